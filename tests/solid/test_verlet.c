/* test_verlet: bodies of any material in motion: dispersion, waves in bars, energies, metal that flows.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/correspondence.h"
#include "solid/verlet.h"
#include "test.h"
#include <math.h>

#define MOST 4000 /* points */
#define PI 3.14159265358979323846

typedef struct bar_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    pd_verlet verlet;
    double position[MOST * PD_DIM], volume[MOST];
} bar_case;

static bar_case test_case;

/* A bar of n cells of 1 with E = 1, density 1 and the longest step times `share`, in motion. */
static bar_case *bar(const int *n, double m, double yield, double share)
{
    bar_case *c = &test_case;
    pd_correspondence_desc metal;
    pd_verlet_desc motion;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->desc.count = 1;
    for (int d = 0; d < PD_DIM; d++) c->desc.count *= n[d];
    if (!CHECK(c->desc.count <= MOST)) return NULL;
    for (int32_t k = 0; k < c->desc.count; k++) {
        for (int32_t d = 0, rest = k; d < PD_DIM; rest /= n[d], d++)
            c->position[k * PD_DIM + d] = rest % n[d] - 0.5 * (n[d] - 1);
        c->volume[k] = 1.0;
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m;
    c->desc.spacing = 1.0;
    if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return NULL;
    memset(&metal, 0, sizeof metal);
    metal.young = 1.0;
    metal.poisson = 0.3;
    metal.plane = yield > 0.0 ? PD_PLANE_STRAIN : PD_PLANE_STRESS;
    metal.yield = yield;
    if (!CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &metal, &c->elastic))) return NULL;
    memset(&motion, 0, sizeof motion);
    motion.density = 1.0;
    motion.step_fraction = share;
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    return CHECK_OK(&c->ctx, pd_verlet_build(&c->ctx, &solid, &motion, &c->verlet)) ? c : NULL;
}

