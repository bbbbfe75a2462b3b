/* ordinary_state: see ordinary_state.h */
#include "solid/ordinary_state.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "solid/bond_extension.h"
#include "solid/mandel.h"
#include "solid/weight_calibration.h"
#include <math.h>
#include <string.h>

/* Family whose bonds do not determine all strains: smallest pivot of the normalised moment sum w V r^2 (n n)(n n)/m. */
#define PDI_ORDINARY_STATE_MIN_PIVOT 1e-6
/* Matrix squarings in the bound of the largest eigenvalue: within 3 % in 3D. */
#define PDI_ORDINARY_STATE_SQUARINGS 6

/* Kinematics of a bond. */
typedef struct pdi_ordinary_state_bond {
    double w;          /* [-] w */
    double weight;     /* [m^d] w V_j */
    double r, length;  /* [m] as it began, and now; r where displacements are small */
    double extension;  /* [m] length - r, with the digits of the displacements */
    double xi[PD_DIM]; /* [m] */
    double y[PD_DIM];  /* [-] direction of its force */
    double dyad[PDI_SYM_COMPONENTS]; /* [m2] xi xi^T */
} pdi_ordinary_state_bond;

/* Kinematics of the current bond of point i at u; linear 1: of small displacements, 0: of any size. Returns 1; 0: it is
 * broken, and bond holds nothing but w = 0. */
static inline int pdi_ordinary_state_get_bond(const pd_ordinary_state *o, int linear, const double *u, int32_t i,
                                              const pd_bond_iterator *f, pdi_ordinary_state_bond *bond)
{
    const double *own = u + (int64_t)i * PD_DIM, *far = u + (int64_t)f->neighbour * PD_DIM;
    double eta[PD_DIM];
    bond->w = pdi_bond_weights_get_intact(&o->weights, i, f);
    if (!(bond->w > 0.0)) return 0;
    bond->weight = bond->w * o->body->volume[f->neighbour];
    pdi_body_bond_vector(o->body, i, f, bond->xi);
    for (int d = 0; d < PD_DIM; d++) eta[d] = far[d] - own[d];
    if (linear) {
        bond->length = bond->r = pdi_vec_norm(bond->xi);
        bond->extension = pdi_vec_dot(bond->xi, eta) / bond->r;
    } else {
        bond->extension = pdi_body_compute_stretch(bond->xi, eta, bond->y, &bond->r, &bond->length);
        bond->extension *= bond->r;
    }
    for (int d = 0; d < PD_DIM; d++) bond->y[d] = (linear ? bond->xi[d] : bond->y[d]) / bond->length;
    pdi_mandel_dyad(bond->xi, bond->dyad);
    return 1;
}

/* 1: the model fits a strain to each family (PD_ORDINARY_STATE_POSITION). */
static int pdi_ordinary_state_is_position_aware(const pd_ordinary_state *o)
{
    return o->desc.surface == PD_ORDINARY_STATE_POSITION;
}

/* Bond weights: isotropic for shear on a lattice (not position-aware, and not isotropic_off), and with the surface
 * correction; sets isotropy, bulk_weighted_volume and anisotropy, too: that is 1 where the model is position-aware or
 * in 1D, and 0 without a lattice. PD_ERR_ARGUMENT: a weight would not be positive. */
static pd_status pdi_ordinary_state_compute_weights(pd_ctx *ctx, pd_ordinary_state *o)
{
    int strain = pdi_ordinary_state_is_position_aware(o);
    pdi_weight_calibration weigh;
    memset(&weigh, 0, sizeof weigh);
    weigh.body = o->body;
    weigh.influence = o->desc.influence;
    if (o->desc.surface == PD_ORDINARY_STATE_ENERGY) weigh.correction = PDI_WEIGHT_CALIBRATION_ENERGY;
    if (o->desc.surface == PD_ORDINARY_STATE_VOLUME) weigh.correction = PDI_WEIGHT_CALIBRATION_VOLUME;
    PD_TRY(pdi_weight_calibration_calibrate(ctx, &weigh, !strain && !o->desc.isotropic_off));
    const pdi_weight_calibration_sums *whole = &weigh.whole;
    o->isotropy = weigh.anisotropy;
    o->bulk_weighted_volume = whole->weighted_volume;
    o->anisotropy = strain || PD_DIM == 1 ? 1.0 : 0.0;
    if (!(o->anisotropy > 0.0) && whole->axis > whole->cross)
        o->anisotropy = 2.0 * whole->cross / (whole->axis - whole->cross);
    return pdi_weight_calibration_compute_weights(ctx, &weigh, &o->weights);
}

/* ---- families ---- */

/* Upper bound of the largest eigenvalue of the n x n matrix a with real, non-negative eigenvalues: root of the trace of
 * its 64th power. 0: a trace is not positive. a is overwritten. */
