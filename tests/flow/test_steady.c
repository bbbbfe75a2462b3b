/* steady: convergence from rest, flux through sections, exact profiles, re-solves, threads.
 * dims: 2 3 */
#include "fixture.h"
#include "flow/inlet_flux.h"
#include <stdlib.h>

#define RHO 1000.0
#define MU 1e-3
#define RADIUS 150e-6 /* [m] half-width of the channel, radius of the tube */

static scene test_scene, other_scene;

/* Fully developed: parabola in y (2D), paraboloid in r (3D). */
static void profile(void *user, const double *x, double *u)
{
    const scene *s = (const scene *)user;
    double r2 = 0.0;
    for (int d = 1; d < PD_DIM; d++) {
        r2 += x[d] * x[d] / (RADIUS * RADIUS);
        u[d] = 0.0;
    }
    u[0] = s->mean * (PD_DIM == 2 ? 1.5 : 2.0) * fmax(1.0 - r2, 0.0);
}

static double exact_drop(const scene *s) { return (PD_DIM == 2 ? -3.0 : -8.0) * MU * s->mean / (RADIUS * RADIUS); }

static int horizon = 3;                            /* m of the scenes that follow */
static double reference_factor[2] = {1.0, 1.0};    /* of the reference speed and length */
#if PD_DIM == 3
static int developed; /* 1: the inlet is told to have developed flow */
#endif

/* Channel or tube from lo to hi along x, with a pin 0 .. 400 um by 80 um if asked for. */
static int tube_build(scene *s, double h, double lo, double hi, double mean, int pin, double tolerance)
{
    scene_reset(s);
    s->mean = mean;
    s->shapes[0].type = PD_SHAPE_BOX;
    s->shapes[0].b[0] = 400e-6;
    s->shapes[1].type = PD_SHAPE_CYLINDER;
    s->shapes[1].radius = RADIUS;
    s->shapes[2].type = PD_SHAPE_COMPLEMENT;
    s->shapes[2].child[0] = 1;
    s->shapes[2].child_count = 1;
    s->stencil_desc.m = horizon;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h;
        s->grid_desc.lo[d] = d ? -RADIUS : lo;
        s->grid_desc.hi[d] = d ? RADIUS : hi;
        if (d) s->shapes[0].b[d] = 40e-6;
        if (d) s->shapes[0].a[d] = -40e-6;
    }
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    if (pin) s->grid_desc.solid = &s->shapes[0];
    if (PD_DIM == 3) s->grid_desc.wall = &s->shapes[2];
    s->with = WITH_FLOW | WITH_STEADY;
    s->flow_desc.rho = RHO;
    s->flow_desc.mu = MU;
    s->flow_desc.report_speed = mean * reference_factor[0];
    s->flow_desc.report_length = 2.0 * RADIUS * reference_factor[1];
    s->flow_desc.inlet = profile;
    s->flow_desc.inlet_user = s;
#if PD_DIM == 3
    s->flow_desc.developed_sides = developed;
#endif
    s->steady_desc.tolerance = tolerance;
    return scene_build(s);
}

#if PD_DIM == 2
static void start_from_profile(scene *s)
{
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM], u[PD_DIM];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&s->grid, node, x);
        profile(s, x, u);
        for (int d = 0; d < PD_DIM; d++) s->flow.u[(int64_t)d * s->grid.total + node] = u[d];
        s->flow.p[node] = exact_drop(s) / RHO * (x[0] - s->grid.hi[0]);
    }
}
#endif

