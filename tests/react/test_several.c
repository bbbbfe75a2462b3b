/* several: metals that each dissolve by a law and a reaction of their own among ions that migrate: the balance of their
 * laws, an exchange of two ions against its closed form, Faraday's law of each metal, metals that are alike against one
 * metal, contact in a row and side by side, checkpoints, threads; what is refused.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "run/run.h"
#include "cases/plates.h"
#include "continued_model.h"

#if PD_DIM == 1
#define BOX(from, to) from " .. " to
#define SIDES
#define HEIGHT 1.0
#else
#define BOX(from, to) from " .. " to ", 0 um .. 30 um"
#define SIDES "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define HEIGHT 3e-5
#endif

static double level_of(int electrode)
{
    pd_cell_electrode now;
    pd_species_electrodes_get_electrode(&model.dissolution_laws.species_electrodes, electrode, &now);
    return now.potential;
}

static double anodic_of(int electrode)
{
    pd_cell_electrode now;
    pd_species_electrodes_get_electrode(&model.dissolution_laws.species_electrodes, electrode, &now);
    return now.anodic;
}

/* [mol] of a metal that is left; without `metal` of all. */
static double solid_of(int metal)
{
    double sum = 0.0;
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_SOLID && (metal < 0 || model.metal[i] == metal)) sum += model.transport.c[i];
    return sum * model.stencil.volume;
}

/* [mol] of an ion, which is a component of its own, with what a step has left to the next one. */
static double ions_of(const char *name)
{
    const pd_reactive *r = &model.reactive;
    int place = r->components.solute_of_species[pd_electrolyte_find_species(&setup.electrolyte, name)], own = -1;
    double sum = 0.0;
    for (int k = 0; k < r->components.count; k++)
        if (r->components.component_solute[k] == place) own = k;
    for (int32_t i = 0; i < model.grid.total; i++)
        if (model.grid.kind[i] == PD_FLUID)
            sum += r->c[(int64_t)place * model.grid.total + i] + r->carry[(int64_t)own * model.grid.total + i];
    return sum * model.stencil.volume;
}

/* Where a rising balance of currents is 0. */
static double root(double (*balance)(double), double low, double high)
{
    for (int k = 0; k < 200; k++) {
        double e = 0.5 * (low + high);
        if (balance(e) > 0.0) high = e;
        else low = e;
    }
    return 0.5 * (low + high);
}

/* ---- no resistance: the balance of both laws ---- */

#define SALT \
    "[chemistry] activity = ideal  migration = yes\n[species Mg2+] D = 0.706e-9 m2/s\n" \
    "[species Fe2+] D = 0.72e-9 m2/s\n[species Na+] D = 1.33e-9 m2/s  initial = 500 mol/m3\n" \
    "[species Cl-] D = 2.03e-9 m2/s  initial = 500 mol/m3\n[species OH-] D = 5.27e-9 m2/s\n" \
    "[species H2] D = 4.5e-9 m2/s\n[species H2O]\n[potential]\n[transport] D = 1e-9 m2/s\n"
#define LAWS(solid) \
    "[dissolve mg4ag] charge = 2  Cs = " solid "  reaction = Mg = Mg2+ + 2 e-\n" \
    "current = 0.01 A/m2*10^((E + 1 V)/(60 mV))\n" \
    "[dissolve steel304] charge = 2  Cs = " solid "  reaction = Fe = Fe2+ + 2 e-\n" \
    "current = 0.1 A/m2*10^((E + 0.9 V)/(90 mV))\n"
#define HYDROGEN \
    "curve = tafel  i0 = 1e-6 A/m2  E0 = -0.4 V  cathodic_slope = 120 mV\nreaction = 2 H2O + 2 e- = H2 + 2 OH-\n"
#define APART \
    "[grid] h = 5 um  m = 1  threads = 1  box = " BOX("0 um", "200 um") "\n" SIDES \
    "[shape mg] kind = solid  material = mg4ag  box = " BOX("0 um", "50 um") "\n" \
    "[shape iron] kind = solid  material = steel304  box = " BOX("150 um", "200 um") "\n"

