/* test_force: friction and pressure on walls against closed forms; the balance of a box against both.
 * dims: 2 3 */
#include "flow/force.h"
#include "fixture.h"
#include <math.h>
#include <string.h>

#define RHO 900.0 /* [kg/m3] */
#define MU 0.03   /* [Pa s] */
#define DROP 5.0  /* [m/s2] of the kinematic pressure along x, or the body force */

static const double pi = 3.14159265358979323846;

static scene test_scene;

/* A box from the origin of n cells of 1/n[1] m, walls at the sides of y, periodic otherwise. */
static scene *scene_start(int x, int y, int z)
{
    scene *s = &test_scene;
    scene_box(s, 0.0, 1.0 / y, x, y, z);
    for (int side = 0; side < 2 * PD_DIM; side++)
        s->grid_desc.side[side] = side / 2 == 1 ? PD_SIDE_WALL : PD_SIDE_PERIODIC;
    s->with = WITH_FLOW;
    s->flow_desc.rho = RHO;
    s->flow_desc.mu = MU;
    s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    return s;
}

/* Velocity along x and pressure at every fluid node. */
typedef void (*field_fn)(const double *x, double *u, double *p);

static void fill(scene *s, field_fn field)
{
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        field(x, &s->flow.u[i], &s->flow.p[i]);
    }
}

/* nu u'' = -DROP between y = 0 and 1. */
static void parabola_forced(const double *x, double *u, double *p)
{
    *u = 0.5 * DROP * RHO / MU * x[1] * (1.0 - x[1]);
    *p = 0.0;
}

static void parabola_pressed(const double *x, double *u, double *p)
{
    parabola_forced(x, u, p);
    *p = -DROP * x[0];
}

static void parabola_inlet(void *user, const double *x, double *u)
{
    double p;
    (void)user;
    for (int d = 1; d < PD_DIM; d++) u[d] = 0.0;
    parabola_forced(x, u, &p);
}

/* Plane Poiseuille flow: friction is the body force on all fluid, or the drop of pressure over the part of the channel
 * that is asked for, for any horizon. */
TEST(friction_in_a_channel)
{
    for (int pressed = 0; pressed < 2; pressed++)
        for (int m = 1; m <= 4; m++) {
            scene *s = scene_start(16, 10, 8);
            double force[PD_DIM], friction[PD_DIM], pressure[PD_DIM], lo[PD_DIM], hi[PD_DIM];
            s->stencil_desc.m = m;
            if (pressed) s->grid_desc.side[0] = PD_SIDE_INLET, s->grid_desc.side[1] = PD_SIDE_OUTLET;
            s->flow_desc.force[0] = pressed ? 0.0 : DROP;
            s->flow_desc.p_out = pressed ? -DROP * 1.6 * RHO : 0.0;
            s->flow_desc.inlet = parabola_inlet;
            if (!scene_build(s)) return;
            fill(s, pressed ? parabola_pressed : parabola_forced);
            memcpy(lo, s->grid_desc.lo, sizeof lo);
            memcpy(hi, s->grid_desc.hi, sizeof hi);
            lo[0] = 0.5;
            hi[0] = 1.1;
            double area = 0.6 * (PD_DIM == 3 ? 0.8 : 1.0);
            pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, force, friction, pressure);
            CHECK_NEAR(friction[0], RHO * DROP * area, 1e-9 * RHO * DROP * area);
            CHECK_NEAR(pressure[0], 0.0, 1e-9 * RHO * DROP);
            for (int d = 0; d < PD_DIM; d++) CHECK_NEAR(force[d], friction[d] + pressure[d], 1e-9);
            for (int d = 1; d < PD_DIM; d++) CHECK_NEAR(force[d], 0.0, 1e-9 * RHO * DROP);
            scene_free(s);
        }
}

static void lid(void *user, const double *x, double *u)
{
    (void)user;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    if (x[1] > 0.5) u[0] = 2.0;
}

static void shear(const double *x, double *u, double *p)
{
    *u = 2.0 * x[1];
    *p = 7.0;
}

