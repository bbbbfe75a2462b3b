/* memory_estimate: see memory_estimate.h */
#include "physics/memory_estimate.h"
#include "setup/fields.h"
#include <math.h>
#include <string.h>

/* Sample points of the geometry along an axis, at most. */
#define PDI_MEMORY_ESTIMATE_SAMPLE_POINTS (PD_DIM == 1 ? 2000 : PD_DIM == 2 ? 100 : 28)
/* [byte] What does not grow with the lattice: tables of a run, small matrices of the solvers, the stencil. */
#define PDI_MEMORY_ESTIMATE_FIXED_BYTES 0.22e6

/* 1: x [m] lies nearer than near_to cells to a wall or inlet side, where its family is truncated; other sides do not
 * count. */
static int pdi_memory_estimate_is_near_closed_side(const pd_setup *setup, const double *x, double near_to)
{
    for (int d = 0; d < PD_DIM; d++)
        for (int end = 0; end < 2; end++) {
            pd_side kind = setup->side[2 * d + end].kind;
            double away = end ? setup->hi[d] - x[d] : x[d] - setup->lo[d];
            if ((kind == PD_SIDE_WALL || kind == PD_SIDE_INLET) && away < near_to * setup->h[d]) return 1;
        }
    return 0;
}

/* [m] Signed distance of x from metal and walls, negative within them; HUGE_VAL: there are none. */
static double pdi_memory_estimate_compute_distance(const pd_setup *setup, const double *x)
{
    double away = HUGE_VAL;
    if (setup->wall >= 0) away = pd_shape_distance(setup->shape, setup->wall, x);
    if (setup->solid >= 0) away = pd_min(away, pd_shape_distance(setup->shape, setup->solid, x));
    return away;
}

/* 1: the family of fluid place x, at distance `away` [m] from metal and walls, is truncated by them: away is below
 * reach times the spacing; with unequal spacings, of the largest, and a step along an axis of up to reach cells also
 * ends in metal or a wall. reach: of a family [cells]. */
static int pdi_memory_estimate_is_truncated(const pd_setup *setup, const double *x, double away, double reach)
{
    double least = setup->h[0], most = setup->h[0];
    for (int d = 1; d < PD_DIM; d++) {
        least = pd_min(least, setup->h[d]);
        most = pd_max(most, setup->h[d]);
    }
    if (!(away < reach * most)) return 0;
    for (int step = -(int)reach; step <= (int)reach && most > least; step++)
        for (int d = 0; d < PD_DIM; d++) {
            double at[PD_DIM];
            for (int a = 0; a < PD_DIM; a++) at[a] = x[a] + (a == d ? step * setup->h[a] : 0.0);
            if (pdi_memory_estimate_compute_distance(setup, at) < 0.0) return 1;
        }
    return !(most > least);
}

/* Estimate the numbers of fluid, solid, truncated and medium nodes, into b, on a regular sample of the box of at most
 * 2000 points (1D), 100 x 100 (2D) or 28 x 28 x 28 (3D). b->cells is set before. Truncated: fluid, and its family of
 * reach [cells] meets metal, a wall or an inlet side. Near a medium: within m + 1/2 of the largest spacing. */
static void pdi_memory_estimate_nodes(const pd_setup *u, double reach, pd_memory_estimate *b)
{
    int count[3] = {1, 1, 1}, i[3];
    double points = 1.0, step = 0.0, fluid = 0.0, solid = 0.0, cut = 0.0, near = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = (u->hi[d] - u->lo[d]) / u->h[d];
        count[d] = cells < PDI_MEMORY_ESTIMATE_SAMPLE_POINTS ? (int)(cells + 0.5) : PDI_MEMORY_ESTIMATE_SAMPLE_POINTS;
        if (count[d] < 1) count[d] = 1;
        points *= count[d];
        step = pd_max(step, u->h[d]);
    }
    for (i[2] = 0; i[2] < count[2]; i[2]++)
        for (i[1] = 0; i[1] < count[1]; i[1]++)
            for (i[0] = 0; i[0] < count[0]; i[0]++) {
                double x[PD_DIM];
                for (int d = 0; d < PD_DIM; d++) x[d] = u->lo[d] + (i[d] + 0.5) * (u->hi[d] - u->lo[d]) / count[d];
                if (u->medium >= 0) near += fabs(pd_shape_distance(u->shape, u->medium, x)) < (u->fluid_m + 0.5) * step;
                if (u->wall >= 0 && pd_shape_distance(u->shape, u->wall, x) < 0.0) continue;
                double away = pdi_memory_estimate_compute_distance(u, x);
                solid += away < 0.0;
                fluid += !(away < 0.0);
                cut += !(away < 0.0) && (pdi_memory_estimate_is_truncated(u, x, away, reach) ||
                                         pdi_memory_estimate_is_near_closed_side(u, x, reach));
            }
    b->fluid = b->cells * fluid / points;
    b->solid = b->cells * solid / points;
    b->truncated = b->cells * cut / points;
    b->near_medium = b->cells * near / points;
}

