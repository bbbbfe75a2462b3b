/* bond: see bond.h */
#include "lattice/bond.h"
#include "core/vec.h"
#include "core/par.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [-] Smallest fraction t of a bond at which it is cut: a node on the wall counts as 1e-3 of a bond away from it, so
 * that its wall term a/t stays representable against the weights of its other bonds. */
#define PDI_BOND_MIN_FRACTION 1e-3
/* [-] Curvature times the spacing above which a surface counts as an edge, and below which as flat. A radius of two
 * cells gives one half; the factor keeps rounding of the differences from deciding on it. */
#define PDI_BOND_EDGE_CURVATURE (0.5 * (1.0 + 1e-5))
#define PDI_BOND_FLAT_CURVATURE 1e-5
/* [-] A blocked bond whose line grazes the surface is extended up to this multiple of its length to find the
 * intersection: the chord that it lies on grows with the square root of the radius. */
#define PDI_BOND_MAX_FRACTION 16.0
/* [-] A unit normal whose largest component is closer than this to 1 is along an axis, but for rounding. */
#define PDI_BOND_AXIS_TOLERANCE 1e-9
/* [-] The gradient of a distance has the norm 1, and less at an edge. Below this value normals cancel to rounding. */
#define PDI_BOND_MIN_GRADIENT 1e-6
/* [cells] An intersection farther than this from the smooth surface is on a cell face instead. */
#define PDI_BOND_SURFACE_TOLERANCE 1e-3
/* [-] Below this pivot ratio of the moments the open bonds do not span space (a channel one node wide). */
#define PDI_BOND_MIN_PIVOT 1e-3

/* Intersection of a cut bond with the surface, and the geometry of the surface there. */
typedef struct pdi_bond_intersection {
    double fraction;       /* [-] fraction of the bond */
    double normal[PD_DIM]; /* unit, towards the fluid */
    double distance;       /* [m] of the node from a curved surface; 0: unknown or flat, then the next two are 0 */
    double curvature;      /* [1/m] sum of the principal curvatures: Laplacian of the distance */
    /* [m] xi.D xi - mean (xi.N)^2 with the second derivatives D of the distance */
    double tangential_curvature;
    int is_smooth; /* 1: on the zero level of a shape that is curved or inclined against the lattice */
} pdi_bond_intersection;

/* Sets all of *cut to the intersection with the face of the closed cell that bond k enters with `group`; curvatures and
 * distance become 0, is_smooth 0. Through an edge or corner the unit normal is the mean of the entered faces: of those
 * whose near side is open when the group is one cell, else, or when none is, of all. */
static void pdi_bond_intersect_cell_face(const pd_bond_paths *paths, int32_t node, int k, int group,
                                         pdi_bond_intersection *cut)
{
    const pd_stencil *s = paths->stencil;
    const pd_grid *grid = paths->grid;
    const int *n = s->offset + k * PD_DIM;
    int axes = s->group_axes[group], used = 0;
    int32_t at = node + paths->cell_shift[s->group_cell[group]];
    int single = s->group_cell[group + 1] - s->group_cell[group] == 1;
    double length = 0.0;
    cut->distance = cut->curvature = cut->tangential_curvature = 0.0;
    cut->is_smooth = 0;
    for (int pass = 0; pass < 2 && !used; pass++)
        for (int d = 0; d < PD_DIM; d++) {
            int sign = n[d] < 0 ? -1 : 1;
            cut->normal[d] = 0.0;
            if (!((axes >> d) & 1)) continue;
            if (pass == 0 && single && !pdi_grid_is_open(grid->kind[at - sign * grid->stride[d]])) continue;
            cut->normal[d] = -(double)sign;
            used = 1;
        }
    for (int d = 0; d < PD_DIM; d++) length += cut->normal[d] * cut->normal[d];
    for (int d = 0; d < PD_DIM; d++) cut->normal[d] /= sqrt(length);
    cut->fraction = s->group_entry[group];
}

/* Signed distance [m] from a shape of the point x + t xi [m], positive outside of the shape (in the fluid). */
static double pdi_bond_shape_distance_along(const pd_grid *grid, int shape, const double *x, const double *xi, double t)
{
    double at[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) at[d] = x[d] + t * xi[d];
    return pdi_grid_signed_distance(grid, shape, at);
}

/* 1: an open node on bond k, in front of its closed `group`, lies inside `shape` or on its surface: metal has dissolved
 * there, and the surface is that of cell faces, no longer the shape. The node at the start of the bond is not tested.
 */
static int pdi_bond_has_receded(const pd_bond_paths *paths, int shape, int32_t node, int k, int group)
{
    const pd_stencil *s = paths->stencil;
    const pd_grid *grid = paths->grid;
    double x[PD_DIM];
    for (int c = s->group_cell[s->group_first[k]]; c < s->group_cell[group]; c++) {
        int32_t at = node + paths->cell_shift[c];
        if (!pdi_grid_is_open(grid->kind[at])) continue;
        pd_grid_position(grid, at, x);
        if (pdi_grid_signed_distance(grid, shape, x) <= pd_shape_surface_tolerance(grid->h, x)) return 1;
    }
    return 0;
}

/* Sets normal and is_smooth of *cut, whose fraction is set, by central differences of the distance to `shape`; x, xi
 * [m]: node and bond. Nothing changes where the gradient vanishes. is_smooth: the normal is along no axis, or c, the
 * largest second derivative times h, is not below PDI_BOND_FLAT_CURVATURE. distance (>= PDI_BOND_MIN_FRACTION spacings)
 * and curvatures are set only where c is from there to below PDI_BOND_EDGE_CURVATURE, and distance times curvature is
 * below 1.5. */
