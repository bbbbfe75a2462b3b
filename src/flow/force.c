/* force: see force.h */
#include "flow/force.h"
#include "flow/near_wall.h"
#include "core/vec.h"
#include "core/par.h"
#include "lattice/surface.h"
#include "lattice/cut_cell.h"
#include <math.h>
#include <string.h>

#define PDI_FORCE_SURFACE_OFFSET 1e-3 /* [cells] a point closer to a surface lies on it */

/* Sets the radial force to 0 on axisymmetric grids: around an axis it cancels. Nothing on planar ones. */
static void pdi_force_remove_radial(const pd_grid *grid, double *force)
{
    if (grid->circumference) force[PD_DIM - 1] = 0.0;
}

/* Arguments of a surface force: between lo and hi, of one shape, of the sides or of all. sum: friction, then
 * pressure. */
typedef struct pdi_force_query {
    const pd_flow *flow;
    const double *lo, *hi;
    int shape;
    int32_t last_row; /* row whose friction axes are cached in `axes` */
    int last_axes;
    pdi_compensated_sum sum[2 * PD_DIM];
} pdi_force_query;

/* 1: the closed cell at the end of a bond, or behind a face, is on the shape of the query. side: 1 for sides of the
 * box. PD_FORCE_ALL: always. Sides belong to PD_FORCE_BOX_SIDES alone, and it to sides alone. Else: the centre of the
 * cell is inside the shape, or outside by no more than the surface tolerance. */
static int pdi_force_is_on_shape(const pdi_force_query *q, int32_t closed, int side)
{
    double x[PD_DIM];
    if (q->shape == PD_FORCE_ALL) return 1;
    if (side || q->shape == PD_FORCE_BOX_SIDES) return side && q->shape == PD_FORCE_BOX_SIDES;
    pd_grid_position(q->flow->grid, closed, x);
    return pdi_grid_signed_distance(q->flow->grid, q->shape, x) <= pd_shape_surface_tolerance(q->flow->grid->h, x);
}

/* Fraction of the closed bonds of row r, by the sizes of their gradient weights, that end on the shape of the query; 0:
 * none is closed. */
static double pdi_force_compute_shape_fraction(const pdi_force_query *q, int32_t r)
{
    const pd_bonds *bonds = q->flow->bonds;
    double all = 0.0, owned = 0.0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        double size = pdi_vec_norm(bonds->stencil->gradient_weight + k * PD_DIM);
        pdi_bond_wall_end end;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_wall_end(bonds, r, k, &end);
        all += size;
        if (pdi_force_is_on_shape(q, end.closed_cell, end.is_box_side)) owned += size;
    }
    return all > 0.0 ? owned / all : 0.0;
}

/* rub [PD_DIM] = force of friction of row r on the surface, over rho, for the whole cell of volume V: V (nu (W u -
 * motion) - Q (G P - f)) with wall_laplacian W and wall_curvature Q (eq. 5.1), for one shape with the parts of its
 * closed bonds. Rows with a fitted wall: V (viscous error - nu times the fit of 2.7), of fourth order -V nu times the
 * cubic of 3.23; both times the fraction of closed bonds on the shape. */
static void pdi_force_compute_row_friction(const pdi_force_query *q, int32_t r, double *rub)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    int64_t total = flow->grid->total;
    int32_t node = bonds->node[r];
    double lap = 0.0, curv = 0.0, motion[PD_DIM], miss[PD_DIM];
    double volume = bonds->stencil->volume * pd_grid_circumference(flow->grid, node);
    int bends = pdi_flow_has_fitted_wall(flow, r);
    if (bends || (flow->fourth_order.bonds && pdi_fourth_order_compute_wall_laplacian(
                                                  &flow->fourth_order, r, flow->u, flow->fourth_order.second, rub))) {
        double share = pdi_force_compute_shape_fraction(q, r);
        if (bends) pdi_reconstruct_apply_wall_laplacian(&flow->wall_fit, r, flow->u, rub);
        if (bends) pdi_reconstruct_compute_viscous_error(&flow->wall_fit, r, flow->p, miss);
        for (int d = 0; d < PD_DIM; d++)
            rub[d] = volume * share * ((bends ? miss[d] : 0.0) - flow->nu * rub[d]);
        return;
    }
    for (int d = 0; d < PD_DIM; d++)
        motion[d] = flow->wall_motion && q->shape == PD_FORCE_ALL ? flow->wall_motion[d * total + node] : 0.0;
    if (q->shape == PD_FORCE_ALL) {
        lap = bonds->wall_laplacian[r];
        curv = bonds->wall_curvature[r];
    }
    for (int k = 0; k < bonds->stencil->count && q->shape != PD_FORCE_ALL; k++) {
        pdi_bond_wall_end end;
        double u[PD_DIM];
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_wall_end(bonds, r, k, &end);
        if (!pdi_force_is_on_shape(q, end.closed_cell, end.is_box_side)) continue;
        lap += end.wall_lap;
        curv += end.wall_curv;
        if (!flow->wall) continue;
        flow->wall(flow->wall_user, end.surface_point, u);
        for (int d = 0; d < PD_DIM; d++) motion[d] += end.wall_lap * u[d];
    }
    for (int d = 0; d < PD_DIM; d++) {
        int64_t at = (int64_t)d * total + node;
        rub[d] = volume * (flow->nu * (lap * flow->u[at] - motion[d]) -
                           curv * (flow->pressure_grad[at] - pdi_flow_get_body_force(flow, d, node)));
    }
}

