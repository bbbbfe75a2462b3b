/* transport: see transport.h
 *
 * Design: bond fluxes are evaluated from the flow on the fly, bond by bond for up to PDI_LANES neighbours along axis 0.
 * A gate shuts the bonds that take no part. Implicit steps solve for corrections, so inlet values need no place in the
 * Krylov vectors.
 */
#include "transport.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Share of xi.G in the antidiffusive fluxes: damps what alternates from node to node, which a central flux does not
 * see. */
#define PDI_TRANSPORT_LEAN 0.3
/* Steps along bonds far below this share of the field are upwinded. */
#define PDI_TRANSPORT_FAINT 1e-4
/* Displacement of a difference quotient over the field, and tolerances of the linear solves of Newton's method. */
#define PDI_TRANSPORT_PROBE 1e-7
#define PDI_TRANSPORT_LOOSE 0.1
#define PDI_TRANSPORT_TIGHT 1e-3
/* Iterations of one of these, and the shortest step along its direction. */
#define PDI_TRANSPORT_KRYLOV 60
#define PDI_TRANSPORT_SHORTEST 0.03
/* A step that leaves more than this share of the residual ends the iteration. */
#define PDI_TRANSPORT_STALLED 0.999
/* Share of the largest value by which a field may leave its bounds: rounding of the linear solve. */
#define PDI_TRANSPORT_SLACK 3e-10
/* Tolerance that is enough to limit, and to see bounds broken, over the final one. */
#define PDI_TRANSPORT_ROUGH 30.0
/* Rounds of upwinding the nodes that leave their bounds before the whole step is upwinded. */
#define PDI_TRANSPORT_ROUNDS 20
/* The steady field: length of a step over the exchange time of the slowest node, and how many. */
#define PDI_TRANSPORT_LONG 1e9
#define PDI_TRANSPORT_STEPS 60
/* Relative change of the field by the last of them. */
#define PDI_TRANSPORT_SETTLED 1e-6

/* Of bond k of node i: volume flux F [1/s] to the far end, conductance [1/s], and what upwinding adds to it [1/s]. */
static void pdi_transport_bond(const pd_transport *t, int32_t i, int k, double *flux, double *bond, double *upwind)
{
    pdi_diffusion_bond(&t->diffusion, i, k, 1, t->bonds->row[i] >= 0, bond);
    *flux = t->flow ? pdi_flow_bond_flux(t->flow, i, k) : 0.0;
    *upwind = fmax(0.5 * fabs(*flux) - *bond, 0.0);
}

/* Amount per volume and time [mol/m3/s] that leaves i through bond k, upwinded (eq. 5.1). */
static double pdi_transport_bond_flux(const pd_transport *t, const double *c, int32_t i, int k)
{
    double flux, bond, upwind;
    int32_t j = i + t->bonds->shift[k];
    pdi_transport_bond(t, i, k, &flux, &bond, &upwind);
    if (t->grid->kind[j] == PD_OUTLET) return flux * c[i];
    return 0.5 * flux * (c[i] + c[j]) - (bond + upwind) * (c[j] - c[i]);
}

/* Bond k of node i is open: by its row, or since its family is whole. */
static int pdi_transport_open(const pd_transport *t, int32_t i, int k)
{
    int32_t r = t->bonds->row[i];
    return r < 0 || pdi_bond_open(t->bonds, r, k);
}

/* What a sweep does with its nodes: y = A c, or the limited antidiffusive fluxes y. */
typedef enum pdi_transport_task {
    PDI_TRANSPORT_APPLY,
    PDI_TRANSPORT_ANTI
} pdi_transport_task;

typedef struct pdi_transport_sweep {
    pdi_transport_task task;
    const pd_transport *t;
    const double *c;
    double *y;
} pdi_transport_sweep;

/* One bond of the nodes i .. i+count-1: what the tasks need of it. */
typedef struct pdi_transport_lanes {
    int count;
    int gated;          /* 0: all gates are open */
    const double *far;  /* c at the far ends [mol/m3] */
    double gate[PDI_LANES];   /* 1.0: takes part, 0.0: does not */
    double bond[PDI_LANES];   /* conductance [1/s] */
    double flux[PDI_LANES];   /* F [1/s] */
    double upwind[PDI_LANES]; /* diffusion that upwinding adds to `bond` [1/s] */
    double edge[PDI_LANES];   /* holds far values beside outlets */
} pdi_transport_lanes;

