/* units: physical dimensions, unit products such as "um/h" or "Pa s", and values printed with a readable unit.
 *
 * A unit is text: a product of SI or accepted units with prefixes ("m2/s", "kg/m^3", "mol m-2 s-1", "J/(mol K)",
 * "mm/year", "%"). Wherever pdcorr asks for a dimension it takes such a text; its scale then does not matter.
 * "" and "1" are the plain number. A year is 365.25 days. Offset units (degC) are refused.
 */
#ifndef PD_UNITS_H
#define PD_UNITS_H
#include "core/base.h"

/* Physical dimension: exponents of m, kg, s, A, mol, K. Real numbers, since sqrt of a length is a quantity too. */
typedef struct pd_dims {
    double exponent[6]; /* [-] */
} pd_dims;

#define PD_UNITS_TEXT 96 /* [byte] room for what pdi_units_format_value and pd_units_describe write */

#define pd_units_parse PD_NAME(pd_units_parse)
#define pd_units_describe PD_NAME(pd_units_describe)
#define pd_units_format_suggestion PD_NAME(pd_units_format_suggestion)
#define pd_units_init_suggestion PD_NAME(pd_units_init_suggestion)
#define pd_units_is_blank PD_NAME(pd_units_is_blank)
#define pd_units_is_digit PD_NAME(pd_units_is_digit)
#define pd_units_is_same PD_NAME(pd_units_is_same)
#define pd_units_scan_product PD_NAME(pd_units_scan_product)
#define pd_units_scan_word PD_NAME(pd_units_scan_word)
#define pd_units_try_candidate PD_NAME(pd_units_try_candidate)

/* Parse a unit: *scale is its size in SI (1 mL/min: 1.667e-8), *dims its dimension. Either may be NULL. "" and "1" have
 * scale 1. PD_ERR_PARSE: not a unit, or one with an offset (degC); *scale and *dims stay. */
PD_API pd_status pd_units_parse(pd_ctx *ctx, const char *unit, double *scale, pd_dims *dims);

/* A product of units, its scale as a quotient: a value times it rounds once, so that "80 um" is the double 80e-6. */
typedef struct pd_units_product {
    double num, den; /* [-] scale = num/den */
    pd_dims dims;
} pd_units_product;

/* Callback: 1 if the identifier text[0..size) is a declared name, and so no unit. */
typedef int (*pd_units_is_declared_fn)(const void *user, const char *text, size_t size);

/* Spelling suggestion: search for the candidate with the least edit distance to a misspelt word. best: "" if none is
 * close enough. */
typedef struct pd_units_suggestion {
    char word[32], best[32];
    int distance;
} pd_units_suggestion;
/* 1: both dimensions are equal, each exponent within 1e-9. */
PD_API int pd_units_is_same(const pd_dims *a, const pd_dims *b);
/* Describe a dimension in words into text[PD_UNITS_TEXT]: "a speed [m/s]", "a plain number", or, where it has no name,
 * "a quantity [kg m2]". */
PD_API void pd_units_describe(const pd_dims *dims, char *text);
/* Parse a product of units ("mol m-2 s-1", "J/(mol K)", "1/s") at the start of text, as far as units go; returns the
 * bytes read, 0: no unit there. A declared name (declared NULL: none) ends it. *why: NULL, or the reason why the unit
 * there is inadmissible (degC, bad exponent); the return value is then its position, and *unit is of no use. */
PD_API size_t pd_units_scan_product(const char *text, pd_units_is_declared_fn declared, const void *user,
                                    pd_units_product *unit, const char **why);
/* 1: space, tab or carriage return. */
PD_API int pd_units_is_blank(char c);
/* 1: decimal digit. */
PD_API int pd_units_is_digit(char c);
/* Length [byte] of the identifier at text; 0: none. Bytes >= 0x80 and _ count as letters; no digit comes first. */
PD_API size_t pd_units_scan_word(const char *text);
/* Start a search for the misspelt word[size]: a candidate must have an edit distance of 1 to a word of up to 4 bytes,
 * of 2 at most to a longer one. One of 32 bytes or more gets no suggestion. */
PD_API void pd_units_init_suggestion(pd_units_suggestion *near_word, const char *word, size_t size);
/* Compare a candidate with the word and keep it if it is nearer than the one before and near enough, with a distance
 * below the length of both. Words that differ in case alone have distance 0. Empty ones, and those of 32 bytes or more,
 * are skipped. */
PD_API void pd_units_try_candidate(pd_units_suggestion *near_word, const char *candidate);
/* The suggestion for a message, ": did you mean 'best'?" or "", into text[PD_UNITS_TEXT]. */
PD_API void pd_units_format_suggestion(const pd_units_suggestion *near_word, char *text);

#ifdef PDI_INTERNAL
/* Print the SI value of dimension dims with six digits into text[PD_UNITS_TEXT], in the largest unit of its list in
 * which its size is at least 1, else the smallest ("80 um", "9 h", "1.3 um/h"). 0, NaN, sizes above 1e300, and
 * dimensions without a name have the SI unit; plain numbers none. What it prints of a finite value can be read back by
 * pd_expr_build. */
PDI_FN void pdi_units_format_value(double value, const pd_dims *dims, char *text);

/* Parse what may follow a '/' in a unit: one unit, or a product in parentheses, which has to be closed. *unit is that
 * unit, not its inverse. Return value and *why as in pd_units_scan_product. */
PDI_FN size_t pdi_units_scan_divisor(const char *text, pd_units_is_declared_fn declared, const void *user,
                                     pd_units_product *unit, const char **why);
/* List units of the dimension for a message, "um, mm, m", into text[PD_UNITS_TEXT], as many as fit; of one without a
 * name its SI unit, of a plain number "". */
PDI_FN void pdi_units_format_examples(const pd_dims *dims, char *text);

/* Compare all units, with and without prefix (those of the micro sign aside), with the misspelt word and keep the
 * closest. */
PDI_FN void pdi_units_try_units(pd_units_suggestion *near_word);
#endif

#endif
