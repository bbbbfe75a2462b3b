/* media: see media.h */
#include "lattice/media.h"
#include "core/bracket.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* [cells] The search for surfaces on a bond stops at parts of this length: thinner layers may be missed. */
#define PDI_MEDIA_THIN 0.0625
/* [cells] The diffusivities on both sides of a surface are evaluated at this distance from it. */
#define PDI_MEDIA_BESIDE 1e-3
/* [-] Two lengths that differ by this fraction are equal. */
#define PDI_MEDIA_TIE 1e-9
/* [-] The squared gradient of a distance is 1. Below this value the differences on both sides of a node cancel, between
 * two parts of the surface. */
#define PDI_MEDIA_CANCELLED 0.4

/* A straight segment from x to x + xi. */
typedef struct pdi_media_way {
    const pd_media *media;
    double x[PD_DIM], xi[PD_DIM]; /* [m] */
    double from, length;          /* [-] fraction of it where the present material begins; [m] its length */
    double near, far;             /* [m2/s] diffusivity at both ends; NaN: unknown */
} pdi_media_way;

/* Evaluates a function at a fraction of the segment. Behind sides that are not walls positions are folded into the
 * box, so materials repeat as the kinds of ghosts do. */
static double pdi_media_ask(const pdi_media_way *w, pd_point_fn fn, double fraction)
{
    double x[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) x[d] = w->x[d] + fraction * w->xi[d];
    pdi_grid_fold_position(w->media->grid, x);
    return fn(w->media->user, x);
}

/* Signed distance [m] from the surface at a fraction of the segment. */
static double pdi_media_level(const pdi_media_way *w, double fraction)
{
    return pdi_media_ask(w, w->media->level, fraction);
}

/* Side of the surface at a fraction of the segment, where its signed distance is `level` [m]: -1, 1, or 0 on it. */
static int pdi_media_side(const pdi_media_way *w, double fraction, double level)
{
    double x[PD_DIM], tolerance;
    for (int d = 0; d < PD_DIM; d++) x[d] = w->x[d] + fraction * w->xi[d];
    tolerance = pdi_shape_tie(w->media->grid->h, x);
    return (level > tolerance) - (level < -tolerance);
}

/* Fraction between lo and hi at which the segment intersects the surface; flo, fhi: signed distances there [m]. */
static double pdi_media_root(const pdi_media_way *w, double lo, double hi, double flo, double fhi)
{
    double scale = fabs(flo) + fabs(fhi), t = lo, f = scale;
    if (!(flo * fhi < 0.0)) return lo; /* it starts on the surface */
    pdi_bracket s = {lo, flo, hi, fhi, 0, 0};
    while (fabs(f) > 1e-14 * scale && pdi_bracket_next(&s, &t)) {
        f = pdi_media_level(w, t);
        pdi_bracket_take(&s, t, f);
    }
    return t;
}

/* Diffusivity [m2/s] of a segment 0 .. end that lies within the surface: the mean of both sides. */
static double pdi_media_within(const pdi_media_way *w, double end)
{
    const pd_media *m = w->media;
    double normal[PD_DIM], eps = PDI_MEDIA_BESIDE * m->smallest, sum = 0.0;
    pdi_media_way across = *w;
    for (int d = 0; d < PD_DIM; d++) across.x[d] += 0.5 * end * w->xi[d];
    for (int d = 0; d < PD_DIM; d++) {
        for (int a = 0; a < PD_DIM; a++) across.xi[a] = a == d ? eps : 0.0;
        normal[d] = pdi_media_level(&across, 1.0) - pdi_media_level(&across, -1.0);
    }
    double length = pdi_vec_norm(normal);
    if (!(length > PDI_MEDIA_TIE * eps)) return pdi_media_ask(w, m->field, 0.5 * end);
    for (int d = 0; d < PD_DIM; d++) across.xi[d] = eps * normal[d] / length;
    for (int up = -1; up < 2; up += 2) sum += 0.5 * pdi_media_ask(&across, m->field, up);
    return sum;
}

