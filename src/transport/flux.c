/* flux: see flux.h
 *
 * Design: the volume fluxes of the bonds hold during a step. In 1D and 2D they are stored, once for both ends: bond k
 * of node i is bond count-1-k of its far end. In 3D they would be a third of the memory of a run, and are computed by
 * each sweep, with the same bits from both ends. Sweeps go bond by bond over blocks of nodes along axis 0. Closed bonds
 * carry and conduct zero.
 */
#include "transport/flux.h"
#include "transport/rest.h"
#include "core/vec.h"
#include "core/par.h"
#include "lattice/node_loop.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* For fluid at rest. */
static const double pdi_flux_still[PDI_BLOCK] = {0.0};

/* Where F of bond k of the nodes from i stands, and the factor that it is to be taken with. */
static inline double *pdi_flux_slot(const pd_flux *t, int32_t i, int k, double *factor)
{
    const pd_grid *grid = t->bonds->grid;
    int count = t->bonds->stencil->count;
    int32_t j = i + t->bonds->paths.shift[k];
    *factor = 1.0;
    if (k < count / 2) return t->flux + (int64_t)k * grid->total + i;
    *factor = -1.0;
    if (grid->circumference) *factor = -pd_grid_circumference(grid, j) / pd_grid_circumference(grid, i);
    return t->flux + (int64_t)(count - 1 - k) * grid->total + j;
}

/* Conductance of a bond with upwinding: no less than |F|/2 = |half| (eq. 6.1). */
static inline double pdi_flux_upwind(double half, double least)
{
    double size = fabs(half);
    return size > least ? size : least;
}

/* What leaves through a bond of half the volume flux F: F (c_i + c_j)/2 - (D a + d) (c_j - c_i) (eq. 6.1). */
static inline double pdi_flux_leave(double half, double least, double near, double far)
{
    return half * (near + far) - pdi_flux_upwind(half, least) * (far - near);
}

PDI_FN void pdi_flux_bond(const pd_flux *t, int32_t i, int k, double *flux, double *bond, double *upwind)
{
    pdi_diffusion_bond(t->diffusion, i, k, 1, t->bonds->row_of_node[i] >= 0, bond);
    *bond = pdi_conductance_beside(t->bonds, i, k, *bond);
    *flux = t->flow ? pdi_flow_compute_bond_flux(t->flow, i, k) : 0.0;
    *upwind = pdi_flux_upwind(0.5 * *flux, *bond) - *bond;
}

PDI_FN double pdi_flux_bond_flux(const pd_flux *t, const double *c, int32_t i, int k)
{
    double flux, bond, upwind;
    int32_t j = i + t->bonds->paths.shift[k];
    pdi_flux_bond(t, i, k, &flux, &bond, &upwind);
    return pdi_flux_leave(0.5 * flux, bond, c[i], t->bonds->grid->kind[j] == PD_OUTLET ? c[i] : c[j]);
}

PDI_FN int pdi_flux_open(const pd_flux *t, int32_t i, int k)
{
    int32_t r = t->bonds->row_of_node[i];
    return r < 0 || pdi_bond_is_open(t->bonds, r, k);
}

/* ---- what holds during a step ---- */

/* Where a(n) xi = c g(n) for all bonds, with one c for each axis, what the gradient of the pressure gives a bond is a
 * part of its velocity. So on lattices of equal spacings. */
static void pdi_flux_ratio(pd_flux *t)
{
    const pd_stencil *s = t->bonds->stencil;
    double *c = t->ratio;
    t->even = 1;
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double g = s->gradient_weight[k * PD_DIM + d], drop = s->laplacian_weight[k] * s->xi[k * PD_DIM + d];
            if (fabs(g) > 0.0 && !(fabs(c[d]) > 0.0)) c[d] = drop / g;
            if (fabs(drop - c[d] * g) > 1e-12 * s->laplacian_weight[k] * pdi_vec_norm(s->xi + k * PD_DIM)) t->even = 0;
        }
    for (int d = 0; d < PD_DIM && !t->even; d++) c[d] = 0.0;
}

/* F of a bond is g.(w_i + w_j) - a (q_j - q_i), less what the pressure gradients leave in uneven lattices: w and q hold
 * advecting, pressure, its gradient and the potential of the flow (eq. 3.7, 3.34). */
static void pdi_flux_stream_share(const pd_flux *t)
{
    const pd_flow *f = t->flow;
    int64_t total = f->grid->total;
    double *q = t->stream + PD_DIM * total, weight = f->pressure_impulse ? 1.0 : f->stabilisation;
    const double *p = f->pressure_impulse ? f->pressure_impulse : f->p,
                 *grad = f->pressure_impulse ? f->pressure_impulse_grad : f->pressure_grad;
    PDI_FOR_NOWAIT
    for (int64_t i = 0; i < total; i++) {
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = d * total + i;
            t->stream[at] = f->advecting[at] + 0.5 * weight * t->ratio[d] * grad[at];
        }
        q[i] = weight * p[i] + (f->divergence_potential ? f->divergence_potential[i] : 0.0);
    }
}

