/* least_squares: least squares against certified values (NIST StRD), closed forms, bounds, noise, failures.
 * dims: 2 */
#include "solve/least_squares.h"
#include "test.h"
#include <math.h>
#include <string.h>

typedef struct problem {
    const double *x, *y;
    int count, calls;
    double noise; /* of the function: digits cut off */
    double (*model)(const double *p, double x);
} problem;

static pd_status residuals(pd_ctx *ctx, void *user, const double *p, double *r)
{
    problem *q = (problem *)user;
    (void)ctx;
    q->calls++;
    for (int k = 0; k < q->count; k++) {
        double f = q->model(p, q->x[k]);
        if (q->noise > 0.0) f = floor(f / q->noise + 0.5) * q->noise;
        r[k] = f - q->y[k];
    }
    return PD_OK;
}

static pd_least_squares_desc describe(problem *p, int parameters)
{
    pd_least_squares_desc d;
    memset(&d, 0, sizeof d);
    d.parameters = parameters;
    d.points = p->count;
    d.fn = residuals;
    d.user = p;
    return d;
}

static double saturating(const double *p, double x) { return p[0] * (1.0 - exp(-p[1] * x)); }
static double straight(const double *p, double x) { return p[0] + p[1] * x; }

/* National Institute of Standards and Technology, Statistical Reference Datasets, nonlinear regression: Misra1a. */
static const double misra_x[] = {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                                 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0};
static const double misra_y[] = {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                                 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78};
/* BoxBOD, of the higher level of difficulty there. */
static const double box_x[] = {1, 2, 3, 5, 7, 10}, box_y[] = {109, 149, 149, 191, 213, 224};

TEST(misra1a)
{
    pd_ctx ctx;
    pd_least_squares_result r;
    problem p = {misra_x, misra_y, 14, 0, 0.0, saturating};
    pd_least_squares_desc d = describe(&p, 2);
    static const double starts[2][2] = {{500.0, 1e-4}, {250.0, 5e-4}}; /* both of the set */
    for (int s = 0; s < 2; s++) {
        pd_ctx_init(&ctx);
        d.low[0] = 50.0;
        d.high[0] = 1000.0;
        d.low[1] = 5e-5;
        d.high[1] = 5e-3;
        memcpy(d.start, starts[s], sizeof starts[s]);
        d.tolerance = 1e-8;
        if (!CHECK_OK(&ctx, pd_least_squares_solve(&ctx, &d, &r))) NOTE("message: %s", ctx.message);
        CHECK_REL(r.value[0], 2.3894212918e2, 1e-7);
        CHECK_REL(r.value[1], 5.5015643181e-4, 1e-7);
        CHECK_REL(r.standard_error[0], 2.7070075241, 1e-5);
        CHECK_REL(r.standard_error[1], 7.2668688436e-6, 1e-5);
        CHECK_REL(r.sum, 1.2455138894e-1, 1e-9);
        CHECK_INT(r.degrees_of_freedom, 12);
        CHECK_REL(r.high[0] - r.value[0], 2.178812830 * 2.7070075241, 1e-5); /* t, 12 degrees of freedom */
        CHECK_INT(ctx.in_use, 0);
        NOTE("%d evaluations, %d steps, noise %.2g", r.evaluations, r.steps, r.noise);
    }
}

TEST(box_bod)
{
    pd_ctx ctx;
    pd_least_squares_result r;
    problem p = {box_x, box_y, 6, 0, 0.0, saturating};
    pd_least_squares_desc d = describe(&p, 2);
    pd_ctx_init(&ctx);
    d.low[0] = d.start[0] = 1.0; /* the start of the set, on the bounds of both */
    d.high[0] = 1000.0;
    d.low[1] = 1e-2;
    d.high[1] = 2.0;
    d.start[1] = 1.0;
    d.tolerance = 1e-8;
    CHECK_OK(&ctx, pd_least_squares_solve(&ctx, &d, &r));
    CHECK_REL(r.value[0], 2.1380940889e2, 1e-6);
    CHECK_REL(r.value[1], 5.4723748542e-1, 1e-6);
    CHECK_REL(r.standard_error[0], 1.2354515176e1, 1e-4);
    CHECK_REL(r.standard_error[1], 1.0455993237e-1, 1e-4);
    CHECK_REL(r.sum, 1.1680088766e3, 1e-9);
}

