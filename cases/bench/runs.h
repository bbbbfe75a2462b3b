/* runs: cases about the work of the solvers and the cost of whole runs. */
#ifndef BENCH_RUNS_H
#define BENCH_RUNS_H
#if PD_DIM > 1

/* Reads a scene and builds its model. Both stay empty but freeable when that fails. */
static pd_status runs_open(bench *b, const char *scene, const char *const *overrides, int count, pd_setup *setup,
                           pd_model *model)
{
    char path[PD_PATH_SIZE];
    memset(setup, 0, sizeof *setup);
    memset(model, 0, sizeof *model);
    PD_TRY(pd_file_join(b->ctx, b->scenes, scene, path));
    PD_TRY(pd_scene_read(b->ctx, path, overrides, count, setup));
    return pd_model_build(b->ctx, setup, model);
}

static void runs_close(bench *b, pd_setup *setup, pd_model *model)
{
    pd_model_free(b->ctx, model);
    pd_setup_free(b->ctx, setup);
}

/* ---- scenes ---- */

enum { SCENE_THREADS = 64 }; /* the speed-up is carried on to this many */

typedef struct scene_run {
    const char *name; /* in tables and result lines; NULL: that of the scene */
    const char *scene;
    const char *full[8], *quick[4]; /* overrides; NULL: no more */
    double wall, cpu;               /* [s] goals of the full run; 0: none. One thread where cpu is given: threads that
                                     * wait count as busy */
    double bytes;                   /* goal a node; 0: none */
} scene_run;

#if PD_DIM == 2
static const scene_run scene_runs[] = {
    {"mg_pin_2d_short", "mg_pin_2d.scene", /* the box of the goal: 112 x 60 nodes */
     {"grid.box=-80 um .. 480 um, -150 um .. 150 um", "plane.up.at=x -60 um", "plane.down.at=x 460 um",
      "probe.end.at=450 um, 0 um", "force.pin.box=-50 um .. 450 um, -100 um .. 100 um",
      "transfer.pin.box=-50 um .. 450 um, -100 um .. 100 um", NULL},
     {"grid.h=10 um", "run.until=1 min", NULL}, 10.0, 0.0, 500.0},
    {NULL, "mg_pin_2d.scene", {NULL}, {"grid.h=10 um", "run.until=10 min", NULL}, 0.0, 0.0, 500.0},
    {NULL, "mg_pin_axi.scene", {NULL}, {"grid.h=10 um", "run.until=10 min", NULL}, 0.0, 0.0, 500.0},
    {NULL, "crevice_625_2d.scene", {NULL}, {"grid.h=50 um, 2 um", "run.until=1 h", NULL}, 60.0, 0.0, 250.0},
    {NULL, "pit_304_2d.scene", {NULL}, {"run.until=2 s", NULL}, 0.0, 0.0, 250.0},
};
#else
static const scene_run scene_runs[] = {
    {NULL, "mg_pin_3d.scene", {"run.until=1 h", NULL}, {NULL}, 0.0, 0.0, 900.0},
    {NULL, "validation/channel3d_3d.scene", {NULL}, {"grid.h=0.25 m", "run.until=0.5 s", NULL}, 30.0, 0.0, 700.0},
    {"uniform_cu_3d_slab",
     "uniform_cu_3d.scene", /* 128 x 128 x 64 nodes; with this share about 650 steps */
     {"grid.box=-64 um .. 64 um, -64 um .. 64 um, -32 um .. 32 um",
      "shape.metal.box=-58 um .. 58 um, -58 um .. 58 um, -26 um .. 26 um", "run.max_dissolved_fraction=0.02",
      "run.until=150 s", NULL},
     {"run.until=5 s", NULL},
     0.0,
     10.0,
     250.0},
    {NULL, "pits_304_3d.scene", {NULL}, {"run.until=1 s", NULL}, 0.0, 0.0, 250.0},
};
#endif