static double magnesium(double e) { return 0.01 * pow(10.0, (e + 1.0) / 0.06); }
static double iron(double e) { return 0.1 * pow(10.0, (e + 0.9) / 0.09); }
static double hydrogen(double e) { return 1e-6 * pow(10.0, -(e + 0.4) / 0.12); }
static double mixed(double e) { return magnesium(e) + iron(e) - hydrogen(e); }

/* Hydrogen comes off iron; both metals go, at the potential of both together. */
TEST(mixed)
{
    double e = root(mixed, -2.0, 0.0);
    if (!open_threads(APART SALT LAWS("40 mol/L") "[electrode mg] shape = mg  connected = iron\n"
                    "[electrode iron] shape = iron  " HYDROGEN "[run] until = 1 s\n", NULL, 0, 1))
        return;
    if (run_to(1e-3)) {
        NOTE("E %.8f V (%.8f), Mg %g A/m2, Fe %g A/m2", level_of(0), e, magnesium(e), iron(e));
        CHECK_NEAR(level_of(0), e, 2e-6);
        CHECK_REL(anodic_of(0), HEIGHT * magnesium(e), 1e-4);
        CHECK_REL(anodic_of(1), HEIGHT * iron(e), 1e-4);
    }
    close_model();
}

/* ---- two ions in exchange ---- */

static const plates_exchange exchange_of = {
    {0.71e-9, 1e-4, 50.0, 250.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.71e-9, 0.5e-9},
    {10.0, 12.0}, {0.0, 0.05}, {0.06, 0.12}, {20.0, 20.0}, {0.0, 0.1}, {0.12, 0.12}, 100.0};

/* Each metal dissolves into its own ion and takes up that of the other. */
TEST(exchange)
{
    plates_exchanged wanted = plates_exchange_at(&exchange_of);
    if (!open_threads(APART
                      "[chemistry] activity = ideal  migration = yes\n"
                      "[species Cu2+] D = 0.71e-9 m2/s  initial = 50 mol/m3\n"
                      "[species Zn2+] D = 0.5e-9 m2/s  initial = 50 mol/m3\n"
                      "[species Na+] D = 1.33e-9 m2/s  initial = 50 mol/m3\n"
                      "[species Cl-] D = 2.03e-9 m2/s  initial = 250 mol/m3\n[potential]\n[transport] D = 1e-9 m2/s\n"
                      "[dissolve mg4ag] charge = 2  Cs = 1e10 mol/m3  reaction = Cu = Cu2+ + 2 e-\n"
                      "current = 10 A/m2*10^(E/(60 mV))\n"
                      "[dissolve steel304] charge = 2  Cs = 1e10 mol/m3  reaction = Zn = Zn2+ + 2 e-\n"
                      "current = 12 A/m2*10^((E - 50 mV)/(120 mV))\n"
                      "[electrode cu] shape = mg  connected = zn  curve = expression  reaction = Zn2+ + 2 e- = Zn\n"
                      "i = -20 A/m2*[Zn2+]/(100 mol/m3)*10^(-E/(120 mV))\n"
                      "[electrode zn] shape = iron  curve = expression  reaction = Cu2+ + 2 e- = Cu\n"
                      "i = -20 A/m2*[Cu2+]/(100 mol/m3)*10^(-(E - 100 mV)/(120 mV))\n[run] until = 1 h\n", NULL, 0, 1))
        return;
    for (int k = 1; k < 20; k++) run_to(2e3 * k);
    if (run_to(4e4)) {
        NOTE("E %.8f V (%.8f), Cu %.8g A/m2 (%.8g), Zn %.8g A/m2 (%.8g)", level_of(0), wanted.potential,
             anodic_of(0) / HEIGHT, wanted.current[0], anodic_of(1) / HEIGHT, wanted.current[1]);
        CHECK_NEAR(level_of(0), wanted.potential, 1e-7);
        CHECK_REL(anodic_of(0), HEIGHT * wanted.current[0], 2e-6);
        CHECK_REL(anodic_of(1), HEIGHT * wanted.current[1], 2e-6);
        CHECK_REL(ions_of("Cu2+"), HEIGHT * wanted.amount[0], 2e-5);
        CHECK_REL(ions_of("Zn2+"), HEIGHT * wanted.amount[1], 2e-5);

    }
    close_model();
}
/* ---- Faraday's law of each metal ---- */

