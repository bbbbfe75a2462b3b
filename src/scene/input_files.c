/* input_files: see input_files.h */
#include "scene/input_files.h"
#include "io/file.h"
#include <stdio.h>
#include <string.h>

PDI_FN pd_status pdi_input_files_get_path(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *folder,
                                          char *path)
{
    const char *name;
    PD_TRY(pdi_text_get_string(ctx, text, section, key, NULL, &name));
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
    return ctx->status = pd_is_fatal(status) ? status : refused;
}

PDI_FN pd_status pdi_input_files_read_output_folder(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                                    pd_setup *setup)
{
    const char *folder;
    char own[PD_SETUP_NAME + 16];
    snprintf(own, sizeof own, "output/%s", setup->name); /* a folder holds one run */
    PD_TRY(pdi_text_get_string(ctx, text, section, key, pdi_file_is_subpath(own) ? own : "output", &folder));
    if (strlen(folder) >= PD_PATH_SIZE - PD_SETUP_NAME)
        return pdi_text_fail_key(ctx, text, section, key, "the path is too long");
    if (!pdi_file_is_subpath(folder))
        return pdi_text_fail_key(ctx, text, section, key,
                                 "found '%.200s', expected a folder below the current one,"
                                 " without '..': only who starts the run may choose another",
                                 folder);
    memcpy(setup->folder, folder, strlen(folder) + 1);
    return PD_OK;
}

PDI_FN void pdi_input_files_split_path(const char *path, char *name, char *folder)
{
    const char *base = path, *end = NULL;
    for (const char *c = path; *c; c++)
        if (*c == '/' || *c == '\\') base = c + 1;
    for (const char *c = base; *c; c++)
        if (*c == '.' && c > base) end = c;
    size_t length = end ? (size_t)(end - base) : strlen(base), above = (size_t)(base - path);
    if (length > PD_SETUP_NAME - 1) length = PD_SETUP_NAME - 1;
    memcpy(name, base, length);
    name[length] = '\0';
    /* the name becomes one word of a result line */
    for (char *c = name; *c; c++)
        if (*c == ' ' || *c == '=' || *c == '\t') *c = '_';
    if (!folder) return;
    if (above > PD_PATH_SIZE - 1) above = 0;
    memcpy(folder, path, above);
    folder[above] = '\0';
}
