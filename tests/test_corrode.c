/* corrode: speed of flat fronts against the sum over the family, the pencil electrode, exact amounts, threads.
 * dims: 1 2 3   slow: 3 */
#include "corrode_scene.h"

/* ---- speeds ---- */

/* Speed over the cells that the front moves between two layers of a half-space of metal, from the times at which they
 * turn fluid. */
static double layer_speed(scene *s, int from, int to)
{
    double start = 0.0;
    int64_t metal = s->grid.solid_count, layer = 1;
    for (int d = 1; d < PD_DIM; d++) layer *= s->grid.n[d];
    for (int layers = 0, before; layers < to;) {
        double limit = 0.0;
        if (!CHECK_OK(&s->ctx, pd_corrode_limit(&s->ctx, &s->corrode, &limit))) return NAN;
        double step = s->corrode.desc.share / (s->corrode.fastest * s->corrode.front.total);
        if (!CHECK_OK(&s->ctx, pd_corrode_step(&s->ctx, &s->corrode, fmin(step, limit)))) return NAN;
        if (!CHECK(s->corrode.steps < 1000000)) return NAN;
        before = layers;
        layers = (int)((metal - s->grid.solid_count) / layer);
        if (before < from && layers >= from) start = s->corrode.time;
    }
    CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-12);
    return (to - from) * H / (s->corrode.time - start);
}

/* The other axes have `ratio` times the spacing of the first. */
static double flat_speed(double m, double ratio, pd_kernel kernel, pd_drive drive, double share)
{
    scene *s = scene_start(26, 2, 2);
    for (int d = 1; d < PD_DIM; d++) {
        s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        s->stencil_desc.h[d] *= ratio;
        s->grid_desc.hi[d] *= ratio;
    }
    half_space(s, 8.0 * H);
    s->stencil_desc.m = m;
    s->desc.kernel = kernel;
    s->desc.drive = drive;
    s->desc.share = share;
    if (!scene_build(s)) return NAN;
    double found = layer_speed(s, 5, 9);
    scene_free(s);
    return found;
}

/* v = k h sum n w_n/ln(Cs/Csat) with k w_n = v0 ln(Cs/Csat) b_n is v0 by calibration, and the model moves at it: up to
 * what steps of finite length leave, which is of first order in them. */
TEST(flat_front_speed)
{
    for (int m = 1; m <= 4; m++)
        for (int kernel = 0; kernel < 3; kernel++)
            for (int drive = 0; drive < 2; drive++) {
                double coarse = flat_speed(m, 1.0, (pd_kernel)kernel, (pd_drive)drive, 0.01);
                CHECK_REL(coarse, SPEED, 1e-2);
                if (PD_DIM > 1 && (kernel || m > 2)) continue;
                CHECK_REL(flat_speed(m, 1.0, (pd_kernel)kernel, (pd_drive)drive, 0.002), SPEED, 3e-3);
            }
}

/* The metal behind makes up for what a node that turns has lost too much, so a front takes the time that it must, up to
 * the last step, however long that is. In proportion to the difference of concentrations steps have to resolve the
 * decay. */
TEST(flat_front_with_long_steps)
{
    static const double share[4] = {0.4, 0.2, 0.1, 0.02};
    for (int m = 1; m <= 3; m += 2)
        for (int drive = 0; drive < 2; drive++)
            for (int k = 0; k < 4; k++) {
                scene *s = scene_start(26, 2, 2);
                for (int d = 1; d < PD_DIM; d++)
                    s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
                half_space(s, 8.0 * H);
                s->stencil_desc.m = m;
                s->desc.drive = (pd_drive)drive;
                s->desc.share = share[k];
                if (!scene_build(s)) return;
                double found = layer_speed(s, 4, 16), steps = (double)s->corrode.steps;
                NOTE("m %d, drive %d, share %.2f: speed %.5f in %.0f steps", m, drive, share[k], found / SPEED, steps);
                CHECK_REL(found, SPEED, drive ? share[k] + 1.3 / steps : 1.3 / steps);
                scene_free(s);
            }
}

#if PD_DIM > 1
/* Elliptical horizons: the same speed along the short axis and (2D) along the long one. */
TEST(flat_front_on_unequal_spacings)
{
    static const double ratios[3] = {25.0, 100.0, 0.04};
    for (int r = 0; r < (PD_DIM == 2 ? 3 : 1); r++)
        for (int kernel = 0; kernel < 3; kernel++)
            CHECK_REL(flat_speed(PD_DIM == 2 ? 3.0 : 2.0, ratios[r], (pd_kernel)kernel, PD_DRIVE_CONSTANT, 0.01),
                      SPEED, 1e-2);
}
#endif

