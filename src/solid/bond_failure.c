/* bond_failure: see bond_failure.h */
#include "solid/bond_failure.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include "solid/weight_calibration.h"
#include <math.h>
#include <string.h>

/* Singular shape tensor: smallest pivot over the largest entry of K below which no gradient exists. */
#define PDI_BOND_FAILURE_MIN_PIVOT 1e-6
/* Relative difference of measures within which bonds break together, as those of mirror images do. */
#define PDI_BOND_FAILURE_TIE 1e-9

PDI_FN void pdi_bond_failure_list(pdi_array_visitor *owner, void *object)
{
    pd_bond_failure *criterion = (pd_bond_failure *)object;
    const pd_body *body = criterion->solid.body;
    int64_t count = body && criterion->critical > 0.0 ? body->count : 0;
    int64_t tensors = criterion->desc.kind >= PD_BOND_FAILURE_PRINCIPAL ? count : 0;
    PDI_ARRAY(owner, criterion, energy, count && criterion->desc.kind == PD_BOND_FAILURE_ENERGY ? body->bonds : 0,
              "J/m^(2d)");
    PDI_ARRAY(owner, criterion, stress, tensors * PD_DIM * PD_DIM, "Pa");
    PDI_ARRAY(owner, criterion, scalar, tensors, "Pa");
    PDI_ARRAY(owner, criterion, max_measure, count, "1");
}

/* ---- calibration ---- */

/* Sum of beta V r over a complete family of the lattice, or of beta V |n.xi| where n is not NULL [m^(d+1)]; beta: cell
 * fraction within the horizon, V: cell volume. */
static double pdi_bond_failure_sum_family(const pd_body *body, const double *n)
{
    double sum = 0.0, xi[PD_DIM];
    for (int k = 0; k < pdi_weight_calibration_count_offsets(body); k++) {
        double square = pdi_weight_calibration_get_offset(body, k, xi);
        if (!(square > 0.0)) continue;
        sum += pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi) *
               (n ? fabs(pdi_vec_dot(n, xi)) : sqrt(square));
    }
    return pdi_weight_calibration_cell_volume(body) * sum;
}

PDI_FN double pdi_bond_failure_crack_energy(const pd_bond_failure *c, const double *n)
{
    return 0.5 * c->critical * pdi_bond_failure_sum_family(c->solid.body, n) / pdi_vec_norm(n);
}

/* pdi_bond_failure_crack_energy as a callback of the anisotropy; self: the pd_bond_failure. */
static double pdi_bond_failure_crack_energy_of(const void *self, const double *n)
{
    return pdi_bond_failure_crack_energy((const pd_bond_failure *)self, n);
}

/* Sets `critical`, the bond energy for the wanted fracture energy as a mean over all crack directions (theory: eq.
 * 15.11), and `anisotropy`. */
static void pdi_bond_failure_calibrate(pd_bond_failure *c)
{
    static const double mean[3] = {1.0, 2.0 / PD_PI, 0.5}; /* of |n.e| */
    c->critical = 2.0 * c->desc.fracture / (mean[PD_DIM - 1] * pdi_bond_failure_sum_family(c->solid.body, NULL));
    c->anisotropy = pdi_weight_calibration_compute_anisotropy(pdi_bond_failure_crack_energy_of, c);
}

/* ---- measures ---- */

/* Largest of the three principal stresses, or von Mises stress [Pa] of point i, by the kind of criterion, of the
 * symmetric part of stress; with the out-of-plane stress in 2D. Where the von Mises stress is 0, the principal one is
 * the mean. */
static double pdi_bond_failure_equivalent_stress(const pd_bond_failure *c, int32_t i, const double *stress)
{
    double s[9] = {0.0},
           normal = c->solid.out_of_plane_stress ? c->solid.out_of_plane_stress(c->solid.self, i, stress) : 0.0, mean;
    double mises = pdi_material_interface_von_mises(stress, normal, &mean);
    if (c->desc.kind == PD_BOND_FAILURE_MISES) return mises;
    if (!(mises > 0.0)) return mean;
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) s[3 * p + q] = 0.5 * (stress[p * PD_DIM + q] + stress[q * PD_DIM + p]);
    if (PD_DIM == 2) s[8] = normal;
    for (int p = 0; p < 3; p++) s[4 * p] -= mean;
    double third = s[0] * (s[4] * s[8] - s[5] * s[5]) - s[1] * (s[1] * s[8] - s[5] * s[2]) +
                   s[2] * (s[1] * s[5] - s[4] * s[2]);
    double size = mises / 3.0, turn = 0.5 * third / (size * size * size); /* = cos(3 angle) */
    return mean + 2.0 * size * cos(acos(pd_max(-1.0, pd_min(1.0, turn))) / 3.0);
}

