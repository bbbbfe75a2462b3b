/* reactions and activity: constants by hand, in any unit; one message for what does not balance or fit; speeds by mass
 * action; Davies' equation against a table.
 * dims: 1 */
#include "chemistry/activity.h"
#include "chemistry/reaction.h"
#include "test.h"

static const char *const names[] = {"H+", "OH-", "H2O", "Mg2+", "Mg(OH)2(s)", "MgOH+", "CO3-2", "HCO3-"};
enum { H, OH, WATER, MG, BRUCITE, MGOH, CO3, HCO3, COUNT };

static void make(pd_ctx *ctx, pd_species *s)
{
    pd_ctx_init(ctx);
    for (int i = 0; i < COUNT; i++) {
        pd_species_desc d;
        memset(&d, 0, sizeof d);
        d.name = names[i];
        CHECK_OK(ctx, pd_species_read(ctx, &d, &s[i]));
    }
}

static pd_status read(pd_ctx *ctx, const pd_species *s, const char *text, double k, const char *unit, pd_reaction *r)
{
    pd_reaction_desc d;
    memset(&d, 0, sizeof d);
    d.name = "x";
    d.text = text;
    d.k = k;
    d.k_unit = unit;
    return pd_reaction_read(ctx, &d, s, COUNT, r);
}

TEST(constants)
{
    pd_ctx ctx;
    pd_species s[COUNT];
    pd_reaction r;
    double ln10 = log(10.0);
    make(&ctx, s);
    CHECK_OK(&ctx, read(&ctx, s, "H2O = H+ + OH-", 1e-14, "mol2/L2", &r));
    CHECK_REL(r.ln_k, -14.0 * ln10, 1e-14);
    CHECK_NEAR(r.nu[H], 1.0, 0.0);
    CHECK_NEAR(r.nu[WATER], -1.0, 0.0);
    CHECK_INT(r.kinetic, 0);
    CHECK_OK(&ctx, read(&ctx, s, "H2O = H+ + OH-", 1e-8, "mol^2/m^6", &r));
    CHECK_REL(r.ln_k, -14.0 * ln10, 1e-14);
    CHECK_OK(&ctx, read(&ctx, s, "H2O = H+ + OH-", 1e-8, "mM2", &r));
    CHECK_REL(r.ln_k, -14.0 * ln10, 1e-14);
    CHECK_OK(&ctx, read(&ctx, s, "  H+ + OH-   =\tH2O ", 14.0, "log10", &r));
    CHECK_REL(r.ln_k, 14.0 * ln10, 1e-14);
    CHECK_OK(&ctx, read(&ctx, s, "Mg(OH)2(s) = Mg2+ + 2 OH-", 1e-2, "mol3 m-9", &r));
    CHECK_REL(r.ln_k, -11.0 * ln10, 1e-14);
    CHECK_NEAR(r.nu[OH], 2.0, 0.0);
    CHECK_OK(&ctx, read(&ctx, s, "Mg2+ + H2O = MgOH+ + H+", 3.6e-12, "mol/L", &r));
    CHECK_REL(r.ln_k, log(3.6e-12), 1e-14);
    CHECK_OK(&ctx, read(&ctx, s, "MgOH+ + H+ = Mg2+ + H2O", 100.0, "L/mol", &r));
    CHECK_REL(r.ln_k, log(100.0), 1e-13);
    CHECK_OK(&ctx, read(&ctx, s, "CO3-2 + H2O = HCO3- + OH-", 2.1e-4, "mol/L", &r));
    CHECK_OK(&ctx, read(&ctx, s, "0.5 H2O = 0.5 H+ + 0.5OH-", 1e-7, "mol/L", &r));
    CHECK_REL(r.ln_k, -7.0 * ln10, 1e-14);
}

static void refuse(const char *text, double k, const char *unit, const char *part, const char *part2)
{
    pd_ctx ctx;
    pd_species s[COUNT];
    pd_reaction r;
    make(&ctx, s);
    int status = read(&ctx, s, text, k, unit, &r);
    if (!CHECK(status == PD_ERR_PARSE || status == PD_ERR_ARGUMENT) || !CHECK(strstr(ctx.message, part) != NULL) ||
        !CHECK(strstr(ctx.message, part2) != NULL))
        NOTE("'%s' gave: %s (expected %s, %s)", text, ctx.message, part, part2);
}

