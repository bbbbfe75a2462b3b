/* settle: see settle.h */
#include "transport/settle.h"
#include "core/par.h"
#include "transport/explicit.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Length of a step over the exchange time of the slowest node. */
#define PDI_SETTLE_LONG 1e9
/* Most such steps. */
#define PDI_SETTLE_STEPS 60
/* Most corrections in a row. */
#define PDI_SETTLE_CORRECTIONS 20
/* Each is solved to this share of what it corrects. */
#define PDI_SETTLE_SHARE 1e-4
/* Corrections end when the defect after one is more than this share of the defect before. */
#define PDI_SETTLE_SLOW 0.5
/* The defect that corrections aim at: fluxes agree in all digits that tables print. */
#define PDI_SETTLE_AIM 1e-10

/* Longest time [s] in which a node exchanges its content; HUGE_VAL: nothing moves. */
static double pdi_settle_slowest(const pd_transport *t)
{
    double slowest = HUGE_VAL;
    for (int32_t i = 0; i < t->grid->total; i++) {
        double rate = t->grid->kind[i] == PD_FLUID ? pdi_explicit_rate(t, i) : 0.0;
        if (rate > 0.0) slowest = pd_min(slowest, rate);
    }
    return slowest < HUGE_VAL ? 1.0 / slowest : HUGE_VAL;
}

/* What the balances lack [mol/m3/s] into t->work, zero off the fluid. Held walls count as differences. */
static void pdi_settle_residual(pd_ctx *ctx, pd_transport *t)
{
    pd_flux steady = t->flux;
    pd_diffusion free_walls = t->diffusion;
    double *out = t->work, *more = t->work + t->grid->total;
    free_walls.wall_rate = NULL;
    steady.diffusion = &free_walls;
    steady.rate = 0.0;
    steady.exact = 1;
    pdi_transport_fresh(ctx, t);
    pd_ghosts_set_scalar(&t->bonds->ghosts, t->c);
    pdi_flux_apply(ctx, &steady, t->c, out);
    if (t->rest) pd_ghosts_set_scalar(&t->bonds->ghosts, t->rest);
    if (t->rest) pdi_flux_apply(ctx, &steady, t->rest, more);
    for (int32_t i = 0; i < t->grid->total; i++) {
        int fluid = t->grid->kind[i] == PD_FLUID;
        double rest = fluid && t->rest ? t->rest[i] : 0.0, sum = fluid ? out[i] : 0.0;
        if (fluid && t->rest) sum += more[i];
        if (fluid) sum = pdi_diffusion_gain(&t->diffusion, i, t->c[i], rest) + t->source[i] +
                         pdi_transport_gain(t, i) - sum;
        out[i] = sum;
    }
}

/* Rounding of the balances [mol/s]: of what streams carry, and of what diffuses, as far as `rest` does not keep it. */
static double pdi_settle_rounding(const pd_transport *t)
{
    const pd_stencil *s = t->bonds->stencil;
    double rounding = 4.0 * DBL_EPSILON, carry[PD_DIM], conduct = 0.0, size = 0.0;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int d = 0; d < PD_DIM; d++) carry[d] = 0.0;
    for (int k = 0; k < s->count; k++) {
        conduct += s->laplacian_weight[k];
        for (int d = 0; d < PD_DIM; d++) carry[d] += fabs(s->gradient_weight[k * PD_DIM + d]);
    }
    conduct *= t->rest ? rounding * rounding : rounding;
    for (int32_t i = 0; i < t->grid->total; i++) {
        double part = conduct * (t->diffusion.field ? t->diffusion.field[i] : t->desc.diffusivity);
        if (t->grid->kind[i] == PD_INLET) size = pd_max(size, fabs(t->c[i]));
        if (t->grid->kind[i] != PD_FLUID) continue;
        size = pd_max(size, fabs(t->c[i]));
        for (int d = 0; d < PD_DIM && t->flow; d++)
            part += rounding * carry[d] * fabs(t->flow->u[(int64_t)d * t->grid->total + i]);
        pdi_compensated_sum_add(&sum, part * pd_grid_circumference(t->grid, i));
    }
    return size * s->volume * pdi_compensated_sum_total(&sum);
}

/* What all balances lack, over what passes: inflow, outflow, sources. Where nothing passes, 0 when they hold to
 * rounding. */
