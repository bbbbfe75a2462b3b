/* syntax: the sections of a scene and their keys, checked before anything is read: a misspelt key is reported as such
 * and not by what is missing without it. */
#ifndef PD_SYNTAX_H
#define PD_SYNTAX_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
/* PD_ERR_PARSE or PD_ERR_ARGUMENT with file:line: a section or a key that no scene has, and the nearest that one has.
 * Whether a key has an effect in this scene is left to pdi_text_unused. */
PDI_FN pd_status pdi_syntax_check(pd_ctx *ctx, const pd_text *text);
#endif

#endif
