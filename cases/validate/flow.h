/* flow: cases about the steady flow. */
#ifndef VAL_FLOW_H
#define VAL_FLOW_H
#if PD_DIM > 1

#define FLOW_HALF 150e-6 /* [m] half-width of the channel, radius of the tube */
#define FLOW_RHO 1000.0  /* [kg/m3] */
#define FLOW_MU 1e-3     /* [Pa s] */

/* Fully developed flow of mean speed *user [m/s]: a parabola between plates, a paraboloid in a tube. */
static void flow_profile(void *user, const double *x, double *u)
{
    double r2 = 0.0;
    for (int d = 1; d < PD_DIM; d++) {
        r2 += x[d] * x[d] / (FLOW_HALF * FLOW_HALF);
        u[d] = 0.0;
    }
    u[0] = *(const double *)user * (PD_DIM == 3 ? 2.0 : 1.5) * fmax(1.0 - r2, 0.0);
}

/* Channel or tube along x from lo to hi [m], inlet at x-, outlet at x+. *mean [m/s] must live as long as the lab. */
static void flow_channel(val_lab *lab, double h, double m, double lo, double hi, double *mean, double tolerance)
{
    lab_box(lab, h, m, -FLOW_HALF, FLOW_HALF);
    lab->grid_desc.lo[0] = lo;
    lab->grid_desc.hi[0] = hi;
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.side[1] = PD_SIDE_OUTLET;
    lab->flow_desc.rho = FLOW_RHO;
    lab->flow_desc.mu = FLOW_MU;
    lab->flow_desc.report_speed = *mean;
    lab->flow_desc.report_length = 2.0 * FLOW_HALF;
    lab->flow_desc.inlet = flow_profile;
    lab->flow_desc.developed_sides = 1; /* side x- */
    lab->flow_desc.inlet_user = mean;
    lab->steady_desc.tolerance = tolerance;
}

/* Solve and note what it took. Not to converge is a failure here. */
static pd_status flow_solve(val_job *job)
{
    pd_steady_result result;
    PD_TRY(pd_steady_solve(job->ctx, &job->lab->steady, &result));
    job->out->residual = fmax(result.momentum, result.continuity);
    job->out->evals = (long)result.evaluations;
    job->out->steps = result.newton;
    if (result.converged) return PD_OK;
    return pd_fail(job->ctx, PD_ERR_DIVERGED, "validate", "the flow is not steady: residual %.3g after %d steps",
                   job->out->residual, result.newton);
}

/* Relative L2 difference of the velocity from the profile, and relative error of dp/dx: the slope of the straight line
 * of least squares through the pressures of all fluid nodes. */
static void flow_errors(val_job *job, double exact_slope, double *velocity, double *slope)
{
    const val_lab *lab = job->lab;
    const pd_grid *grid = &lab->grid;
    double count = 0.0, sx = 0.0, sp = 0.0, sxx = 0.0, sxp = 0.0;
    double middle = 0.5 * (grid->lo[0] + grid->hi[0]);
    val_squares sum = {0.0, 0.0};
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (grid->kind[i] != PD_FLUID) continue;
        pd_grid_position(grid, i, x);
        flow_profile(lab->flow_desc.inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++)
            val_squares_add(&sum, 1.0, lab->flow.u[(int64_t)d * grid->total + i], u[d]);
        count += 1.0;
        sx += x[0] - middle;
        sp += FLOW_RHO * lab->flow.p[i];
        sxx += (x[0] - middle) * (x[0] - middle);
        sxp += (x[0] - middle) * FLOW_RHO * lab->flow.p[i];
    }
    *velocity = val_squares_l2(&sum);
    *slope = fabs((count * sxp - sx * sp) / (count * sxx - sx * sx) / exact_slope - 1.0);
}

