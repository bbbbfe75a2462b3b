/* recede: the pencil electrode at hundreds of times the explicit step, amounts, bounds, threads.
 * dims: 1 2 3 */
#include "metal/recede.h"
#include "corrode_scene.h"

static const double pencil_times[3] = {10.0, 100.0, 300.0};
static const double pencil_depths[3] = {24.9218e-6, 78.8095e-6, 136.502e-6}; /* pencil304_stefan.csv */

/* Largest relative error of the depths. */
static double pencil_error(double m, double h, double end, double share)
{
    scene *s = scene_start(1, 2, 2);
    pd_recede recede;
    pd_recede_desc desc;
    double bottom = 160e-6, worst = 0.0, before = PENCIL_START / (2.0 * PENCIL_LAMBDA);
    memset(&desc, 0, sizeof desc);
    desc.share = share;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h;
        s->grid_desc.hi[d] = d ? 2.0 * h : bottom;
        if (d) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
    }
    s->stencil_desc.m = m;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    half_space(s, PENCIL_START);
    s->desc.activation = 0;
    s->desc.diffusivity = PENCIL_D;
    s->speed = 1e-5;
    if (!scene_build(s)) return NAN;
    if (!CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return NAN;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID)
            s->corrode.c[i] = CSAT * erf(PENCIL_LAMBDA * x[0] / PENCIL_START) / erf(PENCIL_LAMBDA);
    }
    pd_corrode_open(&s->corrode);
    double solid = pd_corrode_solid(&s->corrode), limit = 0.0;
    CHECK_OK(&s->ctx, pd_corrode_limit(&s->ctx, &s->corrode, &limit));
    for (int k = 0; k < 3 && pencil_times[k] <= end; k++) {
        if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, pencil_times[k] - before * before / PENCIL_D))) break;
        CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        double depth = bottom - (bottom - PENCIL_START) * pd_corrode_solid(&s->corrode) / solid;
        double error = depth / pencil_depths[k] - 1.0;
        worst = fmax(worst, fabs(error));
        NOTE("m %g, h %.2f um, t %g s: depth %.3f um (%+.2f %%), %d steps (explicit at least %.0f), %d rejected, %.1f "
             "corrections and %.1f iterations a step", m, 1e6 * h, pencil_times[k], 1e6 * depth, 100.0 * error,
             (int)s->corrode.steps, pencil_times[k] / limit, (int)recede.rejected,
             (double)recede.newton / (double)s->corrode.steps, (double)recede.iterations / (double)s->corrode.steps);
    }
    pd_recede_free(&s->ctx, &recede);
    scene_free(s);
    return worst;
}

/* Depths at 10, 100 and 300 s, of first order in the spacing: fluid beside the front is at Csat one cell early. */
TEST(pencil_electrode)
{
    for (int m = 1; m <= (PD_DIM == 1 ? 3 : 1); m += 2) {
        double coarse = pencil_error((double)m, 4e-6, PD_DIM == 1 ? 300.0 : 10.0, 0.2);
        double fine = pencil_error((double)m, 2e-6, PD_DIM == 1 ? 300.0 : 10.0, 0.2);
        CHECK_LE(coarse, 0.15);
        CHECK_LE(fine, 0.6 * coarse);
        if (PD_DIM > 1) continue;
        CHECK_LE(pencil_error((double)m, 0.5e-6, 300.0, 0.2), 0.3 * fine);
        /* steps twice as long */
        CHECK_NEAR(pencil_error((double)m, 2e-6, 300.0, 0.4), fine, 5e-3);
    }
}

/* Laws that jump at 30 % of Csat: to nothing, and to half of what diffusion carries away at least. */
static double jumping_law(void *user, const pd_rate_at *at)
{
    return at->c < 0.3 * CSAT ? *(const double *)user : 0.0;
}

static double falling_law(void *user, const pd_rate_at *at)
{
    return at->c < 0.3 * CSAT ? *(const double *)user : 0.007 * *(const double *)user;
}

