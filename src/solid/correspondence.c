/* correspondence: see correspondence.h */
#include "solid/correspondence.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Singular shape tensor: smallest pivot over the largest entry of K below which the bonds of a family lie in a plane
 * (3D) or on a line, and no gradient exists. */
#define PDI_CORRESPONDENCE_MIN_PIVOT 1e-6

enum {
    PDI_CORRESPONDENCE_TENSOR = PD_DIM * PD_DIM,
    PDI_CORRESPONDENCE_FOURTH = PD_DIM == 3   ? 15
                                : PD_DIM == 2 ? 5
                                              : 1
};

/* Scalar product of two vectors. */
static inline double pdi_correspondence_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d] * b[d];
    return sum;
}

/* Current bond of point i: xi [m], 1/r^2 [1/m2], weight w V_j [m^d]. Returns 1; 0: it is broken, and weight is 0. */
static inline int pdi_correspondence_get_bond(const pd_correspondence *e, int32_t i, const pd_bond_iterator *f,
                                              double *xi, double *inv_r2, double *weight)
{
    *weight = pdi_bond_weights_get_intact(&e->weights, i, f);
    if (!(*weight > 0.0)) return 0;
    pdi_body_bond_vector(e->body, i, f, xi);
    *inv_r2 = 1.0 / pdi_correspondence_dot(xi, xi);
    *weight *= e->body->volume[f->neighbour];
    return 1;
}

/* y = A x. */
static inline void pdi_correspondence_multiply_vector(const double *a, const double *x, double *y)
{
    for (int p = 0; p < PD_DIM; p++) {
        y[p] = 0.0;
        for (int q = 0; q < PD_DIM; q++) y[p] += a[p * PD_DIM + q] * x[q];
    }
}

/* c = a b. */
static inline void pdi_correspondence_multiply(const double *a, const double *b, double *c)
{
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            double sum = 0.0;
            for (int k = 0; k < PD_DIM; k++) sum += a[p * PD_DIM + k] * b[k * PD_DIM + q];
            c[p * PD_DIM + q] = sum;
        }
}

/* Trace of a tensor. */
static inline double pdi_correspondence_trace(const double *a)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d * PD_DIM + d];
    return sum;
}

/* Factor [-] of E and of the yield stress of point i. */
static inline double pdi_correspondence_stiffness_factor(const pd_correspondence *e, int32_t i)
{
    return e->desc.stiffness_factor ? e->desc.stiffness_factor[i] : 1.0;
}

/* Elastic stress p [PD_DIM^2] [Pa] of a displacement gradient h by Hooke's law, without the factor of E of a point. */
static inline void pdi_correspondence_hooke_stress(const pd_correspondence *e, const double *h, double *p)
{
    double trace = pdi_correspondence_trace(h);
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++)
            p[a * PD_DIM + b] = e->mu * (h[a * PD_DIM + b] + h[b * PD_DIM + a]) + (a == b ? e->lambda * trace : 0.0);
}

/* Non-uniform part of the displacement of a bond: z = eta - h xi [m]. Returns z.xi/r^2. */
static inline double pdi_correspondence_compute_nonuniform(const double *h, const double *xi, const double *eta,
                                                           double inv_r2, double *z)
{
    pdi_correspondence_multiply_vector(h, xi, z);
    for (int d = 0; d < PD_DIM; d++) z[d] = eta[d] - z[d];
    return pdi_correspondence_dot(z, xi) * inv_r2;
}

/* ---- build ---- */

PDI_FN void pdi_correspondence_list(pdi_array_visitor *owner, void *object)
{
    pd_correspondence *elastic = (pd_correspondence *)object;
    int64_t count = elastic->body ? elastic->body->count : 0;
    PDI_ARRAY(owner, elastic, influential, count, "1");
    PDI_ARRAY(owner, elastic, shape, count * PDI_CORRESPONDENCE_TENSOR, "1/m^(d+2)");
    PDI_ARRAY(owner, elastic, second_moment, count * PDI_CORRESPONDENCE_TENSOR, "1");
    PDI_ARRAY(owner, elastic, fourth_moment, count * PDI_CORRESPONDENCE_FOURTH, "1");
    PDI_ARRAY(owner, elastic, weight_sum, count, "m^d");
    PDI_ARRAY(owner, elastic, surface_vector, count * PD_DIM, "1/m");
}

/* Index of n_p n_q n_r n_s among the fourth moments: by how many of the indices are y, and how many z. */
static inline int pdi_correspondence_fourth_index(int p, int q, int r, int s)
{
    int y = (p == 1) + (q == 1) + (r == 1) + (s == 1), z = (p == 2) + (q == 2) + (r == 2) + (s == 2);
    return z * (11 - z) / 2 + y;
}

