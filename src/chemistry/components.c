/* components: see components.h */
#include "chemistry/components.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PDI_COMPONENTS_ROUNDING_ZERO 1e-9       /* a combination of stoichiometric numbers below this is zero */
#define PDI_COMPONENTS_MIN_CONCENTRATION 1e-200 /* [mol/m3] lower bound of concentrations in logarithms */
#define PDI_COMPONENTS_MAX_NEWTON 200           /* most Newton steps */
#define PDI_COMPONENTS_MAX_HALVINGS 12          /* most halvings of a Newton step */
#define PDI_COMPONENTS_TOTAL_ROUNDING 4.0       /* error of a total in rounding units of its terms that counts as met */
/* [-] error of a total over its terms that counts as met when Newton stalls */
#define PDI_COMPONENTS_STALLED_TOLERANCE 1e-11
#define PDI_COMPONENTS_SWAP_RATIO 2.0       /* [-] a formed species above this many times a basis species replaces it */
#define PDI_COMPONENTS_MAX_LOG_CHANGE 700.0 /* largest change of a logarithm in a step */
/* [-] relative change of the ionic strength at which its iteration ends */
#define PDI_COMPONENTS_STRENGTH_TOLERANCE 1e-15
#define PDI_COMPONENTS_STRENGTH_MAX_NEWTON 40 /* most steps of the iteration of the ionic strength */
#define PDI_COMPONENTS_STRENGTH_STALLED 1e-12 /* [-] a change below this that a step does not halve is rounding */
#define PDI_COMPONENTS_CACHED_CHARGES 10      /* charges below this have a stored activity factor */
#define PDI_COMPONENTS_MAX_LOG 600.0 /* |ln c| above which an activity is applied to the logarithm, against overflow \
                                      */
#define PDI_COMPONENTS_MOLAR 1e3 /* [mol/m3] one mol/L */

/* A matrix with a row for each joined component and a column for each member. */
typedef double pdi_components_matrix[PD_SPECIES_MAX][PD_SPECIES_MAX];

/* Solver state of one volume: the most frequent independent members, `basis`, form the others by the rows of
 * `m`. */
typedef struct pdi_components_work {
    const pd_components *system;
    int rows, members;
    int charge[PD_SPECIES_MAX];
    double total[PD_SPECIES_MAX];  /* [mol/m3] joined */
    double debye, other_strength;  /* as of the system; [mol/m3] ionic strength of those that are not joined */
    double ln_k[PD_SPECIES_MAX];   /* of members, by the heads */
    int basis[PD_SPECIES_MAX];     /* basis member of each row */
    pdi_components_matrix m, inverse; /* [rows][live], [rows][rows] */
    /* [mol/m3] totals T_r in the basis, sums of term sizes */
    double balance[PD_SPECIES_MAX], term_size[PD_SPECIES_MAX];
    double ln_activity[PD_SPECIES_MAX];               /* unknowns: ln of activities of the basis, with mol/m3 */
    double ln_c[PD_SPECIES_MAX], c[PD_SPECIES_MAX];   /* members: ln of [mol/m3], [mol/m3] */
    double strength, ln_gamma, ln_gamma_slope;        /* [mol/m3], ln gamma of a charge of 1, [m3/mol] */
} pdi_components_work;

/* ---- a volume ---- */

PDI_FN void pdi_components_compute_totals(const pd_components *s, const double *c, double *total)
{
    for (int k = 0; k < s->count; k++) {
        total[k] = c[s->component_solute[k]];
        for (int n = 0; n < s->members && k < s->equilibrium_components; n++) {
            int i = s->member_solute[n];
            if (i != s->component_solute[k]) total[k] += s->stoichiometry[k][i] * c[i];
        }
    }
}

/* Square of a charge. */
static double pdi_components_compute_square(int charge) { return (double)(charge * charge); }

/* Ionic strength [mol/m3] of the solutes that no equilibrium reaction joins, from totals [count] (or their changes). */
static double pdi_components_compute_other_strength(const pd_components *s, const double *total)
{
    double sum = 0.0;
    for (int k = s->equilibrium_components; k < s->count; k++)
        sum += 0.5 * pdi_components_compute_square(s->charge[s->component_solute[k]]) * total[k];
    return sum;
}

double pd_components_compute_ionic_strength(const pd_components *s, const double *c)
{
    double strength = 0.0;
    for (int i = 0; i < s->solutes; i++)
        strength += 0.5 * pdi_components_compute_square(s->charge[i]) * pd_max(c[i], 0.0);
    return strength;
}

PDI_FN double pdi_components_compute_davies(const pd_components *s, const double *c, double *slope)
{
    *slope = 0.0;
    return s->debye_hueckel > 0.0
               ? pdi_activity_compute_davies(s->debye_hueckel, pd_components_compute_ionic_strength(s, c), slope)
               : 0.0;
}

PDI_FN double pdi_components_compute_ln_gamma(const pd_components *s, const double *c)
{
    double slope;
    return pdi_components_compute_davies(s, c, &slope);
}

/* Sets the exponents of ln gamma for both ways: the sum of |nu| z^2 over the solutes of a side, less the square of the
 * sum of its charges, which is the charge of the activated complex (kinetic salt effect: Broensted, Bjerrum; eq. 7.3).
 * Both ways take the charge of the left side. */
