/* facets: signed distances to closed surfaces of triangles, against boxes, balls, winding numbers and sums over all
 * triangles; STL files, good and bad; a scene whose metal is one.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "io/stl.h"
#include "random.h"
#include "run/sim.h"
#include "scene_file.h"
#include "test.h"

#define MOST 6000 /* triangles */
#define PI 3.14159265358979323846

static double mesh[MOST * 9];
static int triangles;

static void add(const double *a, const double *b, const double *c)
{
    if (!CHECK(triangles < MOST)) return;
    memcpy(mesh + 9 * triangles, a, 3 * sizeof *a);
    memcpy(mesh + 9 * triangles + 3, b, 3 * sizeof *a);
    memcpy(mesh + 9 * triangles++ + 6, c, 3 * sizeof *a);
}

/* The box, each face two triangles. */
static void box(const double *lo, const double *hi)
{
    static const int8_t face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                      {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    double x[8][3];
    for (int k = 0; k < 8; k++)
        for (int d = 0; d < 3; d++) x[k][d] = k >> d & 1 ? hi[d] : lo[d];
    for (int f = 0; f < 6; f++) {
        add(x[face[f][0]], x[face[f][1]], x[face[f][2]]);
        add(x[face[f][0]], x[face[f][2]], x[face[f][3]]);
    }
}

/* A torus of the radii 1 and r, its nodes at whole numbers of n and k; corners are computed once for each node. */
static void torus(int n, int k, double r)
{
    static double x[60][40][3];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < k; j++) {
            double p = 2.0 * PI * i / n, q = 2.0 * PI * j / k;
            x[i][j][0] = (1.0 + r * cos(q)) * cos(p);
            x[i][j][1] = (1.0 + r * cos(q)) * sin(p);
            x[i][j][2] = r * sin(q);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < k; j++) {
            int s = (i + 1) % n, t = (j + 1) % k;
            add(x[i][j], x[s][j], x[s][t]);
            add(x[i][j], x[s][t], x[i][t]);
        }
}

static int build(pd_ctx *ctx, pd_facets *f)
{
    pd_ctx_init(ctx);
    return CHECK_OK(ctx, pd_facets_build(ctx, mesh, triangles, f));
}

static void end(pd_ctx *ctx, pd_facets *f)
{
    pd_facets_free(ctx, f);
    pd_facets_free(ctx, f);
    CHECK_INT(ctx->in_use, 0);
}

/* How often the surface goes around x: the sum of solid angles (van Oosterom and Strackee 1983). */
static double winding(const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < triangles; k++) {
        double e[3][3], length[3], det = 0.0;
        for (int p = 0; p < 3; p++) {
            for (int d = 0; d < 3; d++) e[p][d] = mesh[9 * k + 3 * p + d] - x[d];
            length[p] = sqrt(e[p][0] * e[p][0] + e[p][1] * e[p][1] + e[p][2] * e[p][2]);
        }
        double ab = 0.0, bc = 0.0, ca = 0.0;
        for (int d = 0; d < 3; d++) {
            ab += e[0][d] * e[1][d];
            bc += e[1][d] * e[2][d];
            ca += e[2][d] * e[0][d];
            det += e[0][d] * (e[1][(d + 1) % 3] * e[2][(d + 2) % 3] - e[1][(d + 2) % 3] * e[2][(d + 1) % 3]);
        }
        sum += 2.0 * atan2(det, length[0] * length[1] * length[2] + ab * length[2] + bc * length[0] + ca * length[1]);
    }
    return sum / (4.0 * PI);
}

/* The distance by the nearest of many places of each triangle, which is never less; and no farther than `coarse`. */
static double by_places(const double *x, double *coarse)
{
    enum { N = 12 };
    double best = HUGE_VAL;
    *coarse = 0.0;
    for (int k = 0; k < triangles; k++) {
        double longest = 0.0;
        for (int p = 0; p < 3; p++) {
            double edge = 0.0;
            for (int d = 0; d < 3; d++) edge += pow(mesh[9 * k + 3 * p + d] - mesh[9 * k + 3 * ((p + 1) % 3) + d], 2.0);
            longest = fmax(longest, sqrt(edge));
        }
        *coarse = fmax(*coarse, longest / N);
        for (int i = 0; i <= N; i++)
            for (int j = 0; j + i <= N; j++) {
                double square = 0.0;
                for (int d = 0; d < 3; d++) {
                    const double *at = mesh + 9 * k + d;
                    double place = (at[0] * (N - i - j) + at[3] * i + at[6] * j) / N;
                    square += (place - x[d]) * (place - x[d]);
                }
                best = fmin(best, sqrt(square));
            }
    }
    return best;
}

/* ---- distances ---- */

