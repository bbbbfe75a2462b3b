/* read_drawing: reads from a scene how fields are drawn: keys of [output]. */
#ifndef PD_READ_DRAWING_H
#define PD_READ_DRAWING_H
#include "scene/read_monitors.h"

#ifdef PDI_INTERNAL
/* Keys of the section into the setup, whose `images` are known. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_drawing_read(pd_ctx *ctx, pd_text *text, int section, pd_setup *setup);
#endif

#endif
