/* monitor: see monitor.h */
#include "run/monitor.h"
#include "run/monitor_profile.h"
#include "setup/fields.h"
#include "physics/sample.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* File name of the table, such as "plane_up.csv". */
static void pdi_monitor_format_table_name(const pd_monitor *m, char name[2 * PD_SETUP_NAME])
{
    snprintf(name, 2 * PD_SETUP_NAME, "%s_%s.csv", pd_setup_monitor_section_name(m->desc->kind), m->desc->name);
}

/* Enter the table of a monitor in the list of the folder, create it with the column time and one for each present
 * output, and open it. Errors of pd_csv_create. */
static pd_status pdi_monitor_begin_table(pd_ctx *ctx, const pd_monitors *all, pd_monitor *m)
{
    char names[PD_MONITOR_MAX_OUTPUTS + 1][64], name[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    const char *list[PD_MONITOR_MAX_OUTPUTS + 1];
    snprintf(names[0], sizeof names[0], "time [s]");
    for (int k = 0; k < m->count; k++)
        snprintf(names[k + 1], sizeof names[0], "%s [%s]", m->output[k].key, m->output[k].unit);
    for (int k = 0; k <= m->count; k++) list[k] = names[k];
    pdi_monitor_format_table_name(m, name);
    PD_TRY(pdi_output_folder_add_file(ctx, all->folder, name, path));
    return pd_csv_create(ctx, path, list, m->count + 1, &m->table);
}

/* Allocate m->output (more with chemistry), and for a line or transfer the profile; set rows and columns. A transfer
 * also gets its layers: one for each cell along its axis, or one without an axis. rows is 0 for all other kinds. On
 * failure the caller frees. */
static pd_status pdi_monitor_allocate(pd_ctx *ctx, const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    m->capacity = model->setup->has_chemistry ? PD_MONITOR_MAX_OUTPUTS : PD_MONITOR_MAX_OUTPUTS_NO_SPECIES;
    PD_TRY(PD_NEW(ctx, "monitor", m->capacity, m->output));
    m->rows = d->kind == PD_MONITOR_LINE ? d->points : 0;
    m->columns = 1 + PD_DIM;
    for (int f = 0; f < PD_FIELD_COUNT; f++)
        if ((d->fields >> f) & 1u) m->columns += pd_fields_count_components((pd_field)f);
    if (d->kind == PD_MONITOR_TRANSFER) {
        m->rows = d->axis < 0 ? 1 : model->grid.n[d->axis];
        m->columns = d->length > 0.0 ? 5 : 3;
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->flux));
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->area));
        PD_TRY(PD_NEW(ctx, "monitor", m->rows, m->fluid));
    }
    return m->rows ? PD_NEW(ctx, "monitor", (int64_t)m->rows * m->columns, m->profile) : PD_OK;
}

/* Set the message for a probe within a wall; with its depth where the distance to the wall shape is known (smooth
 * shapes). Returns PD_ERR_GEOMETRY. */
static pd_status pdi_monitor_reject_probe(pd_ctx *ctx, const pd_model *model, const pd_setup_probe *probe)
{
    const pd_setup *u = model->setup;
    char deep[PD_UNITS_TEXT];
    if (u->wall < 0 || !pd_shape_is_smooth(u->shape, u->wall))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "probe",
                       "'%s' stands in the wall, expected a place in the fluid or metal, or on a surface: move it",
                       probe->name);
    pd_setup_format_value(fabs(pd_shape_distance(u->shape, u->wall, probe->position)), "m", deep);
    return pd_fail(ctx, PD_ERR_GEOMETRY, "probe",
                   "'%s' stands in the wall, %s behind its surface, expected a place in the fluid or metal, or on a "
                   "surface: move it by that much", probe->name, deep);
}

/* Zero all, refuse probes deep in a wall (PD_ERR_GEOMETRY), then allocate each monitor and compute its outputs once, so
 * that they can be refused before the run. Forces are due again at the first step. all->error_line is the line of the
 * section in work; the caller frees on failure. */
