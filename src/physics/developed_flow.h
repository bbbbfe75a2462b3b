/* developed_flow: fully developed velocity profiles of inlets with any cross-section: a steady flow solve in a straight
 * periodic duct with the opening as its section, on the lattice of the run (theory: 3.10).
 */
#ifndef PD_DEVELOPED_FLOW_H
#define PD_DEVELOPED_FLOW_H
#include "flow/steady_newton.h"
#include "physics/inlet.h"

#ifdef PDI_INTERNAL
/* Solve for the profiles of inlets without a closed form, with the viscous operator of `flow`; they are allocated as
 * inlet->profile, which pdi_inlet_free frees. Those that are there stay. If there is a new one, updates the ghosts of
 * `flow`. inlet->error_side is the last side tried. PD_ERR_GEOMETRY: an opening without a wall, where no profile
 * develops. PD_ERR_DIVERGED: no profile is found. */
PDI_FN pd_status pdi_developed_flow_compute_profiles(pd_ctx *ctx, pd_inlet *inlet, pd_flow *flow);
#endif

#endif
