/* axisym: axisymmetric operators up to the axis, conservation, order, flow in tubes and between them, diffusion,
 * dissolution with the volumes of rings.
 * dims: 2 */
#include "transport/amount.h"
#include "transport/two_stage.h"
#include "flow/force.h"
#include "flow/implicit.h"
#include "lattice/op.h"
#include "transport/settle.h"
#include "fixture.h"
#include <stdlib.h>

#define PI 3.14159265358979323846

static scene test_scene;
enum { F, U, OUT }; /* fields: a scalar, a vector, what an operator gives */

/* A box of cells 0 .. nz, first .. first + nr, closed all around, fluid; the caller changes s->grid_desc. */
static scene *scene_start(double m, double hz, double hr, int nz, int first, int nr)
{
    scene *s = &test_scene;
    scene_box(s, m, hz, nz, 1, 1);
    s->stencil_desc.h[1] = hr;
    s->grid_desc.axisymmetric = 1;
    s->grid_desc.lo[1] = first * hr;
    s->grid_desc.hi[1] = (first + nr) * hr;
    s->grid_desc.side[2] = first ? PD_SIDE_WALL : PD_SIDE_MIRROR;
    s->fields = 3;
    return s;
}

/* ---- operators ---- */

/* Scalars of (z, r), even in r, with their derivatives. */
typedef struct scalar {
    double value, dz, dr, lap;
} scalar;

static scalar quadratic(int which, double z, double r)
{
    scalar q = {0.0, 0.0, 0.0, 0.0};
    if (which == 0) q.value = 1.0;
    if (which == 1) {
        q.value = z;
        q.dz = 1.0;
    }
    if (which == 2) {
        q.value = z * z;
        q.dz = 2.0 * z;
        q.lap = 2.0;
    }
    if (which == 3) {
        q.value = r * r;
        q.dr = 2.0 * r;
        q.lap = 4.0;
    }
    return q;
}

/* Vectors without swirl: (quadratic, 0), (0, r), (0, r z). */
static void vector(int which, double z, double r, double *u, double *div)
{
    u[0] = u[1] = *div = 0.0;
    if (which < 4) {
        scalar q = quadratic(which, z, r);
        u[0] = q.value;
        *div = q.dz;
    } else if (which == 4) {
        u[1] = r;
        *div = 2.0;
    } else {
        u[1] = r * z;
        *div = 2.0 * z;
    }
}

