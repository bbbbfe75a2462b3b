/* species: charges and elements from names, against a list by hand; what disagrees; random texts.
 * dims: 1 */
#include "chemistry/species.h"
#include "test.h"

static pd_status read(pd_ctx *ctx, const char *name, pd_species *s)
{
    pd_species_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.name = name;
    return pd_species_read(ctx, &desc, s);
}

typedef struct sample {
    const char *name;
    int charge;
    pd_phase phase;
    const char *elements; /* "Mg 1 O 2", in the order of the name */
} sample;

TEST(names)
{
    static const sample list[] = {
        {"Mg2+", 2, PD_PHASE_SOLUTE, "Mg1"}, {"Mg+2", 2, PD_PHASE_SOLUTE, "Mg1"}, {"OH-", -1, PD_PHASE_SOLUTE, "O1H1"},
        {"H+", 1, PD_PHASE_SOLUTE, "H1"}, {"H2PO4-", -1, PD_PHASE_SOLUTE, "H2P1O4"}, {"NO3-", -1, PD_PHASE_SOLUTE,
        "N1O3"},
        {"SO42-", -2, PD_PHASE_SOLUTE, "S1O4"}, {"SO4^2-", -2, PD_PHASE_SOLUTE, "S1O4"},
        {"SO4_2-", -2, PD_PHASE_SOLUTE, "S1O4"}, {"SO4 2-", -2, PD_PHASE_SOLUTE, "S1O4"},
        {"SO4-2", -2, PD_PHASE_SOLUTE, "S1O4"}, {"SO4--", -2, PD_PHASE_SOLUTE, "S1O4"},
        {"PO4^3-", -3, PD_PHASE_SOLUTE, "P1O4"}, {"HPO42-", -2, PD_PHASE_SOLUTE, "H1P1O4"},
        {"MgOH+", 1, PD_PHASE_SOLUTE, "Mg1O1H1"}, {"Al(OH)4-", -1, PD_PHASE_SOLUTE, "Al1O4H4"},
        {"Hg22+", 2, PD_PHASE_SOLUTE, "Hg2"}, {"Cl^-", -1, PD_PHASE_SOLUTE, "Cl1"},
        {"Mg(OH)2(s)", 0, PD_PHASE_SOLID, "Mg1O2H2"}, {"CaCO3", 0, PD_PHASE_SOLUTE, "Ca1C1O3"},
        {"CO2(g)", 0, PD_PHASE_GAS, "C1O2"}, {"CO2(aq)", 0, PD_PHASE_SOLUTE, "C1O2"},
        {"H2O", 0, PD_PHASE_SOLVENT, "H2O1"}, {"e-", -1, PD_PHASE_ELECTRON, ""},
        {"CaHPO4:2H2O(s)", 0, PD_PHASE_SOLID, "Ca1H5P1O6"}, {"Ca5(PO4)3OH(s)", 0, PD_PHASE_SOLID, "Ca5P3O13H1"}};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (size_t k = 0; k < sizeof list / sizeof list[0]; k++) {
        pd_species s;
        char text[64] = "", symbol[3];
        if (!CHECK_OK(&ctx, read(&ctx, list[k].name, &s))) continue;
        for (int e = 0; e < s.elements; e++) {
            pd_species_get_symbol(s.element[e], symbol);
            pd_append(text, sizeof text, "%s%d", symbol, s.count[e]);
        }
        int right = CHECK_INT(s.charge, list[k].charge) & CHECK_INT(s.phase, list[k].phase);
        if (!CHECK_STR(text, list[k].elements) || !right) NOTE("of %s", list[k].name);
    }
}

TEST(refused)
{
    static const char *const list[] = {"", "Xx", "mg2+", "Mg(OH", "Mg)2", "Mg0", "H1000", "()", "2", "+", "-",
    "2+", "H+-",
                                       "H:", ":H", "(s)", "H2O:", "AbCdEfGhIjKlMnOpQrStUvWx",
                                       "((((((H))))))", "HHeLiBeBCNOF", "H++2"};
    pd_ctx ctx;
    pd_species s;
    pd_ctx_init(&ctx);
    for (size_t k = 0; k < sizeof list / sizeof list[0]; k++) {
        if (!CHECK_INT(read(&ctx, list[k], &s), PD_ERR_PARSE)) NOTE("of '%s'", list[k]);
        CHECK_INT(s.name[0], 0);
    }
}

TEST(given)
{
    pd_ctx ctx;
    pd_species s;
    pd_species_desc d;
    pd_ctx_init(&ctx);
    memset(&d, 0, sizeof d);
    d.name = "glucose";
    d.formula = "C6H12O6";
    CHECK_OK(&ctx, pd_species_read(&ctx, &d, &s));
    CHECK_INT(pdi_species_count_atoms(&s, 6), 6);
    CHECK_INT(pdi_species_count_atoms(&s, 1), 12);
    CHECK_INT(pdi_species_count_atoms(&s, 7), 0);
    d.formula = "C6h";
    CHECK_INT(pd_species_read(&ctx, &d, &s), PD_ERR_PARSE);
    d.name = "Mg2+";
    d.formula = "Ca";
    CHECK_INT(pd_species_read(&ctx, &d, &s), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "other elements") != NULL);
    d.formula = NULL;
    d.has_charge = 1;
    d.charge = 1;
    CHECK_INT(pd_species_read(&ctx, &d, &s), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "+2 by its name") != NULL);
    d.charge = 2;
    d.diffusivity = 7.05e-10;
    CHECK_OK(&ctx, pd_species_read(&ctx, &d, &s));
    CHECK_NEAR(s.diffusivity, 7.05e-10, 0.0);
    d.diffusivity = -1.0;
    CHECK_INT(pd_species_read(&ctx, &d, &s), PD_ERR_ARGUMENT);
}

/* Random names: read or refused; what is read has atoms. */
TEST(random_names)
{
    static const char letters[] = "HOMgCalN()23+-:^_ s0";
    pd_ctx ctx;
    uint32_t state = 1u;
    int reads = 0;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 200000; k++) {
        char name[12];
        pd_species s;
        state = state * 1664525u + 1013904223u;
        int size = 1 + (int)(state >> 16) % 11;
        for (int c = 0; c < size; c++) {
            state = state * 1664525u + 1013904223u;
            name[c] = letters[(state >> 16) % (sizeof letters - 1)];
        }
        name[size] = 0;
        if (read(&ctx, name, &s) < 0) continue;
        reads++;
        if (s.elements < 1 || s.count[0] < 1 || strcmp(s.name, name) != 0) CHECK_STR(name, "a formula");
    }
    CHECK(reads > 1000);
}

TEST_MAIN(ENTRY(names) ENTRY(refused) ENTRY(given) ENTRY(random_names))
