/* streamline: lines along a flow against closed forms; arrows of a picture. */
/* dims: 2 */
#include "io/velocity_plot.h"
#include "io/field_plot.h"
#include "test.h"
#include <string.h>

enum { N = 40 };
static const double pi = 3.14159265358979323846;

/* A flow on N x N cells of 1 m, 10 pixels wide. */
typedef struct flow {
    double u[2][N * N];
    pdi_streamline_field stream;
    pdi_streamlines lines;
} flow;

static void start(flow *f, void (*velocity)(const double *x, double *u))
{
    memset(&f->stream, 0, sizeof f->stream);
    memset(&f->lines, 0, sizeof f->lines);
    f->stream.nx = f->stream.ny = N;
    for (int d = 0; d < 2; d++) {
        f->stream.velocity[d] = f->u[d];
        f->stream.cell_size[d] = 1.0;
        f->stream.pixel_size[d] = 10.0;
    }
    f->stream.spacing = 20.0;
    for (int k = 0; k < N * N; k++) {
        double x[2] = {k % N + 0.5, k / N + 0.5}, u[2];
        velocity(x, u);
        for (int d = 0; d < 2; d++) f->u[d][k] = u[d];
    }
}

static const double *point(const flow *f, int64_t line, int64_t k)
{
    return &f->lines.point[2 * (f->lines.line[line].first + k)];
}

/* Smallest distance of points of different lines. */
static double closest(const flow *f)
{
    double least = 1e300;
    for (int64_t a = 0; a < f->lines.count; a++)
        for (int64_t b = 0; b < a; b++)
            for (int64_t i = 0; i < f->lines.line[a].count; i++)
                for (int64_t j = 0; j < f->lines.line[b].count; j++) {
                    const double *p = point(f, a, i), *q = point(f, b, j);
                    least = fmin(least, hypot(p[0] - q[0], p[1] - q[1]));
                }
    return least;
}

/* Largest distance of a place, on a lattice of 5 pixels, from the nearest point of a line, where the flow is. */
static double widest(const flow *f, double margin)
{
    double most = 0.0, u[2];
    for (double y = margin; y <= 10.0 * N - margin; y += 5.0)
        for (double x = margin; x <= 10.0 * N - margin; x += 5.0) {
            double least = 1e300, at[2] = {x, y};
            if (!pdi_streamline_interpolate_velocity(&f->stream, at, u)) continue;
            for (int64_t k = 0; k < f->lines.point_count; k++)
                least = fmin(least, hypot(f->lines.point[2 * k] - x, f->lines.point[2 * k + 1] - y));
            most = fmax(most, least);
        }
    return most;
}

static void sloping(const double *x, double *u)
{
    u[0] = 0.02 + 0.0 * x[0];
    u[1] = 0.01;
}

/* Straight lines from side to side, 20 pixels apart and no farther. */
TEST(a_uniform_flow_has_straight_lines)
{
    static flow f;
    pd_ctx ctx;
    double off = 0.0, short_of = 0.0;
    pd_ctx_init(&ctx);
    start(&f, sloping);
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    CHECK_LE(10, f.lines.count);
    for (int64_t k = 0; k < f.lines.count; k++) {
        const double *a = point(&f, k, 0), *b = point(&f, k, f.lines.line[k].count - 1);
        CHECK(!f.lines.line[k].is_loop && b[0] > a[0]);
        for (int64_t i = 0; i < f.lines.line[k].count; i++) {
            const double *p = point(&f, k, i);
            off = fmax(off, fabs((p[0] - a[0]) - 2.0 * (p[1] - a[1])) / sqrt(5.0));
        }
        short_of = fmax(short_of, fmin(a[0], a[1])); /* it begins at a side */
        short_of = fmax(short_of, fmin(10.0 * N - b[0], 10.0 * N - b[1]));
    }
    CHECK_LE(off, 1e-10);
    CHECK_LE(short_of, 0.2);
    CHECK_NEAR(closest(&f), 20.0, 1e-3); /* between points, that are at most 2 pixels apart */
    CHECK_LE(widest(&f, 15.0), 20.5); /* else there is room for a line */
    pdi_streamlines_free(&ctx, &f.lines);
}

