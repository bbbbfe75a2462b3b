/* reader: see reader.h */
#include "scene/reader.h"
#include <math.h>

/* [-] Relative tolerance of equal values: conversion from another unit rounds by a few parts in 1e16. */
#define PDI_READER_EQUAL_TOL 1e-12

PDI_FN pd_status pdi_reader_read_initial(pdi_reader *s, int section)
{
    pd_expr *initial = &s->setup->initial_c;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "initial", "mol/m3", pd_setup_get_position_symbols(), PD_DIM,
                             "0", initial));
    double value;
    if (!pd_expr_is_constant(initial)) return PD_OK;
    return pdi_key_value_get_number(s->ctx, s->text, section, "initial", &value);
}

PDI_FN int pdi_reader_is_equal(double a, double b)
{
    return fabs(a - b) <= PDI_READER_EQUAL_TOL * pd_max(fabs(a), fabs(b));
}

#undef PDI_READER_EQUAL_TOL
