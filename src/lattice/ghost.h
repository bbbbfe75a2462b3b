/* ghost: fills the ghosts that stand for fluid nodes: images behind periodic and mirror sides, and outlets.
 *
 * One list for all sides. A ghost has one source node of the box and a sign for each component of a vector, the product
 * of what the axes ask for, so corners do not depend on the order of the axes. Mirror: the normal component is odd.
 * Outlet: tangential components are odd, the normal one is even, a pressure is odd about its value at the outlet
 * (theory: section 3.4). Ghosts of inlets are listed, too, and hold what their owner puts there; walls have no values
 * (see bond.h).
 */
#ifndef PD_GHOST_H
#define PD_GHOST_H
#include "lattice/grid.h"

typedef struct pd_ghosts {
    const pd_grid *grid;
    int32_t images, count, listed, capacity; /* images come first, then outlets up to count, then inlets up to listed */
    int32_t *node, *source; /* [capacity] */
    uint8_t *odd;           /* [capacity] bit d: component d of a vector changes its sign; inlets: axis d is mirrored */
    uint8_t *across;        /* [capacity] bit d: an inlet across axis d */
} pd_ghosts;

#define pd_ghosts_scalar PD_NAME(pd_ghosts_scalar)
#define pd_ghosts_vector PD_NAME(pd_ghosts_vector)

#ifdef PDI_INTERNAL
/* The grid is borrowed. */
PDI_FN pd_status pdi_ghosts_build(pd_ctx *ctx, const pd_grid *grid, pd_ghosts *ghosts);
/* The kinds of the grid have changed. */
PDI_FN pd_status pdi_ghosts_update(pd_ctx *ctx, pd_ghosts *ghosts);
#endif
/* f [total]: images take the value of their source; outlets are left alone. */
PD_API void pd_ghosts_scalar(const pd_ghosts *ghosts, double *f);
/* v [PD_DIM][total]: images and outlets. */
PD_API void pd_ghosts_vector(const pd_ghosts *ghosts, double *v);
#ifdef PDI_INTERNAL
/* v [PD_DIM][total] behind inlets: odd about what they hold on the side, held [PD_DIM][listed - count] in the order of
 * the list (NULL: zero), as far as the source is fluid. */
PDI_FN void pdi_ghosts_held(const pd_ghosts *ghosts, const double *held, double *v);
/* p [total]: images, and outlets odd about `held`, in the unit of p. */
PDI_FN void pdi_ghosts_pressure(const pd_ghosts *ghosts, double held, double *p);
/* q [total] of a velocity that corrects a flow: nothing of it passes an inlet, so that what enters is what inlets hold;
 * outlets hold zero, and so do inlets where nothing else does. */
PDI_FN void pdi_ghosts_potential(const pd_ghosts *ghosts, double *q);
/* x [components][total] becomes zero at all ghosts of the list, inlets included. */
PDI_FN void pdi_ghosts_clear(const pd_ghosts *ghosts, int components, double *x);
PDI_FN void pdi_ghosts_free(pd_ctx *ctx, pd_ghosts *ghosts);
#endif

#endif
