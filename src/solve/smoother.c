/* smoother: see smoother.h
 *
 * Sums of level 0 have the loop over axes inside that over cells: the other way round gcc interchanges the loops, and
 * uses gather instructions.
 */
#include "solve/smoother.h"

/* Lines are swept in blocks of lines, which are coloured for threads; the partition depends on the size of the level
 * only. This is the largest number of blocks along an axis. */
#define PDI_SMOOTHER_MAX_BLOCKS 8
/* Least number of lines across a block. */
#define PDI_SMOOTHER_MIN_BLOCK_LINES 7
/* A level with fewer cells is a single block. */
#define PDI_SMOOTHER_MIN_BLOCK_CELLS 4096
/* Cells of level 0 that are computed at a time (vectorised). */
#define PDI_SMOOTHER_VECTOR_CELLS 256

/* Neighbours of a row of level 0 along axis 0. Beyond an end of an axis that is not periodic lies another row or a pad,
 * whose coefficients are 0. */
typedef struct pdi_smoother_row_neighbours {
    int32_t below[PD_DIM], above[PD_DIM]; /* index offsets of the neighbours along each axis; periodic for axes 1 and
                                           * up */
    const float *lo[PD_DIM], *hi[PD_DIM]; /* coefficients of all axes, by cell; lo[0] not for the first cell */
} pdi_smoother_row_neighbours;

/* Set the neighbour offsets and coefficients of a row of level 0. */
static void pdi_smoother_find_row_neighbours(const pd_smoother_level *fine, const int32_t *stride, int32_t row,
                                             pdi_smoother_row_neighbours *adjacent)
{
    adjacent->below[0] = -1;
    adjacent->above[0] = 1;
    for (int d = 1; d < PD_DIM; d++) {
        int32_t n = fine->n[d], i = row % n, across = (n - 1) * stride[d];
        adjacent->below[d] = i == 0 && fine->periodic[d] ? across : -stride[d];
        adjacent->above[d] = i == n - 1 && fine->periodic[d] ? -across : stride[d];
        row /= n;
    }
    for (int d = 0; d < PD_DIM; d++) {
        adjacent->lo[d] = fine->symmetric_storage ? fine->hi[d] + adjacent->below[d] : fine->lo[d];
        adjacent->hi[d] = fine->hi[d];
    }
}

/* Sum over links of a x for a cell of level 0 that may have periodic neighbours. */
PDI_NOINLINE static float pdi_smoother_periodic_sum(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    float sum = 0.0f;
    for (int d = 0; d < PD_DIM; d++)
        for (int upper = 0; upper < 2; upper++) {
            int32_t q = pdi_smoother_find_neighbour(fine, stride[d], d, upper, c);
            if (q >= 0) sum += pdi_smoother_get_coefficient(fine, d, upper, c, q) * fine->x[q];
        }
    return sum;
}

/* Sum over links of a x for a cell of level 0. */
static inline float pdi_smoother_fine_sum(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    float sum = 0.0f;
    if (fine->has_periodic_neighbour && fine->has_periodic_neighbour[c])
        return pdi_smoother_periodic_sum(fine, stride, c);
    for (int d = 0; d < PD_DIM; d++)
        sum += fine->lo[d][c] * fine->x[c - stride[d]] + fine->hi[d][c] * fine->x[c + stride[d]];
    return sum;
}

/* Sum over links of a x for a cell of a coarse level. */
static inline float pdi_smoother_coarse_sum(const pd_smoother_level *level, int32_t c)
{
    float sum = 0.0f;
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++) sum += level->a[k] * level->x[level->col[k]];
    return sum;
}

/* Sum over links of a x for a cell of any level. */
static inline float pdi_smoother_sum(const pd_smoother_level *level, const int32_t *stride, int32_t c)
{
    return level->row ? pdi_smoother_coarse_sum(level, c) : pdi_smoother_fine_sum(level, stride, c);
}

/* (A coarse_correction)_c of level 0 from the row sum and differences of neighbours: where links are strong and values
 * nearly equal, as in a good conductor, the rounding of the products would exceed the row sum. */
