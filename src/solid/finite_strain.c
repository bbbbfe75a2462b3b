/* finite_strain: see finite_strain.h */
#include "solid/finite_strain.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "solid/tensor.h"
#include <math.h>
#include <string.h>

/* Singular shape tensor: smallest pivot over the largest entry of K below which the bonds of a family lie in a plane
 * (3D) or on a line, and no gradient exists. */
#define PDI_FINITE_STRAIN_MIN_PIVOT 1e-6
/* Scalar operations of a bond, for the choice of the number of threads. */
#define PDI_FINITE_STRAIN_OPERATIONS 300

/* Data of a bond in a family. */
typedef struct pdi_finite_strain_bond {
    double xi[PD_DIM]; /* [m] */
    double inv_r2;     /* [1/m2] 1/r^2 */
    double w;          /* [-] w */
    double weight;     /* [m^d] w V_j */
} pdi_finite_strain_bond;

/* 1: each bond has its own deformation gradient; 0: that of the family. */
static int pdi_finite_strain_bond_gradients(const pd_finite_strain *f)
{
    return f->desc.control == PD_FINITE_STRAIN_BOND_GRADIENT;
}

/* Data of the current bond of point i. Returns 1; 0: it is broken, and bond holds nothing but w = 0. */
static inline int pdi_finite_strain_get_bond(const pd_finite_strain *f, int32_t i, const pd_bond_iterator *it,
                                             pdi_finite_strain_bond *bond)
{
    bond->w = pdi_bond_weights_get_intact(&f->weights, i, it);
    if (!(bond->w > 0.0)) return 0;
    pdi_body_bond_vector(f->body, i, it, bond->xi);
    bond->inv_r2 = 1.0 / pdi_tensor_dot(bond->xi, bond->xi);
    bond->weight = bond->w * f->body->volume[it->neighbour];
    return 1;
}

/* Factor of the moduli of point i. */
static double pdi_finite_strain_stiffness_factor(const pd_finite_strain *f, int32_t i)
{
    return f->desc.stiffness_factor ? f->desc.stiffness_factor[i] : 1.0;
}

/* Plastic state [PDI_CONSTITUTIVE_LAW_STATE] of a site: number of a bond, with plain correspondence of a point; NULL
 * but for J2. */
static double *pdi_finite_strain_get_state(const pd_finite_strain *f, int64_t site)
{
    return f->desc.law.kind == PD_FINITE_STRAIN_J2 ? f->state + site * PDI_CONSTITUTIVE_LAW_STATE : NULL;
}

/* Moduli of the constitutive law, which the build has checked. */
static pdi_constitutive_law_params pdi_finite_strain_get_law(const pd_finite_strain *f)
{
    pdi_constitutive_law_params m;
    pd_ctx none;
    pd_ctx_init(&none);
    pdi_constitutive_law_init(&none, &f->desc.law, &m);
    return m;
}

/* ---- build ---- */

PDI_FN void pdi_finite_strain_list(pdi_array_visitor *owner, void *object)
{
    pd_finite_strain *finite = (pd_finite_strain *)object;
    int64_t count = finite->body ? finite->body->count : 0, bonds = finite->body ? finite->body->bonds : 0;
    int64_t sites = pdi_finite_strain_bond_gradients(finite) ? bonds : count;
    PDI_ARRAY(owner, finite, reverse_bond, bonds, "1");
    PDI_ARRAY(owner, finite, influential, count, "1");
    PDI_ARRAY(owner, finite, shape, count * PDI_TENSOR, "1/m^(d+2)");
    PDI_ARRAY(owner, finite, weight_sum, count, "m^d");
    PDI_ARRAY(owner, finite, surface_vector, count * PD_DIM, "1/m");
    PDI_ARRAY(owner, finite, u, count * PD_DIM, "m");
    PDI_ARRAY(owner, finite, gradient, count * PDI_TENSOR, "1");
    PDI_ARRAY(owner, finite, force_state, bonds * PD_DIM, "N/m^(2d)");
    PDI_ARRAY(owner, finite, work, count, "");
    if (PD_DIM == 2) PDI_ARRAY(owner, finite, out_of_plane_stress, count, "Pa");
    PDI_SCALAR_STATE(owner, finite, plastic_work, "J");
    if (finite->desc.store_tangent) PDI_ARRAY(owner, finite, moduli, sites * PDI_CONSTITUTIVE_LAW_TANGENT, "Pa");
    if (finite->desc.law.kind == PD_FINITE_STRAIN_J2)
        PDI_ARRAY_STATE(owner, finite, state, sites * PDI_CONSTITUTIVE_LAW_STATE, "1");
}

/* Sets reverse_bond: the number of each bond within the family of its other end. */
static void pdi_finite_strain_find_reverse_bonds(const pd_ctx *ctx, const pd_finite_strain *f)
{
    const pd_body *body = f->body;
    int nt = pd_par_threads(ctx, body->bonds * 60);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);)
            f->reverse_bond[pdi_body_bond_number(&b)] = pdi_body_bonds_find_reverse(body, i, &b);
}

/* Sets inverse shape tensor K^-1 and total weight w_0 of point i, both 0 where K is singular. mean [PD_DIM^2] [-]: of n
 * n^T over its bonds. */
