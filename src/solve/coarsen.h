/* coarsen: the next coarser level of a multigrid hierarchy.
 *
 * Cells that are linked within a block of two cells along each halved axis become one. Conductances of faces between
 * the same two are summed and reduced as the distance of the centres grows; flows are summed and taken upwind anew.
 */
#ifndef PD_COARSEN_H
#define PD_COARSEN_H
#include "solve/smoother.h"

#ifdef PDI_INTERNAL
typedef struct pdi_coarsen {
    int symmetric, contrast; /* as in pd_multigrid_desc */
    int all;                 /* 1: no cell is left out: for the room that a setup may need one day */
    int32_t *mark;           /* [cells of level 0 + 3] counts and marks */
    int32_t lines;           /* along axis 0 of level 0 */
} pdi_coarsen;

/* The same view of the links of all levels; only setups use it. */
typedef struct pdi_coarsen_link {
    int32_t cell;  /* the neighbour */
    float a, back; /* coefficient of the neighbour here, of this cell there */
    int axis, upper;
} pdi_coarsen_link;

/* Link k of cell c; 0: closed. */
static inline int pdi_coarsen_link_get(const pd_smoother_level *level, int32_t c, int32_t k, pdi_coarsen_link *link)
{
    if (level->row) {
        link->cell = level->col[k];
        link->a = level->a[k];
        link->back = level->back[k];
        link->axis = level->face[k] >> 1;
        link->upper = level->face[k] & 1;
        return 1;
    }
    link->axis = k >> 1;
    link->upper = k & 1;
    int32_t stride = pdi_smoother_stride(level->n, link->axis);
    if (level->edge && level->edge[c]) {
        link->cell = pdi_smoother_across(level, stride, link->axis, link->upper, c);
        if (link->cell < 0) return 0;
        link->a = pdi_smoother_edge_coefficient(level, link->axis, link->upper, c, link->cell);
        link->back = pdi_smoother_edge_coefficient(level, link->axis, !link->upper, link->cell, c);
        return link->a + link->back > 0.0f;
    }
    link->cell = link->upper ? c + stride : c - stride;
    link->a = link->upper ? level->hi[link->axis][c] : level->lo[link->axis][c];
    link->back = link->upper ? level->lo[link->axis][c + stride] : level->hi[link->axis][c - stride];
    return link->a + link->back > 0.0f;
}

/* Loop over the open links of cell c. */
#define PDI_COARSEN_LINKS(level, c, k, link) \
    for (int32_t k = (level)->row ? (level)->row[c] : 0; k < ((level)->row ? (level)->row[(c) + 1] : 2 * PD_DIM); k++) \
        if (pdi_coarsen_link_get((level), (c), k, &(link)))

/* Floats of a cell beside x and the coefficients of level 0: b, r, inv, excess. */
static inline size_t pdi_coarsen_values(int contrast) { return contrast ? 4 : 3; }
/* 1: the ends of an axis of n blocks are linked, when its ends on the level above are. Red-black sweeps need an even
 * number, else both ends have one colour. */
static inline int pdi_coarsen_wraps(int symmetric, int n, int above)
{
    return above && n > 2 && !(symmetric && n % 2);
}
/* Choose the axes of a level to halve, and mark in parent which cells take part in the next one; 0: none does. */
PDI_FN int pdi_coarsen_choose(const pd_ctx *ctx, const pdi_coarsen *how, pd_smoother_level *level);
/* The level below one whose axes are chosen. During setup x holds the wall and b the mass of each cell of a level. */
PDI_FN pd_status pdi_coarsen_level(pd_ctx *ctx, const pdi_coarsen *how, pd_smoother_level *level,
                                   pd_smoother_level *coarse);
/* Only its diagonals, after those of `level` have changed: symmetric. */
PDI_FN void pdi_coarsen_diagonal(const pdi_coarsen *how, const pd_smoother_level *level, pd_smoother_level *coarse);
PDI_FN void pdi_coarsen_free(pd_ctx *ctx, pd_smoother_level *coarse);
#endif

#endif