/* What a metal has lost is what has come of its ion and what that ion is still owed, and with them half of the base. */
static void balanced(double magnesium_start, double iron_start, double far)
{
    double lost[2], come[2], owed[2] = {0.0, 0.0};
    int64_t total = model.grid.total;
    int mg = strcmp(setup.metal[0].material.name, "mg4ag") != 0;
    for (int m = 0; m < 2; m++) {
        int which = m != mg;
        lost[which] = (which ? iron_start : magnesium_start) - solid_of(m);
        for (int32_t i = 0; i < total; i++)
            if (model.grid.kind[i] == PD_FLUID) owed[which] += model.dissolve.shed[m * total + i];
        owed[which] *= model.stencil.volume;
    }
    come[0] = ions_of("Mg2+");
    come[1] = ions_of("Fe2+");
    NOTE("lost %.6g and %.6g mol, off by %.2g and %.2g of it", lost[0], lost[1], (come[0] + owed[0]) / lost[0] - 1.0,
         (come[1] + owed[1]) / lost[1] - 1.0);
    for (int k = 0; k < 2; k++) {
        CHECK(lost[k] > 0.0);
        CHECK_REL(come[k] + owed[k], lost[k], far);
        CHECK_REL(model.species_integrator.each[k == 0 ? mg : 1 - mg] + owed[k], lost[k], far);
    }
    CHECK_NEAR(ions_of("OH-"), 2.0 * (come[0] + come[1]), 1e-10 * ions_of("Cl-"));
}

#define WIRES \
    "[electrode mg] shape = mg  connected = iron\n[electrode iron] shape = iron  " HYDROGEN "[run] until = 1 day\n"
#define GO_APART APART SALT LAWS("50 mol/m3") WIRES

/* In an hour, in which cells go, each one loses what its own ion has got. */
static void goes(const char *text)
{
    if (!open_threads(text, NULL, 0, 1)) return;
    int mg = strcmp(setup.metal[0].material.name, "mg4ag") != 0;
    double start[2] = {solid_of(mg), solid_of(1 - mg)};
    if (run_to(3600.0)) {
        CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
        balanced(start[0], start[1], 1e-13);
    }
    close_model();
}

TEST(faraday) { goes(GO_APART); }

/* ---- metals that are alike ---- */

#define PLATES_OF(second, more) \
    "[grid] h = 5 um  m = 1  threads = 1  box = " BOX("0 um", "200 um") "\n" SIDES \
    "[shape mg] kind = solid  material = mg4ag  box = " BOX("0 um", "50 um") "\n" \
    "[shape iron] kind = solid  material = " second "  box = " BOX("150 um", "200 um") "\n" SALT \
    "[dissolve mg4ag]" FAST more "[electrode mg] shape = mg  connected = iron  " HYDROGEN \
    "[electrode iron] shape = iron  " STRONG "[run] until = 1 h\n"
#define STRONG \
    "curve = tafel  i0 = 1 mA/m2  E0 = -0.4 V  cathodic_slope = 120 mV\nreaction = 2 H2O + 2 e- = H2 + 2 OH-\n"
#define FAST " charge = 2  Cs = 1 mol/L  reaction = Mg = Mg2+ + 2 e-  current = 1 A/m2*10^((E + 1 V)/(60 mV))\n"

