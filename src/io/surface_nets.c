/* surface_nets: see surface_nets.h */
#include "io/surface_nets.h"
#include <math.h>
#include <string.h>

#define PDI_SURFACE_NETS_SMOOTHING_SWEEPS 5 /* sweeps that smooth the vertices */
/* relaxation factor of a sweep: fraction of the way to the mean of the neighbours */
#define PDI_SURFACE_NETS_RELAXATION 0.5
#define PDI_SURFACE_NETS_NORMAL_SWEEPS 6 /* sweeps that smooth the normals */
/* cosine of the angle between face normals below which the surface has a sharp edge */
#define PDI_SURFACE_NETS_EDGE_COSINE 0.5
/* [cells] minimum distance from the centre of a cell of the set to the surface */
#define PDI_SURFACE_NETS_MIN_DISTANCE 0.02

/* Work arrays of the construction. The grid is extended by a layer of empty cells. */
typedef struct pdi_surface_nets_work {
    pd_ctx *ctx;
    const pdi_surface_nets_desc *desc;
    pdi_surface_nets_mesh *mesh;
    int m[3];                 /* possible vertices along each axis: number of cells + 1 */
    double *fraction[2];      /* [(n[0] + 2) * (n[1] + 2)] volume fractions of two layers of cells */
    int32_t *vertex_index[2]; /* [m[0] * m[1]] vertex indices of two layers, -1: none */
    /* [bound_capacity][3] [cells] bounds of a vertex: lower_bound .. lower_bound + 1, the adjacent cell centres */
    double *lower_bound;
    int64_t bound_capacity;
    double *sum;            /* [corners][3] sum over the neighbours of a vertex */
    double *weight;         /* [corners] number of these */
    double *face_normal[2]; /* [faces][3] normals of faces, and those of the next sweep */
    int64_t *first_face;    /* [corners + 1] start of the faces at a vertex in the next array */
    int32_t *vertex_face;   /* [4 faces] faces at all vertices */
} pdi_surface_nets_work;

/* Make room for one more vertex and its bounds. PD_ERR_SIZE: more than int32 counts. */
static pd_status pdi_surface_nets_reserve_vertex(pdi_surface_nets_work *w)
{
    pdi_surface_nets_mesh *s = w->mesh;
    if (s->vertex_count == s->vertex_capacity) {
        int64_t room = 2 * s->vertex_capacity + 4096;
        if (w->bound_capacity < room)
            PD_TRY(PD_GROW(w->ctx, "surface_nets", 3 * w->bound_capacity, 3 * room, w->lower_bound));
        w->bound_capacity = room;
        PD_TRY(PD_GROW(w->ctx, "surface_nets", 3 * s->vertex_capacity, 3 * room, s->x));
        s->vertex_capacity = room;
    }
    if (s->vertex_count < INT32_MAX - 1) return PD_OK;
    return pd_fail(w->ctx, PD_ERR_SIZE, "surface_nets", "a surface of more than %ld corners", (long)s->vertex_count);
}

/* Volume fraction of cell (i, j), from -1 on, of layer 0 or 1 of the work arrays; 0 or less: it is not in the set. */
static double pdi_surface_nets_get_fraction(const pdi_surface_nets_work *w, int layer, int i, int j)
{
    return w->fraction[layer][(int64_t)(j + 1) * (w->desc->n[0] + 2) + i + 1];
}

/* Evaluate the volume fractions of the cells of index k along axis 2 into layer 0 or 1 of the work arrays, at most 1,
 * with a margin of one empty cell; k may lie outside of the grid. */
static void pdi_surface_nets_set_fractions(pdi_surface_nets_work *w, int layer, int k)
{
    const int *n = w->desc->n;
    double *to = w->fraction[layer];
    for (int j = -1; j <= n[1]; j++)
        for (int i = -1; i <= n[0]; i++, to++) {
            int at[3], in = i >= 0 && i < n[0] && j >= 0 && j < n[1] && k >= 0 && k < n[2];
            at[0] = i;
            at[1] = j;
            at[2] = k;
            *to = in ? pd_min(w->desc->fraction(w->desc->user, at), 1.0) : 0.0;
        }
}

/* Returns 1 when the vertex index[3] lies on a side of the grid along axis d. */
static int pdi_surface_nets_is_on_side(const pdi_surface_nets_work *w, const int *index, int d)
{
    return index[d] == 0 || index[d] == w->desc->n[d];
}

