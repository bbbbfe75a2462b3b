/* test_diffusion: conductances beside walls, between materials, and to held walls.
 * dims: 1 2 3 */
#include "test.h"
#include "transport.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

typedef struct scene {
    pd_ctx ctx;
    pd_stencil_desc stencil_desc;
    pd_grid_desc grid_desc;
    pd_transport_desc desc;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_transport transport;
    pd_shape shapes[2];
} scene;

static scene test_scene;

/* A box of n cells of size 1/n along axis 0, `across` cells of the same size along the others; walls all round. */
static scene *scene_start(int n, int across, double m)
{
    scene *s = &test_scene;
    memset(s, 0, sizeof *s);
    pd_ctx_init(&s->ctx);
    s->stencil_desc.m = m;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = 1.0 / n;
        s->grid_desc.hi[d] = d == 0 ? 1.0 : across / (double)n;
    }
    s->grid_desc.solid = s->grid_desc.wall = -1;
    s->desc.diffusivity = 1.0;
    s->desc.tolerance = 1e-13;
    return s;
}

static int scene_build(scene *s)
{
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)) &&
           CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) &&
           CHECK_OK(&s->ctx, pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &s->desc, &s->transport));
}

static void scene_free(scene *s)
{
    pd_transport_free(&s->ctx, &s->transport);
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT((int)s->ctx.in_use, 0);
}

static int step(scene *s, double dt)
{
    pd_transport_result result;
    return CHECK_OK(&s->ctx, pd_transport_implicit(&s->ctx, &s->transport, dt, &result));
}

/* Every conductance is positive and the same from both ends, bit for bit, around a rugged solid, at walls, mirrors and
 * periodic sides. */
TEST(conductances_are_symmetric)
{
    scene *s = scene_start(12, 9, 3.0);
    s->shapes[0].type = PD_SHAPE_BALL;
    s->shapes[0].r = 0.21;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = d == 0 ? 0.43 : 0.37;
    s->grid_desc.shapes = s->shapes;
    s->grid_desc.solid = 0;
    s->grid_desc.side[0] = PD_SIDE_MIRROR;
    if (PD_DIM > 1) s->grid_desc.side[2 * PD_DIM - 1] = s->grid_desc.side[2 * PD_DIM - 2] = PD_SIDE_PERIODIC;
    if (!scene_build(s)) return;
    int different = 0, checked = 0;
    double least = 1e300, most = 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        int32_t r = s->bonds.row[i];
        if (s->grid.kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->stencil.count; k++) {
            int32_t j = i + s->bonds.shift[k];
            if (r >= 0 && !pdi_bond_open(&s->bonds, r, k)) continue;
            if (s->grid.kind[j] != PD_FLUID) continue;
            double there, back;
            pdi_diffusion_bond(&s->transport.diffusion, i, k, 1, r >= 0, &there);
            pdi_diffusion_bond(&s->transport.diffusion, j, s->stencil.count - 1 - k, 1, s->bonds.row[j] >= 0, &back);
            different += there != back;
            least = fmin(least, there / s->stencil.lap[k]);
            most = fmax(most, there / s->stencil.lap[k]);
            checked++;
        }
    }
    CHECK_INT(different, 0);
    CHECK(checked > 10 && least > 0.0);
    NOTE("%d bonds, factors %.3g .. %.3g", checked, least, most);
    scene_free(s);
}

static double at_rest(void *user, const double *x)
{
    (void)user;
    (void)x;
    return 0.0;
}

/* Decay rate over pi^2 of a mode of the closed slab (cosine), or between walls held at 0 (sine), the walls along the
 * way being closed: from the ratio of two implicit steps, (1 + rate dt)^-1. */
static double decay_rate(int n, int across, double m, int held)
{
    scene *s = scene_start(n, across, m);
    double before = 0.0, after = 0.0, dt = 0.01;
    if (held) s->desc.held = at_rest;
    if (held)
        for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&s->grid, i, x);
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = held ? sin(pi * x[0]) : 1.0 + cos(pi * x[0]);
    }
    for (int k = 0; k < 11; k++) {
        if (!step(s, dt)) return 0.0;
        double sum = 0.0;
        for (int32_t i = 0; i < s->grid.total; i++) {
            double x[PD_DIM];
            pd_grid_position(&s->grid, i, x);
            double mode = held ? sin(pi * x[0]) : cos(pi * x[0]);
            if (s->grid.kind[i] == PD_FLUID) sum += mode * s->transport.c[i];
        }
        before = after;
        after = sum;
    }
    scene_free(s);
    return (before / after - 1.0) / dt / (pi * pi);
}

