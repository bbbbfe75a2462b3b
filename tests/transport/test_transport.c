/* transport: diffusion and advection against exact solutions, conservation, bounds, limits of the explicit step.
 * dims: 1 2 3 */
#include "fixture.h"
#include "transport/amount.h"
#include "transport/explicit.h"
#include <stdlib.h>

#define PI 3.14159265358979323846
#define D 1e-9   /* [m2/s] */
#define H 1e-5   /* [m] */
#define U 1e-3   /* [m/s] */

static scene test_scene;

/* A box from the origin of x * y (* z) cells, all sides walls, spacing H. */
static scene *scene_start(int x, int y, int z)
{
    scene *s = &test_scene;
    scene_box(s, 0.0, H, x, y, z);
    s->with = WITH_TRANSPORT;
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = 1e-3;
    s->flow_desc.report_speed = U;
    s->flow_desc.report_length = x * H;
    s->transport_desc.diffusivity = D;
    return s;
}

/* Inlet at the low side of `axis`, outlet at the high one, uniform velocity along it, ghosts included. */
static void uniform_flow(scene *s, int axis, double speed)
{
    for (int32_t i = 0; i < s->grid.total; i++) s->flow.u[(int64_t)axis * s->grid.total + i] = speed;
    pdi_flow_update_derived_fields(&s->ctx, &s->flow);
}

static void channel(scene *s, int axis)
{
    s->with |= WITH_FLOW;
    s->grid_desc.side[2 * axis] = PD_SIDE_INLET;
    s->grid_desc.side[2 * axis + 1] = PD_SIDE_OUTLET;
}

static void random_field(scene *s, uint32_t *seed)
{
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = random_share(seed);
}

/* Fluid nodes turn wall with probability 1/`odds`. */
static void random_walls(scene *s, uint32_t *seed, uint32_t odds)
{
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID && next_random(seed) % odds == 0) {
            s->grid.kind[i] = PD_WALL;
            s->grid.fluid_count--;
        }
}

static void extremes(const scene *s, double *low, double *high)
{
    *low = HUGE_VAL;
    *high = -HUGE_VAL;
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        *low = fmin(*low, s->transport.c[i]);
        *high = fmax(*high, s->transport.c[i]);
    }
}

static int step_implicit(scene *s, double dt)
{
    return CHECK_OK(&s->ctx, pd_transport_implicit(&s->ctx, &s->transport, dt, &s->result));
}

static int step_explicit(scene *s, double dt)
{
    return CHECK_OK(&s->ctx, pd_transport_explicit(&s->ctx, &s->transport, dt));
}

/* ---- diffusion ---- */

/* The second moments of the family are exact, so the variance of a drop grows by 2 D t along every axis, to rounding,
 * in explicit and implicit steps of any length, until it feels the walls. */
TEST(variance_of_a_drop)
{
    for (int m = 1; m <= 3; m++)
        for (int implicit = 0; implicit < 2; implicit++) {
            int n = PD_DIM == 3 ? 25 : 81, centre[PD_DIM];
            scene *s = scene_start(n, n, n);
            s->transport_desc.tolerance = 1e-13;
            if (!scene_build_m(s, m)) return;
            for (int d = 0; d < PD_DIM; d++) centre[d] = n / 2;
            s->transport.c[pd_grid_node(&s->grid, centre)] = 1.0;
            double dt = implicit ? 0.05 * H * H / D : 0.9 * pd_transport_limit(&s->ctx, &s->transport), time = 0.0;
            int steps = PD_DIM == 3 ? (implicit ? 2 : 4) : (implicit ? 6 : 8);
            for (int k = 0; k < steps; k++, time += dt)
                if (!(implicit ? step_implicit(s, dt) : step_explicit(s, dt))) return;
            for (int d = 0; d < PD_DIM; d++) {
                double mass = 0.0, second = 0.0;
                for (int32_t i = 0; i < s->grid.total; i++) {
                    int at[PD_DIM];
                    pd_grid_index(&s->grid, i, at);
                    mass += s->transport.c[i];
                    second += s->transport.c[i] * (at[d] - centre[d]) * (at[d] - centre[d]) * H * H;
                }
                CHECK_NEAR(mass, 1.0, implicit ? 1e-10 : 1e-13);
                CHECK_REL(second / mass, 2.0 * D * time, implicit ? 1e-8 : 1e-12);
            }
            scene_free(s);
        }
}

/* Largest error of a Gaussian of a width of 3 (3D: 1.2) cells times 2^level after its variance has doubled, over its
 * amplitude. */