/* Along x, fastest in the cell (27, 9). */
static void bump(const double *x, double *u)
{
    u[0] = 1.0 + 0.1 * exp(-pow(x[0] - 27.5, 2.0) - pow(x[1] - 9.5, 2.0));
    u[1] = 0.0;
}

/* The first line passes the middle of the fastest cell, and the others follow from it, one after the other on both of
 * its sides. */
TEST(lines_begin_at_the_fastest_cell)
{
    static flow f;
    pd_ctx ctx;
    double off = 1e300, uneven = 0.0;
    pd_ctx_init(&ctx);
    start(&f, bump);
    f.stream.pixel_size[1] = 6.0;
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    CHECK_INT((int)f.lines.count, 12); /* at 57 - 2 x 20 to 57 + 9 x 20 of 240 pixels */
    for (int64_t i = 0; i < f.lines.line[0].count; i++)
        off = fmin(off, hypot(point(&f, 0, i)[0] - 275.0, point(&f, 0, i)[1] - 57.0));
    CHECK_LE(off, 1e-9);
    for (int64_t k = 0; k < f.lines.count; k++) {
        double lines = (point(&f, k, 0)[1] - 57.0) / (20.0 * (1.0 + 1e-6));
        uneven = fmax(uneven, fabs(lines - floor(lines + 0.5)));
    }
    CHECK_LE(uneven, 1e-9);
    pdi_streamlines_free(&ctx, &f.lines);
}

/* A block in the middle, and channels one cell wide along the sides, which no line of it reaches. */
static void chambers(const double *x, double *u)
{
    int inner = x[0] > 10.0 && x[0]<30.0, middle = x[1]> 10.0 && x[1] < 30.0;
    u[0] = u[1] = (double)NAN;
    if (inner && middle) u[0] = 2.0;
    else if (inner && (x[1] < 1.0 || x[1] > N - 1.0)) u[0] = 1.0;
    else if (!middle || (x[0] > 1.0 && x[0] < N - 1.0)) return;
    u[1] = isnan(u[0]) ? 1.0 : 0.0;
    if (isnan(u[0])) u[0] = 0.0;
}

/* Each has a line of its own. */
TEST(chambers_have_lines)
{
    static flow f;
    pd_ctx ctx;
    int found[5] = {0, 0, 0, 0, 0};
    pd_ctx_init(&ctx);
    start(&f, chambers);
    f.stream.pixel_size[1] = 6.0;
    for (int s = 0; s < 4; s++) f.stream.side_closed[s] = 1;
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    for (int64_t k = 0; k < f.lines.count; k++) {
        const double *p = point(&f, k, f.lines.line[k].count / 2);
        found[p[0] < 10.0 ? 0 : p[0] > 390.0 ? 1 : p[1] < 6.0 ? 2 : p[1] > 234.0 ? 3 : 4]++;
    }
    for (int c = 0; c < 4; c++) CHECK_INT(found[c], 1);
    CHECK_LE(4, found[4]);
    pdi_streamlines_free(&ctx, &f.lines);
}

static void rotating(const double *x, double *u)
{
    u[0] = -(x[1] - 0.5 * N);
    u[1] = x[0] - 0.5 * N;
}

/* Circles that close, about the middle: but beside the sides a bilinear velocity is exact, and what is left is the
 * error of steps. */
