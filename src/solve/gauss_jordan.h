/* gauss_jordan: Gauss-Jordan elimination for small dense systems of linear equations with several right-hand sides. */
#ifndef PD_GAUSS_JORDAN_H
#define PD_GAUSS_JORDAN_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Solve in place by Gauss-Jordan elimination with partial pivoting (rows are exchanged). a: [rows][columns], rows
 * `stride` apart; the first `rows` columns are the matrix, which is overwritten, the others are right-hand sides and
 * become the solutions. An unknown whose pivot is at most DBL_MIN in size (singular matrix) gets 0; that is not
 * reported. */
PDI_FN void pdi_gauss_jordan_solve(int rows, int columns, int stride, double *a);
#endif

#endif