/* The front then holds 0.3 Csat, and recedes as 2 lambda sqrt(D t) with sqrt(pi) lambda exp(lambda^2) erf(lambda) =
 * 0.3 Csat/(Cs - 0.3 Csat) once it has gone far against the solution that a node leaves at Csat. */
TEST(law_that_jumps)
{
    double low = 0.0, high = 1.0, wanted = 0.3 * CSAT / (CS - 0.3 * CSAT), off[4];
    for (int k = 0; k < 60; k++) {
        double middle = 0.5 * (low + high);
        if (sqrt(3.14159265358979324) * middle * exp(middle * middle) * erf(middle) < wanted) low = middle;
        else high = middle;
    }
    for (int k = 0; k < 4; k++) {
        scene *s = scene_start(1, 2, 2);
        pd_recede recede;
        pd_recede_desc desc;
        double h = k % 2 ? 1e-6 : 2e-6, bottom = 100e-6, end = 200.0;
        memset(&desc, 0, sizeof desc);
        for (int d = 0; d < PD_DIM; d++) {
            s->stencil_desc.h[d] = h;
            s->grid_desc.hi[d] = d ? 2.0 * h : bottom;
            if (d) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        }
        s->stencil_desc.m = 1.0;
        s->grid_desc.side[0] = PD_SIDE_INLET;
        half_space(s, 4e-6);
        s->desc.activation = 0;
        s->desc.diffusivity = PENCIL_D;
        s->desc.rate = k < 2 ? jumping_law : falling_law;
        s->speed = 1e-5;
        double from = 4e-6 / (2.0 * low), begin = from * from / PENCIL_D; /* when the front stood there */
        if (!scene_build(s)) return;
        if (!CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, i, x);
            if (s->grid.kind[i] == PD_FLUID) s->corrode.c[i] = 0.3 * CSAT * erf(low * x[0] / 4e-6) / erf(low);
        }
        pd_corrode_open(&s->corrode);
        double solid = pd_corrode_solid(&s->corrode);
        CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, end - begin));
        CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        CHECK(s->corrode.steps < 2000);
        double depth = bottom - (bottom - 4e-6) * pd_corrode_solid(&s->corrode) / solid;
        off[k] = depth / (2.0 * low * sqrt(PENCIL_D * end)) - 1.0;
        NOTE("to %s, h %g um: depth %.3f um (%+.2f %%), %d steps, %d rejected, %.1f corrections a step",
             k < 2 ? "nothing" : "less", 1e6 * h, 1e6 * depth, 100.0 * off[k], (int)s->corrode.steps,
             (int)recede.rejected, (double)recede.newton / (double)s->corrode.steps);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
    for (int k = 0; k < 4; k += 2) {
        CHECK_LE(fabs(off[k]), 0.1);
        CHECK_LE(fabs(off[k + 1]), 0.6 * fabs(off[k]));
    }
}

#if PD_DIM == 1
/* v = v0 (1 - C/Csat) */
static double saturating_law(void *user, const pd_rate_at *at)
{
    const scene *s = (const scene *)user;
    return s->speed * (1.0 - at->c / s->desc.saturation);
}

/* From control by the law to control by diffusion: with Cs >> Csat the field is straight, D C/L is what the front
 * gives, so L + a L^2/2 = v0 t with a = v0 (Cs - Csat)/(D Csat). */
