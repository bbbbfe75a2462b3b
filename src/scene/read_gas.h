/* read_gas: the section [gas] of a scene, and what sides mean for a gas. */
#ifndef PD_READ_GAS_H
#define PD_READ_GAS_H
#include "scene/setup.h"

#ifdef PDI_INTERNAL
/* Read [gas] where setup->has_gas says that there is one, after the sides. PD_ERR_ARGUMENT, PD_ERR_PARSE: with its
 * line. */
PDI_FN pd_status pdi_read_gas_read(pd_ctx *ctx, pd_text *text, pd_setup *setup);
/* A gas moves alone, since nothing knows how to be carried by it: refuse what is beside it. */
PDI_FN pd_status pdi_read_gas_alone(pd_ctx *ctx, pd_text *text, const pd_setup *setup);
/* The section `side` of a scene with a gas: what lies behind it. */
PDI_FN pd_status pdi_read_gas_side(pd_ctx *ctx, pd_text *text, int section, pd_setup_side *side);
#endif

#endif
