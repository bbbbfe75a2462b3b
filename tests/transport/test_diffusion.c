/* test_diffusion: conductances beside walls, between materials, and to held walls.
 * dims: 1 2 3 */
#include "transport/amount.h"
#include "transport/settle.h"
#include "fixture.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static scene test_scene;

/* A box of n cells of size 1/n along axis 0, `across` cells of the same size along the others; walls all round. */
static scene *scene_start(int n, int across, double m)
{
    scene *s = &test_scene;
    scene_box(s, m, 1.0 / n, n, across, across);
    s->with = WITH_TRANSPORT;
    s->transport_desc.diffusivity = 1.0;
    s->transport_desc.tolerance = 1e-13;
    return s;
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
    s->shapes[0].radius = 0.21;
    for (int d = 0; d < PD_DIM; d++) s->shapes[0].a[d] = d == 0 ? 0.43 : 0.37;
    s->grid_desc.solid = &s->shapes[0];
    s->grid_desc.side[0] = PD_SIDE_MIRROR;
    if (PD_DIM > 1) s->grid_desc.side[2 * PD_DIM - 1] = s->grid_desc.side[2 * PD_DIM - 2] = PD_SIDE_PERIODIC;
    if (!scene_build(s)) return;
    int different = 0, checked = 0;
    double least = 1e300, most = 0.0;
    for (int32_t i = 0; i < s->grid.total; i++) {
        int32_t r = s->bonds.row_of_node[i];
        if (s->grid.kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->stencil.count; k++) {
            int32_t j = i + s->bonds.paths.shift[k];
            if (r >= 0 && !pdi_bond_is_open(&s->bonds, r, k)) continue;
            if (s->grid.kind[j] != PD_FLUID) continue;
            double there, back;
            pdi_diffusion_bond(&s->transport.diffusion, i, k, 1, r >= 0, &there);
            pdi_diffusion_bond(&s->transport.diffusion, j, s->stencil.count - 1 - k, 1, s->bonds.row_of_node[j] >= 0,
                               &back);
            different += there != back;
            least = fmin(least, there / s->stencil.laplacian_weight[k]);
            most = fmax(most, there / s->stencil.laplacian_weight[k]);
            checked++;
        }
    }
    CHECK_INT(different, 0);
    CHECK(checked > 10 && least > 0.0);
    NOTE("%d bonds, factors %.3g .. %.3g", checked, least, most);
    scene_free(s);
}

static double at_half(void *user, const double *x)
{
    (void)user;
    (void)x;
    return 0.5;
}

static double at_rest(void *user, const double *x)
{
    (void)user;
    (void)x;
    return 0.0;
}

/* Decay rate over pi^2 of a mode of the closed slab (cosine), or between walls held at 0 (sine), the walls along the
 * way being closed: from the ratio of two implicit steps, (1 + rate dt)^-1. */
static double decay_rate(int n, int across, double m, int held, int metal)
{
    scene *s = scene_start(n, across, m);
    s->shapes[0].type = PD_SHAPE_BOX;
    s->shapes[1].type = PD_SHAPE_COMPLEMENT;
    s->shapes[1].child_count = 1;
    for (int d = 0; d < PD_DIM && metal; d++) {
        double cell = d ? 1.0 / n : 0.0;
        s->shapes[0].a[d] = d ? 0.0 : -1.0;
        s->shapes[0].b[d] = d ? s->grid_desc.hi[d] : 2.0;
        s->grid_desc.lo[d] -= cell;
        s->grid_desc.hi[d] += cell;
            s->grid_desc.solid = &s->shapes[1];
    }
    double before = 0.0, after = 0.0, dt = 0.01;
    if (held) s->transport_desc.held = at_rest;
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
        coarse = fabs(decay_rate(16, 8, m, 1, 0) - 1.0);
        fine = fabs(decay_rate(32, 16, m, 1, 0) - 1.0);
        CHECK_LE(fine, 0.35 * (m * m + 1.5) / (32.0 * 32.0));
        CHECK_LE(1.9, log(coarse / fine) / log(2.0));
        NOTE("m = %d: rate off by %.3g, %.3g", m, coarse, fine);
    }
}

/* The same between closed walls, along closed walls or metal. Their error has the other sign than that of whole
 * families, so the order shows on fine lattices only; on coarse ones the bound holds. */