TEST(mixed_control)
{
    double depth[2];
    for (int level = 0; level < 2; level++) {
        int cells = 40 << level;
        double h = 40e-6 / cells, start = 4e-6, bottom = 40e-6, a, t, error;
        pd_recede recede;
        pd_recede_desc desc;
        scene *s = scene_start(1, 1, 1);
        memset(&desc, 0, sizeof desc);
        s->stencil_desc.h[0] = h;
        s->grid_desc.hi[0] = bottom;
        s->grid_desc.side[0] = PD_SIDE_INLET;
        half_space(s, start);
        s->desc.activation = 0;
        s->desc.saturation = 20.0;
        s->desc.diffusivity = 1e-9;
        s->desc.rate = saturating_law;
        s->desc.rate_user = s;
        s->speed = 1e-8;
        if (!scene_build(s)) return;
        if (!CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
        a = s->speed * (CS - 20.0) / (1e-9 * 20.0);
        t = (20e-6 - start + 0.5 * a * (20e-6 * 20e-6 - start * start)) / s->speed; /* to 20 um */
        double solid = pd_corrode_solid(&s->corrode);
        if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, t))) return;
        CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        depth[level] = bottom - (bottom - start) * pd_corrode_solid(&s->corrode) / solid;
        error = depth[level] - 20e-6;
        NOTE("h %.2f um: law over diffusion %.2f at the end, depth off by %.3f h, %d steps", 1e6 * h, 1.0 / (a * 20e-6),
             error / h, (int)s->corrode.steps);
        CHECK_NEAR(error, 0.0, 0.6 * h);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
    CHECK_LE(fabs(depth[1] - 20e-6), 0.6 * fabs(depth[0] - 20e-6) + 2e-8);
}

/* v = v0 (1 + 50 C/Csat) */
static double runaway_law(void *user, const pd_rate_at *at)
{
    const scene *s = (const scene *)user;
    return s->speed * (1.0 + 50.0 * at->c / s->desc.saturation);
}

/* A closed pocket, well mixed, of which no node of metal turns: L dC/dt = v(C) (Cs - Csat), so that
 * C = Csat/50 (exp(g t) - 1) with g = 50 v0 (Cs - Csat)/(L Csat). Implicit steps are of first order in time: the error
 * goes with the root of rtol. One step of 20/g is longer than the growth of the law, so that the linear systems are
 * indefinite; its answer is saturated fluid. */
TEST(law_that_runs_away)
{
    double error[2], t, g;
    for (int run = 0; run < 3; run++) {
        pd_recede recede;
        pd_recede_desc desc;
        scene *s = scene_start(30, 1, 1);
        memset(&desc, 0, sizeof desc);
        desc.share = 1.0;
        desc.rtol = run ? 1e-6 : 1e-4;
        half_space(s, 20.0 * H);
        s->desc.activation = 0;
        s->desc.diffusivity = 1e-5;
        s->desc.rate = runaway_law;
        s->desc.rate_user = s;
        s->speed = 1e-9;
        if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
        g = 50.0 * s->speed * (CS - CSAT) / (20.0 * H * CSAT);
        t = log(40.0) / g;
        if (run < 2) {
            if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, t))) return;
            error[run] = pd_corrode_dissolved(&s->corrode) / (20.0 * H * CSAT / 50.0 * 39.0) - 1.0;
            NOTE("rtol %g: %d steps, %d corrections, off by %.2e", desc.rtol, (int)s->corrode.steps, (int)recede.newton,
                 error[run]);
            CHECK_LE(recede.newton, 4 * s->corrode.steps);
        } else {
            CHECK_OK(&s->ctx, pd_recede_step(&s->ctx, &recede, 20.0 / g));
            /* rounding of the exchanges over such a step: 1e-14 dt D sum a = 3e-5 */
            CHECK_REL(pd_corrode_dissolved(&s->corrode), 20.0 * H * CSAT, 1e-6);
        }
        CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-14);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
    CHECK_LE(fabs(error[0]), 0.1);
    CHECK_LE(fabs(error[1]), 0.13 * fabs(error[0]));
}
#endif

static int recede_build(scene *s, double share, pd_recede *recede)
{
    pd_recede_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.share = share;
    return s && CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, recede));
}

