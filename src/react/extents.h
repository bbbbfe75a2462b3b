/* extents: how far kinetic reactions go at a node in a step, by the balance of that node (theory: 8.9). */
#ifndef PD_EXTENTS_H
#define PD_EXTENTS_H
#include "react/reactive.h"

#ifdef PDI_INTERNAL
/* What belongs to the totals `sum` of node i with what minerals are in `base`: c, and amounts n of minerals.
 * PD_NOT_CONVERGED: there is no equilibrium. */
PDI_FN pd_status pdi_extents_equilibrium(const pd_reactive *reactive, int32_t i, const double *sum, double *c,
                                         double *n);
/* Totals of node i of `base` moved by a share of the correction: what reactions do by it they do at the speeds of what
 * comes, not by the derivatives of what was there. Those are far off where a species is used up. */
PDI_FN void pdi_extents_react(const pd_reactive *reactive, int32_t i, double share, double *sum);
/* [mol/m3/s] of component k that kinetic reactions make and take at node i, and that its minerals hold, over the step:
 * differences have the rounding of that. */
PDI_FN double pdi_extents_turnover(const pd_reactive *reactive, int k, int32_t i);
/* What the difference `off` of minerals changes at node i by itself: kinetic reactions work on what it leaves dissolved
 * while the stage lasts, so that next to nothing is left beside a fast one. x [components]: totals by that; left: of
 * concentrations; lack [components] [mol/m3/s]: what of it is not in balance. */
PDI_FN void pdi_extents_relax(const pd_reactive *reactive, int32_t i, const double *c, const double *off, double *x,
                              double *left, double *lack);
#endif

#endif