static double gaussian_error(int level, double m)
{
    int n = (PD_DIM == 3 ? 9 : 24) << level;
    scene *s = scene_start(n, n, n);
    double sigma2 = (PD_DIM == 3 ? 1.2 : 3.0) * (1 << level) * H, time = 0.0, worst = 0.0;
    sigma2 *= sigma2;
    if (!scene_build_m(s, m)) return HUGE_VAL;
    double end = 0.5 * sigma2 / D, dt = 0.5 * pd_transport_limit(&s->ctx, &s->transport);
    int steps = (int)ceil(end / dt);
    for (int k = 0; k <= steps; k++) {
        double variance = sigma2 + 2.0 * D * time;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM], r2 = 0.0;
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            for (int d = 0; d < PD_DIM; d++) r2 += (x[d] - 0.5 * n * H) * (x[d] - 0.5 * n * H);
            double exact = pow(sigma2 / variance, 0.5 * PD_DIM) * exp(-0.5 * r2 / variance);
            if (k == 0) s->transport.c[i] = exact;
            if (k == steps && r2 < 4.0 * sigma2) worst = fmax(worst, fabs(s->transport.c[i] - exact));
        }
        if (k < steps && !step_explicit(s, end / steps)) return HUGE_VAL;
        time += end / steps;
    }
    scene_free(s);
    return worst;
}

/* Explicit steps in proportion to h^2: second order in space. */
TEST(second_order_in_space)
{
    for (int m = 1; m <= 3; m += 2) {
        double coarse = gaussian_error(0, m), fine = gaussian_error(1, m);
        NOTE("m = %d: error %.3g, half the spacing %.3g, order %.2f", m, coarse, fine, log(coarse / fine) / log(2.0));
        CHECK(coarse < 0.2);
        CHECK_LE(3.2, coarse / fine);
    }
}

/* Amplitude of the first cosine along `axis` at the end of `steps` implicit steps, from 1. */
static double cosine_decay(int n, int axis, double m, double end, int steps)
{
    scene *s = scene_start(n, n, PD_DIM == 3 ? n : 1);
    double part = 0.0, whole = 0.0;
    if (!scene_build_m(s, m)) return HUGE_VAL;
    for (int k = 0; k <= steps; k++) {
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            double mode = cos(PI * x[axis] / (n * H));
            if (k == 0) s->transport.c[i] = 2.0 + mode;
            if (k == steps) part += mode * s->transport.c[i];
            if (k == steps) whole += mode * mode;
        }
        if (k < steps && !step_implicit(s, end / steps)) return HUGE_VAL;
    }
    scene_free(s);
    return part / whole;
}

/* A closed box: amplitudes of 8, 16, 32 implicit steps approach a limit at first order, and that limit is exp(-D k2 t)
 * up to the error of the lattice, which halves with the spacing: bonds cut at a wall carry nothing along it. */
TEST(cosine_in_a_closed_box)
{
    int n = PD_DIM == 3 ? 6 : 20;
    double amplitude[2][3], end = n * n * H * H / (PI * PI * D), exact = exp(-1.0), off[2];
    for (int axis = PD_DIM == 3 ? 2 : 0; axis < PD_DIM; axis++) {
        for (int level = 0; level < 2; level++) {
            for (int k = 0; k < 3; k++)
                amplitude[level][k] = cosine_decay(n << level, axis, 2.0, end * (1 << 2 * level), 8 << k);
            const double *a = amplitude[level];
            CHECK_NEAR((a[0] - a[1]) / (a[1] - a[2]), 2.0, 0.12);
            /* extrapolated twice: the terms of first and second order drop out */
            off[level] = fabs((a[0] - 6.0 * a[1] + 8.0 * a[2]) / 3.0 - exact);
        }
        NOTE("axis %d: limits off by %.3g and %.3g", axis, off[0], off[1]);
        CHECK_LE(off[0], 0.1);
        CHECK_LE(off[1], 0.6 * off[0]);
    }
}

#if PD_DIM == 1
/* With m = 1 the cosine is an eigenvector of the lattice: after n steps the amplitude is (1 + dt lambda)^-n. */
TEST(cosine_is_exact_for_nearest_neighbours)
{
    int n = 20;
    double end = 4e-3, lambda = 2.0 * D * (1.0 - cos(PI / n)) / (H * H);
    for (int steps = 1; steps <= 16; steps *= 4)
        CHECK_REL(cosine_decay(n, 0, 1.0, end, steps), pow(1.0 + end / steps * lambda, -steps), 1e-9);
}
#endif

