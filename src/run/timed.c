/* timed: see timed.h */
#include "run/timed.h"
#include "react/layer.h"
#include "scene/range.h"
#include "solve/quadrature.h"
#include "solve/sdirk.h"
#include <math.h>
#include <string.h>

/* Allowed error of the stage quadrature, over rtol: relative to the integral over the step, and to a reference amount
 * (a cell of metal, the size of a state, a factor of 1). */
#define PDI_TIMED_COST 0.1
#define PDI_TIMED_FAINT 1e-4
/* Largest number of quadrature intervals of a step, and of intervals on the stack. */
#define PDI_TIMED_MOST 1024
#define PDI_TIMED_WAIT 62
/* A jump is located to this fraction of the step; the step ends before it. */
#define PDI_TIMED_SHORT 1e-12
/* Largest number of halvings of a step by one law, and of passes over all laws. */
#define PDI_TIMED_HALVINGS 50
#define PDI_TIMED_TRIALS 60
/* Relative time by which a stage lies before a jump at its time, as in react/etch. */
#define PDI_TIMED_BEFORE 1e-15
/* rtol of the run where the scene sets none. */
#define PDI_TIMED_RTOL 1e-3

/* A law at a surface site, as a function of time alone. */
typedef struct pdi_timed_law {
    const pd_expr *expr;
    double vars[PD_EXPR_VARS];
    int clock;    /* index of time in vars */
    double scale; /* factor on the expression */
    double least; /* lower bound: smaller values are clamped to it */
    double size;  /* [unit of the law times s] reference amount of its time integral, for the tolerance */
    double rtol;  /* [-] */
} pdi_timed_law;

/* Value of the law at time t [s]. Integrand of pdi_quadrature. */
static double pdi_timed_at(void *user, double t)
{
    pdi_timed_law *law = (pdi_timed_law *)user;
    law->vars[law->clock] = t;
    return pdi_max(law->scale * pdi_expr_eval(law->expr, law->vars), law->least);
}

/* Lower and upper bound of the law over the time interval from .. to [s], by interval arithmetic. */
static void pdi_timed_bounds(void *user, double from, double to, double *least, double *most)
{
    const pdi_timed_law *law = (const pdi_timed_law *)user;
    pdi_range range = pdi_range_of(law->expr, law->vars, law->clock, from, to);
    double one = law->scale * range.low, two = law->scale * range.high;
    *least = pdi_max(pdi_min(one, two), law->least);
    *most = pdi_max(pdi_max(one, two), law->least);
}

/* Integrate the law over dt [s] from t on by adaptive quadrature. *sum: integral, *size: integral of its absolute value
 * [unit of the law times s]; *jump: time of the first jump after t, HUGE_VAL: none. Returns the time that was reached.
 */
static double pdi_timed_integral(pdi_timed_law *law, double t, double dt, double *sum, double *size, double *jump)
{
    double waiting[PDI_TIMED_WAIT + 2], from = t, mean;
    int count = 1;
    pdi_quadrature of = {pdi_timed_at, pdi_timed_bounds, law, dt, law->size, law->rtol};
    waiting[0] = t + dt;
    *sum = *size = 0.0;
    *jump = HUGE_VAL;
    for (int piece = 0; piece < PDI_TIMED_MOST && count > 0; piece++) {
        double to = waiting[count - 1], middle = 0.5 * (from + to);
        int divides = count <= PDI_TIMED_WAIT && middle > from && middle < to && to - from >= PDI_TIMED_SHORT * dt;
        pdi_quadrature_piece found = pdi_quadrature_judge(&of, from, to, (to - from) / dt, 0, &mean);
        if (found == PDI_QUADRATURE_DIVIDE && divides) {
            waiting[count++] = middle;
            continue;
        }
        if (found != PDI_QUADRATURE_FITS && from > t) *jump = pdi_min(*jump, from);
        *sum += (to - from) * mean;
        *size += (to - from) * fabs(mean);
        from = to;
        count--;
    }
    return from;
}

/* Latest end [s] of a step from t to `end` by one law: halved, or cut at a jump, until the SDIRK2 stage rule agrees
 * with the integral. */
static double pdi_timed_first(pdi_timed_law *law, double t, double end)
{
    double g = PDI_SDIRK_GAMMA, sum, size, jump;
    for (int k = 0; k < PDI_TIMED_HALVINGS; k++) {
        double dt = end - t, far = pdi_timed_integral(law, t, dt, &sum, &size, &jump);
        double rule = dt * ((1.0 - g) * pdi_timed_at(law, (t + g * dt) * (1.0 - PDI_TIMED_BEFORE)) +
                            g * pdi_timed_at(law, end * (1.0 - PDI_TIMED_BEFORE)));
        double room = law->rtol * (PDI_TIMED_COST * size + PDI_TIMED_FAINT * law->size);
        if (!(far < end) && fabs(rule - sum) <= room) return end;
        if (!(fabs(sum) < HUGE_VAL) || !(fabs(rule) < HUGE_VAL)) return end; /* who asks for that value will say so */
        double next = jump < end ? jump : t + 0.5 * dt;
        if (!(next > t) || !(next < end)) return end;
        end = next;
    }
    return end;
}

/* ---- all laws ---- */

