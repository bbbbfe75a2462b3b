/* override: pairs of the command line in the place of those of a scene. */
#ifndef PD_OVERRIDE_H
#define PD_OVERRIDE_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
/* Apply a command-line argument `key=value`, `section.key=value` or `section.label.key=value`. A bare key must stand
 * in exactly one section; a labelled section must exist; `section.key` may be new, and a misspelt one then fails in
 * pdi_text_unused. PD_ERR_PARSE. */
PDI_FN pd_status pdi_override_apply(pd_ctx *ctx, pd_text *text, const char *argument);
#endif

#endif
