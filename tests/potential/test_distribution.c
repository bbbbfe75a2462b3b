/* distribution: currents around shapes: circles, surfaces at an angle, rings, coplanar couples (Waber 1954), Newman's
 * disc.
 * dims: 2 3 */
#include "metal/entry.h"
#include "potential_cell.h"

#if PD_DIM == 2
/* ---- circles and walls at an angle ---- */

static double centre[2];
static int is_outer(const double *x) { return hypot(x[0] - centre[0], x[1] - centre[1]) > 0.7e-3; }

/* Rod of 0.4 mm in a ring of 1 mm, n cells in all, moved by a part of a cell. */
static void circles(double m, int n, double move)
{
    double h = 2.4e-3 / n;
    scene_box(&S, m, h, n, n, 1);
    for (int k = 0; k < 2; k++) {
        centre[k] = (0.5 * n + move * (k ? 0.6 : 1.0)) * h;
        S.shapes[k].type = PD_SHAPE_BALL;
        S.shapes[k].radius = k ? 1e-3 : 0.4e-3;
    }
    for (int k = 0; k < 4; k++) S.shapes[k % 2].a[k / 2] = centre[k / 2];
    S.shapes[2].type = PD_SHAPE_COMPLEMENT;
    S.shapes[2].child_count = 1;
    S.shapes[2].child[0] = 1;
    S.shapes[3].type = PD_SHAPE_UNION;
    S.shapes[3].child_count = 2;
    S.shapes[3].child[0] = 0;
    S.shapes[3].child[1] = 2;
    solid(3);
}

/* Share by which the current between two circles is off, with straight lines or with Tafel curves. */
static double circle_error(double m, int n, double move, int curved)
{
    double r0 = 0.4e-3, r1 = 1e-3, kappa = 5.0, lo = 0.0, hi = 1e6, area = 0.0;
    pd_electrode_term a = linear(1e-4, 0.0), b = a;
    if (curved) {
        a = tafel(20.0, -0.2, 0.05, 0.04);
        b = tafel(10.0, 0.1, 0.06, 0.05);
    }
    circles(m, n, move);
    begin(kappa);
    electrode(0, &a, 1, 0.0);
    electrode(1, &b, 1, 0.0);
    circuit(0, PD_CIRCUIT_POTENTIAL, 1.0);
    circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
    if (!ready(is_outer) || !solve()) return 1.0;
    for (int k = 0; k < 100; k++) { /* a source far off drives its current through a curve, whose u is asked for */
        double i = 0.5 * (lo + hi), u = 0.0, v = 0.0, by;
        pdi_electrode_through(&X.e[0], 1.0, 1e9, 1e9 / (i / (2.0 * PI * r0)), &u, &by);
        pdi_electrode_through(&X.e[1], 1.0, -1e9, 1e9 / (i / (2.0 * PI * r1)), &v, &by);
        if (u - v + i * log(r1 / r0) / (2.0 * PI * kappa) < 1.0) lo = i;
        else hi = i;
    }
    double error = X.p.total[0] / hi - 1.0;
    for (int32_t k = 0; k < X.p.contacts.count; k++)
        if (X.p.contacts.list[k].electrode == 0) area += X.p.contacts.list[k].area * S.stencil.volume;
    CHECK_REL(area, 2.0 * PI * r0, n < 40 ? 0.02 : 0.01);
    done();
    return error;
}

TEST(circle_currents)
{
    static const double most[3] = {0.0075, 0.004, 0.002};
    for (int curved = 0; curved < 2; curved++)
        for (int m = 1; m < 4; m += 2)
            for (int k = 0; k < 3; k++) {
                double worst = 0.0;
                for (int move = k == 2 ? 2 : 0; move < 3; move++)
                    worst = fmax(worst, fabs(circle_error(m, 24 << k, move / 3.0, curved)));
                NOTE("%s, m = %d, %d cells across: %.4f", curved ? "Tafel" : "linear", m, 24 << k, worst);
                CHECK_LE(worst, most[k]);
            }
}

