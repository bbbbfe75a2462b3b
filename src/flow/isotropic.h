/* isotropic: weights of friction whose leading error is a Laplacian of the Laplacian, and fluxes whose leading error is
 * that of the divergence.
 *
 * On the nearest neighbours the Laplacian errs by fourth derivatives along the axes and mixed ones, and by other shares
 * of them than h^2/12 lap lap, which vanishes in slow steady flow. What is missing is mixed differences over squares of
 * four nodes: what one takes up the others give. Squares that miss a node have none (theory: eq. 4.1b to 4.1e). The
 * divergence errs by third derivatives along the axes: the advecting velocity takes off what makes it a Laplacian of
 * the divergence, which vanishes (eq. 4.2d).
 */
#ifndef PD_ISOTROPIC_H
#define PD_ISOTROPIC_H
#include "core/base.h"
#include "lattice/bond.h"

/* A node and three others in the plane of two axes. */
typedef struct pd_square {
    int across, side[2]; /* bonds of the node: through the middle, along both axes */
    double more;         /* [1/m2] what `across` gains, and both sides lose */
} pd_square;

typedef struct pd_isotropic {
    const pd_bonds *bonds; /* NULL: friction has the weights of the Laplacian */
    int squares;
    pd_square square[2 * PD_DIM * PD_DIM];
    double excess[2 * PD_DIM * PD_DIM]; /* [1/m2] of bonds over those of the Laplacian, where squares are complete */
    double bend[PD_DIM]; /* [-] of its second difference along its axis, which the advecting velocity loses */
} pd_isotropic;

#ifdef PDI_INTERNAL
/* A row beside a surface with the velocity `wall`; NULL: 0. */
typedef struct pdi_slope_place {
    const pd_bonds *bonds;
    int32_t r;
    pd_velocity_fn wall;
    void *user;
} pdi_slope_place;

/* Families of the nearest neighbours on planar lattices get weights; others none. */
PDI_FN void pdi_isotropic_build(const pd_bonds *bonds, pd_isotropic *isotropic);
/* Share of the excess that a flow takes whose Reynolds number is `rate` [1/m] a length: it falls from 1 to 0 as that of
 * the longest spacing grows, where advection errs by more than friction (theory: eq. 4.1f). */
PDI_FN double pdi_isotropic_share(const pd_isotropic *isotropic, double rate);
/* What the squares of row r that are not complete take off the Laplacian of a component f [total]. */
PDI_FN double pdi_isotropic_row(const pd_isotropic *isotropic, int32_t r, const double *f);
/* ru += what `excess` brings too much to friction nu of u [PD_DIM][total] by squares that are not complete. */
PDI_FN void pdi_isotropic_rows(const pd_ctx *ctx, const pd_isotropic *isotropic, double nu, const double *u,
                               double *ru);
/* advecting -= bend times the second difference of v [PD_DIM][total] at fluid nodes between two open ones. */
PDI_FN void pdi_isotropic_velocity(const pd_ctx *ctx, const pd_isotropic *isotropic, const double *v,
                                   double *advecting);
/* Derivative [1/s] of component d of u along axis d: of the parabola through both neighbours, or the surface where it
 * comes before one of them; with the nearest neighbours in the plane then of the cubic through the node behind the
 * other, too. */
PDI_FN double pdi_isotropic_slope(const pdi_slope_place *place, int d, const double *u);
#endif

#endif
