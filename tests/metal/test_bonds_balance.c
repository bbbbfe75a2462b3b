/* bonds_balance: what bond-based corrosion keeps: amounts, bounds, saturation, threads, factors, films, input.
 * dims: 1 2 3 */
#include "metal_scene.h"
#include "conductances.h"
#include "transport/amount.h"

#define MOST 40000 /* nodes of these scenes */

/* Nothing is lost, no fluid passes Csat: the salt layer is solved for. Metal deeper than a horizon is not touched. */
TEST(amounts_and_bounds)
{
    for (int drive = 0; drive < 2; drive++) {
        scene *s = lump((pd_drive)drive, 0, NULL);
        if (!s) return;
        double start = scene_solid(s), most = 0.0, least = CS;
        int32_t intact = 0;
        for (int k = 1; k <= 20; k++) {
            if (!CHECK_OK(&s->ctx, scene_run(s, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
            check_conductances(&s->ctx, &s->transport);
            for (int32_t i = 0; i < s->grid.total; i++) {
                double c = s->transport.c[i];
                if (s->grid.kind[i] == PD_SOLID) CHECK(c >= CSAT && c <= CS);
                if (s->grid.kind[i] == PD_SOLID && k == 20) intact += c >= CS;
                if (s->grid.kind[i] != PD_FLUID) continue;
                most = fmax(most, c);
                least = fmin(least, c);
            }
        }
        NOTE("drive %d: %d steps, %.3g of the metal gone, C from %.3g to 1 %+.1e Csat", drive, (int)s->couple.steps,
             1.0 - scene_solid(s) / start, least / CSAT, most / CSAT - 1.0);
        CHECK_LE(-1e-9 * CSAT, least);
        CHECK_LE(most, CSAT * (1.0 + 1e-8));
        CHECK(most > 0.999 * CSAT);
        if (PD_DIM == 1) CHECK(intact > 0);
        CHECK(s->couple.ledger[0].out > 1e-4 * start);
        scene_free(s);
    }
}

/* A closed box takes up what saturates it; then nothing moves any more, and few steps lead to any time. */
TEST(saturation_pauses)
{
    scene *s = scene_start(16, 2, 1);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->transport_desc.diffusivity = 1e-11;
    if (!scene_build(s) || !CHECK_OK(&s->ctx, scene_run(s, 60.0))) return;
    double fluid = (double)s->grid.fluid_count * s->stencil.volume;
    double gone = pd_transport_stock(&s->ctx, &s->transport);
    CHECK_REL(gone, CSAT * fluid, 1e-6);
    int64_t steps = s->couple.steps;
    if (!CHECK_OK(&s->ctx, scene_run(s, 1e6))) return;
    CHECK_REL(pd_transport_stock(&s->ctx, &s->transport), CSAT * fluid, 1e-6);
    NOTE("%d steps to saturation, %d from there to 1e6 s", (int)steps, (int)(s->couple.steps - steps));
    CHECK(s->couple.steps - steps < 60);
    CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
    scene_free(s);
}

/* Runs the scene to `end` [s]; of a first run the field is kept, of others the same bits are asked for. */
static void same_bits(scene *s, int first, double end)
{
    static double kept[MOST];
    double before = scene_solid(s);
    if (!CHECK_OK(&s->ctx, scene_run(s, end)) || !CHECK(s->grid.total <= MOST)) return;
    CHECK(scene_solid(s) < 0.995 * before);
    size_t size = (size_t)s->grid.total * sizeof *kept;
    if (first) memcpy(kept, s->transport.c, size);
    else CHECK(memcmp(kept, s->transport.c, size) == 0);
    scene_free(s);
}

TEST(threads_do_not_matter)
{
    for (int run = 0; run < 2; run++) {
        scene *s = lump(PD_DRIVE_CONSTANT, run ? 3 : 1, NULL);
        if (s) same_bits(s, run == 0, 10.0);
    }
}

/* Bonds, what enters by them and rates that are found anew at each step are the same as those that were kept, to the
 * last bit: rough metal under activation control and under diffusion control, behind mirrors, with films. */
TEST(kept_and_anew)
{
    static double factor[MOST], first[MOST];
    uint32_t seed = 11;
    for (int k = 0; k < MOST; k++) factor[k] = 0.5 + (double)(next_random(&seed) % 1000) * 1e-3;
    for (int way = 0; way < 6; way++) {
        int diffusion = way & 1, turned = 0, enough = PD_DIM == 1 ? 3 : 11;
        for (int run = 0; run < 2; run++) {
            int here = 0;
            scene *s = scene_start(20, PD_DIM == 3 ? 6 : 20, 5);
            for (int k = 1; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = PD_SIDE_MIRROR;
            half_space(s, 6.0 * H);
            s->open[0] = 1;
            s->desc.activation = !diffusion;
            s->desc.factor = factor;
            s->desc.stochastic = way >= 4;
            s->desc.drive = way == 2 || way == 3 ? PD_DRIVE_DIFFERENCE : PD_DRIVE_CONSTANT;
            if (way == 1) {
                s->desc.repassivation = 0.4 * CSAT;
                s->transport_desc.initial = 0.9 * CSAT;
            }
            s->transport_desc.diffusivity = 1e-11;
            if (!scene_build(s) || !CHECK(s->grid.total <= MOST)) return;
            int steps = PD_DIM == 3 ? 100 : 200;
            for (int k = 0; (k < steps || here < enough) && k < 2000 && s->grid.solid_count > 0; k++) {
                if (run) s->dissolve.reached = 0;
                if (!scene_step(s, 1e6 * (k + 1.0))) return;
                here += s->dissolve.changed_count;
            }
            turned += here;
            CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
            size_t size = (size_t)s->grid.total * sizeof *first;
            if (!run) memcpy(first, s->transport.c, size);
            else CHECK(memcmp(first, s->transport.c, size) == 0);
            scene_free(s);
        }
        NOTE("way %d: %d nodes turned in both runs", way, turned);
        CHECK(turned >= 2 * enough);
    }
}

/* ---- factors of metal ---- */

/* Twice the factor is twice the speed, to the last bit. */
TEST(factor_is_a_speed)
{
    static double factor[MOST];
    for (int k = 0; k < MOST; k++) factor[k] = 2.0;
    for (int run = 0; run < 2; run++) {
        scene *s = lump(PD_DRIVE_CONSTANT, 1, run ? factor : NULL);
        if (!s) return;
        s->speed = run ? SPEED : 2.0 * SPEED;
        same_bits(s, run == 0, 10.0);
    }
}

/* Factors that differ from node to node, behind periodic and mirror sides, too: nothing is lost. */
TEST(factors_conserve)
{
    static double factor[MOST];
    uint32_t seed = 5;
    for (int k = 0; k < MOST; k++) factor[k] = (double)(next_random(&seed) % 1000) * 3e-3;
    for (int drive = 0; drive < 2; drive++) {
        scene *s = lump((pd_drive)drive, 1, factor);
        if (!s) return;
        for (int k = 1; k <= 5; k++) {
            if (!CHECK_OK(&s->ctx, scene_run(s, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
        }
        CHECK(s->couple.ledger[0].out > 0.0);
        scene_free(s);
    }
}

/* ---- films ---- */

/* In front of a passive film nothing dissolves; where it is open the metal goes as if it were alone. */
TEST(passive_film)
{
    static uint8_t film[MOST];
    double lost[3];
    for (int run = 0; run < 3; run++) { /* closed, open, none */
        scene *s = scene_start(20, 6, 6);
        half_space(s, 6.0 * H);
        memset(film, 1, sizeof film);
        s->desc.passive = run < 2 ? film : NULL;
        if (!scene_build(s)) return;
        for (int32_t i = 0; i < s->grid.total && run; i++) film[i] = s->grid.kind[i] == PD_FLUID ? 0 : 1;
        double before = scene_solid(s);
        while (s->couple.time < 3.0 * H / SPEED) {
            if (!scene_step(s, 3.0 * H / SPEED)) return;
            /* what has turned is open, too */
            for (int32_t i = 0; i < s->grid.total && run; i++) film[i] = s->grid.kind[i] == PD_FLUID ? 0 : 1;
        }
        lost[run] = 1.0 - scene_solid(s) / before;
        scene_free(s);
    }
    CHECK_LE(fabs(lost[0]), 0.0);
    CHECK(lost[2] > 0.1 && fabs(lost[1] - lost[2]) <= 0.0);
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
        s->transport_desc.diffusivity = 1e-12;
        s->transport_desc.initial = 0.5 * CSAT;
        s->desc.repassivation = mode == 1 ? 0.6 * CSAT : mode == 2 ? 0.4 * CSAT : 0.0;
        if (!scene_build(s) || !CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple))) return;
        CHECK((s->dissolve.film != NULL) == (mode > 0));
        double whole = scene_solid(s);
        for (int part = 0; part < 3; part++) { /* above, below and again above the threshold */
            double solid = scene_solid(s);
            scene_fill(s, part == 1 ? 0.5 * CSAT : 0.9 * CSAT);
            if (!CHECK_OK(&s->ctx, scene_run(s, s->couple.time + 0.01 * H / SPEED))) return;
            CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
            lost[part] = (solid - scene_solid(s)) / whole;
        }
        CHECK(lost[0] > 0.0);
        if (mode == 1) CHECK(lost[1] <= 0.0 && lost[2] <= 0.0);
        else CHECK(lost[1] > 0.0 && lost[2] > 0.0);
        scene_free(s);
    }
}

/* A film forms in the first step, too. */
TEST(repassivation_at_the_start)
{
    scene *s = scene_start(20, 6, 6);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->transport_desc.diffusivity = 1e-12;
    s->transport_desc.initial = 0.5 * CSAT;
    s->desc.repassivation = 0.6 * CSAT;
    if (!scene_build(s)) return;
    double before = scene_solid(s);
    if (!CHECK_OK(&s->ctx, scene_run(s, H / SPEED))) return;
    CHECK_LE(before - scene_solid(s), 0.0);
    scene_free(s);
}

/* ---- input ---- */

static double no_number(void *user, const pd_rate_at *at)
{
    (void)user;
    (void)at;
    return (double)NAN;
}

static double broken_law(void *user, const pd_rate_at *at)
{
    return at->c > 0.2 * CSAT ? (double)NAN : *(const double *)user;
}

TEST(bad_input)
{
    static double factor[MOST];
    for (int k = 0; k < MOST; k++) factor[k] = -1.0;
    for (int k = 0; k < 14; k++) {
        scene *s = scene_start(20, 6, 6);
        half_space(s, 6.0 * H);
        s->desc.activation = 0;
        s->transport_desc.diffusivity = 1e-11;
        if (k == 0) s->desc.saturation = CS;
        if (k == 1) s->transport_desc.initial = -1.0;
        if (k == 2) s->transport_desc.diffusivity = (double)NAN;
        if (k == 3) s->couple_desc.fraction = 2.0;
        if (k == 4) s->desc.rate = NULL;
        if (k == 5) s->desc.weights = PD_WEIGHTS_PUBLISHED; /* of area weights */
        if (k == 6) s->desc.drive = (pd_drive)7;
        if (k == 7) s->desc.repassivation = 1.1 * CSAT;
        if (k == 8) s->desc.factor = factor;
        if (k == 9) s->desc.rtol = -1.0;
        if (k == 10) s->desc.bulk = 2.0 * CSAT;
        if (k == 11) s->desc.threshold = 0.1; /* Csat is it */
        if (k == 12) s->desc.model = (pd_metal_model)5;
        if (k == 13) s->desc.rate = no_number;
        if (!scene_lattice(s) || !CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)))
            return;
        CHECK_INT(scene_physics(s), k == 13 ? PD_OK : PD_ERR_ARGUMENT);
        if (k == 13) {
            CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, &s->couple));
            CHECK_INT(pd_time_loop_step(&s->ctx, &s->couple, 1e-3), PD_ERR_STATE);
        }
        CHECK(strlen(s->ctx.message) > 20);
        scene_free(s);
    }
}

