/* range: see range.h
 *
 * Sources: Moore, Kearfott and Cloud, Introduction to Interval Analysis, SIAM 2009. Bounds are those of rounded
 * numbers: they may be off by a few units of the last place, which is below all that they are asked for.
 */
#include "scene/range.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* The interval low .. high; all real numbers if the bounds are no numbers or not ordered. */
static pdi_range pdi_range_make(double low, double high)
{
    pdi_range r;
    r.low = low;
    r.high = high;
    if (low <= high) return r;
    r.low = -HUGE_VAL; /* no number is known: any may come */
    r.high = HUGE_VAL;
    return r;
}

/* The interval of all real numbers. */
static pdi_range pdi_range_any(void) { return pdi_range_make(-HUGE_VAL, HUGE_VAL); }

/* Smallest interval that contains both. */
static pdi_range pdi_range_hull(pdi_range a, pdi_range b)
{
    return pdi_range_make(pdi_min(a.low, b.low), pdi_max(a.high, b.high));
}

/* 1: the interval contains the value. */
static int pdi_range_holds(pdi_range a, double value) { return a.low <= value && value <= a.high; }

/* Interval of a binary operation that is monotone in both operands: hull of its values at the four corners. */
static pdi_range pdi_range_corners(int op, const pdi_range *a)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int corner = 0; corner < 4; corner++) {
        double operand[2], value;
        operand[0] = corner & 1 ? a[0].high : a[0].low;
        operand[1] = corner & 2 ? a[1].high : a[1].low;
        value = pdi_expr_apply(op, operand);
        if (op == PDI_EXPR_MUL && !(fabs(operand[0]) > 0.0 && fabs(operand[1]) > 0.0)) value = 0.0; /* of any number */
        if (isnan(value)) return pdi_range_any();
        low = pdi_min(low, value);
        high = pdi_max(high, value);
    }
    return pdi_range_make(low, high);
}

/* Interval of an increasing function. */
static pdi_range pdi_range_rising(int op, pdi_range a)
{
    return pdi_range_make(pdi_expr_apply(op, &a.low), pdi_expr_apply(op, &a.high));
}

/* 1: some point first + n period, n whole, lies in the interval. */
static int pdi_range_meets(pdi_range a, double first, double period)
{
    return floor((a.high - first) / period) > floor((a.low - first) / period) || pdi_range_holds(a, first);
}

/* Interval of sin or cos, whose maxima lie at crest + 2 pi n. */
static pdi_range pdi_range_wave(int op, pdi_range a, double crest)
{
    double low = pdi_expr_apply(op, &a.low), high = pdi_expr_apply(op, &a.high), least, most;
    if (!(a.high - a.low < 2.0 * PDI_PI)) return pdi_range_make(-1.0, 1.0);
    least = pdi_range_meets(a, crest + PDI_PI, 2.0 * PDI_PI) ? -1.0 : pdi_min(low, high);
    most = pdi_range_meets(a, crest, 2.0 * PDI_PI) ? 1.0 : pdi_max(low, high);
    return pdi_range_make(least, most);
}

/* Interval of an even function with its minimum at 0: abs, cosh. */
static pdi_range pdi_range_valley(int op, pdi_range a)
{
    double zero = 0.0, low = pdi_expr_apply(op, &a.low), high = pdi_expr_apply(op, &a.high);
    double least = pdi_range_holds(a, 0.0) ? pdi_expr_apply(op, &zero) : pdi_min(low, high);
    return pdi_range_make(least, pdi_max(low, high));
}

/* Interval of pow(a[0], a[1]); bounded for a positive base, or a constant exponent of at least 0. */
static pdi_range pdi_range_power(const pdi_range *a)
{
    double n = a[1].low, zero[2] = {0.0, 0.0};
    if (a[0].low > 0.0) return pdi_range_corners(PDI_EXPR_OP_pow, a);
    if (a[1].high > n || n < 0.0) return pdi_range_any();
    zero[1] = n;
    if (n > floor(n)) return a[0].low < 0.0 ? pdi_range_any() : pdi_range_corners(PDI_EXPR_OP_pow, a);
    pdi_range found = pdi_range_corners(PDI_EXPR_OP_pow, a); /* odd powers rise; even ones have a valley */
    if (pdi_range_holds(a[0], 0.0)) found.low = pdi_min(found.low, pdi_expr_apply(PDI_EXPR_OP_pow, zero));
    return found;
}

/* Interval of atan2(a[0], a[1]); -pi .. pi across the branch cut. */
static pdi_range pdi_range_angle(const pdi_range *a)
{
    if (a[1].low <= 0.0 && pdi_range_holds(a[0], 0.0)) return pdi_range_make(-PDI_PI, PDI_PI);
    return pdi_range_corners(PDI_EXPR_OP_atan2, a);
}

/* Interval of a comparison: 1, 0 or 0 .. 1. */
static pdi_range pdi_range_compare(int op, const pdi_range *a)
{
    int more = op == PDI_EXPR_GT || op == PDI_EXPR_GE, even = op == PDI_EXPR_LE || op == PDI_EXPR_GE;
    pdi_range small = more ? a[1] : a[0], large = more ? a[0] : a[1];
    int sure = even ? small.high <= large.low : small.high < large.low;
    int never = even ? small.low > large.high : small.low >= large.high;
    return pdi_range_make(sure ? 1.0 : 0.0, never ? 0.0 : 1.0);
}

