/* activity: coefficients of activity from charge and ionic strength: 1, or Davies' (theory: eq. 7.4). */
#ifndef PD_ACTIVITY_H
#define PD_ACTIVITY_H
#include "core/base.h"

typedef enum pd_activity {
    PD_ACTIVITY_IDEAL = 0,
    PD_ACTIVITY_DAVIES /* Davies 1962: up to an ionic strength of about 500 mol/m3 */
} pd_activity;

#ifdef PDI_INTERNAL
/* Debye-Hueckel constant A [(L/mol)^0.5] of water at a temperature [K], 273 to 373 (eq. 7.4). */
PDI_FN double pdi_activity_compute_debye_hueckel(double temperature);
/* Davies' equation: ln gamma over the square of the charge, at an ionic strength [mol/m3] of at least 0; *slope: its
 * derivative by the strength [m3/mol], set to 0 at strength 0. a: the constant A (eq. 7.4). */
PDI_FN double pdi_activity_compute_davies(double a, double strength, double *slope);
#endif

#endif
