/* override: command-line arguments key=value that replace or add pairs of a scene. */
#ifndef PD_OVERRIDE_H
#define PD_OVERRIDE_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* Apply one command-line argument `key=value`, `section.key=value` or `section.label.key=value` to the text. A bare key
 * must be in exactly one section, in a flat file it may be new; a labelled section must exist; `section.key` may be
 * new, and a misspelt one is reported by later checks. The pair then has line 0. PD_ERR_PARSE: also an empty value, or
 * control bytes. */
PDI_FN pd_status pdi_override_apply(pd_ctx *ctx, pd_text *text, const char *argument);
#endif

#endif
