/* pit: metal that dissolves by the potential of the ions that migrate before it, against a quadrature: under a law, with
 * water in equilibrium, under a salt film, beside a plane and a cylinder, in one step of any length and in many; orders,
 * charge and elements, currents that have nowhere to go.
 * dims: 1 2 3 */
#include "react/advance.h"
#include "react/etch.h"
#include "../cases/pit.h"
#include "chemistry_case.h"
#include "fixture.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_etch test_etch;
static pd_reactive_result test_result;
static double test_end; /* [m] where the bath is */

typedef struct steel {
    double held; /* [V] */
    int second, third;
} steel;

static double law(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    const steel *a = (const steel *)user;
    (void)node;
    (void)ph;
    (void)t;
    return c[a->second] + c[a->third] < PIT_SATURATION ? pit_law(a->held - phi) / PIT_SOLID : 0.0;
}

static double at_end(void *user, const double *x)
{
    (void)user;
    return x[0] > test_end ? 1.0 : (double)NAN;
}

/* A pit of `cells` of the depth `length` along axis 0; the metal is behind x = 0. */
static int pit(mixture *v, steel *a, double length, int cells, double m, int water, int order)
{
    scene *s = &test_scene;
    double held[PD_SPECIES_MOST] = {0.0}, shed[PD_SPECIES_MOST] = {0.0}, h = length / cells, x[PD_DIM];
    pd_reactive_desc d;
    pd_etch_desc e;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    mix_begin(v);
    a->second = mix_species(v, "Fe2+", NULL, PIT_D);
    a->third = mix_species(v, "Fe3+", NULL, PIT_D);
    held[mix_species(v, "Na+", NULL, PIT_D_NA)] = PIT_BATH;
    held[mix_species(v, "Cl-", NULL, PIT_D_CL)] = PIT_BATH;
    if (water) {
        held[mix_species(v, "H2O", NULL, 0.0)] = 55344.0;
        held[mix_species(v, "H+", NULL, 9.31e-9)] = 1e-4;
        held[mix_species(v, "OH-", NULL, 5.27e-9)] = 1e-4;
        mix_reaction(v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    }
    shed[a->second] = 1.0 - PIT_THIRD;
    shed[a->third] = PIT_THIRD;
    test_end = length - 1e-3 * h;
    scene_box(s, m, h, cells, 3, 3);
    for (int axis = 1; axis < PD_DIM; axis++)
        s->grid_desc.side[2 * axis] = s->grid_desc.side[2 * axis + 1] = PD_SIDE_MIRROR;
    if (!scene_build(s)) return 0;
    d.species = v->s;
    d.count = v->species;
    d.reactions = v->r;
    d.reaction_count = v->reactions;
    d.temperature = PIT_TEMPERATURE;
    d.initial = d.wall = held;
    d.held = at_end;
    d.migration = 1;
    d.order = order;
    if (!CHECK_OK(&s->ctx, pd_reactive_build(&s->ctx, &s->grid, &s->bonds, NULL, &d, &test_reactive))) return 0;
    e.law = law;
    e.user = a;
    e.shed = shed;
    e.reads = (uint32_t)1 << a->second | (uint32_t)1 << a->third;
    e.reads_phi = 1;
    if (!CHECK_OK(&s->ctx, pd_etch_build(&s->ctx, &test_reactive, &e, &test_etch))) return 0;
    pd_etch_open(&test_etch);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        if (x[0] < h)
            pd_etch_put(&test_etch, i, PIT_SOLID / h,
                        PIT_SOLID * 0.5 * h / test_reactive.diffusion.desc.diffusivity);
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

static int step_all(double dt)
{
    int done = CHECK_OK(&test_scene.ctx, pd_reactive_step(&test_scene.ctx, &test_reactive, dt, &test_result));
    if (done) pdi_etch_accept(&test_etch);
    return done;
}

/* Flux of the metal [mol/m2/s], the same at all places. */
static double flux_of(void)
{
    double least = HUGE_VAL, most = 0.0;
    for (int32_t p = 0; p < test_etch.count; p++) {
        least = fmin(least, test_etch.speed[test_etch.node[p]]);
        most = fmax(most, test_etch.speed[test_etch.node[p]]);
    }
    CHECK_REL(most, least, 1e-7);
    return most * PIT_SOLID;
}

/* Elements and charge close; nodes are neutral; what metal has given is in. */
static void closed(const steel *a)
{
    scene *s = &test_scene;
    pd_reactive_balance b;
    double given = 0.0, volume = test_reactive.bonds->stencil->volume;
    for (int32_t p = 0; p < test_etch.count; p++) given += volume * test_etch.weight[p] * test_etch.passed[p];
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
        if (strcmp(b.name, "Fe") == 0) CHECK_REL(b.in, given, 1e-9);
        if (strcmp(b.name, "charge") == 0) CHECK_REL(b.in, given * PIT_ELECTRONS, 1e-9);
    }
    CHECK_LE(pd_reactive_neutrality(&test_reactive), 1e-14);
    (void)a;
}

/* Error of the steady flux in one step from the bath. */
static double steady(double held, double length, int cells, double m, int water, double dt)
{
    mixture v;
    steel a = {held, 0, 0};
    pit_state wanted = pit_steady(held, length);
    if (!pit(&v, &a, length, cells, m, water, 1) || !step_all(dt)) {
        finish();
        return HUGE_VAL;
    }
    double off = flux_of() / wanted.flux - 1.0;
    NOTE("L %g cells %d m %g water %d: off %.3e salt %d newton %d krylov %d parts %d", length, cells, m, water, off,
         wanted.salt, test_result.newton, test_result.krylov, test_result.parts);
    closed(&a);
    finish();
    return off;
}

TEST(plane)
{
    static const double length[] = {3e-4, 6e-4, 1e-3, 1e-2};
    for (int k = 0; k < 4; k++) {
        double off[3];
        for (int n = 0; n < 3; n++) off[n] = steady(PIT_HELD, length[k], 20 << n, 1.0, 0, 1e12);
        NOTE("orders %g %g", log2(off[0] / off[1]), log2(off[1] / off[2]));
    }
}

TEST(creep)
{
    mixture v;
    steel a = {PIT_HELD, 0, 0};
    double L = 1e-3;
    pit_state wanted = pit_steady(PIT_HELD, L);
    if (!pit(&v, &a, L, 20, 1.0, 0, 1)) return;
    for (double dt = 1e-2; dt < 1e7; dt *= 2.0) {
        pd_status st = pd_reactive_step(&test_scene.ctx, &test_reactive, dt, &test_result);
        double off = test_etch.speed[test_etch.node[0]] * PIT_SOLID / wanted.flux - 1.0;
        NOTE("dt %g st %d off %.3e newton %d krylov %d parts %d phi %g c %g", dt, st, off, test_result.newton, test_result.krylov, test_result.parts, test_reactive.migration.psi[test_etch.node[0]], test_reactive.c[test_etch.node[0]]);
        if (st) dt /= 20;
    }
    finish();
}

TEST(water) { steady(PIT_HELD, 1e-4, 20, 1.0, 1, 1e12); }

TEST_MAIN(ENTRY(creep) ENTRY(plane) ENTRY(water))