/* Position[3] of the vertex index[3] in the cube of the eight cell centres around it, 0..1: mean of the points where
 * edges of the cube cross the surface. fraction[8]: volume fractions; bit d of their index: upper cell along axis d. On
 * a side of the grid the vertex lies in it; edges across it count only without others. Returns the number of edges, 0:
 * no surface. */
static int pdi_surface_nets_vertex_position(const pdi_surface_nets_work *w, const int *index, const double *fraction,
                                            double *position)
{
    double sum[2][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    int count[2] = {0, 0};
    for (int a = 0; a < 8; a++)
        for (int d = 0; d < 3; d++) {
            int b = a | 1 << d, side = pdi_surface_nets_is_on_side(w, index, d);
            if (b == a || (fraction[a] > 0.0) == (fraction[b] > 0.0)) continue;
            /* from the centre of the cell that is in the set */
            double from = pd_max(PDI_SURFACE_NETS_MIN_DISTANCE, pd_max(fraction[a], fraction[b]) - 0.5);
            for (int e = 0; e < 3; e++) sum[side][e] += e != d ? a >> e & 1 : fraction[a] > 0.0 ? from : 1.0 - from;
            count[side]++;
        }
    int side = !count[0];
    for (int d = 0; d < 3 && count[side]; d++)
        position[d] = pdi_surface_nets_is_on_side(w, index, d) ? 0.5 : sum[side][d] / count[side];
    return count[side];
}

/* Add the vertex index[3] between the eight cells of which index - 1 is the lowest, with its bounds, in cells; *number:
 * its number. Nothing, and *number is unchanged, where all or none of the cells are in the set. PD_ERR_SIZE. */
static pd_status pdi_surface_nets_add_vertex(pdi_surface_nets_work *w, const int *index, const double *fraction,
                                             int32_t *number)
{
    double mean[3];
    if (!pdi_surface_nets_vertex_position(w, index, fraction, mean)) return PD_OK;
    PD_TRY(pdi_surface_nets_reserve_vertex(w));
    *number = (int32_t)w->mesh->vertex_count;
    for (int d = 0; d < 3; d++) {
        w->lower_bound[3 * w->mesh->vertex_count + d] = index[d] - 0.5;
        w->mesh->x[3 * w->mesh->vertex_count + d] = index[d] - 0.5 + mean[d];
    }
    w->mesh->vertex_count++;
    return PD_OK;
}

/* Add a face of the vertices corner[4], counterclockwise seen from outside, with its value, between the cells in[3] and
 * out[3]; NaN where desc has no callback for values. */
static pd_status pdi_surface_nets_add_face(pdi_surface_nets_work *w, const int32_t *corner, const int *in,
                                           const int *out)
{
    pdi_surface_nets_mesh *s = w->mesh;
    int64_t room = 2 * s->face_count + 4096;
    if (s->face_count == s->face_capacity) {
        PD_TRY(PD_GROW(w->ctx, "surface_nets", 4 * s->face_capacity, 4 * room, s->face_vertex));
        s->face_capacity = room;
    }
    if (s->face_count == s->value_capacity) {
        PD_TRY(PD_GROW(w->ctx, "surface_nets", s->value_capacity, room, s->face_value));
        s->value_capacity = room;
    }
    for (int k = 0; k < 4; k++) s->face_vertex[4 * s->face_count + k] = corner[k];
    s->face_value[s->face_count++] = w->desc->value ? w->desc->value(w->desc->user, in, out) : (double)NAN;
    return PD_OK;
}

/* Add the faces across the edges from the lowest of the eight cells of the vertex index[3] upward along each axis,
 * where one of the two cells is in the set. Their other vertices have been added before. */
static pd_status pdi_surface_nets_add_vertex_faces(pdi_surface_nets_work *w, const int *index, const double *fraction)
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
            corner[turned] = w->vertex_index[(index[2] - to[2]) ? 0 : 1][(int64_t)to[1] * w->m[0] + to[0]];
        }
        for (int a = 0; a < 3; a++) in[a] = out[a] = index[a] - 1;
        (fraction[0] > 0.0 ? out : in)[d]++;
        PD_TRY(pdi_surface_nets_add_face(w, corner, in, out));
    }
    return PD_OK;
}

/* Build vertices and faces, in cells, layer by layer along axis 2; layer 0 of the work arrays is the one before.
 * PD_ERR_SIZE, PD_CANCELLED. */
