/* etch: see etch.h
 *
 * Design: in the film the sums over species of D times concentration, by components, are linear, since reactions in
 * equilibrium keep them. Concentrations times their diffusivities follow the same mass action with other constants, so
 * the surface is found by the solver of components. Coefficients of activity are those of the node.
 */
#include "react/etch.h"
#include "core/par.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Least diffusivity of a species in the film, over the mean one. */
#define PDI_ETCH_LEAST 1e-6
/* Steps of a search, and the share of the speed to which it is found. */
#define PDI_ETCH_STEPS 200
#define PDI_ETCH_CLOSE 1e-15
/* Factor by which a bracket of the speed grows first; it is squared each time. */
#define PDI_ETCH_BRACKET 2.0
/* Relative change of what a law reads by which its slope is found. */
#define PDI_ETCH_STRIDE 1e-6
/* [mol/m3] that counts as nothing beside that. */
#define PDI_ETCH_NOTHING 1e-30
/* What is left at least of 1 less the slope of a rising law behind its film. */
#define PDI_ETCH_RISE 0.05

/* ---- the surface of a node ---- */

/* A node and its film. */
typedef struct pdi_etch_work {
    const pd_etch *s;
    int32_t node;
    double thick;
    double davies;                    /* ln gamma of a charge of 1 */
    double flows[PD_SPECIES_MOST];    /* [mol/m3] of components at the node: sums of what diffuses */
    double c[PD_SPECIES_MOST];        /* [mol/m3] at the node */
    double at[PD_SPECIES_MOST];       /* [mol/m3] times `scale`: at the surface, the last that was found */
} pdi_etch_work;

static void pdi_etch_enter(const pd_etch *s, int32_t node, double thick, pd_components *film, pdi_etch_work *w)
{
    const pd_components *of = &s->reactive->components;
    w->s = s;
    w->node = node;
    w->thick = thick;
    pdi_reactive_get(s->reactive, s->reactive->c, node, w->c);
    w->davies = pdi_components_activity(of, w->c);
    for (int n = 0; n < of->solutes; n++) w->at[n] = s->scale[n] * w->c[n];
    if (!(thick > 0.0)) return;
    for (int n = 0; n < of->solutes; n++) {
        film->ln_k[n] = s->film.ln_k[n] - of->charge[n] * of->charge[n] * w->davies;
        for (int k = 0; k < of->joined; k++) {
            int z = of->charge[of->master[k]];
            film->ln_k[n] += of->m[k][n] * z * z * w->davies;
        }
    }
    for (int k = 0; k < of->joined; k++) film->ln_k[of->master[k]] = 0.0;
    pdi_components_totals(of, w->at, w->flows);
}

/* The law for the concentrations c. */
static double pdi_etch_law(const pdi_etch_work *w, const double *c)
{
    const pd_reactive *r = w->s->reactive;
    double ph = NAN;
    if (r->proton >= 0) ph = 3.0 - (log(fmax(c[r->proton], DBL_MIN)) + w->davies) / log(10.0);
    return fmax(w->s->desc.law(w->s->desc.user, w->node, c, ph, w->s->time), 0.0);
}

/* The law at the surface, where metal dissolves at v [m/s]. */
static double pdi_etch_given(const pd_components *film, pdi_etch_work *w, double v)
{
    const pd_etch *s = w->s;
    double flows[PD_SPECIES_MOST], c[PD_SPECIES_MOST];
    if (!(w->thick > 0.0)) return pdi_etch_law(w, w->c);
    for (int k = 0; k < film->count; k++) flows[k] = w->flows[k] + s->gain[k] * w->thick * v;
    if (pdi_components_solve(film, flows, w->at) != PD_OK) return NAN;
    for (int n = 0; n < film->solutes; n++) c[n] = w->at[n] / s->scale[n];
    return pdi_etch_law(w, c);
}

/* A bracket of v = law(v) around a guess between 0 and what the node would give: law(*a) > *a, law(*b) <= *b, with the
 * differences. 0: the law is not finite. */
