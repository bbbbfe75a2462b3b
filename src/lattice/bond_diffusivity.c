/* bond_diffusivity: see bond_diffusivity.h */
#include "lattice/bond_diffusivity.h"
#include "core/root_bracket.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* [cells] The search for surfaces on a bond stops at parts of this length: thinner layers may be missed. */
#define PDI_BOND_DIFFUSIVITY_MIN_LAYER 0.0625
/* [cells] The diffusivities on both sides of a surface are evaluated at this distance from it. */
#define PDI_BOND_DIFFUSIVITY_SIDE_OFFSET 1e-3
/* [-] Two lengths that differ by this fraction are equal. */
#define PDI_BOND_DIFFUSIVITY_TOLERANCE 1e-9
/* [-] The squared gradient of a distance is 1. Below this value the differences on both sides of a node cancel, between
 * two parts of the surface. */
#define PDI_BOND_DIFFUSIVITY_MIN_GRADIENT 0.4

/* A straight segment from x to x + xi. */
typedef struct pdi_bond_diffusivity_segment {
    const pd_bond_diffusivity *media;
    double x[PD_DIM], xi[PD_DIM]; /* [m] */
    double material_begin, length;            /* [-] fraction of it where the present material begins; [m] its length */
    double near_diffusivity, far_diffusivity; /* [m2/s] diffusivity at both ends; NaN: unknown */
} pdi_bond_diffusivity_segment;

/* Value of `fn` at a fraction of the segment, which may be negative. Behind sides that are not walls positions are
 * folded into the box, so materials repeat as the kinds of ghosts do. */
static double pdi_bond_diffusivity_evaluate(const pdi_bond_diffusivity_segment *w, pd_point_fn fn, double fraction)
{
    double x[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) x[d] = w->x[d] + fraction * w->xi[d];
    pdi_grid_fold_position(w->media->grid, x);
    return fn(w->media->user, x);
}

/* Signed distance [m] from the surface at a fraction of the segment. */
static double pdi_bond_diffusivity_distance(const pdi_bond_diffusivity_segment *w, double fraction)
{
    return pdi_bond_diffusivity_evaluate(w, w->media->surface_distance, fraction);
}

/* Side of the surface of the point at a fraction of the segment, by its signed distance `level` [m]: the sign of that,
 * -1 or 1; 0: within the tolerance of the surface there. */
static int pdi_bond_diffusivity_find_side(const pdi_bond_diffusivity_segment *w, double fraction, double level)
{
    double x[PD_DIM], tolerance;
    for (int d = 0; d < PD_DIM; d++) x[d] = w->x[d] + fraction * w->xi[d];
    tolerance = pd_shape_surface_tolerance(w->media->grid->h, x);
    return (level > tolerance) - (level < -tolerance);
}

/* Fraction between lo and hi at which the segment intersects the surface, where the distance is at most 1e-14 of |flo|
 * + |fhi|; flo, fhi: signed distances there [m]. lo when these do not have opposite signs (0 included). */
static double pdi_bond_diffusivity_find_surface(const pdi_bond_diffusivity_segment *w, double lo, double hi, double flo,
                                                double fhi)
{
    double scale = fabs(flo) + fabs(fhi), t = lo, f = scale;
    if (!(flo * fhi < 0.0)) return lo; /* it starts on the surface */
    pdi_root_bracket s = {lo, flo, hi, fhi, 0, 0};
    while (fabs(f) > 1e-14 * scale && pdi_root_bracket_get_next(&s, &t)) {
        f = pdi_bond_diffusivity_distance(w, t);
        pdi_root_bracket_update(&s, t, f);
    }
    return t;
}

/* Diffusivity [m2/s] of the part 0 .. end of a segment, which lies within the surface: the arithmetic mean of both
 * sides at its middle, PDI_BOND_DIFFUSIVITY_SIDE_OFFSET spacings along the normal; the value at the middle itself where
 * the surface has no normal (differences of the distance cancel). */