/* Adds a bond of weight w V_j [m^d] to the sum of fourth moments of its family, fourth [PDI_CORRESPONDENCE_FOURTH]
 * [m^d]. */
static void pdi_correspondence_add_fourth(const double *xi, double inv_r2, double weight, double *fourth)
{
    double x[5], y[5], z[5];
    x[0] = weight * inv_r2 * inv_r2;
    y[0] = z[0] = 1.0;
    for (int k = 0; k < 4; k++) {
        x[k + 1] = x[k] * xi[0];
        y[k + 1] = y[k] * xi[PD_DIM > 1];
        z[k + 1] = z[k] * xi[PD_DIM - 1];
    }
    for (int c = 0; c <= (PD_DIM > 2 ? 4 : 0); c++)
        for (int b = 0; b <= (PD_DIM > 1 ? 4 - c : 0); b++)
            fourth[c * (11 - c) / 2 + b] += x[4 - c - b] * y[b] * z[c];
}

/* Sets inverse shape tensor, second and fourth direction moments and weight_sum of point i. Returns 1; 0: there are no
 * bonds or the shape tensor is singular: its inverse is zero, the others may be not. */
static int pdi_correspondence_compute_family(const pd_correspondence *e, int32_t i)
{
    const pd_body *body = e->body;
    double k[PDI_CORRESPONDENCE_TENSOR] = {0.0}, total = 0.0, scale = 1.0 / (body->horizon * body->horizon), xi[PD_DIM];
    double *mean = e->second_moment + (int64_t)i * PDI_CORRESPONDENCE_TENSOR,
           *shape = e->shape + (int64_t)i * PDI_CORRESPONDENCE_TENSOR;
    double *fourth = e->fourth_moment + (int64_t)i * PDI_CORRESPONDENCE_FOURTH;
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) mean[p] = 0.0;
    for (int p = 0; p < PDI_CORRESPONDENCE_FOURTH; p++) fourth[p] = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double over, weight;
        if (!pdi_correspondence_get_bond(e, i, &f, xi, &over, &weight)) continue;
        total += weight;
        pdi_correspondence_add_fourth(xi, over, weight, fourth);
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++) {
                k[p * PD_DIM + q] += weight * scale * xi[p] * xi[q];
                mean[p * PD_DIM + q] += weight * xi[p] * xi[q] * over;
            }
    }
    e->weight_sum[i] = total;
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) shape[p] = 0.0;
    if (!(total > 0.0)) return 0;
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) mean[p] /= total;
    for (int p = 0; p < PDI_CORRESPONDENCE_FOURTH; p++) fourth[p] /= total;
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) k[p] /= total;
    if (!(pdi_vec_invert(k, shape) > PDI_CORRESPONDENCE_MIN_PIVOT)) {
        for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) shape[p] = 0.0;
        return 0;
    }
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) shape[p] *= scale / total;
    return 1;
}

/* Stiffness, gradient, force tensor and plastic stress fields of point i for the surface vectors: these are the forces
 * of the displacements u = x with 1/w_0, A = (1 - M) K^-1, lambda = -1 and mu = 1 (theory: eq. 14.5). */
static void pdi_correspondence_set_surface_fields(const pd_correspondence *e, int32_t i)
{
    const double *mean = e->second_moment + (int64_t)i * PDI_CORRESPONDENCE_TENSOR;
    const double *shape = e->shape + (int64_t)i * PDI_CORRESPONDENCE_TENSOR;
    double part[PDI_CORRESPONDENCE_TENSOR], *field = pdi_point_batch_get_field(&e->band, 0) + i;
    pdi_correspondence_multiply(mean, shape, part);
    field[PDI_POINT_BATCH_STIFFNESS * e->band.stride] = e->weight_sum[i] > 0.0 ? 1.0 / e->weight_sum[i] : 0.0;
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) {
        field[(PDI_POINT_BATCH_GRADIENT + p) * e->band.stride] = 0.0;
        field[(PDI_POINT_BATCH_FORCE_TENSOR + p) * e->band.stride] = shape[p] - part[p];
        if (e->band.fields > PDI_POINT_BATCH_PLASTIC_STRESS)
            field[(PDI_POINT_BATCH_PLASTIC_STRESS + p) * e->band.stride] = 0.0;
    }
}

/* Computes the surface vectors of all points, then stores the stiffness fields. Displacement fields are positions
 * afterwards. */
static void pdi_correspondence_compute_edges(const pd_ctx *ctx, const pd_correspondence *e)
{
    int nt = pd_par_threads(ctx, e->body->bonds * 20);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &e->band, e->body->position);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < e->body->count; i++) pdi_correspondence_set_surface_fields(e, i);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++)
        pdi_point_batch_compute_force(&e->band, k, -1.0, 1.0, e->surface_vector);
    for (int32_t i = 0; i < e->body->count; i++)
        pdi_point_batch_get_field(&e->band, PDI_POINT_BATCH_STIFFNESS)[i] *= pdi_correspondence_stiffness_factor(e, i);
}

