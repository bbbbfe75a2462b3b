/* weakly_compressible: see weakly_compressible.h */
#include "flow/weakly_compressible.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

#define PDI_WEAKLY_COMPRESSIBLE_MAX_HALVINGS 20 /* most halvings of a step that leaves the admissible range */

/* Kinematic pressure p/rho0 [m2/s2] of rho/rho0 by the equation of state (eq. 3.35). */
static double pdi_weakly_compressible_compute_pressure(const pd_weakly_compressible_desc *d, double density)
{
    double c2 = d->sound_speed * d->sound_speed;
    if (d->eos == PD_EOS_LINEAR) return c2 * (density - 1.0);
    return c2 / d->gamma * (pow(density, d->gamma) - 1.0);
}

/* Density rho/rho0 [-] of a kinematic pressure [m2/s2] by the equation of state; NaN or not positive where the pressure
 * is too negative to have one. */
static double pdi_weakly_compressible_compute_density(const pd_weakly_compressible_desc *d, double pressure)
{
    double c2 = d->sound_speed * d->sound_speed;
    if (d->eos == PD_EOS_LINEAR) return 1.0 + pressure / c2;
    return pow(1.0 + d->gamma * pressure / c2, 1.0 / d->gamma);
}

PDI_COLD_BEGIN
PDI_FN void pdi_weakly_compressible_list(pdi_array_visitor *owner, void *object)
{
    pd_weakly_compressible *unsteady = (pd_weakly_compressible *)object;
    int64_t total = unsteady->flow ? unsteady->flow->grid->total : 0;
    PDI_ARRAY_STATE(owner, unsteady, density, total, "1");
    PDI_ARRAY(owner, unsteady, momentum, PD_DIM * total, "m/s");
    PDI_ARRAY(owner, unsteady, start_state, (PD_DIM + 1) * total, "");
    PDI_ARRAY(owner, unsteady, time_derivative, (PD_DIM + 1) * total, "");
    PDI_SCALAR_STATE(owner, unsteady, time, "s");
    PDI_SCALAR_STATE(owner, unsteady, steps, "1");
}

/* Inner part of the build: checks desc, sets defaults, density from the pressure at fluid nodes (1 elsewhere), tau of
 * the flow, and the waves of the stability limit. The caller frees after an error. */
static pd_status pdi_weakly_compressible_try_build(pd_ctx *ctx, pd_flow *flow, const pd_weakly_compressible_desc *desc,
                                                   pd_weakly_compressible *un)
{
    const pd_stencil *s = flow->bonds->stencil;
    const pd_grid *grid = flow->grid;
    memset(un, 0, sizeof *un);
    un->desc = *desc;
    if (!(un->desc.gamma > 0.0)) un->desc.gamma = 7.0;
    if (!(un->desc.density_diffusion > 0.0)) un->desc.density_diffusion = 0.1;
    if (!(un->desc.cfl > 0.0)) un->desc.cfl = 0.8;
    if (!(desc->sound_speed > 0.0) || un->desc.gamma < 1.0 || !(desc->gamma >= 0.0) ||
        !(desc->density_diffusion >= 0.0) || !(desc->cfl >= 0.0) ||
        !(desc->sound_speed + desc->gamma + desc->density_diffusion + desc->cfl < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "weakly_compressible",
                       "sound = %g m/s must be positive, gamma = %g at least 1, diffusion = %g and cfl = %g not "
                       "negative, all finite",
                       desc->sound_speed, desc->gamma, desc->density_diffusion, desc->cfl);
    if (flow->order == 4)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "weakly_compressible",
                       "order 4 is one of steady and implicit flow, expected 2");
    un->flow = flow;
    /* the limit is that of the weights of the Laplacian */
    memset(&flow->isotropic_stencil, 0, sizeof flow->isotropic_stencil);
    double spacing = grid->h[0];
    for (int d = 1; d < PD_DIM; d++) spacing = pd_min(spacing, grid->h[d]);
    /* eta c0 delta lap rho, written for the pressure: d rho = rho0 dp/(rho0 c0^2) */
    flow->stabilisation = un->desc.density_diffusion * s->m * spacing / un->desc.sound_speed;
    flow->is_weakly_compressible = 1;
    PD_TRY(pdi_array_registry_build(ctx, pdi_weakly_compressible_list, un));
    for (int32_t i = 0; i < grid->total; i++) {
        un->density[i] = 1.0;
        if (grid->kind[i] == PD_FLUID) un->density[i] = pdi_weakly_compressible_compute_density(&un->desc, flow->p[i]);
        if (!(un->density[i] > 0.0))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "weakly_compressible", "the pressure %g Pa of node %d has no density",
                           flow->p[i] * flow->rho, (int)i);
    }
    return pdi_stability_build(ctx, flow, &un->stability);
}