/* Couette flow under pressure: the lower wall is dragged along, the upper one held back, both pressed outwards. */
TEST(moving_wall)
{
    scene *s = scene_start(12, 12, 8);
    double force[PD_DIM], friction[PD_DIM], pressure[PD_DIM], lo[PD_DIM], hi[PD_DIM];
    s->flow_desc.wall = lid;
    if (!scene_build(s)) return;
    fill(s, shear);
    for (int upper = 0; upper < 2; upper++) {
        double sign = upper ? 1.0 : -1.0, area = PD_DIM == 3 ? 8.0 / 12.0 : 1.0;
        memcpy(lo, s->grid_desc.lo, sizeof lo);
        memcpy(hi, s->grid_desc.hi, sizeof hi);
        if (upper) lo[1] = 0.5;
        else hi[1] = 0.5;
        pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, force, friction, pressure);
        CHECK_NEAR(friction[0], -sign * 2.0 * MU * area, 1e-11);
        CHECK_NEAR(pressure[1], sign * 7.0 * RHO * area, 1e-8);
        CHECK_NEAR(force[0], friction[0], 1e-8);
    }
    scene_free(s);
}

#define BALL 0.3 /* [m] */

static void at_rest(const double *x, double *u, double *p)
{
    *u = 0.0;
    *p = DROP * x[0];
}

/* Relative error of the lift of a ball in a fluid at rest, from the pressure on its surface. The balance of a box gives
 * the weight of the fluid that it replaces, too, and not that of its cells. */
static double lift(int n)
{
    scene *s = scene_start(n, n, n);
    double force[PD_DIM], balance[PD_DIM], lo[PD_DIM], hi[PD_DIM], volume = PD_DIM == 3 ? 4.0 / 3.0 * BALL : 1.0;
    volume *= pi * BALL * BALL;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = BALL;
    s->grid_desc.solid = &s->shapes[0];
    s->flow_desc.force[0] = DROP;
    for (int side = 0; side < 2 * PD_DIM; side++) s->grid_desc.side[side] = PD_SIDE_WALL;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = 0.503 - 0.004 * d;
        lo[d] = 0.1;
        hi[d] = 0.9;
    }
    if (!scene_build(s)) return 1.0;
    fill(s, at_rest);
    pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, force, NULL, NULL);
    CHECK_OK(&s->ctx, pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, balance));
    CHECK_NEAR(balance[0], -RHO * DROP * volume, 3e-4 * RHO * DROP * volume);
    double error = fabs(force[0] / (-RHO * DROP * volume) - 1.0);
    for (int d = 1; d < PD_DIM; d++) {
        CHECK_NEAR(balance[d], 0.0, 1e-10 * RHO * DROP);
        error = fmax(error, fabs(force[d] / (RHO * DROP * volume)));
    }
    scene_free(s);
    return error;
}

static void weight(void *user, const double *x, double *force)
{
    (void)user;
    (void)x;
    for (int d = 0; d < PD_DIM; d++) force[d] = d ? 0.0 : DROP;
}

/* A body force that a callback gives is the same as a uniform one, around a ball of metal and one that is a wall: both
 * give the weight of the fluid that the ball replaces. */
TEST(force_of_a_callback)
{
    for (int walled = 0; walled < 2; walled++) {
        double balance[2][PD_DIM], surface[2][PD_DIM], size = RHO * DROP * pi * BALL * BALL;
        size *= PD_DIM == 3 ? 4.0 / 3.0 * BALL : 1.0;
        for (int called = 0; called < 2; called++) {
            double lo[PD_DIM], hi[PD_DIM];
            int n = PD_DIM == 2 ? 30 : 20;
            scene *s = scene_start(n, n, n);
            s->shapes[0].type = PD_SHAPE_BALL;
            s->shapes[0].radius = BALL;
            if (walled) s->grid_desc.wall = &s->shapes[0];
            else s->grid_desc.solid = &s->shapes[0];
            if (called) s->flow_desc.body = weight;
            else s->flow_desc.force[0] = DROP;
            for (int side = 0; side < 2 * PD_DIM; side++) s->grid_desc.side[side] = PD_SIDE_WALL;
            for (int d = 0; d < PD_DIM; d++) {
                s->shapes[0].a[d] = 0.503 - 0.004 * d;
                lo[d] = 0.1;
                hi[d] = 0.9;
            }
            if (!scene_build(s)) return;
            fill(s, at_rest);
            pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, surface[called], NULL, NULL);
            CHECK_OK(&s->ctx, pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, balance[called]));
            scene_free(s);
        }
        CHECK_NEAR(balance[1][0], -size, 1e-3 * size);
        for (int d = 0; d < PD_DIM; d++) {
            CHECK_NEAR(balance[1][d], balance[0][d], 1e-12 * size);
            CHECK_NEAR(surface[1][d], surface[0][d], 1e-12 * size);
        }
    }
}

