/* transport: see transport.h
 *
 * Implicit steps solve for corrections, so inlet values need no place in the Krylov vectors.
 */
#include "transport/transport.h"
#include "transport/steep.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Steps along bonds far below this share of the field are upwinded. */
#define PDI_TRANSPORT_FAINT 1e-4
/* A residual over its tolerance that counts as missed, and the most pairs of sweeps behind a multigrid cycle then. */
#define PDI_TRANSPORT_MISSED 10.0
#define PDI_TRANSPORT_SWEEPS 64
/* The shortest step along their direction. */
#define PDI_TRANSPORT_SHORTEST 0.03
/* Share of the spreading of upwind fluxes in the preconditioner of limited ones, which give most of it back. */
#define PDI_TRANSPORT_SPREAD 0.3
/* Iterations after which the next step factors anew. */
#define PDI_TRANSPORT_AGAIN 4
/* A step that leaves more than this share of the residual ends the iteration. */
#define PDI_TRANSPORT_STALLED 0.999
/* Share of the largest value by which a field may leave its bounds: rounding of the linear solve. */
#define PDI_TRANSPORT_SLACK 3e-10
/* Tolerances over the final one: enough to limit (the last solve, with fluxes that stay, is cheaper by far); the same
 * where bounds are broken after that; and enough to see them broken. */
#define PDI_TRANSPORT_ENOUGH 1000.0
#define PDI_TRANSPORT_FINISHED 30.0
#define PDI_TRANSPORT_ROUGH 30.0
/* Basis vectors of a solve at rest that there is room for from the start: most take no more. */
#define PDI_TRANSPORT_LEAST 4
/* A change of the field, relative, that is none. */
#define PDI_TRANSPORT_STILL 1e-10
/* The same where what is left undone breaks them. */
#define PDI_TRANSPORT_FINE 1e-3

/* The share of one thread in a copy less a mean. */
static void pdi_transport_less(const pd_transport *t, const double *c, double mean)
{
    const uint8_t *kind = t->grid->kind;
    PDI_FOR_NOWAIT
    for (int32_t i = 0; i < t->grid->total; i++) {
        int none = kind[i] == PD_SOLID || kind[i] == PD_WALL || kind[i] == PD_INACTIVE;
        t->repeated[i] = none ? 0.0 : c[i] - mean;
    }
}

/* A copy with images. At rest it is less its mean, which bonds do not carry: products of lines are differences of sums,
 * and have the rounding of what is summed. Metal and walls have no concentration where sweeps go over them. */
static void pdi_transport_repeat(const pd_ctx *ctx, const pd_transport *t, const double *c)
{
    int nt = pd_par_threads(ctx, t->grid->total);
    if (t->flux.conductance.rests) {
        double sum = pdi_grid_sum_field(ctx, t->grid, PD_FLUID, NULL, 0, c);
        PDI_PARALLEL_CALL(nt,
                          pdi_transport_less(t, c, t->grid->fluid_count ? sum / (double)t->grid->fluid_count : 0.0));
    } else pdi_par_copy(ctx, t->grid->total, c, t->repeated);
    pd_ghosts_set_scalar(&t->bonds->ghosts, t->repeated);
}

/* exact: amounts are kept but for rounding of what bonds carry. */
static void pdi_transport_sweep(const pd_ctx *ctx, const pd_transport *t, const double *c, int exact, double *y)
{
    pd_flux flux = t->flux;
    flux.rate = t->dt > 0.0 ? 1.0 / t->dt : 0.0;
    flux.exact = exact;
    flux.plain = t->flux.conductance.rests ? c : NULL;
    if (t->repeated) pdi_transport_repeat(ctx, t, c);
    pdi_flux_apply(ctx, &flux, t->repeated ? t->repeated : c, y);
}

PDI_FN void pdi_transport_operator(const pd_ctx *ctx, const pd_transport *t, const double *c, double *y)
{
    pdi_transport_sweep(ctx, t, c, 1, y);
}

/* Upwinded nodes keep nothing. */
static void pdi_transport_silence(const pd_transport *t, double *factor)
{
    if (!t->upwinding) return;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->upwinded[i]) factor[i] = 0.0;
    pd_ghosts_set_scalar(&t->bonds->ghosts, factor);
}

PDI_FN void pdi_transport_anti(const pd_ctx *ctx, pd_transport *t, double *c, double *out)
{
    pd_ghosts_set_scalar(&t->bonds->ghosts, c);
    pdi_limiter_update(ctx, &t->limiter, c, PDI_TRANSPORT_FAINT * t->size);
    pdi_transport_silence(t, t->limiter.factor);
    pdi_flux_anti(ctx, &t->flux, c, out);
}

static pd_arena *pdi_transport_arena(pd_transport *t) { return t->desc.arena ? t->desc.arena : &t->own; }

/* What the solver callbacks see. */
typedef struct pdi_transport_user {
    pd_ctx *ctx;
    pd_transport *t;
    int limited; /* 1: there are antidiffusive fluxes */
    int factored; /* 1: their derivatives are factored */
} pdi_transport_user;