/* Second order between held walls, with the constant of whole families. */
TEST(slab_between_held_walls)
{
    for (int m = 1; m <= 4; m++) {
        double coarse, fine;
        if (PD_DIM == 3 && m == 4) continue;
        coarse = fabs(decay_rate(16, 8, m, 1) - 1.0);
        fine = fabs(decay_rate(32, 16, m, 1) - 1.0);
        CHECK_LE(fine, 0.35 * (m * m + 1.5) / (32.0 * 32.0));
        CHECK_LE(1.9, log(coarse / fine) / log(2.0));
        NOTE("m = %d: rate off by %.3g, %.3g", m, coarse, fine);
    }
}

/* The same between closed walls, along closed walls. Their error has the other sign than that of whole families, so the
 * order shows on fine lattices only; on coarse ones the bound holds. */
TEST(slab_between_closed_walls)
{
    for (int m = 1; m <= 4; m++) {
        double error[4];
        int levels = PD_DIM == 3 ? 2 : 4;
        if (PD_DIM == 3 && m == 4) continue;
        for (int l = 0; l < levels; l++) {
            int n = 16 << l;
            error[l] = fabs(decay_rate(n, n / 2, m, 0) - 1.0);
            CHECK_LE(error[l], 0.6 * (m * m + 1.5) / ((double)n * n));
        }
        if (levels == 4) CHECK_LE(1.5, log(error[2] / error[3]) / log(2.0));
        NOTE("m = %d: rate off by %.3g .. %.3g", m, error[0], error[levels - 1]);
    }
}

/* Two materials between walls held at 0 and 1; the interface lies anywhere. */
static double level_at(void *user, const double *x) { return x[0] - *(const double *)user; }

static double jump_at(void *user, const double *x) { return x[0] < *(const double *)user ? 1.0 : 1e-8; }

static double ends_held(void *user, const double *x)
{
    (void)user;
    if (x[0] < 1e-9) return 0.0;
    return x[0] > 1.0 - 1e-9 ? 1.0 : (double)NAN;
}

TEST(two_materials)
{
    for (int m = 1; m <= 4; m++)
        for (int k = 0; k < 3; k++) {
            scene *s = scene_start(16, 3, m);
            double place = 0.3 + 0.17 * k, flux = 1.0 / (place / 1.0 + (1.0 - place) / 1e-8);
            s->desc.field = jump_at;
            s->desc.level = level_at;
            s->desc.held = ends_held;
            s->desc.user = &place;
            for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
            if (!scene_build(s)) return;
            for (int n = 0; n < 4; n++)
                if (!step(s, 1e14)) return;
            for (int32_t i = 0; i < s->grid.total; i++) {
                double x[PD_DIM];
                if (s->grid.kind[i] != PD_FLUID) continue;
                pd_grid_position(&s->grid, i, x);
                double exact = flux * (fmin(x[0], place) + fmax(x[0] - place, 0.0) / 1e-8);
                CHECK_NEAR(s->transport.c[i], exact, 1e-9);
            }
            scene_free(s);
        }
}

/* A conductor 1e8 times better than what is beside it, between closed walls, or with the far end held at 0. */
static double conductor_at(void *user, const double *x) { return x[0] < *(const double *)user ? 1e8 : 1.0; }

static double end_held(void *user, const double *x)
{
    (void)user;
    return x[0] > 1.0 - 1e-9 ? 0.0 : (double)NAN;
}

enum { LAYERS = 80 };

/* First node of layer i across axis 0; the others of it have the same values. */
static int32_t layer_node(const scene *s, int i)
{
    int at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) at[d] = d == 0 ? i : 0;
    return pd_grid_node(&s->grid, at);
}

/* A c of the last step's equations, layer by layer, for c = 1 in the layers from .. to - 1 and 0 elsewhere. */
static void layer_product(scene *s, int from, int to, double *product)
{
    pd_transport *t = &s->transport;
    for (int32_t i = 0; i < s->grid.total; i++) {
        int at[PD_DIM];
        t->probe[i] = t->c[i];
        pdi_grid_index(&s->grid, i, at);
        if (s->grid.kind[i] == PD_FLUID) t->c[i] = at[0] >= from && at[0] < to;
    }
    pdi_transport_residual(&s->ctx, t, t->work);
    for (int i = 0; i < LAYERS; i++) product[i] = t->rhs[layer_node(s, i)] - t->work[layer_node(s, i)];
    memcpy(t->c, t->probe, (size_t)s->grid.total * sizeof *t->c);
}

