/* electrolytes: recipes with a pH and an ion that closes them, against closed forms and PHREEQC; included files; the
 * electrolytes of examples/; bad input; texts that are cut and flipped.
 * dims: 1 */
#define _XOPEN_SOURCE 700
#include "scene/read_electrolyte.h"
#include "fault.h"
#include "random.h"
#include "scene_file.h"

#define WATER \
    "[species H+]\n[species OH-]\n[species Na+] initial = 100 mM\n[species Cl-] initial = 100 mM\n" \
    "[reaction water] H2O = H+ + OH-   K = 1e-14 mol2/L2\n"

static pd_electrolyte e;

static int parse(pd_ctx *ctx, const char *text)
{
    pd_ctx_init(ctx);
    return CHECK_OK(ctx, pd_electrolyte_parse(ctx, "a.electrolyte", text, NULL, 0, &e));
}

static double amount(const char *name)
{
    int i = pd_electrolyte_find_species(&e, name);
    return CHECK(i >= 0) ? e.initial[i] : NAN;
}

/* The text is refused with "a.electrolyte:LINE: " and a message that holds `part`. */
static void refuse(int line, const char *text, const char *part)
{
    pd_ctx ctx;
    char where[64];
    pd_ctx_init(&ctx);
    snprintf(where, sizeof where, "a.electrolyte:%d: ", line);
    CHECK(pd_electrolyte_parse(&ctx, "a.electrolyte", text, NULL, 0, &e) < 0);
    if (!CHECK(strncmp(ctx.message, where, strlen(where)) == 0 && strstr(ctx.message, part) != NULL))
        NOTE("message: %s; expected %s and: %s", ctx.message, where, part);
    CHECK_INT(ctx.in_use, 0);
}

/* Strong acid and base: [H+] = a + [OH-], in closed form. */
TEST(strong_acid_and_base)
{
    static const double ph[] = {1.0, 3.0, 6.5, 7.0, 7.5, 10.0, 12.0};
    pd_ctx ctx;
    char text[1024];
    for (size_t k = 0; k < sizeof ph / sizeof ph[0]; k++) {
        double h = 1e3 * pow(10.0, -ph[k]), oh = 1e-8 / h; /* [mol/m3] */
        for (int sodium = 0; sodium < 2; sodium++) {
            snprintf(text, sizeof text, "[chemistry] activity = ideal  pH = %g  counter_ion = %s\n" WATER, ph[k],
                     sodium ? "Na+" : "Cl-");
            if (h - oh >= 100.0 && sodium) continue; /* there is not so much to take */
            if (!parse(&ctx, text)) continue;
            CHECK_NEAR(amount(sodium ? "Na+" : "Cl-"), 100.0 + (sodium ? oh - h : h - oh), 1e-7 * (h + oh));
            CHECK_NEAR(amount("H+"), fmax(h - oh, 0.0), 1e-8 * fmax(h, oh));
            CHECK_NEAR(amount("OH-"), fmax(oh - h, 0.0), 1e-8 * fmax(h, oh));
            pd_electrolyte_state s;
            double c[PD_SPECIES_MAX];
            memcpy(c, e.initial, sizeof c);
            CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &e, c, &s));
            CHECK_NEAR(s.ph, ph[k], 1e-9);
            CHECK_REL(c[pd_electrolyte_find_species(&e, "OH-")], oh, 1e-8);
            CHECK_NEAR(s.charge, 0.0, 1e-10);
            CHECK_INT(pd_electrolyte_solve(&ctx, &e, c, &s), PD_OK); /* an equilibrium stays */
            CHECK_NEAR(s.ph, ph[k], 1e-9);
        }
    }
}

TEST(balance)
{
    pd_ctx ctx;
    if (parse(&ctx, "[chemistry] balance_ion = Cl-\n[species Na+] initial = 3 mol/m3\n[species Ca2+] initial = 2 mM\n"
                    "[species Cl-] initial = 1 mmol/L\n")) {
        CHECK_REL(amount("Cl-"), 7.0, 1e-14);
        CHECK_REL(e.recipe[pd_electrolyte_find_species(&e, "Cl-")], 1.0, 1e-14);
    }
    if (parse(&ctx,
              "[chemistry] balance_ion = Ca2+\n[species Ca2+]\n[species Cl-] initial = 1 mM  inlet = 3e-3 mol/L\n")) {
        CHECK_REL(amount("Ca2+"), 0.5, 1e-14);
        CHECK_REL(e.inlet[pd_electrolyte_find_species(&e, "Ca2+")], 1.5, 1e-14);
    }
    if (parse(&ctx, "[chemistry] activity = ideal  pH = 5  inlet_pH = 9  counter_ion = Cl-\n" WATER)) {
        CHECK_REL(amount("H+"), 1e-2 - 1e-6, 1e-8);
        CHECK_REL(e.inlet[pd_electrolyte_find_species(&e, "OH-")], 1e-2 - 1e-6, 1e-8);
    }
}