/* A box of triangles is a box: at any place, and at places whose rays run along its edges and through its corners. */
TEST(boxes)
{
    static const double lo[3] = {-1.0, 0.0, 0.5}, hi[3] = {1.0, 0.25, 2.0};
    uint32_t seed = 3;
    pd_ctx ctx;
    pd_facets f;
    double worst = 0.0;
    int wrong = 0;
    triangles = 0;
    box(lo, hi);
    if (!build(&ctx, &f)) return;
    for (int k = 0; k < 30000; k++) {
        double x[3], inside = -HUGE_VAL, square = 0.0;
        for (int d = 0; d < 3; d++) {
            x[d] = k < 10000 ? 3.0 * random_real(&seed) : (double)((int)(next_random(&seed) % 33) - 16) / 8.0;
            double beyond = fmax(lo[d] - x[d], x[d] - hi[d]);
            inside = fmax(inside, beyond);
            square += beyond > 0.0 ? beyond * beyond : 0.0;
        }
        double expected = inside > 0.0 ? sqrt(square) : inside, found = pdi_facets_distance(&f, x);
        worst = fmax(worst, fabs(fabs(found) - fabs(expected)));
        wrong += fabs(expected) > 0.0 && (found < 0.0) != (expected < 0.0);
    }
    CHECK_LE(worst, 1e-15);
    CHECK_INT(wrong, 0);
    end(&ctx, &f);
}

/* No zero has a sign: a surface of which corners are -0 is the same to the last bit, as its fingerprint and what is
 * found of it have to be. */
TEST(zeros)
{
    static const double lo[3] = {-1.0, 0.0, 0.0}, hi[3] = {0.0, 2.0, 3.0};
    static double corner[12 * 9], kept[12 * 9];
    uint32_t seed = 6;
    pd_ctx ctx;
    pd_facets f, g;
    triangles = 0;
    box(lo, hi);
    if (!build(&ctx, &f)) return;
    for (int way = 0; way < 3; way++) { /* all are -0, or all of an axis, or some by chance: then welding joins them */
        memcpy(corner, mesh, sizeof corner);
        for (int k = 0; k < 9 * triangles; k++)
            if (!(fabs(mesh[k]) > 0.0) && (way == 0 || (way == 1 ? k % 3 == 0 : random_share(&seed) < 0.5)))
                corner[k] = -0.0;
        memcpy(kept, corner, sizeof kept);
        if (!CHECK_OK(&ctx, pd_facets_build(&ctx, corner, triangles, &g))) break;
        CHECK(memcmp(kept, mesh, sizeof kept) != 0);
        CHECK(memcmp(f.corner, g.corner, 9 * (size_t)f.count * sizeof *f.corner) == 0);
        for (int k = 0; k < f.count * 9; k++) CHECK(!signbit(g.corner[k]) || g.corner[k] < 0.0);
        pd_facets_free(&ctx, &g);
    }
    end(&ctx, &f);
}

/* Where a line meets a box: by the slabs between its planes. */
static double meets_box(const double *lo, const double *hi, const double *x, const double *xi, double after)
{
    double best = HUGE_VAL;
    for (int d = 0; d < 3; d++)
        for (int upper = 0; upper < 2; upper++) {
            double t = ((upper ? hi[d] : lo[d]) - x[d]) / xi[d];
            int on = t > after && t <= 1.0 && t < best;
            for (int e = 0; e < 3 && on; e++) {
                double at = x[e] + t * xi[e];
                on = e == d || (at >= lo[e] && at <= hi[e]);
            }
            if (on) best = t;
        }
    return best;
}

/* Where lines meet a box, from inside and outside, behind places before; along an axis, beside it and through its
 * corners. */
