/* shape: signed distance functions of primitives and their set operations (constructive solid geometry); negative
 * inside.
 *
 * A geometry is an array of shapes. Set operations refer to earlier entries by index (children first), so a tree is one
 * flat array without pointers.
 */
#ifndef PD_SHAPE_H
#define PD_SHAPE_H
#include "lattice/facets.h"

typedef enum pd_shape_type {
    PD_SHAPE_NONE = 0,
    PD_SHAPE_BOX,        /* a: low corner [m], b: high corner [m] */
    PD_SHAPE_BALL,       /* a: centre, radius; a disc in 2D, a sphere in 3D */
    PD_SHAPE_CYLINDER,   /* around axis `axis` (0, 1, 2) through a, radius r, unbounded along the axis. 2D is a planar
                          * cut: axis 0 the slab |y - a_y| < r, axis 1 |x - a_x| < r, axis 2 a disc. 1D: |x - a| < r */
    PD_SHAPE_HALF_SPACE, /* points with (x - a) . b < 0; b need not have unit length */
    PD_SHAPE_VOXELS,     /* mask of n[] cells from corner a with spacing b; nearest cell decides */
    PD_SHAPE_FACETS,     /* 3D: a closed surface of triangles */
    PD_SHAPE_UNION,      /* of children first .. first+count-1 in the child list */
    PD_SHAPE_INTERSECT,
    PD_SHAPE_DIFFERENCE, /* first child minus the others */
    PD_SHAPE_COMPLEMENT  /* of one child */
} pd_shape_type;

typedef struct pd_shape {
    pd_shape_type type;
    double a[PD_DIM], b[PD_DIM]; /* [m] */
    double radius;               /* [m] */
    int axis;
    int child[8], child_count;   /* indices of earlier shapes of the array */
    const uint8_t *mask;         /* PD_SHAPE_VOXELS: non-zero is inside, axis 0 fastest; borrowed */
    const pd_facets *facets;     /* PD_SHAPE_FACETS: the surface; borrowed */
    int mask_size[PD_DIM];
} pd_shape;

#define pd_shape_distance PD_NAME(pd_shape_distance)
#define pd_shape_is_smooth PD_NAME(pd_shape_is_smooth)
#define pd_shape_validate PD_NAME(pd_shape_validate)
#define pd_shape_surface_tolerance PD_NAME(pd_shape_surface_tolerance)

/* Most entries of an array of shapes. */
#define PD_SHAPE_MAX 256
/* Most evaluations of primitives and operations for one point. An entry that is used n times counts n times. */
#define PD_SHAPE_MAX_EVALUATIONS 4096

/* [-] of the smallest spacing: a point nearer than that to a surface counts as on it. */
#define PD_SHAPE_TOLERANCE 1e-9

/* Signed distance [m] of point x to shape `index` of a validated array, negative inside. Exact for primitives (voxel
 * masks: up to one cell, beyond it a bound); set operations take the minimum or maximum of their children, a bound of
 * the right sign. Lipschitz constant 1. HUGE_VAL: the shape has no type. */
PD_API double pd_shape_distance(const pd_shape *shapes, int index, const double *x);
/* [m] Distance up to which a point x counts as on a surface: the larger of PD_SHAPE_TOLERANCE of the smallest spacing
 * of h [PD_DIM] and the rounding (16 units of double precision) of the largest |coordinate| of x. */
PD_API double pd_shape_surface_tolerance(const double *h, const double *x);
/* Checks `count` shapes, which may be 0: parameters finite, radii and voxels positive, boxes and masks not empty, the
 * right number of children, all earlier in the array, facets in 3D with a surface. PD_ERR_ARGUMENT: names the first
 * shape and parameter at fault; also a negative count, or no array. PD_ERR_SIZE: PD_SHAPE_MAX or
 * PD_SHAPE_MAX_EVALUATIONS is exceeded. */
PD_API pd_status pd_shape_validate(pd_ctx *ctx, const pd_shape *shapes, int count);
/* 1: the zero level of the signed distance is a smooth description of the surface; 0: there is a voxel mask in the tree
 * of shape `index`. Edges of boxes and facets do not count. */
PD_API int pd_shape_is_smooth(const pd_shape *shapes, int index);
#ifdef PDI_INTERNAL
/* 1: the point x belongs to the shape. Points on the surface do, so that mirrored, rotated and shifted bodies have
 * the same nodes. */
static inline int pdi_shape_contains(const pd_shape *shapes, int index, const double *h, const double *x)
{
    return pd_shape_distance(shapes, index, x) <= pd_shape_surface_tolerance(h, x);
}
/* Planes of a box behind which shapes continue (periodic and mirror sides): x_d = lo[d] for bit 2 d of `sides`, and
 * x_d = hi[d] for bit 2 d + 1. */
typedef struct pdi_shape_continued_box {
    const double *lo, *hi; /* [m] */
    double tolerance;      /* [m] tolerance: a point nearer than that to a plane lies on it */
    int sides;             /* bits of the planes */
} pdi_shape_continued_box;
/* Signed distance [m] of x between the planes, where faces of boxes and half-spaces on or behind a plane of the frame
 * are no surface: they are moved away by the distance between the two planes. */
PDI_FN double pdi_shape_distance_continued(const pd_shape *shapes, int index, const pdi_shape_continued_box *frame,
                                           const double *x);
/* First intersection of the segment x + t xi [m] with the surface of one of the primitives among the shapes 0 .. index,
 * whichever of them a set operation uses: the smallest t > after, at most 1; HUGE_VAL: none. Of a box the planes of its
 * faces count, outside of the faces, too. Between two intersections the segment is on one side of each surface. A ball
 * or cylinder that it only touches within `tie` [m] has one intersection. Voxel masks are left out. */
PDI_FN double pdi_shape_find_crossing(const pd_shape *shapes, int index, const double *x, const double *xi,
                                      double after, double tie);
/* 1: the shape is convex, as its type says: a box, ball, cylinder or half-space, an intersection of such, or a union of
 * one. 0: it may not be (voxels, facets, differences, complements, other unions). */
PDI_FN int pdi_shape_is_convex(const pd_shape *shapes, int index);
#endif

#endif
