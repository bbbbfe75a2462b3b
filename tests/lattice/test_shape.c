/* shape: signed distances and set operations.
 * dims: 1 2 3 */
#include "core/rng.h"
#include "lattice/shape.h"
#include "test.h"

static pd_shape none(void)
{
    pd_shape s;
    memset(&s, 0, sizeof s);
    return s;
}

/* The first PD_DIM of three coordinates. */
static void put(double *to, double x, double y, double z)
{
    double all[3];
    all[0] = x;
    all[1] = y;
    all[2] = z;
    for (int d = 0; d < PD_DIM; d++) to[d] = all[d];
}

static pd_shape box(double lo, double hi)
{
    pd_shape s = none();
    s.type = PD_SHAPE_BOX;
    put(s.a, lo, lo, lo);
    put(s.b, hi, hi + 1.0, hi + 2.0);
    return s;
}

static pd_shape ball(double x, double y, double z, double r)
{
    pd_shape s = none();
    s.type = PD_SHAPE_BALL;
    put(s.a, x, y, z);
    s.radius = r;
    return s;
}

static pd_shape cylinder(int axis, double x, double y, double z, double r)
{
    pd_shape s = ball(x, y, z, r);
    s.type = PD_SHAPE_CYLINDER;
    s.axis = axis;
    return s;
}

static pd_shape half_space(double x, double y, double z, double nx, double ny, double nz)
{
    pd_shape s = none();
    s.type = PD_SHAPE_HALF_SPACE;
    put(s.a, x, y, z);
    put(s.b, nx, ny, nz);
    return s;
}

static pd_shape operation(pd_shape_type type, int first, int second, int third)
{
    pd_shape s = none();
    s.type = type;
    s.child[0] = first;
    s.child[1] = second;
    s.child[2] = third;
    s.child_count = third >= 0 ? 3 : second >= 0 ? 2 : 1;
    return s;
}

/* A plus sign (a bar in 1D) of cells in a 5^d mask. */
static uint8_t test_mask[125];
static pd_shape voxels(void)
{
    pd_shape s = none();
    int total = 1;
    s.type = PD_SHAPE_VOXELS;
    put(s.a, -2.0, -1.0, 0.5);
    put(s.b, 0.5, 0.75, 1.0);
    for (int d = 0; d < PD_DIM; d++) {
        s.mask_size[d] = 5;
        total *= 5;
    }
    for (int k = 0; k < total; k++) {
        int i[3], centred = 0;
        i[0] = k % 5;
        i[1] = k / 5 % 5;
        i[2] = k / 25;
        for (int d = 0; d < PD_DIM; d++) centred += i[d] == 2;
        test_mask[k] = PD_DIM == 1 ? i[0] == 1 || i[0] == 2 : centred >= PD_DIM - 1;
    }
    s.mask = test_mask;
    return s;
}

static void random_point(uint64_t k, double half, double *x)
{
    for (int d = 0; d < PD_DIM; d++) x[d] = half * (2.0 * pdi_rng_uniform(1, (uint64_t)d, k) - 1.0);
}

static double distance_at(const pd_shape *s, double x, double y, double z)
{
    double p[PD_DIM];
    put(p, x, y, z);
    return pd_shape_distance(s, 0, p);
}

