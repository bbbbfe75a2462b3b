/* read_gas: see read_gas.h */
#include "scene/read_gas.h"
#include <math.h>

PDI_FN pd_status pdi_read_gas_side(pd_ctx *ctx, pd_text *text, int section, pd_setup_side *side)
{
    static const char *const flows[] = {"slip", "inlet", "outlet", "periodic", "mirror", NULL};
    int flow;
    PD_TRY(pdi_text_get_choice(ctx, text, section, "flow", flows, "slip", &flow));
    side->kind = (pd_side)flow;
    return PD_OK;
}

PDI_FN pd_status pdi_read_gas_check_alone(pd_ctx *ctx, pd_text *text, const pd_setup *u)
{
    int section = pdi_text_get_section(ctx, text, "gas", NULL);
    const char *beside = u->has_flow ? "flow" : u->has_transport ? "transport" : u->has_dissolve ? "dissolve" :
                         u->has_corrode ? "corrode" : NULL;
    if (!u->has_gas || !beside) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, "gas",
                             "found beside [%s], expected [gas] alone: an inviscid gas "
                             "carries nothing and attacks nothing",
                             beside);
}

/* Read an expression in x, y, z; if it is constant it must be positive. */
static pd_status pdi_read_gas_positive_expr(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                            pd_expr *expr)
{
    PD_TRY(pdi_text_get_expr(ctx, text, section, key, unit, pd_setup_get_position_symbols(), PD_DIM, NULL, expr));
    if (!pd_expr_is_constant(expr)) return PD_OK;
    double value = pd_expr_eval(expr, NULL);
    if (value > 0.0 && value < 1e100) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, key, "found %.6g %s, expected a positive value", value, unit);
}

/* Read a number above `low` and at most `high`. */
static pd_status pdi_read_gas_bounded(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                      double low, double high, double *value)
{
    PD_TRY(pdi_text_get_number(ctx, text, section, key, "", fallback, value));
    if (*value > low && *value <= high) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, key, "found %.6g, expected a value above %g and at most %g", *value,
                             low, high);
}

PDI_FN pd_status pdi_read_gas_read(pd_ctx *ctx, pd_text *text, pd_setup *u)
{
    static const char *const orders[] = {"second", "first", NULL};
    static const char *const keys[] = {"vx", "vy", "vz"};
    int section = pdi_text_get_section(ctx, text, "gas", NULL), order;
    if (!u->has_gas) return PD_OK;
    /* without friction a plane wall is a plane of symmetry, and bonds to images know no corner */
    for (int side = 0; side < 2 * PD_DIM; side++)
        if (u->side[side].kind == PD_SIDE_WALL) u->side[side].kind = PD_SIDE_MIRROR;
    if (u->axisymmetric)
        return pdi_text_fail_key(ctx, text, section, "gas",
                                 "found in a box with geometry = axisymmetric, expected planar");
    PD_TRY(pdi_read_gas_bounded(ctx, text, section, "gamma", "1.4", 1.0, 10.0, &u->gas_gamma));
    PD_TRY(pdi_read_gas_positive_expr(ctx, text, section, "rho", "kg/m3", &u->gas_rho));
    PD_TRY(pdi_read_gas_positive_expr(ctx, text, section, "p", "Pa", &u->gas_p));
    for (int d = 0; d < PD_DIM; d++)
        PD_TRY(pdi_text_get_expr(ctx, text, section, keys[d], "m/s", pd_setup_get_position_symbols(), PD_DIM, "0",
                                 &u->initial_velocity[d]));
    PD_TRY(pdi_text_get_choice(ctx, text, section, "order", orders, "second", &order));
    u->gas_order = (pd_gas_order)order;
    return pdi_read_gas_bounded(ctx, text, section, "cfl", "0.8", 0.0, 1.0, &u->gas_cfl);
}
