/* shape: see shape.h
 *
 * Sources: signed distances of primitives and their minimum/maximum algebra as in Ricci 1973 and Hart 1996 (sphere
 * tracing).
 */
#include "lattice/shape.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>

/* [-] Rounding error of a distance over the largest coordinate: 16 units of double precision. */
#define PDI_SHAPE_ROUNDING (16.0 * DBL_EPSILON)

/* Signed distance [m] of x from the axis-aligned box lo .. hi, exact. */
static double pdi_shape_box_distance(const double *lo, const double *hi, const double *x)
{
    double outside[PD_DIM], inside = -HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) {
        double beyond = pd_max(lo[d] - x[d], x[d] - hi[d]);
        outside[d] = pd_max(beyond, 0.0);
        inside = pd_max(inside, beyond);
    }
    return inside > 0.0 ? pdi_vec_norm(outside) : inside;
}

/* 1: the lower (upper 0) or upper (upper 1) face of a shape across axis d, at the coordinate `face` [m], lies on or
 * behind a plane of the frame f where shapes continue, and so is no surface. */
static int pdi_shape_is_face_continued(const pdi_shape_continued_box *f, int d, int upper, double face)
{
    if (!(f->sides >> (2 * d + upper) & 1)) return 0;
    return upper ? face >= f->hi[d] - f->tolerance : face <= f->lo[d] + f->tolerance;
}

/* Signed distance [m] of x from box s, whose faces behind planes of the frame are moved away by the distance between
 * the planes. */
static double pdi_shape_box_distance_continued(const pd_shape *s, const pdi_shape_continued_box *f, const double *x)
{
    double lo[PD_DIM], hi[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        double length = f->hi[d] - f->lo[d];
        lo[d] = pdi_shape_is_face_continued(f, d, 0, s->a[d]) ? f->lo[d] - length : s->a[d];
        hi[d] = pdi_shape_is_face_continued(f, d, 1, s->b[d]) ? f->hi[d] + length : s->b[d];
    }
    return pdi_shape_box_distance(lo, hi, x);
}

/* Signed distance [m] of x from an unbounded cylinder (2D: a disc or a slab). */
static double pdi_shape_cylinder_distance(const pd_shape *s, const double *x)
{
    double radial[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) radial[d] = PD_DIM > 1 && d == s->axis ? 0.0 : x[d] - s->a[d];
    return pdi_vec_norm(radial) - s->radius;
}

/* Signed distance [m] of x from a half-space. */
static double pdi_shape_half_space_distance(const pd_shape *s, const double *x)
{
    double offset[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) offset[d] = x[d] - s->a[d];
    return pdi_vec_dot(offset, s->b) / pdi_vec_norm(s->b);
}

/* Signed distance [m] of x from a half-space. A face normal to an axis, on or behind a plane of the frame, is moved
 * away by the distance between the planes, so that all points between them are on one side of it. */
static double pdi_shape_half_space_distance_continued(const pd_shape *s, const pdi_shape_continued_box *f,
                                                      const double *x)
{
    int axis = -1, axes = 0;
    double at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        at[d] = x[d];
        if (!(fabs(s->b[d]) > 0.0)) continue;
        axis = d;
        axes++;
    }
    if (axes != 1) return pdi_shape_half_space_distance(s, x);
    double length = f->hi[axis] - f->lo[axis];
    if (pdi_shape_is_face_continued(f, axis, 0, s->a[axis])) at[axis] += length;
    else if (pdi_shape_is_face_continued(f, axis, 1, s->a[axis])) at[axis] -= length;
    return pdi_shape_half_space_distance(s, at);
}

/* 1: voxel i[] of the mask is set. Voxels outside of the mask are empty. */
static int pdi_shape_is_voxel_set(const pd_shape *s, const int64_t *i)
{
    size_t cell = 0, stride = 1;
    for (int d = 0; d < PD_DIM; d++) {
        if (i[d] < 0 || i[d] >= s->mask_size[d]) return 0;
        cell += (size_t)i[d] * stride;
        stride *= (size_t)s->mask_size[d];
    }
    return s->mask[cell] != 0;
}

