/* read_gas: the section [gas] of a scene, and what sides mean for a gas. */
#ifndef PD_READ_GAS_H
#define PD_READ_GAS_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Read the section [gas] (Euler equations) after the sides, if setup->has_gas: gamma, density, pressure, velocity (0 by
 * default), order, CFL number. Sides that are walls become mirrors. PD_ERR_ARGUMENT: in an axisymmetric box, or a value
 * out of bounds. PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_gas_read(pd_ctx *ctx, pd_text *text, pd_setup *setup);
/* Check that no [flow], [transport], [dissolve] or [corrode] stands beside a gas: the inviscid gas is not coupled to
 * them. Without a gas do nothing. PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_read_gas_check_alone(pd_ctx *ctx, pd_text *text, const pd_setup *setup);
/* Read the boundary condition of a side for a gas (key `flow`) into side->kind: slip, the default, which is stored as a
 * wall, inlet, outlet, periodic or mirror. PD_ERR_PARSE: another word. */
PDI_FN pd_status pdi_read_gas_side(pd_ctx *ctx, pd_text *text, int section, pd_setup_side *side);
#endif

#endif
