/* dynamic_relaxation: see dynamic_relaxation.h */
#include "solid/dynamic_relaxation.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* First mass over the stiffness block of a point. The Rayleigh quotient of stiffness and mass of springs is then at
 * most 2/0.6, below the stability limit 4 (theory: eq. 14.26). */
#define PDI_DYNAMIC_RELAXATION_INITIAL_MASS 0.6
/* Rayleigh quotient beyond which a step counts as unstable, and the margin by which the mass then grows. */
#define PDI_DYNAMIC_RELAXATION_SAFE_QUOTIENT 3.8
#define PDI_DYNAMIC_RELAXATION_MASS_MARGIN 1.2
/* Factor of the mass when displacements are no state of the material, and how many restarts are allowed. */
#define PDI_DYNAMIC_RELAXATION_RETRY_MASS 4.0
#define PDI_DYNAMIC_RELAXATION_MAX_RESTARTS 60
/* Largest damping coefficient of a step of length 1: at 2 the velocities would vanish. */
#define PDI_DYNAMIC_RELAXATION_MAX_DAMPING 1.9
#define PDI_DYNAMIC_RELAXATION_MAX_STEPS 100000
/* Displacement over the horizon at which the motion counts as unbounded. */
#define PDI_DYNAMIC_RELAXATION_DIVERGED 1e6

/* The fictitious motion. */
typedef struct pdi_dynamic_relaxation {
    pdi_equilibrium problem;
    double mass;      /* [-] over the blocks */
    double damping;   /* [-] */
    double *momentum; /* [n] [N] */
} pdi_dynamic_relaxation;

/* Describes the momentum array. */
static void pdi_dynamic_relaxation_list(pdi_array_visitor *owner, void *object)
{
    pdi_dynamic_relaxation *relaxation = (pdi_dynamic_relaxation *)object;
    PDI_ARRAY(owner, relaxation, momentum, relaxation->problem.n, "N");
}

/* Starts from rest at u with the present mass: residual and *norm [N], blocks, zero momentum and damping. PD_RETRY: u
 * is no state of the material. */
static pd_status pdi_dynamic_relaxation_restart(pdi_dynamic_relaxation *r, const double *u, double *norm)
{
    pd_status status = pdi_equilibrium_compute_residual(&r->problem, u, norm);
    if (status != PD_OK) return status;
    pdi_equilibrium_compute_blocks(&r->problem);
    pdi_par_zero(r->problem.ctx, r->problem.n, r->momentum);
    r->damping = 0.0;
    return PD_OK;
}

/* One step of length 1 of the damped motion of u (theory: eq. 14.26). *norm [N]: residual after it; *quotient: Rayleigh
 * quotient of stiffness and mass along the step, 0 where the step has no inertia. PD_RETRY: the new u is no state of
 * the material, and *quotient stays. */
static pd_status pdi_dynamic_relaxation_step(pdi_dynamic_relaxation *r, double *u, double *norm, double *quotient)
{
    pdi_equilibrium *q = &r->problem;
    double keep = (2.0 - r->damping) / (2.0 + r->damping), push = 2.0 / (2.0 + r->damping);
    for (int64_t k = 0; k < q->n; k++) r->momentum[k] = keep * r->momentum[k] + push * q->residual[k];
    pdi_equilibrium_apply_precond(q, r->momentum, q->step);
    for (int64_t k = 0; k < q->n; k++) q->step[k] /= r->mass;
    double before = pdi_par_dot(q->ctx, q->n, q->residual, q->step);
    pdi_par_axpy(q->ctx, q->n, 1.0, q->step, u);
    pd_status status = pdi_equilibrium_compute_residual(q, u, norm);
    if (status != PD_OK) return status;
    double inertia = pdi_par_dot(q->ctx, q->n, r->momentum, q->step);
    double after = pdi_par_dot(q->ctx, q->n, q->residual, q->step);
    *quotient = inertia > 0.0 ? (before - after) / inertia : 0.0;
    return PD_OK;
}

/* Steps until the norm [N] of the residual is at most target [N]; adapts damping and mass. A step with a Rayleigh
 * quotient > 3.8, or to no state of the material, is taken back, the mass grows, and the motion begins anew from rest.
 * PD_RETRY: more than 60 such restarts. PD_ERR_DIVERGED: a displacement reaches 1e6 horizons. PD_NOT_CONVERGED:
 * max_iterations steps, 0: 100000. result->residual is in N. */
