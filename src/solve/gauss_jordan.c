/* gauss_jordan: see gauss_jordan.h */
#include "solve/gauss_jordan.h"
#include <float.h>
#include <math.h>

PDI_FN void pdi_gauss_jordan_solve(int rows, int columns, int stride, double *a)
{
    for (int p = 0; p < rows; p++) {
        double *row = a + (int64_t)p * stride, *best = row;
        for (int i = p + 1; i < rows; i++)
            if (fabs(a[(int64_t)i * stride + p]) > fabs(best[p])) best = a + (int64_t)i * stride;
        double factor = fabs(best[p]) > DBL_MIN ? 1.0 / best[p] : 0.0;
        for (int j = 0; j < columns; j++) {
            double swap = best[j];
            best[j] = row[j];
            row[j] = factor * swap;
        }
        for (int i = 0; i < rows; i++) {
            double *other = a + (int64_t)i * stride, scale = other[p];
            for (int j = 0; j < columns && i != p; j++) other[j] -= scale * row[j];
        }
    }
}
