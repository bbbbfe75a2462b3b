/* near_wall: see near_wall.h */
#include "flow/near_wall.h"
#include "core/vec.h"
#include "lattice/quadratic_fit.h"
#include "lattice/surface.h"
#include <math.h>
#include <string.h>

/* [cells] step of finite differences of a distance; closer than this is on the surface */
#define PDI_NEAR_WALL_STEP 1e-3
/* [-] curvature times cell size above which a surface is an edge, as for bonds */
#define PDI_NEAR_WALL_EDGE_CURVATURE 0.5
#define PDI_NEAR_WALL_RADIUS_SQUARED 5   /* squared distance [cells] within which nodes take part in a fit */
#define PDI_NEAR_WALL_MAX_NODES 57       /* most nodes of a fit: those within sqrt(5) cells in 3D */
#define PDI_NEAR_WALL_MAX_DISTANCE 1.5   /* [cells] farthest surface whose pressure slope is used */
#define PDI_NEAR_WALL_TERMS (PD_DIM + 1) /* unknowns of the fit of eq. 1.12 */
#define PDI_NEAR_WALL_SINGULAR 1e-4      /* pivot over diagonal below which a fit is singular */

/* Nodes of a fit, and the surface beside the point. */
typedef struct pdi_near_wall_fit_nodes {
    const pd_bonds *bonds;
    int count;
    int32_t node[PDI_NEAR_WALL_MAX_NODES];
    int offset[PDI_NEAR_WALL_MAX_NODES][PD_DIM]; /* from the first one */
    double wall_point[PD_DIM], normal[PD_DIM];   /* [m] a point on the surface beside x, and its normal there */
    int32_t wall_cell;
} pdi_near_wall_fit_nodes;

/* Adds a node at the offset `step` [cells] from the first one, unless it is farther than sqrt(5) cells, already there,
 * or the list is full. */
static void pdi_near_wall_add_node(pdi_near_wall_fit_nodes *sight, int32_t node, const int *step)
{
    int square = 0;
    for (int d = 0; d < PD_DIM; d++) square += step[d] * step[d];
    if (square > PDI_NEAR_WALL_RADIUS_SQUARED || sight->count == PDI_NEAR_WALL_MAX_NODES) return;
    for (int q = 0; q < sight->count; q++)
        if (sight->node[q] == node) return;
    sight->node[sight->count] = node;
    memcpy(sight->offset[sight->count++], step, sizeof sight->offset[0]);
}

/* Collects the nodes of a fit: `node`, the ends of its open bonds to adjacent cells, and of theirs, diagonals included;
 * inlets are left out, and ghosts lead no further. Resets the list first. */
static void pdi_near_wall_find_nodes(pdi_near_wall_fit_nodes *sight, int32_t node)
{
    const pd_bonds *bonds = sight->bonds;
    const pd_stencil *s = bonds->stencil;
    int start = 0, none[PD_DIM];
    memset(none, 0, sizeof none);
    sight->count = 0;
    pdi_near_wall_add_node(sight, node, none);
    for (int pass = 0; pass < 2; pass++) {
        int end = sight->count;
        for (int q = start; q < end; q++) {
            int32_t row = bonds->row_of_node[sight->node[q]];
            if (bonds->grid->kind[sight->node[q]] != PD_FLUID) continue;
            for (int k = 0; k < s->count; k++) {
                int32_t far = sight->node[q] + bonds->paths.shift[k];
                int step[PD_DIM], largest = 0;
                for (int d = 0; d < PD_DIM; d++) {
                    int n = s->offset[k * PD_DIM + d];
                    step[d] = sight->offset[q][d] + n;
                    largest = n > largest ? n : -n > largest ? -n : largest;
                }
                if (largest > 1 || bonds->grid->kind[far] == PD_INLET || (row >= 0 && !pdi_bond_is_open(bonds, row, k)))
                    continue;
                pdi_near_wall_add_node(sight, far, step);
            }
        }
        start = end;
    }
}