/* Set the memory of grid, stencils, ghosts and rows of bonds, the first share of PD_PART_GRID. */
static void pdi_memory_estimate_grid(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    b->bytes[PD_PART_GRID] = b->nodes + b->bonds * (70.0 + 12.0 * PD_DIM);          /* kinds; the stencil */
    if (pdi_grid_has_images(&plan->grid)) b->bytes[PD_PART_GRID] += 4.0 * b->nodes; /* what nodes repeat */
    if (setup->metals > 1) b->bytes[PD_PART_GRID] += b->nodes;
    if (pdi_setup_has_surface_area(setup)) b->bytes[PD_PART_GRID] += plan->across.count * (70.0 + 12.0 * PD_DIM);
    b->bytes[PD_PART_GRID] += 8.0 * b->nodes + 10.0 * (b->nodes - b->cells); /* rows of nodes, versions; ghosts */
    b->bytes[PD_PART_GRID] += pdi_memory_plan_count_array_bytes(plan, pdi_bond_list_row_arrays, &plan->bonds);
}

/* Set the memory of output, b->output_bytes: copies of the scalar fields and displacements that are written, and the
 * largest picture. */
static void pdi_memory_estimate_output(const pd_setup *setup, pd_memory_estimate *b)
{
    double copies = 0.0;
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (((setup->fields >> k) & 1u) && (k == PD_FIELD_U || pd_fields_is_scalar((pd_field)k)))
            copies += k == PD_FIELD_U ? 8.0 * PD_DIM : 8.0;
    b->output_bytes = copies * b->nodes + (setup->picture_bytes ? setup->picture_bytes(setup) : 0.0);
}

void pd_memory_estimate_compute(const pd_setup *u, pd_memory_estimate *b)
{
    pdi_memory_plan plan;
    pdi_physics_list list;
    double reach = ceil(u->fluid_m + 0.5) - 1.0, layers = pd_setup_count_ghost_layers(u);
    memset(b, 0, sizeof *b);
    b->nodes = b->cells = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = floor((u->hi[d] - u->lo[d]) / u->h[d] + 0.5);
        b->cells *= cells;
        b->nodes *= cells + 2.0 * layers;
    }
    b->bonds = pdi_memory_plan_count_bonds(u->fluid_m);
    pdi_memory_estimate_nodes(u, reach, b);
    pdi_memory_plan_init(u, b, &plan);
    pdi_memory_estimate_grid(u, &plan, b);
    pdi_physics_list_init_present(u, &list);
    for (int k = 0; k < list.count; k++)
        if (list.row[k].estimate) list.row[k].estimate(u, &plan, b);
    pdi_memory_estimate_output(u, b);
    b->total_bytes = PDI_MEMORY_ESTIMATE_FIXED_BYTES + b->runtime_bytes +
                     pd_max(b->output_bytes, b->equilibrium_bytes) + PD_SHAPE_MAX * (double)sizeof *u->shape;
    for (int k = 0; k < u->masks; k++) b->total_bytes += (double)u->mask_size[k];
    for (int k = 0; k < u->facets_count; k++) b->total_bytes += (double)pdi_facets_bytes(u->facets[k]);
    for (int k = 0; k < PD_PART_COUNT; k++) b->total_bytes += b->bytes[k];
}

pd_status pd_memory_estimate_check_limit(pd_ctx *ctx, const pd_setup *setup, int dry)
{
    pd_memory_estimate b;
    pd_memory_estimate_compute(setup, &b);
    if (dry) b.total_bytes -= pd_max(b.output_bytes - b.equilibrium_bytes, 0.0);
    if (!(b.nodes <= (double)INT32_MAX))
        return pd_fail(ctx, PD_ERR_SIZE, "grid", "the lattice has %.3g nodes, at most %.3g are possible", b.nodes,
                       (double)INT32_MAX);
    double sure = (b.total_bytes - PDI_MEMORY_ESTIMATE_FIXED_BYTES) / (1.0 + PD_MEMORY_ESTIMATE_ERROR);
    if (ctx->alloc.limit && sure > (double)ctx->alloc.limit)
        return pd_fail(ctx, PD_ERR_LIMIT, "memory", "the run needs about %.3g MB, the limit is %.3g MB",
                       b.total_bytes * 1e-6, (double)ctx->alloc.limit * 1e-6);
    return PD_OK;
}

#undef PDI_MEMORY_ESTIMATE_SAMPLE_POINTS
#undef PDI_MEMORY_ESTIMATE_FIXED_BYTES
