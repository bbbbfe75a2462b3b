/* bond_extension: see bond_extension.h */
#include "solid/bond_extension.h"
#include "solid/mandel.h"
#include "solid/bond_stretch.h"
#include <math.h>

/* Kinematics of a loop; e = (|Y|^2 - r^2)/r^2. */
enum {
    PDI_BOND_EXTENSION_LINEAR, /* under small displacements */
    PDI_BOND_EXTENSION_SMALL,  /* with |e| up to PDI_BOND_STRETCH_SERIES_LIMIT */
    PDI_BOND_EXTENSION_ANY     /* with any e */
};

/* Which sum a loop computes. */
enum { PDI_BOND_EXTENSION_SHAPE, PDI_BOND_EXTENSION_ENERGY, PDI_BOND_EXTENSION_STRESS, PDI_BOND_EXTENSION_FORCE };

/* Rows of a sum: the entries of the moment, and that of squares behind them. */
#define PDI_BOND_EXTENSION_ROWS (PDI_SYM_COMPONENTS + 1)

/* Result of a loop over the bonds of a batch. */
typedef struct pdi_bond_extension_loop {
    double (*sum)[PD_POINT_BATCH_MAX];
    double max_e[PD_POINT_BATCH_MAX]; /* [-] largest |e| of the bonds of a point */
} pdi_bond_extension_loop;

/* Kinematics of one bond of one point of the batch. */
typedef struct pdi_bond_extension_bond {
    double xi[PD_DIM], y[PD_DIM]; /* [m] */
    double r2, inv_r2;            /* [m2] r^2, and [1/m2] 1/r^2 */
    double stretch;               /* [-] */
    double length_ratio;          /* [-] r/|Y| */
} pdi_bond_extension_bond;

/* Kinematics of a bond of point n of a batch: own and other: fields of the point and its neighbour, shift [m] of a
 * periodic image or NULL, kinematics: PDI_BOND_EXTENSION_LINEAR and so on. Linear: y = xi, stretch = eta.xi/r^2 and
 * length_ratio 1. Without its mask bit it has no stretch. max_e [PD_POINT_BATCH_MAX]: largest |e|, updated with
 * PDI_BOND_EXTENSION_SMALL alone. */
PDI_INLINE void pdi_bond_extension_compute_bond(const double *PD_RESTRICT own, const double *PD_RESTRICT other,
                                                int64_t stride, const double *shift, uint32_t mask, int kinematics,
                                                int n, double *PD_RESTRICT max_e,
                                                pdi_bond_extension_bond *PD_RESTRICT bond)
{
    double more = 0.0;
    bond->r2 = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double eta = other[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n] -
                     own[(PDI_POINT_BATCH_DISPLACEMENT + d) * stride + n];
        bond->xi[d] =
            other[(PDI_POINT_BATCH_POSITION + d) * stride + n] - own[(PDI_POINT_BATCH_POSITION + d) * stride + n];
        if (shift) bond->xi[d] += shift[d];
        bond->y[d] = bond->xi[d] + (kinematics == PDI_BOND_EXTENSION_LINEAR ? 0.0 : eta);
        bond->r2 += bond->xi[d] * bond->xi[d];
        more += eta * (kinematics == PDI_BOND_EXTENSION_LINEAR ? bond->xi[d] : bond->xi[d] + bond->y[d]);
    }
    bond->inv_r2 = 1.0 / bond->r2;
    double e = more * bond->inv_r2;
    if (mask != PDI_POINT_BATCH_FULL_MASK) e = (mask >> n & 1u) ? e : 0.0;
    bond->stretch = e;
    bond->length_ratio = 1.0;
    if (kinematics == PDI_BOND_EXTENSION_LINEAR) return;
    if (kinematics == PDI_BOND_EXTENSION_SMALL) max_e[n] = fabs(e) > max_e[n] ? fabs(e) : max_e[n];
    double pull =
        kinematics == PDI_BOND_EXTENSION_SMALL ? e * pdi_bond_stretch_factor_series(e) : pdi_bond_stretch_factor(e);
    bond->length_ratio -= pull;
    bond->stretch = pull * (1.0 + e) * bond->length_ratio;
}

/* Adds one bond to the moments A of `count` points, without the root of 2 off the diagonal; squares 1: to sum w V e^2,
 * too. */