/* Largest errors over all nodes, each against the size of its terms, h^2 second derivatives being 1. */
static void exactness(double m, double hz, double hr, int first)
{
    scene *s = scene_start(m, hz, hr, 5, first, 14);
    double worst[3] = {0.0, 0.0, 0.0}, least = HUGE_VAL, x[2], div, u[2];
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
    s->grid_desc.side[3] = PD_SIDE_OUTLET;
    if (first) s->grid_desc.side[2] = PD_SIDE_OUTLET;
    if (!scene_build(s)) return;
    CHECK_INT(s->bonds.rows, 0);
    for (int which = 0; which < 6; which++) {
        for (int32_t node = 0; node < s->grid.total; node++) {
            pd_grid_position(&s->grid, node, x);
            s->field[F][node] = which < 4 ? quadratic(which, x[0], x[1]).value : 0.0;
            vector(which, x[0], x[1], u, &div);
            s->field[U][node] = u[0];
            s->field[U][s->grid.total + node] = u[1];
        }
        for (int what = which < 4 ? 0 : 2; what < 3; what++) {
            if (what == 0) pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
            if (what == 1) pd_op_gradient(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
            if (what == 2) pd_op_divergence(&s->ctx, &s->bonds, s->field[U], s->field[OUT]);
            for (int32_t node = 0; node < s->grid.total; node++) {
                if (s->grid.kind[node] != PD_FLUID) continue;
                pd_grid_position(&s->grid, node, x);
                scalar q = quadratic(which, x[0], x[1]);
                vector(which, x[0], x[1], u, &div);
                double size = 1.0 / (hz * hz) + 1.0 / (hr * hr), span = 5.0 * hz + (first + 14.0) * hr, error = 0.0;
                if (what == 0) error = fabs(s->field[OUT][node] - q.lap) / (size * span * span);
                if (what == 1)
                    error = fmax(fabs(s->field[OUT][node] - q.dz), fabs(s->field[OUT][s->grid.total + node] - q.dr)) /
                            (sqrt(size) * span * span);
                if (what == 2) error = fabs(s->field[OUT][node] - div) / (sqrt(size) * span * span);
                worst[what] = fmax(worst[what], error);
            }
        }
    }
    for (int row = 0; row < s->grid.n[1]; row++)
        for (int k = 0; k < s->stencil.count; k++) {
            double a = s->bonds.axisym.laplacian_weight[(int64_t)(row + s->grid.ghost) * s->stencil.count + k] /
                       s->stencil.laplacian_weight[k];
            if (first || row + s->stencil.offset[2 * k + 1] >= 0) least = fmin(least, a);
            else CHECK(!(fabs(a) > 0.0));
        }
    for (int what = 0; what < 3; what++) CHECK_LE(worst[what], 1e-14);
    CHECK(least > 0.0);
    NOTE("m %g, spacing %g x %g, from r = %d: errors %.1e %.1e %.1e, least weight %.2g of a(n)", m, hz, hr, first,
         worst[0], worst[1], worst[2], least);
    scene_free(s);
}

TEST(exact)
{
    static const double spacing[5][2] = {{1.0, 1.0}, {2.0, 1.0}, {1.0, 2.0}, {10.0, 1.0}, {1.0, 10.0}};
    for (int m = 1; m <= 6; m++)
        for (int k = 0; k < 5; k++) exactness(m, spacing[k][0], spacing[k][1], 0);
    exactness(3.0, 1.0, 1.0, 4);
    exactness(1.5, 1.0, 2.0, 0);
    exactness(12.0, 1.0, 1.0, 0);
    exactness(8.0, 20.0, 1.0, 0);
    exactness(8.0, 1.0, 20.0, 0);
}

/* lap u_r - hoop u_r vanishes on r, and is 8 r on r^3 up to the order. */
TEST(hoop)
{
    double error[2];
    for (int level = 0; level < 2; level++) {
        int n = 20 << level;
        scene *s = scene_start(3.0, 1.0 / n, 1.0 / n, 4, 0, n);
        double x[2];
        s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
        s->grid_desc.side[3] = PD_SIDE_OUTLET;
        if (!scene_build(s)) return;
        for (int cubic = 0; cubic < 2; cubic++) {
            double worst = 0.0;
            for (int32_t node = 0; node < s->grid.total; node++) {
                pd_grid_position(&s->grid, node, x);
                s->field[F][node] = cubic ? x[1] * x[1] * x[1] : x[1];
            }
            pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
            for (int32_t node = 0; node < s->grid.total; node++) {
                if (s->grid.kind[node] != PD_FLUID) continue;
                pd_grid_position(&s->grid, node, x);
                double hoop = s->bonds.axisym.hoop[node / s->grid.stride[1]];
                worst = fmax(worst, fabs(s->field[OUT][node] - hoop * s->field[F][node] - (cubic ? 8.0 * x[1] : 0.0)));
            }
            if (!cubic) CHECK_LE(worst, 1e-10 * n);
            if (cubic) error[level] = worst;
        }
        scene_free(s);
    }
    NOTE("largest error on r^3: %.2e, %.2e", error[0], error[1]);
    CHECK_LE(error[1], error[0] / 1.9); /* first order in the cells at the axis, whose volume vanishes */
}

/* In a closed box with solids what bonds move adds up to nothing, and the Laplacian is self-adjoint. */
TEST(conservation)
{
    for (int first = 0; first <= 4; first += 4) {
        scene *s = scene_start(3.0, 1.0, 0.7, 20, first, 16);
        uint32_t state = 7;
        double sum[3] = {0.0, 0.0, 0.0}, size[3] = {0.0, 0.0, 0.0};
        s->grid_desc.solid = &s->shapes[0];
        s->shapes[0].type = PD_SHAPE_BOX;
        s->shapes[0].a[0] = 6.0;
        s->shapes[0].b[0] = 13.0;
        s->shapes[0].a[1] = s->grid_desc.lo[1] + (first ? 2.8 : 0.0);
        s->shapes[0].b[1] = s->grid_desc.lo[1] + 4.2;
        if (!scene_build(s)) return;
        for (int64_t k = 0; k < 2 * s->grid.total; k++) s->field[U][k] = random_real(&state);
        pd_ghosts_set_vector(&s->bonds.ghosts, s->field[U]);
        pd_op_divergence(&s->ctx, &s->bonds, s->field[U], s->field[OUT]);
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (s->grid.kind[node] != PD_FLUID) continue;
            sum[0] += s->field[OUT][node] * pd_grid_circumference(&s->grid, node);
            size[0] += fabs(s->field[OUT][node]) * pd_grid_circumference(&s->grid, node);
        }
        for (int32_t node = 0; node < s->grid.total; node++) s->field[F][node] = random_real(&state);
        pd_ghosts_set_scalar(&s->bonds.ghosts, s->field[F]);
        pd_ghosts_set_scalar(&s->bonds.ghosts, s->field[U]);
        pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
        pd_op_laplacian(&s->ctx, &s->bonds, s->field[U], s->field[OUT] + s->grid.total);
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (s->grid.kind[node] != PD_FLUID) continue;
            double volume = pd_grid_circumference(&s->grid, node);
            sum[1] += s->field[OUT][node] * volume;
            size[1] += fabs(s->field[OUT][node]) * volume;
            sum[2] += (s->field[U][node] * s->field[OUT][node] -
                       s->field[F][node] * s->field[OUT][s->grid.total + node]) * volume;
            size[2] += fabs(s->field[U][node] * s->field[OUT][node]) * volume;
        }
        for (int k = 0; k < 3; k++) CHECK_LE(fabs(sum[k]), 1e-13 * size[k]);
        scene_free(s);
    }
}

