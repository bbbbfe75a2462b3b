/* grain: Voronoi grains and the fraction of their boundaries.
 * dims: 2 3 */
#include "metal/grain.h"
#include "test.h"
#include <stdlib.h>

typedef struct sample {
    pd_ctx ctx;
    pd_shape shape[2];
    pd_stencil stencil;
    pd_grid grid;
    pd_grain grain;
    float *fraction;
} sample;

static void sample_free(sample *s)
{
    pd_grain_free(&s->ctx, &s->grain);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    free(s->fraction);
    s->fraction = NULL;
    CHECK_INT(s->ctx.in_use, 0);
}

/* A box of edge lengths `edge` [m] from `low`, all solid, `cells` nodes along axis 0; spacing ratio `ratio` on axis 1.
 * margin: layers of fluid around. */
static int sample_grid(sample *s, const double *low, const double *edge, int cells, double ratio, int margin, double m)
{
    pd_stencil_desc stencil;
    pd_grid_desc grid;
    memset(s, 0, sizeof *s);
    memset(&stencil, 0, sizeof stencil);
    memset(&grid, 0, sizeof grid);
    pd_ctx_init(&s->ctx);
    s->shape[0].type = PD_SHAPE_BOX;
    stencil.m = m;
    for (int d = 0; d < PD_DIM; d++) {
        stencil.h[d] = edge[0] / cells * (d == 1 ? ratio : 1.0);
        s->shape[0].a[d] = low[d];
        s->shape[0].b[d] = low[d] + edge[d];
        grid.lo[d] = low[d] - margin * stencil.h[d];
        grid.hi[d] = low[d] + edge[d] + margin * stencil.h[d];
    }
    grid.shapes = s->shape;
    grid.solid = &s->shape[0];
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &stencil, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &grid, &s->grid));
}

static int sample_grains(sample *s, const pd_grain_desc *desc)
{
    if (!CHECK_OK(&s->ctx, pd_grain_build(&s->ctx, &s->grid, desc, &s->grain))) return 0;
    s->fraction = (float *)calloc((size_t)s->grid.total, sizeof *s->fraction);
    return CHECK_OK(&s->ctx, pd_grain_fraction(&s->ctx, &s->stencil, &s->grid, &s->grain, s->fraction));
}

static pd_grain_desc describe(double size, double spread, uint64_t seed, double width)
{
    pd_grain_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.size = size;
    desc.spread = spread;
    desc.seed = seed;
    desc.boundary_width = width;
    return desc;
}

/* Cube [0, 1]^d around the origin's neighbourhood. */
static const double origin[3] = {0.0, 0.0, 0.0}, unit_edge[3] = {1.0, 1.0, 1.0};

/* Every id is that of the nearest of all seeds; nodes beyond the reach have none. */
static void check_brute_force(const sample *s)
{
    const pd_grain *g = &s->grain;
    int far = 0, near = 0;
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM], best = 1e300;
        int32_t nearest = -1;
        int within = 0, i[PD_DIM];
        pd_grid_position(&s->grid, node, x);
        pd_grid_index(&s->grid, node, i);
        for (int32_t k = 0; k < g->centre_count; k++) {
            double square = 0.0;
            for (int d = 0; d < PD_DIM; d++) {
                double apart = x[d] - g->centre[k * PD_DIM + d];
                square += apart * apart;
            }
            if (square < best) {
                best = square;
                nearest = k;
            }
        }
        if (g->id[node] >= 0) {
            near++;
            CHECK_INT(g->id[node], nearest);
        } else {
            far++;
            CHECK_INT(g->id[node], -1);
            CHECK(s->grid.kind[node] != PD_SOLID);
        }
        /* whole families of solid nodes have grains */
        for (int k = 0; k < s->stencil.count && !within; k++) {
            int j[PD_DIM], inside = 1;
            for (int d = 0; d < PD_DIM; d++) {
                j[d] = i[d] + s->stencil.offset[k * PD_DIM + d];
                inside = inside && j[d] >= 0 && j[d] < s->grid.n[d];
            }
            within = inside && s->grid.kind[pd_grid_node(&s->grid, j)] == PD_SOLID;
        }
        if (within) CHECK(g->id[node] >= 0);
    }
    CHECK(near > 0 && far > 0);
}

