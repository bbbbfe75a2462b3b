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

/* Bounds of the expression while variable `index` passes a .. b, b >= a; the others are fixed at vars[PD_EXPR_VARS]. A
 * user function is bounded by its values at both ends and in the middle, or not at all if it has a break in between. */
PDI_FN pdi_interval pdi_interval_eval_expr(const pd_expr *expr, const double *vars, int index, double a, double b);
#endif

#endif
