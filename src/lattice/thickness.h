/* thickness: the fraction of metal in parts that are thinner than a number of cells (morphological opening). */
#ifndef PD_THICKNESS_H
#define PD_THICKNESS_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* *fraction [-]: share, by number, of the metal nodes of the box that are farther than half of `cells` (>= 1), on a
 * path through metal, from every cube of `cells` metal nodes along each axis. Metal continues behind mirror sides, but
 * not behind others. Edges and caps of thick parts count as thick: the cap of the smallest ball that holds a cube is
 * 0.37 `cells` high. 0 without metal, and on failure (memory). */
PDI_FN pd_status pdi_thickness_compute_thin_fraction(pd_ctx *ctx, const pd_grid *grid, int cells, double *fraction);
#endif

#endif