/* Resistance over length [s/m2] of the segment from the start of the present material to the fraction `to`, within
 * that material; the parts at the ends of the segment have the diffusivity of the node there. */
static double pdi_media_resist(const pdi_media_way *w, double to, double end)
{
    double d, near = w->from > 0.0 ? (double)NAN : w->near, far = to < end ? (double)NAN : w->far;
    if (near >= 0.0 && far >= 0.0) d = pdi_media_harmonic(near, far);
    else if (near >= 0.0) d = near;
    else if (far >= 0.0) d = far;
    else d = pdi_media_ask(w, w->media->field, 0.5 * (w->from + to));
    return d > 0.0 ? (to - w->from) / d : HUGE_VAL;
}

/* ---- integral over the materials on a segment ---- */

/* State of the integration over a segment from 0 to `end`. */
typedef struct pdi_media_walk {
    pdi_media_way *way;
    double end;
    int cell;         /* 1: integral of the diffusivity [m2/s]; 0: of the resistance [s/m2] */
    double sum;       /* [m2/s] or [s/m2] integral so far */
    int side;         /* side of the last point off the surface; 0: none so far */
    double at, level; /* [-], [m] fraction and signed distance of the last point */
} pdi_media_walk;

/* Adds the part from the start of the present material to the fraction `to`. */
static void pdi_media_piece(pdi_media_walk *state, double to)
{
    pdi_media_way *w = state->way;
    if (state->cell) state->sum += (to - w->from) * pdi_media_ask(w, w->media->field, 0.5 * (w->from + to));
    else state->sum += pdi_media_resist(w, to, state->end);
    w->from = to;
}

/* Takes in the next point: finds the surface between it and the last one when they are on different sides, and adds
 * the material that ends there. */
static void pdi_media_reach_place(pdi_media_walk *state, double at, double level)
{
    int beyond = pdi_media_side(state->way, at, level);
    if (at >= state->end && beyond == 0) state->way->far = (double)NAN;
    if (state->side * beyond < 0)
        pdi_media_piece(state, pdi_media_root(state->way, state->at, at, state->level, level));
    if (beyond) state->side = beyond;
    state->at = at;
    state->level = level;
}

/* Integrates from the last point to `to` by bisection, until no surface can be missed: the distances at both ends are
 * bounds (Lipschitz constant 1). The points are the same from whichever end the segment begins. */
static void pdi_media_follow(pdi_media_walk *state, double to, double level)
{
    const pd_media *m = state->way->media;
    double from = state->at, part = (to - from) * state->way->length * (1.0 - PDI_MEDIA_TIE);
    if (part > fabs(state->level) + fabs(level) && part > PDI_MEDIA_THIN * m->smallest) {
        double middle = 0.5 * (from + to);
        pdi_media_follow(state, middle, pdi_media_level(state->way, middle));
        pdi_media_follow(state, to, level);
    } else pdi_media_reach_place(state, to, level);
}

/* Integral over 0 .. end of the diffusivity (cell 1) or the resistance (cell 0). *side: 0 when the segment lies
 * within the surface. */
static double pdi_media_sum(pdi_media_way *w, double end, int cell, int *side)
{
    pdi_media_walk state = {w, end, cell, 0.0, 0, 0.0, pdi_media_level(w, 0.0)};
    state.side = pdi_media_side(w, 0.0, state.level);
    if (state.side == 0) w->near = (double)NAN;
    w->from = 0.0;
    pdi_media_follow(&state, end, pdi_media_level(w, end));
    *side = state.side;
    if (state.side && w->from < end) pdi_media_piece(&state, end);
    return state.sum;
}

/* Mean diffusivity [m2/s] of the segment 0 .. end: resistances in series (eq. 5.8). */
static double pdi_media_mean(pdi_media_way *w, double end)
{
    int side;
    double sum = pdi_media_sum(w, end, 0, &side);
    return side ? end / sum : pdi_media_within(w, end);
}

/* Sets the segment to bond k of node i. */
static void pdi_media_start(const pd_media *m, int32_t i, int k, pdi_media_way *w)
{
    w->media = m;
    pd_grid_position(m->grid, i, w->x);
    memcpy(w->xi, m->stencil->xi + k * PD_DIM, sizeof w->xi);
    w->length = pdi_vec_norm(w->xi);
    w->from = 0.0;
    w->near = m->at[i];
    w->far = (double)NAN;
}

