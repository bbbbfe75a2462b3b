/* test_implicit: incompressible flow in time, against closed forms and series.
 * dims: 2 3 */
#include "test.h"
#include "implicit_scene.h"
#include "core/par.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A box of nx x ny (x 4) cells, 1 high, periodic but for the y sides. */
static void scene_init(scene *s, int nx, int ny, pd_side low, pd_side high)
{
    memset(s, 0, sizeof *s);
    pd_ctx_init(&s->ctx);
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = 1.0 / ny;
        s->grid_desc.hi[d] = (d == 0 ? nx : d == 1 ? ny : 4) / (double)ny;
        s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    s->grid_desc.side[2] = low;
    s->grid_desc.side[3] = high;
    s->flow_desc.rho = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    s->flow_desc.mu = 1.0;
}

/* The shear wave u_x = sin(k y) in a stream along y: the sums of the stencil give its decay rate and phase speed in
 * closed form, so that what is left is the error in time. */
static double shear_wave(double dt, double stream)
{
    scene s_, *s = &s_;
    double k = 2.0 * pi, nu = 0.05, decay = 0.0, phase = 0.0, t = 0.4, error = 0.0;
    scene_init(s, 4, 16, PD_SIDE_PERIODIC, PD_SIDE_PERIODIC);
    s->flow_desc.mu = nu;
    s->desc.stage_tolerance = 1e-11;
    if (!scene_build(s)) return 1.0;
    for (int b = 0; b < s->stencil.count; b++) {
        decay += nu * s->stencil.laplacian_weight[b] * (1.0 - cos(k * s->stencil.xi[b * PD_DIM + 1]));
        phase += stream * s->stencil.gradient_weight[b * PD_DIM + 1] * sin(k * s->stencil.xi[b * PD_DIM + 1]);
    }
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM], now = s->implicit.time;
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            double u = exp(-decay * now) * sin(k * x[1] - phase * now);
            if (pass) {
                error = fmax(error, fabs(s->flow.u[i] - u));
                error = fmax(error, fabs(s->flow.u[s->grid.total + i] - stream));
                continue;
            }
            s->flow.u[i] = u;
            s->flow.u[s->grid.total + i] = stream;
        }
        for (int n = 0; pass == 0 && n < (int)(t / dt + 0.5); n++)
            if (!CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &s->implicit, dt))) return 1.0;
    }
    scene_free(s);
    return error;
}

TEST(second_order_in_time)
{
    for (int streaming = 0; streaming < 2; streaming++) {
        double coarse = shear_wave(0.04, streaming), middle = shear_wave(0.02, streaming),
               fine = shear_wave(0.01, streaming);
        CHECK_LE(fine, 1e-3);
        CHECK_NEAR(log(coarse / middle) / log(2.0), 2.0, 0.03);
        CHECK_NEAR(log(middle / fine) / log(2.0), 2.0, 0.02);
        NOTE("stream %d: errors %.3g %.3g %.3g", streaming, coarse, middle, fine);
    }
}

#if PD_DIM == 2
static double taylor_green(int n, double t)
{
    scene s_, *s = &s_;
    double k = 2.0 * pi, nu = 0.01, error = 0.0;
    scene_init(s, n, n, PD_SIDE_PERIODIC, PD_SIDE_PERIODIC);
    s->flow_desc.mu = nu;
    if (!scene_build(s)) return 1.0;
    for (int pass = 0; pass < 2; pass++) {
        double a = exp(-2.0 * nu * k * k * s->implicit.time);
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM], u[PD_DIM];
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            u[0] = a * sin(k * x[0]) * cos(k * x[1]);
            u[1] = -a * cos(k * x[0]) * sin(k * x[1]);
            for (int d = 0; d < PD_DIM; d++) {
                double *at = &s->flow.u[(int64_t)d * s->grid.total + i];
                if (pass) error = fmax(error, fabs(*at - u[d]));
                else *at = u[d];
            }
        }
        if (pass == 0 && !CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_implicit_process(&s->implicit), t))) return 1.0;
    }
    scene_free(s);
    return error;
}

/* How far the pressure of the vortex is off its closed form, after `steps` steps of `share` times the weight of the
 * pressure flux. */
