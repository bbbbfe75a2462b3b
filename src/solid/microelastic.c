/* microelastic: see microelastic.h */
#include "solid/microelastic.h"
#include "core/par.h"
#include "solid/weight_calibration.h"
#include <math.h>
#include <string.h>

/* Least transverse over longitudinal bond stiffness in preconditioner blocks, so that they can be inverted. */
#define PDI_MICROELASTIC_MIN_TRANSVERSE 1e-3
/* Fixed-point scale: parts of 1/h in which surface vectors are summed. They are a few 1/h at most. */
#define PDI_MICROELASTIC_FIXED_POINT 4503599627370496.0 /* 2^52 */

/* Sums over a complete family of an infinite lattice; n = xi/r. */
typedef struct pdi_microelastic_sums {
    double axis;   /* [m^(d+1)] sum w r n_0^4 V */
    /* [m^(d+1)] sum w r (n_0^4 - 3 n_0^2 n_1^2) V: 0 when moduli are the same in all directions */
    double anisotropy;
    double stretch; /* [m^(d+1)] sum w r V */
    double square; /* [m^(d+2)] sum w r^2 V */
    double inverse; /* [m^(d-1)] sum w/r V */
    double crack;  /* [m^(d+2)] sum w r |n.xi| V for one direction */
    double volume; /* [m^d] sum beta V, beta: what lies within the horizon */
} pdi_microelastic_sums;

/* Sums over a complete family of the lattice, into s, with the weights, or (cubic 1) with the influence function times
 * q; n: crack normal of any length, or NULL: s->crack is 0. */
static void pdi_microelastic_sum_family(const pd_microelastic *m, int cubic, const double *n, pdi_microelastic_sums *s)
{
    const pd_body *body = m->body;
    double volume = pdi_weight_calibration_cell_volume(body), xi[PD_DIM];
    memset(s, 0, sizeof *s);
    for (int k = 0; k < pdi_weight_calibration_count_offsets(body); k++) {
        double square = pdi_weight_calibration_get_offset(body, k, xi), along = n ? pdi_vec_dot(n, xi) : 0.0, q = 0.0;
        double r = sqrt(square), first = xi[0] * xi[0], second = PD_DIM > 1 ? xi[PD_DIM - 1] * xi[PD_DIM - 1] : 0.0;
        double weight = square > 0.0 ? volume * pdi_body_compute_bond_weight(m->body, m->desc.influence, xi) : 0.0;
        if (!(weight > 0.0)) continue;
        q = pdi_weight_calibration_cubic_harmonic(xi, square);
        weight *= cubic ? q : 1.0 + m->isotropy * q;
        s->axis += weight * first * first / (square * r);
        s->anisotropy += weight * (first * first - 3.0 * first * second) / (square * r);
        s->stretch += weight * r;
        s->square += weight * square;
        s->inverse += weight / r;
        s->crack += weight * r * fabs(along);
        s->volume += volume * pdi_body_compute_bond_weight(m->body, PD_INFLUENCE_CONSTANT, xi);
    }
}

PDI_FN double pdi_microelastic_crack_energy(const pd_microelastic *m, const double *n)
{
    pdi_microelastic_sums s;
    pdi_microelastic_sum_family(m, 0, n, &s);
    return 0.25 * m->modulus * m->critical * m->critical * s.crack / pdi_vec_norm(n);
}

PDI_FN double pdi_microelastic_stable_step(const pd_microelastic *m, double density)
{
    pdi_microelastic_sums s;
    pdi_microelastic_sum_family(m, 0, NULL, &s);
    return sqrt(2.0 * density / (m->modulus * pd_max(s.inverse, m->stiffness_bound)));
}

/* pdi_microelastic_crack_energy as a callback of the anisotropy; self: the pd_microelastic. */
static double pdi_microelastic_crack_energy_of(const void *self, const double *n)
{
    return pdi_microelastic_crack_energy((const pd_microelastic *)self, n);
}

PDI_FN void pdi_microelastic_list(pdi_array_visitor *owner, void *object)
{
    pd_microelastic *microelastic = (pd_microelastic *)object;
    int64_t count = microelastic->body ? microelastic->body->count : 0;
    if (PD_DIM > 1 && microelastic->desc.surface == PD_MICROELASTIC_MOMENTS)
        PDI_ARRAY(owner, microelastic, multiplier, count * PD_SURFACE_CORRECTION_MOMENTS, "1");
    PDI_ARRAY(owner, microelastic, last_u, count * PD_DIM, "m");
    PDI_SCALAR_STATE(owner, microelastic, released, "J");
}

