/* course: species in scenes: titration of a closed box by its metal against a table, fronts of acid and base against a
 * closed form, one species against transport, what metal loses against what species gain, checkpoints, bad input.
 * dims: 1 2 */
#include "setup/fields.h"
#include "physics/model.h"
#include "physics/sample.h"
#include "run/field_view.h"
#include "scene/scene.h"
#include "checkpoint_model.h"
#include "test.h"
#include <stdlib.h>
#include <string.h>

#define IONS \
    "[species H+] D = 9.31e-9 m2/s\n[species OH-] D = 5.27e-9 m2/s\n[species Na+] D = 1.33e-9 m2/s\n" \
    "[species Cl-] D = 2.03e-9 m2/s\n[reaction water] H2O = H+ + OH-  log10_K = -14\n"
/* HBSS as of cases/validate/chemistry.h, whose table was computed without this program */
#define HBSS \
    "[chemistry] activity = ideal  pH = 7.4  counter_ion = Cl-  balance_ion = Na+\n" IONS \
    "[species Na+] initial = 145.73 mM\n[species Cl-] initial = 140 mM\n" \
    "[species HCO3-] D = 1e-9 m2/s  initial = 4.17 mM\n" \
    "[species HPO4-2] D = 1e-9 m2/s  initial = 0.78 mM\n[species H2PO4-] D = 1e-9 m2/s\n" \
    "[species PO4-3] D = 1e-9 m2/s\n[species CO3-2] D = 1e-9 m2/s  initial = 4.17 mM * 10^(7.4 - 10.329)\n" \
    "[species CO2] D = 2e-9 m2/s  initial = 4.17 mM * 10^(6.352 - 7.4)\n[species Mg2+] D = 0.7e-9 m2/s\n" \
    "[reaction a] CO2 + H2O = HCO3- + H+  log10_K = -6.352\n[reaction b] HCO3- = CO3-2 + H+  log10_K = -10.329\n" \
    "[reaction c] H2PO4- = HPO4-2 + H+  log10_K = -7.207\n[reaction d] HPO4-2 = PO4-3 + H+  log10_K = -12.346\n"
#define SURFACE "reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)"

#if PD_DIM == 1
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x "  threads = 1\n"
#define ACROSS ""
#define BLOCK(x) "[shape metal] kind = solid  box = " x "\n"
#define SPOT(x) "[shape spot] kind = solution  box = " x "\n"
#define DEEP ""
#else
#define BOX(h, x) "[grid] h = " h "  box = 0 .. " x ", 0 .. 3 * " h "  threads = 1\n"
#define ACROSS "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define BLOCK(x) "[shape metal] kind = solid  box = " x ", 0 .. 30 um\n"
#define SPOT(x) "[shape spot] kind = solution  box = " x ", 0 .. 30 um\n"
#define DEEP ", 0 .. 3 mm"
#endif

static pd_ctx test_ctx;
static pd_setup test_setup;
static pd_model test_model;

static int open_model(const char *text)
{
    pd_ctx_init(&test_ctx);
    if (!CHECK_OK(&test_ctx, pd_scene_parse(&test_ctx, "a.scene", text, NULL, 0, &test_setup))) return 0;
    return CHECK_OK(&test_ctx, pd_model_build(&test_ctx, &test_setup, &test_model));
}

static void close_model(void)
{
    pd_model_free(&test_ctx, &test_model);
    pd_setup_free(&test_ctx, &test_setup);
    CHECK_INT(test_ctx.in_use, 0);
}

static int run_to(double t)
{
    return CHECK_OK(&test_ctx, pd_time_loop_run(&test_ctx, &test_model.time_loop, t, 0.0, NULL, NULL));
}

/* All rows of the balance; `name` is that of one that is handed on. */
static pd_reactive_balance balances(const char *name)
{
    pd_reactive_balance b, found;
    memset(&found, 0, sizeof found);
    for (int row = 0; row < test_model.reactive.rows; row++) {
        pd_reactive_balance_of(&test_ctx, &test_model.reactive, row, &b);
        if (!CHECK_LE(b.relative, 1e-12)) NOTE("%s", b.name);
        if (strcmp(b.name, name) == 0) found = b;
    }
    CHECK_LE(pd_time_loop_imbalance(&test_model.time_loop), 1e-12);
    return found;
}

static const double *species(const char *name)
{
    return pd_reactive_field(&test_model.reactive, pd_electrolyte_find_species(&test_setup.electrolyte, name));
}

/* ---- metal ---- */

/* Metal dissolves so slowly that the box is even: each Mg brings 2 OH-. shared table: [mM] of OH-, pH. */
TEST(titration)
{
    static const double table[][2] = {{0.0, 7.400},  {0.05, 7.442}, {0.1, 7.486}, {0.2, 7.585}, {0.3, 7.701},
                                      {0.5, 8.027},  {0.75, 8.734}, {1.0, 9.214}, {1.5, 9.649}, {2.0, 9.906},
                                      {3.0, 10.275}, {5.0, 10.878}};
    static const char text[] = BOX("10 um", "100 um") BLOCK("0 .. 20 um") ACROSS HBSS
        "[transport] D = 0.7e-9 m2/s\n[dissolve] rate = 1e-14 m/s  " SURFACE "\n[run] until = 1 year  rtol = 0.01\n";
    if (!open_model(text)) return;
    double cs = test_setup.metal[0].solid_c, worst = 0.0;
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        /* 80 um of fluid get rate cs t, two OH- each */
        double t = table[k][0] * 80e-6 / (2.0 * 1e-14 * cs);
        if (k && !run_to(t)) return;
        if (!k) CHECK_OK(&test_ctx, pd_time_loop_start(&test_ctx, &test_model.time_loop));
        for (int32_t i = 0; i < test_model.grid.total; i++)
            if (test_model.grid.kind[i] == PD_FLUID)
                worst = fmax(worst, fabs(pd_sample_get_node(&test_model, PD_FIELD_PH, i) - table[k][1]));
    }
    CHECK_LE(worst, 2e-3);
    pd_reactive_balance mg = balances("Mg");
    CHECK_NEAR(mg.dissolved / (80e-6 * (PD_DIM == 2 ? 30e-6 : 1.0)), 2.5, 2e-9);
    close_model();
}