/* Reference vector xi and relative displacement eta of the current bond of point i [m]. */
static void pdi_bond_failure_bond_vectors(const pd_bond_failure *c, const double *u, int32_t i,
                                          const pd_bond_iterator *f, double *xi, double *eta)
{
    const double *own = u + (int64_t)i * PD_DIM, *far = u + (int64_t)f->neighbour * PD_DIM;
    pdi_body_bond_vector(c->solid.body, i, f, xi);
    for (int d = 0; d < PD_DIM; d++) eta[d] = far[d] - own[d];
}

/* Failure measure of the current bond of point i, in the unit of the kind; 0: it is broken, spared, or by energy not
 * stretched. A stretch may be negative. Energies and stresses are those that pdi_bond_failure_find_max has prepared. */
static double pdi_bond_failure_compute_measure(const pd_bond_failure *c, const double *u, int32_t i,
                                               const pd_bond_iterator *f)
{
    const pd_body *body = c->solid.body;
    int32_t j = f->neighbour;
    double xi[PD_DIM], eta[PD_DIM], y[PD_DIM], r, length;
    if (pd_body_bond_is_broken(f) || (c->desc.unbreakable && (c->desc.unbreakable[i] || c->desc.unbreakable[j])))
        return 0.0;
    if (c->desc.kind >= PD_BOND_FAILURE_PRINCIPAL) return 0.5 * (c->scalar[i] + c->scalar[j]);
    pdi_bond_failure_bond_vectors(c, u, i, f, xi, eta);
    double stretch = pdi_body_compute_stretch(xi, eta, y, &r, &length);
    if (c->desc.kind == PD_BOND_FAILURE_STRETCH) return stretch;
    if (!(stretch > 0.0)) return 0.0;
    double energy =
        c->energy[pdi_body_bond_number(f)] + c->energy[body->first_bond[j] + pdi_body_bonds_find_reverse(body, i, f)];
    return energy / pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi);
}

/* Inverse of the factor on u at which the current bond of point i breaks; 0: it never does, as its measure is not
 * positive. Stretch: |xi + factor eta| = (1 + critical) r; energy: sqrt(measure/critical); stress: measure/critical. */
static double pdi_bond_failure_inverse_load_factor(const pd_bond_failure *c, const double *u, int32_t i,
                                                   const pd_bond_iterator *f)
{
    double xi[PD_DIM], eta[PD_DIM], measure = pdi_bond_failure_compute_measure(c, u, i, f);
    if (!(measure > 0.0)) return 0.0;
    if (c->desc.kind == PD_BOND_FAILURE_ENERGY) return sqrt(measure / c->critical);
    if (c->desc.kind != PD_BOND_FAILURE_STRETCH) return measure / c->critical;
    pdi_bond_failure_bond_vectors(c, u, i, f, xi, eta); /* |xi + f eta| = (1 + critical) r */
    double along = pdi_vec_dot(xi, eta), square = pdi_vec_dot(eta, eta);
    double gap = c->critical * (2.0 + c->critical) * pdi_vec_dot(xi, xi), root = sqrt(along * along + square * gap);
    return along > 0.0 ? (along + root) / gap : square / (root - along);
}

/* A measure of bonds: pdi_bond_failure_compute_measure or pdi_bond_failure_inverse_load_factor. */
typedef double (*pdi_bond_failure_fn)(const pd_bond_failure *c, const double *u, int32_t i, const pd_bond_iterator *f);

/* Prepares energies or stresses at u, and finds the largest measure of the bonds of each point, at least 0, into
 * max_measure. A bond belongs to the point with the lower number, so both ends see the same. Returns the largest of
 * all. */
static double pdi_bond_failure_find_max(const pd_ctx *ctx, pd_bond_failure *c, const double *u,
                                        pdi_bond_failure_fn measure)
{
    const pd_body *body = c->solid.body;
    double most = 0.0;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    if (c->desc.kind == PD_BOND_FAILURE_ENERGY) c->solid.bond_energy(ctx, c->solid.self, u, c->energy);
    if (c->desc.kind >= PD_BOND_FAILURE_PRINCIPAL) {
        c->solid.stress(ctx, c->solid.self, u, c->stress);
        for (int32_t i = 0; i < body->count; i++)
            c->scalar[i] = pdi_bond_failure_equivalent_stress(c, i, c->stress + (int64_t)i * PD_DIM * PD_DIM);
    }
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        c->max_measure[i] = 0.0;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            if (f.neighbour >= i) c->max_measure[i] = pd_max(c->max_measure[i], measure(c, u, i, &f));
    }
    for (int32_t i = 0; i < body->count; i++) most = pd_max(most, c->max_measure[i]);
    return most;
}