static void pdi_flux_stream(const pd_ctx *ctx, const pd_flux *t)
{
    int nt = pd_par_threads(ctx, (int64_t)t->flow->grid->total * PD_DIM);
    PDI_PARALLEL_CALL(nt, pdi_flux_stream_share(t));
}

/* What uneven lattices add to the fluxes of bond k of `count` nodes from i. */
static void pdi_flux_uneven(const pd_flux *t, int32_t i, int k, int count, double *flux)
{
    const pd_flow *f = t->flow;
    const pd_stencil *s = f->bonds->stencil;
    const double *grad = (f->pressure_impulse ? f->pressure_impulse_grad : f->pressure_grad) + i,
                 *far = grad + f->bonds->paths.shift[k];
    double part = 0.5 * (f->pressure_impulse ? 1.0 : f->stabilisation) * pdi_bond_get_laplacian_weights(f->bonds, i)[k];
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * f->grid->total;
        for (int b = 0; b < count; b++) flux[b] += part * s->xi[k * PD_DIM + d] * (grad[at + b] + far[at + b]);
    }
}

/* Volume fluxes of bond k of `count` nodes from i (as pdi_flow_compute_bond_flux), tied by the pressure. */
static void pdi_flux_volume(const pd_flux *t, int32_t i, int k, int count, double *flux)
{
    const pd_bonds *bonds = t->bonds;
    int64_t total = bonds->grid->total, shift = bonds->paths.shift[k];
    const double *w = t->stream + i, *q = w + PD_DIM * total, *g = bonds->stencil->gradient_weight + k * PD_DIM;
    double a = pdi_bond_get_laplacian_weights(bonds, i)[k], share = pdi_bond_get_flux_factor(bonds, i, k);
    for (int b = 0; b < count; b++) {
        double sum = pdi_flow_dot(g, w + b, total) + pdi_flow_dot(g, w + b + shift, total);
        flux[b] = share * sum - a * (q[b + shift] - q[b]);
    }
    if (!t->even) pdi_flux_uneven(t, i, k, count, flux);
}