/* Nodes that turn fluid, in a stream in 2D: what the ledger of the metal has lost is in the species, and the gas. */
TEST(amounts)
{
#if PD_DIM == 2
    static const char text[] =
        "[grid] h = 10 um  box = 0 .. 300 um, 0 .. 120 um  threads = 1\n"
        "[side x-] flow = inlet  profile = parabola  mean = 0.5 mm/s\n[side x+] flow = outlet\n"
        "[shape metal] kind = solid  ball = 100 um, 50 um  radius = 26 um\n[flow] rho = 1000 kg/m3  mu = 1 mPa s\n"
#else
    static const char text[] = BOX("10 um", "200 um") BLOCK("0 .. 60 um")
#endif
        "[chemistry] activity = ideal\n" IONS "[species Na+] initial = 1 mM\n[species Cl-] initial = 1 mM\n"
        "[species Mg2+] D = 0.7e-9 m2/s\n[transport] D = 0.7e-9 m2/s\n"
        "[dissolve] rate = 4 um/h  threshold = 0.01  " SURFACE "\n[run] until = 3 h  rtol = 0.02\n";
    if (!open_model(text)) return;
    int64_t solid = test_model.grid.solid_count;
    if (!run_to(3.0 * 3600.0)) return;
    CHECK(test_model.grid.solid_count < solid);
    const pd_mass_balance *l = &test_model.time_loop.ledger[0];
    double lost = l->solid_start - l->solid;
    pd_reactive_balance mg = balances("Mg");
    CHECK(lost > 0.05 * l->solid_start);
    /* back: by diffusion against the stream, through the inlet */
    double taken = test_model.species_integrator.taken, back = taken - mg.in;
    CHECK(back >= 0.0 && back <= 1e-9 * taken);
    CHECK_NEAR((taken - lost) / l->solid_start, 0.0, 1e-12);
    CHECK_NEAR((mg.dissolved + mg.out + mg.carry + back - lost) / l->solid_start, 0.0, 1e-12);
    CHECK_NEAR((taken - l->dissolved - l->carried_residual - l->out + l->in) / l->solid_start, 0.0, 1e-12);
    CHECK_NEAR(test_setup.metal[0].gas_released, 1.0, 0.0);
    close_model();
}

/* A stream so fast that its exchange is 1e9 times what the metal gives: steps grow to those of the metal, and what
 * empty nodes owe by rounding is not carried off. */
TEST(fast_stream)
{
#if PD_DIM == 2
    static const char text[] =
        "[grid] h = 10 um  box = 0 .. 300 um, 0 .. 120 um  threads = 1\n"
        "[side x-] flow = inlet  profile = parabola  mean = 0.2 m/s\n[side x+] flow = outlet\n"
        "[shape metal] kind = solid  ball = 100 um, 50 um  radius = 26 um\n[flow] rho = 1000 kg/m3  mu = 1 mPa s\n"
        "[chemistry] activity = ideal  pH = 7.4  counter_ion = Na+\n" IONS
        "[species Na+] initial = 4 mM\n[species HCO3-] D = 1.18e-9 m2/s  initial = 4 mM\n"
        "[species CO2] D = 1.92e-9 m2/s\n[species Mg2+] D = 0.7e-9 m2/s\n"
        "[reaction a] CO2 + H2O = HCO3- + H+  log10_K = -6.352\n"
        "[transport] D = 0.7e-9 m2/s\n[dissolve] rate = 1 um/h  " SURFACE "\n[run] until = 3 h  rtol = 0.004\n";
    if (!open_model(text)) return;
    if (!run_to(3.0 * 3600.0)) return;
    CHECK_LE((double)test_model.species_integrator.steps, 400.0);
    CHECK_LE((double)test_model.species_integrator.newton, 4000.0);
    NOTE("%d steps, %d of Newton", (int)test_model.species_integrator.steps, (int)test_model.species_integrator.newton);
    balances("Mg");
    close_model();
#else
    SKIP("in 2D: a stream past metal");
#endif
}

/* A law in pH: a closed box whose metal dissolves ever more slowly. A pool of base: dB/dt = 2 Cs v(pH)/width. */
TEST(law_in_ph)
{
    static const char text[] = BOX("10 um", "100 um") BLOCK("0 .. 40 um") ACROSS "[chemistry] activity = ideal\n" IONS
        "[species Na+] initial = 145 mM\n[species Cl-] initial = 145 mM\n[species Mg2+] D = 0.7e-9 m2/s\n"
        "[transport] D = 0.7e-9 m2/s\n[dissolve] rate = 1e-13 m/s * 10^(0.3*(7 - pH))  " SURFACE
        "\n[run] until = 40 h  rtol = 2e-4\n";
    if (!open_model(text)) return;
    if (!run_to(144000.0)) return;
    double cs = test_setup.metal[0].solid_c, base = 0.0, t = 0.0, width = 60e-6;
    const pd_mass_balance *l = &test_model.time_loop.ledger[0];
    double lost = (l->solid_start - l->solid) / (PD_DIM == 2 ? 30e-6 : 1.0);
    for (int n = 0; n < 400000; n++) { /* as if it were stirred: the layer is thin for such speeds */
        double dt = 144000.0 * (n < 200000 ? 5e-9 : 0.999 / 200000.0), oh = 0.5 * (base + sqrt(base * base + 4e-8));
        base += dt * 2.0 * cs / width * 1e-13 * pow(10.0, 0.3 * (7.0 - (11.0 + log10(oh))));
        t += dt;
    }
    CHECK_REL(t, 144000.0, 1e-9);
    CHECK_REL(lost, 0.5 * base * width, 0.01);
    pd_reactive_balance mg = balances("Mg");
    CHECK_NEAR((test_model.species_integrator.taken - (l->solid_start - l->solid)) / mg.in, 0.0, 1e-9);
    CHECK(fabs(l->relative_imbalance) <= 1e-12);
    close_model();
}

