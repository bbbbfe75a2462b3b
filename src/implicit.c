/* implicit: see implicit.h */
#include "implicit.h"
#include "par.h"
#include "sdirk.h"
#include <math.h>
#include <string.h>

/* Step control: the largest change of one step to the next. */
#define PDI_IMPLICIT_GROWTH 3.0
/* Share of its error that a step keeps when it is made shorter and the error is none of the step. */
#define PDI_IMPLICIT_JUMP 0.95
#define PDI_IMPLICIT_SHRINK 0.2
/* Default tolerance of the stages over that of a step. */
#define PDI_IMPLICIT_STAGE 1e-3
#define PDI_IMPLICIT_SMALLEST 1e-12

pd_status pd_implicit_build(pd_ctx *ctx, pd_flow *flow, pd_steady *steady, const pd_implicit_desc *desc,
                            pd_implicit *im)
{
    int64_t total = flow->grid->total;
    memset(im, 0, sizeof *im);
    im->desc = *desc;
    if (!(desc->tolerance >= 0.0) || !(desc->rtol >= 0.0) || !(desc->first >= 0.0) || !(desc->largest >= 0.0) ||
        !(desc->tolerance + desc->rtol + desc->first + desc->largest < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "implicit",
                        "tolerance %g, rtol %g, first %g s, largest %g s: expected finite values of at least 0",
                        desc->tolerance, desc->rtol, desc->first, desc->largest);
    if (!(im->desc.rtol > 0.0)) im->desc.rtol = 1e-4;
    if (!(im->desc.tolerance > 0.0)) im->desc.tolerance = PDI_IMPLICIT_STAGE * im->desc.rtol;
    if (!(im->desc.first > 0.0)) im->desc.first = 1e-3 * flow->length / flow->speed;
    im->flow = flow;
    im->steady = steady;
    PDI_TRY(PDI_NEW(ctx, "implicit", (PD_DIM + 1) * total, im->start));
    PDI_TRY(PDI_NEW(ctx, "implicit", PD_DIM * total, im->target));
    return PDI_NEW(ctx, "implicit", PD_DIM * total, im->slope);
}

static pd_status pdi_implicit_stage(pd_ctx *ctx, pd_implicit *im, double dt, const double *target, int again)
{
    pd_steady_result result;
    pd_status status = pdi_steady_stage(ctx, im->steady, 1.0 / (PDI_SDIRK_GAMMA * dt), target, im->desc.tolerance,
                                        again, &result);
    im->evaluations += result.evaluations;
    return status;
}

/* error = gamma dt max |f1 - f2| / U, the distance to the step of first order with f1 alone, from `slope` = gamma dt f1
 * and u - u* = gamma dt f2. The start may break continuity or a boundary condition, which is no error of the step, so
 * that two equal estimates count less than their sum. */
static double pdi_implicit_error(pd_implicit *im)
{
    const pd_flow *flow = im->flow;
    double worst = 0.0;
    for (int32_t i = 0; i < flow->grid->total; i++) {
        if (flow->grid->kind[i] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = (int64_t)d * flow->grid->total + i;
            worst = fmax(worst, fabs(im->slope[at] - (flow->u[at] - im->target[at])));
        }
    }
    return worst / flow->speed;
}

/* First guess of the first stage: along the slope at the end of the last step, which is (u - u*)/(gamma dt) there. */
static void pdi_implicit_extrapolate(const pd_ctx *ctx, pd_implicit *im, double dt)
{
    int64_t split = PD_DIM * (int64_t)im->flow->grid->total;
    if (!(im->last > 0.0)) return;
    pdi_par_axpy(ctx, split, dt / im->last, im->start, im->flow->u);
    pdi_par_axpy(ctx, split, -dt / im->last, im->target, im->flow->u);
    im->last = 0.0;
}

pd_status pd_implicit_step(pd_ctx *ctx, pd_implicit *im, double dt)
{
    pd_flow *flow = im->flow;
    int64_t total = flow->grid->total, split = PD_DIM * total;
    double ratio = (1.0 - PDI_SDIRK_GAMMA) / PDI_SDIRK_GAMMA;
    if (!(dt > 0.0) || !(dt < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "implicit", "the step is %g s, expected a positive one", dt);
    pdi_par_copy(ctx, split, flow->u, im->start);
    pdi_par_copy(ctx, total, flow->p, im->start + split);
    pdi_implicit_extrapolate(ctx, im, dt);
    pd_status status = pdi_implicit_stage(ctx, im, dt, im->start, 0);
    if (status == PD_OK) {
        pdi_par_copy(ctx, split, flow->u, im->slope);
        pdi_par_axpy(ctx, split, -1.0, im->start, im->slope);
        pdi_par_copy(ctx, split, im->start, im->target);
        pdi_par_axpy(ctx, split, ratio, im->slope, im->target);
        pdi_par_axpy(ctx, split, ratio, im->slope, flow->u); /* a first guess */
        status = pdi_implicit_stage(ctx, im, dt, im->target, 1);
    }
    if (status != PD_OK) {
        pdi_par_copy(ctx, split, im->start, flow->u);
        pdi_par_copy(ctx, total, im->start + split, flow->p);
        if (pdi_lacks_memory(status)) return status;
        pdi_fail(ctx, PD_RETRY, "implicit", "a stage of a step of %g s at t = %g s does not converge", dt, im->time);
        return PD_RETRY;
    }
    im->error = pdi_implicit_error(im);
    im->last = dt;
    im->time += dt;
    im->steps++;
    return PD_OK;
}

/* The last step was too coarse: back to its start. */
static void pdi_implicit_reject(const pd_ctx *ctx, pd_implicit *im, double dt)
{
    int64_t total = im->flow->grid->total, split = PD_DIM * total;
    pdi_par_copy(ctx, split, im->start, im->flow->u);
    pdi_par_copy(ctx, total, im->start + split, im->flow->p);
    im->last = 0.0;
    im->time -= dt;
    im->steps--;
    im->rejected++;
}

pd_status pd_implicit_run(pd_ctx *ctx, pd_implicit *im, double t_end)
{
    if (!(t_end >= im->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "implicit", "a run from %g s to %g s", im->time, t_end);
    if (!(im->dt > 0.0)) im->dt = im->desc.first;
    double before = 0.0; /* error of a longer step from the same start */
    while (im->time < t_end) {
        int last;
        double begin = im->time, dt = pdi_sdirk_clip(im->dt, im->desc.largest, t_end - begin, &last);
        pd_status status = pd_implicit_step(ctx, im, dt);
        if (status < 0) return status;
        double share = status == PD_OK ? im->error / im->desc.rtol : 25.0;
        double factor = pdi_sdirk_factor(share, PDI_IMPLICIT_GROWTH);
        /* A start that breaks continuity or a boundary condition jumps in its first step, however short that is. */
        int jump = status == PD_OK && im->steps == 1 && before > 0.0 && im->error > PDI_IMPLICIT_JUMP * before;
        before = status == PD_OK ? im->error : 0.0;
        if (jump) factor = 1.0;
        if (share > 1.0 && !jump && dt > PDI_IMPLICIT_SMALLEST * im->desc.first) {
            if (status == PD_OK) pdi_implicit_reject(ctx, im, dt);
            im->time = begin;
            im->dt = dt * fmax(PDI_IMPLICIT_SHRINK, factor);
            continue;
        }
        if (status != PD_OK)
            return pdi_fail(ctx, PD_ERR_STATE, "implicit", "steps down to %g s at t = %g s do not converge", dt,
                            im->time);
        if (last) im->time = t_end;
        im->dt = pdi_sdirk_plan(im->dt, dt, factor);
    }
    return PD_OK;
}

PDI_FN pd_status pdi_implicit_store(pd_ctx *ctx, pd_implicit *im, pd_store *store)
{
    PDI_TRY(PDI_STORE(ctx, store, "implicit.time", &im->time, 1));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.dt", &im->dt, 1));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.error", &im->error, 1));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.last", &im->last, 1));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.target", im->target, (int64_t)PD_DIM * im->flow->grid->total));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.steps", &im->steps, 1));
    PDI_TRY(PDI_STORE(ctx, store, "implicit.rejected", &im->rejected, 1));
    return PDI_STORE(ctx, store, "implicit.evaluations", &im->evaluations, 1);
}

void pd_implicit_free(pd_ctx *ctx, pd_implicit *im)
{
    int64_t total = im->flow ? im->flow->grid->total : 0;
    PDI_DELETE(ctx, (PD_DIM + 1) * total, im->start);
    PDI_DELETE(ctx, PD_DIM * total, im->target);
    PDI_DELETE(ctx, PD_DIM * total, im->slope);
    memset(im, 0, sizeof *im);
}