/* Tensors of all families; weight_sum is 0 where the shape tensor is singular. Returns the first of these points, with
 * detach_singular the first one that has intact bonds; -1: there is none. */
static int32_t pdi_correspondence_compute_families(const pd_ctx *ctx, const pd_correspondence *e)
{
    const pd_body *body = e->body;
    int32_t flat = -1;
    int nt = pd_par_threads(ctx, body->bonds * 40);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++)
        if (!pdi_correspondence_compute_family(e, i)) e->weight_sum[i] = 0.0;
    for (int32_t i = body->count - 1; i >= 0; i--)
        if (!(e->weight_sum[i] > 0.0) && (!e->desc.detach_singular || pdi_body_bonds_count_intact(body, i))) flat = i;
    return flat;
}

pd_status pd_correspondence_update(pd_ctx *ctx, pd_correspondence *e)
{
    const pd_body *body = e->body;
    int32_t flat = pdi_correspondence_compute_families(ctx, e);
    while (flat >= 0 && e->desc.detach_singular) {
        for (int32_t i = flat; i < body->count; i++)
            if (!(e->weight_sum[i] > 0.0)) e->detached_bonds += pdi_body_bonds_break_all(e->body, i);
        flat = pdi_correspondence_compute_families(ctx, e);
    }
    if (flat >= 0)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "correspondence",
                       "the %.0f bonds of point %d at x = %g m do not span all directions: the body is too thin there "
                       "for its horizon",
                       (double)pdi_body_bonds_count_intact(body, flat), (int)flat,
                       body->position[(int64_t)flat * PD_DIM]);
    PD_TRY(pdi_point_batch_update(ctx, &e->band));
    pdi_correspondence_compute_edges(ctx, e);
    return PD_OK;
}

/* Inner part of the build; after an error the caller frees. In 1D mu is 0 and lambda E; in plane stress lambda is E
 * nu/(1 - nu^2). Arrays of plasticity exist with a yield stress alone. */
static pd_status pdi_correspondence_build_inner(pd_ctx *ctx, pd_body *body, const pd_correspondence_desc *desc,
                                                pd_correspondence *e)
{
    double nu = PD_DIM == 1 ? 0.0 : desc->poisson;
    memset(e, 0, sizeof *e);
    if (!(desc->young > 0.0) || !(desc->young < 1e100) || !(nu > -1.0) || !(nu < 0.5))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "correspondence",
                       "E = %g Pa and nu = %g, expected a finite positive E and nu between -1 and 0.5", desc->young,
                       desc->poisson);
    if (!(desc->yield >= 0.0) || !(desc->yield < 1e100) || !(desc->hardening >= 0.0) || !(desc->hardening < 1e100) ||
        (desc->yield > 0.0 && PD_DIM == 2 && desc->plane == PD_PLANE_STRESS))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "correspondence",
                       "a yield stress of %g Pa that hardens by %g Pa: expected "
                       "finite and positive values, and in 2D plane strain",
                       desc->yield, desc->hardening);
    e->desc = *desc;
    e->body = body;
    e->mu = PD_DIM == 1 ? 0.0 : 0.5 * desc->young / (1.0 + nu);
    e->lambda = PD_DIM == 1 ? desc->young : desc->young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    if (PD_DIM == 2 && desc->plane == PD_PLANE_STRESS) e->lambda = desc->young * nu / (1.0 - nu * nu);
    e->plastic.count = desc->yield > 0.0 ? body->count : 0;
    e->plastic.shear = PD_DIM == 1 ? desc->young : e->mu;
    e->plastic.yield = desc->yield;
    e->plastic.hardening = desc->hardening;
    PD_TRY(pdi_array_registry_build(ctx, pdi_correspondence_list, e));
    PD_TRY(pdi_array_registry_build(ctx, pdi_j2_plasticity_list, &e->plastic));
    pdi_body_bonds_mark_influential(body, e->influential);
    PD_TRY(pdi_bond_weights_build(ctx, body, &e->weights));
    PD_TRY(pdi_bond_weights_compute_influence(ctx, &e->weights, desc->influence));
    PD_TRY(pdi_point_batch_build(ctx, body, &e->weights,
                                 e->plastic.count > 0 ? PDI_POINT_BATCH_FIELDS : PDI_POINT_BATCH_PLASTIC_STRESS,
                                 &e->band));
    return pd_correspondence_update(ctx, e);
}

pd_status pd_correspondence_build(pd_ctx *ctx, pd_body *body, const pd_correspondence_desc *desc, pd_correspondence *e)
{
    pd_status status = pdi_correspondence_build_inner(ctx, body, desc, e);
    if (status < 0) pd_correspondence_free(ctx, e);
    return status;
}

