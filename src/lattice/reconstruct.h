/* reconstruct: fields beside smooth surfaces as quadratics through the nodes that a row sees.
 *
 * The gradient (3.5) of a cut family is exact for linear fields: on one side of a surface its error is half the bend of
 * the field over the reach of the bonds. And what (3.2) takes along each cut bond by itself leaves out how the slope of
 * the velocity changes along the surface. Rows on shapes that are curved or inclined take parabolas along the axes for
 * a scalar, or with wide families the quadratic closest to it at their far ends, and for a velocity a quadratic through
 * the places on the surface as well, where their bonds determine one (theory: eq. 3.5b, 3.4b). With the nearest
 * neighbours the cubic part of a velocity that vanishes on the surface follows from the second derivatives of the
 * pressure: what sums miss of it is known beforehand (eq. 3.4c).
 */
#ifndef PD_RECONSTRUCT_H
#define PD_RECONSTRUCT_H
#include "lattice/bond.h"

typedef struct pd_reconstruct {
    const pd_bonds *bonds;
    int32_t count, capacity; /* rows beside smooth surfaces */
    int32_t *row;            /* [capacity] */
    uint8_t *fits;           /* [capacity] 1: the bonds determine the fit of a velocity */
    double *bend;            /* [capacity][terms] [-] the sum over cut bonds of (3.4b) from the same moments */
    double *drag;            /* [capacity] [1/m2] what it takes from the velocity of the node, for the surface */
    double *term;            /* [bonds of the stencil][terms] [1/m2] weighted terms of the far ends of all rows */
    int32_t wide;            /* capacity, or 0: families of the nearest neighbours */
    double *miss;            /* [capacity - wide][PD_DIM][second derivatives] [m] what friction has too much (3.4c) for
                              * each second derivative of the pressure over mu */
    uint8_t *known;          /* [wide] 1: the bonds determine the fit of a scalar */
    double *slope;           /* [wide][PD_DIM][terms] [m] its gradient from the sums of terms times differences */
    int32_t rows;
    int32_t *place;          /* [rows] of a row of the bonds in these lists; -1: none */
} pd_reconstruct;

#ifdef PDI_INTERNAL
/* The fits as the geometry is; `slopes` holds zeros or those of before. excess: NULL, or [bonds of the stencil] [1/m2]
 * what friction adds, times `share`, to the weights of the Laplacian. */
PDI_FN pd_status pdi_reconstruct_update(pd_ctx *ctx, const pd_bonds *bonds, const double *excess, double share,
                                        pd_reconstruct *slopes);
PDI_FN void pdi_reconstruct_free(pd_ctx *ctx, pd_reconstruct *slopes);

#define PDI_RECONSTRUCT_BENDS (PD_DIM * (PD_DIM + 1) / 2) /* second derivatives: xx, yx, yy, .. */
/* grad [PD_DIM][total] of f [total] at the rows beside smooth surfaces: of the fit of wide families, else along axes on
 * which they have neighbours.
 * Ghosts must be filled. */
PDI_FN void pdi_reconstruct_gradient(const pd_ctx *ctx, const pd_reconstruct *slopes, const double *f, double *grad);
/* 1: row r of the bonds has a fit of a velocity. */
static inline int pdi_reconstruct_bent(const pd_reconstruct *slopes, int32_t r)
{
    return r < slopes->rows && slopes->place[r] >= 0 && slopes->fits[slopes->place[r]];
}
/* wall [PD_DIM] = what cut bonds make of the Laplacian of u [PD_DIM][total] at such a row beside a surface at rest. */
PDI_FN void pdi_reconstruct_bend(const pd_reconstruct *slopes, int32_t r, const double *u, double *wall);
/* Friction [PD_DIM] [unit of f / m] that such a row has too much beside a pressure f [total] (eq. 3.4c). */
PDI_FN void pdi_reconstruct_miss(const pd_reconstruct *slopes, int32_t r, const double *f, double *miss);
/* Slope at 0 of the parabola through `below` at -a, `at` at 0 and `above` at b. */
static inline double pdi_reconstruct_parabola(double a, double b, double below, double at, double above)
{
    return ((above - at) * a / b + (at - below) * b / a) / (a + b);
}
#endif

#endif
