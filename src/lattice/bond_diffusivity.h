/* bond_diffusivity: diffusivity of each bond in a heterogeneous medium, whose diffusivity is a field with jumps across
 * a surface.
 *
 * Along a bond materials are resistances in series (theory: eq. 6.3). The surface is the zero level of a signed
 * distance; all its intersections with a bond count, so a layer thinner than a bond is not missed, and a surface may
 * lie on a node. The diffusivity of bonds near the surface is computed once, the same for both ends.
 */
#ifndef PD_BOND_DIFFUSIVITY_H
#define PD_BOND_DIFFUSIVITY_H
#include "core/array_registry.h"
#include "lattice/grid.h"

/* A scalar at the position x [m]. */
typedef double (*pd_point_fn)(void *user, const double *x);

/* Diffusivities of nodes and bonds. node_value NULL: the medium is homogeneous, nothing is stored. */
typedef struct pd_bond_diffusivity {
    const pd_stencil *stencil;
    const pd_grid *grid;
    pd_point_fn diffusivity; /* [m2/s] diffusivity */
    /* [m] signed distance from the surface where `diffusivity` jumps, Lipschitz constant 1; NULL: none */
    pd_point_fn surface_distance;
    void *user;         /* of both */
    double min_spacing; /* [m] smallest spacing */
    double *node_value; /* [total] [m2/s] diffusivity at nodes, ghosts included */
    int32_t *row_of_node; /* [total] row of a node within one bond of the surface; -1: farther away */
    double *bond_value;   /* [rows][count] [m2/s] mean diffusivity of the bonds of these nodes; NULL: no surface */
    int32_t rows;       /* nodes within one bond of the surface */
    int unit_bond[PD_DIM]; /* index of the bond of one cell in the positive direction of an axis */
} pd_bond_diffusivity;

#ifdef PDI_INTERNAL
/* Describes the arrays of pd_bond_diffusivity with one entry a node to the array registry. */
PDI_FN void pdi_bond_diffusivity_list_node_arrays(pdi_array_visitor *owner, void *object);
/* Describes the array of pd_bond_diffusivity with one entry for each bond of nodes near the surface to the array
 * registry. */
PDI_FN void pdi_bond_diffusivity_list_row_arrays(pdi_array_visitor *owner, void *object);
/* Evaluates the diffusivity `field` [m2/s] at all nodes that are not inactive (others: 0; ghosts: folded into the box),
 * and allocates and computes that of all bonds near the zero level of the signed distance `level` [m] (NULL: no
 * surface), with the correction along surfaces normal to an axis (eq. 6.4). Grid and stencil are borrowed; `media` is
 * overwritten, and the caller frees it on failure, too. PD_ERR_ARGUMENT: a diffusivity is negative, NaN or at least
 * 1e100. */
PDI_FN pd_status pdi_bond_diffusivity_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid,
                                            pd_point_fn field, pd_point_fn level, void *user,
                                            pd_bond_diffusivity *media);
PDI_FN void pdi_bond_diffusivity_free(pd_ctx *ctx, pd_bond_diffusivity *media);
/* Mean diffusivity [m2/s] of the part of bond k from node i to the fraction `end` of its length: resistances in series;
 * that of the node where the surface is farther away than this part is long, or no bond value is stored. Computed anew,
 * without the correction of eq. 6.4. */
PDI_FN double pdi_bond_diffusivity_get_part(const pd_bond_diffusivity *media, int32_t i, int k, double end);
/* Harmonic mean 2ab/(a + b) (eq. 6.2), in a form that does not overflow and gives the same bits from both ends. */
static inline double pdi_bond_diffusivity_harmonic_mean(double a, double b)
{
    double lower = a < b ? a : b, upper = a < b ? b : a;
    return upper > 0.0 ? 2.0 * lower / (1.0 + lower / upper) : 0.0;
}
/* Diffusivity [m2/s] of bond k from node i to its far end j: the stored one near the surface, else the harmonic mean of
 * both nodes. */
static inline double pdi_bond_diffusivity_get(const pd_bond_diffusivity *media, int32_t i, int32_t j, int k)
{
    int32_t row = media->bond_value ? media->row_of_node[i] : -1;
    if (row >= 0) return media->bond_value[(int64_t)row * media->stencil->count + k];
    return pdi_bond_diffusivity_harmonic_mean(media->node_value[i], media->node_value[j]);
}
#endif

#endif
