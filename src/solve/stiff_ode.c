/* stiff_ode: see stiff_ode.h */
#include "solve/stiff_ode.h"
#include <math.h>
#include <string.h>

/* Columns of the extrapolation table: a step is divided into 1, 2, ... COLUMNS substeps. */
#define PDI_STIFF_ODE_COLUMNS 5
/* Most steps, and the least step as a fraction of the whole interval. */
#define PDI_STIFF_ODE_MAX_STEPS 5000
#define PDI_STIFF_ODE_MIN_STEP 1e-13
/* [-] Least first step as a fraction of the whole interval. */
#define PDI_STIFF_ODE_MIN_FIRST_STEP 1e-10
/* [-] A step that would leave less than this fraction of the remaining time is extended to the end. */
#define PDI_STIFF_ODE_MIN_REMAINDER 1e-6
/* [-] Step size control: safety factor, largest growth and strongest reduction of a step. */
#define PDI_STIFF_ODE_SAFETY 0.8
#define PDI_STIFF_ODE_GROWTH 8.0
#define PDI_STIFF_ODE_SHRINK 0.1
/* [-] Relative increment of the finite differences of the Jacobian. */
#define PDI_STIFF_ODE_INCREMENT 1e-7

typedef double pdi_stiff_ode_matrix[PD_STIFF_ODE_MAX_EQUATIONS][PD_STIFF_ODE_MAX_EQUATIONS];

/* State of the integration. */
typedef struct pdi_stiff_ode_state {
    const pd_stiff_ode *system;
    int fixed[PD_STIFF_ODE_MAX_EQUATIONS]; /* 1: the component is fixed at a bound, its rate points outwards */
    pdi_stiff_ode_matrix jacobian; /* [1/s] Jacobian df/dy */
    int bad_rate;                  /* equation whose rate is not finite; -1: none */
} pdi_stiff_ode_state;

/* Component y clipped to its bounds. */
static double pdi_stiff_ode_clip(const pd_stiff_ode *s, int k, double y)
{
    return pd_min(pd_max(y, s->low[k]), s->high[k]);
}

/* Evaluate the rates at y clipped to its bounds; 0 for components fixed at a bound. Sets bad_rate, where it is -1, to
 * the first component whose rate is not below 1e100 in size. */
static void pdi_stiff_ode_compute_rates(pdi_stiff_ode_state *w, double t, const double *y, double *rate)
{
    const pd_stiff_ode *s = w->system;
    double x[PD_STIFF_ODE_MAX_EQUATIONS];
    for (int k = 0; k < s->count; k++) x[k] = pdi_stiff_ode_clip(s, k, y[k]);
    s->rate(s->user, t, x, rate);
    for (int k = 0; k < s->count; k++) {
        if (!(fabs(rate[k]) < 1e100) && w->bad_rate < 0) w->bad_rate = k;
        if (w->fixed[k]) rate[k] = 0.0;
    }
}

/* Set `fixed` of the components that are at a bound with a rate that points outwards, and clear it for the others. */
static void pdi_stiff_ode_mark_fixed(pdi_stiff_ode_state *w, double t, const double *y)
{
    const pd_stiff_ode *s = w->system;
    double rate[PD_STIFF_ODE_MAX_EQUATIONS];
    memset(w->fixed, 0, sizeof w->fixed);
    pdi_stiff_ode_compute_rates(w, t, y, rate);
    for (int k = 0; k < s->count; k++)
        w->fixed[k] = (y[k] >= s->high[k] && rate[k] > 0.0) || (y[k] <= s->low[k] && rate[k] < 0.0);
}

/* Set the Jacobian of the rates by one-sided finite differences, upwards, or downwards where that would pass the high
 * bound; rows and columns of fixed components are 0. The increment is 1e-7 of the larger of |y| and the typical value,
 * or 1e-7 where both are 0. */
