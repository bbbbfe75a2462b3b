/* electrolyte: see electrolyte.h */
#include "chemistry/electrolyte.h"
#include "core/root_bracket.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* [-] sum of charges over ionic strength below which a recipe is neutral */
#define PDI_ELECTROLYTE_NEUTRAL_TOLERANCE 1e-6
#define PDI_ELECTROLYTE_PH_TOLERANCE 1e-12 /* difference at which a given pH is met */
#define PDI_ELECTROLYTE_MIN_ACID 1e-9      /* [mol/m3] of acid or base that is tried first to meet a pH */
#define PDI_ELECTROLYTE_MAX_ACID 2e4       /* [mol/m3] of acid or base that is tried last */

int pd_electrolyte_find_species(const pd_electrolyte *e, const char *name)
{
    for (int i = 0; i < e->count; i++)
        if (strcmp(e->species[i].name, name) == 0) return i;
    return -1;
}

double pd_electrolyte_compute_element_total(const pd_electrolyte *e, const double *c, int element)
{
    double sum = 0.0;
    for (int i = 0; i < e->count; i++) sum += c[i] * pdi_species_count_atoms(&e->species[i], element);
    return sum;
}

/* Sum of charges z c [mol/m3] of concentrations c, with sign; *strength: ionic strength [mol/m3], half the sum of z^2
 * c. All species count; negative ones are not clipped. */
static double pdi_electrolyte_compute_charge(const pd_electrolyte *e, const double *c, double *strength)
{
    double sum = 0.0;
    *strength = 0.0;
    for (int i = 0; i < e->count; i++) {
        sum += e->species[i].charge * c[i];
        *strength += 0.5 * e->species[i].charge * e->species[i].charge * c[i];
    }
    return sum;
}

/* 1: the reaction is in equilibrium at c: it has a constant, and its minerals may form or are present. c NULL: all may
 * form. */
static int pdi_electrolyte_is_in_equilibrium(const pd_electrolyte *e, const pd_reaction *r, const double *c)
{
    if (!r->has_k) return 0;
    for (int i = 0; i < e->count && c && !e->all_minerals_form; i++)
        if (r->nu[i] != 0.0 && e->species[i].phase == PD_PHASE_SOLID && !(c[i] > 0.0)) return 0;
    return 1;
}

pd_status pd_electrolyte_build_speciation(pd_ctx *ctx, const pd_electrolyte *e, const double *c,
                                                  pd_speciation *system)
{
    pd_reaction held[PD_REACTION_MAX];
    int count = 0;
    for (int r = 0; r < e->reactions; r++) {
        if (!pdi_electrolyte_is_in_equilibrium(e, &e->reaction[r], c)) continue;
        held[count] = e->reaction[r];
        held[count++].kinetic = 0; /* its rates lead there, too */
    }
    return pd_speciation_build(ctx, e->species, e->count, held, count, e->activity, e->temperature, system);
}

/* Sets saturation indices log10(IAP/K) of minerals from the activities in s->result, by the reactions with a K, one
 * solid and neither gas nor electron; the last such reaction counts. NaN for species that have none. */
static void pdi_electrolyte_compute_saturation(const pd_electrolyte *e, pd_electrolyte_state *s)
{
    for (int i = 0; i < e->count; i++) s->saturation[i] = NAN;
    for (int r = 0; r < e->reactions; r++) {
        const double *nu = e->reaction[r].nu;
        double sum = -e->reaction[r].ln_k / log(10.0);
        int solid = -1, solids = 0;
        for (int i = 0; i < e->count; i++) {
            if (nu[i] == 0.0) continue;
            if (e->species[i].phase == PD_PHASE_SOLID) {
                solid = i;
                solids++;
            } else if (e->species[i].phase == PD_PHASE_SOLUTE) {
                sum += nu[i] * s->result.log_activity[i];
            } else if (e->species[i].phase != PD_PHASE_SOLVENT) {
                solids = 2; /* gases and electrons have no activity here */
            }
        }
        if (solids == 1 && e->reaction[r].has_k) s->saturation[solid] = -sum / nu[solid];
    }
}

/* Removes species k, which no reaction names and which is no balance or counter ion; later ones move down by one. */
static void pdi_electrolyte_remove_species(pd_electrolyte *e, int k)
{
    e->count--;
    for (int i = k; i < e->count; i++) {
        e->species[i] = e->species[i + 1];
        e->volume[i] = e->volume[i + 1];
        e->recipe[i] = e->recipe[i + 1];
        e->initial[i] = e->initial[i + 1];
        e->inlet[i] = e->inlet[i + 1];
        e->shape_initial[i] = e->shape_initial[i + 1];
        for (int r = 0; r < e->reactions; r++) e->reaction[r].nu[i] = e->reaction[r].nu[i + 1];
    }
    for (int r = 0; r < e->reactions; r++) e->reaction[r].nu[e->count] = 0.0;
    if (e->balance_ion > k) e->balance_ion--;
    if (e->counter_ion > k) e->counter_ion--;
}

