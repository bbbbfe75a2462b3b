/* stencil: family sizes, patch tests, printed weights, symmetries and paths, against closed forms.
 * dims: 1 2 3 */
#include "lattice/stencil.h"
#include "test.h"

static int build(pd_ctx *ctx, double m, const double *h, pd_weights weights, pd_stencil *s)
{
    pd_stencil_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.m = m;
    for (int d = 0; d < PD_DIM; d++) desc.h[d] = h[d];
    desc.weights = weights;
    pd_ctx_init(ctx);
    return CHECK_OK(ctx, pd_stencil_build(ctx, &desc, s));
}

static void release(pd_ctx *ctx, pd_stencil *s)
{
    pd_stencil_free(ctx, s);
    CHECK_INT(ctx->in_use, 0);
}

static void equal_spacing(double length, double *h)
{
    for (int d = 0; d < PD_DIM; d++) h[d] = length;
}

/* Points of the lattice within m + 1/2, counted by another way: squares of lengths are whole numbers. */
static int count_points(int m)
{
    int count = 0, limit = (2 * m + 1) * (2 * m + 1), y = PD_DIM > 1 ? m + 1 : 0, z = PD_DIM > 2 ? m + 1 : 0;
    for (int c = -z; c <= z; c++)
        for (int b = -y; b <= y; b++)
            for (int a = -m - 1; a <= m + 1; a++) count += 4 * (a * a + b * b + c * c) < limit;
    return count - 1;
}

TEST(family_sizes)
{
    static const int expected[] = {0, 6, 36, 178};
    double h[PD_DIM];
    pd_ctx ctx;
    pd_stencil s;
    equal_spacing(5e-6, h);
    if (!build(&ctx, 0.0, h, PD_WEIGHTS_CALIBRATED, &s)) return;
    CHECK_INT(s.count, expected[PD_DIM]);
    CHECK_INT(s.reach, 3);
    CHECK_NEAR(s.m, 3.0, 0.0);
    CHECK_REL(s.volume, pow(5e-6, PD_DIM), 1e-15);
    release(&ctx, &s);
    for (int m = 1; m <= 6; m++) {
        if (!build(&ctx, m, h, PD_WEIGHTS_CALIBRATED, &s)) return;
        CHECK_INT(s.count, count_points(m));
        CHECK_INT(s.reach, m);
        release(&ctx, &s);
    }
}

/* Points within m, whole cells; calibration is exact for them, too. */
TEST(whole_cells)
{
    static const int within_four[] = {0, 8, 48, 256};
    pd_stencil_desc desc;
    pd_ctx ctx;
    pd_stencil s;
    memset(&desc, 0, sizeof desc);
    desc.m = 4.0;
    desc.family = PD_FAMILY_FULL_CELLS;
    equal_spacing(2e-6, desc.h);
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_stencil_build(&ctx, &desc, &s))) return;
    CHECK_INT(s.count, within_four[PD_DIM]);
    for (int k = 0; k < s.count; k++) CHECK_NEAR(s.partial_volume[k], 1.0, 0.0);
    for (int a = 0; a < PD_DIM; a++) {
        double lap = 0.0;
        for (int k = 0; k < s.count; k++) lap += s.laplacian_weight[k] * s.xi[k * PD_DIM + a] * s.xi[k * PD_DIM + a];
        CHECK_REL(lap, 2.0, 1e-13);
    }
    release(&ctx, &s);
}

/* One monomial xi_a xi_b xi_c (an index below 0: factor 1) under the operators of the centre node, whose own value is
 * zero, against its derivatives there. Errors relative to the sum of magnitudes. */
static void check_monomial(const pd_stencil *s, int a, int b, int c, double exact_lap, int check_grad)
{
    double lap = 0.0, lap_size = 0.0, grad[PD_DIM], grad_size[PD_DIM];
    memset(grad, 0, sizeof grad);
    memset(grad_size, 0, sizeof grad_size);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double f = xi[a] * (b < 0 ? 1.0 : xi[b]) * (c < 0 ? 1.0 : xi[c]);
        lap += s->laplacian_weight[k] * f;
        lap_size += fabs(s->laplacian_weight[k] * f);
        for (int d = 0; d < PD_DIM; d++) {
            grad[d] += s->gradient_weight[k * PD_DIM + d] * f;
            grad_size[d] += fabs(s->gradient_weight[k * PD_DIM + d] * f);
        }
    }
    CHECK_NEAR(lap, exact_lap, 1e-12 * lap_size);
    for (int d = 0; d < PD_DIM && check_grad; d++)
        CHECK_NEAR(grad[d], b < 0 && d == a ? 1.0 : 0.0, 1e-12 * grad_size[d]);
}

