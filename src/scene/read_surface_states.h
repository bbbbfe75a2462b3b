/* read_surface_states: reads the [surface NAME] sections of a scene: state variables of metal surfaces (film coverage,
 * thickness) and their rate laws.
 *
 * Rate laws of metals and factors of electrodes use the names of the states, so these are read first; rates of the
 * states use i and E of electrodes, and are read last. */
#ifndef PD_READ_SURFACE_STATES_H
#define PD_READ_SURFACE_STATES_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read names, units, initial values and bounds of all surface states, after the species. PD_ERR_ARGUMENT with
 * file:line: a state without species, without electrodes and dissolution, or in steady chemistry, a name that is taken,
 * too many states. PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_surface_states_read(pdi_reader *reader);
/* Read the rate laws of all surface states and the electrodes that carry them, after metals and electrodes. Add a
 * monitor for each. PD_ERR_ARGUMENT: a rate of another dimension, or a law or factor that uses a state where an
 * electrode does not carry it. */
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
 * the surface states, if it is given, and set has_current_factor. electrode: its index. PD_ERR_ARGUMENT: there are no
 * states, the curve is primary, or the factor names species. */
PDI_FN pd_status pdi_read_surface_states_current_factor(pdi_reader *reader, int section, int electrode);
#endif

#endif
