/* balance: what the rows of electrolyte and circuits lack, and the search along a step.
 *
 * The energy 1/2 sum kappa a (phi_i - phi_j)^2 + sum area int i du - sum I E is convex. The balances are its
 * derivatives, negated, over the volume of a cell; rows of nodes count the circumference on rings (theory: eq. 12.4).
 */
#ifndef PD_BALANCE_H
#define PD_BALANCE_H
#include "potential/potential.h"

#ifdef PDI_INTERNAL
/* What the balances lack, the size of the currents in them, and of their rounding (Euclidean norms [A/m3]). */
typedef struct pdi_balance_size {
    double lack, currents, rounding;
} pdi_balance_size;

/* y [total], times circumferences: what x sends through the bonds. held: into held walls, too. */
PDI_FN void pdi_balance_bonds(const pd_ctx *ctx, pd_potential *potential, const double *x, int held, double *y);
/* Currents of the contacts, and what all rows lack: into potential->rest. */
PDI_FN pdi_balance_size pdi_balance_rest(const pd_ctx *ctx, pd_potential *potential);
/* Currents that a change of E - phi by its rounding, or by the tolerance, would turn round are none, and so are those
 * that enter less than the balances of all lack, as pdi_balance_rest gives it. */
PDI_FN void pdi_balance_still(pd_potential *potential, double lack);
/* Share of potential->step to take. */
PDI_FN double pdi_balance_share(const pd_ctx *ctx, pd_potential *potential);
/* Currents of circuits and sides, from those of the contacts. */
PDI_FN void pdi_balance_totals(pd_potential *potential, pd_potential_result *result);
#endif

#endif
