/* mineral: amounts and concentrations of a volume against the equilibria of speciation, which are solved in another
 * way; laws in time against their own closed forms; derivatives against differences; what bad input says.
 * dims: 1 */
#include "chemistry/mineral_step.h"
#include "chemistry/speciation.h"
#include "chemistry_case.h"
#include "random.h"

static pd_components test_system;
static pd_minerals test_minerals;

/* Body fluid with brucite, calcite and hydroxyapatite. */
static void body(mixture *v, pd_mineral *of)
{
    mix_body_fluid(v);
    memset(of, 0, 3 * sizeof *of);
    of[0].species = mix_species(v, "Mg(OH)2(s)", NULL, 0.0);
    of[1].species = mix_species(v, "CaCO3(s)", NULL, 0.0);
    of[2].species = mix_species(v, "Ca5(PO4)3OH(s)", NULL, 0.0);
    mix_reaction(v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", 16.84, 0.0, NULL);
    mix_reaction(v, "Ca2+ + CO3-2 = CaCO3(s)", 8.48, 0.0, NULL);
    mix_reaction(v, "Ca5(PO4)3OH(s) + 4 H+ = H2O + 3 HPO4-2 + 5 Ca2+", -3.421, 0.0, NULL);
}

static int build(mixture *v, pd_activity activity, const pd_mineral *of, int count)
{
    pd_reaction rest[PD_REACTION_MAX];
    int kept = pdi_mineral_copy_solid_free_reactions(v->s, v->species, v->r, v->reactions, rest);
    return CHECK_OK(&v->ctx, pdi_components_build(&v->ctx, v->s, v->species, rest, kept, activity, 298.15,
                                                  &test_system)) &&
           CHECK_OK(&v->ctx, pdi_mineral_build(&v->ctx, &test_system, v->s, v->species, v->r, v->reactions, of, count,
                                               &test_minerals));
}

/* Any mixture with minerals in equilibrium. Those of speciation are the same, and totals are kept. */
static void any(pd_activity activity)
{
    mixture v;
    pd_mineral of[3];
    pd_speciation system;
    pd_speciation_result result;
    uint32_t random = 11;
    int solved = 0, formed[3] = {0, 0, 0};
    body(&v, of);
    if (!build(&v, activity, of, 3)) return;
    CHECK_OK(&v.ctx, pd_speciation_build(&v.ctx, v.s, v.species, v.r, v.reactions, activity, 298.15, &system));
    for (int k = 0; k < 200; k++) {
        double all[PD_SPECIES_MAX], c[PD_SPECIES_MAX], total[PD_SPECIES_MAX], again[PD_SPECIES_MAX], n[3];
        pd_mineral_start start;
        for (int i = 0; i < v.species; i++) all[i] = 30.0 * pow(10.0, -6.0 * random_share(&random));
        all[0] = 55344.0;
        for (int i = 0; i < v.species; i++)
            if (test_system.solute_of_species[i] >= 0) c[test_system.solute_of_species[i]] = all[i];
        for (int s = 0; s < 3; s++) n[s] = all[of[s].species] = k % 3 ? all[of[s].species] : 0.0;
        double before[3] = {n[0], n[1], n[2]};
        start.dt = 1.0;
        start.start_amount = before;
        pdi_mineral_begin_step(&test_system, &test_minerals, n, c, &start);
        pdi_components_compute_totals(&test_system, c, total);
        if (!CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, n), PD_OK)) continue;
        pdi_components_compute_totals(&test_system, c, again);
        for (int m = 0; m < test_system.count; m++) {
            double size = fabs(total[m]);
            for (int i = 0; i < test_system.solutes; i++) size += fabs(test_system.stoichiometry[m][i]) * c[i];
            for (int s = 0; s < 3; s++) {
                again[m] += test_minerals.total_content[s][m] * (n[s] - before[s]);
                size += fabs(test_minerals.total_content[s][m]) * (n[s] + before[s]);
            }
            CHECK_NEAR(again[m], total[m], 1e-13 * size);
        }
        if (pd_speciation_solve(&system, all, &result) != PD_OK) continue;
        solved++;
        for (int s = 0; s < 3; s++) {
            formed[s] += n[s] > 0.0;
            CHECK_NEAR(n[s], all[of[s].species], 1e-7);
            double index = pdi_mineral_compute_ln_omega(&test_system, &test_minerals, s, c);
            CHECK_LE(index, n[s] > 0.0 ? 1e-4 : 1e-9); /* rounding of what is used up */
            if (n[s] > 0.0) CHECK_LE(-index, 1e-4);
        }
        for (int i = 1; i < v.species; i++)
            if (test_system.solute_of_species[i] >= 0 && all[i] > 1e-9)
                CHECK_REL(c[test_system.solute_of_species[i]], all[i], 1e-5);
    }
    NOTE("%.0f solved, brucite in %.0f", (double)solved, (double)formed[0]);
    NOTE("calcite in %.0f, hydroxyapatite in %.0f", (double)formed[1], (double)formed[2]);
    CHECK_LE(150, solved);
    for (int s = 0; s < 3; s++) CHECK(formed[s] > 20 && formed[s] < solved);
}

