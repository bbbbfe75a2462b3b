/* named_files: files that a scene names. */
#ifndef PD_NAMED_FILES_H
#define PD_NAMED_FILES_H
#include "scene/text.h"

#ifdef PDI_INTERNAL
/* path[PD_PATH_SIZE] of the file that stands under `key`: relative to `folder`, which is that of the scene with its '/'
 * at the end. PD_ERR_PARSE: no such key; PD_ERR_ARGUMENT: too long. */
PDI_FN pd_status pdi_named_files_path(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *folder,
                                char *path);
/* Put "file:line: key" before the message of a failed call, whose cause is the value of that key. Returns
 * PD_ERR_ARGUMENT, or the status of the call when it lacked memory. */
PDI_FN pd_status pdi_named_files_fail(pd_ctx *ctx, const pd_text *text, int section, const char *key);
#endif

#endif