/* Solve and check what the result says against the residual of the state. */
static int solve(scene *s, pd_steady_result *result)
{
    int64_t total = s->grid.total, split = PD_DIM * total;
    double momentum = 0.0, continuity = 0.0;
    double strain = s->flow.velocity_scale / s->flow.length_scale,
           force = strain * (s->flow.velocity_scale + s->flow.nu / s->flow.length_scale);
    if (!CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &s->steady, result))) return 0;
    CHECK_INT(result->converged, 1);
    double *r = (double *)calloc((size_t)(split + total), sizeof *r);
    if (!CHECK(r != NULL)) return 0;
    pdi_flow_assemble_residual(&s->ctx, &s->flow, r, r + split);
    for (int64_t k = 0; k < split; k++) momentum = fmax(momentum, fabs(r[k]) / force);
    for (int64_t k = split; k < split + total; k++) continuity = fmax(continuity, fabs(r[k]) / strain);
    free(r);
    CHECK_LE(momentum, s->steady.desc.tolerance);
    CHECK_LE(continuity, s->steady.desc.tolerance);
    double reference = s->flow.reference_speed / s->flow.reference_length;
    CHECK_REL(result->momentum * reference * (s->flow.reference_speed + s->flow.nu / s->flow.reference_length),
              momentum * force, 1e-6);
    CHECK_REL(result->residual_over_tolerance, fmax(momentum, continuity) / s->steady.desc.tolerance, 1e-6);
    return 1;
}

/* Relative L2 difference of the velocities of fluid nodes from the profile. */
static double profile_error(const scene *s)
{
    double error = 0.0, size = 0.0;
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM], u[PD_DIM];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&s->grid, node, x);
        profile((void *)(uintptr_t)s, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            double off = s->flow.u[(int64_t)d * s->grid.total + node] - u[d];
            error += off * off;
            size += u[d] * u[d];
        }
    }
    return sqrt(error / size);
}

/* dp/dx [Pa/m] on the axis, halfway along. */
static double axis_drop(const scene *s)
{
    int i[PD_DIM], j[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) i[d] = j[d] = s->grid.n[d] / 2;
    j[0]--;
    return RHO * (s->flow.p[pd_grid_node(&s->grid, i)] - s->flow.p[pd_grid_node(&s->grid, j)]) / s->grid.h[0];
}

/* Relative difference of two states of one grid. */
static double state_difference(const scene *a, const scene *b)
{
    double worst = 0.0, pressure = 0.0, pressure_size = 0.0;
    for (int32_t node = 0; node < a->grid.total; node++) {
        if (a->grid.kind[node] != PD_FLUID) continue;
        for (int d = 0; d < PD_DIM; d++) {
            int64_t k = (int64_t)d * a->grid.total + node;
            worst = fmax(worst, fabs(a->flow.u[k] - b->flow.u[k]) / a->mean);
        }
        pressure = fmax(pressure, fabs(a->flow.p[node] - b->flow.p[node]));
        pressure_size = fmax(pressure_size, fabs(a->flow.p[node]));
    }
    return fmax(worst, pressure / pressure_size);
}

/* Largest relative difference of a section flux from that of the first section. */
static double section_spread(scene *s)
{
    double worst = 0.0, first = pd_flow_integrate_section(&s->ctx, &s->flow, 0, 1);
    for (int index = 2; index < s->grid.n[0]; index++)
        worst = fmax(worst, fabs(pd_flow_integrate_section(&s->ctx, &s->flow, 0, index) / first - 1.0));
    return worst;
}

#if PD_DIM == 2
static int build_pin(scene *s) { return tube_build(s, 10e-6, -80e-6, 480e-6, 0.236, 1, 1e-8); }

TEST(pin_from_rest)
{
    scene *s = &test_scene, *o = &other_scene;
    pd_steady_result result;
    if (!build_pin(s) || !solve(s, &result)) return;
    CHECK_LE(result.evaluations, 1000);
    CHECK_INT(s->flow.evaluations, result.evaluations + 1); /* and the one of this test */
    CHECK_LE(section_spread(s), 1e-6);
    /* from another start: the same answer */
    if (!build_pin(o)) return;
    start_from_profile(o);
    if (!solve(o, &result)) return;
    CHECK_LE(state_difference(s, o), 1e-6);
    scene_free(s);
    scene_free(o);
}