static void check_patch(const pd_stencil *s)
{
    for (int a = 0; a < PD_DIM; a++) {
        check_monomial(s, a, -1, -1, 0.0, 1);
        for (int b = a; b < PD_DIM; b++) {
            check_monomial(s, a, b, -1, a == b ? 2.0 : 0.0, 1);
            for (int c = b; c < PD_DIM; c++) check_monomial(s, a, b, c, 0.0, 0);
        }
    }
}

static void check_positive(const pd_stencil *s)
{
    for (int k = 0; k < s->count; k++)
        CHECK(s->laplacian_weight[k] > 0.0 && s->partial_volume[k] > 0.0 && s->partial_volume[k] <= 1.0);
}

/* Every assignment of the spacings 1 and `ratio` to the axes, all m: no weight turns negative there. */
TEST(patch_on_any_spacing)
{
    static const double ratios[] = {1.0, 2.0, 10.0, 100.0};
    for (int m = 2; m <= 6; m++)
        for (int r = 0; r < 4; r++)
            for (int wide = 1; wide < (r ? 1 << PD_DIM : 2); wide++) {
                double h[PD_DIM];
                pd_ctx ctx;
                pd_stencil s;
                for (int d = 0; d < PD_DIM; d++) h[d] = 1e-6 * (((wide >> d) & 1) ? ratios[r] : 1.0);
                if (!build(&ctx, m, h, PD_WEIGHTS_CALIBRATED, &s)) return;
                check_patch(&s);
                check_positive(&s);
                release(&ctx, &s);
            }
}

#if PD_DIM == 3
/* Three different spacings, up to 1 : 10 : 100. */
TEST(patch_on_three_spacings)
{
    static const double sets[][3] = {{1.0, 2.0, 10.0}, {10.0, 1.0, 100.0}, {100.0, 2.0, 1.0}};
    for (int m = 2; m <= 4; m++)
        for (int k = 0; k < 3; k++) {
            pd_ctx ctx;
            pd_stencil s;
            if (!build(&ctx, m, sets[k], PD_WEIGHTS_CALIBRATED, &s)) return;
            check_patch(&s);
            check_positive(&s);
            release(&ctx, &s);
        }
}
#endif

#if PD_DIM > 1
/* Laplacian of x_axis^2 / 2, exactly 1. */
static double printed_response(double m, const double *h, int axis)
{
    double sum = 0.0;
    pd_ctx ctx;
    pd_stencil s;
    if (!build(&ctx, m, h, PD_WEIGHTS_PUBLISHED, &s)) return NAN;
    for (int k = 0; k < s.count; k++)
        sum += 0.5 * s.laplacian_weight[k] * s.xi[k * PD_DIM + axis] * s.xi[k * PD_DIM + axis];
    release(&ctx, &s);
    return sum;
}

