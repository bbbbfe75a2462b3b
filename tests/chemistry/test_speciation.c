/* speciation: closed forms of water, acids and bases, tables of brucite and buffers; what is kept; any start.
 * dims: 1 */
#include "chemistry/speciation.h"
#include "test.h"

typedef struct volume {
    pd_ctx ctx;
    pd_species s[PD_SPECIES_MAX];
    pd_reaction r[PD_REACTION_MAX];
    int species, reactions;
    pd_speciation system;
    pd_speciation_result result;
} volume;

static void add_species(volume *v, const char *name)
{
    pd_species_desc d;
    memset(&d, 0, sizeof d);
    d.name = name;
    CHECK_OK(&v->ctx, pd_species_read(&v->ctx, &d, &v->s[v->species++]));
}

static void add_reaction(volume *v, const char *text, double log10_k)
{
    pd_reaction_desc d;
    memset(&d, 0, sizeof d);
    d.text = text;
    d.k = log10_k;
    d.k_unit = "log10";
    CHECK_OK(&v->ctx, pd_reaction_read(&v->ctx, &d, v->s, v->species, &v->r[v->reactions++]));
}

static void build(volume *v, pd_activity activity)
{
    CHECK_OK(&v->ctx, pd_speciation_build(&v->ctx, v->s, v->species, v->r, v->reactions, activity, 298.15, &v->system));
}

static int at(const volume *v, const char *name)
{
    for (int i = 0; i < v->species; i++)
        if (strcmp(v->s[i].name, name) == 0) return i;
    return -1;
}

static void begin(volume *v)
{
    memset(v, 0, sizeof *v);
    pd_ctx_init(&v->ctx);
    add_species(v, "H2O");
    add_species(v, "H+");
    add_species(v, "OH-");
}

static double total(const volume *v, const double *c, int element)
{
    double sum = 0.0;
    for (int i = 0; i < v->species; i++) sum += c[i] * pdi_species_count_atoms(&v->s[i], element);
    return sum;
}

static double charge(const volume *v, const double *c)
{
    double sum = 0.0;
    for (int i = 0; i < v->species; i++) sum += c[i] * v->s[i].charge;
    return sum;
}

/* Solve; elements and charge stay. The result is pH. */
static double solve(volume *v, double *c)
{
    double e0[120], q0 = charge(v, c), size = 0.0;
    for (int e = 1; e < 119; e++) e0[e] = total(v, c, e);
    for (int i = 0; i < v->species; i++)
        if (v->s[i].phase != PD_PHASE_SOLVENT) size = fmax(size, fabs(c[i]));
    CHECK_INT(pd_speciation_solve(&v->system, c, &v->result), PD_OK);
    for (int e = 1; e < 119; e++) CHECK_NEAR(total(v, c, e), e0[e], 1e-12 * (fabs(e0[e]) + size));
    CHECK_NEAR(charge(v, c), q0, 1e-12 * (size + 1e-3));
    CHECK_LE(v->result.residual, 1e-9);
    return -v->result.log_activity[at(v, "H+")];
}

static void water(volume *v)
{
    begin(v);
    add_reaction(v, "H2O = H+ + OH-", -14.0);
}

TEST(water_alone)
{
    volume v;
    double c[3] = {55344.0, 0.0, 0.0};
    water(&v);
    build(&v, PD_ACTIVITY_IDEAL);
    CHECK_NEAR(solve(&v, c), 7.0, 1e-9);
    for (int k = -300; k <= 3; k += 3) {
        double d = pow(10.0, k), acid[3] = {55344.0, d, 0.0}, base[3] = {55344.0, 0.0, d};
        double h = 0.5 * (d + sqrt(d * d + 4e-8)); /* mol/m3 */
        CHECK_NEAR(solve(&v, acid), 3.0 - log10(h), 1e-9);
        CHECK_LE(v.result.iterations, 40);
        CHECK_NEAR(solve(&v, base), 11.0 + log10(h), 1e-9);
    }
}

