/* read_potential: what a scene says of the electric potential: the sections [potential] and [electrode NAME], and the
 * potentials of sides. */
#ifndef PD_READ_POTENTIAL_H
#define PD_READ_POTENTIAL_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* 1: there is one of these sections. */
PDI_FN int pdi_read_potential_given(pdi_reader *reader);
/* All of it, behind shapes, sides and species. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_potential_read(pdi_reader *reader);
#endif

#endif