/* The same by bonds, with nodes that turn: what metal has lost is in the species, and the gas. A law in a species. */
/* Pores that narrow as a solid grows everywhere: what has come through them after a time is of second order. */
TEST(narrowing)
{
    double came[3];
    for (int k = 0; k < 3; k++) {
        char text[1536];
        snprintf(text, sizeof text, "%s%s[side x-] species = inlet\n[chemistry] activity = ideal  tortuosity = 1\n"
                 "[species Na+] D = 1e-9 m2/s  inlet = 10 mM\n[species Cl-] D = 1e-9 m2/s  inlet = 10 mM\n"
                 "[species Mg2+] D = 1e-12 m2/s  initial = 1 mol/L  inlet = 1 mol/L\n"
                 "[species SO4-2] D = 1e-12 m2/s  initial = 1 mol/L  inlet = 1 mol/L\n"
                 "[species MgSO4(s)] volume = 4e-3 m3/mol  initial = 20 mol/m3\n[species H2O]\n"
                 "[reaction s] MgSO4(s) = Mg2+ + SO4-2  K = 0.9 mol2/L2\n"
                 "[mineral MgSO4(s)] rate = 1 mol/m2/s  area = 2 1/m  porosity = 0.01\n"
                 "[run] until = 400 s  rtol = 0.1  max_step = %.17g s\n", BOX("50 um", "1 mm"), ACROSS,
                 40.0 / (1 << k));
        if (!open_model(text)) return;
        if (!run_to(400.0)) return;
        came[k] = balances("Na").dissolved;
        close_model();
    }
    NOTE("%.3e %.3e, order %.2f", came[0] / came[2] - 1.0, came[1] / came[2] - 1.0,
         log2(fabs((came[0] - came[1]) / (came[1] - came[2]))));
    CHECK_LE(1.7, log2(fabs((came[0] - came[1]) / (came[1] - came[2]))));
}

/* A law that overflows where nothing dissolves is met where base has taken the phosphate: as one that ends at e^690. */
TEST(law_that_overflows)
{
#define FALLS(x) \
    BOX("1 mm", "20 mm") "[shape metal] kind = solid  box = 0 .. 4 mm" DEEP "\n" ACROSS HBSS \
    "[side x+] species = inlet\n[transport] D = 1e-9 m2/s\n" \
    "[dissolve] rate = 1e-6 um/h*exp(" x ")  " SURFACE "\n[run] until = 1 min\n"
    double taken[2];
    static const char *const text[] = {FALLS("[HPO4-2]/(1e-4 mol/m3)"), FALLS("min([HPO4-2]/(1e-4 mol/m3), 690)")};
    for (int k = 0; k < 2; k++) {
        if (!open_model(text[k])) return;
        run_to(60.0);
        taken[k] = test_model.species_integrator.taken;
        close_model();
    }
    CHECK(taken[0] > 0.0);
    CHECK_REL(taken[0], taken[1], 1e-9);
}

TEST(corrode)
{
    static const char text[] = BOX("10 um", "500 um") BLOCK("0 .. 100 um") ACROSS "[chemistry] activity = ideal\n" IONS
        "[species Na+] initial = 1 mM\n[species Cl-] initial = 1 mM\n[species Mg2+] D = 0.7e-9 m2/s\n"
        "[corrode] rate = 40 um/h / (1 + [Mg2+]/(5 mol/L))  Csat = 5 mol/L  D = 0.7e-9 m2/s  " SURFACE
        "\n[run] until = 0.6 h\n";
    if (!open_model(text)) return;
    int64_t solid = test_model.grid.solid_count;
    if (!run_to(2160.0)) return;
    CHECK(test_model.grid.solid_count < solid);
    const pd_mass_balance *l = &test_model.time_loop.ledger[0];
    double lost = l->solid_start - l->solid, owed = 0.0;
    pd_reactive_balance mg = balances("Mg");
    for (int32_t i = 0; i < test_model.grid.total; i++) /* given by the last step, and taken by the next */
        if (test_model.grid.kind[i] == PD_FLUID) owed += test_model.dissolve.shed[i] * test_model.stencil.volume;
    CHECK_NEAR((mg.dissolved + mg.carry + owed - lost) / lost, 0.0, 1e-10);
    CHECK_NEAR((test_model.species_integrator.taken + owed - lost) / lost, 0.0, 1e-10);
    CHECK_LE(fabs(owed), 0.02 * lost);
    CHECK_LE(fabs(l->relative_imbalance), 1e-12);
    CHECK_NEAR(test_setup.metal[0].gas_released, 1.0, 0.0);
    close_model();
}

