/* interpenetration: see interpenetration.h */
#include "couple/interpenetration.h"
#include "solid/body_bonds.h"
#include "core/vec.h"
#include "lattice/node_visibility.h"
#include <math.h>
#include <string.h>

/* Shortening of bonds that counts as rounding [-]. */
#define PDI_INTERPENETRATION_ROUNDING 1e-6

/* 1: i is a point (not -1) whose metal has not dissolved. */
static int pdi_interpenetration_is_solid(const pd_interpenetration *s, int32_t i)
{
    return i >= 0 && s->stiffness_factor[i] > 0.0;
}

/* 1: no unbroken bond connects points i and j: they are no neighbours, or their bond is broken. */
static int pdi_interpenetration_is_unbonded(const pd_interpenetration *s, int32_t i, int32_t j)
{
    for (pd_bond_iterator f = pd_body_bonds_begin(s->body, i); pd_body_bonds_next(&f);)
        if (f.neighbour == j) return pd_body_bond_is_broken(&f);
    return 1;
}

/* Component of a point; 0 where the body has one. */
static int32_t pdi_interpenetration_get_component(const pd_interpenetration *s, int32_t i)
{
    return s->component ? s->component[i] : 0;
}

/* The adjacent point above point i along axis d; -1: none. */
static int32_t pdi_interpenetration_neighbour(const pd_interpenetration *s, int32_t i, int d)
{
    int at[PD_DIM];
    pd_grid_index(s->grid, s->node[i], at);
    at[d]++;
    return pd_grid_is_inside(s->grid, at) ? s->point[pd_grid_node(s->grid, at)] : -1;
}

/* Length [m] of the part of the line from x along xi [m] that lies outside of the initial metal; 0 where the metal is
 * not smooth. */
static double pdi_interpenetration_initial_gap(const pd_interpenetration *s, const double *x, const double *xi)
{
    const pd_grid *grid = s->grid;
    int last = grid->solid > grid->wall ? grid->solid : grid->wall;
    double gap = 0.0, at[PD_DIM], touch = pd_shape_surface_tolerance(grid->h, x);
    if (!pdi_node_visibility_is_smooth(grid)) return 0.0;
    for (double from = 0.0; from < 1.0;) {
        double to = pd_min(pdi_shape_find_crossing(grid->shapes, last, x, xi, from, touch), 1.0);
        for (int d = 0; d < PD_DIM; d++) at[d] = x[d] + 0.5 * (from + to) * xi[d];
        if (pdi_node_visibility_metal_distance(grid, at) > pd_shape_surface_tolerance(grid->h, at)) gap += to - from;
        from = to;
    }
    return gap * pdi_vec_norm(xi);
}

/* Records an overlap `depth` [m] of two points. In one component it raises crack_overlap, unless one of the points has
 * lost all bonds; of two components it raises component_overlap and then sets first and other, whatever bonds they
 * have. */
static void pdi_interpenetration_record(pd_interpenetration *s, int32_t i, int32_t j, double depth)
{
    if (pdi_interpenetration_get_component(s, i) == pdi_interpenetration_get_component(s, j)) {
        if (pdi_body_bonds_count_intact(s->body, i) && pdi_body_bonds_count_intact(s->body, j))
            s->crack_overlap = pd_max(s->crack_overlap, depth);
    } else if (depth > s->component_overlap) {
        s->component_overlap = depth;
        s->first = i;
        s->other = j;
    }
}

/* Adjacent points, neither dissolved, whose distance is shortened by more than the fraction max_shortening. Pass 0: of
 * bonded ones, returns the largest fraction, at least max_shortening. Pass 1: records the overlaps of those without a
 * bond, less the initial gap, where that is still more, and returns max_shortening. u [count][PD_DIM] [m]. */
static double pdi_interpenetration_check_neighbours(pd_interpenetration *s, const double *u, int pass,
                                                    double max_shortening)
{
    const pd_body *body = s->body;
    for (int32_t i = 0; i < s->count; i++)
        for (int d = 0; d < PD_DIM && pdi_interpenetration_is_solid(s, i); d++) {
            int32_t j = pdi_interpenetration_neighbour(s, i, d);
            double xi[PD_DIM], y[PD_DIM];
            if (!pdi_interpenetration_is_solid(s, j)) continue;
            pdi_body_compute_offset(body, i, j, xi);
            for (int e = 0; e < PD_DIM; e++) y[e] = xi[e] + u[(int64_t)j * PD_DIM + e] - u[(int64_t)i * PD_DIM + e];
            double was = pdi_vec_norm(xi), shorter = was - pdi_vec_norm(y);
            if (!(shorter > max_shortening * was) || pdi_interpenetration_is_unbonded(s, i, j) != pass) continue;
            if (!pass) max_shortening = shorter / was;
            else {
                double depth = shorter - pdi_interpenetration_initial_gap(s, body->position + (int64_t)i * PD_DIM, xi);
                if (depth > max_shortening * was) pdi_interpenetration_record(s, i, j, depth);
            }
        }
    return max_shortening;
}

/* ---- points that come from afar ---- */

/* Bin, 0 .. bins - 1, of the cell in which point i lies at displacements u, shifted by off [PD_DIM] cells unless that
 * is NULL. Several cells may share a bin. */
