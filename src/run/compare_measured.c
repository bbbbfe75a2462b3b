/* compare_measured: see compare_measured.h */
#include "run/result_line.h"
#include "run/compare_measured.h"
#include "io/plot.h"
#include "scene/read_measured.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_COMPARE_MEASURED_TIME_TOLERANCE 1e-9 /* [-] relative tolerance by which two times are the same */

/* Name of an output, as "volume_loss" or "plane.up.flow", into text[size]. */
static void pdi_compare_measured_format_output_name(const pd_scalar_output *f, char *text, size_t size)
{
    if (strcmp(f->section, "scene") == 0) snprintf(text, size, "%s", f->key);
    else snprintf(text, size, "%s.%s.%s", f->section, f->name, f->key);
}

/* Value of the output with that name, summed with weights over planes of a coarser lattice, and its unit[16] (or NULL).
 * Returns 1; 0: there is no such output, and *value is 0. */
static int pdi_compare_measured_get_output(const pd_measured_comparison *c, const char *figure, double *value,
                                           char *unit)
{
    char name[2 * PD_SETUP_NAME];
    int found = 0;
    *value = 0.0;
    for (int k = 0; k < c->figures.count; k++) {
        const pd_scalar_output *f = &c->figures.list[k];
        pdi_compare_measured_format_output_name(f, name, sizeof name);
        if (strcmp(name, figure) != 0) continue;
        *value += (c->monitor_weight && f->monitor >= 0 ? c->monitor_weight[f->monitor] : 1.0) * f->value;
        if (unit) memcpy(unit, f->unit, sizeof f->unit);
        found = 1;
    }
    return found;
}

/* Error message with a list of all outputs. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_compare_measured_reject_output(pd_ctx *ctx, const pd_measured_comparison *c,
                                                    const pd_setup_measured *r)
{
    char list[320] = "", name[2 * PD_SETUP_NAME];
    for (int k = 0; k < c->figures.count; k++) {
        size_t used = strlen(list);
        pdi_compare_measured_format_output_name(&c->figures.list[k], name, sizeof name);
        if (strstr(list, name)) continue;
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", name);
    }
    return pd_fail(ctx, PD_ERR_ARGUMENT, "measured", "found of = %.80s, expected a figure that the run watches: %s",
                   r->output_name, list[0] ? list : "it watches none");
}

/* Check that a measured set names an output of the run of the same physical dimension. PD_ERR_ARGUMENT: no such output,
 * with a list of all, or another dimension. */
static pd_status pdi_compare_measured_check_figure(pd_ctx *ctx, const pd_measured_comparison *c,
                                                   const pd_setup_measured *r)
{
    char unit[16], found[PD_UNITS_TEXT], wanted[PD_UNITS_TEXT];
    double value;
    pd_dims dims;
    if (!pdi_compare_measured_get_output(c, r->output_name, &value, unit))
        return pdi_compare_measured_reject_output(ctx, c, r);
    if (strcmp(unit, "-") == 0) unit[0] = '\0';
    PD_TRY(pd_units_parse(ctx, unit, NULL, &dims));
    if (pd_units_is_same(&dims, &r->dims)) return PD_OK;
    pd_units_describe(&r->dims, found);
    pd_units_describe(&dims, wanted);
    return pd_fail(ctx, PD_ERR_ARGUMENT, "measured",
                   "the values of %.60s are %s, expected %s as %.80s is: write the"
                   " unit of the column behind 'in'",
                   r->name, found, wanted, r->output_name);
}

/* Zero and fill the comparison, with NaN for all computed values. Outputs are collected only if there are measured
 * sets. The caller frees on failure; c->error_line is the line of the set in work. */
