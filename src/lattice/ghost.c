/* ghost: see ghost.h */
#include "lattice/ghost.h"
#include "core/array_registry.h"
#include <string.h>

/* Describes the arrays of the list to the array registry. */
static void pdi_ghost_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_ghosts *ghosts = (pd_ghosts *)object;
    PDI_ARRAY(owner, ghosts, node, ghosts->capacity, "1");
    PDI_ARRAY(owner, ghosts, source, ghosts->capacity, "1");
    PDI_ARRAY(owner, ghosts, sign_flips, ghosts->capacity, "1");
    PDI_ARRAY(owner, ghosts, normal_axis, ghosts->capacity, "1");
}

/* Overwrites *g and lists the ghosts of the grid, which is borrowed; on failure the caller frees what *g holds. */
static pd_status pdi_ghost_build_inner(pd_ctx *ctx, const pd_grid *grid, pd_ghosts *g)
{
    memset(g, 0, sizeof *g);
    g->grid = grid;
    return pdi_ghosts_update(ctx, g);
}

PDI_FN pd_status pdi_ghosts_build(pd_ctx *ctx, const pd_grid *grid, pd_ghosts *g)
{
    pd_status status = pdi_ghost_build_inner(ctx, grid, g);
    if (status < 0) pdi_ghosts_free(ctx, g);
    return status;
}

/* Bit 1 << d of the axis normal to the inlet or outlet behind which a ghost lies, once images are folded into the box;
 * 0: an image, or a node of the box. */
static int pdi_ghost_find_normal_axis(const pd_grid *grid, int32_t node)
{
    int i[PD_DIM], across = 0;
    pd_grid_index(grid, node, i);
    pdi_grid_fold_index(grid, i);
    for (int d = 0; d < PD_DIM; d++)
        if (i[d] < 0 || i[d] >= grid->n[d]) across |= 1 << d;
    return across;
}

/* Appends a ghost with its source, signs and normal axis at inlets_end, which grows by one; the list has room. Signs
 * that change: images the mirrored components; outlets these and all components but the normal one; inlets every
 * mirrored axis, that of the side included. */
static void pdi_ghost_add(pd_ghosts *g, int32_t node)
{
    const pd_grid *grid = g->grid;
    int i[PD_DIM], odd, flip;
    pd_grid_index(grid, node, i);
    odd = pdi_grid_fold_index(grid, i);
    g->source[g->inlets_end] = pd_grid_find_source(grid, node, &flip);
    g->normal_axis[g->inlets_end] = (uint8_t)pdi_ghost_find_normal_axis(grid, node);
    /* all components but the normal one change their sign behind an outlet */
    if (grid->kind[node] == PD_OUTLET) odd ^= ((1 << PD_DIM) - 1) & ~g->normal_axis[g->inlets_end];
    if (grid->kind[node] == PD_INLET) odd = flip;
    g->node[g->inlets_end] = node;
    g->sign_flips[g->inlets_end++] = (uint8_t)odd;
}

PDI_FN pd_status pdi_ghosts_update(pd_ctx *ctx, pd_ghosts *g)
{
    const pd_grid *grid = g->grid;
    static const uint8_t kinds[3] = {PD_IMAGE, PD_OUTLET, PD_INLET};
    int32_t *end[3], count = 0;
    end[0] = &g->images_end;
    end[1] = &g->outlets_end;
    end[2] = &g->inlets_end;
    for (int32_t node = 0; node < grid->total; node++) count += grid->kind[node] >= PD_INLET;
    g->inlets_end = g->outlets_end = g->images_end = 0;
    if (count > g->capacity) PD_TRY(pdi_array_registry_rebuild(ctx, pdi_ghost_list_arrays, g, &g->capacity, count));
    for (int k = 0; k < 3; k++) {
        for (int32_t node = 0; node < grid->total; node++)
            if (grid->kind[node] == kinds[k]) pdi_ghost_add(g, node);
        *end[k] = g->inlets_end;
    }
    return PD_OK;
}

void pd_ghosts_set_scalar(const pd_ghosts *g, double *f)
{
    for (int32_t k = 0; k < g->images_end; k++) f[g->node[k]] = f[g->source[k]];
}

void pd_ghosts_set_vector(const pd_ghosts *g, double *v)
{
    int64_t total = g->grid->total;
    for (int d = 0; d < PD_DIM; d++)
        for (int32_t k = 0; k < g->outlets_end; k++) {
            double value = v[d * total + g->source[k]];
            v[d * total + g->node[k]] = g->sign_flips[k] >> d & 1 ? -value : value;
        }
}

PDI_FN void pdi_ghosts_set_inlet_velocity(const pd_ghosts *g, const double *held, double *v)
{
    int32_t inlets = g->inlets_end - g->outlets_end;
    for (int d = 0; d < PD_DIM; d++)
        for (int32_t k = 0; k < inlets; k++) {
            int32_t at = g->outlets_end + k, source = g->source[at];
            double *value = &v[(int64_t)d * g->grid->total + g->node[at]], side = held ? held[d * inlets + k] : 0.0;
            double inside = v[(int64_t)d * g->grid->total + source];
            *value = side;
            if (g->grid->kind[source] != PD_FLUID) continue;
            *value += side + ((g->sign_flips[at] ^ g->normal_axis[at]) >> d & 1 ? inside : -inside);
        }
}

PDI_FN void pdi_ghosts_set_pressure(const pd_ghosts *g, double held, double *p)
{
    pd_ghosts_set_scalar(g, p);
    for (int32_t k = g->images_end; k < g->outlets_end; k++) p[g->node[k]] = 2.0 * held - p[g->source[k]];
}

PDI_FN void pdi_ghosts_set_potential(const pd_ghosts *g, double *q)
{
    pd_ghosts_set_scalar(g, q);
    for (int32_t k = g->outlets_end; k < g->inlets_end && g->outlets_end > g->images_end; k++)
        q[g->node[k]] = g->grid->kind[g->source[k]] == PD_FLUID ? q[g->source[k]] : 0.0;
}

PDI_FN void pdi_ghosts_set_zero(const pd_ghosts *g, int components, double *x)
{
    int64_t total = g->grid->total;
    for (int d = 0; d < components; d++)
        for (int32_t k = 0; k < g->inlets_end; k++) x[d * total + g->node[k]] = 0.0;
}

PDI_FN void pdi_ghosts_free(pd_ctx *ctx, pd_ghosts *g)
{
    pdi_array_registry_free(ctx, pdi_ghost_list_arrays, g);
    memset(g, 0, sizeof *g);
}