/* Values prescribed on both sides of any axis: the steady field is linear, exactly, for every m. */
TEST(steady_linear)
{
    for (int axis = 0; axis < PD_DIM; axis++)
        for (int m = 1; m <= 4; m++) {
            scene *s = scene_start(9, 7, 6);
            s->grid_desc.side[2 * axis] = s->grid_desc.side[2 * axis + 1] = PD_SIDE_INLET;
            s->transport_desc.tolerance = 1e-13;
            if (!scene_build_m(s, m)) return;
            for (int32_t i = 0; i < s->grid.total; i++) {
                double x[PD_DIM];
                pd_grid_position(&s->grid, i, x);
                double side = fmin(fmax(x[axis], s->grid.lo[axis]), s->grid.hi[axis]);
                if (s->grid.kind[i] == PD_INLET) s->transport.c[i] = 5.0 + side / H;
            }
            for (int k = 0; k < 3; k++)
                if (!step_implicit(s, 1e9)) return;
            for (int32_t i = 0; i < s->grid.total; i++) {
                double x[PD_DIM];
                pd_grid_position(&s->grid, i, x);
                if (s->grid.kind[i] == PD_FLUID) CHECK_REL(s->transport.c[i], 5.0 + x[axis] / H, 1e-10);
            }
            /* what enters at the high side leaves at the low one */
            CHECK_NEAR(s->transport.inflow, 0.0, 1e-9 * D / H * pow(H, PD_DIM - 1));
            scene_free(s);
        }
}

/* ---- the explicit step ---- */

TEST(explicit_limit)
{
    uint32_t seed = 11;
    for (int flowing = 0; flowing < 2; flowing++)
        for (int advection = 0; advection < 2; advection++) {
            double low, high;
            scene *s = scene_start(24, 9, 7);
            if (flowing) channel(s, 0);
            s->transport_desc.advection = advection ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
            s->transport_desc.inlet = 0.5;
            if (!scene_build_m(s, 3.0)) return;
            if (flowing) uniform_flow(s, 0, U);
            random_field(s, &seed);
            double limit = pd_transport_limit(&s->ctx, &s->transport);
            size_t bytes = (size_t)s->grid.total * sizeof(double);
            double *before = (double *)malloc(bytes);
            if (!CHECK(before != NULL)) return;
            memcpy(before, s->transport.c, bytes);
            CHECK_INT(pd_transport_explicit(&s->ctx, &s->transport, 1.0001 * limit), PD_RETRY);
            CHECK(memcmp(before, s->transport.c, bytes) == 0);
            CHECK(strstr(s->ctx.message, "exceeds the limit") != NULL);
            for (int k = 0; k < 100; k++) {
                double last_low, last_high;
                extremes(s, &last_low, &last_high);
                if (!step_explicit(s, limit)) return;
                extremes(s, &low, &high);
                CHECK_LE(fmin(last_low, 0.5) - 1e-14, low);
                CHECK_LE(high, fmax(last_high, 0.5) + 1e-14);
            }
            free(before);
            scene_free(s);
        }
}

/* ---- conservation and bounds ---- */

/* Masks at random, steps of up to a million explicit limits: the amount stays, with what is in carry, whatever the
 * solver's tolerance; no value leaves the range of the start. */
TEST(maximum_principle_on_random_masks)
{
    uint32_t seed = 5;
    static const double lengths[] = {1e-2, 1.0, 1e3, 1e6}, tolerances[] = {1e-2, 1e-11};
    for (int round = 0; round < 12; round++) {
        double low, high, now_low, now_high;
        scene *s = scene_start(PD_DIM == 1 ? 90 : 15, 12, 8);
        s->transport_desc.tolerance = tolerances[round % 2];
        if (!scene_grid_m(s, 1.0 + round % 3)) return;
        random_walls(s, &seed, PD_DIM == 1 ? 9 : 2 + (uint32_t)round % 3);
        if (!scene_rest(s)) return;
        random_field(s, &seed);
        double limit = pd_transport_limit(&s->ctx, &s->transport), start = pd_transport_stock(&s->ctx, &s->transport);
        extremes(s, &low, &high);
        for (int k = 0; k < 8; k++) {
            if (!step_implicit(s, limit * lengths[k % 4])) return;
            extremes(s, &now_low, &now_high);
            double slack = 10.0 * s->transport_desc.tolerance;
            if (round % 2) CHECK_LE(low - slack, now_low);
            if (round % 2) CHECK_LE(now_high, high + slack);
            CHECK_REL(pd_transport_stock(&s->ctx, &s->transport) + pd_transport_carried(&s->ctx, &s->transport), start,
                      1e-13);
        }
        /* an explicit step delivers what was owed */
        if (!step_explicit(s, limit)) return;
        CHECK(pd_transport_carried(&s->ctx, &s->transport) == 0.0);
        CHECK_REL(pd_transport_stock(&s->ctx, &s->transport), start, 1e-13);
        scene_free(s);
    }
}

