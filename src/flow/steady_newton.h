/* steady_newton: steady flow by Newton's method with pseudo time continuation, and stages of implicit steps in time.
 *
 * Residual, linear step and preconditioner are those of pd_steady. The pseudo time step grows as the residual falls
 * (switched evolution relaxation, eq. 3.32).
 */
#ifndef PD_STEADY_NEWTON_H
#define PD_STEADY_NEWTON_H
#include "flow/steady.h"

#define pd_steady_solve PD_NAME(pd_steady_solve)

/* From the state in flow to the steady state, and its divergence potential; updates the surface patches.
 * PD_NOT_CONVERGED (positive): the limit came first or steps make no progress, flow holds the last state and result its
 * residuals. PD_ERR_DIVERGED: the residual is not finite, or coefficients of the preconditioner are not. A pressure
 * impulse that the flow has takes no part, and becomes that of the last state, tau (p - p_out). */
PD_API pd_status pd_steady_solve(pd_ctx *ctx, pd_steady *steady, pd_steady_result *result);

#ifdef PDI_INTERNAL
/* Solves R(u, p) + rate (u - target) = 0 from the state in flow: one stage of an implicit time step, in at most 8
 * Newton steps. rate [1/s], target [PD_DIM][total] [m/s]. tolerance [-]: of the velocity error over U and of the
 * continuity residual. A preconditioner of the same rate is used again. PD_RETRY: not converged, or an error in the
 * solve that is not fatal; flow holds no solution. */
PDI_FN pd_status pdi_steady_newton_solve_stage(pd_ctx *ctx, pd_steady *steady, double rate, const double *target,
                                               double tolerance, pd_steady_result *result);
#endif

#endif
