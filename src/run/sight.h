/* sight: 3D rendering of the metal surface for pictures. */
#ifndef PD_SIGHT_H
#define PD_SIGHT_H
#include "io/shade.h"
#include "run/model.h"

#ifdef PDI_INTERNAL
#include "io/relief.h"

/* 1: the scene requests pictures of the surface. */
PDI_FN int pdi_sight_wanted(const pd_setup *setup);
/* The field that colours the surface; PD_FIELD_COUNT: none. */
PDI_FN pd_field pdi_sight_field(const pd_setup *setup);
/* Allocate the pixels of the rendering; freed by pdi_shade_free. */
PDI_FN pd_status pdi_sight_build(pd_ctx *ctx, const pd_setup *setup, pd_shade *shade);
/* Mesh and render the metal surface as it is now; call pdi_sample_prepare before. PD_STOPPED. */
PDI_FN pd_status pdi_sight_take(pd_ctx *ctx, const pd_model *model, pd_shade *shade);
#endif

#endif
