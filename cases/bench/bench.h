/* bench: what a case of the benchmark is, how it reports, and how it takes times.
 *
 * A case is one run function. It times or counts, and hands over result lines, tables, figures and goals; the driver
 * prints them and writes them into the section of the report. To add a case: write it into the file of its room and
 * list it in cases.h.
 */
#ifndef BENCH_BENCH_H
#define BENCH_BENCH_H

enum { BENCH_LINES = 512, BENCH_LINE = 320, BENCH_ROWS = 64, BENCH_GOALS = 48, BENCH_JOBS = 24 };

typedef struct bench bench;
typedef pd_status (*bench_run_fn)(bench *b);

typedef struct bench_case {
    const char *name, *title;
    const char *what; /* is measured, and how */
    bench_run_fn run;
} bench_case;

/* A figure with the bound that it is held to. */
typedef struct bench_goal {
    const bench_case *of;
    char what[96];
    int at_least; /* else at most */
    double bound, found;
} bench_goal;

struct bench {
    pd_ctx *ctx;
    const char *scenes; /* folder of the scene files */
    const char *out;    /* folder of the report; NULL: none */
    int quick, quiet;
    int n;              /* 0: sizes of the case */
    double m;           /* [-] 0: horizons of the case */
    int threads;        /* the most to use */
    double share;       /* [-] of its core that one thread had while it was timed, least so far */
    const bench_case *of;
    pd_file file;       /* section of the report */
    char (*line)[BENCH_LINE];
    int lines;
    table_row row[BENCH_ROWS];
    int rows;
    bench_goal goal[BENCH_GOALS];
    int goals;
    pd_status status;   /* of writing the report */
};

static void bench_text(bench *b, const char *text)
{
    if (b->out && b->status == PD_OK) b->status = pdi_file_write_text(b->ctx, &b->file, text);
}

/* ---- what a case hands over ---- */

/* "result case=kernels dim=2 ..." with the keys of the format behind it. */
PD_PRINTF_LIKE(2, 3)
static void bench_result(bench *b, const char *format, ...)
{
    va_list args;
    if (b->lines == BENCH_LINES) return;
    char *line = b->line[b->lines++];
    int size = snprintf(line, BENCH_LINE, "result case=%s dim=%d ", b->of->name, PD_DIM);
    va_start(args, format);
    size += vsnprintf(line + size, (size_t)(BENCH_LINE - size), format, args);
    va_end(args);
    if (size < BENCH_LINE) snprintf(line + size, (size_t)(BENCH_LINE - size), " peak_rss_mb=%.1f", peak_rss_mb());
}

/* The next row of the table, empty. */
static table_row *bench_row(bench *b)
{
    table_row *row = &b->row[b->rows < BENCH_ROWS ? b->rows++ : BENCH_ROWS - 1];
    row->cells = 0;
    return row;
}

/* The rows since the last table become one. */
static void bench_table(bench *b, const char *title)
{
    if (!b->quiet) {
        printf("  %s\n", title);
        table_print(b->row, b->rows);
        fflush(stdout);
    }
    if (b->out && b->status == PD_OK) {
        bench_text(b, "**");
        bench_text(b, title);
        bench_text(b, "**\n\n");
        if (b->status == PD_OK) b->status = report_table(b->ctx, &b->file, b->row, b->rows);
    }
    b->rows = 0;
}

/* A paragraph below the tables. */
static void bench_note(bench *b, const char *text)
{
    if (!b->quiet) printf("  %s\n", text);
    bench_text(b, text);
    bench_text(b, "\n\n");
}

static int bench_met(const bench_goal *g) { return g->at_least ? g->found >= g->bound : g->found <= g->bound; }

static void bench_judge(bench *b, const char *what, int at_least, double bound, double found)
{
    if (b->goals == BENCH_GOALS) return;
    bench_goal *g = &b->goal[b->goals++];
    g->of = b->of;
    snprintf(g->what, sizeof g->what, "%s", what);
    g->at_least = at_least;
    g->bound = bound;
    g->found = found;
    if (!b->quiet)
        printf("  goal: %s %s %g: %s, %.3g\n", what, at_least ? "at least" : "at most", bound,
               bench_met(g) ? "met" : "MISSED", found);
}

/* CASE_2d_NAME.png, linked in the section. */
static void bench_figure(bench *b, const char *name, const pd_plot *plot)
{
    char path[PD_PATH_SIZE], file[128], link[320];
    if (!b->out || b->status != PD_OK) return;
    snprintf(file, sizeof file, "%s_%dd_%s.png", b->of->name, PD_DIM, name);
    b->status = pd_file_join(b->ctx, b->out, file, path);
    if (b->status == PD_OK) b->status = pd_plot_write(b->ctx, path, plot);
    snprintf(link, sizeof link, "![%s, %dD, %s](%s)\n\n", b->of->name, PD_DIM, name, file);
    bench_text(b, link);
}

