/* transport: see transport.h
 *
 * Design: bond fluxes are evaluated from the flow on the fly, in blocks of neighbours along axis 0 for nodes with whole
 * families, one by one for rows and for nodes that see an outlet ghost. Implicit steps solve for corrections, so inlet
 * values need no place in the Krylov vectors.
 */
#include "transport.h"
#include "par.h"
#include <math.h>
#include <string.h>

#define PDI_TRANSPORT_BLOCK 8
/* Linear tolerance while the antidiffusive fluxes still move, and their relaxation. */
#define PDI_TRANSPORT_LOOSE 1e-2
#define PDI_TRANSPORT_RELAX 0.7
/* Share of the largest value by which a field may leave its bounds: rounding of the linear solve. */
#define PDI_TRANSPORT_SLACK 1e-9
/* Linear tolerance that is enough to see bounds broken, over the final one. */
#define PDI_TRANSPORT_ROUGH 30.0
/* Rounds of upwinding the nodes that leave their bounds before the whole step is upwinded. */
#define PDI_TRANSPORT_ROUNDS 20

/* Volume flux F [1/s] from i to the far end of bond k, and the diffusion d [1/s] that upwinding adds to D a. */
static void pdi_transport_bond(const pd_transport *t, int32_t i, int k, double *flux, double *upwind)
{
    double bond = t->desc.diffusivity * t->bonds->stencil->lap[k];
    *flux = t->flow ? pdi_flow_bond_flux(t->flow, i, k) : 0.0;
    *upwind = fmax(0.5 * fabs(*flux) - bond, 0.0);
}

/* alpha of the bond: the antidiffusive flux d (c_i - c_j) raises the larger end and lowers the smaller one. */
static double pdi_transport_alpha(const pd_transport *t, const double *c, int32_t i, int32_t j)
{
    return c[i] > c[j] ? fmin(t->up[i], t->down[j]) : fmin(t->down[i], t->up[j]);
}

/* Amount per volume and time [mol/m3/s] that leaves i through bond k, upwinded (eq. 5.1). */
static double pdi_transport_bond_flux(const pd_transport *t, const double *c, int32_t i, int k)
{
    double flux, upwind;
    int32_t j = i + t->bonds->shift[k];
    pdi_transport_bond(t, i, k, &flux, &upwind);
    if (t->grid->kind[j] == PD_OUTLET) return flux * c[i];
    double spread = t->desc.diffusivity * t->bonds->stencil->lap[k] + upwind;
    return 0.5 * flux * (c[i] + c[j]) - spread * (c[j] - c[i]);
}

/* Bond k of node i is open: by its row, or since its family is whole. */
static int pdi_transport_open(const pd_transport *t, int32_t i, int k)
{
    int32_t r = t->bonds->row[i];
    return r < 0 || pdi_bond_open(t->bonds, r, k);
}

/* What a sweep does with its nodes: y = A c, the limiter ratios of c, or the limited fluxes y = sum alpha d (c_i -
 * c_j). */
typedef enum pdi_transport_task {
    PDI_TRANSPORT_APPLY,
    PDI_TRANSPORT_RATIOS,
    PDI_TRANSPORT_ANTI
} pdi_transport_task;

typedef struct pdi_transport_sweep {
    pdi_transport_task task;
    const pd_transport *t;
    const double *c;
    double *y;
    double *up, *down;
} pdi_transport_sweep;

static double pdi_transport_ratio(double room, double wanted) { return wanted > room ? room / wanted : 1.0; }

