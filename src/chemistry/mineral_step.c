/* mineral_step: see mineral_step.h */
#include "chemistry/mineral_step.h"
#include "core/root_bracket.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PDI_MINERAL_STEP_INFEASIBLE (-1e3)    /* ln Omega - law where totals have no concentrations */
#define PDI_MINERAL_STEP_MAX_SWEEPS 200       /* most sweeps over all minerals */
#define PDI_MINERAL_STEP_MAX_SOLVES 500       /* most equilibria that are solved for the minerals of a volume */
#define PDI_MINERAL_STEP_LOOSE_TOLERANCE 1e-4 /* |ln Omega - law| accepted when the equilibria are used up */
/* |ln Omega - law| below which its derivative tells what rounding of amounts changes */
#define PDI_MINERAL_STEP_REGULAR_RESIDUAL 1.0
#define PDI_MINERAL_STEP_FILL_TOLERANCE 1e-12 /* [-] part of the free volume within which several minerals fill it */
#define PDI_MINERAL_STEP_ROUNDING 16.0        /* rounding units of the totals within which amounts are equal */
#define PDI_MINERAL_STEP_MIN_FRACTION 1e-4    /* shortest fraction of a Newton step */
#define PDI_MINERAL_STEP_MAX_LEFT 0.99        /* most of the residual that an accepted step leaves */
/* residual below which PDI_MINERAL_STEP_MAX_LEFT_NEAR holds: what remains is rounding */
#define PDI_MINERAL_STEP_NEAR_RESIDUAL 1e-11
#define PDI_MINERAL_STEP_MAX_LEFT_NEAR 0.5 /* most of such a residual that an accepted step leaves */
#define PDI_MINERAL_STEP_FIRST_STEP 1e-3   /* [-] first step of a search without bounds, over the totals */

/* Solver state of one volume. */
typedef struct pdi_mineral_step_work {
    const pd_components *c;
    const pd_minerals *m;
    const pd_mineral_start *start;
    double base_amount[PD_MINERAL_MAX]; /* [mol/m3] amounts that `total` belongs to */
    double total[PD_SPECIES_MAX];       /* [mol/m3] dissolved with these */
    /* [mol/m3] amounts above base_amount: beside much of a mineral they are far smaller */
    double growth[PD_MINERAL_MAX];
    double amount[PD_MINERAL_MAX], conc[PD_SPECIES_MAX]; /* n: base_amount + growth, but for rounding */
    double guess[PD_SPECIES_MAX];                        /* [mol/m3] to begin from anew */
    int infeasible;                                      /* 1: the last amounts have no concentrations */
    int solves_left;                                     /* number of equilibria that may still be solved */
} pdi_mineral_step_work;

/* Residual of (7.16): ln Omega of mineral s less that of its law at amount n, `over` [mol/m3] above that of the start.
 * Without rate, since none has no surface: HUGE_VAL or -HUGE_VAL, towards the amount of the start. */
static double pdi_mineral_step_compute_law_residual(const pd_components *c, const pd_minerals *m,
                                                    const pd_mineral_start *start, int s, const double *conc, double n,
                                                    double over)
{
    double rate = pdi_mineral_compute_max_extent(start, s, n), off = pdi_mineral_compute_ln_omega(c, m, s, conc);
    /* none has no surface */
    if (!(rate > 0.0) && start->amount_rate[s] > 0.0) return over < 0.0 ? HUGE_VAL : -HUGE_VAL;
    return rate < HUGE_VAL ? off - log1p(pd_max(over / rate, -1.0)) / m->mineral[s].exponent : off;
}

/* Sets the growth of mineral s [mol/m3], and its amount. */
static void pdi_mineral_step_set_growth(pdi_mineral_step_work *w, int s, double grown)
{
    w->growth[s] = grown;
    w->amount[s] = pd_max(w->base_amount[s] + grown, 0.0);
}

/* Amount of mineral s above that of the start of the step [mol/m3]. */
static double pdi_mineral_step_get_excess(const pdi_mineral_step_work *w, int s)
{
    return w->amount[s] > 0.0 ? w->growth[s] + (w->base_amount[s] - w->start->start_amount[s])
                              : -w->start->start_amount[s];
}

/* Residual of (7.16) of mineral s with the concentrations for this growth; it falls with the growth. Sets growth,
 * amount, conc and `infeasible` of w, and counts one solve. PDI_MINERAL_STEP_INFEASIBLE: there are no concentrations,
 * conc is the guess. */
static double pdi_mineral_step_compute_growth_residual(pdi_mineral_step_work *w, int s, double grown)
{
    double total[PD_SPECIES_MAX];
    w->solves_left--;
    pdi_mineral_step_set_growth(w, s, grown);
    for (int k = 0; k < w->c->count; k++) {
        total[k] = w->total[k];
        for (int t = 0; t < w->m->count; t++) total[k] -= w->m->total_content[t][k] * w->growth[t];
    }
    w->infeasible = pdi_components_solve(w->c, total, w->conc) != PD_OK;
    if (w->infeasible) memcpy(w->conc, w->guess, sizeof w->conc);
    if (w->infeasible) return PDI_MINERAL_STEP_INFEASIBLE;
    return pdi_mineral_step_compute_law_residual(w->c, w->m, w->start, s, w->conc, w->amount[s],
                                                 pdi_mineral_step_get_excess(w, s));
}

