/* mineral: see mineral.h */
#include "chemistry/mineral.h"
#include <math.h>
#include <string.h>

#define PDI_MINERAL_MOLAR 1e3 /* [mol/m3] one mol/L */

/* Number of solids in a reaction. */
static int pdi_mineral_count_solids(const pd_species *species, int count, const pd_reaction *r)
{
    int solids = 0;
    for (int i = 0; i < count; i++) solids += r->nu[i] != 0.0 && species[i].phase == PD_PHASE_SOLID;
    return solids;
}

PDI_FN int pdi_mineral_copy_solid_free_reactions(const pd_species *species, int count, const pd_reaction *reactions,
                                                 int reaction_count, pd_reaction *rest)
{
    int kept = 0;
    for (int r = 0; r < reaction_count; r++)
        if (!pdi_mineral_count_solids(species, count, &reactions[r])) rest[kept++] = reactions[r];
    return kept;
}

/* 1: a parameter is negative or not finite. */
static int pdi_mineral_is_invalid(double value) { return !(value >= 0.0) || !(value < 1e100); }

/* Sets nu, total_content, charge_square and ln_k of mineral s, which dissolves by reaction r, for one unit of it
 * dissolved. */
static void pdi_mineral_set_reaction(const pd_components *c, const pd_species *species, int count, const pd_reaction *r,
                                     pd_minerals *m, int s)
{
    double one = -r->nu[m->mineral[s].species], sum = 0.0;
    for (int i = 0; i < count; i++) {
        double nu = r->nu[i] / one;
        if (c->solute_of_species[i] < 0 || nu == 0.0) continue;
        m->nu[s][c->solute_of_species[i]] = nu;
        m->charge_square[s] += nu * species[i].charge * species[i].charge;
        sum += nu;
    }
    m->ln_k[s] = r->ln_k / one + sum * log(PDI_MINERAL_MOLAR);
    pdi_components_compute_totals(c, m->nu[s], m->total_content[s]);
}

/* Checks all minerals, fills in exponents (0 becomes 1), and finds their reactions. PD_ERR_ARGUMENT: a number is out of
 * range, or a mineral has not exactly one reaction, with a K and with solutes and water alone. */
static pd_status pdi_mineral_set_laws(pd_ctx *ctx, const pd_components *c, const pd_species *species, int count,
                                      const pd_reaction *reactions, int reaction_count, pd_minerals *m)
{
    for (int s = 0; s < m->count; s++) {
        pd_mineral *of = &m->mineral[s];
        const char *name = species[of->species].name;
        int found = -1, several = 0;
        if (pdi_mineral_is_invalid(of->rate) || pdi_mineral_is_invalid(of->surface_rate) ||
            pdi_mineral_is_invalid(of->exponent) || pdi_mineral_is_invalid(of->volume) ||
            !(fabs(of->nucleation) < 1e100) || !(of->min_porosity >= 0.0) || !(of->min_porosity < 1.0))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals",
                           "%s has the rate %g, surface %g, exponent %g, volume %g, "
                           "nucleation %g and porosity %g, expected finite values of at least 0, and a porosity below "
                           "1",
                           name, of->rate, of->surface_rate, of->exponent, of->volume, of->nucleation,
                           of->min_porosity);
        if (!(of->exponent > 0.0)) of->exponent = 1.0;
        for (int r = 0; r < reaction_count; r++) {
            if (reactions[r].nu[of->species] == 0.0) continue;
            several += found >= 0 || pdi_mineral_count_solids(species, count, &reactions[r]) > 1;
            found = r;
        }
        if (found < 0 || several || !reactions[found].has_k)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals", "%s has %s, expected one reaction with a constant and "
                           "solutes, such as %s = ...", name, found < 0 ? "no reaction" : several ?
                           "several reactions, or one with another solid" : "a reaction without K", name);
        for (int i = 0; i < count; i++)
            if (reactions[found].nu[i] != 0.0 && species[i].phase > PD_PHASE_SOLID)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals", "%s reacts with %s, expected solutes and water", name,
                               species[i].name);
        pdi_mineral_set_reaction(c, species, count, &reactions[found], m, s);
    }
    return PD_OK;
}

