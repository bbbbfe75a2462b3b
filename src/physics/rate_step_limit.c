/* rate_step_limit: see rate_step_limit.h */
#include "physics/rate_step_limit.h"
#include "react/layer.h"
#include "setup/interval.h"
#include "solve/time_quadrature.h"
#include "solve/sdirk.h"
#include <math.h>
#include <string.h>

/* Allowed error of the stage quadrature, over rtol: relative to the integral over the step, and to a reference amount
 * (a cell of metal, the size of a state, a factor of 1). */
#define PDI_RATE_STEP_LIMIT_INTEGRAL_TOLERANCE 0.1
#define PDI_RATE_STEP_LIMIT_AMOUNT_TOLERANCE 1e-4
/* Largest number of quadrature intervals of a step, and of intervals on the stack. */
#define PDI_RATE_STEP_LIMIT_MAX_INTERVALS 1024
#define PDI_RATE_STEP_LIMIT_MAX_PENDING 62
/* A jump is located to this fraction of the step; the step ends before it. */
#define PDI_RATE_STEP_LIMIT_MIN_INTERVAL 1e-12
/* Largest number of halvings of a step by one law, and of passes over all laws. */
#define PDI_RATE_STEP_LIMIT_MAX_HALVINGS 50
#define PDI_RATE_STEP_LIMIT_MAX_TRIALS 60
/* Relative time by which a stage lies before a jump at its time, as in react/etch. */
#define PDI_RATE_STEP_LIMIT_STAGE_OFFSET 1e-15
/* rtol of the run where the scene sets none. */
#define PDI_RATE_STEP_LIMIT_DEFAULT_RTOL 1e-3

/* A law at a surface site, as a function of time alone. */
typedef struct pdi_rate_step_limit_local_law {
    const pd_expr *expr;
    double vars[PD_EXPR_VARS];
    int time_index; /* index of time in vars */
    double scale; /* factor on the expression */
    double minimum;        /* lower bound: smaller values are clamped to it */
    double integral_scale; /* [unit of the law times s] reference amount of its time integral, for the tolerance */
    double rtol;  /* [-] */
} pdi_rate_step_limit_local_law;

/* Value of the law at time t [s], which is kept in its vars. Integrand of pdi_time_quadrature; user: the local law. */
static double pdi_rate_step_limit_compute_law(void *user, double t)
{
    pdi_rate_step_limit_local_law *law = (pdi_rate_step_limit_local_law *)user;
    law->vars[law->time_index] = t;
    return pd_max(law->scale * pd_expr_eval(law->expr, law->vars), law->minimum);
}

/* Lower and upper bound of the law over the time interval from .. to [s], by interval arithmetic. */
static void pdi_rate_step_limit_compute_law_bounds(void *user, double from, double to, double *least, double *most)
{
    const pdi_rate_step_limit_local_law *law = (const pdi_rate_step_limit_local_law *)user;
    pdi_interval range = pdi_interval_eval_expr(law->expr, law->vars, law->time_index, from, to);
    double one = law->scale * range.low, two = law->scale * range.high;
    *least = pd_max(pd_min(one, two), law->minimum);
    *most = pd_max(pd_max(one, two), law->minimum);
}

/* Integrate the law over dt [s] from t on by adaptive quadrature, in at most 1024 intervals. *sum: integral, *size:
 * integral of its absolute value [unit of the law times s]; *jump: time after t of the first interval that stays
 * inaccurate at its shortest, HUGE_VAL: none. Returns the time that was reached, before t + dt if there were too many
 * intervals. */
static double pdi_rate_step_limit_integrate_law(pdi_rate_step_limit_local_law *law, double t, double dt, double *sum,
                                                double *size, double *jump)
{
    double waiting[PDI_RATE_STEP_LIMIT_MAX_PENDING + 2], from = t, mean;
    int count = 1;
    pdi_time_quadrature of = {pdi_rate_step_limit_compute_law,
                              pdi_rate_step_limit_compute_law_bounds,
                              law,
                              dt,
                              law->integral_scale,
                              law->rtol};
    waiting[0] = t + dt;
    *sum = *size = 0.0;
    *jump = HUGE_VAL;
    for (int piece = 0; piece < PDI_RATE_STEP_LIMIT_MAX_INTERVALS && count > 0; piece++) {
        double to = waiting[count - 1], middle = 0.5 * (from + to);
        int divides = count <= PDI_RATE_STEP_LIMIT_MAX_PENDING && middle > from && middle < to &&
                      to - from >= PDI_RATE_STEP_LIMIT_MIN_INTERVAL * dt;
        pdi_time_quadrature_verdict found = pdi_time_quadrature_check(&of, from, to, (to - from) / dt, 0, &mean);
        if (found == PDI_TIME_QUADRATURE_SUBDIVIDE && divides) {
            waiting[count++] = middle;
            continue;
        }
        if (found != PDI_TIME_QUADRATURE_ACCURATE && from > t) *jump = pd_min(*jump, from);
        *sum += (to - from) * mean;
        *size += (to - from) * fabs(mean);
        from = to;
        count--;
    }
    return from;
}

