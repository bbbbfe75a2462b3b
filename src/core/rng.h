/* rng: counter-based random numbers. A number depends on (seed, stream, counter) alone: no state, no order of calls,
 * the same for any thread count and on every machine.
 */
#ifndef PD_RNG_H
#define PD_RNG_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Philox 4x32, 10 rounds: out[4] from counter[4] and key[2].
 * Source: Salmon, Moraes, Dror, Shaw 2011, "Parallel random numbers: as easy as 1, 2, 3". */
PDI_FN void pdi_rng_philox(const uint32_t *counter, const uint32_t *key, uint32_t *out);
/* 64 random bits, a pure function of the arguments. */
PDI_FN uint64_t pdi_rng_u64(uint64_t seed, uint64_t stream, uint64_t counter);
/* Uniform in the open interval (0, 1): odd multiples of 2^-53. */
PDI_FN double pdi_rng_uniform(uint64_t seed, uint64_t stream, uint64_t counter);
/* Two independent standard normal numbers (Box-Muller) into pair [2], a pure function of the other arguments. */
PDI_FN void pdi_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter, double *pair);
#endif

#endif
