/* steady_newton: see steady_newton.h */
#include "flow/steady_newton.h"
#include "flow/pressure_impulse.h"
#include "core/par.h"
#include "solve/newton.h"
#include <math.h>
#include <string.h>

#define PDI_STEADY_NEWTON_FIRST_RATE 1.0 /* [-] first pseudo time rate over U/L (b of eq. 3.32) */
/* [-] first pseudo time rate over U/L after a change of geometry: the old state is near */
#define PDI_STEADY_NEWTON_FIRST_RATE_AGAIN 0.1
/* a step that lets the residual norm grow by more than this factor is shortened */
#define PDI_STEADY_NEWTON_MAX_GROWTH 10.0
#define PDI_STEADY_NEWTON_MAX_HALVINGS 3 /* times that it is halved before it is given up */
#define PDI_STEADY_NEWTON_MAX_STALLED 40 /* Newton steps in which the residual has to be halved, or the solve ends */

#define PDI_STEADY_NEWTON_MAX_BOOST 1e8 /* factor on the pseudo time rate above which the solve ends */
/* Part of the residual that the linearisation may miss (q of eq. 3.33). Above it the pseudo time step becomes shorter,
 * below a quarter of it longer. */
#define PDI_STEADY_NEWTON_MAX_NONLINEARITY 1.0

#define PDI_STEADY_NEWTON_FINAL_FORCING 0.3 /* [-] part of the tolerance that the last Newton step aims at */

#define PDI_STEADY_NEWTON_STAGE_MAX_STEPS 8 /* most Newton steps of a stage in time */
/* loosest and tightest linear tolerance of such a Newton step */
#define PDI_STEADY_NEWTON_STAGE_FORCING 0.1
#define PDI_STEADY_NEWTON_STAGE_MIN_FORCING 1e-4
/* [-] part of the stage tolerance that a linear solve aims at: just missing it costs a Newton step */
#define PDI_STEADY_NEWTON_STAGE_FINAL_FORCING 0.1

/* Equations of a Newton iteration: a steady state by pseudo time continuation, or a stage in time. */
typedef struct pdi_steady_newton {
    pd_steady *steady;
    pd_steady_result *result;
    double tolerance;        /* [-] of both residuals */
    int started;             /* 1: the residual of the first state is known */
    double length;           /* [-] part of the present step that is in the state */
    int effort;              /* Krylov iterations of that step */
    double boost, min_boost; /* [-] of the pseudo time rate, and its smallest value; 0: a stage */
    double full_step_norm;   /* [-] norm of the residual after a full step, or of what the linearisation has missed */
} pdi_steady_newton;

/* Norm, with momentum_weight, of the part of the residual after a full step that the linearisation does not give, |r +
 * sigma du| (eq. 3.33), sigma the pseudo time rate; pseudo time has no part in continuity. */
static double pdi_steady_newton_compute_nonlinearity(const pd_ctx *ctx, const pd_steady *s)
{
    int64_t size = (int64_t)(PD_DIM + 1) * s->flow->grid->total, split = size - s->flow->grid->total;
    double rate = s->pseudo_rate / pdi_steady_get_momentum_scale(s);
    double momentum = pdi_par_dot(ctx, split, s->residual, s->residual) +
                      2.0 * rate * pdi_par_dot(ctx, split, s->residual, s->newton_step) +
                      rate * rate * pdi_par_dot(ctx, split, s->newton_step, s->newton_step);
    double continuity = pdi_par_dot(ctx, size - split, s->residual + split, s->residual + split);
    return sqrt(s->momentum_weight * s->momentum_weight * pd_max(momentum, 0.0) + continuity);
}

/* Newton callback: assembles the scaled residual; *norm: weighted, *excess: largest residual over the tolerance. For a
 * steady state also raises reference_norm at the start, and sets full_step_norm after a full step. */
static pd_status pdi_steady_newton_compute_residual(pd_ctx *ctx, void *self, double *norm, double *excess)
{
    pdi_steady_newton *n = (pdi_steady_newton *)self;
    *norm = pdi_steady_assemble_residual(ctx, n->steady, n->result);
    *excess = n->result->residual_over_tolerance * (n->steady->desc.tolerance / n->tolerance);
    if (!(n->boost > 0.0)) return PD_OK;
    if (!n->started) n->steady->reference_norm = pd_max(n->steady->reference_norm, *norm);
    n->started = 1;
    if (!(n->length < 1.0)) n->full_step_norm = pd_min(pdi_steady_newton_compute_nonlinearity(ctx, n->steady), *norm);
    return PD_OK;
}

/* Newton callback: sets velocity and pressure to those before the step plus `length` times the step. */
static void pdi_steady_newton_move(pd_ctx *ctx, void *self, double length)
{
    pdi_steady_newton *n = (pdi_steady_newton *)self;
    pdi_steady_update_state(ctx, n->steady, length - n->length);
    n->length = length;
}

