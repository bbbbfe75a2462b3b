/* ghost: values of ghost nodes from boundary conditions: periodic and mirror sides, outlets, inlets.
 *
 * One list for all sides. A ghost has one source node of the box and a sign for each component of a vector, the product
 * of the signs of the axes, so corners do not depend on the order of the axes. Mirror: the normal component is odd.
 * Outlet: tangential components are odd, the normal one is even, a pressure is odd about its value at the outlet
 * (theory: section 1.5). Ghosts of inlets are listed, too, and hold what their owner puts there; walls have no values
 * (see bond.h).
 */
#ifndef PD_GHOST_H
#define PD_GHOST_H
#include "lattice/grid.h"

typedef struct pd_ghosts {
    const pd_grid *grid;
    /* images come first, up to images_end, then outlets up to outlets_end, then inlets up to inlets_end */
    int32_t images_end, outlets_end, inlets_end, capacity;
    int32_t *node, *source; /* [capacity] the ghost, and the node of the box that it takes its value from */
    /* [capacity] bit d: component d of a vector changes its sign; inlets: axis d is mirrored */
    uint8_t *sign_flips;
    uint8_t *normal_axis; /* [capacity] bit d: the inlet or outlet is normal to axis d */
} pd_ghosts;

#define pd_ghosts_set_scalar PD_NAME(pd_ghosts_set_scalar)
#define pd_ghosts_set_vector PD_NAME(pd_ghosts_set_vector)

#ifdef PDI_INTERNAL
/* Allocates and fills the list of the images, outlet and inlet ghosts of a grid, which is borrowed. *ghosts is
 * overwritten, and all zero after a failure. */
PDI_FN pd_status pdi_ghosts_build(pd_ctx *ctx, const pd_grid *grid, pd_ghosts *ghosts);
/* Lists the ghosts again after kinds of the grid have changed, and grows the arrays when they are too short; the
 * numbers of ghosts in the list may change. After a failure the list is empty. */
PDI_FN pd_status pdi_ghosts_update(pd_ctx *ctx, pd_ghosts *ghosts);
#endif
/* Scalar f [total]: images take the value of their source (periodic, or zero normal gradient); outlets and inlets are
 * left alone. */
PD_API void pd_ghosts_set_scalar(const pd_ghosts *ghosts, double *f);
/* Vector v [PD_DIM][total]: images and outlets take the value of their source, with the sign of the component; inlets
 * are left alone. */
PD_API void pd_ghosts_set_vector(const pd_ghosts *ghosts, double *v);
#ifdef PDI_INTERNAL
/* Velocity v [PD_DIM][total] behind inlets: odd extension 2 held - source about the values `held` on the side (NULL:
 * zero), stored [PD_DIM][inlets_end - outlets_end] in the order of the list; the source has the sign of its mirror
 * image in other sides. Where the source is no fluid: `held` itself. Images and outlets are left alone. */
PDI_FN void pdi_ghosts_set_inlet_velocity(const pd_ghosts *ghosts, const double *held, double *v);
/* Pressure p [total]: images take the value of their source, outlets 2 held - source with the prescribed value `held`
 * in the unit of p; inlets are left alone. */
PDI_FN void pdi_ghosts_set_pressure(const pd_ghosts *ghosts, double held, double *p);
/* Potential q [total] of a velocity correction (projection): images and inlets take the value of their source (inlets 0
 * where that is no fluid), so that the correction leaves the prescribed inflow. Outlets are left alone, and without
 * outlets so are inlets: they have to be zero before. */
PDI_FN void pdi_ghosts_set_potential(const pd_ghosts *ghosts, double *q);
/* Sets x [components][total] to zero at all listed ghosts, inlets included. */
PDI_FN void pdi_ghosts_set_zero(const pd_ghosts *ghosts, int components, double *x);
PDI_FN void pdi_ghosts_free(pd_ctx *ctx, pd_ghosts *ghosts);
#endif

#endif
