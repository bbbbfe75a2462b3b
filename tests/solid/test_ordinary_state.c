/* test_ordinary_state: the linear peridynamic solid: moduli of lattices, surfaces, forces and their derivative, closed
 * forms. dims: 1 2 3 */
#include "ordinary_case.h"
#include "solid/body_bonds.h"
#include "solid/equilibrium.h"
#include "solid/ordinary_state.h"
#include "solid/bond_stretch.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

static pd_ordinary_state material;
static const char *const methods[4] = {"position", "none", "energy", "volume"};

static int make(solid_case *c, const pd_ordinary_state_desc *desc, pd_material_interface *s)
{
    if (!CHECK_OK(&c->ctx, pd_ordinary_state_build(&c->ctx, &c->body, desc, &material))) return 0;
    *s = pd_ordinary_state_material(&material);
    return 1;
}

static pd_ordinary_state_desc steel(double nu, int plane, int influence, int surface)
{
    pd_ordinary_state_desc d;
    memset(&d, 0, sizeof d);
    d.young = 200e9;
    d.poisson = nu;
    d.plane = (pd_plane)plane;
    d.influence = (pd_influence)influence;
    d.surface = (pd_ordinary_state_surface)surface;
    d.linear = 1;
    return d;
}

static void end(solid_case *c)
{
    pd_ordinary_state_free(&c->ctx, &material);
    case_end(c);
}

static int cells(void) { return PD_DIM == 1 ? 40 : PD_DIM == 2 ? 18 : 9; }

/* Stress and energy density of Hooke's law; 1D is a bar. */
static double wanted(const double *g, double *p)
{
    if (PD_DIM > 1) return hooke(material.lambda, material.mu, g, p);
    p[0] = material.desc.young * g[0];
    return 0.5 * p[0] * g[0];
}

static double largest(const double *a, int n)
{
    double most = 0.0;
    for (int k = 0; k < n; k++) most = fmax(most, fabs(a[k]));
    return most;
}

static double total(const double *a, int n)
{
    double sum = 0.0;
    for (int k = 0; k < n; k++) sum += a[k];
    return sum;
}

/* ---- moduli ---- */

/* The bulk modulus, and the mean of the shear modulus over all rotations, of a lattice without any mending: for all
 * horizons and influences. Their ratios are those of an independent computation, to its digits. */
#if PD_DIM > 1
typedef struct lattice_row {
    double m;
    int part, influence;
    double diagonal, axis; /* C'/mu, C44/mu */
} lattice_row;

static const lattice_row rows[] = { /* data: lattice_lps_shear.csv; influences 1, horizon/r, 1 - r/horizon */
#if PD_DIM == 2
    {2, 0, 0, 1.4286, 0.57143}, {2, 0, 2, 0.92099, 1.079}, {2, 0, 1, 1.3592, 0.64075},
    {2, 1, 0, 1.0342, 0.96584}, {2, 1, 1, 1.0556, 0.94444}, {3, 0, 0, 1.0353, 0.96471},
    {3, 0, 2, 0.96243, 1.0376}, {3, 0, 1, 1.0343, 0.96567}, {3, 1, 0, 1.0362, 0.96376},
    {3, 1, 1, 1.0369, 0.9631}, {3.015, 0, 0, 1.0353, 0.96471}, {3.015, 0, 2, 0.96442, 1.0356},
    {3.015, 0, 1, 1.0343, 0.96567}, {3.015, 1, 0, 1.0385, 0.96145}, {3.015, 1, 1, 1.0384, 0.96157},
    {4, 0, 0, 1.0468, 0.95321}, {4, 0, 2, 0.97458, 1.0254}, {4, 0, 1, 1.0372, 0.96284},
    {4, 1, 0, 1.006, 0.99404}, {4, 1, 1, 1.009, 0.99104},
#endif
#if PD_DIM == 3
    {2, 0, 0, 1.1538, 0.89744}, {2, 0, 2, 0.89797, 1.068}, {2, 0, 1, 1.1389, 0.90743},
    {2, 1, 0, 1.0638, 0.95745}, {2, 1, 1, 1.0728, 0.95147}, {3, 0, 0, 0.83475, 1.1102},
    {3, 0, 2, 1.0031, 0.99796}, {3, 0, 1, 0.87065, 1.0862}, {3, 1, 0, 1.0168, 0.98878},
    {3, 1, 1, 1.0172, 0.98855}, {3.015, 0, 0, 0.83475, 1.1102}, {3.015, 0, 2, 0.99716, 1.0019},
    {3.015, 0, 1, 0.87065, 1.0862}, {3.015, 1, 0, 1.0181, 0.98791}, {3.015, 1, 1, 1.0181, 0.98791},
    {4, 0, 0, 0.97137, 1.0191}, {4, 0, 2, 0.98806, 1.008}, {4, 0, 1, 0.97873, 1.0142},
    {4, 1, 0, 0.99971, 1.0002}, {4, 1, 1, 1.0016, 0.99894},
#endif
};

