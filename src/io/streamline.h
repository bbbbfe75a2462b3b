/* streamline: evenly spaced streamlines of a velocity field on a two-dimensional grid (Jobard and Lefer 1997).
 *
 * Velocities at cell centres are interpolated bilinearly. At the face of a cell without fluid, and at a closed side,
 * the normal component is zero and the tangential one that of the cell, so that lines run along such faces and do not
 * cross them. A line starts at least the distance between lines from all others, beside one of them where there is
 * room. It ends at a side, where the fluid is at rest, and where it comes nearer than half of that distance to another
 * line or to itself. One thread computes all lines, one after another.
 */
#ifndef PD_STREAMLINE_H
#define PD_STREAMLINE_H
#include "core/base.h"

#ifdef PDI_APP_INTERNAL
/* A velocity field, and how its lines are spaced. */
typedef struct pdi_streamline_field {
    int nx, ny;         /* number of cells */
    const double *velocity[2]; /* [nx * ny] [m/s] velocity components, value j * nx + i of cell (i, j); NaN: no fluid */
    double cell_size[2];       /* [m] size of a cell */
    /* [pixel] size of a cell in the picture; all positions and distances below are in pixels */
    double pixel_size[2];
    double spacing;     /* [pixel] distance between lines */
    int side_closed[4]; /* 1: nothing flows through the side x-, x+, y-, y+ */
    int mirrored;       /* 1: lines are drawn below y = 0, too, and keep half the distance from there */
} pdi_streamline_field;

/* A line: a range of points. */
typedef struct pdi_streamline {
    int64_t first, count; /* first point, and number of points */
    int is_loop;          /* 1: a closed loop */
} pdi_streamline;

/* All lines of a field. Zero-initialise. */
typedef struct pdi_streamlines {
    int64_t count, capacity;         /* number of lines, and capacity */
    pdi_streamline *line;            /* [capacity] */
    int64_t point_count, point_capacity; /* number of points, and capacity */
    double *point;                       /* [point_capacity][2] [pixel] points of all lines, in flow direction */
} pdi_streamlines;

/* Velocity[2] at position[2] [pixel], bilinear between cell centres, scaled to the picture [pixel/s]. Beyond an open
 * side the outer cells go on; at a face without flow the normal component is 0. Returns 1; 0: the cell there has no
 * fluid, or it lies outside the grid, and velocity is unchanged. */
PDI_FN int pdi_streamline_interpolate_velocity(const pdi_streamline_field *stream, const double *position,
                                               double *velocity);
/* Largest speed of a cell [m/s], of the components at its centre; cells without fluid (NaN) are skipped. 0 without
 * any. */
PDI_FN double pdi_streamline_compute_max_speed(const pdi_streamline_field *stream);
/* Compute evenly spaced streamlines of a field, spacing > 0, into zeroed `lines`; none, and PD_OK, where nothing flows.
 * Fluid slower than 1e-4 of the largest speed in the picture is at rest. Free the lines also on failure. */
PDI_FN pd_status pdi_streamlines_compute(pd_ctx *ctx, const pdi_streamline_field *stream, pdi_streamlines *lines);
/* Free the lines. A zeroed set is allowed. */
PDI_FN void pdi_streamlines_free(pd_ctx *ctx, pdi_streamlines *lines);
#endif

#endif
