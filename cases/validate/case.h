/* case: what a validation case is. Included by drivers/validate.c, drivers/bench.c.
 *
 * A case has parts, a part has levels. The driver calls the part's run function once a level with a fresh lab, takes
 * the times, works out the orders of convergence and judges the goals. To add a case: write its run functions into the
 * file of its room (operators, flow, transport, dissolution), give it an entry there, list it in the table of cases.h.
 */
#ifndef VAL_CASE_H
#define VAL_CASE_H
#include "lab.h"

#define VAL_MEASURES 5
#define VAL_LEVELS 8
#define VAL_GOALS 6
#define VAL_CURVES 4
#define VAL_POINTS 1024

static const double val_pi = 3.14159265358979323846;

/* Sums of squares, of differences and of what is exact. Zero-initialise. */
typedef struct val_squares {
    double off, size;
} val_squares;

static void val_squares_add(val_squares *sum, double weight, double found, double exact)
{
    sum->off += weight * (found - exact) * (found - exact);
    sum->size += weight * exact * exact;
}

static double val_squares_l2(const val_squares *sum) { return sqrt(sum->off / sum->size); }

/* One set of numbers that a part runs with. */
typedef struct val_level {
    int n;    /* resolution: cells across the length that the part names */
    double m; /* [-] horizon ratio */
    double p; /* parameter of the part, in the unit of its column */
} val_level;

/* What is asked of the levels with n >= from. bound > 0: the error exceeds it at none of them. order > 0: the errors of
 * at least two of them fall with this order, the slope of the straight line of least squares. A guard is no goal of the
 * project: it holds coarse levels to what they reach, so that a quick run notices a regression. */
typedef enum val_rank {
    VAL_GOAL = 0,
    VAL_GUARD,
    VAL_GOAL_OF_ALL /* judged only when all levels of the part are run */
} val_rank;

typedef struct val_goal {
    int measure; /* index */
    double bound;
    double order; /* [-] */
    int from;
    val_rank rank;
} val_goal;

/* Key of result lines, and words for tables. */
typedef struct val_measure {
    const char *key, *label;
} val_measure;

typedef enum val_column {
    VAL_BY_N = 0,
    VAL_BY_M,
    VAL_BY_P
} val_column;

/* Curves of the finest level for a figure. */
typedef struct val_curve {
    char name[48];
    pd_series_style stroke;
    double x[VAL_POINTS], y[VAL_POINTS];
    int count;
} val_curve;

typedef struct val_profile {
    const char *title, *x_label, *y_label;
    int x_log, y_log;
    val_curve curve[VAL_CURVES];
    int curves;
} val_profile;

/* What one level gave. */
typedef struct val_outcome {
    double h;        /* [m] spacing along x */
    double x;        /* abscissa of the errors; 0: h */
    double err[VAL_MEASURES];
    double residual; /* [-] of the flow; 0: no flow solved */
    long steps, evals;
    double wall, cpu;    /* [s] */
    double peak_rss_mb;
} val_outcome;

/* One call of a run function. lab is zeroed before and freed after the call. */
typedef struct val_job {
    pd_ctx *ctx;
    val_level level;
    val_lab *lab;
    val_outcome *out;
    val_profile *profile; /* NULL: no curves wanted */
} val_job;

typedef pd_status (*val_run_fn)(val_job *job);

typedef struct val_part {
    const char *name;   /* one word for file names and result lines; "" when it is the only one */
    const char *title;
    const char *column; /* words for the column of the level */
    val_column by;
    const char *x_label; /* of the abscissa; NULL: h */
    double slope;        /* [-] expected order; 0: errors have no order in x */
    val_measure measure[VAL_MEASURES];
    int measures;
    val_goal goal[VAL_GOALS];
    int goals;
    val_level level[VAL_LEVELS];
    int levels, quick; /* all; how many of them, from the first, a quick run takes */
    val_run_fn run;
    const char *miss;   /* what is known about the cause of a missed goal; NULL: nothing */
} val_part;

typedef struct val_case {
    const char *name, *title;
    const char *what;   /* is computed */
    const char *why;    /* the mistakes that it catches */
    const char *source; /* of the reference */
    const val_part *const *part;
    int parts;
} val_case;

/* A part as it was run. */
typedef struct val_result {
    const val_case *of;
    const val_part *part;
    val_level level[VAL_LEVELS];
    val_outcome out[VAL_LEVELS];
    int levels;
    int failed; /* a run function failed; the message says why */
    char message[PD_MESSAGE_SIZE];
    val_profile profile;
} val_result;

/* Verdict on one goal. */
typedef enum val_verdict {
    VAL_UNJUDGED = 0, /* none of its levels was run */
    VAL_MET,
    VAL_MISSED
} val_verdict;

/* Order between the level before and `level`; NaN where there is none. */
static double val_order(const val_result *r, int level, int measure)
{
    if (level < 1 || !(r->part->slope > 0.0)) return NAN;
    const val_outcome *a = &r->out[level - 1], *b = &r->out[level];
    return log(a->err[measure] / b->err[measure]) / log(a->x / b->x);
}

/* Slope of the straight line of least squares through log error over log x, levels with n >= from; NaN for fewer than
 * two of them. */
static double val_fitted_order(const val_result *r, const val_goal *g)
{
    double count = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (int l = 0; l < r->levels; l++) {
        if (r->level[l].n < g->from) continue;
        double x = log(r->out[l].x), y = log(r->out[l].err[g->measure]);
        count += 1.0;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return count > 1.5 ? (count * sxy - sx * sy) / (count * sxx - sx * sx) : NAN;
}

/* *value: the worst error where the bound holds, or the order. A value that is no number is a miss. */
static val_verdict val_judge(const val_result *r, const val_goal *g, double *value)
{
    int judged = 0, missed = 0;
    *value = NAN;
    if (g->rank == VAL_GOAL_OF_ALL && r->levels < r->part->levels) return VAL_UNJUDGED;
    for (int l = 0; l < r->levels; l++) {
        double e = r->out[l].err[g->measure];
        if (r->level[l].n < g->from) continue;
        if (!judged++ || !(e <= *value)) *value = e;
        missed = missed || !(e <= g->bound);
    }
    if (g->order > 0.0) {
        if (judged < 2) return VAL_UNJUDGED;
        *value = val_fitted_order(r, g);
        missed = !(*value >= g->order);
    }
    return !judged ? VAL_UNJUDGED : missed ? VAL_MISSED : VAL_MET;
}

/* Add a curve to the profile of a job; NULL when none is wanted or no room is left. */
static val_curve *val_add_curve(val_job *job, const char *name, pd_series_style stroke)
{
    val_profile *p = job->profile;
    if (!p || p->curves == VAL_CURVES) return NULL;
    val_curve *c = &p->curve[p->curves++];
    snprintf(c->name, sizeof c->name, "%s", name);
    c->stroke = stroke;
    return c;
}

static void val_add_point(val_curve *c, double x, double y)
{
    if (!c || c->count == VAL_POINTS) return;
    c->x[c->count] = x;
    c->y[c->count++] = y;
}

#endif
