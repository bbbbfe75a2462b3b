/* startup: cases about flow between plates that starts from rest or from a stream. */
#ifndef VAL_STARTUP_H
#define VAL_STARTUP_H
#if PD_DIM > 1

/* ---- series for the layer 0 <= y <= 1 between plates; time in H^2/nu ---- */

#define STARTUP_TERMS 400

/* u nu/(f H^2) under a constant force f, from rest: the columns of poiseuille_plane_startup.csv. */
static double startup_force(double y, double t)
{
    double u = 0.5 * y * (1.0 - y);
    for (int k = 1; k < STARTUP_TERMS; k += 2)
        u -= 4.0 / (k * k * k * val_pi * val_pi * val_pi) * sin(k * val_pi * y) * exp(-k * k * val_pi * val_pi * t);
    return u;
}

/* u/U beside the plate y = 1, which moves from t = 0 on: the columns of couette_startup.csv. */
static double startup_wall(double y, double t)
{
    double u = y;
    for (int k = 1; k < STARTUP_TERMS; k++)
        u += 2.0 / (k * val_pi) * (k % 2 ? -1.0 : 1.0) * sin(k * val_pi * y) * exp(-k * k * val_pi * val_pi * t);
    return u;
}

/* Periodic box with plates at y = 0 and y = height, n cells between them, `along` cells in the other directions. */
static void startup_box(val_lab *lab, double height, const val_level *level, int along)
{
    double h = height / level->n;
    lab_box(lab, h, level->m, 0.0, along * h);
    lab->grid_desc.hi[1] = height;
    for (int side = 0; side < 2 * PD_DIM; side++)
        lab->grid_desc.side[side] = side / 2 == 1 ? PD_SIDE_WALL : PD_SIDE_PERIODIC;
}

#if PD_DIM == 2

/* ---- startup ---- */

#define STARTUP_TIMES 8
static const double startup_time[STARTUP_TIMES] = {0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0}; /* [-] nu t/H^2 */

static void startup_lid(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = x[1] > 0.5 ? 1.0 : 0.0;
    u[1] = 0.0;
}

/* Plates one apart, viscosity 1, along y; the largest velocity is 1 or that of the parabola. */
static void startup_scene(val_job *job, int moving)
{
    val_lab *lab = job->lab;
    startup_box(lab, 1.0, &job->level, 4);
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_length = 1.0;
    lab->flow_desc.report_speed = moving ? 1.0 : 0.125;
    lab->flow_desc.force[0] = moving ? 0.0 : 1.0;
    lab->flow_desc.wall = moving ? startup_lid : NULL;
    if (!job->profile) return;
    job->profile->title =
        moving ? "Couette start-up: nu t/H^2 = 0.005, 0.05" : "Poiseuille start-up: nu t/H^2 = 0.02, 0.1";
    job->profile->x_label = "y/H [-]";
    job->profile->y_label = moving ? "u/U [-]" : "u nu/(f H^2) [-]";
}

/* Largest error of both components at any node, over the largest velocity. */
static double startup_error(const val_lab *lab, int moving, double t)
{
    double error = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        double u = moving ? startup_wall(x[1], t) : startup_force(x[1], t);
        error = fmax(error, fabs(lab->flow.u[i] - u));
        error = fmax(error, fabs(lab->flow.u[lab->grid.total + i]));
    }
    return error / lab->flow_desc.report_speed;
}

static void startup_curves(val_job *job, int moving, double t)
{
    const val_lab *lab = job->lab;
    char name[40];
    int i[PD_DIM];
    if (!job->profile) return;
    snprintf(name, sizeof name, "series, %g", t);
    val_curve *exact = val_add_curve(job, name, PD_SERIES_STYLE_LINE);
    snprintf(name, sizeof name, "computed, %g", t);
    val_curve *found = val_add_curve(job, name, PD_SERIES_STYLE_MARKERS);
    for (int k = 0; k <= 200; k++)
        val_add_point(exact, k / 200.0, moving ? startup_wall(k / 200.0, t) : startup_force(k / 200.0, t));
    i[0] = 0;
    for (i[1] = 0; i[1] < lab->grid.n[1]; i[1]++)
        val_add_point(found, (i[1] + 0.5) * lab->grid.h[1], lab->flow.u[pd_grid_node(&lab->grid, i)]);
}

