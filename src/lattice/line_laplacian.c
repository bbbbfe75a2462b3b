/* line_laplacian: see line_laplacian.h
 *
 * Each pass streams over the columns of a chunk of nodes, a few operands at a time: results stay in the L1 cache.
 */
#include "lattice/line_laplacian.h"

/* [cells] Largest reach of a family (m = 12). */
#define PDI_LINE_LAPLACIAN_MAX_REACH 12
/* Nodes in a chunk. */
#define PDI_LINE_LAPLACIAN_CHUNK 256
/* Columns of a chunk with the reach on both sides, in multiples of the vector length. */
#define PDI_LINE_LAPLACIAN_COLUMNS (PDI_LINE_LAPLACIAN_CHUNK + 2 * PDI_LINE_LAPLACIAN_MAX_REACH + PDI_VECTOR_LENGTH)
/* Kinds of lines that are processed at a time. */
#define PDI_LINE_LAPLACIAN_MAX_KINDS 4

/* sum (+)= (a - c) + (b - c): differences of a grid line and its mirror image a, b to the line c through the node. With
 * `first` the sum is set, else added to. */
static void pdi_line_laplacian_sum_pair(const double *PD_RESTRICT c, const double *PD_RESTRICT a,
                                        const double *PD_RESTRICT b, int first, int n, double *PD_RESTRICT sum)
{
    if (first)
        for (int k = 0; k < n; k++) sum[k] = (a[k] - c[k]) + (b[k] - c[k]);
    else
        for (int k = 0; k < n; k++) sum[k] += (a[k] - c[k]) + (b[k] - c[k]);
}

/* sum (+)= differences of two pairs of opposite grid lines, at the node shifts shift[4], to the line c through the
 * node. With `first` the sum is set, else added to. */
static void pdi_line_laplacian_sum_two_pairs(const double *PD_RESTRICT c, const int32_t *shift, int first, int n,
                                             double *PD_RESTRICT sum)
{
    const double *PD_RESTRICT p = c + shift[0], *PD_RESTRICT q = c + shift[1];
    const double *PD_RESTRICT r = c + shift[2], *PD_RESTRICT s = c + shift[3];
    if (first)
        for (int k = 0; k < n; k++) sum[k] = ((p[k] - c[k]) + (q[k] - c[k])) + ((r[k] - c[k]) + (s[k] - c[k]));
    else
        for (int k = 0; k < n; k++) sum[k] += ((p[k] - c[k]) + (q[k] - c[k])) + ((r[k] - c[k]) + (s[k] - c[k]));
}

/* sum = differences of four pairs of opposite grid lines, at the node shifts shift[8], to the line c through the
 * node. */
static void pdi_line_laplacian_sum_four_pairs(const double *PD_RESTRICT c, const int32_t *shift, int n,
                                              double *PD_RESTRICT sum)
{
    const double *PD_RESTRICT p = c + shift[0], *PD_RESTRICT q = c + shift[1];
    const double *PD_RESTRICT r = c + shift[2], *PD_RESTRICT s = c + shift[3];
    const double *PD_RESTRICT t = c + shift[4], *PD_RESTRICT u = c + shift[5];
    const double *PD_RESTRICT v = c + shift[6], *PD_RESTRICT w = c + shift[7];
    for (int k = 0; k < n; k++)
        sum[k] = (((p[k] - c[k]) + (q[k] - c[k])) + ((r[k] - c[k]) + (s[k] - c[k]))) +
                 (((t[k] - c[k]) + (u[k] - c[k])) + ((v[k] - c[k]) + (w[k] - c[k])));
}

/* sum [n] = differences of all grid lines of one kind to the line through the node, in the n columns from f on. The
 * number of lines is even: opposite ones are paired. */
static void pdi_line_laplacian_sum_kind(const pdi_line_laplacian_data *lines, const double *f, int kind, int n,
                                        double *sum)
{
    const int32_t *shift = lines->shift;
    int first = lines->stencil->line_first[kind], end = lines->stencil->line_first[kind + 1], l = first;
    if (end - l >= 8) {
        pdi_line_laplacian_sum_four_pairs(f, shift + l, n, sum);
        l += 8;
    }
    for (; l + 4 <= end; l += 4) pdi_line_laplacian_sum_two_pairs(f, shift + l, l == first, n, sum);
    for (; l < end; l += 2) pdi_line_laplacian_sum_pair(f, f + shift[l], f + shift[l + 1], l == first, n, sum);
}

