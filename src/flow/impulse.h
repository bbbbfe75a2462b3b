/* impulse: the pressure flux of flow in time, made of the pressure that has acted within its weight in time (theory:
 * eq. 4.15c, 4.15d).
 */
#ifndef PD_IMPULSE_H
#define PD_IMPULSE_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* The pressure flux becomes that of `share` times flow->impulse, and of the pressure of flow times `now` [s], the
 * weight that a stage has for it; 0: no stage is being solved. Fills the ghosts of flow->impulse. */
PDI_FN void pdi_impulse_set(const pd_ctx *ctx, pd_flow *flow, double share, double now);
/* The impulse of fluid nodes becomes share times itself and weight [s] times the pressure above that of outlets. */
PDI_FN void pdi_impulse_move(pd_flow *flow, double share, double weight);
#endif

#endif
