/* flux: see flux.h
 *
 * Design: the volume fluxes of the bonds hold during a step. In 1D and 2D they are stored, once for both ends: bond k
 * of node i is bond count-1-k of its far end. In 3D they would be a third of the memory of a run, and are told anew by
 * each sweep, with the same bits from both ends. Sweeps go bond by bond over blocks of nodes along axis 0. Closed bonds
 * carry and conduct zero.
 */
#include "transport/flux.h"
#include "core/vec.h"
#include "core/par.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Share of xi.G in the antidiffusive fluxes: damps what alternates from node to node, which a central flux does not
 * see. */
#define PDI_FLUX_LEAN 0.3

/* Rows whose conductances stand together: a sweep over blocks of them reads on in memory. */
#define PDI_FLUX_PAGE 64

/* For fluid at rest. */
static const double pdi_flux_still[PDI_BLOCK] = {0.0};

/* Where F of bond k of the nodes from i stands, and the factor that it is to be taken with. */
static inline double *pdi_flux_slot(const pd_flux *t, int32_t i, int k, double *factor)
{
    const pd_grid *grid = t->bonds->grid;
    int count = t->bonds->stencil->count;
    int32_t j = i + t->bonds->shift[k];
    *factor = 1.0;
    if (k < count / 2) return t->flux + (int64_t)k * grid->total + i;
    *factor = -1.0;
    if (grid->circumference) *factor = -pdi_grid_circumference(grid, j) / pdi_grid_circumference(grid, i);
    return t->flux + (int64_t)(count - 1 - k) * grid->total + j;
}

/* Where the conductance of bond k of a row stands; those of the next rows follow up to the end of its page. */
static inline double *pdi_flux_place(const pd_flux *t, int32_t row, int k)
{
    int64_t page = row / PDI_FLUX_PAGE;
    return t->conduct + (page * t->bonds->stencil->count + k) * PDI_FLUX_PAGE + row % PDI_FLUX_PAGE;
}

/* Fraction at which bond k of node i crosses the side of the box behind which its inlet ghost lies: there the inflow
 * has its value, and the ghost has it at any depth. */
static double pdi_flux_entry(const pd_flux *t, int32_t i, int k)
{
    const pd_grid *grid = t->bonds->grid;
    double fraction = 1.0;
    int at[PD_DIM];
    if (grid->kind[i + t->bonds->shift[k]] != PD_INLET) return 1.0;
    pdi_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        int step = t->bonds->stencil->offset[k * PD_DIM + d], upper = step > 0;
        double inside = upper ? grid->n[d] - at[d] - 0.5 : at[d] + 0.5; /* cells to the side */
        if (pdi_grid_port(grid->side[2 * d + upper])) fraction = fmin(fraction, step ? inside / abs(step) : 1.0);
    }
    return fraction;
}

PDI_FN void pdi_flux_bond(const pd_flux *t, int32_t i, int k, double *flux, double *bond, double *upwind)
{
    pdi_diffusion_bond(t->diffusion, i, k, 1, t->bonds->row[i] >= 0, bond);
    *bond /= pdi_flux_entry(t, i, k);
    *flux = t->flow ? pdi_flow_bond_flux(t->flow, i, k) : 0.0;
    *upwind = fmax(0.5 * fabs(*flux) - *bond, 0.0);
}

PDI_FN double pdi_flux_bond_flux(const pd_flux *t, const double *c, int32_t i, int k)
{
    double flux, bond, upwind;
    int32_t j = i + t->bonds->shift[k];
    pdi_flux_bond(t, i, k, &flux, &bond, &upwind);
    if (t->bonds->grid->kind[j] == PD_OUTLET) return flux * c[i];
    return 0.5 * flux * (c[i] + c[j]) - (bond + upwind) * (c[j] - c[i]);
}

PDI_FN int pdi_flux_open(const pd_flux *t, int32_t i, int k)
{
    int32_t r = t->bonds->row[i];
    return r < 0 || pdi_bond_open(t->bonds, r, k);
}

/* ---- what holds during a step ---- */

/* Where a(n) xi = c g(n) for all bonds, with one c for each axis, what the gradient of the pressure gives a bond is a
 * part of its velocity. So on lattices of equal spacings. */
static void pdi_flux_lean(pd_flux *t)
{
    const pd_stencil *s = t->bonds->stencil;
    double *c = t->lean;
    t->even = 1;
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double g = s->grad[k * PD_DIM + d], drop = s->lap[k] * s->xi[k * PD_DIM + d];
            if (fabs(g) > 0.0 && !(fabs(c[d]) > 0.0)) c[d] = drop / g;
            if (fabs(drop - c[d] * g) > 1e-12 * s->lap[k] * pdi_vec_norm(s->xi + k * PD_DIM)) t->even = 0;
        }
    for (int d = 0; d < PD_DIM && !t->even; d++) c[d] = 0.0;
}