/* A channel with uniform flow: what comes in less what goes out is what accumulates, in every step. */
TEST(balance_of_a_channel)
{
    uint32_t seed = 7;
    for (int axis = 0; axis < PD_DIM; axis++)
        for (int round = 0; round < 6; round++) {
            scene *s = scene_start(PD_DIM == 3 ? 8 : 14, PD_DIM == 3 ? 7 : 11, 6);
            channel(s, axis);
            s->transport_desc.advection = round % 2 ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
            s->transport_desc.inlet = 2.0;
            s->transport_desc.tolerance = round < 2 ? 1e-3 : 1e-11;
            if (!scene_build_m(s, 3.0)) return;
            uniform_flow(s, axis, round % 3 ? U : 100.0 * U);
            random_field(s, &seed);
            double limit = pd_transport_limit(&s->ctx, &s->transport), net = 0.0, passed = 0.0;
            double start = pd_transport_stock(&s->ctx, &s->transport);
            for (int k = 0; k < 6; k++) {
                double dt = limit * (k % 3 == 0 ? 1.0 : k % 3 == 1 ? 30.0 : 1e9);
                if (!(k % 3 == 0 ? step_explicit(s, dt) : step_implicit(s, dt))) return;
                net += dt * (s->transport.inflow - s->transport.outflow);
                passed += dt * fabs(s->transport.inflow);
                double held = pd_transport_stock(&s->ctx, &s->transport) + pd_transport_carried(&s->ctx, &s->transport);
                CHECK_NEAR(held - start, net, 1e-13 * (passed + start));
            }
            /* the last step is steady: the channel is full of inflow, and its flux passes both ends */
            double flux = 2.0 * pd_flow_integrate_section(&s->ctx, &s->flow, axis, s->grid.n[axis] / 2);
            if (round >= 2) CHECK_REL(s->transport.inflow, flux, 1e-8);
            if (round >= 2) CHECK_REL(s->transport.outflow, flux, 1e-8);
            scene_free(s);
        }
}

/* Source and absorption in equilibrium: c = source / absorb, and the start of it as 1 - 1/(1 + absorb dt). */
TEST(source_and_absorption)
{
    scene *s = scene_start(9, 8, 7);
    if (!scene_build_m(s, 2.0)) return;
    for (int32_t i = 0; i < s->grid.total; i++) {
        s->transport.source[i] = 3.0;
        s->transport.absorb[i] = 0.5;
    }
    if (!step_implicit(s, 0.1)) return;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) CHECK_REL(s->transport.c[i], 6.0 * (1.0 - 1.0 / 1.05), 1e-10);
    if (!step_implicit(s, 1e9)) return;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) CHECK_REL(s->transport.c[i], 6.0 - 6.0 / 1.05 / (1.0 + 0.5e9), 1e-10);
    scene_free(s);
}

/* ---- advection ---- */

/* Steady field between c = 0 in front and c = 1 behind for the Peclet number of the cell, uniform flow, as ghosts hold
 * (exp(Pe x) - 1)/(exp(Pe) - 1); the first and the last node lie at x = 0 and x = 1. */
static int boundary_layer(scene *s, int cells, double peclet)
{
    double length = cells * H;
    s->with |= WITH_FLOW;
    s->grid_desc.lo[0] = -0.5 * H;
    s->grid_desc.hi[0] = length + 0.5 * H;
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_INLET;
    s->transport_desc.tolerance = 1e-12;
    if (!scene_build_m(s, 3.0)) return 0;
    uniform_flow(s, 0, peclet * D / length);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        double side = fmin(fmax(x[0], s->grid.lo[0]), s->grid.hi[0]);
        if (s->grid.kind[i] == PD_INLET)
            s->transport.c[i] = peclet < 1e4 ? expm1(peclet * side / length) / expm1(peclet) : (side > 0.0 ? 1.0 : 0.0);
    }
    for (int k = 0; k < 3; k++)
        if (!step_implicit(s, 1e9)) return 0;
    return 1;
}

#if PD_DIM == 1
/* Exact values of (exp(Pe x) - 1)/(exp(Pe) - 1), which is phi(0) = 0, phi(1) = 1 with advection towards x = 1: textbook
 * (Patankar 1980, eq. 6.4), tabulated with nine digits. */
