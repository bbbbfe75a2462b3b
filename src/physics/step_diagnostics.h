/* step_diagnostics: diagnostics of a time step: volume loss, extremes, corrosion depth, and conservation of the volume
 * flux along a flow. */
#ifndef PD_STEP_DIAGNOSTICS_H
#define PD_STEP_DIAGNOSTICS_H
#include "physics/model.h"

typedef struct pd_step_diagnostics {
    double volume_loss;   /* [-] share of the initial solid */
    double v_max;         /* [m/s] */
    double c_max;         /* [mol/m3] dissolved */
    /* [m] bond-based corrosion: how far metal has turned fluid, from the nearest first fluid */
    double corrosion_depth;
    int has_flux;         /* the flow enters on one side and leaves through the opposite one */
    double flux_error;    /* [-] flux that the scheme conserves, far downstream against far upstream of the solid, worst
                           * so far */
    double layer_flux_error; /* [-] largest deviation of the flux through a layer of nodes from the upstream one, worst
                              * so far */
    int flux_axis, flux_towards_plus; /* axis of the flow; 1: towards + */
    /* [m3/s] (per m in 2D) where inlets follow a clock: largest flux upstream, and of nodes */
    double max_flux[2];
    int64_t flow_solves; /* flow solves that flux and flux_max know */
    int32_t layers;
    int32_t nodes;
    /* [nodes] [m] bond-based corrosion: distance from the nearest fluid node of the start */
    float *initial_depth;
    double *layer_flux; /* [layers] [m^d/s] flux of each layer of nodes, work */
} pd_step_diagnostics;

#define pd_step_diagnostics_build PD_NAME(pd_step_diagnostics_build)
#define pd_step_diagnostics_compute_peclet PD_NAME(pd_step_diagnostics_compute_peclet)
#define pd_step_diagnostics_free PD_NAME(pd_step_diagnostics_free)
#define pd_step_diagnostics_store PD_NAME(pd_step_diagnostics_store)
#define pd_step_diagnostics_update PD_NAME(pd_step_diagnostics_update)

/* [-] Largest cell Peclet number |v_d| h_d/D over fluid nodes and axes, with the least positive diffusivity D of a
 * dissolved species; *slowest: its name. 0 and "": there is no flow with species. */
PD_API double pd_step_diagnostics_compute_peclet(const pd_model *model, const char **slowest);
/* Prepare the diagnostics of a built model: allocates initial depths with bond-based corrosion, and layer fluxes where
 * a flux error is computed (has_flux). pd_step_diagnostics_free frees them; after an error nothing is left. */
PD_API pd_status pd_step_diagnostics_build(pd_ctx *ctx, const pd_model *model, pd_step_diagnostics *o);
/* Update volume loss and extremes after a step; the flux errors, which keep the worst so far, only with has_flux and
 * after new flow solves. The two sections for the flux error lie a quarter of the free length away from the ends;
 * without solid at 1/4 and 3/4. */
PD_API void pd_step_diagnostics_update(pd_ctx *ctx, pd_model *model, pd_step_diagnostics *o);
PD_API void pd_step_diagnostics_free(pd_ctx *ctx, pd_step_diagnostics *o);
/* Store or load the worst flux errors and largest fluxes so far in a checkpoint. Depths are those of the start and are
 * built before the model is loaded. */
PD_API pd_status pd_step_diagnostics_store(pd_ctx *ctx, pd_step_diagnostics *o, pd_archive *archive);

#endif
