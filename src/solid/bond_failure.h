/* bond_failure: failure criteria of bonds: which bonds break at given displacements, and which is the first as a load
 * grows.
 *
 * A bond breaks when its measure reaches a critical value: its stretch, its energy (Foster, Silling and Chen 2011),
 * or the stress of its ends. The critical energy follows from the energy of a crack by sums over the lattice, so that
 * the mean over all directions of the crack is exact (theory: eq. 15.11).
 */
#ifndef PD_BOND_FAILURE_H
#define PD_BOND_FAILURE_H
#include "solid/material_interface.h"

typedef enum pd_bond_failure_kind {
    PD_BOND_FAILURE_STRETCH = 0, /* [-] (|Y| - r)/r */
    PD_BOND_FAILURE_ENERGY,      /* [J/m^(2d)] of both ends, over the part of a rim cell; of bonds that are stretched */
    PD_BOND_FAILURE_PRINCIPAL,   /* [Pa] largest principal stress, mean of both ends */
    PD_BOND_FAILURE_MISES        /* [Pa] von Mises' stress, mean of both ends */
} pd_bond_failure_kind;

/* Zero-initialise. Without a critical value and `fracture` no bond breaks. */
typedef struct pd_bond_failure_desc {
    pd_bond_failure_kind kind;
    double critical;       /* [-], [J/m^(2d)] or [Pa]; 0: from `fracture` */
    double fracture;       /* [J/m2] energy of a crack per area, for PD_BOND_FAILURE_ENERGY on a lattice */
    const uint8_t *unbreakable; /* [count] 1: bonds of the point never break; NULL: none. Borrowed */
} pd_bond_failure_desc;

typedef struct pd_bond_failure {
    pd_bond_failure_desc desc;
    pd_material_interface solid;
    double critical;   /* [-], [J/m^(2d)] or [Pa]; 0: no bond breaks */
    double anisotropy; /* [-] largest energy of a crack over the least one, all directions; 1 but for `fracture` */
    double *energy;    /* [bonds] [J/m^(2d)] work */
    double *stress;    /* [count][PD_DIM^2] [Pa] work */
    double *scalar;    /* [count] [Pa] stress of each point that counts */
    /* [count] [-], [J/m^(2d)] or [Pa] largest measure of the bonds to points with higher numbers */
    double *max_measure;
} pd_bond_failure;

/* The bond that breaks first. */
typedef struct pd_first_failure {
    int64_t bond;          /* -1: no measure is above 0 */
    int32_t from, to;      /* its points */
    double midpoint[PD_DIM]; /* [m] its middle */
    double measure;        /* [-], [J/m^(2d)] or [Pa] */
    double factor;         /* [-] on u; 0: none */
} pd_first_failure;

#define pd_bond_failure_build PD_NAME(pd_bond_failure_build)
#define pd_bond_failure_break PD_NAME(pd_bond_failure_break)
#define pd_bond_failure_find_first PD_NAME(pd_bond_failure_find_first)
#define pd_bond_failure_free PD_NAME(pd_bond_failure_free)

/* The table is copied, what it points to borrowed. Without a critical value nothing is allocated. After an error the
 * criterion is empty. PD_ERR_ARGUMENT: a kind out of range, a value that is negative or not finite, `fracture` without
 * a lattice, with another kind than PD_BOND_FAILURE_ENERGY or beside `critical`, a material without the bond energies
 * or the stress of the kind. */
PD_API pd_status pd_bond_failure_build(pd_ctx *ctx, const pd_material_interface *solid,
                                       const pd_bond_failure_desc *desc, pd_bond_failure *criterion);
/* Breaks, at both ends, bonds whose measure at u [count][PD_DIM] [m] exceeds the critical one; unbreakable points keep
 * theirs. eager 0: only those of the largest measure, within 1e-9 of it; 1: all; between: those from max - eager (max -
 * critical) on. Returns how many; 0 without a critical value. The material has to be updated afterwards. Stretch, and a
 * material with stress: where no bond exceeds it, but the gradient of the unbroken bonds of a point would stretch one
 * of its broken bonds beyond it, the point loses all bonds. */
PD_API int64_t pd_bond_failure_break(const pd_ctx *ctx, pd_bond_failure *criterion, const double *u, double eager);
/* Which bond breaks first when displacements u [count][PD_DIM] [m] grow in proportion, and by which factor on u it
 * reaches the critical value; of ties the lowest bond. Stretch: any displacements; energies grow like the square of the
 * factor and stresses like it: exact where forces are linear. bond -1 and factor 0: no critical value, or no measure
 * above 0. */
PD_API void pd_bond_failure_find_first(const pd_ctx *ctx, pd_bond_failure *criterion, const double *u,
                                       pd_first_failure *first);
PD_API void pd_bond_failure_free(pd_ctx *ctx, pd_bond_failure *criterion);

#ifdef PDI_INTERNAL
/* Describes the work arrays. */
PDI_FN void pdi_bond_failure_list(pdi_array_visitor *owner, void *criterion);
/* Fracture energy [J/m2] of a crack with the normal n (any length) through the lattice, mean over its positions. */
PDI_FN double pdi_bond_failure_crack_energy(const pd_bond_failure *criterion, const double *n);
#endif

#endif