static int pdi_etch_bracket(const pd_components *film, pdi_etch_work *w, double guess, double first, double *a,
                               double *above, double *b, double *below)
{
    double factor = PDI_ETCH_BRACKET, v = guess > 0.0 ? guess : first;
    *a = 0.0;
    *above = first;
    double g = pdi_etch_given(film, w, v) - v;
    for (int step = 0; step < PDI_ETCH_STEPS && fabs(g) < HUGE_VAL; step++) {
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
        double there = pdi_etch_given(film, w, next) - next;
        if (!(fabs(there) < HUGE_VAL)) return 0;
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

/* The speed of a node: false position (Illinois), halved where that is slow. */
static double pdi_etch_find(const pd_components *film, pdi_etch_work *w, double guess)
{
    double a, b = 0.0, above, below = 0.0, first = pdi_etch_given(film, w, 0.0);
    if (!(fabs(first) < HUGE_VAL)) return NAN;
    if (!(first > 0.0) || !(w->thick > 0.0)) return first;
    if (!pdi_etch_bracket(film, w, guess, first, &a, &above, &b, &below)) return NAN;
    for (int step = 0; step < PDI_ETCH_STEPS && b - a > PDI_ETCH_CLOSE * b; step++) {
        double v = a + (b - a) * (above / (above - below));
        if (step % 4 == 3 || !(v > a) || !(v < b)) v = a + 0.5 * (b - a);
        if (!(v > a) || !(v < b)) break;
        double g = pdi_etch_given(film, w, v) - v;
        if (!(fabs(g) < HUGE_VAL)) return NAN;
        if (g > 0.0) {
            a = v;
            above = g;
            below *= 0.5;
        } else {
            b = v;
            below = g;
            above *= 0.5;
            if (!(g < 0.0)) break;
        }
    }
    return b;
}

/* Change of the law with concentrations that change by `along`, per unit of it. Both sides of a jump count. */
static double pdi_etch_slope(const pdi_etch_work *w, const double *c, const double *along)
{
    const pd_etch *s = w->s;
    double least = HUGE_VAL, up[PD_SPECIES_MOST], down[PD_SPECIES_MOST];
    for (int n = 0; n < s->film.solutes; n++) {
        int reads = (s->desc.reads >> n & 1u) || (s->desc.reads_ph && n == s->reactive->proton);
        if (reads && fabs(along[n]) > 0.0) least = fmin(least, fmax(c[n], PDI_ETCH_NOTHING) / fabs(along[n]));
    }
    if (!(least < HUGE_VAL)) return 0.0;
    double stride = PDI_ETCH_STRIDE * least;
    for (int n = 0; n < s->film.solutes; n++) {
        up[n] = fmax(c[n] + stride * along[n], 0.0);
        down[n] = fmax(c[n] - stride * along[n], 0.0);
    }
    double change = (pdi_etch_law(w, up) - pdi_etch_law(w, down)) / (2.0 * stride);
    return fabs(change) < HUGE_VAL ? change : 0.0;
}

/* How the law at the surface follows what diffuses: slope [components] [m4/mol/s]. */
static void pdi_etch_slopes(const pd_components *system, const pdi_etch_work *w, const double *scale,
                               const double *at, double *slope)
{
    float table[PD_SPECIES_MOST * (PD_SPECIES_MOST + 1)];
    double c[PD_SPECIES_MOST], one[PD_SPECIES_MOST], along[PD_SPECIES_MOST];
    pdi_components_derive(system, at, table);
    for (int n = 0; n < system->solutes; n++) c[n] = at[n] / (scale ? scale[n] : 1.0);
    for (int k = 0; k < system->count; k++) {
        memset(one, 0, sizeof one);
        one[k] = 1.0;
        pdi_components_follow(system, table, one, along);
        for (int n = 0; n < system->solutes && scale; n++) along[n] /= scale[n];
        slope[k] = pdi_etch_slope(w, c, along);
    }
}

/* How the speed of a node follows its totals. */
static void pdi_etch_derive(const pd_components *film, const pdi_etch_work *w, float *by)
{
    const pd_etch *s = w->s;
    const pd_components *of = &s->reactive->components;
    double slope[PD_SPECIES_MOST], one[PD_SPECIES_MOST], along[PD_SPECIES_MOST], flows[PD_SPECIES_MOST];
    float table[PD_SPECIES_MOST * (PD_SPECIES_MOST + 1)];
    if (!(w->thick > 0.0)) {
        pdi_etch_slopes(of, w, NULL, w->c, slope);
        for (int k = 0; k < of->count; k++) by[k] = (float)slope[k];
        return;
    }
    double back = 1.0;
    pdi_etch_slopes(film, w, s->scale, w->at, slope);
    for (int k = 0; k < of->count; k++) back -= slope[k] * s->gain[k] * w->thick;
    back = fmax(back, PDI_ETCH_RISE);
    pdi_components_derive(of, w->c, table);
    for (int k = 0; k < of->count; k++) {
        double sum = 0.0;
        memset(one, 0, sizeof one);
        one[k] = 1.0;
        pdi_components_follow(of, table, one, along);
        for (int n = 0; n < of->solutes; n++) along[n] *= s->scale[n];
        pdi_components_totals(of, along, flows);
        for (int j = 0; j < of->count; j++) sum += slope[j] * flows[j];
        by[k] = (float)(sum / back);
    }
}

PDI_FN double pdi_etch_at(const pd_etch *s, int32_t node, double thick, double guess)
{
    pd_components film = s->film;
    pdi_etch_work w;
    pdi_etch_enter(s, node, thick, &film, &w);
    return pdi_etch_find(&film, &w, guess);
}

/* ---- all of them ---- */

PDI_FN void pdi_etch_solve(const pd_ctx *ctx, pd_etch *s, int derive)
{
    int count = s->reactive->components.count;
    int nt = pdi_par_threads(ctx, (int64_t)s->count * count * count * PDI_ETCH_STEPS);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < s->count; p++) {
        pd_components film = s->film;
        pdi_etch_work w;
        pdi_etch_enter(s, s->node[p], s->thick[p], &film, &w);
        if (derive) {
            pdi_etch_given(&film, &w, s->speed[s->node[p]]);
            pdi_etch_derive(&film, &w, s->by + (int64_t)p * count);
        } else {
            s->speed[s->node[p]] = pdi_etch_find(&film, &w, s->speed[s->node[p]]);
        }
    }
}

void pd_etch_open(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++) s->slot[s->node[p]] = -1;
    s->count = 0;
}

