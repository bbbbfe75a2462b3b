/* op: exactness, conservation, symmetry, maximum principle, both paths, threads, units.
 * dims: 1 2 3 */
#include "lattice/op.h"
#include "fixture.h"
#include <stdlib.h>

static scene test_scene;
enum { A, B, C, D }; /* fields */

typedef enum body { BODY_NONE, BODY_BALL, BODY_VOXELS } body;

/* A box around the origin, spacing h (1 + d/2) of axis d: walls all round, or (ports) an inlet at x- and an outlet at
 * x+. Solid: a ball off the centre, or scattered nodes. */
static int box_build(scene *s, double m, double h, int x, int y, int z, body what, int ports)
{
    int n[3], cells = 1;
    uint32_t state = 5;
    uint8_t *mask = NULL;
    n[0] = x;
    n[1] = y;
    n[2] = z;
    scene_box(s, m, h, x, y, z);
    s->fields = 4;
    if (what != BODY_NONE) s->grid_desc.solid = &s->shapes[0];
    if (ports) {
        s->grid_desc.side[0] = PD_SIDE_INLET;
        s->grid_desc.side[1] = PD_SIDE_OUTLET;
    }
    pd_shape *shape = &s->shapes[0];
    shape->type = what == BODY_BALL ? PD_SHAPE_BALL : PD_SHAPE_VOXELS;
    shape->radius = 2.3 * h;
    for (int d = 0; d < PD_DIM; d++) {
        double step = s->stencil_desc.h[d] = h * (1.0 + 0.5 * d);
        cells *= n[d];
        s->grid_desc.lo[d] = -0.5 * n[d] * step;
        s->grid_desc.hi[d] = 0.5 * n[d] * step;
        shape->a[d] = what == BODY_BALL ? 0.375 * h : s->grid_desc.lo[d];
        shape->b[d] = step;
        shape->mask_size[d] = n[d];
    }
    if (what == BODY_VOXELS) {
        mask = (uint8_t *)calloc((size_t)cells, 1);
        if (!CHECK(mask != NULL)) return 0;
        for (int k = 0; k < cells; k++) mask[k] = next_random(&state) % 200 == 0;
        mask[cells / 2] = 1;
        shape->mask = mask;
    }
    int good = scene_build(s);
    free(mask);
    return good;
}

/* Random in [-1, 1] where fields have values, and a poison where no operator may look. */
static void fill_random(const scene *s, uint32_t seed, double *f)
{
    for (int64_t k = 0; k < s->size; k++) {
        double value = random_real(&seed);
        f[k] = pdi_grid_is_open(s->grid.kind[k % s->grid.total]) ? value : (double)NAN;
    }
}

static int is_fluid(const scene *s, int32_t node) { return s->grid.kind[node] == PD_FLUID; }

/* Sums over fluid nodes of x and |x|; of x y. */
static double fluid_sum(const scene *s, const double *x, double *size)
{
    double sum = 0.0;
    *size = 0.0;
    for (int32_t node = 0; node < s->grid.total; node++) {
        if (!is_fluid(s, node)) continue;
        sum += x[node];
        *size += fabs(x[node]);
    }
    return sum;
}

static double fluid_dot(const scene *s, const double *x, const double *y)
{
    double sum = 0.0;
    for (int32_t node = 0; node < s->grid.total; node++)
        if (is_fluid(s, node)) sum += x[node] * y[node];
    return sum;
}

/* ---- exactness ---- */

