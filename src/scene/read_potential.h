/* read_potential: reads the sections [potential] and [electrode NAME] of a scene and the potentials of sides: current
 * distribution, polarisation curves, galvanic circuits. */
#ifndef PD_READ_POTENTIAL_H
#define PD_READ_POTENTIAL_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* 1: the scene has a section [potential] or [electrode NAME], also without keys. */
PDI_FN int pdi_read_potential_has_sections(pdi_reader *reader);
/* Read all of it, if setup->has_potential, after shapes, sides, species and metals. Add a monitor for each electrode.
 * PD_ERR_ARGUMENT with file:line: a gas, no electrode, a constant named E or i, two prescribed values in one circuit,
 * and values that are refused. PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_potential_read(pdi_reader *reader);
#endif

#endif
