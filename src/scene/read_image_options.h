/* read_image_options: reads the options of images from [output]: colour ranges and maps, contours, streamlines, arrows,
 * view of the surface, formats. */
#ifndef PD_READ_IMAGE_OPTIONS_H
#define PD_READ_IMAGE_OPTIONS_H
#include "scene/read_monitors.h"

#ifdef PDI_APP_INTERNAL
/* Read the image options of the section [output] into setup->drawing, after setup->images is known. images = none also
 * switches the view of the surface off. Where neither is drawn, the other options have no effect. PD_ERR_PARSE,
 * PD_ERR_ARGUMENT with file:line: also a percentile that is not above 0 and at most 100 %. */
PDI_FN pd_status pdi_read_image_options_read(pd_ctx *ctx, pd_text *text, int section, pd_setup *setup);
#endif

#endif
