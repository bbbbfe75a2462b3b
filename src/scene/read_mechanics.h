/* read_mechanics: reads solid mechanics of the metal: section [solid] (material, failure, loads) and the mechanical
 * boundary conditions of sides and shapes. */
#ifndef PD_READ_MECHANICS_H
#define PD_READ_MECHANICS_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read the section [solid], if there is one, and the loads of sides, after shapes, sides and metals. Adds monitors of
 * the body and of each mechanical boundary condition. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_mechanics_read(pdi_reader *reader);
/* Read a shape of kind = grip: prescribed displacements [m] of the metal in shape `shape`, at least along one axis.
 * Called before [solid] is read. */
PDI_FN pd_status pdi_read_mechanics_shape_bc(pd_ctx *ctx, pd_text *text, int section, int shape, pd_setup *setup);
/* Add notes on known limits: several metals with one E, toughness without a pre-crack (initiation depends on h),
 * volumetric locking near nu = 1/2. */
PDI_FN void pdi_read_mechanics_add_notes(pdi_reader *reader);
#endif

#endif