/* Acetic acid of 10 mol/m3: h^3 + Ka h^2 - (Kw + Ka C) h - Ka Kw = 0 by bisection. */
TEST(weak_acid)
{
    volume v;
    water(&v);
    add_species(&v, "CH3COOH");
    add_species(&v, "CH3COO-");
    v.reactions = 0;
    add_reaction(&v, "H2O = H+ + OH-", -14.0);
    add_reaction(&v, "CH3COOH = CH3COO- + H+", -4.756);
    build(&v, PD_ACTIVITY_IDEAL);
    for (double acid = 1e-6; acid < 1e3; acid *= 10.0) {
        double c[5] = {55344.0, 0.0, 0.0, acid, 0.0}, low = 1e-14, high = 1.0, ka = pow(10.0, -4.756);
        for (int k = 0; k < 200; k++) {
            double h = sqrt(low * high);
            if (h - 1e-14 / h - 1e-3 * acid * ka / (ka + h) > 0.0) high = h;
            else low = h;
        }
        CHECK_NEAR(solve(&v, c), -log10(low), 1e-9);
    }
}

/* Mg(OH)2 in water with NaCl [mol/L]: the table of pH for PHREEQC's constants, MgOH+ with Davies. */
static double brucite(double log_k, double salt, int davies, double *mg)
{
    volume v;
    begin(&v);
    add_species(&v, "Mg2+");
    add_species(&v, "MgOH+");
    add_species(&v, "Mg(OH)2(s)");
    add_species(&v, "Na+");
    add_species(&v, "Cl-");
    add_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", log_k);
    add_reaction(&v, "H2O = H+ + OH-", -14.0);
    if (davies) add_reaction(&v, "Mg2+ + H2O = MgOH+ + H+", -11.44);
    build(&v, davies ? PD_ACTIVITY_DAVIES : PD_ACTIVITY_IDEAL);
    double c[8] = {55344.0, 0.0, 0.0, 0.0, 0.0, 10.0, 1e3 * salt, 1e3 * salt}, ph = solve(&v, c);
    CHECK(c[5] > 9.0);
    *mg = c[3];
    return ph;
}

TEST(brucite_table)
{
    double mg;
    CHECK_NEAR(brucite(16.298, 0.0, 0, &mg), 10.200, 1e-3);
    CHECK_NEAR(brucite(16.75, 0.0, 0, &mg), 10.350, 1e-3);
    CHECK_NEAR(brucite(16.84, 0.0, 0, &mg), 10.380, 1e-3);
    CHECK_NEAR(brucite(16.84, 0.0, 0, &mg), 14.0 + log10(cbrt(2e-28 * pow(10.0, 16.84))), 1e-6);
    CHECK_NEAR(brucite(16.84, 0.0, 1, &mg), 10.396, 2e-4);
    CHECK_NEAR(mg, 0.1221, 2e-4);
    CHECK_NEAR(brucite(16.84, 0.145, 1, &mg), 10.502, 3e-3);
    CHECK_NEAR(mg, 0.2036, 2e-3);
    CHECK_NEAR(brucite(18.794, 0.0, 1, &mg), 11.077, 3e-4);
}

/* HBSS with 4.17 mol/m3 of carbonate and 0.78 of phosphate at pH 7.4, OH- added. */
TEST(hbss)
{
    static const double table[][3] = {{0.0, 7.4, 7.0}, {0.1, 7.486, 10.0}, {0.5, 8.027, 10.699}, {1.0, 9.214, 11.0},
                                      {5.0, 10.878, 11.699}};
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        volume v, saline;
        begin(&v);
        static const char *const more[] = {"CO2", "HCO3-", "CO3-2", "H2PO4-", "HPO4-2", "PO4-3"};
        for (int i = 0; i < 6; i++) add_species(&v, more[i]);
        add_reaction(&v, "H2O = H+ + OH-", -14.0);
        add_reaction(&v, "CO2 + H2O = HCO3- + H+", -6.352);
        add_reaction(&v, "HCO3- = CO3-2 + H+", -10.329);
        add_reaction(&v, "H2PO4- = HPO4-2 + H+", -7.207);
        add_reaction(&v, "HPO4-2 = PO4-3 + H+", -12.346);
        build(&v, PD_ACTIVITY_IDEAL);
        double h = pow(10.0, -7.4), k1 = pow(10.0, -6.352), k2 = pow(10.0, -10.329), p2 = pow(10.0, -7.207);
        double p3 = pow(10.0, -12.346), p = h * h + p2 * h + p2 * p3;
        double c[9] = {55344.0, 1e3 * h, 1e-11 / h + table[k][0], 4.17 * h / k1, 4.17,
                       4.17 * k2 / h, 0.78 * h * h / p, 0.78 * p2 * h / p, 0.78 * p2 * p3 / p};
        CHECK_NEAR(solve(&v, c), table[k][1], 2e-3);
        water(&saline);
        build(&saline, PD_ACTIVITY_IDEAL);
        double salt[3] = {55344.0, 0.0, table[k][0]};
        CHECK_NEAR(solve(&saline, salt), table[k][2], 3e-4);
    }
}

