/* node_loop: see node_loop.h */
#include "lattice/node_loop.h"
#include "core/par.h"

/* Calls `run` for a range of nodes in pieces of up to `max` nodes (0: as a whole). */
static void pdi_node_loop_run_chunks(int32_t i, int32_t row, int32_t length, int max, pdi_node_loop_range_fn run,
                                     const void *user)
{
    int32_t count;
    for (int32_t at = 0; at < length; at += count) {
        count = max ? pdi_node_loop_next_chunk(length, max, &at) : length;
        run(user, i + at, row < 0 ? row : row + at, count);
    }
}

/* Body of one thread (all nodes when called outside of a parallel region): ranges with full families, ranges of plain
 * rows, rows at inlets. */
static void pdi_node_loop_run_thread(const pd_bonds *bonds, int max, pdi_node_loop_range_fn run, const void *user)
{
    PDI_FOR_NOWAIT
    for (int32_t s = 0; s < bonds->full_ranges.count; s++)
        pdi_node_loop_run_chunks(bonds->full_ranges.first[s], -1, bonds->full_ranges.length[s], max, run, user);
    PDI_FOR_NOWAIT
    for (int32_t s = 0; s < bonds->truncated_ranges.count; s++)
        pdi_node_loop_run_chunks(bonds->truncated_ranges.first[s], bonds->row_of_node[bonds->truncated_ranges.first[s]],
                                 bonds->truncated_ranges.length[s], max, run, user);
    PDI_FOR_NOWAIT
    for (int32_t r = bonds->rows_without_inlet; r < bonds->rows; r++) run(user, bonds->node[r], r, 1);
}

/* Operands of a loop by blocks. */
typedef struct pdi_node_loop_work {
    const pd_bonds *bonds;
    pdi_node_loop_block_fn block;
    const void *user;
} pdi_node_loop_work;

/* Calls the body for those parts of a range that are not near inlets and outlets, block by block, with place -1; nodes
 * near them are left out. The last block of a part may repeat nodes. */
static void pdi_node_loop_run_blocks(const void *user, int32_t i, int32_t row, int32_t length)
{
    const pdi_node_loop_work *w = (const pdi_node_loop_work *)user;
    int32_t part;
    int near_port, count;
    for (int32_t begin = 0; begin < length; begin += part) {
        part = pdi_open_boundary_find_segment(w->bonds, i + begin, length - begin, &near_port);
        for (int32_t at = 0; at < part && !near_port; at += count) {
            count = pdi_node_loop_next_block(part, &at);
            w->block(w->user, i + begin + at, row < 0 ? row : row + begin + at, -1, count);
        }
    }
}

/* Body of one thread: calls the loop body for each node near inlets and outlets. */
static void pdi_node_loop_run_open_boundary(const pd_open_boundary *boundary, pdi_node_loop_block_fn block,
                                            const void *user)
{
    PDI_FOR_NOWAIT
    for (int32_t p = 0; p < boundary->count; p++)
        block(user, boundary->node[p], boundary->bonds->row_of_node[boundary->node[p]], p, 1);
}

/* Body of one thread: all fluid nodes, first those away from inlets and outlets, then those near them. */
static void pdi_node_loop_run_thread_blocks(const pd_open_boundary *boundary, const pdi_node_loop_work *w)
{
    pdi_node_loop_run_thread(boundary->bonds, 0, pdi_node_loop_run_blocks, w);
    pdi_node_loop_run_open_boundary(boundary, w->block, w->user);
}

PDI_FN void pdi_node_loop_by_ranges(const pd_ctx *ctx, const pd_bonds *bonds, int64_t work, int max,
                                    pdi_node_loop_range_fn run, const void *user)
{
    pdi_par_timing timing;
    int nt = pdi_par_begin_timing(ctx, work, 1, (uint64_t)(uintptr_t)run, &timing);
    PDI_PARALLEL_CALL(nt, pdi_node_loop_run_thread(bonds, max, run, user));
    pdi_par_end_timing(ctx, &timing);
}

PDI_FN void pdi_node_loop_by_blocks(const pd_ctx *ctx, const pd_open_boundary *boundary, int64_t work,
                                    pdi_node_loop_block_fn block, const void *user)
{
    const pd_bonds *bonds = boundary->bonds;
    pdi_node_loop_work w;
    pdi_par_timing timing;
    int nt = pdi_par_begin_timing(ctx, work, 1, (uint64_t)(uintptr_t)block, &timing);
    w.bonds = bonds;
    w.block = block;
    w.user = user;
    PDI_PARALLEL_CALL(nt, pdi_node_loop_run_thread_blocks(boundary, &w));
    pdi_par_end_timing(ctx, &timing);
}

PDI_COLD_BEGIN
/* Adds to *sum the fluxes, times the circumference of `node`, of the open bonds that start at `node`, of index i[], and
 * end at or behind index `index`. Left out: bonds of which no end is fluid, that leave the arrays, that cross a closed
 * group of cells, or that end in an inlet or outlet beside the box (not behind the upper side of `axis`). */
static void pdi_node_loop_add_plane_fluxes(const pd_bonds *bonds, int32_t node, const int *i, int axis, int index,
                                           pdi_node_loop_flux_fn flux, const void *user, pdi_compensated_sum *sum)
{
    const pd_stencil *s = bonds->stencil;
    const pd_grid *grid = bonds->grid;
    for (int k = 0; k < s->count; k++) {
        if (i[axis] + s->offset[k * PD_DIM + axis] < index) continue;
        /* bonds that would leave the arrays start behind a side ghost */
        int inside = 1;
        for (int d = 0; d < PD_DIM; d++) {
            int far = i[d] + s->offset[k * PD_DIM + d];
            inside = inside && far >= -grid->ghost && far < grid->n[d] + grid->ghost;
        }
        if (!inside) continue;
        uint8_t far_kind = grid->kind[node + bonds->paths.shift[k]];
        if (grid->kind[node] != PD_FLUID && far_kind != PD_FLUID) continue;
        int port = far_kind == PD_INLET || far_kind == PD_OUTLET;
        if (port && i[axis] + s->offset[k * PD_DIM + axis] < grid->n[axis]) continue; /* passes a side beside */
        if (!pdi_grid_is_open(far_kind) || pdi_bond_path_find_closed_group(&bonds->paths, node, k) >= 0) continue;
        pdi_compensated_sum_add(sum, flux(user, node, k) * pd_grid_circumference(grid, node));
    }
}

PDI_FN double pdi_node_loop_sum_plane_flux(const pd_bonds *bonds, int axis, int index, pdi_node_loop_flux_fn flux,
                                           const void *user)
{
    const pd_grid *grid = bonds->grid;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM], along = pdi_grid_is_open(grid->kind[node]) ? pdi_grid_index_along(grid, node, axis) : index;
        if (along >= index || along < index - bonds->stencil->reach) continue;
        pd_grid_index(grid, node, i);
        /* ghosts count before the box, not beside it: ports there belong to no plane, and an image repeats a bond of
         * the box */
        if (grid->kind[node] != PD_FLUID && i[axis] >= 0) continue;
        pdi_node_loop_add_plane_fluxes(bonds, node, i, axis, index, flux, user, &sum);
    }
    return pdi_compensated_sum_total(&sum);
}
PDI_COLD_END
