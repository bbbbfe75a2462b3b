/* facets: see facets.h
 *
 * Sources: trees of boxes and the closest points of triangles as in Ericson 2005, ch. 5 and 6.
 */
#include "lattice/facets.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Most triangles of a box without children. */
#define PDI_FACETS_LEAF 4
/* Rounding of places, over the largest coordinate of the surface. */
#define PDI_FACETS_ROUNDING 1e-14
/* Least square of the double area of a triangle that has a plane, over the fourth power of its longest edge. */
#define PDI_FACETS_SLIVER 1e-16
/* Depth of the tree: boxes halve, and there are fewer than 2^31 triangles. */
#define PDI_FACETS_DEPTH 64
/* A line meets a triangle that it passes so much beyond an edge, over the length of the edge; of boxes over the largest
 * coordinate. A place too many does no harm. */
#define PDI_FACETS_EDGE 1e-9

static void pdi_facets_list(pdi_owner *owner, void *object)
{
    pd_facets *facets = (pd_facets *)object;
    PDI_ARRAY(owner, facets, corner, (int64_t)facets->count * 9, "m");
    PDI_ARRAY(owner, facets, box, (int64_t)facets->count * 6, "m");
    PDI_ARRAY(owner, facets, first, facets->count, "1");
    PDI_ARRAY(owner, facets, size, facets->count, "1");
    PDI_ARRAY(owner, facets, second, facets->count, "1");
}

PDI_FN int64_t pdi_facets_bytes(const pd_facets *facets)
{
    pd_facets copy = *facets;
    return pdi_owner_bytes(pdi_facets_list, &copy);
}

/* ---- is it closed? ---- */

typedef struct pdi_facets_vertex {
    double x[3];
    int32_t at; /* of all corners */
} pdi_facets_vertex;

typedef struct pdi_facets_edge {
    int32_t low, high; /* vertices */
    int32_t at;        /* corner where it begins */
    int32_t sense;     /* 1: from low to high */
} pdi_facets_edge;

static int pdi_facets_compare(const void *a, const void *b)
{
    const pdi_facets_vertex *p = (const pdi_facets_vertex *)a, *q = (const pdi_facets_vertex *)b;
    for (int d = 0; d < 3; d++)
        if (p->x[d] < q->x[d] || p->x[d] > q->x[d]) return p->x[d] < q->x[d] ? -1 : 1;
    return (p->at > q->at) - (p->at < q->at);
}

static int pdi_facets_compare_edges(const void *a, const void *b)
{
    const pdi_facets_edge *p = (const pdi_facets_edge *)a, *q = (const pdi_facets_edge *)b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    if (p->sense != q->sense) return p->sense < q->sense ? -1 : 1;
    return (p->at > q->at) - (p->at < q->at);
}

/* Numbers of corners that are the same at the same places: vertex [3 count]. */
static pd_status pdi_facets_weld(pd_ctx *ctx, const double *corner, int32_t count, int32_t *vertex)
{
    pdi_facets_vertex *list = NULL;
    int32_t n = 3 * count, number = 0;
    PDI_TRY(PDI_NEW(ctx, "facets", n, list));
    for (int32_t k = 0; k < n; k++) {
        for (int d = 0; d < 3; d++) list[k].x[d] = corner[(int64_t)k * 3 + d];
        list[k].at = k;
    }
    qsort(list, (size_t)n, sizeof *list, pdi_facets_compare);
    for (int32_t k = 0; k < n; k++) {
        for (int d = 0; k && d < 3; d++)
            if (list[k].x[d] < list[k - 1].x[d] || list[k].x[d] > list[k - 1].x[d]) {
                number = k;
                break;
            }
        vertex[list[k].at] = number;
    }
    PDI_DELETE(ctx, n, list);
    return PD_OK;
}

