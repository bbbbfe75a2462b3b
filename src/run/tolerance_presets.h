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

/* Set the tolerances that the scene does not give from accuracy [-], relative, and append a line with it to
 * setup->fingerprint. PD_ERR_ARGUMENT, nothing changed: not from PD_ACCURACY_MIN to PD_ACCURACY_MAX. Into text[size]
 * goes what was picked and what the scene keeps, as "accuracy 1 %: picked flow.steady_tolerance = 0.001; the scene sets
 * run.rtol = 0.004". */
PD_API pd_status pd_tolerance_presets_apply(pd_ctx *ctx, double accuracy, pd_setup *setup, char *text, size_t size);

#endif