void pd_correspondence_free(pd_ctx *ctx, pd_correspondence *e)
{
    pdi_point_batch_free(ctx, &e->band);
    pdi_bond_weights_free(ctx, &e->weights);
    pdi_array_registry_free(ctx, pdi_j2_plasticity_list, &e->plastic);
    pdi_array_registry_free(ctx, pdi_correspondence_list, e);
    memset(e, 0, sizeof *e);
}

/* ---- forces ---- */

/* eta = u_j - u_i [m]. */
static inline void pdi_correspondence_relative_displacement(const double *u, int32_t i, int32_t j, double *eta)
{
    const double *from = u + (int64_t)i * PD_DIM, *to = u + (int64_t)j * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) eta[d] = to[d] - from[d];
}

/* Displacement gradient h [PD_DIM^2] of point i, number n of its batch; average, unless NULL: mean of the bond
 * gradients H_b. */
static void pdi_correspondence_compute_gradient(const pd_correspondence *e, const pdi_point_batch_sums *sums, int32_t i,
                                                int32_t n, double *h, double *average)
{
    double sum[PDI_CORRESPONDENCE_TENSOR], part[PDI_CORRESPONDENCE_TENSOR], total = e->weight_sum[i];
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) sum[p] = sums->moment[p][n];
    pdi_correspondence_multiply(sum, e->shape + (int64_t)i * PDI_CORRESPONDENCE_TENSOR, h);
    if (!average) return;
    pdi_correspondence_multiply(h, e->second_moment + (int64_t)i * PDI_CORRESPONDENCE_TENSOR, part);
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++)
        average[p] = h[p] + (total > 0.0 ? sums->unit_moment[p][n] / total - part[p] : 0.0);
}

/* Mean over the family of point i of the stress from the non-uniform parts z of bonds, times (1 - n n^T). z gives
 * lambda s 1 + mu (z n^T + n z^T)/r with s = z.n/r; the means of s, s n n^T and n z^T follow from sums over eta and
 * from direction moments. */
static void pdi_correspondence_compute_nonuniform_moment(const pd_correspondence *e, const pdi_point_batch_sums *sums,
                                                         int32_t i, int32_t n, const double *h, double *moment)
{
    const double *mean = e->second_moment + (int64_t)i * PDI_CORRESPONDENCE_TENSOR;
    const double *fourth = e->fourth_moment + (int64_t)i * PDI_CORRESPONDENCE_FOURTH;
    double over = 1.0 / e->weight_sum[i], stretch = 0.0;
    for (int d = 0; d < PD_DIM; d++) stretch += over * sums->unit_moment[d * PD_DIM + d][n];
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) stretch -= h[p] * mean[p];
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            double line = over * sums->axial_moment[p < q ? p * PD_DIM + q : q * PD_DIM + p][n];
            double across = over * sums->unit_moment[q * PD_DIM + p][n];
            for (int r = 0; r < PD_DIM; r++) {
                across -= mean[p * PD_DIM + r] * h[q * PD_DIM + r];
                for (int s = 0; s < PD_DIM; s++)
                    line -= fourth[pdi_correspondence_fourth_index(p, q, r, s)] * h[r * PD_DIM + s];
            }
            moment[p * PD_DIM + q] = e->lambda * ((p == q ? stretch : 0.0) - line) + e->mu * (across - line);
        }
}

/* Fields of point i, number n of its batch, that bonds read: the tensors of eq. 14.4 for the gradient h; subtracts the
 * plastic stress that is set. */
static void pdi_correspondence_set_force_fields(const pd_correspondence *e, const pdi_point_batch_sums *sums, int32_t i,
                                                int32_t n, const double *h)
{
    const double *mean = e->second_moment + (int64_t)i * PDI_CORRESPONDENCE_TENSOR;
    double sum[PDI_CORRESPONDENCE_TENSOR] = {0.0}, stress[PDI_CORRESPONDENCE_TENSOR], part[PDI_CORRESPONDENCE_TENSOR];
    double *field = pdi_point_batch_get_field(&e->band, 0) + i,
           share = field[PDI_POINT_BATCH_STIFFNESS * e->band.stride];
    if (e->weight_sum[i] > 0.0) pdi_correspondence_compute_nonuniform_moment(e, sums, i, n, h, sum);
    pdi_correspondence_hooke_stress(e, h, stress);
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR && e->plastic.count; p++) {
        double relief = e->plastic.plastic_stress[(int64_t)i * PDI_CORRESPONDENCE_TENSOR + p];
        stress[p] -= relief;
        field[(PDI_POINT_BATCH_PLASTIC_STRESS + p) * e->band.stride] = share * relief;
    }
    pdi_correspondence_multiply(stress, mean, part);
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++)
        sum[p] = pdi_correspondence_stiffness_factor(e, i) * (sum[p] + stress[p] - part[p]);
    pdi_correspondence_multiply(sum, e->shape + (int64_t)i * PDI_CORRESPONDENCE_TENSOR, part);
    for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) {
        int q = p % PD_DIM * PD_DIM + p / PD_DIM;
        field[(PDI_POINT_BATCH_FORCE_TENSOR + p) * e->band.stride] = part[p];
        field[(PDI_POINT_BATCH_GRADIENT + p) * e->band.stride] = share * h[q];
    }
}