/* Bounds of the growth of mineral s with those of others fixed: least, most by the totals (-HUGE_VAL, HUGE_VAL: none),
 * room by the free volume, or the limits of start. Totals bound only where no solute counts negative and no mineral
 * counts against s. room lets the amount before the step stay; HUGE_VAL without volume. */
static void pdi_mineral_step_compute_growth_bounds(const pdi_mineral_step_work *w, int s, double *least, double *most,
                                                   double *room)
{
    double taken = 0.0;
    *least = -HUGE_VAL;
    *most = HUGE_VAL;
    for (int k = 0; k < w->c->count; k++) {
        double there = w->total[k], gain = w->m->total_content[s][k];
        int signs = 0;
        for (int i = 0; i < w->c->solutes; i++) signs |= w->c->stoichiometry[k][i] < 0.0;
        if (signs || gain == 0.0) continue;
        for (int t = 0; t < w->m->count; t++) {
            if (w->m->total_content[t][k] * gain < 0.0) signs = 1;
            if (t != s) there -= w->m->total_content[t][k] * w->growth[t];
        }
        if (!signs && gain > 0.0) *most = pd_min(*most, there / gain);
        if (!signs && gain < 0.0) *least = pd_max(*least, there / gain);
    }
    if (!(*least < *most)) *least = -HUGE_VAL;
    for (int t = 0; t < w->m->count; t++)
        if (t != s) taken += w->m->mineral[t].volume * w->amount[t];
    *room = w->start->has_limits ? w->start->limit[s] - w->base_amount[s] : HUGE_VAL;
    if (!(w->m->mineral[s].volume > 0.0) || w->start->has_limits) return;
    *room = pd_max((1.0 - w->m->mineral[s].min_porosity - taken) / w->m->mineral[s].volume, 0.0);
    *room = pd_max(*room, w->start->initial[s]) - w->base_amount[s]; /* what is there stays */
}

/* Brackets the growth of mineral s between x[0], where the residual f[0] is positive, and x[1]; raises x[0]. x[1] is
 * the bound by `most`, `room` or the law, or without any grows fourfold. 1: f[1] is not positive; 0: it is positive up
 * to x[1], so the growth is at its bound. */
static int pdi_mineral_step_find_growth_bracket(pdi_mineral_step_work *w, int s, double most, double room, double *x,
                                                double *f)
{
    double index = w->m->mineral[s].exponent * pdi_mineral_compute_ln_omega(w->c, w->m, s, w->conc), size = 0.0;
    double law = w->start->start_amount[s] - w->base_amount[s] +
                 pdi_mineral_compute_growth(w->start, s, expm1(pd_min(index, 700.0)));
    double top = pd_min(pd_min(room, most), law > x[0] ? law : HUGE_VAL);
    for (int k = 0; k < w->c->count; k++) size = pd_max(size, fabs(w->total[k]));
    for (double step = PDI_MINERAL_STEP_FIRST_STEP * (size + w->base_amount[s] + x[0]);; step *= 4.0) {
        x[1] = top < HUGE_VAL ? top : pd_min(x[0] + step, room);
        f[1] = pdi_mineral_step_compute_growth_residual(w, s, x[1]);
        if (!(f[1] > 0.0)) return 1;
        if (x[1] >= room || top < HUGE_VAL || !(step < 1e100)) return 0;
        x[0] = x[1];
        f[0] = f[1];
    }
}

/* Next point in the bracket of a growth: secant in ln((n - least)/(most - n)), in which the law is nearly linear. */
static double pdi_mineral_step_interpolate_bracket(const pdi_root_bracket *b, double least, double most, double next)
{
    double ends[2] = {b->a, b->b}, ratio[2], width = most - least;
    int below = least > -HUGE_VAL, above = most < HUGE_VAL;
    if (!below && !above) return next;
    for (int k = 0; k < 2; k++) {
        double low = below ? pd_max(ends[k] - least, DBL_EPSILON * fabs(least)) : 1.0;
        double high = above ? pd_max(most - ends[k], DBL_EPSILON * fabs(most)) : 1.0;
        ratio[k] = log(low) - log(high);
    }
    double at = exp(ratio[0] + pdi_root_bracket_compute_fraction(b) * (ratio[1] - ratio[0])), x;
    if (!below) x = most - 1.0 / at;
    else if (!above) x = least + at;
    else x = at < 1.0 ? least + width * (at / (1.0 + at)) : most - width / (1.0 + at);
    return x > b->a && x < b->b ? x : next;
}

