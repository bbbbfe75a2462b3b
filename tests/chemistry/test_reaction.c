/* reaction: random laws of dissolution in closed boxes, against the balance of one stirred vessel, and beside a bath,
 * against the linear profile between metal and bath; steps as long as the run chooses them.
 * dims: 1 2 3   slow: 2 3. Each kind of law once; with PD_TEST_ALL=1, ten times in 1D and three times in 2D. */
#include "fixture.h"
#include "metal/interface.h"
#include <float.h>
#include <math.h>

#define CS 71500.0   /* [mol/m3] */
#define CSAT 56.0    /* [mol/m3] */
#define H 1e-5       /* [m] */
#define SOLID 20     /* cells */
#define FLUID 20
#define KINDS 7
#define VALUES 8

typedef struct random_law {
    int kind;
    double speed, power, value[VALUES];
} random_law;

static uint32_t random_state;

static int laws(void)
{
    const char *all = getenv("PD_TEST_ALL");
    return all && all[0] == '1' ? KINDS * (PD_DIM == 1 ? 10 : PD_DIM == 2 ? 3 : 1) : KINDS;
}

/* Powers, roots, exponentials, rising laws, tables of jumps or of lines with negative parts; 0 beyond Csat. */
static double rate(void *user, const pd_rate_at *at)
{
    const random_law *l = (const random_law *)user;
    double x = at->c / CSAT, place = x * VALUES;
    int k = place < VALUES - 1 ? (int)place : VALUES - 1;
    switch (l->kind) {
    case 0: return l->speed * (1.0 - pow(x, l->power));
    case 1: return x < 1.0 ? l->speed * pow(1.0 - x, 1.0 / l->power) : 0.0;
    case 2: return l->speed * (exp(-l->power * x) - exp(-l->power));
    case 3: return l->speed * (1.0 + l->power * x) * (1.0 - x);
    case 4: return x < 1.0 ? l->speed * l->value[k] : 0.0;
    case 5: {
        double here = l->value[k], next = k < VALUES - 1 ? l->value[k + 1] : 0.0;
        return x < 1.0 ? l->speed * (here + (next - here) * (place - k)) : -l->speed;
    }
    default: return x < l->value[0] ? l->speed : x < 1.0 ? 0.1 * l->speed : 0.0;
    }
}

static double rate_at(random_law *l, double c)
{
    pd_rate_at at;
    memset(&at, 0, sizeof at);
    at.c = c;
    return rate(l, &at);
}

static void draw(random_law *l, int number)
{
    memset(l, 0, sizeof *l);
    random_state = 77u + 1000u * (uint32_t)number;
    random_between(&random_state, 0.0, 1.0);
    l->kind = number % KINDS;
    l->power = random_between(&random_state, 1.0, 8.0);
    l->value[0] = random_between(&random_state, 0.2, 1.0);
    for (int k = 1; k < VALUES; k++) l->value[k] = random_between(&random_state, -0.4, 1.5);
}

/* Smallest concentration at which the law is not positive. */
static double end_of(random_law *l, double c)
{
    for (; c < CSAT; c += 1e-6 * CSAT)
        if (!(rate_at(l, c) > 0.0)) return c;
    return c;
}

static scene test_scene;
static double held_bath; /* [mol/m3] */

static double bath_of(void *user, const double *x)
{
    /* nothing on the metal */
    return x[0] > (SOLID + FLUID - 1 - 1e-6) * H ? *(const double *)user : NAN;
}

static void scene_start(scene *s, pd_rate_fn law, void *l, double solid, double m, double diffusivity, double rtol)
{
    scene_reset(s);
    s->ctx.threads = 1;
    s->with = WITH_TRANSPORT | WITH_DISSOLVE | WITH_COUPLE;
    s->grid_desc.solid = &s->shapes[0];
    s->stencil_desc.m = m;
    s->transport_desc.diffusivity = diffusivity;
    s->transport_desc.user = &held_bath;
    s->dissolve_desc.solid = solid;
    s->dissolve_desc.rate = law;
    s->dissolve_desc.rate_user = l;
    s->dissolve_desc.uniform = 1;
    s->couple_desc.fraction = 0.1;
    s->couple_desc.rtol = rtol;
}

