/* quadratic_fit: see quadratic_fit.h */
#include "lattice/quadratic_fit.h"
#include <math.h>
#include <string.h>

/* [cells^2] Added to squared distances, so that the weight of a datum at the point itself is finite (eq. 1.11). */
#define PDI_QUADRATIC_FIT_DISTANCE_OFFSET 1e-6
/* [-] Weight of the regularising equation "second derivative = 0", for those that no datum determines. */
#define PDI_QUADRATIC_FIT_SECOND_WEIGHT 1e-5
/* [-] Weight of the regularising equation "gradient component = 0". */
#define PDI_QUADRATIC_FIT_GRADIENT_WEIGHT 1e-10
/* [-] A column whose norm falls below this fraction in the elimination is zero but for rounding. An entry e of an
 * equation with the residual r would give a derivative of e r/FAINT^2, so rounding of 1e-16 one of 1e-6 r. */
#define PDI_QUADRATIC_FIT_ROUNDING 1e-11

PDI_FN void pdi_quadratic_fit_init(pdi_quadratic_fit *fit, const double *x, const double *h)
{
    fit->rows = 0;
    for (int d = 0; d < PD_DIM; d++) {
        fit->x[d] = x[d];
        fit->h[d] = h[d];
    }
}

/* Adds an equation for a datum at x [m] and sets its weight, 1 over the squared distance plus `offset` [cells2].
 * z [PD_DIM]: its position relative to the point in units of h. Returns its row, which the caller fills; NULL: the fit
 * is full. */
static double *pdi_quadratic_fit_add_equation(pdi_quadratic_fit *fit, const double *x, double offset, double *z)
{
    double square = offset;
    if (fit->rows == PDI_QUADRATIC_FIT_MAX_DATA) return NULL;
    for (int d = 0; d < PD_DIM; d++) {
        z[d] = (x[d] - fit->x[d]) / fit->h[d];
        square += z[d] * z[d];
    }
    fit->weight[fit->rows] = 1.0 / square;
    return fit->row[fit->rows++];
}

/* Multiplies row [terms + 1] of an equation, its right-hand side included, by `weight`. */
static void pdi_quadratic_fit_scale_equation(double *row, double weight)
{
    for (int c = 0; c <= PDI_QUADRATIC_FIT_TERMS; c++) row[c] *= weight;
}

PDI_FN void pdi_quadratic_fit_add_value(pdi_quadratic_fit *fit, const double *x, double value)
{
    double z[PD_DIM], *row = pdi_quadratic_fit_add_equation(fit, x, PDI_QUADRATIC_FIT_DISTANCE_OFFSET, z);
    int at = 0;
    if (!row) return;
    row[at++] = 1.0;
    for (int a = 0; a < PD_DIM; a++) row[at++] = z[a];
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++) row[at++] = z[a] * z[b];
    row[at] = value;
    pdi_quadratic_fit_scale_equation(row, fit->weight[fit->rows - 1]);
}

PDI_FN void pdi_quadratic_fit_add_derivative(pdi_quadratic_fit *fit, const double *x, const double *normal,
                                             double derivative)
{
    double z[PD_DIM], along[PD_DIM], length = 0.0, *row = pdi_quadratic_fit_add_equation(fit, x, 1.0, z);
    int at = 0;
    if (!row) return;
    for (int d = 0; d < PD_DIM; d++) length += normal[d] / fit->h[d] * (normal[d] / fit->h[d]);
    length = 1.0 / sqrt(length);
    for (int d = 0; d < PD_DIM; d++) along[d] = normal[d] / fit->h[d] * length;
    row[at++] = 0.0;
    for (int a = 0; a < PD_DIM; a++) row[at++] = along[a];
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b <= a; b++) row[at++] = z[a] * along[b] + z[b] * along[a] * (a == b ? 0.0 : 1.0) +
                                                 (a == b ? z[a] * along[a] : 0.0);
    row[at] = derivative * length;
    pdi_quadratic_fit_scale_equation(row, fit->weight[fit->rows - 1]);
}

/* Sorts the equations by descending weight: Householder reflections are then accurate for light ones, too. */
static void pdi_quadratic_fit_sort_equations(pdi_quadratic_fit *fit)
{
    double keep[PDI_QUADRATIC_FIT_TERMS + 1];
    for (int r = 1; r < fit->rows; r++)
        for (int q = r; q > 0 && fit->weight[q] > fit->weight[q - 1]; q--) {
            double weight = fit->weight[q];
            fit->weight[q] = fit->weight[q - 1];
            fit->weight[q - 1] = weight;
            memcpy(keep, fit->row[q], sizeof keep);
            memcpy(fit->row[q], fit->row[q - 1], sizeof keep);
            memcpy(fit->row[q - 1], keep, sizeof keep);
        }
}

