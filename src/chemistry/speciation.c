/* speciation: see speciation.h */
#include "chemistry/speciation.h"
#include <math.h>
#include <string.h>

#define PDI_SPECIATION_MAX_NEWTON 600       /* most Newton steps for one set of present minerals */
#define PDI_SPECIATION_MAX_CHANGES 100      /* most changes of the set of present minerals */
#define PDI_SPECIATION_ROUNDING_ZERO 1e-9   /* a combination of stoichiometric numbers below this is zero */
#define PDI_SPECIATION_NEAR_RESIDUAL 1e-7   /* |ln(IAP/K)| from where one more Newton step reaches rounding */
#define PDI_SPECIATION_SUPERSATURATED 1e-10 /* ln(IAP/K) above which a mineral precipitates */
/* part of the reactants that a reaction uses at the start to make absent species */
#define PDI_SPECIATION_SEED_FRACTION 1e-3
#define PDI_SPECIATION_SEED_WATER 1e-4         /* [mol/m3] extent at the start of a reaction of water alone */
#define PDI_SPECIATION_MIN_LEFT 0.05           /* least part of a concentration that a step leaves */
#define PDI_SPECIATION_MAX_TAKEN 0.9           /* most of a concentration that one reaction takes in a step */
#define PDI_SPECIATION_SWAP_RATIO 2.0          /* a formed species above this many times a basis species replaces it */
#define PDI_SPECIATION_MAX_HALVINGS 60         /* most halvings of a step */
#define PDI_SPECIATION_MAX_BOUNDED_HALVINGS 6  /* most halvings of a bounded step, before the Newton step is tried */
#define PDI_SPECIATION_SUFFICIENT_DECREASE 0.1 /* part of a full step by which the residual has to fall */
#define PDI_SPECIATION_MOLAR 1e3 /* [mol/m3] one mol/L */

/* State of a species in the active set. */
typedef enum pdi_speciation_state {
    PDI_SPECIATION_IMPOSSIBLE = 0, /* zero, and no reaction can make it */
    PDI_SPECIATION_ABSENT,         /* a mineral that is not present */
    PDI_SPECIATION_SOLUTE,         /* a solute, an unknown */
    PDI_SPECIATION_UNIT_ACTIVITY   /* activity 1: water, a mineral that is present */
} pdi_speciation_state;

/* Solver state: reduced reactions, each of which makes one species, its pivot, of others that are no pivots. */
typedef struct pdi_speciation_work {
    const pd_speciation *system;
    double amount[PD_SPECIES_MAX]; /* [mol/m3] */
    double ln_c[PD_SPECIES_MAX];   /* ln of mol/L, of solutes */
    int state[PD_SPECIES_MAX];
    double row[PD_REACTION_MAX][PD_SPECIES_MAX], ln_k[PD_REACTION_MAX];
    int pivot[PD_REACTION_MAX]; /* -1: none */
    int rows;
} pdi_speciation_work;

/* Ionic strength [mol/m3] of the solutes that are present. */
static double pdi_speciation_compute_ionic_strength(const pdi_speciation_work *w)
{
    double sum = 0.0;
    for (int i = 0; i < w->system->species; i++)
        if (w->state[i] == PDI_SPECIATION_SOLUTE)
            sum += 0.5 * w->system->charge[i] * w->system->charge[i] * w->amount[i];
    return sum;
}

/* ln of the activity of species i, with mol/L: ln_c + z^2 davies of a solute, 0 of others. davies: ln gamma of a unit
 * charge. */
static double pdi_speciation_compute_ln_activity(const pdi_speciation_work *w, int i, double davies)
{
    return w->state[i] == PDI_SPECIATION_SOLUTE ? w->ln_c[i] + davies * w->system->charge[i] * w->system->charge[i]
                                                : 0.0;
}

/* Residual ln(IAP/K) of reduced reaction r (eq. 7.7). */
static double pdi_speciation_compute_ln_ratio(const pdi_speciation_work *w, int r, double davies)
{
    double sum = -w->ln_k[r];
    for (int i = 0; i < w->system->species; i++)
        if (w->row[r][i] != 0.0) sum += w->row[r][i] * pdi_speciation_compute_ln_activity(w, i, davies);
    return sum;
}