/* The flow mirrors about the axis as the scene does. */
TEST(pin_is_symmetric)
{
    scene *s = &test_scene;
    pd_steady_result result;
    if (!build_pin(s) || !solve(s, &result)) return;
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[2];
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_index(&s->grid, node, i);
        i[1] = s->grid.n[1] - 1 - i[1];
        int32_t image = pd_grid_node(&s->grid, i);
        CHECK_NEAR(s->flow.u[node], s->flow.u[image], 1e-7 * s->mean);
        CHECK_NEAR(s->flow.u[s->grid.total + node], -s->flow.u[s->grid.total + image], 1e-7 * s->mean);
    }
    scene_free(s);
}

TEST(poiseuille_from_rest)
{
    scene *s = &test_scene;
    pd_steady_result result;
    for (double h = 10e-6; h > 4e-6; h *= 0.5) {
        if (!tube_build(s, h, 0.0, 300e-6, 0.236, 0, 1e-8) || !solve(s, &result)) return;
        CHECK_LE(profile_error(s), 1e-6);
        CHECK_REL(axis_drop(s), exact_drop(s), 1e-6);
        CHECK_LE(result.evaluations, 1000);
        scene_free(s);
    }
}

/* Reference values scale reports alone: the same bits, whatever they are. */
TEST(references_change_no_bit)
{
    static const double factor[4][2] = {{1e3, 1.0}, {1e-3, 1.0}, {1.0, 1e3}, {1e-3, 1e-3}};
    scene *s = &test_scene, *o = &other_scene;
    pd_steady_result result, other;
    if (!build_pin(s) || !solve(s, &result)) return;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 2; i++) reference_factor[i] = factor[k][i];
        int built = build_pin(o);
        reference_factor[0] = reference_factor[1] = 1.0;
        if (!built || !solve(o, &other)) return;
        CHECK_INT(other.newton, result.newton);
        CHECK_INT(other.krylov, result.krylov);
        CHECK(memcmp(s->flow.u, o->flow.u, (size_t)PD_DIM * (size_t)s->grid.total * sizeof(double)) == 0);
        CHECK(memcmp(s->flow.p, o->flow.p, (size_t)s->grid.total * sizeof(double)) == 0);
        CHECK_REL(other.continuity, result.continuity * (factor[k][1] / factor[k][0]), 1e-12);
        scene_free(o);
    }
    scene_free(s);
}

/* Creeping flow is linear: the velocity over its mean and the pressure over the viscous one do not depend on Re. */
TEST(creeping_pin)
{
    scene *s = &test_scene, *o = &other_scene;
    pd_steady_result result;
    for (int k = 0; k < 6; k++) {
        double h = k < 4 ? 20e-6 : k == 4 ? 30e-6 : 10e-6, largest = 0.0;
        horizon = k < 4 ? k + 1 : 3;
        for (double re = 1e-9; re < 3.0; re *= 1e3) {
            double mean = re * (MU / RHO) / (2.0 * RADIUS);
            scene *now = re < 1e-8 ? o : s;
            if (!tube_build(now, h, -480e-6, 900e-6, mean, 1, 1e-6) || !solve(now, &result)) return;
            CHECK_LE(result.evaluations, 500);
            CHECK_LE(section_spread(now), 1e-5);
            if (now == o) continue;
            largest = 0.0;
            for (int32_t i = 0; i < PD_DIM * s->grid.total; i++)
                largest = fmax(largest, fabs(s->flow.u[i] / s->mean - o->flow.u[i] / o->mean));
            CHECK_LE(largest, 1e-5 + 0.05 * re);
            scene_free(s);
        }
        scene_free(o);
    }
    horizon = 3;
}

/* Lid of a box. */
static void slide(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = x[1] > 1.0 - 1e-9 ? 1.0 : 0.0;
    u[1] = 0.0;
}

static void uniform(void *user, const double *x, double *u)
{
    (void)user;
    (void)x;
    u[0] = 1.0;
    u[1] = 0.0;
}