/* Volume fluxes of bond k and of the opposite one, in planar boxes. */
PDI_INLINE void pdi_flux_volumes(const pd_flux *t, int32_t i, int k, int count, double *PD_RESTRICT ahead,
                                 double *PD_RESTRICT behind)
{
    const pd_stencil *s = t->bonds->stencil;
    int64_t total = t->bonds->grid->total, shift = t->bonds->paths.shift[k];
    const double *w = t->stream + i, *q = w + PD_DIM * total, *g = s->gradient_weight + k * PD_DIM;
    double a = s->laplacian_weight[k];
    for (int b = 0; b < count; b++) {
        double here = pdi_flow_dot(g, w + b, total);
        ahead[b] = here + pdi_flow_dot(g, w + b + shift, total) - a * (q[b + shift] - q[b]);
        behind[b] = -(here + pdi_flow_dot(g, w + b - shift, total)) - a * (q[b - shift] - q[b]);
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
    int32_t shift = bonds->paths.shift[k];
    int own = k < bonds->stencil->count / 2;
    uint8_t ghosts = 0;
    double flux[PDI_CHUNK], open[PDI_CHUNK], factor, *slot = pdi_flux_slot(t, i, k, &factor);
    pdi_bond_mask_block gate = {NULL, 0, 0, 0};
    if (own && row < 0 && !t->boundary->count) {
        pdi_flux_volume(t, i, k, count, slot);
        return;
    }
    for (int b = 0; b < count && !own; b++) ghosts |= bonds->grid->kind[i + b + shift] ^ PD_FLUID;
    if (!own && !ghosts) return;
    pdi_bond_openness which = pdi_bond_find_nodes_open(bonds, row, k, count, &gate, open);
    pdi_flux_volume(t, i, k, count, flux);
    for (int b = 0; b < count; b++) {
        uint8_t kind = bonds->grid->kind[i + b + shift];
        int shut = which == PDI_BOND_OPEN_NONE || (which == PDI_BOND_OPEN_SOME && !(open[b] > 0.0));
        if (!own && kind == PD_FLUID) continue;
        if (kind == PD_INLET) flux[b] = pdi_flow_compute_bond_flux(t->flow, i + b, k);
        slot[b] = shut ? 0.0 : flux[b] / factor;
    }
}

static void pdi_flux_store_run(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pd_flux *t = (const pd_flux *)user;
    for (int k = 0; k < t->bonds->stencil->count; k++) pdi_flux_store(t, i, row, k, count);
}

/* F and the conductance of bond k of node i, as sweeps see them. */
PDI_FN void pdi_flux_one(const pd_flux *t, int32_t i, int k, double *flux, double *bond)
{
    int32_t row = t->bonds->row_of_node[i];
    *flux = 0.0;
    if (t->flux) {
        double factor;
        const double *slot = pdi_flux_slot(t, i, k, &factor);
        *flux = factor * *slot;
    } else if (t->flow && pdi_flux_open(t, i, k)) {
        int inlet = t->bonds->grid->kind[i + t->bonds->paths.shift[k]] == PD_INLET;
        if (inlet) *flux = pdi_flow_compute_bond_flux(t->flow, i, k);
        else pdi_flux_volume(t, i, k, 1, flux);
    }
    if (row >= 0) *bond = pdi_conductance_value(&t->conductance, row, k);
    else {
        pdi_diffusion_bond(t->diffusion, i, k, 1, 0, bond);
        if (t->bonds->grid->mixed_sides) *bond = pdi_conductance_beside(t->bonds, i, k, *bond);
    }
}

PDI_FN pd_status pdi_flux_refresh(pd_ctx *ctx, pd_flux *t)
{
    const pd_bonds *bonds = t->bonds;
    if (t->diffusion->version != bonds->version)
        return pd_fail(ctx, PD_ERR_STATE, "flux", "the conductances are those of other bonds, expected a call of "
                       "pd_transport_update after pd_bonds_update");
    if (!t->flow && t->conductance.version == bonds->version) return PD_OK; /* nothing has changed */
    pdi_conductance_update(ctx, &t->conductance);
    if (t->flow) pdi_flux_stream(ctx, t);
    if (t->flux)
        pdi_node_loop_by_ranges(ctx, bonds, bonds->grid->fluid_count * bonds->stencil->count * 4, PDI_CHUNK,
                                pdi_flux_store_run, t);
    for (int32_t p = 0; p < t->boundary->count; p++)
        for (int k = 0; k < bonds->stencil->count; k++) {
            int64_t slot = (int64_t)p * bonds->stencil->count + k;
            pdi_flux_one(t, t->boundary->node[p], k, t->boundary_flux + slot, t->boundary_bond + slot);
        }
    return PD_OK;
}

/* ---- sweeps ---- */

/* What a sweep works on: y = A c, the limited antidiffusive fluxes y, or their derivative. */
typedef struct pdi_flux_sweep {
    const pd_flux *t;
    const double *c;
    const double *x, *factor_by, *slope_by; /* direction of a derivative, and those of the limiter along it */
    double room; /* [-] for what upwinding adds, of rates */
    double *y;
} pdi_flux_sweep;

/* Bond k of a block and its opposite one, to the far ends ahead and behind. */
typedef struct pdi_flux_pair {
    int32_t next, before;         /* far ends ahead and behind, from the node */
    const double *flux, *back;    /* F [1/s] of the bond ahead, and of that which comes from behind or leaves there */
    double turn;                  /* what `back` is to be multiplied with to leave: -1 as stored in planes */
    const double *ahead, *behind; /* conductances [1/s] */
    double bend[2];               /* [-] 1: the flux has a bend, 0: it has none, ahead and behind */
    double space[2][PDI_BLOCK];   /* for those of whole families, and across pages */
    double volume[2][PDI_BLOCK];  /* for fluxes that are not stored */
} pdi_flux_pair;

/* Close the bonds k of the rows from `row` that are. */
static inline void pdi_flux_shut(const pd_flux *t, int32_t row, int k, int count, double *PD_RESTRICT flux)
{
    pdi_bond_mask_block gate;
    gate.words = pdi_bond_get_mask_words(t->bonds, row, k);
    for (int b = 0; b < count; b++) flux[b] *= pdi_bond_get_open_factor(&gate, k, b);
}

/* Whether the flux of a bond to `far` has a bend, beside inlets and outlets: inlets have no gradient, and their
 * concentration is that of the side of the box. */
static double pdi_flux_bends(const pd_flux *t, int32_t far)
{
    return t->bonds->grid->kind[far] == PD_INLET ? 0.0 : 1.0;
}

/* place: of a single node beside inlets and outlets in their list, -1: none of the block is one of them. */
PDI_INLINE_HOT void pdi_flux_pair_get(const pd_flux *t, int32_t i, int32_t row, int32_t place, int k, int count,
                                      pdi_flux_pair *p)
{
    int bonds = t->bonds->stencil->count, opposite = bonds - 1 - k;
    if (place >= 0) {
        int64_t first = (int64_t)place * bonds;
        const int32_t *far = t->boundary->far_end + first;
        p->flux = t->boundary_flux + first + k;
        p->back = t->boundary_flux + first + opposite;
        p->turn = 1.0;
        p->ahead = t->boundary_bond + first + k;
        p->behind = t->boundary_bond + first + opposite;
        p->next = far[k] - i;
        p->before = far[opposite] - i;
        p->bend[0] = pdi_flux_bends(t, far[k]);
        p->bend[1] = pdi_flux_bends(t, far[opposite]);
        return;
    }
    p->next = t->bonds->paths.shift[k];
    p->before = -p->next;
    p->bend[0] = p->bend[1] = 1.0;
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
    p->ahead = pdi_conductance_of(&t->conductance, i, row, k, count, p->space[0]);
    p->behind = pdi_conductance_of(&t->conductance, i, row, opposite, count, p->space[1]);
}

PDI_FN int32_t pdi_flux_bonds(const pd_flux *t, int32_t i, int32_t row, int32_t place, int k, int count, double *flux,
                              double *bond)
{
    pdi_flux_pair p;
    int last = t->bonds->stencil->count - 1, ahead = k < last - k;
    pdi_flux_pair_get(t, i, row, place, ahead ? k : last - k, count, &p);
    for (int b = 0; b < count; b++) {
        flux[b] = ahead ? p.flux[b] : p.turn * p.back[b];
        bond[b] = ahead ? p.ahead[b] : p.behind[b];
    }
    return ahead ? p.next : p.before;
}

/* Compiled for whole blocks, for shorter ones and for single nodes beside inlets and outlets. */
PDI_INLINE_HOT void pdi_flux_apply_block(const pdi_flux_sweep *s, int32_t i, int32_t row, int32_t place, int count)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT c = s->c + i, *PD_RESTRICT absorb = t->absorb + i, *hold = t->diffusion->wall_rate;
    double sum[PDI_BLOCK], rate = t->rate, *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = (rate + absorb[b]) * c[b];
    for (int b = 0; b < count && hold; b++) sum[b] += hold[i + b] * c[b];
    for (int k = 0; k < t->bonds->stencil->count / 2; k++) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, place, k, count, &p);
        const double *next = c + p.next, *before = c + p.before, *flux = p.flux, *back = p.back;
        const double *ahead = p.ahead, *behind = p.behind;
        double part = 0.5 * p.turn;
        for (int b = 0; b < count; b++)
            sum[b] += pdi_flux_leave(0.5 * flux[b], ahead[b], c[b], next[b]) +
                      pdi_flux_leave(part * back[b], behind[b], c[b], before[b]);
    }
    for (int b = 0; b < count; b++) y[b] = sum[b];
}