/* Gauss-Jordan step: species i becomes the pivot, with the number 1, of that reaction without one in which its number
 * is largest, and leaves all others; nothing where all are at most PDI_SPECIATION_ROUNDING_ZERO in size. */
static void pdi_speciation_set_pivot(pdi_speciation_work *w, int i)
{
    int best = -1;
    double size = PDI_SPECIATION_ROUNDING_ZERO;
    for (int r = 0; r < w->rows; r++) {
        if (w->pivot[r] >= 0 || !(fabs(w->row[r][i]) > size)) continue;
        best = r;
        size = fabs(w->row[r][i]);
    }
    if (best < 0) return;
    double scale = 1.0 / w->row[best][i];
    for (int k = 0; k < w->system->species; k++) w->row[best][k] *= scale;
    w->ln_k[best] *= scale;
    w->row[best][i] = 1.0;
    w->pivot[best] = i;
    for (int r = 0; r < w->rows; r++) {
        double factor = w->row[r][i];
        if (r == best || factor == 0.0) continue;
        for (int k = 0; k < w->system->species; k++) {
            w->row[r][k] -= factor * w->row[best][k];
            if (fabs(w->row[r][k]) < PDI_SPECIATION_ROUNDING_ZERO) w->row[r][k] = 0.0;
        }
        w->ln_k[r] -= factor * w->ln_k[best];
        w->row[r][i] = 0.0;
    }
}

/* Reduces the reactions anew and chooses their pivots: impossible species first, then absent minerals, then solutes
 * from the rarest on. Species of unit activity are none. */
static void pdi_speciation_update_pivots(pdi_speciation_work *w)
{
    int order[PD_SPECIES_MAX], count = 0;
    w->rows = w->system->reactions;
    memcpy(w->row, w->system->nu, sizeof w->row);
    memcpy(w->ln_k, w->system->ln_k, sizeof w->ln_k);
    for (int r = 0; r < w->rows; r++) w->pivot[r] = -1;
    for (int i = 0; i < w->system->species; i++) {
        int k = count;
        if (w->state[i] == PDI_SPECIATION_UNIT_ACTIVITY) continue;
        for (; k > 0; k--) {
            int j = order[k - 1];
            if (w->state[j] < w->state[i] || (w->state[j] == w->state[i] && !(w->ln_c[j] > w->ln_c[i]))) break;
            order[k] = j;
        }
        order[k] = i;
        count++;
    }
    for (int k = 0; k < count; k++) pdi_speciation_set_pivot(w, order[k]);
}

/* 1: reduced reaction r has a solute as its pivot. */
static int pdi_speciation_is_solute_reaction(const pdi_speciation_work *w, int r)
{
    return w->pivot[r] >= 0 && w->state[w->pivot[r]] == PDI_SPECIATION_SOLUTE;
}

/* Adds the extent xi [mol/m3] of a reaction with the numbers nu to the amounts. */
static void pdi_speciation_add_extent(pdi_speciation_work *w, const double *nu, double xi)
{
    for (int i = 0; i < w->system->species; i++) w->amount[i] += nu[i] * xi;
}

/* Adds small extents of reactions until every solute that they can make is present: PDI_SPECIATION_SEED_FRACTION of the
 * scarcest reactant, or PDI_SPECIATION_SEED_WATER where water alone reacts. Elements and charge stay. */
static void pdi_speciation_add_traces(pdi_speciation_work *w)
{
    for (int again = 1; again;) {
        again = 0;
        for (int r = 0; r < w->system->reactions; r++) {
            for (double sign = -1.0; sign < 2.0; sign += 2.0) {
                double most = HUGE_VAL;
                int makes = 0;
                for (int i = 0; i < w->system->species; i++) {
                    double nu = sign * w->system->nu[r][i];
                    if (w->system->phase[i] == PD_PHASE_SOLVENT) continue;
                    if (nu < 0.0) most = pd_min(most, w->amount[i] / -nu);
                    if (nu > 0.0 && !(w->amount[i] > 0.0) && w->system->phase[i] == PD_PHASE_SOLUTE) makes = 1;
                }
                if (!makes || !(most > 0.0)) continue;
                double xi = most < HUGE_VAL ? PDI_SPECIATION_SEED_FRACTION * most : PDI_SPECIATION_SEED_WATER;
                pdi_speciation_add_extent(w, w->system->nu[r], sign * xi);
                again = again || xi > DBL_MIN;
            }
        }
    }
}

