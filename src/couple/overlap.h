/* overlap: faces of a body that pass through each other, since bonds alone join its points and no contact is computed.
 *
 * Two points that lie side by side, in cells that share a face, are on two faces where no bond joins them. These
 * overlap by what is left of the distance of the points when the gap between them is closed. Others overlap when they
 * come nearer than a cell. What intact bonds are shortened by is no overlap. A point that has lost all bonds is no
 * face: nothing says where it is.
 */
#ifndef PD_OVERLAP_H
#define PD_OVERLAP_H
#include "lattice/grid.h"
#include "solid/body.h"

typedef struct pd_overlap {
    const pd_grid *grid;  /* borrowed, as all below */
    const pd_body *body;
    const int32_t *node;  /* [count] of the points */
    const int32_t *point; /* [total] of the nodes; -1: none */
    const double *stiff;  /* [count] [-] 0: the metal has gone */
    int32_t count;        /* points; further ones of the body are images */
    int32_t parts;        /* pieces of the body as it was built */
    int32_t *part;        /* [count] the piece of each point; empty with one piece */
    int32_t bins;         /* a power of two; 0: no look has been asked for */
    int32_t *bin;         /* [bins] the last point that came to it, -1: none */
    int32_t *next;        /* [count with bins] the one before it */
    double crack;         /* [m] largest overlap of faces of one piece, at the last look; 0: none */
    double most;          /* [m] the same of all looks */
    double pieces;        /* [m] that of two pieces which were apart at the start; 0: none */
    int32_t first, other; /* points of these */
} pd_overlap;

#ifdef PDI_INTERNAL
/* grid to count are set. Pieces are those that intact bonds join now. */
PDI_FN pd_status pdi_overlap_build(pd_ctx *ctx, pd_overlap *overlap);
/* Room for looks. */
PDI_FN pd_status pdi_overlap_prepare(pd_ctx *ctx, pd_overlap *overlap);
/* Look, with displacements u [count][PD_DIM] [m]. */
PDI_FN void pdi_overlap_look(pd_overlap *overlap, const double *u);
PDI_FN void pdi_overlap_free(pd_ctx *ctx, pd_overlap *overlap);
#endif

#endif
