/* scan: words and numbers of a text, and failures that name its line.
 *
 * Words are separated by blanks and line ends. A failure is PD_ERR_PARSE with "path:line: ".
 */
#ifndef PD_SCAN_H
#define PD_SCAN_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef struct pdi_scan {
    pd_ctx *ctx;
    const char *where; /* the module, for messages */
    const char *path;
    const char *text, *end; /* *end is 0 */
    const char *at;
    int any_case; /* 1: words that are expected may have capital letters */
} pdi_scan;

/* The text from its first byte, or behind a mark of the order of bytes. */
PDI_FN pdi_scan pdi_scan_begin(pd_ctx *ctx, const char *where, const char *path, const char *text, size_t size);
PDI_FN pd_status pdi_scan_fail(const pdi_scan *scan, const char *at, const char *format, ...) PD_PRINTF_LIKE(3, 4);
/* The next word; its length, 0 at the end of the text. */
PDI_FN size_t pdi_scan_word(pdi_scan *scan, const char **word);
/* Go behind the end of the line; 1: there was nothing left on it. */
PDI_FN int pdi_scan_line(pdi_scan *scan);
/* The next word as a finite number, or as a whole one from low to high. what: its name, for the message. */
PDI_FN pd_status pdi_scan_number(pdi_scan *scan, const char *what, double *value);
PDI_FN pd_status pdi_scan_integer(pdi_scan *scan, const char *what, int64_t low, int64_t high, int64_t *value);
/* The next word as a number of entries of at least so many bytes each: a file that names more of them than it can hold
 * is refused before memory is asked for. */
PDI_FN pd_status pdi_scan_count(pdi_scan *scan, const char *what, int bytes, int64_t *count);
/* 1: a word is this one. */
PDI_FN int pdi_scan_is(const pdi_scan *scan, const char *word, size_t size, const char *name);
/* The next word has to be this one. */
PDI_FN pd_status pdi_scan_expect(pdi_scan *scan, const char *word);
#endif

#endif
