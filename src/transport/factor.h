/* factor: an incomplete factorisation of the linearised equations of limited transport, on a plane lattice whose bonds
 * end on the eight nodes around (theory: 6.14).
 *
 * The derivative of the limiter joins a node with the 24 others of the square of five by five around it. Column by
 * column, along the stream, elimination within these squares leaves out next to nothing.
 */
#ifndef PD_FACTOR_H
#define PD_FACTOR_H
#include "transport/flux.h"

typedef struct pd_factor {
    const pd_flux *flux;     /* borrowed */
    const uint8_t *upwinded; /* [total] nodes without antidiffusive fluxes. Borrowed */
    int axis, down;          /* columns follow each other along this axis; 1: downwards */
    float *entry;            /* [nodes of the box][5][5] [1/s] factors of a row, one over its pivot; lent, else NULL */
    double *x;               /* [2][nodes with a rim of two] [mol/m3/s], [mol/m3] work; lent, too */
    float *near;             /* [2][3][nodes of a column with a rim][PDI_FACTOR_NEAR] derivatives of alpha and of the
                              * gradient by the family; lent, too */
    int good;                /* 1: it can be used */
    int took;                /* iterations of the last system solved with it */
} pd_factor;

#ifdef PDI_INTERNAL
/* Entries of `near` for a node: alpha, and both components of the gradient, three lines of four each. */
#define PDI_FACTOR_NEAR 36
/* Lend it in place of vectors of a basis that is not lent, where some are left and such lattices are asked for. */
PDI_FN void pdi_factor_lend(pd_ctx *ctx, pd_arena *arena, pd_krylov *krylov, pd_factor *factor);
/* What was lent goes back. */
PDI_FN pd_status pdi_factor_return(pd_ctx *ctx, pd_arena *arena, pd_status status, pd_krylov *krylov,
                                   pd_factor *factor);
/* Factors of the equations about c [mol/m3], with its images, the present limiter and the rate [1/s] in time; steps
 * below `least` [mol/m3] are faint. */
PDI_FN void pdi_factor_make(const pd_ctx *ctx, pd_factor *factor, const double *c, double rate, double least);
/* y = near A^-1 x at fluid nodes. */
PDI_FN void pdi_factor_solve(const pd_ctx *ctx, const pd_factor *factor, const double *x, double *y);
#endif

#endif