static void pdi_finite_strain_compute_family(const pd_finite_strain *f, int32_t i, double *mean)
{
    double k[PDI_TENSOR] = {0.0}, total = 0.0, scale = 1.0 / (f->body->horizon * f->body->horizon);
    double *shape = f->shape + (int64_t)i * PDI_TENSOR;
    pdi_finite_strain_bond bond;
    for (int p = 0; p < PDI_TENSOR; p++) mean[p] = 0.0;
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        total += bond.weight;
        for (int p = 0; p < PDI_TENSOR; p++) {
            double square = bond.weight * bond.xi[p / PD_DIM] * bond.xi[p % PD_DIM];
            k[p] += square * scale;
            mean[p] += square * bond.inv_r2;
        }
    }
    for (int p = 0; p < PDI_TENSOR && total > 0.0; p++) k[p] /= total;
    for (int p = 0; p < PDI_TENSOR && total > 0.0; p++) mean[p] /= total;
    int spans = total > 0.0 && pdi_vec_invert(k, shape) > PDI_FINITE_STRAIN_MIN_PIVOT;
    for (int p = 0; p < PDI_TENSOR; p++) shape[p] = spans ? shape[p] * scale / total : 0.0;
    f->weight_sum[i] = spans ? total : 0.0;
}

/* Bond vectors g of the family of point i into force_state, 0 for broken bonds: a uniform stress P has the force states
 * P g. Sets inverse shape tensor and weight, too. */
static void pdi_finite_strain_compute_bond_vectors(const pd_finite_strain *f, int32_t i)
{
    double mean[PDI_TENSOR], at[PD_DIM], back[PD_DIM];
    const double *shape = f->shape + (int64_t)i * PDI_TENSOR;
    pdi_finite_strain_bond bond;
    pdi_finite_strain_compute_family(f, i, mean);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        double *pull = f->force_state + pdi_body_bond_number(&b) * PD_DIM;
        int open = f->weight_sum[i] > 0.0 && pdi_finite_strain_get_bond(f, i, &b, &bond);
        for (int d = 0; d < PD_DIM; d++) pull[d] = 0.0;
        if (!open) continue;
        pdi_tensor_multiply_vector(shape, bond.xi, at);
        pdi_tensor_multiply_vector(mean, at, back);
        for (int d = 0; d < PD_DIM; d++)
            pull[d] = bond.w * (pdi_finite_strain_bond_gradients(f)
                                    ? bond.xi[d] * bond.inv_r2 / f->weight_sum[i] + at[d] - back[d]
                                    : at[d]);
    }
}

/* Force density [N/m3] on point i from the force states of its family and of those of its neighbours. */
static void pdi_finite_strain_sum_force(const pd_finite_strain *f, int32_t i, double *force)
{
    const pd_body *body = f->body;
    for (int d = 0; d < PD_DIM; d++) force[d] = 0.0;
    for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
        int64_t k = pdi_body_bond_number(&b);
        const double *own = f->force_state + k * PD_DIM,
                     *other = f->force_state + (body->first_bond[b.neighbour] + f->reverse_bond[k]) * PD_DIM;
        for (int d = 0; d < PD_DIM; d++) force[d] += body->volume[b.neighbour] * (own[d] - other[d]);
    }
}

/* The same of the first `count` points: all, or those that are no mirror images; other entries of force stay. */
static void pdi_finite_strain_sum_forces(const pd_ctx *ctx, const pd_finite_strain *f, int32_t count, double *force)
{
    int nt = pd_par_threads(ctx, f->body->bonds * 10);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < count; i++) pdi_finite_strain_sum_force(f, i, force + (int64_t)i * PD_DIM);
}

/* Tensors and bond vectors of all families; force_state holds the vectors. Returns the first point with a singular
 * shape tensor, with detach_singular the first one that has intact bonds, too; -1: none. */
static int32_t pdi_finite_strain_compute_families(const pd_ctx *ctx, const pd_finite_strain *f)
{
    int nt = pd_par_threads(ctx, f->body->bonds * 60);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < f->body->count; i++) pdi_finite_strain_compute_bond_vectors(f, i);
    for (int32_t i = 0; i < f->body->count; i++)
        if (!(f->weight_sum[i] > 0.0) && (!f->desc.detach_singular || pdi_body_bonds_count_intact(f->body, i)))
            return i;
    return -1;
}

/* pd_material_interface.update: families and surface vectors, after bonds or stiffness factors have changed. Points
 * with a singular shape tensor lose their bonds, which detached_bonds counts (detach_singular), or are PD_ERR_GEOMETRY.
 * PD_ERR_ARGUMENT: a factor out of range. */
