/* skin: see skin.h */
#include "io/skin.h"
#include "core/vec.h"
#include "lattice/weld.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Maximum number of cells that the area of a face is distributed to. */
#define PDI_SKIN_CELLS 96
/* Relative pivot below which the centroids around a face count as linearly dependent (squared lengths). */
#define PDI_SKIN_SPAN 1e-6
/* Tolerance of negative weights for rounding. */
#define PDI_SKIN_ROUNDING 1e-12

/* Faces of a cell type and their corners, in turn by the right-hand rule with the normal out of a cell of positive
 * volume; -1 behind the last corner of a face. */
typedef struct pdi_skin_form {
    int faces;
    int8_t corner[6][4];
} pdi_skin_form;

/* Faces of a cell type. */
static const pdi_skin_form *pdi_skin_of(pdi_cell_form form)
{
    static const pdi_skin_form forms[8] = {
        {0, {{0}}},
        {2, {{0, -1, -1, -1}, {1, -1, -1, -1}}},
        {3, {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 0, -1, -1}}},
        {4, {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 3, -1, -1}, {3, 0, -1, -1}}},
        {4, {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {0, 3, 2, -1}}},
        {6, {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}},
        {5, {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
        {5, {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}}};
    return &forms[form];
}

/* Area vector of a face. In 3D half the cross product of the diagonals, which also holds for a face that is not
 * plane. */
static void pdi_skin_area(int corners, const double *const *x, double *area)
{
    if (PD_DIM == 2) {
        area[0] = x[1][1] - x[0][1];
        area[1] = x[0][0] - x[1][0];
    } else if (PD_DIM == 3) {
        const double *last = x[corners - 1], *from = corners == 4 ? x[1] : x[0];
        for (int d = 0; d < PD_DIM; d++) {
            int e = (d + 1) % 3, f = (d + 2) % 3;
            area[d] = 0.5 * ((x[corners - 2][e] - x[0][e]) * (last[f] - from[f]) -
                             (x[corners - 2][f] - x[0][f]) * (last[e] - from[e]));
        }
    }
}

/* Centroid of a face; of a quadrilateral from its two triangles. */
static void pdi_skin_middle(int corners, const double *const *x, double *centroid)
{
    double size[2] = {1.0, 0.0};
    for (int t = 0; t < 2 && PD_DIM == 3 && corners == 4; t++) {
        double area[3] = {0.0, 0.0, 0.0};
        const double *const half[3] = {x[0], x[1 + t], x[2 + t]};
        pdi_skin_area(3, half, area);
        size[t] = sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    }
    for (int d = 0; d < PD_DIM; d++) {
        double sum = 0.0;
        centroid[d] = 0.0;
        for (int k = 0; k < corners; k++) sum += (x[k][d] - x[0][d]) / corners;
        for (int t = 0; t < 2 && corners == 4; t++)
            centroid[d] += size[t] / (size[0] + size[1]) * ((x[1 + t][d] - x[0][d]) + (x[2 + t][d] - x[0][d])) / 3.0;
        centroid[d] = x[0][d] + (corners == 4 ? centroid[d] : sum);
    }
}

/* Double the capacity. */
static pd_status pdi_skin_grow(pd_ctx *ctx, pdi_skin *s)
{
    pdi_skin_face *face;
    int64_t room = 2 * s->room + 64;
    PDI_TRY(PDI_NEW(ctx, "skin", room, face));
    if (s->count) memcpy(face, s->face, (size_t)s->count * sizeof *face);
    PDI_DELETE(ctx, s->room, s->face);
    s->face = face;
    s->room = room;
    return PD_OK;
}

/* Sort four node ids ascending. */
static void pdi_skin_sort(int64_t *node)
{
    for (int a = 1; a < 4; a++)
        for (int b = a; b > 0 && node[b] < node[b - 1]; b--) {
            int64_t other = node[b];
            node[b] = node[b - 1];
            node[b - 1] = other;
        }
}

/* Returns 1 when the area vector of a face points away from the centre of its cell, else -1: a cell may be inverted or
 * mirrored. */