/* One reaction, its K in five ways; rates. */
TEST(constants)
{
    static const char *const ways[] = {"K = 1e-14 mol2/L2", "K = 1e-14 mol^2 L^-2", "K = 1e-8 mol2/m6",
                                       "K = (1e-7 M)^2", "log10_K = -14", "K = 1e-2 uM2"};
    pd_ctx ctx;
    char text[512];
    for (size_t k = 0; k < sizeof ways / sizeof ways[0]; k++) {
        snprintf(text, sizeof text, "[species H+]\n[species OH-]\n[reaction w]\n  H2O = H+ + OH-\n  %s\n", ways[k]);
        if (parse(&ctx, text)) CHECK_NEAR(e.reaction[0].ln_k, -14.0 * log(10.0), 1e-12);
    }
    if (!parse(&ctx, "[constants] kf = 1.4e11 L/mol/s\n[species H+]\n[species OH-]\n"
                     "[reaction w] H+ + OH- = H2O  K = 1e14 L2/mol2  forward = kf\n"))
        return;
    CHECK_INT(e.reaction[0].kinetic, 1);
    CHECK_REL(e.reaction[0].forward, 1.4e8, 1e-12);
    CHECK_REL(e.reaction[0].backward, 1.4e8 * 1e-8, 1e-12);
}

/* Water has 0.8902 mPa s at 25 C and 0.6913 at 37 C (IAPWS). Energies of activation: rates back have those less the
 * enthalpy. */
TEST(temperature_of_rates)
{
    double by = 1.0 / 298.15 - 1.0 / 310.15, arrhenius = exp(20e3 / 8.31446261815324 * by);
    pd_ctx ctx;
    if (!parse(&ctx, "[chemistry] temperature = 310.15 K  diffusion = viscosity\n[species H+] D = 9.31e-9 m2/s\n"
                     "[species OH-] D = 5e-9 m2/s * T/(310.15 K)  activation_energy = 20 kJ/mol\n"
                     "[reaction a] H+ + OH- = H2O  K = 1e14 L2/mol2  enthalpy = -55.91 kJ/mol  forward = 1 L/mol/s  "
                     "activation_energy = 20 kJ/mol\n"))
        return;
    CHECK_REL(e.species[0].diffusivity, 9.31e-9 * 0.8902 / 0.6913 * 310.15 / 298.15, 3e-4);
    CHECK_REL(e.species[1].diffusivity, 5e-9 * arrhenius, 1e-12);
    CHECK_REL(e.reaction[0].forward, 1e-3 * arrhenius, 1e-12);
    CHECK_REL(e.reaction[0].backward, 1e-11 * exp(75.91e3 / 8.31446261815324 * by), 1e-9);
}

/* Of water at 37 C: pKw 13.61 to 13.63 in tables. A constant without an enthalpy stays; a rate back follows. */
TEST(temperature)
{
    pd_ctx ctx;
    if (!parse(&ctx, "[chemistry] temperature = 310.15 K\n[species H+]\n[species OH-]\n"
                     "[reaction a] H2O = H+ + OH-  log10_K = -14  enthalpy = 55.91 kJ/mol\n"
                     "[reaction b] H+ + OH- = H2O  K = 1e14 L2/mol2  enthalpy = -55.91 kJ/mol  forward = 1 L/mol/s\n"))
        return;
    CHECK_NEAR(e.reaction[0].ln_k / log(10.0), -13.62, 0.01);
    CHECK_NEAR(e.reaction[1].ln_k, -e.reaction[0].ln_k, 1e-9);
    CHECK_REL(e.reaction[1].backward, 1e3 * exp(e.reaction[0].ln_k), 1e-9);
    if (!parse(&ctx, "[chemistry] temperature = 310.15 K\n[species H+]\n[species OH-]\n"
                     "[reaction a] H2O = H+ + OH-  log10_K = -14\n"))
        return;
    CHECK_NEAR(e.reaction[0].ln_k / log(10.0), -14.0, 1e-12);
    CHECK(isnan(e.enthalpy[0]));
}

