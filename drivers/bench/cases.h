/* cases: the table of all benchmarks of this dimension, in the order in which they run. */
#ifndef BENCH_CASES_H
#define BENCH_CASES_H
#include "bench.h"
#include "kernels.h"

static const bench_case *const bench_cases[] = {
    &triad_case,
    &kernels_case,
#if PD_DIM > 1
    &csr_case,
#endif
};

enum { BENCH_CASE_COUNT = (int)(sizeof bench_cases / sizeof bench_cases[0]) };

#endif