static double pdi_bond_diffusivity_mean_in_surface(const pdi_bond_diffusivity_segment *w, double end)
{
    const pd_bond_diffusivity *m = w->media;
    double normal[PD_DIM], eps = PDI_BOND_DIFFUSIVITY_SIDE_OFFSET * m->min_spacing, sum = 0.0;
    pdi_bond_diffusivity_segment across = *w;
    for (int d = 0; d < PD_DIM; d++) across.x[d] += 0.5 * end * w->xi[d];
    for (int d = 0; d < PD_DIM; d++) {
        for (int a = 0; a < PD_DIM; a++) across.xi[a] = a == d ? eps : 0.0;
        normal[d] = pdi_bond_diffusivity_distance(&across, 1.0) - pdi_bond_diffusivity_distance(&across, -1.0);
    }
    double length = pdi_vec_norm(normal);
    if (!(length > PDI_BOND_DIFFUSIVITY_TOLERANCE * eps))
        return pdi_bond_diffusivity_evaluate(w, m->diffusivity, 0.5 * end);
    for (int d = 0; d < PD_DIM; d++) across.xi[d] = eps * normal[d] / length;
    for (int up = -1; up < 2; up += 2) sum += 0.5 * pdi_bond_diffusivity_evaluate(&across, m->diffusivity, up);
    return sum;
}

/* Resistance [s/m2], over the length of the segment, of its part from the start of the present material to the fraction
 * `to`; HUGE_VAL: the diffusivity is 0. Where they are not NaN, near_diffusivity holds for the first part,
 * far_diffusivity for the last one (to >= end), and their harmonic mean for a part that is both; others have the
 * diffusivity at their middle. */
static double pdi_bond_diffusivity_resistance(const pdi_bond_diffusivity_segment *w, double to, double end)
{
    double d, near = w->material_begin > 0.0 ? (double)NAN : w->near_diffusivity,
              far = to < end ? (double)NAN : w->far_diffusivity;
    if (near >= 0.0 && far >= 0.0) d = pdi_bond_diffusivity_harmonic_mean(near, far);
    else if (near >= 0.0) d = near;
    else if (far >= 0.0) d = far;
    else d = pdi_bond_diffusivity_evaluate(w, w->media->diffusivity, 0.5 * (w->material_begin + to));
    return d > 0.0 ? (to - w->material_begin) / d : HUGE_VAL;
}

/* ---- integral over the materials on a segment ---- */

/* State of the integration over a segment from 0 to `end`. */
typedef struct pdi_bond_diffusivity_integral {
    pdi_bond_diffusivity_segment *segment;
    double end;
    int in_parallel;  /* 1: integral of the diffusivity [m2/s]; 0: of the resistance [s/m2] */
    double integral;  /* [m2/s] or [s/m2] integral so far */
    int side;         /* side of the last point off the surface; 0: none so far */
    double last_fraction, last_distance; /* [-], [m] fraction and signed distance of the last point */
} pdi_bond_diffusivity_integral;

/* Adds the part from the start of the present material to the fraction `to` to the integral; the next material begins
 * there. */
static void pdi_bond_diffusivity_add_material(pdi_bond_diffusivity_integral *state, double to)
{
    pdi_bond_diffusivity_segment *w = state->segment;
    if (state->in_parallel)
        state->integral += (to - w->material_begin) *
                           pdi_bond_diffusivity_evaluate(w, w->media->diffusivity, 0.5 * (w->material_begin + to));
    else state->integral += pdi_bond_diffusivity_resistance(w, to, state->end);
    w->material_begin = to;
}

/* Takes in the next point, at the fraction `at` with the signed distance `level` [m]: finds the surface between it and
 * the last one when they are on different sides, and adds the material that ends there. The last point becomes this
 * one; where it ends the segment on the surface, far_diffusivity becomes NaN. */
