/* arnoldi: see arnoldi.h
 *
 * A thread has the same blocks of w in all dot products and updates, so that one barrier per group of vectors is
 * enough.
 */
#include "solve/arnoldi.h"
#include <math.h>

/* [-] Orthogonalise again when the norm fell below this fraction (Daniel, Gragg, Kaufman and Stewart 1976). */
#define PDI_ARNOLDI_REORTHOGONALISE 0.1
/* Blocks whose partial sums are stored at a time. */
#define PDI_ARNOLDI_BATCH 512

/* Partial sums of blocks, shared by all threads, double-buffered: one half is read while the other one is written. */
typedef double (*pdi_arnoldi_sums)[PDI_ARNOLDI_BATCH][PDI_PAR_GROUP];

/* The arguments of one orthogonalisation, shared by all threads. */
typedef struct pdi_arnoldi_job {
    int64_t n;
    int j;
    pdi_arnoldi_basis_fn basis;
    const void *user;
    double *w, *h;
    pdi_arnoldi_sums sums; /* [2] */
    double norm_before;    /* [unit of w] |w| at the start */
} pdi_arnoldi_job;

/* State of one thread. */
typedef struct pdi_arnoldi_thread {
    pdi_par_team team;
    int half; /* half of the double buffer to write to next */
} pdi_arnoldi_thread;

/* dots[m] = v[m].w for m < count, the same bits on every thread. All threads of the team have to call it. */
static void pdi_arnoldi_dots(const pdi_arnoldi_job *q, pdi_arnoldi_thread *thread, int count,
                             const pdi_par_vector_group *v, double *dots)
{
    int64_t blocks = pdi_par_count_blocks(q->n);
    for (int m = 0; m < count; m++) dots[m] = 0.0;
    for (int64_t first = 0; first < blocks; first += PDI_ARNOLDI_BATCH) {
        int32_t batch = (int32_t)(blocks - first < PDI_ARNOLDI_BATCH ? blocks - first : PDI_ARNOLDI_BATCH);
        double(*sums)[PDI_PAR_GROUP] = q->sums[thread->half];
        for (int32_t b = pdi_par_range_begin(thread->team, batch); b < pdi_par_range_end(thread->team, batch); b++)
            pdi_par_block_multi_dot(q->n, first + b, count, v, q->w, sums[b]);
        pdi_par_barrier(thread->team);
        for (int32_t b = 0; b < batch; b++)
            for (int m = 0; m < count; m++) dots[m] += sums[b][m];
        thread->half = 1 - thread->half;
    }
}

/* w -= sum over m of dots[m] v[m], on the blocks of one thread. There is no barrier: a thread reads the same blocks in
 * the next dot products. */
static void pdi_arnoldi_subtract(const pdi_arnoldi_job *q, pdi_par_team team, int count, const pdi_par_vector_group *v,
                                 const double *dots)
{
    int64_t blocks = pdi_par_count_blocks(q->n);
    double a[PDI_PAR_GROUP];
    for (int m = 0; m < count; m++) a[m] = -dots[m];
    for (int64_t first = 0; first < blocks; first += PDI_ARNOLDI_BATCH) {
        int32_t batch = (int32_t)(blocks - first < PDI_ARNOLDI_BATCH ? blocks - first : PDI_ARNOLDI_BATCH);
        for (int32_t b = pdi_par_range_begin(team, batch); b < pdi_par_range_end(team, batch); b++)
            pdi_par_block_multi_axpy(q->n, first + b, count, a, v, q->w);
    }
}

/* |w|, the same bits on every thread. */
static double pdi_arnoldi_norm(const pdi_arnoldi_job *q, pdi_arnoldi_thread *thread)
{
    pdi_par_vector_group v;
    double square;
    v.doubles[0] = q->w;
    pdi_arnoldi_dots(q, thread, 1, &v, &square);
    return sqrt(square);
}

/* One or two passes of the orthogonalisation, as each thread of the team runs it: the second where the first leaves
 * less than PDI_ARNOLDI_REORTHOGONALISE of |w|. Thread 0 adds to h[0 .. j], which starts as zeros, and writes h[j + 1],
 * the norm after, and norm_before. */
static void pdi_arnoldi_run_thread(pdi_par_team team, pdi_arnoldi_job *q)
{
    pdi_arnoldi_thread thread;
    thread.team = team;
    thread.half = 0;
    double before = pdi_arnoldi_norm(q, &thread), norm = before;
    for (int pass = 0; pass < 2; pass++) {
        double start = norm;
        for (int i = 0; i <= q->j; i += PDI_PAR_GROUP) {
            int count = q->j + 1 - i < PDI_PAR_GROUP ? q->j + 1 - i : PDI_PAR_GROUP;
            pdi_par_vector_group v = q->basis(q->user, i);
            double dots[PDI_PAR_GROUP];
            pdi_arnoldi_dots(q, &thread, count, &v, dots);
            for (int m = 0; m < count && !team.rank; m++) q->h[i + m] += dots[m];
            pdi_arnoldi_subtract(q, team, count, &v, dots);
        }
        norm = pdi_arnoldi_norm(q, &thread);
        if (!(norm < PDI_ARNOLDI_REORTHOGONALISE * start)) break;
    }
    if (team.rank) return;
    q->h[q->j + 1] = norm;
    q->norm_before = before;
}

PDI_FN double pdi_arnoldi_orthogonalise(const pd_ctx *ctx, int64_t n, int j, pdi_arnoldi_basis_fn basis,
                                        const void *user, double *w, double *h)
{
    double sums[2][PDI_ARNOLDI_BATCH][PDI_PAR_GROUP];
    pdi_arnoldi_job job;
    int nt = pd_par_threads(ctx, 2 * n * (j + 1));
    job.n = n;
    job.j = j;
    job.basis = basis;
    job.user = user;
    job.w = w;
    job.h = h;
    job.sums = sums;
    job.norm_before = 0.0;
    for (int i = 0; i <= j; i++) h[i] = 0.0;
    PDI_PARALLEL_TEAM_CALL(nt, pdi_arnoldi_run_thread(team, &job));
    return job.norm_before;
}

#undef PDI_ARNOLDI_REORTHOGONALISE
#undef PDI_ARNOLDI_BATCH
