/* reclaim: the fluid gives back what comes with metal: how much at most, from where, and what balances say of it.
 * dims: 1 2 */
#include "react/reclaim.h"
#include "model_scene.h"

#if PD_DIM == 1
#define BOX "0 um .. 40 um"
#else
#define BOX "0 um .. 40 um, 0 um .. 10 um"
#endif

/* Magnesium of 2 to 10 mol/m3, chloride, which nothing gives back, and salt. */
static const char scene_text[] =
    "[grid] h = 5 um  threads = 1  box = " BOX "\n[chemistry] activity = ideal\n"
    "[species Mg2+] D = 0.7e-9 m2/s  initial = 2 mol/m3\n[species Cl-] D = 2e-9 m2/s  initial = 5 mol/m3\n"
    "[species Na+] D = 1.3e-9 m2/s  initial = 1 mol/m3\n[run] until = 1 s\n";

/* Solute of a name. */
static int solute(const char *name)
{
    const pd_electrolyte *e = &setup.electrolyte;
    for (int k = 0; k < e->count; k++)
        if (strcmp(e->species[k].name, name) == 0) return model.reactive.components.solute_of_species[k];
    return -1;
}

TEST(what_is_there_at_most)
{
    if (!open_model(scene_text, NULL, 0)) return;
    pd_reactive *r = &model.reactive;
    int mg = solute("Mg2+"), cl = solute("Cl-"), count = r->components.count;
    int64_t total = r->grid->total;
    double volume = r->bonds->stencil->volume, shed[PD_SPECIES_MAX] = {0.0}, gain[PD_SPECIES_MAX];
    double held = 0.0, in = r->in[mg];
    CHECK(mg >= 0 && cl >= 0);
    shed[mg] = 1.0;
    pdi_components_compute_totals(&r->components, shed, gain);
    for (int32_t i = 0; i < total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        r->c[mg * total + i] = 2.0 + i % 9;
        held += 0.5 * r->c[mg * total + i]; /* half of it at most */
    }
    /* a part of it, from every node in proportion */
    CHECK_REL(pdi_reclaim_take(r, shed, 0.25 * held), 0.25 * held, 1e-14);
    CHECK_REL(r->in[mg] - in, -0.25 * held * volume, 1e-12);
    CHECK_NEAR(r->in[cl], 0.0, 0.0);
    for (int32_t i = 0; i < total; i++)
        for (int k = 0; k < count && r->grid->kind[i] == PD_FLUID; k++)
            CHECK_NEAR(r->carry[k * total + i], -0.25 * 0.5 * r->c[mg * total + i] * gain[k], 1e-13);
    /* what is owed counts: half of 7/8 is left, and no more is given back than that */
    CHECK_REL(pdi_reclaim_take(r, shed, 10.0 * held), 0.875 * held, 1e-14);
    for (int32_t i = 0; i < total; i++)
        for (int k = 0; k < count && r->grid->kind[i] == PD_FLUID; k++)
            CHECK_NEAR(r->carry[k * total + i], -(0.125 + 0.4375) * r->c[mg * total + i] * gain[k], 1e-12);
    CHECK_REL(r->in[mg] - in, -1.125 * held * volume, 1e-12);
    /* nothing comes with this metal */
    memset(shed, 0, sizeof shed);
    CHECK_NEAR(pdi_reclaim_take(r, shed, held), 0.0, 0.0);
    close_model();
}

TEST_MAIN(ENTRY(what_is_there_at_most))