static inline float pdi_smoother_fine_defect(const pd_smoother_level *fine, const int32_t *stride, int32_t c)
{
    double leave = (double)fine->row_sum[c] * fine->coarse_correction[c];
    for (int d = 0; d < PD_DIM; d++)
        for (int upper = 0; upper < 2; upper++) {
            int32_t q = pdi_smoother_find_neighbour(fine, stride[d], d, upper, c);
            if (q < 0) continue;
            leave += (double)pdi_smoother_get_coefficient(fine, d, upper, c, q) *
                     (fine->coarse_correction[c] - fine->coarse_correction[q]);
        }
    return (float)leave;
}

/* The same on a coarse level. */
static inline float pdi_smoother_coarse_defect(const pd_smoother_level *level, int32_t c)
{
    double leave = (double)level->row_sum[c] * level->coarse_correction[c];
    for (int32_t k = level->row[c]; k < level->row[c + 1]; k++)
        leave += (double)level->a[k] * (level->coarse_correction[c] - level->coarse_correction[level->col[k]]);
    return (float)leave;
}

/* b -= A coarse_correction on `count` cells of level 0 without periodic axes (vectorised). */
static void pdi_smoother_block_defect(const pd_smoother_level *fine, const int32_t *stride, int32_t first,
                                      int32_t count)
{
    const float *PD_RESTRICT excess = fine->row_sum + first;
    const double *PD_RESTRICT sum = fine->coarse_correction + first;
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

/* b -= A coarse_correction on the cells first .. end-1 of any level. */
static void pdi_smoother_subtract_defect(const pd_smoother_level *level, const int32_t *stride, int32_t first,
                                         int32_t end)
{
    float *b = level->b;
    if (level->row)
        for (int32_t c = first; c < end; c++) b[c] -= pdi_smoother_coarse_defect(level, c);
    else if (level->has_periodic_neighbour)
        for (int32_t c = first; c < end; c++) b[c] -= pdi_smoother_fine_defect(level, stride, c);
    else
        for (int32_t c = first; c < end; c += PDI_SMOOTHER_VECTOR_CELLS)
            pdi_smoother_block_defect(level, stride, c,
                                      end - c < PDI_SMOOTHER_VECTOR_CELLS ? end - c : PDI_SMOOTHER_VECTOR_CELLS);
}

/* Apply one operation to the cells first, first + step, ... before end; PDI_SMOOTHER_DEFECT takes all cells between
 * them. stride: index differences to the neighbours. Cells without parent: PDI_SMOOTHER_PROLONG skips them,
 * PDI_SMOOTHER_PROLONG_SUM sets 0. Inactive cells get 0 for x and r. */
static inline void pdi_smoother_apply_cells(const pd_smoother_level *level, const int32_t *stride, pdi_smoother_op op,
                                            int32_t first, int32_t end, int32_t step)
{
    float *x = level->x;
    const float *b = level->b, *inv = level->inverse_diagonal;
    switch (op) {
    case PDI_SMOOTHER_JACOBI:
        for (int32_t c = first; c < end; c += step) x[c] = b[c] * inv[c];
        break;
    case PDI_SMOOTHER_GAUSS_SEIDEL:
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
    case PDI_SMOOTHER_PROLONG_SUM:
        for (int32_t c = first; c < end; c += step)
            level->coarse_correction[c] = level->parent[c] >= 0 ? level[1].coarse_correction[level->parent[c]] : 0.0;
        break;
    case PDI_SMOOTHER_DEFECT: pdi_smoother_subtract_defect(level, stride, first, end); break;
    case PDI_SMOOTHER_ADD_TO_SUM:
        for (int32_t c = first; c < end; c += step) level->coarse_correction[c] += (double)x[c];
        break;
    }
}

/* Index strides [PD_DIM] of the blocks of a level. */
static void pdi_smoother_compute_strides(const pd_smoother_level *level, int32_t *stride)
{
    for (int d = 0; d < PD_DIM; d++) stride[d] = pdi_smoother_stride(level->n, d);
}

/* Colour, 0 or 1, of the first cell of row r of level 0. */
static int pdi_smoother_row_colour(const pd_smoother_level *fine, int32_t r)
{
    int sum = 0;
    for (int d = 1; d < PD_DIM; d++) {
        sum += (int)(r % fine->n[d]);
        r /= fine->n[d];
    }
    return sum & 1;
}

/* Residual r = b + sum - x/inv, 0 at inactive cells, on every `step`-th cell from `first` to before `end` of a row of
 * level 0, none of which has a periodic neighbour along axis 0. Cells between are computed too, for vectorisation, but
 * not stored. */
static void pdi_smoother_compute_residuals(const pd_smoother_level *fine, const pdi_smoother_row_neighbours *adjacent,
                                           int32_t first, int32_t end, int32_t step)
{
    float next[PDI_SMOOTHER_VECTOR_CELLS];
    for (int32_t at = first; at < end; at += PDI_SMOOTHER_VECTOR_CELLS) {
        int n = end - at < PDI_SMOOTHER_VECTOR_CELLS ? (int)(end - at) : PDI_SMOOTHER_VECTOR_CELLS;
        const float *b = fine->b + at, *inv = fine->inverse_diagonal + at, *x = fine->x + at, *lo[PD_DIM], *hi[PD_DIM];
        float *r = fine->r + at;
        for (int d = 0; d < PD_DIM; d++) {
            lo[d] = adjacent->lo[d] + at;
            hi[d] = adjacent->hi[d] + at;
        }
        for (int c = 0; c < n; c++) {
            float sum = 0.0f, share = inv[c] > 0.0f ? inv[c] : 1.0f;
            for (int d = 0; d < PD_DIM; d++)
                sum += lo[d][c] * x[c + adjacent->below[d]] + hi[d][c] * x[c + adjacent->above[d]];
            float left = b[c] + sum - x[c] / share;
            next[c] = inv[c] > 0.0f ? left : 0.0f;
        }
        for (int c = 0; c < n; c += step) r[c] = next[c];
    }
}

/* Residual on every `step`-th cell of a row of level 0 from `first` on. Where axis 0 is periodic, the first and the
 * last cell of the row are treated separately. */
static void pdi_smoother_row_residual(const pd_smoother_level *fine, const int32_t *stride, int32_t row, int32_t first,
                                      int32_t end, int32_t step)
{
    pdi_smoother_row_neighbours adjacent;
    int32_t begin = row * fine->n[0], last = begin + fine->n[0] - 1, inner = end;
    pdi_smoother_find_row_neighbours(fine, stride, row, &adjacent);
    if (fine->periodic[0]) {
        if (first == begin && first < end) {
            pdi_smoother_apply_cells(fine, stride, PDI_SMOOTHER_RESIDUAL, first, first + 1, 1);
            first += step;
        }
        if (end > last) inner = last;
    }
    pdi_smoother_compute_residuals(fine, &adjacent, first, inner, step);
    if (inner < end && first <= last && (last - first) % step == 0)
        pdi_smoother_apply_cells(fine, stride, PDI_SMOOTHER_RESIDUAL, last, last + 1, 1);
}

PDI_FN void pdi_smoother_apply_range(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_op op,
                                     int32_t first, int32_t count)
{
    int32_t stride[PD_DIM], n0 = level->n[0];
    pdi_smoother_compute_strides(level, stride);
    if (level->row || op != PDI_SMOOTHER_RESIDUAL) {
        pdi_smoother_apply_cells(level, stride, op, first + pdi_par_range_begin(team, count),
                                 first + pdi_par_range_end(team, count), 1);
        return;
    }
    int32_t rows = level->cells / n0;
    for (int32_t r = pdi_par_range_begin(team, rows); r < pdi_par_range_end(team, rows); r++)
        pdi_smoother_row_residual(level, stride, r, r * n0, (r + 1) * n0, 1);
}

/* x = b/diag (sweep 0) or (b + sum)/diag (sweep 1) on every second cell from `first` of a row of level 0, none of which
 * has a periodic neighbour along axis 0. The cells between, which the sums read, are computed too, for vectorisation,
 * but not stored. */
static void pdi_smoother_every_second(const pd_smoother_level *fine, const pdi_smoother_row_neighbours *adjacent,
                                      int sweep, int32_t first, int32_t end)
{
    float next[PDI_SMOOTHER_VECTOR_CELLS];
    for (int32_t at = first; at < end; at += PDI_SMOOTHER_VECTOR_CELLS) {
        int n = end - at < PDI_SMOOTHER_VECTOR_CELLS ? (int)(end - at) : PDI_SMOOTHER_VECTOR_CELLS;
        const float *b = fine->b + at, *inv = fine->inverse_diagonal + at, *lo[PD_DIM], *hi[PD_DIM];
        float *x = fine->x + at;
        for (int d = 0; d < PD_DIM; d++) {
            lo[d] = adjacent->lo[d] + at;
            hi[d] = adjacent->hi[d] + at;
        }
        if (sweep)
            for (int c = 0; c < n; c++) {
                float sum = 0.0f;
                for (int d = 0; d < PD_DIM; d++)
                    sum += lo[d][c] * x[c + adjacent->below[d]] + hi[d][c] * x[c + adjacent->above[d]];
                next[c] = (b[c] + sum) * inv[c];
            }
        else
            for (int c = 0; c < n; c++) next[c] = b[c] * inv[c];
        for (int c = 0; c < n; c += 2) x[c] = next[c];
    }
}

/* PDI_SMOOTHER_JACOBI or PDI_SMOOTHER_GAUSS_SEIDEL on every second cell of row r of level 0 from `first` (one colour).
 * Where axis 0 is periodic, the first and the last cell of the row are treated separately. */
static void pdi_smoother_row_sweep(const pd_smoother_level *fine, const int32_t *stride, pdi_smoother_op op, int32_t r,
                                   int32_t first)
{
    pdi_smoother_row_neighbours adjacent;
    int32_t begin = r * fine->n[0], last = begin + fine->n[0] - 1, end = fine->end[r], inner = end;
    pdi_smoother_find_row_neighbours(fine, stride, r, &adjacent);
    if (fine->periodic[0]) {
        if (first == begin && first < end) {
            pdi_smoother_apply_cells(fine, stride, op, first, first + 1, 1);
            first += 2;
        }
        if (end > last) inner = last;
    }
    pdi_smoother_every_second(fine, &adjacent, op == PDI_SMOOTHER_GAUSS_SEIDEL, first, inner);
    if (inner < end && first <= last && (last - first) % 2 == 0)
        pdi_smoother_apply_cells(fine, stride, op, last, last + 1, 1);
}

PDI_FN void pdi_smoother_apply_colour(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_op op, int colour)
{
    int32_t stride[PD_DIM], n0 = level->n[0], rows = level->cells / n0;
    if (level->row) {
        pdi_smoother_apply_range(team, level, op, colour ? level->red : 0,
                                 colour ? level->cells - level->red : level->red);
        return;
    }
    pdi_smoother_compute_strides(level, stride);
    for (int32_t r = pdi_par_range_begin(team, rows); r < pdi_par_range_end(team, rows); r++) {
        int32_t first = level->begin[r];
        first += ((first - r * n0) ^ pdi_smoother_row_colour(level, r) ^ colour) & 1;
        if (op == PDI_SMOOTHER_JACOBI || op == PDI_SMOOTHER_GAUSS_SEIDEL)
            pdi_smoother_row_sweep(level, stride, op, r, first);
        else if (op == PDI_SMOOTHER_RESIDUAL)
            pdi_smoother_row_residual(level, stride, r, first, level->end[r], 2);
        else pdi_smoother_apply_cells(level, stride, op, first, level->end[r], 2);
    }
}

/* Gauss-Seidel forwards and backwards over the cells first .. end-1, one line of a coarse level. */
PDI_NOINLINE static void pdi_smoother_sweep_coarse_line(const pd_smoother_level *level, int32_t first, int32_t end)
{
    float *x = level->x;
    const float *b = level->b, *inv = level->inverse_diagonal;
    for (int32_t c = first; c < end; c++) x[c] = (b[c] + pdi_smoother_coarse_sum(level, c)) * inv[c];
    for (int32_t c = end - 1; c >= first; c--) x[c] = (b[c] + pdi_smoother_coarse_sum(level, c)) * inv[c];
}

/* r = b + contributions of the other lines to a line of level 0, which are constant while the line is swept. */
PDI_NOINLINE static void pdi_smoother_fine_line_rhs(const pd_smoother_level *fine, const int32_t *stride, int32_t line)
{
    int32_t n = fine->n[0], first = line * n;
    const float *PD_RESTRICT x = fine->x + first, *PD_RESTRICT b = fine->b + first, *lo[PD_DIM], *hi[PD_DIM];
    float *PD_RESTRICT given = fine->r + first;
    pdi_smoother_row_neighbours adjacent;
    pdi_smoother_find_row_neighbours(fine, stride, line, &adjacent);
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = adjacent.lo[d] + first;
        hi[d] = adjacent.hi[d] + first;
    }
    for (int32_t c = 0; c < n; c++) {
        float sum = b[c];
        for (int d = 1; d < PD_DIM; d++)
            sum += lo[d][c] * x[c + adjacent.below[d]] + hi[d][c] * x[c + adjacent.above[d]];
        given[c] = sum;
    }
}

