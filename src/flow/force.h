/* force: what a flow does to walls and solids, in two ways that share nothing but the fields.
 *
 * On the surface: cut bonds carry friction (the wall terms of eq. 3.3 and 3.4), and pressure acts on the pieces of the
 * surface in each cell. Around the body: momentum that passes the sides of a box of cells. Both are of second order
 * where the surface is smooth; their difference measures the error (theory: eq. 4.27, 4.28).
 */
#ifndef PD_FORCE_H
#define PD_FORCE_H
#include "flow/flow.h"

#define pd_force_surface PD_NAME(pd_force_surface)
#define pd_force_balance PD_NAME(pd_force_balance)

#define PD_FORCE_ALL (-1)   /* as shape: everything */
#define PD_FORCE_SIDES (-2) /* as shape: the sides of the box, which are no part of a shape */
/* force [PD_DIM] [N; 1D: N/m2, 2D: N/m, axisymmetric: N along z, 0 across] that the present state of the flow exerts on
 * the surface of walls and solids between lo and hi [m]. A constant pressure gives itself times the area there.
 * friction and pressure are its parts (NULL: not wanted). Friction takes the steady balance of momentum on the
 * surface. shape is an index in the shapes of the grid, of walls or of metal that has not dissolved: pieces of a smooth
 * surface that it is nearest to count, and faces of closed cells whose centres lie in it. A cell of several shapes
 * counts for each. */
PD_API void pd_force_surface(pd_ctx *ctx, pd_flow *flow, int shape, const double *lo, const double *hi, double *force,
                             double *friction, double *pressure);
/* The force on everything inside the box of cells next to lo .. hi [m], from what passes the sides of this box in a
 * steady flow. The body force counts with the cells of fluid inside. PD_ERR_GEOMETRY: a closed or outer node lies
 * within two cells of a side. */
PD_API pd_status pd_force_balance(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi, double *force);

#endif
