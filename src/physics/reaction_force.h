/* reaction_force: resultant forces of mechanical boundary conditions: reactions of supports and sums of applied loads.
 * At edges and corners the reaction is divided among the sides that prescribe it. */
#ifndef PD_REACTION_FORCE_H
#define PD_REACTION_FORCE_H
#include "physics/mechanical_bc.h"

#define pd_reaction_force_compute PD_NAME(pd_reaction_force_compute)

/* Resultant force [PD_DIM] [N] (per m in 2D, per m2 in 1D) of boundary condition k on the body at time t [s]: the
 * reaction of prescribed components, as of the last equilibrium, and the applied load of the others. In equilibrium the
 * forces of all conditions and of the body force add up to zero. PD_ERR_STATE: as that of pdi_mechanical_bc_apply; work
 * is freed. */
PD_API pd_status pd_reaction_force_compute(pd_ctx *ctx, const pd_mechanical_bc *grips, int k, double t, double *force);

#endif
