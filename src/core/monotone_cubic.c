/* monotone_cubic: see monotone_cubic.h */
#include "core/monotone_cubic.h"
#include <math.h>
#include <string.h>

#define PDI_MONOTONE_CUBIC_MAX_VALUE 1e150 /* limit of |x|, |y| and secants: products of slopes stay finite */
#define PDI_MONOTONE_CUBIC_MARGIN 1e-5     /* [-] of the range of x: how far outside `strict` still allows */

PDI_COLD_BEGIN
const char *pd_monotone_cubic_check_point(const double *x, const double *y, int k)
{
    if (!(fabs(x[k]) < PDI_MONOTONE_CUBIC_MAX_VALUE) || !(fabs(y[k]) < PDI_MONOTONE_CUBIC_MAX_VALUE))
        return "expected finite values";
    if (k == 0) return NULL;
    if (!(x[k] > x[k - 1])) return "expected ascending values";
    if (!(fabs((y[k] - y[k - 1]) / (x[k] - x[k - 1])) < PDI_MONOTONE_CUBIC_MAX_VALUE)) return "expected a finite slope";
    return NULL;
}

/* Limit a slope to three times the smaller of the secants a and b; 0 where the three differ in sign
 * (Fritsch-Carlson). */
static double pdi_monotone_cubic_limit_slope(double slope, double a, double b)
{
    double sign = a > 0.0 ? 1.0 : -1.0, least = pd_min(sign * a, sign * b);
    if (!(least > 0.0) || !(sign * slope > 0.0)) return 0.0;
    return sign * pd_min(sign * slope, 3.0 * least);
}

/* Slope at an end point, not yet limited: of the parabola through it and the next two. Spacings and secants go from the
 * end inwards. */
static double pdi_monotone_cubic_end_slope(double step, double next_step, double secant, double next_secant)
{
    return secant + (secant - next_secant) * (step / (step + next_step));
}

PDI_FN void pdi_monotone_cubic_compute_slopes(const double *x, const double *y, int count, double *slope)
{
    int last = count - 1;
    double first = (y[1] - y[0]) / (x[1] - x[0]), before = first;
    if (last == 1) {
        slope[0] = slope[1] = first;
        return;
    }
    for (int k = 1; k < last; k++) {
        double left = x[k] - x[k - 1], right = x[k + 1] - x[k], after = (y[k + 1] - y[k]) / right;
        double parabola = before + (after - before) * (left / (left + right));
        if (k == 1)
            slope[0] = pdi_monotone_cubic_limit_slope(pdi_monotone_cubic_end_slope(left, right, before, after), before,
                                                      before);
        if (k == last - 1)
            slope[last] =
                pdi_monotone_cubic_limit_slope(pdi_monotone_cubic_end_slope(right, left, after, before), after, after);
        slope[k] = pdi_monotone_cubic_limit_slope(parabola, before, after);
        before = after;
    }
}

pd_status pd_monotone_cubic_build(pd_ctx *ctx, const double *x, const double *y, int count, int strict,
                                          pd_monotone_cubic *c)
{
    memset(c, 0, sizeof *c);
    if (count < 2) return pd_fail(ctx, PD_ERR_ARGUMENT, "curve", "found %d point%s, expected at least 2", count,
                                  count == 1 ? "" : "s");
    for (int k = 0; k < count; k++) {
        const char *wrong = pd_monotone_cubic_check_point(x, y, k);
        if (wrong)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "curve", "point %d: found x = %g, y = %g, %s", k, x[k], y[k], wrong);
    }
    c->count = count;
    c->nan_outside = strict;
    pd_status status = PD_NEW(ctx, "curve", count, c->x);
    if (status == PD_OK) status = PD_NEW(ctx, "curve", count, c->y);
    if (status == PD_OK) status = PD_NEW(ctx, "curve", count, c->slope);
    if (status < 0) {
        pdi_monotone_cubic_free(ctx, c);
        return status;
    }
    memcpy(c->x, x, (size_t)count * sizeof *x);
    memcpy(c->y, y, (size_t)count * sizeof *y);
    pdi_monotone_cubic_compute_slopes(c->x, c->y, count, c->slope);
    return PD_OK;
}

PDI_FN void pdi_monotone_cubic_free(pd_ctx *ctx, pd_monotone_cubic *c)
{
    PD_DELETE(ctx, c->count, c->x);
    PD_DELETE(ctx, c->count, c->y);
    PD_DELETE(ctx, c->count, c->slope);
    memset(c, 0, sizeof *c);
}
PDI_COLD_END

PDI_FN double pdi_monotone_cubic_interpolate(const double *x, const double *y, const double *slopes, int count,
                                             double at, double *slope)
{
    int low = 0, high = count - 1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (x[middle] <= at) low = middle;
        else high = middle;
    }
    double step = x[high] - x[low], far = at - x[low], t = far / step;
    double secant = (y[high] - y[low]) / step, a = slopes[low], b = slopes[high];
    double line = 3.0 * secant - 2.0 * a - b, bend = a + b - 2.0 * secant, up = y[high] > y[low] ? 1.0 : -1.0;
    /* rounding must not break monotonicity */
    *slope = up * pd_max(up * (a + t * (2.0 * line + 3.0 * t * bend)), 0.0);
    double value = y[low] + far * (a + t * (line + t * bend));
    return pd_min(pd_max(value, pd_min(y[low], y[high])), pd_max(y[low], y[high]));
}

PDI_FN double pdi_monotone_cubic_evaluate(const pd_monotone_cubic *c, double x)
{
    int high = c->count - 1;
    double slope;
    if (high < 1 || x != x) return (double)NAN;
    double beyond = PDI_MONOTONE_CUBIC_MARGIN * (c->x[high] - c->x[0]);
    if (c->nan_outside && (x < c->x[0] - beyond || x > c->x[high] + beyond)) return (double)NAN;
    if (x <= c->x[0]) return c->y[0];
    if (x >= c->x[high]) return c->y[high];
    return pdi_monotone_cubic_interpolate(c->x, c->y, c->slope, c->count, x, &slope);
}

#undef PDI_MONOTONE_CUBIC_MAX_VALUE
#undef PDI_MONOTONE_CUBIC_MARGIN
