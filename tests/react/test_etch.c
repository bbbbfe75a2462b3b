/* etch: metal that dissolves by a law in pH or species: through a stagnant layer against the balance of its fluxes, for
 * falling, steep, jumping and rising laws, in one step of any length and in many; balances close to rounding.
 * dims: 1 2 3 */
#include "chemistry/speciation.h"
#include "react/advance.h"
#include "react/etch.h"
#include "chemistry_case.h"
#include "fixture.h"

#define LAYER 1e-3 /* [m] */
#define CS 7e4     /* [mol/m3] of the metal */
#define CELLS 20

static scene test_scene;
static pd_reactive test_reactive;
static pd_etch test_etch;
static pd_reactive_result test_result;

/* A law at the surface. */
typedef struct attack {
    int kind;
    double fastest, power;
    int solute;
} attack;

enum { FALLING, ACID, JUMP, RISING, ROOT, BLIND };

static double law_of(const attack *a, double acid, double ph)
{
    if (a->kind == FALLING) return a->fastest * pow(10.0, a->power * (7.0 - ph));
    if (a->kind == ROOT) return a->fastest * sqrt(1.0 - acid / a->power);
    if (a->kind == BLIND) return ph > 9.0 ? NAN : a->fastest;
    if (a->kind == ACID) return a->fastest * acid / 1e-4;
    if (a->kind == JUMP) return ph > 9.5 ? 0.0 : a->fastest;
    return a->fastest * (1.0 + (ph - 7.0) * (ph - 7.0) / 20.0);
}

static double law(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    const attack *a = (const attack *)user;
    (void)node;
    (void)phi;
    (void)t;
    return law_of(a, c[a->solute], ph);
}

static double at_right(void *user, const double *x)
{
    (void)user;
    return x[0] > LAYER - 1e-7 ? 1.0 : (double)NAN;
}

/* A layer of fluid between metal at x = 0 and a solution at x = LAYER, where `held` stays. */
static int layer(mixture *v, const double *held, const attack *a, const double *shed, pd_activity activity, int film,
                 int order)
{
    scene *s = &test_scene;
    pd_reactive_desc d;
    pd_etch_desc e;
    double h = LAYER / CELLS;
    scene_box(s, 1.0, h, CELLS, 3, 3);
    for (int axis = 1; axis < PD_DIM; axis++)
        s->grid_desc.side[2 * axis] = s->grid_desc.side[2 * axis + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return 0;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    d.species = v->s;
    d.count = v->species;
    d.reactions = v->r;
    d.reaction_count = v->reactions;
    d.temperature = 298.15;
    d.activity = activity;
    d.initial = held;
    d.wall = held;
    d.held = at_right;
    d.order = order;
    if (!CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive))) return 0;
    e.law = law;
    e.user = (void *)a;
    e.shed = shed;
    e.reads_ph = a->kind != ACID;
    e.reads = (uint32_t)1 << a->solute;
    if (!CHECK_OK(&s->ctx, pd_etch_build(&s->ctx, &test_reactive, &e, &test_etch))) return 0;
    pd_etch_open(&test_etch);
    for (int32_t i = 0; i < s->grid.total; i++) {
        double x[PD_DIM];
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        if (x[0] < h)
            pd_etch_put(&test_etch, i, CS / h, film ? CS * 0.5 * h / test_reactive.diffusion.desc.diffusivity : 0.0);
    }
    return CHECK(test_etch.count > 0);
}

static void finish(void)
{
    scene *s = &test_scene;
    pd_etch_free(&s->ctx, &test_etch);
    pd_reactive_free(&s->ctx, &test_reactive);
    scene_free(s);
}

/* The balances close, and what metal has given is in them. */
static void closed(const double *shed, int species)
{
    scene *s = &test_scene;
    pd_reactive_balance b;
    double given = 0.0, volume = test_reactive.bonds->stencil->volume;
    for (int32_t p = 0; p < test_etch.count; p++) given += volume * test_etch.weight[p] * test_etch.passed[p];
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
        if (strcmp(b.name, "Mg") == 0) CHECK_REL(b.in, given * shed[species], 1e-9);
    }
}

static double speed_of(void)
{
    double least = HUGE_VAL, most = 0.0;
    for (int32_t p = 0; p < test_etch.count; p++) {
        least = fmin(least, test_etch.speed[test_etch.node[p]]);
        most = fmax(most, test_etch.speed[test_etch.node[p]]);
    }
    CHECK_REL(most, least, 1e-7);
    return most;
}

static int step_all(double dt)
{
    int done = CHECK_OK(&test_scene.ctx, pd_reactive_step(&test_scene.ctx, &test_reactive, dt, &test_result));
    if (done) pdi_etch_accept(&test_etch);
    return done;
}