static int scene_make(scene *s) { return scene_build(s) && CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple)); }

/* Metal on the low side of the axis 0, fluid, and from 390 um a bath that holds its concentration, or none. */
static int metal_build(scene *s, pd_rate_fn law, void *l, double solid, double m, double diffusivity, double bath,
                       double rtol)
{
    scene_start(s, law, l, solid, m, diffusivity, rtol);
    held_bath = bath;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = H;
        s->grid_desc.hi[d] = (d ? 4 : SOLID + FLUID) * H;
        s->shapes[0].b[d] = (d ? 4 : SOLID) * H;
        s->shapes[1].a[d] = -s->grid_desc.hi[d]; /* on both sides of the period */
        s->shapes[1].b[d] = (d ? 2.0 : 1.0) * s->grid_desc.hi[d];
        if (d) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    s->shapes[0].type = s->shapes[1].type = PD_SHAPE_BOX;
    s->shapes[1].a[0] = (SOLID + FLUID - 1) * H;
    s->grid_desc.wall = bath >= 0.0 ? &s->shapes[1] : NULL;
    s->transport_desc.initial = fmax(bath, 0.0);
    s->transport_desc.held = bath >= 0.0 ? bath_of : NULL;
    return scene_make(s);
}

/* Rounding of what the steepest line behind a film gives the fluid in a step of dt [s], in mol/m3: a jump of the law is
 * a line of slope 1/R there. */
static double rounding(const scene *s, double dt)
{
    double steepest = 0.0;
    for (int32_t k = 0; k < s->dissolve.beside_count; k++) {
        const pdi_beside *beside = &s->dissolve.beside[k];
        double resist = beside->weight > 0.0 ? pdi_interface_resist(&s->dissolve, beside) : 0.0;
        if (resist > 0.0) steepest = fmax(steepest, beside->weight / resist);
    }
    return 4.0 * DBL_EPSILON * CSAT * steepest * dt / FLUID;
}

/* Steps up to `end`. Every one closes the ledger, deposits nothing and keeps the fluid below `high`. */
static int run_to(scene *s, double end, double high)
{
    double loss = 0.0, above = 1e-9 * CSAT;
    for (int steps = 0; s->couple.time < end; steps++) {
        double before = s->couple.time;
        if (!CHECK(steps < 10000) || !CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &s->couple, end))) return 0;
        CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-12);
        CHECK(pd_time_loop_volume_loss(&s->couple) >= loss - 1e-15);
        loss = pd_time_loop_volume_loss(&s->couple);
        above = fmax(above, rounding(s, s->couple.time - before));
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) CHECK_LE(s->transport.c[i], high + above);
    }
    return 1;
}

/* Concentration of a stirred vessel at time t: small steps that never pass the end. */
static double vessel(random_law *l, double end, double t)
{
    double c = 0.0, now = 0.0, area = CS / (FLUID * H);
    for (double dt = 1e-6 * t; now < t && c < end; now += dt) {
        dt = fmin(fmax(1e-6 * t, 2e-4 * now), t - now);
        if (!(dt > 0.0)) break;
        c = fmin(c + dt * area * fmax(rate_at(l, c), 0.0), end);
    }
    return c;
}

/* A vessel that stirs itself (fast diffusion), after a tenth, one and ten thousand times that what Csat takes. */
TEST(closed_boxes)
{
    int most = 0, count = laws();
    for (int number = 0; number < count; number++) {
        random_law l;
        draw(&l, number);
        l.speed = 1e-9;
        double unit = CSAT * FLUID * H / (CS * l.speed), end = end_of(&l, 0.0);
        for (int k = 0; k < 3; k++) {
            static const double times[] = {0.1, 1.0, 1e4};
            scene *s = &test_scene;
            double until = times[k] * unit, expected = vessel(&l, end, until);
            if (!metal_build(s, rate, &l, CS, 1.0 + number % 3, 1e-6, -1.0, 1e-3)) return;
            if (!run_to(s, until, end)) printf("law %d\n", number);
            double c = s->couple.ledger[0].dissolved / ((double)s->grid.fluid_count * s->stencil.volume);
            /* steps err in what is dissolved or in time, by 2 % */
            double late = 0.5 * (vessel(&l, end, 1.02 * until) - vessel(&l, end, 0.98 * until));
            if (!CHECK_NEAR(c, expected, 0.02 * expected + late))
                printf("law %d, kind %d, time %g\n", number, l.kind, times[k]);
            if (k == 2 && l.kind != 1) CHECK_NEAR(c, end, 1e-4 * CSAT);
            if (s->couple.steps > most) most = (int)s->couple.steps;
            scene_free(s);
        }
    }
    NOTE("at most %d steps", most);
}

