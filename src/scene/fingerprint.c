/* fingerprint: see fingerprint.h */
#include "scene/fingerprint.h"
#include "io/zlib.h"
#include <stdio.h>
#include <string.h>

#define PDI_FINGERPRINT_VALUE_SIZE 512 /* [byte] longer values are replaced by their checksum */

PDI_FN pd_status pdi_fingerprint_add_line(pd_ctx *ctx, pd_setup *u, const char *line)
{
    size_t length = strlen(line), at = u->fingerprint_size ? u->fingerprint_size - 1 : 0, fresh = at + length + 2;
    PD_TRY(PD_GROW(ctx, "fingerprint", u->fingerprint_size, fresh, u->fingerprint));
    memcpy(u->fingerprint + at, line, length);
    u->fingerprint[at + length] = '\n';
    u->fingerprint[at + length + 1] = '\0';
    u->fingerprint_size = fresh;
    return PD_OK;
}

/* Value into text[size], with each run of blanks as one blank and none at the start; one that does not fit is replaced
 * by its first 60 bytes, its length and its CRC-32. */
static void pdi_fingerprint_format_value(const char *value, char *text, size_t size)
{
    size_t used = 0;
    for (const char *c = value; *c; c++) {
        if (used + 2 > size) {
            size_t length = strlen(value);
            snprintf(text, size, "%.60s... (%.0f bytes, %08x)", value, (double)length,
                     (unsigned)pdi_zlib_crc32(0, (const uint8_t *)value, length));
            return;
        }
        int blank = pd_units_is_blank(*c);
        if (!blank || (used && text[used - 1] != ' ')) text[used++] = blank ? ' ' : *c;
    }
    text[used] = '\0';
}

/* 1: a pair that changes no result (threads, output folder) and is left out. */
static int pdi_fingerprint_is_ignored(const pd_text *text, const pd_text_entry *e)
{
    const char *section = text->section[e->section].name;
    return (strcmp(section, "grid") == 0 && strcmp(e->key, "threads") == 0) ||
           (strcmp(section, "output") == 0 && strcmp(e->key, "folder") == 0) ||
           (text->is_flat && strcmp(e->key, "output_dir") == 0);
}

PDI_FN pd_status pdi_fingerprint_build(pd_ctx *ctx, const pd_text *text, pd_setup *u)
{
    char line[2 * PDI_FINGERPRINT_VALUE_SIZE], value[PDI_FINGERPRINT_VALUE_SIZE];
    snprintf(line, sizeof line, "name = %s", u->name);
    PD_TRY(pdi_fingerprint_add_line(ctx, u, line));
    for (int k = 1; k < text->section_count; k++) {
        const pd_section *s = &text->section[k];
        if (!s->is_present) continue;
        snprintf(line, sizeof line, "[%.200s%s%.200s]", s->name, s->label[0] ? " " : "", s->label);
        PD_TRY(pdi_fingerprint_add_line(ctx, u, line));
    }
    for (int k = 0; k < text->entry_count; k++) {
        const pd_text_entry *e = &text->entry[k];
        const pd_section *s = &text->section[e->section];
        if (pdi_fingerprint_is_ignored(text, e)) continue;
        pdi_fingerprint_format_value(e->value, value, sizeof value);
        snprintf(line, sizeof line, "%.100s%s%.100s%s%.100s = %s", s->name, s->label[0] ? "." : "", s->label,
                 s->name[0] ? "." : "", e->key, value);
        PD_TRY(pdi_fingerprint_add_line(ctx, u, line));
    }
    for (int k = 0; k < u->masks; k++) {
        snprintf(line, sizeof line, "mask %d = %.0f voxels, %08x", k, (double)u->mask_size[k],
                 (unsigned)pdi_zlib_crc32(0, u->mask[k], u->mask_size[k]));
        PD_TRY(pdi_fingerprint_add_line(ctx, u, line));
    }
    for (int k = 0; k < u->facets_count; k++) {
        const pd_facets *f = u->facets[k];
        snprintf(line, sizeof line, "surface %d = %d triangles, %08x", k, (int)f->count,
                 (unsigned)pdi_zlib_crc32(0, (const uint8_t *)f->corner, (size_t)f->count * 9 * sizeof *f->corner));
        PD_TRY(pdi_fingerprint_add_line(ctx, u, line));
    }
    /* that of a flat file depends on what it said before overrides */
    snprintf(line, sizeof line, "scale of the rate = %.17g", u->metal[0].rate_scale);
    return text->is_flat ? pdi_fingerprint_add_line(ctx, u, line) : PD_OK;
}

/* Length of the first line of text, without newline. */
static size_t pdi_fingerprint_line_length(const char *text) { return strcspn(text, "\n"); }

/* Find the line of text that starts with line[length]; whole 1: and equals it. NULL: there is none. */
static const char *pdi_fingerprint_find_line(const char *text, const char *line, size_t length, int whole)
{
    for (; *text; text += pdi_fingerprint_line_length(text) + 1)
        if (strncmp(text, line, length) == 0 && (!whole || text[length] == '\n')) return text;
    return NULL;
}

/* First line of text that `other` lacks. NULL: none. */
static const char *pdi_fingerprint_find_missing_line(const char *text, const char *other)
{
    for (; *text; text += pdi_fingerprint_line_length(text) + 1)
        if (!pdi_fingerprint_find_line(other, text, pdi_fingerprint_line_length(text), 1)) return text;
    return NULL;
}

PDI_FN pd_status pdi_fingerprint_check(pd_ctx *ctx, const pd_setup *u, const char *kept, const char *where)
{
    const char *is = u->fingerprint ? u->fingerprint : "", *was = kept ? kept : "";
    if (strcmp(is, was) == 0) return PD_OK;
    const char *old = pdi_fingerprint_find_missing_line(was, is), *fresh = pdi_fingerprint_find_missing_line(is, was);
    if (old && strcspn(old, "=") < pdi_fingerprint_line_length(old)) { /* the same key with another value says more */
        const char *same = pdi_fingerprint_find_line(is, old, strcspn(old, "=") + 1, 0);
        if (same) fresh = same;
        else fresh = NULL;
    }
    if (old && fresh)
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "it is of another scene: found '%.*s', expected '%.*s'",
                       (int)(pdi_fingerprint_line_length(old) < 200 ? pdi_fingerprint_line_length(old) : 200), old,
                       (int)(pdi_fingerprint_line_length(fresh) < 200 ? pdi_fingerprint_line_length(fresh) : 200),
                       fresh);
    if (old || fresh) {
        const char *line = old ? old : fresh;
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "it is of another scene: found %s'%.*s', expected %s",
                       old ? "" : "no ",
                       (int)(pdi_fingerprint_line_length(line) < 200 ? pdi_fingerprint_line_length(line) : 200), line,
                       old ? "none" : "one");
    }
    return pd_fail(ctx, PD_ERR_ARGUMENT, where, "it is of a scene with the same pairs in another order");
}

#undef PDI_FINGERPRINT_VALUE_SIZE
