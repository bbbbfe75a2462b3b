/* phase: see phase.h */
#include "metal/phase.h"
#include <string.h>

PDI_FN int32_t pdi_phase_pieces(const pd_phases *p)
{
    const pd_grid *grid = p->grid;
    int32_t rows = 1;
    for (int d = 1; d < PD_DIM; d++) rows *= (int32_t)grid->n[d];
    return rows * (int32_t)((grid->n[0] + PDI_PHASE_PIECE - 1) / PDI_PHASE_PIECE);
}

PDI_FN int32_t pdi_phase_place(const pd_phases *p, int32_t piece, int *count)
{
    const pd_grid *grid = p->grid;
    int32_t per_row = (int32_t)((grid->n[0] + PDI_PHASE_PIECE - 1) / PDI_PHASE_PIECE), row = piece / per_row;
    int i[PD_DIM];
    i[0] = (int)(piece % per_row) * PDI_PHASE_PIECE;
    for (int d = 1; d < PD_DIM; d++) {
        i[d] = (int)(row % grid->n[d]);
        row /= (int32_t)grid->n[d];
    }
    *count = grid->n[0] - i[0] < PDI_PHASE_PIECE ? grid->n[0] - i[0] : PDI_PHASE_PIECE;
    return pd_grid_node(grid, i);
}

/* Eight of them at a time. */
PDI_FN int32_t pdi_phase_same(const pd_phases *p, int32_t i, int32_t end)
{
    uint8_t eight[8];
    int32_t next = i + 1;
    memset(eight, p->role[i], sizeof eight);
    while (next + 8 <= end && memcmp(p->role + next, eight, sizeof eight) == 0) next += 8;
    while (next < end && p->role[next] == p->role[i]) next++;
    return next;
}

PDI_FN int pdi_phase_next(const pd_phases *phases, pdi_phase_walk *walk, int32_t *first, int32_t *end)
{
    while (walk->at == walk->end) {
        int count;
        if (walk->piece == pdi_phase_pieces(phases)) return 0;
        walk->at = pdi_phase_place(phases, walk->piece++, &count);
        walk->end = walk->at + count;
    }
    *first = walk->at;
    *end = walk->at = pdi_phase_same(phases, walk->at, walk->end);
    return 1;
}

PDI_FN int pdi_phase_deep(const pd_phases *p, int32_t node)
{
    int i[PD_DIM], deep = 1;
    pdi_grid_index(p->grid, node, i);
    for (int d = 0; d < PD_DIM; d++) deep &= i[d] >= p->grid->ghost && i[d] < p->grid->n[d] - p->grid->ghost;
    return deep;
}

static uint8_t pdi_phase_role(const pd_phases *p, int32_t i)
{
    uint8_t here = p->phase[i];
    if (here == PDI_PHASE_NONE) return PDI_ROLE_IDLE;
    if (here == PDI_PHASE_SOLID) return p->wet[i] ? PDI_ROLE_EXPOSED : PDI_ROLE_IDLE;
    return p->wet[i] == p->stencil->count ? PDI_ROLE_WHOLE : PDI_ROLE_SHORE;
}

static void pdi_phase_roles(pd_phases *p)
{
    for (int32_t piece = 0; piece < pdi_phase_pieces(p); piece++) {
        int count;
        int32_t first = pdi_phase_place(p, piece, &count);
        for (int32_t i = first; i < first + count; i++) {
            int wet = 0;
            for (int k = 0; k < p->stencil->count; k++) wet += pdi_phase_wet(p->phase[i + p->shift[k]]);
            p->wet[i] = (uint16_t)wet;
            p->role[i] = pdi_phase_role(p, i);
        }
    }
}

/* The phase of a ghost is that of its source. Solid is not continued behind held planes. */
static void pdi_phase_ghosts(pd_phases *p)
{
    for (int32_t g = 0; g < p->ghosts; g++) {
        uint8_t phase = p->phase[p->source[g]];
        if (p->behind[g]) phase = phase == PDI_PHASE_FLUID ? PDI_PHASE_HELD : PDI_PHASE_NONE;
        p->phase[p->ghost[g]] = phase;
    }
}

PDI_FN void pdi_phase_read(pd_phases *p)
{
    for (int32_t i = 0; i < p->grid->total; i++) {
        if (p->grid->kind[i] == PD_SOLID) p->phase[i] = PDI_PHASE_SOLID;
        if (p->grid->kind[i] == PD_FLUID) p->phase[i] = PDI_PHASE_FLUID;
    }
    pdi_phase_ghosts(p);
    pdi_phase_roles(p);
}