static void pdi_transport_node(const pdi_transport_sweep *s, int32_t i)
{
    const pd_transport *t = s->t;
    double sum = 0.0, plus = 0.0, minus = 0.0, least = s->c[i], most = s->c[i], weight = 0.0;
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        if (!pdi_transport_open(t, i, k)) continue;
        if (s->task == PDI_TRANSPORT_APPLY) {
            sum += pdi_transport_bond_flux(t, s->c, i, k);
            continue;
        }
        double flux, upwind;
        int32_t j = i + t->bonds->shift[k];
        uint8_t kind = t->grid->kind[j];
        /* what passes an inlet stays upwinded, so that antidiffusion sums to zero over the domain */
        if (kind == PD_OUTLET || (kind == PD_INLET && s->task == PDI_TRANSPORT_ANTI)) continue;
        pdi_transport_bond(t, i, k, &flux, &upwind);
        double anti = upwind * (s->c[i] - s->c[j]);
        if (s->task == PDI_TRANSPORT_ANTI) {
            sum += pdi_transport_alpha(t, s->c, i, j) * anti;
            continue;
        }
        plus += fmax(anti, 0.0);
        minus += fmax(-anti, 0.0);
        least = fmin(least, s->c[j]);
        most = fmax(most, s->c[j]);
        weight += upwind;
    }
    if (s->task == PDI_TRANSPORT_APPLY) sum += ((t->dt > 0.0 ? 1.0 / t->dt : 0.0) + t->absorb[i]) * s->c[i];
    if (s->task != PDI_TRANSPORT_RATIOS) {
        s->y[i] = sum;
        return;
    }
    s->up[i] = pdi_transport_ratio(weight * (most - s->c[i]), plus);
    s->down[i] = pdi_transport_ratio(weight * (s->c[i] - least), minus);
}

/* Fluxes of bond k for PDI_TRANSPORT_BLOCK consecutive nodes. */
static inline void pdi_transport_block_flux(const pd_transport *t, int32_t i, int k, double *flux, double *upwind)
{
    const pd_stencil *st = t->bonds->stencil;
    const pd_flow *f = t->flow;
    int32_t total = t->grid->total, j = i + t->bonds->shift[k];
    double bond = t->desc.diffusivity * st->lap[k], tie = f->tau * st->lap[k];
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) flux[b] = -tie * (f->p[j + b] - f->p[i + b]);
    for (int d = 0; d < PD_DIM; d++) {
        const double *u = f->u + (int64_t)d * total, *g = f->grad + (int64_t)d * total;
        double weight = st->grad[k * PD_DIM + d], half = 0.5 * tie * st->xi[k * PD_DIM + d];
        for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++)
            flux[b] += weight * (u[i + b] + u[j + b]) + half * (g[i + b] + g[j + b]);
    }
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) {
        double excess = 0.5 * fabs(flux[b]) - bond;
        upwind[b] = excess > 0.0 ? excess : 0.0;
    }
}

static void pdi_transport_block_apply(const pdi_transport_sweep *s, int32_t i)
{
    const pd_transport *t = s->t;
    const double *c = s->c;
    double sum[PDI_TRANSPORT_BLOCK], rate = t->dt > 0.0 ? 1.0 / t->dt : 0.0;
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) sum[b] = (rate + t->absorb[i + b]) * c[i + b];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux[PDI_TRANSPORT_BLOCK], upwind[PDI_TRANSPORT_BLOCK],
            bond = t->desc.diffusivity * t->bonds->stencil->lap[k];
        int32_t j = i + t->bonds->shift[k];
        pdi_transport_block_flux(t, i, k, flux, upwind);
        for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++)
            sum[b] += 0.5 * flux[b] * (c[i + b] + c[j + b]) - (bond + upwind[b]) * (c[j + b] - c[i + b]);
    }
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) s->y[i + b] = sum[b];
}

static void pdi_transport_block_anti(const pdi_transport_sweep *s, int32_t i)
{
    const pd_transport *t = s->t;
    const double *c = s->c;
    double sum[PDI_TRANSPORT_BLOCK];
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) sum[b] = 0.0;
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux[PDI_TRANSPORT_BLOCK], upwind[PDI_TRANSPORT_BLOCK];
        int32_t j = i + t->bonds->shift[k];
        pdi_transport_block_flux(t, i, k, flux, upwind);
        for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) {
            int falls = c[i + b] > c[j + b];
            double one = falls ? t->up[i + b] : t->down[i + b], two = falls ? t->down[j + b] : t->up[j + b];
            sum[b] += (one < two ? one : two) * upwind[b] * (c[i + b] - c[j + b]);
        }
    }
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) s->y[i + b] = sum[b];
}

