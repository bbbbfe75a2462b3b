/* read_gas: see read_gas.h */
#include "scene/read_gas.h"
#include "scene/key_value.h"
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

/* Read an expression in x, y, z, not t, of a required key of [gas]. A constant must lie within the bounds of the key.
 */
static pd_status pdi_read_gas_expr(pd_ctx *ctx, pd_text *text, int section, const char *key, pd_expr *expr)
{
    double value;
    const pd_key *row = pdi_keys_find_key(pdi_keys_find_section("gas"), key);
    PD_TRY(pdi_text_get_expr(ctx, text, section, key, row->unit, pd_setup_get_position_symbols(), PD_DIM, NULL, expr));
    return pd_expr_is_constant(expr) ? pdi_key_value_get_number(ctx, text, section, key, &value) : PD_OK;
}

PDI_FN pd_status pdi_read_gas_read(pd_ctx *ctx, pd_text *text, pd_setup *u)
{
    static const char *const keys[] = {"vx", "vy", "vz"};
    int section = pdi_text_get_section(ctx, text, "gas", NULL), order;
    if (!u->has_gas) return PD_OK;
    /* without friction a plane wall is a plane of symmetry, and bonds to images know no corner */
    for (int side = 0; side < 2 * PD_DIM; side++)
        if (u->side[side].kind == PD_SIDE_WALL) u->side[side].kind = PD_SIDE_MIRROR;
    if (u->axisymmetric)
        return pdi_text_fail_key(ctx, text, section, "gas",
                                 "found in a box with geometry = axisymmetric, expected planar");
    PD_TRY(pdi_key_value_get_number(ctx, text, section, "gamma", &u->gas_gamma));
    PD_TRY(pdi_read_gas_expr(ctx, text, section, "rho", &u->gas_rho));
    PD_TRY(pdi_read_gas_expr(ctx, text, section, "p", &u->gas_p));
    for (int d = 0; d < PD_DIM; d++)
        PD_TRY(pdi_text_get_expr(ctx, text, section, keys[d], "m/s", pd_setup_get_position_symbols(), PD_DIM, "0",
                                 &u->initial_velocity[d]));
    PD_TRY(pdi_key_value_get_index(ctx, text, section, "order", &order));
    u->gas_order = (pd_gas_order)order;
    return pdi_key_value_get_number(ctx, text, section, "cfl", &u->gas_cfl);
}
