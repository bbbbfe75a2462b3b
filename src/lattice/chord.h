/* chord: whether the straight line between two metal nodes of a grid stays in the metal.
 *
 * By the smooth surface of the metal, where it has one: the line leaves the metal where it is outside the shape over
 * any length, however thin the gap. By cells, where the shape is a mask of voxels or metal has dissolved: flat faces
 * that are inclined against the lattice are stairs, which the line between two nodes of a half-space may cross. So a
 * line stays in metal where one of the staircases of cells along it does: of each axis across the longest one of the
 * line, a staircase has all cells at the line or below it, or all at the line or above it, and its cells share faces. A
 * half-space that holds both ends holds each staircase on its inner side: if n points outwards, and all n_d of an axis
 * across are at least 0, cells below the line have a lesser n x than the line. So lines of a half-space stay, whatever
 * its normal. Metal on two sides of a gap that no staircase of faces crosses (one that is a cell wide, or wider) has no
 * line across.
 */
#ifndef PD_CHORD_H
#define PD_CHORD_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* 1: the metal is convex and no wall is in it, so no line leaves it. */
PDI_FN int pdi_chord_convex(const pd_grid *grid);
/* 1: its surface is smooth. */
PDI_FN int pdi_chord_smooth(const pd_grid *grid);
/* Signed distance [m] of place x from the smooth surface of the metal of the start, negative inside, or a bound of it.
 */
PDI_FN double pdi_chord_level(const pd_grid *grid, const double *x);
/* 1: the line x + t xi, 0 <= t <= 1, stays within the smooth surface, or on it. */
PDI_FN int pdi_chord_within(const pd_grid *grid, const double *x, const double *xi);
/* 1: `metal` says so of all cells of one of the staircases between cell from[] and the one step[] cells on. */
typedef int (*pdi_chord_fn)(const void *self, const int *cell);
PDI_FN int pdi_chord_stairs(const int *from, const int *step, pdi_chord_fn metal, const void *self);
#endif

#endif