/* Norm of column c from row `top` on. */
static double pdi_quadratic_fit_column_norm(const pdi_quadratic_fit *fit, int top, int c)
{
    double square = 0.0;
    for (int r = top; r < fit->rows; r++) square += fit->row[r][c] * fit->row[r][c];
    return sqrt(square);
}

/* Applies to all columns of the rows from `top` on the Householder reflection that clears column c below row `top`. A
 * column of zeros changes nothing. */
static void pdi_quadratic_fit_apply_reflection(pdi_quadratic_fit *fit, int top, int c)
{
    double norm = pdi_quadratic_fit_column_norm(fit, top, c),
           vector[PDI_QUADRATIC_FIT_MAX_DATA + PDI_QUADRATIC_FIT_TERMS], square = 0.0;
    for (int r = top; r < fit->rows; r++) {
        vector[r] = fit->row[r][c];
        if (r == top) vector[r] += vector[r] > 0.0 ? norm : -norm;
        square += vector[r] * vector[r];
    }
    for (int k = 0; k <= PDI_QUADRATIC_FIT_TERMS && square > 0.0; k++) {
        double dot = 0.0;
        for (int r = top; r < fit->rows; r++) dot += vector[r] * fit->row[r][k];
        for (int r = top; r < fit->rows; r++) fit->row[r][k] -= 2.0 * dot / square * vector[r];
    }
    for (int r = top + 1; r < fit->rows; r++) fit->row[r][c] = 0.0;
}

/* QR factorisation of the equations: keeps as many rows as the data determine terms (a column counts when its rest
 * exceeds PDI_QUADRATIC_FIT_ROUNDING of its norm at its turn), and drops residuals. order [terms]: columns of the
 * determined terms, then undetermined second derivatives, then undetermined gradients, so that lighter equations never
 * change heavier ones. */
static void pdi_quadratic_fit_factor_qr(pdi_quadratic_fit *fit, int *order)
{
    int top = 0, rest = 0, unknown[PDI_QUADRATIC_FIT_TERMS];
    for (int c = 0; c < PDI_QUADRATIC_FIT_TERMS; c++) {
        double limit = PDI_QUADRATIC_FIT_ROUNDING * pdi_quadratic_fit_column_norm(fit, 0, c);
        unknown[c] = !(pdi_quadratic_fit_column_norm(fit, top, c) > limit);
        if (!unknown[c]) {
            order[top] = c;
            pdi_quadratic_fit_apply_reflection(fit, top++, c);
        }
        for (int r = top; r < fit->rows; r++) fit->row[r][c] = 0.0;
    }
    fit->rows = top;
    for (int slopes = 0; slopes < 2; slopes++)
        for (int c = 0; c < PDI_QUADRATIC_FIT_TERMS; c++)
            if ((c <= PD_DIM) == slopes && unknown[c]) order[top + rest++] = c;
}

PDI_FN double pdi_quadratic_fit_solve(pdi_quadratic_fit *fit)
{
    double x[PDI_QUADRATIC_FIT_TERMS];
    int order[PDI_QUADRATIC_FIT_TERMS];
    if (fit->rows == 0) return (double)NAN;
    pdi_quadratic_fit_sort_equations(fit);
    pdi_quadratic_fit_factor_qr(fit, order);
    for (int c = 1; c < PDI_QUADRATIC_FIT_TERMS; c++) {
        double *row = fit->row[fit->rows++];
        memset(row, 0, sizeof fit->row[0]);
        row[c] = c > PD_DIM ? PDI_QUADRATIC_FIT_SECOND_WEIGHT : PDI_QUADRATIC_FIT_GRADIENT_WEIGHT;
    }
    for (int n = 0; n < PDI_QUADRATIC_FIT_TERMS; n++) pdi_quadratic_fit_apply_reflection(fit, n, order[n]);
    for (int n = PDI_QUADRATIC_FIT_TERMS - 1; n >= 0; n--) {
        double *row = fit->row[n], pivot = row[order[n]];
        x[order[n]] = row[PDI_QUADRATIC_FIT_TERMS];
        for (int k = n + 1; k < PDI_QUADRATIC_FIT_TERMS; k++) x[order[n]] -= row[order[k]] * x[order[k]];
        x[order[n]] = fabs(pivot) > 0.0 ? x[order[n]] / pivot : 0.0;
    }
    return x[0];
}

#undef PDI_QUADRATIC_FIT_DISTANCE_OFFSET
#undef PDI_QUADRATIC_FIT_SECOND_WEIGHT
#undef PDI_QUADRATIC_FIT_GRADIENT_WEIGHT
#undef PDI_QUADRATIC_FIT_ROUNDING
