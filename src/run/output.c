/* output: see output.h */
#include "run/output.h"
#include "setup/fields.h"
#include "io/plot.h"
#include "io/paraview.h"
#include "scene/read_measured.h"
#include "physics/sample.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const pdi_output_diagnostics_columns[] = {"time [s]",
                                                             "volume_loss [-]",
                                                             "solid_nodes [-]",
                                                             "v_max [m/s]",
                                                             "C_max [mol/m3]",
                                                             "ledger [-]",
                                                             "flux [-]",
                                                             "dt [s]",
                                                             "step [-]",
                                                             "flow_solves [-]",
                                                             "flow_evals [-]",
                                                             "flow_krylov [-]",
                                                             "transport_krylov [-]",
                                                             "limiter [-]",
                                                             "momentum [-]",
                                                             "continuity [-]",
                                                             "front [m]"};
enum { PDI_OUTPUT_COLUMN_NAME = 88 }; /* [byte] of a column of the probes */
#define PDI_OUTPUT_DIAGNOSTICS_COLUMNS \
    ((int)(sizeof pdi_output_diagnostics_columns / sizeof pdi_output_diagnostics_columns[0]))

/* ---- fields ---- */

static const char *const pdi_output_node_kind_names[] = {"outside", "fluid", "metal", "wall"};
static const char *const pdi_output_phase_names[] = {"fluid or wall", "metal"};

/* 1: a field of the metal alone; files have NaN elsewhere. */
static int pdi_output_is_solid_field(const pd_setup *setup, pd_field field)
{
    return pd_fields_get_place(setup, field) == PD_FIELD_IN_METAL;
}

/* Sample the requested fields at all nodes into the arrays of out that are allocated. At nodes that are not metal,
 * fields of the metal alone and displacements are NaN, grain is -1 and phase 0. Prepares also the fields of pictures
 * and surface colours. */
static void pdi_output_compute_fields(pd_ctx *ctx, pd_output *out)
{
    pd_model *m = out->model;
    pd_fields drawn =
        pdi_surface_view_is_requested(m->setup) ? pd_fields_bit(pdi_surface_view_get_colour_field(m->setup)) : 0;
    pd_sample_prepare(ctx, m, m->setup->fields | m->setup->images | drawn);
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        for (int32_t i = 0; i < m->grid.total && out->scalar[k]; i++)
            out->scalar[k][i] = pdi_output_is_solid_field(m->setup, (pd_field)k) && m->grid.kind[i] != PD_SOLID
                                    ? (double)NAN
                                    : pd_sample_get_node(m, (pd_field)k, i);
    for (int64_t k = 0; k < (int64_t)PD_DIM * m->grid.total && out->displaced; k++) out->displaced[k] = (double)NAN;
    for (int32_t k = 0; k < m->solid.count && out->displaced; k++)
        for (int d = 0; d < PD_DIM; d++) {
            int32_t node = m->solid.node[k];
            if (m->grid.kind[node] != PD_SOLID) continue;
            out->displaced[(int64_t)d * m->grid.total + node] =
                pd_solid_coupling_displacements(&m->solid)[(int64_t)k * PD_DIM + d];
        }
    for (int32_t i = 0; i < m->grid.total && out->grain; i++)
        out->grain[i] = m->grid.kind[i] == PD_SOLID ? m->grain.id[i] : -1;
    for (int32_t i = 0; i < m->grid.total && out->phase; i++) out->phase[i] = m->grid.kind[i] == PD_SOLID;
}

/* List the requested fields for a VTI file in fields[PD_FIELD_COUNT], with names, units (kept in unit) and arrays,
 * which are borrowed; returns their number. */
static int pdi_output_list_fields(const pd_output *out, char (*unit)[PD_UNITS_TEXT], pd_vti_field *fields)
{
    const pd_model *m = out->model;
    int count = 0;
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        pd_vti_field *f = &fields[count];
        if (!((m->setup->fields >> k) & 1u)) continue;
        memset(f, 0, sizeof *f);
        f->name = pd_fields_get_name(m->setup, (pd_field)k);
        pd_fields_get_unit(m->setup, (pd_field)k, unit[k]);
        f->unit = unit[k][0] ? unit[k] : NULL;
        f->type = PD_VTI_FLOAT32;
        f->data = out->scalar[k];
        if (k == PD_FIELD_V) {
            f->vector = 1;
            f->data = pd_model_velocity(m);
        } else if (k == PD_FIELD_U) {
            f->vector = 1;
            f->data = out->displaced;
        } else if (k == PD_FIELD_KIND || k == PD_FIELD_PHASE) {
            f->type = PD_VTI_UINT8;
            f->data = k == PD_FIELD_KIND ? m->grid.kind : out->phase;
            f->value_names = k == PD_FIELD_KIND ? pdi_output_node_kind_names : pdi_output_phase_names;
            f->value_name_count = k == PD_FIELD_KIND ? 4 : 2;
        } else if (k == PD_FIELD_GRAIN) {
            f->type = PD_VTI_INT32;
            f->data = out->grain;
        }
        count++;
    }
    return count;
}

