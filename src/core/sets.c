/* sets: see sets.h */
#include "core/sets.h"

PDI_FN int32_t pdi_sets_root(int32_t *set, int32_t a)
{
    while (set[a] != a) a = set[a] = set[set[a]];
    return a;
}

PDI_FN void pdi_sets_unite(int32_t *set, int32_t a, int32_t b)
{
    a = pdi_sets_root(set, a);
    b = pdi_sets_root(set, b);
    if (a < b) set[b] = a;
    else set[a] = b;
}