TEST(a_rotation_has_closed_circles)
{
    static flow f;
    pd_ctx ctx;
    int closed = 0;
    double off = 0.0, gap = 0.0, least = 1e9, most = 0.0;
    pd_ctx_init(&ctx);
    start(&f, rotating);
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    for (int64_t k = 0; k < f.lines.count; k++) {
        int64_t count = f.lines.line[k].count;
        const double *a = point(&f, k, 0), *b = point(&f, k, count - 1), *c = point(&f, k, count - 2);
        double radius = hypot(a[0] - 5.0 * N, a[1] - 5.0 * N), turned = 0.0;
        for (int64_t i = 0; i < count; i++) {
            const double *p = point(&f, k, i);
            double from = hypot(p[0] - 5.0 * N, p[1] - 5.0 * N);
            if (radius < 190.0) off = fmax(off, fabs(from - radius));
            if (i == 0) continue;
            const double *q = point(&f, k, i - 1);
            double cross = (q[0] - 5.0 * N) * (p[1] - 5.0 * N) - (q[1] - 5.0 * N) * (p[0] - 5.0 * N);
            turned += asin(cross / radius / radius);
        }
        least = fmin(least, radius);
        if (!f.lines.line[k].is_loop) {
            CHECK_LE(200.0 - 20.0, radius); /* a side cuts it */
            continue;
        }
        most = fmax(most, radius);
        closed++;
        gap = fmax(gap, hypot(a[0] - b[0], a[1] - b[1]));
        CHECK_LE(hypot(c[0] - b[0], c[1] - b[1]), 3.0); /* no piece is longer than others */
        CHECK_NEAR(turned, 2.0 * pi, 1e-4); /* once around, with the flow */
    }
    CHECK_LE(7, closed);
    CHECK_LE(off, 1e-4);
    CHECK(gap <= 0.0);
    CHECK_LE(least, 30.0);
    CHECK_LE(170.0, most);
    CHECK_NEAR(closest(&f), 20.0, 0.2);
    pdi_streamlines_free(&ctx, &f.lines);
}

/* Fastest along y at one side, and along x at the other. */
static void crossing(const double *x, double *u)
{
    u[0] = 0.5 + 2.0 * x[0] / N;
    u[1] = 3.0 - 2.8 * x[0] / N;
}

/* Lines follow the flow on paper: cells of half the height, drawn as high, of a flow half as fast there, look the same,
 * and so do cells of half the width. */
TEST(flat_cells)
{
    static flow square, flat;
    static void (*const all[])(const double *, double *) = {rotating, crossing};
    for (int n = 0; n < 4; n++) {
        pd_ctx ctx;
        int64_t points = 0;
        int along = n % 2;
        pd_ctx_init(&ctx);
        start(&square, all[n / 2]);
        start(&flat, all[n / 2]);
        flat.stream.cell_size[along] = 0.5;
        for (int k = 0; k < N * N; k++) flat.u[along][k] *= 0.5;
        if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &square.stream, &square.lines))) return;
        if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &flat.stream, &flat.lines))) return;
        CHECK_INT(flat.lines.count, square.lines.count);
        for (int64_t k = 0; k < square.lines.count && k < flat.lines.count; k++) {
            CHECK_INT(flat.lines.line[k].count, square.lines.line[k].count);
            points += square.lines.line[k].count;
        }
        CHECK(memcmp(flat.lines.point, square.lines.point, (size_t)points * 2 * sizeof *flat.lines.point) == 0);
        pdi_streamlines_free(&ctx, &square.lines);
        pdi_streamlines_free(&ctx, &flat.lines);
    }
}

/* Lines spiral into a sink: none comes nearer than 10 pixels to itself or another one. */
static void spiral(const double *x, double *u)
{
    double dx = x[0] - 20.3, dy = x[1] - 19.6;
    u[0] = -dy - 0.08 * dx;
    u[1] = dx - 0.08 * dy;
}

TEST(spirals_keep_their_distance)
{
    static flow f;
    pd_ctx ctx;
    double own = 1e300;
    pd_ctx_init(&ctx);
    start(&f, spiral);
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    CHECK_LE(1, f.lines.count);
    for (int64_t k = 0; k < f.lines.count; k++) {
        double along = 0.0, length[4096];
        CHECK(!f.lines.line[k].is_loop);
        if (!CHECK(f.lines.line[k].count <= 4096)) break;
        for (int64_t i = 0; i < f.lines.line[k].count; i++) {
            const double *p = point(&f, k, i);
            if (i) along += hypot(p[0] - point(&f, k, i - 1)[0], p[1] - point(&f, k, i - 1)[1]);
            length[i] = along;
            for (int64_t j = 0; j < i; j++) {
                const double *q = point(&f, k, j);
                if (along - length[j] > 10.0 * pi) own = fmin(own, hypot(p[0] - q[0], p[1] - q[1]));
            }
        }
    }
    CHECK_LE(9.8, own);
    CHECK_LE(9.8, closest(&f));
    pdi_streamlines_free(&ctx, &f.lines);
}

