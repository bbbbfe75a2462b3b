/* flat: the `key = value` parameter file of the Mg-pin project (SI numbers without units) as a setup.
 *
 * 2D: a plane channel of half-width R_tube along x with a slab of half-thickness R_wire from x = 0 to L_wire.
 * 3D: a tube along x with a wire. R_wire = 0: no pin. The inflow is a parabola of mean speed Q_flow / (pi R_tube^2).
 * k_corr is the rate of one exposed layer of the file's own dx: speed = k_corr dx, whatever dx a run overrides.
 */
#ifndef PD_FLAT_H
#define PD_FLAT_H
#include "setup.h"
#include "text.h"

#ifdef PDI_INTERNAL
/* Fill the setup from a flat text; overrides are applied here, because k_corr refers to dx as it stands in the file. A
 * key without effect on this solver gets a note. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_flat_read(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count, pd_setup *setup);
#endif

#endif
