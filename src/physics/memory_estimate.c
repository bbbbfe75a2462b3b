/* memory_estimate: see memory_estimate.h */
#include "physics/memory_estimate.h"
#include "scene/fields.h"
#include "io/renderer.h"
#include "io/field_plot.h"
#include <math.h>
#include <string.h>

/* Sample points of the geometry along an axis, at most. */
#define PDI_MEMORY_ESTIMATE_SAMPLE_POINTS (PD_DIM == 1 ? 2000 : PD_DIM == 2 ? 100 : 28)
/* [byte] A plot: pixels, filtered rows, the compressed file and the state of the compressor. */
#define PDI_MEMORY_ESTIMATE_PLOT_BYTES 5.7e6
/* [byte] The state of the compressor alone. */
#define PDI_MEMORY_ESTIMATE_DEFLATE_BYTES 0.65e6
/* [byte] What does not grow with the lattice: tables of a run, small matrices of the solvers, the stencil. */
#define PDI_MEMORY_ESTIMATE_FIXED_BYTES 0.22e6

/* 1: x lies within near_to cells of a wall or inlet side, where its family is truncated. */
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

/* [m] Signed distance of x from metal and walls, negative within them. */
static double pdi_memory_estimate_compute_distance(const pd_setup *setup, const double *x)
{
    double away = HUGE_VAL;
    if (setup->wall >= 0) away = pd_shape_distance(setup->shape, setup->wall, x);
    if (setup->solid >= 0) away = pdi_min(away, pd_shape_distance(setup->shape, setup->solid, x));
    return away;
}

/* 1: the family of fluid place x, at distance `away` [m] from metal and walls, is truncated by them: by the distance,
 * or, with unequal spacings, by steps along the axes. */
static int pdi_memory_estimate_is_truncated(const pd_setup *setup, const double *x, double away, double reach)
{
    double least = setup->h[0], most = setup->h[0];
    for (int d = 1; d < PD_DIM; d++) {
        least = pdi_min(least, setup->h[d]);
        most = pdi_max(most, setup->h[d]);
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

/* Estimate the numbers of fluid, solid, truncated and medium nodes on a regular sample of the box. reach: of a family
 * [cells]. */
static void pdi_memory_estimate_nodes(const pd_setup *u, double reach, pd_memory_estimate *b)
{
    int count[3] = {1, 1, 1}, i[3];
    double points = 1.0, step = 0.0, fluid = 0.0, solid = 0.0, cut = 0.0, near = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = (u->hi[d] - u->lo[d]) / u->h[d];
        count[d] = cells < PDI_MEMORY_ESTIMATE_SAMPLE_POINTS ? (int)(cells + 0.5) : PDI_MEMORY_ESTIMATE_SAMPLE_POINTS;
        if (count[d] < 1) count[d] = 1;
        points *= count[d];
        step = pdi_max(step, u->h[d]);
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

/* Add the memory of grid, stencils, ghosts and rows of bonds. */
static void pdi_memory_estimate_grid(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    b->bytes[PD_PART_GRID] = b->nodes + b->bonds * (70.0 + 12.0 * PD_DIM);          /* kinds; the stencil */
    if (pdi_grid_has_images(&plan->grid)) b->bytes[PD_PART_GRID] += 4.0 * b->nodes; /* what nodes repeat */
    if (setup->metals > 1) b->bytes[PD_PART_GRID] += b->nodes;
    if (pdi_setup_has_surface_area(setup)) b->bytes[PD_PART_GRID] += plan->across.count * (70.0 + 12.0 * PD_DIM);
    b->bytes[PD_PART_GRID] += 8.0 * b->nodes + 10.0 * (b->nodes - b->cells); /* rows of nodes, versions; ghosts */
    b->bytes[PD_PART_GRID] += pdi_memory_plan_count_array_bytes(plan, pdi_bond_list_row_arrays, &plan->bonds);
}

/* Pixels along an axis for a field of `cells`, about `wanted`; cells are merged beyond `largest`. */
static double pdi_memory_estimate_count_pixels(double cells, double wanted, double largest)
{
    double each = pdi_max(1.0, floor(wanted / cells + 0.5));
    return cells > largest ? cells / ceil(cells / largest) : pdi_max(cells * each, 120.0);
}

/* [byte] Memory of the rendered metal surface in 3D, its mesh taken as large as the surface of the box. */
static double pdi_memory_estimate_surface_view(const pd_setup *setup)
{
    pd_rendering s;
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0}, faces = 0.0;
    if (PD_DIM < 3 || !setup->drawing.surface) return 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM;
        lo[d] = setup->lo[d];
        hi[d] = setup->hi[d];
        faces += 2.0 * (setup->hi[d] - setup->lo[d]) / setup->h[d] * (setup->hi[e] - setup->lo[e]) / setup->h[e];
    }
    pdi_renderer_init_view(lo, hi, setup->drawing.view_direction,
                           setup->drawing.width ? setup->drawing.width : PD_FIELD_PLOT_WIDTH, &s);
    double pixels = (double)s.width * s.height, image = 6.0 * (s.width + 140.0) * (s.height + 110.0);
    double sorted = setup->drawing.percentile > 0.0 && setup->drawing.percentile < 1.0 ? 8.0 * pixels : 0.0;
    return 7.0 * pixels + sorted + pdi_max(20.0 * pixels + 330.0 * faces, image + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES);
}

/* [byte] Memory of the largest picture; they are drawn one by one. */
static double pdi_memory_estimate_pictures(const pd_setup *u)
{
    int right = u->slice_axis == 0 && PD_DIM == 3 ? 1 : 0, up = u->slice_axis == 2 || PD_DIM < 3 ? 1 : 2;
    int lines = 0, flows = 0, plots = u->has_dissolve || (PD_DIM == 1 && u->images);
    double largest = 0.0, across = 0.0;
    for (int k = 0; k < u->monitors; k++) {
        const pd_setup_monitor *m = &u->monitor[k];
        plots = plots || (m->kind == PD_MONITOR_LINE && m->images) || (m->kind == PD_MONITOR_TRANSFER && m->axis >= 0);
    }
    if (plots) largest = PDI_MEMORY_ESTIMATE_PLOT_BYTES;
    largest = pdi_max(largest, pdi_memory_estimate_surface_view(u));
    if (PD_DIM == 1 || !u->images) return largest;
    double lx = u->hi[right] - u->lo[right], ly = u->hi[up] - u->lo[up];
    if (u->axisymmetric && !(u->lo[up] > 0.0)) ly *= 2.0; /* both halves are drawn */
    double wanted = u->drawing.width ? u->drawing.width : PD_FIELD_PLOT_WIDTH, cells = lx / u->h[right] * ly / u->h[up];
    double scale = pdi_min(wanted / lx, PD_FIELD_PLOT_MAX_ASPECT * wanted / ly);
    double width = pdi_memory_estimate_count_pixels(lx / u->h[right], scale * lx, 1.4 * wanted) + 230.0;
    double height = pdi_memory_estimate_count_pixels(ly / u->h[up], scale * ly, 1.4 * wanted) + 140.0;
    double all = 6.0 * width * height + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES;
    if (u->displacement_scale > 0.0) { /* drawn on paper of its own, which is gone as the image is packed */
        double pixels = scale * lx * scale * ly;
        width = scale * lx + 230.0;
        height = scale * ly + 140.0;
        all = pdi_max(3.0 * width * height + 9.0 * pixels, 6.0 * width * height + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES);
        all += 17.0 * cells;
    }
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        lines = lines || u->drawing.contours[k];
        flows = flows || u->drawing.streamlines[k] || u->drawing.vectors[k];
        across = pdi_max(across, u->drawing.streamlines[k]);
    }
    if (flows) all = pdi_max(all, 4.0 * width * height) + 16.0 * cells;
    /* points of streamlines, 12 of 80 bytes over the distance between lines */
    all = pdi_max(all, 4.0 * width * height + 1000.0 * width * height * pow(across / wanted, 2.0));
    /* cover of a pixel, place on the bar of a cell */
    if (lines) all = pdi_max(all, 4.0 * width * height + 8.0 * cells);
    if (u->drawing.percentile > 0.0 && u->drawing.percentile < 1.0) all += 8.0 * cells;
    return pdi_max(largest, all) + 9.0 * cells;
}

