/* surface: see surface.h */
#include "lattice/surface.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* [cells] A shorter segment has no direction. */
#define PDI_SURFACE_MIN_LENGTH 1e-9
/* [cells] A point nearer than this to a surface lies on it. */
#define PDI_SURFACE_TOLERANCE 1e-6
/* [cells] Step of the central differences for a normal. */
#define PDI_SURFACE_STEP 1e-3
/* [cells] Surfaces farther away are not searched: beyond, distances of set operations are bounds. */
#define PDI_SURFACE_MAX_DISTANCE 2.0
/* [-] A gradient of the distance whose norm differs from 1 by more than this has an edge nearby. */
#define PDI_SURFACE_EDGE_TOLERANCE 1e-2

/* A search for the surface nearest to a point, and the best candidate so far. */
typedef struct pdi_surface_search {
    const pd_bonds *bonds;
    double x[PD_DIM], xi[PD_DIM]; /* [m] position of the node, and vector from it to the point */
    double end_fraction;          /* [-] multiple of xi at which the search ends */
    double nearest;               /* [cells] distance of the candidate from the point; HUGE_VAL: none */
    int is_behind;                /* 1: the point lies behind the surface */
    double point[PD_DIM], normal[PD_DIM]; /* [m], [-] the candidate */
    int32_t closed_node;                  /* closed node behind it */
} pdi_surface_search;

/* Candidate: the face of the first closed cell on the segment, by a walk from cell to cell; a side of the box that is a
 * wall counts as one, other sides are passed. A face before the point replaces any candidate, one at or behind it only
 * a candidate that is farther from the point. None: end_fraction or the end of the arrays comes first, or the cell has
 * a smooth surface that the node lies outside of (not receded). */
static void pdi_surface_find_cell_face(pdi_surface_search *search)
{
    const pd_grid *grid = search->bonds->grid;
    int i[PD_DIM];
    double next[PD_DIM], t = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = (int)floor((search->x[d] - grid->lo[d]) / grid->h[d]);
        double step = fabs(search->xi[d]);
        next[d] = step > PDI_SURFACE_MIN_LENGTH * grid->h[d] ? 0.5 * grid->h[d] / step : HUGE_VAL;
    }
    for (;;) {
        int d = 0;
        double at[PD_DIM];
        for (int a = 1; a < PD_DIM; a++)
            if (next[a] < next[d]) d = a;
        t = next[d];
        if (!(t <= search->end_fraction)) return;
        int up = search->xi[d] > 0.0;
        i[d] += up ? 1 : -1;
        next[d] += grid->h[d] / fabs(search->xi[d]);
        int outside = i[d] < 0 || i[d] >= grid->n[d];
        if (i[d] < -grid->ghost || i[d] >= grid->n[d] + grid->ghost) return;
        if (outside && grid->side[2 * d + up] != PD_SIDE_WALL) continue;
        int32_t node = pd_grid_node(grid, i);
        if (!outside && pdi_grid_is_open(grid->kind[node])) continue;
        /* a smooth surface is found by its distance, unless it has receded to these cells */
        for (int a = 0; a < PD_DIM; a++) at[a] = search->x[a];
        double smooth = outside ? (double)NAN : pdi_bond_surface_distance(search->bonds, node, at);
        if (smooth > pd_shape_surface_tolerance(grid->h, at)) return;
        double cells = 0.0;
        for (int a = 0; a < PD_DIM; a++) cells = pd_max(cells, fabs((t - 1.0) * search->xi[a]) / grid->h[a]);
        if (t >= 1.0 - PDI_SURFACE_MIN_LENGTH && !(cells < search->nearest)) return;
        search->nearest = cells;
        search->is_behind = t < 1.0;
        search->closed_node = node;
        for (int a = 0; a < PD_DIM; a++) search->point[a] = search->x[a] + t * search->xi[a];
        for (int a = 0; a < PD_DIM; a++) search->normal[a] = a != d ? 0.0 : up ? -1.0 : 1.0;
        return;
    }
}

/* Unit normal [PD_DIM] at x [m], out of the shape: gradient of its signed distance, by central differences; zero where
 * that vanishes. */
