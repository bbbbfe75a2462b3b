/* visibility: which bonds the surface of a body crosses.
 *
 * The surface is given by faces: points in 1D, segments in 2D, triangles in 3D. A bond whose straight line crosses one
 * of them leaves the body (the visibility criterion: Belytschko, Lu and Gu 1994). One that only touches a corner or an
 * edge stays where lines beside it cross no face, so it passes a corner that points into the body, and is stopped by
 * faces that meet at an edge. Faces are found by bins about as wide as a bond.
 */
#ifndef PD_VISIBILITY_H
#define PD_VISIBILITY_H
#include "core/array_registry.h"

#ifdef PDI_INTERNAL
/* Faces of a surface sorted into a grid of bins, for line tests. */
typedef struct pdi_visibility {
    const double *position; /* [points][PD_DIM] [m] borrowed, as `face` */
    const double *face;     /* [faces][PD_DIM][PD_DIM] [m] corners */
    int64_t faces;
    double lo[PD_DIM], width; /* [m] of the bins */
    int32_t n[PD_DIM];
    int64_t bins, entries;
    int64_t *first;         /* [bins + 1] begin of each bin in entry */
    int32_t *entry;         /* [entries] faces that reach into a bin */
} pdi_visibility;

/* Builds the bins, bond_length [m] wide or a power of 2 times as wide: so that there are at most 8 bins per face, and
 * 64 entries per face unless one bin is left. position, face and faces are set before; without faces there are no bins.
 * PD_ERR_ARGUMENT: more than INT32_MAX/2 faces, or a corner that is not finite. */
PDI_FN pd_status pdi_visibility_build(pd_ctx *ctx, double bond_length, pdi_visibility *visibility);
/* A pd_bond_inside_fn: 1: the bond from point i along xi [m] crosses no face. A bond that only touches faces, at an
 * edge, a corner or an end of its own, is joined where one of 8 lines beside it, 1e-5 of its length away, neither
 * crosses nor touches any; in 1D it is not. user is the pdi_visibility, j is not read. */
PDI_FN int pdi_visibility_is_joined(void *user, int32_t i, int32_t j, const double *xi);
PDI_FN void pdi_visibility_free(pd_ctx *ctx, pdi_visibility *visibility);
#endif

#endif
