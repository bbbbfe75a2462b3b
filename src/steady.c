/* steady: see steady.h */
#include "steady.h"
#include "op.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* First pseudo time step: L/U over this. */
#define PDI_STEADY_SHIFT 1.0
/* The same after a change of geometry, over this: the old state is near. */
#define PDI_STEADY_AGAIN 0.1
/* A step that lets the residual grow by more than this factor is taken back. */
#define PDI_STEADY_GROWTH 10.0

/* Pseudo time steps shorter than this against the planned one are hopeless. */
#define PDI_STEADY_MAX_BOOST 1e8
/* Krylov iterations of a Newton step that call for a shorter or a longer pseudo time step. */
#define PDI_STEADY_HARD 150
#define PDI_STEADY_EASY 60

/* The last Newton step aims at this share of the tolerance. */
#define PDI_STEADY_ENOUGH 0.3

/* Share of the divergence left by the potential that takes it off, and the most iterations for it: rounding may be more
 * than that share. */
#define PDI_STEADY_EVEN 1e-10
#define PDI_STEADY_EVEN_MOST 600
/* Divergence over U/L that is none. */
#define PDI_STEADY_ROUNDING 1e-19

/* Newton steps of a stage in time, and the loosest linear tolerance of one. */
#define PDI_STEADY_STAGE 8
#define PDI_STEADY_STAGE_FORCING 0.1
/* A linear solve that just misses costs a whole Newton step more. */
#define PDI_STEADY_STAGE_ENOUGH 0.1

/* What the solver callbacks see. */
typedef struct pdi_steady_user {
    pd_ctx *ctx;
    pd_steady *steady;
} pdi_steady_user;

static int64_t pdi_steady_size(const pd_flow *flow) { return (int64_t)(PD_DIM + 1) * flow->grid->total; }

/* Momentum residuals count in U^2/L, continuity residuals in U/L. */
static void pdi_steady_scale(const pd_ctx *ctx, const pd_flow *flow, double momentum, double continuity, double *x)
{
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    int nt = pdi_par_threads(ctx, pdi_steady_size(flow));
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < split + total; i++) x[i] *= i < split ? momentum : continuity;
}

/* s->work = M^-1 x, and flow->grad the pressure gradient of it. r: scratch. */
static void pdi_steady_precondition(pd_ctx *ctx, pd_steady *s, const double *x, double *r)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    const pd_ghosts *ghosts = &flow->bonds->ghosts;
    double *y = s->work, *dp = y + split;
    pdi_schur schur;
    schur.poisson = &s->mg_p;
    schur.shift = s->shift;
    schur.grad = s->carrier; /* both are written later */
    schur.convected = flow->grad;
    pdi_par_copy(ctx, split + total, x, r);
    pdi_steady_scale(ctx, flow, flow->speed * flow->speed / flow->length, flow->speed / flow->length, r);
    pdi_schur_solve(ctx, flow, &schur, r + split, y, dp);
    pd_ghosts_pressure(ghosts, 0.0, dp);
    pdi_flow_gradient(ctx, flow, dp, flow->grad);
    pdi_par_axpy(ctx, split, -1.0, flow->grad, r);
    pd_ghosts_clear(ghosts, PD_DIM, r); /* no part of the equations */
    for (int d = 0; d < PD_DIM; d++) pd_multigrid_cycle(ctx, &s->mg_u, r + d * total, y + d * total);
}

/* y = scaled J (du, dp) of s->work, whose pressure gradient is in flow->grad:
 * (conv(du, u) + conv(u, du) + G dp - nu lap du, div du - tau ...). */
static void pdi_steady_jacobian(pd_ctx *ctx, pd_steady *s, double *y)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    double *du = s->work;
    pdi_product_step step;
    pd_ghosts_vector(&flow->bonds->ghosts, du);
    pdi_flow_carrier(ctx, flow, du, s->carrier);
    step.carrier = s->carrier;
    step.u = du;
    step.p = du + split;
    step.grad = flow->grad;
    pdi_product_apply(ctx, &s->product, &step, y, y + split);
    if (s->shift > 0.0) pdi_par_axpy(ctx, split, s->shift, du, y);
    pd_ghosts_clear(&flow->bonds->ghosts, PD_DIM, y);
    pdi_steady_scale(ctx, flow, flow->length / (flow->speed * flow->speed), flow->length / flow->speed, y);
    flow->evaluations++;
}