static void pdi_bond_diffusivity_add_point(pdi_bond_diffusivity_integral *state, double at, double level)
{
    int beyond = pdi_bond_diffusivity_find_side(state->segment, at, level);
    if (at >= state->end && beyond == 0) state->segment->far_diffusivity = (double)NAN;
    if (state->side * beyond < 0)
        pdi_bond_diffusivity_add_material(state, pdi_bond_diffusivity_find_surface(state->segment, state->last_fraction,
                                                                                   at, state->last_distance, level));
    if (beyond) state->side = beyond;
    state->last_fraction = at;
    state->last_distance = level;
}

/* Integrates from the last point to the fraction `to`, with the signed distance `level` [m]. Halves the part while it
 * is longer than the sum of the |distances| at both ends (they are bounds, Lipschitz constant 1: a surface may be
 * missed) and longer than PDI_BOND_DIFFUSIVITY_MIN_LAYER of the smallest spacing. Thinner layers may be missed. The
 * points are the same from whichever end the segment begins. */
static void pdi_bond_diffusivity_bisect(pdi_bond_diffusivity_integral *state, double to, double level)
{
    const pd_bond_diffusivity *m = state->segment->media;
    double from = state->last_fraction,
           part = (to - from) * state->segment->length * (1.0 - PDI_BOND_DIFFUSIVITY_TOLERANCE);
    if (part > fabs(state->last_distance) + fabs(level) && part > PDI_BOND_DIFFUSIVITY_MIN_LAYER * m->min_spacing) {
        double middle = 0.5 * (from + to);
        pdi_bond_diffusivity_bisect(state, middle, pdi_bond_diffusivity_distance(state->segment, middle));
        pdi_bond_diffusivity_bisect(state, to, level);
    } else pdi_bond_diffusivity_add_point(state, to, level);
}

/* Integral over the fractions 0 .. end of the diffusivity [m2/s] (cell 1) or of its inverse [s/m2] (cell 0). *side:
 * side of the last point off the surface, 1 or -1; 0: all lies within the surface, and the integral is 0. Changes
 * material_begin of the segment; diffusivities of ends on the surface become NaN. */
static double pdi_bond_diffusivity_integrate(pdi_bond_diffusivity_segment *w, double end, int cell, int *side)
{
    pdi_bond_diffusivity_integral state = {w, end, cell, 0.0, 0, 0.0, pdi_bond_diffusivity_distance(w, 0.0)};
    state.side = pdi_bond_diffusivity_find_side(w, 0.0, state.last_distance);
    if (state.side == 0) w->near_diffusivity = (double)NAN;
    w->material_begin = 0.0;
    pdi_bond_diffusivity_bisect(&state, end, pdi_bond_diffusivity_distance(w, end));
    *side = state.side;
    if (state.side && w->material_begin < end) pdi_bond_diffusivity_add_material(&state, end);
    return state.integral;
}

/* Mean diffusivity [m2/s] of the part 0 .. end of the segment: resistances in series (eq. 6.3), 0 where a material does
 * not conduct; pdi_bond_diffusivity_mean_in_surface where all of it lies within the surface. Changes the segment as
 * pdi_bond_diffusivity_integrate does. */
static double pdi_bond_diffusivity_mean_in_series(pdi_bond_diffusivity_segment *w, double end)
{
    int side;
    double sum = pdi_bond_diffusivity_integrate(w, end, 0, &side);
    return side ? end / sum : pdi_bond_diffusivity_mean_in_surface(w, end);
}

/* Sets the segment to bond k of node i; near_diffusivity is that of the node, far_diffusivity NaN. */
static void pdi_bond_diffusivity_init_segment(const pd_bond_diffusivity *m, int32_t i, int k,
                                              pdi_bond_diffusivity_segment *w)
{
    w->media = m;
    pd_grid_position(m->grid, i, w->x);
    memcpy(w->xi, m->stencil->xi + k * PD_DIM, sizeof w->xi);
    w->length = pdi_vec_norm(w->xi);
    w->material_begin = 0.0;
    w->near_diffusivity = m->node_value[i];
    w->far_diffusivity = (double)NAN;
}

