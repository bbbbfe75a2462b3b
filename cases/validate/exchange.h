/* exchange: cases about metal that walls take up from a stream. */
#ifndef VAL_EXCHANGE_H
#define VAL_EXCHANGE_H
#if PD_DIM == 2

/* The flow is the profile of the inlet everywhere. */
static void exchange_stream(pd_ctx *ctx, val_lab *lab)
{
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        lab->flow_desc.inlet(lab->flow_desc.inlet_user, x, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
    }
    pdi_flow_update_derived_fields(ctx, &lab->flow);
}

/* What the nodes of column `at` give to the wall a length of it, and around the axis for all of it [m/s or m2/s], over
 * the concentration of the mixed stream. */
static double exchange_column(const val_lab *lab, int at)
{
    const pd_transport *t = &lab->transport;
    double flux = 0.0, carried = 0.0, stream = 0.0;
    int i[PD_DIM];
    i[0] = at;
    for (i[1] = 0; i[1] < lab->grid.n[1]; i[1]++) {
        int32_t node = pd_grid_node(&lab->grid, i);
        double around = pd_grid_circumference(&lab->grid, node);
        if (lab->grid.kind[node] != PD_FLUID) continue;
        double given = pdi_diffusion_given(&t->diffusion, node);
        flux += (t->diffusion.wall_rate[node] * t->c[node] - given) * lab->grid.h[1] * around;
        carried += lab->flow.u[node] * t->c[node] * around;
        stream += lab->flow.u[node] * around;
    }
    return flux * stream / carried;
}

/* ---- graetz ---- */

/* Height, mean speed and diffusivity are 1, 1 and 1/1000: x is in heights, c in that of the inflow. */
#define GRAETZ_D 1e-3
#define GRAETZ_PLACES 8
/* [m] cells along x over those across: gradients along x are long. */
#define GRAETZ_STRETCH 4

/* A wall or two that hold c = 0, or that of a tube: the part of the height (of the radius) that is computed, the
 * reference length of the Sherwood number in heights, the number of walls, and the table: places x D/(U L^2), local
 * Sherwood numbers. */
typedef struct graetz_kind {
    double height, reference;
    int walls; /* 0: a tube around the axis */
    double place[GRAETZ_PLACES], sherwood[GRAETZ_PLACES];
} graetz_kind;

/* graetz_channel_sherwood.csv, column Sh_local, reference length Dh = 2 H: half of the channel under a mirror. */
static const graetz_kind graetz_two = {
    0.5, 2.0, 2,
    {1e-3, 1.467799e-3, 2.154435e-3, 3.162278e-3, 4.641589e-3, 6.812921e-3, 1e-2, 1.467799e-2},
    {12.82173, 11.47797, 10.33955, 9.39480, 8.64036, 8.08453, 7.74050, 7.58700}};
/* graetz_channel_onewall_sherwood.csv, column Sh_H_local, reference length H: no flux into the other wall. */
static const graetz_kind graetz_one = {
    1.0, 1.0, 1,
    {2.154435e-3, 3.162278e-3, 4.641589e-3, 6.812921e-3, 1e-2, 1.467799e-2, 2.154435e-2, 3.162278e-2},
    {7.54367, 6.65707, 5.88299, 5.20890, 4.62405, 4.11933, 3.68727, 3.32208}};

/* The series of Graetz for a tube of radius 1, reference length 2: eigenvalues and coefficients by a method of
 * Chebyshev polynomials with 60 and with 80 of them, which agree to all digits. */
static const graetz_kind graetz_tube = {
    1.0, 2.0, 0,
    {1e-3, 1.467799e-3, 2.154435e-3, 3.162278e-3, 4.641589e-3, 6.812921e-3, 1e-2, 1.467799e-2},
    {10.13019, 8.90463, 7.84218, 6.92544, 6.13971, 5.47297, 4.91606, 4.46315}};

static double graetz_held(void *user, const double *x)
{
    const graetz_kind *kind = (const graetz_kind *)user;
    return (kind->walls ? x[1] < 1e-9 : x[1] > 1.0 - 1e-9) ? 0.0 : (double)NAN;
}

