/* read_shapes: reads the [shape NAME] sections of a scene into the geometry tree of the setup: primitives, voxel masks,
 * triangle surfaces, set operations, with kind, material and grains. */
#ifndef PD_READ_SHAPES_H
#define PD_READ_SHAPES_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Read all [shape ...] sections: geometry, solids, walls, materials and grains. folder: relative paths of masks and
 * surfaces start there. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line: also a shape of kind = part that no other shape
 * uses. A scene without shapes is admitted. */
PDI_FN pd_status pdi_read_shapes_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
#endif

#endif