/* Elastic modulus c_11 [Pa] along an axis, by Young's modulus and the Poisson ratio 1/4: 6/5 E in 3D and plane strain;
 * in plane stress, with 1/3, 9/8 E; in 1D E. */
static double pdi_microelastic_axial_modulus(const pd_microelastic *m)
{
    static const double stiff[2] = {6.0 / 5.0, 9.0 / 8.0};
    return m->desc.young * (PD_DIM == 1 ? 1.0 : stiff[PD_DIM == 2 && m->desc.plane == PD_PLANE_STRESS]);
}

/* Sets isotropy (2D, 3D), modulus (micromodulus), critical (stretch, 0 for `fracture` 0) and anisotropy of the material
 * from sums over a complete family of the lattice (theory: 15.2). */
static void pdi_microelastic_calibrate(pd_microelastic *m)
{
    static const double mean[3] = {1.0, 2.0 / PD_PI, 0.5}; /* of |n.e| over all directions */
    double wanted = pdi_microelastic_axial_modulus(m);
    pdi_microelastic_sums plain, cubic;
    if (PD_DIM > 1) {
        pdi_microelastic_sum_family(m, 0, NULL, &plain);
        pdi_microelastic_sum_family(m, 1, NULL, &cubic);
        if (fabs(cubic.anisotropy) > 0.0) m->isotropy = -plain.anisotropy / cubic.anisotropy;
    }
    pdi_microelastic_sum_family(m, 0, NULL, &plain);
    m->modulus = 2.0 * wanted / plain.axis;
    m->critical = sqrt(4.0 * m->desc.fracture / (m->modulus * mean[PD_DIM - 1] * plain.square));
    m->anisotropy = pdi_weight_calibration_compute_anisotropy(pdi_microelastic_crack_energy_of, m);
}

/* ---- weights ---- */

/* Context of the weight functions. */
typedef struct pdi_microelastic_weight_params {
    const pd_microelastic *m;
    pdi_microelastic_sums complete;
    pdi_surface_correction correction;
    /* [count][PD_DIM] energy along each axis, or volume, of families; NULL: no such factors */
    const double *family_moments;
} pdi_microelastic_weight_params;

/* Weight [-] of the bond xi without surface correction: influence function, cell fraction and isotropy factor. */
static double pdi_microelastic_influence_weight(const pd_microelastic *m, const double *xi)
{
    double weight = 1.0 + m->isotropy * pdi_weight_calibration_cubic_harmonic(xi, pdi_vec_dot(xi, xi));
    return weight * pdi_body_compute_bond_weight(m->body, m->desc.influence, xi);
}

/* The pdi_bond_weights_fn without surface correction; self: the pd_microelastic. */
static double pdi_microelastic_uncorrected_weight(const void *self, int32_t i, const pd_bond_iterator *bond)
{
    const pd_microelastic *m = (const pd_microelastic *)self;
    double xi[PD_DIM];
    pdi_bond_force_compute_offset(&m->springs, i, bond->neighbour, xi);
    return pdi_microelastic_influence_weight(m, xi);
}

/* The pdi_bond_weights_fn with the surface correction, by the multipliers or the family moments of both ends; without
 * both of them the factor is 1. self: pdi_microelastic_weight_params. */
static double pdi_microelastic_corrected_weight(const void *self, int32_t i, const pd_bond_iterator *bond)
{
    const pdi_microelastic_weight_params *o = (const pdi_microelastic_weight_params *)self;
    const pd_microelastic *m = o->m;
    int64_t j = bond->neighbour, k = i;
    double xi[PD_DIM], factor = 1.0;
    pdi_bond_force_compute_offset(&m->springs, i, bond->neighbour, xi);
    if (m->multiplier)
        factor = pdi_surface_correction_bond_factor(&o->correction, m->multiplier + k * PD_SURFACE_CORRECTION_MOMENTS,
                                                    m->multiplier + j * PD_SURFACE_CORRECTION_MOMENTS, xi);
    else if (o->family_moments && m->desc.surface == PD_MICROELASTIC_VOLUME)
        factor = 2.0 * o->complete.volume / (o->family_moments[k * PD_DIM] + o->family_moments[j * PD_DIM]);
    else if (o->family_moments)
        factor = pdi_weight_calibration_correction_factor(o->family_moments + k * PD_DIM,
                                                          o->family_moments + j * PD_DIM, xi, o->complete.axis);
    return (double)(float)pdi_microelastic_influence_weight(m, xi) * factor;
}