static int8_t pdi_skin_sense(pdi_cell_form form, const double *const *corner, const double *const *x, int corners)
{
    double along = 0.0, area[3] = {1.0, 0.0, 0.0};
    int all = pdi_points_corners(form);
    pdi_skin_area(corners, x, area);
    for (int d = 0; d < PD_DIM; d++) {
        double middle = 0.0, at = 0.0;
        for (int k = 0; k < all; k++) middle += (corner[k][d] - x[0][d]) / all;
        for (int k = 0; k < corners; k++) at += (x[k][d] - x[0][d]) / corners;
        along += area[d] * (at - middle);
    }
    return along < 0.0 ? -1 : 1;
}

/* Outward area vector [the file's unit to the power PD_DIM - 1] and centroid [the file's unit] of a face. */
static void pdi_skin_measure(const pdi_skin_face *face, double *area, double *centroid)
{
    const double *x[4];
    for (int k = 0; k < 4; k++) x[k] = face->x[k < face->corners ? k : 0];
    area[0] = 1.0;
    pdi_skin_area(face->corners, x, area);
    pdi_skin_middle(face->corners, x, centroid);
    for (int d = 0; d < PD_DIM; d++) area[d] *= face->sense;
}

PDI_FN pd_status pdi_skin_add(pd_ctx *ctx, pdi_skin *s, pdi_cell_form form, const int64_t *node,
                              const double *const *corner, int32_t cell)
{
    const pdi_skin_form *f = pdi_skin_of(form);
    for (int k = 0; k < f->faces; k++) {
        const double *x[4];
        int corners = 0;
        if (s->count == s->room) PDI_TRY(pdi_skin_grow(ctx, s));
        pdi_skin_face *face = &s->face[s->count++];
        for (int c = 0; c < 4; c++) {
            face->node[c] = INT64_MAX;
            if (f->corner[k][c] < 0) continue;
            face->node[c] = node[f->corner[k][c]];
            x[corners++] = corner[f->corner[k][c]];
        }
        face->cell = cell;
        face->part = s->part;
        face->corners = (int8_t)corners;
        for (int c = 0; c < corners; c++) memcpy(face->x[c], x[c], sizeof face->x[c]);
        face->sense = pdi_skin_sense(form, corner, x, corners);
        pdi_skin_sort(face->node);
    }
    return PD_OK;
}

/* Order of faces by their nodes, then by cell, for qsort. */
static int pdi_skin_compare(const void *a, const void *b)
{
    const pdi_skin_face *p = (const pdi_skin_face *)a, *q = (const pdi_skin_face *)b;
    for (int k = 0; k < 4; k++)
        if (p->node[k] != q->node[k]) return p->node[k] > q->node[k] ? 1 : -1;
    return (p->cell > q->cell) - (p->cell < q->cell);
}

/* A pair of a node and a cell that has it. */
typedef struct pdi_skin_link {
    int64_t node;
    int32_t cell;
} pdi_skin_link;

/* Order of these pairs by node, then by cell, for qsort. */
static int pdi_skin_compare_links(const void *a, const void *b)
{
    const pdi_skin_link *p = (const pdi_skin_link *)a, *q = (const pdi_skin_link *)b;
    if (p->node != q->node) return p->node > q->node ? 1 : -1;
    return (p->cell > q->cell) - (p->cell < q->cell);
}

/* List all pairs of nodes and cells, sorted and without duplicates; *count of them. */
static void pdi_skin_links(const pdi_skin *s, pdi_skin_link *link, int64_t *count)
{
    int64_t n = 0, all = 0;
    for (int64_t k = 0; k < s->count; k++)
        for (int c = 0; c < 4; c++) {
            if (s->face[k].node[c] == INT64_MAX) continue;
            link[all].node = s->face[k].node[c];
            link[all++].cell = s->face[k].cell;
        }
    if (all) qsort(link, (size_t)all, sizeof *link, pdi_skin_compare_links);
    for (int64_t k = 0; k < all; k++)
        if (k == 0 || pdi_skin_compare_links(&link[k], &link[k - 1]) != 0) link[n++] = link[k];
    *count = n;
}

/* Cells that share a node with a face, its own first, into cell[PDI_SKIN_CELLS]. Returns their number. */
static int pdi_skin_around(const pdi_skin_face *face, const pdi_skin_link *link, int64_t count, int32_t *cell)
{
    int n = 1;
    cell[0] = face->cell;
    for (int c = 0; c < 4 && face->node[c] != INT64_MAX; c++) {
        int64_t low = 0, high = count;
        while (low < high) {
            int64_t middle = low + (high - low) / 2;
            if (link[middle].node < face->node[c]) low = middle + 1;
            else high = middle;
        }
        for (; low < count && link[low].node == face->node[c] && n < PDI_SKIN_CELLS; low++) {
            int known = 0;
            for (int k = 0; k < n; k++) known = known || cell[k] == link[low].cell;
            if (!known) cell[n++] = link[low].cell;
        }
    }
    return n;
}

