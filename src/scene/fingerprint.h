/* fingerprint: what makes a scene this one and no other: its name, sections and pairs with overrides, masks; not the
 * number of threads, nor the folder of the output. A checkpoint keeps it, and is refused by another scene.
 */
#ifndef PD_FINGERPRINT_H
#define PD_FINGERPRINT_H
#include "scene/text.h"
#include "scene/setup.h"

#ifdef PDI_INTERNAL
/* setup->fingerprint, from the text of a scene that has been read. */
PDI_FN pd_status pdi_fingerprint_build(pd_ctx *ctx, const pd_text *text, pd_setup *setup);
/* One more line, without newline. */
PDI_FN pd_status pdi_fingerprint_add(pd_ctx *ctx, pd_setup *setup, const char *line);
/* PD_OK, or PD_ERR_ARGUMENT with the first line in which `kept` differs from that of the setup. where: of the message.
 * Both may be NULL: not from a file. */
PDI_FN pd_status pdi_fingerprint_compare(pd_ctx *ctx, const pd_setup *setup, const char *kept, const char *where);
#endif

#endif
