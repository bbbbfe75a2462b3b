/* coarser: a setup once more on a coarser lattice: the same physics, tolerances and geometry, `factor` times the
 * spacing.
 *
 * The difference of a run at h and that at 2 h gives the error of the lattice (estimate.h). A rate by layers keeps
 * the thickness of the layer. Planes keep their places: a plane between two planes of the coarser lattice is watched on
 * both.
 */
#ifndef PD_COARSER_H
#define PD_COARSER_H
#include "scene/setup.h"

typedef struct pd_coarser {
    pd_setup setup;                   /* borrows from the setup it was made of: never free it */
    double share[PD_SETUP_MONITORS];  /* [-] of each monitor in the figures of its section */
} pd_coarser;

#ifdef PDI_INTERNAL
/* factor: 2 or more. PD_ERR_GEOMETRY: the coarser lattice cannot hold the scene: the box is no whole number of its
 * cells or the face of a box no plane of it, fluid, solid or wall is thinner than one of them or lost on it, a plane is
 * left without a place. PD_ERR_SIZE: more planes than there is room for. */
PDI_FN pd_status pdi_coarser_build(pd_ctx *ctx, const pd_setup *setup, int factor, pd_coarser *coarser);
#endif

#endif
