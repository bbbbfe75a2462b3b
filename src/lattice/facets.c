/* facets: see facets.h
 *
 * Sources: bounding volume hierarchies and closest points of triangles as in Ericson 2005, Real-Time Collision
 * Detection, ch. 5 and 6.
 */
#include "lattice/facets.h"
#include "lattice/vertex_merge.h"
#include "core/disjoint_sets.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Largest number of triangles in a leaf of the tree. */
#define PDI_FACETS_LEAF_SIZE 4
/* [-] Rounding error of a distance over the largest coordinate of the surface: about 50 units of double precision. */
#define PDI_FACETS_ROUNDING 1e-14
/* [-] Degenerate triangles: (twice the area)^2 is below this fraction of the fourth power of the longest edge. They are
 * treated as three segments. */
#define PDI_FACETS_SLIVER 1e-16
/* Number of overlapping bodies for which the distance is evaluated as documented; with more it is a bound. */
#define PDI_FACETS_MAX_OVERLAP 16
/* Approximate number of triangles whose orientation is tested, and the smallest component along axis 0 of a unit normal
 * that a ray along axis 0 can test. */
#define PDI_FACETS_ORIENTATION_SAMPLES 20000
#define PDI_FACETS_MIN_NORMAL 0.1
/* Stack size of tree traversals: each level halves the triangles, of which there are fewer than 2^31. */
#define PDI_FACETS_MAX_DEPTH 64
/* [-] A segment that misses an edge by this fraction of its length still intersects the triangle; for boxes, a fraction
 * of the largest coordinate. A superfluous intersection does no harm. */
#define PDI_FACETS_EDGE_TOLERANCE 1e-9

/* Describes the arrays of the surface (name, size, unit) to the array registry. */
static void pdi_facets_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_facets *facets = (pd_facets *)object;
    PDI_ARRAY(owner, facets, corner, (int64_t)facets->count * 9, "m");
    PDI_ARRAY(owner, facets, box, (int64_t)facets->count * 6, "m");
    PDI_ARRAY(owner, facets, first_triangle, facets->count, "1");
    PDI_ARRAY(owner, facets, triangle_count, facets->count, "1");
    PDI_ARRAY(owner, facets, second_child, facets->count, "1");
    PDI_ARRAY(owner, facets, root, facets->shells, "1");
    PDI_ARRAY(owner, facets, orientation, facets->shells, "1");
}

PDI_FN int64_t pdi_facets_bytes(const pd_facets *facets)
{
    pd_facets copy = *facets;
    return pdi_array_registry_count_bytes(pdi_facets_list_arrays, &copy);
}

/* ---- is the surface closed? ---- */

/* A directed edge of a triangle, for sorting. */
typedef struct pdi_facets_edge {
    int32_t low, high; /* vertices */
    int32_t corner;    /* corner (3 triangle + 0..2) where it begins */
    int32_t is_forward; /* 1: from low to high */
} pdi_facets_edge;

/* A triangle by its sorted vertices, to find pairs of coincident triangles. */
typedef struct pdi_facets_face {
    int32_t vertex[3]; /* ascending */
    int32_t orientation; /* 1: the sorted order is the orientation of the triangle, -1: the opposite one */
    int32_t triangle;    /* triangle */
} pdi_facets_face;

/* Working arrays while the surface is built. */
typedef struct pdi_facets_work {
    const double *corner; /* [count][3][3] [m] as they were given */
    int32_t count;
    int32_t *vertex;      /* [3 count] vertex of a corner: the first corner at that point */
    int32_t *shell;       /* [count] shell of a triangle: its first triangle; -1: left out */
    int32_t *parent;      /* [3 count] parents of disjoint sets, and other scratch */
    int32_t merged;       /* corners merged with a vertex nearby */
    /* unmatched edges: more triangles in one direction than in the other. The first of them: */
    int32_t unmatched;
    /* its first corner, its triangles, those in the direction of that corner */
    int32_t unmatched_corner, unmatched_triangles, unmatched_forward;
} pdi_facets_work;

