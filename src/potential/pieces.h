/* pieces: metal that hangs together: each piece has one potential, each metal of a piece is an electrode.
 *
 * Solid nodes that share a face conduct to each other, also through periodic sides. So metals in contact form a
 * galvanic couple, and particles that do not touch are circuits of their own.
 */
#ifndef PD_PIECES_H
#define PD_PIECES_H
#include "potential/contact.h"

typedef struct pd_pieces {
    int electrodes, circuits;
    int material[PD_ELECTRODES]; /* [electrodes] */
    int member[PD_ELECTRODES];   /* [electrodes] piece of each of them, a circuit: as pd_potential_desc wants it */
} pd_pieces;

#define pd_pieces_find PD_NAME(pd_pieces_find)

/* material [total]: index of the metal of solid nodes; NULL: 0. electrode [total]: for solid nodes, out. Pieces, and
 * the electrodes of a piece, are in the order of their first nodes. PD_ERR_SIZE: more than PD_ELECTRODES of them. */
PD_API pd_status pd_pieces_find(pd_ctx *ctx, const pd_grid *grid, const uint8_t *material, uint8_t *electrode,
                                pd_pieces *pieces);

#endif
