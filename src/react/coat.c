/* coat: see coat.h */
#include "react/coat.h"
#include "core/par.h"
#include "react/etch.h"
#include "solve/sdirk.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Error of the equations of a place in each of their steps, where the caller gives none. */
#define PDI_COAT_TOLERANCE 1e-10
/* So often a step is made shorter before a rate that is not finite is refused. */
#define PDI_COAT_TRIALS 6
/* [cells] Places are looked for this far from a node. */
#define PDI_COAT_NEAR 2
/* Scalar operations of a place and component, to decide on threads. */
#define PDI_COAT_WORK 400

PDI_COLD_BEGIN
PDI_FN void pdi_coat_list(pdi_array_visitor *owner, void *object)
{
    pd_coat *coat = (pd_coat *)object;
    int64_t total = coat->reactive ? coat->reactive->grid->total : 0, states = coat->desc.count;
    if (!coat->reactive) return;
    PDI_ARRAY_STATE(owner, coat, on, total, "1");
    PDI_ARRAY(owner, coat, was, total, "1");
    PDI_ARRAY(owner, coat, node, total, "1");
    PDI_ARRAY_STATE(owner, coat, value, states * total, "");
    PDI_ARRAY(owner, coat, start, states * total, "");
    PDI_ARRAY(owner, coat, middle, states * total, "");
    if (coat->desc.stages) PDI_ARRAY(owner, coat, ending, states * total, "");
    PDI_ARRAY_STATE(owner, coat, fresh, coat->columns * total, "");
    PDI_ARRAY(owner, coat, slope, coat->columns * total, "");
    PDI_ARRAY(owner, coat, first, coat->columns * total, "");
    PDI_ARRAY(owner, coat, way, coat->columns * total, "");
    PDI_ARRAY(owner, coat, off, total, "1");
    PDI_SCALAR_STATE(owner, coat, last, "s");
    PDI_SCALAR_STATE(owner, coat, begun, "1");
    for (int k = 0; k < PD_COAT_MOST; k++) PDI_SCALAR_STATE(owner, coat, size[k], "");
}

PDI_FN void pdi_coat_columns(pd_coat *s)
{
    for (int n = 0; n < s->reactive->components.solutes; n++)
        if (s->desc.reads >> n & 1u || (s->desc.reads_ph && n == s->reactive->proton)) s->solute[s->columns++] = n;
    if (s->desc.reads_ph) s->solute[s->columns++] = -1;
    for (int n = 0; n < PD_COAT_AROUND; n++)
        if (s->desc.reads_around >> n & 1u) s->solute[s->columns++] = -2 - n;
}

PDI_FN pd_status pdi_coat_build(pd_ctx *ctx, pd_reactive *r, const pd_coat_desc *desc, pd_coat *s)
{
    memset(s, 0, sizeof *s);
    s->desc = *desc;
    if (!(s->desc.tolerance > 0.0)) s->desc.tolerance = PDI_COAT_TOLERANCE;
    s->reactive = r;
    s->anew = 1;
    pdi_coat_columns(s);
    pdi_etch_film(r, &s->film, s->scale);
    pd_status status = pdi_array_registry_build(ctx, pdi_coat_list, s);
    if (status < 0) {
        pdi_coat_free(ctx, s);
        return status;
    }
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < total; i++)
        for (int k = 0; k < desc->count && r->grid->kind[i] == PD_FLUID; k++) {
            double y = desc->initial(desc->user, k, i);
            s->value[k * total + i] = y;
            if (y >= desc->low[k] && y <= desc->high[k]) continue;
            char place[PDI_GRID_POSITION_LENGTH];
            status =
                pd_fail(ctx, PD_ERR_STATE, "surface", "%s begins with %g at %s m, expected a value from %g to %g",
                        desc->name[k], y, pdi_grid_format_position(r->grid, i, place), desc->low[k], desc->high[k]);
            pdi_coat_free(ctx, s);
            return status;
        }
    return PD_OK;
}

PDI_FN void pdi_coat_free(pd_ctx *ctx, pd_coat *s)
{
    pdi_array_registry_free(ctx, pdi_coat_list, s);
    memset(s, 0, sizeof *s);
}
PDI_COLD_END

/* ---- places ---- */

/* Mean of a state over the nodes with its bit in `of` whose largest distance along an axis is `reach` cells. 0: there
 * is none. */