/* Why goals are missed. */
#if PD_DIM == 2
#define SCENES_SERIAL \
    "Why speed-ups are missed: a step of 3,600 to 25,000 nodes is made of loops of 1 to 50 us. A cycle of the "        \
    "multigrid and a column of GMRES are one parallel region each, whose threads meet at barriers: 300,000 in a run "  \
    "of the pin, a sixth of its time on two threads. One thread packs systems, sets up the coarse levels, evaluates "  \
    "the law and keeps the ledger: an eighth."
#define SCENES_MISSED \
    "Why bytes a node are missed: a limited step of transport borrows 372 bytes a node, 164 of them for 41 Krylov " \
    "bases in single precision; a steady solve borrows the same memory, 80 to 165 for its bases. Coarse levels " \
    "of three multigrids take 116, and fields and tables that steps carry on the rest. At rest, steps borrow 150 " \
    "to 180, and fields, tables and what rows of cut families hold take 170 to 230."
#else
#define SCENES_SERIAL \
    "Why speed-ups are missed: one thread sets up the coarse levels, and sweeps those of fewer than 4096 cells."
#define SCENES_MISSED \
    "Why bytes a node are missed: 11 bases of four components, 91 bytes a node of fluid or metal (in time 176), and " \
    "more where they grow; vectors of the flow, its multigrids and linearised products; coarse levels; what rows of " \
    "cut families hold, in the pits a third of all for the conductances of 178 bonds; and ghosts, which double the " \
    "nodes of a box 30 cells wide."
#endif

/* 3D: a quick run leaves out the pin. */
static int scene_first(const bench *b) { return PD_DIM == 3 && b->quick; }

typedef struct scene_watch {
    pd_ctx *ctx;
    pd_model *model;
    pd_step_diagnostics *seen;
} scene_watch;

static int scene_observe(void *user, const pd_time_loop *couple)
{
    scene_watch *w = (scene_watch *)user;
    (void)couple;
    pd_step_diagnostics_update(w->ctx, w->model, w->seen);
    return 0;
}

static pd_status scene_steps(bench *b, pd_model *model, pd_step_diagnostics *seen)
{
    scene_watch watch;
    watch.ctx = b->ctx;
    watch.model = model;
    watch.seen = seen;
    PD_TRY(pd_step_diagnostics_build(b->ctx, model, seen));
    return pd_time_loop_run(b->ctx, &model->time_loop, model->setup->end_time, model->setup->output_interval,
                            scene_observe, &watch);
}

/* Times of a run [s]; one: wall time of the same run on one thread, 0 when there was none. */
typedef struct scene_times {
    double wall, cpu, one;
} scene_times;

/* The share of the work that one thread does alone, by Amdahl's law, of a speed-up on `threads`; 1 where they lose. */
static double scene_serial(double speedup, int threads)
{
    double share = (threads / speedup - 1.0) / (threads - 1.0);
    return share > 1.0 ? 1.0 : share > 0.0 ? share : 0.0;
}

