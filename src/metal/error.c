/* error: see error.h */
#include "metal/error.h"
#include "core/par.h"
#include <math.h>

/* The share of the longest step that is taken, how much longer or shorter the next one may be, and the loss of a node
 * over the tolerance that is faint. */
#define PDI_ERROR_SAFE 0.9
#define PDI_ERROR_LONGER 10.0
#define PDI_ERROR_FAINT 1e-3
/* What the errors of all steps may sum up to, over the tolerance of the metal lost. */
#define PDI_ERROR_SUM 5.0
/* Steps that are foreseen and not taken again: how much longer the next one may be. */
#define PDI_ERROR_GROWTH 1.5
/* Share of it that the equations of errors leave undone. */
#define PDI_ERROR_DAMPED 1e-3

/* Halvings of the largest concentration between which laws are looked at. */
#define PDI_ERROR_HALVINGS 40

/* Of a step [mol]. */
typedef struct pdi_error_step {
    double gone;  /* metal */
    double off;   /* errors of its places, as if they were alike */
    double lean;  /* what it took too little */
    double aside; /* and what more it may have taken, where speeds leave the way between both ends */
} pdi_error_step;

/* How far the concentration [mol/m3] at a node leaves the way between both ends of a step whose law is a mean over its
 * time, were nothing carried away: what comes earlier or later than by the mean. *least [m/s]: of the law meanwhile. */
static double pdi_error_swing(const pdi_beside *beside, const pdi_law *law, double c, double dt,
                              double *least)
{
    pdi_law at = *law;
    double mean = 0.0, came = 0.0, most = 0.0;
    *least = HUGE_VAL;
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < law->moments; k++) {
            double v = pdi_law_at_instant(&at, &beside->point, law->moment[k], c);
            if (!pass) mean += law->part[k] * v;
            if (!pass) *least = pd_min(*least, v);
            if (pass) came += law->part[k] * (v - mean);
            if (pass) most = pd_max(most, fabs(came));
        }
    return beside->weight * dt * most;
}

/* The least and the largest speed that a place has in the step. */
static void pdi_error_range(const pd_dissolve *d, pdi_beside *beside, double dt, double *slow, double *fast)
{
    const pd_transport *t = d->transport;
    double speed = pdi_interface_line(d, beside), c = t->c[beside->node];
    double start = d->desc.activation ? c : t->old[beside->node], least;
    pdi_law law;
    pdi_interface_law(d, beside, &law);
    *fast = pd_max(speed, beside->before);
    *slow = pd_min(speed, beside->before);
    if (d->desc.activation) return;
    *slow = pd_min(*slow, pdi_law_slowest(&law, &beside->point, start, c));
    if (!law.moments) return;
    double lowest = pd_max(pd_min(start, c), 0.0), swing = pdi_error_swing(beside, &law, lowest, dt, &least);
    if (beside->point.pinned) { /* the salt layer lasts while the law gives what the fluid takes */
        *slow = pd_min(*slow, least);
        return;
    }
    double v = pdi_law_at(&law, &beside->point, pd_max(start, c) + swing);
    *slow = pd_min(*slow, pd_max(v, 0.0));
}

static void pdi_error_look(pd_dissolve *d, double dt, pdi_error_step *step)
{
    pdi_compensated_sum gone = {0.0, 0.0}, off = {0.0, 0.0}, lean = {0.0, 0.0}, aside = {0.0, 0.0};
    double volume = d->paths.stencil->volume;
    for (int32_t k = 0; k < d->beside_count; k++) {
        pdi_beside *beside = &d->beside[k];
        double slow, fast, speed;
        if (!(beside->weight > 0.0)) continue; /* it gets nothing */
        double amount = dt * beside->weight * pd_grid_circumference(d->grid, beside->node);
        speed = pdi_interface_line(d, beside);
        pdi_error_range(d, beside, dt, &slow, &fast);
        pdi_compensated_sum_add(&gone, amount * speed);
        pdi_compensated_sum_add(&off, 0.5 * amount * (fast - slow));
        pdi_compensated_sum_add(&lean, 0.5 * amount * (beside->before - speed));
        pdi_compensated_sum_add(&aside, 0.5 * amount * (fast - slow - fabs(beside->before - speed)));
    }
    step->gone = pdi_compensated_sum_total(&gone) * volume;
    step->off = pdi_compensated_sum_total(&off) * volume;
    step->lean = pdi_compensated_sum_total(&lean) * volume;
    step->aside = pdi_compensated_sum_total(&aside) * volume;
}

