/* open_boundary: fluid nodes near open boundaries (inlets and outlets), and the far ends of their bonds.
 *
 * An inlet ghost has a value of its own. A bond to an outlet sees the value of the fluid node itself (zero gradient),
 * so outlet ghosts have no value that a loop over many nodes could read: the nodes near them are listed here, and
 * loops work on them one by one.
 */
#ifndef PD_OPEN_BOUNDARY_H
#define PD_OPEN_BOUNDARY_H
#include "lattice/bond.h"

typedef struct pd_open_boundary {
    const pd_bonds *bonds;
    int32_t count, capacity;
    int32_t *node; /* [capacity] fluid nodes near inlets or outlets, ascending */
    /* [capacity][count of the stencil] far ends; blocked bonds and those to outlets end on the node */
    int32_t *far_end;
} pd_open_boundary;

#ifdef PDI_INTERNAL
/* 1: a side of the box is an inlet or an outlet. */
PDI_FN int pdi_open_boundary_has_any(const pd_grid *grid);
/* Allocates and fills the list of nodes with the far ends of their bonds, empty without inlets and outlets; bonds are
 * borrowed. `boundary` is overwritten; after a failure it is empty. */
PDI_FN pd_status pdi_open_boundary_build(pd_ctx *ctx, const pd_bonds *bonds, pd_open_boundary *boundary);
/* Lists the nodes again, after pd_bonds_update, and grows the arrays when they are too short; the number of a node in
 * the list may change. After a failure the list is empty. */
PDI_FN pd_status pdi_open_boundary_update(pd_ctx *ctx, pd_open_boundary *boundary);
PDI_FN void pdi_open_boundary_free(pd_ctx *ctx, pd_open_boundary *boundary);
/* *near_port: 1 when a side of the type inlet or outlet is within the reach of bonds of node i of the box, blocked ones
 * included, else 0. Returns how many of the `length` nodes from i along axis 0 are like node i in this, at least 1. */
PDI_FN int32_t pdi_open_boundary_find_segment(const pd_bonds *bonds, int32_t i, int32_t length, int *near_port);
/* *node: the first fluid node (lowest id) with an open bond to an inlet, from which no path of open bonds, through
 * periodic and mirror sides too, leads to an outlet (flood fill from the outlets); -1: none. PD_OK in both cases; on
 * failure (memory) -1. */
PDI_FN pd_status pdi_open_boundary_find_blocked_inlet(pd_ctx *ctx, const pd_bonds *bonds, int32_t *node);
#endif

#endif