/* Volume fluxes of bond k (as pdi_flow_bond_flux). tied: 0 where the bond carries no pressure; NULL: everywhere 1. */
static void pdi_transport_flux(const pd_transport *t, int32_t i, int k, const double *tied, pdi_transport_lanes *l)
{
    const pd_stencil *st = t->bonds->stencil;
    const pd_flow *f = t->flow;
    int64_t total = t->grid->total, shift = t->bonds->shift[k];
    const double *p = f->p + i, *u = f->carrier + i, *grad = f->grad + i, *g = st->grad + k * PD_DIM;
    double tie = f->tau * pdi_bond_lap(t->bonds, i)[k], share = pdi_bond_flux(t->bonds, i, k), arm[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) arm[d] = 0.5 * st->xi[k * PD_DIM + d];
    for (int b = 0; b < l->count; b++) {
        double pressure = p[b + shift] - p[b], flux = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            flux += share * g[d] * (u[d * total + b] + u[d * total + b + shift]);
            pressure -= arm[d] * (grad[d * total + b] + grad[d * total + b + shift]);
        }
        flux -= (tied ? tied[b] : 1.0) * tie * pressure;
        double excess = 0.5 * fabs(flux) - l->bond[b];
        l->flux[b] = flux;
        l->upwind[b] = excess > 0.0 ? excess : 0.0;
    }
}

/* Beside inlets and outlets: an outlet takes c of the node, and only moves with the flow. */
static void pdi_transport_ends(const pdi_transport_sweep *s, int32_t i, int k, double *tied, pdi_transport_lanes *l)
{
    int32_t shift = s->t->bonds->shift[k];
    for (int b = 0; b < l->count; b++) {
        uint8_t kind = s->t->grid->kind[i + b + shift];
        tied[b] = kind == PD_INLET ? 0.0 : 1.0;
        l->edge[b] = kind == PD_OUTLET ? s->c[i + b] : l->far[b];
        if (!l->gated) l->gate[b] = 1.0;
        if (kind == PD_OUTLET && s->task == PDI_TRANSPORT_ANTI) l->gate[b] = 0.0;
    }
    l->far = l->edge;
    l->gated = 1;
}

/* Bond k of the nodes i .. i+count-1, which are the rows from `row` (-1: whole families); 0 when it is shut for all. */
static int pdi_transport_bond_lanes(const pdi_transport_sweep *s, int32_t i, int32_t row, int k, int ends,
                                    pdi_transport_lanes *l)
{
    const pd_transport *t = s->t;
    double tied[PDI_LANES];
    pdi_lanes open = row < 0 ? PDI_LANES_ALL : pdi_bond_open_lanes(t->bonds, row, k, l->count, l->gate);
    if (open == PDI_LANES_NONE) return 0;
    l->gated = open == PDI_LANES_SOME;
    pdi_diffusion_bond(&t->diffusion, i, k, l->count, row >= 0, l->bond);
    l->far = s->c + i + t->bonds->shift[k];
    if (ends) pdi_transport_ends(s, i, k, tied, l);
    if (t->flow) pdi_transport_flux(t, i, k, ends ? tied : NULL, l);
    return 1;
}

static void pdi_transport_apply_lanes(const pdi_transport_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    const pd_transport *t = s->t;
    const double *c = s->c + i;
    double sum[PDI_LANES], rate = t->dt > 0.0 ? 1.0 / t->dt : 0.0;
    pdi_transport_lanes l;
    memset(&l, 0, sizeof l);
    l.count = count;
    for (int b = 0; b < count; b++) sum[b] = (rate + t->absorb[i + b]) * c[b];
    for (int b = 0; b < count && t->diffusion.hold; b++) sum[b] += t->diffusion.hold[i + b] * c[b];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        if (!pdi_transport_bond_lanes(s, i, row, k, ends, &l)) continue;
        for (int b = 0; b < count; b++) {
            double flux = 0.5 * l.flux[b] * (c[b] + l.far[b]) - (l.bond[b] + l.upwind[b]) * (l.far[b] - c[b]);
            sum[b] += l.gated ? l.gate[b] * flux : flux;
        }
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

/* Of bond k: the step D of the field along it, leant towards xi.G of the upwind end, within 0 and 2 D (eq. 5.4). An
 * inlet has no gradient. */
static void pdi_transport_lean(const pdi_transport_sweep *s, int32_t i, int k, int ends, const pdi_transport_lanes *l,
                               double *lean)
{
    const pd_transport *t = s->t;
    int64_t total = t->grid->total;
    int32_t shift = t->bonds->shift[k];
    const double *c = s->c + i, *slope = t->limiter.slope + i, *xi = t->bonds->stencil->xi + k * PD_DIM;
    for (int b = 0; b < l->count; b++) {
        double step = l->far[b] - c[b], near_x = 0.0, far_x = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            near_x += xi[d] * slope[d * total + b];
            far_x += xi[d] * slope[d * total + b + shift];
        }
        double x = l->flux[b] > 0.0 ? near_x : far_x;
        double mixed = (1.0 - PDI_TRANSPORT_LEAN) * step + PDI_TRANSPORT_LEAN * x, twice = 2.0 * step;
        double low = twice < 0.0 ? twice : 0.0, high = twice > 0.0 ? twice : 0.0;
        mixed = mixed > low ? mixed : low;
        lean[b] = mixed < high ? mixed : high;
    }
    for (int b = 0; b < l->count && ends; b++)
        if (l->flux[b] <= 0.0 && t->grid->kind[i + b + shift] == PD_INLET) lean[b] = l->far[b] - c[b];
}

