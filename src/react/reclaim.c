/* reclaim: see reclaim.h */
#include "react/reclaim.h"
#include <math.h>
#include <string.h>

/* Share of what a node holds that it gives back at most. */
#define PDI_RECLAIM_SHARE 0.5

/* 1: each solute has at least 0 of component k, so that its total cannot be negative. */
static int pdi_reclaim_bounded(const pd_components *of, int k)
{
    for (int n = 0; n < of->solutes; n++)
        if (of->stoichiometry[k][n] < 0.0) return 0;
    return 1;
}

/* [mol/m3] of metal that a share of what node i holds would be, and that comes [components] would be; with each comes
 * gain [components] of totals. HUGE_VAL: nothing bounds it. */
static double pdi_reclaim_there(const pd_reactive *r, const double *gain, int32_t i, const double *comes)
{
    const pd_components *of = &r->components;
    double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX], most = HUGE_VAL;
    pd_reactive_get(r, r->c, i, c);
    pdi_components_compute_totals(of, c, sum);
    for (int k = 0; k < of->count; k++) {
        double there = PDI_RECLAIM_SHARE * (sum[k] + r->carry[(int64_t)k * r->grid->total + i]) + comes[k];
        if (gain[k] > 0.0 && pdi_reclaim_bounded(of, k)) most = pd_min(most, pd_max(there, 0.0) / gain[k]);
    }
    return most;
}

static double pdi_reclaim_held(const pd_reactive *r, const double *gain, int32_t i)
{
    const double nothing[PD_SPECIES_MAX] = {0.0};
    double most = pdi_reclaim_there(r, gain, i, nothing);
    return most < HUGE_VAL ? most : 0.0;
}

PDI_FN double pdi_reclaim_take(pd_reactive *r, const double *shed, double amount)
{
    const pd_components *of = &r->components;
    int64_t total = r->grid->total;
    double gain[PD_SPECIES_MAX], held = 0.0;
    pdi_compensated_sum sum = {0.0, 0.0};
    pdi_components_compute_totals(of, shed, gain);
    for (int32_t i = 0; i < (int32_t)total; i++)
        if (r->grid->kind[i] == PD_FLUID)
            pdi_compensated_sum_add(&sum, pdi_reclaim_held(r, gain, i) * pd_grid_circumference(r->grid, i));
    held = pdi_compensated_sum_total(&sum);
    if (!(held > 0.0)) return 0.0;
    double share = pd_min(amount / held, 1.0), taken = share < 1.0 ? amount : held;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        double of_node = share * pdi_reclaim_held(r, gain, i);
        for (int k = 0; k < of->count; k++) r->carry[k * total + i] -= of_node * gain[k];
    }
    for (int n = 0; n < of->solutes; n++) r->in[n] -= taken * r->bonds->stencil->volume * shed[n];
    return taken;
}

PDI_FN void pdi_reclaim_due(const pd_reactive *r, const double *shed, double dt, const double *owed, double *due)
{
    double gain[PD_SPECIES_MAX], whole[PD_SPECIES_MAX];
    memcpy(whole, shed, (size_t)r->components.solutes * sizeof *shed);
    if (r->surface) pdi_etch_whole(r->surface, whole);
    pdi_components_compute_totals(&r->components, whole, gain);
    for (int32_t i = 0; i < r->grid->total; i++) {
        double comes[PD_SPECIES_MAX] = {0.0};
        due[i] = owed[i];
        if (!(owed[i] < 0.0) || r->grid->kind[i] != PD_FLUID) continue;
        if (r->surface) pdi_etch_gain(r->surface, i, comes);
        for (int k = 0; k < r->components.count; k++) comes[k] = dt * pd_max(comes[k], 0.0);
        due[i] = pd_max(owed[i], -pdi_reclaim_there(r, gain, i, comes));
    }
}

#undef PDI_RECLAIM_SHARE
