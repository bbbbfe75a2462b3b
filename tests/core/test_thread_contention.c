/* A machine that is simulated: loops of known length, and a program beside that takes time slices. dims: 2 */
#include "core/thread_contention.h"
#include "random.h"
#include "test.h"

typedef struct machine {
    pd_thread_contention pace;
    double now, one; /* [s] clock, and what one thread would have taken */
    uint32_t seed;
    double slice;    /* [s] that the program beside takes of loops on both threads, 0: there is none */
    double often;    /* [-] share of the loops on both threads that wait for it; it grows with their length */
    double alone;    /* [-] by how much it slows one thread */
    double gain;     /* [-] of both threads where there is none */
    double jitter;   /* [-] of all loops */
} machine;

static double machine_random(machine *m) { return random_share(&m->seed); }

/* One loop that takes one thread `length` seconds. */
static void machine_loop(machine *m, uint64_t key, double length)
{
    double start = m->now, shake = 1.0 + m->jitter * machine_random(m);
    double alone = length * shake * (m->slice > 0.0 ? m->alone : 1.0), took = alone;
    if (!m->pace.single_thread) {
        took = length * shake / m->gain;
        if (m->slice > 0.0) {
            double wait = m->often + took / m->slice;
            if (wait >= 1.0) took += m->slice * floor(wait) / 2.0;
            if (machine_random(m) < wait) took += m->slice * machine_random(m);
        }
    }
    m->now += took;
    m->one += alone;
    pdi_thread_contention_record(&m->pace, key, 2, length / 0.5e-9, start, m->now);
}

/* Loops of three lengths for `seconds` of one thread. Returns the time against one thread. */
static double machine_run(machine *m, double length, double seconds)
{
    double begun = m->now, end = m->one + seconds, one = m->one;
    while (m->one < end) {
        machine_loop(m, 1, length);
        machine_loop(m, 2, 0.3 * length);
        machine_loop(m, 3, 3.0 * length);
        m->now += 0.1 * length; /* what no loop is */
        m->one += 0.1 * length;
    }
    return (m->now - begun) / (m->one - one);
}

static void machine_start(machine *m)
{
    memset(m, 0, sizeof *m);
    m->now = 1000.0;
    m->seed = 1;
    m->gain = 1.9;
    m->alone = 1.0;
    m->jitter = 0.2;
}

static const double lengths[] = {2e-5, 1e-4, 1e-3, 1e-2};
enum { LENGTHS = sizeof lengths / sizeof lengths[0] };

/* Nothing beside: all threads all the time, whatever the loops take. */
TEST(quiet)
{
    for (int k = 0; k < LENGTHS; k++) {
        machine m;
        machine_start(&m);
        CHECK_REL(machine_run(&m, lengths[k], 60.0), (4.3 / 1.9 + 0.1 / 1.1) / (4.3 + 0.1 / 1.1), 0.01);
        CHECK_INT(m.pace.single_thread, 0);
    }
}

/* A program beside: no more than 1.2 times the time of one thread, from slices that meet every twentieth loop to those
 * that meet all, and as well where one thread loses a third. */
TEST(busy)
{
    for (int k = 0; k < LENGTHS; k++)
        for (int n = 0; n < 24; n++) {
            static const double often[] = {0.05, 0.2, 0.5, 1.0}, slice[] = {0.001, 0.004, 0.024};
            machine m;
            machine_start(&m);
            m.often = often[n % 4];
            m.slice = slice[n / 4 % 3];
            m.alone = n < 12 ? 1.0 : 1.5;
            double ratio = machine_run(&m, lengths[k], 30.0);
            if (!CHECK_LE(ratio, 1.2)) NOTE("loops of %g s, slices of %g s in %g", lengths[k], m.slice, m.often);
        }
}

/* Threads that gain nothing at all: late by what one operation costs, never by their own best. */
TEST(always_late)
{
    machine m;
    machine_start(&m);
    m.gain = 0.1;
    CHECK_LE(machine_run(&m, 1e-4, 30.0), 1.2);
    CHECK_INT(m.pace.single_thread, 1);
}

/* When the program beside ends, all threads are back within the rest of a trial. */
TEST(comes_back)
{
    machine m;
    machine_start(&m);
    m.slice = 0.004;
    m.often = 0.5;
    machine_run(&m, 1e-4, 10.0);
    CHECK_INT(m.pace.single_thread, 1);
    m.slice = 0.0;
    machine_run(&m, 1e-4, 6.0);
    CHECK_INT(m.pace.single_thread, 0);
    CHECK_LE(machine_run(&m, 1e-4, 30.0), 0.6);
}

/* Loops that never come twice give nothing to compare, and the threads stay. */
TEST(no_loop_twice)
{
    machine m;
    machine_start(&m);
    for (uint64_t k = 1; k < 100000; k++) machine_loop(&m, k * UINT64_C(0x123456789), 1e-3);
    CHECK_LE(m.now - 1000.0, 0.6 * m.one);
}

TEST_MAIN(ENTRY(quiet) ENTRY(busy) ENTRY(always_late) ENTRY(comes_back) ENTRY(no_loop_twice))