static double pdi_ordinary_state_max_eigenvalue(int n, double *a)
{
    double least = 0.0, share = 1.0, next[PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS];
    for (int k = 0; k <= PDI_ORDINARY_STATE_SQUARINGS; k++, share *= 0.5) {
        double trace = 0.0;
        for (int p = 0; p < n; p++) trace += a[p * n + p];
        if (!(trace > 0.0)) return 0.0;
        least += share * log(trace);
        for (int p = 0; p < n * n; p++) {
            double sum = 0.0;
            for (int q = 0; q < n; q++) sum += a[p / n * n + q] * a[q * n + p % n];
            next[p] = sum / (trace * trace);
        }
        memcpy(a, next, (size_t)(n * n) * sizeof *a);
    }
    return exp(least);
}

/* Weighted volume m [m^(d+2)] of family i; for the position-aware model also the inverse of the fourth-order moment sum
 * w V_j r^2 (n n)(n n)/m [-], a full matrix between Mandel vectors; for the others `moment` is work. Returns 1; 0: no
 * bonds, or the moment is singular (position-aware). */
static int pdi_ordinary_state_compute_moment(const pd_ordinary_state *o, int32_t i, double *weighted_volume,
                                             double *moment)
{
    const pd_body *body = o->body;
    double least[PDI_SYM_COMPONENTS], dyad[PDI_SYM_COMPONENTS], inverse[PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS],
        xi[PD_DIM];
    memset(moment, 0, PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS * sizeof *moment);
    *weighted_volume = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double weight = pdi_bond_weights_get_intact(&o->weights, i, &f) * body->volume[f.neighbour];
        if (!(weight > 0.0)) continue;
        pdi_body_bond_vector(body, i, &f, xi);
        pdi_mandel_dyad(xi, dyad);
        double square = pdi_mandel_trace(dyad);
        *weighted_volume += weight * square;
        for (int p = 0; p < PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS; p++)
            moment[p] += weight * dyad[p / PDI_SYM_COMPONENTS] * dyad[p % PDI_SYM_COMPONENTS] / square;
    }
    if (!(*weighted_volume > 0.0)) return 0;
    if (!pdi_ordinary_state_is_position_aware(o)) return 1;
    for (int p = 0; p < PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS; p++) moment[p] /= *weighted_volume;
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++) least[p] = PDI_ORDINARY_STATE_MIN_PIVOT;
    if (!pdi_vec_cholesky(PDI_SYM_COMPONENTS, PDI_SYM_COMPONENTS, least, moment)) return 0;
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++) {
        double *row = inverse + p * PDI_SYM_COMPONENTS;
        for (int q = 0; q < PDI_SYM_COMPONENTS; q++) row[q] = p == q ? 1.0 : 0.0;
        pdi_vec_cholesky_solve(PDI_SYM_COMPONENTS, PDI_SYM_COMPONENTS, moment, row);
    }
    memcpy(moment, inverse, sizeof inverse);
    return 1;
}

/* Law of the position-aware family i: L = M^-1 (C M^-1 - alpha), with n = m M^-1, m: size [m^(d+2)] (theory: eq.
 * 14.16). Sets `law` and `energy_bound` of the point; alpha is set before. */
static void pdi_ordinary_state_compute_position_law(const pd_ordinary_state *o, int32_t i, double size, const double *n)
{
    double row[PDI_SYM_COMPONENTS], carried[PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS],
        *law = o->law + (int64_t)i * PDI_MANDEL_MATRIX_SIZE;
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++) row[p] = pdi_mandel_trace(n + p * PDI_SYM_COMPONENTS);
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++)
        for (int q = 0; q < PDI_SYM_COMPONENTS; q++) {
            double own = n[p * PDI_SYM_COMPONENTS + q];
            carried[p * PDI_SYM_COMPONENTS + q] = 2.0 * o->mu * own + (q < PD_DIM ? o->lambda * row[p] : 0.0);
            if (q > p) continue;
            double twice = pdi_mandel_dot(n + p * PDI_SYM_COMPONENTS, n + q * PDI_SYM_COMPONENTS);
            *law++ = (o->lambda * row[p] * row[q] + 2.0 * o->mu * twice - o->alpha[i] * size * own) / (size * size);
        }
    o->energy_bound[i] = pd_max(o->alpha[i], pdi_ordinary_state_max_eigenvalue(PDI_SYM_COMPONENTS, carried) / size);
}

/* Law L, alpha and energy bound of family i. Returns 1; 0: no law, as bonds do not determine all strains: L and alpha
 * are zero; -1: a strain has no energy. */
static int pdi_ordinary_state_compute_law(const pd_ordinary_state *o, int32_t i)
{
    double size, moment[PDI_SYM_COMPONENTS * PDI_SYM_COMPONENTS], *law = o->law + (int64_t)i * PDI_MANDEL_MATRIX_SIZE;
    memset(law, 0, PDI_MANDEL_MATRIX_SIZE * sizeof *law);
    o->alpha[i] = 0.0;
    if (!pdi_ordinary_state_compute_moment(o, i, &size, moment)) return 0;
    double whole = o->desc.surface == PD_ORDINARY_STATE_ENERGY || o->desc.surface == PD_ORDINARY_STATE_VOLUME
                       ? o->bulk_weighted_volume
                       : size;
    o->alpha[i] = PD_DIM * (PD_DIM + 2) * o->mu / whole;
    if (pdi_ordinary_state_is_position_aware(o)) {
        pdi_ordinary_state_compute_position_law(o, i, size, moment);
        return 1;
    }
    double bulk = o->lambda + 2.0 * o->mu / PD_DIM, l = PD_DIM * PD_DIM * bulk / (whole * whole) - o->alpha[i] / whole;
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++)
        for (int q = 0; q <= p; q++) *law++ = p < PD_DIM && q < PD_DIM ? l : 0.0;
    o->energy_bound[i] = o->alpha[i] + pd_max(l, 0.0) * size;
    return o->alpha[i] + l * size > 0.0 ? 1 : -1;
}

