/* electrode: closed forms of the curves, any overpotential, tables, currents behind a resistance, refusals.
 * dims: 1 */
#include "potential/electrode.h"
#include "test.h"

#define FOLD 0.025

static pd_ctx ctx;

static pd_electrode_term butler(double exchange, double equilibrium, double anodic, double cathodic)
{
    pd_electrode_term t;
    memset(&t, 0, sizeof t);
    t.exchange = exchange;
    t.equilibrium = equilibrium;
    t.anodic = anodic;
    t.cathodic = cathodic;
    return t;
}

static pd_electrode_term table(int points, const double *potential, const double *current)
{
    pd_electrode_term t;
    memset(&t, 0, sizeof t);
    t.kind = PD_ELECTRODE_TABLE;
    t.points = points;
    t.potential = potential;
    t.current = current;
    return t;
}

static pd_status make(const pd_electrode_term *term, int count, double film, pd_electrode *e)
{
    pd_electrode_desc d;
    memset(&d, 0, sizeof d);
    d.term = term;
    d.count = count;
    d.film = film;
    return pd_electrode_build(&ctx, &d, e);
}

static void built(const pd_electrode_term *term, int count, pd_electrode *e)
{
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, make(term, count, 0.0, e));
}

static void freed(pd_electrode *e)
{
    pd_electrode_free(&ctx, e);
    pd_electrode_free(&ctx, e);
    CHECK_INT(ctx.in_use, 0);
}

/* The derivative against a difference, and that no current falls. */
static void check_slope(const pd_electrode *e, double from, double to)
{
    double before = -HUGE_VAL;
    for (double u = from; u <= to; u += (to - from) / 97.0) {
        double slope, i = pd_electrode_current(e, u, &slope), eps = 1e-6;
        double by = (pd_electrode_current(e, u + eps, NULL) - pd_electrode_current(e, u - eps, NULL)) / (2.0 * eps);
        CHECK_LE(before, i);
        CHECK_NEAR(slope, by, 1e-6 * fabs(by) + 1e-9 * fabs(i) / eps * 1e-3 + 1e-12);
        before = i;
    }
}

TEST(butler_volmer)
{
    pd_electrode e;
    pd_electrode_term t = butler(2.0, -0.4, FOLD, 2.0 * FOLD);
    built(&t, 1, &e);
    CHECK_NEAR(pd_electrode_current(&e, -0.4, NULL), 0.0, 0.0);
    CHECK_REL(pd_electrode_current(&e, -0.3, NULL), 2.0 * (exp(4.0) - exp(-2.0)), 1e-14);
    CHECK_REL(pd_electrode_current(&e, -0.7, NULL), 2.0 * (exp(-12.0) - exp(6.0)), 1e-14);
    check_slope(&e, -0.6, -0.2);
    freed(&e);
}

/* A limit is met half where the branch without it is the limit, and is reached far off. */
TEST(limits)
{
    pd_electrode e;
    double least, most;
    pd_electrode_term t[2];
    t[0] = butler(1e-3, 0.0, FOLD, 0.0);
    t[0].anodic_limit = 5.0;
    t[1] = butler(1e-3, 0.5, 0.0, FOLD);
    t[1].cathodic_limit = 3.0;
    built(t, 2, &e);
    CHECK_REL(pd_electrode_current(&e, FOLD * log(5e3), NULL),
              2.5 - 1.0 / (1.0 / 3.0 + 1e3 * exp(-0.5 / FOLD) * 5e3), 1e-12);
    CHECK_REL(pd_electrode_current(&e, -5.0, NULL), -3.0, 1e-12);
    CHECK_REL(pd_electrode_current(&e, 5.0, NULL), 5.0, 1e-12);
    CHECK_REL(pd_electrode_current(&e, 1e100, NULL), 5.0, 1e-12);
    pdi_electrode_range(&e, &least, &most);
    CHECK_NEAR(least, -3.0, 0.0);
    CHECK_NEAR(most, 5.0, 0.0);
    check_slope(&e, -0.2, 0.9);
    freed(&e);
}

/* Nothing overflows, and a current behind a resistance obeys both the curve and Ohm. */
TEST(any_overpotential)
{
    pd_electrode e;
    pd_electrode_term t[3];
    t[0] = butler(1e-6, -1.5, 0.02, 0.03);
    t[1] = butler(10.0, 0.3, 0.01, 0.0);
    t[2] = butler(1e-10, 1.2, 0.0, 0.005);
    built(t, 3, &e);
    for (int sign = -1; sign < 2; sign += 2)
        for (double u = 1e-3; u < 1e13; u *= 10.0) CHECK(fabs(pd_electrode_current(&e, sign * u, NULL)) < 1e300);
    for (double resist = 1e-12; resist < 1e9; resist *= 1e3)
        for (int sign = -1; sign < 2; sign += 2)
            for (double drop = 1e-4; drop < 1e7; drop *= 10.0)
                for (int guess = 0; guess < 3; guess++) {
                    double u = guess == 0 ? sign * drop : guess == 1 ? 50.0 : -1e5, by, more, slope;
                    double i = pdi_electrode_through(&e, 1.0, sign * drop, resist, &u, &by);
                    double curve = pd_electrode_current(&e, u, &slope);
                    double low = -1e9, high = 1e9; /* u by halves */
                    for (int n = 0; n < 120; n++) {
                        double at = 0.5 * (low + high);
                        if (at + resist * pd_electrode_current(&e, at, NULL) < sign * drop) low = at;
                        else high = at;
                    }
                    CHECK_NEAR(u + resist * i, sign * drop, 1e-12 * (fabs(u) + drop) + resist * 1e-14 * fabs(i));
                    CHECK_NEAR(u, high, 4e-16 * (fabs(u) + drop));
                    if (resist * slope < 1.0) CHECK_REL(i, curve, 1e-14);
                    CHECK(by > 0.0 && by <= 1.0 / resist * (1.0 + 1e-12));
                    more = u;
                    CHECK_LE(i, pdi_electrode_through(&e, 1.0, sign * drop * (1.0 + sign * 1e-3), resist, &more, &by));
                }
    freed(&e);
}

