/* schur_precond: approximate inverse of the Schur complement of the pressure, for the preconditioner of the flow solver
 * (theory: eq. 3.29). */
#ifndef PD_SCHUR_PRECOND_H
#define PD_SCHUR_PRECOND_H
#include "solve/multigrid.h"
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Operators and work arrays of the Schur complement preconditioner. */
typedef struct pdi_schur_precond {
    pd_multigrid *poisson;    /* one cycle of it stands for the inverse of -lap */
    pd_multigrid *darcy;      /* one cycle of it stands for the inverse of -div(mobility grad) */
    double shift;             /* [1/s] of the momentum balance */
    double *grad, *convective; /* [PD_DIM][total] */
} pdi_schur_precond;

/* mobility [total] [s] = 1/(shift + wall drag) at fluid nodes, 0 elsewhere and where that sum is 0: velocity over a
 * uniform pressure gradient (eq. 3.30). shift [1/s]: rate of (pseudo) time. */
PDI_FN void pdi_schur_precond_compute_mobility(const pd_ctx *ctx, const pd_flow *flow, double shift, double *mobility);

/* dp [total] [m2/s2] = S^-1 r, approximate inverse of the Schur complement of the pressure (eq. 3.29), with the
 * velocity in flow. r [1/s]; q: one cycle of `poisson` for r, then work with its ghosts. Arrays are over nodes, r and
 * dp at fluid nodes. Overwrites grad and convective of precond. */
PDI_FN void pdi_schur_precond_apply(pd_ctx *ctx, const pd_flow *flow, const pdi_schur_precond *precond, const double *r,
                                    double *q, double *dp);
#endif

#endif
