/* key_check: check of all section and key names of a scene before anything is read, so that a misspelt key is reported
 * as such and not as a missing one. */
#ifndef PD_KEY_CHECK_H
#define PD_KEY_CHECK_H
#include "scene/text.h"

#ifdef PDI_APP_INTERNAL
/* Check that each section and each key is in the table of keys. PD_ERR_PARSE or PD_ERR_ARGUMENT with file:line and the
 * nearest known name. Whether a key has an effect in this scene is checked later by pdi_text_check_unused. */
PDI_FN pd_status pdi_key_check_all(pd_ctx *ctx, const pd_text *text);
#endif

#endif
