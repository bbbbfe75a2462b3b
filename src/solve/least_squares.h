/* least_squares: bounded nonlinear least squares for a few parameters of an expensive function with numerical noise,
 * such as a simulation.
 *
 * Levenberg-Marquardt steps in parameters scaled to their bounds. The Jacobian comes from finite differences whose
 * increment balances the measured noise of the function against the truncation error, and from Broyden updates while
 * steps succeed. The covariance of the result comes from finite differences at the solution.
 */
#ifndef PD_LEAST_SQUARES_H
#define PD_LEAST_SQUARES_H
#include "core/base.h"

#define PD_LEAST_SQUARES_PARAMETERS 8 /* most parameters */

/* The function: residual[points] = (function - data) / standard deviation at value[parameters]. A failure ends the
 * fit. */
typedef pd_status (*pd_least_squares_fn)(pd_ctx *ctx, void *user, const double *value, double *residual);

/* Zero-initialise. */
typedef struct pd_least_squares_desc {
    int parameters, points;
    double low[PD_LEAST_SQUARES_PARAMETERS], high[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    double start[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    /* 1: residuals are scaled by known standard deviations; 0: these are estimated from the fit */
    int known_deviation;
    double tolerance;   /* [-] converged when a step is below this fraction of the standard errors; 0: 0.01 */
    double noise;       /* [-] standard deviation of the numerical noise of a residual; 0: it is measured */
    pd_least_squares_fn fn;
    void *user;
    void (*report)(void *user, const double *value, double sum, int evaluations); /* progress, after each step; NULL:
                                                                                   * none */
} pd_least_squares_desc;

typedef struct pd_least_squares_result {
    double value[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] */
    double standard_error[PD_LEAST_SQUARES_PARAMETERS]; /* [unit of caller] standard error; NaN on a bound or with too
                                                         * few points */
    double low[PD_LEAST_SQUARES_PARAMETERS];   /* [unit of caller] ends of the 95 % intervals */
    double high[PD_LEAST_SQUARES_PARAMETERS];  /* [unit of caller] */
    int active_bound[PD_LEAST_SQUARES_PARAMETERS]; /* -1, 1: the low, high bound is active */
    double correlation[PD_LEAST_SQUARES_PARAMETERS][PD_LEAST_SQUARES_PARAMETERS]; /* [-] */
    double sum;                          /* [-] sum of the squared residuals */
    int degrees_of_freedom;              /* degrees of freedom: points less parameters inside their bounds */
    double noise;                        /* [-] numerical noise of a residual */
    int evaluations, steps;
    int converged;
    int ineffective; /* number, from 1, of a parameter without effect that ended the fit; 0: none */
} pd_least_squares_result;

#define pd_least_squares_solve PD_NAME(pd_least_squares_solve)

/* Minimise the sum of squared residuals within the bounds. Converged: a step is below the tolerance times the standard
 * errors, up to noise, with a fresh Jacobian. PD_ERR_ARGUMENT: number of parameters, bounds, a start outside of them,
 * tolerance or noise negative or not finite, fewer points than parameters, a parameter without effect, or parameters
 * that the points do not distinguish. PD_ERR_STATE: a residual is not finite. Errors of fn. PD_NOT_CONVERGED: no step
 * lowers the sum any more, or there were 100 steps; the result is filled then, too. After an error its values are not
 * set. */
PD_API pd_status pd_least_squares_solve(pd_ctx *ctx, const pd_least_squares_desc *desc,
                                        pd_least_squares_result *result);
#ifdef PDI_INTERNAL
/* The 97.5 % quantile of Student's t distribution; freedom 0 or below, or above 100000: of the normal distribution. */
PDI_FN double pdi_least_squares_student_quantile(int freedom);
#endif

#endif