/* Velocity and reference across the channel at mid-length, on the row of nodes next to the axis. */
static void flow_curves(val_job *job, const char *title)
{
    const val_lab *lab = job->lab;
    if (!job->profile) return;
    job->profile->title = title;
    job->profile->x_label = "y [um]";
    job->profile->y_label = "u [m/s]";
    val_curve *exact = val_add_curve(job, "closed form", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    int i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) i[d] = lab->grid.n[d] / 2;
    for (i[PD_DIM - 1] = 0; i[PD_DIM - 1] < lab->grid.n[PD_DIM - 1]; i[PD_DIM - 1]++) {
        double x[PD_DIM], u[PD_DIM];
        int32_t node = pd_grid_node(&lab->grid, i);
        if (lab->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, node, x);
        flow_profile(lab->flow_desc.inlet_user, x, u);
        val_add_point(exact, 1e6 * x[PD_DIM - 1], u[0]);
        val_add_point(found, 1e6 * x[PD_DIM - 1], lab->flow.u[node]);
    }
}

#define FLOW_ERRORS {{"err_l2", "u, L2"}, {"err_dpdx", "dp/dx"}}, 2

#if PD_DIM == 2

/* ---- poiseuille ---- */

static pd_status poiseuille_run(val_job *job)
{
    double mean = 0.01; /* [m/s] */
    flow_channel(job->lab, 2.0 * FLOW_HALF / job->level.n, job->level.m, 0.0, 4.0 * FLOW_HALF, &mean, 1e-8);
    PD_TRY(lab_build(job->ctx, job->lab, VAL_FLOW | VAL_STEADY));
    PD_TRY(flow_solve(job));
    job->out->h = job->lab->grid.h[0];
    flow_errors(job, -3.0 * FLOW_MU * mean / (FLOW_HALF * FLOW_HALF), &job->out->err[0], &job->out->err[1]);
    flow_curves(job, "Plane Poiseuille flow, 2D");
    return PD_OK;
}

static const val_part poiseuille_across = {
    "across", "nearest neighbours", "nodes across", VAL_BY_N, NULL, 0.0, FLOW_ERRORS,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-6, 0.0, 0, VAL_GOAL}}, 2,
    {{15, 1.0, 0.0}, {30, 1.0, 0.0}, {60, 1.0, 0.0}}, 3, 2, poiseuille_run, NULL};
static const val_part poiseuille_horizons = {
    "horizons", "other horizons", "m", VAL_BY_M, "m", 0.0, FLOW_ERRORS,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-6, 0.0, 0, VAL_GOAL}}, 2,
    {{60, 2.0, 0.0}, {60, 3.0, 0.0}, {60, 4.0, 0.0}}, 3, 0, poiseuille_run, NULL};
static const val_part *const poiseuille_parts[] = {&poiseuille_across, &poiseuille_horizons};

static const val_case poiseuille_case = {
    "poiseuille", "Flow between plates",
    "Steady flow from rest between plates, from an inlet with the parabola to a pressure outlet, Re = 3, to a residual "
    "of 1e-8. The length is two widths.",
    "Walls of first order, uncalibrated viscosity, an inlet or outlet that disturbs the profile, a steady test on "
    "changes instead of residuals.",
    "closed form: u = 3/2 U (1 - (y/H)^2), dp/dx = -3 mu U/H^2",
    poiseuille_parts, 2};

/* ---- flux ---- */

/* Bond flux through the middle of the free lengths before and behind the pin, and the fluxes of all layers of nodes
 * against the upstream one. */