static void scene_note(bench *b, const scene_run *s, const pd_model *model, const pd_step_diagnostics *seen,
                       scene_times t)
{
    const pd_time_loop *c = &model->time_loop;
    pd_model_statistics effort;
    pd_model_get_statistics(model, &effort);
    double nodes = (double)(model->grid.fluid_count + model->grid.solid_count);
    double bytes = (double)b->ctx->peak / nodes, evals = (double)effort.flow_evaluations, steps = (double)c->steps;
    double speedup = t.one / t.wall, serial = t.one > 0.0 ? scene_serial(speedup, b->threads) : 0.0;
    char what[96];
    if (model->implicit.steps) steps = (double)model->implicit.steps;
    const char *name = s->name ? s->name : model->setup->name;
    table_row *row = bench_row(b);
    table_cell(row, "%s", name);
    table_cell(row, "%g", model->grid.h[0]);
    table_cell(row, "%g", model->setup->end_time);
    table_cell(row, "%.0f", nodes);
    table_cell(row, "%.0f", steps);
    table_cell(row, "%.0f", evals);
    table_cell(row, "%d", b->ctx->threads);
    table_cell(row, "%.1f", t.wall);
    table_cell(row, "%.1f", t.cpu);
    table_cell(row, "%.2f", evals > 0.0 ? 1e6 * t.cpu / evals / nodes : 0.0);
    table_cell(row, t.one > 0.0 ? "%.2f" : "-", speedup);
    table_cell(row, t.one > 0.0 ? "%.2f" : "-", serial);
    table_cell(row, t.one > 0.0 ? "%.1f" : "-", 1.0 / (serial + (1.0 - serial) / SCENE_THREADS));
    table_cell(row, "%.1f", 1e-6 * (double)b->ctx->peak);
    table_cell(row, "%.0f", bytes);
    bench_result(b,
                 "name=%s h=%g m=%g volume_loss=%.6g ledger=%.3g flux=%.3g evals=%.0f steps=%.0f nodes=%.0f "
                 "bytes_per_node=%.0f wall_s=%.3f cpu_s=%.3f threads=%d wall_one_s=%.3f",
                 name, model->grid.h[0], model->stencil.m, seen->volume_loss, c->ledger[0].relative_imbalance,
                 seen->flux_error, evals, steps, nodes, bytes, t.wall, t.cpu, b->ctx->threads, t.one);
    if (b->quick) return;
    snprintf(what, sizeof what, "%s: bytes a node", name);
    if (s->bytes > 0.0) bench_judge(b, what, 0, s->bytes, bytes);
    snprintf(what, sizeof what, "%s: wall time [s] on %d threads", name, b->threads);
    if (s->wall > 0.0) bench_judge(b, what, 0, s->wall, t.wall);
    snprintf(what, sizeof what, "%s: processor time [s] on one thread", name);
    if (s->cpu > 0.0) bench_judge(b, what, 0, s->cpu, t.cpu);
    snprintf(what, sizeof what, "%s: speed-up on %d threads", name, b->threads);
    if (t.one > 0.0) bench_judge(b, what, 1, 1.8, speedup);
}

/* The run has a context of its own, which counts the memory of this run alone. one: its wall time on one thread, when
 * it was run so before; NULL: this is that run, whose time is kept and nothing else. */
static pd_status scene_once(bench *b, const scene_run *s, const double *one, double *wall)
{
    const char *const *overrides = b->quick ? s->quick : s->full;
    pd_setup setup;
    pd_model model;
    pd_step_diagnostics seen;
    scene_times t;
    int count = 0;
    memset(&seen, 0, sizeof seen);
    while (overrides[count]) count++;
    t.wall = wall_seconds();
    t.cpu = cpu_seconds();
    pd_status status = runs_open(b, s->scene, overrides, count, &setup, &model);
    if (status >= 0) status = scene_steps(b, &model, &seen);
    *wall = t.wall = wall_seconds() - t.wall;
    t.cpu = cpu_seconds() - t.cpu;
    t.one = one ? *one : 0.0;
    if (status >= 0 && one) scene_note(b, s, &model, &seen, t);
    pd_step_diagnostics_free(b->ctx, &seen);
    runs_close(b, &setup, &model);
    return status;
}

/* On one thread first where more are at hand, since the two times are compared. */
static pd_status scene_passes(bench *b, const scene_run *s)
{
    double one = 0.0, wall;
    int pair = !b->quick && b->threads > 1 && !(s->cpu > 0.0);
    pd_ctx *outer = b->ctx;
    pd_status status = PD_OK;
    for (int pass = pair ? 0 : 1; pass < 2 && status >= 0; pass++) {
        pd_ctx ctx;
        pd_ctx_init(&ctx);
        ctx.threads = !pass || s->cpu > 0.0 ? 1 : b->threads;
        b->ctx = &ctx;
        status = scene_once(b, s, pass ? &one : NULL, pass ? &wall : &one);
        b->ctx = outer;
        if (status < 0) return pd_fail(outer, status, s->scene, "%s", ctx.message);
    }
    return status;
}

