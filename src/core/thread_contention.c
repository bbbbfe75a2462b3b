/* thread_contention: see thread_contention.h */
#include "core/thread_contention.h"
#include <math.h>

/* [s] Times are compared over windows of this length: several time slices, which are 1 to 24 ms long. */
#define PDI_THREAD_CONTENTION_WINDOW 0.05
/* [-] Factor of the exponential weighting from one window to the next: the average covers a quarter of a second, since
 * one lost time slice in a window says little. */
#define PDI_THREAD_CONTENTION_MEMORY 0.8
/* [s] Times are ignored for this long after a change of the thread count: idle threads spin for up to 14 ms first. */
#define PDI_THREAD_CONTENTION_SKIP 0.015
/* [-] Tolerated fraction of the loop time that is lost: 1/6 makes loops 1.2 times as long. */
#define PDI_THREAD_CONTENTION_MAX_LOSS (1.0 / 6.0)
/* [s] One thread needs less than this for a scalar operation of a loop: 0.02e-9 to 1.6e-9 are measured. A loop that
 * takes longer is late. A machine that is slower than this makes a trial now and then. */
#define PDI_THREAD_CONTENTION_MAX_OP_TIME 2e-9
/* [-] After a trial comes a pause of this many times its length, so that trials take 1/20 of the time at most. */
#define PDI_THREAD_CONTENTION_PAUSE_FACTOR 20.0
/* [-] Fraction of that pause before the first trial of all threads: contention is mostly short. It doubles. */
#define PDI_THREAD_CONTENTION_FIRST_PAUSE 0.2
/* [s] After this time without a trial there is one even if no loop is late, since all may be: 0.3 % of the time. */
#define PDI_THREAD_CONTENTION_TRIAL_INTERVAL 10.0
/* [s] Longest pause: it doubles after each unsuccessful trial. */
#define PDI_THREAD_CONTENTION_MAX_PAUSE 30.0

/* Entry of a key in the hash table; an entry of another key in its place is emptied and becomes that of this key. */
static pd_thread_contention_loop *pdi_thread_contention_find_entry(pd_thread_contention *pace, uint64_t key)
{
    pd_thread_contention_loop *loop = &pace->loop[(key * UINT64_C(0x9e3779b97f4a7c15)) >> 58];
    if (loop->key == key) return loop;
    loop->key = key;
    loop->best = 0.0;
    for (int one = 0; one < 2; one++) loop->sum[one] = loop->count[one] = 0.0;
    return loop;
}

/* Start a new window at `now` [s] on one thread (one = 1) or all (0), as a trial where `trying` is 1. The old timings
 * of that choice are discounted, or dropped for a trial. */
static void pdi_thread_contention_begin_window(pd_thread_contention *pace, int one, int trying, double now)
{
    pace->single_thread = one;
    pace->in_trial = trying;
    pace->window_start = now;
    pace->loop_time = pace->lost_time = 0.0;
    for (int k = 0; k < PD_THREAD_CONTENTION_LOOPS; k++) {
        pace->loop[k].sum[one] *= trying ? 0.0 : PDI_THREAD_CONTENTION_MEMORY;
        pace->loop[k].count[one] *= trying ? 0.0 : PDI_THREAD_CONTENTION_MEMORY;
    }
}

/* Ratio of the time on one thread to that on all threads, for the mix of loops of the present choice, over loops that
 * have both timings. 0: there are none. */
static double pdi_thread_contention_time_ratio(const pd_thread_contention *pace)
{
    double all = 0.0, alone = 0.0;
    for (int k = 0; k < PD_THREAD_CONTENTION_LOOPS; k++) {
        const pd_thread_contention_loop *loop = &pace->loop[k];
        if (!(loop->count[0] > 0.0) || !(loop->count[1] > 0.0)) continue;
        double calls = loop->count[pace->single_thread];
        all += calls * loop->sum[0] / loop->count[0];
        alone += calls * loop->sum[1] / loop->count[1];
    }
    return all > 0.0 ? alone / all : 0.0;
}

