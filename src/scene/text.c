/* text: see text.h. The parser works in place on a copy of the file: null bytes overwrite the separators. */
#include "scene/text.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define PDI_TEXT_LOCATION_SIZE 320 /* [byte] of "file:line" */

/* ---- strings and tables ---- */

/* Grow a table by doubling when it has no capacity for one more element. */
#define PDI_TEXT_GROW(ctx, table, count, room) \
    do { \
        if ((count) == (room)) { \
            int pdi_text_capacity = (room) > 0 ? 2 * (room) : 16; \
            PD_TRY(PD_GROW(ctx, "text", (room), pdi_text_capacity, table)); \
            (room) = pdi_text_capacity; \
        } \
    } while (0)

PDI_FN pd_status pdi_text_copy_string(pd_ctx *ctx, pd_text *text, const char *bytes, size_t size, char **copy)
{
    PDI_TEXT_GROW(ctx, text->block, text->block_count, text->block_capacity);
    pd_text_memory *block = &text->block[text->block_count];
    PD_TRY(PD_NEW(ctx, "text", size + 1, block->bytes));
    block->size = size + 1;
    text->block_count++;
    if (size > 0) memcpy(block->bytes, bytes, size);
    *copy = block->bytes;
    return PD_OK;
}

/* Location for messages into where[PDI_TEXT_LOCATION_SIZE]: "file:12", or "command line" for line 0. */
static void pdi_text_format_location(const char *file, int line, char *where)
{
    if (line > 0) snprintf(where, PDI_TEXT_LOCATION_SIZE, "%.280s:%d", file, line);
    else snprintf(where, PDI_TEXT_LOCATION_SIZE, "command line");
}