/* t [n] (+)= a[0] x[0] + .. + a[kinds-1] x[kinds-1], with 0 to 4 kinds; a [4] is read in full. With `first` t is set (0
 * without kinds), else added to (left alone without kinds). */
static void pdi_line_laplacian_sum_weighted(double (*x)[PDI_LINE_LAPLACIAN_COLUMNS], const double *a, int kinds,
                                            int first, int n, double *PD_RESTRICT t)
{
    const double *PD_RESTRICT p = x[0], *PD_RESTRICT q = x[1], *PD_RESTRICT r = x[2], *PD_RESTRICT s = x[3];
    double b = a[0], c = a[1], d = a[2], e = a[3];
    if (kinds == 4 && first)
        for (int k = 0; k < n; k++) t[k] = (b * p[k] + c * q[k]) + (d * r[k] + e * s[k]);
    else if (kinds == 4)
        for (int k = 0; k < n; k++) t[k] += (b * p[k] + c * q[k]) + (d * r[k] + e * s[k]);
    else if (first)
        for (int k = 0; k < n; k++) t[k] = 0.0;
    if (kinds == 3)
        for (int k = 0; k < n; k++) t[k] += (b * p[k] + c * q[k]) + d * r[k];
    if (kinds == 2)
        for (int k = 0; k < n; k++) t[k] += b * p[k] + c * q[k];
    if (kinds == 1)
        for (int k = 0; k < n; k++) t[k] += b * p[k];
}

/* t [4][n] = weighted sums of the layers 0 to 3 for the family of m = 3 in 2D in one pass, in the n columns from f on:
 * three pairs of grid lines, with the reach 3, 2 and 1 and the weights a [3][4]. */
static void pdi_line_laplacian_sum_m3_2d(const double *PD_RESTRICT f, const int32_t *shift, const double *a, int n,
                                         double (*t)[PDI_LINE_LAPLACIAN_COLUMNS])
{
    const double *PD_RESTRICT u = f + shift[0], *PD_RESTRICT v = f + shift[1], *PD_RESTRICT w = f + shift[2];
    const double *PD_RESTRICT x = f + shift[3], *PD_RESTRICT y = f + shift[4], *PD_RESTRICT z = f + shift[5];
    double *PD_RESTRICT t0 = t[0], *PD_RESTRICT t1 = t[1], *PD_RESTRICT t2 = t[2], *PD_RESTRICT t3 = t[3];
    for (int k = 0; k < n; k++) {
        double p = (u[k] - f[k]) + (v[k] - f[k]), q = (w[k] - f[k]) + (x[k] - f[k]), r = (y[k] - f[k]) + (z[k] - f[k]);
        t0[k] = (a[0] * p + a[4] * q) + a[8] * r;
        t1[k] = (a[1] * p + a[5] * q) + a[9] * r;
        t2[k] = a[2] * p + a[6] * q;
        t3[k] = a[3] * p;
    }
}

/* 1: the stencil has the grid lines of m = 3 in 2D. */
static int pdi_line_laplacian_is_m3_2d(const pd_stencil *s)
{
    return s->reach == 3 && s->line_kinds == 3 && s->line_first[3] == 6 && s->line_first[1] == 2 &&
           s->line_first[2] == 4 && s->line_reach[0] == 3 && s->line_reach[1] == 2 && s->line_reach[2] == 1;
}

/* Adds to out the layers n and -n along axis 0: the sums `side` of the other grid lines there, and the differences
 * along the line of the node with the weight a of the layer. */
static void pdi_line_laplacian_add_layer(const double *PD_RESTRICT f, const double *PD_RESTRICT side, double a, int n,
                                         int count, double *PD_RESTRICT out)
{
    const double *up = f + n, *down = f - n, *right = side + n, *left = side - n;
    for (int b = 0; b < count; b++) out[b] += (left[b] + right[b]) + a * ((up[b] - f[b]) + (down[b] - f[b]));
}

/* Sets out to the sum of the layers 0 to 3 along axis 0: the sums t of the other grid lines, and the differences
 * along the line f of the node with the weights a of the layers. */