/* ---- what breaks ---- */

/* Measure from which bonds break, by the largest one and `eager` (see pd_bond_failure_break). */
static double pdi_bond_failure_breaking_threshold(const pd_bond_failure *c, double max_measure, double eager)
{
    return pd_max(c->critical, (max_measure - eager * (max_measure - c->critical)) * (1.0 - PDI_BOND_FAILURE_TIE));
}

/* Displacement gradient h [PD_DIM^2] [-] by the unbroken bonds of point i, with volumes and cell fractions as weights.
 * Returns 1; 0: the shape tensor is singular (smallest pivot not above 1e-6 of its largest entry), and h stays. */
static int pdi_bond_failure_compute_gradient(const pd_bond_failure *c, const double *u, int32_t i, double *h)
{
    const pd_body *body = c->solid.body;
    double k[PD_DIM * PD_DIM] = {0.0}, moved[PD_DIM * PD_DIM] = {0.0}, shape[PD_DIM * PD_DIM] = {0.0};
    double xi[PD_DIM], eta[PD_DIM], over = 1.0 / (body->horizon * body->horizon);
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        if (pd_body_bond_is_broken(&f)) continue;
        pdi_bond_failure_bond_vectors(c, u, i, &f, xi, eta);
        double weight =
            over * pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi) * body->volume[f.neighbour];
        for (int p = 0; p < PD_DIM * PD_DIM; p++) {
            k[p] += weight * xi[p / PD_DIM] * xi[p % PD_DIM];
            moved[p] += weight * eta[p / PD_DIM] * xi[p % PD_DIM];
        }
    }
    if (!(pdi_vec_invert(k, shape) > PDI_BOND_FAILURE_MIN_PIVOT)) return 0;
    for (int p = 0; p < PD_DIM; p++)
        for (int q = 0; q < PD_DIM; q++) {
            h[p * PD_DIM + q] = 0.0;
            for (int r = 0; r < PD_DIM; r++) h[p * PD_DIM + q] += moved[p * PD_DIM + r] * shape[r * PD_DIM + q];
        }
    return 1;
}

/* Largest stretch that the gradient of point i would give to its broken bonds, at least 0; 0 also where all bonds are
 * intact or broken, the point is spared, or there is no gradient. Finds points whose remaining bonds no longer resist
 * the load. */
static double pdi_bond_failure_lost_stretch(const pd_bond_failure *c, const double *u, int32_t i)
{
    const pd_body *body = c->solid.body;
    double h[PD_DIM * PD_DIM], xi[PD_DIM], eta[PD_DIM], y[PD_DIM], r, length, most = 0.0;
    int64_t intact = pdi_body_bonds_count_intact(body, i);
    if (!intact || intact == body->first_bond[i + 1] - body->first_bond[i] ||
        (c->desc.unbreakable && c->desc.unbreakable[i]))
        return 0.0;
    if (!pdi_bond_failure_compute_gradient(c, u, i, h)) return 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        if (!pd_body_bond_is_broken(&f)) continue;
        pdi_body_bond_vector(body, i, &f, xi);
        for (int p = 0; p < PD_DIM; p++) {
            eta[p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) eta[p] += h[p * PD_DIM + q] * xi[q];
        }
        most = pd_max(most, pdi_body_compute_stretch(xi, eta, y, &r, &length));
    }
    return most;
}

/* Breaks all bonds, but those to spared points, of points whose gradient would stretch a broken bond beyond the
 * critical value: their remaining bonds do not feel it. Overwrites max_measure. eager: as of pd_bond_failure_break.
 * Returns how many bonds broke. */
static int64_t pdi_bond_failure_break_blind_points(const pd_ctx *ctx, pd_bond_failure *c, const double *u, double eager)
{
    pd_body *body = c->solid.body;
    int64_t broken = 0;
    double most = 0.0;
    int nt = pd_par_threads(ctx, body->bonds);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) c->max_measure[i] = pdi_bond_failure_lost_stretch(c, u, i);
    for (int32_t i = 0; i < body->count; i++) most = pd_max(most, c->max_measure[i]);
    if (!(most > c->critical)) return 0;
    double from = pdi_bond_failure_breaking_threshold(c, most, eager);
    for (int32_t i = 0; i < body->count; i++) {
        if (!(c->max_measure[i] >= from)) continue;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            if (!c->desc.unbreakable || !c->desc.unbreakable[f.neighbour]) broken += pdi_body_bonds_break(body, i, &f);
    }
    return broken;
}

