/* march: see march.h */
#include "metal/march.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Rates [1/s] at most: of a fluid node towards its neighbours, of a solid node as a share of Cs - Csat. */
static void pdi_march_rates(const pd_corrode *r, double *field, double *loss)
{
    double cross = r->fastest * r->highest * r->front.total;
    int difference = r->desc.drive == PD_DRIVE_DIFFERENCE;
    *loss = cross * (difference ? r->log_ratio * r->desc.solid / r->span : 1.0);
    *field = (r->desc.activation ? 0.0 : r->diffusion) + (difference ? cross * r->log_ratio : 0.0);
}

/* A node that turns fluid and keeps what it has lost has not less than none, and another one loses no more than it had:
 * contents that count, over Cs - Csat. */
static double pdi_march_left(const pd_corrode *r)
{
    return r->desc.keep_deficit ? r->span / r->desc.saturation : 1.0;
}

/* Share of its content [1/s] that a step takes, at most: as if one node were the worst for all that it may lose. */
static double pdi_march_at_most(const pd_corrode *r)
{
    double field, loss;
    pdi_march_rates(r, &field, &loss);
    return fmax(field + r->held, r->desc.drive == PD_DRIVE_CONSTANT ? loss * pdi_march_left(r) : 0.0);
}

/* The same of each node, into next. */
static void pdi_march_drain(void *user, int32_t first, int count)
{
    pd_corrode *r = (pd_corrode *)user;
    double *drain = r->next + first, diffusivity = r->desc.activation ? 0.0 : r->desc.diffusivity;
    double across = r->desc.drive == PD_DRIVE_DIFFERENCE ? r->log_ratio : 0.0;
    int role = r->map.role[first];
    for (int b = 0; b < count; b++) drain[b] = role == PDI_ROLE_WHOLE ? r->diffusion : 0.0;
    for (int k = 0; k < r->stencil->count && role != PDI_ROLE_WHOLE; k++) {
        const uint8_t *there = r->map.phase + first + r->map.shift[k];
        const double *speed = r->speed + first, *factor = r->factor ? r->factor + first + r->map.shift[k] : NULL;
        double weight = r->front.weight[k], lap = diffusivity * r->stencil->lap[k];
        for (int b = 0; b < count && role == PDI_ROLE_EXPOSED; b++) drain[b] += weight * speed[b + r->map.shift[k]];
        for (int b = 0; b < count && role == PDI_ROLE_SHORE; b++) {
            double metal = there[b] == PDI_PHASE_SOLID ? across * weight * speed[b] : 0.0;
            drain[b] += pdi_phase_wet(there[b]) ? lap : factor ? factor[b] * metal : metal;
        }
    }
    for (int b = 0; b < count; b++) {
        if (role != PDI_ROLE_EXPOSED) drain[b] += pdi_corrode_mirrored(r, first + b);
        else drain[b] *= (r->factor ? r->factor[first + b] : 1.0) * (across > 0.0 ? across : pdi_march_left(r));
    }
}

static double pdi_march_longest(const pd_ctx *ctx, pd_corrode *r)
{
    pdi_phase_walk walk = {0, 0, 0};
    int32_t i, end;
    double most = 0.0;
    pdi_corrode_sweep(ctx, r, pdi_march_drain, r);
    while (pdi_phase_next(&r->map, &walk, &i, &end))
        for (int32_t j = i; j < end && r->map.role[i] != PDI_ROLE_IDLE; j++) most = fmax(most, r->next[j]);
    return most > 0.0 ? 1.0 / most : HUGE_VAL;
}

/* Longest step that the share and the overshoot allow. */
static double pdi_march_accurate(const pd_corrode *r)
{
    double field, loss, share = r->desc.share;
    pdi_march_rates(r, &field, &loss);
    if (!r->desc.activation) share = fmin(share, r->desc.overshoot * r->desc.saturation / r->span);
    return loss > 0.0 ? share / loss : HUGE_VAL;
}

/* The step of at most dt [s] in which the course of a law of time costs a small part of what the step may take. Its
 * largest speed in there counts as the fastest. */
static double pdi_march_foresee(pd_corrode *r, double dt)
{
    double per = r->highest * r->front.total / (PDI_CORRODE_COURSE * r->desc.share);
    for (;;) {
        double error, fastest, now = r->fastest;
        pdi_corrode_course(r, dt, &error, &fastest);
        r->ahead = fastest > 0.0 || error > 0.0 ? 0.5 * dt : 0.0;
        r->fastest = fmax(now, fastest);
        double limit = fmin(pdi_march_accurate(r), 1.0 / pdi_march_at_most(r));
        if (fastest > now && dt > limit) {
            r->fastest = now;
            dt = fmax(0.9 * limit, 0.1 * dt);
        } else if (error * dt * per > 1.0 + 1e-9) {
            r->fastest = now;
            dt *= fmax(0.9 / (error * dt * per), 0.1);
        } else return dt;
    }
}

