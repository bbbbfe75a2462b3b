/* equilibrium: see equilibrium.h */
#include "solid/equilibrium.h"
#include "core/par.h"
#include "core/vec.h"
#include "solve/krylov.h"
#include <math.h>
#include <string.h>

/* Sum of the loads of a piece that is not held, over the sum of their sizes, that is rounding. */
#define PDI_EQUILIBRIUM_ROUNDING 1e-9

enum { PDI_EQUILIBRIUM_BLOCK = PD_DIM * PD_DIM };

typedef struct pdi_equilibrium {
    pd_ctx *ctx;
    const pd_elastic *elastic;
    const pd_equilibrium_desc *desc;
    int64_t n;     /* components of all points */
    double *block; /* [count][PD_DIM^2] [m/N] inverse blocks */
    double *rest;  /* [n] [N] */
    double *step;  /* [n] [m] */
    pd_krylov krylov;
} pdi_equilibrium;

static void pdi_equilibrium_list(pdi_owner *owner, void *object)
{
    pdi_equilibrium *equilibrium = (pdi_equilibrium *)object;
    PDI_ARRAY(owner, equilibrium, block, equilibrium->n * PD_DIM, "m/N");
    PDI_ARRAY(owner, equilibrium, rest, equilibrium->n, "N");
    PDI_ARRAY(owner, equilibrium, step, equilibrium->n, "m");
}

static int pdi_equilibrium_held(const pdi_equilibrium *q, int64_t k) { return q->desc->held && q->desc->held[k]; }

/* y = -V force(x) of what is free. */
static void pdi_equilibrium_apply(void *user, const double *x, double *y)
{
    const pdi_equilibrium *q = (const pdi_equilibrium *)user;
    const double *volume = q->elastic->body->volume;
    pd_elastic_force(q->ctx, q->elastic, x, y);
    for (int64_t k = 0; k < q->n; k++) y[k] = pdi_equilibrium_held(q, k) ? 0.0 : -volume[k / PD_DIM] * y[k];
}

static void pdi_equilibrium_precondition(void *user, const double *x, double *y)
{
    const pdi_equilibrium *q = (const pdi_equilibrium *)user;
    for (int64_t i = 0; i < q->n / PD_DIM; i++)
        for (int a = 0; a < PD_DIM; a++) {
            const double *row = q->block + i * PDI_EQUILIBRIUM_BLOCK + a * PD_DIM;
            double sum = 0.0;
            for (int b = 0; b < PD_DIM; b++) sum += row[b] * x[i * PD_DIM + b];
            y[i * PD_DIM + a] = pdi_equilibrium_held(q, i * PD_DIM + a) ? 0.0 : sum;
        }
}

/* What a bond of point i carries when i alone moves: mu 1 + (lambda + mu) n n^T over r^2, by both families. Components
 * that are held are left out. */
static void pdi_equilibrium_blocks(const pdi_equilibrium *q)
{
    const pd_elastic *e = q->elastic;
    const pd_body *body = e->body;
    int nt = pdi_par_threads(q->ctx, body->bonds * 20);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        double a[PDI_EQUILIBRIUM_BLOCK] = {0.0}, xi[PD_DIM];
        for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
            int32_t j = body->column[b];
            pdi_body_bond(body, i, b, xi);
            double square = pdi_vec_dot(xi, xi), volumes = body->volume[i] * body->volume[j];
            double share = (double)e->weight[b] * volumes / square * (1.0 / e->total[i] + 1.0 / e->total[j]);
            for (int p = 0; p < PDI_EQUILIBRIUM_BLOCK; p++) {
                int row = p / PD_DIM, column = p % PD_DIM;
                a[p] += share * ((row == column ? e->mu : 0.0) + (e->lambda + e->mu) * xi[row] * xi[column] / square);
            }
        }
        for (int p = 0; p < PDI_EQUILIBRIUM_BLOCK; p++) {
            int64_t row = (int64_t)i * PD_DIM + p / PD_DIM, column = (int64_t)i * PD_DIM + p % PD_DIM;
            if (row != column && (pdi_equilibrium_held(q, row) || pdi_equilibrium_held(q, column))) a[p] = 0.0;
        }
        pdi_vec_invert(a, q->block + (int64_t)i * PDI_EQUILIBRIUM_BLOCK);
    }
}

static pd_status pdi_equilibrium_finite(const pdi_equilibrium *q, const double *x, const char *what)
{
    for (int64_t k = 0; x && k < q->n; k++)
        if (!(fabs(x[k]) < 1e200))
            return pdi_fail(q->ctx, PD_ERR_STATE, "equilibrium", "the %s of point %.0f is %g", what,
                            (double)(k / PD_DIM), x[k]);
    return PD_OK;
}

/* The points that bonds join to point i, into piece[0 ..]; seen marks them. Returns how many. */
static int32_t pdi_equilibrium_piece(const pd_elastic *e, int32_t i, uint8_t *seen, int32_t *piece)
{
    const pd_body *body = e->body;
    int32_t count = 1;
    piece[0] = i;
    seen[i] = 1;
    for (int32_t n = 0; n < count; n++)
        for (int64_t b = body->row[piece[n]]; b < body->row[piece[n] + 1]; b++) {
            int32_t j = body->column[b];
            if (seen[j] || !(e->weight[b] > 0.0f)) continue;
            seen[j] = 1;
            piece[count++] = j;
        }
    return count;
}

