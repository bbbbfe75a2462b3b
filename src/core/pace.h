/* pace: whether several threads get on faster than one.
 *
 * Threads of a loop wait for the last of them. When another program has its processor, all of them wait for a time
 * slice of that program, which may be a thousand times the loop. Loops of known work are timed: one that takes longer
 * than one thread would need is late. When what they lose is a share that matters, one thread is tried on the same
 * loops, and keeps the work as long as it is the faster; from time to time all threads are tried again.
 */
#ifndef PD_PACE_H
#define PD_PACE_H
#include "core/config.h"

enum { PD_PACE_LOOPS = 64 };

/* Loops of one sort and size: what they took on all threads (0) and on one (1). */
typedef struct pd_pace_loop {
    uint64_t key;
    double best;     /* [s] least on all threads, 0: none */
    double sum[2];   /* [s] in the last windows of either sort, the latest counts most */
    double count[2]; /* [-] */
} pd_pace_loop;

/* Zeros are a start. */
typedef struct pd_pace {
    int one;       /* 1: one thread does all */
    int trying;    /* 1: for a trial */
    double since;  /* [s] begin of the window */
    double until;  /* [s] when the next trial may begin */
    double pause;  /* [s] between trials that fail */
    double spent, lost; /* [s] of the window, by loops on all threads */
    pd_pace_loop loop[PD_PACE_LOOPS];
} pd_pace;

#ifdef PDI_INTERNAL
/* A loop of `work` scalar operations that is worth `threads` threads ran from start to end [s, of a clock that does not
 * turn back]. Loops of one key take the same time on one machine. */
PDI_FN void pdi_pace_note(pd_pace *pace, uint64_t key, int threads, double work, double start, double end);
#endif

#endif