/* A straight line of known spread: standard errors from the normal equations, two digits of noise in the function. */
TEST(line)
{
    pd_ctx ctx;
    pd_least_squares_result r;
    static const double x[] = {0, 1, 2, 3, 4}, y[] = {0.3, 0.9, 2.2, 2.8, 4.1};
    const double errors[2] = {sqrt(0.6), sqrt(0.1)}; /* 5 points, sum x = 10, sum x^2 = 30: det 50 */
    for (int noisy = 0; noisy < 2; noisy++) {
        problem p = {x, y, 5, 0, noisy ? 1e-4 : 0.0, straight};
        pd_least_squares_desc d = describe(&p, 2);
        pd_ctx_init(&ctx);
        d.low[0] = d.low[1] = -10.0;
        d.high[0] = d.high[1] = 10.0;
        d.known_deviation = 1;
        CHECK(pd_least_squares_solve(&ctx, &d, &r) >= 0);
        CHECK_NEAR(r.value[0], 0.16, noisy ? 1e-3 : 1e-8); /* by hand: b = (30.1 - 2 10.3)/10, a = 2.06 - 2 b */
        CHECK_NEAR(r.value[1], 0.95, noisy ? 1e-3 : 1e-8);
        CHECK_REL(r.standard_error[0], errors[0], noisy ? 1e-3 : 1e-8);
        CHECK_REL(r.standard_error[1], errors[1], noisy ? 1e-3 : 1e-8);
        CHECK_REL(r.high[1] - r.low[1], 2.0 * 1.959963984540054 * errors[1], noisy ? 1e-3 : 1e-8);
        CHECK_NEAR(r.correlation[0][1], -10.0 / sqrt(150.0), noisy ? 1e-3 : 1e-8);
        CHECK_LE(r.noise, noisy ? 1e-4 : 1e-12);
        if (noisy) CHECK_LE(1e-6, r.noise);
        CHECK_INT(r.evaluations, p.calls);
        NOTE("%d evaluations, noise %.2g", r.evaluations, r.noise);
    }
}

/* The slope may not pass 0.9: the line then goes through the mean, and the result names the bound. */
TEST(bound)
{
    pd_ctx ctx;
    pd_least_squares_result r;
    static const double x[] = {0, 1, 2, 3, 4}, y[] = {0.3, 0.9, 2.2, 2.8, 4.1};
    problem p = {x, y, 5, 0, 0.0, straight};
    pd_least_squares_desc d = describe(&p, 2);
    pd_ctx_init(&ctx);
    d.low[0] = d.low[1] = -10.0;
    d.high[0] = 10.0;
    d.high[1] = 0.9;
    CHECK_OK(&ctx, pd_least_squares_solve(&ctx, &d, &r));
    CHECK_NEAR(r.value[1], 0.9, 0.0);
    CHECK_NEAR(r.value[0], 2.06 - 1.8, 1e-8);
    CHECK_INT(r.active_bound[1], 1);
    CHECK_INT(r.active_bound[0], 0);
    CHECK(isnan(r.standard_error[1]));
    CHECK_INT(r.degrees_of_freedom, 4);
    CHECK_REL(r.standard_error[0], sqrt(r.sum / 4.0 / 5.0), 1e-8);
}

static double without(const double *p, double x) { return p[0] * x; }

TEST(refused)
{
    pd_ctx ctx;
    pd_least_squares_result r;
    problem p = {box_x, box_y, 6, 0, 0.0, without};
    pd_least_squares_desc d = describe(&p, 2);
    pd_ctx_init(&ctx);
    d.high[0] = d.high[1] = 1.0;
    CHECK_INT(pd_least_squares_solve(&ctx, &d, &r), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "parameter 2 has no effect") != NULL);
    d.points = 1;
    CHECK_INT(pd_least_squares_solve(&ctx, &d, &r), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "1 points for 2 parameters") != NULL);
    d.points = 6;
    d.low[1] = 1.0;
    CHECK_INT(pd_least_squares_solve(&ctx, &d, &r), PD_ERR_ARGUMENT);
    CHECK_INT(ctx.in_use, 0);
}

TEST(refused_tolerances)
{
    static const double bad[3] = {-0.01, (double)NAN, (double)INFINITY};
    pd_ctx ctx;
    pd_least_squares_result r;
    problem p = {box_x, box_y, 6, 0, 0.0, straight};
    pd_ctx_init(&ctx);
    for (int k = 0; k < 6; k++) {
        pd_least_squares_desc d = describe(&p, 2);
        d.low[0] = d.low[1] = -10.0;
        d.high[0] = d.high[1] = 10.0;
        *(k < 3 ? &d.tolerance : &d.noise) = bad[k % 3];
        CHECK_INT(pd_least_squares_solve(&ctx, &d, &r), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, k < 3 ? "tolerance" : "noise") != NULL);
        CHECK_INT(r.evaluations, 0);
    }
}

/* Two-sided 95 % points, Abramowitz and Stegun, table 26.10. */
TEST(student)
{
    static const double t[][2] = {{1, 12.706}, {2, 4.303}, {3, 3.182}, {4, 2.776}, {7, 2.365},
                                  {10, 2.228}, {30, 2.042}, {60, 2.000}, {120, 1.980}};
    for (size_t k = 0; k < sizeof t / sizeof t[0]; k++)
        CHECK_NEAR(pdi_least_squares_student_quantile((int)t[k][0]), t[k][1], 5.1e-4);
    CHECK_NEAR(pdi_least_squares_student_quantile(0), 1.960, 5e-4);
    CHECK_NEAR(pdi_least_squares_student_quantile(100000), pdi_least_squares_student_quantile(0), 1e-4);
}

TEST_MAIN(ENTRY(misra1a) ENTRY(box_bod) ENTRY(line) ENTRY(bound) ENTRY(refused) ENTRY(refused_tolerances)
              ENTRY(student))