/* F of a bond is g.(w_i + w_j) - a (q_j - q_i), less what the pressure gradients leave in uneven lattices: w and q hold
 * carrier, pressure, its gradient and the potential of the flow (eq. 4.4, 4.10b). */
static void pdi_flux_drive(const pd_ctx *ctx, const pd_flux *t)
{
    const pd_flow *f = t->flow;
    int64_t total = f->grid->total;
    double *q = t->drive + PD_DIM * total;
    int nt = pdi_par_threads(ctx, total * PD_DIM);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < total; i++) {
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = d * total + i;
            t->drive[at] = f->carrier[at] + 0.5 * f->tau * t->lean[d] * f->grad[at];
        }
        q[i] = f->tau * f->p[i] + (f->potential ? f->potential[i] : 0.0);
    }
}

/* What uneven lattices add to the fluxes of bond k of `count` nodes from i. */
static void pdi_flux_uneven(const pd_flux *t, int32_t i, int k, int count, double *flux)
{
    const pd_flow *f = t->flow;
    const pd_stencil *s = f->bonds->stencil;
    const double *grad = f->grad + i, *far = grad + f->bonds->shift[k];
    double part = 0.5 * f->tau * pdi_bond_lap(f->bonds, i)[k];
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * f->grid->total;
        for (int b = 0; b < count; b++) flux[b] += part * s->xi[k * PD_DIM + d] * (grad[at + b] + far[at + b]);
    }
}

/* Sum over the axes of g.w at node b of w. */
PDI_INLINE double pdi_flux_along(const double *g, const double *w, int64_t total)
{
    double sum = g[0] * w[0];
    for (int d = 1; d < PD_DIM; d++) sum += g[d] * w[d * total];
    return sum;
}

/* Volume fluxes of bond k of `count` nodes from i (as pdi_flow_bond_flux), tied by the pressure. */
static void pdi_flux_volume(const pd_flux *t, int32_t i, int k, int count, double *flux)
{
    const pd_bonds *bonds = t->bonds;
    int64_t total = bonds->grid->total, shift = bonds->shift[k];
    const double *w = t->drive + i, *q = w + PD_DIM * total, *g = bonds->stencil->grad + k * PD_DIM;
    double a = pdi_bond_lap(bonds, i)[k], share = pdi_bond_flux(bonds, i, k);
    for (int b = 0; b < count; b++) {
        double sum = pdi_flux_along(g, w + b, total) + pdi_flux_along(g, w + b + shift, total);
        flux[b] = share * sum - a * (q[b + shift] - q[b]);
    }
    if (!t->even) pdi_flux_uneven(t, i, k, count, flux);
}

/* The same of bond k and of the opposite one, in planar boxes. */
PDI_INLINE void pdi_flux_volumes(const pd_flux *t, int32_t i, int k, int count, double *PD_RESTRICT ahead,
                                    double *PD_RESTRICT behind)
{
    const pd_stencil *s = t->bonds->stencil;
    int64_t total = t->bonds->grid->total, shift = t->bonds->shift[k];
    const double *w = t->drive + i, *q = w + PD_DIM * total, *g = s->grad + k * PD_DIM;
    double a = s->lap[k];
    for (int b = 0; b < count; b++) {
        double here = pdi_flux_along(g, w + b, total);
        ahead[b] = here + pdi_flux_along(g, w + b + shift, total) - a * (q[b + shift] - q[b]);
        behind[b] = -(here + pdi_flux_along(g, w + b - shift, total)) - a * (q[b - shift] - q[b]);
    }
    if (t->even) return;
    pdi_flux_uneven(t, i, k, count, ahead);
    pdi_flux_uneven(t, i, s->count - 1 - k, count, behind);
}

/* Fluxes of bond k of the nodes i .. i+count-1: nodes of the first half of a family keep them; of the others those that
 * end on ghosts, which have none of their own. */
static void pdi_flux_store(const pd_flux *t, int32_t i, int32_t row, int k, int count)
{
    const pd_bonds *bonds = t->bonds;
    int32_t shift = bonds->shift[k];
    int own = k < bonds->stencil->count / 2, ghosts = 0;
    double flux[PDI_LANES], open[PDI_LANES], factor, *slot = pdi_flux_slot(t, i, k, &factor);
    pdi_bond_gate gate = {NULL, 0, 0, 0};
    for (int b = 0; b < count && !own; b++) ghosts += bonds->grid->kind[i + b + shift] != PD_FLUID;
    if (!own && !ghosts) return;
    pdi_lanes lanes = pdi_bond_gate_open(bonds, row, k, count, &gate, open);
    pdi_flux_volume(t, i, k, count, flux);
    for (int b = 0; b < count; b++) {
        uint8_t kind = bonds->grid->kind[i + b + shift];
        int shut = lanes == PDI_LANES_NONE || (lanes == PDI_LANES_SOME && !(open[b] > 0.0));
        if (!own && kind == PD_FLUID) continue;
        if (kind == PD_INLET) flux[b] = pdi_flow_bond_flux(t->flow, i + b, k);
        slot[b] = shut ? 0.0 : flux[b] / factor;
    }
}

