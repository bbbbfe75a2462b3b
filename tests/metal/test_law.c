/* law: speeds behind a film against closed forms and crossings found by bisection in fine steps; lines that meet laws
 * of every kind.
 * dims: 1 */
#include "metal/law.h"
#include "test.h"
#include <math.h>

#define TOP 1e5
#define CSAT 50.0

typedef struct one_law {
    int kind;
    double speed, power;
} one_law;

enum { LINEAR, POWER, STEP, ROOT, EXPONENTIAL, RISING, GAP, CLIFF, CONSTANT, KINDS };

static double rate(void *user, const pd_rate_at *at)
{
    const one_law *l = (const one_law *)user;
    double x = at->c / CSAT;
    switch (l->kind) {
    case LINEAR: return l->speed * (1.0 - x);
    case POWER: return l->speed * (1.0 - pow(x, l->power));
    case STEP: return x < 1.0 ? l->speed : 0.0;
    case ROOT: return x < 1.0 ? l->speed * sqrt(1.0 - x) : 0.0;
    case EXPONENTIAL: return l->speed * (exp(-l->power * x) - exp(-l->power));
    case RISING: return l->speed * (1.0 + l->power * x) * (1.0 - x);
    case GAP: return x < 0.3 ? l->speed : x < 0.4 ? -l->speed : x < 1.0 ? 5.0 * l->speed : 0.0;
    case CLIFF: return x < 0.5 ? l->speed : x < 1.0 ? 0.1 * l->speed : -1e10;
    default: return l->speed;
    }
}

static pdi_law law_of(one_law *l)
{
    pdi_law law;
    memset(&law, 0, sizeof law);
    law.metals = 1;
    law.metal[0].rate = rate;
    law.metal[0].user = l;
    law.metal[0].whole = law.metal[0].share = 1.0;
    law.top = TOP;
    law.limit = HUGE_VAL;
    return law;
}

/* V(c): what the first line touches. */
static double speed_at(pdi_law *law, double resist, double c)
{
    pdi_law_point p;
    CHECK(pdi_law_begin(law, resist, HUGE_VAL, 0.0, c, &p));
    return p.largest;
}

TEST(ends)
{
    static const double ends[KINDS] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.3, 1.0, HUGE_VAL};
    for (int kind = 0; kind < KINDS; kind++) {
        one_law l = {kind, 1e-9, 3.0};
        pdi_law law = law_of(&l);
        double end = pdi_law_end(&law, 0.0, TOP);
        if (ends[kind] < HUGE_VAL) CHECK_REL(end, ends[kind] * CSAT, 1e-13);
        else CHECK(end >= HUGE_VAL);
    }
    one_law l = {GAP, 1e-9, 0.0};
    pdi_law law = law_of(&l);
    CHECK_REL(pdi_law_end(&law, 0.45 * CSAT, TOP), CSAT, 1e-13);
    CHECK(pdi_law_end(&law, 0.35 * CSAT, TOP) >= 0.35 * CSAT);
    CHECK(pdi_law_end(&law, 0.35 * CSAT, TOP) <= 0.35 * CSAT);
}

/* Behind a film: v = v0 (1 - x)/(1 + v0 R/Csat) of the linear law, the end of the law over R where films are thick. */
TEST(films)
{
    for (int k = -12; k <= 12; k++) {
        one_law l = {LINEAR, 1e-9, 0.0}, step = {STEP, 1e-9, 0.0};
        pdi_law law = law_of(&l), jump = law_of(&step);
        double resist = CSAT / 1e-9 * pow(10.0, k);
        for (double x = 0.0; x < 1.0; x += 0.0999) {
            CHECK_REL(speed_at(&law, resist, x * CSAT), 1e-9 * (1.0 - x) / (1.0 + pow(10.0, k)), 1e-9);
            CHECK_REL(speed_at(&jump, resist, x * CSAT), fmin(1e-9, (1.0 - x) * CSAT / resist), 1e-9);
        }
        CHECK(!(speed_at(&law, resist, 1.5 * CSAT) > 0.0));
    }
}

/* The solution is one, the first one, and V falls by at most 1/R. */
TEST(solutions)
{
    for (int kind = 0; kind < KINDS; kind++)
        for (int k = -3; k <= 3; k++) {
            one_law l = {kind, 1e-9, 3.0};
            pdi_law law = law_of(&l);
            double resist = CSAT / 1e-9 * pow(10.0, k), last = 0.0;
            for (int n = 0; n <= 120; n++) {
                double c = 0.01 * n * CSAT, v = speed_at(&law, resist, c);
                double before = pdi_law_rate(&law, c + resist * v * (1.0 - 1e-9));
                double after = pdi_law_rate(&law, c + resist * v * (1.0 + 1e-9));
                CHECK(v >= 0.0);
                if (resist * v > 1e-4 * c) { /* else both round to c */
                    CHECK(before * (1.0 + 1e-6) >= v);
                    CHECK(after <= v * (1.0 + 1e-6));
                }
                for (int part = 1; part < 16 && v > 0.0; part++) /* none before it */
                    CHECK(pdi_law_rate(&law, c + resist * v * part / 16.0) > v * part / 16.0);
                if (n > 0 && kind != RISING && kind != GAP) CHECK_LE(last - v, 0.0101 * CSAT / resist);
                last = v;
            }
        }
}

/* One node that exchanges with a surrounding of concentration c0 at the rate g, and gets weight times V: lines find the
 * balance in few rounds from any start, for any ratio of the two. */
TEST(lines_meet)
{
    int most = 0;
    for (int kind = 0; kind < KINDS; kind++)
        for (int k = -6; k <= 6; k++)
            for (int film = -3; film <= 3; film++)
                for (double start = 0.0; start <= 2.0; start += 0.4) {
                    one_law l = {kind, 1e-9, 4.0};
                    pdi_law law = law_of(&l);
                    pdi_law_point p;
                    double resist = CSAT / 1e-9 * pow(10.0, film), g = 1.0, weight = CSAT / 1e-9 * pow(10.0, k);
                    double c = start * CSAT, outside = 0.02 * CSAT;
                    int met = 0, rounds = 0;
                    if (kind == CONSTANT && k > 3) continue; /* beyond the metal itself */
                    CHECK(pdi_law_begin(&law, resist, HUGE_VAL, 0.0, c, &p));
                    for (; rounds < 100 && met == 0; rounds++) {
                        c = (g * outside + weight * p.speed) / (g - weight * p.slope);
                        met = pdi_law_meet(&law, c, 1e-8 * p.largest, 1e-10 * CSAT, &p);
                    }
                    if (!CHECK_INT(met, 1)) {
                        printf("kind %d weight 1e%d film 1e%d start %g: c %g\n", kind, k, film, start, c / CSAT);
                        continue;
                    }
                    if (rounds > most) most = rounds;
                    double v = p.speed + p.slope * c;
                    CHECK(v >= 0.0);
                    CHECK(kind == CONSTANT || c <= CSAT * (1.0 + 1e-9));
                    /* c is known to a rounding */
                    CHECK(fabs(g * (c - outside) - weight * v) <=
                          1e-9 * (g * c + weight * v) + 1e-15 * (g - weight * p.slope) * c);
                }
    printf("note: lines_meet: at most %d rounds\n", most);
    CHECK(most <= 30);
}

TEST_MAIN(ENTRY(ends) ENTRY(films) ENTRY(solutions) ENTRY(lines_meet))
