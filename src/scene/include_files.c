/* include_files: see include_files.h */
#include "scene/include_files.h"
#include <stdio.h>
#include <string.h>

#define PDI_INCLUDE_FILES_MAX_DEPTH 8 /* files that include one another */
#define PDI_INCLUDE_FILES_MAX 32      /* of a scene */

/* The files read so far, to find cycles and repetitions. */
typedef struct pdi_include_files_seen {
    char path[PDI_INCLUDE_FILES_MAX][PD_PATH_SIZE];
    int depth[PDI_INCLUDE_FILES_MAX]; /* 0: done */
    int count;
} pdi_include_files_seen;

/* The pair chemistry.include of a text. NULL: it includes no files. */
static const pd_text_entry *pdi_include_files_find_entry(const pd_text *text)
{
    for (int k = 0; k < text->entry_count; k++)
        if (strcmp(text->section[text->entry[k].section].name, "chemistry") == 0 &&
            strcmp(text->entry[k].key, "include") == 0)
            return &text->entry[k];
    return NULL;
}

/* Merge one pair of the included file `file`, a name that text owns, into a section of text; strings are copied. depth:
 * nesting depth of the file. A pair of a smaller depth stays, one of a larger depth is replaced. PD_ERR_PARSE: a file
 * of the same depth has the pair. */
static pd_status pdi_include_files_merge_entry(pd_ctx *ctx, pd_text *text, int section, const pd_text_entry *e,
                                               char *file, int depth)
{
    char *key, *value;
    pd_text_entry *old = pdi_text_find_entry(text, section, e->key);
    const pd_section *s = &text->section[section];
    if (old && old->depth == depth)
        return pdi_text_fail_line(ctx, file, e->line,
                                  "found '%.40s' of [%.40s %.40s], which %.200s:%d has, too: expected "
                                  "it in one of them, or in the file that includes both",
                                  e->key, s->name, s->label, old->file, old->line);
    if (old && old->depth < depth) return PD_OK;
    PD_TRY(pdi_text_copy_string(ctx, text, e->value, strlen(e->value), &value));
    if (!old) {
        PD_TRY(pdi_text_copy_string(ctx, text, e->key, strlen(e->key), &key));
        PD_TRY(pdi_text_add_entry(ctx, text, section, key, value, e->line, e->column));
        old = &text->entry[text->entry_count - 1];
    }
    old->value = value;
    old->line = e->line;
    old->column = e->column;
    old->file = file;
    old->depth = depth;
    return PD_OK;
}

/* Merge all sections and pairs of the included file `from` into text, but not its key include. PD_ERR_PARSE: a section
 * that is not of chemistry, or pairs before the first one. */
static pd_status pdi_include_files_merge_text(pd_ctx *ctx, pd_text *text, const pd_text *from, int depth)
{
    static const char *const allowed[] = {"chemistry", "species", "reaction", "mineral"};
    char *file;
    PD_TRY(pdi_text_copy_string(ctx, text, from->name, strlen(from->name), &file));
    for (int k = 0; k < from->section_count; k++) {
        const pd_section *s = &from->section[k];
        int fits = 0, section;
        if (!s->is_present) continue;
        for (size_t a = 0; a < sizeof allowed / sizeof allowed[0]; a++) fits |= strcmp(s->name, allowed[a]) == 0;
        if (!fits)
            return pdi_text_fail_line(ctx, from->name, s->line > 0 ? s->line : 1,
                                      "found %s%.40s%s in a file that is "
                                      "included, expected [chemistry], [species ...], [reaction ...] and [mineral ...] "
                                      "alone",
                                      k ? "[" : "pairs before a section", s->name, k ? "]" : "");
        PD_TRY(pdi_text_find_or_add_section(ctx, text, s->name, s->label, &section));
        if (!text->section[section].is_present) {
            text->section[section].line = s->line;
            text->section[section].file = file;
            text->section[section].is_present = 1;
        }
        for (int e = 0; e < from->entry_count; e++)
            if (from->entry[e].section == k && strcmp(from->entry[e].key, "include") != 0)
                PD_TRY(pdi_include_files_merge_entry(ctx, text, section, &from->entry[e], file, depth));
    }
    return PD_OK;
}

