/* two_stage: see two_stage.h */
#include "transport/two_stage.h"
#include "core/array_registry.h"
#include "core/par.h"
#include "solve/sdirk.h"
#include "transport/amount.h"
#include <math.h>
#include <string.h>

/* An estimate above this share of the tolerance, below which a step grows as far as it may, is damped, and what the
 * linear solver may leave of that. */
#define PDI_TWO_STAGE_SMALL 0.04
#define PDI_TWO_STAGE_DAMPED 0.1

PDI_FN void pdi_two_stage_list(pdi_array_visitor *owner, void *object)
{
    pd_two_stage *two_stage = (pd_two_stage *)object;
    int64_t total = two_stage->transport ? two_stage->transport->grid->total : 0;
    PDI_ARRAY(owner, two_stage, start, total, "mol/m3");
    PDI_ARRAY(owner, two_stage, carry, total, "mol/m3");
    PDI_ARRAY(owner, two_stage, slope, total, "mol/m3");
    PDI_ARRAY(owner, two_stage, rest, total, "mol/m3");
    PDI_SCALAR_STATE(owner, two_stage, time, "s");
    PDI_SCALAR_STATE(owner, two_stage, dt, "s");
    PDI_SCALAR_STATE(owner, two_stage, error, "1");
    PDI_SCALAR_STATE(owner, two_stage, out, "mol");
    PDI_SCALAR_STATE(owner, two_stage, in, "mol");
    PDI_SCALAR_STATE(owner, two_stage, steps, "1");
    PDI_SCALAR_STATE(owner, two_stage, rejected, "1");
    PDI_SCALAR_STATE(owner, two_stage, krylov, "1");
    PDI_SCALAR_STATE(owner, two_stage, euler, "1");
    PDI_SCALAR_STATE(owner, two_stage, result.limiter, "1");
    PDI_SCALAR_STATE(owner, two_stage, result.change, "1");
}

static pd_status pdi_two_stage_make(pd_ctx *ctx, pd_transport *transport, const pd_two_stage_desc *desc,
                                    pd_two_stage *a)
{
    memset(a, 0, sizeof *a);
    a->desc = *desc;
    if (!(desc->rtol >= 0.0) || !(desc->first >= 0.0) || !(desc->largest >= 0.0) ||
        !(desc->rtol + desc->first + desc->largest < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "two_stage",
                       "rtol %g, first %g s, largest %g s: expected finite values of at least 0", desc->rtol,
                       desc->first, desc->largest);
    if (!(a->desc.rtol > 0.0)) a->desc.rtol = 1e-3;
    a->transport = transport;
    return pdi_array_registry_build(ctx, pdi_two_stage_list, a);
}

pd_status pd_two_stage_build(pd_ctx *ctx, pd_transport *transport, const pd_two_stage_desc *desc, pd_two_stage *a)
{
    pd_status status = pdi_two_stage_make(ctx, transport, desc, a);
    if (status < 0) pd_two_stage_free(ctx, a);
    return status;
}

static void pdi_two_stage_restore(const pd_ctx *ctx, pd_two_stage *a)
{
    pdi_par_copy(ctx, a->transport->grid->total, a->start, a->transport->c);
    pdi_par_copy(ctx, a->transport->grid->total, a->carry, a->transport->carry);
}

/* The change of the first stage, start + carry being where it begins. */
static void pdi_two_stage_change(pd_two_stage *a)
{
    const pd_transport *t = a->transport;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) a->slope[i] = t->c[i] - (a->start[i] + a->carry[i]);
}

/* Where the second stage begins: start + carry + (1 - gamma)/gamma slope. */
static void pdi_two_stage_between(pd_two_stage *a)
{
    pd_transport *t = a->transport;
    double ratio = (1.0 - PDI_SDIRK_GAMMA) / PDI_SDIRK_GAMMA;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        t->old[i] = (a->start[i] + a->carry[i]) + ratio * a->slope[i];
        t->carry[i] = 0.0;
    }
}

/* The estimate [mol/m3] with the differences that the matrix of the stage leaves, where that is less: what is at rest
 * at the end of a step need not be followed. Fluxes that are limited bend, and are left as they are. */
static pd_status pdi_two_stage_damp(pd_ctx *ctx, pd_two_stage *a, double *worst, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    int before = result->krylov;
    if (pdi_transport_limits(t)) return PD_OK;
    for (int32_t i = 0; i < t->grid->total; i++)
        t->work[i] = t->grid->kind[i] == PD_FLUID ? (a->slope[i] - (t->c[i] - t->old[i])) / t->dt : 0.0;
    pd_status status = pdi_transport_refine(ctx, t, PDI_TWO_STAGE_DAMPED, result);
    a->krylov += result->krylov - before;
    if (status == PD_OK) *worst = pd_min(*worst, pdi_par_max_abs(ctx, t->grid->total, t->work + t->grid->total));
    return status < 0 ? status : PD_OK;
}

