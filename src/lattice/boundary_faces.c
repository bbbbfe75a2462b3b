/* boundary_faces: see boundary_faces.h */
#include "lattice/boundary_faces.h"
#include "core/vec.h"
#include "lattice/vertex_merge.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Relative pivot below which the centroids around a face count as linearly dependent (squared lengths). */
#define PDI_BOUNDARY_FACES_MIN_PIVOT 1e-6
/* Tolerance of negative weights for rounding. */
#define PDI_BOUNDARY_FACES_WEIGHT_TOLERANCE 1e-12

/* Faces of a cell type and their corners, in turn by the right-hand rule with the normal out of a cell of positive
 * volume; -1 behind the last corner of a face. */
typedef struct pdi_boundary_faces_form {
    int faces;
    int8_t corner[6][4];
} pdi_boundary_faces_form;

/* Faces of a cell type and their corners, from a static table. */
static const pdi_boundary_faces_form *pdi_boundary_faces_get_form(pd_points_cell_type form)
{
    static const pdi_boundary_faces_form forms[8] = {
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

/* area [PD_DIM] = area vector of a face with the corners x [corners][PD_DIM], in their unit; its direction follows from
 * their order. 3D: half the cross product of the diagonals, also for a face that is not plane. 1D: left alone. */
static void pdi_boundary_faces_compute_area(int corners, const double *const *x, double *area)
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

/* centroid [PD_DIM] of a face with the corners x [corners][PD_DIM], in their unit: the mean of its corners; of a
 * quadrilateral that of its two triangles, weighted by their areas. */
static void pdi_boundary_faces_compute_centroid(int corners, const double *const *x, double *centroid)
{
    double size[2] = {1.0, 0.0};
    for (int t = 0; t < 2 && PD_DIM == 3 && corners == 4; t++) {
        double area[3] = {0.0, 0.0, 0.0};
        const double *const half[3] = {x[0], x[1 + t], x[2 + t]};
        pdi_boundary_faces_compute_area(3, half, area);
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

/* Grow the array of faces to twice its capacity and 64 more. */
static pd_status pdi_boundary_faces_grow(pd_ctx *ctx, pd_boundary_faces *s)
{
    pd_boundary_faces_face *face;
    int64_t room = 2 * s->capacity + 64;
    PD_TRY(PD_NEW(ctx, "skin", room, face));
    if (s->count) memcpy(face, s->face, (size_t)s->count * sizeof *face);
    PD_DELETE(ctx, s->capacity, s->face);
    s->face = face;
    s->capacity = room;
    return PD_OK;
}

/* Sort four node ids ascending. */
static void pdi_boundary_faces_sort_nodes(int64_t *node)
{
    for (int a = 1; a < 4; a++)
        for (int b = a; b > 0 && node[b] < node[b - 1]; b--) {
            int64_t other = node[b];
            node[b] = node[b - 1];
            node[b - 1] = other;
        }
}

/* Returns 1 when the area vector of a face points away from the mean of all corners of its cell, or is normal to that
 * direction, else -1: a cell may be inverted or mirrored. 1D: the area vector is +x. */
static int8_t pdi_boundary_faces_compute_orientation(pd_points_cell_type form, const double *const *corner,
                                                     const double *const *x, int corners)
{
    double along = 0.0, area[3] = {1.0, 0.0, 0.0};
    int all = pd_points_count_corners(form);
    pdi_boundary_faces_compute_area(corners, x, area);
    for (int d = 0; d < PD_DIM; d++) {
        double middle = 0.0, at = 0.0;
        for (int k = 0; k < all; k++) middle += (corner[k][d] - x[0][d]) / all;
        for (int k = 0; k < corners; k++) at += (x[k][d] - x[0][d]) / corners;
        along += area[d] * (at - middle);
    }
    return along < 0.0 ? -1 : 1;
}

/* Outward area vector [the file's unit to the power PD_DIM - 1] and centroid [the file's unit] of a face. */
static void pdi_boundary_faces_area_and_centroid(const pd_boundary_faces_face *face, double *area, double *centroid)
{
    const double *x[4];
    for (int k = 0; k < 4; k++) x[k] = face->x[k < face->corners ? k : 0];
    area[0] = 1.0;
    pdi_boundary_faces_compute_area(face->corners, x, area);
    pdi_boundary_faces_compute_centroid(face->corners, x, centroid);
    for (int d = 0; d < PD_DIM; d++) area[d] *= face->orientation;
}

pd_status pd_boundary_faces_add_cell(pd_ctx *ctx, pd_boundary_faces *s, pd_points_cell_type form,
                                             const int64_t *node, const double *const *corner, int32_t cell)
{
    const pdi_boundary_faces_form *f = pdi_boundary_faces_get_form(form);
    for (int k = 0; k < f->faces; k++) {
        const double *x[4];
        int corners = 0;
        if (s->count == s->capacity) PD_TRY(pdi_boundary_faces_grow(ctx, s));
        pd_boundary_faces_face *face = &s->face[s->count++];
        for (int c = 0; c < 4; c++) {
            face->node[c] = INT64_MAX;
            if (f->corner[k][c] < 0) continue;
            face->node[c] = node[f->corner[k][c]];
            x[corners++] = corner[f->corner[k][c]];
        }
        face->cell = cell;
        face->piece = s->piece;
        face->corners = (int8_t)corners;
        for (int c = 0; c < corners; c++) memcpy(face->x[c], x[c], sizeof face->x[c]);
        face->orientation = pdi_boundary_faces_compute_orientation(form, corner, x, corners);
        pdi_boundary_faces_sort_nodes(face->node);
    }
    return PD_OK;
}

/* Order of faces by their nodes, then by cell, for qsort. */
static int pdi_boundary_faces_compare_faces(const void *a, const void *b)
{
    const pd_boundary_faces_face *p = (const pd_boundary_faces_face *)a, *q = (const pd_boundary_faces_face *)b;
    for (int k = 0; k < 4; k++)
        if (p->node[k] != q->node[k]) return p->node[k] > q->node[k] ? 1 : -1;
    return (p->cell > q->cell) - (p->cell < q->cell);
}

/* A pair of a node and a cell that has it. */
typedef struct pdi_boundary_faces_node_cell {
    int64_t node;
    int32_t cell;
} pdi_boundary_faces_node_cell;

/* Order of these pairs by node, then by cell, for qsort. */
static int pdi_boundary_faces_compare_node_cells(const void *a, const void *b)
{
    const pdi_boundary_faces_node_cell *p = (const pdi_boundary_faces_node_cell *)a,
                                       *q = (const pdi_boundary_faces_node_cell *)b;
    if (p->node != q->node) return p->node > q->node ? 1 : -1;
    return (p->cell > q->cell) - (p->cell < q->cell);
}

/* List all pairs of a node and a cell of all faces into link [4 faces], sorted by node, without duplicates; *count of
 * them. */
static void pdi_boundary_faces_list_node_cells(const pd_boundary_faces *s, pdi_boundary_faces_node_cell *link,
                                               int64_t *count)
{
    int64_t n = 0, all = 0;
    for (int64_t k = 0; k < s->count; k++)
        for (int c = 0; c < 4; c++) {
            if (s->face[k].node[c] == INT64_MAX) continue;
            link[all].node = s->face[k].node[c];
            link[all++].cell = s->face[k].cell;
        }
    if (all) qsort(link, (size_t)all, sizeof *link, pdi_boundary_faces_compare_node_cells);
    for (int64_t k = 0; k < all; k++)
        if (k == 0 || pdi_boundary_faces_compare_node_cells(&link[k], &link[k - 1]) != 0) link[n++] = link[k];
    *count = n;
}

/* Index of the first of the sorted pairs link[count] that is not before `node` and `cell`; count: all are. */
static int64_t pdi_boundary_faces_find_link(const pdi_boundary_faces_node_cell *link, int64_t count, int64_t node,
                                            int32_t cell)
{
    const pdi_boundary_faces_node_cell wanted = {node, cell};
    int64_t low = 0, high = count;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (pdi_boundary_faces_compare_node_cells(&link[middle], &wanted) < 0) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Number of pairs of the nodes of a face in the sorted pairs link[count]. */
static int64_t pdi_boundary_faces_count_links(const pd_boundary_faces_face *face,
                                              const pdi_boundary_faces_node_cell *link, int64_t count)
{
    int64_t n = 0;
    for (int c = 0; c < 4 && face->node[c] != INT64_MAX; c++)
        n += pdi_boundary_faces_find_link(link, count, face->node[c], INT32_MAX) -
             pdi_boundary_faces_find_link(link, count, face->node[c], 0);
    return n;
}

/* Cells that share a node with a face, its own first, each once, into `cell`, which has room for all links of the face,
 * by the sorted pairs link[count]. Returns their number. */
static int32_t pdi_boundary_faces_find_adjacent_cells(const pd_boundary_faces_face *face,
                                                      const pdi_boundary_faces_node_cell *link, int64_t count,
                                                      int32_t *cell)
{
    int32_t n = 1;
    cell[0] = face->cell;
    for (int c = 0; c < 4 && face->node[c] != INT64_MAX; c++) {
        int64_t k = pdi_boundary_faces_find_link(link, count, face->node[c], 0);
        for (; k < count && link[k].node == face->node[c]; k++) {
            int known = link[k].cell == face->cell;
            for (int b = 0; b < c && !known; b++) {
                int64_t at = pdi_boundary_faces_find_link(link, count, face->node[b], link[k].cell);
                known = at < count && link[at].node == face->node[b] && link[at].cell == link[k].cell;
            }
            if (!known) cell[n++] = link[k].cell;
        }
    }
    return n;
}

/* The cells that a face is distributed to, and their weights. Arrays have room for the cells of any face. */
typedef struct pdi_boundary_faces_weights {
    int32_t cells;
    int64_t room;
    int32_t *cell;           /* [room] */
    double *offset;          /* [room][PD_DIM] [-] centroids relative to that of the face, in its plane, scaled */
    double *inverse_penalty; /* [room] [-] inverse penalty of a weight: less for cells deep below; 0: excluded */
    double *weight;          /* [room] [-] the weights */
    double *first;           /* [room] [-] those of the first solution */
} pdi_boundary_faces_weights;

/* Allocates the arrays of *s, zero before, for the cells around any of the first `count` faces that is not shared. The
 * caller frees them, after an error, too. */
static pd_status pdi_boundary_faces_reserve_weights(pd_ctx *ctx, const pd_boundary_faces *faces, int64_t count,
                                                    const uint8_t *shared, const pdi_boundary_faces_node_cell *link,
                                                    int64_t link_count, pdi_boundary_faces_weights *s)
{
    s->room = 1;
    for (int64_t k = 0; k < count; k++) {
        int64_t links = shared[k] ? 0 : pdi_boundary_faces_count_links(&faces->face[k], link, link_count);
        if (links > s->room) s->room = links;
    }
    PD_TRY(PD_NEW(ctx, "skin", s->room, s->cell));
    PD_TRY(PD_NEW(ctx, "skin", s->room * PD_DIM, s->offset));
    PD_TRY(PD_NEW(ctx, "skin", s->room, s->inverse_penalty));
    PD_TRY(PD_NEW(ctx, "skin", s->room, s->weight));
    return PD_NEW(ctx, "skin", s->room, s->first);
}

/* Frees the arrays of *s. */
static void pdi_boundary_faces_free_weights(pd_ctx *ctx, pdi_boundary_faces_weights *s)
{
    PD_DELETE(ctx, s->room, s->cell);
    PD_DELETE(ctx, s->room * PD_DIM, s->offset);
    PD_DELETE(ctx, s->room, s->inverse_penalty);
    PD_DELETE(ctx, s->room, s->weight);
    PD_DELETE(ctx, s->room, s->first);
}

/* Set s->weight: nearest to the own cell (number 0) alone, with sum 1 and a centroid on the unit `normal` of the face,
 * by the normal equations of constrained least squares. Returns 1; 0: these are singular, weights are left alone. */
static int pdi_boundary_faces_solve_weights(const double *normal, pdi_boundary_faces_weights *s)
{
    enum { ROWS = PD_DIM + 1 };
    double a[ROWS * ROWS], x[ROWS], min_pivot[ROWS];
    for (int p = 0; p < ROWS; p++) {
        for (int q = 0; q < ROWS; q++) {
            a[p * ROWS + q] = p && q ? normal[p - 1] * normal[q - 1] : 0.0; /* that direction is free */
            for (int k = 0; k < s->cells; k++)
                a[p * ROWS + q] += s->inverse_penalty[k] * (p ? s->offset[k * PD_DIM + p - 1] : 1.0) *
                                   (q ? s->offset[k * PD_DIM + q - 1] : 1.0);
        }
        x[p] = p ? -s->offset[p - 1] : 0.0;
        min_pivot[p] = PDI_BOUNDARY_FACES_MIN_PIVOT * a[p * ROWS + p];
    }
    if (!pdi_vec_cholesky(ROWS, ROWS, min_pivot, a)) return 0;
    pdi_vec_cholesky_solve(ROWS, ROWS, a, x);
    for (int k = 0; k < s->cells; k++) {
        double correction = x[0];
        for (int d = 0; d < PD_DIM; d++) correction += x[1 + d] * s->offset[k * PD_DIM + d];
        s->weight[k] = (k == 0) + s->inverse_penalty[k] * correction;
    }
    return 1;
}

/* Set s->weight, non-negative where possible: the cell with the most negative weight (below
 * -PDI_BOUNDARY_FACES_WEIGHT_TOLERANCE) is excluded, its inverse_penalty becomes 0, and the rest is solved again
 * (active set). The first solution, which has negative weights, stays when a later one is singular or makes the own
 * cell (number 0) negative; the own cell alone counts when the first one is singular. */
static void pdi_boundary_faces_compute_weights(const double *normal, pdi_boundary_faces_weights *s)
{
    size_t bytes = (size_t)s->cells * sizeof *s->weight;
    memset(s->first, 0, bytes);
    s->first[0] = 1.0;
    for (int found = 0, worst = 1; worst; found = 1) {
        worst = 0;
        if (!pdi_boundary_faces_solve_weights(normal, s) || (found && s->weight[0] < 0.0)) {
            memcpy(s->weight, s->first, bytes);
            return;
        }
        if (!found) memcpy(s->first, s->weight, bytes);
        for (int k = 1; k < s->cells; k++)
            if (s->weight[k] < -PDI_BOUNDARY_FACES_WEIGHT_TOLERANCE && (!worst || s->weight[k] < s->weight[worst]))
                worst = k;
        if (worst) s->inverse_penalty[worst] = 0.0;
    }
}

/* Add the outward area vector of a face, times weights, to boundary_area of the points of the cells that share a node
 * with it; nothing for a face without area. link: as of pdi_boundary_faces_list_node_cells. Centroids deeper below the
 * face than that of its own cell have a lower weight. scale, size: factors from lengths and areas of the file to SI
 * units. s: the arrays to work in. */
static void pdi_boundary_faces_distribute_area(const pd_boundary_faces_face *face,
                                               const pdi_boundary_faces_node_cell *link, int64_t link_count,
                                               double scale, double size, pdi_boundary_faces_weights *s,
                                               pd_points *points)
{
    double area_vector[PD_DIM], centroid[PD_DIM], normal[PD_DIM], longest = 0.0, depth = 0.0;
    pdi_boundary_faces_area_and_centroid(face, area_vector, centroid);
    double area = pdi_vec_norm(area_vector);
    s->cells = area > 0.0 ? pdi_boundary_faces_find_adjacent_cells(face, link, link_count, s->cell) : 0;
    for (int d = 0; d < PD_DIM; d++) normal[d] = area > 0.0 ? area_vector[d] / area : 0.0;
    for (int k = 0; k < s->cells; k++) {
        double *along = s->offset + k * PD_DIM, cell_depth = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            along[d] = points->position[(int64_t)s->cell[k] * PD_DIM + d] - scale * centroid[d];
            cell_depth -= along[d] * normal[d];
        }
        for (int d = 0; d < PD_DIM; d++) along[d] += cell_depth * normal[d];
        if (k == 0) depth = cell_depth;
        s->inverse_penalty[k] = cell_depth > depth ? depth / cell_depth * (depth / cell_depth) : 1.0;
        longest = pd_max(longest, pdi_vec_norm(along));
    }
    for (int k = 0; k < s->cells * PD_DIM && longest > 0.0; k++) s->offset[k] /= longest;
    if (s->cells) pdi_boundary_faces_compute_weights(normal, s);
    for (int k = 0; k < s->cells; k++)
        for (int d = 0; d < PD_DIM; d++)
            points->boundary_area[(int64_t)s->cell[k] * PD_DIM + d] += s->weight[k] * size * area_vector[d];
}

/* Sort the faces by nodes and move those that belong to one cell only to the front. Returns their number; what stands
 * behind them has no meaning. */
static int64_t pdi_boundary_faces_extract_unshared(pd_boundary_faces *s)
{
    int64_t count = 0;
    if (s->count) qsort(s->face, (size_t)s->count, sizeof *s->face, pdi_boundary_faces_compare_faces);
    for (int64_t k = 0, next; k < s->count; k = next) {
        next = k + 1;
        while (next < s->count && !memcmp(s->face[next].node, s->face[k].node, sizeof s->face->node)) next++;
        if (next == k + 1) s->face[count++] = s->face[k];
    }
    return count;
}

/* ---- coincident nodes ---- */

/* A boundary face by its merged vertices. */
typedef struct pdi_boundary_faces_merged_face {
    int32_t vertex[4]; /* ascending; INT32_MAX behind the last one */
    int64_t face;
} pdi_boundary_faces_merged_face;

/* Order of faces by merged vertices, then by index, for qsort. */
static int pdi_boundary_faces_compare_merged(const void *a, const void *b)
{
    const pdi_boundary_faces_merged_face *p = (const pdi_boundary_faces_merged_face *)a,
                                         *q = (const pdi_boundary_faces_merged_face *)b;
    for (int k = 0; k < 4; k++)
        if (p->vertex[k] != q->vertex[k]) return p->vertex[k] > q->vertex[k] ? 1 : -1;
    return (p->face > q->face) - (p->face < q->face);
}

/* Order of integers, for qsort. */
static int pdi_boundary_faces_compare_numbers(const void *a, const void *b)
{
    int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/* Sort number [n] in place, and return how many distinct values it has. */
static int64_t pdi_boundary_faces_count_distinct(int64_t *number, int64_t n)
{
    int64_t count = 0;
    if (n) qsort(number, (size_t)n, sizeof *number, pdi_boundary_faces_compare_numbers);
    for (int64_t k = 0; k < n; k++) count += k == 0 || number[k] != number[k - 1];
    return count;
}

/* vertex [4 count] = merged vertex of each corner of the first `count` faces, 4 a face: coincident corners have the
 * same one. corner [4 count][3], zero before, receives the coordinates [unit of the file]; missing corners repeat the
 * first. */
static pd_status pdi_boundary_faces_merge_vertices(pd_ctx *ctx, const pd_boundary_faces *s, int64_t count,
                                                   double *corner, int32_t *vertex)
{
    int32_t *root = NULL, joined = 0, n = (int32_t)(4 * count);
    for (int64_t k = 0; k < n; k++) /* missing corners of a face repeat its first one */
        for (int d = 0; d < PD_DIM; d++)
            corner[3 * k + d] = s->face[k / 4].x[k % 4 < s->face[k / 4].corners ? k % 4 : 0][d];
    PD_TRY(pdi_vertex_merge_identical(ctx, corner, n, vertex));
    PD_TRY(PD_NEW(ctx, "skin", n, root));
    pd_status status = pdi_vertex_merge_nearby(ctx, corner, n, vertex, root, &joined);
    PD_DELETE(ctx, n, root);
    return status;
}

/* Find coincident faces in the sorted list place[count]: a pair from two pieces of the file is shared (shared[face] 1:
 * no boundary); others, in one piece or more than two, are seams, which add to coincident_faces of the points one by
 * one. nodes[2][4 count]: nodes of the corners of the seams, with repetitions, and their merged vertices. Returns how
 * many entries each has. */
static int64_t pdi_boundary_faces_mark_coincident(const pd_boundary_faces *s,
                                                  const pdi_boundary_faces_merged_face *place, int64_t count,
                                                  uint8_t *shared, int64_t *nodes, pd_points *points)
{
    int64_t n = 0;
    for (int64_t k = 0, next; k < count; k = next) {
        for (next = k + 1; next < count && !memcmp(place[next].vertex, place[k].vertex, sizeof place->vertex);) next++;
        if (next == k + 1) continue;
        int parts = next == k + 2 && s->face[place[k].face].piece != s->face[place[k + 1].face].piece;
        for (int64_t m = k; m < next; m++) {
            const pd_boundary_faces_face *face = &s->face[place[m].face];
            shared[place[m].face] = (uint8_t)parts;
            points->coincident_faces += !parts;
            for (int c = 0; c < face->corners && !parts; c++) {
                nodes[n] = face->node[c];
                nodes[4 * count + n++] = place[m].vertex[c];
            }
        }
    }
    return n;
}

/* Set shared[count], zero before, to 1 for those of the first `count` faces that two pieces of the file share; add
 * seams to coincident_faces and set coincident_nodes (nodes of seams less their distinct places) of the points. Does
 * nothing, with PD_OK, when count is 0 or 4 count exceeds int32. */
static pd_status pdi_boundary_faces_match_pieces(pd_ctx *ctx, const pd_boundary_faces *s, int64_t count,
                                                 uint8_t *shared, pd_points *points)
{
    pdi_boundary_faces_merged_face *place = NULL;
    double *corner = NULL;
    int32_t *vertex = NULL;
    int64_t *nodes = NULL;
    if (count == 0 || 4 * count > INT32_MAX) return PD_OK;
    pd_status status = PD_NEW(ctx, "skin", count, place);
    if (status == PD_OK) status = PD_NEW(ctx, "skin", 12 * count, corner);
    if (status == PD_OK) status = PD_NEW(ctx, "skin", 4 * count, vertex);
    if (status == PD_OK) status = PD_NEW(ctx, "skin", 8 * count, nodes);
    if (status == PD_OK) status = pdi_boundary_faces_merge_vertices(ctx, s, count, corner, vertex);
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
        qsort(place, (size_t)count, sizeof *place, pdi_boundary_faces_compare_merged);
        int64_t n = pdi_boundary_faces_mark_coincident(s, place, count, shared, nodes, points);
        points->coincident_nodes =
            pdi_boundary_faces_count_distinct(nodes, n) - pdi_boundary_faces_count_distinct(nodes + 4 * count, n);
    }
    PD_DELETE(ctx, 8 * count, nodes);
    PD_DELETE(ctx, 4 * count, vertex);
    PD_DELETE(ctx, 12 * count, corner);
    PD_DELETE(ctx, count, place);
    return status;
}

/* ---- boundary ---- */

/* Allocate and set face_corner [m] and face_count of the points: those of the first `count` faces that are not shared,
 * as simplices (points, segments, triangles; two of a quadrilateral). */
static pd_status pdi_boundary_faces_store_simplices(pd_ctx *ctx, const pd_boundary_faces *s, int64_t count,
                                                    const uint8_t *shared, double scale, pd_points *points)
{
    int64_t faces = 0;
    for (int64_t k = 0; k < count; k++) faces += shared[k] ? 0 : s->face[k].corners == 4 ? 2 : 1;
    PD_TRY(pdi_points_reserve_faces(ctx, points, faces));
    double *to = points->face_corner;
    for (int64_t k = 0; k < count; k++)
        for (int t = 0; t < (shared[k] ? 0 : s->face[k].corners == 4 ? 2 : 1); t++)
            for (int c = 0; c < PD_DIM; c++)
                for (int d = 0; d < PD_DIM; d++) *to++ = scale * s->face[k].x[c ? c + t : 0][d];
    return PD_OK;
}

pd_status pd_boundary_faces_finish(pd_ctx *ctx, pd_boundary_faces *s, double scale, pd_points *points)
{
    double size = 1.0;
    int64_t links = 0, rooms = 4 * s->count;
    pdi_boundary_faces_node_cell *link = NULL;
    uint8_t *shared = NULL;
    pdi_boundary_faces_weights weights;
    memset(&weights, 0, sizeof weights);
    for (int d = 1; d < PD_DIM; d++) size *= scale;
    PD_TRY(PD_NEW(ctx, "skin", rooms, link));
    pdi_boundary_faces_list_node_cells(s, link, &links);
    int64_t count = pdi_boundary_faces_extract_unshared(s);
    pd_status status = PD_NEW(ctx, "skin", count, shared);
    if (status == PD_OK) status = pdi_boundary_faces_match_pieces(ctx, s, count, shared, points);
    if (status == PD_OK) status = pdi_boundary_faces_store_simplices(ctx, s, count, shared, scale, points);
    if (status == PD_OK) status = pdi_boundary_faces_reserve_weights(ctx, s, count, shared, link, links, &weights);
    for (int64_t k = 0; k < count && status == PD_OK; k++)
        if (!shared[k]) pdi_boundary_faces_distribute_area(&s->face[k], link, links, scale, size, &weights, points);
    pdi_boundary_faces_free_weights(ctx, &weights);
    PD_DELETE(ctx, count, shared);
    PD_DELETE(ctx, rooms, link);
    return status;
}

void pd_boundary_faces_free(pd_ctx *ctx, pd_boundary_faces *s)
{
    PD_DELETE(ctx, s->capacity, s->face);
    memset(s, 0, sizeof *s);
}

#undef PDI_BOUNDARY_FACES_MAX_CELLS
#undef PDI_BOUNDARY_FACES_MIN_PIVOT
#undef PDI_BOUNDARY_FACES_WEIGHT_TOLERANCE
