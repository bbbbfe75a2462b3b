/* anderson: Anderson acceleration of a fixed-point iteration x = g(x) with an expensive map g.
 *
 * The residual is g(x) - x. The next iterate is the point of the affine space through the last iterates whose
 * linearised residual is least in norm, plus the mixing factor times that residual (Anderson 1965; Walker and Ni 2011);
 * for a linear map this is GMRES. Differences of residuals are kept orthonormal, and differences of iterates are
 * transformed with them (Eirola and Nevanlinna 1989); when the history is full, it is cleared. Strongly nonlinear maps,
 * as of metal that begins to yield, may diverge: where the residual grows twice in a row above the least one, the
 * iteration restarts from the best iterate with an empty history and half the mixing factor.
 */
#ifndef PD_ANDERSON_H
#define PD_ANDERSON_H
#include "core/array_registry.h"

/* Differences in the history at most. */
#define PD_ANDERSON_HISTORY 12

typedef struct pd_anderson {
    int64_t n;      /* entries of a vector */
    int count;      /* differences in the history */
    int has_previous;             /* 1: there is a previous iterate */
    double *previous_x;           /* [n] [unit of x] the previous iterate */
    double *previous_residual;    /* [n] [unit of x] its residual g(x) - x */
    int growth_count;             /* times in a row that the residual has grown above the least one */
    double previous_norm;         /* [unit of x] norm of the previous residual */
    double least_norm;            /* [unit of x] least norm of all residuals */
    double mixing;                /* [-] mixing (damping) factor; 1 until a restart halves it */
    double *best_x;               /* [n] [unit of x] the iterate of the least residual */
    double *best_residual;        /* [n] [unit of x] that residual */
    double *residual_differences; /* [KEPT][n] [-] differences of residuals, orthonormal */
    double *iterate_differences;  /* [KEPT][n] [-] differences of iterates, transformed with them */
} pd_anderson;

#ifdef PDI_INTERNAL
/* List function of the arrays, by the member n. */
PDI_FN void pdi_anderson_list(pdi_array_visitor *owner, void *anderson);
/* Replace the iterate x [n] by the next one. step [n]: the residual g(x) - x, overwritten. Without a previous iterate
 * it adds step to x. Where the norm of the residual is above the least one, and has risen against the call before for
 * the second time in a row, it goes on from the best iterate with an empty history and half the mixing factor. Before
 * the first call all members but n and the arrays are 0. Bitwise reproducible for any number of threads. */
PDI_FN void pdi_anderson_update(pd_anderson *anderson, double *x, double *step);
/* Forget all iterates, the best one too, and set the mixing factor to 1; for a map that has changed. */
PDI_FN void pdi_anderson_reset(pd_anderson *anderson);
#endif

#endif
