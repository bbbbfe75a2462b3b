/* input_files: see input_files.h */
#include "scene/input_files.h"
#include <string.h>

PDI_FN pd_status pdi_input_files_get_path(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *folder,
                                          char *path)
{
    const char *name;
    PDI_TRY(pdi_text_get_string(ctx, text, section, key, NULL, &name));
    size_t above = pdi_file_is_absolute(name) ? 0 : strlen(folder), size = strlen(name) + 1;
    if (above + size > PD_PATH_SIZE) return pdi_text_fail_key(ctx, text, section, key, "the path is too long");
    memcpy(path, folder, above + 1);
    memcpy(path + above, name, size);
    return PD_OK;
}

PDI_FN pd_status pdi_input_files_fail(pd_ctx *ctx, const pd_text *text, int section, const char *key)
{
    char message[PD_MESSAGE_SIZE];
    pd_status status = ctx->status, refused;
    memcpy(message, ctx->message, sizeof message);
    refused = pdi_text_fail_key(ctx, text, section, key, "%.500s", message);
    return ctx->status = pdi_is_fatal(status) ? status : refused;
}