static void pdi_flux_apply_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_flux_sweep *s = (const pdi_flux_sweep *)user;
    if (PDI_SINGLE_NODE(place)) pdi_flux_apply_block(s, i, row, place, 1);
    else if (PDI_FULL_BLOCK(count)) pdi_flux_apply_block(s, i, row, -1, PDI_BLOCK);
    else pdi_flux_apply_block(s, i, row, place, count);
}

/* The same for several fields: a bond is asked once. */
typedef struct pdi_flux_fields_sweep {
    const pd_flux *t;
    const pdi_flux_fields *f;
} pdi_flux_fields_sweep;

/* What bonds conduct to far ends that are `far` away, by the harmonic mean of what their ends let pass. */
static inline void pdi_flux_share(const double *pass, int32_t far, const double *bond, int count, double *share)
{
    for (int b = 0; b < count; b++) share[b] = bond[b] * pdi_bond_diffusivity_harmonic_mean(pass[b], pass[b + far]);
}

PDI_INLINE_HOT void pdi_flux_fields_block(const pdi_flux_fields_sweep *s, int32_t i, int32_t row, int32_t place,
                                          int count)
{
    const pd_flux *t = s->t;
    const pdi_flux_fields *f = s->f;
    const double *hold = t->diffusion->wall_rate;
    int64_t total = t->bonds->grid->total;
    double sum[PDI_FLUX_FIELDS][PDI_BLOCK];
    for (int n = 0; n < f->count; n++) {
        const double *c = f->c + n * total + i;
        int open = hold && f->wall[n] == f->wall[n];
        for (int b = 0; b < count; b++) sum[n][b] = open ? f->ratio[n] * hold[i + b] * (c[b] - f->wall[n]) : 0.0;
        for (int b = 0; b < count && open && f->pass; b++) sum[n][b] *= f->pass[i + b];
    }
    for (int k = 0; k < t->bonds->stencil->count / 2; k++) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, place, k, count, &p);
        const double *flux = p.flux, *back = p.back, *ahead = p.ahead, *behind = p.behind;
        double part = 0.5 * p.turn, share[2][PDI_BLOCK];
        if (f->pass) {
            pdi_flux_share(f->pass + i, p.next, ahead, count, share[0]);
            pdi_flux_share(f->pass + i, p.before, behind, count, share[1]);
            ahead = share[0];
            behind = share[1];
        }
        for (int n = 0; n < f->count; n++) {
            const double *c = f->c + n * total + i, *next = c + p.next, *before = c + p.before;
            double ratio = f->ratio[n], *PD_RESTRICT to = sum[n];
            for (int b = 0; b < count; b++)
                to[b] += pdi_flux_leave(0.5 * flux[b], ratio * ahead[b], c[b], next[b]) +
                         pdi_flux_leave(part * back[b], ratio * behind[b], c[b], before[b]);
        }
    }
    for (int m = 0; m < f->sums; m++) {
        double *PD_RESTRICT y = f->y + m * total + i;
        const double *weight = f->weight + (int64_t)m * f->count;
        for (int b = 0; b < count; b++) y[b] = 0.0;
        for (int n = 0; n < f->count; n++)
            for (int b = 0; b < count && weight[n] != 0.0; b++) y[b] += weight[n] * sum[n][b];
    }
}

