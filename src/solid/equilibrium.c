/* equilibrium: see equilibrium.h */
#include "solid/equilibrium.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/rng.h"
#include "core/vec.h"
#include "solve/newton.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Sum of the loads of a free component, over the sum of their absolute values, that counts as zero. */
#define PDI_EQUILIBRIUM_ROUNDING 1e-9
/* Relative rounding of displacements in the estimate of the rounding of forces. */
#define PDI_EQUILIBRIUM_DIGITS (16.0 * DBL_EPSILON)
/* Most Newton steps, and most trials of a line search, before a load counts as too large. */
#define PDI_EQUILIBRIUM_MAX_NEWTON 50
#define PDI_EQUILIBRIUM_MAX_TRIALS 12
/* Weight of the block preconditioner beside the coarse correction: both resolve waves about as long as a bond. */
#define PDI_EQUILIBRIUM_BLOCK_WEIGHT 0.6
/* GMRES basis: vectors at first, and at most. */
#define PDI_EQUILIBRIUM_RESTART 20
#define PDI_EQUILIBRIUM_MAX_RESTART 170

enum { PDI_EQUILIBRIUM_BLOCK = PD_DIM * PD_DIM };

/* Equations of a Newton iteration. */
typedef struct pdi_equilibrium_newton {
    pdi_equilibrium *problem;
    double *u;     /* [n] [m] displacements */
    double target; /* [N] norm of the residual to reach */
    pd_equilibrium_result *result;
} pdi_equilibrium_newton;

/* Callback of pdi_equilibrium_visit_components for one component. */
typedef pd_status (*pdi_equilibrium_visit)(pdi_equilibrium *q, const pd_rigid_modes *rigid);

PDI_FN void pdi_equilibrium_list(pdi_array_visitor *owner, void *object)
{
    pdi_equilibrium *equilibrium = (pdi_equilibrium *)object;
    PDI_ARRAY(owner, equilibrium, block, equilibrium->n * PD_DIM, "m/N");
    PDI_ARRAY(owner, equilibrium, diagonal, equilibrium->n, "N/m");
    PDI_ARRAY(owner, equilibrium, residual, equilibrium->n, "N");
    PDI_ARRAY(owner, equilibrium, step, equilibrium->n, "m");
    PDI_ARRAY(owner, equilibrium, full_direction, pdi_equilibrium_has_interpolation(equilibrium) ? equilibrium->n : 0,
              "m");
    PDI_ARRAY(owner, equilibrium, start_u, equilibrium->solid->linear ? 0 : equilibrium->n, "m");
    PDI_ARRAY(owner, equilibrium, lambda, equilibrium->solid->moduli ? equilibrium->n / PD_DIM : 0, "Pa");
    PDI_ARRAY(owner, equilibrium, mu, equilibrium->solid->moduli ? equilibrium->n / PD_DIM : 0, "Pa");
}

/* Operator of the linear step: y = -V df along x for free components, 0 for prescribed ones. A Krylov callback. */
static void pdi_equilibrium_apply_tangent(void *user, const double *x, double *y)
{
    const pdi_equilibrium *q = (const pdi_equilibrium *)user;
    const double *volume = q->solid->body->volume;
    q->solid->tangent(q->ctx, q->solid->self, x, y);
    for (int64_t k = 0; k < q->n; k++) y[k] = pdi_equilibrium_is_held(q, k) ? 0.0 : -volume[k / PD_DIM] * y[k];
}

/* Sets the interpolated components of x [m] from its free ones; without interpolation nothing changes. */
static void pdi_equilibrium_interpolate(const pdi_equilibrium *q, double *x)
{
    const pd_multipoint_constraint *all = q->desc->interpolation;
    if (!pdi_equilibrium_has_interpolation(q)) return;
    for (int64_t k = 0; k < all->count; k++) x[all->row[k].follower] = 0.0;
    for (int64_t k = 0; k < all->count; k++) x[all->row[k].follower] += all->row[k].coefficient * x[all->row[k].leader];
}

/* As pdi_equilibrium_apply_tangent, along the free part of x with its interpolated components; x stays. A Krylov
 * callback. */
