/* test_equilibrium: bodies at rest against closed forms: uniform stress, Lame's cylinder and sphere, Kirsch's hole.
 * dims: 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/correspondence.h"
#include "solid/equilibrium.h"
#include "test.h"
#include "cases/elasticity.h"
#include <math.h>

#define MOST 35000 /* points */
enum { T = PD_DIM * PD_DIM };

typedef struct ring_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    double position[MOST * PD_DIM], volume[MOST], u[MOST * PD_DIM], load[MOST * PD_DIM], stress[MOST * T];
    uint8_t held[MOST * PD_DIM];
} ring_case;

static ring_case test_case;

/* 1: the place belongs to the body. */
typedef int (*inside_fn)(const double *x);

/* Cells of the box -half..half [m] that the body cuts: points at the middle of what lies in it, with its volume. */
static ring_case *cells(inside_fn inside, double half, double h, double m)
{
    enum { parts = PD_DIM == 3 ? 6 : 16 };
    ring_case *c = &test_case;
    int n = (int)floor(2.0 * half / h + 0.5), all = 1, samples = 1;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    for (int d = 0; d < PD_DIM; d++) all *= n, samples *= parts;
    for (int k = 0; k < all; k++) {
        double sum[PD_DIM] = {0.0}, x[PD_DIM];
        int count = 0;
        for (int s = 0; s < samples; s++) {
            for (int d = 0, cell = k, part = s; d < PD_DIM; d++, cell /= n, part /= parts)
                x[d] = -half + h * (cell % n + (part % parts + 0.5) / parts);
            if (!inside(x)) continue;
            for (int d = 0; d < PD_DIM; d++) sum[d] += x[d];
            count++;
        }
        if (count < samples / 8) continue;
        if (!CHECK(c->desc.count < MOST)) return NULL;
        for (int d = 0; d < PD_DIM; d++) c->position[c->desc.count * PD_DIM + d] = sum[d] / count;
        c->volume[c->desc.count++] = pow(h, PD_DIM) * count / samples;
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * h;
    c->desc.spacing = h;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body)) ? c : NULL;
}

static int elastic(ring_case *c, double nu, pd_plane plane)
{
    pd_correspondence_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.young = 1.0;
    desc.poisson = nu;
    desc.plane = plane;
    return CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic));
}

static int solve(ring_case *c, int holds, pd_equilibrium_result *result)
{
    pd_equilibrium_desc desc;
    pd_material_interface solid = pd_correspondence_material(&c->elastic);
    memset(&desc, 0, sizeof desc);
    if (holds) desc.prescribed = c->held;
    if (!CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &solid, &desc, c->load, c->u, result))) return 0;
    CHECK_LE(result->residual, 1e-10);
    pd_correspondence_stress(&c->ctx, &c->elastic, c->u, c->stress);
    return 1;
}

static void end(ring_case *c)
{
    pd_correspondence_free(&c->ctx, &c->elastic);
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

static double radius(const double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += x[d] * x[d];
    return sqrt(square);
}

/* ---- Lame ---- */

static int in_ring(const double *x) { return radius(x) > 1.0 && radius(x) < 2.0; }

static double ring_error(double h, double nu, pd_plane plane)
{
    pd_equilibrium_result result;
    double error = 0.0, size = 0.0, mean[PD_DIM] = {0.0}, volume = 0.0;
    ring_case *c = cells(in_ring, 2.0, h, PD_DIM == 3 ? 1.0 : 2.0);
    if (!c || !elastic(c, nu, plane)) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (int d = 0; d < PD_DIM; d++)
            if (radius(c->position + i * PD_DIM) < 1.5)
                c->load[i * PD_DIM + d] = c->elastic.surface_vector[i * PD_DIM + d];
    if (!solve(c, 0, &result)) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        volume += c->volume[i];
        for (int d = 0; d < PD_DIM; d++) mean[d] += c->volume[i] * c->u[i * PD_DIM + d];
    }
    for (int32_t i = 0; i < c->body.count; i++) {
        double r = radius(c->position + i * PD_DIM), exact = elasticity_lame(r, nu, plane);
        size += c->volume[i] * exact * exact;
        for (int d = 0; d < PD_DIM; d++) {
            double off = c->u[i * PD_DIM + d] - mean[d] / volume - exact * c->position[i * PD_DIM + d] / r;
            error += c->volume[i] * off * off;
        }
    }
    NOTE("h = %g, nu = %g: %d points, %d iterations, off by %.2e", h, nu, (int)c->body.count, result.iterations,
         sqrt(error / size));
    end(c);
    return sqrt(error / size);
}

