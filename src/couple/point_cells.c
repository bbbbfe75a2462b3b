/* point_cells: see point_cells.h */
#include "couple/point_cells.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/vec.h"
#include "lattice/node_visibility.h"
#include <math.h>

/* Stiffness factor of points that have just dissolved: they still count as metal until it is their turn to lose
 * bonds. */
#define PDI_POINT_CELLS_PENDING 1e-300

/* ---- planes of symmetry ---- */

/* Layers of image cells behind the lower (upper 0) or upper (1) side along axis d; 0: it is no plane of symmetry. Three
 * horizons, rounded to cells, but with one plane alone no more than the box has. */
static int pdi_point_cells_count_behind(const pd_point_cells *s, int d, int upper)
{
    int depth = 3 * (int)floor(s->horizon_ratio + 0.5), n = s->grid->n[d];
    if (!(s->mirrors >> (2 * d + upper) & 1)) return 0;
    return (s->mirrors >> (2 * d) & 3) == 3 || depth < n ? depth : n;
}

/* Maps a cell at [PD_DIM] of the extended box to the one it mirrors, in place. Returns a bit mask of the axes along
 * which it is reflected an odd number of times. */
static int pdi_point_cells_fold_cell(const pd_point_cells *s, int *at)
{
    int flip = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int n = s->grid->n[d], both = (s->mirrors >> (2 * d) & 3) == 3;
        if (at[d] >= 0 && at[d] < n) continue;
        int place = both ? (at[d] % (2 * n) + 2 * n) % (2 * n) : at[d];
        if (place >= 0 && place < n) at[d] = place;
        else {
            at[d] = place < 0 ? -1 - place : 2 * n - 1 - place;
            flip |= 1 << d;
        }
    }
    return flip;
}

/* Cell number k of the extended box: sets its index at [PD_DIM], negative below the box, and *flip: bit mask of the
 * axes along which it is reflected an odd number of times, -1: the cell lies in the box. Returns the solid node that it
 * is or mirrors; -1: none. */
static int32_t pdi_point_cells_find_image(const pd_point_cells *s, int64_t k, int *at, int *flip)
{
    int folded[PD_DIM];
    for (int d = 0; d < PD_DIM; d++, k /= s->extended_cells[d - 1])
        folded[d] = at[d] = (int)(k % s->extended_cells[d]) - s->lower_cells[d];
    int inside = pd_grid_is_inside(s->grid, at);
    *flip = pdi_point_cells_fold_cell(s, folded);
    if (inside) *flip = -1;
    int32_t node = pd_grid_node(s->grid, folded);
    return s->grid->kind[node] == PD_SOLID ? node : -1;
}

/* Number of cells of the extended box. */
static int64_t pdi_point_cells_count_cells(const pd_point_cells *s)
{
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= s->extended_cells[d];
    return cells;
}

/* How many images there are. */
PDI_FN void pdi_point_cells_count_images(pd_point_cells *s)
{
    int at[PD_DIM], flip;
    for (int d = 0; d < PD_DIM; d++) {
        s->lower_cells[d] = pdi_point_cells_count_behind(s, d, 0);
        s->extended_cells[d] = s->grid->n[d] + s->lower_cells[d] + pdi_point_cells_count_behind(s, d, 1);
    }
    for (int64_t k = 0; k < pdi_point_cells_count_cells(s) && s->mirrors; k++)
        s->images += pdi_point_cells_find_image(s, k, at, &flip) >= 0 && flip >= 0;
}

/* The images, behind the points. */
PDI_FN void pdi_point_cells_add_images(pd_point_cells *s)
{
    int at[PD_DIM], flip;
    int32_t g = 0;
    for (int32_t i = 0; i < s->count + s->images && s->images; i++) s->next_image[i] = -1;
    for (int64_t k = 0; k < pdi_point_cells_count_cells(s) && s->images; k++) {
        int32_t node = pdi_point_cells_find_image(s, k, at, &flip);
        s->cell_point[k] = node >= 0 ? s->point[node] : -1;
        if (node < 0 || flip < 0) continue;
        s->cell_point[k] = s->count + g;
        s->image_source[g] = s->point[node];
        s->image_reflection[g] = (uint8_t)flip;
        for (int d = 0; d < PD_DIM; d++) s->cell[g * PD_DIM + d] = at[d];
        s->next_image[s->count + g] = s->next_image[s->point[node]];
        s->next_image[s->point[node]] = s->count + g++;
    }
    for (int32_t i = s->count; i < s->count + s->images; i++) s->stiffness_factor[i] = 1.0;
}