/* Solves for the growth of mineral s with those of the others fixed, within its bounds, to PDI_MINERAL_TOLERANCE or
 * rounding; w has its amount and concentrations then. A mineral that does not react gets the amount of the start. It
 * stays at a bound towards which its residual points. solves_left becomes 0 where a single mineral dissolves too slowly
 * for the totals to hold the rest. */
static void pdi_mineral_step_solve_one(pdi_mineral_step_work *w, int s)
{
    double start = w->start->start_amount[s], least, most, room, x[2], f[2];
    double rate = w->start->rate[s] < HUGE_VAL ? -pdi_mineral_compute_growth(w->start, s, -1.0) : HUGE_VAL;
    if (!pdi_mineral_is_reactive(w->start, s)) {
        pdi_mineral_step_set_growth(w, s, pd_max(start, 0.0) - w->base_amount[s]);
        return;
    }
    pdi_mineral_step_compute_growth_bounds(w, s, &least, &most, &room);
    x[0] = start > rate ? pd_min((start - w->base_amount[s]) - rate, room) : pd_min(-w->base_amount[s], room);
    if (start > rate && w->m->count == 1 &&
        x[0] - most > PDI_MINERAL_STEP_ROUNDING * DBL_EPSILON * (fabs(x[0]) + fabs(most) + w->base_amount[s])) {
        w->solves_left = 0; /* its speed leaves more of it than totals hold */
        return;
    }
    if (least > x[0] && least < room) x[0] = least; /* below it nothing is left that it needs to dissolve */
    f[0] = pdi_mineral_step_compute_growth_residual(w, s, x[0]);
    if (!(f[0] > 0.0) || x[0] >= room) return;
    if (!pdi_mineral_step_find_growth_bracket(w, s, most, room, x, f)) return;
    pdi_root_bracket b = {x[0], f[0], x[1], f[1], 0, 0};
    double next;
    while (w->solves_left > 0 && pdi_root_bracket_get_next(&b, &next)) {
        next = pdi_mineral_step_interpolate_bracket(&b, least, most, next);
        double off = pdi_mineral_step_compute_growth_residual(w, s, next);
        if (fabs(off) < PDI_MINERAL_TOLERANCE) return;
        pdi_root_bracket_update(&b, next, off);
    }
    pdi_mineral_step_compute_growth_residual(w, s, fabs(b.value_a) < fabs(b.value_b) ? b.a : b.b);
}

/* ---- derivatives ---- */
/* slope [components] [m3/mol] = derivatives of ln Omega of mineral s by the totals; table: dc/dT of the concentrations
 * (pdi_components_compute_derivatives). */
static void pdi_mineral_step_compute_omega_gradient(const pd_components *c, const pd_minerals *m, int s,
                                                    const double *table, const double *conc, double *slope)
{
    int columns = pdi_components_count_columns(c);
    double strength = 0.0, davies = 0.0, share[PD_SPECIES_MAX], others = 0.0;
    for (int i = 0; i < c->solutes; i++) strength += 0.5 * (double)(c->charge[i] * c->charge[i]) * pd_max(conc[i], 0.0);
    if (c->debye_hueckel > 0.0) pdi_activity_compute_davies(c->debye_hueckel, strength, &davies);
    for (int i = 0; i < c->solutes; i++) {
        share[i] = m->charge_square[s] * davies * 0.5 * (double)(c->charge[i] * c->charge[i]);
        if (m->nu[s][i] != 0.0) share[i] += m->nu[s][i] / pd_max(conc[i], PDI_MINERAL_MIN_CONCENTRATION);
    }
    for (int k = 0; k < c->count; k++) slope[k] = k < c->equilibrium_components ? 0.0 : share[c->component_solute[k]];
    for (int n = 0; n < c->members; n++) {
        for (int k = 0; k < c->equilibrium_components; k++)
            slope[k] += share[c->member_solute[n]] * table[n * columns + k];
        if (columns > c->equilibrium_components)
            others += share[c->member_solute[n]] * table[n * columns + c->equilibrium_components];
    }
    for (int k = c->equilibrium_components; k < c->count; k++)
        slope[k] += others * 0.5 * (double)(c->charge[c->component_solute[k]] * c->charge[c->component_solute[k]]);
}

/* 1: mineral s would grow (its residual is above 1e-9), and the volume fraction of all is at least 1 - its
 * min_porosity, or with has_limits its amount is at its limit, to 1e-9. 0 for minerals of no volume. */
static int pdi_mineral_step_is_full(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start, int s,
                                    const double *conc, const double *n)
{
    double full = start->has_limits ? start->limit[s] : 1.0 - m->mineral[s].min_porosity;
    double found = start->has_limits ? n[s] : pdi_mineral_compute_volume_fraction(m, n);
    if (!(m->mineral[s].volume > 0.0) || found < full * (1.0 - PDI_MINERAL_FULL_TOLERANCE)) return 0;
    return pdi_mineral_step_compute_law_residual(c, m, start, s, conc, n[s], n[s] - start->start_amount[s]) >
           PDI_MINERAL_FULL_TOLERANCE;
}

