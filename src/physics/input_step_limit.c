/* input_step_limit: see input_step_limit.h */
#include "physics/input_step_limit.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Sample places along an axis for an expression that depends on place. */
#define PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS 3
/* Relative amount by which a value may leave the range between both ends of a step. */
#define PDI_INPUT_STEP_LIMIT_RANGE_TOLERANCE 0.05
/* Values below this fraction of the largest one to come count as 0. */
#define PDI_INPUT_STEP_LIMIT_ZERO_FRACTION 1e-6
/* A quarter of an interval with more than this fraction of its total change holds a jump, or a change as steep. */
#define PDI_INPUT_STEP_LIMIT_JUMP_FRACTION 0.75
/* A jump within this fraction of a step from its start lies at the start. */
#define PDI_INPUT_STEP_LIMIT_START_FRACTION 1e-9
/* Allowed difference of midpoint value and mean over a step, over rtol. */
#define PDI_INPUT_STEP_LIMIT_MIDPOINT_TOLERANCE 1.0
/* Least reference size for that difference, over the largest value to come. */
#define PDI_INPUT_STEP_LIMIT_SMALL_FRACTION 0.25
/* A current that grows by the factor exp(x) in a step has the mean exp(x/2) (1 + x^2/24): the 24 of its error term. */
#define PDI_INPUT_STEP_LIMIT_GROWTH_FACTOR 24.0
/* [V] Least distance over which curvature of a tabulated curve counts: RT/(4 F), of a 4-electron reaction. */
#define PDI_INPUT_STEP_LIMIT_CURVATURE_SPAN 6.4e-3
/* Second differences below this fraction of the current are rounding. */
#define PDI_INPUT_STEP_LIMIT_CURVATURE_ROUNDING 1e-9
/* rtol of the run where the scene sets none. */
#define PDI_INPUT_STEP_LIMIT_DEFAULT_RTOL 1e-3
/* Largest number of intervals and of halvings in the search of a step. */
#define PDI_INPUT_STEP_LIMIT_MAX_PARTS 2000
#define PDI_INPUT_STEP_LIMIT_MAX_HALVINGS 40
/* Largest number of passes over all values. */
#define PDI_INPUT_STEP_LIMIT_MAX_TRIALS 60

/* Describe the arrays of pd_input_step_limit, for allocation and freeing. */
static void pdi_input_step_limit_list(pdi_array_visitor *owner, void *object)
{
    pd_input_step_limit *vary = (pd_input_step_limit *)object;
    PDI_ARRAY(owner, vary, value, vary->capacity, "");
}

/* Append an expression, if it depends on time, at sample places of the box, or of one side (side < 0: the box): 3 along
 * each axis that it depends on, else the middle; along the normal on the side. It is borrowed. Without an array the
 * entries are only counted. Does nothing if it does not depend on time. */
static void pdi_input_step_limit_add_expression(const pd_setup *setup, const pd_expr *expr, int side,
                                                pd_input_step_limit *vary)
{
    int places = 1;
    if (!pd_setup_is_time_dependent(expr)) return;
    for (int d = 0; d < PD_DIM; d++)
        if ((expr->variables_used >> d & 1u) && d != (side < 0 ? -1 : side / 2))
            places *= PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS;
    for (int k = 0; k < places; k++) {
        int rest = k;
        pd_input_value *value = vary->value ? &vary->value[vary->count] : NULL;
        for (int d = 0; d < PD_DIM && value; d++) {
            int varies = (expr->variables_used >> d & 1u) && d != (side < 0 ? -1 : side / 2);
            double part =
                varies ? (rest % PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS + 0.5) / PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS : 0.5;
            if (varies) rest /= PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS;
            if (side >= 0 && d == side / 2) part = side % 2 ? 1.0 : 0.0;
            value->x[d] = setup->lo[d] + part * (setup->hi[d] - setup->lo[d]);
        }
        if (value) value->expr = expr;
        vary->count++;
    }
}