static void pdi_bond_compute_curvature(const pd_grid *grid, int shape, const double *x, const double *xi,
                                       pdi_bond_intersection *cut)
{
    double gradient[PD_DIM], p[PD_DIM], eps = 1e-3 * pdi_vec_min(grid->h), mean = 0.0, sharpest = 0.0;
    for (int d = 0; d < PD_DIM; d++) p[d] = x[d] + cut->fraction * xi[d];
    double centre = pdi_grid_signed_distance(grid, shape, p), length = pdi_vec_norm(xi);
    for (int d = 0; d < PD_DIM; d++) {
        double at = p[d];
        p[d] = at + eps;
        double up = pdi_grid_signed_distance(grid, shape, p);
        p[d] = at - eps;
        double down = pdi_grid_signed_distance(grid, shape, p), second = (up - centre) - (centre - down);
        p[d] = at;
        gradient[d] = (up - down) / (2.0 * eps);
        mean += second / (eps * eps);
        sharpest = pd_max(sharpest, fabs(second) / (eps * eps) * grid->h[d]);
    }
    double norm = pdi_vec_norm(gradient), step = eps / length, reach;
    if (!(norm > PDI_BOND_MIN_GRADIENT)) return;
    double largest = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        cut->normal[d] = gradient[d] / norm;
        largest = pd_max(largest, fabs(cut->normal[d]));
    }
    cut->is_smooth = largest < 1.0 - PDI_BOND_AXIS_TOLERANCE || !(sharpest < PDI_BOND_FLAT_CURVATURE);
    double second = (pdi_bond_shape_distance_along(grid, shape, x, xi, cut->fraction + step) - centre) -
                    (centre - pdi_bond_shape_distance_along(grid, shape, x, xi, cut->fraction - step));
    /* no closer than the least t allows, and not out where the expansion about the surface ends */
    double distance = pd_max(pdi_grid_signed_distance(grid, shape, x), PDI_BOND_MIN_FRACTION * pdi_vec_min(grid->h));
    if (!(sharpest < PDI_BOND_EDGE_CURVATURE) || sharpest < PDI_BOND_FLAT_CURVATURE || !(distance * mean < 1.5)) return;
    reach = pdi_vec_dot(xi, cut->normal);
    cut->distance = distance;
    cut->curvature = mean;
    cut->tangential_curvature = second / (step * step) - mean * reach * reach;
}

/* First fraction of bond k from node x at which it passes a lattice point inside `shape` or on its surface; the far end
 * counts, the node x does not. HUGE_VAL: none. Such a node is closed even where the line only touches the shape. */
static double pdi_bond_find_node_in_shape(const pd_grid *grid, int shape, const double *x, const pd_stencil *s, int k)
{
    const int *n = s->offset + k * PD_DIM;
    int steps = 0;
    for (int d = 0; d < PD_DIM; d++)
        for (int a = abs(n[d]), rest; a; a = rest) {
            rest = steps % a;
            steps = a;
        }
    for (int j = 1; j <= steps; j++) {
        double at[PD_DIM], t = (double)j / steps;
        for (int d = 0; d < PD_DIM; d++) at[d] = x[d] + t * s->xi[k * PD_DIM + d];
        if (pdi_grid_signed_distance(grid, shape, at) <= pd_shape_surface_tolerance(grid->h, at)) return t;
    }
    return HUGE_VAL;
}

/* Moves the intersection, with normal and curvatures, to the point at which bond k enters `shape`: before the cell face
 * or, where the line grazes the closed cell, behind it, up to fraction `limit`. In a tube that may lie behind the far
 * end, where cells at the wall block the line between two fluid nodes. *cut stays as it is where the node x lies in the
 * shape or on its surface, or the line does not enter it up to `limit`. */
static void pdi_bond_intersect_shape(const pd_grid *grid, int shape, const double *x, const pd_stencil *s, int k,
                                     double limit, pdi_bond_intersection *cut)
{
    const double *xi = s->xi + k * PD_DIM;
    if (!(pdi_grid_signed_distance(grid, shape, x) > pd_shape_surface_tolerance(grid->h, x))) return;
    double node = pdi_bond_find_node_in_shape(grid, shape, x, s, k);
    double t = pd_min(pdi_grid_find_shape_entry(grid, shape, x, xi, pd_min(limit, node)), node);
    if (!(t <= limit)) return;
    cut->fraction = t;
    pdi_bond_compute_curvature(grid, shape, x, xi, cut);
}

PDI_FN int pdi_bond_find_surface_shape(const pd_grid *grid, int32_t closed, int walled)
{
    uint8_t kind = grid->kind[pd_grid_find_source(grid, closed, NULL)];
    int shape = walled ? grid->wall : kind == PD_SOLID ? grid->solid : pdi_grid_is_open(kind) ? -1 : grid->wall;
    return shape >= 0 && pd_shape_is_smooth(grid->shapes, shape) ? shape : -1;
}

/* Axisymmetric grid: adds the curvature N_r/r of a surface of revolution in the plane of the ring to *cut (0 at r <=
 * 0), and sets its distance where that is 0, as of a plane. Nothing changes where |N_r|/r times h_r is not below
 * PDI_BOND_EDGE_CURVATURE, or the distance times the sum of curvatures is not below 1.5. */
static void pdi_bond_add_ring_curvature(const pd_grid *grid, const double *x, const double *xi,
                                        pdi_bond_intersection *cut)
{
    int r = PD_DIM - 1;
    double radius = x[r] + cut->fraction * xi[r], normal_length = pdi_vec_dot(xi, cut->normal);
    double ring_curvature = radius > 0.0 ? cut->normal[r] / radius : 0.0;
    double distance = cut->distance > 0.0 ? cut->distance : cut->fraction * fabs(normal_length);
    if (!(fabs(ring_curvature) * grid->h[r] < PDI_BOND_EDGE_CURVATURE) ||
        !(distance * (cut->curvature + ring_curvature) < 1.5))
        return;
    cut->distance = distance;
    cut->curvature += ring_curvature;
    cut->tangential_curvature -= ring_curvature * normal_length * normal_length;
}

/* Sets all of *cut: the intersection of bond k of `node`, blocked at `group`, with the surface, and the curvatures
 * there. It is the smooth shape of the closed cell, searched up to PDI_BOND_MAX_FRACTION (behind a wall side up to the
 * side); the cell face where there is no such shape, it has receded, or the line does not enter it. The fraction is at
 * least PDI_BOND_MIN_FRACTION, and may exceed 1. */