/* The cells that a face is distributed to, and their weights. */
typedef struct pdi_skin_part {
    int cells;
    int32_t cell[PDI_SKIN_CELLS];
    double along[PDI_SKIN_CELLS * PD_DIM]; /* [-] centroids relative to that of the face, in its plane, scaled */
    double ease[PDI_SKIN_CELLS];           /* [-] inverse penalty of a weight: less for cells deep below; 0: excluded */
    double share[PDI_SKIN_CELLS];          /* [-] the weights */
} pdi_skin_part;

/* Weights nearest to the own cell alone with sum 1 and a centroid on the normal of the face, by the normal equations of
 * constrained least squares. Returns 0 when they are singular. */
static int pdi_skin_solve(const double *normal, pdi_skin_part *s)
{
    enum { ROWS = PD_DIM + 1 };
    double a[ROWS * ROWS], x[ROWS], min_pivot[ROWS];
    for (int p = 0; p < ROWS; p++) {
        for (int q = 0; q < ROWS; q++) {
            a[p * ROWS + q] = p && q ? normal[p - 1] * normal[q - 1] : 0.0; /* that direction is free */
            for (int k = 0; k < s->cells; k++)
                a[p * ROWS + q] += s->ease[k] * (p ? s->along[k * PD_DIM + p - 1] : 1.0) *
                                   (q ? s->along[k * PD_DIM + q - 1] : 1.0);
        }
        x[p] = p ? -s->along[p - 1] : 0.0;
        min_pivot[p] = PDI_SKIN_SPAN * a[p * ROWS + p];
    }
    if (!pdi_vec_factor(ROWS, ROWS, min_pivot, a)) return 0;
    pdi_vec_substitute(ROWS, ROWS, a, x);
    for (int k = 0; k < s->cells; k++) {
        double correction = x[0];
        for (int d = 0; d < PD_DIM; d++) correction += x[1 + d] * s->along[k * PD_DIM + d];
        s->share[k] = (k == 0) + s->ease[k] * correction;
    }
    return 1;
}

/* Non-negative weights where possible: cells with the most negative weight are excluded one by one (active set).
 * Otherwise the first solution stays, or the own cell alone. */
static void pdi_skin_shares(const double *normal, pdi_skin_part *s)
{
    double first[PDI_SKIN_CELLS] = {1.0};
    for (int found = 0, worst = 1; worst; found = 1) {
        worst = 0;
        if (!pdi_skin_solve(normal, s) || (found && s->share[0] < 0.0)) {
            memcpy(s->share, first, sizeof first);
            return;
        }
        if (!found) memcpy(first, s->share, sizeof first);
        for (int k = 1; k < s->cells; k++)
            if (s->share[k] < -PDI_SKIN_ROUNDING && (!worst || s->share[k] < s->share[worst])) worst = k;
        if (worst) s->ease[worst] = 0.0;
    }
}

/* Distribute the area of a face to the points around it. size: factor from areas of the file to SI units. */
static void pdi_skin_give(const pdi_skin_face *face, const pdi_skin_link *link, int64_t link_count, double scale,
                          double size, pd_points *points)
{
    pdi_skin_part s;
    double area_vector[PD_DIM], centroid[PD_DIM], normal[PD_DIM], longest = 0.0, depth = 0.0;
    pdi_skin_measure(face, area_vector, centroid);
    double area = pdi_vec_norm(area_vector);
    s.cells = area > 0.0 ? pdi_skin_around(face, link, link_count, s.cell) : 0;
    for (int d = 0; d < PD_DIM; d++) normal[d] = area > 0.0 ? area_vector[d] / area : 0.0;
    for (int k = 0; k < s.cells; k++) {
        double *along = s.along + k * PD_DIM, cell_depth = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            along[d] = points->position[(int64_t)s.cell[k] * PD_DIM + d] - scale * centroid[d];
            cell_depth -= along[d] * normal[d];
        }
        for (int d = 0; d < PD_DIM; d++) along[d] += cell_depth * normal[d];
        if (k == 0) depth = cell_depth;
        s.ease[k] = cell_depth > depth ? depth / cell_depth * (depth / cell_depth) : 1.0;
        longest = pdi_max(longest, pdi_vec_norm(along));
    }
    for (int k = 0; k < s.cells * PD_DIM && longest > 0.0; k++) s.along[k] /= longest;
    if (s.cells) pdi_skin_shares(normal, &s);
    for (int k = 0; k < s.cells; k++)
        for (int d = 0; d < PD_DIM; d++)
            points->surface[(int64_t)s.cell[k] * PD_DIM + d] += s.share[k] * size * area_vector[d];
}

