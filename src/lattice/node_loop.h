/* node_loop: parallel loops over all fluid nodes in ranges along axis 0, and sums of bond fluxes through a plane.
 *
 * Loops go over ranges of nodes with full families and over ranges of rows (nodes with truncated families). The body of
 * a loop is a callback for a range of nodes.
 */
#ifndef PD_NODE_LOOP_H
#define PD_NODE_LOOP_H
#include "lattice/open_boundary.h"

#ifdef PDI_INTERNAL
/* Largest number of nodes along axis 0 in one piece of work: inner loops over it, bond by bond, are vector loops. */
#define PDI_CHUNK 64
/* Length of the next piece, at most `max`, from *at, of a range of `length` nodes. A remainder shorter than a vector is
 * extended backwards (*at decreases) over nodes that are done already; they get the same bits again. */
static inline int pdi_node_loop_next_chunk(int32_t length, int max, int32_t *at)
{
    int32_t left = length - *at;
    if (left >= max) return max;
    if (left % PDI_VECTOR_LENGTH == 0 || length < PDI_VECTOR_LENGTH) return (int)left;
    if (left > PDI_VECTOR_LENGTH) return (int)(left - left % PDI_VECTOR_LENGTH);
    *at = length - PDI_VECTOR_LENGTH;
    return PDI_VECTOR_LENGTH;
}
/* Nodes in a block: their sums stay in registers during a loop over bonds. */
#define PDI_BLOCK 16
/* Inner loops are compiled separately for full blocks, for single nodes near inlets and outlets (place >= 0), and for
 * other lengths. With PDI_OPTIMISE_SIZE (small programs) the last one serves all. */
#ifdef PDI_OPTIMISE_SIZE
#define PDI_FULL_BLOCK(count) 0
#define PDI_SINGLE_NODE(place) 0
#else
#define PDI_FULL_BLOCK(count) ((count) == PDI_BLOCK)
#define PDI_SINGLE_NODE(place) ((place) >= 0)
#endif
/* Length of the next block from *at of a range of `length` nodes: PDI_BLOCK, or all of a shorter range. The last
 * block is extended backwards over nodes that are done already. */
static inline int pdi_node_loop_next_block(int32_t length, int32_t *at)
{
    if (length < PDI_BLOCK) return (int)length;
    if (*at > length - PDI_BLOCK) *at = length - PDI_BLOCK;
    return PDI_BLOCK;
}
/* Body of a loop: `length` consecutive nodes from i, which own the rows from `row` on, or have full families (row
 * -1). */
typedef void (*pdi_node_loop_range_fn)(const void *user, int32_t i, int32_t row, int32_t length);
/* Loop over all fluid nodes in parallel, in pieces of up to `max` nodes (0: ranges as they are). work: number of scalar
 * operations, to decide on threads. Rows at inlets come one by one. `run` writes to its own nodes only; with `max` it
 * may get some nodes twice. */
PDI_FN void pdi_node_loop_by_ranges(const pd_ctx *ctx, const pd_bonds *bonds, int64_t work, int max,
                                    pdi_node_loop_range_fn run, const void *user);
/* Body of a loop by blocks: up to PDI_BLOCK nodes from i, which own the rows from `row` on, or have full families (row
 * -1). place < 0: no inlet or outlet within reach; else one node near them, entry `place` of pd_open_boundary. */
typedef void (*pdi_node_loop_block_fn)(const void *user, int32_t i, int32_t row, int32_t place, int count);
/* Loop over all fluid nodes in parallel, in blocks, and one by one near inlets and outlets. `block` writes to its own
 * nodes only, and may get some nodes twice. `boundary` is up to date with its bonds. work: number of scalar operations,
 * to decide on threads. */
PDI_FN void pdi_node_loop_by_blocks(const pd_ctx *ctx, const pd_open_boundary *boundary, int64_t work,
                                    pdi_node_loop_block_fn block, const void *user);
/* Flux through the open bond k of node i, positive towards its far end. */
typedef double (*pdi_node_loop_flux_fn)(const void *user, int32_t i, int k);
/* Sum of the fluxes of all open bonds that cross the plane between the cells index - 1 and index of `axis`, times the
 * circumference [m] of their start on an axisymmetric grid; positive along the axis. At least one end of each is fluid,
 * and each pair of nodes counts once: `flux` is called with the end before the plane, which may be a ghost. */
PDI_FN double pdi_node_loop_sum_plane_flux(const pd_bonds *bonds, int axis, int index, pdi_node_loop_flux_fn flux,
                                           const void *user);
#endif

#endif
