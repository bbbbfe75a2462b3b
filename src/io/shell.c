/* shell: see shell.h */
#include "io/shell.h"
#include <math.h>
#include <string.h>

#define PDI_SHELL_MOVES 5 /* sweeps that smooth the vertices */
#define PDI_SHELL_PULL 0.5 /* relaxation factor of a sweep: fraction of the way to the mean of the neighbours */
#define PDI_SHELL_TURNS 6 /* sweeps that smooth the normals */
#define PDI_SHELL_EDGE 0.5 /* cosine of the angle between face normals below which the surface has a sharp edge */
#define PDI_SHELL_LEAST 0.02 /* [cells] minimum distance from the centre of a cell of the set to the surface */

/* Work arrays of the construction. The grid is extended by a layer of empty cells. */
typedef struct pdi_shell_work {
    pd_ctx *ctx;
    const pdi_shell_desc *desc;
    pdi_shell *s;
    int m[3];            /* possible vertices along each axis: number of cells + 1 */
    double *share[2];    /* [(n[0] + 2) * (n[1] + 2)] volume fractions of two layers of cells */
    int32_t *number[2];  /* [m[0] * m[1]] vertex indices of two layers, -1: none */
    double *low;         /* [low_room][3] [cells] bounds of a vertex: low .. low + 1, the adjacent cell centres */
    int64_t low_room;
    double *sum;         /* [corners][3] sum over the neighbours of a vertex */
    double *weight;      /* [corners] number of these */
    double *flat[2];     /* [faces][3] normals of faces, and those of the next sweep */
    int64_t *first;      /* [corners + 1] start of the faces at a vertex in the next array */
    int32_t *around;     /* [4 faces] faces at all vertices */
} pdi_shell_work;

/* Make room for one more vertex. */
static pd_status pdi_shell_room(pdi_shell_work *w)
{
    pdi_shell *s = w->s;
    if (s->corners == s->corner_room) {
        int64_t room = 2 * s->corner_room + 4096;
        if (w->low_room < room) PDI_TRY(PDI_GROW(w->ctx, "shell", 3 * w->low_room, 3 * room, w->low));
        w->low_room = room;
        PDI_TRY(PDI_GROW(w->ctx, "shell", 3 * s->corner_room, 3 * room, s->x));
        s->corner_room = room;
    }
    if (s->corners < INT32_MAX - 1) return PD_OK;
    return pdi_fail(w->ctx, PD_ERR_SIZE, "shell", "a surface of more than %ld corners", (long)s->corners);
}

/* Volume fraction of cell (i, j) of a layer; 0: it is not in the set. */
static double pdi_shell_share(const pdi_shell_work *w, int layer, int i, int j)
{
    return w->share[layer][(int64_t)(j + 1) * (w->desc->n[0] + 2) + i + 1];
}

/* Evaluate the volume fractions of layer k of cells, with a margin of one empty cell. */
static void pdi_shell_shares(pdi_shell_work *w, int layer, int k)
{
    const int *n = w->desc->n;
    double *to = w->share[layer];
    for (int j = -1; j <= n[1]; j++)
        for (int i = -1; i <= n[0]; i++, to++) {
            int at[3], in = i >= 0 && i < n[0] && j >= 0 && j < n[1] && k >= 0 && k < n[2];
            at[0] = i;
            at[1] = j;
            at[2] = k;
            *to = in ? pdi_min(w->desc->share(w->desc->user, at), 1.0) : 0.0;
        }
}

/* Returns 1 when the vertex index[3] lies on a side of the grid along axis d. */
static int pdi_shell_side(const pdi_shell_work *w, const int *index, int d)
{
    return index[d] == 0 || index[d] == w->desc->n[d];
}

/* Position of the vertex index[3] in the cube of the eight cell centres around it, 0..1 along each axis: mean of the
 * points where edges of the cube cross the surface. fraction[8]: volume fractions; bit d of their index: upper cell
 * along axis d. On a side of the grid the vertex lies in it, and edges across that side count only where there are no
 * others. Returns 0 without a surface. */