/* Nodes that hold their concentration have no equation. */
static void pdi_transport_pin(const pd_transport *t, double *y)
{
    for (int32_t k = 0; k < t->pinned_count; k++) y[t->pinned[k]] = 0.0;
}

static pdi_transport_user pdi_transport_see(pd_ctx *ctx, pd_transport *t)
{
    pdi_transport_user user;
    memset(&user, 0, sizeof user);
    user.ctx = ctx;
    user.t = t;
    return user;
}

static void pdi_transport_apply(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pdi_transport_sweep(u->ctx, u->t, x, 0, y);
    pdi_transport_pin(u->t, y);
}

/* y = A x less the derivative of the limited fluxes along x at the present field, whose fluxes were computed last. */
static void pdi_transport_jacobian(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pd_transport *t = u->t;
    int32_t total = t->grid->total;
    const uint8_t *kind = t->grid->kind;
    /* fluxes and right-hand side are computed again after the solve */
    double *slope_by = t->probe, *factor_by = t->rhs, *along = t->anti;
    int nt = pd_par_threads(u->ctx, (int64_t)total * 4);
    (void)nt;
    pdi_transport_apply(user, x, y);
    if (!u->limited) return;
    if (t->repeated) x = t->repeated; /* with its images, by now */
    pdi_limiter_derive(u->ctx, &t->limiter, t->c, x, PDI_TRANSPORT_FAINT * t->size, factor_by, slope_by);
    pdi_transport_silence(t, factor_by);
    pdi_flux_anti_by(u->ctx, &t->flux, t->c, x, factor_by, slope_by, along);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        if (kind[i] == PD_FLUID) y[i] -= along[i];
    pdi_transport_pin(t, y);
}

static void pdi_transport_precondition(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    if (u->factored) {
        pdi_factor_solve(u->ctx, &u->t->factors, x, y);
        pdi_transport_pin(u->t, y);
        return;
    }
    pdi_inverse_apply(u->ctx, &u->t->inverse, x, y);
    pd_flux flux = u->t->flux;
    flux.rate = 1.0 / u->t->dt;
    for (int sweep = 0; sweep < 2 * u->t->sweeping; sweep++) pdi_flux_relax(&flux, x, sweep & 1, y);
    pdi_transport_pin(u->t, y);
}

/* The right-hand side of all nodes, where it is kept. */
static void pdi_transport_right_side(const pd_ctx *ctx, pd_transport *t)
{
    const uint8_t *kind = t->grid->kind;
    int nt = pd_par_threads(ctx, t->grid->total * 4);
    (void)nt;
    if (!t->rhs) return;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < t->grid->total; i++) t->rhs[i] = kind[i] == PD_FLUID ? pdi_transport_right(t, i) : 0.0;
}

/* residual = rhs - A c at fluid nodes, into out. */
PDI_FN void pdi_transport_residual(const pd_ctx *ctx, const pd_transport *t, double *out)
{
    const uint8_t *kind = t->grid->kind;
    int nt = pd_par_threads(ctx, t->grid->total * 4);
    (void)nt;
    pdi_transport_sweep(ctx, t, t->c, !t->rough, out);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (kind[i] == PD_FLUID) out[i] = (t->rhs ? t->rhs[i] : pdi_transport_right(t, i)) - out[i];
        else out[i] = 0.0;
    }
}

/* The size of the field grows to that of now, as far as its bounds allow: 1 when it has grown. */
static int pdi_transport_measure(pd_transport *t)
{
    double had = t->size;
    pdi_bounds of = {0.0, 0.0};
    pdi_bounds_take_all(t->grid, PD_FLUID, t->c, &of);
    pdi_bounds_take_inlets(&t->bonds->ghosts, t->c, &of);
    t->size = pd_max(had, pd_min(pd_max(of.high, -of.low), t->most));
    return t->size > had;
}

/* A linear system with the right-hand side t->work, and the solution behind it. */
static pd_status pdi_transport_linear(pd_ctx *ctx, pd_transport *t, pd_apply_fn apply, pdi_transport_user *user,
                                      pd_krylov_result *linear)
{
    pd_arena *arena = pdi_transport_arena(t);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_krylov_list, &t->krylov));
    pd_status status = pd_krylov_solve(ctx, &t->krylov, apply, pdi_transport_precondition, user, t->work,
                                       t->work + t->grid->total, linear);
    return pdi_arena_release(ctx, arena, pdi_krylov_list, &t->krylov, status);
}

/* Solve A delta = rhs - A c to an absolute tolerance and add delta to c. known: `work` holds the right-hand side. */
static pd_status pdi_transport_solve(pd_ctx *ctx, pd_transport *t, int known, double atol, pd_transport_result *result,
                                     double *moved)
{
    pdi_transport_user user = pdi_transport_see(ctx, t);
    pd_krylov_result linear;
    double *residual = t->work, *delta = t->work + t->grid->total;
    if (!known) pdi_transport_residual(ctx, t, residual);
    if (!known) pdi_transport_pin(t, residual);
    t->krylov.desc.rtol = 1e-15;
    t->krylov.desc.atol = atol;
    pd_status status = pdi_transport_linear(ctx, t, pdi_transport_apply, &user, &linear);
    if (status < 0) return status;
    result->krylov += linear.iterations;
    result->residual = linear.residual;
    pdi_par_axpy(ctx, t->grid->total, 1.0, delta, t->c); /* zero but at fluid nodes */
    *moved = pdi_par_max_abs(ctx, t->grid->total, delta);
    pdi_transport_measure(t);
    return status;
}

