/* developed_flow: fully developed velocity profiles of inlets with any cross-section: a steady flow solve in a straight
 * periodic duct with the opening as its section, on the lattice of the run (theory: 4.3b).
 */
#ifndef PD_DEVELOPED_FLOW_H
#define PD_DEVELOPED_FLOW_H
#include "flow/steady_newton.h"
#include "physics/inlet.h"

#ifdef PDI_INTERNAL
/* Solve for the profiles (inlet->profile) of inlets without a closed form, with the viscous operator of `flow`, and
 * update the ghosts of `flow`. PD_ERR_GEOMETRY: an opening without a wall, where no profile develops. */
PDI_FN pd_status pdi_developed_flow_compute_profiles(pd_ctx *ctx, pd_inlet *inlet, pd_flow *flow);
#endif

#endif
