/* pit: metal that dissolves by the potential of the ions that migrate before it, against a quadrature: under a law,
 * with water in equilibrium, under a salt film, beside a plane and a cylinder, in one step of any length and in many;
 * orders, charge and elements, currents that have nowhere to go; pits that deepen, as scenes.
 * dims: 1 2 */
#include "react/advance.h"
#include "react/etch.h"
#include "run/run.h"
#include "scene/scene.h"
#include "cases/pit.h"
#include "chemistry_case.h"
#include "fixture.h"

static scene test_scene;
static pd_reactive test_reactive;
static pd_etch test_etch;
static pd_reactive_result test_result;
static double test_end;  /* [m] where the bath is, along this axis: */
static int test_across;

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
    return x[test_across] > test_end ? 1.0 : (double)NAN;
}

/* What a pit is filled with beside salt. */
enum { SALT, WATER, HYDROLYSIS };

/* The metal behind the first cells of axis `across`, with the bath behind the last ones. Rings have their inner radius
 * `inner` [m]; 0: planes. */
static void surface(int across, double inner)
{
    scene *s = &test_scene;
    double h = s->grid.h[across], x[PD_DIM], d = test_reactive.diffusion.desc.diffusivity;
    pd_etch_open(&test_etch);
    for (int32_t i = 0; i < s->grid.total; i++) {
        if (s->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&s->grid, i, x);
        if (x[across] > s->grid.lo[across] + h) continue;
        double share = inner > 0.0 ? inner / x[across] : 1.0;
        double film = inner > 0.0 ? inner * log(x[across] / inner) : 0.5 * h;
        pd_etch_put(&test_etch, i, PIT_SOLID * share / h, PIT_SOLID * film / d);
    }
}

