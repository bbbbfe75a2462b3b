/* relaxation: see relaxation.h */
#include "solid/relaxation.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* First mass over the stiffness block of a point. The Rayleigh quotient of stiffness and mass of springs is then at
 * most 2/0.6, below the stability limit 4 (theory: eq. 8.12). */
#define PDI_RELAXATION_MASS 0.6
/* Rayleigh quotient beyond which a step counts as unstable, and the margin by which the mass then grows. */
#define PDI_RELAXATION_SAFE 3.8
#define PDI_RELAXATION_MORE 1.2
/* Factor of the mass when displacements are no state of the material, and how many restarts are allowed. */
#define PDI_RELAXATION_HEAVIER 4.0
#define PDI_RELAXATION_TIMES 60
/* Largest damping coefficient of a step of length 1: at 2 the velocities would vanish. */
#define PDI_RELAXATION_DAMPING 1.9
#define PDI_RELAXATION_STEPS 100000
/* Displacement over the horizon at which the motion counts as unbounded. */
#define PDI_RELAXATION_FAR 1e6

/* The fictitious motion. */
typedef struct pdi_relaxation {
    pdi_equilibrium rest;
    double mass;      /* [-] over the blocks */
    double damping;   /* [-] */
    double *momentum; /* [n] [N] */
} pdi_relaxation;

/* Describes the momentum array. */
static void pdi_relaxation_list(pdi_owner *owner, void *object)
{
    pdi_relaxation *relaxation = (pdi_relaxation *)object;
    PDI_ARRAY(owner, relaxation, momentum, relaxation->rest.n, "N");
}

/* Starts from rest at u with the present mass: residual, blocks, zero momentum. */
static pd_status pdi_relaxation_start(pdi_relaxation *r, const double *u, double *norm)
{
    pd_status status = pdi_equilibrium_rest(&r->rest, u, norm);
    if (status != PD_OK) return status;
    pdi_equilibrium_blocks(&r->rest);
    pdi_par_zero(r->rest.ctx, r->rest.n, r->momentum);
    r->damping = 0.0;
    return PD_OK;
}

/* One step of length 1 of the damped motion (theory: eq. 8.12). *quotient: Rayleigh quotient of stiffness and mass
 * along the step. */
static pd_status pdi_relaxation_step(pdi_relaxation *r, double *u, double *norm, double *quotient)
{
    pdi_equilibrium *q = &r->rest;
    double keep = (2.0 - r->damping) / (2.0 + r->damping), push = 2.0 / (2.0 + r->damping);
    for (int64_t k = 0; k < q->n; k++) r->momentum[k] = keep * r->momentum[k] + push * q->rest[k];
    pdi_equilibrium_precondition(q, r->momentum, q->step);
    for (int64_t k = 0; k < q->n; k++) q->step[k] /= r->mass;
    double before = pdi_par_dot(q->ctx, q->n, q->rest, q->step);
    pdi_par_axpy(q->ctx, q->n, 1.0, q->step, u);
    pd_status status = pdi_equilibrium_rest(q, u, norm);
    if (status != PD_OK) return status;
    double inertia = pdi_par_dot(q->ctx, q->n, r->momentum, q->step);
    double after = pdi_par_dot(q->ctx, q->n, q->rest, q->step);
    *quotient = inertia > 0.0 ? (before - after) / inertia : 0.0;
    return PD_OK;
}

/* Steps until the norm of the residual is below target [N]; adapts damping and mass. */
static pd_status pdi_relaxation_run(pdi_relaxation *r, double *u, double target, double norm,
                                    pd_equilibrium_result *result)
{
    pdi_equilibrium *q = &r->rest;
    int most = q->desc->max_iterations > 0 ? q->desc->max_iterations : PDI_RELAXATION_STEPS;
    pd_status status = pdi_relaxation_start(r, u, &norm);
    while (status == PD_OK && norm > target) {
        double quotient = 0.0;
        if (result->iterations == most) return PD_NOT_CONVERGED;
        result->iterations++;
        status = pdi_relaxation_step(r, u, &norm, &quotient);
        if (status < 0) return status;
        result->residual = norm;
        if (status == PD_OK && quotient <= PDI_RELAXATION_SAFE) {
            if (quotient > 0.0) r->damping = pdi_min(2.0 * sqrt(quotient), PDI_RELAXATION_DAMPING);
            if (!(pdi_par_max_abs(q->ctx, q->n, u) < PDI_RELAXATION_FAR * q->solid->body->horizon))
                return PD_ERR_DIVERGED;
            continue;
        }
        if (++result->steps > PDI_RELAXATION_TIMES) return PD_RETRY;
        pdi_par_axpy(q->ctx, q->n, -1.0, q->step, u);
        r->mass *= status == PD_OK ? PDI_RELAXATION_MORE * quotient / PDI_RELAXATION_SAFE : PDI_RELAXATION_HEAVIER;
        status = pdi_relaxation_start(r, u, &norm);
    }
    result->residual = norm;
    return status;
}

/* Sets up the problem, iterates, and turns divergence into a message. */
static pd_status pdi_relaxation_solve(pdi_relaxation *r, double *u, pd_equilibrium_result *result)
{
    double norm, target;
    PDI_TRY(pdi_equilibrium_begin(&r->rest, u, &norm, &target));
    PDI_TRY(pdi_owner_build(r->rest.ctx, pdi_relaxation_list, r));
    pd_status status = pdi_relaxation_run(r, u, target, norm, result);
    result->residual = r->rest.size > 0.0 ? result->residual / r->rest.size : 0.0;
    if (status != PD_ERR_DIVERGED) return status;
    return pdi_fail(r->rest.ctx, status, "relaxation", "the body moves without end after %d steps: its loads turn it, "
                    "or it has no stiffness against them", result->iterations);
}

pd_status pd_relaxation_solve(pd_ctx *ctx, const pd_solid *solid, const pd_equilibrium_desc *desc, const double *load,
                              double *u, pd_equilibrium_result *result)
{
    pdi_relaxation r;
    memset(&r, 0, sizeof r);
    memset(result, 0, sizeof *result);
    r.rest.ctx = ctx;
    r.rest.solid = solid;
    r.rest.desc = desc;
    r.rest.load = load;
    r.rest.n = (int64_t)solid->body->count * PD_DIM;
    r.mass = PDI_RELAXATION_MASS;
    pd_status status = pdi_relaxation_solve(&r, u, result);
    pdi_owner_free(ctx, pdi_relaxation_list, &r);
    pdi_owner_free(ctx, pdi_equilibrium_list, &r.rest);
    return status;
}

#undef PDI_RELAXATION_MASS
#undef PDI_RELAXATION_SAFE
#undef PDI_RELAXATION_MORE
#undef PDI_RELAXATION_HEAVIER
#undef PDI_RELAXATION_TIMES
#undef PDI_RELAXATION_DAMPING
#undef PDI_RELAXATION_STEPS
#undef PDI_RELAXATION_FAR