/* Salt in a shape spreads between closed walls: the cosines of its series. */
TEST(solutions)
{
    static const char text[] = BOX("10 um", "500 um") SPOT("0 .. 250 um") ACROSS
        "[chemistry] activity = ideal  inside_pH = 3  counter_ion = Cl-\n" IONS
        "[species K+] D = 2e-9 m2/s  inside = 10 mM\n[species Br-] D = 2e-9 m2/s  inside = 10 mM\n"
        "[run] until = 20 s\n[total all]\n";
    if (!open_model(text)) return;
    int low[PD_DIM];
    memset(low, 0, sizeof low);
    CHECK_NEAR(pd_sample_get_node(&test_model, PD_FIELD_PH, pd_grid_node(&test_model.grid, low)), 3.0, 1e-6);
    if (!run_to(20.0)) return;
    const double *k = species("K+");
    double worst = 0.0, pi = 3.14159265358979324, x[PD_DIM];
    for (int32_t i = 0; i < test_model.grid.total; i++) {
        double c = 5.0;
        if (test_model.grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&test_model.grid, i, x);
        for (int n = 1; n < 20; n += 2)
            c += 20.0 / (n * pi) * (n % 4 == 1 ? 1.0 : -1.0) * cos(n * pi * x[0] / 500e-6) *
                 exp(-pow(n * pi / 500e-6, 2.0) * 2e-9 * 20.0);
        worst = fmax(worst, fabs(k[i] - c));
    }
    CHECK_LE(worst, 2e-3);
    balances("K");
    close_model();
}

/* A mineral in equilibrium with the film of a disc, in all of the fluid: it is used up and comes back node by node. */
TEST(mineral_in_equilibrium)
{
#if PD_DIM == 2
    static const char text[] =
        "[grid] h = 20 um  box = 0 .. 600 um, 0 .. 600 um  threads = 1\n"
        "[shape metal] kind = solid  ball = 0, 0  radius = 200 um\n[side x-] flow = mirror\n[side y-] flow = mirror\n"
        "[chemistry] activity = ideal\n" IONS
        "[species Na+] initial = 154 mM\n[species Cl-] initial = 154 mM\n[species Mg2+] D = 0.7e-9 m2/s\n"
        "[species Mg(OH)2(s)] volume = 24.6e-6 m3/mol\n[reaction brucite] Mg(OH)2(s) = Mg2+ + 2 OH-  log10_K = -11\n"
        "[mineral Mg(OH)2(s)]\n[transport] D = 0.7e-9 m2/s\n[dissolve] rate = 4 um/h * 10^(0.1*(7 - pH))  " SURFACE "\n"
        "[run] until = 900 s  rtol = 0.02\n";
    if (!open_model(text)) return;
    if (run_to(900.0)) {
        const pd_course *course = &test_model.species_integrator;
        CHECK_LE((double)course->newton, 25.0 * (double)course->steps);
        CHECK_LE((double)course->steps, 4.0);
        balances("Mg");
        NOTE("%d steps, %d of Newton", (int)course->steps, (int)course->newton);
    }
    close_model();
#else
    SKIP("in 2D: a disc");
#endif
}

/* Salt in a corner that meets water with a millionth of it: one salt has the potential (D- - D+)/(D- + D+) ln c, here
 * against that of the saltiest node, where the lattice resolves the dilution. */
TEST(corner)
{
#if PD_DIM == 2
    static const char text[] =
        "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 200 um  threads = 1\n"
        "[shape spot] kind = solution  box = 0 .. 100 um, 0 .. 100 um\n[chemistry] activity = ideal  migration = yes\n"
        "[species Na+] D = 1.33e-9 m2/s  initial = 1e-4 mol/m3  inside = 100 mol/m3\n"
        "[species Cl-] D = 2.03e-9 m2/s  initial = 1e-4 mol/m3  inside = 100 mol/m3\n[run] until = 1 s  rtol = 0.02\n";
    int low[PD_DIM];
    memset(low, 0, sizeof low);
    if (!open_model(text)) return;
    if (!run_to(1.0)) return;
    const double *c = species("Na+"), *psi = test_model.reactive.migration.psi;
    int32_t salt = pd_grid_node(&test_model.grid, low);
    double worst = 0.0;
    int nodes = 0;
    for (int32_t i = 0; i < test_model.grid.total; i++) {
        if (test_model.grid.kind[i] != PD_FLUID || !(c[i] > 1.0)) continue;
        worst = fmax(worst, fabs(psi[i] - psi[salt] - 0.7 / 3.36 * log(c[i] / c[salt])));
        nodes++;
    }
    NOTE("%d nodes, psi off by %.1e, %d steps, %d of Newton, %d of GMRES", nodes, worst,
         (int)test_model.species_integrator.steps, (int)test_model.species_integrator.newton,
         (int)test_model.species_integrator.krylov);
    CHECK(nodes > 200);
    CHECK_LE(worst, 0.01);
    CHECK_LE((double)test_model.species_integrator.krylov, 3000.0);
    CHECK_LE(pd_reactive_neutrality(&test_model.reactive), 1e-12);
    balances("Na");
    close_model();
#else
    SKIP("in 2D: a corner");
#endif
}

/* A wall holds what enters: 2 c sqrt(D t/pi) has come in before it reaches the other one. */
TEST(walls)
{
    static const char text[] = BOX("10 um", "500 um") ACROSS
        "[side x-] species = inlet\n"
        "[chemistry] activity = ideal  inlet_pH = 10  counter_ion = Na+\n" IONS
        "[species K+] D = 2e-9 m2/s  inlet = 10 mM\n[species Br-] D = 2e-9 m2/s  inlet = 10 mM\n"
        "[run] until = 5 s  rtol = 1e-4\n";
    if (!open_model(text)) return;
    if (!run_to(5.0)) return;
    double width = PD_DIM == 2 ? 30e-6 : 1.0, wanted = 2.0 * 10.0 * sqrt(2e-9 * 5.0 / 3.14159265358979324);
    pd_reactive_balance b = balances("K");
    CHECK_REL(b.dissolved / width, wanted, 0.003);
    CHECK_REL(b.in / width, wanted, 0.003);
    close_model();
}

/* ---- metal under minerals ---- */

/* Metal beside salt of Omega = 2, of which each cell of 10 um holds a share. Its volume is so large that the solution
 * does not feel what forms. */