static void flux_errors(val_job *job)
{
    val_lab *lab = job->lab;
    int first = lab->grid.n[0], last = -1, axis[PD_DIM];
    for (axis[0] = 0; axis[0] < lab->grid.n[0]; axis[0]++) {
        axis[1] = lab->grid.n[1] / 2;
        if (lab->grid.kind[pd_grid_node(&lab->grid, axis)] != PD_SOLID) continue;
        first = axis[0] < first ? axis[0] : first;
        last = axis[0];
    }
    int up = first / 2, down = (last + 1 + lab->grid.n[0]) / 2;
    double before = pd_flow_integrate_section(job->ctx, &lab->flow, 0, up);
    double layer_up = pdi_flow_integrate_nodal_section(&lab->flow, 0, up);
    job->out->err[0] = fabs(pd_flow_integrate_section(job->ctx, &lab->flow, 0, down) / before - 1.0);
    val_curve *layers = val_add_curve(job, "layers of nodes", PD_SERIES_STYLE_LINE);
    val_curve *bonds = val_add_curve(job, "bonds (conserved)", PD_SERIES_STYLE_DASHED);
    for (int k = 0; k < lab->grid.n[0]; k++) {
        double layer = pdi_flow_integrate_nodal_section(&lab->flow, 0, k), x = lab->grid.lo[0] + k * lab->grid.h[0];
        job->out->err[1] = fmax(job->out->err[1], fabs(layer / layer_up - 1.0));
        val_add_point(layers, 1e6 * (x + 0.5 * lab->grid.h[0]), layer / layer_up);
        if (k > 0) val_add_point(bonds, 1e6 * x, pd_flow_integrate_section(job->ctx, &lab->flow, 0, k) / before);
    }
}

/* The pin of the Mg-pin scene: 80 um x 400 um in a channel 300 um wide, 500 um of free length at both ends. Its ends
 * are square or, with level.p = 1, half-discs. */
static pd_status flux_run(val_job *job)
{
    double mean = 0.236, um = 1e-6; /* [m/s] [m] */
    double cap = job->level.p * 40.0 * um;
    val_lab *lab = job->lab;
    flow_channel(lab, 300.0 * um / job->level.n, job->level.m, -500.0 * um, 900.0 * um, &mean, 1e-8);
    lab->grid_desc.solid = &lab->shapes[3];
    lab->shapes[0].type = PD_SHAPE_BOX;
    lab->shapes[0].a[0] = cap;
    lab->shapes[0].a[1] = -40.0 * um;
    lab->shapes[0].b[0] = 400.0 * um - cap;
    lab->shapes[0].b[1] = 40.0 * um;
    for (int end = 1; end < 3; end++) {
        lab->shapes[end].type = PD_SHAPE_BALL;
        lab->shapes[end].radius = 40.0 * um;
        lab->shapes[end].a[0] = end == 1 ? cap : 400.0 * um - cap;
    }
    lab->shapes[3].type = PD_SHAPE_UNION;
    lab->shapes[3].child_count = cap > 0.0 ? 3 : 1;
    for (int k = 0; k < 3; k++) lab->shapes[3].child[k] = k;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PD_TRY(flow_solve(job));
    job->out->h = lab->grid.h[0];
    if (job->profile) {
        job->profile->title = "Flux along the channel over the flux upstream";
        job->profile->x_label = "x [um]";
        job->profile->y_label = "flux [-]";
    }
    flux_errors(job);
    return PD_OK;
}

static const val_part flux_part = {
    "", "", "nodes across", VAL_BY_N, NULL, 1.544, {{"flux", "far down against far up"}, {"flux_max", "largest"}}, 2,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 60, VAL_GOAL}, {1, 0.0, 1.8, 30, VAL_GOAL},
     {1, 2.5e-2, 0.0, 0, VAL_GUARD}}, 4,
    {{30, 1.0, 0.0}, {60, 1.0, 0.0}, {120, 1.0, 0.0}}, 3, 1, flux_run,
    "The flux of bonds, which the scheme conserves, is equal to rounding everywhere. The sum of node velocities over a "
    "layer is a midpoint rule for the flux, and at the edges of the pin, solid angles of 90 degrees, the velocity "
    "grows as r^0.544 with the distance (H. K. Moffatt, J. Fluid Mech. 18, 1964). A midpoint rule is of order 1.544 "
    "there, and 1.54 is found, in the layers at the leading edges. Second order cannot be had there on equal spacings; "
    "with round ends it is there."};
