/* monotone_cubic: exact at the points, monotone on hostile data, third order on smooth data, what is refused. */
#include "core/monotone_cubic.h"
#include "random.h"
#include "test.h"
#include <float.h>

#define MOST 400

/* Between two points the curve runs from one value to the other, never back and never beyond: up to rounding in its
 * three terms, which are at most three times the step of y. */
static void check_pieces(const pd_monotone_cubic *c)
{
    enum { PARTS = 200 };
    for (int k = 0; k + 1 < c->count; k++) {
        double low = c->y[k], high = c->y[k + 1], last = low, size = fmax(fabs(low), fabs(high));
        double sign = high >= low ? 1.0 : -1.0;
        if (!CHECK(pdi_monotone_cubic_evaluate(c, c->x[k]) >= low && pdi_monotone_cubic_evaluate(c, c->x[k]) <= low))
            return;
        for (int p = 1; p <= PARTS; p++) {
            double x = c->x[k] + (c->x[k + 1] - c->x[k]) * p / PARTS, y = pdi_monotone_cubic_evaluate(c, x);
            if (!CHECK(y >= fmin(low, high) && y <= fmax(low, high))) return;
            if (!CHECK_LE(sign * (last - y), 8.0 * DBL_EPSILON * size)) return;
            last = y;
        }
    }
}

/* Steps, plateaus, spikes and steps of x and y over many decades. */
TEST(monotone_between_points)
{
    static double x[MOST], y[MOST];
    uint32_t seed = 4;
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    for (int round = 0; round < 60; round++) {
        int n = 2 + (int)(next_random(&seed) % 60), rising = round % 2;
        x[0] = -1.0;
        y[0] = 0.5;
        for (int k = 1; k < n; k++) {
            double step = pow(10.0, 6.0 * random_share(&seed) - 6.0);
            double jump = pow(10.0, 12.0 * random_share(&seed) - 9.0);
            if (next_random(&seed) % 3 == 0) jump = 0.0;
            x[k] = x[k - 1] + step;
            y[k] = y[k - 1] + (rising || next_random(&seed) % 2 ? jump : -jump);
        }
        if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, y, n, 0, &c))) return;
        check_pieces(&c);
        pdi_monotone_cubic_free(&ctx, &c);
    }
    CHECK_INT(ctx.in_use, 0);
}

/* Data on which cubic splines and parabolic slopes overshoot (Fritsch and Carlson 1980, table 1). */
TEST(rpn_data)
{
    static const double x[9] = {7.99, 8.09, 8.19, 8.7, 9.2, 10.0, 12.0, 15.0, 20.0};
    static const double y[9] = {0.0, 2.76429e-5, 4.37498e-2, 0.169183, 0.469428, 0.943740, 0.998636, 0.999919,
                                0.999994};
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, y, 9, 0, &c))) return;
    check_pieces(&c);
    for (int k = 0; k < 9; k++)
        CHECK(pdi_monotone_cubic_evaluate(&c, x[k]) >= y[k] && pdi_monotone_cubic_evaluate(&c, x[k]) <= y[k]);
    pdi_monotone_cubic_free(&ctx, &c);
    pdi_monotone_cubic_free(&ctx, &c);
}

/* Largest error on [0, 2] with n pieces, whose lengths differ by up to a factor of 1.9. */
static double smooth_error(int n, double (*f)(double))
{
    static double x[MOST], y[MOST];
    double worst = 0.0;
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    for (int k = 0; k <= n; k++) {
        x[k] = 2.0 * (k + (k > 0 && k < n ? 0.3 * (k % 2 ? 0.5 : -0.5) : 0.0)) / n;
        y[k] = f(x[k]);
    }
    if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, y, n + 1, 0, &c))) return NAN;
    for (int p = 0; p <= 20 * n; p++)
        worst = fmax(worst, fabs(pdi_monotone_cubic_evaluate(&c, 0.1 * p / n) - f(0.1 * p / n)));
    pdi_monotone_cubic_free(&ctx, &c);
    return worst;
}

static double steep(double x) { return exp(2.0 * x); }
static double falling(double x) { return 1.0 / (1.0 + exp(4.0 * (x - 0.7))); }
static double bump(double x) { return exp(-4.0 * (x - 0.93) * (x - 0.93)); }

/* Third order where the function is monotone. At an extreme the slope that is cut may be off by h f'', which moves its
 * two pieces by 4/27 h of that at most. */
