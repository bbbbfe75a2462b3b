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
    lab->flow_desc.speed = *mean;
    lab->flow_desc.length = 2.0 * FLOW_HALF;
    lab->flow_desc.inlet = flow_profile;
    lab->flow_desc.inlet_user = mean;
    lab->steady_desc.tolerance = tolerance;
}

/* Solve and note what it took. Not to converge is a failure here. */
static pd_status flow_solve(val_job *job)
{
    pd_steady_result result;
    PDI_TRY(pd_steady_solve(job->ctx, &job->lab->steady, &result));
    job->out->residual = fmax(result.momentum, result.continuity);
    job->out->evals = (long)result.evaluations;
    job->out->steps = result.newton;
    if (result.converged) return PD_OK;
    return pdi_fail(job->ctx, PD_ERR_DIVERGED, "validate", "the flow is not steady: residual %.3g after %d steps",
                    job->out->residual, result.newton);
}

/* Relative L2 difference of the velocity from the profile, and relative error of dp/dx: the slope of the straight line
 * of least squares through the pressures of all fluid nodes. */
static void flow_errors(val_job *job, double exact_slope, double *velocity, double *slope)
{
    const val_lab *lab = job->lab;
    const pd_grid *grid = &lab->grid;
    double off = 0.0, size = 0.0, count = 0.0, sx = 0.0, sp = 0.0, sxx = 0.0, sxp = 0.0;
    double middle = 0.5 * (grid->lo[0] + grid->hi[0]);
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (grid->kind[i] != PD_FLUID) continue;
        pd_grid_position(grid, i, x);
        flow_profile(lab->flow_desc.inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            double e = lab->flow.u[(int64_t)d * grid->total + i] - u[d];
            off += e * e;
            size += u[d] * u[d];
        }
        count += 1.0;
        sx += x[0] - middle;
        sp += FLOW_RHO * lab->flow.p[i];
        sxx += (x[0] - middle) * (x[0] - middle);
        sxp += (x[0] - middle) * FLOW_RHO * lab->flow.p[i];
    }
    *velocity = sqrt(off / size);
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
    val_curve *exact = val_add_curve(job, "closed form", PD_STROKE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_STROKE_MARKERS);
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
    PDI_TRY(lab_build(job->ctx, job->lab, VAL_FLOW | VAL_STEADY));
    PDI_TRY(flow_solve(job));
    job->out->h = job->lab->grid.h[0];
    job->out->x = job->level.m;
    flow_errors(job, -3.0 * FLOW_MU * mean / (FLOW_HALF * FLOW_HALF), &job->out->err[0], &job->out->err[1]);
    flow_curves(job, "Plane Poiseuille flow, 2D");
    return PD_OK;
}

static const val_part poiseuille_across = {
    "across", "m = 3", "nodes across", VAL_BY_N, "nodes across", 0.0, FLOW_ERRORS,
    {{0, 1e-6, 0.0, 0, 0}, {1, 1e-6, 0.0, 0, 0}}, 2,
    {{15, 3.0, 0.0}, {30, 3.0, 0.0}, {60, 3.0, 0.0}}, 3, 2, poiseuille_run, NULL};
static const val_part poiseuille_horizons = {
    "horizons", "other horizons", "m", VAL_BY_M, "m", 0.0, FLOW_ERRORS,
    {{0, 1e-6, 0.0, 0, 0}, {1, 1e-6, 0.0, 0, 0}}, 2,
    {{60, 2.0, 0.0}, {60, 4.0, 0.0}}, 2, 0, poiseuille_run, NULL};
static const val_part *const poiseuille_parts[] = {&poiseuille_across, &poiseuille_horizons};

static const val_case poiseuille_case = {
    "poiseuille", "Flow between plates",
    "Steady flow from rest between plates, from an inlet with the parabola to a pressure outlet, Re = 3, to a residual "
    "of 1e-8. The length is two widths.",
    "Walls of first order, uncalibrated viscosity, an inlet or outlet that disturbs the profile, a steady test on "
    "changes instead of residuals.",
    "closed form: u = 3/2 U (1 - (y/H)^2), dp/dx = -3 mu U/H^2",
    poiseuille_parts, 2};

#endif

#endif
#endif