/* A pit of `cells` of the depth `length`. */
static int pit(mixture *v, steel *a, double length, int cells, double inner, int filled, int order)
{
    scene *s = &test_scene;
    double held[PD_SPECIES_MAX] = {0.0}, shed[PD_SPECIES_MAX] = {0.0}, h = length / cells;
    int across = inner > 0.0;
    pd_reactive_desc d;
    pd_etch_desc e;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    mix_begin(v);
    a->second = mix_species(v, "Fe2+", NULL, PIT_D);
    a->third = mix_species(v, "Fe3+", NULL, PIT_D);
    held[mix_species(v, "Na+", NULL, PIT_D_NA)] = PIT_BATH;
    held[mix_species(v, "Cl-", NULL, PIT_D_CL)] = PIT_BATH;
    if (filled != SALT) {
        held[mix_species(v, "H2O", NULL, 0.0)] = 55344.0;
        held[mix_species(v, "H+", NULL, 9.31e-9)] = 1e-4;
        held[mix_species(v, "OH-", NULL, 5.27e-9)] = 1e-4;
        mix_reaction(v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    }
    if (filled == HYDROLYSIS) {
        mix_species(v, "FeOH+", NULL, 0.75e-9);
        mix_reaction(v, "Fe2+ + H2O = FeOH+ + H+", -9.5, 0.0, NULL);
    }
    shed[a->second] = 1.0 - PIT_THIRD;
    shed[a->third] = PIT_THIRD;
    test_end = inner + length - 1e-3 * h;
    test_across = across;
    scene_box(s, 1.0, h, across ? 3 : cells, across ? cells : 3, 3);
    s->grid_desc.axisymmetric = across;
    if (across) {
        s->grid_desc.lo[across] = inner;
        s->grid_desc.hi[across] = inner + length;
    }
    for (int axis = 0; axis < PD_DIM; axis++)
        if (axis != across) s->grid_desc.side[2 * axis] = s->grid_desc.side[2 * axis + 1] = PD_SIDE_MIRROR;
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
    surface(across, inner);
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
static void closed(void)
{
    scene *s = &test_scene;
    pd_reactive_balance b;
    double given = 0.0, volume = test_reactive.bonds->stencil->volume;
    for (int32_t p = 0; p < test_etch.count; p++) {
        double around = pd_grid_circumference(&s->grid, test_etch.node[p]);
        given += volume * around * test_etch.weight[p] * test_etch.passed[p];
    }
    for (int row = 0; row < test_reactive.rows; row++) {
        pd_reactive_balance_of(&s->ctx, &test_reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
        if (strcmp(b.name, "Fe") == 0) CHECK_REL(b.in, given, 1e-9);
    }
    CHECK_LE(pd_reactive_neutrality(&test_reactive), 1e-14);
}

/* Error of the steady flux in one step from the bath, of so many times of diffusion. */
static double steady(double length, int cells, double inner, int filled, double times)
{
    mixture v;
    steel a = {PIT_HELD, 0, 0};
    double way = inner > 0.0 ? inner * log1p(length / inner) : length;
    pit_state wanted = pit_steady(PIT_HELD, way);
    if (!pit(&v, &a, length, cells, inner, filled, 1) || !step_all(times * length * length / PIT_D)) {
        finish();
        return HUGE_VAL;
    }
    double off = flux_of() / wanted.flux - 1.0;
    closed();
    finish();
    return off;
}

/* Under the law, and under a salt film: flux and orders. */
TEST(plane)
{
    static const double length[] = {1e-5, 1e-4, 1e-3}, most[] = {2e-5, 1e-4, 4e-4};
    CHECK(!pit_steady(PIT_HELD, length[1]).salt);
    CHECK(pit_steady(PIT_HELD, length[2]).salt);
    for (int k = 0; k < 3; k++) {
        double off[3];
        for (int n = 0; n < 3; n++) off[n] = steady(length[k], 20 << n, 0.0, SALT, 1e6);
        CHECK_LE(fabs(off[2]), most[k]);
        CHECK_LE(1.7, log2(off[0] / off[1]));
        CHECK_LE(1.8, log2(off[1] / off[2]));
    }
}

#if PD_DIM == 2
/* Around a cylinder, on rings. */
TEST(cylinder)
{
    double off[2];
    for (int n = 0; n < 2; n++) off[n] = steady(2e-5, 20 << n, 1e-5, SALT, 1e4);
    CHECK_LE(fabs(off[1]), 2e-4);
    CHECK_LE(1.7, log2(off[0] / off[1]));
}
#define PLANAR ENTRY(cylinder)
#else
#define PLANAR
#endif

/* H+ and OH- of neutral water carry next to nothing. Hydrolysis makes acid at the metal. */
TEST(water)
{
    mixture v;
    steel a = {PIT_HELD, 0, 0};
    double without = steady(1e-4, 20, 0.0, SALT, 1e4);
    CHECK_LE(fabs(steady(1e-4, 20, 0.0, WATER, 1e4) - without), 1e-6);
    if (!pit(&v, &a, 1e-4, 20, 0.0, HYDROLYSIS, 1)) return;
    for (int k = 0; k < 3; k++)
        if (!step_all(1e3)) return;
    CHECK_REL(flux_of(), pit_steady(PIT_HELD, 1e-4).flux, 0.01);
    const double *fe = pd_reactive_field(&test_reactive, a.second);
    const double *hydroxide = pd_reactive_field(&test_reactive, mix_at(&v, "FeOH+"));
    const double *acid = pd_reactive_field(&test_reactive, mix_at(&v, "H+"));
    int32_t i = test_etch.node[0];
    CHECK_REL(1e-3 * acid[i] * hydroxide[i] / fe[i], pow(10.0, -9.5), 1e-9);
    CHECK_LE(pd_reactive_ph(&test_reactive, i), 5.2);
    closed();
    finish();
}

/* One step of any length from the bath, with a law and up to a salt film: balances close, and the longest reach the
 * steady state. */
TEST(any_step)
{
    for (int k = 0; k < 2; k++) {
        double length = k ? 1e-3 : 1e-4, last = 0.0, wanted = pit_steady(PIT_HELD, length).flux;
        for (double times = 1e-6; times < 1e7; times *= 100.0) {
            mixture v;
            steel a = {PIT_HELD, 0, 0};
            if (!pit(&v, &a, length, 20, 0.0, SALT, 1)) return;
            if (!step_all(times * length * length / PIT_D)) NOTE("%g times", times);
            closed();
            last = flux_of();
            finish();
        }
        CHECK_REL(last, wanted, 5e-3);
    }
}

/* Two stages that go on in time reach the same state, and each closes. */
TEST(in_time)
{
    mixture v;
    steel a = {PIT_HELD, 0, 0};
    if (!pit(&v, &a, 1e-4, 20, 0.0, SALT, 2)) return;
    for (double dt = 1e-3; dt < 1e3; dt *= 1.5) {
        if (!step_all(dt)) return;
        closed();
    }
    CHECK_REL(flux_of(), pit_steady(PIT_HELD, 1e-4).flux, 1.5e-3);
    finish();
}

/* A current needs a way out. */
TEST(nowhere)
{
    mixture v;
    steel a = {PIT_HELD, 0, 0};
    if (!pit(&v, &a, 1e-4, 20, 0.0, SALT, 1)) return;
    for (int n = 0; n < test_reactive.components.solutes; n++) test_reactive.wall[n] = NAN;
    CHECK_INT(pd_reactive_step(&test_scene.ctx, &test_reactive, 1.0, &test_result), PD_ERR_ARGUMENT);
    CHECK(strstr(test_scene.ctx.message, "no inlet or wall that holds species") != NULL);
    finish();
}

/* ---- scenes ---- */

#if PD_DIM == 1
#define BOX "[grid] h = 0.5 um  box = 0 um .. 26 um  threads = 1\n[shape steel] box = 20 um .. 26 um"
#define SIDES
#else
#define BOX \
    "[grid] h = 0.5 um  box = 0 um .. 26 um, 0 um .. 3 um  threads = 1\n" \
    "[shape steel] box = 20 um .. 26 um, 0 um .. 3 um"
#define SIDES "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#endif
#define IONS(migration) \
    BOX "  kind = solid  material = steel304\n[side x-] species = inlet\n" SIDES \
    "[chemistry] activity = ideal  migration = " migration "\n[species Fe2+] D = 6.8957e-10 m2/s\n" \
    "[species Fe3+] D = 6.8957e-10 m2/s\n[species Na+] D = 1.332e-9 m2/s  initial = 1 mol/L\n" \
    "[species Cl-] D = 2.032e-9 m2/s  initial = 1 mol/L\n[transport] D = 6.8957e-10 m2/s\n" \
    "[run] until = 3 s  rtol = 0.002\n[constants] volt = 25.692579 mV\n"
#define LAW \
    "current = if([Fe2+] + [Fe3+] < 5.1 mol/L, 9.9 A/m2*exp(2.2022*0.65*(E + 240 mV)/volt), 0 A/m2)\n"
#define STEEL "Cs = 144423.1 mol/m3  charge = 2.2022\n"
#define HALF "reaction = Fe = 0.7978 Fe2+ + 0.2022 Fe3+ + 2.2022 e-\n"

/* A pit that deepens by 4 cells: its loss against finite volumes that grow with it, extrapolated in time. */
TEST(deepens)
{
    static const char text[] = IONS("yes") "[dissolve] potential = -75 mV  " STEEL LAW HALF;
    static pit_march march;
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    double v, coarse = pit_deepen(&march, PIT_HELD, 2e-5, 3.0, 60, &v);
    double wanted = 2.0 * pit_deepen(&march, PIT_HELD, 2e-5, 3.0, 120, &v) - coarse - 2e-5;
    CHECK_LE(fabs(coarse - 2e-5 - wanted), 2e-3 * wanted);
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, NULL, 0, &setup))) return;
    if (CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result))) {
        CHECK_REL(result.volume_loss * 6e-6, wanted, 2e-3);
        CHECK_LE(result.mass_balance_error, 1e-12);
    }
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

