/* scalar_outputs: all scalar outputs of a run in one list: volume loss, values of monitors (planes, forces, transfers,
 * totals), flow and concentration at probes. Lines and fields of single cells (kind, grain, rate, ...) have none. */
#ifndef PD_SCALAR_OUTPUTS_H
#define PD_SCALAR_OUTPUTS_H
#include "run/monitor.h"

/* A scalar output. */
typedef struct pd_scalar_output {
    char section[16];         /* "scene", "plane", "force", "transfer", "total" or "probe" */
    char name[PD_SETUP_NAME]; /* of the section; "" for the scene */
    char key[24], unit[16];
    int monitor;              /* index of its monitor in the setup, -1: none */
    double value;             /* [unit] */
} pd_scalar_output;

/* A list of scalar outputs. */
typedef struct pd_scalar_outputs {
    pd_scalar_output *list; /* [room] */
    int count, capacity;    /* length and capacity */
    int order; /* order of the flow discretisation: 2 or 4; 0: there is no flow, or not yet */
} pd_scalar_outputs;

#define pd_scalar_outputs_free PD_NAME(pd_scalar_outputs_free)

#ifdef PDI_APP_INTERNAL
/* Append all scalar outputs to a list that was zero-initialised once, and set its order: volume loss with dissolution,
 * monitors, probes. The monitors hold those of the last step; probes are sampled now. all: 0: of probes only smooth
 * fields (v, p, C, pH, solutes), NaN in the metal; 1: all fields of probes, 0 in the metal for fields of the fluid. */
PDI_FN pd_status pdi_scalar_outputs_collect(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors, int all,
                                            pd_scalar_outputs *figures);
#endif
/* Free the list and zero figures. A zeroed one is allowed. */
PD_API void pd_scalar_outputs_free(pd_ctx *ctx, pd_scalar_outputs *figures);

#endif