/* Latest end [s] of a step from t to `end` by one law: cut at a jump, else halved, at most 50 times, until the SDIRK2
 * stage rule agrees with the integral within rtol of 0.1 of its size and 1e-4 of the reference amount. Where a value is
 * not finite or no shorter step is left the end stays. */
static double pdi_rate_step_limit_limit_law(pdi_rate_step_limit_local_law *law, double t, double end)
{
    double g = PDI_SDIRK_GAMMA, sum, size, jump;
    for (int k = 0; k < PDI_RATE_STEP_LIMIT_MAX_HALVINGS; k++) {
        double dt = end - t, far = pdi_rate_step_limit_integrate_law(law, t, dt, &sum, &size, &jump);
        double rule =
            dt *
            ((1.0 - g) * pdi_rate_step_limit_compute_law(law, (t + g * dt) * (1.0 - PDI_RATE_STEP_LIMIT_STAGE_OFFSET)) +
             g * pdi_rate_step_limit_compute_law(law, end * (1.0 - PDI_RATE_STEP_LIMIT_STAGE_OFFSET)));
        double room = law->rtol * (PDI_RATE_STEP_LIMIT_INTEGRAL_TOLERANCE * size +
                                   PDI_RATE_STEP_LIMIT_AMOUNT_TOLERANCE * law->integral_scale);
        if (!(far < end) && fabs(rule - sum) <= room) return end;
        if (!(fabs(sum) < HUGE_VAL) || !(fabs(rule) < HUGE_VAL)) return end; /* who asks for that value will say so */
        double next = jump < end ? jump : t + 0.5 * dt;
        if (!(next > t) || !(next < end)) return end;
        end = next;
    }
    return end;
}

/* ---- all laws ---- */

/* Latest end [s] up to `end` by the dissolution rate law at a surface site. It is `end` where the law does not depend
 * on time, the site has no weight, or its surface has no solution. law: work, with its rtol. */
static double pdi_rate_step_limit_limit_metal_law(const pd_rate_step_limit *s, int32_t place, double t, double end,
                                                  pdi_rate_step_limit_local_law *law)
{
    const pd_etch *etch = &s->attack->surface_solver;
    const pd_dissolution_law *of = &s->attack->law[pdi_etch_which(etch, place)];
    const pd_setup_metal *metal = &s->setup->metal[of->setup_metal];
    const double *h = s->attack->dissolve->grid->h;
    double c[PD_SPECIES_MAX], ph, phi;
    if (!(etch->weight[place] > 0.0) || !(metal->rate.variables_used >> 1 & 1u)) return end;
    if (!pdi_layer_reads(etch, place, c, &ph, &phi)) return end;
    pdi_dissolution_laws_set_variables(of, etch->node[place], c, ph, phi, t, law->vars);
    law->expr = &metal->rate;
    law->time_index = 1;
    law->scale = metal->rate_scale;
    law->minimum = 0.0;
    law->integral_scale = h[0];
    for (int d = 1; d < PD_DIM; d++) law->integral_scale = pd_min(law->integral_scale, h[d]);
    return pdi_rate_step_limit_limit_law(law, t, end);
}

/* Latest end [s] up to `end` by the rates that depend on time of all states that a site carries; tried: 1: with the
 * state at the end of the attempt, 0: of the start. law: work, with its rtol. */
static double pdi_rate_step_limit_limit_surface_state(const pd_rate_step_limit *s, int32_t place, double t, double end,
                                                      int tried, pdi_rate_step_limit_local_law *law)
{
    const pd_coat *coat = &s->surfaces->state_solver;
    double c[PD_SPECIES_MAX], around[PD_COAT_AROUND], y[PD_COAT_MOST], whole = tried ? end - t : 0.0;
    pd_coat_at at;
    pdi_coat_reads(coat, place, t, whole, c, around, &at, y);
    for (int k = 0; k < s->setup->states; k++) {
        const pd_setup_surface_state *state = &s->setup->state[k];
        if (!(coat->on[coat->node[place]] >> k & 1u) || !(state->rate.variables_used >> 1 & 1u)) continue;
        pdi_surface_states_set_variables(s->surfaces, k, &at, y, law->vars);
        law->expr = &state->rate;
        law->time_index = 1;
        law->scale = 1.0;
        law->minimum = -HUGE_VAL;
        law->integral_scale = pd_max(coat->size[k], fabs(y[k]));
        end = pdi_rate_step_limit_limit_law(law, t, end);
    }
    return end;
}