TEST(nearest_seed)
{
    static const double spreads[] = {0.0, 0.05, 0.12};
    for (int k = 0; k < 3; k++) {
        sample s;
        pd_grain_desc desc = describe(0.2, 0.2 * spreads[k], 17 + (uint64_t)k, 1e-3);
        if (sample_grid(&s, origin, unit_edge, PD_DIM == 2 ? 40 : 14, 1.0, 8, 3.0) && sample_grains(&s, &desc))
            check_brute_force(&s);
        sample_free(&s);
    }
    /* far from the origin, and seeds of one's own: some outside of the solid */
    double away[3] = {1000.0, -2000.0, 500.0}, centre[60 * PD_DIM];
    for (int c = 0; c < 60; c++)
        for (int d = 0; d < PD_DIM; d++)
            centre[c * PD_DIM + d] = away[d] - 1.0 + 3.0 * fmod(0.618 * (c + 1) * (d + 1), 1.0);
    for (int own = 0; own < 2; own++) {
        sample s;
        pd_grain_desc desc = describe(0.2, 0.0, 5, 1e-3);
        desc.centres = own ? centre : NULL;
        desc.centre_count = own ? 60 : 0;
        if (sample_grid(&s, away, unit_edge, PD_DIM == 2 ? 40 : 14, 1.0, 8, 3.0) && sample_grains(&s, &desc))
            check_brute_force(&s);
        sample_free(&s);
    }
}

/* The grain of a place is the same on a grid three times finer (whose nodes include those of the coarse one), on a grid
 * that covers more, and for any number of threads. */
TEST(independent_of_grid_and_threads)
{
    int cells = PD_DIM == 2 ? 30 : 9;
    double low[3] = {-0.5, -0.5, -0.5}, wide[3] = {2.0, 2.0, 2.0};
    sample coarse, fine, more, serial;
    pd_grain_desc desc = describe(0.25, 0.0, 99, 1e-3);
    int ready = sample_grid(&coarse, origin, unit_edge, cells, 1.0, 4, 3.0) && sample_grains(&coarse, &desc);
    ready = sample_grid(&fine, origin, unit_edge, 3 * cells, 1.0, 4, 3.0) && sample_grains(&fine, &desc) && ready;
    ready = sample_grid(&serial, origin, unit_edge, 3 * cells, 1.0, 4, 3.0) && ready;
    serial.ctx.threads = 1;
    ready = sample_grains(&serial, &desc) && ready;
    ready = sample_grid(&more, low, wide, 2 * cells, 1.0, 4, 3.0) && sample_grains(&more, &desc) && ready;
    int compared = 0;
    for (int32_t node = 0; ready && node < coarse.grid.total; node++) {
        int i[PD_DIM], f[PD_DIM], w[PD_DIM];
        if (coarse.grid.kind[node] != PD_SOLID) continue;
        pd_grid_index(&coarse.grid, node, i);
        for (int d = 0; d < PD_DIM; d++) {
            f[d] = 3 * (i[d] - 4) + 1 + 4;
            w[d] = i[d] + cells / 2;
        }
        const double *seed = coarse.grain.centre + coarse.grain.id[node] * PD_DIM;
        const double *same = fine.grain.centre + fine.grain.id[pd_grid_node(&fine.grid, f)] * PD_DIM;
        CHECK(memcmp(seed, same, PD_DIM * sizeof *seed) == 0);
        if (cells % 2 == 0) {
            same = more.grain.centre + more.grain.id[pd_grid_node(&more.grid, w)] * PD_DIM;
            CHECK(memcmp(seed, same, PD_DIM * sizeof *seed) == 0);
        }
        compared++;
    }
    CHECK_INT(compared, coarse.grid.solid_count);
    if (ready) {
        CHECK_INT(fine.grain.centre_count, serial.grain.centre_count);
        CHECK(memcmp(fine.grain.id, serial.grain.id, (size_t)fine.grid.total * sizeof(int32_t)) == 0);
        CHECK(memcmp(fine.fraction, serial.fraction, (size_t)fine.grid.total * sizeof(float)) == 0);
    }
    sample_free(&coarse);
    sample_free(&fine);
    sample_free(&more);
    sample_free(&serial);
}

