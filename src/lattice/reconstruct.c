/* reconstruct: see reconstruct.h */
#include "lattice/reconstruct.h"
#include "lattice/surface.h"
#include "core/array_registry.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Terms of a quadratic about the node: linear ones, then products (the constant is the value of the node). */
#define PDI_RECONSTRUCT_TERMS (PD_DIM + PD_DIM * (PD_DIM + 1) / 2)
/* [-] Data whose moments, scaled by those of a full family, have a pivot below this determine no quadratic (theory,
 * 2.6). */
#define PDI_RECONSTRUCT_MIN_PIVOT 1e-3
/* [-] Step of central differences over the spacing. */
#define PDI_RECONSTRUCT_STEP 0.05

/* Matrix of the normal equations of a fit. */
typedef struct pdi_reconstruct_normal_matrix {
    double sum[PDI_RECONSTRUCT_TERMS * PDI_RECONSTRUCT_TERMS]; /* later scaled by `scale` on both sides and factored */
    double scale[PDI_RECONSTRUCT_TERMS];                       /* 1/sqrt of the diagonal for a full family */
} pdi_reconstruct_normal_matrix;

/* term [terms] = the linear terms [cells] and the products xx, yx, yy, .. [cells2] of the point at fraction t of bond
 * k, relative to its node. */
static void pdi_reconstruct_compute_terms(const pd_stencil *s, int k, double t, double *term)
{
    const int *n = s->offset + k * PD_DIM;
    int at = PD_DIM;
    for (int a = 0; a < PD_DIM; a++) {
        term[a] = t * n[a];
        for (int b = 0; b <= a; b++) term[at++] = t * t * (double)(n[a] * n[b]);
    }
}

/* term [terms], as of pdi_reconstruct_compute_terms, at the surface point nearest to the end of a bond of row r that
 * only grazes the surface, by one step along the normal. Returns 1; 0: an edge is nearby, or the point reached is 0.05
 * of the smallest spacing or more off the surface. */
static int pdi_reconstruct_compute_surface_terms(const pd_bonds *bonds, int32_t r, const pdi_bond_wall_end *end,
                                                 double *term)
{
    const double *h = bonds->grid->h;
    double x[PD_DIM], foot[PD_DIM], normal[PD_DIM], distance;
    int at = PD_DIM;
    if (!pdi_surface_compute_normal(bonds, end->closed_cell, end->surface_point, PDI_RECONSTRUCT_STEP, &distance,
                                    normal))
        return 0;
    for (int a = 0; a < PD_DIM; a++) foot[a] = end->surface_point[a] - distance * normal[a];
    if (!(fabs(pdi_bond_surface_distance(bonds, end->closed_cell, foot)) < PDI_RECONSTRUCT_STEP * pdi_vec_min(h)))
        return 0;
    pd_grid_position(bonds->grid, bonds->node[r], x);
    for (int a = 0; a < PD_DIM; a++) {
        term[a] = (foot[a] - x[a]) / h[a];
        for (int b = 0; b <= a; b++) term[at++] = term[a] * term[b];
    }
    return 1;
}

/* Adds a datum with its terms and weight to the matrix of the normal equations. */
static void pdi_reconstruct_add_datum(const double *term, double weight, pdi_reconstruct_normal_matrix *m)
{
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++)
        for (int b = 0; b < PDI_RECONSTRUCT_TERMS; b++)
            m->sum[a * PDI_RECONSTRUCT_TERMS + b] += weight * term[a] * term[b];
}

/* Scales and factors the matrix m->sum in place (Cholesky). Returns 1; 0: a scaled pivot is not above
 * PDI_RECONSTRUCT_MIN_PIVOT, whatever the order of the terms: the data do not determine a quadratic. */
static int pdi_reconstruct_factor_normal_matrix(pdi_reconstruct_normal_matrix *m)
{
    double least[PDI_RECONSTRUCT_TERMS];
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) {
        least[a] = PDI_RECONSTRUCT_MIN_PIVOT;
        for (int b = 0; b < PDI_RECONSTRUCT_TERMS; b++)
            m->sum[a * PDI_RECONSTRUCT_TERMS + b] *= m->scale[a] * m->scale[b];
    }
    return pdi_vec_cholesky_any_order(PDI_RECONSTRUCT_TERMS, PDI_RECONSTRUCT_TERMS, least, m->sum);
}

