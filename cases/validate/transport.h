/* transport: cases about diffusion and advection. */
#ifndef VAL_TRANSPORT_H
#define VAL_TRANSPORT_H

#define TRANSPORT_D 1e-9 /* [m2/s] */

/* Concentration at x [m] and time t [s]. */
typedef double (*transport_field_fn)(const val_lab *lab, const double *x, double t);

static void transport_start(val_job *job, transport_field_fn field)
{
    pd_transport *t = &job->lab->transport;
    for (int32_t i = 0; i < t->grid->total; i++) {
        double x[PD_DIM];
        t->carry[i] = 0.0;
        if (t->grid->kind[i] != PD_FLUID) continue;
        pd_grid_position(t->grid, i, x);
        t->c[i] = field ? field(job->lab, x, 0.0) : 0.0;
    }
}

static pd_status transport_steps(val_job *job, double dt, int steps)
{
    pd_transport_result result;
    for (int k = 0; k < steps; k++) {
        PD_TRY(pd_transport_implicit(job->ctx, &job->lab->transport, dt, &result));
        job->out->residual = fmax(job->out->residual, result.residual);
        job->out->steps++;
    }
    return PD_OK;
}

/* The fields at the times t[0 .. count-1] from the start `field`, into lab->field[0 .. count-1]. The implicit step is
 * of first order in time; runs with N, 2N and 4N steps between two times combine as (c_N - 6 c_2N + 8 c_4N)/3. That
 * leaves an error of third order, so that what is measured is the error in space. */
static pd_status transport_extrapolate(val_job *job, transport_field_fn field, const double *t, int count, int steps)
{
    static const double weight[3] = {1.0 / 3.0, -2.0, 8.0 / 3.0};
    val_lab *lab = job->lab;
    PD_TRY(lab_fields(job->ctx, lab, count, 1));
    for (int run = 0; run < 3; run++) {
        double time = 0.0;
        transport_start(job, field);
        for (int k = 0; k < count; k++) {
            int n = steps << run;
            PD_TRY(transport_steps(job, (t[k] - time) / n, n));
            for (int32_t i = 0; i < lab->grid.total; i++) lab->field[k][i] += weight[run] * lab->transport.c[i];
            time = t[k];
        }
    }
    return PD_OK;
}

/* Relative L2 and largest absolute difference of c from the closed form at t. */
static void transport_errors(const val_lab *lab, const double *c, transport_field_fn field, double t, double *l2,
                             double *largest)
{
    val_squares sum = {0.0, 0.0};
    *largest = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        double exact = field(lab, x, t);
        val_squares_add(&sum, 1.0, c[i], exact);
        *largest = fmax(*largest, fabs(c[i] - exact));
    }
    *l2 = val_squares_l2(&sum);
}

/* c and the closed form along x through the middle of the box, or along its mirrors. */
static void transport_curves(val_job *job, const double *c, transport_field_fn field, double t, const char *title,
                             const char *label)
{
    const val_lab *lab = job->lab;
    if (!job->profile) return;
    job->profile->title = title;
    job->profile->x_label = "x [um]";
    job->profile->y_label = label;
    val_curve *exact = val_add_curve(job, "closed form", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    int i[PD_DIM], every = lab->grid.n[0] / 60 + 1;
    for (int d = 0; d < PD_DIM; d++) i[d] = lab->grid.side[2 * d] == PD_SIDE_MIRROR ? 0 : lab->grid.n[d] / 2;
    for (i[0] = 0; i[0] < lab->grid.n[0]; i[0]++) {
        double x[PD_DIM];
        int32_t node = pd_grid_node(&lab->grid, i);
        pd_grid_position(&lab->grid, node, x);
        val_add_point(exact, 1e6 * x[0], field(lab, x, t));
        if (i[0] % every == 0) val_add_point(found, 1e6 * x[0], c[node]);
    }
}

/* ---- diffusion: a Gaussian ---- */

#define GAUSS_SIGMA 10e-6                                               /* [m] at the start */
#define GAUSS_TIME (0.5 * GAUSS_SIGMA * GAUSS_SIGMA / TRANSPORT_D)      /* [s] until the variance has doubled */

static double gauss_field(const val_lab *lab, const double *x, double t)
{
    double s2 = GAUSS_SIGMA * GAUSS_SIGMA + 2.0 * TRANSPORT_D * t, r2 = 0.0, c = 1.0;
    (void)lab;
    for (int d = 0; d < PD_DIM; d++) {
        r2 += x[d] * x[d];
        c *= GAUSS_SIGMA / sqrt(s2);
    }
    return c * exp(-0.5 * r2 / s2);
}

/* Box from -8 sigma to 8 sigma, where the field stays below 2e-7 of its peak. 3D: the octant from 0 to 6 sigma (2e-4)
 * between mirrors. */
static pd_status gauss_build(val_job *job)
{
    val_lab *lab = job->lab;
    double half = (PD_DIM == 3 ? 6.0 : 8.0) * GAUSS_SIGMA;
    lab_box(lab, GAUSS_SIGMA / job->level.n, job->level.m, PD_DIM == 3 ? 0.0 : -half, half);
    for (int d = 0; d < PD_DIM && PD_DIM == 3; d++) lab->grid_desc.side[2 * d] = PD_SIDE_MIRROR;
    lab->transport_desc.diffusivity = TRANSPORT_D;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT));
    job->out->h = lab->grid.h[0];
    return PD_OK;
}