static double mean_fraction(const sample *s)
{
    pd_grain_stats stats;
    pd_ctx ctx = s->ctx;
    CHECK_OK(&ctx, pdi_grain_measure(&ctx, &s->grid, &s->grain, s->fraction, &stats));
    return stats.boundary_fraction;
}

/* Two grains and one plane between them, straight and tilted, equal and unequal spacings: fraction = w_gb area /
 * volume. Along an axis the weights are exact; tilted planes are as good as the stencil is isotropic. */
TEST(plane_boundary)
{
    static const double normals[4][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {1.0, 1.0, 0.0}, {2.0, 1.0, 0.0}};
    /* the diagonal x + y = c halfway between two rows of nodes, off the corners of the box */
    int cells = PD_DIM == 2 ? 64 : 24;
    double c = (floor(1.3 * cells) + 0.5) / cells;
    for (int k = 0; k < 4; k++)
        for (int unequal = 0; unequal < (k < 2 ? 2 : 1); unequal++) {
            double centre[2 * PD_DIM], norm = 0.0;
            for (int d = 0; d < PD_DIM; d++) norm += normals[k][d] * normals[k][d];
            for (int d = 0; d < PD_DIM; d++) {
                double middle = k == 2 ? 0.5 * c : d == 0 ? 0.503 : 0.498; /* off the faces between nodes */
                centre[d] = middle - 0.2 * normals[k][d] / sqrt(norm);
                centre[PD_DIM + d] = middle + 0.2 * normals[k][d] / sqrt(norm);
            }
            sample s;
            pd_grain_desc desc = describe(0.0, 0.0, 0, 2e-3);
            desc.centres = centre;
            desc.centre_count = 2;
            if (sample_grid(&s, origin, unit_edge, cells, unequal ? 0.5 : 1.0, 4, 3.0) &&
                sample_grains(&s, &desc)) {
                /* length of the cut through the unit square (the rest of the cube is a prism) */
                double a = normals[k][0], b = normals[k][1], length = 1.0;
                if (k == 2) length = sqrt(2.0) * (2.0 - c);
                if (k == 3) length = 0.5 * sqrt(5.0); /* 2 x + y = 1.504, from y = 0 to y = 1 */
                double got = mean_fraction(&s);
                NOTE("normal (%g, %g): %.6g, exact %.6g", a, b, got, 2e-3 * length);
                CHECK_REL(got, 2e-3 * length, k < 2 ? 1e-6 : 1.2e-2);
            }
            sample_free(&s);
        }
}

/* Seeds of a square (cubic) lattice turned by 0.3 about the last axis: S_V = PD_DIM / edge exactly. The box of ten
 * edges holds whole grains only in the mean: some permille. */
TEST(refinement)
{
    double a = 0.21, turn = 0.3, width = 1e-4;
    static double centre[20000 * PD_DIM];
    int count = 0;
    for (int i = -8; i <= 8; i++)
        for (int j = -8; j <= 8; j++)
            for (int k = PD_DIM == 3 ? -8 : 0; k <= (PD_DIM == 3 ? 8 : 0); k++) {
                double q[3];
                q[0] = 0.5 + a * (i * cos(turn) - j * sin(turn));
                q[1] = 0.5 + a * (i * sin(turn) + j * cos(turn));
                q[2] = 0.47 + a * k;
                for (int d = 0; d < PD_DIM; d++) centre[count * PD_DIM + d] = q[d];
                count++;
            }
    double error[3];
    for (int level = 0; level < 3; level++) {
        sample s;
        pd_grain_desc desc = describe(0.0, 0.0, 0, width);
        desc.centres = centre;
        desc.centre_count = count;
        double low[3] = {-0.55, -0.55, -0.58}, edge[3] = {2.1, 2.1, 2.1};
        int cells = (PD_DIM == 2 ? 40 : 18) << level;
        error[level] = 1.0;
        if (sample_grid(&s, low, edge, cells, 1.0, 4, 3.0) && sample_grains(&s, &desc)) {
            double exact = width * PD_DIM / a;
            error[level] = mean_fraction(&s) / exact - 1.0;
            NOTE("%g cells per grain: boundary fraction %.3f %% off", a / s.grid.h[0], 100.0 * error[level]);
        }
        sample_free(&s);
    }
    CHECK_LE(fabs(error[0]), 1e-2);
    CHECK_LE(fabs(error[1]), 1e-2);
    CHECK_LE(fabs(error[2]), 5e-3);
}