TEST(any_ideal) { any(PD_ACTIVITY_IDEAL); }
TEST(any_davies) { any(PD_ACTIVITY_DAVIES); }

/* A + B = AB(s) with a speed: backward Euler of n' = k (a b/K - 1) is a quadratic. */
TEST(laws)
{
    mixture v;
    pd_mineral of;
    static const double rates[3] = {1e-6, 1e-2, 1e6};
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "NaK(s)", NULL, 0.0);
    mix_reaction(&v, "NaK(s) = Aa + Bb", -6.0, 0.0, NULL); /* K of 1 mol2/m6 */
    for (int k = 0; k < 12; k++) {
        double c[2] = {k % 2 ? 3.0 : 0.1, k % 2 ? 2.0 : 0.2}, n = k % 4 < 2 ? 0.0 : 0.7, first = n, dt = 10.0, q;
        double a = c[0], b = c[1];
        pd_mineral_start start;
        of.rate = rates[k / 4];
        if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
        start.dt = dt;
        start.start_amount = &first;
        pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
        CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, c, c, &n), PD_OK);
        q = dt * of.rate; /* x = q ((a - x)(b - x) - 1), x the change */
        double p = a + b + 1.0 / q, root = 2.0 * (a * b - 1.0) / (p + sqrt(p * p - 4.0 * (a * b - 1.0)));
        CHECK_NEAR(n, fmax(first + root, 0.0), 1e-12);
        CHECK_NEAR(c[0] + n, a + first, 1e-14);
    }
}

/* No more than the room allows; nothing below the saturation of nucleation, and growth of what is there. */
TEST(limits)
{
    mixture v;
    pd_mineral of;
    pd_mineral_start start;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "NaK(s)", NULL, 0.0);
    of.volume = 1e-3;
    of.min_porosity = 0.25;
    of.nucleation = 1.0;
    mix_reaction(&v, "NaK(s) = Aa + Bb", -6.0, 0.0, NULL);
    if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
    for (int k = 0; k < 3; k++) {
        double c[2] = {k ? 1e4 : 3.0, k ? 1e4 : 3.0}, total[2] = {c[0], c[1]}, n = k == 2 ? 740.0 : 0.0, none = n;
        start.dt = 1.0;
        start.start_amount = &none;
        pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
        CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, &n), PD_OK);
        CHECK_NEAR(n, k ? 750.0 : 0.0, 1e-9);
        CHECK_NEAR(c[0], total[0] + none - n, 1e-9);
    }
    double n = 1e-3, c[2] = {3.0, 3.0}, total[2] = {3.0, 3.0}, first = n;
    start.start_amount = &first;
    pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
    CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, &n), PD_OK);
    CHECK_NEAR(n, 2.001, 1e-12);
}