static void pdi_stiff_ode_compute_jacobian(pdi_stiff_ode_state *w, double t, const double *y)
{
    const pd_stiff_ode *s = w->system;
    double x[PD_STIFF_ODE_MAX_EQUATIONS], at[PD_STIFF_ODE_MAX_EQUATIONS], moved[PD_STIFF_ODE_MAX_EQUATIONS];
    memcpy(x, y, sizeof x);
    pdi_stiff_ode_compute_rates(w, t, x, at);
    for (int j = 0; j < s->count; j++) {
        double stride = PDI_STIFF_ODE_INCREMENT * pd_max(fabs(y[j]), s->typical[j]);
        if (!(stride > 0.0)) stride = PDI_STIFF_ODE_INCREMENT;
        x[j] = y[j] + stride > s->high[j] ? y[j] - stride : y[j] + stride;
        pdi_stiff_ode_compute_rates(w, t, x, moved);
        for (int k = 0; k < s->count; k++) w->jacobian[k][j] = w->fixed[j] ? 0.0 : (moved[k] - at[k]) / (x[j] - y[j]);
        x[j] = y[j];
    }
}

/* LU factorisation of I - h J into a with partial pivoting; row [count]: the row exchanged with row p. 1: done; 0:
 * singular: a pivot is 0 or not finite. */
static int pdi_stiff_ode_lu_factor(const pdi_stiff_ode_state *w, double h, pdi_stiff_ode_matrix a, int *row)
{
    int n = w->system->count;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) a[i][j] = (i == j ? 1.0 : 0.0) - h * w->jacobian[i][j];
    for (int p = 0; p < n; p++) {
        row[p] = p;
        for (int i = p + 1; i < n; i++)
            if (fabs(a[i][p]) > fabs(a[row[p]][p])) row[p] = i;
        for (int j = 0; j < n && row[p] != p; j++) {
            double swap = a[p][j];
            a[p][j] = a[row[p]][j];
            a[row[p]][j] = swap;
        }
        if (!(fabs(a[p][p]) > 0.0) || !(fabs(a[p][p]) < HUGE_VAL)) return 0;
        for (int i = p + 1; i < n; i++) {
            a[i][p] /= a[p][p];
            for (int j = p + 1; j < n; j++) a[i][j] -= a[i][p] * a[p][j];
        }
    }
    return 1;
}

/* Solve with these LU factors, x [n] in place: the right-hand side goes in. */
static void pdi_stiff_ode_lu_solve(int n, pdi_stiff_ode_matrix a, const int *row, double *x)
{
    for (int p = 0; p < n; p++) {
        double swap = x[p];
        x[p] = x[row[p]];
        x[row[p]] = swap;
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) x[i] -= a[i][j] * x[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) x[i] -= a[i][j] * x[j];
        x[i] /= a[i][i];
    }
}

/* `parts` linearly implicit Euler substeps over h [s] from y to `end`, both of PD_STIFF_ODE_MAX_EQUATIONS values, with
 * the stored Jacobian and the rates at the end of each substep. 1: done; 0: the matrix is singular, `end` is y. */
static int pdi_stiff_ode_euler_substeps(pdi_stiff_ode_state *w, double t, double h, int parts, const double *y,
                                        double *end)
{
    int n = w->system->count, row[PD_STIFF_ODE_MAX_EQUATIONS];
    double part = h / parts, x[PD_STIFF_ODE_MAX_EQUATIONS];
    pdi_stiff_ode_matrix a;
    memcpy(end, y, PD_STIFF_ODE_MAX_EQUATIONS * sizeof *end);
    if (!pdi_stiff_ode_lu_factor(w, part, a, row)) return 0;
    for (int i = 1; i <= parts; i++) {
        pdi_stiff_ode_compute_rates(w, t + i * part, end, x);
        for (int k = 0; k < n; k++) x[k] *= part;
        pdi_stiff_ode_lu_solve(n, a, row, x);
        for (int k = 0; k < n; k++) end[k] += x[k];
    }
    return 1;
}