static pd_status pdi_include_files_read_list(pd_ctx *ctx, pd_text *text, const pd_text *from, int depth,
                                             pdi_include_files_seen *files);

/* Read one file name[size] of the include list `e` of `from`, relative to its folder, merge it, and follow its own
 * list. A file already read, by its path as written, is skipped. PD_ERR_PARSE: it is missing or includes itself, the
 * path is too long, nesting is deeper than PDI_INCLUDE_FILES_MAX_DEPTH, or PDI_INCLUDE_FILES_MAX were read. */
static pd_status pdi_include_files_read_file(pd_ctx *ctx, pd_text *text, const pd_text *from, const pd_text_entry *e,
                                             const char *name, size_t size, int depth, pdi_include_files_seen *files)
{
    char message[PD_MESSAGE_SIZE], *path;
    pd_text own;
    size_t above = strlen(from->name);
    while (above > 0 && from->name[above - 1] != '/' && from->name[above - 1] != '\\') above--;
    if (files->count == PDI_INCLUDE_FILES_MAX || depth > PDI_INCLUDE_FILES_MAX_DEPTH || above + size >= PD_PATH_SIZE)
        return pdi_text_fail_line(ctx, e->file, e->line,
                                  "include: found '%.*s', expected at most %d files, %d of which "
                                  "include one another, and a shorter path",
                                  (int)(size < 80 ? size : 80), name, PDI_INCLUDE_FILES_MAX,
                                  PDI_INCLUDE_FILES_MAX_DEPTH);
    path = files->path[files->count];
    memcpy(path, name, size);
    path[size] = '\0';
    if (pdi_file_is_absolute(path)) above = 0;
    memcpy(path, from->name, above);
    memcpy(path + above, name, size);
    path[above + size] = '\0';
    int number = 0;
    while (strcmp(files->path[number], path) != 0) number++;
    if (number < files->count && files->depth[number])
        return pdi_text_fail_line(ctx, e->file, e->line, "include: found '%.200s', which includes this file", path);
    if (number < files->count) return PD_OK;
    files->depth[files->count++] = depth;
    pd_status status = pdi_text_read(ctx, path, &own);
    if (status == PD_ERR_FILE) {
        memcpy(message, ctx->message, sizeof message);
        return pdi_text_fail_line(ctx, e->file, e->line, "include: %.500s", message);
    }
    if (status < 0) return status;
    status = pdi_include_files_merge_text(ctx, text, &own, depth);
    if (status == PD_OK) status = pdi_include_files_read_list(ctx, text, &own, depth + 1, files);
    pdi_text_free(ctx, &own);
    files->depth[number] = 0;
    return status;
}

/* Read all files of the include list of `from`, if it has one, and merge them into text, which may be `from`. depth:
 * nesting depth of these files, 1 for those of the scene. */
static pd_status pdi_include_files_read_list(pd_ctx *ctx, pd_text *text, const pd_text *from, int depth,
                                             pdi_include_files_seen *files)
{
    const pd_text_entry *found = pdi_include_files_find_entry(from), *e = found;
    pd_text_entry kept;
    if (!found) return PD_OK;
    if (from == text) { /* its table moves as it grows */
        kept = *found;
        e = &kept;
    }
    for (const char *at = e->value; *at; at += strspn(at, ", \t")) {
        size_t size = strcspn(at, ","), end = size;
        while (end > 0 && pd_units_is_blank(at[end - 1])) end--;
        if (end) PD_TRY(pdi_include_files_read_file(ctx, text, from, e, at, end, depth, files));
        at += size;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_include_files_read(pd_ctx *ctx, pd_text *text)
{
    pdi_include_files_seen *files = NULL;
    if (!pdi_include_files_find_entry(text)) return PD_OK;
    PD_TRY(PD_NEW(ctx, "include", 1, files));
    pd_status status = pdi_include_files_read_list(ctx, text, text, 1, files);
    PD_DELETE(ctx, 1, files);
    return status;
}