/* Four solutes in pairs and the minerals of both pairs in `order`, with speeds in the ratio of 3 to 1. */
static int pairs(mixture *v, pd_mineral *of, const int *order, const double *porosity)
{
    int solid[2];
    mix_begin(v);
    mix_species(v, "Aa", "Na", 1e-9);
    mix_species(v, "Bb", "K", 1e-9);
    mix_species(v, "Cc", "Ca", 1e-9);
    mix_species(v, "Dd", "Mg", 1e-9);
    solid[0] = mix_species(v, "NaK(s)", NULL, 0.0);
    solid[1] = mix_species(v, "CaMg(s)", NULL, 0.0);
    mix_reaction(v, "NaK(s) = Aa + Bb", -6.0, 0.0, NULL); /* K of 1 mol2/m6 */
    mix_reaction(v, "CaMg(s) = Cc + Dd", -6.0, 0.0, NULL);
    memset(of, 0, 2 * sizeof *of);
    for (int s = 0; s < 2; s++) {
        int which = order[s];
        of[s].species = solid[which];
        of[s].rate = which ? 1e-6 : 3e-6;
        of[s].volume = which ? 2e-4 : 1e-4;
        of[s].min_porosity = porosity[which];
    }
    return build(v, PD_ACTIVITY_IDEAL, of, 2);
}

/* One step of `dt` [s] of both pairs; amounts in the order of the pairs. */
static void pairs_step(const int *order, const double *porosity, double pair_a, double pair_b, const double *first,
                       double dt, double *amount)
{
    mixture v;
    pd_mineral of[2];
    pd_mineral_start start;
    static const char *const name[4] = {"Aa", "Bb", "Cc", "Dd"};
    double c[PD_SPECIES_MAX] = {0.0}, total[PD_SPECIES_MAX], n[2], before[2];
    if (!pairs(&v, of, order, porosity)) return;
    for (int i = 0; i < 4; i++) c[test_system.solute_of_species[mix_at(&v, name[i])]] = i < 2 ? pair_a : pair_b;
    for (int s = 0; s < 2; s++) before[s] = n[s] = first[order[s]];
    start.dt = dt;
    start.start_amount = before;
    pdi_mineral_begin_step(&test_system, &test_minerals, n, c, &start);
    pdi_components_compute_totals(&test_system, c, total);
    CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, n), PD_OK);
    for (int i = 0; i < 4; i++) {
        int pair = i / 2, s = order[0] == pair ? 0 : 1;
        double had = (pair ? pair_b : pair_a) + before[s];
        CHECK_NEAR(c[test_system.solute_of_species[mix_at(&v, name[i])]] + n[s], had, 1e-12 * had);
    }
    for (int s = 0; s < 2; s++) amount[order[s]] = n[s];
}

static const int orders[2][2] = {{0, 1}, {1, 0}};

/* Two minerals that fill a volume together, in steps of any length and in both orders. Speeds that hardly change give
 * the share of each in closed form: what both grow by, 1e-4 3 g + 2e-4 g, is the room. */
TEST(two_fill_a_room)
{
    static const double porosity[2] = {0.25, 0.25}, none[2] = {0.0, 0.0}, some[2] = {500.0, 1000.0};
    for (int k = 0; k < 2; k++) {
        const double *first = k ? some : none;
        double room = 0.75 - 1e-4 * first[0] - 2e-4 * first[1], unit = room / 5e-4, amount[2];
        for (int o = 0; o < 2; o++) {
            /* c = 1e9 mol/m3: of 1e18 in the speed 1e-5 change */
            pairs_step(orders[o], porosity, 1e9, 1e9, first, 4e-9, amount);
            CHECK_REL(amount[0], first[0] + 3.0 * unit, 1e-4);
            CHECK_REL(amount[1], first[1] + unit, 1e-4);
            CHECK_NEAR(1e-4 * amount[0] + 2e-4 * amount[1], 0.75, 1e-11);
        }
        /* any step: no more than the room, and the order of the names says nothing */
        for (double dt = 1e-14; dt < 1e20; dt *= 1e3) {
            double other[2];
            pairs_step(orders[0], porosity, 2e4, 1e4, first, dt, amount);
            pairs_step(orders[1], porosity, 2e4, 1e4, first, dt, other);
            CHECK_LE(1e-4 * amount[0] + 2e-4 * amount[1], 0.75 * (1.0 + 1e-14));
            for (int s = 0; s < 2; s++) CHECK_NEAR(amount[s], other[s], 1e-7 * (1.0 + amount[s]));
            for (int s = 0; s < 2; s++) CHECK(amount[s] >= first[s]);
        }
    }
}

