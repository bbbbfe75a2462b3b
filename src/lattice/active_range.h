/* active_range: the range of active nodes (fluid, or metal that may become fluid) on each grid line along axis 0.
 *
 * Solvers that store many vectors (Krylov bases) keep these ranges only, one behind the other: neither ghosts nor the
 * walls around a tube take memory.
 */
#ifndef PD_ACTIVE_RANGE_H
#define PD_ACTIVE_RANGE_H
#include "lattice/grid.h"

typedef struct pd_active_ranges {
    int32_t count, capacity;
    int32_t *first, *packed_start, *length; /* [count] first node, its index in a packed vector, number of nodes */
    int32_t packed_length;                  /* length of a packed vector */
    int32_t total;                   /* nodes of the grid, ghosts included */
} pd_active_ranges;

#ifdef PDI_INTERNAL
/* Allocates and finds the ranges; `spans` is overwritten, not freed. A range goes from the first to the last fluid or
 * solid node of a grid line (solid may dissolve); a line without such nodes has none. */
PDI_FN pd_status pdi_active_range_build(pd_ctx *ctx, const pd_grid *grid, pd_active_ranges *spans);
PDI_FN void pdi_active_range_free(pd_ctx *ctx, pd_active_ranges *spans);
/* Copies the nodes of all ranges from full [components][total] to packed [components][packed_length]. */
PDI_FN void pdi_active_range_pack(const pd_ctx *ctx, const pd_active_ranges *spans, int components, const double *full,
                                  double *packed);
/* Copies packed [components][packed_length] to the nodes of all ranges in full [components][total]. All nodes outside
 * of the ranges, ghosts included, become zero: without any range all nodes. */
PDI_FN void pdi_active_range_unpack(const pd_ctx *ctx, const pd_active_ranges *spans, int components,
                                    const double *packed, double *full);
#endif

#endif