TEST(slab_between_closed_walls)
{
    for (int kind = 0; kind < (PD_DIM == 1 ? 4 : 8); kind++) {
        int m = 1 + kind % 4, metal = kind / 4;
        double error[4];
        int levels = PD_DIM == 3 ? 2 : 4;
        if (PD_DIM == 3 && m == 4) continue;
        for (int l = 0; l < levels; l++) {
            int n = 16 << l;
            error[l] = fabs(decay_rate(n, n / 2, m, 0, metal) - 1.0);
            CHECK_LE(error[l], 0.6 * (m * m + 1.5) / ((double)n * n));
        }
        if (levels == 4) CHECK_LE(1.5, log(error[2] / error[3]) / log(2.0));
        NOTE("m = %d, along %s: rate off by %.3g .. %.3g", m, metal ? "metal" : "walls", error[0], error[levels - 1]);
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
            s->transport_desc.field = jump_at;
            s->transport_desc.level = level_at;
            s->transport_desc.held = ends_held;
            s->transport_desc.user = &place;
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

/* b - A c of the last step's equations, layer by layer, for c = 1 in the layers from .. to - 1 and 0 elsewhere. */
static void layer_residual(scene *s, int from, int to, double *residual)
{
    pd_transport *t = &s->transport;
    double *had = t->work + s->grid.total;
    for (int32_t i = 0; i < s->grid.total; i++) {
        int at[PD_DIM];
        had[i] = t->c[i];
        pd_grid_index(&s->grid, i, at);
        if (s->grid.kind[i] == PD_FLUID) t->c[i] = at[0] >= from && at[0] < to;
    }
    pdi_transport_residual(&s->ctx, t, t->work);
    for (int i = 0; i < LAYERS; i++) residual[i] = t->work[layer_node(s, i)];
    memcpy(t->c, had, (size_t)s->grid.total * sizeof *t->c);
}

/* A c. */
static void layer_product(scene *s, int from, int to, double *product)
{
    double given[LAYERS];
    layer_residual(s, 0, 0, given);
    layer_residual(s, from, to, product);
    for (int i = 0; i < LAYERS; i++) product[i] = given[i] - product[i];
}

/* The same equations by elimination. It works with what the rows have beside their links and only adds positive
 * numbers, so it is exact to rounding for any ratio (Grassmann, Taksar and Heyman 1985). */
static void layer_solve(scene *s, double *x)
{
    static double link[LAYERS][LAYERS];
    double excess[LAYERS], column[LAYERS], diagonal[LAYERS];
    layer_residual(s, 0, 0, x); /* b */
    layer_product(s, 0, 0, excess); /* b - (b - (rhs - 0): zero, so that what follows is A itself */
    for (int i = 0; i < LAYERS; i++) CHECK_NEAR(excess[i], 0.0, 0.0);
    layer_product(s, 0, LAYERS, excess);
    for (int j = 0; j < LAYERS; j++) {
        layer_product(s, j, j + 1, column);
        for (int i = 0; i < LAYERS; i++) link[i][j] = -column[i];
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
        s->transport_desc.tolerance = 1e-11;
        s->transport_desc.field = conductor_at;
        s->transport_desc.level = level_at;
        s->transport_desc.held = open ? end_held : NULL;
        s->transport_desc.user = &place;
        for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        if (!scene_build(s)) return;
        for (int32_t i = 0; i < s->grid.total; i++) {
            int at[PD_DIM];
            pd_grid_index(&s->grid, i, at);
            if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = at[0] < LAYERS / 2 ? 1.0 : 0.25;
        }
        double worst = 0.0;
        for (int n = 0; n < 4; n++) {
            pd_transport_result result;
            if (!CHECK_OK(&s->ctx, pdi_transport_hold(&s->ctx, &s->transport))) return;
            CHECK(pd_transport_implicit(&s->ctx, &s->transport, 0.02, &result) >= 0);
            layer_solve(s, exact); /* the equations of that step are still held */
            CHECK_OK(&s->ctx, pdi_transport_release(&s->ctx, &s->transport, PD_OK));
            for (int i = 0; i < LAYERS; i++)
                worst = fmax(worst, fabs(s->transport.c[layer_node(s, i)] - exact[i]));
        }
        NOTE("%s: off by %.3g", open ? "one end held" : "closed", worst);
        CHECK_LE(worst, 1e-9);
        scene_free(s);
    }
}

/* Two materials, the second one from `place` to `end` of the way: diffusivities 1 and `ratio`. */
typedef struct layers {
    double place, end, ratio;
} layers;

static double layers_level(void *user, const double *x)
{
    const layers *l = (const layers *)user;
    return fmax(l->place - x[0], x[0] - l->end);
}

static double layers_at(void *user, const double *x)
{
    return layers_level(user, x) < 0.0 ? ((const layers *)user)->ratio : 1.0;
}

static double layers_held(void *user, const double *x)
{
    (void)user;
    if (x[0] < 1e-9) return 1.0;
    return x[0] > 1.0 - 1e-9 ? 0.0 : (double)NAN;
}

/* The steady field between ends held at 1 and 0, and the flux through every plane, are those of resistances in
 * series. */
static void check_layers(layers *l, int n, double m, double stretch)
{
    scene *s = scene_start(n, 3, m);
    pd_transport_result result;
    double below = l->place, inside = (fmin(l->end, 1.0) - l->place) / l->ratio, behind = fmax(1.0 - l->end, 0.0);
    double flux = 1.0 / (below + inside + behind), face = 1.0;
    s->transport_desc.field = layers_at;
    s->transport_desc.level = layers_level;
    s->transport_desc.held = layers_held;
    s->transport_desc.user = l;
    for (int d = 1; d < PD_DIM; d++) {
        s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        s->stencil_desc.h[d] *= stretch;
        s->grid_desc.hi[d] *= stretch;
        face *= s->grid_desc.hi[d];
    }
    if (!scene_build(s)) return;
    if (!CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &result)))
        NOTE("place %.17g, ratio %g, m = %g: defect %.3g", l->place, l->ratio, m, result.defect);
    for (int index = 1; index < n; index++)
        CHECK_REL(pdi_amount_section(&s->ctx, &s->transport, 0, index), flux * face, 1e-9);
    CHECK_REL(s->transport.inflow, flux * face, 1e-9);
    CHECK_REL(s->transport.outflow, flux * face, 1e-9);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        double way = fmin(x[0], l->place) + fmax(fmin(x[0], l->end) - l->place, 0.0) / l->ratio +
                     fmax(x[0] - l->end, 0.0);
        CHECK_NEAR(s->transport.c[i], 1.0 - flux * way, 1e-9);
    }
    scene_free(s);
}