static void pdi_components_compute_salt_effect(const pd_components *s, pd_kinetic *kinetic)
{
    double charge = 0.0;
    kinetic->salt_exponent[0] = kinetic->salt_exponent[1] = 0.0;
    for (int i = 0; i < s->solutes; i++) {
        if (kinetic->nu[i] < 0.0) charge -= kinetic->nu[i] * s->charge[i];
        kinetic->salt_exponent[kinetic->nu[i] > 0.0] +=
            fabs(kinetic->nu[i]) * pdi_components_compute_square(s->charge[i]);
    }
    kinetic->salt_exponent[0] -= charge * charge;
    kinetic->salt_exponent[1] -= charge * charge;
}

/* Chooses the basis and rewrites (7.8) in its terms by Gauss-Jordan elimination: members from the most frequent on,
 * each that is independent of those before it (a number above 1e-9 is left). Sets basis, m, inverse, ln_k, balance,
 * term_size and ln_activity from ln_c and total. */
static void pdi_components_update_basis(pdi_components_work *w)
{
    const pd_components *s = w->system;
    int order[PD_SPECIES_MAX], done[PD_SPECIES_MAX], rows = w->rows, live = w->members;
    for (int n = 0; n < live; n++) {
        int k = n;
        for (; k > 0 && w->ln_c[order[k - 1]] < w->ln_c[n]; k--) order[k] = order[k - 1];
        order[k] = n;
    }
    for (int r = 0; r < rows; r++) {
        done[r] = 0;
        for (int n = 0; n < live; n++) w->m[r][n] = s->stoichiometry[r][s->member_solute[n]];
        for (int k = 0; k < rows; k++) w->inverse[r][k] = k == r ? 1.0 : 0.0;
    }
    for (int next = 0, found = 0; next < live && found < rows; next++) {
        int n = order[next], best = -1;
        double size = PDI_COMPONENTS_ROUNDING_ZERO;
        for (int r = 0; r < rows; r++) {
            if (done[r] || !(fabs(w->m[r][n]) > size)) continue;
            best = r;
            size = fabs(w->m[r][n]);
        }
        if (best < 0) continue;
        double scale = 1.0 / w->m[best][n];
        for (int k = 0; k < live; k++) w->m[best][k] *= scale;
        for (int k = 0; k < rows; k++) w->inverse[best][k] *= scale;
        for (int r = 0; r < rows; r++) {
            double factor = w->m[r][n];
            if (r == best || factor == 0.0) continue;
            for (int k = 0; k < live; k++) {
                w->m[r][k] -= factor * w->m[best][k];
                if (fabs(w->m[r][k]) < PDI_COMPONENTS_ROUNDING_ZERO) w->m[r][k] = 0.0;
            }
            for (int k = 0; k < rows; k++) w->inverse[r][k] -= factor * w->inverse[best][k];
        }
        done[best] = 1;
        w->basis[best] = n;
        found++;
    }
    for (int n = 0; n < live; n++) {
        w->ln_k[n] = s->ln_k[s->member_solute[n]];
        for (int r = 0; r < rows; r++) w->ln_k[n] -= w->m[r][n] * s->ln_k[s->member_solute[w->basis[r]]];
    }
    for (int r = 0; r < rows; r++) {
        w->balance[r] = w->term_size[r] = 0.0;
        for (int k = 0; k < rows; k++) {
            w->balance[r] += w->inverse[r][k] * w->total[k];
            w->term_size[r] += fabs(w->inverse[r][k] * w->total[k]);
        }
        w->ln_activity[r] = w->ln_c[w->basis[r]] + w->ln_gamma * pdi_components_compute_square(w->charge[w->basis[r]]);
    }
}

/* 1: a member is far more frequent than a basis member that forms it: the basis has to be chosen anew. */
static int pdi_components_is_basis_stale(const pdi_components_work *w)
{
    for (int r = 0; r < w->rows; r++)
        for (int n = 0; n < w->members; n++)
            if (w->m[r][n] != 0.0 && w->c[n] > PDI_COMPONENTS_SWAP_RATIO * w->c[w->basis[r]] &&
                w->c[n] > PDI_COMPONENTS_MIN_CONCENTRATION)
                return 1;
    return 0;
}

/* factor [size of charge] = 1/gamma for each size of charge of a member below PDI_COMPONENTS_CACHED_CHARGES; other
 * entries are not set. */
static void pdi_components_compute_activity_factors(const pdi_components_work *w, double *factor)
{
    int seen[PDI_COMPONENTS_CACHED_CHARGES] = {0};
    for (int n = 0; n < w->members; n++) {
        int z = abs(w->charge[n]);
        if (z >= PDI_COMPONENTS_CACHED_CHARGES || seen[z]) continue;
        seen[z] = 1;
        factor[z] = exp(-w->ln_gamma * pdi_components_compute_square(z));
    }
}

/* Sets w->c, ln_gamma and its slope: concentrations of the members at the ionic strength w->strength, from ideal ones,
 * or from ln_c where those are negative. Returns the ionic strength that they give with other solutes; *fourth: sum of
 * z^4 c/2 of members. */