PDI_FN pd_status pdi_transport_refine(pd_ctx *ctx, pd_transport *t, double share, pd_transport_result *result)
{
    pdi_transport_user user = pdi_transport_see(ctx, t);
    pd_krylov_result linear;
    t->krylov.desc.rtol = share;
    t->krylov.desc.atol = 0.0;
    pd_status status = pdi_transport_linear(ctx, t, pdi_transport_apply, &user, &linear);
    result->krylov += linear.iterations;
    return status;
}

PDI_FN int pdi_transport_fresh(pd_ctx *ctx, pd_transport *t)
{
    int limited = pdi_transport_limits(t);
    if (limited) pdi_transport_anti(ctx, t, t->c, t->anti);
    return limited;
}

/* The same, with a better preconditioner for the rest of the step wherever it misses its tolerance by far. */
static pd_status pdi_transport_correct(pd_ctx *ctx, pd_transport *t, int known, double atol,
                                       pd_transport_result *result, double *moved)
{
    /* beside a good conductor what is left is rounding (theory: 6.14) */
    int most = t->diffusion.field ? 1 : PDI_TRANSPORT_SWEEPS;
    pd_status status = pdi_transport_solve(ctx, t, known, atol, result, moved);
    while (status > 0 && result->residual > PDI_TRANSPORT_MISSED * atol && t->sweeping < most) {
        t->sweeping = t->sweeping ? 4 * t->sweeping : 1;
        status = pdi_transport_solve(ctx, t, 0, atol, result, moved);
    }
    return status;
}

PDI_FN void pdi_transport_bounds(const pd_transport *t, const double *start, double slack, pdi_bounds *b)
{
    b->low = t->passed[0];
    b->high = pd_max(t->passed[1], 0.0);
    pdi_bounds source = {0.0, 0.0}, absorb = {0.0, 0.0};
    pdi_bounds_take_all(t->grid, PD_FLUID, start, b);
    pdi_bounds_take_inlets(&t->bonds->ghosts, t->c, b);
    pdi_bounds_take_all(t->grid, PD_FLUID, t->source, &source);
    pdi_bounds_take_all(t->grid, PD_FLUID, t->absorb, &absorb);
    if (source.low < 0.0) b->low = -HUGE_VAL;
    if (absorb.high > 0.0) b->low = pd_min(b->low, 0.0);
    if (source.high > 0.0) b->high = pd_max(b->high, t->ceiling);
    for (int32_t k = 0; k < t->pinned_count; k++) pdi_bounds_take(t->c[t->pinned[k]], b);
    if (t->diffusion.wall_rate) {
        b->low = pd_min(b->low, t->diffusion.held_least);
        b->high = pd_max(b->high, t->diffusion.held_most);
    }
    pdi_bounds_widen(t->grid, t->c, slack, b);
}

/* Mark the nodes outside of the bounds, and where that has not helped their neighbours too, whose antidiffusive fluxes
 * reach them from upstream; how many are new. */
PDI_FN int64_t pdi_transport_mark(pd_transport *t, double slack)
{
    pdi_bounds bounds;
    pdi_transport_bounds(t, t->old, slack, &bounds);
    int64_t found = pdi_bounds_mark(t->bonds, t->c, &bounds, t->upwinded);
    t->upwinding = t->upwinding || found > 0;
    return found;
}

/* Begin a step: no node is upwinded, and the size of the field is that of now. Returns 1 when fluxes are limited. */
PDI_FN int pdi_transport_start(pd_transport *t)
{
    pdi_bounds bounds;
    memset(t->upwinded, 0, (size_t)t->grid->total);
    t->upwinding = t->sweeping = 0;
    t->size = t->diffusion.wall_rate ? pd_max(t->diffusion.held_most, 0.0) : 0.0;
    pdi_transport_bounds(t, t->old, 0.0, &bounds);
    t->most = pd_max(fabs(bounds.low), fabs(bounds.high));
    pdi_transport_measure(t);
    return pdi_transport_limits(t);
}

PDI_FN int pdi_transport_within(const pd_transport *t, const double *start)
{
    pdi_bounds bounds;
    pdi_transport_bounds(t, start, PDI_TRANSPORT_SLACK, &bounds);
    return pdi_bounds_keep(t->grid, t->c, NULL, &bounds);
}

/* 1 when the field is within its bounds, and would be with what is left undone, too: the next step delivers that. A
 * cycle of the multigrid shows what becomes of it: next to nothing in the stream, dt times as much where little
 * passes. */