static void pdi_equilibrium_apply_interpolated(void *user, const double *x, double *y)
{
    const pdi_equilibrium *q = (const pdi_equilibrium *)user;
    pdi_par_copy(q->ctx, q->n, x, q->full_direction);
    pdi_equilibrium_interpolate(q, q->full_direction);
    pdi_equilibrium_apply_tangent(user, q->full_direction, y);
}

PDI_FN pd_status pdi_equilibrium_compute_residual(pdi_equilibrium *q, const double *u, double *norm)
{
    const double *volume = q->solid->body->volume;
    double sum = 0.0, pull = 0.0;
    pd_status status = q->solid->force(q->ctx, q->solid->self, u, q->residual);
    if (status != PD_OK) return status;
    for (int64_t k = 0; k < q->n; k++) {
        double bonds = volume[k / PD_DIM] * q->residual[k], load = q->load ? volume[k / PD_DIM] * q->load[k] : 0.0;
        int held = pdi_equilibrium_is_held(q, k);
        q->residual[k] = held ? 0.0 : bonds + load;
        pull += held ? bonds * bonds : 0.0;
        sum += q->residual[k] * q->residual[k];
    }
    *norm = sqrt(sum);
    q->reaction_norm = sqrt(pull);
    return PD_OK;
}

PDI_FN void pdi_equilibrium_apply_precond(void *user, const double *x, double *y)
{
    const pdi_equilibrium *q = (const pdi_equilibrium *)user;
    double share = q->coarse.levels ? PDI_EQUILIBRIUM_BLOCK_WEIGHT : 1.0;
    for (int64_t i = 0; i < q->n / PD_DIM; i++)
        for (int a = 0; a < PD_DIM; a++) {
            const double *row = q->block + i * PDI_EQUILIBRIUM_BLOCK + a * PD_DIM;
            double sum = 0.0;
            for (int b = 0; b < PD_DIM; b++) sum += row[b] * x[i * PD_DIM + b];
            y[i * PD_DIM + a] = share * sum;
        }
    if (q->coarse.levels) pdi_coarse_fe_precond_apply(q->ctx, (pd_coarse_fe_precond *)&q->coarse, x, y);
    for (int64_t k = 0; k < q->n; k++)
        if (pdi_equilibrium_is_held(q, k)) y[k] = 0.0;
}

/* Updates the coarse preconditioner, if any: moduli of the material, and springs of the size of the diagonal at
 * prescribed displacements. Those that is_image marks have none, interpolated ones only within a spacing of where they
 * are prescribed. q->step is overwritten. */
static void pdi_equilibrium_update_coarse(const pdi_equilibrium *q)
{
    if (!q->coarse.levels) return;
    q->solid->moduli(q->ctx, q->solid->self, q->lambda, q->mu);
    for (int64_t k = 0; k < q->n; k++)
        q->step[k] =
            pdi_equilibrium_is_held(q, k) && !(q->solid->is_image && q->solid->is_image[k]) ? q->diagonal[k] : 0.0;
    for (int64_t k = 0; pdi_equilibrium_has_interpolation(q) && k < q->desc->interpolation->count; k++) {
        const pd_constraint_row *row = q->desc->interpolation->row + k;
        if (!row->near_boundary) q->step[row->follower] = 0.0;
    }
    pdi_coarse_fe_precond_assemble(q->ctx, (pd_coarse_fe_precond *)&q->coarse, q->lambda, q->mu, q->step);
}

PDI_FN void pdi_equilibrium_compute_blocks(const pdi_equilibrium *q)
{
    int32_t count = q->solid->body->count;
    int nt = pd_par_threads(q->ctx, (int64_t)count * 20);
    (void)nt;
    q->solid->blocks(q->ctx, q->solid->self, q->block);
    for (int64_t k = 0; k < q->n; k++) q->diagonal[k] = q->block[k * PD_DIM + k % PD_DIM];
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < count; i++) {
        double a[PDI_EQUILIBRIUM_BLOCK], *own = q->block + (int64_t)i * PDI_EQUILIBRIUM_BLOCK;
        for (int p = 0; p < PDI_EQUILIBRIUM_BLOCK; p++) {
            int64_t row = (int64_t)i * PD_DIM + p / PD_DIM, column = (int64_t)i * PD_DIM + p % PD_DIM;
            int held = row != column && (pdi_equilibrium_is_held(q, row) || pdi_equilibrium_is_held(q, column));
            a[p] = held ? 0.0 : own[p];
        }
        if (pdi_vec_invert(a, own) > 0.0) continue;
        for (int p = 0; p < PDI_EQUILIBRIUM_BLOCK; p++) own[p] = 0.0; /* a point without a bond stays where it is */
    }
}