void pd_etch_put(pd_etch *s, int32_t node, double weight, double thick)
{
    s->slot[node] = s->count;
    s->node[s->count] = node;
    s->weight[s->count] = weight;
    s->ahead[s->count] = s->passed[s->count] = 0.0;
    s->thick[s->count++] = thick;
}

PDI_FN void pdi_etch_begin(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++) s->ahead[p] = 0.0;
}

PDI_FN void pdi_etch_pass(pd_etch *s, double dt)
{
    pd_reactive *r = s->reactive;
    pdi_sum sum = {0.0, 0.0};
    for (int32_t p = 0; p < s->count; p++) {
        int32_t i = s->node[p];
        s->ahead[p] += dt * s->speed[i];
        pdi_sum_add(&sum, pdi_grid_circumference(r->grid, i) * s->weight[p] * s->speed[i]);
    }
    double amount = dt * r->bonds->stencil->volume * pdi_sum_total(&sum);
    for (int n = 0; n < r->components.solutes; n++) r->in[n] += amount * s->shed[n];
}

PDI_FN void pdi_etch_accept(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++) s->passed[p] += s->ahead[p];
    pdi_etch_begin(s);
}

/* ---- the object ---- */

PDI_COLD_BEGIN
PDI_FN void pdi_etch_list(pdi_owner *owner, void *object)
{
    pd_etch *etch = (pd_etch *)object;
    if (!etch->reactive) return;
    int64_t total = etch->reactive->grid->total;
    PDI_ARRAY(owner, etch, node, total, "1");
    PDI_ARRAY(owner, etch, slot, total, "1");
    PDI_ARRAY(owner, etch, weight, total, "mol/m4");
    PDI_ARRAY(owner, etch, thick, total, "mol s/m4");
    PDI_STATE(owner, etch, speed, total, "m/s");
    PDI_ARRAY(owner, etch, ahead, total, "m");
    PDI_ARRAY(owner, etch, passed, total, "m");
    PDI_ARRAY(owner, etch, split, total, "m/s");
    PDI_ARRAY(owner, etch, by, etch->reactive->components.count * total, "m4/mol/s");
}

/* The system of concentrations times their diffusivities: ln c' = ln K + ln d + sum m (ln c'_master - ln d_master). */
static void pdi_etch_film(pd_etch *s)
{
    const pd_components *of = &s->reactive->components;
    s->film = *of;
    s->film.debye = 0.0;
    for (int n = 0; n < of->solutes; n++) s->scale[n] = fmax(s->reactive->ratio[n], PDI_ETCH_LEAST);
    for (int n = 0; n < of->solutes; n++) {
        s->film.ln_k[n] += log(s->scale[n]);
        for (int k = 0; k < of->joined; k++) s->film.ln_k[n] -= of->m[k][n] * log(s->scale[of->master[k]]);
    }
}

pd_status pd_etch_build(pd_ctx *ctx, pd_reactive *r, const pd_etch_desc *desc, pd_etch *s)
{
    memset(s, 0, sizeof *s);
    if (!desc->law) return pdi_fail(ctx, PD_ERR_ARGUMENT, "etch", "there is no law");
    s->desc = *desc;
    s->desc.shed = NULL;
    s->reactive = r;
    for (int i = 0; i < r->desc.count && desc->shed; i++)
        if (r->components.place[i] >= 0) s->shed[r->components.place[i]] = desc->shed[i];
    pdi_components_totals(&r->components, s->shed, s->gain);
    pdi_etch_film(s);
    pd_status status = pdi_owner_build(ctx, pdi_etch_list, s);
    if (status < 0) {
        pd_etch_free(ctx, s);
        return status;
    }
    for (int32_t i = 0; i < r->grid->total; i++) s->slot[i] = -1;
    r->surface = s;
    r->linear = 0;
    return PD_OK;
}

void pd_etch_free(pd_ctx *ctx, pd_etch *s)
{
    if (s->reactive) s->reactive->surface = NULL;
    pdi_owner_free(ctx, pdi_etch_list, s);
    memset(s, 0, sizeof *s);
}
PDI_COLD_END
