/* smoother: data of one multigrid level, and its smoothers: red-black and line Gauss-Seidel.
 *
 * The operator of a level is that of multigrid.h: (A x)_c = x_c/inv_c - sum over links of a x. Sweeps go by colour
 * (symmetric) or by line; both are bitwise reproducible for any number of threads.
 */
#ifndef PD_SMOOTHER_H
#define PD_SMOOTHER_H
#include "core/par.h"

/* One multigrid level. Level 0 holds all cells of the box and finds neighbours by stride; coarser levels are sparse
 * rows of links (CSR), the cells sorted by colour (symmetric) or by block. */
typedef struct pd_smoother_level {
    int n[PD_DIM];     /* blocks along the axes */
    int halve[PD_DIM]; /* 1: the next level pairs the blocks of this axis */
    int symmetric_storage;    /* level 0: 1: symmetric storage, lo is hi of the neighbour */
    int periodic[PD_DIM];     /* 1: the axis is periodic */
    float last_width[PD_DIM]; /* width of the last block, the others being 1 */
    int32_t cells, red; /* red: cells of the first colour (symmetric, coarse levels) */
    float *x, *b, *r;  /* [cells] [-] correction, right-hand side, residual */
    float *inverse_diagonal;   /* [cells] 1 / diagonal; 0: inactive cell */
    float *row_sum;            /* [cells] row sum: diagonal less links; NULL without contrast */
    double *coarse_correction; /* [cells] [-] correction of all coarser levels in double precision, then plus x; NULL
                                * without contrast */
    int32_t *parent;   /* [cells] cell of the next level; -1: none */
    int32_t *begin, *end; /* level 0: [cells / n[0]] first active cell of each row along axis 0, and one past the
                           * last; all others hold zeros */
    float *lo[PD_DIM], *hi[PD_DIM]; /* level 0: coefficients of the lower and upper neighbour, 0: closed face */
    int32_t *block;    /* coarse levels: [cells] block of the cell */
    int32_t *row;      /* coarse levels: [cells + 1] offset of the links of a cell */
    int32_t *col;      /* [row[cells]] the neighbour */
    float *a, *reverse; /* coefficient of the neighbour in this row, and of this cell in the row of the neighbour (one
                         * allocation; symmetric: one array) */
    uint8_t *face;     /* direction of the link: 2 axis + (1: upper) */
    /* level 0: [cells] 1: the cell has a periodic neighbour; NULL: no axis is periodic */
    uint8_t *has_periodic_neighbour;
    int32_t *child_first, *child; /* cells of the finer level that form a cell (CSR) */
    float *values;     /* coarse levels: storage of x, b, r, inv and excess */
    int32_t *indices;  /* coarse levels: storage of parent, block, row, child_first */
    int32_t *line;     /* not symmetric: [lines + 1] first cell of each line of blocks along axis 0 */
    int contrast;      /* coarse levels: 1 when there are sum and excess */
    int symmetric;     /* coarse levels: 1 when back is a */
    int32_t cell_capacity, link_capacity, child_capacity, line_capacity;
} pd_smoother_level;

#ifdef PDI_INTERNAL
/* Loops over cells are divided into this many parts, whatever the number of threads. */
#define PDI_SMOOTHER_PARTS 64
/* Scalar operations per cell of a sweep, to choose the number of threads. */
#define PDI_SMOOTHER_WORK (4 * PD_DIM)
/* An operation on cells. */
typedef enum pdi_smoother_op {
    PDI_SMOOTHER_JACOBI,       /* x = b / diag: a Jacobi step from x = 0 */
    PDI_SMOOTHER_GAUSS_SEIDEL, /* x = (b + sum a x) / diag: Gauss-Seidel */
    PDI_SMOOTHER_RESIDUAL,     /* r = b + sum a x - diag x */
    PDI_SMOOTHER_PROLONG,      /* x += x of the parent */
    PDI_SMOOTHER_PROLONG_SUM,  /* sum = sum of the parent */
    PDI_SMOOTHER_DEFECT,       /* b -= A sum; not by colour */
    PDI_SMOOTHER_ADD_TO_SUM    /* sum += x */
} pdi_smoother_op;
/* Index stride along axis d of an array of n [PD_DIM] blocks. */
static inline int32_t pdi_smoother_stride(const int *n, int d)
{
    int32_t stride = 1;
    for (int e = 0; e < d; e++) stride *= n[e];
    return stride;
}
/* First item of a part of a loop over `count` items. */
static inline int32_t pdi_smoother_part_begin(int64_t count, int part)
{
    return (int32_t)(count * part / PDI_SMOOTHER_PARTS);
}
/* Neighbour of cell c of level 0, periodic where the axis is; -1: none. */
static inline int32_t pdi_smoother_find_neighbour(const pd_smoother_level *fine, int32_t stride, int axis, int upper,
                                                  int32_t c)
{
    int32_t n = fine->n[axis], i = c / stride % n;
    if (i != (upper ? n - 1 : 0)) return upper ? c + stride : c - stride;
    if (!fine->periodic[axis]) return -1;
    return upper ? c - (n - 1) * stride : c + (n - 1) * stride;
}

/* Coefficient of `neighbour` in the row of cell c of level 0. With symmetric storage the lower one of a cell is the
 * upper one of the cell below. */
static inline float pdi_smoother_get_coefficient(const pd_smoother_level *fine, int axis, int upper, int32_t c,
                                                 int32_t neighbour)
{
    if (upper) return fine->hi[axis][c];
    return fine->symmetric_storage ? fine->hi[axis][neighbour] : fine->lo[axis][c];
}
/* All threads of a team have to call the following functions. There is no barrier at their end. */
/* Apply an operation to `count` cells from `first`, in any order. PDI_SMOOTHER_RESIDUAL on level 0 takes all cells,
 * whatever `first` and `count` are. */
PDI_FN PDI_NOINLINE void pdi_smoother_apply_range(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_op op,
                                                  int32_t first, int32_t count);
/* Apply an operation to the cells of one colour, 0 (red) or 1, of the red-black ordering; on level 0 to those between
 * begin and end of each row. */
PDI_FN PDI_NOINLINE void pdi_smoother_apply_colour(pdi_par_team team, const pd_smoother_level *level,
                                                   pdi_smoother_op op, int colour);
/* Gauss-Seidel forwards and backwards along every line of axis 0, lines in ascending or descending order within blocks
 * of lines, which are coloured for threads, with a barrier between colours. In 1D it is one line. On level 0 it
 * overwrites r. */
PDI_FN PDI_NOINLINE void pdi_smoother_sweep_lines(pdi_par_team team, const pd_smoother_level *level, int descending);
#endif

#endif