/* Upper bound [Pa/m2] of density times the squared angular frequency, from the unbroken bonds of point i and the energy
 * bounds of both ends (theory: 14.5); 0 without bonds. */
static double pdi_ordinary_state_frequency_bound(const pd_ordinary_state *o, int32_t i)
{
    const pd_body *body = o->body;
    double sum[PD_DIM * PD_DIM] = {0.0}, xi[PD_DIM];
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double weight = pdi_bond_weights_get_intact(&o->weights, i, &f) * body->volume[f.neighbour];
        pdi_body_bond_vector(body, i, &f, xi);
        double share = 2.0 * weight * (o->energy_bound[i] + o->energy_bound[f.neighbour]) / pdi_vec_dot(xi, xi);
        for (int p = 0; p < PD_DIM * PD_DIM; p++) sum[p] += share * xi[p / PD_DIM] * xi[p % PD_DIM];
    }
    return pdi_ordinary_state_max_eigenvalue(PD_DIM, sum);
}

/* ---- forces ---- */

/* Q = L sum w V_j x r n n of point i, into `to`; x: extensions at u, or their derivative along du unless it is NULL. */
static void pdi_ordinary_state_compute_state(const pd_ordinary_state *o, int linear, const double *u, const double *du,
                                             int32_t i, double *to)
{
    pdi_ordinary_state_bond bond;
    double sum[PDI_SYM_COMPONENTS] = {0.0};
    for (pd_bond_iterator f = pd_body_bonds_begin(o->body, i); pd_body_bonds_next(&f);) {
        if (!pdi_ordinary_state_get_bond(o, linear, u, i, &f, &bond)) continue;
        double x = bond.extension;
        if (du) {
            const double *own = du + (int64_t)i * PD_DIM, *far = du + (int64_t)f.neighbour * PD_DIM;
            x = 0.0;
            for (int d = 0; d < PD_DIM; d++) x += bond.y[d] * (far[d] - own[d]);
        }
        for (int p = 0; p < PDI_SYM_COMPONENTS; p++) sum[p] += bond.weight * x / bond.r * bond.dyad[p];
    }
    pdi_mandel_multiply(o->law + (int64_t)i * PDI_MANDEL_MATRIX_SIZE, sum, to);
}

/* Scalar force state of a bond over w by the family of point i with tensor q, at the extension x. */
static inline double pdi_ordinary_state_family_force(const pd_ordinary_state *o, const pdi_ordinary_state_bond *bond,
                                                     int32_t i, const double *q, double x)
{
    return pdi_mandel_dot(bond->dyad, q) / bond->r + o->alpha[i] * x;
}

/* Scalar force state over w by both families of a bond; q [count][tensor]. */
static inline double pdi_ordinary_state_bond_force(const pd_ordinary_state *o, const pdi_ordinary_state_bond *bond,
                                                   int32_t i, int32_t j, const double *q, double x)
{
    return pdi_ordinary_state_family_force(o, bond, i, q + (int64_t)i * PDI_SYM_COMPONENTS, x) +
           pdi_ordinary_state_family_force(o, bond, j, q + (int64_t)j * PDI_SYM_COMPONENTS, x);
}

/* Sets the forces on mirror images to zero. */
static void pdi_ordinary_state_clear_images(const pd_body *body, double *force)
{
    memset(force + (int64_t)body->real_count * PD_DIM, 0,
           (size_t)(body->count - body->real_count) * PD_DIM * sizeof *force);
}

/* Tensors Q of batch k into state [count][tensor] and into the fields of the batches, and the energy densities [J/m3]
 * of its points into energy [PD_POINT_BATCH_MAX], or NULL. Displacements are those set in the batches. Returns how many
 * points. */
static int32_t pdi_ordinary_state_compute_batch(const pd_ordinary_state *o, int32_t k, int linear, double *state,
                                                double *energy)
{
    double shape[PDI_SYM_COMPONENTS][PD_POINT_BATCH_MAX];
    int32_t count = pdi_bond_extension_compute_moment(&o->band, k, linear, shape, energy);
    for (int32_t n = 0; n < count; n++) {
        int64_t i = o->band.first[k] + n;
        double sum[PDI_SYM_COMPONENTS], *q = state + i * PDI_SYM_COMPONENTS;
        for (int p = 0; p < PDI_SYM_COMPONENTS; p++) sum[p] = shape[p][n];
        pdi_mandel_multiply(o->law + i * PDI_MANDEL_MATRIX_SIZE, sum, q);
        pdi_bond_extension_set_fields(&o->band, (int32_t)i, o->alpha[i], q);
        if (energy) energy[n] = 0.5 * (o->alpha[i] * energy[n] + pdi_mandel_dot(sum, q));
    }
    return count;
}

