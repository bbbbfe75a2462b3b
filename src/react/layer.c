/* layer: see layer.h
 *
 * Design: in the film the sums over species of D times concentration, by components, are linear, since reactions in
 * equilibrium keep them. Concentrations times their diffusivities follow the same mass action with other constants, so
 * the surface is found by the solver of components. Coefficients of activity are those of the node. With migration the
 * same holds for the shares of exponential fluxes (migrate.h), and the potential of the surface makes it neutral.
 */
#include "react/layer.h"
#include "react/terms.h"
#include "core/root_bracket.h"
#include "core/par.h"
#include "solve/gauss_jordan.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Steps of a search, and the share of the speed to which it is found. */
#define PDI_LAYER_STEPS 200
#define PDI_LAYER_CLOSE 1e-15
/* [m/s] First guess of a law that overflows. */
#define PDI_LAYER_FAST 1.0
/* Factor by which a bracket of the speed grows first; it is squared each time. */
#define PDI_LAYER_BRACKET 2.0
/* Relative change of what a law reads by which its slope is found. */
#define PDI_LAYER_STRIDE 1e-6
/* Share by which twice that has another slope where a law jumps; doublings and halvings by which the place of the jump
 * is found. */
#define PDI_LAYER_JUMP 0.25
#define PDI_LAYER_DOUBLINGS 60
#define PDI_LAYER_HALVINGS 20
/* [mol/m3] that counts as nothing beside that. */
#define PDI_LAYER_NOTHING 1e-30
/* What is left at least of 1 less the slope of a rising law behind its film. */
#define PDI_LAYER_RISE 0.05
/* Steps of Newton's method for speed and flow of an electrode, and the share of them that counts as found. */
#define PDI_LAYER_NEWTON 12
#define PDI_LAYER_MET 1e-12
/* Bit of what curves read: pH. */
#define PDI_LAYER_PH ((uint32_t)1 << 31)
/* F phi/(R T): most of the surface over the node, first stride to it, and the change by which a slope is found. */
#define PDI_LAYER_LIFT 60.0
#define PDI_LAYER_LIFT_FIRST 0.01
#define PDI_LAYER_LIFT_STRIDE 1e-6
/* Change of ln gamma by which its effect is found. */
#define PDI_LAYER_SALT_STRIDE 1e-6
/* Share of the sum of |z| c that is no charge. */
#define PDI_LAYER_NEUTRAL 4e-16
/* Share of what comes to a surface: down to that, what is left there is found as what comes less what goes. */
#define PDI_LAYER_SPENT 1e-4
/* Charge that comes with one of a metal: less is none. */
#define PDI_LAYER_CHARGED 1e-9

/* ---- the surface of a node ---- */

/* z/(exp(z) - 1) and its derivative. */
static double pdi_layer_share(double z) { return pdi_migrate_leave(1.0, 0.0, z, 1.0, 0.0); }
static double pdi_layer_share_by(double z) { return -pdi_migrate_conduct(z, 1.0, 0.0); }

/* ---- the film of a node with migration ---- */

/* Charge of the surface whose totals are w->into, over the sum of |z| c. NaN: no equilibrium was found. */
static double pdi_layer_charged(const pd_components *film, pdi_terms *w)
{
    double charge = 0.0, size = 0.0;
    if (pdi_components_solve(film, w->into, w->at) != PD_OK) return NAN;
    for (int n = 0; n < film->solutes; n++) {
        w->surface[n] = w->at[n] / (w->s->scale[n] * w->down[n]);
        charge += film->charge[n] * w->surface[n];
        size += fabs((double)film->charge[n]) * w->surface[n];
    }
    return size > DBL_MIN ? charge / size : 0.0;
}

/* The same where metal dissolves at v and the surface has `lift`: it falls with that. */
static double pdi_layer_charge(pd_components *film, pdi_terms *w, double v, double lift)
{
    const pd_etch *s = w->s;
    double up[PD_SPECIES_MAX];
    w->thick = w->still + w->creep * v;
    w->sweep = s->surface ? w->thick * v / s->desc.solid : 0.0;
    for (int n = 0; n < film->solutes; n++) {
        double z = film->charge[n] * lift;
        w->down[n] = pdi_layer_share(-z) + w->sweep / s->scale[n];
        up[n] = s->scale[n] * pdi_layer_share(z) * w->c[n];
    }
    for (int n = 0; n < film->solutes && film->members; n++) {
        film->ln_k[n] = w->ln_k[n] + log(w->down[n]);
        for (int k = 0; k < film->equilibrium_components; k++)
            film->ln_k[n] -= film->stoichiometry[k][n] * log(w->down[film->component_solute[k]]);
    }
    for (int k = 0; k < film->equilibrium_components; k++) film->ln_k[film->component_solute[k]] = 0.0;
    pdi_components_compute_totals(film, up, w->into);
    if (w->electrode >= 0 && !w->reads) w->flow = pdi_terms_curve(w, w->c, w->psi + lift);
    for (int k = 0; k < film->count; k++) {
        w->into[k] += w->kind->gain[k] * w->thick * v;
        if (w->electrode >= 0) w->into[k] += s->part_gain[w->electrode * film->count + k] * w->way * w->flow;
    }
    double charge = pdi_layer_charged(film, w);
    if (charge == charge) w->lift = lift;
    return charge;
}

