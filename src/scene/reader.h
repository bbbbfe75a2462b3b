/* reader: state shared by the readers of scene sections (text, setup to fill, constants), and look-ups of numbers with
 * bounds. */
#ifndef PD_READER_H
#define PD_READER_H
#include "setup/setup.h"
#include "scene/read_constants.h"

#ifdef PDI_APP_INTERNAL
/* Upper bound of all numbers, in SI: anything larger is a mistake. */
#define PDI_READER_MAX_NUMBER 1e30

/* Context of a section reader. named: constants that expressions know by name. */
typedef struct pdi_reader {
    pd_ctx *ctx;
    pd_text *text;
    pd_setup *setup;
    pdi_read_constants_table constants;
} pdi_reader;

/* Read a number in low .. high [SI]; low_open 1: low itself is refused. PD_ERR_ARGUMENT with file:line: out of
 * bounds. */
PDI_FN pd_status pdi_reader_get_bounded(pdi_reader *reader, int section, const char *key, const char *unit,
                                        const char *fallback, double low, double high, int low_open, double *value);
/* Read a number above 0. */
PDI_FN pd_status pdi_reader_get_positive(pdi_reader *reader, int section, const char *key, const char *unit,
                                         const char *fallback, double *value);
/* Read a number of at least 0. */
PDI_FN pd_status pdi_reader_get_nonnegative(pdi_reader *reader, int section, const char *key, const char *unit,
                                            const char *fallback, double *value);
/* 1: two values are equal up to the rounding of unit conversions. */
PDI_FN int pdi_reader_is_equal(double a, double b);
/* Read the initial concentration [mol/m3], an expression in x, y, z, from the key `initial` into the setup. */
PDI_FN pd_status pdi_reader_read_initial(pdi_reader *reader, int section);
#endif

#endif