/* ---- times ---- */

/* Something to be timed. */
typedef struct bench_job {
    const char *name;
    void (*run)(void *user);
    void *user;
    double nodes; /* that one call works on */
    double best;  /* [s] of one call */
} bench_job;

/* One thread is timed by the processor, which does not count what other programs take; several need the wall. */
static double bench_clock(int threads) { return threads > 1 ? wall_seconds() : cpu_seconds(); }

/* Least time of one call of each job, on `threads` threads. The jobs take turns, so that all of them see the machine in
 * the same moods: on a shared machine ratios of these times count, not the times. Short jobs are repeated within a
 * turn; of long ones (several seconds in all) there are two turns after the warm-up. */
static void bench_time(bench *b, bench_job *job, int jobs, int threads)
{
    double turn = b->quick ? 2e-4 : 2e-3, budget = (b->quick ? 0.004 : 0.2) * jobs, spent = 0.0, warm = 0.0;
    double wall = wall_seconds(), cpu = cpu_seconds();
    int repeat[BENCH_JOBS];
    b->ctx->threads = threads;
    for (int k = 0; k < jobs; k++) {
        double start = bench_clock(threads);
        job[k].run(job[k].user);
        job[k].best = bench_clock(threads) - start;
        repeat[k] = 1 + (int)fmin(turn / fmax(job[k].best, 1e-8), 1e4);
        warm += job[k].best;
    }
    for (int round = 0; round < (warm > 3.0 ? 2 : 4) || spent < budget; round++)
        for (int k = 0; k < jobs; k++) {
            double start = bench_clock(threads);
            for (int r = 0; r < repeat[k]; r++) job[k].run(job[k].user);
            double took = bench_clock(threads) - start;
            spent += took;
            job[k].best = fmin(job[k].best, took / repeat[k]);
        }
    if (threads == 1) b->share = fmin(b->share, (cpu_seconds() - cpu) / (wall_seconds() - wall));
    b->ctx->threads = b->threads;
}

/* 1 when times of several threads mean something: one thread had its core to itself. Otherwise a note is added. */
static int bench_alone(bench *b)
{
    char text[160];
    if (b->share >= 0.95) return 1;
    snprintf(text, sizeof text,
             "Other programs left one thread %.0f %% of its core while it was timed, so speed-ups mean nothing here.",
             100.0 * b->share);
    bench_note(b, text);
    return 0;
}

static double bench_rate(const bench_job *job) { return job->nodes / job->best; }

/* ---- triad ---- */

/* a = b + s c on arrays as long as a padded field: three accesses of 8 bytes a node, as many as a kernel needs that
 * reads one field and writes another. */
typedef struct triad {
    pd_ctx *ctx;
    int64_t n;
    double *a, *b, *c;
} triad;

static void triad_run(void *user)
{
    triad *t = (triad *)user;
    int64_t n = t->n;
    double *PD_RESTRICT a = t->a;
    const double *PD_RESTRICT b = t->b, *PD_RESTRICT c = t->c;
    int nt = pd_par_threads(t->ctx, n);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) a[i] = b[i] + 3.0 * c[i];
}

static void triad_free(pd_ctx *ctx, triad *t)
{
    PD_DELETE(ctx, t->n, t->a);
    PD_DELETE(ctx, t->n, t->b);
    PD_DELETE(ctx, t->n, t->c);
}

static pd_status triad_build(pd_ctx *ctx, int64_t n, triad *t)
{
    memset(t, 0, sizeof *t);
    t->ctx = ctx;
    t->n = n;
    PD_TRY(PD_NEW(ctx, "triad", n, t->a));
    PD_TRY(PD_NEW(ctx, "triad", n, t->b));
    PD_TRY(PD_NEW(ctx, "triad", n, t->c));
    for (int64_t i = 0; i < n; i++) {
        t->b[i] = (double)(i & 63);
        t->c[i] = 1.0;
    }
    return PD_OK;
}

/* Keys of one timed job in a result line. */
static void bench_time_result(bench *b, const char *part, int n, double m, const bench_job *job, const bench_job *bound,
                              int threads)
{
    bench_result(b, "part=%s name=%s n=%d m=%g node_rate=%.4g triad_share=%.4g wall_s=%.4g threads=%d", part, job->name,
                 n, m, bench_rate(job), bench_rate(job) / bench_rate(bound), job->best, threads);
}

#endif