/* J0 by its series (Abramowitz and Stegun 9.1.10). */
static double bessel0(double x)
{
    double term = 1.0, sum = 1.0;
    for (int k = 1; k < 60; k++) {
        term *= -0.25 * x * x / ((double)k * k);
        sum += term;
    }
    return sum;
}

/* lap J0(a r) cos(b z) = -(a^2 + b^2) J0(a r) cos(b z): the order in the volume-weighted mean and at worst. */
TEST(order)
{
    double mean[3], most[3];
    for (int level = 0; level < 3; level++) {
        int n = 16 << level;
        scene *s = scene_start(3.0, 1.0 / n, 1.0 / n, n, 0, n);
        double a = 5.0, b = 2.0 * PI, x[2], weight = 0.0;
        s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
        s->grid_desc.side[3] = PD_SIDE_OUTLET;
        if (!scene_build(s)) return;
        for (int32_t node = 0; node < s->grid.total; node++) {
            pd_grid_position(&s->grid, node, x);
            s->field[F][node] = bessel0(a * x[1]) * cos(b * x[0]);
        }
        pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
        mean[level] = most[level] = 0.0;
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (s->grid.kind[node] != PD_FLUID) continue;
            double volume = pd_grid_circumference(&s->grid, node);
            double error = fabs(s->field[OUT][node] + (a * a + b * b) * s->field[F][node]);
            mean[level] += volume * error;
            weight += volume;
            most[level] = fmax(most[level], error);
        }
        mean[level] /= weight;
        scene_free(s);
    }
    NOTE("mean error %.3e, order %.2f, %.2f; largest %.3e, order %.2f", mean[2], log2(mean[0] / mean[1]),
         log2(mean[1] / mean[2]), most[2], log2(most[1] / most[2]));
    CHECK(log2(mean[1] / mean[2]) > 1.9);
    CHECK(log2(most[1] / most[2]) > 1.9);
}

/* ---- flow ---- */

typedef struct stream {
    pd_flow flow;
    pd_steady steady;
    double inner, outer, mean; /* [m], [m], [m/s] */
} stream;

/* Fully developed between r = inner (0: none) and outer, mean 1. */
static double developed(double inner, double outer, double r)
{
    double k = inner / outer, s = r / outer;
    if (!(inner > 0.0)) return 2.0 * (1.0 - s * s);
    double ratio = (1.0 - k * k) / log(1.0 / k);
    return 2.0 * (1.0 - s * s + ratio * log(s)) / (1.0 + k * k - ratio);
}

static void enter(void *user, const double *x, double *u)
{
    const stream *t = (const stream *)user;
    u[0] = t->mean * developed(t->inner, t->outer, x[1]);
    u[1] = 0.0;
}