/* Signed distance [m] of x from the surface, positive in the fluid, and its normal. A wall cell outside of the box:
 * that from the plane through wall_point. Returns 1; 0: wall_point is on no smooth surface, or an edge is near. */
static int pdi_near_wall_compute_distance(const pdi_near_wall_fit_nodes *sight, const double *x, double *distance,
                                          double *normal)
{
    const pd_bonds *bonds = sight->bonds;
    int i[PD_DIM];
    double at[PD_DIM];
    pd_grid_index(bonds->grid, sight->wall_cell, i);
    memcpy(normal, sight->normal, sizeof sight->normal);
    for (int d = 0; d < PD_DIM; d++) at[d] = x[d] - sight->wall_point[d];
    *distance = pdi_vec_dot(at, normal);
    if (!pd_grid_is_inside(bonds->grid, i)) return 1;
    double level = pdi_bond_surface_distance(bonds, sight->wall_cell, sight->wall_point);
    if (!(fabs(level) < PDI_NEAR_WALL_STEP * pdi_vec_min(bonds->grid->h))) return 0;
    return pdi_surface_compute_normal(bonds, sight->wall_cell, x, PDI_NEAR_WALL_STEP, distance, normal);
}

/* *slope [m/s2] = derivative of the kinematic pressure along the normal at the wall, from the friction of the normal
 * velocity, which begins with the square of the distance, and the body force (eq. 1.12). Returns 1; 0: the distance of
 * a node is not known, a node is at the wall point, or the fit is singular. */
static int pdi_near_wall_compute_pressure_slope(const pdi_near_wall_fit_nodes *sight, const pd_flow *flow,
                                                double *slope)
{
    enum { terms = PDI_NEAR_WALL_TERMS };
    const pd_grid *grid = flow->grid;
    double moment[PDI_NEAR_WALL_TERMS * PDI_NEAR_WALL_TERMS], right[PDI_NEAR_WALL_TERMS], least[PDI_NEAR_WALL_TERMS];
    double unit[PDI_NEAR_WALL_TERMS], h = grid->h[0];
    int last = 0;
    memset(moment, 0, sizeof moment);
    memset(right, 0, sizeof right);
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(sight->normal[d]) > fabs(sight->normal[last])) last = d;
    for (int q = 0; q < sight->count; q++) {
        double x[PD_DIM], normal[PD_DIM], d, speed = 0.0, square = 0.0, term[PDI_NEAR_WALL_TERMS];
        pd_grid_position(grid, sight->node[q], x);
        if (!pdi_near_wall_compute_distance(sight, x, &d, normal)) return 0;
        d /= h;
        term[0] = d * d;
        term[1] = d * d * d;
        for (int a = 0, at = 2; a < PD_DIM; a++) {
            double way = (x[a] - sight->wall_point[a]) / h;
            square += way * way;
            speed += normal[a] * flow->u[(int64_t)a * grid->total + sight->node[q]];
            if (a != last) term[at++] = d * d * (way - d * sight->normal[a]);
        }
        if (!(square > 0.0)) return 0;
        for (int a = 0; a < terms; a++) {
            right[a] += term[a] * speed / (square * square);
            for (int b = 0; b < terms; b++) moment[a * terms + b] += term[a] * term[b] / (square * square);
        }
    }
    for (int a = 0; a < terms; a++) {
        if (!(moment[a * terms + a] > 0.0)) return 0;
        least[a] = PDI_NEAR_WALL_SINGULAR;
        unit[a] = 1.0 / sqrt(moment[a * terms + a]);
    }
    for (int a = 0; a < terms; a++) {
        right[a] *= unit[a];
        for (int b = 0; b < terms; b++) moment[a * terms + b] *= unit[a] * unit[b];
    }
    if (!pdi_vec_cholesky_any_order(terms, terms, least, moment)) return 0;
    pdi_vec_cholesky_solve(terms, terms, moment, right);
    *slope = flow->nu * 2.0 * right[0] * unit[0] / (h * h);
    double push[PD_DIM];
    memset(push, 0, sizeof push);
    if (flow->body_force_fn) flow->body_force_fn(flow->body_force_user, sight->wall_point, push);
    for (int d = 0; d < PD_DIM; d++) *slope += sight->normal[d] * (flow->force[d] + push[d]);
    return 1;
}

