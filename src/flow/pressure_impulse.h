/* pressure_impulse: pressure impulse (time integral of the pressure) of implicit flow, and the stabilising pressure
 * flux that is made of it instead of the pressure (theory: eq. 3.43, 3.44). */
#ifndef PD_PRESSURE_IMPULSE_H
#define PD_PRESSURE_IMPULSE_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* pressure_impulse_flux [1/s] of the flow = divergence of the known part of the pressure flux, of `share` times the
 * pressure impulse, at fluid nodes (eq. 3.43). Sets stage_weight = now [s]: weight of the present pressure in the
 * stage that is solved, 0: none is. Fills the ghosts of pressure_impulse (0 at outlets) and updates
 * pressure_impulse_grad (without share). */
PDI_FN void pdi_pressure_impulse_update_flux(const pd_ctx *ctx, pd_flow *flow, double share, double now);
/* Updates the pressure impulse at fluid nodes: I = share I + weight (p - p_out), weight [s]. */
PDI_FN void pdi_pressure_impulse_update(pd_flow *flow, double share, double weight);
#endif

#endif
