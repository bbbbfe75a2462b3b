/* coarsen_setup: see coarsen_setup.h */
#include "run/coarsen_setup.h"
#include "physics/model.h"
#include <math.h>
#include <string.h>

#define PDI_COARSEN_SETUP_TOLERANCE 1e-6 /* [cells] tolerance by which a place lies on a lattice plane */
/* Nodes between two checks for cancellation. */
#define PDI_COARSEN_SETUP_POLL 4096

/* Stencil and grid of a setup. */
typedef struct pdi_coarsen_setup_grid {
    pd_stencil stencil;
    pd_grid grid;
} pdi_coarsen_setup_grid;

/* Nodes [low, high) of the box along each axis. */
typedef struct pdi_coarsen_setup_node_block {
    int low[PD_DIM], high[PD_DIM];
} pdi_coarsen_setup_node_block;

/* Advance index i[PD_DIM] within the block, x fastest. 1: there is a next node; 0: at the end, and i is the first one
 * again. */
static int pdi_coarsen_setup_next_node(const pdi_coarsen_setup_node_block *b, int *i)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (++i[d] < b->high[d]) return 1;
        i[d] = b->low[d];
    }
    return 0;
}

/* Block of nodes from `before` below to `after` above i along each axis, within the box. */
static pdi_coarsen_setup_node_block pdi_coarsen_setup_neighbourhood(const pd_grid *grid, const int *i, int before,
                                                                    int after)
{
    pdi_coarsen_setup_node_block b;
    for (int d = 0; d < PD_DIM; d++) {
        b.low[d] = i[d] > before ? i[d] - before : 0;
        b.high[d] = i[d] + after < grid->n[d] ? i[d] + after + 1 : grid->n[d];
    }
    return b;
}

/* Kind of a node (pd_kind); inactive ones, outside of all families of the fluid, count as wall. */
static uint8_t pdi_coarsen_setup_kind(const pd_grid *grid, int32_t node)
{
    return grid->kind[node] == PD_INACTIVE ? (uint8_t)PD_WALL : grid->kind[node];
}

/* 1: the block of `factor` nodes an axis from i on, which may reach out of the box, is of one kind, *kind. Beyond a
 * side the kind continues, except that walls have wall behind. */
static int pdi_coarsen_setup_is_uniform(const pd_grid *grid, const int *i, int factor, uint8_t *kind)
{
    int at[PD_DIM], first[PD_DIM];
    pdi_coarsen_setup_node_block b;
    for (int d = 0; d < PD_DIM; d++) {
        b.low[d] = i[d] < 0 ? 0 : i[d];
        b.high[d] = i[d] + factor < grid->n[d] ? i[d] + factor : grid->n[d];
        at[d] = first[d] = b.low[d];
    }
    *kind = pdi_coarsen_setup_kind(grid, pd_grid_node(grid, first));
    do {
        if (pdi_coarsen_setup_kind(grid, pd_grid_node(grid, at)) != *kind) return 0;
    } while (pdi_coarsen_setup_next_node(&b, at));
    for (int d = 0; d < PD_DIM && *kind != PD_WALL; d++)
        if ((i[d] < 0 && grid->side[2 * d] == PD_SIDE_WALL) ||
            (i[d] + factor > grid->n[d] && grid->side[2 * d + 1] == PD_SIDE_WALL))
            return 0;
    return 1;
}

/* Set wide[total], 0 before, to 1 for the nodes of each block of `factor` nodes an axis that is of one kind and, where
 * it reaches out of the box, is so beyond its side: features that a coarse cell resolves. PD_CANCELLED. */
static pd_status pdi_coarsen_setup_mark_resolved(pd_ctx *ctx, const pd_grid *grid, int factor, uint8_t *wide)
{
    int i[PD_DIM], at[PD_DIM];
    int64_t blocks = 0;
    pdi_coarsen_setup_node_block starts, b;
    for (int d = 0; d < PD_DIM; d++) {
        starts.low[d] = i[d] = 1 - factor;
        starts.high[d] = grid->n[d];
    }
    do {
        uint8_t kind;
        if (blocks++ % PDI_COARSEN_SETUP_POLL == 0) PD_TRY(pd_check_cancel(ctx, "coarser: widths", blocks));
        if (!pdi_coarsen_setup_is_uniform(grid, i, factor, &kind)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            b.low[d] = at[d] = i[d] < 0 ? 0 : i[d];
            b.high[d] = i[d] + factor < grid->n[d] ? i[d] + factor : grid->n[d];
        }
        do wide[pd_grid_node(grid, at)] = 1;
        while (pdi_coarsen_setup_next_node(&b, at));
    } while (pdi_coarsen_setup_next_node(&starts, i));
    return PD_OK;
}

