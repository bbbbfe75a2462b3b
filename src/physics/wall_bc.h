/* wall_bc: boundary values at walls: velocities of sliding box sides, and prescribed (Dirichlet) concentrations of
 * sides and shapes. */
#ifndef PD_WALL_BC_H
#define PD_WALL_BC_H
#include "physics/inlet.h"

#ifdef PDI_INTERNAL
/* Does any side of the box slide along itself (moving wall)? 1 or 0. */
PDI_FN int pdi_wall_bc_has_motion(const pd_setup *setup);
/* Does any wall have a prescribed concentration? 1 or 0. */
PDI_FN int pdi_wall_bc_has_concentration(const pd_setup *setup);
/* Wall velocity u [PD_DIM] [m/s] at the surface point x [m] and at inlet->time; a point behind a mirror or periodic
 * side has that of its image, reflected. The mean over all wall sides it lies on, of which those at rest count as 0; 0
 * off the sides. A pd_velocity_fn; user is the pd_inlet. */
PDI_FN void pdi_wall_bc_get_velocity(void *user, const double *x, double *u);
/* Prescribed wall concentration [mol/m3] at the surface point x [m] and at inlet->time; NaN: no flux. The mean over the
 * wall sides there that prescribe one. Off all wall sides it is that of the nearest wall or solid shape within a cell,
 * since rough surfaces lie on faces of cells. -HUGE_VAL: the expression is NaN. A pd_point_fn; user is the pd_inlet. */
PDI_FN double pdi_wall_bc_get_concentration(void *user, const double *x);
/* 1: a wall side that x [m] lies on has the inlet concentrations of all species as a Dirichlet condition; NaN: no
 * species passes. A pd_point_fn; user is the pd_inlet. */
PDI_FN double pdi_wall_bc_is_dirichlet_species(void *user, const double *x);
#endif

#endif
