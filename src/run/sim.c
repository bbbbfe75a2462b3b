/* sim: see sim.h */
#include "run/sim.h"
#include "physics/memory_estimate.h"
#include "run/run.h"
#include <string.h>

/* Check the memory estimate and build the model of the setup. On failure the message begins with file and line.
 * PD_ERR_LIMIT: the estimate exceeds the limit. */
static pd_status pdi_sim_build(pd_ctx *ctx, pd_sim *sim)
{
    pd_status status = pd_memory_estimate_check_limit(ctx, &sim->setup, 0);
    int line = sim->setup.line[PD_PART_GRID];
    if (status >= 0) {
        status = pd_model_build(ctx, &sim->setup, &sim->model);
        line = sim->model.error_line;
    }
    if (status < 0) pdi_run_prefix_message(ctx, &sim->setup, line);
    return status < 0 ? status : PD_OK;
}

pd_status pd_sim_open(pd_ctx *ctx, const char *scene, const char *const *overrides, int count, pd_sim *sim)
{
    memset(sim, 0, sizeof *sim);
    pd_status status = strchr(scene, '\n') ? pd_scene_parse(ctx, "scene", scene, overrides, count, &sim->setup)
                                           : pd_scene_read(ctx, scene, overrides, count, &sim->setup);
    if (status >= 0) return pd_sim_start(ctx, sim);
    memset(sim, 0, sizeof *sim);
    return status;
}

pd_status pd_sim_start(pd_ctx *ctx, pd_sim *sim)
{
    pd_status status = pdi_sim_build(ctx, sim);
    if (status >= 0) status = pd_time_loop_start(ctx, &sim->model.time_loop);
    if (status < 0) {
        pd_sim_close(ctx, sim);
        return status;
    }
    sim->end_time = sim->setup.end_time;
    sim->time = sim->model.time_loop.time;
    return status;
}

pd_status pd_sim_step(pd_ctx *ctx, pd_sim *sim, double t_limit)
{
    if (!(t_limit > sim->time))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "sim", "a step from %g s to %g s, expected a time ahead", sim->time,
                       t_limit);
    pd_status status = pd_time_loop_step(ctx, &sim->model.time_loop, t_limit);
    sim->time = sim->model.time_loop.time;
    sim->steps = sim->model.time_loop.steps;
    return status;
}

pd_status pd_sim_field(pd_ctx *ctx, pd_sim *sim, const char *name, pd_field_view *view)
{
    return pdi_field_view_get(ctx, &sim->model, &sim->views, name, view);
}

void pd_sim_detach_view(pd_sim *sim, const pd_field_view *view)
{
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (sim->views.field[k] == view->data) sim->views.field[k] = NULL;
}

void pd_sim_free_view(pd_ctx *ctx, pd_field_view *view)
{
    double *data = (double *)view->data; /* was allocated as such */
    PD_DELETE(ctx, view->components * view->component_stride, data);
    memset(view, 0, sizeof *view);
}

void pd_sim_close(pd_ctx *ctx, pd_sim *sim)
{
    pdi_field_view_free(ctx, &sim->views);
    pd_model_free(ctx, &sim->model);
    pd_setup_free(ctx, &sim->setup);
    memset(sim, 0, sizeof *sim);
}