static pd_status gauss_space_run(val_job *job)
{
    double end = GAUSS_TIME, largest;
    PD_TRY(gauss_build(job));
    PD_TRY(transport_extrapolate(job, gauss_field, &end, 1, 8));
    transport_errors(job->lab, job->lab->field[0], gauss_field, end, &job->out->err[0], &largest);
    job->out->err[1] = largest;
    transport_curves(job, job->lab->field[0], gauss_field, end, "Spreading Gaussian", "c [-]");
    return PD_OK;
}

#define GAUSS_GUARD (PD_DIM == 3 ? 8e-2 : PD_DIM == 2 ? 2.3e-2 : 1.3e-2)
#define GAUSS_ERRORS {{"err_l2", "c, L2"}, {"err_max", "c, largest"}}, 2

static const val_part gauss_space = {
    "gaussian", "Gaussian, order in space", "sigma/h", VAL_BY_N, NULL, 2.0, GAUSS_ERRORS,
#if PD_DIM == 3
    {{0, 1e-3, 0.0, 8, VAL_GOAL}, {0, 0.0, 1.9, 2, VAL_GOAL}, {0, GAUSS_GUARD, 0.0, 0, VAL_GUARD}}, 3,
    {{2, 1.0, 0.0}, {4, 1.0, 0.0}, {8, 1.0, 0.0}}, 3, 2,
#elif PD_DIM == 2
    {{0, 1e-3, 0.0, 24, VAL_GOAL}, {0, 0.0, 1.9, 6, VAL_GOAL}, {0, GAUSS_GUARD, 0.0, 0, VAL_GUARD}}, 3,
    {{3, 1.0, 0.0}, {6, 1.0, 0.0}, {12, 1.0, 0.0}, {24, 1.0, 0.0}}, 4, 3,
#else
    {{0, 1e-3, 0.0, 24, VAL_GOAL}, {0, 0.0, 1.9, 6, VAL_GOAL}, {0, GAUSS_GUARD, 0.0, 0, VAL_GUARD}}, 3,
    {{3, 1.0, 0.0}, {6, 1.0, 0.0}, {12, 1.0, 0.0}, {24, 1.0, 0.0}, {48, 1.0, 0.0}}, 5, 5,
#endif
    gauss_space_run, NULL};

#if PD_DIM < 3
/* p steps, not extrapolated. */
static pd_status gauss_time_run(val_job *job)
{
    double end = GAUSS_TIME, largest;
    int steps = (int)job->level.p;
    PD_TRY(gauss_build(job));
    transport_start(job, gauss_field);
    PD_TRY(transport_steps(job, end / steps, steps));
    transport_errors(job->lab, job->lab->transport.c, gauss_field, end, &job->out->err[0], &largest);
    job->out->err[1] = largest;
    job->out->x = 1.0 / steps;
    return PD_OK;
}

