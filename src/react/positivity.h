/* positivity: whether a step of species takes no more of them than there is, and keeps their bounds (theory: 8.3). */
#ifndef PD_POSITIVITY_H
#define PD_POSITIVITY_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* [mol/m3] that is nothing. */
#define PDI_POSITIVITY_NONE 1e-150
/* Share of the largest value by which a field may leave its bounds. */
#define PDI_POSITIVITY_SLACK 1e-9
/* 1: where a component is spent next to nothing is owed after a stage [s]. */
PDI_FN int pdi_positivity_holds(const pd_reactive *reactive, double stage);
/* 1: sources and metal took more of a component in a step [s] than there is of it. What transport is off by, the next
 * step makes good: only what they took is owed for ever. r->short_of and short_at say where. */
PDI_FN int pdi_positivity_exceeded(pd_reactive *reactive, double dt);
/* 1: solutes that neither react nor migrate keep the bounds of the start, of inlets and of held walls, where sources
 * and metal let them. */
PDI_FN int pdi_positivity_bounded(const pd_reactive *reactive);
/* The node beside an electrode with the fewest ions, and how many [mol/m3] it has. */
PDI_FN int32_t pdi_positivity_fewest(const pd_etch *metal, double *ions);
/* 1: a source takes up what a node has within less than `soonest` [s]: its solute and node. */
PDI_FN int pdi_positivity_drained(const pd_reactive *reactive, double soonest, int *solute, int32_t *node);
#endif

#endif