/* error = gamma dt max |f1 - f2| over the largest concentration (as eq. 3.45), damped; that is at least *largest, which
 * follows. What the solvers of both stages leave undone of any field is no error of the step. */
static pd_status pdi_two_stage_error(pd_ctx *ctx, pd_two_stage *a, double *largest, pd_transport_result *result)
{
    const pd_transport *t = a->transport;
    double worst = 0.0, size = *largest;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        worst = pd_max(worst, fabs(a->slope[i] - (t->c[i] - t->old[i])));
        size = pd_max(size, pd_max(fabs(t->c[i]), fabs(a->start[i])));
    }
    *largest = size;
    size += 2.0 * t->dt * pdi_krylov_min_norm() / a->desc.rtol;
    if (worst > PDI_TWO_STAGE_SMALL * a->desc.rtol * size) PD_TRY(pdi_two_stage_damp(ctx, a, &worst, result));
    a->error = size > 0.0 ? worst / size : 0.0;
    return PD_OK;
}

/* A flow and values outside become those of time t. */
static pd_status pdi_two_stage_at(pd_ctx *ctx, pd_two_stage *a, double t)
{
    if (a->at) PD_TRY(a->at(ctx, a->at_user, t));
    return pdi_transport_at(ctx, a->transport, t);
}

static pd_status pdi_two_stage_first(pd_ctx *ctx, pd_two_stage *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    pdi_par_copy(ctx, t->grid->total, a->start, t->old);
    pd_status status = pdi_transport_stage(ctx, t, PDI_SDIRK_GAMMA * dt, 0, result);
    a->krylov += result->krylov;
    if (status < 0) return status;
    pdi_transport_residual(ctx, t, a->rest);
    pdi_two_stage_change(a);
    return status;
}

static pd_status pdi_two_stage_second(pd_ctx *ctx, pd_two_stage *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    double g = PDI_SDIRK_GAMMA;
    pdi_par_copy(ctx, t->grid->total, a->start, t->old);
    pdi_two_stage_between(a);
    pd_status status = pdi_transport_stage(ctx, t, g * dt, 0, result);
    a->krylov += result->krylov;
    if (status < 0) return status;
    PD_TRY(pdi_two_stage_error(ctx, a, &a->largest, result));
    pdi_transport_residual(ctx, t, t->work);
    for (int32_t i = 0; i < t->grid->total; i++) t->carry[i] = dt * ((1.0 - g) * a->rest[i] + g * t->work[i]);
    return status;
}

/* Between the stages nothing is lent: a flow that follows its boundary is solved there. */
static pd_status pdi_two_stage_stages(pd_ctx *ctx, pd_two_stage *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    double g = PDI_SDIRK_GAMMA;
    PD_TRY(pdi_two_stage_at(ctx, a, a->time + g * dt));
    PD_TRY(pdi_transport_hold(ctx, t));
    pd_status first = pdi_transport_release(ctx, t, pdi_two_stage_first(ctx, a, dt, result));
    if (first < 0) return first;
    double out = (1.0 - g) * t->outflow, in = (1.0 - g) * t->inflow;
    PD_TRY(pdi_two_stage_at(ctx, a, a->time + dt));
    PD_TRY(pdi_transport_hold(ctx, t));
    pd_status status = pdi_transport_release(ctx, t, pdi_two_stage_second(ctx, a, dt, result));
    if (status < 0) return status;
    t->outflow = out + g * t->outflow;
    t->inflow = in + g * t->inflow;
    return first > 0 ? first : status;
}

pd_status pd_two_stage_step(pd_ctx *ctx, pd_two_stage *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    int32_t total = t->grid->total;
    memset(result, 0, sizeof *result);
    if (!(dt > 0.0) || !(dt < 1e300))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "two_stage", "the step is %g s, expected a positive one", dt);
    pdi_par_copy(ctx, total, t->c, a->start);
    pdi_par_copy(ctx, total, t->carry, a->carry);
    PD_TRY(pdi_transport_at(ctx, t, a->time));
    pdi_transport_open(t);
    pd_status status = pdi_two_stage_stages(ctx, a, dt, result);
    if (status >= 0 && !pdi_transport_within(t, a->start)) {
        pdi_two_stage_restore(ctx, a);
        status = pd_transport_implicit(ctx, t, dt, result);
        a->krylov += result->krylov;
        a->euler++;
    }
    if (status < 0) {
        pdi_two_stage_restore(ctx, a);
        return status;
    }
    a->out += dt * t->outflow;
    a->in += dt * t->inflow;
    a->time += dt;
    a->steps++;
    return status;
}

