/* implicit: see implicit.h */
#include "flow/implicit.h"
#include "flow/pressure_impulse.h"
#include "core/par.h"
#include "solve/sdirk.h"
#include <math.h>
#include <string.h>

#define PDI_IMPLICIT_STAGE_TOLERANCE 1e-3 /* [-] default tolerance of the stages over that of a step */
#define PDI_IMPLICIT_MIN_STEP 1e-12       /* [-] shortest step over the first one: below it the run fails */
/* Weight of the pressure flux beside the pressure impulse of a start (eq. 3.42). What it leaves of the divergence is
 * this part of the error that the lattice makes in the impulse. */
#define PDI_IMPLICIT_START_IMPULSE 1e-2

PDI_COLD_BEGIN
PDI_FN void pdi_implicit_list(pdi_array_visitor *owner, void *object)
{
    pd_implicit *implicit = (pd_implicit *)object;
    int64_t total = implicit->flow ? implicit->flow->grid->total : 0;
    PDI_ARRAY(owner, implicit, start_state, (PD_DIM + 2) * total, "");
    PDI_ARRAY_STATE(owner, implicit, stage_target, PD_DIM * total, "m/s");
    PDI_ARRAY_STATE(owner, implicit, pressure_impulse, total, "m2/s");
    PDI_ARRAY(owner, implicit, pressure_impulse_grad, PD_DIM * total, "m/s");
    PDI_ARRAY(owner, implicit, pressure_impulse_flux, total, "1/s");
    PDI_SCALAR_STATE(owner, implicit, time, "s");
    PDI_SCALAR_STATE(owner, implicit, dt, "s");
    PDI_SCALAR_STATE(owner, implicit, error, "1");
    PDI_SCALAR_STATE(owner, implicit, has_new_fluid, "1");
    PDI_SCALAR_STATE(owner, implicit, last_step, "s");
    PDI_SCALAR_STATE(owner, implicit, steps, "1");
    PDI_SCALAR_STATE(owner, implicit, rejected, "1");
    PDI_SCALAR_STATE(owner, implicit, evaluations, "1");
}

/* Lists the scratch arrays of a step, which an arena lends, beside those of the steady solver. */
static void pdi_implicit_list_work(pdi_array_visitor *owner, void *object)
{
    pd_implicit *implicit = (pd_implicit *)object;
    int64_t total = implicit->flow ? implicit->flow->grid->total : 0;
    PDI_ARRAY(owner, implicit, stage_increment, PD_DIM * total, "m/s");
}

PDI_FN size_t pdi_implicit_count_work_bytes(pd_implicit *im)
{
    return pdi_arena_count_bytes(pdi_implicit_list_work, im);
}

/* Inner part of the build: checks desc, sets defaults, raises U, prepares steady, allocates, lends the pressure impulse
 * to the flow. The caller frees after an error. */