/* ---- the pencil electrode ---- */

/* Relative error of the depth at 10 s: diffusion-controlled, by pauses and releases alone. */
static double pencil_error(double m, int n, pd_kernel kernel, pd_drive drive)
{
    scene *s = scene_start(1, 3, 3);
    double h = PENCIL_START / n, bottom = 32e-6, before = PENCIL_START / (2.0 * PENCIL_LAMBDA);
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h;
        s->grid_desc.hi[d] = d ? h : bottom;
        if (d) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_MIRROR;
    }
    s->stencil_desc.m = m;
    s->grid_desc.side[0] = PD_SIDE_INLET;
    half_space(s, PENCIL_START);
    s->desc.activation = 0;
    s->desc.diffusivity = PENCIL_D;
    s->desc.drive = drive;
    s->desc.kernel = kernel;
    s->speed = 1e-5;
    if (!scene_build(s)) return NAN;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID)
            s->corrode.c[i] = CSAT * erf(PENCIL_LAMBDA * x[0] / PENCIL_START) / erf(PENCIL_LAMBDA);
    }
    pd_corrode_open(&s->corrode);
    double solid = pd_corrode_solid(&s->corrode);
    if (!CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 10.0 - before * before / PENCIL_D))) return NAN;
    CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
    double depth = bottom - (bottom - PENCIL_START) * pd_corrode_solid(&s->corrode) / solid;
    NOTE("m %g, h %.2f um, drive %d: depth %.3f um, %d steps", m, 1e6 * h, (int)drive, 1e6 * depth,
         (int)s->corrode.steps);
    scene_free(s);
    return fabs(depth / PENCIL_10S - 1.0);
}

/* First order in the spacing: metal enters the fluid up to a horizon ahead of the front. */
TEST(pencil_electrode)
{
    for (int m = 1; m <= (PD_DIM == 1 ? 3 : 1); m += 2)
        for (int drive = 0; drive < (PD_DIM == 1 ? 2 : 1); drive++) {
            int n = PD_DIM == 1 ? 4 : 2;
            double coarse = pencil_error(m, n, PD_KERNEL_AREA, (pd_drive)drive);
            double fine = pencil_error(m, 2 * n, PD_KERNEL_AREA, (pd_drive)drive);
            CHECK_LE(coarse, 0.06 * 4.0 / n);
            CHECK_LE(fine, 0.6 * coarse);
        }
    if (PD_DIM == 1) CHECK_LE(pencil_error(3.0, 16, PD_KERNEL_AREA, PD_DRIVE_CONSTANT), 1e-2);
}

/* ---- amounts ---- */

/* Nothing is lost, no concentration leaves its bounds, metal deeper than a horizon is not touched. */
TEST(amounts_are_conserved)
{
    for (int drive = 0; drive < 2; drive++) {
        scene *s = lump((pd_drive)drive, 0, NULL);
        if (!s) return;
        double start = s->corrode.start, most = 0.0;
        int32_t intact = 0;
        for (int k = 1; k <= 20; k++) {
            if (!CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        }
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] == PD_FLUID) most = fmax(most, s->corrode.c[i]);
            if (s->grid.kind[i] != PD_SOLID && s->grid.kind[i] != PD_FLUID) continue;
            CHECK(s->corrode.c[i] >= 0.0 && s->corrode.c[i] <= CS);
            if (s->grid.kind[i] == PD_SOLID) intact += s->corrode.c[i] >= CS && s->corrode.c[i] <= CS;
        }
        CHECK_LE(most, 1.05 * CSAT);
        CHECK(most > 0.9 * CSAT); /* a salt layer has formed */
        if (PD_DIM == 1) CHECK(intact > 0);
        CHECK(s->corrode.out > 1e-4 * start);
        scene_free(s);
    }
}

/* A closed box takes up what saturates it; then nothing moves any more. */
TEST(saturation_pauses)
{
    scene *s = scene_start(16, 2, 1);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-11;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 60.0))) return;
    double fluid = (double)s->grid.fluid_count * s->stencil.volume, gone = pd_corrode_dissolved(&s->corrode);
    CHECK(gone >= CSAT * fluid * (1.0 - 1e-9) && gone <= 1.05 * CSAT * fluid);
    int64_t steps = s->corrode.steps;
    CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 120.0));
    CHECK_NEAR(pd_corrode_dissolved(&s->corrode), gone, 1e-12 * gone);
    CHECK(s->corrode.steps > steps);
    scene_free(s);
}

