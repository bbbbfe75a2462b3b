/* conductance: see conductance.h */
#include "transport/conductance.h"
#include "core/par.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [cells] To which the ends of inlets are found. */
#define PDI_CONDUCTANCE_FINE 1e-9

/* Fraction at which bond k of node i crosses the side of the box behind which its inlet ghost lies: there the inflow
 * has its value, and the ghost has it at any depth. */
static double pdi_conductance_entry(const pd_bonds *bonds, int32_t i, int k)
{
    const pd_grid *grid = bonds->grid;
    double fraction = 1.0;
    int at[PD_DIM];
    if (grid->kind[i + bonds->paths.shift[k]] != PD_INLET) return 1.0;
    pd_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        int step = bonds->stencil->offset[k * PD_DIM + d], upper = step > 0;
        double inside = upper ? grid->n[d] - at[d] - 0.5 : at[d] + 0.5; /* cells to the side */
        if (pd_grid_is_inlet_or_outlet(grid->side[2 * d + upper]))
            fraction = pd_min(fraction, step ? inside / abs(step) : 1.0);
    }
    return fraction;
}

/* ---- the ends of inlets (theory: eq. 6.5, 6.6) ---- */

/* The node behind the side of axis d, the upper one or not, that node i of the box lies next to; -1: no side with ends
 * of inlets is there. */
static int32_t pdi_conductance_behind(const pd_grid *grid, int32_t i, const int *at, int d, int upper)
{
    if (!(grid->mixed_sides >> (2 * d + upper) & 1) || at[d] != (upper ? grid->n[d] - 1 : 0)) return -1;
    return upper ? i + grid->stride[d] : i - grid->stride[d];
}

/* Weight of the bonds of node i by one step along axis d, and by `step` along axis e. */
static double pdi_conductance_weight(const pd_bonds *bonds, int32_t i, int d, int upper, int e, int step)
{
    const double *lap = pdi_bond_get_laplacian_weights(bonds, i);
    double sum = 0.0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        const int *offset = bonds->stencil->offset + k * PD_DIM;
        if (offset[d] == (upper ? 1 : -1) && offset[e] == step) sum += lap[k];
    }
    return sum;
}

/* What those that lead from node i, beside an inlet, to an outlet would conduct. */
static double pdi_conductance_missing(const pd_bonds *bonds, int32_t i, int d, int upper)
{
    const double *lap = pdi_bond_get_laplacian_weights(bonds, i);
    double sum = 0.0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int outwards = bonds->stencil->offset[k * PD_DIM + d] == (upper ? 1 : -1);
        if (outwards && bonds->grid->kind[i + bonds->paths.shift[k]] == PD_OUTLET) sum += lap[k];
    }
    return sum;
}

/* How far behind the face between node i, beside an inlet, and the next one along axis e, beside an outlet, the inlet
 * ends, in cells, at the side of axis d. */
static double pdi_conductance_past(const pd_grid *grid, int32_t i, int d, int upper, int e, int step)
{
    double foot[PD_DIM], from = 0.0, to = 1.0;
    pd_grid_position(grid, i, foot);
    foot[d] = upper ? grid->hi[d] : grid->lo[d];
    while (to - from > PDI_CONDUCTANCE_FINE) {
        double middle = 0.5 * (from + to), x[PD_DIM];
        memcpy(x, foot, sizeof x);
        x[e] += step * middle * grid->h[e];
        pdi_grid_fold_position_images(grid, x);
        if (grid->is_inlet(grid->is_inlet_user, 2 * d + upper, x)) from = middle;
        else to = middle;
    }
    return 0.5 * (from + to) - 0.5;
}

/* What the first cell behind the end of an inlet, or the last one before it, conducts to the inlet over 2 D/h^2 (eq.
 * 6.5). h: across the side, along: towards the end, which lies `past` cells behind the face between both. */
static double pdi_conductance_reach(double h, double along, double past, int last)
{
    double r = sqrt(1.0 + h * h / (along * along)), root = sqrt((r - 1.0) / (r + 1.0));
    double beyond = 1.0 - past - 0.25 * r;
    if (last) return beyond < 1.0 ? 1.0 : root * (2.0 - beyond) / (root + (beyond - 1.0) * (1.0 - root));
    return beyond < 1.0 ? root * (1.0 - beyond) / (root + beyond * (1.0 - root)) : 0.0;
}