/* y_i = - sum alpha d s with s of pdi_transport_lean and alpha of the upwind end of the bond (eq. 5.4). */
static void pdi_transport_anti_lanes(const pdi_transport_sweep *s, int32_t i, int32_t row, int count, int ends)
{
    const pd_transport *t = s->t;
    const double *keep = t->limiter.keep + i;
    double sum[PDI_LANES], lean[PDI_LANES];
    pdi_transport_lanes l;
    memset(sum, 0, sizeof sum);
    memset(&l, 0, sizeof l);
    l.count = count;
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        int32_t shift = t->bonds->shift[k];
        if (!pdi_transport_bond_lanes(s, i, row, k, ends, &l)) continue;
        pdi_transport_lean(s, i, k, ends, &l, lean);
        for (int b = 0; b < count; b++) {
            double flux = (l.flux[b] > 0.0 ? keep[b] : keep[b + shift]) * l.upwind[b] * lean[b];
            sum[b] -= l.gated ? l.gate[b] * flux : flux;
        }
    }
    memcpy(s->y + i, sum, (size_t)count * sizeof(double));
}

/* `length` consecutive nodes from i, which are the rows from `row` (-1: whole families). */
static void pdi_transport_run(const pdi_transport_sweep *s, int32_t i, int32_t row, int32_t length)
{
    int count;
    for (int32_t at = 0; at < length; at += count) {
        count = pdi_bond_piece(length, &at);
        int32_t r = row < 0 ? row : row + at;
        int ends = pdi_limiter_ports(s->t->bonds, i + at, count);
        if (s->task == PDI_TRANSPORT_APPLY) pdi_transport_apply_lanes(s, i + at, r, count, ends);
        else pdi_transport_anti_lanes(s, i + at, r, count, ends);
    }
}

static void pdi_transport_sweep_all(const pd_ctx *ctx, const pdi_transport_sweep *s)
{
    const pd_bonds *bonds = s->t->bonds;
    int nt = pdi_par_threads(ctx, s->t->grid->fluid_count * bonds->stencil->count * 8);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t run = 0; run < bonds->runs; run++)
        pdi_transport_run(s, bonds->run_first[run], -1, bonds->run_length[run]);
    PDI_PARALLEL_FOR(nt)
    for (int32_t b = 0; b < bonds->batches; b++)
        pdi_transport_run(s, bonds->node[bonds->batch_first[b]], bonds->batch_first[b], bonds->batch_length[b]);
    for (int32_t r = bonds->plain; r < bonds->rows; r++) pdi_transport_run(s, bonds->node[r], r, 1);
}

static void pdi_transport_operator(const pd_ctx *ctx, const pd_transport *t, const double *c, double *y)
{
    pdi_transport_sweep s;
    memset(&s, 0, sizeof s);
    if (t->repeated) {
        pdi_par_copy(ctx, t->grid->total, c, t->repeated);
        pd_ghosts_scalar(&t->bonds->ghosts, t->repeated);
        c = t->repeated;
    }
    s.t = t;
    s.c = c;
    s.y = y;
    s.task = PDI_TRANSPORT_APPLY;
    pdi_transport_sweep_all(ctx, &s);
}

/* out [total]: limited antidiffusive fluxes of the field c (eq. 5.4), whose images are filled here. */
static void pdi_transport_anti(const pd_ctx *ctx, pd_transport *t, double *c, double *out)
{
    pdi_transport_sweep s;
    pd_ghosts_scalar(&t->bonds->ghosts, c);
    pdi_limiter_update(ctx, &t->limiter, c, PDI_TRANSPORT_FAINT * t->size);
    if (t->upwinding) {
        for (int32_t i = 0; i < t->grid->total; i++)
            if (t->upwinded[i]) t->limiter.keep[i] = 0.0;
        pd_ghosts_scalar(&t->bonds->ghosts, t->limiter.keep);
    }
    memset(&s, 0, sizeof s);
    s.t = t;
    s.c = c;
    s.y = out;
    s.task = PDI_TRANSPORT_ANTI;
    pdi_transport_sweep_all(ctx, &s);
}

/* What the solver callbacks see. */
typedef struct pdi_transport_user {
    pd_ctx *ctx;
    pd_transport *t;
    int limited; /* 1: there are antidiffusive fluxes */
} pdi_transport_user;

static void pdi_transport_apply(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pdi_transport_operator(u->ctx, u->t, x, y);
}