/* A lid-driven box (body 0) or a disc of diameter 1 in a stream between free sides (1) or walls (2), at rest. */
static int vortex_build(scene *s, double h, double re, int body)
{
    pd_stencil_desc sd;
    pd_flow_desc fd;
    pd_steady_desc dd;
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    memset(&fd, 0, sizeof fd);
    memset(&dd, 0, sizeof dd);
    pd_ctx_init(&s->ctx);
    s->mean = 1.0;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 0.5;
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = h;
        s->grid_desc.lo[d] = body ? (d || body == 1 ? -6.0 : -3.0) : 0.0;
        s->grid_desc.hi[d] = body ? (d ? 6.0 : 12.0) : 1.0;
        if (body == 2 && d) s->grid_desc.hi[d] = -(s->grid_desc.lo[d] = -2.0);
    }
    s->grid_desc.shapes = s->shapes;
    s->grid_desc.solid = body ? &s->shapes[0] : NULL;
    if (body) {
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
        fd.inlet = uniform;
    } else fd.wall = slide;
    if (body == 1) s->grid_desc.side[2] = s->grid_desc.side[3] = PD_SIDE_MIRROR;
    fd.rho = 1.0;
    fd.mu = 1.0 / re;
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &sd, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)) &&
           CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) &&
           CHECK_OK(&s->ctx, pd_flow_build(&s->ctx, &s->grid, &s->bonds, &fd, &s->flow)) &&
           CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &dd, &s->steady));
}

static void waves(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 1.0 + 0.3 * sin(2.0 * 3.14159265358979323846 * x[1]);
    u[1] = 0.2 * cos(2.0 * 3.14159265358979323846 * x[1]);
}

/* An inlet holds its velocity on the side of the box: what enters is that to rounding, and the velocity that the nodes
 * lead to on the side differs from it with the second power of the spacing. */
static double inlet_error(int n)
{
    scene *s = &test_scene;
    pd_steady_result result;
    double worst = 0.0, pushed, gross;
    pd_stencil_desc sd;
    pd_flow_desc fd;
    pd_steady_desc dd;
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    memset(&fd, 0, sizeof fd);
    memset(&dd, 0, sizeof dd);
    pd_ctx_init(&s->ctx);
    sd.h[0] = sd.h[1] = 1.0 / n;
    s->grid_desc.hi[0] = s->grid_desc.hi[1] = 1.0;
    s->grid_desc.shapes = s->shapes;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->grid_desc.side[2] = s->grid_desc.side[3] = PD_SIDE_PERIODIC;
    fd.rho = 1.0;
    fd.mu = 0.2;
    fd.inlet = waves;
    dd.tolerance = 1e-10;
    if (!CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &sd, &s->stencil)) ||
        !CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)) ||
        !CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) ||
        !CHECK_OK(&s->ctx, pd_flow_build(&s->ctx, &s->grid, &s->bonds, &fd, &s->flow)) ||
        !CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &dd, &s->steady)))
        return 1.0;
    solve(s, &result);
    double taken = pdi_inlet_flux_integrate(&s->ctx, &s->flow, &pushed, &gross);
    CHECK_NEAR(pushed, 1.0, 1e-12);
    CHECK_NEAR(taken, 1.0, 1e-8);
    CHECK_NEAR(pd_flow_integrate_section(&s->ctx, &s->flow, 0, n / 2), 1.0, 1e-8);
    for (int j = 0; j < n; j++) {
        int i[PD_DIM];
        double x[PD_DIM], u[PD_DIM];
        i[0] = 0;
        i[1] = j;
        int32_t node = pd_grid_node(&s->grid, i);
        pd_grid_position(&s->grid, node, x);
        waves(NULL, x, u);
        for (int d = 0; d < PD_DIM; d++) {
            const double *v = s->flow.u + (int64_t)d * s->grid.total + node;
            worst = fmax(worst, fabs((35.0 * v[0] - 35.0 * v[1] + 21.0 * v[2] - 5.0 * v[3]) / 16.0 - u[d]));
        }
    }
    NOTE("%d cells: %.3g, %d evaluations", n, worst, (int)result.evaluations);
    scene_free(s);
    return worst;
}