/* Move the faces that belong to one cell only to the front. Returns their number. */
static int64_t pdi_skin_single(pdi_skin *s)
{
    int64_t count = 0;
    if (s->count) qsort(s->face, (size_t)s->count, sizeof *s->face, pdi_skin_compare);
    for (int64_t k = 0, next; k < s->count; k = next) {
        next = k + 1;
        while (next < s->count && !memcmp(s->face[next].node, s->face[k].node, sizeof s->face->node)) next++;
        if (next == k + 1) s->face[count++] = s->face[k];
    }
    return count;
}

/* ---- coincident nodes ---- */

/* A boundary face by its merged vertices. */
typedef struct pdi_skin_place {
    int32_t vertex[4]; /* ascending; INT32_MAX behind the last one */
    int64_t face;
} pdi_skin_place;

/* Order of faces by merged vertices, then by index, for qsort. */
static int pdi_skin_compare_places(const void *a, const void *b)
{
    const pdi_skin_place *p = (const pdi_skin_place *)a, *q = (const pdi_skin_place *)b;
    for (int k = 0; k < 4; k++)
        if (p->vertex[k] != q->vertex[k]) return p->vertex[k] > q->vertex[k] ? 1 : -1;
    return (p->face > q->face) - (p->face < q->face);
}

/* Order of integers, for qsort. */
static int pdi_skin_compare_numbers(const void *a, const void *b)
{
    int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/* Number of distinct values among n integers, which are sorted. */
static int64_t pdi_skin_distinct(int64_t *number, int64_t n)
{
    int64_t count = 0;
    if (n) qsort(number, (size_t)n, sizeof *number, pdi_skin_compare_numbers);
    for (int64_t k = 0; k < n; k++) count += k == 0 || number[k] != number[k - 1];
    return count;
}

/* Merged vertex of each corner of the first `count` faces, 4 a face: coincident corners have the same one. */
static pd_status pdi_skin_vertices(pd_ctx *ctx, const pdi_skin *s, int64_t count, double *corner, int32_t *vertex)
{
    int32_t *root = NULL, joined = 0, n = (int32_t)(4 * count);
    for (int64_t k = 0; k < n; k++) /* missing corners of a face repeat its first one */
        for (int d = 0; d < PD_DIM; d++)
            corner[3 * k + d] = s->face[k / 4].x[k % 4 < s->face[k / 4].corners ? k % 4 : 0][d];
    PDI_TRY(pdi_weld_exact(ctx, corner, n, vertex));
    PDI_TRY(PDI_NEW(ctx, "skin", n, root));
    pd_status status = pdi_weld_near(ctx, corner, n, vertex, root, &joined);
    PDI_DELETE(ctx, n, root);
    return status;
}

/* Find coincident faces in the sorted list: those of two pieces of the file are shared (no boundary), others are seams.
 * nodes[2][4 count]: nodes of the seams, and their merged vertices. Returns how many entries each has. */
static int64_t pdi_skin_pairs(const pdi_skin *s, const pdi_skin_place *place, int64_t count, uint8_t *shared,
                              int64_t *nodes, pd_points *points)
{
    int64_t n = 0;
    for (int64_t k = 0, next; k < count; k = next) {
        for (next = k + 1; next < count && !memcmp(place[next].vertex, place[k].vertex, sizeof place->vertex);) next++;
        if (next == k + 1) continue;
        int parts = next == k + 2 && s->face[place[k].face].part != s->face[place[k + 1].face].part;
        for (int64_t m = k; m < next; m++) {
            const pdi_skin_face *face = &s->face[place[m].face];
            shared[place[m].face] = (uint8_t)parts;
            points->seams += !parts;
            for (int c = 0; c < face->corners && !parts; c++) {
                nodes[n] = face->node[c];
                nodes[4 * count + n++] = place[m].vertex[c];
            }
        }
    }
    return n;
}

/* Mark the faces that pieces of the file share among the first `count`, and count seams and coincident nodes. */
static pd_status pdi_skin_match(pd_ctx *ctx, const pdi_skin *s, int64_t count, uint8_t *shared, pd_points *points)
{
    pdi_skin_place *place = NULL;
    double *corner = NULL;
    int32_t *vertex = NULL;
    int64_t *nodes = NULL;
    if (count == 0 || 4 * count > INT32_MAX) return PD_OK;
    pd_status status = PDI_NEW(ctx, "skin", count, place);
    if (status == PD_OK) status = PDI_NEW(ctx, "skin", 12 * count, corner);
    if (status == PD_OK) status = PDI_NEW(ctx, "skin", 4 * count, vertex);
    if (status == PD_OK) status = PDI_NEW(ctx, "skin", 8 * count, nodes);
    if (status == PD_OK) status = pdi_skin_vertices(ctx, s, count, corner, vertex);
    for (int64_t k = 0; k < count && status == PD_OK; k++) {
        place[k].face = k;
        for (int c = 0; c < 4; c++) {
            int to = c;
            int32_t own = c < s->face[k].corners ? vertex[4 * k + c] : INT32_MAX;
            for (; to > 0 && place[k].vertex[to - 1] > own; to--) place[k].vertex[to] = place[k].vertex[to - 1];
            place[k].vertex[to] = own;
        }
    }
    if (status == PD_OK) {
        qsort(place, (size_t)count, sizeof *place, pdi_skin_compare_places);
        int64_t n = pdi_skin_pairs(s, place, count, shared, nodes, points);
        points->twins = pdi_skin_distinct(nodes, n) - pdi_skin_distinct(nodes + 4 * count, n);
    }
    PDI_DELETE(ctx, 8 * count, nodes);
    PDI_DELETE(ctx, 4 * count, vertex);
    PDI_DELETE(ctx, 12 * count, corner);
    PDI_DELETE(ctx, count, place);
    return status;
}

/* ---- boundary ---- */

/* Store the boundary faces as simplices (points, segments, triangles). */
static pd_status pdi_skin_faces(pd_ctx *ctx, const pdi_skin *s, int64_t count, const uint8_t *shared, double scale,
                                pd_points *points)
{
    int64_t faces = 0;
    for (int64_t k = 0; k < count; k++) faces += shared[k] ? 0 : s->face[k].corners == 4 ? 2 : 1;
    PDI_TRY(pdi_points_face(ctx, points, faces));
    double *to = points->face;
    for (int64_t k = 0; k < count; k++)
        for (int t = 0; t < (shared[k] ? 0 : s->face[k].corners == 4 ? 2 : 1); t++)
            for (int c = 0; c < PD_DIM; c++)
                for (int d = 0; d < PD_DIM; d++) *to++ = scale * s->face[k].x[c ? c + t : 0][d];
    return PD_OK;
}

PDI_FN pd_status pdi_skin_close(pd_ctx *ctx, pdi_skin *s, double scale, pd_points *points)
{
    double size = 1.0;
    int64_t links = 0, rooms = 4 * s->count;
    pdi_skin_link *link = NULL;
    uint8_t *shared = NULL;
    for (int d = 1; d < PD_DIM; d++) size *= scale;
    PDI_TRY(PDI_NEW(ctx, "skin", rooms, link));
    pdi_skin_links(s, link, &links);
    int64_t count = pdi_skin_single(s);
    pd_status status = PDI_NEW(ctx, "skin", count, shared);
    if (status == PD_OK) status = pdi_skin_match(ctx, s, count, shared, points);
    if (status == PD_OK) status = pdi_skin_faces(ctx, s, count, shared, scale, points);
    for (int64_t k = 0; k < count && status == PD_OK; k++)
        if (!shared[k]) pdi_skin_give(&s->face[k], link, links, scale, size, points);
    PDI_DELETE(ctx, count, shared);
    PDI_DELETE(ctx, rooms, link);
    return status;
}

PDI_FN void pdi_skin_free(pd_ctx *ctx, pdi_skin *s)
{
    PDI_DELETE(ctx, s->room, s->face);
    memset(s, 0, sizeof *s);
}

#undef PDI_SKIN_CELLS
#undef PDI_SKIN_SPAN
#undef PDI_SKIN_ROUNDING
