/* inlet: prescribed velocity behind the inlets of a box: where a side is open, how wide, and the profile over it. */
#ifndef PD_INLET_H
#define PD_INLET_H
#include "scene/setup.h"

typedef struct pd_inlet {
    const pd_setup *setup;
    const pd_grid *grid;
    double time;                /* [s] for which the functions below, and those of walls, answer */
    int timed;                  /* 1: any of them depends on it */
    int inlets;
    double mean[2 * PD_DIM];    /* [m/s] into the box at time 0, 0 for other sides */
    double area[2 * PD_DIM];    /* [m2] that a flow_rate goes through */
    double fill[2 * PD_DIM];    /* [-] area of the opening over that of the open faces of cells, which a uniform speed
                                 * makes up for */
    double scale[2 * PD_DIM];   /* [s/m] times the mean it scales an expression, so that the area of the opening times
                                 * the mean passes the faces of cells; 0 without a mean */
    double width[2 * PD_DIM];   /* [m] of the open part: 2H or 2R */
    double centre[2 * PD_DIM][PD_DIM]; /* [m] of the open part; axisymmetric: 0 */
    double inner[2 * PD_DIM];   /* [m] axisymmetric, across the axis: least radius of the open part, 0: a tube */
    int develops[2 * PD_DIM];   /* 1: a parabola of no closed form, which `developed` finds */
    double *profile[2 * PD_DIM]; /* [cells of the side] [-] its speed over the mean; NULL: uniform until then */
    int first;                  /* first inlet side, -1: none */
    int latest;                 /* the side that was measured last: the one that the build refuses */
} pd_inlet;

#ifdef PDI_INTERNAL
/* Measure the open part of each inlet side of the grid. PD_ERR_GEOMETRY: a side without open nodes, a parabola where
 * nothing develops (solid in the opening, no walls), an expression with a mean that does not enter. setup and grid are
 * borrowed; nothing is allocated. */
PDI_FN pd_status pdi_inlet_build(pd_ctx *ctx, const pd_setup *setup, const pd_grid *grid, pd_inlet *inlet);
PDI_FN void pdi_inlet_free(pd_ctx *ctx, pd_inlet *inlet);
/* Cells of the layer inside a side. */
PDI_FN int64_t pdi_inlet_cells(const pd_grid *grid, int side);
/* Mean velocity [m/s] into the box through a side at inlet->time. */
PDI_FN double pdi_inlet_mean(const pd_inlet *inlet, int side);
/* A pd_velocity_fn; user is the pd_inlet. 2D parabola: 3/2 U (1 - s^2); tube: 2 U (1 - (r/R)^2); between
 * two tubes (R1 < R2, k = R1/R2, s = r/R2): 2 U (1 - s^2 + a ln s)/(1 + k^2 - a), a = (1 - k^2)/ln(1/k). */
PDI_FN void pdi_inlet_velocity(void *user, const double *x, double *u);
/* A pd_entry_fn, user being the pd_setup: where a given flow enters through open sides. */
PDI_FN int pdi_inlet_enters(void *user, int side, const double *x);
/* A pd_point_fn, user being the pd_inlet: the concentration [mol/m3] behind inlets and open sides. */
PDI_FN double pdi_inlet_entering(void *user, const double *x);
/* A pd_velocity_fn, user being the pd_inlet: the body force [m/s2] that is no constant. */
PDI_FN void pdi_inlet_body(void *user, const double *x, double *force);
#endif

#endif
