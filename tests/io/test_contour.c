/* contour: lines of one value against closed forms. */
/* dims: 2 */
#include "io/contour.h"
#include "test.h"
#include <string.h>

enum { N = 40 };
static const double pi = 3.14159265358979323846;

/* What is found of lines. */
typedef struct found {
    int pieces;
    double length, worst; /* [cells] length of all, largest distance from the closed form */
    double lo[2], hi[2];  /* [cells] the box around them */
    double (*off)(const double *at);
} found;

static void take(void *user, const double *a, const double *b)
{
    found *f = (found *)user;
    f->pieces++;
    f->length += hypot(b[0] - a[0], b[1] - a[1]);
    f->worst = fmax(f->worst, fmax(fabs(f->off(a)), fabs(f->off(b))));
    for (int d = 0; d < 2; d++) {
        f->lo[d] = fmin(f->lo[d], fmin(a[d], b[d]));
        f->hi[d] = fmax(f->hi[d], fmax(a[d], b[d]));
    }
}

static found lines(const double *value, int nx, int ny, double level, double (*off)(const double *))
{
    pdi_contour c = {nx, ny, value};
    found f = {0, 0, 0, {1e9, 1e9}, {-1e9, -1e9}, off};
    pdi_contour_find_segments(&c, level, take, &f);
    return f;
}

static double any(const double *at) { return 0 * at[0]; }

/* 3 x + 2 y = 90 [cells] */
static double from_straight(const double *at) { return (3 * at[0] + 2 * at[1] - 90) / sqrt(13.0); }

/* One straight line from edge to edge of the lattice, of the right length. */
TEST(a_linear_field_has_straight_lines)
{
    double value[N * N];
    for (int k = 0; k < N * N; k++) value[k] = 3 * (k % N + 0.5) + 2 * (k / N + 0.5);
    found f = lines(value, N, N, 90, from_straight);
    CHECK_LE(f.worst, 1e-12 * N);
    CHECK_NEAR(f.length, hypot(30 - 10.0 / 3, 40), 1e-10);
    CHECK_NEAR(f.lo[1], 0, 1e-12);
    CHECK_NEAR(f.hi[1], N, 1e-12);
    CHECK_INT(lines(value, N, N, 1e9, from_straight).pieces, 0);
}

/* x^2 + y^2 = r^2 about the middle: the error of a bilinear field falls with the second power of the cells. */
static double radius;
static double from_circle(const double *at) { return hypot(at[0] - 20, at[1] - 20) - radius; }

TEST(a_paraboloid_has_circles)
{
    double value[N * N];
    for (int k = 0; k < N * N; k++) value[k] = pow(k % N + 0.5 - 20, 2) + pow(k / N + 0.5 - 20, 2);
    for (radius = 3; radius < 19; radius += 2.37) {
        found f = lines(value, N, N, radius * radius, from_circle);
        CHECK_LE(f.worst, 0.26 / radius); /* 2 r dr = error of both directions, at most 1/4 each */
        CHECK_NEAR(f.length, 2 * pi * radius, 0.5 / radius * 2 * pi);
    }
}

/* Lines end at the faces of blanked cells, and are right up to there. */
static double outside_blank(const double *at)
{
    double in = fmin(fmin(at[0] - 10, 20 - at[0]), fmin(at[1] - 15, 30 - at[1])); /* depth in the blanked box */
    return fmax(fmax(in, 0), fabs(from_straight(at)));
}

TEST(lines_do_not_enter_blanked_cells)
{
    double value[N * N];
    for (int k = 0; k < N * N; k++) {
        int i = k % N, j = k / N;
        value[k] = i >= 10 && i < 20 && j >= 15 && j < 30 ? (double)NAN : 3 * (i + 0.5) + 2 * (j + 0.5);
    }
    found f = lines(value, N, N, 90, outside_blank);
    CHECK_LE(f.worst, 1e-12 * N);
    /* the line crosses the box from (20, 15) to (10, 30), corner to corner */
    CHECK_NEAR(f.length, hypot(30 - 10.0 / 3, 40) - hypot(10, 15), 1e-10);
}

