/* surface_correction: see surface_correction.h */
#include "solid/surface_correction.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Regularisation: error of a moment for a multiplier of 1, of energies and third order, and of products. Products are
 * penalised more: at an edge all bonds lie in one quadrant, so no factors can restore them. */
#define PDI_SURFACE_CORRECTION_PENALTY 0.02
#define PDI_SURFACE_CORRECTION_PRODUCT_PENALTY 0.2
/* Logarithm of the largest factor, 8. */
#define PDI_SURFACE_CORRECTION_LOG_MAX_FACTOR 2.0794415416798357
/* Momentum (heavy-ball) coefficient of the sweeps: part of the last change that is added again. */
#define PDI_SURFACE_CORRECTION_MOMENTUM 0.5
/* Largest change of a multiplier in a sweep, the change at which sweeps end, and most sweeps. */
#define PDI_SURFACE_CORRECTION_MAX_STEP 1.0
#define PDI_SURFACE_CORRECTION_TOLERANCE 1e-2
#define PDI_SURFACE_CORRECTION_MAX_SWEEPS 200
/* A family whose moments are off by less counts as complete. */
#define PDI_SURFACE_CORRECTION_COMPLETE 1e-6
/* Rounding grids: x + g - g rounds x to multiples of 2^-40 with g = 3 2^11 (terms of sums), and to multiples of 2^-8
 * with g = 3 2^43 (multipliers: consecutive points then have equal ones more often, as point batches need them). */
#define PDI_SURFACE_CORRECTION_TERM_GRID 6144.0
#define PDI_SURFACE_CORRECTION_MULTIPLIER_GRID 26388279066624.0

enum { PDI_SURFACE_CORRECTION_PACKED = PD_SURFACE_CORRECTION_MOMENTS * (PD_SURFACE_CORRECTION_MOMENTS + 1) / 2 };

/* ---- moments ---- */

/* Rounds x to the grid of one of the constants above. */
static inline double pdi_surface_correction_round_to_grid(double x, double grid) { return x + grid - grid; }

/* f [PD_SURFACE_CORRECTION_MOMENTS]: the functions of the bond xi whose moments are corrected: fourth powers of its
 * direction, products of two components, harmonics of third order times length/r (eq. 15.4). Returns r [m]. */
static inline double pdi_surface_correction_compute_moments(const pdi_surface_correction *o, const double *xi,
                                                            double *f)
{
    double r = sqrt(pdi_vec_dot(xi, xi)), near = o->length / r, n[PD_DIM], s[PD_DIM];
    double *product = f + PD_DIM, *third = product + PD_SURFACE_CORRECTION_PRODUCTS;
    for (int d = 0; d < PD_DIM; d++) {
        n[d] = xi[d] / r;
        s[d] = n[d] * n[d];
        f[d] = s[d] * s[d];
    }
    for (int d = 1; d < PD_DIM; d++)
        for (int e = 0; e < d; e++) *product++ = n[d] * n[e];
    for (int d = 0; d < PD_DIM && PD_DIM > 1; d++) {
        double next = s[(d + 1) % PD_DIM], last = s[(d + PD_DIM - 1) % PD_DIM];
        *third++ = near * n[d] * (PD_DIM == 2 ? s[d] - 3.0 * next : 2.0 * s[d] - 3.0 * (next + last));
        if (PD_DIM == 3) *third++ = near * n[d] * (next - last);
    }
    if (PD_DIM == 3) *third = near * n[0] * n[PD_DIM / 2] * n[PD_DIM - 1];
    return r;
}

/* Exponent of one end: multipliers times moment functions. sign -1: of the other end, which sees -xi, so third order
 * changes its sign. */
static inline double pdi_surface_correction_exponent(const double *share, const double *f, double sign)
{
    double even = 0.0, odd = 0.0;
    for (int k = 0; k < PD_DIM + PD_SURFACE_CORRECTION_PRODUCTS; k++) even += share[k] * f[k];
    for (int k = PD_DIM + PD_SURFACE_CORRECTION_PRODUCTS; k < PD_SURFACE_CORRECTION_MOMENTS; k++)
        odd += share[k] * f[k];
    return even + sign * odd;
}