/* Signed distance [m] of x from a voxel mask: to the nearest voxel of the other value, at most the shortest edge of a
 * voxel (only direct neighbours can be nearer); outside at least the distance to the box of the mask. */
static double pdi_shape_voxel_distance(const pd_shape *s, const double *x)
{
    double hi[PD_DIM], nearest = HUGE_VAL;
    int64_t at[PD_DIM];
    int neighbours = 1;
    for (int d = 0; d < PD_DIM; d++) {
        hi[d] = s->a[d] + s->mask_size[d] * s->b[d];
        double cell = floor((x[d] - s->a[d]) / s->b[d]);
        at[d] = (int64_t)pd_max(-2.0, pd_min(cell, (double)s->mask_size[d] + 1.0));
        nearest = pd_min(nearest, s->b[d]);
        neighbours *= 3;
    }
    double box = pdi_shape_box_distance(s->a, hi, x);
    int value = pdi_shape_is_voxel_set(s, at);
    for (int k = 0; k < neighbours && box < nearest; k++) {
        double lo[PD_DIM], up[PD_DIM];
        int64_t j[PD_DIM];
        int rest = k;
        for (int d = 0; d < PD_DIM; d++) {
            j[d] = at[d] + rest % 3 - 1;
            rest /= 3;
            lo[d] = s->a[d] + (double)j[d] * s->b[d];
            up[d] = lo[d] + s->b[d];
        }
        if (pdi_shape_is_voxel_set(s, j) != value)
            nearest = pd_min(nearest, pd_max(pdi_shape_box_distance(lo, up, x), 0.0));
    }
    return value ? -nearest : pd_max(nearest, box);
}

/* Signed distance [m] of x from shape `index`, set operations by minimum and maximum of their children; frame NULL: no
 * planes behind which shapes continue (they matter for boxes and half-spaces alone). HUGE_VAL: no type, or facets
 * outside of 3D. */
static double pdi_shape_signed_distance(const pd_shape *shapes, int index, const pdi_shape_continued_box *frame,
                                        const double *x)
{
    const pd_shape *s = &shapes[index];
    double offset[PD_DIM], distance;
    switch (s->type) {
    case PD_SHAPE_BOX:
        return frame ? pdi_shape_box_distance_continued(s, frame, x) : pdi_shape_box_distance(s->a, s->b, x);
    case PD_SHAPE_BALL:
        for (int d = 0; d < PD_DIM; d++) offset[d] = x[d] - s->a[d];
        return pdi_vec_norm(offset) - s->radius;
    case PD_SHAPE_CYLINDER: return pdi_shape_cylinder_distance(s, x);
    case PD_SHAPE_HALF_SPACE:
        return frame ? pdi_shape_half_space_distance_continued(s, frame, x) : pdi_shape_half_space_distance(s, x);
    case PD_SHAPE_VOXELS: return pdi_shape_voxel_distance(s, x);
    case PD_SHAPE_FACETS: return PD_DIM == 3 ? pdi_facets_distance(s->facets, x) : HUGE_VAL;
    case PD_SHAPE_COMPLEMENT: return -pdi_shape_signed_distance(shapes, s->child[0], frame, x);
    case PD_SHAPE_UNION:
    case PD_SHAPE_INTERSECT:
    case PD_SHAPE_DIFFERENCE:
        distance = pdi_shape_signed_distance(shapes, s->child[0], frame, x);
        for (int c = 1; c < s->child_count; c++) {
            double other = pdi_shape_signed_distance(shapes, s->child[c], frame, x);
            if (s->type == PD_SHAPE_UNION) distance = pd_min(distance, other);
            else distance = pd_max(distance, s->type == PD_SHAPE_DIFFERENCE ? -other : other);
        }
        return distance;
    case PD_SHAPE_NONE: break;
    }
    return HUGE_VAL;
}

double pd_shape_distance(const pd_shape *shapes, int index, const double *x)
{
    return pdi_shape_signed_distance(shapes, index, NULL, x);
}