/* Forces [N/m3] at the displacements u, of any size or small (linear 1), zero on mirror images; state [count][tensor]:
 * out: tensors Q, as of pd_ordinary_state. */
static void pdi_ordinary_state_compute_force(const pd_ctx *ctx, const pd_ordinary_state *o, int linear, const double *u,
                                             double *state, double *force)
{
    const pd_body *body = o->body;
    const pd_point_batch *band = &o->band;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < band->batches; k++) pdi_ordinary_state_compute_batch(o, k, linear, state, NULL);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < band->batches; k++)
        if (band->first[k] < body->real_count) pdi_bond_extension_compute_force(band, k, linear, force);
    pdi_ordinary_state_clear_images(body, force);
}

/* pd_material_interface.force; keeps u and Q for the tangent. PD_RETRY: a bond has no length. */
static pd_status pdi_ordinary_state_ops_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    int64_t n = (int64_t)o->body->count * PD_DIM;
    pdi_par_copy(ctx, n, u, o->last_u);
    pdi_ordinary_state_compute_force(ctx, o, o->desc.linear, u, o->state, force);
    return pdi_par_max_abs(ctx, n, force) < HUGE_VAL ? PD_OK : PD_RETRY;
}

/* Directional derivative df of the forces along du at last_u, of any size, with the geometric stiffness; zero on mirror
 * images. `change` is overwritten. */
static void pdi_ordinary_state_compute_tangent(const pd_ctx *ctx, const pd_ordinary_state *o, const double *du,
                                               double *df)
{
    const pd_body *body = o->body;
    int nt = pd_par_threads(ctx, body->bonds * 80);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++)
        if (o->influential[i])
            pdi_ordinary_state_compute_state(o, 0, o->last_u, du, i, o->change + (int64_t)i * PDI_SYM_COMPONENTS);
    pdi_ordinary_state_clear_images(body, df);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->real_count; i++) {
        pdi_ordinary_state_bond bond;
        double sum[PD_DIM] = {0.0}, eta[PD_DIM];
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            int32_t j = f.neighbour;
            if (!pdi_ordinary_state_get_bond(o, 0, o->last_u, i, &f, &bond)) continue;
            for (int d = 0; d < PD_DIM; d++) eta[d] = du[(int64_t)j * PD_DIM + d] - du[(int64_t)i * PD_DIM + d];
            double along = pdi_vec_dot(bond.y, eta);
            double t = pdi_ordinary_state_bond_force(o, &bond, i, j, o->change, along);
            double turn = pdi_ordinary_state_bond_force(o, &bond, i, j, o->state, bond.extension) / bond.length;
            for (int d = 0; d < PD_DIM; d++)
                sum[d] += bond.weight * (t * bond.y[d] + turn * (eta[d] - along * bond.y[d]));
        }
        for (int d = 0; d < PD_DIM; d++) df[(int64_t)i * PD_DIM + d] = sum[d];
    }
}

/* pd_material_interface.tangent at the displacements of the last force; linear: the forces of du. `change` is
 * overwritten. */
static void pdi_ordinary_state_ops_tangent(const pd_ctx *ctx, void *self, const double *du, double *df)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    if (o->desc.linear) pdi_ordinary_state_compute_force(ctx, o, 1, du, o->change, df);
    else pdi_ordinary_state_compute_tangent(ctx, o, du, df);
}

/* Diagonal block [N/m] of point i: exact but for the negative geometric stiffness of compressed bonds, which is left
 * out. */
static void pdi_ordinary_state_compute_block(const pd_ordinary_state *o, int32_t i, double *block)
{
    const pd_body *body = o->body;
    double own[PD_DIM][PDI_SYM_COMPONENTS], carried[PDI_SYM_COMPONENTS];
    pdi_ordinary_state_bond bond;
    memset(own, 0, sizeof own);
    memset(block, 0, PD_DIM * PD_DIM * sizeof *block);
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        int32_t j = f.neighbour;
        if (!pdi_ordinary_state_get_bond(o, o->desc.linear, o->last_u, i, &f, &bond)) continue;
        pdi_mandel_multiply(o->law + (int64_t)j * PDI_MANDEL_MATRIX_SIZE, bond.dyad, carried);
        double back = bond.w * body->volume[i] * pdi_mandel_dot(carried, bond.dyad) / (bond.r * bond.r);
        double along = bond.weight * (back + o->alpha[i] + o->alpha[j]), turn = 0.0;
        if (!o->desc.linear)
            turn = pd_max(0.0, bond.weight * pdi_ordinary_state_bond_force(o, &bond, i, j, o->state, bond.extension) /
                                    bond.length);
        for (int p = 0; p < PD_DIM; p++) {
            for (int k = 0; k < PDI_SYM_COMPONENTS; k++) own[p][k] += bond.weight * bond.dyad[k] * bond.y[p] / bond.r;
            for (int q = 0; q < PD_DIM; q++)
                block[p * PD_DIM + q] += (along - turn) * bond.y[p] * bond.y[q] + (p == q ? turn : 0.0);
        }
    }
    for (int p = 0; p < PD_DIM; p++) {
        pdi_mandel_multiply(o->law + (int64_t)i * PDI_MANDEL_MATRIX_SIZE, own[p], carried);
        for (int q = 0; q < PD_DIM; q++) block[p * PD_DIM + q] += pdi_mandel_dot(carried, own[q]);
    }
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q <= p; q++) { /* the same bits on both sides */
            double mean = 0.5 * body->volume[i] * (block[p * PD_DIM + q] + block[q * PD_DIM + p]);
            block[p * PD_DIM + q] = mean;
            block[q * PD_DIM + p] = mean;
        }
}