static pd_status pdi_finite_strain_ops_update(pd_ctx *ctx, void *self)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    const pd_body *body = f->body;
    f->tangent_valid = 0;
    for (int32_t i = 0; i < body->count; i++)
        if (!(pdi_finite_strain_stiffness_factor(f, i) >= (f->desc.detach_singular ? 0.0 : 1e-100)) ||
            !(pdi_finite_strain_stiffness_factor(f, i) < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain",
                           "the stiffness of point %d has the factor %g, expected a "
                           "finite positive one%s",
                           (int)i, pdi_finite_strain_stiffness_factor(f, i), f->desc.detach_singular ? ", or 0" : "");
    int32_t flat = pdi_finite_strain_compute_families(ctx, f);
    while (flat >= 0 && f->desc.detach_singular) {
        for (int32_t i = flat; i < body->count; i++)
            if (!(f->weight_sum[i] > 0.0)) f->detached_bonds += pdi_body_bonds_break_all(f->body, i);
        flat = pdi_finite_strain_compute_families(ctx, f);
    }
    if (flat >= 0)
        return pd_fail(ctx, PD_ERR_GEOMETRY, "finite_strain",
                       "the %.0f bonds of point %d at x = %g m do not span all directions: the body is too thin there "
                       "for its horizon",
                       (double)pdi_body_bonds_count_intact(body, flat), (int)flat,
                       body->position[(int64_t)flat * PD_DIM]);
    pdi_finite_strain_sum_forces(ctx, f, body->count, f->surface_vector);
    return PD_OK;
}

/* Penalty stiffness [Pa/m^(d+2)] of Silling 2017: a bond-based solid of the same bulk modulus K has the micromodulus c
 * = 2 K/d^2, 12 K/(pi d^3), 18 K/(pi d^4) in 1D, 2D, 3D; here `penalty` times that over the horizon d. 0 but for
 * PD_FINITE_STRAIN_SILLING. */
static double pdi_finite_strain_penalty_stiffness(const pd_finite_strain *f)
{
    static const double share[3] = {2.0, 12.0 / PD_PI, 18.0 / PD_PI};
    if (f->desc.control != PD_FINITE_STRAIN_SILLING) return 0.0;
    return f->desc.penalty * share[PD_DIM - 1] * (f->lambda + 2.0 * f->mu / PD_DIM) / pow(f->body->horizon, PD_DIM + 2);
}

/* Inner part of the build; after an error the caller frees. */
static pd_status pdi_finite_strain_build_inner(pd_ctx *ctx, pd_body *body, const pd_finite_strain_desc *desc,
                                               pd_finite_strain *f)
{
    pdi_constitutive_law_params moduli;
    memset(f, 0, sizeof *f);
    PD_TRY(pdi_constitutive_law_init(ctx, &desc->law, &moduli));
    if ((int)desc->control < 0 || (int)desc->control > 2 || (int)desc->law.kind < 0 || (int)desc->law.kind > 2)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain", "control %d of law %d, expected ones of 0 to 2",
                       (int)desc->control, (int)desc->law.kind);
    if (desc->control == PD_FINITE_STRAIN_SILLING && (!(desc->penalty > 0.0) || !(desc->penalty < 1e100)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain", "penalty %g, expected a finite positive one",
                       desc->penalty);
    f->desc = *desc;
    f->body = body;
    f->lambda = pdi_constitutive_law_plane_lambda(&moduli);
    f->mu = moduli.mu;
    f->penalty_stiffness = pdi_finite_strain_penalty_stiffness(f);
    PD_TRY(pdi_array_registry_build(ctx, pdi_finite_strain_list, f));
    pdi_body_bonds_mark_influential(body, f->influential);
    PD_TRY(pdi_bond_weights_build(ctx, body, &f->weights));
    PD_TRY(pdi_bond_weights_compute_influence(ctx, &f->weights, desc->influence));
    pdi_finite_strain_find_reverse_bonds(ctx, f);
    return pdi_finite_strain_ops_update(ctx, f);
}

pd_status pd_finite_strain_build(pd_ctx *ctx, pd_body *body, const pd_finite_strain_desc *desc, pd_finite_strain *f)
{
    pd_status status = pdi_finite_strain_build_inner(ctx, body, desc, f);
    if (status < 0) pd_finite_strain_free(ctx, f);
    return status;
}

void pd_finite_strain_free(pd_ctx *ctx, pd_finite_strain *f)
{
    pdi_bond_weights_free(ctx, &f->weights);
    pdi_array_registry_free(ctx, pdi_finite_strain_list, f);
    memset(f, 0, sizeof *f);
}

/* ---- gradients ---- */

/* eta = u_j - u_i [m]. */
static inline void pdi_finite_strain_relative_displacement(const double *u, int32_t i, int32_t j, double *eta)
{
    const double *from = u + (int64_t)i * PD_DIM, *to = u + (int64_t)j * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) eta[d] = to[d] - from[d];
}

/* Displacement gradient h = F - 1 [PD_DIM^2] of point i at u. */
static void pdi_finite_strain_compute_gradient(const pd_finite_strain *f, const double *u, int32_t i, double *h)
{
    double sum[PDI_TENSOR] = {0.0}, eta[PD_DIM];
    pdi_finite_strain_bond bond;
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        pdi_finite_strain_relative_displacement(u, i, b.neighbour, eta);
        for (int p = 0; p < PDI_TENSOR; p++) sum[p] += bond.weight * eta[p / PD_DIM] * bond.xi[p % PD_DIM];
    }
    pdi_tensor_multiply(sum, f->shape + (int64_t)i * PDI_TENSOR, h);
}

