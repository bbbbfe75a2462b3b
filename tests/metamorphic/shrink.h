/* shrink: the smallest scene that still shows a finding: sections, keys, factors of expressions, cells and steps are
 * taken away as long as the pair differs in the same way.
 */
#ifndef METAMORPHIC_SHRINK_H
#define METAMORPHIC_SHRINK_H
#include "compare.h"

/* Compares a scene with its transformed one. */
typedef void (*compare_pair_fn)(void *user, const scene *x, const transform *t, finding *f);

/* x and f become those of the smallest one. limit: [s] of wall time. */
void shrink_scene(compare_pair_fn compare, void *user, const transform *t, double limit, scene *x, finding *f);

#endif