static pd_status pdi_compare_measured_build_inner(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors,
                                                  const double *share, int curves, pd_measured_comparison *c)
{
    memset(c, 0, sizeof *c);
    c->model = model;
    c->monitors = monitors;
    c->monitor_weight = share;
    c->keeps_curves = curves;
    if (model->setup->measured_count) PD_TRY(pdi_scalar_outputs_collect(ctx, model, monitors, 0, &c->figures));
    for (int k = 0; k < model->setup->measured_count; k++) {
        pd_measured_set *d = &c->list[k];
        d->record = &model->setup->measured[k];
        c->error_line = d->record->line;
        PD_TRY(pdi_compare_measured_check_figure(ctx, c, d->record));
        PD_TRY(PD_NEW(ctx, "compare", d->record->points, d->computed));
        for (int p = 0; p < d->record->points; p++) d->computed[p] = (double)NAN;
    }
    return PD_OK;
}

PDI_FN void pdi_compare_measured_free(pd_ctx *ctx, pd_measured_comparison *c)
{
    for (int k = 0; k < PD_SETUP_MEASURED_MAX; k++) {
        pd_measured_set *d = &c->list[k];
        if (d->record) PD_DELETE(ctx, d->record->points, d->computed);
        PD_DELETE(ctx, d->time_capacity, d->time);
        PD_DELETE(ctx, d->value_capacity, d->value);
    }
    pd_scalar_outputs_free(ctx, &c->figures);
    memset(c, 0, sizeof *c);
}

PDI_FN pd_status pdi_compare_measured_build(pd_ctx *ctx, pd_model *model, const pd_monitors *monitors,
                                            const double *share, int curves, pd_measured_comparison *c)
{
    pd_status status = pdi_compare_measured_build_inner(ctx, model, monitors, share, curves, c);
    int line = c->error_line; /* of the scene: what is refused */
    if (status < 0) {
        pdi_compare_measured_free(ctx, c);
        c->error_line = line;
    }
    return status;
}

PDI_FN double pdi_compare_measured_find_next_time(const pd_measured_comparison *c, double time, double t_end)
{
    double next = t_end;
    int records = c->model ? c->model->setup->measured_count : 0;
    for (int k = 0; k < records; k++)
        for (int p = 0; p < c->list[k].record->points; p++) {
            double t = c->list[k].record->time[p];
            if (t > time * (1.0 + PDI_COMPARE_MEASURED_TIME_TOLERANCE) && t > 0.0 && t < next) next = t;
        }
    return next;
}

/* 1: |time of the point - time| <= 1e-9 time, and time [s] is positive. */
static int pdi_compare_measured_is_at_point(const pd_setup_measured *r, int point, double time)
{
    return time > 0.0 && fabs(r->time[point] - time) <= PDI_COMPARE_MEASURED_TIME_TOLERANCE * time;
}

PDI_FN int pdi_compare_measured_needs_output(const pd_measured_comparison *c, double time)
{
    int records = c->model ? c->model->setup->measured_count : 0;
    for (int k = 0; k < records; k++)
        for (int p = 0; p < c->list[k].record->points; p++)
            if (c->keeps_curves || pdi_compare_measured_is_at_point(c->list[k].record, p, time)) return 1;
    return 0;
}

