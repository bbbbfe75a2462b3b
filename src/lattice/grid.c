/* grid: see grid.h */
#include "lattice/grid.h"
#include "core/par.h"
#include "core/array_registry.h"
#include "core/root_bracket.h"
#include "core/vec.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* [cells] Tolerance of comparisons of positions with bounds; shorter parts of a line do not count. */
#define PDI_GRID_TOLERANCE 1e-6
/* Nodes between two checks for cancellation by the caller. */
#define PDI_GRID_POLL_INTERVAL 65536

void pd_grid_index(const pd_grid *grid, int32_t node, int *i)
{
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = (int)(node % grid->padded[d]) - grid->ghost;
        node /= grid->padded[d];
    }
}

PDI_FN const char *pdi_grid_format_position(const pd_grid *grid, int32_t node, char *text)
{
    double x[PD_DIM];
    int used = 0;
    pd_grid_position(grid, node, x);
    for (int d = 0; d < PD_DIM; d++)
        used += snprintf(text + used, (size_t)(PDI_GRID_POSITION_LENGTH - used), "%s%.6g", d ? ", " : "(", x[d]);
    snprintf(text + used, (size_t)(PDI_GRID_POSITION_LENGTH - used), ")");
    return text;
}

int pd_grid_is_inside(const pd_grid *grid, const int *i)
{
    for (int d = 0; d < PD_DIM; d++)
        if (i[d] < 0 || i[d] >= grid->n[d]) return 0;
    return 1;
}

PDI_FN int pdi_grid_is_behind_wall(const pd_grid *grid, int32_t node)
{
    int i[PD_DIM];
    pd_grid_index(grid, node, i);
    for (int d = 0; d < PD_DIM; d++)
        if ((i[d] < 0 && grid->side[2 * d] == PD_SIDE_WALL) ||
            (i[d] >= grid->n[d] && grid->side[2 * d + 1] == PD_SIDE_WALL))
            return 1;
    return 0;
}

PDI_FN int32_t pdi_grid_find_cube_node(const pd_grid *grid, int32_t node, int reach, int k, int *far)
{
    int at[PD_DIM], width = 2 * reach + 1;
    *far = 0;
    pd_grid_index(grid, node, at);
    for (int d = 0; d < PD_DIM; d++, k /= width) {
        int step = k % width - reach;
        at[d] += step;
        *far = step > *far ? step : -step > *far ? -step : *far;
    }
    return pd_grid_is_inside(grid, at) ? pd_grid_node(grid, at) : -1;
}

int32_t pd_grid_node(const pd_grid *grid, const int *i)
{
    int32_t node = 0;
    for (int d = 0; d < PD_DIM; d++) node += (int32_t)(i[d] + grid->ghost) * grid->stride[d];
    return node;
}

void pd_grid_position(const pd_grid *grid, int32_t node, double *x)
{
    int i[PD_DIM];
    pd_grid_index(grid, node, i);
    for (int d = 0; d < PD_DIM; d++) x[d] = grid->lo[d] + ((double)i[d] + 0.5) * grid->h[d];
}

PDI_FN int64_t pdi_grid_count_kind(const pd_grid *grid, pd_kind kind)
{
    int64_t count = 0;
    for (int32_t node = 0; node < grid->total; node++) count += grid->kind[node] == (uint8_t)kind;
    return count;
}

PDI_FN double pdi_grid_circumference_at(const pd_grid *grid, int32_t node, double out)
{
    double x[PD_DIM];
    if (!grid->circumference) return 1.0;
    pd_grid_position(grid, node, x);
    return 2.0 * PD_PI * fabs(x[PD_DIM - 1] + out);
}

int pd_grid_is_between(const pd_grid *grid, const double *lo, const double *hi, const double *x)
{
    for (int d = 0; d < PD_DIM; d++) {
        double slack = PDI_GRID_TOLERANCE * grid->h[d];
        if (!(x[d] >= lo[d] - slack) || !(x[d] <= hi[d] + slack)) return 0;
    }
    return 1;
}

/* Side of the box behind which index i[] lies; -1: inside the box; -2: behind an edge or corner. */
static int pdi_grid_find_side(const pd_grid *grid, const int *i)
{
    int side = -1;
    for (int d = 0; d < PD_DIM; d++) {
        if (i[d] >= 0 && i[d] < grid->n[d]) continue;
        if (side != -1) return -2;
        side = 2 * d + (i[d] < 0 ? 0 : 1);
    }
    return side;
}

/* i modulo period, not negative. */
static int pdi_grid_wrap(int i, int period) { return ((i % period) + period) % period; }

