/* paraview: a script that opens the fields of a run in ParaView, coloured, with one range for all times. */
#ifndef PD_PARAVIEW_H
#define PD_PARAVIEW_H
#include "io/file.h"

#ifdef PDI_INTERNAL
/* For a folder with simulation.pvd; the script finds out what is in it. PD_ERR_FILE. */
PDI_FN pd_status pdi_paraview_write(pd_ctx *ctx, const char *path);
#endif

#endif