static int pdi_transport_settles(pd_ctx *ctx, pd_transport *t)
{
    pdi_transport_user user = pdi_transport_see(ctx, t);
    pdi_bounds bounds;
    pdi_transport_bounds(t, t->old, PDI_TRANSPORT_SLACK, &bounds);
    if (!pdi_bounds_keep(t->grid, t->c, NULL, &bounds)) return 0;
    pdi_transport_residual(ctx, t, t->work);
    pdi_transport_pin(t, t->work);
    pdi_transport_precondition(&user, t->work, t->work + t->grid->total);
    return pdi_bounds_keep(t->grid, t->c, t->work + t->grid->total, &bounds);
}

/* The last solve; known as above. What it leaves undone counts times dt in nodes that little passes: where the field
 * leaves its bounds by that, it is solved better. Sweeps that do not help end with it. */
static pd_status pdi_transport_close(pd_ctx *ctx, pd_transport *t, int known, double atol, pd_transport_result *result,
                                     double *moved)
{
    pd_status status = pdi_transport_correct(ctx, t, known, atol, result, moved);
    int before = t->sweeping, sweeps = before || status > 0, settled = 0;
    if (status < 0 || pdi_transport_settles(ctx, t)) return status;
    for (; sweeps < 2 && status >= 0 && !settled; sweeps++) {
        if (sweeps && !t->sweeping) t->sweeping = 1;
        status = pdi_transport_solve(ctx, t, 0, PDI_TRANSPORT_FINE * atol, result, moved);
        settled = status >= 0 && pdi_transport_settles(ctx, t);
    }
    if (!settled) t->sweeping = before;
    return status < 0 || result->residual > atol ? status : PD_OK; /* rounding may stop it before that */
}

/* Antidiffusive fluxes, right-hand side and residual of the present field; returns the norm of the residual. */
static double pdi_transport_evaluate(pd_ctx *ctx, pd_transport *t)
{
    pdi_transport_anti(ctx, t, t->c, t->anti);
    pdi_transport_right_side(ctx, t);
    pdi_transport_residual(ctx, t, t->work);
    pdi_transport_pin(t, t->work);
    return sqrt(pdi_par_dot(ctx, t->grid->total, t->work, t->work));
}

/* The direction of a step: the residual in t->work, solved for with the derivative of the limited fluxes. Where that
 * cannot be solved for, these fluxes stay, and what is left is an M-matrix. */
static pd_status pdi_transport_direction(pdi_transport_user *user, double loose, double goal,
                                         pd_transport_result *result)
{
    pd_transport *t = user->t;
    pd_krylov_result linear;
    pd_status status = PD_OK;
    user->limited = pdi_par_max_abs(user->ctx, t->grid->total, t->anti) > 0.0;
    if (user->limited) {
        pdi_flux_differentiate(user->ctx, &t->flux, t->c);
        if (!t->factors.good || t->factors.took > PDI_TRANSPORT_AGAIN)
            pdi_factor_make(user->ctx, &t->factors, t->c, 1.0 / t->dt, PDI_TRANSPORT_FAINT * t->size);
        user->factored = t->factors.good;
    }
    for (int attempt = 0; attempt < 3; attempt++) {
        t->krylov.desc.rtol = user->limited ? loose : PDI_KRYLOV_FORCING_MIN; /* flat fields may be limited after it */
        t->krylov.desc.atol = 0.5 * goal;
        status = pdi_transport_linear(user->ctx, t, pdi_transport_jacobian, user, &linear);
        if (status < 0) return status;
        result->krylov += linear.iterations;
        if (user->factored) t->factors.took = linear.iterations;
        if (status == PD_OK || !user->limited) break;
        if (!user->factored) user->limited = 0;
        user->factored = 0;
    }
    return PD_OK;
}

/* A step along the direction, which is zero at all ghosts, halved until the residual falls: the share that is left. */
static double pdi_transport_shorten(pd_ctx *ctx, pd_transport *t, double *norm)
{
    double before = *norm, share = 1.0;
    for (double by = 1.0;; by = -share) {
        pdi_par_axpy(ctx, t->grid->total, by, t->work + t->grid->total, t->c);
        *norm = pdi_transport_evaluate(ctx, t);
        if (!(*norm > before) || share <= PDI_TRANSPORT_SHORTEST) return share;
        share *= 0.5;
    }
}

/* Newton's method on the limited equations until their residual falls below `goal` [mol/m3/s] or a whole step moves the
 * field by `still` [-] at most: where limiters bend, damped steps go on for long and change nothing else. Its
 * linear systems are solved as well as the last step paid (Eisenstat and Walker 1996); a step that does not lower the
 * residual is halved. */
