/* sim: see sim.h */
#include "run/sim.h"
#include "run/footprint.h"
#include "run/run.h"
#include "run/sample.h"
#include <string.h>

static int pdi_sim_components(int field) { return field == PD_FIELD_V ? PD_DIM : 1; }

static pd_status pdi_sim_build(pd_ctx *ctx, pd_sim *sim)
{
    pd_status status = pdi_footprint_check(ctx, &sim->setup, 0);
    int line = sim->setup.line[PD_PART_GRID];
    if (status >= 0) {
        status = pdi_model_build(ctx, &sim->setup, &sim->model);
        line = sim->model.line;
    }
    if (status < 0) pdi_run_blame(ctx, &sim->setup, line);
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
    if (status >= 0) status = pd_couple_start(ctx, &sim->model.couple);
    if (status < 0) {
        pd_sim_close(ctx, sim);
        return status;
    }
    sim->until = sim->setup.until;
    sim->time = sim->model.couple.time;
    sim->cells = 1;
    for (int d = 0; d < PD_DIM; d++) sim->cells *= sim->model.grid.n[d];
    return status;
}

pd_status pd_sim_step(pd_ctx *ctx, pd_sim *sim, double t_limit)
{
    if (!(t_limit > sim->time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "sim", "a step from %g s to %g s, expected a time ahead", sim->time,
                        t_limit);
    pd_status status = pd_couple_step(ctx, &sim->model.couple, t_limit);
    sim->time = sim->model.couple.time;
    sim->steps = sim->model.couple.steps;
    return status;
}

static void pdi_sim_fill(const pd_sim *sim, pd_field field, double *out)
{
    const pd_model *m = &sim->model;
    const pd_grid *g = &m->grid;
    int at[PD_DIM];
    memset(at, 0, sizeof at);
    for (int64_t cell = 0; cell < sim->cells; cell++) {
        int32_t i = pd_grid_node(g, at);
        if (field != PD_FIELD_V) out[cell] = pdi_sample_node(m, field, i);
        for (int d = 0; d < PD_DIM && field == PD_FIELD_V; d++)
            out[d * sim->cells + cell] = g->kind[i] == PD_FLUID ? m->flow.u[(int64_t)d * g->total + i] : 0.0;
        for (int d = 0; d < PD_DIM && ++at[d] == g->n[d]; d++) at[d] = 0;
    }
}

pd_status pd_sim_field(pd_ctx *ctx, pd_sim *sim, const char *name, pd_view *view)
{
    int field = 0;
    memset(view, 0, sizeof *view);
    while (field < PD_FIELD_COUNT && strcmp(pdi_setup_field_name((pd_field)field), name) != 0) field++;
    if (field == PD_FIELD_COUNT)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "sim",
                        "no field has the name %.40s, expected C, v, p, kind, grain, phase, D, rate, density or damage",
                        name);
    const char *needs = pdi_setup_field_needs(&sim->setup, (pd_field)field);
    if (needs) return pdi_fail(ctx, PD_ERR_ARGUMENT, "sim", "the field %s needs %s", name, needs);
    if (!sim->field[field])
        PDI_TRY(PDI_NEW(ctx, "sim", pdi_sim_components(field) * sim->cells, sim->field[field]));
    pdi_sample_prepare(ctx, &sim->model, 1u << field);
    pdi_sim_fill(sim, (pd_field)field, sim->field[field]);
    view->data = sim->field[field];
    view->label = pdi_setup_field_label((pd_field)field);
    view->components = pdi_sim_components(field);
    view->part = sim->cells;
    for (int d = 0; d < PD_DIM; d++) {
        view->n[d] = sim->model.grid.n[d];
        view->stride[d] = d ? view->stride[d - 1] * view->n[d - 1] : 1;
    }
    return PD_OK;
}

void pd_sim_keep(pd_sim *sim, const pd_view *view)
{
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (sim->field[k] == view->data) sim->field[k] = NULL;
}

void pd_sim_release(pd_ctx *ctx, pd_view *view)
{
    double *data = (double *)view->data; /* was allocated as such */
    PDI_DELETE(ctx, view->components * view->part, data);
    memset(view, 0, sizeof *view);
}

void pd_sim_close(pd_ctx *ctx, pd_sim *sim)
{
    for (int k = 0; k < PD_FIELD_COUNT; k++) PDI_DELETE(ctx, pdi_sim_components(k) * sim->cells, sim->field[k]);
    pdi_model_free(ctx, &sim->model);
    pd_setup_free(ctx, &sim->setup);
    memset(sim, 0, sizeof *sim);
}
