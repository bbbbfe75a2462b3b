/* root_bracket: see root_bracket.h */
#include "core/root_bracket.h"
#include <float.h>
#include <math.h>

#define PDI_ROOT_BRACKET_MAX_EVALUATIONS 200 /* most evaluations, 50 of them bisections */
#define PDI_ROOT_BRACKET_BISECT_EVERY 4      /* every such step bisects */

PDI_FN double pdi_root_bracket_compute_fraction(const pdi_root_bracket *s)
{
    if (s->evaluations % PDI_ROOT_BRACKET_BISECT_EVERY == PDI_ROOT_BRACKET_BISECT_EVERY - 1) return 0.5;
    return s->value_a / (s->value_a - s->value_b);
}

/* Distance from an end at which to evaluate when the secant point coincides with it: eps |end| 2^evaluations. */
static double pdi_root_bracket_offset(const pdi_root_bracket *s, double end)
{
    return ldexp(DBL_EPSILON * fabs(end), s->evaluations);
}

PDI_FN int pdi_root_bracket_get_next(const pdi_root_bracket *s, double *x)
{
    double low = pd_min(s->a, s->b), high = pd_max(s->a, s->b);
    if (s->evaluations >= PDI_ROOT_BRACKET_MAX_EVALUATIONS) return 0;
    int half = s->evaluations % PDI_ROOT_BRACKET_BISECT_EVERY == PDI_ROOT_BRACKET_BISECT_EVERY - 1;
    *x = s->a + (s->b - s->a) * s->value_a / (s->value_a - s->value_b); /* the product first: ratios stay exact */
    if (*x <= low) *x = low + pdi_root_bracket_offset(s, low);
    else if (*x >= high) *x = high - pdi_root_bracket_offset(s, high);
    if (half || !(*x > low) || !(*x < high)) *x = low + 0.5 * (high - low);
    return *x > low && *x < high;
}

/* Half the value; unchanged where halving would lose its sign by underflow. */
static double pdi_root_bracket_halve(double value) { return fabs(value) >= 2.0 * DBL_MIN ? 0.5 * value : value; }

PDI_FN void pdi_root_bracket_update(pdi_root_bracket *s, double x, double value)
{
    s->evaluations++;
    if (value != 0.0 && (value > 0.0) == (s->value_a > 0.0)) {
        s->a = x;
        s->value_a = value;
        if (s->last_kept < 0) s->value_b = pdi_root_bracket_halve(s->value_b);
        s->last_kept = -1;
    } else {
        s->b = x;
        s->value_b = value;
        if (s->last_kept > 0) s->value_a = pdi_root_bracket_halve(s->value_a);
        s->last_kept = 1;
    }
}

#undef PDI_ROOT_BRACKET_MAX_EVALUATIONS
#undef PDI_ROOT_BRACKET_BISECT_EVERY