/* Latest end [s] up to `end` by the factors of polarisation curves, of all electrodes whose factor depends on time,
 * with the states at a site. law: work, with its rtol. */
static double pdi_rate_step_limit_limit_electrode_factor(const pd_rate_step_limit *s, int32_t place, double t,
                                                         double end, pdi_rate_step_limit_local_law *law)
{
    const pd_coat *coat = &s->surfaces->state_solver;
    for (int e = 0; e < s->setup->potential.electrodes; e++) {
        const pd_setup_electrode *of = &s->setup->potential.electrode[e];
        if (!of->has_current_factor || !pd_setup_is_time_dependent(&of->current_factor)) continue;
        memset(law->vars, 0, sizeof law->vars);
        pd_grid_position(s->surfaces->bonds->grid, coat->node[place], law->vars);
        pdi_surface_states_get_states(s->surfaces, coat->node[place], law->vars + PD_SETUP_POSITION_VARS);
        law->expr = &of->current_factor;
        law->time_index = PD_DIM;
        law->scale = 1.0;
        law->minimum = 0.0;
        law->integral_scale = end - t;
        end = pdi_rate_step_limit_limit_law(law, t, end);
    }
    return end;
}

/* Latest end [s] up to `end` by all laws at all sites, once each. law: work, with its rtol. */
static double pdi_rate_step_limit_limit_all(const pd_rate_step_limit *s, double t, double end, int tried,
                                            pdi_rate_step_limit_local_law *law)
{
    for (int32_t p = 0; s->attack && p < s->attack->surface_solver.count; p++)
        end = pdi_rate_step_limit_limit_metal_law(s, p, t, end, law);
    for (int32_t p = 0; s->surfaces && p < s->surfaces->state_solver.count; p++) {
        end = pdi_rate_step_limit_limit_surface_state(s, p, t, end, tried, law);
        end = pdi_rate_step_limit_limit_electrode_factor(s, p, t, end, law);
    }
    return end;
}

PDI_FN double pdi_rate_step_limit_compute(void *user, double t, double end, int tried)
{
    const pd_rate_step_limit *s = (const pd_rate_step_limit *)user;
    pdi_rate_step_limit_local_law law;
    memset(&law, 0, sizeof law);
    law.rtol = s->setup->rtol > 0.0 ? s->setup->rtol : PDI_RATE_STEP_LIMIT_DEFAULT_RTOL;
    double to = pdi_rate_step_limit_limit_all(s, t, end, tried, &law);
    if (tried) return to; /* another attempt follows */
    for (int trial = 0; trial < PDI_RATE_STEP_LIMIT_MAX_TRIALS && to < end; trial++) {
        end = to;
        to = pdi_rate_step_limit_limit_all(s, t, end, tried, &law);
    }
    return to;
}

PDI_FN void pdi_rate_step_limit_build(const pd_setup *setup, const pd_dissolution_laws *attack,
                                      const pd_surface_states *surfaces, pd_rate_step_limit *timed)
{
    int laws = 0, rates = 0;
    memset(timed, 0, sizeof *timed);
    timed->setup = setup;
    for (int m = 0; attack && m < attack->law_count; m++) {
        const pd_setup_metal *metal = &setup->metal[attack->law[m].setup_metal];
        laws |= pd_setup_has_species_rate(metal) && (metal->rate.variables_used >> 1 & 1u);
    }
    for (int k = 0; k < setup->states; k++) rates |= (int)(setup->state[k].rate.variables_used >> 1 & 1u);
    for (int e = 0; e < setup->potential.electrodes; e++)
        rates |= setup->potential.electrode[e].has_current_factor &&
                 pd_setup_is_time_dependent(&setup->potential.electrode[e].current_factor);
    if (laws) timed->attack = attack;
    if (rates) timed->surfaces = surfaces;
}

#undef PDI_RATE_STEP_LIMIT_INTEGRAL_TOLERANCE
#undef PDI_RATE_STEP_LIMIT_AMOUNT_TOLERANCE
#undef PDI_RATE_STEP_LIMIT_MAX_INTERVALS
#undef PDI_RATE_STEP_LIMIT_MAX_PENDING
#undef PDI_RATE_STEP_LIMIT_MIN_INTERVAL
#undef PDI_RATE_STEP_LIMIT_MAX_HALVINGS
#undef PDI_RATE_STEP_LIMIT_MAX_TRIALS
#undef PDI_RATE_STEP_LIMIT_STAGE_OFFSET
#undef PDI_RATE_STEP_LIMIT_DEFAULT_RTOL