/* The component whose ion alone an electrode gives or takes; -1: there are several, or the curve reads none. */
static int pdi_layer_ion(const pd_components *film, const pdi_terms *w)
{
    int ion = -1, ions = 0, first = w->electrode * film->count;
    if (w->electrode < 0 || !w->reads) return -1;
    for (int k = 0; k < film->count; k++)
        if (fabs(w->s->part_gain[first + k]) > 0.0 && film->charge[film->component_solute[k]] && ++ions) ion = k;
    return ions == 1 ? ion : -1;
}

/* Where an electrode takes nearly all of an ion that reaches it, what is left is the small difference of what comes and
 * goes, and only rounding of that. The other ions, whose amounts need no such difference, tell how much of it makes the
 * surface neutral. */
static void pdi_layer_rest(const pd_components *film, pdi_terms *w)
{
    double size = 0.0, come = 0.0, stride = 0.0, others = 0.0, a, of, b, there;
    int ion = pdi_layer_ion(film, w), own = ion < 0 ? -1 : film->component_solute[ion];
    if (ion < 0 || !(fabs(w->lift) < PDI_LAYER_LIFT)) return;
    for (int n = 0; n < film->solutes; n++) {
        double z = film->charge[n];
        size += fabs(z) * w->surface[n];
        come = pd_max(come, fabs(z) * pdi_layer_share(z * w->lift) * w->c[n] / w->down[n]);
        stride += fabs(film->stoichiometry[ion][n]) * w->at[n];
        if (n != own) others += z * w->surface[n];
    }
    if (!(size < PDI_LAYER_SPENT * come)) return;
    if (ion >= film->equilibrium_components) {
        w->into[ion] = pd_max(-others / film->charge[own], 0.0) * w->s->scale[own] * w->down[own];
        pdi_layer_charged(film, w);
        return;
    }
    b = w->into[ion];
    there = pdi_layer_charged(film, w);
    if (!(fabs(there) > PDI_LAYER_NEUTRAL)) return;
    do {
        a = b;
        of = there;
        w->into[ion] = b = (of > 0.0) == (film->charge[own] > 0) ? a - stride : a + stride;
        there = pdi_layer_charged(film, w);
        stride *= 2.0;
    } while (there * of > 0.0 && stride < HUGE_VAL);
    pdi_root_bracket s = {a, of, b, there, 0, 0};
    double x;
    while (of * there < 0.0 && fabs(there) > PDI_LAYER_NEUTRAL && pdi_root_bracket_get_next(&s, &x)) {
        w->into[ion] = x;
        there = pdi_layer_charged(film, w);
        if (!(there == there)) return;
        pdi_root_bracket_update(&s, x, there);
    }
}

/* From `a`, with the charge *of, by growing strides to a lift `b` on the other side of neutrality. */
static double pdi_layer_across(pd_components *film, pdi_terms *w, double v, double *a, double *of, double *there)
{
    double stride = *of > 0.0 ? PDI_LAYER_LIFT_FIRST : -PDI_LAYER_LIFT_FIRST, b = *a;
    *there = *of;
    while (fabs(b) < PDI_LAYER_LIFT || b * stride < 0.0) {
        b = pd_min(pd_max(b + stride, -PDI_LAYER_LIFT), PDI_LAYER_LIFT);
        stride *= 3.0;
        *there = pdi_layer_charge(film, w, v, b);
        if (!(*there * *of > 0.0)) return b;
        *a = b;
        *of = *there;
    }
    return b;
}

/* The lift that makes the surface neutral where metal dissolves at v. Fluid without ions of one sign
 * lifts it as far as it goes. 0: no equilibrium was found. */
static int pdi_layer_lift(pd_components *film, pdi_terms *w, double v)
{
    double a = w->lift, of = pdi_layer_charge(film, w, v, a), there;
    if (fabs(of) <= PDI_LAYER_NEUTRAL) return 1;
    double b = pdi_layer_across(film, w, v, &a, &of, &there);
    pdi_root_bracket s = {a, of, b, there, 0, 0};
    double x;
    while (of * there < 0.0 && pdi_root_bracket_get_next(&s, &x) &&
           fabs(s.b - s.a) > PDI_LAYER_CLOSE * pd_max(fabs(x), PDI_LAYER_LIFT_FIRST)) {
        double g = pdi_layer_charge(film, w, v, x);
        if (!(g == g)) return 0;
        if (fabs(g) <= PDI_LAYER_NEUTRAL) break;
        pdi_root_bracket_update(&s, x, g);
    }
    pdi_layer_rest(film, w);
    return of == of && there == there;
}

/* What the curve gives beyond the flow f, where metal dissolves at v: it falls with f. Where f takes more than there
 * is, the surface has none of it. */
static double pdi_layer_excess(pd_components *film, pdi_terms *w, double v, double f)
{
    w->flow = f;
    if (!pdi_layer_lift(film, w, v)) return f < 0.0 ? HUGE_VAL : -HUGE_VAL;
    return pdi_terms_curve(w, w->surface, w->psi + w->lift) - f;
}

/* Between a bracket [a, b] of a flow that is not 0. */
static double pdi_layer_middle(double a, double b)
{
    double low = pd_min(fabs(a), fabs(b)), high = pd_max(fabs(a), fabs(b)), sign = a + b < 0.0 ? -1.0 : 1.0;
    return low > 0.0 && high > 4.0 * low ? sign * sqrt(low * high) : 0.5 * (a + b);
}

/* The flow of a curve that reads the species, where metal dissolves at v: between none and what the curve gives without
 * it; the guess first. 0: no surface was found. */