static double pdi_components_compute_concentrations(pdi_components_work *w, const double *ideal, double *fourth)
{
    double factor[PDI_COMPONENTS_CACHED_CHARGES], sum = w->other_strength;
    *fourth = 0.0;
    w->ln_gamma = pdi_activity_compute_davies(w->debye, w->strength, &w->ln_gamma_slope);
    pdi_components_compute_activity_factors(w, factor);
    for (int n = 0; n < w->members; n++) {
        double square = pdi_components_compute_square(w->charge[n]);
        w->c[n] = ideal[n] >= 0.0 ? ideal[n] * factor[abs(w->charge[n])] : exp(w->ln_c[n] - square * w->ln_gamma);
        sum += 0.5 * square * w->c[n];
        *fourth += 0.5 * square * square * w->c[n];
    }
    return sum;
}

/* Sets c and ln_c of the members from the basis activities ln_activity, with the ionic strength that they have
 * (Newton's method from w->strength, until rounding stops it, PDI_COMPONENTS_STRENGTH_MAX_NEWTON steps at most). Ideal
 * solutes need no iteration. */
static void pdi_components_compute_members(pdi_components_work *w)
{
    double ideal[PD_SPECIES_MAX], last = HUGE_VAL;
    for (int n = 0; n < w->members; n++) {
        double ln = w->ln_k[n];
        for (int r = 0; r < w->rows; r++)
            if (w->m[r][n] != 0.0) ln += w->m[r][n] * w->ln_activity[r];
        w->ln_c[n] = ln;
        int far = fabs(ln) > PDI_COMPONENTS_MAX_LOG || abs(w->charge[n]) >= PDI_COMPONENTS_CACHED_CHARGES;
        ideal[n] = w->debye > 0.0 && far ? -1.0 : exp(ln);
        w->c[n] = ideal[n];
    }
    if (!(w->debye > 0.0)) return;
    for (int step = 0; step < PDI_COMPONENTS_STRENGTH_MAX_NEWTON; step++) {
        double fourth, sum = pdi_components_compute_concentrations(w, ideal, &fourth);
        double change = (sum - w->strength) / pd_max(1.0 + fourth * w->ln_gamma_slope, 0.5), size = fabs(change);
        if (!(size > PDI_COMPONENTS_STRENGTH_TOLERANCE * w->strength)) break;
        if (size < PDI_COMPONENTS_STRENGTH_STALLED * w->strength && !(size < 0.5 * last)) break;
        last = size;
        w->strength = pd_max(w->strength + change, 0.1 * w->strength);
    }
    for (int n = 0; n < w->members; n++) w->ln_c[n] -= w->ln_gamma * pdi_components_compute_square(w->charge[n]);
}

/* weight [rows][members] [mol/m3] = derivatives of the members by ln_activity; scaled 1: over the basis concentrations
 * [-]. each [members] [m3/mol]: derivatives of their logarithms by the ionic strength of other solutes. */
static void pdi_components_compute_member_derivatives(const pdi_components_work *w, int scaled,
                                                      pdi_components_matrix weight, double *each)
{
    double fourth = 0.0;
    for (int n = 0; n < w->members; n++) {
        double square = pdi_components_compute_square(w->charge[n]);
        fourth += 0.5 * square * square * w->c[n] * w->ln_gamma_slope;
    }
    for (int n = 0; n < w->members; n++)
        each[n] =
            w->debye > 0.0 ? -pdi_components_compute_square(w->charge[n]) * w->ln_gamma_slope / (1.0 + fourth) : 0.0;
    for (int r = 0; r < w->rows; r++) {
        double half = 0.0, over = scaled ? w->c[w->basis[r]] : 1.0;
        for (int n = 0; n < w->members; n++) {
            weight[r][n] = w->m[r][n] != 0.0 ? w->m[r][n] * (w->c[n] / over) : 0.0;
            half += 0.5 * pdi_components_compute_square(w->charge[n]) * weight[r][n];
        }
        for (int n = 0; n < w->members; n++) weight[r][n] += each[n] * half * w->c[n];
    }
}

/* Solves a x = b, `rows` equations with `columns` right-hand sides, by Gauss-Jordan elimination with partial pivoting;
 * x in b, a is overwritten. An unknown whose pivot is at most DBL_EPSILON in size gets 0. */
static void pdi_components_solve_linear(int rows, int columns, pdi_components_matrix a, pdi_components_matrix b)
{
    int at[PD_SPECIES_MAX], used[PD_SPECIES_MAX];
    for (int r = 0; r < rows; r++) used[r] = 0;
    for (int c = 0; c < rows; c++) {
        int best = -1;
        double size = DBL_EPSILON;
        at[c] = -1;
        for (int r = 0; r < rows; r++) {
            if (used[r] || !(fabs(a[r][c]) > size)) continue;
            best = r;
            size = fabs(a[r][c]);
        }
        if (best < 0) continue;
        at[c] = best;
        used[best] = 1;
        for (int r = 0; r < rows; r++) {
            double factor = a[r][c] / a[best][c];
            if (r == best || factor == 0.0) continue;
            for (int k = c; k < rows; k++) a[r][k] -= factor * a[best][k];
            for (int k = 0; k < columns; k++) b[r][k] -= factor * b[best][k];
        }
    }
    pdi_components_matrix x;
    for (int c = 0; c < rows; c++)
        for (int k = 0; k < columns; k++) x[c][k] = at[c] < 0 ? 0.0 : b[at[c]][k] / a[at[c]][c];
    for (int c = 0; c < rows; c++)
        for (int k = 0; k < columns; k++) b[c][k] = x[c][k];
}