static void pdi_surface_compute_shape_normal(const pd_grid *grid, int shape, const double *x, double *normal)
{
    double at[PD_DIM], length;
    memcpy(at, x, sizeof at);
    for (int d = 0; d < PD_DIM; d++) {
        double eps = PDI_SURFACE_STEP * grid->h[d], keep = at[d];
        at[d] = keep + eps;
        normal[d] = pdi_grid_signed_distance(grid, shape, at);
        at[d] = keep - eps;
        normal[d] = (normal[d] - pdi_grid_signed_distance(grid, shape, at)) / (2.0 * eps);
        at[d] = keep;
    }
    length = pdi_vec_norm(normal);
    for (int d = 0; d < PD_DIM; d++) normal[d] /= length > 0.0 ? length : 1.0;
}

/* Closed node (may be a ghost) half a cell or one cell behind the surface point x [m], against `normal`, folded into
 * the box; -1: both are open or outside of the arrays: the metal that was there has dissolved. */
static int32_t pdi_surface_find_closed_node(const pdi_surface_search *search, const double *x, const double *normal)
{
    const pd_grid *grid = search->bonds->grid;
    for (int half = 1; half < 3; half++) {
        double at[PD_DIM];
        int i[PD_DIM], inside = 1;
        for (int d = 0; d < PD_DIM; d++) at[d] = x[d] - 0.5 * half * grid->h[d] * normal[d];
        pdi_grid_fold_position(grid, at);
        for (int d = 0; d < PD_DIM; d++) {
            i[d] = (int)floor((at[d] - grid->lo[d]) / grid->h[d]);
            inside = inside && i[d] >= -grid->ghost && i[d] < grid->n[d] + grid->ghost;
        }
        int32_t node = inside ? pd_grid_node(grid, i) : -1;
        if (node >= 0 && !pdi_grid_is_open(grid->kind[node])) return node;
    }
    return -1;
}

/* Moves `at` [m] onto the surface of a smooth shape by at most 8 steps along the normal; normal [PD_DIM]: that of the
 * last step. *first: signed distance at the start [m]. Returns 1; 0: the distance that is left exceeds
 * PDI_SURFACE_TOLERANCE of the smallest spacing, or it moved by more than PDI_SURFACE_MAX_DISTANCE along an axis; `at`
 * is changed all the same. */
static int pdi_surface_project_on_shape(const pd_grid *grid, int shape, double *at, double *normal, double *first)
{
    double from[PD_DIM], smallest = pdi_vec_min(grid->h), level = 0.0, cells = 0.0;
    memcpy(from, at, sizeof from);
    for (int step = 0; step < 8; step++) {
        level = pdi_grid_signed_distance(grid, shape, at);
        if (step == 0) *first = level;
        pdi_surface_compute_shape_normal(grid, shape, at, normal);
        if (fabs(level) <= 1e-14 * smallest) break;
        for (int d = 0; d < PD_DIM; d++) at[d] -= level * normal[d];
    }
    for (int d = 0; d < PD_DIM; d++) cells = pd_max(cells, fabs(at[d] - from[d]) / grid->h[d]);
    return fabs(level) <= PDI_SURFACE_TOLERANCE * smallest && !(cells > PDI_SURFACE_MAX_DISTANCE);
}

/* Candidate: the point of a smooth shape (index -1: none) nearest to `target` [m], when it is nearer than the present
 * one and a closed node lies behind it. A shape inside which the fluid node lies has receded and gives none. */
static void pdi_surface_find_shape_point(pdi_surface_search *search, int shape, const double *target)
{
    const pd_grid *grid = search->bonds->grid;
    double at[PD_DIM], normal[PD_DIM], first, cells = 0.0;
    if (shape < 0 || !pd_shape_is_smooth(grid->shapes, shape)) return;
    if (!(pdi_grid_signed_distance(grid, shape, search->x) > pd_shape_surface_tolerance(grid->h, search->x))) return;
    memcpy(at, target, sizeof at);
    if (!pdi_surface_project_on_shape(grid, shape, at, normal, &first)) return;
    for (int d = 0; d < PD_DIM; d++) cells = pd_max(cells, fabs(at[d] - target[d]) / grid->h[d]);
    if (!(cells < search->nearest)) return;
    int32_t closed = pdi_surface_find_closed_node(search, at, normal);
    if (closed < 0) return;
    search->nearest = cells;
    search->is_behind = first < 0.0;
    search->closed_node = closed;
    memcpy(search->point, at, sizeof at);
    memcpy(search->normal, normal, sizeof normal);
}

