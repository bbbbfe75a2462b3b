/* facets: a closed triangle surface (STL) in 3D, and the signed distance to it.
 *
 * The surface is closed when each edge has as many triangles in one direction as in the other. Corners are merged when
 * they are identical or, if the surface is open otherwise, when they lie within 3e-6 of its extent. Triangles connected
 * by edges form a shell. Normals point outward: overlapping or nested shells are one body, and a shell with inward
 * normals bounds a cavity of the body around it. A surface that is inside out as a whole is flipped.
 *
 * The distance is that to the nearest triangle, found in a bounding volume hierarchy for each shell. A point is inside
 * where the winding number of the shells is positive, from a ray along axis 0. The crossing test is half-open in the
 * plane normal to the ray and gives the same answer for both triangles at an edge, so a ray through an edge or a vertex
 * needs no special case. Inside overlapping bodies the distance is a lower bound of the true one.
 */
#ifndef PD_FACETS_H
#define PD_FACETS_H
#include "core/array_registry.h"

typedef struct pd_facets {
    int32_t count;   /* triangles */
    int32_t tree_nodes; /* nodes of the trees; box 0 holds all; the first child of box k is k + 1 */
    double *corner;  /* [count][3][3] [m] triangles; those of a box are contiguous */
    double *box;     /* [count][6] [m] low corner, high corner */
    int32_t *first_triangle; /* [count] first triangle of a box */
    int32_t *triangle_count; /* [count] number of triangles of a box */
    int32_t *second_child;   /* [count] second child of a box; 0: a leaf */
    int32_t shells;  /* connected surfaces */
    int32_t *root;   /* [shells] root box of each tree */
    int8_t *orientation; /* [shells] 1: normals point outward, -1: the shell bounds a cavity */
    int flipped;         /* 1: the input was inside out, its triangles were flipped */
    int32_t merged;      /* corners of the input that were merged with others nearby */
} pd_facets;

#define pd_facets_build PD_NAME(pd_facets_build)
#define pd_facets_free PD_NAME(pd_facets_free)

/* Builds the surface from `count` triangles, corner [count][3][3] [m], which are copied; all zero after a failure.
 * Triangles with two corners at one point and pairs that lie on each other are left out. PD_ERR_ARGUMENT: below 4 or
 * above INT32_MAX/9 triangles, a coordinate that is not finite or of 1e30 m or more. PD_ERR_GEOMETRY: the surface is
 * not closed (the message has the place), a shell is inside out and in no other, or there is no volume. */
PD_API pd_status pd_facets_build(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *facets);
PD_API void pd_facets_free(pd_ctx *ctx, pd_facets *facets);

#ifdef PDI_INTERNAL
/* Signed distance [m] of the point x[3] [m] from the surface, negative inside. Exact to rounding, but inside
 * overlapping bodies a lower bound; a distance of at most 1e-14 of the largest coordinate of the surface is returned as
 * 0. */
PDI_FN double pdi_facets_distance(const pd_facets *facets, const double *x);
/* First intersection of the segment x + t xi, t <= 1, with the surface at t > `after`: returns t, or HUGE_VAL without
 * one. `after` is at least 0. A segment that passes an edge within PDI_FACETS_EDGE_TOLERANCE counts as intersecting;
 * one parallel to the plane of a triangle does not intersect it. */
PDI_FN double pdi_facets_find_crossing(const pd_facets *facets, const double *x, const double *xi, double after);
/* Memory [byte] of all arrays of the surface. */
PDI_FN int64_t pdi_facets_bytes(const pd_facets *facets);
#endif

#endif
