/* snapshot: snapshot of a run for the observer callback: time, step, losses, fields by name, scalar outputs.
 *
 *   static int watch(void *user, pd_ctx *ctx, const pd_snapshot *at)
 *   {
 *       pd_field_view c;
 *       if (pd_snapshot_get_field(ctx, at, "C", &c) < 0) return 1;
 *       printf("%g s: %g\n", at->time, c.data[0]);
 *       return at->diagnostics->volume_loss > 0.5;
 *   }
 */
#ifndef PD_SNAPSHOT_H
#define PD_SNAPSHOT_H
#include "physics/step_diagnostics.h"
#include "run/scalar_outputs.h"
#include "run/field_view.h"

typedef enum pd_snapshot_stage {
    PD_SNAPSHOT_STAGE_START = 0, /* before the first step, of a run that goes on before its next one */
    /* a step is done, its rows are in the tables; pictures and fields of this instant follow */
    PD_SNAPSHOT_STAGE_STEP,
    PD_SNAPSHOT_STAGE_END /* the last step is done and all files are complete */
} pd_snapshot_stage;

/* State of a run; read-only, and valid until the observer returns. */
typedef struct pd_snapshot {
    pd_snapshot_stage stage;
    const char *name;     /* of the scene */
    const char *folder;   /* of the files; NULL: none are written */
    double time, dt;      /* [s] dt: of the last step, 0 before the first */
    double end_time;      /* [s] end of the run */
    int64_t steps;
    const pd_step_diagnostics *diagnostics;
    const pd_model *model;
    pd_model *writable_model; /* the same, writable: ghosts and fields computed on request are filled in */
    const pd_monitors *monitors;
    pd_field_views *views;
} pd_snapshot;

/* Not 0: the run ends here. The files are complete up to this instant, a checkpoint is kept where there are some, and
 * pd_run_result.stopped says so. */
typedef int (*pd_snapshot_fn)(void *user, pd_ctx *ctx, const pd_snapshot *at);

#define pd_snapshot_get_field PD_NAME(pd_snapshot_get_field)
#define pd_snapshot_get_outputs PD_NAME(pd_snapshot_get_outputs)

/* Values of an output field (C, v, p, kind, grain, phase, D, rate, density, damage, ...), as for pd_sim_field; they
 * stay in place until the field is asked for again or the run ends. PD_ERR_ARGUMENT: no such field, or the scene has
 * none. */
PD_API pd_status pd_snapshot_get_field(pd_ctx *ctx, const pd_snapshot *at, const char *name, pd_field_view *view);
/* All scalar outputs, with every field of the probes; the same list at each time of a run. Zero-initialise `figures`
 * once: it is filled anew at each call, and freed by pd_scalar_outputs_free. */
PD_API pd_status pd_snapshot_get_outputs(pd_ctx *ctx, const pd_snapshot *at, pd_scalar_outputs *figures);

#endif