static const val_part gauss_time = {
    "time", "Gaussian, order in time of the implicit step", "steps", VAL_BY_P, "1/steps [-]", 1.0, GAUSS_ERRORS,
    {{0, 0.0, 0.9, 0, VAL_GUARD}}, 1,
    {{24, 1.0, 2.0}, {24, 1.0, 4.0}, {24, 1.0, 8.0}, {24, 1.0, 16.0}}, 4, PD_DIM == 1 ? 4 : 0,
    gauss_time_run, NULL};
#endif

/* ---- diffusion: Crank's slab ---- */

#define SLAB_L 100e-6 /* [m] half-thickness */
static const double slab_fo[4] = {0.1, 0.2, 0.5, 1.0}; /* [-] D t/l^2 */

/* Slab 0 <= x <= 2 l, both surfaces at 1 from t = 0 on (Crank, The Mathematics of Diffusion, eq. 4.17). */
static double slab_field(const val_lab *lab, const double *x, double t)
{
    double fo = TRANSPORT_D * t / (SLAB_L * SLAB_L), c = 1.0;
    (void)lab;
    for (int k = 0; k < 200; k++) {
        double q = (k + 0.5) * val_pi;
        c -= 2.0 / q * exp(-q * q * fo) * sin(q * x[0] / SLAB_L);
    }
    return c;
}

/* Mt/Minf (Crank, eq. 4.18). */
static double slab_uptake(double fo)
{
    double sum = 1.0;
    for (int k = 0; k < 200; k++) {
        double q = (k + 0.5) * val_pi;
        sum -= 2.0 / (q * q) * exp(-q * q * fo);
    }
    return sum;
}

/* Walls that hold 1 at x = 0 and nothing elsewhere. */
static double slab_held(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-9 * SLAB_L ? 1.0 : (double)NAN;
}

/* Edge of the boxes across the layers. */
#define SLAB_ACROSS (PD_DIM == 3 ? 0.5 * SLAB_L : SLAB_L)

/* Half of the slab: the surface is a wall that holds its concentration, the middle and the other sides are mirrors. */
static pd_status slab_run(val_job *job)
{
    val_lab *lab = job->lab;
    double t[4];
    lab_box(lab, SLAB_L / job->level.n, job->level.m, 0.0, SLAB_ACROSS);
    lab->grid_desc.hi[0] = SLAB_L;
    for (int side = 1; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_MIRROR;
    lab->transport_desc.diffusivity = TRANSPORT_D;
    lab->transport_desc.held = slab_held;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT));
    job->out->h = lab->grid.h[0];
    for (int k = 0; k < 4; k++) t[k] = slab_fo[k] * SLAB_L * SLAB_L / TRANSPORT_D;
    PD_TRY(transport_extrapolate(job, NULL, t, 4, PD_DIM == 3 ? 8 : 16));
    for (int k = 0; k < 4; k++) {
        double sum = 0.0, l2, largest;
        for (int32_t i = 0; i < lab->grid.total; i++)
            if (lab->grid.kind[i] == PD_FLUID) sum += lab->field[k][i];
        sum /= (double)lab->grid.fluid_count;
        transport_errors(lab, lab->field[k], slab_field, t[k], &l2, &largest);
        job->out->err[0] = fmax(job->out->err[0], fabs(sum - slab_uptake(slab_fo[k])));
        job->out->err[1] = fmax(job->out->err[1], largest);
    }
    transport_curves(job, lab->field[1], slab_field, t[1], "Crank's slab at Fo = 0.2", "c [-]");
    return PD_OK;
}

#define SLAB_LEVELS \
    {{10, 1.0, 0.0}, {20, 1.0, 0.0}, {40, 1.0, 0.0}, {80, 1.0, 0.0}}, PD_DIM == 3 ? 3 : 4, PD_DIM == 3 ? 1 : 2