/* Poisson-Voronoi mosaics: boundary per volume 2 sqrt(lambda) in 2D, 2.910 lambda^(1/3) in 3D (Meijering 1953). */
TEST(poisson_voronoi)
{
    sample s;
    double size = PD_DIM == 2 ? 0.03 : 0.16, width = 1e-5;
    int cells = PD_DIM == 2 ? 700 : 76;
    double lambda = PD_DIM == 2 ? 4.0 / (3.14159265358979 * size * size)
                                : 6.0 / (3.14159265358979 * size * size * size);
    double theory = PD_DIM == 2 ? 2.0 * sqrt(lambda) : 2.910 * cbrt(lambda);
    pd_grain_desc desc = describe(size, 0.0, 2024, width);
    if (sample_grid(&s, origin, unit_edge, cells, 1.0, 3, 3.0) && sample_grains(&s, &desc)) {
        double got = mean_fraction(&s) / width;
        NOTE("lambda %.4g, %g cells per grain: S_V %.4g, theory %.4g", lambda, size * cells, got, theory);
        CHECK_REL(got, theory, 0.03);
    }
    sample_free(&s);
}

/* Equivalent diameters of grains whose seed lies a good way inside. */
static void diameters(const sample *s, double border, double *mean, double *deviation, double *variation)
{
    const pd_grain *g = &s->grain;
    double *share = (double *)calloc((size_t)g->centre_count, sizeof *share), cell = 1.0, n = 0.0;
    double unit = PD_DIM == 2 ? 0.7853981633974483 : 0.5235987755982988;
    double sum = 0.0, square = 0.0, area = 0.0, area2 = 0.0;
    for (int d = 0; d < PD_DIM; d++) cell *= s->grid.h[d];
    for (int32_t node = 0; node < s->grid.total; node++)
        if (s->grid.kind[node] == PD_SOLID) share[g->id[node]] += cell;
    for (int32_t k = 0; k < g->centre_count; k++) {
        int inside = share[k] > 0.0;
        for (int d = 0; d < PD_DIM; d++)
            inside = inside && g->centre[k * PD_DIM + d] > border && g->centre[k * PD_DIM + d] < 1.0 - border;
        if (!inside) continue;
        double diameter = pow(share[k] / unit, 1.0 / PD_DIM);
        n += 1.0;
        sum += diameter;
        square += diameter * diameter;
        area += share[k];
        area2 += share[k] * share[k];
    }
    *mean = sum / n;
    *deviation = sqrt(square / n - *mean * *mean);
    *variation = sqrt(area2 / n / (area / n * (area / n)) - 1.0);
    free(share);
}

/* Random seeds: std of the area (volume) over its mean 0.529 (0.423), Gilbert 1962; else the spread asked for. */
TEST(size_distribution)
{
    static const double asked[2][4] = {{0.0, 0.05, 0.125, 0.2}, {0.0, 0.03, 0.07, 0.11}};
    for (int k = 0; k < 4; k++) {
        sample s;
        double size = PD_DIM == 2 ? 0.03 : 0.1, spread = asked[PD_DIM - 2][k] * size, mean, deviation, variation;
        pd_grain_desc desc = describe(size, spread, 7, 0.0);
        if (sample_grid(&s, origin, unit_edge, PD_DIM == 2 ? 500 : 80, 1.0, 3, 1.0) && sample_grains(&s, &desc)) {
            diameters(&s, 1.5 * size, &mean, &deviation, &variation);
            NOTE("size %g, spread %g asked: mean %.4g, std %.4g, variation of the volume %.3f", size, spread, mean,
                 deviation, variation);
            CHECK_REL(mean, size, 0.06);
            if (k == 0) CHECK_REL(variation, PD_DIM == 2 ? 0.529 : 0.423, 0.12);
            else CHECK_REL(deviation, spread, 0.12);
            CHECK_NEAR(mean_fraction(&s), 0.0, 0.0);
        }
        sample_free(&s);
    }
}