TEST(lines)
{
    static const double lo[3] = {-1.0, 0.0, 0.5}, hi[3] = {1.0, 0.25, 2.0};
    uint32_t seed = 12;
    pd_ctx ctx;
    pd_facets f;
    int hits = 0, twice = 0;
    triangles = 0;
    box(lo, hi);
    if (!build(&ctx, &f)) return;
    for (int k = 0; k < 20000; k++) {
        double x[3], xi[3], after = -1e-9;
        for (int d = 0; d < 3; d++) {
            x[d] = 2.5 * random_real(&seed);
            xi[d] = lo[d] + 1.2 * (hi[d] - lo[d]) * random_share(&seed) - x[d];
            xi[d] *= k % 4 ? 2.0 : 0.7;
        }
        for (int visit = 0; visit < 3; visit++) {
            double expected = meets_box(lo, hi, x, xi, after), found = pdi_facets_find_crossing(&f, x, xi, after);
            hits += visit == 0 && expected < HUGE_VAL;
            twice += visit == 1 && expected < HUGE_VAL;
            if (!(expected < HUGE_VAL)) CHECK(!(found < HUGE_VAL));
            else CHECK_NEAR(found, expected, 1e-12 * 1e2);
            if (!(expected < HUGE_VAL)) break;
            after = found + 1e-9;
        }
    }
    NOTE("%d lines meet the box, %d twice", hits, twice);
    CHECK(hits > 10000 && twice > 5000 && hits - twice > 500);
    for (int d = 0; d < 3; d++) { /* along an axis: what is beside it is met by nothing */
        double x[3] = {0.1, 0.1, 1.0}, xi[3] = {0.0, 0.0, 0.0};
        xi[d] = 10.0;
        x[d] = lo[d] - 1.0;
        CHECK_NEAR(pdi_facets_find_crossing(&f, x, xi, 0.0), 0.1, 1e-15);
        CHECK_NEAR(pdi_facets_find_crossing(&f, x, xi, 0.1 + 1e-9), 0.1 * (hi[d] - x[d]), 1e-15);
        CHECK(!(pdi_facets_find_crossing(&f, x, xi, 0.1 * (hi[d] - x[d]) + 1e-9) < HUGE_VAL));
        xi[d] = 0.999; /* it ends before */
        CHECK(!(pdi_facets_find_crossing(&f, x, xi, 0.0) < HUGE_VAL));
        xi[d] = 10.0;
        x[(d + 1) % 3] = hi[(d + 1) % 3] + 1e-3;
        CHECK(!(pdi_facets_find_crossing(&f, x, xi, 0.0) < HUGE_VAL));
        x[(d + 1) % 3] = lo[(d + 1) % 3]; /* within a face and along its edge */
        x[(d + 2) % 3] = hi[(d + 2) % 3];
        CHECK_NEAR(pdi_facets_find_crossing(&f, x, xi, 0.0), 0.1, 1e-12);
    }
    end(&ctx, &f);
}

/* Lines through a torus meet it where the signed distance changes its sign, as often as it does, and are on it there;
 * a line through corners and edges, where triangles meet, passes none of them by. */
TEST(lines_through_a_torus)
{
    uint32_t seed = 15;
    pd_ctx ctx;
    pd_facets f;
    int met = 0;
    triangles = 0;
    torus(30, 14, 0.4);
    if (!build(&ctx, &f)) return;
    for (int k = 0; k < 2000; k++) {
        double x[3], xi[3], t = 0.0, at[3];
        const double *node = mesh + 9 * (next_random(&seed) % (uint32_t)triangles);
        for (int d = 0; d < 3; d++) {
            double edge = 0.5 * (node[d] + node[3 + d]);
            x[d] = 3.0 * random_real(&seed);
            xi[d] = (k % 3 == 0 ? random_real(&seed) : k % 3 == 1 ? node[d] : edge) - x[d];
            if (k % 3) xi[d] *= 1.0 + 1e-9; /* what it aims at is met */
        }
        int inside = pdi_facets_distance(&f, x) < 0.0;
        for (int visit = 0; visit < 6; visit++) {
            double next = pdi_facets_find_crossing(&f, x, xi, t + 1e-9), middle = 0.5 * (t + fmin(next, 1.0));
            for (int d = 0; d < 3; d++) at[d] = x[d] + middle * xi[d];
            double off = pdi_facets_distance(&f, at);
            if (fabs(off) > 1e-6 && k % 3 == 0) CHECK_INT(off < 0.0, inside);
            if (!(next < HUGE_VAL)) break;
            for (int d = 0; d < 3; d++) at[d] = x[d] + next * xi[d];
            CHECK_LE(fabs(pdi_facets_distance(&f, at)), 1e-9);
            inside = !inside;
            met++;
            t = next;
        }
        if (k % 3) CHECK(t > 0.0);
    }
    CHECK(met > 2000);
    end(&ctx, &f);
}

/* A torus: inside where it winds around once, also on rays through its corners and edges; as far as its places; its
 * triangles in any order. */
