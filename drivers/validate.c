/* validate1d, validate2d, validate3d: accuracy of the solvers against closed forms and published figures.
 *
 *   validate2d [NAME ...] [m=3] [n=60] [--quick] [--check] [--out DIR] [--threads N] [--quiet] [--list] [--help]
 *
 * Exit status: 0 done, 1 a run failed or, with --check, a goal was missed, 2 wrong usage.
 */
#define _POSIX_C_SOURCE 200809L
#ifndef PDCORR_LINKED /* with a library that is compiled apart */
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "calm.h"
#include "cases/common.h"
#include "cases/table.h"
#include "cases/validate/cases.h"
#include "cases/validate/report.h"

static val_result *results; /* of all parts of the cases that run */
static val_lab lab;

static void help(const char *program)
{
    printf("%s [NAME ...] [m=M] [n=N] [options]\n\n"
           "Compares solutions in %d dimension%s with closed forms and published figures (pdcorr %s).\n\n"
           "  NAME           cases to run, all when none is named\n"
           "  m=M            horizon ratio in place of that of every level\n"
           "  n=N            one level of this resolution in place of the list of levels\n"
           "  --quick        the coarse levels only: seconds in total\n"
           "  --check        exit status 1 when a goal that applies to the levels run is missed, or none was judged\n"
           "  --out DIR      write the sections of the report and their figures into DIR, made when missing\n"
           "  --threads N    threads, 0: all\n"
           "  --quiet        print result lines and errors only\n"
           "  --list         print the names of the cases\n\n"
           "Exit status: 0 done, 1 a run failed or a goal was missed (--check), 2 wrong usage.\n",
           program, PD_DIM, PD_DIM > 1 ? "s" : "", PD_VERSION);
}

static const char *name_of(int number) { return number < VAL_CASE_COUNT ? val_cases[number]->name : NULL; }

/* The levels that the options ask for. */
static void choose_levels(const options *o, val_result *r)
{
    const val_part *p = r->part;
    r->levels = o->quick ? p->quick : p->levels;
    for (int l = 0; l < r->levels; l++) r->level[l] = p->level[l];
    if (o->n && p->by == VAL_BY_N) {
        r->levels = 1;
        r->level[0] = p->level[p->levels - 1];
    }
    for (int l = 0; l < r->levels; l++) {
        if (o->n) r->level[l].n = o->n;
        if (o->m > 0.0 && p->by != VAL_BY_M) r->level[l].m = o->m;
    }
}

static pd_status run_level(const options *o, pd_ctx *ctx, val_result *r, int l)
{
    val_job job;
    double wall = wall_seconds(), cpu = cpu_seconds();
    memset(&job, 0, sizeof job);
    memset(&lab, 0, sizeof lab);
    job.ctx = ctx;
    job.level = r->level[l];
    job.lab = &lab;
    job.out = &r->out[l];
    job.profile = o->out && l == r->levels - 1 ? &r->profile : NULL;
    pd_status status = r->part->run(&job);
    lab_free(ctx, &lab);
    if (!(job.out->x > 0.0))
        job.out->x = r->part->by == VAL_BY_M ? job.level.m : r->part->by == VAL_BY_P ? job.level.p : job.out->h;
    job.out->wall = wall_seconds() - wall;
    job.out->cpu = cpu_seconds() - cpu;
    job.out->peak_rss_mb = peak_rss_mb();
    return status;
}

/* Runs one part; what was reached before a failure stays in its table. */
static void run_part(const options *o, pd_ctx *ctx, const val_case *c, const val_part *p, val_result *r)
{
    memset(r, 0, sizeof *r);
    r->of = c;
    r->part = p;
    choose_levels(o, r);
    for (int l = 0; l < r->levels; l++) {
        if (run_level(o, ctx, r, l) == PD_OK) continue;
        r->failed = 1;
        r->levels = l;
        r->profile.curves = 0;
        snprintf(r->message, sizeof r->message, "%s", ctx->message);
    }
}

typedef struct tally {
    int results, missed, failed, unjudged;
} tally;

static pd_status run_case(const options *o, pd_ctx *ctx, const val_case *c, tally *t)
{
    int first = t->results, judged = 0;
    if (!o->quiet) val_print_title(c);
    for (int k = 0; k < c->parts; k++) {
        val_result *r = &results[t->results];
        run_part(o, ctx, c, c->part[k], r);
        if (!r->levels && !r->failed) continue; /* a quick run may leave out a part */
        if (!o->quiet) val_print_part(r);
        else if (r->failed) fprintf(stderr, "%s: %s: %s\n", o->program, c->name, r->message);
        val_verdict v = val_part_verdict(r);
        t->missed += v == VAL_MISSED;
        t->failed += r->failed;
        judged += v != VAL_UNJUDGED;
        t->results++;
    }
    t->unjudged += !judged;
    return o->out ? val_write_case(ctx, o->out, &results[first], t->results - first) : PD_OK;
}

static int run(const options *o, pd_ctx *ctx)
{
    tally t;
    int threads = pd_par_available_threads(ctx, INT64_MAX);
    pd_status status = o->out ? pd_file_make_directory(ctx, o->out) : PD_OK;
    int parts = 0;
    memset(&t, 0, sizeof t);
    for (int k = 0; k < VAL_CASE_COUNT; k++) parts += val_cases[k]->parts;
    if (status == PD_OK) status = PD_NEW(ctx, "validate", parts, results);
    for (int k = 0; k < VAL_CASE_COUNT && status == PD_OK; k++)
        if (!o->named || o->wanted[k]) status = run_case(o, ctx, val_cases[k], &t);
    if (status == PD_OK && o->out) status = val_write_summary(ctx, o->out, results, t.results);
    if (status != PD_OK) fprintf(stderr, "%s: %s\n", o->program, ctx->message);
    else if (!o->quiet) printf("\n");
    for (int k = 0; k < t.results && status == PD_OK; k++) val_print_result(&results[k], threads);
    PD_DELETE(ctx, parts, results);
    if (status != PD_OK) return 1;
    return t.failed || (o->check && (t.missed || t.unjudged));
}

static int act(int argc, char **argv, options *o)
{
    static const usage taken = {name_of, "--check --threads m= n=", 1.0};
    pd_ctx ctx;
    int status = parse(argc, argv, &taken, o);
    if (status) return status;
    if (o->help) help(o->program);
    for (int k = 0; k < VAL_CASE_COUNT && o->list; k++) printf("%-12s %s\n", val_cases[k]->name, val_cases[k]->title);
    if (o->help || o->list) return 0;
    calm_threads(argv);
    pd_ctx_init(&ctx);
    ctx.threads = o->threads;
    return run(o, &ctx);
}

int main(int argc, char **argv)
{
    options o;
    memset(&o, 0, sizeof o);
    return ended(&o, act(argc, argv, &o));
}