/* x = M^-1 y with factored normal equations M. */
static void pdi_reconstruct_solve_normal_matrix(const pdi_reconstruct_normal_matrix *m, const double *y, double *x)
{
    for (int r = 0; r < PDI_RECONSTRUCT_TERMS; r++) x[r] = y[r] * m->scale[r];
    pdi_vec_cholesky_solve(PDI_RECONSTRUCT_TERMS, PDI_RECONSTRUCT_TERMS, m->sum, x);
    for (int r = 0; r < PDI_RECONSTRUCT_TERMS; r++) x[r] *= m->scale[r];
}

/* Sets the matrix of the normal equations to zero, and its scales to those of a full family. */
static void pdi_reconstruct_init_normal_matrix(const pd_stencil *s, pdi_reconstruct_normal_matrix *m)
{
    double term[PDI_RECONSTRUCT_TERMS];
    memset(m, 0, sizeof *m);
    for (int k = 0; k < s->count; k++) {
        pdi_reconstruct_compute_terms(s, k, 1.0, term);
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) m->scale[a] += s->base_weight[k] * term[a] * term[a];
    }
    for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) m->scale[a] = 1.0 / sqrt(m->scale[a]);
}

/* 1: bond k of row r is open and its far end has a scalar value (inlet ghosts have none). */
static int pdi_reconstruct_is_scalar_bond(const pd_bonds *bonds, int32_t r, int k)
{
    return pdi_bond_is_open(bonds, r, k) && bonds->grid->kind[bonds->node[r] + bonds->paths.shift[k]] != PD_INLET;
}

/* 1: the node has a scalar value: fluid, outlet or image. 0: inlet, or closed. */
static int pdi_reconstruct_is_scalar_node(const pd_grid *grid, int32_t node)
{
    return pdi_grid_is_open(grid->kind[node]) && grid->kind[node] != PD_INLET;
}

/* step [2]: differences of node ids to the two other nodes of a parabola along axis d: both neighbours where they have
 * scalar values, else the next two on one side. Returns 1; 0: none (one-sided, the first of them must be fluid and the
 * second have a scalar value); step has no meaning then. */
static int pdi_reconstruct_find_parabola(const pd_grid *grid, int32_t node, int d, int32_t step[2])
{
    int32_t stride = grid->stride[d];
    int below = pdi_reconstruct_is_scalar_node(grid, node - stride),
        above = pdi_reconstruct_is_scalar_node(grid, node + stride);
    step[0] = above ? stride : -stride;
    step[1] = above && below ? -stride : 2 * step[0];
    if (above && below) return 1;
    return grid->kind[node + step[0]] == PD_FLUID && pdi_reconstruct_is_scalar_node(grid, node + step[1]);
}

/* Sets gradient_map of row r of a wide family: the gradient of its scalar fit as a linear map of the data (eq. 2.11).
 * Returns 1; 0: the bonds determine no fit, or there is no parabola along an axis: in such a gap the quadratic would
 * take the gradient from nodes in front of it, by mixed derivatives. */
static int pdi_reconstruct_compute_scalar_fit(pd_quadratic_reconstruction *rec, int32_t r)
{
    const pd_bonds *bonds = rec->bonds;
    const pd_stencil *s = bonds->stencil;
    double *slope = rec->gradient_map + (int64_t)rec->index[r] * PD_DIM * PDI_RECONSTRUCT_TERMS;
    double term[PDI_RECONSTRUCT_TERMS];
    int32_t step[2];
    pdi_reconstruct_normal_matrix m;
    for (int d = 0; d < PD_DIM; d++)
        if (!pdi_reconstruct_find_parabola(bonds->grid, bonds->node[r], d, step)) return 0;
    pdi_reconstruct_init_normal_matrix(s, &m);
    for (int k = 0; k < s->count; k++) {
        if (!pdi_reconstruct_is_scalar_bond(bonds, r, k)) continue;
        pdi_reconstruct_compute_terms(s, k, 1.0, term);
        pdi_reconstruct_add_datum(term, s->base_weight[k], &m);
    }
    if (!pdi_reconstruct_factor_normal_matrix(&m)) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        memset(term, 0, sizeof term);
        term[d] = 1.0 / bonds->grid->h[d];
        pdi_reconstruct_solve_normal_matrix(&m, term, slope + d * PDI_RECONSTRUCT_TERMS);
    }
    return 1;
}

