/* sets: disjoint sets of numbers 0 .. n - 1 that unite. */
#ifndef PD_SETS_H
#define PD_SETS_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* The least member of the set of a. set[n]: a member of the set of n, or n itself, as at the start. Paths to it get
 * shorter (Tarjan and van Leeuwen 1984, halving). */
PDI_FN int32_t pdi_sets_root(int32_t *set, int32_t a);
/* The sets of a and b become one. */
PDI_FN void pdi_sets_unite(int32_t *set, int32_t a, int32_t b);
#endif

#endif
