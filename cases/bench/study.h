/* study: error against time. Every run of a problem is a point; the frontier holds those that no other run beats in
 * both. */
#ifndef BENCH_STUDY_H
#define BENCH_STUDY_H

enum { STUDY_FAMILIES = 6, STUDY_POINTS = 32 };

typedef struct study_point {
    int family;
    char knob[48]; /* what changes along the family */
    double err, cpu, wall;
    double steps, evals; /* 0: not known */
} study_point;

typedef struct study {
    const char *name, *title, *y_label;
    const char *family[STUDY_FAMILIES];
    int families;
    study_point point[STUDY_POINTS];
    int points;
} study;

typedef pd_status (*study_run_fn)(bench *b, const void *knobs, study_point *point);

/* The least time of runs that last 0.2 s together; long runs are made once. One thread, so processor time is the time
 * that the run would take on a machine of its own. */
static pd_status study_measure(bench *b, study *s, int family, study_run_fn run, const void *knobs, const char *knob)
{
    double spent = 0.0;
    study_point *p = &s->point[s->points];
    if (s->points == STUDY_POINTS) return pd_fail(b->ctx, PD_ERR_SIZE, "bench", "more runs than a study holds");
    p->cpu = p->wall = HUGE_VAL;
    p->family = family;
    snprintf(p->knob, sizeof p->knob, "%s", knob);
    b->ctx->threads = 1;
    for (int round = 0; round < (b->quick ? 1 : 20) && (round == 0 || spent < 0.2); round++) {
        double wall = wall_seconds(), cpu = cpu_seconds();
        pd_status status = run(b, knobs, p);
        cpu = cpu_seconds() - cpu;
        b->ctx->threads = 1;
        if (status < 0) {
            b->ctx->threads = b->threads;
            return status;
        }
        p->wall = fmin(p->wall, wall_seconds() - wall);
        p->cpu = fmin(p->cpu, cpu);
        spent += cpu;
    }
    b->ctx->threads = b->threads;
    s->points++;
    return PD_OK;
}

/* No other run has a smaller error in at most the time. */
static int study_efficient(const study *s, int k)
{
    for (int j = 0; j < s->points; j++) {
        const study_point *a = &s->point[j], *p = &s->point[k];
        if (j != k && a->err <= p->err && a->cpu <= p->cpu && (a->err < p->err || a->cpu < p->cpu)) return 0;
    }
    return 1;
}

static void study_table(bench *b, const study *s)
{
    static const char *const words[] = {"run", "", "error", "cpu [s]", "steps", "evaluations", "frontier"};
    table_row *head = bench_row(b);
    for (int k = 0; k < 7; k++) table_cell(head, "%s", words[k]);
    for (int k = 0; k < s->points; k++) {
        const study_point *p = &s->point[k];
        table_row *row = bench_row(b);
        int on = study_efficient(s, k);
        table_cell(row, "%s", s->family[p->family]);
        table_cell(row, "%s", p->knob);
        table_cell(row, "%.2e", p->err);
        table_cell(row, "%.3f", p->cpu);
        table_cell(row, "%.0f", p->steps);
        if (p->evals > 0.0) table_cell(row, "%.0f", p->evals);
        else table_cell(row, "-");
        table_cell(row, "%s", on ? "yes" : "");
        bench_result(b, "part=%s run=%d level=%d err=%.4g steps=%.0f evals=%.0f frontier=%d wall_s=%.4f cpu_s=%.4f "
                     "threads=1", s->name, p->family, k, p->err, p->steps, p->evals, on, p->wall, p->cpu);
    }
    bench_table(b, s->title);
}