/* The same equations by elimination. It works with what the rows have beside their links and only adds positive
 * numbers, so it is exact to rounding for any ratio (Grassmann, Taksar and Heyman 1985). */
static void layer_solve(scene *s, double *x)
{
    static double link[LAYERS][LAYERS];
    double excess[LAYERS], column[LAYERS], diagonal[LAYERS];
    layer_product(s, 0, 0, excess); /* rhs - (rhs - 0): zero, so that what follows is A itself */
    for (int i = 0; i < LAYERS; i++) CHECK_NEAR(excess[i], 0.0, 0.0);
    layer_product(s, 0, LAYERS, excess);
    for (int j = 0; j < LAYERS; j++) {
        layer_product(s, j, j + 1, column);
        for (int i = 0; i < LAYERS; i++) link[i][j] = -column[i];
        x[j] = s->transport.rhs[layer_node(s, j)];
    }
    for (int k = LAYERS - 1; k >= 0; k--) {
        diagonal[k] = excess[k];
        for (int j = 0; j < k; j++) diagonal[k] += link[k][j];
        for (int i = 0; i < k; i++) {
            double share = link[i][k] / diagonal[k];
            for (int j = 0; j < k; j++) link[i][j] += share * link[k][j];
            excess[i] += share * excess[k];
            x[i] += share * x[k];
        }
    }
    for (int k = 0; k < LAYERS; k++) {
        for (int j = 0; j < k; j++) x[k] += link[k][j] * x[j];
        x[k] /= diagonal[k];
    }
}

/* The level of the conductor, which its own links say nothing about, is that of the elimination. */
TEST(good_conductor)
{
    double place = 0.4, exact[LAYERS];
    for (int open = 0; open < 2; open++) {
        scene *s = scene_start(LAYERS, PD_DIM == 3 ? 4 : 6, PD_DIM == 3 ? 2.0 : 3.0);
        s->desc.tolerance = 1e-11;
        s->desc.field = conductor_at;
        s->desc.level = level_at;
        s->desc.held = open ? end_held : NULL;
        s->desc.user = &place;
        for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        if (!scene_build(s)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            int at[PD_DIM];
            pdi_grid_index(&s->grid, i, at);
            if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = at[0] < LAYERS / 2 ? 1.0 : 0.25;
        }
        double worst = 0.0;
        for (int n = 0; n < 4; n++) {
            pd_transport_result result;
            CHECK(pd_transport_implicit(&s->ctx, &s->transport, 0.02, &result) >= 0);
            layer_solve(s, exact);
            for (int i = 0; i < LAYERS; i++)
                worst = fmax(worst, fabs(s->transport.c[layer_node(s, i)] - exact[i]));
        }
        NOTE("%s: off by %.3g", open ? "one end held" : "closed", worst);
        CHECK_LE(worst, 1e-9);
        scene_free(s);
    }
}

/* What held walls give is what the fluid gains. */
TEST(held_walls_are_in_the_balance)
{
    scene *s = scene_start(10, 6, 3.0);
    s->desc.held = ends_held;
    if (!scene_build(s)) return;
    double before = pd_transport_stock(&s->ctx, &s->transport), dt = 0.02;
    for (int n = 0; n < 5; n++) {
        if (!step(s, dt)) return;
        double now = pd_transport_stock(&s->ctx, &s->transport) + pd_transport_carried(&s->ctx, &s->transport);
        double gain = dt * (s->transport.inflow - s->transport.outflow);
        CHECK_NEAR(now - before, gain, 1e-13 * now);
        CHECK(s->transport.inflow > 0.0);
        before = now;
    }
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) CHECK(s->transport.c[i] >= 0.0 && s->transport.c[i] <= 1.0);
    scene_free(s);
}

TEST_MAIN(ENTRY(conductances_are_symmetric) ENTRY(slab_between_held_walls)
          ENTRY(slab_between_closed_walls) ENTRY(two_materials) ENTRY(good_conductor)
          ENTRY(held_walls_are_in_the_balance))