/* Minerals: there, not there, and all that can form. Mg(OH)2 in water, ideal: [OH-]^3 = 2 Ksp with little H+. */
TEST(minerals)
{
    static const char text[] =
        "[chemistry] activity = ideal  minerals = %s\n[species H+]\n[species OH-]\n[species Mg2+]\n"
        "[species Mg(OH)2(s)] initial = %s\n[species Cl-]\n[reaction water] H2O = H+ + OH-   log10_K = -14\n"
        "[reaction brucite] Mg(OH)2(s) = Mg2+ + 2 OH-   K = 1e-11 mol3/L3\n";
    pd_ctx ctx;
    pd_electrolyte_state s;
    char own[1024];
    double c[PD_SPECIES_MAX];
    snprintf(own, sizeof own, text, "given", "1 mM");
    if (!parse(&ctx, own)) return;
    int mg = pd_electrolyte_find_species(&e, "Mg2+"), oh = pd_electrolyte_find_species(&e, "OH-");
    int solid = pd_electrolyte_find_species(&e, "Mg(OH)2(s)");
    memcpy(c, e.initial, sizeof c);
    CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &e, c, &s));
    CHECK_REL(c[oh], 1e3 * cbrt(2e-11), 1e-6);
    CHECK_NEAR(s.saturation[solid], 0.0, 1e-9);
    CHECK_REL(c[solid] + c[mg], 1.0, 1e-14);
    CHECK_NEAR(e.inlet[solid], 0.0, 0.0); /* it does not flow */
    for (int all = 0; all < 2; all++) {
        snprintf(own, sizeof own, text, all ? "all" : "given", "0");
        if (!parse(&ctx, own)) return;
        memcpy(c, e.initial, sizeof c);
        c[mg] = 1.0;
        c[oh] = 2.0;
        CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &e, c, &s));
        if (all) CHECK(c[solid] > 0.8 && fabs(s.saturation[solid]) < 1e-9);
        else CHECK_NEAR(s.saturation[solid], log10(1e-3 * 4e-6 / 1e-11), 1e-6);
    }
}

/* Seawater: PHREEQC 3, example 1, has the ionic strength 0.675 mol/kg and calcite at 0.75, with pairs of Na+ and
 * activities of its own, which differ from Davies' by 0.1 in a logarithm there. */
TEST(seawater)
{
    pd_ctx ctx;
    pd_electrolyte_state s;
    double c[PD_SPECIES_MAX];
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_electrolyte_read(&ctx, "examples/electrolytes/seawater.electrolyte", NULL, 0, &e))) return;
    memcpy(c, e.initial, sizeof c);
    CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &e, c, &s));
    CHECK_NEAR(s.ph, 8.22, 1e-9);
    CHECK_NEAR(s.strength, 675.0 / 1.0128, 0.03 * 675.0);
    CHECK_NEAR(s.saturation[pd_electrolyte_find_species(&e, "CaCO3(s)")], 0.75, 0.15);
    CHECK_NEAR(-s.result.log_activity[pd_electrolyte_find_species(&e, "OH-")], 5.78, 1e-10);
}

/* Those of examples/: neutral, at their pH, with totals that are kept; SBF with the sulphate that is misprinted. */
TEST(examples)
{
    static const char *const names[] = {"water", "saline", "carbonate", "phosphate", "pairs", "minerals", "brucite",
                                        "hbss", "sbf", "seawater"};
    static const char *const sulphate[] = {"species.SO4-2.initial=4.2 mM"};
    pd_ctx ctx;
    pd_electrolyte_state s;
    char path[128];
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        double c[PD_SPECIES_MAX];
        pd_ctx_init(&ctx);
        snprintf(path, sizeof path, "examples/electrolytes/%s.electrolyte", names[k]);
        if (!CHECK_OK(&ctx, pd_electrolyte_read(&ctx, path, NULL, 0, &e))) continue;
        memcpy(c, e.initial, sizeof c);
        CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &e, c, &s));
        CHECK_NEAR(s.charge, 0.0, 1e-12 * fmax(s.strength, 1.0));
        CHECK_NEAR(s.ph, isnan(e.ph) ? 7.0 : e.ph, 1e-9);
        for (int i = 1; i <= 118; i++)
            CHECK_REL(pd_electrolyte_compute_element_total(&e, c, i),
                      pd_electrolyte_compute_element_total(&e, e.initial, i), 1e-12);
    }
    pd_ctx_init(&ctx);
    CHECK_INT(pd_electrolyte_read(&ctx, "examples/electrolytes/sbf.electrolyte", sulphate, 1, &e), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "the charges sum to -7.4 mol/m3") != NULL);
    CHECK(strstr(ctx.message, "balance_ion = Cl-") != NULL);
    CHECK_INT(ctx.in_use, 0);
}

