/* read_surface_states: reads the [surface NAME] sections of a scene: state variables of metal surfaces (film coverage,
 * thickness) and their rate laws.
 *
 * Rate laws of metals and factors of electrodes use the names of the states, so these are read first; rates of the
 * states use i and E of electrodes, and are read last. */
#ifndef PD_READ_SURFACE_STATES_H
#define PD_READ_SURFACE_STATES_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read names, units, initial values and bounds of all surface states, after the species. PD_ERR_PARSE, PD_ERR_ARGUMENT
 * with file:line. */
PDI_FN pd_status pdi_read_surface_states_read(pdi_reader *reader);
/* Read the rate laws of all surface states and the electrodes that carry them, after metals and electrodes. Adds a
 * monitor for each. Checks that each state is carried wherever a law or factor uses it. */
PDI_FN pd_status pdi_read_surface_states_rates(pdi_reader *reader);
/* Append the species that the expression under `key` names as [H+] to the symbol table vars[*count], whose names name[]
 * stores, each once. species_index[*species]: their indices in the electrolyte; *species: their number.
 * PD_ERR_ARGUMENT: no solute, or too many. */
PDI_FN pd_status pdi_read_surface_states_species_symbols(pdi_reader *reader, int section, const char *key,
                                                         pd_expr_symbol *vars, char (*name)[PD_SPECIES_NAME + 2],
                                                         int *count, int *species_index, int *species);
/* Append the species that the expression under `key` names as [H+], then all surface states, to the symbol table
 * vars[*count]. name[] stores the names of species; species_index[*species]: their indices in the electrolyte;
 * *species: their number. */
PDI_FN pd_status pdi_read_surface_states_symbols(pdi_reader *reader, int section, const char *key, pd_expr_symbol *vars,
                                                 char (*name)[PD_SPECIES_NAME + 2], int *count, int *species_index,
                                                 int *species);
/* Read the factor of the current density of an electrode (key `current_factor`) [-], an expression in x, y, z, t and
 * the surface states, if it is given. electrode: its index. */
PDI_FN pd_status pdi_read_surface_states_current_factor(pdi_reader *reader, int section, int electrode);
#endif

#endif