static void pdi_transport_block_ratios(const pdi_transport_sweep *s, int32_t i)
{
    const pd_transport *t = s->t;
    const double *c = s->c;
    double plus[PDI_TRANSPORT_BLOCK], minus[PDI_TRANSPORT_BLOCK], least[PDI_TRANSPORT_BLOCK], most[PDI_TRANSPORT_BLOCK],
        weight[PDI_TRANSPORT_BLOCK];
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) {
        plus[b] = minus[b] = weight[b] = 0.0;
        least[b] = most[b] = c[i + b];
    }
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux[PDI_TRANSPORT_BLOCK], upwind[PDI_TRANSPORT_BLOCK];
        int32_t j = i + t->bonds->shift[k];
        pdi_transport_block_flux(t, i, k, flux, upwind);
        for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) {
            double far = c[j + b], anti = upwind[b] * (c[i + b] - far);
            plus[b] += anti > 0.0 ? anti : 0.0;
            minus[b] += anti < 0.0 ? -anti : 0.0;
            least[b] = far < least[b] ? far : least[b];
            most[b] = far > most[b] ? far : most[b];
            weight[b] += upwind[b];
        }
    }
    for (int b = 0; b < PDI_TRANSPORT_BLOCK; b++) {
        s->up[i + b] = pdi_transport_ratio(weight[b] * (most[b] - c[i + b]), plus[b]);
        s->down[i + b] = pdi_transport_ratio(weight[b] * (c[i + b] - least[b]), minus[b]);
    }
}

/* Part [lo, hi) of a run whose nodes see no outlet ghost. */
static void pdi_transport_inner(const pd_transport *t, int32_t first, int32_t length, int32_t *lo, int32_t *hi)
{
    const pd_grid *grid = t->grid;
    int i[PD_DIM], reach = t->bonds->stencil->reach;
    pdi_grid_index(grid, first, i);
    *lo = 0;
    *hi = length;
    for (int d = 0; d < PD_DIM; d++)
        for (int up = 0; up < 2; up++) {
            if (grid->side[2 * d + up] != PD_SIDE_OUTLET) continue;
            if (d > 0 && (up ? i[d] >= grid->n[d] - reach : i[d] < reach)) *hi = 0;
            if (d == 0 && up && *hi > grid->n[0] - reach - i[0]) *hi = grid->n[0] - reach - i[0];
            if (d == 0 && !up && *lo < reach - i[0]) *lo = reach - i[0];
        }
    if (*lo > length) *lo = length;
    if (*hi < *lo) *hi = *lo;
}

static void pdi_transport_run(const pdi_transport_sweep *s, int32_t first, int32_t length)
{
    int32_t lo, hi, at;
    pdi_transport_inner(s->t, first, length, &lo, &hi);
    if (!s->t->flow) hi = lo;
    for (at = 0; at < lo; at++) pdi_transport_node(s, first + at);
    for (; at + PDI_TRANSPORT_BLOCK <= hi; at += PDI_TRANSPORT_BLOCK) {
        if (s->task == PDI_TRANSPORT_APPLY) pdi_transport_block_apply(s, first + at);
        else if (s->task == PDI_TRANSPORT_ANTI) pdi_transport_block_anti(s, first + at);
        else pdi_transport_block_ratios(s, first + at);
    }
    for (; at < length; at++) pdi_transport_node(s, first + at);
}

static void pdi_transport_sweep_all(const pd_ctx *ctx, const pdi_transport_sweep *s)
{
    const pd_bonds *bonds = s->t->bonds;
    int nt = pdi_par_threads(ctx, s->t->grid->fluid_count * bonds->stencil->count * 8);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t run = 0; run < bonds->runs; run++) pdi_transport_run(s, bonds->run_first[run], bonds->run_length[run]);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) pdi_transport_node(s, bonds->node[r]);
}

static void pdi_transport_operator(const pd_ctx *ctx, const pd_transport *t, const double *c, double *y)
{
    pdi_transport_sweep s;
    memset(&s, 0, sizeof s);
    s.t = t;
    s.c = c;
    s.y = y;
    s.task = PDI_TRANSPORT_APPLY;
    pdi_transport_sweep_all(ctx, &s);
}

/* Limited antidiffusive fluxes of the present field (eq. 5.4), relaxed into t->anti. Prescribed values of inlets limit
 * nothing. */