/* 1: forces on real points depend on the families of batch k. */
static int pdi_correspondence_batch_is_influential(const pd_correspondence *e, int32_t k)
{
    for (int32_t i = e->band.first[k]; i < e->band.first[k + 1]; i++)
        if (e->influential[i]) return 1;
    return 0;
}

/* First pass of a force: gradients, plastic stresses and force tensors of all influential families at displacements u.
 * tangent 1: u is an increment, and the plastic part is its derivative by the step of the last force. */
static void pdi_correspondence_update_fields(const pd_ctx *ctx, const pd_correspondence *e, const double *u,
                                             int tangent)
{
    int nt = pd_par_threads(ctx, e->body->bonds * 40);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++) {
        pdi_point_batch_sums sums;
        if (!pdi_correspondence_batch_is_influential(e, k)) continue;
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++) {
            double h[PDI_CORRESPONDENCE_TENSOR], average[PDI_CORRESPONDENCE_TENSOR];
            int32_t i = e->band.first[k] + n;
            pdi_correspondence_compute_gradient(e, &sums, i, n, h, e->plastic.count ? average : NULL);
            if (e->plastic.count && tangent) pdi_j2_plasticity_apply_tangent(&e->plastic, i, average);
            else if (e->plastic.count) pdi_j2_plasticity_return_map(&e->plastic, i, average);
            pdi_correspondence_set_force_fields(e, &sums, i, n, h);
        }
    }
}

/* Second pass of a force: sums over bonds, into force [count][PD_DIM] [N/m3]. Entries of batches that hold mirror
 * images alone stay. */
static void pdi_correspondence_sum_forces(const pd_ctx *ctx, const pd_correspondence *e, double *force)
{
    int nt = pd_par_threads(ctx, e->body->bonds * 40);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++)
        if (e->band.first[k] < e->body->real_count) pdi_point_batch_compute_force(&e->band, k, e->lambda, e->mu, force);
}

void pd_correspondence_force(const pd_ctx *ctx, const pd_correspondence *e, const double *u, double *force)
{
    pdi_correspondence_update_fields(ctx, e, u, 0);
    pdi_correspondence_sum_forces(ctx, e, force);
}

/* w_0 times the elastic energy density of the family of point i [J m^d/m3], without stiffness factor and plasticity.
 * bond_energy [bonds]: energy density of the bonds of this family times w [J/m3], 0: broken; may be NULL. */
static double pdi_correspondence_family_energy(const pd_correspondence *e, const double *u, int32_t i, const double *h,
                                               double *bond_energy)
{
    double own[PDI_CORRESPONDENCE_TENSOR], p[PDI_CORRESPONDENCE_TENSOR], xi[PD_DIM], eta[PD_DIM], z[PD_DIM], sum = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(e->body, i); pd_body_bonds_next(&f);) {
        double over, weight, density = 0.0;
        if (bond_energy) bond_energy[pdi_body_bond_number(&f)] = 0.0;
        if (!pdi_correspondence_get_bond(e, i, &f, xi, &over, &weight)) continue;
        pdi_correspondence_relative_displacement(u, i, f.neighbour, eta);
        pdi_correspondence_compute_nonuniform(h, xi, eta, over, z);
        for (int k = 0; k < PDI_CORRESPONDENCE_TENSOR; k++) own[k] = h[k] + z[k / PD_DIM] * xi[k % PD_DIM] * over;
        pdi_correspondence_hooke_stress(e, own, p);
        for (int k = 0; k < PDI_CORRESPONDENCE_TENSOR; k++) density += 0.5 * p[k] * own[k];
        sum += weight * density;
        if (bond_energy)
            bond_energy[pdi_body_bond_number(&f)] = (double)pdi_bond_weights_get(&e->weights, i, &f) * density;
    }
    return sum;
}

/* Energy density [J/m3] of point i, number n of its batch, less that of the plastic strain; 0 without bonds. Plastic
 * stress and flow direction of the point are then those of u. */