/* PD_ERR_STATE: an entry of x [n] is NaN, or 1e200 or more in size; what: its name in the message. x NULL: PD_OK. */
static pd_status pdi_equilibrium_check_finite(const pdi_equilibrium *q, const double *x, const char *what)
{
    for (int64_t k = 0; x && k < q->n; k++)
        if (!(fabs(x[k]) < 1e200))
            return pd_fail(q->ctx, PD_ERR_STATE, "equilibrium", "the %s of point %.0f is %g", what,
                           (double)(k / PD_DIM), x[k]);
    return PD_OK;
}

PDI_FN int pdi_equilibrium_is_balanced(const pd_body *body, const uint8_t *held, const double *load, int axis,
                                       const int32_t *piece, int32_t count, double *sum)
{
    double all = 0.0, size = 0.0;
    for (int32_t n = 0; n < count; n++) {
        int64_t k = (int64_t)piece[n] * PD_DIM + axis;
        if (held && held[k]) return 1;
        all += body->volume[piece[n]] * load[k];
        size += body->volume[piece[n]] * fabs(load[k]);
    }
    if (sum) *sum = all;
    return fabs(all) <= PDI_EQUILIBRIUM_ROUNDING * size;
}

PDI_FN int pdi_equilibrium_has_unbalanced_moment(const pd_material_interface *solid, const uint8_t *held,
                                                 const double *load, const pd_rigid_modes *rigid)
{
    return solid->moduli && pdi_rigid_modes_relative_work(rigid, held, load) > PDI_EQUILIBRIUM_ROUNDING;
}

/* PD_ERR_STATE: the loads of a component (piece [count]) do not balance along an axis along which none of its points is
 * prescribed, as of pdi_equilibrium_is_balanced. */
static pd_status pdi_equilibrium_check_forces(const pdi_equilibrium *q, const int32_t *piece, int32_t count)
{
    double sum = 0.0;
    for (int a = 0; a < PD_DIM; a++)
        if (!pdi_equilibrium_is_balanced(q->solid->body, q->desc->prescribed, q->load, a, piece, count, &sum))
            return pd_fail(q->ctx, PD_ERR_STATE, "equilibrium",
                           "a piece of %d points, one of them point %d, is not held along axis %d, and its loads sum "
                           "to %g N: hold it, or balance the loads", (int)count, (int)piece[0], a, sum);
    return PD_OK;
}

/* Calls `visit` for each connected component of the body with its rigid motions; ends at the first error, which it
 * returns. */
static pd_status pdi_equilibrium_visit_components(pdi_equilibrium *q, pdi_equilibrium_visit visit)
{
    int32_t *piece = NULL, all = q->solid->body->count;
    uint8_t *seen = NULL;
    pd_status status = PD_NEW(q->ctx, "equilibrium", all, piece);
    if (status == PD_OK) status = PD_NEW(q->ctx, "equilibrium", all, seen);
    for (int32_t i = 0; i < all && status == PD_OK; i++) {
        pd_rigid_modes rigid;
        if (seen[i]) continue;
        int32_t count = pdi_body_bonds_find_component(q->solid->body, i, seen, piece);
        pdi_rigid_modes_compute(q->solid->body, q->desc->prescribed, piece, count, &rigid);
        status = visit(q, &rigid);
    }
    PD_DELETE(q->ctx, all, piece);
    PD_DELETE(q->ctx, all, seen);
    return status;
}

/* Checks the loads of a component, and sets has_rigid_motions where it has any. PD_ERR_STATE: its loads do not balance
 * along an axis. PD_ERR_DIVERGED: its moments do not balance. */