TEST(boundary_layer_exact)
{
    static const double peclet[4] = {1.0, 10.0, 50.0, 100.0};
    static const double at[] = {0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.98, 0.99};
    static const double phi[8][4] = {
        {6.12070246e-02, 7.80134161e-05, 2.84323108e-20, 8.19364062e-40},
        {2.03609677e-01, 8.66521376e-04, 6.30511483e-16, 3.97544974e-31},
        {3.77540669e-01, 6.69285092e-03, 1.38879439e-11, 1.92874985e-22},
        {5.89980462e-01, 4.97439268e-02, 3.05902321e-07, 9.35762297e-14},
        {8.49455012e-01, 3.67850742e-01, 6.73794700e-03, 4.53999298e-05},
        {9.22846086e-01, 6.06512795e-01, 8.20849986e-02, 6.73794700e-03},
        {9.68674762e-01, 8.18722523e-01, 3.67879441e-01, 1.35335283e-01},
        {9.84259069e-01, 9.04833097e-01, 6.06530660e-01, 3.67879441e-01},
    };
    for (int p = 0; p < 4; p++) {
        double worst[2] = {0.0, 0.0};
        for (int level = 0; level < 2; level++) {
            int cells = 200 << level;
            scene *s = scene_start(cells, 1, 1);
            if (!boundary_layer(s, cells, peclet[p])) return;
            for (int k = 0; k < 8; k++) {
                int i[PD_DIM] = {0};
                i[0] = (int)(at[k] * cells + 0.5);
                worst[level] = fmax(worst[level], fabs(s->transport.c[pd_grid_node(&s->grid, i)] - phi[k][p]));
            }
            scene_free(s);
        }
        double cell = peclet[p] / 200.0;
        NOTE("Pe = %g, of the cell %g: error %.3g, half the spacing %.3g", peclet[p], cell, worst[0], worst[1]);
        CHECK_LE(worst[0], cell * cell + 1e-8);
        CHECK_LE(worst[1], 0.3 * worst[0] + 1e-8);
    }
}
#endif

TEST(boundary_layer_bounded)
{
    for (int advection = 0; advection < 2; advection++)
        for (int power = 0; power <= 6; power++) {
            double low, high;
            scene *s = scene_start(40, PD_DIM == 3 ? 4 : 9, 3);
            s->transport_desc.advection = advection ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
            if (!boundary_layer(s, 40, 40.0 * pow(10.0, power))) return;
            extremes(s, &low, &high);
            double least = 0.0, most = 0.0; /* on the sides */
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] != PD_INLET) continue;
                least = fmin(least, s->transport.c[i]);
                most = fmax(most, s->transport.c[i]);
            }
            CHECK_LE(least - 1e-9, low);
            CHECK_LE(high, most + 1e-9);
            scene_free(s);
        }
}

/* Fronts of inflow at a cell Peclet number of a million: between the values at hand in every step. */
TEST(front_bounded)
{
    uint32_t seed = 23;
    for (int advection = 0; advection < 2; advection++)
        for (int random = 0; random < 2; random++) {
            scene *s = scene_start(PD_DIM == 3 ? 16 : 40, PD_DIM == 3 ? 6 : 9, 5);
            channel(s, 0);
            s->transport_desc.advection = advection ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
            s->transport_desc.inlet = 1.0;
            s->transport_desc.diffusivity = 1e-6 * U * H;
            if (!scene_build_m(s, 3.0)) return;
            uniform_flow(s, 0, U);
            if (random) random_field(s, &seed);
            for (int k = 0; k < 10; k++) {
                double low, high;
                if (!step_implicit(s, H / U * (k % 3 == 2 ? 20.0 : 1.0 + k % 3))) return;
                extremes(s, &low, &high);
                CHECK_LE(-1e-9, low);
                CHECK_LE(high, 1.0 + 1e-9);
            }
            scene_free(s);
        }
}

#if PD_DIM < 3
/* A round pulse of `width` cells, away from the walls, travels 40 h in explicit steps; how far its centre then is from
 * where the flow has carried it [h], and its largest value. */
static void travel(int axis, int width, double m, pd_advection advection, double *away, double *peak)
{
    int n[2];
    n[0] = n[1] = 15 * width; /* no tail of the pulse meets walls, where families are cut */
    n[axis] = 10 * width + 70;
    scene *s = scene_start(n[0], n[1], 1);
    double mass = 0.0, centre = 0.0, low = 0.0, speed = U;
    channel(s, axis);
    s->transport_desc.advection = advection;
    s->transport_desc.diffusivity = 0.0;
    if (!scene_build_m(s, m)) return;
    uniform_flow(s, axis, speed);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], r2 = 0.0;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < PD_DIM; d++) {
            double at = (x[d] / H - (d == axis ? 5.0 : 7.5) * width) / width;
            r2 += at * at;
        }
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = exp(-0.5 * r2);
    }
    int steps = (int)ceil(40.0 * H / speed / (0.3 * pd_transport_limit(&s->ctx, &s->transport)));
    for (int k = 0; k < steps; k++) {
        if (!step_explicit(s, 40.0 * H / speed / steps)) return;
        extremes(s, &low, peak);
        CHECK_LE(-1e-12, low);
        CHECK_LE(*peak, 1.0);
    }
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        mass += s->transport.c[i];
        centre += s->transport.c[i] * x[axis];
    }
    *away = centre / mass / H - 5.0 * width - 40.0;
    scene_free(s);
}