/* qsort: order edges by vertices, then direction, then corner. */
static int pdi_facets_compare_edges(const void *a, const void *b)
{
    const pdi_facets_edge *p = (const pdi_facets_edge *)a, *q = (const pdi_facets_edge *)b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    if (p->is_forward != q->is_forward) return p->is_forward < q->is_forward ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

/* qsort: order triangles by vertices, then orientation, then number. */
static int pdi_facets_compare_faces(const void *a, const void *b)
{
    const pdi_facets_face *p = (const pdi_facets_face *)a, *q = (const pdi_facets_face *)b;
    for (int k = 0; k < 3; k++)
        if (p->vertex[k] != q->vertex[k]) return p->vertex[k] < q->vertex[k] ? -1 : 1;
    if (p->orientation != q->orientation) return p->orientation < q->orientation ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

/* Sets w->shell: -1 for triangles with two equal vertices and for pairs of coincident triangles of opposite orientation
 * (touching bodies; of several as many as pair up), which are left out; for others the number of the triangle, a shell
 * of its own. Only out of memory fails. */
static pd_status pdi_facets_remove_degenerate(pd_ctx *ctx, pdi_facets_work *w)
{
    pdi_facets_face *face = NULL;
    int32_t count = 0;
    PD_TRY(PD_NEW(ctx, "facets", w->count, face));
    for (int32_t k = 0; k < w->count; k++) {
        const int32_t *v = w->vertex + 3 * (int64_t)k;
        w->shell[k] = v[0] == v[1] || v[1] == v[2] || v[2] == v[0] ? -1 : k;
        if (w->shell[k] < 0) continue;
        int first = v[0] < v[1] ? v[0] < v[2] ? 0 : 2 : v[1] < v[2] ? 1 : 2;
        int32_t second = v[(first + 1) % 3], third = v[(first + 2) % 3];
        face[count].vertex[0] = v[first];
        face[count].vertex[1] = second < third ? second : third;
        face[count].vertex[2] = second < third ? third : second;
        face[count].orientation = second < third ? 1 : -1;
        face[count++].triangle = k;
    }
    qsort(face, (size_t)count, sizeof *face, pdi_facets_compare_faces);
    for (int32_t k = 0, next; k < count; k = next) {
        int32_t back = 0, size;
        for (next = k; next < count && memcmp(face[next].vertex, face[k].vertex, sizeof face[k].vertex) == 0; next++)
            back += face[next].orientation < 0; /* they come first */
        size = next - k;
        int32_t pairs = back < size - back ? back : size - back;
        for (int32_t p = 0; p < pairs; p++) w->shell[face[k + p].triangle] = w->shell[face[next - 1 - p].triangle] = -1;
    }
    PD_DELETE(ctx, w->count, face);
    return PD_OK;
}

/* From the sorted directed edges edge[count]: unites triangles that share an edge into shells (w->shell: first triangle
 * of the shell), and counts the edges with more triangles in one direction than in the other (w->unmatched, with data
 * of the first one). Overwrites w->parent. */
static void pdi_facets_find_shells(pdi_facets_work *w, const pdi_facets_edge *edge, int32_t count)
{
    w->unmatched = 0;
    for (int32_t k = 0; k < w->count; k++) w->parent[k] = k;
    for (int32_t k = 0, next; k < count; k = next) {
        int32_t forward = 0;
        for (next = k; next < count && edge[next].low == edge[k].low && edge[next].high == edge[k].high; next++) {
            forward += edge[next].is_forward;
            pdi_disjoint_sets_merge(w->parent, edge[k].corner / 3, edge[next].corner / 3);
        }
        if (2 * forward == next - k) continue;
        if (!w->unmatched++) {
            w->unmatched_corner = edge[k].corner;
            w->unmatched_triangles = next - k;
            w->unmatched_forward = edge[k].is_forward ? forward : next - k - forward;
        }
    }
    for (int32_t k = 0; k < w->count; k++)
        if (w->shell[k] >= 0) w->shell[k] = pdi_disjoint_sets_find_root(w->parent, k);
}

/* Leaves out degenerate triangles, and finds shells and unmatched edges of all others by a sorted list of their edges.
 * PD_OK also with unmatched edges. */
static pd_status pdi_facets_match_edges(pd_ctx *ctx, pdi_facets_work *w)
{
    pdi_facets_edge *edge = NULL;
    int32_t n = 0;
    PD_TRY(pdi_facets_remove_degenerate(ctx, w));
    PD_TRY(PD_NEW(ctx, "facets", 3 * w->count, edge));
    for (int32_t k = 0; k < 3 * w->count; k++) {
        if (w->shell[k / 3] < 0) continue;
        int32_t from = w->vertex[k], to = w->vertex[k % 3 < 2 ? k + 1 : k - 2];
        edge[n].low = from < to ? from : to;
        edge[n].high = from < to ? to : from;
        edge[n].corner = k;
        edge[n++].is_forward = from < to;
    }
    qsort(edge, (size_t)n, sizeof *edge, pdi_facets_compare_edges);
    pdi_facets_find_shells(w, edge, n);
    PD_DELETE(ctx, 3 * w->count, edge);
    return PD_OK;
}

/* Merges identical corners and, only where the surface has unmatched edges otherwise, corners within
 * PDI_VERTEX_MERGE_TOLERANCE of its extent; sets vertex, shell and merged of w. PD_OK: the surface is closed.
 * PD_ERR_GEOMETRY: an edge has more triangles in one direction than in the other; the message has the place of the
 * first one. */
static pd_status pdi_facets_check_closed(pd_ctx *ctx, pdi_facets_work *w)
{
    PD_TRY(pdi_vertex_merge_identical(ctx, w->corner, 3 * w->count, w->vertex));
    PD_TRY(pdi_facets_match_edges(ctx, w));
    if (w->unmatched) {
        PD_TRY(pdi_vertex_merge_nearby(ctx, w->corner, 3 * w->count, w->vertex, w->parent, &w->merged));
        PD_TRY(pdi_facets_match_edges(ctx, w));
    }
    if (!w->unmatched) return PD_OK;
    const double *x = w->corner + (int64_t)w->unmatched_corner * 3;
    const double *y =
        w->corner + (int64_t)(w->unmatched_corner % 3 < 2 ? w->unmatched_corner + 1 : w->unmatched_corner - 2) * 3;
    char more[40] = "";
    if (w->unmatched > 1) snprintf(more, sizeof more, "; so have %d more edges", (int)w->unmatched - 1);
    return pd_fail(ctx, PD_ERR_GEOMETRY, "facets",
                   "the edge from (%.9g %.9g %.9g) to (%.9g %.9g %.9g) m has %d "
                   "triangle%s, %d of them along it, expected as many along it as against it: the surface is not "
                   "closed, or a triangle is turned over%s",
                   x[0], x[1], x[2], y[0], y[1], y[2], (int)w->unmatched_triangles,
                   w->unmatched_triangles > 1 ? "s" : "", (int)w->unmatched_forward, more);
}

/* PD_ERR_ARGUMENT: number of triangles outside 4 .. INT32_MAX/9, or a coordinate that is NaN or of 1e30 m or more. */
static pd_status pdi_facets_check_input(pd_ctx *ctx, const double *corner, int64_t count)
{
    if (count < 4 || count > INT32_MAX / 9)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "facets", "%.0f triangles, expected 4 to %d", (double)count,
                       INT32_MAX / 9);
    for (int64_t k = 0; k < 9 * count; k++)
        if (!(fabs(corner[k]) < 1e30))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "facets", "triangle %d has the coordinate %g m, expected less than"
                           " 1e30", (int)(k / 9) + 1, corner[k]);
    return PD_OK;
}

