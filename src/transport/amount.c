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
    pd_ghosts_scalar(&t->bonds->ghosts, t->c);
    if (limited) flux = pdi_amount_limited(ctx, t, axis, index);
    else flux = pdi_flux_through(&t->flux, t->c, NULL, axis, index);
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