/* Nothing is lost, and no fluid passes Csat: the salt layer is solved for. */
TEST(amounts_and_bounds)
{
    for (int drive = 0; drive < 2; drive++) {
        pd_recede recede;
        scene *s = lump((pd_drive)drive, 0, NULL);
        if (!recede_build(s, 0.2, &recede)) return;
        double start = s->corrode.start, most = 0.0, least = CS;
        for (int k = 1; k <= 20; k++) {
            if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] == PD_SOLID) CHECK(s->corrode.c[i] >= CSAT && s->corrode.c[i] <= CS);
                if (s->grid.kind[i] != PD_FLUID) continue;
                most = fmax(most, s->corrode.c[i]);
                least = fmin(least, s->corrode.c[i]);
            }
        }
        NOTE("drive %d: %d steps, %.3g of the metal gone, C from %.3g to 1 %+.1e Csat", drive, (int)s->corrode.steps,
             1.0 - pd_corrode_solid(&s->corrode) / start, least / CSAT, most / CSAT - 1.0);
        CHECK_LE(-1e-9 * CSAT, least);
        CHECK_LE(most, CSAT * (1.0 + 1e-8));
        CHECK(most > 0.999 * CSAT);
        CHECK(s->corrode.out > 1e-4 * start);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
}

/* ---- the law alone: fluid that carries off what it gets ---- */

/* A flat front moves at the speed of the law, whatever the step, up to where it stands within the last one: nodes turn
 * at the end of a step, at the one closest to their own. */
TEST(flat_front_with_long_steps)
{
    static const double share[3] = {0.4, 0.2, 0.05};
    for (int m = 1; m <= 3; m += 2)
        for (int k = 0; k < 3; k++) {
            pd_recede recede;
            scene *s = scene_start(26, 2, 2);
            double begin = 0.0, end = 0.0;
            for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
            s->grid_desc.side[0] = PD_SIDE_INLET;
            half_space(s, 8.0 * H);
            s->stencil_desc.m = m;
            s->desc.activation = 0;
            s->desc.diffusivity = 1e-6;
            if (!scene_build(s) || !recede_build(s, share[k], &recede)) return;
            int64_t metal = s->grid.solid_count, layer = metal / 18, gone = 0;
            while (gone < 16 * layer && CHECK(s->corrode.steps < 10000)) {
                if (!CHECK_OK(&s->ctx, pd_recede_next(&s->ctx, &recede, 1e3))) return;
                gone = metal - s->grid.solid_count;
                if (begin <= 0.0 && gone >= 4 * layer) begin = s->corrode.time;
                end = s->corrode.time;
            }
            double found = 12.0 * H / (end - begin), steps = (double)s->corrode.steps;
            double lost = (1.0 - pd_corrode_solid(&s->corrode) / s->corrode.start) * 18.0 * H;
            NOTE("m %d, share %.2f: speed %.5f in %.0f steps, amount off by %.1e", m, share[k], found / SPEED, steps,
                 lost / (SPEED * end) - 1.0);
            CHECK_REL(found, SPEED, 1.3 * share[k] / 12.0 + 1e-3);
            CHECK_REL(lost, SPEED * end, 2e-3);
            CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
            pd_recede_free(&s->ctx, &recede);
            scene_free(s);
        }
}

#if PD_DIM > 1
/* Work of a step on average, a tenth above what is found. */
#define PIT_CORRECTIONS (PD_DIM == 3 ? 4.6 : 4.2)
#define PIT_ITERATIONS (PD_DIM == 3 ? 32.0 : 25.0)

/* Metal lost, in metres to the power of the dimension, by a pit that grows under a film, after `end` [s]. share 0:
 * explicit steps. */