static void pdi_flux_refresh_run(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pd_flux *t = (const pd_flux *)user;
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        if (t->flux) pdi_flux_store(t, i, row, k, count);
        if (row < 0) continue;
        double conduct[PDI_LANES];
        pdi_diffusion_bond(t->diffusion, i, k, count, 1, conduct);
        for (int b = 0; b < count; b++) {
            double entry = t->bonds->inlet[row + b] ? pdi_flux_entry(t, i + b, k) : 1.0;
            *pdi_flux_place(t, row + b, k) = pdi_bond_open(t->bonds, row + b, k) ? conduct[b] / entry : 0.0;
        }
    }
}

/* F and the conductance of bond k of node i, as sweeps see them. */
static void pdi_flux_one(const pd_flux *t, int32_t i, int k, double *flux, double *bond)
{
    int32_t row = t->bonds->row[i];
    *flux = 0.0;
    if (t->flux) {
        double factor;
        const double *slot = pdi_flux_slot(t, i, k, &factor);
        *flux = factor * *slot;
    } else if (t->flow && pdi_flux_open(t, i, k)) {
        int inlet = t->bonds->grid->kind[i + t->bonds->shift[k]] == PD_INLET;
        if (inlet) *flux = pdi_flow_bond_flux(t->flow, i, k);
        else pdi_flux_volume(t, i, k, 1, flux);
    }
    if (row >= 0) *bond = *pdi_flux_place(t, row, k);
    else pdi_diffusion_bond(t->diffusion, i, k, 1, 0, bond);
}

PDI_FN pd_status pdi_flux_refresh(pd_ctx *ctx, const pd_flux *convect)
{
    const pd_bonds *bonds = convect->bonds;
    if (bonds->rows > convect->capacity)
        return pdi_fail(ctx, PD_ERR_STATE, "convect",
                        "%d rows, expected at most %d: call pd_transport_update after pd_bonds_update", bonds->rows,
                        convect->capacity);
    if (convect->flow) pdi_flux_drive(ctx, convect);
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 8, PDI_LANES, pdi_flux_refresh_run,
                   convect);
    for (int32_t p = 0; p < convect->ports->count; p++)
        for (int k = 0; k < bonds->stencil->count; k++) {
            int64_t slot = (int64_t)p * bonds->stencil->count + k;
            pdi_flux_one(convect, convect->ports->node[p], k, convect->port_flux + slot, convect->port_bond + slot);
        }
    return PD_OK;
}

/* ---- sweeps ---- */

/* What a sweep does with its nodes: y = A c, the limited antidiffusive fluxes y, or their derivative. */
typedef struct pdi_flux_sweep pdi_flux_sweep;
typedef void (*pdi_flux_block_fn)(const pdi_flux_sweep *s, int32_t i, int32_t row, int count);
typedef void (*pdi_flux_port_fn)(const pdi_flux_sweep *s, int32_t p);

struct pdi_flux_sweep {
    const pd_flux *t;
    const double *c;
    const double *x, *keep_by, *slope_by; /* direction of a derivative, and those of the limiter along it */
    double *y;
    pdi_flux_block_fn block; /* of nodes away from ports */
    pdi_flux_port_fn port;   /* of one node beside inlets or outlets */
};

/* Bond k of a block and its opposite one, to the far ends ahead and behind. */
typedef struct pdi_flux_pair {
    int32_t shift;                /* ahead; the same behind */
    const double *flux, *back;    /* F [1/s] of the bond ahead, and of that which comes from behind or leaves there */
    double turn;                  /* what `back` is to be multiplied with to leave: -1 as stored in planes */
    const double *ahead, *behind; /* conductances [1/s] */
    double space[2][PDI_BLOCK];   /* for those of whole families, and across pages */
    double volume[2][PDI_BLOCK];  /* for fluxes that are not stored */
} pdi_flux_pair;

