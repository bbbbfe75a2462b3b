/* figures: the last values of all that a run watches, in one list: the volume loss, planes, forces, transfers, totals,
 * and flow and concentration at probes. Lines and the fields of single cells (kind, grain, rate, ...) have none.
 */
#ifndef PD_FIGURES_H
#define PD_FIGURES_H
#include "run/monitor.h"

typedef struct pd_figure {
    char section[16];         /* "scene", "plane", "force", "transfer", "total" or "probe" */
    char name[PD_SETUP_NAME]; /* of the section; "" for the scene */
    char key[24], unit[16];
    int monitor;              /* of the setup that it belongs to, -1: none */
    double value;             /* [unit] */
} pd_figure;

typedef struct pd_figures {
    pd_figure *list; /* [room] */
    int count, room;
    int order; /* of the flow: 2 or 4; 0: there is none, or it has no figures yet */
} pd_figures;

#define pd_figures_free PD_NAME(pd_figures_free)

#ifdef PDI_INTERNAL
/* Append the present figures; the monitors hold those of the last step. all: 0: of probes flow, C, pH and what is
 * dissolved, NaN in the metal; 1: all that their table has: the fields of single cells, too, and 0 in the metal where
 * only fluid has a value. Zero-initialise `figures`. */
PDI_FN pd_status pdi_figures_collect(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors, int all,
                                     pd_figures *figures);
#endif
PD_API void pd_figures_free(pd_ctx *ctx, pd_figures *figures);

#endif
