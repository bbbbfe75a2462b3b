/* read_precracks: reads the [crack NAME] sections of a scene: pre-cracks of the metal, with the domains of their
 * J-integral. */
#ifndef PD_READ_PRECRACKS_H
#define PD_READ_PRECRACKS_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read all [crack NAME] sections, after [solid]; add a monitor for each crack that is recorded: all in 2D, those with a
 * direction in 3D. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_precracks_read(pdi_reader *reader);
#endif

#endif
