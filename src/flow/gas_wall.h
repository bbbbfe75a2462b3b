/* gas_wall: slip walls of a gas: the closed bonds of a node as one wall, or as those of a concave edge or corner
 * (theory: eq. 4.7). */
#ifndef PD_GAS_WALL_H
#define PD_GAS_WALL_H
#include "lattice/bond.h"
#ifdef PDI_INTERNAL
#include "core/vec.h"

/* Returns the weight 2 |g| [1/m] of bond k as a face. n [PD_DIM] [-] gets its unit normal, along g. */
static inline double pdi_gas_wall_get_bond_face(const pd_stencil *s, int k, double *n)
{
    double size = pdi_vec_norm(s->gradient_weight + k * PD_DIM);
    for (int d = 0; d < PD_DIM; d++) n[d] = s->gradient_weight[k * PD_DIM + d] / size;
    return 2.0 * size;
}
/* Slip walls of all rows, up to PD_DIM each. face [rows][PD_DIM][PD_DIM] [1/m]: area vectors into the walls, in sum
 * that of g over closed bonds whose opposite bond is open, 0 for unused ones. gap [rows][PD_DIM] [m]: distances of the
 * walls, 0 for unused ones. After an error of memory face and gap are not set; work is freed in any case. */
PDI_FN pd_status pdi_gas_wall_build(pd_ctx *ctx, const pd_bonds *bonds, int32_t rows, double *face, double *gap);
#endif

#endif
