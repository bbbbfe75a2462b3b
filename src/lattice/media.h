/* media: diffusivities of bonds where the diffusivity is a field that may jump across a surface.
 *
 * Along a bond materials are resistances in series (theory: eq. 5.8). A surface is the zero level of a signed distance;
 * all its crossings of a bond count, so a layer thinner than a bond is not passed over, and a surface may lie on a
 * node. What bonds near the surface conduct is computed once, the same for both ends.
 */
#ifndef PD_MEDIA_H
#define PD_MEDIA_H
#include "core/owner.h"
#include "lattice/grid.h"

/* A number at position x [m]. */
typedef double (*pd_point_fn)(void *user, const double *x);

/* Empty without `at`. */
typedef struct pd_media {
    const pd_stencil *stencil;
    const pd_grid *grid;
    pd_point_fn field;  /* [m2/s] */
    pd_point_fn level;  /* [m] signed distance from the surface where `field` jumps, Lipschitz constant 1; NULL: none */
    void *user;         /* of both */
    double smallest;    /* [m] of the spacings */
    double *at;         /* [total] [m2/s] at nodes, ghosts included */
    int32_t *near;      /* [total] row of a node within one bond of the surface; -1: not */
    double *along;      /* [rows][count] [m2/s] mean along the bonds of these; NULL without */
    int32_t rows;
    int unit[PD_DIM];   /* bond of one cell towards + of an axis */
} pd_media;

#ifdef PDI_INTERNAL
/* Arrays of a pd_media: by the lattice, and by the rows. */
PDI_FN void pdi_media_list(pdi_owner *owner, void *object);
PDI_FN void pdi_media_row_list(pdi_owner *owner, void *object);
/* Grid and stencil are borrowed. PD_ERR_ARGUMENT: a diffusivity is negative or not finite. */
PDI_FN pd_status pdi_media_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_point_fn field,
                                 pd_point_fn level, void *user, pd_media *media);
PDI_FN void pdi_media_free(pd_ctx *ctx, pd_media *media);
/* Mean of the resistances from node i over the part 0 .. end of bond k, as a diffusivity [m2/s]. */
PDI_FN double pdi_media_part(const pd_media *media, int32_t i, int k, double end);
/* Harmonic mean (eq. 5.2): no ratio overflows, and both ends get the same bits. */
static inline double pdi_media_harmonic(double a, double b)
{
    double lower = a < b ? a : b, upper = a < b ? b : a;
    return upper > 0.0 ? 2.0 * lower / (1.0 + lower / upper) : 0.0;
}
/* Diffusivity [m2/s] of bond k from node i to j. */
static inline double pdi_media_bond(const pd_media *media, int32_t i, int32_t j, int k)
{
    int32_t row = media->along ? media->near[i] : -1;
    if (row >= 0) return media->along[(int64_t)row * media->stencil->count + k];
    return pdi_media_harmonic(media->at[i], media->at[j]);
}
#endif

#endif