TEST(threads_do_not_matter)
{
    static double kept[40000];
    for (int run = 0; run < 2; run++) {
        scene *s = lump(PD_DRIVE_CONSTANT, run ? 3 : 1, NULL);
        if (!s || !CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 10.0))) return;
        if (!CHECK(s->grid.total <= (int32_t)(sizeof kept / sizeof *kept))) return;
        size_t size = (size_t)s->grid.total * sizeof *kept;
        if (run) CHECK(memcmp(kept, s->corrode.c, size) == 0);
        else memcpy(kept, s->corrode.c, size);
        scene_free(s);
    }
}

/* What is kept from step to step while nodes turn, beside sides of every kind, against sums over the families as they
 * are: counts of wet bonds, and under activation control what metal loses and fluid gains. */
TEST(kept_sums)
{
    static uint8_t film[40000];
    for (int activation = 0; activation < 2; activation++) {
        scene *s = lump(PD_DRIVE_CONSTANT, 0, NULL);
        const pd_corrode *r = &s->corrode;
        int64_t known = 0, wrong = 0;
        if (!CHECK(s->grid.total <= 40000)) return;
        pd_corrode_free(&s->ctx, &s->corrode);
        s->desc.activation = activation;
        s->desc.passive = film;
        if (!CHECK_OK(&s->ctx, pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode))) return;
        for (int k = 1; k <= 4; k++) {
            for (int32_t i = k - 1; i < s->grid.total; i += 7) film[i] = (uint8_t)(k == 2); /* films come and go */
            CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 10.0 * k));
            CHECK(r->changed_count == 0 || pd_corrode_solid(r) < r->start);
        }
        double limit;
        CHECK_OK(&s->ctx, pd_corrode_limit(&s->ctx, &s->corrode, &limit));
        for (int32_t i = 0; i < s->grid.total; i++) {
            double reach = 0.0, attack = 0.0;
            int wet = 0, at[PD_DIM];
            pdi_grid_index(&s->grid, i, at);
            if (!pdi_grid_inside(&s->grid, at)) continue;
            for (int k = 0; k < s->stencil.count; k++) {
                int32_t j = i + r->map.shift[k];
                wet += pdi_phase_wet(r->map.phase[j]);
                if (r->map.phase[j] == PDI_PHASE_SOLID) reach += r->front.weight[k];
                attack += r->speed[j] * r->front.weight[k];
            }
            wrong += wet != r->map.wet[i];
            if (r->map.role[i] != PDI_ROLE_SHORE && (r->map.role[i] != PDI_ROLE_EXPOSED || !activation)) continue;
            if (r->sum[i] < 0.0) continue;
            known++;
            CHECK_NEAR(r->sum[i], r->map.role[i] == PDI_ROLE_SHORE ? reach : attack, 0.0);
        }
        CHECK(known > 2 && wrong == 0);
        CHECK(pd_corrode_solid(r) < 0.99 * r->start);
        scene_free(s);
    }
}

/* ---- factors of metal ---- */

/* Twice the factor is twice the speed, to the last bit. */
TEST(factor_is_a_speed)
{
    static double kept[40000], factor[40000];
    for (int k = 0; k < 40000; k++) factor[k] = 2.0;
    for (int run = 0; run < 2; run++) {
        scene *s = lump(PD_DRIVE_CONSTANT, 1, run ? factor : NULL);
        if (!s || !CHECK(s->grid.total <= 40000)) return;
        s->speed = run ? SPEED : 2.0 * SPEED;
        if (!CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 10.0))) return;
        CHECK(pd_corrode_solid(&s->corrode) < 0.99 * s->corrode.start);
        size_t size = (size_t)s->grid.total * sizeof *kept;
        if (run) CHECK(memcmp(kept, s->corrode.c, size) == 0);
        else memcpy(kept, s->corrode.c, size);
        scene_free(s);
    }
}