/* pd_material_interface.blocks. */
static void pdi_ordinary_state_ops_blocks(const pd_ctx *ctx, void *self, double *block)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    int nt = pd_par_threads(ctx, o->body->bonds * 80);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < o->body->count; i++)
        pdi_ordinary_state_compute_block(o, i, block + (int64_t)i * PD_DIM * PD_DIM);
}

/* ---- energy and stress ---- */

/* pd_material_interface.density: of all points, mirror images too. `change` is overwritten. */
static void pdi_ordinary_state_ops_density(const pd_ctx *ctx, void *self, const double *u, double *density)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    int nt = pd_par_threads(ctx, o->body->bonds * 10);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &o->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < o->band.batches; k++) {
        double energy[PD_POINT_BATCH_MAX];
        int32_t count = pdi_ordinary_state_compute_batch(o, k, o->desc.linear, o->change, energy);
        for (int32_t n = 0; n < count; n++) density[o->band.first[k] + n] = energy[n];
    }
}

/* pd_material_interface.energy: sum over all points, mirror images too. `change` is overwritten. */
static double pdi_ordinary_state_ops_energy(const pd_ctx *ctx, void *self, const double *u)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    pdi_compensated_sum all = {0.0, 0.0};
    pdi_point_batch_set_displacements(ctx, &o->band, u);
    for (int32_t k = 0; k < o->band.batches; k++) {
        double energy[PD_POINT_BATCH_MAX];
        int32_t count = pdi_ordinary_state_compute_batch(o, k, o->desc.linear, o->change, energy);
        for (int32_t n = 0; n < count; n++)
            pdi_compensated_sum_add(&all, o->body->volume[o->band.first[k] + n] * energy[n]);
    }
    return pdi_compensated_sum_total(&all);
}

/* pd_material_interface.bond_energy: w t e/2 of each bond, with the force state t of its own family; 0: it is broken.
 * May be negative for a single bond. */
static void pdi_ordinary_state_ops_bond_energy(const pd_ctx *ctx, void *self, const double *u, double *energy)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    int linear = o->desc.linear, nt = pd_par_threads(ctx, o->body->bonds * 50);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < o->body->count; i++) {
        double q[PDI_SYM_COMPONENTS];
        pdi_ordinary_state_bond bond;
        pdi_ordinary_state_compute_state(o, linear, u, NULL, i, q);
        for (pd_bond_iterator f = pd_body_bonds_begin(o->body, i); pd_body_bonds_next(&f);) {
            double *each = energy + pdi_body_bond_number(&f);
            *each = 0.0;
            if (!pdi_ordinary_state_get_bond(o, linear, u, i, &f, &bond)) continue;
            double t = pdi_ordinary_state_family_force(o, &bond, i, q, bond.extension);
            *each = 0.5 * bond.w * t * bond.extension;
        }
    }
}

/* Volume ratio |det F| of the family of point i at u; 1 where its shape tensor or F is singular. */
static double pdi_ordinary_state_volume_ratio(const pd_ordinary_state *o, const double *u, int32_t i)
{
    double k[PD_DIM * PD_DIM] = {0.0}, y[PD_DIM * PD_DIM] = {0.0}, f[PD_DIM * PD_DIM];
    double none[PD_DIM] = {0.0}, swell = 1.0;
    pdi_ordinary_state_bond bond;
    for (pd_bond_iterator w = pd_body_bonds_begin(o->body, i); pd_body_bonds_next(&w);) {
        if (!pdi_ordinary_state_get_bond(o, 0, u, i, &w, &bond)) continue;
        for (int p = 0; p < PD_DIM * PD_DIM; p++) {
            k[p] += bond.weight * bond.xi[p / PD_DIM] * bond.xi[p % PD_DIM];
            y[p] += bond.weight * bond.length * bond.y[p / PD_DIM] * bond.xi[p % PD_DIM];
        }
    }
    if (!(pdi_vec_invert(k, f) > PDI_ORDINARY_STATE_MIN_PIVOT)) return 1.0;
    for (int p = 0; p < PD_DIM * PD_DIM; p++) {
        k[p] = 0.0;
        for (int d = 0; d < PD_DIM; d++) k[p] += y[p / PD_DIM * PD_DIM + d] * f[d * PD_DIM + p % PD_DIM];
    }
    for (int p = 0; p < PD_DIM * PD_DIM; p++) {
        f[p] = 0.0;
        for (int d = 0; d < PD_DIM; d++) f[p] += k[d * PD_DIM + p / PD_DIM] * k[d * PD_DIM + p % PD_DIM];
    }
    if (!pdi_vec_cholesky(PD_DIM, PD_DIM, none, f)) return 1.0;
    for (int d = 0; d < PD_DIM; d++) swell *= f[d * PD_DIM + d];
    return swell;
}