TEST(box_closed_form)
{
    pd_shape s = box(-1.0, 2.0); /* -1..2, -1..3, -1..4 */
    CHECK_NEAR(distance_at(&s, 0.0, 1.0, 1.0), -1.0, 1e-15);
    CHECK_NEAR(distance_at(&s, 1.75, 1.0, 1.0), -0.25, 1e-15);
    CHECK_NEAR(distance_at(&s, 5.0, 1.0, 1.0), 3.0, 1e-15);
    CHECK_NEAR(distance_at(&s, -4.0, 1.0, 1.0), 3.0, 1e-15);
#if PD_DIM >= 2
    CHECK_NEAR(distance_at(&s, 5.0, 7.0, 1.0), 5.0, 1e-15);
    CHECK_NEAR(distance_at(&s, 0.5, 2.9, 1.0), -0.1, 1e-14);
#endif
#if PD_DIM == 3
    CHECK_NEAR(distance_at(&s, 4.0, 6.0, 10.0), 7.0, 1e-15);
#endif
    /* outside: distance to the closest point of the box; inside: to the closest of the 2d faces */
    for (uint64_t k = 0; k < 2000; k++) {
        double x[PD_DIM], square = 0.0, depth = 1e9;
        random_point(k, 6.0, x);
        for (int d = 0; d < PD_DIM; d++) {
            double closest = x[d] < s.a[d] ? s.a[d] : x[d] > s.b[d] ? s.b[d] : x[d];
            square += (x[d] - closest) * (x[d] - closest);
            depth = fmin(depth, fmin(x[d] - s.a[d], s.b[d] - x[d]));
        }
        CHECK_NEAR(pd_shape_distance(&s, 0, x), square > 0.0 ? sqrt(square) : -depth, 1e-14);
    }
}

TEST(round_closed_form)
{
    pd_shape s = ball(1.0, 2.0, 3.0, 0.5);
    for (uint64_t k = 0; k < 1000; k++) {
        double x[PD_DIM], direction[PD_DIM], norm = 0.0, r = 0.01 + 3.0 * pdi_rng_uniform(2, 9, k);
        random_point(k, 1.0, direction);
        for (int d = 0; d < PD_DIM; d++) norm += direction[d] * direction[d];
        for (int d = 0; d < PD_DIM; d++) x[d] = s.a[d] + r * direction[d] / sqrt(norm);
        CHECK_NEAR(pd_shape_distance(&s, 0, x), r - 0.5, 1e-13);
    }
    s = cylinder(0, 1.0, 2.0, 3.0, 0.5);
#if PD_DIM == 1
    for (s.axis = 0; s.axis < 3; s.axis++) {
        CHECK_NEAR(distance_at(&s, 1.2, 0.0, 0.0), -0.3, 1e-15);
        CHECK_NEAR(distance_at(&s, -1.0, 0.0, 0.0), 1.5, 1e-15);
    }
#elif PD_DIM == 2
    CHECK_NEAR(distance_at(&s, 77.0, 2.25, 0.0), -0.25, 1e-15);
    CHECK_NEAR(distance_at(&s, -77.0, 4.0, 0.0), 1.5, 1e-15);
    s.axis = 1;
    CHECK_NEAR(distance_at(&s, 1.25, 77.0, 0.0), -0.25, 1e-15);
    CHECK_NEAR(distance_at(&s, 4.0, 2.0, 0.0), 2.5, 1e-15);
    s.axis = 2;
    CHECK_NEAR(distance_at(&s, 4.0, 6.0, 0.0), 4.5, 1e-15);
#else
    CHECK_NEAR(distance_at(&s, 77.0, 5.0, 7.0), 4.5, 1e-15);
    s.axis = 1;
    CHECK_NEAR(distance_at(&s, 4.0, 77.0, 7.0), 4.5, 1e-15);
    s.axis = 2;
    CHECK_NEAR(distance_at(&s, 4.0, 6.0, 77.0), 4.5, 1e-15);
#endif
}