void pd_electrolyte_remove_undissolved(pd_electrolyte *e, const int *stays)
{
    int kept = 0;
    for (int r = 0; r < e->reactions; r++) {
        int names = 0;
        for (int k = 0; k < e->count; k++)
            names |= fabs(e->reaction[r].nu[k]) > 0.0 && e->species[k].phase != PD_PHASE_SOLUTE &&
                     e->species[k].phase != PD_PHASE_SOLVENT && !stays[k];
        if (names) continue;
        e->reaction[kept] = e->reaction[r];
        e->enthalpy[kept++] = e->enthalpy[r];
    }
    e->reactions = kept;
    for (int k = e->count - 1; k >= 0; k--)
        if (e->species[k].phase != PD_PHASE_SOLUTE && e->species[k].phase != PD_PHASE_SOLVENT && !stays[k])
            pdi_electrolyte_remove_species(e, k);
}

pd_status pd_electrolyte_solve(pd_ctx *ctx, const pd_electrolyte *e, double *c, pd_electrolyte_state *s)
{
    pd_speciation system;
    int h = pd_electrolyte_find_species(e, "H+");
    memset(s, 0, sizeof *s);
    PD_TRY(pd_electrolyte_build_speciation(ctx, e, c, &system));
    pd_status status = pd_speciation_solve(&system, c, &s->result);
    if (status == PD_ERR_ARGUMENT)
        return pd_fail(ctx, status, "electrolyte", "a concentration is negative or no number");
    if (status != PD_OK)
        return pd_fail(ctx, PD_ERR_DIVERGED, "electrolyte", "no equilibrium was found: look for a reaction whose "
                       "constant is off by powers of ten, or whose species all are absent");
    s->strength = s->result.strength;
    double strength;
    s->charge = pdi_electrolyte_compute_charge(e, c, &strength);
    s->ph = h >= 0 && c[h] > 0.0 ? -s->result.log_activity[h] : NAN;
    pdi_electrolyte_compute_saturation(e, s);
    return PD_OK;
}

/* c = recipe `from` with `acid` [mol/m3] of H+, or where it is not positive -acid of OH-; the counter ion changes by
 * -acid over its charge, to at least 0 (eq. 7.11). c is not the equilibrium. *ph: that of its equilibrium, NaN without
 * H+. Fails as pd_electrolyte_solve does. The three ions have to exist. */
static pd_status pdi_electrolyte_compute_ph(pd_ctx *ctx, const pd_electrolyte *e, const double *from, double acid,
                                            double *c, double *ph)
{
    pd_electrolyte_state s;
    int ion = pd_electrolyte_find_species(e, acid > 0.0 ? "H+" : "OH-");
    double out[PD_SPECIES_MAX];
    memcpy(c, from, (size_t)e->count * sizeof *c);
    c[ion] += fabs(acid);
    double left = c[e->counter_ion] - acid / e->species[e->counter_ion].charge;
    c[e->counter_ion] = pd_max(left, 0.0); /* of rounding at the bound */
    memcpy(out, c, (size_t)e->count * sizeof *c);
    PD_TRY(pd_electrolyte_solve(ctx, e, out, &s));
    *ph = s.ph;
    return PD_OK;
}

/* Brackets the amount of acid (negative: base) [mol/m3] that gives `ph`: a[0], a[1], with the pH differences f[0], f[1]
 * [-], found less wanted; amounts grow fourfold from 1e-9. PD_ERR_ARGUMENT: no reaction makes H+, the counter ion is
 * used up, or 2e4 mol/m3 do not reach it. */
static pd_status pdi_electrolyte_find_acid_bracket(pd_ctx *ctx, const pd_electrolyte *e, double ph, const double *from,
                                                   double *a, double *f)
{
    const pd_species *counter = &e->species[e->counter_ion];
    double c[PD_SPECIES_MAX];
    PD_TRY(pdi_electrolyte_compute_ph(ctx, e, from, 0.0, c, &f[0]));
    f[0] -= ph;
    a[0] = a[1] = 0.0;
    if (isnan(f[0]))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte", "pH is set and no reaction makes H+, expected one such as "
                       "[reaction water] H2O = H+ + OH-");
    f[1] = f[0];
    for (double sign = f[0] > 0.0 ? 1.0 : -1.0, size = PDI_ELECTROLYTE_MIN_ACID; f[1] * sign > 0.0; size *= 4.0) {
        double most = from[e->counter_ion] * counter->charge * sign; /* the ion is used up */
        if (a[1] * sign >= PDI_ELECTROLYTE_MAX_ACID || (most > 0.0 && a[1] * sign >= most))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte",
                           "pH %g cannot be reached with %s, of which there are "
                           "%g mol/m3: name another ion by 'counter_ion'",
                           ph, counter->name, from[e->counter_ion]);
        a[0] = a[1];
        f[0] = f[1];
        a[1] = sign * (most > 0.0 ? pd_min(size, most) : size);
        PD_TRY(pdi_electrolyte_compute_ph(ctx, e, from, a[1], c, &f[1]));
        f[1] -= ph;
    }
    return PD_OK;
}