TEST(tori)
{
    static double shuffled[MOST * 9];
    uint32_t seed = 8;
    pd_ctx ctx;
    pd_facets f, g;
    int wrong = 0, inside = 0, bits = 0;
    triangles = 0;
    torus(30, 14, 0.4);
    if (!build(&ctx, &f)) return;
    memcpy(shuffled, mesh, sizeof mesh);
    for (int k = triangles - 1; k > 0; k--) {
        double keep[9];
        int j = (int)(next_random(&seed) % (uint32_t)(k + 1));
        memcpy(keep, shuffled + 9 * k, sizeof keep);
        memcpy(shuffled + 9 * k, shuffled + 9 * j, sizeof keep);
        memcpy(shuffled + 9 * j, keep, sizeof keep);
    }
    CHECK_OK(&ctx, pd_facets_build(&ctx, shuffled, triangles, &g));
    for (int k = 0; k < 3000; k++) {
        double x[3], coarse;
        const double *node = mesh + 9 * (next_random(&seed) % (uint32_t)triangles);
        for (int d = 0; d < 3; d++) x[d] = 1.6 * random_real(&seed) * (d == 2 ? 0.4 : 1.0);
        if (k % 3 == 1) x[1] = node[1], x[2] = node[2]; /* through a corner */
        if (k % 3 == 2) { /* through the middle of an edge */
            x[1] = 0.5 * (node[1] + node[4]);
            x[2] = 0.5 * (node[2] + node[5]);
        }
        double found = pdi_facets_distance(&f, x), around = winding(x);
        if (fabs(found) > 1e-9) {
            wrong += (found < 0.0) != (around > 0.5);
            CHECK_NEAR(around, found < 0.0 ? 1.0 : 0.0, 1e-6);
        }
        inside += found < 0.0;
        double again = pdi_facets_distance(&g, x);
        bits += memcmp(&found, &again, sizeof found) != 0;
        if (k >= 150) continue;
        double places = by_places(x, &coarse);
        CHECK(fabs(found) <= places * (1.0 + 1e-14) && fabs(found) >= places - coarse);
    }
    CHECK_INT(wrong, 0);
    CHECK_INT(bits, 0);
    CHECK(inside > 500);
    pd_facets_free(&ctx, &g);
    end(&ctx, &f);
}

/* Exact to the plane, the edge and the corner of a tetrahedron in any place and of any size; normals inward, too. */
TEST(tetrahedra)
{
    static const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double at[4][4] = {/* place, distance */
                                    {0.2, 0.3, -0.5, 0.5},
                                    {-0.3, -0.4, 0.5, 0.5},
                                    {1.0 / 3.0 + 1.0, 1.0 / 3.0 + 1.0, 1.0 / 3.0 + 1.0, 1.7320508075688772},
                                    {-2.0, -1.0, -2.0, 3.0}};
    static const double size[3] = {1.0, 1e-9, 1e3};
    for (int k = 0; k < 6; k++) {
        double x[4][3], s = size[k / 2], far = k / 2 == 1 ? 1e-6 : 0.0;
        pd_ctx ctx;
        pd_facets f;
        for (int p = 0; p < 4; p++)
            for (int d = 0; d < 3; d++) x[p][d] = s * corner[p][d] + far;
        triangles = 0;
        for (int p = 0; p < 4; p++) {
            const double *a = x[(p + 1) % 4], *b = x[(p + 2) % 4], *c = x[(p + 3) % 4];
            if ((p + k) % 2) add(a, b, c);
            else add(a, c, b);
        }
        if (!build(&ctx, &f)) return;
        for (int q = 0; q < 4; q++) {
            double y[3];
            for (int d = 0; d < 3; d++) y[d] = s * at[q][d] + far;
            CHECK_NEAR(pdi_facets_distance(&f, y), s * at[q][3], 1e-15 * s + 4e-16 * far);
        }
        double middle[3] = {0.2 * s + far, 0.2 * s + far, 0.2 * s + far};
        CHECK_NEAR(pdi_facets_distance(&f, middle), -0.2 * s, 1e-15 * s + 4e-16 * far);
        end(&ctx, &f);
    }
}

/* ---- refusals ---- */

static void turned_down(pd_status wanted, const char *part)
{
    pd_ctx ctx;
    pd_facets f;
    pd_ctx_init(&ctx);
    pd_status status = pd_facets_build(&ctx, mesh, triangles, &f);
    if (!CHECK(status == wanted && strstr(ctx.message, part))) NOTE("status %d: %s", status, ctx.message);
    CHECK(f.count == 0 && f.corner == NULL);
    CHECK_INT(ctx.in_use, 0);
}

TEST(not_closed)
{
    static const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0};
    double keep[9];
    triangles = 0;
    turned_down(PD_ERR_ARGUMENT, "0 triangles");
    box(lo, hi);
    triangles = 11;
    turned_down(PD_ERR_GEOMETRY, "has 1 triangle");
    triangles = 12;
    memcpy(keep, mesh + 9, sizeof keep);
    memcpy(mesh + 9, keep + 3, 3 * sizeof *keep); /* turned over */
    memcpy(mesh + 12, keep, 3 * sizeof *keep);
    turned_down(PD_ERR_GEOMETRY, "has 2 triangles, ");
    memcpy(mesh + 9, keep, sizeof keep);
    mesh[9] += 1e-5; /* a crack */
    turned_down(PD_ERR_GEOMETRY, "is not closed");
    memcpy(mesh + 9, keep, sizeof keep);
    add(mesh, mesh + 3, mesh + 6); /* twice there */
    turned_down(PD_ERR_GEOMETRY, "has 3 triangles");
    triangles = 12;
    memcpy(mesh + 12, mesh + 9, 3 * sizeof *mesh);
    turned_down(PD_ERR_GEOMETRY, "has 1 triangle, 1 of them along it, expected as many along it as against it: the "
                                 "surface is not closed, or a triangle is turned over; so have 2 more edges");
    memcpy(mesh + 9, keep, sizeof keep);
    mesh[5] = NAN;
    turned_down(PD_ERR_ARGUMENT, "triangle 1 has the coordinate");
    static const double flat[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    triangles = 0;
    add(flat[0], flat[1], flat[2]);
    add(flat[0], flat[2], flat[3]);
    add(flat[0], flat[3], flat[1]);
    add(flat[1], flat[3], flat[2]);
    turned_down(PD_ERR_GEOMETRY, "no volume");
}