/* pd_material_interface.stress: force states of the family over the deformed volume; of small displacements the
 * reference volume. */
static void pdi_ordinary_state_ops_stress(const pd_ctx *ctx, void *self, const double *u, double *stress)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    int linear = o->desc.linear, nt = pd_par_threads(ctx, o->body->bonds * 20);
    (void)nt;
    pdi_point_batch_set_displacements(ctx, &o->band, u);
    PD_PARALLEL_FOR(nt)
    for (int32_t k = 0; k < o->band.batches; k++) {
        double sum[PDI_SYM_COMPONENTS][PD_POINT_BATCH_MAX];
        int32_t count = pdi_ordinary_state_compute_batch(o, k, linear, o->change, NULL);
        pdi_bond_extension_compute_stress(&o->band, k, linear, sum);
        for (int32_t n = 0; n < count; n++) {
            int32_t i = o->band.first[k] + n;
            double *to = stress + (int64_t)i * PD_DIM * PD_DIM,
                   swell = linear ? 1.0 : pdi_ordinary_state_volume_ratio(o, u, i);
            for (int p = 0; p < PD_DIM; p++)
                for (int q = 0; q < PD_DIM; q++)
                    to[p * PD_DIM + q] = sum[p > q ? pdi_mandel_index(p, q) : pdi_mandel_index(q, p)][n] / swell;
        }
    }
}

/* ---- update and build ---- */

/* Force density of the uniform stress e_b e_c^T + e_c e_b^T, as small displacements. u is work; o->state is
 * overwritten. */
static void pdi_ordinary_state_apply_uniform_stress(const pd_ctx *ctx, const pd_ordinary_state *o, int b, int c,
                                                    double *u, double *force)
{
    double trace = b == c ? 2.0 * o->lambda / (PD_DIM * o->lambda + 2.0 * o->mu) : 0.0;
    for (int64_t i = 0; i < o->body->count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            const double *x = o->body->position + i * PD_DIM;
            u[i * PD_DIM + p] = ((p == b ? x[c] : 0.0) + (p == c ? x[b] : 0.0) - trace * x[p]) / (2.0 * o->mu);
        }
    pdi_ordinary_state_compute_force(ctx, o, 1, u, o->state, force);
}

/* Surface vectors c, into surface_vector, that fit the forces of all uniform stresses P best by P c (theory: eq.
 * 14.17). u, force [count][PD_DIM]: work; o->state is overwritten. */
static void pdi_ordinary_state_fit_edges(const pd_ctx *ctx, const pd_ordinary_state *o, double *u, double *force)
{
    pdi_par_zero(ctx, (int64_t)o->body->count * PD_DIM, o->surface_vector);
    for (int b = 0; b < PD_DIM; b++)
        for (int c = 0; c <= b; c++) {
            pdi_ordinary_state_apply_uniform_stress(ctx, o, b, c, u, force);
            for (int64_t i = 0; i < o->body->count; i++) {
                o->surface_vector[i * PD_DIM + c] += force[i * PD_DIM + b] / (PD_DIM + 1.0);
                if (b != c) o->surface_vector[i * PD_DIM + b] += force[i * PD_DIM + c] / (PD_DIM + 1.0);
            }
        }
}

/* Computes the surface vectors of all points; o->state is overwritten. */
static pd_status pdi_ordinary_state_compute_edges(pd_ctx *ctx, const pd_ordinary_state *o)
{
    int64_t n = (int64_t)o->body->count * PD_DIM;
    double *u = NULL, *force = NULL;
    pd_status status = PD_NEW(ctx, "ordinary", n, u);
    if (status == PD_OK) status = PD_NEW(ctx, "ordinary", n, force);
    if (status == PD_OK) pdi_ordinary_state_fit_edges(ctx, o, u, force);
    PD_DELETE(ctx, n, force);
    PD_DELETE(ctx, n, u);
    return status;
}

/* Sets frequency_bound to the largest bound of all points; last_u is overwritten. */
static void pdi_ordinary_state_compute_frequency_bound(const pd_ctx *ctx, pd_ordinary_state *o)
{
    int nt = pd_par_threads(ctx, o->body->bonds * 60);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < o->body->count; i++) o->last_u[i] = pdi_ordinary_state_frequency_bound(o, i);
    o->frequency_bound = 0.0;
    for (int32_t i = 0; i < o->body->count; i++) o->frequency_bound = pd_max(o->frequency_bound, o->last_u[i]);
}

/* Laws of all families; energy_bound is not positive at points that have none. Returns the first of these points, with
 * detach_singular the first one that has intact bonds; -1: there is none. */