/* ---- bodies with a smooth surface that ends nowhere ---- */

#define PDI_FORCE_ALL_AXES ((1 << PD_DIM) - 1)

/* Axis across which the end of a closed bond lies behind a side of the box; -1: it is on no side, or behind an edge of
 * the box (outside along two axes). */
static int pdi_force_find_side_axis(const pd_grid *grid, const pdi_bond_wall_end *end)
{
    int i[PD_DIM], axis = -1;
    pd_grid_index(grid, end->closed_cell, i);
    for (int d = 0; d < PD_DIM && end->is_box_side; d++) {
        if (i[d] >= 0 && i[d] < grid->n[d]) continue;
        if (axis >= 0) return -1;
        axis = d;
    }
    return axis;
}

/* Bits of the axes of the flat sides that closed bonds of row r end on; PDI_FORCE_ALL_AXES: one of them ends on another
 * surface or behind an edge of the box, or none is closed. */
static int pdi_force_find_flat_axes(const pd_flow *flow, int32_t r)
{
    const pd_bonds *bonds = flow->bonds;
    int axes = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_bond_wall_end end;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_wall_end(bonds, r, k, &end);
        int axis = pdi_force_find_side_axis(flow->grid, &end);
        if (axis < 0) return PDI_FORCE_ALL_AXES;
        axes |= 1 << axis;
    }
    return axes ? axes : PDI_FORCE_ALL_AXES;
}

/* Moves x to the side along the axes where it is outside of the box; returns the bits of these axes. */
static int pdi_force_project_into_box(const pd_grid *grid, double *x)
{
    int axes = 0;
    for (int d = 0; d < PD_DIM; d++) {
        if (x[d] >= grid->lo[d] && x[d] <= grid->hi[d]) continue;
        x[d] = x[d] < grid->lo[d] ? grid->lo[d] : grid->hi[d];
        axes |= 1 << d;
    }
    return axes;
}

/* Bits of the axes along which the bonds of row r exchange momentum with another surface. All axes: a closed bond ends
 * on the shape outside of lo .. hi, or on another surface that is no side; an open one leads to an inlet or outlet. A
 * bit each: the normal of a side that a closed bond ends on or behind, the sides beside a row at the far end that is at
 * no smooth surface, an axis across which the far end is a mirror image. */
static int pdi_force_find_coupled_axes(const pdi_force_query *q, int32_t r)
{
    const pd_bonds *bonds = q->flow->bonds;
    const pd_grid *grid = q->flow->grid;
    int bars = 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        int32_t far = bonds->node[r] + bonds->paths.shift[k];
        int flip = 0;
        if (!pdi_bond_is_open(bonds, r, k)) {
            pdi_bond_wall_end end;
            pdi_bond_find_wall_end(bonds, r, k, &end);
            pdi_grid_fold_position(grid, end.end_point);
            bars |= pdi_force_project_into_box(grid, end.end_point);
            int owned = pdi_force_is_on_shape(q, end.closed_cell, end.is_box_side),
                axis = owned ? -1 : pdi_force_find_side_axis(grid, &end);
            if (owned ? !pd_grid_is_between(grid, q->lo, q->hi, end.end_point) : axis < 0) return PDI_FORCE_ALL_AXES;
            if (!owned) bars |= 1 << axis;
            continue;
        }
        int32_t row = bonds->row_of_node[pd_grid_find_source(grid, far, &flip)];
        if (grid->kind[far] == PD_INLET || grid->kind[far] == PD_OUTLET) return PDI_FORCE_ALL_AXES;
        if (row >= 0 && !bonds->near_smooth_surface[row]) bars |= pdi_force_find_flat_axes(q->flow, row);
        bars |= flip;
    }
    return bars;
}