/* ---- several shells ---- */

/* Turn the triangles from `first` on over. */
static void turn_over(int first)
{
    for (int k = first; k < triangles; k++)
        for (int d = 0; d < 3; d++) {
            double second = mesh[9 * k + 3 + d];
            mesh[9 * k + 3 + d] = mesh[9 * k + 6 + d];
            mesh[9 * k + 6 + d] = second;
        }
}

/* A cube from low to high along all axes; inward: it bounds a cavity. */
static void cube(double low, double high, int inward)
{
    const double lo[3] = {low, low, low}, hi[3] = {high, high, high};
    int first = triangles;
    box(lo, hi);
    if (inward) turn_over(first);
}

/* Signed distance from x to that cube. */
static double to_cube(double low, double high, const double *x)
{
    double inside = -HUGE_VAL, square = 0.0;
    for (int d = 0; d < 3; d++) {
        double beyond = fmax(low - x[d], x[d] - high);
        inside = fmax(inside, beyond);
        square += beyond > 0.0 ? beyond * beyond : 0.0;
    }
    return inside > 0.0 ? sqrt(square) : inside;
}

typedef double (*closed_form)(const double *x);

static double overlapping(const double *x) { return fmin(to_cube(0.0, 1.0, x), to_cube(0.6, 1.7, x)); }
static double cavity(const double *x) { return fmax(to_cube(-1.0, 1.0, x), -to_cube(-0.5, 0.25, x)); }
static double island(const double *x) { return fmin(cavity(x), to_cube(-0.25, 0.0, x)); }
static double nested(const double *x) { return to_cube(-1.0, 1.0, x); }
static double filled(const double *x) { return fmin(cavity(x), to_cube(0.0, 1.5, x)); }
static double apart(const double *x) { return fmin(to_cube(-1.5, -0.5, x), to_cube(0.5, 1.5, x)); }

/* Shells that overlap or are nested against set operations on cubes: the signed distance everywhere, but within metal
 * of several shells, where it is none of the true surface and its sign is that of the winding number. */
TEST(shells)
{
    static const struct {
        closed_form of;
        int shells;
        double cube[3][3]; /* low, high, inward */
    } cases[] = {{overlapping, 2, {{0.0, 1.0, 0}, {0.6, 1.7, 0}}},
                 {cavity, 2, {{-1.0, 1.0, 0}, {-0.5, 0.25, 1}}},
                 {island, 3, {{-1.0, 1.0, 0}, {-0.5, 0.25, 1}, {-0.25, 0.0, 0}}},
                 {nested, 2, {{-1.0, 1.0, 0}, {-0.5, 0.25, 0}}},
                 {filled, 3, {{0.0, 1.5, 0}, {-0.5, 0.25, 1}, {-1.0, 1.0, 0}}},
                 {apart, 2, {{-1.5, -0.5, 0}, {0.5, 1.5, 0}}}};
    for (int c = 0; c < 6; c++)
        for (int all_inward = 0; all_inward < 2; all_inward++) {
            uint32_t seed = 5;
            double worst = 0.0;
            int wrong = 0, looked = 0;
            pd_ctx ctx;
            pd_facets f;
            triangles = 0;
            for (int k = 0; k < cases[c].shells; k++)
                cube(cases[c].cube[k][0], cases[c].cube[k][1], (cases[c].cube[k][2] > 0.0) ^ all_inward);
            if (!build(&ctx, &f)) return;
            CHECK_INT(f.shells, cases[c].shells);
            CHECK_INT(f.flipped, all_inward);
            for (int k = 0; k < 20000; k++) {
                double x[3];
                for (int d = 0; d < 3; d++) x[d] = 2.0 * random_real(&seed);
                double expected = cases[c].of(x), found = pdi_facets_distance(&f, x);
                wrong += (found < 0.0) != (expected < 0.0);
                looked += expected < 0.0;
                if (cases[c].of == nested || cases[c].of == filled) {
                    if (expected < 0.0) continue; /* the distance to leave one shell of several */
                }
                worst = fmax(worst, fabs(found - expected));
            }
            CHECK_INT(wrong, 0);
            CHECK(looked > 200);
            CHECK_LE(worst, 1e-15);
            end(&ctx, &f);
        }
}