/* Path of an output file at this time, such as "FOLDER/corr_000012_t6.1s.vti", into path[PD_PATH_SIZE]; it is added to
 * the list of the folder. */
static pd_status pdi_output_format_path(pd_ctx *ctx, const pd_output *out, const char *prefix, const char *extension,
                                        char *path)
{
    char name[PD_PATH_SIZE];
    PD_TRY(pdi_file_format_frame_name(ctx, prefix, out->frame, out->model->time_loop.time, extension, name));
    return pdi_output_folder_add_file(ctx, out->folder, name, path);
}

/* Write the fields as a VTI file and add it to the PVD collection; nothing where no field is requested. */
static pd_status pdi_output_write_vti(pd_ctx *ctx, pd_output *out)
{
    char path[PD_PATH_SIZE], unit[PD_FIELD_COUNT][PD_UNITS_TEXT];
    pd_vti_field fields[PD_FIELD_COUNT];
    int count = pdi_output_list_fields(out, unit, fields);
    double time = out->model->time_loop.time;
    if (count == 0) return PD_OK;
    PD_TRY(pdi_output_format_path(ctx, out, out->model->setup->prefix, "vti", path));
    PD_TRY(pd_vti_write(ctx, path, &out->model->grid, time, fields, count));
    return pdi_pvd_add_file(ctx, &out->pvd, time, path);
}

/* ---- tables ---- */

/* Names or values of the columns of the probe table (time [s], then fields, v by components), as many as fit into room;
 * returns their number. Either may be NULL. */
static int pdi_output_compute_probe_row(const pd_output *out, char names[][PDI_OUTPUT_COLUMN_NAME], double *values,
                                        int room)
{
    const pd_model *m = out->model;
    int count = 0;
    if (values) values[0] = m->time_loop.time;
    if (names) snprintf(names[0], PDI_OUTPUT_COLUMN_NAME, "time [s]");
    count = 1;
    for (int k = 0; k < m->setup->probes; k++)
        for (int f = 0; f < PD_FIELD_COUNT; f++) {
            const pd_setup_probe *p = &m->setup->probe[k];
            int parts = pd_fields_count_components((pd_field)f);
            for (int d = 0; d < parts && ((p->fields >> f) & 1u) && count < room; d++, count++) {
                char unit[PD_UNITS_TEXT];
                pd_fields_get_unit(m->setup, (pd_field)f, unit);
                if (names)
                    snprintf(names[count], PDI_OUTPUT_COLUMN_NAME, "%.40s_%.14s%s [%.23s]", p->name,
                             pd_fields_get_name(m->setup, (pd_field)f), pd_fields_get_axis((pd_field)f, d),
                             unit[0] ? unit : "-");
                if (!values) continue;
                values[count] = pd_sample_get_probe(m, (pd_field)f, d, p->position);
            }
        }
    return count;
}

/* Create probes.csv and enter it in the list of the folder; nothing without probes. Columns beyond PD_CSV_MAX_COLUMNS
 * are left out. */
static pd_status pdi_output_begin_probe_table(pd_ctx *ctx, pd_output *out)
{
    char names[PD_CSV_MAX_COLUMNS][PDI_OUTPUT_COLUMN_NAME], path[PD_PATH_SIZE];
    const char *list[PD_CSV_MAX_COLUMNS];
    if (out->model->setup->probes == 0) return PD_OK;
    int count = pdi_output_compute_probe_row(out, names, NULL, PD_CSV_MAX_COLUMNS);
    for (int k = 0; k < count; k++) list[k] = names[k];
    PD_TRY(pdi_output_folder_add_file(ctx, out->folder, "probes.csv", path));
    return pd_csv_create(ctx, path, list, count, &out->probes);
}