pd_status pd_weakly_compressible_build(pd_ctx *ctx, pd_flow *flow, const pd_weakly_compressible_desc *desc,
                                       pd_weakly_compressible *un)
{
    pd_status status = pdi_weakly_compressible_try_build(ctx, flow, desc, un);
    if (status < 0) pd_weakly_compressible_free(ctx, un);
    return status;
}
PDI_COLD_END

/* Updates pressure, ghosts, momentum rho v over rho0, advecting velocity and pressure gradient of the flow from
 * velocity and density. Inlet ghosts keep velocity and density: inlets bring fluid of rest density. The advecting
 * velocity is that of the momentum. */
static void pdi_weakly_compressible_update_derived_fields(const pd_ctx *ctx, pd_weakly_compressible *un)
{
    pd_flow *flow = un->flow;
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    const uint8_t *kind = flow->grid->kind;
    int32_t total = flow->grid->total;
    int nt = pd_par_threads(ctx, total * 8);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        if (kind[i] == PD_FLUID) flow->p[i] = pdi_weakly_compressible_compute_pressure(&un->desc, un->density[i]);
    pd_ghosts_set_vector(ghosts, flow->u);
    pdi_ghosts_set_pressure(ghosts, flow->p_out, flow->p);
    pdi_ghosts_set_pressure(ghosts, pdi_weakly_compressible_compute_density(&un->desc, flow->p_out), un->density);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        for (int d = 0; d < PD_DIM; d++)
            un->momentum[(int64_t)d * total + i] = un->density[i] * flow->u[(int64_t)d * total + i];
    pdi_flow_compute_advecting_velocity(ctx, flow, un->momentum, NULL, flow->advecting);
    pdi_flow_compute_pressure_gradient(ctx, flow, flow->p, flow->pressure_grad);
}

/* Sets time_derivative at fluid nodes: of velocity [m/s2] and of density over rho0 [1/s] (eq. 3.36, 3.37), after an
 * update of the derived fields. The bond sums give half of div(rho v v); half of v div(rho v) is taken off to make it
 * rho v.grad v. Counts one evaluation. */
static void pdi_weakly_compressible_compute_rates(const pd_ctx *ctx, pd_weakly_compressible *un)
{
    pd_flow *flow = un->flow;
    const uint8_t *kind = flow->grid->kind;
    int32_t total = flow->grid->total;
    double *ru = un->time_derivative, *rc = un->time_derivative + (int64_t)PD_DIM * total;
    pdi_flow_operands t;
    memset(&t, 0, sizeof t);
    pdi_weakly_compressible_update_derived_fields(ctx, un);
    t.advecting = flow->advecting;
    t.u = flow->u;
    t.p = flow->p;
    t.grad = flow->pressure_grad;
    t.force = flow->force;
    t.wall_motion = flow->wall_motion;
    pdi_flow_assemble_bond_sums(ctx, flow, &t, ru, rc);
    pdi_flow_add_body_force(ctx, flow, ru);
    flow->evaluations++;
    int nt = pd_par_threads(ctx, total * 8);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) {
        if (kind[i] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = (int64_t)d * total + i;
            ru[at] = (0.5 * flow->u[at] * rc[i] - ru[at]) / un->density[i];
        }
        rc[i] = -rc[i];
    }
}

/* One Runge-Kutta stage (Shu and Osher 1988) at fluid nodes: state = start_weight start + (1 - start_weight) (state +
 * dt rate). 1: done; 0: a density is not positive, or it or a velocity component not below 1e100; the state is that
 * after the stage all the same. Derived fields are those before it. */
static int pdi_weakly_compressible_step_stage(const pd_ctx *ctx, pd_weakly_compressible *un, double start_weight,
                                              double dt)
{
    pd_flow *flow = un->flow;
    const uint8_t *kind = flow->grid->kind;
    int32_t total = flow->grid->total;
    int nt = pd_par_threads(ctx, total * 8), good = 1;
    (void)nt;
    pdi_weakly_compressible_compute_rates(ctx, un);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) {
        if (kind[i] != PD_FLUID) continue;
        for (int d = 0; d <= PD_DIM; d++) {
            int64_t at = (int64_t)d * total + i;
            double *x = d < PD_DIM ? &flow->u[at] : &un->density[i];
            *x = start_weight * un->start_state[at] + (1.0 - start_weight) * (*x + dt * un->time_derivative[at]);
        }
    }
    for (int32_t i = 0; i < total && good; i++) {
        if (kind[i] != PD_FLUID) continue;
        good = un->density[i] > 0.0 && un->density[i] < 1e100;
        for (int d = 0; d < PD_DIM; d++) good = good && fabs(flow->u[(int64_t)d * total + i]) < 1e100;
    }
    return good;
}