TEST(lift_of_a_ball)
{
    double coarse = lift(PD_DIM == 2 ? 30 : 20), fine = lift(PD_DIM == 2 ? 120 : 40);
    NOTE("errors %.3g, %.3g", coarse, fine);
    /* in 3D, four cells lie between the ball and the walls of the coarse box */
    CHECK_LE(coarse, PD_DIM == 2 ? 1e-4 : 1e-2);
    CHECK_LE(fine, 1e-4);
}

#if PD_DIM == 3
#define TUBE 0.45 /* [m] */

static void paraboloid(const double *x, double *u, double *p)
{
    double y = x[1] - 0.5, z = x[2] - 0.5;
    *u = 0.25 * DROP * RHO / MU * (TUBE * TUBE - y * y - z * z);
    *p = 0.0;
}

/* Hagen-Poiseuille flow, driven by a body force. */
static double tube(int n)
{
    scene *s = scene_start(4, n, n);
    double force[PD_DIM], wanted = RHO * DROP * pi * TUBE * TUBE * 4.0 / n;
    s->shapes[0].type = PD_SHAPE_CYLINDER;
    s->shapes[0].radius = TUBE;
    s->shapes[1].type = PD_SHAPE_COMPLEMENT;
    s->shapes[1].child_count = 1;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 0.5;
    s->grid_desc.wall = &s->shapes[1];
    s->grid_desc.side[2] = s->grid_desc.side[3] = s->grid_desc.side[4] = s->grid_desc.side[5] = PD_SIDE_WALL;
    s->flow_desc.force[0] = DROP;
    if (!scene_build(s)) return 1.0;
    fill(s, paraboloid);
    pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, s->grid_desc.lo, s->grid_desc.hi, force, NULL, NULL);
    double error = fabs(force[0] / wanted - 1.0);
    NOTE("%d cells: %.3g", n, error);
    scene_free(s);
    return error;
}

TEST(friction_in_a_tube)
{
    /* what is left is the share of cells that the circle cuts */
    CHECK_LE(tube(20), 3e-4);
    CHECK_LE(tube(40), 1e-4);
}
#endif

/* A channel of width 1 between two half-spaces that meet inlets and outlets, turned by any angle and cut anywhere. */
#define TURNED_LOW 0.37 /* [m] of the lower wall at x = 0 */

static double turned;   /* [rad] */
static double constant; /* [m2/s2] kinematic pressure on top */

static double turned_height(const double *x) { return (x[1] - TURNED_LOW) * cos(turned) - x[0] * sin(turned); }

static void turned_fill(scene *s)
{
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        double y = turned_height(x), u = 0.5 * DROP * RHO / MU * y * (1.0 - y);
        s->flow.u[i] = u * cos(turned);
        s->flow.u[s->grid.total + i] = u * sin(turned);
        s->flow.p[i] = constant - DROP * (x[0] * cos(turned) + (x[1] - TURNED_LOW) * sin(turned));
    }
}

/* Largest relative errors of friction and of the force of pressure on the lower wall between x = 0.61 and 1.27. */
static void turned_errors(int n, double m, double angle, double p, double *friction_error, double *force_error)
{
    scene *s = scene_start(2 * n, 4 * n, 4);
    double force[PD_DIM], friction[PD_DIM], pressure[PD_DIM], lo[PD_DIM], hi[PD_DIM];
    double depth = PD_DIM == 3 ? 4.0 / n : 1.0;
    *friction_error = *force_error = 1.0;
    turned = angle;
    constant = p;
    for (int d = 0; d < PD_DIM; d++) s->stencil_desc.h[d] = 1.0 / n;
    s->stencil_desc.m = m;
    s->grid_desc.hi[0] = 2.0;
    s->grid_desc.hi[1] = 4.0;
    if (PD_DIM == 3) s->grid_desc.hi[PD_DIM - 1] = depth;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    for (int k = 0; k < 2; k++) {
        s->shapes[k].type = PD_SHAPE_HALF_SPACE;
        s->shapes[k].a[1] = k ? TURNED_LOW + 1.0 / cos(angle) : TURNED_LOW;
        s->shapes[k].b[0] = (k ? 1.0 : -1.0) * sin(angle);
        s->shapes[k].b[1] = (k ? -1.0 : 1.0) * cos(angle);
    }
    s->shapes[2].type = PD_SHAPE_UNION;
    s->shapes[2].child_count = 2;
    s->shapes[2].child[1] = 1;
    s->grid_desc.wall = &s->shapes[2];
    if (!scene_build(s) || !CHECK_INT(pdi_flow_find_surface_patches(&s->ctx, &s->flow), PD_OK)) return;
    turned_fill(s);
    memcpy(lo, s->grid_desc.lo, sizeof lo);
    memcpy(hi, s->grid_desc.hi, sizeof hi);
    lo[0] = 0.61;
    hi[0] = 1.27;
    double area = (hi[0] - lo[0]) / cos(angle) * depth, drag = 0.5 * DROP * RHO * area;
    double mean = p - DROP * 0.5 * (lo[0] + hi[0]) / cos(angle), size = RHO * fabs(mean) * area;
    double wanted[PD_DIM], rubbed[PD_DIM];
    memset(wanted, 0, sizeof wanted);
    memset(rubbed, 0, sizeof rubbed);
    rubbed[0] = drag * cos(angle);
    rubbed[1] = drag * sin(angle);
    wanted[0] = RHO * mean * area * sin(angle);
    wanted[1] = -RHO * mean * area * cos(angle);
    pd_force_surface(&s->ctx, &s->flow, 0, lo, hi, force, friction, pressure);
    *friction_error = *force_error = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        *friction_error = fmax(*friction_error, fabs(friction[d] - rubbed[d]) / drag);
        *force_error = fmax(*force_error, fabs(pressure[d] - wanted[d]) / size);
    }
    scene_free(s);
}