double pd_shape_surface_tolerance(const double *h, const double *x)
{
    double largest = 0.0;
    for (int d = 0; d < PD_DIM; d++) largest = pd_max(largest, fabs(x[d]));
    return pd_max(PD_SHAPE_TOLERANCE * pdi_vec_min(h), PDI_SHAPE_ROUNDING * largest);
}

PDI_FN double pdi_shape_distance_continued(const pd_shape *shapes, int index, const pdi_shape_continued_box *frame,
                                           const double *x)
{
    return pdi_shape_signed_distance(shapes, index, frame, x);
}

/* t when it is larger than `after` and smaller than `best`, else `best`. */
static double pdi_shape_nearer_crossing(double t, double after, double best)
{
    return t > after && t < best ? t : best;
}

/* First intersection, at t > after, of the line x + t xi [m] with a sphere or a cylinder; axis `along` (-1: none) is
 * not counted in the radius. A line that is tangent to the surface within `tie` [m] has one intersection. HUGE_VAL:
 * none. */
static double pdi_shape_find_round_crossing(const pd_shape *s, int along, const double *x, const double *xi,
                                            double after, double tie)
{
    double square = 0.0, linear = 0.0, constant = -s->radius * s->radius;
    for (int d = 0; d < PD_DIM; d++) {
        double offset = x[d] - s->a[d];
        if (d == along) continue;
        square += xi[d] * xi[d];
        linear += offset * xi[d];
        constant += offset * offset;
    }
    double discriminant = linear * linear - square * constant;
    if (!(square > 0.0)) return HUGE_VAL;
    if (fabs(discriminant) <= 2.0 * s->radius * tie * square)
        return pdi_shape_nearer_crossing(-linear / square, after, HUGE_VAL);
    if (!(discriminant > 0.0)) return HUGE_VAL;
    double first = pdi_shape_nearer_crossing((-linear - sqrt(discriminant)) / square, after, HUGE_VAL);
    return pdi_shape_nearer_crossing((-linear + sqrt(discriminant)) / square, after, first);
}

/* First intersection, at t > after, of the line x + t xi [m] with the surface of one primitive (of a box: with the
 * planes of its faces; of a triangle surface: t <= 1 only); HUGE_VAL: none, or s is a voxel mask or set operation. */
static double pdi_shape_find_primitive_crossing(const pd_shape *s, const double *x, const double *xi, double after,
                                                double tie)
{
    double best = HUGE_VAL, offset[PD_DIM];
    switch (s->type) {
    case PD_SHAPE_BOX:
        for (int d = 0; d < PD_DIM; d++) {
            if (!(fabs(xi[d]) > 0.0)) continue;
            best = pdi_shape_nearer_crossing((s->a[d] - x[d]) / xi[d], after, best);
            best = pdi_shape_nearer_crossing((s->b[d] - x[d]) / xi[d], after, best);
        }
        return best;
    case PD_SHAPE_BALL: return pdi_shape_find_round_crossing(s, -1, x, xi, after, tie);
    case PD_SHAPE_CYLINDER: return pdi_shape_find_round_crossing(s, PD_DIM > 1 ? s->axis : -1, x, xi, after, tie);
    case PD_SHAPE_HALF_SPACE:
        for (int d = 0; d < PD_DIM; d++) offset[d] = s->a[d] - x[d];
        if (fabs(pdi_vec_dot(xi, s->b)) > 0.0)
            best = pdi_shape_nearer_crossing(pdi_vec_dot(offset, s->b) / pdi_vec_dot(xi, s->b), after, best);
        return best;
    case PD_SHAPE_FACETS: return PD_DIM == 3 ? pdi_facets_find_crossing(s->facets, x, xi, after) : HUGE_VAL;
    default: return HUGE_VAL;
    }
}

PDI_FN double pdi_shape_find_crossing(const pd_shape *shapes, int index, const double *x, const double *xi,
                                      double after, double tie)
{
    double best = HUGE_VAL;
    for (int k = 0; k <= index; k++)
        best = pdi_shape_nearer_crossing(pdi_shape_find_primitive_crossing(&shapes[k], x, xi, after, tie), after, best);
    return best <= 1.0 ? best : HUGE_VAL;
}