static pd_status pdi_surface_nets_march_layers(pdi_surface_nets_work *w)
{
    pdi_surface_nets_set_fractions(w, 1, -1);
    for (int k = 0; k < w->m[2]; k++) {
        double *share = w->fraction[0];
        int32_t *number = w->vertex_index[0];
        w->fraction[0] = w->fraction[1];
        w->fraction[1] = share;
        w->vertex_index[0] = w->vertex_index[1];
        w->vertex_index[1] = number;
        pdi_surface_nets_set_fractions(w, 1, k);
        PD_TRY(pd_check_cancel(w->ctx, "pictures", k));
        for (int j = 0; j < w->m[1]; j++)
            for (int i = 0; i < w->m[0]; i++) {
                int at[3] = {i, j, k};
                double f[8];
                for (int a = 0; a < 8; a++)
                    f[a] = pdi_surface_nets_get_fraction(w, a >> 2, i - 1 + (a & 1), j - 1 + (a >> 1 & 1));
                int32_t *here = &w->vertex_index[1][(int64_t)j * w->m[0] + i];
                *here = -1;
                PD_TRY(pdi_surface_nets_add_vertex(w, at, f, here));
                if (*here >= 0) PD_TRY(pdi_surface_nets_add_vertex_faces(w, at, f));
            }
    }
    return PD_OK;
}

/* Returns 1 when all of corner[4] lie in one side of the grid, else 0. */
static int pdi_surface_nets_is_side_face(const pdi_surface_nets_work *w, const int32_t *corner)
{
    for (int d = 0; d < 3; d++) {
        int low = 0, high = 0;
        for (int k = 0; k < 4; k++) {
            low += w->lower_bound[3 * (int64_t)corner[k] + d] < 0.0;
            high += w->lower_bound[3 * (int64_t)corner[k] + d] > w->desc->n[d] - 1.0;
        }
        if (low == 4 || high == 4) return 1;
    }
    return 0;
}

/* Set sum and weight: sum of the positions of the neighbours of each vertex and their number, without faces in a side
 * of the grid; a neighbour counts once for each face it shares. */
static void pdi_surface_nets_sum_neighbours(pdi_surface_nets_work *w)
{
    const pdi_surface_nets_mesh *s = w->mesh;
    memset(w->sum, 0, (size_t)s->vertex_count * 3 * sizeof *w->sum);
    memset(w->weight, 0, (size_t)s->vertex_count * sizeof *w->weight);
    for (int64_t f = 0; f < s->face_count; f++)
        for (int k = 0; k < 4 && !pdi_surface_nets_is_side_face(w, &s->face_vertex[4 * f]); k++) {
            int64_t a = s->face_vertex[4 * f + k], b = s->face_vertex[4 * f + (k + 1) % 4];
            for (int d = 0; d < 3; d++) {
                w->sum[3 * a + d] += s->x[3 * b + d];
                w->sum[3 * b + d] += s->x[3 * a + d];
            }
            w->weight[a] += 1.0;
            w->weight[b] += 1.0;
        }
}

/* Smooth the vertices in units of cells: each goes half the way to the mean of its neighbours, five Jacobi sweeps,
 * within its bounds. Vertices in a side of the grid stay in it, those without a neighbour stay. */
static void pdi_surface_nets_smooth_vertices(pdi_surface_nets_work *w)
{
    const pdi_surface_nets_mesh *s = w->mesh;
    for (int n = 0; n < PDI_SURFACE_NETS_SMOOTHING_SWEEPS; n++) {
        pdi_surface_nets_sum_neighbours(w);
        for (int64_t c = 0; c < s->vertex_count; c++)
            for (int d = 0; d < 3 && w->weight[c] > 0.0; d++) {
                double low = w->lower_bound[3 * c + d], *x = &s->x[3 * c + d];
                if (low < 0.0 || low > w->desc->n[d] - 1.0) continue; /* it stays in the side of the grid */
                *x = pd_min(pd_max(*x + PDI_SURFACE_NETS_RELAXATION * (w->sum[3 * c + d] / w->weight[c] - *x), low),
                             low + 1.0);
            }
    }
}

/* Normalise a vector [3]; a zero vector stays. */
static void pdi_surface_nets_normalise(double *v)
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int d = 0; d < 3 && length > 0.0; d++) v[d] /= length;
}

/* Outward unit normals of the faces from the cross product of their diagonals, into face_normal[0]; a zero vector for a
 * face without area. */