/* Adapts `boost`, the factor on the pseudo time rate, to the last Newton step. Taken back: times 10. Linear tolerance
 * missed: times 4. With q, the nonlinearity over the norm before the step: above 1 times 2q, at most 10; below 1/4
 * halved, not below min_boost; between these it stays. A larger boost is a shorter pseudo time step. */
static void pdi_steady_newton_adapt_pseudo_time(pdi_steady_newton *n, const pd_newton_progress *p)
{
    double nonlinearity = n->full_step_norm / p->previous;
    if (!(p->length > 0.0)) n->boost *= 10.0;
    else if (n->effort > n->steady->desc.max_krylov) n->boost *= 4.0;
    else if (nonlinearity > PDI_STEADY_NEWTON_MAX_NONLINEARITY)
        n->boost *= pd_min(2.0 * nonlinearity / PDI_STEADY_NEWTON_MAX_NONLINEARITY, 10.0);
    else if (nonlinearity < 0.25 * PDI_STEADY_NEWTON_MAX_NONLINEARITY) n->boost = pd_max(n->min_boost, n->boost * 0.5);
}

/* Newton callback: a step of pseudo time continuation by switched evolution relaxation: the pseudo time rate is boost
 * times U/L times the root of residual norm over reference norm (eq. 3.32). PD_NOT_CONVERGED: boost exceeds 1e8, so
 * that steps have become too short to lead on. */
static pd_status pdi_steady_newton_solve_pseudo_time_step(pd_ctx *ctx, void *self, const pd_newton_progress *p)
{
    pdi_steady_newton *n = (pdi_steady_newton *)self;
    pd_steady *s = n->steady;
    if (p->steps > 0) pdi_steady_newton_adapt_pseudo_time(n, p);
    if (n->boost > PDI_STEADY_NEWTON_MAX_BOOST) return PD_NOT_CONVERGED;
    pdi_jacobian_set_state(ctx, &s->jacobian);
    PD_TRY(pdi_steady_update_precond(ctx, s,
                                     PDI_STEADY_NEWTON_FIRST_RATE * n->boost *
                                         pdi_steady_get_continuity_scale(s->flow) * sqrt(p->norm / s->reference_norm)));
    n->length = 0.0;
    return pdi_steady_solve_newton_step(ctx, s, p->forcing, n->result, &n->effort);
}

/* 1: the preconditioner is set up for the rate of the present stage. */
static int pdi_steady_newton_is_prepared(const pd_steady *s)
{
    return s->prepared && !(s->pseudo_rate < s->stage_rate) && !(s->pseudo_rate > s->stage_rate);
}

/* Newton callback: a step of a stage, with rate and target in the solver. The preconditioner is set up only when it is
 * not that of this rate. */
static pd_status pdi_steady_newton_solve_stage_step(pd_ctx *ctx, void *self, const pd_newton_progress *p)
{
    pdi_steady_newton *n = (pdi_steady_newton *)self;
    pd_steady *s = n->steady;
    pdi_jacobian_set_state(ctx, &s->jacobian);
    if (!pdi_steady_newton_is_prepared(s)) PD_TRY(pdi_steady_update_precond(ctx, s, s->stage_rate));
    n->length = 0.0;
    return pdi_steady_solve_newton_step(ctx, s, p->forcing, n->result, &n->effort);
}

/* Equations of a solver for a tolerance of the residuals; those of a stage unless boost is set. */
static pdi_steady_newton pdi_steady_newton_equations(pd_steady *s, double tolerance, pd_steady_result *result)
{
    pdi_steady_newton n;
    memset(&n, 0, sizeof n);
    n.steady = s;
    n.result = result;
    n.tolerance = tolerance;
    return n;
}

/* Newton's method for the state in flow, with the callback `solve_step` and options. Sets momentum_weight, and
 * evaluations and converged of n->result. */
static pd_status pdi_steady_newton_iterate(pd_ctx *ctx, pdi_steady_newton *n, const pd_newton_desc *desc,
                                           pd_status (*solve_step)(pd_ctx *, void *, const pd_newton_progress *),
                                           pd_newton_progress *progress)
{
    pd_newton_equations equations;
    int64_t start = n->steady->flow->evaluations;
    memset(&equations, 0, sizeof equations);
    equations.self = n;
    equations.name = "flow: Newton";
    equations.residual = pdi_steady_newton_compute_residual;
    equations.solve_step = solve_step;
    equations.move = pdi_steady_newton_move;
    pdi_steady_compute_momentum_weight(ctx, n->steady);
    pd_status status = pd_newton_solve(ctx, &equations, desc, progress);
    n->result->evaluations = n->steady->flow->evaluations - start;
    n->result->converged = status == PD_OK;
    return status;
}