TEST(order_on_smooth_data)
{
    double (*const list[2])(double) = {steep, falling};
    for (int n = 40; n <= 320; n *= 2) CHECK_LE(smooth_error(n, bump), 4.0 / 27.0 * 8.0 * (2.6 / n) * (2.6 / n));
    for (int f = 0; f < 2; f++) {
        double coarse = smooth_error(40, list[f]);
        for (int n = 80; n <= 320; n *= 2) {
            double fine = smooth_error(n, list[f]), order = log2(coarse / fine);
            NOTE("function %d, %d pieces: error %.3g, order %.2f", f, n, fine, order);
            CHECK(order >= 2.9);
            coarse = fine;
        }
    }
}

/* Parabolas that do not turn, and lines, are exact. */
TEST(polynomials)
{
    double x[12], line[12], parabola[12];
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 12; k++) {
        x[k] = 1.0 + k + 0.2 * (k % 3);
        line[k] = 3.0 - 2.0 * x[k];
        parabola[k] = x[k] * x[k];
    }
    for (int p = 0; p < 2; p++) {
        if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, p ? parabola : line, 12, 0, &c))) return;
        for (double at = x[0]; at <= x[11]; at += 0.03)
            CHECK_REL(pdi_monotone_cubic_evaluate(&c, at), p ? at * at : 3.0 - 2.0 * at, 1e-13);
        for (double at = x[0]; at <= x[11]; at += 0.03) {
            double slope;
            CHECK_REL(pdi_monotone_cubic_interpolate(c.x, c.y, c.slope, 12, at, &slope),
                      pdi_monotone_cubic_evaluate(&c, at), 1e-15);
            CHECK_NEAR(slope, p ? 2.0 * at : -2.0, 1e-12 * (1.0 + fabs(at)));
        }
        pdi_monotone_cubic_free(&ctx, &c);
    }
    if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, line, 2, 0, &c))) return; /* two points: a line */
    CHECK_NEAR(pdi_monotone_cubic_evaluate(&c, 1.5), 0.0, 1e-15);
    pdi_monotone_cubic_free(&ctx, &c);
}

TEST(outside)
{
    static const double x[3] = {1.0, 2.0, 4.0}, y[3] = {5.0, 6.0, 9.0};
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    for (int strict = 0; strict < 2; strict++) {
        if (!CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, x, y, 3, strict, &c))) return;
        CHECK_NEAR(pdi_monotone_cubic_evaluate(&c, 1.0 - 2e-5), 5.0, 0.0);
        CHECK_NEAR(pdi_monotone_cubic_evaluate(&c, 4.0 + 2e-5), 9.0, 0.0);
        double below = pdi_monotone_cubic_evaluate(&c, 0.9), above = pdi_monotone_cubic_evaluate(&c, 4.1),
               none = pdi_monotone_cubic_evaluate(&c, (double)NAN);
        if (strict) CHECK(below != below && above != above);
        else CHECK(below >= 5.0 && below <= 5.0 && above >= 9.0 && above <= 9.0);
        CHECK(none != none);
        pdi_monotone_cubic_free(&ctx, &c);
    }
    double empty = pdi_monotone_cubic_evaluate(&c, 1.0);
    CHECK(empty != empty);
}

TEST(refusals)
{
    static const double good[3] = {1.0, 2.0, 3.0};
    double bad[5][3] = {{1.0, 1.0, 2.0}, {1.0, 3.0, 2.0}, {0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}, {0.0, 1e-160, 1.0}};
    pd_ctx ctx;
    pd_monotone_cubic c;
    pd_ctx_init(&ctx);
    bad[2][1] = (double)NAN;
    bad[3][2] = (double)INFINITY;
    for (int k = 0; k < 5; k++) {
        CHECK_INT(pd_monotone_cubic_build(&ctx, bad[k], good, 3, 0, &c), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, "expected") != NULL);
    }
    CHECK_INT(pd_monotone_cubic_build(&ctx, good, bad[2], 3, 0, &c), PD_ERR_ARGUMENT);
    CHECK_INT(pd_monotone_cubic_build(&ctx, good, good, 1, 0, &c), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "at least 2") != NULL);
    ctx.alloc.limit = 60; /* room for x and y alone */
    CHECK_INT(pd_monotone_cubic_build(&ctx, good, good, 3, 0, &c), PD_ERR_LIMIT);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(monotone_between_points) ENTRY(rpn_data) ENTRY(order_on_smooth_data) ENTRY(polynomials) ENTRY(outside)
          ENTRY(refusals))