/* Linear fields at every node, cut or not, also in corners. Inlet ghosts carry no scalar: they must not be read. */
TEST(gradient_of_linear_fields)
{
    scene *s = &test_scene;
    for (int m = 1; m <= 3; m++)
        for (int ports = 0; ports < 2; ports++) {
            if (!box_build(s, m, 0.01, PD_DIM == 1 ? 30 : 15, 14, 13, BODY_BALL, ports)) return;
            int32_t total = s->grid.total, cut = 0;
            for (int32_t node = 0; node < total; node++) {
                double x[PD_DIM];
                pd_grid_position(&s->grid, node, x);
                s->field[A][node] = 3.0;
                for (int d = 0; d < PD_DIM; d++) s->field[A][node] += (d + 1.5) * x[d];
                if (!pdi_grid_is_open(s->grid.kind[node]) || s->grid.kind[node] == PD_INLET)
                    s->field[A][node] = (double)NAN;
            }
            pd_op_gradient(&s->ctx, &s->bonds, s->field[A], s->field[B]);
            for (int32_t node = 0; node < total; node++) {
                if (!is_fluid(s, node)) continue;
                cut += s->bonds.row_of_node[node] >= 0;
                for (int d = 0; d < PD_DIM; d++) CHECK_REL(s->field[B][(int64_t)d * total + node], d + 1.5, 1e-11);
            }
            CHECK(cut > 0 && s->bonds.full_ranges.count > 0);
            scene_free(s);
        }
}

/* A general cubic of the coordinates over h: value, and derivatives by hand. */
static const double cubic_1[3] = {0.7, -1.1, 0.4};
static const double cubic_2[3][3] = {{0.6, 0.9, -0.3}, {0.9, -0.8, 0.5}, {-0.3, 0.5, 1.2}};
static const double cubic_3[3] = {0.21, -0.17, 0.13};

static double cubic(const double *y, double with_cubes)
{
    double sum = 2.0;
    for (int a = 0; a < PD_DIM; a++) {
        sum += cubic_1[a] * y[a] + with_cubes * cubic_3[a] * y[a] * y[a] * y[(a + 1) % PD_DIM];
        for (int b = 0; b < PD_DIM; b++) sum += 0.5 * cubic_2[a][b] * y[a] * y[b];
    }
    return sum;
}

/* At whole families: gradient and divergence of quadratics, Laplacian and constant diffusion of cubics. */
TEST(polynomials_inside)
{
    scene *s = &test_scene;
    const double h = 0.01, diffusivity = 3e-9;
    if (!box_build(s, 3.0, h, 24, 18, 12, BODY_BALL, 0)) return;
    int32_t total = s->grid.total;
    int checked = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int32_t node = 0; node < total; node++) {
            double y[PD_DIM];
            pd_grid_position(&s->grid, node, y);
            for (int d = 0; d < PD_DIM; d++) y[d] /= h;
            for (int d = 0; d < PD_DIM; d++) s->field[A][(int64_t)d * total + node] = (d + 1.0) * cubic(y, pass);
            s->field[D][node] = diffusivity;
        }
        if (pass) pd_op_laplacian(&s->ctx, &s->bonds, s->field[A], s->field[B]);
        else pd_op_gradient(&s->ctx, &s->bonds, s->field[A], s->field[B]);
        if (pass) CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->field[D], s->field[A], s->field[C]));
        else pd_op_divergence(&s->ctx, &s->bonds, s->field[A], s->field[C]);
        for (int32_t node = 0; node < total; node++) {
            double y[PD_DIM], div = 0.0, lap = 0.0;
            if (!is_fluid(s, node) || s->bonds.row_of_node[node] >= 0) continue;
            pd_grid_position(&s->grid, node, y);
            for (int d = 0; d < PD_DIM; d++) y[d] /= h;
            for (int a = 0; a < PD_DIM; a++) {
                double slope = cubic_1[a];
                for (int b = 0; b < PD_DIM; b++) slope += cubic_2[a][b] * y[b];
                div += (a + 1.0) * slope;
                lap += cubic_2[a][a] + cubic_3[a] * (PD_DIM == 1 ? 6.0 : 2.0) * y[(a + 1) % PD_DIM];
                if (pass == 0) CHECK_NEAR(s->field[B][(int64_t)a * total + node], slope / h, 1e-11 / h);
            }
            if (pass == 0) CHECK_NEAR(s->field[C][node], div / h, 4e-11 / h);
            else CHECK_NEAR(s->field[B][node], lap / (h * h), 1e-10 / (h * h));
            if (pass) CHECK_NEAR(s->field[C][node], diffusivity * lap / (h * h), diffusivity * 1e-10 / (h * h));
            checked++;
        }
    }
    CHECK(checked > 10);
    scene_free(s);
}