/* Moments of the family of point i, broken bonds too, into part [PD_DIM]: energy method: sum w r n_a^4 V [m^(d+1)]
 * along each axis; volume method: the family volume [m^d] in all entries. */
static void pdi_microelastic_compute_family_moments(const pd_microelastic *m, int32_t i, double *part)
{
    const pd_body *body = m->body;
    pdi_compensated_sum sum[PD_DIM];
    memset(sum, 0, sizeof sum);
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double xi[PD_DIM], volume = body->volume[f.neighbour];
        pdi_bond_force_compute_offset(&m->springs, i, f.neighbour, xi);
        double square = pdi_vec_dot(xi, xi);
        double share = pdi_microelastic_influence_weight(m, xi) * volume / (square * sqrt(square));
        double inside = volume * pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi);
        for (int a = 0; a < PD_DIM; a++)
            pdi_compensated_sum_add(
                &sum[a], m->desc.surface == PD_MICROELASTIC_VOLUME ? inside : share * xi[a] * xi[a] * xi[a] * xi[a]);
    }
    for (int a = 0; a < PD_DIM; a++) part[a] = pdi_compensated_sum_total(&sum[a]);
}

/* Upper bound (row sum) of the eigenvalues of sum w/r n n V of the family of point i [m^(d-1)], broken bonds too. */
static double pdi_microelastic_stiffness_bound(const pd_microelastic *m, int32_t i)
{
    double stiff[PD_DIM * PD_DIM] = {0.0}, most = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(m->body, i); pd_body_bonds_next(&f);) {
        double xi[PD_DIM], weight = (double)pdi_bond_weights_get(&m->weights, i, &f);
        pdi_bond_force_compute_offset(&m->springs, i, f.neighbour, xi);
        double square = pdi_vec_dot(xi, xi), over = weight * m->body->volume[f.neighbour] / (square * sqrt(square));
        for (int p = 0; p < PD_DIM * PD_DIM; p++) stiff[p] += over * (xi[p / PD_DIM] * xi[p % PD_DIM]);
    }
    for (int a = 0; a < PD_DIM; a++) {
        double sum = 0.0;
        for (int c = 0; c < PD_DIM; c++) sum += fabs(stiff[a * PD_DIM + c]);
        most = pd_max(most, sum);
    }
    return most;
}

/* Computes the weights of all bonds, broken ones too, with the surface correction (theory: 15.3); sets multiplier,
 * where there is one, and stiffness_bound (1D: it stays). work [count][PD_DIM] is overwritten; it may be last_u. */
static pd_status pdi_microelastic_compute_weights(pd_ctx *ctx, pd_microelastic *m, double *work)
{
    const pd_body *body = m->body;
    int nt = pd_par_threads(ctx, body->bonds * 50);
    pdi_microelastic_weight_params make;
    (void)nt;
    memset(&make, 0, sizeof make);
    make.m = m;
    pdi_microelastic_sum_family(m, 0, NULL, &make.complete);
    make.correction.bonds = &m->springs;
    make.correction.axial_moment = make.complete.axis;
    make.correction.length = sqrt(make.complete.stretch / make.complete.inverse);
    if (m->multiplier) {
        PD_TRY(pdi_bond_weights_compute(ctx, &m->weights, pdi_microelastic_uncorrected_weight, m));
        PD_TRY(pdi_surface_correction_solve(ctx, &make.correction, m->multiplier));
    } else if (m->desc.surface != PD_MICROELASTIC_NONE) {
        make.family_moments = work;
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < body->count; i++)
            pdi_microelastic_compute_family_moments(m, i, work + (int64_t)i * PD_DIM);
    }
    PD_TRY(pdi_bond_weights_compute(ctx, &m->weights, pdi_microelastic_corrected_weight, &make));
    if (PD_DIM == 1) return PD_OK;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) work[i] = pdi_microelastic_stiffness_bound(m, i);
    m->stiffness_bound = (double)(float)pdi_par_max_abs(ctx, body->count, work);
    return PD_OK;
}

