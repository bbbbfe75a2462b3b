/* monitor_profile: tables and plots of values along a line, and of a mass transfer along its axis.
 *
 * line_centre_000012_t6.1s.csv, line_centre_C_000012_t6.1s.png     at output times
 */
#ifndef PD_MONITOR_PROFILE_H
#define PD_MONITOR_PROFILE_H
#include "io/output_folder.h"
#include "run/monitor_outputs.h"

#ifdef PDI_APP_INTERNAL
/* Fill the profile of a line or mass transfer, write it as a table, and plot it: each image field of a line; of a
 * transfer Sh with a reference length, else the flux density. A line samples the fields now; a transfer uses m->flux,
 * m->area and m->fluid of the last step. */
PDI_FN pd_status pdi_monitor_profile_write(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_monitor *m,
                                           int frame);
#endif

#endif
