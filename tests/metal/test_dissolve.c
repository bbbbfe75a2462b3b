/* dissolve: speed of fronts of every shape, saturation, exact amounts, walls, small and empty solids.
 * dims: 2 3 */
#include "fixture.h"
#include <stdlib.h>

#define PI 3.14159265358979323846
#define CS 71500.0        /* [mol/m3] */
#define SPEED 1e-9        /* [m/s] */
#define H 1e-5            /* [m] */

typedef struct law {
    double speed, csat; /* csat 0: none */
} law;

static scene test_scene;
static law rate;

static double rate_law(void *user, const pd_rate_at *at)
{
    const law *l = (const law *)user;
    return l->csat > 0.0 ? l->speed * (1.0 - at->c / l->csat) : l->speed;
}

/* A closed box from the origin of the given edges [m]; a fluid that takes up any amount. */
static scene *scene_start(const double *edge)
{
    scene *s = &test_scene;
    scene_reset(s);
    for (int d = 0; d < PD_DIM; d++) s->grid_desc.hi[d] = edge[d];
    s->grid_desc.solid = &s->shapes[0];
    s->with = WITH_TRANSPORT | WITH_DISSOLVE | WITH_COUPLE;
    s->transport_desc.diffusivity = 1e-9;
    memset(&rate, 0, sizeof rate);
    rate.speed = SPEED;
    s->dissolve_desc.solid = CS;
    s->dissolve_desc.rate = rate_law;
    s->dissolve_desc.rate_user = &rate;
    return s;
}

static scene *scene_cells(int x, int y, int z)
{
    double edge[3];
    edge[0] = x * H;
    edge[1] = y * H;
    edge[2] = z * H;
    return scene_start(edge);
}

static int metal_grid(scene *s, double h, double m)
{
    for (int d = 0; d < PD_DIM; d++) s->stencil_desc.h[d] = h;
    return scene_grid_m(s, m);
}

static int metal_rest(scene *s) { return scene_rest(s) && CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple)); }
static int metal_build(scene *s, double h, double m) { return metal_grid(s, h, m) && metal_rest(s); }

/* Steps up to `end`; the ledger closes to rounding after each, and each ends. */
static int run_to(scene *s, double end)
{
    for (int steps = 0; s->couple.time < end; steps++) {
        if (!CHECK(steps < 20000)) return 0;
        if (!CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, &s->couple, end))) return 0;
        if (!CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-12)) return 0;
    }
    return 1;
}

/* ---- speeds ---- */

/* Metal on the low side of a closed box, a flat front across `axis`: what is left is the depth of the metal less
 * speed times time, to rounding, at every time, for every spacing, horizon and threshold; across the whole box, so that
 * sides do not matter. */
static void check_flat(int axis, double h, double m, double threshold)
{
    double edge[3], lo[3] = {0.0, 0.0, 0.0};
    for (int d = 0; d < PD_DIM; d++) edge[d] = (d == axis ? 20.0 : 4.0) * H;
    scene *s = scene_start(edge);
    edge[axis] = 10.0 * H;
    scene_solid_box(&s->shapes[0], lo, edge);
    s->dissolve_desc.threshold = threshold;
    if (!metal_build(s, h, m)) return;
    for (int k = 1; k <= 6; k++) {
        double depth = 1.1 * k * H;
        if (!run_to(s, depth / SPEED)) return;
        double gone = s->couple.ledger[0].start - s->couple.ledger[0].solid;
        /* a threshold leaves its share of each dissolved layer in the fluid, which counts as dissolved at once */
        double receded = gone / s->couple.ledger[0].start * 10.0 * H;
        if (!(threshold > 0.0)) CHECK_REL(receded, depth, 1e-10);
        else CHECK_NEAR(receded, depth, (threshold + 1e-9) * m * h);
    }
    scene_free(s);
}

TEST(flat_front_is_exact)
{
    for (int axis = 0; axis < PD_DIM; axis++)
        for (int m = 1; m <= 4; m++) {
            check_flat(axis, H, m, 0.0);
            if (PD_DIM == 2) check_flat(axis, 0.5 * H, m, 0.0);
        }
    if (PD_DIM == 2) check_flat(0, 0.25 * H, 3.0, 0.0);
    else check_flat(2, 0.5 * H, 2.0, 0.0);
}

