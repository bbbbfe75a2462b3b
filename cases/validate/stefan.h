/* stefan: the pencil electrode, metal that dissolves as fast as diffusion carries it away. */
#ifndef VAL_STEFAN_H
#define VAL_STEFAN_H

#define STEFAN_D 8.5e-10       /* [m2/s] */
#define STEFAN_CS 143e3        /* [mol/m3] */
#define STEFAN_CSAT 5.1e3      /* [mol/m3] */
#define STEFAN_LAMBDA 0.13515753 /* [-] root of sqrt(pi) l exp(l^2) erf(l) = Csat/(Cs - Csat) */
#define STEFAN_START 8e-6      /* [m] depth at which the run starts, on the closed form */

/* pencil304_stefan.csv, column A: 304 steel pencil electrode, c = 0 held at the original surface. */
static const double stefan_time[3] = {10.0, 100.0, 300.0};            /* [s] */
static const double stefan_depth[3] = {24.9218e-6, 78.8097e-6, 136.5024e-6}; /* [m] */

/* Walls that hold 0 at the original surface. */
static double stefan_held(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-9 * STEFAN_START ? 0.0 : (double)NAN;
}

/* Metal from the front down to `bottom` [m]; the side x- is the original surface. */
static void stefan_metal(const val_job *job, double bottom, double width)
{
    val_lab *lab = job->lab;
    lab_box(lab, STEFAN_START / job->level.n, job->level.m, 0.0, width);
    lab->grid_desc.hi[0] = bottom;
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_HALF_SPACE;
    lab->shapes[0].a[0] = STEFAN_START;
    lab->shapes[0].b[0] = -1.0;
}

static pd_status stefan_build(val_job *job, double bottom, double width, val_law *law)
{
    val_lab *lab = job->lab;
    stefan_metal(job, bottom, width);
    lab->surface_m = 3.0;
    lab->transport_desc.diffusivity = STEFAN_D;
    lab->transport_desc.held = stefan_held;
    lab->dissolve_desc.solid = STEFAN_CS;
    lab->dissolve_desc.rate = dissolution_law;
    lab->dissolve_desc.rate_user = law;
    return lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE);
}

/* c = Csat erf(lambda x/depth)/erf(lambda). */
static double stefan_field(double x, double depth)
{
    return STEFAN_CSAT * erf(STEFAN_LAMBDA * x / depth) / erf(STEFAN_LAMBDA);
}

static double stefan_now(val_job *job, double bottom)
{
    const val_lab *lab = job->lab;
    return bottom - (bottom - STEFAN_START) * lab->couple.ledger[0].solid / lab->couple.ledger[0].solid_start;
}

static void stefan_titles(val_job *job)
{
    if (!job->profile) return;
    job->profile->title = "Depth of the pencil electrode";
    job->profile->x_label = "t [s]";
    job->profile->y_label = "depth [um]";
}

static pd_status stefan_run(val_job *job)
{
    val_lab *lab = job->lab;
    int times = PD_DIM == 3 ? 1 : PD_DIM == 2 ? 2 : 3;
    double bottom = (PD_DIM == 3 ? 40.0 : PD_DIM == 2 ? 96.0 : 160.0) * 1e-6, width = 3.0 * STEFAN_START;
    double start = STEFAN_START / (2.0 * STEFAN_LAMBDA), next;
    val_law law = {1e-3, STEFAN_CSAT};
    start = start * start / STEFAN_D; /* [s] on the clock of the closed form */
    PD_TRY(stefan_build(job, bottom, width, &law));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        if (lab->grid.kind[i] == PD_FLUID) lab->transport.c[i] = stefan_field(x[0], STEFAN_START);
    }
    stefan_titles(job);
    val_curve *exact = val_add_curve(job, "closed form", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    job->out->h = lab->grid.h[0];
    PD_TRY(pd_time_loop_start(job->ctx, &lab->couple));
    for (int k = 0; k < times; k++) {
        for (int part = 1; part <= 10; part++) {
            double from = k ? stefan_time[k - 1] : start;
            next = from + (stefan_time[k] - from) * part / 10.0;
            while (lab->couple.time < next - start) PD_TRY(pd_time_loop_step(job->ctx, &lab->couple, next - start));
            for (int q = 4; q >= 0; q--) {
                double at = next - (stefan_time[k] - from) * q / 50.0;
                val_add_point(exact, at, 2e6 * STEFAN_LAMBDA * sqrt(STEFAN_D * at));
            }
            val_add_point(found, next, 1e6 * stefan_now(job, bottom));
        }
        job->out->err[k] = fabs(stefan_now(job, bottom) / stefan_depth[k] - 1.0);
    }
    job->out->steps = (long)lab->couple.steps;
    return PD_OK;
}