static pd_status pdi_equilibrium_check_component(pdi_equilibrium *q, const pd_rigid_modes *rigid)
{
    PD_TRY(pdi_equilibrium_check_forces(q, rigid->component, rigid->count));
    q->has_rigid_motions = q->has_rigid_motions || rigid->motions;
    if (!pdi_equilibrium_has_unbalanced_moment(q->solid, q->desc->prescribed, q->load, rigid)) return PD_OK;
    return pd_fail(q->ctx, PD_ERR_DIVERGED, "equilibrium",
                   "a piece of %d points, one of them point %d, can turn, and "
                   "its loads turn it: hold it, or balance their moments",
                   (int)rigid->count, (int)rigid->component[0]);
}

/* Removes the mean rigid motions of a component from q->step. Returns PD_OK. */
static pd_status pdi_equilibrium_remove_rigid_step(pdi_equilibrium *q, const pd_rigid_modes *rigid)
{
    pdi_rigid_modes_remove(rigid, q->step);
    return PD_OK;
}

/* Removes the rigid motions of a component from q->residual, which rounding puts there, by a volume-weighted fit to
 * force densities; prescribed entries become 0. Without free motions nothing changes. Returns PD_OK. */
static pd_status pdi_equilibrium_project_residual(pdi_equilibrium *q, const pd_rigid_modes *rigid)
{
    const double *volume = q->solid->body->volume;
    for (int way = 0; way < 2; way++) {
        for (int32_t n = 0; n < rigid->count && rigid->motions; n++)
            for (int d = 0; d < PD_DIM; d++) {
                int64_t k = (int64_t)rigid->component[n] * PD_DIM + d;
                if (way == 0) q->residual[k] /= volume[rigid->component[n]];
                else
                    q->residual[k] = pdi_equilibrium_is_held(q, k) ? 0.0 : q->residual[k] * volume[rigid->component[n]];
            }
        if (way == 0) pdi_rigid_modes_remove(rigid, q->residual);
    }
    return PD_OK;
}

/* First force scale [N]: Euclidean norm over the free components of the loads, plus the forces that the prescribed
 * displacements in u put on a body at rest, by the tangent. q->step and q->residual are overwritten. */
static double pdi_equilibrium_estimate_scale(pdi_equilibrium *q, const double *u)
{
    const double *volume = q->solid->body->volume;
    double size = 0.0;
    for (int64_t k = 0; k < q->n; k++) q->step[k] = pdi_equilibrium_is_held(q, k) ? u[k] : 0.0;
    pdi_equilibrium_apply_tangent(q, q->step, q->residual);
    for (int64_t k = 0; k < q->n; k++) {
        double load = q->load && !pdi_equilibrium_is_held(q, k) ? volume[k / PD_DIM] * q->load[k] : 0.0;
        size += (load - q->residual[k]) * (load - q->residual[k]);
    }
    return sqrt(size);
}

/* Force scale [N] of a solution: Euclidean norm of the loads V load on free components and of the reactions
 * (reaction_norm). It does not depend on rigid motions. */
static double pdi_equilibrium_compute_scale(const pdi_equilibrium *q)
{
    const double *volume = q->solid->body->volume;
    double size = q->reaction_norm * q->reaction_norm;
    for (int64_t k = 0; k < q->n && q->load; k++) {
        double load = pdi_equilibrium_is_held(q, k) ? 0.0 : volume[k / PD_DIM] * q->load[k];
        size += load * load;
    }
    return sqrt(size);
}

/* 1: the loads do work along a motion [n] without stiffness, by more than 1e-9 of the sum of absolute contributions;
 * the motion is copied to desc->mechanism unless that is NULL. 0: they do none, or there are no loads. */
static int pdi_equilibrium_check_mechanism(const pdi_equilibrium *q, const double *motion)
{
    double work = 0.0, size = 0.0;
    for (int64_t k = 0; k < q->n && q->load; k++) {
        double part = q->solid->body->volume[k / PD_DIM] * q->load[k] * motion[k];
        work += part;
        size += fabs(part);
    }
    if (!(fabs(work) > PDI_EQUILIBRIUM_ROUNDING * size)) return 0;
    if (q->desc->mechanism) memcpy(q->desc->mechanism, motion, (size_t)q->n * sizeof *motion);
    return 1;
}