/* Make room for `rows` values of time and output in a curve; capacities grow to about twice that. */
static pd_status pdi_compare_measured_grow_series(pd_ctx *ctx, pd_measured_set *d, int64_t rows)
{
    if (rows > d->time_capacity) {
        PD_TRY(PD_GROW(ctx, "compare", d->time_capacity, 2 * rows + 256, d->time));
        d->time_capacity = 2 * rows + 256;
    }
    if (rows > d->value_capacity) {
        PD_TRY(PD_GROW(ctx, "compare", d->value_capacity, 2 * rows + 256, d->value));
        d->value_capacity = 2 * rows + 256;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_compare_measured_step(pd_ctx *ctx, pd_measured_comparison *c)
{
    double time = c->model->time_loop.time;
    if (!c->model->setup->measured_count) return PD_OK;
    c->figures.count = 0;
    PD_TRY(pdi_scalar_outputs_collect(ctx, c->model, c->monitors, 0, &c->figures));
    for (int k = 0; k < c->model->setup->measured_count; k++) {
        pd_measured_set *d = &c->list[k];
        double value;
        pdi_compare_measured_get_output(c, d->record->output_name, &value, NULL);
        for (int p = 0; p < d->record->points; p++)
            if (pdi_compare_measured_is_at_point(d->record, p, time)) d->computed[p] = value;
        if (!c->keeps_curves) continue;
        PD_TRY(pdi_compare_measured_grow_series(ctx, d, d->rows + 1));
        d->time[d->rows] = time;
        d->value[d->rows++] = value;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_compare_measured_store(pd_ctx *ctx, pd_measured_comparison *c, pd_archive *archive)
{
    for (int k = 0; k < c->model->setup->measured_count; k++) {
        pd_measured_set *d = &c->list[k];
        PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "measured points", d->record->points));
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "computed at measured points", d->computed, d->record->points));
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "rows of a watched figure", &d->rows, 1));
        PD_TRY(pdi_compare_measured_grow_series(ctx, d, d->rows));
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "times of a watched figure", d->time, d->rows));
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "values of a watched figure", d->value, d->rows));
    }
    return PD_OK;
}

/* ---- what it says ---- */

PDI_FN void pdi_compare_measured_compute_error(const pd_measured_set *d, pd_measured_error *result)
{
    const pd_setup_measured *r = d->record;
    double square = 0.0;
    memset(result, 0, sizeof *result);
    for (int p = 0; p < r->points; p++) {
        double off = fabs(d->computed[p] - r->value[p]) / r->scale;
        if (isnan(d->computed[p])) continue;
        result->points++;
        square += off * off;
        if (r->spread) result->within_spread += off * r->scale <= r->spread[p];
        if (result->points > 1 && !(off > result->max_difference)) continue;
        result->max_difference = off;
        result->max_difference_time = r->time[p];
    }
    result->rms = result->points ? sqrt(square / result->points) : (double)NAN;
    if (!result->points) result->max_difference = result->max_difference_time = (double)NAN;
}

PDI_FN void pdi_compare_measured_print(const pd_measured_comparison *c, pd_print_fn print, void *user)
{
    char text[640], unit[PD_UNITS_TEXT];
    int records = c->model ? c->model->setup->measured_count : 0;
    for (int k = 0; print && k < records; k++) {
        const pd_setup_measured *r = c->list[k].record;
        pd_measured_error result;
        pdi_compare_measured_compute_error(&c->list[k], &result);
        memcpy(unit, r->unit[0] ? r->unit : "-", strlen(r->unit[0] ? r->unit : "-") + 1);
        for (char *u = unit; *u; u++)
            if (*u == ' ') *u = '*'; /* one word of the line */
        snprintf(text, sizeof text, "result case=%s measured=%s of=%.127s unit=%s", c->model->setup->name, r->name,
                 r->output_name, unit);
        char *figures = text + strlen(text);
        pd_append(text, sizeof text, " points=%d rms=%.4g largest=%.4g at=%.9g", result.points, result.rms,
                  result.max_difference, result.max_difference_time);
        if (r->spread) pd_append(text, sizeof text, " within_spread=%d", result.within_spread);
        pdi_result_line_remove_nonfinite(figures);
        print(user, PD_PRINT_RESULT, text);
    }
}

/* ---- files ---- */

/* Write the table of one set, a row a point: time [s]; measured, spread (NaN if not known), computed (NaN if not
 * reached) and computed - measured in the unit of the column. */