/* Both plates of one metal, whose cells fill with the solution at the surface as they go, and of two that are alike. */
TEST(one_metal)
{
    static const char *const text[] = {PLATES_OF("mg4ag", ""), PLATES_OF("copper", "[dissolve copper]" FAST)};
    double loss[2], e[2];
    for (int k = 0; k < 2; k++) {
        if (!open_threads(text[k], NULL, 0, 1)) return;
        if (run_to(200.0)) CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
        loss[k] = pd_time_loop_volume_loss(&model.time_loop);
        e[k] = level_of(0);
        close_model();
    }
    NOTE("loss %.6g, %.3g of it off, E %.3g V", loss[0], loss[1] / loss[0] - 1.0, e[1] - e[0]);
    CHECK_REL(loss[1], loss[0], 2e-5);
    CHECK_NEAR(e[1], e[0], 1e-3); /* cells that have just turned are filled in other ways */
}

#if PD_DIM == 2
/* ---- side by side ---- */

#define BLOCK(h, m, second) \
    "[grid] h = " h "  m = " m "  box = 0 um .. 60 um, 0 um .. 60 um\n[side x-] flow = mirror\n" \
    "[side x+] flow = mirror\n" \
    "[shape block] kind = solid  material = mg4ag  box = 0 um .. 60 um, 0 um .. 20 um\n" \
    "[shape half] kind = solid  material = " second "  box = 30 um .. 60 um, 0 um .. 20 um\n" \
    "[shape top] kind = solid  material = steel304  box = 0 um .. 60 um, 50 um .. 60 um\n"
#define ALIKE " charge = 2  Cs = 50 mol/m3  reaction = Mg = Mg2+ + 2 e-  current = 0.1 A/m2*10^((E + 1 V)/(60 mV))\n"
#define TOP "[dissolve steel304] rate = 0\n[electrode top] shape = top  connected = block\n" HYDROGEN

/* What is left of the metal, and the metal in it, of a block of one metal and of one of two that are alike. */
static int alike(const char *text, double *left, double *ions, double *e)
{
    int good;
    if (!open_threads(text, NULL, 0, 1)) return 0;
    good = run_to(1200.0);
    if (good) {
        CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
        *left = solid_of(-1);
        *ions = ions_of("Mg2+");
        *e = level_of(0);
    }
    close_model();
    return good;
}

TEST(alike)
{
    static const char *const text[][4] = {
        {BLOCK("5 um", "1", "mg4ag") SALT "[dissolve] m = 1\n[dissolve mg4ag]" ALIKE TOP
         "[electrode block] shape = block\n[run] until = 1 day\n",
         BLOCK("5 um", "1", "copper") SALT "[dissolve] m = 1\n[dissolve mg4ag]" ALIKE "[dissolve copper]" ALIKE TOP
         "[electrode block] shape = block\n[run] until = 1 day\n",
         BLOCK("5 um", "1", "copper") SALT "[dissolve] m = 1\n[dissolve mg4ag]" ALIKE "[dissolve copper]" ALIKE TOP
         "[electrode block] shape = block\n[electrode half] shape = half\n[run] until = 1 day\n"},
        {BLOCK("5 um", "1", "mg4ag") SALT "[dissolve mg4ag]" ALIKE TOP
         "[electrode block] shape = block\n[run] until = 1 day\n",
         BLOCK("5 um", "1", "copper") SALT "[dissolve mg4ag]" ALIKE "[dissolve copper]" ALIKE TOP
         "[electrode block] shape = block\n[run] until = 1 day\n",
         BLOCK("5 um", "1", "copper") SALT "[dissolve mg4ag]" ALIKE "[dissolve copper]" ALIKE TOP
         "[electrode block] shape = block\n[electrode half] shape = half\n[run] until = 1 day\n"}};
    for (int wide = 0; wide < 2; wide++) {
        double left[3], ions[3], e[3];
        for (int k = 0; k < 3; k++)
            if (!alike(text[wide][k], &left[k], &ions[k], &e[k])) return;
        for (int k = 1; k < 3; k++) {
            NOTE("m = %d, %d electrodes: metal %.3g, ions %.3g, E %.3g V off", wide ? 3 : 1, k, left[k] / left[0] - 1.0,
                 ions[k] / ions[0] - 1.0, e[k] - e[0]);
            CHECK_REL(left[k], left[0], wide ? 1e-6 : 1e-13);
            CHECK_REL(ions[k], ions[0], wide ? 1e-3 : 1e-12);
            CHECK_NEAR(e[k], e[0], wide ? 1e-8 : 1e-13);
        }
    }
}

