/* coarsen: builds the next coarser level of a multigrid hierarchy by aggregation of cells.
 *
 * Cells that are connected within a block of two cells along each halved axis become one coarse cell. Conductances of
 * faces between the same two coarse cells are summed and reduced by the growth of the distance of their centres; flows
 * are summed and upwinded again. A link is the pair of coefficients that couples two neighbouring cells.
 */
#ifndef PD_COARSEN_H
#define PD_COARSEN_H
#include "solve/smoother.h"

#ifdef PDI_INTERNAL
/* Options of the coarsening, and its work array. */
typedef struct pdi_coarsen_options {
    int symmetric, contrast; /* as in pd_multigrid_desc */
    int keep_all;            /* 1: no cell is excluded, to allocate for all later setups */
    int32_t *mark;           /* [cells of level 0 + 3] work array: counts and marks */
    int32_t fine_lines;      /* lines of cells along axis 0 of level 0 */
} pdi_coarsen_options;

/* A link of a cell, the same on all levels; only setups use it. */
typedef struct pdi_coarsen_link {
    int32_t cell;  /* the neighbour */
    /* coefficient of the neighbour in the row of this cell; of this cell in the row of the neighbour */
    float a, reverse;
    int axis, upper; /* direction; 1: upwards along the axis */
} pdi_coarsen_link;

/* 1: *link is link k of cell c. 0: both coefficients are zero (closed face), or there is no neighbour; *link has no
 * meaning. k: on level 0 2 axis + (1: upper), on coarser levels an index into col; use PDI_COARSEN_FOR_LINKS. */
static inline int pdi_coarsen_get_link(const pd_smoother_level *level, int32_t c, int32_t k, pdi_coarsen_link *link)
{
    if (level->row) {
        link->cell = level->col[k];
        link->a = level->a[k];
        link->reverse = level->reverse[k];
        link->axis = level->face[k] >> 1;
        link->upper = level->face[k] & 1;
        return 1;
    }
    link->axis = k >> 1;
    link->upper = k & 1;
    int32_t stride = pdi_smoother_stride(level->n, link->axis);
    if (level->has_periodic_neighbour && level->has_periodic_neighbour[c]) {
        link->cell = pdi_smoother_find_neighbour(level, stride, link->axis, link->upper, c);
        if (link->cell < 0) return 0;
        link->a = pdi_smoother_get_coefficient(level, link->axis, link->upper, c, link->cell);
        link->reverse = pdi_smoother_get_coefficient(level, link->axis, !link->upper, link->cell, c);
        return link->a + link->reverse > 0.0f;
    }
    link->cell = link->upper ? c + stride : c - stride;
    link->a = link->upper ? level->hi[link->axis][c] : level->lo[link->axis][c];
    link->reverse = link->upper ? level->lo[link->axis][c + stride] : level->hi[link->axis][c - stride];
    return link->a + link->reverse > 0.0f;
}

/* Loop over the open links of cell c. */
#define PDI_COARSEN_FOR_LINKS(level, c, k, link) \
    for (int32_t k = (level)->row ? (level)->row[c] : 0; k < ((level)->row ? (level)->row[(c) + 1] : 2 * PD_DIM); k++) \
        if (pdi_coarsen_get_link((level), (c), k, &(link)))

/* Floats per cell for b, r, inverse_diagonal and, with contrast, row_sum. */
static inline size_t pdi_coarsen_floats_per_cell(int contrast) { return contrast ? 4 : 3; }
/* 1: an axis of n blocks stays periodic when it is on the finer level (above = 1). 0: it is not, or n is too small, or
 * it is odd with red-black sweeps (symmetric = 1), where both ends would have the same colour. */
static inline int pdi_coarsen_is_periodic(int symmetric, int n, int above)
{
    return above && n > 2 && !(symmetric && n % 2);
}
/* Choose the axes to halve into level->halve (semi-coarsening): those whose mean link coefficient is at least a quarter
 * of that of the strongest axis. Mark in parent the cells that take part in the next level: -2, else -1. 1: an axis is
 * halved; 0: no link is left, the level is the coarsest. Without keep_all it relaxes a uniform error first: r gets what
 * is left of it, and options->mark is overwritten. */
PDI_FN int pdi_coarsen_choose_axes(const pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *level);
/* Build the next level after pdi_coarsen_choose_axes, and set parent of `level` to its cells (-1: none). During setup x
 * holds the Dirichlet coefficients and b the masses of the cells, on both levels. Overwrites options->mark. Allocates
 * only where the memory of `coarse` is too small; an error of that leaves `coarse` incomplete. */
PDI_FN pd_status pdi_coarsen_build_level(pd_ctx *ctx, const pdi_coarsen_options *options, pd_smoother_level *level,
                                         pd_smoother_level *coarse);
/* Compute inverse_diagonal (0 where the diagonal is), row_sum, b (summed masses) and x (Dirichlet coefficients, summed
 * and rescaled to the wider cells) of the coarse level from those of `level`, and set its r to 0. The diagonal of a
 * cell with mass or wall but no links is at least 1e-6 (with contrast 1e-10) of the sum of those of its cells. Once
 * masses or walls of `level` have changed, only with options->symmetric: else r and x hold sums of the excluded
 * neighbours, which exist once after the links are assembled. */
PDI_FN void pdi_coarsen_compute_diagonals(const pdi_coarsen_options *options, const pd_smoother_level *level,
                                          pd_smoother_level *coarse);
/* Free the arrays of a coarse level and set its capacities to 0; other members stay. */
PDI_FN void pdi_coarsen_free(pd_ctx *ctx, pd_smoother_level *coarse);
#endif

#endif
