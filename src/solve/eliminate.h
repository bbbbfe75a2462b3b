/* eliminate: small dense systems of linear equations with several right-hand sides. */
#ifndef PD_ELIMINATE_H
#define PD_ELIMINATE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Gauss and Jordan with the largest pivot of each column: of the `columns` of a, whose rows are `stride` apart, those
 * behind the first `rows` are right-hand sides and become the solutions. Unknowns without a pivot get 0. */
PDI_FN void pdi_eliminate(int rows, int columns, int stride, double *a);
#endif

#endif
