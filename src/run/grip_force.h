/* grip_force: forces of what holds and loads a body. Where sides meet, what several hold is shared among them. */
#ifndef PD_GRIP_FORCE_H
#define PD_GRIP_FORCE_H
#include "run/grip.h"

#ifdef PDI_INTERNAL
/* Force [N] (per m in 2D, per m2 in 1D) that grip k puts on the body: of components that it holds what they took in the
 * last balance, of others its load at time t [s]. Forces of all grips and of `force` of the body add up to zero in
 * balance. PD_ERR_STATE: as that of pdi_grip_load. */
PDI_FN pd_status pdi_grip_force(pd_ctx *ctx, const pd_grips *grips, int k, double t, double *force);
#endif

#endif