static int pdi_layer_flow(pd_components *film, pdi_terms *w, double v)
{
    double a = 0.0, of = pdi_layer_excess(film, w, v, 0.0), b = of, there = 0.0, f = w->guess;
    if (!(fabs(of) < HUGE_VAL)) return 0;
    if (!(fabs(of) > 0.0)) return 1;
    for (int step = 0; step < PDI_LAYER_STEPS && fabs(b - a) > PDI_LAYER_CLOSE * fabs(b); step++) {
        if (step > 1) f = a + (b - a) * (of / (of - there));
        if (step == 1) f *= there * of < 0.0 ? 1.0 - PDI_LAYER_STRIDE : 1.0 + PDI_LAYER_STRIDE;
        if ((step > 1 && (step % 3 == 2 || !(fabs(of - there) < HUGE_VAL) || !(there * of < 0.0))) ||
            !((f - a) * (b - f) > 0.0))
            f = pdi_layer_middle(a, b);
        if (!((f - a) * (b - f) > 0.0)) break;
        double g = pdi_layer_excess(film, w, v, f);
        if (!(g * of > 0.0)) {
            b = f;
            there = g;
            if (step > 1) of *= 0.5;
            if (!(fabs(g) > 0.0)) {
                a = f;
                break;
            }
        } else {
            a = f;
            of = g;
            if (step > 1) there *= 0.5;
        }
    }
    double last = pdi_layer_excess(film, w, v, fabs(there) < HUGE_VAL && fabs(there) > 0.0 ? b : a);
    w->guess = w->flow;
    return fabs(last) < HUGE_VAL;
}

/* With migration: the surface where metal dissolves at v. 0: none was found. */
static int pdi_layer_settle(pd_components *film, pdi_terms *w, double v)
{
    return w->electrode >= 0 && w->reads ? pdi_layer_flow(film, w, v) : pdi_layer_lift(film, w, v);
}

/* The same in a search, which ends with no speed where it is no number. */
static double pdi_layer_asked(pdi_terms *w, const double *c, double psi)
{
    double v = pdi_terms_number(w, c, psi);
    w->odd = !(v == v);
    w->odds |= w->odd;
    return pd_max(v, 0.0);
}

/* The law at the surface, where metal dissolves at v [m/s]. */
static double pdi_layer_given(pd_components *film, pdi_terms *w, double v)
{
    const pd_etch *s = w->s;
    double flows[PD_SPECIES_MAX], c[PD_SPECIES_MAX];
    if (!(w->thick + w->way > 0.0)) return pdi_layer_asked(w, w->c, w->psi);
    if (s->reactive->migration.on)
        return pdi_layer_settle(film, w, v) ? pdi_layer_asked(w, w->surface, w->psi + w->lift) : (double)NAN;
    w->thick = w->still + w->creep * v;
    for (int k = 0; k < film->count; k++) flows[k] = w->flows[k] + w->kind->gain[k] * w->thick * v;
    if (pdi_components_solve(film, flows, w->at) != PD_OK) return NAN;
    for (int n = 0; n < film->solutes; n++) c[n] = w->at[n] / s->scale[n];
    return pdi_layer_asked(w, c, 0.0);
}

/* A bracket of v = law(v) around a guess between 0 and what the node would give: law(*a) > *a, law(*b) <= *b, with the
 * differences; of a law that overflows *above is infinite. 0: the law is no number, or beyond all bounds. */
static int pdi_layer_bracket(pd_components *film, pdi_terms *w, double guess, double first, double *a,
                               double *above, double *b, double *below)
{
    double factor = PDI_LAYER_BRACKET, v = guess > 0.0 ? guess : pd_min(first, PDI_LAYER_FAST);
    *a = 0.0;
    *above = first;
    double g = pdi_layer_given(film, w, v) - v;
    for (int step = 0; step < PDI_LAYER_STEPS && g == g; step++) {
        int up = g > 0.0;
        if (up) {
            *a = v;
            *above = g;
        } else {
            *b = v;
            *below = g;
        }
        double next = up ? v * factor : v / factor;
        factor *= factor;
        double there = pdi_layer_given(film, w, next) - next;
        if (!(there == there)) return 0;
        if (up && !(there > 0.0)) {
            *b = next;
            *below = there;
            return 1;
        }
        if (!up && there > 0.0) {
            *a = next;
            *above = there;
            return 1;
        }
        if (!up && !(next > DBL_MIN)) return 1;
        v = next;
        g = there;
    }
    return 0;
}

/* The speed of a node; NaN: the law is no number there, or no surface was found. */
static double pdi_layer_find(pd_components *film, pdi_terms *w, double guess)
{
    double a, b = 0.0, above, below = 0.0, first = pdi_layer_given(film, w, 0.0);
    if (!(first == first)) return NAN;
    if (w->odd) return NAN;
    if (!(first > 0.0) || !(w->thick + w->way > 0.0)) return first;
    if (!pdi_layer_bracket(film, w, guess, first, &a, &above, &b, &below)) return first < HUGE_VAL ? NAN : first;
    pdi_root_bracket s = {a, above, b, below, 0, 0};
    double v;
    while (s.b - s.a > PDI_LAYER_CLOSE * s.b && pdi_root_bracket_get_next(&s, &v)) {
        double g = pdi_layer_given(film, w, v) - v;
        if (!(g == g)) return NAN;
        pdi_root_bracket_update(&s, v, g);
        if (!(fabs(g) > 0.0)) break;
    }
    if (!w->odds) return s.b;
    pdi_layer_given(film, w, s.b);
    return w->odd ? (double)NAN : s.b;
}

