/* flow_scales: see flow_scales.h */
#include "flow/flow_scales.h"
#include <math.h>

PDI_FN double pdi_flow_scales_compute_inlet_speed(const pd_grid *grid, const double *u)
{
    double sum[2 * PD_DIM], area[2 * PD_DIM], most = 0.0;
    for (int s = 0; s < 2 * PD_DIM; s++) sum[s] = area[s] = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM], outside = 0, side = 0;
        if (grid->kind[node] != PD_INLET) continue;
        pd_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) {
            if (i[d] >= 0 && i[d] < grid->n[d]) continue;
            outside += i[d] == -1 || i[d] == grid->n[d] ? 1 : 2;
            side = 2 * d + (i[d] > 0);
        }
        if (outside != 1) continue;
        double around = pd_grid_circumference(grid, node);
        sum[side] += around * fabs(u[(int64_t)(side / 2) * grid->total + node]);
        area[side] += around;
    }
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (area[s] > 0.0) most = pd_max(most, sum[s] / area[s]);
    return most;
}

PDI_FN double pdi_flow_scales_compute_length(const pd_grid *grid)
{
    int lo[PD_DIM], hi[PD_DIM], best = 0;
    double extent = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = grid->n[d];
        hi[d] = 0;
    }
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) {
            lo[d] = i[d] < lo[d] ? i[d] : lo[d];
            hi[d] = i[d] > hi[d] ? i[d] : hi[d];
        }
    }
    for (int d = 0; d < PD_DIM; d++) {
        int rank = 2;
        double length = pd_max(hi[d] - lo[d] + 1, 1) * grid->h[d];
        for (int up = 0; up < 2; up++) {
            pd_side side = grid->side[2 * d + up];
            if (pd_grid_is_inlet_or_outlet(side)) rank = 1;
            if (side == PD_SIDE_PERIODIC) rank = 0;
            if (side == PD_SIDE_MIRROR && (up ? hi[d] == grid->n[d] - 1 : lo[d] == 0)) length *= 2.0;
        }
        if (grid->circumference && d == PD_DIM - 1 && fabs(grid->lo[d]) < 0.5 * grid->h[d]) length *= 2.0;
        if (rank < best) continue;
        extent = rank > best ? length : pd_min(extent, length);
        best = rank;
    }
    return extent;
}

PDI_FN double pdi_flow_scales_compute_forced_speed(double nu, double length, double force)
{
    double friction = 6.0 * nu / length;
    return force * length / (friction + sqrt(friction * friction + force * length));
}
