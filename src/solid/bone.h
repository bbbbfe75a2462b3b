/* bone: Young's modulus of bone by its density, and the critical stretch of a brittle bond-based solid.
 *
 * Modulus: a power law  E = a (rho/1 g/cm3)^b  of the apparent density of wet bone. A body of
 * uneven density has the modulus of one density, and factors for points (pd_finite_strain_desc.stiff,
 * pd_correspondence_desc.stiff).
 *
 * Sources: Morgan, Bayraktar and Keaveny 2003 (sites); Carter and Hayes 1977 (compact and spongy bone).
 */
#ifndef PD_BONE_H
#define PD_BONE_H
#include "solid/correspondence.h"

typedef enum pd_bone_site {
    PD_BONE_VERTEBRA = 0,
    PD_BONE_TIBIA,        /* proximal */
    PD_BONE_TROCHANTER,   /* greater */
    PD_BONE_FEMUR,        /* neck */
    PD_BONE_POOLED,       /* those four */
    PD_BONE_CARTER_HAYES  /* 3790 MPa rate^0.06 rho^3 at a strain of 1 % a second */
} pd_bone_site;

#define pd_bone_modulus PD_NAME(pd_bone_modulus)
#define pd_bone_critical_stretch PD_NAME(pd_bone_critical_stretch)

/* Young's modulus [Pa] of bone of an apparent wet density [kg/m3] by the power law of the site, without limits of its
 * range; PD_BONE_CARTER_HAYES: at a strain rate of 0.01/s. NaN: no such site, a density not positive or from 1e100. */
PD_API double pd_bone_modulus(pd_bone_site site, double density);
/* Critical stretch s [-] of a microelastic solid whose cracks take the energy `fracture` [J/m2] per area: s^2 = 3 G/(K
 * d), pi G/(3 K d), 5 G/(9 K d) in 1D, 2D, 3D, with the horizon d [m] and the bulk modulus K of that dimension, E in 1D
 * and by `plane` in 2D (Silling and Askari 2005, in 3D). Integrals over a ball; sums over a lattice with nu = 1/4 are
 * those of pd_microelastic. fracture 0: 0. NaN: young or horizon not positive, fracture negative, Poisson's ratio not
 * in (-1, 1/2). */
PD_API double pd_bone_critical_stretch(double young, double poisson, pd_plane plane, double fracture, double horizon);

#endif