/* Change of the law with concentrations that change by `along`, per unit of it. Both sides of a jump count. */
static double pdi_layer_slope(const pdi_terms *w, const double *c, const double *along)
{
    const pd_etch *s = w->s;
    double least = HUGE_VAL, up[PD_SPECIES_MAX], down[PD_SPECIES_MAX];
    for (int n = 0; n < s->film.solutes; n++) {
        int reads = (w->kind->law.reads >> n & 1u) || (w->kind->law.reads_ph && n == s->reactive->proton);
        if (reads && fabs(along[n]) > 0.0) least = pd_min(least, pd_max(c[n], PDI_LAYER_NOTHING) / fabs(along[n]));
    }
    if (!(least < HUGE_VAL)) return 0.0;
    double stride = PDI_LAYER_STRIDE * least;
    for (int n = 0; n < s->film.solutes; n++) {
        up[n] = pd_max(c[n] + stride * along[n], 0.0);
        down[n] = pd_max(c[n] - stride * along[n], 0.0);
    }
    double change = (pdi_terms_law(w, up, 0.0) - pdi_terms_law(w, down, 0.0)) / (2.0 * stride);
    return fabs(change) < HUGE_VAL ? change : 0.0;
}

/* How the law at the surface follows what diffuses: slope [components] [m4/mol/s]. */
static void pdi_layer_slopes(const pd_components *system, const pdi_terms *w, const double *scale,
                               const double *at, double *slope)
{
    float table[PD_COMPONENTS_DERIVATIVES];
    double c[PD_SPECIES_MAX], one[PD_SPECIES_MAX], along[PD_SPECIES_MAX];
    pdi_components_compute_derivatives_single(system, at, table);
    for (int n = 0; n < system->solutes; n++) c[n] = at[n] / (scale ? scale[n] : 1.0);
    for (int k = 0; k < system->count; k++) {
        memset(one, 0, sizeof one);
        one[k] = 1.0;
        pdi_components_apply_derivatives(system, table, one, along);
        for (int n = 0; n < system->solutes && scale; n++) along[n] /= scale[n];
        slope[k] = pdi_layer_slope(w, c, along);
    }
}

/* ---- how law and curve follow the ionic strength of the node ---- */

/* Law and curve at the surface, with another ln gamma of a charge of 1. 0: no surface was found. */
static int pdi_layer_salted(const pdi_terms *of, double v, double davies, double *law, double *curve)
{
    const pd_etch *s = of->s;
    pd_components film = s->film;
    pdi_terms w = *of;
    w.davies = davies;
    *law = *curve = 0.0;
    if (w.thick + w.way > 0.0) pdi_etch_activities(&s->reactive->components, &s->film, davies, &film);
    memcpy(w.ln_k, film.ln_k, sizeof w.ln_k);
    if (!s->drive) {
        if (w.kind->law.law) *law = pdi_layer_given(&film, &w, v);
        return fabs(*law) < HUGE_VAL;
    }
    if (w.thick + w.way > 0.0 && !pdi_layer_lift(&film, &w, v)) return 0;
    if (w.kind->law.law) *law = pdi_terms_law(&w, w.surface, w.psi + w.lift);
    if (w.electrode >= 0) *curve = pdi_terms_curve(&w, w.surface, w.psi + w.lift);
    return fabs(*law) < HUGE_VAL && fabs(*curve) < HUGE_VAL;
}

/* Changes of law and curve at the surface with the totals of the node, by its coefficients of activity alone. */
static void pdi_layer_salt(const pdi_terms *w, double v, double *law, double *curve)
{
    const pd_components *of = &w->s->reactive->components;
    double one[PD_SPECIES_MAX], along[PD_SPECIES_MAX], slope, high[2], low[2];
    float table[PD_COMPONENTS_DERIVATIVES];
    for (int k = 0; k < of->count; k++) law[k] = curve[k] = 0.0;
    if (!(of->debye_hueckel > 0.0) || (!w->s->drive && !w->kind->law.reads && !w->kind->law.reads_ph)) return;
    pdi_components_compute_davies(of, w->c, &slope);
    if (!pdi_layer_salted(w, v, w->davies + PDI_LAYER_SALT_STRIDE, &high[0], &high[1]) ||
        !pdi_layer_salted(w, v, w->davies - PDI_LAYER_SALT_STRIDE, &low[0], &low[1]))
        return;
    pdi_components_compute_derivatives_single(of, w->c, table);
    for (int k = 0; k < of->count; k++) {
        double ions = 0.0;
        memset(one, 0, sizeof one);
        one[k] = 1.0;
        pdi_components_apply_derivatives(of, table, one, along);
        for (int n = 0; n < of->solutes; n++) ions += 0.5 * of->charge[n] * of->charge[n] * along[n];
        ions *= slope / (2.0 * PDI_LAYER_SALT_STRIDE);
        law[k] = (high[0] - low[0]) * ions;
        curve[k] = (high[1] - low[1]) * ions;
    }
}