/* The mineral whose cells are tighter goes on where the other one has no room; one takes what another sets free. What
 * is there before the step stays, even where it is too much. */
TEST(unlike_rooms)
{
    static const double porosity[2] = {0.5, 0.25}, same[2] = {0.25, 0.25}, none[2] = {0.0, 0.0};
    static const double other[2] = {0.0, 3750.0}, much[2] = {6000.0, 2000.0};
    for (int o = 0; o < 2; o++) {
        double amount[2];
        pairs_step(orders[o], porosity, 1e9, 1e9, none, 4e-9, amount);
        CHECK_REL(amount[0], 3000.0, 1e-4); /* 0.3 + 0.2 are the first room */
        CHECK_NEAR(1e-4 * amount[0] + 2e-4 * amount[1], 0.75, 1e-11);
        /* CaMg(s) dissolves by what backward Euler says, x = q ((x + b) (x + b) - 1) with b = 0.1, q = 1e-6 1e9 */
        pairs_step(orders[o], same, 1e9, 0.1, other, 1e9, amount);
        double q = 1e3, p = 0.2 + 1.0 / q, x = 2.0 * 0.99 / (p + sqrt(p * p + 4.0 * 0.99));
        CHECK_NEAR(amount[1], 3750.0 - x, 1e-8);
        CHECK_NEAR(1e-4 * amount[0], 2e-4 * x, 1e-9);
        pairs_step(orders[o], same, 1e9, 1e9, much, 1.0, amount);
        CHECK_NEAR(amount[0], much[0], 0.0);
        CHECK_NEAR(amount[1], much[1], 0.0);
    }
}

/* Body fluid and amounts at random, speeds or equilibrium, steps of any length: three minerals that share ions never
 * grow beyond their room, and any order of them gives the same. */
TEST(any_order_of_three)
{
    static const int permuted[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    uint32_t random = 5;
    int full = 0, solved = 0;
    for (int k = 0; k < 60; k++) {
        double reference[3] = {0.0}, value[PD_SPECIES_MAX], amount[3], rate[3], dt, volume;
        int lost = 0;
        volume = pow(10.0, -3.5 + 1.5 * random_share(&random));
        for (int i = 0; i < PD_SPECIES_MAX; i++) value[i] = 3e3 * pow(10.0, -2.0 * random_share(&random));
        for (int s = 0; s < 3; s++) {
            amount[s] = k % 3 == s ? 0.0 : 0.3 * random_share(&random) / volume;
            rate[s] = k % 4 == 3 ? 0.0 : pow(10.0, -6.0 + 8.0 * random_share(&random));
        }
        dt = pow(10.0, -6.0 + 18.0 * random_share(&random));
        for (int o = 0; o < 6; o++) {
            mixture v;
            pd_mineral of[3], in_order[3];
            double c[PD_SPECIES_MAX], total[PD_SPECIES_MAX], n[3], first[3], found[3], filled = 0.0, had = 0.0;
            pd_mineral_start start;
            body(&v, of);
            for (int s = 0; s < 3; s++) {
                in_order[s] = of[permuted[o][s]];
                in_order[s].rate = rate[permuted[o][s]];
                in_order[s].volume = volume * (1 + permuted[o][s]);
                in_order[s].min_porosity = 0.1;
                first[s] = n[s] = amount[permuted[o][s]] / (1 + permuted[o][s]);
            }
            if (!build(&v, PD_ACTIVITY_IDEAL, in_order, 3)) return;
            for (int i = 0; i < v.species; i++)
                if (test_system.solute_of_species[i] >= 0) c[test_system.solute_of_species[i]] = value[i];
            pdi_components_compute_totals(&test_system, c, total);
            if (pdi_components_solve(&test_system, total, c) != PD_OK) continue;
            start.dt = dt;
            start.start_amount = first;
            pdi_mineral_begin_step(&test_system, &test_minerals, n, c, &start);
            lost |= pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, n) != PD_OK;
            if (lost) break; /* the step is to be taken in parts */
            for (int s = 0; s < 3; s++) {
                found[permuted[o][s]] = n[s];
                filled += n[s] * in_order[s].volume;
                had += first[s] * in_order[s].volume;
            }
            CHECK_LE(filled, 0.9 * (1.0 + 1e-13));
            CHECK_LE(had, 0.9);
            full += filled > 0.9 * (1.0 - 1e-9);
            solved++;
            for (int s = 0; s < 3; s++)
                if (!o)
                    reference[s] = found[s];
                else
                    CHECK_NEAR(found[s], reference[s], 1e-7 / volume);
        }
    }
    NOTE("%d of %d full", full, solved);
    CHECK_LE(340, solved);
    CHECK(full > 30 && full < solved - 30);
}

