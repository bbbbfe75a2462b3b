/* isotropic_stencil: friction weights with isotropic leading error (a Laplacian of the Laplacian, which vanishes in
 * slow steady flow), and fluxes whose leading error is a Laplacian of the divergence, on nearest neighbours. Friction
 * gains mixed differences over squares of four nodes; incomplete squares beside walls have none (theory: eq. 3.13
 * to 3.16). The advecting velocity loses third-derivative terms (eq. 3.6). */
#ifndef PD_ISOTROPIC_STENCIL_H
#define PD_ISOTROPIC_STENCIL_H
#include "core/base.h"
#include "lattice/bond.h"

/* A square of four neighbouring nodes in the plane of two axes, seen from one of them. */
typedef struct pd_isotropic_square {
    int diagonal, legs[2]; /* bonds of the node: the diagonal, and those along both axes */
    double weight_excess;  /* [1/m2] weight c_ab that the diagonal gains and both sides lose (eq. 3.15) */
} pd_isotropic_square;

typedef struct pd_isotropic_stencil {
    const pd_bonds *bonds; /* NULL: friction has the weights of the Laplacian */
    int squares;
    pd_isotropic_square square[2 * PD_DIM * PD_DIM];
    double weight_excess[2 * PD_DIM * PD_DIM]; /* [1/m2] isotropic less Laplacian weight of bonds in complete squares */
    /* [-] factor on the second difference of each velocity component along its own axis (3.6) */
    double third_moment[PD_DIM];
} pd_isotropic_stencil;

#ifdef PDI_INTERNAL
/* A row (node with a cut family) beside a surface with the velocity `wall`; NULL: at rest. */
typedef struct pdi_isotropic_stencil_place {
    const pd_bonds *bonds;
    int32_t row;
    pd_velocity_fn wall;
    void *wall_user;
} pdi_isotropic_stencil_place;

/* Weights with isotropic leading error for families of all nearest neighbours with diagonals in planes of two axes, on
 * planar lattices in 2D and 3D (eq. 3.14). In 1D, for larger or smaller families and on axisymmetric lattices
 * isotropic->bonds stays NULL. Allocates nothing; bonds are borrowed. */
PDI_FN void pdi_isotropic_stencil_build(const pd_bonds *bonds, pd_isotropic_stencil *isotropic);
/* Blending factor of the isotropic weights, 1 to 0 (eq. 3.17): 1/(1 + (U h/(2 nu))^2) with the longest spacing h, since
 * convection errs by more than friction in fast flow. rate: U/nu [1/m]. 0: there are no isotropic weights. */
PDI_FN double pdi_isotropic_stencil_compute_blending(const pd_isotropic_stencil *isotropic, double rate);
/* Sum of the mixed differences [1/m2 times f] of component f [total] at row r over squares that cut bonds leave
 * incomplete: to be subtracted from its isotropic Laplacian (eq. 3.15). */
PDI_FN double pdi_isotropic_stencil_compute_row_correction(const pd_isotropic_stencil *isotropic, int32_t r,
                                                           const double *f);
/* ru += nu times the incomplete squares of u [PD_DIM][total] (eq. 3.15) at all rows: takes them out of the friction -
 * nu lap u. nu [m2/s]: times the blending factor. Nothing without isotropic weights. */
PDI_FN void pdi_isotropic_stencil_add_row_corrections(const pd_ctx *ctx, const pd_isotropic_stencil *isotropic,
                                                      double nu, const double *u, double *ru);
/* advecting -= third-moment correction (3.6): a factor times the second difference of v [PD_DIM][total] along its own
 * axis, at fluid nodes between two open ones; rows with a closed neighbour along that axis get v. Ghosts of v are
 * given. Nothing without isotropic weights. */
PDI_FN void pdi_isotropic_stencil_add_velocity_correction(const pd_ctx *ctx, const pd_isotropic_stencil *isotropic,
                                                          const double *v, double *advecting);
/* Derivative [1/s] of component d of u along axis d at the row: parabola through both neighbours, or through the
 * surface where it is nearer, with the velocity of the wall. In 1D and 2D on nearest neighbours, where just one
 * neighbour is closed and the node behind the open one is open: a cubic through that node, too (for eq. 3.5). */
PDI_FN double pdi_isotropic_stencil_compute_derivative(const pdi_isotropic_stencil_place *place, int d,
                                                       const double *u);
#endif

#endif
