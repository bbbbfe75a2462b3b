/* paraview: writes a Python script that opens the fields of a run in ParaView, with one colour range for all times. */
#ifndef PD_PARAVIEW_H
#define PD_PARAVIEW_H
#include "io/file.h"

#ifdef PDI_APP_INTERNAL
/* Write the script to `path`, in a folder with simulation.pvd; the script itself finds the fields. PD_ERR_FILE. */
PDI_FN pd_status pdi_paraview_write_script(pd_ctx *ctx, const char *path);
#endif

#endif