/* A stage of a step may count from more than has room, and begin there: what it finds has room, and nothing is lost. */
TEST(stage_beyond)
{
    mixture v;
    pd_mineral of[2];
    pd_mineral_start start;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    mix_species(&v, "Cc", "Li", 1e-9);
    memset(of, 0, sizeof of);
    of[0].species = mix_species(&v, "NaK(s)", NULL, 0.0);
    of[1].species = mix_species(&v, "NaLi(s)", NULL, 0.0);
    of[0].volume = 1e-3;
    of[1].volume = 2e-3;
    of[0].min_porosity = of[1].min_porosity = 0.25;
    mix_reaction(&v, "NaK(s) = Aa + Bb", -6.0, 0.0, NULL);
    mix_reaction(&v, "NaLi(s) = Aa + Cc", -5.0, 0.0, NULL);
    for (int k = 0; k < 3; k++) {
        double c[3] = {900.0, 900.0, 900.0}, total[3] = {900.0, 900.0, 900.0}, before[2] = {100.0, 150.0};
        double n[2] = {300.0, 500.0}, from[2] = {300.0, 500.0};
        of[0].rate = k ? 3.0 : 0.0;
        of[1].rate = k == 2 ? 5.0 : 0.0;
        if (!build(&v, PD_ACTIVITY_IDEAL, of, 2)) return;
        start.dt = 10.0;
        start.start_amount = from;
        pdi_mineral_begin_step(&test_system, &test_minerals, before, c, &start);
        CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, n), PD_OK);
        CHECK_NEAR(pdi_mineral_compute_volume_fraction(&test_minerals, n), 0.75, 1e-9);
        CHECK(n[0] >= 100.0 && n[1] >= 150.0);
        CHECK_NEAR(c[0] + n[0] + n[1], 900.0 + from[0] + from[1], 1e-9);
        CHECK_NEAR(c[1] + n[0], 900.0 + from[0], 1e-9);
        CHECK_NEAR(c[2] + n[1], 900.0 + from[1], 1e-9);
    }
}

/* Brucite that grows gives two H+ each. A lack of H+ is made good by growth alone: by as much as there is room for, and
 * what is beyond its room takes H+. */
TEST(full_lacks_acid)
{
    mixture v;
    pd_mineral of;
    pd_mineral_start start;
    mix_begin(&v);
    mix_species(&v, "H2O", NULL, 0.0);
    int acid = mix_species(&v, "H+", NULL, 0.0);
    mix_species(&v, "Mg2+", NULL, 0.0);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "Mg(OH)2(s)", NULL, 0.0);
    of.volume = 1e-3;
    of.min_porosity = 0.25;
    mix_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", 16.84, 0.0, NULL);
    if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
    for (int k = 0; k < 4; k++) {
        double c[2] = {100.0, 100.0}, total[2] = {100.0, 100.0}, before = k < 2 ? 740.0 : 760.0, from = before;
        if (k == 1) from = 751.0; /* beyond the room of 750 */
        total[test_system.solute_of_species[acid]] = k ? -1.0 : -19.0;
        if (k == 1) total[test_system.solute_of_species[acid]] = 1.0;
        start.dt = 1.0;
        start.start_amount = &from;
        pdi_mineral_begin_step(&test_system, &test_minerals, &before, c, &start);
        if (k == 3) total[test_system.solute_of_species[acid]] = 0.0;
        CHECK_INT(pdi_mineral_is_infeasible(&test_system, &test_minerals, &start, total), k == 1 || k == 2);
    }
}

