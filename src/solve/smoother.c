/* smoother: see smoother.h
 *
 * Sums of level 0 have the loop over axes inside that over cells: the other way round gcc exchanges them, and gathers.
 */
#include "solve/smoother.h"
#include "core/par.h"

/* Lines are swept in slabs along the last axis, even slabs then odd ones; the partition depends on the size only. This
 * is the largest number of slabs. */
#define PDI_SMOOTHER_SLABS 8
/* Least planes of a slab. */
#define PDI_SMOOTHER_SLAB_PLANES 7
/* A level with fewer cells is one slab. */
#define PDI_SMOOTHER_SLAB_CELLS 4096
/* Cells of level 0 whose defects are summed at a time. */
#define PDI_SMOOTHER_BLOCK 256

/* sum over links of a x */
PDI_ONCE static float pdi_smoother_edge_sum(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    float sum = 0.0f;
    for (int d = 0; d < PD_DIM; d++)
        for (int upper = 0; upper < 2; upper++) {
            int32_t q = pdi_smoother_across(fine, stride[d], d, upper, c);
            if (q >= 0) sum += pdi_smoother_edge_coefficient(fine, d, upper, c, q) * fine->x[q];
        }
    return sum;
}

static inline float pdi_smoother_fine_sum(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    float sum = 0.0f;
    if (fine->edge && fine->edge[c]) return pdi_smoother_edge_sum(fine, stride, c);
    for (int d = 0; d < PD_DIM; d++)
        sum += fine->lo[d][c] * fine->x[c - stride[d]] + fine->hi[d][c] * fine->x[c + stride[d]];
    return sum;
}

static inline float pdi_smoother_coarse_sum(const pd_smoother_level *level, int32_t c)
{
    float sum = 0.0f;
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) sum += level->a[k] * level->x[level->col[k]];
    return sum;
}

static inline float pdi_smoother_sum(const pd_smoother_level *level, const int32_t *stride, int32_t c)
{
    return level->row ? pdi_smoother_coarse_sum(level, c) : pdi_smoother_fine_sum(level, stride, c);
}

/* A sum, from differences: where the links are strong and the cells nearly equal, as in a good conductor, the rounding
 * of the products would exceed the excess. */
static inline float pdi_smoother_fine_defect(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    double leave = (double)fine->excess[c] * fine->sum[c];
    for (int d = 0; d < PD_DIM; d++)
        for (int upper = 0; upper < 2; upper++) {
            int32_t q = pdi_smoother_across(fine, stride[d], d, upper, c);
            if (q < 0) continue;
            leave += (double)pdi_smoother_edge_coefficient(fine, d, upper, c, q) * (fine->sum[c] - fine->sum[q]);
        }
    return (float)leave;
}

static inline float pdi_smoother_coarse_defect(const pd_smoother_level *level, int32_t c)
{
    double leave = (double)level->excess[c] * level->sum[c];
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++)
        leave += (double)level->a[k] * (level->sum[c] - level->sum[level->col[k]]);
    return (float)leave;
}

/* b -= A sum on count cells of level 0, no axis of which wraps, bond by bond for the sake of vectors. */
static void pdi_smoother_block_defect(const pd_smoother_level *fine, const int32_t *stride, int32_t first,
                                      int32_t count)
{
    const float *PD_RESTRICT excess = fine->excess + first;
    const double *PD_RESTRICT sum = fine->sum + first;
    float *PD_RESTRICT b = fine->b + first;
    const float *lo[PD_DIM], *hi[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = fine->lo[d] + first;
        hi[d] = fine->hi[d] + first;
    }
    for (int32_t c = 0; c < count; c++) {
        double leave = (double)excess[c] * sum[c];
        for (int d = 0; d < PD_DIM; d++) {
            double below = sum[c] - sum[c - stride[d]], above = sum[c] - sum[c + stride[d]];
            leave += (double)lo[d][c] * below + (double)hi[d][c] * above;
        }
        b[c] -= (float)leave;
    }
}

static void pdi_smoother_defect(const pd_smoother_level *level, const int32_t *stride, int32_t first, int32_t end)
{
    float *b = level->b;
    if (level->row)
        for (int32_t c = first; c < end; c++) b[c] -= pdi_smoother_coarse_defect(level, c);
    else if (level->edge)
        for (int32_t c = first; c < end; c++) b[c] -= pdi_smoother_fine_defect(level, stride, c);
    else
        for (int32_t c = first; c < end; c += PDI_SMOOTHER_BLOCK)
            pdi_smoother_block_defect(level, stride, c, end - c < PDI_SMOOTHER_BLOCK ? end - c : PDI_SMOOTHER_BLOCK);
}

