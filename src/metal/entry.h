/* entry: where bonds of metal enter the fluid.
 *
 * A bond that starts in metal passes cells on its way. The first fluid cells on it take what the metal gives: the far
 * end may lie a horizon away from the surface. Ghosts behind a side of the box stand for their images, so that metal
 * that meets a side is the same there as elsewhere.
 */
#ifndef PD_ENTRY_H
#define PD_ENTRY_H
#include "lattice/bond_path.h"

#ifdef PDI_INTERNAL
/* Most fluid nodes among which a bond enters the fluid. */
#define PDI_ENTRY_NODES 8

typedef struct pdi_entry {
    int count;                     /* 0: the bond does not end in fluid, or a wall stands in between */
    int32_t node[PDI_ENTRY_NODES]; /* several: the bond passes an edge or corner between them */
    int cell[PDI_ENTRY_NODES];     /* of the stencil: where they lie as seen from the start of the bond */
    int flip[PDI_ENTRY_NODES];     /* bit d set when the bond sees a mirror image of the node along axis d */
    int32_t last[PDI_ENTRY_NODES]; /* [lasts] the last metal node before them; several at an edge or corner */
    int lasts;
    int32_t far;                   /* node at the far end */
    int open;                      /* 1: nothing but fluid from there to the far end */
} pdi_entry;

/* Node at the far end of bond k of node i, or that which a ghost there stands for. */
static inline int32_t pdi_entry_far(const pd_bond_paths *paths, int32_t i, int k)
{
    int32_t at = i + paths->shift[k];
    uint8_t kind = paths->grid->kind[at];
    return kind == PD_FLUID || kind == PD_SOLID ? at : pd_grid_find_source(paths->grid, at, NULL);
}
/* 1 when metal can pass bond k of node i: no wall in between, mirror images included. Both ends agree, because paths
 * are the same both ways. */
PDI_FN int pdi_entry_free(const pd_bond_paths *paths, int32_t i, int k);
/* Where bond k of metal node j enters the fluid. */
PDI_FN void pdi_entry_find(const pd_bond_paths *paths, int32_t j, int k, pdi_entry *entry);
/* A vector at node e of an entry as the bond sees it, and the other way round. */
PDI_FN void pdi_entry_mirror(const pdi_entry *entry, int e, const double *v, double *seen);
/* (x_far - x_node).axis [m] of node e of an entry, for bond k. */
PDI_FN double pdi_entry_beyond(const pd_bond_paths *paths, int k, const pdi_entry *entry, int e, const double *axis);

#endif

#endif
