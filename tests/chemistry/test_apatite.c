/* apatite: hydroxyapatite that forms in simulated body fluid beyond a saturation of nucleation, with the steps of a run
 * until nothing changes: against the equilibrium of the closed volume, which is solved in another way, and against sums
 * and the ion product by hand.
 * dims: 1 */
#include "react/course.h"
#include "scene/read_electrolyte.h"
#include "test.h"
#include "cases/vessel.h"

#define END 1e7 /* [s] */

static pd_electrolyte fluid;
static vessel bath;
static int apatite; /* species */

/* SBF of the examples with hydroxyapatite alone, and without other solids. */
static int read_fluid(pd_ctx *ctx, pd_activity activity)
{
    int stays[PD_SPECIES_MAX] = {0};
    if (!CHECK_OK(ctx, pd_electrolyte_read(ctx, "examples/electrolytes/sbf.electrolyte", NULL, 0, &fluid))) return 0;
    stays[pd_electrolyte_find_species(&fluid, "Ca5(PO4)3OH(s)")] = 1;
    pd_electrolyte_remove_undissolved(&fluid, stays);
    fluid.activity = activity;
    apatite = pd_electrolyte_find_species(&fluid, "Ca5(PO4)3OH(s)");
    for (int i = 0; i < fluid.count; i++)
        if (!(fluid.species[i].diffusivity > 0.0)) fluid.species[i].diffusivity = 0.7e-9; /* Tris and its ion */
    return CHECK(apatite >= 0);
}

static void fill(pd_ctx *ctx, int n, const pd_mineral *of)
{
    vessel *v = &bath;
    vessel_begin(ctx, v, n, 2e-5, 1.0);
    memcpy(v->species, fluid.species, sizeof fluid.species);
    memcpy(v->reaction, fluid.reaction, sizeof fluid.reaction);
    memcpy(v->initial, fluid.initial, sizeof fluid.initial);
    v->count = fluid.count;
    v->reactions = fluid.reactions;
    v->mineral[v->minerals] = *of;
    v->mineral[v->minerals++].species = apatite;
    v->desc.activity = fluid.activity;
    v->desc.order = 2;
    vessel_fill(v);
}

/* A grain [mol/m3] in the first cell. */
static void grain(void *user, double x, double *c) { c[apatite] = x < 2e-5 ? *(const double *)user : 0.0; }

static double concentration(const char *name, int cell)
{
    return vessel_field(&bath, pd_electrolyte_find_species(&fluid, name))[vessel_node(&bath, cell)];
}

/* Mean over cells of what an element has in solutes [mol/m3], with what the solvers leave undone; *solid: of units of
 * the solid. */
static double element(int z, double *solid)
{
    const pd_components *s = &bath.reactive.components;
    double sum = 0.0;
    *solid = 0.0;
    for (int k = 0; k < bath.n; k++) {
        int32_t node = vessel_node(&bath, k);
        for (int i = 0; i < fluid.count; i++) {
            const double *c = vessel_field(&bath, i);
            if (!c) continue;
            if (i == apatite) *solid += c[node] / bath.n;
            else sum += pdi_species_count_atoms(&fluid.species[i], z) * c[node] / bath.n;
            for (int e = 0; e < s->count; e++)
                if (s->solute_of_species[i] == s->component_solute[e])
                    sum += pdi_species_count_atoms(&fluid.species[i], z) *
                           bath.reactive.carry[e * (int64_t)bath.grid.total + node] / bath.n;
        }
    }
    return sum;
}

/* By hand: log10 of the activity of an ion at 25 C, with the permittivity 78.303 of water. */
static double activity(const char *name, double z, double strength)
{
    double i = strength / 1e3, root = sqrt(i), a = 1.82e6 * pow(78.303 * 298.15, -1.5);
    double gamma = fluid.activity == PD_ACTIVITY_DAVIES ? -a * z * z * (root / (1.0 + root) - 0.3 * i) : 0.0;
    return log10(concentration(name, 0) / 1e3) + gamma;
}