/* Create diagnostics.csv, and probes.csv if there are probes. */
static pd_status pdi_output_begin_tables(pd_ctx *ctx, pd_output *out)
{
    char path[PD_PATH_SIZE];
    PD_TRY(pdi_output_folder_add_file(ctx, out->folder, "diagnostics.csv", path));
    PD_TRY(pd_csv_create(ctx, path, pdi_output_diagnostics_columns, PDI_OUTPUT_DIAGNOSTICS_COLUMNS, &out->diagnostics));
    return pdi_output_begin_probe_table(ctx, out);
}

/* Append time [s], kept in hours, and volume loss [-] to the loss curve. */
static pd_status pdi_output_append_loss(pd_ctx *ctx, pd_output *out, double time, double loss)
{
    int64_t fresh = 2 * out->rows + 256;
    if (out->rows == out->time_room) {
        PD_TRY(PD_GROW(ctx, "output", out->time_room, fresh, out->time));
        out->time_room = fresh;
    }
    if (out->rows == out->loss_room) {
        PD_TRY(PD_GROW(ctx, "output", out->loss_room, fresh, out->loss));
        out->loss_room = fresh;
    }
    out->time[out->rows] = time / 3600.0;
    out->loss[out->rows++] = loss;
    return PD_OK;
}

PDI_FN pd_status pdi_output_write_rows(pd_ctx *ctx, pd_output *out, const pd_step_diagnostics *o)
{
    const pd_time_loop *c = &out->model->time_loop;
    double row[PDI_OUTPUT_DIAGNOSTICS_COLUMNS], probe[PD_CSV_MAX_COLUMNS];
    pd_model_statistics effort;
    int k = 0;
    pd_model_get_statistics(out->model, &effort);
    row[k++] = c->time;
    row[k++] = o->volume_loss;
    row[k++] = (double)out->model->grid.solid_count;
    row[k++] = o->v_max;
    row[k++] = o->c_max;
    row[k++] = pd_time_loop_imbalance(c);
    row[k++] = o->flux_error;
    row[k++] = c->dt;
    row[k++] = (double)c->steps;
    row[k++] = (double)effort.flow_solves;
    row[k++] = (double)effort.flow_evaluations;
    row[k++] = (double)effort.flow_krylov;
    row[k++] = (double)effort.transport_krylov;
    row[k++] = (double)effort.limiter_iterations;
    row[k++] = effort.momentum;
    row[k++] = effort.continuity;
    row[k++] = o->corrosion_depth;
    PD_ASSERT(k == PDI_OUTPUT_DIAGNOSTICS_COLUMNS);
    PD_TRY(pd_csv_write_row(ctx, &out->diagnostics, row));
    PD_TRY(pdi_output_append_loss(ctx, out, c->time, o->volume_loss));
    const pd_setup *u = out->model->setup;
    if (u->probes == 0) return PD_OK;
    pd_fields fields = 0;
    for (int n = 0; n < u->probes; n++) fields |= u->probe[n].fields;
    pd_sample_prepare(ctx, out->model, fields);
    pdi_output_compute_probe_row(out, NULL, probe, PD_CSV_MAX_COLUMNS);
    return pd_csv_write_row(ctx, &out->probes, probe);
}

/* ---- life ---- */

/* Allocate the arrays of the fields that go to files: plain scalars, phase, grain, displacement. Velocity and kind are
 * taken from the model; images have arrays of their own. */
static pd_status pdi_output_allocate(pd_ctx *ctx, pd_output *out)
{
    const pd_model *m = out->model;
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        if (!((m->setup->fields >> k) & 1u)) continue;
        if (pd_fields_is_scalar((pd_field)k)) PD_TRY(PD_NEW(ctx, "output", m->grid.total, out->scalar[k]));
        if (k == PD_FIELD_PHASE) PD_TRY(PD_NEW(ctx, "output", m->grid.total, out->phase));
        if (k == PD_FIELD_GRAIN) PD_TRY(PD_NEW(ctx, "output", m->grid.total, out->grain));
        if (k == PD_FIELD_U) PD_TRY(PD_NEW(ctx, "output", (int64_t)PD_DIM * m->grid.total, out->displaced));
    }
    return PD_OK;
}

static const char *const pdi_output_loss_plot_names[2] = {"volume_loss.png", "volume_loss.svg"};