/* Steady diffusion through two materials that meet halfway between layers: piecewise linear with D f' constant. */
TEST(diffusion_in_series)
{
    scene *s = &test_scene;
    const double left = 4e-9, right = 4e-17, h = 0.01;
    if (!box_build(s, 1.0, h, 12, 9, 8, BODY_NONE, 0)) return;
    for (int32_t node = 0; node < s->grid.total; node++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, node, x);
        s->field[D][node] = x[0] < 0.0 ? left : right;
        s->field[A][node] = x[0] / s->field[D][node];
    }
    CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->field[D], s->field[A], s->field[B]));
    for (int32_t node = 0; node < s->grid.total; node++) {
        int i[PD_DIM];
        pd_grid_index(&s->grid, node, i);
        if (is_fluid(s, node) && i[0] > 0 && i[0] < 11) CHECK_LE(fabs(s->field[B][node]) * h, 1e-11);
    }
    scene_free(s);
}

#if PD_DIM == 1
/* Uniform inflow into a tube that is closed at its end piles up at the rate of the inflow. */
TEST(inflow_is_the_sum_of_the_divergence)
{
    scene *s = &test_scene;
    double size;
    if (!box_build(s, 3.0, 0.01, 20, 1, 1, BODY_NONE, 1)) return;
    for (int32_t node = 0; node < s->grid.total; node++) s->field[A][node] = 0.7;
    pd_op_divergence(&s->ctx, &s->bonds, s->field[A], s->field[B]);
    fluid_sum(s, s->field[B], &size);
    CHECK_LE(size, 1e-13 * 0.7 / 0.01);
    for (int32_t node = 0; node < s->grid.total; node++)
        if (s->grid.kind[node] == PD_OUTLET) s->field[A][node] = -0.7;  /* odd: nothing leaves on the face */
    pd_op_divergence(&s->ctx, &s->bonds, s->field[A], s->field[B]);
    double inflow = 0.0;
    for (int32_t node = 0; node < s->grid.total; node++)
        if (is_fluid(s, node)) inflow -= s->field[B][node] * s->stencil.volume;
    CHECK_REL(inflow, 0.7, 1e-12);
    scene_free(s);
}
#endif

/* ---- structure ---- */

/* One of the operators by number, from f into out. */
static void apply(scene *s, int which, const pd_bonds *bonds, const double *f, double *out)
{
    if (which == 0) pd_op_gradient(&s->ctx, bonds, f, out);
    if (which == 1) pd_op_divergence(&s->ctx, bonds, f, out);
    if (which == 2) pd_op_laplacian(&s->ctx, bonds, f, out);
    if (which == 3) CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, bonds, s->field[D], f, out));
}

/* Diffusivities over eight orders of magnitude. */
static void fill_diffusivity(scene *s, uint32_t seed)
{
    for (int32_t node = 0; node < s->grid.total; node++)
        s->field[D][node] = pow(10.0, -12.0 + 4.0 * random_real(&seed));
}

/* Rows for all nodes give what the shared stencil gives; nothing but fluid nodes is written. */
TEST(paths_agree)
{
    scene *s = &test_scene;
    for (int m = 1; m <= 3; m++)
        for (int which = 0; which < 4; which++) {
            pd_bonds rows;
            if (!box_build(s, m, 0.01, 22, 16, 12, BODY_BALL, 1)) return;
            if (!CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 1, &rows))) return;
            CHECK(rows.full_ranges.count == 0 && s->bonds.full_ranges.count > 0);
            fill_random(s, 17, s->field[A]);
            fill_diffusivity(s, 3);
            for (int64_t k = 0; k < s->size; k++) s->field[B][k] = s->field[C][k] = -77.0;
            apply(s, which, &s->bonds, s->field[A], s->field[B]);
            apply(s, which, &rows, s->field[A], s->field[C]);
            double largest = 0.0;
            int64_t used = which == 0 ? s->size : s->grid.total;
            for (int64_t k = 0; k < used; k++)
                if (is_fluid(s, (int32_t)(k % s->grid.total))) largest = fmax(largest, fabs(s->field[B][k]));
            for (int64_t k = 0; k < s->size; k++) {
                if (k < used && is_fluid(s, (int32_t)(k % s->grid.total)))
                    CHECK_NEAR(s->field[B][k], s->field[C][k], 1e-14 * largest);
                else CHECK(s->field[B][k] == -77.0 && s->field[C][k] == -77.0);
            }
            pd_bonds_free(&s->ctx, &rows);
            scene_free(s);
        }
}

