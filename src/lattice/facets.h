/* facets: a closed surface of triangles in 3D, and the signed distance to it.
 *
 * Each edge of the surface belongs to two triangles that go along it in opposite senses; corners are the same when
 * their bits are. The distance is that to the nearest triangle, found in a tree of boxes. Inside is where a ray along
 * axis 0 leaves the surface once more than it enters it: edges count half-open in the plane across the ray, and both
 * triangles at an edge decide alike on which side of it the ray passes, so a ray through an edge or a corner is no
 * special case.
 */
#ifndef PD_FACETS_H
#define PD_FACETS_H
#include "core/owner.h"

typedef struct pd_facets {
    int32_t count;   /* triangles */
    int32_t boxes;   /* of the tree; box 0 holds all, the first child of a box is next to it */
    double *corner;  /* [count][3][3] [m] triangles, those of a box one after another */
    double *box;     /* [count][6] [m] low corner, high corner */
    int32_t *first;  /* [count] first triangle of a box */
    int32_t *size;   /* [count] its triangles */
    int32_t *second; /* [count] its second child; 0: it has none */
} pd_facets;

#define pd_facets_build PD_NAME(pd_facets_build)
#define pd_facets_free PD_NAME(pd_facets_free)

/* The surface of `count` triangles, corner [count][3][3] [m]. PD_ERR_ARGUMENT: none, or too many of them, a corner that
 * is not finite. PD_ERR_GEOMETRY: a triangle with two corners at one place; an edge that has not exactly two triangles
 * in opposite senses (the message has its place); no volume. */
PD_API pd_status pd_facets_build(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *facets);
PD_API void pd_facets_free(pd_ctx *ctx, pd_facets *facets);

#ifdef PDI_INTERNAL
/* Signed distance [m] of place x[3] [m], negative inside: exact but for rounding, which
 * is 0 on the surface. */
PDI_FN double pdi_facets_distance(const pd_facets *facets, const double *x);
/* Where the straight line x + t xi meets the surface next: the least t > after, at most 1; HUGE_VAL: nowhere. A line that
 * touches an edge or passes it within rounding meets it. */
PDI_FN double pdi_facets_crossing(const pd_facets *facets, const double *x, const double *xi, double after);
/* [byte] of all arrays. */
PDI_FN int64_t pdi_facets_bytes(const pd_facets *facets);
#endif

#endif
