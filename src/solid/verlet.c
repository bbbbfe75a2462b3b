/* verlet: see verlet.h */
#include "solid/verlet.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Default fraction of the longest stable step, and the largest one allowed: truncated families are softer, stretched
 * bonds stiffer. */
#define PDI_VERLET_DEFAULT_FRACTION 0.8
#define PDI_VERLET_MAX_FRACTION 1.0
/* Displacement over the horizon at which a run counts as unstable. */
#define PDI_VERLET_DIVERGED 1e6

PDI_FN void pdi_verlet_list(pdi_array_visitor *owner, void *object)
{
    pd_verlet *verlet = (pd_verlet *)object;
    int64_t count = verlet->solid.body ? (int64_t)verlet->solid.body->count * PD_DIM : 0;
    PDI_ARRAY_STATE(owner, verlet, u, count, "m");
    PDI_ARRAY_STATE(owner, verlet, v, count, "m/s");
    PDI_ARRAY_STATE(owner, verlet, force, count, "N/m3");
    PDI_SCALAR_STATE(owner, verlet, time, "s");
    PDI_SCALAR_STATE(owner, verlet, work, "J");
    PDI_SCALAR_STATE(owner, verlet, steps, "1");
    PDI_SCALAR_STATE(owner, verlet, broken, "1");
}

pd_status pd_verlet_build(pd_ctx *ctx, const pd_material_interface *solid, const pd_verlet_desc *desc, pd_verlet *d)
{
    memset(d, 0, sizeof *d);
    if (!(desc->density > 0.0) || !(desc->density < 1e100) || !(desc->step_fraction >= 0.0) ||
        !(desc->step_fraction <= PDI_VERLET_MAX_FRACTION))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "verlet",
                       "a density of %g kg/m3 and %g of the stable step, expected a positive density and 0 to 1",
                       desc->density, desc->step_fraction);
    d->desc = *desc;
    d->solid = *solid;
    d->max_step = (desc->step_fraction > 0.0 ? desc->step_fraction : PDI_VERLET_DEFAULT_FRACTION) *
                  solid->stable_step(solid->self, desc->density);
    pd_status status = pdi_array_registry_build(ctx, pdi_verlet_list, d);
    if (status < 0) pd_verlet_free(ctx, d);
    return status;
}

void pd_verlet_free(pd_ctx *ctx, pd_verlet *d)
{
    pdi_array_registry_free(ctx, pdi_verlet_list, d);
    memset(d, 0, sizeof *d);
}

double pd_verlet_kinetic(const pd_verlet *d)
{
    const pd_body *body = d->solid.body;
    pdi_compensated_sum all = {0.0, 0.0};
    for (int32_t i = 0; i < body->count; i++) {
        double square = 0.0;
        for (int a = 0; a < PD_DIM; a++) square += d->v[(int64_t)i * PD_DIM + a] * d->v[(int64_t)i * PD_DIM + a];
        pdi_compensated_sum_add(&all, 0.5 * d->desc.density * body->volume[i] * square);
    }
    return pdi_compensated_sum_total(&all);
}

/* Half a step of the velocities first .. end - 1 by the present forces and loads; prescribed ones stay. */
static void pdi_verlet_half_kick(const pd_verlet *d, double dt, int64_t first, int64_t end)
{
    const double *PD_RESTRICT force = d->force, *PD_RESTRICT load = d->desc.load;
    const uint8_t *PD_RESTRICT held = d->desc.prescribed;
    double *PD_RESTRICT v = d->v, part = 0.5 * dt / d->desc.density;
    if (held)
        for (int64_t k = first; k < end; k++) v[k] = held[k] ? v[k] : v[k] + part * (force[k] + (load ? load[k] : 0.0));
    else if (load)
        for (int64_t k = first; k < end; k++) v[k] += part * (force[k] + load[k]);
    else
        for (int64_t k = first; k < end; k++) v[k] += part * (force[k] + 0.0);
}

/* Adds the work [J] of half a step to *all: of loads on free components, and of the forces that prescribe velocities,
 * with the velocities as they are. */
static void pdi_verlet_add_work(const pd_verlet *d, double dt, int64_t first, int64_t end, pdi_compensated_sum *all)
{
    for (int64_t k = first; k < end && (d->desc.load || d->desc.prescribed); k++) {
        double load = d->desc.load ? d->desc.load[k] : 0.0;
        if (d->desc.prescribed && d->desc.prescribed[k]) load = -d->force[k];
        if (load < 0.0 || load > 0.0)
            pdi_compensated_sum_add(all, 0.5 * dt * d->solid.body->volume[k / PD_DIM] * load * d->v[k]);
    }
}

/* Full step of the displacements first .. end - 1. Returns the largest absolute component [m]; NaN where one is not
 * finite. */
static double pdi_verlet_drift(const pd_verlet *d, double dt, int64_t first, int64_t end)
{
    const double *PD_RESTRICT v = d->v;
    double *PD_RESTRICT u = d->u, most = 0.0, all = 0.0;
    for (int64_t k = first; k < end; k++) u[k] += dt * v[k];
    for (int64_t k = first; k < end; k++) {
        double size = fabs(u[k]);
        all += 0.0 * size;
        most = size > most ? size : most;
    }
    return most + all;
}