/* A half-space cut at 45 degrees (extruded in 3D). The sides of the box mirror the metal and bend the front there, so
 * the depth is that of the middle lines of nodes along the normal, away from the sides, h/sqrt(2) of width each.
 */
static double diagonal_speed(double m, int cells)
{
    double edge[3], h = 40.0 * H / cells, before = 0.0, after = 0.0, end = 8.0 * H / SPEED;
    int side_lines = 8 * cells / 40;
    edge[0] = edge[1] = 40.0 * H;
    edge[2] = 2.0 * h;
    scene *s = scene_start(edge);
    s->shapes[0].type = PD_SHAPE_HALF_SPACE;
    s->shapes[0].a[0] = s->shapes[0].a[1] = 22.0 * H;
    s->shapes[0].b[0] = s->shapes[0].b[1] = 1.0;
    if (!metal_build(s, h, m)) return 0.0;
    for (int k = 0; k < 2; k++) {
        double sum = 0.0;
        if (k && !run_to(s, end)) return 0.0;
        for (int32_t j = 0; j < s->grid.total; j++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, j, x);
            if (s->grid.kind[j] == PD_SOLID && fabs(x[0] - x[1]) < (side_lines + 0.5) * h)
                sum += s->transport.c[j] / CS;
        }
        *(k ? &after : &before) = sum * h * h / (PD_DIM == 3 ? 2.0 : 1.0); /* two layers in 3D */
    }
    double width = (2 * side_lines + 1) * h / sqrt(2.0);
    scene_free(s);
    return (before - after) / width / (SPEED * end);
}

/* Families of one cell are left out: their area measure is off by several per cent at 45 degrees. */
TEST(diagonal_front)
{
    for (int m = 2; m <= 3; m++) {
        double speed = diagonal_speed(m, 40);
        NOTE("m = %d: 45 degrees at %.4f of the speed", m, speed);
        CHECK_NEAR(speed, 1.0, 0.02);
    }
}

/* A disc or ball of `ratio` cells radius: worst deviation of the mean recession from speed times time, in shares of the
 * latter, between 20 % of the radius gone and half the metal gone; radii are those of equal amount. */
static double ball_deviation(double ratio, double m, double threshold)
{
    double edge[3], radius = 8.0 * H, h = radius / ratio, worst = 0.0;
    for (int d = 0; d < PD_DIM; d++) edge[d] = 2.0 * h * ceil(1.25 * ratio);
    scene *s = scene_start(edge);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = radius;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 0.5 * edge[d];
    s->dissolve_desc.threshold = threshold;
    s->couple_desc.fraction = PD_DIM == 2 ? 0.05 : 0.1;
    if (!metal_build(s, h, m)) return HUGE_VAL;
    double start = s->couple.ledger[0].start / CS;
    double first = PD_DIM == 2 ? sqrt(start / PI) : cbrt(0.75 * start / PI);
    for (int k = 4; pd_time_loop_volume_loss(&s->couple) < 0.5; k++) {
        double receded = 0.05 * k * radius;
        if (!run_to(s, receded / SPEED)) return HUGE_VAL;
        double mean = first * (1.0 - pow(s->couple.ledger[0].solid / s->couple.ledger[0].start, 1.0 / PD_DIM));
        worst = fmax(worst, fabs(mean / receded - 1.0));
    }
    scene_free(s);
    return worst;
}

TEST(ball_shrinks_at_the_speed)
{
    double coarse = ball_deviation(PD_DIM == 2 ? 8.0 : 6.0, 3.0, 0.0);
    double fine = ball_deviation(PD_DIM == 2 ? 16.0 : 8.0, 3.0, 0.0);
    NOTE("deviations %.4f and %.4f", coarse, fine);
    CHECK_LE(coarse, PD_DIM == 2 ? 0.02 : 0.1);
    CHECK_LE(fine, PD_DIM == 2 ? 0.01 : 0.07);
    CHECK_LE(fine, coarse);
}

/* The threshold says how much of a node joins the fluid at once, not how fast the front is. */
TEST(threshold_does_not_change_the_speed)
{
    for (int k = 1; k <= 2; k++) check_flat(0, H, 2.0, 0.25 * k);
}

/* ---- the law ---- */

/* A closed box with too little fluid: dissolution stops where the fluid is saturated, having taken exactly what that
 * needs, and no concentration exceeds saturation on the way. */
