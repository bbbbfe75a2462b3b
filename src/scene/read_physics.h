/* read_physics: the sections of physics that the program brings along, by the tables of their keys. */
#ifndef PD_READ_PHYSICS_H
#define PD_READ_PHYSICS_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read the sections of all physics that are registered with the context, and the values that sides hold. After species
 * and states of surfaces, before rate laws. PD_ERR_ARGUMENT, PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_physics_read(pdi_reader *s);
/* Give the places of a table of rate symbols the names and units of the fields; unit [PD_PHYSICS_TYPE_FIELDS]: room for
 * the units as long as the table is used. */
PDI_FN void pdi_read_physics_set_symbols(const pd_setup *setup, pd_expr_symbol *symbols, char (*unit)[PD_UNITS_TEXT]);
#endif

#endif
