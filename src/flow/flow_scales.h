/* flow_scales: velocity and length scale of a flow from its lattice and boundary data (theory: eq. 3.9). */
#ifndef PD_FLOW_SCALES_H
#define PD_FLOW_SCALES_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL

/* Largest over the sides of the mean size of the normal inlet velocity [m/s], from the inlet ghosts next to a face of
 * the box (not its edges); axisymmetric: weighted by the circumference. 0: there are none. u [PD_DIM][total] with its
 * inlet ghosts. */
PDI_FN double pdi_flow_scales_compute_inlet_speed(const pd_grid *grid, const double *u);
/* Length scale L [m] (eq. 3.9): smallest extent of the box around all fluid nodes, over the axes between walls or
 * mirrors; without such axes over those with an inlet or outlet on either side, else over the periodic ones. The extent
 * doubles for each mirror side that fluid reaches, and for the axis of symmetry where the lattice begins there. Without
 * fluid nodes an extent is one cell. */
PDI_FN double pdi_flow_scales_compute_length(const pd_grid *grid);
/* Mean speed U [m/s] of a plane channel of width L = length [m] driven by `force` [m/s2], not negative, with the
 * kinematic viscosity nu [m2/s]: the positive root of 12 nu U/L^2 + U^2/L = force (eq. 3.9); 0 for no force. */
PDI_FN double pdi_flow_scales_compute_forced_speed(double nu, double length, double force);

#endif

#endif