/* off [rows] = residuals ln(P/Q) of the mass balances (eq. 7.9); side: P and Q, the positive terms and the size of the
 * negative ones, the total among them. Returns the largest size; *relative_error: the largest |P - Q| over term_size +
 * P + Q. Totals that no concentrations have get Q next to 0. */
static double pdi_components_compute_balance_residuals(const pdi_components_work *w, double (*side)[2], double *off,
                                                       double *relative_error)
{
    double worst = 0.0;
    *relative_error = 0.0;
    for (int r = 0; r < w->rows; r++) {
        double plus = 0.0, minus = 0.0, terms = w->term_size[r];
        for (int n = 0; n < w->members; n++) {
            if (w->m[r][n] > 0.0) plus += w->m[r][n] * w->c[n];
            else minus -= w->m[r][n] * w->c[n];
        }
        if (w->balance[r] > 0.0) minus += w->balance[r];
        else if (minus > PDI_COMPONENTS_MIN_CONCENTRATION) plus -= w->balance[r];
        else terms = PDI_COMPONENTS_MIN_CONCENTRATION / DBL_EPSILON;
        minus = pd_max(minus, PDI_COMPONENTS_MIN_CONCENTRATION);
        plus = pd_max(plus, DBL_MIN);
        off[r] = log(plus / minus);
        worst = pd_max(worst, fabs(off[r]));
        *relative_error = pd_max(*relative_error, fabs(plus - minus) / (terms + plus + minus));
        side[r][0] = plus;
        side[r][1] = minus;
    }
    return worst;
}

/* dy [rows] = Newton step of ln_activity for ln(P/Q) = 0, which is nearly linear in it at any distance (eq. 7.9). Its
 * size is at most PDI_COMPONENTS_MAX_LOG_CHANGE. */
static void pdi_components_compute_newton_step(const pdi_components_work *w, double (*side)[2], const double *off,
                                               double *dy)
{
    pdi_components_matrix a, b, weight;
    double each[PD_SPECIES_MAX];
    pdi_components_compute_member_derivatives(w, 0, weight, each);
    for (int r = 0; r < w->rows; r++) {
        for (int k = 0; k < w->rows; k++) a[r][k] = 0.0;
        for (int n = 0; n < w->members; n++) {
            if (w->m[r][n] == 0.0) continue;
            double share = w->m[r][n] / side[r][w->m[r][n] < 0.0];
            for (int k = 0; k < w->rows; k++) a[r][k] += share * weight[k][n];
        }
        b[r][0] = -off[r];
    }
    pdi_components_solve_linear(w->rows, 1, a, b);
    for (int r = 0; r < w->rows; r++)
        dy[r] = pd_min(pd_max(b[r][0], -PDI_COMPONENTS_MAX_LOG_CHANGE), PDI_COMPONENTS_MAX_LOG_CHANGE);
}

/* Newton iterations for the members of the totals in w, from c and ln_c; a step is halved until the largest |ln(P/Q)|
 * falls. 1: the relative error of all totals is at most PDI_COMPONENTS_TOTAL_ROUNDING rounding units, or below
 * PDI_COMPONENTS_STALLED_TOLERANCE where no step helps. 0: neither, or PDI_COMPONENTS_MAX_NEWTON steps. */
static int pdi_components_solve_members(pdi_components_work *w)
{
    double side[PD_SPECIES_MAX][2], off[PD_SPECIES_MAX], dy[PD_SPECIES_MAX], start[PD_SPECIES_MAX], relative_error;
    pdi_components_update_basis(w);
    pdi_components_compute_members(w);
    double worst = pdi_components_compute_balance_residuals(w, side, off, &relative_error);
    for (int step = 0; step < PDI_COMPONENTS_MAX_NEWTON; step++) {
        if (!(relative_error > PDI_COMPONENTS_TOTAL_ROUNDING * DBL_EPSILON)) return 1;
        if (pdi_components_is_basis_stale(w)) {
            pdi_components_update_basis(w);
            pdi_components_compute_members(w);
            worst = pdi_components_compute_balance_residuals(w, side, off, &relative_error);
        }
        double before = worst, had = relative_error, share = 1.0;
        pdi_components_compute_newton_step(w, side, off, dy);
        memcpy(start, w->ln_activity, sizeof start);
        for (int halving = 0; halving <= PDI_COMPONENTS_MAX_HALVINGS; halving++, share *= 0.5) {
            for (int r = 0; r < w->rows; r++) w->ln_activity[r] = start[r] + share * dy[r];
            pdi_components_compute_members(w);
            worst = pdi_components_compute_balance_residuals(w, side, off, &relative_error);
            if (worst < before) break;
        }
        if (!(worst < before))
            return relative_error < PDI_COMPONENTS_STALLED_TOLERANCE || had < PDI_COMPONENTS_STALLED_TOLERANCE;
    }
    return 0;
}

/* 1: a balance needs members that count negative and that are next to nothing: a step went too far, and no step leads
 * back. */