/* Estimate of the rounding of forces [N] at displacements u: Euclidean norm of the tangent along 16 DBL_EPSILON |u|
 * with random signs. Where forces follow from 1 + grad u, |u| counts as at least the last digit of a point distance.
 * q->step and q->residual are overwritten. */
static double pdi_equilibrium_estimate_rounding(pdi_equilibrium *q, const double *u)
{
    const pd_body *body = q->solid->body;
    double length = body->spacing > 0.0 ? body->spacing : body->horizon, sum = 0.0;
    double least = q->solid->gradient_based ? length * DBL_EPSILON / PDI_EQUILIBRIUM_DIGITS : 0.0;
    for (int64_t k = 0; k < q->n; k++) {
        double size = pd_max(fabs(u[k]), least);
        q->step[k] = pdi_rng_u64(1, 0, (uint64_t)k) & 1 ? size : -size;
    }
    pdi_equilibrium_apply_tangent(q, q->step, q->residual);
    for (int64_t k = 0; k < q->n; k++) sum += q->residual[k] * q->residual[k];
    return PDI_EQUILIBRIUM_DIGITS * sqrt(sum);
}

PDI_FN pd_krylov_desc pdi_equilibrium_krylov_options(int interpolated)
{
    pd_krylov_desc kd;
    memset(&kd, 0, sizeof kd);
    kd.equations = "solid";
    kd.method = interpolated ? PD_KRYLOV_GMRES : PD_KRYLOV_CG;
    kd.components = 1;
    kd.zero_guess = 1;
    kd.restart = PDI_EQUILIBRIUM_RESTART;
    kd.max_vectors = PDI_EQUILIBRIUM_MAX_RESTART;
    return kd;
}

/* Builds the Krylov solver of linear steps; interpolated 1: GMRES, 0: conjugate gradients. The caller frees. */
static pd_status pdi_equilibrium_build_krylov(const pdi_equilibrium *q, int interpolated, pd_krylov *krylov)
{
    pd_krylov_desc kd = pdi_equilibrium_krylov_options(interpolated);
    kd.n = q->n;
    kd.rtol = DBL_MIN; /* the target is all */
    kd.max_iterations = q->desc->max_iterations > 0 ? q->desc->max_iterations : 10000;
    return pd_krylov_build(q->ctx, &kd, krylov);
}

/* Solves the linear step for the residual down to `target` [N], into q->step; adds to result->iterations. follows 1:
 * with interpolation. PD_ERR_DIVERGED: a direction without stiffness; of a linear material without interpolation only
 * one along which the loads do work, otherwise PD_NOT_CONVERGED. */
static pd_status pdi_equilibrium_solve_krylov(pdi_equilibrium *q, pd_krylov *krylov, int follows, double target,
                                              pd_equilibrium_result *result)
{
    pd_krylov_result linear;
    krylov->desc.atol = target;
    krylov->desc.diagonal = q->solid->linear ? q->diagonal : NULL;
    pd_status status =
        pd_krylov_solve(q->ctx, krylov, follows ? pdi_equilibrium_apply_interpolated : pdi_equilibrium_apply_tangent,
                        pdi_equilibrium_apply_precond, q, q->residual, q->step, &linear);
    result->iterations += linear.iterations;
    result->residual = linear.residual;
    if (follows || status != PD_ERR_DIVERGED || !q->solid->linear) return status;
    if (pdi_equilibrium_check_mechanism(q, krylov->work + q->n)) return status;
    return pd_fail(q->ctx, PD_NOT_CONVERGED, "equilibrium", "a direction without stiffness after %d iterations: "
                   "residual %.3g N, target %.3g N", linear.iterations, linear.residual, target);
}

/* After GMRES has failed, conjugate gradients look for a mechanism, without interpolation: GMRES does not see one.
 * PD_ERR_DIVERGED: found; PD_NOT_CONVERGED: none. q->step stays; full_direction is overwritten. */
