/* par: see par.h */
#include "core/par.h"
#include <math.h>
#include <string.h>
#include <time.h>
#if defined(__wasi__)
#include <wasi/api.h>
#endif
#ifdef _OPENMP
#include <omp.h>
#endif

/* Blocks of fixed length make the order of additions independent of the thread count. */
#define PDI_PAR_BLOCK 2048
/* Independent partial sums in a block. */
#define PDI_PAR_PARTIAL_SUMS 16
/* Least scalar operations of a loop that pay for several threads: 10 us on one thread. A barrier takes spinning threads
 * 1 us, sleeping ones 50. */
#define PDI_PAR_MIN_WORK 20000
/* Block sums are kept on the stack in batches of this many. */
#define PDI_PAR_BATCH 512

int pd_par_available_threads(const pd_ctx *ctx, int64_t work)
{
#ifdef _OPENMP
    if (work < PDI_PAR_MIN_WORK || omp_in_parallel()) return 1;
    return ctx->threads > 0 ? ctx->threads : omp_get_max_threads();
#else
    (void)ctx;
    (void)work;
    return 1;
#endif
}

int pd_par_threads(const pd_ctx *ctx, int64_t work)
{
    int offered = pd_par_available_threads(ctx, work);
    return offered > 1 && ctx->contention.single_thread ? 1 : offered;
}

PDI_FN int pdi_par_begin_timing(const pd_ctx *ctx, int64_t work, int repeats, uint64_t kind, pdi_par_timing *timing)
{
    timing->threads = pd_par_available_threads(ctx, work);
    if (timing->threads == 1) return 1;
    timing->key = (((uint64_t)work * UINT64_C(0x9e3779b97f4a7c15) ^ kind) * 16 + (uint64_t)repeats) * 1024 +
                 (uint64_t)timing->threads;
    timing->work = (double)work * repeats;
    timing->start = pd_par_clock();
    return ctx->contention.single_thread ? 1 : timing->threads;
}

/* The cast is safe: a context object is never const, and its detector is a cache. */
PDI_FN void pdi_par_end_timing(const pd_ctx *ctx, const pdi_par_timing *timing)
{
    if (timing->threads == 1) return;
    pdi_thread_contention_record(&((pd_ctx *)ctx)->contention, timing->key, timing->threads, timing->work,
                                 timing->start, pd_par_clock());
}

PDI_FN pdi_par_team pdi_par_get_team(void)
{
    pdi_par_team team = pdi_par_single_team();
#ifdef _OPENMP
    team.rank = omp_get_thread_num();
    team.size = omp_get_num_threads();
#endif
    return team;
}

PDI_FN void pdi_par_barrier(pdi_par_team team)
{
    if (team.size == 1) return;
    PDI_BARRIER
}

/* x.y over n entries of one block, in double precision. */
static double pdi_par_block_dot(const double *x, const double *y, int64_t n)
{
    /* chains let the compiler use vectors without reassociating */
    double s[PDI_PAR_PARTIAL_SUMS], total = 0.0;
    int64_t i = 0;
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] = 0.0;
    for (; i + PDI_PAR_PARTIAL_SUMS <= n; i += PDI_PAR_PARTIAL_SUMS)
        for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] += x[i + c] * y[i + c];
    for (int c = 0; i < n; i++, c++) s[c] += x[i] * y[i];
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) total += s[c];
    return total;
}

/* x.y over n entries of one block with x in single precision. */
static double pdi_par_block_dot_single(const float *x, const double *y, int64_t n)
{
    double s[PDI_PAR_PARTIAL_SUMS], total = 0.0;
    int64_t i = 0;
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] = 0.0;
    for (; i + PDI_PAR_PARTIAL_SUMS <= n; i += PDI_PAR_PARTIAL_SUMS)
        for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] += (double)x[i + c] * y[i + c];
    for (int c = 0; i < n; i++, c++) s[c] += (double)x[i] * y[i];
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) total += s[c];
    return total;
}

/* x.y over n entries of one block, x as integers times scales, one for PDI_PAR_QUANTISED_BLOCK entries from x[0] on. */
static double pdi_par_block_dot_quantised(const int16_t *x, const float *scale, const double *y, int64_t n)
{
    double s[PDI_PAR_PARTIAL_SUMS], total = 0.0;
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] = 0.0;
    for (int64_t lo = 0; lo < n; lo += PDI_PAR_QUANTISED_BLOCK) {
        double part[PDI_PAR_PARTIAL_SUMS], factor = (double)scale[lo / PDI_PAR_QUANTISED_BLOCK];
        int64_t i = lo, hi = n - lo < PDI_PAR_QUANTISED_BLOCK ? n : lo + PDI_PAR_QUANTISED_BLOCK;
        for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) part[c] = 0.0;
        for (; i + PDI_PAR_PARTIAL_SUMS <= hi; i += PDI_PAR_PARTIAL_SUMS)
            for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) part[c] += (double)x[i + c] * y[i + c];
        for (int c = 0; i < hi; i++, c++) part[c] += (double)x[i] * y[i];
        for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) s[c] += factor * part[c];
    }
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) total += s[c];
    return total;
}

