/* thickness: see thickness.h */
#include "lattice/thickness.h"

/* Erosion (all 1) or dilation (all 0) of mark [total], 0 or 1, along the lines of axis d in the box: a cell is marked
 * when all, or any, cells from `low` before to `high` behind it are. line [n + low + high] is scratch. Mirror sides
 * continue the marks, behind other sides there are none. */
static void pdi_thickness_filter_axis(const pd_grid *grid, uint8_t *mark, int d, int low, int high, int all,
                                      uint8_t *line)
{
    int n = grid->n[d];
    int32_t stride = grid->stride[d];
    for (int32_t node = 0; node < grid->total; node++) {
        int at[PD_DIM], count = 0;
        pd_grid_index(grid, node, at);
        if (at[d] || !pd_grid_is_inside(grid, at)) continue;
        for (int i = -low; i < n + high; i++) {
            int j = i < 0 ? -1 - i : i < n ? i : 2 * n - 1 - i;
            int inside = j == i || (j >= 0 && j < n && grid->side[2 * d + (i >= n)] == PD_SIDE_MIRROR);
            line[i + low] = inside ? mark[node + j * stride] : 0;
        }
        for (int i = 0; i < low + high; i++) count += line[i];
        for (int i = 0; i < n; i++) {
            count += line[i + low + high];
            mark[node + i * stride] = (uint8_t)(all ? count == low + high + 1 : count > 0);
            count -= line[i];
        }
    }
}

/* Dilates mark [total]: each marked cell marks those from `low` before to `high` behind it along all axes (a cuboid),
 * and then removes the marks outside of metal. line: scratch as of pdi_thickness_filter_axis. */
static void pdi_thickness_dilate(const pd_grid *grid, uint8_t *mark, int low, int high, uint8_t *line)
{
    for (int d = 0; d < PD_DIM; d++) pdi_thickness_filter_axis(grid, mark, d, high, low, 0, line);
    for (int32_t node = 0; node < grid->total; node++) mark[node] = mark[node] && grid->kind[node] == PD_SOLID;
}

PDI_FN pd_status pdi_thickness_compute_thin_fraction(pd_ctx *ctx, const pd_grid *grid, int cells, double *fraction)
{
    uint8_t *mark = NULL, *line = NULL;
    int longest = 0, low = cells / 2, high = cells - 1 - low;
    int64_t thin = 0, metal = 0;
    for (int d = 0; d < PD_DIM; d++) longest = grid->n[d] > longest ? grid->n[d] : longest;
    longest += 4 * cells + 2;
    pd_status status = PD_NEW(ctx, "thickness", grid->total, mark);
    if (status == PD_OK) status = PD_NEW(ctx, "thickness", longest, line);
    for (int32_t node = 0; node < grid->total && status == PD_OK; node++) {
        int at[PD_DIM];
        pd_grid_index(grid, node, at);
        mark[node] = grid->kind[node] == PD_SOLID && pd_grid_is_inside(grid, at);
    }
    for (int d = 0; d < PD_DIM && status == PD_OK; d++) pdi_thickness_filter_axis(grid, mark, d, low, high, 1, line);
    if (status == PD_OK) pdi_thickness_dilate(grid, mark, low, high, line);
    for (int k = 0; k < (cells + 1) / 2 && status == PD_OK; k++) pdi_thickness_dilate(grid, mark, 1, 1, line);
    for (int32_t node = 0; node < grid->total && status == PD_OK; node++) {
        int at[PD_DIM];
        pd_grid_index(grid, node, at);
        if (grid->kind[node] != PD_SOLID || !pd_grid_is_inside(grid, at)) continue;
        metal++;
        thin += !mark[node];
    }
    *fraction = metal ? (double)thin / (double)metal : 0.0;
    PD_DELETE(ctx, longest, line);
    PD_DELETE(ctx, grid->total, mark);
    return status;
}
