/* horizon: error against time with the horizons 1 to 3 of the fluid, in cases of `validate`; beside them that whose
 * fourth moments are isotropic, flow of fourth order and plain finite volumes. */
#ifndef BENCH_HORIZON_H
#define BENCH_HORIZON_H

enum { HORIZON_MOST = 3, HORIZON_ISOTROPIC = HORIZON_MOST, HORIZON_FOURTH, HORIZON_VOLUMES, HORIZON_FAMILIES };

/* The horizon below 2 whose fourth moments are isotropic (theory: 1.4). */
#define HORIZON_ROUND \
    (PD_DIM == 2 ? 2.0 * sqrt(2.0) - 1.5 : PD_DIM == 3 ? sqrt(3.0) - 0.5 + 0.375 * (sqrt(2.0) - 1.0) : 1.0)
#define HORIZON_ROUND_NAME (PD_DIM == 2 ? "m = 1.328" : "m = 1.387")

/* Processor time [s] of a run after which a horizon gets no finer lattice. */
#define HORIZON_LONG 15.0

typedef struct horizon_problem {
    const val_part *part;
    const char *name, *title, *y_label;
    int measure; /* of the part */
    double p;    /* parameter of all levels, with n */
    int n[5];    /* resolutions in place of those of the part; 0: none */
    pd_status (*fourth)(val_job *job); /* the part with flow of fourth order; NULL: none */
    pd_status (*volumes)(pd_ctx *ctx, int n, double p, double *err); /* NULL: none */
} horizon_problem;

#if PD_DIM == 2
#define HORIZON_OF_2D(volumes) volumes
#else
#define HORIZON_OF_2D(volumes) NULL
#endif

#if PD_DIM == 2
static pd_status horizon_cavity_fourth(val_job *job)
{
    job->lab->flow_desc.order = 4;
    job->level.m = 1.0; /* no other one has it */
    return cavity_solve(job, &cavity_1000);
}
#elif PD_DIM == 3
static pd_status horizon_duct_fourth(val_job *job) { return duct_run_order(job, 4); }
#endif

static const horizon_problem horizon_problems[] = {
#if PD_DIM == 2
    {&cavity_part_400, "cavity_400", "Lid-driven cavity, Re = 400",
     "u, largest error [-]", 0, 0.0, {32, 48, 64, 96, 128}, NULL, volumes_cavity_400},
    {&cavity_part_1000, "cavity_1000", "Lid-driven cavity, Re = 1000",
     "u, largest error [-]", 0, 0.0, {32, 48, 64, 96, 128}, horizon_cavity_fourth, volumes_cavity_1000},
    {&cavity_part_3200, "cavity_3200", "Lid-driven cavity, Re = 3200",
     "u, largest error [-]", 0, 0.0, {48, 64, 96, 128}, NULL, NULL},
    {&taylor_part, "taylor_green", "Decaying vortices", "error of u [-]", 0, 0.0, {16, 24, 32, 48, 64}, NULL, NULL},
    {&startup_poiseuille, "startup", "Start-up between plates", "error of u [-]", 0, 0.0, {0}, NULL, NULL},
    {&startup_swing, "womersley", "Womersley's flow between plates", "error of u [-]", 0, 0.0, {0}, NULL, NULL},
    {&cylinder_part, "cylinder", "Cylinder in a channel, Re = 20", "error of the drag [-]", 0, 0.0, {0}, NULL, NULL},
    {&flux_round, "pin", "Flux past a pin with round ends", "largest error of a layer [-]", 1, 0.0, {0}, NULL, NULL},
    {&annulus_flow_1, "annulus", "Flow around a wire in a tube",
     "error of u, L2 [-]", 0, 0.1, {20, 40, 80, 160, 320}, NULL, NULL},
    {&annulus_sherwood_1, "annulus_exchange", "Exchange of a wire in a tube",
     "error of Sh [-]", 0, 0.0, {0}, NULL, NULL},
    {&graetz_two_part, "graetz", "Mass transfer in a channel", "error of Sh [-]", 0, 0.0, {0}, NULL, NULL},
    {&graetz_tube_part, "graetz_tube", "Mass transfer in a tube", "error of Sh [-]", 0, 0.0, {0}, NULL, NULL},
    {&turn_near, "turn_10", "Half a turn, Pe = 10",
     "c, largest error [-]", 0, 10.0, {10, 20, 40, 80, 160}, NULL, volumes_turn},
    {&turn_near, "turn_100", "Half a turn, Pe = 100",
     "c, largest error [-]", 0, 100.0, {10, 20, 40, 80, 160}, NULL, volumes_turn},
    {&turn_near, "turn_1e6", "Half a turn, Pe = 1e6",
     "c, largest error [-]", 0, 1e6, {10, 20, 40, 80, 160}, NULL, volumes_turn},
    {&rotation_cone_part, "cone", "A cone after one turn",
     "c, L1 over that of the cone [-]", 1, 0.0, {25, 50, 100}, NULL, volumes_cone},
    {&rotation_disc_part, "disc", "A slotted disc after one turn",
     "c, L1 over that of the disc [-]", 1, 0.0, {25, 50, 100}, NULL, volumes_disc},
#endif
#if PD_DIM == 3
    {&hagen_part, "hagen", "Flow through a tube", "u, L2 [-]", 0, 0.0, {0}, NULL, NULL},
    {&duct_part, "duct", "Flow through a square duct", "u, L2 [-]", 0, 0.0, {0}, horizon_duct_fourth, NULL},
    {&cylinder_part, "cylinder", "Cylinder from wall to wall, Re = 20",
     "error of the drag [-]", 0, 0.0, {8, 10, 12, 16}, NULL, NULL},
    {&channel_along, "channel", "Periodic channel",
     "u, L2 at 20, 50, 100 s [-]", 0, 0.0, {20, 40, 80, 160}, NULL, NULL},
#endif
#if PD_DIM < 3
    {&rotation_wave_part, "wave", "A wave in a uniform stream", "c, L1 over that of the wave [-]", 1, 0.0, {0}, NULL,
     HORIZON_OF_2D(volumes_wave)},
#endif
    {&gauss_space, "gaussian", "A spreading Gaussian", "c, L2 [-]", 0, 0.0, {0}, NULL, HORIZON_OF_2D(volumes_gaussian)},
};
enum { HORIZON_PROBLEMS = (int)(sizeof horizon_problems / sizeof horizon_problems[0]) };

