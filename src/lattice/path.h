/* path: the bonds of a stencil on a grid, as shifts of node ids, and the cells that their straight lines pass.
 *
 * Fluid and metal may have horizons of their own on one grid: each has its stencil and its paths, and the ghosts are
 * as deep as the longest of them.
 */
#ifndef PD_PATH_H
#define PD_PATH_H
#include "core/owner.h"
#include "lattice/grid.h"

typedef struct pd_paths {
    const pd_stencil *stencil;
    const pd_grid *grid;
    int words;           /* of a mask of bits, one a bond */
    int32_t *shift;      /* [count] node id of the far end minus that of the node */
    int32_t *cell_shift; /* [cells of the stencil] the same for the cells that bonds pass */
} pd_paths;

#ifdef PDI_INTERNAL
/* Grid and stencil are borrowed. PD_ERR_ARGUMENT: the ghosts of the grid are fewer than the stencil reaches, or its
 * spacings are others. */
PDI_FN pd_status pdi_path_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_paths *paths);
PDI_FN void pdi_path_free(pd_ctx *ctx, pd_paths *paths);
/* First closed group on bond k from `node` (index into the stencil's groups); -1: open. */
PDI_FN int pdi_path_closed_group(const pd_paths *paths, int32_t node, int k);
/* Cell of that group that stands for it: of cells at an edge or corner metal comes before a wall, and the wall of a
 * shape before the sides of the box, whatever their order. */
PDI_FN int32_t pdi_path_closed_cell(const pd_paths *paths, int32_t node, int group);
/* 1 when a cell of the group is metal, or the image of metal; *all: each of them is. */
PDI_FN int pdi_path_metal(const pd_paths *paths, int32_t node, int group, int *all);
#endif

#endif