/* Limit `end` by the dissolution rate law at a surface site. law: work. */
static double pdi_timed_metal(const pd_timed *s, int32_t place, double t, double end, pdi_timed_law *law)
{
    const pd_etch *etch = &s->attack->etch;
    const pd_attack_law *of = &s->attack->law[pdi_etch_which(etch, place)];
    const pd_setup_metal *metal = &s->setup->metal[of->kind];
    const double *h = s->attack->dissolve->grid->h;
    double c[PD_SPECIES_MOST], ph, phi;
    if (!(etch->weight[place] > 0.0) || !(metal->rate.uses >> 1 & 1u)) return end;
    if (!pdi_layer_reads(etch, place, c, &ph, &phi)) return end;
    pdi_attack_vars(of, etch->node[place], c, ph, phi, t, law->vars);
    law->expr = &metal->rate;
    law->clock = 1;
    law->scale = metal->rate_scale;
    law->least = 0.0;
    law->size = h[0];
    for (int d = 1; d < PD_DIM; d++) law->size = pdi_min(law->size, h[d]);
    return pdi_timed_first(law, t, end);
}

/* Limit `end` by the rates of all surface states at a site; tried: 1: with the state at the end of the attempt. law:
 * work. */
static double pdi_timed_state(const pd_timed *s, int32_t place, double t, double end, int tried, pdi_timed_law *law)
{
    const pd_coat *coat = &s->surfaces->coat;
    double c[PD_SPECIES_MOST], around[PD_COAT_AROUND], y[PD_COAT_MOST], whole = tried ? end - t : 0.0;
    pd_coat_at at;
    pdi_coat_reads(coat, place, t, whole, c, around, &at, y);
    for (int k = 0; k < s->setup->states; k++) {
        const pd_setup_state *state = &s->setup->state[k];
        if (!(coat->on[coat->node[place]] >> k & 1u) || !(state->rate.uses >> 1 & 1u)) continue;
        pdi_surfaces_vars(s->surfaces, k, &at, y, law->vars);
        law->expr = &state->rate;
        law->clock = 1;
        law->scale = 1.0;
        law->least = -HUGE_VAL;
        law->size = pdi_max(coat->size[k], fabs(y[k]));
        end = pdi_timed_first(law, t, end);
    }
    return end;
}

/* Limit `end` by the factors of polarisation curves at a site. law: work. */
static double pdi_timed_factor(const pd_timed *s, int32_t place, double t, double end, pdi_timed_law *law)
{
    const pd_coat *coat = &s->surfaces->coat;
    for (int e = 0; e < s->setup->potential.electrodes; e++) {
        const pd_setup_electrode *of = &s->setup->potential.electrode[e];
        if (!of->shares || !pdi_setup_timed(&of->share)) continue;
        memset(law->vars, 0, sizeof law->vars);
        pd_grid_position(s->surfaces->bonds->grid, coat->node[place], law->vars);
        pdi_surfaces_values(s->surfaces, coat->node[place], law->vars + PDI_SETUP_PLACE);
        law->expr = &of->share;
        law->clock = PD_DIM;
        law->scale = 1.0;
        law->least = 0.0;
        law->size = end - t;
        end = pdi_timed_first(law, t, end);
    }
    return end;
}

/* Limit `end` by all laws at all sites. law: work, with its rtol. */
static double pdi_timed_all(const pd_timed *s, double t, double end, int tried, pdi_timed_law *law)
{
    for (int32_t p = 0; s->attack && p < s->attack->etch.count; p++) end = pdi_timed_metal(s, p, t, end, law);
    for (int32_t p = 0; s->surfaces && p < s->surfaces->coat.count; p++) {
        end = pdi_timed_state(s, p, t, end, tried, law);
        end = pdi_timed_factor(s, p, t, end, law);
    }
    return end;
}

PDI_FN double pdi_timed_until(void *user, double t, double end, int tried)
{
    const pd_timed *s = (const pd_timed *)user;
    pdi_timed_law law;
    memset(&law, 0, sizeof law);
    law.rtol = s->setup->rtol > 0.0 ? s->setup->rtol : PDI_TIMED_RTOL;
    double to = pdi_timed_all(s, t, end, tried, &law);
    if (tried) return to; /* another attempt follows */
    for (int trial = 0; trial < PDI_TIMED_TRIALS && to < end; trial++) {
        end = to;
        to = pdi_timed_all(s, t, end, tried, &law);
    }
    return to;
}

PDI_FN void pdi_timed_build(const pd_setup *setup, const pd_attack *attack, const pd_surfaces *surfaces,
                            pd_timed *timed)
{
    int laws = 0, rates = 0;
    memset(timed, 0, sizeof *timed);
    timed->setup = setup;
    for (int m = 0; attack && m < attack->laws; m++) {
        const pd_setup_metal *metal = &setup->metal[attack->law[m].kind];
        laws |= pdi_setup_chemical(metal) && (metal->rate.uses >> 1 & 1u);
    }
    for (int k = 0; k < setup->states; k++) rates |= (int)(setup->state[k].rate.uses >> 1 & 1u);
    for (int e = 0; e < setup->potential.electrodes; e++)
        rates |= setup->potential.electrode[e].shares && pdi_setup_timed(&setup->potential.electrode[e].share);
    if (laws) timed->attack = attack;
    if (rates) timed->surfaces = surfaces;
}

#undef PDI_TIMED_COST
#undef PDI_TIMED_FAINT
#undef PDI_TIMED_MOST
#undef PDI_TIMED_WAIT
#undef PDI_TIMED_SHORT
#undef PDI_TIMED_HALVINGS
#undef PDI_TIMED_TRIALS
#undef PDI_TIMED_BEFORE
#undef PDI_TIMED_RTOL