/* Non-uniform part of the displacement of the bond from point i to j: z = eta - h xi [m]. */
static inline void pdi_finite_strain_compute_nonuniform(const double *u, const double *h, int32_t i, int32_t j,
                                                        const pdi_finite_strain_bond *bond, double *z)
{
    double along[PD_DIM];
    pdi_finite_strain_relative_displacement(u, i, j, z);
    pdi_tensor_multiply_vector(h, bond->xi, along);
    for (int d = 0; d < PD_DIM; d++) z[d] -= along[d];
}

/* Displacement gradient of that bond alone: own = h + z xi^T/r^2. */
static inline void pdi_finite_strain_compute_bond_gradient(const double *u, const double *h, int32_t i, int32_t j,
                                                           const pdi_finite_strain_bond *bond, double *own)
{
    double z[PD_DIM];
    pdi_finite_strain_compute_nonuniform(u, h, i, j, bond, z);
    for (int p = 0; p < PDI_TENSOR; p++) own[p] = h[p] + z[p / PD_DIM] * bond->xi[p % PD_DIM] * bond->inv_r2;
}

/* f = 1 + h. */
static inline void pdi_finite_strain_add_identity(const double *h, double *f)
{
    for (int p = 0; p < PDI_TENSOR; p++) f[p] = h[p] + (p % (PD_DIM + 1) == 0 ? 1.0 : 0.0);
}

/* ---- forces and their derivative ---- */

/* Derivative p of the first Piola-Kirchhoff stress of a site (bond or point) with the gradient `full` along df. With
 * desc.store_tangent the moduli are stored, or those stored are used where tangent_valid is 1. */
static inline void pdi_finite_strain_apply_moduli(const pd_finite_strain *f, const pdi_constitutive_law_params *m,
                                                  int64_t site, const double *full, const double *df, double *p)
{
    if (!f->desc.store_tangent) {
        pdi_constitutive_law_apply_tangent(m, full, pdi_finite_strain_get_state(f, site), df, p);
        return;
    }
    double *kept = f->moduli + site * PDI_CONSTITUTIVE_LAW_TANGENT;
    if (!f->tangent_valid) pdi_constitutive_law_compute_tangent(m, full, pdi_finite_strain_get_state(f, site), kept);
    for (int k = 0; k < PDI_TENSOR; k++) p[k] = 0.0;
    for (int row = 0; row < PDI_TENSOR; row++) {
        double sum = *kept++ * df[row];
        for (int q = row + 1; q < PDI_TENSOR; q++) {
            sum += *kept * df[q];
            p[q] += *kept++ * df[row];
        }
        p[row] += sum;
    }
}

/* Force states of the bonds of point i with bond gradients, at the displacements f->u, or their derivative along du
 * unless it is NULL, into force_state. f->gradient is that of f->u. Returns 1; 0: a bond is inverted (det F <= 0). */
static int pdi_finite_strain_compute_bond_states(const pd_finite_strain *f, const pdi_constitutive_law_params *m,
                                                 const double *du, int32_t i)
{
    const double *h = f->gradient + (int64_t)i * PDI_TENSOR;
    double dh[PDI_TENSOR], full[PDI_TENSOR], change[PDI_TENSOR], p[PDI_TENSOR], part[PDI_TENSOR];
    double moment[PDI_TENSOR] = {0.0}, stiffness = pdi_finite_strain_stiffness_factor(f, i), along[PD_DIM];
    pdi_finite_strain_bond bond;
    if (du) pdi_finite_strain_compute_gradient(f, du, i, dh);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        double *pull = f->force_state + pdi_body_bond_number(&b) * PD_DIM;
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        pdi_finite_strain_compute_bond_gradient(f->u, h, i, b.neighbour, &bond, part);
        pdi_finite_strain_add_identity(part, full);
        if (du) {
            pdi_finite_strain_compute_bond_gradient(du, dh, i, b.neighbour, &bond, change);
            pdi_finite_strain_apply_moduli(f, m, pdi_body_bond_number(&b), full, change, p);
        } else if (!pdi_constitutive_law_compute_stress(m, full,
                                                        pdi_finite_strain_get_state(f, pdi_body_bond_number(&b)), p)) {
            return 0;
        }
        pdi_tensor_multiply_vector(p, bond.xi, along);
        for (int d = 0; d < PD_DIM; d++) pull[d] = along[d] * bond.inv_r2 / f->weight_sum[i];
        bond.weight /= f->weight_sum[i];
        for (int k = 0; k < PDI_TENSOR; k++)
            moment[k] += bond.weight * (p[k] - along[k / PD_DIM] * bond.xi[k % PD_DIM] * bond.inv_r2);
    }
    pdi_tensor_multiply(moment, f->shape + (int64_t)i * PDI_TENSOR, part);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        double *pull = f->force_state + pdi_body_bond_number(&b) * PD_DIM;
        pdi_tensor_multiply_vector(part, bond.xi, along);
        for (int d = 0; d < PD_DIM; d++) pull[d] = stiffness * bond.w * (pull[d] + along[d]);
    }
    return 1;
}

/* The same with the gradient of the family for all bonds, and with the penalty of Silling. Returns 1; 0: the family is
 * inverted. */
