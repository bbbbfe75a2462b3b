/* coarsen_setup: the same setup on a coarser lattice, `factor` times the spacing, with the same physics, tolerances and
 * geometry.
 *
 * The difference of runs at h and 2 h gives the discretisation error (richardson.h). Monitor planes keep their places:
 * a plane between two of the coarser lattice is interpolated linearly between both.
 */
#ifndef PD_COARSEN_SETUP_H
#define PD_COARSEN_SETUP_H
#include "setup/setup.h"

/* The coarsened setup. */
typedef struct pd_coarsened_setup {
    pd_setup setup;                   /* borrows from the setup it was made of: never free it */
    double monitor_weight[PD_SETUP_MONITORS]; /* [-] weight of each monitor in the outputs of its section */
} pd_coarsened_setup;

#ifdef PDI_APP_INTERNAL
/* Coarsen a setup by a factor of 2 or more; lines are left out of its monitors. On failure coarser is zero.
 * PD_ERR_GEOMETRY: the coarser lattice cannot resolve the scene: the box is no multiple of its cells, the face of a box
 * lies off its planes, fluid, solid or wall is thinner than a cell or lost, a plane has no place. PD_ERR_SIZE: too many
 * planes. */
PDI_FN pd_status pdi_coarsen_setup_build(pd_ctx *ctx, const pd_setup *setup, int factor, pd_coarsened_setup *coarser);
#endif

#endif
