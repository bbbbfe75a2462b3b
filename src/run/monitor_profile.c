/* monitor_profile: see monitor_profile.h */
#include "run/monitor_profile.h"
#include "setup/fields.h"
#include "io/plot.h"
#include "physics/sample.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Copy the name of a column into names[column]; returns the next column. */
static int pdi_monitor_profile_set_column_name(char names[][PD_SETUP_NAME], int column, const char *name)
{
    snprintf(names[column], PD_SETUP_NAME, "%s", name);
    return column + 1;
}

/* Names of the columns of a line: arc length, position, the requested fields (v by components), with units, "-" for
 * none. first[PD_FIELD_COUNT]: column of each field; of one that is not requested, of the next one. Returns the number
 * of columns. */
static int pdi_monitor_profile_name_line_columns(const pd_setup *setup, const pd_monitor *m,
                                                 char names[][PD_SETUP_NAME], int *first)
{
    char name[PD_SETUP_NAME];
    int count = pdi_monitor_profile_set_column_name(names, 0, "s [m]");
    for (int d = 0; d < PD_DIM; d++) {
        snprintf(name, sizeof name, "%c [m]", "xyz"[d]);
        count = pdi_monitor_profile_set_column_name(names, count, name);
    }
    for (int f = 0; f < PD_FIELD_COUNT; f++) {
        first[f] = count;
        if (!((m->desc->fields >> f) & 1u)) continue;
        for (int d = 0; d < pd_fields_count_components((pd_field)f); d++) {
            char unit[PD_UNITS_TEXT];
            pd_fields_get_unit(setup, (pd_field)f, unit);
            snprintf(name, sizeof name, "%.36s%s [%.22s]", pd_fields_get_name(setup, (pd_field)f),
                     pd_fields_get_axis((pd_field)f, d), unit[0] ? unit : "-");
            count = pdi_monitor_profile_set_column_name(names, count, name);
        }
    }
    return count;
}

/* Names of the columns of the profile of a mass transfer: position, area, flux density, and with a reference length
 * C_fluid and Sh. Returns their number, 3 or 5. */
static int pdi_monitor_profile_name_transfer_columns(const pd_setup *setup, const pd_monitor *m,
                                                     char names[][PD_SETUP_NAME])
{
    char name[PD_SETUP_NAME];
    int count;
    snprintf(name, sizeof name, "%c [m]", "xyz"[m->desc->axis]);
    count = pdi_monitor_profile_set_column_name(names, 0, name);
    snprintf(name, sizeof name, "area [%s]", pdi_monitor_outputs_get_area_unit(setup));
    count = pdi_monitor_profile_set_column_name(names, count, name);
    count = pdi_monitor_profile_set_column_name(names, count, "density [mol/m2/s]");
    if (!(m->desc->length > 0.0)) return count;
    count = pdi_monitor_profile_set_column_name(names, count, "C_fluid [mol/m3]");
    return pdi_monitor_profile_set_column_name(names, count, "Sh [-]");
}

/* Sample the requested fields at m->rows points (2 or more), evenly spaced from d->lo to d->hi with both ends, into
 * profile[rows][columns]: arc length from lo, position, fields by components, NaN where a field has no value. Call
 * pd_sample_prepare before. */
static void pdi_monitor_profile_compute_line(const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    for (int k = 0; k < m->rows; k++) {
        double *row = m->profile + (int64_t)k * m->columns, *x = row + 1, share = k / (m->rows - 1.0), square = 0.0;
        int column = 1 + PD_DIM;
        for (int a = 0; a < PD_DIM; a++) {
            x[a] = (1.0 - share) * d->lo[a] + share * d->hi[a];
            square += (x[a] - d->lo[a]) * (x[a] - d->lo[a]);
        }
        row[0] = sqrt(square);
        for (int f = 0; f < PD_FIELD_COUNT; f++)
            for (int c = 0; c < pd_fields_count_components((pd_field)f) && ((d->fields >> f) & 1u); c++)
                row[column++] = pd_sample_get_point(model, (pd_field)f, c, x);
    }
}

/* Fill profile[rows][columns] of a mass transfer from m->flux, m->area and m->fluid: cell centre along the axis, area,
 * flux density (NaN without area); with a reference length also C_fluid and the local Sherwood number with the
 * difference C_surface - C_fluid of the layer. */
static void pdi_monitor_profile_compute_transfer(const pd_model *model, pd_monitor *m)
{
    const pd_setup_monitor *d = m->desc;
    for (int k = 0; k < m->rows; k++) {
        double *row = m->profile + (int64_t)k * m->columns;
        row[0] = model->grid.lo[d->axis] + (k + 0.5) * model->grid.h[d->axis];
        row[1] = m->area[k];
        row[2] = m->area[k] > 0.0 ? m->flux[k] / m->area[k] : (double)NAN;
        if (!(d->length > 0.0)) continue;
        row[3] = m->fluid[k];
        row[4] = row[2] * d->length / ((d->surface_c - m->fluid[k]) * d->diffusivity);
    }
}

/* Plot `count` columns of the profile from `first` on over column 0, drawn in um if its last value is below 2 mm, in mm
 * below 2 m, else in m. axis: name of column 0; label: of the values. Series are named x, y, z if there are several.
 * PD_OK and no file where no value is finite. */