/* Adds the acid or base to c that gives `ph` to 1e-12, or as near as rounding lets it, by the Illinois method (eq.
 * 7.11). PD_ERR_ARGUMENT: no counter ion, H+ or OH-, or it cannot be reached. */
static pd_status pdi_electrolyte_solve_ph(pd_ctx *ctx, const pd_electrolyte *e, double ph, double *c)
{
    double from[PD_SPECIES_MAX], a[2], f[2];
    if (e->counter_ion < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte",
                       "pH is set, but no ion that comes with the acid or base "
                       "that sets it, expected counter_ion = Cl- or another ion");
    if (pd_electrolyte_find_species(e, "H+") < 0 || pd_electrolyte_find_species(e, "OH-") < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte", "pH is set and there is no [species H+] or no "
                       "[species OH-], expected both");
    memcpy(from, c, (size_t)e->count * sizeof *c);
    PD_TRY(pdi_electrolyte_find_acid_bracket(ctx, e, ph, from, a, f));
    pdi_root_bracket s = {a[0], f[0], a[1], f[1], 0, 0};
    double acid = a[1], off = f[1], found;
    while (fabs(off) > PDI_ELECTROLYTE_PH_TOLERANCE && pdi_root_bracket_get_next(&s, &acid)) {
        PD_TRY(pdi_electrolyte_compute_ph(ctx, e, from, acid, c, &found));
        off = found - ph;
        pdi_root_bracket_update(&s, acid, off);
    }
    return pdi_electrolyte_compute_ph(ctx, e, from, acid, c, &found);
}

/* Name of the ion in solution of largest c, the first of equals, as a proposal in messages; "Cl-" without ions. */
static const char *pdi_electrolyte_find_main_ion(const pd_electrolyte *e, const double *c)
{
    int best = -1;
    for (int i = 0; i < e->count; i++)
        if (e->species[i].charge && e->species[i].phase == PD_PHASE_SOLUTE && (best < 0 || c[i] > c[best])) best = i;
    return best < 0 ? "Cl-" : e->species[best].name;
}

pd_status pd_electrolyte_neutralise(pd_ctx *ctx, const pd_electrolyte *e, double ph, double *c)
{
    double closed[PD_SPECIES_MAX], strength, charge = pdi_electrolyte_compute_charge(e, c, &strength);
    if (e->balance_ion < 0 && fabs(charge) > PDI_ELECTROLYTE_NEUTRAL_TOLERANCE * strength)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte",
                       "the charges sum to %+.4g mol/m3, %.3g %% of the ionic "
                       "strength, expected 0: correct a concentration, or name the ion that makes up for it by "
                       "balance_ion = %s",
                       charge, 100.0 * fabs(charge) / strength, pdi_electrolyte_find_main_ion(e, c));
    memcpy(closed, c, (size_t)e->count * sizeof *c);
    if (e->balance_ion >= 0) {
        double more = -charge / e->species[e->balance_ion].charge;
        if (c[e->balance_ion] + more < 0.0)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "electrolyte",
                           "the charges sum to %+.4g mol/m3, which %s cannot "
                           "make up for: there are %g mol/m3 of it; name another ion by 'balance_ion'",
                           charge, e->species[e->balance_ion].name, c[e->balance_ion]);
        closed[e->balance_ion] += more;
    }
    if (!isnan(ph)) PD_TRY(pdi_electrolyte_solve_ph(ctx, e, ph, closed));
    memcpy(c, closed, (size_t)e->count * sizeof *c);
    return PD_OK;
}

pd_status pd_electrolyte_reagent(pd_ctx *ctx, const pd_electrolyte *e, const char *text, double *per)
{
    pd_reaction r;
    double strength;
    PD_TRY(pdi_reaction_parse_sum(ctx, "the reagent", text, e->species, e->count, &r));
    double charge = pdi_electrolyte_compute_charge(e, r.nu, &strength);
    if (charge != 0.0)
        return pd_fail(ctx, PD_ERR_PARSE, "electrolyte", "the reagent '%.60s' has the charge %+g, expected a neutral "
                       "one such as Na+ + OH-", text, charge);
    memcpy(per, r.nu, (size_t)e->count * sizeof *per);
    return PD_OK;
}