/* Index 0 .. n - 1 of the mirror image of i in a box of n cells; *flipped: 1 for an odd number of reflections. Images
 * have twice the period of the box; a box thinner than the horizon is mirrored more than once. */
static int pdi_grid_reflect(int i, int n, int *flipped)
{
    int wrapped = pdi_grid_wrap(i, 2 * n);
    *flipped = wrapped >= n;
    return *flipped ? 2 * n - 1 - wrapped : wrapped;
}

/* Maps index *i of axis d back into the box through the side behind which it lies: periodic or mirror; all 1: any other
 * side, too (mirrored), 0: behind these it stays. Returns the bit 1 << d when it is mirrored an odd number of times,
 * else 0. */
static int pdi_grid_fold_axis(const pd_grid *grid, int d, int all, int *i)
{
    int flipped = 0;
    if (*i >= 0 && *i < grid->n[d]) return 0;
    pd_side side = grid->side[2 * d + (*i < 0 ? 0 : 1)];
    if (side == PD_SIDE_PERIODIC) *i = pdi_grid_wrap(*i, grid->n[d]);
    else if (side == PD_SIDE_MIRROR || all) *i = pdi_grid_reflect(*i, grid->n[d], &flipped);
    return flipped ? 1 << d : 0;
}

int32_t pd_grid_find_source(const pd_grid *grid, int32_t node, int *flip)
{
    if (grid->source_node && !flip) return grid->source_node[node];
    int i[PD_DIM], flipped = 0;
    pd_grid_index(grid, node, i);
    for (int d = 0; d < PD_DIM; d++) flipped |= pdi_grid_fold_axis(grid, d, 1, &i[d]);
    if (flip) *flip = flipped;
    return pd_grid_node(grid, i);
}

PDI_FN int pdi_grid_fold_index(const pd_grid *grid, int *i)
{
    int flipped = 0;
    for (int d = 0; d < PD_DIM; d++) flipped |= pdi_grid_fold_axis(grid, d, 0, &i[d]);
    return flipped;
}

PDI_FN int pdi_grid_fold_position_images(const pd_grid *grid, double *x)
{
    double folded[PD_DIM], tolerance = pd_shape_surface_tolerance(grid->h, x);
    int flip = 0;
    memcpy(folded, x, sizeof folded);
    pdi_grid_fold_position(grid, folded);
    for (int d = 0; d < PD_DIM; d++) {
        pd_side side = grid->side[2 * d + (x[d] > grid->hi[d])];
        if (pd_grid_is_inlet_or_outlet(side) || (x[d] >= grid->lo[d] - tolerance && x[d] <= grid->hi[d] + tolerance))
            continue;
        int once = grid->side[2 * d] == PD_SIDE_WALL || grid->side[2 * d + 1] == PD_SIDE_WALL;
        double boxes = floor((x[d] - grid->lo[d]) / (grid->hi[d] - grid->lo[d]));
        if (side == PD_SIDE_MIRROR && (once || fabs(fmod(boxes, 2.0)) > 0.5)) flip |= 1 << d;
        x[d] = folded[d];
    }
    return flip;
}

PDI_FN void pdi_grid_fold_position(const pd_grid *grid, double *x)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (x[d] >= grid->lo[d] && x[d] <= grid->hi[d]) continue;
        int up = x[d] > grid->hi[d];
        double edge = up ? grid->hi[d] : grid->lo[d], length = grid->hi[d] - grid->lo[d];
        pd_side side = grid->side[2 * d + up];
        if (side == PD_SIDE_PERIODIC) x[d] += up ? -length : length;
        else if (side != PD_SIDE_WALL) x[d] = 2.0 * edge - x[d];
        if ((x[d] >= grid->lo[d] && x[d] <= grid->hi[d]) || grid->side[2 * d] == PD_SIDE_WALL ||
            grid->side[2 * d + 1] == PD_SIDE_WALL)
            continue;
        /* farther than a box away: mirror images have twice its period */
        double period = side == PD_SIDE_PERIODIC ? length : 2.0 * length, offset = x[d] - grid->lo[d];
        offset -= period * floor(offset / period);
        x[d] = grid->lo[d] + (offset > length ? period - offset : offset);
    }
}

/* Signed distance [m] of x from a shape and its periodic images behind the sides of `frame` across axis d or a later
 * one; d = PD_DIM: from the shape alone, continued behind these sides. An image counts only behind the plane: its
 * distance is at least that of the plane. */
