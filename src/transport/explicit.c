/* explicit: see explicit.h */
#include "transport/explicit.h"
#include "core/par.h"
#include <math.h>

PDI_FN double pdi_explicit_rate(const pd_transport *t, int32_t i)
{
    double room = t->desc.advection == PD_ADVECTION_LIMITED ? 2.0 : 1.0;
    double rate = t->absorb[i] + (t->diffusion.wall_rate ? t->diffusion.wall_rate[i] : 0.0);
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux, bond, upwind;
        if (!pdi_flux_open(&t->flux, i, k)) continue;
        pdi_flux_bond(&t->flux, i, k, &flux, &bond, &upwind);
        if (t->grid->kind[i + t->bonds->paths.shift[k]] == PD_OUTLET) rate += fmax(flux, 0.0);
        else rate += bond + room * upwind - 0.5 * flux;
    }
    return rate;
}

double pd_transport_limit(pd_ctx *ctx, const pd_transport *t)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) fastest = fmax(fastest, pdi_explicit_rate(t, i));
    return fastest > 0.0 ? 1.0 / fastest : HUGE_VAL;
}

/* A step within the limit, with all that is lent for it. */
static pd_status pdi_explicit_step(pd_ctx *ctx, pd_transport *t, double dt)
{
    const uint8_t *kind = t->grid->kind;
    PDI_TRY(pdi_flux_refresh(ctx, &t->flux));
    if (t->rest) pdi_par_zero(ctx, t->grid->total, t->rest);
    t->dt = 0.0;
    pdi_par_copy(ctx, t->grid->total, t->c, t->old);
    pdi_transport_open(t);
    int limited = pdi_transport_start(ctx, t), rounds = PDI_TRANSPORT_ROUNDS;
    pdi_transport_operator(ctx, t, t->old, t->rhs);
    do {
        pdi_par_copy(ctx, t->grid->total, t->old, t->c);
        if (limited) pdi_transport_anti(ctx, t, t->c, t->anti);
        pdi_transport_boundary(t);
        for (int32_t i = 0; i < t->grid->total; i++)
            if (kind[i] == PD_FLUID) {
                double held = t->diffusion.wall_source ? t->diffusion.wall_source[i] : 0.0;
                t->c[i] = t->old[i] + dt * (t->source[i] + held + t->anti[i] - t->rhs[i]) + t->carry[i];
            }
    } while (limited && --rounds > 0 && pdi_transport_mark(t, 1e-15) > 0);
    pdi_par_zero(ctx, t->grid->total, t->carry);
    return PD_OK;
}

pd_status pd_transport_explicit(pd_ctx *ctx, pd_transport *t, double dt)
{
    if (!(dt > 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    PDI_TRY(pdi_transport_solves(ctx, t));
    double limit = pd_transport_limit(ctx, t);
    if (dt > limit * (1.0 + 1e-12)) {
        pdi_fail(ctx, PD_RETRY, "transport", "the explicit step of %g s exceeds the limit of %g s", dt, limit);
        return PD_RETRY;
    }
    PDI_TRY(pdi_transport_hold(ctx, t));
    return pdi_transport_release(ctx, t, pdi_explicit_step(ctx, t, dt));
}