static pd_status pdi_equilibrium_search_mechanism(pdi_equilibrium *q, double target, pd_equilibrium_result *result)
{
    pd_equilibrium_result found = *result;
    pd_krylov krylov;
    double *step = q->step;
    q->step = q->full_direction; /* the step of GMRES stays */
    pd_status status = pdi_equilibrium_build_krylov(q, 0, &krylov);
    if (status == PD_OK) status = pdi_equilibrium_solve_krylov(q, &krylov, 0, target, &found);
    q->step = step;
    pd_krylov_free(q->ctx, &krylov);
    result->iterations = found.iterations;
    return status == PD_OK ? PD_NOT_CONVERGED : status;
}

/* Linear step, into q->step, with projection of rigid motions and interpolated components. Statuses: as of
 * pdi_equilibrium_solve_krylov; the step is of use with PD_NOT_CONVERGED, too. */
static pd_status pdi_equilibrium_solve_linear(pdi_equilibrium *q, double target, pd_equilibrium_result *result)
{
    int moves = q->has_rigid_motions && q->coarse.levels, follows = pdi_equilibrium_has_interpolation(q);
    if (moves) PD_TRY(pdi_equilibrium_visit_components(q, pdi_equilibrium_project_residual));
    pd_status status = pdi_equilibrium_solve_krylov(q, &q->krylov, follows, target, result);
    if (follows && q->solid->linear && (status == PD_NOT_CONVERGED || status == PD_ERR_DIVERGED))
        status = pdi_equilibrium_search_mechanism(q, target, result);
    if (status >= 0 && moves) PD_TRY(pdi_equilibrium_visit_components(q, pdi_equilibrium_remove_rigid_step));
    pdi_equilibrium_interpolate(q, q->step);
    return status;
}

/* Newton callback: work of the residual along the step [J]: directional derivative of the energy with the opposite
 * sign. */
static double pdi_equilibrium_compute_step_work(void *self)
{
    const pdi_equilibrium *q = ((const pdi_equilibrium_newton *)self)->problem;
    pdi_compensated_sum all = {0.0, 0.0};
    for (int64_t k = 0; k < q->n; k++) pdi_compensated_sum_add(&all, q->residual[k] * q->step[k]);
    return pdi_compensated_sum_total(&all);
}

/* Clears the error message of a solver whose result is good enough. Returns PD_OK. */
static pd_status pdi_equilibrium_clear_error(const pdi_equilibrium *q)
{
    q->ctx->status = PD_OK;
    q->ctx->message[0] = '\0';
    return PD_OK;
}

/* Linear material: adds one step to u. PD_NOT_CONVERGED: the residual is above the target [N] and the rounding of the
 * displacements; within that rounding it is PD_OK, and the force scale grows. */
static pd_status pdi_equilibrium_solve_once(pdi_equilibrium *q, double *u, double target, pd_equilibrium_result *result)
{
    pdi_equilibrium_update_coarse(q);
    pd_status status = pdi_equilibrium_solve_linear(q, target, result);
    result->steps = 1;
    if (status < 0) return status;
    for (int64_t k = 0; k < q->n; k++) u[k] += q->step[k];
    double digits = status == PD_OK ? 0.0 : pdi_equilibrium_estimate_rounding(q, u);
    if (status == PD_OK || !(result->residual <= digits)) return status;
    q->scale *= digits / target;
    return pdi_equilibrium_clear_error(q);
}

/* Newton callback: the residual at the displacements. *excess: its norm over the target; 0: converged. */
static pd_status pdi_equilibrium_compute_newton_residual(pd_ctx *ctx, void *self, double *norm, double *excess)
{
    pdi_equilibrium_newton *n = (pdi_equilibrium_newton *)self;
    (void)ctx;
    pd_status status = pdi_equilibrium_compute_residual(n->problem, n->u, norm);
    *excess = *norm <= n->target ? 0.0 : *norm / n->target;
    return status;
}

/* Newton callback: the linear step, with blocks and coarse preconditioner at u; keeps u as start_u. A direction without
 * stiffness is searched like any other. */