/* Sets state and ln_c of every species from its amount. */
static void pdi_speciation_init_states(pdi_speciation_work *w)
{
    for (int i = 0; i < w->system->species; i++) {
        int solute = w->system->phase[i] == PD_PHASE_SOLUTE, there = w->amount[i] > 0.0;
        w->ln_c[i] = solute && there ? log(w->amount[i] / PDI_SPECIATION_MOLAR) : 0.0;
        if (solute) w->state[i] = there ? PDI_SPECIATION_SOLUTE : PDI_SPECIATION_IMPOSSIBLE;
        else if (w->system->phase[i] == PD_PHASE_SOLVENT || there) w->state[i] = PDI_SPECIATION_UNIT_ACTIVITY;
        else w->state[i] = PDI_SPECIATION_ABSENT;
    }
}

/* Solves a x = b of `rows` equations by Gaussian elimination with partial pivoting; x in b, a is overwritten. Returns
 * 1; 0: singular: a pivot is exactly 0 or NaN. */
static int pdi_speciation_solve_linear(int rows, double a[PD_REACTION_MAX][PD_REACTION_MAX], double *b)
{
    for (int c = 0; c < rows; c++) {
        int best = c;
        for (int r = c + 1; r < rows; r++)
            if (fabs(a[r][c]) > fabs(a[best][c])) best = r;
        if (!(fabs(a[best][c]) > 0.0)) return 0;
        for (int k = 0; k < rows; k++) {
            double swap = a[c][k];
            a[c][k] = a[best][k];
            a[best][k] = swap;
        }
        double swap = b[c];
        b[c] = b[best];
        b[best] = swap;
        for (int r = c + 1; r < rows; r++) {
            double factor = a[r][c] / a[c][c];
            for (int k = c; k < rows && factor != 0.0; k++) a[r][k] -= factor * a[c][k];
            b[r] -= factor * b[c];
        }
    }
    for (int r = rows - 1; r >= 0; r--) {
        for (int k = r + 1; k < rows; k++) b[r] -= a[r][k] * b[k];
        b[r] /= a[r][r];
    }
    return 1;
}

/* dy [rows] = Newton step for the logarithms of the pivots of the reactions in `list` (eq. 7.7), with the rank-one
 * term of Davies' equation. off [rows]: residuals; slope [m3/mol]: derivative of ln gamma by the ionic strength, 0 for
 * ideal solutes. Returns 1; 0: the matrix is singular, or the step is not finite. */
static int pdi_speciation_compute_newton_step(const pdi_speciation_work *w, const int *list, int rows,
                                              const double *off, double slope, double *dy)
{
    double a[PD_REACTION_MAX][PD_REACTION_MAX], q[PD_REACTION_MAX];
    for (int r = 0; r < rows; r++) {
        q[r] = 0.0;
        for (int i = 0; i < w->system->species; i++)
            if (w->state[i] == PDI_SPECIATION_SOLUTE)
                q[r] += w->row[list[r]][i] * w->system->charge[i] * w->system->charge[i];
    }
    for (int r = 0; r < rows; r++) {
        for (int k = 0; k < rows; k++) {
            int p = w->pivot[list[k]];
            double sum = 0.5 * slope * q[r] * q[k] * w->amount[p];
            for (int i = 0; i < w->system->species; i++)
                if (w->state[i] == PDI_SPECIATION_SOLUTE && w->row[list[r]][i] != 0.0 && w->row[list[k]][i] != 0.0 &&
                    i != w->pivot[list[r]])
                    sum += w->row[list[r]][i] * w->row[list[k]][i] * (w->amount[p] / w->amount[i]);
            a[r][k] = sum + (r == k ? 1.0 : 0.0);
        }
        dy[r] = -off[r];
    }
    if (!pdi_speciation_solve_linear(rows, a, dy)) return 0;
    for (int r = 0; r < rows; r++)
        if (!(fabs(dy[r]) < HUGE_VAL)) return 0;
    return 1;
}