/* The electrolyte of the text gets another pH, which is refused: its amounts stay as they are, with the balance ion. */
static void keep(const char *text, double ph, const char *part)
{
    pd_ctx ctx;
    double c[PD_SPECIES_MAX];
    if (!parse(&ctx, text)) return;
    memcpy(c, e.recipe, sizeof c);
    CHECK_INT(pd_electrolyte_neutralise(&ctx, &e, ph, c), PD_ERR_ARGUMENT);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    CHECK(memcmp(c, e.recipe, sizeof c) == 0);
}

TEST(refused_amounts_stay)
{
    static const char unbalanced[] =
        "[chemistry] activity = ideal  balance_ion = Cl-  counter_ion = Na+\n" WATER "[species K+] initial = 10 mM\n";
    keep(unbalanced, 0.5, "cannot be reached with Na+"); /* the balance ion is closed before */
    keep("[chemistry] balance_ion = Cl-  counter_ion = Na+\n[species Na+] initial = 3 mM\n[species Cl-]\n", 7.0,
         "no [species H+]");
}

TEST(bad_input)
{
    refuse(6, WATER "[reaction r] H+ + 2 OH- = H2O  log10_K = 1\n", "balance: 3 H on the left, 2 on the right");
    refuse(6, WATER "[reaction r] Na+ + OH- = H2O  log10_K = 1\n", "does not balance: 1 H on the left, 2 on");
    refuse(6, WATER "[reaction r] Na+ = Cl- + Mg2+  log10_K = 1\n", "has the species 'Mg2+', which nobody defines");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  K = 1e14\n", "K of 'r' has no unit, expected L2/mol2, or log10_K");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  K = 1e14 L/mol\n", "has the unit 'L/mol', expected L2/mol2");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  K = 1e14 kg\n", "found a mass [kg], expected a unit of mol, L and s");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  forward = 1 1/s\n", "the forward rate of 'r' has the unit");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  forward = -1 L/mol/s\n", "expected a positive value");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  Kk = 1e14 L2/mol2\n", "found a second = in 'H+ + OH- = H2O  Kk");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O\n", "neither a constant of equilibrium nor a rate");
    refuse(6, WATER "[reaction r] H+ = OH-  forward = 1 1/s  enthalpy = 1 J/mol\n", "expected K or log10_K");
    refuse(6, WATER "[reaction r] log10_K = 3\n", "found no 'equation'");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  K = 1 L2/mol2  log10_K = 14\n", "beside 'K'");
    refuse(1, WATER "[reaction r] H+ + OH- = H2O  log10_K = 3\n", "is the sum of others");
    refuse(6, WATER "[species Mg2+] initial = -1 mM\n", "initial: found -1 mol/m3, expected a value of at least 0");
    refuse(6, WATER "[species Mg2+] initial = 1 mg\n", "expected a concentration [mol/m3]");
    refuse(6, WATER "[species Mg2+] charge = 1\n", "the charge of 'Mg2+' is +2 by its name");
    refuse(6, WATER "[species Xy]\n", "'Xy' is no formula");
    refuse(6, WATER "[species Mg(OH)2(s)] inlet = 1 mM\n", "which does not flow");
    refuse(6, WATER "[species Na+] initial = 1 mM\n", "a second time in [species Na+], first on line 3");
    refuse(7, WATER "[reaction r] H+ + OH- = H2O  log10_K = 14\n[reaction r] Na+ = Na+\n", "a second time");
    refuse(6, WATER "[species]\n", "found no name");
    refuse(6, WATER "[chemistry] pH = 7\n", "expected counter_ion = Cl-");
    refuse(6, WATER "[chemistry] pH = 7  counter_ion = K+\n", "found 'K+', which no section defines");
    refuse(6, WATER "[chemistry] pH = 7  counter_ion = H2O\n", "which is no ion");
    refuse(6, WATER "[chemistry] pH = 7  counter_ion = H+\n", "expected another ion");
    refuse(6, WATER "[chemistry] pH = 0.5  counter_ion = Na+\n", "cannot be reached with Na+");
    refuse(6, WATER "[chemistry] pH = 17  counter_ion = Na+\n", "expected a value from -2 to 16");
    refuse(6, WATER "[chemistry] temperature = 37 K\n", "expected a value from 273 K to 373.2 K");
    refuse(6, WATER "[constants] T = 300 K\n", "found beside species, where T is their temperature");
    refuse(6, WATER "[reaction r] H+ + OH- = H2O  K = 1e14 L2/mol2  activation_energy = 1 J/mol\n",
           "found without a rate");
    refuse(6, WATER "[species K+] activation_energy = 1 J/mol\n", "found without D");
    refuse(6, WATER "[chemistry] activity = debye\n", "expected one of ideal, davies");
    refuse(6, WATER "[chemistry] ph = 7\n", "found the unknown key 'ph' in [chemistry]");
    refuse(1, "[species Na+] initial = 2 mM\n[species Cl-] initial = 1 mM\n", "the charges sum to +1 mol/m3");
    refuse(1, "[chemistry] balance_ion = Na+\n[species Na+]\n[species K+] initial = 1 mM\n",
           "which Na+ cannot make up");
    refuse(1, "[chemistry] pH = 7  counter_ion = Na+\n[species Na+]\n", "no [species H+] or no [species OH-]");
    refuse(1, "[chemistry] pH = 7\n", "found no species");
    refuse(1, "[grid] h = 1 um\n", "found no species, expected sections such as [species Na+]");
}