TEST(half_space_closed_form)
{
    pd_shape s = half_space(1.0, 0.0, 0.0, 4.0, 0.0, 0.0);
    CHECK_NEAR(distance_at(&s, -2.0, 5.0, 6.0), -3.0, 1e-15);
    CHECK_NEAR(distance_at(&s, 3.5, 5.0, 6.0), 2.5, 1e-15);
#if PD_DIM >= 2
    s = half_space(0.0, 0.0, 7.0, 3.0, 4.0, 0.0);
    CHECK_NEAR(distance_at(&s, 3.0, 4.0, -9.0), 5.0, 1e-15);
    CHECK_NEAR(distance_at(&s, -4.0, 3.0, 1.0), 0.0, 1e-15);
    /* turning plane and point together changes nothing */
    for (int k = 0; k < 12; k++) {
        double c = cos(0.5 * k), sine = sin(0.5 * k);
        pd_shape turned = half_space(0.0, 0.0, 7.0, 3.0 * c - 4.0 * sine, 3.0 * sine + 4.0 * c, 0.0);
        CHECK_NEAR(distance_at(&turned, 2.0 * c + 1.0 * sine, 2.0 * sine - 1.0 * c, 2.0), 0.4, 1e-14);
    }
#endif
}

static double mask_reference(const pd_shape *s, const double *x, int *inside)
{
    double nearest_full = 1e9, nearest_empty = 1e9;
    int total = 1;
    for (int d = 0; d < PD_DIM; d++) total *= 9;
    for (int k = 0; k < total; k++) {
        int rest = k, in_mask = 1, cell = 0, stride = 1;
        double square = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            int i = rest % 9 - 2;
            rest /= 9;
            double lo = s->a[d] + i * s->b[d];
            double gap = fmax(fmax(lo - x[d], x[d] - lo - s->b[d]), 0.0);
            square += gap * gap;
            if (i < 0 || i >= 5) in_mask = 0;
            cell += i * stride;
            stride *= 5;
        }
        if (in_mask && test_mask[cell]) nearest_full = fmin(nearest_full, sqrt(square));
        else nearest_empty = fmin(nearest_empty, sqrt(square));
    }
    *inside = nearest_full <= 0.0;
    return *inside ? -nearest_empty : nearest_full;
}

/* Against all cells of the mask: the true distance up to one cell edge, a bound of the same sign beyond. */
TEST(voxels_against_all_cells)
{
    pd_shape s = voxels();
    CHECK_INT(pd_shape_is_smooth(&s, 0), 0);
    for (uint64_t k = 0; k < 3000; k++) {
        double x[PD_DIM];
        int inside;
        for (int d = 0; d < PD_DIM; d++) /* within one cell of the mask */
            x[d] = s.a[d] + s.b[d] * (7.0 * pdi_rng_uniform(3, (uint64_t)d, k) - 1.0);
        double expected = mask_reference(&s, x, &inside), value = pd_shape_distance(&s, 0, x);
        if (fabs(expected) <= 0.5) CHECK_NEAR(value, expected, 1e-13);
        CHECK(fabs(value) <= fabs(expected) + 1e-13);
        CHECK(fabs(value) >= fmin(fabs(expected), 0.5) - 1e-13);
        CHECK((value <= 0.0) == inside);
    }
    double far[PD_DIM];
    put(far, 1000.0, 0.0, 1.0);
    double value = pd_shape_distance(&s, 0, far);
    CHECK(value > 990.0 && value <= 1002.0);
}

/* A tree with every type. */
static int sample_tree(pd_shape *s)
{
    s[0] = box(-1.0, 1.5);
    s[1] = ball(0.5, 1.0, 0.5, 1.2);
    s[2] = cylinder(0, 0.3, 0.2, 0.4, 0.7);
    s[3] = half_space(0.5, 0.5, 0.0, 1.0, -2.0, 0.5);
    s[4] = voxels();
    s[5] = operation(PD_SHAPE_UNION, 0, 1, 4);
    s[6] = operation(PD_SHAPE_INTERSECT, 0, 1, 2);
    s[7] = operation(PD_SHAPE_DIFFERENCE, 5, 2, 3);
    s[8] = operation(PD_SHAPE_COMPLEMENT, 7, -1, -1);
    s[9] = operation(PD_SHAPE_UNION, 8, 6, -1);
    return 10;
}