/* Gauss-Jordan elimination without pivoting of `count` equations with `columns` right-hand sides, positive definite but
 * for rounding; solutions in b, 0 where a pivot is 0. a is overwritten. */
static void pdi_mineral_step_solve_linear(int count, int columns, double (*a)[PD_MINERAL_MAX],
                                          double (*b)[PD_SPECIES_MAX])
{
    for (int p = 0; p < count; p++) {
        if (!(fabs(a[p][p]) > 0.0) || !(fabs(a[p][p]) < HUGE_VAL)) continue;
        for (int r = 0; r < count; r++) {
            double factor = r == p ? 0.0 : a[r][p] / a[p][p];
            if (factor == 0.0) continue;
            for (int q = 0; q < count; q++) a[r][q] -= factor * a[p][q];
            for (int k = 0; k < columns; k++) b[r][k] -= factor * b[p][k];
        }
    }
    for (int p = 0; p < count; p++)
        for (int k = 0; k < columns; k++) b[p][k] = fabs(a[p][p]) > 0.0 ? b[p][k] / a[p][p] : 0.0;
}

/* Derivative [m3/mol] of the law of mineral s by its amount (L of theory 7.7); 0 in equilibrium. */
static double pdi_mineral_step_compute_law_derivative(const pd_minerals *m, const pd_mineral_start *start, int s,
                                                      double n)
{
    double rate = pdi_mineral_compute_max_extent(start, s, n), slope = 1.0;
    if (!(rate < HUGE_VAL)) return 0.0;
    if (start->amount_rate[s] > 0.0) slope = pdi_mineral_compute_max_extent(start, s, start->start_amount[s]) / rate;
    return slope / (m->mineral[s].exponent * pd_max(rate + n - start->start_amount[s], DBL_EPSILON * rate));
}

/* Newton matrix a [count][count] of the minerals active [count], W + L; slope [count][components] [m3/mol]: d ln
 * Omega/dT (theory 7.7). */
static void pdi_mineral_step_assemble_matrix(const pd_components *c, const pd_minerals *m,
                                             const pd_mineral_start *start, const double *conc, const double *n,
                                             const int *active, int count, double (*a)[PD_MINERAL_MAX],
                                             double (*slope)[PD_SPECIES_MAX])
{
    double table[PD_COMPONENTS_DERIVATIVES];
    pdi_components_compute_derivatives(c, conc, table);
    for (int p = 0; p < count; p++) {
        int s = active[p];
        pdi_mineral_step_compute_omega_gradient(c, m, s, table, conc, slope[p]);
        for (int q = 0; q < count; q++) {
            a[p][q] = 0.0;
            for (int k = 0; k < c->count; k++) a[p][q] += slope[p][k] * m->total_content[active[q]][k];
        }
        a[p][p] += pdi_mineral_step_compute_law_derivative(m, start, s, n[s]);
    }
}

/* 1: the amount of mineral s changes in the step by less than DBL_EPSILON of it, by dissolution and by growth at Omega,
 * so the derivative of ln Omega, unbounded where nothing is dissolved, says nothing. */
static int pdi_mineral_step_is_inert(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start, int s,
                                     const double *conc, double n)
{
    double rate = pdi_mineral_compute_max_extent(start, s, n);
    if (!(rate < DBL_EPSILON * n)) return 0;
    return rate * exp(m->mineral[s].exponent * pdi_mineral_compute_ln_omega(c, m, s, conc)) < DBL_EPSILON * n;
}

/* Finds the minerals that are present, react, are not full and change by more than rounding, into active; returns their
 * number. */
static int pdi_mineral_step_find_active(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start,
                                        const double *conc, const double *n, int *active)
{
    int count = 0;
    for (int s = 0; s < m->count; s++) {
        int there =
            n[s] > 0.0 && pdi_mineral_is_reactive(start, s) && !pdi_mineral_step_is_inert(c, m, start, s, conc, n[s]);
        if (there && !pdi_mineral_step_is_full(c, m, start, s, conc, n)) active[count++] = s;
    }
    return count;
}

PDI_FN void pdi_mineral_step_compute_derivatives(const pd_components *c, const pd_minerals *m,
                                                 const pd_mineral_start *start, const double *conc, const double *n,
                                                 double *derivatives)
{
    double a[PD_MINERAL_MAX][PD_MINERAL_MAX];
    double slope[PD_MINERAL_MAX][PD_SPECIES_MAX];
    int active[PD_MINERAL_MAX], count = pdi_mineral_step_find_active(c, m, start, conc, n, active);
    for (int k = 0; k < m->count * c->count; k++) derivatives[k] = 0.0;
    if (!count) return;
    pdi_mineral_step_assemble_matrix(c, m, start, conc, n, active, count, a, slope);
    pdi_mineral_step_solve_linear(count, c->count, a, slope);
    for (int p = 0; p < count; p++)
        for (int k = 0; k < c->count; k++) derivatives[active[p] * c->count + k] = slope[p][k];
}