static int stream_build(scene *s, stream *t, double inner, double outer, double mean, double nu)
{
    pd_flow_desc fd;
    pd_steady_desc sd;
    memset(t, 0, sizeof *t);
    memset(&fd, 0, sizeof fd);
    memset(&sd, 0, sizeof sd);
    t->inner = inner;
    t->outer = outer;
    t->mean = mean;
    fd.rho = 1000.0;
    fd.mu = 1000.0 * nu;
    fd.report_speed = mean;
    fd.report_length = outer - inner;
    fd.inlet = enter;
    fd.inlet_user = t;
    sd.tolerance = 1e-9;
    return CHECK_OK(&s->ctx, pd_flow_build(&s->ctx, &s->grid, &s->bonds, &fd, &t->flow)) &&
           CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &t->flow, &sd, &t->steady));
}

static void stream_free(scene *s, stream *t)
{
    pd_steady_free(&s->ctx, &t->steady);
    pd_flow_free(&s->ctx, &t->flow);
}

/* A tube or an annulus, its walls faces of the box: error of u over the mean in L2, and of the pressure gradient. */
static double pipe_error(int cells, int first, double m, double *gradient, int64_t *evaluations)
{
    double outer = 1.0, h = outer / (first + cells), sum = 0.0, weight = 0.0, x[2];
    scene *s = scene_start(m, h, h, 12, first, cells);
    stream t;
    pd_steady_result result;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    if (!scene_build(s) || !stream_build(s, &t, first * h, outer, 1.0, 0.1)) return HUGE_VAL;
    CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &t.steady, &result));
    CHECK_INT(result.converged, 1);
    *evaluations = result.evaluations;
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (s->grid.kind[node] != PD_FLUID) continue;
        pd_grid_position(&s->grid, node, x);
        double volume = pd_grid_circumference(&s->grid, node);
        double e = t.flow.u[node] - developed(t.inner, outer, x[1]), v = t.flow.u[s->grid.total + node];
        sum += volume * (e * e + v * v);
        weight += volume;
    }
    double k = t.inner / outer, shape = first ? 1.0 + k * k - (1.0 - k * k) / log(1.0 / k) : 1.0;
    int i[2] = {5, cells / 2};
    *gradient = t.flow.pressure_grad[pd_grid_node(&s->grid, i)] / (-8.0 * 0.1 / shape) - 1.0;
    double in = pd_flow_integrate_section(&s->ctx, &t.flow, 0, 1),
           out = pd_flow_integrate_section(&s->ctx, &t.flow, 0, 11);
    CHECK_LE(fabs(out - in), 1e-8 * fabs(in));
    CHECK_REL(in, PI * (1.0 - k * k), 4.0 / (cells * cells));
    stream_free(s, &t);
    scene_free(s);
    return sqrt(sum / weight);
}

TEST(tube)
{
    double gradient;
    int64_t evaluations;
    for (int m = 1; m <= 4; m++) {
        double error = pipe_error(10, 0, m, &gradient, &evaluations);
        NOTE("m = %d, 10 cells: error %.2e, dp/dx %.2e, %d evaluations", m, error, gradient, (int)evaluations);
        CHECK_LE(error, 1e-8); /* an exact discrete solution, solved to 1e-9 */
        CHECK_LE(fabs(gradient), 1e-7);
    }
}

TEST(annulus)
{
    double error[3], gradient[3];
    int64_t evaluations;
    for (int level = 0; level < 3; level++) {
        int gap = 9 << level;
        error[level] = pipe_error(gap, gap / 3, 2.0, &gradient[level], &evaluations);
        NOTE("%d cells across: error %.2e, dp/dx %.2e, %d evaluations", gap, error[level], gradient[level],
             (int)evaluations);
    }
    CHECK_LE(error[2], 2e-4);
    CHECK(log2(error[1] / error[2]) > 1.8);
}

