/* tilt: what the weights of bonds across a surface make of its area where it faces along no axis.
 *
 * A family has finitely many directions, so a plane of the normal N is measured as f(N) of its area (theory: eq. 10.5,
 * 11.2). Exposed metal finds its normal from the metal and the fluid around it, averaged over the exposed metal in its
 * family, and gives 1/f(N) of what its weights say (eq. 10.6). Along an axis that is 1.
 */
#ifndef PD_TILT_H
#define PD_TILT_H
#include "metal/reach.h"

#ifdef PDI_INTERNAL
/* Beside the marks of reach.h: what is in the reach of exposed metal has turned, or the normal of metal there. */
enum { PDI_TILT_NEAR = 32 };
/* Normals of exposed metal and the factors, as nodes are now. */
PDI_FN void pdi_tilt_update(const pd_ctx *ctx, pd_dissolve *dissolve);
#endif

#endif