static pd_status pdi_implicit_try_build(pd_ctx *ctx, pd_flow *flow, pd_steady *steady, const pd_implicit_desc *desc,
                                        pd_implicit *im)
{
    memset(im, 0, sizeof *im);
    im->desc = *desc;
    if (!(desc->stage_tolerance >= 0.0) || !(desc->rtol >= 0.0) || !(desc->first_step >= 0.0) ||
        !(desc->max_step >= 0.0) || !(desc->stage_tolerance + desc->rtol + desc->first_step + desc->max_step < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "implicit",
                       "tolerance %g, rtol %g, first %g s, largest %g s: expected finite values of at least 0",
                       desc->stage_tolerance, desc->rtol, desc->first_step, desc->max_step);
    pdi_flow_update_speed_scale(flow);
    if (!(im->desc.rtol > 0.0)) im->desc.rtol = 1e-4;
    if (!(im->desc.stage_tolerance > 0.0)) im->desc.stage_tolerance = PDI_IMPLICIT_STAGE_TOLERANCE * im->desc.rtol;
    if (!(im->desc.first_step > 0.0))
        im->desc.first_step =
            1e-3 / (flow->velocity_scale / flow->length_scale + flow->nu / (flow->length_scale * flow->length_scale));
    im->flow = flow;
    im->steady = steady;
    PD_TRY(pdi_steady_build_stages(ctx, steady, pdi_implicit_count_work_bytes(im)));
    PD_TRY(pdi_array_registry_build(ctx, pdi_implicit_list, im));
    flow->pressure_impulse = im->pressure_impulse;
    flow->pressure_impulse_grad = im->pressure_impulse_grad;
    flow->pressure_impulse_flux = im->pressure_impulse_flux;
    return PD_OK;
}

pd_status pd_implicit_build(pd_ctx *ctx, pd_flow *flow, pd_steady *steady, const pd_implicit_desc *desc,
                            pd_implicit *im)
{
    pd_status status = pdi_implicit_try_build(ctx, flow, steady, desc, im);
    if (status < 0) pd_implicit_free(ctx, im);
    return status;
}
PDI_COLD_END

/* Copies velocity, pressure and pressure impulse of the flow to start_state. */
static void pdi_implicit_copy_to_start(const pd_ctx *ctx, pd_implicit *im)
{
    int64_t total = im->flow->grid->total, split = PD_DIM * total;
    pdi_par_copy(ctx, split, im->flow->u, im->start_state);
    pdi_par_copy(ctx, total, im->flow->p, im->start_state + split);
    pdi_par_copy(ctx, total, im->pressure_impulse, im->start_state + split + total);
}

/* Copies velocity, pressure and pressure impulse from start_state back to the flow, and updates the pressure flux of
 * the impulse; no stage is solved then (stage_weight 0). */
static void pdi_implicit_copy_from_start(const pd_ctx *ctx, pd_implicit *im)
{
    int64_t total = im->flow->grid->total, split = PD_DIM * total;
    pdi_par_copy(ctx, split, im->start_state, im->flow->u);
    pdi_par_copy(ctx, total, im->start_state + split, im->flow->p);
    pdi_par_copy(ctx, total, im->start_state + split + total, im->pressure_impulse);
    pdi_pressure_impulse_update_flux(ctx, im->flow, 1.0, 0.0);
}

/* Solves a stage R(u) + rate (u - target) = 0, rate [1/s]. impulse_factor [-], pressure_weight [s]: the pressure
 * impulse at its end is impulse_factor times the present one plus pressure_weight times (p - p_out). It is updated only
 * when the stage has converged. Adds to im->evaluations. PD_RETRY: not converged, the flow holds no solution. */
static pd_status pdi_implicit_solve_stage_equation(pd_ctx *ctx, pd_implicit *im, double rate, const double *target,
                                                   double impulse_factor, double pressure_weight)
{
    pd_steady_result result;
    pd_flow *flow = im->flow;
    pdi_pressure_impulse_update_flux(ctx, flow, impulse_factor, pressure_weight);
    pd_status status = pdi_steady_newton_solve_stage(ctx, im->steady, rate, target, im->desc.stage_tolerance, &result);
    im->evaluations += result.evaluations;
    if (status == PD_OK) pdi_pressure_impulse_update(flow, impulse_factor, pressure_weight);
    return status;
}

/* Solves a stage of a time step, R(u) + rate (u - target) = 0, with the pressure impulse I of dI/dt = p - I/tau by
 * backward Euler (eq. 3.43). */
static pd_status pdi_implicit_solve_time_stage(pd_ctx *ctx, pd_implicit *im, double rate, const double *target)
{
    double tau = im->flow->stabilisation, weight = tau / (1.0 + tau * rate);
    return pdi_implicit_solve_stage_equation(ctx, im, rate, target, weight * rate, weight);
}

/* The stage at time + c dt of an SDIRK step, with the boundary data of that time. */
static pd_status pdi_implicit_solve_sdirk_stage(pd_ctx *ctx, pd_implicit *im, double dt, double c, const double *target)
{
    PD_TRY(pdi_flow_set_time(ctx, im->flow, im->time + c * dt, 0.5 * PDI_SDIRK_GAMMA * dt, NULL));
    return pdi_implicit_solve_time_stage(ctx, im, 1.0 / (PDI_SDIRK_GAMMA * dt), target);
}

/* Projects a start that violates continuity or the inlets onto the nearest velocity that does not: u + G q = u0, by a
 * stage so short that friction and convection are below its tolerance (eq. 3.42). q is the pressure impulse; the
 * pressure stays. Nothing, unless fluid is new, or no step is done and the start is not yet projected. Overwrites
 * start_state; after a failure the state is restored. Success clears has_new_fluid. */
static pd_status pdi_implicit_project_start(pd_ctx *ctx, pd_implicit *im)
{
    pd_flow *flow = im->flow;
    int64_t total = flow->grid->total;
    double rate = 1.0 / (im->desc.stage_tolerance * flow->stabilisation);
    if (!im->has_new_fluid && (im->steps > 0 || im->projected)) return PD_OK;
    pdi_implicit_copy_to_start(ctx, im);
    pd_status status =
        pdi_implicit_solve_stage_equation(ctx, im, rate, im->start_state, 0.0, PDI_IMPLICIT_START_IMPULSE / rate);
    if (status != PD_OK) {
        pdi_implicit_copy_from_start(ctx, im);
        return status;
    }
    pdi_par_copy(ctx, total, im->start_state + PD_DIM * total, flow->p);
    im->projected = 1;
    im->has_new_fluid = 0;
    return status;
}

/* Embedded error estimate [-]: gamma dt max |f1 - f2|/U over components at fluid nodes, the distance to the first-order
 * step with f1 alone; stage_increment = gamma dt f1, u - stage_target = gamma dt f2. */
static double pdi_implicit_estimate_error(pd_implicit *im)
{
    const pd_flow *flow = im->flow;
    double worst = 0.0;
    for (int32_t i = 0; i < flow->grid->total; i++) {
        if (flow->grid->kind[i] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = (int64_t)d * flow->grid->total + i;
            worst = pd_max(worst, fabs(im->stage_increment[at] - (flow->u[at] - im->stage_target[at])));
        }
    }
    return worst / flow->velocity_scale;
}

/* First guess of the first stage, in flow->u: extrapolated from start_state by the time derivative at the end of the
 * last step, (u - u*)/(gamma dt). Nothing when last_step is 0; else last_step becomes 0. */
static void pdi_implicit_extrapolate_velocity(const pd_ctx *ctx, pd_implicit *im, double dt)
{
    int64_t split = PD_DIM * (int64_t)im->flow->grid->total;
    if (!(im->last_step > 0.0)) return;
    pdi_par_axpy(ctx, split, dt / im->last_step, im->start_state, im->flow->u);
    pdi_par_axpy(ctx, split, -dt / im->last_step, im->stage_target, im->flow->u);
    im->last_step = 0.0;
}

/* Both SDIRK stages from start_state, and the error estimate into im->error. stage_increment and stage_target are those
 * of this step then. After a failure the flow holds no solution. */
static pd_status pdi_implicit_solve_stages(pd_ctx *ctx, pd_implicit *im, double dt)
{
    pd_flow *flow = im->flow;
    int64_t total = flow->grid->total, split = PD_DIM * total;
    double ratio = (1.0 - PDI_SDIRK_GAMMA) / PDI_SDIRK_GAMMA;
    pd_status status = pdi_implicit_solve_sdirk_stage(ctx, im, dt, PDI_SDIRK_GAMMA, im->start_state);
    if (status != PD_OK) return status;
    pdi_par_copy(ctx, split, flow->u, im->stage_increment);
    pdi_par_axpy(ctx, split, -1.0, im->start_state, im->stage_increment);
    pdi_par_copy(ctx, split, im->start_state, im->stage_target);
    pdi_par_axpy(ctx, split, ratio, im->stage_increment, im->stage_target);
    pdi_par_axpy(ctx, split, ratio, im->stage_increment, flow->u); /* a first guess */
    pdi_par_axpy(ctx, total, ratio - 1.0, im->pressure_impulse, im->pressure_impulse);
    pdi_par_axpy(ctx, total, 1.0 - ratio, im->start_state + split + total, im->pressure_impulse);
    status = pdi_implicit_solve_sdirk_stage(ctx, im, dt, 1.0, im->stage_target);
    if (status == PD_OK) im->error = pdi_implicit_estimate_error(im);
    return status;
}

/* A step while the scratch memory is lent. After a failure state and pressure impulse are restored (to the projected
 * start, if the projection has converged), and so are time and boundary data, but walls have no acceleration. Fatal
 * statuses, PD_ERR_ARGUMENT and PD_ERR_INTERNAL are returned as they are, all others as PD_RETRY. */
static pd_status pdi_implicit_try_step(pd_ctx *ctx, pd_implicit *im, double dt)
{
    double start = im->flow->time;
    pd_status status = pdi_implicit_project_start(ctx, im);
    pdi_implicit_copy_to_start(ctx, im);
    pdi_implicit_extrapolate_velocity(ctx, im, dt);
    if (status == PD_OK) status = pdi_implicit_solve_stages(ctx, im, dt);
    if (status == PD_OK) {
        pdi_pressure_impulse_update_flux(ctx, im->flow, 1.0, 0.0);
        return PD_OK;
    }
    pdi_implicit_copy_from_start(ctx, im);
    PD_TRY(pdi_flow_set_time(ctx, im->flow, start, 0.0, NULL));
    if (pd_is_fatal(status) || status == PD_ERR_ARGUMENT || status == PD_ERR_INTERNAL) return status;
    pd_fail(ctx, PD_RETRY, "implicit", "a stage of a step of %g s at t = %g s does not converge", dt, im->time);
    return PD_RETRY;
}

pd_status pd_implicit_step(pd_ctx *ctx, pd_implicit *im, double dt)
{
    pd_arena *arena = pdi_steady_get_arena(im->steady);
    if (!(dt > 0.0) || !(dt < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "implicit", "the step is %g s, expected a positive one", dt);
    if (!im->steps) pdi_flow_update_speed_scale(im->flow); /* the caller may have set it after the build */
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_implicit_list_work, im));
    pd_status status = pdi_steady_begin_solves(ctx, im->steady);
    if (status == PD_OK) status = pdi_steady_end_solves(ctx, im->steady, pdi_implicit_try_step(ctx, im, dt));
    status = pdi_arena_release(ctx, arena, pdi_implicit_list_work, im, status);
    if (status != PD_OK) return status;
    im->last_step = dt;
    im->time += dt;
    im->steps++;
    return PD_OK;
}