/* Gauss-Seidel forwards and backwards along `lines` (1 or 2) lines of level 0 that are not neighbours; overwrites their
 * r. Only one product and one sum depend on the cell before; two lines at a time hide that latency. */
static inline void pdi_smoother_sweep_fine_lines(const pd_smoother_level *fine, const int32_t *stride,
                                                 const int32_t *line, int lines)
{
    const float *PD_RESTRICT lo = fine->lo[0], *PD_RESTRICT hi = fine->hi[0], *PD_RESTRICT inv = fine->inverse_diagonal;
    const float *PD_RESTRICT given = fine->r;
    float *PD_RESTRICT x = fine->x, last[2] = {0.0f, 0.0f};
    int32_t n = fine->n[0], first[2] = {0, 0};
    int wrap = fine->periodic[0];
    for (int l = 0; l < lines; l++) {
        first[l] = line[l] * n;
        pdi_smoother_fine_line_rhs(fine, stride, line[l]);
        if (wrap) last[l] = x[first[l] + n - 1];
    }
    for (int32_t i = 0; i < n - 1; i++)
        for (int l = 0; l < lines; l++) {
            int32_t c = first[l] + i;
            x[c] = last[l] = (given[c] + hi[c] * x[c + 1]) * inv[c] + lo[c] * inv[c] * last[l];
        }
    for (int l = 0; l < lines; l++) {
        int32_t c = first[l] + n - 1;
        float behind = wrap ? x[first[l]] : 0.0f;
        x[c] = (given[c] + hi[c] * behind) * inv[c] + lo[c] * inv[c] * last[l];
        last[l] = behind;
    }
    for (int32_t i = n - 1; i > 0; i--)
        for (int l = 0; l < lines; l++) {
            int32_t c = first[l] + i;
            x[c] = last[l] = (given[c] + lo[c] * x[c - 1]) * inv[c] + hi[c] * inv[c] * last[l];
        }
    for (int l = 0; l < lines; l++) {
        int32_t c = first[l];
        float before = wrap ? x[c + n - 1] : 0.0f;
        x[c] = (given[c] + lo[c] * before) * inv[c] + hi[c] * inv[c] * last[l];
    }
}

