/* scales: velocity and length scale of a flow from its lattice and boundary data (theory: eq. 4.5b). */
#ifndef PD_SCALES_H
#define PD_SCALES_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL

/* Largest mean inlet speed [m/s] over the sides, from the inlet ghosts next to the box. u [PD_DIM][total]. */
PDI_FN double pdi_scales_entry(const pd_grid *grid, const double *u);
/* Length scale L [m] (eq. 4.5b): smallest extent of the fluid between walls; without walls, between the sides of the
 * box. An extent that ends at a mirror counts twice. */
PDI_FN double pdi_scales_fluid(const pd_grid *grid);

#endif

#endif