static double pdi_settle_defect(pd_ctx *ctx, pd_transport *t)
{
    pdi_compensated_sum lack = {0.0, 0.0}, made = {0.0, 0.0};
    double volume = t->bonds->stencil->volume;
    pdi_settle_residual(ctx, t);
    pdi_transport_boundary(ctx, t);
    for (int32_t i = 0; i < t->grid->total; i++) {
        double around = t->grid->kind[i] == PD_FLUID ? pd_grid_circumference(t->grid, i) : 0.0;
        if (!(around > 0.0)) continue;
        pdi_compensated_sum_add(&lack, around * fabs(t->work[i]));
        pdi_compensated_sum_add(&made, around * pd_max(fabs(t->source[i]), t->absorb[i] * fabs(t->c[i])));
    }
    double missing = volume * pdi_compensated_sum_total(&lack), rounding = pdi_settle_rounding(t);
    double passes = pd_max(pd_max(fabs(t->inflow), fabs(t->outflow)), volume * pdi_compensated_sum_total(&made));
    if (missing <= rounding && PDI_SETTLE_DEFECT * passes <= rounding) return 0.0;
    return passes > 0.0 ? missing / passes : HUGE_VAL;
}

/* c + rest += delta, where rest keeps the digits that c cannot hold (Knuth's sum of two). Returns the relative change
 * of the field. */
static double pdi_settle_add(pd_transport *t, const double *delta)
{
    double moved = 0.0, size = 0.0;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        double more = delta[i] + (t->rest ? t->rest[i] : 0.0), c = t->c[i], sum = c + more, part = sum - c;
        t->c[i] = sum;
        moved = pd_max(moved, fabs(delta[i]));
        size = pd_max(size, fabs(sum));
        if (t->rest) t->rest[i] = (c - (sum - part)) + (more - part);
    }
    return size > 0.0 ? moved / size : 0.0;
}

/* Corrections as long as they halve the defect. PD_NOT_CONVERGED: it stays too large. */
static pd_status pdi_settle_correct(pd_ctx *ctx, pd_transport *t, pd_transport_result *result)
{
    double last = HUGE_VAL;
    result->defect = pdi_settle_defect(ctx, t);
    for (int n = 0; n < PDI_SETTLE_CORRECTIONS && result->defect > PDI_SETTLE_AIM; n++) {
        if (!(result->defect <= PDI_SETTLE_SLOW * last)) break;
        last = result->defect;
        pd_status status = pdi_transport_refine(ctx, t, PDI_SETTLE_SHARE, result);
        if (status < 0) return status;
        result->change = pdi_settle_add(t, t->work + t->grid->total);
        result->defect = pdi_settle_defect(ctx, t);
    }
    return result->defect <= PDI_SETTLE_DEFECT ? PD_OK : PD_NOT_CONVERGED;
}

static pd_status pdi_settle_find(pd_ctx *ctx, pd_transport *t, pd_transport_result *result)
{
    double limit = pdi_settle_slowest(t);
    int krylov = 0, limited = pdi_transport_limits(t);
    if (!(limit < 1e200))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "transport", "nothing moves what is dissolved, and a steady field "
                       "needs that: expected D above 0, a flow, or a solution in time");
    for (int step = 0; step < PDI_SETTLE_STEPS; step++) {
        double moved = 0.0, size = 0.0;
        pd_status status = pd_transport_implicit(ctx, t, PDI_SETTLE_LONG * limit, result);
        result->krylov = krylov += result->krylov;
        if (status < 0) return status;
        /* the carry belongs to a step that is no step in time */
        pdi_par_zero(ctx, t->grid->total, t->carry);
        for (int32_t i = 0; i < t->grid->total; i++) {
            if (t->grid->kind[i] != PD_FLUID) continue;
            moved = pd_max(moved, fabs(t->c[i] - t->old[i]));
            size = pd_max(size, fabs(t->c[i]));
        }
        result->change = size > 0.0 ? moved / size : 0.0;
        /* corrections leave the limiter as it is */
        if (limited && size > 0.0) {
            result->defect = pdi_settle_defect(ctx, t);
            if (!(result->defect <= PDI_SETTLE_DEFECT)) continue;
        }
        status = size > 0.0 ? pdi_settle_correct(ctx, t, result) : PD_OK;
        krylov = result->krylov;
        if (status <= 0) return status;
    }
    return PD_NOT_CONVERGED;
}

pd_status pd_transport_steady(pd_ctx *ctx, pd_transport *t, pd_transport_result *result)
{
    PD_TRY(pdi_transport_solves(ctx, t));
    PD_TRY(pdi_transport_hold(ctx, t));
    pd_status status = pdi_settle_find(ctx, t, result);
    t->worst = 0;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (fabs(t->work[i]) > fabs(t->work[t->worst])) t->worst = i;
    return pdi_transport_release(ctx, t, status);
}

#undef PDI_SETTLE_LONG
#undef PDI_SETTLE_STEPS
#undef PDI_SETTLE_CORRECTIONS
#undef PDI_SETTLE_SHARE
#undef PDI_SETTLE_SLOW
#undef PDI_SETTLE_AIM
