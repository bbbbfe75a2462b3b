/* amount: see amount.h */
#include "transport/amount.h"
#include <math.h>

/* What limited fluxes carry bond by bond follows from the limiter and the stream, which are there during steps. */
static double pdi_amount_limited(pd_ctx *ctx, pd_transport *t, int axis, int index)
{
    double flux = (double)NAN;
    if (pdi_transport_hold(ctx, t) < 0) return flux;
    pd_status status = pdi_flux_refresh(ctx, &t->flux);
    if (status >= 0) {
        pdi_transport_anti(ctx, t, t->c, t->rhs);
        flux = pdi_flux_through(&t->flux, t->c, t->anti, axis, index);
    }
    return pdi_transport_release(ctx, t, status) < 0 ? (double)NAN : flux;
}

PDI_FN double pdi_amount_section(pd_ctx *ctx, pd_transport *t, int axis, int index)
{
    int limited = pdi_transport_limits(t);
    double flux;
    if (t->desc.given) return 0.0;
    pd_ghosts_set_scalar(&t->bonds->ghosts, t->c);
    if (limited) flux = pdi_amount_limited(ctx, t, axis, index);
    else flux = pdi_flux_through(&t->flux, t->c, NULL, axis, index);
    if (t->rest) flux += pdi_flux_through(&t->flux, t->rest, NULL, axis, index);
    return flux + pdi_diffusion_through(&t->diffusion, t->c, t->rest, axis, index);
}

double pd_transport_stock(pd_ctx *ctx, const pd_transport *t)
{
    return pdi_grid_sum_field(ctx, t->grid, PD_FLUID, NULL, 0, t->c) * t->bonds->stencil->volume;
}

double pd_transport_carried(pd_ctx *ctx, const pd_transport *t)
{
    return pdi_grid_sum_field(ctx, t->grid, PD_FLUID, NULL, 0, t->carry) * t->bonds->stencil->volume;
}

/* Flow through inlet and outlet bonds, and from and to held walls, at the present field. */
PDI_FN void pdi_transport_boundary(const pd_ctx *ctx, pd_transport *t)
{
    pdi_compensated_sum out = {0.0, 0.0}, in = {0.0, 0.0};
    const pd_grid *grid = t->grid;
    for (int32_t i = 0; i < grid->total && t->diffusion.wall_rate; i++) {
        double gain = pdi_diffusion_gain(&t->diffusion, i, t->c[i], t->rest ? t->rest[i] : 0.0);
        if (grid->kind[i] == PD_FLUID)
            pdi_compensated_sum_add(gain > 0.0 ? &in : &out, fabs(gain) * pd_grid_circumference(grid, i));
    }
    for (int32_t p = 0; p < t->boundary.count; p++) {
        int32_t i = t->boundary.node[p];
        double around = pd_grid_circumference(grid, i);
        for (int k = 0; k < t->bonds->stencil->count; k++) {
            if (!pdi_flux_open(&t->flux, i, k)) continue;
            uint8_t far_kind = grid->kind[i + t->bonds->paths.shift[k]];
            if (far_kind == PD_OUTLET) pdi_compensated_sum_add(&out, around * pdi_flux_bond_flux(&t->flux, t->c, i, k));
            if (far_kind == PD_INLET) pdi_compensated_sum_add(&in, -around * pdi_flux_bond_flux(&t->flux, t->c, i, k));
            if (far_kind == PD_INLET && t->rest)
                pdi_compensated_sum_add(&in, -around * pdi_flux_bond_flux(&t->flux, t->rest, i, k));
        }
    }
    /* between nodes antidiffusive fluxes cancel: their sum came through the inlets */
    if (t->anti) pdi_compensated_sum_add(&in, pdi_grid_sum_field(ctx, grid, PD_FLUID, NULL, 0, t->anti));
    t->outflow = pdi_compensated_sum_total(&out) * t->bonds->stencil->volume;
    t->inflow = pdi_compensated_sum_total(&in) * t->bonds->stencil->volume;
}
