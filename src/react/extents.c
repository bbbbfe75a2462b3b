/* extents: see extents.h */
#include "react/extents.h"
#include "chemistry/mineral_step.h"
#include "react/tangent.h"
#include "core/root_bracket.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Sweeps over the reactions of a node, and changes of totals that are none. */
#define PDI_EXTENTS_SWEEPS 30
#define PDI_EXTENTS_SWEPT 1e-12
/* Sweeps with derivatives, which have single precision: each makes good what that misses. */
#define PDI_EXTENTS_LINEAR 3

/* A kinetic reaction of node i. */
typedef struct pdi_extents_reaction {
    const pd_reactive *r;
    int32_t i;
    const pd_kinetic *kinetic;
    double extent; /* [mol/m3] by the correction */
    double c[PD_SPECIES_MAX], n[PD_MINERAL_MAX]; /* [mol/m3] the last equilibrium, at first that of `base` */
} pdi_extents_reaction;

/* c, n: as pdi_extents_equilibrium. The search begins at c, and at the amounts `near_`; NULL: those of `base`. */
static pd_status pdi_extents_seek(const pd_reactive *r, int32_t i, const double *sum, const double *near_, double *c,
                                  double *n)
{
    double first[PD_MINERAL_MAX];
    pd_mineral_start start;
    if (!r->minerals.count) return pdi_components_solve(&r->components, sum, c);
    pdi_tangent_law(r, i, first, &start);
    start.guess = near_;
    pdi_reactive_solids(r, r->solid_base, i, n);
    return pdi_mineral_step_solve(&r->components, &r->minerals, &start, sum, c, n);
}

PDI_FN pd_status pdi_extents_equilibrium(const pd_reactive *r, int32_t i, const double *sum, double *c, double *n)
{
    pd_reactive_get(r, r->base, i, c);
    return pdi_extents_seek(r, i, sum, NULL, c, n);
}

/* What the reaction lacks where it goes on by `more` [mol/m3] from the totals `sum`. NaN: there is no equilibrium. */
static double pdi_extents_excess(pdi_extents_reaction *of, const double *sum, double more)
{
    const pd_components *s = &of->r->components;
    double total[PD_SPECIES_MAX], n[PD_MINERAL_MAX];
    for (int k = 0; k < s->count; k++) total[k] = sum[k] + of->kinetic->total_change[k] * more;
    if (pdi_extents_seek(of->r, of->i, total, of->n, of->c, n) != PD_OK) return (double)NAN;
    memcpy(of->n, n, (size_t)of->r->minerals.count * sizeof *n);
    return of->extent + more - of->r->dt * pdi_components_compute_rate(s, of->kinetic, of->c, NULL, NULL);
}

/* Extents that differ by less make the same totals, but for their rounding [mol/m3]. */
static double pdi_extents_rounding(const pdi_extents_reaction *of, const double *sum, double more)
{
    double least = HUGE_VAL;
    for (int k = 0; k < of->r->components.count; k++) {
        double gain = fabs(of->kinetic->total_change[k]);
        if (gain > 0.0) least = pd_min(least, pd_max(fabs(sum[k]) / gain, fabs(more)));
    }
    return least < HUGE_VAL ? 0.5 * DBL_EPSILON * least : 0.0;
}

/* How much farther than by the correction it goes [mol/m3]. A reaction slows down as it goes on: what it lacks rises at
 * least as fast as its extent, so that its zero lies within that of the start. */
static double pdi_extents_find(pdi_extents_reaction *of, const double *sum)
{
    double low = pdi_extents_excess(of, sum, 0.0), more = -low, at;
    if (low == 0.0 || low != low) return 0.0;
    pdi_root_bracket s = {0.0, low, more, pdi_extents_excess(of, sum, more), 0, 0};
    if (s.value_b != s.value_b) return 0.0;
    if (!(s.value_b * low < 0.0)) return more;
    while (fabs(s.b - s.a) > pdi_extents_rounding(of, sum, s.b) && pdi_root_bracket_get_next(&s, &more)) {
        at = pdi_extents_excess(of, sum, more);
        if (at != at) return 0.0;
        if (at == 0.0) return more;
        pdi_root_bracket_update(&s, more, at);
    }
    return s.b;
}