pd_status pd_corrode_limit(pd_ctx *ctx, pd_corrode *r, double *limit)
{
    PDI_TRY(pdi_corrode_prepare(ctx, r));
    *limit = pdi_march_longest(ctx, r);
    return PD_OK;
}

pd_status pd_corrode_step(pd_ctx *ctx, pd_corrode *r, double dt)
{
    double limit = dt;
    if (!(dt > 0.0) || !(dt < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "corrode", "a step of %g s, expected a positive one", dt);
    r->ahead = 0.5 * dt;
    pd_status status = pdi_corrode_prepare(ctx, r);
    r->ahead = 0.0;
    if (status < 0) return status;
    if (dt * pdi_march_at_most(r) > 1.0) limit = pdi_march_longest(ctx, r);
    if (dt > limit * (1.0 + 1e-12))
        return pdi_fail(ctx, PD_RETRY, "corrode", "the step of %g s exceeds the limit of %g s", dt, limit);
    pdi_corrode_exchange(ctx, r, dt);
    pdi_corrode_spare(r);
    pdi_corrode_commit(r, dt);
    return PD_OK;
}

/* ---- the process ---- */

static pd_status pdi_march_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_corrode *r = (pd_corrode *)self;
    double left = s->limit - s->time, limit;
    PDI_TRY(pdi_corrode_prepare(ctx, r));
    limit = pdi_march_accurate(r);
    /* at the limit proper a node may take all from its neighbours: beyond Csat by a step of its own each time */
    double most = pdi_march_at_most(r);
    if (limit * most > 1.0) limit = 1.0 / most;
    s->dt = pdi_process_even(left, pdi_march_foresee(r, fmin(limit, left)));
    if (!(r->ahead > 0.0)) return PD_OK;
    pd_status status = pdi_corrode_prepare(ctx, r);
    r->ahead = 0.0;
    return status;
}

static pd_status pdi_march_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_corrode *r = (pd_corrode *)self;
    pdi_corrode_exchange(ctx, r, s->dt);
    s->error = pdi_corrode_spare(r);
    return s->error < 1.0 ? PD_RETRY : PD_OK;
}

static pd_status pdi_march_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    (void)self;
    s->dt *= s->error;
    return PD_OK;
}

static pd_status pdi_march_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_corrode *r = (pd_corrode *)self;
    (void)ctx;
    pdi_corrode_commit(r, s->dt);
    r->time = s->end;
    return PD_OK;
}

static pd_status pdi_march_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_corrode *r = (const pd_corrode *)self;
    return pdi_fail(ctx, PD_ERR_STATE, "corrode",
                    "steps of %g s do not lead on from t = %g s to %g s: the shares of content (%g) or of overshoot "
                    "(%g) that a step may take are too small, Csat (%g mol/m3) too low, or the rate too high", s->dt,
                    s->time, s->limit, r->desc.share, r->desc.overshoot, r->desc.saturation);
}

static pd_status pdi_march_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    return pdi_corrode_store(ctx, (pd_corrode *)self, archive);
}

static void pdi_march_balance(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    const pd_corrode *r = (const pd_corrode *)self;
    (void)ctx;
    (void)k;
    a->solid += pd_corrode_solid(r);
    a->dissolved += pd_corrode_dissolved(r);
    a->out += r->out + r->out_carry;
}

PDI_FN void pdi_march_common(pd_corrode *r, pd_process *p)
{
    static const pd_element metal = {"metal", "mol"};
    p->name = "corrosion";
    p->self = r;
    p->element = &metal;
    p->elements = 1;
    p->steps = &r->steps;
    p->counts = 1;
    p->store = pdi_march_store;
    p->balance = pdi_march_balance;
}

pd_process pd_corrode_process(pd_corrode *r)
{
    pd_process p;
    memset(&p, 0, sizeof p);
    pdi_march_common(r, &p);
    p.inner = 1;
    p.span = pdi_process_span;
    p.limit = pdi_march_limit;
    p.attempt = pdi_march_attempt;
    p.accept = pdi_march_accept;
    p.reject = pdi_march_reject;
    p.stuck = pdi_march_stuck;
    return p;
}

pd_status pd_corrode_run(pd_ctx *ctx, pd_corrode *r, double t_end)
{
    pd_process p = pd_corrode_process(r);
    return pdi_process_run(ctx, &p, r->time, t_end);
}