/* The right-hand side [mol/m3/s] of the errors of the step at the nodes of the fluid: half of what changes on the way.
 * Nodes held at a jump are right; what they would get is left in `late`. */
static void pdi_error_right(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    pd_transport *t = d->transport;
    int32_t total = d->grid->total;
    double *right = t->work, *back = t->work + total;
    int nt = pd_par_threads(ctx, (int64_t)total * 2);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) back[i] = d->grid->kind[i] == PD_FLUID ? t->old[i] - t->c[i] : 0.0;
    pdi_transport_operator(ctx, t, back, right);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        right[i] = d->grid->kind[i] == PD_FLUID ? 0.5 * ((1.0 / dt + t->absorb[i]) * back[i] - right[i]) : 0.0;
    for (int32_t k = 0; k < d->beside_count; k++) {
        pdi_beside *beside = &d->beside[k];
        if (!(beside->weight > 0.0)) continue;
        beside->late = right[beside->node];
        right[beside->node] += 0.5 * beside->weight * (beside->before - pdi_interface_line(d, beside));
        if (beside->point.pinned) right[beside->node] = 0.0;
    }
}

/* Bonds: the error of the step with what the fluid makes of it until its end (by the matrix of the step). Where a law
 * ends or falls within the step, metal gives what the fluid takes, whatever the law began with. Fluxes that are limited
 * are left as they are; so is a surface rate, whose fluid is right for no other reason. */
static pd_status pdi_error_damp(pd_ctx *ctx, pd_dissolve *d, double dt, pdi_error_step *step,
                                pd_transport_result *result)
{
    pd_transport *t = d->transport;
    pdi_compensated_sum lean = {0.0, 0.0};
    double *error = t->work + d->grid->total;
    if (!pdi_metal_bonds(d) || d->desc.activation || pdi_transport_limits(t)) return PD_OK;
    pdi_error_right(ctx, d, dt);
    pd_status status = pdi_transport_refine(ctx, t, PDI_ERROR_DAMPED, result);
    if (status == PD_OK) {
        pdi_transport_operator(ctx, t, error, t->work);
        for (int32_t k = 0; k < d->beside_count; k++) {
            const pdi_beside *beside = &d->beside[k];
            int32_t i = beside->node;
            if (!(beside->weight > 0.0)) continue;
            double late = 0.5 * beside->weight * (beside->before - pdi_interface_line(d, beside)) -
                          t->absorb[i] * error[i];
            if (beside->point.pinned) late = t->work[i] - beside->late;
            pdi_compensated_sum_add(&lean, dt * late * pd_grid_circumference(d->grid, i));
        }
        step->lean = pdi_compensated_sum_total(&lean) * d->paths.stencil->volume;
    }
    if (t->pinned_count) pdi_transport_residual(ctx, t, t->work); /* as it was */
    return status < 0 ? status : PD_OK;
}

/* The laws beside metal, each by what it moves. */
typedef struct pdi_error_laws {
    double slope; /* [m3/mol] how steep they are, over the largest speed */
    int rises;    /* 1: some rise with the concentration */
} pdi_error_laws;

/* From the largest concentration down to what is beside the metal, and on to where the law moves metal. */
static void pdi_error_law(pdi_law *law, double low, double top, double weight, pdi_error_laws *laws, double *largest)
{
    double most = 0.0, steepest = 0.0, last = 0.0;
    for (int k = 0; k <= PDI_ERROR_HALVINGS; k++) {
        double c = ldexp(top, -k), v = pd_max(pdi_law_rate(law, c), 0.0);
        if (k) steepest = pd_max(steepest, fabs(v - last) / c); /* c below the one before */
        if (k && last > v) laws->rises = 1;
        most = pd_max(most, v);
        last = v;
        if (c < low && most > 0.0) break;
    }
    laws->slope += weight * steepest;
    *largest += weight * most;
}

static pdi_error_laws pdi_error_survey(const pd_dissolve *d)
{
    const pd_transport *t = d->transport;
    pdi_error_laws laws = {0.0, 0};
    double largest = 0.0, top = 0.0, low = HUGE_VAL;
    for (int32_t i = 0; i < d->grid->total; i++)
        if (d->grid->kind[i] == PD_FLUID) top = pd_max(top, pd_max(t->old[i], t->c[i]));
    for (int32_t k = 0; k < d->beside_count; k++)
        if (d->beside[k].weight > 0.0)
            low = pd_min(low, pd_min(t->old[d->beside[k].node], t->c[d->beside[k].node]));
    for (int32_t k = 0; k < d->beside_count && top > 0.0; k++) {
        pdi_law law;
        if (!(d->beside[k].weight > 0.0)) continue;
        pdi_interface_law(d, &d->beside[k], &law);
        pdi_error_law(&law, low, top, d->beside[k].weight, &laws, &largest);
        if (d->uniform && d->kinds == 1) break; /* it is the law of all */
    }
    laws.slope = largest > 0.0 ? laws.slope / largest : 0.0;
    return laws;
}