/* One job on the cells first, first + step, ... before end. */
static inline void pdi_smoother_cells(const pd_smoother_level *level, const int32_t *stride, pdi_smoother_job job,
                                    int32_t first, int32_t end, int32_t step)
{
    float *x = level->x;
    const float *b = level->b, *inv = level->inv;
    switch (job) {
    case PDI_SMOOTHER_START:
        for (int32_t c = first; c < end; c += step) x[c] = b[c] * inv[c];
        break;
    case PDI_SMOOTHER_SWEEP:
        for (int32_t c = first; c < end; c += step) x[c] = (b[c] + pdi_smoother_sum(level, stride, c)) * inv[c];
        break;
    case PDI_SMOOTHER_RESIDUAL:
        for (int32_t c = first; c < end; c += step)
            level->r[c] = inv[c] > 0.0f ? b[c] + pdi_smoother_sum(level, stride, c) - x[c] / inv[c] : 0.0f;
        break;
    case PDI_SMOOTHER_PROLONG: /* the levels lie in one array: the next one is level + 1 */
        for (int32_t c = first; c < end; c += step)
            if (level->parent[c] >= 0) x[c] += level[1].x[level->parent[c]];
        break;
    case PDI_SMOOTHER_INHERIT:
        for (int32_t c = first; c < end; c += step)
            level->sum[c] = level->parent[c] >= 0 ? level[1].sum[level->parent[c]] : 0.0;
        break;
    case PDI_SMOOTHER_DEFECT:
        pdi_smoother_defect(level, stride, first, end);
        break;
    case PDI_SMOOTHER_COLLECT:
        for (int32_t c = first; c < end; c += step) level->sum[c] += (double)x[c];
        break;
    }
}

static void pdi_smoother_strides(const pd_smoother_level *level, int32_t *stride)
{
    for (int d = 0; d < PD_DIM; d++) stride[d] = pdi_smoother_stride(level->n, d);
}

/* Colour of the first cell of row r of level 0. */
static int pdi_smoother_row_colour(const pd_smoother_level *fine, int32_t r)
{
    int sum = 0;
    for (int d = 1; d < PD_DIM; d++) {
        sum += (int)(r % fine->n[d]);
        r /= fine->n[d];
    }
    return sum & 1;
}

/* A job on count cells from `first`, in any order. */
PDI_FN void pdi_smoother_range(const pd_ctx *ctx, const pd_smoother_level *level, pdi_smoother_job job,
                                int32_t first, int32_t count)
{
    int32_t stride[PD_DIM];
    pdi_smoother_strides(level, stride);
    int nt = pdi_par_threads(ctx, (int64_t)count * PDI_SMOOTHER_WORK);
    if (nt == 1) {
        pdi_smoother_cells(level, stride, job, first, first + count, 1);
        return;
    }
    PDI_PARALLEL_FOR(nt)
    for (int part = 0; part < PDI_SMOOTHER_PARTS; part++)
        pdi_smoother_cells(level, stride, job, first + pdi_smoother_part(count, part),
                            first + pdi_smoother_part(count, part + 1), 1);
}

/* x = b/a (START) or (b + sum)/a (SWEEP) on every second cell from `first` of a row of level 0 without edges. The cells
 * between, which the sums read, are computed too, for the sake of vectors, and left as they are. */
static void pdi_smoother_every_second(const pd_smoother_level *fine, const int32_t *stride, int sweep, int32_t first,
                                    int32_t end)
{
    float next[PDI_SMOOTHER_BLOCK];
    for (int32_t at = first; at < end; at += PDI_SMOOTHER_BLOCK) {
        int n = end - at < PDI_SMOOTHER_BLOCK ? (int)(end - at) : PDI_SMOOTHER_BLOCK;
        const float *b = fine->b + at, *inv = fine->inv + at, *lo[PD_DIM], *hi[PD_DIM];
        float *x = fine->x + at;
        for (int d = 0; d < PD_DIM; d++) {
            lo[d] = fine->lo[d] + at;
            hi[d] = fine->hi[d] + at;
        }
        if (sweep)
            for (int c = 0; c < n; c++) {
                float sum = 0.0f;
                for (int d = 0; d < PD_DIM; d++) sum += lo[d][c] * x[c - stride[d]] + hi[d][c] * x[c + stride[d]];
                next[c] = (b[c] + sum) * inv[c];
            }
        else
            for (int c = 0; c < n; c++) next[c] = b[c] * inv[c];
        for (int c = 0; c < n; c += 2) x[c] = next[c];
    }
}