/* v[m].w over n entries from lo on, a multiple of PDI_PAR_QUANTISED_BLOCK, in the precision of v[m]. */
static double pdi_par_block_dot_any(const pdi_par_vector_group *v, int m, const double *w, int64_t lo, int64_t n)
{
    if (v->doubles[m]) return pdi_par_block_dot(v->doubles[m] + lo, w + lo, n);
    if (v->floats[m]) return pdi_par_block_dot_single(v->floats[m] + lo, w + lo, n);
    return pdi_par_block_dot_quantised(v->integers[m] + lo, v->scales[m] + lo / PDI_PAR_QUANTISED_BLOCK, w + lo, n);
}

PDI_FN int64_t pdi_par_count_blocks(int64_t n) { return (n + PDI_PAR_BLOCK - 1) / PDI_PAR_BLOCK; }

PDI_FN void pdi_par_block_multi_dot(int64_t n, int64_t block, int count, const pdi_par_vector_group *v, const double *w,
                                    double *products)
{
    int64_t lo = block * PDI_PAR_BLOCK, length = n - lo < PDI_PAR_BLOCK ? n - lo : PDI_PAR_BLOCK;
    for (int m = 0; m < count; m++) products[m] = pdi_par_block_dot_any(v, m, w, lo, length);
}

/* partial[b][m] = v[m].w over the blocks first + b, b < batch: the part of one thread. */
static void pdi_par_batch_multi_dot(int64_t n, int64_t first, int batch, int count, const pdi_par_vector_group *v,
                                    const double *w, double (*partial)[PDI_PAR_GROUP])
{
    PDI_FOR_NOWAIT
    for (int b = 0; b < batch; b++) pdi_par_block_multi_dot(n, first + b, count, v, w, partial[b]);
}

PDI_FN void pdi_par_multi_dot(const pd_ctx *ctx, int64_t n, int count, const pdi_par_vector_group *v, const double *w,
                              double *dots)
{
    double partial[PDI_PAR_BATCH][PDI_PAR_GROUP];
    pdi_par_timing timing;
    int nt = pdi_par_begin_timing(ctx, n, count, 0, &timing);
    int64_t blocks = (n + PDI_PAR_BLOCK - 1) / PDI_PAR_BLOCK;
    for (int m = 0; m < count; m++) dots[m] = 0.0;
    for (int64_t first = 0; first < blocks; first += PDI_PAR_BATCH) {
        int batch = (int)(blocks - first < PDI_PAR_BATCH ? blocks - first : PDI_PAR_BATCH);
        PDI_PARALLEL_CALL(nt, pdi_par_batch_multi_dot(n, first, batch, count, v, w, partial));
        for (int b = 0; b < batch; b++)
            for (int m = 0; m < count; m++) dots[m] += partial[b][m];
    }
    pdi_par_end_timing(ctx, &timing);
}

/* w += a x over n entries, x as integers times scales, one for PDI_PAR_QUANTISED_BLOCK entries from x[0] on. */
static void pdi_par_axpy_quantised(int64_t n, double a, const int16_t *x, const float *scale, double *w)
{
    for (int64_t lo = 0; lo < n; lo += PDI_PAR_QUANTISED_BLOCK) {
        int64_t hi = n - lo < PDI_PAR_QUANTISED_BLOCK ? n : lo + PDI_PAR_QUANTISED_BLOCK;
        double factor = a * (double)scale[lo / PDI_PAR_QUANTISED_BLOCK];
        for (int64_t i = lo; i < hi; i++) w[i] += factor * (double)x[i];
    }
}

PDI_FN void pdi_par_block_multi_axpy(int64_t n, int64_t block, int count, const double *a,
                                     const pdi_par_vector_group *v, double *w)
{
    int64_t lo = block * PDI_PAR_BLOCK, hi = n - lo < PDI_PAR_BLOCK ? n : lo + PDI_PAR_BLOCK;
    for (int m = 0; m < count; m++) {
        const double *x = v->doubles[m];
        const float *single = v->floats[m];
        double factor = a[m];
        for (int64_t i = lo; x && i < hi; i++) w[i] += factor * x[i];
        for (int64_t i = lo; !x && single && i < hi; i++) w[i] += factor * (double)single[i];
        if (!x && !single)
            pdi_par_axpy_quantised(hi - lo, factor, v->integers[m] + lo, v->scales[m] + lo / PDI_PAR_QUANTISED_BLOCK,
                                   w + lo);
    }
}