#if PD_DIM == 1
/* A pit 1 mm deep for 2000 s, half of it under a salt film, and with 0.1 V more, where the law is far from its limit:
 * what new cells hold and when it comes counts. Order 2. */
TEST(film)
{
    static const char *const set[] = {"run.until=2000 s"};
    static const double held[] = {PIT_HELD, PIT_HELD + 0.1}, most[] = {8e-4, 1.2e-3};
    static pit_march march;
    for (int k = 0; k < 2; k++) {
        double v, off[2], coarse = pit_deepen(&march, held[k], 1e-3, 2000.0, 60, &v);
        double wanted = 2.0 * pit_deepen(&march, held[k], 1e-3, 2000.0, 120, &v) - coarse - 1e-3;
        for (int n = 0; n < 2; n++) {
            char text[2048];
            pd_ctx ctx;
            pd_setup setup;
            pd_run_desc desc;
            pd_run_result result;
            pd_ctx_init(&ctx);
            memset(&desc, 0, sizeof desc);
            desc.no_files = 1;
            snprintf(text, sizeof text, "[grid] h = %d um  box = 0 mm .. 1.2 mm  threads = 1\n[shape steel] box = 1 mm "
                     ".. 1.2 mm%s\n[dissolve] potential = %g mV  " STEEL LAW HALF, n ? 25 : 50,
                     strstr(IONS("yes"), "  kind = solid"), 1e3 * held[k]);
            if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, set, 1, &setup))) return;
            if (CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result))) CHECK_LE(result.mass_balance_error, 1e-12);
            off[n] = fabs(result.volume_loss * 2e-4 / wanted - 1.0);
            pd_setup_free(&ctx, &setup);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_LE(off[1], most[k]);
        CHECK_LE(1.7, log2(off[0] / off[1]));
    }
}
#define LONG ENTRY(film)
#else
#define LONG
#endif

