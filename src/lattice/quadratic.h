/* quadratic: the value at a place of the quadratic that fits values and slopes around it best.
 *
 * Data count with 1/r^4 of their distance in cells, so that the fit goes through a datum at the place itself. What
 * the data do not determine is zero: second derivatives, then slopes.
 */
#ifndef PD_QUADRATIC_H
#define PD_QUADRATIC_H
#include "core/config.h"

#ifdef PDI_INTERNAL
#define PDI_QUADRATIC_TERMS ((PD_DIM + 1) * (PD_DIM + 2) / 2)
#define PDI_QUADRATIC_ROWS 96 /* most data of a fit */
#define PDI_QUADRATIC_SQUARE 4 /* largest squared length of the bonds whose ends count, in cells */
typedef struct pdi_quadratic {
    double x[PD_DIM], h[PD_DIM]; /* [m] the place, and the unit of lengths along each axis */
    int rows;
    /* weighted; the last column is the right-hand side */
    double row[PDI_QUADRATIC_ROWS + PDI_QUADRATIC_TERMS][PDI_QUADRATIC_TERMS + 1];
    double weight[PDI_QUADRATIC_ROWS + PDI_QUADRATIC_TERMS];
} pdi_quadratic;
PDI_FN void pdi_quadratic_start(pdi_quadratic *fit, const double *x, const double *h);
/* The field is `value` at x [m]; its slope along the unit vector `normal` there is `slope` [1/m]. Data beyond the room
 * are dropped. */
PDI_FN void pdi_quadratic_value(pdi_quadratic *fit, const double *x, double value);
PDI_FN void pdi_quadratic_slope(pdi_quadratic *fit, const double *x, const double *normal, double slope);
/* Value at the place; NaN without data. The data are used up. */
PDI_FN double pdi_quadratic_solve(pdi_quadratic *fit);
#endif

#endif