TEST(inlet_on_its_side)
{
    double coarse = inlet_error(16), fine = inlet_error(32);
    CHECK_LE(1.8, log(coarse / fine) / log(2.0));
}

/* Vortices that are shut off, from rest and without a knob. */
TEST(vortices_from_rest)
{
    static const struct {
        double h, re;
        int body;
    } given[] = {
        {1.0 / 32, 400.0, 0}, {1.0 / 32, 1000.0, 0}, {1.0 / 48, 1000.0, 0}, {1.0 / 32, 3200.0, 0},
        {0.25, 40.0, 1}, {0.25, 40.0, 2}, {0.25, 100.0, 1}};
    scene *s = &test_scene;
    pd_steady_result result;
    for (int k = 0; k < 7; k++) {
        if (!vortex_build(s, given[k].h, given[k].re, given[k].body)) return;
        solve(s, &result);
        CHECK_INT(s->steady.krylov.chunk_count, 0); /* what the basis took is given back */
        NOTE("h = %g, Re = %g, body %d: %d Newton steps, %d evaluations", given[k].h, given[k].re, given[k].body,
             result.newton, (int)result.evaluations);
        scene_free(s);
    }
}

/* A tolerance that rounding forbids ends with a status, soon, and the state is what can be had. */
TEST(no_progress)
{
    scene *s = &test_scene;
    pd_steady_result result;
    if (!tube_build(s, 20e-6, 0.0, 300e-6, 0.0236, 0, 1e-15)) return;
    CHECK_INT(pd_steady_solve(&s->ctx, &s->steady, &result), PD_NOT_CONVERGED);
    CHECK_LE(result.newton, 80);
    CHECK_LE(result.residual_over_tolerance, 1e5);
    CHECK_LE(1.0, result.residual_over_tolerance);
    CHECK_LE(profile_error(s), 1e-9);
    scene_free(s);
}

/* Some surface nodes of the pin dissolve: the old state leads to the state that a start from rest finds. */
TEST(resolve_after_dissolution)
{
    scene *s = &test_scene, *o = &other_scene;
    pd_steady_result result;
    int32_t changed[64], count = 0;
    if (!build_pin(s) || !build_pin(o) || !solve(s, &result)) return;
    int64_t from_rest = result.evaluations;
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[2];
        pd_grid_index(&s->grid, node, i);
        if (s->grid.kind[node] != PD_SOLID || s->grid.kind[node + s->grid.stride[1]] != PD_FLUID || i[0] % 5) continue;
        changed[count++] = node;
    }
    CHECK(count > 4);
    for (int pass = 0; pass < 2; pass++) {
        scene *now = pass ? o : s;
        for (int32_t k = 0; k < count; k++) pdi_grid_set_fluid(&now->grid, changed[k]);
        CHECK_OK(&now->ctx, pd_bonds_update(&now->ctx, changed, count, &now->bonds));
        CHECK_OK(&now->ctx, pd_flow_update(&now->ctx, changed, count, &now->flow));
        if (!solve(now, &result)) return;
        if (!pass) CHECK_LE(result.evaluations, from_rest);
        CHECK_LE(section_spread(now), 1e-6);
    }
    CHECK_LE(state_difference(s, o), 1e-6);
    scene_free(s);
    scene_free(o);
}
#else
/* Flow through a short tube whose wall is cut by the lattice. An inlet that is told to be developed: the paraboloid is
 * an exact discrete solution. Else what enters is the sum over the faces of cells, which misses pi R^2 by the square of
 * the spacing. */
