/* near_wall: pressure and wall shear at points beside surfaces, by least-squares fits over the fluid nodes around. */
#ifndef PD_NEAR_WALL_H
#define PD_NEAR_WALL_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Kinematic pressure p [total] interpolated at x [m], as seen from fluid node `node`: least-squares quadratic (1.11)
 * through the nodes within two open bonds and sqrt(5) cells, no inlets. Where the surface point nearest to x is within
 * 1.5 cells and at rest, the wall-normal slope of eq. 1.12 joins it if it can be fitted. flow NULL: without that
 * slope. Ghosts must be filled. */
PDI_FN double pdi_near_wall_interpolate_pressure(const pd_bonds *bonds, const pd_flow *flow, const double *p,
                                                 int32_t node, const double *x);
/* *curvature [1/m] = sum of the principal curvatures (Laplacian of the distance, positive for a convex body) of the
 * smooth surface of cell wall_cell at x, by finite differences. Where an inlet or outlet mirrors the surface, that of
 * the part inside. Returns 1; 0 near an edge, where the second derivative along an axis times the spacing is 0.5 or
 * more, *curvature is set all the same. */
PDI_FN int pdi_near_wall_compute_curvature(const pd_bonds *bonds, int32_t wall_cell, const double *x,
                                           double *curvature);
/* slope [PD_DIM] [1/s] = derivative of the tangential velocity along the normal into the fluid, at the surface point
 * nearest to x as seen from fluid node `node`, by least squares (eq. 5.4). Returns 1; 0: there is no surface, it is
 * that of cell faces inside the box, an edge is near, or the fit is singular; slope is not set then. */
PDI_FN int pdi_near_wall_compute_shear(const pd_flow *flow, int32_t node, const double *x, double *slope);
#endif

#endif
