/* advance: see advance.h */
#include "transport/advance.h"
#include "core/owner.h"
#include "core/par.h"
#include "solve/sdirk.h"
#include <math.h>
#include <string.h>

/* Step control: the largest change from one step to the next. */
#define PDI_ADVANCE_GROWTH 4.0
#define PDI_ADVANCE_SHRINK 0.1
#define PDI_ADVANCE_TRIALS 200 /* rejected steps in a row */

PDI_FN void pdi_advance_list(pdi_owner *owner, void *object)
{
    pd_advance *advance = (pd_advance *)object;
    int64_t total = advance->transport ? advance->transport->grid->total : 0;
    PDI_ARRAY(owner, advance, start, total, "mol/m3");
    PDI_ARRAY(owner, advance, carry, total, "mol/m3");
    PDI_ARRAY(owner, advance, slope, total, "mol/m3");
    PDI_ARRAY(owner, advance, rest, total, "mol/m3");
    PDI_VALUE(owner, advance, time, "s");
    PDI_VALUE(owner, advance, dt, "s");
    PDI_VALUE(owner, advance, error, "1");
    PDI_VALUE(owner, advance, out, "mol");
    PDI_VALUE(owner, advance, in, "mol");
    PDI_VALUE(owner, advance, steps, "1");
    PDI_VALUE(owner, advance, rejected, "1");
    PDI_VALUE(owner, advance, krylov, "1");
    PDI_VALUE(owner, advance, euler, "1");
}

static pd_status pdi_advance_make(pd_ctx *ctx, pd_transport *transport, const pd_advance_desc *desc, pd_advance *a)
{
    memset(a, 0, sizeof *a);
    a->desc = *desc;
    if (!(desc->rtol >= 0.0) || !(desc->first >= 0.0) || !(desc->largest >= 0.0) ||
        !(desc->rtol + desc->first + desc->largest < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "advance",
                        "rtol %g, first %g s, largest %g s: expected finite values of at least 0", desc->rtol,
                        desc->first, desc->largest);
    if (!(a->desc.rtol > 0.0)) a->desc.rtol = 1e-3;
    a->transport = transport;
    return pdi_owner_build(ctx, pdi_advance_list, a);
}

pd_status pd_advance_build(pd_ctx *ctx, pd_transport *transport, const pd_advance_desc *desc, pd_advance *a)
{
    pd_status status = pdi_advance_make(ctx, transport, desc, a);
    if (status < 0) pd_advance_free(ctx, a);
    return status;
}

static void pdi_advance_restore(const pd_ctx *ctx, pd_advance *a)
{
    pdi_par_copy(ctx, a->transport->grid->total, a->start, a->transport->c);
    pdi_par_copy(ctx, a->transport->grid->total, a->carry, a->transport->carry);
}

/* The change of the first stage, start + carry being where it begins, and with it the start of the second one:
 * start + carry + (1 - gamma)/gamma slope. */
static void pdi_advance_between(pd_advance *a)
{
    pd_transport *t = a->transport;
    double ratio = (1.0 - PDI_SDIRK_GAMMA) / PDI_SDIRK_GAMMA;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        double begin = a->start[i] + a->carry[i];
        a->slope[i] = t->c[i] - begin;
        t->old[i] = begin + ratio * a->slope[i];
        t->carry[i] = 0.0;
    }
}

/* error = gamma dt max |f1 - f2| over the largest concentration (as eq. 4.17), at least *largest, which follows. */
static double pdi_advance_error(const pd_advance *a, double *largest)
{
    const pd_transport *t = a->transport;
    double worst = 0.0, size = *largest;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        worst = fmax(worst, fabs(a->slope[i] - (t->c[i] - t->old[i])));
        size = fmax(size, fmax(fabs(t->c[i]), fabs(a->start[i])));
    }
    *largest = size;
    return size > 0.0 ? worst / size : 0.0;
}

/* A flow and values outside become those of time t. */
static pd_status pdi_advance_at(pd_ctx *ctx, pd_advance *a, double t)
{
    return a->at ? a->at(ctx, a->at_user, t) : pd_transport_at(ctx, a->transport, t);
}

