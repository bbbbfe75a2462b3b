/* tokenizer: reads words and numbers from a text, and reports errors with the line number.
 *
 * Words are separated by white space. An error is PD_ERR_PARSE with "path:line: ".
 */
#ifndef PD_TOKENIZER_H
#define PD_TOKENIZER_H
#include "core/base.h"

#ifdef PDI_APP_INTERNAL
/* State of reading a text. */
typedef struct pdi_tokenizer {
    pd_ctx *ctx;
    const char *module; /* name of the module, for messages */
    const char *path;
    const char *text, *end; /* *end is 0 */
    const char *position;   /* next character to read */
    int ignore_case;        /* 1: comparisons ignore the case of letters */
} pdi_tokenizer;

/* Start at the first byte of text[size], after a byte order mark; text[size] is 0, and the text stays in place. where:
 * name of the module for messages. */
PDI_FN pdi_tokenizer pdi_tokenizer_init(pd_ctx *ctx, const char *where, const char *path, const char *text,
                                        size_t size);
/* Report an error at a position of the text as PD_ERR_PARSE "path:line: ..."; the line is counted from 1 at the start
 * of the text. Text and path are cut off at 299 and 250 bytes. */
PDI_FN pd_status pdi_tokenizer_fail(const pdi_tokenizer *scan, const char *position, const char *format, ...)
    PD_PRINTF_LIKE(3, 4);
/* Read the next word. *word: its start in the text, not terminated. Returns its length, 0 at the end of the text. */
PDI_FN size_t pdi_tokenizer_read_word(pdi_tokenizer *scan, const char **word);
/* Skip to the start of the next line, or to the end of the text. Returns 1 when the rest of the line was blank (also
 * empty), else 0. */
PDI_FN int pdi_tokenizer_skip_line(pdi_tokenizer *scan);
/* Read the next word, also on a later line, as a finite number. what: its name for the message. PD_ERR_PARSE: there is
 * none, or it is no number, infinite or NaN; *value may have changed, and the word is passed. */
PDI_FN pd_status pdi_tokenizer_read_number(pdi_tokenizer *scan, const char *what, double *value);
/* Read the next word, also on a later line, as an integer from low to high, of at most 18 digits, with a sign or none.
 * PD_ERR_PARSE: there is none, or another word; *value has changed, and the word is passed. */
PDI_FN pd_status pdi_tokenizer_read_integer(pdi_tokenizer *scan, const char *what, int64_t low, int64_t high,
                                            int64_t *value);
/* Read the next word as a number of entries of at least `bytes` bytes each, 0 to INT32_MAX. PD_ERR_PARSE: it is none,
 * or so large that the rest of the file cannot hold the entries; so it is refused before memory is allocated. */
PDI_FN pd_status pdi_tokenizer_read_count(pdi_tokenizer *scan, const char *what, int bytes, int64_t *count);
/* Returns 1 when the word of `size` characters equals `name` (in lower case where ignore_case is set), else 0. */
PDI_FN int pdi_tokenizer_is_word(const pdi_tokenizer *scan, const char *word, size_t size, const char *name);
/* Read the next word, which must equal `word` as of pdi_tokenizer_is_word. PD_ERR_PARSE: another one, or none; it is
 * passed all the same. */
PDI_FN pd_status pdi_tokenizer_expect_word(pdi_tokenizer *scan, const char *word);
#endif

#endif
