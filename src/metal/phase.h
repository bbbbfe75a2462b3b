/* phase: which nodes of bond-based corrosion are metal and which are fluid, and what a step does with them.
 *
 * A ghost has the phase of the node that it repeats; behind an inlet or outlet fluid is held and metal is not
 * continued. The number of wet bonds of every node is kept, so a node that turns costs one visit to its family.
 */
#ifndef PD_PHASE_H
#define PD_PHASE_H
#include "lattice/grid.h"

typedef struct pd_phases {
    const pd_grid *grid;
    const pd_stencil *stencil;
    int32_t *shift;    /* [count] node id of the far end minus that of the node */
    uint8_t *phase;    /* [total] of nodes and ghosts */
    uint8_t *role;     /* [total] what a step does with a node */
    uint16_t *wet;     /* [total] bonds of a node that lead to fluid */
    int32_t *ghost, *source; /* [ghosts] */
    uint8_t *behind;   /* [ghosts] 1: behind an odd number of held planes */
    int32_t ghosts;
    int32_t *border;   /* [borders] nodes within reach of held sides */
    int32_t borders;
} pd_phases;

#ifdef PDI_INTERNAL
/* Phases. Held: the ghost of a fluid node behind an inlet or outlet. */
enum { PDI_PHASE_NONE = 0, PDI_PHASE_FLUID, PDI_PHASE_HELD, PDI_PHASE_SOLID };
/* Roles: what lies beyond the reach of all others is skipped; whole families go in lanes. */
enum { PDI_ROLE_IDLE = 0, PDI_ROLE_WHOLE, PDI_ROLE_SHORE, PDI_ROLE_EXPOSED };
static inline int pdi_phase_wet(uint8_t phase) { return phase == PDI_PHASE_FLUID || phase == PDI_PHASE_HELD; }
/* Nodes along axis 0 that one thread sweeps at a time. */
#define PDI_PHASE_PIECE 128
/* Grid and stencil are borrowed. PD_ERR_GEOMETRY: a box with held sides is thinner than a horizon. */
PDI_FN pd_status pdi_phase_build(pd_ctx *ctx, const pd_grid *grid, const pd_stencil *stencil, pd_phases *phases);
/* Phases and roles of all nodes, from their kinds. */
PDI_FN void pdi_phase_read(pd_phases *phases);
/* `count` solid nodes turn fluid. */
PDI_FN void pdi_phase_turn(pd_phases *phases, const int32_t *nodes, int32_t count);
PDI_FN void pdi_phase_free(pd_ctx *ctx, pd_phases *phases);
/* Pieces of the rows of the box, and the first node and length of one. */
PDI_FN int32_t pdi_phase_pieces(const pd_phases *phases);
PDI_FN int32_t pdi_phase_place(const pd_phases *phases, int32_t piece, int *count);
/* One behind the last of the nodes from i to `end` - 1 that have the role of i. */
PDI_FN int32_t pdi_phase_same(const pd_phases *phases, int32_t i, int32_t end);
/* The next nodes *first .. *end - 1 of one role, all over the box in order; 0: none is left. A walk begins with
 * zeros. */
typedef struct pdi_phase_walk {
    int32_t piece, at, end;
} pdi_phase_walk;
PDI_FN int pdi_phase_next(const pd_phases *phases, pdi_phase_walk *walk, int32_t *first, int32_t *end);
/* 1: no bond of the node leaves the box. */
PDI_FN int pdi_phase_deep(const pd_phases *phases, int32_t node);
/* Node of the box that the far end of a bond is or repeats, with `deep` of its other end. */
static inline int32_t pdi_phase_home(const pd_phases *phases, int deep, int32_t far)
{
    return deep ? far : pdi_grid_image(phases->grid, far, NULL);
}
#endif

#endif