static pd_status pdi_dynamic_relaxation_iterate(pdi_dynamic_relaxation *r, double *u, double target, double norm,
                                                pd_equilibrium_result *result)
{
    pdi_equilibrium *q = &r->problem;
    int most = q->desc->max_iterations > 0 ? q->desc->max_iterations : PDI_DYNAMIC_RELAXATION_MAX_STEPS;
    pd_status status = pdi_dynamic_relaxation_restart(r, u, &norm);
    while (status == PD_OK && norm > target) {
        double quotient = 0.0;
        if (result->iterations == most) return PD_NOT_CONVERGED;
        result->iterations++;
        status = pdi_dynamic_relaxation_step(r, u, &norm, &quotient);
        if (status < 0) return status;
        result->residual = norm;
        if (status == PD_OK && quotient <= PDI_DYNAMIC_RELAXATION_SAFE_QUOTIENT) {
            if (quotient > 0.0) r->damping = pd_min(2.0 * sqrt(quotient), PDI_DYNAMIC_RELAXATION_MAX_DAMPING);
            if (!(pdi_par_max_abs(q->ctx, q->n, u) < PDI_DYNAMIC_RELAXATION_DIVERGED * q->solid->body->horizon))
                return PD_ERR_DIVERGED;
            continue;
        }
        if (++result->steps > PDI_DYNAMIC_RELAXATION_MAX_RESTARTS) return PD_RETRY;
        pdi_par_axpy(q->ctx, q->n, -1.0, q->step, u);
        r->mass *= status == PD_OK
                       ? PDI_DYNAMIC_RELAXATION_MASS_MARGIN * quotient / PDI_DYNAMIC_RELAXATION_SAFE_QUOTIENT
                       : PDI_DYNAMIC_RELAXATION_RETRY_MASS;
        status = pdi_dynamic_relaxation_restart(r, u, &norm);
    }
    result->residual = norm;
    return status;
}

/* Sets up the problem, iterates, makes the residual relative, and turns divergence into a message. The caller frees. */
static pd_status pdi_dynamic_relaxation_solve_inner(pdi_dynamic_relaxation *r, double *u, pd_equilibrium_result *result)
{
    double norm, target;
    PD_TRY(pdi_equilibrium_begin(&r->problem, u, &norm, &target));
    PD_TRY(pdi_array_registry_build(r->problem.ctx, pdi_dynamic_relaxation_list, r));
    pd_status status = pdi_dynamic_relaxation_iterate(r, u, target, norm, result);
    result->residual = r->problem.scale > 0.0 ? result->residual / r->problem.scale : 0.0;
    if (status != PD_ERR_DIVERGED) return status;
    return pd_fail(r->problem.ctx, status, "dynamic_relaxation",
                   "the body moves without end after %d steps: its loads turn it, "
                   "or it has no stiffness against them",
                   result->iterations);
}

pd_status pd_dynamic_relaxation_solve(pd_ctx *ctx, const pd_material_interface *solid, const pd_equilibrium_desc *desc,
                                      const double *load, double *u, pd_equilibrium_result *result)
{
    pdi_dynamic_relaxation r;
    memset(&r, 0, sizeof r);
    memset(result, 0, sizeof *result);
    r.problem.ctx = ctx;
    r.problem.solid = solid;
    r.problem.desc = desc;
    r.problem.load = load;
    r.problem.n = (int64_t)solid->body->count * PD_DIM;
    r.mass = PDI_DYNAMIC_RELAXATION_INITIAL_MASS;
    pd_status status = pdi_dynamic_relaxation_solve_inner(&r, u, result);
    pdi_array_registry_free(ctx, pdi_dynamic_relaxation_list, &r);
    pdi_array_registry_free(ctx, pdi_equilibrium_list, &r.problem);
    return status;
}

#undef PDI_DYNAMIC_RELAXATION_INITIAL_MASS
#undef PDI_DYNAMIC_RELAXATION_SAFE_QUOTIENT
#undef PDI_DYNAMIC_RELAXATION_MASS_MARGIN
#undef PDI_DYNAMIC_RELAXATION_RETRY_MASS
#undef PDI_DYNAMIC_RELAXATION_MAX_RESTARTS
#undef PDI_DYNAMIC_RELAXATION_MAX_DAMPING
#undef PDI_DYNAMIC_RELAXATION_MAX_STEPS
#undef PDI_DYNAMIC_RELAXATION_DIVERGED
