/* surface: the surface of walls and metal beside a point. It is that of bond.h: sides of the box, the zero level of a
 * smooth shape where that has not receded, else the faces of closed cells.
 */
#ifndef PD_SURFACE_H
#define PD_SURFACE_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* The surface beside the point `to` [m] as fluid node `node` sees it: the nearest place of smooth shapes, or that of
 * faces which the straight way from the node, and one cell on, meets. 0: there is none; -1: the point lies behind it.
 * The place [m], the normal towards the fluid, and a closed node. */
PDI_FN int pdi_surface_meet(const pd_bonds *bonds, int32_t node, const double *to, double *place, double *normal,
                        int32_t *closed);
/* Distance [m] of x from the smooth surface that node `closed` is a cell of, and its slope by differences over `step`
 * cells to both sides: the normal there. 0: the slope is not 1, an edge is nearby. */
PDI_FN int pdi_surface_rise(const pd_bonds *bonds, int32_t closed, const double *x, double step, double *distance,
                            double *normal);
/* Area [m^(d-1); axisymmetric: m2 of the whole ring] of the surface beside the face between an open node and the closed
 * one next to it along `axis`, up (1) or down (0): of the places next to those of the face on the smooth shape of the
 * closed node, else of the face (theory: eq. 5.12b). Faces of a closed body share corners, so the sum over them is that
 * of a closed surface. It is negative where the face is the back of a step. */
PDI_FN double pdi_surface_face(const pd_grid *grid, int32_t node, int axis, int up);
#endif

#endif