TEST(turned_channel)
{
    static const double angles[] = {0.0, 5.0, 18.0, 26.565, 37.0, 45.0};
    for (int m = 1; m <= 3; m++)
        for (int k = 0; k < 6; k++) {
            double friction, pressure;
            for (int loaded = 0; loaded < 2; loaded++) {
                turned_errors(10, m, angles[k] * pi / 180.0, loaded ? 1e6 : 0.0, &friction, &pressure);
                CHECK_LE(friction, loaded ? 1e-4 : 1e-9); /* gradients of a large pressure round */
                CHECK_LE(pressure, 1e-12);
            }
        }
}

/* Two bodies of any field: each has its own force, and with the sides of the box they add up to that on everything.
 * Mirror and periodic sides repeat what lies before them. */
static void wavy(const double *x, double *u, double *p)
{
    *u = sin(7.0 * x[0] + 3.0 * x[1]) + 0.5 * x[1];
    *p = cos(5.0 * x[0]) * (1.0 + x[1]) + 3.0 * x[PD_DIM - 1];
}

TEST(several_bodies)
{
    static const pd_side sides[3] = {PD_SIDE_PERIODIC, PD_SIDE_MIRROR, PD_SIDE_WALL};
    for (int kind = 0; kind < 3; kind++) {
        scene *s = scene_start(24, 20, 16);
        double all[PD_DIM], part[PD_DIM], sum[PD_DIM], lo[PD_DIM], hi[PD_DIM], size = 0.0;
        s->shapes[0].type = PD_SHAPE_BALL;
        s->shapes[0].radius = 0.21;
        s->shapes[1].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            s->shapes[0].a[d] = d ? 0.31 : 0.02; /* through the side x- */
            s->shapes[1].a[d] = 0.6;
            s->shapes[1].b[d] = d ? 0.8 : 0.9;
        }
        s->grid_desc.wall = &s->shapes[0];
        s->grid_desc.solid = &s->shapes[1];
        s->grid_desc.side[0] = s->grid_desc.side[1] = sides[kind];
        s->flow_desc.force[0] = DROP;
        if (!scene_build(s)) return;
        fill(s, wavy);
        memcpy(lo, s->grid_desc.lo, sizeof lo);
        memcpy(hi, s->grid_desc.hi, sizeof hi);
        pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, all, NULL, NULL);
        memset(sum, 0, sizeof sum);
        for (int shape = 0; shape < 2; shape++) {
            pd_force_surface(&s->ctx, &s->flow, shape, lo, hi, part, NULL, NULL);
            for (int d = 0; d < PD_DIM; d++) {
                sum[d] += part[d];
                size = fmax(size, fabs(part[d]));
            }
        }
        CHECK_LE(1.0, size);
        double rest[PD_DIM];
        pd_force_surface(&s->ctx, &s->flow, PD_FORCE_BOX_SIDES, lo, hi, rest, NULL, NULL);
        for (int d = 0; d < PD_DIM; d++) CHECK_NEAR(sum[d] + rest[d], all[d], 1e-9 * (size + fabs(all[d])));
        scene_free(s);
    }
}