PDI_FN int pdi_shape_is_convex(const pd_shape *shapes, int index)
{
    const pd_shape *s = &shapes[index];
    if (s->type == PD_SHAPE_UNION || s->type == PD_SHAPE_INTERSECT) {
        if (s->type == PD_SHAPE_UNION && s->child_count > 1) return 0;
        for (int c = 0; c < s->child_count; c++)
            if (!pdi_shape_is_convex(shapes, s->child[c])) return 0;
        return 1;
    }
    return s->type == PD_SHAPE_BOX || s->type == PD_SHAPE_BALL || s->type == PD_SHAPE_CYLINDER ||
           s->type == PD_SHAPE_HALF_SPACE;
}

int pd_shape_is_smooth(const pd_shape *shapes, int index)
{
    const pd_shape *s = &shapes[index];
    if (s->type == PD_SHAPE_VOXELS) return 0;
    int children = s->type >= PD_SHAPE_UNION ? s->child_count : 0;
    for (int c = 0; c < children; c++)
        if (!pd_shape_is_smooth(shapes, s->child[c])) return 0;
    return 1;
}

PDI_COLD_BEGIN
/* PD_ERR_ARGUMENT: not a < b on an axis, or b - a is not finite. k: index for the message. */
static pd_status pdi_shape_check_box(pd_ctx *ctx, const pd_shape *s, int k)
{
    for (int d = 0; d < PD_DIM; d++)
        if (!(s->a[d] < s->b[d]) || !isfinite(s->b[d] - s->a[d]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "shape",
                           "shape %d (box) goes from %g m to %g m on axis %d, expected a < b", k, s->a[d], s->b[d], d);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: point a is not finite. k, name: index and type for the message, here and below. */
static pd_status pdi_shape_check_centre(pd_ctx *ctx, const pd_shape *s, int k, const char *name)
{
    for (int d = 0; d < PD_DIM; d++)
        if (!isfinite(s->a[d]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (%s) has point a = %g m on axis %d, expected a "
                           "finite one", k, name, s->a[d], d);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: the centre of a ball or cylinder is not finite, its radius not positive and finite, or the axis of a
 * cylinder not 0, 1 or 2 (in any dimension). */
static pd_status pdi_shape_check_round(pd_ctx *ctx, const pd_shape *s, int k, const char *name)
{
    PD_TRY(pdi_shape_check_centre(ctx, s, k, name));
    if (!(s->radius > 0.0) || !isfinite(s->radius))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (%s) has radius r = %g m, expected > 0", k, name,
                       s->radius);
    if (s->type == PD_SHAPE_CYLINDER && (s->axis < 0 || s->axis > 2))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (%s) has axis %d, expected 0, 1 or 2", k, name,
                       s->axis);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: point or normal of a half-space is not finite, or the normal is zero. */
static pd_status pdi_shape_check_half_space(pd_ctx *ctx, const pd_shape *s, int k)
{
    PD_TRY(pdi_shape_check_centre(ctx, s, k, "half-space"));
    double length = pdi_vec_norm(s->b);
    if (!(length > 0.0) || !isfinite(length))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (half-space) has a normal b of length %g, expected a "
                       "finite one > 0", k, length);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: a voxel mask is missing, its corner is not finite, its size is below 1 or its spacing not positive
 * and finite. */
static pd_status pdi_shape_check_voxels(pd_ctx *ctx, const pd_shape *s, int k)
{
    PD_TRY(pdi_shape_check_centre(ctx, s, k, "voxels"));
    if (!s->mask) return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (voxels) has no mask", k);
    for (int d = 0; d < PD_DIM; d++) {
        if (s->mask_size[d] < 1)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "shape",
                           "shape %d (voxels) has n = %d cells on axis %d, expected at "
                           "least 1",
                           k, s->mask_size[d], d);
        if (!(s->b[d] > 0.0) || !isfinite(s->b[d]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (voxels) has spacing b = %g m on axis %d, "
                           "expected > 0", k, s->b[d], d);
    }
    return PD_OK;
}

/* PD_ERR_ARGUMENT: a set operation has the wrong number of children (complement 1, difference 2 to 8, others 1 to 8),
 * or one that is not an earlier shape. */
static pd_status pdi_shape_check_children(pd_ctx *ctx, const pd_shape *shapes, int k, const char *name)
{
    const pd_shape *s = &shapes[k];
    int max = (int)(sizeof s->child / sizeof s->child[0]);
    int min = s->type == PD_SHAPE_DIFFERENCE ? 2 : 1;
    if (s->type == PD_SHAPE_COMPLEMENT) max = 1;
    if (s->child_count < min || s->child_count > max)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (%s) has %d children, expected %d to %d", k, name,
                       s->child_count, min, max);
    for (int c = 0; c < s->child_count; c++)
        if (s->child[c] < 0 || s->child[c] >= k)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (%s) has child %d, expected the index of an "
                           "earlier shape", k, name, s->child[c]);
    return PD_OK;
}

/* PD_ERR_ARGUMENT: the parameters of shape k do not fit its type, or it has no type; facets outside of 3D or without a
 * surface. */
static pd_status pdi_shape_check(pd_ctx *ctx, const pd_shape *shapes, int k)
{
    const pd_shape *s = &shapes[k];
    switch (s->type) {
    case PD_SHAPE_BOX: return pdi_shape_check_box(ctx, s, k);
    case PD_SHAPE_BALL: return pdi_shape_check_round(ctx, s, k, "ball");
    case PD_SHAPE_CYLINDER: return pdi_shape_check_round(ctx, s, k, "cylinder");
    case PD_SHAPE_HALF_SPACE: return pdi_shape_check_half_space(ctx, s, k);
    case PD_SHAPE_VOXELS: return pdi_shape_check_voxels(ctx, s, k);
    case PD_SHAPE_FACETS:
        if (PD_DIM == 3 && s->facets && s->facets->count > 0) return PD_OK;
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d (facets) in %dD with%s a surface, expected 3D and a "
                       "surface", k, PD_DIM, s->facets ? "" : "out");
    case PD_SHAPE_UNION: return pdi_shape_check_children(ctx, shapes, k, "union");
    case PD_SHAPE_INTERSECT: return pdi_shape_check_children(ctx, shapes, k, "intersection");
    case PD_SHAPE_DIFFERENCE: return pdi_shape_check_children(ctx, shapes, k, "difference");
    case PD_SHAPE_COMPLEMENT: return pdi_shape_check_children(ctx, shapes, k, "complement");
    case PD_SHAPE_NONE: break;
    }
    return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "shape %d has type %d, which is none", k, (int)s->type);
}

pd_status pd_shape_validate(pd_ctx *ctx, const pd_shape *shapes, int count)
{
    int evaluations[PD_SHAPE_MAX];
    if (count < 0 || (count > 0 && !shapes))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "shape", "%d shapes without an array", count);
    if (count > PD_SHAPE_MAX)
        return pd_fail(ctx, PD_ERR_SIZE, "shape", "%d shapes, expected at most %d", count, PD_SHAPE_MAX);
    for (int k = 0; k < count; k++) {
        PD_TRY(pdi_shape_check(ctx, shapes, k));
        evaluations[k] = 1;
        for (int c = 0; shapes[k].type >= PD_SHAPE_UNION && c < shapes[k].child_count; c++)
            evaluations[k] += evaluations[shapes[k].child[c]];
        /* shared children unfold: without this bound a short array could take forever */
        if (evaluations[k] > PD_SHAPE_MAX_EVALUATIONS)
            return pd_fail(ctx, PD_ERR_SIZE, "shape", "shape %d unfolds to %d shapes, expected at most %d: "
                           "children are shared too often", k, evaluations[k], PD_SHAPE_MAX_EVALUATIONS);
    }
    return PD_OK;
}
PDI_COLD_END

#undef PDI_SHAPE_ROUNDING