static pd_status pdi_monitor_build_inner(pd_ctx *ctx, pd_model *model, pd_monitors *all)
{
    const pd_setup *u = model->setup;
    memset(all, 0, sizeof *all);
    all->model = model;
    for (int k = 0; k < u->probes; k++) {
        all->error_line = u->probe[k].line;
        if (!pd_sample_is_inside(model, u->probe[k].position))
            return pdi_monitor_reject_probe(ctx, model, &u->probe[k]);
    }
    for (int k = 0; k < u->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        m->desc = &u->monitor[k];
        m->flow_solves = -1;
        all->error_line = m->desc->line;
        PD_TRY(pdi_monitor_allocate(ctx, model, m));
        PD_TRY(pdi_monitor_outputs_compute(ctx, model, m));
        m->flow_solves = -1;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_build(pd_ctx *ctx, pd_model *model, pd_monitors *all)
{
    pd_status status = pdi_monitor_build_inner(ctx, model, all);
    int line = all->error_line;
    if (status < 0) pdi_monitors_free(ctx, all);
    all->error_line = line;
    return status;
}

PDI_FN pd_status pdi_monitors_save(pd_ctx *ctx, pd_monitors *all, pd_archive *archive)
{
    for (int k = 0; k < all->model->setup->monitors; k++)
        if (all->monitor[k].count) PD_TRY(pdi_csv_store(ctx, archive, NULL, 0, &all->monitor[k].table));
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_resume(pd_ctx *ctx, pd_monitors *all, pd_output_folder *folder, pd_archive *archive)
{
    char name[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    all->folder = folder;
    for (int k = 0; k < all->model->setup->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        if (m->count == 0) continue;
        pdi_monitor_format_table_name(m, name);
        PD_TRY(pd_file_join(ctx, folder->path, name, path));
        PD_TRY(pdi_csv_store(ctx, archive, path, m->count + 1, &m->table));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_open(pd_ctx *ctx, pd_monitors *all, pd_output_folder *folder)
{
    all->folder = folder;
    for (int k = 0; k < all->model->setup->monitors; k++)
        if (all->monitor[k].count) PD_TRY(pdi_monitor_begin_table(ctx, all, &all->monitor[k]));
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_step(pd_ctx *ctx, pd_monitors *all)
{
    double row[PD_MONITOR_MAX_OUTPUTS + 1];
    int count = all->model->setup->monitors;
    if (count == 0) return PD_OK;
    pd_sample_prepare(ctx, all->model, 0);
    /* sources belong to a step: before the first one they are those that it starts with */
    if (all->model->setup->has_dissolve && all->model->time_loop.steps == 0)
        PD_TRY(pd_dissolve_prepare(ctx, &all->model->dissolve));
    for (int k = 0; k < count; k++) {
        pd_monitor *m = &all->monitor[k];
        PD_TRY(pdi_monitor_outputs_compute(ctx, all->model, m));
        if (m->count == 0 || !m->table.file.stream) continue;
        row[0] = all->model->time_loop.time;
        for (int f = 0; f < m->count; f++) row[f + 1] = m->output[f].value;
        PD_TRY(pd_csv_write_row(ctx, &m->table, row));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_write_frame(pd_ctx *ctx, pd_monitors *all, int frame)
{
    for (int k = 0; k < all->model->setup->monitors; k++) {
        pd_monitor *m = &all->monitor[k];
        if (m->rows > 1) PD_TRY(pdi_monitor_profile_write(ctx, all->model, all->folder, m, frame));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitors_close(pd_ctx *ctx, pd_monitors *all)
{
    for (int k = 0; k < all->model->setup->monitors; k++) PD_TRY(pd_csv_close(ctx, &all->monitor[k].table));
    return PD_OK;
}

PDI_FN void pdi_monitors_free(pd_ctx *ctx, pd_monitors *all)
{
    pd_ctx quiet = *ctx; /* a failure to close must not hide an earlier message */
    for (int k = 0; k < PD_SETUP_MONITORS; k++) {
        pd_monitor *m = &all->monitor[k];
        pd_csv_close(&quiet, &m->table);
        PD_DELETE(ctx, m->capacity, m->output);
        PD_DELETE(ctx, (int64_t)m->rows * m->columns, m->profile);
        PD_DELETE(ctx, m->rows, m->flux);
        PD_DELETE(ctx, m->rows, m->area);
        PD_DELETE(ctx, m->rows, m->fluid);
    }
    memset(all, 0, sizeof *all);
}
