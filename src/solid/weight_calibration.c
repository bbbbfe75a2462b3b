/* weight_calibration: see weight_calibration.h */
#include "solid/weight_calibration.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Number of crack normals that are tried. */
#define PDI_WEIGHT_CALIBRATION_DIRECTIONS 64

/* ---- lattices ---- */

/* Number of lattice offsets along an axis of the box around a family, an odd one. */
static int pdi_weight_calibration_box_width(const pd_body *body)
{
    return 2 * (int)ceil(body->horizon / body->spacing + 0.5) + 1;
}

PDI_FN int pdi_weight_calibration_count_offsets(const pd_body *body)
{
    int wide = pdi_weight_calibration_box_width(body), all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= wide;
    return all;
}

PDI_FN double pdi_weight_calibration_get_offset(const pd_body *body, int k, double *xi)
{
    int wide = pdi_weight_calibration_box_width(body);
    double square = 0.0;
    for (int d = 0, rest = k; d < PD_DIM; d++, rest /= wide) {
        xi[d] = (rest % wide - wide / 2) * body->spacing;
        square += xi[d] * xi[d];
    }
    return square;
}

PDI_FN double pdi_weight_calibration_compute_anisotropy(double (*crack)(const void *self, const double *n),
                                                        const void *self)
{
    double least = HUGE_VAL, most = 0.0;
    for (int k = 0; k < PDI_WEIGHT_CALIBRATION_DIRECTIONS; k++) {
        double n[3] = {1.0, 0.0, 0.0}, turn = 0.5 * PD_PI * k / PDI_WEIGHT_CALIBRATION_DIRECTIONS;
        if (PD_DIM > 1) n[1] = tan(0.5 * turn);
        if (PD_DIM > 2) n[2] = n[1] * (k % 4) / 3.0;
        double energy = crack(self, n);
        least = pd_min(least, energy);
        most = pd_max(most, energy);
    }
    return most > 0.0 ? most / least : 1.0;
}

/* Sums over a complete family with the weights omega beta (base + a q), into s; s->volume has the weight beta. */
static void pdi_weight_calibration_sum_family(const pdi_weight_calibration *o, double base, double a,
                                              pdi_weight_calibration_sums *s)
{
    const pd_body *body = o->body;
    double volume = pdi_weight_calibration_cell_volume(body), xi[PD_DIM];
    memset(s, 0, sizeof *s);
    s->min_weight = HUGE_VAL;
    for (int k = 0; k < pdi_weight_calibration_count_offsets(body); k++) {
        double square = pdi_weight_calibration_get_offset(body, k, xi);
        double weight = square > 0.0 ? pdi_body_compute_bond_weight(body, o->influence, xi) : 0.0;
        double first = xi[0] * xi[0], second = PD_DIM > 1 ? xi[PD_DIM - 1] * xi[PD_DIM - 1] : 0.0;
        if (!(weight > 0.0)) continue;
        weight *= base + a * pdi_weight_calibration_cubic_harmonic(xi, square);
        s->min_weight = pd_min(s->min_weight, weight);
        weight = (double)(float)weight * volume; /* as bonds store it */
        s->weighted_volume += weight * square;
        s->axis += weight * first * first / square;
        s->cross += weight * first * second / square;
        s->volume += volume * pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi);
    }
}

PDI_FN pd_status pdi_weight_calibration_calibrate(pd_ctx *ctx, pdi_weight_calibration *o, int isotropic)
{
    pdi_weight_calibration_sums plain, cubic;
    if (!(o->body->spacing > 0.0)) return PD_OK;
    if (PD_DIM > 1 && isotropic) {
        pdi_weight_calibration_sum_family(o, 1.0, 0.0, &plain);
        pdi_weight_calibration_sum_family(o, 0.0, 1.0, &cubic);
        double odd = cubic.axis - 3.0 * cubic.cross;
        if (fabs(odd) > 0.0) o->anisotropy = (3.0 * plain.cross - plain.axis) / odd;
    }
    pdi_weight_calibration_sum_family(o, 1.0, o->anisotropy, &o->whole);
    if (o->whole.min_weight > 0.0) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "ordinary",
                   "no weights make a horizon of %g spacings the same in all "
                   "directions: use the position method, or a larger horizon",
                   o->body->horizon / o->body->spacing);
}