static double pdi_grid_distance_periodic(const pd_grid *grid, int shape, const pdi_shape_continued_box *frame, int d,
                                         const double *x)
{
    if (d == PD_DIM) return pdi_shape_distance_continued(grid->shapes, shape, frame, x);
    double distance = pdi_grid_distance_periodic(grid, shape, frame, d + 1, x), length = grid->hi[d] - grid->lo[d];
    double shifted[PD_DIM];
    for (int up = 0; up < 2 && grid->side[2 * d] == PD_SIDE_PERIODIC; up++) {
        pdi_shape_continued_box next = *frame, alone = *frame;
        if (!(frame->sides >> (2 * d + up) & 1)) continue;
        memcpy(shifted, x, sizeof shifted);
        shifted[d] += up ? -length : length;
        next.sides ^= 3 << 2 * d;
        alone.sides &= ~(3 << 2 * d);
        double plane = up ? grid->hi[d] - x[d] : x[d] - grid->lo[d];
        double other = pdi_grid_distance_periodic(grid, shape, &next, d + 1, shifted);
        double ends = distance > 0.0 ? pdi_grid_distance_periodic(grid, shape, &alone, d + 1, shifted) : 0.0;
        if (distance > 0.0) distance = pd_min(distance, pd_max(plane, pd_max(other, ends)));
        else distance = pd_max(distance, -pd_max(plane, -other));
    }
    return distance;
}

PDI_FN double pdi_grid_signed_distance(const pd_grid *grid, int shape, const double *x)
{
    double folded[PD_DIM], tolerance = PDI_GRID_TOLERANCE * pdi_vec_min(grid->h);
    pdi_shape_continued_box frame;
    memcpy(folded, x, sizeof folded);
    pdi_grid_fold_position(grid, folded);
    double distance = pd_shape_distance(grid->shapes, shape, folded);
    frame.lo = grid->lo;
    frame.hi = grid->hi;
    frame.tolerance = tolerance;
    frame.sides = 0;
    /* what is farther than the surface cannot change it */
    for (int s = 0; s < 2 * PD_DIM; s++) {
        double plane = s % 2 ? grid->hi[s / 2] - folded[s / 2] : folded[s / 2] - grid->lo[s / 2];
        if (grid->side[s] != PD_SIDE_WALL && plane <= fabs(distance) + tolerance) frame.sides |= 1 << s;
    }
    return frame.sides ? pdi_grid_distance_periodic(grid, shape, &frame, 0, folded) : distance;
}

/* ---- first intersection of a line with a shape ---- */

/* A straight line x + t xi [m], and its image y + t eta in the box, which is straight for from <= t <= to. */
typedef struct pdi_grid_folded_line {
    const pd_grid *grid;
    const double *x, *xi;
    double y[PD_DIM], eta[PD_DIM], from, to;
} pdi_grid_folded_line;

/* Smallest t > line->from, at most `end`, at which the line crosses a plane through which positions are folded (lo + a
 * multiple of the box length); axes with walls on both sides, and those normal to the line, have none. */
static double pdi_grid_find_next_fold(const pdi_grid_folded_line *line, double end)
{
    const pd_grid *grid = line->grid;
    for (int d = 0; d < PD_DIM; d++) {
        if (!(fabs(line->xi[d]) > 0.0)) continue;
        double length = grid->hi[d] - grid->lo[d], step = fabs(length / line->xi[d]);
        if (grid->side[2 * d] == PD_SIDE_WALL && grid->side[2 * d + 1] == PD_SIDE_WALL) continue;
        double first = (grid->lo[d] - line->x[d]) / line->xi[d];
        double t = first + step * (floor((line->from - first) / step) + 1.0);
        end = pd_min(end, t > line->from ? t : t + step);
    }
    return end;
}

/* Sets y, eta and to: the image of the line in the box from line->from on, up to the next folding plane or `end`. */
static void pdi_grid_set_line_image(pdi_grid_folded_line *line, double end)
{
    double other[PD_DIM];
    line->to = pdi_grid_find_next_fold(line, end);
    for (int d = 0; d < PD_DIM; d++) {
        line->y[d] = line->x[d];
        line->eta[d] = line->xi[d];
    }
    if (!(line->from > 0.0)) return;
    double t0 = 0.75 * line->from + 0.25 * line->to, t1 = 0.25 * line->from + 0.75 * line->to;
    for (int d = 0; d < PD_DIM; d++) {
        line->y[d] = line->x[d] + t0 * line->xi[d];
        other[d] = line->x[d] + t1 * line->xi[d];
    }
    pdi_grid_fold_position(line->grid, line->y);
    pdi_grid_fold_position(line->grid, other);
    for (int d = 0; d < PD_DIM; d++) {
        line->eta[d] = (other[d] - line->y[d]) / (t1 - t0);
        line->y[d] -= t0 * line->eta[d];
    }
}

/* Signed distance [m] of the point at t from a shape of the grid; *tie (or NULL): tolerance of the surface there [m].
 */