/* Notes the errors at the listed time `k`: err[0] at all of them, err[1] from the fourth on. */
static void startup_note(val_job *job, int moving, int k)
{
    double error = startup_error(job->lab, moving, startup_time[k]);
    job->out->err[0] = fmax(job->out->err[0], error);
    if (k >= 3) job->out->err[1] = fmax(job->out->err[1], error);
    if (k == (moving ? 0 : 2) || k == (moving ? 3 : 4)) startup_curves(job, moving, startup_time[k]);
}

static pd_status startup_implicit_run(val_job *job, int moving)
{
    val_lab *lab = job->lab;
    startup_scene(job, moving);
    lab->implicit_desc.rtol = 1e-4;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    job->out->h = lab->grid.h[0];
    for (int k = 0; k < STARTUP_TIMES; k++) {
        PD_TRY(pd_physics_run(job->ctx, pd_implicit_process(&lab->implicit), startup_time[k]));
        startup_note(job, moving, k);
    }
    job->out->steps = (long)lab->implicit.steps;
    job->out->evals = (long)lab->implicit.evaluations;
    return PD_OK;
}

static pd_status startup_couette_run(val_job *job) { return startup_implicit_run(job, 1); }
static pd_status startup_poiseuille_run(val_job *job) { return startup_implicit_run(job, 0); }

static pd_status startup_explicit_times(val_job *job, pd_weakly_compressible *un)
{
    for (int k = 0; k < STARTUP_TIMES; k++) {
        PD_TRY(pd_physics_run(job->ctx, pd_weakly_compressible_process(un), startup_time[k]));
        startup_note(job, 0, k);
    }
    job->out->steps = (long)un->steps;
    job->out->evals = (long)job->lab->flow.evaluations;
    return PD_OK;
}

/* Weakly compressible, with sound ten times as fast as the flow: the flow is parallel, so no density changes. */
static pd_status startup_explicit_run(val_job *job)
{
    val_lab *lab = job->lab;
    pd_weakly_compressible un;
    pd_weakly_compressible_desc desc;
    memset(&un, 0, sizeof un);
    memset(&desc, 0, sizeof desc);
    startup_scene(job, 0);
    desc.sound_speed = 10.0 * lab->flow_desc.report_speed;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW));
    job->out->h = lab->grid.h[0];
    pd_status status = pd_weakly_compressible_build(job->ctx, &lab->flow, &desc, &un);
    if (status == PD_OK) status = startup_explicit_times(job, &un);
    pd_weakly_compressible_free(job->ctx, &un);
    return status;
}

/* ---- a force that swings: Womersley's flow between plates one apart, viscosity 1 ---- */

#define SWING_RATE 64.0 /* [1/s] half the height times sqrt(rate/nu) is 4 */
#define SWING_TIMES 4   /* in one period */

/* Time [s] that the force and the walls are asked for. */
static double swing_clock;

static void swing_force(void *user, const double *x, double *f)
{
    (void)x;
    f[0] = cos(SWING_RATE * *(const double *)user);
    f[1] = 0.0;
}

/* u of the force cos(w t): the real part of e^(iwt)/(iw) (1 - cosh(k (1+i) s)/cosh(k (1+i)/2)), k = sqrt(w/2), with s
 * from the middle (Womersley 1955 for a tube; Landau and Lifshitz, section 24, for plates). */
static double swing_speed(double y, double t)
{
    double k = sqrt(0.5 * SWING_RATE), s = y - 0.5;
    double a = cosh(k * s) * cos(k * s), b = sinh(k * s) * sin(k * s);
    double c = cosh(0.5 * k) * cos(0.5 * k), d = sinh(0.5 * k) * sin(0.5 * k), size = c * c + d * d;
    double re = 1.0 - (a * c + b * d) / size, im = (a * d - b * c) / size;
    return (re * sin(SWING_RATE * t) + im * cos(SWING_RATE * t)) / SWING_RATE;
}