PDI_FN double pdi_bond_diffusivity_get_part(const pd_bond_diffusivity *m, int32_t i, int k, double end)
{
    pdi_bond_diffusivity_segment w;
    if (!m->bond_value) return m->node_value[i];
    pdi_bond_diffusivity_init_segment(m, i, k, &w);
    return fabs(pdi_bond_diffusivity_distance(&w, 0.0)) > end * w.length ? m->node_value[i]
                                                                         : pdi_bond_diffusivity_mean_in_series(&w, end);
}

/* 1: the node can take part in diffusion: it is neither wall nor inactive, or it is a ghost whose source is metal, not
 * behind a wall side: it opens when the metal dissolves. 0: others. */
static int pdi_bond_diffusivity_is_member(const pd_grid *grid, int32_t i)
{
    int at[PD_DIM];
    if (grid->kind[i] != PD_INACTIVE && grid->kind[i] != PD_WALL) return 1;
    pd_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++)
        if ((at[d] < 0 && grid->side[2 * d] == PD_SIDE_WALL) ||
            (at[d] >= grid->n[d] && grid->side[2 * d + 1] == PD_SIDE_WALL))
            return 0;
    return !pd_grid_is_inside(grid, at) && grid->kind[pd_grid_find_source(grid, i, NULL)] == PD_SOLID;
}

/* Node (may be a ghost) at `times` bonds k from node i, times < 0: in the opposite direction; -1: outside of the
 * arrays, or it takes no part (pdi_bond_diffusivity_is_member). */
static int32_t pdi_bond_diffusivity_find_node(const pd_bond_diffusivity *m, int32_t i, int k, int times)
{
    int at[PD_DIM];
    pd_grid_index(m->grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        at[d] += times * m->stencil->offset[k * PD_DIM + d];
        if (at[d] < -m->grid->ghost || at[d] >= m->grid->n[d] + m->grid->ghost) return -1;
    }
    int32_t j = pd_grid_node(m->grid, at);
    return pdi_bond_diffusivity_is_member(m->grid, j) ? j : -1;
}

/* Node at the far end of bond k of node i; -1: outside of the arrays, or it takes no part (a wall). */
static int32_t pdi_bond_diffusivity_find_far_node(const pd_bond_diffusivity *m, int32_t i, int k)
{
    return pdi_bond_diffusivity_find_node(m, i, k, 1);
}

/* Computes the diffusivities of the bonds of node i, which has a row, and writes the same number for the opposite bond
 * of a far end with a row. Bonds to walls stay 0; when both ends have rows, bonds k >= count/2 come from the far end.
 */
static void pdi_bond_diffusivity_compute_row(pd_bond_diffusivity *m, int32_t i)
{
    int count = m->stencil->count;
    double *row = m->bond_value + (int64_t)m->row_of_node[i] * count;
    for (int k = 0; k < count; k++) {
        pdi_bond_diffusivity_segment w;
        int32_t j = pdi_bond_diffusivity_find_far_node(m, i, k);
        if (j < 0 || (k >= count / 2 && m->row_of_node[j] >= 0)) continue;
        pdi_bond_diffusivity_init_segment(m, i, k, &w);
        w.far_diffusivity = m->node_value[j];
        row[k] = pdi_bond_diffusivity_mean_in_series(&w, 1.0);
        if (m->row_of_node[j] >= 0) m->bond_value[(int64_t)m->row_of_node[j] * count + count - 1 - k] = row[k];
    }
}

#if PD_DIM > 1
/* ---- conduction along a surface that is normal to an axis (eq. 6.4) ---- */

/* Correction of the diffusivity of the bonds of a node parallel to such a surface: sum of x[a] e_a^2, e the
 * direction. */
typedef struct pdi_bond_diffusivity_correction {
    int axis;         /* normal to the surface; -1: it is inclined, no correction */
    double x[PD_DIM]; /* [m2/s] */
} pdi_bond_diffusivity_correction;

