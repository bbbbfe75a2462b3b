/* read_chemistry: reads what a run with reacting species needs: electrolyte, minerals, time treatment, migration,
 * and the reactions at metal surfaces and electrodes that release species. */
#ifndef PD_READ_CHEMISTRY_H
#define PD_READ_CHEMISTRY_H
#include "scene/reader.h"

#ifdef PDI_APP_INTERNAL
/* Read the sections of chemistry into the setup, if there are any: species, reactions, minerals, time treatment,
 * migration. Set has_chemistry and declare the temperature T as a constant. Solids that are no minerals are left out,
 * with a note. PD_ERR_ARGUMENT with file:line: no [grid], a gas, time = steady beside metal that dissolves, and values
 * that are refused. PD_ERR_PARSE with file:line. */
PDI_FN pd_status pdi_read_chemistry_read(pdi_reader *reader);
/* Read the dissolution reactions of metals, after all other physics. Without chemistry, or without any key `reaction`,
 * nothing is read. PD_ERR_ARGUMENT: a reaction without chemistry, species beside a medium, several metals whose rate
 * laws do not depend on E or species, control = activation, or a metal that dissolves by such a law without a
 * reaction. */
PDI_FN pd_status pdi_read_chemistry_surface_reactions(pdi_reader *reader);
/* Read the half-reaction of an electrode. shed [species] [-]: moles of each species released (negative: consumed) per
 * mole of electrons that pass from the fluid to the metal. PD_ERR_ARGUMENT: no chemistry, a reaction without e-, or,
 * without migration, time = steady or a reaction of a metal beside it. */
PDI_FN pd_status pdi_read_chemistry_electrode_reaction(pdi_reader *reader, int section, double *shed);
#endif

#endif