static int pdi_finite_strain_compute_point_states(const pd_finite_strain *f, const pdi_constitutive_law_params *m,
                                                  const double *du, int32_t i)
{
    const double *h = f->gradient + (int64_t)i * PDI_TENSOR, *u = du ? du : f->u;
    double dh[PDI_TENSOR], full[PDI_TENSOR], p[PDI_TENSOR], part[PDI_TENSOR], along[PD_DIM], z[PD_DIM];
    pdi_finite_strain_bond bond;
    pdi_finite_strain_add_identity(h, full);
    if (du) {
        pdi_finite_strain_compute_gradient(f, du, i, dh);
        pdi_finite_strain_apply_moduli(f, m, i, full, dh, p);
    } else if (!pdi_constitutive_law_compute_stress(m, full, pdi_finite_strain_get_state(f, i), p)) {
        return 0;
    }
    pdi_tensor_multiply(p, f->shape + (int64_t)i * PDI_TENSOR, part);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        double *pull = f->force_state + pdi_body_bond_number(&b) * PD_DIM;
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        double share = pdi_finite_strain_stiffness_factor(f, i) * bond.w;
        pdi_tensor_multiply_vector(part, bond.xi, along);
        pdi_finite_strain_compute_nonuniform(u, du ? dh : h, i, b.neighbour, &bond, z);
        for (int d = 0; d < PD_DIM; d++) pull[d] = share * (along[d] + f->penalty_stiffness * z[d]);
    }
    return 1;
}

/* Force states of all influential families at f->u, whose gradients go into f->gradient (du NULL), or their derivative
 * along du, into force_state. Returns the first point whose family has det F <= 0 of a bond, with plain correspondence
 * of the point; -1: there is none. f->work is overwritten. */
static int32_t pdi_finite_strain_compute_states(const pd_ctx *ctx, const pd_finite_strain *f, const double *du)
{
    const pdi_constitutive_law_params m = pdi_finite_strain_get_law(f);
    int nt = pd_par_threads(ctx, f->body->bonds * PDI_FINITE_STRAIN_OPERATIONS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < f->body->count; i++) {
        f->work[i] = 0.0;
        if (!f->influential[i]) continue;
        if (!du) pdi_finite_strain_compute_gradient(f, f->u, i, f->gradient + (int64_t)i * PDI_TENSOR);
        int good = pdi_finite_strain_bond_gradients(f) ? pdi_finite_strain_compute_bond_states(f, &m, du, i)
                                                       : pdi_finite_strain_compute_point_states(f, &m, du, i);
        f->work[i] = good ? 0.0 : 1.0;
    }
    for (int32_t i = 0; i < f->body->count; i++)
        if (f->work[i] > 0.0) return i;
    return -1;
}

/* pd_material_interface.force of real points; entries of mirror images stay. Keeps u and its gradients for the tangent.
 * PD_RETRY: a family is inverted. */
static pd_status pdi_finite_strain_ops_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    f->tangent_valid = 0;
    memcpy(f->u, u, (size_t)f->body->count * PD_DIM * sizeof *u);
    int32_t folded = pdi_finite_strain_compute_states(ctx, f, NULL);
    if (folded >= 0)
        return pd_fail(ctx, PD_RETRY, "finite_strain", "the family of point %d at x = %g m is turned inside out",
                       (int)folded, f->body->position[(int64_t)folded * PD_DIM]);
    pdi_finite_strain_sum_forces(ctx, f, f->body->real_count, force);
    return PD_OK;
}

/* pd_material_interface.tangent; with store_tangent the first one after a force stores the moduli. force_state holds
 * the derivative afterwards. */
static void pdi_finite_strain_ops_tangent(const pd_ctx *ctx, void *self, const double *du, double *df)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    pdi_finite_strain_compute_states(ctx, f, du);
    f->tangent_valid = 1;
    pdi_finite_strain_sum_forces(ctx, f, f->body->real_count, df);
}

/* Adds factor (mu g^2 1 + (lambda + mu) g g^T) to a diagonal block. */
static void pdi_finite_strain_add_block(const pd_finite_strain *f, double factor, const double *g, double *block)
{
    double square = pdi_tensor_dot(g, g);
    for (int k = 0; k < PDI_TENSOR; k++)
        block[k] += factor * ((k % (PD_DIM + 1) == 0 ? f->mu * square : 0.0) +
                             (f->lambda + f->mu) * g[k / PD_DIM] * g[k % PD_DIM]);
}

/* pd_material_interface.blocks: those of small strains, whatever u is. Bond gradients: each bond adds the share of both
 * families, as if the other points did not move. Plain correspondence: K^-1 of the own family and of the neighbours,
 * and the penalty. Zero without bonds. */