int64_t pd_bond_failure_break(const pd_ctx *ctx, pd_bond_failure *c, const double *u, double eager)
{
    pd_body *body = c->solid.body;
    int64_t broken = 0;
    if (!(c->critical > 0.0)) return 0;
    double most = pdi_bond_failure_find_max(ctx, c, u, pdi_bond_failure_compute_measure);
    if (!(most > c->critical))
        return c->desc.kind == PD_BOND_FAILURE_STRETCH && c->solid.stress
                   ? pdi_bond_failure_break_blind_points(ctx, c, u, eager)
                   : 0;
    double from = pdi_bond_failure_breaking_threshold(c, most, eager);
    for (int32_t i = 0; i < body->count; i++) {
        if (!(c->max_measure[i] >= from)) continue;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            if (f.neighbour >= i && pdi_bond_failure_compute_measure(c, u, i, &f) >= from)
                broken += pdi_body_bonds_break(body, i, &f);
    }
    return broken;
}

void pd_bond_failure_find_first(const pd_ctx *ctx, pd_bond_failure *c, const double *u, pd_first_failure *first)
{
    const pd_body *body = c->solid.body;
    memset(first, 0, sizeof *first);
    first->bond = -1;
    double most = c->critical > 0.0 ? pdi_bond_failure_find_max(ctx, c, u, pdi_bond_failure_inverse_load_factor) : 0.0;
    if (!(most > 0.0)) return;
    while (!(c->max_measure[first->from] >= most)) first->from++;
    pd_bond_iterator f = pd_body_bonds_begin(body, first->from);
    while (pd_body_bonds_next(&f) &&
           !(f.neighbour >= first->from && pdi_bond_failure_inverse_load_factor(c, u, first->from, &f) >= most))
        continue;
    first->bond = pdi_body_bond_number(&f);
    first->to = f.neighbour;
    first->measure = pdi_bond_failure_compute_measure(c, u, first->from, &f);
    first->factor = 1.0 / most;
    pdi_body_bond_vector(body, first->from, &f, first->midpoint);
    for (int d = 0; d < PD_DIM; d++)
        first->midpoint[d] = body->position[(int64_t)first->from * PD_DIM + d] + 0.5 * first->midpoint[d];
}

/* ---- build ---- */

/* PD_ERR_ARGUMENT: as of pd_bond_failure_build. */
static pd_status pdi_bond_failure_check(pd_ctx *ctx, const pd_material_interface *solid,
                                        const pd_bond_failure_desc *desc)
{
    int energy = desc->kind == PD_BOND_FAILURE_ENERGY;
    if ((int)desc->kind < 0 || desc->kind > PD_BOND_FAILURE_MISES)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "bond_failure", "kind %d, expected 0 to %d", (int)desc->kind,
                       (int)PD_BOND_FAILURE_MISES);
    if (!(desc->critical >= 0.0) || !(desc->critical < 1e100) || !(desc->fracture >= 0.0) ||
        !(desc->fracture < 1e100) || (desc->fracture > 0.0 && (!energy || desc->critical > 0.0)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "bond_failure",
                       "a critical value of %g and %g J/m2 of a crack: expected "
                       "one that is finite and positive, and the energy of a crack for that of bonds",
                       desc->critical, desc->fracture);
    if (desc->fracture > 0.0 && !(solid->body->spacing > 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "bond_failure",
                       "the points are those of no lattice: expected a spacing, or "
                       "a critical energy");
    if ((energy && !solid->bond_energy) || (desc->kind >= PD_BOND_FAILURE_PRINCIPAL && !solid->stress))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "bond_failure", "the %s material has no %s", solid->name,
                       energy ? "energies of bonds" : "stress");
    return PD_OK;
}

pd_status pd_bond_failure_build(pd_ctx *ctx, const pd_material_interface *solid, const pd_bond_failure_desc *desc,
                                pd_bond_failure *criterion)
{
    memset(criterion, 0, sizeof *criterion);
    pd_status status = pdi_bond_failure_check(ctx, solid, desc);
    if (status < 0) return status;
    criterion->desc = *desc;
    criterion->solid = *solid;
    criterion->critical = desc->critical;
    criterion->anisotropy = 1.0;
    if (desc->fracture > 0.0) pdi_bond_failure_calibrate(criterion);
    status = pdi_array_registry_build(ctx, pdi_bond_failure_list, criterion);
    if (status < 0) pd_bond_failure_free(ctx, criterion);
    return status;
}

void pd_bond_failure_free(pd_ctx *ctx, pd_bond_failure *criterion)
{
    pdi_array_registry_free(ctx, pdi_bond_failure_list, criterion);
    memset(criterion, 0, sizeof *criterion);
}

#undef PDI_BOND_FAILURE_TIE
#undef PDI_BOND_FAILURE_MIN_PIVOT