static double pdi_correspondence_energy_density(const pd_correspondence *e, const double *u,
                                                const pdi_point_batch_sums *sums, int32_t i, int32_t n)
{
    double h[PDI_CORRESPONDENCE_TENSOR], average[PDI_CORRESPONDENCE_TENSOR], density;
    if (!(e->weight_sum[i] > 0.0)) return 0.0;
    pdi_correspondence_compute_gradient(e, sums, i, n, h, average);
    density = pdi_correspondence_family_energy(e, u, i, h, NULL) / e->weight_sum[i];
    if (e->plastic.count) {
        pdi_j2_plasticity_return_map(&e->plastic, i, average);
        density -= pdi_j2_plasticity_energy_relief(&e->plastic, i, average);
    }
    return pdi_correspondence_stiffness_factor(e, i) * density;
}

double pd_correspondence_energy(const pd_ctx *ctx, const pd_correspondence *e, const double *u)
{
    pdi_compensated_sum all = {0.0, 0.0};
    pdi_point_batch_sums sums;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    for (int32_t k = 0; k < e->band.batches; k++) {
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++) {
            int32_t i = e->band.first[k] + n;
            pdi_compensated_sum_add(&all, e->body->volume[i] * pdi_correspondence_energy_density(e, u, &sums, i, n));
        }
    }
    return pdi_compensated_sum_total(&all);
}

/* Stress p [PD_DIM^2] [Pa] of point i by its gradient h, or with plasticity by the mean gradient of its bonds, of which
 * plastic stress and flow direction then are; 0 without bonds. */
static void pdi_correspondence_point_stress(const pd_correspondence *e, int32_t i, const double *h,
                                            const double *average, double *p)
{
    for (int k = 0; k < PDI_CORRESPONDENCE_TENSOR; k++) p[k] = 0.0;
    if (!(e->weight_sum[i] > 0.0)) return;
    if (e->plastic.count) pdi_j2_plasticity_return_map(&e->plastic, i, average);
    pdi_correspondence_hooke_stress(e, e->plastic.count ? average : h, p);
    for (int k = 0; k < PDI_CORRESPONDENCE_TENSOR; k++) {
        if (e->plastic.count) p[k] -= e->plastic.plastic_stress[(int64_t)i * PDI_CORRESPONDENCE_TENSOR + k];
        p[k] *= pdi_correspondence_stiffness_factor(e, i);
    }
}

void pd_correspondence_stress(const pd_ctx *ctx, const pd_correspondence *e, const double *u, double *stress)
{
    int nt = pd_par_threads(ctx, e->body->bonds * 20);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++) {
        pdi_point_batch_sums sums;
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++) {
            double h[PDI_CORRESPONDENCE_TENSOR], average[PDI_CORRESPONDENCE_TENSOR];
            int32_t i = e->band.first[k] + n;
            pdi_correspondence_compute_gradient(e, &sums, i, n, h, average);
            pdi_correspondence_point_stress(e, i, h, average, stress + (int64_t)i * PDI_CORRESPONDENCE_TENSOR);
        }
    }
}

/* ---- what solvers see ---- */

/* pd_material_interface.force. */
static pd_status pdi_correspondence_ops_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    pd_correspondence_force(ctx, (const pd_correspondence *)self, u, force);
    return PD_OK;
}

/* pd_material_interface.tangent. Overwrites the fields of the batches, and with plasticity plastic_stress, by those of
 * the increment; the consistent tangent is that of the step of the last force. Entries of images: as of
 * pd_correspondence_force. */
static void pdi_correspondence_ops_tangent(const pd_ctx *ctx, void *self, const double *du, double *df)
{
    pdi_correspondence_update_fields(ctx, (const pd_correspondence *)self, du, 1);
    pdi_correspondence_sum_forces(ctx, (const pd_correspondence *)self, df);
}

/* pd_material_interface.blocks: each bond gives (mu 1 + (lambda + mu) n n^T)/r^2 of both families, as if the other
 * points did not move. */
static void pdi_correspondence_ops_blocks(const pd_ctx *ctx, void *self, double *block)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    const pd_body *body = e->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double *a = block + (int64_t)i * PDI_CORRESPONDENCE_TENSOR, xi[PD_DIM];
        for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) a[p] = 0.0;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            double over, weight;
            if (!pdi_correspondence_get_bond(e, i, &f, xi, &over, &weight)) continue;
            double share = weight * body->volume[i] * over *
                           (pdi_correspondence_stiffness_factor(e, i) / e->weight_sum[i] +
                            pdi_correspondence_stiffness_factor(e, f.neighbour) / e->weight_sum[f.neighbour]);
            for (int p = 0; p < PDI_CORRESPONDENCE_TENSOR; p++) {
                int row = p / PD_DIM, column = p % PD_DIM;
                a[p] += share * ((row == column ? e->mu : 0.0) + (e->lambda + e->mu) * xi[row] * xi[column] * over);
            }
        }
    }
}