static pd_status scenes_run(bench *b)
{
    static const char *const words[] = {"scene", "h [m]", "until [s]", "nodes", "steps", "evaluations", "threads",
                                        "wall [s]", "cpu [s]", "cpu [us] a node and evaluation", "speed-up",
                                        "serial share", "at 64 threads", "memory [MB]", "bytes a node"};
    table_row *head = bench_row(b);
    for (int k = 0; k < (int)(sizeof words / sizeof words[0]); k++) table_cell(head, "%s", words[k]);
    for (int k = scene_first(b); k < (int)(sizeof scene_runs / sizeof scene_runs[0]); k++)
        PD_TRY(scene_passes(b, &scene_runs[k]));
    bench_table(b, "From the first flow solve to the end");
    bench_note(b, "Speed-up: wall time on one thread over that on those of the row. The serial share follows from it "
                  "by Amdahl's law, and holds what threads wait for too: loops too short for them, and memory that "
                  "they share. The last figure carries the law on to 64 threads.");
    bench_note(b, SCENES_SERIAL);
    bench_note(b, SCENES_MISSED);
    return PD_OK;
}

static const bench_case scenes_case = {
    "scenes", "Whole runs",
    "Scenes of `examples/scenes` from the building of their objects to their end, all checks on, without the "
    "writing of files. Memory is the most that the library has allocated at once. An evaluation is one residual or "
    "linearised product of the flow; the processor time for one contains everything else that a run does.",
    scenes_run};

/* ---- counts ---- */

#if PD_DIM == 2

enum { COUNT_SOLVES = 5 };

/* First flow from rest to a residual of 1e-8, then again whenever metal has become fluid. *again: the most of these. */
static pd_status counts_pin_solves(bench *b, pd_model *model, int solves, int64_t *first, int64_t *again, double *mean)
{
    pd_time_loop *c = &model->time_loop;
    const pd_quasi_steady *flow = &model->quasi;
    int64_t start, total = 0;
    *again = 0;
    PD_TRY(pd_time_loop_start(b->ctx, c));
    *first = start = flow->evaluations;
    for (int found = 0; found < solves && c->steps < 1000;) {
        int64_t before = flow->evaluations, known = flow->solves;
        PD_TRY(pd_time_loop_step(b->ctx, c, model->setup->end_time));
        if (flow->solves == known) continue;
        *again = flow->evaluations - before > *again ? flow->evaluations - before : *again;
        found++;
    }
    total = flow->evaluations - start;
    *mean = (double)total / solves;
    return PD_OK;
}

/* tolerance NULL: that of the scene. */
static pd_status counts_pin_level(bench *b, const char *h, const char *tolerance, int solves, double found[2])
{
    char grid[32], steady[32];
    const char *overrides[3];
    pd_setup setup;
    pd_model model;
    int64_t first = 0, again = 0;
    double mean = 0.0;
    snprintf(grid, sizeof grid, "grid.h=%s um", h);
    snprintf(steady, sizeof steady, "flow.steady_tolerance=%s", tolerance ? tolerance : "");
    overrides[0] = grid;
    overrides[1] = "run.until=90 h";
    overrides[2] = steady;
    double cpu = cpu_seconds();
    pd_status status = runs_open(b, "mg_pin_2d.scene", overrides, tolerance ? 3 : 2, &setup, &model);
    if (status >= 0) status = counts_pin_solves(b, &model, solves, &first, &again, &mean);
    cpu = cpu_seconds() - cpu;
    if (status >= 0) {
        double nodes = (double)model.grid.fluid_count;
        const pd_steady_result *last = &model.quasi.result;
        double residual = fmax(last->momentum, last->continuity);
        table_row *row = bench_row(b);
        table_cell(row, "%s", h);
        table_cell(row, "%.0f", nodes);
        table_cell(row, "%g", setup.steady_tolerance);
        table_cell(row, "%.0f", (double)first);
        table_cell(row, "%.0f", mean);
        table_cell(row, "%.0f", (double)again);
        table_cell(row, "%.1e", residual);
        table_cell(row, "%.1f", cpu);
        bench_result(b,
                     "part=pin h=%g m=%g tolerance=%g evals=%.0f evals_again=%.1f evals_again_max=%.0f "
                     "residual=%.3g cpu_s=%.3f",
                     model.grid.h[0], model.stencil.m, setup.steady_tolerance, (double)first, mean, (double)again,
                     residual, cpu);
    }
    found[0] = (double)first;
    found[1] = mean;
    runs_close(b, &setup, &model);
    return status;
}

