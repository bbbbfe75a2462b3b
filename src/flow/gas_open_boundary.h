/* gas_open_boundary: open sides of the box (inlets and outlets) for a gas: one face a node, and ghost states (theory:
 * eq. 4.8). */
#ifndef PD_GAS_OPEN_BOUNDARY_H
#define PD_GAS_OPEN_BOUNDARY_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* Faces of a node on open sides (inlets, outlets): its bonds through them, summed for each side. */
typedef struct pdi_gas_open_boundary_faces {
    double area[2 * PD_DIM][PD_DIM]; /* [1/m] of g */
    double half_length[2 * PD_DIM];  /* [-] of g times the way to the middle of the bond */
    int32_t outer_ghost[2 * PD_DIM]; /* the ghost with the state beyond; -1: that of the node */
} pdi_gas_open_boundary_faces;

/* 1: the kind of a ghost behind an open side. */
static inline int pdi_gas_open_boundary_is_open_kind(uint8_t kind) { return kind == PD_OUTLET || kind == PD_INLET; }
/* 1: bond k of node i is open and leads through an open side. */
static inline int pdi_gas_open_boundary_is_crossed_by_bond(const pd_bonds *bonds, int32_t i, int k)
{
    int32_t row = bonds->row_of_node[i];
    return pdi_gas_open_boundary_is_open_kind(bonds->paths.grid->kind[i + bonds->paths.shift[k]]) &&
           (row < 0 || pdi_bond_is_open(bonds, row, k));
}
/* Sets *t: sums the open bonds of node i through open sides to one face for each side, its area out of the box (eq.
 * 4.8). Sides without such bonds have area 0. Where a side is inlet and outlet in part, the last one of the bonds
 * decides which state is beyond. */
PDI_FN void pdi_gas_open_boundary_compute_faces(const pd_bonds *bonds, int32_t i, pdi_gas_open_boundary_faces *t);
/* Signs of ghost k, as bits of axes: flip, along which it is a mirror image; odd, velocity components that change sign
 * there. Behind an outlet the state is even, so that waves leave. */
PDI_FN void pdi_gas_open_boundary_get_ghost_signs(const pd_ghosts *g, int32_t k, int *flip, int *odd);
/* Extrapolates q [fields][total] linearly from the last two nodes before the side to the ghosts of outlets, for
 * gradients beside them: even ghosts would make these too small and reflect waves at an angle. Nothing in 1D. vector:
 * first of PD_DIM vector components, which change sign at mirror sides. Ghosts stay where these two nodes are not both
 * fluid. */
PDI_FN void pdi_gas_open_boundary_extrapolate_ghosts(const pd_bonds *bonds, int fields, int vector, double *q);
#endif

#endif