#if PD_DIM == 2
#define DRAG 5.57953523384   /* dfg_cylinder_2d1.csv */
#define LIFT 0.010618948146

static void dfg_inlet(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 6.0 * 0.2 * x[1] * (0.41 - x[1]) / (0.41 * 0.41);
    u[1] = 0.0;
}

/* Errors of drag (relative) and lift coefficient (absolute), from the surface and from a box, of the cylinder in a
 * channel (Schaefer and Turek 1996, 2D-1) on x times y cells. */
static int dfg_errors(int x, int y, double m, double *error)
{
    scene *s = scene_start(1, 1, 1);
    pd_steady steady;
    pd_steady_desc desc;
    pd_steady_result result;
    double lo[PD_DIM], hi[PD_DIM], surface[PD_DIM], around[PD_DIM], scale = 2.0 / (0.2 * 0.2 * 0.1);
    memset(&desc, 0, sizeof desc);
    memset(&steady, 0, sizeof steady);
    s->stencil_desc.m = m;
    s->stencil_desc.h[0] = 2.2 / x;
    s->stencil_desc.h[1] = 0.41 / y;
    s->grid_desc.hi[0] = 2.2;
    s->grid_desc.hi[1] = 0.41;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    s->grid_desc.side[1] = PD_SIDE_OUTLET;
    s->grid_desc.wall = &s->shapes[0];
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 0.05;
    s->flow_desc.rho = 1.0;
    s->flow_desc.mu = 1e-3;
    s->flow_desc.report_speed = 0.2;
    s->flow_desc.report_length = 0.1;
    s->flow_desc.inlet = dfg_inlet;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = 0.2;
        lo[d] = 0.1;
        hi[d] = 0.3;
    }
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &desc, &steady)) ||
        !CHECK_OK(&s->ctx, pd_steady_solve(&s->ctx, &steady, &result)))
        return 0;
    pd_force_surface(&s->ctx, &s->flow, PD_FORCE_ALL, lo, hi, surface, NULL, NULL);
    CHECK_OK(&s->ctx, pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, around));
    error[0] = fabs(scale * surface[0] / DRAG - 1.0);
    error[1] = fabs(scale * around[0] / DRAG - 1.0);
    error[2] = fabs(scale * surface[1] - LIFT);
    error[3] = fabs(scale * around[1] - LIFT);
    NOTE("%d x %d, m = %g: drag %.3f %% %.3f %%, lift %.4f %.4f, %d evaluations", x, y, m, 100.0 * error[0],
         100.0 * error[1], scale * surface[1], scale * around[1], (int)result.evaluations);
    pd_steady_free(&s->ctx, &steady);
    scene_free(s);
    return 1;
}

/* Wherever the lattice cuts the surface, the error of the drag falls with the square of the horizon, and that of the
 * lift, which changes sign from lattice to lattice, with the square of the spacing. */
TEST(lattice_anywhere)
{
    static const int cells[][3] = {{221, 42, 2}, {222, 43, 2}, {223, 44, 2}, {441, 83, 2}, {442, 84, 2}, {443, 85, 2},
                                   {442, 84, 1}, {264, 50, 3}, {268, 49, 3}, {441, 83, 3}};
    for (int k = 0; k < (int)(sizeof cells / sizeof cells[0]); k++) {
        double error[4], horizon = cells[k][2] * (22.0 / cells[k][0]), spacing = 22.0 / cells[k][0];
        if (!dfg_errors(cells[k][0], cells[k][1], cells[k][2], error)) return;
        CHECK_LE(error[0], 0.35 * horizon * horizon);
        CHECK_LE(error[1], 0.30 * horizon * horizon);
        for (int side = 0; side < 2; side++) CHECK_LE(error[2 + side], 3.0 * spacing * spacing);
    }
}
#endif

/* The box has to lie in the fluid. */
TEST(bad_boxes)
{
    scene *s = scene_start(12, 12, 12);
    double lo[PD_DIM], hi[PD_DIM], force[PD_DIM];
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 0.2;
    s->grid_desc.solid = &s->shapes[0];
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 0.5;
    if (!scene_build(s)) return;
    for (int d = 0; d < PD_DIM; d++) lo[d] = 0.05, hi[d] = 0.8;
    CHECK_INT((int)pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, force), (int)PD_ERR_GEOMETRY);
    for (int d = 0; d < PD_DIM; d++) lo[d] = 0.3;
    CHECK_INT((int)pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, force), (int)PD_ERR_GEOMETRY);
    for (int d = 0; d < PD_DIM; d++) lo[d] = 0.9;
    CHECK_INT((int)pd_force_momentum_balance(&s->ctx, &s->flow, lo, hi, force), (int)PD_ERR_GEOMETRY);
    scene_free(s);
}