/* Around a square block, given as the potential flow about a disc, which has velocities into the block's faces. */
static void around(const double *x, double *u)
{
    double dx = x[0] - 20.0, dy = x[1] - 20.0, r2 = dx * dx + dy * dy, a2 = 36.0;
    u[0] = 1.0 - a2 * (dx * dx - dy * dy) / (r2 * r2);
    u[1] = -2.0 * a2 * dx * dy / (r2 * r2);
    if (fabs(dx) < 7.0 && fabs(dy) < 7.0) u[0] = u[1] = (double)NAN;
}

static int in_block(double x, double y) { return fabs(x - 200.0) < 70.0 - 1e-9 && fabs(y - 200.0) < 70.0 - 1e-9; }

TEST(no_line_enters_a_solid)
{
    static flow f;
    pd_ctx ctx;
    int inside = 0, outside = 0;
    double u[2];
    pd_ctx_init(&ctx);
    start(&f, around);
    f.stream.side_closed[2] = f.stream.side_closed[3] = 1;
    if (!CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines))) return;
    CHECK_LE(10, f.lines.count);
    for (int64_t k = 0; k < f.lines.point_count; k++) {
        const double *p = &f.lines.point[2 * k];
        inside += in_block(p[0], p[1]);
        outside += !(p[0] >= 0.0 && p[0] <= 400.0 && p[1] >= 0.0 && p[1] <= 400.0);
    }
    CHECK_INT(inside, 0);
    CHECK_INT(outside, 0);
    CHECK_LE(9.8, closest(&f));
    /* at faces and closed sides the component across is zero, and the one along is not */
    const double faces[3][2] = {{130.0 - 1e-9, 180.0}, {200.0, 270.0 + 1e-9}, {57.0, 0.0}};
    for (int k = 0; k < 3; k++) {
        if (!CHECK(pdi_streamline_interpolate_velocity(&f.stream, faces[k], u))) continue;
        CHECK_LE(fabs(u[k > 0]), 1e-6);
        CHECK_LE(0.1, fabs(u[k == 0]));
    }
    double in[2] = {200.0, 200.0};
    CHECK_INT(pdi_streamline_interpolate_velocity(&f.stream, in, u), 0);
    pdi_streamlines_free(&ctx, &f.lines);
}

static void still(const double *x, double *u)
{
    u[0] = 0.0 * x[0];
    u[1] = 0.0;
}

/* Fluid at rest has no lines; half a plane at rest has none there. */
static void half_still(const double *x, double *u)
{
    u[0] = 0.0;
    u[1] = x[0] > 20.0 ? 1.0 : 1e-9;
}

TEST(fluid_at_rest_has_no_lines)
{
    static flow f;
    pd_ctx ctx;
    double left = 1e300;
    pd_ctx_init(&ctx);
    start(&f, still);
    CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines));
    CHECK_INT(f.lines.count, 0);
    CHECK(pdi_streamline_compute_max_speed(&f.stream) <= 0.0);
    start(&f, half_still);
    CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines));
    CHECK_LE(8, f.lines.count);
    for (int64_t k = 0; k < f.lines.point_count; k++) left = fmin(left, f.lines.point[2 * k]);
    CHECK_LE(195.0, left);
    pdi_streamlines_free(&ctx, &f.lines);
}

/* The lines of the lower half are those of the upper one: they keep half the distance from y = 0, and where there is
 * room for one more it is there. */
TEST(mirrored_lines_keep_half_the_distance)
{
    static flow f;
    pd_ctx ctx;
    double least = 1e300;
    pd_ctx_init(&ctx);
    for (double apart = 20.0; apart < 40.0; apart += 1.0) {
        double low = 1e300;
        start(&f, sloping);
        for (int k = 0; k < N * N; k++) f.u[1][k] = 0.0;
        f.stream.spacing = apart;
        f.stream.mirrored = f.stream.side_closed[2] = 1;
        CHECK_OK(&ctx, pdi_streamlines_compute(&ctx, &f.stream, &f.lines));
        for (int64_t k = 0; k < f.lines.point_count; k++) low = fmin(low, f.lines.point[2 * k + 1]);
        least = fmin(least, low / apart);
        CHECK_LE(low, 1.5 * apart);
        CHECK_NEAR(closest(&f), apart, 1e-3);
        pdi_streamlines_free(&ctx, &f.lines);
    }
    CHECK_LE(0.5, least);
    CHECK_LE(least, 0.75);
}