/* Iterates to the steady state, then solves for the divergence potential. The first pseudo time rate is a tenth where
 * an earlier solve has left a reference norm. PD_NOT_CONVERGED: no progress (the norm is not halved in 40 steps, or
 * boost), or the limit of steps; the potential stays. PD_ERR_DIVERGED: the residual is not finite. */
static pd_status pdi_steady_newton_solve_steady_state(pd_ctx *ctx, pd_steady *s, pd_steady_result *result)
{
    pdi_steady_newton newton = pdi_steady_newton_equations(s, s->desc.tolerance, result);
    pd_newton_desc desc;
    pd_newton_progress progress;
    newton.boost = newton.min_boost = s->reference_norm > 0.0 ? PDI_STEADY_NEWTON_FIRST_RATE_AGAIN : 1.0;
    memset(&desc, 0, sizeof desc);
    desc.search = PD_NEWTON_BY_NORM;
    desc.max_steps = s->desc.max_newton;
    desc.max_trials = PDI_STEADY_NEWTON_MAX_HALVINGS;
    desc.max_growth = PDI_STEADY_NEWTON_MAX_GROWTH;
    desc.max_stalled = PDI_STEADY_NEWTON_MAX_STALLED;
    desc.first_ratio = 1.0;
    desc.final_forcing = PDI_STEADY_NEWTON_FINAL_FORCING;
    desc.max_forcing = PDI_KRYLOV_FORCING_MAX;
    pd_status status =
        pdi_steady_newton_iterate(ctx, &newton, &desc, pdi_steady_newton_solve_pseudo_time_step, &progress);
    pdi_krylov_free_growth(ctx, &s->krylov);
    if (status >= 0 && !(progress.norm < 1e300))
        return pd_fail(ctx, PD_ERR_DIVERGED, "steady", "the flow residual is %g after %d Newton steps", progress.norm,
                       result->newton);
    return status == PD_OK ? pdi_steady_solve_divergence_potential(ctx, s) : status;
}

pd_status pd_steady_solve(pd_ctx *ctx, pd_steady *s, pd_steady_result *result)
{
    pd_flow *flow = s->flow;
    double *impulse = flow->pressure_impulse;
    memset(result, 0, sizeof *result);
    PD_TRY(pdi_flow_find_surface_patches(ctx, flow));
    PD_TRY(pdi_steady_begin_solves(ctx, s));
    flow->pressure_impulse = NULL;
    pd_status status = pdi_steady_end_solves(ctx, s, pdi_steady_newton_solve_steady_state(ctx, s, result));
    flow->pressure_impulse = impulse;
    if (!impulse) return status;
    pdi_pressure_impulse_update(flow, 0.0, flow->stabilisation);
    pdi_pressure_impulse_update_flux(ctx, flow, 1.0, 0.0);
    return status;
}

/* Newton's method for a stage, in full steps, with stage_rate and stage_target in s. PD_RETRY: it did not converge in 8
 * steps, the norm of the residual did not fall, or an error that is not fatal. */
static pd_status pdi_steady_newton_solve_stage_newton(pd_ctx *ctx, pd_steady *s, double tolerance,
                                                      pd_steady_result *result)
{
    pdi_steady_newton newton = pdi_steady_newton_equations(s, tolerance, result);
    pd_newton_desc desc;
    pd_newton_progress progress;
    memset(&desc, 0, sizeof desc);
    desc.search = PD_NEWTON_FULL_STEP;
    desc.max_steps = PDI_STEADY_NEWTON_STAGE_MAX_STEPS;
    desc.is_nearly_linear = 1;
    desc.final_forcing = PDI_STEADY_NEWTON_STAGE_FINAL_FORCING;
    desc.min_forcing = PDI_STEADY_NEWTON_STAGE_MIN_FORCING;
    desc.max_forcing = PDI_STEADY_NEWTON_STAGE_FORCING;
    pd_status status = pdi_steady_newton_iterate(ctx, &newton, &desc, pdi_steady_newton_solve_stage_step, &progress);
    return status == PD_OK || pd_is_fatal(status) ? status : PD_RETRY;
}

PDI_FN pd_status pdi_steady_newton_solve_stage(pd_ctx *ctx, pd_steady *s, double rate, const double *target,
                                               double tolerance, pd_steady_result *result)
{
    memset(result, 0, sizeof *result);
    PD_TRY(pdi_flow_find_surface_patches(ctx, s->flow));
    PD_TRY(pdi_steady_begin_solves(ctx, s));
    s->stage_rate = rate;
    s->stage_target = target;
    pd_status status = pdi_steady_newton_solve_stage_newton(ctx, s, tolerance, result);
    s->stage_rate = 0.0;
    s->stage_target = NULL;
    return pdi_steady_end_solves(ctx, s, status);
}