static void end(bar_case *c)
{
    pd_verlet_free(&c->ctx, &c->verlet);
    pd_correspondence_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

static double energy(bar_case *c)
{
    return pd_verlet_kinetic(&c->verlet) + pd_correspondence_energy(&c->ctx, &c->elastic, c->verlet.u);
}

#if PD_DIM == 1
/* A standing wave in a long bar. Springs of E/r^2 have the frequency w, w^2 = 2 sum b_p (1 - cos kp)/p^2 / sum b_p with
 * b = 1, at the horizon 1/2, and steps of dt make it w', sin(w' dt/2) = w dt/2: the middle moves so, to rounding,
 * before it hears of the ends. */
TEST(dispersion)
{
    for (int m = 1; m <= 4; m++)
        for (int j = 0; j < 4; j++) {
            static const double waves[4] = {0.1, 1.0, 2.0, PI};
            int n[3] = {801, 1, 1};
            double square = 0.0, all = 0.0, worst = 0.0;
            bar_case *c = bar(n, m, 0.0, 0.8);
            if (!c) return;
            for (int p = 1; p <= m; p++) {
                double part = p == m ? 0.5 : 1.0;
                square += 2.0 * part * (1.0 - cos(waves[j] * p)) / (p * p);
                all += part;
            }
            for (int i = 0; i < 801; i++) c->verlet.u[i] = cos(waves[j] * c->position[i]);
            double dt = c->verlet.max_step, slow = 2.0 / dt * asin(0.5 * dt * sqrt(square / all));
            for (int k = 1; k <= 80; k++) {
                if (!CHECK_OK(&c->ctx, pd_physics_run(&c->ctx, pd_verlet_process(&c->verlet), k * dt))) return;
                worst = fmax(worst, fabs(c->verlet.u[400] - cos(slow * k * dt)));
            }
            CHECK_LE(worst, 1e-12);
            if (j == 3) NOTE("m = %d: off by %.1e after 80 steps", m, worst);
            end(c);
        }
}
#define OF_1D ENTRY(dispersion)
#else
#define OF_1D
#endif

/* A wave goes through a bar at sqrt(E/rho) within 1 %, and energy stays. */
TEST(waves)
{
    int n[3] = {PD_DIM == 3 ? 36 : 120, PD_DIM == 1 ? 1 : PD_DIM == 2 ? 8 : 5, 5};
    bar_case *c = bar(n, PD_DIM == 3 ? 1.5 : 2.0, 0.0, 1.0);
    if (!c) return;
    double length = n[0], low = HUGE_VAL, high = 0.0, before = 1.0, crossed[3] = {0.0, 0.0, 0.0};
    for (int32_t i = 0; i < c->body.count; i++) /* the slowest stretching of a free bar */
        c->verlet.v[i * PD_DIM] = 1e-3 * sin(PI * c->position[i * PD_DIM] / length);
    double start = pd_verlet_kinetic(&c->verlet), dt = c->verlet.max_step;
    int found = 0, steps = (int)(2.7 * length / dt);
    for (int k = 0; k < steps; k++) {
        if (!CHECK_OK(&c->ctx, pd_physics_run(&c->ctx, pd_verlet_process(&c->verlet), (k + 1) * dt))) return;
        double now = c->verlet.v[(c->body.count - 1) * PD_DIM];
        if (k && (before > 0.0) != (now > 0.0) && found < 3) crossed[found++] = (k + before / (before - now)) * dt;
        before = now;
        if (k % 20) continue;
        low = fmin(low, energy(c));
        high = fmax(high, energy(c));
    }
    double speed = found > 2 ? length / (crossed[2] - crossed[1]) : 0.0;
    NOTE("%d steps of %.3f, energy from %.7f to %.7f of the start, bar wave at %.4f of sqrt(E/rho)", steps, dt,
         low / start, high / start, speed);
    CHECK(low > 0.999 * start && high < 1.001 * start);
    CHECK_NEAR(speed, 1.0, PD_DIM == 3 ? 0.01 : 2e-3);
    end(c);
}

/* The longest step is stable for any motion. */
TEST(longest_step)
{
    int n[3] = {PD_DIM == 3 ? 12 : 40, PD_DIM == 3 ? 6 : PD_DIM == 2 ? 20 : 1, 6};
    uint32_t seed = 4;
    bar_case *c = bar(n, 2.0, 0.0, 1.0);
    if (!c) return;
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) c->verlet.v[k] = 1e-6 * random_real(&seed);
    double start = pd_verlet_kinetic(&c->verlet);
    CHECK_OK(&c->ctx, pd_physics_run(&c->ctx, pd_verlet_process(&c->verlet), 200.0 * c->verlet.max_step));
    CHECK(energy(c) < 3.0 * start);
    end(c);
}

/* Metal that is hit flows: what is kinetic becomes heat, and no energy is left out of the sum. */
TEST(flow)
{
    int n[3] = {PD_DIM == 3 ? 16 : 40, PD_DIM == 1 ? 1 : PD_DIM == 2 ? 8 : 4, 4};
    bar_case *c = bar(n, PD_DIM == 3 ? 1.5 : 2.0, 1e-2, 0.2);
    if (!c) return;
    for (int32_t i = 0; i < c->body.count; i++)
        c->verlet.v[i * PD_DIM] = 0.06 * sin(PI * c->position[i * PD_DIM] / n[0]);
    double start = pd_verlet_kinetic(&c->verlet);
    CHECK_OK(&c->ctx, pd_physics_run(&c->ctx, pd_verlet_process(&c->verlet), 1.0 * n[0]));
    double lost = c->verlet.solid.dissipated(c->verlet.solid.self), sum = energy(c) + lost;
    NOTE("%d steps, %.3f of the energy lost, sum off by %.1e", (int)c->verlet.steps, lost / start, sum / start - 1.0);
    CHECK(lost > 0.2 * start);
    CHECK_NEAR(sum, start, 2e-4 * start);
    end(c);
}

TEST_MAIN(OF_1D ENTRY(waves) ENTRY(longest_step) ENTRY(flow))