static pd_status pdi_compare_measured_write_table(pd_ctx *ctx, const pd_measured_set *d, pd_output_folder *folder)
{
    const pd_setup_measured *r = d->record;
    char names[5][PD_UNITS_TEXT + 32], file[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    static const char *const heads[] = {"time [s]", "measured", "spread", "computed", "difference"};
    const char *list[5], *unit = r->unit[0] ? r->unit : "-";
    double *rows = NULL;
    for (int k = 0; k < 5; k++) {
        snprintf(names[k], sizeof names[k], k ? "%s [%s]" : "%s", heads[k], unit);
        list[k] = names[k];
    }
    snprintf(file, sizeof file, "measured_%s.csv", r->name);
    PD_TRY(pdi_output_folder_add_file(ctx, folder, file, path));
    PD_TRY(PD_NEW(ctx, "compare", 5 * r->points, rows));
    for (int p = 0; p < r->points; p++) {
        double *row = rows + 5 * p;
        row[0] = r->time[p];
        row[1] = r->value[p] / r->scale;
        row[2] = r->spread ? r->spread[p] / r->scale : (double)NAN;
        row[3] = d->computed[p] / r->scale;
        row[4] = row[3] - row[1];
    }
    pd_status status = pdi_csv_write_table(ctx, path, list, 5, rows, r->points);
    PD_DELETE(ctx, 5 * r->points, rows);
    return status;
}

/* Plot the computed curve, which has a row at least, and the measured points into a file; time in s if the last is
 * below one hour, else in h. work[2 rows + 3 points]. */
static pd_status pdi_compare_measured_draw_curve(pd_ctx *ctx, const pd_measured_comparison *c, const pd_measured_set *d,
                                                 const char *path, double *work)
{
    const pd_setup_measured *r = d->record;
    char label[4 * PD_SETUP_NAME];
    double last = d->time[d->rows - 1], unit = last < 3600.0 ? 1.0 : 3600.0;
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    for (int64_t k = 0; k < d->rows; k++) {
        work[k] = d->time[k] / unit;
        work[d->rows + k] = d->value[k] / r->scale;
    }
    snprintf(label, sizeof label, "%.127s [%s]", r->output_name, r->unit[0] ? r->unit : "-");
    plot.title = c->model->setup->name;
    plot.x_label = unit > 1.0 ? "t [h]" : "t [s]";
    plot.y_label = label;
    plot.count = 2;
    plot.series[0].name = "computed";
    plot.series[0].x = work;
    plot.series[0].y = work + d->rows;
    plot.series[0].count = (int)d->rows;
    pdi_read_measured_build_series(r, unit, r->scale, last, work + 2 * d->rows, &plot.series[1]);
    return pd_plot_write(ctx, path, &plot);
}

/* Write the plot of one set; nothing for the volume loss, which is plotted elsewhere, or with fewer than two rows, as
 * in a run that keeps no curves. */
static pd_status pdi_compare_measured_write_plot(pd_ctx *ctx, const pd_measured_comparison *c, const pd_measured_set *d,
                                                 pd_output_folder *folder)
{
    char file[2 * PD_SETUP_NAME], path[PD_PATH_SIZE];
    double *work = NULL;
    int64_t size = 2 * d->rows + 3 * (int64_t)d->record->points;
    if (strcmp(d->record->output_name, "volume_loss") == 0 || d->rows < 2) return PD_OK;
    snprintf(file, sizeof file, "measured_%s.png", d->record->name);
    PD_TRY(pdi_output_folder_add_file(ctx, folder, file, path));
    PD_TRY(PD_NEW(ctx, "compare", size, work));
    pd_status status = pdi_compare_measured_draw_curve(ctx, c, d, path, work);
    PD_DELETE(ctx, size, work);
    return status;
}

PDI_FN pd_status pdi_compare_measured_write(pd_ctx *ctx, const pd_measured_comparison *c, pd_output_folder *folder)
{
    for (int k = 0; k < c->model->setup->measured_count; k++) {
        PD_TRY(pdi_compare_measured_write_table(ctx, &c->list[k], folder));
        PD_TRY(pdi_compare_measured_write_plot(ctx, c, &c->list[k], folder));
    }
    return PD_OK;
}

#undef PDI_COMPARE_MEASURED_TIME_TOLERANCE
