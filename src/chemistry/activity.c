/* activity: see activity.h */
#include "chemistry/activity.h"
#include <math.h>

#define PDI_ACTIVITY_DEBYE_HUECKEL 1.82e6 /* [(L/mol)^0.5 K^1.5] A times (permittivity temperature)^1.5 (eq. 7.4) */
#define PDI_ACTIVITY_DAVIES_LINEAR 0.3    /* [L/mol] linear coefficient of Davies 1962 */
#define PDI_ACTIVITY_ZERO_CELSIUS 273.15  /* [K] 0 degrees Celsius */

/* Relative permittivity of water: Malmberg and Maryott 1956. */
PDI_FN double pdi_activity_compute_debye_hueckel(double temperature)
{
    double t = temperature - PDI_ACTIVITY_ZERO_CELSIUS;
    double permittivity = 87.740 - t * (0.40008 - t * (9.398e-4 - t * 1.410e-6));
    return PDI_ACTIVITY_DEBYE_HUECKEL / pow(permittivity * temperature, 1.5);
}

PDI_FN double pdi_activity_compute_davies(double a, double strength, double *slope)
{
    double molar = 1e-3 * strength, root = sqrt(molar), factor = -a * log(10.0);
    *slope =
        root > 0.0 ? 1e-3 * factor * (0.5 / (root * (1.0 + root) * (1.0 + root)) - PDI_ACTIVITY_DAVIES_LINEAR) : 0.0;
    return factor * (root / (1.0 + root) - PDI_ACTIVITY_DAVIES_LINEAR * molar);
}
