/* bracket: where a function of one variable changes its sign, between two places where it has different ones.
 *
 * The straight line between both ends says where to ask next. Where one end stays for a second time, its value is
 * halved: without that a curved function moves one end only. Each fourth place is the middle, so that the bracket of
 * a function with a jump is halved too. A line that meets an end within rounding asks beside that end, twice as far off
 * with each step. Order 1.44 at a simple root. The caller asks the function:
 *     pdi_bracket s = {a, f(a), b, f(b), 0, 0};
 *     while (s.b - s.a > tolerance && pdi_bracket_next(&s, &x)) pdi_bracket_take(&s, x, f(x));
 * Source: Dowell and Jarratt 1971 (the Illinois rule).
 */
#ifndef PD_BRACKET_H
#define PD_BRACKET_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef struct pdi_bracket {
    double a, at_a;  /* [-] (units of the caller) an end and the value there, which is not zero */
    double b, at_b;  /* the other end, below or above a, and the value there, which has not the sign of at_a */
    int steps, kept; /* places asked for; 1: `a` was kept in the last step, -1: b was */
} pdi_bracket;

/* Fraction of the way from a to b where to ask next, from 0 to 1. */
PDI_FN double pdi_bracket_fraction(const pdi_bracket *s);
/* The place at this share of the way. 0: no number lies between the ends, or 200 places were asked for. */
PDI_FN int pdi_bracket_next(const pdi_bracket *s, double *x);
/* The value at x, between the ends: x becomes `a` where that has the sign of at_a, and else b. */
PDI_FN void pdi_bracket_take(pdi_bracket *s, double x, double value);
#endif

#endif
