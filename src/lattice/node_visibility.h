/* node_visibility: visibility criterion for bonds of metal: whether the straight line between two metal nodes stays in
 * the metal.
 *
 * With a smooth surface the test is exact: the line leaves the metal where it is outside the shape over any length,
 * however thin the gap. With cells (a voxel mask, or metal that has dissolved) inclined flat faces are staircases,
 * which the line between two nodes of a half-space may cross. There a line stays in metal when one of the digital lines
 * (staircases of cells that share faces) along it does: along each axis other than the longest one of the line, such a
 * staircase has all cells on or below the line, or all on or above it. A half-space that holds both ends holds each
 * staircase on its inner side, so that lines within a half-space stay in it, whatever its normal. A gap of one cell or
 * more between two metals, which no staircase of faces crosses, blocks the line.
 */
#ifndef PD_NODE_VISIBILITY_H
#define PD_NODE_VISIBILITY_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* 1: all lines between metal nodes stay in the initial metal: the shape of metal is convex (pdi_shape_is_convex) and
 * there is no shape of walls. 0: no metal, or it is not known. */
PDI_FN int pdi_node_visibility_is_convex(const pd_grid *grid);
/* 1: there is a shape of metal, and it and that of walls, if any, have smooth surfaces (no voxel masks). */
PDI_FN int pdi_node_visibility_is_smooth(const pd_grid *grid);
/* Signed distance [m] of x from the initial metal (shape of metal without walls), negative inside, or a bound of it.
 * There is metal. */
PDI_FN double pdi_node_visibility_metal_distance(const pd_grid *grid, const double *x);
/* 1: the segment x + t xi, 0 <= t <= 1, stays inside the smooth surface of the initial metal, or on it: no part between
 * two intersections has its midpoint outside by more than the surface tolerance. There is metal, without voxel masks;
 * positions are not folded into the box. */
PDI_FN int pdi_node_visibility_is_visible(const pd_grid *grid, const double *x, const double *xi);
/* 1: the cell with this index is metal. */
typedef int (*pdi_node_visibility_is_metal_fn)(const void *self, const int *cell);
/* 1: all cells of one of the staircases from the cell from[] to the cell from[] + step[] [cells] are metal, as the
 * callback says; cell from[] itself is not tested. Tried are both sides of the line on each other axis, for each axis
 * of the largest step. A zero step gives 1. */
PDI_FN int pdi_node_visibility_has_staircase(const int *from, const int *step, pdi_node_visibility_is_metal_fn is_metal,
                                             const void *self);
#endif

#endif