static pd_status pdi_advance_stages(pd_ctx *ctx, pd_advance *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    int32_t total = t->grid->total;
    double g = PDI_SDIRK_GAMMA;
    pdi_par_copy(ctx, total, a->start, t->old);
    PDI_TRY(pdi_advance_at(ctx, a, a->time + g * dt));
    pd_status first = pdi_transport_stage(ctx, t, g * dt, 0, result), status;
    a->krylov += result->krylov;
    if (first < 0) return first;
    double out = (1.0 - g) * t->outflow, in = (1.0 - g) * t->inflow;
    pdi_transport_residual(ctx, t, a->rest);
    pdi_advance_between(a);
    PDI_TRY(pdi_advance_at(ctx, a, a->time + dt));
    status = pdi_transport_stage(ctx, t, g * dt, 0, result);
    a->krylov += result->krylov;
    if (status < 0) return status;
    a->error = pdi_advance_error(a, &a->largest);
    t->outflow = out + g * t->outflow;
    t->inflow = in + g * t->inflow;
    pdi_transport_residual(ctx, t, t->carry);
    for (int32_t i = 0; i < total; i++) t->carry[i] = dt * ((1.0 - g) * a->rest[i] + g * t->carry[i]);
    return first > 0 ? first : status;
}

pd_status pd_advance_step(pd_ctx *ctx, pd_advance *a, double dt, pd_transport_result *result)
{
    pd_transport *t = a->transport;
    int32_t total = t->grid->total;
    memset(result, 0, sizeof *result);
    if (!(dt > 0.0) || !(dt < 1e300))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "advance", "the step is %g s, expected a positive one", dt);
    pdi_par_copy(ctx, total, t->c, a->start);
    pdi_par_copy(ctx, total, t->carry, a->carry);
    PDI_TRY(pd_transport_at(ctx, t, a->time));
    pdi_transport_open(t);
    pd_status status = pdi_advance_stages(ctx, a, dt, result);
    if (status >= 0 && !pdi_transport_within(t, a->start)) {
        pdi_advance_restore(ctx, a);
        status = pd_transport_implicit(ctx, t, dt, result);
        a->krylov += result->krylov;
        a->euler++;
    }
    if (status < 0) {
        pdi_advance_restore(ctx, a);
        return status;
    }
    a->out += dt * t->outflow;
    a->in += dt * t->inflow;
    a->time += dt;
    a->steps++;
    return status;
}

/* Take the last step back; time and amounts are the caller's. */
static void pdi_advance_reject(const pd_ctx *ctx, pd_advance *a)
{
    pdi_advance_restore(ctx, a);
    a->steps--;
    a->rejected++;
}

pd_status pd_advance_next(pd_ctx *ctx, pd_advance *a, double t_end, pd_transport_result *result)
{
    if (!(t_end > a->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "advance", "a step from %g s to %g s", a->time, t_end);
    if (!(a->dt > 0.0)) a->dt = a->desc.first > 0.0 ? a->desc.first : t_end - a->time;
    a->largest = 0.0; /* what longer trials have met counts: a field that begins with nothing has no size of its own */
    for (int trial = 0; trial < PDI_ADVANCE_TRIALS; trial++) {
        int last;
        double begin = a->time, out = a->out, in = a->in;
        double dt = pdi_sdirk_clip(a->dt, a->desc.largest, t_end - begin, &last);
        if (pdi_stands_still(begin, t_end - begin, dt)) break;
        pd_status status = pd_advance_step(ctx, a, dt, result);
        if (status < 0) return status;
        double share = a->error / a->desc.rtol;
        double factor = pdi_sdirk_factor(share, PDI_ADVANCE_GROWTH);
        if (share <= 1.0) {
            if (last) a->time = t_end;
            a->dt = pdi_sdirk_plan(a->dt, dt, factor);
            return status;
        }
        pdi_advance_reject(ctx, a);
        a->time = begin;
        a->out = out;
        a->in = in;
        a->dt = dt * fmax(PDI_ADVANCE_SHRINK, factor);
    }
    return pdi_fail(ctx, PD_ERR_STATE, "advance",
                    "the error of a step of %g s at t = %g s is %g, expected it to fall with the step", a->dt, a->time,
                    a->error);
}

pd_status pd_advance_run(pd_ctx *ctx, pd_advance *a, double t_end, pd_transport_result *result)
{
    if (!(t_end >= a->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "advance", "a run from %g s to %g s", a->time, t_end);
    pd_status worst = PD_OK;
    while (a->time < t_end) {
        PDI_TRY(pdi_poll(ctx, "transport in time", a->steps));
        pd_status status = pd_advance_next(ctx, a, t_end, result);
        if (status < 0) return status;
        if (status > 0) worst = status;
    }
    return worst;
}

PDI_FN pd_status pdi_advance_store(pd_ctx *ctx, pd_advance *a, pd_archive *archive)
{
    return pdi_owner_store(ctx, pdi_advance_list, a, archive);
}

void pd_advance_free(pd_ctx *ctx, pd_advance *a)
{
    pdi_owner_free(ctx, pdi_advance_list, a);
    memset(a, 0, sizeof *a);
}
