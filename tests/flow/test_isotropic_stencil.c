/* isotropic_stencil: friction whose leading error is a Laplacian of the Laplacian: exactness, order, symmetry,
 * conservation. dims: 2 3 */
#include "fixture.h"

static scene test_scene;

/* n cells an axis (3D: six along z) of these spacings, with unit viscosity; `ball`: metal in the middle, off the
 * lattice. */
static scene *box(int n, const double *h, pd_side side, int ball)
{
    scene *s = &test_scene;
    scene_box(s, 1.0, 1.0, n, n, 6);
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h[d];
        s->grid_desc.hi[d] = (d < 2 ? n : 6) * h[d];
        s->shapes[0].a[d] = 0.47 * s->grid_desc.hi[d];
    }
    for (int k = 0; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = side;
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].radius = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].radius = fmin(s->shapes[0].radius, 0.3 * s->grid_desc.hi[d]);
    s->grid_desc.solid = ball ? &s->shapes[0] : NULL;
    s->with = WITH_FLOW;
    s->fields = 4;
    s->flow_desc.rho = s->flow_desc.mu = s->flow_desc.report_speed = s->flow_desc.report_length = 1.0;
    return s;
}

/* lap = L u of the velocity in s->flow.u: half the difference of the residuals of -u and u: convection is even. */
static void friction(scene *s, double *lap)
{
    double *back = s->field[2], *rc = s->field[3];
    s->flow.isotropic_blending = 1.0;
    pdi_flow_assemble_residual(&s->ctx, &s->flow, lap, rc);
    for (int64_t i = 0; i < s->size; i++) s->flow.u[i] = -s->flow.u[i];
    pdi_flow_assemble_residual(&s->ctx, &s->flow, back, rc);
    for (int64_t i = 0; i < s->size; i++) {
        s->flow.u[i] = -s->flow.u[i];
        lap[i] = 0.5 * (back[i] - lap[i]);
    }
}

static void noise(const scene *s, uint32_t seed, double *v)
{
    for (int64_t i = 0; i < s->size; i++)
        v[i] = s->grid.kind[i % s->grid.total] == PD_FLUID ? random_real(&seed) : 0.0;
}

/* Over the fluid. */
static double product(const scene *s, const double *a, const double *b)
{
    double sum = 0.0;
    for (int64_t i = 0; i < s->size; i++)
        if (s->grid.kind[i % s->grid.total] == PD_FLUID) sum += a[i] * b[i];
    return sum;
}

/* All components of the velocity become f. */
static void fill(scene *s, double (*f)(const double *x))
{
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        for (int d = 0; d < PD_DIM; d++) s->flow.u[(int64_t)d * s->grid.total + i] = f(x);
    }
}

/* The Laplacian of both is 0 and 1. */
static double harmonic(const double *x)
{
    double a = x[0] * x[0], b = x[PD_DIM - 1] * x[PD_DIM - 1];
    return a * a - 6.0 * a * b + b * b;
}
static double driven(const double *x) { return harmonic(x) + 0.5 * x[1] * x[1]; }

/* Largest error of L u at whole families, over the sum of the sizes of the terms of L u. */
static double error(scene *s, double (*f)(const double *x), double wanted)
{
    double worst = 0.0;
    fill(s, f);
    friction(s, s->field[0]);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double size = 0.0;
        if (s->grid.kind[i] != PD_FLUID || s->bonds.row_of_node[i] >= 0) continue;
        for (int d = 0; d < PD_DIM; d++) size += 8.0 * fabs(s->flow.u[i]) / (s->grid.h[d] * s->grid.h[d]);
        worst = fmax(worst, fabs(s->field[0][i] - wanted) / (size + 1.0));
    }
    return worst;
}

/* Where the Laplacian is constant friction is exact on polynomials of fourth order, at any ratio of spacings. */
TEST(exact)
{
    const double spacings[3][3] = {{0.1, 0.1, 0.1}, {0.1, 0.05, 0.025}, {1.0, 0.1, 0.001}};
    for (int k = 0; k < 3; k++) {
        scene *s = box(10, spacings[k], PD_SIDE_WALL, 0);
        if (scene_build(s)) {
            CHECK_LE(error(s, harmonic, 0.0), 1e-13);
            CHECK_LE(error(s, driven, 1.0), 1e-13);
            memset(&s->flow.isotropic_stencil, 0, sizeof s->flow.isotropic_stencil);
            CHECK_LE(1e-8, error(s, harmonic, 0.0));
        }
        scene_free(s);
    }
}

static double wave_along(const double *x) { return sin(2.0 * acos(-1.0) * x[0]); }
static double wave_across(const double *x) { return sin(2.0 * acos(-1.0) * (x[0] - x[1])); }