#define SALT_BESIDE(chemistry, initial, mineral) \
    "[chemistry] activity = ideal  " chemistry "\n" \
    "[species Na+] D = 1e-9 m2/s  initial = 1 mol/L\n[species Cl-] D = 1e-9 m2/s  initial = 1 mol/L\n" \
    "[species NaCl(s)] volume = 10 m3/mol  initial = " initial "\n" \
    "[reaction halite] NaCl(s) = Na+ + Cl-  K = 0.5 mol2/L2\n[mineral NaCl(s)] area = 1 1/m  " mineral "\n"
#define COVERED(chemistry, initial, mineral, metal, run) \
    BOX("10 um", "100 um") BLOCK("0 .. 40 um") ACROSS SALT_BESIDE(chemistry, initial, mineral) \
    "[transport] D = 1e-9 m2/s\n[dissolve] " metal "\n[run] until = 1 h  " run "\n"
#define STILL "rate = 1e-30 mol/m2/s"
#define GROWING "rate = 1e-6 mol/m2/s"

/* [m] that the metal has receded after an hour. */
static double receded(const char *text)
{
    if (!open_model(text)) return NAN;
    run_to(3600.0);
    const pd_mass_balance *l = &test_model.time_loop.ledger[0];
    double lost = (l->solid_start - l->solid) / test_setup.metal[0].solid_c / (PD_DIM == 2 ? 30e-6 : 1.0);
    CHECK_LE(fabs(l->relative_imbalance), 1e-12);
    close_model();
    return lost;
}

/* A film of 2 um that stays: exp(-d/d0) of the speed, to rounding; all of it without `cover`. */
TEST(covered)
{
    double bare = receded(COVERED("", "0.02 mol/m3", STILL, "rate = 4 um/h", ""));
    CHECK_REL(bare, 4e-6, 1e-12);
    CHECK_REL(receded(COVERED("covering_thickness = 2 um", "0.02 mol/m3", STILL, "rate = 4 um/h", "")),
              4e-6 * exp(-1.0), 1e-9);
    CHECK_REL(receded(COVERED("covering_thickness = 0.5 um", "0.02 mol/m3", STILL, "rate = 4 um/h", "")),
              4e-6 * exp(-4.0), 1e-8);
    CHECK_REL(receded(COVERED("covering_thickness = 2 um", "0", STILL, "rate = 4 um/h", "")), bare, 1e-12);
}

/* Beside boundaries of grains, by bonds, and around corners all metal that dissolves is covered. */
TEST(covered_all)
{
    static const struct { const char *bare, *covered; } of[] = {
#define BOTH(text) {text(""), text("covering_thickness = 2 um")}
#define GRAINS(cover) \
    COVERED(cover, "0.02 mol/m3", STILL, "rate = 1 um/h  grain_boundary_factor = 3", \
            "\n[shape metal] grain_size = 15 um  grain_boundary_width = 8 um")
#define BONDS(cover) \
    BOX("10 um", "200 um") BLOCK("0 .. 80 um") ACROSS SALT_BESIDE(cover, "0.02 mol/m3", STILL) \
    "[corrode] rate = 1 um/h  Csat = 5 mol/L  D = 1e-9 m2/s\n[run] until = 1 h\n"
        BOTH(GRAINS), BOTH(BONDS)
#if PD_DIM == 2
#define PIN(cover) \
    "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 200 um  threads = 1\n" SALT_BESIDE(cover, "0.02 mol/m3", STILL) \
    "[shape metal] ball = 100 um, 100 um  radius = 52 um  kind = solid\n" \
    "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n[run] until = 1 h\n"
        , BOTH(PIN)
#endif
    };
    for (size_t k = 0; k < sizeof of / sizeof of[0]; k++) {
        double bare = receded(of[k].bare);
        CHECK(bare > 0.5e-6);
        CHECK_REL(receded(of[k].covered) / bare, exp(-1.0), 1e-9);
    }
}

/* One that grows at the speed g from nothing: the integral v d0/g (1 - exp(-g t/d0)). The error of a step of the run is
 * that of the mean of both ends. */
TEST(covered_more_and_more)
{
#define MORE(run) COVERED("covering_thickness = 0.2 um", "0", GROWING, "rate = 4 um/h", run)
    /* h V k A (Omega - 1) */
    double g = 10e-6 * 10.0 * 1e-6, end = 4e-6 / 3600.0 * 0.2e-6 / g * (1.0 - exp(-g * 3600.0 / 0.2e-6));
    double found = receded(MORE("")) / end - 1.0, off[3];
    NOTE("off by %.1e", found);
    CHECK_LE(fabs(found), 0.004); /* rtol of the run */
    off[0] = receded(MORE("max_step = 200 s")) / end - 1.0;
    off[1] = receded(MORE("max_step = 100 s")) / end - 1.0;
    off[2] = receded(MORE("max_step = 50 s")) / end - 1.0;
    NOTE("%.2e, %.2e, %.2e", off[0], off[1], off[2]);
    CHECK(log(off[1] / off[2]) / log(2.0) >= 1.8);
    CHECK_LE(fabs(off[2]), 4e-4);
}

/* Magnesium in saline makes base, which lays down the hydroxide that covers it: [m] receded after an hour, and by how
 * much of it the species are behind. Balances close whatever the steps, and steps grow to those of the film, with many
 * times more of the mineral in one than is dissolved. */
#define FILM(law, run) \
    BOX("10 um", "100 um") \
    BLOCK("0 .. 40 um") \
    ACROSS \
    "[chemistry] activity = ideal  migration = yes  covering_thickness = 2 um\n" IONS \
    "[species Na+] initial = 145 mM\n[species Cl-] initial = 145 mM\n[species Mg2+] D = 0.7e-9 m2/s\n" \
    "[species Mg(OH)2(s)] volume = 24.6e-6 m3/mol\n[reaction brucite] Mg(OH)2(s) = Mg2+ + 2 OH-  log10_K = -11\n" \
    "[mineral Mg(OH)2(s)] area = 1e4 1/m  rate = 1e-6 mol/m2/s\n[transport] D = 0.7e-9 m2/s\n" \
    "[dissolve] rate = " law "  " SURFACE "\n[run] until = 1 h  " run "\n"