static int32_t pdi_ordinary_state_compute_laws(const pd_ctx *ctx, const pd_ordinary_state *o)
{
    const pd_body *body = o->body;
    int32_t bad = -1;
    int nt = pd_par_threads(ctx, body->bonds * 60);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        int good = pdi_ordinary_state_compute_law(o, i);
        if (good < 1) o->energy_bound[i] = good;
    }
    for (int32_t i = body->count - 1; i >= 0; i--)
        if (!(o->energy_bound[i] > 0.0) && (!o->desc.detach_singular || pdi_body_bonds_count_intact(body, i))) bad = i;
    return bad;
}

/* Laws of all families. With detach_singular points without a law lose their bonds, which detached_bonds counts;
 * otherwise they are PD_ERR_GEOMETRY. */
static pd_status pdi_ordinary_state_compute_stable_laws(pd_ctx *ctx, pd_ordinary_state *o)
{
    pd_body *body = o->body;
    int32_t bad = pdi_ordinary_state_compute_laws(ctx, o);
    while (bad >= 0 && o->desc.detach_singular) {
        for (int32_t i = bad; i < body->count; i++)
            if (!(o->energy_bound[i] > 0.0)) o->detached_bonds += pdi_body_bonds_break_all(body, i);
        bad = pdi_ordinary_state_compute_laws(ctx, o);
    }
    if (bad < 0) return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "ordinary", "the %.0f bonds of point %d at x = %g m %s",
                   (double)pdi_body_bonds_count_intact(body, bad), (int)bad, body->position[(int64_t)bad * PD_DIM],
                   o->energy_bound[bad] < 0.0 ? "leave a strain without energy: use the position method"
                                              : "do not tell all strains: the body is too thin there for its horizon");
}

/* Multiplies laws, alpha and energy bounds by the stiffness factors of points, if any. PD_ERR_ARGUMENT: a factor is
 * negative or not finite. */
static pd_status pdi_ordinary_state_apply_stiffness(pd_ctx *ctx, const pd_ordinary_state *o)
{
    for (int64_t i = 0; i < o->body->count && o->desc.stiffness_factor; i++) {
        double part = o->desc.stiffness_factor[i];
        if (!(part >= 0.0) || !(part < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "ordinary", "point %d has the part %g of E, expected a finite one of "
                           "at least 0", (int)i, part);
        o->alpha[i] *= part;
        o->energy_bound[i] *= part;
        for (int k = 0; k < PDI_MANDEL_MATRIX_SIZE; k++) o->law[i * PDI_MANDEL_MATRIX_SIZE + k] *= part;
    }
    return PD_OK;
}

/* pd_material_interface.out_of_plane_stress: nu tr(stress) in plane strain; otherwise 0. */
static double pdi_ordinary_state_ops_normal_stress(const void *self, int32_t i, const double *stress)
{
    const pd_ordinary_state *o = (const pd_ordinary_state *)self;
    double trace = 0.0;
    (void)i;
    for (int d = 0; d < PD_DIM; d++) trace += stress[d * (PD_DIM + 1)];
    return PD_DIM == 2 && o->desc.plane == PD_PLANE_STRAIN ? o->desc.poisson * trace : 0.0;
}

/* pd_material_interface.update: bonds or stiffness factors have changed. Points may lose their bonds (detach_singular);
 * last_u and Q become zero, so `force` has to come before the next tangent. PD_ERR_GEOMETRY, PD_ERR_ARGUMENT: a point
 * without a law, a stiffness factor that is negative or not finite; the material is then of no use. */
static pd_status pdi_ordinary_state_ops_update(pd_ctx *ctx, void *self)
{
    pd_ordinary_state *o = (pd_ordinary_state *)self;
    PD_TRY(pdi_ordinary_state_compute_stable_laws(ctx, o));
    PD_TRY(pdi_point_batch_update(ctx, &o->band));
    PD_TRY(pdi_ordinary_state_compute_edges(ctx, o));
    PD_TRY(pdi_ordinary_state_apply_stiffness(ctx, o));
    pdi_ordinary_state_compute_frequency_bound(ctx, o);
    pdi_par_zero(ctx, (int64_t)o->body->count * PD_DIM, o->last_u);
    pdi_par_zero(ctx, (int64_t)o->body->count * PDI_SYM_COMPONENTS, o->state);
    return PD_OK;
}

/* pd_material_interface.stable_step: 2 over the largest angular frequency. */
static double pdi_ordinary_state_ops_stable_step(const void *self, double density)
{
    return 2.0 * sqrt(density / ((const pd_ordinary_state *)self)->frequency_bound);
}

/* pd_material_interface.store: broken bonds; after reading the material is updated. */
static pd_status pdi_ordinary_state_ops_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    PD_TRY(pdi_array_registry_store(ctx, pdi_body_list_state, ((pd_ordinary_state *)self)->body, archive));
    return archive->is_reading ? pdi_ordinary_state_ops_update(ctx, self) : PD_OK;
}