static double pdi_grid_line_distance(const pdi_grid_folded_line *line, int shape, double t, double *tie)
{
    double at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) at[d] = line->x[d] + t * line->xi[d];
    if (tie) *tie = pd_shape_surface_tolerance(line->grid->h, at);
    return pdi_grid_signed_distance(line->grid, shape, at);
}

/* t in from .. to at which the line enters the shape: root of the signed distance, when the line is outside at `from`
 * (by more than 1e-6 spacings) and inside at `to`; else `from`, which is the face itself. */
static double pdi_grid_find_sign_change(const pdi_grid_folded_line *line, int shape, double from, double to)
{
    double low = pdi_grid_line_distance(line, shape, from, NULL), high = pdi_grid_line_distance(line, shape, to, NULL);
    double t = to, f = low;
    if (!(low > PDI_GRID_TOLERANCE * pdi_vec_min(line->grid->h)) || !(high < 0.0)) return from;
    pdi_root_bracket s = {from, low, to, high, 0, 0};
    while (fabs(f) > 1e-12 * (low - high) && pdi_root_bracket_get_next(&s, &t)) {
        f = pdi_grid_line_distance(line, shape, t, NULL);
        pdi_root_bracket_update(&s, t, f);
    }
    return t;
}

PDI_FN double pdi_grid_find_shape_entry(const pd_grid *grid, int shape, const double *x, const double *xi, double limit)
{
    double slack = PDI_GRID_TOLERANCE * pdi_vec_min(grid->h) / pdi_vec_norm(xi), end = limit + 2.0 * slack;
    pdi_grid_folded_line line;
    line.grid = grid;
    line.x = x;
    line.xi = xi;
    for (line.from = 0.0; line.from < end; line.from = line.to) {
        double whole[PD_DIM], touch = pd_shape_surface_tolerance(grid->h, x);
        pdi_grid_set_line_image(&line, end);
        for (int d = 0; d < PD_DIM; d++) whole[d] = line.to * line.eta[d];
        for (double from = line.from / line.to, to; from < 1.0; from = to) { /* shares of line.to */
            double tie, middle;
            to = pd_min(pdi_shape_find_crossing(grid->shapes, shape, line.y, whole, from, touch), 1.0);
            middle = 0.5 * (from + to) * line.to;
            if ((to - from) * line.to > slack && pdi_grid_line_distance(&line, shape, middle, &tie) <= tie)
                return pd_min(pdi_grid_find_sign_change(&line, shape, from * line.to, middle), limit);
        }
    }
    return HUGE_VAL;
}

/* 1: the ghost i[] behind the inlet or outlet `side` is an inlet, as grid->is_inlet says of its projection on the
 * side, or without that function the type of the side. */
static int pdi_grid_is_inlet_ghost(const pd_grid *grid, const int *i, int side)
{
    double x[PD_DIM];
    if (!grid->is_inlet) return grid->side[side] == PD_SIDE_INLET;
    for (int d = 0; d < PD_DIM; d++) x[d] = grid->lo[d] + ((double)i[d] + 0.5) * grid->h[d];
    x[side / 2] = side % 2 ? grid->hi[side / 2] : grid->lo[side / 2];
    return grid->is_inlet(grid->is_inlet_user, side, x);
}

/* Kind of a ghost: image behind periodic and mirror sides; behind one inlet or outlet that (pdi_grid_is_inlet_ghost),
 * each only when its source is fluid. Wall: the source is not fluid (solid is as closed as a wall), the side is a wall,
 * or the ghost lies behind an edge or corner of two sides that are not folded. */
static uint8_t pdi_grid_get_ghost_kind(const pd_grid *grid, int32_t node)
{
    int i[PD_DIM];
    pd_grid_index(grid, node, i);
    pdi_grid_fold_index(grid, i);
    int side = pdi_grid_find_side(grid, i);
    uint8_t behind = grid->kind[pd_grid_find_source(grid, node, NULL)];
    if (side == -2 || behind != PD_FLUID) return PD_WALL;
    if (side == -1) return PD_IMAGE;
    if (grid->side[side] == PD_SIDE_WALL) return PD_WALL;
    return pdi_grid_is_inlet_ghost(grid, i, side) ? PD_INLET : PD_OUTLET;
}

/* Sets the kinds of all ghosts. */
static void pdi_grid_set_ghost_kinds(pd_grid *grid)
{
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        pd_grid_index(grid, node, i);
        if (!pd_grid_is_inside(grid, i)) grid->kind[node] = pdi_grid_get_ghost_kind(grid, node);
    }
}

/* Sets grid->mixed_sides: bits of the sides that are an inlet at some points and an outlet at others, whatever lies in
 * front; 0 without grid->is_inlet, whose function it calls for all ghosts of such sides. */