TEST(saturation)
{
    for (int fast = 0; fast < 2; fast++) {
        double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {6.0 * H, 5.0 * H, 4.0 * H};
        scene *s = scene_cells(12, 5, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        rate.csat = 0.1 * CS;
        rate.speed = fast ? 1e3 * SPEED : SPEED;
        if (!metal_build(s, H, 2.0)) return;
        for (int k = 1; k <= 40; k++) {
            if (!run_to(s, k * 0.5 * H / SPEED)) return;
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_FLUID) CHECK_LE(s->transport.c[i], rate.csat * (1.0 + 1e-9));
        }
        double fluid = (double)s->grid.fluid_count * s->stencil.volume;
        CHECK(s->grid.solid_count > 0);
        const pd_mass_balance *l = &s->couple.ledger[0];
        CHECK_REL(l->dissolved, fluid * rate.csat, 1e-6);
        CHECK_REL(l->solid, l->start - l->dissolved - l->carried_residual, 1e-12);
        scene_free(s);
    }
}

/* The factor multiplies the speed. */
TEST(factor_multiplies)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {10.0 * H, 4.0 * H, 4.0 * H};
    for (int k = 0; k < 2; k++) {
        scene *s = scene_cells(20, 4, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        if (!metal_grid(s, H, 3.0)) return;
        double *factor = (double *)malloc((size_t)s->grid.total * sizeof *factor);
        if (!CHECK(factor != NULL)) return;
        for (int32_t i = 0; i < s->grid.total; i++) factor[i] = k ? 0.25 : 3.0;
        s->dissolve_desc.factor = factor;
        if (!metal_rest(s) || !run_to(s, 2.0 * H / SPEED)) return;
        CHECK_REL(pd_time_loop_volume_loss(&s->couple) * 10.0, 2.0 * (k ? 0.25 : 3.0), 1e-10);
        scene_free(s);
        free(factor);
    }
}

/* Metal of factor 0 stays for good, and hands nothing to the fluid when its neighbours go. */
TEST(inert_metal_stays)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {6.0 * H, 4.0 * H, 4.0 * H}, most = 0.0;
    scene *s = scene_cells(12, 4, 4);
    scene_solid_box(&s->shapes[0], lo, hi);
    if (!metal_grid(s, H, 2.0)) return;
    double *factor = (double *)malloc((size_t)s->grid.total * sizeof *factor);
    if (!CHECK(factor != NULL)) return;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        factor[i] = x[0] < 3.0 * H ? 0.0 : 1.0;
    }
    s->dissolve_desc.factor = factor;
    rate.csat = 0.9 * CS;
    if (!metal_rest(s)) return;
    for (int k = 1; k <= 100; k++) {
        if (!run_to(s, 0.4 * k * H / SPEED)) return;
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) most = fmax(most, s->transport.c[i] + s->transport.carry[i]);
    }
    CHECK_LE(most, rate.csat * (1.0 + 1e-9));
    CHECK_INT(s->grid.solid_count, 3 * (PD_DIM == 2 ? 4 : 16));
    CHECK_REL(s->couple.ledger[0].solid, 0.5 * s->couple.ledger[0].start, 1e-12);
    scene_free(s);
    free(factor);
}

static double not_a_number(void *user, const pd_rate_at *at)
{
    (void)user;
    return at->c > 1.0 ? (double)NAN : SPEED;
}

static double infinite(void *user, const pd_rate_at *at)
{
    (void)user;
    (void)at;
    return HUGE_VAL;
}