/* ---- weights ---- */

/* Moments of the family of point i for the correction, broken bonds too, into part [PD_DIM]: energy method: sum w r^2
 * n_d^4 V [m^(d+2)] along each axis; otherwise the family volume [m^d] in all entries. */
static void pdi_weight_calibration_compute_family_moments(const pdi_weight_calibration *o, int32_t i, double *part)
{
    const pd_body *body = o->body;
    for (int d = 0; d < PD_DIM; d++) part[d] = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double xi[PD_DIM], volume = body->volume[f.neighbour];
        pdi_body_bond_vector(body, i, &f, xi);
        double square = pdi_vec_dot(xi, xi), weight = pdi_body_compute_bond_weight(body, o->influence, xi);
        double inside = volume * pdi_body_compute_bond_weight(body, PD_INFLUENCE_CONSTANT, xi);
        weight *= 1.0 + o->anisotropy * pdi_weight_calibration_cubic_harmonic(xi, square);
        for (int d = 0; d < PD_DIM; d++)
            part[d] += o->correction == PDI_WEIGHT_CALIBRATION_ENERGY
                           ? weight * volume * xi[d] * xi[d] * xi[d] * xi[d] / square
                           : inside;
    }
}

PDI_FN double pdi_weight_calibration_correction_factor(const double *own, const double *other, const double *xi,
                                                       double bulk)
{
    double sum = 0.0, square = pdi_vec_dot(xi, xi);
    for (int d = 0; d < PD_DIM; d++) {
        double factor = 0.5 * (bulk / own[d] + bulk / other[d]);
        sum += xi[d] * xi[d] / (square * factor * factor);
    }
    return 1.0 / sqrt(sum);
}

/* Surface correction g of a bond along xi by the chosen method; own, other [PD_DIM]: family moments of both ends. */
static double pdi_weight_calibration_bond_factor(const pdi_weight_calibration *o, const double *own,
                                                 const double *other, const double *xi)
{
    if (o->correction == PDI_WEIGHT_CALIBRATION_VOLUME) return 2.0 * o->whole.volume / (own[0] + other[0]);
    return pdi_weight_calibration_correction_factor(own, other, xi, o->whole.axis);
}

/* Weight w of the current bond of point i: the pdi_bond_weights_fn of this module. Without family_moments the surface
 * correction is 1. self: pdi_weight_calibration. */
static double pdi_weight_calibration_bond_weight(const void *self, int32_t i, const pd_bond_iterator *bond)
{
    const pdi_weight_calibration *o = (const pdi_weight_calibration *)self;
    double xi[PD_DIM];
    pdi_body_bond_vector(o->body, i, bond, xi);
    double weight = pdi_body_compute_bond_weight(o->body, o->influence, xi);
    weight *= 1.0 + o->anisotropy * pdi_weight_calibration_cubic_harmonic(xi, pdi_vec_dot(xi, xi));
    if (!o->family_moments) return weight;
    return weight * pdi_weight_calibration_bond_factor(o, o->family_moments + (int64_t)i * PD_DIM,
                                                       o->family_moments + (int64_t)bond->neighbour * PD_DIM, xi);
}

PDI_FN pd_status pdi_weight_calibration_compute_weights(pd_ctx *ctx, const pdi_weight_calibration *o,
                                                        pd_bond_weights *weights)
{
    const pd_body *body = o->body;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    pdi_weight_calibration with = *o;
    double *part = NULL;
    (void)nt;
    if (o->correction != PDI_WEIGHT_CALIBRATION_NONE) {
        PD_TRY(PD_NEW(ctx, "ordinary", (int64_t)body->count * PD_DIM, part));
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < body->count; i++)
            pdi_weight_calibration_compute_family_moments(o, i, part + (int64_t)i * PD_DIM);
    }
    with.family_moments = part;
    pd_status status = pdi_bond_weights_compute(ctx, weights, pdi_weight_calibration_bond_weight, &with);
    PD_DELETE(ctx, (int64_t)body->count * PD_DIM, part);
    return status;
}

#undef PDI_WEIGHT_CALIBRATION_DIRECTIONS