/* 1: the block has a node of this kind that is, where `wide` is given, also wide. */
static int pdi_coarsen_setup_has_node_of_kind(const pd_grid *grid, const pdi_coarsen_setup_node_block *b, uint8_t kind,
                                              const uint8_t *wide)
{
    int at[PD_DIM];
    memcpy(at, b->low, sizeof at);
    do {
        int32_t node = pd_grid_node(grid, at);
        if (pdi_coarsen_setup_kind(grid, node) == kind && (!wide || wide[node])) return 1;
    } while (pdi_coarsen_setup_next_node(b, at));
    return 0;
}

/* Error message: the feature near a node is lost on the coarser lattice. Returns PD_ERR_GEOMETRY. */
static pd_status pdi_coarsen_setup_reject_feature(pd_ctx *ctx, const pdi_coarsen_setup_grid *fine,
                                                  const pdi_coarsen_setup_grid *coarse, int32_t node, const char *what)
{
    static const char *const names[] = {"", "fluid", "solid", "wall"};
    char spacing[PD_UNITS_TEXT], place[PD_UNITS_TEXT];
    double x[PD_DIM];
    int axis = 0;
    pd_grid_position(&fine->grid, node, x);
    for (int d = 1; d < PD_DIM; d++)
        if (coarse->grid.h[d] > coarse->grid.h[axis]) axis = d;
    pd_setup_format_value(coarse->grid.h[axis], "m", spacing);
    pd_setup_format_value(x[0], "m", place);
    return pd_fail(ctx, PD_ERR_GEOMETRY, "coarser",
                   "the lattice at h = %s cannot hold the scene: the %s near x = %s %s", spacing,
                   names[pdi_coarsen_setup_kind(&fine->grid, node)], place, what);
}

/* Check each node of the fine lattice: it, or a node of its kind at most factor - 1 nodes away along each axis, is
 * wide, so that features are one coarse cell wide but for corners; and the coarse cell that holds it, or one beside
 * that, has its kind. PD_ERR_GEOMETRY: the first node that fails. PD_CANCELLED. wide[total of the fine grid]: work,
 * zeroed. */
static pd_status pdi_coarsen_setup_check_features(pd_ctx *ctx, const pdi_coarsen_setup_grid *fine,
                                                  const pdi_coarsen_setup_grid *coarse, int factor, uint8_t *wide)
{
    int i[PD_DIM], at[PD_DIM];
    pdi_coarsen_setup_node_block box;
    PD_TRY(pdi_coarsen_setup_mark_resolved(ctx, &fine->grid, factor, wide));
    for (int d = 0; d < PD_DIM; d++) {
        box.low[d] = i[d] = 0;
        box.high[d] = fine->grid.n[d];
    }
    do {
        int32_t node = pd_grid_node(&fine->grid, i);
        uint8_t kind = pdi_coarsen_setup_kind(&fine->grid, node);
        pdi_coarsen_setup_node_block near_fine =
            pdi_coarsen_setup_neighbourhood(&fine->grid, i, factor - 1, factor - 1);
        if (node % PDI_COARSEN_SETUP_POLL == 0) PD_TRY(pd_check_cancel(ctx, "coarser: parts", node));
        if (!wide[node] && !pdi_coarsen_setup_has_node_of_kind(&fine->grid, &near_fine, kind, wide))
            return pdi_coarsen_setup_reject_feature(ctx, fine, coarse, node, "is thinner than one of its cells");
        for (int d = 0; d < PD_DIM; d++) at[d] = i[d] / factor;
        pdi_coarsen_setup_node_block near_coarse = pdi_coarsen_setup_neighbourhood(&coarse->grid, at, 1, 1);
        if (!pdi_coarsen_setup_has_node_of_kind(&coarse->grid, &near_coarse, kind, NULL))
            return pdi_coarsen_setup_reject_feature(ctx, fine, coarse, node, "has no node on it");
    } while (pdi_coarsen_setup_next_node(&box, i));
    return PD_OK;
}

