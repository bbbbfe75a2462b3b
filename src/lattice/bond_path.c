/* bond_path: see bond_path.h */
#include "lattice/bond_path.h"
#include <math.h>
#include <string.h>

PDI_FN int pdi_bond_path_find_closed_group(const pd_bond_paths *paths, int32_t node, int k)
{
    const pd_stencil *s = paths->stencil;
    const uint8_t *kind = paths->grid->kind;
    for (int g = s->group_first[k]; g < s->group_first[k + 1]; g++) {
        int closed = 1;
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1] && closed; c++)
            closed = !pdi_grid_is_open(kind[node + paths->cell_shift[c]]);
        if (closed) return g;
    }
    return -1;
}

/* Kind of a cell; for a ghost that of its source node in the box, behind walls, inlets and outlets, too. */
static uint8_t pdi_bond_path_get_source_kind(const pd_grid *grid, int32_t cell)
{
    if (grid->kind[cell] == PD_SOLID) return PD_SOLID;
    return grid->kind[pd_grid_find_source(grid, cell, NULL)];
}

PDI_FN int32_t pdi_bond_path_find_closed_cell(const pd_bond_paths *paths, int32_t node, int group)
{
    const pd_stencil *s = paths->stencil;
    int32_t found = -1;
    int best = -1;
    for (int c = s->group_cell[group]; c < s->group_cell[group + 1]; c++) {
        int32_t cell = node + paths->cell_shift[c];
        int rank = 2 * (pdi_bond_path_get_source_kind(paths->grid, cell) == PD_SOLID) +
                   !pdi_grid_is_behind_wall(paths->grid, cell);
        if (rank <= best) continue;
        best = rank;
        found = cell;
    }
    return found;
}

PDI_FN int pdi_bond_path_has_metal(const pd_bond_paths *paths, int32_t node, int group, int *all)
{
    const pd_stencil *s = paths->stencil;
    int metal = 0;
    for (int c = s->group_cell[group]; c < s->group_cell[group + 1]; c++)
        metal += pdi_bond_path_get_source_kind(paths->grid, node + paths->cell_shift[c]) == PD_SOLID;
    *all = metal == s->group_cell[group + 1] - s->group_cell[group];
    return metal > 0;
}

PDI_COLD_BEGIN
/* Describes the arrays of the paths to the array registry. */
static void pdi_bond_path_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_bond_paths *paths = (pd_bond_paths *)object;
    if (!paths->stencil) return;
    PDI_ARRAY(owner, paths, shift, paths->stencil->count, "1");
    PDI_ARRAY(owner, paths, cell_shift, paths->stencil->cells, "1");
}

PDI_FN pd_status pdi_bond_path_build(pd_ctx *ctx, const pd_stencil *s, const pd_grid *grid, pd_bond_paths *paths)
{
    memset(paths, 0, sizeof *paths);
    if (s->reach > grid->ghost)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "path", "bonds reach over %d cells, the grid has %d layers of ghosts",
                       s->reach, grid->ghost);
    for (int d = 0; d < PD_DIM; d++)
        if (fabs(s->h[d] - grid->h[d]) > 1e-12 * grid->h[d])
            return pd_fail(ctx, PD_ERR_ARGUMENT, "path", "bonds for a spacing of %g m, the grid has %g m on axis %d",
                           s->h[d], grid->h[d], d);
    paths->stencil = s;
    paths->grid = grid;
    paths->words = (s->count + 31) / 32;
    PD_TRY(pdi_array_registry_build(ctx, pdi_bond_path_list_arrays, paths));
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) paths->shift[k] += s->offset[k * PD_DIM + d] * grid->stride[d];
    for (int c = 0; c < s->cells; c++)
        for (int d = 0; d < PD_DIM; d++) paths->cell_shift[c] += s->cell[c * PD_DIM + d] * grid->stride[d];
    return PD_OK;
}

PDI_FN void pdi_bond_path_free(pd_ctx *ctx, pd_bond_paths *paths)
{
    pdi_array_registry_free(ctx, pdi_bond_path_list_arrays, paths);
    memset(paths, 0, sizeof *paths);
}
PDI_COLD_END
