/* bounds: least and largest value that a field may take, and the nodes that leave them. */
#ifndef PD_BOUNDS_H
#define PD_BOUNDS_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
typedef struct pdi_bounds {
    double low, high; /* low > high: nothing is known yet */
} pdi_bounds;

PDI_FN void pdi_bounds_take(double value, pdi_bounds *bounds);
/* All values of the nodes of one kind. */
PDI_FN void pdi_bounds_take_all(const pd_grid *grid, uint8_t kind, const double *x, pdi_bounds *bounds);
/* Those that inlets hold. */
PDI_FN void pdi_bounds_take_inlets(const pd_ghosts *ghosts, const double *x, pdi_bounds *bounds);
/* Both move out by a share of the largest value of the fluid. */
PDI_FN void pdi_bounds_widen(const pd_grid *grid, const double *c, double share, pdi_bounds *bounds);
/* 1: the field keeps them at all fluid nodes, with `more` on top of it where that is not NULL. */
PDI_FN int pdi_bounds_keep(const pd_grid *grid, const double *c, const double *more, const pdi_bounds *bounds);
/* Marks the fluid nodes that leave them, and where that is done already the far ends of their bonds; how many are
 * new. */
PDI_FN int64_t pdi_bounds_mark(const pd_bonds *bonds, const double *c, const pdi_bounds *bounds, uint8_t *marked);
#endif

#endif
