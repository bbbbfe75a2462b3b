/* least_squares: see least_squares.h */
#include "solve/least_squares.h"
#include "core/array_registry.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PDI_LEAST_SQUARES_PROBES 4     /* equidistant evaluations beside the start from which the noise is measured */
/* [-] of the bounds, between them: no round number, so that it is no multiple of an input resolution */
#define PDI_LEAST_SQUARES_PROBE_SPACING 1.618e-4
#define PDI_LEAST_SQUARES_MAX_STEPS 100        /* most steps */
#define PDI_LEAST_SQUARES_FIRST_INCREMENT 1e-2 /* [-] of the bounds: increment of the first finite differences */
#define PDI_LEAST_SQUARES_MIN_INCREMENT 1e-6   /* [-] of the bounds: least increment of later ones */
#define PDI_LEAST_SQUARES_MAX_INCREMENT 0.1    /* [-] of the bounds: largest increment of later ones */

enum { PDI_LEAST_SQUARES_N = PD_LEAST_SQUARES_PARAMETERS };

/* State of a fit. */
typedef struct pdi_least_squares {
    pd_ctx *ctx;
    const pd_least_squares_desc *desc;
    pd_least_squares_result *result;
    int n;                      /* parameters */
    int m;                      /* points */
    double q[PDI_LEAST_SQUARES_N];    /* [-] present parameters, scaled to 0 .. 1 between their bounds */
    double step[PDI_LEAST_SQUARES_N]; /* [-] increments of the finite differences */
    double *r;                  /* [m] residuals at q */
    double *trial;              /* [m] residuals at a trial point */
    double *jacobian;           /* [n][m] d residual / d q */
    double *work;               /* [(probes + 1)][m] */
    double sum, damping;        /* [-] sum of squares at q; Levenberg-Marquardt damping */
    /* [-] parameters at which the Jacobian was computed by finite differences */
    double jacobian_at[PDI_LEAST_SQUARES_N];
} pdi_least_squares;

/* 1: parameter k is scaled by its logarithm: its low bound is positive and the high one at least ten times that. */
static int pdi_least_squares_is_log_scaled(const pd_least_squares_desc *d, int k)
{
    return d->low[k] > 0.0 && d->high[k] >= 10.0 * d->low[k];
}

/* Value of parameter k from its scaled value q: exactly a bound for q <= 0 and q >= 1, between them geometric where it
 * is scaled by its logarithm, else linear. */
static double pdi_least_squares_unscale(const pd_least_squares_desc *d, int k, double q)
{
    if (q <= 0.0) return d->low[k];
    if (q >= 1.0) return d->high[k];
    if (pdi_least_squares_is_log_scaled(d, k)) return d->low[k] * pow(d->high[k] / d->low[k], q);
    return (1.0 - q) * d->low[k] + q * d->high[k];
}

/* Derivative of the value of parameter k by its scaled value q. */
static double pdi_least_squares_unscale_derivative(const pd_least_squares_desc *d, int k, double q)
{
    if (pdi_least_squares_is_log_scaled(d, k)) return pdi_least_squares_unscale(d, k, q) * log(d->high[k] / d->low[k]);
    return d->high[k] - d->low[k];
}

/* Column k of the Jacobian, [m]. */
static double *pdi_least_squares_jacobian_column(const pdi_least_squares *s, int k)
{
    return s->jacobian + (int64_t)k * s->m;
}

/* Evaluate the residuals [m] and their sum of squares at scaled parameters q, and count that. PD_ERR_STATE: a residual
 * is not finite. Errors of the function. */
static pd_status pdi_least_squares_evaluate(pdi_least_squares *s, const double *q, double *residual, double *sum)
{
    double value[PDI_LEAST_SQUARES_N];
    for (int k = 0; k < s->n; k++) value[k] = pdi_least_squares_unscale(s->desc, k, q[k]);
    PD_TRY(s->desc->fn(s->ctx, s->desc->user, value, residual));
    s->result->evaluations++;
    *sum = 0.0;
    for (int i = 0; i < s->m; i++) *sum += residual[i] * residual[i];
    if (*sum < HUGE_VAL) return PD_OK;
    return pd_fail(s->ctx, PD_ERR_STATE, "least_squares", "a residual is not finite at %g of parameter 1", value[0]);
}