/* Axis normal to the surface near node i: that whose squared component of the gradient of the distance exceeds 1 -
 * PDI_BOND_DIFFUSIVITY_TOLERANCE of the sum; -1: the surface is inclined. Where the squared central gradient is at most
 * PDI_BOND_DIFFUSIVITY_MIN_GRADIENT (two parts of the surface equally near on both sides of the node), the larger
 * one-sided difference along each axis counts instead. */
static int pdi_bond_diffusivity_find_normal_axis(const pd_bond_diffusivity *m, int32_t i)
{
    double gradient[PD_DIM], change[PD_DIM], length = 0.0, changes = 0.0;
    pdi_bond_diffusivity_segment w;
    w.media = m;
    pd_grid_position(m->grid, i, w.x);
    for (int d = 0; d < PD_DIM; d++) {
        double eps = PDI_BOND_DIFFUSIVITY_SIDE_OFFSET * m->grid->h[d], here, up, down;
        for (int a = 0; a < PD_DIM; a++) w.xi[a] = a == d ? eps : 0.0;
        here = pdi_bond_diffusivity_distance(&w, 0.0);
        up = pdi_bond_diffusivity_distance(&w, 1.0);
        down = pdi_bond_diffusivity_distance(&w, -1.0);
        gradient[d] = 0.5 * (up - down) / eps;
        change[d] = pd_max(fabs(up - here), fabs(here - down)) / eps;
        length += gradient[d] * gradient[d];
        changes += change[d] * change[d];
    }
    const double *normal = length > PDI_BOND_DIFFUSIVITY_MIN_GRADIENT ? gradient : change;
    if (normal == change) length = changes;
    for (int d = 0; d < PD_DIM; d++)
        if (normal[d] * normal[d] > (1.0 - PDI_BOND_DIFFUSIVITY_TOLERANCE) * length) return d;
    return -1;
}

/* Mean diffusivity [m2/s] along `axis` over one spacing about node i: arithmetic, each material weighted by its length
 * with the value at its middle; pdi_bond_diffusivity_mean_in_surface where all of it lies within the surface. */
static double pdi_bond_diffusivity_cell_mean(const pd_bond_diffusivity *m, int32_t i, int axis)
{
    pdi_bond_diffusivity_segment w;
    int side;
    w.media = m;
    pd_grid_position(m->grid, i, w.x);
    for (int d = 0; d < PD_DIM; d++) w.xi[d] = d == axis ? m->grid->h[d] : 0.0;
    w.x[axis] -= 0.5 * m->grid->h[axis];
    w.length = m->grid->h[axis];
    w.near_diffusivity = w.far_diffusivity = (double)NAN;
    double sum = pdi_bond_diffusivity_integrate(&w, 1.0, 1, &side);
    return side ? sum : pdi_bond_diffusivity_mean_in_surface(&w, 1.0);
}

/* Mean diffusivity of the cell of node i along `axis` minus that of the node [m2/s], at least 0; 0 when the node has no
 * row or lies on the surface. The neighbours in the material of higher diffusivity carry this surplus. */
static double pdi_bond_diffusivity_cell_surplus(const pd_bond_diffusivity *m, int32_t i, int axis)
{
    pdi_bond_diffusivity_segment w;
    if (m->row_of_node[i] < 0) return 0.0;
    pdi_bond_diffusivity_init_segment(m, i, m->unit_bond[axis], &w);
    if (pdi_bond_diffusivity_find_side(&w, 0.0, pdi_bond_diffusivity_distance(&w, 0.0)) == 0) return 0.0;
    return pd_max(pdi_bond_diffusivity_cell_mean(m, i, axis) - m->node_value[i], 0.0);
}

/* Mean diffusivity [m2/s] of the layer of cells of node i: of its cell along `axis`, without its surplus and with that
 * of both neighbours of lower diffusivity; half of that where the node behind such a neighbour is above it in
 * diffusivity, too. */