/* Correction factor at the exponent z of both ends, bounded by 8 and 1/8; *slope: its derivative. */
static inline double pdi_surface_correction_bounded_exp(double z, double *slope)
{
    double flat = 1.0 /
                  sqrt(1.0 + z * z / (PDI_SURFACE_CORRECTION_LOG_MAX_FACTOR * PDI_SURFACE_CORRECTION_LOG_MAX_FACTOR)),
           factor = exp(z * flat);
    *slope = factor * (flat * flat * flat);
    return factor;
}

PDI_FN double pdi_surface_correction_bond_factor(const pdi_surface_correction *o, const double *own,
                                                 const double *other, const double *xi)
{
    double f[PD_SURFACE_CORRECTION_MOMENTS], slope;
    pdi_surface_correction_compute_moments(o, xi, f);
    return pdi_surface_correction_bounded_exp(
        pdi_surface_correction_exponent(own, f, 1.0) + pdi_surface_correction_exponent(other, f, -1.0), &slope);
}

/* ---- shares ---- */

/* Regularisation of moment k. */
static inline double pdi_surface_correction_get_penalty(int k)
{
    return k >= PD_DIM && k < PD_DIM + PD_SURFACE_CORRECTION_PRODUCTS ? PDI_SURFACE_CORRECTION_PRODUCT_PENALTY
                                                                      : PDI_SURFACE_CORRECTION_PENALTY;
}

/* Residual of the moments of point i over axial_moment, regularised, into gap [moments]; and, unless NULL, the lower
 * triangle of the matrix [moments][moments] of (15.7). */
static void pdi_surface_correction_compute_residual(const pdi_surface_correction *o, const double *share, int32_t i,
                                                    double *gap, double *matrix)
{
    enum { all = PD_SURFACE_CORRECTION_MOMENTS };
    const pd_body *body = o->bonds->body;
    const double *own = share + (int64_t)i * all;
    for (int k = 0; k < all; k++) gap[k] = (k < PD_DIM ? 1.0 : 0.0) - pdi_surface_correction_get_penalty(k) * own[k];
    for (int k = 0; k < all * all && matrix; k++) matrix[k] = 0.0;
    for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
        double xi[PD_DIM], f[all], slope, weight;
        pdi_bond_force_compute_offset(o->bonds, i, b.neighbour, xi);
        weight = (double)pdi_bond_weights_get(o->bonds->weights, i, &b) * body->volume[b.neighbour];
        double part = weight * pdi_surface_correction_compute_moments(o, xi, f) / o->axial_moment;
        double z = pdi_surface_correction_exponent(own, f, 1.0) +
                   pdi_surface_correction_exponent(share + (int64_t)b.neighbour * all, f, -1.0);
        double factor = part * pdi_surface_correction_bounded_exp(z, &slope);
        slope *= part;
        for (int k = 0; k < all; k++)
            gap[k] -= pdi_surface_correction_round_to_grid(factor * f[k], PDI_SURFACE_CORRECTION_TERM_GRID);
        for (int k = 0; k < all && matrix; k++)
            for (int n = 0; n <= k; n++)
                matrix[k * all + n] +=
                    pdi_surface_correction_round_to_grid(slope * f[k] * f[n], PDI_SURFACE_CORRECTION_TERM_GRID);
    }
}

/* Cholesky factor, rows of the lower triangle one after another, of twice the matrix, as the other ends change alike,
 * with the penalties on the diagonal. The matrix is overwritten. */
static void pdi_surface_correction_factorise(double *matrix, float *factor)
{
    enum { all = PD_SURFACE_CORRECTION_MOMENTS };
    double least[all];
    for (int k = 0; k < all; k++) {
        for (int n = 0; n <= k; n++) matrix[k * all + n] *= 2.0;
        matrix[k * all + k] += pdi_surface_correction_get_penalty(k);
        least[k] = 0.0;
    }
    pdi_vec_cholesky(all, all, least, matrix); /* its pivots are at least the costs */
    for (int k = 0; k < all; k++)
        for (int n = 0; n <= k; n++) *factor++ = (float)matrix[k * all + n];
}