static pd_status pdi_equilibrium_solve_step(pd_ctx *ctx, void *self, const pd_newton_progress *p)
{
    pdi_equilibrium_newton *n = (pdi_equilibrium_newton *)self;
    pdi_equilibrium *q = n->problem;
    (void)ctx;
    pdi_equilibrium_compute_blocks(q);
    pdi_equilibrium_update_coarse(q);
    pd_status status = pdi_equilibrium_solve_linear(q, p->forcing * p->norm, n->result);
    memcpy(q->start_u, n->u, (size_t)q->n * sizeof *n->u);
    return status < 0 && status != PD_ERR_DIVERGED ? status : PD_OK;
}

/* Newton callback: displacements at a length [-] of the step from start_u; 0: start_u. */
static void pdi_equilibrium_move(pd_ctx *ctx, void *self, double length)
{
    pdi_equilibrium_newton *n = (pdi_equilibrium_newton *)self;
    const pdi_equilibrium *q = n->problem;
    (void)ctx;
    memcpy(n->u, q->start_u, (size_t)q->n * sizeof *n->u);
    for (int64_t k = 0; k < q->n && length > 0.0; k++) n->u[k] += length * q->step[k];
}

/* Newton's method, with a line search by work: norms are no measure, as the forces have kinks where yielding begins.
 * PD_RETRY: it did not converge. */
static pd_status pdi_equilibrium_solve_newton(pdi_equilibrium *q, double *u, double target,
                                              pd_equilibrium_result *result)
{
    pdi_equilibrium_newton newton;
    pd_newton_equations equations;
    pd_newton_desc desc;
    pd_newton_progress progress;
    newton.problem = q;
    newton.u = u;
    newton.target = target;
    newton.result = result;
    memset(&equations, 0, sizeof equations);
    equations.self = &newton;
    equations.name = "solid: Newton";
    equations.residual = pdi_equilibrium_compute_newton_residual;
    equations.solve_step = pdi_equilibrium_solve_step;
    equations.move = pdi_equilibrium_move;
    equations.work = pdi_equilibrium_compute_step_work;
    memset(&desc, 0, sizeof desc);
    desc.search = PD_NEWTON_BY_WORK;
    desc.max_steps = PDI_EQUILIBRIUM_MAX_NEWTON;
    desc.max_trials = PDI_EQUILIBRIUM_MAX_TRIALS;
    desc.first_ratio = 0.1;
    desc.final_forcing = 0.5;
    desc.max_forcing = 1.0;
    pd_status status = pd_newton_solve(q->ctx, &equations, &desc, &progress);
    result->steps += progress.steps;
    result->residual = progress.norm;
    return status == PD_NOT_CONVERGED ? PD_RETRY : status;
}

/* Relative tolerance [-] of the residual, or its default. */
static double pdi_equilibrium_get_rtol(const pdi_equilibrium *q)
{
    return q->desc->rtol > 0.0 ? q->desc->rtol : PD_EQUILIBRIUM_RTOL;
}

/* Sets *again to 1 where the norm of the residual at u exceeds rtol times the force scale of the solution, and also
 * rtol times a scale below q->scale that rounding allows; q->scale then falls to it. *norm, *target [N]: the norm at u,
 * and the target of the next round. q->step is overwritten. */
static pd_status pdi_equilibrium_check_scale(pdi_equilibrium *q, const double *u, double *norm, double *target,
                                             int *again)
{
    double rtol = pdi_equilibrium_get_rtol(q);
    PD_TRY(pdi_equilibrium_compute_residual(q, u, norm));
    double size = pdi_equilibrium_compute_scale(q);
    *again = *norm > rtol * size;
    if (!*again) return PD_OK;
    size = pd_max(size, pd_max(q->rounding, pdi_equilibrium_estimate_rounding(q, u)) / rtol);
    PD_TRY(pdi_equilibrium_compute_residual(q, u, norm));
    *again = size<q->scale && * norm> rtol * size;
    if (*again) q->scale = size;
    *target = rtol * q->scale;
    return PD_OK;
}

