/* read_constants: see read_constants.h */
#include "scene/read_constants.h"
#include <string.h>

PDI_FN int pdi_read_constants_is_reserved(const char *name)
{
    static const char *const others[] = {"t", "x", "y", "z", "C", "Cs", "Csat", "rho_m", "M_m", "z_m"};
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
        if (strcmp(others[k], name) == 0) return 1;
    return pd_expr_is_reserved(name);
}

/* 1: the name is a unit, so a constant of that name would shadow it ("5 m" as a product). */
static int pdi_read_constants_is_unit(const char *name)
{
    pd_units_product unit;
    const char *why;
    return pd_units_scan_product(name, NULL, NULL, &unit, &why) == strlen(name) && !why;
}

PDI_FN int pdi_read_constants_format_unit(pd_ctx *ctx, const pd_dims *dims, char *unit)
{
    char text[PD_UNITS_TEXT];
    pd_dims again;
    pd_units_describe(dims, text);
    const char *open = strchr(text, '[');
    size_t size = open ? strcspn(open + 1, "]") : 0;
    if (open) memcpy(unit, open + 1, size);
    unit[size] = '\0';
    return pd_units_parse(ctx, unit, NULL, &again) == PD_OK && pd_units_is_same(dims, &again);
}

/* Read one pair of [constants] as a named constant, which the text knows at once. PD_ERR_ARGUMENT: the name is reserved
 * or a unit, a dimension with fractional exponents, too many constants. */
static pd_status pdi_read_constants_add_one(pd_ctx *ctx, pd_text *text, int section, const char *name,
                                            pdi_read_constants_table *n)
{
    pd_expr expr;
    if (n->count == PDI_READ_CONSTANTS_MAX)
        return pdi_text_fail_key(ctx, text, section, name, "found more than %d constants", PDI_READ_CONSTANTS_MAX);
    if (pdi_read_constants_is_reserved(name))
        return pdi_text_fail_key(ctx, text, section, name,
                                 "found the name '%.40s', expected one that expressions do not have", name);
    if (pdi_read_constants_is_unit(name))
        return pdi_text_fail_key(ctx, text, section, name,
                                 "found the name '%.40s', which is a unit, expected another one, such as %.40s_0", name,
                                 name);
    PD_TRY(pdi_text_get_expr(ctx, text, section, name, NULL, NULL, 0, NULL, &expr));
    pd_expr_symbol *s = &n->symbol[n->count];
    s->name = name;
    s->unit = n->unit[n->count];
    s->value = pd_expr_eval(&expr, NULL);
    int fits = pdi_read_constants_format_unit(ctx, &expr.dims, n->unit[n->count]);
    pd_expr_free(ctx, &expr);
    if (!fits)
        return pdi_text_fail_key(ctx, text, section, name,
                                 "found a quantity with broken exponents, expected whole ones");
    text->const_count = ++n->count;
    return PD_OK;
}

PDI_FN pd_status pdi_read_constants_read(pd_ctx *ctx, pd_text *text, pdi_read_constants_table *n)
{
    int section = pdi_text_get_section(ctx, text, "constants", NULL);
    n->count = 0;
    text->consts = n->symbol;
    text->const_count = 0;
    for (int k = 0; k < text->entry_count; k++)
        if (text->entry[k].section == section)
            PD_TRY(pdi_read_constants_add_one(ctx, text, section, text->entry[k].key, n));
    return PD_OK;
}

PDI_FN void pdi_read_constants_add_builtin(pd_text *text, pdi_read_constants_table *n, const char *name,
                                           const char *unit, double value)
{
    PD_ASSERT(n->count < PDI_READ_CONSTANTS_MAX + PDI_READ_CONSTANTS_EXTRA);
    n->symbol[n->count].name = name;
    n->symbol[n->count].unit = unit;
    n->symbol[n->count++].value = value;
    text->const_count = n->count;
}