static int pdi_shell_mean(const pdi_shell_work *w, const int *index, const double *fraction, double *position)
{
    double sum[2][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    int count[2] = {0, 0};
    for (int a = 0; a < 8; a++)
        for (int d = 0; d < 3; d++) {
            int b = a | 1 << d, side = pdi_shell_side(w, index, d);
            if (b == a || (fraction[a] > 0.0) == (fraction[b] > 0.0)) continue;
            /* from the centre of the cell that is in the set */
            double from = pdi_max(PDI_SHELL_LEAST, pdi_max(fraction[a], fraction[b]) - 0.5);
            for (int e = 0; e < 3; e++) sum[side][e] += e != d ? a >> e & 1 : fraction[a] > 0.0 ? from : 1.0 - from;
            count[side]++;
        }
    int side = !count[0];
    for (int d = 0; d < 3 && count[side]; d++)
        position[d] = pdi_shell_side(w, index, d) ? 0.5 : sum[side][d] / count[side];
    return count[side];
}

/* Add the vertex index[3] between the eight cells of which index - 1 is the lowest; *number: its number, unchanged
 * without a surface. */
static pd_status pdi_shell_corner(pdi_shell_work *w, const int *index, const double *fraction, int32_t *number)
{
    double mean[3];
    if (!pdi_shell_mean(w, index, fraction, mean)) return PD_OK;
    PDI_TRY(pdi_shell_room(w));
    *number = (int32_t)w->s->corners;
    for (int d = 0; d < 3; d++) {
        w->low[3 * w->s->corners + d] = index[d] - 0.5;
        w->s->x[3 * w->s->corners + d] = index[d] - 0.5 + mean[d];
    }
    w->s->corners++;
    return PD_OK;
}

/* Add a face with its value, between the cells `in` and `out`. */
static pd_status pdi_shell_face(pdi_shell_work *w, const int32_t *corner, const int *in, const int *out)
{
    pdi_shell *s = w->s;
    int64_t room = 2 * s->faces + 4096;
    if (s->faces == s->face_room) {
        PDI_TRY(PDI_GROW(w->ctx, "shell", 4 * s->face_room, 4 * room, s->corner));
        s->face_room = room;
    }
    if (s->faces == s->value_room) {
        PDI_TRY(PDI_GROW(w->ctx, "shell", s->value_room, room, s->value));
        s->value_room = room;
    }
    for (int k = 0; k < 4; k++) s->corner[4 * s->faces + k] = corner[k];
    s->value[s->faces++] = w->desc->value ? w->desc->value(w->desc->user, in, out) : (double)NAN;
    return PD_OK;
}

/* Add the faces across the three edges from the lowest of the eight cells of the vertex index[3] upward. */
static pd_status pdi_shell_faces(pdi_shell_work *w, const int *index, const double *fraction)
{
    for (int d = 0; d < 3; d++) {
        int e = (d + 1) % 3, g = (d + 2) % 3, in[3], out[3];
        int32_t corner[4];
        if ((fraction[0] > 0.0) == (fraction[1 << d] > 0.0)) continue;
        for (int k = 0; k < 4; k++) { /* around the edge: none, e, both, g lower */
            int to[3] = {index[0], index[1], index[2]};
            to[e] -= k == 1 || k == 2;
            to[g] -= k >= 2;
            int turned = fraction[0] > 0.0 ? k : 3 - k;
            corner[turned] = w->number[(index[2] - to[2]) ? 0 : 1][(int64_t)to[1] * w->m[0] + to[0]];
        }
        for (int a = 0; a < 3; a++) in[a] = out[a] = index[a] - 1;
        (fraction[0] > 0.0 ? out : in)[d]++;
        PDI_TRY(pdi_shell_face(w, corner, in, out));
    }
    return PD_OK;
}

/* Build vertices and faces layer by layer; layer 0 of the work arrays is the one before. */
static pd_status pdi_shell_march(pdi_shell_work *w)
{
    pdi_shell_shares(w, 1, -1);
    for (int k = 0; k < w->m[2]; k++) {
        double *share = w->share[0];
        int32_t *number = w->number[0];
        w->share[0] = w->share[1];
        w->share[1] = share;
        w->number[0] = w->number[1];
        w->number[1] = number;
        pdi_shell_shares(w, 1, k);
        PDI_TRY(pdi_poll(w->ctx, "pictures", k));
        for (int j = 0; j < w->m[1]; j++)
            for (int i = 0; i < w->m[0]; i++) {
                int at[3] = {i, j, k};
                double f[8];
                for (int a = 0; a < 8; a++) f[a] = pdi_shell_share(w, a >> 2, i - 1 + (a & 1), j - 1 + (a >> 1 & 1));
                int32_t *here = &w->number[1][(int64_t)j * w->m[0] + i];
                *here = -1;
                PDI_TRY(pdi_shell_corner(w, at, f, here));
                if (*here >= 0) PDI_TRY(pdi_shell_faces(w, at, f));
            }
    }
    return PD_OK;
}

/* Returns 1 when a face lies in a side of the grid. */
static int pdi_shell_cut(const pdi_shell_work *w, const int32_t *corner)
{
    for (int d = 0; d < 3; d++) {
        int low = 0, high = 0;
        for (int k = 0; k < 4; k++) {
            low += w->low[3 * (int64_t)corner[k] + d] < 0.0;
            high += w->low[3 * (int64_t)corner[k] + d] > w->desc->n[d] - 1.0;
        }
        if (low == 4 || high == 4) return 1;
    }
    return 0;
}

/* Sum the positions of the neighbours of each vertex, without faces in a side of the grid. */
static void pdi_shell_neighbours(pdi_shell_work *w)
{
    const pdi_shell *s = w->s;
    memset(w->sum, 0, (size_t)s->corners * 3 * sizeof *w->sum);
    memset(w->weight, 0, (size_t)s->corners * sizeof *w->weight);
    for (int64_t f = 0; f < s->faces; f++)
        for (int k = 0; k < 4 && !pdi_shell_cut(w, &s->corner[4 * f]); k++) {
            int64_t a = s->corner[4 * f + k], b = s->corner[4 * f + (k + 1) % 4];
            for (int d = 0; d < 3; d++) {
                w->sum[3 * a + d] += s->x[3 * b + d];
                w->sum[3 * b + d] += s->x[3 * a + d];
            }
            w->weight[a] += 1.0;
            w->weight[b] += 1.0;
        }
}

/* Smooth the vertices (Jacobi sweeps), each within its bounds; vertices in a side of the grid stay in it. */
static void pdi_shell_relax(pdi_shell_work *w)
{
    const pdi_shell *s = w->s;
    for (int n = 0; n < PDI_SHELL_MOVES; n++) {
        pdi_shell_neighbours(w);
        for (int64_t c = 0; c < s->corners; c++)
            for (int d = 0; d < 3 && w->weight[c] > 0.0; d++) {
                double low = w->low[3 * c + d], *x = &s->x[3 * c + d];
                if (low < 0.0 || low > w->desc->n[d] - 1.0) continue; /* it stays in the side of the grid */
                *x = pdi_min(pdi_max(*x + PDI_SHELL_PULL * (w->sum[3 * c + d] / w->weight[c] - *x), low), low + 1.0);
            }
    }
}

/* Normalise a vector [3]; a zero vector stays. */
static void pdi_shell_unit(double *v)
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int d = 0; d < 3 && length > 0.0; d++) v[d] /= length;
}