/* Against Lame's ring (2D, both planes) and shell (3D) under pressure. */
TEST(lame_ring)
{
    static const double ratios[2] = {0.3, 0.45};
    for (int way = 0; way < (PD_DIM == 3 ? 1 : 4); way++) {
        double coarse = ring_error(PD_DIM == 3 ? 0.2 : 0.125, ratios[way & 1], (pd_plane)(way >> 1));
        double fine = ring_error(PD_DIM == 3 ? 0.1 : 0.0625, ratios[way & 1], (pd_plane)(way >> 1));
        NOTE("order %.2f", log2(coarse / fine));
        CHECK_LE(fine, PD_DIM == 3 ? 3e-2 : 1.5e-2);
        CHECK(log2(coarse / fine) > 1.1);
    }
}

#if PD_DIM == 2
static int in_plate(const double *x) { return radius(x) > 1.0 && fabs(x[0]) < 4.0 && fabs(x[1]) < 4.0; }

static double plate_error(double h)
{
    pd_equilibrium_result result;
    double error = 0.0, size = 0.0, most = 0.0;
    ring_case *c = cells(in_plate, 4.0, h, 2.0);
    if (!c || !elastic(c, 0.3, PD_PLANE_STRESS)) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * 2;
        if (fmax(fabs(x[0]), fabs(x[1])) < 4.0 - 5.0 * h) continue;
        elasticity_kirsch(x, 0.3, c->u + i * 2);
        c->held[i * 2] = c->held[i * 2 + 1] = 1;
    }
    if (!solve(c, 1, &result)) return 1.0;
    for (int32_t i = 0; i < c->body.count; i++) {
        double exact[2];
        const double *x = c->position + i * 2;
        elasticity_kirsch(x, 0.3, exact);
        for (int d = 0; d < 2; d++) {
            error += c->volume[i] * (c->u[i * 2 + d] - exact[d]) * (c->u[i * 2 + d] - exact[d]);
            size += c->volume[i] * exact[d] * exact[d];
        }
        if (fabs(x[0]) < h) most = fmax(most, c->stress[i * 4]);
    }
    NOTE("h = %g: %d points, %d iterations, u off by %.2e, largest stress %.3f", h, (int)c->body.count,
         result.iterations, sqrt(error / size), most);
    end(c);
    return sqrt(error / size);
}

TEST(kirsch_hole)
{
    double coarse = plate_error(0.25), fine = plate_error(0.125);
    NOTE("order %.2f", log2(coarse / fine));
    CHECK_LE(fine, 5e-3);
    CHECK(log2(coarse / fine) > 1.2);
}

TEST(finer_hole)
{
    double coarse = plate_error(0.125), fine = plate_error(0.0625);
    NOTE("order %.2f", log2(coarse / fine));
    CHECK_LE(fine, 2e-3);
    CHECK(log2(coarse / fine) > 1.2);
}
#define OF_2D ENTRY(kirsch_hole) SLOW_ENTRY(finer_hole)
#else
#define OF_2D
#endif

static int in_box(const double *x) { return fabs(x[0]) < 1.0; }

/* Bodies that no displacement brings to rest are refused: loads that push or turn what nothing holds, also a loose
 * piece of a body that is held. A load that is not a number, too. */
TEST(no_rest)
{
    for (int way = 0; way < 4; way++) {
        pd_equilibrium_desc desc;
        pd_equilibrium_result result;
        ring_case *c = cells(in_box, 1.0, 0.2, 1.0);
        if (!c) return;
        for (int32_t i = 0; i < c->body.count && way == 2; i++)
            for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);)
                if ((c->position[i * PD_DIM] < 0.0) != (c->position[b.neighbour * PD_DIM] < 0.0))
                    pdi_body_bonds_mark_broken(&c->body, i, b.number);
        if (!elastic(c, 0.3, PD_PLANE_STRAIN)) return;
        memset(&desc, 0, sizeof desc);
        desc.prescribed = c->held;
        for (int32_t i = 0; i < c->body.count; i++) {
            const double *x = c->position + i * PD_DIM;
            if (way == 0) c->load[i * PD_DIM + 1] = 1.0;
            if (way == 1) c->load[i * PD_DIM] = x[1];
            if (way == 2 && x[0] < 0.0) memset(c->held + i * PD_DIM, 1, PD_DIM);
            if (way == 2 && x[0] > 0.8) c->load[i * PD_DIM] = 1.0;
        }
        if (way == 3) c->load[5] = NAN;
        pd_material_interface solid = pd_correspondence_material(&c->elastic);
        pd_status status = pd_equilibrium_solve(&c->ctx, &solid, &desc, c->load, c->u, &result);
        CHECK_INT(status, way == 1 ? PD_ERR_DIVERGED : PD_ERR_STATE);
        CHECK(strncmp(c->ctx.message, "equilibrium: ", 13) == 0);
        NOTE("%s", c->ctx.message);
        end(c);
    }
}

