/* least_squares: bounded least squares over a few parameters of a function that costs much and has noise: a run.
 *
 * Levenberg-Marquardt steps in parameters scaled to their bounds; derivatives are difference quotients whose step
 * weighs the noise of the function, measured first, against their curvature, and are carried on by secant updates
 * (Broyden) while steps succeed. The covariance of the result comes from quotients at the solution.
 */
#ifndef PD_LEAST_SQUARES_H
#define PD_LEAST_SQUARES_H
#include "core/base.h"

#define PD_LEAST_SQUARES_PARAMETERS 8 /* most parameters */

/* residual[points]: (function - data)/spread at value[parameters]. A failure ends the fit. */
typedef pd_status (*pd_least_squares_fn)(pd_ctx *ctx, void *user, const double *value, double *residual);

/* Zero-initialise. */
typedef struct pd_least_squares_desc {
    int parameters, points;
    double low[PD_LEAST_SQUARES_PARAMETERS], high[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    double start[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    int known;          /* 1: residuals are in units of a known spread; 0: it follows from them */
    double tolerance;   /* [-] steps end below this share of the standard errors; 0: 0.01 */
    double noise;       /* [-] of a residual, where it is known; 0: it is measured */
    pd_least_squares_fn fn;
    void *user;
    void (*report)(void *user, const double *value, double sum, int evaluations); /* called after a step; NULL: not */
} pd_least_squares_desc;

typedef struct pd_least_squares_result {
    double value[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    double error[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] standard; NaN on a bound or with too few points */
    double low[PD_LEAST_SQUARES_PARAMETERS];   /* [unit of caller] ends of the 95 % intervals */
    double high[PD_LEAST_SQUARES_PARAMETERS];  /* [unit of caller] */
    int bound[PD_LEAST_SQUARES_PARAMETERS]; /* -1, 1: the solution lies on the low, high bound and wants to pass it */
    double correlation[PD_LEAST_SQUARES_PARAMETERS][PD_LEAST_SQUARES_PARAMETERS]; /* [-] */
    double sum;                          /* [-] of the squared residuals */
    int freedom;                         /* points less parameters inside their bounds */
    double noise;                        /* [-] of a residual */
    int evaluations, steps;
    int converged;
    int idle;            /* parameter without effect, counted from 1, that ended the fit; 0: none */
} pd_least_squares_result;

#ifdef PDI_INTERNAL
/* PD_ERR_ARGUMENT: bounds, a start outside of them, fewer points than parameters, a parameter without effect.
 * PD_NOT_CONVERGED: no step lowers the sum any more, but the tolerance is not reached. Errors of fn. */
PDI_FN pd_status pdi_least_squares_solve(pd_ctx *ctx, const pd_least_squares_desc *desc,
                                         pd_least_squares_result *result);
/* Student's t that 97.5 % of the cases stay below; freedom 0: of the normal distribution. */
PDI_FN double pdi_least_squares_quantile(int freedom);
#endif

#endif
