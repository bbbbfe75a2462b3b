/* slope: gradient of a scalar at nodes beside smooth surfaces, exact for quadratics.
 *
 * The gradient (3.5) of a cut family is exact for linear fields: on one side of a surface its error is half the bend of
 * the field over the reach of the bonds. Rows on shapes that are curved or inclined fit a quadratic to their open bonds
 * instead, where these determine one (theory: eq. 3.5b).
 */
#ifndef PD_SLOPE_H
#define PD_SLOPE_H
#include "bond.h"

typedef struct pd_slopes {
    const pd_bonds *bonds;
    int32_t count, capacity;
    int32_t *row;   /* [capacity] rows with a fit */
    double *weight; /* [capacity][PD_DIM][terms] from the moments of the differences to the gradient */
} pd_slopes;

#define pd_slopes_update PD_NAME(pd_slopes_update)
#define pd_slopes_free PD_NAME(pd_slopes_free)

/* The fits of all rows as the geometry is; `slopes` starts as zeros or from the last time. */
PD_API pd_status pd_slopes_update(pd_ctx *ctx, const pd_bonds *bonds, pd_slopes *slopes);
PD_API void pd_slopes_free(pd_ctx *ctx, pd_slopes *slopes);

#ifdef PDI_INTERNAL
/* grad [PD_DIM][total] of f [total] at these rows; ghosts must be filled. */
PDI_FN void pdi_slopes_apply(const pd_ctx *ctx, const pd_slopes *slopes, const double *f, double *grad);
#endif

#endif