/* Append the boundary values of all sides: mean inflow, concentrations, velocities. */
static void pdi_input_step_limit_add_sides(const pd_setup *setup, pd_input_step_limit *vary)
{
    for (int s = 0; s < 2 * PD_DIM; s++) {
        const pd_setup_side *side = &setup->side[s];
        pdi_input_step_limit_add_expression(setup, &side->inflow_of_time, s, vary);
        pdi_input_step_limit_add_expression(setup, &side->inlet_c, s, vary);
        pdi_input_step_limit_add_expression(setup, &side->fixed_c, s, vary);
        for (int d = 0; d < PD_DIM; d++) {
            pdi_input_step_limit_add_expression(setup, &side->velocity[d], s, vary);
            pdi_input_step_limit_add_expression(setup, &side->wall_velocity[d], s, vary);
        }
    }
}

/* Append prescribed displacements, tractions, pressures and body forces of the metal. */
static void pdi_input_step_limit_add_mechanical_bc(const pd_setup *u, pd_input_step_limit *vary)
{
    for (int k = 0; k < u->metal_body.mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &u->metal_body.mechanical_bc[k];
        for (int d = 0; d < PD_DIM; d++) {
            if (grip->has_displacement[d])
                pdi_input_step_limit_add_expression(u, &grip->displacement[d], grip->side, vary);
            if (grip->has_traction) pdi_input_step_limit_add_expression(u, &grip->traction[d], grip->side, vary);
        }
        if (grip->has_pressure) pdi_input_step_limit_add_expression(u, &grip->pressure, grip->side, vary);
    }
    for (int d = 0; d < PD_DIM && u->metal_body.has_body_force; d++)
        pdi_input_step_limit_add_expression(u, &u->metal_body.force[d], -1, vary);
}

/* Least potential change [V] over which the current of a tabulated polarisation curve grows e-fold, over its points:
 * the larger of sqrt(current/curvature) and slope/curvature, by differences over 6.4 mV at least. HUGE_VAL: the curve
 * is straight to rounding. */
static double pdi_input_step_limit_compute_table_curvature(const pd_electrode_term *term)
{
    const double *u = term->potential, *i = term->current;
    double fold = HUGE_VAL;
    for (int k = 1, a = 0, b = 1; k + 1 < term->points; k++) {
        while (a + 1 < k && u[k] - u[a + 1] >= PDI_INPUT_STEP_LIMIT_CURVATURE_SPAN) a++;
        while (b + 1 < term->points && (b <= k || u[b] - u[k] < PDI_INPUT_STEP_LIMIT_CURVATURE_SPAN)) b++;
        double down = u[k] - u[a], up = u[b] - u[k], slope = fabs(i[b] - i[a]) / (down + up);
        double bend = 2.0 * fabs((i[b] - i[k]) / up - (i[k] - i[a]) / down) / (down + up);
        double size = (fabs(i[a]) + fabs(i[k]) + fabs(i[b])) / 3.0;
        if (!(bend * down * up > PDI_INPUT_STEP_LIMIT_CURVATURE_ROUNDING * size)) continue;
        fold = pd_min(fold, pd_max(sqrt(size / bend), slope / bend));
    }
    return fold;
}

/* Least potential change [V] by which the current of an electrode grows e-fold: of Butler-Volmer terms the smaller of
 * both slopes, of a table by its curvature. HUGE_VAL: it is linear, or the electrode is primary. */
static double pdi_input_step_limit_compute_efolding_voltage(const pd_setup_electrode *e)
{
    const pd_electrode_term *term = &e->term;
    double fold = HUGE_VAL;
    if (e->primary || term->kind == PD_ELECTRODE_LINEAR) return fold;
    if (term->kind != PD_ELECTRODE_BUTLER_VOLMER) return pdi_input_step_limit_compute_table_curvature(term);
    if (term->anodic > 0.0) fold = term->anodic;
    return term->cathodic > 0.0 ? pd_min(fold, term->cathodic) : fold;
}

/* Append prescribed potentials and currents of electrodes, with whether the solver takes them at the midpoint of a step
 * and the potential change that counts for their error. */