TEST(law_without_a_value)
{
    for (int k = 0; k < 2; k++) {
        double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {5.0 * H, 4.0 * H, 4.0 * H};
        scene *s = scene_cells(10, 4, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        s->dissolve_desc.rate = k ? infinite : not_a_number;
        if (!metal_build(s, H, 2.0)) return;
        pd_status status = PD_OK;
        for (int step = 0; step < 100 && status == PD_OK; step++)
            status = pd_time_loop_step(&s->ctx, &s->couple, 10.0 * H / SPEED);
        CHECK_INT(status, PD_ERR_STATE);
        CHECK(strstr(s->ctx.message, "the rate law gives") != NULL);
        CHECK(strstr(s->ctx.message, " at (") != NULL);
        scene_free(s);
    }
}

/* Three times as fast on the upper side of the slab, and twice as fast after an hour as at first. */
static double place_and_time(void *user, const pd_rate_at *at)
{
    const scene *s = (const scene *)user;
    return SPEED * (at->x[0] > 0.5 * s->grid_desc.hi[0] ? 3.0 : 1.0) * (1.0 + at->t / 3600.0);
}

/* A slab with two flat fronts: the metal that is gone after an hour is the integral of both speeds. They grow with the
 * time, and the middle of a step is exact for that. */
TEST(law_of_place_and_time)
{
    for (int steps = 4; steps <= 8; steps *= 2) {
        double lo[3] = {5.0 * H, 0.0, 0.0}, hi[3] = {11.0 * H, 4.0 * H, 4.0 * H};
        scene *s = scene_cells(16, 4, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        s->dissolve_desc.rate = place_and_time;
        s->dissolve_desc.rate_user = s;
        s->couple_desc.max_step = 3600.0 / steps;
        s->couple_desc.fraction = 1.0;
        if (!metal_build(s, H, 2.0)) return;
        if (!run_to(s, 3600.0)) return;
        double gone = pd_time_loop_volume_loss(&s->couple) * 6.0 * H, expected = 3600.0 * SPEED * 4.0 * 1.5;
        CHECK_INT(s->couple.steps, steps);
        CHECK_REL(gone, expected, 1e-12);
        scene_free(s);
    }
}

/* Ten times as fast behind an hour. */
static double jumping(void *user, const pd_rate_at *at)
{
    (void)user;
    return at->t > 3600.0 ? 10.0 * SPEED : SPEED;
}

/* What laws follow is given and jumps at the end of a step. The next one is as long as the speed behind the jump
 * allows: a flat front crosses a fifth of a cell. Where nothing is given anew the speed at the start counts. */
TEST(first_step_behind_a_jump)
{
    for (int driven = 0; driven < 2; driven++) {
        double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {5.0 * H, 4.0 * H, 4.0 * H};
        pd_step step;
        scene *s = scene_cells(10, 4, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        s->dissolve_desc.rate = jumping;
        s->dissolve_desc.driven = driven;
        if (!metal_build(s, H, 1.0)) return;
        pd_physics process = pd_dissolve_process(&s->dissolve);
        memset(&step, 0, sizeof step);
        step.time = 3600.0;
        step.latest_end = 36000.0;
        step.dt = 32400.0;
        step.max_dissolved_fraction = 0.2;
        step.rtol = 1e-3;
        CHECK_OK(&s->ctx, process.max_run_step(&s->ctx, process.self, &step));
        CHECK_REL(step.dt, 0.2 * H / ((driven ? 10.0 : 1.0) * SPEED), 1e-12);
        scene_free(s);
    }
}

/* Three times as fast in grain 1. */
static double by_grain(void *user, const pd_rate_at *at)
{
    (void)user;
    return at->grain == 1 ? 3.0 * SPEED : at->grain == 0 ? SPEED : NAN;
}

/* A slab of two grains, each with a flat front: a node of the fluid sees the grain in front of it. */
TEST(law_of_grain)
{
    static int32_t grain[40 * 40 * 40];
    double lo[3] = {5.0 * H, 0.0, 0.0}, hi[3] = {11.0 * H, 4.0 * H, 4.0 * H};
    scene *s = scene_cells(16, 4, 4);
    scene_solid_box(&s->shapes[0], lo, hi);
    s->dissolve_desc.rate = by_grain;
    s->dissolve_desc.grain = grain;
    memset(grain, 0, sizeof grain);
    if (!metal_build(s, H, 2.0) || !CHECK(s->grid.total <= 40 * 40 * 40)) return;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        grain[i] = x[0] > 0.5 * s->grid_desc.hi[0];
    }
    if (!run_to(s, 3600.0)) return;
    CHECK_REL(pd_time_loop_volume_loss(&s->couple) * 6.0 * H, 3600.0 * SPEED * 4.0, 1e-12);
    scene_free(s);
}

/* A law below zero does not deposit; a rising one is taken as it stands. */
static double falling_below(void *user, const pd_rate_at *at)
{
    (void)user;
    (void)at;
    return -SPEED;
}

TEST(no_deposit)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {5.0 * H, 4.0 * H, 4.0 * H};
    scene *s = scene_cells(10, 4, 4);
    scene_solid_box(&s->shapes[0], lo, hi);
    s->dissolve_desc.rate = falling_below;
    s->transport_desc.initial = 10.0;
    if (!metal_build(s, H, 2.0)) return;
    if (!run_to(s, H / SPEED)) return;
    CHECK(pd_time_loop_volume_loss(&s->couple) == 0.0);
    scene_free(s);
}

/* ---- small, empty, walled ---- */

/* One node of metal dissolves whole and leaves exactly its content. */
TEST(single_node)
{
    for (int m = 1; m <= 3; m++) {
        double lo[3] = {4.0 * H, 4.0 * H, 3.0 * H}, hi[3] = {5.0 * H, 5.0 * H, 4.0 * H};
        scene *s = scene_cells(9, 9, 7);
        scene_solid_box(&s->shapes[0], lo, hi);
        if (!metal_build(s, H, m)) return;
        CHECK_INT(s->grid.solid_count, 1);
        if (!run_to(s, 20.0 * H / SPEED)) return;
        CHECK_INT(s->grid.solid_count, 0);
        CHECK(pd_time_loop_volume_loss(&s->couple) == 1.0);
        CHECK_REL(s->couple.ledger[0].dissolved + s->couple.ledger[0].carried_residual, CS * s->stencil.volume, 1e-13);
        CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
        /* and with nothing left a step of any length is one step */
        int64_t steps = s->couple.steps;
        if (!run_to(s, 1e6 * H / SPEED)) return;
        CHECK_INT(s->couple.steps, steps + 1);
        scene_free(s);
    }
}

/* Debris at random, dissolved to the last node: the fluid holds all of it. */
TEST(everything_dissolves)
{
    uint32_t seed = 77;
    for (int round = 0; round < 6; round++) {
        double lo[3] = {3.0 * H, 2.0 * H, 2.0 * H}, hi[3] = {11.0 * H, 8.0 * H, 5.0 * H};
        scene *s = scene_cells(14, 10, 7);
        scene_solid_box(&s->shapes[0], lo, hi);
        if (!metal_grid(s, H, 1.0 + round % 3)) return;
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_SOLID && next_random(&seed) % 3 == 0) pdi_grid_set_fluid(&s->grid, i);
        if (!metal_rest(s) || !run_to(s, 60.0 * H / SPEED)) return;
        CHECK_INT(s->grid.solid_count, 0);
        CHECK_REL(s->couple.ledger[0].dissolved + s->couple.ledger[0].carried_residual, s->couple.ledger[0].start,
                  1e-13);
        scene_free(s);
    }
}

