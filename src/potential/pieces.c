/* pieces: see pieces.h */
#include "potential/pieces.h"
#include <string.h>

/* A walk over one piece after the other. */
typedef struct pdi_pieces_walk {
    const pd_grid *grid;
    int32_t *piece; /* [total] of solid nodes; -1: not yet */
    int32_t *queue; /* [total] */
} pdi_pieces_walk;

/* All metal that hangs together with node i. */
static void pdi_pieces_fill(const pdi_pieces_walk *w, int32_t i, int32_t piece)
{
    int32_t count = 1;
    w->queue[0] = i;
    w->piece[i] = piece;
    for (int32_t n = 0; n < count; n++)
        for (int side = 0; side < 2 * PD_DIM; side++) {
            int32_t step = w->grid->stride[side / 2];
            int32_t at = pd_grid_find_source(w->grid, w->queue[n] + (side % 2 ? step : -step), NULL);
            if (w->grid->kind[at] != PD_SOLID || w->piece[at] >= 0) continue;
            w->piece[at] = piece;
            w->queue[count++] = at;
        }
}

/* The electrode of a material of a piece; -1: there are too many. */
static int pdi_pieces_electrode(pd_pieces *p, int piece, int material)
{
    for (int e = 0; e < p->electrodes; e++)
        if (p->member[e] == piece && p->material[e] == material) return e;
    if (p->electrodes == PD_ELECTRODES) return -1;
    p->member[p->electrodes] = piece;
    p->material[p->electrodes] = material;
    return p->electrodes++;
}

static pd_status pdi_pieces_walk_all(pd_ctx *ctx, const pdi_pieces_walk *w, const uint8_t *material, uint8_t *electrode,
                                     pd_pieces *p)
{
    const pd_grid *grid = w->grid;
    for (int32_t i = 0; i < grid->total; i++) w->piece[i] = -1;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_SOLID || pd_grid_find_source(grid, i, NULL) != i) continue;
        if (w->piece[i] < 0) pdi_pieces_fill(w, i, p->circuits++);
        int e = pdi_pieces_electrode(p, w->piece[i], material ? material[i] : 0);
        if (e < 0)
            return pd_fail(ctx, PD_ERR_SIZE, "pieces", "the metals of all pieces are more than %d electrodes",
                           PD_ELECTRODES);
        electrode[i] = (uint8_t)e;
    }
    return PD_OK;
}

pd_status pd_pieces_find(pd_ctx *ctx, const pd_grid *grid, const uint8_t *material, uint8_t *electrode,
                         pd_pieces *pieces)
{
    pdi_pieces_walk w;
    memset(pieces, 0, sizeof *pieces);
    w.grid = grid;
    w.piece = w.queue = NULL;
    PD_TRY(PD_NEW(ctx, "pieces", grid->total, w.piece));
    pd_status status = PD_NEW(ctx, "pieces", grid->total, w.queue);
    if (status >= 0) status = pdi_pieces_walk_all(ctx, &w, material, electrode, pieces);
    PD_DELETE(ctx, grid->total, w.queue);
    PD_DELETE(ctx, grid->total, w.piece);
    return status;
}