/* Copies the list of minerals. PD_ERR_ARGUMENT: more than PD_MINERAL_MAX, a species that is no solid or is there
 * twice. */
static pd_status pdi_mineral_copy_list(pd_ctx *ctx, const pd_species *species, int count, const pd_mineral *list,
                                       int mineral_count, pd_minerals *m)
{
    if (mineral_count < 0 || mineral_count > PD_MINERAL_MAX)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals", "%d minerals, expected at most %d", mineral_count,
                       PD_MINERAL_MAX);
    for (int s = 0; s < mineral_count; s++) {
        m->mineral[s] = list[s];
        if (list[s].species < 0 || list[s].species >= count || species[list[s].species].phase != PD_PHASE_SOLID)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals", "mineral %d is species %d, which is no solid", s,
                           list[s].species);
        for (int t = 0; t < s; t++)
            if (list[t].species == list[s].species)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "minerals", "%s is there twice", species[list[s].species].name);
    }
    m->count = mineral_count;
    return PD_OK;
}

PDI_FN pd_status pdi_mineral_build(pd_ctx *ctx, const pd_components *c, const pd_species *species, int count,
                                   const pd_reaction *reactions, int reaction_count, const pd_mineral *list,
                                   int mineral_count, pd_minerals *m)
{
    memset(m, 0, sizeof *m);
    pd_status status = pdi_mineral_copy_list(ctx, species, count, list, mineral_count, m);
    if (status == PD_OK) status = pdi_mineral_set_laws(ctx, c, species, count, reactions, reaction_count, m);
    if (status < 0) memset(m, 0, sizeof *m);
    return status;
}

PDI_FN double pdi_mineral_compute_volume(const pd_minerals *m, const double *n)
{
    double sum = 0.0;
    for (int s = 0; s < m->count; s++) sum += m->mineral[s].volume * n[s];
    return sum;
}

PDI_FN double pdi_mineral_compute_volume_fraction(const pd_minerals *m, const double *n)
{
    return pd_min(pd_max(pdi_mineral_compute_volume(m, n), 0.0), 1.0);
}

PDI_FN double pdi_mineral_compute_ln_omega(const pd_components *c, const pd_minerals *m, int s, const double *conc)
{
    double sum = m->charge_square[s] * pdi_components_compute_ln_gamma(c, conc) - m->ln_k[s], more = 0.0;
    int lacks = 0;
    for (int i = 0; i < c->solutes; i++) {
        double size = m->nu[s][i] != 0.0 ? m->nu[s][i] * log(pd_max(conc[i], PDI_MINERAL_MIN_CONCENTRATION)) : 0.0;
        lacks |= m->nu[s][i] > 0.0 && !(conc[i] > 1.01 * PDI_MINERAL_MIN_CONCENTRATION);
        if (m->nu[s][i] < 0.0) more += size;
        else sum += size;
    }
    return sum + (lacks ? pd_min(more, 0.0) : more); /* no acid makes a mineral of ions that are not there */
}

PDI_FN void pdi_mineral_begin_step(const pd_components *c, const pd_minerals *m, const double *n, const double *conc,
                                   pd_mineral_start *start)
{
    start->has_limits = 0;
    start->guess = NULL;
    for (int s = 0; s < m->count; s++) {
        const pd_mineral *of = &m->mineral[s];
        start->initial[s] = pd_max(n[s], 0.0);
        int free = !(of->rate > 0.0) && !(of->surface_rate > 0.0), bare = !(n[s] > 0.0) && of->nucleation > 0.0;
        start->rate[s] = free ? HUGE_VAL : of->rate;
        start->amount_rate[s] = of->rate > 0.0 || n[s] > 0.0 ? of->surface_rate : 0.0;
        if (bare && pdi_mineral_compute_ln_omega(c, m, s, conc) < of->nucleation * log(10.0))
            start->rate[s] = start->amount_rate[s] = 0.0;
    }
}