/* Bodies that touch at a face, an edge or a corner are one body without a wall between them. */
TEST(shells_that_touch)
{
    static const double at[3][3] = {{1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {1.0, 1.0, 1.0}};
    static const double zero[3] = {0.0, 0.0, 0.0}, one[3] = {1.0, 1.0, 1.0};
    for (int k = 0; k < 3; k++) {
        uint32_t seed = 2;
        double hi[3], worst = 0.0;
        int wrong = 0;
        pd_ctx ctx;
        pd_facets f;
        triangles = 0;
        box(zero, one);
        for (int d = 0; d < 3; d++) hi[d] = at[k][d] + 1.0;
        box(at[k], hi);
        if (!build(&ctx, &f)) return;
        CHECK_INT(f.count, k ? 24 : 20); /* two triangles of each at the face between them go */
        for (int n = 0; n < 10000; n++) {
            double x[3], y[3];
            for (int d = 0; d < 3; d++) {
                x[d] = 1.0 + 1.2 * random_real(&seed);
                y[d] = x[d] - at[k][d];
            }
            double expected = fmin(to_cube(0.0, 1.0, x), to_cube(0.0, 1.0, y)), found = pdi_facets_distance(&f, x);
            wrong += (found < 0.0) != (expected < 0.0);
            if (expected > 0.0) worst = fmax(worst, fabs(found - expected));
        }
        CHECK_INT(wrong, 0);
        CHECK_LE(worst, 1e-15);
        end(&ctx, &f);
    }
}

/* Triangles that have shrunk to a line or a point, corners beside each other, and what is turned over. */
TEST(shells_of_rough_files)
{
    pd_ctx ctx;
    pd_facets f;
    double x[3] = {0.5, 0.5, 0.5};
    triangles = 0;
    cube(0.0, 1.0, 0);
    add(mesh, mesh + 3, mesh + 3);
    add(mesh, mesh, mesh);
    if (!build(&ctx, &f)) return;
    CHECK_INT(f.count, 12);
    CHECK_INT(f.merged, 0);
    CHECK_NEAR(pdi_facets_distance(&f, x), -0.5, 1e-15);
    end(&ctx, &f);
    triangles = 12;
    for (int k = 0; k < 9 * triangles; k += 5) mesh[k] += (k % 2 ? 1e-6 : -1e-6); /* all edges are open */
    if (!build(&ctx, &f)) return;
    CHECK_INT(f.count, 12);
    CHECK(f.merged > 5);
    CHECK_NEAR(pdi_facets_distance(&f, x), -0.5, 2e-6);
    end(&ctx, &f);
    triangles = 0; /* one of two bodies is inside out */
    cube(0.0, 2.0, 0);
    cube(3.0, 4.0, 1);
    turned_down(PD_ERR_GEOMETRY, "expected normals that point outward, and into cavities");
    triangles = 0; /* a cavity that leaves its body */
    cube(0.0, 2.0, 0);
    cube(1.5, 2.5, 1);
    turned_down(PD_ERR_GEOMETRY, "expected normals that point outward, and into cavities");
    triangles = 0; /* bodies that touch at an edge, one of them inside out: a shell of both */
    cube(0.0, 1.0, 0);
    double lo[3] = {1.0, 1.0, 0.0}, hi[3] = {1.5, 1.5, 1.0};
    box(lo, hi);
    turn_over(12);
    turned_down(PD_ERR_GEOMETRY, "");
}

/* ---- files ---- */

static char bytes[200000];

/* The mesh as a binary file; its size. */
static size_t binary(void)
{
    uint32_t count = (uint32_t)triangles;
    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, "solid or not", 12);
    for (int k = 0; k < 4; k++) bytes[80 + k] = (char)(count >> (8 * k));
    for (int t = 0; t < triangles; t++)
        for (int n = 0; n < 9; n++) {
            float value = (float)mesh[9 * t + n];
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            for (int k = 0; k < 4; k++) bytes[84 + 50 * t + 12 + 4 * n + k] = (char)(bits >> (8 * k));
        }
    return 84 + 50 * (size_t)triangles;
}

static size_t text(void)
{
    size_t size = (size_t)snprintf(bytes, sizeof bytes, "solid a name of several words\n");
    for (int t = 0; t < triangles; t++) {
        size += (size_t)snprintf(bytes + size, sizeof bytes - size, " facet normal 0 0 nan\n  outer loop\n");
        for (int p = 0; p < 3; p++)
            size += (size_t)snprintf(bytes + size, sizeof bytes - size, "   vertex %.9g %.9g %.9e\r\n",
                                     mesh[9 * t + 3 * p], mesh[9 * t + 3 * p + 1], mesh[9 * t + 3 * p + 2]);
        size += (size_t)snprintf(bytes + size, sizeof bytes - size, "  endloop\n endfacet\n");
    }
    return size + (size_t)snprintf(bytes + size, sizeof bytes - size, "endsolid a name\n");
}

