/* shape: signed distances and set operations. Negative inside the shape.
 *
 * A scene is an array of shapes; later nodes of the array refer to earlier ones by index (children first), so a tree
 * is one flat array without pointers.
 */
#ifndef PD_SHAPE_H
#define PD_SHAPE_H
#include "lattice/facets.h"

typedef enum pd_shape_type {
    PD_SHAPE_NONE = 0,
    PD_SHAPE_BOX,        /* a: low corner [m], b: high corner [m] */
    PD_SHAPE_BALL,       /* a: centre, r: radius; a disc in 2D, a sphere in 3D */
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
    double r;                    /* [m] */
    int axis;
    int child[8], children;      /* indices of earlier shapes of the array */
    const uint8_t *mask;         /* PD_SHAPE_VOXELS: non-zero is inside, axis 0 fastest; borrowed */
    const pd_facets *facets;     /* PD_SHAPE_FACETS: the surface; borrowed */
    int n[PD_DIM];
} pd_shape;

#define pd_shape_distance PD_NAME(pd_shape_distance)

/* Most entries of an array of shapes. */
#define PD_SHAPE_MAX 256
/* Most evaluations of primitives and operations for one point. An entry that is used n times counts n times. */
#define PD_SHAPE_MAX_EVALUATIONS 4096

/* Signed distance [m] of point x to shape `index` of a validated array, negative inside. Exact for primitives (voxel
 * masks: up to one cell, beyond it a bound); a bound of the right sign inside set operations. Lipschitz constant 1. */
PD_API double pd_shape_distance(const pd_shape *shapes, int index, const double *x);
#ifdef PDI_INTERNAL
/* [m] A place that is nearer to the surface of a shape lies on it: PDI_SHAPE_TIE of the least spacing, or the rounding
 * of coordinates of that size. */
#define PDI_SHAPE_TIE 1e-9
PDI_FN double pdi_shape_tie(const double *h, const double *x);
/* 1: the place belongs to the shape. What lies on a surface does, on both sides of every body, so that mirrored, turned
 * and shifted bodies have the same nodes. */
static inline int pdi_shape_has(const pd_shape *shapes, int index, const double *h, const double *x)
{
    return pd_shape_distance(shapes, index, x) <= pdi_shape_tie(h, x);
}
/* Check the array of `count` shapes: parameters finite, radii positive, boxes not empty, children earlier.
 * PD_ERR_ARGUMENT: the first shape and parameter at fault. PD_ERR_SIZE: a limit above. */
PDI_FN pd_status pdi_shape_validate(pd_ctx *ctx, const pd_shape *shapes, int count);
/* Planes that a shape goes on behind: x_d = lo[d] (bit 2 d of `sides`) and x_d = hi[d] (bit 2 d + 1). */
typedef struct pdi_shape_frame {
    const double *lo, *hi; /* [m] */
    double slack;          /* [m] what is nearer than that to a plane lies on it */
    int sides;
} pdi_shape_frame;
/* The same between the planes, where faces of boxes and half-spaces on these planes or behind them are no surface: it
 * is at least the distance between two planes from them. */
PDI_FN double pdi_shape_framed(const pd_shape *shapes, int index, const pdi_shape_frame *frame, const double *x);
/* Where the straight line x + t xi meets a face of one of the shapes 0 .. index next: the least t > after, at most 1;
 * HUGE_VAL: nowhere. Between two such places it is on one side of each shape's surface. A ball or cylinder that it
 * comes as near to as `tie` [m], or enters no deeper, it touches at one place. Not for voxel masks. */
PDI_FN double pdi_shape_crossing(const pd_shape *shapes, int index, const double *x, const double *xi, double after,
                                 double tie);
/* 1 when the shape is convex, as its type and those of its children say. */
PDI_FN int pdi_shape_convex(const pd_shape *shapes, int index);
/* 1 when the zero level of the shape is a smooth description of the surface (no voxel mask below it). */
PDI_FN int pdi_shape_exact(const pd_shape *shapes, int index);
#endif

#endif