/* Set result->noise, the standard deviation of one residual: desc.noise where it is positive, else from evaluations
 * along a line from q, at least rounding of the root mean square residual. Smooth parts cancel in k-th differences,
 * whose mean square is the variance of the noise times (2k)!/(k!)^2 (Hamming; More and Wild 2011). Errors of
 * pdi_least_squares_evaluate. */
static pd_status pdi_least_squares_estimate_noise(pdi_least_squares *s)
{
    double q[PDI_LEAST_SQUARES_N], sum, square = 0.0, gamma = 1.0;
    double *f = s->work;
    s->result->noise = s->desc->noise;
    if (s->desc->noise > 0.0) return PD_OK;
    memcpy(f, s->r, (size_t)s->m * sizeof *f);
    for (int p = 1; p <= PDI_LEAST_SQUARES_PROBES; p++) {
        for (int k = 0; k < s->n; k++) q[k] = s->q[k] + (s->q[k] < 0.5 ? 1 : -1) * PDI_LEAST_SQUARES_PROBE_SPACING * p;
        PD_TRY(pdi_least_squares_evaluate(s, q, f + p * s->m, &sum));
    }
    for (int order = 1; order <= PDI_LEAST_SQUARES_PROBES; order++) {
        gamma *= order / (2.0 * (2.0 * order - 1.0));
        for (int p = 0; p + order <= PDI_LEAST_SQUARES_PROBES; p++)
            for (int i = 0; i < s->m; i++) f[p * s->m + i] = f[(p + 1) * s->m + i] - f[p * s->m + i];
    }
    for (int i = 0; i < s->m; i++) square += gamma * f[i] * f[i];
    s->result->noise = pd_max(sqrt(square / s->m), DBL_EPSILON * sqrt(s->sum / s->m));
    return PD_OK;
}

/* Column k of the Jacobian by a finite difference of second order within the bounds, with the increment step[k]: two
 * evaluations, on both sides of q (central), or next to a bound both on the inner side, at one and two increments. */
static pd_status pdi_least_squares_compute_column(pdi_least_squares *s, int k)
{
    double q[PDI_LEAST_SQUARES_N], sum, h = s->step[k], *j = pdi_least_squares_jacobian_column(s, k);
    double *a = s->work, *b = s->work + s->m;
    double first = s->q[k] + h <= 1.0 ? h : -h, mirrored = s->q[k] - first;
    double second = mirrored >= 0.0 && mirrored <= 1.0 ? -first : 2.0 * first;
    memcpy(q, s->q, sizeof q);
    q[k] = s->q[k] + first;
    PD_TRY(pdi_least_squares_evaluate(s, q, a, &sum));
    q[k] = s->q[k] + second;
    PD_TRY(pdi_least_squares_evaluate(s, q, b, &sum));
    for (int i = 0; i < s->m; i++) {
        double near_slope = (a[i] - s->r[i]) / first, far_slope = (b[i] - s->r[i]) / second;
        j[i] = (near_slope * second - far_slope * first) / (second - first);
    }
    return PD_OK;
}

/* Dot product over the points. */
static double pdi_least_squares_dot(const pdi_least_squares *s, const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < s->m; i++) sum += a[i] * b[i];
    return sum;
}

/* -1, 1: parameter k is on its low, high bound, and the sum of squares would decrease beyond it (active bound); else
 * 0. */
static int pdi_least_squares_active_bound(const pdi_least_squares *s, int k)
{
    double slope = pdi_least_squares_dot(s, pdi_least_squares_jacobian_column(s, k), s->r);
    return s->q[k] <= 0.0 && slope > 0.0 ? -1 : s->q[k] >= 1.0 && slope < 0.0 ? 1 : 0;
}

/* Cholesky factor, in the lower triangle of a, of the normal matrix J^T J with its diagonal times (1 + damping);
 * parameters on active bounds get a unit row and column. 1: done; 0: singular: a pivot is not above 1e-13 of its
 * diagonal without damping. */
