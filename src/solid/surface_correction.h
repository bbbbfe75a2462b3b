/* surface_correction: surface correction of bond-based models by moments: factors of bonds in families that a surface
 * truncates.
 *
 * Each family has moments sum w r f(n) V: the energies of strains along the axes, the products n_a n_b, and the
 * traceless part of n n n. Bond factors restore the moments of a complete family. Then a uniform stress is in balance
 * at a free surface of any direction, and energies are those of the bulk. Each point has a multiplier (share) for each
 * moment. The factor of a bond is a bounded exponential of the multipliers of both ends; a complete family needs none
 * (theory: eq. 15.4 to 15.7).
 *
 * Sums take terms rounded to a grid, so that they are exact: they do not depend on the order, and a body and its mirror
 * image get the same bits. Multipliers depend on those of all points around, however far: mirror images behind planes
 * of symmetry take those of their points.
 */
#ifndef PD_SURFACE_CORRECTION_H
#define PD_SURFACE_CORRECTION_H
#include "solid/bond_force.h"

/* Energies along the axes, products of two axes, tensors of third order without a trace. */
enum {
    PD_SURFACE_CORRECTION_PRODUCTS = PD_DIM * (PD_DIM - 1) / 2,
    PD_SURFACE_CORRECTION_MOMENTS = PD_DIM + PD_SURFACE_CORRECTION_PRODUCTS +
                                    (PD_DIM == 1   ? 0
                                     : PD_DIM == 2 ? 2
                                                   : 7)
};

#ifdef PDI_INTERNAL
/* Bond weights of the uncorrected model, and the moments of a complete family. */
typedef struct pdi_surface_correction {
    const pd_bond_force *bonds; /* weights without factors */
    double axial_moment;       /* [m^(d+1)] sum w r n_0^4 V of a whole family */
    double length;             /* [m] root of sum w r V over sum w/r V of a whole family */
} pdi_surface_correction;

/* Computes the multipliers share [count][PD_SURFACE_CORRECTION_MOMENTS] [-] of all points anew; zero where families are
 * complete, that is a moment is off by at most 1e-6. Jacobi-Newton sweeps over the incomplete families of real points,
 * until no multiplier changes by more than 1e-2; broken bonds count. Mirror images take reflected multipliers. 200
 * sweeps that do not converge are no error. */
PDI_FN pd_status pdi_surface_correction_solve(pd_ctx *ctx, const pdi_surface_correction *mend, double *share);
/* Correction factor [-] of a bond along xi, between 1/8 and 8, by the multipliers [PD_SURFACE_CORRECTION_MOMENTS] of
 * the end that xi starts from (own) and of the other; 1: they are zero. Both ends get the same bits. */
PDI_FN double pdi_surface_correction_bond_factor(const pdi_surface_correction *mend, const double *own,
                                                 const double *other, const double *xi);
#endif

#endif
