/* eliminate: Gauss-Jordan elimination for small dense systems of linear equations with several right-hand sides. */
#ifndef PD_ELIMINATE_H
#define PD_ELIMINATE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Solve in place by Gauss-Jordan elimination with column pivoting. a: [rows][columns], rows `stride` apart; the first
 * `rows` columns are the matrix, the others are right-hand sides and become the solutions. Unknowns whose pivot
 * vanishes (singular matrix) get 0. */
PDI_FN void pdi_eliminate(int rows, int columns, int stride, double *a);
#endif

#endif