/* y = J M^-1 x: preconditioned from the right, so that both share the pressure gradient. */
static void pdi_steady_product(void *user, const double *x, double *y)
{
    pdi_steady_user *u = (pdi_steady_user *)user;
    pdi_steady_precondition(u->ctx, u->steady, x, y);
    pdi_steady_jacobian(u->ctx, u->steady, y);
}

static pd_status pdi_steady_setup(pd_ctx *ctx, pd_steady *s, double shift)
{
    pdi_compact_faces velocity, pressure;
    pdi_compact_convection moving, resting;
    s->shift = shift;
    velocity.closed = velocity.inlet = 1;
    velocity.outlet = 0;
    pressure.closed = pressure.inlet = 0;
    pressure.outlet = 1;
    moving.u = s->flow->u;
    moving.spread = resting.spread = resting.u = NULL;
    pdi_compact_fill(ctx, s->flow->nu, NULL, &moving, s->shift, &velocity, &s->compact_u);
    pdi_compact_fill(ctx, 1.0, NULL, &resting, 0.0, &pressure, &s->compact_p);
    pd_compact *u = &s->compact_u, *p = &s->compact_p;
    PDI_TRY(pd_multigrid_setup(ctx, &s->mg_u, u->active, (const float *const *)u->conduct,
                               (const float *const *)u->flux, u->wall, u->mass));
    return pd_multigrid_setup(ctx, &s->mg_p, p->active, (const float *const *)p->conduct, NULL, p->wall, p->mass);
}

/* Scaled residual of the present state into s->residual; its norm. */
static double pdi_steady_residual(pd_ctx *ctx, pd_steady *s, pd_steady_result *result)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    double *r = s->residual;
    pd_flow_residual(ctx, flow, r, r + split);
    if (s->rate > 0.0) {
        pdi_par_axpy(ctx, split, s->rate, flow->u, r);
        pdi_par_axpy(ctx, split, -s->rate, s->target, r);
        pd_ghosts_clear(&flow->bonds->ghosts, PD_DIM, r); /* inlets hold a velocity, and have no equation */
    }
    pdi_steady_scale(ctx, flow, flow->length / (flow->speed * flow->speed), flow->length / flow->speed, r);
    result->momentum = pdi_par_max_abs(ctx, split, r);
    result->continuity = pdi_par_max_abs(ctx, total, r + split);
    return sqrt(pdi_par_dot(ctx, split + total, r, r));
}

static void pdi_steady_move(const pd_ctx *ctx, pd_steady *s, double factor)
{
    pd_flow *flow = s->flow;
    int64_t total = flow->grid->total, split = (int64_t)PD_DIM * total;
    pdi_par_axpy(ctx, split, factor, s->step, flow->u);
    pdi_par_axpy(ctx, total, factor, s->step + split, flow->p);
}