/* A job on the cells of one colour of level 0: the share of one thread. */
static void pdi_smoother_rows(const pd_smoother_level *level, const int32_t *stride, pdi_smoother_job job, int colour)
{
    int32_t n0 = level->n[0], rows = level->cells / n0;
    PDI_FOR
    for (int32_t r = 0; r < rows; r++) {
        int32_t first = level->begin[r];
        first += ((first - r * n0) ^ pdi_smoother_row_colour(level, r) ^ colour) & 1;
        if (!level->edge && (job == PDI_SMOOTHER_START || job == PDI_SMOOTHER_SWEEP))
            pdi_smoother_every_second(level, stride, job == PDI_SMOOTHER_SWEEP, first, level->end[r]);
        else pdi_smoother_cells(level, stride, job, first, level->end[r], 2);
    }
}

/* A job on the cells of one colour: they do not touch each other. */
PDI_FN void pdi_smoother_colour(const pd_ctx *ctx, const pd_smoother_level *level, pdi_smoother_job job, int colour)
{
    if (level->row) {
        pdi_smoother_range(ctx, level, job, colour ? level->red : 0, colour ? level->cells - level->red : level->red);
        return;
    }
    int32_t stride[PD_DIM];
    pdi_smoother_strides(level, stride);
    int nt = pdi_par_threads(ctx, (int64_t)level->cells * PDI_SMOOTHER_WORK);
    PDI_SHARE(nt, pdi_smoother_rows(level, stride, job, colour));
}

/* Gauss-Seidel forth and back along one line of a coarse level, or one that meets itself across the box. */
PDI_ONCE static void pdi_smoother_linked_line(const pd_smoother_level *level, const int32_t *stride, int32_t first,
                                              int32_t end)
{
    float *x = level->x;
    const float *b = level->b, *inv = level->inv;
    for (int32_t c = first; c < end; c++) x[c] = (b[c] + pdi_smoother_sum(level, stride, c)) * inv[c];
    for (int32_t c = end - 1; c >= first; c--) x[c] = (b[c] + pdi_smoother_sum(level, stride, c)) * inv[c];
}

/* What the other lines give a line of level 0, into r: it does not change while the line is swept. */
PDI_ONCE static void pdi_smoother_fine_given(const pd_smoother_level *fine, const int32_t *stride, int32_t first,
                                             int32_t n)
{
    const float *PD_RESTRICT x = fine->x + first, *PD_RESTRICT b = fine->b + first, *lo[PD_DIM], *hi[PD_DIM];
    float *PD_RESTRICT given = fine->r + first;
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = fine->lo[d] + first;
        hi[d] = fine->hi[d] + first;
    }
    for (int32_t c = 0; c < n; c++) {
        float sum = b[c];
        for (int d = 1; d < PD_DIM; d++) sum += lo[d][c] * x[c - stride[d]] + hi[d][c] * x[c + stride[d]];
        given[c] = sum;
    }
}

/* The same as above on `lines` (1 or 2) lines of level 0 from the cells `first`, of n cells each, that do not touch
 * each other. Only one product and one sum wait for the cell before, and two lines wait together. */
static inline void pdi_smoother_fine_lines(const pd_smoother_level *fine, const int32_t *stride, const int32_t *first,
                                         int32_t n, int lines)
{
    const float *PD_RESTRICT lo = fine->lo[0], *PD_RESTRICT hi = fine->hi[0], *PD_RESTRICT inv = fine->inv;
    const float *PD_RESTRICT given = fine->r;
    float *PD_RESTRICT x = fine->x, last[2] = {0.0f, 0.0f};
    for (int l = 0; l < lines; l++) pdi_smoother_fine_given(fine, stride, first[l], n);
    for (int32_t i = 0; i < n; i++)
        for (int l = 0; l < lines; l++) {
            int32_t c = first[l] + i;
            x[c] = last[l] = (given[c] + hi[c] * x[c + 1]) * inv[c] + lo[c] * inv[c] * last[l];
        }
    last[0] = last[1] = 0.0f;
    for (int32_t i = n - 1; i > 0; i--)
        for (int l = 0; l < lines; l++) {
            int32_t c = first[l] + i;
            x[c] = last[l] = (given[c] + lo[c] * x[c - 1]) * inv[c] + hi[c] * inv[c] * last[l];
        }
    for (int l = 0; l < lines; l++) {
        int32_t c = first[l];
        x[c] = given[c] * inv[c] + hi[c] * inv[c] * last[l];
    }
}

