/* electrode: see electrode.h */
#include "potential/electrode.h"
#include "core/monotone_cubic.h"
#include <math.h>
#include <string.h>

/* Exponentials go on straight beyond this exponent: no current comes near it, and none overflows. */
#define PDI_ELECTRODE_STEEP 300.0
/* [V] A resistance counts in the size of currents at this overpotential. */
#define PDI_ELECTRODE_SMALL 0.025
/* Most steps to the overpotential behind a resistance. */
#define PDI_ELECTRODE_STEPS 300
/* [V] First stride to the side of it that is not known. */
#define PDI_ELECTRODE_STRIDE 0.1

static void pdi_electrode_list(pdi_array_visitor *owner, void *object)
{
    pd_electrode *electrode = (pd_electrode *)object;
    PDI_ARRAY(owner, electrode, term, electrode->count, "");
    PDI_ARRAY(owner, electrode, potential, electrode->points, "V");
    PDI_ARRAY(owner, electrode, current, electrode->points, "A/m2");
    PDI_ARRAY(owner, electrode, slope, electrode->points, "S/m2");
}

/* x exp(z), straight on where it is steep, and its derivative by z. */
static double pdi_electrode_exp(double x, double z, double *by)
{
    double steep = pd_min(z, PDI_ELECTRODE_STEEP);
    *by = x * exp(steep);
    return *by * (1.0 + (z - steep));
}

/* One branch, with its limit. */
static double pdi_electrode_branch(double exchange, double fold, double limit, double u, double *slope)
{
    double by, i = pdi_electrode_exp(exchange, u / fold, &by);
    *slope = by / fold;
    if (!(limit > 0.0)) return i;
    double part = 1.0 / (1.0 + i / limit);
    *slope *= part * part;
    return limit / (1.0 + limit / i);
}

static double pdi_electrode_table(const pd_electrode *e, const pd_electrode_term *t, double u, double *slope)
{
    const double *x = t->potential, *y = t->current, *m = e->slope + (x - e->potential);
    int last = t->points - 1;
    if (u <= x[0] || u >= x[last]) {
        int end = u <= x[0] ? 0 : last;
        *slope = m[end];
        return y[end] + m[end] * (u - x[end]);
    }
    return pdi_monotone_cubic_interpolate(x, y, m, t->points, u, slope);
}

static double pdi_electrode_term_current(const pd_electrode *e, const pd_electrode_term *t, double u, double *slope)
{
    double i = 0.0, part;
    *slope = 0.0;
    if (t->kind == PD_ELECTRODE_TABLE) return pdi_electrode_table(e, t, u, slope);
    u -= t->equilibrium;
    if (t->kind == PD_ELECTRODE_LINEAR) {
        *slope = 1.0 / t->resistance;
        return u / t->resistance;
    }
    if (t->anodic > 0.0) i += pdi_electrode_branch(t->exchange, t->anodic, t->anodic_limit, u, slope);
    if (t->cathodic > 0.0) {
        i -= pdi_electrode_branch(t->exchange, t->cathodic, t->cathodic_limit, -u, &part);
        *slope += part;
    }
    return i;
}

double pd_electrode_current(const pd_electrode *e, double u, double *slope)
{
    double i = 0.0, sum = 0.0, part;
    for (int k = 0; k < e->count; k++) {
        i += pdi_electrode_term_current(e, &e->term[k], u, &part);
        sum += part;
    }
    if (slope) *slope = sum;
    return i;
}

/* Where a bracket [lo, hi] of the solution has no lower or no upper end yet, a stride beyond the other one. */
static double pdi_electrode_inside(double lo, double hi, double *stride)
{
    if (lo > -HUGE_VAL && hi < HUGE_VAL) return 0.5 * (lo + hi);
    *stride *= 2.0;
    return lo > -HUGE_VAL ? lo + *stride : hi - *stride;
}

/* u + R i(u) = drop. Newton's method for asinh i(u) = asinh((drop - u)/R) knows both an exponential and a straight line
 * as nearly straight. A bracket holds it. */
