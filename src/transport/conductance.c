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
    if (grid->kind[i + bonds->shift[k]] != PD_INLET) return 1.0;
    pdi_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        int step = bonds->stencil->offset[k * PD_DIM + d], upper = step > 0;
        double inside = upper ? grid->n[d] - at[d] - 0.5 : at[d] + 0.5; /* cells to the side */
        if (pdi_grid_port(grid->side[2 * d + upper])) fraction = fmin(fraction, step ? inside / abs(step) : 1.0);
    }
    return fraction;
}

/* Element `row` of shut. */
static double pdi_conductance_shut(const pd_conductance *c, int32_t i, int32_t row)
{
    const pd_bonds *bonds = c->bonds;
    const double *lap = pdi_bond_lap(bonds, i);
    double sum = 0.0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        uint8_t kind = bonds->grid->kind[i + bonds->shift[k]];
        double bond = *pdi_conductance_place(c, row, k), whole = c->diffusion->desc.diffusivity * lap[k];
        if (kind == PD_FLUID || kind == PD_IMAGE) {
            if (bond < whole || bond > whole) return -1.0;
        } else if (kind == PD_INLET || kind == PD_OUTLET || bond > 0.0) return -1.0;
        else sum += whole;
    }
    return sum;
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
    for (int k = 0; k < c->bonds->stencil->count; k++)
        *pdi_conductance_place(c, r, k) = *pdi_conductance_place(c, from, k);
    if (c->shut) c->shut[r] = c->shut[from];
}

/* What goes to the front goes first, from the front on; the order of the rows stays, so that none is overwritten. */
static void pdi_conductance_move(const pd_conductance *c)
{
    for (int32_t r = 0; r < c->bonds->rows; r++)
        if (c->from[r] > r) pdi_conductance_move_row(c, r);
    for (int32_t r = c->bonds->rows - 1; r >= 0; r--)
        if (c->from[r] < r) pdi_conductance_move_row(c, r);
}

/* Conductances of the bonds of a row that have an end with new numbers. */
static void pdi_conductance_row(const pd_conductance *c, int32_t r)
{
    const pd_bonds *bonds = c->bonds;
    const pd_diffusion *d = c->diffusion;
    int32_t i = bonds->node[r];
    int all = c->from[r] < 0 || d->renewed[i] > c->version, some = all;
    for (int k = 0; k < bonds->stencil->count; k++) {
        double bond = 0.0;
        if (!all && d->renewed[i + bonds->shift[k]] <= c->version) continue;
        if (pdi_bond_open(bonds, r, k)) {
            pdi_diffusion_bond(d, i, k, 1, 1, &bond);
            if (bonds->inlet[r]) bond /= pdi_conductance_entry(bonds, i, k);
        }
        *pdi_conductance_place(c, r, k) = bond;
        some = 1;
    }
    if (some && c->shut) c->shut[r] = pdi_conductance_shut(c, i, r);
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
    PDI_ARRAY(owner, conductance, bond, bonds ? bonds->stencil->count * rows : 0, "1/s");
    if (conductance->rests) PDI_ARRAY(owner, conductance, shut, rows, "1/s");
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
