/* moments: the instants at which a step takes laws that depend on time, and their weights.
 *
 * A step takes the mean of a law over its time, at each concentration. Where the law goes nearly straight that is its
 * value in the middle. Else the step is divided until two instants a piece give the mean within a share of the
 * tolerance, and bounds of the law leave no room for what they do not see (theory: 10.12).
 */
#ifndef PD_MOMENTS_H
#define PD_MOMENTS_H
#include "metal/interface.h"

#ifdef PDI_INTERNAL
/* Most instants of a step. */
#define PDI_MOMENTS_MOST 1024
/* Find them for the step from t over dt [s], by the present concentrations. Returns 1; or the share of the step that
 * may be tried next, since so many are not enough. *taken [-]: of a node's content what laws that change in the step
 * take at most. */
PDI_FN double pdi_moments_find(pd_dissolve *d, double t, double dt, double *taken);
#endif

#endif