static const val_part flux_round = {
    "round", "round ends", "nodes across", VAL_BY_N, NULL, 2.0,
    {{"flux", "far down against far up"}, {"flux_max", "largest"}}, 2,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 60, VAL_GOAL}, {1, 0.0, 1.8, 60, VAL_GOAL},
     {1, 2.5e-2, 0.0, 0, VAL_GUARD}}, 4,
    {{30, 1.0, 1.0}, {60, 1.0, 1.0}, {120, 1.0, 1.0}}, 3, 1, flux_run, NULL};
static const val_part *const flux_parts[] = {&flux_part, &flux_round};

static const val_case flux_case = {
    "flux", "Flux past a pin",
    "Steady flow past a pin of 80 um x 400 um in a channel 300 um wide, Re = 71, to a residual of 1e-8, with square "
    "and with round ends. The flux far "
    "downstream against that far upstream of the pin, both of bonds (what the scheme conserves), 250 um from the pin "
    "and from the ends; and the largest deviation of a layer of nodes from the upstream layer.",
    "A pin that swallows flow, continuity that does not come in fluxes of bonds, walls that leak, a flow that is not "
    "steady.",
    "conservation of mass",
    flux_parts, 2};

#endif

#if PD_DIM == 3

/* ---- hagen ---- */

/* A tube one radius long; slow, Re = 3. */
static pd_status hagen_run(val_job *job)
{
    double mean = 0.01; /* [m/s] */
    val_lab *lab = job->lab;
    flow_channel(lab, FLOW_HALF / job->level.n, job->level.m, 0.0, FLOW_HALF, &mean, 1e-8);
    lab->shapes[0].type = PD_SHAPE_CYLINDER;
    lab->shapes[0].radius = FLOW_HALF;
    lab->shapes[1].type = PD_SHAPE_COMPLEMENT;
    lab->shapes[1].child_count = 1;
    lab->grid_desc.wall = &lab->shapes[1];
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PD_TRY(flow_solve(job));
    job->out->h = lab->grid.h[0];
    flow_errors(job, -8.0 * FLOW_MU * mean / (FLOW_HALF * FLOW_HALF), &job->out->err[0], &job->out->err[1]);
    flow_curves(job, "Hagen-Poiseuille flow, 3D");
    return PD_OK;
}

static const val_part hagen_part = {
    /* an exact discrete solution: what is left is the residual, and has no order */
    "", "", "R/h", VAL_BY_N, NULL, 0.0, FLOW_ERRORS, {{0, 5e-3, 0.0, 20, VAL_GOAL}, {0, 1e-9, 0.0, 0, VAL_GUARD}}, 2,
    {{8, 1.0, 0.0}, {12, 1.0, 0.0}, {16, 1.0, 0.0}, {20, 1.0, 0.0}}, 4, 2, hagen_run, NULL};
static const val_part *const hagen_parts[] = {&hagen_part};

/* ---- duct ---- */

/* Square duct of side 1, force 1 and viscosity 1: the series of White, Viscous Fluid Flow, eq. 3.48. */
static double duct_speed(double y, double z)
{
    double u = 0.0;
    for (int k = 1; k < 200; k += 2) {
        /* cosh(k pi (z - 1/2))/cosh(k pi/2) without large numbers; z and 1 - z alike */
        double near = exp(-k * val_pi * z) + exp(-k * val_pi * (1.0 - z));
        double part = 1.0 - near / (1.0 + exp(-k * val_pi));
        u += 4.0 / (k * k * k * val_pi * val_pi * val_pi) * sin(k * val_pi * y) * part;
    }
    return u;
}