/* The surface anywhere in a cell, on nodes and faces and beside them by rounding, whatever the ratio. */
TEST(surface_anywhere)
{
    static const double offset[] = {0.0, 0.125, 0.25, 1.0 / 3.0, 0.5, 0.75, 0.9, 1e-15, -1e-15, 1e-12, -1e-12, 1e-7,
                                    0.5 + 1e-15, 0.5 - 1e-15, 0.5 + 1e-12, 0.5 - 1e-12, 0.5 + 1e-7, 0.5 - 1e-7};
    static const double ratio[] = {1e-12, 1e-8, 1e-4, 0.01, 3.0, 100.0, 1e6, 1e10, 1e12};
    int n = 16, most = PD_DIM == 3 ? 2 : 4;
    for (int m = 1; m <= most; m++)
        for (int o = 0; o < (int)(sizeof offset / sizeof offset[0]); o++)
            for (int r = 0; r < (int)(sizeof ratio / sizeof ratio[0]); r++) {
                layers l;
                if (PD_DIM > 1 && (o + r + m) % (PD_DIM == 2 ? 4 : 9) != 0) continue;
                l.place = (7.0 + offset[o]) / n;
                l.end = 2.0;
                l.ratio = ratio[r];
                check_layers(&l, n, m, 1.0);
            }
}

/* The same where cells are longer or shorter across. */
TEST(surface_anywhere_on_uneven_lattices)
{
    static const double stretch[] = {0.05, 0.3, 4.0, 25.0};
    for (int k = 0; k < 4 && PD_DIM > 1; k++)
        for (int o = 0; o < 2; o++) {
            layers l;
            l.place = (7.0 + 0.5 * o) / 16.0;
            l.end = 2.0;
            l.ratio = k % 2 ? 1e8 : 1e-4;
            check_layers(&l, 16, PD_DIM == 3 ? 2 : 3, stretch[k]);
        }
    CHECK(PD_DIM > 0);
}

