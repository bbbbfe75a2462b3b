/* stiff: a few ordinary differential equations, against closed forms: order, stiffness, bounds, what cannot be done.
 * dims: 2 */
#include "solve/stiff_ode.h"
#include "test.h"
#include <math.h>

static int asked;

static pd_stiff_ode_status solve(pd_stiff_ode_rate_fn rate, int count, double low, double high, double tolerance,
                                 double to, double *y)
{
    double lows[PD_STIFF_ODE_MAX_EQUATIONS], highs[PD_STIFF_ODE_MAX_EQUATIONS], size[PD_STIFF_ODE_MAX_EQUATIONS];
    pd_stiff_ode s;
    int which = -7;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < PD_STIFF_ODE_MAX_EQUATIONS; k++) {
        lows[k] = low;
        highs[k] = high;
        size[k] = 1.0;
    }
    s.count = count;
    s.rate = rate;
    s.low = lows;
    s.high = highs;
    s.typical = size;
    s.tolerance = tolerance;
    asked = 0;
    pd_stiff_ode_status end = pdi_stiff_ode_solve(&s, 0.0, to, y, &which);
    if (end == PD_STIFF_ODE_NOT_FINITE) CHECK(which >= 0 && which < count);
    else CHECK_INT(which, -7);
    return end;
}

/* A pair that turns, and decays beside it. */
static void turn(void *user, double t, const double *y, double *rate)
{
    (void)user;
    (void)t;
    asked++;
    rate[0] = -y[1];
    rate[1] = y[0];
    rate[2] = -y[2];
}

TEST(closed_forms)
{
    for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 1e-2) {
        double y[PD_STIFF_ODE_MAX_EQUATIONS] = {1.0, 0.0, 1.0};
        CHECK_INT(solve(turn, 3, -HUGE_VAL, HUGE_VAL, tolerance, 10.0, y), PD_STIFF_ODE_DONE);
        NOTE("turn: tolerance %g: off by %.2e, %d rates", tolerance, fabs(y[0] - cos(10.0)), asked);
        CHECK_NEAR(y[0], cos(10.0), 20.0 * tolerance);
        CHECK_NEAR(y[1], sin(10.0), 20.0 * tolerance);
        CHECK_NEAR(y[2], exp(-10.0), 2.0 * tolerance);
        CHECK(asked < 40000);
    }
}

/* y' = -1e9 (y - cos t) - sin t: y = cos t. */
static void relax(void *user, double t, const double *y, double *rate)
{
    (void)user;
    asked++;
    rate[0] = -1e9 * (y[0] - cos(t)) - sin(t);
}

TEST(stiff)
{
    double y[PD_STIFF_ODE_MAX_EQUATIONS] = {1.0};
    CHECK_INT(solve(relax, 1, -HUGE_VAL, HUGE_VAL, 1e-8, 10.0, y), PD_STIFF_ODE_DONE);
    CHECK_NEAR(y[0], cos(10.0), 1e-7);
    NOTE("stiff: off by %.2e, %d rates", fabs(y[0] - cos(10.0)), asked);
    CHECK(asked < 3000);
    y[0] = 3.0; /* far off it: the layer is met, too */
    CHECK_INT(solve(relax, 1, -HUGE_VAL, HUGE_VAL, 1e-8, 10.0, y), PD_STIFF_ODE_DONE);
    CHECK_NEAR(y[0], cos(10.0), 1e-7);
}

/* 0.75 cos t: from 0 up to a bound at 0.5 at t = asin(2/3), held there until pi/2, then 0.5 + 0.75 (sin t - 1). */
static void wave(void *user, double t, const double *y, double *rate)
{
    (void)user;
    asked++;
    if (!(y[0] <= 0.5)) rate[0] = NAN; /* never asked beyond it */
    else rate[0] = 0.75 * cos(t);
}

TEST(bounds)
{
    double y[PD_STIFF_ODE_MAX_EQUATIONS] = {0.0};
    CHECK_INT(solve(wave, 1, -HUGE_VAL, 0.5, 1e-8, 0.5, y), PD_STIFF_ODE_DONE);
    CHECK_NEAR(y[0], 0.75 * sin(0.5), 1e-7);
    y[0] = 0.0;
    CHECK_INT(solve(wave, 1, -HUGE_VAL, 0.75 * sin(0.5), 1e-8, 0.5, y), PD_STIFF_ODE_DONE); /* just there */
    CHECK_NEAR(y[0], 0.75 * sin(0.5), 1e-8);
    y[0] = 0.0;
    CHECK_INT(solve(wave, 1, -HUGE_VAL, 0.5, 1e-8, 1.2, y), PD_STIFF_ODE_DONE);
    CHECK_NEAR(y[0], 0.5, 0.0);
    y[0] = 0.0;
    CHECK_INT(solve(wave, 1, -HUGE_VAL, 0.5, 1e-8, 3.0, y), PD_STIFF_ODE_DONE);
    CHECK_NEAR(y[0], 0.5 + 0.75 * (sin(3.0) - 1.0), 1e-7);
}

static void root(void *user, double t, const double *y, double *rate)
{
    (void)user;
    (void)t;
    rate[0] = 1.0;
    rate[1] = sqrt(0.5 - y[0]);
}

static void chatter(void *user, double t, const double *y, double *rate)
{
    (void)user;
    (void)t;
    rate[0] = y[0] > 0.5 ? -1.0 : 1.0;
}

/* Ways that end anywhere: no rest of rounding is left, and the longest ones do not begin with a step that damps all. */
TEST(ends)
{
    for (int k = 1; k < 2000; k++) {
        double y[PD_STIFF_ODE_MAX_EQUATIONS] = {1.0, 0.0, 1.0}, to = 0.37 * k + 1e-3 / k;
        if (!CHECK_INT(solve(turn, 3, -HUGE_VAL, HUGE_VAL, 1e-4, to, y), PD_STIFF_ODE_DONE)) return;
        if (!CHECK_NEAR(y[0], cos(to), 2e-4 * (1.0 + to))) return;
        if (!CHECK_NEAR(hypot(y[0], y[1]), 1.0, 1e-2)) return;
    }
}

TEST(what_cannot_be_done)
{
    double y[PD_STIFF_ODE_MAX_EQUATIONS] = {0.0, 0.0};
    CHECK_INT(solve(root, 2, -HUGE_VAL, HUGE_VAL, 1e-8, 1.0, y), PD_STIFF_ODE_NOT_FINITE);
    y[0] = 0.0;
    CHECK_INT(solve(chatter, 1, -HUGE_VAL, HUGE_VAL, 1e-8, 1.0, y), PD_STIFF_ODE_UNDERFLOW);
}

TEST_MAIN(ENTRY(closed_forms) ENTRY(stiff) ENTRY(bounds) ENTRY(ends) ENTRY(what_cannot_be_done))