/* How far friction of a wave k is from k^2 (1 - h^2 k^2/12), over k^2, n cells a wave. */
static double spread(int n, double (*wave)(const double *x), double k2)
{
    double h[3], off = 1.0;
    for (int d = 0; d < 3; d++) h[d] = 1.0 / n;
    scene *s = box(n, h, PD_SIDE_PERIODIC, 0);
    if (scene_build(s)) {
        fill(s, wave);
        friction(s, s->field[0]);
        off = fabs(-product(s, s->field[0], s->flow.u) / product(s, s->flow.u, s->flow.u) / k2 - 1.0 +
                   h[0] * h[0] * k2 / 12.0);
    }
    scene_free(s);
    return off;
}

/* The error is (h^2/12) lap lap in every direction; what is left is of fourth order. */
TEST(order)
{
    double k2 = 4.0 * acos(-1.0) * acos(-1.0);
    for (int across = 0; across < 2; across++) {
        double coarse = spread(12, across ? wave_across : wave_along, k2 * (1 + across));
        double fine = spread(24, across ? wave_across : wave_along, k2 * (1 + across));
        NOTE("off by %.3g, %.3g", coarse, fine);
        CHECK_LE(3.9, log(coarse / fine) / log(2.0));
        CHECK_LE(fine, 1e-4);
    }
}

/* Friction is symmetric and takes energy, less than without squares and at least a third of that, beside walls and a
 * body, too; squares make no momentum. */
TEST(symmetry)
{
    const double spacings[2][3] = {{0.1, 0.1, 0.1}, {0.1, 0.02, 0.05}};
    for (int k = 0; k < 4; k++) {
        scene *s = box(14, spacings[k / 2], PD_SIDE_WALL, k % 2);
        if (scene_build(s)) {
            double *u = s->flow.u, *lap = s->field[0], *other = s->field[1];
            noise(s, 3, u);
            friction(s, other);
            noise(s, 5, s->field[3]);
            double uv = product(s, other, s->field[3]);
            noise(s, 5, u);
            friction(s, lap);
            double energy = -product(s, lap, u);
            noise(s, 3, s->field[3]);
            CHECK_NEAR(product(s, lap, s->field[3]), uv, 1e-12 * energy);
            memset(&s->flow.isotropic_stencil, 0, sizeof s->flow.isotropic_stencil);
            friction(s, other);
            double before = -product(s, other, u);
            CHECK_LE(energy, before);
            CHECK_LE(before / 3.0, energy);
            for (int d = 0; d < PD_DIM; d++) {
                double made = 0.0, size = 0.0;
                for (int32_t i = 0; i < s->grid.total; i++) {
                    int64_t at = (int64_t)d * s->grid.total + i;
                    made += lap[at] - other[at];
                    size += fabs(lap[at] - other[at]);
                }
                CHECK_LE(0.1 * before / (double)s->size, size);
                CHECK_LE(fabs(made), 1e-12 * size);
            }
        }
        scene_free(s);
    }
}

/* Long families and fourth order have weights of their own. */
TEST(others)
{
    const double h[3] = {0.1, 0.1, 0.1};
    for (int k = 0; k < 3; k++) {
        scene *s = box(10, h, PD_SIDE_WALL, 0);
        if (k == 1) s->stencil_desc.m = 2.0;
        if (k == 2) s->flow_desc.order = 4;
        if (scene_build(s)) CHECK((s->flow.isotropic_stencil.bonds != NULL) == (k == 0));
        scene_free(s);
    }
}

/* Cubics without divergence. */
static void solenoidal(const double *x, double *u)
{
    u[0] = PD_DIM == 3 ? x[0] * x[0] * x[0] : x[0] * x[0] * x[0] + x[0] * x[1] * x[1];
    u[1] = PD_DIM == 3 ? x[1] * x[1] * x[1] : -3.0 * x[0] * x[0] * x[1] - x[1] * x[1] * x[1] / 3.0;
    if (PD_DIM == 3) u[PD_DIM - 1] = -3.0 * (x[0] * x[0] + x[1] * x[1]) * x[PD_DIM - 1];
}

/* 1: node i and all that its bonds lead to have whole families. */
static int inside(const scene *s, int32_t i)
{
    if (s->grid.kind[i] != PD_FLUID || s->bonds.row_of_node[i] >= 0) return 0;
    for (int k = 0; k < s->stencil.count; k++)
        if (s->bonds.row_of_node[i + s->bonds.paths.shift[k]] >= 0) return 0;
    return 1;
}

