/* read_surface: what a scene says of states that surfaces of metal carry: the sections [surface NAME].
 *
 * Their names are known to the laws of metal and to factors of electrodes, so they are read first; their rates name
 * what electrodes bring, and are read last.
 */
#ifndef PD_READ_SURFACE_H
#define PD_READ_SURFACE_H
#include "scene/reader.h"

#ifdef PDI_INTERNAL
/* Names, units, values of the start and bounds; behind species. PD_ERR_PARSE, PD_ERR_ARGUMENT with file:line. */
PDI_FN pd_status pdi_read_surface_states(pdi_reader *reader);
/* Rates and what carries the states; behind metal and electrodes. */
PDI_FN pd_status pdi_read_surface_rates(pdi_reader *reader);
/* Append the species that the text of a key names as [H+], which name[] keeps. of[*species]: species by their place in
 * the electrolyte. */
PDI_FN pd_status pdi_read_surface_species(pdi_reader *reader, int section, const char *key, pd_expr_symbol *vars,
                                          char (*name)[PD_SPECIES_NAME + 2], int *count, int *of, int *species);
/* The same, and all states behind them. */
PDI_FN pd_status pdi_read_surface_variables(pdi_reader *reader, int section, const char *key, pd_expr_symbol *vars,
                                            char (*name)[PD_SPECIES_NAME + 2], int *count, int *of, int *species);
/* The factor of an electrode, its number. */
PDI_FN pd_status pdi_read_surface_share(pdi_reader *reader, int section, int electrode);
#endif

#endif