/* 1: the flow has patches of rows, of the present geometry. */
static int pdi_force_has_patches(const pd_flow *flow)
{
    return flow->patch && flow->patch_version == flow->bonds->version;
}

/* Collects for each patch of rows the axes along which it exchanges momentum with other surfaces, as bits in
 * flow->patch_sums at its first row. Nothing without patches of the present geometry. */
static void pdi_force_mark_coupled_axes(const pdi_force_query *q)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    if (!pdi_force_has_patches(flow)) return;
    for (int32_t r = 0; r < bonds->rows; r++) flow->patch_sums[r] = 0.0;
    for (int32_t r = 0; r < bonds->rows; r++)
        if (flow->patch[r] >= 0)
            flow->patch_sums[flow->patch[r]] =
                (int)flow->patch_sums[flow->patch[r]] | pdi_force_find_coupled_axes(q, r);
}

/* Bits of the axes along which the body beside row r exchanges no momentum with other surfaces; 0: none, or the row is
 * in no patch. After pdi_force_mark_coupled_axes. */
static int pdi_force_get_isolated_axes(const pd_flow *flow, int32_t r)
{
    if (!pdi_force_has_patches(flow) || flow->patch[r] < 0) return 0;
    return PDI_FORCE_ALL_AXES & ~(int)flow->patch_sums[flow->patch[r]];
}

/* 1: row r is beside a smooth surface, and none of its closed bonds meets that near an edge
 * (pdi_near_wall_compute_curvature). */
static int pdi_force_is_smooth_row(const pd_flow *flow, int32_t r)
{
    const pd_bonds *bonds = flow->bonds;
    if (!bonds->near_smooth_surface[r]) return 0;
    for (int k = 0; k < bonds->stencil->count; k++) {
        pdi_bond_wall_end end;
        double mean;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_wall_end(bonds, r, k, &end);
        if (end.is_smooth && !pdi_near_wall_compute_curvature(bonds, end.closed_cell, end.surface_point, &mean))
            return 0;
    }
    return 1;
}

/* Bits of the axes along which row r gives the friction of its surface; surface pieces give it along the others. All
 * axes: beside no smooth surface, at an edge of one, on axisymmetric lattices, or when the body is isolated along all
 * axes. Else the isolated axes: rows are right only in the mean over a whole body. */
static int pdi_force_find_friction_axes(const pd_flow *flow, int32_t r)
{
    int free = flow->bonds->near_smooth_surface[r] && !flow->grid->circumference ? pdi_force_get_isolated_axes(flow, r)
                                                                                 : PDI_FORCE_ALL_AXES;
    return free == PDI_FORCE_ALL_AXES || !pdi_force_is_smooth_row(flow, r) ? PDI_FORCE_ALL_AXES : free;
}

/* Row of a fluid node or of the source of its image. For a node without one: that of its first neighbour beside a
 * smooth surface, else that of the last neighbour; -1: none. */
static int32_t pdi_force_find_row(const pd_flow *flow, int32_t node)
{
    const pd_bonds *bonds = flow->bonds;
    int32_t row = bonds->row_of_node[pd_grid_find_source(flow->grid, node, NULL)];
    if (row >= 0) return row;
    for (int k = 0; k < bonds->stencil->count && (row < 0 || !bonds->near_smooth_surface[row]); k++)
        row = bonds->row_of_node[pd_grid_find_source(flow->grid, node + bonds->paths.shift[k], NULL)];
    return row;
}

/* The axes of pdi_force_find_friction_axes for row r, cached in *q: pieces often ask for the same row again. All axes
 * for r = -1. */
static int pdi_force_get_friction_axes(pdi_force_query *q, int32_t r)
{
    if (r < 0) return PDI_FORCE_ALL_AXES;
    if (r != q->last_row) q->last_axes = pdi_force_find_friction_axes(q->flow, r);
    q->last_row = r;
    return q->last_axes;
}

/* Fluid node that is the mirror image of the far end of closed bond k on a flat side of the box; -1: none. *axis:
 * normal axis of that side, -1 behind no side or behind an edge. */
static int32_t pdi_force_find_mirror_node(const pd_flow *flow, int32_t r, int k, int *axis)
{
    const pd_grid *grid = flow->grid;
    pdi_bond_wall_end end;
    int i[PD_DIM];
    pdi_bond_find_wall_end(flow->bonds, r, k, &end);
    *axis = pdi_force_find_side_axis(grid, &end);
    if (*axis < 0) return -1;
    pd_grid_index(grid, flow->bonds->node[r] + flow->bonds->paths.shift[k], i);
    i[*axis] = i[*axis] < 0 ? -1 - i[*axis] : 2 * grid->n[*axis] - 1 - i[*axis];
    if (!pd_grid_is_inside(grid, i)) return -1;
    int32_t image = pd_grid_node(grid, i);
    return grid->kind[image] == PD_FLUID ? image : -1;
}