PDI_FN void pdi_mineral_step_solve_linear_response(const pd_components *c, const pd_minerals *m,
                                                   const pd_mineral_start *start, const double *conc, const double *n,
                                                   double *change)
{
    double a[PD_MINERAL_MAX][PD_MINERAL_MAX];
    double slope[PD_MINERAL_MAX][PD_SPECIES_MAX];
    int active[PD_MINERAL_MAX], count = pdi_mineral_step_find_active(c, m, start, conc, n, active);
    if (!count) return;
    pdi_mineral_step_assemble_matrix(c, m, start, conc, n, active, count, a, slope);
    for (int p = 0; p < count; p++) {
        int s = active[p];
        slope[p][0] = pdi_mineral_step_compute_law_derivative(m, start, s, n[s]) * change[s];
    }
    pdi_mineral_step_solve_linear(count, 1, a, slope);
    for (int p = 0; p < count; p++) change[active[p]] = slope[p][0];
}

/* ---- all minerals ---- */
/* Residuals off [minerals] of (7.16) at the amounts in w, whose concentrations are solved for; returns the largest
 * size that a change of amounts can lower: minerals that do not react, that are full and would grow, or that are absent
 * and would dissolve do not count. HUGE_VAL: there are no concentrations, off is not set. */
static double pdi_mineral_step_compute_residuals(pdi_mineral_step_work *w, double *off)
{
    double worst = 0.0, first = pdi_mineral_step_compute_growth_residual(w, 0, w->growth[0]);
    if (w->infeasible) return HUGE_VAL;
    for (int s = 0; s < w->m->count; s++) {
        off[s] = s ? pdi_mineral_step_compute_law_residual(w->c, w->m, w->start, s, w->conc, w->amount[s],
                                                           pdi_mineral_step_get_excess(w, s))
                   : first;
        int full = off[s] > 0.0 && pdi_mineral_step_is_full(w->c, w->m, w->start, s, w->conc, w->amount);
        if (full || !pdi_mineral_is_reactive(w->start, s)) continue;
        if (w->amount[s] > 0.0 || off[s] > 0.0) worst = pd_max(worst, fabs(off[s]));
    }
    return worst;
}

/* slope[][0]: residuals of the active minerals become changes of their amounts [mol/m3] by matrix a. Amounts that would
 * be negative become 0, one by one. */
static void pdi_mineral_step_compute_bounded_changes(const pdi_mineral_step_work *w, const int *active, int count,
                                                     double (*a)[PD_MINERAL_MAX], double (*slope)[PD_SPECIES_MAX])
{
    double matrix[PD_MINERAL_MAX][PD_MINERAL_MAX], change[PD_MINERAL_MAX][PD_SPECIES_MAX];
    int gone[PD_MINERAL_MAX] = {0};
    for (int turn = 0; turn <= count; turn++) {
        int worst = -1;
        for (int p = 0; p < count; p++) {
            change[p][0] = gone[p] ? -w->amount[active[p]] : slope[p][0];
            for (int q = 0; q < count; q++) {
                matrix[p][q] = gone[p] || gone[q] ? (p == q ? 1.0 : 0.0) : a[p][q];
                if (!gone[p] && gone[q]) change[p][0] += a[p][q] * w->amount[active[q]];
            }
        }
        pdi_mineral_step_solve_linear(count, 1, matrix, change);
        for (int p = 0; p < count; p++)
            if (!gone[p] && w->amount[active[p]] + change[p][0] < 0.0 &&
                (worst < 0 || change[p][0] / w->amount[active[p]] < change[worst][0] / w->amount[active[worst]]))
                worst = p;
        if (worst < 0) break;
        gone[worst] = 1;
    }
    for (int p = 0; p < count; p++) slope[p][0] = change[p][0];
}

/* 1: the changes slope[][0] of active minerals are rounding of amounts, or of the least total they change. */
static int pdi_mineral_step_is_rounding(const pdi_mineral_step_work *w, const int *active, int count,
                                        double (*slope)[PD_SPECIES_MAX])
{
    for (int p = 0; p < count; p++) {
        int s = active[p];
        double least = HUGE_VAL;
        for (int k = 0; k < w->c->count; k++)
            if (w->m->total_content[s][k] != 0.0) least = pd_min(least, fabs(w->total[k] / w->m->total_content[s][k]));
        if (!(fabs(slope[p][0]) <= 0.5 * DBL_EPSILON * pd_max(fabs(w->growth[s]), least))) return 0;
    }
    return 1;
}

/* Growth of mineral s [mol/m3] after `change` from the growth `from` and the amount `had`, within its bounds. If it is
 * alone and the change exceeds half of what a limiting component has left, the change is one of the logarithm of that
 * rest. */