/* Add the memory of output: copies of fields, and the largest picture. */
static void pdi_memory_estimate_output(const pd_setup *setup, pd_memory_estimate *b)
{
    double copies = 0.0;
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (((setup->fields >> k) & 1u) && (k == PD_FIELD_U || pdi_fields_is_scalar((pd_field)k)))
            copies += k == PD_FIELD_U ? 8.0 * PD_DIM : 8.0;
    b->output_bytes = copies * b->nodes + pdi_memory_estimate_pictures(setup);
}

void pd_memory_estimate_compute(const pd_setup *u, pd_memory_estimate *b)
{
    pdi_memory_plan plan;
    pdi_physics_list list;
    double reach = ceil(u->fluid_m + 0.5) - 1.0, layers = pdi_setup_count_ghost_layers(u);
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
                     pdi_max(b->output_bytes, b->equilibrium_bytes) + PD_SHAPE_MAX * (double)sizeof *u->shape;
    for (int k = 0; k < u->masks; k++) b->total_bytes += (double)u->mask_size[k];
    for (int k = 0; k < u->facets_count; k++) b->total_bytes += (double)pdi_facets_bytes(u->facets[k]);
    for (int k = 0; k < PD_PART_COUNT; k++) b->total_bytes += b->bytes[k];
}

PDI_FN pd_status pdi_memory_estimate_check_limit(pd_ctx *ctx, const pd_setup *setup, int dry)
{
    pd_memory_estimate b;
    pd_memory_estimate_compute(setup, &b);
    if (dry) b.total_bytes -= pdi_max(b.output_bytes - b.equilibrium_bytes, 0.0);
    if (!(b.nodes <= (double)INT32_MAX))
        return pdi_fail(ctx, PD_ERR_SIZE, "grid", "the lattice has %.3g nodes, at most %.3g are possible", b.nodes,
                        (double)INT32_MAX);
    double sure = (b.total_bytes - PDI_MEMORY_ESTIMATE_FIXED_BYTES) / (1.0 + PD_MEMORY_ESTIMATE_ERROR);
    if (ctx->alloc.limit && sure > (double)ctx->alloc.limit)
        return pdi_fail(ctx, PD_ERR_LIMIT, "memory", "the run needs about %.3g MB, the limit is %.3g MB",
                        b.total_bytes * 1e-6, (double)ctx->alloc.limit * 1e-6);
    return PD_OK;
}

#undef PDI_MEMORY_ESTIMATE_SAMPLE_POINTS
#undef PDI_MEMORY_ESTIMATE_PLOT_BYTES
#undef PDI_MEMORY_ESTIMATE_DEFLATE_BYTES
#undef PDI_MEMORY_ESTIMATE_FIXED_BYTES