#define STEFAN_MISS \
    "First order: where the metal stands within its cell is known on average only, and nodes leave the solid one " \
    "cell at a time."

static const val_part stefan_surface_part = {
    "surface", "Surface rate", "8 um/h", VAL_BY_N, NULL, 1.0,
#if PD_DIM == 3
    {{"err_10s", "10 s"}}, 1, {{0, 1e-2, 0.0, 4, VAL_GOAL}, {0, 3e-2, 0.0, 2, VAL_GUARD}}, 2,
    {{1, 1.0, 0.0}, {2, 1.0, 0.0}, {4, 1.0, 0.0}}, 3, 2,
#elif PD_DIM == 2
    {{"err_10s", "10 s"}, {"err_100s", "100 s"}}, 2,
    {{0, 1e-2, 0.0, 8, VAL_GOAL}, {1, 1e-2, 0.0, 8, VAL_GOAL}, {0, 6e-2, 0.0, 2, VAL_GUARD},
     {1, 3e-2, 0.0, 2, VAL_GUARD}}, 4,
    {{1, 1.0, 0.0}, {2, 1.0, 0.0}, {4, 1.0, 0.0}, {8, 1.0, 0.0}}, 4, 2,
#else
    {{"err_10s", "10 s"}, {"err_100s", "100 s"}, {"err_300s", "300 s"}}, 3,
    {{0, 1e-2, 0.0, 16, VAL_GOAL}, {1, 1e-2, 0.0, 16, VAL_GOAL}, {2, 1e-2, 0.0, 16, VAL_GOAL},
     {0, 3e-2, 0.0, 4, VAL_GUARD}, {2, 9e-3, 0.0, 4, VAL_GUARD}}, 5,
    {{1, 1.0, 0.0}, {2, 1.0, 0.0}, {4, 1.0, 0.0}, {8, 1.0, 0.0}, {16, 1.0, 0.0}}, 5, 3,
#endif
    stefan_run, STEFAN_MISS};
/* ---- bond-based, in implicit steps ---- */

static double stefan_fast_law(void *user, const pd_rate_at *at)
{
    (void)user, (void)at;
    return 1e-5; /* [m/s], a hundred times that of the front at its start: the salt layer rules */
}

/* A column of two cells between periodic sides. */
static pd_status stefan_bonds_build(val_job *job, double bottom)
{
    val_lab *lab = job->lab;
    stefan_metal(job, bottom, 2.0 * STEFAN_START / job->level.n);
    for (int side = 2; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    lab->transport_desc.diffusivity = STEFAN_D;
    lab->transport_desc.held = stefan_held;
    lab->dissolve_desc.model = PD_METAL_BONDS;
    lab->dissolve_desc.solid = STEFAN_CS;
    lab->dissolve_desc.saturation = STEFAN_CSAT;
    lab->dissolve_desc.rate = stefan_fast_law;
    lab->dissolve_desc.uniform = 1;
    lab->couple_desc.fraction = 0.2;
    return lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE);
}

