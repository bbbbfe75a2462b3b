/* wetted: the surface of walls and metal as planar pieces, cell by cell, and what they leave of each cell.
 *
 * A smooth shape cuts cells: where it does they are halved, and in simplices of the parts the signed distance is
 * linear. What has no smooth surface, and metal that has receded, has faces of cells. Neighbours cut their common face
 * alike, so the areas of all pieces of a closed body add up to zero, and those of a wall between two planes to the
 * openings in these, whatever the lattice (theory: eq. 4.27).
 */
#ifndef PD_WETTED_H
#define PD_WETTED_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
typedef struct pdi_wetted_piece {
    double area[PD_DIM]; /* [m^(d-1); rings: m2] towards the wall */
    double x[PD_DIM];    /* [m] its middle */
    int32_t closed;      /* the closed node behind a face of the cell; -1: a piece of a smooth surface */
    int side;            /* 1: that face is one of a side of the box */
} pdi_wetted_piece;
typedef void (*pdi_wetted_fn)(void *user, const pdi_wetted_piece *piece);
/* Hands the pieces of the cell of `node`, which lies in the box, between lo and hi [m] to `take` (NULL: to nobody).
 * Volume [m^d; rings: m3] that is open there. */
PDI_FN double pdi_wetted_cell(const pd_grid *grid, int32_t node, const double *lo, const double *hi, pdi_wetted_fn take,
                              void *user);
/* [m] No smooth surface comes nearer to the node; HUGE_VAL: there is none. */
PDI_FN double pdi_wetted_clear(const pd_grid *grid, int32_t node);
/* Share of a cell's volume that lies between lo and hi. */
PDI_FN double pdi_wetted_overlap(const pd_grid *grid, int32_t node, const double *lo, const double *hi);
#endif

#endif