/* y = A x less the derivative of the limited fluxes along x, by a difference quotient. */
static void pdi_transport_jacobian(void *user, const double *x, double *y)
{
    pdi_transport_user *u = (pdi_transport_user *)user;
    pd_transport *t = u->t;
    int32_t total = t->grid->total;
    const uint8_t *kind = t->grid->kind;
    double size = pdi_par_max_abs(u->ctx, total, x), *probe = t->probe, *moved = t->probe + total;
    int nt = pdi_par_threads(u->ctx, (int64_t)total * 4);
    (void)nt;
    pdi_transport_operator(u->ctx, t, x, y);
    if (!u->limited || !(size > 0.0)) return;
    double step = PDI_TRANSPORT_PROBE * t->size / size;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++) probe[i] = kind[i] == PD_FLUID ? t->c[i] + step * x[i] : t->c[i];
    pdi_transport_anti(u->ctx, t, probe, moved);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < total; i++)
        if (kind[i] == PD_FLUID) y[i] -= (moved[i] - t->anti[i]) / step;
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
    pdi_compact_fill(ctx, t->desc.diffusivity, t->diffusion.field, &convection, 1.0 / t->dt, &faces, c);
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        double drain = t->absorb[node] + (t->diffusion.hold ? t->diffusion.hold[node] : 0.0);
        if (grid->kind[node] != PD_FLUID || !(drain > 0.0)) continue;
        pdi_grid_index(grid, node, i);
        c->mass[pdi_compact_cell(grid, i)] += (float)(drain * pdi_grid_circumference(grid, node));
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
    for (int32_t i = 0; i < t->grid->total && t->diffusion.drive; i++)
        if (kind[i] == PD_FLUID) t->rhs[i] += t->diffusion.drive[i];
}

/* residual = rhs - A c at fluid nodes, into out. */
PDI_FN void pdi_transport_residual(const pd_ctx *ctx, const pd_transport *t, double *out)
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

/* Flow through inlet and outlet bonds, and from and to held walls, at the present field. */
static void pdi_transport_boundary(pd_transport *t)
{
    pdi_sum out = {0.0, 0.0}, in = {0.0, 0.0};
    const pd_grid *grid = t->grid;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID) continue;
        double around = pdi_grid_circumference(grid, i);
        if (t->diffusion.hold) {
            double gain = t->diffusion.drive[i] - t->diffusion.hold[i] * t->c[i];
            pdi_sum_add(gain > 0.0 ? &in : &out, fabs(gain) * around);
        }
        if (!pdi_limiter_ports(t->bonds, i, 1)) continue;
        for (int k = 0; k < t->bonds->stencil->count; k++) {
            if (!pdi_transport_open(t, i, k)) continue;
            uint8_t far_kind = grid->kind[i + t->bonds->shift[k]];
            if (far_kind == PD_OUTLET) pdi_sum_add(&out, around * pdi_transport_bond_flux(t, t->c, i, k));
            if (far_kind == PD_INLET) pdi_sum_add(&in, -around * pdi_transport_bond_flux(t, t->c, i, k));
        }
    }
    /* between nodes antidiffusive fluxes cancel: their sum came through the inlets */
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) pdi_sum_add(&in, t->anti[i] * pdi_grid_circumference(grid, i));
    t->outflow = pdi_sum_total(&out) * t->bonds->stencil->volume;
    t->inflow = pdi_sum_total(&in) * t->bonds->stencil->volume;
}

/* Bounds that the step must keep: those of the field at its start and of the inflow; a source lifts the upper one. */
static void pdi_transport_bounds(const pd_transport *t, const double *start, double *low, double *high)
{
    *low = HUGE_VAL;
    *high = 0.0;
    for (int32_t i = 0; i < t->grid->total; i++) {
        uint8_t kind = t->grid->kind[i];
        if (kind != PD_FLUID && kind != PD_INLET) continue;
        double value = kind == PD_FLUID ? start[i] : t->c[i];
        *low = fmin(*low, value);
        *high = fmax(*high, value);
        if (kind == PD_FLUID && t->source[i] < 0.0) *low = -HUGE_VAL;
        if (kind == PD_FLUID && t->absorb[i] > 0.0) *low = fmin(*low, 0.0);
        if (kind == PD_FLUID && t->source[i] > 0.0) *high = HUGE_VAL;
    }
    if (!t->diffusion.hold) return;
    *low = fmin(*low, t->diffusion.held_least);
    *high = fmax(*high, t->diffusion.held_most);
}

/* Widen the bounds by a share of the field. */
static void pdi_transport_slack(const pd_transport *t, double share, double *low, double *high)
{
    double size = 0.0;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) size = fmax(size, fabs(t->c[i]));
    *low -= share * size;
    *high += share * size;
}

