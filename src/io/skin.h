/* skin: the surface of a mesh, as the faces that one cell alone has.
 *
 * Cells share a face where they share its nodes. A crack or a joint whose sides have nodes of their own is surface, and
 * so is what lies between two pieces of a VTU file.
 *
 * What a face bears goes to its cell and to those that share a node with it, in shares w with sum w = 1 whose centroid
 * sum w x lies on the normal through that of the face: at the centroids of cells alone pressures would have other
 * moments than on the faces, and turn the body. Shares are as near to the cell alone as that allows (theory: 8.6).
 */
#ifndef PD_SKIN_H
#define PD_SKIN_H
#include "io/points.h"

#ifdef PDI_INTERNAL
/* A face of a cell. */
typedef struct pdi_skin_face {
    int64_t node[4];     /* ascending; INT64_MAX behind the last one */
    double area[PD_DIM]; /* outward [of the file's unit to the power of PD_DIM - 1] */
    double middle[PD_DIM]; /* its centroid [the file's unit] */
    int32_t cell;        /* the point that the cell has become */
} pdi_skin_face;

/* Faces on their way to a surface. Zero it at the start. */
typedef struct pdi_skin {
    int64_t count, room;
    pdi_skin_face *face; /* [room] */
} pdi_skin;

/* The faces of a cell. node: numbers of its corners; cell: the point that it has become. */
PDI_FN pd_status pdi_skin_add(pd_ctx *ctx, pdi_skin *skin, pdi_cell_form form, const int64_t *node,
                              const double *const *corner, int32_t cell);
/* points->surface of all cells; lengths are times scale in metres. Sorts the faces. */
PDI_FN pd_status pdi_skin_close(pd_ctx *ctx, pdi_skin *skin, double scale, pd_points *points);
PDI_FN void pdi_skin_free(pd_ctx *ctx, pdi_skin *skin);
#endif

#endif