/* How the speed v of a node follows its totals. */
static void pdi_layer_derive(const pd_components *film, const pdi_terms *w, double v, float *by)
{
    const pd_etch *s = w->s;
    const pd_components *of = &s->reactive->components;
    double slope[PD_SPECIES_MAX], one[PD_SPECIES_MAX], along[PD_SPECIES_MAX], flows[PD_SPECIES_MAX];
    double salt[PD_SPECIES_MAX], none[PD_SPECIES_MAX];
    float table[PD_COMPONENTS_DERIVATIVES];
    pdi_layer_salt(w, v, salt, none);
    if (!(w->thick > 0.0)) {
        pdi_layer_slopes(of, w, NULL, w->c, slope);
        for (int k = 0; k < of->count; k++) by[k] = (float)(slope[k] + salt[k]);
        return;
    }
    double back = 1.0;
    pdi_layer_slopes(film, w, s->scale, w->at, slope);
    for (int k = 0; k < of->count; k++) back -= slope[k] * w->kind->gain[k] * (w->thick + w->creep * v);
    back = pd_max(back, PDI_LAYER_RISE);
    pdi_components_compute_derivatives_single(of, w->c, table);
    for (int k = 0; k < of->count; k++) {
        double sum = salt[k];
        memset(one, 0, sizeof one);
        one[k] = 1.0;
        pdi_components_apply_derivatives(of, table, one, along);
        for (int n = 0; n < of->solutes; n++) along[n] *= s->scale[n];
        pdi_components_compute_totals(of, along, flows);
        for (int j = 0; j < of->count; j++) sum += slope[j] * flows[j];
        by[k] = (float)(sum / back);
    }
}

/* ---- how the speed of a node follows, with migration ---- */

/* Changes of the curve of the electrode with each solute that it reads, and with F phi/(R T): *lift. */
static void pdi_layer_bend(const pdi_terms *w, double *by, double *lift)
{
    const pd_etch *s = w->s;
    double c[PD_SPECIES_MAX], psi = w->psi + w->lift, stride = PDI_LAYER_LIFT_STRIDE;
    memcpy(c, w->surface, sizeof c);
    for (int n = 0; n < s->film.solutes; n++) {
        by[n] = 0.0;
        if (!(w->reads >> n & 1u) && !((w->reads & PDI_LAYER_PH) && n == s->reactive->proton)) continue;
        double from = c[n], step = PDI_LAYER_STRIDE * pd_max(from, PDI_LAYER_NOTHING);
        c[n] = from + step;
        by[n] = pdi_terms_curve(w, c, psi);
        c[n] = from - step;
        by[n] = (by[n] - pdi_terms_curve(w, c, psi)) / (2.0 * step);
        c[n] = from;
        if (!(fabs(by[n]) < HUGE_VAL)) by[n] = 0.0;
    }
    *lift = (pdi_terms_curve(w, c, psi + stride) - pdi_terms_curve(w, c, psi - stride)) / (2.0 * stride);
    if (!(fabs(*lift) < HUGE_VAL)) *lift = 0.0;
}

/* The law at the surface with a change of one concentration. */
static double pdi_layer_moved(const pdi_terms *w, double *c, int n, double change)
{
    double from = c[n];
    c[n] = pd_max(from + change, 0.0);
    double v = pdi_terms_law(w, c, w->psi + w->lift);
    c[n] = from;
    return v;
}

/* The law jumps with solutes m and n, by `step` of m: the change of n that undoes it, in the sense of `sign`. */
static double pdi_layer_undone(const pdi_terms *w, double *c, int m, double step, int n, double sign)
{
    double from = c[m], level = 0.5 * (pdi_layer_moved(w, c, m, step) + pdi_layer_moved(w, c, m, -step));
    double low = 0.0, high = PDI_LAYER_STRIDE * PDI_LAYER_STRIDE * pd_max(c[n], PDI_LAYER_NOTHING);
    int above = pdi_layer_moved(w, c, m, step) > level, found = 0;
    c[m] = pd_max(from + step, 0.0);
    for (int k = 0; k < PDI_LAYER_DOUBLINGS && !found; k++) {
        found = (pdi_layer_moved(w, c, n, sign * high) > level) != above;
        if (!found) low = high;
        if (!found) high *= 2.0;
    }
    for (int k = 0; k < PDI_LAYER_HALVINGS; k++) {
        double middle = 0.5 * (low + high);
        if ((pdi_layer_moved(w, c, n, sign * middle) > level) != above) high = middle;
        else low = middle;
    }
    c[m] = from;
    return found ? high : HUGE_VAL;
}

/* Changes of the law with each solute that it reads, and with F phi/(R T): *lift. Where it jumps, both sides count, and
 * the changes are in the ratios that keep to the jump. */
static void pdi_layer_gradient(const pdi_terms *w, double *by, double *lift)
{
    const pd_etch *s = w->s;
    double c[PD_SPECIES_MAX], stride[PD_SPECIES_MAX], psi = w->psi + w->lift;
    int jumps[PD_SPECIES_MAX], first = -1;
    memcpy(c, w->surface, sizeof c);
    for (int n = 0; n < s->film.solutes; n++) {
        double wide;
        stride[n] = PDI_LAYER_STRIDE * pd_max(c[n], PDI_LAYER_NOTHING);
        by[n] = 0.0;
        jumps[n] = 0;
        if (!(w->kind->law.reads >> n & 1u) && !(w->kind->law.reads_ph && n == s->reactive->proton)) continue;
        by[n] = (pdi_layer_moved(w, c, n, stride[n]) - pdi_layer_moved(w, c, n, -stride[n])) / (2.0 * stride[n]);
        wide = pdi_layer_moved(w, c, n, 2.0 * stride[n]) - pdi_layer_moved(w, c, n, -2.0 * stride[n]);
        wide /= 4.0 * stride[n];
        if (!(fabs(by[n]) < HUGE_VAL) || !(fabs(wide) < HUGE_VAL)) by[n] = wide = 0.0;
        jumps[n] = fabs(by[n] - wide) > PDI_LAYER_JUMP * fabs(by[n]);
        if (jumps[n] && (first < 0 || stride[n] > stride[first])) first = n;
    }
    for (int n = 0; n < s->film.solutes; n++) {
        if (!jumps[n] || n == first) continue;
        double change = pdi_layer_undone(w, c, first, stride[first], n, by[n] * by[first] > 0.0 ? -1.0 : 1.0);
        by[n] = copysign(fabs(by[first]) * stride[first] / change, by[n]);
    }
    *lift = 0.0;
    if (!s->desc.reads_phi) return;
    *lift = pdi_terms_law(w, c, psi + PDI_LAYER_LIFT_STRIDE) - pdi_terms_law(w, c, psi - PDI_LAYER_LIFT_STRIDE);
    *lift = fabs(*lift) < HUGE_VAL ? *lift / (2.0 * PDI_LAYER_LIFT_STRIDE) : 0.0;
}

