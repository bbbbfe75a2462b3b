/* Mechanical bonds that break at random: the law of their damage, fronts, amounts, seeds, threads, diffusion.
 * dims: 1 2 3 */
#include "metal_scene.h"
#include "metal/damage.h"
#include "metal/entry.h"

/* ---- bonds ---- */

/* At the expected damage e the broken bonds of a node are binomial with mean N e; an intact one breaks on the way to f
 * with (f - e)/(1 - e), whatever broke before; none is mended. Bounds: five standard deviations. */
TEST(bonds_break_as_metal_goes)
{
    enum { NODES = 40000 };
    static const int bonds[3] = {2, 36, 146};
    for (int b = 0; b < 3; b++) {
        int n = bonds[b];
        double before = 0.0;
        static double share[NODES];
        memset(share, 0, sizeof share);
        for (int step = 1; step <= 10; step++) {
            double e = step < 10 ? 0.1 * step - 0.03 * (step % 2) : 1.0, p = (e - before) / (1.0 - before);
            double mean = 0.0, square = 0.0, broke = 0.0, expected = 0.0, variance = 0.0;
            for (int i = 0; i < NODES; i++) {
                double now = pdi_damage_broken(7, i, n, e);
                CHECK(now >= share[i]);
                broke += n * (now - share[i]);
                expected += n * (1.0 - share[i]) * p;
                variance += n * (1.0 - share[i]) * p * (1.0 - p);
                mean += now / NODES;
                square += (now - e) * (now - e) / NODES;
                share[i] = now;
            }
            double binomial = e * (1.0 - e) / n, rounding = 1e-11; /* of sums over NODES */
            CHECK_NEAR(broke, expected, 5.0 * sqrt(variance) + rounding * NODES * n);
            CHECK_NEAR(mean, e, 5.0 * sqrt(binomial / NODES) + rounding);
            /* fourth moment of a binomial share: at most 3 variance^2 + variance/n^2 */
            CHECK_NEAR(square, binomial,
                       5.0 * sqrt((2.0 * binomial * binomial + binomial / n / n) / NODES) + rounding);
            before = e;
        }
    }
}

/* The last bond: the largest of N numbers has the mean N/(N+1) and the variance N/((N+1)^2 (N+2)). */
TEST(last_bond)
{
    enum { NODES = 20000 };
    static const int bonds[3] = {1, 36, 146};
    for (int b = 0; b < 3; b++) {
        double n = bonds[b], mean = 0.0, variance = n / ((n + 1.0) * (n + 1.0) * (n + 2.0));
        for (int i = 0; i < NODES; i++) {
            double last = pdi_damage_last(3, i, bonds[b]);
            if (!CHECK(pdi_damage_broken(3, i, bonds[b], last) >= 1.0)) return;
            if (!CHECK(pdi_damage_broken(3, i, bonds[b], last * (1.0 - 1e-12)) < 1.0)) return;
            mean += last / NODES;
        }
        CHECK_NEAR(mean, n / (n + 1.0), 5.0 * sqrt(variance / NODES));
    }
    CHECK_NEAR(pdi_damage_last(3, 5, 0), 1.0, 0.0); /* no bonds: Csat decides */
    CHECK_NEAR(pdi_damage_broken(3, 5, 0, 0.25), 0.25, 0.0);
}

/* ---- fronts ---- */

/* A half-space of metal that faces x-, periodic across; `across` cells (3D: squared to the same number). */
static scene *flat(int length, int across, double share, uint64_t seed)
{
    int side = PD_DIM == 3 ? (int)floor(sqrt((double)across) + 0.5) : across;
    scene *s = scene_start(length, side, side);
    scene_periodic(s);
    half_space(s, 6.0 * H);
    if (PD_DIM == 3) s->stencil_desc.m = 2.0;
    s->desc.stochastic = 1;
    s->desc.seed = seed;
    s->couple_desc.fraction = share;
    return scene_build(s) ? s : NULL;
}

/* The damage of metal, where it is exposed, has the mean that belongs to its loss: of a node that is still solid, whose
 * bonds have not all been drawn below e, (e - e^N)/(1 - e^N). Before and after the front gets rough. */
