/* bare: the share of metal that minerals on it leave bare (theory: 8.6). */
#ifndef PD_BARE_H
#define PD_BARE_H
#include "react/reactive.h"

#ifdef PDI_INTERNAL
/* share [total]: of metal under a film d [m] thick exp(-d/cover) is bare, at the surface and `layers` cells below it.
 * -1: what is not metal, or lies deeper. */
PDI_FN void pdi_bare_shares(const pd_reactive *reactive, double cover, int layers, double *share);
#endif

#endif