/* phi does not see what dissolves around a node, is 0 in fluid and 1 where the boundary is wider than the cells. */
TEST(fraction_and_dissolution)
{
    sample s;
    pd_grain_desc desc = describe(0.3, 0.0, 3, 1e-3);
    if (sample_grid(&s, origin, unit_edge, PD_DIM == 2 ? 40 : 16, 1.0, 4, 3.0) && sample_grains(&s, &desc)) {
        float *later = (float *)calloc((size_t)s.grid.total, sizeof *later);
        for (int32_t node = 0; node < s.grid.total; node += 3)
            if (s.grid.kind[node] == PD_SOLID) pdi_grid_set_fluid(&s.grid, node);
        CHECK_OK(&s.ctx, pd_grain_fraction(&s.ctx, &s.stencil, &s.grid, &s.grain, later));
        for (int32_t node = 0; node < s.grid.total; node++)
            CHECK(later[node] == (s.grid.kind[node] == PD_SOLID ? s.fraction[node] : 0.0f));
        s.grain.boundary_width = 10.0;
        CHECK_OK(&s.ctx, pd_grain_fraction(&s.ctx, &s.stencil, &s.grid, &s.grain, later));
        for (int32_t node = 0; node < s.grid.total; node++)
            CHECK(later[node] == (s.grid.kind[node] == PD_SOLID && s.fraction[node] > 0.0f ? 1.0f : 0.0f));
        free(later);
    }
    sample_free(&s);
}

TEST(statistics)
{
    /* four equal grains in a square (column): diameters from the area 1/4 */
    double centre[4 * PD_DIM];
    for (int k = 0; k < 4; k++)
        for (int d = 0; d < PD_DIM; d++) centre[k * PD_DIM + d] = d == 2 ? 0.5 : 0.25 + 0.5 * ((k >> d) & 1);
    sample s;
    pd_grain_stats stats;
    pd_grain_desc desc = describe(0.0, 0.0, 0, 1e-3);
    desc.centres = centre;
    desc.centre_count = 4;
    if (sample_grid(&s, origin, unit_edge, 20, 1.0, 4, 1.0) && sample_grains(&s, &desc) &&
        CHECK_OK(&s.ctx, pdi_grain_measure(&s.ctx, &s.grid, &s.grain, s.fraction, &stats))) {
        double diameter = PD_DIM == 2 ? sqrt(0.25 * 4.0 / 3.14159265358979) : cbrt(0.25 * 6.0 / 3.14159265358979);
        CHECK_INT(stats.count, 4);
        CHECK_REL(stats.mean, diameter, 1e-12);
        CHECK_NEAR(stats.deviation, 0.0, 1e-7);
        CHECK_REL(stats.boundary_fraction, 2e-3, 0.03);
    }
    sample_free(&s);
    /* three columns of widths 0.2, 0.4 and 0.4: mean and deviation of their diameters */
    static const double place[3] = {0.1, 0.3, 0.9}, width[3] = {0.2, 0.4, 0.4};
    double sum = 0.0, square = 0.0;
    for (int k = 0; k < 3; k++) {
        double d = PD_DIM == 2 ? sqrt(width[k] * 4.0 / 3.14159265358979) : cbrt(width[k] * 6.0 / 3.14159265358979);
        for (int a = 0; a < PD_DIM; a++) centre[k * PD_DIM + a] = a ? 0.5 : place[k];
        sum += d / 3.0;
        square += d * d / 3.0;
    }
    desc.centre_count = 3;
    if (sample_grid(&s, origin, unit_edge, 20, 1.0, 4, 1.0) && sample_grains(&s, &desc) &&
        CHECK_OK(&s.ctx, pdi_grain_measure(&s.ctx, &s.grid, &s.grain, s.fraction, &stats))) {
        CHECK_INT(stats.count, 3);
        CHECK_REL(stats.mean, sum, 1e-12);
        CHECK_REL(stats.deviation, sqrt(square - sum * sum), 1e-9);
    }
    sample_free(&s);
}