TEST(damage_follows_the_loss)
{
    scene *s = flat(40, PD_DIM == 1 ? 1 : 400, 0.05, 1);
    if (!s) return;
    double off = 0.0, variance = 0.0, nodes = 0.0, largest = 0.0;
    for (int step = 1; step <= 400; step++) {
        if (!scene_step(s, 1e6)) return;
        if (step % 40 && step > 10) continue;
        double here = 0.0, spread = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (!s->dissolve.exposed[i] || s->transport.c[i] <= s->dissolve.last[i]) continue;
            double n = s->dissolve.links[i], e = (CS - s->transport.c[i]) / (CS - CSAT), all = pow(e, n);
            double mean = (e - all) / (1.0 - all), square = (e * (1.0 - e) / n + e * e - all) / (1.0 - all);
            here += pdi_dissolve_damage(&s->dissolve, i) - mean;
            spread += square - mean * mean;
            nodes += 1.0;
            largest = fmax(largest, e);
        }
        CHECK_LE(fabs(here), 5.0 * sqrt(spread) + 1e-12);
        off += here;
        variance += spread;
    }
    NOTE("%.0f nodes and times, mean damage off by %.2g, deviation of one time %.2g, e up to %.3f", nodes, off / nodes,
         sqrt(variance) / nodes, largest);
    CHECK(nodes > (PD_DIM == 1 ? 40 : 10000) && largest > 0.5);
    scene_free(s);
}

/* Weight of all bonds across the front over that of a flat one along x [-]. */
static double measure(const scene *s)
{
    double sum = 0.0, area = 1.0;
    for (int d = 1; d < PD_DIM; d++) area *= s->grid.n[d];
    for (int32_t i = 0; i < s->grid.total; i++) {
        int at[PD_DIM];
        pd_grid_index(&s->grid, i, at);
        if (!pd_grid_is_inside(&s->grid, at) || s->grid.kind[i] != PD_SOLID) continue;
        for (int k = 0; k < s->stencil.count; k++)
            if (s->grid.kind[pdi_entry_far(&s->bonds.paths, i, k)] == PD_FLUID) sum += s->dissolve.kernel.weight[k];
    }
    return sum * H / area;
}

/* A node leaves with 1/(N+1) of Cs - Csat on average, so the bonds across a front carry N/(N+1) of what they carry when
 * nothing breaks, and it is faster than v = k h sum n w_n/ln(Cs/Csat) by (N+1)/N, times the weight of the bonds across
 * it over that of a flat one. The speed is that at which metal goes. What M nodes leave with has the deviation
 * 1/((N+1) sqrt(M)) in the mean; the stretch that is timed begins and ends somewhere within a layer, which leaves a
 * share of Csat/Cs and of 1/(N+1) of one layer open. */
TEST(front_speed)
{
    static const double share[2] = {0.05, 0.02};
    double found[2];
    for (int k = 0; k < 2; k++) {
        scene *s = flat(50, PD_DIM == 1 ? 1 : 400, share[k], 1);
        if (!s) return;
        double n = s->stencil.count, first = 0.0, start = 0.0, place = 0.0, weight = 0.0, rows = 1.0, layers = 26.0;
        for (int d = 1; d < PD_DIM; d++) rows *= s->grid.n[d];
        double layer = rows * CS * s->stencil.volume, whole = scene_solid(s);
        CHECK_NEAR(measure(s), 1.0, 1e-12);
        while (place < 8.0 + layers) {
            double time = s->couple.time, area = measure(s);
            if (!scene_step(s, 1e6)) return;
            place = (whole - scene_solid(s)) / layer;
            if (place < 8.0) {
                start = s->couple.time;
                first = place;
            } else weight += area * (s->couple.time - time);
        }
        double took = s->couple.time - start;
        double noise = 3.0 / ((n + 1.0) * sqrt(layers * rows)) + (CSAT / CS + 1.0 / (n + 1.0)) / layers;
        weight /= took;
        found[k] = (place - first) * H / took / SPEED;
        double derived = weight * (n + 1.0) / n;
        NOTE("share %.2f: speed %.4f, expected %.4f, off by %.4f, bound %.4f (%.0f bonds, weight %.4f)", share[k],
             found[k], derived, fabs(found[k] / derived - 1.0), noise, n, weight);
        CHECK_REL(found[k], derived, noise);
        if (PD_DIM > 1) CHECK(weight > 1.0 && weight < 1.02);
        CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
        scene_free(s);
    }
    CHECK_REL(found[0], found[1], PD_DIM == 1 ? 5e-3 : 1e-2);
}