/* The real point that i is or mirrors. */
static int32_t pdi_point_cells_real_point(const pd_point_cells *s, int32_t i)
{
    return i < s->count ? i : s->image_source[i - s->count];
}

/* Cell index at [PD_DIM] of a point or image; that of an image lies outside of the box. */
static void pdi_point_cells_get_cell(const pd_point_cells *s, int32_t i, int *at)
{
    if (i < s->count) pd_grid_index(s->grid, s->node[i], at);
    else
        for (int d = 0; d < PD_DIM; d++) at[d] = s->cell[(i - s->count) * PD_DIM + d];
}

PDI_FN void pdi_point_cells_position(const pd_point_cells *s, int32_t i, double *x)
{
    int at[PD_DIM];
    pdi_point_cells_get_cell(s, i, at);
    for (int d = 0; d < PD_DIM; d++) x[d] = s->grid->lo[d] + ((double)at[d] + 0.5) * s->grid->h[d];
}

/* The point or image in the cell at [PD_DIM], also of points that have dissolved; -1: none. */
static int32_t pdi_point_cells_find_point(const pd_point_cells *s, const int *at)
{
    int64_t k = 0;
    if (!s->images) return pd_grid_is_inside(s->grid, at) ? s->point[pd_grid_node(s->grid, at)] : -1;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        int place = at[d] + s->lower_cells[d];
        if (place < 0 || place >= s->extended_cells[d]) return -1;
        k = k * s->extended_cells[d] + place;
    }
    return s->cell_point[k];
}

/* ---- bonds that leave the metal ---- */

/* 1: the cell at [PD_DIM] is metal, or its point has dissolved in this step and has not yet lost its bonds. self: the
 * pd_point_cells. A callback of pdi_node_visibility_has_staircase. */
static int pdi_point_cells_is_metal(const void *self, const int *at)
{
    const pd_point_cells *s = (const pd_point_cells *)self;
    int32_t i = pdi_point_cells_find_point(s, at);
    return i >= 0 &&
           (s->grid->kind[s->node[pdi_point_cells_real_point(s, i)]] == PD_SOLID || s->stiffness_factor[i] > 0.0);
}

/* Offset step [PD_DIM] in cells from point or image i to point or image j. */
static void pdi_point_cells_cell_offset(const pd_point_cells *s, int32_t i, int32_t j, int *step)
{
    int from[PD_DIM];
    pdi_point_cells_get_cell(s, i, from);
    pdi_point_cells_get_cell(s, j, step);
    for (int d = 0; d < PD_DIM; d++) step[d] -= from[d];
}

/* 1: at least one of the staircase paths of cells from point i by step [PD_DIM] cells is metal throughout. */
static int pdi_point_cells_is_connected(const pd_point_cells *s, int32_t i, const int *step)
{
    int from[PD_DIM];
    pdi_point_cells_get_cell(s, i, from);
    return pdi_node_visibility_has_staircase(from, step, pdi_point_cells_is_metal, s);
}

/* Least parameter t > after, at most 1, where the line x + t xi [m] crosses a side of the box or of its mirror images.
 * Only axes with a plane of symmetry, on either side, count; 1: there is no such crossing. */
static double pdi_point_cells_next_side(const pd_point_cells *s, const double *x, const double *xi, double after)
{
    double best = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double length = s->grid->hi[d] - s->grid->lo[d], from = (x[d] - s->grid->lo[d]) / length, by = xi[d] / length;
        if (!(s->mirrors >> (2 * d) & 3) || !(fabs(by) > 0.0)) continue;
        double last = pd_max(from, from + by);
        for (double k = ceil(pd_min(from, from + by)); k <= last; k += 1.0) {
            double t = (k - from) / by;
            if (t > after && t < best) best = t;
        }
    }
    return best;
}