static int pdi_coat_around(const pd_coat *s, const uint32_t *of, int state, int32_t i, int reach, double *mean)
{
    const pd_grid *grid = s->reactive->grid;
    int found = 0, far;
    double sum = 0.0;
    for (int k = 0; k < pdi_grid_count_cube(reach); k++) {
        int32_t j = pdi_grid_find_cube_node(grid, i, reach, k, &far);
        if (j < 0 || far != reach || !(of[j] >> state & 1u)) continue;
        sum += s->value[(int64_t)state * grid->total + j];
        found++;
    }
    *mean = found ? sum / found : 0.0;
    return found > 0;
}

PDI_FN double pdi_coat_value(const pd_coat *s, int state, int32_t node)
{
    double mean;
    for (int reach = 0; reach <= PDI_COAT_NEAR; reach++)
        if (pdi_coat_around(s, s->on, state, node, reach, &mean)) return mean;
    return s->desc.initial(s->desc.user, state, node);
}

/* A place that is new begins with what those around it had; else with the value of the start. */
static void pdi_coat_inherit(pd_coat *s, int state, int32_t i)
{
    int64_t total = s->reactive->grid->total;
    double *value = &s->value[state * total + i];
    for (int reach = 1; reach <= PDI_COAT_NEAR; reach++)
        if (pdi_coat_around(s, s->was, state, i, reach, value)) return;
    *value = s->desc.initial(s->desc.user, state, i);
}

PDI_FN pd_status pdi_coat_places(pd_ctx *ctx, pd_coat *s)
{
    int64_t total = s->reactive->grid->total;
    memcpy(s->was, s->on, (size_t)total * sizeof *s->on);
    memset(s->on, 0, (size_t)total * sizeof *s->on);
    PD_TRY(s->desc.where(ctx, s->desc.user, s->anew, s->on));
    s->anew = 0;
    s->count = 0;
    for (int32_t i = 0; i < total; i++) {
        if (s->on[i]) s->node[s->count++] = i;
        for (int k = 0; k < s->desc.count && s->begun; k++)
            if ((s->on[i] & ~s->was[i]) >> k & 1u) pdi_coat_inherit(s, k, i);
    }
    s->begun = 1;
    return PD_OK;
}

/* ---- the surface ---- */

/* Concentrations at the surface beside a node that has those of `field`, behind what comes out of metal now. 0: no
 * equilibrium was found. */
static int pdi_coat_near(const pd_coat *s, const double *field, int32_t i, double *c)
{
    const pd_components *of = &s->reactive->components;
    double flows[PD_SPECIES_MAX];
    pd_reactive_get(s->reactive, field, i, c);
    if (!s->desc.film) return 1;
    double davies = pdi_components_compute_ln_gamma(of, c);
    pd_components film = s->film;
    pdi_etch_activities(of, &s->film, davies, &film);
    for (int n = 0; n < of->solutes; n++) c[n] *= s->scale[n];
    pdi_components_compute_totals(of, c, flows);
    s->desc.film(s->desc.user, i, flows);
    if (pdi_components_solve(&film, flows, c) != PD_OK) return 0;
    for (int n = 0; n < of->solutes; n++) c[n] /= s->scale[n];
    return 1;
}

/* ln gamma of a charge of 1 beside c at the surface: with `surface` that of the node. */
static double pdi_coat_activity(const pd_coat *s, int32_t i, const double *c)
{
    double at[PD_SPECIES_MAX];
    if (!s->desc.surface) return pdi_components_compute_ln_gamma(&s->reactive->components, c);
    pd_reactive_get(s->reactive, s->reactive->c, i, at);
    return pdi_components_compute_ln_gamma(&s->reactive->components, at);
}

/* Columns of all places, behind what comes out of metal now; what has no equilibrium is NaN, which rates pass on. */
static void pdi_coat_surface(const pd_ctx *ctx, const pd_coat *s, const double *field, double *column)
{
    int64_t total = s->reactive->grid->total;
    int nt = pd_par_threads(ctx, (int64_t)s->count * PDI_COAT_WORK * s->reactive->components.solutes);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < s->count; p++) {
        double c[PD_SPECIES_MAX], around[PD_COAT_AROUND];
        int32_t i = s->node[p];
        int found = s->columns > 0;
        if (found && s->desc.surface) found = s->desc.surface(s->desc.user, i, c, around);
        else if (found) found = pdi_coat_near(s, field, i, c);
        for (int k = 0; k < s->columns; k++) {
            double value = NAN;
            if (found && s->solute[k] < -1) value = around[-2 - s->solute[k]];
            else if (found) value = s->solute[k] < 0 ? pdi_coat_activity(s, i, c) : c[s->solute[k]];
            column[k * total + i] = value;
        }
    }
}

