/* positivity: see positivity.h */
#include "react/positivity.h"
#include "transport/bounds.h"
#include <math.h>

/* Where the most of each component is owed after a stage [s], and how much, over what there is of it. */
static void pdi_positivity_debts(const pd_reactive *r, double stage, double *owed, int32_t *worst)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double most[PD_SPECIES_MAX];
    for (int k = 0; k < s->count; k++) {
        most[k] = owed[k] = 0.0;
        worst[k] = -1;
        for (int32_t i = 0; i < (int32_t)total; i++) {
            double lacks = r->spent[k * total + i] ? -stage * r->weight[k] * r->work[k * total + i] : 0.0;
            most[k] = pd_max(most[k], fabs(r->total[k * total + i]));
            if (!(lacks > owed[k])) continue;
            owed[k] = lacks;
            worst[k] = i;
        }
    }
    pdi_reactive_trace(r, most);
    for (int k = 0; k < s->count; k++) owed[k] = owed[k] > PDI_POSITIVITY_NONE ? owed[k] / most[k] : 0.0;
}

PDI_FN int pdi_positivity_holds(const pd_reactive *r, double stage)
{
    double owed[PD_SPECIES_MAX];
    int32_t worst[PD_SPECIES_MAX];
    pdi_positivity_debts(r, stage, owed, worst);
    for (int k = 0; k < r->components.count; k++)
        if (owed[k] > PDI_POSITIVITY_SLACK) return 0;
    return 1;
}

/* [mol/m3/s] of component k that sources and metal take up at node i. */
static double pdi_positivity_sink(const pd_reactive *r, int k, int32_t i)
{
    double source[PD_SPECIES_MAX], gain[PD_SPECIES_MAX];
    pd_reactive_get(r, r->source, i, source);
    pdi_components_compute_totals(&r->components, source, gain);
    if (r->surface) pdi_etch_gain(r->surface, i, gain);
    return -gain[k];
}

PDI_FN int pdi_positivity_exceeded(pd_reactive *r, double dt)
{
    double owed[PD_SPECIES_MAX];
    int32_t worst[PD_SPECIES_MAX];
    pdi_positivity_debts(r, dt, owed, worst);
    r->short_of = 0;
    for (int k = 0; k < r->components.count && !r->short_of; k++) {
        if (!(owed[k] > PDI_POSITIVITY_SLACK)) continue;
        int64_t at = k * (int64_t)r->grid->total + worst[k];
        double lacks = -dt * r->weight[k] * r->work[at], before = pd_max(-r->carry[at], 0.0), now = lacks - before;
        double least = PDI_POSITIVITY_SLACK / owed[k] * lacks; /* what is next to nothing */
        if (before > least && !(now > least)) continue;     /* transport owed it before */
        if (!(dt * pdi_positivity_sink(r, k, worst[k]) > 0.5 * now)) continue;
        r->short_of = 1 + k;
        r->short_at = worst[k];
    }
    return r->short_of;
}

PDI_FN int pdi_positivity_bounded(const pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int ports = pdi_open_boundary_has_any(r->grid);
    for (int k = s->equilibrium_components; k < s->count && !r->migration.on; k++) {
        int n = s->component_solute[k], reacts = 0;
        pdi_bounds bounds = {HUGE_VAL, -HUGE_VAL};
        for (int e = 0; e < s->kinetics; e++) reacts = reacts || s->kinetic[e].nu[n] != 0.0;
        for (int e = 0; e < r->minerals.count; e++) reacts = reacts || r->minerals.nu[e][n] != 0.0;
        if (reacts) continue;
        pdi_bounds_take_all(r->grid, PD_FLUID, r->begin + n * total, &bounds);
        if (ports) pdi_bounds_take(r->inlet[n], &bounds);
        if (r->diffusion.wall_rate && r->wall[n] == r->wall[n]) pdi_bounds_take(r->wall[n], &bounds);
        pdi_etch_bounds(r, n, &bounds);
        pdi_bounds_widen(r->grid, r->c + n * total, PDI_POSITIVITY_SLACK, &bounds);
        bounds.low -= PDI_POSITIVITY_NONE;
        bounds.high += PDI_POSITIVITY_NONE;
        if (!pdi_bounds_keep(r->grid, r->c + n * total, NULL, &bounds)) return 0;
    }
    return 1;
}

PDI_FN int32_t pdi_positivity_fewest(const pd_etch *s, double *ions)
{
    int32_t least = s->node[0];
    *ions = HUGE_VAL;
    for (int32_t p = 0; p < s->count; p++) {
        double c[PD_SPECIES_MAX], sum = 0.0;
        if (s->electrode[p] < 0) continue;
        pd_reactive_get(s->reactive, s->reactive->c, s->node[p], c);
        for (int n = 0; n < s->reactive->components.solutes; n++)
            if (s->reactive->components.charge[n]) sum += c[n];
        if (sum < *ions) least = s->node[p];
        *ions = pd_min(*ions, sum);
    }
    return least;
}

PDI_FN int pdi_positivity_drained(const pd_reactive *r, double soonest, int *solute, int32_t *node)
{
    int found = 0;
    for (int n = 0; n < r->components.solutes; n++)
        for (int32_t i = 0; i < r->grid->total; i++) {
            int64_t at = n * (int64_t)r->grid->total + i;
            if (r->grid->kind[i] != PD_FLUID || !(r->source[at] < 0.0)) continue;
            if (!(r->c[at] < -soonest * r->source[at])) continue;
            soonest = pd_max(r->c[at], 0.0) / -r->source[at];
            *solute = n;
            *node = i;
            found = 1;
        }
    return found;
}