/* `scale` times an error of the fluid [mol/m3]: its mean beside metal, or over all fluid, root mean square, the larger
 * one; *amount [mol]: of all of it, whatever its sign. */
static double pdi_error_field(const pd_dissolve *d, const double *error, double scale, double *amount)
{
    pdi_compensated_sum all = {0.0, 0.0}, square = {0.0, 0.0}, near = {0.0, 0.0}, weight = {0.0, 0.0},
                        space = {0.0, 0.0};
    for (int32_t i = 0; i < d->grid->total; i++) {
        if (d->grid->kind[i] != PD_FLUID) continue;
        double size = scale * fabs(error[i]), around = pd_grid_circumference(d->grid, i);
        pdi_compensated_sum_add(&all, size * around);
        pdi_compensated_sum_add(&square, size * size * around);
        pdi_compensated_sum_add(&space, around);
    }
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        if (!(beside->weight > 0.0)) continue;
        double share = beside->weight * pd_grid_circumference(d->grid, beside->node);
        pdi_compensated_sum_add(&near, share * scale * fabs(error[beside->node]));
        pdi_compensated_sum_add(&weight, share);
    }
    *amount = pdi_compensated_sum_total(&all) * d->paths.stencil->volume;
    double fluid = sqrt(pdi_compensated_sum_total(&square) / pdi_compensated_sum_total(&space));
    return pd_max(pdi_compensated_sum_total(&near) / pdi_compensated_sum_total(&weight), fluid);
}

/* By how much longer a step may be, by what it misses of the fluid. Where laws fall, the loss is off by at most the
 * amount that is missed. Where that is too much, speeds are off by at most their slope times what is missed. */
static double pdi_error_stray_longer(const pd_dissolve *d, const pdi_error_step *step, const pdi_error_laws *laws,
                                     double size, double amount, double dt)
{
    double all = d->rtol * (d->lost + step->gone), factor;
    if (!(amount > 0.0) || !(laws->slope > 0.0)) return HUGE_VAL;
    size = pd_max(size - 2.0 * dt * pdi_krylov_min_norm(), 0.0) * laws->slope;
    factor = size > 0.0 ? sqrt(d->rtol / size) : HUGE_VAL;
    if (!laws->rises) {
        double left = pd_max(PDI_ERROR_SUM * all - d->stray, 0.0);
        factor = pd_max(factor, pd_max(PDI_ERROR_SUM * d->rtol * step->gone / amount, sqrt(left / amount)));
    }
    return PDI_ERROR_SAFE * factor;
}

/* Surface: the error in time of the fluid at the end of a step, dt/2 (f' - f), and where it would shorten the next step
 * what the matrix of the step leaves of it, twice: of a mode that decays by z in the step that is z^2/(1 + z)^3/2 (eq.
 * 10.15). Limited fluxes count as upwind ones. A step after one in which nodes turned is not judged: fields bend there.
 * *longer: how much longer the step may be. */
static pd_status pdi_error_stray(pd_ctx *ctx, pd_dissolve *d, double dt, const pdi_error_step *step, double *longer,
                                 pd_transport_result *result)
{
    pd_transport *t = d->transport;
    double *error = t->work + d->grid->total, amount, size;
    pd_status status = PD_OK;
    *longer = HUGE_VAL;
    if (d->turned || !d->beside_count) return PD_OK;
    pdi_error_laws laws = pdi_error_survey(d);
    if (!(laws.slope > 0.0)) return PD_OK;
    pdi_error_right(ctx, d, dt);
    size = pdi_error_field(d, t->work, dt, &amount);
    *longer = pdi_error_stray_longer(d, step, &laws, size, amount, dt);
    for (int pass = 0; pass < 2 && *longer < PDI_ERROR_LONGER; pass++) {
        for (int32_t i = 0; i < d->grid->total && pass; i++)
            t->work[i] = d->grid->kind[i] == PD_FLUID ? error[i] / dt : 0.0;
        status = pdi_transport_refine(ctx, t, PDI_ERROR_DAMPED, result);
        if (status != PD_OK) break;
        size = pdi_error_field(d, error, 1.0, &amount);
        *longer = pdi_error_stray_longer(d, step, &laws, size, amount, dt);
    }
    d->step_stray = amount;
    if (t->pinned_count) pdi_transport_residual(ctx, t, t->work); /* as it was */
    return status < 0 ? status : PD_OK;
}