TEST(the_scale_arrow_is_a_round_number)
{
    char text[32];
    CHECK_REL(pdi_velocity_plot_reference_speed(0.236, text), 0.2, 1e-12);
    CHECK_STR(text, "0.2 m/s");
    CHECK_REL(pdi_velocity_plot_reference_speed(0.05, text), 0.05, 1e-12);
    CHECK_STR(text, "0.05 m/s");
    CHECK_REL(pdi_velocity_plot_reference_speed(9.9e-5, text), 5e-5, 1e-12);
    CHECK_STR(text, "0.05 mm/s");
    CHECK_REL(pdi_velocity_plot_reference_speed(1e-5, text), 1e-5, 1e-12);
    CHECK_STR(text, "10 \xC2\xB5m/s");
    CHECK_REL(pdi_velocity_plot_reference_speed(1e3, text), 1e3, 1e-12);
    CHECK_STR(text, "1 km/s");
}

/* Ink in the field of a picture: pixels darker than the paper of a constant field. */
static int dark(const pd_image *image, int x, int y)
{
    const uint8_t *p = image->pixels + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    return p[0] + p[1] + p[2] < 3 * 80;
}

/* In a uniform flow along x all arrows have the length of `fastest`; of half the speed half of it. */
TEST(arrows_are_as_long_as_the_flow_is_fast)
{
    static double value[N * N], velocity[2 * N * N];
    pd_field_plot picture;
    pd_ctx ctx;
    int longest[2] = {0, 0};
    pd_ctx_init(&ctx);
    memset(&picture, 0, sizeof picture);
    picture.nx = picture.ny = N;
    picture.values = value;
    picture.hi[0] = picture.hi[1] = 1.0;
    picture.range_hi = 1.0;
    picture.map = PD_COLOUR_MAP_GREY;
    picture.width = 400;
    picture.arrows = 8; /* 50 pixels */
    picture.velocity = velocity;
    picture.max_speed = 2.0;
    for (int k = 0; k < N * N; k++) {
        value[k] = 1.0;
        velocity[k] = k / N < N / 2 ? 2.0 : 1.0;
    }
    for (int times = 0; times < 2; times++) {
        pd_image image;
        if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
        for (int half = 0; half < 2; half++) {
            longest[half] = 0;
            for (int y = half ? 60 : 240; y < (half ? 180 : 360); y++)
                for (int x = 100, run = 0; x < 380; x++) {
                    run = dark(&image, x, y) ? run + 1 : 0;
                    longest[half] = run > longest[half] ? run : longest[half];
                }
        }
        CHECK_NEAR(longest[0], times ? 25 : 50, 2);
        CHECK_NEAR(longest[1], times ? 13 : 25, 2);
        pd_image_free(&ctx, &image);
        picture.max_speed *= 2.0;
    }
    picture.velocity = NULL;
    CHECK_INT(pd_field_plot_write(&ctx, "build/none.png", &picture), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "8 vectors side by side, expected 0 or 4 to 100, with velocities") != NULL);
    picture.velocity = velocity;
    picture.streamlines = 101;
    CHECK_INT(pd_field_plot_write(&ctx, "build/none.png", &picture), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "101 streamlines side by side") != NULL);
}

TEST_MAIN(ENTRY(a_uniform_flow_has_straight_lines) ENTRY(lines_begin_at_the_fastest_cell) ENTRY(chambers_have_lines)
          ENTRY(a_rotation_has_closed_circles) ENTRY(flat_cells) ENTRY(spirals_keep_their_distance)
          ENTRY(no_line_enters_a_solid) ENTRY(fluid_at_rest_has_no_lines)
          ENTRY(mirrored_lines_keep_half_the_distance) ENTRY(the_scale_arrow_is_a_round_number)
          ENTRY(arrows_are_as_long_as_the_flow_is_fast))
