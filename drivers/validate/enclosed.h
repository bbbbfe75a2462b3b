/* enclosed: cases about flow in closed and in periodic boxes. */
#ifndef VAL_ENCLOSED_H
#define VAL_ENCLOSED_H
#if PD_DIM > 1

/* Unit density and unit reference speed and length, viscosity nu [m2/s]. */
static void enclosed_fluid(val_lab *lab, double nu)
{
    lab->flow_desc.rho = lab->flow_desc.speed = lab->flow_desc.length = 1.0;
    lab->flow_desc.mu = nu;
}

#if PD_DIM == 2

/* ---- cavity ---- */

#define CAVITY_POINTS 15

/* cavity_re100_u.csv and cavity_re100_v.csv, the recomputed columns (stream function and vorticity, Richardson
 * extrapolation, error 5e-4) without the end points, which are given. */
static const double cavity_y[CAVITY_POINTS] = {0.0547, 0.0625, 0.0703, 0.1016, 0.1719, 0.2813, 0.4531, 0.5,
                                               0.6172, 0.7344, 0.8516, 0.9531, 0.9609, 0.9688, 0.9766};
static const double cavity_u[CAVITY_POINTS] = {-0.03723, -0.04198, -0.04662, -0.06443, -0.10174,
                                               -0.15767, -0.21398, -0.20915, -0.13880, 0.00419,
                                               0.23655,  0.69103,  0.74047,  0.79194,  0.84373};
static const double cavity_x[CAVITY_POINTS] = {0.0625, 0.0703, 0.0781, 0.0938, 0.1563, 0.2266, 0.2344, 0.5,
                                               0.8047, 0.8594, 0.9063, 0.9453, 0.9531, 0.9609, 0.9688};
static const double cavity_v[CAVITY_POINTS] = {0.09481,  0.10359,  0.11175,  0.12643,  0.16483,
                                               0.17936,  0.17956,  0.05754,  -0.25354, -0.23369,
                                               -0.17708, -0.10853, -0.09339, -0.07798, -0.06219};

/* The lid y = 1 moves; in its corners the mean of lid and wall. */
static void cavity_lid(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = u[1] = 0.0;
    if (x[1] > 1.0 - 1e-9) u[0] = x[0] < 1e-9 || x[0] > 1.0 - 1e-9 ? 0.5 : 1.0;
}

/* Cubic through the four of the points s (ascending) next to `at`. */
static double enclosed_cubic(const double *s, const double *f, int count, double at)
{
    int first = 0;
    double sum = 0.0;
    while (first + 4 < count && s[first + 2] < at) first++;
    for (int a = first; a < first + 4; a++) {
        double product = f[a];
        for (int b = first; b < first + 4; b++)
            if (b != a) product *= (at - s[b]) / (s[a] - s[b]);
        sum += product;
    }
    return sum;
}

/* Component `of` of the velocity along the centreline across it (u along y, v along x), its ends being walls; the
 * middle by the cubic through four nodes. Returns the number of points. */
static int cavity_line(const val_lab *lab, int of, double *s, double *f)
{
    int along = 1 - of, n = lab->grid.n[along], half = lab->grid.n[of] / 2, odd = lab->grid.n[of] % 2, i[PD_DIM];
    s[0] = f[0] = 0.0;
    for (i[along] = 0; i[along] < n; i[along]++) {
        static const double even[4] = {-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0};
        double sum = 0.0;
        for (int k = 0; k < 4; k++) {
            double weight = odd ? (k == 2 ? 1.0 : 0.0) : even[k];
            i[of] = half - 2 + k;
            sum += weight * lab->flow.u[(int64_t)of * lab->grid.total + pd_grid_node(&lab->grid, i)];
        }
        s[i[along] + 1] = (i[along] + 0.5) / n;
        f[i[along] + 1] = sum;
    }
    s[n + 1] = 1.0;
    f[n + 1] = of == 0 ? 1.0 : 0.0;
    return n + 2;
}

static double cavity_error(val_job *job, int of, const double *place, const double *value)
{
    double s[VAL_POINTS], f[VAL_POINTS], error = 0.0;
    int count = cavity_line(job->lab, of, s, f);
    val_curve *found = val_add_curve(job, of ? "v along x, computed" : "u along y, computed", PD_STROKE_LINE);
    val_curve *wanted = val_add_curve(job, of ? "v along x, reference" : "u along y, reference", PD_STROKE_MARKERS);
    for (int k = 0; k < count; k++) val_add_point(found, s[k], f[k]);
    for (int k = 0; k < CAVITY_POINTS; k++) {
        val_add_point(wanted, place[k], value[k]);
        error = fmax(error, fabs(enclosed_cubic(s, f, count, place[k]) - value[k]));
    }
    return error;
}

static pd_status cavity_run(val_job *job)
{
    val_lab *lab = job->lab;
    if (job->level.n < 4 || job->level.n > VAL_POINTS - 2)
        return pdi_fail(job->ctx, PD_ERR_ARGUMENT, "validate", "the cavity takes 4 to %d cells", VAL_POINTS - 2);
    lab_box(lab, 1.0 / job->level.n, job->level.m, 0.0, 1.0);
    enclosed_fluid(lab, 0.01);
    lab->flow_desc.wall = cavity_lid;
    lab->steady_desc.tolerance = 1e-8;
    PDI_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PDI_TRY(flow_solve(job));
    job->out->h = lab->grid.h[0];
    if (job->profile) {
        job->profile->title = "Velocity on the centrelines of the cavity, Re = 100";
        job->profile->x_label = "place [-]";
        job->profile->y_label = "velocity over that of the lid [-]";
    }
    job->out->err[0] = cavity_error(job, 0, cavity_y, cavity_u);
    job->out->err[1] = cavity_error(job, 1, cavity_x, cavity_v);
    return PD_OK;
}

static const val_part cavity_part = {
    "", "", "nodes across", VAL_BY_N, NULL, 2.0, {{"err_max", "u, largest"}, {"err_v", "v, largest"}}, 2,
    {{0, 3e-3, 0.0, 96, VAL_GOAL}, {1, 3e-3, 0.0, 96, VAL_GOAL}, {0, 3e-2, 0.0, 0, VAL_GUARD},
     {0, 0.0, 1.8, 32, VAL_GUARD}, {1, 0.0, 1.8, 32, VAL_GUARD}}, 5,
    {{24, 3.0, 0.0}, {32, 3.0, 0.0}, {48, 3.0, 0.0}, {64, 3.0, 0.0}, {96, 3.0, 0.0}}, 5, 3, cavity_run, NULL};
static const val_part *const cavity_parts[] = {&cavity_part};

static const val_case cavity_case = {
    "cavity", "Lid-driven cavity",
    "Steady flow from rest in a closed square box whose lid slides, Re = 100, to a residual of 1e-8. Largest "
    "differences of u on the vertical and of v on the horizontal centreline, over the speed of the lid.",
    "Moving walls of first order, a closed box whose pressure is not determined, convection of first order.",
    "U. Ghia, K. N. Ghia and C. T. Shin, J. Comput. Phys. 48, 1982, recomputed to 5e-4: the tables "
    "`cavity_re100_u.csv` and `cavity_re100_v.csv` (the published v are up to 3.7 % off)",
    cavity_parts, 1};

#endif
#endif
#endif
