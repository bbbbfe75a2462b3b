/* facets: a closed surface of triangles in 3D, and the signed distance to it.
 *
 * Along each edge as many triangles go in one sense as in the other; corners are the same when their bits are, or,
 * where the surface would be open, when they lie within 3e-6 of its extent. Triangles that hang together by edges are a
 * shell. Normals point outward: shells that overlap or lie in each other are one body, and a shell whose normals point
 * inward bounds a cavity of a body that it lies in. Where all is inside out, all is turned.
 *
 * The distance is that to the nearest triangle, found in a tree of boxes for each shell. Inside is where the shells go
 * around more often outward than inward, by a ray along axis 0: edges count half-open in the plane across the ray, and
 * both triangles at an edge decide alike on which side of it the ray passes, so a ray through an edge or a corner is no
 * special case. Within bodies that overlap the distance is that to leave one of them, and not more than the true one.
 */
#ifndef PD_FACETS_H
#define PD_FACETS_H
#include "core/owner.h"

typedef struct pd_facets {
    int32_t count;   /* triangles */
    int32_t boxes;   /* of the trees; box 0 holds all, the first child of a box is next to it */
    double *corner;  /* [count][3][3] [m] triangles, those of a box one after another */
    double *box;     /* [count][6] [m] low corner, high corner */
    int32_t *first;  /* [count] first triangle of a box */
    int32_t *size;   /* [count] its triangles */
    int32_t *second; /* [count] its second child; 0: it has none */
    int32_t shells;
    int32_t *root;   /* [shells] their boxes */
    int8_t *sense;   /* [shells] 1: its normals point outward, -1: it bounds a cavity */
    int turned;      /* 1: the triangles that it was built of were inside out */
    int32_t joined;  /* corners of them that were joined with others beside them */
} pd_facets;

#define pd_facets_build PD_NAME(pd_facets_build)
#define pd_facets_free PD_NAME(pd_facets_free)

/* The surface of `count` triangles, corner [count][3][3] [m]. PD_ERR_ARGUMENT: none, or too many of them, a corner that
 * is not finite. Triangles with two corners at one place are left out. PD_ERR_GEOMETRY: an edge that has not as many
 * triangles along it as against it, or a shell that is inside out and in no other (the message has the place); no
 * volume. */
PD_API pd_status pd_facets_build(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *facets);
PD_API void pd_facets_free(pd_ctx *ctx, pd_facets *facets);

#ifdef PDI_INTERNAL
/* Signed distance [m] of place x[3] [m], negative inside: exact but for rounding, which
 * is 0 on the surface. */
PDI_FN double pdi_facets_distance(const pd_facets *facets, const double *x);
/* Where the straight line x + t xi meets the surface next: the least t > after, at most 1; HUGE_VAL: nowhere. A line
 * that touches an edge or passes it within rounding meets it. */
PDI_FN double pdi_facets_crossing(const pd_facets *facets, const double *x, const double *xi, double after);
/* [byte] of all arrays. */
PDI_FN int64_t pdi_facets_bytes(const pd_facets *facets);
#endif

#endif