static int pdi_least_squares_factor_normal(const pdi_least_squares *s, double damping,
                                           double a[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N])
{
    int held[PDI_LEAST_SQUARES_N];
    double least[PDI_LEAST_SQUARES_N];
    for (int k = 0; k < s->n; k++) held[k] = pdi_least_squares_active_bound(s, k);
    for (int k = 0; k < s->n; k++) {
        const double *column = pdi_least_squares_jacobian_column(s, k);
        for (int l = 0; l <= k; l++) {
            a[k][l] = pdi_least_squares_dot(s, column, pdi_least_squares_jacobian_column(s, l));
            if (held[k] || held[l]) a[k][l] = k == l ? 1.0 : 0.0;
        }
        least[k] = 1e-13 * a[k][k];
        a[k][k] *= 1.0 + damping;
    }
    return pdi_vec_cholesky(s->n, PDI_LEAST_SQUARES_N, least, a[0]);
}

/* Compute the Jacobian by finite differences at q, noted in jacobian_at, and their next increments h: with relative
 * noise e, and a third derivative of the size of the first one, the relative error e/h + h^2/6 is least at h = (3
 * e)^(1/3), kept in 1e-6 .. 0.1. PD_ERR_ARGUMENT: a parameter (result->ineffective) has no effect, its column being at
 * most ten times the norm of the noise, or the normal matrix is singular. */
static pd_status pdi_least_squares_compute_jacobian(pdi_least_squares *s)
{
    double noise = s->result->noise * sqrt((double)s->m), a[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N];
    for (int k = 0; k < s->n; k++) {
        PD_TRY(pdi_least_squares_compute_column(s, k));
        const double *j = pdi_least_squares_jacobian_column(s, k);
        double size = sqrt(pdi_least_squares_dot(s, j, j));
        s->result->ineffective = size > 10.0 * noise ? 0 : k + 1;
        if (s->result->ineffective)
            return pd_fail(s->ctx, PD_ERR_ARGUMENT, "least_squares",
                           "parameter %d has no effect on the points: they change"
                           " by %.3g between its bounds, and by %.3g without it",
                           k + 1, size, noise);
        s->step[k] = pd_min(PDI_LEAST_SQUARES_MAX_INCREMENT,
                            pd_max(PDI_LEAST_SQUARES_MIN_INCREMENT, cbrt(3.0 * noise / size)));
    }
    memcpy(s->jacobian_at, s->q, sizeof s->jacobian_at);
    if (pdi_least_squares_factor_normal(s, 0.0, a)) return PD_OK;
    return pd_fail(s->ctx, PD_ERR_ARGUMENT, "least_squares", "the points do not distinguish the %d parameters", s->n);
}

/* q: the scaled parameters after a Levenberg-Marquardt step, clipped to the bounds; those on active bounds stay. 1:
 * done; 0: the matrix is singular, and q is not set. */
static int pdi_least_squares_compute_step(const pdi_least_squares *s, double *q)
{
    double a[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N], x[PDI_LEAST_SQUARES_N];
    if (!pdi_least_squares_factor_normal(s, s->damping, a)) return 0;
    for (int k = 0; k < s->n; k++)
        x[k] = pdi_least_squares_active_bound(s, k)
                   ? 0.0
                   : -pdi_least_squares_dot(s, pdi_least_squares_jacobian_column(s, k), s->r);
    pdi_vec_cholesky_solve(s->n, PDI_LEAST_SQUARES_N, a[0], x);
    for (int k = 0; k < s->n; k++) q[k] = pd_min(1.0, pd_max(0.0, s->q[k] + x[k]));
    return 1;
}

/* Factor of the covariance: the reduced chi-square, sum of squares over degrees of freedom (NaN without any). With
 * known standard deviations at least 1, and 1 without degrees of freedom. */
static double pdi_least_squares_covariance_factor(const pdi_least_squares *s)
{
    int freedom = s->result->degrees_of_freedom;
    double reduced = freedom > 0 ? s->sum / freedom : (double)NAN;
    if (!s->desc->known_deviation) return reduced;
    return reduced > 1.0 ? reduced : 1.0;
}

/* Set degrees of freedom and active bounds of the result, and cov, the covariance matrix of the scaled parameters, with
 * NaN for those on active bounds. 1: done; 0: the normal matrix is singular, and cov is not set. */