/* End a trial: one thread where the ratio of times is below 1, else all; start a window. The next trial comes after a
 * pause of up to 20 times the trial, doubled up to 30 s where a trial of one thread fails again, and at once after a
 * return to all threads. Without comparable loops all threads are chosen, and the next trial comes soon. */
static void pdi_thread_contention_end_trial(pd_thread_contention *pace, double now)
{
    double ratio = pdi_thread_contention_time_ratio(pace),
           rest = PDI_THREAD_CONTENTION_PAUSE_FACTOR * (now - pace->window_start);
    int one = ratio > 0.0 && ratio < 1.0, failed = pace->single_thread && !one;
    if (!(ratio > 0.0)) rest *= 0.25;
    else if (failed)
        rest = pace->pause = pace->pause > 0.0 ? pd_min(2.0 * pace->pause, PDI_THREAD_CONTENTION_MAX_PAUSE) : rest;
    else if (one)
        rest = pace->pause =
            pace->single_thread ? PDI_THREAD_CONTENTION_FIRST_PAUSE * rest : pd_min(2.0 * pace->pause, rest);
    else pace->pause = 0.0;
    pace->next_trial = failed || one ? now + rest : now;
    pdi_thread_contention_begin_window(pace, one, 0, now);
}

/* End a window without a trial. Before next_trial, or on all threads while at most 1/6 of the time is lost and
 * next_trial has passed by at most 10 s, a new window of the same choice begins; else a trial of the other choice (one
 * thread, or all of them). */
static void pdi_thread_contention_end_window(pd_thread_contention *pace, double now)
{
    int late = pace->lost_time > PDI_THREAD_CONTENTION_MAX_LOSS * pace->loop_time ||
               now - pace->next_trial > PDI_THREAD_CONTENTION_TRIAL_INTERVAL;
    if (now < pace->next_trial || (!pace->single_thread && !late))
        pdi_thread_contention_begin_window(pace, pace->single_thread, 0, now);
    else pdi_thread_contention_begin_window(pace, !pace->single_thread, 1, now);
}

PDI_FN void pdi_thread_contention_record(pd_thread_contention *pace, uint64_t key, int threads, double work,
                                         double start, double end)
{
    double elapsed = end - start, slowest = PDI_THREAD_CONTENTION_MAX_OP_TIME * work;
    if (pace->window_start <= 0.0) {
        pace->next_trial = start;
        pdi_thread_contention_begin_window(pace, 0, 0, start);
    }
    if (elapsed > 0.0 && (!pace->in_trial || start - pace->window_start > PDI_THREAD_CONTENTION_SKIP)) {
        pd_thread_contention_loop *loop = pdi_thread_contention_find_entry(pace, key);
        loop->sum[pace->single_thread] += elapsed;
        loop->count[pace->single_thread] += 1.0;
        if (!pace->single_thread) {
            if (loop->best <= 0.0 || elapsed < loop->best) loop->best = elapsed;
            /* one thread takes at most the smaller of threads * best and slowest */
            if (elapsed > pd_min(threads * loop->best, slowest))
                pace->lost_time += elapsed - pd_min(loop->best, slowest);
            pace->loop_time += elapsed;
        }
    }
    if (end - pace->window_start < PDI_THREAD_CONTENTION_WINDOW + (pace->in_trial ? PDI_THREAD_CONTENTION_SKIP : 0.0))
        return;
    if (pace->in_trial) pdi_thread_contention_end_trial(pace, end);
    else pdi_thread_contention_end_window(pace, end);
}

#undef PDI_THREAD_CONTENTION_WINDOW
#undef PDI_THREAD_CONTENTION_MEMORY
#undef PDI_THREAD_CONTENTION_SKIP
#undef PDI_THREAD_CONTENTION_MAX_LOSS
#undef PDI_THREAD_CONTENTION_MAX_OP_TIME
#undef PDI_THREAD_CONTENTION_PAUSE_FACTOR
#undef PDI_THREAD_CONTENTION_FIRST_PAUSE
#undef PDI_THREAD_CONTENTION_TRIAL_INTERVAL
#undef PDI_THREAD_CONTENTION_MAX_PAUSE