static double pdi_mineral_step_compute_new_growth(const pdi_mineral_step_work *w, int s, int alone, double had,
                                                  double from, double change)
{
    double least, most, room, none = -w->base_amount[s], grown = from + change;
    pdi_mineral_step_compute_growth_bounds(w, s, &least, &most, &room);
    double below = from - least, above = most - from, rest = pd_min(below, above);
    if (!(had + change > 0.0)) grown = none;
    if (alone && rest > 0.0 && fabs(change) > 0.5 * rest) {
        double near = below < above ? least + rest * exp(change / rest) : most - rest * exp(-change / rest);
        if (near > least && near < most) grown = near;
    }
    return pd_min(pd_max(grown, none), room);
}

/* A Newton step of all minerals that are present, react and are not full, with line search: a fraction is accepted that
 * leaves less than 0.99 of the residual, or 0.5 next to rounding. 1: *worst, the largest residual, has fallen; 0: no
 * progress, amounts are unchanged, *worst is their residual, 0 where it is rounding. */
static int pdi_mineral_step_try_newton_step(pdi_mineral_step_work *w, double *worst)
{
    const pd_components *c = w->c;
    const pd_minerals *m = w->m;
    double a[PD_MINERAL_MAX][PD_MINERAL_MAX];
    double slope[PD_MINERAL_MAX][PD_SPECIES_MAX], off[PD_MINERAL_MAX];
    double from[PD_MINERAL_MAX], had[PD_MINERAL_MAX];
    int active[PD_MINERAL_MAX], count = 0;
    *worst = pdi_mineral_step_compute_residuals(w, off);
    for (int s = 0; s < m->count; s++)
        if (w->amount[s] > 0.0 && pdi_mineral_is_reactive(w->start, s) &&
            !pdi_mineral_step_is_full(c, m, w->start, s, w->conc, w->amount))
            active[count++] = s;
    if (!count || !(*worst > PDI_MINERAL_TOLERANCE) || w->infeasible || w->solves_left <= 0) return 0;
    pdi_mineral_step_assemble_matrix(c, m, w->start, w->conc, w->amount, active, count, a, slope);
    for (int p = 0; p < count; p++) slope[p][0] = off[active[p]];
    pdi_mineral_step_compute_bounded_changes(w, active, count, a, slope);
    if (pdi_mineral_step_is_rounding(w, active, count, slope)) {
        if (*worst <= PDI_MINERAL_STEP_REGULAR_RESIDUAL) *worst = 0.0;
        return 0;
    }
    memcpy(from, w->growth, sizeof from);
    memcpy(had, w->amount, sizeof had);
    for (double share = 1.0; share > PDI_MINERAL_STEP_MIN_FRACTION; share *= 0.25) {
        for (int p = 0; p < count; p++) {
            int of = active[p];
            double change = share * slope[p][0];
            pdi_mineral_step_set_growth(
                w, of, pdi_mineral_step_compute_new_growth(w, of, count == 1, had[of], from[of], change));
        }
        double now = pdi_mineral_step_compute_residuals(w, off);
        if (now <
            (*worst > PDI_MINERAL_STEP_NEAR_RESIDUAL ? PDI_MINERAL_STEP_MAX_LEFT : PDI_MINERAL_STEP_MAX_LEFT_NEAR) *
                *worst) {
            *worst = now;
            return 1;
        }
    }
    for (int s = 0; s < m->count; s++) pdi_mineral_step_set_growth(w, s, from[s]);
    pdi_mineral_step_compute_growth_residual(w, 0, from[0]);
    return 0;
}

/* Amounts by laws and bounds, as pdi_mineral_step_solve: Newton for all, else one by one, until neither moves them. Of
 * several that lack room, the first ones have it. PD_NOT_CONVERGED: there are no concentrations, or
 * PDI_MINERAL_STEP_MAX_SOLVES equilibria are used up and a residual is not below PDI_MINERAL_STEP_LOOSE_TOLERANCE. conc
 * and n are unchanged then. */