/* A pin on the axis of a tube: as much behind it as in front, and the same force from the surface and the balance. */
TEST(pin)
{
    scene *s = scene_start(3.0, 0.05, 0.05, 60, 0, 20);
    stream t;
    pd_steady_result result;
    double lo[2], hi[2], surface[2], balance[2];
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->grid_desc.solid = &s->shapes[0];
    s->shapes[0].type = PD_SHAPE_BOX;
    s->shapes[0].a[0] = 1.0;
    s->shapes[0].b[0] = 2.0;
    s->shapes[0].a[1] = -0.3;
    s->shapes[0].b[1] = 0.3;
    if (!scene_build(s) || !stream_build(s, &t, 0.0, 1.0, 1.0, 0.1)) return;
    CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &t.steady, &result));
    CHECK_INT(result.converged, 1);
    double up = pd_flow_integrate_section(&s->ctx, &t.flow, 0, 4),
           down = pd_flow_integrate_section(&s->ctx, &t.flow, 0, 56), most = 0.0;
    for (int k = 4; k <= 56; k++) most = fmax(most, fabs(pdi_flow_integrate_nodal_section(&t.flow, 0, k) / up - 1.0));
    CHECK_LE(fabs(down / up - 1.0), 1e-7);
    CHECK_LE(fabs(pd_flow_integrate_section(&s->ctx, &t.flow, 0, 30) / up - 1.0), 1e-7);
    lo[0] = 0.6;
    hi[0] = 2.4;
    lo[1] = 0.0;
    hi[1] = 0.7;
    pd_force_surface(&s->ctx, &t.flow, PD_FORCE_ALL, lo, hi, surface, NULL, NULL);
    CHECK_OK(&s->ctx, pd_force_momentum_balance(&s->ctx, &t.flow, lo, hi, balance));
    NOTE("%d evaluations, flux %.1e, of nodes %.1e, force %.4g (surface) %.4g N (balance)", (int)result.evaluations,
         down / up - 1.0, most, surface[0], balance[0]);
    CHECK_LE(most, 3e-2);
    CHECK_REL(surface[0], balance[0], 0.02);
    CHECK(!(fabs(surface[1]) > 0.0) && !(fabs(balance[1]) > 0.0));
    stream_free(s, &t);
    scene_free(s);
}

/* ---- transport ---- */

/* J0(j r) with the first zero j of J1 fades as exp(-D j^2 t) in a closed tube: the error at t = 0.1 in L2. */
static double fading_error(int n, double *gone)
{
    scene *s = scene_start(3.0, 1.0 / n, 1.0 / n, 6, 0, n);
    pd_transport transport;
    pd_transport_desc td;
    pd_two_stage two_stage;
    pd_two_stage_desc ad;
    double zero = 3.8317059702075123, x[2], sum = 0.0, weight = 0.0;
    memset(&td, 0, sizeof td);
    memset(&ad, 0, sizeof ad);
    td.diffusivity = 1.0;
    td.initial = 2.0;
    ad.rtol = 1e-6;
    if (!scene_build(s) ||
        !CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &td, &transport)) ||
        !CHECK_OK(&s->ctx, pd_two_stage_build(&s->ctx, &transport, &ad, &two_stage)))
        return HUGE_VAL;
    for (int32_t i = 0; i < s->grid.total; i++) {
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID) transport.c[i] += bessel0(zero * x[1]);
    }
    double start = pd_transport_stock(&s->ctx, &transport);
    CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_two_stage_process(&two_stage), 0.1));
    *gone = pd_transport_stock(&s->ctx, &transport) + pd_transport_carried(&s->ctx, &transport) - start;
    CHECK_REL(start, 2.0 * PI * 6.0 / n, 0.2 / (n * n)); /* the volume of rings is that of the tube */
    *gone /= start;
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        double e = transport.c[i] - 2.0 - exp(-0.1 * zero * zero) * bessel0(zero * x[1]);
        sum += pd_grid_circumference(&s->grid, i) * e * e;
        weight += pd_grid_circumference(&s->grid, i);
    }
    pd_two_stage_free(&s->ctx, &two_stage);
    pd_transport_free(&s->ctx, &transport);
    scene_free(s);
    return sqrt(sum / weight);
}

TEST(fading)
{
    double error[3], gone;
    for (int level = 0; level < 3; level++) {
        error[level] = fading_error(10 << level, &gone);
        CHECK_LE(fabs(gone), 1e-14);
    }
    NOTE("error %.2e, %.2e, %.2e, amount gone %.1e", error[0], error[1], error[2], gone);
    CHECK(log2(error[1] / error[2]) > 1.8);
}

/* Between walls that hold 1 at r = a and 0 at r = b: c = ln(b/r)/ln(b/a), and as much leaves as enters. */
static double held_at(void *user, const double *x)
{
    return x[1] < *(const double *)user ? 1.0 : 0.0;
}