pd_status pd_steady_build(pd_ctx *ctx, pd_flow *flow, const pd_steady_desc *desc, pd_steady *s)
{
    memset(s, 0, sizeof *s);
    s->flow = flow;
    s->desc = *desc;
    if (!(desc->tolerance >= 0.0) || desc->tolerance >= 1.0 || desc->max_newton < 0 || desc->max_krylov < 0 ||
        desc->restart < 0)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "steady", "tolerance %g, max_newton %d, max_krylov %d, restart %d",
                        desc->tolerance, desc->max_newton, desc->max_krylov, desc->restart);
    if (!(s->desc.tolerance > 0.0)) s->desc.tolerance = 1e-6;
    if (!s->desc.max_newton) s->desc.max_newton = 60;
    if (!s->desc.max_krylov) s->desc.max_krylov = 300;
    if (!s->desc.restart) s->desc.restart = PDI_STEADY_RESTART;
    int64_t size = pdi_steady_size(flow);
    pd_krylov_desc kd;
    pd_multigrid_desc md;
    memset(&kd, 0, sizeof kd);
    kd.n = size;
    kd.spans = &flow->bonds->spans;
    kd.components = PD_DIM + 1;
    kd.restart = s->desc.restart;
    kd.max_iterations = s->desc.max_krylov;
    kd.zero_guess = kd.compressed = 1;
    pdi_compact_multigrid(flow->grid, &md);
    PDI_TRY(pdi_compact_build(ctx, flow->grid, 1, &s->compact_u));
    PDI_TRY(pdi_compact_build(ctx, flow->grid, 0, &s->compact_p));
    PDI_TRY(pd_multigrid_build(ctx, &md, &s->mg_u));
    md.symmetric = 1;
    PDI_TRY(pd_multigrid_build(ctx, &md, &s->mg_p));
    PDI_TRY(pd_krylov_build(ctx, &kd, &s->krylov));
    PDI_TRY(pdi_product_build(ctx, flow, &s->product));
    PDI_TRY(PDI_NEW(ctx, "steady", size, s->residual));
    PDI_TRY(PDI_NEW(ctx, "steady", size, s->step));
    PDI_TRY(PDI_NEW(ctx, "steady", size, s->work));
    PDI_TRY(PDI_NEW(ctx, "steady", flow->grid->total, s->potential));
    return PDI_NEW(ctx, "steady", (int64_t)PD_DIM * flow->grid->total, s->carrier);
}

/* One linearised step with the term `shift` of pseudo time, for which the preconditioner is set up; the state moves by
 * s->step. *effort: Krylov iterations, beyond the limit when the tolerance was missed. */
static pd_status pdi_steady_newton(pd_ctx *ctx, pd_steady *s, double forcing, pd_steady_result *result, int *effort)
{
    pdi_steady_user user;
    pd_krylov_result linear;
    user.ctx = ctx;
    user.steady = s;
    pdi_par_axpy(ctx, pdi_steady_size(s->flow), -2.0, s->residual, s->residual);
    pdi_product_freeze(ctx, &s->product);
    s->krylov.desc.rtol = forcing;
    PDI_TRY(pd_krylov_solve(ctx, &s->krylov, pdi_steady_product, NULL, &user, s->residual, s->step, &linear));
    pdi_steady_precondition(ctx, s, s->step, s->residual);
    pdi_par_copy(ctx, pdi_steady_size(s->flow), s->work, s->step);
    *effort = linear.converged ? linear.iterations : s->desc.max_krylov + 1;
    result->krylov += linear.iterations;
    result->newton++;
    pdi_steady_move(ctx, s, 1.0);
    return PD_OK;
}

/* ---- what is left of the divergence ---- */

/* y = lap q, both in the places of the pressure. Ports hold zero. */
static void pdi_steady_laplacian(void *user, const double *x, double *y)
{
    pdi_steady_user *u = (pdi_steady_user *)user;
    const pd_flow *flow = u->steady->flow;
    int64_t split = (int64_t)PD_DIM * flow->grid->total;
    double *q = u->steady->work;
    pdi_par_copy(u->ctx, flow->grid->total, x + split, q);
    pd_ghosts_scalar(&flow->bonds->ghosts, q);
    pdi_par_zero(u->ctx, split, y);
    pd_op_laplacian(u->ctx, flow->bonds, q, y + split);
}

static void pdi_steady_poisson(void *user, const double *x, double *y)
{
    pdi_steady_user *u = (pdi_steady_user *)user;
    int64_t split = (int64_t)PD_DIM * u->steady->flow->grid->total;
    pdi_par_zero(u->ctx, split, y);
    pd_multigrid_cycle(u->ctx, &u->steady->mg_p, x + split, y + split);
}