/* A layer thinner than a bond, or than a cell, is not passed over; one on a held wall counts as well. */
TEST(thin_layers)
{
    static const double from[] = {7.5, 7.2, 8.0, 7.0, 7.4, 0.0, 0.2}, thick[] = {1.0, 0.2, 1.0, 2.0, 0.1, 0.3, 0.2};
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++)
        for (int k = 0; k < 7; k++) {
            layers l;
            l.place = from[k] / 16.0;
            l.end = (from[k] + thick[k]) / 16.0;
            l.ratio = k % 2 ? 1e-3 : 1e-8;
            check_layers(&l, 16, m, 1.0);
        }
}

/* A solver that is stopped before its end does not call the field steady. */
TEST(steady_or_not)
{
    scene *s = scene_start(64, 3, 3.0);
    pd_transport_result result;
    layers l = {0.4, 2.0, 1e-8};
    s->transport_desc.field = layers_at;
    s->transport_desc.level = layers_level;
    s->transport_desc.held = layers_held;
    s->transport_desc.user = &l;
    if (!scene_build(s)) return;
    s->transport.krylov.desc.max_iterations = 1;
    int status = pd_transport_steady(&s->ctx, &s->transport, &result);
    CHECK(status == PD_NOT_CONVERGED ? result.defect > PDI_SETTLE_DEFECT : status == PD_OK && result.defect <= 1e-6);
    scene_free(s);
}

/* Nothing to carry: the same value all round, or no way in or out. */
TEST(steady_without_flux)
{
    for (int closed = 0; closed < 2; closed++) {
        scene *s = scene_start(12, 5, PD_DIM == 3 ? 2.0 : 3.0);
        pd_transport_result result;
        layers l = {0.4, 0.7, 1e6};
        s->transport_desc.field = layers_at;
        s->transport_desc.level = layers_level;
        s->transport_desc.held = closed ? NULL : at_half;
        s->transport_desc.user = &l;
        s->transport_desc.initial = closed ? 0.5 : 0.25;
        if (!scene_build(s)) return;
        CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &result));
        for (int32_t i = 0; i < s->grid.total; i++)
            if (s->grid.kind[i] == PD_FLUID) CHECK_NEAR(s->transport.c[i], 0.5, 1e-9);
        scene_free(s);
    }
}

#if PD_DIM > 1
/* A surface at an angle between two materials, all walls held at a field that only varies across it. */
typedef struct tilt {
    double normal[PD_DIM], place, ratio;
} tilt;

static double tilt_level(void *user, const double *x)
{
    const tilt *t = (const tilt *)user;
    double sum = -t->place;
    for (int d = 0; d < PD_DIM; d++) sum += t->normal[d] * x[d];
    return sum;
}

static double tilt_at(void *user, const double *x)
{
    return tilt_level(user, x) < 0.0 ? 1.0 : ((const tilt *)user)->ratio;
}

static double tilt_held(void *user, const double *x)
{
    double s = tilt_level(user, x), ratio = ((const tilt *)user)->ratio, scale = fmin(1.0, ratio);
    return 3.0 + scale * (s < 0.0 ? s : s / ratio);
}

TEST(surface_at_an_angle)
{
    static const double ratio[] = {1e-8, 0.01, 100.0, 1e8};
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++)
        for (int k = 0; k < 4; k++) {
            scene *s = scene_start(10, 10, m);
            pd_transport_result result;
            tilt t;
            double worst = 0.0, length = 0.0;
            for (int d = 0; d < PD_DIM; d++) t.normal[d] = d == 0 ? 0.8 : 0.33 * d + 0.2 * k;
            for (int d = 0; d < PD_DIM; d++) length += t.normal[d] * t.normal[d];
            for (int d = 0; d < PD_DIM; d++) t.normal[d] /= sqrt(length);
            t.place = 0.61;
            t.ratio = ratio[k];
            s->transport_desc.field = tilt_at;
            s->transport_desc.level = tilt_level;
            s->transport_desc.held = tilt_held;
            s->transport_desc.user = &t;
            if (!scene_build(s)) return;
            CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &result));
            for (int32_t i = 0; i < s->grid.total; i++) {
                double x[PD_DIM];
                if (s->grid.kind[i] != PD_FLUID) continue;
                pd_grid_position(&s->grid, i, x);
                worst = fmax(worst, fabs(s->transport.c[i] - tilt_held(&t, x)));
            }
            CHECK_LE(worst, 1e-8);
            scene_free(s);
        }
}