/* Lowers dy [rows] so that no reaction takes more than the part PDI_SPECIATION_MAX_TAKEN of a solute to make its
 * pivot. */
static void pdi_speciation_limit_changes(const pdi_speciation_work *w, const int *list, int rows, double *dy)
{
    for (int r = 0; r < rows; r++) {
        int p = w->pivot[list[r]];
        double room = HUGE_VAL;
        for (int i = 0; i < w->system->species; i++)
            if (w->state[i] == PDI_SPECIATION_SOLUTE && w->row[list[r]][i] < 0.0)
                room = pd_min(room, PDI_SPECIATION_MAX_TAKEN * w->amount[i] / -w->row[list[r]][i]);
        if (room < HUGE_VAL) dy[r] = pd_min(dy[r], log((w->amount[p] + room) / PDI_SPECIATION_MOLAR) - w->ln_c[p]);
    }
}

/* Moves amounts and ln_c of *w by t dy along the reactions in `list`. 1: done; 0: a solute that is no pivot would fall
 * to PDI_SPECIATION_MIN_LEFT of its amount or below, or an amount overflows; *w is partly moved. Minerals and water may
 * become negative. */
static int pdi_speciation_try_move(pdi_speciation_work *w, const int *list, int rows, const double *dy, double t)
{
    double start[PD_SPECIES_MAX];
    memcpy(start, w->amount, sizeof start);
    for (int r = 0; r < rows; r++) {
        int p = w->pivot[list[r]];
        double made = PDI_SPECIATION_MOLAR * exp(w->ln_c[p] + t * dy[r]) - start[p];
        if (!(made < HUGE_VAL)) return 0;
        w->ln_c[p] += t * dy[r];
        w->amount[p] = PDI_SPECIATION_MOLAR * exp(w->ln_c[p]);
        for (int i = 0; i < w->system->species; i++)
            if (i != p && w->row[list[r]][i] != 0.0) w->amount[i] += w->row[list[r]][i] * made;
    }
    for (int i = 0; i < w->system->species; i++) {
        int pivot = 0;
        for (int r = 0; r < rows; r++) pivot = pivot || w->pivot[list[r]] == i;
        if (pivot || w->state[i] != PDI_SPECIATION_SOLUTE) continue;
        if (!(w->amount[i] > PDI_SPECIATION_MIN_LEFT * start[i]) || !(w->amount[i] < HUGE_VAL)) return 0;
        if (w->amount[i] != start[i]) w->ln_c[i] = log(w->amount[i] / PDI_SPECIATION_MOLAR);
    }
    return 1;
}

/* Residuals off [rows] of the reactions in `list`; returns the largest. */
static double pdi_speciation_compute_residuals(const pdi_speciation_work *w, const int *list, int rows, double *off)
{
    double slope, worst = 0.0;
    double davies =
        w->system->debye_hueckel > 0.0
            ? pdi_activity_compute_davies(w->system->debye_hueckel, pdi_speciation_compute_ionic_strength(w), &slope)
            : 0.0;
    for (int r = 0; r < rows; r++) {
        off[r] = pdi_speciation_compute_ln_ratio(w, list[r], davies);
        worst = pd_max(worst, fabs(off[r]));
    }
    return worst;
}

/* 1: a pivot exceeds PDI_SPECIATION_SWAP_RATIO times a basis solute that forms it: the pivots have to be chosen
 * anew. */
static int pdi_speciation_is_pivot_stale(const pdi_speciation_work *w)
{
    for (int r = 0; r < w->rows; r++) {
        if (!pdi_speciation_is_solute_reaction(w, r)) continue;
        for (int i = 0; i < w->system->species; i++)
            if (w->row[r][i] != 0.0 && w->state[i] == PDI_SPECIATION_SOLUTE && i != w->pivot[r] &&
                w->amount[w->pivot[r]] > PDI_SPECIATION_SWAP_RATIO * w->amount[i])
                return 1;
    }
    return 0;
}

/* Line search along dy, halved from 1, until the slope of the free energy along it, downwards at the start, is upwards
 * by half of that at most, or the residual falls by PDI_SPECIATION_SUFFICIENT_DECREASE of the step; next to the
 * solution any possible step is taken. 1: *w is moved; 0: neither within `halvings` trials, or the free energy rises
 * along dy at once; *w is unchanged. off [rows], worst: residuals, and the largest. */