static void pdi_flux_fields_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_flux_fields_sweep *s = (const pdi_flux_fields_sweep *)user;
    if (PDI_SINGLE_NODE(place)) pdi_flux_fields_block(s, i, row, place, 1);
    else if (PDI_FULL_BLOCK(count)) pdi_flux_fields_block(s, i, row, -1, PDI_BLOCK);
    else pdi_flux_fields_block(s, i, row, place, count);
}

/* What a bond adds to the rate of a node: no less than half of what leaves, and `room` times what upwinding adds. */
static inline double pdi_flux_rate(double flux, double least, double room)
{
    return least + room * (pdi_flux_upwind(0.5 * flux, least) - least) - 0.5 * flux;
}

/* Outlets take what leaves and give nothing. Bonds that are closed stand for themselves, too, and carry zero. */
static inline double pdi_flux_rate_of(double flux, double least, double room, int itself)
{
    return itself ? (flux > 0.0 ? flux : 0.0) : pdi_flux_rate(flux, least, room);
}

PDI_INLINE_HOT void pdi_flux_rates_block(const pdi_flux_sweep *s, int32_t i, int32_t row, int32_t place, int count)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT absorb = t->absorb + i, *hold = t->diffusion->wall_rate;
    double sum[PDI_BLOCK], room = s->room, *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = absorb[b] + (hold ? hold[i + b] : 0.0);
    for (int k = 0; k < t->bonds->stencil->count / 2; k++) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, place, k, count, &p);
        const double *flux = p.flux, *back = p.back, *ahead = p.ahead, *behind = p.behind;
        double turn = p.turn;
        int last = place >= 0 && !p.next, first = place >= 0 && !p.before;
        for (int b = 0; b < count; b++)
            sum[b] += pdi_flux_rate_of(flux[b], ahead[b], room, last) +
                      pdi_flux_rate_of(turn * back[b], behind[b], room, first);
    }
    for (int b = 0; b < count; b++) y[b] = sum[b];
}

/* Fluid at rest with one diffusivity. */
static void pdi_flux_rates_rest(const pdi_flux_sweep *s, int32_t i, int32_t row, int count)
{
    const pd_flux *t = s->t;
    const pd_stencil *stencil = t->bonds->stencil;
    const double *hold = t->diffusion->wall_rate;
    for (int b = 0; b < count; b++) {
        double sum = t->diffusion->desc.diffusivity * stencil->lap_sum;
        for (int k = 0; k < stencil->count && row >= 0; k++)
            sum = (k ? sum : 0.0) + pdi_conductance_value(&t->conductance, row + b, k);
        s->y[i + b] = t->absorb[i + b] + (hold ? hold[i + b] : 0.0) + sum;
    }
}

static void pdi_flux_rates_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_flux_sweep *s = (const pdi_flux_sweep *)user;
    if (s->t->conductance.rests) pdi_flux_rates_rest(s, i, row, count);
    else if (PDI_SINGLE_NODE(place)) pdi_flux_rates_block(s, i, row, place, 1);
    else if (PDI_FULL_BLOCK(count)) pdi_flux_rates_block(s, i, row, -1, PDI_BLOCK);
    else pdi_flux_rates_block(s, i, row, place, count);
}

/* What two bonds, one opposite to the other, are made of for node b of a block: the field or a direction, with the
 * limiter or its derivative. f and g: F of both, which leaves. */
PDI_INLINE void pdi_flux_upwinds(const pdi_flux_pair *p, const double *xi, const double *c, const double *factor,
                                 const double *slope, int64_t total, int b, double f, double g,
                                 pdi_bend_terms *ahead, pdi_bend_terms *behind)
{
    double x = 0.0, next = 0.0, before = 0.0, alpha = factor[b];
    for (int d = 0; d < PD_DIM; d++) {
        x += xi[d] * slope[d * total + b];
        next += xi[d] * slope[d * total + b + p->next];
        before += xi[d] * slope[d * total + b + p->before];
    }
    double alpha_next = factor[b + p->next], alpha_before = factor[b + p->before];
    ahead->step = c[b + p->next] - c[b];
    ahead->bend = pdi_bend_of(ahead->step, f > 0.0 ? x : next, f > 0.0 ? next : x);
    ahead->alpha = f > 0.0 ? alpha : alpha_next;
    behind->step = c[b + p->before] - c[b];
    behind->bend = -pdi_bend_of(-behind->step, g > 0.0 ? x : before, g > 0.0 ? before : x);
    behind->alpha = g > 0.0 ? alpha : alpha_before;
}

/* What an antidiffusive block is asked for: its fluxes, their derivative along a direction, the same with the partial
 * derivatives that are kept, or to keep them. */
enum { PDI_FLUX_VALUES, PDI_FLUX_ALONG, PDI_FLUX_KEPT, PDI_FLUX_KEEP };

