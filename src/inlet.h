/* inlet: prescribed velocity behind the inlets of a box: where a side is open, how wide, and the profile over it. */
#ifndef PD_INLET_H
#define PD_INLET_H
#include "setup.h"

typedef struct pd_inlet {
    const pd_setup *setup;
    int inlets;
    double mean[2 * PD_DIM];    /* [m/s] into the box, 0 for other sides */
    double width[2 * PD_DIM];   /* [m] of the open part: 2H or 2R */
    double centre[2 * PD_DIM][PD_DIM]; /* [m] of the open part; axisymmetric: 0 */
    double inner[2 * PD_DIM];   /* [m] axisymmetric, across the axis: least radius of the open part, 0: a tube */
    int first;                  /* first inlet side, -1: none */
    int latest;                 /* the side that was measured last: the one that the build refuses */
} pd_inlet;

#define pd_inlet_build PD_NAME(pd_inlet_build)
#define pd_inlet_velocity PD_NAME(pd_inlet_velocity)
#define pd_inlet_enters PD_NAME(pd_inlet_enters)
#define pd_inlet_entering PD_NAME(pd_inlet_entering)

/* Measure the open part of each inlet side of the grid. PD_ERR_GEOMETRY: a side without open nodes, a parabola where no
 * parabola fits (two openings, a rectangular duct, solid in the opening). setup is borrowed; nothing is allocated. */
PD_API pd_status pd_inlet_build(pd_ctx *ctx, const pd_setup *setup, const pd_grid *grid, pd_inlet *inlet);
/* A pd_velocity_fn; user is the pd_inlet. 2D parabola: 3/2 U (1 - s^2); tube: 2 U (1 - (r/R)^2); between
 * two tubes (R1 < R2, k = R1/R2, s = r/R2): 2 U (1 - s^2 + a ln s)/(1 + k^2 - a), a = (1 - k^2)/ln(1/k). */
PD_API void pd_inlet_velocity(void *user, const double *x, double *u);
/* A pd_entry_fn and a pd_point_fn, user being the pd_setup: where a given flow enters through open sides, and the
 * concentration [mol/m3] behind inlets and open sides. */
PD_API int pd_inlet_enters(void *user, int side, const double *x);
PD_API double pd_inlet_entering(void *user, const double *x);

#endif