/* Factors that differ from node to node, behind periodic and mirror sides, too: nothing is lost. */
TEST(factors_conserve)
{
    static double factor[40000];
    uint32_t seed = 5;
    for (int k = 0; k < 40000; k++) factor[k] = (double)(next_random(&seed) % 1000) * 3e-3;
    for (int drive = 0; drive < 2; drive++) {
        scene *s = lump((pd_drive)drive, 1, factor);
        if (!s) return;
        for (int k = 1; k <= 5; k++) {
            if (!CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
        }
        CHECK(s->corrode.out > 0.0);
        scene_free(s);
    }
    scene *s = scene_start(20, 6, 6);
    half_space(s, 6.0 * H);
    for (int k = 0; k < 40000; k++) factor[k] = -1.0;
    s->desc.factor = factor;
    CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil));
    CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid));
    CHECK_INT(pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode), PD_ERR_ARGUMENT);
    scene_free(s);
}

/* ---- places and input ---- */

/* In front of a passive film nothing dissolves; where it is open the metal goes as if it were alone. */
TEST(passive_film)
{
    static uint8_t film[40000];
    memset(film, 1, sizeof film);
    for (int open = 0; open < 2; open++) {
        scene *s = scene_start(20, 6, 6);
        half_space(s, 6.0 * H);
        s->desc.passive = film;
        if (!scene_build(s)) return;
        for (int32_t i = 0; i < s->grid.total && open; i++) film[i] = s->grid.kind[i] == PD_FLUID ? 0 : 1;
        CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, 3.0 * H / SPEED));
        double lost = 1.0 - pd_corrode_solid(&s->corrode) / s->corrode.start;
        if (open) CHECK(lost > 0.0);
        else CHECK(lost <= 0.0);
        scene_free(s);
    }
}

/* Fluid that falls below the threshold beside metal does not attack any more, though it fills up again; fluid that
 * stays above goes on, as does a law that forgets. */
TEST(repassivation_remembers)
{
    for (int mode = 0; mode < 3; mode++) { /* 0: no films, 1: films, 2: films below what is never reached */
        scene *s = scene_start(20, 6, 6);
        double lost[3];
        half_space(s, 6.0 * H);
        s->desc.activation = 0;
        s->desc.diffusivity = 1e-12;
        s->desc.initial = 0.5 * CSAT;
        s->desc.repassivation = mode == 1 ? 0.6 * CSAT : mode == 2 ? 0.4 * CSAT : 0.0;
        if (!scene_build(s)) return;
        CHECK((s->corrode.film != NULL) == (mode > 0));
        for (int part = 0; part < 3; part++) { /* above, below and again above the threshold */
            double solid = pd_corrode_solid(&s->corrode), c = part == 1 ? 0.5 * CSAT : 0.9 * CSAT;
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_FLUID) s->corrode.c[i] = c;
            pd_corrode_open(&s->corrode);
            CHECK_OK(&s->ctx, pd_corrode_run(&s->ctx, &s->corrode, s->corrode.time + 0.01 * H / SPEED));
            CHECK_LE(pd_corrode_imbalance(&s->corrode), 1e-13);
            lost[part] = (solid - pd_corrode_solid(&s->corrode)) / s->corrode.start;
        }
        CHECK(lost[0] > 0.0);
        if (mode == 1) CHECK(lost[1] <= 0.0 && lost[2] <= 0.0);
        else CHECK(lost[1] > 0.0 && lost[2] > 0.0);
        scene_free(s);
    }
    scene *s = scene_start(20, 6, 6);
    half_space(s, 6.0 * H);
    s->desc.repassivation = 1.1 * CSAT;
    CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil));
    CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid));
    CHECK_INT(pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode), PD_ERR_ARGUMENT);
    scene_free(s);
}

TEST(step_beyond_the_limit)
{
    double limit;
    scene *s = scene_start(20, 6, 6);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-9;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_corrode_limit(&s->ctx, &s->corrode, &limit))) return;
    CHECK_INT(pd_corrode_step(&s->ctx, &s->corrode, 1.01 * limit), PD_RETRY);
    CHECK_INT(s->corrode.steps, 0);
    CHECK_OK(&s->ctx, pd_corrode_step(&s->ctx, &s->corrode, limit));
    CHECK_INT(pd_corrode_step(&s->ctx, &s->corrode, -1.0), PD_ERR_ARGUMENT);
    scene_free(s);
}

/* Beside a side that holds fluid without metal a node loses to its own image too: a step at the limit takes all that it
 * has, and no more. In the corner of two such sides likewise. */
