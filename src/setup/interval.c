/* interval: see interval.h
 *
 * Sources: Moore, Kearfott and Cloud, Introduction to Interval Analysis, SIAM 2009. Bounds are those of rounded
 * numbers: they may be off by a few units of the last place, which is below all that they are asked for.
 */
#include "setup/interval.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* The interval low .. high; all real numbers if low > high or one is NaN. */
static pdi_interval pdi_interval_make(double low, double high)
{
    pdi_interval r;
    r.low = low;
    r.high = high;
    if (low <= high) return r;
    r.low = -HUGE_VAL; /* no number is known: any may come */
    r.high = HUGE_VAL;
    return r;
}

/* The interval of all real numbers. */
static pdi_interval pdi_interval_all_reals(void) { return pdi_interval_make(-HUGE_VAL, HUGE_VAL); }

/* Smallest interval that contains both. */
static pdi_interval pdi_interval_hull(pdi_interval a, pdi_interval b)
{
    return pdi_interval_make(pd_min(a.low, b.low), pd_max(a.high, b.high));
}

/* 1: the interval contains the value. */
static int pdi_interval_contains(pdi_interval a, double value) { return a.low <= value && value <= a.high; }

/* Interval of a binary operation that takes its extremes at corners of the operands: hull of its values there. In a
 * product 0 times anything, infinity too, is 0. All real numbers if a value is NaN. */
static pdi_interval pdi_interval_apply_corners(int op, const pdi_interval *a)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int corner = 0; corner < 4; corner++) {
        double operand[2], value;
        operand[0] = corner & 1 ? a[0].high : a[0].low;
        operand[1] = corner & 2 ? a[1].high : a[1].low;
        value = pdi_expr_apply_op(op, operand);
        if (op == PDI_EXPR_MUL && !(fabs(operand[0]) > 0.0 && fabs(operand[1]) > 0.0)) value = 0.0; /* of any number */
        if (isnan(value)) return pdi_interval_all_reals();
        low = pd_min(low, value);
        high = pd_max(high, value);
    }
    return pdi_interval_make(low, high);
}

/* Interval of an increasing function: its values at both ends; all real numbers if one of them is NaN, as outside its
 * domain. */
static pdi_interval pdi_interval_apply_increasing(int op, pdi_interval a)
{
    return pdi_interval_make(pdi_expr_apply_op(op, &a.low), pdi_expr_apply_op(op, &a.high));
}

/* 1: some point first + n period, n whole, lies in the closed interval. */
static int pdi_interval_contains_periodic(pdi_interval a, double first, double period)
{
    return floor((a.high - first) / period) > floor((a.low - first) / period) || pdi_interval_contains(a, first);
}

/* Interval of sin or cos, whose maxima lie at crest + 2 pi n; -1 .. 1 for an operand of 2 pi or wider, or unbounded. */
static pdi_interval pdi_interval_apply_sine(int op, pdi_interval a, double crest)
{
    double low = pdi_expr_apply_op(op, &a.low), high = pdi_expr_apply_op(op, &a.high), least, most;
    if (!(a.high - a.low < 2.0 * PD_PI)) return pdi_interval_make(-1.0, 1.0);
    least = pdi_interval_contains_periodic(a, crest + PD_PI, 2.0 * PD_PI) ? -1.0 : pd_min(low, high);
    most = pdi_interval_contains_periodic(a, crest, 2.0 * PD_PI) ? 1.0 : pd_max(low, high);
    return pdi_interval_make(least, most);
}

/* Interval of an even function with its minimum at 0: abs, cosh. */
static pdi_interval pdi_interval_apply_even(int op, pdi_interval a)
{
    double zero = 0.0, low = pdi_expr_apply_op(op, &a.low), high = pdi_expr_apply_op(op, &a.high);
    double least = pdi_interval_contains(a, 0.0) ? pdi_expr_apply_op(op, &zero) : pd_min(low, high);
    return pdi_interval_make(least, pd_max(low, high));
}

/* Interval of pow(a[0], a[1]); all real numbers unless the base is positive, or the exponent is a constant >= 0 and,
 * where it is not whole, the base >= 0. */