/* One extrapolated step of h [s] from y to `end`. Returns the largest error over its tolerance: the difference of the
 * last two columns over `tolerance` times the largest of both |y| and the typical value. HUGE_VAL: no result: a
 * singular matrix, or a difference that is not below 1e100. */
static double pdi_stiff_ode_step(pdi_stiff_ode_state *w, double t, double h, const double *y, double *end)
{
    const pd_stiff_ode *s = w->system;
    double table[PDI_STIFF_ODE_COLUMNS][PDI_STIFF_ODE_COLUMNS][PD_STIFF_ODE_MAX_EQUATIONS], worst = 0.0;
    int last = PDI_STIFF_ODE_COLUMNS - 1;
    for (int j = 0; j <= last; j++) {
        if (!pdi_stiff_ode_euler_substeps(w, t, h, j + 1, y, table[j][0])) return HUGE_VAL;
        for (int c = 1; c <= j; c++)
            for (int k = 0; k < s->count; k++)
                table[j][c][k] = table[j][c - 1][k] + (table[j][c - 1][k] - table[j - 1][c - 1][k]) /
                                                      ((j + 1.0) / (j + 1.0 - c) - 1.0);
    }
    for (int k = 0; k < s->count; k++) {
        double off = fabs(table[last][last][k] - table[last][last - 1][k]);
        double size = pd_max(pd_max(fabs(y[k]), fabs(table[last][last][k])), s->typical[k]);
        end[k] = table[last][last][k];
        if (!(off < 1e100)) return HUGE_VAL;
        if (off > 0.0) worst = pd_max(worst, off / (size * s->tolerance));
    }
    return worst;
}

/* Fraction of the step, at least PDI_STIFF_ODE_SHRINK, after which the first component reaches a bound; 1: none does.
 * Components of `end` that are beyond a bound, and within the tolerance of it before or after the step, are set to
 * it. */
static double pdi_stiff_ode_bound_fraction(const pd_stiff_ode *s, const double *y, double *end)
{
    double share = 1.0;
    for (int k = 0; k < s->count; k++) {
        double bound = pdi_stiff_ode_clip(s, k, end[k]), out = fabs(end[k] - bound);
        double near_ = s->tolerance * pd_max(pd_max(fabs(bound), fabs(y[k])), s->typical[k]);
        if (!(out > 0.0)) continue;
        if (out <= near_ || fabs(bound - y[k]) <= near_) end[k] = bound;
        else share = pd_min(share, pd_max((bound - y[k]) / (end[k] - y[k]), PDI_STIFF_ODE_SHRINK));
    }
    return share;
}

/* 1: a component that was fixed at a bound in a step of h [s] would leave it by more than the tolerance: its rate
 * points inwards at the end. */
static int pdi_stiff_ode_has_left_bound(const pdi_stiff_ode_state *w, double t, double h, const double *end)
{
    const pd_stiff_ode *s = w->system;
    pdi_stiff_ode_state loose = *w;
    double rate[PD_STIFF_ODE_MAX_EQUATIONS];
    int any = 0;
    for (int k = 0; k < s->count; k++) any |= w->fixed[k];
    if (!any) return 0;
    memset(loose.fixed, 0, sizeof loose.fixed);
    pdi_stiff_ode_compute_rates(&loose, t + h, end, rate);
    for (int k = 0; k < s->count; k++) {
        double out = end[k] >= s->high[k] ? rate[k] : -rate[k];
        if (w->fixed[k] && -out * h > s->tolerance * pd_max(fabs(end[k]), s->typical[k])) return 1;
    }
    return 0;
}

/* First step [s], at most `whole` and at least PDI_STIFF_ODE_MIN_FIRST_STEP of it: no component changes by more than
 * the larger of |y| and its typical value at the present rates. Sets `fixed`. In a far too long step all columns of the
 * table are damped to zero, and their differences wrongly show no error. */