PDI_FN double pdi_media_part(const pd_media *m, int32_t i, int k, double end)
{
    pdi_media_way w;
    if (!m->along) return m->at[i];
    pdi_media_start(m, i, k, &w);
    return fabs(pdi_media_level(&w, 0.0)) > end * w.length ? m->at[i] : pdi_media_mean(&w, end);
}

/* 1: the node can take part in diffusion: it is no wall. A ghost whose source is metal takes part, as it opens when the
 * metal dissolves. */
static int pdi_media_takes(const pd_grid *grid, int32_t i)
{
    int at[PD_DIM];
    if (grid->kind[i] != PD_OUTSIDE && grid->kind[i] != PD_WALL) return 1;
    pdi_grid_index(grid, i, at);
    for (int d = 0; d < PD_DIM; d++)
        if ((at[d] < 0 && grid->side[2 * d] == PD_SIDE_WALL) ||
            (at[d] >= grid->n[d] && grid->side[2 * d + 1] == PD_SIDE_WALL))
            return 0;
    return !pdi_grid_inside(grid, at) && grid->kind[pdi_grid_image(grid, i, NULL)] == PD_SOLID;
}

/* Node at `times` bonds k from node i; -1: outside of the arrays, or a wall. */
static int32_t pdi_media_reach(const pd_media *m, int32_t i, int k, int times)
{
    int at[PD_DIM];
    pdi_grid_index(m->grid, i, at);
    for (int d = 0; d < PD_DIM; d++) {
        at[d] += times * m->stencil->offset[k * PD_DIM + d];
        if (at[d] < -m->grid->ghost || at[d] >= m->grid->n[d] + m->grid->ghost) return -1;
    }
    int32_t j = pd_grid_node(m->grid, at);
    return pdi_media_takes(m->grid, j) ? j : -1;
}

/* Node at the far end of bond k of node i; -1: outside of the arrays, or a wall. */
static int32_t pdi_media_far(const pd_media *m, int32_t i, int k) { return pdi_media_reach(m, i, k, 1); }

/* Computes the diffusivities of all bonds of node i, which has a row; writes the same number for the opposite bond of
 * the far end. */
static void pdi_media_row(pd_media *m, int32_t i)
{
    int count = m->stencil->count;
    double *row = m->along + (int64_t)m->near[i] * count;
    for (int k = 0; k < count; k++) {
        pdi_media_way w;
        int32_t j = pdi_media_far(m, i, k);
        if (j < 0 || (k >= count / 2 && m->near[j] >= 0)) continue;
        pdi_media_start(m, i, k, &w);
        w.far = m->at[j];
        row[k] = pdi_media_mean(&w, 1.0);
        if (m->near[j] >= 0) m->along[(int64_t)m->near[j] * count + count - 1 - k] = row[k];
    }
}

#if PD_DIM > 1
/* ---- conduction along a surface that is normal to an axis (eq. 5.14) ---- */

/* Correction of the diffusivity of the bonds of a node parallel to such a surface: sum of x[a] e_a^2, e the
 * direction. */
typedef struct pdi_media_lift {
    int axis;         /* normal to the surface; -1: it is inclined, no correction */
    double x[PD_DIM]; /* [m2/s] */
} pdi_media_lift;

/* Axis normal to the surface near node i, to rounding; -1: the surface is inclined. Where two parts of it are equally
 * near on both sides of the node, central differences cancel, and the axis is that along which the distance changes. */