TEST(hagen_poiseuille)
{
    scene *s = &test_scene;
    pd_steady_result result;
    double error[2] = {0.0, 0.0};
    for (int cells = 6; cells <= 12; cells += 3) { /* R/h */
        developed = 1;
        if (!tube_build(s, RADIUS / cells, 0.0, RADIUS, 0.0236, 0, 1e-9) || !solve(s, &result)) return;
        CHECK_LE(profile_error(s), 1e-9);
        CHECK_REL(axis_drop(s), exact_drop(s), 1e-9);
        CHECK_LE(section_spread(s), 1e-8);
        scene_free(s);
        developed = 0;
        if (!tube_build(s, RADIUS / cells, 0.0, RADIUS, 0.0236, 0, 1e-9) || !solve(s, &result)) return;
        error[cells > 6] = profile_error(s);
        CHECK_LE(section_spread(s), 1e-8);
        scene_free(s);
    }
    NOTE("what enters by faces: error %.3g at 6 cells to the radius, %.3g at 12", error[0], error[1]);
    CHECK_LE(error[1], error[0] / 3.4); /* 4: second order */
}
#endif

TEST(threads_change_no_bit)
{
    scene *s = &test_scene, *o = &other_scene;
    pd_steady_result result, again;
    double h = PD_DIM == 2 ? 10e-6 : 30e-6, lo = PD_DIM == 2 ? -80e-6 : -90e-6, hi = PD_DIM == 2 ? 480e-6 : 510e-6;
    double mean = PD_DIM == 2 ? 0.236 : 0.0236;
    if (!tube_build(s, h, lo, hi, mean, PD_DIM == 2, 1e-4)) return;
    if (!tube_build(o, h, lo, hi, mean, PD_DIM == 2, 1e-4)) return;
    s->ctx.threads = 1;
    o->ctx.threads = 2;
    if (!solve(s, &result) || !solve(o, &again)) return;
    CHECK_INT(again.krylov, result.krylov);
    CHECK(memcmp(s->flow.u, o->flow.u, (size_t)PD_DIM * (size_t)s->grid.total * sizeof(double)) == 0);
    CHECK(memcmp(s->flow.p, o->flow.p, (size_t)s->grid.total * sizeof(double)) == 0);
    CHECK_NEAR(state_difference(s, o), 0.0, 0.0);
    scene_free(s);
    scene_free(o);
}

/* The limit of Newton steps is honoured, and the start from the exact answer ends at once. */
TEST(limits)
{
    scene *s = &test_scene;
    pd_steady_result result;
    pd_steady_desc wrong;
    pd_steady other;
    double h = PD_DIM == 2 ? 10e-6 : 25e-6;
    if (!tube_build(s, h, 0.0, 300e-6, 0.0236, 0, 1e-9)) return;
    s->steady.desc.max_newton = 1;
    CHECK_INT(pd_steady_solve(&s->ctx, &s->steady, &result), PD_NOT_CONVERGED);
    CHECK_INT(result.newton, 1);
    CHECK_INT(result.converged, 0);
#if PD_DIM == 2
    start_from_profile(s);
    CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &s->steady, &result));
    CHECK_INT(result.newton, 0);
    CHECK_INT(result.evaluations, 1);
#endif
    memset(&wrong, 0, sizeof wrong);
    wrong.tolerance = (double)NAN;
    CHECK_INT(pd_steady_build(&s->ctx, &s->flow, &wrong, &other), PD_ERR_ARGUMENT);
    pd_steady_free(&s->ctx, &other);
    wrong.tolerance = 0.0;
    wrong.max_newton = -1;
    CHECK_INT(pd_steady_build(&s->ctx, &s->flow, &wrong, &other), PD_ERR_ARGUMENT);
    pd_steady_free(&s->ctx, &other);
    scene_free(s);
}

#if PD_DIM == 2
#define OF_DIM \
    ENTRY(pin_from_rest) ENTRY(pin_is_symmetric) ENTRY(poiseuille_from_rest) ENTRY(resolve_after_dissolution) \
    ENTRY(references_change_no_bit) ENTRY(creeping_pin) SLOW_ENTRY(vortices_from_rest) \
    ENTRY(inlet_on_its_side) ENTRY(no_progress)
#else
#define OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, hagen_poiseuille)
#endif

TEST_MAIN(OF_DIM ENTRY(threads_change_no_bit) ENTRY(limits))
