/* sweep: the runs of --sweep, side by side in processes of their own, as many as there are threads. */
#ifndef DRIVERS_SWEEP_H
#define DRIVERS_SWEEP_H
#include <errno.h>
#include <sys/wait.h>

enum { MAX_JOBS = 256 };

/* Exit status of a run: 0 done, 1 failed, 3 stopped. */
static int sweep_one(pd_ctx *ctx, const pd_sweep *sweep, int index, const pd_run_desc *desc)
{
    pd_status status = pd_sweep_run(ctx, sweep, index, desc);
    return status < 0 ? 1 : status == PD_RETRY ? 3 : 0;
}

static void sweep_tell(const pd_sweep *sweep, int index, int status)
{
    char label[PD_SWEEP_AXES * PD_SWEEP_VALUE];
    pd_sweep_label(sweep, index, label, sizeof label);
    printf("%s: %s\n", label, status == 0 ? "done" : status == 3 ? "stopped" : "failed, sweep.csv tells why");
    fflush(stdout);
}

/* Wait for one process; its place is free again. 0: there was none. */
static int sweep_reap(const pd_sweep *sweep, pid_t *child, int *index, int jobs)
{
    int status;
    pid_t ended = waitpid(-1, &status, 0);
    if (ended < 0 && errno == EINTR) {
        for (int k = 0; k < jobs && interrupted; k++)
            if (child[k] > 0) kill(child[k], SIGTERM); /* they may not have heard it */
        return 1;
    }
    for (int k = 0; k < jobs && ended > 0; k++) {
        if (child[k] != ended) continue;
        child[k] = 0;
        sweep_tell(sweep, index[k], WIFEXITED(status) ? WEXITSTATUS(status) : 1);
    }
    return ended > 0;
}

static void sweep_side_by_side(pd_ctx *ctx, const pd_sweep *sweep, const pd_run_desc *desc, int jobs)
{
    pid_t child[MAX_JOBS];
    int index[MAX_JOBS], next = 0, busy = 1;
    memset(child, 0, sizeof child);
    fflush(stdout);
    fflush(stderr);
    while (busy) {
        busy = 0;
        for (int k = 0; k < jobs; k++) {
            if (child[k] == 0 && next < sweep->runs && !interrupted) {
                index[k] = next++;
                child[k] = fork();
                if (child[k] == 0) _exit(sweep_one(ctx, sweep, index[k], desc));
                if (child[k] < 0) { /* no more processes: here, then */
                    child[k] = 0;
                    sweep_tell(sweep, index[k], sweep_one(ctx, sweep, index[k], desc));
                }
            }
            busy = busy || child[k] > 0;
        }
        if (busy && !sweep_reap(sweep, child, index, jobs)) break;
        busy = busy || (next < sweep->runs && !interrupted);
    }
}

/* 0: all runs are done, 1: one failed, 3: stopped. */
static int sweep_runs(pd_ctx *ctx, const pd_sweep *sweep, const pd_run_desc *desc, int threads)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int all = threads > 0 ? threads : cores > 0 && cores < MAX_JOBS ? (int)cores : 1;
    int jobs = sweep->runs < all ? sweep->runs : all;
    pd_sweep_count count;
    if (jobs > MAX_JOBS) jobs = MAX_JOBS;
    ctx->threads = all / jobs;
    if (jobs > 1) sweep_side_by_side(ctx, sweep, desc, jobs);
    for (int k = 0; k < sweep->runs && jobs == 1 && !interrupted; k++)
        sweep_tell(sweep, k, sweep_one(ctx, sweep, k, desc));
    if (pd_sweep_write(ctx, sweep, &count) < 0) {
        fprintf(stderr, "%s\n", ctx->message);
        return 1;
    }
    printf("sweep %s: %d done, %d failed, %d stopped; %s/sweep.csv\n", sweep->name, count.done, count.failed,
           count.stopped, sweep->folder);
    return count.stopped || interrupted ? 3 : count.failed ? 1 : 0;
}

#endif
