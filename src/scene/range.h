/* range: between what an expression stays while one of its variables passes an interval: interval arithmetic on its
 * code. */
#ifndef PD_RANGE_H
#define PD_RANGE_H
#include "scene/expr.h"

#ifdef PDI_INTERNAL
/* A closed interval, at most all numbers; wider than all values by what the operations do not know of each other, and
 * as narrow as wanted where the interval of the variable is. */
typedef struct pdi_range {
    double low, high; /* [unit of the expression in SI] */
} pdi_range;

/* Bounds of the expression for variable `index` from a to b >= a, with the others as vars[PD_EXPR_VARS] says. A
 * function of the caller is bounded by its values at both ends and in the middle, unless it has a break in between:
 * then by nothing. */
PDI_FN pdi_range pdi_range_of(const pd_expr *expr, const double *vars, int index, double a, double b);
#endif

#endif
