/* key_value: see key_value.h */
#include "scene/key_value.h"
#include "setup/setup.h"
#include <string.h>

#define PDI_KEY_VALUE_MAX_CHOICES 8 /* most words of a choice */

/* Row of a key in the table of the section with index `section`. NULL: the table has none. */
static const pd_key *pdi_key_value_find(const pd_ctx *ctx, const pd_text *text, int section, const char *key)
{
    const pd_key_section *table = pdi_keys_find_known_section(ctx, text->section[section].name);
    return table ? pdi_keys_find_key(table, key) : NULL;
}

/* 1: the first `length` bytes of `word` are a word of the choices. */
static int pdi_key_value_is_choice(const pd_key *row, const char *word, size_t length)
{
    for (const char *at = row->choices; *at; at += strcspn(at, ","), at += strspn(at, ", "))
        if (strcspn(at, ",") == length && strncmp(at, word, length) == 0) return 1;
    return 0;
}

/* Default of the table, copied into out[size] up to its first ; or : and returned, where its text begins with a number
 * or, of a choice, with one of the words. NULL otherwise: the key is required, or the table tells in words where its
 * value comes from. */
static const char *pdi_key_value_get_default(const pd_key *row, char *out, size_t size)
{
    size_t length = strcspn(row->default_text, ";:"), word = strcspn(row->default_text, " ;:,");
    const char *digit = row->default_text + strspn(row->default_text, "-.");
    int is_value = row->type == PD_KEY_CHOICE ? pdi_key_value_is_choice(row, row->default_text, word)
                                              : *digit >= '0' && *digit <= '9';
    if (!is_value) return NULL;
    if (length >= size) length = size - 1;
    memcpy(out, row->default_text, length);
    out[length] = '\0';
    return out;
}

/* Unit of a key as the parser takes it: "" for a plain number; m^(d-1) becomes m2, m or "" by the dimension. */
static const char *pdi_key_value_get_unit(const pd_key *row)
{
    if (strcmp(row->unit, "m^(d-1)") == 0) return PD_DIM == 3 ? "m2" : PD_DIM == 2 ? "m" : "";
    return strcmp(row->unit, "-") == 0 ? "" : row->unit;
}

/* Report that the table has no such key of the wanted type. Returns PD_ERR_INTERNAL. */
static pd_status pdi_key_value_fail_key(pd_ctx *ctx, const pd_text *text, int section, const char *key)
{
    return pd_fail(ctx, PD_ERR_INTERNAL, "keys", "[%.40s] has no key '%.40s' of this type",
                   section >= 0 ? text->section[section].name : "", key);
}

/* Report a value [SI] that is not between the lower bound of the row and `high`; the message gives both, or only the
 * lower one where that is 0 and high is PD_KEY_MAX_NUMBER. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_key_value_fail_bounds(pd_ctx *ctx, const pd_text *text, int section, const pd_key *row,
                                           double high, const char *key, double value)
{
    const char *unit = pdi_key_value_get_unit(row);
    char found[PD_UNITS_TEXT], bottom[PD_UNITS_TEXT], top[PD_UNITS_TEXT];
    pd_setup_format_value(value, unit, found);
    pd_setup_format_value(row->low, unit, bottom);
    pd_setup_format_value(high, unit, top);
    if (high < PD_KEY_MAX_NUMBER || value > high || row->low < 0.0 || row->low > 0.0)
        return pdi_text_fail_key(ctx, text, section, key, "found %s, expected a value %s %s %s %s", found,
                                 row->low_is_open ? "above" : "from", bottom, row->low_is_open ? "and at most" : "to",
                                 top);
    return pdi_text_fail_key(ctx, text, section, key, "found %s, expected %s", found,
                             row->low_is_open ? "a positive value" : "a value of at least 0");
}

/* 1: the key has a number with bounds, or an expression whose value has them where it is constant. */
static int pdi_key_value_is_number(const pd_key *row)
{
    return row->type == PD_KEY_NUMBER || (row->type == PD_KEY_TEXT && row->low < row->high);
}

/* 1: a value [SI] lies between the lower bound of the row, which may be open, and `high`, which is included. */
static int pdi_key_value_is_within(const pd_key *row, double high, double value)
{
    return (row->low_is_open ? value > row->low : value >= row->low) && value <= high;
}

PDI_FN pd_status pdi_key_value_check_bounds(pd_ctx *ctx, const pd_text *text, int section, const pd_key *row,
                                            double value)
{
    if (!pdi_key_value_is_number(row) || pdi_key_value_is_within(row, row->high, value)) return PD_OK;
    return pdi_key_value_fail_bounds(ctx, text, section, row, row->high, row->keys, value);
}