static pdi_interval pdi_interval_apply_power(const pdi_interval *a)
{
    double n = a[1].low, zero[2] = {0.0, 0.0};
    if (a[0].low > 0.0) return pdi_interval_apply_corners(PDI_EXPR_OP_pow, a);
    if (a[1].high > n || n < 0.0) return pdi_interval_all_reals();
    zero[1] = n;
    if (n > floor(n)) return a[0].low < 0.0 ? pdi_interval_all_reals() : pdi_interval_apply_corners(PDI_EXPR_OP_pow, a);
    pdi_interval found = pdi_interval_apply_corners(PDI_EXPR_OP_pow, a); /* odd powers rise; even ones have a valley */
    if (pdi_interval_contains(a[0], 0.0)) found.low = pd_min(found.low, pdi_expr_apply_op(PDI_EXPR_OP_pow, zero));
    return found;
}

/* Interval of atan2(a[0], a[1]); -pi .. pi where a[0] contains 0 and a[1] reaches 0 or below (branch cut). */
static pdi_interval pdi_interval_apply_atan2(const pdi_interval *a)
{
    if (a[1].low <= 0.0 && pdi_interval_contains(a[0], 0.0)) return pdi_interval_make(-PD_PI, PD_PI);
    return pdi_interval_apply_corners(PDI_EXPR_OP_atan2, a);
}

/* Interval of a comparison: 1 if it holds for all values of the operands, 0 if for none, else 0 .. 1. */
static pdi_interval pdi_interval_apply_comparison(int op, const pdi_interval *a)
{
    int more = op == PDI_EXPR_GT || op == PDI_EXPR_GE, even = op == PDI_EXPR_LE || op == PDI_EXPR_GE;
    pdi_interval small = more ? a[1] : a[0], large = more ? a[0] : a[1];
    int sure = even ? small.high <= large.low : small.high < large.low;
    int never = even ? small.low > large.high : small.low >= large.high;
    return pdi_interval_make(sure ? 1.0 : 0.0, never ? 0.0 : 1.0);
}

/* Interval of if(a[0], a[1], a[2]): a[1] if the condition excludes 0, a[2] if it is 0 alone, else the hull of both. */
static pdi_interval pdi_interval_apply_if(const pdi_interval *a)
{
    if (!pdi_interval_contains(a[0], 0.0)) return a[1];
    return a[0].low < 0.0 || a[0].high > 0.0 ? pdi_interval_hull(a[1], a[2]) : a[2];
}

/* Interval of a table: hull of its values at both ends and at the points in between; it is monotone between points. All
 * real numbers if an end lies where the table is NaN. */
static pdi_interval pdi_interval_apply_table(const pd_monotone_cubic *curve, pdi_interval a)
{
    double low = pdi_monotone_cubic_evaluate(curve, a.low), high = pdi_monotone_cubic_evaluate(curve, a.high);
    pdi_interval found = pdi_interval_make(pd_min(low, high), pd_max(low, high));
    if (isnan(low) || isnan(high)) return pdi_interval_all_reals();
    for (int k = 0; k < curve->count; k++)
        if (pdi_interval_contains(a, curve->x[k]))
            found = pdi_interval_hull(found, pdi_interval_make(curve->y[k], curve->y[k]));
    return found;
}

/* Interval of min or max, which increase in both operands: bounds from bounds. */
static pdi_interval pdi_interval_apply_min_max(int op, const pdi_interval *a)
{
    double low[2], high[2];
    for (int k = 0; k < 2; k++) {
        low[k] = a[k].low;
        high[k] = a[k].high;
    }
    return pdi_interval_make(pdi_expr_apply_op(op, low), pdi_expr_apply_op(op, high));
}

/* Interval of one operator or function for the intervals of its operands; division by an interval that contains 0, and
 * tan across a pole, give all real numbers. */