static void pdi_input_step_limit_add_electrodes(const pd_setup *u, pd_input_step_limit *vary)
{
    double fold = HUGE_VAL;
    for (int k = 0; k < u->potential.electrodes; k++)
        fold = pd_min(fold, pdi_input_step_limit_compute_efolding_voltage(&u->potential.electrode[k]));
    for (int k = 0; k < u->potential.electrodes; k++) {
        const pd_setup_electrode *e = &u->potential.electrode[k];
        int32_t first = vary->count;
        pdi_input_step_limit_add_expression(u, &e->fixed_value, -1, vary);
        for (int32_t n = first; n < vary->count && vary->value; n++) {
            vary->value[n].at_midpoint = u->has_dissolve || !u->has_migration;
            vary->value[n].efolding_voltage = e->has_fixed_potential && !u->has_migration ? fold : HUGE_VAL;
        }
    }
}

/* Append all time-dependent expressions of the setup; without an array they are only counted. */
static void pdi_input_step_limit_add_all(const pd_setup *setup, pd_input_step_limit *vary)
{
    vary->count = 0;
    pdi_input_step_limit_add_sides(setup, vary);
    for (int k = 0; k < setup->wall_count; k++)
        pdi_input_step_limit_add_expression(setup, &setup->wall_shape[k].fixed_c, -1, vary);
    for (int d = 0; d < PD_DIM; d++) pdi_input_step_limit_add_expression(setup, &setup->body_force[d], -1, vary);
    for (int k = 0; k < setup->metals; k++)
        pdi_input_step_limit_add_expression(setup, &setup->metal[k].potential, -1, vary);
    pdi_input_step_limit_add_electrodes(setup, vary);
    pdi_input_step_limit_add_mechanical_bc(setup, vary);
}

PDI_FN pd_status pdi_input_step_limit_build(pd_ctx *ctx, const pd_setup *setup, pd_input_step_limit *vary)
{
    memset(vary, 0, sizeof *vary);
    vary->end_time = setup->end_time;
    vary->rtol = setup->rtol > 0.0 ? setup->rtol : PDI_INPUT_STEP_LIMIT_DEFAULT_RTOL;
    pdi_input_step_limit_add_all(setup, vary);
    vary->capacity = vary->count;
    if (!vary->count) return PD_OK;
    pd_status status = pdi_array_registry_build(ctx, pdi_input_step_limit_list, vary);
    if (status < 0) memset(vary, 0, sizeof *vary);
    else pdi_input_step_limit_add_all(setup, vary);
    return status;
}

PDI_FN void pdi_input_step_limit_free(pd_ctx *ctx, pd_input_step_limit *vary)
{
    pdi_array_registry_free(ctx, pdi_input_step_limit_list, vary);
    memset(vary, 0, sizeof *vary);
}

/* Bounds of a value over the time interval a .. b [s], by interval arithmetic. */
static pdi_interval pdi_input_step_limit_compute_bounds(const pd_input_value *value, double a, double b)
{
    double vars[PD_EXPR_VARS];
    memset(vars, 0, sizeof vars);
    memcpy(vars, value->x, sizeof value->x);
    return pdi_interval_eval_expr(value->expr, vars, PD_DIM, a, b);
}

/* Range of a value between both ends of a step. */
typedef struct pdi_input_step_limit_seen_range {
    double low, high, tolerance; /* the last: tolerance by which values may lie outside of them */
} pdi_input_step_limit_seen_range;

/* Smallest and largest value at the ends t and end [s], with the tolerance: 5 % of the largest size there, of at least
 * `most` [unit of the value]. */