/* Rows for each spacing with the tolerance of the scene, then with 1e-8, by which goals are judged. */
static pd_status counts_pin(bench *b)
{
    static const char *const h[] = {"20", "10", "5"};
    double found[2] = {0.0, 0.0}, most = 0.0, least = 1e300;
    table_row *head = bench_row(b);
    table_cell(head, "h [um]");
    table_cell(head, "fluid nodes");
    table_cell(head, "tolerance");
    table_cell(head, "first flow");
    table_cell(head, "re-solve, mean");
    table_cell(head, "re-solve, most");
    table_cell(head, "last residual");
    table_cell(head, "cpu [s]");
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < 3; k++) {
            if (b->quick && (k != 1 || !pass)) continue;
            PD_TRY(counts_pin_level(b, h[k], pass ? "1e-8" : NULL, b->quick ? 2 : COUNT_SOLVES, found));
            if (!pass) continue;
            most = fmax(most, found[0]);
            least = fmin(least, found[0]);
        }
    bench_table(b, "Evaluations for the flow past the pin (`mg_pin_2d`)");
    bench_judge(b, "pin, residual 1e-8: evaluations of the first flow, most of all h", 0, 120.0, most);
    if (!b->quick) bench_judge(b, "pin, residual 1e-8: evaluations of the first flow, most over least h", 0, 1.3,
                               most / least);
    bench_judge(b, "pin, h = 5 um, residual 1e-8: evaluations of a re-solve, mean", 0, 40.0, found[1]);
    bench_note(b, "Why 40 evaluations for a re-solve to 1e-8 are missed: it takes four or five Newton steps of 4 to 16 "
                  "iterations. The exact inverse of the velocity block in the place of cycles on the compact one would "
                  "take a fifth of them off, that of the Schur complement next to nothing.");
    return PD_OK;
}

typedef struct counts_step {
    int n; /* nodes across */
    double m, peclet;
    double courant; /* widths that the mean flow goes in a step */
    pd_advection advection;
} counts_step;