/* One cell alone has no slope, and no line. */
TEST(a_lone_cell_has_no_line)
{
    double value[3] = {NAN, 5, NAN}, none[4] = {NAN, NAN, NAN, NAN}, flat[4] = {2, 2, 2, 2};
    CHECK_INT(lines(value, 3, 1, 5, any).pieces, 0);
    CHECK_INT(lines(value, 3, 1, 4, any).pieces, 0);
    CHECK_INT(lines(none, 2, 2, 0, any).pieces, 0);
    CHECK_INT(lines(flat, 2, 2, 2, any).pieces, 0);
}

/* Four cells as a saddle (x - 1) (y - 1) + mean: the lines of a level above the mean stay in the quadrants of the
 * large values, those of one below in the others. The middles of the cells have the values +-1 off the mean. */
static double above;
static double wrong_side(const double *at)
{
    double product = (at[0] - 1) * (at[1] - 1);
    return product * above >= -1e-12 ? 0 : 1;
}

TEST(a_saddle_is_decided_by_its_mean)
{
    for (int turn = 0; turn < 2; turn++)
        for (above = -1; above < 2; above += 2) {
            double sign = turn ? -1.0 : 1.0, value[4] = {7 + sign, 7 - sign, 7 - sign, 7 + sign};
            double asked = above;
            above *= sign;
            found f = lines(value, 2, 2, 7 + 0.3 * asked, wrong_side);
            above = asked;
            CHECK(f.pieces >= 2);
            CHECK_LE(f.worst, 0);
        }
}

/* The quarter of the first of four cells has the corners 1, -1, (c - 5)/4, -1: for c = 10 the mean of these is above 0,
 * and the lines cut off the corners -1, for c = 6 below, and they cut off the others. */
static double pieces[8][4];
static int piece_count;
static void keep(void *user, const double *a, const double *b)
{
    (void)user;
    if (fmin(a[0], b[0]) > 1 || fmin(a[1], b[1]) > 1 || fmax(a[0], b[0]) > 1 + 1e-12 || fmax(a[1], b[1]) > 1 + 1e-12 ||
        fmin(a[0], b[0]) < 0.5 - 1e-12 || fmin(a[1], b[1]) < 0.5 - 1e-12 || piece_count == 8)
        return; /* of another quarter */
    for (int d = 0; d < 2; d++) pieces[piece_count][d] = a[d], pieces[piece_count][2 + d] = b[d];
    piece_count++;
}

TEST(a_saddle_in_a_quarter)
{
    for (int low = 0; low < 2; low++) {
        double value[4] = {1, -3, -3, low ? 6 : 10}, mean = (value[3] - 5) / 4, far = 0.5 + 0.5 / (1 + mean);
        double ends[4][2] = {{0.75, 0.5}, {1, far}, {far, 1}, {0.5, 0.75}};
        pdi_contour c = {2, 2, value};
        int met = 0;
        piece_count = 0;
        pdi_contour_find_segments(&c, 0, keep, NULL);
        CHECK_INT(piece_count, 2);
        for (int n = 0; n < piece_count; n++)
            for (int k = 0; k < 2; k++) {
                const double *a = ends[low ? (2 * k + 3) % 4 : 2 * k], *b = ends[low ? (2 * k + 4) % 4 : 2 * k + 1];
                const double *p = pieces[n];
                met += fmin(hypot(p[0] - a[0], p[1] - a[1]) + hypot(p[2] - b[0], p[3] - b[1]),
                            hypot(p[0] - b[0], p[1] - b[1]) + hypot(p[2] - a[0], p[3] - a[1])) < 1e-12;
            }
        CHECK_INT(met, 2);
    }
}

TEST_MAIN(ENTRY(a_saddle_in_a_quarter) ENTRY(a_linear_field_has_straight_lines) ENTRY(a_paraboloid_has_circles)
          ENTRY(lines_do_not_enter_blanked_cells) ENTRY(a_lone_cell_has_no_line)
          ENTRY(a_saddle_is_decided_by_its_mean))
