/* clock: what follows time: walls, inlets, forces, held and entering concentrations, against closed forms; laws whose
 * steps see them.
 * dims: 2 */
#include "flow/implicit.h"
#include "flow/weakly_compressible.h"
#include "fixture.h"
#include <complex.h>

#define PI 3.14159265358979323846
#define EDGE 1e-3  /* [m] */
#define NU 1e-6    /* [m2/s] */
#define WHOLE 1.0  /* [s] of a period */

static scene test_scene;
static double time_now; /* [s] */
static pd_implicit implicit;
static pd_weakly_compressible unsteady;

static double turn(double t) { return 2.0 * PI * t / WHOLE; }

/* A channel of `cells` across y, periodic along x. */
static scene *channel(int cells)
{
    scene *s = &test_scene;
    scene_box(s, 0.0, EDGE / cells, 4, cells, 1);
    s->grid_desc.side[0] = s->grid_desc.side[1] = PD_SIDE_PERIODIC;
    s->with = WITH_FLOW | WITH_STEADY;
    s->flow_desc.rho = 1000.0;
    s->flow_desc.mu = NU * 1000.0;
    s->flow_desc.report_speed = 1e-3;
    s->flow_desc.report_length = EDGE;
    s->flow_desc.clock = &time_now;
    time_now = 0.0;
    return s;
}

static int channel_build(scene *s, double m)
{
    pd_implicit_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(&implicit, 0, sizeof implicit);
    memset(&unsteady, 0, sizeof unsteady);
    desc.stage_tolerance = 1e-9;
    return scene_build_m(s, m) && CHECK_OK(&s->ctx, pd_implicit_build(&s->ctx, &s->flow, &s->steady, &desc, &implicit));
}

static void channel_free(scene *s)
{
    pd_implicit_free(&s->ctx, &implicit);
    pd_weakly_compressible_free(&s->ctx, &unsteady);
    scene_free(s);
}

/* ---- closed forms, as real parts of amplitudes over exp(i w t) ---- */

#define LAMBDA csqrt(I * (2.0 * PI / WHOLE) / NU) /* [1/m] */

/* Force f cos(w t) between walls at rest: Womersley flow of a channel. */
static double complex womersley(double y)
{
    const double f = 1e-2, w = 2.0 * PI / WHOLE;
    return f / (I * w) * (1.0 - ccosh(LAMBDA * (y - 0.5 * EDGE)) / ccosh(LAMBDA * 0.5 * EDGE));
}

static void womersley_force(void *user, const double *x, double *f)
{
    (void)x;
    f[0] = 1e-2 * cos(turn(*(const double *)user));
    f[1] = 0.0;
}

/* A wall at y = 0 that moves as U cos(w t), the other one at rest: Stokes' second problem. */
static double complex stokes(double y) { return 1e-3 * csinh(LAMBDA * (EDGE - y)) / csinh(LAMBDA * EDGE); }

static void stokes_wall(void *user, const double *x, double *u)
{
    u[0] = x[1] < 0.5 * EDGE ? 1e-3 * cos(turn(*(const double *)user)) : 0.0;
    u[1] = 0.0;
}

typedef struct problem {
    const char *name;
    double complex (*amplitude)(double y);
    pd_velocity_fn wall, body;
} problem;

static const problem problems[2] = {{"Womersley", womersley, NULL, womersley_force},
                                    {"Stokes' second problem", stokes, stokes_wall, NULL}};

static double exact(const problem *p, double y, double t) { return creal(p->amplitude(y) * cexp(I * turn(t))); }

/* Half a period from the closed form in `steps` equal steps; the field [cells] over y, and its largest error over the
 * largest speed. */
static double follow(const problem *p, int cells, double m, int steps, int forward, double *field)
{
    scene *s = channel(cells);
    double worst = 0.0, end = 0.5 * WHOLE;
    s->flow_desc.wall = p->wall;
    s->flow_desc.body = p->body;
    s->flow_desc.wall_user = s->flow_desc.body_user = &time_now;
    if (!channel_build(s, m)) return NAN;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID) s->flow.u[i] = exact(p, x[1], 0.0);
    }
    pd_weakly_compressible_desc weak;
    memset(&weak, 0, sizeof weak);
    weak.sound_speed = 0.02;
    if (forward && !CHECK_OK(&s->ctx, pd_weakly_compressible_build(&s->ctx, &s->flow, &weak, &unsteady))) return NAN;
    if (forward) CHECK_OK(&s->ctx, pd_physics_run(&s->ctx, pd_weakly_compressible_process(&unsteady), end));
    for (int n = 0; n < steps && !forward; n++)
        if (!CHECK_OK(&s->ctx, pd_implicit_step(&s->ctx, &implicit, end / steps))) return NAN;
    for (int n = 0; n < cells; n++) {
        int at[2] = {1, 0};
        at[1] = n;
        double u = s->flow.u[pd_grid_node(&s->grid, at)];
        if (field) field[n] = u;
        worst = fmax(worst, fabs(u - exact(p, (n + 0.5) * EDGE / cells, end)) / 1e-3);
    }
    channel_free(s);
    return worst;
}

/* Second order in time and in space, with walls whose acceleration bends the profile beside them. */
TEST(second_order_in_time_and_space)
{
    static double field[4][16];
    for (int k = 0; k < 2; k++) {
        const problem *p = &problems[k];
        double change[3] = {0.0, 0.0, 0.0};
        for (int level = 0; level < 4; level++) {
            follow(p, 16, 2.0, 20 << level, 0, field[level]);
            for (int n = 0; n < 16 && level; n++)
                change[level - 1] = fmax(change[level - 1], fabs(field[level][n] - field[level - 1][n]));
        }
        double coarse = follow(p, 16, 2.0, 160, 0, NULL), fine = follow(p, 32, 2.0, 160, 0, NULL);
        double finest = follow(p, 96, 2.0, 160, 0, NULL);
        NOTE("%s: changes in time %.3g %.3g %.3g, errors at 16, 32, 96 cells %.3g %.3g %.3g", p->name, change[0],
             change[1], change[2], coarse, fine, finest);
        CHECK_LE(3.6, change[1] / change[2]);
        CHECK_LE(change[1] / change[2], 4.4);
        CHECK_LE(3.3, coarse / fine);
        CHECK_LE(finest, k ? 2e-5 : 1e-4); /* walls that do not accelerate: 5.4e-5 */
    }
}

/* Explicit steps see the time of their stages. */
TEST(explicit_steps_follow)
{
    for (int k = 0; k < 2; k++) {
        double error = follow(&problems[k], 16, 2.0, 0, 1, NULL);
        double other = follow(&problems[k], 16, 2.0, 160, 0, NULL);
        NOTE("%s: explicit steps off by %.3g, implicit ones by %.3g", problems[k].name, error, other);
        CHECK_NEAR(error, other, 2e-5);
        CHECK_LE(error, k ? 7e-4 : 4e-3); /* of 16 cells */
    }
}

TEST_MAIN(SLOW_ENTRY(second_order_in_time_and_space) ENTRY(explicit_steps_follow))
