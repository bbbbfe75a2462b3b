/* components: totals and concentrations against the equilibria of speciation, which are solved in another way; from any
 * guess; derivatives against differences.
 * dims: 1 */
#include "chemistry/speciation.h"
#include "chemistry_case.h"
#include "random.h"

static void build(mixture *v, pd_activity activity, pd_components *s)
{
    CHECK_OK(&v->ctx, pdi_components_build(&v->ctx, v->s, v->species, v->r, v->reactions, activity, 298.15, s));
}

/* Concentrations of solutes from those of all species. */
static void pick(const pd_components *s, int species, const double *all, double *c)
{
    for (int i = 0; i < species; i++)
        if (s->solute_of_species[i] >= 0) c[s->solute_of_species[i]] = all[i];
}

/* Any mixture, from a guess that says nothing. Speciation finds the same. */
static void any(pd_activity activity, double most, double tolerance)
{
    mixture v;
    pd_components s;
    pd_speciation system;
    pd_speciation_result result;
    uint32_t random = 7;
    int solved = 0;
    mix_body_fluid(&v);
    build(&v, activity, &s);
    CHECK_OK(&v.ctx, pd_speciation_build(&v.ctx, v.s, v.species, v.r, v.reactions, activity, 298.15, &system));
    CHECK_INT(s.solutes, 14);
    CHECK_INT(s.count, 7);
    CHECK_INT(s.equilibrium_components, 5);
    for (int k = 0; k < 400; k++) {
        double all[PD_SPECIES_MAX], c[PD_SPECIES_MAX], total[PD_SPECIES_MAX], again[PD_SPECIES_MAX];
        for (int i = 0; i < v.species; i++) all[i] = most * pow(10.0, -12.0 * random_share(&random));
        all[0] = 55344.0;
        pick(&s, v.species, all, c);
        pdi_components_compute_totals(&s, c, total);
        for (int i = 0; i < s.solutes && k % 2; i++) c[i] = 1e-3;
        if (!CHECK_INT(pdi_components_solve(&s, total, c), PD_OK)) continue;
        pdi_components_compute_totals(&s, c, again);
        for (int m = 0; m < s.count; m++) {
            double size = fabs(total[m]);
            for (int i = 0; i < s.solutes; i++) size += fabs(s.stoichiometry[m][i]) * c[i];
            CHECK_NEAR(again[m], total[m], 1e-14 * size);
        }
        if (pd_speciation_solve(&system, all, &result) != PD_OK) continue;
        solved++;
        for (int i = 1; i < v.species; i++) CHECK_REL(c[s.solute_of_species[i]], all[i], tolerance);
    }
    CHECK_LE(380, solved);
}

TEST(any_ideal) { any(PD_ACTIVITY_IDEAL, 100.0, 1e-7); }
TEST(any_davies) { any(PD_ACTIVITY_DAVIES, 30.0, 1e-7); }

/* A + 2 B = P with K of 1e30: one of both is used up. What totals cannot have is next to 0. */
TEST(front)
{
    mixture v;
    pd_components s;
    mix_begin(&v);
    int a = mix_species(&v, "Aa", "Na", 1e-9), b = mix_species(&v, "Bb", "K", 1e-9);
    int p = mix_species(&v, "Pp", "NaK2", 1e-9);
    mix_reaction(&v, "Aa + 2 Bb = Pp", 30.0, 0.0, NULL);
    build(&v, PD_ACTIVITY_IDEAL, &s);
    for (int k = 0; k < 41; k++) {
        double c[3] = {0.0, 0.0, 0.0}, start[3] = {0.0, 0.0, 0.0}, total[3];
        start[a] = 10.0;
        start[b] = k;
        pdi_components_compute_totals(&s, start, total);
        CHECK_INT(pdi_components_solve(&s, total, c), PD_OK);
        CHECK_NEAR(c[a], fmax(10.0 - 0.5 * k, 0.0), k == 20 ? 1e-6 : 1e-11);
        CHECK_NEAR(c[b], fmax(k - 20.0, 0.0), k == 20 ? 1e-6 : 1e-11);
        CHECK_NEAR(c[p], fmin(10.0, 0.5 * k), k == 20 ? 1e-6 : 1e-11);
        for (int i = 0; i < 3; i++) CHECK(c[i] >= 0.0);
        start[a] = -1e-9;
        pdi_components_compute_totals(&s, start, total);
        CHECK_INT(pdi_components_solve(&s, total, c), PD_OK);
        for (int i = 0; i < 3; i++) CHECK(c[i] >= 0.0);
        CHECK_NEAR(c[b], k, 1e-8);
    }
}