/* The limiter is not symmetric about a pulse that disperses, so that its centre is a matter of resolution: widths of
 * two horizons and more stay within a tenth of a cell. */
TEST(pulse_arrives)
{
    for (int axis = 0; axis < PD_DIM; axis++)
        for (int m = 1; m <= 3; m += 2) {
            double away[2] = {1.0, 1.0}, peak[2] = {0.0, 0.0};
            for (int upwind = 0; upwind < 2; upwind++)
                travel(axis, m == 1 ? 4 : 6, m, upwind ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED, &away[upwind],
                       &peak[upwind]);
            NOTE("axis %d, m = %d: centre off by %.3g h, peak %.3f; upwind %.3g h, %.3f", axis, m, away[0], peak[0],
                 away[1], peak[1]);
            CHECK_NEAR(away[0], 0.0, 0.1);
            CHECK_NEAR(away[1], 0.0, 1e-4);
            CHECK_LE(peak[1] + 0.2, peak[0]);
            CHECK_LE(0.8, peak[0]);
        }
}
#endif

#if PD_DIM == 2
static void plug(void *user, const double *x, double *u)
{
    (void)user;
    (void)x;
    u[0] = U;
    u[1] = 0.0;
}

/* Round a disc, in a flow from the solver, at a cell Peclet number of a million. */
TEST(bounded_around_a_disc)
{
    uint32_t seed = 31;
    for (int advection = 0; advection < 2; advection++) {
        pd_steady steady;
        pd_steady_desc steady_desc;
        pd_steady_result flow_result;
        double low, high;
        scene *s = scene_start(36, 20, 1);
        channel(s, 0);
        s->shapes[0].type = PD_SHAPE_BALL;
        s->shapes[0].radius = 4.2 * H;
        s->shapes[0].a[0] = 14.0 * H;
        s->shapes[0].a[1] = 9.0 * H;
        s->grid_desc.wall = &s->shapes[0];
        s->flow_desc.inlet = plug;
        s->transport_desc.advection = advection ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
        s->transport_desc.inlet = 1.0;
        s->transport_desc.diffusivity = 1e-6 * U * H;
        memset(&steady_desc, 0, sizeof steady_desc);
        steady_desc.tolerance = 1e-11;
        if (!scene_build_m(s, 3.0)) return;
        CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &steady_desc, &steady));
        CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &steady, &flow_result));
        random_field(s, &seed);
        for (int k = 0; k < 8; k++) {
            if (!step_implicit(s, H / U * pow(10.0, k % 4))) return;
            extremes(s, &low, &high);
            CHECK_LE(-2e-9, low);
            CHECK_LE(high, 1.0 + 2e-9);
        }
        pd_steady_free(&s->ctx, &steady);
        scene_free(s);
    }
}
#endif

/* ---- Newton's method ---- */

static double one_at_rest(void *user, const double *x)
{
    (void)user;
    return x[0] > 0.0 ? 1.0 : 0.5;
}

/* Limited fluxes of the field c + share x, into out. */
static void limited_at(scene *s, const double *c, double share, const double *x, double *out)
{
    for (int32_t i = 0; i < s->grid.total; i++) s->transport.probe[i] = c[i] + share * x[i];
    pd_ghosts_set_scalar(&s->bonds.ghosts, s->transport.probe);
    pdi_limiter_update(&s->ctx, &s->transport.limiter, s->transport.probe, 1e-3);
    pdi_flux_anti(&s->ctx, &s->transport.flux, s->transport.probe, out);
}

/* Fields that are fainter by powers of two have the derivative of the field itself, bit for bit, as long as squares of
 * their steps are normal numbers; below that it stays of its size. */
static void derivative_of_faint_fields(scene *s, double *x, const double *by, double largest)
{
    static const int powers[] = {100, 440, 500, 510, 515, 520, 530, 540, 560, 700};
    pd_transport *t = &s->transport;
    double *again = t->old, *slope_by = t->probe, *keep_by = t->source;
    for (int k = 0, power = 0; k < 10; power = powers[k++]) {
        double least = ldexp(1e-3, -powers[k]);
        for (int32_t i = 0; i < s->grid.total; i++) t->c[i] = ldexp(t->c[i], power - powers[k]);
        pdi_limiter_update(&s->ctx, &t->limiter, t->c, least);
        pdi_limiter_derive(&s->ctx, &t->limiter, t->c, x, least, keep_by, slope_by);
        pdi_flux_anti_by(&s->ctx, &t->flux, t->c, x, keep_by, slope_by, again);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            if (powers[k] < 450) CHECK_NEAR(again[i], by[i], 0.0);
            else CHECK_LE(fabs(again[i]), 2.0 * largest);
        }
    }
}