static const val_part slab_part = {
    "slab", "Crank's slab between held walls", "nodes across l", VAL_BY_N, NULL, 2.0,
    {{"err", "uptake"}, {"err_max", "profile"}}, 2,
    {{0, 1e-3, 0.0, 40, VAL_GOAL}, {0, 0.0, 1.9, 0, VAL_GOAL}, {0, 2e-2, 0.0, 0, VAL_GUARD}}, 3, SLAB_LEVELS, slab_run,
    NULL};

/* ---- diffusion: a cosine between walls without flux ---- */

#define COSINE_END (0.1 * SLAB_L * SLAB_L / TRANSPORT_D) /* [s] until the amplitude is 0.37 */

static double cosine_field(const val_lab *lab, const double *x, double t)
{
    double k = val_pi / SLAB_L;
    (void)lab;
    return 1.0 + exp(-TRANSPORT_D * k * k * t) * cos(k * x[0]);
}

/* All sides are closed: diffusion goes towards the walls of x and along the others. */
static pd_status cosine_run(val_job *job)
{
    val_lab *lab = job->lab;
    double end = COSINE_END;
    lab_box(lab, SLAB_L / job->level.n, job->level.m, 0.0, SLAB_ACROSS);
    lab->grid_desc.hi[0] = SLAB_L;
    lab->transport_desc.diffusivity = TRANSPORT_D;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT));
    PD_TRY(transport_extrapolate(job, cosine_field, &end, 1, 8));
    transport_errors(lab, lab->field[0], cosine_field, end, &job->out->err[0], &job->out->err[1]);
    job->out->h = lab->grid.h[0];
    transport_curves(job, lab->field[0], cosine_field, end, "Cosine between closed walls", "c [-]");
    return PD_OK;
}

static const val_part cosine_part = {
    "cosine", "Cosine between closed walls", "nodes across", VAL_BY_N, NULL, 2.0,
    {{"err_l2", "c, L2"}, {"err_max", "c, largest"}}, 2,
    {{0, 1e-3, 0.0, 40, VAL_GOAL}, {0, 0.0, 1.9, 0, VAL_GOAL}, {0, 2e-2, 0.0, 0, VAL_GUARD}}, 3, SLAB_LEVELS,
    cosine_run, NULL};

/* ---- diffusion: two materials ---- */

/* [m] of the interface, the fast material lies before it: a third or two thirds of a cell from a face at all levels,
 * since the constant of the error depends on that. */
#define LAYER_PLACE (SLAB_L / 3.0)

/* Ratio of the diffusivities: parameter of the level. */
static double layer_ratio(const val_lab *lab) { return lab->transport_desc.diffusivity / TRANSPORT_D; }

static double layer_level(void *user, const double *x)
{
    (void)user;
    return x[0] - LAYER_PLACE;
}

static double layer_diffusivity(void *user, const double *x)
{
    return x[0] < LAYER_PLACE ? layer_ratio((const val_lab *)user) * TRANSPORT_D : TRANSPORT_D;
}

/* Walls that hold 0 at x = l. */
static double layer_drain(void *user, const double *x)
{
    (void)user;
    return x[0] > (1.0 - 1e-9) * SLAB_L ? 0.0 : (double)NAN;
}

/* Walls that hold 0 at x = 0 and 1 at x = l. */
static double layer_ends(void *user, const double *x)
{
    return x[0] < 1e-9 * SLAB_L ? 0.0 : layer_drain(user, x) + 1.0;
}

/* Wave number [1/m] in the slow material of the slowest mode of both layers, closed at x = 0 and held at 0 at x = l:
 * cos(k' x) before the interface and sin(k (l - x)) behind it, D' k'^2 = D k^2, D' k' tan(k' a) = D k cot(k b). The
 * difference of both sides rises with k; bisection. */
static double layer_wave(const val_lab *lab)
{
    double a = LAYER_PLACE, b = SLAB_L - LAYER_PLACE, root = sqrt(layer_ratio(lab)), lo = 0.0, hi = 0.5 * val_pi / b;
    for (int step = 0; step < 200; step++) {
        double k = 0.5 * (lo + hi);
        if (root * tan(k / root * a) * tan(k * b) < 1.0) lo = k;
        else hi = k;
    }
    return 0.5 * (lo + hi);
}