/* Inner part of the build; after an error the caller frees. */
static pd_status pdi_microelastic_build_inner(pd_ctx *ctx, pd_body *body, const pd_microelastic_desc *desc,
                                              pd_microelastic *m)
{
    memset(m, 0, sizeof *m);
    if (!(desc->young > 0.0) || !(desc->young < 1e100) || !(desc->fracture >= 0.0) || !(desc->fracture < 1e100) ||
        !(body->spacing > 0.0) || pd_body_is_periodic(body))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "microelastic", "E = %g Pa, %g J/m2 of a crack, a spacing of %g m and a "
                       "period of %g m: expected positive and finite values, and no period", desc->young,
                       desc->fracture, body->spacing, body->period[PD_DIM - 1]);
    if ((int)desc->surface < 0 || desc->surface > PD_MICROELASTIC_NONE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "microelastic", "method %d of surfaces, expected 0 to %d",
                       (int)desc->surface, (int)PD_MICROELASTIC_NONE);
    m->desc = *desc;
    m->body = body;
    PD_TRY(pdi_array_registry_build(ctx, pdi_microelastic_list, m));
    PD_TRY(pdi_bond_weights_build(ctx, body, &m->weights));
    PD_TRY(pdi_bond_force_build(ctx, body, &m->weights, &m->springs));
    pdi_microelastic_calibrate(m);
    PD_TRY(pdi_microelastic_compute_weights(ctx, m, m->last_u));
    pdi_par_zero(ctx, (int64_t)body->count * PD_DIM, m->last_u);
    return pdi_bond_force_update(ctx, &m->springs);
}

pd_status pd_microelastic_build(pd_ctx *ctx, pd_body *body, const pd_microelastic_desc *desc, pd_microelastic *m)
{
    pd_status status = pdi_microelastic_build_inner(ctx, body, desc, m);
    if (status < 0) pd_microelastic_free(ctx, m);
    return status;
}

void pd_microelastic_free(pd_ctx *ctx, pd_microelastic *m)
{
    pdi_bond_force_free(ctx, &m->springs);
    pdi_bond_weights_free(ctx, &m->weights);
    pdi_array_registry_free(ctx, pdi_microelastic_list, m);
    memset(m, 0, sizeof *m);
}

/* Stretch [-] of the bond from point i to j at u; out: Y, r and |Y| [m]. */
static inline double pdi_microelastic_compute_stretch(const pd_body *body, const double *u, int32_t i, int32_t j,
                                                      double *y, double *r, double *length)
{
    const double *own = u + (int64_t)i * PD_DIM, *far = u + (int64_t)j * PD_DIM;
    double xi[PD_DIM], eta[PD_DIM];
    pdi_body_compute_offset(body, i, j, xi);
    for (int d = 0; d < PD_DIM; d++) eta[d] = far[d] - own[d];
    return pdi_body_compute_stretch(xi, eta, y, r, length);
}

/* Forces at u, into force. breaks 1, with a critical stretch > 0: bonds beyond it break, and add their energy at u -
 * midpoint_dt v (v NULL: at u) to m->released. Returns how many broke; otherwise 0. */
static int64_t pdi_microelastic_compute_force(const pd_ctx *ctx, pd_microelastic *m, const double *u, const double *v,
                                              double midpoint_dt, int breaks, double *force)
{
    pdi_bond_force_state sweep;
    sweep.u = u;
    sweep.v = v;
    sweep.midpoint_dt = midpoint_dt;
    sweep.critical = breaks && m->critical > 0.0 ? m->critical : HUGE_VAL;
    sweep.modulus = m->modulus;
    sweep.force = force;
    int64_t broken = pdi_bond_force_compute_force(ctx, &m->springs, &sweep);
    m->released += sweep.released;
    return broken;
}

int64_t pd_microelastic_force(const pd_ctx *ctx, pd_microelastic *m, const double *u, int breaks, double *force)
{
    return pdi_microelastic_compute_force(ctx, m, u, NULL, 0.0, breaks, force);
}

PDI_FN void pdi_microelastic_compute_edge(const pd_microelastic *m, int32_t i, double *edge)
{
    double over = 3.0 * m->modulus / ((PD_DIM + 2.0) * pdi_microelastic_axial_modulus(m)) * m->body->spacing,
           xi[PD_DIM];
    int64_t units[PD_DIM] = {0}; /* whole numbers, so that mirror images have the same bits */
    for (pd_bond_iterator f = pd_body_bonds_begin(m->body, i); pd_body_bonds_next(&f);) {
        pdi_bond_force_compute_offset(&m->springs, i, f.neighbour, xi);
        double weight = over * (double)pdi_bond_weights_get(&m->weights, i, &f) * m->body->volume[f.neighbour];
        double most = weight / pdi_vec_norm(xi) * PDI_MICROELASTIC_FIXED_POINT;
        for (int d = 0; d < PD_DIM; d++) units[d] += (int64_t)llround(most * xi[d]);
    }
    for (int d = 0; d < PD_DIM; d++) edge[d] = (double)units[d] / PDI_MICROELASTIC_FIXED_POINT / m->body->spacing;
}