static int pdi_speciation_try_line_search(pdi_speciation_work *w, const int *list, int rows, const double *dy,
                                          const double *off, double worst, int halvings)
{
    const pdi_speciation_work from = *w;
    double next[PD_REACTION_MAX], before = 0.0, t = 1.0;
    for (int r = 0; r < rows; r++) before += off[r] * w->amount[w->pivot[list[r]]] * dy[r];
    if (before > 0.0 && worst > PDI_SPECIATION_NEAR_RESIDUAL) return 0;
    for (int k = 0; k < halvings; k++, t *= 0.5) {
        double after = 0.0;
        *w = from;
        if (!pdi_speciation_try_move(w, list, rows, dy, t)) continue;
        double now = pdi_speciation_compute_residuals(w, list, rows, next);
        for (int r = 0; r < rows; r++) after += next[r] * w->amount[w->pivot[list[r]]] * dy[r];
        if (worst <= PDI_SPECIATION_NEAR_RESIDUAL || now < (1.0 - PDI_SPECIATION_SUFFICIENT_DECREASE * t) * worst ||
            after <= -0.5 * before)
            return 1;
    }
    *w = from;
    return 0;
}

/* Newton iterations for the solutes with the present minerals, whose amounts may become negative, until one step after
 * the residual is at most PDI_SPECIATION_NEAR_RESIDUAL; PD_OK also ahead of convergence when one is far below 0.
 * *iterations: raised by the steps. PD_NOT_CONVERGED: a singular matrix, no step lowers the residual, or
 * PDI_SPECIATION_MAX_NEWTON steps. */
static pd_status pdi_speciation_solve_solutes(pdi_speciation_work *w, int *iterations)
{
    int list[PD_REACTION_MAX];
    double off[PD_REACTION_MAX], dy[PD_REACTION_MAX], bounded[PD_REACTION_MAX], size = 1.0;
    for (int i = 0; i < w->system->species; i++)
        if (w->system->phase[i] != PD_PHASE_SOLVENT) size += fabs(w->amount[i]);
    for (int round = 0; round < PDI_SPECIATION_MAX_NEWTON; round++) {
        int rows = 0, near;
        double slope = 0.0;
        if (pdi_speciation_is_pivot_stale(w)) pdi_speciation_update_pivots(w);
        for (int r = 0; r < w->rows; r++)
            if (pdi_speciation_is_solute_reaction(w, r)) list[rows++] = r;
        double worst = pdi_speciation_compute_residuals(w, list, rows, off);
        near = worst <= PDI_SPECIATION_NEAR_RESIDUAL;
        if (!(worst > 0.0)) return PD_OK;
        if (w->system->debye_hueckel > 0.0)
            pdi_activity_compute_davies(w->system->debye_hueckel, pdi_speciation_compute_ionic_strength(w), &slope);
        if (!pdi_speciation_compute_newton_step(w, list, rows, off, slope, dy)) return PD_NOT_CONVERGED;
        memcpy(bounded, dy, sizeof bounded);
        pdi_speciation_limit_changes(w, list, rows, bounded);
        if (!pdi_speciation_try_line_search(w, list, rows, bounded, off, worst, PDI_SPECIATION_MAX_BOUNDED_HALVINGS) &&
            !pdi_speciation_try_line_search(w, list, rows, dy, off, worst, PDI_SPECIATION_MAX_HALVINGS))
            return PD_NOT_CONVERGED;
        ++*iterations;
        if (near) return PD_OK;
        for (int i = 0; i < w->system->species; i++) /* far beyond its end */
            if (w->system->phase[i] == PD_PHASE_SOLID && w->amount[i] < -10.0 * size) return PD_OK;
    }
    return PD_NOT_CONVERGED;
}

/* Mineral i becomes absent. */
static void pdi_speciation_remove_mineral(pdi_speciation_work *w, int i)
{
    w->amount[i] = 0.0;
    w->state[i] = PDI_SPECIATION_ABSENT;
}

/* Minerals that cannot be present together at any composition (a reaction without pivot): the side that its K
 * disfavours converts until its first mineral is used up, which becomes absent. 1: one is gone; -1: there is no mineral
 * on that side, so nothing ends it; 0: there are none. */
