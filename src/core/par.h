/* par: OpenMP loops and thread teams, vector kernels with reproducible sums, wall clock.
 *
 * Loops run in gather form with a static schedule. Sums are taken over blocks of fixed length, and the block sums are
 * added in order: results are bitwise equal for any number of threads and without OpenMP.
 */
#ifndef PD_PAR_H
#define PD_PAR_H
#include "core/base.h"

/* Values of OMP_WAIT_POLICY and GOMP_SPINCOUNT: threads at a barrier spin for about the time of a wake-up and then
 * sleep. Endless spinning takes the core from the thread that is waited for as soon as another program runs: tens of
 * times the wall time. Barriers of a multigrid cycle are 2 to 20 us apart. 10000 spins of libgomp, some 100 us, keep a
 * thread awake until the next one, and beside a busy program runs take as long as with 1000. Other runtimes use the
 * policy. A runtime reads its environment when it is loaded: the programs and the Python package set it before. */
#define PD_OMP_WAIT_POLICY "passive"
#define PD_GOMP_SPINCOUNT "10000"

/* PD_PARALLEL_FOR(nt): before a for loop: run it on nt threads (pd_par_threads), static schedule. */
#ifdef _OPENMP
#define PDI_PRAGMA(text) _Pragma(#text)
#define PD_PARALLEL_FOR(nt) PDI_PRAGMA(omp parallel for schedule(static) num_threads(nt))
#else
#define PD_PARALLEL_FOR(nt)
#endif

#define pd_par_available_threads PD_NAME(pd_par_available_threads)
#define pd_par_clock PD_NAME(pd_par_clock)
#define pd_par_threads PD_NAME(pd_par_threads)

/* Threads for a loop of `work` scalar operations: those of ctx, or all (ctx->threads 0). 1 below 20000 operations,
 * without OpenMP, in a parallel region, where starting threads costs more, or where other programs make one thread
 * faster (thread_contention.h). pd_par_available_threads: without that last test. */
PD_API int pd_par_threads(const pd_ctx *ctx, int64_t work);
PD_API int pd_par_available_threads(const pd_ctx *ctx, int64_t work);
/* Clock [s] from an arbitrary origin: wall time with OpenMP and in WASI, else processor time. */
PD_API double pd_par_clock(void);
#ifdef PDI_INTERNAL
#ifdef _OPENMP
/* Several loops in one parallel region: PDI_PARALLEL(nt) before a block, PDI_FOR_NOWAIT before each loop in it, without
 * a barrier at its end. */
#define PDI_PARALLEL(nt) PDI_PRAGMA(omp parallel num_threads(nt))
#define PDI_FOR_NOWAIT PDI_PRAGMA(omp for schedule(static) nowait)
#define PDI_BARRIER PDI_PRAGMA(omp barrier)
#else
#define PDI_PARALLEL(nt)
#define PDI_FOR_NOWAIT
#define PDI_BARRIER
#endif
/* Call a function whose loops are marked PDI_FOR_NOWAIT in a parallel region of nt threads. One thread calls it without
 * a region, whose start would cost a system call. */
#define PDI_PARALLEL_CALL(nt, call) \
    do { \
        if ((nt) == 1) call; \
        else { \
            PDI_PARALLEL(nt) \
            call; \
        } \
    } while (0)

/* The calling thread in its team: number `rank` of `size` threads. */
typedef struct pdi_par_team {
    int rank, size;
} pdi_par_team;
/* The team of the enclosing parallel region; one thread outside of a region, or without OpenMP. */
PDI_FN pdi_par_team pdi_par_get_team(void);
/* A team of one thread. */
static inline pdi_par_team pdi_par_single_team(void)
{
    pdi_par_team team;
    team.rank = 0;
    team.size = 1;
    return team;
}
/* Call a function with the argument `team` in a parallel region of nt threads. */
#define PDI_PARALLEL_TEAM_CALL(nt, call) \
    do { \
        if ((nt) == 1) { \
            pdi_par_team team = pdi_par_single_team(); \
            call; \
        } else { \
            PDI_PARALLEL(nt) \
            { \
                pdi_par_team team = pdi_par_get_team(); \
                call; \
            } \
        } \
    } while (0)
/* Range of n items for one thread of a team: its first item, and one past its last item. */
static inline int32_t pdi_par_range_begin(pdi_par_team team, int32_t n)
{
    return (int32_t)((int64_t)n * team.rank / team.size);
}
static inline int32_t pdi_par_range_end(pdi_par_team team, int32_t n)
{
    return (int32_t)((int64_t)n * (team.rank + 1) / team.size);
}
/* Barrier of the team, with a memory flush. All threads have to call it. */
PDI_FN void pdi_par_barrier(pdi_par_team team);

