/* developed: the developed flow in a straight duct with the opening of an inlet as its section, on the lattice of the
 * run (theory: 4.3b).
 */
#ifndef PD_DEVELOPED_H
#define PD_DEVELOPED_H
#include "flow/steady.h"
#include "run/inlet.h"

#ifdef PDI_INTERNAL
/* Find the profiles of inlets that have no closed form, with the operator of `flow`, and fill its ghosts anew.
 * PD_ERR_GEOMETRY: an opening without a wall, where nothing develops. */
PDI_FN pd_status pdi_developed_find(pd_ctx *ctx, pd_inlet *inlet, pd_flow *flow);
#endif

#endif
