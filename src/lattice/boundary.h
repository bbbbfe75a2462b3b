/* boundary: the fluid nodes beside inlets and outlets, and what their bonds end on.
 *
 * An inlet ghost holds a value of its own. An outlet shows each node the node's own value, so it has none that a sweep
 * over many nodes could read: those beside it are listed here, and sweeps work on them one by one, as blocks of one.
 */
#ifndef PD_BOUNDARY_H
#define PD_BOUNDARY_H
#include "lattice/bond.h"

typedef struct pd_boundary {
    const pd_bonds *bonds;
    int32_t count, capacity;
    int32_t *node; /* [capacity] ascending */
    int32_t *far;  /* [capacity][count of the stencil] far ends; closed bonds and those to outlets end on the node */
} pd_boundary;

#ifdef PDI_INTERNAL
/* 1: a side of the box is an inlet or an outlet. */
PDI_FN int pdi_boundary_any(const pd_grid *grid);
PDI_FN pd_status pdi_boundary_build(pd_ctx *ctx, const pd_bonds *bonds, pd_boundary *boundary);
/* After pd_bonds_update. */
PDI_FN pd_status pdi_boundary_update(pd_ctx *ctx, pd_boundary *boundary);
PDI_FN void pdi_boundary_free(pd_ctx *ctx, pd_boundary *boundary);
/* *beside: 1 when node i has an inlet or outlet in reach. Returns how many of the `length` nodes from i along axis 0
 * are like node i in this. */
PDI_FN int32_t pdi_boundary_segment(const pd_bonds *bonds, int32_t i, int32_t length, int *beside);
/* A fluid node beside an inlet from which no open bonds lead to an outlet; -1: there is none. */
PDI_FN pd_status pdi_boundary_blocked(pd_ctx *ctx, const pd_bonds *bonds, int32_t *node);
#endif

#endif
