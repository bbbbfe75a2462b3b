/* near_wall: pressure and slopes of the velocity at places beside surfaces, from the nodes of the fluid around. */
#ifndef PD_NEAR_WALL_H
#define PD_NEAR_WALL_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Value at the place x [m] that fluid node `node` sees of the kinematic pressure p [total]: of the quadratic (3.11)
 * through the nodes within two cells, and the slope that friction of `flow` gives it on a smooth surface or side of the
 * box at rest beside x (eq. 3.11b). flow NULL: of the nodes alone. Ghosts must be filled. */
PDI_FN double pdi_near_wall_pressure(const pd_bonds *bonds, const pd_flow *flow, const double *p, int32_t node,
                                     const double *x);
/* Sum of the curvatures [1/m] of the smooth surface that node `closed` is a cell of, at the place x on it: the
 * Laplacian of the distance. Where an inlet or outlet mirrors it, that of the part in front. 0: an edge is nearby. */
PDI_FN int pdi_near_wall_curved(const pd_bonds *bonds, int32_t closed, const double *x, double *mean);
/* Slope of the velocity along the normal [1/s] on the smooth surface beside x, as fluid node `node` sees it (4.27c),
 * by least squares over the nodes around. 0: it is not known. */
PDI_FN int pdi_near_wall_shear(const pd_flow *flow, int32_t node, const double *x, double *slope);
#endif

#endif