static pd_status pdi_monitor_profile_draw(pd_ctx *ctx, const pd_model *model, const pd_monitor *m, int first, int count,
                                          const char *axis, const char *label, const char *path)
{
    char title[PD_SETUP_NAME + 2 * PD_UNITS_TEXT], stamp[PD_UNITS_TEXT], x_label[16];
    static const char *const names[] = {"x", "y", "z"};
    double *work = NULL, last = m->profile[(int64_t)(m->rows - 1) * m->columns];
    double unit = last < 2e-3 ? 1e6 : last < 2.0 ? 1e3 : 1.0;
    int64_t size = (int64_t)(count + 1) * m->rows, shown = 0;
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    PD_TRY(PD_NEW(ctx, "monitor", size, work));
    for (int k = 0; k < m->rows; k++) {
        const double *row = m->profile + (int64_t)k * m->columns;
        work[k] = unit * row[0];
        for (int c = 0; c < count; c++) {
            work[(int64_t)(c + 1) * m->rows + k] = row[first + c];
            shown += fabs(row[first + c]) < HUGE_VAL;
        }
    }
    pd_setup_format_value(model->time_loop.time, "s", stamp);
    snprintf(title, sizeof title, "%.60s: %.40s, t = %s", model->setup->name, m->desc->name, stamp);
    snprintf(x_label, sizeof x_label, "%s [%s]", axis, unit > 1e4 ? "um" : unit > 10.0 ? "mm" : "m");
    plot.title = title;
    plot.x_label = x_label;
    plot.y_label = label;
    plot.count = count;
    for (int c = 0; c < count; c++) {
        plot.series[c].name = count > 1 ? names[c] : NULL;
        plot.series[c].x = work;
        plot.series[c].y = work + (int64_t)(c + 1) * m->rows;
        plot.series[c].count = m->rows;
    }
    pd_status status = shown ? pd_plot_write(ctx, path, &plot) : PD_OK;
    PD_DELETE(ctx, size, work);
    return status;
}

/* Path "FOLDER/line_NAME_C_000012_t6.1s.png" into path[PD_PATH_SIZE], added to the list of the folder; field "":
 * without it. */
static pd_status pdi_monitor_profile_format_path(pd_ctx *ctx, const pd_model *model, pd_output_folder *folder,
                                                 const pd_monitor *m, const char *field, int frame,
                                                 const char *extension, char *path)
{
    char prefix[2 * PD_SETUP_NAME], name[PD_PATH_SIZE];
    snprintf(prefix, sizeof prefix, "%s_%s%s%s", pd_setup_monitor_section_name(m->desc->kind), m->desc->name,
             field[0] ? "_" : "", field);
    PD_TRY(pdi_file_format_frame_name(ctx, prefix, frame, model->time_loop.time, extension, name));
    return pdi_output_folder_add_file(ctx, folder, name, path);
}

/* Plot each field of m->desc->images over a line, one file a field. first[f]: column of field f. */
static pd_status pdi_monitor_profile_draw_line(pd_ctx *ctx, const pd_model *model, pd_output_folder *folder,
                                               const pd_monitor *m, const int *first, int frame)
{
    char path[PD_PATH_SIZE];
    for (int f = 0; f < PD_FIELD_COUNT; f++) {
        if (!((m->desc->images >> f) & 1u)) continue;
        const char *name = pd_fields_get_name(model->setup, (pd_field)f);
        PD_TRY(pdi_monitor_profile_format_path(ctx, model, folder, m, name, frame, "png", path));
        PD_TRY(pdi_monitor_profile_draw(ctx, model, m, first[f], pd_fields_count_components((pd_field)f), "s",
                                        pd_fields_get_label(model->setup, (pd_field)f), path));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_monitor_profile_write(pd_ctx *ctx, pd_model *model, pd_output_folder *folder, pd_monitor *m,
                                           int frame)
{
    char names[1 + PD_DIM + PD_FIELD_COUNT + PD_DIM][PD_SETUP_NAME], path[PD_PATH_SIZE];
    const char *list[1 + PD_DIM + PD_FIELD_COUNT + PD_DIM];
    const pd_setup_monitor *d = m->desc;
    int first[PD_FIELD_COUNT], line = d->kind == PD_MONITOR_LINE;
    const pd_setup *u = model->setup;
    int count = line ? pdi_monitor_profile_name_line_columns(u, m, names, first)
                     : pdi_monitor_profile_name_transfer_columns(u, m, names);
    for (int k = 0; k < count; k++) list[k] = names[k];
    if (line) pd_sample_prepare(ctx, model, d->fields);
    if (line) pdi_monitor_profile_compute_line(model, m);
    else pdi_monitor_profile_compute_transfer(model, m);
    PD_TRY(pdi_monitor_profile_format_path(ctx, model, folder, m, "", frame, "csv", path));
    PD_TRY(pdi_csv_write_table(ctx, path, list, count, m->profile, m->rows));
    if (line) return pdi_monitor_profile_draw_line(ctx, model, folder, m, first, frame);
    int sherwood = d->length > 0.0;
    PD_TRY(pdi_monitor_profile_format_path(ctx, model, folder, m, sherwood ? "Sh" : "density", frame, "png", path));
    return pdi_monitor_profile_draw(ctx, model, m, sherwood ? 4 : 2, 1,
                                    d->axis == 0   ? "x"
                                    : d->axis == 1 ? "y"
                                                   : "z",
                                    sherwood ? "Sh [-]" : "density [mol/m2/s]", path);
}