/* Half a step of the velocities, and in the first half (first 1) the full step of the displacements, block by block;
 * adds to `work`. Returns the largest displacement [m], or NaN; 0 in the second half. */
static double pdi_verlet_half_step(const pd_ctx *ctx, pd_verlet *d, double dt, int first)
{
    enum { parts = 64, block = 1024 };
    int64_t n = (int64_t)d->solid.body->count * PD_DIM;
    double most[parts], all = 0.0;
    pdi_compensated_sum work[parts], sum = {0.0, 0.0};
    int nt = pd_par_threads(ctx, n * 6);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int q = 0; q < parts; q++) {
        most[q] = work[q].sum = work[q].compensation = 0.0;
        for (int64_t k = n * q / parts; k < n * (q + 1) / parts; k += block) {
            int64_t end = k + block < n * (q + 1) / parts ? k + block : n * (q + 1) / parts;
            if (first) pdi_verlet_half_kick(d, dt, k, end);
            pdi_verlet_add_work(d, dt, k, end, &work[q]);
            double size = first ? pdi_verlet_drift(d, dt, k, end) : 0.0;
            if (!(size <= most[q])) most[q] = size;
            if (!first) pdi_verlet_half_kick(d, dt, k, end);
        }
    }
    for (int q = 0; q < parts; q++) {
        pdi_compensated_sum_add(&sum, pdi_compensated_sum_total(&work[q]));
        if (!(most[q] <= all)) all = most[q];
    }
    d->work += pdi_compensated_sum_total(&sum);
    return all;
}

/* Process callback: time step, at most the stable one, in equal steps up to s->latest_end. */
static pd_status pdi_verlet_process_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    const pd_verlet *d = (const pd_verlet *)self;
    s->dt = pd_min(s->dt, d->max_step);
    PD_TRY(pdi_physics_limit_max_step(ctx, self, s));
    s->dt = pdi_physics_equal_steps(s->latest_end - s->time, s->dt);
    return PD_OK;
}

/* Forces at u, into force, after a step of dt with velocities v, or before the first one (v NULL); bonds may break and
 * are counted. PD_ERR_STATE: u is no state of the material. */
static pd_status pdi_verlet_compute_force(pd_ctx *ctx, pd_verlet *d, const double *v, double dt)
{
    const pd_material_interface *solid = &d->solid;
    if (solid->dynamic_force) {
        d->broken += solid->dynamic_force(ctx, solid->self, d->u, v, dt, d->force);
        return PD_OK;
    }
    pd_status status = solid->force(ctx, solid->self, d->u, d->force);
    if (status <= PD_OK) return status;
    return pd_fail(ctx, PD_ERR_STATE, "verlet", "at t = %g s displacements are no state of the %s material", d->time,
                   solid->name);
}

/* Process callback: one velocity Verlet step of u and v in place; before the first one it computes the forces.
 * PD_ERR_STATE: displacements diverge. */
static pd_status pdi_verlet_process_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_verlet *d = (pd_verlet *)self;
    if (d->steps == 0) PD_TRY(pdi_verlet_compute_force(ctx, d, NULL, 0.0));
    double most = pdi_verlet_half_step(ctx, d, s->dt, 1);
    PD_TRY(pdi_verlet_compute_force(ctx, d, d->v, s->dt));
    pdi_verlet_half_step(ctx, d, s->dt, 0);
    d->steps++;
    if (most < PDI_VERLET_DIVERGED * d->solid.body->horizon) return PD_OK;
    return pd_fail(ctx, PD_ERR_STATE, "verlet", "displacements of %g m at t = %g s: a piece is free and is loaded, or "
                   "the step of %g s is too long", most, s->time, s->dt);
}

/* Process callback: the step is accepted; sets the time and commits the material. */
static pd_status pdi_verlet_process_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_verlet *d = (pd_verlet *)self;
    d->time = s->end;
    return d->solid.commit ? d->solid.commit(ctx, d->solid.self, d->u) : PD_OK;
}

/* Process callback for checkpoints: state of the material and of the motion. */
static pd_status pdi_verlet_process_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    const pd_material_interface *solid = &((pd_verlet *)self)->solid;
    if (solid->store) PD_TRY(solid->store(ctx, solid->self, archive));
    return pdi_array_registry_store(ctx, pdi_verlet_list, self, archive);
}

pd_physics pd_verlet_process(pd_verlet *d)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "verlet";
    p.self = d;
    p.time = &d->time;
    p.steps = &d->steps;
    p.max_run_step = pdi_physics_limit_max_step;
    p.limit = pdi_verlet_process_limit;
    p.attempt = pdi_verlet_process_attempt;
    p.accept = pdi_verlet_process_accept;
    p.checkpoint = pdi_verlet_process_store;
    return p;
}

#undef PDI_VERLET_DEFAULT_FRACTION
#undef PDI_VERLET_MAX_FRACTION
#undef PDI_VERLET_DIVERGED
