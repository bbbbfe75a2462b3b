/* neighbour: what a run takes beside programs that keep processors busy. */
#ifndef BENCH_NEIGHBOUR_H
#define BENCH_NEIGHBOUR_H
#if PD_DIM == 2
#if defined(_POSIX_VERSION)
#include <signal.h>
#include <sys/wait.h>

enum { NEIGHBOUR_MOST = 16, NEIGHBOUR_ROUNDS = 3 };

/* A process that does nothing else than count, until its parent stops it or is gone. 0: there is none. */
static pid_t neighbour_start(void)
{
    pid_t parent = getpid(), child = fork();
    if (child != 0) return child > 0 ? child : 0;
    volatile uint32_t count = 0;
    while (getppid() == parent)
        for (int k = 0; k < 1000000; k++) count = count + 1;
    _exit(0);
}

static void neighbour_stop(pid_t child)
{
    if (!child) return;
    kill(child, SIGTERM);
    waitpid(child, NULL, 0);
}

/* Wall time of a run, from the building of its objects to its end, in a context of its own. */
static pd_status neighbour_run_once(bench *b, int threads, double *wall)
{
    const char *const overrides[] = {b->quick ? "grid.h=10 um" : "grid.h=5 um", "run.until=1 min"};
    pd_ctx ctx, *outer = b->ctx;
    pd_setup setup;
    pd_model model;
    pd_step_diagnostics seen;
    double start = wall_seconds();
    memset(&seen, 0, sizeof seen);
    pd_ctx_init(&ctx);
    ctx.threads = threads;
    b->ctx = &ctx;
    pd_status status = runs_open(b, "mg_pin_2d.scene", overrides, 2, &setup, &model);
    if (status >= 0) status = scene_steps(b, &model, &seen);
    *wall += wall_seconds() - start;
    pd_step_diagnostics_free(&ctx, &seen);
    runs_close(b, &setup, &model);
    b->ctx = outer;
    return status < 0 ? pd_fail(outer, status, "bench", "%s", ctx.message) : PD_OK;
}

/* Both numbers of threads take turns. */
static pd_status neighbour_level(bench *b, int busy)
{
    double wall[2] = {0.0, 0.0};
    int rounds = b->quick ? 1 : NEIGHBOUR_ROUNDS, running = 0;
    pid_t child[NEIGHBOUR_MOST];
    char what[96];
    pd_status status = PD_OK;
    for (int k = 0; k < busy; k++) running += (child[k] = neighbour_start()) != 0;
    for (int round = 0; round < 2 * rounds && running == busy && status >= 0; round++)
        status = neighbour_run_once(b, round % 2 ? b->threads : 1, &wall[round % 2]);
    for (int k = 0; k < busy; k++) neighbour_stop(child[k]);
    if (running < busy) bench_note(b, "No process could be started beside.");
    if (status < 0 || running < busy) return status;
    table_row *row = bench_row(b);
    table_cell(row, "%d", busy);
    for (int k = 0; k < 2; k++) table_cell(row, "%.2f", wall[k] / rounds);
    table_cell(row, "%.2f", wall[1] / wall[0]);
    bench_result(b, "part=pin busy=%d threads=%d wall_one_s=%.3f wall_s=%.3f ratio=%.3f", busy, b->threads,
                 wall[0] / rounds, wall[1] / rounds, wall[1] / wall[0]);
    snprintf(what, sizeof what, "pin beside %d busy: wall time on %d threads over that on one", busy, b->threads);
    if (busy && !b->quick) bench_judge(b, what, 0, 1.2, wall[1] / wall[0]);
    return PD_OK;
}

static pd_status neighbour_run(bench *b)
{
    if (b->threads == 1 || b->threads > NEIGHBOUR_MOST) {
        bench_note(b, "Left out: it takes two to sixteen threads.");
        return PD_OK;
    }
    table_row *head = bench_row(b);
    table_cell(head, "busy processes");
    table_cell(head, "one thread [s]");
    table_cell(head, "%d threads [s]", b->threads);
    table_cell(head, "ratio");
    for (int busy = 0; busy <= b->threads; busy += busy ? b->threads - 1 : 1) PD_TRY(neighbour_level(b, busy));
    bench_table(b, "Wall time of the first minute of the pin (`mg_pin_2d`)");
    return PD_OK;
}
#else
static pd_status neighbour_run(bench *b)
{
    bench_note(b, "Left out: this system has no fork().");
    return PD_OK;
}
#endif

static const bench_case neighbour_case = {
    "neighbour", "Beside busy programs",
    "A run on one thread and on several, beside processes that do nothing but count: none, one, and one for each "
    "thread. The runs take turns, and the times are means. Threads that wait for one whose processor is taken lose a "
    "time slice; the library goes over to one thread where that costs more than it gains.",
    neighbour_run};
#endif
#endif
