/* interval: bounds of an expression while one of its variables passes an interval, by interval arithmetic on its code
 * (Moore, Kearfott and Cloud 2009). */
#ifndef PD_INTERVAL_H
#define PD_INTERVAL_H
#include "setup/expr.h"

#ifdef PDI_INTERNAL
/* A closed interval that contains all values; low and high may be infinite. It is wider than the values by the
 * dependency of repeated variables, and shrinks to a point with the interval of the variable. */
typedef struct pdi_interval {
    double low, high; /* [unit of the expression in SI] */
} pdi_interval;

/* Bounds of the expression while variable `index` passes a .. b, b >= a; the others are fixed at vars[PD_EXPR_VARS].
 * All real numbers where nothing is known: NaN, a pole, an expression that was never built. A user function is taken at
 * both ends and in the middle, which is no bound; one with a break in a .. b has all real numbers. */
PDI_FN pdi_interval pdi_interval_eval_expr(const pd_expr *expr, const double *vars, int index, double a, double b);
#endif

#endif
