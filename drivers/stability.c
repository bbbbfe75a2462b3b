/* stability1d, stability2d, stability3d: how long the explicit steps may be in truth, against the steps that the
 * integrators choose, and that implicit steps have no limit.
 *
 *   stability2d [NAME ...] [--quick] [--check] [--out DIR] [--quiet] [--list] [--help]
 *
 * Exit status: 0 done, 1 a run failed or, with --check, a step is none of those the program knows, 2 wrong usage.
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
#include "cases/validate/lab.h"
#include "cases/stability/symbol.h"
#include "cases/stability/cases.h"

enum { STAB_RATIOS = 4, STAB_ROOM = 16 };
static const double ratios[STAB_RATIOS] = {2.0, 3.0, 4.0, 5.0};

/* The results of one case: a row for each m and abscissa. */
typedef struct map {
    stab_point point[STAB_RATIOS][STAB_ROOM];
    double x[STAB_ROOM];
    int ratios, count;
} map;

static map maps[STAB_CASE_COUNT];

static void help(const char *program)
{
    printf("%s [NAME ...] [options]\n\n"
           "Measures the longest stable and the longest bounded step of every integrator in %d dimension%s (pdcorr "
           "%s).\n\n"
           "  NAME         cases to run, all when none is named\n"
           "  --quick      three points and two horizon ratios of each case\n"
           "  --check      exit status 1 when a step is longer than its limit, or shorter than the case knows it to "
           "be\n"
           "  --out DIR    write the sections of the report and their figures into DIR, made when missing\n"
           "  --quiet      print result lines and errors only\n"
           "  --list       print the names of the cases\n\n"
           "Exit status: 0 done, 1 a run failed or a check did, 2 wrong usage.\n",
           program, PD_DIM, PD_DIM > 1 ? "s" : "", PD_VERSION);
}

static const char *name_of(int number) { return number < STAB_CASE_COUNT ? stab_cases[number].name : NULL; }

/* The limit that the step of a case is there for. */
static double limit_of(const stab_point *p) { return p->bounded > 0.0 ? p->bounded : p->stable; }

static pd_status run_case(const options *o, pd_ctx *ctx, const stab_case *c, map *m)
{
    static val_lab lab;
    int step = o->quick ? (c->count + 1) / 3 : 1;
    m->ratios = o->quick ? 2 : STAB_RATIOS;
    m->count = 0;
    for (int k = 0; k < c->count; k += step) m->x[m->count++] = c->x[k];
    for (int r = 0; r < m->ratios; r++)
        for (int k = 0; k < m->count; k++) {
            stab_point *p = &m->point[r][k];
            memset(p, 0, sizeof *p);
            memset(&lab, 0, sizeof lab);
            pd_status status = c->run(ctx, &lab, ratios[r], m->x[k], p);
            lab_free(ctx, &lab);
            if (status != PD_OK) return status;
            printf("result case=%s dim=%d m=%g %s=%g step=%.6g", c->name, PD_DIM, ratios[r], c->key, m->x[k], p->step);
            if (p->stable > 0.0) printf(" stable=%.6g", p->stable);
            if (p->bounded > 0.0) printf(" bounded=%.6g", p->bounded);
            if (c->implicit) printf(" growth=%.3g\n", p->growth);
            else printf(" ratio=%.4f\n", p->step / limit_of(p));
            fflush(stdout);
        }
    return PD_OK;
}

/* 1: every step lies where the case says. *least, *most: of all ratios, or growths. */
static int judge(const stab_case *c, const map *m, double *least, double *most)
{
    *least = HUGE_VAL;
    *most = 0.0;
    for (int r = 0; r < m->ratios; r++)
        for (int k = 0; k < m->count; k++) {
            const stab_point *p = &m->point[r][k];
            double value = c->implicit ? p->growth : p->step / limit_of(p);
            *least = fmin(*least, value);
            *most = fmax(*most, value);
        }
    return c->implicit ? *most <= 1.0 : *least >= c->least && *most <= 1.0 + 1e-3;
}

