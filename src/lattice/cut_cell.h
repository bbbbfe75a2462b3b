/* cut_cell: cut cells: the fluid-wetted surface of walls and metal as planar pieces, cell by cell, and the open volume
 * of each cell.
 *
 * A smooth shape cuts cells: these are halved recursively and split into simplices in which the signed distance is
 * linear. Voxel masks, and metal that has receded by dissolution, have the faces of cells as surface. Neighbours cut
 * their common face alike, so the area vectors of all pieces of a closed body add up to zero, and those of a wall
 * between two planes to its openings in these, whatever the lattice (theory: eq. 5.1).
 */
#ifndef PD_CUT_CELL_H
#define PD_CUT_CELL_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* A planar piece of the wetted surface. */
typedef struct pdi_cut_cell_facet {
    double area[PD_DIM]; /* [m^(d-1); rings: m2] area vector, from the fluid into the wall */
    double centroid[PD_DIM]; /* [m] centroid */
    int32_t closed_node;     /* the piece is a cell face: the solid or wall node behind it; -1: on a smooth surface */
    int is_box_side;         /* 1: that face lies on a side of the box */
} pdi_cut_cell_facet;
/* Receives one piece of the surface, valid during the call. */
typedef void (*pdi_cut_cell_fn)(void *user, const pdi_cut_cell_facet *piece);
/* Returns the open (fluid) volume [m^d; rings: m3] of the cell of `node`, clipped to the box lo .. hi [m], and calls
 * `take` (may be NULL) for each surface piece in it and on its faces. 0 without pieces: nothing is left, or the cell is
 * closed as a whole; pieces on faces are those of the open side. A solid or wall node inside a smooth shape has a cut
 * cell, too. `node` lies in the box of the grid. */
PDI_FN double pdi_cut_cell_integrate(const pd_grid *grid, int32_t node, const double *lo, const double *hi,
                                     pdi_cut_cell_fn take, void *user);
/* Unsigned distance [m] of the node from the nearest smooth surface of metal or wall as the grid was built with, or a
 * lower bound; HUGE_VAL: there is none. */
PDI_FN double pdi_cut_cell_surface_distance(const pd_grid *grid, int32_t node);
/* Fraction of the volume of a node's cell that lies in the box lo .. hi [m], open or not, by lengths along the axes
 * (also on an axisymmetric grid); 0: they do not overlap. */
PDI_FN double pdi_cut_cell_overlap_fraction(const pd_grid *grid, int32_t node, const double *lo, const double *hi);
#endif

#endif
