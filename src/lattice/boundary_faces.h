/* boundary_faces: boundary of a mesh: the faces that belong to one cell only, and their areas distributed to the
 * points.
 *
 * Cells share a face where they share its nodes. Both sides of a crack or joint with duplicated nodes are boundary;
 * coincident nodes are counted. Pieces of a VTU file have separate nodes: there cells share a face where its corners
 * coincide.
 *
 * The area of a face is distributed to its cell and the cells that share a node with it, with weights w, sum w = 1,
 * whose centroid sum w x lies on the normal through the centroid of the face. So a pressure has the same moment on the
 * points as on the faces; with the area given to its own cell alone it would turn the body. Among these the weights
 * nearest to the cell alone are taken (constrained least squares; theory: 14.7).
 */
#ifndef PD_BOUNDARY_FACES_H
#define PD_BOUNDARY_FACES_H
#include "lattice/points.h"

enum { PD_BOUNDARY_FACES_MAX_CORNERS = PD_DIM == 3 ? 4 : PD_DIM }; /* maximum corners of a face */

/* A face of a cell. */
typedef struct pd_boundary_faces_face {
    int64_t node[4];     /* its nodes, ascending; INT64_MAX behind the last one */
    double x[PD_BOUNDARY_FACES_MAX_CORNERS][PD_DIM]; /* [unit of the file] corners in turn */
    int32_t cell;        /* index of the point of its cell */
    int32_t piece;       /* number of the piece of the file */
    int8_t corners;      /* number of corners */
    int8_t orientation;  /* 1: the area vector by its corners points outward, -1: inward */
} pd_boundary_faces_face;

/* All faces of a mesh. Zero it at the start. */
typedef struct pd_boundary_faces {
    int64_t count, capacity;       /* number of faces, and capacity */
    int32_t piece;                 /* piece of the file that the next faces belong to */
    pd_boundary_faces_face *face; /* [capacity] */
} pd_boundary_faces;

#define pd_boundary_faces_add_cell PD_NAME(pd_boundary_faces_add_cell)
#define pd_boundary_faces_finish PD_NAME(pd_boundary_faces_finish)
#define pd_boundary_faces_free PD_NAME(pd_boundary_faces_free)

/* Append the faces of a cell with their nodes, corners, outward orientation and the present piece; none for
 * PD_POINTS_CELL_NONE. node[], corner[][3]: ids and coordinates [unit of the file] of its corners, copied; cell: index
 * of its point. Nothing is checked. On failure (memory) some faces of the cell may be appended. */
PD_API pd_status pd_boundary_faces_add_cell(pd_ctx *ctx, pd_boundary_faces *skin, pd_points_cell_type form,
                                            const int64_t *node, const double *const *corner, int32_t cell);
/* Find the boundary faces, those whose nodes no other face has and that no other piece of the file repeats. Adds their
 * outward areas [m^(d-1)] to boundary_area of the points, sets their face_corner (which they do not have yet) and
 * face_count, and counts coincident faces and nodes (not above INT32_MAX/4 faces). Lengths times scale are in metres.
 * Sorts the faces; those that cells share are lost. Fails only for memory. */
PD_API pd_status pd_boundary_faces_finish(pd_ctx *ctx, pd_boundary_faces *skin, double scale, pd_points *points);
/* Free the faces. A zeroed object is allowed. */
PD_API void pd_boundary_faces_free(pd_ctx *ctx, pd_boundary_faces *skin);

#endif