pd_status pd_weakly_compressible_step(pd_ctx *ctx, pd_weakly_compressible *un, double dt)
{
    static const double old_share[3] = {0.0, 0.75, 1.0 / 3.0}, instant[3] = {0.0, 1.0, 0.5};
    pd_flow *flow = un->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    if (!(dt > 0.0) || !(dt < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "weakly_compressible", "the step is %g s, expected a positive one", dt);
    pdi_par_copy(ctx, split, flow->u, un->start_state);
    pdi_par_copy(ctx, total, un->density, un->start_state + split);
    for (int stage = 0; stage < 3; stage++) {
        pd_status status = pdi_flow_set_time(ctx, flow, un->time + instant[stage] * dt, 0.5 * dt, NULL);
        if (status == PD_OK && pdi_weakly_compressible_step_stage(ctx, un, old_share[stage], dt)) continue;
        pdi_par_copy(ctx, split, un->start_state, flow->u);
        pdi_par_copy(ctx, total, un->start_state + split, un->density);
        pdi_weakly_compressible_update_derived_fields(ctx, un);
        if (status != PD_OK) return status;
        return pd_fail(ctx, PD_RETRY, "weakly_compressible",
                       "a density or velocity left its range in a step of %g s at t = %g s", dt, un->time);
    }
    PD_TRY(pdi_flow_set_time(ctx, flow, un->time + dt, 0.5 * dt, NULL));
    pdi_weakly_compressible_update_derived_fields(ctx, un);
    un->time += dt;
    un->steps++;
    return PD_OK;
}

/* Rounds up to multiples of 1/128, so that a limit is computed again only after such a change, and depends on the state
 * alone. */
static double pdi_weakly_compressible_round_up(double x) { return ceil(128.0 * x) / 128.0; }

/* Upper bounds of the present state, key [PD_DIM+2], rounded up to 1/128: largest sizes of velocity components over c0,
 * at fluid nodes and ghosts; speed of sound over that at rest (linear equation of state: 1); rest density over the
 * lowest density. The last two are at least 1. */
static void pdi_weakly_compressible_compute_bounds(const pd_weakly_compressible *un, double *key)
{
    const pd_grid *grid = un->flow->grid;
    double high = 1.0, low = 1.0;
    for (int d = 0; d < PD_DIM; d++) key[d] = 0.0;
    for (int32_t i = 0; i < grid->total; i++) {
        if (!pdi_grid_is_open(grid->kind[i])) continue;
        for (int d = 0; d < PD_DIM; d++) key[d] = pd_max(key[d], fabs(un->flow->u[(int64_t)d * grid->total + i]));
        if (grid->kind[i] != PD_FLUID) continue;
        high = pd_max(high, un->density[i]);
        low = pd_min(low, un->density[i]);
    }
    for (int d = 0; d < PD_DIM; d++) key[d] = pdi_weakly_compressible_round_up(key[d] / un->desc.sound_speed);
    key[PD_DIM] =
        un->desc.eos == PD_EOS_TAIT ? pdi_weakly_compressible_round_up(pow(high, 0.5 * (un->desc.gamma - 1.0))) : 1.0;
    key[PD_DIM + 1] = pdi_weakly_compressible_round_up(1.0 / low);
}

double pd_weakly_compressible_limit(pd_ctx *ctx, pd_weakly_compressible *un)
{
    double key[PD_DIM + 2], c = un->desc.sound_speed;
    int same = un->limit > 0.0;
    (void)ctx;
    pdi_weakly_compressible_compute_bounds(un, key);
    for (int k = 0; k < PD_DIM + 2; k++)
        same = same && !(key[k] < un->limit_state[k]) && !(key[k] > un->limit_state[k]);
    if (same) return un->limit;
    pdi_stability_state q;
    q.sound_speed = c * key[PD_DIM];
    q.viscosity = un->flow->nu * key[PD_DIM + 1];
    q.stabilisation = un->flow->stabilisation * q.sound_speed * q.sound_speed;
    for (int d = 0; d < PD_DIM; d++) q.max_velocity[d] = c * key[d];
    memcpy(un->limit_state, key, sizeof key);
    un->limit = pdi_stability_compute_limit(&un->stability, &q);
    return un->limit;
}

/* ---- the process ---- */

PDI_COLD_BEGIN
/* Process callback at the start of a run: updates the derived fields of the flow. */
static pd_status pdi_weakly_compressible_begin(pd_ctx *ctx, void *self, double t)
{
    (void)t;
    pdi_flow_update_derived_fields(ctx, ((pd_weakly_compressible *)self)->flow);
    return PD_OK;
}

/* Process callback: s->dt is cfl times the stability limit. */
static pd_status pdi_weakly_compressible_limit_step(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_weakly_compressible *un = (pd_weakly_compressible *)self;
    s->dt = un->desc.cfl * pd_weakly_compressible_limit(ctx, un);
    return PD_OK;
}

/* Process callback: tries one step. */
static pd_status pdi_weakly_compressible_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    return pd_weakly_compressible_step(ctx, (pd_weakly_compressible *)self, s->dt);
}