/* The mode, 1 at x = 0 and t = 0. */
static double layer_field(const val_lab *lab, const double *x, double t)
{
    double k = layer_wave(lab), slow = k / sqrt(layer_ratio(lab)), top = cos(slow * LAYER_PLACE);
    double shape = x[0] < LAYER_PLACE ? cos(slow * x[0])
                                      : top * sin(k * (SLAB_L - x[0])) / sin(k * (SLAB_L - LAYER_PLACE));
    return shape * exp(-TRANSPORT_D * k * k * t);
}

static double layer_steady(const val_lab *lab, const double *x, double t)
{
    double ratio = layer_ratio(lab), flux = 1.0 / (LAYER_PLACE / ratio + SLAB_L - LAYER_PLACE);
    (void)t;
    return flux * (fmin(x[0], LAYER_PLACE) / ratio + fmax(x[0] - LAYER_PLACE, 0.0));
}

static pd_status layer_build(val_job *job, pd_point_fn held)
{
    val_lab *lab = job->lab;
    lab_box(lab, SLAB_L / job->level.n, job->level.m, 0.0, PD_DIM == 3 ? 0.2 * SLAB_L : 0.4 * SLAB_L);
    lab->grid_desc.hi[0] = SLAB_L;
    for (int side = 2; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    lab->transport_desc.diffusivity = job->level.p * TRANSPORT_D;
    lab->transport_desc.field = layer_diffusivity;
    lab->transport_desc.user = lab;
    lab->transport_desc.level = layer_level;
    lab->transport_desc.held = held;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT));
    job->out->h = lab->grid.h[0];
    return PD_OK;
}

/* The mode decays to 1/e. */
static pd_status layer_run(val_job *job)
{
    double k, end;
    PD_TRY(layer_build(job, layer_drain));
    k = layer_wave(job->lab);
    end = 1.0 / (TRANSPORT_D * k * k);
    PD_TRY(transport_extrapolate(job, layer_field, &end, 1, 16));
    transport_errors(job->lab, job->lab->field[0], layer_field, end, &job->out->err[0], &job->out->err[1]);
    transport_curves(job, job->lab->field[0], layer_field, end, "Two materials: slowest mode", "c [-]");
    return PD_OK;
}

static pd_status layer_steady_run(val_job *job)
{
    double l2;
    PD_TRY(layer_build(job, layer_ends));
    transport_start(job, NULL);
    PD_TRY(transport_steps(job, 1e14 * SLAB_L * SLAB_L / TRANSPORT_D, 4));
    transport_errors(job->lab, job->lab->transport.c, layer_steady, 0.0, &l2, &job->out->err[0]);
    return PD_OK;
}

#define LAYER_MODE(ratio) \
    "nodes across", VAL_BY_N, NULL, 2.0, {{"err_l2", "c, L2"}, {"err_max", "c, largest"}}, 2, \
    {{0, 1e-3, 0.0, 40, VAL_GOAL}, {0, 0.0, 1.9, 0, VAL_GOAL}, {0, 2e-2, 0.0, 0, VAL_GUARD}}, 3, \
    {{10, 1.0, ratio}, {20, 1.0, ratio}, {40, 1.0, ratio}, {80, 1.0, ratio}}, PD_DIM == 3 ? 3 : 4

static const val_part layer_part = {"layers", "Two materials, ratio of D 1e4: slowest mode", LAYER_MODE(1e4),
                                    PD_DIM == 3 ? 1 : 2, layer_run, NULL};
static const val_part layer_far_part = {
    "layers_far", "Two materials, ratio of D 1e8: slowest mode", LAYER_MODE(1e8), 0, layer_run,
    NULL};
static const val_part layer_steady_part = {
    "layers_steady", "Two materials, ratio of D 1e8: steady between held walls", "nodes across", VAL_BY_N, NULL, 0.0,
    {{"err_max", "c, largest"}}, 1, {{0, 1e-9, 0.0, 0, VAL_GOAL}}, 1,
    {{10, 1.0, 1e8}, {20, 1.0, 1e8}, {40, 1.0, 1e8}, {80, 1.0, 1e8}}, PD_DIM == 3 ? 3 : 4, 2, layer_steady_run, NULL};