/* What is kept of the derivative gives the same up to the rounding of single precision, which is all there is of it. */
static void derivative_kept(scene *s, const double *x, const double *by, double largest)
{
    pd_transport *t = &s->transport;
    double *again = t->old, *slope_by = t->probe, *keep_by = t->source, off = 0.0;
    size_t entries = 3 * (size_t)(s->stencil.count / 2) * (size_t)s->grid.total;
    if (!t->flux.flux) return;
    t->flux.bend.kept = (float *)malloc(entries * sizeof(float));
    if (!CHECK(t->flux.bend.kept != NULL)) return;
    memset(t->flux.bend.kept, 0xff, entries * sizeof(float)); /* no numbers: who reads what was not kept shows */
    pdi_flux_differentiate(&s->ctx, &t->flux, t->c);
    pdi_flux_anti_by(&s->ctx, &t->flux, t->c, x, keep_by, slope_by, again);
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID && !(fabs(again[i] - by[i]) <= off)) off = fabs(again[i] - by[i]);
    CHECK_LE(off, 1e-6 * largest);
    CHECK(off > 0.0);
    free(t->flux.bend.kept);
    t->flux.bend.kept = NULL;
}

/* The derivative of the limited fluxes along a random direction is what central differences give: beside inlets,
 * outlets, closed bonds, held walls, images, in whole families. */
TEST(derivative_of_limited_fluxes)
{
    uint32_t seed = 77;
    for (int round = 0; round < 9; round++) {
        scene *s = scene_start(PD_DIM == 1 ? 200 : 40, 13, 9);
        channel(s, 0);
        s->transport_desc.inlet = 0.5;
        s->transport_desc.diffusivity = 1e-2 * U * H;
        if (round % 3 == 1) s->transport_desc.held = one_at_rest;
        if (round % 3 == 2 && PD_DIM > 1) s->grid_desc.side[2] = s->grid_desc.side[3] = PD_SIDE_PERIODIC;
        if (!scene_grid_m(s, 1.0 + round / 3)) return;
        if (round % 3 < 2) random_walls(s, &seed, 40);
        if (!scene_rest(s)) return;
        pd_transport *t = &s->transport;
        uniform_flow(s, 0, U);
        random_field(s, &seed);
        if (!CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, t))) return;
        double *x = t->work, *more = t->old, *less = t->rhs, *by = t->carry, *slope_by = t->probe, *keep_by = t->source;
        double largest = 0.0, off = 0.0, share = 1e-6;
        for (int32_t i = 0; i < s->grid.total; i++)
            x[i] = s->grid.kind[i] == PD_FLUID ? random_share(&seed) - 0.5 : 0.0;
        CHECK_OK(&s->ctx, pdi_flux_refresh(&s->ctx, &t->flux));
        limited_at(s, t->c, share, x, more);
        limited_at(s, t->c, -share, x, less);
        limited_at(s, t->c, 0.0, x, t->anti);
        pd_ghosts_set_scalar(&s->bonds.ghosts, t->c);
        pd_ghosts_set_scalar(&s->bonds.ghosts, x);
        pdi_limiter_derive(&s->ctx, &t->limiter, t->c, x, 1e-3, keep_by, slope_by);
        pdi_flux_anti_by(&s->ctx, &t->flux, t->c, x, keep_by, slope_by, by);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            largest = fmax(largest, fabs(by[i]));
            off = fmax(off, fabs(by[i] - 0.5 * (more[i] - less[i]) / share));
        }
        CHECK(largest > 0.1 * U / H);
        CHECK_LE(off, 1e-7 * largest);
        derivative_kept(s, x, by, largest);
        if (round % 3 != 1) derivative_of_faint_fields(s, x, by, largest);
        CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, t, PD_OK));
        scene_free(s);
    }
}

/* A channel is rinsed until nothing is left whose squares are numbers. No step fails on the way, and no field leaves
 * the bounds of the start by more than the tolerance of its solve. */
TEST(washed_out)
{
    for (int upwind = 0; upwind < 2; upwind++) {
        scene *s = scene_start(16, PD_DIM == 3 ? 2 : 6, 2);
        double low = 0.0, high = 1.0, least = 0.0;
        int after = 0; /* steps with next to nothing */
        channel(s, 0);
        s->transport_desc.advection = upwind ? PD_ADVECTION_UPWIND : PD_ADVECTION_LIMITED;
        if (!scene_build_m(s, 2.0)) return;
        uniform_flow(s, 0, U);
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = 1.0;
        for (int step = 0; step < 300 && after < 20; step++) {
            if (!step_implicit(s, 16.0 * H / U)) return;
            extremes(s, &low, &high);
            least = fmin(least, low);
            after += high <= 1e-146;
        }
        CHECK_INT(after, 20);
        CHECK_LE(-least, 1e-9);
        scene_free(s);
    }
}

