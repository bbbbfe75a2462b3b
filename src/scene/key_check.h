/* key_check: check of all section and key names of a scene before anything is read, so that a misspelt key is reported
 * as such and not as a missing one. */
#ifndef PD_KEY_CHECK_H
#define PD_KEY_CHECK_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* Check that each section and each key of a section is in the table of keys or of a registered physics.
 * PD_ERR_ARGUMENT: unknown section, PD_ERR_PARSE: unknown key, with file:line, the known names and the nearest one.
 * Sections are checked first; pairs before the first section are not. Whether a key has an effect in this scene is
 * checked later by pdi_text_check_unused. */
PDI_FN pd_status pdi_key_check_all(pd_ctx *ctx, const pd_text *text);
#endif

#endif