static void pdi_line_laplacian_sum_three_layers(const double *PD_RESTRICT f, double (*t)[PDI_LINE_LAPLACIAN_COLUMNS],
                                                int reach, const double *a, int count, double *PD_RESTRICT out)
{
    const double *PD_RESTRICT s = t[0] + reach, *PD_RESTRICT u = t[1] + reach, *PD_RESTRICT v = t[2] + reach;
    const double *PD_RESTRICT w = t[3] + reach;
    double c = a[1], d = a[2], e = a[3];
    for (int b = 0; b < count; b++)
        out[b] = (s[b] + ((u[b - 1] + u[b + 1]) + c * ((f[b + 1] - f[b]) + (f[b - 1] - f[b])))) +
                 (((v[b - 2] + v[b + 2]) + d * ((f[b + 2] - f[b]) + (f[b - 2] - f[b]))) +
                  ((w[b - 3] + w[b + 3]) + e * ((f[b + 3] - f[b]) + (f[b - 3] - f[b]))));
}

/* out [count] = Laplacian of a chunk of `count` nodes; f points to the first of them. The family of m = 3 in 2D is
 * summed in one pass, others by up to PDI_LINE_LAPLACIAN_MAX_KINDS kinds of lines at a time. Columns beyond the reach
 * of a kind may hold any values: kinds are sorted by reach, and layer n uses those that reach it. `columns` is at least
 * count + 2 reach. */
static void pdi_line_laplacian_apply_chunk(const pdi_line_laplacian_data *lines, const double *f, int count,
                                           int columns, double *out)
{
    const pd_stencil *s = lines->stencil;
    int reach = s->reach, at = 1;
    double x[PDI_LINE_LAPLACIAN_MAX_KINDS][PDI_LINE_LAPLACIAN_COLUMNS],
        t[PDI_LINE_LAPLACIAN_MAX_REACH + 1][PDI_LINE_LAPLACIAN_COLUMNS];
    int three = pdi_line_laplacian_is_m3_2d(s);
    if (three) pdi_line_laplacian_sum_m3_2d(f - reach, lines->shift, s->line_lap, columns, t);
    for (int first = 0; (first == 0 || first < s->line_kinds) && !three; first += PDI_LINE_LAPLACIAN_MAX_KINDS) {
        int some =
            s->line_kinds - first < PDI_LINE_LAPLACIAN_MAX_KINDS ? s->line_kinds - first : PDI_LINE_LAPLACIAN_MAX_KINDS;
        for (int k = 0; k < some; k++) pdi_line_laplacian_sum_kind(lines, f - reach, first + k, columns, x[k]);
        for (int n = 0; n <= reach; n++) {
            double a[PDI_LINE_LAPLACIAN_MAX_KINDS];
            int kinds = 0;
            for (; kinds < some && s->line_reach[first + kinds] >= n; kinds++)
                a[kinds] = s->line_lap[(first + kinds) * (reach + 1) + n];
            for (int k = kinds; k < PDI_LINE_LAPLACIAN_MAX_KINDS; k++) a[k] = 0.0;
            pdi_line_laplacian_sum_weighted(x, a, kinds, first == 0, columns, t[n]);
        }
    }
    if (reach >= 3) {
        pdi_line_laplacian_sum_three_layers(f, t, reach, s->layer_lap, count, out);
        at = 4;
    } else
        for (int b = 0; b < count; b++) out[b] = t[0][b + reach];
    for (; at <= reach; at++) pdi_line_laplacian_add_layer(f, t[at] + reach, s->layer_lap[at], at, count, out);
}

PDI_FN void pdi_line_laplacian_apply(const pdi_line_laplacian_data *lines, const double *f, int32_t i, int32_t length,
                                     double *out)
{
    const pd_grid *grid = lines->grid;
    int reach = lines->stencil->reach, deepest = 0;
    for (int d = 0; d < PD_DIM; d++) deepest += reach * grid->stride[d];
    for (int32_t at = 0; at < length; at += PDI_LINE_LAPLACIAN_CHUNK) {
        int count = length - at < PDI_LINE_LAPLACIAN_CHUNK ? (int)(length - at) : PDI_LINE_LAPLACIAN_CHUNK;
        /* whole vectors, where that does not leave the array */
        int columns = count + 2 * reach,
            vectors = (columns + PDI_VECTOR_LENGTH - 1) / PDI_VECTOR_LENGTH * PDI_VECTOR_LENGTH;
        if (i + at + deepest + vectors - reach <= grid->total) columns = vectors;
        pdi_line_laplacian_apply_chunk(lines, f + i + at, count, columns, out + at);
    }
}