/* Six times the volume [m3] enclosed by the triangles corner [count][3][3] [m], positive when their normals point
 * outward, as a sum of tetrahedra with apex `origin` [m]. */
static double pdi_facets_compute_six_volumes(const double *corner, int32_t count, const double *origin)
{
    double volume = 0.0;
    for (int64_t k = 0; k < count; k++) {
        double e[3][3];
        for (int p = 0; p < 3; p++)
            for (int d = 0; d < 3; d++) e[p][d] = corner[9 * k + 3 * p + d] - origin[d];
        for (int d = 0; d < 3; d++)
            volume += e[0][d] * (e[1][(d + 1) % 3] * e[2][(d + 2) % 3] - e[1][(d + 2) % 3] * e[2][(d + 1) % 3]);
    }
    return volume;
}

/* ---- the tree ---- */

/* Sort key of a triangle. */
typedef struct pdi_facets_centroid_key {
    double centroid;  /* [m] coordinate of its centroid along the axis of the split */
    int32_t triangle; /* triangle */
} pdi_facets_centroid_key;

/* qsort: order by the coordinate of the centroid, then by number. */
static int pdi_facets_compare_keys(const void *a, const void *b)
{
    const pdi_facets_centroid_key *p = (const pdi_facets_centroid_key *)a, *q = (const pdi_facets_centroid_key *)b;
    if (p->centroid < q->centroid || p->centroid > q->centroid) return p->centroid < q->centroid ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

/* Appends the box of the triangles first .. first + size - 1 of `key` to the tree, and recursively those of its two
 * children: a median split of the centroids along the longest edge of the box, while there are more than
 * PDI_FACETS_LEAF_SIZE triangles. Reorders `key`. */
static void pdi_facets_build_subtree(pd_facets *f, const double *corner, pdi_facets_centroid_key *key, int32_t first,
                                     int32_t size)
{
    int32_t index = f->tree_nodes++;
    double *box = f->box + 6 * (int64_t)index;
    int axis = 0;
    f->first_triangle[index] = first;
    f->triangle_count[index] = size;
    f->second_child[index] = 0;
    for (int d = 0; d < 3; d++) {
        box[d] = HUGE_VAL;
        box[3 + d] = -HUGE_VAL;
        for (int32_t k = first; k < first + size; k++)
            for (int p = 0; p < 3; p++) {
                double x = corner[9 * (int64_t)key[k].triangle + 3 * p + d];
                box[d] = pd_min(box[d], x);
                box[3 + d] = pd_max(box[3 + d], x);
            }
        if (box[3 + d] - box[d] > box[3 + axis] - box[axis]) axis = d;
    }
    if (size <= PDI_FACETS_LEAF_SIZE) return;
    for (int32_t k = first; k < first + size; k++) {
        const double *x = corner + 9 * (int64_t)key[k].triangle + axis;
        key[k].centroid = x[0] / 3.0 + x[3] / 3.0 + x[6] / 3.0;
    }
    qsort(key + first, (size_t)size, sizeof *key, pdi_facets_compare_keys);
    pdi_facets_build_subtree(f, corner, key, first, size / 2);
    f->second_child[index] = f->tree_nodes;
    pdi_facets_build_subtree(f, corner, key, first + size / 2, size - size / 2);
}

/* ---- distance ---- */

/* Scalar product of two vectors in 3D. */
static double pdi_facets_dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Squared distance [m2] of point x from the segment a b. */
static double pdi_facets_square_distance_segment(const double *a, const double *b, const double *x)
{
    double edge[3], offset[3];
    for (int d = 0; d < 3; d++) {
        edge[d] = b[d] - a[d];
        offset[d] = x[d] - a[d];
    }
    double along = pdi_facets_dot(offset, edge), square = pdi_facets_dot(edge, edge);
    double t = along > 0.0 ? along < square ? along / square : 1.0 : 0.0;
    for (int d = 0; d < 3; d++) offset[d] -= t * edge[d];
    return pdi_facets_dot(offset, offset);
}

/* Squared distance [m2] of point x from a triangle corner [3][3]: to its plane where x projects into it, else to the
 * nearest edge. Degenerate triangles ((twice the area)^2 at most PDI_FACETS_SLIVER times the longest edge^4) count as
 * their edges. */
static double pdi_facets_square_distance_triangle(const double *corner, const double *x)
{
    double e[3][3], offset[3], normal[3], longest = 0.0, best = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        for (int d = 0; d < 3; d++) e[k][d] = corner[(3 * k + 3) % 9 + d] - corner[3 * k + d];
        double edge = pdi_facets_dot(e[k], e[k]);
        longest = edge > longest ? edge : longest;
    }
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        normal[d] = e[0][p] * e[1][q] - e[0][q] * e[1][p];
        offset[d] = x[d] - corner[d];
    }
    double area = pdi_facets_dot(normal, normal);
    int plane = area > PDI_FACETS_SLIVER * longest * longest, outside = 0;
    for (int k = 0; k < 3; k++) {
        const double *from = corner + 3 * k;
        double side = 0.0;
        for (int d = 0; d < 3; d++) {
            int p = (d + 1) % 3, q = (d + 2) % 3;
            side += (x[d] - from[d]) * (normal[p] * e[k][q] - normal[q] * e[k][p]);
        }
        if (plane && side >= 0.0) continue;
        outside = 1;
        double square = pdi_facets_square_distance_segment(from, corner + (3 * k + 3) % 9, x);
        best = square < best ? square : best;
    }
    if (outside) return best;
    double height = pdi_facets_dot(normal, offset);
    return height * height / area;
}