/* From the series at t = 0 over one period; errors over the largest velocity in the middle. */
static pd_status swing_run(val_job *job)
{
    val_lab *lab = job->lab;
    swing_clock = 0.0;
    startup_box(lab, 1.0, &job->level, 4);
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_length = 1.0;
    lab->flow_desc.report_speed = 1.0 / SWING_RATE;
    lab->flow_desc.body = swing_force;
    lab->flow_desc.body_user = lab->flow_desc.clock = &swing_clock;
    lab->implicit_desc.rtol = 1e-5;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        lab->flow.u[i] = swing_speed(x[1], 0.0);
    }
    job->out->h = lab->grid.h[0];
    val_curve *exact = job->profile ? val_add_curve(job, "closed form", PD_SERIES_STYLE_LINE) : NULL;
    val_curve *found = job->profile ? val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS) : NULL;
    for (int k = 1; k <= SWING_TIMES; k++) {
        double t = k * 2.0 * val_pi / SWING_RATE / SWING_TIMES;
        PD_TRY(pd_physics_run(job->ctx, pd_implicit_process(&lab->implicit), t));
        for (int32_t i = 0; i < lab->grid.total; i++) {
            double x[PD_DIM];
            if (lab->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&lab->grid, i, x);
            double off = fabs(lab->flow.u[i] - swing_speed(x[1], t));
            job->out->err[0] = fmax(job->out->err[0], SWING_RATE * off);
            if (k == SWING_TIMES) job->out->err[1] = fmax(job->out->err[1], SWING_RATE * off);
            if (found && k == 1 && x[0] < lab->grid.h[0]) val_add_point(found, x[1], lab->flow.u[i]);
        }
        for (int n = 0; n <= 200 && exact && k == 1; n++) val_add_point(exact, n / 200.0, swing_speed(n / 200.0, t));
    }
    if (job->profile) {
        job->profile->title = "Flow under a force that swings, after a quarter of a period";
        job->profile->x_label = "y/H [-]";
        job->profile->y_label = "u [m/s]";
    }
    job->out->steps = (long)lab->implicit.steps;
    job->out->evals = (long)lab->implicit.evaluations;
    return PD_OK;
}

static const val_part startup_swing = {
    "womersley", "a force that swings, Womersley number 4", "nodes across", VAL_BY_N, NULL, 2.0,
    {{"err_max", "all times"}, {"err_end", "after a period"}}, 2,
    {{0, 1e-3, 0.0, 64, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GUARD}}, 2,
    {{16, 1.0, 0.0}, {32, 1.0, 0.0}, {64, 1.0, 0.0}}, 3, 2, swing_run, NULL};

#define STARTUP_MEASURES {{"err_max", "all times"}, {"err_late", "from 0.05 on"}}, 2

static const val_part startup_couette = {
    "couette", "Couette start-up", "nodes across", VAL_BY_N, NULL, 2.0, STARTUP_MEASURES,
    {{0, 1e-3, 0.0, 144, VAL_GOAL}, {0, 0.0, 1.8, 48, VAL_GUARD}, {1, 4e-3, 0.0, 0, VAL_GUARD}}, 3,
    {{24, 1.0, 0.0}, {48, 1.0, 0.0}, {96, 1.0, 0.0}, {144, 1.0, 0.0}}, 4, 2, startup_couette_run, NULL};
static const val_part startup_poiseuille = {
    "poiseuille", "Poiseuille start-up", "nodes across", VAL_BY_N, NULL, 2.0, STARTUP_MEASURES,
    {{0, 1e-3, 0.0, 48, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GUARD}}, 2,
    {{24, 1.0, 0.0}, {48, 1.0, 0.0}, {96, 1.0, 0.0}}, 3, 2, startup_poiseuille_run, NULL};