static pd_status pdi_facets_pairs(pd_ctx *ctx, const double *corner, const pdi_facets_edge *edge, int32_t count)
{
    for (int32_t k = 0, next; k < count; k = next) {
        int32_t forth = 0;
        for (next = k; next < count && edge[next].low == edge[k].low && edge[next].high == edge[k].high; next++)
            forth += edge[next].sense;
        const double *x = corner + (int64_t)edge[k].at * 3;
        int32_t other = edge[k].at % 3 < 2 ? edge[k].at + 1 : edge[k].at - 2;
        const double *y = corner + (int64_t)other * 3;
        if (next - k == 2 && forth == 1) continue;
        return pdi_fail(ctx, PD_ERR_GEOMETRY, "facets", "the edge from (%.9g %.9g %.9g) to (%.9g %.9g %.9g) m has %d "
                        "triangle%s, %d of them along it, expected two in opposite senses: the surface is not closed",
                        x[0], x[1], x[2], y[0], y[1], y[2], (int)(next - k), next - k > 1 ? "s" : "",
                        (int)(edge[k].sense ? forth : next - k - forth));
    }
    return PD_OK;
}

static pd_status pdi_facets_edges(pd_ctx *ctx, const double *corner, const int32_t *vertex, int32_t count)
{
    pdi_facets_edge *edge = NULL;
    int32_t n = 3 * count;
    PDI_TRY(PDI_NEW(ctx, "facets", n, edge));
    for (int32_t k = 0; k < n; k++) {
        int32_t from = vertex[k], to = vertex[k % 3 < 2 ? k + 1 : k - 2];
        edge[k].low = from < to ? from : to;
        edge[k].high = from < to ? to : from;
        edge[k].sense = from < to;
        edge[k].at = k;
    }
    qsort(edge, (size_t)n, sizeof *edge, pdi_facets_compare_edges);
    pd_status status = pdi_facets_pairs(ctx, corner, edge, n);
    PDI_DELETE(ctx, n, edge);
    return status;
}

static pd_status pdi_facets_closed(pd_ctx *ctx, const double *corner, int32_t count)
{
    int32_t *vertex = NULL;
    PDI_TRY(PDI_NEW(ctx, "facets", 3 * count, vertex));
    pd_status status = pdi_facets_weld(ctx, corner, count, vertex);
    for (int32_t k = 0; k < count && status == PD_OK; k++) {
        const int32_t *v = vertex + 3 * (int64_t)k;
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
            status = pdi_fail(ctx, PD_ERR_GEOMETRY, "facets", "triangle %d of %d has two corners at one place, at "
                              "(%.9g %.9g %.9g) m", (int)k + 1, (int)count, corner[9 * (int64_t)k],
                              corner[9 * (int64_t)k + 1], corner[9 * (int64_t)k + 2]);
    }
    if (status == PD_OK) status = pdi_facets_edges(ctx, corner, vertex, count);
    PDI_DELETE(ctx, 3 * count, vertex);
    return status;
}

static pd_status pdi_facets_check(pd_ctx *ctx, const double *corner, int64_t count)
{
    double volume = 0.0;
    if (count < 4 || count > INT32_MAX / 9)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "facets", "%.0f triangles, expected 4 to %d", (double)count,
                        INT32_MAX / 9);
    for (int64_t k = 0; k < 9 * count; k++)
        if (!(fabs(corner[k]) < 1e30))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "facets", "triangle %d has the coordinate %g m, expected less than"
                            " 1e30", (int)(k / 9) + 1, corner[k]);
    PDI_TRY(pdi_facets_closed(ctx, corner, (int32_t)count));
    for (int64_t k = 0; k < count; k++) { /* six times that over the first corner of all */
        double e[3][3];
        for (int p = 0; p < 3; p++)
            for (int d = 0; d < 3; d++) e[p][d] = corner[9 * k + 3 * p + d] - corner[d];
        for (int d = 0; d < 3; d++)
            volume += e[0][d] * (e[1][(d + 1) % 3] * e[2][(d + 2) % 3] - e[1][(d + 2) % 3] * e[2][(d + 1) % 3]);
    }
    if (fabs(volume) > 0.0) return PD_OK;
    return pdi_fail(ctx, PD_ERR_GEOMETRY, "facets", "the surface of %d triangles has no volume", (int)count);
}

/* ---- the tree ---- */

typedef struct pdi_facets_key {
    double middle; /* [m] along an axis */
    int32_t at;
} pdi_facets_key;

static int pdi_facets_compare_keys(const void *a, const void *b)
{
    const pdi_facets_key *p = (const pdi_facets_key *)a, *q = (const pdi_facets_key *)b;
    if (p->middle < q->middle || p->middle > q->middle) return p->middle < q->middle ? -1 : 1;
    return (p->at > q->at) - (p->at < q->at);
}

