/* time_quadrature: adaptive integration in time: is two-point Gauss quadrature accurate over an interval of a step, for
 * a rate that may jump or pulse?
 *
 * An interval is accepted where two-point Gauss quadrature, Simpson's rule and Gauss quadrature over both halves agree,
 * and where interval bounds of the function exclude peaks between the quadrature points and become narrower with the
 * interval (theory: 10.12). Bounds come from interval arithmetic (Moore, Kearfott and Cloud, Introduction to Interval
 * Analysis, SIAM 2009).
 */
#ifndef PD_TIME_QUADRATURE_H
#define PD_TIME_QUADRATURE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Value of the integrand at time t [s]. */
typedef double (*pdi_time_quadrature_value_fn)(void *user, double t);
/* Rigorous bounds of the integrand between the times `from` and `to` [s]. */
typedef void (*pdi_time_quadrature_bounds_fn)(void *user, double from, double to, double *least, double *most);

/* The integrand of a step, with its tolerance. */
typedef struct pdi_time_quadrature {
    pdi_time_quadrature_value_fn value;
    pdi_time_quadrature_bounds_fn bounds; /* NULL: judge by point values alone */
    void *user;
    double weight; /* weight: amount that the step removes for a value of 1 */
    double amount; /* the amount that is there, in the unit of share */
    double rtol;  /* [-] relative tolerance of the step */
} pdi_time_quadrature;

/* Verdict on an interval. */
typedef enum pdi_time_quadrature_verdict {
    PDI_TIME_QUADRATURE_SUBDIVIDE, /* not accurate: subdivide */
    PDI_TIME_QUADRATURE_ACCURATE,  /* accurate */
    PDI_TIME_QUADRATURE_JUMP       /* not accurate, but the amount removed there is negligible: a jump */
} pdi_time_quadrature_verdict;

/* Time [s] of the first (0) or second (1) point of two-point Gauss quadrature over [from, to]. */
PDI_FN double pdi_time_quadrature_gauss_point(double from, double to, int second);
/* Judge the interval [from, to], the fraction `part` [-] of the step. *mean: mean of the function over it by the
 * midpoint rule (middle = 1) or two-point Gauss quadrature (0). ACCURATE: weight times its difference from Simpson's
 * rule and from Gauss over both halves is at most rtol (0.1 removed + 1e-4 amount), and the bounds exclude peaks; also
 * where a value is not finite, an error that is reported elsewhere. JUMP: part below 1e-15, or part times weight times
 * the width of the bounds at most rtol 1e-4 amount. Else SUBDIVIDE. */
PDI_FN pdi_time_quadrature_verdict pdi_time_quadrature_check(const pdi_time_quadrature *q, double from, double to,
                                                             double part, int middle, double *mean);
#endif

#endif