typedef struct horizon_knobs {
    const horizon_problem *of;
    val_level level;
    int fourth;
} horizon_knobs;

static pd_status horizon_once(bench *b, const void *knobs, study_point *p)
{
    const horizon_knobs *k = (const horizon_knobs *)knobs;
    static val_lab lab;
    val_outcome out;
    val_job job;
    memset(&job, 0, sizeof job);
    memset(&lab, 0, sizeof lab);
    memset(&out, 0, sizeof out);
    job.ctx = b->ctx;
    job.level = k->level;
    job.lab = &lab;
    job.out = &out;
    lab.flow_desc.order = 2;
    pd_status status = (k->fourth ? k->of->fourth : k->of->part->run)(&job);
    lab_free(b->ctx, &lab);
    p->err = out.err[k->of->measure];
    p->steps = (double)out.steps;
    p->evals = (double)out.evals;
    return status;
}

static pd_status horizon_volumes(bench *b, const void *knobs, study_point *p)
{
    const horizon_knobs *k = (const horizon_knobs *)knobs;
    p->steps = p->evals = 0.0;
    return k->of->volumes(b->ctx, k->level.n, k->level.p, &p->err);
}

/* Finer and finer lattices with one horizon or by another method, up to the first long run. `lost`: runs that found no
 * solution, which are left out. */
static pd_status horizon_family(bench *b, study *s, const horizon_problem *of, int f, char *lost, size_t size)
{
    const val_part *part = of->part;
    int levels = part->levels;
    for (int k = 0; k < 5 && of->n[k]; k++) levels = k + 1;
    if (b->quick) levels = 1;
    for (int l = 0; l < levels; l++) {
        horizon_knobs k;
        char knob[48];
        k.of = of;
        k.level = part->level[of->n[0] ? 0 : l];
        k.level.m = f < HORIZON_MOST ? f + 1.0 : f == HORIZON_ISOTROPIC ? HORIZON_ROUND : 1.0;
        k.fourth = f == HORIZON_FOURTH;
        if (of->n[0]) {
            k.level.n = of->n[l];
            k.level.p = of->p;
        }
        snprintf(knob, sizeof knob, "n = %d", k.level.n);
        pd_status status = study_measure(b, s, f, f == HORIZON_VOLUMES ? horizon_volumes : horizon_once, &k, knob);
        if (status == PD_ERR_DIVERGED) {
            pd_append(lost, size, "%s%s with %s, %s: %s", lost[0] ? "; " : "Left out: ", of->title, s->family[f], knob,
                      b->ctx->message);
            continue;
        }
        PD_TRY(status);
        if (s->point[s->points - 1].cpu > HORIZON_LONG) break;
    }
    return PD_OK;
}

/* A lattice whose error is less than that of a finer one of the same family owes that to errors of both signs: it
 * counts with the larger one. */
static void horizon_settle(study *s)
{
    for (int k = s->points - 1; k > 0; k--)
        if (s->point[k - 1].family == s->point[k].family)
            s->point[k - 1].err = fmax(s->point[k - 1].err, s->point[k].err);
}

/* Error of a family after `time` [s]: between two of its runs a power of the time, beyond the longest one its error.
 * Infinite before the shortest one. */
static double horizon_error(const study *s, int family, double time)
{
    double error = HUGE_VAL;
    const study_point *before = NULL;
    for (int k = 0; k < s->points; k++) {
        const study_point *p = &s->point[k];
        if (p->family != family) continue;
        if (p->cpu <= time) error = fmin(error, p->err);
        else if (before && before->cpu <= time && p->err < before->err)
            error = fmin(error, before->err * pow(p->err / before->err,
                                                  log(time / before->cpu) / log(p->cpu / before->cpu)));
        before = p;
    }
    return error;
}