/* 1: the file is accepted. */
static int attempt(const char *data, size_t size)
{
    pd_ctx ctx;
    pd_facets f;
    double x[3] = {0.1, 0.2, 0.3};
    pd_ctx_init(&ctx);
    ctx.alloc.limit = 10000000;
    put("b.stl", data, size);
    pd_status status = pd_facets_read(&ctx, path_of("b.stl"), 1.0, NULL, &f);
    CHECK(status == PD_OK ? f.count > 3 && pdi_facets_distance(&f, x) < HUGE_VAL : f.count == 0 && ctx.message[0]);
    pd_facets_free(&ctx, &f);
    CHECK_INT(ctx.in_use, 0);
    return status == PD_OK;
}

/* Both forms of the file, moved and scaled; cut off behind each byte; with bytes changed. */
TEST(files)
{
    static const double lo[3] = {0.0, 0.25, 0.5}, hi[3] = {1.0, 0.75, 2.0}, shift[3] = {3e-3, 0.0, -1e-3};
    static char copy[sizeof bytes];
    double x[3] = {3.5e-3, 0.5e-3, 0.125e-3};
    uint32_t seed = 4;
    pd_ctx ctx;
    pd_facets f;
    pd_ctx_init(&ctx);
    triangles = 0;
    box(lo, hi);
    for (int form = 0; form < 2; form++) {
        size_t size = form ? text() : binary(), whole = form ? size - 8 : size;
        int early = 0;
        put("a.stl", bytes, size);
        if (!CHECK_OK(&ctx, pd_facets_read(&ctx, path_of("a.stl"), 1e-3, shift, &f))) return;
        CHECK_INT(f.count, 12);
        CHECK_NEAR(pdi_facets_distance(&f, x), -0.25e-3, 1e-18);
        end(&ctx, &f);
        for (size_t k = 0; k < whole; k++) early += attempt(bytes, k) && k < whole - 8;
        CHECK_INT(early, 0);
        for (int k = 0; k < 600; k++) {
            memcpy(copy, bytes, size);
            for (uint32_t n = next_random(&seed) % 3 + 1; n > 0; n--)
                copy[next_random(&seed) % size] = (char)(k % 2 ? next_random(&seed) : (uint32_t)"09 -.e\nv"[n]);
            attempt(copy, size);
        }
    }
    for (int form = 0; form < 4; form++) { /* as programs write them */
        size_t size = form ? text() : binary(), more = 0;
        if (form == 1)
            for (size_t k = 0; k < size; k++)
                if (bytes[k] >= 'a' && bytes[k] <= 'z') bytes[k] = (char)(bytes[k] - 'a' + 'A');
        if (form == 2) memmove(bytes + 3, bytes, size), memcpy(bytes, "\xEF\xBB\xBF", 3), more = 3;
        if (form == 3) memcpy(bytes + size, "\n\0\0\0\x1A \0", 7), more = 7;
        if (form == 0) memcpy(bytes + size, "made by a program", 17), more = 17;
        put("a.stl", bytes, size + more);
        if (!CHECK_OK(&ctx, pd_facets_read(&ctx, path_of("a.stl"), 1e-3, shift, &f))) return;
        CHECK_INT(f.count, 12);
        CHECK_NEAR(pdi_facets_distance(&f, x), -0.25e-3, 1e-18);
        end(&ctx, &f);
    }
    text();
    strcat(bytes, "sold another\n");
    put("a.stl", bytes, strlen(bytes));
    CHECK_INT(pd_facets_read(&ctx, path_of("a.stl"), 1.0, NULL, &f), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "found 'sold', expected solid") != NULL);
    static const char wrong[] = "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0\nvertex 1 0 x";
    put("a.stl", wrong, strlen(wrong));
    CHECK_INT(pd_facets_read(&ctx, path_of("a.stl"), 1.0, NULL, &f), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "a.stl:3: found 'x', expected a coordinate: a finite number") != NULL);
    put("a.stl", "no such thing", 13);
    CHECK_INT(pd_facets_read(&ctx, path_of("a.stl"), 1.0, NULL, &f), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "do not begin with 'solid'") != NULL);
    CHECK_INT(pd_facets_read(&ctx, path_of("a.stl"), 0.0, NULL, &f), PD_ERR_ARGUMENT);
    CHECK_INT(pd_facets_read(&ctx, path_of("none.stl"), 1.0, NULL, &f), PD_ERR_FILE);
}

/* ---- scenes ---- */