/* 1: the line from x by xi [m], folded into the box at each side that is a plane of symmetry, stays within the smooth
 * metal; 0: a piece of it does not. */
static int pdi_point_cells_is_within(const pd_point_cells *s, const double *x, const double *xi)
{
    const pd_grid *grid = s->grid;
    for (double from = 0.0; from < 1.0;) {
        double to = pdi_point_cells_next_side(s, x, xi, from), a[PD_DIM], way[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            double length = grid->hi[d] - grid->lo[d], middle = x[d] + 0.5 * (from + to) * xi[d] - grid->lo[d];
            double box = s->mirrors >> (2 * d) & 3 ? floor(middle / length) : 0.0;
            int even = fabs(2.0 * floor(0.5 * box) - box) < 0.5;
            a[d] = x[d] + from * xi[d] - box * length;
            way[d] = (to - from) * xi[d];
            if (even) continue;
            a[d] = grid->lo[d] + grid->hi[d] - a[d];
            way[d] = -way[d];
        }
        if (!pdi_node_visibility_is_visible(grid, a, way)) return 0;
        from = to;
    }
    return 1;
}

/* A pd_bond_inside_fn: 1: a staircase path of metal cells joins points i and j. user: the pd_point_cells. */
static int pdi_point_cells_joined_by_cells(void *user, int32_t i, int32_t j, const double *xi)
{
    const pd_point_cells *s = (const pd_point_cells *)user;
    int step[PD_DIM];
    (void)xi;
    pdi_point_cells_cell_offset(s, i, j, step);
    return pdi_point_cells_is_connected(s, i, step);
}

/* A pd_bond_inside_fn: 1: the line from point i by xi [m] stays within the smooth surface. Where the depths of both
 * ends below the surface, those of ends outside counted as 0, add up to at least its length, it does so and is not
 * traced. user: the pd_point_cells. */
static int pdi_point_cells_joined_by_surface(void *user, int32_t i, int32_t j, const double *xi)
{
    const pd_point_cells *s = (const pd_point_cells *)user;
    double from[PD_DIM], deep = pd_max(s->depth[i], 0.0) + pd_max(s->depth[j], 0.0);
    if (deep * deep >= pdi_vec_dot(xi, xi)) return 1;
    pdi_point_cells_position(s, i, from);
    return pdi_point_cells_is_within(s, from, xi);
}

/* Which bonds leave the metal of the start is to be asked of these. */
PDI_FN void pdi_point_cells_set_joined(pd_ctx *ctx, pd_point_cells *s, pd_body_desc *desc)
{
    int nt = pd_par_threads(ctx, (int64_t)s->count * 100);
    (void)nt;
    if (pdi_node_visibility_is_convex(s->grid)) return;
    desc->user = s;
    desc->joined = pdi_point_cells_joined_by_cells;
    if (!pdi_node_visibility_is_smooth(s->grid)) return;
    desc->joined = pdi_point_cells_joined_by_surface;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < s->count; i++) {
        double x[PD_DIM];
        pd_grid_position(s->grid, s->node[i], x);
        s->depth[i] = -pdi_node_visibility_metal_distance(s->grid, x);
    }
    for (int32_t g = 0; g < s->images; g++) s->depth[s->count + g] = s->depth[s->image_source[g]];
}

/* ---- metal that goes ---- */

/* 1: a cell at offset off[] from the start of a line of step[] cells may belong to one of its staircase paths: it lies
 * in the box that the line spans, and each component of the cross product of off and step is at most 4 times the
 * largest |step|. A quick test before staircases are searched. */
static int pdi_point_cells_may_cross(const int *off, const int *step)
{
    int length = 0;
    for (int d = 0; d < PD_DIM; d++) {
        if (off[d] < (step[d] < 0 ? step[d] : 0) || off[d] > (step[d] > 0 ? step[d] : 0)) return 0;
        length = step[d] > length ? step[d] : -step[d] > length ? -step[d] : length;
    }
    for (int d = 0; d < PD_DIM; d++)
        for (int e = 0; e < d; e++) { /* it is two cells off the line along an axis, at most */
            int across = off[d] * step[e] - off[e] * step[d];
            if (across > 4 * length || -across > 4 * length) return 0;
        }
    return 1;
}

