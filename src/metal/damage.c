/* damage: see damage.h */
#include "metal/damage.h"
#include "core/rng.h"
#include <math.h>

static double pdi_damage_number(uint64_t seed, int32_t node, int bond)
{
    return pdi_rng_uniform(seed, (uint64_t)node, (uint64_t)bond);
}

PDI_FN double pdi_damage_broken(uint64_t seed, int32_t node, int bonds, double expected)
{
    int broken = 0;
    for (int b = 0; b < bonds; b++) broken += pdi_damage_number(seed, node, b) <= expected;
    return bonds ? (double)broken / bonds : expected;
}

PDI_FN double pdi_damage_last(uint64_t seed, int32_t node, int bonds)
{
    double last = 0.0;
    for (int b = 0; b < bonds; b++) last = pd_max(last, pdi_damage_number(seed, node, b));
    return bonds ? last : 1.0;
}
