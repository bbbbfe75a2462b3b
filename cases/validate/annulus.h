/* annulus: cases about a wire on the axis of a tube, axisymmetric. */
#ifndef VAL_ANNULUS_H
#define VAL_ANNULUS_H
#if PD_DIM == 2

/* The gap and the mean speed are 1; radii are those of the wire and of the tube. */
#define ANNULUS_NU 0.1 /* [m2/s] */
#define ANNULUS_D 0.02 /* [m2/s]: U Dh/D = 100 with Dh twice the gap */
/* [m] cells along the axis over those across, and length of the mass exchange in gaps: 0.1 Dh Pe. */
#define ANNULUS_STRETCH 4
#define ANNULUS_LENGTH 20.0

/* One line of annulus_flow.csv. */
typedef struct annulus_kind {
    double kappa, over_mean, sherwood; /* largest over mean speed; Sh_inner_fd_Dh */
} annulus_kind;

static const annulus_kind annulus_kinds[2] = {{0.1, 1.567307, 11.55912}, {0.2, 1.537394, 8.12958}};

/* level.p is kappa. */
static const annulus_kind *annulus_of(const val_job *job)
{
    return &annulus_kinds[job->level.p > 0.15];
}

static double annulus_outer(double kappa) { return 1.0 / (1.0 - kappa); }

/* Mean speed 1; user: kappa. */
static double annulus_speed(double kappa, double r)
{
    double s = r / annulus_outer(kappa), a = (1.0 - kappa * kappa) / log(1.0 / kappa);
    return s > kappa && s < 1.0 ? 2.0 * (1.0 - s * s + a * log(s)) / (1.0 + kappa * kappa - a) : 0.0;
}

static void annulus_profile(void *user, const double *x, double *u)
{
    u[0] = annulus_speed(*(const double *)user, x[1]);
    u[1] = 0.0;
}

/* c = 0 on the wire, no flux into the tube. */
static double annulus_held(void *user, const double *x)
{
    return x[1] < *(const double *)user ? 0.0 : (double)NAN;
}

/* The wire is a solid, the tube a wall; neither lies on faces of cells. */
static void annulus_lab(val_job *job, double length, double along, double *kappa)
{
    val_lab *lab = job->lab;
    double h = 1.0 / job->level.n, outer = annulus_outer(*kappa);
    lab_box(lab, h, job->level.m, 0.0, h * ceil(outer / h - 1e-9));
    lab->stencil_desc.h[0] = along;
    lab->grid_desc.hi[0] = along * ceil(length / along - 1e-9);
    lab->grid_desc.axisymmetric = 1;
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.side[1] = PD_SIDE_OUTLET;
    lab->grid_desc.side[2] = PD_SIDE_MIRROR;
    lab->grid_desc.solid = &lab->shapes[0];
    lab->grid_desc.wall = &lab->shapes[2];
    lab->shapes[0].type = lab->shapes[1].type = PD_SHAPE_CYLINDER;
    lab->shapes[0].radius = *kappa * outer;
    lab->shapes[1].radius = outer;
    lab->shapes[2].type = PD_SHAPE_COMPLEMENT;
    lab->shapes[2].child[0] = 1;
    lab->shapes[2].child_count = 1;
    enclosed_fluid(lab, 1.0);
    lab->flow_desc.mu = ANNULUS_NU * lab->flow_desc.rho;
    lab->flow_desc.inlet = annulus_profile;
    lab->flow_desc.developed_sides = 1; /* side x- */
    lab->flow_desc.inlet_user = kappa;
    lab->steady_desc.tolerance = 1e-9;
    job->out->h = h;
}

static pd_status annulus_flow_run(val_job *job)
{
    val_lab *lab = job->lab;
    double kappa = annulus_of(job)->kappa, most = 0.0;
    val_squares sum = {0.0, 0.0};
    annulus_lab(job, 1.0, 1.0 / job->level.n, &kappa);
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PD_TRY(flow_solve(job));
    val_curve *exact = job->profile ? val_add_curve(job, "closed form", PD_SERIES_STYLE_LINE) : NULL;
    val_curve *found = job->profile ? val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS) : NULL;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        int at[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        pd_grid_index(&lab->grid, i, at);
        double u = annulus_speed(kappa, x[1]);
        val_squares_add(&sum, x[1], lab->flow.u[i], u);
        val_squares_add(&sum, x[1], lab->flow.u[lab->grid.total + i], 0.0);
        most = fmax(most, lab->flow.u[i]);
        if (!exact || at[0] != lab->grid.n[0] / 2) continue;
        val_add_point(exact, x[1], u);
        val_add_point(found, x[1], lab->flow.u[i]);
    }
    if (job->profile) {
        job->profile->title = kappa < 0.15 ? "Flow between a wire and a tube, kappa = 0.1"
                                            : "Flow between a wire and a tube, kappa = 0.2";
        job->profile->x_label = "r [gaps]";
        job->profile->y_label = "u/U [-]";
    }
    job->out->err[0] = val_squares_l2(&sum);
    job->out->err[1] = fabs(most / annulus_of(job)->over_mean - 1.0);
    return PD_OK;
}

