/* sight: the surface of the metal as pictures of 3D runs show it. */
#ifndef PD_SIGHT_H
#define PD_SIGHT_H
#include "io/shade.h"
#include "run/model.h"

#ifdef PDI_INTERNAL
#include "io/relief.h"

/* 1: the scene asks for it. */
PDI_FN int pdi_sight_wanted(const pd_setup *setup);
/* The field that colours it; PD_FIELD_COUNT: none does. */
PDI_FN pd_field pdi_sight_field(const pd_setup *setup);
/* Room for its pixels; freed by pdi_shade_free. */
PDI_FN pd_status pdi_sight_build(pd_ctx *ctx, const pd_setup *setup, pd_shade *shade);
/* The metal of this instant, with pdi_sample_prepare before. PD_STOPPED. */
PDI_FN pd_status pdi_sight_take(pd_ctx *ctx, const pd_model *model, pd_shade *shade);
#endif

#endif
