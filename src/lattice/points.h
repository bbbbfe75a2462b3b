/* points: material points with volumes and regions, and the conversion of mesh cells to such points.
 *
 * A cell becomes a point at its centroid with its volume: both are integrals of the multilinear map of the cell, which
 * 2 Gauss points along each axis integrate exactly, also for a hexahedron with faces that are not plane.
 */
#ifndef PD_POINTS_H
#define PD_POINTS_H
#include "core/base.h"

/* Material points of a body, and its surface. */
typedef struct pd_points {
    int32_t count;    /* number of points */
    int32_t capacity; /* capacity of the arrays */
    double *position; /* [count][PD_DIM] [m] */
    double *volume;   /* [count] [m^d] */
    int32_t *tag;     /* [count] region; 0: none */
    double *boundary_area; /* [count][PD_DIM] [m^(d-1)] outward area vector of the boundary faces of a point: those of
                            * its cell, distributed to the cells at their nodes so that a pressure has the same moment
                            * as on the faces; points of tables: 0. A boundary stress P gives a point the body force P
                            * surface/volume [N/m3], a pressure p -p surface/volume */
    int64_t face_count;    /* number of boundary faces: points, segments, triangles (two a quadrilateral); tables: 0 */
    double *face_corner;   /* [face_count][PD_DIM][PD_DIM] [m] their corners, as of pd_body_desc */
    int64_t coincident_faces; /* number of boundary faces that coincide with one of another cell but have other nodes:
                               * parts that touch there are not connected */
    int64_t coincident_nodes; /* number of boundary nodes that coincide with another one */
} pd_points;

/* Type of a mesh cell. Corners are numbered as in VTK and Gmsh, which agree on all types but for the side from which
 * the base of a wedge is seen. */
typedef enum pd_points_cell_type {
    PD_POINTS_CELL_NONE = 0,
    PD_POINTS_CELL_LINE,
    PD_POINTS_CELL_TRIANGLE,
    PD_POINTS_CELL_QUAD,
    PD_POINTS_CELL_TETRAHEDRON,
    PD_POINTS_CELL_HEXAHEDRON,
    PD_POINTS_CELL_WEDGE,
    PD_POINTS_CELL_PYRAMID
} pd_points_cell_type;

/* Conversion of mesh cells to points. Zero it and set points, scale and extent. */
typedef struct pd_points_converter {
    pd_points *points;
    double scale;    /* [-] factor from lengths of the file to metres */
    double extent;   /* [m] extent of the mesh, before scaling */
    double plane[3]; /* [m] coordinates of the first corner: those beyond PD_DIM must be the same in all cells */
    int has_plane;   /* 1: plane is set */
    double orientation; /* [-] orientation of the cells so far, 1 or -1; 0: unknown. The reader clears it where another
                         * surface begins */
} pd_points_converter;

#define pd_points_free PD_NAME(pd_points_free)
#define pd_points_add PD_NAME(pd_points_add)
#define pd_points_add_cell PD_NAME(pd_points_add_cell)
#define pd_points_count_corners PD_NAME(pd_points_count_corners)
#define pd_points_shrink PD_NAME(pd_points_shrink)

/* Free the points. A zeroed object is allowed. */
PD_API void pd_points_free(pd_ctx *ctx, pd_points *points);
/* Append a point at position[PD_DIM] [m] with a volume [m^d] and a region; its boundary_area is 0. Values are not
 * checked. The arrays double when they are full; PD_ERR_SIZE: beyond what int32 counts. On failure nothing changes. */
PD_API pd_status pd_points_add(pd_ctx *ctx, pd_points *points, const double *position, double volume, int32_t tag);
/* Shrink the arrays to the number of points (also none); contents stay. On failure nothing changes. */
PD_API pd_status pd_points_shrink(pd_ctx *ctx, pd_points *points);
/* Number of corners of a cell type; 0 for PD_POINTS_CELL_NONE. */
PD_API int pd_points_count_corners(pd_points_cell_type form);
/* Append a mesh cell with these corners[][3] as a point. *fault (static text), with PD_OK and no point added: the cell
 * is off the line (1D) or plane (2D) of the first one by more than 1e-9 of the extent, folded, of no volume or one out
 * of range, or turned against earlier cells; else NULL. mirrored 1: its orientation is not compared, and does not count
 * for later ones. Sets plane by the first cell, and orientation. */
PD_API pd_status pd_points_add_cell(pd_ctx *ctx, pd_points_converter *cells, pd_points_cell_type form,
                                    const double *const *corner, int mirrored, int32_t tag, const char **fault);

#ifdef PDI_INTERNAL
/* Allocate face_corner, zeroed, for that many boundary faces and set face_count. The points have no face_corner yet. On
 * failure face_count stays. */
PDI_FN pd_status pdi_points_reserve_faces(pd_ctx *ctx, pd_points *points, int64_t faces);
#endif

#endif
