/* root_bracket: bracketed root finding for a function of one variable, by the Illinois form of regula falsi.
 *
 * The secant through both ends gives the next point. Where one end stays for a second time, its value is halved:
 * otherwise a convex function moves one end only. Every fourth point is the midpoint (bisection), so that a jump is
 * bracketed too. A secant point that coincides with an end within rounding is moved off it, twice as far with each
 * step. Convergence order 1.44 at a simple root. The caller evaluates the function:
 *     pdi_root_bracket s = {a, f(a), b, f(b), 0, 0};
 *     while (s.b - s.a > tolerance && pdi_root_bracket_get_next(&s, &x)) pdi_root_bracket_update(&s, x, f(x));
 * Source: Dowell and Jarratt 1971 (the Illinois rule).
 */
#ifndef PD_ROOT_BRACKET_H
#define PD_ROOT_BRACKET_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef struct pdi_root_bracket {
    double a, value_a;          /* [-] (units of the caller) an end and f(a), which is not zero */
    double b, value_b;          /* the other end, below or above a, and f(b), whose sign is not that of f(a) */
    int evaluations, last_kept; /* evaluations so far; 1: the last step kept the end a, -1: it kept b */
} pdi_root_bracket;

/* Position of the next point as a fraction of the distance from a to b, 0 to 1: that of the secant, or 1/2 in every
 * fourth step (bisection). For callers that interpolate in a variable of their own; a point at an end is not moved off
 * it. */
PDI_FN double pdi_root_bracket_compute_fraction(const pdi_root_bracket *s);
/* 1: *x is the next point at which to evaluate, strictly between the ends. 0: no double lies between them, or there
 * were 200 evaluations; *x has no meaning. */
PDI_FN int pdi_root_bracket_get_next(const pdi_root_bracket *s, double *x);
/* Update the bracket by `value` = f(x) at x between the ends: x replaces a where f(x) has the sign of f(a), else, also
 * for f(x) = 0, it replaces b. Halves the stored value of an end that stays for the second time. Counts the
 * evaluation. */
PDI_FN void pdi_root_bracket_update(pdi_root_bracket *s, double x, double value);
#endif

#endif