/* |d(x) - d(y)| <= |x - y|, near pairs and far ones. */
TEST(lipschitz)
{
    pd_shape s[10];
    int count = sample_tree(s);
    for (int shape = 0; shape < count; shape++)
        for (uint64_t k = 0; k < 2000; k++) {
            double x[PD_DIM], y[PD_DIM], square = 0.0;
            random_point(2 * k, 3.0, x);
            random_point(2 * k + 1, k % 2 ? 3.0 : 0.05, y);
            for (int d = 0; d < PD_DIM; d++) {
                if (k % 2 == 0) y[d] += x[d];
                square += (x[d] - y[d]) * (x[d] - y[d]);
            }
            double jump = fabs(pd_shape_distance(s, shape, x) - pd_shape_distance(s, shape, y));
            CHECK_LE(jump, sqrt(square) * (1.0 + 1e-12) + 1e-14);
        }
}

TEST(set_operations)
{
    pd_shape s[10];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    int count = sample_tree(s), hits[10] = {0};
    CHECK_OK(&ctx, pd_shape_validate(&ctx, s, count));
    for (uint64_t k = 0; k < 4000; k++) {
        double x[PD_DIM];
        int in[10];
        random_point(k, 3.0, x);
        for (int i = 0; i < count; i++) {
            in[i] = pd_shape_distance(s, i, x) < 0.0;
            hits[i] += in[i];
        }
        CHECK_INT(in[5], in[0] || in[1] || in[4]);
        CHECK_INT(in[6], in[0] && in[1] && in[2]);
        CHECK_INT(in[7], in[5] && !in[2] && !in[3]);
        CHECK_INT(in[8], !in[7]);
        CHECK_INT(in[9], in[8] || in[6]);
    }
    for (int i = 0; i < count; i++) CHECK(hits[i] > 0 && hits[i] < 4000);
    CHECK_INT(pd_shape_is_smooth(s, 6), 1);
    CHECK_INT(pd_shape_is_smooth(s, 5), 0);
    CHECK_INT(pd_shape_is_smooth(s, 9), 0);
}

TEST(translation)
{
    pd_shape s[10], moved[10];
    int count = sample_tree(s);
    memcpy(moved, s, sizeof s);
    double by[PD_DIM];
    put(by, 0.75, -2.5, 4.25);
    for (int i = 0; i < count; i++)
        for (int d = 0; d < PD_DIM; d++) {
            moved[i].a[d] += by[d];
            if (s[i].type == PD_SHAPE_BOX) moved[i].b[d] += by[d];
        }
    for (int i = 0; i < count; i++)
        for (uint64_t k = 0; k < 300; k++) {
            double x[PD_DIM], y[PD_DIM];
            random_point(k, 3.0, x);
            for (int d = 0; d < PD_DIM; d++) y[d] = x[d] + by[d];
            CHECK_NEAR(pd_shape_distance(moved, i, y), pd_shape_distance(s, i, x), 1e-13);
        }
}

/* The deepest chain that fits, and sharing that would unfold without end. */
TEST(nesting)
{
    static pd_shape s[PD_SHAPE_MAX + 1];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    s[0] = ball(0.0, 0.0, 0.0, 1.0);
    for (int k = 1; k <= PD_SHAPE_MAX; k++) s[k] = operation(PD_SHAPE_COMPLEMENT, k - 1, -1, -1);
    CHECK_OK(&ctx, pd_shape_validate(&ctx, s, PD_SHAPE_MAX));
    CHECK_NEAR(distance_at(s, 0.25, 0.0, 0.0), -0.75, 1e-15);
    double x[PD_DIM];
    put(x, 0.25, 0.0, 0.0);
    CHECK_NEAR(pd_shape_distance(s, PD_SHAPE_MAX - 1, x), 0.75, 1e-15);
    CHECK_INT(pd_shape_validate(&ctx, s, PD_SHAPE_MAX + 1), PD_ERR_SIZE);
    CHECK_STR(ctx.message, "shape: 257 shapes, expected at most 256");
    for (int k = 1; k < PD_SHAPE_MAX; k++) s[k] = operation(PD_SHAPE_UNION, k - 1, k - 1, -1);
    CHECK_INT(pd_shape_validate(&ctx, s, PD_SHAPE_MAX), PD_ERR_SIZE);
    CHECK_OK(&ctx, pd_shape_validate(&ctx, s, 11));
}

