/* inflow: advecting velocity of inlet ghosts, so that the flux that bonds let in is that of the inlet velocity,
 * whatever the fluid in front of it does (theory: eq. 3.11). */
#ifndef PD_INFLOW_H
#define PD_INFLOW_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* sided, ratio [inlet ghosts]: sided = 1 where the bonds of the source node through the side do not balance along the
 * side (axisymmetric: always); ratio = mean normal speed of ghost and source over that on the side, with which bonds
 * carry the flux of the face (eq. 3.11), or -1: the tensor of the row is used. developed: bits of the sides with
 * developed flow. They get -1, as do sources that are not fluid, and grids whose sides mix kinds. */
PDI_FN void pdi_inflow_compute_ratios(const pd_bonds *bonds, int developed, uint8_t *sided, double *ratio);
/* Sum of the sizes of the gradient weights along `axis` of the open bonds from node i through the inlet at the end `up`
 * (0 or 1) of `axis`, times its volume [m^(d-1)]: flux per unit speed. 0: no fluid node, or no such bonds. */
PDI_FN double pdi_inflow_compute_flux_weight(const pd_bonds *bonds, int32_t i, int axis, int up);
/* 1: axisymmetric with m > 1, no side of mixed kinds: inlets at the ends of the radius carry the flux of their faces in
 * sum over each end. */
PDI_FN int pdi_inflow_has_radial_balance(const pd_bonds *bonds);
/* Sets v [PD_DIM][total] [m/s] of inlet ghosts to twice the velocity on the side: adds that of the source. Ghosts whose
 * source is not fluid stay at the velocity of the side. */
PDI_FN void pdi_inflow_set_doubled_velocity(const pd_bonds *bonds, double *v);
/* Sets the advecting velocity of inlet ghosts (eq. 3.11) from the doubled velocity on the side
 * (pdi_inflow_set_doubled_velocity) and v of nodes, which is an advecting velocity already. Normal component with ratio
 * >= 0: ratio times the doubled one; tangential one with `sided`: as in front; else the tensor of the row times the
 * doubled one, or, with even 1 beside smooth surfaces, that itself; less the one in front. Ghosts whose source is not
 * fluid stay, but for the radial balance. */
PDI_FN void pdi_inflow_set_advecting_velocity(const pd_bonds *bonds, const uint8_t *sided, const double *ratio,
                                              int even, double *v);
#endif

#endif