/* Adds the pressure force [N] at row r of an isolated body to q->sum, along its isolated axes alone, by the discrete
 * momentum balance: rho V (G P - sum (P_i + P_j) g) over open bonds, and over closed ones to a flat side by the mirror
 * node. Bond terms are antisymmetric, so the sum over the body is the flux through a box around it. */
static void pdi_force_add_row_pressure(pdi_force_query *q, int32_t r)
{
    const pd_flow *flow = q->flow;
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r];
    int axes = pdi_force_get_isolated_axes(flow, r);
    double take[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) take[d] = flow->pressure_grad[(int64_t)d * flow->grid->total + node];
    for (int k = 0; k < s->count; k++) {
        int axis = -1, open = pdi_bond_is_open(bonds, r, k);
        int32_t far = open ? node + bonds->paths.shift[k] : pdi_force_find_mirror_node(flow, r, k, &axis);
        if (far < 0) continue;
        double p = pdi_bond_get_flux_factor(bonds, node, k) * (flow->p[node] + flow->p[far]);
        for (int d = 0; d < PD_DIM; d++)
            if (d != axis) take[d] -= p * s->gradient_weight[k * PD_DIM + d];
    }
    double volume = s->volume * pd_grid_circumference(flow->grid, node);
    for (int d = 0; d < PD_DIM; d++)
        if (axes >> d & 1) pdi_compensated_sum_add(&q->sum[PD_DIM + d], flow->rho * volume * take[d]);
}

/* ---- cell by cell ---- */

#define PDI_FORCE_MAX_HALF_CELLS 4  /* half cells along the normal within which a surface piece looks for fluid */
#define PDI_FORCE_MAX_GROUPS 8      /* most groups of surface pieces in a cell */
#define PDI_FORCE_INSIDE_DEPTH 0.05 /* [cells] a point this far behind a piece is inside of its body */

/* A group of pieces of one surface in a cell that see the same fluid node; without room for more groups, all the
 * rest. */
typedef struct pdi_force_piece_group {
    int32_t node, wall_cell; /* as of the piece */
    int axes;      /* those along which friction is that of the surface */
    double area, position_sum[PD_DIM], normal_sum[PD_DIM]; /* area, and sums over it of place and normal */
} pdi_force_piece_group;

/* Sums over the surface pieces in a cell. */
typedef struct pdi_force_cell_sums {
    pdi_force_query *query;
    double total_area, shape_area; /* area of all pieces, and of those on the shape of the query */
    /* area times gradient of the pressure less body force, where rows have the friction */
    double row_friction_drive[PD_DIM];
    double row_pressure_drive[PD_DIM]; /* area times that gradient, of bodies whose rows take pressure */
    int count;
    pdi_force_piece_group group[PDI_FORCE_MAX_GROUPS];
} pdi_force_cell_sums;

/* Fluid node, or mirror image of one, in front of the surface point x, whose unit normal `into` points into the wall:
 * its cell, or the next one away from the wall, in steps of half a cell up to two cells. -1: none. */
static int32_t pdi_force_find_fluid_node(const pd_grid *grid, const double *x, const double *into)
{
    for (int half = 0; half <= PDI_FORCE_MAX_HALF_CELLS; half++) {
        int i[PD_DIM], inside = 1;
        for (int d = 0; d < PD_DIM; d++) {
            /* a face belongs to the cell in front of it */
            double at = x[d] - (0.5 * half + PDI_FORCE_SURFACE_OFFSET) * grid->h[d] * into[d];
            i[d] = (int)floor((at - grid->lo[d]) / grid->h[d]);
            inside = inside && i[d] >= -grid->ghost && i[d] < grid->n[d] + grid->ghost;
        }
        int32_t node = inside ? pd_grid_node(grid, i) : -1;
        if (node >= 0 && (grid->kind[node] == PD_FLUID || grid->kind[node] == PD_IMAGE)) return node;
    }
    return -1;
}

/* 1: a surface piece is on the shape of the query. Cell faces and queries without a shape: pdi_force_is_on_shape. On a
 * smooth surface: at a point 0.05 cells behind it the distance of the shape is, within the tolerance, at most the
 * smaller one of wall and metal, or the point is inside the shape. */
