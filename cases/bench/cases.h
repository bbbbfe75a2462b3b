/* cases: the table of all benchmarks of this dimension, in the order in which they run. */
#ifndef BENCH_CASES_H
#define BENCH_CASES_H
#include "bench.h"
#include "kernels.h"
#include "runs.h"
#include "species.h"
#include "solid.h"
#include "neighbour.h"
#include "study.h"
#include "volumes.h"
#include "horizon.h"

static const bench_case *const bench_cases[] = {
#if PD_DIM == 2
    &counts_case,
    &neighbour_case,
    &glass_case,
#endif
#if PD_DIM > 1
    &scenes_case,
#endif
#if PD_DIM == 2
    &species_case,
#endif
#if PD_DIM < 3
    &study_case,
#endif
    &horizon_case,
    &triad_case,
    &kernels_case,
#if PD_DIM > 1
    &csr_case,
    &scaling_case,
    &solid_case,
#endif
};

enum { BENCH_CASE_COUNT = (int)(sizeof bench_cases / sizeof bench_cases[0]) };

#endif