/* Computes the velocity fit of row r (eq. 2.7): the contribution of cut bonds to the Laplacian of a velocity that
 * vanishes on the surface, as coefficients[terms] of the sums over open bonds and *drag [1/m2] of the velocity of the
 * node. Data: open far ends, inlets included, and points on the surface with weights over t^2, but not those of t > 1.
 * extra_weight may be NULL. Returns 1; 0: the bonds determine no fit, nothing is set. */
static int pdi_reconstruct_compute_velocity_fit(const pd_bonds *bonds, int32_t r, const double *extra_weight,
                                                double factor, double *coefficients, double *drag)
{
    const pd_stencil *s = bonds->stencil;
    double term[PDI_RECONSTRUCT_TERMS], far[PDI_RECONSTRUCT_TERMS], wall[PDI_RECONSTRUCT_TERMS];
    pdi_reconstruct_normal_matrix m;
    memset(far, 0, sizeof far);
    memset(wall, 0, sizeof wall);
    pdi_reconstruct_init_normal_matrix(s, &m);
    for (int k = 0; k < s->count; k++) {
        double weight = s->base_weight[k];
        pdi_reconstruct_compute_terms(s, k, 1.0, term);
        if (!pdi_bond_is_open(bonds, r, k)) {
            pdi_bond_wall_end end;
            double a = pdi_bond_get_laplacian_weights(bonds, bonds->node[r])[k] +
                       (extra_weight ? factor * extra_weight[k] : 0.0);
            pdi_bond_find_wall_end(bonds, r, k, &end);
            for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) far[c] += a * term[c];
            if (end.fraction > 1.0 + 1e-9) continue; /* the line grazes the surface, and meets it far behind */
            weight /= end.fraction * end.fraction;
            if (!end.is_grazing || !pdi_reconstruct_compute_surface_terms(bonds, r, &end, term))
                pdi_reconstruct_compute_terms(s, k, end.fraction, term);
            for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) wall[c] += weight * term[c];
        }
        pdi_reconstruct_add_datum(term, weight, &m);
    }
    if (!pdi_reconstruct_factor_normal_matrix(&m)) return 0;
    pdi_reconstruct_solve_normal_matrix(&m, far, coefficients);
    *drag = 0.0;
    for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) *drag += coefficients[c] * wall[c];
    return 1;
}

/* ---- the cubic part of a velocity near a wall (eq. 2.8) ---- */

/* [-] Sum of the principal curvatures times h from which a surface counts as an edge. */
#define PDI_RECONSTRUCT_EDGE_CURVATURE 0.5

/* The surface point nearest to a node. */
typedef struct pdi_reconstruct_surface_point {
    const pd_bonds *bonds;
    int32_t closed_node;                  /* closed node behind it */
    double point[PD_DIM], normal[PD_DIM]; /* [m], [-] point, and normal towards the fluid */
} pdi_reconstruct_surface_point;

/* Sets *foot to the surface point nearest to the node of row r, on the shape of its shortest cut bond. Returns 1; 0: no
 * bond ends on a smooth shape that is curved or inclined (sides of the box do not count), an edge is nearby, the node
 * lies inside the shape, or the |sum of the principal curvatures| times h is PDI_RECONSTRUCT_EDGE_CURVATURE or more;
 * *foot is partly set then. */
static int pdi_reconstruct_find_surface_point(const pd_bonds *bonds, int32_t r, pdi_reconstruct_surface_point *foot)
{
    const pd_stencil *s = bonds->stencil;
    double x[PD_DIM], distance, nearest = HUGE_VAL, curvature = 0.0;
    foot->bonds = bonds;
    foot->closed_node = -1;
    for (int k = 0; k < s->count; k++) {
        pdi_bond_wall_end end;
        if (pdi_bond_is_open(bonds, r, k)) continue;
        pdi_bond_find_wall_end(bonds, r, k, &end);
        double length = end.fraction * pdi_vec_norm(s->xi + k * PD_DIM);
        if (!end.is_smooth || end.is_box_side || !(length < nearest)) continue;
        nearest = length;
        foot->closed_node = end.closed_cell;
    }
    if (foot->closed_node < 0) return 0;
    pd_grid_position(bonds->grid, bonds->node[r], x);
    if (!pdi_surface_compute_normal(bonds, foot->closed_node, x, PDI_RECONSTRUCT_STEP, &distance, foot->normal))
        return 0;
    if (!(distance >= 0.0)) return 0;
    for (int d = 0; d < PD_DIM; d++) x[d] = foot->point[d] = x[d] - distance * foot->normal[d];
    for (int d = 0; d < PD_DIM; d++) {
        double at = x[d], eps = PDI_RECONSTRUCT_STEP * bonds->grid->h[d];
        x[d] = at + eps;
        double up = pdi_bond_surface_distance(bonds, foot->closed_node, x);
        x[d] = at - eps;
        curvature += (up + pdi_bond_surface_distance(bonds, foot->closed_node, x)) / (eps * eps) * bonds->grid->h[d];
        x[d] = at;
    }
    return fabs(curvature) < PDI_RECONSTRUCT_EDGE_CURVATURE;
}