static int pdi_force_is_piece_on_shape(const pdi_force_query *q, const pdi_cut_cell_facet *piece, const double *into)
{
    const pd_grid *grid = q->flow->grid;
    double x[PD_DIM], least = HUGE_VAL;
    if (piece->closed_node >= 0 || q->shape < 0)
        return pdi_force_is_on_shape(q, piece->closed_node, piece->is_box_side);
    for (int d = 0; d < PD_DIM; d++) x[d] = piece->centroid[d] + PDI_FORCE_INSIDE_DEPTH * grid->h[d] * into[d];
    if (grid->wall >= 0) least = pdi_grid_signed_distance(grid, grid->wall, x);
    if (grid->solid >= 0) least = pd_min(least, pdi_grid_signed_distance(grid, grid->solid, x));
    return pdi_grid_signed_distance(grid, q->shape, x) <= pd_max(least, 0.0) + pd_shape_surface_tolerance(grid->h, x);
}

/* 1: the piece belongs to this group: same node, same axes of friction, same closed cell (-1: smooth surface), normals
 * within 60 degrees of each other. */
static int pdi_force_is_same_group(const pdi_force_piece_group *rubbed, const pdi_cut_cell_facet *piece, int32_t node,
                                   int axes)
{
    double both = pdi_vec_norm(rubbed->normal_sum) * pdi_vec_norm(piece->area);
    return rubbed->node == node && rubbed->axes == axes && rubbed->wall_cell == piece->closed_node &&
           pdi_vec_dot(rubbed->normal_sum, piece->area) > 0.5 * both;
}

/* Adds a piece of area `size` to the group of its fluid node for the friction along `axes` (bits). The last group takes
 * it when there is no room for another. */
static void pdi_force_add_to_group(pdi_force_cell_sums *cell, const pdi_cut_cell_facet *piece, int32_t node, int axes,
                                   double size)
{
    int k = 0;
    while (k < cell->count && !pdi_force_is_same_group(&cell->group[k], piece, node, axes)) k++;
    if (k == PDI_FORCE_MAX_GROUPS) k--;
    pdi_force_piece_group *rubbed = &cell->group[k];
    if (k == cell->count) {
        cell->count++;
        memset(rubbed, 0, sizeof *rubbed);
        rubbed->node = node;
        rubbed->axes = axes;
        rubbed->wall_cell = piece->closed_node;
    }
    rubbed->area += size;
    for (int d = 0; d < PD_DIM; d++) {
        rubbed->position_sum[d] += size * piece->centroid[d];
        rubbed->normal_sum[d] += piece->area[d];
    }
}

/* Adds the friction [N] of a group along its axes to q->sum: rho nu times area times wall shear by least squares; where
 * that is not known (an edge) by a parabola from the node to the wall, at least half the smallest spacing away, without
 * its normal part. Nothing where it is not known and the normals cancel. */
static void pdi_force_add_group_friction(pdi_force_query *q, const pdi_force_piece_group *rubbed)
{
    const pd_flow *flow = q->flow;
    const pd_grid *grid = flow->grid;
    double x[PD_DIM], at[PD_DIM], slope[PD_DIM], into[PD_DIM], wall[PD_DIM], d = 0.0, along = 0.0;
    double length = pdi_vec_norm(rubbed->normal_sum);
    for (int a = 0; a < PD_DIM; a++) x[a] = rubbed->position_sum[a] / rubbed->area;
    if (!pdi_near_wall_compute_shear(flow, rubbed->node, x, slope)) {
        if (!(length > 0.0)) return;
        pd_grid_position(grid, rubbed->node, at);
        for (int a = 0; a < PD_DIM; a++) {
            into[a] = rubbed->normal_sum[a] / length;
            d += (x[a] - at[a]) * into[a];
        }
        memset(wall, 0, sizeof wall);
        if (flow->wall) flow->wall(flow->wall_user, x, wall);
        d = pd_max(d, 0.5 * pdi_vec_min(grid->h));
        for (int a = 0; a < PD_DIM; a++) {
            int64_t of = (int64_t)a * grid->total + rubbed->node;
            int32_t image = pd_grid_find_source(grid, rubbed->node, NULL);
            double bend = (flow->pressure_grad[of] - pdi_flow_get_body_force(flow, a, image)) / flow->nu;
            slope[a] = (flow->u[of] - wall[a]) / d - 0.5 * d * bend;
            along += slope[a] * into[a];
        }
        for (int a = 0; a < PD_DIM; a++) slope[a] -= along * into[a];
    }
    for (int a = 0; a < PD_DIM; a++)
        if (rubbed->axes >> a & 1) pdi_compensated_sum_add(&q->sum[a], flow->rho * flow->nu * slope[a] * rubbed->area);
}