PDI_FN pd_status pdi_equilibrium_begin(pdi_equilibrium *q, const double *u, double *norm, double *target)
{
    PD_TRY(pdi_equilibrium_check_finite(q, q->load, "load"));
    PD_TRY(pdi_equilibrium_check_finite(q, u, "displacement"));
    if (q->load) PD_TRY(pdi_equilibrium_visit_components(q, pdi_equilibrium_check_component));
    PD_TRY(pdi_array_registry_build(q->ctx, pdi_equilibrium_list, q));
    pd_status status = pdi_equilibrium_compute_residual(q, u, norm);
    if (status == PD_RETRY)
        return pd_fail(q->ctx, PD_ERR_STATE, "equilibrium", "the guess of the displacements, with what is held, is no "
                       "state of the %s material: take shorter steps", q->solid->name);
    if (status < 0) return status;
    pdi_equilibrium_compute_blocks(q);
    q->rounding = pdi_equilibrium_estimate_rounding(q, u);
    q->scale = pd_max(pdi_equilibrium_estimate_scale(q, u), q->rounding / pdi_equilibrium_get_rtol(q));
    *target = q->scale * pdi_equilibrium_get_rtol(q);
    return pdi_equilibrium_compute_residual(q, u, norm);
}

/* Solves once, and again with a smaller force scale where pdi_equilibrium_check_scale asks for it; relative residual
 * into result. A later round that fails is PD_OK where its residual meets the first target. Sets desc->mechanism to
 * zero first. The caller frees. Statuses: as of pd_equilibrium_solve. */
static pd_status pdi_equilibrium_solve_inner(pdi_equilibrium *q, double *u, pd_equilibrium_result *result)
{
    double norm, target;
    pd_status status = PD_OK;
    if (q->desc->mechanism) memset(q->desc->mechanism, 0, (size_t)q->n * sizeof *q->desc->mechanism);
    PD_TRY(pdi_equilibrium_begin(q, u, &norm, &target));
    if (q->solid->moduli) PD_TRY(pdi_coarse_fe_precond_build(q->ctx, q->solid->body, &q->coarse));
    PD_TRY(pdi_equilibrium_build_krylov(q, pdi_equilibrium_has_interpolation(q), &q->krylov));
    double first = target;
    for (int again = 1; again;) {
        status = q->solid->linear ? pdi_equilibrium_solve_once(q, u, target, result)
                                  : pdi_equilibrium_solve_newton(q, u, target, result);
        again = 0;
        if (status == PD_OK) PD_TRY(pdi_equilibrium_check_scale(q, u, &norm, &target, &again));
    }
    /* rounding may end it before: large strains have the digits of 1, and parts may hang on few bonds */
    if ((status == PD_RETRY || status == PD_NOT_CONVERGED) && target < first && result->residual <= first) {
        status = pdi_equilibrium_clear_error(q);
        q->scale = first / pdi_equilibrium_get_rtol(q);
    }
    if (status == PD_ERR_DIVERGED)
        return pd_fail(q->ctx, status, "equilibrium", "the body can turn, or a part of it can about a hinge, and its "
                       "loads turn it: hold it, or balance their moments");
    result->residual = q->scale > 0.0 ? result->residual / q->scale : 0.0;
    return status;
}

pd_status pd_equilibrium_solve(pd_ctx *ctx, const pd_material_interface *solid, const pd_equilibrium_desc *desc,
                               const double *load, double *u, pd_equilibrium_result *result)
{
    pdi_equilibrium q;
    memset(&q, 0, sizeof q);
    memset(result, 0, sizeof *result);
    q.ctx = ctx;
    q.solid = solid;
    q.desc = desc;
    q.load = load;
    q.n = (int64_t)solid->body->count * PD_DIM;
    pd_status status = pdi_equilibrium_solve_inner(&q, u, result);
    pd_krylov_free(ctx, &q.krylov);
    pdi_coarse_fe_precond_free(ctx, &q.coarse);
    pdi_array_registry_free(ctx, pdi_equilibrium_list, &q);
    return status;
}

#undef PDI_EQUILIBRIUM_ROUNDING
#undef PDI_EQUILIBRIUM_DIGITS
#undef PDI_EQUILIBRIUM_MAX_NEWTON
#undef PDI_EQUILIBRIUM_MAX_TRIALS
#undef PDI_EQUILIBRIUM_BLOCK_WEIGHT
#undef PDI_EQUILIBRIUM_RESTART
#undef PDI_EQUILIBRIUM_MAX_RESTART