/* Conductances of bond k of a block; `space`: room for those that do not stand together. */
static inline const double *pdi_flux_conduct(const pd_flux *t, int32_t i, int32_t row, int k, int count,
                                                double *PD_RESTRICT space)
{
    if (row >= 0 && row % PDI_FLUX_PAGE + count <= PDI_FLUX_PAGE) return pdi_flux_place(t, row, k);
    for (int b = 0; b < count && row >= 0; b++) space[b] = *pdi_flux_place(t, row + b, k);
    if (row >= 0) return space;
    if (t->diffusion->field) {
        pdi_diffusion_bond(t->diffusion, i, k, count, 0, space);
        return space;
    }
    double whole = t->diffusion->desc.diffusivity * pdi_bond_lap(t->bonds, i)[k];
    for (int b = 0; b < count; b++) space[b] = whole;
    return space;
}

/* Close the bonds k of the rows from `row` that are. */
static inline void pdi_flux_shut(const pd_flux *t, int32_t row, int k, int count, double *PD_RESTRICT flux)
{
    pdi_bond_gate gate;
    gate.word = pdi_bond_words(t->bonds, row, k);
    for (int b = 0; b < count; b++) flux[b] *= pdi_bond_gate_lane(&gate, k, b);
}

PDI_INLINE void pdi_flux_pair_get(const pd_flux *t, int32_t i, int32_t row, int k, int count,
                                     pdi_flux_pair *p)
{
    int opposite = t->bonds->stencil->count - 1 - k;
    p->shift = t->bonds->shift[k];
    p->flux = p->back = pdi_flux_still;
    p->turn = -1.0;
    if (t->flux) {
        p->flux = pdi_flux_slot(t, i, k, &p->turn);
        p->back = pdi_flux_slot(t, i, opposite, &p->turn);
    } else if (PD_DIM == 3 && t->flow) {
        pdi_flux_volumes(t, i, k, count, p->volume[0], p->volume[1]);
        if (row >= 0) {
            pdi_flux_shut(t, row, k, count, p->volume[0]);
            pdi_flux_shut(t, row, opposite, count, p->volume[1]);
        }
        p->flux = p->volume[0];
        p->back = p->volume[1];
        p->turn = 1.0;
    }
    p->ahead = pdi_flux_conduct(t, i, row, k, count, p->space[0]);
    p->behind = pdi_flux_conduct(t, i, row, opposite, count, p->space[1]);
}

/* What leaves through one bond (eq. 5.1): conductances are at least |F|/2. */
static inline double pdi_flux_leave(double half, double least, double near, double far)
{
    double size = fabs(half);
    return half * (near + far) - (size > least ? size : least) * (far - near);
}

/* Compiled for whole blocks and for shorter ones. */
static inline void pdi_flux_apply_block(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT c = s->c + i, *PD_RESTRICT absorb = t->absorb + i, *hold = t->diffusion->hold;
    double sum[PDI_BLOCK], rate = t->rate, *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = (rate + absorb[b]) * c[b];
    for (int b = 0; b < count && hold; b++) sum[b] += hold[i + b] * c[b];
    for (int k = 0; k < t->bonds->stencil->count / 2; k++) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, k, count, &p);
        const double *next = c + p.shift, *before = c - p.shift, *flux = p.flux, *back = p.back;
        const double *ahead = p.ahead, *behind = p.behind;
        double part = 0.5 * p.turn;
        for (int b = 0; b < count; b++)
            sum[b] += pdi_flux_leave(0.5 * flux[b], ahead[b], c[b], next[b]) +
                      pdi_flux_leave(part * back[b], behind[b], c[b], before[b]);
    }
    for (int b = 0; b < count; b++) y[b] = sum[b];
}

static void pdi_flux_apply_nodes(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    if (count == PDI_BLOCK) pdi_flux_apply_block(s, i, row, PDI_BLOCK);
    else pdi_flux_apply_block(s, i, row, count);
}

static void pdi_flux_apply_port(const pdi_flux_sweep *s, int32_t p)
{
    const pd_flux *t = s->t;
    int count = t->bonds->stencil->count;
    int32_t i = t->ports->node[p];
    const int32_t *far = t->ports->far + (int64_t)p * count;
    const double *flux = t->port_flux + (int64_t)p * count, *bond = t->port_bond + (int64_t)p * count;
    double c = s->c[i], sum = (t->rate + t->absorb[i]) * c;
    if (t->diffusion->hold) sum += t->diffusion->hold[i] * c;
    for (int k = 0; k < count; k++) sum += pdi_flux_leave(0.5 * flux[k], bond[k], c, s->c[far[k]]);
    s->y[i] = sum;
}

/* alpha d s of one bond: its step of the field, leant towards xi.G of the upwind end, less where they differ by far;
 * alpha of that end, and d what upwinding adds to the conductance (eq. 5.4). */