static double vortex_pressure(int n, int steps, double share)
{
    scene s_, *s = &s_;
    double k = 2.0 * pi, mean = 0.0, error = 0.0;
    scene_init(s, n, n, PD_SIDE_PERIODIC, PD_SIDE_PERIODIC);
    s->flow_desc.mu = 0.01;
    s->desc.stage_tolerance = 1e-9;
    if (!scene_build(s)) return 1.0;
    for (int pass = 0; pass < 3; pass++) {
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM], *u = s->flow.u + i, a = exp(-4.0 * 0.01 * k * k * s->implicit.time);
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            double off = s->flow.p[i] - 0.25 * a * (cos(2.0 * k * x[0]) + cos(2.0 * k * x[1]));
            if (pass == 1) mean += off / (n * n);
            if (pass == 2) error = fmax(error, fabs(off - mean));
            if (pass) continue;
            u[0] = sin(k * x[0]) * cos(k * x[1]);
            u[s->grid.total] = -cos(k * x[0]) * sin(k * x[1]);
        }
        for (int m = 0; pass == 0 && m < steps; m++)
            if (!CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &s->implicit, share * s->flow.stabilisation))) return 1.0;
    }
    scene_free(s);
    return error;
}

/* However short steps are, the pressure is that of the velocity from the first of them on. */
TEST(pressure_of_short_steps)
{
    static const double share[3] = {1e-1, 1e-3, 1e-5};
    for (int k = 0; k < 3; k++) {
        double coarse = vortex_pressure(32, 3, share[k]), fine = vortex_pressure(64, 3, share[k]);
        CHECK_LE(fine, 0.04 * 0.5);
        CHECK_NEAR(log(coarse / fine) / log(2.0), 2.0, 0.2);
        NOTE("steps of %g: errors %.3g %.3g", share[k], coarse, fine);
    }
}

/* Taylor 1923: exact for all Reynolds numbers. */
TEST(taylor_green_vortex)
{
    double coarse = taylor_green(24, 0.5), fine = taylor_green(48, 0.5);
    CHECK_LE(fine, 3e-3);
    CHECK_LE(1.9, log(coarse / fine) / log(2.0));
    NOTE("errors %.3g %.3g", coarse, fine);
}

/* u/(f H^2/nu) at y/H and nu t/H^2 = tau under a constant force, and u/U beside a wall at y = H that starts to move. */
static double force_startup(double y, double tau)
{
    double u = 0.5 * y * (1.0 - y);
    for (int k = 1; k < 400; k += 2)
        u -= 4.0 / (k * k * k * pi * pi * pi) * sin(k * pi * y) * exp(-k * k * pi * pi * tau);
    return u;
}

static double wall_startup(double y, double tau)
{
    double u = y;
    for (int k = 1; k < 400; k++)
        u += 2.0 / (k * pi) * (k % 2 ? -1.0 : 1.0) * sin(k * pi * y) * exp(-k * k * pi * pi * tau);
    return u;
}

static void lid(void *user, const double *x, double *u)
{
    (void)user;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    if (x[1] > 0.5) u[0] = 1.0;
}

/* Largest error at all times over the largest velocity; half: mirrored at y = 0, the wall at y = 1. */
static double startup(int n, int moving, int half)
{
    static const double taus[] = {0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0};
    int first = moving ? 2 : 0; /* the layer at a wall that jumps has to grow to a few nodes first */
    scene s_, *s = &s_;
    double error = 0.0, height = half ? 2.0 : 1.0;
    scene_init(s, 4, n, half ? PD_SIDE_MIRROR : PD_SIDE_WALL, PD_SIDE_WALL);
    s->flow_desc.force[0] = moving ? 0.0 : 1.0;
    s->flow_desc.wall = moving ? lid : NULL;
    s->flow_desc.report_speed = moving ? 1.0 : 0.125 * height * height;
    if (!scene_build(s)) return 1.0;
    for (int k = first; k < 7; k++) {
        double end = taus[k] * height * height;
        if (!CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_implicit_process(&s->implicit), end))) return 1.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            double y = half ? 0.5 * (1.0 + x[1]) : x[1];
            double u = moving ? wall_startup(y, taus[k]) : height * height * force_startup(y, taus[k]);
            error = fmax(error, fabs(s->flow.u[i] - u));
            error = fmax(error, fabs(s->flow.u[s->grid.total + i]));
        }
    }
    error /= s->flow.velocity_scale;
    scene_free(s);
    return error;
}

