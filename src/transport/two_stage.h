/* two_stage: transport in time, of second order, with error-controlled steps.
 *
 * The two-stage L-stable SDIRK method of implicit.h on the implicit stages of transport.h (theory: eq. 6.12 to 6.14).
 * No linear method of second order keeps all fields within their bounds for all steps; a step that leaves them is taken
 * again by backward Euler, which does. Amounts are conserved to rounding either way.
 */
#ifndef PD_TWO_STAGE_H
#define PD_TWO_STAGE_H
#include "transport/transport.h"
#include "transport/settle.h"
#include "solve/physics.h"

typedef struct pd_two_stage_desc {
    double rtol;    /* [-] error of one step against the largest concentration, by the embedded estimate; 0: 1e-3 */
    double first;   /* [s] first step of a run; 0: found from the error of trial steps */
    double largest; /* [s] largest step of a run; 0: none */
} pd_two_stage_desc;

typedef struct pd_two_stage {
    pd_two_stage_desc desc; /* defaults filled in */
    pd_transport *transport;
    /* of the step at hand: called before each stage, for a flow that follows its boundary */
    pd_solve_at_fn at;
    void *at_user;
    double *start, *carry; /* [total] [mol/m3] field and carry at the start of the step */
    double *slope;         /* [total] [mol/m3] change of the first stage */
    double *rest;          /* [total] [mol/m3/s] what the first stage left undone */
    double time;           /* [s] */
    double dt;             /* [s] that a run would try next; 0: not known yet */
    double error;          /* [-] estimated error of the last step */
    double largest;        /* [mol/m3] concentration in the trials of a step */
    double out, in;        /* [mol] (per m in planar 2D) through outlets, inlets and held walls since the build */
    int settle;            /* set before a run of time_loop.h starts: the field starts steady */
    double passed[2];      /* [mol] out and in at the start of the step */
    pd_transport_result result; /* of the last stage */
    int64_t steps, rejected, krylov;
    int64_t euler;         /* steps taken by backward Euler to keep the bounds */
} pd_two_stage;

#define pd_two_stage_build PD_NAME(pd_two_stage_build)
#define pd_two_stage_step PD_NAME(pd_two_stage_step)
#define pd_two_stage_process PD_NAME(pd_two_stage_process)
#define pd_two_stage_free PD_NAME(pd_two_stage_free)

/* transport is borrowed; its c is the state. PD_ERR_ARGUMENT: a knob is negative or not finite. */
PD_API pd_status pd_two_stage_build(pd_ctx *ctx, pd_transport *transport, const pd_two_stage_desc *desc,
                                    pd_two_stage *two_stage);
/* One step of dt [s], whatever its error. result: of the last stage. PD_NOT_CONVERGED, here and in runs: a linear
 * solver stopped above its tolerance; what is missing is in the carry of transport. */
PD_API pd_status pd_two_stage_step(pd_ctx *ctx, pd_two_stage *two_stage, double dt, pd_transport_result *result);
/* The transport as a process, by steps of controlled error. PD_ERR_STATE: the error does not fall with the step. */
PD_API pd_physics pd_two_stage_process(pd_two_stage *two_stage);
PD_API void pd_two_stage_free(pd_ctx *ctx, pd_two_stage *two_stage);

#ifdef PDI_INTERNAL
/* Arrays of a pd_two_stage. */
PDI_FN void pdi_two_stage_list(pdi_array_visitor *owner, void *object);
#endif

#endif