static const val_part startup_explicit = {
    "explicit", "Poiseuille start-up, weakly compressible and explicit", "nodes across", VAL_BY_N, NULL, 2.0,
    STARTUP_MEASURES, {{0, 1e-3, 0.0, 48, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GUARD}}, 2,
    {{24, 1.0, 0.0}, {48, 1.0, 0.0}}, 2, 2, startup_explicit_run, NULL};
static const val_part *const startup_parts[] = {&startup_couette, &startup_poiseuille, &startup_explicit,
                                                &startup_swing};

static const val_case startup_case = {
    "startup", "Start-up between plates",
    "Fluid at rest between plates, of which one starts to move, or which a force starts to drive. Largest error at "
    "any node at the times 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5 and 1 H^2/nu over the largest velocity of the "
    "steady flow, with implicit steps of controlled error (1e-4) and with explicit ones. A force that swings with the "
    "Womersley number 4 drives the fluid through one period, from the field of the closed form: largest error at four "
    "times over the amplitude of a stream without walls (steps of 1e-5).",
    "Walls whose velocity comes late or in the wrong place, an impulsive start that rings, steps whose error is not "
    "controlled, an order in time below two.",
    "series for a layer (the tables `couette_startup.csv` and `poiseuille_plane_startup.csv`); Womersley's flow",
    startup_parts, 4};

#endif

#if PD_DIM == 3

/* ---- channel3d ---- */

/* Plates 2 m apart, viscosity 0.02 m2/s, a force of 0.06 m/s2 along x: Re = 100 with the mean speed 1 m/s. */
#define CHANNEL_HEIGHT 2.0
#define CHANNEL_NU 0.02
#define CHANNEL_FORCE 0.06
#define CHANNEL_TIMES 5
#define CHANNEL_JUMP 2 /* times before this one are those of the jump at the walls */
#define CHANNEL_CELLS 1000 /* most across */
static const double channel_time[CHANNEL_TIMES] = {1.0, 5.0, 20.0, 50.0, 100.0}; /* [s] */

/* A stream of speed 1 that the plates stop. */
static double startup_stop(double y, double t)
{
    double u = 0.0;
    for (int k = 1; k < STARTUP_TERMS; k += 2)
        u += 4.0 / (k * val_pi) * sin(k * val_pi * y) * exp(-k * k * val_pi * val_pi * t);
    return u;
}

/* u [m/s] at the distance y [m] from a wall: a stream of 1 m/s, and the force from t = 0 on. */
static double channel_series(double y, double t, double sign)
{
    double unit = CHANNEL_HEIGHT * CHANNEL_HEIGHT / CHANNEL_NU, s = t / unit;
    return startup_stop(y / CHANNEL_HEIGHT, s) +
           sign * CHANNEL_FORCE * unit * startup_force(y / CHANNEL_HEIGHT, s);
}

/* What second differences make of it on n cells: with (2.3) and (2.4) at the walls the parabola is a discrete solution,
 * and sines are modes that decay at 4/h^2 sin^2(k pi/(2 n)) (theory: section 1.4). u [n] [m/s] at the time t [s]. */
static void channel_second(int n, double t, double sign, double *u)
{
    double h = CHANNEL_HEIGHT / n, half = 0.5 * sign * CHANNEL_FORCE / CHANNEL_NU;
    for (int j = 0; j < n; j++) u[j] = half * (j + 0.5) * h * (CHANNEL_HEIGHT - (j + 0.5) * h);
    for (int k = 1; k < n; k += 2) {
        double sum = 0.0, s = 2.0 / h * sin(0.5 * k * val_pi / n), left = exp(-CHANNEL_NU * s * s * t);
        for (int j = 0; j < n; j++) {
            double y = (j + 0.5) * h;
            sum += 2.0 / n * (1.0 - half * y * (CHANNEL_HEIGHT - y)) * sin(k * val_pi * (j + 0.5) / n);
        }
        for (int j = 0; j < n; j++) u[j] += sum * left * sin(k * val_pi * (j + 0.5) / n);
    }
}