PDI_FN pd_status pdi_text_fail_line(pd_ctx *ctx, const char *file, int line, const char *format, ...)
{
    char where[PDI_TEXT_LOCATION_SIZE], message[PD_MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    pdi_text_format_location(file, line, where);
    return pd_fail(ctx, PD_ERR_PARSE, where, "%s", message);
}

/* Section header for messages into title[PD_UNITS_TEXT]: "[side x-]", or words for the lines before the first
 * section. */
static void pdi_text_format_section(const pd_text *text, int section, char *title)
{
    const pd_section *s = &text->section[section];
    if (section == 0) snprintf(title, PD_UNITS_TEXT, text->is_flat ? "the file" : "the lines before the first section");
    else snprintf(title, PD_UNITS_TEXT, "[%.40s%s%.40s]", s->name, s->label[0] ? " " : "", s->label);
}

PDI_FN void pdi_text_add_to_list(char *list, const char *separator, const char *name)
{
    size_t used = strlen(list);
    if (used + strlen(name) + strlen(separator) + 5 > PDI_TEXT_LIST_SIZE) {
        if (used > 3 && strcmp(list + used - 3, "...") != 0) snprintf(list + used, PDI_TEXT_LIST_SIZE - used, " ...");
        return;
    }
    snprintf(list + used, PDI_TEXT_LIST_SIZE - used, "%s%s", used > 0 ? separator : "", name);
}

/* Record that the text has a former name; index -1: it is none. */
static void pdi_text_mark_renamed(pd_text *text, int index)
{
    if (index >= 0) text->has_renamed[index] = 1;
}

PDI_FN const char *pdi_text_get_present_section(pd_text *text, const char *name)
{
    pdi_text_mark_renamed(text, pdi_renamed_keys_find(name, NULL, NULL));
    return pdi_renamed_keys_get_section(name);
}

PDI_FN const char *pdi_text_get_present_key(pd_text *text, int section, const char *key)
{
    const char *name = text->section[section].name;
    pdi_text_mark_renamed(text, pdi_renamed_keys_find(name, key, NULL));
    return pdi_renamed_keys_get_key(name, key);
}

PDI_FN void pdi_text_set_value(pd_text *text, pd_text_entry *entry, const char *value)
{
    const char *name = text->section[entry->section].name;
    pdi_text_mark_renamed(text, pdi_renamed_keys_find(name, entry->key, value));
    entry->value = pdi_renamed_keys_get_value(name, entry->key, value);
}

PDI_FN pd_status pdi_text_find_or_add_section(pd_ctx *ctx, pd_text *text, const char *name, const char *label,
                                              int *index)
{
    int group = text->section_count;
    char *kept_name, *kept_label;
    name = pdi_text_get_present_section(text, name);
    for (int k = text->section_count - 1; k >= 0; k--) {
        if (strcmp(text->section[k].name, name) != 0) continue;
        group = text->section[k].group_first;
        if (strcmp(text->section[k].label, label) != 0) continue;
        *index = k;
        return PD_OK;
    }
    PDI_TEXT_GROW(ctx, text->section, text->section_count, text->section_capacity);
    PD_TRY(pdi_text_copy_string(ctx, text, name, strlen(name), &kept_name));
    PD_TRY(pdi_text_copy_string(ctx, text, label, strlen(label), &kept_label));
    pd_section *s = &text->section[text->section_count];
    s->name = kept_name;
    s->label = kept_label;
    s->file = text->name ? text->name : "";
    s->group_first = group;
    *index = text->section_count++;
    return PD_OK;
}

PDI_FN pd_text_entry *pdi_text_find_entry(const pd_text *text, int section, const char *key)
{
    key = pdi_renamed_keys_get_key(text->section[section].name, key);
    for (int k = 0; k < text->entry_count; k++)
        if (text->entry[k].section == section && strcmp(text->entry[k].key, key) == 0) return &text->entry[k];
    return NULL;
}

PDI_FN pd_status pdi_text_add_entry(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *value,
                                    int line, int column)
{
    const pd_text_entry *old = pdi_text_find_entry(text, section, key);
    char title[PD_UNITS_TEXT];
    pdi_text_format_section(text, section, title);
    if (old)
        return pdi_text_fail_line(ctx, text->name, line,
                                  "found '%.40s' a second time in %s, first on line %d; expected it once", key, title,
                                  old->line);
    if (text->entry_count >= PD_TEXT_ENTRIES)
        return pdi_text_fail_line(ctx, text->name, line, "found more than %d pairs, expected fewer", PD_TEXT_ENTRIES);
    PDI_TEXT_GROW(ctx, text->entry, text->entry_count, text->entry_capacity);
    pd_text_entry *e = &text->entry[text->entry_count++];
    e->key = pdi_text_get_present_key(text, section, key);
    e->section = section;
    pdi_text_set_value(text, e, value);
    e->file = text->name;
    e->line = line;
    e->column = column;
    text->section[section].is_present = 1;
    return PD_OK;
}

/* ---- reading the file ---- */

PDI_FN size_t pdi_text_skip_blanks(const char *t, size_t at)
{
    while (pd_units_is_blank(t[at])) at++;
    return at;
}

PDI_FN pdi_text_charset pdi_text_get_label_charset(const char *section)
{
    const pd_key_section *table = pdi_keys_find_section(section);
    return table && strcmp(table->label, "FORMULA") == 0 ? PDI_TEXT_CHARSET_FORMULA : PDI_TEXT_CHARSET_LABEL;
}

PDI_FN size_t pdi_text_scan_word(const char *t, pdi_text_charset kind)
{
    size_t n = 0;
    while ((unsigned char)t[n] < 0x80 &&
           ((t[n] >= 'a' && t[n] <= 'z') || (t[n] >= 'A' && t[n] <= 'Z') || t[n] == '_' ||
            (pd_units_is_digit(t[n]) && (n > 0 || kind)) || (kind && (t[n] == '+' || t[n] == '-')) ||
            (kind == PDI_TEXT_CHARSET_FORMULA && n > 0 && (t[n] == '(' || t[n] == ')' || t[n] == '^' || t[n] == ':'))))
        n++;
    return n;
}

/* Length of the key at t if `identifier =` starts there, else 0; *value: offset of the value behind the '=', unchanged
 * if 0. */
static size_t pdi_text_scan_key(const char *t, size_t *value)
{
    size_t n = pdi_text_scan_word(t, PDI_TEXT_CHARSET_KEY), equal = pdi_text_skip_blanks(t, n);
    if (n == 0 || t[equal] != '=' || t[equal + 1] == '=') return 0;
    *value = equal + 1;
    return n;
}

PDI_FN pd_status pdi_text_fail_expected(pd_ctx *ctx, const pd_text *text, int line, const char *t, size_t at,
                                        const char *expected)
{
    char found[PD_UNITS_TEXT];
    pd_expr_quote_token(t + at, found);
    return pdi_text_fail_line(ctx, text->name, line, "column %d: found %s, expected %s", (int)at + 1, found, expected);
}

/* Parse the section line "[name label]" whose '[' is t[*at]; null bytes in t end its words. The text is flat no longer.
 * *section: the section that it opens, one that exists or a new one, which then is present; *at: index behind the ']'.
 * PD_ERR_PARSE: no name, no ']', or PD_TEXT_ENTRIES sections. */
static pd_status pdi_text_parse_section(pd_ctx *ctx, pd_text *text, char *t, int line, size_t *at, int *section)
{
    size_t name = pdi_text_skip_blanks(t, *at + 1), name_size = pdi_text_scan_word(t + name, PDI_TEXT_CHARSET_KEY);
    size_t label, label_size, close;
    char kept[PD_TEXT_WORD] = "";
    if (name_size == 0) return pdi_text_fail_expected(ctx, text, line, t, name, "the name of a section");
    label = pdi_text_skip_blanks(t, name + name_size);
    if (name_size < sizeof kept) memcpy(kept, t + name, name_size);
    label_size = label > name + name_size ? pdi_text_scan_word(t + label, pdi_text_get_label_charset(kept)) : 0;
    close = pdi_text_skip_blanks(t, label + label_size);
    if (t[close] != ']') return pdi_text_fail_expected(ctx, text, line, t, close, "']' after [name or [name label");
    if (text->section_count >= PD_TEXT_ENTRIES)
        return pdi_text_fail_line(ctx, text->name, line, "found more than %d sections, expected fewer",
                                  PD_TEXT_ENTRIES);
    t[close] = t[label + label_size] = t[name + name_size] = '\0';
    PD_TRY(pdi_text_find_or_add_section(ctx, text, t + name, label_size > 0 ? t + label : "", section));
    if (text->section[*section].line == 0) text->section[*section].line = line;
    text->section[*section].is_present = 1;
    text->is_flat = 0;
    *at = close + 1;
    return PD_OK;
}

/* Key under which the free text of a section is stored (first key of unit "text"); NULL: the section has no free
 * text. */
static const char *pdi_text_get_free_text_key(const pd_text *text, int section)
{
    const pd_key_section *table = pdi_keys_find_section(text->section[section].name);
    return table && strcmp(table->key[0].unit, "text") == 0 ? table->key[0].keys : NULL;
}

/* Look up the key of `size` bytes at t in the key table of its section; NULL: the table has no such key. */
static const pd_key *pdi_text_find_listed_key(const pd_text *text, int section, const char *t, size_t size)
{
    const pd_key_section *table = pdi_keys_find_section(text->section[section].name);
    char key[PD_TEXT_WORD];
    if (!table || size >= sizeof key) return NULL;
    memcpy(key, t, size);
    key[size] = '\0';
    return pdi_keys_find_key(table, pdi_renamed_keys_get_key(table->name, key));
}

/* Length of the key at t, 0: none; *value as of pdi_text_scan_key. In a section with free text, and inside such a value
 * (within = 1), only the keys of its table count. */
static size_t pdi_text_scan_section_key(const pd_text *text, int section, const char *t, int within, size_t *value)
{
    size_t size = pdi_text_scan_key(t, value);
    if (size == 0 || size >= PD_TEXT_WORD || !(within || pdi_text_get_free_text_key(text, section))) return size;
    return pdi_text_find_listed_key(text, section, t, size) ? size : 0;
}

/* Number of bytes from the '[' at t[at] to the ']' of a species [FORMULA] inside the value that starts at t[start]; 0:
 * no species, since neither an operator, an opening parenthesis, a comma nor the start of the value precedes it, or its
 * formula is malformed. */
static size_t pdi_text_scan_species(const char *t, size_t start, size_t at)
{
    size_t size = pdi_text_scan_word(t + at + 1, PDI_TEXT_CHARSET_FORMULA), before = at;
    while (before > start && pd_units_is_blank(t[before - 1])) before--;
    if (before > start && !strchr("+-*/^(,<>=", t[before - 1])) return 0;
    return size && t[at + 1 + size] == ']' ? 1 + size : 0;
}

/* Find *end of the value that starts at t[at]: the next key outside parentheses behind a blank or comma
 * (pdi_text_scan_section_key), or the end of the line. PD_ERR_PARSE: unbalanced parentheses, or a bracket that is not
 * of a species [FORMULA]. */
static pd_status pdi_text_find_value_end(pd_ctx *ctx, const pd_text *text, int section, const char *t, int line,
                                         int within, size_t at, size_t *end)
{
    size_t start = at, open = 0, unused;
    int depth = 0;
    for (; t[at] != '\0'; at++) {
        char before = at > start ? t[at - 1] : ' ';
        int apart = depth == 0 && (pd_units_is_blank(before) || before == ',');
        if (apart && pdi_text_scan_section_key(text, section, t + at, within, &unused) > 0) break;
        if (t[at] == '(' && depth++ == 0) open = at;
        if (t[at] == ')' && --depth < 0) return pdi_text_fail_expected(ctx, text, line, t, at, "'(' before it");
        size_t species = t[at] == '[' ? pdi_text_scan_species(t, start, at) : 0;
        if (species) at += species;
        if (t[at] == '[' || (t[at] == ']' && !species))
            return pdi_text_fail_expected(ctx, text, line, t, at, "a value (a section starts on a line of its own)");
    }
    if (depth > 0) return pdi_text_fail_expected(ctx, text, line, t, open, "its ')' on the same line");
    *end = at;
    return PD_OK;
}

/* Parse one line, which null bytes cut into strings: comment from # on, section header, pairs; an empty line adds
 * nothing. *section: the current section, updated by a header. PD_ERR_PARSE: what is no pair in a section without free
 * text, a key without value, or a key that the section has already. */
static pd_status pdi_text_parse_line(pd_ctx *ctx, pd_text *text, char *t, int line, int *section)
{
    char *comment = strchr(t, '#');
    if (comment) *comment = '\0';
    size_t at = pdi_text_skip_blanks(t, 0), value, end;
    if (t[at] == '[') PD_TRY(pdi_text_parse_section(ctx, text, t, line, &at, section));
    at = pdi_text_skip_blanks(t, at);
    while (t[at] != '\0') {
        size_t key = at, size = pdi_text_scan_section_key(text, *section, t + at, 0, &value);
        const char *name = size ? t + key : pdi_text_get_free_text_key(text, *section);
        if (!name)
            return pdi_text_fail_expected(ctx, text, line, t, at,
                                          key == 0 ? "[section] or key = value" : "key = value");
        value = size ? pdi_text_skip_blanks(t, at + value) : at;
        const pd_key *listed = size ? pdi_text_find_listed_key(text, *section, t + key, size) : NULL;
        int within = listed && strcmp(listed->unit, "text") == 0;
        PD_TRY(pdi_text_find_value_end(ctx, text, *section, t, line, within, value, &at));
        for (end = at; end > value && (pd_units_is_blank(t[end - 1]) || t[end - 1] == ',');) end--;
        if (end == value) {
            t[key + size] = '\0';
            return pdi_text_fail_line(ctx, text->name, line,
                                      "column %d: found nothing after '%.40s =', expected a value", (int)value + 1,
                                      t + key);
        }
        /* A value ends at a separator, so nothing of the next key is overwritten. */
        if (size) t[key + size] = '\0';
        t[end] = '\0';
        PD_TRY(pdi_text_add_entry(ctx, text, *section, name, t + value, line, (int)value + 1));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_text_check_bytes(pd_ctx *ctx, const pd_text *text, const char *t, size_t size)
{
    int line = 1;
    for (size_t k = 0; k < size; k++) {
        unsigned char c = (unsigned char)t[k];
        int end = c == '\r' && (k + 1 == size || t[k + 1] == '\n');
        if (c == '\n') line++;
        else if ((c < 0x20 && c != '\t' && !end) || c == 0x7f)
            return pdi_text_fail_line(ctx, text->name, line, "found byte 0x%02x, expected text", (unsigned)c);
    }
    return PD_OK;
}

/* Parse bytes[size] line by line into sections and pairs; section 0 is that of the lines before the first header. A
 * text without headers is flat, and its numbers may lack units. A UTF-8 byte order mark is skipped. PD_ERR_SIZE: more
 * than PD_TEXT_SIZE bytes without it. On failure text is left in part, for pdi_text_free. */
static pd_status pdi_text_parse(pd_ctx *ctx, pd_text *text, const char *name, const char *bytes, size_t size)
{
    char *t, *kept_name;
    int section, line = 0;
    if (size >= 3 && memcmp(bytes, "\xEF\xBB\xBF", 3) == 0) { /* byte order mark */
        bytes += 3;
        size -= 3;
    }
    PD_TRY(pdi_text_copy_string(ctx, text, name, strlen(name), &kept_name));
    text->name = kept_name;
    PD_TRY(pdi_text_find_or_add_section(ctx, text, "", "", &section));
    if (size > PD_TEXT_SIZE)
        return pd_fail(ctx, PD_ERR_SIZE, text->name, "found %.0f bytes, expected at most %d", (double)size,
                       PD_TEXT_SIZE);
    PD_TRY(pdi_text_check_bytes(ctx, text, bytes, size));
    PD_TRY(pdi_text_copy_string(ctx, text, bytes, size, &t));
    text->is_flat = 1;
    while (t) {
        char *end = strchr(t, '\n');
        if (end) *end = '\0';
        PD_TRY(pdi_text_parse_line(ctx, text, t, ++line, &section));
        t = end ? end + 1 : NULL;
    }
    text->allow_bare_numbers = text->is_flat;
    return PD_OK;
}

PDI_FN pd_status pdi_text_build(pd_ctx *ctx, const char *name, const char *bytes, size_t size, pd_text *text)
{
    memset(text, 0, sizeof *text);
    pd_status status = pdi_text_parse(ctx, text, name, bytes, size);
    if (status < 0) pdi_text_free(ctx, text);
    return status;
}

PDI_FN pd_status pdi_text_read(pd_ctx *ctx, const char *path, pd_text *text)
{
    char *data;
    size_t size;
    memset(text, 0, sizeof *text);
    PD_TRY(pdi_file_read_all(ctx, path, PD_TEXT_SIZE, &data, &size));
    pd_status status = pdi_text_build(ctx, path, data, size, text);
    PD_DELETE(ctx, size + 1, data);
    return status;
}

PDI_FN void pdi_text_free(pd_ctx *ctx, pd_text *text)
{
    for (int k = 0; k < text->block_count; k++) PD_DELETE(ctx, text->block[k].size, text->block[k].bytes);
    PD_DELETE(ctx, text->block_capacity, text->block);
    PD_DELETE(ctx, text->section_capacity, text->section);
    PD_DELETE(ctx, text->entry_capacity, text->entry);
    PD_DELETE(ctx, text->asked_capacity, text->asked_key);
    memset(text, 0, sizeof *text);
}

PDI_FN int pdi_text_is_flat(const pd_text *text) { return text->is_flat; }

/* ---- look-up ---- */

PDI_FN int pdi_text_get_section(pd_ctx *ctx, pd_text *text, const char *name, const char *label)
{
    int index = -1;
    pd_status status = pdi_text_find_or_add_section(ctx, text, name, label ? label : "", &index);
    if (status < 0) text->pending_status = status;
    else text->section[text->section[index].group_first].is_looked_up = 1;
    return index;
}

PDI_FN int pdi_text_next_section(pd_ctx *ctx, pd_text *text, const char *name, int after)
{
    if (after < 0 && pdi_text_get_section(ctx, text, name, NULL) < 0) return -1;
    for (int k = after + 1; k < text->section_count; k++)
        if (text->section[k].is_present && strcmp(text->section[k].name, name) == 0) return k;
    return -1;
}

/* Report the pending out-of-memory error of an earlier call that returned no status. */
static pd_status pdi_text_fail_memory(pd_ctx *ctx, const pd_text *text)
{
    return pd_fail(ctx, text->pending_status, text->name, "memory for its keys could not be allocated");
}

/* Record, once, that a reader looked up the key in the sections of this name, for the suggestions of
 * pdi_text_check_unused; they count as looked up. PD_ERR_ARGUMENT: no such section. A pending error (out of memory) is
 * returned first. */
static pd_status pdi_text_mark_asked(pd_ctx *ctx, pd_text *text, int section, const char *key)
{
    char *copy;
    if (text->pending_status) return pdi_text_fail_memory(ctx, text);
    if (section < 0 || section >= text->section_count)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "text", "section %d of %d was asked for '%.40s'", section,
                       text->section_count, key);
    int group = text->section[section].group_first;
    text->section[group].is_looked_up = 1;
    for (int k = 0; k < text->asked_count; k++)
        if (text->asked_key[k].group == group && strcmp(text->asked_key[k].key, key) == 0) return PD_OK;
    PDI_TEXT_GROW(ctx, text->asked_key, text->asked_count, text->asked_capacity);
    PD_TRY(pdi_text_copy_string(ctx, text, key, strlen(key), &copy));
    text->asked_key[text->asked_count].key = copy;
    text->asked_key[text->asked_count++].group = group;
    return PD_OK;
}

PDI_FN int pdi_text_has_key(pd_ctx *ctx, pd_text *text, int section, const char *key)
{
    if (section < 0 || section >= text->section_count) return 0;
    if (!key) return text->section[section].is_present;
    PD_ASSERT(!text->check_keys || pdi_keys_is_consistent(text->section[section].name, key, NULL, NULL));
    pd_status status = pdi_text_mark_asked(ctx, text, section, key);
    if (status < 0) text->pending_status = status;
    return status == PD_OK && pdi_text_find_entry(text, section, key) != NULL;
}

/* A value that was looked up, with its location for messages. */
typedef struct pdi_text_value {
    const char *value;
    int line, column;
    char location[PDI_TEXT_LOCATION_SIZE];
} pdi_text_value;

/* Look up a pair, which then counts as read, or its default; the key counts as asked for. `what` describes the expected
 * value in the message of a missing key. unit: only for the check against the table of keys with PD_DEBUG.
 * PD_ERR_PARSE: neither pair nor default. PD_ERR_ARGUMENT: no such section. */
static pd_status pdi_text_find_value(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                     const char *fallback, const char *what, pdi_text_value *v)
{
    char title[PD_UNITS_TEXT];
    PD_TRY(pdi_text_mark_asked(ctx, text, section, key));
    (void)unit; /* where there are no assertions */
    PD_ASSERT(!text->check_keys || pdi_keys_is_consistent(text->section[section].name, key, unit, fallback));
    pd_text_entry *e = pdi_text_find_entry(text, section, key);
    pdi_text_format_section(text, section, title);
    if (e) {
        e->is_read = 1;
        v->value = e->value;
        v->line = e->line;
        v->column = e->column;
        pdi_text_format_location(e->file, e->line, v->location);
        if (e->line == 0) snprintf(v->location, sizeof v->location, "command line: %.40s", key);
    } else if (fallback) {
        v->value = fallback;
        v->line = v->column = 1;
        snprintf(v->location, sizeof v->location, "default of '%.40s' in %s", key, title);
    } else {
        int line = text->section[section].line > 0 ? text->section[section].line : 1;
        return pdi_text_fail_line(ctx, text->section[section].file, line,
                                  "found no '%.40s' in %s, expected %.40s = %.120s", key, title, key, what);
    }
    return PD_OK;
}

/* Report with column what stands at byte `at` of the value, and what was expected. Returns PD_ERR_PARSE. */
static pd_status pdi_text_fail_value(pd_ctx *ctx, const pdi_text_value *v, size_t at, const char *expected)
{
    char found[PD_UNITS_TEXT];
    pd_expr_quote_token(v->value + at, found);
    return pd_fail(ctx, PD_ERR_PARSE, v->location, "column %d: found %s, expected %s", v->column + (int)at, found,
                   expected);
}

/* Compile bytes [first, end) of the value as an expression in vars[var_count], for pd_expr_free. unit: its dimension,
 * NULL: any. It knows the constants and tables of the text. PD_ERR_PARSE: more than PD_EXPR_LENGTH bytes. On failure
 * there is nothing to free. */
static pd_status pdi_text_compile_expr(pd_ctx *ctx, const pd_text *text, const pdi_text_value *v, size_t first,
                                       size_t end, const char *unit, const pd_expr_symbol *vars, int var_count,
                                       pd_expr *expr)
{
    char item[PD_EXPR_LENGTH + 1];
    pd_expr_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(expr, 0, sizeof *expr);
    if (end - first > PD_EXPR_LENGTH)
        return pd_fail(ctx, PD_ERR_PARSE, v->location,
                       "column %d: found an expression of more than %d characters,"
                       " expected a shorter one",
                       v->column + (int)first, PD_EXPR_LENGTH);
    while (first < end && pd_units_is_blank(v->value[first])) first++;
    memcpy(item, v->value + first, end - first);
    item[end - first] = '\0';
    desc.text = item;
    desc.vars = vars;
    desc.var_count = var_count;
    desc.consts = text->consts;
    desc.const_count = text->const_count;
    desc.tables = text->tables;
    desc.table_count = text->table_count;
    desc.unit = unit;
    desc.allow_bare = text->allow_bare_numbers;
    desc.location = v->location;
    desc.column = v->column + (int)first;
    return pd_expr_build(ctx, &desc, expr);
}

/* Evaluate bytes [first, end) of the value as a constant expression; *value in SI. */
static pd_status pdi_text_eval_constant(pd_ctx *ctx, const pd_text *text, const pdi_text_value *v, size_t first,
                                        size_t end, const char *unit, double *value)
{
    pd_expr expr;
    PD_TRY(pdi_text_compile_expr(ctx, text, v, first, end, unit, NULL, 0, &expr));
    *value = pd_expr_eval(&expr, NULL);
    pd_expr_free(ctx, &expr);
    return PD_OK;
}

/* End of the list item that starts at value[first]: index of a comma outside parentheses, or of the end. */
static size_t pdi_text_find_item_end(const char *value, size_t first)
{
    int depth = 0;
    for (; value[first] != '\0' && (depth > 0 || value[first] != ','); first++)
        depth += (value[first] == '(') - (value[first] == ')');
    return first;
}

/* Describe the dimension of a unit in what[PD_UNITS_TEXT] for the message of a missing key: "a length [m]"; unit NULL:
 * "an expression". */
static void pdi_text_describe_unit(pd_ctx *ctx, const char *unit, char *what)
{
    pd_dims dims;
    if (unit && pd_units_parse(ctx, unit, NULL, &dims) == PD_OK) pd_units_describe(&dims, what);
    else snprintf(what, PD_UNITS_TEXT, "an expression");
}

PDI_FN pd_status pdi_text_get_string(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                     const char **value)
{
    pdi_text_value v;
    PD_TRY(pdi_text_find_value(ctx, text, section, key, NULL, fallback, "a text", &v));
    *value = v.value;
    return PD_OK;
}

PDI_FN pd_status pdi_text_get_number(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                     const char *fallback, double *value)
{
    pdi_text_value v;
    char what[PD_UNITS_TEXT];
    pdi_text_describe_unit(ctx, unit, what);
    PD_TRY(pdi_text_find_value(ctx, text, section, key, unit, fallback, what, &v));
    return pdi_text_eval_constant(ctx, text, &v, 0, strlen(v.value), unit, value);
}

/* Report more than `max` list items, from byte `at` on; axes: a hint on the dimension. Returns PD_ERR_PARSE. */
static pd_status pdi_text_fail_too_many(pd_ctx *ctx, const pdi_text_value *v, size_t at, int max, const char *axes)
{
    char expected[PD_UNITS_TEXT + sizeof PDI_AXES_HINT];
    snprintf(expected, sizeof expected, "the end (at most %d item%s%s)", max, max > 1 ? "s" : "", axes);
    return pdi_text_fail_value(ctx, v, at, expected);
}

PDI_FN pd_status pdi_text_get_numbers(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                      const char *fallback, int max, double *values, int *count)
{
    pdi_text_value v;
    char what[PD_UNITS_TEXT];
    size_t at = 0, end;
    *count = 0;
    pdi_text_describe_unit(ctx, unit, what);
    PD_TRY(pdi_text_find_value(ctx, text, section, key, unit, fallback, what, &v));
    for (;; at = end + 1) {
        end = pdi_text_find_item_end(v.value, at);
        if (*count >= max) return pdi_text_fail_too_many(ctx, &v, at - 1, max, max == PD_DIM ? PDI_AXES_HINT : "");
        PD_TRY(pdi_text_eval_constant(ctx, text, &v, at, end, unit, &values[*count]));
        ++*count;
        if (v.value[end] == '\0') return PD_OK;
    }
}

PDI_FN pd_status pdi_text_get_integer(pd_ctx *ctx, pd_text *text, int section, const char *key, int low, int high,
                                      const char *fallback, int *value)
{
    pdi_text_value v;
    double number;
    PD_TRY(pdi_text_find_value(ctx, text, section, key, "", fallback, "a whole number", &v));
    PD_TRY(pdi_text_eval_constant(ctx, text, &v, 0, strlen(v.value), "", &number));
    if (!(number >= low && number <= high) || number != floor(number))
        return pd_fail(ctx, PD_ERR_PARSE, v.location, "column %d: found %.6g, expected a whole number from %d to %d",
                       v.column, number, low, high);
    *value = (int)number;
    return PD_OK;
}

/* Find the value in names, which ends with NULL; *index: its position. PD_ERR_PARSE: the message lists the names. */
static pd_status pdi_text_find_choice(pd_ctx *ctx, const pdi_text_value *v, const char *const *names, int *index)
{
    char list[PDI_TEXT_LIST_SIZE] = "", hint[PD_UNITS_TEXT];
    pd_units_suggestion near_word;
    pd_units_init_suggestion(&near_word, v->value, strlen(v->value));
    for (int k = 0; names[k]; k++) {
        if (strcmp(names[k], v->value) == 0) {
            *index = k;
            return PD_OK;
        }
        pdi_text_add_to_list(list, ", ", names[k]);
        pd_units_try_candidate(&near_word, names[k]);
    }
    pd_units_format_suggestion(&near_word, hint);
    char expected[PDI_TEXT_LIST_SIZE + PD_UNITS_TEXT + 16];
    snprintf(expected, sizeof expected, "one of %s%s", list, hint);
    return pdi_text_fail_value(ctx, v, 0, expected);
}

PDI_FN pd_status pdi_text_get_bool(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                   int *value)
{
    static const char *const names[] = {"no", "yes", "false", "true", "off", "on", NULL};
    pdi_text_value v;
    PD_TRY(pdi_text_find_value(ctx, text, section, key, "", fallback, "yes or no", &v));
    PD_TRY(pdi_text_find_choice(ctx, &v, names, value));
    *value %= 2;
    return PD_OK;
}

PDI_FN pd_status pdi_text_get_choice(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *const *names,
                                     const char *fallback, int *index)
{
    pdi_text_value v;
    char list[PDI_TEXT_LIST_SIZE] = "";
    for (int k = 0; names[k]; k++) pdi_text_add_to_list(list, " | ", names[k]);
    PD_TRY(pdi_text_find_value(ctx, text, section, key, "", fallback, list, &v));
    return pdi_text_find_choice(ctx, &v, names, index);
}

PDI_FN pd_status pdi_text_get_words(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                    pd_word_list *list)
{
    pdi_text_value v;
    list->count = 0;
    PD_TRY(pdi_text_find_value(ctx, text, section, key, "", fallback, "words separated by commas", &v));
    for (size_t at = 0;; at++) {
        at = pdi_text_skip_blanks(v.value, at);
        size_t n = 0, size;
        while ((size = pdi_text_scan_word(v.value + at + n, PDI_TEXT_CHARSET_LABEL)) > 0 ||
               (v.value[at + n] && strchr(n ? ".():" : ".", v.value[at + n]))) /* Mg(OH)2(s) */
            n += size > 0 ? size : 1;
        if (n == 0) return pdi_text_fail_value(ctx, &v, at, "a word");
        if (n >= PD_TEXT_WORD) return pdi_text_fail_value(ctx, &v, at, "a word of fewer than 32 characters");
        if (list->count >= PD_TEXT_WORDS) return pdi_text_fail_too_many(ctx, &v, at, PD_TEXT_WORDS, "");
        memcpy(list->word[list->count], v.value + at, n);
        list->word[list->count++][n] = '\0';
        at = pdi_text_skip_blanks(v.value, at + n);
        if (v.value[at] == '\0') return PD_OK;
        if (v.value[at] != ',') return pdi_text_fail_value(ctx, &v, at, "',' or the end");
    }
}

/* Parse one range "a .. b" in bytes [at, end) of the value, in SI. PD_ERR_PARSE: no "..", three dots, or a not below
 * b. */
static pd_status pdi_text_parse_range(pd_ctx *ctx, const pd_text *text, const pdi_text_value *v, size_t at, size_t end,
                                      const char *unit, double *low, double *high)
{
    size_t dots = at;
    while (dots < end && (v->value[dots] != '.' || v->value[dots + 1] != '.')) dots++;
    if (dots >= end) return pdi_text_fail_value(ctx, v, end, "'..' and the end of a range (a .. b)");
    if (v->value[dots + 2] == '.') return pdi_text_fail_value(ctx, v, dots, "two dots with blanks around them");
    PD_TRY(pdi_text_eval_constant(ctx, text, v, at, dots, unit, low));
    PD_TRY(pdi_text_eval_constant(ctx, text, v, dots + 2, end, unit, high));
    if (*low < *high) return PD_OK;
    return pd_fail(ctx, PD_ERR_PARSE, v->location,
                   "column %d: found a range from %.6g to %.6g, expected its start below"
                   " its end",
                   v->column + (int)at, *low, *high);
}

PDI_FN pd_status pdi_text_get_ranges(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                     const char *fallback, int max, double *low, double *high, int *count)
{
    pdi_text_value v;
    size_t at = 0, end;
    *count = 0;
    PD_TRY(pdi_text_find_value(ctx, text, section, key, unit, fallback, "a .. b, one range for each axis", &v));
    for (;; at = end + 1) {
        end = pdi_text_find_item_end(v.value, at);
        if (*count >= max) return pdi_text_fail_too_many(ctx, &v, at - 1, max, max == PD_DIM ? PDI_AXES_HINT : "");
        PD_TRY(pdi_text_parse_range(ctx, text, &v, at, end, unit, &low[*count], &high[*count]));
        ++*count;
        if (v.value[end] == '\0') return PD_OK;
    }
}

PDI_FN pd_status pdi_text_get_expr(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                   const pd_expr_symbol *vars, int var_count, const char *fallback, pd_expr *expr)
{
    int count;
    return pdi_text_get_exprs(ctx, text, section, key, unit, vars, var_count, fallback, 1, expr, &count);
}

PDI_FN pd_status pdi_text_get_exprs(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                    const pd_expr_symbol *vars, int var_count, const char *fallback, int max,
                                    pd_expr *exprs, int *count)
{
    pdi_text_value v;
    char what[PD_UNITS_TEXT];
    size_t at = 0, end;
    pd_status status;
    *count = 0;
    memset(exprs, 0, (size_t)max * sizeof *exprs);
    pdi_text_describe_unit(ctx, unit, what);
    PD_TRY(pdi_text_find_value(ctx, text, section, key, unit, fallback, what, &v));
    for (;; at = end + 1) {
        end = pdi_text_find_item_end(v.value, at);
        status = *count < max ? pdi_text_compile_expr(ctx, text, &v, at, end, unit, vars, var_count, &exprs[*count])
                              : pdi_text_fail_too_many(ctx, &v, at - 1, max, max == PD_DIM ? PDI_AXES_HINT : "");
        if (status < 0) break;
        ++*count;
        if (v.value[end] == '\0') return PD_OK;
    }
    while (*count > 0) pd_expr_free(ctx, &exprs[--*count]);
    return status;
}

/* ---- reports ---- */

PDI_FN pd_status pdi_text_fail_key(pd_ctx *ctx, const pd_text *text, int section, const char *key, const char *format,
                                   ...)
{
    char message[PD_MESSAGE_SIZE], where[PDI_TEXT_LOCATION_SIZE];
    if (text->pending_status) return pdi_text_fail_memory(ctx, text);
    const pd_text_entry *e = pdi_text_find_entry(text, section, key);
    int known = section >= 0 && section < text->section_count, line = known ? text->section[section].line : 0;
    const char *file = known ? text->section[section].file : text->name;
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    pdi_text_format_location(e ? e->file : file, e ? e->line : line > 0 ? line : 1, where);
    return pd_fail(ctx, PD_ERR_ARGUMENT, where, "%.40s: %s", key, message);
}

/* Report a section that no reader knows, with the nearest name. Returns PD_ERR_PARSE. */
static pd_status pdi_text_fail_unknown_section(pd_ctx *ctx, const pd_text *text, int section, const char *file,
                                               int line)
{
    char hint[PD_UNITS_TEXT], list[PDI_TEXT_LIST_SIZE] = "";
    const pd_section *s = &text->section[section];
    pd_units_suggestion near_word;
    pd_units_init_suggestion(&near_word, s->name, strlen(s->name));
    for (int k = 1; k < text->section_count; k++) {
        if (!text->section[k].is_looked_up || text->section[k].group_first != k) continue;
        pd_units_try_candidate(&near_word, text->section[k].name);
        pdi_text_add_to_list(list, ", ", text->section[k].name);
    }
    pd_units_format_suggestion(&near_word, hint);
    return pdi_text_fail_line(ctx, file, line, "found the section [%.40s], expected one of %s%s", s->name, list, hint);
}

/* Report a key that no reader used: without effect in this scene, if a reader asked for it in a section of this name,
 * else unknown, with the nearest key asked for. Returns PD_ERR_PARSE. */
static pd_status pdi_text_fail_unknown_key(pd_ctx *ctx, const pd_text *text, const pd_text_entry *e)
{
    char hint[PD_UNITS_TEXT], list[PDI_TEXT_LIST_SIZE] = "", title[PD_UNITS_TEXT];
    pd_units_suggestion near_word;
    pdi_text_format_section(text, e->section, title);
    pd_units_init_suggestion(&near_word, e->key, strlen(e->key));
    for (int k = 0; k < text->asked_count; k++) {
        if (text->asked_key[k].group != text->section[e->section].group_first) continue;
        if (strcmp(text->asked_key[k].key, e->key) == 0)
            return pdi_text_fail_line(ctx, e->file, e->line,
                                      "found '%.40s' in %s, where it has no effect; expected it to be left out", e->key,
                                      title);
        pd_units_try_candidate(&near_word, text->asked_key[k].key);
        pdi_text_add_to_list(list, ", ", text->asked_key[k].key);
    }
    pd_units_format_suggestion(&near_word, hint);
    return pdi_text_fail_line(ctx, e->file, e->line, "found the unknown key '%.40s' in %s, expected %s%s%s", e->key,
                              title, list[0] ? "one of " : "no key there", list, hint);
}

PDI_FN pd_status pdi_text_check_unused(pd_ctx *ctx, const pd_text *text)
{
    if (text->pending_status) return pdi_text_fail_memory(ctx, text);
    for (int k = 0; k < text->entry_count; k++) {
        const pd_text_entry *e = &text->entry[k];
        int known = e->section == 0 || text->section[text->section[e->section].group_first].is_looked_up;
        if (!e->is_read && known) return pdi_text_fail_unknown_key(ctx, text, e);
        if (!e->is_read) return pdi_text_fail_unknown_section(ctx, text, e->section, e->file, e->line);
    }
    for (int k = 1; k < text->section_count; k++)
        if (text->section[k].is_present && !text->section[text->section[k].group_first].is_looked_up)
            return pdi_text_fail_unknown_section(ctx, text, k, text->section[k].file, text->section[k].line);
    return PD_OK;
}

#undef PDI_TEXT_GROW
#undef PDI_TEXT_LOCATION_SIZE