/* The same bits with any number of threads. */
TEST(threads)
{
    static double phi[CELLS];
    double total = 0.0;
    for (int k = 0; k < 3; k++) {
        pd_electrode_term a = tafel(20.0, -0.2, 0.05, 0.04);
        circles(2.0, 240, 0.1);
        S.ctx.threads = 1 + k;
        begin(5.0);
        electrode(0, &a, 1, 0.0);
        electrode(1, &a, 1, 0.0);
        circuit(0, PD_CIRCUIT_POTENTIAL, 1.0);
        circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
        if (!ready(is_outer) || !solve()) return;
        if (k == 0) memcpy(phi, X.p.phi, (size_t)S.grid.total * sizeof *phi);
        if (k == 0) total = X.p.total[0];
        CHECK(memcmp(phi, X.p.phi, (size_t)S.grid.total * sizeof *phi) == 0);
        CHECK_NEAR(X.p.total[0], total, 0.0);
        done();
    }
}

/* Area of a half-space between two normals of its edge, from its zero level and from its cells alone. */
static double flat_area(double degrees, double m, int n, int cells, double move)
{
    static uint8_t mask[200 * 200];
    double turn = degrees * PI / 180.0, c = cos(turn), s = sin(turn), sum = 0.0, h = 1.0 / n, half = 0.3;
    pd_electrode_term a = linear(1.0, 0.0);
    scene_box(&S, m, h, n, n, 1);
    S.grid_desc.ghost = 4;
    S.shapes[0].type = PD_SHAPE_HALF_SPACE;
    S.shapes[0].a[0] = 0.5 + move * h;
    S.shapes[0].a[1] = 0.5 - 0.37 * move * h;
    S.shapes[0].b[0] = -s;
    S.shapes[0].b[1] = c;
    if (cells) {
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++) {
                double x = (i + 0.5) * h - S.shapes[0].a[0], y = (j + 0.5) * h - S.shapes[0].a[1];
                mask[j * n + i] = -s * x + c * y < 0.0;
            }
        S.shapes[0].type = PD_SHAPE_VOXELS;
        for (int d = 0; d < 2; d++) {
            S.shapes[0].a[d] = 0.0;
            S.shapes[0].b[d] = h;
            S.shapes[0].mask_size[d] = n;
        }
        S.shapes[0].mask = mask;
    }
    solid(0);
    begin(1.0);
    electrode(0, &a, 1, 0.0);
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    static pd_stencil wide;
    pd_stencil_desc wd = S.stencil_desc;
    wd.m = 3.0;
    if (!CHECK_OK(&S.ctx, pd_stencil_build(&S.ctx, &wd, &wide))) return 0.0;
    X.desc.wide = &wide;
    if (!ready(NULL)) return 0.0;
    for (int32_t k = 0; k < X.p.contacts.count; k++) {
        double x[2];
        pd_grid_position(&S.grid, X.p.contacts.list[k].node, x);
        double along = fabs((x[0] - 0.5) * c + (x[1] - 0.5) * s), share = (half - along) / h * 0.25 + 0.5;
        sum += X.p.contacts.list[k].area * h * h * fmin(fmax(share, 0.0), 1.0);
    }
    pd_stencil_free(&S.ctx, &wide);
    done();
    return sum / (2.0 * half) - 1.0;
}

TEST(flat_areas)
{
    static const double degrees[3] = {0.0, 27.0, 45.0};
    for (int cells = 0; cells < 2; cells++)
        for (int k = 0; k < 3; k++)
            for (int m = 1; m < 4; m += 2) {
                double worst = 0.0;
                for (int move = 0; move < 3; move++)
                    worst = fmax(worst, fabs(flat_area(degrees[k], m, 120, cells, move / 3.0)));
                NOTE("%s, %g degrees, m = %d: area off by %.4f", cells ? "cells" : "level", degrees[k], m, worst);
                CHECK_LE(worst, cells ? 0.015 : 0.006);
            }
}