/* ---- the equations of a place ---- */

typedef struct pdi_coat_work {
    const pd_coat *s;
    int32_t node;
    double from;                  /* [s] columns go from `first` there by `slope` */
    const double *first, *slope;
    int foreseen;                 /* 1: nothing is known of their ends */
    double around[PD_COAT_AROUND];
    double fixed[PD_COAT_MOST];   /* states that the place does not carry */
    int states, of[PD_COAT_MOST]; /* those that it does */
} pdi_coat_work;

/* Column k after a time. A line between two ends keeps their bounds. What is foreseen of a concentration that falls
 * would pass zero: it begins as the line and comes to rest at zero, without a bend where rounding would end steps. */
static double pdi_coat_column(const pdi_coat_work *w, int k, double time)
{
    int64_t at = k * w->s->reactive->grid->total + w->node;
    double first = w->first[at], change = time * w->slope[at];
    if (w->s->solute[k] < 0) return first + change;
    if (w->foreseen && change < 0.0 && first > 0.0) return first / (1.0 - change / first);
    return first + change < 0.0 ? 0.0 : first + change; /* no number stays none */
}

/* What they read at time t. */
static void pdi_coat_read(const pdi_coat_work *w, double t, double *c, double *around, pd_coat_at *at)
{
    const pd_coat *s = w->s;
    double davies = 0.0;
    memset(c, 0, PD_SPECIES_MAX * sizeof *c);
    memcpy(around, w->around, sizeof w->around);
    for (int k = 0; k < s->columns; k++) {
        double value = pdi_coat_column(w, k, t - w->from);
        if (s->solute[k] < -1) around[-2 - s->solute[k]] = value;
        else if (s->solute[k] < 0) davies = value;
        else c[s->solute[k]] = value;
    }
    at->node = w->node;
    at->c = c;
    at->around = around;
    at->time = t;
    at->ph = NAN;
    if (s->desc.reads_ph && s->reactive->proton >= 0)
        at->ph = 3.0 - (log(pd_max(c[s->reactive->proton], DBL_MIN)) + davies) / log(10.0);
}

static void pdi_coat_rates(void *user, double t, const double *y, double *rate)
{
    const pdi_coat_work *w = (const pdi_coat_work *)user;
    double c[PD_SPECIES_MAX], all[PD_COAT_MOST], rates[PD_COAT_MOST], around[PD_COAT_AROUND];
    pd_coat_at at;
    memcpy(all, w->fixed, sizeof all);
    for (int k = 0; k < w->states; k++) all[w->of[k]] = y[k];
    pdi_coat_read(w, t, c, around, &at);
    w->s->desc.rate(w->s->desc.user, &at, all, rates);
    for (int k = 0; k < w->states; k++) rate[k] = rates[w->of[k]];
}

/* The states of place p over dt; values go from `from` to `to` [states][total]. 0, 1 + the state whose rate is not
 * finite, or -1: no steps follow them. */
static int pdi_coat_solve(const pd_coat *s, int32_t p, pdi_coat_work *w, double dt, const double *from, double *to)
{
    int64_t total = s->reactive->grid->total;
    int32_t i = s->node[p];
    double y[PD_STIFF_ODE_MAX_EQUATIONS], low[PD_STIFF_ODE_MAX_EQUATIONS], high[PD_STIFF_ODE_MAX_EQUATIONS],
        size[PD_STIFF_ODE_MAX_EQUATIONS];
    pd_stiff_ode stiff;
    int which = 0;
    w->s = s;
    w->node = i;
    for (int k = 0; k < s->desc.count; k++) {
        w->fixed[k] = from[k * total + i];
        if (!(s->on[i] >> k & 1u)) continue;
        y[w->states] = w->fixed[k];
        low[w->states] = s->desc.low[k];
        high[w->states] = s->desc.high[k];
        size[w->states] = s->size[k];
        w->of[w->states++] = k;
    }
    if (s->desc.around) s->desc.around(s->desc.user, i, w->around);
    memset(&stiff, 0, sizeof stiff);
    stiff.count = w->states;
    stiff.rate = pdi_coat_rates;
    stiff.user = w;
    stiff.low = low;
    stiff.high = high;
    stiff.typical = size;
    stiff.tolerance = s->desc.tolerance;
    pd_stiff_ode_status end = pdi_stiff_ode_solve(&stiff, w->from, w->from + dt, y, &which);
    for (int k = 0; k < w->states; k++) to[w->of[k] * total + i] = y[k];
    if (end == PD_STIFF_ODE_NOT_FINITE) return 1 + w->of[which];
    return end == PD_STIFF_ODE_UNDERFLOW ? -1 : 0;
}

