/* force: what a flow does to walls and solids, in two ways that share nothing but the fields.
 *
 * On the surface: cut bonds carry friction (the wall terms of eq. 3.3 and 3.4), and closed bonds are faces with the
 * area 2 g V that the pressure presses on. Around the body: momentum that passes the sides of a box of cells. Both are
 * second order where the surface is smooth; their difference measures the error (theory: eq. 4.27, 4.28).
 */
#ifndef PD_FORCE_H
#define PD_FORCE_H
#include "flow/flow.h"

#define pd_force_surface PD_NAME(pd_force_surface)
#define pd_force_balance PD_NAME(pd_force_balance)

#define PD_FORCE_ALL (-1)   /* as shape: everything */
#define PD_FORCE_SIDES (-2) /* as shape: the sides of the box, which are no part of a shape */
/* force [PD_DIM] [N; 1D: N/m2, 2D: N/m, axisymmetric: N along z, 0 across] that the present state of the flow exerts on
 * walls and solids between lo and hi [m]: friction of the fluid nodes there, and pressure on the points there at which
 * bonds meet the surface. friction and pressure are its parts (NULL: not wanted). Friction takes the steady balance of
 * momentum on the surface. shape is an index in the shapes of the grid: all closed cells whose centres lie in it count,
 * walls, and metal that has not dissolved. A cell of several shapes counts for each. */
PD_API void pd_force_surface(pd_ctx *ctx, pd_flow *flow, int shape, const double *lo, const double *hi, double *force,
                             double *friction, double *pressure);
/* The force on everything inside the box of cells next to lo .. hi [m], from what passes the sides of this box in a
 * steady flow. The body force counts with the cells of fluid inside. PD_ERR_GEOMETRY: a closed or outer node lies
 * within two cells of a side. */
PD_API pd_status pd_force_balance(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi, double *force);

#ifdef PDI_INTERNAL
/* Value at the place x [m] that fluid node `node` sees of the kinematic pressure p [total]: of the quadratic (3.11)
 * through the nodes within two cells, and the slope that friction of `flow` gives it on a smooth surface or side of the
 * box at rest beside x (eq. 3.11b). flow NULL: of the nodes alone. Ghosts must be filled. */
PDI_FN double pdi_force_pressure(const pd_bonds *bonds, const pd_flow *flow, const double *p, int32_t node,
                                 const double *x);
#endif

#endif