/* By how much longer a step may be, by its own error and by the sum of all steps. Both go with its square. */
static double pdi_error_longer(const pd_dissolve *d, const pdi_error_step *step)
{
    double all = d->rtol * (d->lost + step->gone), size = fabs(step->lean) + step->aside, factor = HUGE_VAL;
    if (step->off > 0.0 && !pdi_metal_bonds(d)) factor = PDI_ERROR_SAFE * sqrt(all / step->off);
    double left = PDI_ERROR_SUM * all - (step->lean > 0.0 ? d->lean : -d->lean);
    if (!(size > 0.0)) return factor;
    double rate = PDI_ERROR_SUM * d->rtol * step->gone / size, sum = left > 0.0 ? sqrt(left / size) : 0.0;
    return pd_min(factor, PDI_ERROR_SAFE * pd_max(rate, sum));
}

/* PD_OK: the metal lost is right in time. What is faint against a cell is right. */
static pd_status pdi_error_accurate(pd_ctx *ctx, pd_dissolve *d, double lost, double dt, pd_transport_result *result)
{
    pdi_error_step step;
    d->next_dt = HUGE_VAL;
    if (!(d->rtol > 0.0)) return PD_OK;
    pdi_error_look(d, dt, &step);
    double factor = pdi_error_longer(d, &step), fluid = HUGE_VAL;
    if (!pdi_metal_bonds(d)) PD_TRY(pdi_error_stray(ctx, d, dt, &step, &fluid, result));
    if (factor < PDI_ERROR_LONGER) {
        PD_TRY(pdi_error_damp(ctx, d, dt, &step, result));
        factor = pdi_error_longer(d, &step);
    }
    d->step_lean = step.lean;
    int faint = lost <= PDI_ERROR_FAINT * d->rtol;
    factor = faint && factor <= PDI_ERROR_LONGER ? PDI_ERROR_LONGER : factor;
    factor = pd_min(factor, fluid);
    if (factor <= PDI_ERROR_LONGER) d->next_dt = dt * factor;
    if (factor >= PDI_ERROR_SAFE) return PD_OK;
    d->retry_dt = dt * pd_max(factor, 1.0 / PDI_ERROR_LONGER);
    return PD_RETRY;
}

/* Bonds: the next step from the error in time of the fluid, half of what it has moved otherwise than before, over Csat,
 * root mean square (eq. 11.9), and from what a node has lost. A step after one in which nodes turned is not judged:
 * fields bend there. 0: the error is too large, and no step before has foreseen it: it is the first one, or the law
 * bends in it. */
static int pdi_error_foresee(pd_dissolve *d, double lost, double dt)
{
    const pd_transport *t = d->transport;
    pdi_compensated_sum sum = {0.0, 0.0};
    int64_t nodes = 0;
    double ratio = d->last_dt > 0.0 ? dt / d->last_dt : 0.0, next = HUGE_VAL;
    for (int32_t i = 0; i < d->grid->total && d->moved; i++) {
        if (d->grid->kind[i] != PD_FLUID) continue;
        double moved = t->c[i] - t->old[i], error = 0.5 * (moved - ratio * d->moved[i]) / d->desc.saturation;
        pdi_compensated_sum_add(&sum, error * error);
        nodes++;
    }
    double error = nodes && !d->turned ? sqrt(pdi_compensated_sum_total(&sum) / (double)nodes) : 0.0;
    if (d->moved && (d->moments || !(d->last_dt > 0.0)) && error > d->desc.rtol) {
        d->retry_dt = dt * pd_max(PDI_ERROR_SAFE * sqrt(d->desc.rtol / error), 1.0 / PDI_ERROR_LONGER);
        return 0;
    }
    for (int32_t i = 0; i < d->grid->total && d->moved; i++)
        if (d->grid->kind[i] == PD_FLUID) d->moved[i] = t->c[i] - t->old[i];
    if (d->moved)
        next = dt * pd_min(PDI_ERROR_GROWTH, error > 0.0 ? PDI_ERROR_SAFE * sqrt(d->desc.rtol / error)
                                                          : PDI_ERROR_GROWTH);
    if (lost > 0.0) next = pd_min(next, 0.5 * dt * d->most / lost);
    d->next_dt = pd_min(d->next_dt, next);
    return 1;
}