/* Areas of discs are those by which metal dissolves (10.5), to the anisotropy of these. */
TEST(areas_of_dissolution)
{
    for (int r = 6; r <= 24; r *= 2)
        for (int m = 1; m < 4; m += 2) {
            pd_stencil wide;
            pd_bond_paths paths;
            pd_contacts contacts;
            pdi_contact_metal metal = {NULL, NULL, NULL};
            double dissolves = 0.0, area = 0.0;
            scene_box(&S, m, 1.0, 2 * r + 14, 2 * r + 14, 1);
            S.grid_desc.ghost = 4;
            S.shapes[0].type = PD_SHAPE_BALL;
            S.shapes[0].radius = r;
            for (int d = 0; d < 2; d++) S.shapes[0].a[d] = r + 7.3;
            solid(0);
            if (!scene_build(&S)) return;
            pd_stencil_desc wd = S.stencil_desc;
            wd.m = 3.0;
            if (!CHECK_OK(&S.ctx, pd_stencil_build(&S.ctx, &wd, &wide))) return;
            if (!CHECK_OK(&S.ctx, pdi_bond_path_build(&S.ctx, &wide, &S.grid, &paths))) return;
            for (int32_t j = 0; j < S.grid.total; j++)
                for (int k = 0; k < wide.count && S.grid.kind[j] == PD_SOLID; k++) {
                    pdi_entry entry;
                    pdi_entry_find(&paths, j, k, &entry);
                    if (entry.count) dissolves += wide.area_weight[k];
                }
            metal.wide = &wide;
            memset(&contacts, 0, sizeof contacts);
            CHECK_OK(&S.ctx, pdi_contact_find(&S.ctx, &S.bonds, &metal, &contacts));
            for (int32_t k = 0; k < contacts.count; k++) area += contacts.list[k].area;
            CHECK_REL(area, 2.0 * PI * r, 0.004);
            CHECK_REL(area, dissolves, 0.01);
            pdi_contact_free(&S.ctx, &contacts);
            pdi_bond_path_free(&S.ctx, &paths);
            pd_stencil_free(&S.ctx, &wide);
            scene_free(&S);
        }
}

/* ---- couples and discs ---- */

static int is_cathode(const double *x) { return x[0] > 0.5; }

/* Total of a coplanar couple with equal slopes (Waber 1954), and the largest error of the current density. */
static double coplanar(double m, int n, double length, double *local)
{
    double h = 1.0 / n, lo[2] = {0.0, 0.0}, hi[2] = {1.0, 0.0}, worst = 0.0;
    pd_electrode_term a = linear(length, 1.0), b = linear(length, 0.0);
    scene_box(&S, m, h, n, n + 4, 1);
    hi[1] = 4.0 * h;
    scene_solid_box(&S.shapes[0], lo, hi);
    solid(0);
    begin(1.0);
    X.member[1] = 0;
    electrode(0, &a, 1, 0.0);
    electrode(1, &b, 1, 0.0);
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    if (!ready(is_cathode) || !solve()) return 0.0;
    double sum = 0.0;
    for (int32_t k = 0; k < X.p.contacts.count; k++) {
        double x[2], i = 0.0;
        const pd_contact *c = &X.p.contacts.list[k];
        pd_grid_position(&S.grid, c->node, x);
        if (c->electrode == 0) sum -= X.p.current[k] * c->area * h * h;
        for (int w = 1; w < 4000; w++) { /* current density there, by the series */
            double q = w * PI;
            i += 2.0 * sin(0.5 * q) / q * q * tanh(q) / (1.0 + length * q * tanh(q)) * cos(q * x[0]);
        }
        if (fabs(x[0] - 0.5) > 0.1) worst = fmax(worst, fabs(fabs(X.p.current[k]) - fabs(i)));
    }
    *local = worst;
    done();
    return fabs(sum);
}