PDI_COLD_BEGIN
/* Undoes the last accepted step: state, boundary data and derived fields become those of im->time; counts it as
 * rejected. */
static pd_status pdi_implicit_undo_step(pd_ctx *ctx, pd_implicit *im)
{
    pdi_implicit_copy_from_start(ctx, im);
    im->last_step = 0.0;
    im->steps--;
    im->rejected++;
    PD_TRY(pdi_flow_set_time(ctx, im->flow, im->time, 0.0, NULL));
    pdi_flow_update_derived_fields(ctx, im->flow);
    return PD_OK;
}

/* Process callback after a rejected attempt: undoes it and proposes a shorter step. s->error is infinite when it did
 * not converge; then there is nothing to undo. PD_ERR_STATE: the rejected step was at most 1e-12 of first_step. */
static pd_status pdi_implicit_reject_step(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_implicit *im = (pd_implicit *)self;
    char place[PDI_GRID_POSITION_LENGTH];
    int solved = s->error < HUGE_VAL;
    double dt = s->dt;
    im->time = s->time;
    if (solved) PD_TRY(pdi_implicit_undo_step(ctx, im));
    pdi_sdirk_reject(&im->dt, im->desc.max_step, s);
    if (dt > PDI_IMPLICIT_MIN_STEP * im->desc.first_step) return PD_OK;
    if (solved)
        return pd_fail(ctx, PD_ERR_STATE, "implicit",
                       "the error of a step of %g s at t = %g s is %g and does not fall with the step, expected %g: "
                       "loosen rtol, or look for an inlet or wall that jumps in time", dt, im->time, im->error,
                       im->desc.rtol);
    return pd_fail(ctx, PD_ERR_STATE, "implicit",
                   "steps down to %g s at t = %g s do not converge, the residual is largest at %s m: loosen rtol (%g),"
                   " refine the lattice or lower the speed",
                   dt, im->time, pdi_grid_format_position(im->flow->grid, im->steady->worst_node, place),
                   im->desc.rtol);
}