/* 1: the line from 0 to step[] cells passes through the cell at offset off[], over more than 1e-9 of its length; an
 * edge or corner alone does not count. */
static int pdi_point_cells_is_crossed(const int *off, const int *step)
{
    double from = 0.0, to = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double low = ((double)off[d] - 0.5) / (step[d] ? step[d] : 1);
        double high = ((double)off[d] + 0.5) / (step[d] ? step[d] : 1);
        if (!step[d] && off[d]) return 0;
        if (!step[d]) continue;
        from = pd_max(from, pd_min(low, high));
        to = pd_min(to, pd_max(low, high));
    }
    return to > from + 1e-9;
}

/* Breaks the intact bonds of point i to neighbours of higher number that led through the dissolved point `gone` alone;
 * so each bond is met at one end. A staircase of metal joins the ends with `gone` and none without it. A bond that no
 * staircase joined before, as in a thin part with smooth faces, breaks where its line passes the cell. */
static void pdi_point_cells_break_through(const pd_point_cells *s, pd_body *body, int32_t gone, int32_t i)
{
    double stiff = s->stiffness_factor[gone];
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        int off[PD_DIM], step[PD_DIM];
        if (f.neighbour < i || pd_body_bond_is_broken(&f)) continue;
        pdi_point_cells_cell_offset(s, i, gone, off);
        pdi_point_cells_cell_offset(s, i, f.neighbour, step);
        if (!pdi_point_cells_may_cross(off, step)) continue;
        int before = pdi_point_cells_is_connected(s, i, step);
        s->stiffness_factor[gone] = 0.0;
        int after = pdi_point_cells_is_connected(s, i, step);
        s->stiffness_factor[gone] = stiff;
        if (before ? !after : pdi_point_cells_is_crossed(off, step)) pdi_body_bonds_break(body, i, &f);
    }
}

/* Point or image `gone` has dissolved: breaks its bonds, and those of all points nearby that led through it alone, and
 * sets its stiffness factor to 0. */
static void pdi_point_cells_dissolve_point(const pd_point_cells *s, pd_body *body, int32_t gone)
{
    int reach = (int)ceil(s->horizon_ratio + 0.5), wide = 2 * reach + 1, all = pdi_grid_count_cube(reach), cell[PD_DIM];
    pdi_body_bonds_break_all(body, gone);
    pdi_point_cells_get_cell(s, gone, cell);
    for (int k = 0; k < all; k++) {
        int at[PD_DIM];
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= wide) at[d] = cell[d] + rest % wide - reach;
        int32_t i = pdi_point_cells_find_point(s, at);
        if (i >= 0 && i != gone) pdi_point_cells_break_through(s, body, gone, i);
    }
    s->stiffness_factor[gone] = 0.0;
}

/* Points and their images, one after another: each sees the others as metal until it is its turn. */
PDI_FN int pdi_point_cells_dissolve_nodes(const pd_point_cells *s, pd_body *body, const int32_t *turned, int32_t count)
{
    int gone = 0;
    for (int way = 0; way < 2; way++)
        for (int32_t k = 0; k < count; k++)
            for (int32_t i = s->point[turned[k]]; i >= 0; i = s->images ? s->next_image[i] : -1) {
                gone = 1;
                if (way) pdi_point_cells_dissolve_point(s, body, i);
                else s->stiffness_factor[i] = pd_max(s->stiffness_factor[i], PDI_POINT_CELLS_PENDING);
            }
    return gone;
}

PDI_FN void pdi_point_cells_list(pdi_array_visitor *owner, void *object)
{
    pd_point_cells *sites = (pd_point_cells *)object;
    int64_t all = (int64_t)sites->count + sites->images;
    PDI_ARRAY(owner, sites, cell, sites->images * PD_DIM, "1");
    PDI_ARRAY(owner, sites, next_image, all, "1");
    PDI_ARRAY(owner, sites, cell_point, pdi_point_cells_count_cells(sites), "1");
}

#undef PDI_POINT_CELLS_PENDING