static double pdi_bond_diffusivity_layer_mean(const pd_bond_diffusivity *m, int32_t i, int axis)
{
    double mean = pdi_bond_diffusivity_cell_mean(m, i, axis) - pdi_bond_diffusivity_cell_surplus(m, i, axis);
    for (int side = -1; side < 2; side += 2) {
        int32_t j = pdi_bond_diffusivity_find_node(m, i, m->unit_bond[axis], side);
        int32_t beyond = pdi_bond_diffusivity_find_node(m, i, m->unit_bond[axis], 2 * side);
        if (j < 0 || !(m->node_value[i] > m->node_value[j])) continue;
        int better = beyond >= 0 && m->node_value[beyond] > m->node_value[j];
        mean += pdi_bond_diffusivity_cell_surplus(m, j, axis) / (better ? 2.0 : 1.0);
    }
    return mean;
}

/* 1: bond k is parallel to surfaces normal to `axis`. */
static int pdi_bond_diffusivity_is_bond_parallel(const pd_bond_diffusivity *m, int k, int axis)
{
    return axis >= 0 && m->stencil->offset[k * PD_DIM + axis] == 0;
}

/* Number of axes along which bond n is the mirror image of bond k; -1: it is no image. A reflection across the surface
 * (along `axis`) counts PD_DIM. */
static int pdi_bond_diffusivity_count_reflections(const pd_stencil *s, int n, int k, int axis)
{
    int reflections = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int a = s->offset[n * PD_DIM + d], b = s->offset[k * PD_DIM + d];
        if (a != b && a != -b) return -1;
        if (a != b) reflections += d == axis ? PD_DIM : 1;
    }
    return reflections;
}

/* Diffusivity [m2/s] of bond k of node i, which has a row; where it ends in a wall, the mean of its mirror images with
 * the fewest reflections that do not (across `axis` only for want of others), or that of the node when all do: what
 * walls cut off is corrected elsewhere (theory: eq. 6.8). */
static double pdi_bond_diffusivity_get_mirrored(const pd_bond_diffusivity *m, int32_t i, int k, int axis)
{
    const pd_stencil *s = m->stencil;
    const double *row = m->bond_value + (int64_t)m->row_of_node[i] * s->count;
    double sum = 0.0;
    int fewest = 2 * PD_DIM, found = 0;
    if (pdi_bond_diffusivity_find_far_node(m, i, k) >= 0) return row[k];
    for (int n = 0; n < s->count; n++) {
        int reflections = pdi_bond_diffusivity_count_reflections(s, n, k, axis);
        if (reflections < 0 || reflections > fewest || pdi_bond_diffusivity_find_far_node(m, i, n) < 0) continue;
        if (reflections < fewest) sum = found = 0;
        fewest = reflections;
        sum += row[n];
        found++;
    }
    return found ? sum / found : m->node_value[i];
}

/* Computes the correction of node i (eq. 6.4): lift->axis, -1 where the surface is inclined, and lift->x, 0 then and
 * where the moments are singular. Bonds across the surface are resistances in series and conduct less along it than the
 * materials do; a cut cell has the material of its node. The deficit of the moments of the node against the mean of its
 * layer goes to its bonds parallel to the surface. So the layers together conduct along it what the materials do, and
 * nothing changes across it. */
static void pdi_bond_diffusivity_compute_correction(const pd_bond_diffusivity *m, int32_t i,
                                                    pdi_bond_diffusivity_correction *lift)
{
    const pd_stencil *s = m->stencil;
    double matrix[PD_DIM * PD_DIM], deficit[PD_DIM], inverse[PD_DIM * PD_DIM];
    memset(matrix, 0, sizeof matrix);
    memset(lift->x, 0, sizeof lift->x);
    lift->axis = pdi_bond_diffusivity_find_normal_axis(m, i);
    if (lift->axis < 0) return;
    double mean = pdi_bond_diffusivity_layer_mean(m, i, lift->axis);
    for (int a = 0; a < PD_DIM; a++) deficit[a] = a == lift->axis ? 0.0 : mean;
    matrix[lift->axis * PD_DIM + lift->axis] = 1.0;
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double square = pdi_vec_dot(xi, xi);
        double along = pdi_bond_diffusivity_get_mirrored(m, i, k, lift->axis);
        for (int a = 0; a < PD_DIM; a++) {
            if (a == lift->axis) continue;
            deficit[a] -= 0.5 * s->laplacian_weight[k] * along * xi[a] * xi[a];
            for (int b = 0; b < PD_DIM && pdi_bond_diffusivity_is_bond_parallel(m, k, lift->axis); b++)
                matrix[a * PD_DIM + b] += 0.5 * s->laplacian_weight[k] * xi[a] * xi[a] * xi[b] * xi[b] / square;
        }
    }
    if (!(pdi_vec_invert(matrix, inverse) > 0.0)) return;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) lift->x[a] += inverse[a * PD_DIM + b] * deficit[b];
}

