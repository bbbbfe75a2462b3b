/* quadratic_fit: interpolation at a point by the weighted least-squares fit of a quadratic to values and normal
 * derivatives nearby (theory: eq. 1.11).
 *
 * Squared residuals have the weight 1/r^4, r the distance in cells, so that the fit passes through a datum at the point
 * itself. What the data do not determine is zero: second derivatives first, then gradients.
 */
#ifndef PD_QUADRATIC_FIT_H
#define PD_QUADRATIC_FIT_H
#include "core/config.h"

#ifdef PDI_INTERNAL
#define PDI_QUADRATIC_FIT_TERMS ((PD_DIM + 1) * (PD_DIM + 2) / 2) /* coefficients of a quadratic */
#define PDI_QUADRATIC_FIT_MAX_DATA 96                             /* largest number of data of a fit */
#define PDI_QUADRATIC_FIT_MAX_SQUARE 4 /* [cells2] largest squared length of the bonds whose ends are data */
/* A fit in progress: one weighted equation a datum. */
typedef struct pdi_quadratic_fit {
    double x[PD_DIM], h[PD_DIM]; /* [m] the point, and the unit of length along each axis */
    int rows;                    /* data so far */
    /* [unit of the field] weighted equations; the last column is the right-hand side */
    double row[PDI_QUADRATIC_FIT_MAX_DATA + PDI_QUADRATIC_FIT_TERMS][PDI_QUADRATIC_FIT_TERMS + 1];
    double weight[PDI_QUADRATIC_FIT_MAX_DATA + PDI_QUADRATIC_FIT_TERMS]; /* [-] 1/r^2 of each equation */
} pdi_quadratic_fit;
/* Begins a fit without data at the point x [PD_DIM] [m] with the lengths h [PD_DIM] [m] as units (the spacings). */
PDI_FN void pdi_quadratic_fit_init(pdi_quadratic_fit *fit, const double *x, const double *h);
/* Adds a datum: the field is `value` at x [m], with the weight 1/(r^2 + 1e-6) of its equation, r in cells. Dropped when
 * there are PDI_QUADRATIC_FIT_MAX_DATA data already. */
PDI_FN void pdi_quadratic_fit_add_value(pdi_quadratic_fit *fit, const double *x, double value);
/* Adds a datum: the derivative of the field at x [m] along the unit vector `normal` is `derivative` [unit of the field
 * / m], with the weight 1/(r^2 + 1) of its equation, r in cells. Dropped when there are PDI_QUADRATIC_FIT_MAX_DATA data
 * already. */
PDI_FN void pdi_quadratic_fit_add_derivative(pdi_quadratic_fit *fit, const double *x, const double *normal,
                                             double derivative);
/* Solves the least-squares problem; returns the value of the quadratic at the point, NaN without data. Derivatives that
 * the data do not determine are 0; with derivatives as only data the value is 0. Overwrites the data: a fit is solved
 * once. */
PDI_FN double pdi_quadratic_fit_solve(pdi_quadratic_fit *fit);
#endif

#endif