/* Largest divergence away from rims, over the largest derivative; *count: nodes. */
static double diverged(scene *s, int *count)
{
    double most = 0.0, size = 0.0;
    *count = 0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        solenoidal(x, u);
        for (int d = 0; d < PD_DIM; d++) s->flow.u[(int64_t)d * s->grid.total + i] = u[d];
        size = fmax(size, 3.0 * (x[0] * x[0] + x[1] * x[1]));
    }
    pdi_flow_assemble_residual(&s->ctx, &s->flow, s->field[0], s->field[1]);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (!inside(s, i)) continue;
        most = fmax(most, fabs(s->field[1][i]));
        ++*count;
    }
    return most / size;
}

/* Beside a ball the divergence of a cubic without one is zero in whole families; in the plane at any spacings. */
TEST(divergence)
{
    const double spacings[2][3] = {{0.1, 0.1, 0.1}, {0.1, 0.06, 0.06}};
    for (int k = 0; k < (PD_DIM == 2 ? 2 : 1); k++) {
        scene *s = box(PD_DIM == 2 ? 20 : 12, spacings[k], PD_SIDE_WALL, 1);
        if (PD_DIM == 3) {
            s->grid_desc.hi[PD_DIM - 1] = s->grid_desc.hi[0];
            s->shapes[0].a[PD_DIM - 1] = s->shapes[0].a[0];
        }
        if (scene_build(s) && CHECK_OK(&s->ctx, pdi_flow_find_surface_patches(&s->ctx, &s->flow))) {
            int count;
            CHECK(s->flow.uses_axis_divergence);
            CHECK_LE(diverged(s, &count), 1e-13);
            CHECK_LE(10, count);
            for (int d = 0; d < PD_DIM; d++) s->flow.isotropic_stencil.third_moment[d] = 0.0;
            CHECK_LE(1e-4, diverged(s, &count));
        }
        scene_free(s);
    }
}

#if PD_DIM == 2
/* Cubics that vanish on the ball: u_d = (r^2 - R^2) (1 + x_d + x_0/2). */
static double past_ball(const scene *s, const double *x, int d, double *slope)
{
    double r2 = -s->shapes[0].radius * s->shapes[0].radius, factor = 1.0 + x[d] + 0.5 * x[0];
    for (int b = 0; b < PD_DIM; b++) r2 += (x[b] - s->shapes[0].a[b]) * (x[b] - s->shapes[0].a[b]);
    *slope = 2.0 * (x[d] - s->shapes[0].a[d]) * factor + r2 * (d ? 1.0 : 1.5);
    return r2 * factor;
}

/* Where the ball cuts one neighbour along an axis, and the node behind the other is open, derivatives of such cubics
 * are exact, from both sides of the ball. */
TEST(slopes)
{
    const double spacing[3] = {0.1, 0.1, 0.1};
    scene *s = box(20, spacing, PD_SIDE_WALL, 1);
    int32_t count = 0, low = 0;
    if (scene_build(s)) {
        double x[PD_DIM], slope;
        for (int32_t i = 0; i < s->grid.total; i++) {
            if (s->grid.kind[i] != PD_FLUID) continue;
            pd_grid_position(&s->grid, i, x);
            for (int d = 0; d < PD_DIM; d++)
                s->flow.u[(int64_t)d * s->grid.total + i] = past_ball(s, x, d, &slope);
        }
        for (int32_t r = 0; r < s->bonds.rows; r++)
            for (int d = 0; d < PD_DIM && s->bonds.near_smooth_surface[r]; d++) {
                const double *leg = s->bonds.neighbour_distance + ((int64_t)r * PD_DIM + d) * 2;
                pdi_isotropic_stencil_place place = {&s->bonds, r, NULL, NULL};
                int away = leg[1] > 0.0 ? 1 : -1;
                if ((leg[0] > 0.0) == (leg[1] > 0.0)) continue;
                if (s->grid.kind[s->bonds.node[r] + 2 * away * s->grid.stride[d]] != PD_FLUID) continue;
                pd_grid_position(&s->grid, s->bonds.node[r], x);
                past_ball(s, x, d, &slope);
                CHECK_NEAR(pdi_isotropic_stencil_compute_derivative(&place, d, s->flow.u), slope, 1e-9);
                count++;
                low += away < 0;
            }
        CHECK_LE(8, count);
        CHECK_LE(4, low);
        CHECK_LE(4, count - low);
    }
    scene_free(s);
}

TEST_MAIN(ENTRY(exact) ENTRY(order) ENTRY(symmetry) ENTRY(others) ENTRY(divergence) ENTRY(slopes))
#else
TEST_MAIN(ENTRY(exact) ENTRY(order) ENTRY(symmetry) ENTRY(others) ENTRY(divergence))
#endif