/* Zero out and prepare everything but the tables: arrays, pictures, an empty PVD collection. No file is written. On
 * failure the caller frees. */
static pd_status pdi_output_build(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_output *out)
{
    char path[PD_PATH_SIZE];
    memset(out, 0, sizeof *out);
    out->model = model;
    out->last_frame_time = -1.0;
    out->folder = folder;
    PD_TRY(pdi_output_allocate(ctx, out));
    PD_TRY(pdi_pictures_build(ctx, model, folder, &out->images));
    PD_TRY(pd_file_join(ctx, folder->path, "simulation.pvd", path));
    return pdi_pvd_init(ctx, path, &out->pvd);
}

PDI_FN pd_status pdi_output_open(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_output *out)
{
    char path[PD_PATH_SIZE];
    PD_TRY(pdi_output_build(ctx, model, folder, out));
    PD_TRY(pdi_output_folder_add_file(ctx, folder, "simulation.pvd", path));
    PD_TRY(pdi_pictures_begin_frame_file(ctx, &out->images));
    if (model->setup->fields) {
        PD_TRY(pdi_output_folder_add_file(ctx, folder, PD_OUTPUT_FOLDER_SCRIPT, path));
        PD_TRY(pdi_paraview_write_script(ctx, path));
    }
    return pdi_output_begin_tables(ctx, out);
}

/* Store frame number, time of the last fields, PVD entries, pictures and loss curve in a checkpoint, or load them,
 * growing the curve. The tables are not part of it. */
static pd_status pdi_output_store(pd_ctx *ctx, pd_output *out, pd_archive *archive)
{
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "frame", &out->frame, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "time of the last frame", &out->last_frame_time, 1));
    PD_TRY(pdi_pvd_store(ctx, &out->pvd, archive));
    PD_TRY(pdi_pictures_store(ctx, &out->images, archive));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "listed curves", out->curve, 2));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "rows", &out->rows, 1));
    if (out->rows > out->time_room) {
        PD_TRY(PD_GROW(ctx, "output", out->time_room, out->rows, out->time));
        out->time_room = out->rows;
    }
    if (out->rows > out->loss_room) {
        PD_TRY(PD_GROW(ctx, "output", out->loss_room, out->rows, out->loss));
        out->loss_room = out->rows;
    }
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "times of the curve", out->time, out->rows));
    return PD_ARCHIVE_ARRAY(ctx, archive, "losses of the curve", out->loss, out->rows);
}

PDI_FN pd_status pdi_output_save(pd_ctx *ctx, pd_output *out, pd_archive *archive)
{
    PD_TRY(pdi_output_store(ctx, out, archive));
    PD_TRY(pdi_csv_store(ctx, archive, NULL, 0, &out->diagnostics));
    return out->model->setup->probes ? pdi_csv_store(ctx, archive, NULL, 0, &out->probes) : PD_OK;
}

PDI_FN pd_status pdi_output_resume(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_archive *archive,
                                   pd_output *out)
{
    char path[PD_PATH_SIZE];
    PD_TRY(pdi_output_build(ctx, model, folder, out));
    PD_TRY(pdi_output_store(ctx, out, archive));
    PD_TRY(pd_file_join(ctx, folder->path, "diagnostics.csv", path));
    PD_TRY(pdi_csv_store(ctx, archive, path, PDI_OUTPUT_DIAGNOSTICS_COLUMNS, &out->diagnostics));
    if (model->setup->probes == 0) return PD_OK;
    PD_TRY(pd_file_join(ctx, folder->path, "probes.csv", path));
    return pdi_csv_store(ctx, archive, path, pdi_output_compute_probe_row(out, NULL, NULL, PD_CSV_MAX_COLUMNS),
                         &out->probes);
}

/* Add measured losses to the plot of the curve, in %, a series for each set of volume_loss, as many as fit; the curve
 * is then named "computed". unit [s]: of the time axis; last [s]: end of the curve; work[3 points of all records]:
 * memory of the series. */
static void pdi_output_add_measured_series(const pd_output *out, double unit, double last, double *work, pd_plot *plot)
{
    const pd_setup *u = out->model->setup;
    for (int k = 0; k < u->measured_count && plot->count < PD_PLOT_MAX_SERIES; k++) {
        if (strcmp(u->measured[k].output_name, "volume_loss") != 0) continue;
        pdi_read_measured_build_series(&u->measured[k], unit, 0.01, last, work, &plot->series[plot->count++]);
        work += 3 * u->measured[k].points;
    }
    if (plot->count > 1) plot->series[0].name = "computed";
}