/* Mark the nodes outside of the bounds; how many are new. */
static int64_t pdi_transport_mark(pd_transport *t, double low, double high, double slack)
{
    int64_t found = 0;
    pdi_transport_slack(t, slack, &low, &high);
    for (int32_t i = 0; i < t->grid->total; i++) {
        if (t->grid->kind[i] != PD_FLUID || t->upwinded[i]) continue;
        if (t->c[i] >= low && t->c[i] <= high) continue;
        t->upwinded[i] = 1;
        found++;
    }
    t->upwinding = t->upwinding || found > 0;
    return found;
}

static void pdi_transport_measure(pd_transport *t)
{
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID || t->grid->kind[i] == PD_INLET) t->size = fmax(t->size, fabs(t->c[i]));
}

/* Begin a step: no node is upwinded, and the size of the field is that of now. Returns 1 when fluxes are limited. */
static int pdi_transport_start(pd_transport *t)
{
    memset(t->upwinded, 0, (size_t)t->grid->total);
    t->upwinding = 0;
    t->size = t->diffusion.hold ? fmax(t->diffusion.held_most, 0.0) : 0.0;
    pdi_transport_measure(t);
    return t->flow && t->desc.advection == PD_ADVECTION_LIMITED;
}

/* The limiter bounds a converged field; where the iteration has left the field outside of its bounds, the nodes
 * concerned lose their antidiffusive fluxes until none is left. Fluxes are limited, values never. */
static pd_status pdi_transport_enforce(pd_ctx *ctx, pd_transport *t, double atol, pd_transport_result *result)
{
    double low, high, change;
    pd_status status = PD_OK;
    pdi_transport_bounds(t, t->old, &low, &high);
    for (int round = 1; round <= PDI_TRANSPORT_ROUNDS; round++) {
        if (!pdi_transport_mark(t, low, high, PDI_TRANSPORT_SLACK)) break;
        if (round == PDI_TRANSPORT_ROUNDS) pdi_par_zero(ctx, t->grid->total, t->anti);
        else pdi_transport_anti(ctx, t, t->c, t->anti);
        pdi_transport_right_side(ctx, t);
        status = pdi_transport_correct(ctx, t, 1e-15, PDI_TRANSPORT_ROUGH * atol, &change, result);
        if (status < 0) return status;
        result->bounded = round;
    }
    return pdi_transport_correct(ctx, t, 1e-15, atol, &change, result);
}

/* Antidiffusive fluxes, right-hand side and residual of the present field; returns the norm of the residual. */
static double pdi_transport_evaluate(pd_ctx *ctx, pd_transport *t)
{
    pdi_transport_anti(ctx, t, t->c, t->anti);
    pdi_transport_right_side(ctx, t);
    pdi_transport_residual(ctx, t, t->work);
    return sqrt(pdi_par_dot(ctx, t->grid->total, t->work, t->work));
}

/* c += share delta, where delta is zero at all ghosts. */
static double pdi_transport_move(pd_ctx *ctx, pd_transport *t, double share, const double *delta)
{
    pdi_par_axpy(ctx, t->grid->total, share, delta, t->c);
    pdi_transport_measure(t);
    return pdi_transport_evaluate(ctx, t);
}

/* Newton's method on the limited equations until their residual falls below `goal` [mol/m3/s] or the field stays. Its
 * linear systems are solved as well as the last step paid (Eisenstat and Walker 1996); a step that does not lower the
 * residual is halved. */
static pd_status pdi_transport_newton(pd_ctx *ctx, pd_transport *t, double goal, pd_transport_result *result)
{
    pdi_transport_user user;
    pd_krylov_result linear;
    double *delta = t->work + t->grid->total, norm = pdi_transport_evaluate(ctx, t), loose = PDI_TRANSPORT_LOOSE;
    int most = t->krylov.desc.max_iterations;
    pd_status status = PD_OK;
    user.ctx = ctx;
    user.t = t;
    t->krylov.desc.max_iterations = PDI_TRANSPORT_KRYLOV;
    while (result->limiter < t->desc.max_limiter && norm > goal) {
        user.limited = pdi_par_max_abs(ctx, t->grid->total, t->anti) > 0.0;
        t->krylov.desc.rtol = user.limited ? loose : 1e-15;
        t->krylov.desc.atol = 0.5 * goal;
        status = pd_krylov_solve(ctx, &t->krylov, pdi_transport_jacobian, pdi_transport_precondition, &user, t->work,
                                 delta, &linear);
        if (status < 0) break;
        result->krylov += linear.iterations;
        double moved = pdi_par_max_abs(ctx, t->grid->total, delta), before = norm, share = 1.0;
        norm = pdi_transport_move(ctx, t, share, delta);
        for (; norm > before && share > PDI_TRANSPORT_SHORTEST; share *= 0.5)
            norm = pdi_transport_move(ctx, t, -0.5 * share, delta);
        result->change = t->size > 0.0 ? share * moved / t->size : 0.0;
        result->limiter++;
        if (result->change <= t->desc.limiter_tolerance || norm > PDI_TRANSPORT_STALLED * before) break;
        loose = fmin(PDI_TRANSPORT_LOOSE, fmax(PDI_TRANSPORT_TIGHT, 0.9 * (norm / before) * (norm / before)));
    }
    t->krylov.desc.max_iterations = most;
    return status < 0 ? status : PD_OK;
}