/* Squared distance [m2] of point x from box k; 0 inside. */
static double pdi_facets_square_distance_box(const pd_facets *f, int32_t k, const double *x)
{
    const double *box = f->box + 6 * (int64_t)k;
    double square = 0.0;
    for (int d = 0; d < 3; d++) {
        double below = box[d] - x[d], above = x[d] - box[3 + d], outside = below > above ? below : above;
        square += outside > 0.0 ? outside * outside : 0.0;
    }
    return square;
}

/* Squared distance [m2] of x from the nearest triangle in the tree below `root`, without triangle `skip` (-1: none);
 * `best` [m2] when none is nearer. Branch and bound, the nearer child first. */
static double pdi_facets_square_distance_tree(const pd_facets *f, int32_t root, int32_t skip, const double *x,
                                              double best)
{
    int32_t stack[PDI_FACETS_MAX_DEPTH];
    double bound[PDI_FACETS_MAX_DEPTH];
    int depth = 1;
    stack[0] = root;
    bound[0] = 0.0;
    while (depth) {
        int32_t index = stack[--depth], second = f->second_child[index];
        if (bound[depth] >= best) continue;
        if (second) {
            double left = pdi_facets_square_distance_box(f, index + 1, x),
                   right = pdi_facets_square_distance_box(f, second, x);
            int swap = left < right;
            stack[depth] = swap ? second : index + 1;
            bound[depth++] = swap ? right : left;
            stack[depth] = swap ? index + 1 : second;
            bound[depth++] = swap ? left : right;
            continue;
        }
        for (int32_t k = f->first_triangle[index]; k < f->first_triangle[index] + f->triangle_count[index]; k++) {
            double square = k == skip ? best : pdi_facets_square_distance_triangle(f->corner + 9 * (int64_t)k, x);
            best = square < best ? square : best;
        }
    }
    return best;
}

/* ---- inside or outside ---- */

/* Does the edge p q, projected along axis 0, cross the half-line from x towards +axis 1? 1: upwards along axis 2, -1:
 * downwards, 0: no. Evaluates the same expression for both triangles at an edge. */