PDI_FN void pdi_extents_react(const pd_reactive *r, int32_t i, double share, double *sum)
{
    const pd_components *s = &r->components;
    const float *row = r->by + (int64_t)i * r->slots + s->members * pdi_components_count_columns(s);
    int64_t total = r->grid->total;
    const double *delta = r->work + s->count * total;
    double base[PD_SPECIES_MAX];
    pdi_extents_reaction of[PD_REACTION_MAX];
    pd_reactive_get(r, r->base, i, base);
    for (int n = 0; n < s->kinetics; n++, row += s->count) {
        double rise = 0.0;
        for (int k = 0; k < s->count; k++) rise += (double)row[k] * r->weight[k] * delta[k * total + i];
        of[n].r = r;
        memcpy(of[n].c, base, sizeof base);
        pdi_reactive_solids(r, r->solid_base, i, of[n].n);
        of[n].i = i;
        of[n].kinetic = &s->kinetic[n];
        of[n].extent = r->dt * (pdi_components_compute_rate(s, &s->kinetic[n], base, NULL, NULL) + share * rise);
    }
    for (int sweep = 0, moved = 1; sweep < PDI_EXTENTS_SWEEPS && moved; sweep++) {
        moved = 0;
        for (int n = 0; n < s->kinetics; n++) {
            double more = pdi_extents_find(&of[n], sum);
            of[n].extent += more;
            for (int k = 0; k < s->count; k++) {
                double by = s->kinetic[n].total_change[k] * more;
                moved = moved || (s->kinetics > 1 && fabs(by) > PDI_EXTENTS_SWEPT * fabs(sum[k]));
                sum[k] += by;
            }
        }
    }
}

PDI_FN double pdi_extents_turnover(const pd_reactive *r, int k, int32_t i)
{
    const pd_components *s = &r->components;
    double c[PD_SPECIES_MAX], sum = 0.0, both;
    if (s->kinetics) pd_reactive_get(r, r->c, i, c);
    for (int n = 0; n < s->kinetics; n++) {
        if (s->kinetic[n].total_change[k] == 0.0) continue;
        pdi_components_compute_rate(s, &s->kinetic[n], c, NULL, &both);
        sum += fabs(s->kinetic[n].total_change[k]) * both;
    }
    for (int m = 0; m < r->minerals.count; m++)
        sum += fabs(r->minerals.total_content[m][k]) * r->solid[m * (int64_t)r->grid->total + i] / r->dt;
    return sum;
}

/* Change of the concentrations of node i with its dissolved totals, and with all totals by x, of which minerals take
 * their part. */
static void pdi_extents_left(const pd_reactive *r, int32_t i, const double *dissolved, const double *x, double *left)
{
    const pd_components *s = &r->components;
    const float *by = r->by + (int64_t)i * r->slots;
    double sum[PD_SPECIES_MAX], taken[PD_MINERAL_MAX];
    pdi_tangent_taken(r, by, x, taken);
    for (int k = 0; k < s->count; k++) {
        sum[k] = dissolved[k] + x[k];
        for (int m = 0; m < r->minerals.count; m++) sum[k] -= r->minerals.total_content[m][k] * taken[m];
    }
    pdi_components_apply_derivatives(s, by, sum, left);
}

/* [mol/m3/s] by which kinetic reaction n of node i at c is faster with a change of concentrations. */
static double pdi_extents_faster(const pd_reactive *r, int n, const double *c, const double *change)
{
    double slope[PD_SPECIES_MAX], speed = 0.0;
    pdi_components_compute_rate(&r->components, &r->components.kinetic[n], c, slope, NULL);
    for (int m = 0; m < r->components.solutes; m++) speed += slope[m] * change[m];
    return speed;
}

PDI_FN void pdi_extents_relax(const pd_reactive *r, int32_t i, const double *c, const double *off, double *x,
                              double *left, double *lack)
{
    const pd_components *s = &r->components;
    double extent[PD_REACTION_MAX] = {0.0}, dissolved[PD_SPECIES_MAX] = {0.0};
    for (int k = 0; k < s->count; k++) {
        x[k] = lack[k] = 0.0;
        for (int m = 0; m < r->minerals.count; m++) dissolved[k] -= r->minerals.total_content[m][k] * off[m];
    }
    for (int sweep = 0; sweep < PDI_EXTENTS_LINEAR; sweep++)
        for (int n = 0; n < s->kinetics; n++) {
            pdi_extents_left(r, i, dissolved, x, left);
            double more = pdi_extents_faster(r, n, c, left) - extent[n] / r->dt;
            more /= 1.0 / r->dt + r->filter[n].absorb[i];
            extent[n] += more;
            for (int k = 0; k < s->count; k++) x[k] += s->kinetic[n].total_change[k] * more;
        }
    pdi_extents_left(r, i, dissolved, x, left);
    for (int n = 0; n < s->kinetics; n++) {
        double more = pdi_extents_faster(r, n, c, left) - extent[n] / r->dt;
        for (int k = 0; k < s->count; k++) lack[k] += s->kinetic[n].total_change[k] * more;
    }
}

#undef PDI_EXTENTS_SWEEPS
#undef PDI_EXTENTS_SWEPT
#undef PDI_EXTENTS_LINEAR
