/* surface_view: 3D rendering of the metal surface for pictures. */
#ifndef PD_SURFACE_VIEW_H
#define PD_SURFACE_VIEW_H
#include "io/renderer.h"
#include "physics/model.h"

#ifdef PDI_APP_INTERNAL
#include "io/surface_plot.h"

/* 1: the scene requests pictures of the surface; 0 always in 1D and 2D. */
PDI_FN int pdi_surface_view_is_requested(const pd_setup *setup);
/* The field that colours the surface; PD_FIELD_COUNT: none. */
PDI_FN pd_field pdi_surface_view_get_colour_field(const pd_setup *setup);
/* Allocate the pixels of the rendering for the box and view direction of the setup, of its image width or the default;
 * freed by pdi_renderer_free. */
PDI_FN pd_status pdi_surface_view_build(pd_ctx *ctx, const pd_setup *setup, pd_rendering *shade);
/* Mesh the metal surface as it is now, and render it into the pixels of shade, coloured if there is a colour field;
 * call pd_sample_prepare before. The mesh is freed. PD_CANCELLED. */
PDI_FN pd_status pdi_surface_view_draw(pd_ctx *ctx, const pd_model *model, pd_rendering *shade);
#endif

#endif