static void pdi_bond_find_intersection(const pd_bond_paths *paths, int32_t node, int k, int group,
                                       pdi_bond_intersection *cut)
{
    const pd_grid *grid = paths->grid;
    const pd_stencil *s = paths->stencil;
    int32_t closed = pdi_bond_path_find_closed_cell(paths, node, group);
    int walled = pdi_grid_is_behind_wall(grid, closed), shape = pdi_bond_find_surface_shape(grid, closed, walled);
    double x[PD_DIM];
    pdi_bond_intersect_cell_face(paths, node, k, group, cut);
    pd_grid_position(grid, node, x);
    /* a tube that touches the box: its wall lies at or before the side */
    if (shape >= 0 && !pdi_bond_has_receded(paths, shape, node, k, group))
        pdi_bond_intersect_shape(grid, shape, x, s, k, walled ? cut->fraction : PDI_BOND_MAX_FRACTION, cut);
    if (cut->fraction < PDI_BOND_MIN_FRACTION) cut->fraction = PDI_BOND_MIN_FRACTION;
    if (PD_DIM == 2 && grid->circumference) pdi_bond_add_ring_curvature(grid, x, s->xi + k * PD_DIM, cut);
}

/* inverse [PD_DIM][PD_DIM] = inverse of the moment matrix, plus `closure` where that is not NULL. Returns 1; 0: the
 * reciprocal condition number of the matrix, scaled by the moments norm [PD_DIM] of a full family so that the ratio of
 * the spacings does not matter, is not above `min_pivot`, and `inverse` has no meaning. */
static int pdi_bond_invert_moment(const double *norm, const double *moment, const double *closure, double min_pivot,
                                  double *inverse)
{
    double scaled[PD_DIM * PD_DIM], scale[PD_DIM];
    for (int a = 0; a < PD_DIM; a++) scale[a] = sqrt(norm[a]);
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++)
            scaled[a * PD_DIM + b] =
                (moment[a * PD_DIM + b] + (closure ? closure[a * PD_DIM + b] : 0.0)) / (scale[a] * scale[b]);
    if (!(pdi_vec_invert(scaled, inverse) > min_pivot)) return 0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) inverse[a * PD_DIM + b] /= scale[a] * scale[b];
    return 1;
}

/* 1: the family of `node` is full: all far ends are fluid, images or outlets. 0: one is solid, wall, inactive, or an
 * inlet ghost, which carries no pressure. */
static int pdi_bond_is_family_full(const pd_bonds *bonds, int32_t node)
{
    for (int k = 0; k < bonds->stencil->count; k++) {
        uint8_t kind = bonds->grid->kind[node + bonds->paths.shift[k]];
        if (kind != PD_FLUID && kind != PD_OUTLET && kind != PD_IMAGE) return 0;
    }
    return 1;
}

/* Adds the contributions of cut bond k of `node` to *lap [1/m2] and *curv [-] (eq. 2.3, 2.4): a/t, and a (1-t)/2
 * (xi.N)^2 (negative for t > 1). Where cut->distance d > 0 both lose a part for the tangential curvature. Derivation: u
 * = u_i + s u' + s^2/2 u'' is zero at t. Near a wall u = g d + q d^2/2, so u'' = g (xi.D xi) + q (xi.N)^2 and the
 * Laplacian is g mean + q: u'' and g follow from u_i and that Laplacian. */
static void pdi_bond_add_wall_terms(const pd_bonds *bonds, int32_t node, int k, const pdi_bond_intersection *cut,
                                    double *lap, double *curv)
{
    double a = pdi_bond_get_laplacian_weights(bonds, node)[k], half = 0.5 * a * (1.0 - cut->fraction);
    double normal_length = pdi_vec_dot(bonds->stencil->xi + k * PD_DIM, cut->normal);
    *lap += a / cut->fraction;
    *curv += half * normal_length * normal_length;
    if (!(cut->distance > 0.0)) return;
    double gradient = 1.0 / (1.0 - 0.5 * cut->distance * cut->curvature);
    *lap -= half * cut->tangential_curvature * gradient / cut->distance;
    *curv -= half * cut->tangential_curvature * gradient * 0.5 * cut->distance;
}

/* 1: the bond is blocked by cells of a smooth surface that its line intersects behind its far end (fraction above 1 +
 * 1e-9), or nowhere: the intersection is PDI_BOND_SURFACE_TOLERANCE or more from the shape. 0: a surface of cell faces,
 * or a wall side of the box, with a fraction of at most 1. */
static int pdi_bond_is_grazing(const pd_bond_paths *paths, int32_t node, int k, int group,
                               const pdi_bond_intersection *cut)
{
    const pd_grid *grid = paths->grid;
    const double *xi = paths->stencil->xi + k * PD_DIM;
    int32_t closed = pdi_bond_path_find_closed_cell(paths, node, group);
    int walled = pdi_grid_is_behind_wall(grid, closed), shape = pdi_bond_find_surface_shape(grid, closed, walled);
    double x[PD_DIM];
    if (cut->fraction > 1.0 + 1e-9) return 1;
    if (walled || shape < 0 || pdi_bond_has_receded(paths, shape, node, k, group)) return 0;
    pd_grid_position(grid, node, x);
    return !(fabs(pdi_bond_shape_distance_along(grid, shape, x, xi, cut->fraction)) <
             PDI_BOND_SURFACE_TOLERANCE * pdi_vec_min(grid->h));
}

PDI_FN double pdi_bond_find_cut_fraction(const pd_bond_paths *paths, int32_t node, int k, double *x)
{
    const double *xi = paths->stencil->xi + k * PD_DIM;
    pdi_bond_intersection cut;
    pdi_bond_find_intersection(paths, node, k, pdi_bond_path_find_closed_group(paths, node, k), &cut);
    pd_grid_position(paths->grid, node, x);
    for (int d = 0; d < PD_DIM; d++) x[d] += cut.fraction * xi[d];
    return cut.fraction;
}