/* ---- the process ---- */

/* Process callback at the start of a run: updates the derived fields of the flow. */
static pd_status pdi_implicit_begin(pd_ctx *ctx, void *self, double t)
{
    (void)t;
    pdi_flow_update_derived_fields(ctx, ((pd_implicit *)self)->flow);
    return PD_OK;
}

/* Step [s] that is tried next: dt, or first_step where that is not known yet. */
static double pdi_implicit_get_next_step(const pd_implicit *im) { return im->dt > 0.0 ? im->dt : im->desc.first_step; }

/* Process callback: lowers s->dt to the next step of the flow and to the limit of the run [s]. Other processes see the
 * flow at the ends of steps as long as its own. */
static pd_status pdi_implicit_limit_outer_step(pd_ctx *ctx, void *self, pd_step *s)
{
    s->dt = pd_min(s->dt, pdi_implicit_get_next_step((const pd_implicit *)self));
    return pdi_physics_limit_max_step(ctx, self, s);
}

/* Process callback: next inner step [s], clipped to the end of the outer one. */
static pd_status pdi_implicit_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_implicit *im = (pd_implicit *)self;
    (void)ctx;
    im->dt = pdi_implicit_get_next_step(im);
    pdi_sdirk_limit(im->dt, im->desc.max_step, s);
    return PD_OK;
}