/* A node has as many bonds to another and its images as that one has to it and its images. */
PDI_FN void pdi_phase_turn(pd_phases *p, const int32_t *nodes, int32_t count)
{
    int inner = 1;
    for (int32_t n = 0; n < count; n++) {
        p->phase[nodes[n]] = PDI_PHASE_FLUID;
        inner &= pdi_phase_deep(p, nodes[n]);
    }
    if (!inner) pdi_phase_ghosts(p);
    for (int32_t n = 0; n < count; n++) {
        int deep = pdi_phase_deep(p, nodes[n]);
        for (int k = 0; k < p->stencil->count; k++) {
            int32_t near_node = pdi_phase_home(p, deep, nodes[n] + p->shift[k]);
            p->wet[near_node]++;
            p->role[near_node] = pdi_phase_role(p, near_node);
        }
        p->role[nodes[n]] = pdi_phase_role(p, nodes[n]);
    }
}

/* Behind an odd number of held planes. */
static int pdi_phase_is_held(const pd_grid *grid, const int *i)
{
    int held = 0;
    for (int d = 0; d < PD_DIM; d++)
        if (i[d] < 0 || i[d] >= grid->n[d]) held ^= pdi_grid_port(grid->side[2 * d + (i[d] < 0 ? 0 : 1)]);
    return held;
}

/* 1 for nodes of the box within reach of a held side. */
static int pdi_phase_is_border(const pd_grid *grid, const int *i)
{
    int near_side = 0;
    for (int d = 0; d < PD_DIM; d++)
        near_side |= (i[d] < grid->ghost && pdi_grid_port(grid->side[2 * d])) ||
                     (i[d] >= grid->n[d] - grid->ghost && pdi_grid_port(grid->side[2 * d + 1]));
    return near_side;
}

static int32_t pdi_phase_inside(const pd_grid *grid)
{
    int32_t inside = 1;
    for (int d = 0; d < PD_DIM; d++) inside *= (int32_t)grid->n[d];
    return inside;
}

static pd_status pdi_phase_allocate(pd_ctx *ctx, pd_phases *p)
{
    int32_t total = p->grid->total, inside = pdi_phase_inside(p->grid);
    PDI_TRY(PDI_NEW(ctx, "phase", p->stencil->count, p->shift));
    PDI_TRY(PDI_NEW(ctx, "phase", total, p->phase));
    PDI_TRY(PDI_NEW(ctx, "phase", total, p->role));
    PDI_TRY(PDI_NEW(ctx, "phase", total, p->wet));
    PDI_TRY(PDI_NEW(ctx, "phase", total - inside, p->ghost));
    PDI_TRY(PDI_NEW(ctx, "phase", total - inside, p->source));
    PDI_TRY(PDI_NEW(ctx, "phase", total - inside, p->behind));
    return PDI_NEW(ctx, "phase", inside, p->border);
}

PDI_FN pd_status pdi_phase_build(pd_ctx *ctx, const pd_grid *grid, const pd_stencil *stencil, pd_phases *p)
{
    p->grid = grid;
    p->stencil = stencil;
    for (int d = 0; d < PD_DIM; d++)
        if ((pdi_grid_port(grid->side[2 * d]) || pdi_grid_port(grid->side[2 * d + 1])) && grid->n[d] < grid->ghost)
            return pdi_fail(ctx, PD_ERR_GEOMETRY, "corrode",
                            "the box is %d cells long on axis %d, with held sides expected at least a horizon: %d",
                            grid->n[d], d, grid->ghost);
    PDI_TRY(pdi_phase_allocate(ctx, p));
    for (int k = 0; k < stencil->count; k++)
        for (int d = 0; d < PD_DIM; d++) p->shift[k] += (int32_t)stencil->offset[k * PD_DIM + d] * grid->stride[d];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        pdi_grid_index(grid, node, i);
        if (pdi_grid_inside(grid, i)) {
            if (pdi_phase_is_border(grid, i)) p->border[p->borders++] = node;
            continue;
        }
        p->ghost[p->ghosts] = node;
        p->behind[p->ghosts] = (uint8_t)pdi_phase_is_held(grid, i);
        p->source[p->ghosts++] = pdi_grid_image(grid, node, NULL);
    }
    pdi_phase_read(p);
    return PD_OK;
}

PDI_FN void pdi_phase_free(pd_ctx *ctx, pd_phases *p)
{
    int32_t total = p->grid ? p->grid->total : 0, inside = p->grid ? pdi_phase_inside(p->grid) : 0;
    PDI_DELETE(ctx, p->stencil ? p->stencil->count : 0, p->shift);
    PDI_DELETE(ctx, total, p->phase);
    PDI_DELETE(ctx, total, p->role);
    PDI_DELETE(ctx, total, p->wet);
    PDI_DELETE(ctx, total - inside, p->ghost);
    PDI_DELETE(ctx, total - inside, p->source);
    PDI_DELETE(ctx, total - inside, p->behind);
    PDI_DELETE(ctx, inside, p->border);
    memset(p, 0, sizeof *p);
}