#define TOUCH \
    "[grid] h = 5 um  m = 1  box = 0 um .. 60 um, 0 um .. 60 um\n[side x-] flow = mirror\n[side x+] flow = mirror\n" \
    "[shape mg] kind = solid  material = mg4ag  box = 0 um .. 30 um, 0 um .. 30 um\n" \
    "[shape iron] kind = solid  material = steel304  box = 30 um .. 60 um, 0 um .. 30 um\n"
#define TOUCH_OF TOUCH
#define GO_TOUCH TOUCH SALT LAWS("50 mol/m3") "[electrode mg] shape = mg\n[electrode iron] shape = iron  " HYDROGEN \
    "[run] until = 1 day\n"

#define STAYS \
    "[dissolve mg4ag] charge = 2  Cs = 50 mol/m3  reaction = Mg = Mg2+ + 2 e-\n" \
    "current = 0.1 A/m2*10^((E + 1 V)/(60 mV))\n[dissolve steel304] rate = 0\n[electrode mg] shape = mg\n" \
    "[electrode iron] shape = iron  " HYDROGEN "[run] until = 1 day\n"

/* A metal that stays beside one that goes: the one loses what has passed, by Faraday's law. */
TEST(stays)
{
    for (int wide = 0; wide < 2; wide++) {
        double q = 0.0;
        if (!open_threads(wide ? TOUCH SALT STAYS : TOUCH SALT "[dissolve] m = 1\n" STAYS, NULL, 0, 1)) return;
        double start = solid_of(-1);
        for (int k = 1; k <= 72; k++) {
            double before = k > 1 ? anodic_of(0) : 0.0;
            if (!run_to(10.0 * k)) break;
            q += 10.0 * (k > 1 ? 0.5 * (before + anodic_of(0)) : anodic_of(0));
        }
        CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
        NOTE("m = %d: %.6g mol lost, %.3g of it off", wide ? 3 : 1, start - solid_of(-1),
             q / (2.0 * PLATES_FARADAY) / (start - solid_of(-1)) - 1.0);
        CHECK_REL(ions_of("Mg2+"), start - solid_of(-1), 1e-10);
        CHECK_REL(q / (2.0 * PLATES_FARADAY), start - solid_of(-1), 1e-3);
        close_model();
    }
}

/* Two metals that touch. */
TEST(touch) { goes(GO_TOUCH); }
#define FLAT ENTRY(alike) ENTRY(stays) ENTRY(touch)
#else
#define TOUCH_OF APART
#define GO_TOUCH GO_APART
#define FLAT
#endif

/* ---- states of runs ---- */

static void keep(void)
{
    const pd_etch *s = &model.dissolution_laws.surface_solver;
    CHECK(model.grid.solid_count < model.time_loop.solid_nodes_start);
    saved_count = 0;
    for (int k = 0; k < model.reactive.components.solutes; k++)
        for (int32_t i = 0; i < model.grid.total && saved_count < 6000; i++)
            saved[saved_count++] = model.reactive.c[(int64_t)k * model.grid.total + i];
    for (int32_t i = 0; i < model.grid.total; i++) saved[saved_count++] = model.transport.c[i];
    saved[saved_count++] = s->level[0];
    for (int32_t p = 0; p < s->count && saved_count < 8192; p++) saved[saved_count++] = s->gave[p] + s->flow[p];
}

#define PASSIVE \
    "[dissolve mg4ag] charge = 2  Cs = 50 mol/m3  reaction = Mg = Mg2+ + 2 e-\n" \
    "current = 0.01 A/m2*q*10^((E + 1 V)/(60 mV))\n[dissolve steel304] charge = 2  Cs = 50 mol/m3\n" \
    "reaction = Fe = Fe2+ + 2 e-  current = 0.1 A/m2*q*10^((E + 0.9 V)/(90 mV))\n" \
    "[surface q] initial = 1  min = 0.1  rate = -q/(500 s)\n"