static inline double pdi_flux_return(double flux, double least, double step, double lean, double x, double alpha)
{
    double off = x - step, square = step * step, sum = square + 0.25 * off * off, excess = 0.5 * fabs(flux) - least;
    double mixed = step + lean * (sum > 0.0 ? square / sum : 1.0) * off;
    return alpha * (excess > 0.0 ? excess : 0.0) * mixed;
}

/* Its derivative, with those of the step, of x and of alpha. */
static inline double pdi_flux_return_by(double flux, double least, double step, double lean, double x, double alpha,
                                           double step_by, double x_by, double alpha_by)
{
    double off = x - step, off_by = x_by - step_by, excess = 0.5 * fabs(flux) - least;
    double square = step * step, sum = square + 0.25 * off * off, over = sum > 0.0 ? 1.0 / sum : 0.0;
    double weight = sum > 0.0 ? square * over : 1.0, rest = 1.0 - weight;
    double mixed = step + lean * weight * off;
    double mixed_by = step_by + lean * (weight * (weight - rest) * off_by + 2.0 * rest * off * step * over * step_by);
    return (excess > 0.0 ? excess : 0.0) * (alpha_by * mixed + alpha * mixed_by);
}

static inline void pdi_flux_anti_block(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT c = s->c + i, *PD_RESTRICT keep = t->limiter->keep + i;
    const double *PD_RESTRICT slope = t->limiter->slope + i, *xi = t->bonds->stencil->xi;
    int64_t total = t->bonds->grid->total;
    double sum[PDI_BLOCK], *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < t->bonds->stencil->count / 2; k++, xi += PD_DIM) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, k, count, &p);
        const double *flux = p.flux, *back = p.back, *ahead = p.ahead, *behind = p.behind;
        double turn = p.turn;
        int32_t shift = p.shift;
        for (int b = 0; b < count; b++) {
            double x = 0.0, next = 0.0, before = 0.0, f = flux[b], g = turn * back[b], alpha = keep[b];
            for (int d = 0; d < PD_DIM; d++) {
                x += xi[d] * slope[d * total + b];
                next += xi[d] * slope[d * total + b + shift];
                before += xi[d] * slope[d * total + b - shift];
            }
            double alpha_next = keep[b + shift], alpha_before = keep[b - shift];
            sum[b] -= pdi_flux_return(f, ahead[b], c[b + shift] - c[b], PDI_FLUX_LEAN,
                                         f > 0.0 ? x : next, f > 0.0 ? alpha : alpha_next);
            sum[b] -= pdi_flux_return(g, behind[b], c[b - shift] - c[b], PDI_FLUX_LEAN,
                                         g > 0.0 ? -x : -before, g > 0.0 ? alpha : alpha_before);
        }
    }
    for (int b = 0; b < count; b++) y[b] = sum[b];
}

static void pdi_flux_anti_nodes(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    if (count == PDI_BLOCK) pdi_flux_anti_block(s, i, row, PDI_BLOCK);
    else pdi_flux_anti_block(s, i, row, count);
}

static inline void pdi_flux_anti_block_by(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT c = s->c + i, *PD_RESTRICT keep = t->limiter->keep + i, *PD_RESTRICT z = s->x + i;
    const double *PD_RESTRICT slope = t->limiter->slope + i, *xi = t->bonds->stencil->xi;
    const double *PD_RESTRICT keep_by = s->keep_by + i, *PD_RESTRICT slope_by = s->slope_by + i;
    int64_t total = t->bonds->grid->total;
    double sum[PDI_BLOCK], *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < t->bonds->stencil->count / 2; k++, xi += PD_DIM) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, k, count, &p);
        const double *flux = p.flux, *back = p.back, *ahead = p.ahead, *behind = p.behind;
        double turn = p.turn;
        int32_t shift = p.shift;
        for (int b = 0; b < count; b++) {
            double f = flux[b], g = turn * back[b], x = 0.0, next = 0.0, before = 0.0;
            double x_by = 0.0, next_by = 0.0, before_by = 0.0, alpha = keep[b], alpha_by = keep_by[b];
            for (int d = 0; d < PD_DIM; d++) {
                x += xi[d] * slope[d * total + b];
                next += xi[d] * slope[d * total + b + shift];
                before += xi[d] * slope[d * total + b - shift];
                x_by += xi[d] * slope_by[d * total + b];
                next_by += xi[d] * slope_by[d * total + b + shift];
                before_by += xi[d] * slope_by[d * total + b - shift];
            }
            double alpha_next = keep[b + shift], alpha_before = keep[b - shift];
            double alpha_next_by = keep_by[b + shift], alpha_before_by = keep_by[b - shift];
            sum[b] -= pdi_flux_return_by(f, ahead[b], c[b + shift] - c[b], PDI_FLUX_LEAN, f > 0.0 ? x : next,
                                            f > 0.0 ? alpha : alpha_next, z[b + shift] - z[b],
                                            f > 0.0 ? x_by : next_by, f > 0.0 ? alpha_by : alpha_next_by);
            sum[b] -= pdi_flux_return_by(g, behind[b], c[b - shift] - c[b], PDI_FLUX_LEAN,
                                            g > 0.0 ? -x : -before, g > 0.0 ? alpha : alpha_before,
                                            z[b - shift] - z[b], g > 0.0 ? -x_by : -before_by,
                                            g > 0.0 ? alpha_by : alpha_before_by);
        }
    }
    for (int b = 0; b < count; b++) y[b] = sum[b];
}

