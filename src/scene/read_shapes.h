/* read_shapes: the [shape NAME] sections of a scene: primitives, voxel masks, set operations, materials and grains. */
#ifndef PD_READ_SHAPES_H
#define PD_READ_SHAPES_H
#include "scene/text.h"
#include "scene/setup.h"

#ifdef PDI_INTERNAL
/* Read all [shape ...] sections: geometry, solid, wall, material and grains of the setup. folder: where the paths of
 * masks start. PD_ERR_PARSE, PD_ERR_ARGUMENT, PD_ERR_FILE with file:line. */
PDI_FN pd_status pdi_read_shapes_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
#endif

#endif