TEST(lattice)
{
    double worst = 0.0, mean = 0.0, bulk = 0.0;
    for (int k = 0; k < (int)(sizeof rows / sizeof rows[0]); k++) {
        const lattice_row *row = &rows[k];
        int wide = 2 * (int)(row->m + 0.49) + 1, n[3] = {wide, wide, wide};
        pd_material_interface s;
        solid_case *c = box(n, 1e-3, row->m, row->part);
        pd_ordinary_state_desc d = steel(0.3, k & 1, row->influence, PD_ORDINARY_STATE_NONE);
        d.isotropic_off = 1;
        if (!c || !make(c, &d, &s)) return;
        double found[3];
        for (int q = 0; q < 3; q++) { /* all around, along the axes, between them */
            double g[T] = {0.0}, *p = c->stress + c->body.count / 2 * T;
            g[0] = q < 2 ? 1e-3 : 0.0;
            g[PD_DIM + 1] = q == 0 ? 1e-3 : q == 1 ? -1e-3 : 0.0;
            if (q == 0) g[T - 1] = 1e-3;
            if (q == 2) g[1] = g[PD_DIM] = 1e-3;
            linear(c, g, c->u);
            s.stress(&c->ctx, s.self, c->u, c->stress);
            found[q] = q == 0 ? p[0] / (1e-3 * (PD_DIM * material.lambda + 2.0 * material.mu))
                              : p[q == 1 ? 0 : 1] / (2e-3 * material.mu);
        }
        double average = PD_DIM == 2 ? 0.5 * (found[1] + found[2]) : 0.4 * found[1] + 0.6 * found[2];
        bulk = fmax(bulk, fabs(found[0] - 1.0));
        mean = fmax(mean, fabs(average - 1.0));
        worst = fmax(worst, fmax(fabs(found[1] / row->diagonal - 1.0), fabs(found[2] / row->axis - 1.0)));
        if (row->part) CHECK_REL(material.anisotropy, found[2] / found[1], 1e-6); /* from floats */
        end(c);
    }
    NOTE("K %.1e, mean of mu %.1e, ratios to the table %.1e", bulk, mean, worst);
    CHECK_LE(bulk, 1e-12);
    CHECK_LE(mean, 1e-12);
    CHECK_LE(worst, 6e-5); /* five digits */
}

/* Weights by direction leave nothing of the lattice in any modulus, but for their rounding; the position method needs
 * none. */
TEST(isotropy)
{
    for (int way = 0; way < 12; way++) {
        int surface = way / 3, wide = PD_DIM == 3 ? 7 : 9, n[3] = {wide, wide, wide};
        uint32_t seed = 5;
        pd_material_interface s;
        solid_case *c = box(n, 1e-3, 2.5 + (PD_DIM == 2 ? way % 2 : 0), 1.0);
        pd_ordinary_state_desc d = steel(0.42, way & 1, way % 3, surface);
        if (!c || !make(c, &d, &s)) return;
        CHECK_NEAR(material.anisotropy, 1.0, 1e-6);
        double off = 0.0;
        for (int q = 0; q < 4; q++) {
            double g[T], p[T];
            for (int k = 0; k < T; k++) g[k] = random_real(&seed);
            wanted(g, p);
            linear(c, g, c->u);
            s.stress(&c->ctx, s.self, c->u, c->stress);
            for (int k = 0; k < T; k++) off = fmax(off, fabs(c->stress[c->body.count / 2 * T + k] - p[k]));
            off /= largest(p, T);
        }
        /* with the energy and the volume method the cut families around make up for one another at their bonds */
        CHECK_LE(off, surface == 0 ? 1e-12 : surface == 1 ? 1e-6 : 1.0);
        end(c);
    }
}
#endif

/* ---- surfaces ---- */

/* Uniform strain in a body of any shape with any points: stress at each of them and the energy are those of Hooke's
 * law; with the method of positions, for any Poisson ratio, influence and horizon. Edges add up to the normals. */
