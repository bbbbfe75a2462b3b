/* chart: reads the [table NAME] sections of a scene: functions through the points of CSV files, for all expressions
 * behind them.
 *
 *   [table iC]  file = crevice.csv  x = C_mol_per_L in mol/L  y = i_A_per_m2 in A/m2  outside = hold|error
 *
 * declares iC(C). A column goes by its name in the heading or, where a scene cannot write that, by its number from 1.
 */
#ifndef PD_CHART_H
#define PD_CHART_H
#include "setup.h"
#include "text.h"

#ifdef PDI_INTERNAL
/* The tables go to `setup`, and `text` knows them from then on. folder: of the scene. Errors name the line of the scene
 * and that of the table: PD_ERR_PARSE, PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_chart_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup);
#endif

#endif
