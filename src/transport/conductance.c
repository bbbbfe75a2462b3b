/* conductance: see conductance.h */
#include "transport/conductance.h"
#include "core/par.h"
#include <math.h>
#include <stdlib.h>

PDI_FN double pdi_conductance_entry(const pd_bonds *bonds, int32_t i, int k)
{
    const pd_grid *grid = bonds->grid;
    double fraction = 1.0;
    int at[PD_DIM];
    if (grid->kind[i + bonds->paths.shift[k]] != PD_INLET) return 1.0;
    pdi_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        int step = bonds->stencil->offset[k * PD_DIM + d], upper = step > 0;
        double inside = upper ? grid->n[d] - at[d] - 0.5 : at[d] + 0.5; /* cells to the side */
        if (pdi_grid_port(grid->side[2 * d + upper])) fraction = pdi_min(fraction, step ? inside / abs(step) : 1.0);
    }
    return fraction;
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
        else if (!pdi_bond_open(bonds, row, k)) sum += bonds->stencil->lap[k];
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
        int32_t end = r < bonds->plain ? c->plain : c->rows;
        if (r == bonds->plain) old = c->plain;
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
    int open = pdi_bond_open(bonds, r, k);
    int64_t at = pdi_conductance_place(c, r, k);
    if (c->rests) {
        uint8_t kind = bonds->grid->kind[i + bonds->paths.shift[k]];
        c->more[at] = open ? pdi_diffusion_more(c->diffusion, i, k) : pdi_grid_open(kind) ? -1.0f : 0.0f;
        return;
    }
    c->bond[at] = 0.0;
    if (!open) return;
    pdi_diffusion_bond(c->diffusion, i, k, 1, 1, c->bond + at);
    if (bonds->inlet[r]) c->bond[at] /= pdi_conductance_entry(bonds, i, k);
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
    int nt = pdi_par_threads(ctx, (int64_t)bonds->rows * bonds->stencil->count * 8);
    (void)nt;
    if (c->version == bonds->version) return;
    pdi_conductance_find(c);
    pdi_conductance_move(c);
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++) pdi_conductance_row(c, r);
    for (int32_t r = 0; r < bonds->rows; r++) c->node[r] = bonds->node[r];
    c->rows = bonds->rows;
    c->plain = bonds->plain;
    c->version = bonds->version;
}

PDI_FN void pdi_conductance_list(pdi_owner *owner, void *object)
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
    return pdi_owner_renew(ctx, pdi_conductance_list, c, &c->capacity, pages * PDI_CONDUCTANCE_PAGE);
}