TEST(uniform)
{
    static const double ratios[4] = {0.0, 0.25, 0.499, -0.5};
    uint32_t seed = 8;
    double stress = 0.0, energy = 0.0, edge = 0.0;
    for (int way = 0; way < (PD_DIM == 3 ? 12 : 24); way++) {
        double g[T], p[T], sum[T] = {0.0};
        pd_material_interface s;
        solid_case *c = block(cells(), 2.0 + way % 3 * 0.75, way & 1, way & 2 ? 0.4 : 0.0);
        pd_ordinary_state_desc d = steel(ratios[way % 4], way >> 2 & 1, way % 3, PD_ORDINARY_STATE_POSITION);
        if (!c || !make(c, &d, &s)) return;
        for (int k = 0; k < T; k++) g[k] = random_real(&seed);
        double density = wanted(g, p), volume = total(c->volume, c->body.count);
        linear(c, g, c->u);
        s.stress(&c->ctx, s.self, c->u, c->stress);
        for (int k = 0; k < T * c->body.count; k++)
            stress = fmax(stress, fabs(c->stress[k] - p[k % T]) / largest(p, T));
        energy = fmax(energy, fabs(s.energy(&c->ctx, s.self, c->u) / (density * volume) - 1.0));
        for (int32_t i = 0; i < c->body.count; i++)
            for (int k = 0; k < T; k++)
                sum[k] +=
                    c->volume[i] * s.surface_vector[i * PD_DIM + k / PD_DIM] * c->position[i * PD_DIM + k % PD_DIM];
        for (int k = 0; k < T; k++)
            edge = fmax(edge, fabs(sum[k] / volume + (k / PD_DIM == k % PD_DIM ? 1.0 : 0.0)));
        end(c);
    }
    NOTE("stress %.1e, energy %.1e, edges %.1e", stress, energy, edge);
    CHECK_LE(stress, 1e-11);
    CHECK_LE(energy, 1e-12);
    CHECK_LE(edge, 1e-11);
}

#if PD_DIM == 2
/* The methods side by side on a plate under tension with free sides: the error of stress and energy of a uniform
 * strain, and of displacements and stress of the solution. */
TEST(methods)
{
    static const double ratios[2] = {0.25, 0.45};
    int n[3] = {40, 20, 1};
    for (int way = 0; way < 8; way++) {
        double g[T] = {1.0, 0.3, 0.2, -0.4}, p[T], error = 0.0, size = 0.0, off = 0.0, solved = 0.0;
        pd_material_interface s;
        solid_case *c = box(n, 0.05, 3.0, 1.0);
        pd_ordinary_state_desc d = steel(ratios[way / 4], PD_PLANE_STRAIN, PD_INFLUENCE_CONSTANT, way % 4);
        d.young = 1.0;
        clock_t start = clock();
        if (!c || !make(c, &d, &s)) return;
        double density = wanted(g, p), volume = total(c->volume, c->body.count);
        double build = (double)(clock() - start) / CLOCKS_PER_SEC;
        linear(c, g, c->u);
        s.stress(&c->ctx, s.self, c->u, c->stress);
        for (int k = 0; k < T * c->body.count; k++) off = fmax(off, fabs(c->stress[k] - p[k % T]) / largest(p, T));
        double energy = s.energy(&c->ctx, s.self, c->u) / (density * volume) - 1.0;
        double trace = material.lambda / (2.0 * material.lambda + 2.0 * material.mu);
        memset(c->u, 0, sizeof c->u);
        for (int32_t i = 0; i < c->body.count; i++) c->load[i * 2] = -s.surface_vector[i * 2];
        start = clock();
        int steps = case_solve(c, &s, 1e-13);
        double solve = (double)(clock() - start) / CLOCKS_PER_SEC;
        s.stress(&c->ctx, s.self, c->u, c->stress);
        for (int k = 0; k < c->body.count * 2; k++) {
            double exact = ((k % 2 ? 0.0 : 1.0) - trace) / (2.0 * material.mu) * c->position[k];
            error += (c->u[k] - exact) * (c->u[k] - exact);
            size += exact * exact;
        }
        for (int k = 0; k < c->body.count * 4; k++) solved = fmax(solved, fabs(c->stress[k] - (k % 4 ? 0.0 : 1.0)));
        NOTE("nu %.2f, %-8s: uniform strain: stress %.1e, energy %+.1e; tension: u %.1e, stress %.1e, build %.3f s, %d "
             "iterations in %.3f s", ratios[way / 4], methods[way % 4], off, energy, sqrt(error / size), solved, build,
             steps, solve);
        if (way % 4 == 0) CHECK_LE(off, 1e-12);
        if (way % 4 == 0) CHECK_LE(fabs(energy), 1e-12);
        CHECK_LE(sqrt(error / size), way % 4 == 0 ? 0.02 : 0.07);
        end(c);
    }
}
#endif

