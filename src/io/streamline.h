/* streamline: evenly spaced lines along a velocity on a two-dimensional lattice (Jobard and Lefer 1997).
 *
 * Velocities stand in the middles of cells and are bilinear between them. At the face of a cell where nothing flows,
 * and at a closed side, the component across is zero and the component along goes on. So a line runs along such a face
 * and does not pass it. A line begins at least `apart` from all others, beside one of them where there is room. It ends
 * at a side, where the fluid is at rest, and where it comes nearer than half of `apart` to another line or to itself.
 * One thread finds all lines, each from those before it.
 */
#ifndef PD_STREAMLINE_H
#define PD_STREAMLINE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef struct pdi_stream {
    int nx, ny;
    const double *u[2]; /* [nx * ny] [m/s] along both axes, the first one to the right first; NaN: nothing flows */
    double cell[2];     /* [m] of a cell */
    double size[2];     /* the same on paper; all places and distances below are in its unit */
    double apart;       /* between lines */
    int closed[4];      /* 1: nothing passes the side x-, x+, y-, y+ */
    int mirrored;       /* 1: lines are drawn below y = 0, too, and keep half the distance from there */
} pdi_stream;

typedef struct pdi_streamline {
    int64_t first, count; /* of its points */
    int closed;           /* 1: it ends where it begins */
} pdi_streamline;

/* Zero-initialise. */
typedef struct pdi_streamlines {
    int64_t count, room;             /* lines */
    pdi_streamline *line;            /* [room] */
    int64_t points, point_room;
    double *at;                      /* [point_room][2] in the sense of the flow */
} pdi_streamlines;

/* Velocity at a place; 0: nothing flows there, or it lies outside. */
PDI_FN int pdi_stream_velocity(const pdi_stream *stream, const double *at, double *velocity);
/* Largest speed of a cell [m/s], 0 without any. */
PDI_FN double pdi_stream_fastest(const pdi_stream *stream);
PDI_FN pd_status pdi_streamlines_find(pd_ctx *ctx, const pdi_stream *stream, pdi_streamlines *lines);
PDI_FN void pdi_streamlines_free(pd_ctx *ctx, pdi_streamlines *lines);
#endif

#endif