static void pdi_surface_nets_compute_face_normals(pdi_surface_nets_work *w)
{
    const pdi_surface_nets_mesh *s = w->mesh;
    for (int64_t f = 0; f < s->face_count; f++) {
        const int32_t *c = &s->face_vertex[4 * f];
        double a[3], b[3], *normal = &w->face_normal[0][3 * f];
        for (int d = 0; d < 3; d++) {
            a[d] = s->x[3 * (int64_t)c[2] + d] - s->x[3 * (int64_t)c[0] + d];
            b[d] = s->x[3 * (int64_t)c[3] + d] - s->x[3 * (int64_t)c[1] + d];
        }
        for (int d = 0; d < 3; d++) normal[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
        pdi_surface_nets_normalise(normal);
    }
}

/* List the faces at each vertex, in CSR form, into first_face and vertex_face. */
static void pdi_surface_nets_list_vertex_faces(pdi_surface_nets_work *w)
{
    const pdi_surface_nets_mesh *s = w->mesh;
    memset(w->first_face, 0, (size_t)(s->vertex_count + 1) * sizeof *w->first_face);
    for (int64_t k = 0; k < 4 * s->face_count; k++) w->first_face[s->face_vertex[k] + 1]++;
    for (int64_t c = 0; c < s->vertex_count; c++) w->first_face[c + 1] += w->first_face[c];
    for (int64_t k = 4 * s->face_count - 1; k >= 0; k--)
        w->vertex_face[--w->first_face[s->face_vertex[k] + 1]] = (int32_t)(k / 4);
    for (int64_t c = 0; c < s->vertex_count; c++) w->first_face[c] = w->first_face[c + 1];
    w->first_face[s->vertex_count] = 4 * s->face_count;
}

/* Add to sum[3] the normals of the faces at a vertex `corner` as one face sees them: the weight falls linearly with the
 * cosine of the angle to its own normal, from 1 to 0 at PDI_SURFACE_NETS_EDGE_COSINE (60 degrees), and stays 0
 * beyond. */
static void pdi_surface_nets_add_near_normals(const pdi_surface_nets_work *w, int64_t face, int64_t corner, double *sum)
{
    const double *own = &w->face_normal[0][3 * face];
    for (int64_t k = w->first_face[corner]; k < w->first_face[corner + 1]; k++) {
        const double *n = &w->face_normal[0][3 * (int64_t)w->vertex_face[k]];
        double same = (own[0] * n[0] + own[1] * n[1] + own[2] * n[2] - PDI_SURFACE_NETS_EDGE_COSINE) /
                      (1.0 - PDI_SURFACE_NETS_EDGE_COSINE);
        for (int d = 0; d < 3 && same > 0.0; d++) sum[d] += same * n[d];
    }
}

/* Compute the face normals and smooth them in six sweeps, but not across edges sharper than 60 degrees; then set
 * corner_normal, the unit normals of each face at its vertices. */
static void pdi_surface_nets_compute_normals(pdi_surface_nets_work *w)
{
    pdi_surface_nets_mesh *s = w->mesh;
    pdi_surface_nets_compute_face_normals(w);
    pdi_surface_nets_list_vertex_faces(w);
    for (int n = 0; n < PDI_SURFACE_NETS_NORMAL_SWEEPS; n++) {
        double *next = w->face_normal[1];
        for (int64_t f = 0; f < s->face_count; f++) {
            double *sum = &next[3 * f];
            sum[0] = sum[1] = sum[2] = 0.0;
            for (int k = 0; k < 4; k++) pdi_surface_nets_add_near_normals(w, f, s->face_vertex[4 * f + k], sum);
            pdi_surface_nets_normalise(sum);
        }
        w->face_normal[1] = w->face_normal[0];
        w->face_normal[0] = next;
    }
    for (int64_t k = 0; k < 4 * s->face_count; k++) {
        double sum[3] = {0.0, 0.0, 0.0};
        pdi_surface_nets_add_near_normals(w, k / 4, s->face_vertex[k], sum);
        pdi_surface_nets_normalise(sum);
        for (int d = 0; d < 3; d++) s->corner_normal[3 * k + d] = (float)sum[d];
    }
}

/* Set vertex_value, the mean value of the faces at each vertex that have one; NaN: none has. */
static void pdi_surface_nets_compute_vertex_values(pdi_surface_nets_work *w)
{
    pdi_surface_nets_mesh *s = w->mesh;
    memset(s->vertex_value, 0, (size_t)s->vertex_capacity * sizeof *s->vertex_value);
    memset(w->weight, 0, (size_t)s->vertex_count * sizeof *w->weight);
    for (int64_t k = 0; k < 4 * s->face_count; k++) {
        if (isnan(s->face_value[k / 4])) continue;
        s->vertex_value[s->face_vertex[k]] += s->face_value[k / 4];
        w->weight[s->face_vertex[k]] += 1.0;
    }
    for (int64_t c = 0; c < s->vertex_count; c++)
        s->vertex_value[c] = w->weight[c] > 0.0 ? s->vertex_value[c] / w->weight[c] : (double)NAN;
}

/* Smooth the mesh, convert it from cells to metres, and compute normals and values. */
static void pdi_surface_nets_finish(pdi_surface_nets_work *w)
{
    pdi_surface_nets_mesh *s = w->mesh;
    pdi_surface_nets_smooth_vertices(w);
    for (int64_t k = 0; k < 3 * s->vertex_count; k++) s->x[k] = w->desc->lo[k % 3] + s->x[k] * w->desc->h[k % 3];
    pdi_surface_nets_compute_normals(w);
    pdi_surface_nets_compute_vertex_values(w);
}

/* Build vertices and faces, in units of cells. */
static pd_status pdi_surface_nets_build_faces(pdi_surface_nets_work *w)
{
    const pdi_surface_nets_desc *desc = w->desc;
    pd_status status = PD_OK;
    for (int d = 0; d < 3; d++) w->m[d] = desc->n[d] + 1;
    int64_t layer = (int64_t)w->m[0] * w->m[1], shares = ((int64_t)desc->n[0] + 2) * (desc->n[1] + 2);
    for (int k = 0; k < 2 && status == PD_OK; k++) {
        status = PD_NEW(w->ctx, "surface_nets", shares, w->fraction[k]);
        if (status == PD_OK) status = PD_NEW(w->ctx, "surface_nets", layer, w->vertex_index[k]);
    }
    if (status == PD_OK) status = pdi_surface_nets_march_layers(w);
    for (int k = 0; k < 2; k++) {
        PD_DELETE(w->ctx, shares, w->fraction[k]);
        PD_DELETE(w->ctx, layer, w->vertex_index[k]);
    }
    return status;
}

PDI_FN pd_status pdi_surface_nets_build(pd_ctx *ctx, const pdi_surface_nets_desc *desc, pdi_surface_nets_mesh *s)
{
    pdi_surface_nets_work w;
    memset(&w, 0, sizeof w);
    memset(s, 0, sizeof *s);
    w.ctx = ctx;
    w.desc = desc;
    w.mesh = s;
    pd_status status = pdi_surface_nets_build_faces(&w);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", 3 * s->vertex_count, w.sum);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", s->vertex_count, w.weight);
    for (int k = 0; k < 2 && status == PD_OK; k++)
        status = PD_NEW(ctx, "surface_nets", 3 * s->face_count, w.face_normal[k]);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", s->vertex_count + 1, w.first_face);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", 4 * s->face_count, w.vertex_face);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", 12 * s->face_capacity, s->corner_normal);
    if (status == PD_OK) status = PD_NEW(ctx, "surface_nets", s->vertex_capacity, s->vertex_value);
    if (status == PD_OK) pdi_surface_nets_finish(&w);
    PD_DELETE(ctx, 3 * s->vertex_count, w.sum);
    PD_DELETE(ctx, s->vertex_count, w.weight);
    for (int k = 0; k < 2; k++) PD_DELETE(ctx, 3 * s->face_count, w.face_normal[k]);
    PD_DELETE(ctx, s->vertex_count + 1, w.first_face);
    PD_DELETE(ctx, 4 * s->face_count, w.vertex_face);
    PD_DELETE(ctx, 3 * w.bound_capacity, w.lower_bound);
    if (status != PD_OK) pdi_surface_nets_free(ctx, s);
    return status;
}

PDI_FN void pdi_surface_nets_free(pd_ctx *ctx, pdi_surface_nets_mesh *s)
{
    PD_DELETE(ctx, 3 * s->vertex_capacity, s->x);
    PD_DELETE(ctx, 12 * s->face_capacity, s->corner_normal);
    PD_DELETE(ctx, s->vertex_capacity, s->vertex_value);
    PD_DELETE(ctx, 4 * s->face_capacity, s->face_vertex);
    PD_DELETE(ctx, s->value_capacity, s->face_value);
    memset(s, 0, sizeof *s);
}

#undef PDI_SURFACE_NETS_SMOOTHING_SWEEPS
#undef PDI_SURFACE_NETS_RELAXATION
#undef PDI_SURFACE_NETS_NORMAL_SWEEPS
#undef PDI_SURFACE_NETS_EDGE_COSINE
#undef PDI_SURFACE_NETS_MIN_DISTANCE
