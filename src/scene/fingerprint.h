/* fingerprint: normalised text of all input that affects results: name, sections, pairs after overrides, checksums of
 * masks and surfaces; not the number of threads or the output folder. A checkpoint stores it, so that a run of another
 * scene refuses the checkpoint.
 */
#ifndef PD_FINGERPRINT_H
#define PD_FINGERPRINT_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Append to setup->fingerprint, a line each: the name of the setup, sections that are present, pairs in the order of
 * the text (not threads and output folder), checksums of masks and surfaces, and of a flat file the scale of the rate.
 * Lines that are there stay. pd_setup_free frees it. */
PDI_FN pd_status pdi_fingerprint_build(pd_ctx *ctx, const pd_text *text, pd_setup *setup);
/* Append one line, given without newline, to setup->fingerprint, which grows. On failure (out of memory) it is
 * unchanged. */
PDI_FN pd_status pdi_fingerprint_add_line(pd_ctx *ctx, pd_setup *setup, const char *line);
/* Compare the fingerprint of the setup with the stored one, `kept`. PD_ERR_ARGUMENT: they differ, if only in the order
 * of lines; the message, which starts with `where`, has the first stored line that the setup lacks, with its line of
 * the same key. Either may be NULL and counts as empty: input that is no file. */
PDI_FN pd_status pdi_fingerprint_check(pd_ctx *ctx, const pd_setup *setup, const char *kept, const char *where);
#endif

#endif
