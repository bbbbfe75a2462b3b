/* par: see par.h */
#include "par.h"
#include <math.h>
#include <time.h>
#ifdef _OPENMP
#include <omp.h>
#endif

/* Blocks of fixed length make the order of additions independent of the thread count. */
#define PDI_PAR_BLOCK 2048
/* Block sums are kept on the stack in batches of this many. */
#define PDI_PAR_BATCH 512

PDI_FN int pdi_par_threads(const pd_ctx *ctx, int64_t work)
{
#ifdef _OPENMP
    if (work < 20000 || omp_in_parallel()) return 1;
    return ctx->threads > 0 ? ctx->threads : omp_get_max_threads();
#else
    (void)ctx;
    (void)work;
    return 1;
#endif
}

static double pdi_par_block_dot(const double *x, const double *y, int64_t n)
{
    /* four chains let the compiler keep the adders busy without reassociating */
    double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
    int64_t i = 0;
    for (; i + 3 < n; i += 4) {
        s0 += x[i] * y[i];
        s1 += x[i + 1] * y[i + 1];
        s2 += x[i + 2] * y[i + 2];
        s3 += x[i + 3] * y[i + 3];
    }
    for (; i < n; i++) s0 += x[i] * y[i];
    return (s0 + s1) + (s2 + s3);
}

PDI_FN double pdi_par_dot(const pd_ctx *ctx, int64_t n, const double *x, const double *y)
{
    double partial[PDI_PAR_BATCH];
    double total = 0.0;
    int nt = pdi_par_threads(ctx, n);
    (void)nt;
    int64_t blocks = (n + PDI_PAR_BLOCK - 1) / PDI_PAR_BLOCK;
    for (int64_t first = 0; first < blocks; first += PDI_PAR_BATCH) {
        int count = (int)(blocks - first < PDI_PAR_BATCH ? blocks - first : PDI_PAR_BATCH);
        PDI_PARALLEL_FOR(nt)
        for (int b = 0; b < count; b++) {
            int64_t lo = (first + b) * PDI_PAR_BLOCK;
            int64_t len = n - lo < PDI_PAR_BLOCK ? n - lo : PDI_PAR_BLOCK;
            partial[b] = pdi_par_block_dot(x + lo, y + lo, len);
        }
        for (int b = 0; b < count; b++) total += partial[b];
    }
    return total;
}

PDI_FN double pdi_par_max_abs(const pd_ctx *ctx, int64_t n, const double *x)
{
    (void)ctx;
    double largest = 0.0;
    for (int64_t i = 0; i < n; i++) {
        double value = fabs(x[i]);
        if (!(value <= largest)) largest = value;
        if (largest != largest) return largest;
    }
    return largest;
}

PDI_FN void pdi_par_axpy(const pd_ctx *ctx, int64_t n, double a, const double *x, double *y)
{
    int nt = pdi_par_threads(ctx, n);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) y[i] += a * x[i];
}

PDI_FN void pdi_par_copy(const pd_ctx *ctx, int64_t n, const double *x, double *y)
{
    int nt = pdi_par_threads(ctx, n);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) y[i] = x[i];
}

PDI_FN void pdi_par_zero(const pd_ctx *ctx, int64_t n, double *y)
{
    int nt = pdi_par_threads(ctx, n);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) y[i] = 0.0;
}

PDI_FN double pdi_par_clock(void)
{
#ifdef _OPENMP
    return omp_get_wtime();
#else
    return (double)clock() / (double)CLOCKS_PER_SEC;
#endif
}

PDI_FN void pdi_sum_add(pdi_sum *s, double x)
{
    double t = s->sum + x;
    s->carry += fabs(s->sum) >= fabs(x) ? (s->sum - t) + x : (x - t) + s->sum;
    s->sum = t;
}

PDI_FN double pdi_sum_total(const pdi_sum *s) { return s->sum + s->carry; }