static int pdi_least_squares_compute_covariance(pdi_least_squares *s,
                                                double cov[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N])
{
    double a[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N];
    pd_least_squares_result *r = s->result;
    r->degrees_of_freedom = s->m;
    for (int k = 0; k < s->n; k++) {
        r->active_bound[k] = pdi_least_squares_active_bound(s, k);
        r->degrees_of_freedom -= !r->active_bound[k];
    }
    if (!pdi_least_squares_factor_normal(s, 0.0, a)) return 0;
    double scale = pdi_least_squares_covariance_factor(s);
    for (int k = 0; k < s->n; k++) {
        for (int l = 0; l < s->n; l++) cov[k][l] = k == l;
        pdi_vec_cholesky_solve(s->n, PDI_LEAST_SQUARES_N, a[0], cov[k]);
        for (int l = 0; l < s->n; l++) cov[k][l] *= r->active_bound[k] || r->active_bound[l] ? (double)NAN : scale;
    }
    return 1;
}

/* 1: no parameter changes in the step to q by more than the tolerance (0: 0.01) times its standard error, plus its
 * uncertainty due to noise, plus rounding; the error counts as 0 on an active bound and where it is NaN. 0: one does,
 * or the normal matrix is singular. Updates degrees of freedom and active bounds of the result. */
static int pdi_least_squares_is_step_small(pdi_least_squares *s, const double *q)
{
    double cov[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N],
        tolerance = s->desc->tolerance > 0.0 ? s->desc->tolerance : 0.01;
    if (!pdi_least_squares_compute_covariance(s, cov)) return 0;
    double unit = s->result->noise * s->result->noise / pdi_least_squares_covariance_factor(s);
    for (int k = 0; k < s->n; k++) {
        double error = s->result->active_bound[k] ? 0.0 : sqrt(cov[k][k]), open = error * sqrt(unit);
        if (isnan(error)) error = open = 0.0;
        if (fabs(q[k] - s->q[k]) > tolerance * error + open + 4.0 * DBL_EPSILON) return 0;
    }
    return 1;
}

/* Broyden's rank-one update: the Jacobian then reproduces the change of the residuals from r to `trial` in the step to
 * q. Nothing for a step of length 0. */
static void pdi_least_squares_broyden_update(pdi_least_squares *s, const double *q)
{
    double length = 0.0;
    for (int k = 0; k < s->n; k++) length += (q[k] - s->q[k]) * (q[k] - s->q[k]);
    for (int i = 0; i < s->m && length > 0.0; i++) {
        double missed = s->trial[i] - s->r[i];
        for (int k = 0; k < s->n; k++) missed -= pdi_least_squares_jacobian_column(s, k)[i] * (q[k] - s->q[k]);
        for (int k = 0; k < s->n; k++) pdi_least_squares_jacobian_column(s, k)[i] += missed * (q[k] - s->q[k]) / length;
    }
}

/* 1: the Jacobian is up to date: in no parameter its finite differences were taken more than one increment away from
 * q. */
static int pdi_least_squares_is_jacobian_valid(const pdi_least_squares *s)
{
    for (int k = 0; k < s->n; k++)
        if (fabs(s->q[k] - s->jacobian_at[k]) > s->step[k]) return 0;
    return 1;
}

/* One iteration. A step that lowers the sum is accepted, with a Broyden update and a tenth of the damping. A step that
 * is small at a damping of at most 1 ends the fit (*done = 1), or with an old Jacobian renews that. Otherwise an old
 * Jacobian is renewed, or the damping grows tenfold, as for a singular matrix. *done = -1: a small step does not lower
 * the sum, or the damping of a singular matrix exceeds 1e10. Else *done, 0 before, stays 0. */