PDI_INLINE_HOT void pdi_bond_extension_add_moment(const double *PD_RESTRICT own, const double *PD_RESTRICT other,
                                                  int64_t stride, const double *shift, double w, uint32_t mask,
                                                  int squares, int kinematics, int count, double *PD_RESTRICT max_e,
                                                  double (*PD_RESTRICT sum)[PD_POINT_BATCH_MAX])
{
    for (int n = 0; n < count; n++) {
        pdi_bond_extension_bond bond;
        pdi_bond_extension_compute_bond(own, other, stride, shift, mask, kinematics, n, max_e, &bond);
        double share = w * other[PDI_POINT_BATCH_VOLUME * stride + n] * bond.stretch;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = 0; q < PD_DIM; q++)
                if (q <= p) sum[pdi_mandel_index(p, q)][n] += share * bond.xi[p] * bond.xi[q];
        if (squares) sum[PDI_SYM_COMPONENTS][n] += share * bond.stretch * bond.r2;
    }
}

/* Adds the force of one bond to `count` points, by alpha and Q of both ends. stress 1: adds t y y^T/|y| instead, its
 * lower triangle, by alpha and Q of the point alone. Points without their mask bit get nothing. */
PDI_INLINE_HOT void pdi_bond_extension_add_force(const double *PD_RESTRICT own, const double *PD_RESTRICT other,
                                                 int64_t stride, const double *shift, double w, uint32_t mask,
                                                 int stress, int kinematics, int count, double *PD_RESTRICT max_e,
                                                 double (*PD_RESTRICT sum)[PD_POINT_BATCH_MAX])
{
    for (int n = 0; n < count; n++) {
        pdi_bond_extension_bond bond;
        double alpha = own[PDI_BOND_EXTENSION_ALPHA * stride + n], carried = 0.0;
        if (!stress) alpha += other[PDI_BOND_EXTENSION_ALPHA * stride + n];
        pdi_bond_extension_compute_bond(own, other, stride, shift, mask, kinematics, n, max_e, &bond);
        for (int p = 0; p < PD_DIM; p++) {
            double line = 0.0;
            for (int q = 0; q < PD_DIM; q++) {
                int64_t at = (PDI_BOND_EXTENSION_Q + pdi_mandel_index(p, q)) * stride + n;
                if (q <= p) line += (stress ? own[at] : own[at] + other[at]) * bond.xi[q];
            }
            carried += line * bond.xi[p];
        }
        double share = w * other[PDI_POINT_BATCH_VOLUME * stride + n] * (carried * bond.inv_r2 + alpha * bond.stretch) *
                       bond.length_ratio;
        if (mask != PDI_POINT_BATCH_FULL_MASK) share = (mask >> n & 1u) ? share : 0.0;
        for (int p = 0; p < PD_DIM && !stress; p++) sum[p][n] += share * bond.y[p];
        for (int p = 0; p < PD_DIM && stress; p++)
            for (int q = 0; q < PD_DIM; q++)
                if (q <= p) sum[pdi_mandel_index(p, q)][n] += share * bond.y[p] * bond.y[q];
    }
}

/* Adds one bond to the sum `what`. Inlined with constants for what, kinematics, shift, mask or count. */
PDI_INLINE_HOT void pdi_bond_extension_add_bond(const double *own, const double *other, int64_t stride,
                                                const double *shift, double w, uint32_t mask, int what, int kinematics,
                                                int count, pdi_bond_extension_loop *loop)
{
    if (what == PDI_BOND_EXTENSION_SHAPE || what == PDI_BOND_EXTENSION_ENERGY)
        pdi_bond_extension_add_moment(own, other, stride, shift, w, mask, what == PDI_BOND_EXTENSION_ENERGY, kinematics,
                                      count, loop->max_e, loop->sum);
    else
        pdi_bond_extension_add_force(own, other, stride, shift, w, mask, what == PDI_BOND_EXTENSION_STRESS, kinematics,
                                     count, loop->max_e, loop->sum);
}

/* Sum over all unbroken bonds of batch k with the given kinematics, into loop, which is cleared before. A batch of one
 * point takes the bonds of the body, as it has no list. Entries of the padding are of no use. Inlined with
 * constants. */
PDI_INLINE_HOT void pdi_bond_extension_sum_bonds(const pd_point_batch *band, int32_t k, int what, int kinematics,
                                                 pdi_bond_extension_loop *loop)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    int whole = pdi_point_batch_pad_count(count);
    int64_t total = band->stride;
    const double *own = pdi_point_batch_get_field(band, 0) + i;
    double shift[PD_DIM];
    for (int p = 0; p < PDI_BOND_EXTENSION_ROWS; p++)
        for (int n = 0; n < whole; n++) loop->sum[p][n] = 0.0;
    for (int n = 0; n < whole; n++) loop->max_e[n] = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(band->body, i); count == 1 && pd_body_bonds_next(&f);) {
        double w = pdi_bond_weights_get_intact(band->weights, i, &f);
        pdi_point_batch_image_shift(band->body, pdi_body_bond_image(&f), shift);
        if (w > 0.0)
            pdi_bond_extension_add_bond(own, own + (f.neighbour - i), total, shift, w, PDI_POINT_BATCH_FULL_MASK, what,
                                        kinematics, 1, loop);
    }
    for (int64_t b = band->begin[k]; b < band->begin[k + 1]; b++) {
        const double *far = own + band->bond[b].offset;
        double w = (double)band->bond[b].weight;
        uint32_t lanes = band->bond[b].mask;
        if (band->bond[b].image) {
            pdi_point_batch_image_shift(band->body, band->bond[b].image, shift);
            pdi_bond_extension_add_bond(own, far, total, shift, w, lanes, what, kinematics, whole, loop);
        } else if (lanes == PDI_POINT_BATCH_FULL_MASK)
            pdi_bond_extension_add_bond(own, far, total, NULL, w, PDI_POINT_BATCH_FULL_MASK, what, kinematics,
                                        PD_POINT_BATCH_MAX, loop);
        else pdi_bond_extension_add_bond(own, far, total, NULL, w, lanes, what, kinematics, whole, loop);
    }
}