PDI_FN void pdi_bond_find_wall_end(const pd_bonds *bonds, int32_t row, int k, pdi_bond_wall_end *end)
{
    int32_t node = bonds->node[row];
    int group = pdi_bond_path_find_closed_group(&bonds->paths, node, k);
    pdi_bond_intersection cut;
    pdi_bond_find_intersection(&bonds->paths, node, k, group, &cut);
    pd_grid_position(bonds->grid, node, end->surface_point);
    for (int d = 0; d < PD_DIM; d++) {
        double xi = bonds->stencil->xi[k * PD_DIM + d];
        end->end_point[d] = end->surface_point[d] + pd_min(cut.fraction, 1.0) * xi;
        end->surface_point[d] += cut.fraction * xi;
    }
    end->fraction = cut.fraction;
    end->wall_lap = end->wall_curv = 0.0;
    pdi_bond_add_wall_terms(bonds, node, k, &cut, &end->wall_lap, &end->wall_curv);
    end->closed_cell = pdi_bond_path_find_closed_cell(&bonds->paths, node, group);
    end->is_box_side = pdi_grid_is_behind_wall(bonds->grid, end->closed_cell);
    end->is_smooth = cut.is_smooth;
    end->is_grazing = pdi_bond_is_grazing(&bonds->paths, node, k, group, &cut);
}

PDI_FN double pdi_bond_surface_distance(const pd_bonds *bonds, int32_t closed, const double *x)
{
    int shape = pdi_bond_find_surface_shape(bonds->grid, closed, pdi_grid_is_behind_wall(bonds->grid, closed));
    return shape < 0 ? (double)NAN : pdi_grid_signed_distance(bonds->grid, shape, x);
}

PDI_FN int32_t pdi_bond_find_surface_point(const pd_bonds *bonds, int32_t row, int k, double *x, double *normal)
{
    int32_t node = bonds->node[row];
    int group = pdi_bond_path_find_closed_group(&bonds->paths, node, k);
    pdi_bond_intersection cut;
    pdi_bond_find_intersection(&bonds->paths, node, k, group, &cut);
    pd_grid_position(bonds->grid, node, x);
    for (int d = 0; d < PD_DIM; d++) x[d] += cut.fraction * bonds->stencil->xi[k * PD_DIM + d];
    memcpy(normal, cut.normal, sizeof cut.normal);
    if (pdi_bond_is_grazing(&bonds->paths, node, k, group, &cut)) return -1;
    return pdi_bond_path_find_closed_cell(&bonds->paths, node, group);
}

PDI_FN void pdi_bond_sum_wall_velocity(const pd_bonds *bonds, int32_t row, pd_velocity_fn wall, void *user,
                                       double *motion, double *curved)
{
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[row];
    double x[PD_DIM], u[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) motion[d] = 0.0;
    for (int d = 0; d < PD_DIM && curved; d++) curved[d] = 0.0;
    for (int k = 0; k < s->count; k++) {
        pdi_bond_intersection cut;
        double lap = 0.0, curv = 0.0;
        int group = pdi_bond_path_find_closed_group(&bonds->paths, node, k);
        if (group < 0) continue;
        pdi_bond_find_intersection(&bonds->paths, node, k, group, &cut);
        pdi_bond_add_wall_terms(bonds, node, k, &cut, &lap, &curv);
        pd_grid_position(bonds->grid, node, x);
        for (int d = 0; d < PD_DIM; d++) x[d] += cut.fraction * s->xi[k * PD_DIM + d];
        wall(user, x, u);
        for (int d = 0; d < PD_DIM; d++) motion[d] += lap * u[d];
        for (int d = 0; d < PD_DIM && curved; d++) curved[d] += curv * u[d];
    }
}

/* Number 0 .. 2 PD_DIM - 1 of bond k among the nearest neighbours x-, x+, y-, ...; -1: it is longer or diagonal. */
static int pdi_bond_find_axis_neighbour(const pd_stencil *s, int k)
{
    int neighbour = -1, steps = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int n = s->offset[k * PD_DIM + d];
        if (n != 0) neighbour = 2 * d + (n > 0);
        steps += abs(n);
    }
    return steps == 1 ? neighbour : -1;
}

/* Converts matrix [PD_DIM][PD_DIM] in place from inverse moments S^-1 to the flux correction N S^-T [-] (eq. 3.4),
 * with the moments N = norm [PD_DIM] of a full family, for g = w xi / N. */
static void pdi_bond_compute_flux_correction(const double *norm, double *matrix)
{
    double inverse[PD_DIM * PD_DIM];
    memcpy(inverse, matrix, sizeof inverse);
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) matrix[a * PD_DIM + b] = norm[a] * inverse[b * PD_DIM + a];
}

/* Sets closure [PD_DIM][PD_DIM], which the cut bonds of row r add to its moments by a zero normal gradient at the
 * surface (eq. 2.10): the mirror image of the far end is xi - 2 (1-t) (xi.N) N. Bonds with t >= 1 add nothing. With
 * flow it also adds to wall_laplacian and wall_curvature of the row, sets near_smooth_surface to 1 at a smooth surface
 * (never to 0), and neighbour_distance of closed neighbours to -t. The row must be reset before. */
static void pdi_bond_sum_wall_closure(pd_bonds *bonds, int32_t r, double *closure)
{
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    memset(closure, 0, PD_DIM * PD_DIM * sizeof *closure);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        int neighbour = pdi_bond_find_axis_neighbour(s, k);
        pdi_bond_intersection cut;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_intersection(&bonds->paths, node, k, pdi_bond_path_find_closed_group(&bonds->paths, node, k),
                                   &cut);
        double factor = 2.0 * s->base_weight[k] * pd_max(1.0 - cut.fraction, 0.0) * pdi_vec_dot(xi, cut.normal);
        for (int i = 0; i < PD_DIM * PD_DIM; i++) closure[i] += factor * xi[i / PD_DIM] * cut.normal[i % PD_DIM];
        if (bonds->options & PD_BONDS_NO_FLOW) continue;
        pdi_bond_add_wall_terms(bonds, node, k, &cut, &bonds->wall_laplacian[r], &bonds->wall_curvature[r]);
        if (cut.is_smooth) bonds->near_smooth_surface[r] = 1;
        if (neighbour >= 0) bonds->neighbour_distance[(int64_t)r * 2 * PD_DIM + neighbour] = -cut.fraction;
    }
}