/* Solve lap q = div for the divergence that the tolerance has left, so that transport finds fluxes that carry as much
 * into a node as out of it, to rounding (eq. 4.10b). s->residual is the residual of the present state. */
static pd_status pdi_steady_solenoid(pd_ctx *ctx, pd_steady *s)
{
    pdi_steady_user user;
    pd_krylov_result linear;
    pd_krylov *k = &s->krylov;
    pd_flow *flow = s->flow;
    int32_t total = flow->grid->total;
    int64_t split = (int64_t)PD_DIM * total;
    int most = k->desc.max_iterations;
    user.ctx = ctx;
    user.steady = s;
    pdi_par_zero(ctx, split, s->residual);
    pdi_par_axpy(ctx, total, flow->speed / flow->length - 1.0, s->residual + split, s->residual + split);
    PDI_TRY(pdi_steady_setup(ctx, s, s->shift));
    k->desc.rtol = PDI_STEADY_EVEN;
    k->desc.atol = PDI_STEADY_ROUNDING * flow->speed / flow->length;
    k->desc.max_iterations = PDI_STEADY_EVEN_MOST;
    pd_status status = pd_krylov_solve(ctx, k, pdi_steady_laplacian, pdi_steady_poisson, &user, s->residual, s->step,
                                       &linear);
    /* compact pockets that long bonds join to the rest spoil the cycle */
    if (status > 0)
        status = pd_krylov_solve(ctx, k, pdi_steady_laplacian, NULL, &user, s->residual, s->step, &linear);
    k->desc.max_iterations = most;
    k->desc.atol = 0.0;
    if (status < 0) return status;
    pdi_par_copy(ctx, total, s->step + split, s->potential);
    pd_ghosts_scalar(&flow->bonds->ghosts, s->potential);
    flow->potential = s->potential;
    return PD_OK;
}

PDI_FN int32_t pdi_steady_worst(const pd_steady *s)
{
    int32_t total = s->flow->grid->total, worst = 0;
    double most = -1.0;
    for (int64_t i = 0; i < pdi_steady_size(s->flow); i++) {
        if (!(fabs(s->residual[i]) > most)) continue;
        most = fabs(s->residual[i]);
        worst = (int32_t)(i % total);
    }
    return worst;
}

pd_status pd_steady_solve(pd_ctx *ctx, pd_steady *s, pd_steady_result *result)
{
    char place[PDI_GRID_PLACE];
    pd_flow *flow = s->flow;
    int64_t start = flow->evaluations;
    double forcing = 0.1, least = s->norm0 > 0.0 ? PDI_STEADY_AGAIN : 1.0, boost = least;
    memset(result, 0, sizeof *result);
    double norm = pdi_steady_residual(ctx, s, result);
    s->norm0 = fmax(s->norm0, norm);
    for (;;) {
        result->evaluations = flow->evaluations - start;
        if (!(norm < 1e300))
            return pdi_fail(ctx, PD_ERR_DIVERGED, "steady", "the flow residual is %g after %d Newton steps", norm,
                            result->newton);
        result->converged = result->momentum <= s->desc.tolerance && result->continuity <= s->desc.tolerance;
        if (result->converged) return pdi_steady_solenoid(ctx, s);
        if (result->newton >= s->desc.max_newton) return PD_NOT_CONVERGED;
        if (boost > PDI_STEADY_MAX_BOOST)
            return pdi_fail(ctx, PD_ERR_DIVERGED, "steady",
                            "no pseudo time step lowers the flow residual of %g (%d Newton steps), which is largest at "
                            "%s m. Refine the grid or lower the Reynolds number", norm, result->newton,
                            pdi_grid_place(flow->grid, pdi_steady_worst(s), place));
        /* switched evolution relaxation: the pseudo time step grows as the residual falls (eq. 4.10) */
        double shift = PDI_STEADY_SHIFT * boost * flow->speed / flow->length * sqrt(norm / s->norm0);
        int effort = 0;
        PDI_TRY(pdi_steady_setup(ctx, s, shift));
        PDI_TRY(pdi_steady_newton(ctx, s, forcing, result, &effort));
        double fresh = pdi_steady_residual(ctx, s, result);
        if (!(fresh < PDI_STEADY_GROWTH * norm)) {
            pdi_steady_move(ctx, s, -1.0);
            norm = pdi_steady_residual(ctx, s, result);
            boost *= 10.0;
            continue;
        }
        /* a linear system that is hard to solve gets a shorter pseudo time step next time, an easy one a longer one */
        if (effort > s->desc.max_krylov) boost *= 10.0;
        else if (effort > PDI_STEADY_HARD) boost *= 2.0;
        else if (effort < PDI_STEADY_EASY) boost = fmax(least, boost * 0.5);
        /* Eisenstat and Walker 1996, choice 2: solve as well as the last step predicts, no better than asked for */
        double excess = fmax(result->momentum, result->continuity) / s->desc.tolerance;
        forcing = fmax(0.9 * (fresh / norm) * (fresh / norm), PDI_STEADY_ENOUGH / fmax(excess, 1.0));
        forcing = fmin(0.1, fmax(1e-3, forcing));
        norm = fresh;
    }
}

