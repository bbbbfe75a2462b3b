/* explicit: see explicit.h */
#include "transport/explicit.h"
#include "core/par.h"
#include "transport/steep.h"
#include <math.h>

PDI_FN double pdi_explicit_rate(const pd_transport *t, int32_t i)
{
    double room = t->desc.advection == PD_ADVECTION_LIMITED ? 2.0 : 1.0;
    double rate = t->absorb[i] + (t->diffusion.wall_rate ? t->diffusion.wall_rate[i] : 0.0);
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux, bond, upwind;
        if (!pdi_flux_open(&t->flux, i, k)) continue;
        pdi_flux_bond(&t->flux, i, k, &flux, &bond, &upwind);
        if (t->grid->kind[i + t->bonds->paths.shift[k]] == PD_OUTLET) rate += pd_max(flux, 0.0);
        else rate += bond + room * upwind - 0.5 * flux;
    }
    return rate;
}

double pd_transport_limit(pd_ctx *ctx, const pd_transport *t)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) fastest = pd_max(fastest, pdi_explicit_rate(t, i));
    return fastest > 0.0 ? 1.0 / fastest : HUGE_VAL;
}

/* 1: a step of dt is within the limit that the stored fluxes of the bonds give. They are those of the step, and differ
 * from what single bonds are asked for by rounding. */
static int pdi_explicit_within(pd_ctx *ctx, const pd_transport *t, double dt)
{
    double room = t->desc.advection == PD_ADVECTION_LIMITED ? 2.0 : 1.0;
    pdi_par_zero(ctx, t->grid->total, t->work);
    pdi_flux_rates(ctx, &t->flux, room, t->work);
    return dt * pdi_par_max_abs(ctx, t->grid->total, t->work) <= 1.0;
}

/* c = start + dt (what comes in less what leaves) + what the last solve left undone, at fluid nodes; the share of one
 * thread. */
static void pdi_explicit_share(const pd_transport *t, double dt)
{
    const uint8_t *kind = t->grid->kind;
    const double *old = t->old, *source = t->source, *anti = t->anti, *net = t->work, *carry = t->carry;
    double *PD_RESTRICT c = t->c;
    if (!t->diffusion.wall_source) {
        PDI_FOR_NOWAIT
        for (int32_t i = 0; i < t->grid->total; i++) {
            double next = old[i] + dt * (source[i] + (anti ? anti[i] : 0.0) - net[i]) + carry[i];
            c[i] = kind[i] == PD_FLUID ? next : c[i];
        }
        return;
    }
    PDI_FOR_NOWAIT
    for (int32_t i = 0; i < t->grid->total; i++) {
        double held = pdi_diffusion_given(&t->diffusion, i);
        if (kind[i] != PD_FLUID) continue;
        c[i] = old[i] + dt * (source[i] + held + pdi_transport_gain(t, i) - net[i]) + carry[i];
    }
}

static void pdi_explicit_move(pd_ctx *ctx, const pd_transport *t, double dt)
{
    int nt = pd_par_threads(ctx, (int64_t)t->grid->total * 4);
    PDI_PARALLEL_CALL(nt, pdi_explicit_share(t, dt));
}

/* Bounds of an explicit step from t->old: those of a step, and what explicit steps before it have begun with. */
static void pdi_explicit_bounds(pd_transport *t, pdi_bounds *b)
{
    pdi_bounds seen;
    seen.low = t->seen[0];
    seen.high = t->seen[1];
    pdi_bounds_take_all(t->grid, PD_FLUID, t->old, &seen);
    t->seen[0] = seen.low;
    t->seen[1] = seen.high;
    pdi_transport_bounds(t, t->old, 0.0, b);
    b->low = pd_min(b->low, seen.low);
    b->high = pd_max(b->high, seen.high);
}

/* Antidiffusive fluxes of sixth order, as far as they keep the bounds of all explicit steps so far. */
static pd_status pdi_explicit_steep(pd_ctx *ctx, pd_transport *t, double dt)
{
    pd_arena *arena = t->desc.arena ? t->desc.arena : &t->own;
    pdi_steep s;
    s.flux = &t->flux;
    s.dt = dt;
    s.c = t->old;
    s.plain = t->c;
    s.bend = t->probe;
    s.ahead = t->limiter.slope;
    s.behind = t->limiter.factor;
    s.gain = t->work + t->grid->total;
    s.loss = t->rhs;
    pdi_explicit_bounds(t, &s.bounds);
    pdi_par_zero(ctx, t->grid->total, t->anti);
    pdi_explicit_move(ctx, t, dt);
    pd_ghosts_set_scalar(&t->bonds->ghosts, t->old);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_steep_list, &s));
    pdi_steep_anti(ctx, &s, t->anti);
    return pdi_arena_release(ctx, arena, pdi_steep_list, &s, PD_OK);
}

/* A step with all that is lent for it. PD_RETRY: it is too long, and nothing has changed. */
static pd_status pdi_explicit_step(pd_ctx *ctx, pd_transport *t, double dt)
{
    PD_TRY(pdi_flux_refresh(ctx, &t->flux));
    if (!pdi_explicit_within(ctx, t, dt)) {
        double limit = pd_transport_limit(ctx, t);
        if (dt > limit * (1.0 + 1e-12)) {
            pd_fail(ctx, PD_RETRY, "transport", "the explicit step of %g s exceeds the limit of %g s", dt, limit);
            return PD_RETRY;
        }
    }
    if (t->rest) pdi_par_zero(ctx, t->grid->total, t->rest);
    t->dt = 0.0;
    pdi_par_copy(ctx, t->grid->total, t->c, t->old);
    pdi_transport_open(t);
    int limited = pdi_transport_start(t), steep = limited && pdi_steep_may(&t->flux), rounds = PDI_TRANSPORT_ROUNDS;
    pdi_transport_operator(ctx, t, t->old, t->work);
    if (steep) PD_TRY(pdi_explicit_steep(ctx, t, dt));
    do {
        pdi_par_copy(ctx, t->grid->total, t->old, t->c);
        if (limited && !steep) pdi_transport_anti(ctx, t, t->c, t->anti);
        pdi_transport_boundary(ctx, t);
        pdi_explicit_move(ctx, t, dt);
    } while (limited && !steep && --rounds > 0 && pdi_transport_mark(t, 1e-15) > 0);
    pdi_par_zero(ctx, t->grid->total, t->carry);
    return PD_OK;
}

/* All but the solver is lent, unless it is already. */
static pd_status pdi_explicit_hold(pd_ctx *ctx, pd_transport *t)
{
    if (!t->held) t->lean = 1;
    pd_status status = pdi_transport_hold(ctx, t);
    if (!t->held) t->lean = 0;
    return status;
}

pd_status pd_transport_explicit(pd_ctx *ctx, pd_transport *t, double dt)
{
    if (!(dt > 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    PD_TRY(pdi_transport_solves(ctx, t));
    PD_TRY(pdi_explicit_hold(ctx, t));
    return pdi_transport_release(ctx, t, pdi_explicit_step(ctx, t, dt));
}
