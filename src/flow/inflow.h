/* inflow: advecting velocities of inlet ghosts: with them the flux that enters is what the inlet holds, whatever the
 * fluid in front of it does (theory: eq. 4.5d).
 */
#ifndef PD_INFLOW_H
#define PD_INFLOW_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* sided [inlet ghosts]: 1 where the bonds through the side of the node that a ghost mirrors do not balance along it.
 * ratio [inlet ghosts]: mean speed of both over that on the side, with which bonds carry what passes the side; below 0:
 * that of the tensor of the row, on the sides whose bits are set in `developed`. */
PDI_FN void pdi_inflow_find(const pd_bonds *bonds, int developed, uint8_t *sided, double *ratio);
/* Sum of the weights of open bonds from node i through the inlet at the end `up` of `axis`, times its volume
 * [m^(d-1)]. */
PDI_FN double pdi_inflow_weight(const pd_bonds *bonds, int32_t i, int axis, int up);
/* 1: inlets at the ends of the radius carry what passes their faces, in sum over each end. */
PDI_FN int pdi_inflow_rings(const pd_bonds *bonds);
/* v [PD_DIM][total] [m/s] of ghosts becomes twice that on the side. */
PDI_FN void pdi_inflow_twice(const pd_bonds *bonds, double *v);
/* v of nodes makes fluxes by now: that of the ghosts, from twice that on the side. even: rows on smooth surfaces keep
 * v = u. */
PDI_FN void pdi_inflow_enter(const pd_bonds *bonds, const uint8_t *sided, const double *ratio, int even, double *v);
#endif

#endif