static void pdi_finite_strain_ops_blocks(const pd_ctx *ctx, void *self, double *block)
{
    const pd_finite_strain *f = (const pd_finite_strain *)self;
    const pd_body *body = f->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double *a = block + (int64_t)i * PDI_TENSOR, here = pdi_finite_strain_stiffness_factor(f, i);
        double at[PD_DIM], all[PD_DIM] = {0.0};
        pdi_finite_strain_bond bond;
        for (int k = 0; k < PDI_TENSOR; k++) a[k] = 0.0;
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            int32_t j = b.neighbour;
            double there = pdi_finite_strain_stiffness_factor(f, j);
            if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
            double volumes = body->volume[i] * bond.weight;
            if (pdi_finite_strain_bond_gradients(f)) {
                double share = here / f->weight_sum[i] + there / f->weight_sum[j];
                pdi_finite_strain_add_block(f, volumes * bond.inv_r2 * bond.inv_r2 * share, bond.xi, a);
                continue;
            }
            for (int d = 0; d < PD_DIM; d++) all[d] += bond.weight * bond.xi[d];
            pdi_tensor_multiply_vector(f->shape + (int64_t)j * PDI_TENSOR, bond.xi, at);
            pdi_finite_strain_add_block(f, there * bond.w * body->volume[i] * volumes, at, a);
            for (int d = 0; d < PD_DIM; d++) a[d * (PD_DIM + 1)] += f->penalty_stiffness * volumes * (here + there);
        }
        pdi_tensor_multiply_vector(f->shape + (int64_t)i * PDI_TENSOR, all, at);
        pdi_finite_strain_add_block(f, here * body->volume[i], at, a);
    }
}

/* ---- energy, stress, state ---- */

/* Elastic energy density [Pa] of point i at u, without plastic work: weighted mean over its bonds, 0 without bonds;
 * with plain correspondence that of the gradient of the family (zero without bonds) and the penalty of Silling. Times
 * the stiffness factor. HUGE_VAL: det F <= 0, also where that factor is 0. */
static double pdi_finite_strain_energy_density(const pd_finite_strain *f, const pdi_constitutive_law_params *m,
                                               const double *u, int32_t i)
{
    double h[PDI_TENSOR], part[PDI_TENSOR], full[PDI_TENSOR], z[PD_DIM], sum = 0.0;
    pdi_finite_strain_bond bond;
    pdi_finite_strain_compute_gradient(f, u, i, h);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        if (pdi_finite_strain_bond_gradients(f)) {
            pdi_finite_strain_compute_bond_gradient(u, h, i, b.neighbour, &bond, part);
            pdi_finite_strain_add_identity(part, full);
            sum += bond.weight *
                   pdi_constitutive_law_compute_energy(m, full,
                                                       pdi_finite_strain_get_state(f, pdi_body_bond_number(&b)), 0) /
                   f->weight_sum[i];
        } else {
            pdi_finite_strain_compute_nonuniform(u, h, i, b.neighbour, &bond, z);
            sum += 0.5 * bond.weight * f->penalty_stiffness * pdi_tensor_dot(z, z);
        }
    }
    pdi_finite_strain_add_identity(h, full);
    if (!pdi_finite_strain_bond_gradients(f))
        sum += pdi_constitutive_law_compute_energy(m, full, pdi_finite_strain_get_state(f, i), 0);
    return sum < HUGE_VAL ? sum * pdi_finite_strain_stiffness_factor(f, i) : HUGE_VAL;
}

/* pd_material_interface.energy: sum over all points, mirror images too; HUGE_VAL where a bond is inverted. */
static double pdi_finite_strain_ops_energy(const pd_ctx *ctx, void *self, const double *u)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    const pdi_constitutive_law_params m = pdi_finite_strain_get_law(f);
    pdi_compensated_sum all = {0.0, 0.0};
    int nt = pd_par_threads(ctx, f->body->bonds * PDI_FINITE_STRAIN_OPERATIONS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < f->body->count; i++) f->work[i] = pdi_finite_strain_energy_density(f, &m, u, i);
    for (int32_t i = 0; i < f->body->count; i++) {
        if (!(f->work[i] < HUGE_VAL)) return HUGE_VAL;
        pdi_compensated_sum_add(&all, f->body->volume[i] * f->work[i]);
    }
    return pdi_compensated_sum_total(&all);
}

/* Mean Cauchy stress [PD_DIM^2] [Pa] of the bonds of point i at u; in 2D its out-of-plane stress, too. NaN: one of them
 * is inverted. stress NULL: commits their plastic states instead, and their plastic work density [J/m3] goes into
 * f->work. */
static void pdi_finite_strain_visit_point(const pd_finite_strain *f, const pdi_constitutive_law_params *m,
                                          const double *u, int32_t i, double *stress)
{
    double h[PDI_TENSOR], part[PDI_TENSOR], full[PDI_TENSOR], sum[PDI_TENSOR] = {0.0};
    double single = 1.0, normal, all = 0.0;
    pdi_finite_strain_bond bond;
    pdi_finite_strain_compute_gradient(f, u, i, h);
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i); pd_body_bonds_next(&b);) {
        int64_t site = pdi_finite_strain_bond_gradients(f) ? pdi_body_bond_number(&b) : i;
        if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
        memcpy(part, h, sizeof part);
        if (pdi_finite_strain_bond_gradients(f)) {
            pdi_finite_strain_compute_bond_gradient(u, h, i, b.neighbour, &bond, part);
            single = bond.weight / f->weight_sum[i];
        }
        pdi_finite_strain_add_identity(part, full);
        if (!stress) {
            all += single * pdi_constitutive_law_commit(m, full, pdi_finite_strain_get_state(f, site));
        } else {
            int good =
                pdi_constitutive_law_compute_cauchy(m, full, pdi_finite_strain_get_state(f, site), part, &normal);
            for (int k = 0; k < PDI_TENSOR; k++) sum[k] += good ? single * part[k] : (double)NAN;
            all += good ? single * normal : (double)NAN;
        }
        if (!pdi_finite_strain_bond_gradients(f)) break;
    }
    for (int k = 0; stress && k < PDI_TENSOR; k++) stress[k] = sum[k] * pdi_finite_strain_stiffness_factor(f, i);
    if (!stress) f->work[i] = all * pdi_finite_strain_stiffness_factor(f, i);
    else if (f->out_of_plane_stress) f->out_of_plane_stress[i] = all * pdi_finite_strain_stiffness_factor(f, i);
}

