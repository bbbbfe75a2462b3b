/* finite_strain: correspondence model (non-ordinary state-based) of large strains.
 *
 * The family of point i has the gradient  F = 1 + (sum w V_j eta xi^T) K^-1  and a bond its own,
 * F_b = F + (Y - F xi) xi^T/r^2,  Y = xi + eta.  The energy of a point is the mean of  psi(F_b)  over its bonds, and
 * forces are its derivative (theory: 14.4). Plain correspondence, which takes F for all bonds, has zero-energy
 * modes; it is here with the stabilisation of Silling, and without.
 *
 * Under J2 each bond of a family has its own plastic state, with plain correspondence each point. Broken bonds change
 * the gradients of the others, but not their plastic strains: the energy balance then holds to some percent, not
 * exactly.
 *
 * Sources: Breitzman and Dayal 2018; Behzadinasab and Foster 2020; Silling 2017 (stability of correspondence).
 */
#ifndef PD_FINITE_STRAIN_H
#define PD_FINITE_STRAIN_H
#include "solid/constitutive_law.h"
#include "solid/material_interface.h"
#include "solid/bond_weights.h"

typedef enum pd_zero_energy_control {
    PD_FINITE_STRAIN_BOND_GRADIENT = 0, /* each bond has its own gradient */
    PD_FINITE_STRAIN_SILLING,           /* plain, with a penalty on the non-uniform part of bond deformation */
    PD_FINITE_STRAIN_PLAIN
} pd_zero_energy_control;

typedef struct pd_finite_strain_desc {
    pd_constitutive_law law;
    pd_influence influence;
    pd_zero_energy_control control;
    double penalty;          /* [-] PD_FINITE_STRAIN_SILLING: penalty stiffness over that of a bond-based solid */
    const double *stiffness_factor; /* [count] [-] factors of the energy of points, and so of moduli and yield stress;
                                     * NULL: 1. Borrowed, may change before an update */
    int store_tangent; /* 1: material tangents are stored, in 80 B (2D) or 360 B (3D) a bond, and products with
                        * the tangent are 4 to 6 times as fast under Hencky and J2; 0: computed each time */
    /* 1: a point whose bonds do not span all directions loses them; 0: it is an error */
    int detach_singular;
} pd_finite_strain_desc;

typedef struct pd_finite_strain {
    pd_finite_strain_desc desc;
    pd_body *body;
    double lambda, mu; /* [Pa] of small strains: stress = lambda tr(e) 1 + 2 mu e, with the lambda of the plane */
    double penalty_stiffness; /* [Pa/m^(d+2)] of PD_FINITE_STRAIN_SILLING */
    pd_bond_weights weights; /* w */
    /* [count] 1: forces on real points depend on this family; 0: only those on mirror images */
    uint8_t *influential;
    int32_t *reverse_bond; /* [bonds] number of the reverse bond in the family of the other end */
    double *shape;     /* [count][PD_DIM^2] [1/m^(d+2)] K^-1 */
    double *weight_sum;     /* [count] [m^d] sum w V_j */
    double *surface_vector; /* [count][PD_DIM] [1/m] a first Piola-Kirchhoff stress P has the force P edge */
    double *u;         /* [count][PD_DIM] [m] of the last forces */
    double *gradient;  /* [count][PD_DIM^2] [-] F - 1 of them */
    double *force_state; /* [bonds][PD_DIM] [N/m^(2d)] force states of the bonds: work */
    double *work;      /* [count] [Pa] of sweeps */
    double *state;     /* [bonds or count][state] [-] J2 */
    double *moduli;    /* [bonds or count][] [Pa] with desc.store_tangent: derivative of the stress at u */
    int tangent_valid; /* 1: moduli are those of u */
    double *out_of_plane_stress; /* [count] [Pa] in 2D: out-of-plane normal stress of the last stresses */
    double plastic_work;         /* [J] (per m in 2D, per m2 in 1D) plastic work up to the last state */
    int64_t detached_bonds; /* bonds broken at points whose bonds did not span all directions (desc.detach_singular) */
} pd_finite_strain;

#define pd_finite_strain_build PD_NAME(pd_finite_strain_build)
#define pd_finite_strain_material PD_NAME(pd_finite_strain_material)
#define pd_finite_strain_plastic_strain PD_NAME(pd_finite_strain_plastic_strain)
#define pd_finite_strain_free PD_NAME(pd_finite_strain_free)

/* The body is borrowed; with detach_singular it may lose bonds. After an error the material is empty. PD_ERR_ARGUMENT:
 * a modulus, a stiffness factor, the penalty (PD_FINITE_STRAIN_SILLING), the control or the law is out of range.
 * PD_ERR_GEOMETRY, without detach_singular: the bonds of a point do not span all directions, or it has none (the
 * message names it). */
PD_API pd_status pd_finite_strain_build(pd_ctx *ctx, pd_body *body, const pd_finite_strain_desc *desc,
                                        pd_finite_strain *finite);
/* The table for solvers. Loads by surface_vector are dead: t = P n per area and normal of the reference. Where a bond
 * is turned inside out the energy is infinite and the stress NaN. A failed update leaves the material without use. It
 * stores which bonds of the body are broken. */
PD_API pd_material_interface pd_finite_strain_material(pd_finite_strain *finite);
/* strain [count] [-]: equivalent plastic strain as last committed, weighted mean over the unbroken bonds of a family,
 * with plain correspondence that of the point. 0 but for J2, and with bond gradients for a point without bonds. */
PD_API void pd_finite_strain_plastic_strain(const pd_ctx *ctx, const pd_finite_strain *finite, double *strain);
PD_API void pd_finite_strain_free(pd_ctx *ctx, pd_finite_strain *finite);

#ifdef PDI_INTERNAL
/* Describes the arrays of the material; plastic states and plastic work are stored. */
PDI_FN void pdi_finite_strain_list(pdi_array_visitor *owner, void *finite);
#endif

#endif