static void refuse(pd_shape bad, const char *message)
{
    pd_shape s[2];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    s[0] = ball(0.0, 0.0, 0.0, 1.0);
    s[1] = bad;
    CHECK_INT(pd_shape_validate(&ctx, s, 2), PD_ERR_ARGUMENT);
    CHECK_STR(ctx.message, message);
}

TEST(refusals)
{
    pd_shape s = none();
    refuse(s, "shape: shape 1 has type 0, which is none");
    s.type = (pd_shape_type)99;
    refuse(s, "shape: shape 1 has type 99, which is none");
    s = box(1.0, 2.0);
    s.b[0] = 1.0;
    refuse(s, "shape: shape 1 (box) goes from 1 m to 1 m on axis 0, expected a < b");
    s.b[0] = HUGE_VAL;
    refuse(s, "shape: shape 1 (box) goes from 1 m to inf m on axis 0, expected a < b");
    refuse(ball(0.0, 0.0, 0.0, 0.0), "shape: shape 1 (ball) has radius r = 0 m, expected > 0");
    refuse(ball(0.0, 0.0, 0.0, -2.0), "shape: shape 1 (ball) has radius r = -2 m, expected > 0");
    refuse(ball(HUGE_VAL, 0.0, 0.0, 1.0), "shape: shape 1 (ball) has point a = inf m on axis 0, expected a finite one");
    refuse(cylinder(3, 0.0, 0.0, 0.0, 1.0), "shape: shape 1 (cylinder) has axis 3, expected 0, 1 or 2");
    refuse(half_space(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
           "shape: shape 1 (half-space) has a normal b of length 0, expected a finite one > 0");
    s = voxels();
    s.mask = NULL;
    refuse(s, "shape: shape 1 (voxels) has no mask");
    s = voxels();
    s.mask_size[0] = 0;
    refuse(s, "shape: shape 1 (voxels) has n = 0 cells on axis 0, expected at least 1");
    s = voxels();
    s.b[0] = -1.0;
    refuse(s, "shape: shape 1 (voxels) has spacing b = -1 m on axis 0, expected > 0");
    refuse(operation(PD_SHAPE_UNION, 0, 1, -1),
           "shape: shape 1 (union) has child 1, expected the index of an earlier shape");
    refuse(operation(PD_SHAPE_INTERSECT, -1, 0, -1),
           "shape: shape 1 (intersection) has child -1, expected the index of an earlier shape");
    refuse(operation(PD_SHAPE_DIFFERENCE, 0, -1, -1), "shape: shape 1 (difference) has 1 children, expected 2 to 8");
    refuse(operation(PD_SHAPE_COMPLEMENT, 0, 0, -1), "shape: shape 1 (complement) has 2 children, expected 1 to 1");
    s = operation(PD_SHAPE_UNION, 0, 0, 0);
    s.child_count = 9;
    refuse(s, "shape: shape 1 (union) has 9 children, expected 1 to 8");
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    CHECK_INT(pd_shape_validate(&ctx, NULL, 1), PD_ERR_ARGUMENT);
    CHECK_OK(&ctx, pd_shape_validate(&ctx, NULL, 0));
}

TEST_MAIN(ENTRY(box_closed_form) ENTRY(round_closed_form) ENTRY(half_space_closed_form)
          ENTRY(voxels_against_all_cells) ENTRY(lipschitz) ENTRY(set_operations) ENTRY(translation) ENTRY(nesting)
          ENTRY(refusals))
