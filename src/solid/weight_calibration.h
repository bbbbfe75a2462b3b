/* weight_calibration: bond weights by length, by direction and by the surface correction, calibrated by sums over a
 * lattice.
 *
 * w = omega(r) beta (1 + a q) g. omega: influence function, beta: cell fraction within the horizon. q is the cubic
 * harmonic of the direction; a makes the shear modulus of a lattice isotropic (theory: eq. 15.2, with r^2 for r). g is
 * the surface correction of families at a surface, which lack bonds (theory: eq. 15.8).
 */
#ifndef PD_WEIGHT_CALIBRATION_H
#define PD_WEIGHT_CALIBRATION_H
#include "core/vec.h"
#include "solid/bond_weights.h"

#ifdef PDI_INTERNAL
/* Surface correction g of bonds. */
typedef enum pdi_weight_calibration_correction {
    PDI_WEIGHT_CALIBRATION_NONE = 0, /* g = 1 */
    PDI_WEIGHT_CALIBRATION_ENERGY,   /* energy method: by the strain energy of uniaxial strains along the axes */
    PDI_WEIGHT_CALIBRATION_VOLUME    /* volume method: 2 V_0/(V_i + V_j), V: volumes of families */
} pdi_weight_calibration_correction;

/* Sums over a complete family of the lattice; n = xi/r. */
typedef struct pdi_weight_calibration_sums {
    double weighted_volume; /* [m^(d+2)] sum w r^2 V */
    double axis;   /* [m^(d+2)] sum w r^2 n_0^4 V */
    double cross;  /* [m^(d+2)] sum w r^2 n_0^2 n_1^2 V */
    double volume; /* [m^d] sum beta V, beta: what lies within the horizon */
    double min_weight; /* [-] least w of all bonds */
} pdi_weight_calibration_sums;

typedef struct pdi_weight_calibration {
    const pd_body *body;
    pd_influence influence;
    pdi_weight_calibration_correction correction;
    double anisotropy;                 /* [-] a */
    const double *family_moments;      /* [count][PD_DIM] energy along each axis, or volume, of families; NULL: no
                                        * correction.      Work */
    pdi_weight_calibration_sums whole; /* zero without a spacing */
} pdi_weight_calibration;

/* q(xi) = sum n_d^4 - 3/(d + 2), n = xi/r, square = r^2: its mean over all directions is zero. 0 in 1D. */
static inline double pdi_weight_calibration_cubic_harmonic(const double *xi, double square)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += xi[d] * xi[d] * xi[d] * xi[d] / (square * square);
    return PD_DIM > 1 ? sum - 3.0 / (PD_DIM + 2.0) : 0.0;
}
/* Surface correction g of a bond along xi; own, other [PD_DIM]: positive moments of both ends along the axes, bulk:
 * that of a complete family along any axis. g = (sum n_d^2/f_d^2)^(-1/2), with the mean f_d of bulk/own_d and
 * bulk/other_d: an ellipsoid between the axes (Madenci and Oterkus 2014, ch. 4; Le and Bobaru 2018). */
PDI_FN double pdi_weight_calibration_correction_factor(const double *own, const double *other, const double *xi,
                                                       double bulk);
/* Volume of a lattice cell [m^d]. */
static inline double pdi_weight_calibration_cell_volume(const pd_body *body)
{
    double volume = 1.0;
    for (int d = 0; d < PD_DIM; d++) volume *= body->spacing;
    return volume;
}
/* Number of lattice offsets in the box around a family, the point itself and the corners beyond the horizon
 * included. */
PDI_FN int pdi_weight_calibration_count_offsets(const pd_body *body);
/* Lattice offset number k: xi [m]. Returns |xi|^2 [m2]; 0: the point itself. */
PDI_FN double pdi_weight_calibration_get_offset(const pd_body *body, int k, double *xi);
/* Largest over smallest fracture energy crack(self, n) over 64 crack normals n (not of unit length), which cover the
 * directions of a lattice; 1: it is zero. */
PDI_FN double pdi_weight_calibration_compute_anisotropy(double (*crack)(const void *self, const double *n),
                                                        const void *self);
/* Sets the coefficient a (isotropic 1, in 2D and 3D; otherwise it stays, 0 at first) and the sums over a complete
 * family; without a spacing it does nothing. PD_ERR_ARGUMENT: the least weight of a complete family is not positive; a
 * and the sums are set then. */
PDI_FN pd_status pdi_weight_calibration_calibrate(pd_ctx *ctx, pdi_weight_calibration *weigh, int isotropic);
/* Computes the weights of all bonds into `weights`, which is built before, with the surface correction unless it is
 * NONE. Both ends of a bond get the same number. Broken bonds get weights and count in the correction as others do. */
PDI_FN pd_status pdi_weight_calibration_compute_weights(pd_ctx *ctx, const pdi_weight_calibration *weigh,
                                                        pd_bond_weights *weights);
#endif

#endif