static double pdi_stiff_ode_estimate_first_step(pdi_stiff_ode_state *w, double t, double whole, const double *y)
{
    const pd_stiff_ode *s = w->system;
    double rate[PD_STIFF_ODE_MAX_EQUATIONS], h = whole;
    pdi_stiff_ode_mark_fixed(w, t, y);
    pdi_stiff_ode_compute_rates(w, t, y, rate);
    for (int k = 0; k < s->count; k++) {
        double size = pd_max(fabs(y[k]), s->typical[k]);
        if (fabs(rate[k]) * h > size && size > 0.0) h = size / fabs(rate[k]);
    }
    return pd_max(h, PDI_STIFF_ODE_MIN_FIRST_STEP * whole);
}

PDI_FN pd_stiff_ode_status pdi_stiff_ode_solve(const pd_stiff_ode *s, double from, double to, double *y, int *which)
{
    pdi_stiff_ode_state w;
    double t = from, h = to - from, end[PD_STIFF_ODE_MAX_EQUATIONS];
    memset(&w, 0, sizeof w);
    w.system = s;
    w.bad_rate = -1;
    if (h > 0.0) h = pdi_stiff_ode_estimate_first_step(&w, t, h, y);
    for (int step = 0; step < PDI_STIFF_ODE_MAX_STEPS && t < to; step++) {
        int last = !(h < (to - t) * (1.0 - PDI_STIFF_ODE_MIN_REMAINDER));
        if (last) h = to - t;
        if (!(h > PDI_STIFF_ODE_MIN_STEP * (to - from))) return PD_STIFF_ODE_UNDERFLOW;
        pdi_stiff_ode_mark_fixed(&w, t, y);
        pdi_stiff_ode_compute_jacobian(&w, t, y);
        if (w.bad_rate >= 0) break;
        double error = pdi_stiff_ode_step(&w, t, h, y, end),
               share = error <= 1.0 ? pdi_stiff_ode_bound_fraction(s, y, end) : 1.0;
        if (error <= 1.0 && share >= 1.0 && pdi_stiff_ode_has_left_bound(&w, t, h, end)) share = 0.5;
        double factor = PDI_STIFF_ODE_SAFETY * pow(pd_max(error, 1e-10), -1.0 / PDI_STIFF_ODE_COLUMNS);
        factor = pd_min(pd_max(factor, PDI_STIFF_ODE_SHRINK), PDI_STIFF_ODE_GROWTH);
        if (w.bad_rate >= 0 && h <= 2.0 * PDI_STIFF_ODE_MIN_STEP * (to - from)) break;
        if (w.bad_rate >= 0) {
            w.bad_rate = -1;
            h *= PDI_STIFF_ODE_SHRINK;
            continue;
        }
        if (error <= 1.0 && share >= 1.0) {
            memcpy(y, end, (size_t)s->count * sizeof *y);
            t = last ? to : t + h;
        }
        h *= error <= 1.0 && share < 1.0 ? share : error <= 1.0 ? pd_max(factor, 1.0) : pd_min(factor, 0.5);
    }
    if (w.bad_rate >= 0) {
        *which = w.bad_rate;
        return PD_STIFF_ODE_NOT_FINITE;
    }
    return t < to ? PD_STIFF_ODE_UNDERFLOW : PD_STIFF_ODE_DONE;
}

#undef PDI_STIFF_ODE_COLUMNS
#undef PDI_STIFF_ODE_MAX_STEPS
#undef PDI_STIFF_ODE_MIN_STEP
#undef PDI_STIFF_ODE_MIN_FIRST_STEP
#undef PDI_STIFF_ODE_MIN_REMAINDER
#undef PDI_STIFF_ODE_SAFETY
#undef PDI_STIFF_ODE_GROWTH
#undef PDI_STIFF_ODE_SHRINK
#undef PDI_STIFF_ODE_INCREMENT