static double pit_loss(double share, double diffusivity, double end, int64_t *steps)
{
    static uint8_t film[40000];
    pd_recede recede;
    int n = PD_DIM == 3 ? 16 : 30;
    scene *s = scene_start(n, n, n);
    memset(film, 0, sizeof film);
    for (int side = 0; side < 2 * PD_DIM; side++) s->grid_desc.side[side] = PD_SIDE_MIRROR;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    half_space(s, 5.0 * H);
    s->shapes[1].type = PD_SHAPE_BALL;
    s->shapes[1].a[0] = 5.0 * H;
    s->shapes[1].r = 4.2 * H;
    s->shapes[2].type = PD_SHAPE_DIFFERENCE;
    s->shapes[2].child[1] = 1;
    s->shapes[2].children = 2;
    s->grid_desc.solid = 2;
    s->desc.activation = 0;
    s->desc.diffusivity = diffusivity;
    s->desc.passive = film;
    if (!scene_build(s)) return NAN;
    for (int32_t i = 0; i < s->grid.total && i < 40000; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        film[i] = x[0] < 5.0 * H;
    }
    if (share > 0.0) {
        if (!recede_build(s, share, &recede)) return NAN;
        if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, end))) return NAN;
        double steps_taken = (double)s->corrode.steps;
        NOTE("share %.1f: %.1f corrections and %.1f iterations a step", share, (double)recede.newton / steps_taken,
             (double)recede.iterations / steps_taken);
        CHECK_LE((double)recede.newton / steps_taken, PIT_CORRECTIONS);
        CHECK_LE((double)recede.iterations / steps_taken, PIT_ITERATIONS);
        pd_recede_free(&s->ctx, &recede);
    } else if (!CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, end))) return NAN;
    double lost = (1.0 - pd_corrode_solid(&s->corrode) / s->corrode.start) * s->corrode.start / CS;
    *steps = s->corrode.steps;
    CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-12);
    scene_free(s);
    return lost;
}

/* A pit that grows exposes the more metal, the more it has dissolved. Long steps against explicit ones, under control
 * by the law and by both: where nodes turned at the end of the step in which they are down to Csat, never before, steps
 * of these shares would lose up to 1.9, 5.5 and 11 % in 3D. */
TEST(growing_pit)
{
    static const double diffusivity[2] = {2e-10, 1.5e-11};
    for (int k = 0; k < 2; k++) {
        double end = k ? 120.0 : 60.0;
        int64_t steps, many;
        double exact = pit_loss(0.0, diffusivity[k], end, &many);
        for (int j = 0; j < 3; j++) {
            double share = 0.1 * (1 << j), error = pit_loss(share, diffusivity[k], end, &steps) / exact - 1.0;
            NOTE("D %.0e m2/s, share %.1f: %+.2f %% in %d steps, explicit %d", diffusivity[k], share, 100.0 * error,
                 (int)steps, (int)many);
            CHECK_NEAR(error, 0.0, 0.075 * share);
        }
    }
}
#endif

/* A closed box takes up what saturates it; then nothing moves any more, and one step leads to any time. */
TEST(saturation_pauses)
{
    pd_recede recede;
    scene *s = scene_start(16, 2, 1);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-11;
    if (!scene_build(s) || !recede_build(s, 0.2, &recede)) return;
    if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, 60.0))) return;
    double fluid = (double)s->grid.fluid_count * s->stencil.volume, gone = pd_corrode_dissolved(&s->corrode);
    CHECK_REL(gone, CSAT * fluid, 1e-6);
    int64_t steps = s->corrode.steps;
    CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, 1e6));
    CHECK_REL(pd_corrode_dissolved(&s->corrode), CSAT * fluid, 1e-6);
    NOTE("%d steps to saturation, %d from there to 1e6 s", (int)steps, (int)(s->corrode.steps - steps));
    CHECK(s->corrode.steps - steps < 60);
    CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
    pd_recede_free(&s->ctx, &recede);
    scene_free(s);
}

TEST(threads_do_not_matter)
{
    static double kept[40000];
    for (int run = 0; run < 2; run++) {
        pd_recede recede;
        scene *s = lump(PD_DRIVE_CONSTANT, run ? 3 : 1, NULL);
        if (!recede_build(s, 0.2, &recede)) return;
        if (!CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, 3.0))) return;
        if (!CHECK(s->grid.total <= (int32_t)(sizeof kept / sizeof *kept))) return;
        size_t size = (size_t)s->grid.total * sizeof *kept;
        if (run) CHECK(memcmp(kept, s->corrode.c, size) == 0);
        else memcpy(kept, s->corrode.c, size);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
}

/* A law that ends as no number leaves the state as it was. */
/* Three times as fast beyond the middle, and twice as fast after ten seconds as at first. */
static double place_and_time(void *user, const pd_rate_at *at)
{
    const scene *s = (const scene *)user;
    return SPEED * (at->x[0] > 0.5 * s->grid_desc.hi[0] ? 3.0 : 1.0) * (1.0 + at->t / 10.0);
}