/* Between metal and bath the profile is linear: v Cs = D (c - bath)/L, and v is that of the law at c. */
TEST(beside_a_bath)
{
    const double diffusivity = 1e-9;
    int count = laws();
    for (int number = 0; number < count; number++) {
        random_law l;
        draw(&l, number);
        double length = (FLUID - 1) * H, strength = pow(10.0, random_between(&random_state, -2.0, 2.0));
        double bath = random_between(&random_state, 0.0, number % 3 ? 0.3 : 1.5) * CSAT;
        l.speed = strength * CSAT * diffusivity / (CS * length);
        scene *s = &test_scene;
        if (!metal_build(s, rate, &l, CS, 1.0, diffusivity, bath, 1e-4)) return;
        double until = 8.0 * length * length / diffusivity;
        if (!run_to(s, until, fmax(bath, end_of(&l, bath)))) printf("law %d\n", number);
        double depth = pd_time_loop_volume_loss(&s->couple) * SOLID * H, before = depth, from = s->couple.time;
        if (!run_to(s, 1.01 * until, HUGE_VAL)) printf("law %d\n", number);
        depth = pd_time_loop_volume_loss(&s->couple) * SOLID * H;
        double speed = (depth - before) / (s->couple.time - from);
        double resist = CS * (length + 0.5 * (depth + before)) / diffusivity;
        double most = 2.0 * l.speed * (3.0 + l.power), expected = 0.0, step = 1e-5 * most;
        if (rate_at(&l, bath) > 0.0)
            while (rate_at(&l, bath + resist * expected) > expected) expected += step;
        if (!CHECK_NEAR(speed, expected, 2e-3 * expected + 2.0 * step))
            printf("law %d, kind %d, strength %g, bath %g\n", number, l.kind, strength, bath / CSAT);
        if (!(rate_at(&l, bath) > 0.0)) CHECK_NEAR(depth, 0.0, 1e-18);
        scene_free(s);
    }
}

/* A law that falls along a line to Csat, of any steepness. */
static double falling(void *user, const pd_rate_at *at)
{
    return *(const double *)user * (1.0 - at->c / CSAT);
}

/* What the metal gives now [mol/s, per m in 2D, per m2 in 1D]. */
static double given(const scene *s)
{
    double sum = 0.0;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) sum += s->transport.source[i] * s->stencil.volume;
    return sum;
}

/* Law and way to the bath are resistances in series, for every horizon: v Cs = D (s - bath)/L, v = k (1 - s/Csat). The
 * metal has so much that its surface stays where it is. */
TEST(resistances_in_series)
{
    const double diffusivity = 1e-9, solid = 1e8 * CSAT, length = (FLUID - 1) * H;
    double worst = 0.0;
    for (int m = 1; m <= (PD_DIM == 1 ? 6 : PD_DIM == 2 ? 4 : 3); m++)
        for (double strength = 1e-2; strength < 2e6; strength *= PD_DIM == 3 ? 1e4 : 1e2) {
            scene *s = &test_scene;
            double speed = strength * CSAT * diffusivity / (solid * length);
            if (!metal_build(s, falling, &speed, solid, m, diffusivity, 0.2 * CSAT, 1e-3)) return;
            if (!run_to(s, 200.0 * length * length / diffusivity, CSAT)) printf("m %d, strength %g\n", m, strength);
            double flux = given(s) / pow(4.0 * H, PD_DIM - 1.0);
            double expected = 0.8 * CSAT / (length / diffusivity + CSAT / (speed * solid));
            worst = fmax(worst, fabs(flux / expected - 1.0));
            if (!CHECK_NEAR(flux, expected, 5e-5 * expected)) printf("m %d, strength %g\n", m, strength);
            scene_free(s);
        }
    NOTE("flux within %.2g", worst);
}