/* pd_material_interface.moduli: Lame's moduli times the mean of the stiffness factor of the point and the weighted mean
 * factor of its neighbours, since a bond has the stiffness of both families. Without bonds or factors: the own
 * factor. */
static void pdi_correspondence_ops_moduli(const pd_ctx *ctx, void *self, double *lambda, double *mu)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    const pd_body *body = e->body;
    int nt = pd_par_threads(ctx, body->bonds * 4);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double sum = 0.0, own = pdi_correspondence_stiffness_factor(e, i);
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i);
             e->desc.stiffness_factor && e->weight_sum[i] > 0.0 && pd_body_bonds_next(&f);)
            sum += pdi_bond_weights_get_intact(&e->weights, i, &f) * body->volume[f.neighbour] *
                   (pdi_correspondence_stiffness_factor(e, f.neighbour) - own);
        double part = own + (sum != 0.0 ? 0.5 * sum / e->weight_sum[i] : 0.0);
        lambda[i] = part * e->lambda;
        mu[i] = part * e->mu;
    }
}

/* pd_material_interface.energy. */
static double pdi_correspondence_ops_energy(const pd_ctx *ctx, void *self, const double *u)
{
    return pd_correspondence_energy(ctx, (const pd_correspondence *)self, u);
}

/* pd_material_interface.bond_energy, of materials without plasticity: w/w_0 times the energy density of each bond by
 * its own gradient, times the stiffness factor of its point; 0 for a broken bond. */
static void pdi_correspondence_ops_bond_energy(const pd_ctx *ctx, void *self, const double *u, double *energy)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    int nt = pd_par_threads(ctx, e->body->bonds * 40);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++) {
        pdi_point_batch_sums sums;
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++) {
            double h[PDI_CORRESPONDENCE_TENSOR], share;
            int32_t i = e->band.first[k] + n;
            share = e->weight_sum[i] > 0.0 ? pdi_correspondence_stiffness_factor(e, i) / e->weight_sum[i] : 0.0;
            pdi_correspondence_compute_gradient(e, &sums, i, n, h, NULL);
            pdi_correspondence_family_energy(e, u, i, h, energy);
            for (int64_t b = e->body->first_bond[i]; b < e->body->first_bond[i + 1]; b++) energy[b] *= share;
        }
    }
}

/* pd_material_interface.density: elastic energy density of all points, less that of the plastic strain of the step to
 * u; 0 without bonds. */
static void pdi_correspondence_ops_density(const pd_ctx *ctx, void *self, const double *u, double *density)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    int nt = pd_par_threads(ctx, e->body->bonds * 40);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++) {
        pdi_point_batch_sums sums;
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++)
            density[e->band.first[k] + n] = pdi_correspondence_energy_density(e, u, &sums, e->band.first[k] + n, n);
    }
}

/* pd_material_interface.plastic_strain. */
static void pdi_correspondence_ops_plastic_strain(const pd_ctx *ctx, const void *self, double *strain)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    (void)ctx;
    memcpy(strain, e->plastic.equivalent_strain, (size_t)e->body->count * sizeof *strain);
}

/* pd_material_interface.stress. */
static void pdi_correspondence_ops_stress(const pd_ctx *ctx, void *self, const double *u, double *stress)
{
    pd_correspondence_stress(ctx, (const pd_correspondence *)self, u, stress);
}

/* pd_material_interface.dissipated: plastic work, with the part that hardening stores, of the real points. */
static double pdi_correspondence_ops_dissipated(const void *self)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    pdi_compensated_sum all = {0.0, 0.0};
    for (int32_t i = 0; i < e->body->real_count && e->plastic.count; i++)
        pdi_compensated_sum_add(&all, e->body->volume[i] * pdi_correspondence_stiffness_factor(e, i) *
                                          pdi_j2_plasticity_dissipated(&e->plastic, i));
    return pdi_compensated_sum_total(&all);
}

/* pd_material_interface.out_of_plane_stress: that of plane strain, with the out-of-plane plastic strain; 0 in plane
 * stress and for a point without stiffness or bonds. */
static double pdi_correspondence_ops_normal_stress(const void *self, int32_t i, const double *stress)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    double stiff = pdi_correspondence_stiffness_factor(e, i), relief = 0.0;
    if (PD_DIM != 2 || e->desc.plane == PD_PLANE_STRESS || !(stiff > 0.0) || !(e->weight_sum[i] > 0.0)) return 0.0;
    if (e->plastic.count)
        relief = pdi_correspondence_trace(e->plastic.plastic_stress + (int64_t)i * PDI_CORRESPONDENCE_TENSOR);
    double trace = (pdi_correspondence_trace(stress) / stiff + relief) / (2.0 * (e->lambda + e->mu));
    return stiff * (e->lambda * trace + relief);
}