/* A bond of node i across the side of axis d to an inlet, over its weight: `behind` is the node straight behind it. */
static double pdi_conductance_across(const pd_bonds *bonds, int32_t i, int k, int d, int upper, int32_t behind)
{
    const pd_grid *grid = bonds->grid;
    const int *offset = bonds->stencil->offset + k * PD_DIM;
    int outlet = grid->kind[behind] == PD_OUTLET;
    double share = 1.0, h = grid->h[d];
    for (int e = 0; e < PD_DIM; e++)
        for (int step = -1; step < 2 && e != d; step += 2) {
            int32_t next = step * grid->stride[e];
            uint8_t wanted = outlet ? PD_INLET : PD_OUTLET;
            if (grid->kind[behind + next] != wanted || (outlet && offset[e] != step)) continue;
            double past = outlet ? pdi_conductance_past(grid, i + next, d, upper, e, -step)
                                 : pdi_conductance_past(grid, i, d, upper, e, step);
            double reach = pdi_conductance_reach(h, grid->h[e], past, !outlet);
            if (outlet) return reach / (h * h * pdi_conductance_weight(bonds, i, d, upper, e, step));
            share *= reach;
        }
    if (i + bonds->paths.shift[k] == behind)
        return share *
               (1.0 + pdi_conductance_missing(bonds, i, d, upper) / pdi_bond_get_laplacian_weights(bonds, i)[k]);
    return share;
}

/* A bond of node i along the side of axis d over its weight, more than 1: by what bonds to an outlet do not conduct
 * along it. */
static double pdi_conductance_along(const pd_bonds *bonds, int32_t i, int k, int d, int upper, int32_t behind)
{
    const pd_grid *grid = bonds->grid;
    const pd_stencil *s = bonds->stencil;
    const int *offset = s->offset + k * PD_DIM;
    uint8_t near = grid->kind[behind], far = grid->kind[behind + bonds->paths.shift[k]];
    int ports = (near == PD_OUTLET || near == PD_INLET) && (far == PD_OUTLET || far == PD_INLET);
    if (!ports || (near == PD_INLET && far == PD_INLET)) return 0.0;
    for (int other = 0; other < s->count; other++) {
        int same = s->offset[other * PD_DIM + d] == (upper ? 1 : -1);
        for (int e = 0; e < PD_DIM; e++) same = same && (e == d || s->offset[other * PD_DIM + e] == offset[e]);
        if (same) return pdi_bond_get_laplacian_weights(bonds, i)[other] / pdi_bond_get_laplacian_weights(bonds, i)[k];
    }
    return 0.0;
}

/* Beside sides that are inlet at some places and outlet at others, with the nearest neighbours: what bond k of node i
 * conducts over what it would. */
static double pdi_conductance_end(const pd_bonds *bonds, int32_t i, int k)
{
    const pd_grid *grid = bonds->grid;
    double factor = 1.0;
    int at[PD_DIM];
    if (bonds->stencil->reach > 1) return 1.0;
    pd_grid_index(grid, i, at);
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int d = side / 2, step = bonds->stencil->offset[k * PD_DIM + d];
        int32_t behind = pdi_conductance_behind(grid, i, at, d, side % 2);
        if (behind < 0) continue;
        if (!step) factor += pdi_conductance_along(bonds, i, k, d, side % 2, behind);
        else if (step == (side % 2 ? 1 : -1) && grid->kind[i + bonds->paths.shift[k]] == PD_INLET)
            factor *= pdi_conductance_across(bonds, i, k, d, side % 2, behind);
    }
    return factor;
}

PDI_FN double pdi_conductance_beside(const pd_bonds *bonds, int32_t i, int k, double bond)
{
    bond /= pdi_conductance_entry(bonds, i, k);
    return bonds->grid->mixed_sides ? bond * pdi_conductance_end(bonds, i, k) : bond;
}

/* Which bonds of a row at rest have a number, and what those that are closed and have none would conduct. */
static void pdi_conductance_sums(const pd_conductance *c, int32_t row)
{
    const pd_bonds *bonds = c->bonds;
    double sum = 0.0;
    for (int word = 0; word < bonds->paths.words; word++) c->other[(int64_t)word * c->capacity + row] = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        float more = c->more[pdi_conductance_place(c, row, k)];
        if (more < 0.0f || more > 0.0f) c->other[(int64_t)(k >> 5) * c->capacity + row] |= (uint32_t)1 << (k & 31);
        else if (!pdi_bond_is_open(bonds, row, k)) sum += bonds->stencil->laplacian_weight[k];
    }
    c->shut[row] = c->diffusion->desc.diffusivity * sum;
}

/* Where the rows stood when they were last found. Plain rows come in the order of their nodes, and so do the others
 * behind them. */
static void pdi_conductance_find(const pd_conductance *c)
{
    const pd_bonds *bonds = c->bonds;
    int32_t old = 0;
    for (int32_t r = 0; r < bonds->rows; r++) {
        int32_t end = r < bonds->rows_without_inlet ? c->plain : c->rows;
        if (r == bonds->rows_without_inlet) old = c->plain;
        while (old < end && c->node[old] < bonds->node[r]) old++;
        c->from[r] = old < end && c->node[old] == bonds->node[r] ? old : -1;
    }
}