/* u [PD_DIM] = velocity times viscosity at x [m] of Stokes flow that vanishes on the surface and whose pressure has the
 * second derivatives `hessian` (xx, yx, yy, ..) and no other part (eq. 2.8): [m3] times the unit of `hessian`. */
static void pdi_reconstruct_stokes_velocity(const pdi_reconstruct_surface_point *foot, const double *hessian,
                                            const double *x, double *u)
{
    double d = pdi_bond_surface_distance(foot->bonds, foot->closed_node, x), s[PD_DIM], hn[PD_DIM], hs[PD_DIM],
           square = 0.0;
    const double *n = foot->normal;
    for (int a = 0; a < PD_DIM; a++) s[a] = x[a] - foot->point[a];
    double along = pdi_vec_dot(s, n);
    for (int a = 0; a < PD_DIM; a++) {
        s[a] -= along * n[a];
        square += s[a] * s[a];
        hn[a] = hs[a] = 0.0;
    }
    for (int a = 0, at = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++, at++) {
            hn[a] += hessian[at] * n[b];
            hs[a] += hessian[at] * s[b];
            if (a == b) continue;
            hn[b] += hessian[at] * n[a];
            hs[b] += hessian[at] * s[a];
        }
    double normal_normal = pdi_vec_dot(hn, n), tangent_normal = pdi_vec_dot(hs, n);
    for (int a = 0; a < PD_DIM; a++) {
        double t = hn[a] - normal_normal * n[a];
        u[a] = n[a] * (normal_normal * d * d * d / 6.0 + tangent_normal * d * d / 2.0) +
               (hs[a] - tangent_normal * n[a]) * d * d / 2.0 +
               t * (PD_DIM * d * d * d / 6.0 - square * d / 2.0);
    }
}

/* error [PD_DIM] = discrete minus exact Laplacian at row r of the velocity of pdi_reconstruct_stokes_velocity: [m]
 * times the unit of `hessian`. */
static void pdi_reconstruct_laplacian_error(const pd_quadratic_reconstruction *rec,
                                            const pdi_reconstruct_surface_point *foot, int32_t r, const double *hessian,
                                            const double *extra_weight, double factor, double *error)
{
    const pd_bonds *bonds = foot->bonds;
    const pd_stencil *s = bonds->stencil;
    int64_t q = rec->index[r];
    double x[PD_DIM], y[PD_DIM], here[PD_DIM], u[2][PD_DIM];
    pd_grid_position(bonds->grid, bonds->node[r], x);
    pdi_reconstruct_stokes_velocity(foot, hessian, x, here);
    for (int a = 0; a < PD_DIM; a++) error[a] = -rec->wall_friction[q] * here[a];
    for (int k = 0; k < s->count; k++) {
        double weight =
            pdi_bond_get_laplacian_weights(bonds, bonds->node[r])[k] + (extra_weight ? factor * extra_weight[k] : 0.0);
        if (!pdi_bond_is_open(bonds, r, k)) continue;
        for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++)
            weight += rec->wall_coefficients[q * PDI_RECONSTRUCT_TERMS + c] *
                      rec->weighted_terms[k * PDI_RECONSTRUCT_TERMS + c];
        for (int d = 0; d < PD_DIM; d++) y[d] = x[d] + s->xi[k * PD_DIM + d];
        pdi_reconstruct_stokes_velocity(foot, hessian, y, u[0]);
        for (int a = 0; a < PD_DIM; a++) error[a] += weight * (u[0][a] - here[a]);
    }
    for (int d = 0; d < PD_DIM; d++) {
        double eps = PDI_RECONSTRUCT_STEP * bonds->grid->h[d];
        for (int side = 0; side < 2; side++) {
            memcpy(y, x, sizeof y);
            y[d] += side ? eps : -eps;
            pdi_reconstruct_stokes_velocity(foot, hessian, y, u[side]);
        }
        for (int a = 0; a < PD_DIM; a++) error[a] -= ((u[1][a] - here[a]) - (here[a] - u[0][a])) / (eps * eps);
    }
}

