/* inlet: inflow boundary conditions: open part of each inlet side, its mean velocity and velocity profile, and the
 * concentration of what flows in. */
#ifndef PD_INLET_H
#define PD_INLET_H
#include "setup/setup.h"

/* Inlets of a setup on its lattice. Arrays are by side of the box. */
typedef struct pd_inlet {
    const pd_setup *setup;
    const pd_grid *grid;
    double time;                /* [s] time of boundary values here and in wall_bc.h; set by the solvers */
    int is_time_dependent;      /* 1: a boundary value depends on it */
    int inlets;                 /* number of inlet sides */
    double mean[2 * PD_DIM];    /* [m/s] into the box at time 0, 0 for other sides */
    double area[2 * PD_DIM];    /* [m2] area by which a flow rate is divided */
    double opening[2 * PD_DIM]; /* [m^(d-1)] of the opening; with rings of the whole ring */
    /* [-] area of the opening over that of its cell faces: factor on uniform profiles */
    double area_ratio[2 * PD_DIM];
    double scale[2 * PD_DIM];   /* [s/m] factor that, times the mean velocity, scales an expression to the flow rate
                                 * through the opening; 0 without a mean */
    double width[2 * PD_DIM];   /* [m] of the open part: 2H or 2R */
    double centre[2 * PD_DIM][PD_DIM]; /* [m] of the open part; axisymmetric: 0 */
    double inner_radius[2 * PD_DIM];   /* [m] axisymmetric: inner radius of an annulus, 0: a tube */
    int needs_profile[2 * PD_DIM];     /* 1: the developed profile has no closed form; developed_flow.h solves for it */
    double *profile[2 * PD_DIM]; /* [cells of the side] [-] that profile over its mean; NULL: not solved yet */
    int first;                  /* first inlet side, -1: none */
    int error_side;             /* side that was measured last, for error messages */
} pd_inlet;

#ifdef PDI_INTERNAL
/* Measure the open part of each inlet side with a profile and its mean velocity. PD_ERR_GEOMETRY: a side without open
 * nodes; a parabola where none develops (1D, solid in the opening, no walls); an expression with a mean that does not
 * flow in; then error_side alone is set, the rest is 0. setup and grid are borrowed; nothing is allocated. */
PDI_FN pd_status pdi_inlet_build(pd_ctx *ctx, const pd_setup *setup, const pd_grid *grid, pd_inlet *inlet);
/* Free the developed profiles. */
PDI_FN void pdi_inlet_free(pd_ctx *ctx, pd_inlet *inlet);
/* Number of cells in the layer inside a side of the box. */
PDI_FN int64_t pdi_inlet_count_side_cells(const pd_grid *grid, int side);
/* Mean inflow velocity [m/s] through a side at inlet->time, positive into the box; 0: the side is no inlet. */
PDI_FN double pdi_inlet_get_mean_velocity(const pd_inlet *inlet, int side);
/* Inflow velocity u [PD_DIM] [m/s] at place x [m] behind a side, of several the first; 0 in the box, and the mean while
 * a profile is not solved yet. Profiles: uniform (by area_ratio), expression, 2D parabola 3/2 U (1 - s^2), tube 2 U (1
 * - (r/R)^2), annulus (R1 < R2, k = R1/R2, s = r/R2): 2 U (1 - s^2 + a ln s)/(1 + k^2 - a), a = (1 - k^2)/ln(1/k)
 * (White, Viscous Fluid Flow, 3-3.3). A pd_velocity_fn; user is the pd_inlet. */
PDI_FN void pdi_inlet_get_velocity(void *user, const double *x, double *u);
/* Does the flow enter through a side at place x [m]? 1 or 0. On open sides by the sign of the initial velocity there, 0
 * where its normal component is 0; else 1 on inlet sides. A pd_is_inlet_fn; user is the pd_setup. */
PDI_FN int pdi_inlet_is_inflow(void *user, int side, const double *x);
/* Concentration [mol/m3] of the inflow at place x [m] on or behind a side, at inlet->time: that of the first such side
 * that has one of its own, else that of the setup for all inlets. A pd_point_fn; user is the pd_inlet. */
PDI_FN double pdi_inlet_get_concentration(void *user, const double *x);
/* Body force per mass, force [PD_DIM] [m/s2], at place x [m]. A pd_velocity_fn; user is the pd_inlet. */
PDI_FN void pdi_inlet_compute_body_force(void *user, const double *x, double *force);
#endif

#endif