/* w += sum over m of a[m] v[m]: the part of one thread. */
static void pdi_par_multi_axpy_thread(int64_t n, int count, const double *a, const pdi_par_vector_group *v, double *w)
{
    PDI_FOR_NOWAIT
    for (int64_t b = 0; b < pdi_par_count_blocks(n); b++) pdi_par_block_multi_axpy(n, b, count, a, v, w);
}

PDI_FN void pdi_par_multi_axpy(const pd_ctx *ctx, int64_t n, int count, const double *a, const pdi_par_vector_group *v,
                               double *w)
{
    pdi_par_timing timing;
    int nt = pdi_par_begin_timing(ctx, n, count, 1, &timing);
    PDI_PARALLEL_CALL(nt, pdi_par_multi_axpy_thread(n, count, a, v, w));
    pdi_par_end_timing(ctx, &timing);
}

/* v = a v, compressed to rounded integers with one scale for each block, max |v| / INT16_MAX, or 0 where that is at
 * most FLT_MIN; v gets the decompressed values: the part of one thread. */
static void pdi_par_quantise_thread(int64_t n, double a, double *v, int16_t *integer, float *scale)
{
    PDI_FOR_NOWAIT
    for (int64_t block = 0; block < (n + PDI_PAR_QUANTISED_BLOCK - 1) / PDI_PAR_QUANTISED_BLOCK; block++) {
        int64_t lo = block * PDI_PAR_QUANTISED_BLOCK,
                hi = n - lo < PDI_PAR_QUANTISED_BLOCK ? n : lo + PDI_PAR_QUANTISED_BLOCK;
        double largest = 0.0;
        for (int64_t i = lo; i < hi; i++) {
            v[i] *= a;
            double size = fabs(v[i]);
            largest = size > largest ? size : largest;
        }
        largest /= INT16_MAX;
        scale[block] = largest > FLT_MIN ? (float)largest : 0.0f;
        double back = (double)scale[block], unit = back > 0.0 ? 1.0 / back : 0.0;
        for (int64_t i = lo; i < hi; i++) {
            double x = v[i] * unit;
            int32_t q = (int32_t)(x + (x < 0.0 ? -0.5 : 0.5)); /* no more: a scale has 24 bits */
            integer[i] = (int16_t)q;
            v[i] = back * (double)q;
        }
    }
}

/* v = a v with a copy in double or single precision; with single, v is rounded to it. NULL: no such copy. The part of
 * one thread. */
static void pdi_par_scale_store_thread(int64_t n, double a, double *PD_RESTRICT v, double *PD_RESTRICT kept,
                                       float *PD_RESTRICT single)
{
    PDI_FOR_NOWAIT
    for (int64_t b = 0; b < pdi_par_count_blocks(n); b++) {
        int64_t lo = b * PDI_PAR_BLOCK, hi = n - lo < PDI_PAR_BLOCK ? n : lo + PDI_PAR_BLOCK;
        for (int64_t i = lo; i < hi; i++) v[i] *= a;
        for (int64_t i = lo; kept && i < hi; i++) kept[i] = v[i];
        for (int64_t i = lo; single && i < hi; i++) single[i] = (float)v[i];
        for (int64_t i = lo; single && i < hi; i++) v[i] = (double)single[i];
    }
}

PDI_FN void pdi_par_scale_store(const pd_ctx *ctx, int64_t n, double a, double *v, double *kept, float *single)
{
    int nt = pd_par_threads(ctx, n);
    PDI_PARALLEL_CALL(nt, pdi_par_scale_store_thread(n, a, v, kept, single));
}

PDI_FN void pdi_par_scale_quantise(const pd_ctx *ctx, int64_t n, double a, double *v, int16_t *integer, float *scale)
{
    int nt = pd_par_threads(ctx, n);
    PDI_PARALLEL_CALL(nt, pdi_par_quantise_thread(n, a, v, integer, scale));
}

PDI_FN double pdi_par_dot(const pd_ctx *ctx, int64_t n, const double *x, const double *y)
{
    double dot;
    pdi_par_vector_group v;
    v.doubles[0] = x;
    pdi_par_multi_dot(ctx, n, 1, &v, y, &dot);
    return dot;
}

/* max |x| over n entries; NaN if any of them is NaN. */
static double pdi_par_block_max(const double *x, int64_t n)
{
    double largest[PDI_PAR_PARTIAL_SUMS], most = 0.0;
    int64_t i = 0, nan_count = 0;
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) largest[c] = 0.0;
    for (; i + PDI_PAR_PARTIAL_SUMS <= n; i += PDI_PAR_PARTIAL_SUMS)
        for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) {
            double value = fabs(x[i + c]);
            largest[c] = value > largest[c] ? value : largest[c];
            nan_count += value != value;
        }
    for (; i < n; i++) {
        double value = fabs(x[i]);
        most = value > most ? value : most;
        nan_count += value != value;
    }
    for (int c = 0; c < PDI_PAR_PARTIAL_SUMS; c++) most = largest[c] > most ? largest[c] : most;
    return nan_count ? NAN : most;
}