static void pdi_flux_anti_nodes_by(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    if (count == PDI_BLOCK) pdi_flux_anti_block_by(s, i, row, PDI_BLOCK);
    else pdi_flux_anti_block_by(s, i, row, count);
}

/* The antidiffusive flux out of node i through bond k, which ends on `far`. Inlets have no gradient. */
static double pdi_flux_anti_one(const pdi_flux_sweep *s, int32_t i, int32_t far, int k, double flux, double bond)
{
    const pd_grid *grid = s->t->bonds->grid;
    const pd_limiter *limiter = s->t->limiter;
    int32_t upwind = flux > 0.0 ? i : far;
    double x = 0.0, lean = grid->kind[upwind] == PD_INLET ? 0.0 : PDI_FLUX_LEAN;
    for (int d = 0; d < PD_DIM; d++)
        x += s->t->bonds->stencil->xi[k * PD_DIM + d] * limiter->slope[(int64_t)d * grid->total + upwind];
    return pdi_flux_return(flux, bond, s->c[far] - s->c[i], lean, x, limiter->keep[upwind]);
}

static void pdi_flux_anti_port(const pdi_flux_sweep *s, int32_t p)
{
    const pd_flux *t = s->t;
    int count = t->bonds->stencil->count;
    int64_t first = (int64_t)p * count;
    double sum = 0.0;
    for (int k = 0; k < count; k++)
        sum -= pdi_flux_anti_one(s, t->ports->node[p], t->ports->far[first + k], k, t->port_flux[first + k],
                                    t->port_bond[first + k]);
    s->y[t->ports->node[p]] = sum;
}

static void pdi_flux_anti_port_by(const pdi_flux_sweep *s, int32_t p)
{
    const pd_grid *grid = s->t->bonds->grid;
    const pd_stencil *st = s->t->bonds->stencil;
    const pd_limiter *limiter = s->t->limiter;
    int32_t i = s->t->ports->node[p];
    double sum = 0.0;
    for (int k = 0; k < st->count; k++) {
        int64_t slot = (int64_t)p * st->count + k;
        double flux = s->t->port_flux[slot], x = 0.0, x_by = 0.0;
        int32_t far = s->t->ports->far[slot], upwind = flux > 0.0 ? i : far;
        double lean = grid->kind[upwind] == PD_INLET ? 0.0 : PDI_FLUX_LEAN;
        for (int d = 0; d < PD_DIM; d++) {
            x += st->xi[k * PD_DIM + d] * limiter->slope[(int64_t)d * grid->total + upwind];
            x_by += st->xi[k * PD_DIM + d] * s->slope_by[(int64_t)d * grid->total + upwind];
        }
        sum -= pdi_flux_return_by(flux, s->t->port_bond[slot], s->c[far] - s->c[i], lean, x, limiter->keep[upwind],
                                     s->x[far] - s->x[i], x_by, s->keep_by[upwind]);
    }
    s->y[i] = sum;
}

static void pdi_flux_run(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_flux_sweep *s = (const pdi_flux_sweep *)user;
    int32_t part;
    int beside, count;
    for (int32_t begin = 0; begin < length; begin += part) {
        part = pdi_port_segment(s->t->bonds, i + begin, length - begin, &beside);
        for (int32_t at = 0; at < part && !beside; at += count) {
            count = pdi_bond_block(part, &at);
            s->block(s, i + begin + at, row < 0 ? row : row + begin + at, count);
        }
    }
}

static void pdi_flux_sweep_all(const pd_ctx *ctx, pdi_flux_sweep *s)
{
    const pd_bonds *bonds = s->t->bonds;
    pdi_bond_sweep(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 2, 0, pdi_flux_run, s);
    int nt = pdi_par_threads(ctx, (int64_t)s->t->ports->count * bonds->stencil->count * PDI_PORT_WORK);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < s->t->ports->count; p++) s->port(s, p);
}

PDI_FN void pdi_flux_apply(const pd_ctx *ctx, const pd_flux *convect, const double *c, double *y)
{
    pdi_flux_sweep s;
    s.t = convect;
    s.c = c;
    s.y = y;
    s.block = pdi_flux_apply_nodes;
    s.port = pdi_flux_apply_port;
    pdi_flux_sweep_all(ctx, &s);
}

