/* random: numbers of tests, from the library's generator. A sequence is known by its state: give the same one twice and
 * the numbers are the same.
 */
#ifndef RANDOM_H
#define RANDOM_H
#include "core/rng.h"

/* 24 random bits. */
static inline uint32_t next_random(uint32_t *state)
{
    *state += 0x9E3779B9u;
    return (uint32_t)(pdi_rng_u64(1, 0, *state) >> 40);
}

/* In [0, 1). */
static inline double random_share(uint32_t *state) { return (double)next_random(state) / 16777216.0; }
/* In [-1, 1). */
static inline double random_real(uint32_t *state) { return 2.0 * random_share(state) - 1.0; }
static inline double random_between(uint32_t *state, double low, double high)
{
    return low + (high - low) * random_share(state);
}

#endif