/* Two minerals of one metal: the less stable one is gone; undersaturated ones dissolve. A solution stays as it is. */
TEST(minerals)
{
    volume v;
    begin(&v);
    add_species(&v, "Mg2+");
    add_species(&v, "Mg(OH)2(s)");
    add_species(&v, "MgO(s)");
    add_reaction(&v, "H2O = H+ + OH-", -14.0);
    add_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", 16.84);
    add_reaction(&v, "MgO(s) + 2 H+ = Mg2+ + H2O", 21.584);
    build(&v, PD_ACTIVITY_IDEAL);
    double c[6] = {55344.0, 0.0, 0.0, 0.0, 0.0, 5.0};
    CHECK_NEAR(solve(&v, c), 10.380, 1e-3);
    CHECK_NEAR(c[5], 0.0, 0.0);
    CHECK_NEAR(c[4], 5.0 - c[3], 1e-12);
    double again[6];
    memcpy(again, c, sizeof c);
    solve(&v, again);
    CHECK_LE(v.result.iterations, 2);
    for (int i = 0; i < 6; i++) CHECK_REL(again[i], c[i], 1e-12);
    double acid[6] = {55344.0, 20.0, 0.0, 0.0, 3.0, 1.0};
    solve(&v, acid);
    CHECK_NEAR(acid[4] + acid[5], 0.0, 0.0);
    CHECK_REL(acid[3], 4.0, 1e-12);
    CHECK_REL(acid[1], 12.0, 1e-9);
    CHECK(v.result.log_activity[4] < 0.0);
}

/* Any start from 1e-300 to 1e3 mol/m3 and any K from 1e-60 to 1e60: solved. With K from 1e-6 to
 * 1e6 the same comes out with reactions and species in another order. */
TEST(any_start)
{
    uint32_t state = 7u;
    int most = 0, failed = 0;
    for (int k = 0; k < 3000; k++) {
        double c[2][8], ln[5];
        volume v[2];
        for (int i = 0; i < 5; i++) {
            state = state * 1664525u + 1013904223u;
            ln[i] = (k % 4 == 1 ? 0.1 : 1.0) * (-60.0 + 120.0 * (state >> 8) / 16777216.0);
        }
        for (int i = 0; i < 8; i++) {
            state = state * 1664525u + 1013904223u;
            c[0][i] = pow(10.0, -300.0 + 303.0 * (state >> 8) / 16777216.0);
            if (k % 2) c[0][i] = pow(10.0, -9.0 + 12.0 * (state >> 8) / 16777216.0);
        }
        for (int o = 0; o < 2; o++) {
            static const char *const names[] = {"HCO3-", "CO2", "CO3-2", "Mg2+", "Mg(OH)2(s)"};
            static const char *const text[] = {"H2O = H+ + OH-", "CO2 + H2O = HCO3- + H+", "HCO3- = CO3-2 + H+",
                                               "Mg(OH)2(s) = Mg2+ + 2 OH-"};
            begin(&v[o]);
            for (int i = 0; i < 5; i++) add_species(&v[o], names[o ? 4 - i : i]);
            for (int i = 0; i < 4; i++) add_reaction(&v[o], text[o ? 3 - i : i], ln[o ? 3 - i : i]);
            build(&v[o], PD_ACTIVITY_IDEAL);
        }
        for (int i = 0; i < 8; i++) c[1][at(&v[1], v[0].s[i].name)] = c[0][i];
        int status = pd_speciation_solve(&v[0].system, c[0], &v[0].result);
        failed += status != PD_OK || pd_speciation_solve(&v[1].system, c[1], &v[1].result) != PD_OK;
        for (int i = 0; k % 4 == 1 && i < 8; i++) {
            double a = v[0].result.log_activity[i], b = v[1].result.log_activity[at(&v[1], v[0].s[i].name)];
            if (fabs(a) < 1e3) CHECK_NEAR(a, b, 1e-6);
        }
        most = v[0].result.iterations > most ? v[0].result.iterations : most;
    }
    CHECK_INT(failed, 0);
    CHECK_LE(most, 100);
}

TEST_MAIN(ENTRY(water_alone) ENTRY(weak_acid) ENTRY(brucite_table) ENTRY(hbss) ENTRY(minerals) ENTRY(any_start))