/* The value of node i that balances it. */
static double pdi_flux_balance(const pd_flux *t, const double *b, const double *c, int32_t i)
{
    const pd_grid *grid = t->bonds->grid;
    double diagonal = t->rate + t->absorb[i] + (t->diffusion->hold ? t->diffusion->hold[i] : 0.0), sum = b[i];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        int32_t j = i + t->bonds->shift[k];
        double flux, bond;
        if (!pdi_flux_open(t, i, k)) continue;
        pdi_flux_one(t, i, k, &flux, &bond);
        if (grid->kind[j] == PD_OUTLET) diagonal += flux;
        else {
            double gain = fmax(0.5 * fabs(flux), bond) - 0.5 * flux;
            diagonal += gain + flux;
            if (grid->kind[j] == PD_IMAGE) j = pdi_grid_image(grid, j, NULL);
            if (grid->kind[j] == PD_FLUID) sum += gain * c[j];
        }
    }
    return diagonal > 0.0 ? sum / diagonal : c[i];
}

PDI_FN void pdi_flux_relax(const pd_flux *t, const double *b, int back, double *c)
{
    int32_t total = t->bonds->grid->total;
    for (int32_t n = 0; n < total; n++) {
        int32_t i = back ? total - 1 - n : n;
        if (t->bonds->grid->kind[i] == PD_FLUID) c[i] = pdi_flux_balance(t, b, c, i);
    }
}

PDI_FN void pdi_flux_anti(const pd_ctx *ctx, const pd_flux *convect, const double *c, double *y)
{
    pdi_flux_sweep s;
    s.t = convect;
    s.c = c;
    s.y = y;
    s.block = pdi_flux_anti_nodes;
    s.port = pdi_flux_anti_port;
    pdi_flux_sweep_all(ctx, &s);
}

PDI_FN void pdi_flux_anti_by(const pd_ctx *ctx, const pd_flux *convect, const double *c, const double *x,
                                const double *keep_by, const double *slope_by, double *y)
{
    pdi_flux_sweep s;
    s.t = convect;
    s.c = c;
    s.x = x;
    s.keep_by = keep_by;
    s.slope_by = slope_by;
    s.y = y;
    s.block = pdi_flux_anti_nodes_by;
    s.port = pdi_flux_anti_port_by;
    pdi_flux_sweep_all(ctx, &s);
}

/* What the bonds through a plane are asked for. */
typedef struct pdi_flux_section {
    const pd_flux *convect;
    const double *c;    /* [mol/m3] */
    const double *anti; /* [mol/m3/s] what the nodes gain by antidiffusion */
} pdi_flux_section;

/* Upwinded flux [mol/m3/s] of bond k of node i. One of both ends is fluid, the flux is told from there. */
static double pdi_flux_section_bond(const void *user, int32_t i, int k)
{
    const pdi_flux_section *section = (const pdi_flux_section *)user;
    const pd_flux *t = section->convect;
    int32_t j = i + t->bonds->shift[k];
    if (t->bonds->grid->kind[i] == PD_FLUID) return pdi_flux_bond_flux(t, section->c, i, k);
    double over = pdi_grid_circumference(t->bonds->grid, j) / pdi_grid_circumference(t->bonds->grid, i);
    return -over * pdi_flux_bond_flux(t, section->c, j, t->bonds->stencil->count - 1 - k);
}

/* What node i gains by the antidiffusive flux of bond k (eq. 5.4), likewise. */
static double pdi_flux_section_anti(const void *user, int32_t i, int k)
{
    const pdi_flux_section *section = (const pdi_flux_section *)user;
    const pd_flux *t = section->convect;
    int32_t j = i + t->bonds->shift[k];
    pdi_flux_sweep s;
    if (t->bonds->grid->kind[i] != PD_FLUID) {
        double over = pdi_grid_circumference(t->bonds->grid, j) / pdi_grid_circumference(t->bonds->grid, i);
        return -over * pdi_flux_section_anti(section, j, t->bonds->stencil->count - 1 - k);
    }
    memset(&s, 0, sizeof s);
    s.t = t;
    s.c = section->c;
    double flux, bond;
    pdi_flux_one(t, i, k, &flux, &bond);
    if (t->bonds->grid->kind[j] == PD_OUTLET) j = i;
    return -pdi_flux_anti_one(&s, i, j, k, flux, bond);
}

/* What passes the plane by antidiffusion is all that the nodes on one side of it gain, since the fluxes between them
 * cancel, unless inlets feed both sides or the axis is periodic: then bond by bond, up to what the limiter still
 * moves. */