static pdi_interval pdi_interval_apply_op(int op, const pdi_interval *a)
{
    switch (op) {
    case PDI_EXPR_NEG: return pdi_interval_make(-a[0].high, -a[0].low);
    case PDI_EXPR_ADD: return pdi_interval_make(a[0].low + a[1].low, a[0].high + a[1].high);
    case PDI_EXPR_SUB: return pdi_interval_make(a[0].low - a[1].high, a[0].high - a[1].low);
    case PDI_EXPR_MUL: return pdi_interval_apply_corners(op, a);
    case PDI_EXPR_DIV:
        return pdi_interval_contains(a[1], 0.0) ? pdi_interval_all_reals() : pdi_interval_apply_corners(op, a);
    case PDI_EXPR_LT:
    case PDI_EXPR_GT:
    case PDI_EXPR_LE:
    case PDI_EXPR_GE: return pdi_interval_apply_comparison(op, a);
    case PDI_EXPR_OP_sin: return pdi_interval_apply_sine(op, a[0], 0.5 * PD_PI);
    case PDI_EXPR_OP_cos: return pdi_interval_apply_sine(op, a[0], 0.0);
    case PDI_EXPR_OP_tan:
        if (!(a[0].high - a[0].low < PD_PI) || pdi_interval_contains_periodic(a[0], 0.5 * PD_PI, PD_PI))
            return pdi_interval_all_reals();
        return pdi_interval_apply_increasing(op, a[0]);
    case PDI_EXPR_OP_abs:
    case PDI_EXPR_OP_cosh: return pdi_interval_apply_even(op, a[0]);
    case PDI_EXPR_OP_min:
    case PDI_EXPR_OP_max: return pdi_interval_apply_min_max(op, a);
    case PDI_EXPR_OP_atan2: return pdi_interval_apply_atan2(a);
    case PDI_EXPR_OP_pow: return pdi_interval_apply_power(a);
    case PDI_EXPR_OP_if: return pdi_interval_apply_if(a);
    default: return pdi_interval_apply_increasing(op, a[0]); /* exp log log10 tanh sinh atan erf floor sqrt */
    }
}

/* Hull of a user function at a, b and their middle, variable `index` being varied: an estimate, no bound. All real
 * numbers if a value is NaN, or the variable is its time and a break lies in the closed a .. b, b > a. */
static pdi_interval pdi_interval_eval_function(const pd_expr *expr, const double *vars, int index, double a, double b)
{
    double at[PD_EXPR_VARS], low = HUGE_VAL, high = -HUGE_VAL;
    memcpy(at, vars, sizeof at);
    for (int k = 0; k < expr->discontinuity_count && index == expr->time_variable; k++)
        if (expr->discontinuities[k] >= a && expr->discontinuities[k] <= b && b > a) return pdi_interval_all_reals();
    for (int k = 0; k < 3; k++) {
        at[index] = k < 2 ? (k ? b : a) : 0.5 * (a + b);
        double value = expr->fn(expr->user, at);
        if (isnan(value)) return pdi_interval_all_reals();
        low = pd_min(low, value);
        high = pd_max(high, value);
    }
    return pdi_interval_make(low, high);
}

PDI_FN pdi_interval pdi_interval_eval_expr(const pd_expr *expr, const double *vars, int index, double a, double b)
{
    pdi_interval stack[PDI_EXPR_STACK_SIZE];
    int top = 0;
    if (expr->fn) return pdi_interval_eval_function(expr, vars, index, a, b);
    for (int k = 0; k < expr->code_count; k++) {
        int op = expr->code[k] & 255, at = expr->code[k] >> 8;
        if (op == PDI_EXPR_CONST) {
            stack[top++] = pdi_interval_make(expr->value[at], expr->value[at]);
        } else if (op == PDI_EXPR_VAR) {
            stack[top++] = at == index ? pdi_interval_make(a, b) : pdi_interval_make(vars[at], vars[at]);
        } else if (op == PDI_EXPR_TABLE) {
            stack[top - 1] = pdi_interval_apply_table(expr->tables[at].curve, stack[top - 1]);
        } else {
            top -= pdi_expr_count_operands(op);
            stack[top] = pdi_interval_apply_op(op, stack + top);
            top++;
        }
    }
    return top == 1 ? stack[0] : pdi_interval_all_reals();
}