static pd_status pdi_transport_iterate(pd_ctx *ctx, pd_transport *t, double size, int bounded,
                                       pd_transport_result *result)
{
    double atol = t->desc.tolerance * size, change;
    if (!pdi_transport_start(t)) return pdi_transport_correct(ctx, t, 1e-15, atol, &result->change, result);
    PDI_TRY(pdi_transport_newton(ctx, t, PDI_TRANSPORT_ROUGH * atol, result));
    if (bounded) return pdi_transport_enforce(ctx, t, atol, result);
    return pdi_transport_correct(ctx, t, 1e-15, atol, &change, result);
}

PDI_FN pd_status pdi_transport_stage(pd_ctx *ctx, pd_transport *t, double dt, int bounded, pd_transport_result *result)
{
    int32_t total = t->grid->total;
    memset(result, 0, sizeof *result);
    t->dt = dt;
    pdi_transport_right_side(ctx, t);
    PDI_TRY(pdi_transport_setup(ctx, t));
    /* the size of the equations: right-hand side and inflow */
    pdi_transport_residual(ctx, t, t->work);
    double size = fmax(sqrt(pdi_par_dot(ctx, total, t->rhs, t->rhs)), sqrt(pdi_par_dot(ctx, total, t->work, t->work)));
    pd_status status = size > 0.0 ? pdi_transport_iterate(ctx, t, size, bounded, result) : PD_OK;
    if (status < 0) return status;
    result->residual = size > 0.0 ? result->residual / size : 0.0;
    pdi_transport_boundary(t);
    return result->residual <= 10.0 * t->desc.tolerance ? PD_OK : status;
}

PDI_FN int pdi_transport_within(const pd_transport *t, const double *start)
{
    double low, high;
    pdi_transport_bounds(t, start, &low, &high);
    pdi_transport_slack(t, PDI_TRANSPORT_SLACK, &low, &high);
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID && (t->c[i] < low || t->c[i] > high)) return 0;
    return 1;
}

pd_status pd_transport_implicit(pd_ctx *ctx, pd_transport *t, double dt, pd_transport_result *result)
{
    int32_t total = t->grid->total;
    if (!(dt > 0.0) || !(dt < 1e300))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport", "the step is %g s, expected a positive one", dt);
    pdi_par_copy(ctx, total, t->c, t->old);
    pd_status status = pdi_transport_stage(ctx, t, dt, 1, result);
    if (status < 0) {
        pdi_par_copy(ctx, total, t->old, t->c);
        return status;
    }
    pdi_transport_residual(ctx, t, t->carry);
    for (int32_t i = 0; i < total; i++) t->carry[i] *= dt;
    return status;
}

/* Rate [1/s] at which node i exchanges its content: one over its explicit limit. */
static double pdi_transport_rate(const pd_transport *t, int32_t i)
{
    double rate = t->absorb[i] + (t->diffusion.hold ? t->diffusion.hold[i] : 0.0);
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        double flux, bond, upwind;
        if (!pdi_transport_open(t, i, k)) continue;
        pdi_transport_bond(t, i, k, &flux, &bond, &upwind);
        if (t->grid->kind[i + t->bonds->shift[k]] == PD_OUTLET) rate += fmax(flux, 0.0);
        else rate += bond + 2.0 * upwind - 0.5 * flux;
    }
    return rate;
}

double pd_transport_limit(pd_ctx *ctx, const pd_transport *t)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) fastest = fmax(fastest, pdi_transport_rate(t, i));
    return fastest > 0.0 ? 1.0 / fastest : HUGE_VAL;
}

/* Longest time [s] in which a node exchanges its content; HUGE_VAL: nothing moves. */
static double pdi_transport_slowest(const pd_transport *t)
{
    double slowest = HUGE_VAL;
    for (int32_t i = 0; i < t->grid->total; i++) {
        double rate = t->grid->kind[i] == PD_FLUID ? pdi_transport_rate(t, i) : 0.0;
        if (rate > 0.0) slowest = fmin(slowest, rate);
    }
    return slowest < HUGE_VAL ? 1.0 / slowest : HUGE_VAL;
}