static pdi_input_step_limit_seen_range pdi_input_step_limit_compute_seen_range(const pd_input_value *value, double t,
                                                                               double end, double most)
{
    pdi_interval first = pdi_input_step_limit_compute_bounds(value, t, t),
                 last = pdi_input_step_limit_compute_bounds(value, end, end);
    pdi_input_step_limit_seen_range e;
    e.low = first.low < last.low ? first.low : last.low;
    e.high = first.high > last.high ? first.high : last.high;
    e.tolerance = PDI_INPUT_STEP_LIMIT_RANGE_TOLERANCE * pd_max(pd_max(fabs(e.low), fabs(e.high)), most);
    e.tolerance = pd_max(e.tolerance, DBL_MIN); /* below, values have lost their digits, and jump */
    return e;
}

/* [s] End of the short interval after t in which a jump counts as one at the start of the step t .. end. */
static double pdi_input_step_limit_compute_start_tolerance(double t, double end)
{
    return t + PDI_INPUT_STEP_LIMIT_START_FRACTION * (end - t) + 8.0 * DBL_EPSILON * fabs(t);
}

/* 1: the value has no jump between from and to [s]: in no quarter of the interval is the width of its bounds (interval
 * arithmetic) above 0.75 of `width`, that of the interval. */
static int pdi_input_step_limit_is_continuous(const pd_input_value *value, double from, double to, double width)
{
    double quarter = 0.25 * (to - from);
    for (int k = 0; k < 4; k++) {
        pdi_interval range = pdi_input_step_limit_compute_bounds(value, from + k * quarter, from + (k + 1) * quarter);
        if (range.high - range.low > PDI_INPUT_STEP_LIMIT_JUMP_FRACTION * width) return 0;
    }
    return 1;
}

/* First time [s] in t .. end at which the value leaves the range between both ends by more than 5 % or jumps, found by
 * bisection with interval bounds; `end`: nowhere, or a value at an end is not finite. Where 2000 parts are not enough:
 * how far they reach, or the middle. A jump at the start of the step is ignored. most: largest size of the value to
 * come. */
static double pdi_input_step_limit_find_unseen_change(const pd_input_value *value, double most, double t, double end)
{
    double stack[PDI_INPUT_STEP_LIMIT_MAX_HALVINGS + 2], from = t,
                                                         shortest = ldexp(end - t, -PDI_INPUT_STEP_LIMIT_MAX_HALVINGS);
    pdi_input_step_limit_seen_range ends =
        pdi_input_step_limit_compute_seen_range(value, t, end, PDI_INPUT_STEP_LIMIT_ZERO_FRACTION * most);
    double begins = pdi_input_step_limit_compute_start_tolerance(t, end);
    int top = 0;
    if (!(ends.low > -HUGE_VAL) || !(ends.high < HUGE_VAL)) return end; /* who asks for that value will say so */
    stack[top++] = end;
    for (int part = 0; part < PDI_INPUT_STEP_LIMIT_MAX_PARTS && top > 0; part++) {
        double to = stack[top - 1], middle = 0.5 * (from + to);
        pdi_interval range = pdi_input_step_limit_compute_bounds(value, from, to);
        double size = pd_max(fabs(range.low), fabs(range.high));
        double more =
            size < HUGE_VAL ? pd_max(PDI_INPUT_STEP_LIMIT_RANGE_TOLERANCE * size, ends.tolerance) : ends.tolerance;
        int seen = range.low >= ends.low - more && range.high <= ends.high + more;
        int last =
            top > PDI_INPUT_STEP_LIMIT_MAX_HALVINGS || to - from <= shortest || !(middle > from) || !(middle < to);
        if (seen && (range.high - range.low <= more ||
                     pdi_input_step_limit_is_continuous(value, from, to, range.high - range.low))) {
            from = to;
            top--;
        } else if (!last) {
            stack[top++] = middle;
        } else if (from > begins) {
            return from;
        } else {
            ends = pdi_input_step_limit_compute_seen_range(value, to, end, PDI_INPUT_STEP_LIMIT_ZERO_FRACTION * most);
            from = to;
            top--;
        }
    }
    return top > 0 && from > t ? from : top > 0 ? 0.5 * (t + end) : end;
}

/* The value at time t [s], by its lower bound there. */
static double pdi_input_step_limit_get_value(const pd_input_value *value, double t)
{
    return pdi_input_step_limit_compute_bounds(value, t, t).low;
}