static int pdi_components_has_vanished_members(const pdi_components_work *w)
{
    for (int r = 0; r < w->rows; r++) {
        double minus = 0.0;
        int against = 0;
        for (int n = 0; n < w->members; n++) {
            if (!(w->m[r][n] < 0.0)) continue;
            minus -= w->m[r][n] * w->c[n];
            against = 1;
        }
        if (against && !(minus > PDI_COMPONENTS_MIN_CONCENTRATION) &&
            -w->balance[r] > PDI_COMPONENTS_STALLED_TOLERANCE * w->term_size[r])
            return 1;
    }
    return 0;
}

/* Starts the solver state from concentrations c [solutes], without activities: strengths and ln gamma are 0. `total`
 * and the basis are not set. */
static void pdi_components_init_work(const pd_components *s, const double *c, pdi_components_work *w)
{
    w->system = s;
    w->rows = s->equilibrium_components;
    w->members = s->members;
    w->debye = s->debye_hueckel;
    w->other_strength = w->ln_gamma = w->ln_gamma_slope = w->strength = 0.0;
    for (int n = 0; n < s->members; n++) {
        w->charge[n] = s->charge[s->member_solute[n]];
        w->c[n] = pd_max(c[s->member_solute[n]], PDI_COMPONENTS_MIN_CONCENTRATION);
        w->ln_c[n] = log(w->c[n]);
    }
}

/* Sets ionic strength, ln gamma and its slope of the present concentrations; nothing for ideal solutes. */
static void pdi_components_update_activities(pdi_components_work *w)
{
    if (!(w->debye > 0.0)) return;
    w->strength = w->other_strength;
    for (int n = 0; n < w->members; n++) w->strength += 0.5 * pdi_components_compute_square(w->charge[n]) * w->c[n];
    w->ln_gamma = pdi_activity_compute_davies(w->debye, w->strength, &w->ln_gamma_slope);
}

/* Solves once more from equal amounts of all solutes, where members have vanished; *w becomes that solution if it has
 * none that vanish, else it stays. Totals that no concentrations have end there again. */
static void pdi_components_try_equal_amounts(const pd_components *s, pdi_components_work *w)
{
    pdi_components_work anew = *w;
    double c[PD_SPECIES_MAX], others = w->other_strength;
    for (int i = 0; i < s->solutes; i++) c[i] = 1.0;
    pdi_components_init_work(s, c, &anew);
    anew.other_strength = others;
    pdi_components_update_activities(&anew);
    if (pdi_components_solve_members(&anew) && !pdi_components_has_vanished_members(&anew)) *w = anew;
}

PDI_FN pd_status pdi_components_solve(const pd_components *s, const double *total, double *c)
{
    pdi_components_work w;
    double others = 0.0;
    pdi_components_init_work(s, c, &w);
    for (int k = 0; k < s->equilibrium_components; k++) w.total[k] = total[k];
    for (int k = 0; k < s->count; k++)
        if (!(fabs(total[k]) < HUGE_VAL)) return PD_NOT_CONVERGED;
    for (int k = s->equilibrium_components; k < s->count; k++)
        others += 0.5 * pdi_components_compute_square(s->charge[s->component_solute[k]]) * pd_max(total[k], 0.0);
    w.other_strength = others;
    pdi_components_update_activities(&w);
    if (s->members && !pdi_components_solve_members(&w)) {
        if (!(s->debye_hueckel > 0.0)) return PD_NOT_CONVERGED;
        pdi_components_init_work(s, c, &w); /* ideal ones are near, and found from anywhere */
        w.debye = 0.0;
        if (!pdi_components_solve_members(&w)) return PD_NOT_CONVERGED;
        w.debye = s->debye_hueckel;
        w.other_strength = others;
        pdi_components_update_activities(&w);
        if (!pdi_components_solve_members(&w)) return PD_NOT_CONVERGED;
    }
    if (s->members && pdi_components_has_vanished_members(&w)) pdi_components_try_equal_amounts(s, &w);
    for (int n = 0; n < s->members; n++) c[s->member_solute[n]] = w.c[n];
    for (int k = s->equilibrium_components; k < s->count; k++) c[s->component_solute[k]] = pd_max(total[k], 0.0);
    return PD_OK;
}

PDI_FN void pdi_components_compute_derivatives(const pd_components *s, const double *c, double *derivatives)
{
    pdi_components_work w;
    pdi_components_matrix a, b, weight;
    double each[PD_SPECIES_MAX];
    int columns = pdi_components_count_columns(s);
    if (!s->members) return;
    pdi_components_init_work(s, c, &w);
    for (int k = 0; k < s->equilibrium_components; k++) w.total[k] = 0.0;
    for (int k = s->equilibrium_components; k < s->count; k++)
        w.other_strength +=
            0.5 * pdi_components_compute_square(s->charge[s->component_solute[k]]) * c[s->component_solute[k]];
    pdi_components_update_activities(&w);
    pdi_components_update_basis(&w);
    pdi_components_compute_member_derivatives(&w, 1, weight, each);
    for (int r = 0; r < w.rows; r++) {
        for (int k = 0; k < w.rows; k++) {
            a[r][k] = 0.0;
            for (int n = 0; n < w.members; n++) a[r][k] += w.m[r][n] * weight[k][n];
            b[r][k] = w.inverse[r][k];
        }
        b[r][s->equilibrium_components] = 0.0;
        for (int n = 0; n < w.members; n++) b[r][s->equilibrium_components] -= w.m[r][n] * each[n] * w.c[n];
    }
    pdi_components_solve_linear(w.rows, columns, a, b);
    for (int n = 0; n < w.members; n++)
        for (int k = 0; k < columns; k++) {
            double sum = k < s->equilibrium_components ? 0.0 : each[n] * w.c[n];
            for (int r = 0; r < w.rows; r++) sum += weight[r][n] * b[r][k];
            derivatives[n * columns + k] = sum;
        }
}