/* Sums that are kept, and the ion product of Ca5(PO4)3OH + 4 H+ = H2O + 3 HPO4-2 + 5 Ca2+ in the first cell. */
static void check_by_hand(double grains)
{
    static const int kept[] = {6, 11, 12, 16, 17, 19}; /* C, Na, Mg, S, Cl, K */
    double solid, calcium = element(20, &solid), phosphorus = element(15, &solid), charge = 0.0, strength = 0.0;
    double start[2] = {0.0, 0.0};
    for (int i = 0; i < fluid.count; i++) {
        start[0] += pdi_species_count_atoms(&fluid.species[i], 20) * fluid.initial[i];
        start[1] += pdi_species_count_atoms(&fluid.species[i], 15) * fluid.initial[i];
    }
    CHECK_REL(calcium + 5.0 * (solid - grains), start[0], 1e-12);
    CHECK_REL(phosphorus + 3.0 * (solid - grains), start[1], 1e-12);
    for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
        double sum = 0.0;
        for (int i = 0; i < fluid.count; i++)
            sum += pdi_species_count_atoms(&fluid.species[i], kept[k]) * fluid.initial[i];
        CHECK_REL(element(kept[k], &solid), sum, 1e-12);
    }
    for (int i = 0; i < fluid.count; i++) {
        const double *c = vessel_field(&bath, i);
        if (!c || i == apatite) continue;
        charge += fluid.species[i].charge * c[vessel_node(&bath, 0)];
        strength += 0.5 * fluid.species[i].charge * fluid.species[i].charge * c[vessel_node(&bath, 0)];
    }
    CHECK_NEAR(charge, 0.0, 1e-9 * strength);
    double product = 5.0 * activity("Ca2+", 2.0, strength) + 3.0 * activity("HPO4-2", 2.0, strength) -
                     4.0 * activity("H+", 1.0, strength);
    CHECK_NEAR(product, -3.421, 1e-4);
}

/* A bath whose mineral forms beyond `nucleation`, with grains [mol/m3] in the first of n cells, until it is at rest. */
static void settle(pd_activity davies, int n, double grains, double nucleation, double rate, double surface)
{
    pd_ctx ctx;
    pd_mineral of;
    pd_course course;
    pd_course_desc desc;
    pd_electrolyte_state state;
    double c[PD_SPECIES_MAX], n_solid;
    pd_ctx_init(&ctx);
    memset(&of, 0, sizeof of);
    memset(&desc, 0, sizeof desc);
    if (!read_fluid(&ctx, davies)) return;
    of.nucleation = nucleation;
    of.rate = rate;
    of.surface_rate = surface;
    fill(&ctx, n, &of);
    vessel_pour(&bath, grain, &grains);
    if (!CHECK_OK(&ctx, bath.status)) return;
    double before = pd_reactive_saturation(&bath.reactive, 0, vessel_node(&bath, n / 2));
    if (CHECK_OK(&ctx, pd_course_build(&ctx, &bath.reactive, &desc, &course)))
        CHECK_OK(&ctx, pd_physics_run(&ctx, pd_course_process(&course), END));
    NOTE("index %.2f at the start; %.0f steps, %.0f by Euler", before, (double)course.steps, (double)course.euler);
    NOTE("%.0f again, %.0f of Newton, %.0f of GMRES", (double)course.rejected, (double)course.newton,
         (double)course.krylov);
    pd_course_free(&ctx, &course);
    CHECK_LE(0.0, vessel_least(&bath));
    CHECK_LE(vessel_imbalance(&bath), 1e-12);
    check_by_hand(grains / n);
    memcpy(c, fluid.initial, sizeof c);
    c[apatite] = grains / n;
    fluid.all_minerals_form = 1;
    if (CHECK_OK(&ctx, pd_electrolyte_solve(&ctx, &fluid, c, &state))) {
        element(20, &n_solid);
        CHECK_REL(n_solid, c[apatite], 1e-7);
        for (int i = 0; i < fluid.count; i++) {
            const double *at = vessel_field(&bath, i);
            if (!at || i == apatite) continue;
            for (int k = 0; k < n; k++) CHECK_REL(at[vessel_node(&bath, k)], c[i], 1e-5);
        }
    }
    CHECK_OK(&ctx, vessel_end(&bath));
}

/* Nothing is there at the start; it forms at once. */
TEST(all_at_once)
{
    settle(PD_ACTIVITY_IDEAL, 4, 0.0, 1.0, 0.0, 0.0);
    settle(PD_ACTIVITY_DAVIES, 4, 0.0, 1.0, 0.0, 0.0);
}

/* It forms nowhere but on a grain, to which the bath diffuses. */
TEST(on_a_grain)
{
    settle(PD_ACTIVITY_IDEAL, 20, 0.1, 30.0, 0.0, 0.0);
    settle(PD_ACTIVITY_DAVIES, 20, 0.1, 30.0, 0.0, 0.0);
}

/* It grows by a law that is far faster at the start than what dissolves. */
TEST(with_a_speed)
{
    settle(PD_ACTIVITY_DAVIES, 4, 0.0, 1.0, 1e-6, 0.0);
    settle(PD_ACTIVITY_DAVIES, 20, 0.1, 30.0, 1e-6, 1e-4);
}

TEST_MAIN(ENTRY(all_at_once) ENTRY(on_a_grain) ENTRY(with_a_speed))
