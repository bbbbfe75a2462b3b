/* disjoint_sets: union-find: disjoint sets of the numbers 0 .. n - 1. */
#ifndef PD_DISJOINT_SETS_H
#define PD_DISJOINT_SETS_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Find the root of the set of a, which is its smallest member. parent [n]: parent[k] is the parent of k, or k itself
 * where k is a root, as all are at the start. Halves the path from a in parent (Tarjan and van Leeuwen 1984). */
PDI_FN int32_t pdi_disjoint_sets_find_root(int32_t *parent, int32_t a);
/* Merge the sets of a and b: the smaller one of their roots becomes the root of both. One set stays as it is. */
PDI_FN void pdi_disjoint_sets_merge(int32_t *parent, int32_t a, int32_t b);
#endif

#endif
