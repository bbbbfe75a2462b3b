/* read_metal: reads the sections [dissolve] and [corrode] of a scene: how metal goes. */
#ifndef PD_READ_METAL_H
#define PD_READ_METAL_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* Before anything of the other sections is read: what [corrode] brings with it. */
PDI_FN pd_status pdi_read_metal_first(pdi_reader *s);
/* [dissolve], the surface rate. */
PDI_FN pd_status pdi_read_metal_dissolve(pdi_reader *s);
/* [corrode], bond-based corrosion. */
PDI_FN pd_status pdi_read_metal_corrode(pdi_reader *s);
#endif

#endif
