/* screen: what the programs print: lines, progress, the figures of a run. Needs pdcorr.h and machine.h. */
#ifndef PDCORR_SCREEN_H
#define PDCORR_SCREEN_H
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct screen {
    int quiet, terminal;
    int open;         /* a progress line stands without its newline */
    int lines;        /* 1: lines of progress where there is no terminal */
    double every, said; /* [s] wall time between them, and of the last one */
    FILE *results;    /* of lines of results */
} screen;

static void end_progress(screen *s)
{
    if (s->open) fprintf(stderr, "\n");
    s->open = 0;
}

/* Progress: on a terminal one line that replaces itself, elsewhere a line now and then, so that logs stay readable. */
static void print_progress(screen *s, const char *text)
{
    double now = wall_seconds();
    if (s->terminal) {
        fprintf(stderr, "\r%.*s\033[K", terminal_width() - 1, text);
        s->open = 1;
    } else if (s->lines && now - s->said >= s->every) {
        fprintf(stderr, "%s\n", text);
        s->said = now;
    }
    fflush(stderr);
}

static void print(void *user, pd_print_kind kind, const char *text)
{
    screen *s = (screen *)user;
    if (kind == PD_PRINT_PROGRESS) {
        print_progress(s, text);
        return;
    }
    if (s->quiet && kind != PD_PRINT_RESULT) return;
    end_progress(s);
    fprintf(s->results, "%s%s\n", kind == PD_PRINT_NOTE ? "note: " : "", text);
    fflush(s->results);
}

/* ---- the figures of a run, as they come ---- */

enum { FOLLOW_WIDTH = 12, FOLLOW_NAME = 128 };

typedef struct follow {
    screen *s;
    int begun;
    pd_scalar_outputs figures;
} follow;

/* "probe.a.C"; those of the scene have no section. */
static void follow_name(const pd_scalar_output *f, char *name)
{
    if (strcmp(f->section, "scene") == 0) snprintf(name, FOLLOW_NAME, "%s", f->key);
    else snprintf(name, FOLLOW_NAME, "%s.%s.%s", f->section, f->name, f->key);
}

/* A field of CSV; one that would be misread stands in quotes. */
static void follow_text(const char *text)
{
    int quotes = strpbrk(text, ",\"") != NULL;
    if (quotes) printf("\"");
    for (; *text; text++) printf(*text == '"' ? "\"\"" : "%c", *text);
    if (quotes) printf("\"");
}

/* The shortest text that reads back as the same number. */
static void follow_number(double value)
{
    char text[40];
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        snprintf(text, sizeof text, "%.*g", digits, value);
        back = strtod(text, NULL);
        if (!(back < value) && !(back > value)) break;
    }
    printf("%s", text);
}

/* The columns before those of the figures. */
static const char *const follow_columns[][2] = {{"time", "s"}, {"step", "-"}, {"dt", "s"}};
enum { FOLLOW_COLUMNS = sizeof follow_columns / sizeof follow_columns[0] };

/* Name and unit of a column. */
static void follow_column(const follow *f, int k, char *name, const char **unit)
{
    if (k < FOLLOW_COLUMNS) snprintf(name, FOLLOW_NAME, "%s", follow_columns[k][0]);
    else follow_name(&f->figures.list[k - FOLLOW_COLUMNS], name);
    *unit = k < FOLLOW_COLUMNS ? follow_columns[k][1] : f->figures.list[k - FOLLOW_COLUMNS].unit;
}

static int follow_width(const char *name, const char *unit)
{
    int width = (int)strlen(name), least = (int)strlen(unit) + 2;
    width = width < least ? least : width;
    return (width < FOLLOW_WIDTH ? FOLLOW_WIDTH : width) + 1;
}

static void follow_head(const follow *f)
{
    char name[FOLLOW_NAME], text[2 * FOLLOW_NAME];
    const char *unit;
    int columns = FOLLOW_COLUMNS + f->figures.count;
    for (int line = 0; line < (f->s->quiet ? 1 : 2); line++) {
        for (int k = 0; k < columns; k++) {
            follow_column(f, k, name, &unit);
            if (f->s->quiet) {
                snprintf(text, sizeof text, "%s [%s]", name, unit);
                if (k) printf(",");
                follow_text(text);
            } else {
                snprintf(text, sizeof text, "[%s]", unit);
                printf("%*s", follow_width(name, unit), line ? text : name);
            }
        }
        printf("\n");
    }
}

/* A row for each instant. */
static int follow_instant(void *user, pd_ctx *ctx, const pd_snapshot *at)
{
    follow *f = (follow *)user;
    double own[FOLLOW_COLUMNS];
    char name[FOLLOW_NAME];
    const char *unit;
    if (at->stage == PD_SNAPSHOT_STAGE_END) return 0;
    if (pd_snapshot_get_outputs(ctx, at, &f->figures) < 0) return 1;
    end_progress(f->s);
    if (!f->begun) follow_head(f);
    f->begun = 1;
    own[0] = at->time;
    own[1] = (double)at->steps;
    own[2] = at->dt;
    for (int k = 0; k < FOLLOW_COLUMNS + f->figures.count; k++) {
        double value = k < FOLLOW_COLUMNS ? own[k] : f->figures.list[k - FOLLOW_COLUMNS].value;
        follow_column(f, k, name, &unit);
        if (f->s->quiet) {
            if (k) printf(",");
            follow_number(value);
        } else printf("%*.*g", follow_width(name, unit), k < FOLLOW_COLUMNS ? 9 : 6, value);
    }
    printf("\n");
    fflush(stdout);
    return 0;
}

#endif
