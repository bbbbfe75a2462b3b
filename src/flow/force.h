/* force: force of a flow on walls and solids, computed in two independent ways. On the surface: friction from the wall
 * terms of cut bonds (eq. 2.3, 2.4) or the wall shear, pressure on the pieces of the surface in each cell. Around the
 * body: momentum flux through the faces of a box of cells. Both are of second order where the surface is smooth; their
 * difference measures the error (theory: eq. 5.1, 5.5). */
#ifndef PD_FORCE_H
#define PD_FORCE_H
#include "flow/flow.h"

#define pd_force_surface PD_NAME(pd_force_surface)
#define pd_force_momentum_balance PD_NAME(pd_force_momentum_balance)

#define PD_FORCE_ALL (-1) /* as shape: all surfaces */
#define PD_FORCE_BOX_SIDES (-2) /* as shape: the sides of the box alone */
/* force [PD_DIM] [N; 1D: N/m2, 2D: N/m, axisymmetric: N along z, 0 across] that the present state of the flow exerts on
 * the surface of walls and solids between lo and hi [m]. A constant pressure gives itself times the area there.
 * friction and pressure are its parts (NULL: not wanted). Friction takes the steady balance of momentum on the surface.
 * shape: PD_FORCE_ALL, PD_FORCE_BOX_SIDES, or an index in the shapes of the grid, of walls or of metal that has not
 * dissolved: pieces of a smooth surface that it is nearest to count, and faces of closed cells whose centres lie in it.
 * A cell of several shapes counts for each. Updates the derived fields. */
PD_API void pd_force_surface(pd_ctx *ctx, pd_flow *flow, int shape, const double *lo, const double *hi, double *force,
                             double *friction, double *pressure);
/* force [PD_DIM], as above, on everything inside the box lo .. hi [m], rounded to cell faces, from the momentum flux
 * through its faces in a steady flow. At an axis of symmetry the box begins there, whatever lo is. Body forces count
 * with the open volume of cells. Updates the derived fields. PD_ERR_GEOMETRY, force 0: the box is empty, or a node
 * within two cells of a face is not fluid or not in the lattice. */
PD_API pd_status pd_force_momentum_balance(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi,
                                           double *force);

#endif