static int pdi_media_axis(const pd_media *m, int32_t i)
{
    double gradient[PD_DIM], change[PD_DIM], length = 0.0, changes = 0.0;
    pdi_media_way w;
    w.media = m;
    pd_grid_position(m->grid, i, w.x);
    for (int d = 0; d < PD_DIM; d++) {
        double eps = PDI_MEDIA_BESIDE * m->grid->h[d], here, up, down;
        for (int a = 0; a < PD_DIM; a++) w.xi[a] = a == d ? eps : 0.0;
        here = pdi_media_level(&w, 0.0);
        up = pdi_media_level(&w, 1.0);
        down = pdi_media_level(&w, -1.0);
        gradient[d] = 0.5 * (up - down) / eps;
        change[d] = pdi_max(fabs(up - here), fabs(here - down)) / eps;
        length += gradient[d] * gradient[d];
        changes += change[d] * change[d];
    }
    const double *normal = length > PDI_MEDIA_CANCELLED ? gradient : change;
    if (normal == change) length = changes;
    for (int d = 0; d < PD_DIM; d++)
        if (normal[d] * normal[d] > (1.0 - PDI_MEDIA_TIE) * length) return d;
    return -1;
}

/* Mean diffusivity [m2/s] of the cell of node i along `axis`, material by material. */
static double pdi_media_cell(const pd_media *m, int32_t i, int axis)
{
    pdi_media_way w;
    int side;
    w.media = m;
    pd_grid_position(m->grid, i, w.x);
    for (int d = 0; d < PD_DIM; d++) w.xi[d] = d == axis ? m->grid->h[d] : 0.0;
    w.x[axis] -= 0.5 * m->grid->h[axis];
    w.length = m->grid->h[axis];
    w.near = w.far = (double)NAN;
    double sum = pdi_media_sum(&w, 1.0, 1, &side);
    return side ? sum : pdi_media_within(&w, 1.0);
}

/* Mean diffusivity of the cell of node i minus that of the node [m2/s], at least 0, when the surface cuts the cell. The
 * neighbours in the material of higher diffusivity carry this surplus. */
static double pdi_media_surplus(const pd_media *m, int32_t i, int axis)
{
    pdi_media_way w;
    if (m->near[i] < 0) return 0.0;
    pdi_media_start(m, i, m->unit[axis], &w);
    if (pdi_media_side(&w, 0.0, pdi_media_level(&w, 0.0)) == 0) return 0.0;
    return pdi_max(pdi_media_cell(m, i, axis) - m->at[i], 0.0);
}

/* Mean diffusivity [m2/s] of the layer of cells of node i: of its cell, without its surplus and with that of
 * neighbours of lower diffusivity. */
static double pdi_media_layer(const pd_media *m, int32_t i, int axis)
{
    double mean = pdi_media_cell(m, i, axis) - pdi_media_surplus(m, i, axis);
    for (int side = -1; side < 2; side += 2) {
        int32_t j = pdi_media_reach(m, i, m->unit[axis], side);
        int32_t beyond = pdi_media_reach(m, i, m->unit[axis], 2 * side);
        if (j < 0 || !(m->at[i] > m->at[j])) continue;
        int better = beyond >= 0 && m->at[beyond] > m->at[j];
        mean += pdi_media_surplus(m, j, axis) / (better ? 2.0 : 1.0);
    }
    return mean;
}

/* 1: bond k is parallel to surfaces normal to `axis`. */
static int pdi_media_within_bond(const pd_media *m, int k, int axis)
{
    return axis >= 0 && m->stencil->offset[k * PD_DIM + axis] == 0;
}

/* Number of axes along which bond n is the mirror image of bond k; -1: it is no image. A reflection across the surface
 * (along `axis`) counts PD_DIM. */
static int pdi_media_turns(const pd_stencil *s, int n, int k, int axis)
{
    int reflections = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int a = s->offset[n * PD_DIM + d], b = s->offset[k * PD_DIM + d];
        if (a != b && a != -b) return -1;
        if (a != b) reflections += d == axis ? PD_DIM : 1;
    }
    return reflections;
}

/* Diffusivity [m2/s] of bond k of node i, or, where that ends in a wall, the mean of its mirror images with the fewest
 * reflections: what walls cut off is corrected elsewhere (theory: eq. 5.7). */
