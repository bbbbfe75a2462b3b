/* points: places with volumes and regions, and cells of meshes that become such points.
 *
 * A cell becomes a point at its centroid with its volume: both are integrals of the multilinear map of the cell, which
 * Gauss points integrate exactly, faces of a hexahedron that are not plane included.
 */
#ifndef PD_POINTS_H
#define PD_POINTS_H
#include "core/base.h"

typedef struct pd_points {
    int32_t count;
    int32_t room;     /* length of the arrays */
    double *position; /* [count][PD_DIM] [m] */
    double *volume;   /* [count] [m^d] */
    int32_t *tag;     /* [count] region; 0: none */
    double *surface;  /* [count][PD_DIM] [m^(d-1)] outward area of those faces that one cell alone has, shared with the
                       * cells at their nodes so that a pressure has the moment that it has on the faces; points of
                       * tables: 0. Under a stress P a point bears the load P surface/volume [N/m3], under a pressure p
                       * -p surface/volume */
    int64_t faces;    /* those faces: points, segments, triangles (two for a quadrilateral); tables: 0 */
    double *face;     /* [faces][PD_DIM][PD_DIM] [m] their corners, as of pd_body_desc */
    int64_t seams;    /* of these faces those of two cells at one place which have nodes of their own: parts that touch
                       * there are not joined */
    int64_t twins;    /* nodes of the surface at the place of another one */
} pd_points;

#define pd_points_free PD_NAME(pd_points_free)

PD_API void pd_points_free(pd_ctx *ctx, pd_points *points);

#ifdef PDI_INTERNAL
/* Append a point. PD_ERR_SIZE: more than int32 counts. */
PDI_FN pd_status pdi_points_add(pd_ctx *ctx, pd_points *points, const double *position, double volume, int32_t tag);
/* Room for that many faces. */
PDI_FN pd_status pdi_points_face(pd_ctx *ctx, pd_points *points, int64_t faces);
/* Arrays as long as the points are many. */
PDI_FN pd_status pdi_points_finish(pd_ctx *ctx, pd_points *points);

/* Corners of the forms are numbered as in VTK and Gmsh, which agree on all of them but for the side from which the base
 * of a wedge is seen. */
typedef enum pdi_cell_form {
    PDI_CELL_NONE = 0,
    PDI_CELL_LINE,
    PDI_CELL_TRIANGLE,
    PDI_CELL_QUAD,
    PDI_CELL_TETRAHEDRON,
    PDI_CELL_HEXAHEDRON,
    PDI_CELL_WEDGE,
    PDI_CELL_PYRAMID
} pdi_cell_form;

/* Cells on their way to points. Zero it and set points, scale and extent. */
typedef struct pdi_cells {
    pd_points *points;
    double scale;    /* [-] of lengths */
    double extent;   /* [m] of the mesh, before scaling */
    double level[3]; /* [m] coordinates of the first corner: those beyond PD_DIM are the same everywhere */
    int started;
    double sign;     /* [-] which way the cells of a surface or line turn; 0: not known. The reader clears it where
                      * another surface begins */
} pdi_cells;

PDI_FN int pdi_points_corners(pdi_cell_form form);
/* Append the cell of these corners [3] [m]. *fault: why it is refused, NULL when it is not. mirrored 1: a cell of
 * negative volume is good. */
PDI_FN pd_status pdi_cells_add(pd_ctx *ctx, pdi_cells *cells, pdi_cell_form form, const double *const *corner,
                               int mirrored, int32_t tag, const char **fault);
#endif

#endif
