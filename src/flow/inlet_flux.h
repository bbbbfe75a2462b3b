/* inlet_flux: what bonds to inlets carry into the box against what the inlet velocities give, by which solvers check a
 * flow (theory: eq. 3.11).
 */
#ifndef PD_INLET_FLUX_H
#define PD_INLET_FLUX_H
#include "flow/flow.h"

#ifdef PDI_INTERNAL
/* Returns the volume per time [m3/s; planar 2D: m2/s] that the bonds to inlets carry into the box. *net_inlet: what the
 * inlet velocities give on the faces of the cells beside them, into the box positive (developed flow: what bonds give);
 * *gross_inlet: the sum of the sizes of these. Updates the derived fields first. */
PDI_FN double pdi_inlet_flux_integrate(pd_ctx *ctx, pd_flow *flow, double *net_inlet, double *gross_inlet);
#endif

#endif