static double pdi_flux_section_gain(const pdi_flux_section *section, int axis, int index)
{
    const pd_flux *t = section->convect;
    pdi_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
    int fed[2] = {0, 0};
    if (t->bonds->grid->side[2 * axis] == PD_SIDE_PERIODIC) fed[0] = fed[1] = 1;
    for (int32_t node = 0; node < t->bonds->grid->total; node++) {
        int i[PD_DIM];
        pdi_grid_index(t->bonds->grid, node, i);
        int behind = i[axis] >= index;
        if (t->bonds->grid->kind[node] == PD_INLET) fed[behind] = 1;
        if (t->bonds->grid->kind[node] != PD_FLUID) continue;
        pdi_sum_add(&sum[behind], section->anti[node] * pdi_grid_circumference(t->bonds->grid, node));
    }
    if (!fed[0]) return pdi_sum_total(&sum[0]);
    if (!fed[1]) return -pdi_sum_total(&sum[1]);
    return pdi_bond_section(t->bonds, axis, index, pdi_flux_section_anti, section);
}

PDI_FN double pdi_flux_through(const pd_flux *convect, const double *c, const double *anti, int axis, int index)
{
    pdi_flux_section section;
    section.convect = convect;
    section.c = c;
    section.anti = anti;
    double low = pdi_bond_section(convect->bonds, axis, index, pdi_flux_section_bond, &section);
    double gain = anti ? pdi_flux_section_gain(&section, axis, index) : 0.0;
    return (low - gain) * convect->bonds->stencil->volume;
}

static pd_status pdi_flux_fit_ports(pd_ctx *ctx, pd_flux *convect)
{
    int64_t count = convect->bonds->stencil->count;
    int32_t rows = convect->ports->capacity;
    if (rows == convect->port_capacity) return PD_OK;
    PDI_DELETE(ctx, count * convect->port_capacity, convect->port_flux);
    PDI_DELETE(ctx, count * convect->port_capacity, convect->port_bond);
    convect->port_capacity = 0;
    PDI_TRY(PDI_NEW(ctx, "convect", count * rows, convect->port_flux));
    pd_status status = PDI_NEW(ctx, "convect", count * rows, convect->port_bond);
    if (status == PD_OK) convect->port_capacity = rows;
    else PDI_DELETE(ctx, count * rows, convect->port_flux);
    return status;
}

static pd_status pdi_flux_fit_rows(pd_ctx *ctx, pd_flux *convect)
{
    int64_t count = convect->bonds->stencil->count;
    int32_t rows = (convect->bonds->capacity + PDI_FLUX_PAGE - 1) / PDI_FLUX_PAGE * PDI_FLUX_PAGE;
    if (rows == convect->capacity) return PD_OK;
    PDI_DELETE(ctx, count * convect->capacity, convect->conduct);
    convect->capacity = 0;
    PDI_TRY(PDI_NEW(ctx, "convect", count * rows, convect->conduct));
    convect->capacity = rows;
    return PD_OK;
}

PDI_FN pd_status pdi_flux_fit(pd_ctx *ctx, pd_flux *convect)
{
    PDI_TRY(pdi_flux_fit_rows(ctx, convect));
    return pdi_flux_fit_ports(ctx, convect);
}

PDI_FN pd_status pdi_flux_build(pd_ctx *ctx, pd_flux *convect)
{
    const pd_bonds *bonds = convect->bonds;
    pdi_flux_lean(convect);
    if (convect->flow) PDI_TRY(PDI_NEW(ctx, "convect", (PD_DIM + 1) * (int64_t)bonds->grid->total, convect->drive));
    if (convect->flow && PD_DIM < 3)
        PDI_TRY(PDI_NEW(ctx, "convect", bonds->stencil->count / 2 * (int64_t)bonds->grid->total, convect->flux));
    return pdi_flux_fit(ctx, convect);
}

PDI_FN void pdi_flux_free(pd_ctx *ctx, pd_flux *convect)
{
    const pd_bonds *bonds = convect->bonds;
    if (!bonds) return;
    PDI_DELETE(ctx, (PD_DIM + 1) * (int64_t)bonds->grid->total, convect->drive);
    PDI_DELETE(ctx, bonds->stencil->count / 2 * (int64_t)bonds->grid->total, convect->flux);
    PDI_DELETE(ctx, (int64_t)bonds->stencil->count * convect->capacity, convect->conduct);
    PDI_DELETE(ctx, (int64_t)bonds->stencil->count * convect->port_capacity, convect->port_flux);
    PDI_DELETE(ctx, (int64_t)bonds->stencil->count * convect->port_capacity, convect->port_bond);
    convect->capacity = convect->port_capacity = 0;
}
