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

/* A stream of speed 1 that the plates stop. */
static double startup_stop(double y, double t)
{
    double u = 0.0;
    for (int k = 1; k < STARTUP_TERMS; k += 2)
        u += 4.0 / (k * val_pi) * sin(k * val_pi * y) * exp(-k * k * val_pi * val_pi * t);
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
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.length = 1.0;
    lab->flow_desc.speed = moving ? 1.0 : 0.125;
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
    return error / lab->flow_desc.speed;
}

static void startup_curves(val_job *job, int moving, double t)
{
    const val_lab *lab = job->lab;
    char name[40];
    int i[PD_DIM];
    if (!job->profile) return;
    snprintf(name, sizeof name, "series, %g", t);
    val_curve *exact = val_add_curve(job, name, PD_STROKE_LINE);
    snprintf(name, sizeof name, "computed, %g", t);
    val_curve *found = val_add_curve(job, name, PD_STROKE_MARKERS);
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
    PDI_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    job->out->h = lab->grid.h[0];
    for (int k = 0; k < STARTUP_TIMES; k++) {
        PDI_TRY(pd_implicit_run(job->ctx, &lab->implicit, startup_time[k]));
        startup_note(job, moving, k);
    }
    job->out->steps = (long)lab->implicit.steps;
    job->out->evals = (long)lab->implicit.evaluations;
    return PD_OK;
}

static pd_status startup_couette_run(val_job *job) { return startup_implicit_run(job, 1); }
static pd_status startup_poiseuille_run(val_job *job) { return startup_implicit_run(job, 0); }

static pd_status startup_explicit_times(val_job *job, pd_unsteady *un)
{
    for (int k = 0; k < STARTUP_TIMES; k++) {
        PDI_TRY(pd_unsteady_run(job->ctx, un, startup_time[k]));
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
    pd_unsteady un;
    pd_unsteady_desc desc;
    memset(&un, 0, sizeof un);
    memset(&desc, 0, sizeof desc);
    startup_scene(job, 0);
    desc.sound = 10.0 * lab->flow_desc.speed;
    PDI_TRY(lab_build(job->ctx, lab, VAL_FLOW));
    job->out->h = lab->grid.h[0];
    pd_status status = pd_unsteady_build(job->ctx, &lab->flow, &desc, &un);
    if (status == PD_OK) status = startup_explicit_times(job, &un);
    pd_unsteady_free(job->ctx, &un);
    return status;
}

#define STARTUP_MEASURES {{"err_max", "all times"}, {"err_late", "from 0.05 on"}}, 2

static const val_part startup_couette = {
    "couette", "Couette start-up", "nodes across", VAL_BY_N, NULL, 2.0, STARTUP_MEASURES,
    {{0, 1e-3, 0.0, 144, VAL_GOAL}, {0, 0.0, 1.8, 48, VAL_GUARD}, {1, 4e-3, 0.0, 0, VAL_GUARD}}, 3,
    {{24, 3.0, 0.0}, {48, 3.0, 0.0}, {96, 3.0, 0.0}, {144, 3.0, 0.0}}, 4, 2, startup_couette_run, NULL};
static const val_part startup_poiseuille = {
    "poiseuille", "Poiseuille start-up", "nodes across", VAL_BY_N, NULL, 2.0, STARTUP_MEASURES,
    {{0, 1e-3, 0.0, 48, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GUARD}}, 2,
    {{24, 3.0, 0.0}, {48, 3.0, 0.0}, {96, 3.0, 0.0}}, 3, 2, startup_poiseuille_run, NULL};
static const val_part startup_explicit = {
    "explicit", "Poiseuille start-up, weakly compressible and explicit", "nodes across", VAL_BY_N, NULL, 2.0,
    STARTUP_MEASURES, {{0, 1e-3, 0.0, 48, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GUARD}}, 2,
    {{24, 3.0, 0.0}, {48, 3.0, 0.0}}, 2, 2, startup_explicit_run, NULL};
static const val_part *const startup_parts[] = {&startup_couette, &startup_poiseuille, &startup_explicit};

static const val_case startup_case = {
    "startup", "Start-up between plates",
    "Fluid at rest between plates, of which one starts to move, or which a force starts to drive. Largest error at "
    "any node at the times 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5 and 1 H^2/nu over the largest velocity of the "
    "steady flow, with implicit steps of controlled error (1e-4) and with explicit ones.",
    "Walls whose velocity comes late or in the wrong place, an impulsive start that rings, steps whose error is not "
    "controlled, an order in time below two.",
    "series for a layer (the tables `couette_startup.csv` and `poiseuille_plane_startup.csv`)",
    startup_parts, 3};

#endif
#endif
#endif