static void pdi_grid_mark_mixed_sides(pd_grid *grid)
{
    int seen[2] = {0, 0};
    for (int32_t node = 0; node < grid->total && grid->is_inlet; node++) {
        int i[PD_DIM];
        pd_grid_index(grid, node, i);
        pdi_grid_fold_index(grid, i);
        int side = pdi_grid_find_side(grid, i);
        if (side >= 0 && pd_grid_is_inlet_or_outlet(grid->side[side]))
            seen[pdi_grid_is_inlet_ghost(grid, i, side) ? 1 : 0] |= 1 << side;
    }
    grid->mixed_sides = (uint8_t)(seen[0] & seen[1]);
}

/* Marks walls, ghosts included, without a fluid or solid node of the box in their family as PD_INACTIVE. */
static void pdi_grid_mark_outside(const pd_stencil *stencil, pd_grid *grid)
{
    for (int32_t node = 0; node < grid->total; node++) {
        if (grid->kind[node] != PD_WALL) continue;
        int i[PD_DIM], near_fluid = 0;
        pd_grid_index(grid, node, i);
        for (int k = 0; k < stencil->count && !near_fluid; k++) {
            int j[PD_DIM];
            for (int d = 0; d < PD_DIM; d++) j[d] = i[d] + stencil->offset[k * PD_DIM + d];
            near_fluid = pd_grid_is_inside(grid, j) && (grid->kind[pd_grid_node(grid, j)] == PD_FLUID ||
                                                        grid->kind[pd_grid_node(grid, j)] == PD_SOLID);
        }
        if (!near_fluid) grid->kind[node] = PD_INACTIVE;
    }
}

PDI_COLD_BEGIN
/* Box lo .. hi [m] around shape `index`: of a union around all children, of an intersection the common part of theirs,
 * of a difference that of the first child. +-infinity: unbounded directions, half-spaces and complements. */
static void pdi_grid_compute_bounds(const pd_shape *shapes, int index, double *lo, double *hi)
{
    const pd_shape *s = &shapes[index];
    for (int d = 0; d < PD_DIM; d++) {
        lo[d] = -HUGE_VAL;
        hi[d] = HUGE_VAL;
        if (s->type == PD_SHAPE_BOX) {
            lo[d] = s->a[d];
            hi[d] = s->b[d];
        } else if (s->type == PD_SHAPE_BALL || (s->type == PD_SHAPE_CYLINDER && (PD_DIM == 1 || d != s->axis))) {
            lo[d] = s->a[d] - s->radius;
            hi[d] = s->a[d] + s->radius;
        } else if (s->type == PD_SHAPE_VOXELS) {
            lo[d] = s->a[d];
            hi[d] = s->a[d] + (double)s->mask_size[d] * s->b[d];
        } else if (s->type == PD_SHAPE_FACETS) {
            lo[d] = s->facets->box[d];
            hi[d] = s->facets->box[3 + d];
        }
    }
    int is_union = s->type == PD_SHAPE_UNION;
    int is_intersection = s->type == PD_SHAPE_INTERSECT || s->type == PD_SHAPE_DIFFERENCE;
    int used = s->type == PD_SHAPE_DIFFERENCE ? 1 : s->child_count;
    for (int c = 0; c < used && (is_union || is_intersection); c++) {
        double clo[PD_DIM], chi[PD_DIM];
        pdi_grid_compute_bounds(shapes, s->child[c], clo, chi);
        for (int d = 0; d < PD_DIM; d++) {
            if (c == 0) {
                lo[d] = clo[d];
                hi[d] = chi[d];
                continue;
            }
            lo[d] = is_union ? pd_min(lo[d], clo[d]) : pd_max(lo[d], clo[d]);
            hi[d] = is_union ? pd_max(hi[d], chi[d]) : pd_min(hi[d], chi[d]);
        }
    }
}

/* PD_ERR_GEOMETRY: the bounds of the metal reach beyond a side that is a wall, inlet or outlet by more than 1e-9 of the
 * length of the box. Directions without bounds do not count. */
static pd_status pdi_grid_check_solid(pd_ctx *ctx, const pd_grid *grid)
{
    double lo[PD_DIM], hi[PD_DIM];
    pdi_grid_compute_bounds(grid->shapes, grid->solid, lo, hi);
    for (int d = 0; d < PD_DIM; d++) {
        double tolerance = 1e-9 * (grid->hi[d] - grid->lo[d]);
        int below = lo[d] < grid->lo[d] - tolerance && lo[d] > -HUGE_VAL && grid->side[2 * d] < PD_SIDE_PERIODIC;
        int above = hi[d] > grid->hi[d] + tolerance && hi[d] < HUGE_VAL && grid->side[2 * d + 1] < PD_SIDE_PERIODIC;
        if (below || above)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "grid",
                           "the solid reaches from %g m to %g m on axis %d, outside of the box %g m .. %g m", lo[d],
                           hi[d], d, grid->lo[d], grid->hi[d]);
    }
    return PD_OK;
}