#if PD_DIM == 2
static double round_bath(void *user, const double *x)
{
    return hypot(x[0], x[1]) > 15.0 * H ? *(const double *)user : NAN;
}

/* A rod of the radius 10 H in a ring that holds its concentration at 20 H: D (s - bath)/(R1 ln(R2/R1)). Surfaces as the
 * lattice has them: about first order on coarse lattices, more where the film is all. */
TEST(rod_in_a_ring)
{
    const double diffusivity = 1e-9, solid = 1e8 * CSAT, length = 10.0 * H * log(2.0);
    for (int m = 1; m <= 4; m++)
        for (double strength = 10.0; strength < 2e3; strength *= 100.0) {
            double error[3];
            for (int k = 0; k < 3; k++) {
                scene *s = &test_scene;
                double h = 10.0 * H / (8 << k), speed = strength * CSAT * diffusivity / (solid * length);
                scene_start(s, falling, &speed, solid, m, diffusivity, 1e-3);
                held_bath = s->transport_desc.initial = 0.2 * CSAT;
                s->transport_desc.held = round_bath;
                for (int d = 0; d < 2; d++) {
                    s->stencil_desc.h[d] = h;
                    s->grid_desc.hi[d] = ((16 << k) + 2) * h;
                    s->grid_desc.lo[d] = -s->grid_desc.hi[d];
                }
                s->shapes[0].type = s->shapes[1].type = PD_SHAPE_BALL;
                s->shapes[0].radius = 10.0 * H;
                s->shapes[1].radius = 20.0 * H;
                s->shapes[2].type = PD_SHAPE_COMPLEMENT;
                s->shapes[2].child[0] = s->shapes[2].child_count = 1;
                s->grid_desc.wall = &s->shapes[2];
                if (!scene_make(s)) return;
                if (!run_to(s, 200.0 * length * length / diffusivity, CSAT)) printf("m %d\n", m);
                double expected = 0.8 * CSAT / (length / diffusivity + CSAT / (speed * solid));
                error[k] = given(s) / (20.0 * 3.14159265358979324 * H) / expected - 1.0;
                scene_free(s);
            }
            double order = log(fabs(error[0] / error[2])) / log(4.0);
            NOTE("m = %d, strength %g: off by %.2e, %.2e and %.2e with 8, 16 and 32 cells, order %.1f", m, strength,
                 error[0], error[1], error[2], order);
            CHECK_LE(fabs(error[2]), 5e-3);
            CHECK_LE(1.0, order);
        }
}
#define OF_DIM ENTRY(rod_in_a_ring)
#elif PD_DIM == 1
/* Metal that saturates its surface at once, beside fluid without end: what has dissolved by the time t is
 * 2 Csat sqrt(D t/pi) (Crank 1975, 3.15), of second order in h/sqrt(D t). */
TEST(saturated_at_once)
{
    const double diffusivity = 1e-9, solid = 1e8 * CSAT;
    for (int m = 1; m <= 6; m++) {
        double error[2];
        for (int k = 0; k < 2; k++) {
            scene *s = &test_scene;
            double width = (k + 1) * 2.0 * H, speed = 1e6 * CSAT * diffusivity / (solid * H);
            if (!metal_build(s, falling, &speed, solid, m, diffusivity, -1.0, 1e-4)) return;
            s->couple.desc.max_step = 5e-4 * width * width / diffusivity;
            if (!run_to(s, width * width / diffusivity, CSAT)) printf("m %d\n", m);
            error[k] = s->couple.ledger[0].dissolved / (2.0 * CSAT * width / sqrt(3.14159265358979324)) - 1.0;
            scene_free(s);
        }
        NOTE("m = %d: off by %.2e and %.2e with 2 and 4 cells of penetration", m, error[0], error[1]);
        CHECK_LE(fabs(error[1]), 0.02 * (m * m + 3.0) / 16.0);
        CHECK_LE(1.8, log(error[0] / error[1]) / log(2.0));
    }
}
#define OF_DIM ENTRY(saturated_at_once)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(closed_boxes) ENTRY(beside_a_bath) ENTRY(resistances_in_series) OF_DIM)