/* Sets viscous_error of row r for each second derivative of the pressure; zero without a velocity fit or smooth
 * surface. Does nothing for wide families, which have no such array. */
static void pdi_reconstruct_compute_cubic_errors(pd_quadratic_reconstruction *rec, int32_t r,
                                                 const double *extra_weight, double factor)
{
    int64_t q = rec->index[r];
    pdi_reconstruct_surface_point foot;
    if (rec->wide_capacity) return;
    double *error = rec->viscous_error + q * PD_DIM * PDI_RECONSTRUCT_HESSIAN_SIZE;
    memset(error, 0, PD_DIM * PDI_RECONSTRUCT_HESSIAN_SIZE * sizeof *error);
    if (!rec->has_velocity_fit[q] || !pdi_reconstruct_find_surface_point(rec->bonds, r, &foot)) return;
    for (int c = 0; c < PDI_RECONSTRUCT_HESSIAN_SIZE; c++) {
        double hessian[PDI_RECONSTRUCT_HESSIAN_SIZE], part[PD_DIM];
        memset(hessian, 0, sizeof hessian);
        hessian[c] = 1.0;
        pdi_reconstruct_laplacian_error(rec, &foot, r, hessian, extra_weight, factor, part);
        for (int a = 0; a < PD_DIM; a++) error[a * PDI_RECONSTRUCT_HESSIAN_SIZE + c] = part[a];
    }
}

/* slope [PD_DIM] = gradient of the scalar fit of f at row r of a wide family. */
static void pdi_reconstruct_apply_scalar_fit(const pd_quadratic_reconstruction *rec, int32_t r, const double *f,
                                             double *slope)
{
    const pd_bonds *bonds = rec->bonds;
    int32_t node = bonds->node[r];
    const double *coefficients = rec->gradient_map + (int64_t)rec->index[r] * PD_DIM * PDI_RECONSTRUCT_TERMS;
    double sum[PDI_RECONSTRUCT_TERMS];
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < bonds->stencil->count; k++) {
        if (!pdi_reconstruct_is_scalar_bond(bonds, r, k)) continue;
        const double *term = rec->weighted_terms + k * PDI_RECONSTRUCT_TERMS;
        double difference = f[node + bonds->paths.shift[k]] - f[node];
        for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++) sum[c] += difference * term[c];
    }
    for (int d = 0; d < PD_DIM; d++) {
        slope[d] = 0.0;
        for (int c = 0; c < PDI_RECONSTRUCT_TERMS; c++)
            slope[d] += coefficients[d * PDI_RECONSTRUCT_TERMS + c] * sum[c];
    }
}

/* hessian: second derivatives [unit of f / m2] of f [total] at a node, packed as a triangle (xx, yx, yy, zx, zy, zz), 0
 * where neighbours are missing: of parabolas along the axes (of cubics through four nodes where they are one-sided and
 * there are four), and mixed ones as the mean over the squares of nodes next to it. */
static void pdi_reconstruct_compute_hessian(const pd_grid *grid, int32_t node, const double *f, double *hessian)
{
    for (int a = 0, at = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++, at++) {
            int32_t step[2];
            int count = 0;
            hessian[at] = 0.0;
            if (a == b && pdi_reconstruct_find_parabola(grid, node, a, step)) {
                int32_t third = step[0] + step[1];
                double first = f[node + step[0]] - f[node], second = f[node + step[1]] - f[node];
                hessian[at] = third ? second - 2.0 * first : first + second;
                if (third && grid->kind[node + step[1]] == PD_FLUID &&
                    pdi_reconstruct_is_scalar_node(grid, node + third))
                    hessian[at] = 4.0 * second - 5.0 * first - (f[node + third] - f[node]);
                hessian[at] /= grid->h[a] * grid->h[a];
            }
            for (int which = 0; which < 4 && a != b; which++) {
                int32_t i = node + (which & 1 ? grid->stride[a] : -grid->stride[a]);
                int32_t j = node + (which & 2 ? grid->stride[b] : -grid->stride[b]), k = i + j - node;
                if (!pdi_reconstruct_is_scalar_node(grid, i) || !pdi_reconstruct_is_scalar_node(grid, j) ||
                    !pdi_reconstruct_is_scalar_node(grid, k))
                    continue;
                double mixed = f[k] - f[i] - f[j] + f[node];
                hessian[at] += which == 0 || which == 3 ? mixed : -mixed;
                count++;
            }
            if (count) hessian[at] /= count * grid->h[a] * grid->h[b];
        }
}