/* Sets ghost (the larger of desc->ghost and the reach), cells, spacings, box, strides, total and sides.
 * PD_ERR_GEOMETRY: an edge of the box is not positive, has 2e9 cells or more, or no whole number of them (to 1e-6 of a
 * cell, above 1000 cells to 1e-9 of the edge). PD_ERR_SIZE: total times PD_DIM does not fit int32. PD_ERR_ARGUMENT: a
 * side of no type, or periodic without the opposite one. */
static pd_status pdi_grid_set_size(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid_desc *desc, pd_grid *grid)
{
    double total = 1.0;
    grid->ghost = desc->ghost > stencil->reach ? desc->ghost : stencil->reach;
    for (int d = 0; d < PD_DIM; d++) {
        double edge = desc->hi[d] - desc->lo[d], cells = edge / stencil->h[d];
        if (!(edge > 0.0) || !(cells < 2e9))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "grid",
                           "axis %d of the box goes from %g m to %g m with spacing %g m", d, desc->lo[d], desc->hi[d],
                           stencil->h[d]);
        double whole = floor(cells + 0.5);
        if (whole < 1.0 || fabs(cells - whole) > 1e-6 * pd_max(1.0, whole * 1e-3))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "grid",
                           "the box is %g cells of %g m long on axis %d, expected a whole number", cells,
                           stencil->h[d], d);
        grid->n[d] = (int)whole;
        grid->padded[d] = grid->n[d] + 2 * grid->ghost;
        grid->h[d] = stencil->h[d];
        grid->lo[d] = desc->lo[d];
        grid->hi[d] = desc->hi[d];
        total *= (double)grid->padded[d];
    }
    if (total * PD_DIM >= 2147483647.0)
        return pd_fail(ctx, PD_ERR_SIZE, "grid", "%.3g nodes with ghosts, expected less than %.3g", total,
                       2147483647.0 / PD_DIM);
    grid->stride[0] = 1;
    for (int d = 1; d < PD_DIM; d++) grid->stride[d] = grid->stride[d - 1] * (int32_t)grid->padded[d - 1];
    grid->total = (int32_t)total;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        grid->side[s] = desc->side[s];
        if ((int)desc->side[s] < PD_SIDE_WALL || (int)desc->side[s] > PD_SIDE_MIRROR)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "grid",
                           "side %d of the box has type %d, expected wall, inlet, outlet, periodic or mirror", s,
                           (int)desc->side[s]);
        if ((desc->side[s] == PD_SIDE_PERIODIC) != (desc->side[s ^ 1] == PD_SIDE_PERIODIC))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "grid", "axis %d is periodic on one side only", s / 2);
    }
    return PD_OK;
}

/* Allocates and computes the circumferences of an axisymmetric grid. PD_ERR_ARGUMENT: not 2D; the side at the axis is
 * no mirror; another side across r is periodic or a mirror. PD_ERR_GEOMETRY: the box begins neither at r = 0 (to 1e-9
 * of a cell) nor at least the ghost layers away. Otherwise fluxes would not be conservative. */
static pd_status pdi_grid_compute_circumferences(pd_ctx *ctx, pd_grid *grid)
{
    int r = PD_DIM - 1, at_axis = fabs(grid->lo[r]) <= 1e-9 * grid->h[r];
    if (PD_DIM != 2)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grid", "axisymmetric in %dD, expected PD_DIM = 2 with axes z and r",
                       PD_DIM);
    if (!at_axis && !(grid->lo[r] >= grid->ghost * grid->h[r]))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "grid",
                       "an axisymmetric box begins at r = %g m, expected 0 or at least one horizon, %g m", grid->lo[r],
                       grid->ghost * grid->h[r]);
    if (at_axis && grid->side[2 * r] != PD_SIDE_MIRROR)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grid", "the side at the axis r = 0 has type %d, expected mirror",
                       (int)grid->side[2 * r]);
    if ((!at_axis && grid->side[2 * r] >= PD_SIDE_PERIODIC) || grid->side[2 * r + 1] >= PD_SIDE_PERIODIC)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grid",
                       "an axisymmetric box is periodic or mirrored across r > 0, expected wall, inlet or outlet");
    PD_TRY(PD_NEW(ctx, "grid.circumference", grid->padded[r], grid->circumference));
    for (int row = 0; row < grid->padded[r]; row++) {
        double cell = row - grid->ghost + 0.5;
        grid->circumference[row] = 2.0 * PD_PI * fabs((at_axis ? 0.0 : grid->lo[r]) + cell * grid->h[r]);
    }
    return PD_OK;
}

