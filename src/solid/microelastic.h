/* microelastic: bond-based material: a bond is a spring, and breaks at a critical stretch.
 *
 * The bond of the points i and j puts the force density  c w s Y/|Y| V_j  on i, with the stretch s = (|Y| - r)/r and
 * Y = xi + eta. Its modulus c, the weights and the critical stretch follow from sums over the lattice, not from
 * integrals over a ball: the Young modulus of an infinite lattice is exact, it is the same in all directions, and so is
 * the mean energy that a crack takes (theory: 15.2). Poisson's ratio is 1/4, in plane stress 1/3.
 *
 * Sources: Silling and Askari 2005 (prototype microelastic brittle material); Le and Bobaru 2018 (energy and volume
 * methods).
 */
#ifndef PD_MICROELASTIC_H
#define PD_MICROELASTIC_H
#include "solid/correspondence.h"
#include "solid/surface_correction.h"
#include "solid/material_interface.h"

/* Surface correction: how families at a surface, which lack bonds, get the stiffness of the bulk. */
typedef enum pd_microelastic_surface {
    /* factors restore the moments of a complete family (15.4, surface_correction.h); 1D: energy */
    PD_MICROELASTIC_MOMENTS = 0,
    PD_MICROELASTIC_ENERGY, /* energy method: factors along each axis (15.8) */
    PD_MICROELASTIC_VOLUME, /* volume method: 2 V_0/(V_i + V_j), V: volumes of families */
    PD_MICROELASTIC_NONE    /* nothing */
} pd_microelastic_surface;

typedef struct pd_microelastic_desc {
    double young;    /* [Pa] E */
    double fracture; /* [J/m2] energy of a crack per area; 0: nothing breaks */
    pd_plane plane;  /* of 2D */
    pd_influence influence;
    pd_microelastic_surface surface;
} pd_microelastic_desc;

typedef struct pd_microelastic {
    pd_microelastic_desc desc;
    pd_body *body;      /* whose bonds break */
    double modulus;     /* [N/m^(2d)] c, the micromodulus */
    /* [-] a: weights have the factor 1 + a q, q = sum n_a^4 - 3/(d + 2); makes shear isotropic */
    double isotropy;
    double critical;    /* [-] stretch at which bonds break; 0: none */
    double anisotropy;  /* [-] largest energy of a crack over the least one, all directions */
    double stiffness_bound; /* [m^(d-1)] bound of sum w/r n n V of all families; 1D: 0 */
    /* [count][PD_SURFACE_CORRECTION_MOMENTS] [-] multipliers of the surface correction; NULL: another method */
    double *multiplier;
    pd_bond_weights weights; /* w */
    pd_bond_force springs;   /* forces of bonds */
    double *last_u;          /* [count][PD_DIM] [m] displacements of the last forces that a solver has asked for */
    double released;    /* [J] (per m in 2D, per m2 in 1D) energy of the bonds that broke, as they did */
} pd_microelastic;

#define pd_microelastic_build PD_NAME(pd_microelastic_build)
#define pd_microelastic_force PD_NAME(pd_microelastic_force)
#define pd_microelastic_energy PD_NAME(pd_microelastic_energy)
#define pd_microelastic_material PD_NAME(pd_microelastic_material)
#define pd_microelastic_free PD_NAME(pd_microelastic_free)

/* The body is borrowed; it has a spacing, whose lattice the constants are for, and no period. Its broken bonds count in
 * the weights, but give no force. After an error the material is empty. PD_ERR_ARGUMENT: E not positive and finite,
 * `fracture` negative or not finite, a method of surfaces out of range, no spacing, a period. */
PD_API pd_status pd_microelastic_build(pd_ctx *ctx, pd_body *body, const pd_microelastic_desc *desc,
                                       pd_microelastic *material);
/* force [count][PD_DIM] [N/m3] of displacements u [count][PD_DIM] [m] of any size. breaks 1: bonds whose stretch is >
 * the critical one break, have no force, and add their energy at u to `released`; none where `critical` is 0. Returns
 * how many broke, each counted once. Forces that are not finite are not reported. Source: theory, eq. 15.1. */
PD_API int64_t pd_microelastic_force(const pd_ctx *ctx, pd_microelastic *material, const double *u, int breaks,
                                     double *force);
/* Energy [J] (per m in 2D, per m2 in 1D) of the unbroken bonds at displacements u [count][PD_DIM] [m]; sum over all
 * points, mirror images too. */
PD_API double pd_microelastic_energy(const pd_ctx *ctx, const pd_microelastic *material, const double *u);
/* The pd_material_interface table of the material: displacements of any size; `force` breaks no bonds. It has no
 * stress. Under pressure the derivative of its forces may be indefinite; its blocks are positive. PD_RETRY of `force`:
 * a bond has no length. */
PD_API pd_material_interface pd_microelastic_material(pd_microelastic *material);
PD_API void pd_microelastic_free(pd_ctx *ctx, pd_microelastic *material);

#ifdef PDI_INTERNAL
/* Describes the arrays and the released energy of a material. */
PDI_FN void pdi_microelastic_list(pdi_array_visitor *owner, void *material);
/* Fracture energy [J/m2] of a crack with the normal n (any length) through the lattice, mean over its positions. */
PDI_FN double pdi_microelastic_crack_energy(const pd_microelastic *material, const double *n);
/* Surface vector c [1/m] of point i: a uniform stress P has about the force density P c (theory: eq. 15.9). Broken
 * bonds count. */
PDI_FN void pdi_microelastic_compute_edge(const pd_microelastic *material, int32_t i, double *edge);
/* Longest stable explicit step [s] for a density [kg/m3], by the larger stiffness of a complete family and of
 * stiffness_bound. Broken bonds count. */
PDI_FN double pdi_microelastic_stable_step(const pd_microelastic *material, double density);
#endif

#endif