/* What went wrong at a place. */
static pd_status pdi_coat_refuse(pd_ctx *ctx, const pd_coat *s, int32_t p, double t)
{
    char place[PDI_GRID_POSITION_LENGTH];
    int32_t i = s->node[p];
    int state = s->off[p] - 1;
    pdi_grid_format_position(s->reactive->grid, i, place);
    if (state < 0)
        return pd_fail(ctx, PD_ERR_STATE, "surface", "no steps follow the rates of states at %s m from t = %g s on: "
                       "one jumps back and forth or grows beyond all bounds, expected a rate that is continuous, or "
                       "min and max where it ends", place, t);
    return pd_fail(ctx, PD_ERR_STATE, "surface", "the rate of %s is no finite number at %s m (pH %.4g) from t = %g s "
                   "on, where it is %g, expected a law that holds there", s->desc.name[state], place,
                   pd_reactive_ph(s->reactive, i), t, s->start[state * (int64_t)s->reactive->grid->total + i]);
}

/* All places over dt from t; `stuck`: trials after which equations that no steps follow are refused. */
static pd_status pdi_coat_move(pd_ctx *ctx, pd_coat *s, const double *first, const double *slope, double t, double dt,
                               int stuck, int trial, double *to)
{
    int nt = pd_par_threads(ctx, (int64_t)s->count * PDI_COAT_WORK * s->desc.count);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < s->count; p++) {
        pdi_coat_work w;
        memset(&w, 0, sizeof w);
        w.from = t;
        w.first = first;
        w.slope = slope;
        w.foreseen = slope == s->slope;
        s->off[p] = pdi_coat_solve(s, p, &w, dt, s->start, to);
    }
    for (int32_t p = 0; p < s->count; p++)
        if (s->off[p]) {
            int most = s->off[p] < 0 ? stuck : PDI_COAT_TRIALS;
            return trial >= most ? pdi_coat_refuse(ctx, s, p, t) : PD_RETRY;
        }
    return PD_OK;
}

/* ---- steps ---- */

/* Columns at the start of a step, and how they have changed since that of the last one. */
static void pdi_coat_fresh(const pd_ctx *ctx, pd_coat *s)
{
    int64_t total = s->reactive->grid->total;
    pdi_coat_surface(ctx, s, s->reactive->c, s->way);
    for (int k = 0; k < s->columns; k++)
        for (int32_t p = 0; p < s->count; p++) {
            int64_t at = k * total + s->node[p];
            int known = s->last > 0.0 && s->was[s->node[p]];
            double slope = known ? (s->way[at] - s->fresh[at]) / s->last : 0.0;
            s->slope[at] = fabs(slope) < HUGE_VAL ? slope : 0.0;
            s->fresh[at] = s->way[at];
        }
}

PDI_FN pd_status pdi_coat_begin(pd_ctx *ctx, pd_coat *s, double t)
{
    int64_t total = s->reactive->grid->total;
    if (s->desc.solve && !s->desc.surface) PD_TRY(s->desc.solve(ctx, s->desc.user, t));
    PD_TRY(pdi_coat_places(ctx, s));
    memcpy(s->start, s->value, (size_t)(s->desc.count * total) * sizeof *s->value);
    pdi_coat_fresh(ctx, s);
    for (int k = 0; k < s->desc.count; k++)
        for (int32_t p = 0; p < s->count; p++) s->size[k] = pd_max(s->size[k], fabs(s->value[k * total + s->node[p]]));
    return PD_OK;
}

PDI_FN pd_status pdi_coat_stage(pd_ctx *ctx, pd_coat *s, double share)
{
    int64_t count = s->desc.count * (int64_t)s->reactive->grid->total;
    memcpy(s->value, share < 1.0 ? s->middle : s->ending, (size_t)count * sizeof *s->value);
    return s->desc.solve(ctx, s->desc.user, s->from + share * s->span);
}

PDI_FN void pdi_coat_rest(pd_coat *s, double t, double dt)
{
    size_t size = (size_t)(s->desc.count * (int64_t)s->reactive->grid->total) * sizeof *s->value;
    s->from = t;
    s->span = dt;
    memcpy(s->middle, s->value, size);
    memcpy(s->ending, s->value, size);
}