/* Derivatives of amounts with totals against differences, of kinetic minerals and of those in equilibrium. */
static void derive(double surface)
{
    mixture v;
    pd_mineral of[3];
    body(&v, of);
    of[1].rate = 1e-3;
    of[2].surface_rate = surface;
    if (!build(&v, PD_ACTIVITY_DAVIES, of, 3)) return;
    double c[PD_SPECIES_MAX] = {0.0}, n[3] = {1.0, 2.0, 1.5}, first[3] = {1.0, 2.0, 1.5}, total[PD_SPECIES_MAX];
    double by[3 * PD_SPECIES_MAX];
    pd_mineral_start start;
    start.dt = 10.0;
    start.start_amount = first;
    for (int i = 1; i < test_system.solutes; i++) c[i] = 0.3 + 0.1 * i;
    c[test_system.solute_of_species[mix_at(&v, "OH-")]] = 30.0;
    pdi_components_compute_totals(&test_system, c, total);
    CHECK_INT(pdi_components_solve(&test_system, total, c), PD_OK);
    pdi_mineral_begin_step(&test_system, &test_minerals, n, c, &start);
    CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, n), PD_OK);
    for (int s = 0; s < 3; s++) CHECK(n[s] > 0.0);
    pdi_components_compute_totals(&test_system, c, total);
    pdi_mineral_step_compute_derivatives(&test_system, &test_minerals, &start, c, n, by);
    for (int k = 0; k < test_system.count; k++) {
        double ends[2][3], step = 1e-5;
        for (int side = 0; side < 2; side++) {
            double moved[PD_SPECIES_MAX], at[PD_SPECIES_MAX];
            memcpy(moved, total, sizeof moved);
            memcpy(at, c, sizeof at);
            memcpy(ends[side], n, sizeof n);
            moved[k] += side ? step : -step;
            CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, moved, at, ends[side]), PD_OK);
        }
        for (int s = 0; s < 3; s++)
            CHECK_NEAR(by[s * test_system.count + k], (ends[1][s] - ends[0][s]) / (2.0 * step), 1e-5);
    }
}

TEST(derivatives) { derive(0.0); }
TEST(derivatives_of_spreading) { derive(1e-2); }

/* A mineral whose surface grows with its amount has that of the end of the step, and one that dissolves is never gone
 * without a surface of its own. A stage that would begin with less than nothing goes on from the one before. */
TEST(spreading)
{
    mixture v;
    pd_mineral of;
    mix_begin(&v);
    mix_species(&v, "Aa", "Na", 1e-9);
    mix_species(&v, "Bb", "K", 1e-9);
    memset(&of, 0, sizeof of);
    of.species = mix_species(&v, "NaK(s)", NULL, 0.0);
    of.surface_rate = 0.3;
    mix_reaction(&v, "NaK(s) = Aa + Bb", -6.0, 0.0, NULL); /* K of 1 mol2/m6 */
    for (int k = 0; k < 16; k++) {
        static const double steps[4] = {1e-3, 1.0, 1e3, 1e9};
        double c[2] = {k % 2 ? 3.0 : 0.1, k % 2 ? 2.0 : 0.2}, n = 1e-3, first = n, a = c[0], dt = steps[k / 4];
        pd_mineral_start start;
        of.rate = k % 4 < 2 ? 0.0 : 1e-4;
        if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
        start.dt = dt;
        start.start_amount = &first;
        pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
        CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, c, c, &n), PD_OK);
        double speed = (of.rate + of.surface_rate * n) * (c[0] * c[1] - 1.0);
        CHECK(of.rate > 0.0 || n > 0.0);
        if (n > 0.0 && dt < 1e6) CHECK_NEAR(n - first, dt * speed, 1e-11 * dt);
        if (n > 0.0 && dt > 1e6) CHECK_NEAR(k % 2 ? c[0] * c[1] : n, k % 2 ? 1.0 : 0.0, 1e-8);
        CHECK_NEAR(c[0] + n, a + first, 1e-14);
    }
    pd_mineral_start start;
    double n = 1e-3, c[2] = {0.1, 0.2}, amount = -2e-3;
    of.rate = 0.0;
    if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
    pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
    CHECK_INT(pdi_mineral_try_resume(&start, 0, 4e-4, 2.5, &amount), 1);
    CHECK_NEAR(amount, 4e-4, 1e-18);
    CHECK_NEAR(start.amount_rate[0], 0.75, 1e-15);
    CHECK_INT(pdi_mineral_try_resume(&start, 0, 4e-4, 2.5, &amount), 0);
}