static void graetz_profile(void *user, const double *x, double *u)
{
    const graetz_kind *kind = (const graetz_kind *)user;
    u[0] = kind->walls ? 6.0 * x[1] * (1.0 - x[1]) : 2.0 * (1.0 - x[1] * x[1]);
    u[1] = 0.0;
}

static pd_status graetz_build(val_job *job, const graetz_kind *kind)
{
    val_lab *lab = job->lab;
    double h = 1.0 / job->level.n, along = GRAETZ_STRETCH * h;
    double length = 1.1 * kind->place[GRAETZ_PLACES - 1] * kind->reference * kind->reference / GRAETZ_D;
    lab_box(lab, h, job->level.m, 0.0, kind->height);
    lab->stencil_desc.h[0] = along;
    lab->grid_desc.hi[0] = ceil(length / along) * along;
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.side[1] = PD_SIDE_OUTLET;
    if (kind->walls == 2) lab->grid_desc.side[3] = PD_SIDE_MIRROR;
    if (!kind->walls) lab->grid_desc.side[2] = PD_SIDE_MIRROR;
    lab->grid_desc.axisymmetric = !kind->walls;
    enclosed_fluid(lab, 1.0);
    lab->flow_desc.inlet = graetz_profile;
    lab->flow_desc.developed_sides = 1; /* side x- */
    lab->flow_desc.inlet_user = lab->transport_desc.user = (void *)(uintptr_t)kind;
    lab->transport_desc.diffusivity = GRAETZ_D;
    lab->transport_desc.held = graetz_held;
    lab->transport_desc.inlet = lab->transport_desc.initial = 1.0;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    exchange_stream(job->ctx, lab);
    job->out->h = h;
    return PD_OK;
}

/* At most 30 steps, much longer than the time of passage, until the field stays; err[2]: what the last one changes. */
static pd_status graetz_steady(val_job *job)
{
    pd_transport *t = &job->lab->transport;
    pd_transport_result result;
    double change = HUGE_VAL;
    for (int step = 0; step < 30 && change > 1e-6; step++) {
        change = 0.0;
        pdi_par_copy(job->ctx, t->grid->total, t->c, job->lab->field[0]);
        PD_TRY(pd_transport_implicit(job->ctx, t, 1e6, &result));
        for (int32_t i = 0; i < t->grid->total; i++)
            if (t->grid->kind[i] == PD_FLUID) change = fmax(change, fabs(t->c[i] - job->lab->field[0][i]));
        job->out->steps++;
    }
    job->out->err[2] = change;
    return PD_OK;
}

static double graetz_column(const val_lab *lab, const graetz_kind *kind, int at)
{
    double around = kind->walls ? 1.0 : 2.0 * val_pi;
    return exchange_column(lab, at) / around * kind->reference / GRAETZ_D;
}

/* Errors at the listed places, between columns by powers of x; curves over all columns. */
static void graetz_errors(val_job *job, const graetz_kind *kind)
{
    const val_lab *lab = job->lab;
    double unit = kind->reference * kind->reference / GRAETZ_D, along = lab->grid.h[0];
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_LINE);
    val_curve *wanted = val_add_curve(job, "series", PD_SERIES_STYLE_MARKERS);
    for (int k = 0; k < GRAETZ_PLACES; k++) {
        double x = kind->place[k] * unit / along - 0.5;
        int at = (int)floor(x);
        double before = graetz_column(lab, kind, at), behind = graetz_column(lab, kind, at + 1);
        double share = log((x + 0.5) / (at + 0.5)) / log((at + 1.5) / (at + 0.5));
        double error = fabs(before * pow(behind / before, share) / kind->sherwood[k] - 1.0);
        job->out->err[0] = fmax(job->out->err[0], error);
        if (k >= GRAETZ_PLACES / 2) job->out->err[1] = fmax(job->out->err[1], error);
        val_add_point(wanted, kind->place[k], kind->sherwood[k]);
    }
    for (int at = 1; at < lab->grid.n[0]; at += 1 + lab->grid.n[0] / VAL_POINTS)
        val_add_point(found, (at + 0.5) * along / unit, graetz_column(lab, kind, at));
}