static int pdi_facets_edge_crossing_sign(const double *p, const double *q, const double *x)
{
    if ((p[2] <= x[2]) == (q[2] <= x[2])) return 0;
    int up = p[2] < q[2] ? 1 : -1;
    const double *low = up > 0 ? p : q, *high = up > 0 ? q : p;
    if (x[1] < low[1] && x[1] < high[1]) return up;
    if (x[1] >= low[1] && x[1] >= high[1]) return 0;
    return (high[1] - low[1]) * (x[2] - low[2]) - (high[2] - low[2]) * (x[1] - low[1]) > 0.0 ? up : 0;
}

/* Does the ray from x towards +axis 0 intersect the triangle? 1: it leaves the body there, -1: it enters, 0: no. */
static int pdi_facets_ray_crossing_sign(const double *corner, const double *x)
{
    const double *a = corner, *b = corner + 3, *c = corner + 6;
    int leaves = pdi_facets_edge_crossing_sign(a, b, x) + pdi_facets_edge_crossing_sign(b, c, x) +
                 pdi_facets_edge_crossing_sign(c, a, x);
    if (!leaves) return 0;
    double low = pd_min(a[0], pd_min(b[0], c[0])), high = pd_max(a[0], pd_max(b[0], c[0])), slope[3];
    if (x[0] < low || x[0] >= high) return x[0] < low ? leaves : 0;
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        slope[d] = (b[p] - a[p]) * (c[q] - a[q]) - (b[q] - a[q]) * (c[p] - a[p]);
    }
    double height = slope[0] * (x[0] - a[0]) + slope[1] * (x[1] - a[1]) + slope[2] * (x[2] - a[2]);
    return (slope[0] > 0.0 ? height < 0.0 : height > 0.0) ? leaves : 0;
}

/* Winding number about x of the triangles in the tree below `root`, without triangle `skip` (-1: none): signed count
 * of ray intersections. */
static int pdi_facets_winding_number(const pd_facets *f, int32_t root, int32_t skip, const double *x)
{
    int32_t stack[PDI_FACETS_MAX_DEPTH];
    int depth = 1, sum = 0;
    stack[0] = root;
    while (depth) {
        int32_t index = stack[--depth];
        const double *box = f->box + 6 * (int64_t)index;
        if (x[0] >= box[3] || x[1] < box[1] || x[1] >= box[4] || x[2] < box[2] || x[2] >= box[5]) continue;
        if (f->second_child[index]) {
            stack[depth++] = index + 1;
            stack[depth++] = f->second_child[index];
            continue;
        }
        for (int32_t k = f->first_triangle[index]; k < f->first_triangle[index] + f->triangle_count[index]; k++)
            if (k != skip) sum += pdi_facets_ray_crossing_sign(f->corner + 9 * (int64_t)k, x);
    }
    return sum;
}

/* 1: x lies in the region that shell s encloses, whatever the direction of its normals. */
static int pdi_facets_is_inside_shell(const pd_facets *f, int32_t s, const double *x)
{
    return f->orientation[s] * pdi_facets_winding_number(f, f->root[s], -1, x) > 0;
}

/* Unsigned distance [m] to the surface of a union of several shells; *inside: 1 when x is in more bodies than cavities.
 * Offsetting every shell by t changes how many of them contain x; the distance is the offset t at which bodies minus
 * cavities changes sign: the `wanted`-th smallest distance of those shells that can bring it about. A lower bound when
 * `wanted` exceeds PDI_FACETS_MAX_OVERLAP. */
static double pdi_facets_distance_to_union(const pd_facets *f, const double *x, int *inside)
{
    double nearest[PDI_FACETS_MAX_OVERLAP];
    int depth = 0, found = 0;
    for (int32_t s = 0; s < f->shells; s++) depth += f->orientation[s] * pdi_facets_is_inside_shell(f, s, x);
    *inside = depth > 0;
    int wanted = *inside ? depth : 1 - depth;
    if (wanted > PDI_FACETS_MAX_OVERLAP) wanted = PDI_FACETS_MAX_OVERLAP;
    for (int32_t s = 0; s < f->shells; s++) {
        double bound = found < wanted ? HUGE_VAL : nearest[wanted - 1];
        if (pdi_facets_square_distance_box(f, f->root[s], x) >= bound) continue;
        if ((f->orientation[s] > 0) != (pdi_facets_is_inside_shell(f, s, x) == *inside)) continue;
        double square = pdi_facets_square_distance_tree(f, f->root[s], -1, x, bound);
        if (!(square < bound)) continue;
        int k = found < wanted ? found++ : wanted - 1;
        for (; k > 0 && nearest[k - 1] > square; k--) nearest[k] = nearest[k - 1];
        nearest[k] = square;
    }
    return sqrt(nearest[wanted - 1]);
}