/* Strain energy density of point i at displacements u [J/m3]: half the energy of its unbroken bonds; the other half
 * belongs to the other ends. */
static double pdi_microelastic_energy_density(const pd_microelastic *m, const double *u, int32_t i)
{
    const pd_body *body = m->body;
    double sum = 0.0, y[PD_DIM], r, length;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double weight = pdi_bond_weights_get_intact(&m->weights, i, &f) * body->volume[f.neighbour];
        if (!(weight > 0.0)) continue;
        double s = pdi_microelastic_compute_stretch(body, u, i, f.neighbour, y, &r, &length);
        sum += weight * s * s * r;
    }
    return 0.25 * m->modulus * sum;
}

double pd_microelastic_energy(const pd_ctx *ctx, const pd_microelastic *m, const double *u)
{
    pdi_compensated_sum all = {0.0, 0.0};
    (void)ctx;
    for (int32_t i = 0; i < m->body->count; i++)
        pdi_compensated_sum_add(&all, m->body->volume[i] * pdi_microelastic_energy_density(m, u, i));
    return pdi_compensated_sum_total(&all);
}

/* ---- what solvers see ---- */

/* pd_material_interface.force: forces without breaking; keeps u for the tangent. PD_RETRY: a force is not finite. */
static pd_status pdi_microelastic_ops_force(pd_ctx *ctx, void *self, const double *u, double *force)
{
    pd_microelastic *m = (pd_microelastic *)self;
    int64_t n = (int64_t)m->body->count * PD_DIM;
    pd_microelastic_force(ctx, m, u, 0, force);
    pdi_par_copy(ctx, n, u, m->last_u);
    return pdi_par_max_abs(ctx, n, force) < HUGE_VAL ? PD_OK : PD_RETRY;
}

/* Longitudinal and transverse stiffness of a bond of point i at u [N/m^(2d+1)], and its direction n in the deformed
 * body. Returns 1; 0: it is broken, and nothing is set. */
static int pdi_microelastic_bond_stiffness(const pd_microelastic *m, const double *u, int32_t i,
                                           const pd_bond_iterator *f, double *n, double *longitudinal,
                                           double *transverse)
{
    double r, length, weight = m->modulus * pdi_bond_weights_get_intact(&m->weights, i, f);
    if (!(weight > 0.0)) return 0;
    double s = pdi_microelastic_compute_stretch(m->body, u, i, f->neighbour, n, &r, &length);
    for (int d = 0; d < PD_DIM; d++) n[d] /= length;
    *longitudinal = weight / r;
    *transverse = weight * s / length;
    return 1;
}

/* pd_material_interface.tangent at the displacements of the last force, with the geometric stiffness of stretched and
 * compressed bonds, of all points. */
static void pdi_microelastic_ops_tangent(const pd_ctx *ctx, void *self, const double *du, double *df)
{
    const pd_microelastic *m = (const pd_microelastic *)self;
    const pd_body *body = m->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double sum[PD_DIM] = {0.0}, n[PD_DIM], along, across;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            const double *own = du + (int64_t)i * PD_DIM, *far = du + (int64_t)f.neighbour * PD_DIM;
            double volume = body->volume[f.neighbour], longer = 0.0;
            if (!pdi_microelastic_bond_stiffness(m, m->last_u, i, &f, n, &along, &across)) continue;
            for (int d = 0; d < PD_DIM; d++) longer += n[d] * (far[d] - own[d]);
            for (int d = 0; d < PD_DIM; d++)
                sum[d] += volume * (across * (far[d] - own[d]) + (along - across) * longer * n[d]);
        }
        for (int d = 0; d < PD_DIM; d++) df[(int64_t)i * PD_DIM + d] = sum[d];
    }
}

/* pd_material_interface.blocks: diagonal blocks of the unbroken bonds at last_u. The transverse stiffness of a bond is
 * at least 1e-3 of the longitudinal one, so compressed bonds give no negative one. Zero for a point without bonds. */
