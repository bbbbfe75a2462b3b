/* amount: see amount.h */
#include "transport/amount.h"

PDI_FN double pdi_amount_section(pd_ctx *ctx, pd_transport *t, int axis, int index)
{
    int limited = t->flow && t->desc.advection == PD_ADVECTION_LIMITED;
    (void)ctx;
    if (t->desc.given) return 0.0;
    pd_ghosts_scalar(&t->bonds->ghosts, t->c);
    double flux = pdi_flux_through(&t->flux, t->c, limited ? t->anti : NULL, axis, index);
    if (t->rest) flux += pdi_flux_through(&t->flux, t->rest, NULL, axis, index);
    return flux + pdi_diffusion_through(&t->diffusion, t->c, t->rest, axis, index);
}

double pd_transport_stock(pd_ctx *ctx, const pd_transport *t)
{
    return pdi_grid_sum(ctx, t->grid, PD_FLUID, NULL, 0, t->c) * t->bonds->stencil->volume;
}

double pd_transport_carried(pd_ctx *ctx, const pd_transport *t)
{
    return pdi_grid_sum(ctx, t->grid, PD_FLUID, NULL, 0, t->carry) * t->bonds->stencil->volume;
}