/* inverse [PD_DIM][PD_DIM] = inverse of the moments. Where their scaled reciprocal condition number is not above
 * PDI_BOND_MIN_PIVOT (a channel one node wide): of moments plus closure; where that is not above 1e-9: zero. */
static void pdi_bond_invert_moment_closed(const double *norm, const double *moment, const double *closure,
                                          double *inverse)
{
    if (pdi_bond_invert_moment(norm, moment, NULL, PDI_BOND_MIN_PIVOT, inverse)) return;
    if (pdi_bond_invert_moment(norm, moment, closure, 1e-9, inverse)) return;
    memset(inverse, 0, PD_DIM * PD_DIM * sizeof *inverse);
}

/* inverse [PD_DIM][PD_DIM] = inverse moments of row r without flow, as of pdi_bond_invert_moment_closed; the closure is
 * computed only where the open bonds do not span space. Writes nothing to the row with PD_BONDS_NO_FLOW. */
static void pdi_bond_invert_moment_no_flow(pd_bonds *bonds, int32_t r, const double *moment, double *inverse)
{
    double closure[PD_DIM * PD_DIM];
    if (pdi_bond_invert_moment(bonds->full_moment, moment, NULL, PDI_BOND_MIN_PIVOT, inverse)) return;
    pdi_bond_sum_wall_closure(bonds, r, closure);
    pdi_bond_invert_moment_closed(bonds->full_moment, moment, closure, inverse);
}

PDI_FN const double *pdi_bond_get_inverse_moment(const pd_bonds *bonds, int32_t r, double *buffer)
{
    enum { N = PD_DIM * PD_DIM };
    const pd_stencil *s = bonds->stencil;
    pd_bonds rest = *bonds; /* what is written to rows is of flows only */
    double moment[N];
    if (bonds->inverse_moment) return bonds->inverse_moment + (int64_t)r * N;
    memset(moment, 0, sizeof moment);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        int inlet = bonds->grid->kind[bonds->node[r] + bonds->paths.shift[k]] == PD_INLET;
        if (inlet || !pdi_bond_is_open(bonds, r, k)) continue;
        for (int i = 0; i < N; i++) moment[i] += s->base_weight[k] * xi[i / PD_DIM] * xi[i % PD_DIM];
    }
    pdi_bond_invert_moment_no_flow(&rest, r, moment, buffer);
    return buffer;
}

/* Computes all data of row r, whose node is set: open_mask, has_inlet (an open bond ends on an inlet), inverse moments
 * of the open bonds without inlets where they are stored, and with flow the wall terms, near_smooth_surface,
 * neighbour_distance (1: not cut) and the flux correction, whose moments include inlets and the axisymmetric flux
 * factor. Earlier data of the row are lost. */
static void pdi_bond_compute_row(pd_bonds *bonds, int32_t r)
{
    enum { N = PD_DIM * PD_DIM };
    const pd_stencil *s = bonds->stencil;
    const pd_grid *grid = bonds->grid;
    int32_t node = bonds->node[r];
    int at_rest = bonds->options & PD_BONDS_NO_FLOW;
    double moment[N], closure[N], inner[N], entry[N], norm[PD_DIM];
    memset(moment, 0, sizeof moment);
    memset(inner, 0, sizeof inner);
    memset(entry, 0, sizeof entry);
    memset(norm, 0, sizeof norm);
    for (int w = 0; w < bonds->paths.words; w++) bonds->open_mask[(int64_t)w * bonds->capacity + r] = 0;
    bonds->has_inlet[r] = 0;
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double flux = s->base_weight[k] * pdi_bond_get_flux_factor(bonds, node, k);
        for (int d = 0; d < PD_DIM; d++) norm[d] += flux * xi[d] * xi[d];
        if (pdi_bond_path_find_closed_group(&bonds->paths, node, k) >= 0) continue;
        bonds->open_mask[(int64_t)(k >> 5) * bonds->capacity + r] |= 1u << (k & 31);
        int inlet = grid->kind[node + bonds->paths.shift[k]] == PD_INLET;
        if (inlet) bonds->has_inlet[r] = 1;
        for (int i = 0; i < N; i++) {
            if (!inlet) moment[i] += s->base_weight[k] * xi[i / PD_DIM] * xi[i % PD_DIM];
            (inlet ? entry : inner)[i] += flux * xi[i / PD_DIM] * xi[i % PD_DIM];
        }
    }
    if (at_rest) {
        if (bonds->inverse_moment)
            pdi_bond_invert_moment_no_flow(bonds, r, moment, bonds->inverse_moment + (int64_t)r * N);
        return;
    }
    for (int i = 0; i < 2 * PD_DIM; i++) bonds->neighbour_distance[(int64_t)r * 2 * PD_DIM + i] = 1.0;
    bonds->wall_laplacian[r] = bonds->wall_curvature[r] = bonds->near_smooth_surface[r] = 0;
    pdi_bond_sum_wall_closure(bonds, r, closure);
    pdi_bond_invert_moment_closed(bonds->full_moment, moment, closure, bonds->inverse_moment + (int64_t)r * N);
    double *advecting = bonds->flux_correction + (int64_t)r * N;
    for (int i = 0; i < N; i++) entry[i] += inner[i];
    pdi_bond_invert_moment_closed(norm, entry, closure, advecting);
    pdi_bond_compute_flux_correction(norm, advecting);
}

PDI_COLD_BEGIN
PDI_FN void pdi_bond_list_row_arrays(pdi_array_visitor *owner, void *object)
{
    pd_bonds *bonds = (pd_bonds *)object;
    int64_t rows = bonds->capacity;
    PDI_ARRAY(owner, bonds, node, rows, "1");
    PDI_ARRAY(owner, bonds, open_mask, rows * bonds->paths.words, "1");
    PDI_ARRAY(owner, bonds, has_inlet, rows, "1");
    if (bonds->options & PD_BONDS_LOW_MEMORY) return;
    PDI_ARRAY(owner, bonds, inverse_moment, rows * PD_DIM * PD_DIM, "1");
    if (bonds->options & PD_BONDS_NO_FLOW) return;
    PDI_ARRAY(owner, bonds, near_smooth_surface, rows, "1");
    PDI_ARRAY(owner, bonds, neighbour_distance, rows * 2 * PD_DIM, "1");
    PDI_ARRAY(owner, bonds, wall_laplacian, rows, "1/m2");
    PDI_ARRAY(owner, bonds, wall_curvature, rows, "1");
    PDI_ARRAY(owner, bonds, flux_correction, rows * PD_DIM * PD_DIM, "1");
}