/* Solves with the packed Cholesky factor, x [moments] in place. */
static void pdi_surface_correction_substitute(const float *factor, double *x)
{
    const float *row = factor;
    for (int r = 0; r < PD_SURFACE_CORRECTION_MOMENTS; row += ++r) {
        for (int k = 0; k < r; k++) x[r] -= (double)row[k] * x[k];
        x[r] /= (double)row[r];
    }
    for (int r = PD_SURFACE_CORRECTION_MOMENTS - 1; r >= 0; r--) {
        row -= r + 1;
        x[r] /= (double)row[r];
        for (int k = 0; k < r; k++) x[k] -= (double)row[k] * x[r];
    }
}

/* Newton step of the multipliers of point i alone, bounded, plus a part of its last change; change [moments]: in: last
 * one, out: this one; share stays. fresh 1: with a new factor, which it stores; 0: with the last one. */
static void pdi_surface_correction_newton_step(const pdi_surface_correction *o, const double *share, int32_t i,
                                               int fresh, float *factor, double *change)
{
    enum { all = PD_SURFACE_CORRECTION_MOMENTS };
    double gap[all], matrix[all * all], most = 0.0;
    pdi_surface_correction_compute_residual(o, share, i, gap, fresh ? matrix : NULL);
    if (fresh) pdi_surface_correction_factorise(matrix, factor);
    pdi_surface_correction_substitute(factor, gap);
    for (int k = 0; k < all; k++) most = pd_max(most, fabs(gap[k]));
    double part = most > PDI_SURFACE_CORRECTION_MAX_STEP ? PDI_SURFACE_CORRECTION_MAX_STEP / most : 1.0;
    for (int k = 0; k < all; k++) change[k] = part * gap[k] + PDI_SURFACE_CORRECTION_MOMENTUM * change[k];
}

/* Signs (1 or -1) of the moments [moments] under a reflection; bit d of flip: n_d changes its sign. */
static void pdi_surface_correction_reflection_signs(int flip, double *sign)
{
    double *product = sign + PD_DIM, *third = product + PD_SURFACE_CORRECTION_PRODUCTS, n[PD_DIM], all = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        n[d] = flip >> d & 1 ? -1.0 : 1.0;
        all *= n[d];
        sign[d] = 1.0;
    }
    for (int d = 1; d < PD_DIM; d++)
        for (int e = 0; e < d; e++) *product++ = n[d] * n[e];
    for (int d = 0; d < PD_DIM && PD_DIM > 1; d++) {
        *third++ = n[d];
        if (PD_DIM == 3) *third++ = n[d];
    }
    if (PD_DIM == 3) *third = all;
}

/* Sets the multipliers of mirror images: those of their points, reflected. */
static void pdi_surface_correction_update_images(const pd_ctx *ctx, const pd_body *body, double *share)
{
    int nt = pd_par_threads(ctx, ((int64_t)body->count - body->real_count) * PD_SURFACE_CORRECTION_MOMENTS);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = body->real_count; i < body->count; i++) {
        const double *own = share + (int64_t)body->image_source[i - body->real_count] * PD_SURFACE_CORRECTION_MOMENTS;
        double *image = share + (int64_t)i * PD_SURFACE_CORRECTION_MOMENTS, sign[PD_SURFACE_CORRECTION_MOMENTS];
        pdi_surface_correction_reflection_signs(body->image_reflection[i - body->real_count], sign);
        for (int k = 0; k < PD_SURFACE_CORRECTION_MOMENTS; k++) image[k] = sign[k] * own[k];
    }
}

/* Lists real points with incomplete families, where a moment is off by more than 1e-6, into cut [real_count]; share:
 * zeros. Returns how many. */
static int32_t pdi_surface_correction_find_incomplete(const pd_ctx *ctx, const pdi_surface_correction *o,
                                                      const double *share, int32_t *cut)
{
    const pd_body *body = o->bonds->body;
    int nt = pd_par_threads(ctx, body->bonds * 50);
    int32_t found = 0;
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->real_count; i++) {
        double gap[PD_SURFACE_CORRECTION_MOMENTS], most = 0.0;
        pdi_surface_correction_compute_residual(o, share, i, gap, NULL);
        for (int k = 0; k < PD_SURFACE_CORRECTION_MOMENTS; k++) most = pd_max(most, fabs(gap[k]));
        cut[i] = most > PDI_SURFACE_CORRECTION_COMPLETE;
    }
    for (int32_t i = 0; i < body->real_count; i++)
        if (cut[i]) cut[found++] = i;
    return found;
}