TEST(held_side_at_the_limit)
{
    for (int sides = 1; sides <= PD_DIM; sides++) {
        double limit, lowest = HUGE_VAL;
        scene *s = scene_start(20, 12, 12);
        half_space(s, 14.0 * H);
        for (int d = 0; d < sides; d++) s->grid_desc.side[2 * d] = PD_SIDE_INLET;
        s->desc.activation = 0;
        s->desc.diffusivity = 1e-9;
        s->speed = 1e-9;
        if (!scene_build(s)) return;
        for (int at = 0; at < 8; at++) {
            int i[PD_DIM];
            double *c = s->corrode.c;
            for (int32_t k = 0; k < s->grid.total; k++)
                if (s->grid.kind[k] == PD_FLUID) c[k] = 0.0;
            for (int d = 0; d < PD_DIM; d++) i[d] = d < sides ? at : 6;
            int32_t node = pd_grid_node(&s->grid, i);
            c[node] = 0.9 * CSAT;
            CHECK_OK(&s->ctx, pd_corrode_limit(&s->ctx, &s->corrode, &limit));
            CHECK_OK(&s->ctx, pd_corrode_step(&s->ctx, &s->corrode, limit));
            CHECK_LE(-1e-14 * CSAT, c[node]);
            lowest = fmin(lowest, c[node]);
        }
        CHECK_LE(lowest, 1e-2 * CSAT);
        scene_free(s);
    }
}

/* Three times as fast beyond the middle, and twice as fast after ten seconds as at first. */
static double place_and_time(void *user, const pd_rate_at *at)
{
    const scene *s = (const scene *)user;
    return SPEED * (at->x[0] > 0.5 * s->grid_desc.hi[0] ? 3.0 : 1.0) * (1.0 + at->t / 10.0);
}

/* A slab with two flat fronts, which lose by place and by the time at the middle of each step. */
TEST(law_of_place_and_time)
{
    scene *s = scene_start(30, 4, 4);
    s->shapes[0].type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].a[d] = d ? 0.0 : 8.0 * H;
        s->shapes[0].b[d] = d ? 4.0 * H : 22.0 * H;
    }
    s->desc.rate = place_and_time;
    s->desc.rate_user = s;
    s->desc.uniform = 0;
    if (!scene_build(s)) return;
    double before = pd_corrode_solid(&s->corrode), dt = 0.1, sum = 0.0;
    for (int n = 0; n < 10; n++) {
        sum += 1.0 + (n + 0.5) * dt / 10.0;
        if (!CHECK_OK(&s->ctx, pd_corrode_step(&s->ctx, &s->corrode, dt))) return;
    }
    CHECK_REL((before - pd_corrode_solid(&s->corrode)) * 14.0 * H / before,
              4.0 * SPEED * dt * sum * (CS - CSAT) / CS, 1e-10);
    scene_free(s);
}

static double no_number(void *user, const pd_rate_at *at)
{
    (void)user;
    (void)at;
    return (double)NAN;
}

TEST(bad_input)
{
    for (int k = 0; k < 8; k++) {
        scene *s = scene_start(20, 6, 6);
        half_space(s, 6.0 * H);
        if (k == 0) s->desc.saturation = CS;
        if (k == 1) s->desc.initial = -1.0;
        if (k == 2) s->desc.diffusivity = (double)NAN;
        if (k == 3) s->desc.share = 2.0;
        if (k == 4) s->desc.rate = NULL;
        if (k == 5) s->desc.weights = PD_WEIGHTS_PRINTED; /* of area weights */
        if (k == 6) s->desc.drive = (pd_drive)7;
        if (k == 7) s->desc.rate = no_number;
        if (!CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) ||
            !CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)))
            return;
        pd_status status = pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode);
        CHECK_INT(status, k == 7 ? PD_OK : PD_ERR_ARGUMENT);
        if (k == 7) CHECK_INT(pd_corrode_step(&s->ctx, &s->corrode, 1e-3), PD_ERR_STATE);
        CHECK(strlen(s->ctx.message) > 20);
        scene_free(s);
    }
}

#if PD_DIM == 1
#define OF_DIM
#else
#define OF_DIM ENTRY(flat_front_on_unequal_spacings)
#endif

TEST_MAIN(ENTRY(flat_front_speed) ENTRY(flat_front_with_long_steps) OF_DIM ENTRY(pencil_electrode)
          ENTRY(amounts_are_conserved) ENTRY(saturation_pauses) ENTRY(threads_do_not_matter) ENTRY(kept_sums)
              ENTRY(factor_is_a_speed) ENTRY(factors_conserve) ENTRY(passive_film) ENTRY(repassivation_remembers)
                  ENTRY(law_of_place_and_time) ENTRY(step_beyond_the_limit) ENTRY(held_side_at_the_limit)
                      ENTRY(bad_input))