/* Gauss-Seidel along the lines line[0] and, where `lines` is 2, line[1], of any level. */
PDI_NOINLINE static void pdi_smoother_sweep_line(const pd_smoother_level *level, const int32_t *stride,
                                                 const int32_t *line, int lines)
{
    if (level->row)
        for (int l = 0; l < lines; l++)
            pdi_smoother_sweep_coarse_line(level, level->line[line[l]], level->line[line[l] + 1]);
    else if (lines > 1) pdi_smoother_sweep_fine_lines(level, stride, line, 2);
    else pdi_smoother_sweep_fine_lines(level, stride, line, 1);
}

/* A block of lines: its first line and its size along the axes 1 and up, and its number of lines. */
typedef struct pdi_smoother_block {
    int32_t first[PD_DIM], n[PD_DIM], lines;
} pdi_smoother_block;

/* Number of blocks along the axes 1 and up into blocks [PD_DIM], one for each 7 lines and at most 8: 1, or an even
 * number, since the last may be a periodic neighbour of the first. 1 on levels of fewer than
 * PDI_SMOOTHER_MIN_BLOCK_CELLS cells. blocks[0] is not set. */
static void pdi_smoother_count_axis_blocks(const pd_smoother_level *level, int *blocks)
{
    for (int d = 1; d < PD_DIM; d++) {
        blocks[d] = level->cells < PDI_SMOOTHER_MIN_BLOCK_CELLS ? 1 : level->n[d] / PDI_SMOOTHER_MIN_BLOCK_LINES;
        if (blocks[d] > PDI_SMOOTHER_MAX_BLOCKS) blocks[d] = PDI_SMOOTHER_MAX_BLOCKS;
        if (blocks[d] > 1) blocks[d] -= blocks[d] % 2;
        if (blocks[d] < 1) blocks[d] = 1;
    }
}