static double pdi_electrode_solve(const pd_electrode *e, double drop, double resist, double u)
{
    double lo = -HUGE_VAL, hi = HUGE_VAL, stride = 0.5 * PDI_ELECTRODE_STRIDE, scale = e->scale, last = HUGE_VAL;
    for (int step = 0; step < PDI_ELECTRODE_STEPS; step++) {
        double slope, i = pd_electrode_current(e, u, &slope), line = (drop - u) / resist;
        if (i > line) hi = u;
        else if (i < line) lo = u;
        else return u;
        double by = slope / hypot(scale, i) + 1.0 / (resist * hypot(scale, line));
        double next = u - (asinh(i / scale) - asinh(line / scale)) / by;
        if (!(next > lo) || !(next < hi) || (step % 8 == 7 && fabs(next - u) > 0.5 * last))
            next = pdi_electrode_inside(lo, hi, &stride);
        last = fabs(next - u);
        if (!(last > 0.5 * DBL_EPSILON * pd_max(fabs(u), fabs(drop)))) return next;
        u = next;
    }
    return u;
}

PDI_FN double pdi_electrode_through(const pd_electrode *e, double share, double drop, double resist, double *u,
                                    double *slope)
{
    resist += e->desc.film;
    if (!(share > 0.0)) {
        *u = drop;
        *slope = 0.0;
        return 0.0;
    }
    if (e->count == 0) {
        *u = e->desc.equilibrium;
        *slope = 1.0 / resist;
        return (drop - *u) / resist;
    }
    *u = pdi_electrode_solve(e, drop, share * resist, *u);
    double by, i = share * pd_electrode_current(e, *u, &by);
    by *= share;
    *slope = by / (1.0 + resist * by);
    return resist * by > 1.0 ? (drop - *u) / resist : i; /* the one with more digits */
}

PDI_FN void pdi_electrode_range(const pd_electrode *e, double *least, double *most)
{
    *least = *most = 0.0;
    if (e->count == 0) {
        *least = -HUGE_VAL;
        *most = HUGE_VAL;
    }
    for (int k = 0; k < e->count; k++) {
        const pd_electrode_term *t = &e->term[k];
        const double *slope = e->slope + (t->potential ? t->potential - e->potential : 0);
        int last = t->points - 1;
        if (t->kind == PD_ELECTRODE_BUTLER_VOLMER) {
            if (t->anodic > 0.0) *most += t->anodic_limit > 0.0 ? t->anodic_limit : HUGE_VAL;
            if (t->cathodic > 0.0) *least -= t->cathodic_limit > 0.0 ? t->cathodic_limit : HUGE_VAL;
        } else if (t->kind == PD_ELECTRODE_LINEAR) {
            *least -= HUGE_VAL;
            *most += HUGE_VAL;
        } else {
            *least += slope[0] > 0.0 ? -HUGE_VAL : t->current[0];
            *most += slope[last] > 0.0 ? HUGE_VAL : t->current[last];
        }
    }
}

/* ---- building ---- */

static int pdi_electrode_positive(double x) { return x > 0.0 && x < 1e100; }
static int pdi_electrode_least_zero(double x) { return x >= 0.0 && x < 1e100; }

static pd_status pdi_electrode_check_table(pd_ctx *ctx, int k, const pd_electrode_term *t)
{
    if (t->points < 2 || !t->potential || !t->current)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: a table of %d points, expected at least 2", k,
                       t->points);
    for (int p = 0; p < t->points; p++)
        if (!(fabs(t->potential[p]) < 1e100) || !(fabs(t->current[p]) < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: point %d of the table is (%g V, %g A/m2), "
                           "expected finite numbers", k, p, t->potential[p], t->current[p]);
    for (int p = 1; p < t->points; p++) {
        if (!(t->potential[p] > t->potential[p - 1]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: the potentials %g and %g V of points %d and "
                           "%d do not ascend", k, t->potential[p - 1], t->potential[p], p - 1, p);
        if (t->current[p] < t->current[p - 1])
            return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: the current falls from %g to %g A/m2 between "
                           "%g and %g V, so a field would have several solutions; expected a curve that rises or "
                           "stays (cathodic currents are negative)", k, t->current[p - 1], t->current[p],
                           t->potential[p - 1], t->potential[p]);
    }
    return PD_OK;
}

