/* bond_stretch: bond stretch as a function of e = (|Y|^2 - r^2)/r^2, without loss of digits for small e.
 *
 * 1 - r/|Y| = e phi(e), phi = 1/(sqrt(1 + e) (1 + sqrt(1 + e))). With p = 1 - r/|Y| the stretch is
 * (|Y| - r)/r = p (1 + e)(1 - p).
 */
#ifndef PD_BOND_STRETCH_H
#define PD_BOND_STRETCH_H
#include "core/base.h"
#include <math.h>

#ifdef PDI_INTERNAL
/* Largest |e| at which the nine terms of the series are exact to rounding. */
#define PDI_BOND_STRETCH_SERIES_LIMIT (1.0 / 64.0)

/* phi(e) by the first nine terms of its power series. */
PDI_INLINE double pdi_bond_stretch_factor_series(double e)
{
    double sum = 12155.0 / 65536.0;
    sum = sum * e - 6435.0 / 32768.0;
    sum = sum * e + 429.0 / 2048.0;
    sum = sum * e - 231.0 / 1024.0;
    sum = sum * e + 63.0 / 256.0;
    sum = sum * e - 35.0 / 128.0;
    sum = sum * e + 5.0 / 16.0;
    sum = sum * e - 3.0 / 8.0;
    return sum * e + 0.5;
}

/* 1 - r/|Y| of any e > -1: force over modulus and deformed bond vector Y. */
static inline double pdi_bond_stretch_factor(double e)
{
    if (fabs(e) <= PDI_BOND_STRETCH_SERIES_LIMIT) return e * pdi_bond_stretch_factor_series(e);
    double root = sqrt(1.0 + e);
    return e / (root * (1.0 + root));
}
#endif

#endif
