/* bond_extension: the two sums over bonds of the ordinary state-based model, for batches of points.
 *
 * The first one is the moment A = sum w V e r n n of the bond extensions e of a family. The second one is the force of
 * bonds from the tensors Q of both families: t = r n.(Q_i + Q_j) n + (alpha_i + alpha_j) e along Y (theory: 14.5). Both
 * use xi, r^2 and the change of r^2 only: no square root of a length is needed.
 */
#ifndef PD_BOND_EXTENSION_H
#define PD_BOND_EXTENSION_H
#include "core/vec.h"
#include "solid/point_batch.h"

#ifdef PDI_INTERNAL
enum {
    PDI_BOND_EXTENSION_ALPHA = PDI_POINT_BATCH_STIFFNESS, /* alpha [Pa/m^(d+2)] */
    PDI_BOND_EXTENSION_Q = PDI_BOND_EXTENSION_ALPHA + 1, /* Q [Pa/m^(d+2)]: its diagonal, then twice what lies off it */
    PDI_BOND_EXTENSION_FIELDS = PDI_BOND_EXTENSION_Q + PDI_SYM_COMPONENTS
};

/* Moments A [PDI_SYM_COMPONENTS] [m^(d+2)] of the points of batch k by their unbroken bonds, as vectors of mandel.h,
 * and sum w V e^2 [m^(d+2)] into square [PD_POINT_BATCH_MAX], or NULL; both are overwritten. e = extension [m], at the
 * displacements that are set in the batches. linear 1: small displacements, 0: of any size. Returns how many points. */
PDI_FN int32_t pdi_bond_extension_compute_moment(const pd_point_batch *band, int32_t k, int linear,
                                                 double (*shape)[PD_POINT_BATCH_MAX], double *square);
/* Stores the fields of point i that the force reads: alpha [Pa/m^(d+2)], and Q as a vector of mandel.h. */
PDI_FN void pdi_bond_extension_set_fields(const pd_point_batch *band, int32_t i, double alpha, const double *q);
/* Stress [PDI_SYM_COMPONENTS] [Pa] of the points of batch k by their own families, over the reference volume: sum w V t
 * y y^T/|y|. Rows: diagonal entries, then those off the diagonal, not multiplied. Reads the fields of the force. */
PDI_FN void pdi_bond_extension_compute_stress(const pd_point_batch *band, int32_t k, int linear,
                                              double (*stress)[PD_POINT_BATCH_MAX]);
/* force [count][PD_DIM] [N/m3] of the points of batch k, from their fields and those of their neighbours; others
 * stay. */
PDI_FN void pdi_bond_extension_compute_force(const pd_point_batch *band, int32_t k, int linear, double *force);
#endif

#endif