PDI_FN int pdi_surface_find_nearest(const pd_bonds *bonds, int32_t node, const double *target, double *point,
                                    double *normal, int32_t *closed)
{
    const pd_grid *grid = bonds->grid;
    pdi_surface_search search;
    double square = 0.0;
    memset(&search, 0, sizeof search);
    search.bonds = bonds;
    pd_grid_position(grid, node, search.x);
    for (int d = 0; d < PD_DIM; d++) {
        search.xi[d] = target[d] - search.x[d];
        square += search.xi[d] / grid->h[d] * (search.xi[d] / grid->h[d]);
    }
    search.nearest = HUGE_VAL;
    pdi_surface_find_shape_point(&search, grid->wall, target);
    pdi_surface_find_shape_point(&search, grid->solid, target);
    if (sqrt(square) > PDI_SURFACE_MIN_LENGTH) {
        search.end_fraction = 1.0 + 1.0 / sqrt(square);
        pdi_surface_find_cell_face(&search);
    }
    memcpy(point, search.point, sizeof search.point);
    memcpy(normal, search.normal, sizeof search.normal);
    *closed = search.closed_node;
    return search.nearest < HUGE_VAL ? (search.is_behind ? -1 : 1) : 0;
}

PDI_FN int pdi_surface_compute_normal(const pd_bonds *bonds, int32_t closed, const double *x, double step,
                                      double *distance, double *normal)
{
    double at[PD_DIM];
    memcpy(at, x, sizeof at);
    *distance = pdi_bond_surface_distance(bonds, closed, x);
    for (int d = 0; d < PD_DIM; d++) {
        double eps = step * bonds->grid->h[d];
        at[d] = x[d] + eps;
        double up = pdi_bond_surface_distance(bonds, closed, at);
        at[d] = x[d] - eps;
        normal[d] = (up - pdi_bond_surface_distance(bonds, closed, at)) / (2.0 * eps);
        at[d] = x[d];
    }
    return fabs(pdi_vec_norm(normal) - 1.0) < PDI_SURFACE_EDGE_TOLERANCE;
}

/* ---- area of the surface at a cell face ---- */

/* A cell face between an open and a closed node. */
typedef struct pdi_surface_cell_face {
    const pd_grid *grid;
    int shape, is_box_side; /* smooth shape of the closed node, -1: none; 1: the face lies on a side of the box */
    int axis;            /* normal to the face */
    double middle[PD_DIM], outward[PD_DIM]; /* [m] middle of the face; its unit normal towards the open node */
} pdi_surface_cell_face;

#if PD_DIM > 1
/* Maps a point of the face, `across` [half cells from its middle, along the other axes], to the surface: `at` [m] and
 * the unit normal towards the fluid. The point itself and the normal of the face: without a smooth shape, where the
 * projection fails, and on sides of the box that no shape covers. */
static void pdi_surface_map_face_point(const pdi_surface_cell_face *face, const double *across, double *at,
                                       double *normal)
{
    double on[PD_DIM], first;
    for (int d = 0, a = 0; d < PD_DIM; d++)
        on[d] = face->middle[d] + (d == face->axis ? 0.0 : 0.5 * face->grid->h[d] * across[a++]);
    memcpy(at, on, sizeof on);
    int bare = face->shape < 0 || (face->is_box_side && pdi_grid_signed_distance(face->grid, face->shape, on) >
                                                            pd_shape_surface_tolerance(face->grid->h, on));
    if (!bare && pdi_surface_project_on_shape(face->grid, face->shape, at, normal, &first)) return;
    memcpy(at, on, sizeof on);
    memcpy(normal, face->outward, sizeof face->outward);
}
#endif