TEST(coplanar_couples)
{
    static const double length[3] = {1.0, 0.1, 0.01}, total[3] = {0.19787, 0.77648, 1.50366};
    for (int k = 0; k < 3; k++) {
        double last = 0.0;
        for (int n = k == 2 ? 128 : 32; n <= (k == 2 ? 256 : 64); n *= 2) {
            double local = 0.0, off = coplanar(1.0, n, length[k], &local) / total[k] - 1.0;
            NOTE("L/c = %g, n = %d: total off by %.5f, density by %.5f", length[k], n, off, local);
            if (last < 0.0) CHECK(off / last > 0.2 && off / last < 0.45); /* orders of 1.2 to 2 */
            last = off;
        }
        CHECK_LE(fabs(last), 0.01);
    }
}
#endif

/* ---- Newman's disc: on rings, and a quarter of it in space ---- */

static int is_ball(const double *x) { return x[0] > 0.0 && pdi_vec_norm(x) > 2.0; }

/* A disc of n cells radius in an insulating plane, inside a hemisphere of three radii, where its current goes like that
 * of a point, so that what lies beyond adds 1/(2 pi kappa r). Returns the total resistance times kappa and radius;
 * density: over its mean. j: of Newman, 0: no overpotential. */
static double disc(double m, int n, double j, double *density)
{
    static pd_shape shapes[7];
    double h = 1.0 / n, far = 3.0;
    int layer = 4, cells = (int)(far * n) + layer;
    pd_electrode_term a = linear(j > 0.0 ? 1.0 / j : 1.0, 0.0);
    scene_box(&S, m, h, cells + layer, cells, cells);
    S.grid_desc.axisymmetric = PD_DIM == 2;
    S.grid_desc.lo[0] = -layer * h;
    S.grid_desc.hi[0] = cells * h;
    for (int d = 1; d < PD_DIM; d++) S.grid_desc.side[2 * d] = PD_SIDE_MIRROR;
    memset(shapes, 0, sizeof shapes);
    shapes[0].type = PD_SHAPE_HALF_SPACE;
    shapes[0].b[0] = 1.0;
    shapes[1].type = PD_SHAPE_CYLINDER;
    shapes[1].radius = 1.0;
    shapes[2].type = PD_SHAPE_BALL;
    shapes[2].radius = far;
    shapes[3].type = PD_SHAPE_COMPLEMENT;
    shapes[3].child[0] = 2;
    shapes[4].type = PD_SHAPE_INTERSECT;
    shapes[5].type = PD_SHAPE_DIFFERENCE;
    shapes[6].type = PD_SHAPE_UNION;
    shapes[4].child[1] = shapes[5].child[1] = 1;
    shapes[6].child[0] = 3;
    shapes[6].child[1] = 4;
    for (int k = 3; k < 7; k++) shapes[k].child_count = k == 3 ? 1 : 2;
    S.grid_desc.shapes = shapes;
    S.grid_desc.wall = &shapes[5];
    S.grid_desc.solid = &shapes[6];
    begin(1.0);
    electrode(0, &a, j > 0.0, 0.0);
    electrode(1, &a, 0, 0.0);
    circuit(0, PD_CIRCUIT_POTENTIAL, 1.0);
    circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
    if (!ready(is_ball) || !solve()) return 0.0;
    for (int32_t k = 0; k < X.p.contacts.count && density; k++) {
        double x[PD_DIM];
        pd_grid_position(&S.grid, X.p.contacts.list[k].node, x);
        int r = (int)(x[1] * n);
        if (X.p.contacts.list[k].electrode == 0 && r < n && x[0] < h) density[r] = X.p.current[k] / (X.p.total[0] / PI);
    }
    double resist = 1.0 / (X.p.total[0] * (PD_DIM == 2 ? 1.0 : 4.0)) + 1.0 / (2.0 * PI * far);
    done();
    return resist;
}