#if PD_DIM == 3
#define SCENE(shape) \
    "[grid] h = 1 um  m = 2  box = 0 .. 16 um, 0 .. 12 um, 0 .. 10 um\n[shape a] " shape "  kind = solid\n" \
    "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s * (1 - C/Csat)  Csat = 5e4 mol/m3\n[run] until = 1 s\n"

/* A box of triangles is metal as a box is: the kinds of all nodes, and what dissolves in a second. */
TEST(scenes)
{
    static const double lo[3] = {4.0, 3.0, 2.25}, hi[3] = {11.0, 8.25, 7.0};
    static const char *const texts[2] = {
        SCENE("box = 4 um .. 11 um, 3 um .. 8.25 um, 2.25 um .. 7 um"),
        SCENE("stl = c.stl  scale = 0.5 um  shift = 2 um, 1.5 um, 1.125 um")};
    static double c[2][4000];
    static uint8_t kind[2][100000];
    triangles = 0;
    box(lo, hi);
    for (int k = 0; k < 9 * triangles; k++) mesh[k] = (mesh[k] - 0.5 * lo[k % 3]) * 2.0; /* 2 x - lo, shift lo/2 */
    put("c.stl", bytes, binary());
    for (int k = 0; k < 2; k++) {
        pd_ctx ctx;
        pd_sim sim;
        pd_field_view view;
        pd_ctx_init(&ctx);
        ctx.threads = 1;
        put("a.scene", texts[k], strlen(texts[k]));
        if (!CHECK_OK(&ctx, pd_sim_open(&ctx, path_of("a.scene"), NULL, 0, &sim))) return;
        CHECK(sim.model.grid.total < 100000);
        memcpy(kind[k], sim.model.grid.kind, (size_t)sim.model.grid.total);
        if (k) CHECK(memcmp(kind[0], kind[1], (size_t)sim.model.grid.total) == 0);
        for (int n = 0; n < 5; n++) CHECK_OK(&ctx, pd_sim_step(&ctx, &sim, 1.0));
        CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, "C", &view));
        for (int n = 0; n < 16 * 12 * 10; n++) c[k][n] = view.data[n];
        pd_sim_close(&ctx, &sim);
        CHECK_INT(ctx.in_use, 0);
    }
    double most = 0.0, off = 0.0;
    for (int n = 0; n < 16 * 12 * 10; n++) {
        most = fmax(most, c[0][n]);
        off = fmax(off, fabs(c[1][n] - c[0][n]));
    }
    CHECK(most > 0.0);
    CHECK_LE(off, 1e-9 * most); /* the tolerance of solvers */
}

/* Set operations, and what scenes get wrong. */
TEST(bad_scenes)
{
    static const double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {4.0, 4.0, 4.0};
    triangles = 0;
    box(lo, hi);
    put("c.stl", bytes, binary());
    pd_ctx ctx;
    pd_setup u;
    double x[3] = {3e-6, 3e-6, 3e-6};
    const char *both = SCENE("box = 1 um .. 9 um, 1 um .. 9 um, 1 um .. 9 um\n[shape b] stl = c.stl  scale = 1 um\n"
                             "[shape c] difference = a, b");
    if (!CHECK_OK(&ctx, load(&ctx, both, NULL, 0, &u))) return;
    CHECK_NEAR(pd_shape_distance(u.shape, u.solid, x), 1e-6, 1e-20);
    leave(&ctx, &u);
    refused(SCENE("stl = c.stl"), "scale");
    refused(SCENE("stl = c.stl  scale = 0 um"), "expected a positive value");
    refused(SCENE("stl = none.stl  scale = 1 um"), "stl: ");
    refused(SCENE("stl = c.stl  scale = 1 um  shift = 1 um"), "found 1 number, expected 3");
    put("c.stl", bytes, 84 + 50 * 11);
    refused(SCENE("stl = c.stl  scale = 1 um"), "the file ends");
    triangles = 11;
    put("c.stl", bytes, binary());
    refused(SCENE("stl = c.stl  scale = 1 um"), "is not closed");
}
#define SCENES ENTRY(scenes) ENTRY(bad_scenes)
#else
TEST(not_in_2d)
{
    pd_ctx ctx;
    pd_setup u;
    CHECK(load(&ctx, "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n"
                     "[shape a] stl = c.stl  scale = 1 um  kind = wall\n", NULL, 0, &u) < 0);
    CHECK(strstr(ctx.message, "found a surface in 2D, expected 3D") != NULL);
    CHECK_INT(ctx.in_use, 0);
}
#define SCENES ENTRY(not_in_2d)
#endif

TEST_MAIN(ENTRY(boxes) ENTRY(zeros) ENTRY(lines) ENTRY(lines_through_a_torus)
          ENTRY(tori) ENTRY(tetrahedra) ENTRY(not_closed) ENTRY(shells)
          ENTRY(shells_that_touch) ENTRY(shells_of_rough_files) ENTRY(files) SCENES)
