/* balance: what makes uniform stresses of an ordinary material balance beside surfaces.
 *
 * Families of which bonds are missing carry a uniform stress P by bond forces that do not add up to zero at each point
 * of a free surface. Forces that do no work on uniform strains mend that: w z(v), where z is what the extension n.(v_j -
 * v_i) of a bond has beyond the strain of its family. The v of each P solves a symmetric system (theory: eq. 8.15).
 */
#ifndef PD_BALANCE_H
#define PD_BALANCE_H
#include "solid/body.h"
#include "solid/strain.h"

#ifdef PDI_INTERNAL
/* A system  sum_j V_j w (z_ij + z_ji) n = -rest. */
typedef struct pdi_balance {
    const pd_body *body;
    const float *weight;   /* [bonds] [-] w; 0: the bond is broken */
    const double *inverse; /* [count][tensors] inverse of sum w V_j r^2 (n n)(n n) */
    double *v;             /* [count][PD_DIM] */
    double *bend;          /* [count][tensor] strain of the family by v */
    double *rest;          /* [count][PD_DIM] what has to be balanced, less what is */
    double *block, *way, *done, *mended; /* work */
    int iterations;
    double residual;       /* largest of what is left, over the largest of what there was */
} pdi_balance;

PDI_FN pd_status pdi_balance_build(pd_ctx *ctx, const pd_body *body, const float *weight, const double *inverse,
                                   pdi_balance *balance);
/* v and its bend of the `rest`. rounding: what is left of it that is none. PD_NOT_CONVERGED: families have too few bonds
 * for that. */
PDI_FN pd_status pdi_balance_solve(pd_ctx *ctx, pdi_balance *balance, double rounding);
PDI_FN void pdi_balance_free(pd_ctx *ctx, pdi_balance *balance);
#endif

#endif