static void pdi_conductance_move_row(const pd_conductance *c, int32_t r)
{
    int32_t from = c->from[r];
    if (from < 0) return;
    for (int k = 0; k < c->bonds->stencil->count; k++) {
        int64_t to = pdi_conductance_place(c, r, k), at = pdi_conductance_place(c, from, k);
        if (c->rests) c->more[to] = c->more[at];
        else c->bond[to] = c->bond[at];
    }
    for (int word = 0; word < c->bonds->paths.words && c->rests; word++)
        c->other[(int64_t)word * c->capacity + r] = c->other[(int64_t)word * c->capacity + from];
    if (c->rests) c->shut[r] = c->shut[from];
}

/* What goes to the front goes first, from the front on; the order of the rows stays, so that none is overwritten. */
static void pdi_conductance_move(const pd_conductance *c)
{
    for (int32_t r = 0; r < c->bonds->rows; r++)
        if (c->from[r] > r) pdi_conductance_move_row(c, r);
    for (int32_t r = c->bonds->rows - 1; r >= 0; r--)
        if (c->from[r] < r) pdi_conductance_move_row(c, r);
}

/* Bond k of row r. */
static void pdi_conductance_bond(const pd_conductance *c, int32_t r, int k)
{
    const pd_bonds *bonds = c->bonds;
    int32_t i = bonds->node[r];
    int open = pdi_bond_is_open(bonds, r, k);
    int64_t at = pdi_conductance_place(c, r, k);
    if (c->rests) {
        uint8_t kind = bonds->grid->kind[i + bonds->paths.shift[k]];
        c->more[at] = open ? pdi_diffusion_more(c->diffusion, i, k) : pdi_grid_is_open(kind) ? -1.0f : 0.0f;
        return;
    }
    c->bond[at] = 0.0;
    if (!open) return;
    pdi_diffusion_bond(c->diffusion, i, k, 1, 1, c->bond + at);
    if (bonds->has_inlet[r] || bonds->grid->mixed_sides) c->bond[at] = pdi_conductance_beside(bonds, i, k, c->bond[at]);
}

/* The bonds of a row that have an end with new numbers. */
static void pdi_conductance_row(const pd_conductance *c, int32_t r)
{
    const pd_bonds *bonds = c->bonds;
    const uint32_t *renewed = c->diffusion->renewed + bonds->node[r];
    int all = c->from[r] < 0 || *renewed > c->version, some = all;
    for (int k = 0; k < bonds->stencil->count; k++) {
        if (!all && renewed[bonds->paths.shift[k]] <= c->version) continue;
        pdi_conductance_bond(c, r, k);
        some = 1;
    }
    if (some && c->rests) pdi_conductance_sums(c, r);
}

PDI_FN void pdi_conductance_update(const pd_ctx *ctx, pd_conductance *c)
{
    const pd_bonds *bonds = c->bonds;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * bonds->stencil->count * 8);
    (void)nt;
    if (c->version == bonds->version) return;
    pdi_conductance_find(c);
    pdi_conductance_move(c);
    /* callbacks say where inlets end: one thread asks them */
    int32_t several = bonds->grid->mixed_sides ? bonds->rows_without_inlet : bonds->rows;
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < several; r++) pdi_conductance_row(c, r);
    for (int32_t r = several; r < bonds->rows; r++) pdi_conductance_row(c, r);
    for (int32_t r = 0; r < bonds->rows; r++) c->node[r] = bonds->node[r];
    c->rows = bonds->rows;
    c->plain = bonds->rows_without_inlet;
    c->version = bonds->version;
}

PDI_FN void pdi_conductance_list(pdi_array_visitor *owner, void *object)
{
    pd_conductance *conductance = (pd_conductance *)object;
    const pd_bonds *bonds = conductance->bonds;
    int64_t rows = conductance->capacity;
    int64_t count = bonds ? bonds->stencil->count * rows : 0;
    if (!conductance->rests) PDI_ARRAY(owner, conductance, bond, count, "1/s");
    else {
        PDI_ARRAY(owner, conductance, more, count, "1");
        PDI_ARRAY(owner, conductance, other, bonds ? bonds->paths.words * rows : 0, "1");
        PDI_ARRAY(owner, conductance, shut, rows, "1/s");
    }
    PDI_ARRAY(owner, conductance, node, rows, "1");
    PDI_ARRAY(owner, conductance, from, rows, "1");
}

PDI_FN pd_status pdi_conductance_fit(pd_ctx *ctx, pd_conductance *c)
{
    int32_t pages = (c->bonds->capacity + PDI_CONDUCTANCE_PAGE - 1) / PDI_CONDUCTANCE_PAGE;
    if (pages * PDI_CONDUCTANCE_PAGE == c->capacity) return PD_OK;
    c->rows = c->plain = 0;
    c->version = 0;
    return pdi_array_registry_rebuild(ctx, pdi_conductance_list, c, &c->capacity, pages * PDI_CONDUCTANCE_PAGE);
}