static pd_status pdi_mineral_step_solve_without_sharing(const pd_components *c, const pd_minerals *m,
                                                        const pd_mineral_start *start, const double *total,
                                                        double *conc, double *n)
{
    pdi_mineral_step_work w;
    double size = 0.0, off[PD_MINERAL_MAX];
    w.c = c;
    w.m = m;
    w.start = start;
    w.infeasible = 0;
    w.solves_left = PDI_MINERAL_STEP_MAX_SOLVES;
    memset(w.conc, 0, sizeof w.conc);
    memcpy(w.conc, conc, (size_t)c->solutes * sizeof *conc);
    memcpy(w.guess, w.conc, sizeof w.guess);
    memcpy(w.total, total, (size_t)c->count * sizeof *total);
    for (int k = 0; k < c->count; k++) size = pd_max(size, fabs(total[k]));
    for (int s = 0; s < m->count; s++) {
        w.base_amount[s] = w.amount[s] = n[s];
        w.growth[s] = 0.0;
        size = pd_max(size, n[s]);
    }
    for (int s = 0; s < m->count; s++) { /* a guess may be more than has room */
        if (start->guess) pdi_mineral_step_set_growth(&w, s, pd_max(start->guess[s], 0.0) - n[s]);
        double least, most, room;
        pdi_mineral_step_compute_growth_bounds(&w, s, &least, &most, &room);
        if (room < 0.0) pdi_mineral_step_set_growth(&w, s, room);
    }
    for (int round = 0; round < PDI_MINERAL_STEP_MAX_SWEEPS && w.solves_left > 0; round++) {
        double moved = 0.0, worst;
        while (pdi_mineral_step_try_newton_step(&w, &worst)) {
        }
        if (!(worst > PDI_MINERAL_STEP_NEAR_RESIDUAL) || w.solves_left <= 0) break;
        for (int s = 0; s < m->count; s++) {
            double before = w.growth[s];
            pdi_mineral_step_solve_one(&w, s);
            moved = pd_max(moved, fabs(w.growth[s] - before));
        }
        if (!(moved > PDI_MINERAL_STEP_ROUNDING * DBL_EPSILON * size)) break;
    }
    if (!(pdi_mineral_step_compute_residuals(&w, off) <
          (w.solves_left > 0 ? HUGE_VAL : PDI_MINERAL_STEP_LOOSE_TOLERANCE)))
        return PD_NOT_CONVERGED;
    memcpy(conc, w.conc, (size_t)c->solutes * sizeof *conc);
    memcpy(n, w.amount, (size_t)m->count * sizeof *n);
    return PD_OK;
}

/* ---- several minerals that share the free volume ---- */
/* 1: two or more minerals react and have a volume, one of them is full, or has grown while the volume of all exceeds
 * its free volume, and one has changed by more than 1e-9 of the volume of all: how they share it is open. */
static int pdi_mineral_step_has_shared_volume(const pd_components *c, const pd_minerals *m,
                                              const pd_mineral_start *start, const double *conc, const double *n)
{
    double volume = pdi_mineral_compute_volume(m, n);
    int full = 0, moved = 0, count = 0;
    for (int s = 0; s < m->count; s++) {
        if (!(m->mineral[s].volume > 0.0) || !pdi_mineral_is_reactive(start, s)) continue;
        count++;
        moved |= fabs(n[s] - start->initial[s]) * m->mineral[s].volume > PDI_MINERAL_FULL_TOLERANCE * volume;
        full |= pdi_mineral_step_is_full(c, m, start, s, conc, n);
        full |= n[s] > start->initial[s] &&
                volume > (1.0 - m->mineral[s].min_porosity) * (1.0 + PDI_MINERAL_FULL_TOLERANCE);
    }
    return full && moved && count > 1;
}

/* Minerals that share the free volume of a cell. */
typedef struct pdi_mineral_shared_volume {
    const pd_components *c;
    const pd_minerals *m;
    pd_mineral_start start;      /* with limits */
    const double *total, *guess; /* of pdi_mineral_step_solve */
    const double *start_amounts;
    double free_amount[PD_MINERAL_MAX]; /* [mol/m3] amounts if there were room */
    int is_open[PD_MINERAL_MAX];        /* 1: it grows, and is not at its limit */
    double conc[PD_SPECIES_MAX], amount[PD_MINERAL_MAX];
} pdi_mineral_shared_volume;

/* Solves for conc and amount of r within the limits of r->start, from guess and start amounts. 1: found, 0: not. */
static int pdi_mineral_step_solve_within_limits(pdi_mineral_shared_volume *r)
{
    memset(r->conc, 0, sizeof r->conc);
    memcpy(r->conc, r->guess, (size_t)r->c->solutes * sizeof *r->conc);
    memcpy(r->amount, r->start_amounts, (size_t)r->m->count * sizeof *r->amount);
    return pdi_mineral_step_solve_without_sharing(r->c, r->m, &r->start, r->total, r->conc, r->amount) == PD_OK;
}

/* Amounts if open minerals grow by `share` of their free growth (sets their limits); *over [-]: volume fraction above
 * `room`. 1: found, 0: not. */
static int pdi_mineral_step_solve_partial_growth(pdi_mineral_shared_volume *r, double share, double room, double *over)
{
    for (int s = 0; s < r->m->count; s++)
        if (r->is_open[s]) r->start.limit[s] = r->start.initial[s] + share * (r->free_amount[s] - r->start.initial[s]);
    int found = pdi_mineral_step_solve_within_limits(r);
    *over = pdi_mineral_compute_volume(r->m, r->amount) - room;
    return found;
}

/* Finds the share 0 .. 1 of free growth at which the open minerals fill `room` [-] from below to
 * PDI_MINERAL_STEP_FILL_TOLERANCE, and the amounts there; 0 where they fill it without growth. high: excess at share 1,
 * positive. 1: found, 0: a solve fails. */
