/* read_cuts: the [cut NAME] sections of a scene: cracks that metal under load has from the start. */
#ifndef PD_READ_CUTS_H
#define PD_READ_CUTS_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* After [solid]. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_cuts_read(pdi_reader *s);
#endif

#endif