/* Sum over batch k: linear 1: once. Otherwise by the series for small |e|, and again for all points of the batch in
 * full where a bond has |e| > PDI_BOND_STRETCH_SERIES_LIMIT. Inlined with a constant for `what`. */
PDI_INLINE_HOT void pdi_bond_extension_sum_batch(const pd_point_batch *band, int32_t k, int linear, int what,
                                                 pdi_bond_extension_loop *loop)
{
    int32_t count = band->first[k + 1] - band->first[k], n = 0;
    if (linear) {
        pdi_bond_extension_sum_bonds(band, k, what, PDI_BOND_EXTENSION_LINEAR, loop);
        return;
    }
    pdi_bond_extension_sum_bonds(band, k, what, PDI_BOND_EXTENSION_SMALL, loop);
    while (n < count && loop->max_e[n] <= PDI_BOND_STRETCH_SERIES_LIMIT) n++;
    if (n < count) pdi_bond_extension_sum_bonds(band, k, what, PDI_BOND_EXTENSION_ANY, loop);
}

PDI_FN int32_t pdi_bond_extension_compute_moment(const pd_point_batch *band, int32_t k, int linear,
                                                 double (*shape)[PD_POINT_BATCH_MAX], double *square)
{
    int32_t count = band->first[k + 1] - band->first[k];
    double sum[PDI_BOND_EXTENSION_ROWS][PD_POINT_BATCH_MAX];
    pdi_bond_extension_loop loop;
    loop.sum = sum;
    if (square) pdi_bond_extension_sum_batch(band, k, linear, PDI_BOND_EXTENSION_ENERGY, &loop);
    else pdi_bond_extension_sum_batch(band, k, linear, PDI_BOND_EXTENSION_SHAPE, &loop);
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++)
        for (int32_t n = 0; n < count; n++) shape[p][n] = p < PD_DIM ? sum[p][n] : PDI_MANDEL_SQRT2 * sum[p][n];
    for (int32_t n = 0; n < count && square; n++) square[n] = sum[PDI_SYM_COMPONENTS][n];
    return count;
}

PDI_FN void pdi_bond_extension_compute_stress(const pd_point_batch *band, int32_t k, int linear,
                                              double (*stress)[PD_POINT_BATCH_MAX])
{
    double sum[PDI_BOND_EXTENSION_ROWS][PD_POINT_BATCH_MAX];
    pdi_bond_extension_loop loop;
    loop.sum = sum;
    pdi_bond_extension_sum_batch(band, k, linear, PDI_BOND_EXTENSION_STRESS, &loop);
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++)
        for (int32_t n = 0; n < band->first[k + 1] - band->first[k]; n++) stress[p][n] = sum[p][n];
}

PDI_FN void pdi_bond_extension_set_fields(const pd_point_batch *band, int32_t i, double alpha, const double *q)
{
    double *field = pdi_point_batch_get_field(band, 0) + i;
    field[PDI_BOND_EXTENSION_ALPHA * band->stride] = alpha;
    for (int p = 0; p < PDI_SYM_COMPONENTS; p++)
        field[(PDI_BOND_EXTENSION_Q + p) * band->stride] = p < PD_DIM ? q[p] : PDI_MANDEL_SQRT2 * q[p];
}

PDI_FN void pdi_bond_extension_compute_force(const pd_point_batch *band, int32_t k, int linear, double *force)
{
    int32_t i = band->first[k], count = band->first[k + 1] - i;
    double sum[PDI_BOND_EXTENSION_ROWS][PD_POINT_BATCH_MAX];
    pdi_bond_extension_loop loop;
    loop.sum = sum;
    pdi_bond_extension_sum_batch(band, k, linear, PDI_BOND_EXTENSION_FORCE, &loop);
    for (int32_t n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) force[((int64_t)i + n) * PD_DIM + d] = sum[d][n];
}

#undef PDI_BOND_EXTENSION_ROWS