/* Callback for each surface piece of a cell: adds its area and drives to the sums of the cell. A piece on the shape of
 * the query also adds its pressure force, extrapolated from the node in front, along the axes where rows do not give
 * it, and its friction to a group along the axes where rows do not. Nothing for a piece of no area or without fluid in
 * front. */
static void pdi_force_add_piece(void *user, const pdi_cut_cell_facet *piece)
{
    pdi_force_cell_sums *cell = (pdi_force_cell_sums *)user;
    pdi_force_query *q = cell->query;
    const pd_flow *flow = q->flow;
    const pd_grid *grid = flow->grid;
    double size = pdi_vec_norm(piece->area), into[PD_DIM], x[PD_DIM];
    if (!(size > 0.0)) return;
    for (int d = 0; d < PD_DIM; d++) into[d] = piece->area[d] / size;
    int32_t node = pdi_force_find_fluid_node(grid, piece->centroid, into);
    if (node < 0) return;
    int32_t row = pdi_force_find_row(flow, node), image = pd_grid_find_source(grid, node, NULL);
    int asked = pdi_force_is_piece_on_shape(q, piece, into), rows = pdi_force_get_friction_axes(q, row);
    int free = row < 0 || !flow->bonds->near_smooth_surface[row] ? 0 : pdi_force_get_isolated_axes(flow, row);
    double p = flow->p[node];
    pd_grid_position(grid, node, x);
    cell->total_area += size;
    cell->shape_area += asked ? size : 0.0;
    if (asked && rows != PDI_FORCE_ALL_AXES)
        pdi_force_add_to_group(cell, piece, node, PDI_FORCE_ALL_AXES & ~rows, size);
    for (int d = 0; d < PD_DIM; d++) {
        double slope = flow->pressure_grad[(int64_t)d * grid->total + node];
        p += slope * (piece->centroid[d] - x[d]);
        if (rows >> d & 1) cell->row_friction_drive[d] += size * (slope - pdi_flow_get_body_force(flow, d, image));
        if (free >> d & 1) cell->row_pressure_drive[d] += size * slope;
    }
    for (int d = 0; d < PD_DIM && asked; d++)
        if (!(free >> d & 1)) pdi_compensated_sum_add(&q->sum[PD_DIM + d], flow->rho * p * piece->area[d]);
}

/* Adds pressure and friction of the surface in the cell of `node`, between lo and hi. Rows count the friction and
 * forces of complete cells: the open volume less that (0 for a closed node) is corrected by the momentum balance, on
 * the part of the area that is on the shape. Nothing when no piece is on the shape. */
static void pdi_force_integrate_cell(pdi_force_query *q, int32_t node)
{
    const pd_flow *flow = q->flow;
    const pd_grid *grid = flow->grid;
    pdi_force_cell_sums cell;
    memset(&cell, 0, sizeof cell);
    cell.query = q;
    double open = pdi_cut_cell_integrate(grid, node, q->lo, q->hi, pdi_force_add_piece, &cell);
    if (!(cell.shape_area > 0.0)) return;
    double whole = flow->bonds->stencil->volume * pd_grid_circumference(grid, node);
    double excess =
        open - (grid->kind[node] == PD_FLUID ? whole * pdi_cut_cell_overlap_fraction(grid, node, q->lo, q->hi) : 0.0);
    for (int k = 0; k < cell.count; k++) pdi_force_add_group_friction(q, &cell.group[k]);
    excess *= flow->rho * (cell.shape_area / cell.total_area) / cell.total_area;
    for (int d = 0; d < PD_DIM; d++) {
        pdi_compensated_sum_add(&q->sum[d], -excess * cell.row_friction_drive[d]);
        pdi_compensated_sum_add(&q->sum[PD_DIM + d], excess * cell.row_pressure_drive[d]);
    }
}

/* Adds pressure and friction of all cells of the box that may have a surface: fluid nodes with a cut family, and cells
 * no farther than half their diagonal from a smooth surface. */
static void pdi_force_integrate_cells(pdi_force_query *q)
{
    const pd_grid *grid = q->flow->grid;
    double half = 0.5 * pdi_vec_norm(grid->h), clear = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        clear -= grid->h[0];
        pd_grid_index(grid, node, i);
        if (i[0] <= 0) clear = 0.0;
        if (!pd_grid_is_inside(grid, i)) continue;
        int beside = grid->kind[node] == PD_FLUID && q->flow->bonds->row_of_node[node] >= 0;
        if (!(clear > half)) clear = pdi_cut_cell_surface_distance(grid, node);
        if (beside || clear <= half) pdi_force_integrate_cell(q, node);
    }
}