/* Halve the step t .. end, at most 40 times, for a value that is taken at its midpoint, until Simpson's rule gives that
 * value within rtol of its size (of a potential: of its e-folding voltage), and potential changes are at most sqrt(24
 * rtol) e-folding voltages. Returns the end [s]; other values leave it. */
static double pdi_input_step_limit_limit_midpoint_error(const pd_input_step_limit *vary, const pd_input_value *value,
                                                        double most, double t, double end)
{
    double begins = pdi_input_step_limit_compute_start_tolerance(t, end),
           wide = sqrt(PDI_INPUT_STEP_LIMIT_GROWTH_FACTOR * vary->rtol) * value->efolding_voltage;
    for (int k = 0; value->at_midpoint && k < PDI_INPUT_STEP_LIMIT_MAX_HALVINGS && begins < end; k++) {
        double first = pdi_input_step_limit_get_value(value, begins),
               middle = pdi_input_step_limit_get_value(value, 0.5 * (t + end));
        double last = pdi_input_step_limit_get_value(value, end * (1.0 - DBL_EPSILON)),
               simpson = (first + 4.0 * middle + last) / 6.0;
        double size = value->efolding_voltage < HUGE_VAL
                          ? value->efolding_voltage
                          : pd_max(fabs(simpson), PDI_INPUT_STEP_LIMIT_SMALL_FRACTION * most);
        double change = pd_max(fabs(last - first), pd_max(fabs(middle - first), fabs(last - middle)));
        if (!(fabs(simpson - middle) > PDI_INPUT_STEP_LIMIT_MIDPOINT_TOLERANCE * vary->rtol * size) && !(change > wide))
            return end;
        end = 0.5 * (t + end);
        begins = pdi_input_step_limit_compute_start_tolerance(t, end);
    }
    return end;
}

PDI_FN double pdi_input_step_limit_compute(void *user, double t, double end)
{
    const pd_input_step_limit *vary = (const pd_input_step_limit *)user;
    for (int trial = 0; trial < PDI_INPUT_STEP_LIMIT_MAX_TRIALS; trial++) {
        double earlier = end;
        for (int32_t k = 0; k < vary->count; k++) {
            pdi_interval all = pdi_input_step_limit_compute_bounds(&vary->value[k], t, pd_max(end, vary->end_time));
            double most = pd_max(fabs(all.low), fabs(all.high));
            if (!(most < HUGE_VAL)) most = 0.0;
            earlier = pdi_input_step_limit_find_unseen_change(&vary->value[k], most, t, earlier);
            earlier = pdi_input_step_limit_limit_midpoint_error(vary, &vary->value[k], most, t, earlier);
        }
        if (!(earlier < end) || !(earlier > t)) return end;
        end = earlier;
    }
    return end;
}

#undef PDI_INPUT_STEP_LIMIT_SAMPLE_POINTS
#undef PDI_INPUT_STEP_LIMIT_RANGE_TOLERANCE
#undef PDI_INPUT_STEP_LIMIT_JUMP_FRACTION
#undef PDI_INPUT_STEP_LIMIT_START_FRACTION
#undef PDI_INPUT_STEP_LIMIT_MIDPOINT_TOLERANCE
#undef PDI_INPUT_STEP_LIMIT_ZERO_FRACTION
#undef PDI_INPUT_STEP_LIMIT_SMALL_FRACTION
#undef PDI_INPUT_STEP_LIMIT_GROWTH_FACTOR
#undef PDI_INPUT_STEP_LIMIT_CURVATURE_SPAN
#undef PDI_INPUT_STEP_LIMIT_CURVATURE_ROUNDING
#undef PDI_INPUT_STEP_LIMIT_DEFAULT_RTOL
#undef PDI_INPUT_STEP_LIMIT_MAX_PARTS
#undef PDI_INPUT_STEP_LIMIT_MAX_HALVINGS
#undef PDI_INPUT_STEP_LIMIT_MAX_TRIALS