static double flat_level(void *user, const double *x) { return x[PD_DIM - 1] - ((const tilt *)user)->place; }

static double flat_at(void *user, const double *x)
{
    return flat_level(user, x) < 0.0 ? 1.0 : ((const tilt *)user)->ratio;
}

static double along_error(int n, int across, double m, double offset, double ratio)
{
    scene *s = scene_start(n, across, m);
    pd_transport_result result;
    tilt t;
    int last = PD_DIM - 1;
    t.place = (across / 2 + offset) / n;
    t.ratio = ratio;
    s->transport_desc.field = flat_at;
    s->transport_desc.level = flat_level;
    s->transport_desc.held = layers_held;
    s->transport_desc.user = &t;
    for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_MIRROR;
    if (PD_DIM == 3) s->grid_desc.hi[1] = 4.0 / n;
    if (!scene_build(s)) return 1.0;
    CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &result));
    double width = s->grid_desc.hi[last], exact = t.place + (width - t.place) * ratio;
    if (PD_DIM == 3) exact *= s->grid_desc.hi[1];
    double error = fabs(pdi_amount_section(&s->ctx, &s->transport, 0, n / 2) / exact - 1.0);
    scene_free(s);
    return error;
}

/* Along a surface both materials conduct side by side, wherever it cuts the cells: second order. */
TEST(along_a_surface)
{
    static const double offset[] = {0.0, 0.25, 0.5, 0.8};
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++)
        for (int o = 0; o < 4; o++)
            for (int r = 0; r < 2; r++) {
                double ratio = r ? 100.0 : 1e-4;
                double coarse = along_error(16, 16, m, offset[o], ratio);
                double fine = along_error(32, 32, m, offset[o], ratio);
                CHECK_LE(fine, 2e-3);
                CHECK_LE(fine, 0.3 * coarse + 1e-9);
            }
}

/* Shells around a core, with diffusivities 1 and `ratio`, between spheres held at 1 and 0. */
static double shell_middle[PD_DIM], shell_place, shell_ratio;
enum { CORE = 25, RIM = 90 }; /* hundredths */

static double shell_radius(const double *x)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += (x[d] - shell_middle[d]) * (x[d] - shell_middle[d]);
    return sqrt(sum);
}

static double shell_level(void *user, const double *x)
{
    (void)user;
    return shell_radius(x) - shell_place;
}

static double shell_at(void *user, const double *x) { return shell_level(user, x) < 0.0 ? 1.0 : shell_ratio; }

static double shell_held(void *user, const double *x)
{
    (void)user;
    return shell_radius(x) < 0.01 * (CORE + RIM) / 2.0 ? 1.0 : 0.0;
}

/* Resistance between two radii. */
static double shell_between(double a, double b)
{
    return PD_DIM == 2 ? log(b / a) / (2.0 * pi) : (1.0 / a - 1.0 / b) / (4.0 * pi);
}

/* Flux [mol/s] through round layers. core: 0 a wall, 1 metal, 2 metal that is not asked. */
static double shell_flux(int n, double m, double shift, double ratio, int core)
{
    scene *s = scene_start(n, n, m);
    pd_shape shapes[4];
    pd_transport_result result;
    memset(shapes, 0, sizeof shapes);
    for (int d = 0; d < PD_DIM; d++) {
        s->grid_desc.lo[d] = -1.0;
        s->grid_desc.hi[d] = 1.0;
        s->stencil_desc.h[d] = 2.0 / n;
        shell_middle[d] = d == 0 ? shift * 2.0 / n : 0.0;
        for (int k = 0; k < 2; k++) shapes[k].a[d] = shell_middle[d];
    }
    shapes[0].type = shapes[1].type = PD_SHAPE_BALL;
    shapes[0].radius = 0.01 * CORE;
    shapes[1].radius = 0.01 * RIM;
    shapes[2].type = PD_SHAPE_COMPLEMENT;
    shapes[2].child[0] = 1;
    shapes[2].child_count = 1;
    shapes[3].type = PD_SHAPE_UNION;
    shapes[3].child[1] = 2;
    shapes[3].child_count = 2;
    s->grid_desc.shapes = shapes;
    s->grid_desc.wall = &shapes[3];
    s->transport_desc.field = shell_at;
    s->transport_desc.level = shell_level;
    s->transport_desc.held = shell_held;
    shell_place = 0.55;
    shell_ratio = ratio;
    s->transport_desc.walls_only = core == 2;
    if (core) s->grid_desc.solid = &shapes[0];
    if (core) s->grid_desc.wall = &shapes[2];
    if (!scene_build(s)) return 0.0;
    CHECK_OK(&s->ctx, pd_transport_steady(&s->ctx, &s->transport, &result));
    double flux = s->transport.inflow;
    scene_free(s);
    return flux;
}