PDI_FN void pdi_reconstruct_compute_viscous_error(const pd_quadratic_reconstruction *rec, int32_t r, const double *f,
                                                  double *error)
{
    double hessian[PDI_RECONSTRUCT_HESSIAN_SIZE];
    for (int a = 0; a < PD_DIM; a++) error[a] = 0.0;
    if (rec->wide_capacity) return;
    const double *part = rec->viscous_error + (int64_t)rec->index[r] * PD_DIM * PDI_RECONSTRUCT_HESSIAN_SIZE;
    pdi_reconstruct_compute_hessian(rec->bonds->grid, rec->bonds->node[r], f, hessian);
    for (int a = 0; a < PD_DIM; a++)
        for (int c = 0; c < PDI_RECONSTRUCT_HESSIAN_SIZE; c++)
            error[a] += part[a * PDI_RECONSTRUCT_HESSIAN_SIZE + c] * hessian[c];
}

PDI_COLD_BEGIN
/* Describes the arrays of pd_quadratic_reconstruction to the array registry. */
static void pdi_reconstruct_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_quadratic_reconstruction *slopes = (pd_quadratic_reconstruction *)object;
    int64_t count = slopes->capacity, terms = PDI_RECONSTRUCT_TERMS, wide = slopes->wide_capacity;
    PDI_ARRAY(owner, slopes, row, count, "1");
    PDI_ARRAY(owner, slopes, has_velocity_fit, count, "1");
    PDI_ARRAY(owner, slopes, wall_coefficients, count * terms, "1/m2");
    PDI_ARRAY(owner, slopes, wall_friction, count, "1/m2");
    PDI_ARRAY(owner, slopes, viscous_error, (count - wide) * PD_DIM * PDI_RECONSTRUCT_HESSIAN_SIZE, "m");
    PDI_ARRAY(owner, slopes, has_scalar_fit, wide, "1");
    PDI_ARRAY(owner, slopes, gradient_map, wide * PD_DIM * terms, "1/m");
    PDI_ARRAY(owner, slopes, weighted_terms, slopes->bonds ? slopes->bonds->stencil->count * terms : 0, "1");
    PDI_ARRAY(owner, slopes, index, slopes->row_capacity, "1");
}

/* Frees and allocates the arrays, for `count` rows and a quarter more, when `count` or the capacity of the bonds
 * exceeds theirs; earlier contents are lost then. Else does nothing. On failure no array is left. */
static pd_status pdi_reconstruct_reserve(pd_ctx *ctx, int32_t count, pd_quadratic_reconstruction *rec)
{
    const pd_bonds *bonds = rec->bonds;
    if (count <= rec->capacity && bonds->capacity <= rec->row_capacity) return PD_OK;
    pdi_reconstruct_free(ctx, rec);
    rec->bonds = bonds;
    rec->capacity = count + count / 4;
    rec->wide_capacity = bonds->stencil->reach > 1 ? rec->capacity : 0;
    rec->row_capacity = bonds->capacity;
    pd_status status = pdi_array_registry_build(ctx, pdi_reconstruct_list_arrays, rec);
    if (status < 0) rec->capacity = rec->wide_capacity = rec->row_capacity = 0;
    return status;
}
PDI_COLD_END