/* To both stages of a step. */
static pd_status pdi_coat_foresee(pd_ctx *ctx, pd_coat *s, double t, double dt, int trial)
{
    double first = PDI_SDIRK_GAMMA * dt;
    pdi_coat_rest(s, t, dt);
    pd_status status = pdi_coat_move(ctx, s, s->fresh, s->slope, t, first, 1, trial, s->middle);
    return status == PD_OK ? pdi_coat_move(ctx, s, s->fresh, s->slope, t, dt, 1, trial, s->ending) : status;
}

PDI_FN pd_status pdi_coat_ahead(pd_ctx *ctx, pd_coat *s, double t, double dt, int trial)
{
    int64_t count = s->desc.count * (int64_t)s->reactive->grid->total;
    if (s->desc.surface) return pdi_coat_foresee(ctx, s, t, dt, trial);
    pd_status status = pdi_coat_move(ctx, s, s->fresh, s->slope, t, 0.5 * dt, 1, trial, s->value);
    if (status != PD_OK) return status;
    memcpy(s->middle, s->value, (size_t)count * sizeof *s->value);
    return s->desc.solve ? s->desc.solve(ctx, s->desc.user, t + 0.5 * dt) : PD_OK;
}

/* What the end of a step differs by from the middle that was foreseen for it: of state k, over the largest of it. The
 * mean over a step is off by a sixth of what the course bends; with `surface` by half of what the end is. */
static double pdi_coat_error(const pd_coat *s, int k)
{
    int64_t total = s->reactive->grid->total;
    double worst = 0.0, size = s->size[k];
    for (int32_t p = 0; p < s->count; p++) {
        int64_t at = k * total + s->node[p];
        if (!(s->on[s->node[p]] >> k & 1u)) continue;
        double bend = (s->start[at] - 2.0 * s->middle[at] + s->value[at]) / 6.0;
        if (s->desc.surface) bend = 0.5 * (s->value[at] - s->ending[at]);
        worst = pd_max(worst, fabs(bend));
        size = pd_max(size, fabs(s->value[at]));
    }
    return worst > 0.0 ? worst / (size * s->desc.rtol) : 0.0;
}

PDI_FN pd_status pdi_coat_behind(pd_ctx *ctx, pd_coat *s, const double *from, double t, double dt, int trial)
{
    int64_t total = s->reactive->grid->total;
    if (!s->desc.surface) pdi_coat_surface(ctx, s, from, s->first);
    else memcpy(s->first, s->fresh, (size_t)(s->columns * total) * sizeof *s->first);
    pdi_coat_surface(ctx, s, s->reactive->c, s->way);
    for (int k = 0; k < s->columns; k++)
        for (int32_t p = 0; p < s->count; p++) {
            int64_t at = k * total + s->node[p];
            s->way[at] = (s->way[at] - s->first[at]) / dt;
        }
    pd_status status = pdi_coat_move(ctx, s, s->first, s->way, t, dt, 0, trial, s->value);
    s->error = 0.0;
    for (int k = 0; k < s->desc.count && status == PD_OK; k++) s->error = pd_max(s->error, pdi_coat_error(s, k));
    return status;
}

PDI_FN void pdi_coat_reads(const pd_coat *s, int32_t p, double t, double dt, double *c, double *around, pd_coat_at *at,
                           double *y)
{
    int64_t total = s->reactive->grid->total;
    pdi_coat_work w;
    memset(&w, 0, sizeof w);
    w.s = s;
    w.node = s->node[p];
    w.from = t;
    w.first = dt > 0.0 ? s->first : s->fresh;
    w.slope = dt > 0.0 ? s->way : s->slope;
    if (s->desc.around) s->desc.around(s->desc.user, w.node, w.around);
    for (int k = 0; k < s->desc.count; k++) y[k] = (dt > 0.0 ? s->value : s->start)[k * total + w.node];
    pdi_coat_read(&w, t + dt, c, around, at);
}

PDI_FN void pdi_coat_accept(pd_coat *s, double dt) { s->last = dt; }

PDI_FN void pdi_coat_reject(pd_coat *s)
{
    memcpy(s->value, s->start, (size_t)(s->desc.count * (int64_t)s->reactive->grid->total) * sizeof *s->value);
}

#undef PDI_COAT_TOLERANCE
#undef PDI_COAT_NEAR
#undef PDI_COAT_TRIALS
#undef PDI_COAT_WORK
