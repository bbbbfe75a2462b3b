/* rng: see rng.h */
#include "core/rng.h"
#include <math.h>

#define PDI_RNG_ROUNDS 10 /* of the generator (Salmon et al. 2011) */

PDI_FN void pdi_rng_philox(const uint32_t *counter, const uint32_t *key, uint32_t *out)
{
    uint32_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
    uint32_t k0 = key[0], k1 = key[1];
    for (int round = 0; round < PDI_RNG_ROUNDS; round++) {
        uint64_t p0 = (uint64_t)0xD2511F53u * c0;
        uint64_t p1 = (uint64_t)0xCD9E8D57u * c2;
        c0 = (uint32_t)(p1 >> 32) ^ c1 ^ k0;
        c2 = (uint32_t)(p0 >> 32) ^ c3 ^ k1;
        c1 = (uint32_t)(p1 & 0xFFFFFFFFu);
        c3 = (uint32_t)(p0 & 0xFFFFFFFFu);
        k0 += 0x9E3779B9u; /* golden ratio */
        k1 += 0xBB67AE85u; /* sqrt(3) - 1 */
    }
    out[0] = c0;
    out[1] = c1;
    out[2] = c2;
    out[3] = c3;
}

/* Two numbers of 64 random bits by Philox into pair [2]. Key: the seed. Counter: low words the counter, high words the
 * stream. */
static void pdi_rng_u64_pair(uint64_t seed, uint64_t stream, uint64_t counter, uint64_t *pair)
{
    uint32_t key[2], block[4], out[4];
    key[0] = (uint32_t)(seed & 0xFFFFFFFFu);
    key[1] = (uint32_t)(seed >> 32);
    block[0] = (uint32_t)(counter & 0xFFFFFFFFu);
    block[1] = (uint32_t)(counter >> 32);
    block[2] = (uint32_t)(stream & 0xFFFFFFFFu);
    block[3] = (uint32_t)(stream >> 32);
    pdi_rng_philox(block, key, out);
    pair[0] = ((uint64_t)out[1] << 32) | out[0];
    pair[1] = ((uint64_t)out[3] << 32) | out[2];
}

/* Uniform in (0, 1) from 64 random bits: (52 high bits + 1/2) 2^-52, symmetric about 1/2, never 0 or 1. */
static double pdi_rng_to_uniform(uint64_t bits) { return ((double)(bits >> 12) + 0.5) * (1.0 / 4503599627370496.0); }

PDI_FN uint64_t pdi_rng_u64(uint64_t seed, uint64_t stream, uint64_t counter)
{
    uint64_t pair[2];
    pdi_rng_u64_pair(seed, stream, counter, pair);
    return pair[0];
}

PDI_FN double pdi_rng_uniform(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return pdi_rng_to_uniform(pdi_rng_u64(seed, stream, counter));
}

PDI_FN void pdi_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter, double *pair)
{
    uint64_t bits[2];
    pdi_rng_u64_pair(seed, stream, counter, bits);
    double radius = sqrt(-2.0 * log(pdi_rng_to_uniform(bits[0])));
    double angle = 6.283185307179586 * pdi_rng_to_uniform(bits[1]);
    pair[0] = radius * cos(angle);
    pair[1] = radius * sin(angle);
}