PDI_FN double pdi_facets_distance(const pd_facets *f, const double *x)
{
    int inside = 0;
    double far = 0.0, distance = f->shells > 1 ? pdi_facets_distance_to_union(f, x, &inside)
                                               : sqrt(pdi_facets_square_distance_tree(f, 0, -1, x, HUGE_VAL));
    for (int d = 0; d < 6; d++) far = pd_max(far, fabs(f->box[d]));
    if (distance <= PDI_FACETS_ROUNDING * far) return 0.0;
    if (f->shells == 1) inside = pdi_facets_is_inside_shell(f, 0, x);
    return inside ? -distance : distance;
}

/* ---- do all normals point outward? ---- */

/* Winding number of all shells just in front (outside) of triangle k: below 0 where the triangle is oriented the wrong
 * way; 0 also where another triangle lies on it (within PDI_VERTEX_MERGE_TOLERANCE of the largest coordinate).
 * normal_x: component of its normal along axis 0, of any length, not 0; middle [m]: its centroid. */
static int pdi_facets_winding_in_front(const pd_facets *f, int32_t k, double normal_x, const double *middle)
{
    int winding = normal_x > 0.0 ? 0 : -1;
    for (int32_t s = 0; s < f->shells; s++) winding += pdi_facets_winding_number(f, f->root[s], k, middle);
    if (winding >= 0) return winding;
    double largest = 0.0, nearest = HUGE_VAL; /* triangles that lie on each other are in front of nothing */
    for (int d = 0; d < 6; d++) largest = pd_max(largest, fabs(f->box[d]));
    for (int32_t s = 0; s < f->shells; s++)
        nearest = pdi_facets_square_distance_tree(f, f->root[s], k, middle, nearest);
    return nearest > PDI_VERTEX_MERGE_TOLERANCE * PDI_VERTEX_MERGE_TOLERANCE * largest * largest ? winding : 0;
}

/* 1: the orientation of triangle k can be tested by a ray along axis 0: the component of its unit normal along that is
 * above PDI_FACETS_MIN_NORMAL. Always set: *normal_x, component along axis 0 of the normal, whose length is twice the
 * area [m2]; middle [3] [m], the centroid. */
static int pdi_facets_is_orientation_testable(const pd_facets *f, int32_t k, double *normal_x, double *middle)
{
    const double *a = f->corner + 9 * (int64_t)k, *b = a + 3, *c = a + 6;
    double normal[3];
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        normal[d] = (b[p] - a[p]) * (c[q] - a[q]) - (b[q] - a[q]) * (c[p] - a[p]);
        middle[d] = a[d] / 3.0 + b[d] / 3.0 + c[d] / 3.0;
    }
    *normal_x = normal[0];
    return fabs(normal[0]) > PDI_FACETS_MIN_NORMAL * sqrt(pdi_facets_dot(normal, normal));
}

/* PD_ERR_GEOMETRY: a sampled triangle has its normal towards the inside of the body; the message has the place of the
 * first one. Samples about 8 triangles or more of each shell, and about PDI_FACETS_ORIENTATION_SAMPLES in all; those
 * whose normal is across axis 0 are skipped. */
static pd_status pdi_facets_check_orientation(pd_ctx *ctx, const pd_facets *f)
{
    int32_t tested = 0, wrong = 0, first = 0, step = 1 + f->count / PDI_FACETS_ORIENTATION_SAMPLES;
    double place[3] = {0.0, 0.0, 0.0};
    for (int32_t s = 0; s < f->shells; s++) {
        int32_t size = f->triangle_count[f->root[s]], stride = step < 1 + size / 8 ? step : 1 + size / 8;
        for (int32_t k = first; k < first + size; k += stride) {
            double normal_x, middle[3];
            if (!pdi_facets_is_orientation_testable(f, k, &normal_x, middle)) continue;
            tested++;
            if (pdi_facets_winding_in_front(f, k, normal_x, middle) >= 0) continue;
            for (int d = 0; d < 3 && !wrong; d++) place[d] = middle[d];
            wrong++;
        }
        first += size;
    }
    if (!wrong) return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "facets", "the triangle around (%.9g %.9g %.9g) m is turned over, as "
                   "are %d of the %d that were looked at: expected normals that point outward, and into cavities",
                   place[0], place[1], place[2], (int)wrong, (int)tested);
}

/* ---- build and free ---- */

/* Copies the triangles that are not left out, by their merged vertices, to corner [count][3][3] [m], shell by shell;
 * size [shells] receives the number of triangles of each. Flips all of them when the enclosed volume is negative, and
 * sets f->flipped. Uses f->root and w->parent as scratch. */
