/* result_line: see result_line.h */
#include "run/result_line.h"
#include <string.h>

/* 1: the text up to the next blank is NaN or infinite: nan, -nan, nan(...), inf, -inf, infinity, in any case. */
static int pdi_result_line_is_nonfinite(const char *value)
{
    char word[4] = "";
    size_t size = strcspn(value, " "), sign = value[0] == '-' || value[0] == '+';
    for (size_t k = 0; k < 3 && sign + k < size; k++) {
        char c = value[sign + k];
        word[k] = (char)(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    }
    if (strcmp(word, "nan") != 0 && strcmp(word, "inf") != 0) return 0;
    return size == sign + 3 || value[sign + 3] == '(' || strcspn(value, " ") == sign + 8; /* infinity */
}

PDI_FN void pdi_result_line_remove_nonfinite(char *figures)
{
    char *to = figures;
    for (const char *at = figures; *at;) {
        size_t size = strcspn(at + 1, " ") + 1;
        const char *value = (const char *)memchr(at, '=', size);
        int leave = at[0] == ' ' && value && pdi_result_line_is_nonfinite(value + 1);
        if (!leave) memmove(to, at, size);
        if (!leave) to += size;
        at += size;
    }
    *to = '\0';
}