TEST(nothing_to_dissolve)
{
    scene *s = scene_cells(8, 7, 6);
    s->grid_desc.solid = NULL;
    if (!metal_build(s, H, 2.0)) return;
    CHECK_INT(s->dissolve.front_count, 0);
    if (!run_to(s, 1.0)) return;
    CHECK_INT(s->couple.steps, 1);
    CHECK(pd_time_loop_volume_loss(&s->couple) == 0.0);
    CHECK(pdi_dissolve_fastest(&s->ctx, &s->dissolve) == 0.0);
    scene_free(s);
}

/* Metal without any fluid beside it stays. */
TEST(no_fluid)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {8.0 * H, 7.0 * H, 6.0 * H};
    scene *s = scene_cells(8, 7, 6);
    scene_solid_box(&s->shapes[0], lo, hi);
    if (!metal_build(s, H, 2.0) || !run_to(s, 10.0 * H / SPEED)) return;
    CHECK(pd_time_loop_volume_loss(&s->couple) == 0.0);
    scene_free(s);
}

/* A sheet one node thick between two pockets: it goes, and they become one. The speed is that of the law for families
 * of one cell; larger ones would draw a part of it from metal behind the sheet that is not there. */
TEST(thin_sheet)
{
    double lo[3] = {7.0 * H, 0.0, 0.0}, hi[3] = {8.0 * H, 4.0 * H, 4.0 * H};
    for (int m = 1; m <= 3; m++) {
        scene *s = scene_cells(15, 4, 4);
        scene_solid_box(&s->shapes[0], lo, hi);
        if (!metal_build(s, H, m)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, i, x);
            if (s->grid.kind[i] == PD_FLUID && x[0] < 7.0 * H) s->transport.c[i] = 50.0;
        }
        s->couple.steps = 0;
        if (!CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple))) return;
        double volume = s->stencil.volume * (double)(7 * s->grid.solid_count);
        if (!run_to(s, 0.2 * H / SPEED)) return;
        /* both sides lose at the speed, and nothing passes */
        double gone = s->couple.ledger[0].solid_start - s->couple.ledger[0].solid;
        if (m == 1) CHECK_REL(gone, 0.4 * s->couple.ledger[0].solid_start, 1e-10);
        CHECK_LE(gone, 0.4 * s->couple.ledger[0].solid_start * (1.0 + 1e-10));
        CHECK_LE(0.25 * s->couple.ledger[0].solid_start, gone);
        double left = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, i, x);
            if (s->grid.kind[i] == PD_FLUID && x[0] < 7.0 * H) left += s->transport.c[i] * s->stencil.volume;
        }
        CHECK_REL(left, 50.0 * volume + 0.5 * gone, 1e-9);
        if (!run_to(s, 1e4 * H / SPEED)) return;
        CHECK_INT(s->grid.solid_count, 0);
        double low = HUGE_VAL, high = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            low = fmin(low, s->transport.c[i]);
            high = fmax(high, s->transport.c[i]);
        }
        CHECK_REL(low, high, 1e-6);
        scene_free(s);
    }
}