/* ---- iterations ---- */

enum { HELD, CRACK, WEAK, FREE, ROLLERS, STIRRED, WAYS };

static int in_all(const double *x) { return x[0] < 1.0; }

/* The box -1..1 with cells of width h, pulled at both ends or held at one of them. */
static ring_case *pulled(int way, double h, double m, double *stiff)
{
    pd_correspondence_desc desc;
    ring_case *c = cells(in_all, 1.0, h, m);
    if (!c) return NULL;
    uint32_t seed = 5;
    if (way == STIRRED) {
        for (int32_t k = 0; k < c->desc.count * PD_DIM; k++) c->position[k] += 0.5 * h * (random_share(&seed) - 0.5);
        pd_body_free(&c->ctx, &c->body);
        c->desc.spacing = 0.0;
        c->desc.horizon = (m + 0.5) * h;
        if (!CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body))) return NULL;
    }
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM;
        stiff[i] = way == WEAK && radius(x) < 0.6 ? 1e-3 : 1.0;
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); way == CRACK && pd_body_bonds_next(&b);) {
            const double *y = c->position + b.neighbour * PD_DIM;
            if ((x[0] < 0.0) != (y[0] < 0.0) && x[1] + y[1] > 0.0) pdi_body_bonds_mark_broken(&c->body, i, b.number);
        }
    }
    memset(&desc, 0, sizeof desc);
    desc.young = 1.0;
    desc.poisson = 0.3;
    desc.stiffness_factor = stiff;
    if (!CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &c->elastic))) return NULL;
    for (int32_t i = 0; i < c->body.count; i++) {
        const double *x = c->position + i * PD_DIM, *edge = c->elastic.surface_vector + i * PD_DIM;
        if (way == FREE || x[0] > 0.0) c->load[i * PD_DIM] = -edge[0];
        if (way != FREE && way != ROLLERS && x[0] > 0.0) c->load[i * PD_DIM + 1] = -0.2 * edge[0];
        for (int d = 0; d < PD_DIM && way != FREE && x[0] < m * h - 1.0; d++)
            c->held[i * PD_DIM + d] = way != ROLLERS || d == 0;
        for (int d = 1; d < PD_DIM && way == ROLLERS; d++)
            if (x[d] < h - 1.0) c->held[i * PD_DIM + d] = 1;
    }
    return c;
}

/* Few iterations, nearly as many with finer cells, in bodies with cracks, weak regions and points anywhere, however
 * they are held; the solution is that with the blocks alone, and it is the same with three threads. */
TEST(few_iterations)
{
    static double stiff[MOST], kept[MOST * PD_DIM];
    static const char *const names[WAYS] = {"held", "crack", "weak", "free", "rollers", "stirred"};
    for (int way = 0; way < WAYS; way++) {
        int iterations[4] = {0};
        double off = 0.0, size = 0.0;
        for (int run = 0; run < 4; run++) { /* the same with threads and with blocks alone, and finer cells */
            pd_equilibrium_desc desc;
            pd_equilibrium_result result;
            ring_case *c = pulled(way, (PD_DIM == 3 ? 0.25 : 0.0625) * (run == 3 ? 0.5 : 1.0), PD_DIM == 3 ? 1.0 : 2.0,
                                  stiff);
            if (!c) return;
            pd_material_interface solid = pd_correspondence_material(&c->elastic);
            memset(&desc, 0, sizeof desc);
            desc.prescribed = c->held;
            desc.rtol = 1e-9;
            if (run == 1) c->ctx.threads = 3;
            if (run == 2) solid.moduli = NULL;
            if (!CHECK_OK(&c->ctx, pd_equilibrium_solve(&c->ctx, &solid, &desc, c->load, c->u, &result))) return;
            iterations[run] = result.iterations;
            if (run == 0) memcpy(kept, c->u, sizeof kept);
            if (run == 1) CHECK(memcmp(kept, c->u, (size_t)c->body.count * PD_DIM * sizeof *kept) == 0);
            for (int32_t k = 0; k < c->body.count * PD_DIM && run == 2; k++) {
                off = fmax(off, fabs(kept[k] - c->u[k]));
                size = fmax(size, fabs(c->u[k]));
            }
            end(c);
        }
        NOTE("%s: %d iterations, %d with finer cells, %d with blocks alone; u off by %.1e", names[way], iterations[0],
             iterations[3], iterations[2], off / size);
        CHECK_LE(iterations[3], way == CRACK ? 80 : 60);
        CHECK_LE(iterations[3], 1.2 * iterations[0] + 5);
        CHECK_LE(off, 1e-7 * size);
    }
}

TEST_MAIN(ENTRY(lame_ring) OF_2D ENTRY(no_rest) ENTRY(few_iterations))