/* Read a number [SI] of at most `high` and the upper bound of its row. Its default is that of the table, or, where
 * has_fallback is 1, `fallback` (NULL: the key is required). PD_ERR_ARGUMENT: out of bounds, also of a default.
 * PD_ERR_INTERNAL: no row of a number. */
static pd_status pdi_key_value_read_number(pd_ctx *ctx, pd_text *text, int section, const char *key, int has_fallback,
                                           const char *fallback, double high, double *value)
{
    char own[PD_UNITS_TEXT];
    const pd_key *row = section >= 0 ? pdi_key_value_find(ctx, text, section, key) : NULL;
    if (!row || !pdi_key_value_is_number(row)) return pdi_key_value_fail_key(ctx, text, section, key);
    if (!has_fallback) fallback = pdi_key_value_get_default(row, own, sizeof own);
    PD_TRY(pdi_text_get_number(ctx, text, section, key, pdi_key_value_get_unit(row), fallback, value));
    high = pd_min(high, row->high);
    if (pdi_key_value_is_within(row, high, *value)) return PD_OK;
    return pdi_key_value_fail_bounds(ctx, text, section, row, high, key, *value);
}

PDI_FN pd_status pdi_key_value_get_number(pd_ctx *ctx, pd_text *text, int section, const char *key, double *value)
{
    return pdi_key_value_read_number(ctx, text, section, key, 0, NULL, PD_KEY_MAX_NUMBER, value);
}

PDI_FN pd_status pdi_key_value_get_number_or(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                             const char *fallback, double *value)
{
    return pdi_key_value_read_number(ctx, text, section, key, 1, fallback, PD_KEY_MAX_NUMBER, value);
}

PDI_FN pd_status pdi_key_value_get_number_up_to(pd_ctx *ctx, pd_text *text, int section, const char *key, double high,
                                                double *value)
{
    return pdi_key_value_read_number(ctx, text, section, key, 0, NULL, high, value);
}

/* Read one of the words of a choice, at most PDI_KEY_VALUE_MAX_CHOICES; *value: its position among them, from 0 on.
 * "no, yes" is read as pdi_text_get_bool does. PD_ERR_PARSE: another word. PD_ERR_INTERNAL: the list of words is too
 * long. */
static pd_status pdi_key_value_read_choice(pd_ctx *ctx, pd_text *text, int section, const char *key, const pd_key *row,
                                           const char *fallback, int *value)
{
    char words[PD_UNITS_TEXT];
    const char *names[PDI_KEY_VALUE_MAX_CHOICES + 1];
    int count = 0;
    if (strcmp(row->choices, "no, yes") == 0) return pdi_text_get_bool(ctx, text, section, key, fallback, value);
    if (strlen(row->choices) >= sizeof words) return pdi_key_value_fail_key(ctx, text, section, key);
    memcpy(words, row->choices, strlen(row->choices) + 1);
    for (char *at = words; *at && count < PDI_KEY_VALUE_MAX_CHOICES;) {
        size_t length = strcspn(at, ",");
        int more = at[length] != '\0';
        names[count++] = at;
        at[length] = '\0';
        at += length + (size_t)more;
        at += strspn(at, " ");
    }
    names[count] = NULL;
    return pdi_text_get_choice(ctx, text, section, key, names, fallback, value);
}

/* Read a whole number, or the position of a choice. Its default is that of the table, or, where has_fallback is 1,
 * `fallback` (NULL: the key is required). PD_ERR_INTERNAL: no row of this type. PD_ERR_PARSE: out of bounds, or no such
 * word. */
static pd_status pdi_key_value_read_index(pd_ctx *ctx, pd_text *text, int section, const char *key, int has_fallback,
                                          const char *fallback, int *value)
{
    char own[PD_UNITS_TEXT];
    const pd_key *row = section >= 0 ? pdi_key_value_find(ctx, text, section, key) : NULL;
    if (!row || (row->type != PD_KEY_WHOLE && row->type != PD_KEY_CHOICE))
        return pdi_key_value_fail_key(ctx, text, section, key);
    if (!has_fallback) fallback = pdi_key_value_get_default(row, own, sizeof own);
    if (row->type == PD_KEY_CHOICE) return pdi_key_value_read_choice(ctx, text, section, key, row, fallback, value);
    return pdi_text_get_integer(ctx, text, section, key, (int)row->low, (int)row->high, fallback, value);
}

PDI_FN pd_status pdi_key_value_get_index(pd_ctx *ctx, pd_text *text, int section, const char *key, int *value)
{
    return pdi_key_value_read_index(ctx, text, section, key, 0, NULL, value);
}

PDI_FN pd_status pdi_key_value_get_index_or(pd_ctx *ctx, pd_text *text, int section, const char *key,
                                            const char *fallback, int *value)
{
    return pdi_key_value_read_index(ctx, text, section, key, 1, fallback, value);
}

#undef PDI_KEY_VALUE_MAX_CHOICES