static void pdi_transport_limit_fluxes(const pd_ctx *ctx, pd_transport *t, double relax)
{
    pdi_transport_sweep s;
    const uint8_t *kind = t->grid->kind;
    memset(&s, 0, sizeof s);
    s.t = t;
    s.c = t->c;
    s.y = t->work;
    s.up = t->up;
    s.down = t->down;
    s.task = PDI_TRANSPORT_RATIOS;
    pdi_transport_sweep_all(ctx, &s);
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->upwinded[i]) t->up[i] = t->down[i] = 0.0;
    s.task = PDI_TRANSPORT_ANTI;
    pdi_transport_sweep_all(ctx, &s);
    for (int32_t i = 0; i < t->grid->total; i++)
        if (kind[i] == PD_FLUID) t->anti[i] += relax * (t->work[i] - t->anti[i]);
}

/* What the solver callbacks see. */
typedef struct pdi_transport_user {
    pd_ctx *ctx;
    pd_transport *t;
} pdi_transport_user;

static void pdi_transport_apply(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pdi_transport_operator(u->ctx, u->t, x, y);
}

static void pdi_transport_precondition(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pd_multigrid_cycle(u->ctx, &u->t->mg, x, y);
}

/* Upwinding bond by bond spreads along b by 1/2 sum |g_a| xi_b^2 per speed along a. */
static void pdi_transport_spread(const pd_stencil *s, double *spread)
{
    for (int i = 0; i < PD_DIM * PD_DIM; i++) spread[i] = 0.0;
    for (int k = 0; k < s->count; k++)
        for (int a = 0; a < PD_DIM; a++)
            for (int b = 0; b < PD_DIM; b++)
                spread[a * PD_DIM + b] +=
                    0.5 * fabs(s->grad[k * PD_DIM + a]) * s->xi[k * PD_DIM + b] * s->xi[k * PD_DIM + b];
}

static pd_status pdi_transport_setup(pd_ctx *ctx, pd_transport *t)
{
    pdi_compact_faces faces;
    pdi_compact_convection convection;
    double spread[PD_DIM * PD_DIM];
    pd_compact *c = &t->compact;
    const pd_grid *grid = t->grid;
    faces.closed = faces.outlet = 0;
    faces.inlet = 1;
    pdi_transport_spread(t->bonds->stencil, spread);
    convection.u = t->flow ? t->flow->u : NULL;
    convection.spread = spread;
    pdi_compact_fill(ctx, t->desc.diffusivity, &convection, 1.0 / t->dt, &faces, c);
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID || !(t->absorb[node] > 0.0)) continue;
        pdi_grid_index(grid, node, i);
        c->mass[pdi_compact_cell(grid, i)] += (float)t->absorb[node];
    }
    return pd_multigrid_setup(ctx, &t->mg, c->active, (const float *const *)c->conduct,
                              t->flow ? (const float *const *)c->flux : NULL, c->wall, c->mass);
}

/* rhs = old/dt + source + carry/dt + anti at fluid nodes. */
static void pdi_transport_right_side(const pd_ctx *ctx, pd_transport *t)
{
    const uint8_t *kind = t->grid->kind;
    int nt = pdi_par_threads(ctx, t->grid->total * 4);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < t->grid->total; i++)
        t->rhs[i] = kind[i] == PD_FLUID ? (t->old[i] + t->carry[i]) / t->dt + t->source[i] + t->anti[i] : 0.0;
}

/* residual = rhs - A c at fluid nodes, into out. */
static void pdi_transport_residual(const pd_ctx *ctx, const pd_transport *t, double *out)
{
    const uint8_t *kind = t->grid->kind;
    int nt = pdi_par_threads(ctx, t->grid->total * 4);
    (void)nt;
    pdi_transport_operator(ctx, t, t->c, out);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < t->grid->total; i++) out[i] = kind[i] == PD_FLUID ? t->rhs[i] - out[i] : 0.0;
}

