/* ordinary_state: ordinary state-based model (linear peridynamic solid): forces along bonds, any Poisson ratio, exact
 * moduli in complete and truncated families.
 *
 * The family of point i has the strain E_i that fits the extensions e of its bonds best: e = r n.E n + z. Its energy
 * density is that of Hooke's law for E_i, and that of springs for what is left,
 *
 *   W_i = lambda tr(E)^2/2 + mu E:E + (alpha/2) sum w V_j z^2,  alpha = d (d + 2) mu/m,  m = sum w V_j r^2.
 *
 * In a family that is the same in all directions this is the solid of Silling et al. 2007, with the bulk modulus and
 * the shear modulus as its two constants. In any other, on a lattice or at a surface, it keeps Hooke's law for all
 * strains (theory: 14.5). Other surface corrections are there for comparison.
 *
 * Sources: Silling, Epton, Weckner, Xu and Askari 2007 (linear peridynamic solid); Mitchell, Silling and Littlewood
 * 2015 (position-aware); Le and Bobaru 2018 (energy and volume methods).
 */
#ifndef PD_ORDINARY_STATE_H
#define PD_ORDINARY_STATE_H
#include "solid/point_batch.h"
#include "solid/correspondence.h"
#include "solid/material_interface.h"

/* Surface correction: how families at a surface, which lack bonds, get the stiffness of the bulk. */
typedef enum pd_ordinary_state_surface {
    PD_ORDINARY_STATE_POSITION = 0, /* the strain of the family, as above */
    PD_ORDINARY_STATE_NONE,         /* none: the model of 2007, with the weighted volume m of each family */
    PD_ORDINARY_STATE_ENERGY,       /* that model with the m of the bulk and factors along each axis (energy method) */
    PD_ORDINARY_STATE_VOLUME /* that model with the m of the bulk and factors 2 V_0/(V_i + V_j) (volume method) */
} pd_ordinary_state_surface;

typedef struct pd_ordinary_state_desc {
    double young;   /* [Pa] E */
    double poisson; /* [-] -1 < nu < 1/2; 1D takes none, and E is that of a bar */
    pd_plane plane; /* of 2D */
    pd_influence influence;
    pd_ordinary_state_surface surface;
    int linear;     /* 1: displacements are small; 0: of any size */
    /* [count] [-] factor of E of a point; NULL: 1. Borrowed, may change before an update */
    const double *stiffness_factor;
    int detach_singular; /* 1: a point whose bonds do not determine all strains loses them; 0: it is an error */
    int isotropic_off;   /* 1: weights do not depend on direction, so the shear modulus of a lattice does;
                          * PD_ORDINARY_STATE_POSITION needs no such choice */
} pd_ordinary_state_desc;

typedef struct pd_ordinary_state {
    pd_ordinary_state_desc desc;
    pd_body *body;
    double lambda, mu;  /* [Pa] stress = lambda tr(e) 1 + 2 mu e, with the lambda of the plane; 1D: E/3 each */
    double isotropy;    /* [-] a: weights have the factor 1 + a q by direction, as those of pd_microelastic */
    double anisotropy;  /* [-] of the lattice: shear modulus along its axes over that along diagonals; 0: unknown */
    double bulk_weighted_volume; /* [m^(d+2)] m of a whole family of the lattice; 0: unknown */
    /* [Pa/m2] upper bound of density times the square of the largest angular frequency */
    double frequency_bound;
    pd_bond_weights weights; /* w */
    pd_point_batch band;     /* batches of points for the sums over bonds */
    /* [count] 1: forces on real points depend on this family; 0: only those on mirror images */
    uint8_t *influential;
    double *alpha;      /* [count] [Pa/m^(d+2)] */
    double *energy_bound;   /* [count] [Pa/m^(d+2)] bound of the energy of a family over sum w V_j e^2/2 */
    /* bonds broken at points whose bonds did not determine all strains (desc.detach_singular) */
    int64_t detached_bonds;
    double *law;        /* [count][tensors] [Pa/m^(2d+4)] symmetric L: W = A.L A/2 + (alpha/2) sum w V_j e^2 */
    /* [count][PD_DIM] [1/m] as of pd_correspondence_update, best fit: exact in sum over a layer */
    double *surface_vector;
    double *last_u;     /* [count][PD_DIM] [m] displacements of the last forces */
    double *state;      /* [count][tensor] [Pa/m^(d+2)] Q of the last forces: L A, A = sum w V_j e r n n */
    double *change;     /* [count][tensor] [Pa/m^(d+2)] that of a tangent, an energy or a stress */
} pd_ordinary_state;

#define pd_ordinary_state_build PD_NAME(pd_ordinary_state_build)
#define pd_ordinary_state_material PD_NAME(pd_ordinary_state_material)
#define pd_ordinary_state_free PD_NAME(pd_ordinary_state_free)

/* The body is borrowed; broken bonds drop out, and detach_singular may break more. After an error the material is
 * empty. PD_ERR_ARGUMENT: a modulus, stiffness factor or choice out of range, the energy or volume method without a
 * spacing, a lattice whose bonds no weights make the same in all directions. PD_ERR_GEOMETRY: the bonds of a point do
 * not tell all strains (PD_ORDINARY_STATE_POSITION), there are none, or a method of surfaces leaves a strain without
 * energy; the message names the point. So does `update` of the table. */
PD_API pd_status pd_ordinary_state_build(pd_ctx *ctx, pd_body *body, const pd_ordinary_state_desc *desc,
                                         pd_ordinary_state *ordinary);
/* The pd_material_interface table of the material, linear as desc.linear; it has no moduli. The stress is that of the
 * family: sum V_j t y y^T/|y| over its deformed volume (linear: its volume); in plane stress over its area and the
 * thickness that it had. `force` returns PD_RETRY where a bond has no length. */
PD_API pd_material_interface pd_ordinary_state_material(pd_ordinary_state *ordinary);
PD_API void pd_ordinary_state_free(pd_ctx *ctx, pd_ordinary_state *ordinary);

#ifdef PDI_INTERNAL
/* Describes the arrays of the material, without those of its parts. */
PDI_FN void pdi_ordinary_state_list(pdi_array_visitor *owner, void *ordinary);
#endif

#endif
