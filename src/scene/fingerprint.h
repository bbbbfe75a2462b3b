/* fingerprint: normalised text of all input that affects results: name, sections, pairs after overrides, checksums of
 * masks and surfaces; not the number of threads or the output folder. A checkpoint stores it, so that a run of another
 * scene refuses the checkpoint.
 */
#ifndef PD_FINGERPRINT_H
#define PD_FINGERPRINT_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Append the lines of a text that was read, and checksums of the masks and surfaces of the setup, to
 * setup->fingerprint. */
PDI_FN pd_status pdi_fingerprint_build(pd_ctx *ctx, const pd_text *text, pd_setup *setup);
/* Append one line, given without newline, to setup->fingerprint. */
PDI_FN pd_status pdi_fingerprint_add_line(pd_ctx *ctx, pd_setup *setup, const char *line);
/* Compare the fingerprint of the setup with the stored one, `kept`. PD_ERR_ARGUMENT: they differ; the message, which
 * starts with `where`, has the first difference. Either may be NULL: input that is no file. */
PDI_FN pd_status pdi_fingerprint_check(pd_ctx *ctx, const pd_setup *setup, const char *kept, const char *where);
#endif

#endif