/* Solve A delta = rhs - A c to an absolute tolerance and add delta to c. */
static pd_status pdi_transport_correct(pd_ctx *ctx, pd_transport *t, double rtol, double atol, double *change,
                                       pd_transport_result *result)
{
    pdi_transport_user user;
    pd_krylov_result linear;
    double *residual = t->work, *delta = t->work + t->grid->total;
    const uint8_t *kind = t->grid->kind;
    user.ctx = ctx;
    user.t = t;
    pdi_transport_residual(ctx, t, residual);
    t->krylov.desc.rtol = rtol;
    t->krylov.desc.atol = atol;
    pd_status status = pd_krylov_solve(ctx, &t->krylov, pdi_transport_apply, pdi_transport_precondition, &user,
                                       residual, delta, &linear);
    if (status < 0) return status;
    result->krylov += linear.iterations;
    result->residual = linear.residual;
    double moved = pdi_par_max_abs(ctx, t->grid->total, delta), size = 0.0;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (kind[i] != PD_FLUID) continue;
        t->c[i] += delta[i];
        size = fmax(size, fabs(t->c[i]));
    }
    *change = size > 0.0 ? moved / size : 0.0;
    return status;
}

/* Flow through inlet and outlet bonds at the present field. */
static void pdi_transport_boundary(pd_transport *t)
{
    pdi_sum out = {0.0, 0.0}, in = {0.0, 0.0};
    const pd_grid *grid = t->grid;
    int reach = t->bonds->stencil->reach;
    for (int32_t i = 0; i < grid->total; i++) {
        int at[PD_DIM], near_open = 0;
        if (grid->kind[i] != PD_FLUID) continue;
        pdi_grid_index(grid, i, at);
        for (int d = 0; d < PD_DIM; d++) {
            near_open = near_open || (grid->side[2 * d] != PD_SIDE_WALL && at[d] < reach);
            near_open = near_open || (grid->side[2 * d + 1] != PD_SIDE_WALL && at[d] >= grid->n[d] - reach);
        }
        if (!near_open) continue;
        for (int k = 0; k < t->bonds->stencil->count; k++) {
            if (!pdi_transport_open(t, i, k)) continue;
            uint8_t far_kind = grid->kind[i + t->bonds->shift[k]];
            if (far_kind == PD_OUTLET) pdi_sum_add(&out, pdi_transport_bond_flux(t, t->c, i, k));
            if (far_kind == PD_INLET) pdi_sum_add(&in, -pdi_transport_bond_flux(t, t->c, i, k));
        }
    }
    t->outflow = pdi_sum_total(&out) * t->bonds->stencil->volume;
    t->inflow = pdi_sum_total(&in) * t->bonds->stencil->volume;
}

/* Bounds that the step must keep: those of the old field and the inflow; a source lifts the upper one. */
static void pdi_transport_bounds(const pd_transport *t, double *low, double *high)
{
    *low = HUGE_VAL;
    *high = 0.0;
    for (int32_t i = 0; i < t->grid->total; i++) {
        uint8_t kind = t->grid->kind[i];
        if (kind != PD_FLUID && kind != PD_INLET) continue;
        *low = fmin(*low, t->old[i]);
        *high = fmax(*high, t->old[i]);
        if (kind == PD_FLUID && t->source[i] < 0.0) *low = -HUGE_VAL;
        if (kind == PD_FLUID && t->absorb[i] > 0.0) *low = fmin(*low, 0.0);
        if (kind == PD_FLUID && t->source[i] > 0.0) *high = HUGE_VAL;
    }
}

/* Mark the nodes outside of the bounds; how many are new. */
static int64_t pdi_transport_mark(pd_transport *t, double low, double high)
{
    double size = 0.0;
    int64_t found = 0;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) size = fmax(size, fabs(t->c[i]));
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID || t->upwinded[i]) continue;
        if (t->c[i] >= low - PDI_TRANSPORT_SLACK * size && t->c[i] <= high + PDI_TRANSPORT_SLACK * size) continue;
        t->upwinded[i] = 1;
        found++;
    }
    return found;
}

/* The limiter bounds a converged field; where the iteration has left the field outside of its bounds, the nodes
 * concerned lose their antidiffusive fluxes until none is left. Fluxes are limited, values never. */
static pd_status pdi_transport_enforce(pd_ctx *ctx, pd_transport *t, double atol, pd_transport_result *result)
{
    double low, high, change;
    pd_status status = PD_OK;
    pdi_transport_bounds(t, &low, &high);
    for (int round = 1; round <= PDI_TRANSPORT_ROUNDS && pdi_transport_mark(t, low, high) > 0; round++) {
        if (round == PDI_TRANSPORT_ROUNDS) pdi_par_zero(ctx, t->grid->total, t->anti);
        else pdi_transport_limit_fluxes(ctx, t, 1.0);
        pdi_transport_right_side(ctx, t);
        status = pdi_transport_correct(ctx, t, 1e-15, PDI_TRANSPORT_ROUGH * atol, &change, result);
        if (status < 0) return status;
        result->bounded = round;
    }
    return pdi_transport_correct(ctx, t, 1e-15, atol, &change, result);
}