static int pdi_speciation_try_convert_minerals(pdi_speciation_work *w)
{
    for (int r = 0; r < w->rows; r++) {
        int first = -1;
        double most = HUGE_VAL, sign = w->ln_k[r] < 0.0 ? -1.0 : 1.0;
        if (w->pivot[r] >= 0) continue;
        for (int i = 0; i < w->system->species; i++)
            if (w->system->phase[i] == PD_PHASE_SOLID && sign * w->row[r][i] < 0.0 &&
                w->amount[i] / (-sign * w->row[r][i]) < most) {
                first = i;
                most = w->amount[i] / (-sign * w->row[r][i]);
            }
        if (first < 0) {
            for (int i = 0; i < w->system->species; i++)
                if (w->row[r][i] != 0.0) return -1;
            continue; /* the sum of others */
        }
        pdi_speciation_add_extent(w, w->row[r], sign * most);
        pdi_speciation_remove_mineral(w, first);
        return 1;
    }
    return 0;
}

/* Finds the mineral that is used up first on the way from n0 to the present amounts, goes back to that point and makes
 * it absent. Returns its index; -1: there is none, nothing changes. */
static int pdi_speciation_remove_exhausted_mineral(pdi_speciation_work *w, const double *n0)
{
    int first = -1;
    double share = 1.0;
    for (int i = 0; i < w->system->species; i++) {
        if (w->state[i] != PDI_SPECIATION_UNIT_ACTIVITY || w->system->phase[i] != PD_PHASE_SOLID || w->amount[i] >= 0.0)
            continue;
        double t = n0[i] / (n0[i] - w->amount[i]);
        if (first >= 0 && t >= share) continue;
        first = i;
        share = t;
    }
    if (first < 0) return -1;
    for (int i = 0; i < w->system->species; i++) {
        w->amount[i] = n0[i] + share * (w->amount[i] - n0[i]);
        if (w->state[i] == PDI_SPECIATION_SOLUTE && w->amount[i] > 0.0)
            w->ln_c[i] = log(w->amount[i] / PDI_SPECIATION_MOLAR);
        /* rounding of one at its end */
        if (w->system->phase[i] == PD_PHASE_SOLID) w->amount[i] = pd_max(w->amount[i], 0.0);
    }
    pdi_speciation_remove_mineral(w, first);
    return first;
}

/* Sets log_activity, strength and residual of the result; returns the absent mineral of largest ln(IAP/K) above
 * PDI_SPECIATION_SUPERSATURATED, other than `spared`; -1: none. Pivots are chosen anew. */
static int pdi_speciation_find_supersaturated(pdi_speciation_work *w, int spared, pd_speciation_result *result)
{
    double slope, most = PDI_SPECIATION_SUPERSATURATED;
    int best = -1;
    result->strength = pdi_speciation_compute_ionic_strength(w);
    double davies = w->system->debye_hueckel > 0.0
                        ? pdi_activity_compute_davies(w->system->debye_hueckel, result->strength, &slope)
                        : 0.0;
    pdi_speciation_update_pivots(w);
    result->residual = 0.0;
    for (int i = 0; i < w->system->species; i++)
        result->log_activity[i] = w->state[i] == PDI_SPECIATION_IMPOSSIBLE || w->state[i] == PDI_SPECIATION_ABSENT
                                      ? -HUGE_VAL
                                      : pdi_speciation_compute_ln_activity(w, i, davies) / log(10.0);
    for (int r = 0; r < w->rows; r++) {
        int i = w->pivot[r];
        if (i < 0 || w->state[i] == PDI_SPECIATION_IMPOSSIBLE) continue;
        double off = pdi_speciation_compute_ln_ratio(w, r, davies);
        if (w->state[i] == PDI_SPECIATION_SOLUTE) {
            result->residual = pd_max(result->residual, fabs(off));
            continue;
        }
        result->log_activity[i] = -off / log(10.0);
        if (-off > most && i != spared) {
            most = -off;
            best = i;
        }
    }
    return best;
}

