/* precond: the inverse of the Schur complement of the pressure, as nearly as a preconditioner needs it (theory:
 * eq. 4.9).
 */
#ifndef PD_PRECOND_H
#define PD_PRECOND_H
#include "solve/multigrid.h"
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Work of an application. */
typedef struct pdi_precond {
    pd_multigrid *poisson;    /* one cycle of it stands for the inverse of -lap */
    pd_multigrid *seep;       /* one cycle of it stands for the inverse of -div(mobility grad) */
    double shift;             /* [1/s] of the momentum balance */
    double *grad, *convected; /* [PD_DIM][total] */
} pdi_precond;

/* mobility [total] [s]: about the velocity of the fluid over a uniform pressure gradient. It is one over the sum of
 * `shift` [1/s] and the drag of the walls (theory: eq. 4.9b). 0 outside of the fluid. */
PDI_FN void pdi_precond_mobility(const pd_ctx *ctx, const pd_flow *flow, double shift, double *mobility);

/* dp = S^-1 r, with the velocity in flow. q [total]: a cycle of `poisson` for r, then work, its ghosts too. All arrays
 * are over the nodes of the grid, r and dp mean something at fluid nodes only. */
PDI_FN void pdi_precond_solve(pd_ctx *ctx, const pd_flow *flow, const pdi_precond *precond, const double *r, double *q,
                            double *dp);
#endif

#endif