/* Copies all arrays of the first `rows` rows but node, open_mask and has_inlet to `to`, which has room for them and the
 * same options: nothing with PD_BONDS_LOW_MEMORY, inverse moments alone with PD_BONDS_NO_FLOW. */
static void pdi_bond_copy_row_data(const pd_bonds *from, size_t rows, pd_bonds *to)
{
    if (from->options & PD_BONDS_LOW_MEMORY) return;
    memcpy(to->inverse_moment, from->inverse_moment, rows * PD_DIM * PD_DIM * sizeof *from->inverse_moment);
    if (from->options & PD_BONDS_NO_FLOW) return;
    memcpy(to->near_smooth_surface, from->near_smooth_surface, rows * sizeof *from->near_smooth_surface);
    memcpy(to->neighbour_distance, from->neighbour_distance, rows * 2 * PD_DIM * sizeof *from->neighbour_distance);
    memcpy(to->wall_laplacian, from->wall_laplacian, rows * sizeof *from->wall_laplacian);
    memcpy(to->wall_curvature, from->wall_curvature, rows * sizeof *from->wall_curvature);
    memcpy(to->flux_correction, from->flux_correction, rows * PD_DIM * PD_DIM * sizeof *from->flux_correction);
}

/* Grows the arrays of rows to a capacity of rows + rows/4 + 64 when `rows` exceeds the capacity, else does nothing; the
 * present rows are kept. All arrays keep one common capacity. On failure nothing changes. */
static pd_status pdi_bond_reserve(pd_ctx *ctx, int32_t rows, pd_bonds *b)
{
    if (rows <= b->capacity) return PD_OK;
    pd_bonds grown = *b;
    grown.capacity = rows + rows / 4 + 64;
    pd_status status = pdi_array_registry_build(ctx, pdi_bond_list_row_arrays, &grown);
    if (status == PD_OK) {
        size_t used = (size_t)b->rows;
        pd_bonds old = *b;
        if (used) {
            memcpy(grown.node, b->node, used * sizeof *b->node);
            for (int w = 0; w < b->paths.words; w++)
                memcpy(grown.open_mask + (int64_t)w * grown.capacity, b->open_mask + (int64_t)w * b->capacity,
                       used * sizeof *b->open_mask);
            memcpy(grown.has_inlet, b->has_inlet, used * sizeof *b->has_inlet);
            pdi_bond_copy_row_data(b, used, &grown);
        }
        *b = grown;
        grown = old;
    }
    pdi_array_registry_free(ctx, pdi_bond_list_row_arrays, &grown);
    return status;
}

/* Exchanges rows r and q of an array with `count` doubles a row. */
static void pdi_bond_swap_doubles(double *x, int count, int32_t r, int32_t q)
{
    for (int i = 0; i < count; i++) {
        double keep = x[(int64_t)r * count + i];
        x[(int64_t)r * count + i] = x[(int64_t)q * count + i];
        x[(int64_t)q * count + i] = keep;
    }
}

/* Exchanges rows r and q of an array of bytes. */
static void pdi_bond_swap_bytes(uint8_t *x, int32_t r, int32_t q)
{
    uint8_t keep = x[r];
    x[r] = x[q];
    x[q] = keep;
}

/* Exchanges rows r and q in all arrays, and updates row_of_node of their nodes. */
static void pdi_bond_swap_rows(pd_bonds *b, int32_t r, int32_t q)
{
    int32_t node = b->node[r];
    for (int w = 0; w < b->paths.words; w++) {
        uint32_t *mask = b->open_mask + (int64_t)w * b->capacity, keep = mask[r];
        mask[r] = mask[q];
        mask[q] = keep;
    }
    b->node[r] = b->node[q];
    b->node[q] = node;
    b->row_of_node[b->node[r]] = r;
    b->row_of_node[b->node[q]] = q;
    pdi_bond_swap_bytes(b->has_inlet, r, q);
    if (b->options & PD_BONDS_LOW_MEMORY) return;
    pdi_bond_swap_doubles(b->inverse_moment, PD_DIM * PD_DIM, r, q);
    if (b->options & PD_BONDS_NO_FLOW) return;
    pdi_bond_swap_bytes(b->near_smooth_surface, r, q);
    pdi_bond_swap_doubles(b->wall_laplacian, 1, r, q);
    pdi_bond_swap_doubles(b->wall_curvature, 1, r, q);
    pdi_bond_swap_doubles(b->neighbour_distance, 2 * PD_DIM, r, q);
    pdi_bond_swap_doubles(b->flux_correction, PD_DIM * PD_DIM, r, q);
}
PDI_COLD_END

/* Sorts the rows: plain ones in the order of their nodes, then those with bonds to inlets, in the same order. Sets
 * rows_without_inlet and row_of_node. */
static void pdi_bond_sort_rows(pd_bonds *b)
{
    int32_t next = 0;
    for (int inlet = 0; inlet < 2; inlet++) {
        for (int32_t node = 0; node < b->grid->total && next < b->rows; node++) {
            int32_t r = b->row_of_node[node];
            if (r < 0 || b->has_inlet[r] != inlet) continue;
            if (r != next) pdi_bond_swap_rows(b, r, next);
            next++;
        }
        if (!inlet) b->rows_without_inlet = next;
    }
}

/* Describes the arrays of pd_node_ranges to the array registry. */
static void pdi_bond_list_range_arrays(pdi_array_visitor *owner, void *object)
{
    pd_node_ranges *list = (pd_node_ranges *)object;
    PDI_ARRAY(owner, list, first, list->capacity, "1");
    PDI_ARRAY(owner, list, length, list->capacity, "1");
}

