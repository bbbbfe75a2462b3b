/* invariant: what must hold of one record, whatever the scene: balances, bounds, figures that are what their name says.
 */
#ifndef METAMORPHIC_INVARIANT_H
#define METAMORPHIC_INVARIANT_H
#include "compare.h"

/* The first one that does not hold. */
void check_record(const scene *x, const record *r, finding *f);

#endif
