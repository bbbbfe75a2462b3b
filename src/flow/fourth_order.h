/* fourth_order: the flow of fourth order on the nearest neighbours: corrections of advecting velocity, pressure
 * gradient, convection and friction by second differences along the axes. Node by node for the advecting velocity and
 * the pressure gradient, face by face for momentum. At walls a cubic through the wall and three nodes gives the second
 * difference. Nodes beside smooth surfaces stay of second order (theory: eq. 3.18 to 3.23). */
#ifndef PD_FOURTH_ORDER_H
#define PD_FOURTH_ORDER_H
#include "core/array_registry.h"
#include "lattice/bond.h"

typedef struct pd_fourth_order {
    const pd_bonds *bonds;        /* NULL: second order */
    double third_moments[PD_DIM][PD_DIM];   /* [-] third moments sum g_d xi_d n_b^2 of the gradient */
    int face_bonds[PD_DIM][2 * PD_DIM - 1]; /* bonds through the upper face along axis d: the one along d, and for each
                                             * other axis the two diagonals, down and up along it; -1: none */
    /* [total] 1: the node is corrected: fluid beside no smooth surface, and its ghosts */
    uint8_t *is_regular;
    double *second, *second_increment; /* [PD_DIM axes][PD_DIM][total] [m/s] second differences of the velocity, and of
                                        * the step of a solver */
    double *work;                 /* [PD_DIM+1][total] velocity behind inlets [m/s]; of the pressure [m2/s2]; momentum
                                   * [m/s2] and volume [1/s] of faces */
} pd_fourth_order;

#ifdef PDI_INTERNAL
/* A velocity field in the momentum sums, with what derives from it. Ghosts are filled. */
typedef struct pdi_fourth_order_field {
    const double *advecting; /* [PD_DIM][total] [m/s] velocity that makes the bond fluxes (eq. 3.19) */
    const double *v, *second; /* [m/s] node velocity and its second differences (eq. 3.18) */
} pdi_fourth_order_field;

/* 1: no side of the box is an inlet or outlet, and two axes or more have a wall on at least one of their sides, so that
 * walls meet in edges; 0 in 1D. side [2 PD_DIM]. */
PDI_FN int pdi_fourth_order_has_closed_sides(const pd_side *side);
/* 1: pdi_fourth_order_has_closed_sides, and all nodes inside the box are fluid: no walls or metal inside. */
PDI_FN int pdi_fourth_order_is_fluid_box(const pd_grid *grid);
/* 1: fourth order is known to be more accurate for the same time (eq. 3.24): rate times length is at most 1000, rate
 * times the longest spacing at most 16, the family has the nearest neighbours alone, and the lattice is planar and a
 * fluid box (pdi_fourth_order_is_fluid_box). rate: U/nu [1/m], length [m]: that of the flow. */
PDI_FN int pdi_fourth_order_is_efficient(const pd_bonds *bonds, double rate, double length);
/* Allocates the arrays, computes moments and face bonds, and marks the regular nodes. Bonds are borrowed.
 * PD_ERR_ARGUMENT: the family reaches beyond the nearest neighbours or has bonds with offsets along three axes, or the
 * lattice is axisymmetric. After an error nothing is allocated, and sharp->bonds is NULL. */
PDI_FN pd_status pdi_fourth_order_build(pd_ctx *ctx, const pd_bonds *bonds, pd_fourth_order *sharp);
/* Lists the arrays of a pd_fourth_order (`object`). */
PDI_FN void pdi_fourth_order_list(pdi_array_visitor *owner, void *object);
/* Marks the nodes that get the correction (fluid beside no smooth surface, and their ghosts) after a change of
 * geometry. */
PDI_FN void pdi_fourth_order_mark_regular_nodes(const pd_fourth_order *sharp);
/* second [PD_DIM axes][PD_DIM][total] [m/s] = second differences of v [PD_DIM][total] along all axes (eq. 3.18), not
 * divided by h^2, at fluid nodes and ghosts; beside a closed neighbour from a cubic with the wall value. Ghosts of v
 * are given. wall: velocity of the walls; NULL: at rest. */
PDI_FN void pdi_fourth_order_compute_second_differences(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                                        pd_velocity_fn wall, void *user, const double *v,
                                                        double *second);
/* corrected [PD_DIM][total] [m/s] = advecting velocity of fourth order: v less the third-derivative error of the bond
 * fluxes, at regular fluid nodes and their inlet ghosts (eq. 3.19). Holds v on entry; other entries stay. The tensor of
 * (3.4) is applied after it. Overwrites `work`. */
PDI_FN void pdi_fourth_order_compute_advecting_velocity(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                                        const double *v, const double *second, double *corrected);
/* grad [PD_DIM][total] [unit of p/m] = pressure gradient of fourth order, at regular fluid nodes alone; other entries
 * stay (eq. 3.20). Closed neighbours and inlets give no pressure: one-sided beside one, 0 along an axis between two.
 * Ghosts of p are given. Overwrites `work`. */
PDI_FN void pdi_fourth_order_compute_pressure_gradient(const pd_ctx *ctx, const pd_fourth_order *sharp, const double *p,
                                                       double *grad);
/* ru [PD_DIM][total] [m/s2] += fourth-order less second-order convection of u by w and friction nu of u at fluid nodes,
 * face by face (eq. 3.21, 3.22), less u times half the divergence of this difference of volume fluxes. Faces to a
 * closed node, and those at or beside a smooth surface, have no correction. nu [m2/s], 0: convection alone. Overwrites
 * `work`. */
PDI_FN void pdi_fourth_order_add_momentum(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                          const pdi_fourth_order_field *w, const pdi_fourth_order_field *u, double nu,
                                          double *ru);
/* Terms by which (2.3) and (2.4) take the wall friction that is replaced. NULL: none, but `grad` is needed. */
typedef struct pdi_fourth_order_wall_terms {
    const double *grad;        /* [PD_DIM][total] [m/s2] of the pressure */
    const double *force, *body; /* [PD_DIM], [PD_DIM][total] [m/s2] */
    const double *wall_motion;  /* [PD_DIM][total] [1/m/s] of moving walls */
} pdi_fourth_order_wall_terms;
/* ru += friction nu [m2/s] of flat walls by the cubic (3.23), in place of that by the parabola of (2.3) and (2.4), at
 * the rows where pdi_fourth_order_compute_wall_laplacian returns 1. drive->grad must be given, its other terms may be
 * NULL. */
PDI_FN void pdi_fourth_order_add_wall_friction(const pd_ctx *ctx, const pd_fourth_order *sharp,
                                               const pdi_fourth_order_field *u,
                                               const pdi_fourth_order_wall_terms *drive, double nu, double *ru);
/* lap [PD_DIM] [1/m/s] = wall part of the Laplacian of v at row r (eq. 3.23), of the axes with a closed neighbour.
 * Returns 1 when the row has a closed neighbour along an axis and is beside no smooth surface, else 0 with lap 0. */
PDI_FN int pdi_fourth_order_compute_wall_laplacian(const pd_fourth_order *sharp, int32_t r, const double *v,
                                                   const double *second, double *lap);
PDI_FN void pdi_fourth_order_free(pd_ctx *ctx, pd_fourth_order *sharp);
#endif

#endif
