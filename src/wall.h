/* wall: what the walls at the sides of a box do in a setup: they move along themselves, they hold a concentration. */
#ifndef PD_WALL_H
#define PD_WALL_H
#include "setup.h"

#define pd_wall_moves PD_NAME(pd_wall_moves)
#define pd_wall_holds PD_NAME(pd_wall_holds)
#define pd_wall_velocity PD_NAME(pd_wall_velocity)
#define pd_wall_held PD_NAME(pd_wall_held)

/* 1 when a wall of the setup moves, or holds a concentration. */
PD_API int pd_wall_moves(const pd_setup *setup);
PD_API int pd_wall_holds(const pd_setup *setup);
/* A pd_velocity_fn and a pd_point_fn; user is the pd_setup. x lies on a surface. Where two sides meet the velocity is
 * their mean, and the first of them that holds a concentration counts; elsewhere rest, and NaN. */
PD_API void pd_wall_velocity(void *user, const double *x, double *u);
PD_API double pd_wall_held(void *user, const double *x);

#endif