PDI_FN void pdi_ordinary_state_list(pdi_array_visitor *owner, void *object)
{
    pd_ordinary_state *ordinary = (pd_ordinary_state *)object;
    int64_t count = ordinary->body ? ordinary->body->count : 0;
    PDI_ARRAY(owner, ordinary, influential, count, "1");
    PDI_ARRAY(owner, ordinary, alpha, count, "Pa/m^(d+2)");
    PDI_ARRAY(owner, ordinary, energy_bound, count, "Pa/m^(d+2)");
    PDI_ARRAY(owner, ordinary, law, count * PDI_MANDEL_MATRIX_SIZE, "Pa/m^(2d+4)");
    PDI_ARRAY(owner, ordinary, surface_vector, count * PD_DIM, "1/m");
    PDI_ARRAY(owner, ordinary, last_u, count * PD_DIM, "m");
    PDI_ARRAY(owner, ordinary, state, count * PDI_SYM_COMPONENTS, "");
    PDI_ARRAY(owner, ordinary, change, count * PDI_SYM_COMPONENTS, "");
}

/* Inner part of the build; after an error the caller frees. */
static pd_status pdi_ordinary_state_build_inner(pd_ctx *ctx, pd_body *body, const pd_ordinary_state_desc *desc,
                                                pd_ordinary_state *o)
{
    double nu = PD_DIM == 1 ? 0.0 : desc->poisson;
    int mends = desc->surface == PD_ORDINARY_STATE_ENERGY || desc->surface == PD_ORDINARY_STATE_VOLUME;
    memset(o, 0, sizeof *o);
    if (!(desc->young > 0.0) || !(desc->young < 1e100) || !(nu > -1.0) || !(nu < 0.5))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "ordinary",
                       "E = %g Pa and nu = %g, expected a finite positive E and nu between -1 and 0.5", desc->young,
                       desc->poisson);
    if ((int)desc->surface < 0 || desc->surface > PD_ORDINARY_STATE_VOLUME || (mends && !(body->spacing > 0.0)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "ordinary",
                       "method %d of surfaces and a spacing of %g m, expected 0 to "
                       "%d, and a spacing for those that compare with a whole family",
                       (int)desc->surface, body->spacing, (int)PD_ORDINARY_STATE_VOLUME);
    o->desc = *desc;
    o->body = body;
    o->mu = 0.5 * desc->young / (1.0 + nu);
    o->lambda = desc->young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    if (PD_DIM == 2 && desc->plane == PD_PLANE_STRESS) o->lambda = desc->young * nu / (1.0 - nu * nu);
    if (PD_DIM == 1) o->lambda = o->mu = desc->young / 3.0; /* a chain of springs */
    PD_TRY(pdi_array_registry_build(ctx, pdi_ordinary_state_list, o));
    pdi_body_bonds_mark_influential(body, o->influential);
    PD_TRY(pdi_bond_weights_build(ctx, body, &o->weights));
    PD_TRY(pdi_ordinary_state_compute_weights(ctx, o));
    PD_TRY(pdi_point_batch_build(ctx, body, &o->weights, PDI_BOND_EXTENSION_FIELDS, &o->band));
    return pdi_ordinary_state_ops_update(ctx, o);
}

pd_status pd_ordinary_state_build(pd_ctx *ctx, pd_body *body, const pd_ordinary_state_desc *desc,
                                  pd_ordinary_state *ordinary)
{
    pd_status status = pdi_ordinary_state_build_inner(ctx, body, desc, ordinary);
    if (status < 0) pd_ordinary_state_free(ctx, ordinary);
    return status;
}

pd_material_interface pd_ordinary_state_material(pd_ordinary_state *ordinary)
{
    pd_material_interface s;
    memset(&s, 0, sizeof s);
    s.name = "ordinary";
    s.self = ordinary;
    s.body = ordinary->body;
    s.surface_vector = ordinary->surface_vector;
    s.linear = ordinary->desc.linear;
    s.force = pdi_ordinary_state_ops_force;
    s.tangent = pdi_ordinary_state_ops_tangent;
    s.blocks = pdi_ordinary_state_ops_blocks;
    s.energy = pdi_ordinary_state_ops_energy;
    s.density = pdi_ordinary_state_ops_density;
    s.bond_energy = pdi_ordinary_state_ops_bond_energy;
    s.stress = pdi_ordinary_state_ops_stress;
    s.out_of_plane_stress = pdi_ordinary_state_ops_normal_stress;
    s.update = pdi_ordinary_state_ops_update;
    s.stable_step = pdi_ordinary_state_ops_stable_step;
    s.store = pdi_ordinary_state_ops_store;
    return s;
}

void pd_ordinary_state_free(pd_ctx *ctx, pd_ordinary_state *ordinary)
{
    pdi_point_batch_free(ctx, &ordinary->band);
    pdi_bond_weights_free(ctx, &ordinary->weights);
    pdi_array_registry_free(ctx, pdi_ordinary_state_list, ordinary);
    memset(ordinary, 0, sizeof *ordinary);
}

#undef PDI_ORDINARY_STATE_MIN_PIVOT
#undef PDI_ORDINARY_STATE_SQUARINGS
