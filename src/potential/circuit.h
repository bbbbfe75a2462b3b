/* circuit: what hangs together electrically: pockets of electrolyte, circuits of metal, given potentials.
 *
 * A pocket is electrolyte that bonds join. Circuits join the pockets that they touch. Where none of what hangs together
 * has a given potential, currents have to add up to zero, and potentials are known up to a constant.
 */
#ifndef PD_CIRCUIT_H
#define PD_CIRCUIT_H
#include "potential/potential.h"

#ifdef PDI_INTERNAL
/* [byte] of a name below, with its end. */
#define PDI_CIRCUIT_NAME 160
/* An electrode, or those of a circuit, in words: "electrode mg and electrode steel". Into name[PDI_CIRCUIT_NAME]. */
PDI_FN const char *pdi_circuit_electrode(const pd_potential *potential, int electrode, char *name);
PDI_FN const char *pdi_circuit_name(const pd_potential *potential, int circuit, char *name);
/* Side of the box behind which an inlet ghost lies. */
PDI_FN int pdi_circuit_side(const pd_grid *grid, int32_t ghost);
/* Pockets and parts, and which circuits have an unknown E; contacts are known. PD_ERR_STATE: the curves around a pocket
 * carry current one way only; with `idle` their contacts are left out. */
PDI_FN pd_status pdi_circuit_find(pd_ctx *ctx, pd_potential *potential);
/* Given currents have a solution. PD_ERR_STATE: they do not add up to zero, or curves cannot carry them. */
PDI_FN pd_status pdi_circuit_check(pd_ctx *ctx, const pd_potential *potential);
/* The level of each pocket takes the mean of its phi, where held sides do not keep it at the origin. */
PDI_FN void pdi_circuit_raise(pd_potential *potential);
/* What nothing holds gets a mean of phi of zero; electrolyte that neither metal nor held sides touch has none. */
PDI_FN void pdi_circuit_level(pd_potential *potential);
#endif

#endif