/* The same for all points; stress [count][PD_DIM^2] or NULL. */
static void pdi_finite_strain_visit_all(const pd_ctx *ctx, const pd_finite_strain *f, const double *u, double *stress)
{
    const pdi_constitutive_law_params m = pdi_finite_strain_get_law(f);
    int nt = pd_par_threads(ctx, f->body->bonds * PDI_FINITE_STRAIN_OPERATIONS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < f->body->count; i++)
        pdi_finite_strain_visit_point(f, &m, u, i, stress ? stress + (int64_t)i * PDI_TENSOR : NULL);
}

/* pd_material_interface.stress. */
static void pdi_finite_strain_ops_stress(const pd_ctx *ctx, void *self, const double *u, double *stress)
{
    pdi_finite_strain_visit_all(ctx, (const pd_finite_strain *)self, u, stress);
}

/* pd_material_interface.commit: plastic states of the step to u, of all points with bonds; adds its plastic work [J] on
 * real points to plastic_work. Bonds with det F <= 0 stay. Stored tangents are no longer valid. */
static pd_status pdi_finite_strain_ops_commit(pd_ctx *ctx, void *self, const double *u)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    pdi_compensated_sum all = {f->plastic_work, 0.0};
    pdi_finite_strain_visit_all(ctx, f, u, NULL);
    for (int32_t i = 0; i < f->body->real_count; i++) pdi_compensated_sum_add(&all, f->body->volume[i] * f->work[i]);
    f->plastic_work = pdi_compensated_sum_total(&all);
    f->tangent_valid = 0;
    return PD_OK;
}

/* pd_material_interface.out_of_plane_stress: that of the last `stress`; the argument stress is not read. */
static double pdi_finite_strain_ops_normal_stress(const void *self, int32_t i, const double *stress)
{
    (void)stress;
    return ((const pd_finite_strain *)self)->out_of_plane_stress[i];
}

/* pd_material_interface.dissipated. */
static double pdi_finite_strain_ops_dissipated(const void *self)
{
    return ((const pd_finite_strain *)self)->plastic_work;
}

/* pd_material_interface.store: plastic states, plastic work and broken bonds; after reading the material is updated. */
static pd_status pdi_finite_strain_ops_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    PD_TRY(pdi_array_registry_store(ctx, pdi_finite_strain_list, f, archive));
    PD_TRY(pdi_array_registry_store(ctx, pdi_body_list_state, f->body, archive));
    return archive->is_reading ? pdi_finite_strain_ops_update(ctx, f) : PD_OK;
}

/* pd_material_interface.density: of all points; HUGE_VAL where a bond of the point is inverted. */
static void pdi_finite_strain_ops_density(const pd_ctx *ctx, void *self, const double *u, double *density)
{
    pd_finite_strain *f = (pd_finite_strain *)self;
    const pdi_constitutive_law_params m = pdi_finite_strain_get_law(f);
    int nt = pd_par_threads(ctx, f->body->bonds * PDI_FINITE_STRAIN_OPERATIONS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < f->body->count; i++) density[i] = pdi_finite_strain_energy_density(f, &m, u, i);
}

/* pd_material_interface.moduli: Lame's moduli of small strains. */
static void pdi_finite_strain_ops_moduli(const pd_ctx *ctx, void *self, double *lambda, double *mu)
{
    const pd_finite_strain *f = (const pd_finite_strain *)self;
    (void)ctx;
    for (int32_t i = 0; i < f->body->count; i++) {
        lambda[i] = pdi_finite_strain_stiffness_factor(f, i) * f->lambda;
        mu[i] = pdi_finite_strain_stiffness_factor(f, i) * f->mu;
    }
}

void pd_finite_strain_plastic_strain(const pd_ctx *ctx, const pd_finite_strain *f, double *strain)
{
    (void)ctx;
    for (int32_t i = 0; i < f->body->count; i++) {
        pdi_finite_strain_bond bond;
        double *state = f->desc.law.kind == PD_FINITE_STRAIN_J2 && !pdi_finite_strain_bond_gradients(f)
                            ? pdi_finite_strain_get_state(f, i)
                            : NULL;
        strain[i] = state ? state[PDI_CONSTITUTIVE_LAW_STATE - 1] : 0.0;
        for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i);
             pdi_finite_strain_bond_gradients(f) && f->state && pd_body_bonds_next(&b);)
            if (pdi_finite_strain_get_bond(f, i, &b, &bond))
                strain[i] += bond.weight / f->weight_sum[i] *
                             pdi_finite_strain_get_state(f, pdi_body_bond_number(&b))[PDI_CONSTITUTIVE_LAW_STATE - 1];
    }
}

