/* thickness: how much of the metal of a grid is in thin parts. */
#ifndef PD_THICKNESS_H
#define PD_THICKNESS_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* *share [-]: of the metal that is farther than half of `cells`, on a way through metal, from every cube of as many
 * cells of metal along each axis. It goes on behind mirror sides. Edges and caps of thick parts are near such a cube:
 * the cap of the smallest ball that holds one is 0.37 `cells` high. */
PDI_FN pd_status pdi_thickness_fraction(pd_ctx *ctx, const pd_grid *grid, int cells, double *share);
#endif

#endif