PDI_FN pd_status pdi_steady_stage(pd_ctx *ctx, pd_steady *s, double rate, const double *target, double tolerance,
                                  int again, pd_steady_result *result)
{
    pd_flow *flow = s->flow;
    int64_t start = flow->evaluations;
    pd_status status = PD_OK;
    /* an error of the velocity shows in the residual `rate` times as large */
    double least = fmin(1.0, flow->speed / (flow->length * rate)), before = HUGE_VAL;
    memset(result, 0, sizeof *result);
    s->rate = rate;
    s->target = target;
    for (;;) {
        double norm = pdi_steady_residual(ctx, s, result);
        result->evaluations = flow->evaluations - start;
        double excess = fmax(least * result->momentum, result->continuity) / tolerance;
        result->converged = excess <= 1.0;
        if (result->converged || !(norm < before) || result->newton >= PDI_STEADY_STAGE) break;
        int effort = 0;
        before = norm;
        double forcing = fmin(PDI_STEADY_STAGE_FORCING, fmax(1e-4, PDI_STEADY_STAGE_ENOUGH / excess));
        if (!again) status = pdi_steady_setup(ctx, s, rate);
        if (status < 0) break;
        again = 1;
        status = pdi_steady_newton(ctx, s, forcing, result, &effort);
        if (status < 0) break;
    }
    s->rate = 0.0;
    s->target = NULL;
    if (pdi_lacks_memory(status)) return status;
    return result->converged ? PD_OK : PD_RETRY;
}

PDI_FN pd_status pdi_steady_store(pd_ctx *ctx, pd_steady *s, pd_store *store)
{
    if (store->reading) s->flow->potential = s->potential;
    PDI_TRY(PDI_STORE(ctx, store, "steady.potential", s->potential, s->flow->grid->total));
    return PDI_STORE(ctx, store, "steady.norm0", &s->norm0, 1);
}

void pd_steady_free(pd_ctx *ctx, pd_steady *s)
{
    int64_t size = s->flow ? pdi_steady_size(s->flow) : 0;
    pdi_compact_free(ctx, &s->compact_u);
    pdi_compact_free(ctx, &s->compact_p);
    pd_multigrid_free(ctx, &s->mg_u);
    pd_multigrid_free(ctx, &s->mg_p);
    pd_krylov_free(ctx, &s->krylov);
    pdi_product_free(ctx, &s->product);
    PDI_DELETE(ctx, size, s->residual);
    PDI_DELETE(ctx, size, s->step);
    PDI_DELETE(ctx, size, s->work);
    PDI_DELETE(ctx, s->flow ? s->flow->grid->total : 0, s->potential);
    if (s->flow) s->flow->potential = NULL;
    PDI_DELETE(ctx, s->flow ? (int64_t)PD_DIM * s->flow->grid->total : 0, s->carrier);
    memset(s, 0, sizeof *s);
}