#define BY_PH "2 um/h * 10^(0.1*(7 - pH))"

static double filmed(const char *text, double *behind)
{
    double lost = NAN;
    *behind = NAN;
    if (!open_model(text)) return lost;
    if (run_to(3600.0)) {
        const pd_mass_balance *l = &test_model.time_loop.ledger[0];
        const pd_course *course = &test_model.species_integrator;
        lost = l->solid_start - l->solid;
        *behind = 1.0 - course->taken / lost;
        CHECK_LE(fabs(l->relative_imbalance), 1e-12);
        CHECK_LE(pd_reactive_neutrality(&test_model.reactive), 1e-12);
        balances("Mg");
        CHECK_LE((double)course->steps, 150.0 + 4.0 * (double)test_model.time_loop.steps);
        lost /= test_setup.metal[0].solid_c * (PD_DIM == 2 ? 30e-6 : 1.0);
        NOTE("%.5g um, species %.1e behind, %d steps, %d of species, %d not taken, %d of Newton, %d of GMRES",
             1e6 * lost, *behind, (int)test_model.time_loop.steps, (int)course->steps, (int)course->rejected,
             (int)course->newton, (int)course->krylov);
    }
    close_model();
    return lost;
}

/* Both ways of the law: in pH, and with a speed that only the film changes. */
#define STEPS(law) {FILM(law, ""), FILM(law, "max_step = 80 s"), FILM(law, "max_step = 20 s")}
TEST(all_together)
{
    static const char *const of[][3] = {STEPS(BY_PH), STEPS("1 um/h")};
    for (size_t law = 0; law < sizeof of / sizeof of[0]; law++) {
        double lost[3], behind[3];
        for (int k = 0; k < 3; k++) lost[k] = filmed(of[law][k], &behind[k]);
        CHECK_LE(fabs(lost[0] / lost[2] - 1.0), 0.004); /* rtol of the run */
        CHECK_LE(fabs(lost[1] / lost[2] - 1.0), 1e-4);
        CHECK_LE(fabs(behind[0]), 0.004);
        double order = log(behind[1] / behind[2]) / log(4.0);
        NOTE("order %.2f", order);
        CHECK(order >= 1.8);
    }
}

/* ---- fronts, one species ---- */

#define GIVEN(vx) "[flow] rho = 1000 kg/m3  mu = 1 mPa s  time = prescribed  vx = " vx "\n"

/* Base flows into acid, all of one D: u = OH - H+ diffuses in the stream, and the front stands where it is 0. With a
 * value held at the inlet u = -a + (a + b) F of Ogata and Banks (1961). */
static double carried(double x, double v, double d, double t)
{
    double root = 2.0 * sqrt(d * t);
    return 0.5 * (erfc((x - v * t) / root) + exp(v * x / d) * erfc((x + v * t) / root));
}

TEST(front)
{
    static const char text[] =
        BOX("10 um", "1 mm") ACROSS "[side x-] flow = inlet  profile = uniform  mean = 20 um/s\n"
        "[side x+] flow = outlet\n" GIVEN("20 um/s")
        "[chemistry] activity = ideal\n[species H+] D = 2e-9 m2/s  initial = 1 mM\n"
        "[species OH-] D = 2e-9 m2/s  inlet = 2 mM\n"
        "[species Na+] D = 2e-9 m2/s  inlet = 2 mM\n[species Cl-] D = 2e-9 m2/s  initial = 1 mM\n"
        "[reaction water] H2O = H+ + OH-  log10_K = -14\n[species OH-] initial = 0\n[species H+] inlet = 0\n"
        "[species Cl-] inlet = 0\n[run] until = 12 s\n";
    double place = 0.0, before = 0.0, low = 0.0, high = 1e-3;
    if (!open_model(text)) return;
    if (!run_to(12.0)) return;
    const double *h = species("H+"), *oh = species("OH-");
    for (int k = 0; k < test_model.grid.n[0]; k++) {
        int at[PD_DIM];
        memset(at, 0, sizeof at);
        at[0] = k;
        int32_t i = pd_grid_node(&test_model.grid, at);
        double u = oh[i] - h[i];
        if (k && before > 0.0 && u <= 0.0) place = 1e-5 * (k - 0.5 + before / (before - u));
        before = u;
    }
    for (int k = 0; k < 60; k++) {
        double x = 0.5 * (low + high);
        if (3.0 * carried(x, 20e-6, 2e-9, 12.0) > 1.0) low = x;
        else high = x;
    }
    CHECK_NEAR(place / low, 1.0, 4e-3);
    balances("");
    close_model();
}

/* As transport with upwinded fluxes in the same run. */
TEST(one_species)
{
    static const char text[] =
        BOX("10 um", "300 um") ACROSS "[side x-] flow = inlet  profile = uniform  mean = 0.1 mm/s  C = 1 mol/m3\n"
        "[side x+] flow = outlet\n" GIVEN("0.1 mm/s")
        "[transport] D = 2e-9 m2/s  advection = upwind  initial = 0.25 mol/m3\n"
        "[chemistry]\n[species glucose] formula = C6H12O6  charge = 0  D = 2e-9 m2/s  initial = 0.25 mM  inlet = 1 mM\n"
        "[run] until = 1.5 s  rtol = 1e-5\n";
    double worst = 0.0, size = 0.0;
    if (!open_model(text)) return;
    if (!run_to(1.5)) return;
    const double *c = species("glucose");
    for (int32_t i = 0; i < test_model.grid.total; i++) {
        if (test_model.grid.kind[i] != PD_FLUID) continue;
        worst = fmax(worst, fabs(c[i] - test_model.transport.c[i]));
        size = fmax(size, fabs(c[i] - 0.25));
    }
    CHECK(size > 0.3);
    CHECK_LE(worst, 2e-4);
    balances("C");
    close_model();
}

