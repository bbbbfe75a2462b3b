/* skin: see skin.h */
#include "io/skin.h"
#include <stdlib.h>
#include <string.h>

/* Corners of the faces of a form, around each of them so that the right hand points out of a cell of positive volume;
 * -1 behind the last corner of a face. */
typedef struct pdi_skin_form {
    int faces;
    int8_t corner[6][4];
} pdi_skin_form;

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

/* The area of a face, a vector. In 3D half the product of the diagonals, which holds for a face that is not plane. */
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

/* Ascending. */
static void pdi_skin_sort(int64_t *node)
{
    for (int a = 1; a < 4; a++)
        for (int b = a; b > 0 && node[b] < node[b - 1]; b--) {
            int64_t other = node[b];
            node[b] = node[b - 1];
            node[b - 1] = other;
        }
}

/* Outward: away from the middle of the corners. A cell may be turned or mirrored. */
static void pdi_skin_turn(pdi_cell_form form, const double *const *corner, const double *const *x, int corners,
                          double *area)
{
    double along = 0.0;
    int all = pdi_points_corners(form);
    for (int d = 0; d < PD_DIM; d++) {
        double middle = 0.0, at = 0.0;
        for (int k = 0; k < all; k++) middle += (corner[k][d] - x[0][d]) / all;
        for (int k = 0; k < corners; k++) at += (x[k][d] - x[0][d]) / corners;
        along += area[d] * (at - middle);
    }
    for (int d = 0; d < PD_DIM && along < 0.0; d++) area[d] = -area[d];
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
        face->area[0] = 1.0;
        pdi_skin_area(corners, x, face->area);
        pdi_skin_turn(form, corner, x, corners, face->area);
        pdi_skin_sort(face->node);
    }
    return PD_OK;
}

static int pdi_skin_compare(const void *a, const void *b)
{
    const pdi_skin_face *p = (const pdi_skin_face *)a, *q = (const pdi_skin_face *)b;
    for (int k = 0; k < 4; k++)
        if (p->node[k] != q->node[k]) return p->node[k] > q->node[k] ? 1 : -1;
    return (p->cell > q->cell) - (p->cell < q->cell);
}

PDI_FN void pdi_skin_close(pdi_skin *s, double scale, pd_points *points)
{
    double size = 1.0;
    for (int d = 1; d < PD_DIM; d++) size *= scale;
    if (s->count) qsort(s->face, (size_t)s->count, sizeof *s->face, pdi_skin_compare);
    for (int64_t k = 0, next; k < s->count; k = next) {
        const pdi_skin_face *face = &s->face[k];
        for (next = k + 1; next < s->count && !memcmp(s->face[next].node, face->node, sizeof face->node);) next++;
        if (next > k + 1) continue;
        for (int d = 0; d < PD_DIM; d++) points->surface[(int64_t)face->cell * PD_DIM + d] += size * face->area[d];
    }
}

PDI_FN void pdi_skin_free(pd_ctx *ctx, pdi_skin *s)
{
    PDI_DELETE(ctx, s->room, s->face);
    memset(s, 0, sizeof *s);
}