/* ---- included files ---- */

static void leave_file(const char *name, const char *text) { put(name, text, strlen(text)); }

static int joined(pd_ctx *ctx, const char *name, const char *part)
{
    pd_ctx_init(ctx);
    pd_status status = pd_electrolyte_read(ctx, path_of(name), NULL, 0, &e);
    CHECK_INT(ctx->in_use, 0);
    if (!part) return CHECK_OK(ctx, status);
    if (!CHECK(status < 0 && strstr(ctx->message, part) != NULL)) NOTE("message: %s; expected: %s", ctx->message, part);
    return 0;
}

TEST(includes)
{
    pd_ctx ctx;
    leave_file("base.e", "[chemistry] balance_ion = Na+\n[species Na+] initial = 1 mM\n[species Cl-] initial = 2 mM\n");
    leave_file("mid.e",
               "[chemistry] include = base.e  balance_ion = Cl-\n[species Na+] initial = 5 mM  D = 1e-9 m2/s\n");
    leave_file("other.e", "[chemistry] include = base.e\n[species K+]\n");
    leave_file("top.e", "[chemistry] include = mid.e, other.e  activity = ideal\n[species Cl-] initial = 3 mM\n");
    if (joined(&ctx, "top.e", NULL)) {
        CHECK_REL(amount("Na+"), 5.0, 1e-14);
        CHECK_REL(amount("Cl-"), 5.0, 1e-14); /* 3, and what balances */
        CHECK_INT(e.count, 4);                /* with water */
        CHECK_REL(e.species[pd_electrolyte_find_species(&e, "Na+")].diffusivity, 1e-9, 1e-14);
    }
    leave_file("twice.e", "[species Na+]\n  initial = 7 mM\n");
    leave_file("both.e", "[chemistry] include = mid.e, twice.e\n");
    joined(&ctx, "both.e", "twice.e:2: found 'initial' of [species Na+], which ");
    leave_file("round.e", "[chemistry] include = loop.e\n");
    leave_file("loop.e", "[chemistry] include = round.e\n");
    leave_file("begin.e", "\n[chemistry] include = round.e\n");
    joined(&ctx, "begin.e", "loop.e:1: include: found '");
    leave_file("missing.e", "[chemistry]\ninclude = nowhere.e\n");
    joined(&ctx, "missing.e", "missing.e:2: include: ");
    leave_file("grid.e", "[species Na+]\n[grid] h = 1 um\n");
    leave_file("with.e", "[chemistry] include = grid.e\n");
    joined(&ctx, "with.e", "grid.e:2: found [grid] in a file that is included");
    leave_file("flat.e", "h = 1\n");
    leave_file("withflat.e", "[chemistry] include = flat.e\n");
    joined(&ctx, "withflat.e", "flat.e:1: found pairs before a section");
    leave_file("slip.e", "[species Na+]\ninital = 1 mM\n");
    leave_file("withslip.e", "[chemistry] include = slip.e\n");
    joined(&ctx, "withslip.e", "slip.e:2: found the unknown key 'inital'");
    leave_file("value.e", "[species Na+]\ninitial = -1 mM\n");
    leave_file("withvalue.e", "[chemistry] include = value.e\n");
    joined(&ctx, "withvalue.e", "value.e:2: initial: found -1 mol/m3");
}

