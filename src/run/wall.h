/* wall: what the walls of a setup do: sides of the box move along themselves, sides and shapes hold a concentration. */
#ifndef PD_WALL_H
#define PD_WALL_H
#include "run/inlet.h"

#ifdef PDI_INTERNAL
/* 1 when a wall of the setup moves, or holds a concentration. */
PDI_FN int pdi_wall_moves(const pd_setup *setup);
PDI_FN int pdi_wall_holds(const pd_setup *setup);
/* A pd_velocity_fn and a pd_point_fn; user is the pd_inlet, whose time holds. x lies on a surface. Where two sides meet
 * the velocity is their mean, and the first of them that holds a concentration counts. Off the sides, at rest, the
 * nearest of the wall and solid shapes counts: found within a cell, since surfaces that are not smooth lie on faces of
 * cells. */
PDI_FN void pdi_wall_velocity(void *user, const double *x, double *u);
PDI_FN double pdi_wall_held(void *user, const double *x);
/* The same for species: 1, or NaN where walls are closed for them. */
PDI_FN double pdi_wall_steeps(void *user, const double *x);
#endif

#endif