/* Lines `line` and `beside` (-1: none). */
PDI_ONCE static void pdi_smoother_line(const pd_smoother_level *level, const int32_t *stride, int32_t line,
                                       int32_t beside)
{
    int32_t n0 = level->n[0], first[2];
    first[0] = line * n0;
    first[1] = beside * n0;
    if (level->row || level->edge) {
        for (int32_t q = line; q >= 0; q = q == line ? beside : -1) {
            if (level->row) pdi_smoother_linked_line(level, stride, level->line[q], level->line[q + 1]);
            else pdi_smoother_linked_line(level, stride, q * n0, (q + 1) * n0);
        }
    } else if (beside >= 0) pdi_smoother_fine_lines(level, stride, first, n0, 2);
    else pdi_smoother_fine_lines(level, stride, first, n0, 1);
}

/* Lines [begin[0], end[0]) and, where it is not empty, [begin[1], end[1]) at their side. */
static void pdi_smoother_slabs(const pd_smoother_level *level, const int32_t *stride, const int32_t *begin,
                             const int32_t *end, int descending)
{
    int32_t count[2];
    for (int l = 0; l < 2; l++) count[l] = end[l] - begin[l];
    for (int32_t q = 0; q < count[0] || q < count[1]; q++) {
        int32_t line[2];
        for (int l = 0; l < 2; l++) line[l] = q >= count[l] ? -1 : descending ? end[l] - 1 - q : begin[l] + q;
        if (line[0] >= 0) pdi_smoother_line(level, stride, line[0], line[1]);
        else pdi_smoother_line(level, stride, line[1], -1);
    }
}

/* Lines of the slabs of one parity, which do not touch each other and are swept by twos: the share of one thread. */
static void pdi_smoother_half(const pd_smoother_level *level, const int32_t *stride, int slabs, int parity,
                              int descending)
{
    int32_t planes = PD_DIM > 1 ? level->n[PD_DIM - 1] : 1, lines = 1;
    for (int d = 1; d < PD_DIM; d++) lines *= level->n[d];
    PDI_FOR
    for (int s = parity; s < slabs; s += 4) {
        int32_t begin[2], end[2];
        for (int l = 0; l < 2; l++) {
            int slab = s + 2 * l < slabs ? s + 2 * l : -1;
            begin[l] = slab < 0 ? 0 : (int32_t)((int64_t)planes * slab / slabs) * (lines / planes);
            end[l] = slab < 0 ? 0 : (int32_t)((int64_t)planes * (slab + 1) / slabs) * (lines / planes);
        }
        pdi_smoother_slabs(level, stride, begin, end, descending);
    }
}

/* Lines of the slabs, ascending or descending, one parity after the other. */
PDI_FN void pdi_smoother_lines(const pd_ctx *ctx, const pd_smoother_level *level, int descending)
{
    int32_t stride[PD_DIM], planes = PD_DIM > 1 ? level->n[PD_DIM - 1] : 1;
    pdi_smoother_strides(level, stride);
    int slabs = level->cells < PDI_SMOOTHER_SLAB_CELLS ? 1 : (int)(planes / PDI_SMOOTHER_SLAB_PLANES);
    if (slabs > PDI_SMOOTHER_SLABS) slabs = PDI_SMOOTHER_SLABS;
    if (slabs > 1) slabs -= slabs % 2; /* as many of either parity; the last may touch the first */
    if (slabs < 1) slabs = 1;
    int nt = slabs > 4 ? pdi_par_threads(ctx, (int64_t)level->cells * PDI_SMOOTHER_WORK) : 1;
    for (int half = 0; half < 2; half++) {
        int parity = descending ? 1 - half : half;
        PDI_SHARE(nt, pdi_smoother_half(level, stride, slabs, parity, descending));
    }
}

#undef PDI_SMOOTHER_SLABS
#undef PDI_SMOOTHER_SLAB_PLANES
#undef PDI_SMOOTHER_SLAB_CELLS
#undef PDI_SMOOTHER_BLOCK