/* Sherwood number of column `at` of cells. */
static double annulus_column(const val_lab *lab, double inner, int at)
{
    return exchange_column(lab, at) / (2.0 * val_pi * inner) * 2.0 / ANNULUS_D;
}

static pd_status annulus_sherwood_run(val_job *job)
{
    val_lab *lab = job->lab;
    double kappa = annulus_of(job)->kappa, inner = kappa * annulus_outer(kappa), wire = inner + 0.1;
    pd_transport_result result;
    annulus_lab(job, ANNULUS_LENGTH, (double)ANNULUS_STRETCH / job->level.n, &kappa);
    lab->transport_desc.diffusivity = ANNULUS_D;
    lab->transport_desc.held = annulus_held;
    lab->transport_desc.user = &wire;
    lab->transport_desc.inlet = lab->transport_desc.initial = 1.0;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    exchange_stream(job->ctx, lab);
    PD_TRY(pd_transport_steady(job->ctx, &lab->transport, &result));
    job->out->err[1] = result.change;
    int last = lab->grid.n[0] * 9 / 10;
    job->out->err[0] = fabs(annulus_column(lab, inner, last) / annulus_of(job)->sherwood - 1.0);
    if (!job->profile) return PD_OK;
    job->profile->title = kappa < 0.15 ? "Local Sherwood number of the wire, kappa = 0.1"
                                       : "Local Sherwood number of the wire, kappa = 0.2";
    job->profile->x_label = "x D/(U Dh^2) [-]";
    job->profile->y_label = "Sherwood number on Dh [-]";
    job->profile->x_log = job->profile->y_log = 1;
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_LINE);
    val_curve *exact = val_add_curve(job, "fully developed", PD_SERIES_STYLE_MARKERS);
    for (int at = 1; at <= last; at++)
        val_add_point(found, (at + 0.5) * lab->grid.h[0] * ANNULUS_D / 4.0, annulus_column(lab, inner, at));
    val_add_point(exact, (last + 0.5) * lab->grid.h[0] * ANNULUS_D / 4.0, annulus_of(job)->sherwood);
    return PD_OK;
}

#define ANNULUS_FLOW_PART(name, title, kappa, quick, guard, miss) \
    {name, title, "cells in the gap", VAL_BY_N, NULL, 2.0, {{"err_l2", "u, L2"}, {"err_max", "largest u"}}, 2, \
     {{0, 1e-4, 0.0, 40, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GOAL_OF_ALL}, {0, guard, 0.0, 0, VAL_GUARD}}, 3, \
     {{20, 1.0, kappa}, {40, 1.0, kappa}, {80, 1.0, kappa}}, 3, quick, annulus_flow_run, miss}
#define ANNULUS_SHERWOOD_PART(name, title, kappa) \
    {name, title, "cells in the gap", VAL_BY_N, NULL, 2.0, \
     {{"err_rel", "Sherwood number"}, {"change", "change of the last step"}}, 2, \
     {{0, 1e-2, 0.0, 40, VAL_GOAL}, {0, 0.1, 0.0, 0, VAL_GUARD}}, 2, \
     {{20, 1.0, kappa}, {40, 1.0, kappa}, {80, 1.0, kappa}}, 3, 2, annulus_sherwood_run, NULL}

static const val_part annulus_flow_1 = ANNULUS_FLOW_PART("flow_01", "flow, kappa = 0.1", 0.1, 1, 4e-3, NULL);
static const val_part annulus_flow_2 = ANNULUS_FLOW_PART("flow_02", "flow, kappa = 0.2", 0.2, 2, 5e-4, NULL);
static const val_part annulus_sherwood_1 = ANNULUS_SHERWOOD_PART("sherwood_01", "exchange, kappa = 0.1", 0.1);
static const val_part annulus_sherwood_2 = ANNULUS_SHERWOOD_PART("sherwood_02", "exchange, kappa = 0.2", 0.2);
static const val_part *const annulus_parts[] = {&annulus_flow_1, &annulus_flow_2, &annulus_sherwood_1,
                                                &annulus_sherwood_2};

static const val_case annulus_case = {
    "annulus", "A wire on the axis of a tube",
    "Axisymmetric: steady flow from rest between a wire of radius kappa R and a tube of radius R, Re = 10 on the gap, "
    "to a residual of 1e-9; and a stream with that profile which meets a wire that holds c = 0 (U Dh/D = 100, cells "
    "four times as long as high, Sherwood number at 0.09 Dh^2 U/D). At kappa = 0.1 neither surface lies on faces of "
    "cells.",
    "A plane section passed off as a tube, radii left out of a flux, curvature of walls, weights at the axis.",
    "closed form and eigenvalue: the table `annulus_flow.csv`",
    annulus_parts, 4};

#endif
#endif