static pd_status pdi_transport_newton(pd_ctx *ctx, pd_transport *t, double goal, double still,
                                      pd_transport_result *result)
{
    pdi_transport_user user = pdi_transport_see(ctx, t);
    double norm = pdi_transport_evaluate(ctx, t), loose = PDI_KRYLOV_FORCING_MAX;
    pd_status status = PD_OK;
    t->krylov.desc.fixed_restart = 0; /* waves from node to node that the limiter hardly damps need the whole space */
    /* else rounding is far below what is asked for */
    pdi_krylov_set_flexible(&t->krylov, pdi_compact_operator_is_stretched(t->grid->h));
    pdi_factor_lend(ctx, pdi_transport_arena(t), &t->krylov, &t->factors);
    if (t->flux.flux)
        pdi_bend_lend(ctx, pdi_transport_arena(t), t->size, t->flow->velocity_scale / t->grid->h[0], &t->krylov,
                      &t->flux.bend);
    while (result->limiter < t->desc.max_limiter && norm > goal) {
        status = pd_check_cancel(ctx, "transport: Newton", result->limiter);
        if (status < 0) break;
        status = pdi_transport_direction(&user, loose, goal, result);
        if (status < 0) break;
        double before = norm, moved = pdi_par_max_abs(ctx, t->grid->total, t->work + t->grid->total);
        double share = pdi_transport_shorten(ctx, t, &norm), left = norm / before;
        if (pdi_transport_measure(t)) norm = pdi_transport_evaluate(ctx, t);
        result->change = t->size > 0.0 ? share * moved / t->size : 0.0;
        result->limiter++;
        if (moved <= still * t->size || left > PDI_TRANSPORT_STALLED) break;
        loose = pdi_krylov_forcing_linear(left);
    }
    t->krylov.desc.fixed_restart = 1;
    pdi_krylov_free_growth(ctx, &t->krylov);
    status = pdi_bend_return(ctx, pdi_transport_arena(t), status, &t->krylov, &t->flux.bend);
    status = pdi_factor_return(ctx, pdi_transport_arena(t), status, &t->krylov, &t->factors);
    pdi_krylov_set_flexible(&t->krylov, 1);
    return status < 0 ? status : PD_OK;
}

/* The limiter bounds a converged field; where the iteration has left the field outside of its bounds, the nodes
 * concerned lose their antidiffusive fluxes until none is left. Fluxes are limited, values never. */
static pd_status pdi_transport_enforce(pd_ctx *ctx, pd_transport *t, double atol, pd_transport_result *result)
{
    double moved;
    pd_status status = PD_OK;
    for (int round = 0; round <= PDI_TRANSPORT_ROUNDS; round++) {
        if (pdi_transport_within(t, t->old)) {
            /* the last solve moves a field whose fluxes have not settled: it has to stay within the bounds, too */
            status = pdi_transport_close(ctx, t, 0, atol, result, &moved);
            if (status < 0 || pdi_transport_within(t, t->old)) return status;
        }
        /* what solves have left undone may be all that is outside: nodes upwinded for it would be chosen by rounding */
        if (!round) PD_TRY(pdi_transport_newton(ctx, t, PDI_TRANSPORT_FINISHED * atol, PDI_TRANSPORT_STILL, result));
        int64_t marked = round ? pdi_transport_mark(t, PDI_TRANSPORT_SLACK) : 0;
        if (round == PDI_TRANSPORT_ROUNDS) pdi_par_zero(ctx, t->grid->total, t->anti);
        else pdi_transport_anti(ctx, t, t->c, t->anti);
        pdi_transport_right_side(ctx, t);
        status = pdi_transport_correct(ctx, t, 0, (marked ? PDI_TRANSPORT_ROUGH : PDI_TRANSPORT_FINE) * atol, result,
                                       &moved);
        if (status < 0) return status;
        result->bounded = round;
    }
    return pdi_transport_close(ctx, t, 0, atol, result, &moved);
}

static pd_status pdi_transport_iterate(pd_ctx *ctx, pd_transport *t, double atol, int bounded,
                                       pd_transport_result *result)
{
    double moved = 0.0;
    if (!pdi_transport_start(t)) {
        /* with the residual of the stage */
        pd_status status = t->rough || !bounded ? pdi_transport_correct(ctx, t, 1, atol, result, &moved)
                                                : pdi_transport_close(ctx, t, 1, atol, result, &moved);
        result->change = t->size > 0.0 ? moved / t->size : 0.0;
        return status;
    }
    PD_TRY(pdi_transport_newton(ctx, t, PDI_TRANSPORT_ENOUGH * atol, t->desc.limiter_tolerance, result));
    if (bounded) return pdi_transport_enforce(ctx, t, atol, result);
    return pdi_transport_correct(ctx, t, 0, atol, result, &moved);
}

/* Size of the equations: the right-hand side, with sources as they are at the present field. */
static double pdi_transport_given(const pd_ctx *ctx, pd_transport *t)
{
    double *given = t->work + t->grid->total;
    int nt = pd_par_threads(ctx, t->grid->total * 2);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < t->grid->total; i++)
        given[i] = t->grid->kind[i] == PD_FLUID ? pdi_transport_right(t, i) - t->absorb[i] * t->c[i] : 0.0;
    return sqrt(pdi_par_dot(ctx, t->grid->total, given, given));
}

PDI_FN pd_status pdi_transport_first(pd_ctx *ctx, pd_transport *t, double dt)
{
    t->dt = dt;
    PD_TRY(pdi_flux_refresh(ctx, &t->flux));
    pdi_transport_right_side(ctx, t);
    pdi_transport_residual(ctx, t, t->work);
    return PD_OK;
}