/* Figures of codes that use the continuum coefficients on a lattice. */
TEST(printed_weights)
{
    double h[PD_DIM];
    equal_spacing(1e-6, h);
#if PD_DIM == 2
    static const double crevice[2] = {25e-6, 1e-6};
    CHECK_NEAR(printed_response(2.0, h, 0), 0.9638, 5e-5);
    CHECK_NEAR(printed_response(3.0, h, 0), 0.968655, 5e-7);
    CHECK_NEAR(printed_response(4.0, h, 1), 0.9832, 5e-5);
    CHECK_NEAR(printed_response(5.0, h, 1), 0.9947, 5e-5);
    CHECK_NEAR(printed_response(4.0, crevice, 0), 0.217, 5e-4);
    CHECK_NEAR(printed_response(4.0, crevice, 1), 6.97, 5e-3);
#else
    CHECK_NEAR(printed_response(3.0, h, 0), 1.0244, 5e-5);
    CHECK_NEAR(printed_response(4.0, h, 2), 1.0082, 5e-5);
#endif
}
#else
/* m = 1: the three-point formulae. m = 2: beta = 1 and 1/2, so a_1 = 8 a_2 and 2 (a_1 + 4 a_2) = 2/h^2. */
TEST(weights_by_hand)
{
    double h[1] = {0.5};
    pd_ctx ctx;
    pd_stencil s;
    if (!build(&ctx, 1.0, h, PD_WEIGHTS_CALIBRATED, &s)) return;
    for (int k = 0; k < 2; k++) {
        CHECK_REL(s.laplacian_weight[k], 4.0, 1e-14);
        CHECK_REL(s.gradient_weight[k], k ? 1.0 : -1.0, 1e-14);
    }
    release(&ctx, &s);
    if (!build(&ctx, 2.0, h, PD_WEIGHTS_CALIBRATED, &s)) return;
    CHECK_REL(s.laplacian_weight[0], 4.0 / 12.0, 1e-14);
    CHECK_REL(s.laplacian_weight[1], 4.0 * 2.0 / 3.0, 1e-14);
    release(&ctx, &s);
    /* the continuum coefficient 1/delta: sum of 1/2 a xi^2 = (1 + 1 + 1/2 + 1/2) h / (2 h) / 2 */
    if (!build(&ctx, 2.0, h, PD_WEIGHTS_PUBLISHED, &s)) return;
    double sum = 0.0;
    for (int k = 0; k < s.count; k++) sum += 0.5 * s.laplacian_weight[k] * s.xi[k] * s.xi[k];
    CHECK_REL(sum, 0.75, 1e-14);
    release(&ctx, &s);
}
#endif

/* The entry of offset n; -1: none. */
static int find(const pd_stencil *s, const int *n)
{
    for (int k = 0; k < s->count; k++)
        if (memcmp(s->offset + k * PD_DIM, n, PD_DIM * sizeof *n) == 0) return k;
    return -1;
}

static void check_opposite(const pd_stencil *s)
{
    double sum[PD_DIM], size = 0.0;
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < s->count; k++) {
        int o = s->count - 1 - k;
        CHECK(s->laplacian_weight[k] == s->laplacian_weight[o] && s->base_weight[k] == s->base_weight[o] &&
              s->partial_volume[k] == s->partial_volume[o]);
        CHECK_REL(s->area_weight[k], s->area_weight[o], 1e-14);
        for (int d = 0; d < PD_DIM; d++) {
            CHECK_INT(s->offset[k * PD_DIM + d], -s->offset[o * PD_DIM + d]);
            CHECK(s->gradient_weight[k * PD_DIM + d] == -s->gradient_weight[o * PD_DIM + d]);
            CHECK_REL(s->xi[k * PD_DIM + d], s->offset[k * PD_DIM + d] * s->h[d], 1e-15);
            sum[d] += s->gradient_weight[k * PD_DIM + d];
            size += fabs(s->gradient_weight[k * PD_DIM + d]);
        }
    }
    for (int d = 0; d < PD_DIM; d++) CHECK_LE(fabs(sum[d]), 1e-14 * size);
}

/* Reflections leave the weights alone on any spacing, exchanges of axes on equal spacings. */
static void check_mirrored(const pd_stencil *s, int equal)
{
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            int n[PD_DIM], other = (d + 1) % PD_DIM;
            memcpy(n, s->offset + k * PD_DIM, sizeof n);
            n[d] = -n[d];
            CHECK_REL(s->laplacian_weight[find(s, n)], s->laplacian_weight[k], 1e-13);
            if (!equal) continue;
            n[d] = n[other];
            n[other] = s->offset[k * PD_DIM + d];
            int image = find(s, n);
            CHECK_REL(s->laplacian_weight[image], s->laplacian_weight[k], 1e-13);
            CHECK_NEAR(s->gradient_weight[image * PD_DIM + other], s->gradient_weight[k * PD_DIM + d], 1e-13 / s->h[0]);
        }
}

TEST(symmetries)
{
    static const double ms[] = {1.0, 1.5, 2.0, 2.7, 3.0, 4.0, 5.25};
    for (int i = 0; i < 7; i++)
        for (int equal = 0; equal < 2; equal++) {
            double h[PD_DIM];
            pd_ctx ctx;
            pd_stencil s;
            for (int d = 0; d < PD_DIM; d++) h[d] = equal ? 2e-6 : 2e-6 * (1 + 7 * d);
            if (!build(&ctx, ms[i], h, PD_WEIGHTS_CALIBRATED, &s)) return;
            check_opposite(&s);
            check_mirrored(&s, equal);
            check_positive(&s);
            release(&ctx, &s);
        }
}