/* Families as markers, the frontier as a dashed line through its runs in the order of their times. */
static void study_figure(bench *b, const study *s)
{
    double x[STUDY_FAMILIES + 1][STUDY_POINTS], y[STUDY_FAMILIES + 1][STUDY_POINTS], after = -1.0;
    int count[STUDY_FAMILIES + 1] = {0}, line = s->families;
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    plot.title = s->title;
    plot.x_label = "processor time on one thread [s]";
    plot.y_label = s->y_label;
    plot.x_log = plot.y_log = 1;
    for (int k = 0; k < s->points; k++) {
        int f = s->point[k].family;
        x[f][count[f]] = s->point[k].cpu;
        y[f][count[f]++] = s->point[k].err;
    }
    for (;;) {
        int next = -1;
        for (int k = 0; k < s->points; k++)
            if (study_efficient(s, k) && s->point[k].cpu > after && (next < 0 || s->point[k].cpu < s->point[next].cpu))
                next = k;
        if (next < 0) break;
        after = s->point[next].cpu;
        x[line][count[line]] = after;
        y[line][count[line]++] = s->point[next].err;
    }
    for (int f = 0; f < s->families; f++) plot_add(&plot, s->family[f], x[f], y[f], count[f], PD_SERIES_STYLE_MARKERS);
    plot_add(&plot, "efficient frontier", x[line], y[line], count[line], PD_SERIES_STYLE_DASHED);
    bench_figure(b, s->name, &plot);
}

static void study_close(bench *b, const study *s)
{
    study_table(b, s);
    study_figure(b, s);
}

static void study_open(study *s, const char *name, const char *title, const char *y_label)
{
    memset(s, 0, sizeof *s);
    s->name = name;
    s->title = title;
    s->y_label = y_label;
}

#if PD_DIM == 1

/* ---- pulse ---- */

#define STUDY_SIGMA 10e-6  /* [m] width of the pulse */
#define STUDY_TRAVEL 8.0   /* [-] widths */
#define STUDY_PECLET 1e3   /* [-] of the width */

typedef struct pulse_knobs {
    int n;          /* nodes a width */
    double m;
    pd_advection advection;
    double rtol;    /* of SDIRK2; 0: backward Euler at Courant number 1/2 */
} pulse_knobs;

static pd_status study_pulse_steps(bench *b, val_lab *lab, const pulse_knobs *k, double end, study_point *p)
{
    pd_two_stage two_stage;
    pd_two_stage_desc desc;
    pd_transport_result result;
    if (!(k->rtol > 0.0)) {
        int steps = (int)(2.0 * STUDY_TRAVEL * k->n);
        p->steps = steps;
        for (int s = 0; s < steps; s++) PD_TRY(pd_transport_implicit(b->ctx, &lab->transport, end / steps, &result));
        return PD_OK;
    }
    memset(&desc, 0, sizeof desc);
    desc.rtol = k->rtol;
    pd_status status = pd_two_stage_build(b->ctx, &lab->transport, &desc, &two_stage);
    if (status >= 0) status = pd_physics_run(b->ctx, pd_two_stage_process(&two_stage), end);
    p->steps = (double)two_stage.steps;
    pd_two_stage_free(b->ctx, &two_stage);
    return status;
}

