/* vertex_merge: see vertex_merge.h */
#include "lattice/vertex_merge.h"
#include "core/disjoint_sets.h"
#include <stdlib.h>

/* A corner, for sorting by its coordinates. */
typedef struct pdi_vertex_merge_vertex {
    double x[3]; /* [m] */
    int32_t corner; /* number of the corner */
} pdi_vertex_merge_vertex;

/* A vertex and the cell of a uniform hash grid (edge: the merge tolerance) that it lies in. */
typedef struct pdi_vertex_merge_cube {
    int32_t index[3];
    int32_t corner;
} pdi_vertex_merge_cube;

/* qsort: order by x, y, z, then by the number of the corner. */
static int pdi_vertex_merge_compare_points(const void *a, const void *b)
{
    const pdi_vertex_merge_vertex *p = (const pdi_vertex_merge_vertex *)a, *q = (const pdi_vertex_merge_vertex *)b;
    for (int d = 0; d < 3; d++)
        if (p->x[d] < q->x[d] || p->x[d] > q->x[d]) return p->x[d] < q->x[d] ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

/* qsort: order by the index of the hash cell, then by the number of the corner. */
static int pdi_vertex_merge_compare_cubes(const void *a, const void *b)
{
    const pdi_vertex_merge_cube *p = (const pdi_vertex_merge_cube *)a, *q = (const pdi_vertex_merge_cube *)b;
    for (int d = 0; d < 3; d++)
        if (p->index[d] != q->index[d]) return p->index[d] < q->index[d] ? -1 : 1;
    return (p->corner > q->corner) - (p->corner < q->corner);
}

PDI_FN pd_status pdi_vertex_merge_identical(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex)
{
    pdi_vertex_merge_vertex *list = NULL;
    int32_t number = 0;
    PD_TRY(PD_NEW(ctx, "facets", n, list));
    for (int32_t k = 0; k < n; k++) {
        for (int d = 0; d < 3; d++) list[k].x[d] = corner[(int64_t)k * 3 + d];
        list[k].corner = k;
    }
    qsort(list, (size_t)n, sizeof *list, pdi_vertex_merge_compare_points);
    for (int32_t k = 0; k < n; k++) {
        for (int d = 0; k && d < 3; d++)
            if (list[k].x[d] < list[k - 1].x[d] || list[k].x[d] > list[k - 1].x[d]) {
                number = k;
                break;
            }
        vertex[list[k].corner] = list[number].corner;
    }
    PD_DELETE(ctx, n, list);
    return PD_OK;
}

/* Binary search: index of the first of `count` sorted hash cells that is not less than `key`. */
static int32_t pdi_vertex_merge_find_cube(const pdi_vertex_merge_cube *cube, int32_t count,
                                          const pdi_vertex_merge_cube *key)
{
    int32_t low = 0, high = count;
    while (low < high) {
        int32_t middle = low + (high - low) / 2;
        if (pdi_vertex_merge_compare_cubes(&cube[middle], key) < 0) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Merges the sets (parent) of vertex number k of the sorted list cube[count] and of all later ones within the distance
 * `tolerance` [m]; looks at the 27 hash cells around it. */
static void pdi_vertex_merge_unite_neighbours(const double *corner, const pdi_vertex_merge_cube *cube, int32_t count,
                                              int32_t k, double tolerance, int32_t *parent)
{
    const double *x = corner + 3 * (int64_t)cube[k].corner;
    for (int n = 0; n < 27; n++) {
        pdi_vertex_merge_cube key = cube[k];
        key.index[0] += n % 3 - 1;
        key.index[1] += n / 3 % 3 - 1;
        key.index[2] += n / 9 - 1;
        key.corner = -1;
        for (int32_t o = pdi_vertex_merge_find_cube(cube, count, &key); o < count; o++) {
            double square = 0.0;
            int there = cube[o].index[0] == key.index[0] && cube[o].index[1] == key.index[1] &&
                        cube[o].index[2] == key.index[2];
            if (!there) break;
            for (int d = 0; d < 3; d++) {
                double off = corner[3 * (int64_t)cube[o].corner + d] - x[d];
                square += off * off;
            }
            if (o > k && square <= tolerance * tolerance)
                pdi_disjoint_sets_merge(parent, cube[k].corner, cube[o].corner);
        }
    }
}

PDI_FN pd_status pdi_vertex_merge_nearby(pd_ctx *ctx, const double *corner, int32_t n, int32_t *vertex, int32_t *parent,
                                         int32_t *merged)
{
    pdi_vertex_merge_cube *cube = NULL;
    int32_t count = 0;
    double low[3], extent = 0.0;
    for (int d = 0; d < 3; d++) {
        double high = low[d] = corner[d];
        for (int32_t k = 0; k < n; k++) {
            low[d] = pd_min(low[d], corner[3 * (int64_t)k + d]);
            high = pd_max(high, corner[3 * (int64_t)k + d]);
        }
        extent = pd_max(extent, high - low[d]);
    }
    double tolerance = PDI_VERTEX_MERGE_TOLERANCE * extent;
    if (!(tolerance > 0.0)) return PD_OK;
    PD_TRY(PD_NEW(ctx, "facets", n, cube));
    for (int32_t k = 0; k < n; k++) {
        parent[k] = k;
        if (vertex[k] != k) continue;
        for (int d = 0; d < 3; d++) cube[count].index[d] = (int32_t)((corner[3 * (int64_t)k + d] - low[d]) / tolerance);
        cube[count++].corner = k;
    }
    qsort(cube, (size_t)count, sizeof *cube, pdi_vertex_merge_compare_cubes);
    for (int32_t k = 0; k < count; k++) pdi_vertex_merge_unite_neighbours(corner, cube, count, k, tolerance, parent);
    for (int32_t k = 0; k < n; k++) {
        int32_t to = pdi_disjoint_sets_find_root(parent, vertex[k]);
        *merged += to != vertex[k];
        vertex[k] = to;
    }
    PD_DELETE(ctx, n, cube);
    return PD_OK;
}