/* Adds to bond k of node i, and to its opposite bond, the mean of the corrections lift [rows] of both ends; at least a
 * quarter of the diffusivity stays. Nothing changes for k >= count/2 (it is the opposite bond of another one), without
 * a row at both ends, or unless the bond is parallel to the surface of both. */
static void pdi_bond_diffusivity_add_correction(const pd_bond_diffusivity *m,
                                                const pdi_bond_diffusivity_correction *lift, int32_t i, int k)
{
    const pd_stencil *s = m->stencil;
    const double *xi = s->xi + k * PD_DIM;
    int32_t j = pdi_bond_diffusivity_find_far_node(m, i, k), back = s->count - 1 - k;
    double *here = m->bond_value + (int64_t)m->row_of_node[i] * s->count + k, more = 0.0;
    int32_t mine = m->row_of_node[pd_grid_find_source(m->grid, i, NULL)];
    int32_t theirs =
        j < 0 || m->row_of_node[j] < 0 || k > back ? -1 : m->row_of_node[pd_grid_find_source(m->grid, j, NULL)];
    if (mine < 0 || theirs < 0) return;
    const pdi_bond_diffusivity_correction *own = lift + mine, *other = lift + theirs;
    if (!pdi_bond_diffusivity_is_bond_parallel(m, k, own->axis) || own->axis != other->axis) return;
    for (int a = 0; a < PD_DIM; a++) more += 0.5 * (own->x[a] + other->x[a]) * xi[a] * xi[a] / pdi_vec_dot(xi, xi);
    *here = pd_max(*here + more, 0.25 * *here);
    m->bond_value[(int64_t)m->row_of_node[j] * s->count + back] = *here;
}

/* Computes the corrections of all nodes of the box near the surface, and adds them to their bonds; ghosts have that of
 * their source. Only out of memory fails, before any change. */
static pd_status pdi_bond_diffusivity_correct_bonds(pd_ctx *ctx, pd_bond_diffusivity *m)
{
    pdi_bond_diffusivity_correction *lift = NULL;
    PD_TRY(PD_NEW(ctx, "media", m->rows, lift));
    for (int32_t i = 0; i < m->grid->total; i++)
        if (m->row_of_node[i] >= 0 && pd_grid_find_source(m->grid, i, NULL) == i)
            pdi_bond_diffusivity_compute_correction(m, i, lift + m->row_of_node[i]);
    for (int32_t i = 0; i < m->grid->total; i++)
        for (int k = 0; k < m->stencil->count && m->row_of_node[i] >= 0; k++)
            pdi_bond_diffusivity_add_correction(m, lift, i, k);
    PD_DELETE(ctx, m->rows, lift);
    return PD_OK;
}
#endif

PDI_FN void pdi_bond_diffusivity_list_node_arrays(pdi_array_visitor *owner, void *object)
{
    pd_bond_diffusivity *media = (pd_bond_diffusivity *)object;
    int32_t total = media->grid ? media->grid->total : 0;
    PDI_ARRAY(owner, media, node_value, total, "m2/s");
    if (media->surface_distance) PDI_ARRAY(owner, media, row_of_node, total, "1");
}

