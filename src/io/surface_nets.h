/* surface_nets: surface mesh of a set of cells of a 3D grid, smoothed (surface nets, Gibson 1998).
 *
 * A vertex lies between eight cells of which some belong to the set. It starts at the mean of the points where the
 * edges between the cell centres cross the surface, and is moved towards its neighbours without leaving the cube of the
 * eight centres. So the steps of the cells vanish, and the surface stays within one cell of its place. Outside the grid
 * nothing belongs to the set: a set that reaches a side is closed there by a plane face.
 */
#ifndef PD_SURFACE_NETS_H
#define PD_SURFACE_NETS_H
#include "core/base.h"

#ifdef PDI_APP_INTERNAL
/* The grid and the set of cells. */
typedef struct pdi_surface_nets_desc {
    int n[3];                /* number of cells */
    double lo[3], h[3];      /* [m] low corner of the grid, size of a cell */
    /* Volume fraction of the cell i[3] that belongs to the set: 0 or less: none, 1: all of it. It sets the position of
     * the surface in a cell, which is at most at its centre. */
    double (*fraction)(const void *user, const int *i);
    /* Value of the face between a cell `in` of the set and its neighbour `out`, which may lie outside of the grid; NaN:
     * no value; NULL: no face has a value. */
    double (*value)(const void *user, const int *in, const int *out);
    const void *user;
} pdi_surface_nets_desc;

/* The mesh: quadrilaterals. Zero-initialise. */
typedef struct pdi_surface_nets_mesh {
    int64_t vertex_count, vertex_capacity; /* number of vertices, and capacity */
    double *x;                             /* [vertex_capacity][3] [m] positions of vertices */
    double *vertex_value;                  /* [vertex_capacity] [-] mean value of the faces at a vertex; NaN: none */
    int64_t face_count, face_capacity, value_capacity; /* number of faces, and capacities */
    int32_t *face_vertex; /* [face_capacity][4] vertices of each face, counterclockwise seen from outside */
    double *face_value;   /* [value_capacity] [-] values of faces */
    /* [face_capacity][4][3] [-] outward unit normals of each face at its vertices; they jump at edges */
    float *corner_normal;
} pdi_surface_nets_mesh;

/* Zero `shell` and build the smoothed mesh with normals and values, in new memory; on failure nothing stays. An empty
 * set has a mesh without vertices. PD_ERR_SIZE: more vertices than int32 counts; PD_CANCELLED. */
PDI_FN pd_status pdi_surface_nets_build(pd_ctx *ctx, const pdi_surface_nets_desc *desc, pdi_surface_nets_mesh *shell);
/* Free the mesh. A zeroed one is allowed. */
PDI_FN void pdi_surface_nets_free(pd_ctx *ctx, pdi_surface_nets_mesh *shell);
#endif

#endif