#if PD_DIM < 3
static const val_part *const diffusion_parts[] = {&gauss_space, &gauss_time, &slab_part,
                                                  &cosine_part, &layer_part, &layer_far_part,
                                                  &layer_steady_part};
#else
static const val_part *const diffusion_parts[] = {&gauss_space, &slab_part, &cosine_part,
                                                  &layer_part, &layer_far_part, &layer_steady_part};
#endif

static const val_case diffusion_case = {
    "diffusion", "Diffusion",
    "A Gaussian spreads until its variance has doubled, in a box that it does not reach the sides of. A slab takes up "
    "metal from its surface, a wall that holds its concentration, at Fo = 0.1, 0.2, 0.5 and 1. A cosine decays in a "
    "closed box. Two materials with very different diffusivities, the fast one before the slow one, drain into a wall: "
    "the slowest mode of both decays to 1/e. These are extrapolated to time steps of length zero. At last the steady "
    "profile through both materials.",
    "Uncalibrated weights, wrong powers of h, walls that slow down diffusion beside them, boundary values or "
    "interfaces in the wrong place, harmonic means that ignore where an interface lies.",
    "closed forms; slab: J. Crank, The Mathematics of Diffusion, 2nd ed., Oxford, 1975, eq. 4.17 and 4.18",
    diffusion_parts, (int)(sizeof diffusion_parts / sizeof diffusion_parts[0])};

/* ---- advection ---- */

#define PULSE_SPEED 1e-3 /* [m/s] along x; half of it along y and z */
#define PULSE_H 1e-6     /* [m] */
#define PULSE_TRAVEL (PD_DIM == 1 ? 16.0 : PD_DIM == 2 ? 8.0 : 2.0) /* [-] cells along x */

static void pulse_velocity(void *user, const double *x, double *u)
{
    (void)user, (void)x;
    for (int d = 0; d < PD_DIM; d++) u[d] = PULSE_SPEED / (d ? 2.0 : 1.0);
}

/* Gaussian of peak 1 at the start; its width stands in the desc as reference length of the flow. */
static double pulse_field(const val_lab *lab, const double *x, double t)
{
    double sigma = lab->flow_desc.report_length, s2 = sigma * sigma + 2.0 * lab->transport_desc.diffusivity * t;
    double u[PD_DIM], r2 = 0.0, c = 1.0;
    pulse_velocity(NULL, x, u);
    for (int d = 0; d < PD_DIM; d++) {
        r2 += (x[d] - u[d] * t) * (x[d] - u[d] * t);
        c *= sigma / sqrt(s2);
    }
    return c * exp(-0.5 * r2 / s2);
}

/* Uniform oblique flow through a box with inlets on the low sides and outlets on the high ones. */
static pd_status pulse_build(val_job *job)
{
    val_lab *lab = job->lab;
    double n = job->level.n, width = sqrt(n * n + 2.0 * PULSE_TRAVEL / job->level.p); /* cells, at the end */
    double margin = ceil((PD_DIM == 3 ? 4.0 : 5.0) * width);
    lab_box(lab, PULSE_H, job->level.m, -margin * PULSE_H, margin * PULSE_H);
    for (int d = 0; d < PD_DIM; d++) {
        lab->grid_desc.hi[d] = (margin + PULSE_TRAVEL / (d ? 2.0 : 1.0)) * PULSE_H;
        lab->grid_desc.side[2 * d] = PD_SIDE_INLET;
        lab->grid_desc.side[2 * d + 1] = PD_SIDE_OUTLET;
    }
    lab->flow_desc.rho = 1000.0;
    lab->flow_desc.mu = 1e-3;
    lab->flow_desc.report_speed = PULSE_SPEED;
    lab->flow_desc.report_length = job->level.n * PULSE_H;
    lab->flow_desc.inlet = pulse_velocity;
    lab->transport_desc.diffusivity = PULSE_SPEED * PULSE_H / job->level.p;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double u[PD_DIM];
        pulse_velocity(NULL, u, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
    }
    pdi_flow_update_derived_fields(job->ctx, &lab->flow);
    job->out->h = PULSE_H;
    return PD_OK;
}