PDI_FN int pdi_grid_has_images(const pd_grid *grid)
{
    int images = 0;
    for (int s = 0; s < 2 * PD_DIM; s++) images = images || grid->side[s] >= PD_SIDE_PERIODIC;
    return images && grid->solid >= 0;
}

/* Describes the arrays of the grid to the array registry. */
static void pdi_grid_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_grid *grid = (pd_grid *)object;
    PDI_ARRAY(owner, grid, kind, grid->total, "1");
    if (pdi_grid_has_images(grid)) PDI_ARRAY(owner, grid, source_node, grid->total, "1");
    PDI_ARRAY_GROWING(owner, grid, circumference, grid->padded[PD_DIM - 1], "m");
}

/* 1: x [m] lies in shape `index` or on its surface; 0: outside, or index -1 (none). *touched grows by one when x is on
 * the surface. */
static int pdi_grid_is_in_shape(const pd_grid *grid, int index, const double *x, int64_t *touched)
{
    if (index < 0) return 0;
    double distance = pd_shape_distance(grid->shapes, index, x), tolerance = pd_shape_surface_tolerance(grid->h, x);
    *touched += fabs(distance) <= tolerance;
    return distance <= tolerance;
}

/* Kind of a node of the box at x [m] by the shapes: wall before metal before fluid. Counts in nodes_on_surface. */
static uint8_t pdi_grid_classify_point(pd_grid *grid, const double *x)
{
    if (pdi_grid_is_in_shape(grid, grid->wall, x, &grid->nodes_on_surface[1])) return PD_WALL;
    return pdi_grid_is_in_shape(grid, grid->solid, x, &grid->nodes_on_surface[0]) ? PD_SOLID : PD_FLUID;
}

/* Does the work of pd_grid_build on an overwritten grid; on failure the caller frees what it has allocated. Kinds are
 * set in the order: nodes of the box, ghosts, inactive nodes. */
static pd_status pdi_grid_build_inner(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid_desc *desc, pd_grid *grid)
{
    memset(grid, 0, sizeof *grid);
    if ((desc->solid || desc->wall) && !desc->shapes)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "grid",
                       "solid and wall point into shapes, which is NULL: an array of shapes is expected");
    PD_TRY(pdi_grid_set_size(ctx, stencil, desc, grid));
    if (desc->axisymmetric) PD_TRY(pdi_grid_compute_circumferences(ctx, grid));
    grid->shapes = desc->shapes;
    grid->solid = desc->solid ? (int)(desc->solid - desc->shapes) : -1;
    grid->wall = desc->wall ? (int)(desc->wall - desc->shapes) : -1;
    grid->is_inlet = desc->is_inlet;
    grid->is_inlet_user = desc->is_inlet_user;
    if (grid->solid >= 0) PD_TRY(pdi_grid_check_solid(ctx, grid));
    PD_TRY(pdi_array_registry_build(ctx, pdi_grid_list_arrays, grid));
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        double x[PD_DIM];
        if (node % PDI_GRID_POLL_INTERVAL == 0) PD_TRY(pd_check_cancel(ctx, "grid", node));
        pd_grid_index(grid, node, i);
        if (!pd_grid_is_inside(grid, i)) continue;
        pd_grid_position(grid, node, x);
        grid->kind[node] = pdi_grid_classify_point(grid, x);
    }
    grid->fluid_count = pdi_grid_count_kind(grid, PD_FLUID);
    grid->solid_count = pdi_grid_count_kind(grid, PD_SOLID);
    if (grid->solid >= 0 && grid->solid_count == 0)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "grid",
                       "the solid covers no node: it is thinner than the spacing or lies inside the wall");
    if (grid->fluid_count + grid->solid_count == 0)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "grid", "the wall covers every node of the box");
    for (int32_t node = 0; grid->source_node && node < grid->total; node++) {
        int flip;
        grid->source_node[node] = pd_grid_find_source(grid, node, &flip);
    }
    pdi_grid_set_ghost_kinds(grid);
    pdi_grid_mark_mixed_sides(grid);
    pdi_grid_mark_outside(stencil, grid);
    return PD_OK;
}

pd_status pd_grid_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid_desc *desc, pd_grid *grid)
{
    pd_status status = pdi_grid_build_inner(ctx, stencil, desc, grid);
    if (status < 0) pd_grid_free(ctx, grid);
    return status;
}
PDI_COLD_END