/* Process callback: tries one step. PD_RETRY: it did not converge, or its error exceeds rtol. */
static pd_status pdi_implicit_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_implicit *im = (pd_implicit *)self;
    pd_status status = pd_implicit_step(ctx, im, s->dt);
    s->error = status == PD_OK ? im->error / im->desc.rtol : HUGE_VAL;
    return status < 0 || !(s->error > 1.0) ? status : PD_RETRY;
}

/* Process callback: sets the time and plans the next step by the error of the last one. */
static pd_status pdi_implicit_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_implicit *im = (pd_implicit *)self;
    (void)ctx;
    im->time = s->end;
    pdi_sdirk_accept(&im->dt, s);
    return PD_OK;
}

/* Process callback: fails with a message, since steps have become too short for the time to advance. */
static pd_status pdi_implicit_fail_step_underflow(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_implicit *im = (const pd_implicit *)self;
    return pd_fail(ctx, PD_ERR_STATE, "implicit",
                   "steps of %g s do not lead on from t = %g s to %g s: loosen rtol (%g) or take a longer largest "
                   "step (%g s, 0: none)",
                   s->dt, s->time, s->latest_end, im->desc.rtol, im->desc.max_step);
}

/* Process callback after the last inner step: makes the fluxes for transport free of divergence. */
static pd_status pdi_implicit_end(pd_ctx *ctx, void *self, double t)
{
    (void)t;
    return pdi_steady_update_divergence_potential(ctx, ((pd_implicit *)self)->steady);
}

