/* reader: see reader.h */
#include "scene/reader.h"
#include <math.h>

/* [-] Relative tolerance of equal values: conversion from another unit rounds by a few parts in 1e16. */
#define PDI_READER_EQUAL_TOL 1e-12

PDI_FN pd_status pdi_reader_get_bounded(pdi_reader *s, int section, const char *key, const char *unit,
                                        const char *fallback, double low, double high, int low_open, double *value)
{
    char found[PD_UNITS_TEXT], bottom[PD_UNITS_TEXT], top[PD_UNITS_TEXT];
    PD_TRY(pdi_text_get_number(s->ctx, s->text, section, key, unit, fallback, value));
    if ((low_open ? *value > low : *value >= low) && *value <= high) return PD_OK;
    pd_setup_format_value(*value, unit, found);
    pd_setup_format_value(low, unit, bottom);
    pd_setup_format_value(high, unit, top);
    if (high < PDI_READER_MAX_NUMBER || *value > high)
        return pdi_text_fail_key(s->ctx, s->text, section, key, "found %s, expected a value %s %s and at most %s",
                                 found, low_open ? "above" : "from", bottom, top);
    return pdi_text_fail_key(s->ctx, s->text, section, key, "found %s, expected %s", found,
                             low_open ? "a positive value" : "a value of at least 0");
}

PDI_FN pd_status pdi_reader_get_positive(pdi_reader *s, int section, const char *key, const char *unit,
                                         const char *fallback, double *value)
{
    return pdi_reader_get_bounded(s, section, key, unit, fallback, 0.0, PDI_READER_MAX_NUMBER, 1, value);
}

PDI_FN pd_status pdi_reader_get_nonnegative(pdi_reader *s, int section, const char *key, const char *unit,
                                            const char *fallback, double *value)
{
    return pdi_reader_get_bounded(s, section, key, unit, fallback, 0.0, PDI_READER_MAX_NUMBER, 0, value);
}

PDI_FN pd_status pdi_reader_read_initial(pdi_reader *s, int section)
{
    pd_expr *initial = &s->setup->initial_c;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "initial", "mol/m3", pd_setup_get_position_symbols(), PD_DIM,
                             "0", initial));
    if (pd_expr_is_constant(initial) && pd_expr_eval(initial, NULL) < 0.0)
        return pdi_text_fail_key(s->ctx, s->text, section, "initial", "found %.6g mol/m3, expected at least 0",
                                 pd_expr_eval(initial, NULL));
    return PD_OK;
}

PDI_FN int pdi_reader_is_equal(double a, double b)
{
    return fabs(a - b) <= PDI_READER_EQUAL_TOL * pd_max(fabs(a), fabs(b));
}

#undef PDI_READER_EQUAL_TOL