/* Errors up to this are those of rounding and of the tolerance of a solver: neither horizon is better. */
#define HORIZON_EXACT 1e-9
/* Share by which times of the same run vary. */
#define HORIZON_NOISE 0.05

/* One row: the errors in the time of the finest run with m = 1. Returns by how much another horizon is better. */
static double horizon_row(bench *b, const study *s, const horizon_problem *of)
{
    double time = 0.0, error[HORIZON_FAMILIES], least = HUGE_VAL;
    table_row *row = bench_row(b);
    for (int k = 0; k < s->points; k++)
        if (s->point[k].family == 0) time = fmax(time, s->point[k].cpu);
    for (int f = 0; f < HORIZON_FAMILIES; f++) {
        error[f] = horizon_error(s, f, time);
        if (f && f < HORIZON_MOST) least = fmin(least, error[f]);
    }
    table_cell(row, "%s", of->title);
    table_cell(row, "%.2f", time);
    for (int f = 0; f < HORIZON_FAMILIES; f++) table_cell(row, isfinite(error[f]) ? "%.2e" : "-", error[f]);
    table_cell(row, isfinite(least) ? "%.2f" : "-", error[0] / least);
    return error[0] > HORIZON_EXACT ? error[0] / least : 0.0;
}

/* Where a wider horizon comes near, and why. */
#if PD_DIM == 1
#define HORIZON_WIDER "Bonds longer than a spacing spread a front and a peak by more than one."
#elif PD_DIM == 2
#define HORIZON_WIDER                                                                                              \
    "Past the pin with round ends the nearest neighbours have a divergence whose error is that of its own "        \
    "Laplacian, like wider horizons (theory: eq. 3.6). Around the wire what is left from 80 cells on is the "     \
    "error of the row of cells at the wire, which has the same parabola with every horizon (theory: 1.6)."
#else
#define HORIZON_WIDER                                                                                              \
    "The flow through a tube is exact: what is left is rounding, and counts for no horizon. In the periodic "      \
    "channel steps in time leave 8.5e-6 with any horizon. Past the cylinder m = 2 is a fifth ahead on lattices "   \
    "whose boundary layer has less than a cell and a half. Times vary by 5 %, and so do ratios of errors."
#endif

static pd_status horizon_run(bench *b)
{
    static const char *const words[] = {"case", "cpu [s]", "m = 1", "m = 2", "m = 3", HORIZON_ROUND_NAME,
                                        "m = 1, order 4", "finite volumes", "m = 1 over m = 2 or 3"};
    static study all[HORIZON_PROBLEMS];
    int worse = 0;
    char what[96], lost[1024] = "";
    for (int p = 0; p < HORIZON_PROBLEMS; p++) {
        const horizon_problem *of = &horizon_problems[p];
        study *s = &all[p];
        study_open(s, of->name, of->title, of->y_label);
        s->families = HORIZON_FAMILIES;
        for (int f = 0; f < HORIZON_FAMILIES; f++) {
            static const char *const names[HORIZON_FAMILIES] = {"m = 1",      "m = 2",          "m = 3",
                                                                HORIZON_ROUND_NAME, "m = 1, order 4", "finite volumes"};
            s->family[f] = names[f];
            if ((f == HORIZON_FOURTH && !of->fourth) || (f == HORIZON_VOLUMES && !of->volumes)) continue;
            if (b->quick && f > 1) continue;
            if (PD_DIM == 1 && f == HORIZON_ISOTROPIC) continue; /* the family of m = 1 */
            PD_TRY(horizon_family(b, s, of, f, lost, sizeof lost));
        }
        study_close(b, s);
    }
    table_row *head = bench_row(b);
    for (int k = 0; k < 9; k++) table_cell(head, "%s", words[k]);
    for (int p = 0; p < HORIZON_PROBLEMS; p++) horizon_settle(&all[p]);
    for (int p = 0; p < HORIZON_PROBLEMS; p++)
        worse += horizon_row(b, &all[p], &horizon_problems[p]) > 1.0 + HORIZON_NOISE;
    bench_table(b, "Errors in the same processor time, that of the finest run with m = 1");
    snprintf(what, sizeof what, "cases of %d in which a wider horizon has the smaller error by 5 %%", HORIZON_PROBLEMS);
    if (lost[0]) bench_note(b, lost);
    if (b->quick) return PD_OK;
    bench_judge(b, what, 0, 0.0, worse);
    bench_note(b, HORIZON_WIDER);
    return PD_OK;
}

static const bench_case horizon_case = {
    "horizon", "What a horizon costs and gives",
    "Cases of `validate` with m = 1, the default of fluids, and with wider horizons, on the same lattices: the error "
    "against the processor time of a run on one thread. A wider horizon has more bonds a node, so it is compared in "
    "the same time, between its runs by a power of the time. Where a finer lattice has the larger error, both signs of "
    "it meet on the coarser one, which counts there with that of the finer one. Finite volumes are plain ones of "
    "second order, written for this comparison (`cases/bench/volumes.h`).",
    horizon_run};

#endif
