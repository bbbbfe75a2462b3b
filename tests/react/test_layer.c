/* layer: how law and curve of metal at the surface of its film follow what is in the fluid, against differences of
 * what they give.
 * dims: 1 */
#include "react/layer.h"
#include "model_scene.h"

#define IRON(activity, sodium, chloride, migration) \
    "[grid] h = 5 um  threads = 1  box = 0 um .. 60 um\n[transport] D = 1e-9 m2/s\n" \
    "[shape iron] kind = solid  material = steel304  box = 0 um .. 20 um\n[chemistry] activity = " \
    activity migration "\n" \
    "[species Fe2+] D = 0.72e-9 m2/s  initial = 20 mol/m3\n" \
    "[species Na+] D = 1.33e-9 m2/s  initial = " sodium " mol/m3\n" \
    "[species Cl-] D = 2.03e-9 m2/s  initial = " chloride " mol/m3\n[species FeCl+] D = 1e-9 m2/s\n" \
    "[reaction pair] equation = Fe2+ + Cl- = FeCl+  log10_K = 0.5\n[species OH-] D = 5.27e-9 m2/s\n" \
    "[species H2] D = 4.5e-9 m2/s  initial = 1 mol/m3\n[species H2O]\n[run] until = 1 ms\n"
#define WATER "[species H+] D = 9.31e-9 m2/s\n[reaction water] equation = H2O = H+ + OH-  log10_K = -14\n"
#define ELECTRODE(law, curve) \
    "[potential]\n[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-\n" \
    "current = 1 A/m2*" law "*10^((E + 0.6 V)/(60 mV))\n" \
    "[electrode iron] shape = iron  curve = expression  reaction = 2 H2O + 2 e- = H2 + 2 OH-\n" \
    "i = -1 A/m2*" curve "*10^(-(E + 0.4 V)/(120 mV))\n"

#define CORROSION \
    "[dissolve] reaction = Fe + 2 H2O = Fe2+ + H2 + 2 OH-\n" \
    "rate = 1 um/s*[Cl-]/(500 mol/m3)/(1 + [FeCl+]/(5 mol/m3))*10^((7 - pH)/20)\n"
#define SALTS ELECTRODE("[Cl-]/(500 mol/m3)", "[Na+]/(500 mol/m3)/(1 + [H2]/(10 mol/m3))")
#define ACIDS ELECTRODE("10^((7 - pH)/20)", "[FeCl+]/(1 mol/m3)*10^((pH - 7)/50)")
/* Oxygen of which there is next to nothing. */
#define TRACE \
    "[species O2] D = 2e-9 m2/s  initial = 1e-5 mol/m3\n[dissolve] reaction = Fe + 2 H2O = Fe2+ + H2 + 2 OH-\n" \
    "rate = 1 um/s*[Cl-]/(500 mol/m3)*[O2]/(1e-5 mol/m3)\n"

/* Iron beside a complex of its ion: laws and curves that read species, pH and the potential, in ideal and in dilute
 * water, where coefficients of activity follow the ionic strength. */
static const char *const scenes[] = {
    IRON("ideal", "500", "540", "  migration = yes") SALTS,
    IRON("ideal", "500", "540", "  migration = yes") WATER ACIDS,
    IRON("ideal", "500", "540", "") WATER CORROSION,
    IRON("davies", "10", "50", "  migration = yes") SALTS,
    IRON("davies", "10", "50", "  migration = yes") WATER ACIDS,
    IRON("davies", "10", "50", "") WATER CORROSION,
    IRON("ideal", "500", "540", "") TRACE};

/* Half of a total of place 0: less of it can be taken away. */
static double half_of(int total)
{
    const pd_reactive *r = &model.reactive;
    double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
    for (int k = 0; k < r->components.solutes; k++)
        c[k] = r->c[k * r->grid->total + model.dissolution_laws.surface_solver.node[0]];
    pdi_components_compute_totals(&r->components, c, sum);
    return fabs(sum[total]) > 0.0 ? 0.5 * fabs(sum[total]) : 1e-2;
}

/* Speed and flow of place 0 beside a change of one total of its node, or of F phi/(R T) (total = -1). */
static void moved(int total, double change, double *speed, double *flow)
{
    pd_etch *s = &model.dissolution_laws.surface_solver;
    pd_reactive *r = &model.reactive;
    double held[PD_SPECIES_MAX], c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
    int32_t node = s->node[0];
    int64_t n = r->grid->total;
    for (int k = 0; k < r->components.solutes; k++) held[k] = c[k] = r->c[k * n + node];
    if (total < 0) r->migration.psi[node] += change;
    else {
        pdi_components_compute_totals(&r->components, c, sum);
        sum[total] += change;
        CHECK_OK(&ctx, pdi_components_solve(&r->components, sum, c));
        for (int k = 0; k < r->components.solutes; k++) r->c[k * n + node] = c[k];
    }
    pdi_layer_solve(&ctx, s, -1, 0);
    *speed = *pdi_etch_speed(s, 0);
    *flow = s->electrode ? s->flow[0] : 0.0;
    for (int k = 0; k < r->components.solutes; k++) r->c[k * n + node] = held[k];
    if (total < 0) r->migration.psi[node] -= change;
}

TEST(derivatives)
{
    for (int n = 0; n < (int)(sizeof scenes / sizeof scenes[0]); n++) {
        if (!open_model(scenes[n], NULL, 0)) return;
        pd_etch *s = &model.dissolution_laws.surface_solver;
        int count = model.reactive.components.count, migration = model.reactive.migration.on;
        double most[2] = {0.0, 0.0};
        if (run_to(1e-3)) {
            pdi_layer_solve(&ctx, s, -1, 0);
            pdi_layer_solve(&ctx, s, -1, 1);
            CHECK_INT(s->count, 1);
            for (int k = migration ? -1 : 0; k < count; k++) {
                double up[2], down[2], share = n == 6 ? 1e-3 : 1.0; /* the speed bends with oxygen */
                double stride = k < 0 ? 1e-4 : n % 3 == 0 ? fmin(share * half_of(k), 1e-2) : 1e-6;
                double by[2] = {k < 0 ? (double)s->drive[0] : (double)s->by[k], 0.0};
                if (s->electrode) by[1] = k < 0 ? (double)s->flow_drive[0] : (double)s->flow_by[k];
                moved(k, stride, &up[0], &up[1]);
                moved(k, -stride, &down[0], &down[1]);
                for (int j = 0; j < (s->electrode ? 2 : 1); j++) {
                    double found = (up[j] - down[j]) / (2.0 * stride);
                    most[j] = fmax(most[j], fabs(found));
                    CHECK_NEAR(by[j], found, 2e-5 * fabs(found) + 1e-7 * most[j]); /* rounding of the difference */
                }
            }
            CHECK(most[0] > 0.0 && (most[1] > 0.0 || !s->electrode));
        }
        close_model();
    }
}

TEST_MAIN(ENTRY(derivatives))
