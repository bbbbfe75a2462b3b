/* test_weakly_compressible: weakly compressible flow in time, against closed forms.
 * dims: 1 2 */
#include "fixture.h"
#include "flow/weakly_compressible.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A flow in time and what it stands on. */
typedef struct run {
    scene s;
    pd_weakly_compressible unsteady;
} run;

/* Box [0, length] x [0, 1]; `open`: both x sides are outlets at p = 0. */
static pd_status run_build(run *r, double length, double h, int open, double nu, double force, double sound, pd_eos eos)
{
    scene *s = &r->s;
    pd_weakly_compressible_desc ud;
    memset(r, 0, sizeof *r);
    memset(&ud, 0, sizeof ud);
    scene_box(s, 0.0, h, 1, 1, 1);
    for (int d = 0; d < PD_DIM; d++) s->grid_desc.hi[d] = d == 0 ? length : 1.0;
    s->grid_desc.side[0] = s->grid_desc.side[1] = open ? PD_SIDE_OUTLET : PD_SIDE_WALL;
    s->with = WITH_FLOW;
    s->flow_desc.rho = 1.0;
    s->flow_desc.mu = nu;
    s->flow_desc.force[0] = force;
    s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    ud.sound_speed = sound;
    ud.eos = eos;
    /* the order of the wave is that in space: longer steps hide some of the error of coarse lattices */
    ud.cfl = PD_DIM == 1 ? 0.34 : 0.8;
    PD_TRY(scene_try(s));
    return pd_weakly_compressible_build(&s->ctx, &s->flow, &ud, &r->unsteady);
}

static void run_free(run *r)
{
    pd_weakly_compressible_free(&r->s.ctx, &r->unsteady);
    scene_free(&r->s);
}

#if PD_DIM == 1
static double total_mass(const run *r)
{
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < r->s.grid.total; i++)
        if (r->s.grid.kind[i] == PD_FLUID) pdi_compensated_sum_add(&sum, r->unsteady.density[i]);
    return pdi_compensated_sum_total(&sum);
}
#endif

#if PD_DIM == 2
/* Start-up of plane Poiseuille flow under a constant force: u nu/(f H^2) by the series. */
static double startup(double y, double tau)
{
    double u = 0.5 * y * (1.0 - y);
    for (int k = 1; k < 400; k += 2)
        u -= 4.0 / (k * k * k * pi * pi * pi) * sin(k * pi * y) * exp(-k * k * pi * pi * tau);
    return u;
}

static double startup_error(double h)
{
    run r;
    double error = 0.0;
    static const double times[] = {0.02, 0.05, 0.1, 0.2};
    /* reference velocity 1/8 at the end, Mach 0.0125; nothing compresses in a uniform stream */
    if (!CHECK_OK(&r.s.ctx, run_build(&r, 8.0 * h, h, 1, 1.0, 1.0, 10.0, PD_EOS_TAIT))) return 1.0;
    for (int n = 0; n < 4; n++) {
        CHECK_OK(&r.s.ctx, pd_physics_run(&r.s.ctx, pd_weakly_compressible_process(&r.unsteady), times[n]));
        for (int32_t i = 0; i < r.s.grid.total; i++) {
            double x[2];
            if (r.s.grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&r.s.grid, i, x);
            error = fmax(error, fabs(r.s.flow.u[i] - startup(x[1], times[n])));
            error = fmax(error, fabs(r.s.flow.u[r.s.grid.total + i]));
        }
    }
    run_free(&r);
    return error * 8.0;
}

TEST(poiseuille_startup)
{
    double coarse = startup_error(1.0 / 24.0), fine = startup_error(1.0 / 48.0);
    CHECK_LE(fine, 1e-3);
    CHECK_LE(1.8, log(coarse / fine) / log(2.0));
}
#endif