/* The box of the triangles first .. first + size - 1 of `key`, and those below it. */
static void pdi_facets_divide(pd_facets *f, const double *corner, pdi_facets_key *key, int32_t first, int32_t size)
{
    int32_t own = f->boxes++;
    double *box = f->box + 6 * (int64_t)own;
    int axis = 0;
    f->first[own] = first;
    f->size[own] = size;
    f->second[own] = 0;
    for (int d = 0; d < 3; d++) {
        box[d] = HUGE_VAL;
        box[3 + d] = -HUGE_VAL;
        for (int32_t k = first; k < first + size; k++)
            for (int p = 0; p < 3; p++) {
                double x = corner[9 * (int64_t)key[k].at + 3 * p + d];
                box[d] = pdi_min(box[d], x);
                box[3 + d] = pdi_max(box[3 + d], x);
            }
        if (box[3 + d] - box[d] > box[3 + axis] - box[axis]) axis = d;
    }
    if (size <= PDI_FACETS_LEAF) return;
    for (int32_t k = first; k < first + size; k++) {
        const double *x = corner + 9 * (int64_t)key[k].at + axis;
        key[k].middle = x[0] / 3.0 + x[3] / 3.0 + x[6] / 3.0;
    }
    qsort(key + first, (size_t)size, sizeof *key, pdi_facets_compare_keys);
    pdi_facets_divide(f, corner, key, first, size / 2);
    f->second[own] = f->boxes;
    pdi_facets_divide(f, corner, key, first + size / 2, size - size / 2);
}

static pd_status pdi_facets_make(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *f)
{
    pdi_facets_key *key = NULL;
    PDI_TRY(pdi_facets_check(ctx, corner, count));
    f->count = (int32_t)count;
    PDI_TRY(pdi_owner_build(ctx, pdi_facets_list, f));
    PDI_TRY(PDI_NEW(ctx, "facets", count, key));
    for (int32_t k = 0; k < f->count; k++) key[k].at = k;
    pdi_facets_divide(f, corner, key, 0, f->count);
    for (int32_t k = 0; k < f->count; k++) /* + 0: no zero has a sign */
        for (int c = 0; c < 9; c++) f->corner[9 * (int64_t)k + c] = corner[9 * (int64_t)key[k].at + c] + 0.0;
    PDI_DELETE(ctx, count, key);
    return PD_OK;
}

pd_status pd_facets_build(pd_ctx *ctx, const double *corner, int64_t count, pd_facets *facets)
{
    memset(facets, 0, sizeof *facets);
    pd_status status = pdi_facets_make(ctx, corner, count, facets);
    if (status < 0) pd_facets_free(ctx, facets);
    return status;
}

void pd_facets_free(pd_ctx *ctx, pd_facets *facets)
{
    pdi_owner_free(ctx, pdi_facets_list, facets);
    memset(facets, 0, sizeof *facets);
}

/* ---- distance ---- */

static double pdi_facets_dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Square of the distance from x to the segment from a to b. */
static double pdi_facets_segment(const double *a, const double *b, const double *x)
{
    double edge[3], off[3];
    for (int d = 0; d < 3; d++) {
        edge[d] = b[d] - a[d];
        off[d] = x[d] - a[d];
    }
    double along = pdi_facets_dot(off, edge), whole = pdi_facets_dot(edge, edge);
    double share = along > 0.0 ? along < whole ? along / whole : 1.0 : 0.0;
    for (int d = 0; d < 3; d++) off[d] -= share * edge[d];
    return pdi_facets_dot(off, off);
}