/* Compiled for each of them, too. */
PDI_INLINE_HOT void pdi_flux_anti_block(const pdi_flux_sweep *s, int32_t i, int32_t row, int32_t place, int count,
                                        int what)
{
    const pd_flux *t = s->t;
    const double *PD_RESTRICT c = s->c + i, *PD_RESTRICT factor = t->limiter->factor + i;
    const double *PD_RESTRICT slope = t->limiter->slope + i, *xi = t->bonds->stencil->xi;
    int along = what == PDI_FLUX_ALONG || what == PDI_FLUX_KEPT, whole = what != PDI_FLUX_KEPT;
    const double *PD_RESTRICT z = along ? s->x + i : c, *PD_RESTRICT factor_by = along ? s->factor_by + i : factor;
    const double *PD_RESTRICT slope_by = along ? s->slope_by + i : slope;
    int64_t total = t->bonds->grid->total;
    double sum[PDI_BLOCK], *PD_RESTRICT y = s->y + i;
    for (int b = 0; b < count; b++) sum[b] = 0.0;
    for (int k = 0; k < t->bonds->stencil->count / 2; k++, xi += PD_DIM) {
        pdi_flux_pair p;
        pdi_flux_pair_get(t, i, row, place, k, count, &p);
        const double *flux = p.flux, *back = p.back, *ahead = p.ahead, *behind = p.behind;
        const float *kept = whole ? NULL : pdi_bend_kept(&t->bend, i, k), *kept_back = whole ? NULL : kept + p.before;
        double turn = p.turn, bend = p.bend[0], bend_back = p.bend[1];
        for (int b = 0; b < count; b++) {
            double f = flux[b], g = turn * back[b], value = 0.0, other = 0.0;
            pdi_bend_terms next, before, by, by_back;
            if (whole) {
                pdi_flux_upwinds(&p, xi, c, factor, slope, total, b, f, g, &next, &before);
                value = pdi_bend_flux(f, ahead[b], bend, &next, &by);
                other = pdi_bend_flux(g, behind[b], bend_back, &before, &by_back);
            } else {
                by = pdi_bend_recall(&t->bend, kept, b, 1.0);
                by_back = pdi_bend_recall(&t->bend, kept_back, b, turn);
            }
            if (along) {
                pdi_flux_upwinds(&p, xi, z, factor_by, slope_by, total, b, f, g, &next, &before);
                value = pdi_bend_along(&by, &next);
                other = pdi_bend_along(&by_back, &before);
            }
            if (what == PDI_FLUX_KEEP) {
                pdi_bend_keep(&t->bend, i + b, k, 1.0, &by);
                if (place < 0 && t->bonds->grid->kind[i + b + p.before] != PD_FLUID)
                    pdi_bend_keep(&t->bend, i + b + p.before, k, 1.0 / turn, &by_back);
            }
            sum[b] -= value;
            sum[b] -= other;
        }
    }
    for (int b = 0; b < count && what != PDI_FLUX_KEEP; b++) y[b] = sum[b];
}

static void pdi_flux_anti_nodes_by(const void *user, int32_t i, int32_t row, int32_t place, int count);

/* Nodes beside inlets and outlets see other far ends, and keep nothing for themselves. */
PDI_INLINE void pdi_flux_anti_nodes_of(const void *user, int32_t i, int32_t row, int32_t place, int count, int what)
{
    const pdi_flux_sweep *s = (const pdi_flux_sweep *)user;
    if (place >= 0 && what == PDI_FLUX_KEPT) pdi_flux_anti_nodes_by(user, i, row, place, 1);
    else if (PDI_SINGLE_NODE(place)) pdi_flux_anti_block(s, i, row, place, 1, what);
    else if (PDI_FULL_BLOCK(count)) pdi_flux_anti_block(s, i, row, -1, PDI_BLOCK, what);
    else pdi_flux_anti_block(s, i, row, place, count, what);
}

static void pdi_flux_anti_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    pdi_flux_anti_nodes_of(user, i, row, place, count, PDI_FLUX_VALUES);
}

static void pdi_flux_anti_nodes_by(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    pdi_flux_anti_nodes_of(user, i, row, place, count, PDI_FLUX_ALONG);
}

static void pdi_flux_anti_nodes_kept(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    pdi_flux_anti_nodes_of(user, i, row, place, count, PDI_FLUX_KEPT);
}

static void pdi_flux_anti_nodes_keep(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    pdi_flux_anti_nodes_of(user, i, row, place, count, PDI_FLUX_KEEP);
}

static void pdi_flux_sweep_all(const pd_ctx *ctx, const pdi_flux_sweep *s, pdi_node_loop_block_fn block)
{
    const pd_bonds *bonds = s->t->bonds;
    pdi_node_loop_by_blocks(ctx, s->t->boundary, bonds->grid->fluid_count * bonds->stencil->count * 2, block, s);
}