/* 1 - r/|Y| has all digits on both sides of the end of its series, and the stretch that follows from it, too. */
TEST(lengths)
{
    for (int k = -600; k <= 2000; k++) {
        double e = k % 2 ? k / 1000.0 : ldexp(1.0 + k / 2000.0, -6 - abs(k) % 40), p = pdi_bond_stretch_factor(e);
        long double root = sqrtl(1.0L + e), pull = e / (root * (1.0L + root)), stretch = e / (1.0L + root);
        CHECK(fabsl(p - pull) <= 4.0L * DBL_EPSILON * fabsl(pull));
        CHECK(fabsl(p * (1.0 + e) * (1.0 - p) - stretch) <= 12.0L * DBL_EPSILON * fabsl(stretch));
    }
}

/* A box whose rim, two horizons wide, is stretched by a fifth along all axes: Newton's method finds that the inside is,
 * too, and the stress of all points, at free surfaces as inside, is the closed form over the deformed area. */
TEST(stretched)
{
    static uint8_t held[MOST * PD_DIM];
    pd_material_interface s;
    pd_equilibrium_desc of;
    pd_equilibrium_result result;
    int n[3] = {12, 13, 11};
    uint32_t seed = 9;
    solid_case *c = box(n, 1e-4, 2.0, 1.0);
    pd_ordinary_state_desc d = steel(0.3, 0, 0, PD_ORDINARY_STATE_POSITION);
    d.linear = 0;
    if (!c || !make(c, &d, &s)) return;
    double bulk = PD_DIM == 1 ? d.young : PD_DIM * material.lambda + 2.0 * material.mu, u = 0.0, p = 0.0;
    memset(&of, 0, sizeof of);
    of.rtol = 1e-11;
    of.prescribed = held;
    for (int k = 0; k < c->body.count * PD_DIM; k++) {
        int free = 1;
        for (int a = 0; a < PD_DIM; a++)
            free = free && fabs(c->position[k / PD_DIM * PD_DIM + a]) < (0.5 * n[a] - 5.0) * 1e-4;
        held[k] = (uint8_t)!free;
        c->u[k] = 0.2 * c->position[k] + (free ? 5e-6 * random_real(&seed) : 0.0);
    }
    if (!CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &s, &of, NULL, c->u, &result))) return;
    s.stress(&c->ctx, s.self, c->u, c->stress);
    for (int k = 0; k < c->body.count * PD_DIM; k++) u = fmax(u, fabs(c->u[k] - 0.2 * c->position[k]) / 1e-3);
    for (int k = 0; k < c->body.count * T; k++)
        p = fmax(p, fabs(c->stress[k] / (0.2 * bulk / pow(1.2, PD_DIM - 1)) - (k % T % (PD_DIM + 1) == 0 ? 1.0 : 0.0)));
    NOTE("%d steps, %d iterations: u %.1e, stress %.1e", result.steps, result.iterations, u, p);
    CHECK_LE(u, 1e-12);
    CHECK_LE(p, 1e-9);
    end(c);
}

/* ---- forces ---- */

/* A body that turns by any angle has no force, and no energy. */
TEST(rotation)
{
    for (int surface = 0; surface < 4; surface++) {
        pd_material_interface s;
        solid_case *c = block(PD_DIM == 3 ? 7 : cells(), 2.0, 1.0, 0.3);
        pd_ordinary_state_desc d = steel(0.3, PD_PLANE_STRAIN, 0, surface);
        d.linear = 0;
        if (!c || !make(c, &d, &s)) return;
        for (int32_t i = 0; i < c->body.count; i++) {
            const double *x = c->position + i * PD_DIM;
            double y[3] = {x[0], 0.0, 0.0};
            for (int k = 1; k < PD_DIM; k++) y[k] = x[k];
            for (int k = 1; k < PD_DIM; k++) { /* turns by 2 in each plane of the first axis */
                double first = y[0] * cos(2.0) - y[k] * sin(2.0), second = y[0] * sin(2.0) + y[k] * cos(2.0);
                y[0] = first;
                y[k] = second;
            }
            for (int k = 0; k < PD_DIM; k++) c->u[i * PD_DIM + k] = y[k] - x[k] + 3e-4;
        }
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
        s.stress(&c->ctx, s.self, c->u, c->stress);
        CHECK_LE(largest(c->force, c->body.count * PD_DIM) * c->desc.horizon, 1e-11 * 200e9);
        CHECK_LE(largest(c->stress, c->body.count * T), 1e-11 * 200e9);
        end(c);
    }
}

/* Displacements of the size of a tenth of a cell. */
static void shake(solid_case *c, double *u, double size, uint32_t seed)
{
    for (int k = 0; k < c->body.count * PD_DIM; k++) u[k] = size * random_real(&seed);
}

/* Forces and their moments add up to zero; they are the derivative of the energy, and the tangent is theirs and
 * symmetric; energies of bonds add up. With displacements small and of any size, and all methods. */
