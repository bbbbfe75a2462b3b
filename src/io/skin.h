/* skin: the surface of a mesh, as the faces that one cell alone has.
 *
 * Cells share a face where they share its nodes. A crack or a joint whose sides have nodes of their own is surface; the
 * nodes at one place are counted. Pieces of a VTU file have nodes of their own: there cells share a face where its
 * corners are at the same places.
 *
 * What a face bears goes to its cell and to those that share a node with it, in shares w with sum w = 1 whose centroid
 * sum w x lies on the normal through that of the face: at the centroids of cells alone pressures would have other
 * moments than on the faces, and turn the body. Shares are as near to the cell alone as that allows (theory: 8.6).
 */
#ifndef PD_SKIN_H
#define PD_SKIN_H
#include "io/points.h"

#ifdef PDI_INTERNAL
enum { PDI_SKIN_CORNERS = PD_DIM == 3 ? 4 : PD_DIM };

/* A face of a cell. */
typedef struct pdi_skin_face {
    int64_t node[4];     /* ascending; INT64_MAX behind the last one */
    double x[PDI_SKIN_CORNERS][PD_DIM]; /* [the file's unit] corners, around it */
    int32_t cell;        /* the point that the cell has become */
    int32_t part;        /* of the file */
    int8_t corners;
    int8_t sense;        /* -1: its corners go around inward */
} pdi_skin_face;

/* Faces on their way to a surface. Zero it at the start. */
typedef struct pdi_skin {
    int64_t count, room;
    int32_t part;        /* of the file, which the next faces belong to */
    pdi_skin_face *face; /* [room] */
} pdi_skin;

/* The faces of a cell. node: numbers of its corners; cell: the point that it has become. */
PDI_FN pd_status pdi_skin_add(pd_ctx *ctx, pdi_skin *skin, pdi_cell_form form, const int64_t *node,
                              const double *const *corner, int32_t cell);
/* points->surface of all cells, points->face, seams and twins; lengths are times scale in metres. Sorts the faces. */
PDI_FN pd_status pdi_skin_close(pd_ctx *ctx, pdi_skin *skin, double scale, pd_points *points);
PDI_FN void pdi_skin_free(pd_ctx *ctx, pdi_skin *skin);
#endif

#endif