/* An acid without magnesium, sought from a lye with much of it: the first step of Newton goes past all acid. */
TEST(acid_from_lye)
{
    mixture v;
    pd_components s;
    double c[PD_SPECIES_MAX] = {0.0}, start[PD_SPECIES_MAX] = {0.0}, total[PD_SPECIES_MAX];
    double acid = 0.15452454172346108;
    mix_begin(&v);
    mix_species(&v, "H2O", NULL, 0.0);
    mix_species(&v, "H+", NULL, 9.31e-9);
    mix_species(&v, "OH-", NULL, 5.27e-9);
    mix_species(&v, "Mg2+", NULL, 0.705e-9);
    mix_species(&v, "MgOH+", NULL, 0.705e-9);
    mix_species(&v, "Na+", NULL, 1.33e-9);
    mix_species(&v, "Cl-", NULL, 2.03e-9);
    mix_reaction(&v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    mix_reaction(&v, "Mg2+ + H2O = MgOH+ + H+", -11.44, 0.0, NULL);
    for (int davies = 0; davies < 2; davies++) {
        build(&v, davies ? PD_ACTIVITY_DAVIES : PD_ACTIVITY_IDEAL, &s);
        int h = s.solute_of_species[1], oh = s.solute_of_species[2], mg = s.solute_of_species[3],
            mgoh = s.solute_of_species[4];
        for (int i = 5; i < 7; i++) c[s.solute_of_species[i]] = start[s.solute_of_species[i]] = 154.0;
        start[h] = acid;
        start[mg] = -1.7763568394002505e-15;
        pdi_components_compute_totals(&s, start, total);
        c[h] = 5.29065e-10;
        c[oh] = 33.8101;
        c[mg] = 5.81935;
        c[mgoh] = 22.3259;
        CHECK_INT(pdi_components_solve(&s, total, c), PD_OK);
        CHECK_NEAR(c[h], acid + c[oh], 1e-14);
        CHECK(c[oh] > 5e-8 && c[oh] < 2e-7);
        CHECK(c[mg] >= 0.0 && c[mg] < 1e-14 && c[mgoh] >= 0.0 && c[mgoh] < 1e-14);
    }
}

static void derivatives(pd_activity activity)
{
    mixture v;
    pd_components s;
    double all[PD_SPECIES_MAX], c[PD_SPECIES_MAX], total[PD_SPECIES_MAX], by[PD_SPECIES_MAX];
    float table[PD_COMPONENTS_DERIVATIVES];
    mix_body_fluid(&v);
    build(&v, activity, &s);
    mix_hanks(&v, all);
    pick(&s, v.species, all, c);
    pdi_components_compute_totals(&s, c, total);
    CHECK_INT(pdi_components_solve(&s, total, c), PD_OK);
    pdi_components_compute_derivatives_single(&s, c, table);
    for (int k = 0; k < s.count; k++) {
        double one[PD_SPECIES_MAX] = {0.0}, high[PD_SPECIES_MAX], low[PD_SPECIES_MAX], step = 1e-4;
        one[k] = 1.0;
        pdi_components_apply_derivatives(&s, table, one, by);
        memcpy(high, c, sizeof high);
        memcpy(low, c, sizeof low);
        total[k] += step;
        CHECK_INT(pdi_components_solve(&s, total, high), PD_OK);
        total[k] -= 2.0 * step;
        CHECK_INT(pdi_components_solve(&s, total, low), PD_OK);
        total[k] += step;
        for (int i = 0; i < s.solutes; i++)
            CHECK_NEAR(by[i], (high[i] - low[i]) / (2.0 * step), 2e-6 * (fabs(by[i]) + 1e-4));
    }
}

TEST(derivatives_ideal) { derivatives(PD_ACTIVITY_IDEAL); }
TEST(derivatives_davies) { derivatives(PD_ACTIVITY_DAVIES); }

/* All species that there can be in one reaction, x of which brings nu_i x: with dT more of a component its extent is
 * -(nu/c dT)/sum(nu^2/c), and so are the slopes. The table is full, and nothing is written behind it. */
TEST(most_species)
{
    mixture v;
    pd_components s;
    double c[PD_SPECIES_MAX], total[PD_SPECIES_MAX], nu[PD_SPECIES_MAX], table[PD_COMPONENTS_DERIVATIVES + 1],
        sum = 0.0;
    char text[8 * PD_SPECIES_MAX] = "", name[8];
    mix_begin(&v);
    for (int i = 0; i < PD_SPECIES_MAX; i++) {
        const char *sign = i == PD_SPECIES_MAX / 2 ? " = " : i ? " + " : "";
        snprintf(name, sizeof name, "%c%c", i % 2 ? 'J' : 'Q', 'a' + i / 2); /* no elements */
        mix_species(&v, name, "Na", 1e-9);
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", sign, name);
    }
    mix_reaction(&v, text, 0.0, 0.0, NULL);
    build(&v, PD_ACTIVITY_DAVIES, &s);
    int columns = pdi_components_count_columns(&s);
    CHECK_INT(s.members, PD_SPECIES_MAX);
    CHECK_INT(columns, PD_SPECIES_MAX);
    for (int i = 0; i < s.solutes; i++) {
        c[i] = 1.0 + 0.1 * i;
        nu[i] = i < PD_SPECIES_MAX / 2 ? -1.0 : 1.0;
    }
    pdi_components_compute_totals(&s, c, total);
    CHECK_INT(pdi_components_solve(&s, total, c), PD_OK);
    for (int i = 0; i < s.solutes; i++) sum += 1.0 / c[i];
    table[s.members * columns] = -7.0;
    pdi_components_compute_derivatives(&s, c, table);
    CHECK_NEAR(table[s.members * columns], -7.0, 0.0);
    for (int n = 0; n < s.members; n++)
        for (int k = 0; k < s.equilibrium_components; k++) {
            int i = s.member_solute[n], with = s.component_solute[k];
            CHECK_NEAR(table[n * columns + k], (i == with ? 1.0 : 0.0) - nu[i] * nu[with] / c[with] / sum, 1e-12);
        }
    /* no charges */
    for (int n = 0; n < s.members; n++) CHECK_NEAR(table[n * columns + s.equilibrium_components], 0.0, 1e-15);
}

TEST(speeds)
{
    mixture v;
    pd_components s;
    double all[4] = {0.3, 0.7, 0.2, 5.0}, by[4], size;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    mix_species(&v, "Pp", "NaK2", 1e-9);
    mix_species(&v, "H2O", NULL, 0.0);
    mix_reaction(&v, "Aa + 2 Bb = Pp", 3.0, 7.0, "L2/mol2/s");
    build(&v, PD_ACTIVITY_IDEAL, &s);
    CHECK_INT(s.count, 3);
    CHECK_INT(s.kinetics, 1);
    CHECK_REL(pdi_components_compute_rate(&s, &s.kinetic[0], all, by, &size), pd_reaction_rate(&v.r[0], v.s, 4, all),
              1e-14);
    /* k of L2/mol2/s is 1e-6 of m6/mol2/s; K = 1000 L2/mol2. */
    CHECK_REL(size, 7e-6 * 0.3 * 0.49 + 7.0 / 1000.0 * 0.2, 1e-13);
    for (int i = 0; i < 3; i++) {
        double x = all[i], step = 1e-5;
        all[i] = x + step;
        double high = pd_reaction_rate(&v.r[0], v.s, 4, all);
        all[i] = x - step;
        double low = pd_reaction_rate(&v.r[0], v.s, 4, all);
        all[i] = x;
        CHECK_REL(by[i], (high - low) / (2.0 * step), 1e-8);
    }
}

/* Broensted and Bjerrum: at the concentrations whose activities give K nothing happens; which way the reaction is
 * written does not matter; the derivatives are those of differences. */
TEST(speeds_among_ions)
{
    mixture v;
    pd_components s;
    double all[5] = {40.0, 0.3, 0.0, 100.0, 180.0}, by[5], strength, davies, slope, speed[2];
    mix_begin(&v);
    mix_species(&v, "Mg2+", NULL, 1e-9);
    mix_species(&v, "OH-", NULL, 1e-9);
    mix_species(&v, "MgOH+", NULL, 1e-9);
    mix_species(&v, "Na+", NULL, 1e-9);
    mix_species(&v, "Cl-", NULL, 1e-9);
    mix_reaction(&v, "Mg2+ + OH- = MgOH+", 2.6, 5.0, "L/mol/s");
    mix_reaction(&v, "MgOH+ = Mg2+ + OH-", -2.6, 5.0 * pow(10.0, -2.6), "1/s");
    build(&v, PD_ACTIVITY_DAVIES, &s);
    CHECK_INT(s.kinetics, 2);
    /* ln gamma z^2: 4 and 1 on one side, 1 on the other; a_p/(a_m a_o) = K */
    for (int k = 0; k < 100; k++) {
        strength = 0.5 * (4.0 * all[0] + all[1] + all[2] + all[3] + all[4]);
        davies = pdi_activity_compute_davies(s.debye_hueckel, strength, &slope);
        all[2] = pow(10.0, 2.6) * 1e-3 * all[0] * all[1] * exp(4.0 * davies);
    }
    for (int r = 0; r < 2; r++)
        CHECK_NEAR(pdi_components_compute_rate(&s, &s.kinetic[r], all, NULL, NULL), 0.0, 1e-12 * all[2]);
    all[2] *= 3.0;
    for (int r = 0; r < 2; r++) speed[r] = pdi_components_compute_rate(&s, &s.kinetic[r], all, by, NULL);
    CHECK_REL(speed[0], -speed[1], 1e-12);
    for (int i = 0; i < 5; i++) {
        double x = all[i], step = 1e-5;
        all[i] = x + step;
        double high = pdi_components_compute_rate(&s, &s.kinetic[1], all, NULL, NULL);
        all[i] = x - step;
        double low = pdi_components_compute_rate(&s, &s.kinetic[1], all, NULL, NULL);
        all[i] = x;
        CHECK_NEAR(by[i], (high - low) / (2.0 * step), 1e-7 * fabs(speed[1]));
    }
}

/* Water alone holds H+ and OH-, whether they come at once, at finite rate, or by a reaction that is written
 * backwards. */
TEST(water)
{
    const char *text[3] = {"H2O = H+ + OH-", "H+ + OH- = H2O", "H2O = H+ + OH-"};
    for (int k = 0; k < 3; k++) {
        mixture v;
        pd_components s;
        double c[PD_SPECIES_MAX];
        mix_begin(&v);
        mix_species(&v, "H+", NULL, 1e-9);
        mix_species(&v, "OH-", NULL, 1e-9);
        mix_species(&v, "Mg2+", NULL, 1e-9);
        mix_species(&v, "MgOH+", NULL, 1e-9);
        mix_species(&v, "H2O", NULL, 0.0);
        mix_reaction(&v, text[k], k == 1 ? 14.0 : -14.0, k ? 7.0 : 0.0, k == 1 ? "L/mol/s" : k ? "mol/L/s" : NULL);
        mix_reaction(&v, "Mg2+ + OH- = MgOH+", 2.6, 0.0, NULL);
        build(&v, PD_ACTIVITY_DAVIES, &s);
        CHECK_INT(pdi_components_solve_pure_solvent(&s, c), PD_OK);
        CHECK_REL(c[0], 1e-4, 1e-3); /* the activities of 1e-7 mol/L */
        CHECK_REL(c[1], 1e-4, 1e-3);
        CHECK_NEAR(c[2] + c[3], 0.0, 1e-12);
    }
}

/* 1: solute i is a component. */
static int is_master(const pd_components *s, int i)
{
    for (int k = 0; k < s->count; k++)
        if (s->component_solute[k] == i) return 1;
    return 0;
}

/* Species and reactions the other way round have the same components: sizes of totals, and so steps, go by them. */
TEST(order)
{
    mixture v, w;
    pd_components s, t;
    mix_body_fluid(&v);
    w = v;
    for (int i = 0; i < v.species; i++) w.s[i] = v.s[v.species - 1 - i];
    for (int r = 0; r < v.reactions; r++) {
        w.r[r] = v.r[v.reactions - 1 - r];
        for (int i = 0; i < v.species; i++) w.r[r].nu[i] = v.r[v.reactions - 1 - r].nu[v.species - 1 - i];
    }
    build(&v, PD_ACTIVITY_IDEAL, &s);
    build(&w, PD_ACTIVITY_IDEAL, &t);
    for (int i = 0; i < v.species; i++)
        if (s.solute_of_species[i] >= 0)
            CHECK_INT(is_master(&s, s.solute_of_species[i]), is_master(&t, t.solute_of_species[v.species - 1 - i]));
}

/* What water alone makes has no total: its concentration is the constant, from any guess. */
TEST(of_water_alone)
{
    for (int davies = 0; davies < 2; davies++) {
        mixture v;
        pd_components s;
        double c[PD_SPECIES_MAX] = {7.0}, slopes[PD_COMPONENTS_DERIVATIVES] = {3.0}, total = 0.0;
        mix_begin(&v);
        mix_species(&v, "H2O", NULL, 0.0);
        mix_species(&v, "H4O2", NULL, 1e-9);
        mix_reaction(&v, "H4O2 = 2 H2O", 1.5, 0.0, NULL);
        build(&v, davies ? PD_ACTIVITY_DAVIES : PD_ACTIVITY_IDEAL, &s);
        CHECK_INT(s.count, 0);
        CHECK_INT(s.members, 1);
        CHECK_INT(pdi_components_solve(&s, &total, c), PD_OK);
        CHECK_REL(c[0], 1000.0 * pow(10.0, -1.5), 1e-14);
        pdi_components_compute_derivatives(&s, c, slopes);
        CHECK_NEAR(slopes[0], davies ? 0.0 : 3.0, 0.0);
    }
}

TEST(refused)
{
    mixture v;
    pd_components s;
    mix_body_fluid(&v);
    mix_reaction(&v, "CO2 + H2O = CO3-2 + 2 H+", -15.0, 0.0, NULL);
    CHECK_INT(pdi_components_build(&v.ctx, v.s, v.species, v.r, v.reactions, PD_ACTIVITY_IDEAL, 298.15, &s),
              PD_ERR_ARGUMENT);
    CHECK_INT(s.solutes, 0);
    mix_species(&v, "CO2(g)", NULL, 0.0);
    CHECK_INT(pdi_components_build(&v.ctx, v.s, v.species, v.r, 1, PD_ACTIVITY_IDEAL, 298.15, &s), PD_ERR_ARGUMENT);
}

TEST_MAIN(ENTRY(any_ideal) ENTRY(any_davies) ENTRY(front) ENTRY(derivatives_ideal) ENTRY(derivatives_davies)
          ENTRY(acid_from_lye) ENTRY(speeds) ENTRY(speeds_among_ions) ENTRY(water)
          ENTRY(order) ENTRY(most_species) ENTRY(of_water_alone)
          ENTRY(refused))