TEST(derivative)
{
    double sums = 0.0, slope = 0.0, second = 0.0, skew = 0.0, bonds = 0.0;
    for (int way = 0; way < 16; way += PD_DIM == 3 ? 3 : 1) {
        pd_material_interface s;
        solid_case *c = block(PD_DIM == 3 ? 7 : cells(), 2.0, 1.0, 0.2);
        pd_ordinary_state_desc d = steel(0.35, way & 1, way % 3, way / 4);
        d.linear = way >> 1 & 1;
        if (!c || !make(c, &d, &s)) return;
        static double bond[40 * MOST];
        if (!CHECK(c->body.bonds <= 40 * MOST)) return;
        int n = c->body.count * PD_DIM;
        double h = 1e-3 / cells(), delta = 1e-5 * h, size = 0.0, turn[3] = {0.0}, push[PD_DIM] = {0.0};
        shake(c, c->u, 0.1 * h, 4);
        shake(c, c->way, 1.0, 5);
        shake(c, c->rest, 1.0, 6);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
        s.bond_energy(&c->ctx, s.self, c->u, bond);
        double work = 0.0, energy = s.energy(&c->ctx, s.self, c->u), split = 0.0;
        for (int32_t i = 0; i < c->body.count; i++) {
            double y[3] = {0.0}, f[3] = {0.0};
            for (int k = 0; k < PD_DIM; k++) {
                y[k] = c->position[i * PD_DIM + k] + (d.linear ? 0.0 : c->u[i * PD_DIM + k]);
                f[k] = c->volume[i] * c->force[i * PD_DIM + k];
                push[k] += f[k];
                work += f[k] * c->way[i * PD_DIM + k];
                size += fabs(f[k]);
            }
            for (int k = 0; k < 3; k++)
                turn[k] += (y[(k + 1) % 3] * f[(k + 2) % 3] - y[(k + 2) % 3] * f[(k + 1) % 3]) * 1e3;
            for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);)
                split += c->volume[i] * c->volume[b.neighbour] * bond[pdi_body_bond_number(&b)];
        }
        sums = fmax(sums, fmax(largest(push, PD_DIM), largest(turn, 3)) / size);
        bonds = fmax(bonds, fabs(split / energy - 1.0));
        s.tangent(&c->ctx, s.self, c->way, c->done);
        s.tangent(&c->ctx, s.self, c->rest, c->mended);
        double there = 0.0, back = 0.0, most = largest(c->done, n);
        for (int k = 0; k < n; k++) {
            there += c->volume[k / PD_DIM] * c->done[k] * c->rest[k];
            back += c->volume[k / PD_DIM] * c->mended[k] * c->way[k];
        }
        skew = fmax(skew, fabs(there - back) / inner(n, c->volume, c->volume) * c->volume[0] / most);
        for (int k = 0; k < n; k++) c->load[k] = c->u[k] + delta * c->way[k];
        double more = s.energy(&c->ctx, s.self, c->load);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->load, c->other));
        for (int k = 0; k < n; k++) c->load[k] = c->u[k] - delta * c->way[k];
        slope = fmax(slope, fabs((more - s.energy(&c->ctx, s.self, c->load)) / (2.0 * delta) + work) / fabs(work));
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->load, c->force));
        for (int k = 0; k < n; k++)
            second = fmax(second, fabs((c->other[k] - c->force[k]) / (2.0 * delta) - c->done[k]) / most);
        end(c);
    }
    NOTE("sums %.1e, energy %.1e, tangent %.1e, symmetry %.1e, bonds %.1e", sums, slope, second, skew, bonds);
    CHECK_LE(sums, 1e-13);
    CHECK_LE(slope, 1e-6);
    CHECK_LE(second, 1e-7);
    CHECK_LE(skew, 1e-12);
    CHECK_LE(bonds, 1e-12);
}

/* Blocks are the derivative of the force on a point along its own displacements; what compressed bonds gain by turning
 * is left out of them. */
