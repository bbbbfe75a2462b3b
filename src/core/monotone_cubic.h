/* monotone_cubic: monotone cubic interpolation of a table (PCHIP): a function of one variable through given points that
 * is monotone where they are.
 *
 * Cubic Hermite pieces. The slope at an inner point is that of the parabola through it and its neighbours, limited to
 * three times the smaller of the two adjacent secants, and zero where these differ in sign. With end slopes a s and
 * b s a piece of secant s has the derivative
 *     s (a (1-t)(1-3t) + b t (3t-2) + 6 t (1-t)),     0 <= t <= 1,
 * linear in a and b and 6t(1-t), 3(1-t)^2, 3t^2, 3(1-2t)^2 times s at the corners of 0 <= a, b <= 3: a piece is
 * monotone, so extrema are data points, and nothing overshoots. Third order where data are smooth and monotone, second
 * order next to an extremum.
 * Sources: de Boor and Swartz 1977 (the square of admissible slopes), Fritsch and Carlson 1980.
 */
#ifndef PD_MONOTONE_CUBIC_H
#define PD_MONOTONE_CUBIC_H
#include "core/base.h"

typedef struct pd_monotone_cubic {
    int count;      /* points */
    int nan_outside; /* 1: NaN outside the range of x; 0: constant end values there */
    double *x;      /* [count] [-] (unit of the caller) ascending */
    double *y;      /* [count] [-] (unit of the caller) */
    double *slope;  /* [count] [-] (unit of y over that of x) */
} pd_monotone_cubic;

#define pd_monotone_cubic_build PD_NAME(pd_monotone_cubic_build)
#define pd_monotone_cubic_check_point PD_NAME(pd_monotone_cubic_check_point)

/* Build the interpolant; x and y [count] are copied. PD_ERR_ARGUMENT: fewer than two points, one that is not finite, x
 * not ascending, or a secant without a finite slope. */
PD_API pd_status pd_monotone_cubic_build(pd_ctx *ctx, const double *x, const double *y, int count, int strict,
                                         pd_monotone_cubic *curve);
/* Check point k >= 0 after all points before it passed: NULL when valid, else the reason, "expected ...". */
PD_API const char *pd_monotone_cubic_check_point(const double *x, const double *y, int k);
#ifdef PDI_INTERNAL
/* Compute the limited slopes [count] of the cubic pieces at valid data points x, y [count]. */
PDI_FN void pdi_monotone_cubic_compute_slopes(const double *x, const double *y, int count, double *slope);
/* Interpolated value at `at`, x[0] <= at <= x[count - 1], from arrays [count]; *slope: the derivative there. */
PDI_FN double pdi_monotone_cubic_interpolate(const double *x, const double *y, const double *slopes, int count,
                                             double at, double *slope);

/* Interpolated value at x: exactly y at a data point, NaN for NaN. Thread-safe. With `strict`, x may exceed the ends by
 * 1e-5 of the range, for finite differences at the ends. */
PDI_FN double pdi_monotone_cubic_evaluate(const pd_monotone_cubic *curve, double x);
PDI_FN void pdi_monotone_cubic_free(pd_ctx *ctx, pd_monotone_cubic *curve);

#endif

#endif