/* Stores the ranges of fluid nodes with plain rows (cut 1) or without row (full families, cut 0) in `list`, as many as
 * it has room for; list->count is left alone. Nodes with a bond to an inlet are in neither. Returns the number of all
 * ranges, which may exceed the capacity. */
static int32_t pdi_bond_find_ranges(const pd_bonds *b, int cut, pd_node_ranges *list)
{
    int32_t count = 0, length = 0;
    for (int32_t node = 0; node <= b->grid->total; node++) {
        int32_t row = node < b->grid->total ? b->row_of_node[node] : -1;
        int fluid = node < b->grid->total && b->grid->kind[node] == PD_FLUID;
        if (fluid && (cut ? row >= 0 && row < b->rows_without_inlet : row < 0)) {
            length++;
            continue;
        }
        if (length == 0) continue;
        if (count < list->capacity) {
            list->first[count] = node - length;
            list->length[count] = length;
        }
        count++;
        length = 0;
    }
    return count;
}

/* Finds the ranges of a list again, sets its count, and grows it when it is too short; cut: as of pdi_bond_find_ranges.
 * On failure the list is empty. */
static pd_status pdi_bond_update_ranges(pd_ctx *ctx, const pd_bonds *b, int cut, pd_node_ranges *list)
{
    int32_t count = pdi_bond_find_ranges(b, cut, list);
    if (count > list->capacity) {
        list->count = 0;
        PD_TRY(
            pdi_array_registry_rebuild(ctx, pdi_bond_list_range_arrays, list, &list->capacity, count + count / 4 + 16));
        pdi_bond_find_ranges(b, cut, list);
    }
    list->count = count;
    return PD_OK;
}

/* Sorts the rows and updates both lists of ranges, which loops over nodes go by. */
static pd_status pdi_bond_update_order(pd_ctx *ctx, pd_bonds *b)
{
    pdi_bond_sort_rows(b);
    PD_TRY(pdi_bond_update_ranges(ctx, b, 0, &b->full_ranges));
    return pdi_bond_update_ranges(ctx, b, 1, &b->truncated_ranges);
}

/* Updates the row of a node. It needs one when it is fluid and its family is truncated, or with PD_BONDS_ALL_ROWS; a
 * missing row is appended, and the row computed anew. Else a present row is removed, and the last row takes its number.
 * Rows are unsorted and ranges out of date afterwards. On failure nothing changes. */
static pd_status pdi_bond_update_node(pd_ctx *ctx, int32_t node, pd_bonds *b)
{
    int needed =
        b->grid->kind[node] == PD_FLUID && ((b->options & PD_BONDS_ALL_ROWS) || !pdi_bond_is_family_full(b, node));
    int32_t r = b->row_of_node[node];
    if (needed && r < 0) {
        PD_TRY(pdi_bond_reserve(ctx, b->rows + 1, b));
        r = b->row_of_node[node] = b->rows++;
        b->node[r] = node;
    }
    if (needed) {
        pdi_bond_compute_row(b, r);
        return PD_OK;
    }
    if (r < 0) return PD_OK;
    /* the last row takes the free place */
    int32_t last = b->rows - 1;
    if (r != last) pdi_bond_swap_rows(b, r, last);
    b->row_of_node[node] = -1;
    b->rows--;
    return PD_OK;
}

/* Nodes between two checks for cancellation: a tenth of a second where each needs a row in 3D. */
#define PDI_BOND_POLL_INTERVAL 4096

PDI_COLD_BEGIN
/* Describes the arrays of pd_bonds with one entry a node to the array registry. */
static void pdi_bond_list_node_arrays(pdi_array_visitor *owner, void *object)
{
    pd_bonds *bonds = (pd_bonds *)object;
    const pd_stencil *stencil = bonds->stencil;
    if (!stencil) return;
    PDI_ARRAY(owner, bonds, line_shift, stencil->line_first[stencil->line_kinds], "1");
    PDI_ARRAY(owner, bonds, row_of_node, bonds->grid->total, "1");
    PDI_ARRAY(owner, bonds, node_version, bonds->grid->total, "1");
}

/* Does the work of pd_bonds_build on overwritten `bonds`; on failure the caller frees what it has allocated. Polls for
 * cancellation (PD_CANCELLED) every PDI_BOND_POLL_INTERVAL nodes. */
static pd_status pdi_bond_build_inner(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, int options,
                                      pd_bonds *bonds)
{
    memset(bonds, 0, sizeof *bonds);
    if ((options & PD_BONDS_LOW_MEMORY) && !(options & PD_BONDS_NO_FLOW))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "bonds", "PD_BONDS_LOW_MEMORY, expected PD_BONDS_NO_FLOW with it");
    bonds->stencil = stencil;
    bonds->grid = grid;
    bonds->options = options;
    bonds->version = 1;
    for (int k = 0; k < stencil->count; k++)
        for (int d = 0; d < PD_DIM; d++)
            bonds->full_moment[d] +=
                stencil->base_weight[k] * stencil->xi[k * PD_DIM + d] * stencil->xi[k * PD_DIM + d];
    PD_TRY(pdi_bond_path_build(ctx, stencil, grid, &bonds->paths));
    PD_TRY(pdi_array_registry_build(ctx, pdi_bond_list_node_arrays, bonds));
    PD_TRY(pdi_ghosts_build(ctx, grid, &bonds->ghosts));
    PD_TRY(pdi_active_range_build(ctx, grid, &bonds->active_ranges));
    PD_TRY(pdi_axisym_build(ctx, stencil, grid, &bonds->axisym));
    pdi_grid_compute_line_shifts(grid, stencil, bonds->line_shift);
    int32_t rows = 0;
    for (int32_t node = 0; node < grid->total; node++) {
        bonds->row_of_node[node] = -1;
        if (node % PDI_BOND_POLL_INTERVAL == 0) PD_TRY(pd_check_cancel(ctx, "bonds: rows", node));
        if (grid->kind[node] == PD_FLUID)
            rows += (options & PD_BONDS_ALL_ROWS) || !pdi_bond_is_family_full(bonds, node);
    }
    PD_TRY(pdi_bond_reserve(ctx, rows, bonds));
    for (int32_t node = 0; node < grid->total; node++) {
        if (node % PDI_BOND_POLL_INTERVAL == 0) PD_TRY(pd_check_cancel(ctx, "bonds", node));
        if (grid->kind[node] == PD_FLUID) PD_TRY(pdi_bond_update_node(ctx, node, bonds));
    }
    return pdi_bond_update_order(ctx, bonds);
}