TEST(startup_flows)
{
    for (int kind = 0; kind < 3; kind++) {
        double coarse = startup(24, kind == 1, kind == 2), fine = startup(48, kind == 1, kind == 2);
        CHECK_LE(fine, 1e-3);
        CHECK_LE(1.8, log(coarse / fine) / log(2.0));
        NOTE("kind %d: errors %.3g %.3g", kind, coarse, fine);
    }
}
#endif

/* A random velocity that breaks continuity becomes solenoidal in the first step, and calms down for any step. */
TEST(any_start_and_step)
{
    for (int k = 0; k < 4; k++) {
        scene s_, *s = &s_;
        double before = 0.0, after = 0.0, dt = pow(100.0, k - 2);
        scene_init(s, 8, 8, PD_SIDE_WALL, PD_SIDE_MIRROR);
        s->desc.stage_tolerance = 1e-8;
        if (!scene_build(s)) return;
        uint32_t seed = 5;
        for (int32_t i = 0; i < s->grid.total; i++)
            for (int d = 0; d < PD_DIM && s->grid.kind[i] == PD_FLUID; d++) {
                seed = seed * 1664525u + 1013904223u;
                double u = seed / 4294967296.0 - 0.5;
                s->flow.u[(int64_t)d * s->grid.total + i] = u;
                before += u * u;
            }
        CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &s->implicit, dt));
        for (int64_t i = 0; i < PD_DIM * s->grid.total; i++)
            if (s->grid.kind[i % s->grid.total] == PD_FLUID) after += s->flow.u[i] * s->flow.u[i];
        CHECK_LE(after, before);
        if (!CHECK_OK(&s->ctx, pdi_steady_begin_solves(&s->ctx, &s->steady))) return;
        double *r = s->steady.residual;
        pdi_flow_assemble_residual(&s->ctx, &s->flow, r, r + PD_DIM * s->grid.total);
        CHECK_LE(pdi_par_max_abs(&s->ctx, s->grid.total, r + PD_DIM * s->grid.total), 1e-8);
        CHECK_OK(&s->ctx, pdi_steady_end_solves(&s->ctx, &s->steady, PD_OK));
        scene_free(s);
    }
}

TEST(threads_change_no_bit)
{
    scene a, b;
    scene *both[2];
    both[0] = &a;
    both[1] = &b;
    for (int k = 0; k < 2; k++) {
        scene *s = both[k];
        scene_init(s, PD_DIM == 2 ? 40 : 16, PD_DIM == 2 ? 24 : 12, PD_SIDE_WALL, PD_SIDE_MIRROR);
        s->flow_desc.force[0] = 1.0;
        if (!scene_build(s)) return;
        s->ctx.threads = 1 + 3 * k;
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) s->flow.u[s->grid.total + i] = 0.1 * sin(0.3 * i);
        for (int n = 0; n < 3; n++) CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &s->implicit, 0.002));
    }
    CHECK_INT((int)a.implicit.steps, (int)b.implicit.steps);
    CHECK(memcmp(a.flow.u, b.flow.u, (size_t)(PD_DIM * a.grid.total) * sizeof(double)) == 0);
    scene_free(&a);
    scene_free(&b);
}

static void growing_inlet(void *user, const double *x, double *u)
{
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    u[0] = (1.0 + *(const double *)user) * x[1] * (1.0 - x[1]);
}

/* Largest difference of two arrays, NaN counts as infinite. */
static double largest_difference(const double *a, const double *b, int64_t n)
{
    double most = 0.0;
    for (int64_t i = 0; i < n; i++) {
        double off = fabs(a[i] - b[i]);
        most = off <= HUGE_VAL ? fmax(most, off) : HUGE_VAL;
    }
    return most;
}

/* A step that does not converge, and one whose error is too large, leave the flow as it was before: the state, the time
 * of its boundary data, and the fields that follow from them. */
