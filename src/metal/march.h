/* march: explicit steps of bond-based corrosion (corrode.h), and how long they may be (theory: section 6.5). */
#ifndef PD_MARCH_H
#define PD_MARCH_H
#include "metal/corrode.h"
#include "solve/process.h"

#define pd_corrode_limit PD_NAME(pd_corrode_limit)
#define pd_corrode_step PD_NAME(pd_corrode_step)
#define pd_corrode_run PD_NAME(pd_corrode_run)
#define pd_corrode_process PD_NAME(pd_corrode_process)

/* Longest step [s] that keeps concentrations positive and without new extremes, at the present concentrations; HUGE_VAL
 * when nothing moves. PD_ERR_STATE: the law gives no finite speed (the message names node, place and concentration). */
PD_API pd_status pd_corrode_limit(pd_ctx *ctx, pd_corrode *corrode, double *limit);
/* One step of forward Euler by dt [s]. PD_RETRY: dt exceeds the limit, nothing changed. PD_ERR_STATE as above. */
PD_API pd_status pd_corrode_step(pd_ctx *ctx, pd_corrode *corrode, double dt);
/* Steps up to t_end [s], each as long as a bound of 0.5 to 1 of the limit, the share and (with fluid that is not held)
 * the overshoot allow. */
PD_API pd_status pd_corrode_run(pd_ctx *ctx, pd_corrode *corrode, double t_end);
/* The corrosion as a part of a run, for pd_couple_add: by such steps. */
PD_API pd_process pd_corrode_process(pd_corrode *corrode);

#ifdef PDI_INTERNAL
/* Element and amounts of a corrosion, and its state, for both kinds of steps. */
PDI_FN void pdi_march_common(pd_corrode *corrode, pd_process *process);
#endif

#endif
