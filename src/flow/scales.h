/* scales: how large a flow is and how fast it comes in, from the lattice alone. */
#ifndef PD_SCALES_H
#define PD_SCALES_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL

/* Mean speed [m/s] through the inlet nodes next to the box, of the side where it is largest; u
 * [PD_DIM][total]. */
PDI_FN double pdi_scales_entry(const pd_grid *grid, const double *u);
/* Smallest extent [m] of the fluid across which it stands between walls; of a box without them, between its sides. What
 * lies in front of a mirror counts twice. */
PDI_FN double pdi_scales_fluid(const pd_grid *grid);

#endif

#endif