/* 1: the kind of a node with index j along axis d depends on a box node with index i: it is the node or a ghost that
 * it is the source of. */
static int pdi_grid_is_dependent(const pd_grid *grid, int d, int i, int j)
{
    if (j >= 0 && j < grid->n[d]) return i == j;
    pd_side side = grid->side[2 * d + (j < 0 ? 0 : 1)];
    if (side == PD_SIDE_WALL) return 0;
    pdi_grid_fold_axis(grid, d, 1, &j);
    return i == j;
}

/* Next index after j (-ghost - 1: the first one), along axis d, of a node that depends on the box node with index i; at
 * least n[d] + ghost: there is none. */
static int pdi_grid_next_dependent(const pd_grid *grid, int d, int i, int j)
{
    int end = grid->n[d] + grid->ghost;
    do j = j == -1 ? i : j == i ? grid->n[d] : j + 1;
    while (j < end && !pdi_grid_is_dependent(grid, d, i, j));
    return j;
}

PDI_FN void pdi_grid_set_fluid(pd_grid *grid, int32_t node)
{
    int i[PD_DIM], j[PD_DIM], d;
    grid->kind[node] = PD_FLUID;
    grid->solid_count--;
    grid->fluid_count++;
    pd_grid_index(grid, node, i);
    int ghost = grid->ghost;
    for (d = 0; d < PD_DIM; d++) j[d] = -ghost - 1;
    /* all combinations of followers along the axes */
    for (d = 0; d >= 0;) {
        j[d] = pdi_grid_next_dependent(grid, d, i[d], j[d]);
        if (j[d] >= grid->n[d] + ghost) {
            j[d--] = -ghost - 1;
            continue;
        }
        if (++d < PD_DIM) continue;
        d = PD_DIM - 1;
        if (pd_grid_is_inside(grid, j)) continue;
        int32_t ghost_node = pd_grid_node(grid, j);
        grid->kind[ghost_node] = pdi_grid_get_ghost_kind(grid, ghost_node);
    }
}

enum { PDI_GRID_SUM_PARTS = 64 }; /* of a sum, by layers */

/* Body of one thread: part [PDI_GRID_SUM_PARTS] = compensated sums of the field, times circumferences, over the nodes
 * of pdi_grid_sum_field in each part of the layers along the last axis. */
static void pdi_grid_sum_layers(const pd_grid *grid, uint8_t kind, const uint8_t *which, int wanted,
                                const double *field, pdi_compensated_sum *part)
{
    int64_t layers = grid->padded[PD_DIM - 1], nodes = grid->stride[PD_DIM - 1];
    PDI_FOR_NOWAIT
    for (int q = 0; q < PDI_GRID_SUM_PARTS; q++) {
        part[q].sum = part[q].compensation = 0.0;
        for (int64_t layer = layers * q / PDI_GRID_SUM_PARTS; layer < layers * (q + 1) / PDI_GRID_SUM_PARTS; layer++) {
            int64_t at = layer * nodes;
            double sum = pdi_par_sum_where(nodes, grid->kind + at, kind, which ? which + at : grid->kind + at,
                                           which ? (uint8_t)wanted : kind, field + at);
            pdi_compensated_sum_add(&part[q], sum * pd_grid_circumference(grid, (int32_t)at));
        }
    }
}

PDI_FN double pdi_grid_sum_field(const pd_ctx *ctx, const pd_grid *grid, uint8_t kind, const uint8_t *which, int wanted,
                                 const double *field)
{
    pdi_compensated_sum part[PDI_GRID_SUM_PARTS], all = {0.0, 0.0};
    int nt = pd_par_threads(ctx, grid->total);
    PDI_PARALLEL_CALL(nt, pdi_grid_sum_layers(grid, kind, which, wanted, field, part));
    for (int q = 0; q < PDI_GRID_SUM_PARTS; q++) {
        pdi_compensated_sum_add(&all, part[q].sum);
        pdi_compensated_sum_add(&all, part[q].compensation);
    }
    return pdi_compensated_sum_total(&all);
}

void pd_grid_free(pd_ctx *ctx, pd_grid *grid)
{
    pdi_array_registry_free(ctx, pdi_grid_list_arrays, grid);
    memset(grid, 0, sizeof *grid);
}

PDI_FN void pdi_grid_compute_line_shifts(const pd_grid *grid, const pd_stencil *stencil, int32_t *shift)
{
    for (int l = 0; l < stencil->line_first[stencil->line_kinds]; l++) {
        shift[l] = 0;
        for (int d = 1; d < PD_DIM; d++) shift[l] += stencil->line[l * PD_DIM + d] * grid->stride[d];
    }
}