PDI_FN void pdi_flux_apply(const pd_ctx *ctx, const pd_flux *t, const double *c, double *y)
{
    pdi_flux_sweep s;
    s.t = t;
    s.c = c;
    s.y = y;
    if (t->conductance.rests) {
        pdi_rest rest;
        rest.conductance = &t->conductance;
        rest.rate = t->rate;
        rest.absorb = t->absorb;
        rest.hold = t->diffusion->wall_rate;
        rest.plain = t->plain ? t->plain : c;
        rest.exact = t->exact;
        pdi_rest_apply(ctx, &rest, c, y);
        return;
    }
    pdi_flux_sweep_all(ctx, &s, pdi_flux_apply_nodes);
}

PDI_FN void pdi_flux_apply_fields(const pd_ctx *ctx, const pd_flux *t, const pdi_flux_fields *fields)
{
    pdi_flux_fields_sweep s;
    s.t = t;
    s.f = fields;
    pdi_node_loop_by_blocks(ctx, t->boundary,
                            t->bonds->grid->fluid_count * t->bonds->stencil->count * 2 * fields->count,
                            pdi_flux_fields_nodes, &s);
}

PDI_FN void pdi_flux_rates(const pd_ctx *ctx, const pd_flux *t, double room, double *y)
{
    pdi_flux_sweep s;
    s.t = t;
    s.room = room;
    s.y = y;
    pdi_flux_sweep_all(ctx, &s, pdi_flux_rates_nodes);
}