static pd_status pdi_electrode_check(pd_ctx *ctx, int k, const pd_electrode_term *t)
{
    if (t->kind == PD_ELECTRODE_TABLE) return pdi_electrode_check_table(ctx, k, t);
    if (t->kind != PD_ELECTRODE_LINEAR && t->kind != PD_ELECTRODE_BUTLER_VOLMER)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: there is no kind %d", k, (int)t->kind);
    if (!(fabs(t->equilibrium) < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: equilibrium at %g V, expected a finite number", k,
                       t->equilibrium);
    if (t->kind == PD_ELECTRODE_LINEAR) {
        if (pdi_electrode_positive(t->resistance)) return PD_OK;
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: resistance %g m2/S, expected a positive number",
                       k, t->resistance);
    }
    if (!pdi_electrode_positive(t->exchange) || !pdi_electrode_least_zero(t->anodic) ||
        !pdi_electrode_least_zero(t->cathodic) || !(t->anodic + t->cathodic > 0.0) ||
        !pdi_electrode_least_zero(t->anodic_limit) || !pdi_electrode_least_zero(t->cathodic_limit))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "term %d: exchange %g A/m2, anodic %g V, cathodic %g V, "
                       "limits %g and %g A/m2: expected a positive exchange current, and at least one branch", k,
                       t->exchange, t->anodic, t->cathodic, t->anodic_limit, t->cathodic_limit);
    return PD_OK;
}

/* Slopes at the points of a table; at the ends those of the last intervals, so that it goes on straight. */
static void pdi_electrode_slopes(const pd_electrode_term *t, double *slope)
{
    const double *x = t->potential, *y = t->current;
    int last = t->points - 1;
    pdi_monotone_cubic_compute_slopes(x, y, t->points, slope);
    slope[0] = (y[1] - y[0]) / (x[1] - x[0]);
    slope[last] = (y[last] - y[last - 1]) / (x[last] - x[last - 1]);
}

static void pdi_electrode_fill(const pd_electrode_desc *desc, pd_electrode *e)
{
    int at = 0;
    for (int k = 0; k < e->count; k++) {
        pd_electrode_term *t = &e->term[k];
        *t = desc->term[k];
        if (t->kind == PD_ELECTRODE_BUTLER_VOLMER) e->scale = pd_max(e->scale, t->exchange);
        if (t->kind == PD_ELECTRODE_LINEAR) e->scale = pd_max(e->scale, PDI_ELECTRODE_SMALL / t->resistance);
        if (t->kind != PD_ELECTRODE_TABLE) {
            t->points = 0;
            t->potential = t->current = NULL;
            continue;
        }
        for (int p = 0; p < t->points; p++) {
            e->potential[at + p] = t->potential[p];
            e->current[at + p] = t->current[p];
            e->scale = pd_max(e->scale, PDI_ELECTRODE_SMALL * fabs(t->current[p]));
        }
        t->potential = e->potential + at;
        t->current = e->current + at;
        pdi_electrode_slopes(t, e->slope + at);
        at += t->points;
    }
    if (!(e->scale > 0.0)) e->scale = 1.0; /* a table of zeros */
}

pd_status pd_electrode_build(pd_ctx *ctx, const pd_electrode_desc *desc, pd_electrode *e)
{
    pd_electrode_desc given = *desc;
    memset(e, 0, sizeof *e);
    if (given.count < 0 || (given.count > 0 && !given.term) || !pdi_electrode_least_zero(given.film) ||
        !(fabs(given.equilibrium) < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrode", "%d terms, equilibrium %g V, film %g m2/S: expected "
                       "terms, and finite numbers of at least 0", given.count, given.equilibrium, given.film);
    int64_t points = 0;
    for (int k = 0; k < given.count; k++) {
        PD_TRY(pdi_electrode_check(ctx, k, &given.term[k]));
        if (given.term[k].kind == PD_ELECTRODE_TABLE) points += given.term[k].points;
    }
    if (points > INT32_MAX) return pd_fail(ctx, PD_ERR_SIZE, "electrode", "tables of more than 2^31 points");
    e->count = given.count;
    e->points = (int)points;
    pd_status status = pdi_array_registry_build(ctx, pdi_electrode_list, e);
    if (status < 0) {
        memset(e, 0, sizeof *e);
        return status;
    }
    e->desc = given;
    pdi_electrode_fill(&given, e);
    e->desc.term = e->term;
    return PD_OK;
}

void pd_electrode_free(pd_ctx *ctx, pd_electrode *e)
{
    pdi_array_registry_free(ctx, pdi_electrode_list, e);
    memset(e, 0, sizeof *e);
}
