/* extension: the two sums over bonds that forces along bonds need, for many points at a time.
 *
 * The first one is the shape A = sum w V e r n n of the extensions e of a family, the second one the force of bonds
 * that the tensors Q of both of their families pull: t = r n.(Q_i + Q_j) n + (alpha_i + alpha_j) e along Y (theory:
 * 8.9). Both know a bond by xi, r^2 and the change of its square: no length is needed.
 */
#ifndef PD_EXTENSION_H
#define PD_EXTENSION_H
#include "core/vec.h"
#include "solid/band.h"

#ifdef PDI_INTERNAL
enum {
    PDI_EXTENSION_ALPHA = PDI_BAND_SHARE,        /* alpha [Pa/m^(d+2)] */
    PDI_EXTENSION_STATE = PDI_EXTENSION_ALPHA + 1, /* Q [Pa/m^(d+2)]: its diagonal, then twice what lies off it */
    PDI_EXTENSION_FIELDS = PDI_EXTENSION_STATE + PDI_SYM
};

/* A of the points of band k, as vectors of strain.h, for displacements of any size or small ones (linear 1), and
 * sum w V e^2 [PD_BAND_MOST], or NULL. Returns how many points the band has. */
PDI_FN int32_t pdi_extension_shape(const pd_band *band, int32_t k, int linear, double (*shape)[PD_BAND_MOST],
                                   double *square);
/* Fields of point i for the force: alpha, and Q as a vector of strain.h. */
PDI_FN void pdi_extension_offer(const pd_band *band, int32_t i, double alpha, const double *q);
/* Stress of the families of band k over the volume that they had, sum w V t y y^T/|y| with what the family of a point
 * has of t: its diagonal and then what lies off it. */
PDI_FN void pdi_extension_stress(const pd_band *band, int32_t k, int linear, double (*stress)[PD_BAND_MOST]);
/* force [count][PD_DIM] [N/m3] of the points of band k. */
PDI_FN void pdi_extension_force(const pd_band *band, int32_t k, int linear, double *force);
#endif

#endif
