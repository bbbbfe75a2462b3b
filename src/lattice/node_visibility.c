/* node_visibility: see node_visibility.h */
#include "lattice/node_visibility.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

PDI_FN int pdi_node_visibility_is_convex(const pd_grid *grid)
{
    return grid->solid >= 0 && grid->wall < 0 && pdi_shape_is_convex(grid->shapes, grid->solid);
}

PDI_FN int pdi_node_visibility_is_smooth(const pd_grid *grid)
{
    return grid->solid >= 0 && pd_shape_is_smooth(grid->shapes, grid->solid) &&
           (grid->wall < 0 || pd_shape_is_smooth(grid->shapes, grid->wall));
}

PDI_FN double pdi_node_visibility_metal_distance(const pd_grid *grid, const double *x)
{
    double level = pd_shape_distance(grid->shapes, grid->solid, x);
    return grid->wall < 0 ? level : pd_max(level, -pd_shape_distance(grid->shapes, grid->wall, x));
}

PDI_FN int pdi_node_visibility_is_visible(const pd_grid *grid, const double *x, const double *xi)
{
    int last = grid->solid > grid->wall ? grid->solid : grid->wall;
    double middle[PD_DIM], tolerance = pd_shape_surface_tolerance(grid->h, x);
    for (double from = 0.0; from < 1.0;) {
        double to = pd_min(pdi_shape_find_crossing(grid->shapes, last, x, xi, from, tolerance), 1.0);
        for (int d = 0; d < PD_DIM; d++) middle[d] = x[d] + 0.5 * (from + to) * xi[d];
        if (pdi_node_visibility_metal_distance(grid, middle) > pd_shape_surface_tolerance(grid->h, middle)) return 0;
        from = to;
    }
    return 1;
}

/* ---- cells ---- */

/* A staircase of cells along a line. */
typedef struct pdi_node_visibility_staircase {
    pdi_node_visibility_is_metal_fn metal;
    const void *self;
    const int *from; /* cell at the start of the line */
    const int *step; /* [cells] from its start to its end */
    int axis;        /* axis of the largest step */
    int above;       /* bit d: cells are on or above the line along axis d, else on or below it */
} pdi_node_visibility_staircase;

/* Offset [cells] from the start, along axis d, of the staircase at step k of its longest axis: that of the line rounded
 * down, or up where bit d of `above` is set. */
static int pdi_node_visibility_stair_offset(const pdi_node_visibility_staircase *stairs, int k, int d)
{
    int step = stairs->step[stairs->axis], length = step < 0 ? -step : step, along = k * stairs->step[d];
    int lower = along >= 0 ? along / length : -((-along + length - 1) / length);
    return (stairs->above >> d & 1) && lower * length != along ? lower + 1 : lower;
}

/* 1: the cell at the offset `at` from the start is metal. */
static int pdi_node_visibility_is_metal(const pdi_node_visibility_staircase *stairs, const int *at)
{
    int cell[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) cell[d] = stairs->from[d] + at[d];
    return stairs->metal(stairs->self, cell);
}

/* 1: the staircase can go from cell `from` to cell `to` along the axes of a bit set, in some order, through metal
 * only; `to` is tested, too. */
static int pdi_node_visibility_has_path(const pdi_node_visibility_staircase *stairs, const int *from, const int *to,
                                        int axes)
{
    if (!axes) return 1;
    for (int d = 0; d < PD_DIM; d++) {
        int at[PD_DIM];
        if (!(axes >> d & 1)) continue;
        memcpy(at, from, sizeof at);
        at[d] = to[d];
        if (pdi_node_visibility_is_metal(stairs, at) && pdi_node_visibility_has_path(stairs, at, to, axes & ~(1 << d)))
            return 1;
    }
    return 0;
}

/* 1: step k of the staircase along its longest axis is in metal. Axes along which it moves towards its side of the
 * line go before that step, the others behind it. */
static int pdi_node_visibility_is_step_metal(const pdi_node_visibility_staircase *stairs, int k)
{
    int from[PD_DIM], to[PD_DIM], before = 0, behind = 0, sign = stairs->step[stairs->axis] < 0 ? -1 : 1;
    for (int d = 0; d < PD_DIM; d++) {
        from[d] = d == stairs->axis ? sign * k : pdi_node_visibility_stair_offset(stairs, k, d);
        to[d] = d == stairs->axis ? sign * (k + 1) : pdi_node_visibility_stair_offset(stairs, k + 1, d);
        if (d == stairs->axis || from[d] == to[d]) continue;
        if ((to[d] > from[d]) == (stairs->above >> d & 1)) before |= 1 << d;
        else behind |= 1 << d;
    }
    if (!pdi_node_visibility_has_path(stairs, from, to, before)) return 0;
    for (int d = 0; d < PD_DIM; d++)
        if (before >> d & 1) from[d] = to[d];
    from[stairs->axis] = to[stairs->axis];
    return pdi_node_visibility_is_metal(stairs, from) && pdi_node_visibility_has_path(stairs, from, to, behind);
}

PDI_FN int pdi_node_visibility_has_staircase(const int *from, const int *step, pdi_node_visibility_is_metal_fn is_metal,
                                             const void *self)
{
    int length = 0;
    pdi_node_visibility_staircase stairs;
    stairs.metal = is_metal;
    stairs.self = self;
    stairs.from = from;
    stairs.step = step;
    for (int d = 0; d < PD_DIM; d++) length = step[d] > length ? step[d] : -step[d] > length ? -step[d] : length;
    for (stairs.axis = 0; stairs.axis < PD_DIM; stairs.axis++) {
        if (step[stairs.axis] != length && -step[stairs.axis] != length) continue;
        for (stairs.above = 0; stairs.above < 1 << PD_DIM; stairs.above++) {
            int k = 0;
            if (stairs.above >> stairs.axis & 1) continue;
            while (k < length && pdi_node_visibility_is_step_metal(&stairs, k)) k++;
            if (k == length) return 1;
        }
    }
    return 0;
}

