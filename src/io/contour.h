/* contour: contour lines of a cell-centred field on a two-dimensional grid, by marching squares.
 *
 * Between four cell centres the field is interpolated bilinearly; towards a cell without a value, and towards the edge
 * of the grid, it is extrapolated linearly. So lines end at the face of a cell without a value and never enter it.
 */
#ifndef PD_CONTOUR_H
#define PD_CONTOUR_H
#include "core/config.h"

#ifdef PDI_APP_INTERNAL
/* The field. */
typedef struct pdi_contour {
    int nx, ny;
    const double *value; /* [nx * ny] [-] at cell centres, value[j * nx + i]; NaN: no value */
} pdi_contour;

/* Callback for a segment of a contour line from a[2] to b[2], in units of cells from the lower left corner of the
 * grid. */
typedef void (*pdi_contour_segment_fn)(void *user, const double *a, const double *b);

/* Call add_segment(user, a, b) for all segments of the contour lines of this level, in the unit of the values; quarter
 * cell by quarter cell, not in order along a line. Values equal to the level count as above it. Cells of NaN have none,
 * nor has a level of NaN. */
PDI_FN void pdi_contour_find_segments(const pdi_contour *contour, double level, pdi_contour_segment_fn add_segment,
                                      void *user);
#endif

#endif