PDI_FN void pdi_components_compute_derivatives_single(const pd_components *s, const double *c, float *derivatives)
{
    double exact[PD_COMPONENTS_DERIVATIVES];
    int count = s->members * pdi_components_count_columns(s);
    pdi_components_compute_derivatives(s, c, exact);
    for (int k = 0; k < count; k++) derivatives[k] = (float)exact[k];
}

PDI_FN void pdi_components_apply_derivatives(const pd_components *s, const float *derivatives, const double *total,
                                             double *c)
{
    int columns = pdi_components_count_columns(s);
    double others = columns > s->equilibrium_components ? pdi_components_compute_other_strength(s, total) : 0.0;
    for (int n = 0; n < s->members; n++) {
        double sum =
            columns > s->equilibrium_components ? (double)derivatives[s->equilibrium_components] * others : 0.0;
        for (int k = 0; k < s->equilibrium_components; k++) sum += (double)derivatives[k] * total[k];
        c[s->member_solute[n]] = sum;
        derivatives += columns;
    }
    for (int k = s->equilibrium_components; k < s->count; k++) c[s->component_solute[k]] = total[k];
}

/* c^n; *derivative: its derivative by c. */
static double pdi_components_compute_power(double c, double n, double *derivative)
{
    if (n == 1.0) {
        *derivative = 1.0;
        return c;
    }
    *derivative = n * pow(c, n - 1.0);
    return pow(c, n);
}

PDI_FN double pdi_components_compute_rate(const pd_components *s, const pd_kinetic *kinetic, const double *c,
                                          double *derivatives, double *gross_rate)
{
    double product[2], constant[2], power[PD_SPECIES_MAX], slope[PD_SPECIES_MAX], davies_slope;
    double davies = pdi_components_compute_davies(s, c, &davies_slope);
    constant[0] = kinetic->forward;
    constant[1] = kinetic->backward;
    for (int way = 0; way < 2 && s->debye_hueckel > 0.0; way++)
        constant[way] *= exp(kinetic->salt_exponent[way] * davies);
    memcpy(product, constant, sizeof product);
    for (int i = 0; i < s->solutes; i++) {
        if (kinetic->nu[i] == 0.0) continue;
        power[i] = pdi_components_compute_power(c[i], fabs(kinetic->nu[i]), &slope[i]);
        product[kinetic->nu[i] > 0.0] *= power[i];
    }
    for (int i = 0; i < s->solutes && derivatives; i++) {
        int way = kinetic->nu[i] > 0.0;
        derivatives[i] = 0.5 * pdi_components_compute_square(s->charge[i]) * davies_slope *
                         (kinetic->salt_exponent[0] * product[0] - kinetic->salt_exponent[1] * product[1]);
        if (kinetic->nu[i] == 0.0) continue;
        double rest = (way ? -constant[1] : constant[0]) * slope[i];
        for (int j = 0; j < s->solutes; j++)
            if (j != i && kinetic->nu[j] != 0.0 && (kinetic->nu[j] > 0.0) == way) rest *= power[j];
        derivatives[i] += rest;
    }
    if (gross_rate) *gross_rate = fabs(product[0]) + fabs(product[1]);
    return product[0] - product[1];
}

/* Extent [mol/m3] of a kinetic reaction that makes solutes of the solvent alone, in its ideal equilibrium from nothing,
 * negative where they are on its left. 0: it needs solutes on both sides, has none, or lacks a positive rate constant
 * back. */
static double pdi_components_compute_dissociation(const pd_components *s, const pd_kinetic *kinetic)
{
    double order[2] = {0.0, 0.0}, product[2];
    product[0] = kinetic->forward;
    product[1] = kinetic->backward;
    for (int i = 0; i < s->solutes; i++) {
        double n = fabs(kinetic->nu[i]);
        if (!(n > 0.0)) continue;
        order[kinetic->nu[i] > 0.0] += n;
        product[kinetic->nu[i] > 0.0] *= pow(n, n);
    }
    int way = order[1] > 0.0;
    if (order[!way] > 0.0 || !(order[way] > 0.0) || !(product[way] > 0.0)) return 0.0;
    double extent = pow(product[!way] / product[way], 1.0 / order[way]);
    return way ? extent : -extent;
}

PDI_FN pd_status pdi_components_solve_pure_solvent(const pd_components *s, double *c)
{
    double total[PD_SPECIES_MAX] = {0.0};
    for (int i = 0; i < PD_SPECIES_MAX; i++) c[i] = 1.0; /* from nothing no equilibrium is found */
    for (int r = 0; r < s->kinetics; r++) {
        double extent = pdi_components_compute_dissociation(s, &s->kinetic[r]);
        for (int k = 0; k < s->count; k++) total[k] += s->kinetic[r].total_change[k] * extent;
    }
    pd_status status = pdi_components_solve(s, total, c);
    if (status != PD_OK) memset(c, 0, PD_SPECIES_MAX * sizeof *c);
    return status;
}