pd_status pd_speciation_solve(const pd_speciation *s, double *c, pd_speciation_result *result)
{
    pdi_speciation_work w;
    int added = -1, spared = -1;
    memset(result, 0, sizeof *result);
    memset(&w, 0, sizeof w);
    w.system = s;
    for (int i = 0; i < s->species; i++) {
        if ((!(c[i] >= 0.0) && s->phase[i] != PD_PHASE_SOLVENT) || !(fabs(c[i]) < HUGE_VAL)) return PD_ERR_ARGUMENT;
        w.amount[i] = c[i];
    }
    pdi_speciation_add_traces(&w);
    pdi_speciation_init_states(&w);
    for (; result->mineral_changes < PDI_SPECIATION_MAX_CHANGES; result->mineral_changes++) {
        double n0[PD_SPECIES_MAX];
        pdi_speciation_update_pivots(&w);
        int gone = pdi_speciation_try_convert_minerals(&w);
        if (gone < 0) return PD_NOT_CONVERGED;
        if (gone) continue;
        memcpy(n0, w.amount, sizeof n0);
        pd_status status = pdi_speciation_solve_solutes(&w, &result->iterations);
        if (status != PD_OK) return status;
        int first = pdi_speciation_remove_exhausted_mineral(&w, n0);
        if (first >= 0) {
            if (first == added) spared = first; /* at its saturation, to rounding */
            continue;
        }
        added = pdi_speciation_find_supersaturated(&w, spared, result);
        if (added < 0) {
            memcpy(c, w.amount, (size_t)s->species * sizeof *c);
            return PD_OK;
        }
        w.state[added] = PDI_SPECIATION_UNIT_ACTIVITY;
    }
    return PD_NOT_CONVERGED;
}

/* pd_speciation_build without activities. PD_ERR_ARGUMENT: as there. s is zero at the start; the caller clears it after
 * an error. */
static pd_status pdi_speciation_try_build(pd_ctx *ctx, const pd_species *species, int count,
                                          const pd_reaction *reactions, int reaction_count, pd_speciation *s)
{
    pdi_speciation_work w;
    if (count < 1 || count > PD_SPECIES_MAX || reaction_count < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "speciation",
                       "%d species and %d reactions, expected 1 to %d "
                       "species",
                       count, reaction_count, PD_SPECIES_MAX);
    s->species = count;
    for (int i = 0; i < count; i++) {
        s->charge[i] = species[i].charge;
        s->phase[i] = (int)species[i].phase;
    }
    for (int r = 0; r < reaction_count; r++) {
        if (reactions[r].kinetic) continue;
        if (s->reactions == PD_REACTION_MAX)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "speciation", "more than %d reactions in equilibrium",
                           PD_REACTION_MAX);
        for (int i = 0; i < count; i++) {
            if (reactions[r].nu[i] == 0.0 || s->phase[i] <= PD_PHASE_SOLID) continue;
            return pd_fail(ctx, PD_ERR_ARGUMENT, "speciation", "'%s' is in equilibrium with %s, expected solutes, "
                           "water "
                           "and solids alone", reactions[r].name, species[i].name);
        }
        memcpy(s->nu[s->reactions], reactions[r].nu, sizeof reactions[r].nu);
        s->ln_k[s->reactions++] = reactions[r].ln_k;
    }
    memset(&w, 0, sizeof w);
    w.system = s;
    for (int i = 0; i < count; i++) w.state[i] = PDI_SPECIATION_SOLUTE;
    pdi_speciation_update_pivots(&w);
    for (int r = 0; r < w.rows; r++)
        if (w.pivot[r] < 0 && fabs(w.ln_k[r]) > PDI_SPECIATION_NEAR_RESIDUAL)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "speciation", "a reaction is the sum of others, and its K is not the "
                           "product of theirs: leave one out");
    return PD_OK;
}

pd_status pd_speciation_build(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *reactions,
                              int reaction_count, pd_activity activity, double temperature, pd_speciation *s)
{
    memset(s, 0, sizeof *s);
    pd_status status = pdi_speciation_try_build(ctx, species, count, reactions, reaction_count, s);
    if (status < 0) memset(s, 0, sizeof *s);
    else if (activity == PD_ACTIVITY_DAVIES) s->debye_hueckel = pdi_activity_compute_debye_hueckel(temperature);
    return status;
}