#if PD_DIM == 2
/* Slow flow past a cylinder, Stokes: psi = (r ln r - r/2 + 1/(2 r)) sin, p = -2 cos/r, lap u = grad p. */
static void stokes(const double *x, double *u, double *p)
{
    double square = x[0] * x[0] + x[1] * x[1], r = sqrt(square), c = x[0] / r, s = x[1] / r;
    double radial = (log(r) - 0.5 + 0.5 / square) * c, turn = -(log(r) + 0.5 - 0.5 / square) * s;
    u[0] = radial * c - turn * s;
    u[1] = radial * s + turn * c;
    *p = -2.0 * c / r;
}

/* Largest residuals of momentum along the normal and of continuity beside a cylinder of n cells to the radius, shifted
 * by a part of a cell, of the closed form. */
static void slow_residuals(int n, double m, double *momentum, double *continuity)
{
    scene *s = &test_scene;
    double tiny = 1e-9; /* m/s: inertia is none */
    *momentum = *continuity = 0.0;
    scene_box(s, m, 1.0 / n, 4 * n, 4 * n, 1);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 1.0;
    for (int d = 0; d < 2; d++) s->shapes[0].a[d] = 2.0 - 0.3 / n;
    s->grid_desc.solid = &s->shapes[0];
    s->with = WITH_FLOW | WITH_STEADY;
    s->fields = 2;
    s->flow_desc.rho = s->flow_desc.mu = 1.0;
    if (!scene_build(s)) return;
    CHECK_INT(pdi_flow_find_surface_patches(&s->ctx, &s->flow), PD_OK);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[2], u[2], p;
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < 2; d++) x[d] -= s->shapes[0].a[d];
        stokes(x, u, &p);
        for (int d = 0; d < 2; d++) s->flow.u[d * s->grid.total + i] = tiny * u[d];
        s->flow.p[i] = tiny * p;
    }
    pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[0], s->field[1]);
    for (int32_t r = 0; r < s->bonds.rows; r++) {
        double x[2];
        int32_t node = s->bonds.node[r];
        if (!s->bonds.near_smooth_surface[r]) continue;
        pd_grid_position(&s->grid, node, x);
        for (int d = 0; d < 2; d++) x[d] -= s->shapes[0].a[d];
        double along = (s->field[0][node] * x[0] + s->field[0][s->grid.total + node] * x[1]) / hypot(x[0], x[1]);
        *momentum = fmax(*momentum, fabs(along) / tiny);
        *continuity = fmax(*continuity, fabs(s->field[1][node]) / tiny);
    }
    scene_free(s);
}

/* Rows beside a surface that cuts the lattice anywhere: momentum of first order, continuity of second. A radius has 10
 * and 40 horizons. */
TEST(slow_flow)
{
    double momentum[2], continuity[2];
    for (int m = 1; m < 5; m *= 2) {
        for (int k = 0; k < 2; k++) slow_residuals((k ? 40 : 10) * m, m, &momentum[k], &continuity[k]);
        NOTE("m = %d: momentum %.3g, %.3g; continuity %.3g, %.3g", m, momentum[0], momentum[1], continuity[0],
             continuity[1]);
        CHECK_LE(momentum[1], 0.1);
        CHECK_LE(0.75, log(momentum[0] / momentum[1]) / log(4.0));
        CHECK_LE(continuity[1], 0.003);
        CHECK_LE(1.6, log(continuity[0] / continuity[1]) / log(4.0));
    }
}
#endif

#if PD_DIM == 3
TEST_MAIN(ENTRY(friction_in_a_channel) ENTRY(moving_wall) ENTRY(force_of_a_callback) SLOW_ENTRY(lift_of_a_ball)
              ENTRY(friction_in_a_tube) SLOW_ENTRY(turned_channel) SLOW_ENTRY(several_bodies) ENTRY(bad_boxes))
#else
TEST_MAIN(ENTRY(friction_in_a_channel) ENTRY(moving_wall) ENTRY(force_of_a_callback) ENTRY(lift_of_a_ball)
              SLOW_ENTRY(lattice_anywhere) ENTRY(turned_channel) ENTRY(several_bodies) ENTRY(bad_boxes)
                  ENTRY(slow_flow))
#endif