PDI_FN int pdi_mineral_try_resume(pd_mineral_start *start, int s, double first_amount, double step_ratio,
                                  double *amount)
{
    if (!(start->amount_rate[s] > 0.0) || start->rate[s] + start->amount_rate[s] * *amount > 0.0) return 0;
    *amount = pd_max(first_amount, 0.0);
    start->rate[s] *= step_ratio;
    start->amount_rate[s] *= step_ratio;
    return 1;
}

PDI_FN int pdi_mineral_is_reactive(const pd_mineral_start *start, int s)
{
    return start->rate[s] > 0.0 || start->amount_rate[s] > 0.0;
}

PDI_FN double pdi_mineral_compute_max_extent(const pd_mineral_start *start, int s, double n)
{
    return (start->rate[s] + start->amount_rate[s] * n) * start->dt;
}

PDI_FN double pdi_mineral_compute_growth(const pd_mineral_start *start, int s, double excess)
{
    double more = start->dt * start->amount_rate[s] * excess;
    if (!(start->rate[s] < HUGE_VAL) || !(more < 1.0)) return HUGE_VAL;
    return pdi_mineral_compute_max_extent(start, s, start->start_amount[s]) * excess / (1.0 - more);
}

/* Most that dissolves of mineral s in the step by its law [mol/m3]; all of it in equilibrium. */
static double pdi_mineral_compute_max_dissolution(const pd_mineral_start *start, int s)
{
    double rate = start->rate[s] < HUGE_VAL ? -pdi_mineral_compute_growth(start, s, -1.0) : HUGE_VAL;
    return start->start_amount[s] - pd_max(start->start_amount[s] - rate, 0.0);
}

/* Most that mineral s grows in the step [mol/m3], by its law and the free volume. Negative: there is too much of it. */
static double pdi_mineral_compute_max_growth(const pd_minerals *m, const pd_mineral_start *start, int s)
{
    double rate = pdi_mineral_compute_growth(start, s, 1.0),
           room = 1.0 - m->mineral[s].min_porosity - m->mineral[s].volume * start->start_amount[s];
    for (int q = 0; q < m->count; q++)
        if (q != s)
            room -= m->mineral[q].volume * (start->start_amount[q] - pdi_mineral_compute_max_dissolution(start, q));
    if (!(m->mineral[s].volume > 0.0)) return rate;
    return pd_min(rate, pd_max(room / m->mineral[s].volume, start->initial[s] - start->start_amount[s]));
}

PDI_FN int pdi_mineral_is_infeasible(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start,
                                     const double *total)
{
    for (int k = 0; k < c->count; k++) {
        double most = total[k];
        int signs = 0;
        for (int i = 0; i < c->solutes; i++) signs |= c->stoichiometry[k][i] < 0.0;
        for (int s = 0; s < m->count && !signs; s++) {
            double gain = m->total_content[s][k];
            if (gain > 0.0) most += gain * pdi_mineral_compute_max_dissolution(start, s);
            if (gain < 0.0) most -= gain * pdi_mineral_compute_max_growth(m, start, s);
        }
        if (!signs && most < 0.0) return 1;
    }
    return 0;
}

PDI_FN int pdi_mineral_has_switched(const pd_minerals *m, const double *n_before, const double *after)
{
    double before = pdi_mineral_compute_volume_fraction(m, n_before),
           now = pdi_mineral_compute_volume_fraction(m, after);
    for (int s = 0; s < m->count; s++) {
        double full = (1.0 - m->mineral[s].min_porosity) * (1.0 - PDI_MINERAL_FULL_TOLERANCE);
        if (n_before[s] > 0.0 && !(after[s] > 0.0)) return 1;
        if (m->mineral[s].volume > 0.0 && before < full && now >= full) return 1;
    }
    return 0;
}

#undef PDI_MINERAL_MOLAR
