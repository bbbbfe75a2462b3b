/* bracket: see bracket.h */
#include "core/bracket.h"
#include <float.h>
#include <math.h>

#define PDI_BRACKET_STEPS 200 /* most evaluations, 50 of them bisections */
#define PDI_BRACKET_MIDDLE 4 /* every such step bisects */

PDI_FN double pdi_bracket_fraction(const pdi_bracket *s)
{
    if (s->steps % PDI_BRACKET_MIDDLE == PDI_BRACKET_MIDDLE - 1) return 0.5;
    return s->at_a / (s->at_a - s->at_b);
}

/* Distance from an end at which to evaluate when the secant point coincides with it: eps |end| 2^steps. */
static double pdi_bracket_near(const pdi_bracket *s, double end)
{
    return ldexp(DBL_EPSILON * fabs(end), s->steps);
}

PDI_FN int pdi_bracket_next(const pdi_bracket *s, double *x)
{
    double low = pdi_min(s->a, s->b), high = pdi_max(s->a, s->b);
    if (s->steps >= PDI_BRACKET_STEPS) return 0;
    int half = s->steps % PDI_BRACKET_MIDDLE == PDI_BRACKET_MIDDLE - 1;
    *x = s->a + (s->b - s->a) * s->at_a / (s->at_a - s->at_b); /* the product first: ratios stay exact */
    if (*x <= low) *x = low + pdi_bracket_near(s, low);
    else if (*x >= high) *x = high - pdi_bracket_near(s, high);
    if (half || !(*x > low) || !(*x < high)) *x = low + 0.5 * (high - low);
    return *x > low && *x < high;
}

/* Half the value; unchanged where halving would lose its sign by underflow. */
static double pdi_bracket_half(double value) { return fabs(value) >= 2.0 * DBL_MIN ? 0.5 * value : value; }

PDI_FN void pdi_bracket_take(pdi_bracket *s, double x, double value)
{
    s->steps++;
    if (value != 0.0 && (value > 0.0) == (s->at_a > 0.0)) {
        s->a = x;
        s->at_a = value;
        if (s->kept < 0) s->at_b = pdi_bracket_half(s->at_b);
        s->kept = -1;
    } else {
        s->b = x;
        s->at_b = value;
        if (s->kept > 0) s->at_a = pdi_bracket_half(s->at_a);
        s->kept = 1;
    }
}

#undef PDI_BRACKET_STEPS
#undef PDI_BRACKET_MIDDLE