#if PD_DIM > 1
/* Mean and deviation of the place of the front in cells: the number of fluid nodes of each row along x. */
static double roughness(const scene *s, double *mean)
{
    int rows = 1;
    double square = 0.0;
    for (int d = 1; d < PD_DIM; d++) rows *= s->grid.n[d];
    *mean = 0.0;
    for (int row = 0; row < rows; row++) {
        int at[3], rest = row, fluid = 0;
        for (int d = 1; d < PD_DIM; d++) {
            at[d] = rest % s->grid.n[d];
            rest /= s->grid.n[d];
        }
        for (at[0] = 0; at[0] < s->grid.n[0]; at[0]++) fluid += s->grid.kind[pd_grid_node(&s->grid, at)] == PD_FLUID;
        *mean += (double)fluid / rows;
        square += (double)fluid * fluid / rows;
    }
    return sqrt(fmax(0.0, square - *mean * *mean));
}

/* The front is flat at first and gets rough within ten layers; in 2D its deviation grows from there, but bonds that
 * reach around keep it within a cell. Where nothing breaks at random it stays flat. */
TEST(roughness_grows)
{
    for (int stochastic = 0; stochastic < 2; stochastic++) {
        double place = 0.0, square = 0.0, time = 0.0, found[4];
        scene *s = scene_start(60, PD_DIM == 2 ? 600 : 16, 16);
        scene_periodic(s);
        half_space(s, 6.0 * H);
        s->stencil_desc.m = 2.0;
        s->couple_desc.fraction = 0.05;
        s->desc.stochastic = stochastic;
        if (!scene_build(s)) return;
        for (int window = 0; window < 4;) {
            double before = s->couple.time, now;
            if (!scene_step(s, 1e6)) return;
            now = roughness(s, &place);
            square += now * now * (s->couple.time - before);
            time += s->couple.time - before;
            if (place < 16.0 + 10.0 * window) continue;
            found[window++] = sqrt(square / time);
            square = time = 0.0;
        }
        NOTE("%s: %.4f, %.4f, %.4f, %.4f cells, ten layers each", stochastic ? "stochastic" : "deterministic",
             found[0], found[1], found[2], found[3]);
        for (int k = 0; k < 4; k++) {
            if (stochastic) CHECK(found[k] > (k && PD_DIM == 2 ? found[k - 1] : 0.05) && found[k] < 0.5);
            else CHECK_LE(found[k], 1e-5);
        }
        scene_free(s);
    }
}
#endif

/* ---- amounts, seeds, threads ---- */

static scene *random_lump(pd_drive drive, int threads, uint64_t seed)
{
    scene *s = lump(drive, threads, NULL);
    if (!s) return NULL;
    pd_dissolve_free(&s->ctx, &s->dissolve);
    pd_transport_free(&s->ctx, &s->transport);
    s->transport_desc.diffusivity = 1e-10;
    s->speed = 1e-6;
    s->desc.stochastic = 1;
    s->desc.seed = seed;
    return CHECK_OK(&s->ctx, scene_physics(s)) ? s : NULL;
}

/* Nothing is lost, though nodes turn fluid above saturation; contents keep their bounds. */
TEST(amounts_are_conserved)
{
    for (int drive = 0; drive < 2; drive++) {
        scene *s = random_lump((pd_drive)drive, 0, 5);
        if (!s) return;
        int32_t before = (int32_t)s->grid.solid_count, above = 0;
        for (int k = 1; k <= 20; k++) {
            if (!CHECK_OK(&s->ctx, scene_run(s, (PD_DIM == 1 ? 3.0 : 0.5) * k))) return;
            CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
            for (int32_t i = 0; i < s->grid.total; i++) {
                if (s->grid.kind[i] != PD_SOLID && s->grid.kind[i] != PD_FLUID) continue;
                /* fluid without metal ends within the tolerance of the linear solves */
                CHECK(s->transport.c[i] >= -1e-9 * CSAT && s->transport.c[i] <= CS);
                above += s->grid.kind[i] == PD_FLUID && s->transport.c[i] > 1.06 * CSAT;
            }
        }
        CHECK(s->grid.solid_count < before && (above > 0 || PD_DIM == 1));
        scene_free(s);
    }
}

