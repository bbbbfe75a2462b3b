/* gas_opening: what the open sides of the box are to a gas: one face a node, and ghosts (theory: eq. 4.24b). */
#ifndef PD_GAS_OPENING_H
#define PD_GAS_OPENING_H
#include "lattice/bond.h"

#ifdef PDI_INTERNAL
/* The bonds of a node through open sides, summed for each side. */
typedef struct pdi_gas_opening {
    double area[2 * PD_DIM][PD_DIM]; /* [1/m] of g */
    double middle[2 * PD_DIM];       /* [-] of g times the way to the middle of the bond */
    int32_t beyond[2 * PD_DIM];      /* the ghost with the state beyond; -1: that of the node */
} pdi_gas_opening;

/* 1: the kind of a node behind an open side. */
static inline int pdi_gas_opening_behind(uint8_t kind) { return kind == PD_OUTLET || kind == PD_INLET; }
/* 1: bond k of node i is open and leads through an open side. */
static inline int pdi_gas_opening_passed(const pd_bonds *bonds, int32_t i, int k)
{
    int32_t row = bonds->row[i];
    return pdi_gas_opening_behind(bonds->paths.grid->kind[i + bonds->paths.shift[k]]) &&
           (row < 0 || pdi_bond_open(bonds, row, k));
}
/* Those of node i. */
PDI_FN void pdi_gas_opening_find(const pd_bonds *bonds, int32_t i, pdi_gas_opening *t);
/* Axes along which a ghost is a mirror image, and the components of the velocity that change their sign there: those
 * of the axes with mirror sides. Behind an outlet the state is even, which lets pass what comes. */
PDI_FN void pdi_gas_opening_signs(const pd_ghosts *g, int32_t k, int *flip, int *odd);
/* Ghosts of outlets become straight lines through the next two nodes, from which gradients beside them are made: with
 * even ghosts those would be too small, and what bonds at an angle make of that comes back. Lines have no such
 * bonds. q [fields][total]: of which PD_DIM from `vector` on are those of a vector. */
PDI_FN void pdi_gas_opening_extend(const pd_bonds *bonds, int fields, int vector, double *q);
#endif

#endif