typedef double pdi_layer_table[PD_SPECIES_MAX + 1][2 * PD_SPECIES_MAX + 3];

/* Totals of what leaves the surface of the film follow those of its concentrations (columns of components), the lift
 * (one more), and, on the right, the speed and the flow (two more) and the totals of the node (those of components). */
static void pdi_layer_balances(const pd_components *film, const pdi_terms *w, const float *own, pdi_layer_table a)
{
    const pd_etch *s = w->s;
    const pd_components *of = &s->reactive->components;
    double one[PD_SPECIES_MAX], along[PD_SPECIES_MAX], sum[PD_SPECIES_MAX], left[PD_SPECIES_MAX];
    float node[PD_COMPONENTS_DERIVATIVES];
    int count = of->count;
    memset(along, 0, sizeof along);
    memset(a, 0, sizeof(pdi_layer_table));
    memset(left, 0, sizeof left);
    pdi_components_compute_derivatives_single(of, w->c, node);
    if (s->surface) pdi_components_compute_totals(of, w->surface, left);
    for (int j = 0; j < count; j++) {
        memset(one, 0, sizeof one);
        one[j] = 1.0;
        pdi_components_apply_derivatives(film, own, one, along);
        for (int n = 0; n < of->solutes; n++)
            along[n] *= s->scale[n] * pdi_layer_share(-of->charge[n] * w->lift) + w->sweep;
        pdi_components_compute_totals(of, along, sum);
        for (int k = 0; k < count; k++) a[k][j] = sum[k];
        pdi_components_apply_derivatives(of, node, one, along);
        for (int n = 0; n < of->solutes; n++) along[n] *= s->scale[n] * pdi_layer_share(of->charge[n] * w->lift);
        pdi_components_compute_totals(of, along, sum);
        for (int k = 0; k < count; k++) a[k][count + 3 + j] = sum[k];
        a[count][j] = of->charge[of->component_solute[j]];
        a[j][count + 1] = (s->surface ? w->kind->gain[j] - left[j] / s->desc.solid : w->kind->gain[j]) * w->thick;
        if (w->electrode >= 0) a[j][count + 2] = s->part_gain[w->electrode * count + j] * w->way;
    }
    for (int n = 0; n < of->solutes; n++) {
        double z = of->charge[n];
        along[n] = -z * s->scale[n] * (pdi_layer_share_by(-z * w->lift) * w->surface[n] +
                                       pdi_layer_share_by(z * w->lift) * w->c[n]);
    }
    pdi_components_compute_totals(of, along, sum);
    for (int k = 0; k < count; k++) a[k][count] = sum[k];
    if (fabs(w->lift) < PDI_LAYER_LIFT) return;
    for (int j = 0; j < count; j++) a[count][j] = 0.0; /* it goes no further */
    a[count][count] = 1.0;
}

/* How a rate at the surface follows what changes there: the speed, the flow, then the totals. */
static void pdi_layer_chain(const pd_components *film, const pdi_terms *w, const float *own, pdi_layer_table a,
                           const double *gradient, double lift, double *slope)
{
    const pd_components *of = &w->s->reactive->components;
    double along[PD_SPECIES_MAX], change[PD_SPECIES_MAX];
    int count = of->count, films = w->thick + w->way > 0.0;
    for (int j = 0; j <= count + 1; j++) {
        for (int k = 0; k < count; k++) change[k] = films ? a[k][count + 1 + j] : k == j - 2 ? 1.0 : 0.0;
        pdi_components_apply_derivatives(films ? film : of, own, change, along);
        slope[j] = films ? lift * a[count][count + 1 + j] : 0.0;
        for (int n = 0; n < of->solutes; n++) slope[j] += gradient[n] * along[n];
    }
}

/* How law and curve at the surface follow the speed, the flow and the totals of the node, and F phi/(R T) there. */
typedef struct pdi_layer_slopes_of {
    double law[PD_SPECIES_MAX + 2], curve[PD_SPECIES_MAX + 2];
    double lift, bend;
} pdi_layer_slopes_of;