static void pdi_microelastic_ops_blocks(const pd_ctx *ctx, void *self, double *block)
{
    const pd_microelastic *m = (const pd_microelastic *)self;
    const pd_body *body = m->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double *a = block + (int64_t)i * PD_DIM * PD_DIM, n[PD_DIM], along, across;
        for (int p = 0; p < PD_DIM * PD_DIM; p++) a[p] = 0.0;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
            double volume = body->volume[i] * body->volume[f.neighbour];
            if (!pdi_microelastic_bond_stiffness(m, m->last_u, i, &f, n, &along, &across)) continue;
            across = pd_max(across, PDI_MICROELASTIC_MIN_TRANSVERSE * along);
            for (int p = 0; p < PD_DIM * PD_DIM; p++) {
                int row = p / PD_DIM, column = p % PD_DIM;
                a[p] += volume * ((row == column ? across : 0.0) + (along - across) * (n[row] * n[column]));
            }
        }
    }
}

/* pd_material_interface.energy. */
static double pdi_microelastic_ops_energy(const pd_ctx *ctx, void *self, const double *u)
{
    return pd_microelastic_energy(ctx, (const pd_microelastic *)self, u);
}

/* pd_material_interface.density: energy density of all points. */
static void pdi_microelastic_ops_density(const pd_ctx *ctx, void *self, const double *u, double *density)
{
    const pd_microelastic *m = (const pd_microelastic *)self;
    int nt = pd_par_threads(ctx, m->body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < m->body->count; i++) density[i] = pdi_microelastic_energy_density(m, u, i);
}

/* pd_material_interface.force_state: half of the bond force on point i, the part of its own family; zero for a broken
 * bond. */
static void pdi_microelastic_ops_bond_force(const void *self, const double *u, int32_t i, const pd_bond_iterator *f,
                                            double *pull)
{
    const pd_microelastic *m = (const pd_microelastic *)self;
    double r, length, weight = pdi_bond_weights_get_intact(&m->weights, i, f);
    double s = pdi_microelastic_compute_stretch(m->body, u, i, f->neighbour, pull, &r, &length);
    for (int d = 0; d < PD_DIM; d++) pull[d] *= weight > 0.0 ? 0.5 * m->modulus * weight * s / length : 0.0;
}

/* pd_material_interface.dynamic_force: forces at the end of a time step, with breaking. The energy of a bond that
 * breaks, which adds to `released`, is that at the middle of the step. */
static int64_t pdi_microelastic_ops_move(const pd_ctx *ctx, void *self, const double *u, const double *v, double dt,
                                         double *force)
{
    return pdi_microelastic_compute_force(ctx, (pd_microelastic *)self, u, v, 0.5 * dt, 1, force);
}

/* pd_material_interface.update: bonds have broken; rebuilds the batches. Weights do not change. */
static pd_status pdi_microelastic_ops_update(pd_ctx *ctx, void *self)
{
    return pdi_bond_force_update(ctx, &((pd_microelastic *)self)->springs);
}

/* pd_material_interface.stable_step. */
static double pdi_microelastic_ops_stable_step(const void *self, double density)
{
    return pdi_microelastic_stable_step((const pd_microelastic *)self, density);
}

/* pd_material_interface.store: released energy and broken bonds, to or from an archive; after reading the batches are
 * rebuilt. */
static pd_status pdi_microelastic_ops_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_microelastic *m = (pd_microelastic *)self;
    PD_TRY(pdi_array_registry_store(ctx, pdi_microelastic_list, m, archive));
    PD_TRY(pdi_array_registry_store(ctx, pdi_body_list_state, m->body, archive));
    return archive->is_reading ? pdi_bond_force_update(ctx, &m->springs) : PD_OK;
}

pd_material_interface pd_microelastic_material(pd_microelastic *m)
{
    pd_material_interface solid;
    memset(&solid, 0, sizeof solid);
    solid.name = "microelastic";
    solid.self = m;
    solid.body = m->body;
    solid.force = pdi_microelastic_ops_force;
    solid.tangent = pdi_microelastic_ops_tangent;
    solid.blocks = pdi_microelastic_ops_blocks;
    solid.energy = pdi_microelastic_ops_energy;
    solid.density = pdi_microelastic_ops_density;
    solid.force_state = pdi_microelastic_ops_bond_force;
    solid.dynamic_force = pdi_microelastic_ops_move;
    solid.update = pdi_microelastic_ops_update;
    solid.stable_step = pdi_microelastic_ops_stable_step;
    solid.store = pdi_microelastic_ops_store;
    return solid;
}

#undef PDI_MICROELASTIC_MIN_TRANSVERSE
#undef PDI_MICROELASTIC_FIXED_POINT