/* L2 error of a Gaussian that has gone eight times its width. */
static pd_status study_pulse_solve(bench *b, val_lab *lab, const pulse_knobs *k, study_point *p)
{
    double end = STUDY_TRAVEL * STUDY_SIGMA / PULSE_SPEED, largest;
    memset(lab, 0, sizeof *lab);
    lab_box(lab, STUDY_SIGMA / k->n, k->m, -6.0 * STUDY_SIGMA, (6.0 + STUDY_TRAVEL) * STUDY_SIGMA);
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.side[1] = PD_SIDE_OUTLET;
    lab->flow_desc.rho = 1000.0;
    lab->flow_desc.mu = 1e-3;
    lab->flow_desc.report_speed = PULSE_SPEED;
    lab->flow_desc.report_length = STUDY_SIGMA; /* the width, for pulse_field */
    lab->flow_desc.inlet = pulse_velocity;
    lab->transport_desc.diffusivity = PULSE_SPEED * STUDY_SIGMA / STUDY_PECLET;
    lab->transport_desc.advection = k->advection;
    PD_TRY(lab_build(b->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        lab->flow.u[i] = PULSE_SPEED;
        pd_grid_position(&lab->grid, i, x);
        if (lab->grid.kind[i] == PD_FLUID) lab->transport.c[i] = pulse_field(lab, x, 0.0);
    }
    pdi_flow_update_derived_fields(b->ctx, &lab->flow);
    PD_TRY(study_pulse_steps(b, lab, k, end, p));
    transport_errors(lab, lab->transport.c, pulse_field, end, &p->err, &largest);
    return PD_OK;
}

static pd_status study_pulse_once(bench *b, const void *knobs, study_point *p)
{
    static val_lab lab;
    pd_status status = study_pulse_solve(b, &lab, (const pulse_knobs *)knobs, p);
    lab_free(b->ctx, &lab);
    return status;
}

static pd_status study_pulse(bench *b, study *s)
{
    static const struct {
        const char *name;
        pulse_knobs knobs;
    } family[] = {
        {"Euler, m = 3", {0, 3.0, PD_ADVECTION_LIMITED, 0.0}},
        {"SDIRK2 1e-3, m = 3", {0, 3.0, PD_ADVECTION_LIMITED, 1e-3}},
        {"SDIRK2 1e-4, m = 3", {0, 3.0, PD_ADVECTION_LIMITED, 1e-4}},
        {"SDIRK2 1e-4, m = 1", {0, 1.0, PD_ADVECTION_LIMITED, 1e-4}},
        {"SDIRK2 1e-3, m = 3, upwind", {0, 3.0, PD_ADVECTION_UPWIND, 1e-3}},
    };
    study_open(s, "pulse", "Pulse that goes eight times its width, Peclet number 1000", "L2 error [-]");
    s->families = (int)(sizeof family / sizeof family[0]);
    for (int f = 0; f < s->families; f++) {
        s->family[f] = family[f].name;
        for (int n = 4; n <= (b->quick ? 4 : 32); n *= 2) {
            char knob[48];
            pulse_knobs k = family[f].knobs;
            k.n = n;
            snprintf(knob, sizeof knob, "%d nodes a width", n);
            PD_TRY(study_measure(b, s, f, study_pulse_once, &k, knob));
        }
    }
    study_close(b, s);
    return PD_OK;
}

/* ---- pencil ---- */

typedef struct pencil_knobs {
    val_level level;
    double fraction; /* of a node's metal that a step may take */
} pencil_knobs;

/* Depth after 300 s, by the case `stefan` of the validation. */
static pd_status study_pencil_once(bench *b, const void *knobs, study_point *p)
{
    static val_lab lab;
    const pencil_knobs *k = (const pencil_knobs *)knobs;
    val_outcome out;
    val_job job;
    memset(&lab, 0, sizeof lab);
    memset(&job, 0, sizeof job);
    memset(&out, 0, sizeof out);
    lab.couple_desc.fraction = k->fraction;
    job.ctx = b->ctx;
    job.level = k->level;
    job.lab = &lab;
    job.out = &out;
    pd_status status = stefan_run(&job);
    lab_free(b->ctx, &lab);
    p->err = out.err[2];
    p->steps = (double)out.steps;
    return status;
}

static pd_status study_pencil(bench *b, study *s)
{
    static const struct {
        const char *name;
        double m, fraction;
    } family[] = {{"m = 3, share 0.1", 3.0, 0.1}, {"m = 3, share 0.3", 3.0, 0.3}, {"m = 3, share 0.03", 3.0, 0.03},
                  {"m = 2, share 0.1", 2.0, 0.1}, {"m = 1, share 0.1", 1.0, 0.1}};
    study_open(s, "pencil", "Pencil electrode: depth after 300 s", "relative error of the depth [-]");
    s->families = (int)(sizeof family / sizeof family[0]);
    for (int f = 0; f < s->families; f++) {
        s->family[f] = family[f].name;
        for (int n = 1; n <= (b->quick ? 1 : 8); n *= 2) {
            char knob[48];
            pencil_knobs k;
            memset(&k, 0, sizeof k);
            k.level.n = n;
            k.level.m = family[f].m;
            k.fraction = family[f].fraction;
            snprintf(knob, sizeof knob, "h = %g um", 8.0 / n);
            PD_TRY(study_measure(b, s, f, study_pencil_once, &k, knob));
        }
    }
    study_close(b, s);
    return PD_OK;
}

static pd_status study_run(bench *b)
{
    static study s;
    PD_TRY(study_pulse(b, &s));
    PD_TRY(study_pencil(b, &s));
    bench_note(b, "Bonds longer than a spacing are upwinded too, which spreads a front by more than a cell: long "
                  "horizons pay for their work with accuracy here. The error of the pencil is that of metal that "
                  "leaves cell by cell; it falls with h, not with the steps.");
    return PD_OK;
}

static const bench_case study_case = {
    "study", "Speed against error",
    "A Gaussian is carried along; the field against the closed form (L2). A pencil electrode dissolves under "
    "diffusion; its depth against the closed form. Spacing, horizon, method in time and tolerance vary.",
    study_run};

#elif PD_DIM == 2

/* ---- Poiseuille ---- */

typedef struct channel_knobs {
    int n;
    double m, tolerance;
} channel_knobs;

static pd_status study_channel_once(bench *b, const void *knobs, study_point *p)
{
    static val_lab lab;
    const channel_knobs *k = (const channel_knobs *)knobs;
    double mean = 0.01, slope; /* [m/s] */
    val_outcome out;
    val_job job;
    memset(&lab, 0, sizeof lab);
    memset(&job, 0, sizeof job);
    memset(&out, 0, sizeof out);
    job.ctx = b->ctx;
    job.lab = &lab;
    job.out = &out;
    flow_channel(&lab, 2.0 * FLOW_HALF / k->n, k->m, 0.0, 4.0 * FLOW_HALF, &mean, k->tolerance);
    pd_status status = lab_build(b->ctx, &lab, VAL_FLOW | VAL_STEADY);
    if (status >= 0) status = flow_solve(&job);
    if (status >= 0) flow_errors(&job, -3.0 * FLOW_MU * mean / (FLOW_HALF * FLOW_HALF), &p->err, &slope);
    lab_free(b->ctx, &lab);
    p->steps = (double)out.steps;
    p->evals = (double)out.evals;
    return status;
}

static pd_status study_channel(bench *b, study *s)
{
    static const struct {
        const char *name;
        double m, tolerance;
    } family[] = {{"m = 3, residual 1e-8", 3.0, 1e-8}, {"m = 3, residual 1e-6", 3.0, 1e-6},
                  {"m = 3, residual 1e-4", 3.0, 1e-4}, {"m = 2, residual 1e-8", 2.0, 1e-8},
                  {"m = 4, residual 1e-8", 4.0, 1e-8}};
    study_open(s, "poiseuille", "Poiseuille flow: velocity", "relative L2 error of u [-]");
    s->families = (int)(sizeof family / sizeof family[0]);
    for (int f = 0; f < s->families; f++) {
        s->family[f] = family[f].name;
        for (int n = 15; n <= (b->quick ? 15 : 60); n *= 2) {
            char knob[48];
            channel_knobs k;
            k.n = n;
            k.m = family[f].m;
            k.tolerance = family[f].tolerance;
            snprintf(knob, sizeof knob, "%d nodes across", n);
            PD_TRY(study_measure(b, s, f, study_channel_once, &k, knob));
        }
    }
    study_close(b, s);
    bench_note(b, "The parabola is an exact discrete solution at every spacing and horizon, so the error is that of "
                  "the solver alone: coarse grids with a tight tolerance are the efficient ones, and refinement "
                  "buys nothing.");
    return PD_OK;
}

/* ---- pin ---- */

typedef struct pin_knobs {
    const char *h, *m, *steady;
    double fraction;
} pin_knobs;

static double study_pin_reference; /* [-] */

/* Volume loss of the 2D pin at the end of the run. */
static pd_status study_pin_loss(bench *b, const pin_knobs *k, double *loss, study_point *p)
{
    char text[3][48];
    const char *overrides[4];
    pd_setup setup;
    pd_model model;
    snprintf(text[0], sizeof text[0], "grid.h=%s um", k->h);
    snprintf(text[1], sizeof text[1], "grid.m=%s", k->m);
    snprintf(text[2], sizeof text[2], "flow.steady_tolerance=%s", k->steady);
    for (int i = 0; i < 3; i++) overrides[i] = text[i];
    overrides[3] = "run.until=4 h";
    memset(&model, 0, sizeof model);
    pd_status status = runs_open(b, "mg_pin_2d.scene", overrides, 4, &setup, &model);
    if (status >= 0) {
        model.time_loop.desc.fraction = k->fraction;
        status = pd_time_loop_run(b->ctx, &model.time_loop, setup.end_time, setup.end_time, NULL, NULL);
    }
    *loss = pd_time_loop_volume_loss(&model.time_loop);
    p->steps = (double)model.time_loop.steps;
    p->evals = (double)model.quasi.evaluations;
    runs_close(b, &setup, &model);
    return status;
}

static pd_status study_pin_once(bench *b, const void *knobs, study_point *p)
{
    double loss;
    PD_TRY(study_pin_loss(b, (const pin_knobs *)knobs, &loss, p));
    p->err = fabs(loss / study_pin_reference - 1.0);
    return PD_OK;
}

static pd_status study_pin(bench *b, study *s)
{
    static const pin_knobs best = {"5", "3", "1e-6", 0.05}, coarse = {"10", "3", "1e-6", 0.1};
    static const struct {
        const char *name;
        pin_knobs knobs;
    } family[] = {{"m = 3, share 0.2", {"", "3", "1e-6", 0.2}},
                  {"m = 3, share 0.05", {"", "3", "1e-6", 0.05}},
                  {"m = 2, share 0.2", {"", "2", "1e-6", 0.2}},
                  {"m = 4, share 0.2", {"", "4", "1e-6", 0.2}},
                  {"m = 3, share 0.2, residual 1e-3", {"", "3", "1e-3", 0.2}}};
    static const char *const h[] = {"20", "10"};
    study_point reference;
    study_open(s, "pin", "Mg pin in 2D: volume loss after 4 h", "difference from the finest run [-]");
    PD_TRY(study_pin_loss(b, b->quick ? &coarse : &best, &study_pin_reference, &reference));
    bench_result(b, "part=pin_reference volume_loss=%.6g steps=%.0f evals=%.0f", study_pin_reference, reference.steps,
                 reference.evals);
    s->families = b->quick ? 1 : (int)(sizeof family / sizeof family[0]);
    for (int f = 0; f < s->families; f++) {
        s->family[f] = family[f].name;
        for (int l = 0; l < (b->quick ? 1 : 2); l++) {
            char knob[48];
            pin_knobs k = family[f].knobs;
            k.h = h[l];
            snprintf(knob, sizeof knob, "h = %s um", h[l]);
            PD_TRY(study_measure(b, s, f, study_pin_once, &k, knob));
        }
    }
    study_close(b, s);
    bench_note(b, "The finest run has h = 5 um, m = 3, a residual of 1e-6 and steps that take at most 0.05 of a node.");
    return PD_OK;
}

static pd_status study_run(bench *b)
{
    static study s;
    PD_TRY(study_channel(b, &s));
    return study_pin(b, &s);
}

static const bench_case study_case = {
    "study", "Speed against error",
    "Steady flow between plates from rest, the velocity against the closed form (L2). Four hours of the Mg pin, the "
    "volume loss against that of the finest run, since no closed form exists. Spacing, horizon, tolerances and "
    "steps vary.",
    study_run};

#endif
#endif