static void pdi_layer_tangent(const pd_components *film, const pdi_terms *w, int goes, pdi_layer_slopes_of *t)
{
    const pd_components *of = &w->s->reactive->components;
    double gradient[PD_SPECIES_MAX];
    float own[PD_COMPONENTS_DERIVATIVES];
    pdi_layer_table a;
    int count = of->count, films = w->thick + w->way > 0.0;
    memset(t, 0, sizeof *t);
    pdi_components_compute_derivatives_single(films ? film : of, w->surface, own);
    if (films) {
        pdi_layer_balances(film, w, own, a);
        pdi_gauss_jordan_solve(count + 1, 2 * count + 3, 2 * PD_SPECIES_MAX + 3, a[0]);
    }
    if (goes) {
        pdi_layer_gradient(w, gradient, &t->lift);
        pdi_layer_chain(film, w, own, a, gradient, t->lift, t->law);
    }
    if (w->electrode < 0) return;
    pdi_layer_bend(w, gradient, &t->bend);
    pdi_layer_chain(film, w, own, a, gradient, t->bend, t->curve);
}

/* How the speed of a node and the flow of its electrode follow its totals, and F phi/(R T) there: drive[0], [1]. */
static void pdi_layer_derive_charged(const pd_components *film, const pdi_terms *w, double v, float *by,
                                     float *flow_by, double drive[2])
{
    pdi_layer_slopes_of t;
    double law[PD_SPECIES_MAX], curve[PD_SPECIES_MAX];
    pdi_layer_tangent(film, w, by != NULL, &t);
    pdi_layer_salt(w, v, law, curve);
    for (int k = 0; k < film->count; k++) {
        if (by) t.law[2 + k] += law[k];
        t.curve[2 + k] += curve[k];
    }
    double one = pd_max(1.0 - t.law[0], PDI_LAYER_RISE), two = pd_max(1.0 - t.curve[1], PDI_LAYER_RISE);
    double back = pd_max(one * two - t.law[1] * t.curve[0], PDI_LAYER_RISE * one * two);
    for (int k = 0; k < film->count; k++) {
        if (by) by[k] = (float)((two * t.law[2 + k] + t.law[1] * t.curve[2 + k]) / back);
        if (flow_by) flow_by[k] = (float)((one * t.curve[2 + k] + t.curve[0] * t.law[2 + k]) / back);
    }
    drive[0] = (two * t.lift + t.law[1] * t.bend) / back;
    drive[1] = (one * t.bend + t.curve[0] * t.lift) / back;
}

/* Speed and flow of an electrode by Newton's method from guesses. 0: it does not get there, and they are searched. */
static int pdi_layer_newton(pd_components *film, pdi_terms *w, int goes, double *speed)
{
    double v = goes ? pd_max(*speed, 0.0) : 0.0, f = w->guess;
    for (int step = 0; step < PDI_LAYER_NEWTON; step++) {
        pdi_layer_slopes_of t;
        if (w->reads) w->flow = f;
        if (!pdi_layer_lift(film, w, v)) return 0;
        double law = goes ? pdi_layer_asked(w, w->surface, w->psi + w->lift) : 0.0;
        double curve = w->reads ? pdi_terms_curve(w, w->surface, w->psi + w->lift) : w->flow;
        f = w->flow;
        if (w->odd || !(fabs(law - v) < HUGE_VAL) || !(fabs(curve - f) < HUGE_VAL)) return 0;
        int met = fabs(law - v) <= PDI_LAYER_MET * law && fabs(curve - f) <= PDI_LAYER_MET * fabs(f);
        if (met && (!goes || !(law > 0.0) || !(fabs(law - v) > 0.0))) break;
        pdi_layer_tangent(film, w, goes, &t);
        double one = 1.0 - t.law[0], two = 1.0 - t.curve[1], back = one * two - t.law[1] * t.curve[0];
        if (!(one > 0.0) || !(two > 0.0) || !(back > 0.0)) return 0;
        double dv = (two * (law - v) + t.law[1] * (curve - f)) / back;
        f += (one * (curve - f) + t.curve[0] * (law - v)) / back;
        v += dv;
        if (!(v >= 0.0) || !(fabs(f) < HUGE_VAL)) return 0;
        if (met) break;
        if (step + 1 == PDI_LAYER_NEWTON) return 0;
    }
    if (w->reads) w->flow = f;
    *speed = v;
    return 1;
}

PDI_FN double pdi_layer_at(const pd_etch *s, int metal, int32_t node, int32_t place, double thick, double guess)
{
    pd_components film = s->film;
    pdi_terms w;
    pdi_terms_enter(s, metal, node, place, thick, &film, &w);
    return pdi_layer_find(&film, &w, guess);
}

PDI_FN void pdi_layer_bare(const pd_etch *s, int32_t p, double drop, double *speed, double *flow)
{
    pd_components film = s->film;
    pdi_terms w;
    pdi_terms_enter(s, pdi_etch_which(s, p), s->node[p], p, 0.0, &film, &w);
    w.level = w.psi * s->reactive->migration.volt + drop;
    *speed = pdi_etch_of(s, p)->law.law && s->weight[p] > 0.0 ? pdi_terms_number(&w, w.c, w.psi) : 0.0;
    if (*speed < 0.0) *speed = 0.0;
    *flow = w.electrode >= 0 ? pdi_terms_curve(&w, w.c, w.psi) : 0.0;
}

PDI_FN int pdi_layer_surface(const pd_etch *s, int32_t p, double *c, double *psi)
{
    pd_components film = s->film;
    pdi_terms w;
    double speed = pdi_etch_of(s, p)->law.law && s->weight[p] > 0.0 ? *pdi_etch_speed(s, p) : 0.0;
    pdi_terms_enter(s, pdi_etch_which(s, p), s->node[p], p, s->thick[p], &film, &w);
    w.flow = w.guess;
    if (w.thick + w.way > 0.0 && !pdi_layer_lift(&film, &w, speed)) return 0;
    memcpy(c, w.surface, (size_t)film.solutes * sizeof *c);
    *psi = w.psi + w.lift;
    return 1;
}