/* The error that second differences have at 20, 50 and 100 s. */
static double channel_predicted(int n, double sign)
{
    double u[CHANNEL_CELLS], largest = 0.0;
    for (int k = CHANNEL_JUMP; k < CHANNEL_TIMES; k++) {
        double sum = 0.0;
        channel_second(n, channel_time[k], sign, u);
        for (int j = 0; j < n; j++) {
            double e = u[j] - channel_series((j + 0.5) * CHANNEL_HEIGHT / n, channel_time[k], sign);
            sum += e * e;
        }
        largest = fmax(largest, sqrt(sum / n));
    }
    return largest;
}

/* Root of the mean square of the error over the nodes, which are the same number at every distance from a wall, and the
 * largest velocity across. */
static void channel_note(val_job *job, int k, double sign)
{
    const val_lab *lab = job->lab;
    double sum = 0.0, across = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        double e = lab->flow.u[i] - channel_series(x[1], channel_time[k], sign);
        sum += e * e;
        for (int d = 1; d < PD_DIM; d++) across = fmax(across, fabs(lab->flow.u[(int64_t)d * lab->grid.total + i]));
    }
    double rms = sqrt(sum / (double)lab->grid.fluid_count);
    job->out->err[k < CHANNEL_JUMP ? 1 : 0] = fmax(job->out->err[k < CHANNEL_JUMP ? 1 : 0], rms);
    if (k == CHANNEL_TIMES - 1) job->out->err[2] = fmax(job->out->err[2], rms);
    job->out->err[3] = fmax(job->out->err[3], across);
}

static pd_status channel_once(val_job *job, int along, int wide, double sign)
{
    val_lab *lab = job->lab;
    int order = lab->flow_desc.order;
    memset(lab, 0, sizeof *lab);
    lab->flow_desc.order = order;
    startup_box(lab, CHANNEL_HEIGHT, &job->level, along);
    lab->grid_desc.hi[2] = wide * lab->stencil_desc.h[2];
    lab->flow_desc.rho = lab->flow_desc.report_speed = 1.0;
    lab->flow_desc.mu = CHANNEL_NU;
    lab->flow_desc.report_length = CHANNEL_HEIGHT;
    lab->flow_desc.force[0] = sign * CHANNEL_FORCE;
    lab->implicit_desc.stage_tolerance = 1e-7;
    lab->implicit_desc.rtol = 1e-4;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    for (int32_t i = 0; i < lab->grid.total; i++)
        if (lab->grid.kind[i] == PD_FLUID) lab->flow.u[i] = 1.0;
    for (int k = 0; k < CHANNEL_TIMES; k++) {
        PD_TRY(pd_physics_run(job->ctx, pd_implicit_process(&lab->implicit), channel_time[k]));
        channel_note(job, k, sign);
    }
    job->out->h = lab->grid.h[0];
    job->out->steps += (long)lab->implicit.steps;
    job->out->evals += (long)lab->implicit.evaluations;
    if (lab->grid.n[1] > CHANNEL_CELLS)
        return pd_fail(job->ctx, PD_ERR_ARGUMENT, "validate", "the channel takes at most %d cells across",
                       CHANNEL_CELLS);
    job->out->err[4] = job->out->err[0] / channel_predicted(lab->grid.n[1], sign);
    return PD_OK;
}