/* Number of blocks of a colour, which are not neighbours; 0 where an axis has one block and the colour is odd there.
 * Bits of colour: even or odd blocks along the axes 1 and up. */
static int pdi_smoother_count_blocks(const int *blocks, int colour)
{
    int count = 1;
    for (int d = 1; d < PD_DIM; d++) count *= blocks[d] > 1 ? blocks[d] / 2 : 1 - (colour >> (d - 1) & 1);
    return count;
}

/* Block number k of a colour. */
static pdi_smoother_block pdi_smoother_get_block(const pd_smoother_level *level, const int *blocks, int colour, int k)
{
    pdi_smoother_block block;
    block.lines = block.n[0] = 1;
    block.first[0] = 0;
    for (int d = 1; d < PD_DIM; d++) {
        int half = blocks[d] > 1 ? blocks[d] / 2 : 1;
        int at = 2 * (k % half) + (colour >> (d - 1) & 1);
        block.first[d] = (int32_t)((int64_t)level->n[d] * at / blocks[d]);
        block.n[d] = (int32_t)((int64_t)level->n[d] * (at + 1) / blocks[d]) - block.first[d];
        block.lines *= block.n[d];
        k /= half;
    }
    return block;
}

/* Line number q of a block, as a line of the level. */
static int32_t pdi_smoother_block_line(const pd_smoother_level *level, const pdi_smoother_block *block, int32_t q)
{
    int32_t line = 0, stride = 1;
    for (int d = 1; d < PD_DIM; d++) {
        line += (block->first[d] + q % block->n[d]) * stride;
        q /= block->n[d];
        stride *= level->n[d];
    }
    return line;
}