/* A run that goes on from a checkpoint has the bits of one that was never stopped; so has one with more threads. */
TEST(state)
{
    continued(GO_TOUCH, 1000.0, 3000.0, keep);
    continued(TOUCH_OF SALT PASSIVE WIRES, 1000.0, 3000.0, keep);
}

/* ---- until nothing is left ---- */

/* In a closed box each metal goes to its last atom, and what ions there are has come from it; base comes with both. */
static void used_up(const char *text)
{
    if (!open_threads(text, NULL, 0, 1)) return;
    int mg = strcmp(setup.metal[0].material.name, "mg4ag") != 0;
    double start[2] = {solid_of(mg), solid_of(1 - mg)};
    if (run_to(72000.0)) {
        double come[2] = {ions_of("Mg2+"), ions_of("Fe2+")};
        NOTE("off by %.2g and %.2g of the metals, base by %.2g", come[0] / start[0] - 1.0, come[1] / start[1] - 1.0,
             ions_of("OH-") / (2.0 * (come[0] + come[1])) - 1.0);
        CHECK(model.grid.solid_count == 0);
        for (int k = 0; k < 2; k++) CHECK_REL(come[k], start[k], 1e-12);
        CHECK_NEAR(ions_of("OH-"), 2.0 * (come[0] + come[1]), 1e-10 * ions_of("Cl-"));
    }
    close_model();
}

#define TWO_CIRCUITS \
    "[electrode mg] shape = mg  curve = tafel  i0 = 1e-5 A/m2  E0 = -0.4 V  cathodic_slope = 120 mV\n" \
    "reaction = 2 H2O + 2 e- = H2 + 2 OH-\n[electrode iron] shape = iron  " HYDROGEN "[run] until = 1 day\n"

/* An open bath keeps nothing of what has come, so nothing can be taken back. [mol] of the metal shortly before its
 * end. */
static double bathed(double fraction)
{
    static const char text[] =
        "[grid] m = 1  h = 5 um  box = " BOX("0 um", "200 um") "\n" SIDES "[side x+] species = inlet\n"
        "[shape mg] kind = solid  material = mg4ag  box = " BOX("0 um", "10 um") "\n"
        "[chemistry] activity = ideal\n[species Mg2+] D = 0.7e-9 m2/s\n[species OH-] D = 5.3e-9 m2/s\n"
        "[species Na+] D = 1.3e-9 m2/s  initial = 1 mol/m3\n[species Cl-] D = 2e-9 m2/s  initial = 1 mol/m3\n"
        "[species H2O]\n[transport] D = 1e-9 m2/s\n"
        "[dissolve] rate = 20 um/h*(1 - 0.02*[OH-]/(1 mol/m3))  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n"
        "[run] until = 10 h\n";
    static const double time[] = {1500.0, 1900.0, 2500.0, 4000.0, 8000.0, 36000.0};
    char steps[48];
    const char *over[] = {steps};
    double left = 0.0, least = 0.0;
    snprintf(steps, sizeof steps, "run.max_dissolved_fraction=%g", fraction);
    if (!open_threads(text, over, 1, 1)) return 0.0;
    double start = solid_of(-1);
    for (int k = 0; k < 6 && run_to(time[k]); k++) {
        const pd_reactive *r = &model.reactive;
        if (!k) left = solid_of(-1);
        for (int n = 0; n < r->components.solutes; n++)
            for (int32_t i = 0; i < model.grid.total; i++)
                if (model.grid.kind[i] == PD_FLUID) least = pd_min(least, r->c[(int64_t)n * model.grid.total + i]);
    }
    CHECK(model.grid.solid_count == 0);
    CHECK(least >= 0.0);
    CHECK_REL(model.species_integrator.taken, start, 1e-9);
    close_model();
    return left;
}

