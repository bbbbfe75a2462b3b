/* bench1d, bench2d, bench3d: speed of the operators, work of the solvers, cost of whole runs, speed against error.
 *
 *   bench2d [NAME ...] [m=3] [n=1024] [--quick] [--out DIR] [--scenes DIR] [--threads N] [--quiet] [--list] [--help]
 *
 * Exit status: 0 done, 1 a run failed, 2 wrong usage. A missed goal is no failure: times depend on the machine.
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
#include "cases/bench/cases.h"

static char lines[BENCH_LINES][BENCH_LINE];
static bench state;

static void help(const char *program)
{
    printf("%s [NAME ...] [m=M] [n=N] [options]\n\n"
           "Measures speed and counts work in %d dimension%s (pdcorr %s).\n\n"
           "  NAME           cases to run, all when none is named\n"
           "  m=M            horizon ratio in place of those of the case\n"
           "  n=N            nodes along an edge of the boxes that operators are timed on\n"
           "  --quick        small sizes and few repetitions: seconds in total; counts mean something, times do not\n"
           "  --out DIR      write the sections of the report and their figures into DIR, made when missing\n"
           "  --scenes DIR   folder of the scene files (examples/scenes)\n"
           "  --threads N    the most threads that are used, beside one (2); 0: all\n"
           "  --quiet        print result lines and errors only\n"
           "  --list         print the names of the cases\n\n"
           "Exit status: 0 done, 1 a run failed, 2 wrong usage.\n",
           program, PD_DIM, PD_DIM > 1 ? "s" : "", PD_VERSION);
}

static const char *name_of(int number) { return number < BENCH_CASE_COUNT ? bench_cases[number]->name : NULL; }

/* goals_NAME_2d.md: rows of the summary. */
static pd_status write_goals(bench *b, int first)
{
    char path[PD_PATH_SIZE], name[96];
    pd_file file;
    pd_status status = PD_OK;
    memset(&file, 0, sizeof file);
    snprintf(name, sizeof name, "goals_%s_%dd.md", b->of->name, PD_DIM);
    PD_TRY(pd_file_join(b->ctx, b->out, name, path));
    PD_TRY(pdi_file_create(b->ctx, path, &file));
    for (int k = first; k < b->goals && status == PD_OK; k++) {
        const bench_goal *g = &b->goal[k];
        status = report_text(b->ctx, &file, "| %s | [%s, %dD](#%s-%dd) | %s | %s %g | %.3g |\n",
                             bench_met(g) ? "met" : "**missed**", g->of->name, PD_DIM, g->of->name, PD_DIM, g->what,
                             g->at_least ? "at least" : "at most", g->bound, g->found);
    }
    if (status == PD_OK) return pdi_file_commit(b->ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

/* Runs a case with its section open. */
static pd_status run_section(bench *b)
{
    char path[PD_PATH_SIZE], name[96];
    int first = b->goals;
    memset(&b->file, 0, sizeof b->file);
    snprintf(name, sizeof name, "%s_%dd.md", b->of->name, PD_DIM);
    PD_TRY(pd_file_join(b->ctx, b->out, name, path));
    PD_TRY(pdi_file_create(b->ctx, path, &b->file));
    b->status = report_text(b->ctx, &b->file, "### %s, %dD: %s\n\n%s\n\n*Run.* `build/bench%dd %s`\n\n", b->of->name,
                            PD_DIM, b->of->title, b->of->what, PD_DIM, b->of->name);
    pd_status status = b->of->run(b);
    if (status >= 0) status = b->status;
    if (status >= 0) status = pdi_file_commit(b->ctx, &b->file);
    else pdi_file_abandon(&b->file);
    return status < 0 ? status : write_goals(b, first);
}

static pd_status run_case(bench *b, const bench_case *c)
{
    b->of = c;
    if (!b->quiet) printf("\n%s, %dD: %s\n", c->name, PD_DIM, c->title);
    fflush(stdout);
    return b->out ? run_section(b) : c->run(b);
}

static int act(int argc, char **argv, options *o)
{
    static const usage taken = {name_of, "--scenes --threads m= n=", 12.0};
    pd_ctx ctx;
    o->scenes = "examples/scenes";
    o->threads = 2;
    int status = parse(argc, argv, &taken, o);
    if (status) return status;
    if (o->help) help(o->program);
    for (int k = 0; k < BENCH_CASE_COUNT && o->list; k++)
        printf("%-10s %s\n", bench_cases[k]->name, bench_cases[k]->title);
    if (o->help || o->list) return 0;
    calm_threads(argv);
    pd_ctx_init(&ctx);
    ctx.threads = o->threads;
    bench *b = &state;
    b->ctx = &ctx;
    b->line = lines;
    b->scenes = o->scenes;
    b->out = o->out;
    b->quick = o->quick;
    b->quiet = o->quiet;
    b->n = o->n;
    b->m = o->m;
    b->threads = pd_par_available_threads(&ctx, INT64_MAX);
    b->share = 1.0;
    pd_status done = b->out ? pd_file_make_directory(&ctx, b->out) : PD_OK;
    for (int k = 0; k < BENCH_CASE_COUNT && done >= 0; k++)
        if (!o->named || o->wanted[k]) done = run_case(b, bench_cases[k]);
    if (!b->quiet) printf("\n");
    for (int k = 0; k < b->lines; k++) printf("%s\n", lines[k]);
    if (done >= 0) return 0;
    fprintf(stderr, "%s: %s\n", o->program, ctx.message);
    return 1;
}

int main(int argc, char **argv)
{
    options o;
    memset(&o, 0, sizeof o);
    return ended(&o, act(argc, argv, &o));
}