void pd_force_surface(pd_ctx *ctx, pd_flow *flow, int shape, const double *lo, const double *hi, double *force,
                      double *friction, double *pressure)
{
    pdi_force_query q;
    memset(&q, 0, sizeof q);
    q.flow = flow;
    q.lo = lo;
    q.hi = hi;
    q.shape = shape;
    q.last_row = -1;
    pdi_flow_update_derived_fields(ctx, flow);
    pdi_force_mark_coupled_axes(&q);
    for (int32_t r = 0; r < flow->bonds->rows; r++) {
        double rub[PD_DIM], share = pdi_cut_cell_overlap_fraction(flow->grid, flow->bonds->node[r], lo, hi);
        if (flow->bonds->near_smooth_surface[r] && pdi_force_get_isolated_axes(flow, r))
            pdi_force_add_row_pressure(&q, r);
        int axes = share > 0.0 ? pdi_force_get_friction_axes(&q, r) : 0;
        if (!axes) continue;
        pdi_force_compute_row_friction(&q, r, rub);
        for (int d = 0; d < PD_DIM; d++)
            if (axes >> d & 1) pdi_compensated_sum_add(&q.sum[d], flow->rho * share * rub[d]);
    }
    pdi_force_integrate_cells(&q);
    for (int d = 0; d < PD_DIM; d++) {
        double f = pdi_compensated_sum_total(&q.sum[d]), p = pdi_compensated_sum_total(&q.sum[PD_DIM + d]);
        force[d] = f + p;
        if (friction) friction[d] = f;
        if (pressure) pressure[d] = p;
    }
    pdi_force_remove_radial(flow->grid, force);
    if (friction) pdi_force_remove_radial(flow->grid, friction);
    if (pressure) pdi_force_remove_radial(flow->grid, pressure);
}

/* ---- around the body ---- */

/* Field f interpolated at the face between node - stride and node by a cubic. */
static double pdi_force_interpolate_face(const double *f, int32_t node, int32_t stride)
{
    return (9.0 * (f[node] + f[node - stride]) - (f[node + stride] + f[node - 2 * stride])) / 16.0;
}

/* Derivative of field f across the face between node - stride and node, times the spacing, by a cubic. */
static double pdi_force_compute_face_derivative(const double *f, int32_t node, int32_t stride)
{
    return (27.0 * (f[node] - f[node - stride]) - (f[node + stride] - f[node - 2 * stride])) / 24.0;
}

/* pass [PD_DIM] = momentum flux over rho through the face before `node` along +axis: u u_n + P n - nu du/dn. */
static void pdi_force_compute_momentum_flux(const pd_flow *flow, int32_t node, int axis, double *pass)
{
    const pd_grid *grid = flow->grid;
    int32_t stride = grid->stride[axis];
    double speed = pdi_force_interpolate_face(flow->u + (int64_t)axis * grid->total, node, stride);
    for (int d = 0; d < PD_DIM; d++) {
        const double *u = flow->u + (int64_t)d * grid->total;
        pass[d] = speed * pdi_force_interpolate_face(u, node, stride) -
                  flow->nu * pdi_force_compute_face_derivative(u, node, stride) / grid->h[axis];
    }
    pass[axis] += pdi_force_interpolate_face(flow->p, node, stride);
}

/* 1: the low side of axis d is the axis of symmetry, which nothing passes. */
static int pdi_force_is_symmetry_axis(const pd_grid *grid, int d)
{
    return grid->circumference && d == PD_DIM - 1 && grid->side[2 * d] == PD_SIDE_MIRROR;
}

/* first, last [PD_DIM] = first and last cell inside of the box lo .. hi, rounded to cell faces; at the axis of symmetry
 * from 0, whatever lo is. PD_ERR_GEOMETRY: along an axis no cell is left, or it begins before cell 2 or ends after cell
 * n - 3. */
static pd_status pdi_force_find_box_cells(pd_ctx *ctx, const pd_grid *grid, const double *lo, const double *hi,
                                          int *first, int *last)
{
    for (int d = 0; d < PD_DIM; d++) {
        double low = floor((lo[d] - grid->lo[d]) / grid->h[d] + 0.5);
        double high = floor((hi[d] - grid->lo[d]) / grid->h[d] + 0.5);
        int axis = pdi_force_is_symmetry_axis(grid, d);
        if (axis) low = 0.0;
        if ((!axis && !(low >= 2.0)) || !(high <= grid->n[d] - 2.0) || !(high > low))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "force",
                           "cells %g .. %g of axis %d: a box of fluid two cells inside of %d is expected", low, high,
                           d, grid->n[d]);
        first[d] = (int)low;
        last[d] = (int)high - 1;
    }
    return PD_OK;
}