/* ---- the system ---- */

/* Equilibrium reactions among solutes during elimination. */
typedef struct pdi_components_reactions {
    int rows;
    double nu[PD_REACTION_MAX][PD_SPECIES_MAX], ln_k[PD_REACTION_MAX];
    int product[PD_REACTION_MAX]; /* solute; -1: none */
    const char *name[PD_REACTION_MAX];
} pdi_components_reactions;

/* A candidate pivot: a solute that a reaction can make, and what decides on it. */
typedef struct pdi_components_pivot {
    int row, solute, same_side, rank;
    double cost, ln_k;
} pdi_components_pivot;

/* 1: pivot a is better than b, or there is no b: in order, a lower cost (number of reactions with the solute, plus the
 * distance of its number from 1), fewer other solutes on its side, the later name in the alphabet, a smaller |ln K|. So
 * the order of species and reactions does not matter. */
static int pdi_components_is_better_pivot(const pdi_components_pivot *a, const pdi_components_pivot *b)
{
    if (b->row < 0 || a->cost < b->cost || a->cost > b->cost) return b->row < 0 || a->cost < b->cost;
    if (a->same_side != b->same_side) return a->same_side < b->same_side;
    if (a->rank != b->rank) return a->rank > b->rank;
    return fabs(a->ln_k) < fabs(b->ln_k);
}

/* Number of other solutes on the same side of reaction r as solute i. */
static int pdi_components_count_same_side(const pd_components *s, const pdi_components_reactions *e, int r, int i)
{
    int count = -1;
    for (int j = 0; j < s->solutes; j++)
        if (fabs(e->nu[r][j]) > PDI_COMPONENTS_ROUNDING_ZERO && (e->nu[r][j] > 0.0) == (e->nu[r][i] > 0.0)) count++;
    return count;
}

/* Next pivot: a reaction without product, and the solute that it makes; row -1: the reactions that are left are
 * empty. */
static pdi_components_pivot pdi_components_find_pivot(const pd_components *s, const pdi_components_reactions *e,
                                                      const int *rank)
{
    pdi_components_pivot best = {-1, -1, 0, 0, 0.0, 0.0};
    for (int r = 0; r < e->rows; r++) {
        for (int i = 0; i < s->solutes && e->product[r] < 0; i++) {
            if (!(fabs(e->nu[r][i]) > PDI_COMPONENTS_ROUNDING_ZERO)) continue;
            pdi_components_pivot now = {r,
                                        i,
                                        pdi_components_count_same_side(s, e, r, i),
                                        rank[i],
                                        fabs(fabs(e->nu[r][i]) - 1.0),
                                        e->ln_k[r] / e->nu[r][i]};
            for (int k = 0; k < e->rows; k++) now.cost += fabs(e->nu[k][i]) > PDI_COMPONENTS_ROUNDING_ZERO ? 1.0 : 0.0;
            if (pdi_components_is_better_pivot(&now, &best)) best = now;
        }
    }
    return best;
}

/* rank [solutes] = position of their names in alphabetical order among the solutes. count: of species. */
static void pdi_components_compute_name_ranks(const pd_species *species, int count, const pd_components *s, int *rank)
{
    for (int i = 0; i < count; i++) {
        int before = 0;
        if (s->solute_of_species[i] < 0) continue;
        for (int j = 0; j < count; j++) {
            int sign = s->solute_of_species[j] < 0 ? 1 : strcmp(species[j].name, species[i].name);
            before += sign < 0 || (sign == 0 && j < i);
        }
        rank[s->solute_of_species[i]] = before;
    }
}

/* Eliminates the solute that reaction r makes from all others, numbers and ln K; its own number in r becomes 1. Numbers
 * below PDI_COMPONENTS_ROUNDING_ZERO become 0. */
static void pdi_components_remove_product(const pd_components *s, pdi_components_reactions *e, int r)
{
    int made = e->product[r];
    double scale = 1.0 / e->nu[r][made];
    for (int i = 0; i < s->solutes; i++) e->nu[r][i] *= scale;
    e->ln_k[r] *= scale;
    for (int k = 0; k < e->rows; k++) {
        double factor = e->nu[k][made];
        if (k == r || factor == 0.0) continue;
        for (int i = 0; i < s->solutes; i++) {
            e->nu[k][i] -= factor * e->nu[r][i];
            if (fabs(e->nu[k][i]) < PDI_COMPONENTS_ROUNDING_ZERO) e->nu[k][i] = 0.0;
        }
        e->ln_k[k] -= factor * e->ln_k[r];
    }
}

/* Numbers the components, joined ones first, lists the members, and fills stoichiometry and ln_k of (7.8), with
 * mol/m3. */