/* A closed box with scattered solid: nothing is lost, <Lu, v> = <u, Lv>, <Lu, u> <= 0. */
TEST(conservation_and_symmetry)
{
    scene *s = &test_scene;
    for (int which = 1; which < 4; which++)
        for (int m = 1; m <= 3; m++) {
            double size, error;
            if (!box_build(s, m, 0.01, 30, 20, 12, BODY_VOXELS, 0)) return;
            CHECK(s->bonds.full_ranges.count > 0 && s->bonds.rows > 0);
            fill_random(s, 23, s->field[A]);
            fill_diffusivity(s, 29);
            apply(s, which, &s->bonds, s->field[A], s->field[B]);
            error = fluid_sum(s, s->field[B], &size);
            CHECK_LE(fabs(error), 1e-14 * size);
            if (which > 1) {
                fill_random(s, 31, s->field[C]);
                double left = fluid_dot(s, s->field[B], s->field[C]);
                CHECK(fluid_dot(s, s->field[B], s->field[A]) < 0.0);
                apply(s, which, &s->bonds, s->field[C], s->field[B]);
                CHECK_NEAR(left, fluid_dot(s, s->field[B], s->field[A]), 1e-13 * size);
                for (int64_t k = 0; k < s->size; k++) s->field[C][k] = 0.1;
                apply(s, which, &s->bonds, s->field[C], s->field[B]);
                fluid_sum(s, s->field[B], &size);
                CHECK_NEAR(size, 0.0, 0.0); /* constants lie in the null space bit for bit */
            }
            scene_free(s);
        }
}

/* An explicit step of 1 / (sum of weights) stays within the old bounds, and the extremes move inwards. */
TEST(maximum_principle)
{
    scene *s = &test_scene;
    for (int which = 2; which < 4; which++) {
        double weights = 0.0, lo = 1.0, hi = -1.0;
        int32_t lowest = 0, highest = 0;
        if (!box_build(s, 3.0, 0.01, 30, 20, 12, BODY_VOXELS, 0)) return;
        fill_random(s, 37, s->field[A]);
        fill_diffusivity(s, 41);
        apply(s, which, &s->bonds, s->field[A], s->field[B]);
        for (int k = 0; k < s->stencil.count; k++) weights += s->stencil.laplacian_weight[k];
        double dt = 1.0 / (weights * (which == 3 ? 1e-8 : 1.0)); /* no diffusivity above 1e-8 */
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (!is_fluid(s, node)) continue;
            if (s->field[A][node] < lo) lo = s->field[A][lowest = node];
            if (s->field[A][node] > hi) hi = s->field[A][highest = node];
        }
        CHECK(s->field[B][lowest] > 0.0 && s->field[B][highest] < 0.0);
        for (int32_t node = 0; node < s->grid.total; node++) {
            if (!is_fluid(s, node)) continue;
            double fresh = s->field[A][node] + dt * s->field[B][node];
            CHECK(fresh >= lo - 1e-14 && fresh <= hi + 1e-14);
        }
        scene_free(s);
    }
}