TEST(blocks)
{
    for (int way = 0; way < 8; way++) {
        pd_material_interface s;
        solid_case *c = block(PD_DIM == 3 ? 7 : cells(), 2.0, 1.0, 0.2);
        pd_ordinary_state_desc d = steel(0.1, way & 1, 0, way / 2);
        double g[T] = {0.0}, off = 0.0, least = HUGE_VAL;
        d.linear = way & 1;
        if (!c || !make(c, &d, &s)) return;
        for (int k = 0; k < PD_DIM; k++) g[k * PD_DIM + k] = 0.01;
        linear(c, g, c->u);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
        s.blocks(&c->ctx, s.self, c->block);
        for (int32_t i = 0; i < c->body.count; i += c->body.count / 7)
            for (int k = 0; k < PD_DIM; k++) {
                memset(c->way, 0, sizeof c->way);
                c->way[i * PD_DIM + k] = 1.0;
                s.tangent(&c->ctx, s.self, c->way, c->done);
                for (int q = 0; q < PD_DIM; q++) {
                    double own = c->block[i * T + q * PD_DIM + k];
                    off = fmax(off, fabs(own + c->volume[i] * c->done[i * PD_DIM + q]) / c->block[i * T]);
                    CHECK(own <= c->block[i * T + k * PD_DIM + q] && own >= c->block[i * T + k * PD_DIM + q]);
                }
                least = fmin(least, c->block[i * T + k * PD_DIM + k] + c->volume[i] * c->done[i * PD_DIM + k]);
            }
        if (d.linear || PD_DIM == 1) CHECK_LE(off, 1e-10);
        CHECK_LE(-1e-10 * c->block[0], least);
        end(c);
    }
}

/* The step limit is below the longest stable step, and by how much: the largest frequency is found by iteration. */
TEST(step)
{
    for (int way = 0; way < 12; way++) {
        pd_material_interface s;
        solid_case *c = block(PD_DIM == 3 ? 5 : cells(), way % 3 == 1 ? 2.5 : 2.0, 1.0, way % 3 == 2 ? 0.4 : 0.0);
        pd_ordinary_state_desc d = steel(way & 1 ? 0.45 : 0.2, 0, 0, way / 3);
        double square = 0.0;
        if (!c || !make(c, &d, &s)) return;
        int n = c->body.count * PD_DIM;
        shake(c, c->way, 1.0, 7);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
        for (int k = 0; k < (PD_DIM == 3 ? 60 : 100); k++) {
            s.tangent(&c->ctx, s.self, c->way, c->done);
            double size = sqrt(inner(n, c->done, c->done));
            square = size / sqrt(inner(n, c->way, c->way)) / 7800.0;
            for (int q = 0; q < n; q++) c->way[q] = -c->done[q] / size;
        }
        double share = s.stable_step(s.self, 7800.0) * sqrt(square) / 2.0;
        NOTE("%s: limit is %.3f of the longest stable step", methods[way / 3], share);
        CHECK_LE(share, 1.0);
        CHECK_LE(0.3, share);
        end(c);
    }
}

/* ---- bodies ---- */

#if PD_DIM > 1
/* A plate that broken bonds cut in two has no force between its parts, and uniform strains of both stay exact; a body
 * too thin for its horizon, and a point whose bonds are gone, are errors that name it. */
TEST(broken)
{
    pd_material_interface s;
    double g[T], p[T], off = 0.0;
    uint32_t seed = 2;
    solid_case *c = block(cells(), 2.0, 1.0, 0.0);
    pd_ordinary_state_desc d = steel(0.3, 0, 0, 0);
    if (!c || !make(c, &d, &s)) return;
    for (int32_t i = 0; i < c->body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
            double own = c->position[i * PD_DIM], far = c->position[b.neighbour * PD_DIM];
            if ((own < 0.8e-3) != (far < 0.8e-3)) pdi_body_bonds_mark_broken(&c->body, i, b.number);
        }
    CHECK_OK(&c->ctx, s.update(&c->ctx, s.self));
    for (int k = 0; k < T; k++) g[k] = random_real(&seed);
    wanted(g, p);
    linear(c, g, c->u);
    for (int32_t i = 0; i < c->body.count; i++)
        if (c->position[i * PD_DIM] < 0.8e-3) c->u[i * PD_DIM] += 0.3; /* one part is moved away */
    s.stress(&c->ctx, s.self, c->u, c->stress);
    for (int k = 0; k < T * c->body.count; k++) off = fmax(off, fabs(c->stress[k] - p[k % T]) / largest(p, T));
    CHECK_LE(off, 1e-12);
    pdi_body_bonds_break_all(&c->body, 7);
    CHECK_INT(s.update(&c->ctx, s.self), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "the 0 bonds of point 7 at x") != NULL);
    material.desc.detach_singular = 1; /* then it is free, and a point with one bond is, too */
    for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, 0); pd_body_bonds_next(&b);)
        if (b.number) pd_body_break(&c->body, 0, b.neighbour);
    CHECK_OK(&c->ctx, s.update(&c->ctx, s.self));
    CHECK_INT(material.detached_bonds, 1);
    CHECK_INT(pdi_body_bonds_count_intact(&c->body, 0), 0);
    CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
    s.blocks(&c->ctx, s.self, c->block);
    for (int k = 0; k < PD_DIM; k++) CHECK_NEAR(c->force[k] + c->block[k], 0.0, 0.0);
    end(c);
    int n[3] = {12, 1, 1};
    c = box(n, 1e-3, 2.0, 1.0);
    if (!c) return;
    CHECK_INT(pd_ordinary_state_build(&c->ctx, &c->body, &d, &material), PD_ERR_GEOMETRY);
    CHECK(strstr(c->ctx.message, "bonds of point 0 at x") != NULL);
    end(c);
}

