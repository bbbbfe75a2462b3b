/* reader: what the readers of sections share: the text, the setup that they fill, numbers within bounds. */
#ifndef PD_READER_H
#define PD_READER_H
#include "scene/setup.h"
#include "scene/read_constants.h"

#ifdef PDI_INTERNAL
/* A number of this size is none. */
#define PDI_READER_HUGE 1e30

typedef struct pdi_reader {
    pd_ctx *ctx;
    pd_text *text;
    pd_setup *setup;
    pdi_read_constants named;
} pdi_reader;

/* A number in low .. high; low_open: low itself is refused. */
PDI_FN pd_status pdi_reader_within(pdi_reader *s, int section, const char *key, const char *unit, const char *fallback,
                                   double low, double high, int low_open, double *value);
PDI_FN pd_status pdi_reader_positive(pdi_reader *s, int section, const char *key, const char *unit,
                                     const char *fallback, double *value);
PDI_FN pd_status pdi_reader_not_negative(pdi_reader *s, int section, const char *key, const char *unit,
                                         const char *fallback, double *value);
/* 1: both are one value, to what their units round. */
PDI_FN int pdi_reader_repeats(double a, double b);
/* The concentration at the start, key `initial` of a section. */
PDI_FN pd_status pdi_reader_initial(pdi_reader *s, int section);
#endif

#endif