/* pd_material_interface.update. */
static pd_status pdi_correspondence_ops_update(pd_ctx *ctx, void *self)
{
    return pd_correspondence_update(ctx, (pd_correspondence *)self);
}

/* pd_material_interface.commit: the plastic strains of the step to u become the state, but not of points without bonds.
 * Without plasticity nothing happens. Displacement fields are u afterwards. */
static pd_status pdi_correspondence_ops_commit(pd_ctx *ctx, void *self, const double *u)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    int nt = pd_par_threads(ctx, e->body->bonds * 20);
    (void)nt;
    if (!e->plastic.count) return PD_OK;
    pdi_point_batch_set_displacements(ctx, &e->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < e->band.batches; k++) {
        pdi_point_batch_sums sums;
        int32_t count = pdi_point_batch_compute_sums(&e->band, k, &sums);
        for (int32_t n = 0; n < count; n++) {
            double h[PDI_CORRESPONDENCE_TENSOR], average[PDI_CORRESPONDENCE_TENSOR];
            int32_t i = e->band.first[k] + n;
            pdi_correspondence_compute_gradient(e, &sums, i, n, h, average);
            if (e->weight_sum[i] > 0.0) pdi_j2_plasticity_commit(&e->plastic, i, average);
        }
    }
    return PD_OK;
}

/* pd_material_interface.store: broken bonds and plastic strains; after reading the material is updated. */
static pd_status pdi_correspondence_ops_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_correspondence *e = (pd_correspondence *)self;
    PD_TRY(pdi_array_registry_store(ctx, pdi_body_list_state, e->body, archive));
    if (e->plastic.count) PD_TRY(pdi_array_registry_store(ctx, pdi_j2_plasticity_list, &e->plastic, archive));
    return archive->is_reading ? pd_correspondence_update(ctx, e) : PD_OK;
}

/* pd_material_interface.stable_step, by an upper bound of the highest frequency: |H|^2 is at most tr K^-1 times sum w V
 * |eta|^2, and |eta|^2 at most twice the squares of both ends; the largest bound of all points counts. HUGE_VAL: there
 * are no bonds. */
static double pdi_correspondence_ops_stable_step(const void *self, double density)
{
    const pd_correspondence *e = (const pd_correspondence *)self;
    double most = 0.0, modulus = 2.0 * e->mu + pd_max(PD_DIM * e->lambda, 0.0);
    for (int32_t i = 0; i < e->body->count; i++) {
        double sum = 0.0, xi[PD_DIM], own = pdi_correspondence_trace(e->shape + (int64_t)i * PDI_CORRESPONDENCE_TENSOR);
        for (pd_bond_iterator f = pd_body_bonds_begin(e->body, i); pd_body_bonds_next(&f);) {
            double over, weight;
            if (!pdi_correspondence_get_bond(e, i, &f, xi, &over, &weight)) continue;
            double other = pdi_correspondence_trace(e->shape + (int64_t)f.neighbour * PDI_CORRESPONDENCE_TENSOR);
            sum += weight *
                   (pdi_correspondence_stiffness_factor(e, i) * (over / e->weight_sum[i] + own) +
                    pdi_correspondence_stiffness_factor(e, f.neighbour) * (over / e->weight_sum[f.neighbour] + other));
        }
        most = pd_max(most, sum * modulus);
    }
    return most > 0.0 ? sqrt(2.0 * density / most) : HUGE_VAL;
}

pd_material_interface pd_correspondence_material(pd_correspondence *e)
{
    pd_material_interface solid;
    memset(&solid, 0, sizeof solid);
    solid.name = "elastic";
    solid.self = e;
    solid.body = e->body;
    solid.surface_vector = e->surface_vector;
    solid.linear = !e->plastic.count;
    solid.force = pdi_correspondence_ops_force;
    solid.tangent = pdi_correspondence_ops_tangent;
    solid.blocks = pdi_correspondence_ops_blocks;
    solid.moduli = pdi_correspondence_ops_moduli;
    solid.energy = pdi_correspondence_ops_energy;
    if (!e->plastic.count) solid.bond_energy = pdi_correspondence_ops_bond_energy;
    solid.stress = pdi_correspondence_ops_stress;
    solid.out_of_plane_stress = pdi_correspondence_ops_normal_stress;
    solid.density = pdi_correspondence_ops_density;
    if (e->plastic.count) solid.dissipated = pdi_correspondence_ops_dissipated;
    if (e->plastic.count) solid.plastic_strain = pdi_correspondence_ops_plastic_strain;
    solid.update = pdi_correspondence_ops_update;
    solid.commit = pdi_correspondence_ops_commit;
    solid.stable_step = pdi_correspondence_ops_stable_step;
    solid.store = pdi_correspondence_ops_store;
    return solid;
}

#undef PDI_CORRESPONDENCE_MIN_PIVOT