PDI_FN void pdi_bond_diffusivity_list_row_arrays(pdi_array_visitor *owner, void *object)
{
    pd_bond_diffusivity *media = (pd_bond_diffusivity *)object;
    PDI_ARRAY(owner, media, bond_value, media->rows ? (int64_t)media->rows * media->stencil->count : 0, "m2/s");
}

/* Numbers the nodes within one bond of the surface (rows, row_of_node; -1: others), ghosts included and walls not, and
 * allocates and computes the diffusivities of their bonds, with the correction of eq. 6.4 (not in 1D). bond_value
 * stays NULL when there are none. The tolerance includes all neighbours of a node on the surface, so that both ends of
 * a bond have the same diffusivity. */
static pd_status pdi_bond_diffusivity_build_rows(pd_ctx *ctx, pd_bond_diffusivity *m)
{
    double longest = 0.0;
    for (int k = 0; k < m->stencil->count; k++) longest = pd_max(longest, pdi_vec_norm(m->stencil->xi + k * PD_DIM));
    for (int32_t i = 0; i < m->grid->total; i++) {
        double x[PD_DIM];
        m->row_of_node[i] = -1;
        if (!pdi_bond_diffusivity_is_member(m->grid, i)) continue;
        pd_grid_position(m->grid, i, x);
        pdi_grid_fold_position(m->grid, x);
        if (fabs(m->surface_distance(m->user, x)) <= longest + 2.0 * pd_shape_surface_tolerance(m->grid->h, x))
            m->row_of_node[i] = m->rows++;
    }
    if (m->rows == 0) return PD_OK;
    PD_TRY(pdi_array_registry_build(ctx, pdi_bond_diffusivity_list_row_arrays, m));
    for (int32_t i = 0; i < m->grid->total; i++)
        if (m->row_of_node[i] >= 0) pdi_bond_diffusivity_compute_row(m, i);
#if PD_DIM > 1
    return pdi_bond_diffusivity_correct_bonds(ctx, m);
#else
    return PD_OK;
#endif
}

PDI_FN pd_status pdi_bond_diffusivity_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid,
                                            pd_point_fn field, pd_point_fn level, void *user, pd_bond_diffusivity *m)
{
    memset(m, 0, sizeof *m);
    m->stencil = stencil;
    m->grid = grid;
    m->diffusivity = field;
    m->surface_distance = level;
    m->user = user;
    m->min_spacing = pdi_vec_min(grid->h);
    PD_TRY(pdi_array_registry_build(ctx, pdi_bond_diffusivity_list_node_arrays, m));
    for (int k = 0; k < stencil->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            int unit = 1;
            for (int a = 0; a < PD_DIM; a++) unit = unit && stencil->offset[k * PD_DIM + a] == (a == d);
            if (unit) m->unit_bond[d] = k;
        }
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM];
        if (grid->kind[i] == PD_INACTIVE) continue;
        pd_grid_position(grid, i, x);
        pdi_grid_fold_position(grid, x);
        m->node_value[i] = field(user, x);
        if (!(m->node_value[i] >= 0.0) || !(m->node_value[i] < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "media",
                           "the diffusivity at x = %g m is %g m2/s, expected a finite value of at least 0", x[0],
                           m->node_value[i]);
    }
    return level ? pdi_bond_diffusivity_build_rows(ctx, m) : PD_OK;
}

PDI_FN void pdi_bond_diffusivity_free(pd_ctx *ctx, pd_bond_diffusivity *m)
{
    pdi_array_registry_free(ctx, pdi_bond_diffusivity_list_node_arrays, m);
    pdi_array_registry_free(ctx, pdi_bond_diffusivity_list_row_arrays, m);
    memset(m, 0, sizeof *m);
}

#undef PDI_BOND_DIFFUSIVITY_MIN_LAYER
#undef PDI_BOND_DIFFUSIVITY_SIDE_OFFSET
#undef PDI_BOND_DIFFUSIVITY_TOLERANCE
#undef PDI_BOND_DIFFUSIVITY_MIN_GRADIENT
