/* wall: what the walls of a setup do: sides of the box move along themselves, sides and shapes hold a concentration. */
#ifndef PD_WALL_H
#define PD_WALL_H
#include "run/inlet.h"

#define pd_wall_moves PD_NAME(pd_wall_moves)
#define pd_wall_holds PD_NAME(pd_wall_holds)
#define pd_wall_velocity PD_NAME(pd_wall_velocity)
#define pd_wall_held PD_NAME(pd_wall_held)

/* 1 when a wall of the setup moves, or holds a concentration. */
PD_API int pd_wall_moves(const pd_setup *setup);
PD_API int pd_wall_holds(const pd_setup *setup);
/* A pd_velocity_fn and a pd_point_fn; user is the pd_inlet, whose time holds. x lies on a surface. Where two sides meet
 * the velocity is their mean, and the first of them that holds a concentration counts. Off the sides, at rest, the
 * nearest of the wall and solid shapes counts: found within a cell, since surfaces that are not smooth lie on faces of
 * cells. */
PD_API void pd_wall_velocity(void *user, const double *x, double *u);
PD_API double pd_wall_held(void *user, const double *x);

#endif