static pd_status stefan_bonds_run(val_job *job)
{
    val_lab *lab = job->lab;
    int times = PD_DIM == 3 ? 1 : 3;
    double bottom = (PD_DIM == 3 ? 40.0 : 160.0) * 1e-6, begin = STEFAN_START / (2.0 * STEFAN_LAMBDA);
    begin = begin * begin / STEFAN_D; /* [s] on the clock of the closed form */
    PD_TRY(stefan_bonds_build(job, bottom));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        if (lab->grid.kind[i] == PD_FLUID) lab->transport.c[i] = stefan_field(x[0], STEFAN_START);
    }
    job->out->h = lab->grid.h[0];
    for (int k = 0; k < times; k++) {
        PD_TRY(pd_time_loop_run(job->ctx, &lab->couple, stefan_time[k] - begin, 0.0, NULL, NULL));
        job->out->err[k] = fabs(stefan_now(job, bottom) / stefan_depth[k] - 1.0);
    }
    job->out->steps = (long)lab->couple.steps;
    return PD_OK;
}

#define STEFAN_BONDS_MISS "First order: fluid beside the front is at saturation one cell early."

static const val_part stefan_bonds_part = {
    "bonds", "Bond-based", "8 um/h", VAL_BY_N, NULL, 1.0,
#if PD_DIM == 3
    {{"err_10s", "10 s"}}, 1, {{0, 1e-2, 0.0, 32, VAL_GOAL}, {0, 0.0, 0.9, 0, VAL_GOAL}}, 2,
    {{2, 1.0, 0.0}, {4, 1.0, 0.0}, {8, 1.0, 0.0}, {16, 1.0, 0.0}, {32, 1.0, 0.0}}, 5, 2,
#elif PD_DIM == 2
    {{"err_10s", "10 s"}, {"err_100s", "100 s"}, {"err_300s", "300 s"}}, 3,
    {{0, 1e-2, 0.0, 32, VAL_GOAL}, {1, 1e-2, 0.0, 16, VAL_GOAL}, {2, 1e-2, 0.0, 8, VAL_GOAL},
     {0, 0.0, 0.9, 0, VAL_GOAL}}, 4,
    {{2, 1.0, 0.0}, {4, 1.0, 0.0}, {8, 1.0, 0.0}, {16, 1.0, 0.0}, {32, 1.0, 0.0}}, 5, 2,
#else
    {{"err_10s", "10 s"}, {"err_100s", "100 s"}, {"err_300s", "300 s"}}, 3,
    {{0, 1e-2, 0.0, 16, VAL_GOAL}, {1, 1e-2, 0.0, 8, VAL_GOAL}, {2, 1e-2, 0.0, 4, VAL_GOAL},
     {0, 0.0, 0.9, 0, VAL_GOAL}}, 4,
    {{2, 3.0, 0.0}, {4, 3.0, 0.0}, {8, 3.0, 0.0}, {16, 3.0, 0.0}}, 4, 2,
#endif
    stefan_bonds_run, STEFAN_BONDS_MISS};

static const val_part *const stefan_parts[] = {&stefan_surface_part, &stefan_bonds_part};

static const val_case stefan_case = {
    "stefan", "Pencil electrode",
    "304 steel dissolves as fast as metal diffuses away: c = 0 at the original surface, a held wall, saturation "
    "at the front. The run starts on the closed form at a depth of 8 um; the law is 1e-3 m/s (1 - c/Csat). Depth "
    "at 10, 100 and 300 s against 24.92, 78.81 and 136.5 um; in 2D and 3D the pencil is a column 24 um wide "
    "between walls, up to 100 s and 10 s. Then the bond-based model with a law that is ten times as fast as diffusion, "
    "so that the salt layer rules, in a column between periodic sides, up to 300 s (3D: 10 s), with the nearest "
    "neighbours in 2D and 3D: metal enters the fluid as far as its bonds reach, which with m = 3 is three cells there "
    "(15 % at 10 s with h = 2 um, of first order), and one in 1D.",
    "Sources that count neighbours, values reset when a node turns fluid, a salt layer that does not let go, metal "
    "that vanishes.",
    "closed form: depth = 2 lambda sqrt(D t), sqrt(pi) lambda exp(lambda^2) erf(lambda) = Csat/(Cs - Csat), with "
    "D = 8.5e-10 m2/s, Cs = 143 mol/L, Csat = 5.1 mol/L; table `pencil304_stefan.csv`",
    stefan_parts, 2};

#endif