/* The last of a metal goes at the same time with steps that cost a node half of what it has, and nothing is negative
 * afterwards. */
TEST(bath)
{
    double left[3] = {bathed(0.02), bathed(0.1), bathed(0.5)};
    NOTE("%.6g mol are left, %.2g and %.2g of it more with longer steps", left[0], left[1] / left[0] - 1.0,
         left[2] / left[0] - 1.0);
    CHECK(left[0] > 0.0);
    CHECK_REL(left[1], left[0], 5e-3);
    CHECK_REL(left[2], left[0], 1e-2);
}

TEST(used_up)
{
    used_up(GO_TOUCH);
    used_up(APART SALT LAWS("50 mol/m3") TWO_CIRCUITS);
    used_up(TOUCH_OF SALT "[dissolve] threshold = 0.3\n" LAWS("50 mol/m3") WIRES);
    continued(GO_TOUCH, 9000.0, 40000.0, keep);
}

/* ---- refused ---- */

#define MG_ALONE \
    "[dissolve mg4ag] charge = 2  reaction = Mg = Mg2+ + 2 e-  current = 0.1 A/m2*10^((E + 1 V)/(60 mV))\n"
#define IRON_BY "[dissolve steel304] current = 0.1 A/m2*10^((E + 0.9 V)/(90 mV))  "
#define WIRED \
    "\n[electrode mg] shape = mg  connected = iron\n[electrode iron] shape = iron  " HYDROGEN "[run] until = 1 s\n"

TEST(refused)
{
    static const char *const bad[][2] = {
        {APART SALT MG_ALONE "[dissolve steel304] rate = 1 nm/h" WIRED, "expected a law in E, or rate = 0"},
        {APART SALT MG_ALONE IRON_BY WIRED, "found none of steel304"},
        {APART SALT MG_ALONE IRON_BY "charge = 3  reaction = Fe = Fe2+ + 2 e-" WIRED,
         "found 2 e- for one of the metal, but Faraday's law has charge = 3"},
        {APART SALT MG_ALONE "[dissolve steel304] rate = 0  reaction = Fe = Fe2+ + 2 e-" WIRED, "of metal that stays"},
        {APART SALT "[dissolve mg4ag] reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)  current = 1 A/m2*E/(1 V)\n" IRON_BY
                    "charge = 3  reaction = Fe + Cl- = Fe2+ + 0.5 Cl2(g) + 3 e-" WIRED,
         "expected one gas"},
        {APART SALT MG_ALONE IRON_BY "charge = 2  reaction = Fe = Fe2+ + 2 e-\n[chemistry] minerals = all\n"
                                     "covering_thickness = 1 um\n[species Mg(OH)2(s)] volume = 24.6 cm3/mol\n"
                                     "[reaction brucite] equation = Mg(OH)2(s) = Mg2+ + 2 OH-  log10_K = -11.2" WIRED,
         "covering_thickness: found with several"},
        {APART
         "[species Mg2+] D = 1e-9 m2/s\n[species OH-] D = 1e-9 m2/s\n[species H2O]\n"
         "[transport] D = 1e-9 m2/s\n[dissolve mg4ag] rate = 1 um/h  reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)\n"
         "[dissolve steel304] rate = 0\n[run] until = 1 s\n",
         "found with several metals, expected one"}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        pd_ctx_init(&ctx);
        pd_status status = pd_scene_parse(&ctx, "a.scene", bad[k][0], NULL, 0, &setup);
        if (status == PD_OK) pd_setup_free(&ctx, &setup);
        CHECK(status < 0);
        if (!CHECK(strstr(ctx.message, bad[k][1]) != NULL)) NOTE("%d: %s", (int)k, ctx.message);
        CHECK_INT(ctx.in_use, 0);
    }
}

TEST_MAIN(ENTRY(mixed) ENTRY(exchange) ENTRY(faraday) ENTRY(one_metal) FLAT ENTRY(state) ENTRY(bath) ENTRY(used_up) \
          ENTRY(refused))