/* ---- report ---- */

static pd_status draw(pd_ctx *ctx, const stab_case *c, const map *m, int share, const char *path)
{
    static double y[2 * STAB_RATIOS][STAB_ROOM];
    char name[2 * STAB_RATIOS][48], title[120];
    double one[2] = {1.0, 1.0}, nine[2] = {0.9, 0.9}, ends[2];
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    ends[0] = m->x[0];
    ends[1] = m->x[m->count - 1];
    for (int r = 0; r < m->ratios; r++) {
        if (!share && !c->implicit && r == 2) continue; /* room for three pairs */
        for (int k = 0; k < m->count; k++) {
            const stab_point *p = &m->point[r][k];
            y[r][k] = c->implicit ? p->growth : share ? p->step / limit_of(p) : limit_of(p) * p->unit;
            y[STAB_RATIOS + r][k] = p->step * p->unit;
        }
        snprintf(name[r], sizeof name[r], c->implicit || share ? "m = %g" : "m = %g, limit", ratios[r]);
        plot_add(&plot, name[r], m->x, y[r], m->count,
                 share || c->implicit ? PD_SERIES_STYLE_BOTH : PD_SERIES_STYLE_MARKERS);
        snprintf(name[STAB_RATIOS + r], sizeof name[0], "m = %g, step", ratios[r]);
        if (!share && !c->implicit)
            plot_add(&plot, name[STAB_RATIOS + r], m->x, y[STAB_RATIOS + r], m->count, PD_SERIES_STYLE_LINE);
    }
    if (share) plot_add(&plot, "limit", ends, one, 2, PD_SERIES_STYLE_DASHED);
    if (share) plot_add(&plot, "0.9", ends, nine, 2, PD_SERIES_STYLE_DASHED);
    snprintf(title, sizeof title, "%s, %dD: %s", c->name, PD_DIM,
             c->implicit ? "growth in a step"
             : share     ? "step over its limit"
                         : "limit and step");
    plot.title = title;
    plot.x_label = c->x_label;
    plot.y_label = c->implicit ? "largest value after a step over that before [-]"
                   : share     ? "step / limit [-]"
                               : c->y_label;
    plot.x_log = 1;
    plot.y_log = !share;
    if (share) plot.y_hi = 1.1;
    return pd_plot_write(ctx, path, &plot);
}

static pd_status figure(pd_ctx *ctx, const char *folder, pd_file *file, const stab_case *c, const map *m, int share)
{
    char path[PD_PATH_SIZE], name[96];
    snprintf(name, sizeof name, "%s_%dd_%s.png", c->name, PD_DIM, share ? "share" : "map");
    PD_TRY(pd_file_join(ctx, folder, name, path));
    PD_TRY(draw(ctx, c, m, share, path));
    return report_text(ctx, file, "![%s, %dD](%s)\n\n", c->name, PD_DIM, name);
}

static void head(const stab_case *c, table_row *row)
{
    row->cells = 0;
    table_cell(row, "m");
    table_cell(row, "%s", c->x_label);
    if (c->implicit) {
        table_cell(row, "growth in a step");
        return;
    }
    table_cell(row, "step [h = 1]");
    table_cell(row, "stable to");
    table_cell(row, "bounded to");
    table_cell(row, "step over its limit");
}

static void line(const stab_case *c, double ratio, double x, const stab_point *p, table_row *row)
{
    row->cells = 0;
    table_cell(row, "%g", ratio);
    table_cell(row, "%g", x);
    if (c->implicit) {
        table_cell(row, "%.2e", p->growth);
        return;
    }
    table_cell(row, "%.4g", p->step);
    if (p->stable > 0.0) table_cell(row, "%.4g", p->stable);
    else table_cell(row, "-");
    if (p->bounded > 0.0) table_cell(row, "%.4g", p->bounded);
    else table_cell(row, "-");
    table_cell(row, "%.3f", p->step / limit_of(p));
}