/* The value of node i that balances it. */
static double pdi_flux_balance(const pd_flux *t, const double *b, const double *c, int32_t i)
{
    const pd_grid *grid = t->bonds->grid;
    double diagonal = t->rate + t->absorb[i] + (t->diffusion->wall_rate ? t->diffusion->wall_rate[i] : 0.0), sum = b[i];
    for (int k = 0; k < t->bonds->stencil->count; k++) {
        int32_t j = i + t->bonds->paths.shift[k];
        double flux, bond;
        if (!pdi_flux_open(t, i, k)) continue;
        pdi_flux_one(t, i, k, &flux, &bond);
        if (grid->kind[j] == PD_OUTLET) diagonal += flux;
        else {
            double gain = pdi_flux_upwind(0.5 * flux, bond) - 0.5 * flux;
            diagonal += gain + flux;
            if (grid->kind[j] == PD_IMAGE) j = pd_grid_find_source(grid, j, NULL);
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

PDI_FN void pdi_flux_anti(const pd_ctx *ctx, const pd_flux *t, const double *c, double *y)
{
    pdi_flux_sweep s;
    s.t = t;
    s.c = c;
    s.y = y;
    pdi_flux_sweep_all(ctx, &s, pdi_flux_anti_nodes);
}

PDI_FN void pdi_flux_anti_by(const pd_ctx *ctx, const pd_flux *t, const double *c, const double *x,
                             const double *factor_by, const double *slope_by, double *y)
{
    pdi_flux_sweep s;
    s.t = t;
    s.c = c;
    s.x = x;
    s.factor_by = factor_by;
    s.slope_by = slope_by;
    s.y = y;
    pdi_flux_sweep_all(ctx, &s, t->bend.kept ? pdi_flux_anti_nodes_kept : pdi_flux_anti_nodes_by);
}

PDI_FN void pdi_flux_differentiate(const pd_ctx *ctx, const pd_flux *t, const double *c)
{
    pdi_flux_sweep s;
    s.t = t;
    s.c = c;
    s.y = NULL;
    if (t->bend.kept) pdi_flux_sweep_all(ctx, &s, pdi_flux_anti_nodes_keep);
}

/* What the bonds through a plane are asked for. */
typedef struct pdi_flux_section {
    const pd_flux *t;
    const double *c;    /* [mol/m3] */
    const double *anti; /* [mol/m3/s] what the nodes gain by antidiffusion */
} pdi_flux_section;

PDI_COLD_BEGIN
/* Upwinded flux [mol/m3/s] of bond k of node i. One of both ends is fluid; the flux is computed from there. */
static double pdi_flux_section_bond(const void *user, int32_t i, int k)
{
    const pdi_flux_section *section = (const pdi_flux_section *)user;
    const pd_flux *t = section->t;
    int32_t j = i + t->bonds->paths.shift[k];
    if (t->bonds->grid->kind[i] == PD_FLUID) return pdi_flux_bond_flux(t, section->c, i, k);
    double over = pd_grid_circumference(t->bonds->grid, j) / pd_grid_circumference(t->bonds->grid, i);
    return -over * pdi_flux_bond_flux(t, section->c, j, t->bonds->stencil->count - 1 - k);
}

/* What node i gains by the antidiffusive flux of bond k (eq. 6.15), computed from the end that is fluid. */
static double pdi_flux_section_anti(const void *user, int32_t i, int k)
{
    const pdi_flux_section *section = (const pdi_flux_section *)user;
    const pd_flux *t = section->t;
    const pd_grid *grid = t->bonds->grid;
    int32_t j = i + t->bonds->paths.shift[k];
    if (grid->kind[i] != PD_FLUID) {
        double over = pd_grid_circumference(grid, j) / pd_grid_circumference(grid, i);
        return -over * pdi_flux_section_anti(section, j, t->bonds->stencil->count - 1 - k);
    }
    pdi_bend_terms of;
    double flux, bond, along[2] = {0.0, 0.0};
    pdi_flux_one(t, i, k, &flux, &bond);
    if (grid->kind[j] == PD_OUTLET) j = i;
    int32_t end[2];
    end[0] = flux > 0.0 ? i : j;
    end[1] = flux > 0.0 ? j : i;
    for (int e = 0; e < 2; e++)
        for (int d = 0; d < PD_DIM; d++)
            along[e] += t->bonds->stencil->xi[k * PD_DIM + d] * t->limiter->slope[(int64_t)d * grid->total + end[e]];
    of.step = section->c[j] - section->c[i];
    of.bend = pdi_bend_of(of.step, along[0], along[1]);
    of.alpha = t->limiter->factor[end[0]];
    return -pdi_bend_flux(flux, bond, pdi_flux_bends(t, j), &of, NULL);
}

/* What passes the plane by antidiffusion is all that the nodes on one side of it gain, since the fluxes between them
 * cancel, unless inlets feed both sides or the axis is periodic: then bond by bond, up to what the limiter still
 * moves. */
static double pdi_flux_section_gain(const pdi_flux_section *section, int axis, int index)
{
    const pd_flux *t = section->t;
    pdi_compensated_sum sum[2] = {{0.0, 0.0}, {0.0, 0.0}};
    int fed[2] = {0, 0};
    if (t->bonds->grid->side[2 * axis] == PD_SIDE_PERIODIC) fed[0] = fed[1] = 1;
    for (int32_t node = 0; node < t->bonds->grid->total; node++) {
        int behind = pdi_grid_index_along(t->bonds->grid, node, axis) >= index;
        if (t->bonds->grid->kind[node] == PD_INLET) fed[behind] = 1;
        if (t->bonds->grid->kind[node] != PD_FLUID) continue;
        pdi_compensated_sum_add(&sum[behind], section->anti[node] * pd_grid_circumference(t->bonds->grid, node));
    }
    if (!fed[0]) return pdi_compensated_sum_total(&sum[0]);
    if (!fed[1]) return -pdi_compensated_sum_total(&sum[1]);
    return pdi_node_loop_sum_plane_flux(t->bonds, axis, index, pdi_flux_section_anti, section);
}

PDI_FN double pdi_flux_through(const pd_flux *t, const double *c, const double *anti, int axis, int index)
{
    pdi_flux_section section;
    section.t = t;
    section.c = c;
    section.anti = anti;
    double low = pdi_node_loop_sum_plane_flux(t->bonds, axis, index, pdi_flux_section_bond, &section);
    double gain = anti ? pdi_flux_section_gain(&section, axis, index) : 0.0;
    return (low - gain) * t->bonds->stencil->volume;
}

PDI_FN void pdi_flux_list(pdi_array_visitor *owner, void *object)
{
    pd_flux *flux = (pd_flux *)object;
    if (!flux->flow) return;
    int64_t total = flux->bonds->grid->total;
    PDI_ARRAY_UNINIT(owner, flux, stream, (PD_DIM + 1) * total, "1/s");
    if (PD_DIM < 3) PDI_ARRAY_UNINIT(owner, flux, flux, flux->bonds->stencil->count / 2 * total, "1/s");
}

static void pdi_flux_boundary_list(pdi_array_visitor *owner, void *object)
{
    pd_flux *flux = (pd_flux *)object;
    int64_t bonds = flux->bonds ? (int64_t)flux->bonds->stencil->count * flux->boundary_capacity : 0;
    PDI_ARRAY(owner, flux, boundary_flux, bonds, "1/s");
    PDI_ARRAY(owner, flux, boundary_bond, bonds, "1/s");
}

static pd_status pdi_flux_fit_boundary(pd_ctx *ctx, pd_flux *t)
{
    int32_t rows = t->boundary->capacity;
    if (rows == t->boundary_capacity) return PD_OK;
    return pdi_array_registry_rebuild(ctx, pdi_flux_boundary_list, t, &t->boundary_capacity, rows);
}

PDI_FN pd_status pdi_flux_fit(pd_ctx *ctx, pd_flux *t)
{
    PD_TRY(pdi_conductance_fit(ctx, &t->conductance));
    return pdi_flux_fit_boundary(ctx, t);
}

PDI_FN pd_status pdi_flux_build(pd_ctx *ctx, pd_flux *t)
{
    pdi_flux_ratio(t);
    t->bend.bonds = t->conductance.bonds = t->bonds;
    t->conductance.diffusion = t->diffusion;
    return pdi_flux_fit(ctx, t);
}

PDI_FN void pdi_flux_free(pd_ctx *ctx, pd_flux *t)
{
    pdi_array_registry_free(ctx, pdi_conductance_list, &t->conductance);
    pdi_array_registry_free(ctx, pdi_flux_boundary_list, t);
    t->boundary_capacity = 0;
    memset(&t->conductance, 0, sizeof t->conductance);
}
PDI_COLD_END
