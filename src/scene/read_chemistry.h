/* read_chemistry: what a scene says of species that a run carries: the electrolyte, how it moves in time, and the
 * reaction by which metal enters it. */
#ifndef PD_READ_CHEMISTRY_H
#define PD_READ_CHEMISTRY_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* The sections of chemistry into the setup, solids left out. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_chemistry_read(pdi_reader *reader);
/* What needs the rest of the setup: the reaction at the surface of metal, and what runs carry no species with. */
PDI_FN pd_status pdi_read_chemistry_metal(pdi_reader *reader);
/* The half-reaction of an electrode: shed [species] [-] of each with one electron that leaves the fluid for the
 * metal. */
PDI_FN pd_status pdi_read_chemistry_electrode(pdi_reader *reader, int section, double *shed);
#endif

#endif