/* Steady fields are those after a long time, and need no [run]. */
TEST(steady)
{
#define STREAM \
    BOX("10 um", "300 um") ACROSS "[side x-] flow = inlet  profile = uniform  mean = 0.1 mm/s\n" \
    "[side x+] flow = outlet\n" GIVEN("0.1 mm/s") IONS \
    "[species Na+] inlet = 1 mM\n[species OH-] inlet = 1 mM\n[species H+] inlet = 0\n"
    double kept[64];
    int count = 0;
    if (!open_model(STREAM "[chemistry] activity = ideal  time = steady\n")) return;
    CHECK_OK(&test_ctx, pd_time_loop_start(&test_ctx, &test_model.time_loop));
    for (int k = 0; k < 30; k++) {
        int at[PD_DIM];
        memset(at, 0, sizeof at);
        at[0] = k;
        kept[count++] = pd_reactive_ph(&test_model.reactive, pd_grid_node(&test_model.grid, at));
        CHECK_NEAR(kept[k], 11.0, 1e-6);
    }
    close_model();
    if (!open_model(STREAM "[chemistry] activity = ideal\n[run] until = 200 s\n")) return;
    if (!run_to(200.0)) return;
    for (int k = 0; k < count; k++) {
        int at[PD_DIM];
        memset(at, 0, sizeof at);
        at[0] = k;
        CHECK_NEAR(pd_reactive_ph(&test_model.reactive, pd_grid_node(&test_model.grid, at)), kept[k], 1e-4);
    }
    balances("charge");
    close_model();
}

/* ---- fields, checkpoints ---- */

TEST(fields)
{
    static const char text[] = BOX("10 um", "60 um") HBSS
        "[run] until = 1 s\n[output] fields = pH, Mg2+, HCO3-, kind\n[probe a] at = 30 um" /* and the other axis: */
#if PD_DIM == 2
        ", 15 um"
#endif
        "  fields = pH, Na+\n";
    pd_field_views views;
    pd_field_view v;
    double x[2] = {30e-6, 15e-6};
    memset(&views, 0, sizeof views);
    if (!open_model(text)) return;
    if (!run_to(1.0)) return;
    pd_field field = (pd_field)pd_fields_find(&test_setup, "HCO3-");
    CHECK_STR(pd_fields_get_label(&test_setup, field), "HCO3- [mol/m3]");
    CHECK_OK(&test_ctx, pdi_field_view_get(&test_ctx, &test_model, &views, "pH", &v));
    CHECK_NEAR(v.data[0], 7.4, 1e-6);
    CHECK_NEAR(pd_sample_get_point(&test_model, PD_FIELD_PH, 0, x), 7.4, 1e-6);
    CHECK_OK(&test_ctx, pdi_field_view_get(&test_ctx, &test_model, &views, "HCO3-", &v));
    CHECK_NEAR(v.data[0], 4.17, 1e-12);
    CHECK_NEAR(pd_sample_get_point(&test_model, field, 0, x), v.data[0], 1e-12);
    CHECK(pdi_field_view_get(&test_ctx, &test_model, &views, "H2O", &v) == PD_ERR_ARGUMENT);
    pdi_field_view_free(&test_ctx, &views);
    close_model();
}

static void resumed(const char *text, double t)
{
    size_t size;
    if (!open_model(text)) return;
    if (!run_to(t)) return;
    CHECK_OK(&test_ctx, checkpoint_save(&test_ctx, "build/test_course.checkpoint", &test_model));
    if (!run_to(2.0 * t)) return;
    size = (size_t)test_model.reactive.components.solutes * (size_t)test_model.grid.total;
    double *kept = (double *)malloc(size * sizeof *kept), taken = test_model.species_integrator.taken;
    double left = test_model.time_loop.ledger[0].solid;
    if (!CHECK(kept != NULL)) return;
    memcpy(kept, test_model.reactive.c, size * sizeof *kept);
    close_model();
    if (!open_model(text)) return;
    if (!CHECK_OK(&test_ctx, checkpoint_load(&test_ctx, "build/test_course.checkpoint", &test_model))) return;
    if (!run_to(2.0 * t)) return;
    CHECK(memcmp(kept, test_model.reactive.c, size * sizeof *kept) == 0);
    CHECK(taken > 0.0 && memcmp(&taken, &test_model.species_integrator.taken, sizeof taken) == 0);
    CHECK(memcmp(&left, &test_model.time_loop.ledger[0].solid, sizeof left) == 0);
    balances("Mg");
    free(kept);
    close_model();
}

#define RESUMED(rate) \
    BOX("10 um", "100 um") BLOCK("0 .. 30 um") ACROSS HBSS "[transport] D = 0.7e-9 m2/s\n[dissolve] rate = " rate \
    "  threshold = 0.01  " SURFACE "\n[run] until = 4 h  rtol = 0.02\n"
TEST(checkpoint) { resumed(RESUMED("4 um/h"), 7200.0); }
TEST(checkpoint_of_a_law) { resumed(RESUMED("4 um/h * 10^(0.1*(7 - pH))"), 7200.0); }
TEST(checkpoint_of_a_film)
{
    resumed(FILM(BY_PH, ""), 500.0);
    resumed(FILM("1 um/h", ""), 500.0);
    resumed(FILM("30 um/h", "rtol = 0.02"), 1500.0); /* a cell turns on the way */
}

/* ---- bad input ---- */