/* A law that ends as no number leaves the state as it was. */
TEST(law_that_breaks)
{
    scene *s = scene_start(12, 2, 2);
    half_space(s, 6.0 * H);
    s->desc.activation = 0;
    s->transport_desc.diffusivity = 1e-11;
    s->desc.rate = broken_law;
    if (!scene_build(s)) return;
    pd_transport_result result;
    double solid = scene_solid(s);
    CHECK_OK(&s->ctx, pd_dissolve_prepare(&s->ctx, &s->dissolve));
    CHECK_INT(pdi_dissolve_transport(&s->ctx, &s->dissolve, 0.0, &result), PD_ERR_ARGUMENT);
    s->dissolve.most = 1.0;
    CHECK_INT(pdi_dissolve_transport(&s->ctx, &s->dissolve, 1.0, &result), PD_ERR_STATE);
    CHECK(strstr(s->ctx.message, "nan m/s at c =") != NULL);
    CHECK_NEAR(scene_solid(s), solid, 0.0);
    CHECK_NEAR(pd_transport_stock(&s->ctx, &s->transport), 0.0, 0.0);
    scene_free(s);
}

TEST_MAIN(ENTRY(amounts_and_bounds) ENTRY(saturation_pauses) ENTRY(threads_do_not_matter) ENTRY(kept_and_anew)
              ENTRY(factor_is_a_speed) ENTRY(factors_conserve) ENTRY(passive_film) ENTRY(repassivation_remembers)
                  ENTRY(repassivation_at_the_start) ENTRY(bad_input) ENTRY(law_that_breaks))