PDI_FN pd_status pdi_transport_stage(pd_ctx *ctx, pd_transport *t, double dt, int bounded, pd_transport_result *result)
{
    int32_t total = t->grid->total;
    memset(result, 0, sizeof *result);
    PD_TRY(pdi_transport_first(ctx, t, dt));
    PD_TRY(pdi_inverse_setup(ctx, &t->inverse, 1.0 / dt, t->pinned, t->pinned_count));
    pdi_transport_pin(t, t->work);
    double first = sqrt(pdi_par_dot(ctx, total, t->work, t->work)), size = pd_max(pdi_transport_given(ctx, t), first);
    double atol = t->desc.tolerance * size;
    /* the limiter turns what is left of linear systems into other fluxes */
    double loose = t->flow ? PDI_KRYLOV_FORCING_MIN : pdi_krylov_forcing(t->first > 0.0 ? first / t->first : 1.0);
    if (t->rough) atol = pd_max(atol, first * loose);
    t->first = first;
    pd_status status = size > 0.0 ? pdi_transport_iterate(ctx, t, atol, bounded, result) : PD_OK;
    if (status < 0) return status;
    result->residual = size > 0.0 ? result->residual / size : 0.0;
    pdi_transport_boundary(ctx, t);
    return result->residual <= 10.0 * t->desc.tolerance ? PD_OK : status;
}

PDI_FN pd_status pdi_transport_solves(pd_ctx *ctx, const pd_transport *t)
{
    if (!t->desc.given) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "transport", "the field is given: there are no steps to take");
}

PDI_FN pd_status pdi_transport_begin(pd_ctx *ctx, pd_transport *t, double dt)
{
    if (!(dt > 0.0) || !(dt < 1e300))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    PD_TRY(pdi_transport_solves(ctx, t));
    PD_TRY(pdi_transport_hold(ctx, t));
    t->inverse.fresh = 0;
    t->first = 0.0;
    pdi_par_copy(ctx, t->grid->total, t->c, t->old);
    pdi_transport_open(t);
    if (t->rest) pdi_par_zero(ctx, t->grid->total, t->rest);
    return PD_OK;
}

PDI_FN pd_status pdi_transport_end(pd_ctx *ctx, pd_transport *t, double dt, pd_status status)
{
    if (status < 0 || status == PD_RETRY) {
        pdi_par_copy(ctx, t->grid->total, t->old, t->c);
        return pdi_transport_release(ctx, t, status);
    }
    pdi_transport_right_side(ctx, t); /* sources may have been settled after the last stage */
    pdi_transport_residual(ctx, t, t->work);
    for (int32_t i = 0; i < t->grid->total; i++) t->carry[i] = dt * t->work[i];
    return pdi_transport_release(ctx, t, status);
}

pd_status pd_transport_implicit(pd_ctx *ctx, pd_transport *t, double dt, pd_transport_result *result)
{
    PD_TRY(pdi_transport_begin(ctx, t, dt));
    return pdi_transport_end(ctx, t, dt, pdi_transport_stage(ctx, t, dt, 1, result));
}

/* What is held and enters now goes into the bounds of the step. */
static void pdi_transport_pass(pd_transport *t)
{
    pdi_bounds of = {t->passed[0], t->passed[1]};
    pdi_bounds_take_inlets(&t->bonds->ghosts, t->c, &of);
    t->passed[0] = of.low;
    t->passed[1] = of.high;
    if (!t->diffusion.wall_rate) return;
    t->passed[0] = pd_min(t->passed[0], t->diffusion.held_least);
    t->passed[1] = pd_max(t->passed[1], t->diffusion.held_most);
}

static pd_status pdi_transport_inlets(pd_ctx *ctx, pd_transport *t)
{
    for (int32_t i = 0; i < t->grid->total; i++) {
        double x[PD_DIM];
        if (t->grid->kind[i] != PD_INLET) continue;
        pd_grid_position(t->grid, i, x);
        pdi_grid_fold_position_images(t->grid, x);
        for (int d = 0; d < PD_DIM; d++) x[d] = pd_min(pd_max(x[d], t->grid->lo[d]), t->grid->hi[d]);
        t->c[i] = t->desc.entering ? t->desc.entering(t->desc.user, x) : t->desc.inlet;
        if (!(t->c[i] >= 0.0) || !(t->c[i] < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "transport",
                           "C = %g mol/m3 enters at x = %g m and t = %g s, expected a finite value of at least 0",
                           t->c[i], x[0], t->time);
    }
    return PD_OK;
}

/* Walls hold no less than nothing. */
static pd_status pdi_transport_holds(pd_ctx *ctx, const pd_transport *t)
{
    const pd_diffusion *d = &t->diffusion;
    if (!d->wall_rate || (d->held_least >= 0.0 && d->held_most < 1e100)) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "transport",
                   "a wall holds C = %g mol/m3 at t = %g s, expected a finite value of at least 0",
                   d->held_least >= 0.0 ? d->held_most : d->held_least, t->time);
}

PDI_FN pd_status pdi_transport_at(pd_ctx *ctx, pd_transport *t, double time)
{
    t->inverse.fresh = 0;
    if (!t->desc.clock) return PD_OK;
    pdi_transport_pass(t);
    *t->desc.clock = t->time = time;
    PD_TRY(pdi_transport_inlets(ctx, t));
    if (t->diffusion.wall_rate) pdi_diffusion_renew(&t->diffusion);
    return pdi_transport_holds(ctx, t);
}

