/* vec: see vec.h */
#include "core/vec.h"
#include <math.h>

PDI_FN double pdi_vec_dot(const double *a, const double *b)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d] * b[d];
    return sum;
}

PDI_FN double pdi_vec_norm(const double *a) { return sqrt(pdi_vec_dot(a, a)); }

PDI_FN double pdi_vec_min(const double *a)
{
    double least = a[0];
    for (int d = 1; d < PD_DIM; d++) least = pd_min(least, a[d]);
    return least;
}

/* Gauss-Jordan elimination with partial pivoting. b [PD_DIM][nb], nb right-hand sides, becomes the solutions; a is
 * overwritten. Returns the smallest |pivot| over max |a|, at most 1; 0: singular: a pivot is exactly 0, or NaN, and a
 * and b are partly overwritten. */
static double pdi_vec_eliminate(double *a, double *b, int nb)
{
    double largest = 0.0, smallest = 1.0;
    for (int i = 0; i < PD_DIM * PD_DIM; i++) largest = pd_max(largest, fabs(a[i]));
    if (!(largest > 0.0)) return 0.0;
    for (int c = 0; c < PD_DIM; c++) {
        int pivot = c;
        for (int r = c + 1; r < PD_DIM; r++)
            if (fabs(a[r * PD_DIM + c]) > fabs(a[pivot * PD_DIM + c])) pivot = r;
        double value = a[pivot * PD_DIM + c];
        smallest = pd_min(smallest, fabs(value) / largest);
        if (!(fabs(value) > 0.0)) return 0.0;
        for (int k = 0; k < PD_DIM; k++) {
            double swap = a[c * PD_DIM + k];
            a[c * PD_DIM + k] = a[pivot * PD_DIM + k] / value;
            if (pivot != c) a[pivot * PD_DIM + k] = swap;
        }
        for (int k = 0; k < nb; k++) {
            double swap = b[c * nb + k];
            b[c * nb + k] = b[pivot * nb + k] / value;
            if (pivot != c) b[pivot * nb + k] = swap;
        }
        for (int r = 0; r < PD_DIM; r++) {
            double factor = a[r * PD_DIM + c];
            if (r == c) continue;
            for (int k = 0; k < PD_DIM; k++) a[r * PD_DIM + k] -= factor * a[c * PD_DIM + k];
            for (int k = 0; k < nb; k++) b[r * nb + k] -= factor * b[c * nb + k];
        }
    }
    return smallest;
}

PDI_FN double pdi_vec_solve(const double *a, const double *b, double *x)
{
    double work[PD_DIM * PD_DIM], rhs[PD_DIM];
    for (int i = 0; i < PD_DIM * PD_DIM; i++) work[i] = a[i];
    for (int d = 0; d < PD_DIM; d++) rhs[d] = b[d];
    double pivot = pdi_vec_eliminate(work, rhs, 1);
    if (pivot > 0.0)
        for (int d = 0; d < PD_DIM; d++) x[d] = rhs[d];
    return pivot;
}

PDI_FN double pdi_vec_invert(const double *a, double *inverse)
{
    double work[PD_DIM * PD_DIM], rhs[PD_DIM * PD_DIM];
    for (int i = 0; i < PD_DIM * PD_DIM; i++) {
        work[i] = a[i];
        rhs[i] = i % (PD_DIM + 1) == 0 ? 1.0 : 0.0;
    }
    if (!(pdi_vec_eliminate(work, rhs, PD_DIM) > 0.0)) return 0.0;
    double largest = 0.0, opposite = 0.0;
    for (int i = 0; i < PD_DIM * PD_DIM; i++) {
        largest = pd_max(largest, fabs(a[i]));
        opposite = pd_max(opposite, fabs(rhs[i]));
        inverse[i] = rhs[i];
    }
    return 1.0 / (largest * opposite);
}

PDI_FN int pdi_vec_cholesky(int n, int stride, const double *least, double *a)
{
    for (int r = 0; r < n; r++)
        for (int c = 0; c <= r; c++) {
            double sum = a[r * stride + c];
            for (int k = 0; k < c; k++) sum -= a[r * stride + k] * a[c * stride + k];
            if (r == c && !(sum > least[r])) return 0;
            a[r * stride + c] = r == c ? sqrt(sum) : sum / a[c * stride + c];
        }
    return 1;
}

PDI_FN int pdi_vec_cholesky_any_order(int n, int stride, const double *least, double *a)
{
    double column[PDI_VEC_MAX_ROWS];
    if (!pdi_vec_cholesky(n, stride, least, a)) return 0;
    for (int r = 0; r < n; r++) { /* were row r last, its pivot would be 1 / (A^-1)_rr */
        for (int c = 0; c < n; c++) column[c] = c == r ? 1.0 : 0.0;
        pdi_vec_cholesky_solve(n, stride, a, column);
        if (!(column[r] * least[r] < 1.0)) return 0;
    }
    return 1;
}

PDI_FN void pdi_vec_cholesky_solve(int n, int stride, const double *a, double *x)
{
    for (int r = 0; r < n; r++) {
        for (int k = 0; k < r; k++) x[r] -= a[r * stride + k] * x[k];
        x[r] /= a[r * stride + r];
    }
    for (int r = n - 1; r >= 0; r--) {
        for (int k = r + 1; k < n; k++) x[r] -= a[k * stride + r] * x[k];
        x[r] /= a[r * stride + r];
    }
}