static void pdi_facets_sort_by_shell(const pdi_facets_work *w, pd_facets *f, double *corner, int32_t *size)
{
    int32_t count = 0, shells = 0;
    for (int32_t k = 0; k < w->count; k++)
        if (w->shell[k] == k) w->parent[k] = shells++;
    memset(size, 0, (size_t)shells * sizeof *size);
    for (int32_t k = 0; k < w->count; k++)
        if (w->shell[k] >= 0) size[w->parent[w->shell[k]]]++;
    for (int32_t s = 0, first = 0; s < shells; s++) {
        f->root[s] = first; /* for now: its next place */
        first += size[s];
    }
    for (int32_t k = 0; k < w->count; k++) {
        if (w->shell[k] < 0) continue;
        double *to = corner + 9 * (int64_t)f->root[w->parent[w->shell[k]]]++;
        for (int c = 0; c < 9; c++) to[c] = w->corner[3 * (int64_t)w->vertex[3 * (int64_t)k + c / 3] + c % 3];
        count++;
    }
    double volume = pdi_facets_compute_six_volumes(corner, count, corner);
    f->flipped = volume < 0.0;
    for (int64_t k = 0; k < count && f->flipped; k++)
        for (int d = 0; d < 3; d++) {
            double second = corner[9 * k + 3 + d];
            corner[9 * k + 3 + d] = corner[9 * k + 6 + d];
            corner[9 * k + 6 + d] = second;
        }
}

/* Builds one tree for each shell (with a box 0 around all when there are several), sets root and orientation of each
 * shell, the latter by the sign of its volume, and stores the triangles corner [count][3][3] in f->corner in the order
 * of the leaves. key [count] is scratch; size [shells]: triangles of each shell. */
static void pdi_facets_build_trees(pd_facets *f, const double *corner, pdi_facets_centroid_key *key,
                                   const int32_t *size)
{
    int32_t first = 0;
    for (int32_t k = 0; k < f->count; k++) key[k].triangle = k;
    if (f->shells > 1) {
        f->tree_nodes = 1;
        f->triangle_count[0] = f->count;
        for (int d = 0; d < 6; d++) f->box[d] = d < 3 ? HUGE_VAL : -HUGE_VAL;
    }
    for (int32_t s = 0; s < f->shells; s++) {
        const double *shell = corner + 9 * (int64_t)first;
        f->orientation[s] = pdi_facets_compute_six_volumes(shell, size[s], shell) < 0.0 ? -1 : 1;
        f->root[s] = f->tree_nodes;
        pdi_facets_build_subtree(f, corner, key, first, size[s]);
        const double *box = f->box + 6 * (int64_t)f->root[s];
        for (int d = 0; d < 3 && f->shells > 1; d++) {
            f->box[d] = pd_min(f->box[d], box[d]);
            f->box[3 + d] = pd_max(f->box[3 + d], box[3 + d]);
        }
        first += size[s];
    }
    for (int32_t k = 0; k < f->count; k++) /* + 0: no zero has a sign */
        for (int c = 0; c < 9; c++) f->corner[9 * (int64_t)k + c] = corner[9 * (int64_t)key[k].triangle + c] + 0.0;
}

/* Allocates the surface and fills it from the closed triangles of w, flipped as a whole where the enclosed volume is
 * negative; on failure the caller frees it. PD_ERR_GEOMETRY: fewer than 4 triangles are left, or the volume is 0. */
static pd_status pdi_facets_build_shells(pd_ctx *ctx, const pdi_facets_work *w, pd_facets *f)
{
    pdi_facets_centroid_key *key = NULL;
    double *corner = NULL;
    int32_t *size = NULL;
    for (int32_t k = 0; k < w->count; k++) {
        f->count += w->shell[k] >= 0;
        f->shells += w->shell[k] == k;
    }
    f->merged = w->merged;
    if (f->count < 4)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "facets", "the surface of %d triangles has no volume", (int)w->count);
    PD_TRY(pdi_array_registry_build(ctx, pdi_facets_list_arrays, f));
    pd_status status = PD_NEW(ctx, "facets", f->count, key);
    if (status == PD_OK) status = PD_NEW(ctx, "facets", 9 * (int64_t)f->count, corner);
    if (status == PD_OK) status = PD_NEW(ctx, "facets", f->shells, size);
    if (status == PD_OK) {
        pdi_facets_sort_by_shell(w, f, corner, size);
        if (fabs(pdi_facets_compute_six_volumes(corner, f->count, corner)) > 0.0)
            pdi_facets_build_trees(f, corner, key, size);
        else status = pd_fail(ctx, PD_ERR_GEOMETRY, "facets", "the surface of %d triangles has no volume",
                              (int)w->count);
    }
    PD_DELETE(ctx, f->shells, size);
    PD_DELETE(ctx, 9 * (int64_t)f->count, corner);
    PD_DELETE(ctx, f->count, key);
    return status;
}

/* Does the work of pd_facets_build on a zeroed surface, the working arrays included; on failure the caller frees the
 * surface. */