/* A timed loop. pdi_par_begin_timing sets *timing and returns the number of threads for the loop; pdi_par_end_timing
 * reports its time to the contention detector of ctx, which changes despite const. A loop that has one thread available
 * is not timed. The loop does `repeats` times `work` scalar operations in one region. Loops of equal kind, work and
 * repeats are expected to take the same time. */
typedef struct pdi_par_timing {
    int threads;
    uint64_t key; /* identifies loops of equal duration */
    double work;  /* [-] scalar operations */
    double start; /* [s] */
} pdi_par_timing;
PDI_FN int pdi_par_begin_timing(const pd_ctx *ctx, int64_t work, int repeats, uint64_t kind, pdi_par_timing *timing);
PDI_FN void pdi_par_end_timing(const pd_ctx *ctx, const pdi_par_timing *timing);
/* Dot product x.y over n elements, reproducible: bitwise equal for any number of threads. 0 for n = 0. */
PDI_FN double pdi_par_dot(const pd_ctx *ctx, int64_t n, const double *x, const double *y);
/* Vectors of a Krylov basis, up to PDI_PAR_GROUP at a time. Each is stored in double or in single precision, or as
 * 16-bit integers times a scale for each block; its other pointers are NULL. */
#define PDI_PAR_GROUP 4
/* Entries of a block of integers that share a scale. */
#define PDI_PAR_QUANTISED_BLOCK 64
typedef struct pdi_par_vector_group {
    const double *doubles[PDI_PAR_GROUP];
    const float *floats[PDI_PAR_GROUP];
    const int16_t *integers[PDI_PAR_GROUP];
    const float *scales[PDI_PAR_GROUP]; /* [n / PDI_PAR_QUANTISED_BLOCK] of the integers */
} pdi_par_vector_group;
/* dots[m] = v[m].w over n elements for m < count <= PDI_PAR_GROUP, in one pass over w, reproducible. */
PDI_FN void pdi_par_multi_dot(const pd_ctx *ctx, int64_t n, int count, const pdi_par_vector_group *v, const double *w,
                              double *dots);
/* w += sum over m of a[m] v[m], in one pass over w. */
PDI_FN void pdi_par_multi_axpy(const pd_ctx *ctx, int64_t n, int count, const double *a, const pdi_par_vector_group *v,
                               double *w);
/* Number of blocks of the sums over n elements, the last of which may be shorter. */
PDI_FN int64_t pdi_par_count_blocks(int64_t n);
/* products[m] = v[m].w over the elements of one block, for m < count; one thread. */
PDI_FN void pdi_par_block_multi_dot(int64_t n, int64_t block, int count, const pdi_par_vector_group *v, const double *w,
                                    double *products);
/* w += sum over m < count of a[m] v[m] on the elements of one block; one thread. */
PDI_FN void pdi_par_block_multi_axpy(int64_t n, int64_t block, int count, const double *a,
                                     const pdi_par_vector_group *v, double *w);
/* v = a v, compressed to integer [n] with a scale for each PDI_PAR_QUANTISED_BLOCK entries, whose largest one becomes
 * INT16_MAX. v gets the decompressed values. A block whose scale would be below FLT_MIN becomes 0. */
PDI_FN void pdi_par_scale_quantise(const pd_ctx *ctx, int64_t n, double a, double *v, int16_t *integer, float *scale);
/* v = a v, with a copy in kept [n], or in single [n], to whose precision v is then rounded. The other pointer is
 * NULL. */
PDI_FN void pdi_par_scale_store(const pd_ctx *ctx, int64_t n, double a, double *v, double *kept, float *single);
/* max |x| over n elements, 0 without any; NaN if any element is NaN. */
PDI_FN double pdi_par_max_abs(const pd_ctx *ctx, int64_t n, const double *x);
/* y += a x; y = x; y = 0. */
PDI_FN void pdi_par_axpy(const pd_ctx *ctx, int64_t n, double a, const double *x, double *y);
PDI_FN void pdi_par_copy(const pd_ctx *ctx, int64_t n, const double *x, double *y);
PDI_FN void pdi_par_zero(const pd_ctx *ctx, int64_t n, double *y);

/* Compensated summation (Neumaier 1974): the total is sum + compensation; this is the accumulated rounding error. */
typedef struct pdi_compensated_sum {
    double sum, compensation; /* [unit of the terms] */
} pdi_compensated_sum;
/* Add x to the sum, which starts as zeros. */
PDI_FN void pdi_compensated_sum_add(pdi_compensated_sum *s, double x);
/* The total with its compensation. */
PDI_FN double pdi_compensated_sum_total(const pdi_compensated_sum *s);
/* Sum of x[i] over all i < n with a[i] == wanted_a and b[i] == wanted_b; 0 without any. Plain sums of 64 elements are
 * added by compensated summation. One thread, fixed order. */
PDI_FN double pdi_par_sum_where(int64_t n, const uint8_t *a, uint8_t wanted_a, const uint8_t *b, uint8_t wanted_b,
                                const double *x);
#endif

#endif