/* A slab with two flat fronts below saturation: the law holds at the middle of each step. */
TEST(law_of_place_and_time)
{
    pd_recede recede;
    pd_recede_desc desc;
    scene *s = scene_start(30, 4, 4);
    memset(&desc, 0, sizeof desc);
    s->shapes[0].type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = d ? 0.0 : 8.0 * H;
        s->shapes[0].b[d] = d ? 4.0 * H : 22.0 * H;
    }
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-9;
    s->desc.saturation = 0.5 * CS;
    s->desc.rate = place_and_time;
    s->desc.rate_user = s;
    s->desc.uniform = 0;
    if (!scene_build(s)) return;
    if (!CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
    double before = pd_corrode_solid(&s->corrode), dt = 0.1, sum = 0.0;
    for (int n = 1; n <= 10; n++) {
        sum += 1.0 + (n - 0.5) * dt / 10.0;
        if (!CHECK_OK(&s->ctx, pd_recede_step(&s->ctx, &recede, dt))) return;
    }
    CHECK_REL((before - pd_corrode_solid(&s->corrode)) * 14.0 * H / before, 4.0 * SPEED * dt * sum * 0.5, 1e-10);
    pd_recede_free(&s->ctx, &recede);
    scene_free(s);
}

/* Laws of time that lose half a cell in 100 s: from 37 s on, until then, a wave, a burst of 3 s. */
static int time_kind;
static double law_of_time(void *user, const pd_rate_at *at)
{
    double mean = 0.5 * H / 100.0, now = at->t;
    (void)user;
    switch (time_kind) {
    case 0: return now < 37.0 ? 0.0 : mean / 0.63;
    case 1: return now < 37.0 ? mean / 0.37 : 0.0;
    case 2: return mean * (1.0 + sin(0.06 * 3.14159265358979324 * now));
    default: return now >= 41.0 && now < 44.0 ? mean * 100.0 / 3.0 : 0.0;
    }
}

/* Far from saturation the metal loses the integral of the law over time, up to what each jump or turn may cost: 0.04 of
 * what a step may take. Implicit steps and explicit ones. The burst is shorter than steps are, so it is looked for in
 * parts of the way, as observers ask for. */
TEST(law_of_time)
{
    for (int k = 0; k < 16; k++) {
        static const double shares[2] = {0.2, 0.02}, turns[4] = {1.0, 1.0, 6.0, 2.0};
        pd_recede recede;
        pd_recede_desc desc;
        scene *s = scene_start(30, 4, 4);
        int implicit = k / 8;
        memset(&desc, 0, sizeof desc);
        memset(&recede, 0, sizeof recede);
        time_kind = k % 4;
        desc.share = s->desc.share = shares[k / 4 % 2];
        s->shapes[0].type = PD_SHAPE_BOX;
        for (int d = 0; d < PD_DIM; d++) {
            s->shapes[0].a[d] = d ? 0.0 : 8.0 * H;
            s->shapes[0].b[d] = d ? 4.0 * H : 22.0 * H;
        }
        s->desc.activation = !implicit;
        s->desc.diffusivity = 1e-9;
        s->desc.saturation = 0.5 * CS;
        s->desc.rate = law_of_time;
        s->desc.uniform = 1;
        if (!scene_build(s)) return;
        if (implicit && !CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
        double before = pd_corrode_solid(&s->corrode);
        for (int part = 1; part <= 20; part++) {
            double end = time_kind == 3 ? 5.0 * part : 100.0;
            if (implicit) CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, end));
            else CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, end));
        }
        double lost = (1.0 - pd_corrode_solid(&s->corrode) / before) * 14.0 / (2.0 * 0.5); /* cells */
        CHECK_NEAR(lost, 0.5, turns[time_kind] * 0.04 * desc.share);
        NOTE("%s, law %d, share %g: %.4f cells lost in %d steps", implicit ? "implicit" : "explicit", time_kind,
             desc.share, lost, (int)s->corrode.steps);
        CHECK(s->corrode.steps < 2000);
        pd_recede_free(&s->ctx, &recede);
        scene_free(s);
    }
}