#if PD_DIM == 3
/* Twice the area [m2] of the surface that the square of the face about `across`, with the half edge `half` [half
 * cells], is mapped to: projected on the normal at its middle. */
static double pdi_surface_compute_double_area(const pdi_surface_cell_face *f, const double *across, double half)
{
    double corner[4][PD_DIM], middle[PD_DIM], normal[PD_DIM], sum = 0.0;
    for (int c = 0; c < 4; c++) {
        double at[2] = {across[0] + (c == 1 || c == 2 ? half : -half), across[1] + (c > 1 ? half : -half)};
        pdi_surface_map_face_point(f, at, corner[c], normal);
    }
    pdi_surface_map_face_point(f, across, middle, normal);
    for (int d = 0; d < PD_DIM; d++) {
        int p = (d + 1) % PD_DIM, q = (d + 2) % PD_DIM;
        double one = corner[2][p] - corner[0][p], two = corner[3][q] - corner[1][q];
        double three = corner[2][q] - corner[0][q], four = corner[3][p] - corner[1][p];
        sum += (one * two - three * four) * normal[d];
    }
    /* the axes across are in the order of the box: they go around x and z, and against y */
    return (f->axis == 1 ? -1.0 : 1.0) * f->outward[f->axis] * sum;
}
#elif PD_DIM == 2
/* Twice the length [m] of the surface segment that the part of the face about `across`, with the half edge `half` [half
 * cells], is mapped to (2D); on an axisymmetric grid twice the area of its ring [m2]. */
static double pdi_surface_compute_double_area(const pdi_surface_cell_face *f, const double *across, double half)
{
    double from[PD_DIM], to[PD_DIM], middle[PD_DIM], normal[PD_DIM];
    double low = across[0] - half, high = across[0] + half;
    pdi_surface_map_face_point(f, &low, from, normal);
    pdi_surface_map_face_point(f, &high, to, normal);
    pdi_surface_map_face_point(f, across, middle, normal);
    double length = (to[1] - from[1]) * normal[0] - (to[0] - from[0]) * normal[1];
    double around = f->grid->circumference ? PD_PI * fabs(from[1] + to[1]) : 1.0;
    return (f->axis == 0 ? 2.0 : -2.0) * f->outward[f->axis] * length * around;
}
#else
/* Twice the area of the surface at a face in 1D, where it is one point [-]. */
static double pdi_surface_compute_double_area(const pdi_surface_cell_face *f, const double *across, double half)
{
    (void)f, (void)across;
    return half > 0.5 ? 2.0 : 0.0;
}
#endif

PDI_FN double pdi_surface_compute_face_area(const pd_grid *grid, int32_t node, int axis, int up)
{
    pdi_surface_cell_face face;
    int32_t closed = up ? node + grid->stride[axis] : node - grid->stride[axis];
    double across[PD_DIM], coarse, fine = 0.0;
    memset(&face, 0, sizeof face);
    memset(across, 0, sizeof across);
    face.grid = grid;
    face.axis = axis;
    face.is_box_side = pdi_grid_is_behind_wall(grid, closed);
    face.shape = pdi_bond_find_surface_shape(grid, closed, face.is_box_side);
    face.outward[axis] = up ? -1.0 : 1.0;
    pd_grid_position(grid, node, face.middle);
    face.middle[axis] -= 0.5 * grid->h[axis] * face.outward[axis];
    coarse = pdi_surface_compute_double_area(&face, across, 1.0);
    if (PD_DIM == 1 || face.shape < 0) return 0.5 * coarse;
    for (int c = 0; c < 1 << (PD_DIM - 1); c++) {
        for (int a = 0; a < PD_DIM - 1; a++) across[a] = (c >> a) & 1 ? 0.5 : -0.5;
        fine += pdi_surface_compute_double_area(&face, across, 0.5);
    }
    /* the error of both goes with the square of their edges */
    return 0.5 * (fine + (fine - coarse) / 3.0);
}

#undef PDI_SURFACE_MIN_LENGTH
#undef PDI_SURFACE_TOLERANCE
#undef PDI_SURFACE_STEP
#undef PDI_SURFACE_MAX_DISTANCE
#undef PDI_SURFACE_EDGE_TOLERANCE
