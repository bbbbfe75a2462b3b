/* read_gas: the section [gas] of a scene, and what sides mean for a gas. */
#ifndef PD_READ_GAS_H
#define PD_READ_GAS_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Read the section [gas] (Euler equations), if setup->has_gas, after the sides. Sides that are walls become mirrors.
 * PD_ERR_ARGUMENT, PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_gas_read(pd_ctx *ctx, pd_text *text, pd_setup *setup);
/* Check that no flow, transport or dissolution stands beside a gas: the inviscid gas is not coupled to them.
 * PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_read_gas_check_alone(pd_ctx *ctx, pd_text *text, const pd_setup *setup);
/* Read the boundary condition of a side for a gas into side->kind: slip (as a wall), inlet, outlet, periodic or mirror.
 */
PDI_FN pd_status pdi_read_gas_side(pd_ctx *ctx, pd_text *text, int section, pd_setup_side *side);
#endif

#endif