static pd_status graetz_run(val_job *job, const graetz_kind *kind)
{
    PD_TRY(graetz_build(job, kind));
    PD_TRY(lab_fields(job->ctx, job->lab, 1, 1));
    PD_TRY(graetz_steady(job));
    if (job->profile) {
        job->profile->title = kind->walls == 2   ? "Both walls take up metal"
                              : kind->walls == 1 ? "One wall takes up metal"
                                                 : "The wall of a tube takes up metal";
        job->profile->x_label = kind->walls == 1 ? "x D/(U H^2) [-]" : "x D/(U Dh^2) [-]";
        job->profile->y_label = "local Sherwood number [-]";
        job->profile->x_log = job->profile->y_log = 1;
    }
    graetz_errors(job, kind);
    return PD_OK;
}

static pd_status graetz_two_run(val_job *job) { return graetz_run(job, &graetz_two); }
static pd_status graetz_one_run(val_job *job) { return graetz_run(job, &graetz_one); }
static pd_status graetz_tube_run(val_job *job) { return graetz_run(job, &graetz_tube); }

#define GRAETZ_MEASURES \
    {{"err_rel", "all places"}, {"err_late", "last four"}, {"change", "change of the last step"}}, 3
#define GRAETZ_GOALS(from, guard) {{0, 1e-2, 0.0, from, VAL_GOAL}, {0, guard, 0.0, 0, VAL_GUARD}}, 2
#define GRAETZ_LEVELS(m) {{20, m, 0.0}, {40, m, 0.0}, {80, m, 0.0}}

static const val_part graetz_two_part = {
    "two", "both walls hold c = 0, m = 1", "nodes across", VAL_BY_N, NULL, 2.0, GRAETZ_MEASURES,
    GRAETZ_GOALS(80, 0.2), GRAETZ_LEVELS(1.0), 3, 2, graetz_two_run, NULL};
static const val_part graetz_one_part = {
    "one", "one wall holds c = 0, m = 1", "nodes across", VAL_BY_N, NULL, 2.0, GRAETZ_MEASURES,
    GRAETZ_GOALS(80, 0.2), GRAETZ_LEVELS(1.0), 3, 2, graetz_one_run, NULL};
static const val_part graetz_m3_part = {
    "m3", "both walls hold c = 0, m = 3", "nodes across", VAL_BY_N, NULL, 2.0, GRAETZ_MEASURES,
    GRAETZ_GOALS(80, 1.0), GRAETZ_LEVELS(3.0), 3, 2, graetz_two_run, NULL};
static const val_part graetz_tube_part = {
    "tube", "the wall of a tube holds c = 0, m = 1", "nodes on the radius", VAL_BY_N, NULL, 2.0, GRAETZ_MEASURES,
    {{0, 1e-3, 0.0, 80, VAL_GOAL}, {0, 0.2, 0.0, 0, VAL_GUARD}}, 2, GRAETZ_LEVELS(1.0), 3, 2, graetz_tube_run, NULL};
static const val_part *const graetz_parts[] = {&graetz_two_part, &graetz_one_part, &graetz_m3_part,
                                               &graetz_tube_part};

static const val_case graetz_case = {
    "graetz", "Mass transfer in a channel and a tube",
    "A parabolic stream enters a channel whose walls, or one of them, hold c = 0 and let nothing pass otherwise, or a "
    "tube around the axis whose wall does; U over D is 1000 over the height or the radius. Largest relative error of "
    "the local Sherwood number at eight places, with cells four times as long as high: from 0.001 to 0.0147 Dh^2 U/D "
    "for both walls (the half under a mirror is computed), from 0.0022 to 0.032 H^2 U/D for one, as for both with the "
    "diameter for the tube. The series neglect diffusion along the stream.",
    "Walls that take up metal half a cell off, upwinding that thickens the layer at the wall, fluxes of the flow "
    "beside walls of first order.",
    "series: the tables `graetz_channel_sherwood.csv` and `graetz_channel_onewall_sherwood.csv`; Graetz' series",
    graetz_parts, 4};

#endif
#endif