TEST(failed_steps_change_nothing)
{
    for (int rejected = 0; rejected < 2; rejected++) {
        scene s_, *s = &s_;
        double clock = 0.0;
        scene_init(s, 12, 8, PD_SIDE_WALL, PD_SIDE_WALL);
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
        s->flow_desc.mu = 0.1;
        s->flow_desc.inlet = growing_inlet;
        s->flow_desc.inlet_user = s->flow_desc.clock = &clock;
        if (!scene_build(s)) return;
        CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &s->implicit, 0.01));
        int64_t total = s->grid.total, n = PD_DIM * total;
        double *kept = (double *)malloc((size_t)(3 * n + total) * sizeof *kept);
        if (!CHECK(kept != NULL)) return;
        memcpy(kept, s->flow.u, (size_t)n * sizeof *kept);
        memcpy(kept + n, s->flow.advecting, (size_t)n * sizeof *kept);
        memcpy(kept + 2 * n, s->flow.pressure_grad, (size_t)n * sizeof *kept);
        memcpy(kept + 3 * n, s->flow.p, (size_t)total * sizeof *kept);
        if (rejected) {
            pd_physics process = pd_implicit_process(&s->implicit);
            pd_step step;
            memset(&step, 0, sizeof step);
            step.time = s->implicit.time;
            step.dt = 1.0;
            s->implicit.desc.rtol = 1e-9;
            CHECK_INT((int)process.attempt(&s->ctx, process.self, &step), (int)PD_RETRY);
            CHECK(step.error > 1.0 && step.error < HUGE_VAL);
            CHECK_OK(&s->ctx, process.reject(&s->ctx, process.self, &step));
        } else {
            s->implicit.desc.stage_tolerance = 1e-30; /* below rounding */
            CHECK_INT((int)pd_implicit_step(&s->ctx, &s->implicit, 1.0), (int)PD_RETRY);
        }
        CHECK_NEAR(s->flow.time, 0.01, 1e-15);
        CHECK_NEAR(clock, 0.01, 1e-15);
        CHECK_LE(largest_difference(s->flow.u, kept, n), 0.0);
        CHECK_LE(largest_difference(s->flow.advecting, kept + n, n), 0.0);
        CHECK_LE(largest_difference(s->flow.pressure_grad, kept + 2 * n, n), 0.0);
        CHECK_LE(largest_difference(s->flow.p, kept + 3 * n, total), 0.0);
        free(kept);
        scene_free(s);
    }
}

TEST(bad_descs)
{
    scene s_, *s = &s_;
    scene_init(s, 6, 6, PD_SIDE_WALL, PD_SIDE_WALL);
    if (!scene_build(s)) return;
    pd_implicit_desc desc;
    pd_implicit none;
    memset(&desc, 0, sizeof desc);
    desc.rtol = -1.0;
    CHECK_INT((int)pd_implicit_build(&s->ctx, &s->flow, &s->steady, &desc, &none), (int)PD_ERR_ARGUMENT);
    CHECK_INT((int)pd_implicit_step(&s->ctx, &s->implicit, 0.0), (int)PD_ERR_ARGUMENT);
    CHECK_INT((int)pd_physics_run(&s->ctx, pd_implicit_process(&s->implicit), -1.0), (int)PD_ERR_ARGUMENT);
    /* steps that time cannot count have no end */
    s->implicit.time = 1.0;
    s->implicit.desc.max_step = 1e-17;
    CHECK_INT((int)pd_physics_run(&s->ctx, pd_implicit_process(&s->implicit), 2.0), (int)PD_ERR_STATE);
    CHECK(strstr(s->ctx.message, "do not lead on from t = 1 s to 2 s") != NULL);
    scene_free(s);
}

#if PD_DIM == 2
TEST_MAIN(ENTRY(second_order_in_time) ENTRY(taylor_green_vortex) ENTRY(pressure_of_short_steps) ENTRY(startup_flows)
              ENTRY(any_start_and_step) ENTRY(threads_change_no_bit) ENTRY(failed_steps_change_nothing)
                  ENTRY(bad_descs))
#else
TEST_MAIN(ENTRY(second_order_in_time) ENTRY(any_start_and_step) ENTRY(threads_change_no_bit)
              ENTRY(failed_steps_change_nothing) ENTRY(bad_descs))
#endif
