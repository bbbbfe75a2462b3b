/* interface: where metal enters the fluid, and with which weights.
 *
 * Surface rate: bonds of metal enter the fluid at the first nodes on their way. What they give goes to all nodes whose
 * bonds the metal cuts, to each what its cut bonds would carry (theory: eq. 10.3). Bonds: they enter at their far end.
 */
#ifndef PD_INTERFACE_H
#define PD_INTERFACE_H
#include "metal/reach.h"

#ifdef PDI_INTERNAL
/* Where bond k of metal node j enters the fluid; entry->count is 0 where it does not. */
PDI_FN void pdi_interface_find(const pd_dissolve *dissolve, int32_t j, int k, pdi_entry *entry);
/* What that bond gives to node i of the entry, per speed of the law [mol/m4]. */
PDI_FN double pdi_interface_weight(const pd_dissolve *dissolve, int32_t j, int32_t i, int k, const pdi_entry *entry);
/* The fluid beside metal, as nodes and contents are now. */
PDI_FN pd_status pdi_interface_land(pd_ctx *ctx, pd_dissolve *dissolve);
/* Speed [m/s] that the law gives at a node, on its line. */
PDI_FN double pdi_interface_line(const pd_dissolve *dissolve, const pdi_beside *beside);
/* R of the film [mol s/m4]; HUGE_VAL: nothing passes it. */
PDI_FN double pdi_interface_resist(const pd_dissolve *dissolve, const pdi_beside *beside);
PDI_FN double pdi_interface_diffusivity(const pd_dissolve *dissolve, int32_t i);
/* Speeds of the metal where it enters, from the lines. */
PDI_FN void pdi_interface_means(pd_dissolve *dissolve);
/* Speed [m/s] of a metal beside node i; 0: there is none. */
PDI_FN double pdi_interface_speed(const pd_dissolve *dissolve, int32_t i, int metal);
/* That of the fastest one; NaN: no metal enters there, or what entered is used up. */
PDI_FN double pdi_interface_fastest(const pd_dissolve *dissolve, int32_t i);
/* The law beside a node. A drive by difference is part of it. */
PDI_FN void pdi_interface_law(const pd_dissolve *dissolve, const pdi_beside *beside, pdi_law *law);
/* Rate [1/s] at which exposed node f loses its supply. */
PDI_FN double pdi_interface_rate(const pd_dissolve *dissolve, int32_t f);
/* What steps are chosen for: the same; with a loss in proportion to a difference that of a node with fluid all around
 * by a constant drive. Such a loss fades, and steps that follow it would grow up to the end. */
PDI_FN double pdi_interface_pace(const pd_dissolve *dissolve, int32_t f);
/* 1: the rates were found with the speeds of now. pdi_interface_rated: they have just been found. */
PDI_FN int pdi_interface_lasts(const pd_dissolve *dissolve);
/* 1: they were, and the fluid beside metal is as it was then. */
PDI_FN int pdi_interface_stays(const pd_dissolve *dissolve);
PDI_FN void pdi_interface_rated(pd_dissolve *dissolve);
/* What `used` and `paid` say of pieces of metal that do not last the step is given once for all (eq. 10.11). */
PDI_FN void pdi_interface_spare(pd_dissolve *dissolve);
#endif

#endif