pd_status pd_bonds_build(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, int options, pd_bonds *bonds)
{
    pd_status status = pdi_bond_build_inner(ctx, stencil, grid, options, bonds);
    if (status < 0) pd_bonds_free(ctx, bonds);
    return status;
}
PDI_COLD_END

pd_status pd_bonds_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_bonds *bonds)
{
    const pd_grid *grid = bonds->grid;
    const pd_stencil *s = bonds->stencil;
    PD_TRY(pdi_ghosts_update(ctx, &bonds->ghosts));
    if (count > 0) bonds->version++;
    for (int32_t c = 0; c < count; c++) {
        int i[PD_DIM], j[PD_DIM];
        bonds->node_version[changed[c]] = bonds->version;
        pd_grid_index(grid, changed[c], i);
        for (int k = 0; k < s->count; k++) {
            /* who has an image of the node in its family */
            for (int d = 0; d < PD_DIM; d++) j[d] = i[d] + s->offset[k * PD_DIM + d];
            pdi_grid_fold_index(grid, j);
            int32_t node = pd_grid_node(grid, j);
            if (grid->kind[node] == PD_FLUID) bonds->node_version[node] = bonds->version;
        }
    }
    for (int32_t node = 0; node < grid->total && count > 0; node++)
        if (bonds->node_version[node] == bonds->version) PD_TRY(pdi_bond_update_node(ctx, node, bonds));
    return pdi_bond_update_order(ctx, bonds);
}

PDI_COLD_BEGIN
/* 1: the row of a node is in its place, and the node lies in the list of ranges that it belongs to and in no other; at
 * [2]: the ranges of both lists that end behind the node before it, which move on. */
static int pdi_bond_is_node_in_order(const pd_bonds *b, int32_t node, int32_t *at)
{
    int32_t row = b->row_of_node[node], first = b->rows_without_inlet;
    int fluid = b->grid->kind[node] == PD_FLUID, plain = row < first;
    if (row < -1 || row >= b->rows || (row > 0 && row != first && b->node[row - 1] >= node)) return 0;
    if (row >= 0 && (!fluid || b->node[row] != node || b->has_inlet[row] == plain)) return 0;
    for (int cut = 0; cut < 2; cut++) {
        const pd_node_ranges *list = cut ? &b->truncated_ranges : &b->full_ranges;
        while (at[cut] < list->count && list->first[at[cut]] + list->length[at[cut]] <= node) at[cut]++;
        int inside = at[cut] < list->count && list->first[at[cut]] <= node;
        if (inside != (fluid && plain && (row >= 0) == cut)) return 0;
    }
    return 1;
}

/* Checks the open bonds of row r: from fluid nodes at their far ends they are open, too, by the cells of the grid and
 * by the rows of these nodes. PD_ERR_INTERNAL: one is not. */
static pd_status pdi_bond_validate_row(pd_ctx *ctx, const pd_bonds *b, int32_t r)
{
    for (int k = 0; k < b->stencil->count; k++) {
        if (!pdi_bond_is_open(b, r, k)) continue;
        int32_t other = b->node[r] + b->paths.shift[k], back = b->stencil->count - 1 - k;
        if (b->grid->kind[other] != PD_FLUID) continue;
        int32_t row = b->row_of_node[other];
        if (pdi_bond_path_find_closed_group(&b->paths, other, back) >= 0 ||
            (row >= 0 && !pdi_bond_is_open(b, row, back)))
            return pd_fail(ctx, PD_ERR_INTERNAL, "bond", "the bond from node %d to node %d is open one way only",
                           (int)b->node[r], (int)other);
    }
    return PD_OK;
}

pd_status pd_bonds_validate(pd_ctx *ctx, const pd_bonds *b)
{
    int64_t covered = b->rows - b->rows_without_inlet;
    int32_t rows = 0, at[2] = {0, 0};
    for (int32_t k = 0; k < b->full_ranges.count; k++) covered += b->full_ranges.length[k];
    for (int32_t k = 0; k < b->truncated_ranges.count; k++) covered += b->truncated_ranges.length[k];
    for (int32_t node = 0; node < b->grid->total; node++) {
        rows += b->row_of_node[node] >= 0;
        if (!pdi_bond_is_node_in_order(b, node, at))
            return pd_fail(ctx, PD_ERR_INTERNAL, "bond", "the row or range of node %d is out of order", (int)node);
    }
    if (rows != b->rows || covered != pdi_grid_count_kind(b->grid, PD_FLUID))
        return pd_fail(ctx, PD_ERR_INTERNAL, "bond",
                       "%d nodes for %d rows, rows and ranges for %.0f fluid nodes of %.0f", (int)rows, (int)b->rows,
                       (double)covered, (double)pdi_grid_count_kind(b->grid, PD_FLUID));
    for (int32_t r = 0; r < b->rows; r++) PD_TRY(pdi_bond_validate_row(ctx, b, r));
    return PD_OK;
}

void pd_bonds_free(pd_ctx *ctx, pd_bonds *b)
{
    pdi_array_registry_free(ctx, pdi_bond_list_node_arrays, b);
    pdi_array_registry_free(ctx, pdi_bond_list_row_arrays, b);
    pdi_array_registry_free(ctx, pdi_bond_list_range_arrays, &b->full_ranges);
    pdi_array_registry_free(ctx, pdi_bond_list_range_arrays, &b->truncated_ranges);
    pdi_ghosts_free(ctx, &b->ghosts);
    pdi_active_range_free(ctx, &b->active_ranges);
    pdi_axisym_free(ctx, &b->axisym);
    pdi_bond_path_free(ctx, &b->paths);
    memset(b, 0, sizeof *b);
}
PDI_COLD_END