pd_status pd_transport_update(pd_ctx *ctx, pd_transport *t)
{
    if (t->desc.given) return PD_OK;
    t->inverse.fresh = 0;
    if (t->desc.clock) *t->desc.clock = t->time;
    PD_TRY(pdi_diffusion_update(ctx, &t->diffusion));
    PD_TRY(pdi_transport_inlets(ctx, t));
    PD_TRY(pdi_open_boundary_update(ctx, &t->boundary));
    return pdi_flux_fit(ctx, &t->flux);
}

PDI_COLD_BEGIN
PDI_FN void pdi_transport_list(pdi_array_visitor *owner, void *object)
{
    pd_transport *transport = (pd_transport *)object;
    if (!transport->grid) return;
    int64_t total = transport->grid->total;
    PDI_ARRAY_STATE(owner, transport, c, total, "mol/m3");
    PDI_ARRAY_STATE(owner, transport, carry, total, "mol/m3");
    PDI_ARRAY(owner, transport, source, total, "mol/m3/s");
    PDI_ARRAY(owner, transport, absorb, total, "1/s");
    if (transport->desc.given) return;
    if (pdi_transport_limits(transport)) PDI_ARRAY_STATE(owner, transport, anti, total, "mol/m3/s");
    PDI_ARRAY(owner, transport, upwinded, total, "1");
    if (transport->desc.field) PDI_ARRAY_STATE(owner, transport, rest, total, "mol/m3");
    if (transport->desc.clock) PDI_SCALAR_STATE(owner, transport, time, "s");
}

/* What is lent for a step. */
static void pdi_transport_work_list(pdi_array_visitor *owner, void *object)
{
    pd_transport *transport = (pd_transport *)object;
    int64_t total = transport->grid->total;
    int limits = pdi_transport_limits(transport), repeats = pdi_transport_repeats(transport);
    PDI_ARRAY_UNINIT(owner, transport, old, total, "mol/m3");
    if (limits) PDI_ARRAY_UNINIT(owner, transport, rhs, total, "mol/m3/s");
    PDI_ARRAY_UNINIT(owner, transport, work, 2 * total, "");
    if (limits) PDI_ARRAY(owner, transport, probe, PD_DIM * total, "mol/m4");
    if (repeats) PDI_ARRAY_UNINIT(owner, transport, repeated, pdi_transport_repeated(transport), "mol/m3");
    if (limits) pdi_limiter_list(owner, &transport->limiter);
    pdi_flux_list(owner, &transport->flux);
    if (!transport->lean) pdi_inverse_list(owner, &transport->inverse);
}

static void pdi_transport_krylov(pd_transport *t, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->equations = "transport";
    kd->n = t->grid->total;
    kd->spans = &t->bonds->active_ranges;
    kd->components = 1;
    kd->restart = 20;
    kd->initial_vectors = t->flow ? 0 : PDI_TRANSPORT_LEAST;
    kd->max_vectors = t->flow ? 10 * kd->restart : 0;
    kd->arena = pdi_transport_arena(t);
    kd->fixed_restart = 1;
    kd->flexible = 1;
    kd->zero_guess = 1;
    /* in which a good conductor's level drowns */
    kd->basis_precision = t->desc.field ? PD_KRYLOV_DOUBLE : PD_KRYLOV_SINGLE;
}

PDI_FN pd_status pdi_transport_plan(pd_ctx *ctx, pd_transport *t)
{
    pd_krylov_desc kd;
    pd_multigrid_desc md;
    pdi_transport_krylov(t, &kd);
    pdi_compact_operator_multigrid_desc(t->grid, &md);
    md.symmetric = t->flow == NULL;
    md.high_contrast = md.high_contrast || t->desc.field != NULL;
    md.arena = pdi_transport_arena(t);
    md.caller_fields = pdi_transport_repeats(t);
    t->inverse.flux = t->factors.flux = &t->flux;
    t->limiter.bonds = t->flux.bonds = t->bonds;
    t->flux.flow = t->flow;
    PD_TRY(pdi_inverse_plan(ctx, &md, &t->inverse));
    return pdi_krylov_init(ctx, &kd, &t->krylov);
}

PDI_FN size_t pdi_transport_room(pd_transport *t)
{
    size_t setup = pdi_inverse_room(&t->inverse), linear = pdi_arena_count_bytes(pdi_krylov_list, &t->krylov);
    size_t most = setup > linear ? setup : linear, steep = 0;
    pdi_steep values;
    memset(&values, 0, sizeof values);
    values.flux = &t->flux;
    if (pdi_transport_limits(t) && pdi_steep_may(&t->flux)) steep = pdi_arena_count_bytes(pdi_steep_list, &values);
    return pdi_arena_count_bytes(pdi_transport_work_list, t) + (steep > most ? steep : most);
}