static void pdi_components_sort_components(const pdi_components_reactions *e, pd_components *s)
{
    int row[PD_SPECIES_MAX], joined[PD_SPECIES_MAX];
    for (int i = 0; i < s->solutes; i++) {
        row[i] = -1;
        joined[i] = 0;
        for (int r = 0; r < e->rows; r++) {
            if (e->product[r] == i) row[i] = r;
            if (e->product[r] >= 0 && e->nu[r][i] != 0.0) joined[i] = 1;
        }
        if (joined[i]) s->member_solute[s->members++] = i;
    }
    for (int first = 1; first >= 0; first--) {
        for (int i = 0; i < s->solutes; i++)
            if (row[i] < 0 && joined[i] == first) s->component_solute[s->count++] = i;
        if (first) s->equilibrium_components = s->count;
    }
    for (int k = 0; k < s->count; k++)
        for (int i = 0; i < s->solutes; i++) {
            s->stoichiometry[k][i] = i == s->component_solute[k] ? 1.0 : 0.0;
            if (row[i] >= 0) s->stoichiometry[k][i] = -e->nu[row[i]][s->component_solute[k]];
        }
    for (int i = 0; i < s->solutes; i++) {
        double molar = log(PDI_COMPONENTS_MOLAR);
        if (row[i] < 0) continue;
        s->ln_k[i] = e->ln_k[row[i]] + molar;
        for (int k = 0; k < s->count; k++) s->ln_k[i] -= s->stoichiometry[k][i] * molar;
    }
}

/* Adds a reaction: a kinetic one to s, with its salt effect, an equilibrium one to e, without product. PD_ERR_ARGUMENT:
 * it has a species that is neither solute nor solvent. */
static pd_status pdi_components_add_reaction(pd_ctx *ctx, const pd_species *species, int count,
                                             const pd_reaction *reaction, pdi_components_reactions *e, pd_components *s)
{
    double nu[PD_SPECIES_MAX];
    memset(nu, 0, sizeof nu);
    for (int i = 0; i < count; i++)
        if (s->solute_of_species[i] >= 0) nu[s->solute_of_species[i]] = reaction->nu[i];
    for (int i = 0; i < count; i++)
        if (reaction->nu[i] != 0.0 && species[i].phase > PD_PHASE_SOLVENT)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "components", "'%s' has %s, expected solutes and water alone",
                           reaction->name, species[i].name);
    if (reaction->kinetic) {
        pd_kinetic *kinetic = &s->kinetic[s->kinetics++];
        kinetic->forward = reaction->forward;
        kinetic->backward = reaction->backward;
        memcpy(kinetic->nu, nu, sizeof nu);
        pdi_components_compute_salt_effect(s, kinetic);
        return PD_OK;
    }
    memcpy(e->nu[e->rows], nu, sizeof nu);
    e->ln_k[e->rows] = reaction->ln_k;
    e->name[e->rows] = reaction->name;
    e->product[e->rows++] = -1;
    return PD_OK;
}

/* pdi_components_build without activities: sizes, solutes, reactions, elimination, totals. PD_ERR_ARGUMENT: as there. s
 * is zero at the start; the caller clears it after an error. */
static pd_status pdi_components_try_build(pd_ctx *ctx, const pd_species *species, int count,
                                          const pd_reaction *reactions, int reaction_count, pd_components *s)
{
    pdi_components_reactions e;
    int rank[PD_SPECIES_MAX];
    memset(&e, 0, sizeof e);
    if (count < 1 || count > PD_SPECIES_MAX || reaction_count < 0 || reaction_count > PD_REACTION_MAX)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "components",
                       "%d species and %d reactions, expected 1 to %d species and "
                       "at most %d reactions",
                       count, reaction_count, PD_SPECIES_MAX, PD_REACTION_MAX);
    for (int i = 0; i < count; i++) {
        s->solute_of_species[i] = -1;
        if (species[i].phase == PD_PHASE_SOLVENT || species[i].phase == PD_PHASE_SOLID) continue;
        if (species[i].phase != PD_PHASE_SOLUTE)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "components", "%s is no solute, expected solutes, solids and water",
                           species[i].name);
        s->charge[s->solutes] = species[i].charge;
        s->solute_of_species[i] = s->solutes++;
    }
    if (!s->solutes) return pd_fail(ctx, PD_ERR_ARGUMENT, "components", "there is no solute");
    for (int r = 0; r < reaction_count; r++)
        PD_TRY(pdi_components_add_reaction(ctx, species, count, &reactions[r], &e, s));
    pdi_components_compute_name_ranks(species, count, s, rank);
    for (;;) {
        pdi_components_pivot next = pdi_components_find_pivot(s, &e, rank);
        if (next.row < 0) break;
        e.product[next.row] = next.solute;
        pdi_components_remove_product(s, &e, next.row);
    }
    for (int r = 0; r < e.rows; r++)
        if (e.product[r] < 0 && fabs(e.ln_k[r]) > PDI_COMPONENTS_ROUNDING_ZERO)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "components", "'%s' is the sum of others, and its K is not the "
                           "product of theirs: leave one out", e.name[r]);
    pdi_components_sort_components(&e, s);
    for (int r = 0; r < s->kinetics; r++)
        pdi_components_compute_totals(s, s->kinetic[r].nu, s->kinetic[r].total_change);
    return PD_OK;
}

PDI_FN pd_status pdi_components_build(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *reactions,
                                      int reaction_count, pd_activity activity, double temperature, pd_components *s)
{
    memset(s, 0, sizeof *s);
    pd_status status = pdi_components_try_build(ctx, species, count, reactions, reaction_count, s);
    if (status < 0) memset(s, 0, sizeof *s);
    else if (activity == PD_ACTIVITY_DAVIES) s->debye_hueckel = pdi_activity_compute_debye_hueckel(temperature);
    return status;
}