static int pdi_mineral_step_find_filling_growth(pdi_mineral_shared_volume *r, double room, double high)
{
    double low, share = 0.0, x;
    if (!pdi_mineral_step_solve_partial_growth(r, 0.0, room, &low)) return 0;
    pdi_root_bracket b = {0.0, low, 1.0, high, 0, 0};
    while (low < -PDI_MINERAL_STEP_FILL_TOLERANCE * room && pdi_root_bracket_get_next(&b, &x)) {
        double over;
        if (!pdi_mineral_step_solve_partial_growth(r, x, room, &over)) return 0;
        pdi_root_bracket_update(&b, x, over);
        if (over > 0.0) continue;
        low = over;
        share = x;
    }
    return pdi_mineral_step_solve_partial_growth(r, share, room, &low);
}

/* Smallest free volume of the open minerals, 1 - porosity; HUGE_VAL: none is open. */
static double pdi_mineral_step_get_min_free_volume(const pdi_mineral_shared_volume *r)
{
    double room = HUGE_VAL;
    for (int s = 0; s < r->m->count; s++)
        if (r->is_open[s]) room = pd_min(room, 1.0 - r->m->mineral[s].min_porosity);
    return room;
}

/* Minerals that grow share the free volume by equal shares of their free growth, up to the largest min_porosity; those
 * with a lower one go on growing alone, and those that do not grow are limited to their amount before the step. Results
 * in conc and amount of r. 1: found, 0: not. */
static int pdi_mineral_step_solve_shared_volume(pdi_mineral_shared_volume *r)
{
    double room;
    r->start.has_limits = 1;
    for (int s = 0; s < r->m->count; s++) r->start.limit[s] = HUGE_VAL;
    if (!pdi_mineral_step_solve_within_limits(r)) return 0;
    for (int s = 0; s < r->m->count; s++) {
        if (!(r->m->mineral[s].volume > 0.0)) continue;
        r->is_open[s] = r->amount[s] > r->start.initial[s];
        if (!r->is_open[s]) r->start.limit[s] = r->start.initial[s];
    }
    while ((room = pdi_mineral_step_get_min_free_volume(r)) < HUGE_VAL) {
        double over = pdi_mineral_compute_volume(r->m, r->amount) - room;
        if (!(over > 0.0)) return 1;
        for (int s = 0; s < r->m->count; s++) r->free_amount[s] = pd_max(r->amount[s], r->start.initial[s]);
        if (!pdi_mineral_step_find_filling_growth(r, room, over)) return 0;
        for (int s = 0; s < r->m->count; s++) {
            if (r->is_open[s]) r->is_open[s] = 1.0 - r->m->mineral[s].min_porosity > room;
            if (r->is_open[s]) r->start.limit[s] = HUGE_VAL;
        }
        if (pdi_mineral_step_get_min_free_volume(r) < HUGE_VAL && !pdi_mineral_step_solve_within_limits(r)) return 0;
    }
    return 1;
}

PDI_FN pd_status pdi_mineral_step_solve(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start,
                                        const double *total, double *conc, double *n)
{
    pdi_mineral_shared_volume r;
    memcpy(r.conc, conc, (size_t)c->solutes * sizeof *conc);
    memcpy(r.amount, n, (size_t)m->count * sizeof *n);
    pd_status status = pdi_mineral_step_solve_without_sharing(c, m, start, total, r.conc, r.amount);
    if (status == PD_OK && pdi_mineral_step_has_shared_volume(c, m, start, r.conc, r.amount)) {
        r.c = c;
        r.m = m;
        r.start = *start;
        r.total = total;
        r.guess = conc;
        r.start_amounts = n;
        memset(r.is_open, 0, sizeof r.is_open);
        if (!pdi_mineral_step_solve_shared_volume(&r)) status = PD_NOT_CONVERGED;
    }
    if (status != PD_OK) return status;
    memcpy(conc, r.conc, (size_t)c->solutes * sizeof *conc);
    memcpy(n, r.amount, (size_t)m->count * sizeof *n);
    return PD_OK;
}

#undef PDI_MINERAL_STEP_INFEASIBLE
#undef PDI_MINERAL_STEP_MAX_SWEEPS
#undef PDI_MINERAL_STEP_MAX_SOLVES
#undef PDI_MINERAL_STEP_LOOSE_TOLERANCE
#undef PDI_MINERAL_STEP_REGULAR_RESIDUAL
#undef PDI_MINERAL_STEP_FILL_TOLERANCE
#undef PDI_MINERAL_STEP_ROUNDING
#undef PDI_MINERAL_STEP_MIN_FRACTION
#undef PDI_MINERAL_STEP_MAX_LEFT
#undef PDI_MINERAL_STEP_NEAR_RESIDUAL
#undef PDI_MINERAL_STEP_MAX_LEFT_NEAR
#undef PDI_MINERAL_STEP_FIRST_STEP