PDI_FN double pdi_par_max_abs(const pd_ctx *ctx, int64_t n, const double *x)
{
    double partial[PDI_PAR_BATCH], largest = 0.0;
    int nt = pd_par_threads(ctx, n);
    (void)nt;
    if (nt == 1) return pdi_par_block_max(x, n);
    int64_t blocks = (n + PDI_PAR_BLOCK - 1) / PDI_PAR_BLOCK;
    for (int64_t first = 0; first < blocks; first += PDI_PAR_BATCH) {
        int batch = (int)(blocks - first < PDI_PAR_BATCH ? blocks - first : PDI_PAR_BATCH);
        PD_PARALLEL_FOR(nt)
        for (int b = 0; b < batch; b++) {
            int64_t lo = (first + b) * PDI_PAR_BLOCK;
            partial[b] = pdi_par_block_max(x + lo, n - lo < PDI_PAR_BLOCK ? n - lo : PDI_PAR_BLOCK);
        }
        for (int b = 0; b < batch; b++) {
            if (partial[b] != partial[b]) return partial[b];
            largest = partial[b] > largest ? partial[b] : largest;
        }
    }
    return largest;
}

/* y += a x: the part of one thread. */
static void pdi_par_axpy_thread(int64_t n, double a, const double *x, double *y)
{
    PDI_FOR_NOWAIT
    for (int64_t i = 0; i < n; i++) y[i] += a * x[i];
}

PDI_FN void pdi_par_axpy(const pd_ctx *ctx, int64_t n, double a, const double *x, double *y)
{
    int nt = pd_par_threads(ctx, n);
    PDI_PARALLEL_CALL(nt, pdi_par_axpy_thread(n, a, x, y));
}

PDI_FN void pdi_par_copy(const pd_ctx *ctx, int64_t n, const double *x, double *y)
{
    int nt = pd_par_threads(ctx, n);
    if (nt == 1) {
        if (n > 0) memmove(y, x, (size_t)n * sizeof *y);
        return;
    }
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) y[i] = x[i];
}

PDI_FN void pdi_par_zero(const pd_ctx *ctx, int64_t n, double *y)
{
    int nt = pd_par_threads(ctx, n);
    if (nt == 1) {
        if (n > 0) memset(y, 0, (size_t)n * sizeof *y);
        return;
    }
    PD_PARALLEL_FOR(nt)
    for (int64_t i = 0; i < n; i++) y[i] = 0.0;
}

double pd_par_clock(void)
{
#ifdef _OPENMP
    return omp_get_wtime();
#elif defined(__wasi__) /* its C library has no clock() */
    __wasi_timestamp_t now = 0; /* [ns] */
    return __wasi_clock_time_get(__WASI_CLOCKID_MONOTONIC, 1000, &now) == 0 ? 1e-9 * (double)now : 0.0;
#else
    return (double)clock() / (double)CLOCKS_PER_SEC;
#endif
}

PDI_FN void pdi_compensated_sum_add(pdi_compensated_sum *s, double x)
{
    double t = s->sum + x;
    s->compensation += fabs(s->sum) >= fabs(x) ? (s->sum - t) + x : (x - t) + s->sum;
    s->sum = t;
}

PDI_FN double pdi_compensated_sum_total(const pdi_compensated_sum *s) { return s->sum + s->compensation; }

PDI_FN double pdi_par_sum_where(int64_t n, const uint8_t *a, uint8_t wanted_a, const uint8_t *b, uint8_t wanted_b,
                                const double *x)
{
    enum { lanes = 8, block = 64 };
    pdi_compensated_sum sum = {0.0, 0.0};
    int64_t i = 0;
    for (; i + block <= n; i += block) {
        double lane[lanes] = {0.0};
        for (int64_t k = i; k < i + block; k += lanes)
            for (int l = 0; l < lanes; l++)
                lane[l] += ((a[k + l] == wanted_a) & (b[k + l] == wanted_b)) ? x[k + l] : 0.0;
        pdi_compensated_sum_add(&sum, ((lane[0] + lane[1]) + (lane[2] + lane[3])) +
                                          ((lane[4] + lane[5]) + (lane[6] + lane[7])));
    }
    for (; i < n; i++) pdi_compensated_sum_add(&sum, a[i] == wanted_a && b[i] == wanted_b ? x[i] : 0.0);
    return pdi_compensated_sum_total(&sum);
}