pd_status pd_transport_steady(pd_ctx *ctx, pd_transport *t, pd_transport_result *result)
{
    double limit = pdi_transport_slowest(t);
    int krylov = 0;
    if (!(limit < 1e200))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "transport", "nothing moves: there is no steady field to find");
    for (int step = 0; step < PDI_TRANSPORT_STEPS; step++) {
        double moved = 0.0, size = 0.0;
        pd_status status = pd_transport_implicit(ctx, t, PDI_TRANSPORT_LONG * limit, result);
        result->krylov = krylov += result->krylov;
        if (status < 0) return status;
        /* what is owed belongs to a time that never was */
        pdi_par_zero(ctx, t->grid->total, t->carry);
        for (int32_t i = 0; i < t->grid->total; i++) {
            if (t->grid->kind[i] != PD_FLUID) continue;
            moved = fmax(moved, fabs(t->c[i] - t->old[i]));
            size = fmax(size, fabs(t->c[i]));
        }
        result->change = size > 0.0 ? moved / size : 0.0;
        if (result->change <= PDI_TRANSPORT_SETTLED) return PD_OK;
    }
    return PD_NOT_CONVERGED;
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
    int limited = pdi_transport_start(t), rounds = PDI_TRANSPORT_ROUNDS;
    double low, high;
    pdi_par_copy(ctx, t->grid->total, t->c, t->old);
    pdi_transport_bounds(t, t->old, &low, &high);
    pdi_transport_operator(ctx, t, t->old, t->rhs);
    do {
        pdi_par_copy(ctx, t->grid->total, t->old, t->c);
        if (limited) pdi_transport_anti(ctx, t, t->c, t->anti);
        pdi_transport_boundary(t);
        for (int32_t i = 0; i < t->grid->total; i++)
            if (kind[i] == PD_FLUID) {
                double held = t->diffusion.drive ? t->diffusion.drive[i] : 0.0;
                t->c[i] = t->old[i] + dt * (t->source[i] + held + t->anti[i] - t->rhs[i]) + t->carry[i];
            }
    } while (limited && --rounds > 0 && pdi_transport_mark(t, low, high, 1e-15) > 0);
    pdi_par_zero(ctx, t->grid->total, t->carry);
    return PD_OK;
}

/* Upwinded flux [mol/m3/s] of bond k of node i. One of both ends is fluid, the flux is told from there. */
static double pdi_transport_section_bond(const void *user, int32_t i, int k)
{
    const pd_transport *t = (const pd_transport *)user;
    int32_t j = i + t->bonds->shift[k];
    if (t->grid->kind[i] == PD_FLUID) return pdi_transport_bond_flux(t, t->c, i, k);
    double over = pdi_grid_circumference(t->grid, j) / pdi_grid_circumference(t->grid, i);
    return -over * pdi_transport_bond_flux(t, t->c, j, t->bonds->stencil->count - 1 - k);
}

/* What node i gains by the antidiffusive flux of bond k (eq. 5.4), likewise. */
static double pdi_transport_section_anti(const void *user, int32_t i, int k)
{
    const pd_transport *t = (const pd_transport *)user;
    int32_t j = i + t->bonds->shift[k];
    pdi_transport_sweep s;
    pdi_transport_lanes l;
    double lean;
    if (t->grid->kind[i] != PD_FLUID) {
        double over = pdi_grid_circumference(t->grid, j) / pdi_grid_circumference(t->grid, i);
        return -over * pdi_transport_section_anti(t, j, t->bonds->stencil->count - 1 - k);
    }
    memset(&s, 0, sizeof s);
    memset(&l, 0, sizeof l);
    s.t = t;
    s.c = t->c;
    s.task = PDI_TRANSPORT_ANTI;
    l.count = 1;
    int ports = pdi_limiter_ports(t->bonds, i, 1);
    if (!pdi_transport_bond_lanes(&s, i, t->bonds->row[i], k, ports, &l)) return 0.0;
    pdi_transport_lean(&s, i, k, ports, &l, &lean);
    return -(l.gated ? l.gate[0] : 1.0) * t->limiter.keep[l.flux[0] > 0.0 ? i : j] * l.upwind[0] * lean;
}

/* What passes the plane by antidiffusion is all that the nodes on one side of it gain, since the fluxes between them
 * cancel, unless inlets feed both sides or the axis is periodic: then bond by bond, up to what the limiter still
 * moves. */
static double pdi_transport_section_gain(const pd_transport *t, int axis, int index)
{
    pdi_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
    int fed[2] = {0, 0};
    if (t->grid->side[2 * axis] == PD_SIDE_PERIODIC) fed[0] = fed[1] = 1;
    for (int32_t node = 0; node < t->grid->total; node++) {
        int i[PD_DIM];
        pdi_grid_index(t->grid, node, i);
        int behind = i[axis] >= index;
        if (t->grid->kind[node] == PD_INLET) fed[behind] = 1;
        if (t->grid->kind[node] != PD_FLUID) continue;
        pdi_sum_add(&sum[behind], t->anti[node] * pdi_grid_circumference(t->grid, node));
    }
    if (!fed[0]) return pdi_sum_total(&sum[0]);
    if (!fed[1]) return -pdi_sum_total(&sum[1]);
    return pdi_bond_section(t->bonds, axis, index, pdi_transport_section_anti, t);
}