static pd_status pdi_transport_iterate(pd_ctx *ctx, pd_transport *t, double atol, pd_transport_result *result)
{
    pd_status status = PD_OK;
    int limiter = t->flow && t->desc.advection == PD_ADVECTION_LIMITED;
    for (int pass = 0;; pass++) {
        int last = !limiter || pass == t->desc.max_limiter || (pass > 0 && result->change < t->desc.limiter_tolerance);
        if (limiter && pass > 0) {
            pdi_transport_limit_fluxes(ctx, t, PDI_TRANSPORT_RELAX);
            pdi_transport_right_side(ctx, t);
        }
        double floor_residual = limiter ? PDI_TRANSPORT_ROUGH * atol : atol;
        status =
            pdi_transport_correct(ctx, t, last ? 1e-15 : PDI_TRANSPORT_LOOSE, floor_residual, &result->change, result);
        result->limiter = pass;
        if (status < 0) return status;
        if (last) break;
    }
    return limiter ? pdi_transport_enforce(ctx, t, atol, result) : status;
}

pd_status pd_transport_implicit(pd_ctx *ctx, pd_transport *t, double dt, pd_transport_result *result)
{
    int32_t total = t->grid->total;
    memset(result, 0, sizeof *result);
    if (!(dt > 0.0) || !(dt < 1e300))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    t->dt = dt;
    pdi_par_copy(ctx, total, t->c, t->old);
    memset(t->upwinded, 0, (size_t)total);
    pdi_transport_right_side(ctx, t);
    PDI_TRY(pdi_transport_setup(ctx, t));
    /* the size of the equations: right-hand side and inflow */
    pdi_transport_residual(ctx, t, t->work);
    double size = fmax(sqrt(pdi_par_dot(ctx, total, t->rhs, t->rhs)), sqrt(pdi_par_dot(ctx, total, t->work, t->work)));
    pd_status status = size > 0.0 ? pdi_transport_iterate(ctx, t, t->desc.tolerance * size, result) : PD_OK;
    if (status < 0) {
        pdi_par_copy(ctx, total, t->old, t->c);
        return status;
    }
    result->residual = size > 0.0 ? result->residual / size : 0.0;
    pdi_transport_residual(ctx, t, t->carry);
    for (int32_t i = 0; i < total; i++) t->carry[i] *= dt;
    pdi_transport_boundary(t);
    return result->residual <= 10.0 * t->desc.tolerance ? PD_OK : status;
}

double pd_transport_limit(pd_ctx *ctx, const pd_transport *t)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID) continue;
        double rate = t->absorb[i];
        for (int k = 0; k < t->bonds->stencil->count; k++) {
            if (!pdi_transport_open(t, i, k)) continue;
            double flux, upwind;
            pdi_transport_bond(t, i, k, &flux, &upwind);
            if (t->grid->kind[i + t->bonds->shift[k]] == PD_OUTLET) rate += fmax(flux, 0.0);
            else rate += t->desc.diffusivity * t->bonds->stencil->lap[k] + 2.0 * upwind - 0.5 * flux;
        }
        fastest = fmax(fastest, rate);
    }
    return fastest > 0.0 ? 1.0 / fastest : HUGE_VAL;
}