static pd_status pdi_least_squares_iterate_once(pdi_least_squares *s, int *done)
{
    double q[PDI_LEAST_SQUARES_N], sum;
    if (!pdi_least_squares_compute_step(s, q)) {
        s->damping = pd_max(10.0 * s->damping, 1e-8);
        *done = s->damping > 1e10 ? -1 : 0;
        return PD_OK;
    }
    int small = pdi_least_squares_is_step_small(s, q);
    if (small && s->damping <= 1.0) {
        if (pdi_least_squares_is_jacobian_valid(s)) *done = 1;
        else PD_TRY(pdi_least_squares_compute_jacobian(s));
        return PD_OK;
    }
    PD_TRY(pdi_least_squares_evaluate(s, q, s->trial, &sum));
    int lower = sum < s->sum;
    if (!lower && !pdi_least_squares_is_jacobian_valid(s)) return pdi_least_squares_compute_jacobian(s);
    if (!lower) {
        *done = small ? -1 : 0; /* a strongly damped step that still increases the sum */
        s->damping = pd_max(10.0 * s->damping, 1e-3);
        return PD_OK;
    }
    pdi_least_squares_broyden_update(s, q);
    memcpy(s->q, q, sizeof q);
    memcpy(s->r, s->trial, (size_t)s->m * sizeof *s->r);
    s->sum = sum;
    s->damping = s->damping > 1e-6 ? 0.1 * s->damping : 0.0;
    return PD_OK;
}

/* Call the progress callback. */
static void pdi_least_squares_report_progress(const pdi_least_squares *s)
{
    double value[PDI_LEAST_SQUARES_N];
    for (int k = 0; k < s->n; k++) value[k] = pdi_least_squares_unscale(s->desc, k, s->q[k]);
    if (s->desc->report) s->desc->report(s->desc->user, value, s->sum, s->result->evaluations);
}

/* Fill the result: sum, values, standard errors, 95 % intervals (symmetric, not clipped to the bounds), correlations.
 * Student's t for the degrees of freedom, or the normal distribution where known deviations explain the sum. NaN where
 * there is no covariance, as on active bounds. */
static void pdi_least_squares_set_result(pdi_least_squares *s)
{
    double cov[PDI_LEAST_SQUARES_N][PDI_LEAST_SQUARES_N];
    pd_least_squares_result *r = s->result;
    int fixed = pdi_least_squares_compute_covariance(s, cov);
    double t = pdi_least_squares_student_quantile(
        s->desc->known_deviation && pdi_least_squares_covariance_factor(s) <= 1.0 ? 0 : r->degrees_of_freedom);
    r->sum = s->sum;
    for (int k = 0; k < s->n; k++) {
        r->value[k] = pdi_least_squares_unscale(s->desc, k, s->q[k]);
        r->standard_error[k] =
            fixed ? sqrt(cov[k][k]) * pdi_least_squares_unscale_derivative(s->desc, k, s->q[k]) : (double)NAN;
        r->low[k] = r->value[k] - t * r->standard_error[k];
        r->high[k] = r->value[k] + t * r->standard_error[k];
        for (int l = 0; l < s->n; l++)
            r->correlation[k][l] = fixed ? cov[k][l] / sqrt(cov[k][k] * cov[l][l]) : (double)NAN;
    }
}

/* The iteration from the start q to convergence, at most PDI_LEAST_SQUARES_MAX_STEPS steps; reports the start and each
 * step that lowers the sum; renews an old Jacobian at the end and fills the result. PD_NOT_CONVERGED: as of
 * pd_least_squares_solve. Errors leave the result without values. */
static pd_status pdi_least_squares_iterate(pdi_least_squares *s)
{
    int done = 0;
    PD_TRY(pdi_least_squares_evaluate(s, s->q, s->r, &s->sum));
    pdi_least_squares_report_progress(s);
    PD_TRY(pdi_least_squares_estimate_noise(s));
    PD_TRY(pdi_least_squares_compute_jacobian(s));
    while (!done && s->result->steps < PDI_LEAST_SQUARES_MAX_STEPS) {
        double before = s->sum;
        PD_TRY(pdi_least_squares_iterate_once(s, &done));
        s->result->steps++;
        if (s->sum < before) pdi_least_squares_report_progress(s);
    }
    if (!pdi_least_squares_is_jacobian_valid(s)) PD_TRY(pdi_least_squares_compute_jacobian(s));
    s->result->converged = done > 0;
    pdi_least_squares_set_result(s);
    return s->result->converged ? PD_OK : PD_NOT_CONVERGED;
}

/* PD_ERR_ARGUMENT: the number of parameters is not 1 .. 8, there are fewer points than parameters, bounds are not
 * finite or do not rise, a start is outside of them, or tolerance or noise is negative or not finite. */