/* Unit normals of the faces from the cross product of their diagonals. */
static void pdi_shell_flat(pdi_shell_work *w)
{
    const pdi_shell *s = w->s;
    for (int64_t f = 0; f < s->faces; f++) {
        const int32_t *c = &s->corner[4 * f];
        double a[3], b[3], *normal = &w->flat[0][3 * f];
        for (int d = 0; d < 3; d++) {
            a[d] = s->x[3 * (int64_t)c[2] + d] - s->x[3 * (int64_t)c[0] + d];
            b[d] = s->x[3 * (int64_t)c[3] + d] - s->x[3 * (int64_t)c[1] + d];
        }
        for (int d = 0; d < 3; d++) normal[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
        pdi_shell_unit(normal);
    }
}

/* List the faces at each vertex, in CSR form. */
static void pdi_shell_around(pdi_shell_work *w)
{
    const pdi_shell *s = w->s;
    memset(w->first, 0, (size_t)(s->corners + 1) * sizeof *w->first);
    for (int64_t k = 0; k < 4 * s->faces; k++) w->first[s->corner[k] + 1]++;
    for (int64_t c = 0; c < s->corners; c++) w->first[c + 1] += w->first[c];
    for (int64_t k = 4 * s->faces - 1; k >= 0; k--) w->around[--w->first[s->corner[k] + 1]] = (int32_t)(k / 4);
    for (int64_t c = 0; c < s->corners; c++) w->first[c] = w->first[c + 1];
    w->first[s->corners] = 4 * s->faces;
}

/* Add the normals of the faces at a vertex as one face sees them: weights fall with the angle to its own normal, to 0
 * at an edge. */
static void pdi_shell_gather(const pdi_shell_work *w, int64_t face, int64_t corner, double *sum)
{
    const double *own = &w->flat[0][3 * face];
    for (int64_t k = w->first[corner]; k < w->first[corner + 1]; k++) {
        const double *n = &w->flat[0][3 * (int64_t)w->around[k]];
        double same = (own[0] * n[0] + own[1] * n[1] + own[2] * n[2] - PDI_SHELL_EDGE) / (1.0 - PDI_SHELL_EDGE);
        for (int d = 0; d < 3 && same > 0.0; d++) sum[d] += same * n[d];
    }
}

/* Smooth the face normals, but not across sharp edges; then set the normals of each face at its vertices. */
static void pdi_shell_normals(pdi_shell_work *w)
{
    pdi_shell *s = w->s;
    pdi_shell_flat(w);
    pdi_shell_around(w);
    for (int n = 0; n < PDI_SHELL_TURNS; n++) {
        double *next = w->flat[1];
        for (int64_t f = 0; f < s->faces; f++) {
            double *sum = &next[3 * f];
            sum[0] = sum[1] = sum[2] = 0.0;
            for (int k = 0; k < 4; k++) pdi_shell_gather(w, f, s->corner[4 * f + k], sum);
            pdi_shell_unit(sum);
        }
        w->flat[1] = w->flat[0];
        w->flat[0] = next;
    }
    for (int64_t k = 0; k < 4 * s->faces; k++) {
        double sum[3] = {0.0, 0.0, 0.0};
        pdi_shell_gather(w, k / 4, s->corner[k], sum);
        pdi_shell_unit(sum);
        for (int d = 0; d < 3; d++) s->normal[3 * k + d] = (float)sum[d];
    }
}

/* Mean value of the faces at each vertex. */
static void pdi_shell_means(pdi_shell_work *w)
{
    pdi_shell *s = w->s;
    memset(s->mean, 0, (size_t)s->corner_room * sizeof *s->mean);
    memset(w->weight, 0, (size_t)s->corners * sizeof *w->weight);
    for (int64_t k = 0; k < 4 * s->faces; k++) {
        if (isnan(s->value[k / 4])) continue;
        s->mean[s->corner[k]] += s->value[k / 4];
        w->weight[s->corner[k]] += 1.0;
    }
    for (int64_t c = 0; c < s->corners; c++) s->mean[c] = w->weight[c] > 0.0 ? s->mean[c] / w->weight[c] : (double)NAN;
}

/* Smooth the mesh, convert it from cells to metres, and compute normals and values. */
static void pdi_shell_finish(pdi_shell_work *w)
{
    pdi_shell *s = w->s;
    pdi_shell_relax(w);
    for (int64_t k = 0; k < 3 * s->corners; k++) s->x[k] = w->desc->lo[k % 3] + s->x[k] * w->desc->h[k % 3];
    pdi_shell_normals(w);
    pdi_shell_means(w);
}

/* Build vertices and faces, in units of cells. */
static pd_status pdi_shell_find(pdi_shell_work *w)
{
    const pdi_shell_desc *desc = w->desc;
    pd_status status = PD_OK;
    for (int d = 0; d < 3; d++) w->m[d] = desc->n[d] + 1;
    int64_t layer = (int64_t)w->m[0] * w->m[1], shares = ((int64_t)desc->n[0] + 2) * (desc->n[1] + 2);
    for (int k = 0; k < 2 && status == PD_OK; k++) {
        status = PDI_NEW(w->ctx, "shell", shares, w->share[k]);
        if (status == PD_OK) status = PDI_NEW(w->ctx, "shell", layer, w->number[k]);
    }
    if (status == PD_OK) status = pdi_shell_march(w);
    for (int k = 0; k < 2; k++) {
        PDI_DELETE(w->ctx, shares, w->share[k]);
        PDI_DELETE(w->ctx, layer, w->number[k]);
    }
    return status;
}

PDI_FN pd_status pdi_shell_build(pd_ctx *ctx, const pdi_shell_desc *desc, pdi_shell *s)
{
    pdi_shell_work w;
    memset(&w, 0, sizeof w);
    memset(s, 0, sizeof *s);
    w.ctx = ctx;
    w.desc = desc;
    w.s = s;
    pd_status status = pdi_shell_find(&w);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", 3 * s->corners, w.sum);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", s->corners, w.weight);
    for (int k = 0; k < 2 && status == PD_OK; k++) status = PDI_NEW(ctx, "shell", 3 * s->faces, w.flat[k]);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", s->corners + 1, w.first);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", 4 * s->faces, w.around);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", 12 * s->face_room, s->normal);
    if (status == PD_OK) status = PDI_NEW(ctx, "shell", s->corner_room, s->mean);
    if (status == PD_OK) pdi_shell_finish(&w);
    PDI_DELETE(ctx, 3 * s->corners, w.sum);
    PDI_DELETE(ctx, s->corners, w.weight);
    for (int k = 0; k < 2; k++) PDI_DELETE(ctx, 3 * s->faces, w.flat[k]);
    PDI_DELETE(ctx, s->corners + 1, w.first);
    PDI_DELETE(ctx, 4 * s->faces, w.around);
    PDI_DELETE(ctx, 3 * w.low_room, w.low);
    if (status != PD_OK) pdi_shell_free(ctx, s);
    return status;
}

PDI_FN void pdi_shell_free(pd_ctx *ctx, pdi_shell *s)
{
    PDI_DELETE(ctx, 3 * s->corner_room, s->x);
    PDI_DELETE(ctx, 12 * s->face_room, s->normal);
    PDI_DELETE(ctx, s->corner_room, s->mean);
    PDI_DELETE(ctx, 4 * s->face_room, s->corner);
    PDI_DELETE(ctx, s->value_room, s->value);
    memset(s, 0, sizeof *s);
}

#undef PDI_SHELL_MOVES
#undef PDI_SHELL_PULL
#undef PDI_SHELL_TURNS
#undef PDI_SHELL_EDGE
#undef PDI_SHELL_LEAST