static void refused(const char *text, const char *message)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_ctx_init(&ctx);
    if (!CHECK(pd_scene_parse(&ctx, "a.scene", text, NULL, 0, &setup) < 0)) {
        NOTE("accepted, expected: %s", message);
        pd_setup_free(&ctx, &setup);
        return;
    }
    if (!CHECK(strstr(ctx.message, message) != NULL)) NOTE("%s", ctx.message);
    CHECK_INT(ctx.in_use, 0);
}

TEST(refusals)
{
#define ION "[species Na+] initial = 1 mM  D = 1e-9 m2/s\n[species Cl-] initial = 1 mM  D = 1e-9 m2/s\n"
#define END "[run] until = 1 s\n"
#define METAL BOX("10 um", "100 um") BLOCK("0 .. 20 um") "[transport] D = 1e-9 m2/s\n"
    refused("[species Na+] initial = 1 mM\n[species Cl-] initial = 1 mM\n", "found species without a [grid]");
    refused(BOX("1 um", "9 um") "[species Na+] initial = 1 mM\n[species Cl-] D = 1e-9 m2/s  initial = 1 mM\n" END,
            "a.scene:2: D: found no diffusivity of Na+, which moves in a run");
    refused(BOX("1 um", "9 um") ION
            "[species NaCl(s)] initial = 1 mM\n[reaction r] NaCl(s) = Na+ + Cl-  log10_K = 1\n" END,
            "found NaCl(s), which is no solute");
#define SALT "[species NaCl(s)] initial = 1 mM\n[reaction r] NaCl(s) = Na+ + Cl-  "
    refused(BOX("1 um", "9 um") ION "[mineral K+] rate = 1 mol/m2/s\n" END, "a.scene:4: mineral: found 'K+', which no");
    refused(BOX("1 um", "9 um") ION "[mineral Na+] rate = 1 mol/m2/s\n" END, "found 'Na+', which is no solid");
    refused(BOX("1 um", "9 um") ION SALT "log10_K = 1\n[mineral NaCl(s)] rate = 1 mol/m2/s\n" END,
            "a.scene:6: rate: found without a surface");
    refused(BOX("1 um", "9 um") ION SALT "log10_K = 1\n[mineral NaCl(s)] rate = -1 mol/m2/s  area = 1 1/m\n" END,
            "a.scene:6: rate: found -1 mol/m2/s, expected a value of at least 0");
    refused(BOX("1 um", "9 um") ION SALT "log10_K = 1\n[mineral NaCl(s)] area = 1 1/m\n" END,
            "a.scene:6: area: found without 'rate'");
    refused(BOX("1 um", "9 um") ION SALT "K = 10\n[mineral NaCl(s)]\n" END, "K of 'r' has no unit");
    refused(BOX("1 um", "9 um") ION "[species NaCl(s)]\n[reaction r] NaCl(s) = 2 Na+ + Cl-  log10_K = 1\n"
            "[mineral NaCl(s)]\n" END, "'r' does not balance");
    refused(BOX("1 um", "9 um") ION "[species NaCl(s)]\n[mineral NaCl(s)]\n" END, "NaCl(s) has no reaction");
    refused(BOX("1 um", "9 um") ION "[output] fields = film\n" END, "a [mineral ...] section");
    refused(BOX("1 um", "9 um") ION "[output] fields = pH\n" END, "found 'pH', which needs the species H+");
    refused(BOX("1 um", "9 um") ION "[output] fields = K+\n" END,
            "found 'K+', expected some of kind, phase, Na+, Cl-, or none");
    refused(METAL ION "[dissolve] rate = 1 um/h  reaction = Mg = Mg2+\n" END, "'Mg2+', which nobody defines");
    refused(METAL IONS "[species Mg2+] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h  reaction = Mg = Mg2+\n" END, "charge");
    refused(METAL IONS "[species Mg2+] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h  reaction = H+ + OH- = H2O\n" END,
            "found no metal");
    refused(METAL "[dissolve] rate = 1 um/h  " SURFACE "\n" END, "found without species");
    refused(METAL ION "[chemistry] time = steady\n[dissolve] rate = 1 um/h\n" END, "'steady' beside metal");
    refused(METAL "[dissolve] rate = 1 um/h * pH\n" END, "found pH without the species H+");
    refused(METAL ION "[dissolve] rate = 1 um/h * pH\n" END, "found pH without the species H+");
    refused(METAL ION "[dissolve] rate = 1 um/h * [K+]/(1 mM)\n" END, "found [K+], expected a solute");
    refused(METAL "[dissolve] rate = 1 um/h * [K+]/(1 mM)\n" END, "found [K+], expected a solute");
    refused(METAL IONS "[dissolve] rate = 1 um/h * [OH-]\n" END, "expected a speed");
    refused(METAL IONS "[dissolve] rate = 1 um/h * pH * C/(1 mM)\n" END, "found C beside pH, species or E");
    refused(METAL ION "[output] every = [Na+] * 1 s\n" END, "laws of the speed of metal alone know species");
    refused(METAL "[dissolve] rate = 1 um/h\n[side x+] species = inlet\n", "found without species");
    refused(METAL SPOT("0 .. 10 um") "[dissolve] rate = 1 um/h\n", "without species");
    refused(METAL ION "[dissolve] rate = 1 um/h [flow]\n" END, "a section starts on a line of its own");
}

TEST_MAIN(ENTRY(titration) ENTRY(amounts) ENTRY(fast_stream) ENTRY(mineral_in_equilibrium) ENTRY(law_in_ph)
          ENTRY(law_that_overflows) ENTRY(narrowing) ENTRY(corrode)
          ENTRY(solutions) ENTRY(corner) ENTRY(walls) ENTRY(covered) ENTRY(covered_all) ENTRY(covered_more_and_more)
          ENTRY(all_together)
          ENTRY(front) ENTRY(one_species)
          ENTRY(steady) ENTRY(fields) ENTRY(checkpoint) ENTRY(checkpoint_of_a_law) ENTRY(checkpoint_of_a_film)
          ENTRY(refusals))
