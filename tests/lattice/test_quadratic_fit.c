/* quadratic_fit: quadratics are met, whatever the distances of the data and the order in which they come.
 * dims: 1 2 3 */
#include "lattice/quadratic_fit.h"
#include "test.h"
#include <math.h>

/* A quadratic of lengths h. */
static double quadratic(const double *x, const double *h)
{
    double sum = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double z = x[d] / h[d];
        sum += (2.0 + d) * z + (0.5 - d) * z * z;
        if (d > 0) sum += 0.7 * z * x[0] / h[0];
    }
    return sum;
}

/* The fit at `at` [m] to a block of nodes and one datum more at a distance of `near_by` h, first or last. */
static double fit_block(const double *at, const double *h, double near_by, int last)
{
    pdi_quadratic_fit fit;
    double x[PD_DIM];
    int nodes = PD_DIM == 1 ? 3 : PD_DIM == 2 ? 9 : 27;
    pdi_quadratic_fit_init(&fit, at, h);
    for (int part = 0; part < 2; part++) {
        if (part == last) {
            for (int d = 0; d < PD_DIM; d++) x[d] = at[d];
            x[0] += near_by * h[0];
            pdi_quadratic_fit_add_value(&fit, x, quadratic(x, h));
            continue;
        }
        for (int k = 0; k < nodes; k++) {
            for (int d = 0, rest = k; d < PD_DIM; d++, rest /= 3) x[d] = (rest % 3 - 1) * h[d];
            pdi_quadratic_fit_add_value(&fit, x, quadratic(x, h));
        }
    }
    return pdi_quadratic_fit_solve(&fit);
}

/* Weights fall with the square of the distance: those of the block vanish beside that of a datum nearby, and still
 * determine the slopes. */
TEST(heavy_and_light_data)
{
    const double h[3] = {1e-6, 2e-6, 0.7e-6}, at[3] = {0.3e-6, -0.5e-6, 0.2e-6};
    double exact = quadratic(at, h);
    for (double near_by = 1e-1; near_by > 1e-11; near_by *= 0.1)
        for (int last = 0; last < 2; last++)
            if (!CHECK_NEAR(fit_block(at, h, near_by, last), exact, 2e-12)) NOTE("at %g h, %d", near_by, last);
}

TEST_MAIN(ENTRY(heavy_and_light_data))
