/* implicit: time-dependent incompressible flow by the two-stage, second-order, L-stable SDIRK method.
 *
 * du/dt + R(u, P) = 0,  div u = 0 on the sums of flow.h. Both stages have the form R(u) + (u - u*)/(gamma dt) = 0 with
 * gamma = 1 - 1/sqrt(2) and are solved by the Newton-Krylov method of steady.h (theory: eq. 3.40 to 3.45; Alexander
 * 1977; Hairer and Wanner 1996, IV.6). No sound, so no acoustic limit on the step; an impulsive start is damped, not
 * kept. A start that does not obey continuity or the inlets is projected onto the nearest one that does.
 */
#ifndef PD_IMPLICIT_H
#define PD_IMPLICIT_H
#include "flow/steady_newton.h"
#include "solve/physics.h"

typedef struct pd_implicit_desc {
    double stage_tolerance; /* [-] of the stages, against the reference speed; 0: a thousandth of rtol */
    double rtol;      /* [-] error of one step against the reference speed, by the embedded estimate; 0: 1e-4 */
    double first_step; /* [s] first step of a run; 0: 1e-3 / (U/L + nu/L^2) */
    double max_step;   /* [s] largest step of a run; 0: none */
} pd_implicit_desc;

typedef struct pd_implicit {
    pd_implicit_desc desc; /* defaults filled in */
    pd_flow *flow;         /* its u and p are the state */
    pd_steady *steady;     /* solves the stages */
    double *start_state;   /* [PD_DIM+2][total] [m/s], [m2/s2], [m2/s] state at the start of the step */
    double *pressure_impulse; /* [total] [m2/s] which the pressure flux is made of (eq. 3.43) */
    /* [PD_DIM][total] [m/s] and its gradient: the flow borrows both, and the next one */
    double *pressure_impulse_grad;
    double *pressure_impulse_flux; /* [total] [1/s] */
    double *stage_target;          /* [PD_DIM][total] [m/s] u* of the second stage, kept for the next step */
    double *stage_increment;       /* [PD_DIM][total] [m/s] gamma dt du/dt of the first stage; lent for a step */
    double time;           /* [s] */
    double dt;             /* [s] step that is tried next; 0: not known yet */
    double last_step;      /* [s] last step, for extrapolation; 0: do not extrapolate */
    int projected;         /* 1: the start has been projected onto continuity and the inlets */
    int64_t has_new_fluid; /* 1: nodes have become fluid, so the next step begins with a projection */
    double error;          /* [-] estimated error of the last step against the reference speed */
    int64_t steps, rejected, evaluations;
} pd_implicit;

#define pd_implicit_build PD_NAME(pd_implicit_build)
#define pd_implicit_step PD_NAME(pd_implicit_step)
#define pd_implicit_process PD_NAME(pd_implicit_process)
#define pd_implicit_free PD_NAME(pd_implicit_free)

/* Starts from the state in flow; flow and steady are borrowed. Raises the scale U of the flow to its velocities, lends
 * it the pressure impulse, which starts at 0, and prepares steady for stages. PD_ERR_ARGUMENT: a setting is negative or
 * not finite; flow and steady are unchanged. After any error implicit is freed, and the flow has no pressure
 * impulse. */
PD_API pd_status pd_implicit_build(pd_ctx *ctx, pd_flow *flow, pd_steady *steady, const pd_implicit_desc *desc,
                                   pd_implicit *implicit);
/* One step of dt [s], whatever its error, which is in `error`. The first step, and one after new fluid, begins with a
 * projection. PD_RETRY: the projection or a stage did not converge. PD_ERR_ARGUMENT: dt is not positive and finite, or
 * a boundary value is not finite. After these two the flow is that before the step (projected, if that has converged),
 * but walls have no acceleration, and U may be larger. */
PD_API pd_status pd_implicit_step(pd_ctx *ctx, pd_implicit *implicit, double dt);
/* The flow as a process; it prepares the flow. Steps of controlled error. PD_ERR_STATE: steps of 1e-12 of the first one
 * do not converge, or their error does not fall. */
PD_API pd_physics pd_implicit_process(pd_implicit *implicit);
PD_API void pd_implicit_free(pd_ctx *ctx, pd_implicit *implicit);

#ifdef PDI_INTERNAL
/* Lists the arrays of a pd_implicit that the build makes. */
PDI_FN void pdi_implicit_list(pdi_array_visitor *owner, void *object);
/* Scratch memory [byte] of a step beside that of the steady solver. */
PDI_FN size_t pdi_implicit_count_work_bytes(pd_implicit *implicit);
#endif

#endif
