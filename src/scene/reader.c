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

PDI_FN const char *pdi_reader_get_dissolution_name(const pd_setup *setup)
{
    return setup->has_corrode ? "corrode" : "dissolve";
}

PDI_FN int pdi_reader_find_dissolution(pdi_reader *s, int m, const char *key)
{
    const char *name = pdi_reader_get_dissolution_name(s->setup);
    int own = pdi_text_get_section(s->ctx, s->text, name, s->setup->metal[m].material.name);
    if (pdi_text_has_key(s->ctx, s->text, own, key)) return own;
    return pdi_text_get_section(s->ctx, s->text, name, NULL);
}

PDI_FN const char *pdi_reader_get_rate_key(pdi_reader *s, int section)
{
    if (pdi_text_has_key(s->ctx, s->text, section, "current")) return "current";
    return pdi_text_has_key(s->ctx, s->text, section, "law") ? "law" : "rate";
}

#undef PDI_READER_EQUAL_TOL
