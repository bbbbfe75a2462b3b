/* open_boundary: see open_boundary.h */
#include "lattice/open_boundary.h"
#include "core/array_registry.h"
#include <string.h>

PDI_FN int32_t pdi_open_boundary_find_segment(const pd_bonds *bonds, int32_t i, int32_t length, int *near_port)
{
    const pd_grid *grid = bonds->grid;
    int at[PD_DIM], reach = bonds->stencil->reach;
    pd_grid_index(grid, i, at);
    *near_port = 1;
    for (int d = 1; d < PD_DIM; d++) {
        if (pd_grid_is_inlet_or_outlet(grid->side[2 * d]) && at[d] < reach) return length;
        if (pd_grid_is_inlet_or_outlet(grid->side[2 * d + 1]) && at[d] >= grid->n[d] - reach) return length;
    }
    int32_t low = pd_grid_is_inlet_or_outlet(grid->side[0]) ? reach - at[0] : 0;
    int32_t high = (pd_grid_is_inlet_or_outlet(grid->side[1]) ? grid->n[0] - reach : grid->n[0]) - at[0];
    if (low > 0) return low < length ? low : length;
    if (high <= 0) return length;
    *near_port = 0;
    return high < length ? high : length;
}

PDI_FN int pdi_open_boundary_has_any(const pd_grid *grid)
{
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (pd_grid_is_inlet_or_outlet(grid->side[s])) return 1;
    return 0;
}

/* far [count] = far ends of the bonds of fluid node i; blocked bonds and those to outlets end on i. */
static void pdi_open_boundary_set_far_ends(const pd_bonds *bonds, int32_t i, int32_t *far)
{
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t row = bonds->row_of_node[i], j = i + bonds->paths.shift[k];
        int open = row < 0 || pdi_bond_is_open(bonds, row, k);
        far[k] = open && bonds->grid->kind[j] != PD_OUTLET ? j : i;
    }
}

/* Returns the number of fluid nodes near inlets and outlets; list 1: also stores them and their far ends in node and
 * far_end, which have room. */
static int32_t pdi_open_boundary_find_nodes(pd_open_boundary *p, int list)
{
    const pd_bonds *bonds = p->bonds;
    int32_t found = 0;
    for (int32_t i = 0; i < bonds->grid->total; i++) {
        int near_port;
        if (bonds->grid->kind[i] != PD_FLUID) continue;
        pdi_open_boundary_find_segment(bonds, i, 1, &near_port);
        if (!near_port) continue;
        if (list) {
            p->node[found] = i;
            pdi_open_boundary_set_far_ends(bonds, i, p->far_end + (int64_t)found * bonds->stencil->count);
        }
        found++;
    }
    return found;
}

/* Describes the arrays of pd_open_boundary to the array registry. */
static void pdi_open_boundary_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_open_boundary *boundary = (pd_open_boundary *)object;
    int64_t bonds = boundary->bonds ? boundary->bonds->stencil->count : 0;
    PDI_ARRAY(owner, boundary, node, boundary->capacity, "1");
    PDI_ARRAY(owner, boundary, far_end, bonds * boundary->capacity, "1");
}

PDI_FN pd_status pdi_open_boundary_update(pd_ctx *ctx, pd_open_boundary *p)
{
    int32_t count = pdi_open_boundary_has_any(p->bonds->grid) ? pdi_open_boundary_find_nodes(p, 0) : 0;
    if (count > p->capacity) {
        p->count = 0;
        PD_TRY(pdi_array_registry_rebuild(ctx, pdi_open_boundary_list_arrays, p, &p->capacity, count));
    }
    p->count = count ? pdi_open_boundary_find_nodes(p, 1) : 0;
    return PD_OK;
}

PDI_FN pd_status pdi_open_boundary_build(pd_ctx *ctx, const pd_bonds *bonds, pd_open_boundary *p)
{
    memset(p, 0, sizeof *p);
    p->bonds = bonds;
    return pdi_open_boundary_update(ctx, p);
}

PDI_FN void pdi_open_boundary_free(pd_ctx *ctx, pd_open_boundary *p)
{
    pdi_array_registry_free(ctx, pdi_open_boundary_list_arrays, p);
    memset(p, 0, sizeof *p);
}

/* 1: an open bond of fluid node i ends on a node of the kind `port` (PD_INLET or PD_OUTLET). */
static int pdi_open_boundary_has_bond_to(const pd_bonds *bonds, int32_t i, uint8_t port)
{
    int32_t row = bonds->row_of_node[i];
    for (int k = 0; k < bonds->stencil->count; k++)
        if (bonds->grid->kind[i + bonds->paths.shift[k]] == port && (row < 0 || pdi_bond_is_open(bonds, row, k)))
            return 1;
    return 0;
}

/* One step of a flood fill: sets mark [total] of the fluid nodes that open bonds of node i end on, of images that of
 * their source; returns how many are new. */
static int64_t pdi_open_boundary_mark_reachable(const pd_bonds *bonds, int32_t i, uint8_t *mark)
{
    int64_t found = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t j = i + bonds->paths.shift[k];
        if (bonds->row_of_node[i] >= 0 && !pdi_bond_is_open(bonds, bonds->row_of_node[i], k)) continue;
        if (bonds->grid->kind[j] == PD_IMAGE) j = pd_grid_find_source(bonds->grid, j, NULL);
        if (bonds->grid->kind[j] != PD_FLUID || mark[j]) continue;
        mark[j] = 1;
        found++;
    }
    return found;
}

PDI_FN pd_status pdi_open_boundary_find_blocked_inlet(pd_ctx *ctx, const pd_bonds *bonds, int32_t *node)
{
    int32_t total = bonds->grid->total;
    const uint8_t *kind = bonds->grid->kind;
    uint8_t *mark = NULL;
    *node = -1;
    PD_TRY(PD_NEW(ctx, "flow", total, mark));
    for (int32_t i = 0; i < total; i++)
        mark[i] = kind[i] == PD_FLUID && pdi_open_boundary_has_bond_to(bonds, i, PD_OUTLET);
    for (int64_t found = 1, backward = 0; found > 0; backward = !backward) {
        found = 0;
        for (int32_t n = 0; n < total; n++) {
            int32_t i = backward ? total - 1 - n : n;
            if (mark[i]) found += pdi_open_boundary_mark_reachable(bonds, i, mark);
        }
    }
    for (int32_t i = 0; i < total && *node < 0; i++)
        if (kind[i] == PD_FLUID && !mark[i] && pdi_open_boundary_has_bond_to(bonds, i, PD_INLET)) *node = i;
    PD_DELETE(ctx, total, mark);
    return PD_OK;
}