/* Refuses a piece that is loaded along an axis along which nothing holds it. */
static pd_status pdi_equilibrium_balanced(const pdi_equilibrium *q, const double *load, const int32_t *piece,
                                          int32_t count)
{
    for (int a = 0; a < PD_DIM; a++) {
        double sum = 0.0, size = 0.0;
        int held = 0;
        for (int32_t n = 0; n < count; n++) {
            int64_t k = (int64_t)piece[n] * PD_DIM + a;
            held = held || pdi_equilibrium_held(q, k);
            sum += q->elastic->body->volume[piece[n]] * load[k];
            size += q->elastic->body->volume[piece[n]] * fabs(load[k]);
        }
        if (!held && fabs(sum) > PDI_EQUILIBRIUM_ROUNDING * size)
            return pdi_fail(q->ctx, PD_ERR_STATE, "equilibrium",
                            "a piece of %d points, one of them point %d, is not held along axis %d, and its loads sum "
                            "to %g N: hold it, or balance the loads", (int)count, (int)piece[0], a, sum);
    }
    return PD_OK;
}

/* The same for all pieces. */
static pd_status pdi_equilibrium_pieces(const pdi_equilibrium *q, const double *load)
{
    int32_t *piece = NULL, all = q->elastic->body->count;
    uint8_t *seen = NULL;
    pd_status status = PDI_NEW(q->ctx, "equilibrium", all, piece);
    if (status == PD_OK) status = PDI_NEW(q->ctx, "equilibrium", all, seen);
    for (int32_t i = 0; i < all && status == PD_OK; i++) {
        if (seen[i]) continue;
        int32_t count = pdi_equilibrium_piece(q->elastic, i, seen, piece);
        status = pdi_equilibrium_balanced(q, load, piece, count);
    }
    PDI_DELETE(q->ctx, all, piece);
    PDI_DELETE(q->ctx, all, seen);
    return status;
}

static pd_status pdi_equilibrium_run(pdi_equilibrium *q, const double *load, double *u, pd_equilibrium_result *result)
{
    const double *volume = q->elastic->body->volume;
    pd_krylov_desc kd;
    pd_krylov_result linear;
    double size = 0.0;
    PDI_TRY(pdi_equilibrium_finite(q, load, "load"));
    PDI_TRY(pdi_equilibrium_finite(q, u, "displacement"));
    if (load) PDI_TRY(pdi_equilibrium_pieces(q, load));
    PDI_TRY(pdi_owner_build(q->ctx, pdi_equilibrium_list, q));
    memset(&kd, 0, sizeof kd);
    kd.method = PD_KRYLOV_CG;
    kd.n = q->n;
    kd.components = 1;
    kd.zero_guess = 1;
    kd.rtol = 1e-15;
    kd.max_iterations = q->desc->max_iterations > 0 ? q->desc->max_iterations : 10000;
    PDI_TRY(pdi_krylov_build(q->ctx, &kd, &q->krylov));
    pdi_equilibrium_blocks(q);
    /* the loads, and what is held as it pulls on points that have not moved, are the size of the problem */
    for (int64_t k = 0; k < q->n; k++) q->step[k] = pdi_equilibrium_held(q, k) ? u[k] : 0.0;
    pdi_equilibrium_apply(q, q->step, q->rest);
    for (int64_t k = 0; k < q->n; k++) {
        double given = (load && !pdi_equilibrium_held(q, k) ? volume[k / PD_DIM] * load[k] : 0.0) - q->rest[k];
        size += given * given;
    }
    size = sqrt(size);
    pdi_equilibrium_apply(q, u, q->rest);
    for (int64_t k = 0; k < q->n; k++) {
        double given = load && !pdi_equilibrium_held(q, k) ? volume[k / PD_DIM] * load[k] : 0.0;
        q->rest[k] = given - q->rest[k];
    }
    q->krylov.desc.atol = size * (q->desc->rtol > 0.0 ? q->desc->rtol : 1e-10);
    pd_status status = pdi_krylov_solve(q->ctx, &q->krylov, pdi_equilibrium_apply, pdi_equilibrium_precondition, q,
                                        q->rest, q->step, &linear);
    if (status == PD_ERR_DIVERGED)
        return pdi_fail(q->ctx, status, "equilibrium", "the body can turn, and its loads turn it: hold it, or balance "
                        "their moments");
    if (status < 0) return status;
    for (int64_t k = 0; k < q->n; k++) u[k] += q->step[k];
    result->iterations = linear.iterations;
    result->residual = size > 0.0 ? linear.residual / size : 0.0;
    return status;
}

pd_status pd_equilibrium_solve(pd_ctx *ctx, const pd_elastic *elastic, const pd_equilibrium_desc *desc,
                                       const double *load, double *u, pd_equilibrium_result *result)
{
    pdi_equilibrium q;
    memset(&q, 0, sizeof q);
    memset(result, 0, sizeof *result);
    q.ctx = ctx;
    q.elastic = elastic;
    q.desc = desc;
    q.n = (int64_t)elastic->body->count * PD_DIM;
    pd_status status = pdi_equilibrium_run(&q, load, u, result);
    pdi_krylov_free(ctx, &q.krylov);
    pdi_owner_free(ctx, pdi_equilibrium_list, &q);
    return status;
}

#undef PDI_EQUILIBRIUM_ROUNDING