/* A volume that has just become fluid: water is no equilibrium, so that it holds no H+, and the acid that brucite lacks
 * makes none of it where there is no Mg2+. */
TEST(empty_volume)
{
    mixture v;
    pd_mineral of;
    double c[PD_SPECIES_MAX] = {0.0}, total[PD_SPECIES_MAX], n = 0.0, before = 0.0;
    pd_mineral_start start;
    memset(&v, 0, sizeof v);
    memset(&of, 0, sizeof of);
    pd_ctx_init(&v.ctx);
    mix_species(&v, "H2O", NULL, 55344.0);
    mix_species(&v, "H+", NULL, 0.0);
    int hydroxide = mix_species(&v, "OH-", NULL, 0.0), metal = mix_species(&v, "Mg2+", NULL, 0.0);
    of.species = mix_species(&v, "Mg(OH)2(s)", NULL, 0.0);
    mix_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", 16.84, 0.0, NULL);
    if (!build(&v, PD_ACTIVITY_IDEAL, &of, 1)) return;
    c[test_system.solute_of_species[hydroxide]] = c[test_system.solute_of_species[metal]] = 1e-200;
    start.dt = 1.0;
    start.start_amount = &before;
    pdi_mineral_begin_step(&test_system, &test_minerals, &n, c, &start);
    pdi_components_compute_totals(&test_system, c, total);
    CHECK_INT(pdi_mineral_step_solve(&test_system, &test_minerals, &start, total, c, &n), PD_OK);
    CHECK_NEAR(n, 0.0, 1e-200);
}

/* The minerals are refused, and nothing of them is left. */
static void refuse_minerals(mixture *v, const pd_mineral *of)
{
    pd_minerals none;
    memset(&none, 0, sizeof none);
    CHECK_INT(pdi_mineral_build(&v->ctx, &test_system, v->s, v->species, v->r, v->reactions, of, 3, &test_minerals),
              PD_ERR_ARGUMENT);
    CHECK(memcmp(&test_minerals, &none, sizeof none) == 0);
}

TEST(refusals)
{
    mixture v;
    pd_mineral of[3];
    body(&v, of);
    if (!build(&v, PD_ACTIVITY_IDEAL, of, 3)) return;
    pd_reaction calcite = v.r[8];
    of[0].rate = -1.0;
    refuse_minerals(&v, of);
    CHECK(strstr(v.ctx.message, "rate -1") != NULL);
    of[0].rate = 0.0;
    of[1].species = of[0].species;
    refuse_minerals(&v, of);
    CHECK(strstr(v.ctx.message, "twice") != NULL);
    of[1].species = mix_at(&v, "CaCO3(s)");
    v.r[8].has_k = 0;
    refuse_minerals(&v, of);
    CHECK(strstr(v.ctx.message, "without K") != NULL);
    v.r[8] = v.r[0];
    refuse_minerals(&v, of);
    CHECK(strstr(v.ctx.message, "no reaction") != NULL);
    v.r[8] = calcite;
    of[1].species = mix_at(&v, "Ca2+");
    refuse_minerals(&v, of);
    CHECK(strstr(v.ctx.message, "no solid") != NULL);
}

TEST_MAIN(ENTRY(any_ideal) ENTRY(any_davies) ENTRY(laws) ENTRY(limits) ENTRY(stage_beyond) ENTRY(full_lacks_acid)
          ENTRY(empty_volume) ENTRY(two_fill_a_room) ENTRY(unlike_rooms) ENTRY(any_order_of_three) ENTRY(derivatives)
          ENTRY(derivatives_of_spreading) ENTRY(spreading)
          ENTRY(refusals))
