/* contour: lines of one value in a field on a two-dimensional lattice, by marching squares.
 *
 * Values stand in the middles of cells. Between four middles the field is bilinear; up to a cell without a value, and
 * to the edge of the lattice, it goes on linearly. So lines end at the face of such a cell and never enter it.
 */
#ifndef PD_CONTOUR_H
#define PD_CONTOUR_H
#include "core/config.h"

#ifdef PDI_INTERNAL
typedef struct pdi_contour {
    int nx, ny;
    const double *value; /* [nx * ny] [-], i to the right first; NaN: none */
} pdi_contour;

/* A piece of a line [cells] from the lower left corner of the lattice: from (a[0], a[1]) to (b[0], b[1]). */
typedef void (*pdi_contour_piece)(void *user, const double *a, const double *b);

/* All pieces of the lines of this level, cell by cell. */
PDI_FN void pdi_contour_lines(const pdi_contour *contour, double level, pdi_contour_piece piece, void *user);
#endif

#endif