/* One implicit step in the channel of the validation. */
static pd_status counts_transport_step(bench *b, val_lab *lab, const counts_step *s, pd_transport_result *result)
{
    double mean = 0.01; /* [m/s] */
    memset(lab, 0, sizeof *lab);
    flow_channel(lab, 2.0 * FLOW_HALF / s->n, s->m, 0.0, 4.0 * FLOW_HALF, &mean, 1e-8);
    lab->transport_desc.diffusivity = mean * 2.0 * FLOW_HALF / s->peclet;
    lab->transport_desc.inlet = 1.0;
    lab->transport_desc.advection = s->advection;
    PD_TRY(lab_build(b->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        flow_profile(&mean, x, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
    }
    pdi_flow_update_derived_fields(b->ctx, &lab->flow);
    return pd_transport_implicit(b->ctx, &lab->transport, s->courant * 2.0 * FLOW_HALF / mean, result);
}

/* Cells of a row: upwind with a short and a long step, limited with a short one, and its Newton steps. */
static pd_status counts_transport_row(bench *b, table_row *row, counts_step s)
{
    static const double courant[3] = {0.1, 1e4, 0.1};
    static val_lab lab;
    pd_transport_result result;
    for (int k = 0; k < 3; k++) {
        s.advection = k == 2 ? PD_ADVECTION_LIMITED : PD_ADVECTION_UPWIND;
        s.courant = courant[k];
        pd_status status = counts_transport_step(b, &lab, &s, &result);
        lab_free(b->ctx, &lab);
        if (status < 0) return status;
        table_cell(row, "%d", result.krylov);
        bench_result(b, "part=transport n=%d m=%g peclet=%g limited=%d courant=%g krylov=%d limiter=%d residual=%.3g",
                     s.n, s.m, s.peclet, k == 2, s.courant, result.krylov, result.limiter, result.residual);
    }
    table_cell(row, "%d", result.limiter);
    return PD_OK;
}

static void counts_transport_head(bench *b, const char *first, const char *second)
{
    table_row *head = bench_row(b);
    table_cell(head, "%s", first);
    table_cell(head, "%s", second);
    table_cell(head, "upwind, short step");
    table_cell(head, "upwind, steady");
    table_cell(head, "limited, short step");
    table_cell(head, "its Newton steps");
}

static pd_status counts_transport(bench *b)
{
    counts_step s = {16, 1.0, 3000.0, 0.0, PD_ADVECTION_UPWIND};
    counts_transport_head(b, "nodes across", "m");
    for (s.m = 1.0; s.m < 4.0; s.m += 2.0)
        for (s.n = 16; s.n <= (b->quick ? 32 : 128); s.n *= 2) {
            table_row *row = bench_row(b);
            table_cell(row, "%d", s.n);
            table_cell(row, "%g", s.m);
            PD_TRY(counts_transport_row(b, row, s));
        }
    bench_table(b, "Krylov iterations of one implicit step of transport in a channel, Peclet number 3000");
    if (b->quick) return PD_OK;
    counts_transport_head(b, "Peclet number", "m");
    s.n = 64;
    for (s.m = 1.0; s.m < 4.0; s.m += 1.0)
        for (s.peclet = 30.0; s.peclet < 1e7; s.peclet *= 100.0) {
            table_row *row = bench_row(b);
            table_cell(row, "%g", s.peclet);
            table_cell(row, "%g", s.m);
            PD_TRY(counts_transport_row(b, row, s));
        }
    bench_table(b, "The same with 64 nodes across, against the Peclet number and the horizon");
    return PD_OK;
}

static pd_status counts_implicit_steps(bench *b, val_lab *lab, int n, int steps)
{
    memset(lab, 0, sizeof *lab);
    lab_box(lab, 1.0 / n, 3.0, 0.0, 1.0);
    for (int side = 0; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    enclosed_fluid(lab, TAYLOR_NU);
    PD_TRY(lab_build(b->ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        pd_grid_position(&lab->grid, i, x);
        taylor_field(x, 0.0, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
    }
    for (int k = 0; k < steps; k++)
        if (pd_implicit_step(b->ctx, &lab->implicit, 0.01) != PD_OK)
            return pd_fail(b->ctx, PD_ERR_DIVERGED, "bench", "an implicit step with %d nodes does not converge", n);
    return PD_OK;
}

static pd_status counts_implicit(bench *b)
{
    static val_lab lab;
    table_row *head = bench_row(b);
    int steps = 5;
    table_cell(head, "nodes a side");
    table_cell(head, "evaluations a step");
    for (int n = 16; n <= (b->quick ? 32 : 128); n *= 2) {
        table_row *row = bench_row(b);
        pd_status status = counts_implicit_steps(b, &lab, n, steps);
        double evals = (double)lab.implicit.evaluations / steps;
        lab_free(b->ctx, &lab);
        if (status < 0) return status;
        table_cell(row, "%d", n);
        table_cell(row, "%.1f", evals);
        bench_result(b, "part=implicit n=%d m=3 evals=%.1f steps=%d", n, evals, steps);
    }
    bench_table(b, "Implicit steps of 0.01 s of decaying vortices in a unit square at 1 m/s, tolerance 1e-8");
    return PD_OK;
}

static pd_status counts_run(bench *b)
{
    PD_TRY(counts_pin(b));
    PD_TRY(counts_transport(b));
    return counts_implicit(b);
}

static const bench_case counts_case = {
    "counts", "Work of the solvers",
    "What does not depend on the machine: evaluations of the flow (residuals and linearised products on the fine "
    "grid) and Krylov iterations, against the size of the grid. `make test` holds the coarse levels to their counts.",
    counts_run};

#endif
#endif

/* ---- scaling ---- */

enum { SCALING_LEVELS = 8, SCALING_KERNELS = 5 };

/* ns a node of each kernel on one thread, then on all. */
typedef struct scaling {
    double nodes[SCALING_LEVELS], cost[2][SCALING_KERNELS][SCALING_LEVELS];
    int levels;
} scaling;

static pd_status scaling_level(bench *b, scaling *s, kernels *k, int n)
{
    static const int which[SCALING_KERNELS] = {0, 1, 5, 7, 9}; /* of kernels_build */
    double rate[KERNELS][2];
    int l = s->levels++;
    memset(rate, 0, sizeof rate);
    PD_TRY(kernels_build(b, k, n, b->m > 0.0 ? b->m : 3.0));
    for (int j = 0; j < SCALING_KERNELS; j++) k->job[j] = k->job[which[j]];
    k->jobs = SCALING_KERNELS;
    kernels_time(b, k, "scaling", n, k->lab.stencil.m, rate);
    s->nodes[l] = (double)k->lab.grid.fluid_count;
    for (int j = 0; j < SCALING_KERNELS; j++)
        for (int pass = 0; pass < 2; pass++) s->cost[pass][j][l] = 1e9 / rate[j][pass];
    table_row *row = bench_row(b);
    table_cell(row, "%.0f", s->nodes[l]);
    for (int j = 0; j < SCALING_KERNELS; j++) {
        table_cell(row, "%.2f", s->cost[0][j][l]);
        if (b->threads > 1) table_cell(row, "%.2f", s->cost[0][j][l] / s->cost[1][j][l]);
    }
    return PD_OK;
}

static void scaling_figure(bench *b, const scaling *s, const kernels *k)
{
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    plot.title = "Cost a node against the number of nodes, m = 3";
    plot.x_label = "nodes [-]";
    plot.y_label = "ns a node";
    plot.x_log = plot.y_log = 1;
    for (int j = 0; j < SCALING_KERNELS; j++)
        plot_add(&plot, k->job[j].name, s->nodes, s->cost[0][j], s->levels, PD_SERIES_STYLE_BOTH);
    bench_figure(b, "one", &plot);
    if (b->threads == 1 || !bench_alone(b)) return;
    plot.count = 0;
    plot.title = "The same on two threads";
    for (int j = 0; j < SCALING_KERNELS; j++)
        plot_add(&plot, k->job[j].name, s->nodes, s->cost[1][j], s->levels, PD_SERIES_STYLE_BOTH);
    bench_figure(b, "two", &plot);
}

static pd_status scaling_run(bench *b)
{
    static scaling s;
    static kernels k;
    int first = PD_DIM == 3 ? 12 : 64, last = b->quick ? first : PD_DIM == 3 ? 96 : 1024;
    table_row *head = bench_row(b);
    memset(&s, 0, sizeof s);
    table_cell(head, "nodes");
    pd_status status = PD_OK;
    for (int n = first; n <= last && status >= 0; n *= 2) {
        status = scaling_level(b, &s, &k, n);
        for (int j = 0; j < SCALING_KERNELS && s.levels == 1; j++) {
            table_cell(head, "%s [ns]", k.job[j].name);
            if (b->threads > 1) table_cell(head, "speed-up");
        }
        if (n == last) scaling_figure(b, &s, &k);
        kernels_free(&k);
    }
    if (status >= 0) bench_table(b, "Nanoseconds a node on one thread, and speed-up on two");
    return status;
}

static const bench_case scaling_case = {
    "scaling", "Cost against size",
    "The same kernels on grids of different size, on one thread and on two. Loops too short to be worth a fork stay "
    "on one thread.",
    scaling_run};

#endif
