/* bond: rows of open bonds for fluid nodes whose family is cut, and runs of nodes whose family is whole.
 *
 * A bond is open when both ends and every cell that its straight line passes are open (fluid, inlet, outlet), so a
 * wall one node thick separates its two sides. A cut bond meets the surface at the fraction t of its length: on the
 * zero level of the shape where that is known, else on the face of the closed cell. It acts through its fictitious
 * end value, the extension of the field from the node through the wall value at t (theory: eq. 3.2 to 3.4), which
 * needs three numbers a node (wall_lap, wall_curv, gradient) and no ghost value in the solid.
 */
#ifndef PD_BOND_H
#define PD_BOND_H
#include "grid.h"

typedef struct pd_bonds {
    const pd_stencil *stencil;
    const pd_grid *grid;
    int all_rows;        /* every fluid node owns a row (for comparisons of both paths) */
    int32_t *shift;      /* [count] node id of the far end minus that of the node */
    int32_t *cell_shift; /* [cells] the same for the cells of the paths */
    int32_t *row;        /* [total] row of a node; -1: whole family, or not fluid */
    int32_t rows, capacity;
    int32_t *node;       /* [capacity] */
    uint16_t *open;      /* [capacity] open bonds of the row */
    uint16_t *bond;      /* [capacity][count] their stencil indices, ascending */
    double *wall_lap;    /* [capacity] [1/m2] sum over cut bonds of a/t (eq. 3.3), and the bend of a curved surface */
    double *wall_curv;   /* [capacity] [-] sum over cut bonds of a (xi.N)^2 (1-t)/2 (eq. 3.4), likewise */
    double *moment;      /* [capacity][PD_DIM][PD_DIM] [unit of 1/(base m2)] inverse of sum w xi xi^T over open bonds
                          * (eq. 3.5) */
    int32_t runs, run_capacity;
    int32_t *run_first, *run_length; /* nodes with whole families, consecutive along axis 0 */
} pd_bonds;

#define pd_bonds_build PD_NAME(pd_bonds_build)
#define pd_bonds_update PD_NAME(pd_bonds_update)
#define pd_bonds_validate PD_NAME(pd_bonds_validate)
#define pd_bonds_free PD_NAME(pd_bonds_free)

/* Grid and stencil are borrowed. all_rows != 0: a row for every fluid node. */
PD_API pd_status pd_bonds_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, int all_rows,
                                pd_bonds *bonds);
/* The kinds of `count` nodes have changed: renew the rows within one reach of them, nothing else. */
PD_API pd_status pd_bonds_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_bonds *bonds);
/* O(N): openness is mutual, rows and runs cover every fluid node once. PD_ERR_INTERNAL otherwise. */
PD_API pd_status pd_bonds_validate(pd_ctx *ctx, const pd_bonds *bonds);
PD_API void pd_bonds_free(pd_ctx *ctx, pd_bonds *bonds);

#ifdef PDI_INTERNAL
/* First closed group on bond k from `node` (index into the stencil's groups); -1: open. */
PDI_FN int pdi_bond_closed_group(const pd_bonds *bonds, int32_t node, int k);
#endif

#endif