PDI_FN pd_status pdi_error_stands(pd_ctx *ctx, pd_dissolve *d, double lost, double dt, pd_transport_result *result)
{
    pd_status status = PD_OK;
    int judged = !pdi_metal_bonds(d) || !d->turned;
    d->next_dt = HUGE_VAL;
    d->step_lean = d->step_stray = 0.0;
    if (judged) status = pdi_error_accurate(ctx, d, lost, dt, result);
    if (status != PD_OK || !pdi_metal_bonds(d)) return status;
    return pdi_error_foresee(d, lost, dt) ? PD_OK : PD_RETRY;
}

/* Metal [mol/s] by the speeds at the start of a step, or by those of now. */
static double pdi_error_speed(const pd_dissolve *d, int start)
{
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        double speed = start ? beside->before : pdi_interface_line(d, beside);
        if (beside->weight > 0.0)
            pdi_compensated_sum_add(&sum, beside->weight * pd_grid_circumference(d->grid, beside->node) * speed);
    }
    return pdi_compensated_sum_total(&sum) * d->paths.stencil->volume;
}

/* Metal [mol] that is faint against a cell of any metal. */
static double pdi_error_none(const pd_dissolve *d)
{
    double least = d->kind[0].supply;
    for (int m = 1; m < d->kinds; m++) least = pd_min(least, d->kind[m].supply);
    return PDI_ERROR_FAINT * d->rtol * least * d->paths.stencil->volume;
}

PDI_FN void pdi_error_judge(pd_dissolve *d)
{
    pdi_error_step last;
    d->faint = 1;
    d->foreseen = 0.0;
    if (!d->desc.follows || !(d->rtol > 0.0) || !(d->last_dt > 0.0)) return;
    last.gone = d->last_dt * d->last_speed;
    last.lean = d->turned ? 0.0 : 0.5 * d->last_dt * (pdi_error_speed(d, 1) - d->last_speed - d->drift);
    last.off = fabs(last.lean);
    last.aside = 0.0;
    d->lean += last.lean;
    d->faint = last.off <= pdi_error_none(d);
    d->foreseen = d->last_dt * (d->faint ? PDI_ERROR_LONGER : pd_min(pdi_error_longer(d, &last), PDI_ERROR_GROWTH));
}

PDI_FN void pdi_error_begin(pd_dissolve *d, double longest)
{
    if (!d->desc.follows || !(d->rtol > 0.0)) return;
    d->first_speed = pdi_error_speed(d, 1);
    d->drift = 0.0;
    double none = d->rtol * longest; /* a step that loses next to nothing, whatever the last one did */
    if (!d->faint && d->first_speed > 0.0) none = pd_min(none, pdi_error_none(d) / d->first_speed);
    d->foreseen = pd_max(d->foreseen, none);
    d->next_dt = pd_min(d->next_dt, d->foreseen);
}

PDI_FN void pdi_error_middle(pd_dissolve *d)
{
    if (d->desc.follows) d->drift = pdi_error_speed(d, 1) - d->first_speed;
}

PDI_FN void pdi_error_end(pd_dissolve *d, double dt)
{
    d->lean += d->step_lean;
    d->stray += d->step_stray;
    if (d->desc.follows) d->last_speed = pdi_error_speed(d, 0);
    d->last_dt = dt;
}

PDI_FN pd_status pdi_error_held(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    pd_transport *t = d->transport;
    int held = 0;
    for (int32_t k = 0; k < d->beside_count; k++) held |= d->beside[k].weight > 0.0 && d->beside[k].point.pinned;
    if (!held) return PD_OK;
    PD_TRY(pdi_transport_first(ctx, t, dt));
    for (int32_t k = 0; k < d->beside_count; k++) {
        pdi_beside *beside = &d->beside[k];
        const pdi_law_point *p = &beside->point;
        if (!(beside->weight > 0.0) || !p->pinned) continue;
        double need = -t->work[beside->node] / beside->weight;
        beside->before = pd_min(pd_max(need, p->behind), p->ahead);
    }
    return PD_OK;
}

#undef PDI_ERROR_SAFE
#undef PDI_ERROR_LONGER
#undef PDI_ERROR_FAINT
#undef PDI_ERROR_SUM
#undef PDI_ERROR_GROWTH
#undef PDI_ERROR_DAMPED
#undef PDI_ERROR_HALVINGS