PDI_FN pd_status pdi_reconstruct_update(pd_ctx *ctx, const pd_bonds *bonds, const double *extra_weight, double factor,
                                        pd_quadratic_reconstruction *rec)
{
    int32_t count = 0;
    for (int32_t r = 0; r < bonds->rows; r++) count += bonds->near_smooth_surface[r];
    rec->bonds = bonds;
    PD_TRY(pdi_reconstruct_reserve(ctx, count, rec));
    rec->count = 0;
    for (int k = 0; k < bonds->stencil->count && count; k++) {
        double *term = rec->weighted_terms + k * PDI_RECONSTRUCT_TERMS;
        pdi_reconstruct_compute_terms(bonds->stencil, k, 1.0, term);
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) term[a] *= bonds->stencil->base_weight[k];
    }
    for (int32_t r = 0; r < rec->row_capacity; r++) {
        int32_t q = rec->count;
        rec->index[r] = -1;
        if (r >= bonds->rows || !bonds->near_smooth_surface[r]) continue;
        rec->index[r] = q;
        rec->row[q] = r;
        rec->has_velocity_fit[q] = (uint8_t)pdi_reconstruct_compute_velocity_fit(
            bonds, r, extra_weight, factor, rec->wall_coefficients + (int64_t)q * PDI_RECONSTRUCT_TERMS,
            rec->wall_friction + q);
        pdi_reconstruct_compute_cubic_errors(rec, r, extra_weight, factor);
        if (rec->wide_capacity) rec->has_scalar_fit[q] = (uint8_t)pdi_reconstruct_compute_scalar_fit(rec, r);
        rec->count++;
    }
    return PD_OK;
}

PDI_FN void pdi_reconstruct_set_gradient(const pd_ctx *ctx, const pd_quadratic_reconstruction *rec, const double *f,
                                         double *grad)
{
    const pd_bonds *bonds = rec->bonds;
    if (!rec->count) return;
    const pd_grid *grid = bonds->grid;
    int each = rec->wide_capacity ? bonds->stencil->count * PDI_RECONSTRUCT_TERMS : PD_DIM * 4;
    int nt = pd_par_threads(ctx, (int64_t)rec->count * each);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t q = 0; q < rec->count; q++) {
        int32_t node = bonds->node[rec->row[q]];
        double fit[PD_DIM];
        int known = rec->wide_capacity && rec->has_scalar_fit[q];
        if (known) pdi_reconstruct_apply_scalar_fit(rec, rec->row[q], f, fit);
        for (int d = 0; d < PD_DIM && known; d++) grad[(int64_t)d * grid->total + node] = fit[d];
        for (int d = 0; d < PD_DIM && !known; d++) {
            int32_t step[2];
            if (!pdi_reconstruct_find_parabola(grid, node, d, step)) continue;
            double first = f[node + step[0]] - f[node], second = f[node + step[1]] - f[node];
            double slope = step[1] == -step[0] ? 0.5 * (first - second) : 2.0 * first - 0.5 * second;
            grad[(int64_t)d * grid->total + node] = (step[0] > 0 ? slope : -slope) / grid->h[d];
        }
    }
}

PDI_FN void pdi_reconstruct_apply_wall_laplacian(const pd_quadratic_reconstruction *rec, int32_t r, const double *u,
                                                 double *wall)
{
    const pd_bonds *bonds = rec->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t node = bonds->node[r], q = rec->index[r];
    int64_t total = bonds->grid->total;
    const double *coefficients = rec->wall_coefficients + (int64_t)q * PDI_RECONSTRUCT_TERMS;
    for (int d = 0; d < PD_DIM; d++) wall[d] = -rec->wall_friction[q] * u[d * total + node];
    for (int k = 0; k < s->count; k++) {
        const double *term = rec->weighted_terms + k * PDI_RECONSTRUCT_TERMS;
        double weight = 0.0;
        if (!pdi_bond_is_open(bonds, r, k)) continue;
        for (int a = 0; a < PDI_RECONSTRUCT_TERMS; a++) weight += coefficients[a] * term[a];
        for (int d = 0; d < PD_DIM; d++)
            wall[d] += weight * (u[d * total + node + bonds->paths.shift[k]] - u[d * total + node]);
    }
}

PDI_FN void pdi_reconstruct_free(pd_ctx *ctx, pd_quadratic_reconstruction *rec)
{
    pdi_array_registry_free(ctx, pdi_reconstruct_list_arrays, rec);
    memset(rec, 0, sizeof *rec);
}

#undef PDI_RECONSTRUCT_TERMS
#undef PDI_RECONSTRUCT_MIN_PIVOT
#undef PDI_RECONSTRUCT_STEP
#undef PDI_RECONSTRUCT_EDGE_CURVATURE