/* Lengths times a power of two: the weights follow bit for bit. */
#if PD_DIM > 1
/* Between 1 and 2 there is a horizon with isotropic fourth moments (theory: 1.4); in 2D its weights are those of the
 * nine-point Laplacian. */
TEST(isotropic_horizon)
{
    double m = PD_DIM == 2 ? 2.0 * sqrt(2.0) - 1.5 : sqrt(3.0) - 0.5 + 0.375 * (sqrt(2.0) - 1.0), h[PD_DIM];
    pd_ctx ctx;
    pd_stencil s;
    equal_spacing(1.0, h);
    if (!build(&ctx, m, h, PD_WEIGHTS_CALIBRATED, &s)) return;
    CHECK_INT(s.count, PD_DIM == 2 ? 8 : 26);
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) {
            double sum = 0.0;
            for (int k = 0; k < s.count; k++)
                sum += s.laplacian_weight[k] * pow(s.xi[k * PD_DIM + a], 2.0) * pow(s.xi[k * PD_DIM + b], 2.0);
            CHECK_REL(sum, a == b ? 2.0 : 2.0 / 3.0, 1e-14);
        }
    for (int k = 0; k < s.count && PD_DIM == 2; k++) {
        int diagonal = s.offset[k * PD_DIM] != 0 && s.offset[k * PD_DIM + 1] != 0;
        CHECK_REL(s.laplacian_weight[k], diagonal ? 1.0 / 6.0 : 2.0 / 3.0, 1e-14);
    }
    release(&ctx, &s);
}
#endif

TEST(unit_covariance)
{
    double h[PD_DIM], scaled[PD_DIM], factor = ldexp(1.0, -19);
    pd_ctx ctx, other;
    pd_stencil s, t;
    for (int d = 0; d < PD_DIM; d++) {
        h[d] = 1.3 + 0.7 * d;
        scaled[d] = h[d] * factor;
    }
    if (!build(&ctx, 3.0, h, PD_WEIGHTS_CALIBRATED, &s)) return;
    if (!build(&other, 3.0, scaled, PD_WEIGHTS_CALIBRATED, &t)) return;
    for (int k = 0; k < s.count; k++) {
        CHECK(t.laplacian_weight[k] * factor * factor == s.laplacian_weight[k]);
        for (int d = 0; d < PD_DIM; d++)
            CHECK(t.gradient_weight[k * PD_DIM + d] * factor == s.gradient_weight[k * PD_DIM + d]);
    }
    release(&ctx, &s);
    release(&other, &t);
}

/* Fractions of the bond between which its line runs through the closed cell c. 0: never. */
static int passage(const int *n, const int *c, double *first, double *last)
{
    *first = 0.0;
    *last = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        if (n[d] == 0) {
            if (c[d] != 0) return 0;
            continue;
        }
        double a = (c[d] - 0.5) / n[d], b = (c[d] + 0.5) / n[d];
        *first = fmax(*first, fmin(a, b));
        *last = fmin(*last, fmax(a, b));
    }
    return *last > *first - 1e-12;
}

/* Groups of one cell are the cells whose inside the line crosses, in order; others touch it in an edge or corner. */
static void check_path(const pd_stencil *s, int k)
{
    const int *n = s->offset + k * PD_DIM;
    double first, last, reached = 0.0;
    int crossed = 0, c[PD_DIM], ends = s->group_first[k + 1] - 1;
    for (int g = s->group_first[k]; g <= ends; g++) {
        int single = s->group_cell[g + 1] - s->group_cell[g] == 1;
        CHECK(s->group_entry[g] >= reached);
        reached = s->group_entry[g];
        for (int e = s->group_cell[g]; e < s->group_cell[g + 1]; e++) {
            CHECK(passage(n, s->cell + e * PD_DIM, &first, &last));
            CHECK_NEAR(first, s->group_entry[g], 1e-12);
            CHECK(single ? last > first + 1e-12 : last < first + 1e-12);
        }
        crossed += single;
    }
    CHECK(memcmp(s->cell + s->group_cell[ends] * PD_DIM, n, PD_DIM * sizeof *n) == 0);
    int total = 1, expected = -1; /* less the cell of the start */
    for (int d = 0; d < PD_DIM; d++) total *= 2 * s->reach + 1;
    for (int i = 0; i < total; i++) {
        for (int d = 0, rest = i; d < PD_DIM; d++, rest /= 2 * s->reach + 1)
            c[d] = rest % (2 * s->reach + 1) - s->reach;
        expected += passage(n, c, &first, &last) && last > first + 1e-12;
    }
    CHECK_INT(crossed, expected);
}