static pd_status pdi_transport_make(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                                    const pd_transport_desc *desc, pd_transport *t)
{
    memset(t, 0, sizeof *t);
    if (!(desc->diffusivity >= 0.0) || !(desc->inlet >= 0.0) || !(desc->initial >= 0.0) || !(desc->tolerance >= 0.0) ||
        !(desc->diffusivity + desc->inlet + desc->initial < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "transport",
                       "D = %g m2/s, inlet %g mol/m3, initial %g mol/m3, tolerance %g: expected finite values of at "
                       "least 0", desc->diffusivity, desc->inlet, desc->initial, desc->tolerance);
    t->desc = *desc;
    t->seen[1] = -(t->ceiling = t->seen[0] = HUGE_VAL); /* nothing yet */
    if (desc->clock) *desc->clock = 0.0;
    pdi_transport_open(t);
    if (!(t->desc.tolerance > 0.0)) t->desc.tolerance = 1e-11;
    if (t->desc.max_limiter <= 0) t->desc.max_limiter = 30;
    if (!(t->desc.limiter_tolerance > 0.0)) t->desc.limiter_tolerance = PDI_TRANSPORT_STILL;
    t->grid = grid;
    t->bonds = bonds;
    t->flow = flow;
    if (desc->given && flow)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "transport", "a given field does not go with a flow");
    t->diffusion.desc.diffusivity = desc->diffusivity;
    PD_TRY(pdi_array_registry_build(ctx, pdi_transport_list, t));
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) t->c[i] = desc->initial;
    if (desc->given) return PD_OK;
    pd_krylov_desc kd;
    PD_TRY(pdi_transport_plan(ctx, t));
    pdi_transport_krylov(t, &kd);
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &t->krylov));
    pd_diffusion_desc dd;
    memset(&dd, 0, sizeof dd);
    dd.diffusivity = desc->diffusivity;
    dd.field = desc->field;
    dd.level = desc->level;
    dd.held = desc->held;
    dd.walls_only = desc->walls_only;
    dd.smooth = !pdi_transport_limits(t);
    dd.user = desc->user;
    PD_TRY(pdi_diffusion_build(ctx, bonds, &dd, &t->diffusion));
    PD_TRY(pdi_open_boundary_build(ctx, bonds, &t->boundary));
    t->limiter.boundary = &t->boundary;
    t->limiter.diffusion = &t->diffusion;
    t->factors.upwinded = t->upwinded;
    t->flux.diffusion = &t->diffusion;
    t->flux.limiter = &t->limiter;
    t->flux.boundary = &t->boundary;
    t->flux.absorb = t->absorb;
    t->flux.conductance.rests = pdi_transport_rests(t);
    PD_TRY(pdi_transport_inlets(ctx, t));
    PD_TRY(pdi_transport_holds(ctx, t));
    PD_TRY(pdi_flux_build(ctx, &t->flux));
    t->inverse.spread = desc->advection == PD_ADVECTION_LIMITED ? PDI_TRANSPORT_SPREAD : 1.0;
    return pdi_arena_reserve(ctx, pdi_transport_arena(t), pdi_transport_room(t));
}

PDI_FN pd_status pdi_transport_hold(pd_ctx *ctx, pd_transport *t)
{
    if (!t->held) {
        PD_TRY(pdi_arena_acquire(ctx, pdi_transport_arena(t), pdi_transport_work_list, t));
        if (t->repeated && !t->lean) t->inverse.mg.fields = (float *)(void *)t->repeated;
        if (!t->lean) pdi_multigrid_set_pointers(&t->inverse.mg);
    }
    t->held++;
    return PD_OK;
}

PDI_FN pd_status pdi_transport_release(pd_ctx *ctx, pd_transport *t, pd_status status)
{
    if (--t->held) return status;
    t->inverse.fresh = 0;
    if (!t->lean) pdi_multigrid_clear_pointers(&t->inverse.mg);
    if (t->repeated) t->inverse.mg.fields = NULL;
    status = pdi_arena_release(ctx, pdi_transport_arena(t), pdi_transport_work_list, t, status);
    t->lean = 0;
    return status;
}

pd_status pd_transport_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                             const pd_transport_desc *desc, pd_transport *t)
{
    pd_status status = pdi_transport_make(ctx, grid, bonds, flow, desc, t);
    if (status < 0) pd_transport_free(ctx, t);
    return status;
}

/* The tolerance of the next step depends on the fluxes of the last one. */
PDI_FN pd_status pdi_transport_store(pd_ctx *ctx, pd_transport *t, pd_archive *archive)
{
    PD_TRY(pdi_array_registry_store(ctx, pdi_transport_list, t, archive));
    return archive->is_reading ? pdi_transport_at(ctx, t, t->time) : PD_OK;
}

void pd_transport_free(pd_ctx *ctx, pd_transport *t)
{
    pdi_flux_free(ctx, &t->flux);
    pdi_open_boundary_free(ctx, &t->boundary);
    pdi_diffusion_free(ctx, &t->diffusion);
    pdi_inverse_free(ctx, &t->inverse);
    pd_krylov_free(ctx, &t->krylov);
    pdi_array_registry_free(ctx, pdi_transport_list, t);
    pd_arena_free(ctx, &t->own);
    memset(t, 0, sizeof *t);
}
PDI_COLD_END