/* To the triangle: its plane where x is above it, else the edges that x is beyond. Slivers are edges alone. */
static double pdi_facets_square(const double *corner, const double *x)
{
    double e[3][3], off[3], normal[3], longest = 0.0, best = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        for (int d = 0; d < 3; d++) e[k][d] = corner[(3 * k + 3) % 9 + d] - corner[3 * k + d];
        double edge = pdi_facets_dot(e[k], e[k]);
        longest = edge > longest ? edge : longest;
    }
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        normal[d] = e[0][p] * e[1][q] - e[0][q] * e[1][p];
        off[d] = x[d] - corner[d];
    }
    double area = pdi_facets_dot(normal, normal);
    int plane = area > PDI_FACETS_SLIVER * longest * longest, beyond = 0;
    for (int k = 0; k < 3; k++) {
        const double *from = corner + 3 * k;
        double side = 0.0;
        for (int d = 0; d < 3; d++) {
            int p = (d + 1) % 3, q = (d + 2) % 3;
            side += (x[d] - from[d]) * (normal[p] * e[k][q] - normal[q] * e[k][p]);
        }
        if (plane && side >= 0.0) continue;
        beyond = 1;
        double square = pdi_facets_segment(from, corner + (3 * k + 3) % 9, x);
        best = square < best ? square : best;
    }
    if (beyond) return best;
    double height = pdi_facets_dot(normal, off);
    return height * height / area;
}

/* Square of the distance from x to box k. */
static double pdi_facets_beyond(const pd_facets *f, int32_t k, const double *x)
{
    const double *box = f->box + 6 * (int64_t)k;
    double square = 0.0;
    for (int d = 0; d < 3; d++) {
        double below = box[d] - x[d], above = x[d] - box[3 + d], off = below > above ? below : above;
        square += off > 0.0 ? off * off : 0.0;
    }
    return square;
}

/* Square of the distance to the nearest triangle. Nearer children are looked at first. */
static double pdi_facets_nearest(const pd_facets *f, const double *x)
{
    int32_t stack[PDI_FACETS_DEPTH];
    double far[PDI_FACETS_DEPTH], best = HUGE_VAL;
    int depth = 1;
    stack[0] = 0;
    far[0] = 0.0;
    while (depth) {
        int32_t own = stack[--depth], second = f->second[own];
        if (far[depth] >= best) continue;
        if (second) {
            double left = pdi_facets_beyond(f, own + 1, x), right = pdi_facets_beyond(f, second, x);
            int swap = left < right;
            stack[depth] = swap ? second : own + 1;
            far[depth++] = swap ? right : left;
            stack[depth] = swap ? own + 1 : second;
            far[depth++] = swap ? left : right;
            continue;
        }
        for (int32_t k = f->first[own]; k < f->first[own] + f->size[own]; k++) {
            double square = pdi_facets_square(f->corner + 9 * (int64_t)k, x);
            best = square < best ? square : best;
        }
    }
    return best;
}

/* ---- inside or outside ---- */

/* Does the edge from p to q pass the ray from x along axis 0 on its far side along axis 1? Both triangles at the edge
 * get the same answer. */
static int pdi_facets_passes(const double *p, const double *q, const double *x)
{
    if ((p[2] <= x[2]) == (q[2] <= x[2])) return 0;
    const double *low = p[2] < q[2] ? p : q, *high = p[2] < q[2] ? q : p;
    if (x[1] < low[1] && x[1] < high[1]) return 1;
    if (x[1] >= low[1] && x[1] >= high[1]) return 0;
    return (high[1] - low[1]) * (x[2] - low[2]) - (high[2] - low[2]) * (x[1] - low[1]) > 0.0;
}

/* Does the ray from x up axis 0 meet the triangle? */
static int pdi_facets_meets(const double *corner, const double *x)
{
    const double *a = corner, *b = corner + 3, *c = corner + 6;
    if (!(pdi_facets_passes(a, b, x) ^ pdi_facets_passes(b, c, x) ^ pdi_facets_passes(c, a, x))) return 0;
    double low = pdi_min(a[0], pdi_min(b[0], c[0])), high = pdi_max(a[0], pdi_max(b[0], c[0])), slope[3];
    if (x[0] < low || x[0] >= high) return x[0] < low;
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        slope[d] = (b[p] - a[p]) * (c[q] - a[q]) - (b[q] - a[q]) * (c[p] - a[p]);
    }
    double height = slope[0] * (x[0] - a[0]) + slope[1] * (x[1] - a[1]) + slope[2] * (x[2] - a[2]);
    return slope[0] > 0.0 ? height < 0.0 : height > 0.0;
}