/* Interval of if(a[0], a[1], a[2]). */
static pdi_range pdi_range_choice(const pdi_range *a)
{
    if (!pdi_range_holds(a[0], 0.0)) return a[1];
    return a[0].low < 0.0 || a[0].high > 0.0 ? pdi_range_hull(a[1], a[2]) : a[2];
}

/* Interval of a table: hull of its values at both ends and at the points in between; it is monotone between points. */
static pdi_range pdi_range_table(const pd_curve *curve, pdi_range a)
{
    double low = pdi_curve_eval(curve, a.low), high = pdi_curve_eval(curve, a.high);
    pdi_range found = pdi_range_make(pdi_min(low, high), pdi_max(low, high));
    if (isnan(low) || isnan(high)) return pdi_range_any();
    for (int k = 0; k < curve->count; k++)
        if (pdi_range_holds(a, curve->x[k])) found = pdi_range_hull(found, pdi_range_make(curve->y[k], curve->y[k]));
    return found;
}

/* Interval of min or max, which increase in both operands: bounds from bounds. */
static pdi_range pdi_range_least(int op, const pdi_range *a)
{
    double low[2], high[2];
    for (int k = 0; k < 2; k++) {
        low[k] = a[k].low;
        high[k] = a[k].high;
    }
    return pdi_range_make(pdi_expr_apply(op, low), pdi_expr_apply(op, high));
}

/* Interval of one instruction for the intervals of its operands. */
static pdi_range pdi_range_apply(int op, const pdi_range *a)
{
    switch (op) {
    case PDI_EXPR_NEG: return pdi_range_make(-a[0].high, -a[0].low);
    case PDI_EXPR_ADD: return pdi_range_make(a[0].low + a[1].low, a[0].high + a[1].high);
    case PDI_EXPR_SUB: return pdi_range_make(a[0].low - a[1].high, a[0].high - a[1].low);
    case PDI_EXPR_MUL: return pdi_range_corners(op, a);
    case PDI_EXPR_DIV: return pdi_range_holds(a[1], 0.0) ? pdi_range_any() : pdi_range_corners(op, a);
    case PDI_EXPR_LT:
    case PDI_EXPR_GT:
    case PDI_EXPR_LE:
    case PDI_EXPR_GE: return pdi_range_compare(op, a);
    case PDI_EXPR_OP_sin: return pdi_range_wave(op, a[0], 0.5 * PDI_PI);
    case PDI_EXPR_OP_cos: return pdi_range_wave(op, a[0], 0.0);
    case PDI_EXPR_OP_tan:
        if (!(a[0].high - a[0].low < PDI_PI) || pdi_range_meets(a[0], 0.5 * PDI_PI, PDI_PI)) return pdi_range_any();
        return pdi_range_rising(op, a[0]);
    case PDI_EXPR_OP_abs:
    case PDI_EXPR_OP_cosh: return pdi_range_valley(op, a[0]);
    case PDI_EXPR_OP_min:
    case PDI_EXPR_OP_max: return pdi_range_least(op, a);
    case PDI_EXPR_OP_atan2: return pdi_range_angle(a);
    case PDI_EXPR_OP_pow: return pdi_range_power(a);
    case PDI_EXPR_OP_if: return pdi_range_choice(a);
    default: return pdi_range_rising(op, a[0]); /* exp log log10 tanh sinh atan erf floor sqrt */
    }
}

/* Interval of a user function from three samples; all numbers if it has a break in a .. b. */
static pdi_range pdi_range_function(const pd_expr *expr, const double *vars, int index, double a, double b)
{
    double at[PD_EXPR_VARS], low = HUGE_VAL, high = -HUGE_VAL;
    memcpy(at, vars, sizeof at);
    for (int k = 0; k < expr->break_count && index == expr->clock; k++)
        if (expr->breaks[k] >= a && expr->breaks[k] <= b && b > a) return pdi_range_any();
    for (int k = 0; k < 3; k++) {
        at[index] = k < 2 ? (k ? b : a) : 0.5 * (a + b);
        double value = expr->fn(expr->user, at);
        if (isnan(value)) return pdi_range_any();
        low = pdi_min(low, value);
        high = pdi_max(high, value);
    }
    return pdi_range_make(low, high);
}

PDI_FN pdi_range pdi_range_of(const pd_expr *expr, const double *vars, int index, double a, double b)
{
    pdi_range stack[PDI_EXPR_STACK];
    int top = 0;
    if (expr->fn) return pdi_range_function(expr, vars, index, a, b);
    for (int k = 0; k < expr->code_count; k++) {
        int op = expr->code[k] & 255, at = expr->code[k] >> 8;
        if (op == PDI_EXPR_CONST) {
            stack[top++] = pdi_range_make(expr->value[at], expr->value[at]);
        } else if (op == PDI_EXPR_VAR) {
            stack[top++] = at == index ? pdi_range_make(a, b) : pdi_range_make(vars[at], vars[at]);
        } else if (op == PDI_EXPR_TABLE) {
            stack[top - 1] = pdi_range_table(expr->tables[at].curve, stack[top - 1]);
        } else {
            top -= pdi_expr_operands(op);
            stack[top] = pdi_range_apply(op, stack + top);
            top++;
        }
    }
    return top == 1 ? stack[0] : pdi_range_any();
}
