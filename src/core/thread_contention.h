/* thread_contention: detects contention of threads with other programs, and decides between one thread and all.
 *
 * Threads of a parallel loop wait for the last one. Where another program occupies a core, all wait for its time slice,
 * which may be a thousand times the loop. Loops of known work are timed: one that takes longer than a single thread
 * would is late. When late loops lose a relevant fraction of the time, a trial runs the same loops on one thread, which
 * is kept as long as it is faster; from time to time a trial runs on all threads again.
 */
#ifndef PD_THREAD_CONTENTION_H
#define PD_THREAD_CONTENTION_H
#include "core/config.h"

enum { PD_THREAD_CONTENTION_LOOPS = 64 };

/* Timings of loops of one kind and size, on all threads [0] and on one thread [1]. */
typedef struct pd_thread_contention_loop {
    uint64_t key;
    double best;     /* [s] shortest time on all threads; 0: not measured */
    double sum[2];   /* [s] time, exponentially weighted over the last windows */
    double count[2]; /* [-] number of loops, weighted likewise */
} pd_thread_contention_loop;

/* State of the detector. Zero-initialise. */
typedef struct pd_thread_contention {
    int single_thread;   /* 1: loops run on one thread */
    int in_trial;        /* 1: the present choice is a trial */
    double window_start; /* [s] start of the present window */
    double next_trial;   /* [s] when the next trial may begin */
    double pause;  /* [s] between unsuccessful trials */
    /* [s] in this window, loops on all threads: total time, and excess over the expected time */
    double loop_time, lost_time;
    pd_thread_contention_loop loop[PD_THREAD_CONTENTION_LOOPS];
} pd_thread_contention;

#ifdef PDI_INTERNAL
/* Record one timed loop of `work` scalar operations that ran from start to end [s, monotonic clock]. `threads`: all
 * that it could have had; it ran on one of them where single_thread is set. Timings in the first 15 ms of a trial, and
 * of no duration, are ignored. A loop on all threads is late where it takes more than threads times its shortest time,
 * or than 2 ns an operation. At the end of a window (50 ms) it may change single_thread or begin a trial. Loops of one
 * key take the same time. */
PDI_FN void pdi_thread_contention_record(pd_thread_contention *pace, uint64_t key, int threads, double work,
                                         double start, double end);
#endif

#endif
