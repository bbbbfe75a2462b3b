/* balance: see balance.h */
#include "solid/balance.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Most iterations. */
#define PDI_BALANCE_MOST 4000

static void pdi_balance_list(pdi_owner *owner, void *object)
{
    pdi_balance *balance = (pdi_balance *)object;
    int64_t count = balance->body ? balance->body->count : 0;
    PDI_ARRAY(owner, balance, v, count * PD_DIM, "");
    PDI_ARRAY(owner, balance, bend, count * PDI_SYM, "");
    PDI_ARRAY(owner, balance, rest, count * PD_DIM, "1/m");
    PDI_ARRAY(owner, balance, block, count * PD_DIM * PD_DIM, "");
    PDI_ARRAY(owner, balance, way, count * PD_DIM, "");
    PDI_ARRAY(owner, balance, done, count * PD_DIM, "");
    PDI_ARRAY(owner, balance, mended, count * PD_DIM, "");
}

/* xi and its dyad, and xi.(v_j - v_i)/r^2. 0: the bond is broken. */
static inline int pdi_balance_bond(const pdi_balance *s, const double *v, int32_t i, int64_t b, double *xi,
                                   double *dyad, double *along, double *weight)
{
    const double *own = v + (int64_t)i * PD_DIM, *far = v + (int64_t)s->body->column[b] * PD_DIM;
    *weight = (double)s->weight[b];
    if (!(*weight > 0.0)) return 0;
    *weight *= s->body->volume[s->body->column[b]];
    pdi_body_bond(s->body, i, b, xi);
    pdi_strain_dyad(xi, dyad);
    *along = 0.0;
    for (int d = 0; d < PD_DIM; d++) *along += xi[d] * (far[d] - own[d]);
    *along /= pdi_strain_trace(dyad);
    return 1;
}

/* bend: the strain of family i by v. */
static void pdi_balance_bend(const pdi_balance *s, const double *v, int32_t i)
{
    double xi[PD_DIM], dyad[PDI_SYM], sum[PDI_SYM] = {0.0}, along, weight;
    for (int64_t b = s->body->row[i]; b < s->body->row[i + 1]; b++) {
        if (!pdi_balance_bond(s, v, i, b, xi, dyad, &along, &weight)) continue;
        for (int p = 0; p < PDI_SYM; p++) sum[p] += weight * along * dyad[p];
    }
    pdi_strain_times(s->inverse + (int64_t)i * PDI_STRAIN_PACK, sum, s->bend + (int64_t)i * PDI_SYM);
}

/* to = -V sum_j V_j w (z_ij + z_ji) n. */
static void pdi_balance_apply(const pd_ctx *ctx, const pdi_balance *s, const double *v, double *to)
{
    const pd_body *body = s->body;
    int nt = pdi_par_threads(ctx, body->bonds * 40);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) pdi_balance_bend(s, v, i);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double xi[PD_DIM], dyad[PDI_SYM], sum[PD_DIM] = {0.0}, along, weight;
        const double *own = s->bend + (int64_t)i * PDI_SYM;
        for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
            if (!pdi_balance_bond(s, v, i, b, xi, dyad, &along, &weight)) continue;
            const double *far = s->bend + (int64_t)body->column[b] * PDI_SYM;
            double bent = 0.0;
            for (int p = 0; p < PDI_SYM; p++) bent += dyad[p] * (own[p] + far[p]);
            double t = weight * (2.0 * along - bent / pdi_strain_trace(dyad));
            for (int d = 0; d < PD_DIM; d++) sum[d] += t * xi[d];
        }
        for (int d = 0; d < PD_DIM; d++) to[(int64_t)i * PD_DIM + d] = -body->volume[i] * sum[d];
    }
}

/* Inverse blocks of the springs alone. */
static void pdi_balance_blocks(const pdi_balance *s)
{
    for (int32_t i = 0; i < s->body->count; i++) {
        double xi[PD_DIM], dyad[PDI_SYM], a[PD_DIM * PD_DIM] = {0.0}, along, weight;
        for (int64_t b = s->body->row[i]; b < s->body->row[i + 1]; b++) {
            if (!pdi_balance_bond(s, s->v, i, b, xi, dyad, &along, &weight)) continue;
            weight *= 2.0 * s->body->volume[i] / pdi_strain_trace(dyad);
            for (int p = 0; p < PD_DIM * PD_DIM; p++) a[p] += weight * xi[p / PD_DIM] * xi[p % PD_DIM];
        }
        pdi_vec_invert(a, s->block + (int64_t)i * PD_DIM * PD_DIM);
    }
}

PDI_FN pd_status pdi_balance_build(pd_ctx *ctx, const pd_body *body, const float *weight, const double *inverse,
                                   pdi_balance *balance)
{
    memset(balance, 0, sizeof *balance);
    balance->body = body;
    balance->weight = weight;
    balance->inverse = inverse;
    pd_status status = pdi_owner_build(ctx, pdi_balance_list, balance);
    if (status == PD_OK) pdi_balance_blocks(balance);
    return status;
}

PDI_FN void pdi_balance_free(pd_ctx *ctx, pdi_balance *balance)
{
    pdi_owner_free(ctx, pdi_balance_list, balance);
    memset(balance, 0, sizeof *balance);
}

static void pdi_balance_mend(const pdi_balance *s)
{
    for (int64_t i = 0; i < s->body->count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            double sum = 0.0;
            for (int q = 0; q < PD_DIM; q++)
                sum += s->block[(i * PD_DIM + p) * PD_DIM + q] * s->rest[i * PD_DIM + q];
            s->mended[i * PD_DIM + p] = sum;
        }
}

/* Conjugate gradients. */
PDI_FN pd_status pdi_balance_solve(pd_ctx *ctx, pdi_balance *s, double rounding)
{
    int64_t n = (int64_t)s->body->count * PD_DIM;
    double rho = 0.0, old;
    pdi_par_zero(ctx, n, s->v);
    for (int64_t k = 0; k < n; k++) s->rest[k] *= s->body->volume[k / PD_DIM];
    for (s->iterations = 0; s->iterations < PDI_BALANCE_MOST; s->iterations++) {
        s->residual = 0.0;
        for (int64_t k = 0; k < n; k++) s->residual = fmax(s->residual, fabs(s->rest[k]) / s->body->volume[k / PD_DIM]);
        if (s->residual <= rounding) break;
        PDI_TRY(pdi_poll(ctx, "ordinary: balance", s->iterations));
        pdi_balance_mend(s);
        old = rho;
        rho = pdi_par_dot(ctx, n, s->rest, s->mended);
        double share = s->iterations ? rho / old : 0.0;
        for (int64_t k = 0; k < n; k++) s->way[k] = s->mended[k] + share * s->way[k];
        pdi_balance_apply(ctx, s, s->way, s->done);
        double curve = pdi_par_dot(ctx, n, s->way, s->done);
        if (!(curve > 0.0)) break;
        pdi_par_axpy(ctx, n, rho / curve, s->way, s->v);
        pdi_par_axpy(ctx, n, -rho / curve, s->done, s->rest);
    }
    pdi_balance_apply(ctx, s, s->v, s->done); /* bends of v */
    return s->residual <= rounding ? PD_OK : PD_NOT_CONVERGED;
}

#undef PDI_BALANCE_MOST