static double held_error(int cells, double *through)
{
    double h = 1.0 / cells, middle = 1.0, x[2], worst = 0.0;
    scene *s = scene_start(3.0, h, h, 6, cells / 2, cells);
    pd_transport transport;
    pd_transport_desc td;
    pd_transport_result result;
    memset(&td, 0, sizeof td);
    td.diffusivity = 0.5;
    td.held = held_at;
    td.user = &middle;
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
    if (!scene_build(s) ||
        !CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &td, &transport)))
        return HUGE_VAL;
    CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &transport, &result));
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        worst = fmax(worst, fabs(transport.c[i] - log(1.5 / x[1]) / log(3.0)));
    }
    CHECK_REL(transport.inflow, transport.outflow, 1e-9);
    *through = transport.inflow / (0.5 * 2.0 * PI * 6.0 * h / log(3.0)) - 1.0;
    pd_transport_free(&s->ctx, &transport);
    scene_free(s);
    return worst;
}

TEST(held)
{
    double error[3], through[3];
    for (int level = 0; level < 3; level++) error[level] = held_error(8 << level, &through[level]);
    NOTE("error %.2e, %.2e, %.2e; flux off by %.2e, %.2e, %.2e", error[0], error[1], error[2], through[0], through[1],
         through[2]);
    CHECK(log2(error[1] / error[2]) > 1.5);
    CHECK_LE(fabs(through[2]), 5e-3);
}

/* ---- dissolution ---- */

#define SPEED 1e-9 /* [m/s] */

static double constant_speed(void *user, const pd_rate_at *at)
{
    (void)user;
    (void)at;
    return SPEED;
}

/* A wire of infinite length or a ball on the axis, `ratio` cells of radius: worst deviation of the mean recession until
 * half is gone, in shares of it; radii are those of equal amount. */
static double shrink(int ball, int ratio, double *ledger)
{
    double radius = 8e-5, h = radius / ratio, worst = 0.0, cs = 71500.0;
    int nr = (int)ceil(1.5 * ratio);
    scene *s = scene_start(3.0, h, h, ball ? 2 * nr : 4, 0, nr);
    pd_transport transport;
    pd_transport_desc td;
    pd_dissolve dissolve;
    pd_dissolve_desc dd;
    pd_time_loop couple;
    pd_time_loop_desc cd;
    memset(&td, 0, sizeof td);
    memset(&dd, 0, sizeof dd);
    memset(&cd, 0, sizeof cd);
    s->grid_desc.solid = &s->shapes[0];
    s->shapes[0].type = ball ? PD_SHAPE_BALL : PD_SHAPE_CYLINDER;
    s->shapes[0].radius = radius;
    s->shapes[0].a[0] = nr * h;
    td.diffusivity = 1e-9;
    dd.solid = cs;
    dd.rate = constant_speed;
    cd.fraction = 0.05;
    if (!scene_build(s) ||
        !CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &td, &transport)) ||
        !CHECK_OK(&s->ctx, pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &transport, &dd, &dissolve)) ||
        !CHECK_OK(&s->ctx, pd_time_loop_build(&s->ctx, &cd, &s->grid, &s->bonds, &couple)) ||
        !CHECK_OK(&s->ctx, pd_time_loop_add_process(&s->ctx, &couple, pd_dissolve_process(&dissolve))) ||
        !CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &couple)))
        return HUGE_VAL;
    double start = couple.ledger[0].start / cs;
    double first = ball ? cbrt(0.75 * start / PI) : sqrt(start / PI / (4.0 * h));
    CHECK_REL(first, radius, ball ? 0.05 : 1e-12);
    for (int k = 4; pd_time_loop_volume_loss(&couple) < 0.5; k++) {
        double receded = 0.05 * k * radius;
        while (couple.time < receded / SPEED)
            if (!CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &couple, receded / SPEED))) return HUGE_VAL;
        double left = couple.ledger[0].solid / couple.ledger[0].start;
        worst = fmax(worst, fabs(first * (1.0 - (ball ? cbrt(left) : sqrt(left))) / receded - 1.0));
        *ledger = fmax(*ledger, couple.ledger[0].relative_imbalance);
    }
    pd_dissolve_free(&s->ctx, &dissolve);
    pd_transport_free(&s->ctx, &transport);
    scene_free(s);
    return worst;
}