/* Amount [mol] on the low side of the plane x = at: fluid, debt and metal. */
static double amount_below(const scene *s, double at)
{
    double sum = 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (x[0] > at || (s->grid.kind[i] != PD_FLUID && s->grid.kind[i] != PD_SOLID)) continue;
        sum += (s->transport.c[i] + (s->grid.kind[i] == PD_FLUID ? s->transport.carry[i] : 0.0)) * s->stencil.volume;
    }
    return sum;
}

/* A wall one node thick with metal on both of its faces and different shapes on either side: no metal passes it. */
TEST(wall_is_tight)
{
    uint32_t seed = 5;
    for (int m = 1; m <= 3; m++)
        for (int round = 0; round < 3; round++) {
            double lo[3] = {4.0 * H, 1.0 * H, 1.0 * H}, hi[3] = {10.0 * H, 6.0 * H, 4.0 * H};
            scene *s = scene_cells(15, 7, 5);
            scene_solid_box(&s->shapes[0], lo, hi);
            s->shapes[1].type = PD_SHAPE_BOX;
            for (int d = 0; d < PD_DIM; d++) s->shapes[1].b[d] = s->grid_desc.hi[d];
            s->shapes[1].a[0] = 7.0 * H;
            s->shapes[1].b[0] = 8.0 * H;
            s->grid_desc.wall = &s->shapes[1];
            if (!metal_grid(s, H, m)) return;
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_SOLID && next_random(&seed) % 4 == 0) pdi_grid_set_fluid(&s->grid, i);
            if (!metal_rest(s)) return;
            double below = amount_below(s, 7.5 * H);
            for (int k = 1; k <= 30; k++) {
                if (!run_to(s, k * 0.3 * H / SPEED)) return;
                if (!CHECK_REL(amount_below(s, 7.5 * H), below, 1e-12)) return;
            }
            CHECK_INT(s->grid.solid_count, 0);
            scene_free(s);
        }
}

/* Walls at random inside boxes down to one cell across: amounts close although paths mirror at the sides. */
TEST(random_walls)
{
    uint32_t seed = 9;
    for (int round = 0; round < 40; round++) {
        double edge[3], lo[3] = {0.0, 0.0, 0.0};
        for (int d = 0; d < 3; d++) edge[d] = (1 + (int)(next_random(&seed) % (PD_DIM == 3 ? 6 : 12))) * H;
        scene *s = scene_start(edge);
        scene_solid_box(&s->shapes[0], lo, edge);
        if (!metal_grid(s, H, 1.0 + round % 3)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_SOLID) continue;
            uint32_t pick = next_random(&seed) % 6;
            if (pick < 2) pdi_grid_set_fluid(&s->grid, i);
            if (pick != 2) continue;
            s->grid.kind[i] = PD_WALL;
            s->grid.solid_count--;
        }
        if (!metal_rest(s) || !run_to(s, 40.0 * H / SPEED)) return;
        CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
        scene_free(s);
    }
}

