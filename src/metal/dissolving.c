/* dissolving: see dissolving.h */
#include "metal/dissolving.h"
#include "metal/content.h"
#include <math.h>
#include <string.h>

/* Share of `fraction` that the course of a law within a step may cost. */
#define PDI_DISSOLVING_EXACT 0.04
/* A node may lose this many times the share that steps are chosen for, where the law speeds up. */
#define PDI_DISSOLVING_EXCESS 2.0
/* A step that is below this share of the wanted one has failed. */
#define PDI_DISSOLVING_SHORTEST 1e-9

static pd_status pdi_dissolving_start(pd_ctx *ctx, void *self, double t)
{
    return pdi_transport_at(ctx, ((pd_dissolving *)self)->dissolve->transport, t);
}

/* The longest admissible step. */
static pd_status pdi_dissolving_longest(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolving *q = (pd_dissolving *)self;
    pd_dissolve *d = q->dissolve;
    d->most = PDI_DISSOLVING_EXCESS * s->fraction;
    d->rtol = s->rtol;
    d->lost = s->lost;
    d->time = s->time;
    q->first = 0.0;
    PDI_TRY(pdi_dissolve_prepare(ctx, d));
    double fastest = pdi_dissolve_fastest(ctx, d);
    if (fastest > 0.0) s->dt = fmin(s->dt, s->fraction / fastest);
    s->dt = fmin(s->dt, d->next_dt);
    return pdi_process_longest(ctx, self, s);
}

static pd_status pdi_dissolving_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    PDI_TRY(pdi_dissolving_longest(ctx, self, s));
    s->dt = pdi_process_even(s->limit - s->time, s->dt);
    return PD_OK;
}

/* Laws of place and time. Returns the factor that makes the step short enough; 1: it is. No node may lose more than the
 * step may take, and the change of the law within the step may cost a small share of that. A jump in time is met to
 * that share, too. */
static double pdi_dissolving_course(const pd_dissolve *d, const pd_step *s)
{
    double error, taken;
    if (d->uniform) return 1.0;
    pdi_dissolve_course(d, s->time, s->dt, &error, &taken);
    double share = fmax(taken / s->fraction, error / (PDI_DISSOLVING_EXACT * s->fraction));
    return share <= 1.0 + 1e-9 ? 1.0 : fmax(0.9 / share, 0.1);
}

static pd_status pdi_dissolving_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolving *q = (pd_dissolving *)self;
    pd_dissolve *d = q->dissolve;
    double end = s->time + s->dt;
    s->error = pdi_dissolving_course(d, s);
    if (s->error < 1.0) return PD_RETRY;
    if (!d->uniform || q->first > 0.0) { /* what changes in time is taken at the middle of the step */
        d->time = s->time + 0.5 * s->dt;
        PDI_TRY(pdi_dissolve_prepare(ctx, d));
    }
    if (s->at) PDI_TRY(s->at(ctx, s->at_user, end));
    PDI_TRY(pdi_transport_at(ctx, d->transport, end));
    pd_status status = pdi_dissolve_transport(ctx, d, s->dt, &q->result);
    q->krylov += status < 0 ? 0 : q->result.krylov;
    q->first = fmax(q->first, s->dt);
    return status;
}

static pd_status pdi_dissolving_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    const pd_dissolving *q = (const pd_dissolving *)self;
    const pd_dissolve *d = q->dissolve;
    double left = s->limit - s->time;
    if (s->error < 1.0) {
        s->dt = pdi_process_even(left, s->dt * s->error);
        return PD_OK;
    }
    if (d->retry_dt < PDI_DISSOLVING_SHORTEST * q->first)
        return pdi_fail(ctx, PD_ERR_DIVERGED, "dissolve",
                        "at t = %g s law and transport have no common solution for steps of %g s or more, or the law "
                        "grows so fast that metal would lose more than %g of a cell in them. Take a smoother law",
                        s->time, s->dt, d->most);
    s->dt = pdi_process_even(left, d->retry_dt);
    return PD_OK;
}

static pd_status pdi_dissolving_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolving *q = (pd_dissolving *)self;
    pd_dissolve *d = q->dissolve;
    q->out += s->dt * d->transport->outflow;
    q->in += s->dt * d->transport->inflow;
    PDI_TRY(pdi_dissolve_finish(ctx, d, s->dt));
    q->out += d->rinsed;
    s->turned = d->changed;
    s->turned_count = d->changed_count;
    return PD_OK;
}

static pd_status pdi_dissolving_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    (void)self;
    return pdi_fail(ctx, PD_ERR_STATE, "dissolve",
                    "steps of %g s do not lead on from t = %g s to %g s: fraction (%g) or max_step (%g s) is too "
                    "small, or the metal dissolves too fast", s->dt, s->time, s->limit, s->fraction, s->max_step);
}

static pd_status pdi_dissolving_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    pd_dissolve *d = ((pd_dissolving *)self)->dissolve;
    PDI_TRY(pd_transport_update(ctx, d->transport));
    if (turned != d->changed) pdi_content_turned(d, turned, count); /* its own nodes it knows */
    return PD_OK;
}

static pd_status pdi_dissolving_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_dissolving *q = (pd_dissolving *)self;
    q->dissolve->reached = 0; /* films may be read */
    PDI_TRY(pdi_transport_store(ctx, q->dissolve->transport, archive));
    PDI_TRY(pdi_owner_store(ctx, pdi_dissolve_list, q->dissolve, archive));
    PDI_TRY(PDI_KEEP(ctx, archive, "dissolve.out", &q->out, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "dissolve.in", &q->in, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "krylov of transport", &q->krylov, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "limiter steps", &q->result.limiter, 1));
    return PDI_KEEP(ctx, archive, "change", &q->result.change, 1);
}

static void pdi_dissolving_balance(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    const pd_dissolving *q = (const pd_dissolving *)self;
    (void)k;
    double volume;
    a->solid += pdi_content_stock(q->dissolve, &volume);
    a->volume += volume;
    a->dissolved += pd_transport_stock(ctx, q->dissolve->transport);
    a->carry += pd_transport_carried(ctx, q->dissolve->transport);
    a->out += q->out;
    a->in += q->in;
}

pd_process pd_dissolving_process(pd_dissolve *dissolve, pd_dissolving *q)
{
    pd_process p;
    memset(&p, 0, sizeof p);
    memset(q, 0, sizeof *q);
    q->dissolve = dissolve;
    p.name = "dissolution";
    p.self = q;
    p.element = pdi_transport_element();
    p.elements = 1;
    p.start = pdi_dissolving_start;
    p.longest = pdi_dissolving_longest;
    p.limit = pdi_dissolving_limit;
    p.attempt = pdi_dissolving_attempt;
    p.accept = pdi_dissolving_accept;
    p.reject = pdi_dissolving_reject;
    p.stuck = pdi_dissolving_stuck;
    p.changed = pdi_dissolving_changed;
    p.store = pdi_dissolving_store;
    p.balance = pdi_dissolving_balance;
    return p;
}

#undef PDI_DISSOLVING_EXACT
#undef PDI_DISSOLVING_EXCESS
#undef PDI_DISSOLVING_SHORTEST