/* Adds to sum [PD_DIM] [N] rho times the momentum flux into the box through both faces across `axis`: the force on what
 * is inside. The axis of symmetry has no face. PD_ERR_GEOMETRY: one of the two nodes on either side of a face is not
 * fluid; sum has a part of the flux then. */
static pd_status pdi_force_integrate_box_sides(pd_ctx *ctx, const pd_flow *flow, const int *first, const int *last,
                                               int axis, pdi_compensated_sum *sum)
{
    const pd_grid *grid = flow->grid;
    double face = flow->bonds->stencil->volume / grid->h[axis];
    int32_t stride = grid->stride[axis];
    for (int side = pdi_force_is_symmetry_axis(grid, axis) ? 1 : 0; side < 2; side++) {
        int i[PD_DIM], more = 1;
        memcpy(i, first, sizeof i);
        i[axis] = side ? last[axis] + 1 : first[axis];
        while (more) {
            double pass[PD_DIM];
            int32_t node = pd_grid_node(grid, i);
            for (int k = -2; k < 2; k++)
                if (grid->kind[node + k * stride] != PD_FLUID)
                    return pd_fail(ctx, PD_ERR_GEOMETRY, "force",
                                   "a side of the box, axis %d, comes within two cells of a closed node", axis);
            double area = face * pdi_grid_circumference_at(grid, node, axis == PD_DIM - 1 ? -0.5 * grid->h[axis] : 0.0);
            pdi_force_compute_momentum_flux(flow, node, axis, pass);
            for (int d = 0; d < PD_DIM; d++)
                pdi_compensated_sum_add(&sum[d], (side ? -1.0 : 1.0) * flow->rho * area * pass[d]);
            more = 0;
            for (int d = 0; d < PD_DIM && !more; d++) {
                if (d == axis) continue;
                more = i[d] < last[d];
                i[d] = more ? i[d] + 1 : first[d];
            }
        }
    }
    return PD_OK;
}

/* force [PD_DIM] [m/s2] = body force at `node`: the uniform one plus that of the callback. A closed node may have fluid
 * in its cell, and has no stored value: the callback is called. */
static void pdi_force_get_body_force(const pd_flow *flow, int32_t node, double *force)
{
    double x[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) force[d] = pdi_flow_get_body_force(flow, d, node);
    if (!flow->body_force || flow->grid->kind[node] == PD_FLUID) return;
    pd_grid_position(flow->grid, node, x);
    flow->body_force_fn(flow->body_force_user, x, force);
    for (int d = 0; d < PD_DIM; d++) force[d] += flow->force[d];
}

pd_status pd_force_momentum_balance(pd_ctx *ctx, pd_flow *flow, const double *lo, const double *hi, double *force)
{
    const pd_grid *grid = flow->grid;
    pdi_compensated_sum sum[PD_DIM];
    int first[PD_DIM], last[PD_DIM];
    memset(sum, 0, sizeof sum);
    memset(first, 0, sizeof first);
    memset(last, 0, sizeof last);
    for (int d = 0; d < PD_DIM; d++) force[d] = 0.0;
    PD_TRY(pdi_force_find_box_cells(ctx, grid, lo, hi, first, last));
    pdi_flow_update_derived_fields(ctx, flow);
    for (int axis = 0; axis < PD_DIM; axis++) PD_TRY(pdi_force_integrate_box_sides(ctx, flow, first, last, axis, sum));
    for (int32_t node = 0; node < grid->total; node++) {
        double body[PD_DIM];
        int i[PD_DIM], within = 1;
        pd_grid_index(grid, node, i);
        for (int d = 0; d < PD_DIM; d++) within = within && i[d] >= first[d] && i[d] <= last[d];
        double open = within ? pdi_cut_cell_integrate(grid, node, grid->lo, grid->hi, NULL, NULL) : 0.0;
        if (!(open > 0.0)) continue;
        pdi_force_get_body_force(flow, node, body);
        for (int d = 0; d < PD_DIM; d++) pdi_compensated_sum_add(&sum[d], flow->rho * open * body[d]);
    }
    for (int d = 0; d < PD_DIM; d++) force[d] = pdi_compensated_sum_total(&sum[d]);
    pdi_force_remove_radial(grid, force);
    return PD_OK;
}

#undef PDI_FORCE_SURFACE_OFFSET