TEST(bad_input)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {4.0 * H, 4.0 * H, 4.0 * H};
    scene *s = scene_cells(8, 7, 6);
    scene_solid_box(&s->shapes[0], lo, hi);
    if (!metal_build(s, H, 2.0)) return;
    for (int k = 0; k < 7; k++) {
        pd_dissolve_desc desc = s->dissolve_desc;
        pd_dissolve other;
        if (k == 0) desc.solid = 0.0;
        if (k == 1) desc.solid = (double)NAN;
        if (k == 2) desc.threshold = -0.1;
        if (k == 3) desc.threshold = 1.0;
        if (k == 4) desc.threshold = (double)NAN;
        if (k == 5) desc.rate = NULL;
        if (k == 6) desc.solid = HUGE_VAL;
        CHECK_INT(pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &desc, &other), PD_ERR_ARGUMENT);
        CHECK(strncmp(s->ctx.message, "dissolve: ", 10) == 0);
        pd_dissolve_free(&s->ctx, &other);
    }
    scene_free(s);
}

/* Each solid node is of a metal that there is and has a factor; other nodes have neither. */
TEST(bad_nodes)
{
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {4.0 * H, 4.0 * H, 4.0 * H};
    scene *s = scene_cells(8, 7, 6);
    scene_solid_box(&s->shapes[0], lo, hi);
    if (!metal_build(s, H, 2.0)) return;
    uint8_t *metal = (uint8_t *)calloc((size_t)s->grid.total, sizeof *metal);
    double *factor = (double *)calloc((size_t)s->grid.total, sizeof *factor);
    pd_metal more;
    memset(&more, 0, sizeof more);
    more.solid = 2.0 * CS;
    more.rate = rate_law;
    more.rate_user = &rate;
    for (int32_t j = 0; j < s->grid.total; j++) {
        int inside = s->grid.kind[j] == PD_SOLID;
        metal[j] = inside ? 1 : 2;
        factor[j] = inside ? j % 2 : -1.0;
    }
    for (int32_t j = 0; j < s->grid.total; j++) {
        pd_dissolve_desc desc = s->dissolve_desc;
        pd_dissolve other;
        char text[80];
        desc.more = &more;
        desc.more_count = 1;
        desc.metal = metal;
        desc.factor = factor;
        if (s->grid.kind[j] != PD_SOLID) {
            if (j % 31) continue;
            CHECK_OK(&s->ctx, pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &desc, &other));
            pd_dissolve_free(&s->ctx, &other);
            continue;
        }
        metal[j] = 2;
        snprintf(text, sizeof text, "dissolve: node %d is of metal 2, expected 0 to 1", (int)j);
        CHECK_INT(pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &desc, &other), PD_ERR_ARGUMENT);
        CHECK(strstr(s->ctx.message, text) != NULL);
        metal[j] = 1;
        for (int k = 0; k < 3; k++) {
            factor[j] = k == 0 ? -1e-3 : k == 1 ? 1e100 : (double)NAN;
            snprintf(text, sizeof text, "dissolve: node %d has the factor %g, expected", (int)j, factor[j]);
            CHECK_INT(pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &desc, &other),
                      PD_ERR_ARGUMENT);
            CHECK(strstr(s->ctx.message, text) != NULL);
        }
        factor[j] = j % 2;
    }
    free(metal);
    free(factor);
    scene_free(s);
}

TEST_MAIN(SLOW_ENTRY_IF(PD_DIM == 3, flat_front_is_exact) ENTRY(diagonal_front)
              SLOW_ENTRY_IF(PD_DIM == 3, ball_shrinks_at_the_speed) ENTRY(threshold_does_not_change_the_speed)
                  ENTRY(saturation) ENTRY(factor_multiplies) ENTRY(inert_metal_stays) ENTRY(law_without_a_value)
                      ENTRY(law_of_place_and_time) ENTRY(first_step_behind_a_jump) ENTRY(law_of_grain) ENTRY(no_deposit)
                          ENTRY(single_node) ENTRY(everything_dissolves) ENTRY(nothing_to_dissolve) ENTRY(no_fluid)
                              ENTRY(thin_sheet) ENTRY(wall_is_tight) ENTRY(random_walls) ENTRY(bad_input)
                                  ENTRY(bad_nodes))
