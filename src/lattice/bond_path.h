/* bond_path: the bonds of a stencil on a grid as differences of node ids, and the cells that their straight lines
 * cross.
 *
 * Fluid and metal may have different horizons on one grid: each has its stencil and its paths, and the ghost layers
 * are as deep as the longest of them.
 */
#ifndef PD_BOND_PATH_H
#define PD_BOND_PATH_H
#include "core/array_registry.h"
#include "lattice/grid.h"

typedef struct pd_bond_paths {
    const pd_stencil *stencil;
    const pd_grid *grid;
    int words;           /* 32-bit words of a mask with one bit for each bond */
    int32_t *shift;      /* [count] node id of the far end minus that of the node */
    int32_t *cell_shift; /* [cells of the stencil] the same for the cells that bonds cross */
} pd_bond_paths;

#ifdef PDI_INTERNAL
/* Allocates and computes the differences of node ids; `paths` is overwritten, and holds no arrays after a failure. Grid
 * and stencil are borrowed. PD_ERR_ARGUMENT: the grid has fewer ghost layers than the stencil reaches, or spacings that
 * differ by more than 1e-12 of them. */
PDI_FN pd_status pdi_bond_path_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_bond_paths *paths);
PDI_FN void pdi_bond_path_free(pd_ctx *ctx, pd_bond_paths *paths);
/* First closed group of cells on bond k from `node` (index into the stencil's groups), one whose cells are all closed:
 * the bond is blocked there; -1: the bond is open. The cell of `node` itself is not tested, that of the far end is. */
PDI_FN int pdi_bond_path_find_closed_group(const pd_bond_paths *paths, int32_t node, int k);
/* Node id of the cell of a closed group, as seen from `node`, that represents it (may be a ghost): metal and images of
 * metal before walls, then cells in front of wall sides of the box before those behind; of equal ones the first of the
 * group. */
PDI_FN int32_t pdi_bond_path_find_closed_cell(const pd_bond_paths *paths, int32_t node, int group);
/* 1: a cell of the group, as seen from `node`, is metal or a ghost whose source is metal; *all: 1 when each of them is.
 */
PDI_FN int pdi_bond_path_has_metal(const pd_bond_paths *paths, int32_t node, int group, int *all);
#endif

#endif
