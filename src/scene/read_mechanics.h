/* read_mechanics: reads solid mechanics of the metal: section [solid] (material, failure, loads) and the mechanical
 * boundary conditions of sides and shapes. */
#ifndef PD_READ_MECHANICS_H
#define PD_READ_MECHANICS_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read the section [solid], if there is one, and the loads of sides, after shapes, sides and metals. Add monitors of
 * the body and of each mechanical boundary condition. PD_ERR_ARGUMENT with file:line: an axisymmetric box, no solid
 * shape, spacings that differ by more than 1e-9, a periodic side, nothing that loads the metal, or a material that does
 * not support a key. PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_mechanics_read(pdi_reader *reader);
/* Read a shape of kind = grip: append the prescribed displacements [m] of the metal in shape `shape` to the boundary
 * conditions. Called before [solid] is read. PD_ERR_ARGUMENT: no [solid] section, no displacement along any axis, or
 * too many conditions. */
PDI_FN pd_status pdi_read_mechanics_shape_bc(pd_ctx *ctx, pd_text *text, int section, int shape, pd_setup *setup);
/* Add notes on known limits, if there is a [solid]: one for each metal behind the first, which has the E of the first;
 * toughness without a pre-crack (initiation depends on h); volumetric locking, for nu above 0.45 (above 0.48 with a
 * horizon of 1 h), not in 1D, in plane stress, or of the bond-based and ordinary materials. */
PDI_FN void pdi_read_mechanics_add_notes(pdi_reader *reader);
#endif

#endif
