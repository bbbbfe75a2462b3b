/* reconstruct: fields beside smooth surfaces as quadratics through the nodes that a row sees.
 *
 * The gradient (3.5) of a cut family is exact for linear fields: on one side of a surface its error is half the bend of
 * the field over the reach of the bonds. And what (3.2) takes along each cut bond by itself leaves out how the slope of
 * the velocity changes along the surface. Rows on shapes that are curved or inclined fit quadratics instead, where
 * their bonds determine them: of a scalar to the open bonds, of a velocity to the places on the surface as well
 * (theory: eq. 3.5b, 3.4b).
 */
#ifndef PD_RECONSTRUCT_H
#define PD_RECONSTRUCT_H
#include "lattice/bond.h"

typedef struct pd_reconstruct {
    const pd_bonds *bonds;
    int32_t count, capacity; /* rows beside smooth surfaces */
    int32_t *row;            /* [capacity] */
    uint8_t *fits; /* [capacity] PDI_RECONSTRUCT_SCALAR, PDI_RECONSTRUCT_VELOCITY: those that the bonds determine */
    double *grad;            /* [capacity][PD_DIM][terms] [1/m] gradient from the moments of the differences */
    double *bend;            /* [capacity][terms] [1/m2] the sum over cut bonds of (3.4b) from the same moments */
    double *drag;            /* [capacity] [1/m2] what it takes from the velocity of the node, for the surface */
    double *term;            /* [bonds of the stencil][terms] [-] weighted terms of the far ends of all rows */
    int32_t rows;
    int32_t *place;          /* [rows] of a row of the bonds in these lists; -1: none */
} pd_reconstruct;

#ifdef PDI_INTERNAL
/* The fits as the geometry is; `slopes` holds zeros or those of before. */
PDI_FN pd_status pdi_reconstruct_update(pd_ctx *ctx, const pd_bonds *bonds, pd_reconstruct *slopes);
PDI_FN void pdi_reconstruct_free(pd_ctx *ctx, pd_reconstruct *slopes);

/* Value of f [total] at the place x [m] beside fluid node `node`: that of the quadratic (3.11) through the node and the
 * far ends of its open bonds. Ghosts must be filled; inlets carry no scalar. */
PDI_FN double pdi_reconstruct_value(const pd_bonds *bonds, const double *f, int32_t node, const double *x);
#define PDI_RECONSTRUCT_SCALAR 1 /* the row has the fit of a scalar */
#define PDI_RECONSTRUCT_VELOCITY 2 /* the row has the fit of a velocity */
/* grad [PD_DIM][total] of f [total] at the rows that have a fit of a scalar; ghosts must be filled. */
PDI_FN void pdi_reconstruct_gradient(const pd_ctx *ctx, const pd_reconstruct *slopes, const double *f, double *grad);
/* 1: row r of the bonds has a fit of a velocity. */
static inline int pdi_reconstruct_bent(const pd_reconstruct *slopes, int32_t r)
{
    return r < slopes->rows && slopes->place[r] >= 0 && (slopes->fits[slopes->place[r]] & PDI_RECONSTRUCT_VELOCITY);
}
/* wall [PD_DIM] = what cut bonds make of the Laplacian of u [PD_DIM][total] at such a row beside a surface at rest. */
PDI_FN void pdi_reconstruct_bend(const pd_reconstruct *slopes, int32_t r, const double *u, double *wall);
#endif

#endif