TEST(refused)
{
    static const char *const bad[][2] = {
        {IONS("no") "[dissolve] potential = -75 mV  " STEEL LAW HALF, "expected migration = yes"},
        {IONS("yes") "[dissolve] " STEEL LAW HALF, "'E'"},
        {IONS("yes") "[dissolve] potential = -75 mV * x/(1 m)  " STEEL LAW HALF, "of t alone"},
        {IONS("yes") "[dissolve] potential = -75 mV  " STEEL LAW "reaction = Fe = Fe2+ + 2 e-\n",
         "found 2 e- for one of"},
        {IONS("yes") "[dissolve] potential = -75 mV  " STEEL LAW "reaction = Fe = Fe2+ + 3 e-\n", "the charge is"},
        {IONS("no") "[dissolve] rate = 1 um/h  reaction = Fe = Fe2+ + 2 e-\n", "nothing carries the current"},
        {IONS("yes") "[dissolve] potential = -75 mV  " STEEL "current = 1 A/m2*C/Cs*E/volt\n" HALF,
         "found C beside pH"},
        {IONS("yes") "E = 1 V\n[dissolve] potential = -75 mV  " STEEL LAW HALF, "the name 'E'"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        pd_ctx ctx;
        pd_setup setup;
        pd_ctx_init(&ctx);
        if (CHECK(pd_scene_parse(&ctx, "a.scene", bad[k][0], NULL, 0, &setup) < 0)) {
            if (!CHECK(strstr(ctx.message, bad[k][1]) != NULL)) NOTE("%s", ctx.message);
        } else {
            pd_setup_free(&ctx, &setup);
        }
        CHECK_INT(ctx.in_use, 0);
    }
}

TEST_MAIN(ENTRY(plane) PLANAR ENTRY(water) ENTRY(any_step) ENTRY(in_time) ENTRY(nowhere) ENTRY(deepens)
          LONG ENTRY(refused))