/* Distance of the centre of mass from its place in cells, and how far the field leaves [0, 1]. */
static void pulse_errors(val_job *job, double t)
{
    const val_lab *lab = job->lab;
    double sum = 0.0, centre[PD_DIM], u[PD_DIM], beyond = 0.0, largest;
    for (int d = 0; d < PD_DIM; d++) centre[d] = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], c = lab->transport.c[i];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        sum += c;
        for (int d = 0; d < PD_DIM; d++) centre[d] += c * x[d];
        beyond = fmax(beyond, fmax(c - 1.0, -c));
    }
    pulse_velocity(NULL, centre, u);
    for (int d = 0; d < PD_DIM; d++) centre[d] = (centre[d] / sum - u[d] * t) / PULSE_H;
    job->out->err[0] = pdi_vec_norm(centre);
    job->out->err[1] = beyond;
    transport_errors(lab, lab->transport.c, pulse_field, t, &job->out->err[2], &largest);
}

static pd_status pulse_run(val_job *job)
{
    double t = PULSE_TRAVEL * PULSE_H / PULSE_SPEED;
    int steps = (int)(PULSE_TRAVEL * (PD_DIM == 3 ? 4.0 : 10.0));
    PD_TRY(pulse_build(job));
    transport_start(job, pulse_field);
    PD_TRY(transport_steps(job, t / steps, steps));
    pulse_errors(job, t);
    transport_curves(job, job->lab->transport.c, pulse_field, t, "Advected Gaussian, cell Peclet number 0.5", "c [-]");
    return PD_OK;
}

static pd_status pulse_limited_run(val_job *job)
{
    job->lab->transport_desc.advection = PD_ADVECTION_LIMITED;
    return pulse_run(job);
}

static pd_status pulse_upwind_run(val_job *job)
{
    job->lab->transport_desc.advection = PD_ADVECTION_UPWIND;
    return pulse_run(job);
}

#define PULSE_MEASURES {{"err", "position [h]"}, {"overshoot", "overshoot"}, {"err_l2", "c, L2"}}, 3
#define PULSE_GOALS {{0, 0.1, 0.0, 0, VAL_GOAL}, {1, 1e-9, 0.0, 0, VAL_GOAL}}, 2
#if PD_DIM == 3
#define PULSE_LEVELS {{3, 1.0, 5e5}, {3, 1.0, 0.5}}, 2
#else
#define PULSE_LEVELS {{6, 1.0, 5e5}, {6, 1.0, 500.0}, {6, 1.0, 50.0}, {6, 1.0, 5.0}, {6, 1.0, 0.5}}, 5
#endif

static const val_part pulse_limited = {"limited", "limited", "cell Peclet", VAL_BY_P, "cell Peclet number [-]", 0.0,
                                       PULSE_MEASURES, PULSE_GOALS, PULSE_LEVELS, PD_DIM == 1 ? 5 : 1,
                                       pulse_limited_run, NULL};
static const val_part pulse_upwind = {"upwind", "upwind", "cell Peclet", VAL_BY_P, "cell Peclet number [-]", 0.0,
                                      PULSE_MEASURES, PULSE_GOALS, PULSE_LEVELS, PD_DIM == 1 ? 5 : 0,
                                      pulse_upwind_run, NULL};
static const val_part *const advection_parts[] = {&pulse_limited, &pulse_upwind};

static const val_case advection_case = {
    "advection", "A pulse in a uniform flow",
    "A Gaussian is carried over 16 cells (2D: 8, 3D: 2) through a box, obliquely in 2D and 3D, at cell Peclet numbers "
    "U h/D from 0.5 to 5e5, with implicit steps. Its centre of mass against its place, in cells; how far the "
    "field leaves its bounds (the linear solver keeps them to 1e-9); "
    "and the error of the field, most of which comes from steps of a tenth of a cell (3D: a quarter).",
    "Sums of upwind and downwind bonds that cancel (advection at 0.6 of its speed), upwind bonds counted once (half "
    "speed at high Peclet numbers), oscillations, clamps.",
    "closed form",
    advection_parts, 2};

#endif