/* Process callback: sets the time. */
static pd_status pdi_weakly_compressible_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    ((pd_weakly_compressible *)self)->time = s->end;
    return PD_OK;
}

/* Process callback: halves a rejected step. PD_ERR_STATE: 20 attempts of this step were rejected before. */
static pd_status pdi_weakly_compressible_reject_step(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)self;
    s->dt *= 0.5;
    if (s->rejected < PDI_WEAKLY_COMPRESSIBLE_MAX_HALVINGS) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "weakly_compressible",
                   "steps down to %g s at t = %g s leave the admissible range", s->dt, s->time);
}

/* Process callback: fails with a message, since steps have become too short for the time to advance. */
static pd_status pdi_weakly_compressible_fail_step_underflow(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_weakly_compressible *un = (const pd_weakly_compressible *)self;
    return pd_fail(ctx, PD_ERR_STATE, "weakly_compressible",
                   "steps of %g s do not lead on from t = %g s to %g s: the speed of sound (%g m/s) or the viscosity "
                   "(%g m2/s) asks for them on this lattice",
                   s->dt, s->time, s->latest_end, un->desc.sound_speed, un->flow->nu);
}

/* Process callback: nodes `converted` have become fluid. They get velocity and pressure by pd_flow_update, and the
 * density of their pressure; the waves of the stability limit are computed anew, and the limit at the next request. */
static pd_status pdi_weakly_compressible_update_geometry(pd_ctx *ctx, void *self, const int32_t *converted,
                                                         int32_t count)
{
    pd_weakly_compressible *un = (pd_weakly_compressible *)self;
    PD_TRY(pd_flow_update(ctx, converted, count, un->flow));
    for (int32_t n = 0; n < count; n++)
        un->density[converted[n]] = pdi_weakly_compressible_compute_density(&un->desc, un->flow->p[converted[n]]);
    un->limit = 0.0;
    pdi_stability_free(ctx, &un->stability);
    return pdi_stability_build(ctx, un->flow, &un->stability);
}

/* Process callback: writes or reads the checkpoint of flow and density; after reading derived fields are updated. */
static pd_status pdi_weakly_compressible_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_weakly_compressible *un = (pd_weakly_compressible *)self;
    PD_TRY(pdi_flow_store(ctx, un->flow, archive));
    PD_TRY(pdi_array_registry_store(ctx, pdi_weakly_compressible_list, un, archive));
    if (archive->is_reading) pdi_weakly_compressible_update_derived_fields(ctx, un);
    return PD_OK;
}

pd_physics pd_weakly_compressible_process(pd_weakly_compressible *un)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "explicit flow";
    p.self = un;
    p.time = &un->time;
    p.has_substeps = 1;
    p.steps = &un->steps;
    p.start = pdi_weakly_compressible_begin;
    p.max_run_step = pdi_physics_limit_max_step;
    p.limit = pdi_weakly_compressible_limit_step;
    p.attempt = pdi_weakly_compressible_attempt;
    p.accept = pdi_weakly_compressible_accept;
    p.reject = pdi_weakly_compressible_reject_step;
    p.report_underflow = pdi_weakly_compressible_fail_step_underflow;
    p.nodes_converted = pdi_weakly_compressible_update_geometry;
    p.checkpoint = pdi_weakly_compressible_store;
    return p;
}

void pd_weakly_compressible_free(pd_ctx *ctx, pd_weakly_compressible *un)
{
    pdi_array_registry_free(ctx, pdi_weakly_compressible_list, un);
    pdi_stability_free(ctx, &un->stability);
    memset(un, 0, sizeof *un);
}
PDI_COLD_END

#undef PDI_WEAKLY_COMPRESSIBLE_MAX_HALVINGS