/* Projects the velocity after a change of geometry, and solves for its pressure by a stage as short as the first step,
 * which replaces the velocity, too. If that stage fails the projected state is restored, with the old pressure. Returns
 * the status of what failed. */
static pd_status pdi_implicit_project_new_fluid(pd_ctx *ctx, pd_implicit *im)
{
    pd_status status = pdi_implicit_project_start(ctx, im);
    if (status != PD_OK) return status;
    pdi_implicit_copy_to_start(ctx, im);
    status = pdi_implicit_solve_time_stage(ctx, im, 1.0 / im->desc.first_step, im->start_state);
    if (status == PD_OK) pdi_pressure_impulse_update_flux(ctx, im->flow, 1.0, 0.0);
    else pdi_implicit_copy_from_start(ctx, im);
    return status;
}

/* Process callback: nodes `converted` have become fluid. New families make the velocity divergent, which would be an
 * error of the next step however short, so it is projected. A projection that does not converge is no error: the next
 * step tries again. Fatal statuses, PD_ERR_ARGUMENT and PD_ERR_INTERNAL are returned. Updates derived fields and
 * divergence potential. */
static pd_status pdi_implicit_update_geometry(pd_ctx *ctx, void *self, const int32_t *converted, int32_t count)
{
    pd_implicit *im = (pd_implicit *)self;
    pd_arena *arena = pdi_steady_get_arena(im->steady);
    im->last_step = 0.0;
    im->has_new_fluid = 1;
    PD_TRY(pd_flow_update(ctx, converted, count, im->flow));
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_implicit_list_work, im));
    pd_status status = pdi_steady_begin_solves(ctx, im->steady);
    if (status == PD_OK) status = pdi_steady_end_solves(ctx, im->steady, pdi_implicit_project_new_fluid(ctx, im));
    status = pdi_arena_release(ctx, arena, pdi_implicit_list_work, im, status);
    if (pd_is_fatal(status) || status == PD_ERR_ARGUMENT || status == PD_ERR_INTERNAL) return status;
    pdi_flow_update_derived_fields(ctx, im->flow);
    return pdi_steady_update_divergence_potential(ctx, im->steady); /* fluxes through the families that are new */
}

/* Process callback: writes or reads the checkpoint of flow, solver and integrator. */
static pd_status pdi_implicit_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_implicit *im = (pd_implicit *)self;
    PD_TRY(pdi_flow_store(ctx, im->flow, archive));
    PD_TRY(pdi_steady_store(ctx, im->steady, archive));
    PD_TRY(pdi_array_registry_store(ctx, pdi_implicit_list, im, archive));
    if (archive->is_reading) pdi_pressure_impulse_update_flux(ctx, im->flow, 1.0, 0.0);
    return PD_OK;
}

pd_physics pd_implicit_process(pd_implicit *im)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "flow in time";
    p.self = im;
    p.time = &im->time;
    p.has_substeps = 1;
    p.steps = &im->steps;
    p.start = pdi_implicit_begin;
    p.max_run_step = pdi_implicit_limit_outer_step;
    p.limit = pdi_implicit_limit;
    p.attempt = pdi_implicit_attempt;
    p.accept = pdi_implicit_accept;
    p.reject = pdi_implicit_reject_step;
    p.report_underflow = pdi_implicit_fail_step_underflow;
    p.finish = pdi_implicit_end;
    p.nodes_converted = pdi_implicit_update_geometry;
    p.checkpoint = pdi_implicit_store;
    return p;
}

void pd_implicit_free(pd_ctx *ctx, pd_implicit *im)
{
    if (im->flow) im->flow->pressure_impulse = im->flow->pressure_impulse_grad = im->flow->pressure_impulse_flux = NULL;
    pdi_array_registry_free(ctx, pdi_implicit_list, im);
    memset(im, 0, sizeof *im);
}
PDI_COLD_END