#if PD_DIM == 3
TEST(disc_in_space)
{
    static const double j[2] = {1.0, 0.0}, total[2] = {0.58592, 0.25};
    for (int k = 0; k < 2; k++) {
        double off = disc(1.0, 8, j[k], NULL) / total[k] - 1.0;
        NOTE("J = %g, 8 cells: resistance off by %.4f", j[k], off);
        CHECK_LE(fabs(off), k ? 0.06 : 0.02);
    }
}
#else
TEST(discs)
{
    static const double j[3] = {1.0, 10.0, 0.0}, total[3] = {0.58592, 0.29115, 0.25};
    static const double at[5] = {0.0, 0.2, 0.4, 0.6, 0.8}, profile[3][5] = {{0.8826, 0.8895, 0.9115, 0.9528, 1.0253},
                                                                           {0.6221, 0.6357, 0.6804, 0.7789, 1.0137},
                                                                           {0.5000, 0.5103, 0.5455, 0.6250, 0.8333}};
    for (int k = 0; k < 3; k++)
        for (int m = 1; m < 4; m += 2) {
            double last = 0.0;
            for (int n = 16; n <= 32; n *= 2) {
                double density[64], off = disc(m, n, j[k], density) / total[k] - 1.0, worst = 0.0;
                for (int a = 0; a < 5; a++) {
                    double r = at[a] * n - 0.5, part = r < 0.0 ? 0.0 : r - floor(r);
                    int cell = r < 0.0 ? 0 : (int)r;
                    double here = (1.0 - part) * density[cell] + part * density[cell + 1];
                    worst = fmax(worst, fabs(here / profile[k][a] - 1.0));
                }
                NOTE("J = %g, m = %d, %d cells: resistance off by %.5f, density up to 0.8 a by %.4f, at the edge %.3f",
                     j[k], m, n, off, worst, density[n - 1]);
                CHECK_LE(fabs(off), k == 2 ? 0.3 / n : 0.006);
                if (m == 1) CHECK_LE(worst, k == 2 ? 1.5 / n : 0.02);
                if (k == 2 && n == 32) CHECK_NEAR(last / off, 2.0, 0.2); /* order 1, that of the singular edge */
                last = off;
            }
        }
}
#endif

#if PD_DIM == 2
/* Plates across the axis of a ring lattice: the same at all radii. */
TEST(rings)
{
    for (int m = 1; m < 4; m++) {
        double h = 1e-4, kappa = 1.3, worst = 0.0;
        pd_electrode_term a = linear(1e-4, -0.4), b = linear(2e-4, 0.3);
        plates(m, h, 19, 4.1, 14.7);
        S.grid_desc.axisymmetric = 1;
        S.grid_desc.hi[1] = 8.0 * h;
        begin(kappa);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        X.member[1] = 0;
        circuit(0, PD_CIRCUIT_CURRENT, 0.0);
        S.grid_desc.side[3] = PD_SIDE_WALL;
        if (!ready(is_right) || !solve()) return;
        double i = 0.7 / (3e-4 + 10.6 * h / kappa);
        for (int32_t n = 0; n < X.p.contacts.count; n++) {
            double x[2];
            pd_grid_position(&S.grid, X.p.contacts.list[n].node, x);
            if (x[1] < 4.0 * h) worst = fmax(worst, fabs(fabs(X.p.current[n]) / i - 1.0));
        }
        /* the corner between metal and wall costs a little */
        CHECK_REL(X.r.anodic / (PI * 64.0 * h * h), i, 0.004);
        CHECK_LE(worst, 0.002 + 0.016 * (m - 1));
        done();
    }
}
#endif

#if PD_DIM == 2
TEST_MAIN(ENTRY(circle_currents) ENTRY(threads) ENTRY(flat_areas) ENTRY(areas_of_dissolution)
          ENTRY(rings) ENTRY(coplanar_couples) ENTRY(discs))
#else
TEST_MAIN(ENTRY(disc_in_space))
#endif
