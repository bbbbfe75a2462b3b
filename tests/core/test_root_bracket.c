/* root_bracket: roots of smooth, steep, flat and broken functions, ends in either order, what is asked for at most. */
#include "core/root_bracket.h"
#include "random.h"
#include "test.h"
#include <float.h>

typedef double (*function)(double x, double at);

static double line(double x, double at) { return 3.0 * (x - at); }
static double cubic(double x, double at) { return (x - at) * ((x - at) * (x - at) + 0.1); }
static double seventh(double x, double at) { return pow(x - at, 7.0); }
static double steep(double x, double at) { return expm1(60.0 * (x - at)); }
static double jump(double x, double at) { return x < at ? -1e-9 : 1e9; }
static double tiny(double x, double at) { return 1e-300 * (x - at); }

/* Places asked for until the ends are neighbours; the root lies between them. -1: they do not become neighbours. */
static int search(function f, double at, double a, double b)
{
    pdi_root_bracket s = {a, f(a, at), b, f(b, at), 0, 0};
    double x, last = 0.0;
    while (pdi_root_bracket_get_next(&s, &x)) {
        if (!CHECK(x > fmin(s.a, s.b) && x < fmax(s.a, s.b))) return -1;
        last = f(x, at);
        if (last == 0.0) return x == at ? s.evaluations : -1;
        pdi_root_bracket_update(&s, x, last);
        if (!CHECK((f(s.a, at) > 0.0) != (f(s.b, at) > 0.0))) return -1;
    }
    return nextafter(s.a, s.b) == s.b ? s.evaluations : -1;
}

TEST(finds_the_last_number)
{
    static const function all[] = {line, cubic, steep, jump, tiny};
    uint32_t seed = 11;
    for (int round = 0; round < 400; round++) {
        double at = random_share(&seed), a = at - pow(10.0, -8.0 * random_share(&seed));
        double b = at + pow(10.0, -8.0 * random_share(&seed));
        for (int k = 0; k < 5; k++) {
            CHECK(search(all[k], at, a, b) >= 0);
            CHECK(search(all[k], at, b, a) >= 0);
        }
    }
}

/* A simple root of a smooth function: the order of the rule is 1.44, so that 1e-16 takes about log(16)/log(1.44) = 8
 * evaluations behind the first digit. */
TEST(order)
{
    pdi_root_bracket s = {0.0, cubic(0.0, 0.3), 1.0, cubic(1.0, 0.3), 0, 0};
    double x = 0.0, error = 1.0;
    int begun = 0;
    while (pdi_root_bracket_get_next(&s, &x)) {
        error = fabs(x - 0.3);
        if (error < 0.1 && !begun) begun = s.evaluations;
        if (error < 1e-15) break;
        pdi_root_bracket_update(&s, x, cubic(x, 0.3));
    }
    CHECK_LE(error, 1e-15);
    CHECK_LE(s.evaluations - begun, 12);
}

static double bent(double x, double at) { return expm1(5.0 * (x - at)); }
static double bent_back(double x, double at) { return -expm1(-5.0 * (x - at)); }

/* Whichever end stays, and whichever of both is `a`, the rule gains as much. */
TEST(either_end)
{
    static const function all[] = {bent, bent_back};
    for (int k = 0; k < 4; k++) {
        double from = k < 2 ? 0.0 : 1.0, x = from;
        pdi_root_bracket s = {from, all[k % 2](from, 0.4), 1.0 - from, all[k % 2](1.0 - from, 0.4), 0, 0};
        while (pdi_root_bracket_get_next(&s, &x) && fabs(x - 0.4) > 1e-14)
            pdi_root_bracket_update(&s, x, all[k % 2](x, 0.4));
        CHECK_NEAR(x, 0.4, 1e-14);
        CHECK_LE(s.evaluations, 14);
    }
}

static double between(double x, double at) { return (x - at) - 1e-20; }

/* A root between two numbers, of which the first step finds one: the other end comes as near in a few steps. */
TEST(beside_a_root)
{
    for (int k = 0; k < 4; k++) {
        double at = k % 2 ? 0.3 : -0.3, from = at - 0.7, to = at + 5.0;
        int steps = k < 2 ? search(between, at, from, to) : search(between, at, to, from);
        CHECK(steps >= 0);
        CHECK_LE(steps, 16);
    }
}

/* A root of seventh order, where false positions gain little: no worse than four halvings a bit of the bracket. */
TEST(flat_root)
{
    pdi_root_bracket s = {-1.0, seventh(-1.0, 0.3), 1.0, seventh(1.0, 0.3), 0, 0};
    double x;
    while (fabs(s.b - s.a) > 1e-6 && pdi_root_bracket_get_next(&s, &x)) pdi_root_bracket_update(&s, x, seventh(x, 0.3));
    CHECK_LE(fabs(s.b - s.a), 1e-6);
    CHECK_LE(s.evaluations, 84);
}

/* NaN is a value of no sign: it moves the end b, and the search ends. */
TEST(ends)
{
    pdi_root_bracket s = {0.0, 1.0, 1.0, -1.0, 0, 0};
    double x;
    int asked = 0;
    while (pdi_root_bracket_get_next(&s, &x)) {
        pdi_root_bracket_update(&s, x, NAN);
        asked++;
    }
    CHECK_LE(asked, 200);
    pdi_root_bracket touching = {1.0, 1.0, 1.0 + DBL_EPSILON, -1.0, 0, 0};
    CHECK_INT(pdi_root_bracket_get_next(&touching, &x), 0);
    pdi_root_bracket zero = {0.0, 1.0, 1.0, 0.0, 0, 0};
    CHECK(pdi_root_bracket_get_next(&zero, &x) && x > 0.0 && x < 1.0);
}

TEST_MAIN(ENTRY(finds_the_last_number) ENTRY(order) ENTRY(either_end) ENTRY(beside_a_root) ENTRY(flat_root) ENTRY(ends))
