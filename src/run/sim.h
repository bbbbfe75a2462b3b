/* sim: step-by-step interface to a scene, for programs that read its fields while it runs. Writes no files. */
#ifndef PD_SIM_H
#define PD_SIM_H
#include "run/field_view.h"
#include "scene/scene.h"

/* Objects of the model point at each other: an open one must not be moved. */
typedef struct pd_sim {
    pd_setup setup;
    pd_model model;
    double time;  /* [s] */
    double end_time; /* [s] end time of the scene; steps may go beyond it */
    int64_t steps;
    pd_field_views views;
} pd_sim;

#define pd_sim_open PD_NAME(pd_sim_open)
#define pd_sim_start PD_NAME(pd_sim_start)
#define pd_sim_step PD_NAME(pd_sim_step)
#define pd_sim_field PD_NAME(pd_sim_field)
#define pd_sim_detach_view PD_NAME(pd_sim_detach_view)
#define pd_sim_free_view PD_NAME(pd_sim_free_view)
#define pd_sim_close PD_NAME(pd_sim_close)

/* scene: the path of a scene file, or the text of a scene, which has a newline in it. `count` overrides as for
 * pd_scene_read. The flow is solved and the balance opened: fields are there. On failure sim is zero. The errors of the
 * reader, of the builders and of the first flow solve. */
PD_API pd_status pd_sim_open(pd_ctx *ctx, const char *scene, const char *const *overrides, int count, pd_sim *sim);
/* Build the model and start the time loop. sim is zero but for its setup, which the caller has read and changed, and
 * which sim owns from then on: on failure the setup is freed, too, and sim is zero. */
PD_API pd_status pd_sim_start(pd_ctx *ctx, pd_sim *sim);
/* Make one step, as long as its error allows, that does not pass t_limit [s]; sim->time and steps follow, on failure,
 * too. Statuses of pd_time_loop_step. PD_ERR_ARGUMENT: t_limit <= sim->time, and no step is made. */
PD_API pd_status pd_sim_step(pd_ctx *ctx, pd_sim *sim, double t_limit);
/* The values of an output field (C, v, p, kind, grain, phase, D, rate, density, damage) as they are now. They stay in
 * place until the field is asked for again or the simulation is closed. PD_ERR_ARGUMENT: no such field, or the scene
 * has none. */
PD_API pd_status pd_sim_field(pd_ctx *ctx, pd_sim *sim, const char *name, pd_field_view *view);
/* Take the values of a view out of sim: they stay as they are until pd_sim_free_view, also when the simulation is
 * closed; the next view of the field has others. Nothing if sim does not hold them. */
PD_API void pd_sim_detach_view(pd_sim *sim, const pd_field_view *view);
/* Free the values of a view that was detached, and zero the view. */
PD_API void pd_sim_free_view(pd_ctx *ctx, pd_field_view *view);
/* Free views, model and setup and zero sim. A zeroed one is allowed. Views that were detached stay. */
PD_API void pd_sim_close(pd_ctx *ctx, pd_sim *sim);

#endif
