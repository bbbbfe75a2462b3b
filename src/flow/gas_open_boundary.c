/* gas_open_boundary: see gas_open_boundary.h */
#include "flow/gas_open_boundary.h"
#include "flow/gas_wall.h"
#include <string.h>

PDI_FN void pdi_gas_open_boundary_get_ghost_signs(const pd_ghosts *g, int32_t k, int *flip, int *odd)
{
    int i[PD_DIM];
    *flip = *odd = g->sign_flips[k];
    if (k < g->images_end) return;
    pd_grid_index(g->grid, g->node[k], i);
    *odd = pdi_grid_fold_index(g->grid, i);
    (void)pd_grid_find_source(g->grid, g->node[k], flip);
}

/* Open side of the box, 2 axis + (0 or 1), that ghost j is behind; -1: none. */
static int pdi_gas_open_boundary_find_side(const pd_grid *grid, int32_t j)
{
    int index[PD_DIM];
    pd_grid_index(grid, j, index);
    for (int d = 0; d < PD_DIM; d++) {
        int side = 2 * d + (index[d] >= grid->n[d]);
        int outside = index[d] < 0 || index[d] >= grid->n[d];
        if (outside && (grid->side[side] == PD_SIDE_INLET || grid->side[side] == PD_SIDE_OUTLET)) return side;
    }
    return -1;
}

PDI_FN void pdi_gas_open_boundary_extrapolate_ghosts(const pd_bonds *bonds, int fields, int vector, double *q)
{
    const pd_ghosts *g = &bonds->ghosts;
    const pd_grid *grid = g->grid;
    int64_t total = grid->total;
    for (int32_t k = g->images_end; k < g->outlets_end && PD_DIM > 1; k++) {
        int index[PD_DIM], side = pdi_gas_open_boundary_find_side(grid, g->node[k]), d = side / 2, flip, odd;
        if (side < 0 || grid->n[d] < 2) continue;
        pd_grid_index(grid, g->source[k], index);
        int32_t inwards = side % 2 ? -grid->stride[d] : grid->stride[d];
        int32_t last = g->source[k] + (side % 2 ? grid->n[d] - 1 - index[d] : -index[d]) * grid->stride[d];
        if (grid->kind[last] != PD_FLUID || grid->kind[last + inwards] != PD_FLUID) continue;
        pdi_gas_open_boundary_get_ghost_signs(g, k, &flip, &odd);
        pd_grid_index(grid, g->node[k], index);
        int steps = side % 2 ? index[d] - (grid->n[d] - 1) : -index[d];
        for (int c = 0; c < fields; c++) {
            double *f = q + c * total, value = f[last] + steps * (f[last] - f[last + inwards]);
            int sign = c >= vector && c < vector + PD_DIM ? odd >> (c - vector) & 1 : 0;
            f[g->node[k]] = sign ? -value : value;
        }
    }
}

/* Ghost of the first layer behind `side` (2 axis + 0 or 1) on the grid line of node i; `other` where that is no
 * inlet. */
static int32_t pdi_gas_open_boundary_find_facing_ghost(const pd_grid *grid, int32_t i, int side, int32_t other)
{
    int index[PD_DIM], d = side / 2;
    pd_grid_index(grid, i, index);
    int32_t ghost = i + (side % 2 ? grid->n[d] - index[d] : -1 - index[d]) * grid->stride[d];
    return grid->kind[ghost] == PD_INLET ? ghost : other;
}

PDI_FN void pdi_gas_open_boundary_compute_faces(const pd_bonds *bonds, int32_t i, pdi_gas_open_boundary_faces *t)
{
    const pd_grid *grid = bonds->paths.grid;
    memset(t, 0, sizeof *t);
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t j = i + bonds->paths.shift[k];
        double n[PD_DIM];
        if (!pdi_gas_open_boundary_is_crossed_by_bond(bonds, i, k)) continue;
        int side = pdi_gas_open_boundary_find_side(grid, j);
        double weight = pdi_gas_wall_get_bond_face(bonds->stencil, k, n);
        for (int d = 0; d < PD_DIM; d++) t->area[side][d] += 0.5 * weight * n[d];
        t->half_length[side] += 0.25 * weight * pdi_vec_dot(n, bonds->stencil->xi + k * PD_DIM);
        t->outer_ghost[side] =
            grid->kind[j] == PD_INLET ? pdi_gas_open_boundary_find_facing_ghost(grid, i, side, j) : -1;
    }
}