static pd_status pdi_facets_build_inner(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *f)
{
    pdi_facets_work w;
    memset(&w, 0, sizeof w);
    PD_TRY(pdi_facets_check_input(ctx, corner, count));
    w.corner = corner;
    w.count = (int32_t)count;
    pd_status status = PD_NEW(ctx, "facets", 3 * count, w.vertex);
    if (status == PD_OK) status = PD_NEW(ctx, "facets", 3 * count, w.parent);
    if (status == PD_OK) status = PD_NEW(ctx, "facets", count, w.shell);
    if (status == PD_OK) status = pdi_facets_check_closed(ctx, &w);
    if (status == PD_OK) status = pdi_facets_build_shells(ctx, &w, f);
    PD_DELETE(ctx, count, w.shell);
    PD_DELETE(ctx, 3 * count, w.parent);
    PD_DELETE(ctx, 3 * count, w.vertex);
    return status == PD_OK ? pdi_facets_check_orientation(ctx, f) : status;
}

pd_status pd_facets_build(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *facets)
{
    memset(facets, 0, sizeof *facets);
    pd_status status = pdi_facets_build_inner(ctx, corner, count, facets);
    if (status < 0) pd_facets_free(ctx, facets);
    return status;
}

void pd_facets_free(pd_ctx *ctx, pd_facets *facets)
{
    pdi_array_registry_free(ctx, pdi_facets_list_arrays, facets);
    memset(facets, 0, sizeof *facets);
}

/* ---- intersections with segments ---- */

/* 1: the segment x + t xi, 0 <= t <= 1, intersects the box [6] enlarged by `tolerance` [m] (slab test). */
static int pdi_facets_is_box_hit(const double *box, const double *x, const double *xi, double tolerance)
{
    double from = 0.0, to = 1.0;
    for (int d = 0; d < 3; d++) {
        double low = box[d] - tolerance - x[d], high = box[3 + d] + tolerance - x[d];
        if (fabs(xi[d]) > 0.0) {
            double a = low / xi[d], b = high / xi[d];
            from = pd_max(from, pd_min(a, b));
            to = pd_min(to, pd_max(a, b));
        } else if (low > 0.0 || high < 0.0) return 0;
    }
    return from <= to;
}

/* Parameter t, of any sign, at which the line x + t xi intersects the triangle corner [3][3] [m]; HUGE_VAL: it does
 * not, or is parallel to its plane. Moeller and Trumbore 1997, with the tolerance PDI_FACETS_EDGE_TOLERANCE. */
static double pdi_facets_find_triangle_crossing(const double *corner, const double *x, const double *xi)
{
    double e[2][3], offset[3], across[3], cross[3];
    for (int d = 0; d < 3; d++) {
        e[0][d] = corner[3 + d] - corner[d];
        e[1][d] = corner[6 + d] - corner[d];
        offset[d] = x[d] - corner[d];
    }
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        across[d] = xi[p] * e[1][q] - xi[q] * e[1][p];
        cross[d] = offset[p] * e[0][q] - offset[q] * e[0][p];
    }
    double volume = pdi_facets_dot(e[0], across);
    if (!(fabs(volume) > 0.0)) return HUGE_VAL;
    double u = pdi_facets_dot(offset, across) / volume, v = pdi_facets_dot(xi, cross) / volume;
    if (u < -PDI_FACETS_EDGE_TOLERANCE || v < -PDI_FACETS_EDGE_TOLERANCE || u + v > 1.0 + PDI_FACETS_EDGE_TOLERANCE)
        return HUGE_VAL;
    return pdi_facets_dot(e[1], cross) / volume;
}

PDI_FN double pdi_facets_find_crossing(const pd_facets *f, const double *x, const double *xi, double after)
{
    int32_t stack[PDI_FACETS_MAX_DEPTH];
    int depth = 1;
    double best = HUGE_VAL, largest = 0.0;
    for (int d = 0; d < 6; d++) largest = pd_max(largest, fabs(f->box[d]));
    stack[0] = 0;
    while (depth) {
        int32_t index = stack[--depth];
        if (!pdi_facets_is_box_hit(f->box + 6 * (int64_t)index, x, xi, PDI_FACETS_EDGE_TOLERANCE * largest)) continue;
        if (f->second_child[index]) {
            stack[depth++] = index + 1;
            stack[depth++] = f->second_child[index];
            continue;
        }
        for (int32_t k = f->first_triangle[index]; k < f->first_triangle[index] + f->triangle_count[index]; k++) {
            double t = pdi_facets_find_triangle_crossing(f->corner + 9 * (int64_t)k, x, xi);
            if (t > after && t < best) best = t;
        }
    }
    return best <= 1.0 ? best : HUGE_VAL;
}

#undef PDI_FACETS_LEAF_SIZE
#undef PDI_FACETS_EDGE_TOLERANCE
#undef PDI_FACETS_ROUNDING
#undef PDI_FACETS_SLIVER
#undef PDI_FACETS_MAX_OVERLAP
#undef PDI_FACETS_ORIENTATION_SAMPLES
#undef PDI_FACETS_MIN_NORMAL
#undef PDI_FACETS_MAX_DEPTH
