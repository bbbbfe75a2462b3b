/* monitor_outputs: scalar outputs of a monitor now: of a plane, the force on bodies, a mass transfer, a box, the
 * mechanics of the metal, a crack tip, an electrode, a surface state, a mechanical boundary condition.
 *
 * Sherwood number: Sh = flux L / (area (C_surface - C_fluid) D); with the bulk concentration, area (C_surface -
 * C_fluid) is summed over the layers.
 */
#ifndef PD_MONITOR_OUTPUTS_H
#define PD_MONITOR_OUTPUTS_H
#include "io/csv.h"
#include "physics/model.h"

#define PD_MONITOR_MAX_OUTPUTS 80 /* largest number of outputs of a monitor: of boxes, all species and balances */
#define PD_MONITOR_MAX_OUTPUTS_NO_SPECIES 24 /* the same without species */

/* A scalar output. */
typedef struct pd_monitor_output {
    char key[24], unit[16];
    double value; /* [unit] */
} pd_monitor_output;

/* A monitor: one section of the scene and its outputs. */
typedef struct pd_monitor {
    const pd_setup_monitor *desc;
    pd_csv table;
    int count;                   /* number of outputs */
    int capacity;                /* capacity of output[] */
    pd_monitor_output *output;   /* [capacity] */
    int64_t flow_solves;         /* force: number of flow solves at the last update */
    int columns, rows;           /* of the profile */
    double *profile;             /* [rows][columns] [unit of the column] */
    double *flux, *area, *fluid; /* [rows] [mol/s] [m^(d-1)] [mol/m3] transfer: of the layers */
} pd_monitor;

#ifdef PDI_APP_INTERNAL
/* Replace the outputs of a monitor by those of now. A line has none; a force keeps its outputs until the next flow
 * solve; a mechanical boundary condition has its reaction force by axes. Errors of force, crack and reaction force; the
 * outputs are incomplete then. */
PDI_FN pd_status pdi_monitor_outputs_compute(pd_ctx *ctx, pd_model *model, pd_monitor *m);
/* State of an electrode now (potential, currents, charge), from the potential solver or, with migrating ions, from the
 * species solver. */
PDI_FN void pdi_monitor_outputs_get_electrode(const pd_model *model, int electrode, pd_cell_electrode *e);
/* Unit of areas: "m2" in 3D and with axisymmetry, "m" in 2D, "-" in 1D. */
PDI_FN const char *pdi_monitor_outputs_get_area_unit(const pd_setup *setup);
#endif

#endif
