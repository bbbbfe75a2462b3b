/* pressure_impulse: pressure impulse (time integral of the pressure) of implicit flow, and the stabilising pressure
 * flux that is made of it instead of the pressure (theory: eq. 4.15c, 4.15d). */
#ifndef PD_PRESSURE_IMPULSE_H
#define PD_PRESSURE_IMPULSE_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Computes the known part of the pressure flux from `share` times the pressure impulse; `now` [s]: weight of the
 * present pressure in the stage that is solved, 0: none is (eq. 4.15c). Fills the ghosts of flow->impulse. */
PDI_FN void pdi_pressure_impulse_update_flux(const pd_ctx *ctx, pd_flow *flow, double share, double now);
/* Updates the pressure impulse at fluid nodes: I = share I + weight (p - p_out), weight [s]. */
PDI_FN void pdi_pressure_impulse_update(pd_flow *flow, double share, double weight);
#endif

#endif