PDI_FN int pdi_layer_reads(const pd_etch *s, int32_t p, double *c, double *ph, double *phi)
{
    pd_components film = s->film;
    pdi_terms w;
    double flows[PD_SPECIES_MAX], speed = s->weight[p] > 0.0 ? *pdi_etch_speed(s, p) : 0.0;
    pdi_terms_enter(s, pdi_etch_which(s, p), s->node[p], p, s->thick[p], &film, &w);
    w.flow = w.guess;
    memcpy(c, w.c, (size_t)film.solutes * sizeof *c);
    if (w.thick + w.way > 0.0 && s->reactive->migration.on) {
        if (!pdi_layer_lift(&film, &w, speed)) return 0;
        memcpy(c, w.surface, (size_t)film.solutes * sizeof *c);
    } else if (w.thick > 0.0) {
        for (int k = 0; k < film.count; k++) flows[k] = w.flows[k] + w.kind->gain[k] * w.thick * speed;
        if (pdi_components_solve(&film, flows, w.at) != PD_OK) return 0;
        for (int n = 0; n < film.solutes; n++) c[n] = w.at[n] / s->scale[n];
    }
    pdi_terms_read(&w, c, w.psi + w.lift, ph, phi);
    return 1;
}

/* ---- all places ---- */

/* What is at the surface fills what metal leaves there; it is neutral. */
static void pdi_layer_note(pd_etch *s, int32_t p, const pdi_terms *w)
{
    const pd_reactive *r = s->reactive;
    double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
    int finite = 1;
    for (int n = 0; n < r->components.solutes; n++) finite = finite && w->surface[n] < HUGE_VAL;
    memcpy(c, finite ? w->surface : w->c, sizeof c);
    pdi_migration_neutralise(&r->migration, c);
    pdi_components_compute_totals(&r->components, c, sum);
    for (int k = 0; k < r->components.count; k++) s->surface[k * (int64_t)r->grid->total + p] = sum[k];
}

/* 1: metal that would give a charge, where no current passes. */
static int pdi_layer_open(const pd_etch *s, int32_t p)
{
    return s->open && s->open[p] && fabs(pdi_etch_of(s, p)->charge) > PDI_LAYER_CHARGED;
}

/* A place whose metal dissolves, with its derivatives or without. */
static void pdi_layer_place(pd_etch *s, int32_t p, int derive)
{
    pd_components film = s->film;
    pdi_terms w;
    int count = film.count, has = pdi_etch_of(s, p)->law.law && s->weight[p] > 0.0, goes = has && !pdi_layer_open(s, p);
    if (has && !goes) *pdi_etch_speed(s, p) = 0.0;
    double *v = pdi_etch_speed(s, p), still = 0.0, drive[2];
    if (!goes) v = &still;
    pdi_terms_enter(s, pdi_etch_which(s, p), s->node[p], p, s->thick[p], &film, &w);
    if (!derive) {
        if (w.electrode >= 0 && pdi_layer_newton(&film, &w, goes, v)) {
            s->flow[p] = w.flow;
            if (s->surface && goes) pdi_layer_note(s, p, &w);
            return;
        }
        if (goes) *v = pdi_layer_find(&film, &w, *v);
        if (s->electrode) {
            int found = fabs(*v) < HUGE_VAL && (w.electrode < 0 || pdi_layer_settle(&film, &w, *v));
            s->flow[p] = found ? w.flow : (double)NAN;
        }
        if (s->surface && goes) pdi_layer_note(s, p, &w);
        return;
    }
    w.flow = w.guess;
    if (w.electrode >= 0) pdi_layer_lift(&film, &w, *v);
    else if (goes) pdi_layer_given(&film, &w, *v);
    if (!s->drive) {
        pdi_layer_derive(&film, &w, *v, s->by + (int64_t)p * count);
        return;
    }
    if (!goes) memset(s->by + (int64_t)p * count, 0, (size_t)count * sizeof *s->by);
    pdi_layer_derive_charged(&film, &w, *v, goes ? s->by + (int64_t)p * count : NULL,
                             s->electrode ? s->flow_by + (int64_t)p * count : NULL, drive);
    s->drive[p] = (float)drive[0];
    if (s->electrode) s->flow_drive[p] = (float)drive[1];
}

/* 1: a place without a speed has none because its law is no number. */
static int pdi_layer_odd(const pd_etch *s, int32_t p)
{
    pd_components film = s->film;
    pdi_terms w;
    pdi_terms_enter(s, pdi_etch_which(s, p), s->node[p], p, s->thick[p], &film, &w);
    pdi_layer_find(&film, &w, 0.0);
    return w.odd;
}

PDI_FN void pdi_layer_solve(const pd_ctx *ctx, pd_etch *s, int circuit, int derive)
{
    int count = s->reactive->components.count;
    int nt = pd_par_threads(ctx, (int64_t)s->count * count * count * PDI_LAYER_STEPS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < s->count; p++)
        if (circuit < 0 || pdi_etch_circuit(s, p) == circuit) pdi_layer_place(s, p, derive);
    if (derive) return;
    for (int32_t p = 0; p < s->count && !s->odd; p++)
        if (s->weight[p] > 0.0 && !(fabs(*pdi_etch_speed(s, p)) < HUGE_VAL) && pdi_layer_odd(s, p)) s->odd = 1 + p;
}