/* Points with a part of E: half of it everywhere is half of all forces, energies and stress. */
TEST(parts)
{
    static double part[MOST];
    for (int surface = 0; surface < 4; surface++) {
        pd_material_interface s;
        solid_case *c = block(PD_DIM == 3 ? 7 : cells(), 2.0, 1.0, 0.2);
        pd_ordinary_state_desc d = steel(0.3, 0, 0, surface);
        if (!c || !make(c, &d, &s)) return;
        shake(c, c->u, 1e-6, 4);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->force));
        s.stress(&c->ctx, s.self, c->u, c->stress);
        double energy = s.energy(&c->ctx, s.self, c->u), limit = s.stable_step(s.self, 7800.0);
        for (int32_t i = 0; i < c->body.count; i++) part[i] = 0.5;
        material.desc.stiffness_factor = part;
        CHECK_OK(&c->ctx, s.update(&c->ctx, s.self));
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, c->other));
        s.stress(&c->ctx, s.self, c->u, c->block);
        for (int k = 0; k < c->body.count * PD_DIM; k++)
            CHECK_NEAR(c->other[k], 0.5 * c->force[k], 1e-9 * fabs(c->force[0]));
        for (int k = 0; k < c->body.count * T; k++)
            CHECK_NEAR(c->block[k], 0.5 * c->stress[k], 1e-9 * fabs(c->stress[0]));
        CHECK_REL(s.energy(&c->ctx, s.self, c->u), 0.5 * energy, 1e-12);
        CHECK_REL(s.stable_step(s.self, 7800.0), limit * sqrt(2.0), 1e-12);
        part[3] = -1.0;
        CHECK_INT(s.update(&c->ctx, s.self), PD_ERR_ARGUMENT);
        end(c);
    }
}

/* What is out of range is refused. */
TEST(refused)
{
    int n[3] = {6, 6, 6};
    solid_case *c = box(n, 1e-3, 2.0, 0.0);
    if (!c) return;
    pd_ordinary_state_desc d = steel(0.5, 0, 0, 0);
    CHECK_INT(pd_ordinary_state_build(&c->ctx, &c->body, &d, &material), PD_ERR_ARGUMENT);
    d = steel(0.3, 0, 0, PD_ORDINARY_STATE_ENERGY);
    CHECK_INT(pd_ordinary_state_build(&c->ctx, &c->body, &d, &material), PD_ERR_ARGUMENT);
    CHECK(strstr(c->ctx.message, "spacing") != NULL);
    d = steel(0.3, 0, 0, 4);
    CHECK_INT(pd_ordinary_state_build(&c->ctx, &c->body, &d, &material), PD_ERR_ARGUMENT);
    end(c);
}

/* ---- Lame ---- */

static double radius(const double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += x[d] * x[d];
    return sqrt(square);
}

/* Cells that the ring or shell from 1 to 2 cuts: points at the middle of what lies in it, with its volume. */
static solid_case *ring(double h, double m)
{
    enum { parts = PD_DIM == 3 ? 4 : 16 };
    solid_case *c = case_begin();
    int n = (int)floor(4.0 / h + 0.5), all = 1, samples = 1;
    for (int d = 0; d < PD_DIM; d++) all *= n, samples *= parts;
    for (int k = 0; k < all; k++) {
        double sum[PD_DIM] = {0.0}, x[PD_DIM];
        int count = 0;
        for (int s = 0; s < samples; s++) {
            for (int d = 0, cell = k, part = s; d < PD_DIM; d++, cell /= n, part /= parts)
                x[d] = -2.0 + h * (cell % n + (part % parts + 0.5) / parts);
            if (!(radius(x) > 1.0 && radius(x) < 2.0)) continue;
            for (int d = 0; d < PD_DIM; d++) sum[d] += x[d];
            count++;
        }
        if (count < samples / 8) continue;
        if (!CHECK(c->desc.count < MOST)) return NULL;
        for (int d = 0; d < PD_DIM; d++) c->position[c->desc.count * PD_DIM + d] = sum[d] / count;
        c->volume[c->desc.count++] = pow(h, PD_DIM) * count / samples;
    }
    return case_body(c, m * h, h);
}

