/* smoother: one level of the multigrid hierarchy, and the sweeps over its cells.
 *
 * The operator of a level is that of multigrid.h: (A x)_c = x_c/inv_c - sum over links of a x. Sweeps go by colour
 * (symmetric) or by line; both give the same bits for any number of threads.
 */
#ifndef PD_SMOOTHER_H
#define PD_SMOOTHER_H
#include "core/par.h"

/* One level. Level 0 holds all cells of the box and finds neighbours by stride; coarser levels are rows of links, the
 * cells sorted by colour (symmetric) or by block. */
typedef struct pd_smoother_level {
    int n[PD_DIM];     /* blocks along the axes */
    int halve[PD_DIM]; /* 1: the next level pairs the blocks of this axis */
    int shared;        /* level 0: lo is hi of the neighbour (symmetric) */
    int wrap[PD_DIM];  /* 1: the first and the last blocks of this axis are linked */
    float last[PD_DIM]; /* width of the last block, the others being 1 */
    int32_t cells, red; /* red: cells of the first colour (symmetric, coarse levels) */
    float *x, *b, *r;  /* [cells] correction, right-hand side, residual */
    float *inv;        /* [cells] 1 / diagonal; 0: the cell takes no part */
    float *excess;     /* [cells] sum of the row: diagonal less links; NULL without contrast */
    double *sum;       /* [cells] [-] as x, from all coarser levels, then with x; NULL without contrast */
    int32_t *parent;   /* [cells] of the next level; -1: none */
    int32_t *begin, *end; /* level 0: [cells / n[0]] of each row along axis 0, first cell that takes part and the one
                           * behind the last; all others hold zeros */
    float *lo[PD_DIM], *hi[PD_DIM]; /* level 0: coefficients of the two neighbours of each axis, 0: closed */
    int32_t *block;    /* coarse levels: [cells] block of the cell */
    int32_t *row;      /* [cells + 1] */
    int32_t *col;      /* [row[cells]] the neighbour */
    float *a, *back;   /* its coefficient in this row, and that of this cell in its row (one allocation; symmetric: one
                        * array) */
    uint8_t *face;     /* 2 axis + (1: upper) */
    uint8_t *edge;     /* level 0: [cells] 1: the cell has a neighbour across the box; NULL: no axis wraps */
    int32_t *child_first, *child; /* cells of the level above that make up a cell */
    float *values;     /* coarse levels: storage of x, b, r, inv and excess */
    int32_t *indices;  /* coarse levels: storage of parent, block, row, child_first */
    int32_t *line;     /* not symmetric: [lines + 1] first cell of each line of blocks along axis 0 */
    int contrast;      /* coarse levels: 1 when there are sum and excess */
    int symmetric;     /* coarse levels: 1 when back is a */
    int32_t cell_capacity, link_capacity, child_capacity, line_capacity;
} pd_smoother_level;

#ifdef PDI_INTERNAL
/* Loops over cells are cut into this many parts. */
#define PDI_SMOOTHER_PARTS 64
/* Operations a cell, to decide on threads. */
#define PDI_SMOOTHER_WORK (4 * PD_DIM)
typedef enum pdi_smoother_job {
    PDI_SMOOTHER_START,    /* x = b / diag */
    PDI_SMOOTHER_SWEEP,   /* x = (b + sum a x) / diag */
    PDI_SMOOTHER_RESIDUAL, /* r = b + sum a x - diag x */
    PDI_SMOOTHER_PROLONG,  /* x += x of the parent */
    PDI_SMOOTHER_INHERIT,  /* sum = sum of the parent */
    PDI_SMOOTHER_DEFECT,   /* b -= A sum; not by colour */
    PDI_SMOOTHER_COLLECT   /* sum += x */
} pdi_smoother_job;
/* Cells from one block to the next along axis d, n blocks along the axes. */
static inline int32_t pdi_smoother_stride(const int *n, int d)
{
    int32_t stride = 1;
    for (int e = 0; e < d; e++) stride *= n[e];
    return stride;
}
/* Begin of a part of a loop over count items. */
static inline int32_t pdi_smoother_part(int64_t count, int part)
{
    return (int32_t)(count * part / PDI_SMOOTHER_PARTS);
}
/* Neighbour of cell c of level 0, across the box where the axis wraps; -1: none. */
static inline int32_t pdi_smoother_across(const pd_smoother_level *fine, int32_t stride, int axis, int upper,
                                           int32_t c)
{
    int32_t n = fine->n[axis], i = c / stride % n;
    if (i != (upper ? n - 1 : 0)) return upper ? c + stride : c - stride;
    if (!fine->wrap[axis]) return -1;
    return upper ? c - (n - 1) * stride : c + (n - 1) * stride;
}

/* Coefficient of `neighbour` in the row of c. With symmetric storage the lower one of a cell is the upper one of the
 * cell below. */
static inline float pdi_smoother_edge_coefficient(const pd_smoother_level *fine, int axis, int upper, int32_t c,
                                                   int32_t neighbour)
{
    if (upper) return fine->hi[axis][c];
    return fine->shared ? fine->hi[axis][neighbour] : fine->lo[axis][c];
}
/* All threads of a team call these, which do not wait for each other at the end. */
/* A job on count cells from `first`, in any order. */
PDI_FN PDI_ONCE void pdi_smoother_range(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_job job,
                                        int32_t first, int32_t count);
/* A job on the cells of one colour: they do not touch each other. */
PDI_FN PDI_ONCE void pdi_smoother_colour(pdi_par_team team, const pd_smoother_level *level, pdi_smoother_job job,
                                         int colour);
/* Gauss-Seidel forth and back along every line, ascending or descending. */
PDI_FN PDI_ONCE void pdi_smoother_lines(pdi_par_team team, const pd_smoother_level *level, int descending);
#endif

#endif
