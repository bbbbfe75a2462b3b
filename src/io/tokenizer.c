/* tokenizer: see tokenizer.h */
#include "io/tokenizer.h"
#include "io/file.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

PDI_FN pdi_tokenizer pdi_tokenizer_init(pd_ctx *ctx, const char *where, const char *path, const char *text, size_t size)
{
    pdi_tokenizer scan = {ctx, where, path, text, text + size, text, 0};
    if (size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0) scan.position += 3;
    return scan;
}

PDI_FN pd_status pdi_tokenizer_fail(const pdi_tokenizer *s, const char *position, const char *format, ...)
{
    char text[300];
    int line = 1;
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    for (const char *c = s->text; c < position && c < s->end; c++) line += *c == '\n';
    return pd_fail(s->ctx, PD_ERR_PARSE, s->module, "%.250s:%d: %s", s->path, line, text);
}

/* Returns 1 for white space. */
static int pdi_tokenizer_is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

PDI_FN size_t pdi_tokenizer_read_word(pdi_tokenizer *s, const char **word)
{
    while (s->position < s->end && pdi_tokenizer_is_blank(*s->position)) s->position++;
    *word = s->position;
    while (s->position < s->end && !pdi_tokenizer_is_blank(*s->position)) s->position++;
    return (size_t)(s->position - *word);
}

PDI_FN int pdi_tokenizer_skip_line(pdi_tokenizer *s)
{
    int nothing = 1;
    for (; s->position < s->end && *s->position != '\n'; s->position++)
        nothing = nothing && pdi_tokenizer_is_blank(*s->position);
    if (s->position < s->end) s->position++;
    return nothing;
}

/* Report the word of `size` characters that was found (0: the end of the text) and what was expected, as
 * PD_ERR_PARSE. */
static pd_status pdi_tokenizer_fail_expected(const pdi_tokenizer *s, const char *word, size_t size,
                                             const char *expected)
{
    if (size == 0) return pdi_tokenizer_fail(s, s->end, "the file ends here, expected %s", expected);
    return pdi_tokenizer_fail(s, word, "found '%.*s', expected %s", size < 40 ? (int)size : 40, word, expected);
}

PDI_FN pd_status pdi_tokenizer_read_number(pdi_tokenizer *s, const char *what, double *value)
{
    const char *word;
    char expected[80];
    size_t size = pdi_tokenizer_read_word(s, &word);
    if (size > 0 && pdi_file_parse_number(word, size, value) && isfinite(*value)) return PD_OK;
    snprintf(expected, sizeof expected, "%s: a finite number", what);
    return pdi_tokenizer_fail_expected(s, word, size, expected);
}

PDI_FN pd_status pdi_tokenizer_read_integer(pdi_tokenizer *s, const char *what, int64_t low, int64_t high,
                                            int64_t *value)
{
    const char *word;
    char expected[120];
    size_t size = pdi_tokenizer_read_word(s, &word), k = 0;
    int minus = size > 0 && word[0] == '-', good = size > 0;
    *value = 0;
    if (size > 0 && (word[0] == '-' || word[0] == '+')) k = 1;
    good = good && size > k && size - k <= 18;
    for (; good && k < size; k++) {
        good = word[k] >= '0' && word[k] <= '9';
        *value = 10 * *value + (word[k] - '0');
    }
    if (minus) *value = -*value;
    if (good && *value >= low && *value <= high) return PD_OK;
    snprintf(expected, sizeof expected, "%s: a whole number from %.0f to %.0f", what, (double)low, (double)high);
    return pdi_tokenizer_fail_expected(s, word, size, expected);
}

PDI_FN pd_status pdi_tokenizer_read_count(pdi_tokenizer *s, const char *what, int bytes, int64_t *count)
{
    PD_TRY(pdi_tokenizer_read_integer(s, what, 0, INT64_C(999999999999999999), count));
    if (*count <= (int64_t)(s->end - s->position) / bytes + 1 && *count <= INT32_MAX) return PD_OK;
    return pdi_tokenizer_fail(s, s->position, "%s: %.0f, which is more than the rest of the file can hold", what,
                              (double)*count);
}

PDI_FN int pdi_tokenizer_is_word(const pdi_tokenizer *s, const char *word, size_t size, const char *name)
{
    if (size != strlen(name)) return 0;
    for (size_t k = 0; k < size; k++) {
        int capital = s->ignore_case && word[k] >= 'A' && word[k] <= 'Z';
        if ((capital ? word[k] - 'A' + 'a' : word[k]) != name[k]) return 0;
    }
    return 1;
}

PDI_FN pd_status pdi_tokenizer_expect_word(pdi_tokenizer *s, const char *expected)
{
    const char *word;
    size_t size = pdi_tokenizer_read_word(s, &word);
    if (pdi_tokenizer_is_word(s, word, size, expected)) return PD_OK;
    return pdi_tokenizer_fail_expected(s, word, size, expected);
}