PDI_FN int pdi_near_wall_compute_curvature(const pd_bonds *bonds, int32_t wall_cell, const double *x, double *curvature)
{
    const pd_grid *grid = bonds->grid;
    double at[PD_DIM], sharpest = 0.0;
    *curvature = 0.0;
    memcpy(at, x, sizeof at);
    pdi_grid_fold_position(grid, at);
    for (int d = 0; d < PD_DIM; d++) {
        double reach = 2.0 * PDI_NEAR_WALL_STEP * grid->h[d];
        if (pd_grid_is_inlet_or_outlet(grid->side[2 * d])) at[d] = pd_max(at[d], grid->lo[d] + reach);
        if (pd_grid_is_inlet_or_outlet(grid->side[2 * d + 1])) at[d] = pd_min(at[d], grid->hi[d] - reach);
    }
    double middle = pdi_bond_surface_distance(bonds, wall_cell, at);
    for (int d = 0; d < PD_DIM; d++) {
        double eps = PDI_NEAR_WALL_STEP * grid->h[d], second = -2.0 * middle, here = at[d];
        for (int up = 0; up < 2; up++) {
            at[d] = here + (up ? eps : -eps);
            second += pdi_bond_surface_distance(bonds, wall_cell, at);
        }
        at[d] = here;
        *curvature += second / (eps * eps);
        sharpest = pd_max(sharpest, fabs(second) / (eps * eps) * grid->h[d]);
    }
    return sharpest < PDI_NEAR_WALL_EDGE_CURVATURE;
}

PDI_FN int pdi_near_wall_compute_shear(const pd_flow *flow, int32_t node, const double *x, double *slope)
{
    enum { terms = PD_DIM };
    const pd_grid *grid = flow->grid;
    pdi_near_wall_fit_nodes sight;
    double moment[PD_DIM * PD_DIM], right[PD_DIM][PD_DIM], least[PD_DIM], h = grid->h[0], mean, normal[PD_DIM];
    int last = 0;
    sight.bonds = flow->bonds;
    if (!pdi_surface_find_nearest(flow->bonds, node, x, sight.wall_point, sight.normal, &sight.wall_cell)) return 0;
    if (!(pdi_bond_surface_distance(flow->bonds, sight.wall_cell, sight.wall_point) < HUGE_VAL)) mean = 0.0;
    else if (!pdi_near_wall_compute_curvature(flow->bonds, sight.wall_cell, sight.wall_point, &mean)) return 0;
    double round = grid->circumference ? sight.normal[PD_DIM - 1] / fabs(sight.wall_point[PD_DIM - 1]) : 0.0;
    /* a surface of revolution bends round the axis, too */
    if (fabs(round) * h < PDI_NEAR_WALL_EDGE_CURVATURE) mean += round;
    pdi_near_wall_find_nodes(&sight, node);
    memset(moment, 0, sizeof moment);
    memset(right, 0, sizeof right);
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(sight.normal[d]) > fabs(sight.normal[last])) last = d;
    for (int q = 0; q < sight.count; q++) {
        int32_t from = sight.node[q];
        double at[PD_DIM], foot[PD_DIM], wall[PD_DIM], d, square = 0.0, term[PD_DIM];
        pd_grid_position(grid, from, at);
        if (grid->kind[from] != PD_FLUID && grid->kind[from] != PD_IMAGE) continue;
        if (!pdi_near_wall_compute_distance(&sight, at, &d, normal)) return 0;
        if (!(d > 0.0)) continue;
        for (int a = 0; a < PD_DIM; a++) foot[a] = at[a] - d * normal[a];
        memset(wall, 0, sizeof wall);
        if (flow->wall) flow->wall(flow->wall_user, foot, wall);
        term[0] = d / h * (1.0 - 0.5 * mean * d);
        for (int a = 0, k = 1; a < PD_DIM; a++) {
            double way = (at[a] - sight.wall_point[a]) / h;
            square += way * way;
            if (a != last) term[k++] = term[0] * (foot[a] - sight.wall_point[a]) / h;
        }
        for (int e = 0; e < PD_DIM; e++) {
            int64_t of = (int64_t)e * grid->total + from;
            double bend =
                (flow->pressure_grad[of] - pdi_flow_get_body_force(flow, e, pd_grid_find_source(grid, from, NULL))) /
                flow->nu;
            double rest = flow->u[of] - wall[e] - 0.5 * bend * d * d;
            for (int a = 0; a < terms; a++) right[e][a] += term[a] * rest / (square * square);
        }
        for (int a = 0; a < terms * terms; a++)
            moment[a] += term[a / terms] * term[a % terms] / (square * square);
    }
    for (int a = 0; a < terms; a++) least[a] = PDI_NEAR_WALL_SINGULAR * moment[a * terms + a];
    if (!(moment[0] > 0.0) || !pdi_vec_cholesky_any_order(terms, terms, least, moment)) return 0;
    for (int e = 0; e < PD_DIM; e++) {
        pdi_vec_cholesky_solve(terms, terms, moment, right[e]);
        slope[e] = right[e][0] / h;
    }
    double along = pdi_vec_dot(slope, sight.normal);
    for (int e = 0; e < PD_DIM; e++) slope[e] -= along * sight.normal[e];
    return 1;
}