static pd_status section(pd_ctx *ctx, const char *folder, pd_file *file, const stab_case *c, const map *m)
{
    static table_row rows[STAB_RATIOS * STAB_ROOM + 1];
    double least, most;
    int good = judge(c, m, &least, &most), count = 1;
    PD_TRY(report_text(ctx, file, "### %s, %dD: %s\n\n%s\n\n*Run.* `build/stability%dd %s`\n\n", c->name, PD_DIM,
                       c->title, c->what, PD_DIM, c->name));
    if (c->implicit)
        PD_TRY(report_text(ctx, file, "- a step leaves at most %.2e of a disturbance: %s\n\n", most,
                           good ? "no limit" : "**it grows**"));
    else
        PD_TRY(report_text(ctx, file, "- step over its limit: %.3f to %.3f; %s\n\n", least, most,
                           least >= 0.9 && good ? "within 10 % from below"
                           : good               ? "shorter than asked for (0.9), as explained"
                                                : "**not as it should be**"));
    head(c, &rows[0]);
    for (int r = 0; r < m->ratios; r++)
        for (int k = 0; k < m->count; k++) line(c, ratios[r], m->x[k], &m->point[r][k], &rows[count++]);
    PD_TRY(report_table(ctx, file, rows, count));
    PD_TRY(figure(ctx, folder, file, c, m, 0));
    return c->implicit ? PD_OK : figure(ctx, folder, file, c, m, 1);
}

static pd_status write_section(pd_ctx *ctx, const char *folder, const stab_case *c, const map *m)
{
    char path[PD_PATH_SIZE], name[96];
    pd_file file;
    memset(&file, 0, sizeof file);
    snprintf(name, sizeof name, "%s_%dd.md", c->name, PD_DIM);
    PD_TRY(pd_file_join(ctx, folder, name, path));
    PD_TRY(pdi_file_create(ctx, path, &file));
    pd_status status = section(ctx, folder, &file, c, m);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

static int run(const options *o, pd_ctx *ctx)
{
    int bad = 0;
    pd_status status = o->out ? pd_file_make_directory(ctx, o->out) : PD_OK;
    for (int c = 0; c < STAB_CASE_COUNT && status == PD_OK; c++) {
        double least, most;
        if (o->named && !o->wanted[c]) continue;
        status = run_case(o, ctx, &stab_cases[c], &maps[c]);
        if (status != PD_OK) break;
        int good = judge(&stab_cases[c], &maps[c], &least, &most);
        bad += !good;
        if (!o->quiet)
            printf("%s, %dD: %s %.3g to %.3g%s\n", stab_cases[c].name, PD_DIM,
                   stab_cases[c].implicit ? "growth in a step" : "step over its limit", least, most,
                   good ? "" : ": BAD");
        if (o->out) status = write_section(ctx, o->out, &stab_cases[c], &maps[c]);
    }
    if (status != PD_OK) {
        fprintf(stderr, "%s: %s\n", o->program, ctx->message);
        return 1;
    }
    return o->check && bad;
}

static int act(int argc, char **argv, options *o)
{
    static const usage taken = {name_of, "--check", 0.0};
    pd_ctx ctx;
    int status = parse(argc, argv, &taken, o);
    if (status) return status;
    if (o->help) help(o->program);
    for (int c = 0; c < STAB_CASE_COUNT && o->list; c++) printf("%-12s %s\n", stab_cases[c].name, stab_cases[c].title);
    if (o->help || o->list) return 0;
    calm_threads(argv);
    pd_ctx_init(&ctx);
    return run(o, &ctx);
}

int main(int argc, char **argv)
{
    options o;
    memset(&o, 0, sizeof o);
    return ended(&o, act(argc, argv, &o));
}
