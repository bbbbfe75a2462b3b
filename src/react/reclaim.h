/* reclaim: what species have got of a metal beyond what was there goes back from where they are (theory: 9.7).
 *
 * A law gives what its speeds say, and the metal says afterwards what it had. Where it was used up within a step the
 * rest cannot come from the node beside it for long: its species have moved on. They give it back all over the fluid,
 * in the share of what they hold.
 */
#ifndef PD_RECLAIM_H
#define PD_RECLAIM_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* Takes back `amount` [mol/m3 of cells] of metal with shed [solutes] each, or as much as there is. Returns that. The
 * next step begins without it. */
PDI_FN double pdi_reclaim_take(pd_reactive *reactive, const double *shed, double amount);
/* due [total] [mol/m3]: what of owed [total], metal with shed [solutes] each that fluid nodes have to get in dt [s],
 * they get. Where it is negative a node gives back no more than a share of what it has dissolved, and what metal gives
 * it in that time at the present speeds, with the reactions that take its electrons: minerals may hold the rest, which
 * stays for later. */
PDI_FN void pdi_reclaim_due(const pd_reactive *reactive, const double *shed, double dt, const double *owed,
                            double *due);
#endif

#endif