static double broken_law(void *user, const pd_rate_at *at)
{
    return at->c > 0.2 * CSAT ? (double)NAN : *(const double *)user;
}

TEST(bad_input)
{
    pd_recede recede;
    pd_recede_desc desc;
    scene *s = scene_start(12, 2, 2);
    half_space(s, 6.0 * H);
    s->desc.diffusivity = 1e-11;
    if (!scene_build(s)) return;
    memset(&desc, 0, sizeof desc);
    CHECK_INT(pd_recede_build(&s->ctx, &s->corrode, &desc, &recede), PD_ERR_ARGUMENT);
    CHECK(strstr(s->ctx.message, "activation") != NULL);
    scene_free(s);
    s = scene_start(12, 2, 2);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-11;
    s->desc.rate = broken_law;
    if (!scene_build(s)) return;
    for (int fault = 0; fault < 4; fault++) {
        memset(&desc, 0, sizeof desc);
        if (fault == 0) desc.share = 2.0;
        if (fault == 1) desc.rtol = -1.0;
        if (fault == 2) desc.tolerance = (double)NAN;
        if (fault == 3) desc.max_newton = -1;
        CHECK_INT(pd_recede_build(&s->ctx, &s->corrode, &desc, &recede), PD_ERR_ARGUMENT);
        pd_recede_free(&s->ctx, &recede);
    }
    if (!recede_build(s, 0.2, &recede)) return;
    CHECK_INT(pd_recede_step(&s->ctx, &recede, 0.0), PD_ERR_ARGUMENT);
    double solid = pd_corrode_solid(&s->corrode);
    CHECK_INT(pd_recede_step(&s->ctx, &recede, 1.0), PD_ERR_STATE);
    CHECK(strstr(s->ctx.message, "nan m/s at c =") != NULL);
    CHECK_NEAR(pd_corrode_solid(&s->corrode), solid, 0.0);
    CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-15);
    pd_recede_free(&s->ctx, &recede);
    scene_free(s);
}

/* A film that has formed below the threshold stays when the solution fills up again. */
TEST(repassivation_remembers)
{
    scene *s = scene_start(20, 6, 6);
    pd_recede recede;
    pd_recede_desc desc;
    double lost[3];
    memset(&desc, 0, sizeof desc);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-12;
    s->desc.repassivation = 0.6 * CSAT;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_recede_build(&s->ctx, &s->corrode, &desc, &recede))) return;
    for (int part = 0; part < 3; part++) { /* above, below and again above the threshold */
        double solid = pd_corrode_solid(&s->corrode);
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) s->corrode.c[i] = part == 1 ? 0.5 * CSAT : 0.9 * CSAT;
        pd_corrode_open(&s->corrode);
        CHECK_OK(&s->ctx, pd_recede_run(&s->ctx, &recede, s->corrode.time + 0.01 * H / SPEED));
        CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        lost[part] = (solid - pd_corrode_solid(&s->corrode)) / s->corrode.start;
    }
    CHECK(lost[0] > 0.0 && lost[1] <= 0.0 && lost[2] <= 0.0);
    pd_recede_free(&s->ctx, &recede);
    scene_free(s);
}

#if PD_DIM > 1
#define OF_DIM ENTRY(growing_pit)
#elif PD_DIM == 1
#define OF_DIM ENTRY(mixed_control) ENTRY(law_that_runs_away)
#endif

TEST_MAIN(ENTRY(pencil_electrode) ENTRY(law_that_jumps) OF_DIM ENTRY(amounts_and_bounds)
          ENTRY(flat_front_with_long_steps) ENTRY(saturation_pauses) ENTRY(threads_do_not_matter)
              ENTRY(repassivation_remembers) ENTRY(law_of_place_and_time) ENTRY(law_of_time)
                  ENTRY(bad_input))