/* pd_material_interface.plastic_strain. */
static void pdi_finite_strain_ops_plastic_strain(const pd_ctx *ctx, const void *self, double *strain)
{
    pd_finite_strain_plastic_strain(ctx, (const pd_finite_strain *)self, strain);
}

/* Upper bound of the largest eigenvalue of (1 - mean of n n^T) K^-1 of point i [1/m^(d+2)], by the trace of its eighth
 * power; with plain correspondence of K^-1. 0 without bonds. */
static double pdi_finite_strain_max_eigenvalue(const pd_finite_strain *f, int32_t i)
{
    const double *shape = f->shape + (int64_t)i * PDI_TENSOR;
    double across[PDI_TENSOR] = {0.0}, power[PDI_TENSOR], square[PDI_TENSOR], trace = 0.0, size = 0.0;
    pdi_finite_strain_bond bond;
    if (!(f->weight_sum[i] > 0.0)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) across[d * (PD_DIM + 1)] = 1.0;
    for (pd_bond_iterator b = pd_body_bonds_begin(f->body, i);
         pdi_finite_strain_bond_gradients(f) && pd_body_bonds_next(&b);)
        if (pdi_finite_strain_get_bond(f, i, &b, &bond))
            for (int k = 0; k < PDI_TENSOR; k++)
                across[k] -= bond.weight / f->weight_sum[i] * bond.xi[k / PD_DIM] * bond.xi[k % PD_DIM] * bond.inv_r2;
    pdi_tensor_multiply(across, shape, power);
    for (int d = 0; d < PD_DIM; d++) size = pd_max(size, shape[d * (PD_DIM + 1)]);
    for (int k = 0; k < PDI_TENSOR; k++) power[k] /= size;
    for (int round = 0; round < 3; round++) {
        pdi_tensor_multiply(power, power, square);
        memcpy(power, square, sizeof power);
    }
    for (int d = 0; d < PD_DIM; d++) trace += power[d * (PD_DIM + 1)];
    return size * pow(pd_max(trace, 0.0), 0.125);
}

/* pd_material_interface.stable_step: a bond stores no more energy than a spring of stiffness M w V_i V_j (1/(w_i r^2) +
 * k_i), k from the eigenvalue above, and the same of its other end, with the largest modulus M (theory: eq. 14.13). */
static double pdi_finite_strain_ops_stable_step(const void *self, double density)
{
    const pd_finite_strain *f = (const pd_finite_strain *)self;
    const pd_body *body = f->body;
    double modulus = pd_max(2.0 * f->mu, PD_DIM * f->lambda + 2.0 * f->mu), stiffest = 0.0;
    for (int32_t i = 0; i < body->count; i++) f->work[i] = modulus * pdi_finite_strain_max_eigenvalue(f, i);
    for (int32_t i = 0; i < body->count; i++) {
        pdi_finite_strain_bond bond;
        double sum = 0.0;
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            if (!pdi_finite_strain_get_bond(f, i, &b, &bond)) continue;
            for (int end = 0; end < 2; end++) {
                int32_t k = end ? b.neighbour : i;
                double size = pdi_finite_strain_bond_gradients(f)
                                  ? f->work[k] + modulus * bond.inv_r2 / f->weight_sum[k]
                                  : pd_max(f->work[k], f->penalty_stiffness);
                sum += bond.weight * pdi_finite_strain_stiffness_factor(f, k) * size;
            }
        }
        stiffest = pd_max(stiffest, sum);
    }
    return sqrt(2.0 * density / stiffest);
}

pd_material_interface pd_finite_strain_material(pd_finite_strain *f)
{
    pd_material_interface s;
    memset(&s, 0, sizeof s);
    s.name = "finite";
    s.self = f;
    s.body = f->body;
    s.surface_vector = f->surface_vector;
    s.gradient_based = 1;
    s.force = pdi_finite_strain_ops_force;
    s.tangent = pdi_finite_strain_ops_tangent;
    s.blocks = pdi_finite_strain_ops_blocks;
    s.moduli = pdi_finite_strain_ops_moduli;
    s.energy = pdi_finite_strain_ops_energy;
    s.density = pdi_finite_strain_ops_density;
    s.stress = pdi_finite_strain_ops_stress;
    s.update = pdi_finite_strain_ops_update;
    if (PD_DIM == 2) s.out_of_plane_stress = pdi_finite_strain_ops_normal_stress;
    if (f->desc.law.kind == PD_FINITE_STRAIN_J2) {
        s.dissipated = pdi_finite_strain_ops_dissipated;
        s.plastic_strain = pdi_finite_strain_ops_plastic_strain;
        s.commit = pdi_finite_strain_ops_commit;
    }
    s.stable_step = pdi_finite_strain_ops_stable_step;
    s.store = pdi_finite_strain_ops_store;
    return s;
}

#undef PDI_FINITE_STRAIN_MIN_PIVOT
#undef PDI_FINITE_STRAIN_OPERATIONS