static int pdi_facets_inside(const pd_facets *f, const double *x)
{
    int32_t stack[PDI_FACETS_DEPTH];
    int depth = 1, odd = 0;
    stack[0] = 0;
    while (depth) {
        int32_t own = stack[--depth];
        const double *box = f->box + 6 * (int64_t)own;
        if (x[0] >= box[3] || x[1] < box[1] || x[1] >= box[4] || x[2] < box[2] || x[2] >= box[5]) continue;
        if (f->second[own]) {
            stack[depth++] = own + 1;
            stack[depth++] = f->second[own];
            continue;
        }
        for (int32_t k = f->first[own]; k < f->first[own] + f->size[own]; k++)
            odd ^= pdi_facets_meets(f->corner + 9 * (int64_t)k, x);
    }
    return odd;
}

PDI_FN double pdi_facets_distance(const pd_facets *f, const double *x)
{
    double distance = sqrt(pdi_facets_nearest(f, x)), far = 0.0;
    for (int d = 0; d < 6; d++) far = pdi_max(far, fabs(f->box[d]));
    if (distance <= PDI_FACETS_ROUNDING * far) return 0.0;
    return pdi_facets_inside(f, x) ? -distance : distance;
}

/* ---- lines ---- */

/* Does the line x + t xi, 0 <= t <= 1, pass the box of the tree? */
static int pdi_facets_through(const double *box, const double *x, const double *xi, double slack)
{
    double from = 0.0, to = 1.0;
    for (int d = 0; d < 3; d++) {
        double low = box[d] - slack - x[d], high = box[3 + d] + slack - x[d];
        if (fabs(xi[d]) > 0.0) {
            double a = low / xi[d], b = high / xi[d];
            from = pdi_max(from, pdi_min(a, b));
            to = pdi_min(to, pdi_max(a, b));
        } else if (low > 0.0 || high < 0.0) return 0;
    }
    return from <= to;
}

/* t where the line meets the triangle; HUGE_VAL: it does not. By the volumes of line and edges. */
static double pdi_facets_hit(const double *corner, const double *x, const double *xi)
{
    double e[2][3], off[3], across[3], turned[3];
    for (int d = 0; d < 3; d++) {
        e[0][d] = corner[3 + d] - corner[d];
        e[1][d] = corner[6 + d] - corner[d];
        off[d] = x[d] - corner[d];
    }
    for (int d = 0; d < 3; d++) {
        int p = (d + 1) % 3, q = (d + 2) % 3;
        across[d] = xi[p] * e[1][q] - xi[q] * e[1][p];
        turned[d] = off[p] * e[0][q] - off[q] * e[0][p];
    }
    double volume = pdi_facets_dot(e[0], across);
    if (!(fabs(volume) > 0.0)) return HUGE_VAL;
    double u = pdi_facets_dot(off, across) / volume, v = pdi_facets_dot(xi, turned) / volume;
    if (u < -PDI_FACETS_EDGE || v < -PDI_FACETS_EDGE || u + v > 1.0 + PDI_FACETS_EDGE) return HUGE_VAL;
    return pdi_facets_dot(e[1], turned) / volume;
}

PDI_FN double pdi_facets_crossing(const pd_facets *f, const double *x, const double *xi, double after)
{
    int32_t stack[PDI_FACETS_DEPTH];
    int depth = 1;
    double best = HUGE_VAL, far = 0.0;
    for (int d = 0; d < 6; d++) far = pdi_max(far, fabs(f->box[d]));
    stack[0] = 0;
    while (depth) {
        int32_t own = stack[--depth];
        if (!pdi_facets_through(f->box + 6 * (int64_t)own, x, xi, PDI_FACETS_EDGE * far)) continue;
        if (f->second[own]) {
            stack[depth++] = own + 1;
            stack[depth++] = f->second[own];
            continue;
        }
        for (int32_t k = f->first[own]; k < f->first[own] + f->size[own]; k++) {
            double t = pdi_facets_hit(f->corner + 9 * (int64_t)k, x, xi);
            if (t > after && t < best) best = t;
        }
    }
    return best <= 1.0 ? best : HUGE_VAL;
}

#undef PDI_FACETS_LEAF
#undef PDI_FACETS_EDGE
#undef PDI_FACETS_ROUNDING
#undef PDI_FACETS_SLIVER
#undef PDI_FACETS_DEPTH