static double pdi_media_mirrored(const pd_media *m, int32_t i, int k, int axis)
{
    const pd_stencil *s = m->stencil;
    const double *row = m->along + (int64_t)m->near[i] * s->count;
    double sum = 0.0;
    int fewest = 2 * PD_DIM, found = 0;
    if (pdi_media_far(m, i, k) >= 0) return row[k];
    for (int n = 0; n < s->count; n++) {
        int reflections = pdi_media_turns(s, n, k, axis);
        if (reflections < 0 || reflections > fewest || pdi_media_far(m, i, n) < 0) continue;
        if (reflections < fewest) sum = found = 0;
        fewest = reflections;
        sum += row[n];
        found++;
    }
    return found ? sum / found : m->at[i];
}

/* Computes the correction of node i (eq. 5.14). Bonds across the surface are resistances in series, and conduct less
 * along the surface than the materials do; a cell that the surface cuts has the material of its node. The deficit of
 * the moments of the node against the mean of its cell is given to its bonds parallel to the surface. Then the layers
 * together conduct along the surface what the materials do, and nothing changes across it. */
static void pdi_media_lack(const pd_media *m, int32_t i, pdi_media_lift *lift)
{
    const pd_stencil *s = m->stencil;
    double matrix[PD_DIM * PD_DIM], deficit[PD_DIM], inverse[PD_DIM * PD_DIM];
    memset(matrix, 0, sizeof matrix);
    memset(lift->x, 0, sizeof lift->x);
    lift->axis = pdi_media_axis(m, i);
    if (lift->axis < 0) return;
    double mean = pdi_media_layer(m, i, lift->axis);
    for (int a = 0; a < PD_DIM; a++) deficit[a] = a == lift->axis ? 0.0 : mean;
    matrix[lift->axis * PD_DIM + lift->axis] = 1.0;
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double square = pdi_vec_dot(xi, xi);
        double along = pdi_media_mirrored(m, i, k, lift->axis);
        for (int a = 0; a < PD_DIM; a++) {
            if (a == lift->axis) continue;
            deficit[a] -= 0.5 * s->lap[k] * along * xi[a] * xi[a];
            for (int b = 0; b < PD_DIM && pdi_media_within_bond(m, k, lift->axis); b++)
                matrix[a * PD_DIM + b] += 0.5 * s->lap[k] * xi[a] * xi[a] * xi[b] * xi[b] / square;
        }
    }
    if (!(pdi_vec_invert(matrix, inverse) > 0.0)) return;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) lift->x[a] += inverse[a * PD_DIM + b] * deficit[b];
}

/* Adds to bond k of node i, and to its opposite bond, the mean of the corrections of both ends; at least a quarter of
 * the diffusivity stays. */
static void pdi_media_add(const pd_media *m, const pdi_media_lift *lift, int32_t i, int k)
{
    const pd_stencil *s = m->stencil;
    const double *xi = s->xi + k * PD_DIM;
    int32_t j = pdi_media_far(m, i, k), back = s->count - 1 - k;
    double *here = m->along + (int64_t)m->near[i] * s->count + k, more = 0.0;
    int32_t mine = m->near[pdi_grid_image(m->grid, i, NULL)];
    int32_t theirs = j < 0 || m->near[j] < 0 || k > back ? -1 : m->near[pdi_grid_image(m->grid, j, NULL)];
    if (mine < 0 || theirs < 0) return;
    const pdi_media_lift *own = lift + mine, *other = lift + theirs;
    if (!pdi_media_within_bond(m, k, own->axis) || own->axis != other->axis) return;
    for (int a = 0; a < PD_DIM; a++) more += 0.5 * (own->x[a] + other->x[a]) * xi[a] * xi[a] / pdi_vec_dot(xi, xi);
    *here = pdi_max(*here + more, 0.25 * *here);
    m->along[(int64_t)m->near[j] * s->count + back] = *here;
}

/* Computes the corrections of all nodes near the surface, and adds them to their bonds. */
static pd_status pdi_media_raise(pd_ctx *ctx, pd_media *m)
{
    pdi_media_lift *lift = NULL;
    PDI_TRY(PDI_NEW(ctx, "media", m->rows, lift));
    for (int32_t i = 0; i < m->grid->total; i++)
        if (m->near[i] >= 0 && pdi_grid_image(m->grid, i, NULL) == i) pdi_media_lack(m, i, lift + m->near[i]);
    for (int32_t i = 0; i < m->grid->total; i++)
        for (int k = 0; k < m->stencil->count && m->near[i] >= 0; k++)
            pdi_media_add(m, lift, i, k);
    PDI_DELETE(ctx, m->rows, lift);
    return PD_OK;
}
#endif