#if PD_DIM == 1
/* Standing wave between walls: p = A cos(pi x) cos(pi c t). Returns the largest error over the amplitude at t. */
static double standing_wave(double h, pd_eos eos, double *drift)
{
    run r;
    double amplitude = 1e-4, sound = 1.0, t = 1.3, error = 0.0;
    if (!CHECK_OK(&r.s.ctx, run_build(&r, 1.0, h, 0, 1e-8, 0.0, sound, eos))) return 1.0;
    for (int32_t i = 0; i < r.s.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&r.s.grid, i, x);
        if (r.s.grid.kind[i] == PD_FLUID) r.unsteady.density[i] = 1.0 + amplitude * cos(pi * x[0]);
    }
    double before = total_mass(&r);
    CHECK_OK(&r.s.ctx, pd_physics_run(&r.s.ctx, pd_weakly_compressible_process(&r.unsteady), t));
    *drift = fabs(total_mass(&r) / before - 1.0);
    for (int32_t i = 0; i < r.s.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&r.s.grid, i, x);
        if (r.s.grid.kind[i] != PD_FLUID) continue;
        error = fmax(error, fabs(r.s.flow.p[i] - amplitude * cos(pi * x[0]) * cos(pi * sound * t)));
    }
    run_free(&r);
    return error / amplitude;
}

TEST(standing_wave)
{
    double drift;
    double coarse = standing_wave(1.0 / 20.0, PD_EOS_TAIT, &drift);
    CHECK_LE(drift, 1e-14);
    double fine = standing_wave(1.0 / 80.0, PD_EOS_TAIT, &drift);
    CHECK_LE(drift, 1e-14);
    CHECK_LE(fine, 4e-3);
    CHECK_LE(1.8, log(coarse / fine) / log(4.0));
    CHECK_LE(standing_wave(1.0 / 40.0, PD_EOS_LINEAR, &drift), 2e-2);
    CHECK_LE(drift, 1e-14);
}
#endif

TEST(stability_limit)
{
    run r;
    CHECK_OK(&r.s.ctx, run_build(&r, 1.0, 1.0 / 20.0, 0, 1e-3, 0.0, 1.0, PD_EOS_LINEAR));
    double limit = pd_weakly_compressible_limit(&r.s.ctx, &r.unsteady), start = 0.0, end = 0.0;
    /* the roughest field: alternating densities */
    for (int32_t i = 0; i < r.s.grid.total; i++)
        if (r.s.grid.kind[i] == PD_FLUID) {
            int at[PD_DIM];
            pd_grid_index(&r.s.grid, i, at);
            r.unsteady.density[i] = 1.0 + (at[0] % 2 ? 1e-3 : -1e-3);
            start = fmax(start, fabs(r.unsteady.density[i] - 1.0));
        }
    for (int n = 0; n < 400; n++) CHECK_OK(&r.s.ctx, pd_weakly_compressible_step(&r.s.ctx, &r.unsteady, limit));
    for (int32_t i = 0; i < r.s.grid.total; i++)
        if (r.s.grid.kind[i] == PD_FLUID) end = fmax(end, fabs(r.unsteady.density[i] - 1.0));
    CHECK_LE(end, start);
    /* far above the limit the step is refused and the state kept, at the latest when it has blown up */
    pd_status status = PD_OK;
    for (int n = 0; n < 400 && status == PD_OK; n++)
        status = pd_weakly_compressible_step(&r.s.ctx, &r.unsteady, 6.0 * limit);
    CHECK_INT((int)status, (int)PD_RETRY);
    for (int32_t i = 0; i < r.s.grid.total; i++)
        if (r.s.grid.kind[i] == PD_FLUID) CHECK(r.unsteady.density[i] > 0.0);
    run_free(&r);
}

/* A lattice without surfaces, or one with: a box of walls with a ball in it. */
static pd_status bounds_build(run *r, double m, int surfaces, double nu)
{
    scene *s = &r->s;
    pd_weakly_compressible_desc ud;
    memset(r, 0, sizeof *r);
    memset(&ud, 0, sizeof ud);
    scene_box(s, m, 1.0, 24, 11, 11);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 2.3;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = d ? 4.4 : 9.7;
    if (surfaces) s->grid_desc.wall = &s->shapes[0];
    for (int d = 0; d < 2 * PD_DIM; d++) s->grid_desc.side[d] = surfaces ? PD_SIDE_WALL : PD_SIDE_PERIODIC;
    s->with = WITH_FLOW;
    s->flow_desc.rho = s->flow_desc.report_speed = s->flow_desc.report_length = ud.sound_speed = 1.0;
    s->flow_desc.mu = nu;
    ud.eos = PD_EOS_LINEAR;
    PD_TRY(scene_try(s));
    return pd_weakly_compressible_build(&s->ctx, &s->flow, &ud, &r->unsteady);
}

