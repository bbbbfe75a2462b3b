/* traverse: the ways over the fluid nodes and over their bonds.
 *
 * Sweeps go along axis 0, over runs of nodes with whole families and over runs of rows. What a sweep computes is a
 * function of a piece of nodes; the way there is written here once.
 */
#ifndef PD_TRAVERSE_H
#define PD_TRAVERSE_H
#include "lattice/boundary.h"

#ifdef PDI_INTERNAL
/* Nodes along axis 0 that a sweep works on at once, bond by bond: the inner loops are plain vectors. */
#define PDI_PIECE 64
/* Lanes of the next piece, up to `most`, from *at, of `length` consecutive nodes. What is left over behind the last
 * whole vector goes together with nodes that are done already: they get the same bits again. */
static inline int pdi_traverse_piece(int32_t length, int most, int32_t *at)
{
    int32_t left = length - *at;
    if (left >= most) return most;
    if (left % PDI_VECTOR == 0 || length < PDI_VECTOR) return (int)left;
    if (left > PDI_VECTOR) return (int)(left - left % PDI_VECTOR);
    *at = length - PDI_VECTOR;
    return PDI_VECTOR;
}
/* Nodes whose sums stay in registers while their bonds pass by. */
#define PDI_BLOCK 16
/* Inner loops are compiled for whole blocks, for single nodes beside inlets and outlets (place >= 0), and for all else.
 * Where a program is to be small, that one does for all. */
#ifdef PDI_SMALL
#define PDI_WHOLE(count) 0
#define PDI_SINGLE(place) 0
#else
#define PDI_WHOLE(count) ((count) == PDI_BLOCK)
#define PDI_SINGLE(place) ((place) >= 0)
#endif
/* The next block from *at of `length` nodes: all of them where they are fewer. The last one goes together with nodes
 * that are done already. */
static inline int pdi_traverse_block(int32_t length, int32_t *at)
{
    if (length < PDI_BLOCK) return (int)length;
    if (*at > length - PDI_BLOCK) *at = length - PDI_BLOCK;
    return PDI_BLOCK;
}
/* `length` consecutive nodes from i: the rows from `row`, or nodes with whole families (-1). */
typedef void (*pdi_traverse_fn)(const void *user, int32_t i, int32_t row, int32_t length);
/* All fluid nodes, in pieces of up to `most` nodes (0: whole runs); `work`: scalar operations in all, to decide on
 * threads. Rows at inlets come one by one. run writes to its own nodes only. */
PDI_FN void pdi_traverse_sweep(const pd_ctx *ctx, const pd_bonds *bonds, int64_t work, int most, pdi_traverse_fn run,
                               const void *user);
/* A piece of up to PDI_BLOCK nodes from i: rows from `row`, or whole families (-1). place < 0: no inlet or outlet is in
 * reach of them. Else one node beside them, at this place of the list. */
typedef void (*pdi_traverse_block_fn)(const void *user, int32_t i, int32_t row, int32_t place, int count);
/* All fluid nodes, in blocks away from inlets and outlets and one by one beside them. block writes to its own nodes
 * only. `work` as above. */
PDI_FN void pdi_traverse_blocks(const pd_ctx *ctx, const pd_boundary *boundary, int64_t work,
                                pdi_traverse_block_fn block, const void *user);
/* A flux through the open bond k of node i, counted towards its far end. */
typedef double (*pdi_traverse_flux_fn)(const void *user, int32_t i, int k);
/* Sum of the fluxes of all bonds that cross the plane between the cells index - 1 and index of `axis`. One end of each
 * is fluid, and each pair of nodes counts once. */
PDI_FN double pdi_traverse_section(const pd_bonds *bonds, int axis, int index, pdi_traverse_flux_fn flux,
                                   const void *user);
#endif

#endif