static void channel_curves(val_job *job, double sign)
{
    const val_lab *lab = job->lab;
    int i[PD_DIM];
    if (!job->profile) return;
    job->profile->title = sign > 0.0 ? "Channel at t = 100 s" : "Channel with the force reversed at t = 100 s";
    job->profile->x_label = "y [m]";
    job->profile->y_label = "u [m/s]";
    val_curve *exact = val_add_curve(job, "series", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    for (int k = 0; k <= 200; k++)
        val_add_point(exact, k * CHANNEL_HEIGHT / 200.0, channel_series(k * CHANNEL_HEIGHT / 200.0, 100.0, sign));
    i[0] = i[2] = 0;
    for (i[1] = 0; i[1] < lab->grid.n[1]; i[1]++)
        val_add_point(found, (i[1] + 0.5) * lab->grid.h[1], lab->flow.u[pd_grid_node(&lab->grid, i)]);
}

/* 4 x n x 4 cells: the flow does not depend on x and z. */
static pd_status channel_short_run(val_job *job)
{
    PD_TRY(channel_once(job, 4, 4, job->level.p));
    channel_curves(job, job->level.p);
    return PD_OK;
}

static pd_status channel_fourth_run(val_job *job)
{
    job->lab->flow_desc.order = 4;
    return channel_short_run(job);
}

#define CHANNEL_MEASURES                                                                                   \
    {{"err_l2", "20, 50, 100 s"}, {"err_early", "1, 5 s"}, {"err_end", "100 s"}, {"across", "largest across"}, \
     {"over_second", "over that of second differences"}}, 5
#define CHANNEL_GOALS(from) \
    {{0, 1e-4, 0.0, from, VAL_GOAL}, {3, 1e-6, 0.0, 0, VAL_GOAL}, {0, 6e-3, 0.0, 0, VAL_GUARD}}, 3
#define CHANNEL_MISS \
    "The slowest mode of the reversed flow is ten times as large as that of the other, 2.8 against 0.28 m/s. Second " \
    "differences have sines for modes, which decay at 4/h^2 sin^2(k h/2), with 40 cells at 0.9995 of the rate, and "   \
    "give the last column 1. So no weights of nearest neighbours do better; 1e-4 takes 86 cells, or fourth order "    \
    "(theory: section 1.4)."

static const val_part channel_along = {
    "along", "force along the stream", "nodes across", VAL_BY_N, NULL, 2.0, CHANNEL_MEASURES, CHANNEL_GOALS(40),
    {{20, 1.0, 1.0}, {40, 1.0, 1.0}, {80, 1.0, 1.0}}, 3, 1, channel_short_run, NULL};
static const val_part channel_back = {
    "reversed", "force reversed", "nodes across", VAL_BY_N, NULL, 2.0, CHANNEL_MEASURES,
    {{0, 1e-4, 0.0, 40, VAL_GOAL}, {3, 1e-6, 0.0, 0, VAL_GOAL}, {4, 1.05, 0.0, 0, VAL_GOAL},
     {0, 6e-3, 0.0, 0, VAL_GUARD}}, 4,
    {{20, 1.0, -1.0}, {40, 1.0, -1.0}, {80, 1.0, -1.0}}, 3, 1, channel_short_run, CHANNEL_MISS};
static const val_part channel_fourth = {
    "fourth", "force reversed, order = 4", "nodes across", VAL_BY_N, NULL, 0.0, CHANNEL_MEASURES,
    {{0, 5e-5, 0.0, 20, VAL_GOAL}, {3, 1e-6, 0.0, 0, VAL_GOAL}, {1, 5e-4, 0.0, 20, VAL_GUARD}}, 3,
    {{20, 1.0, -1.0}, {40, 1.0, -1.0}}, 2, 1, channel_fourth_run, NULL};
static const val_part *const channel_parts[] = {&channel_along, &channel_back, &channel_fourth};

static const val_case channel_case = {
    "channel3d", "Periodic channel in 3D",
    "A stream of 1 m/s between plates 2 m apart which stop it, while a force of 0.06 m/s2 drives it or holds it up: "
    "Re = 100, periodic along and across, implicit steps of controlled error (1e-4). The box is 4 cells long and wide, "
    "since nothing depends on these directions (the whole one of 10 x 2 x 1 m, `channel3d_3d.scene`, 160,000 nodes: 46 "
    "steps, 1383 evaluations and 191 s of processor time for 100 s at `rtol = 4e-3`). Root of the mean square of the "
    "error of u from wall to wall at 20, 50 and 100 s, at the early times 1 and 5 s, and at 100 s; largest velocity "
    "across at any of these.",
    "Profiles that are compared away from the walls only, a bias that refinement does not remove, flow across that "
    "feeds on rounding, work that depends on the sign of the force.",
    "series for a layer",
    channel_parts, 3};

#endif
#endif
#endif