/* Energy of the disturbance after `steps` steps of `dt`, over that of the random one at the start. */
static double growth(run *r, double dt, int steps)
{
    uint32_t seed = 5;
    double start = 0.0, now = 0.0;
    int64_t total = r->s.grid.total;
    for (int n = -1; n < steps; n++) {
        if (n >= 0 && pd_weakly_compressible_step(&r->s.ctx, &r->unsteady, dt) != PD_OK) return HUGE_VAL;
        now = 0.0;
        for (int64_t i = 0; i < total; i++)
            for (int d = 0; d <= PD_DIM && r->s.grid.kind[i] == PD_FLUID; d++) {
                double *x = d < PD_DIM ? &r->s.flow.u[d * total + i] : &r->unsteady.density[i];
                double noise = random_share(&seed) - 0.5;
                if (n < 0) *x = (d == PD_DIM) + 1e-7 * noise;
                now += pow(*x - (d == PD_DIM), 2.0);
            }
        if (n < 0) start = now;
        if (now > 1e4 * start || now < 1e-4 * start) break;
    }
    return now / start;
}

/* The limit is at least 0.9 of the longest stable step without surfaces. Beside them it is a bound. */
TEST(limit_within_ten_per_cent)
{
    static const double viscosity[] = {1e-6, 0.1, 0.6, 10.0};
    for (int k = 0; k < 24; k++) {
        run r;
        double m = 1 + k / 8 * 2, nu = viscosity[k / 2 % 4];
        int surfaces = k % 2;
        if (!CHECK_OK(&r.s.ctx, bounds_build(&r, m, surfaces, nu))) return;
        double limit = pd_weakly_compressible_limit(&r.s.ctx, &r.unsteady);
        int safe = CHECK_LE(growth(&r, limit, 300), 4.0);
        int sharp = CHECK_LE(1e3, growth(&r, limit / (surfaces ? 0.5 : 0.9), 300));
        if (!safe || !sharp) NOTE("m = %g, nu = %g, %s, limit %g s", m, nu, surfaces ? "walls" : "no walls", limit);
        run_free(&r);
    }
}

TEST(threads_and_errors)
{
    run one, two;
    CHECK_OK(&one.s.ctx, run_build(&one, 1.0, 1.0 / 40.0, 0, 1e-2, 0.3, 1.0, PD_EOS_TAIT));
    CHECK_OK(&two.s.ctx, run_build(&two, 1.0, 1.0 / 40.0, 0, 1e-2, 0.3, 1.0, PD_EOS_TAIT));
    one.s.ctx.threads = 1;
    two.s.ctx.threads = 3;
    CHECK_OK(&one.s.ctx, pd_physics_run(&one.s.ctx, pd_weakly_compressible_process(&one.unsteady), 0.2));
    CHECK_OK(&two.s.ctx, pd_physics_run(&two.s.ctx, pd_weakly_compressible_process(&two.unsteady), 0.2));
    CHECK(memcmp(one.s.flow.u, two.s.flow.u, (size_t)(PD_DIM * one.s.grid.total) * sizeof(double)) == 0);
    CHECK(memcmp(one.s.flow.p, two.s.flow.p, (size_t)one.s.grid.total * sizeof(double)) == 0);
    run_free(&one);
    run_free(&two);
    CHECK_INT((int)run_build(&one, 1.0, 1.0 / 20.0, 0, 1e-2, 0.0, -1.0, PD_EOS_TAIT), (int)PD_ERR_ARGUMENT);
    run_free(&one);
}