double pd_transport_section(pd_ctx *ctx, pd_transport *t, int axis, int index)
{
    int limited = t->flow && t->desc.advection == PD_ADVECTION_LIMITED;
    (void)ctx;
    pd_ghosts_scalar(&t->bonds->ghosts, t->c);
    double low = pdi_bond_section(t->bonds, axis, index, pdi_transport_section_bond, t);
    double gain = limited ? pdi_transport_section_gain(t, axis, index) : 0.0;
    return (low - gain) * t->bonds->stencil->volume;
}

static double pdi_transport_total(const pd_transport *t, const double *field)
{
    pdi_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < t->grid->total; i++)
        if (t->grid->kind[i] == PD_FLUID) pdi_sum_add(&sum, field[i] * pdi_grid_circumference(t->grid, i));
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

static void pdi_transport_inlets(pd_transport *t)
{
    for (int32_t i = 0; i < t->grid->total; i++) {
        double x[PD_DIM];
        if (t->grid->kind[i] != PD_INLET) continue;
        pd_grid_position(t->grid, i, x);
        pdi_grid_fold_images(t->grid, x);
        t->c[i] = t->desc.entering ? t->desc.entering(t->desc.user, x) : t->desc.inlet;
    }
}

void pd_transport_update(pd_ctx *ctx, pd_transport *t)
{
    pd_diffusion_update(ctx, &t->diffusion);
    pdi_transport_inlets(t);
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
    if (t->desc.max_limiter <= 0) t->desc.max_limiter = 30;
    if (!(t->desc.limiter_tolerance > 0.0)) t->desc.limiter_tolerance = 1e-7;
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
        md.periodic[d] = grid->side[2 * d] == PD_SIDE_PERIODIC;
    }
    md.first = pd_grid_node(grid, origin);
    md.weight = grid->circumference ? grid->circumference + grid->ghost : NULL;
    md.symmetric = flow == NULL;
    PDI_TRY(pdi_compact_build(ctx, grid, flow != NULL, &t->compact));
    PDI_TRY(pd_multigrid_build(ctx, &md, &t->mg));
    PDI_TRY(pd_krylov_build(ctx, &kd, &t->krylov));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->c));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->old));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->source));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->absorb));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->carry));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->anti));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->upwinded));
    PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->rhs));
    PDI_TRY(PDI_NEW(ctx, "transport", 2 * (int64_t)grid->total, t->work));
    PDI_TRY(PDI_NEW(ctx, "transport", 2 * (int64_t)grid->total, t->probe));
    for (int s = 0; s < 2 * PD_DIM && !t->repeated; s++)
        if (grid->side[s] >= PD_SIDE_PERIODIC) PDI_TRY(PDI_NEW(ctx, "transport", grid->total, t->repeated));
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) t->c[i] = desc->initial;
    pd_diffusion_desc dd;
    memset(&dd, 0, sizeof dd);
    dd.diffusivity = desc->diffusivity;
    dd.field = desc->field;
    dd.level = desc->level;
    dd.held = desc->held;
    dd.user = desc->user;
    PDI_TRY(pd_diffusion_build(ctx, bonds, &dd, &t->diffusion));
    if (flow) PDI_TRY(pdi_limiter_build(ctx, &t->diffusion, &t->limiter));
    pdi_transport_inlets(t);
    return PD_OK;
}

void pd_transport_free(pd_ctx *ctx, pd_transport *t)
{
    int64_t total = t->grid ? t->grid->total : 0;
    pdi_limiter_free(ctx, &t->limiter);
    pd_diffusion_free(ctx, &t->diffusion);
    pdi_compact_free(ctx, &t->compact);
    pd_multigrid_free(ctx, &t->mg);
    pd_krylov_free(ctx, &t->krylov);
    PDI_DELETE(ctx, total, t->c);
    PDI_DELETE(ctx, total, t->old);
    PDI_DELETE(ctx, total, t->source);
    PDI_DELETE(ctx, total, t->absorb);
    PDI_DELETE(ctx, total, t->carry);
    PDI_DELETE(ctx, total, t->anti);
    PDI_DELETE(ctx, total, t->upwinded);
    PDI_DELETE(ctx, total, t->rhs);
    PDI_DELETE(ctx, 2 * total, t->work);
    PDI_DELETE(ctx, 2 * total, t->probe);
    PDI_DELETE(ctx, total, t->repeated);
    memset(t, 0, sizeof *t);
}