PDI_FN double pdi_near_wall_interpolate_pressure(const pd_bonds *bonds, const pd_flow *flow, const double *p,
                                                 int32_t node, const double *x)
{
    pdi_near_wall_fit_nodes sight;
    pdi_quadratic_fit fit;
    double at[PD_DIM], slope, square = 0.0, moves = 0.0;
    sight.bonds = bonds;
    pdi_near_wall_find_nodes(&sight, node);
    pdi_quadratic_fit_init(&fit, x, bonds->grid->h);
    for (int q = 0; q < sight.count; q++) {
        pd_grid_position(bonds->grid, sight.node[q], at);
        pdi_quadratic_fit_add_value(&fit, at, p[sight.node[q]]);
    }
    if (!flow || !pdi_surface_find_nearest(bonds, node, x, sight.wall_point, sight.normal, &sight.wall_cell))
        return pdi_quadratic_fit_solve(&fit);
    for (int d = 0; d < PD_DIM; d++) {
        double way = (sight.wall_point[d] - x[d]) / bonds->grid->h[d];
        square += way * way;
        at[d] = 0.0;
    }
    if (flow->wall) flow->wall(flow->wall_user, sight.wall_point, at);
    for (int d = 0; d < PD_DIM; d++) moves = pd_max(moves, fabs(at[d]));
    int beside = square < PDI_NEAR_WALL_MAX_DISTANCE * PDI_NEAR_WALL_MAX_DISTANCE && !(moves > 0.0);
    if (beside && pdi_near_wall_compute_pressure_slope(&sight, flow, &slope))
        pdi_quadratic_fit_add_derivative(&fit, sight.wall_point, sight.normal, slope);
    return pdi_quadratic_fit_solve(&fit);
}

#undef PDI_NEAR_WALL_STEP
#undef PDI_NEAR_WALL_EDGE_CURVATURE
#undef PDI_NEAR_WALL_RADIUS_SQUARED
#undef PDI_NEAR_WALL_MAX_NODES
#undef PDI_NEAR_WALL_MAX_DISTANCE
#undef PDI_NEAR_WALL_TERMS
#undef PDI_NEAR_WALL_SINGULAR