TEST(values_that_are_not_finite)
{
    static const double wrong[2] = {(double)NAN, (double)INFINITY};
    run r;
    if (!CHECK_OK(&r.s.ctx, run_build(&r, 1.0, 0.2, 0, 1e-2, 0.0, 1.0, PD_EOS_TAIT))) return;
    for (int k = 0; k < 8; k++) {
        pd_weakly_compressible none;
        pd_weakly_compressible_desc desc;
        double *value[4];
        memset(&desc, 0, sizeof desc);
        desc.sound_speed = 1.0;
        value[0] = &desc.sound_speed;
        value[1] = &desc.gamma;
        value[2] = &desc.density_diffusion;
        value[3] = &desc.cfl;
        *value[k / 2] = wrong[k % 2];
        CHECK_INT((int)pd_weakly_compressible_build(&r.s.ctx, &r.s.flow, &desc, &none), (int)PD_ERR_ARGUMENT);
        CHECK(strstr(r.s.ctx.message, "all finite") != NULL);
    }
    for (int k = 0; k < 2; k++)
        CHECK_INT((int)pd_weakly_compressible_step(&r.s.ctx, &r.unsteady, wrong[k]), (int)PD_ERR_ARGUMENT);
    run_free(&r);
}

/* Each node of fluid starts with the density of its pressure, the others with 1. A pressure without one is refused. */
TEST(densities_of_pressures)
{
    for (int eos = PD_EOS_TAIT; eos <= PD_EOS_LINEAR; eos++) {
        run r;
        pd_weakly_compressible_desc desc;
        double c2 = 4.0;
        CHECK_OK(&r.s.ctx, run_build(&r, 1.0, 0.2, 0, 1e-2, 0.0, 1.0, PD_EOS_LINEAR));
        pd_weakly_compressible_free(&r.s.ctx, &r.unsteady);
        memset(&desc, 0, sizeof desc);
        desc.sound_speed = sqrt(c2);
        desc.eos = (pd_eos)eos;
        r.s.flow.rho = 3.0; /* of the message alone */
        for (int32_t i = 0; i < r.s.grid.total; i++)
            if (r.s.grid.kind[i] == PD_FLUID) r.s.flow.p[i] = 0.1 + 0.01 * (i % 13);
        if (!CHECK_OK(&r.s.ctx, pd_weakly_compressible_build(&r.s.ctx, &r.s.flow, &desc, &r.unsteady))) return;
        for (int32_t i = 0; i < r.s.grid.total; i++) {
            double p = r.s.flow.p[i] / c2, density = eos == PD_EOS_LINEAR ? 1.0 + p : pow(1.0 + 7.0 * p, 1.0 / 7.0);
            CHECK_REL(r.unsteady.density[i], r.s.grid.kind[i] == PD_FLUID ? density : 1.0, 1e-14);
        }
        pd_weakly_compressible_free(&r.s.ctx, &r.unsteady);
        for (int32_t i = 0; i < r.s.grid.total; i++) {
            char text[80];
            double held = r.s.flow.p[i];
            if (r.s.grid.kind[i] != PD_FLUID) continue;
            r.s.flow.p[i] = -c2;
            snprintf(text, sizeof text, "weakly_compressible: the pressure -12 Pa of node %d has no density", (int)i);
            CHECK_INT(pd_weakly_compressible_build(&r.s.ctx, &r.s.flow, &desc, &r.unsteady), PD_ERR_ARGUMENT);
            CHECK_STR(r.s.ctx.message, text);
            r.s.flow.p[i] = held;
        }
        run_free(&r);
    }
}

#if PD_DIM == 2
TEST_MAIN(ENTRY(poiseuille_startup) ENTRY(stability_limit) ENTRY(limit_within_ten_per_cent) ENTRY(threads_and_errors)
              ENTRY(values_that_are_not_finite) ENTRY(densities_of_pressures))
#else
TEST_MAIN(ENTRY(standing_wave) ENTRY(stability_limit) ENTRY(limit_within_ten_per_cent) ENTRY(threads_and_errors)
          ENTRY(values_that_are_not_finite) ENTRY(densities_of_pressures))
#endif