/* ---- water and salt ---- */

enum { WATER, H, OH, NA, CL, MG };

static void saline(mixture *v, double ph, double *held, double *shed)
{
    mix_begin(v);
    mix_species(v, "H2O", NULL, 0.0);
    mix_species(v, "H+", NULL, 9.31e-9);
    mix_species(v, "OH-", NULL, 5.27e-9);
    mix_species(v, "Na+", NULL, 1.33e-9);
    mix_species(v, "Cl-", NULL, 2.03e-9);
    mix_species(v, "Mg2+", NULL, 0.7e-9);
    mix_reaction(v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    memset(held, 0, PD_SPECIES_MAX * sizeof *held);
    memset(shed, 0, PD_SPECIES_MAX * sizeof *shed);
    held[H] = 1e3 * pow(10.0, -ph);
    held[OH] = 1e-8 / held[H];
    held[NA] = held[CL] = 145.0;
    shed[MG] = 1.0;
    shed[OH] = 2.0;
}

/* What the law gives where metal dissolves at v. Base goes as OH- and is taken up by H+: D_OH OH - D_H H is linear. */
static double given_at(const attack *a, const double *held, double v)
{
    double u = 5.27e-9 * held[OH] - 9.31e-9 * held[H] + 2.0 * CS * v * LAYER; /* = 5.27e-9 OH - 9.31e-9 1e-8/OH */
    double root = sqrt(u * u + 4.0 * 5.27e-9 * 9.31e-9 * 1e-8);
    double oh = u > 0.0 ? (u + root) / (2.0 * 5.27e-9) : 2.0 * 9.31e-9 * 1e-8 / (root - u);
    return law_of(a, 1e-8 / oh, 11.0 + log10(oh));
}

static double exact(const attack *a, const double *held)
{
    double low = 0.0, high = 1.0;
    for (int k = 0; k < 2000; k++) {
        double v = k < 60 ? sqrt(fmax(low, 1e-30) * high) : 0.5 * (low + high);
        if (given_at(a, held, v) > v) low = v;
        else high = v;
    }
    return high;
}

/* Steps from a hundredth of the time of diffusion through the layer to a million times it, each from the start. */
TEST(layers)
{
    static const attack laws[] = {
        {FALLING, 3e-10, 0.3, 0}, {FALLING, 3e-8, 0.3, 0}, {FALLING, 3e-10, 4.0, 0}, {ACID, 1e-10, 0.0, 0},
        {ACID, 1e-5, 0.0, 0},     {JUMP, 3e-10, 0.0, 0},   {RISING, 1e-12, 0.0, 0}};
    for (size_t k = 0; k < sizeof laws / sizeof laws[0]; k++)
        for (int acid = 0; acid < 2; acid++) {
            mixture v;
            double held[PD_SPECIES_MAX], shed[PD_SPECIES_MAX];
            saline(&v, acid ? 4.0 : 7.0, held, shed);
            if (!layer(&v, held, &laws[k], shed, PD_ACTIVITY_IDEAL, 1, 1)) return;
            double wanted = exact(&laws[k], held);
            if (!step_all(1e12)) return;
            if (!CHECK_REL(speed_of(), wanted, 1e-7)) NOTE("law %d, acid %d: %g, %g", (int)k, acid, speed_of(), wanted);
            CHECK_LE(test_result.newton, 30);
            CHECK_INT(test_result.parts, 0);
            closed(shed, MG);
            finish();
        }
}

/* Many steps of each order come to the same, each nearer to it, and each closes. By order 1 they come from above: base
 * gathers. By order 2 a long step passes the end by a share of what was left. (1 + a z)/(1 - g z)^2 with
 * g = 1 - 1/sqrt(2), a = sqrt(2) - 1 has the least value -(sqrt(2) - 1)/2 = -0.2071. */
TEST(in_time)
{
    static const attack falling = {FALLING, 3e-9, 0.3, 0};
    for (int order = 1; order < 3; order++) {
        mixture v;
        double held[PD_SPECIES_MAX], shed[PD_SPECIES_MAX], before = HUGE_VAL;
        saline(&v, 7.0, held, shed);
        if (!layer(&v, held, &falling, shed, PD_ACTIVITY_IDEAL, 1, order)) return;
        double wanted = exact(&falling, held);
        for (double dt = 1e-3; dt < 1e6; dt *= 3.0) {
            if (!step_all(dt)) return;
            CHECK_LE(test_result.newton, 40);
            double left = speed_of() - wanted, was = before < HUGE_VAL ? before - wanted : wanted;
            if (order == 1) CHECK_LE(speed_of(), before * (1.0 + 1e-6));
            if (order == 2 && was > 0.0) CHECK_LE(-left, 0.21 * was + 1e-6 * wanted);
            CHECK_LE(fabs(left), fabs(before - wanted) + 1e-6 * wanted);
            before = speed_of();
            closed(shed, MG);
        }
        CHECK_REL(speed_of(), wanted, 1e-5);
        finish();
    }
}

/* Without a film the law meets the node itself: half a cell is missing of the layer. */
TEST(without_film)
{
    static const attack laws[] = {{FALLING, 3e-9, 0.3, 0}, {ACID, 1e-5, 0.0, 0}};
    for (int k = 0; k < 2; k++) {
        mixture v;
        double held[PD_SPECIES_MAX], shed[PD_SPECIES_MAX];
        saline(&v, 7.0, held, shed);
        if (!layer(&v, held, &laws[k], shed, PD_ACTIVITY_IDEAL, 0, 1)) return;
        if (!step_all(1e12)) return;
        CHECK_REL(speed_of(), exact(&laws[k], held), 1.5 / CELLS);
        CHECK_LE(test_result.krylov, 200);
        closed(shed, MG);
        finish();
    }
}

/* ---- body fluid ---- */

/* All of one D: at the surface is what the solution holds and what has diffused in, brought to equilibrium in another
 * way. */
static void body_fluid(pd_activity activity, double close)
{
    static attack falling = {FALLING, 2e-10, 0.3, 0};
    mixture v;
    pd_speciation all;
    pd_speciation_result result;
    double held[PD_SPECIES_MAX], shed[PD_SPECIES_MAX], low = 0.0, high = 1e-9;
    mix_body_fluid(&v);
    for (int i = 0; i < v.species; i++) v.s[i].diffusivity = 1e-9;
    mix_hanks(&v, held);
    CHECK_OK(&v.ctx, pd_speciation_build(&v.ctx, v.s, v.species, v.r, v.reactions, activity, 298.15, &all));
    CHECK_OK(&v.ctx, pd_speciation_solve(&all, held, &result));
    memset(shed, 0, sizeof shed);
    shed[mix_at(&v, "Mg2+")] = 1.0;
    shed[mix_at(&v, "OH-")] = 2.0;
    for (int k = 0; k < 60; k++) {
        double c[PD_SPECIES_MAX], middle = 0.5 * (low + high);
        for (int i = 0; i < v.species; i++) c[i] = held[i] + shed[i] * middle * CS * LAYER / 1e-9;
        CHECK_OK(&v.ctx, pd_speciation_solve(&all, c, &result));
        double ph = -result.log_activity[mix_at(&v, "H+")];
        if (law_of(&falling, 0.0, ph) > middle) low = middle;
        else high = middle;
    }
    if (!layer(&v, held, &falling, shed, activity, 1, 1)) return;
    if (!step_all(1e12)) return;
    if (!CHECK_REL(speed_of(), high, close)) NOTE("%g, %g", speed_of(), high);
    CHECK(high < 0.7 * falling.fastest);
    CHECK_LE(test_result.newton, 30);
    closed(shed, mix_at(&v, "Mg2+"));
    finish();
}

TEST(body_fluid_ideal) { body_fluid(PD_ACTIVITY_IDEAL, 1e-8); }
TEST(body_fluid_davies) { body_fluid(PD_ACTIVITY_DAVIES, 1e-4); }

/* A law that ends: it has a solution, beyond which it is no number, v = a sqrt(1 - v/b). One that is none where the
 * metal would dissolve has no step. */
TEST(no_number)
{
    for (int k = 0; k < 2; k++) {
        mixture v;
        double held[PD_SPECIES_MAX], shed[PD_SPECIES_MAX];
        saline(&v, 7.0, held, shed);
        const attack law_at = {k ? BLIND : ROOT, k ? 1e-6 : 3e-9, CS * 2e-9 * LAYER / 0.7e-9, MG - 1};
        if (!layer(&v, held, &law_at, shed, PD_ACTIVITY_IDEAL, 1, 1)) return;
        CHECK_INT(test_reactive.components.solute_of_species[MG], law_at.solute);
        if (k) {
            CHECK_INT(pd_reactive_step(&test_scene.ctx, &test_reactive, 1e12, &test_result), PD_RETRY);
            CHECK(test_etch.odd > 0);
        } else if (step_all(1e12)) {
            double half = 0.5 * 9e-18 / 2e-9; /* v^2 + a^2/b v = a^2 */
            CHECK_REL(speed_of(), sqrt(half * half + 9e-18) - half, 1e-7);
            CHECK_INT(test_etch.odd, 0);
        }
        finish();
    }
}

TEST_MAIN(ENTRY(layers) ENTRY(in_time) ENTRY(without_film) ENTRY(no_number)
          ENTRY(body_fluid_ideal) ENTRY(body_fluid_davies))