PDI_FN void pdi_media_list(pdi_owner *owner, void *object)
{
    pd_media *media = (pd_media *)object;
    int32_t total = media->grid ? media->grid->total : 0;
    PDI_ARRAY(owner, media, at, total, "m2/s");
    if (media->level) PDI_ARRAY(owner, media, near, total, "1");
}

PDI_FN void pdi_media_row_list(pdi_owner *owner, void *object)
{
    pd_media *media = (pd_media *)object;
    PDI_ARRAY(owner, media, along, media->rows ? (int64_t)media->rows * media->stencil->count : 0, "m2/s");
}

/* Numbers the nodes within one bond of the surface and computes the diffusivities of their bonds. The tolerance
 * includes all neighbours of a node on the surface, so that both ends of a bond have the same diffusivity. */
static pd_status pdi_media_rows(pd_ctx *ctx, pd_media *m)
{
    double longest = 0.0;
    for (int k = 0; k < m->stencil->count; k++) longest = pdi_max(longest, pdi_vec_norm(m->stencil->xi + k * PD_DIM));
    for (int32_t i = 0; i < m->grid->total; i++) {
        double x[PD_DIM];
        m->near[i] = -1;
        if (!pdi_media_takes(m->grid, i)) continue;
        pd_grid_position(m->grid, i, x);
        pdi_grid_fold_position(m->grid, x);
        if (fabs(m->level(m->user, x)) <= longest + 2.0 * pdi_shape_tie(m->grid->h, x)) m->near[i] = m->rows++;
    }
    if (m->rows == 0) return PD_OK;
    PDI_TRY(pdi_owner_build(ctx, pdi_media_row_list, m));
    for (int32_t i = 0; i < m->grid->total; i++)
        if (m->near[i] >= 0) pdi_media_row(m, i);
#if PD_DIM > 1
    return pdi_media_raise(ctx, m);
#else
    return PD_OK;
#endif
}

PDI_FN pd_status pdi_media_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, pd_point_fn field,
                                 pd_point_fn level, void *user, pd_media *m)
{
    memset(m, 0, sizeof *m);
    m->stencil = stencil;
    m->grid = grid;
    m->field = field;
    m->level = level;
    m->user = user;
    m->smallest = pdi_vec_least(grid->h);
    PDI_TRY(pdi_owner_build(ctx, pdi_media_list, m));
    for (int k = 0; k < stencil->count; k++)
        for (int d = 0; d < PD_DIM; d++) {
            int unit = 1;
            for (int a = 0; a < PD_DIM; a++) unit = unit && stencil->offset[k * PD_DIM + a] == (a == d);
            if (unit) m->unit[d] = k;
        }
    for (int32_t i = 0; i < grid->total; i++) {
        double x[PD_DIM];
        if (grid->kind[i] == PD_OUTSIDE) continue;
        pd_grid_position(grid, i, x);
        pdi_grid_fold_position(grid, x);
        m->at[i] = field(user, x);
        if (!(m->at[i] >= 0.0) || !(m->at[i] < 1e100))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "media",
                            "the diffusivity at x = %g m is %g m2/s, expected a finite value of at least 0", x[0],
                            m->at[i]);
    }
    return level ? pdi_media_rows(ctx, m) : PD_OK;
}

PDI_FN void pdi_media_free(pd_ctx *ctx, pd_media *m)
{
    pdi_owner_free(ctx, pdi_media_list, m);
    pdi_owner_free(ctx, pdi_media_row_list, m);
    memset(m, 0, sizeof *m);
}

#undef PDI_MEDIA_THIN
#undef PDI_MEDIA_BESIDE
#undef PDI_MEDIA_TIE
#undef PDI_MEDIA_CANCELLED
