/* surface: nearest point, normal and area of the surface of walls and metal. The surface is that of bond.h: sides of
 * the box, the zero level of a smooth shape where that has not receded by dissolution, else the faces of closed
 * cells.
 */
#ifndef PD_SURFACE_H
#define PD_SURFACE_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* Surface point nearest to `target` [m] as seen from fluid node `node`: the closest point of smooth shapes, up to two
 * cells away, or the cell face that the segment from the node, extended by one cell, intersects (none when target is
 * the node). 1: found, -1: found, and `target` lies behind it (in the solid), 0: none, and the results are zero. point
 * [PD_DIM] [m], unit normal [PD_DIM] towards the fluid, and *closed, a closed node behind it (may be a ghost). */
PDI_FN int pdi_surface_find_nearest(const pd_bonds *bonds, int32_t node, const double *target, double *point,
                                    double *normal, int32_t *closed);
/* Signed distance [m] of x from the smooth surface through the cell of node `closed`, and its gradient by central
 * differences over `step` cells either way: the normal towards the fluid. Returns 1; 0: its norm differs from 1 by 1e-2
 * or more, as an edge is nearby, or there is no smooth surface (NaN). The gradient is not normalised; both are set in
 * either case. */
PDI_FN int pdi_surface_compute_normal(const pd_bonds *bonds, int32_t closed, const double *x, double step,
                                      double *distance, double *normal);
/* Area [m^(d-1); axisymmetric: m2 of the full ring] of the surface that belongs to the cell face between open node
 * `node` and the closed one next to it along `axis`, up (1) or down (0): of the projection of the face on the smooth
 * shape of the closed node, else of the face itself (theory: eq. 6.20). Faces of a closed body share corners, so the
 * sum over them is the area of a closed surface. It is negative where the face is the back of a step. */
PDI_FN double pdi_surface_compute_face_area(const pd_grid *grid, int32_t node, int axis, int up);
#endif

#endif