/* Draw the volume loss [%] over time so far into volume_loss.png and .svg, as requested (PNG by default), and enter
 * them in the list of the folder the first time. Time is in s if the last one is below an hour, else in h. Nothing
 * without dissolution or with fewer than two rows. */
static pd_status pdi_output_draw_loss_curve(pd_ctx *ctx, pd_output *out)
{
    const pd_setup *u = out->model->setup;
    char path[PD_PATH_SIZE];
    double *work = NULL;
    int64_t points = 2 * out->rows;
    pd_plot plot;
    if (!u->has_dissolve || out->rows < 2) return PD_OK;
    double last = 3600.0 * out->time[out->rows - 1];
    int brief = last < 3600.0;
    for (int k = 0; k < u->measured_count; k++) points += 3 * u->measured[k].points;
    PD_TRY(PD_NEW(ctx, "output", points, work));
    for (int64_t k = 0; k < out->rows; k++) {
        work[k] = brief ? 3600.0 * out->time[k] : out->time[k];
        work[out->rows + k] = 100.0 * out->loss[k];
    }
    memset(&plot, 0, sizeof plot);
    plot.title = u->name;
    plot.x_label = brief ? "t [s]" : "t [h]";
    plot.y_label = "volume loss [%]";
    plot.count = 1;
    plot.series[0].x = work;
    plot.series[0].y = work + out->rows;
    plot.series[0].count = (int)out->rows;
    pdi_output_add_measured_series(out, brief ? 1.0 : 3600.0, last, work + 2 * out->rows, &plot);
    pd_status status = PD_OK;
    for (int k = 0; k < 2 && status == PD_OK; k++) {
        if (!((u->drawing.formats ? u->drawing.formats : 1u) >> k & 1u)) continue;
        status = out->curve[k] ? pd_file_join(ctx, out->folder->path, pdi_output_loss_plot_names[k], path)
                               : pdi_output_folder_add_file(ctx, out->folder, pdi_output_loss_plot_names[k], path);
        if (status == PD_OK) out->curve[k] = 1;
        if (status == PD_OK) status = pd_plot_write(ctx, path, &plot);
    }
    PD_DELETE(ctx, points, work);
    return status;
}

PDI_FN pd_status pdi_output_write_frame(pd_ctx *ctx, pd_output *out)
{
    double time = out->model->time_loop.time;
    if (out->last_frame_time >= time) return PD_OK;
    pdi_output_compute_fields(ctx, out);
    PD_TRY(pdi_output_write_vti(ctx, out));
    PD_TRY(pdi_pictures_draw_frames(ctx, &out->images, out->frame));
    out->last_frame_time = time;
    out->frame++;
    return out->images.updates_latest ? pdi_output_draw_loss_curve(ctx, out) : PD_OK;
}

PDI_FN pd_status pdi_output_close(pd_ctx *ctx, pd_output *out, int over)
{
    if (over) PD_TRY(pdi_pictures_finish(ctx, &out->images));
    PD_TRY(pdi_output_draw_loss_curve(ctx, out));
    PD_TRY(pd_csv_close(ctx, &out->diagnostics));
    return pd_csv_close(ctx, &out->probes);
}

PDI_FN void pdi_output_free(pd_ctx *ctx, pd_output *out)
{
    pd_ctx quiet = *ctx; /* a failure to close must not hide an earlier message */
    int32_t total = out->model ? out->model->grid.total : 0;
    pd_csv_close(&quiet, &out->diagnostics);
    pd_csv_close(&quiet, &out->probes);
    pdi_pictures_free(ctx, &out->images);
    pdi_pvd_free(ctx, &out->pvd);
    for (int k = 0; k < PD_FIELD_COUNT; k++) PD_DELETE(ctx, total, out->scalar[k]);
    PD_DELETE(ctx, total, out->phase);
    PD_DELETE(ctx, total, out->grain);
    PD_DELETE(ctx, (int64_t)PD_DIM * total, out->displaced);
    PD_DELETE(ctx, out->time_room, out->time);
    PD_DELETE(ctx, out->loss_room, out->loss);
    memset(out, 0, sizeof *out);
}

#undef PDI_OUTPUT_DIAGNOSTICS_COLUMNS
