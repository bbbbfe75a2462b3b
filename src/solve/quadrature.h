/* quadrature: adaptive integration in time: is two-point Gauss quadrature accurate over an interval of a step, for a
 * rate that may jump or pulse?
 *
 * An interval is accepted where two-point Gauss quadrature, Simpson's rule and Gauss quadrature over both halves agree,
 * and where interval bounds of the function exclude peaks between the quadrature points and become narrower with the
 * interval (theory: 6.1). Bounds come from interval arithmetic (Moore, Kearfott and Cloud, Introduction to Interval
 * Analysis, SIAM 2009).
 */
#ifndef PD_QUADRATURE_H
#define PD_QUADRATURE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Value of the integrand at time t [s]. */
typedef double (*pdi_quadrature_value)(void *user, double t);
/* Rigorous bounds of the integrand between the times `from` and `to` [s]. */
typedef void (*pdi_quadrature_bounds)(void *user, double from, double to, double *least, double *most);

/* The integrand of a step, with its tolerance. */
typedef struct pdi_quadrature {
    pdi_quadrature_value value;
    pdi_quadrature_bounds bounds; /* NULL: judge by point values alone */
    void *user;
    double share; /* weight: amount that the step removes for a value of 1 */
    double size;  /* the amount that is there, in the unit of share */
    double rtol;  /* [-] relative tolerance of the step */
} pdi_quadrature;

/* Verdict on an interval. */
typedef enum pdi_quadrature_piece {
    PDI_QUADRATURE_DIVIDE, /* not accurate: subdivide */
    PDI_QUADRATURE_FITS,   /* accurate */
    PDI_QUADRATURE_JUMP /* not accurate, but the amount removed there is negligible: a jump */
} pdi_quadrature_piece;

/* The first (0) or second (1) point of two-point Gauss quadrature over [from, to]. */
PDI_FN double pdi_quadrature_instant(double from, double to, int second);
/* Judge the interval [from, to], which is the fraction `part` [-] of the step. *mean: mean of the function over it by
 * the rule to be judged: the midpoint rule (middle = 1) or two-point Gauss quadrature (0). */
PDI_FN pdi_quadrature_piece pdi_quadrature_judge(const pdi_quadrature *q, double from, double to, double part,
                                                 int middle, double *mean);
#endif

#endif
