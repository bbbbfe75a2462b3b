/* distribution: solves for the potential: the current distribution of an electrolyte and its metals.
 */
#ifndef PD_DISTRIBUTION_H
#define PD_DISTRIBUTION_H
#include "potential/potential.h"

#define pd_potential_build PD_NAME(pd_potential_build)
#define pd_potential_update PD_NAME(pd_potential_update)
#define pd_potential_solve PD_NAME(pd_potential_solve)
#define pd_potential_free PD_NAME(pd_potential_free)

/* Grid and bonds are borrowed. The guess is 0 everywhere, and given potentials. PD_ERR_ARGUMENT: a number is out of
 * range, an electrode or circuit that does not exist, a side that cannot hold a potential. PD_ERR_STATE: the curves
 * around a pocket of electrolyte carry current one way only. */
PD_API pd_status pd_potential_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds,
                                    const pd_potential_desc *desc, pd_potential *potential);
/* After pd_bonds_update, and after another conductivity in desc.field or desc.conductivity. phi and E stay. What has
 * failed may only be freed. Errors are those of the build. */
PD_API pd_status pd_potential_update(pd_ctx *ctx, pd_potential *potential);
/* Circuits and held potentials of desc may have changed since the last one in value, not in kind.
 * PD_ERR_STATE: there is no solution: given currents do not add up to zero, or are beyond what curves can carry.
 * PD_NOT_CONVERGED: balances lack more than the tolerance; what is found is there. */
PD_API pd_status pd_potential_solve(pd_ctx *ctx, pd_potential *potential, pd_potential_result *result);
PD_API void pd_potential_free(pd_ctx *ctx, pd_potential *potential);

#ifdef PDI_INTERNAL
/* Metal has lost content, and no node has turned: contacts anew. phi and E stay. */
PDI_FN pd_status pdi_distribution_contacts(pd_ctx *ctx, pd_potential *potential);
/* Arrays of all nodes, and of contacts. */
PDI_FN void pdi_distribution_list(pdi_array_visitor *owner, void *object);
PDI_FN void pdi_distribution_contact_list(pdi_array_visitor *owner, void *object);
/* Without arrays: [byte] that a solve borrows. */
PDI_FN pd_status pdi_distribution_plan(pd_ctx *ctx, pd_potential *potential, size_t *room);
#endif

#endif