/* Build both grids, which the caller frees also on failure, and check that the coarse one resolves the features of the
 * fine one. PD_ERR_GEOMETRY: it does not. */
static pd_status pdi_coarsen_setup_build_grids(pd_ctx *ctx, const pd_setup *setup, const pd_setup *coarser, int factor,
                                               pdi_coarsen_setup_grid *fine, pdi_coarsen_setup_grid *coarse)
{
    uint8_t *wide = NULL;
    int line;
    PD_TRY(pd_model_build_grid(ctx, setup, &line, &fine->stencil, &fine->grid));
    PD_TRY(pd_model_build_grid(ctx, coarser, &line, &coarse->stencil, &coarse->grid));
    PD_TRY(PD_NEW(ctx, "coarser", fine->grid.total, wide));
    pd_status status = pdi_coarsen_setup_check_features(ctx, fine, coarse, factor, wide);
    PD_DELETE(ctx, fine->grid.total, wide);
    return status;
}

/* Check that the coarser lattice resolves the geometry (PD_ERR_GEOMETRY); frees what it builds. */
static pd_status pdi_coarsen_setup_check_geometry(pd_ctx *ctx, const pd_setup *setup, const pd_setup *coarser,
                                                  int factor)
{
    pdi_coarsen_setup_grid fine, coarse;
    memset(&fine, 0, sizeof fine);
    memset(&coarse, 0, sizeof coarse);
    pd_status status = pdi_coarsen_setup_build_grids(ctx, setup, coarser, factor, &fine, &coarse);
    pd_grid_free(ctx, &coarse.grid);
    pd_stencil_free(ctx, &coarse.stencil);
    pd_grid_free(ctx, &fine.grid);
    pd_stencil_free(ctx, &fine.stencil);
    return status;
}

/* Check that the number of cells of the box along each axis is a multiple of the factor. PD_ERR_GEOMETRY. */
static pd_status pdi_coarsen_setup_check_box(pd_ctx *ctx, const pd_setup *setup, int factor)
{
    for (int d = 0; d < PD_DIM; d++) {
        int cells = pd_setup_count_cells(setup, d);
        if (cells % factor)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "coarser",
                           "the lattice at %d h cannot hold the scene: the box has %d cells along %c, expected a"
                           " multiple of %d", factor, cells, "xyz"[d], factor);
    }
    return PD_OK;
}

/* Check a face of a shape at coordinate `place` [m]: if it lies on cell faces of the lattice (within 1e-6 cells), it
 * has to on the coarser one, else the body size jumps, which hides the order of convergence: PD_ERR_GEOMETRY. A face
 * between cell faces passes, as does one outside the box or on its sides. */
static pd_status pdi_coarsen_setup_check_face(pd_ctx *ctx, const pd_setup *setup, int factor, int axis, double place)
{
    char text[PD_UNITS_TEXT];
    double index = (place - setup->lo[axis]) / setup->h[axis], whole = floor(index + 0.5);
    int inside =
        index > PDI_COARSEN_SETUP_TOLERANCE && index < pd_setup_count_cells(setup, axis) - PDI_COARSEN_SETUP_TOLERANCE;
    if (!inside || fabs(index - whole) > PDI_COARSEN_SETUP_TOLERANCE || (int)whole % factor == 0) return PD_OK;
    pd_setup_format_value(place, "m", text);
    return pd_fail(ctx, PD_ERR_GEOMETRY, "coarser",
                   "the lattice at %d h cannot hold the scene: the face of a shape at %c = %s is cell %d of the box, "
                   "expected a multiple of %d", factor, "xyz"[axis], text, (int)whole, factor);
}

/* Check both faces of each box along every axis, and the plane of each half space whose normal is along an axis. Other
 * shapes are not checked. PD_ERR_GEOMETRY. */