/* The same bits for any number of threads and for the same seed; another seed, another front. */
TEST(seeds_and_threads)
{
    static double kept[40000];
    for (int run = 0; run < 3; run++) {
        uint64_t seed = run == 2 ? 6 : 5;
        scene *s = PD_DIM == 1 ? flat(30, 1, 0.05, seed) : random_lump(PD_DRIVE_CONSTANT, run == 1 ? 3 : 1, seed);
        if (!s || !CHECK_OK(&s->ctx, scene_run(s, PD_DIM == 1 ? 4.0 * H / SPEED : 3.0))) return;
        if (!CHECK(s->grid.total <= (int32_t)(sizeof kept / sizeof *kept))) return;
        size_t size = (size_t)s->grid.total * sizeof *kept;
        if (run == 0) memcpy(kept, s->transport.c, size);
        else CHECK((memcmp(kept, s->transport.c, size) == 0) == (run == 1));
        scene_free(s);
    }
}

/* Nodes without bonds turn at Csat, as without random breaking. */
TEST(lone_nodes)
{
    scene *s = scene_start(20, 20, 20);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = 0.4 * H;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = 10.5 * H;
    s->desc.stochastic = 1;
    s->couple_desc.fraction = 0.01;
    if (!scene_build(s)) return;
    CHECK_INT(s->grid.solid_count, 1);
    for (int step = 0; step < 100000 && s->grid.solid_count; step++) {
        int32_t alone = -1;
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_SOLID) alone = i;
        CHECK(alone >= 0 && s->transport.c[alone] > CSAT);
        CHECK_REL(pdi_dissolve_damage(&s->dissolve, alone), (CS - s->transport.c[alone]) / (CS - CSAT), 1e-12);
        if (!scene_step(s, 1e6)) return;
    }
    CHECK_INT(s->grid.solid_count, 0);
    CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
    scene_free(s);
}

/* ---- diffusion ---- */

/* Metal beside a held side, diffusion control: long steps and short ones lose the same up to their errors, and what
 * turns above saturation is not lost. */
TEST(long_steps)
{
    double lost[2] = {0.0, 0.0}, most = 0.0;
    for (int run = 0; run < 2; run++) {
        scene *s = scene_start(30, PD_DIM == 3 ? 6 : 16, 6);
        scene_periodic(s);
        s->grid_desc.side[1] = PD_SIDE_MIRROR;
        s->open[0] = 1;
        half_space(s, 6.0 * H);
        if (PD_DIM == 3) s->stencil_desc.m = 2.0;
        s->desc.activation = 0;
        s->transport_desc.diffusivity = 1e-11;
        s->desc.stochastic = 1;
        s->desc.seed = 2;
        s->speed = 1e-6;
        s->couple_desc.fraction = run ? 0.05 : 0.005; /* of first order in it */
        s->desc.rtol = run ? 0.0 : 1e-4;
        if (!scene_build(s)) return;
        double before = scene_solid(s);
        while (s->couple.time < 30.0) {
            if (!scene_step(s, 30.0)) return;
            for (int32_t i = 0; i < s->grid.total; i++)
                if (s->grid.kind[i] == PD_FLUID) most = fmax(most, s->transport.c[i]);
        }
        lost[run] = 1.0 - scene_solid(s) / before;
        CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-13);
        NOTE("%s: lost %.5f in %d steps", run ? "long steps" : "short steps", lost[run], (int)s->couple.steps);
        scene_free(s);
    }
    CHECK(lost[0] > 0.05);
    CHECK_REL(lost[1], lost[0], PD_DIM == 1 ? 0.05 : 0.01);
    CHECK(most > CSAT);
}

#if PD_DIM == 1
#define OF_DIM
#else
#define OF_DIM ENTRY(roughness_grows)
#endif

TEST_MAIN(ENTRY(bonds_break_as_metal_goes) ENTRY(last_bond) ENTRY(damage_follows_the_loss)
          SLOW_ENTRY_IF(PD_DIM > 1, front_speed) OF_DIM ENTRY(amounts_are_conserved)
          ENTRY(seeds_and_threads) ENTRY(lone_nodes) ENTRY(long_steps))
