/* sets: see sets.h */
#include "core/sets.h"

PDI_FN int32_t pdi_sets_root(int32_t *parent, int32_t a)
{
    while (parent[a] != a) a = parent[a] = parent[parent[a]];
    return a;
}

PDI_FN void pdi_sets_unite(int32_t *parent, int32_t a, int32_t b)
{
    a = pdi_sets_root(parent, a);
    b = pdi_sets_root(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}