/* ---- the steps of a process ---- */

static pd_status pdi_two_stage_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_two_stage *a = (pd_two_stage *)self;
    (void)ctx;
    if (!(a->dt > 0.0)) a->dt = a->desc.first > 0.0 ? a->desc.first : s->latest_end - s->time;
    a->largest = 0.0; /* what longer trials have met counts: a field that begins with nothing has no size of its own */
    a->time = s->time;
    a->at = s->solve_at;
    a->at_user = s->solve_at_user;
    a->passed[0] = a->out;
    a->passed[1] = a->in;
    pdi_sdirk_limit(a->dt, a->desc.largest, s);
    return PD_OK;
}

static pd_status pdi_two_stage_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_two_stage *a = (pd_two_stage *)self;
    pd_status status = pd_two_stage_step(ctx, a, s->dt, &a->result);
    s->error = a->error / a->desc.rtol;
    return status < 0 || s->error <= 1.0 ? status : PD_RETRY;
}

static pd_status pdi_two_stage_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_two_stage *a = (pd_two_stage *)self;
    (void)ctx;
    a->time = s->end;
    pdi_sdirk_accept(&a->dt, s);
    return PD_OK;
}

static pd_status pdi_two_stage_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_two_stage *a = (pd_two_stage *)self;
    pdi_two_stage_restore(ctx, a);
    a->steps--;
    a->rejected++;
    a->time = s->time;
    a->out = a->passed[0];
    a->in = a->passed[1];
    pdi_sdirk_reject(&a->dt, a->desc.largest, s);
    return PD_OK;
}

static pd_status pdi_two_stage_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_two_stage *a = (const pd_two_stage *)self;
    return pd_fail(ctx, PD_ERR_STATE, "transport",
                   "the error of a step of %g s at t = %g s is %g, expected it to fall with the step", s->dt, s->time,
                   a->error);
}

static pd_status pdi_two_stage_settle(pd_ctx *ctx, pd_two_stage *a)
{
    const pd_transport_result *r = &a->result;
    char place[PDI_GRID_POSITION_LENGTH];
    pd_status status = pd_transport_steady(ctx, a->transport, &a->result);
    a->krylov += r->krylov;
    if (status <= 0) return status;
    return pd_fail(ctx, PD_ERR_DIVERGED, "transport",
                   "the concentration is not steady: what the balances of the nodes lack is %.3g of what passes, "
                   "expected %g, and a step still changes %.3g of it; the largest at %s m. Solve in time, with "
                   "advection = upwind, or on a finer grid",
                   r->defect, PDI_SETTLE_DEFECT, r->change,
                   pdi_grid_format_position(a->transport->grid, a->transport->worst, place));
}

static pd_status pdi_two_stage_start(pd_ctx *ctx, void *self, double t)
{
    pd_two_stage *a = (pd_two_stage *)self;
    a->time = t;
    PD_TRY(pdi_transport_at(ctx, a->transport, t));
    return a->settle ? pdi_two_stage_settle(ctx, a) : PD_OK;
}

static pd_status pdi_two_stage_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_two_stage *a = (pd_two_stage *)self;
    PD_TRY(pdi_transport_store(ctx, a->transport, archive));
    return pdi_array_registry_store(ctx, pdi_two_stage_list, a, archive);
}

static void pdi_two_stage_balance(pd_ctx *ctx, void *self, int k, pd_amounts *amounts)
{
    const pd_two_stage *a = (const pd_two_stage *)self;
    (void)k;
    amounts->dissolved += pd_transport_stock(ctx, a->transport);
    amounts->undelivered += pd_transport_carried(ctx, a->transport);
    amounts->out += a->out;
    amounts->in += a->in;
}

pd_physics pd_two_stage_process(pd_two_stage *a)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "transport in time";
    p.self = a;
    p.time = &a->time;
    p.element = pdi_transport_element();
    p.elements = 1;
    p.steps = &a->steps;
    p.start = pdi_two_stage_start;
    p.limit = pdi_two_stage_limit;
    p.attempt = pdi_two_stage_attempt;
    p.accept = pdi_two_stage_accept;
    p.reject = pdi_two_stage_reject;
    p.report_underflow = pdi_two_stage_stuck;
    p.checkpoint = pdi_two_stage_store;
    p.add_amounts = pdi_two_stage_balance;
    return p;
}

void pd_two_stage_free(pd_ctx *ctx, pd_two_stage *a)
{
    pdi_array_registry_free(ctx, pdi_two_stage_list, a);
    memset(a, 0, sizeof *a);
}