/* Displacement under the pressure 1 inside, E = 1. */
static double lame(double r, double nu, int plane)
{
    if (PD_DIM == 3) return ((1.0 - 2.0 * nu) * r + 0.5 * (1.0 + nu) * 8.0 / (r * r)) / 7.0;
    if (plane) return ((1.0 - nu) * r + (1.0 + nu) * 4.0 / r) / 3.0;
    return (1.0 + nu) * ((1.0 - 2.0 * nu) * r + 4.0 / r) / 3.0;
}

static double ring_error(double h, double m, double nu, int plane, int surface)
{
    double error = 0.0, size = 0.0;
    pd_material_interface s;
    solid_case *c = ring(h, m);
    pd_ordinary_state_desc d = steel(nu, plane, 0, surface);
    d.young = 1.0;
    if (!c || !make(c, &d, &s)) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (int k = 0; k < PD_DIM; k++)
            if (radius(c->position + i * PD_DIM) < 1.5) c->load[i * PD_DIM + k] = s.surface_vector[i * PD_DIM + k];
    int steps = case_solve(c, &s, PD_DIM == 3 ? 1e-6 : 1e-8);
    for (int32_t i = 0; i < c->body.count; i++) {
        double r = radius(c->position + i * PD_DIM), exact = lame(r, nu, plane);
        size += c->volume[i] * exact * exact;
        for (int k = 0; k < PD_DIM; k++) {
            double off = c->u[i * PD_DIM + k] - exact * c->position[i * PD_DIM + k] / r;
            error += c->volume[i] * off * off;
        }
    }
    NOTE("h = %g, m = %g, nu = %g, %s: %d points, %d iterations, off by %.2e", h, m, nu, methods[surface],
         (int)c->body.count, steps, sqrt(error / size));
    end(c);
    return sqrt(error / size);
}

/* Against Lame's ring (2D, both planes) and shell (3D) under pressure. */
TEST(lame_ring)
{
    static const double ratios[2] = {0.3, 0.45};
#if PD_DIM == 2
    for (int way = 0; way < 2; way++) {
        double coarse = ring_error(0.125, 2.0, ratios[way], way, 0);
        double fine = ring_error(0.0625, 2.0, ratios[way], way, 0);
        NOTE("order %.2f", log(coarse / fine) / log(2.0));
        CHECK_LE(fine, 1.5e-2);
        CHECK(log(coarse / fine) / log(2.0) > 1.1);
    }
#else
    CHECK_LE(ring_error(1.0 / 7.0, 1.5, ratios[0], 0, 0), 5e-2);
#endif
}
#endif

/* One thread and two give the same bits. */
TEST(threads)
{
    pd_material_interface s;
    solid_case *c = block(PD_DIM == 1 ? 2000 : PD_DIM == 2 ? 36 : 12, 2.0, 1.0, 0.2);
    pd_ordinary_state_desc d = steel(0.3, 0, 0, 0);
    d.linear = 0;
    for (int threads = 1; threads <= 2; threads++) {
        c->ctx.threads = threads;
        if (!c || !make(c, &d, &s)) return;
        shake(c, c->u, 1e-6, 4);
        CHECK_OK(&c->ctx, s.force(&c->ctx, s.self, c->u, threads == 1 ? c->force : c->other));
        s.tangent(&c->ctx, s.self, c->u, threads == 1 ? c->rest : c->way);
        s.stress(&c->ctx, s.self, c->u, threads == 1 ? c->stress : c->block);
        pd_ordinary_state_free(&c->ctx, &material);
    }
    size_t n = (size_t)c->body.count * PD_DIM * sizeof *c->u;
    CHECK(memcmp(c->force, c->other, n) == 0 && memcmp(c->rest, c->way, n) == 0);
    CHECK(memcmp(c->stress, c->block, n * PD_DIM) == 0);
    end(c);
}

#if PD_DIM == 1
TEST_MAIN(ENTRY(lengths) ENTRY(uniform) ENTRY(stretched) ENTRY(rotation) ENTRY(derivative) ENTRY(blocks) ENTRY(step)
          ENTRY(threads))
#elif PD_DIM == 2
TEST_MAIN(ENTRY(lattice) ENTRY(isotropy) ENTRY(lengths) ENTRY(uniform) ENTRY(methods) ENTRY(stretched) ENTRY(rotation)
          ENTRY(derivative) ENTRY(blocks) ENTRY(step) ENTRY(broken) ENTRY(parts) ENTRY(refused)
          ENTRY(lame_ring) ENTRY(threads))
#else
TEST_MAIN(ENTRY(lattice) ENTRY(isotropy) ENTRY(lengths) ENTRY(uniform) ENTRY(stretched) ENTRY(rotation)
          ENTRY(derivative) ENTRY(blocks) ENTRY(step) ENTRY(broken) ENTRY(parts) ENTRY(refused)
          ENTRY(lame_ring) ENTRY(threads))
#endif