static double shell_error(int n, double m, double shift, double ratio)
{
    double exact = 1.0 / (shell_between(0.01 * CORE, 0.55) + shell_between(0.55, 0.01 * RIM) / ratio);
    return fabs(shell_flux(n, m, shift, ratio, 0) / exact - 1.0);
}

/* Metal holds what a wall holds, unless nobody asks it. */
TEST(metal_that_holds)
{
    int n = PD_DIM == 3 ? 24 : 48;
    double exact = 1.0 / (shell_between(0.01 * CORE, 0.55) + shell_between(0.55, 0.01 * RIM) / 0.1);
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++) {
        double wall = shell_flux(n, m, 0.37, 0.1, 0), metal = shell_flux(n, m, 0.37, 0.1, 1);
        NOTE("m = %d: flux off by %.3g from a wall, %.3g from metal", m, wall / exact - 1.0, metal / exact - 1.0);
        CHECK_NEAR(metal, exact, (PD_DIM == 3 ? 2e-2 : 5e-3) * exact);
        CHECK_NEAR(shell_flux(n, m, 0.37, 0.1, 2), 0.0, 1e-9 * exact);
    }
}

/* Round layers, the lattice shifted under them: second order. */
TEST(round_layers)
{
    static const double ratio[] = {1e-6, 0.1, 1e6};
    int coarse = PD_DIM == 3 ? 24 : 48, fine = PD_DIM == 3 ? 48 : 192;
    for (int m = 1; m <= (PD_DIM == 3 ? 2 : 3); m++)
        for (int r = 0; r < 3; r++) {
            double worst[2] = {0.0, 0.0};
            for (int k = PD_DIM == 3; k < (PD_DIM == 3 ? 2 : 3); k++) {
                worst[0] = fmax(worst[0], shell_error(coarse, m, 0.37 * k, ratio[r]));
                worst[1] = fmax(worst[1], shell_error(fine, m, 0.37 * k, ratio[r]));
            }
            double order = log(worst[0] / worst[1]) / log((double)fine / coarse);
            NOTE("m = %d, ratio %g: flux off by %.3g, %.3g, order %.2f", m, ratio[r], worst[0], worst[1], order);
            /* three cells to the core in 3D */
            CHECK_LE(worst[1], PD_DIM == 3 ? 1e-2 : 3e-4);
            CHECK_LE(PD_DIM == 3 ? 1.75 : 1.9, order);
        }
}
#endif

/* What held walls give is what the fluid gains. */
TEST(held_walls_are_in_the_balance)
{
    scene *s = scene_start(10, 6, 3.0);
    s->transport_desc.held = ends_held;
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

#if PD_DIM > 1
#define ROUND_LAYERS \
    ENTRY(surface_at_an_angle) ENTRY(along_a_surface) ENTRY(metal_that_holds) SLOW_ENTRY_IF(PD_DIM > 1, round_layers)
#else
#define ROUND_LAYERS
#endif
TEST_MAIN(ENTRY(conductances_are_symmetric) ENTRY(slab_between_held_walls)
          SLOW_ENTRY_IF(PD_DIM > 1, slab_between_closed_walls) ENTRY(two_materials) ENTRY(good_conductor)
          ENTRY(held_walls_are_in_the_balance) ENTRY(surface_anywhere)
          ENTRY(surface_anywhere_on_uneven_lattices) ENTRY(thin_layers) ENTRY(steady_or_not)
          ENTRY(steady_without_flux) ROUND_LAYERS)