/* Sweeps over all incomplete families until the multipliers converge, or a limit is reached, and rounds them to a grid.
 * Factors are computed anew at sweeps 0, 1, 2, 4, 8 and so on. factor, change: work for each listed point; change is
 * zero before. */
static void pdi_surface_correction_iterate(const pd_ctx *ctx, const pdi_surface_correction *o, const int32_t *cut,
                                           int32_t cuts, float *factor, double *change, double *share)
{
    enum { all = PD_SURFACE_CORRECTION_MOMENTS, packed = PDI_SURFACE_CORRECTION_PACKED };
    const pd_body *body = o->bonds->body;
    int nt = pd_par_threads(ctx, body->bonds / body->count * cuts * 150);
    (void)nt;
    for (int sweep = 0; sweep < PDI_SURFACE_CORRECTION_MAX_SWEEPS; sweep++) {
        PD_PARALLEL_FOR(nt)
        for (int32_t p = 0; p < cuts; p++)
            pdi_surface_correction_newton_step(o, share, cut[p], (sweep & (sweep - 1)) == 0,
                                               factor + (int64_t)p * packed, change + (int64_t)p * all);
        for (int32_t p = 0; p < cuts; p++)
            for (int k = 0; k < all; k++) share[(int64_t)cut[p] * all + k] += change[(int64_t)p * all + k];
        pdi_surface_correction_update_images(ctx, body, share);
        if (!(pdi_par_max_abs(ctx, (int64_t)cuts * all, change) > PDI_SURFACE_CORRECTION_TOLERANCE)) break;
    }
    for (int64_t k = 0; k < (int64_t)body->count * all; k++)
        share[k] = pdi_surface_correction_round_to_grid(share[k], PDI_SURFACE_CORRECTION_MULTIPLIER_GRID);
}

PDI_FN pd_status pdi_surface_correction_solve(pd_ctx *ctx, const pdi_surface_correction *o, double *share)
{
    int32_t count = o->bonds->body->count, own = o->bonds->body->real_count, *cut = NULL;
    double *change = NULL;
    float *factor = NULL;
    pdi_par_zero(ctx, (int64_t)count * PD_SURFACE_CORRECTION_MOMENTS, share);
    PD_TRY(PD_NEW(ctx, "mend", own, cut));
    int32_t cuts = pdi_surface_correction_find_incomplete(ctx, o, share, cut);
    int64_t room = (int64_t)(cuts > 0 ? cuts : 1) * PD_SURFACE_CORRECTION_MOMENTS,
            wide = room / PD_SURFACE_CORRECTION_MOMENTS * PDI_SURFACE_CORRECTION_PACKED;
    pd_status status = PD_NEW(ctx, "mend", room, change);
    if (status == PD_OK) status = PD_NEW(ctx, "mend", wide, factor);
    if (status == PD_OK) {
        pdi_par_zero(ctx, room, change);
        pdi_surface_correction_iterate(ctx, o, cut, cuts, factor, change, share);
    }
    PD_DELETE(ctx, wide, factor);
    PD_DELETE(ctx, room, change);
    PD_DELETE(ctx, own, cut);
    return status;
}

#undef PDI_SURFACE_CORRECTION_PENALTY
#undef PDI_SURFACE_CORRECTION_PRODUCT_PENALTY
#undef PDI_SURFACE_CORRECTION_LOG_MAX_FACTOR
#undef PDI_SURFACE_CORRECTION_MOMENTUM
#undef PDI_SURFACE_CORRECTION_MAX_STEP
#undef PDI_SURFACE_CORRECTION_TOLERANCE
#undef PDI_SURFACE_CORRECTION_MAX_SWEEPS
#undef PDI_SURFACE_CORRECTION_COMPLETE
#undef PDI_SURFACE_CORRECTION_TERM_GRID
#undef PDI_SURFACE_CORRECTION_MULTIPLIER_GRID