TEST(diffusivity_is_checked)
{
    scene *s = &test_scene;
    static const double wrong[] = {-1e-9, (double)NAN, (double)INFINITY};
    if (!box_build(s, 3.0, 0.01, 20, 12, 8, BODY_BALL, 1)) return;
    fill_random(s, 43, s->field[A]);
    for (int32_t node = 0; node < s->grid.total; node++)
        s->field[D][node] = pdi_grid_is_open(s->grid.kind[node]) ? 1e-9 : NAN;
    CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->field[D], s->field[A], s->field[B]));
    int32_t node = s->bonds.node[0];
    for (int k = 0; k < 3; k++) {
        s->field[D][node] = wrong[k];
        CHECK_INT(pd_op_diffusion(&s->ctx, &s->bonds, s->field[D], s->field[A], s->field[B]), PD_ERR_ARGUMENT);
        CHECK(strncmp(s->ctx.message, "op: ", 4) == 0);
    }
    s->field[D][node] = 0.0; /* an insulator */
    CHECK_OK(&s->ctx, pd_op_diffusion(&s->ctx, &s->bonds, s->field[D], s->field[A], s->field[B]));
    CHECK_NEAR(s->field[B][node], 0.0, 0.0);
    scene_free(s);
}

/* ---- bits ---- */

TEST(threads_change_no_bit)
{
    scene *s = &test_scene;
    int x = PD_DIM == 1 ? 4000 : PD_DIM == 2 ? 70 : 24, y = PD_DIM == 3 ? 20 : 60;
    if (!box_build(s, 3.0, 0.01, x, y, 18, BODY_VOXELS, 1)) return;
    fill_random(s, 47, s->field[A]);
    fill_diffusivity(s, 53);
    for (int which = 0; which < 4; which++)
        for (int threads = 2; threads <= 4; threads *= 2) {
            memset(s->field[B], 0, (size_t)s->size * sizeof *s->field[B]);
            memset(s->field[C], 0, (size_t)s->size * sizeof *s->field[C]);
            s->ctx.threads = 1;
            apply(s, which, &s->bonds, s->field[A], s->field[B]);
            s->ctx.threads = threads;
            apply(s, which, &s->bonds, s->field[A], s->field[C]);
            CHECK(memcmp(s->field[B], s->field[C], (size_t)s->size * sizeof *s->field[B]) == 0);
        }
    scene_free(s);
}

/* Lengths times a power of two: results follow bit for bit, wall coefficients too. */
TEST(unit_covariance)
{
    static scene other;
    scene *s = &test_scene;
    const double factor = ldexp(1.0, -21);
    for (int which = 0; which < 4; which++) {
        if (!box_build(s, 3.0, 1.0, 20, 15, 12, BODY_BALL, 1)) return;
        if (!box_build(&other, 3.0, factor, 20, 15, 12, BODY_BALL, 1)) return;
        double back = which < 2 ? factor : factor * factor;
        fill_random(s, 59, s->field[A]);
        fill_diffusivity(s, 61);
        fill_diffusivity(&other, 61);
        apply(s, which, &s->bonds, s->field[A], s->field[B]);
        apply(&other, which, &other.bonds, s->field[A], other.field[B]);
        int64_t used = which == 0 ? s->size : s->grid.total;
        for (int64_t k = 0; k < used; k++)
            if (is_fluid(s, (int32_t)(k % s->grid.total))) CHECK(other.field[B][k] * back == s->field[B][k]);
        CHECK_INT(s->bonds.rows, other.bonds.rows);
        for (int32_t r = 0; r < s->bonds.rows; r++) {
            CHECK(other.bonds.wall_laplacian[r] * factor * factor == s->bonds.wall_laplacian[r]);
            CHECK(other.bonds.wall_curvature[r] == s->bonds.wall_curvature[r]);
        }
        scene_free(s);
        scene_free(&other);
    }
}

#if PD_DIM == 1
#define OF_DIM ENTRY(inflow_is_the_sum_of_the_divergence)
#else
#define OF_DIM
#endif

TEST_MAIN(ENTRY(gradient_of_linear_fields) ENTRY(polynomials_inside) ENTRY(diffusion_in_series) OF_DIM
              ENTRY(paths_agree) ENTRY(conservation_and_symmetry) ENTRY(maximum_principle)
                  ENTRY(diffusivity_is_checked) ENTRY(threads_change_no_bit) ENTRY(unit_covariance))
