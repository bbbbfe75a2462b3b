/* disjoint_sets: see disjoint_sets.h */
#include "core/disjoint_sets.h"

PDI_FN int32_t pdi_disjoint_sets_find_root(int32_t *parent, int32_t a)
{
    while (parent[a] != a) a = parent[a] = parent[parent[a]];
    return a;
}

PDI_FN void pdi_disjoint_sets_merge(int32_t *parent, int32_t a, int32_t b)
{
    a = pdi_disjoint_sets_find_root(parent, a);
    b = pdi_disjoint_sets_find_root(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}
