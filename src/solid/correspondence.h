/* correspondence: bond-associated correspondence model (non-ordinary state-based) of small strains, with J2 plasticity.
 *
 * The family of point i has the displacement gradient  H = sum w V_j eta (K^-1 xi)^T,  K = sum w V_j xi xi^T,  with
 * eta = u_j - u_i. A bond has its own, H_b = H + (eta - H xi) xi^T/r^2, which gives the bond its true elongation: there
 * are no zero-energy modes. The energy density is W = (1/w_0) sum w V_j psi(H_b), w_0 = sum w V_j, and forces are its
 * derivative: they are symmetric, and there is no parameter. Linear fields are exact in every family, whole or cut, for
 * any Poisson ratio.
 *
 * Sources: Breitzman and Dayal 2018 (bond-level deformation gradient); Behzadinasab and Foster 2020 (semi-Lagrangian
 * correspondence, eq. 16); Silling, Epton, Weckner, Xu and Askari 2007 (states).
 */
#ifndef PD_CORRESPONDENCE_H
#define PD_CORRESPONDENCE_H
#include "solid/point_batch.h"
#include "solid/j2_plasticity.h"
#include "solid/material_interface.h"

typedef enum pd_plane {
    PD_PLANE_STRAIN = 0,
    PD_PLANE_STRESS
} pd_plane;

typedef struct pd_correspondence_desc {
    double young;   /* [Pa] E */
    double poisson; /* [-] -1 < nu < 1/2; 1D takes none, and E is that of a bar */
    pd_plane plane; /* of 2D */
    pd_influence influence;
    const double *stiffness_factor; /* [count] [-] factor of E and of the yield stress of a point; NULL: 1. Borrowed,
                                     * may change before pd_correspondence_update */
    double yield;        /* [Pa] von Mises yield stress; 0: no plasticity */
    double hardening;    /* [Pa] isotropic hardening modulus */
    int detach_singular; /* 1: a point with a singular shape tensor loses its bonds; 0: it is an error */
} pd_correspondence_desc;

typedef struct pd_correspondence {
    pd_correspondence_desc desc;
    pd_body *body;
    double lambda, mu; /* [Pa] stress = lambda tr(e) 1 + 2 mu e, with the lambda of the plane */
    pd_bond_weights weights; /* w */
    /* [count] 1: forces on real points depend on this family; 0: only those on mirror images */
    uint8_t *influential;
    double *shape;     /* [count][PD_DIM^2] [1/m^(d+2)] K^-1 */
    double *second_moment;    /* [count][PD_DIM^2] [-] (1/w_0) sum w V_j n n^T, n = xi/r */
    double *fourth_moment;    /* [count][15, 2D 5, 1D 1] [-] mean of n n n n: its monomials, by powers of z, then y */
    double *weight_sum;       /* [count] [m^d] w_0 */
    double *surface_vector;   /* [count][PD_DIM] [1/m] see pd_correspondence_update */
    pd_point_batch band;      /* batches of points for the sums over bonds */
    pd_j2_plasticity plastic; /* plastic strains; plastic.count 0: none */
    int64_t detached_bonds; /* bonds broken at points whose bonds did not span all directions (desc.detach_singular) */
} pd_correspondence;

#define pd_correspondence_build PD_NAME(pd_correspondence_build)
#define pd_correspondence_update PD_NAME(pd_correspondence_update)
#define pd_correspondence_force PD_NAME(pd_correspondence_force)
#define pd_correspondence_energy PD_NAME(pd_correspondence_energy)
#define pd_correspondence_stress PD_NAME(pd_correspondence_stress)
#define pd_correspondence_material PD_NAME(pd_correspondence_material)
#define pd_correspondence_free PD_NAME(pd_correspondence_free)

/* The body is borrowed; with detach_singular it may lose bonds. After an error the material is empty. PD_ERR_ARGUMENT:
 * E not positive and finite, nu not in (-1, 1/2) (not read in 1D), yield stress or hardening negative or not finite, or
 * a yield stress in plane stress. PD_ERR_GEOMETRY: as of pd_correspondence_update. */
PD_API pd_status pd_correspondence_build(pd_ctx *ctx, pd_body *body, const pd_correspondence_desc *desc,
                                         pd_correspondence *elastic);
/* Bonds or stiffness factors have changed: recomputes shape tensors and surface vectors c. A uniform stress P gives the
 * point the force density P c: zero in the bulk, and over the layer at a surface of normal n sum V c = -n per area: a
 * traction P n is the load -P c, in balance to rounding (theory: eq. 14.5). PD_ERR_GEOMETRY: the unbroken bonds of a
 * point do not span all directions (least pivot of K up to 1e-6 of its largest entry), or there are none; the material
 * is then of no use. With detach_singular such points lose their bonds instead, which detached_bonds counts. */
PD_API pd_status pd_correspondence_update(pd_ctx *ctx, pd_correspondence *elastic);
/* force [count][PD_DIM] [N/m3] of displacements u [count][PD_DIM] [m] (theory: eq. 14.4). Entries of images behind
 * planes of symmetry are of no use, and stay where a batch has images alone. With plasticity the plastic strain is that
 * of a step from the last committed state to u (theory, 14.3); the state stays. */
PD_API void pd_correspondence_force(const pd_ctx *ctx, const pd_correspondence *elastic, const double *u,
                                    double *force);
/* Elastic energy [J] (per m in 2D, per m2 in 1D) of displacements u [count][PD_DIM] [m] (theory: eq. 14.3), sum over
 * all points, mirror images too. With plasticity less what the plastic strain of the step to u relieves. Points without
 * bonds have none. */
PD_API double pd_correspondence_energy(const pd_ctx *ctx, const pd_correspondence *elastic, const double *u);
/* stress [count][PD_DIM^2] [Pa] of all points at displacements u [count][PD_DIM] [m], times their stiffness factors: by
 * the gradient of the family, with plasticity by the mean gradient of its bonds and the plastic strain of the step to
 * u. Zero for a point without bonds. */
PD_API void pd_correspondence_stress(const pd_ctx *ctx, const pd_correspondence *elastic, const double *u,
                                     double *stress);
/* The pd_material_interface table of the material, which is borrowed. Without plasticity it is linear and has bond
 * energies; with plasticity it has dissipated and plastic_strain instead. It has no force states and no
 * dynamic_force. */
PD_API pd_material_interface pd_correspondence_material(pd_correspondence *elastic);
PD_API void pd_correspondence_free(pd_ctx *ctx, pd_correspondence *elastic);

#ifdef PDI_INTERNAL
/* Describes the arrays of the material, without those of its parts. */
PDI_FN void pdi_correspondence_list(pdi_array_visitor *owner, void *elastic);
#endif

#endif
