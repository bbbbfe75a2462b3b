/* par: threads, ordered sums, wall clock.
 *
 * Loops run in gather form with a static schedule; sums are taken over blocks of fixed length and the block
 * sums are added in order, so results are the same bits for any number of threads and without OpenMP.
 */
#ifndef PD_PAR_H
#define PD_PAR_H
#include "core/base.h"

/* How threads of OpenMP should wait for others: they spin for the time of a waking up and then sleep. A runtime that
 * spins on keeps the processor from what they wait for as soon as another program runs beside: tens of times the wall
 * time. Between two barriers of a cycle lie 2 to 20 us. With 10000 turns of libgomp, some 100 us, a thread is still
 * awake at the next one, and beside a busy program runs take as long as with 1000. Other runtimes follow the policy.
 * A runtime reads its environment when it is loaded: the programs and the Python package set it before. */
#define PD_OMP_WAIT_POLICY "passive"
#define PD_GOMP_SPINCOUNT "10000"

#ifdef PDI_INTERNAL
#ifdef _OPENMP
#define PDI_PRAGMA(text) _Pragma(#text)
/* Put before a for loop; nt comes from pdi_par_threads. */
#define PDI_PARALLEL_FOR(nt) PDI_PRAGMA(omp parallel for schedule(static) num_threads(nt))
/* Several loops under one fork: PDI_PARALLEL(nt) before a block, PDI_FOR before each loop in it. The loops do not wait
 * for each other. */
#define PDI_PARALLEL(nt) PDI_PRAGMA(omp parallel num_threads(nt))
#define PDI_FOR PDI_PRAGMA(omp for schedule(static) nowait)
#define PDI_BARRIER PDI_PRAGMA(omp barrier)
#else
#define PDI_PARALLEL_FOR(nt)
#define PDI_PARALLEL(nt)
#define PDI_FOR
#define PDI_BARRIER
#endif
/* A call of a function whose loops have PDI_FOR before them, by nt threads. One thread has no fork around it, which
 * would cost it a call of the system. */
#define PDI_SHARE(nt, call) \
    do { \
        if ((nt) == 1) call; \
        else { \
            PDI_PARALLEL(nt) \
            call; \
        } \
    } while (0)

/* Who takes a share of the work: thread `rank` of `size`. */
typedef struct pdi_par_team {
    int rank, size;
} pdi_par_team;
/* The threads of the region around the call. */
PDI_FN pdi_par_team pdi_par_here(void);
static inline pdi_par_team pdi_par_alone(void)
{
    pdi_par_team team;
    team.rank = 0;
    team.size = 1;
    return team;
}
/* A call with `team`, by nt threads in one region. */
#define PDI_TEAM(nt, call) \
    do { \
        if ((nt) == 1) { \
            pdi_par_team team = pdi_par_alone(); \
            call; \
        } else { \
            PDI_PARALLEL(nt) \
            { \
                pdi_par_team team = pdi_par_here(); \
                call; \
            } \
        } \
    } while (0)
/* Of n items the share of a thread: from the first one to that of the thread behind it. */
static inline int32_t pdi_par_first(pdi_par_team team, int32_t n)
{
    return (int32_t)((int64_t)n * team.rank / team.size);
}
static inline int32_t pdi_par_behind(pdi_par_team team, int32_t n)
{
    return (int32_t)((int64_t)n * (team.rank + 1) / team.size);
}
/* All threads of the team wait for the last one, and see what the others have written. */
PDI_FN void pdi_par_meet(pdi_par_team team);

/* Threads worth using for a loop of `work` scalar operations: 1 when the fork would cost more, or when one thread is
 * faster (pace). pdi_par_offered: without regard to pace. */
PDI_FN int pdi_par_threads(const pd_ctx *ctx, int64_t work);
PDI_FN int pdi_par_offered(const pd_ctx *ctx, int64_t work);
/* pdi_par_begin returns the threads for a loop, and pdi_par_end gives pace the time that the loop took: `times` times
 * the work in one fork. Loops of one sort, work and times take the same time. */