static pd_status pdi_least_squares_check(pd_ctx *ctx, const pd_least_squares_desc *d)
{
    if (d->parameters < 1 || d->parameters > PDI_LEAST_SQUARES_N)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "least_squares", "%d parameters, expected 1 to %d", d->parameters,
                       PDI_LEAST_SQUARES_N);
    if (d->points < d->parameters)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "least_squares", "%d points for %d parameters, expected as many at least",
                       d->points, d->parameters);
    for (int k = 0; k < d->parameters; k++)
        if (!(d->low[k] < d->high[k]) || !(d->high[k] - d->low[k] < HUGE_VAL) || !(d->start[k] >= d->low[k]) ||
            !(d->start[k] <= d->high[k]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "least_squares",
                           "parameter %d starts at %g between %g and %g, expected"
                           " finite bounds that rise and a start between them",
                           k + 1, d->start[k], d->low[k], d->high[k]);
    if (!(d->tolerance >= 0.0) || !(d->tolerance < HUGE_VAL) || !(d->noise >= 0.0) || !(d->noise < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "least_squares",
                       "tolerance %g, noise %g: expected finite values of at least 0", d->tolerance, d->noise);
    return PD_OK;
}

/* List function: the arrays of a solve. */
static void pdi_least_squares_list(pdi_array_visitor *owner, void *object)
{
    pdi_least_squares *squares = (pdi_least_squares *)object;
    int64_t points = squares->m;
    PDI_ARRAY(owner, squares, r, points, "1");
    PDI_ARRAY(owner, squares, trial, points, "1");
    PDI_ARRAY(owner, squares, jacobian, points * squares->n, "1");
    PDI_ARRAY(owner, squares, work, points * (PDI_LEAST_SQUARES_PROBES + 1), "1");
}

pd_status pd_least_squares_solve(pd_ctx *ctx, const pd_least_squares_desc *d, pd_least_squares_result *result)
{
    pdi_least_squares s;
    memset(&s, 0, sizeof s);
    memset(result, 0, sizeof *result);
    PD_TRY(pdi_least_squares_check(ctx, d));
    s.ctx = ctx;
    s.desc = d;
    s.result = result;
    s.n = d->parameters;
    s.m = d->points;
    for (int k = 0; k < s.n; k++) {
        s.q[k] = pdi_least_squares_is_log_scaled(d, k) ? log(d->start[k] / d->low[k]) / log(d->high[k] / d->low[k])
                                                       : (d->start[k] - d->low[k]) / (d->high[k] - d->low[k]);
        s.step[k] = PDI_LEAST_SQUARES_FIRST_INCREMENT;
    }
    pd_status status = pdi_array_registry_build(ctx, pdi_least_squares_list, &s);
    if (status == PD_OK) status = pdi_least_squares_iterate(&s);
    pdi_array_registry_free(ctx, pdi_least_squares_list, &s);
    return status;
}

/* Probability that |Student's t| < t for an integer number of degrees of freedom (Abramowitz and Stegun 26.7.3,
 * 26.7.4). */
static double pdi_least_squares_student_probability(double t, int freedom)
{
    double angle = atan(t / sqrt((double)freedom)), c = cos(angle), term = 1.0, sum = 0.0;
    int odd = freedom % 2;
    if (odd) term = c;
    for (int k = odd ? 3 : 2; k <= freedom; k += 2) {
        sum += term;
        term *= c * c * (k - 1) / (double)k;
    }
    return odd ? 2.0 / PD_PI * (angle + sin(angle) * sum) : sin(angle) * sum;
}

PDI_FN double pdi_least_squares_student_quantile(int freedom)
{
    double low = 0.0, high = 16.0;
    if (freedom <= 0 || freedom > 100000) return 1.959963984540054;
    for (int k = 0; k < 60; k++) {
        double middle = 0.5 * (low + high);
        if (pdi_least_squares_student_probability(middle, freedom) < 0.95) low = middle;
        else high = middle;
    }
    return 0.5 * (low + high);
}

#undef PDI_LEAST_SQUARES_PROBES
#undef PDI_LEAST_SQUARES_PROBE_SPACING
#undef PDI_LEAST_SQUARES_MAX_STEPS
#undef PDI_LEAST_SQUARES_FIRST_INCREMENT
#undef PDI_LEAST_SQUARES_MIN_INCREMENT
#undef PDI_LEAST_SQUARES_MAX_INCREMENT
