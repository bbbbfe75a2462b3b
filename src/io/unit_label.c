/* unit_label: see unit_label.h */
#include "io/unit_label.h"
#include <string.h>

/* Returns 1 for a decimal digit. */
static int pdi_unit_label_is_digit(char c) { return c >= '0' && c <= '9'; }
/* Returns 1 for a letter of ASCII. */
static int pdi_unit_label_is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/* Append bytes to out[PDI_UNIT_LABEL_SIZE] and advance *used; what does not fit is left out as a whole. */
static void pdi_unit_label_add_bytes(const char *bytes, size_t size, char *out, size_t *used)
{
    if (*used + size >= PDI_UNIT_LABEL_SIZE) return;
    memcpy(out + *used, bytes, size);
    *used += size;
}

PDI_FN const char *pdi_unit_label_get_superscript(char sign)
{
    static const char raised[11][4] = {"\xE2\x81\xB0", "\xC2\xB9",     "\xC2\xB2",     "\xC2\xB3",
                                       "\xE2\x81\xB4", "\xE2\x81\xB5", "\xE2\x81\xB6", "\xE2\x81\xB7",
                                       "\xE2\x81\xB8", "\xE2\x81\xB9", "\xE2\x81\xBB"};
    return raised[pdi_unit_label_is_digit(sign) ? sign - '0' : 10];
}

/* Typeset the characters of a unit at text[position]: u before a letter, and not behind a letter or digit, becomes µ;
 * digits behind a letter, with a minus sign or none, become superscripts; another character stays. Returns how many
 * characters were read, at least 1. */
static size_t pdi_unit_label_format_unit(const char *text, size_t position, char *out, size_t *used)
{
    char before = position ? text[position - 1] : ' ', here = text[position], after = here ? text[position + 1] : '\0';
    size_t length = 0;
    if (here == 'u' && pdi_unit_label_is_letter(after) && !pdi_unit_label_is_letter(before) &&
        !pdi_unit_label_is_digit(before)) {
        pdi_unit_label_add_bytes("\xC2\xB5", 2, out, used);
        return 1;
    }
    if (!pdi_unit_label_is_letter(before) ||
        !(pdi_unit_label_is_digit(here) || (here == '-' && pdi_unit_label_is_digit(after)))) {
        pdi_unit_label_add_bytes(&here, 1, out, used);
        return 1;
    }
    do {
        const char *sign = pdi_unit_label_get_superscript(text[position + length++]);
        pdi_unit_label_add_bytes(sign, strlen(sign), out, used);
    } while (pdi_unit_label_is_digit(text[position + length]));
    return length;
}

/* Typeset a text into out. inside 1: it begins within a unit, not before an opening bracket. Returns out. */
static const char *pdi_unit_label_format_text(const char *text, int inside, char *out)
{
    size_t used = 0;
    for (size_t at = 0; text[at];) {
        if (text[at] == '[' || text[at] == ']') inside = text[at] == '[';
        if (inside) at += pdi_unit_label_format_unit(text, at, out, &used);
        else pdi_unit_label_add_bytes(&text[at++], 1, out, &used);
    }
    out[used] = '\0';
    return out;
}

PDI_FN const char *pdi_unit_label_format(const char *text, char *out)
{
    return pdi_unit_label_format_text(text, 0, out);
}

PDI_FN const char *pdi_unit_label_format_value(const char *text, char *out)
{
    size_t number = strcspn(text, " ");
    if (!text[number] || number >= PDI_UNIT_LABEL_SIZE) return pdi_unit_label_format_text(text, 0, out);
    pdi_unit_label_format_text(text + number, 1, out); /* begins with a space */
    size_t length = strlen(out);
    if (number + length >= PDI_UNIT_LABEL_SIZE) length = PDI_UNIT_LABEL_SIZE - 1 - number;
    memmove(out + number, out, length);
    out[number + length] = '\0';
    memcpy(out, text, number);
    return out;
}