typedef struct pdi_par_timing {
    int threads;
    uint64_t key;
    double work;  /* [-] */
    double start; /* [s] */
} pdi_par_timing;
PDI_FN int pdi_par_begin(const pd_ctx *ctx, int64_t work, int times, uint64_t sort, pdi_par_timing *timing);
PDI_FN void pdi_par_end(const pd_ctx *ctx, const pdi_par_timing *timing);
/* Ordered sum over n elements. */
PDI_FN double pdi_par_dot(const pd_ctx *ctx, int64_t n, const double *x, const double *y);
/* dots[m] = v[m].w for m < count <= PDI_PAR_GROUP, and w += sum a[m] v[m]: one pass over w each. The vectors v are of
 * double or of single precision, or integers of 16 bits times the scale of their block; the others are NULL. */
#define PDI_PAR_GROUP 4
/* Entries that share a scale. */
#define PDI_PAR_SCALED 64
typedef struct pdi_par_vectors {
    const double *v[PDI_PAR_GROUP];
    const float *single[PDI_PAR_GROUP];
    const int16_t *integer[PDI_PAR_GROUP];
    const float *scale[PDI_PAR_GROUP]; /* [one for PDI_PAR_SCALED entries], of the integers */
} pdi_par_vectors;
PDI_FN void pdi_par_dots(const pd_ctx *ctx, int64_t n, int count, const pdi_par_vectors *v, const double *w,
                         double *dots);
PDI_FN void pdi_par_axpys(const pd_ctx *ctx, int64_t n, int count, const double *a, const pdi_par_vectors *v,
                          double *w);
/* The same for one block of ordered sums, of which n elements have so many. */
PDI_FN int64_t pdi_par_blocks(int64_t n);
PDI_FN void pdi_par_block_dots(int64_t n, int64_t block, int count, const pdi_par_vectors *v, const double *w,
                               double *products);
PDI_FN void pdi_par_block_axpys(int64_t n, int64_t block, int count, const double *a, const pdi_par_vectors *v,
                                double *w);
/* v = a v as integers of 16 bits with scales, the largest of a block INT16_MAX, and v what they stand for. */
PDI_FN void pdi_par_integers(const pd_ctx *ctx, int64_t n, double a, double *v, int16_t *integer, float *scale);
/* v = a v, kept in double precision; or in single precision, to which v is rounded. The other one is NULL. */
PDI_FN void pdi_par_keep(const pd_ctx *ctx, int64_t n, double a, double *v, double *kept, float *single);
/* max |x|; NaN if any element is NaN. */
PDI_FN double pdi_par_max_abs(const pd_ctx *ctx, int64_t n, const double *x);
/* y += a x, and y = x, and y = 0. */
PDI_FN void pdi_par_axpy(const pd_ctx *ctx, int64_t n, double a, const double *x, double *y);
PDI_FN void pdi_par_copy(const pd_ctx *ctx, int64_t n, const double *x, double *y);
PDI_FN void pdi_par_zero(const pd_ctx *ctx, int64_t n, double *y);
/* Seconds of wall time where OpenMP gives it, else of processor time. */
PDI_FN double pdi_par_clock(void);
/* Compensated running sum (Neumaier): total() = sum + carry. */
typedef struct pdi_sum {
    double sum, carry;
} pdi_sum;
PDI_FN void pdi_sum_add(pdi_sum *s, double x);
PDI_FN double pdi_sum_total(const pdi_sum *s);
/* Sum of the x with a == wanted_a and b == wanted_b, with the rounding of a few terms. One thread. */
PDI_FN double pdi_par_sum_of(int64_t n, const uint8_t *a, uint8_t wanted_a, const uint8_t *b, uint8_t wanted_b,
                             const double *x);
#endif

#endif
