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

/* Build the interpolant; x and y [count] are copied, and pdi_monotone_cubic_free frees them. strict 1: it has no values
 * outside the range of x (nan_outside). PD_ERR_ARGUMENT: fewer than two points, or one that
 * pd_monotone_cubic_check_point refuses. After any error the curve is zero. */
PD_API pd_status pd_monotone_cubic_build(pd_ctx *ctx, const double *x, const double *y, int count, int strict,
                                         pd_monotone_cubic *curve);
/* Check point k >= 0 after all points before it passed: NULL when valid, else the reason, "expected ...": |x|, |y| or
 * the secant from the point before is not below 1e150, or x is not above that of the point before. */
PD_API const char *pd_monotone_cubic_check_point(const double *x, const double *y, int k);
#ifdef PDI_INTERNAL
/* Compute the slopes [count] of the cubic pieces at valid data points x, y [count], count at least 2: of the parabola
 * through a point and its neighbours (at an end the next two), limited to three times the smaller secant, and 0 where
 * the secants or the parabola differ in sign. Two points: the secant. */
PDI_FN void pdi_monotone_cubic_compute_slopes(const double *x, const double *y, int count, double *slope);
/* Interpolated value at `at`, x[0] <= at <= x[count - 1], from the points x, y and the limited slopes [count], count at
 * least 2. It is clipped to the values at both ends of its piece. *slope: the derivative there, of the sign of the
 * secant or 0. */
PDI_FN double pdi_monotone_cubic_interpolate(const double *x, const double *y, const double *slopes, int count,
                                             double at, double *slope);

/* Interpolated value at x: exactly y at a data point, NaN for NaN and without points. Outside the range of x: y of the
 * end, or with nan_outside NaN beyond 1e-5 of the range, which finite differences at the ends need. Thread-safe. */
PDI_FN double pdi_monotone_cubic_evaluate(const pd_monotone_cubic *curve, double x);
/* Free the arrays and set the curve to zero. */
PDI_FN void pdi_monotone_cubic_free(pd_ctx *ctx, pd_monotone_cubic *curve);

#endif

#endif