TEST(refused)
{
    refuse("Mg2+ + OH- = Mg(OH)2(s)", 1.0, "log10", "1 O on the left", "2 on the right");
    refuse("HCO3- = CO3-2 + H2O", 1.0, "log10", "does not balance", "H");
    refuse("HCO3- + Mg2+ = CO3-2 + MgOH+", 1.0, "log10", "does not balance", "O on the");
    refuse("Mg2+ + H2O = MgOH+ + H+ + e-", 1.0, "log10", "'e-', which nobody defines", "H2O");
    refuse("H+ + OX- = H2O", 1.0, "log10", "'OX-', which nobody defines", "Mg(OH)2(s)");
    refuse("H2O = H+ + OH-", 1e-14, NULL, "K of 'x' has no unit", "mol2/L2, or log10_K");
    refuse("H2O = H+ + OH-", 1e-14, "mol/L", "has the unit 'mol/L'", "expected mol2/L2");
    refuse("H2O = H+ + OH-", 1e-14, "kg", "has the unit 'kg'", "expected mol2/L2");
    refuse("H2O = H+ + OH-", 1e-14, "mol2//L2", "has the unit 'mol2//L2'", "expected mol2/L2");
    refuse("H2O = H+ + OH-", 1e-14, "mol2/L2/", "has the unit 'mol2/L2/'", "expected mol2/L2");
    refuse("H+ + OH- = H2O", 1e14, "mol2/L2", "expected L2/mol2", "log10_K");
    refuse("Mg(OH)2(s) = Mg2+ + 2 OH-", 1e-11, "mol2/L2", "expected mol3/L3", "log10");
    refuse("H2O = H+ + OH-", -1.0, "mol2/L2", "expected a positive number", "-1");
    refuse("H2O = H+ + OH-", 0.0, "mol2/L2", "expected a positive number", "0");
    refuse("H2O = H+ + OH-", (double)NAN, "mol2/L2", "neither", "rate");
    refuse("H2O H+ + OH-", 1.0, "log10", "'H2O H+'", "nobody defines");
    refuse("H+ + OH-", 1.0, "log10", "has no =", "H2O");
    refuse("H2O = H+ = OH-", 1.0, "log10", "two =", "expected one");
    refuse("H2O = ", 1.0, "log10", "the term ''", "blanks around");
    refuse("H2O = H+ +", 1.0, "log10", "the term ''", "blanks around");
    refuse("0 H2O = H+ + OH-", 1.0, "log10", "term '0 H2O'", "expected terms");
    refuse("H2O = H2O", 1.0, "log10", "on both sides", "difference");
    refuse("", 1.0, "log10", "the term ''", "expected");
    /* the longest term, and one byte more */
    char longest[80] = "H2O = ";
    memset(longest + 6, 'Q', 48);
    refuse(longest, 1.0, "log10", "is longer than 47 bytes", "a term of");
    longest[6 + 47] = 0;
    refuse(longest, 1.0, "log10", "QQQ', which nobody defines", "H2O");
}

/* Water at 25 C: forward 1.4e11 L/mol/s, and K gives the backward one. */
TEST(speeds)
{
    pd_ctx ctx;
    pd_species s[COUNT];
    pd_reaction r;
    pd_reaction_desc d;
    double c[COUNT] = {0.0};
    make(&ctx, s);
    memset(&d, 0, sizeof d);
    d.text = "H+ + OH- = H2O";
    d.k = 14.0;
    d.k_unit = "log10";
    d.forward = 1.4e11;
    d.forward_unit = "L/mol/s";
    CHECK_OK(&ctx, pd_reaction_read(&ctx, &d, s, COUNT, &r));
    CHECK_INT(r.kinetic, 1);
    CHECK_REL(r.forward, 1.4e8, 1e-13);
    CHECK_REL(r.backward, 1.4, 1e-12);
    c[H] = 2e-4;
    c[OH] = 3e-4;
    CHECK_REL(pd_reaction_rate(&r, s, COUNT, c), 1.4e8 * (6e-8 - 1e-8), 1e-12);
    c[OH] = 0.5e-4;
    CHECK_NEAR(pd_reaction_rate(&r, s, COUNT, c), 0.0, 1e-12);
    d.forward_unit = "1/s";
    CHECK_INT(pd_reaction_read(&ctx, &d, s, COUNT, &r), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "expected L/mol/s") != NULL);
    d.forward_unit = "m3/mol/s";
    d.backward = 1.0;
    CHECK_INT(pd_reaction_read(&ctx, &d, s, COUNT, &r), PD_ERR_ARGUMENT);
    d.k = (double)NAN;
    d.backward_unit = "mol/m3/s";
    CHECK_OK(&ctx, pd_reaction_read(&ctx, &d, s, COUNT, &r));
    CHECK_NEAR(r.backward, 1.0, 1e-13);
}

/* log10 gamma of an ion of charge 1 at 0.1 mol/L with A = 0.509: -0.107; the slope against a difference. */
TEST(davies)
{
    double slope, a = pdi_activity_compute_debye_hueckel(298.15), other;
    CHECK_NEAR(a, 0.509, 0.002);
    CHECK_NEAR(pdi_activity_compute_debye_hueckel(310.15), 0.521, 0.003);
    CHECK_NEAR(pdi_activity_compute_davies(0.509, 100.0, &slope) / log(10.0), -0.1070, 1e-4);
    CHECK_NEAR(pdi_activity_compute_davies(0.509, 0.0, &slope), 0.0, 0.0);
    for (double strength = 1e-6; strength < 1e4; strength *= 3.0) {
        double h = 1e-5 * strength;
        double change =
            pdi_activity_compute_davies(a, strength + h, &other) - pdi_activity_compute_davies(a, strength - h, &other);
        pdi_activity_compute_davies(a, strength, &slope);
        CHECK_NEAR(change / (2.0 * h), slope, 1e-6 * fabs(slope) + 1e-9);
    }
}

TEST_MAIN(ENTRY(constants) ENTRY(refused) ENTRY(speeds) ENTRY(davies))