static int32_t pdi_interpenetration_hash_cell(const pd_interpenetration *s, const double *u, int32_t i, const int *off)
{
    uint64_t key = 0;
    for (int d = 0; d < PD_DIM; d++) {
        double x = s->body->position[(int64_t)i * PD_DIM + d] + u[(int64_t)i * PD_DIM + d];
        double cell = floor(x / s->grid->h[0]) + (off ? off[d] : 0);
        key = (key + (uint64_t)(int64_t)pd_max(-1e15, pd_min(cell, 1e15))) * 0x9E3779B97F4A7C15u;
        key ^= key >> 29;
    }
    return (int32_t)(key & (uint64_t)(s->bins - 1));
}

/* Records the overlap [m], spacing less distance, of two points without an unbroken bond that were at least 1.1
 * spacings apart, if they are nearer than 1 - max_shortening spacings at displacements u. Does nothing otherwise. */
static void pdi_interpenetration_check_pair(pd_interpenetration *s, const double *u, int32_t i, int32_t j,
                                            double max_shortening)
{
    double h = s->grid->h[0], square = 0.0, was = 0.0, near = (1.0 - max_shortening) * h;
    for (int d = 0; d < PD_DIM; d++) {
        double xi = s->body->position[(int64_t)j * PD_DIM + d] - s->body->position[(int64_t)i * PD_DIM + d];
        double y = xi + u[(int64_t)j * PD_DIM + d] - u[(int64_t)i * PD_DIM + d];
        was += xi * xi;
        square += y * y;
    }
    if (square >= near * near || was < 1.21 * h * h || !pdi_interpenetration_is_unbonded(s, i, j)) return;
    pdi_interpenetration_record(s, i, j, h - sqrt(square));
}

/* Checks point i against the points that are in the hash table already, in its cell and the adjacent ones, and records
 * overlaps. */
static void pdi_interpenetration_check_nearby(pd_interpenetration *s, const double *u, int32_t i, double max_shortening)
{
    int32_t seen[27];
    int all = 1, bins = 0;
    for (int d = 0; d < PD_DIM; d++) all *= 3;
    for (int k = 0; k < all; k++) { /* each bin once: cells may share one */
        int off[PD_DIM], known = 0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= 3) off[d] = rest % 3 - 1;
        int32_t bin = pdi_interpenetration_hash_cell(s, u, i, off);
        for (int e = 0; e < bins; e++) known |= seen[e] == bin;
        if (known) continue;
        seen[bins++] = bin;
        for (int32_t j = s->bin[bin]; j >= 0; j = s->next[j])
            pdi_interpenetration_check_pair(s, u, i, j, max_shortening);
    }
}

PDI_FN void pdi_interpenetration_compute(pd_interpenetration *s, const double *u)
{
    s->crack_overlap = s->component_overlap = 0.0;
    double most = pdi_interpenetration_check_neighbours(s, u, 0, PDI_INTERPENETRATION_ROUNDING);
    pdi_interpenetration_check_neighbours(s, u, 1, most);
    for (int32_t k = 0; k < s->bins; k++) s->bin[k] = -1;
    for (int32_t i = 0; i < s->count && s->bins; i++) { /* points that lack bonds are at a surface */
        if (!pdi_interpenetration_is_solid(s, i) || pdi_body_bonds_count_intact(s->body, i) == s->body->stencil_bonds)
            continue;
        pdi_interpenetration_check_nearby(s, u, i, most);
        int32_t own = pdi_interpenetration_hash_cell(s, u, i, NULL);
        s->next[i] = s->bin[own];
        s->bin[own] = i;
    }
    s->max_crack_overlap = pd_max(s->max_crack_overlap, s->crack_overlap);
}

/* ---- build ---- */

PDI_FN pd_status pdi_interpenetration_build(pd_ctx *ctx, pd_interpenetration *s)
{
    int32_t *piece = NULL, all = s->body->count;
    uint8_t *seen = NULL;
    pd_status status = PD_NEW(ctx, "overlap", all, piece);
    if (status == PD_OK) status = PD_NEW(ctx, "overlap", all, seen);
    if (status == PD_OK) status = PD_NEW(ctx, "overlap", s->count, s->component);
    for (int32_t i = 0; i < s->count && status == PD_OK; i++) {
        if (seen[i]) continue;
        int32_t count = pdi_body_bonds_find_component(s->body, i, seen, piece);
        for (int32_t k = 0; k < count; k++)
            if (piece[k] < s->count) s->component[piece[k]] = s->components;
        s->components++;
    }
    if (s->components < 2) PD_DELETE(ctx, s->count, s->component);
    PD_DELETE(ctx, all, piece);
    PD_DELETE(ctx, all, seen);
    return status;
}

PDI_FN pd_status pdi_interpenetration_prepare(pd_ctx *ctx, pd_interpenetration *s)
{
    int32_t bins = 1024;
    while (bins < s->count && bins < 1 << 29) bins *= 2;
    PD_TRY(PD_NEW(ctx, "overlap", bins, s->bin));
    s->bins = bins;
    return PD_NEW(ctx, "overlap", s->count, s->next);
}

PDI_FN void pdi_interpenetration_free(pd_ctx *ctx, pd_interpenetration *s)
{
    PD_DELETE(ctx, s->count, s->component);
    PD_DELETE(ctx, s->bins, s->bin);
    PD_DELETE(ctx, s->count, s->next);
    memset(s, 0, sizeof *s);
}

#undef PDI_INTERPENETRATION_ROUNDING