/* 4 x n x n cells, periodic along x; from rest. */
static pd_status duct_run_order(val_job *job, int order)
{
    val_lab *lab = job->lab;
    lab->flow_desc.order = order;
    double h = 1.0 / job->level.n;
    val_squares sum = {0.0, 0.0};
    lab_box(lab, h, job->level.m, 0.0, 1.0);
    lab->grid_desc.hi[0] = 4.0 * h;
    lab->grid_desc.side[0] = lab->grid_desc.side[1] = PD_SIDE_PERIODIC;
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_length = lab->flow_desc.force[0] = 1.0;
    lab->flow_desc.report_speed = 0.07; /* the largest is 0.0737 */
    lab->steady_desc.tolerance = 1e-9;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PD_TRY(flow_solve(job));
    val_curve *exact = job->profile ? val_add_curve(job, "series", PD_SERIES_STYLE_LINE) : NULL;
    val_curve *found = job->profile ? val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS) : NULL;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        int at[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        pd_grid_index(&lab->grid, i, at);
        double u = duct_speed(x[1], x[2]);
        val_squares_add(&sum, 1.0, lab->flow.u[i], u);
        job->out->err[1] = fmax(job->out->err[1], fabs(lab->flow.u[i] - u) / 0.07367);
        if (!exact || at[0] || at[2] != lab->grid.n[2] / 2) continue;
        val_add_point(exact, x[1], u);
        val_add_point(found, x[1], lab->flow.u[i]);
    }
    job->out->h = h;
    job->out->err[0] = val_squares_l2(&sum);
    if (!job->profile) return PD_OK;
    job->profile->title = "Flow through a square duct, beside the middle";
    job->profile->x_label = "y/H [-]";
    job->profile->y_label = "u nu/(f H^2) [-]";
    return PD_OK;
}

static pd_status duct_run(val_job *job)
{
    return duct_run_order(job, job->lab->flow_desc.order ? job->lab->flow_desc.order : PD_FLOW_ORDER_AUTO);
}
static pd_status duct_run_second(val_job *job) { return duct_run_order(job, 2); }

static const val_part duct_part = {
    "", "", "nodes across", VAL_BY_N, NULL, 4.0, {{"err_l2", "u, L2"}, {"err_max", "u, largest"}}, 2,
    {{0, 5e-5, 0.0, 64, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GOAL_OF_ALL}, {0, 5e-3, 0.0, 0, VAL_GUARD}}, 3,
    {{16, 1.0, 0.0}, {32, 1.0, 0.0}, {64, 1.0, 0.0}}, 3, 2, duct_run, NULL};
static const val_part duct_second_part = {
    "second", "order = 2", "nodes across", VAL_BY_N, NULL, 2.0, {{"err_l2", "u, L2"}, {"err_max", "u, largest"}}, 2,
    {{0, 5e-5, 0.0, 64, VAL_GOAL}, {0, 5e-3, 0.0, 0, VAL_GUARD}}, 2,
    {{16, 1.0, 0.0}, {32, 1.0, 0.0}, {64, 1.0, 0.0}}, 3, 2, duct_run_second, NULL};
static const val_part *const duct_parts[] = {&duct_part, &duct_second_part};

static const val_case duct_case = {
    "duct", "Flow through a square duct",
    "Steady flow from rest between four walls under a force along them, to a residual of 1e-9; periodic, four cells "
    "long. Relative L2 error of u, and the largest over the largest u.",
    "Corners in which the walls of both axes count wrongly, profiles that hold along the axes alone.",
    "closed form: White's series", duct_parts, 2};

static const val_case hagen_case = {
    "hagen", "Flow through a tube",
    "Steady flow from rest through a round tube that is cut out of the lattice, Re = 3, to a residual of 1e-8. The "
    "tube is one radius long.",
    "Curved walls of first order (nearest node in place of the surface), operators that were never tried in 3D, a "
    "false pressure in the wall.",
    "closed form: u = 2 U (1 - (r/R)^2), dp/dx = -8 mu U/R^2",
    hagen_parts, 1};

#endif

#endif
#endif