static void refuse(sample *s, pd_grain_desc desc, const char *part)
{
    CHECK_INT(pd_grain_build(&s->ctx, &s->grid, &desc, &s->grain), PD_ERR_ARGUMENT);
    if (!CHECK(strstr(s->ctx.message, part) != NULL)) NOTE("message: %s", s->ctx.message);
    pd_grain_free(&s->ctx, &s->grain);
}

TEST(refusals)
{
    sample s;
    if (!sample_grid(&s, origin, unit_edge, 10, 1.0, 4, 1.0)) return;
    refuse(&s, describe(0.0, 0.0, 1, 0.0), "grain: the grain size is 0 m, expected at least the spacing 0.1 m");
    refuse(&s, describe(0.05, 0.0, 1, 0.0), "expected at least the spacing");
    refuse(&s, describe(0.3, 0.3, 1, 0.0), "the spread of the grain size is 0.3 m, expected 0 (random seeds) or up to");
    refuse(&s, describe(0.3, -0.1, 1, 0.0), "the spread of the grain size is -0.1 m");
    refuse(&s, describe(0.3, 0.0, 1, -1.0), "the boundary width is -1 m, expected 0 or more");
    pd_grain_desc desc = describe(0.3, 0.0, 1, 0.0);
    desc.centre_count = 3;
    refuse(&s, desc, "3 centres without an array");
    /* every coordinate of every centre is a number, and what stands behind the last is not looked at */
    double centre[4 * PD_DIM];
    desc.centres = centre;
    for (int k = 0; k <= 3 * PD_DIM; k++) {
        char text[60];
        for (int d = 0; d < 4 * PD_DIM; d++) centre[d] = 0.1 + 0.05 * d;
        centre[k] = (double)NAN;
        snprintf(text, sizeof text, "grain: centre %d has coordinate nan m", k / PD_DIM);
        if (k < 3 * PD_DIM) refuse(&s, desc, text);
        else CHECK_OK(&s.ctx, pd_grain_build(&s.ctx, &s.grid, &desc, &s.grain));
        pd_grain_free(&s.ctx, &s.grain);
    }
    desc.centre_count = 0;
    refuse(&s, desc, "grain: 0 centres with an array");
    desc.centres = NULL;
    /* a limit on memory is an error, and leaves something that can be freed */
    size_t before = s.ctx.in_use;
    CHECK_OK(&s.ctx, pd_grain_build(&s.ctx, &s.grid, &desc, &s.grain));
    size_t needed = s.ctx.in_use - before;
    pd_grain_free(&s.ctx, &s.grain);
    CHECK_INT(s.ctx.in_use, before);
    for (int k = 0; k < 20; k++) { /* less than it holds when it is built */
        s.ctx.alloc.limit = before + 1 + (size_t)k * (needed - 2) / 19;
        CHECK_INT(pd_grain_build(&s.ctx, &s.grid, &desc, &s.grain), PD_ERR_LIMIT);
        pd_grain_free(&s.ctx, &s.grain);
        CHECK_INT(s.ctx.in_use, before);
    }
    s.ctx.alloc.limit = before + 10 * needed;
    CHECK_OK(&s.ctx, pd_grain_build(&s.ctx, &s.grid, &desc, &s.grain));
    pd_grain_free(&s.ctx, &s.grain);
    sample_free(&s);
}

TEST_MAIN(ENTRY(nearest_seed) ENTRY(independent_of_grid_and_threads) ENTRY(plane_boundary)
          ENTRY(refinement) ENTRY(poisson_voronoi) ENTRY(size_distribution)
          ENTRY(fraction_and_dissolution) ENTRY(statistics) ENTRY(refusals))
