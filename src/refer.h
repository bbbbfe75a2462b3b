/* refer: files that a scene names. */
#ifndef PD_REFER_H
#define PD_REFER_H
#include "text.h"

#ifdef PDI_INTERNAL
/* path[PD_PATH_SIZE] of the file that stands under `key`: relative to `folder`, which is that of the scene with its '/'
 * at the end. PD_ERR_PARSE: no such key; PD_ERR_ARGUMENT: too long. */
PDI_FN pd_status pdi_refer_path(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *folder,
                                char *path);
/* The file cannot be used, as the last message says: the same with the line that names it. PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_refer_fail(pd_ctx *ctx, const pd_text *text, int section, const char *key);
#endif

#endif