TEST(bodies_shrink_at_the_speed)
{
    double ledger = 0.0;
    double wire = shrink(0, 8, &ledger), finer = shrink(0, 16, &ledger);
    double ball = shrink(1, 8, &ledger), rounder = shrink(1, 16, &ledger);
    NOTE("wire off by %.4f, %.4f; ball by %.4f, %.4f; ledger %.1e", wire, finer, ball, rounder, ledger);
    CHECK_LE(ledger, 1e-12);
    /* the share of the lead (theory: 10.7) is that of curved fronts; the rows of a wire leave as flat ones */
    CHECK_LE(wire, 0.03);
    CHECK_LE(finer, 0.5 * wire);
    CHECK_LE(ball, 0.025);
    CHECK_LE(rounder, 0.5 * ball);
}

static pd_status build_with(pd_grid_desc *desc, pd_grid *grid)
{
    pd_status status = pd_grid_build(&test_scene.ctx, &test_scene.stencil, desc, grid);
    pd_grid_free(&test_scene.ctx, grid);
    return status;
}

TEST(refusals)
{
    scene *s = scene_start(3.0, 1.0, 1.0, 8, 0, 8);
    pd_grid grid;
    if (!CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil))) return;
    pd_grid_desc desc = s->grid_desc;
    CHECK_OK(&s->ctx, build_with(&desc, &grid));
    desc.side[2] = PD_SIDE_WALL;
    CHECK_INT(build_with(&desc, &grid), PD_ERR_ARGUMENT);
    CHECK_STR(s->ctx.message, "grid: the side at the axis r = 0 has type 0, expected mirror");
    desc = s->grid_desc;
    desc.side[3] = PD_SIDE_MIRROR;
    CHECK_INT(build_with(&desc, &grid), PD_ERR_ARGUMENT);
    desc = s->grid_desc;
    desc.lo[1] = 2.0;
    CHECK_INT(build_with(&desc, &grid), PD_ERR_GEOMETRY);
    CHECK_STR(s->ctx.message, "grid: an axisymmetric box begins at r = 2 m, expected 0 or at least one horizon, 3 m");
    desc.lo[1] = 3.0;
    CHECK_INT(build_with(&desc, &grid), PD_ERR_ARGUMENT); /* a mirror at r = 3 */
    desc.side[2] = PD_SIDE_WALL;
    CHECK_OK(&s->ctx, build_with(&desc, &grid));
    scene_free(s);
}

/* Largest r^2 |L f - lap f| over whole rows beside a wire of 6 cells radius for f = ln r, or over r^2 for f = r^2. */
static double beside_wire(double m, int square)
{
    scene *s = scene_start(m, 1.0, 1.0, 12, 0, 24);
    double most = 0.0, x[2];
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
    s->grid_desc.side[3] = PD_SIDE_OUTLET;
    s->shapes[0].type = PD_SHAPE_CYLINDER;
    s->shapes[0].radius = 6.0;
    s->grid_desc.solid = &s->shapes[0];
    if (!scene_build(s)) return HUGE_VAL;
    for (int32_t node = 0; node < s->grid.total; node++) {
        pd_grid_position(&s->grid, node, x);
        s->field[F][node] = square ? x[1] * x[1] : log(fabs(x[1]));
    }
    pd_op_laplacian(&s->ctx, &s->bonds, s->field[F], s->field[OUT]);
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (s->grid.kind[node] != PD_FLUID || s->bonds.row_of_node[node] >= 0) continue;
        pd_grid_position(&s->grid, node, x);
        double error = fabs(s->field[OUT][node] - (square ? 4.0 : 0.0));
        most = fmax(most, error * (square ? 1.0 / (x[1] * x[1]) : x[1] * x[1]));
    }
    scene_free(s);
    return most;
}

/* Around a wire on the axis r^2 is exact and ln r of fourth order in the spacing over the radius, where mean radii are
 * off by its square. */
TEST(logarithm)
{
    for (double m = 1.0; m < 2.5; m += 1.0) {
        double r = 6.5 + m - (m > 1.0 ? 1.0 : 0.0); /* of the first whole row, or less */
        NOTE("m = %g: %.3g, %.3g", m, beside_wire(m, 0), beside_wire(m, 1));
        CHECK_LE(beside_wire(m, 1), 1e-13);
        CHECK_LE(beside_wire(m, 0), 0.1 * m * m * m * m / (r * r * r * r));
    }
}

TEST_MAIN(ENTRY(exact) ENTRY(logarithm) ENTRY(hoop) ENTRY(conservation) ENTRY(order) ENTRY(tube) ENTRY(annulus)
          ENTRY(pin) ENTRY(fading) ENTRY(held) ENTRY(bodies_shrink_at_the_speed) ENTRY(refusals))
