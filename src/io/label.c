/* label: see label.h */
#include "io/label.h"
#include <string.h>

static int pdi_label_digit(char c) { return c >= '0' && c <= '9'; }
static int pdi_label_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/* Append bytes to out[PDI_LABEL_SIZE]; what does not fit is left out. */
static void pdi_label_add(const char *bytes, size_t size, char *out, size_t *used)
{
    if (*used + size >= PDI_LABEL_SIZE) return;
    memcpy(out + *used, bytes, size);
    *used += size;
}

PDI_FN const char *pdi_label_raised(char sign)
{
    static const char raised[11][4] = {"\xE2\x81\xB0", "\xC2\xB9",     "\xC2\xB2",     "\xC2\xB3",
                                       "\xE2\x81\xB4", "\xE2\x81\xB5", "\xE2\x81\xB6", "\xE2\x81\xB7",
                                       "\xE2\x81\xB8", "\xE2\x81\xB9", "\xE2\x81\xBB"};
    return raised[pdi_label_digit(sign) ? sign - '0' : 10];
}

/* Typeset the characters of a unit at text[position]: u to µ, exponents to superscripts. Returns how many characters
 * were read. */
static size_t pdi_label_unit(const char *text, size_t position, char *out, size_t *used)
{
    char before = position ? text[position - 1] : ' ', here = text[position], after = here ? text[position + 1] : '\0';
    size_t length = 0;
    if (here == 'u' && pdi_label_letter(after) && !pdi_label_letter(before) && !pdi_label_digit(before)) {
        pdi_label_add("\xC2\xB5", 2, out, used);
        return 1;
    }
    if (!pdi_label_letter(before) || !(pdi_label_digit(here) || (here == '-' && pdi_label_digit(after)))) {
        pdi_label_add(&here, 1, out, used);
        return 1;
    }
    do {
        const char *sign = pdi_label_raised(text[position + length++]);
        pdi_label_add(sign, strlen(sign), out, used);
    } while (pdi_label_digit(text[position + length]));
    return length;
}

/* Typeset a text; inside 1: it begins within a unit, not before an opening bracket. */
static const char *pdi_label_text(const char *text, int inside, char *out)
{
    size_t used = 0;
    for (size_t at = 0; text[at];) {
        if (text[at] == '[' || text[at] == ']') inside = text[at] == '[';
        if (inside) at += pdi_label_unit(text, at, out, &used);
        else pdi_label_add(&text[at++], 1, out, &used);
    }
    out[used] = '\0';
    return out;
}

PDI_FN const char *pdi_label_print(const char *text, char *out) { return pdi_label_text(text, 0, out); }

PDI_FN const char *pdi_label_value(const char *text, char *out)
{
    size_t number = strcspn(text, " ");
    if (!text[number] || number >= PDI_LABEL_SIZE) return pdi_label_text(text, 0, out);
    pdi_label_text(text + number, 1, out); /* begins with a space */
    size_t length = strlen(out);
    if (number + length >= PDI_LABEL_SIZE) length = PDI_LABEL_SIZE - 1 - number;
    memmove(out + number, out, length);
    out[number + length] = '\0';
    memcpy(out, text, number);
    return out;
}
