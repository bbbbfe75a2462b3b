/* read_physics: the sections of physics that the program brings along, by the tables of their keys. */
#ifndef PD_READ_PHYSICS_H
#define PD_READ_PHYSICS_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Append all physics that are registered with the context and whose section is present to setup->registered: keys of
 * the section, and the values that sides hold. After species and states of surfaces, before rate laws. PD_ERR_ARGUMENT
 * with file:line: a field name that is taken, too many fields, a constant out of bounds. PD_ERR_PARSE with
 * file:line. */
PDI_FN pd_status pdi_read_physics_read(pdi_reader *s);
/* Give the places of a table of rate symbols, from PD_SETUP_RATE_FIELD on, the names and units of the fields of
 * registered physics in the setup; other symbols stay. unit [PD_PHYSICS_TYPE_FIELDS]: room for the units as long as the
 * table is used. */
PDI_FN void pdi_read_physics_set_symbols(const pd_setup *setup, pd_expr_symbol *symbols, char (*unit)[PD_UNITS_TEXT]);
#endif

#endif