/* Gauss-Seidel on the lines of the blocks k .. k + by - 1 of a colour, `by` (1 or 2) blocks side by side; blocks beyond
 * the last one are left out. Lines of a block go in ascending or descending order. */
static void pdi_smoother_sweep_blocks(const pd_smoother_level *level, const int32_t *stride, const int *blocks,
                                      int colour, int k, int by, int descending)
{
    int count = pdi_smoother_count_blocks(blocks, colour);
    pdi_smoother_block block[2];
    int32_t longest = 0;
    block[1].lines = 0;
    for (int l = 0; l < by && k + l < count; l++) {
        block[l] = pdi_smoother_get_block(level, blocks, colour, k + l);
        if (block[l].lines > longest) longest = block[l].lines;
    }
    for (int32_t q = 0; q < longest; q++) {
        int32_t line[2];
        int lines = 0;
        for (int l = 0; l < by; l++) {
            int32_t at = descending ? block[l].lines - 1 - q : q;
            if (q < block[l].lines) line[lines++] = pdi_smoother_block_line(level, &block[l], at);
        }
        pdi_smoother_sweep_line(level, stride, line, lines);
    }
}

PDI_FN void pdi_smoother_sweep_lines(pdi_par_team team, const pd_smoother_level *level, int descending)
{
    int32_t stride[PD_DIM];
    int blocks[PD_DIM], colours = 1 << (PD_DIM - 1);
    pdi_smoother_compute_strides(level, stride);
    pdi_smoother_count_axis_blocks(level, blocks);
    for (int k = 0; k < colours; k++) {
        int colour = descending ? colours - 1 - k : k, count = pdi_smoother_count_blocks(blocks, colour);
        int by = !level->row && count >= 2 * team.size ? 2 : 1, groups = (count + by - 1) / by;
        if (k && count) pdi_par_barrier(team);
        for (int g = pdi_par_range_begin(team, groups); g < pdi_par_range_end(team, groups); g++)
            pdi_smoother_sweep_blocks(level, stride, blocks, colour, g * by, by, descending);
    }
}

#undef PDI_SMOOTHER_MAX_BLOCKS
#undef PDI_SMOOTHER_MIN_BLOCK_LINES
#undef PDI_SMOOTHER_MIN_BLOCK_CELLS
#undef PDI_SMOOTHER_VECTOR_CELLS