/* A field and its negative are one problem of one size: the largest at the start. */
TEST(negative_field)
{
    double first[4000];
    for (int sign = 1; sign >= -1; sign -= 2) {
        uint32_t seed = 5;
        scene *s = scene_start(24, 6, 4);
        double low = 0.0, high = 0.0;
        channel(s, 0);
        if (!scene_build_m(s, 2.0) || !CHECK(s->grid.total <= 4000)) return;
        uniform_flow(s, 0, U);
        random_field(s, &seed);
        for (int32_t i = 0; i < s->grid.total; i++) s->transport.c[i] *= 3.0 * sign;
        extremes(s, &low, &high);
        if (!step_implicit(s, 2.0 * H / U)) return;
        CHECK_REL(s->transport.size, fmax(-low, high), 1e-12);
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (sign < 0) CHECK_NEAR(s->transport.c[i], -first[i], 1e-12);
            first[i] = s->transport.c[i];
        }
        scene_free(s);
    }
}

/* ---- the same bits, bad input ---- */

TEST(threads_change_no_bit)
{
    double *first = NULL;
    size_t bytes;
    for (int threads = 1; threads <= 4; threads *= 2) {
        uint32_t seed = 3;
        scene *s = scene_start(PD_DIM == 1 ? 3000 : PD_DIM == 2 ? 50 : 10, PD_DIM == 2 ? 30 : 8, 6);
        channel(s, 0);
        s->transport_desc.inlet = 1.0;
        s->ctx.threads = threads;
        if (!scene_build_m(s, 3.0)) return;
        uniform_flow(s, 0, 3.0 * U);
        random_field(s, &seed);
        if (!step_implicit(s, H / U)) return;
        bytes = (size_t)s->grid.total * sizeof(double);
        if (!first) {
            first = (double *)malloc(bytes);
            if (!CHECK(first != NULL)) return;
            memcpy(first, s->transport.c, bytes);
        }
        CHECK(memcmp(first, s->transport.c, bytes) == 0);
        scene_free(s);
    }
    free(first);
}

TEST(bad_input)
{
    scene *s = scene_start(8, 7, 6);
    if (!scene_build_m(s, 2.0)) return;
    for (int k = 0; k < 8; k++) {
        static const double wrong[2] = {-1e-9, (double)NAN};
        pd_transport_desc desc = s->transport_desc;
        pd_transport other;
        double *value[4];
        value[0] = &desc.diffusivity;
        value[1] = &desc.inlet;
        value[2] = &desc.initial;
        value[3] = &desc.tolerance;
        *value[k / 2] = wrong[k % 2];
        CHECK_INT(pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &desc, &other), PD_ERR_ARGUMENT);
        CHECK(strncmp(s->ctx.message, "transport: ", 11) == 0);
        pd_transport_free(&s->ctx, &other);
    }
    static const double steps[] = {0.0, -1.0, (double)NAN};
    for (int k = 0; k < 3; k++) {
        CHECK_INT(pd_transport_implicit(&s->ctx, &s->transport, steps[k], &s->result), PD_ERR_ARGUMENT);
        CHECK_INT(pd_transport_explicit(&s->ctx, &s->transport, steps[k]), PD_ERR_ARGUMENT);
    }
    CHECK_INT(pd_transport_implicit(&s->ctx, &s->transport, HUGE_VAL, &s->result), PD_ERR_ARGUMENT);
    /* nothing dissolved: the step is exact at once */
    if (!step_implicit(s, 1.0)) return;
    CHECK_INT(s->result.krylov, 0);
    CHECK(pd_transport_stock(&s->ctx, &s->transport) == 0.0);
    scene_free(s);
}

#if PD_DIM == 1
#define OF_DIM ENTRY(cosine_is_exact_for_nearest_neighbours) ENTRY(boundary_layer_exact) \
    SLOW_ENTRY_IF(PD_DIM > 1, pulse_arrives)
#elif PD_DIM == 2
#define OF_DIM ENTRY(bounded_around_a_disc) SLOW_ENTRY_IF(PD_DIM > 1, pulse_arrives)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(variance_of_a_drop) ENTRY(second_order_in_space) ENTRY(cosine_in_a_closed_box) ENTRY(steady_linear)
          OF_DIM ENTRY(explicit_limit) ENTRY(maximum_principle_on_random_masks) ENTRY(balance_of_a_channel)
          ENTRY(source_and_absorption) ENTRY(boundary_layer_bounded) ENTRY(front_bounded)
          ENTRY(derivative_of_limited_fluxes) ENTRY(washed_out) ENTRY(negative_field)
          ENTRY(threads_change_no_bit) ENTRY(bad_input))
