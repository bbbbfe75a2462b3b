/* tolerance_presets: solver tolerances and step control of a setup from the wanted accuracy of its results.
 *
 * They leave three quarters of the error to the discretisation in space, which richardson.h measures. Settings that the
 * scene gives stay.
 */
#ifndef PD_TOLERANCE_PRESETS_H
#define PD_TOLERANCE_PRESETS_H
#include "setup/setup.h"

#define PD_ACCURACY_MIN 1e-6 /* [-] */
#define PD_ACCURACY_MAX 0.5  /* [-] */

#define pd_tolerance_presets_apply PD_NAME(pd_tolerance_presets_apply)

/* accuracy [-]: relative, from PD_ACCURACY_MIN to PD_ACCURACY_MAX, else PD_ERR_ARGUMENT. What was picked and what
 * the scene keeps goes into text[size], for example "accuracy 1 %: picked steady = 0.0001; of the scene rtol = 0.004".
 */
PD_API pd_status pd_tolerance_presets_apply(pd_ctx *ctx, double accuracy, pd_setup *setup, char *text, size_t size);

#endif
