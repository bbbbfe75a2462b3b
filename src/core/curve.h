/* curve: a function of one variable through given points, as monotone as they are.
 *
 * Cubic Hermite pieces. The slope at an inner point is that of the parabola through it and its neighbours, cut to
 * three times the smaller of the two secants beside it, and zero where these differ in sign. With end slopes a s and
 * b s a piece of secant s has the derivative
 *     s (a (1-t)(1-3t) + b t (3t-2) + 6 t (1-t)),     0 <= t <= 1,
 * linear in a and b and 6t(1-t), 3(1-t)^2, 3t^2, 3(1-2t)^2 times s at the corners of 0 <= a, b <= 3: a piece never
 * turns, so extremes are points, and nothing overshoots. Third order where data are smooth and monotone, second order
 * beside an extreme.
 * Sources: de Boor and Swartz 1977 (the square), Fritsch and Carlson 1980.
 */
#ifndef PD_CURVE_H
#define PD_CURVE_H
#include "core/base.h"

typedef struct pd_curve {
    int count;      /* points */
    int strict;     /* 1: NaN outside of the points; 0: the end values hold there */
    double *x;      /* [count] [-] (unit of the caller) ascending */
    double *y;      /* [count] [-] (unit of the caller) */
    double *slope;  /* [count] [-] (unit of y over that of x) */
} pd_curve;

#ifdef PDI_INTERNAL
/* Slopes [count] at points that make a curve. */
PDI_FN void pdi_curve_slopes(const double *x, const double *y, int count, double *slope);
/* Value at an x from the first point to the last, of arrays [count] like those of a curve; *slope: the derivative. */
PDI_FN double pdi_curve_piece(const double *x, const double *y, const double *slopes, int count, double at,
                              double *slope);

/* Takes copies of x and y [count]. PD_ERR_ARGUMENT: fewer than two points, one that is not finite, x not ascending,
 * or a secant without a finite slope. */
PDI_FN pd_status pdi_curve_build(pd_ctx *ctx, const double *x, const double *y, int count, int strict, pd_curve *curve);
/* Value at x: y itself at a point. Reads only, so threads may share the curve. NaN of NaN. `strict` lets x pass the
 * ends by 1e-5 of the length, for difference quotients at them. */
PDI_FN double pdi_curve_eval(const pd_curve *curve, double x);
PDI_FN void pdi_curve_free(pd_ctx *ctx, pd_curve *curve);

/* Why the points up to k >= 0 make no curve, with those before it admissible: "expected ..."; NULL: they do. */
PDI_FN const char *pdi_curve_wrong(const double *x, const double *y, int k);
#endif

#endif