pd_status pd_transport_explicit(pd_ctx *ctx, pd_transport *t, double dt)
{
    const uint8_t *kind = t->grid->kind;
    if (!(dt > 0.0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    double limit = pd_transport_limit(ctx, t);
    if (dt > limit * (1.0 + 1e-12)) {
        pdi_fail(ctx, PD_RETRY, "transport", "the explicit step of %g s exceeds the limit of %g s", dt, limit);
        return PD_RETRY;
    }
    t->dt = 0.0;
    if (t->flow && t->desc.advection == PD_ADVECTION_LIMITED) pdi_transport_limit_fluxes(ctx, t, 1.0);
    pdi_transport_operator(ctx, t, t->c, t->rhs);
    pdi_transport_boundary(t);
    for (int32_t i = 0; i < t->grid->total; i++)
        if (kind[i] == PD_FLUID) {
            t->c[i] += dt * (t->source[i] + t->anti[i] - t->rhs[i]) + t->carry[i];
            t->carry[i] = 0.0;
        }
    return PD_OK;
}

static double pdi_transport_total(const pd_transport *t, const double *field)
{
    pdi_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) pdi_sum_add(&sum, field[i]);
    return pdi_sum_total(&sum) * t->bonds->stencil->volume;
}

double pd_transport_stock(pd_ctx *ctx, const pd_transport *t)
{
    (void)ctx;
    return pdi_transport_total(t, t->c);
}

double pd_transport_carried(pd_ctx *ctx, const pd_transport *t)
{
    (void)ctx;
    return pdi_transport_total(t, t->carry);
}

void pd_transport_update(pd_transport *t)
{
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_INLET) {
            t->c[i] = t->desc.inlet;
            t->up[i] = t->down[i] = 1.0;
        }
}

pd_status pd_transport_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                             const pd_transport_desc *desc, pd_transport *t)
{
    memset(t, 0, sizeof *t);
    if (!(desc->diffusivity >= 0.0) || !(desc->inlet >= 0.0) || !(desc->initial >= 0.0) || !(desc->tolerance >= 0.0) ||
        !(desc->diffusivity + desc->inlet + desc->initial < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport",
                        "D = %g m2/s, inlet %g mol/m3, initial %g mol/m3, tolerance %g: expected finite values of at "
                        "least 0", desc->diffusivity, desc->inlet, desc->initial, desc->tolerance);
    t->desc = *desc;
    if (!(t->desc.tolerance > 0.0)) t->desc.tolerance = 1e-11;
    if (t->desc.max_limiter <= 0) t->desc.max_limiter = 10;
    if (!(t->desc.limiter_tolerance > 0.0)) t->desc.limiter_tolerance = 1e-3;
    t->grid = grid;
    t->bonds = bonds;
    t->flow = flow;
    pd_krylov_desc kd;
    pd_multigrid_desc md;
    int origin[PD_DIM];
    memset(&kd, 0, sizeof kd);
    memset(&md, 0, sizeof md);
    kd.n = grid->total;
    kd.restart = 20;
    kd.flexible = 1;
    kd.zero_guess = 1;
    for (int d = 0; d < PD_DIM; d++) {
        origin[d] = 0;
        md.n[d] = grid->n[d];
        md.stride[d] = grid->stride[d];
    }
    md.first = pd_grid_node(grid, origin);
    md.symmetric = flow == NULL;
    PDI_TRY(pdi_compact_build(ctx, grid, flow != NULL, &t->compact));
    PDI_TRY(pd_multigrid_build(ctx, &md, &t->mg));
    PDI_TRY(pd_krylov_build(ctx, &kd, &t->krylov));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->c));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->old));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->source));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->absorb));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->carry));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->up));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->down));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->anti));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->upwinded));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->rhs));
    PDI_TRY(PDI_NEW(ctx, "transport", 2 * (int64_t)grid->total, t->work));
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) t->c[i] = desc->initial;
    pd_transport_update(t);
    return PD_OK;
}

void pd_transport_free(pd_ctx *ctx, pd_transport *t)
{
    int64_t total = t->grid ? t->grid->total : 0;
    pdi_compact_free(ctx, &t->compact);
    pd_multigrid_free(ctx, &t->mg);
    pd_krylov_free(ctx, &t->krylov);
    PDI_DELETE(ctx, total, t->c);
    PDI_DELETE(ctx, total, t->old);
    PDI_DELETE(ctx, total, t->source);
    PDI_DELETE(ctx, total, t->absorb);
    PDI_DELETE(ctx, total, t->carry);
    PDI_DELETE(ctx, total, t->up);
    PDI_DELETE(ctx, total, t->down);
    PDI_DELETE(ctx, total, t->anti);
    PDI_DELETE(ctx, total, t->upwinded);
    PDI_DELETE(ctx, total, t->rhs);
    PDI_DELETE(ctx, 2 * total, t->work);
    memset(t, 0, sizeof *t);
}