static pd_status pdi_coarsen_setup_check_faces(pd_ctx *ctx, const pd_setup *setup, int factor)
{
    for (int k = 0; k < setup->shapes; k++) {
        const pd_shape *s = &setup->shape[k];
        int tilted = 0;
        for (int d = 0; d < PD_DIM; d++) tilted += fabs(s->b[d]) > 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            int plane = s->type == PD_SHAPE_HALF_SPACE && tilted == 1 && fabs(s->b[d]) > 0.0;
            if (s->type == PD_SHAPE_BOX || plane) PD_TRY(pdi_coarsen_setup_check_face(ctx, setup, factor, d, s->a[d]));
            if (s->type == PD_SHAPE_BOX) PD_TRY(pdi_coarsen_setup_check_face(ctx, setup, factor, d, s->b[d]));
        }
    }
    return PD_OK;
}

/* Add the monitor of a plane to coarser->setup: one plane of weight 1 where its index is a multiple of the factor, else
 * the two beside it with weights of linear interpolation. cells: of the finer lattice along its axis. PD_ERR_GEOMETRY:
 * one of them lies on an end of the box or beyond. PD_ERR_SIZE: too many monitors. */
static pd_status pdi_coarsen_setup_add_plane(pd_ctx *ctx, const pd_setup_monitor *m, int cells, int factor,
                                             pd_coarsened_setup *coarser)
{
    int low = m->index / factor, rest = m->index % factor;
    for (int side = 0; side < (rest ? 2 : 1); side++) {
        int k = coarser->setup.monitors;
        if (low + side < 1 || low + side > cells / factor - 1)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "coarser",
                           "the lattice at %d h has no plane beside [plane %s], too near to the end of the box",
                           factor, m->name);
        if (k == PD_SETUP_MONITORS)
            return pd_fail(ctx, PD_ERR_SIZE, "coarser",
                           "more than %d sections, because planes between those of the lattice count twice",
                           PD_SETUP_MONITORS);
        coarser->setup.monitor[k] = *m;
        coarser->setup.monitor[k].index = low + side;
        coarser->monitor_weight[k] = side ? rest / (double)factor : 1.0 - rest / (double)factor;
        coarser->setup.monitors++;
    }
    return PD_OK;
}

/* Copy the setup with `factor` times the spacing, check that its lattice holds the scene, and rebuild its monitors with
 * weights; lines are left out, since they write only files. Arrays of the copy are those of the setup. PD_ERR_GEOMETRY;
 * PD_ERR_SIZE: more monitors than a setup holds. */
static pd_status pdi_coarsen_setup_build_inner(pd_ctx *ctx, const pd_setup *setup, int factor,
                                               pd_coarsened_setup *coarser)
{
    coarser->setup = *setup;
    for (int d = 0; d < PD_DIM; d++) coarser->setup.h[d] = factor * setup->h[d];
    PD_TRY(pdi_coarsen_setup_check_box(ctx, setup, factor));
    PD_TRY(pdi_coarsen_setup_check_faces(ctx, setup, factor));
    PD_TRY(pdi_coarsen_setup_check_geometry(ctx, setup, &coarser->setup, factor));
    coarser->setup.monitors = 0;
    for (int k = 0; k < setup->monitors; k++) {
        const pd_setup_monitor *m = &setup->monitor[k];
        if (m->kind == PD_MONITOR_LINE) continue; /* nothing but files */
        if (m->kind == PD_MONITOR_PLANE) {
            PD_TRY(pdi_coarsen_setup_add_plane(ctx, m, pd_setup_count_cells(setup, m->axis), factor, coarser));
            continue;
        }
        if (coarser->setup.monitors == PD_SETUP_MONITORS)
            return pd_fail(ctx, PD_ERR_SIZE, "coarser", "more than %d sections", PD_SETUP_MONITORS);
        coarser->monitor_weight[coarser->setup.monitors] = 1.0;
        coarser->setup.monitor[coarser->setup.monitors++] = *m;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_coarsen_setup_build(pd_ctx *ctx, const pd_setup *setup, int factor, pd_coarsened_setup *coarser)
{
    pd_status status = pdi_coarsen_setup_build_inner(ctx, setup, factor, coarser);
    if (status < 0) memset(coarser, 0, sizeof *coarser);
    return status;
}

#undef PDI_COARSEN_SETUP_TOLERANCE
#undef PDI_COARSEN_SETUP_POLL