/* A scene that runs is refused, with a message; so is one of other sections. */
TEST(scenes)
{
    refused("[grid] h = 1 um  box = 0 .. 9 um\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n[species Na+]\n",
            "a.scene:4: D: found no diffusivity of Na+");
    refused("[grid] h = 1 um  box = 0 .. 9 um\n[run] until = 1 s\n[species Na+] initial = 1 mM  D = 1e-9 m2/s\n"
            "[species Cl-] initial = 1 mM  D = 0 m2/s\n", "a.scene:4: D: found 0: a solute moves in a run");
    refused("[species Na+] initial = 1 mM\n", "a.scene:1: chemistry: the charges sum to");
}

TEST(garbage)
{
    static const char *const parts[] = {"[reaction",
                                        " water]",
                                        "[species ",
                                        "Na+]",
                                        "Mg(OH)2(s)]",
                                        " initial",
                                        " = ",
                                        "1 mM",
                                        "K",
                                        "log10_K = ",
                                        "-14",
                                        " + ",
                                        "H+",
                                        "OH-",
                                        "2 ",
                                        "H2O",
                                        "\n",
                                        "mol2/L2",
                                        "[chemistry]",
                                        " pH = 7",
                                        " include = ",
                                        "(",
                                        "]",
                                        ":",
                                        "^",
                                        "=",
                                        " counter_ion = Cl-",
                                        " balance_ion = Na+",
                                        " minerals = all",
                                        "#",
                                        "e-",
                                        "(g)"};
    static const char sound[] = "[chemistry] pH = 5  counter_ion = Cl-\n" WATER;
    uint32_t state = 7;
    int bad = 0;
    for (int k = 0; k < 6000; k++) {
        char text[512] = "";
        pd_ctx ctx;
        pd_ctx_init(&ctx);
        if (k % 2) {
            memcpy(text, sound, sizeof sound);
            for (int n = 0; n < 3; n++)
                text[next_random(&state) % (sizeof sound - 1)] = (char)(32 + next_random(&state) % 95);
            if (k % 3 == 0) text[next_random(&state) % (sizeof sound - 1)] = '\0';
        } else {
            if (k % 4) memcpy(text, sound, sizeof sound);
            for (int n = (int)(next_random(&state) % 12); n >= 0; n--)
                pd_append(text, sizeof text, "%s", parts[next_random(&state) % (sizeof parts / sizeof parts[0])]);
        }
        pd_status status = pd_electrolyte_parse(&ctx, "a", text, NULL, 0, &e);
        bad += status < 0;
        if (status < 0 && !ctx.message[0]) CHECK(ctx.message[0]);
        if (status > 0) CHECK_INT(status, PD_OK);
        if (ctx.in_use != 0) CHECK_INT(ctx.in_use, 0);
    }
    CHECK(bad > 3000 && bad < 6000);
}

static pd_status read_example(pd_ctx *ctx, void *user)
{
    (void)user;
    return pd_electrolyte_read(ctx, "examples/electrolytes/brucite.electrolyte", NULL, 0, &e);
}

TEST(allocation_failures) { CHECK_LE(20, fault_sweep("electrolyte", read_example, NULL, 10000, 1)); }

TEST_MAIN(ENTRY(strong_acid_and_base) ENTRY(balance) ENTRY(constants) ENTRY(temperature) ENTRY(temperature_of_rates)
              ENTRY(minerals) ENTRY(seawater) ENTRY(examples) ENTRY(refused_amounts_stay) ENTRY(bad_input)
                  ENTRY(includes) ENTRY(scenes) ENTRY(garbage) ENTRY(allocation_failures))