/* 1 when group h of the opposite bond holds the cells of group g of bond k, seen from its own end. */
static int same_group(const pd_stencil *s, int k, int g, int h)
{
    const int *n = s->offset + k * PD_DIM;
    if (s->group_cell[g + 1] - s->group_cell[g] != s->group_cell[h + 1] - s->group_cell[h]) return 0;
    for (int a = s->group_cell[g]; a < s->group_cell[g + 1]; a++) {
        int found = 0;
        for (int b = s->group_cell[h]; b < s->group_cell[h + 1] && !found; b++) {
            found = 1;
            for (int d = 0; d < PD_DIM; d++) found = found && s->cell[b * PD_DIM + d] + n[d] == s->cell[a * PD_DIM + d];
        }
        if (!found) return 0;
    }
    return 1;
}

TEST(paths)
{
    for (int m = 1; m <= (PD_DIM == 3 ? 4 : 6); m++) {
        double h[PD_DIM];
        pd_ctx ctx;
        pd_stencil s;
        for (int d = 0; d < PD_DIM; d++) h[d] = 1.0 + 3.0 * d;
        if (!build(&ctx, m, h, PD_WEIGHTS_CALIBRATED, &s)) return;
        for (int k = 0; k < s.count; k++) {
            int o = s.count - 1 - k;
            check_path(&s, k);
            /* the last group is the end node, which the opposite bond starts from */
            CHECK_INT(s.group_first[k + 1] - s.group_first[k], s.group_first[o + 1] - s.group_first[o]);
            for (int g = s.group_first[k]; g < s.group_first[k + 1] - 1; g++) {
                int partners = 0;
                for (int b = s.group_first[o]; b < s.group_first[o + 1] - 1; b++) partners += same_group(&s, k, g, b);
                CHECK_INT(partners, 1);
            }
        }
        release(&ctx, &s);
    }
}

static void check_refused(double m, double h, pd_status expected)
{
    pd_ctx ctx;
    pd_stencil_desc desc;
    pd_stencil s;
    memset(&desc, 0, sizeof desc);
    desc.m = m;
    equal_spacing(1.0, desc.h);
    desc.h[PD_DIM - 1] = h;
    pd_ctx_init(&ctx);
    CHECK_INT(pd_stencil_build(&ctx, &desc, &s), expected);
    CHECK(strncmp(ctx.message, "stencil: ", 9) == 0);
    release(&ctx, &s);
    release(&ctx, &s); /* twice is allowed */
}

TEST(bad_input)
{
    check_refused(0.5, 1.0, PD_ERR_ARGUMENT);
    check_refused(-3.0, 1.0, PD_ERR_ARGUMENT);
    check_refused(12.5, 1.0, PD_ERR_ARGUMENT);
    check_refused((double)NAN, 1.0, PD_ERR_ARGUMENT);
    check_refused((double)INFINITY, 1.0, PD_ERR_ARGUMENT);
    check_refused(3.0, 0.0, PD_ERR_ARGUMENT);
    check_refused(3.0, -1.0, PD_ERR_ARGUMENT);
    check_refused(3.0, (double)NAN, PD_ERR_ARGUMENT);
    check_refused(3.0, (double)INFINITY, PD_ERR_ARGUMENT);
}

#if PD_DIM == 1
#define OF_DIM ENTRY(weights_by_hand)
#elif PD_DIM == 2
#define OF_DIM ENTRY(printed_weights)
#else
#define OF_DIM ENTRY(printed_weights) ENTRY(patch_on_three_spacings)
#endif

#if PD_DIM > 1
#define OF_PLANE ENTRY(isotropic_horizon)
#else
#define OF_PLANE
#endif

TEST_MAIN(ENTRY(family_sizes) ENTRY(whole_cells) ENTRY(patch_on_any_spacing) OF_DIM OF_PLANE ENTRY(symmetries)
              ENTRY(unit_covariance) ENTRY(paths) ENTRY(bad_input))