/* Without terms and with a film all of the resistance is in series. */
TEST(series)
{
    pd_electrode e;
    double u = 0.0, slope;
    pd_electrode_desc d;
    memset(&d, 0, sizeof d);
    d.equilibrium = -0.25;
    d.film = 3e-3;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_electrode_build(&ctx, &d, &e));
    CHECK_REL(pdi_electrode_through(&e, 1.0, 0.75, 1e-3, &u, &slope), 1.0 / 4e-3, 1e-15);
    CHECK_REL(slope, 250.0, 1e-15);
    CHECK_NEAR(u, -0.25, 0.0);
    freed(&e);
    pd_electrode_term t = butler(1.0, 0.1, 0.0, 0.0);
    t.kind = PD_ELECTRODE_LINEAR;
    t.resistance = 2e-3;
    CHECK_OK(&ctx, make(&t, 1, 3e-3, &e));
    u = 7.0;
    CHECK_REL(pdi_electrode_through(&e, 1.0, 1.1, 5e-3, &u, &slope), 1.0 / 1e-2, 1e-13);
    CHECK_REL(u, 0.3, 1e-12);
    /* a quarter of the curve: four times its resistance, 8e-3 in series with 8e-3 */
    CHECK_REL(pdi_electrode_through(&e, 0.25, 1.7, 5e-3, &u, &slope), 1.6 / 16e-3, 1e-13);
    CHECK_REL(slope, 1.0 / 16e-3, 1e-13);
    CHECK_REL(u, 0.9, 1e-12);
    CHECK_NEAR(pdi_electrode_through(&e, 0.0, 1.1, 5e-3, &u, &slope), 0.0, 0.0); /* and none of it */
    CHECK_NEAR(slope, 0.0, 0.0);
    CHECK_NEAR(u, 1.1, 0.0);
    freed(&e);
}

/* Tables pass their points, never fall, are straight beyond their ends, and follow a smooth curve with order 3. */
TEST(tables)
{
    static const double x[6] = {-1.0, -0.8, -0.5, -0.45, 0.0, 0.3}, y[6] = {-3.0, -1.0, -1.0, 2.0, 2.1, 9.0};
    double last = 0.0;
    pd_electrode e;
    pd_electrode_term t = table(6, x, y);
    built(&t, 1, &e);
    for (int p = 0; p < 6; p++) CHECK_NEAR(pd_electrode_current(&e, x[p], NULL), y[p], 1e-14);
    CHECK_NEAR(pd_electrode_current(&e, -0.7, NULL), -1.0, 1e-14);
    CHECK_REL(pd_electrode_current(&e, -2.0, NULL), -3.0 - 10.0, 1e-13);
    CHECK_REL(pd_electrode_current(&e, 0.4, NULL), 9.0 + 2.3, 1e-13);
    check_slope(&e, -1.1, 0.4);
    freed(&e);
    for (int n = 11; n <= 41; n = 2 * n - 1) {
        double a[41], b[41], error = 0.0;
        for (int p = 0; p < n; p++) {
            a[p] = (double)p / (n - 1);
            b[p] = exp(3.0 * a[p]);
        }
        t = table(n, a, b);
        CHECK_OK(&ctx, make(&t, 1, 0.0, &e));
        for (double u = 0.1; u < 0.9; u += 0.003)
            error = fmax(error, fabs(pd_electrode_current(&e, u, NULL) - exp(3.0 * u)));
        if (last > 0.0) CHECK_LE(error, last / 6.0);
        last = error;
        freed(&e);
    }
}

static void refused(const pd_electrode_term *t, const char *says)
{
    pd_electrode e;
    CHECK_INT(make(t, 1, 0.0, &e), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, says) != NULL);
    CHECK_INT(ctx.in_use, 0);
}

TEST(refusals)
{
    static const double x[3] = {0.0, 1.0, 2.0}, back[3] = {0.0, 1.0, 1.0}, y[3] = {0.0, 2.0, 1.0};
    pd_electrode_term t = butler(1.0, 0.0, 0.0, 0.0);
    pd_electrode e;
    pd_ctx_init(&ctx);
    refused(&t, "at least one branch");
    t = butler(0.0, 0.0, FOLD, 0.0);
    refused(&t, "positive exchange");
    t = butler(1.0, (double)NAN, FOLD, 0.0);
    refused(&t, "equilibrium");
    t.kind = PD_ELECTRODE_LINEAR;
    t.equilibrium = 0.0;
    refused(&t, "resistance 0");
    t = table(3, x, y);
    refused(&t, "falls from 2 to 1");
    t = table(3, back, x);
    refused(&t, "do not ascend");
    t = table(1, x, x);
    refused(&t, "at least 2");
    t.kind = (pd_electrode_kind)7;
    refused(&t, "no kind 7");
    t = butler(1.0, 0.0, FOLD, FOLD);
    CHECK_INT(make(&t, 1, -1.0, &e), PD_ERR_ARGUMENT);
}

TEST_MAIN(ENTRY(butler_volmer) ENTRY(limits) ENTRY(any_overpotential) ENTRY(series) ENTRY(tables) ENTRY(refusals))
