/* read_measured: see read_measured.h */
#include "scene/read_measured.h"
#include "scene/key_value.h"
#include "scene/input_files.h"
#include "scene/read_tables.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_READ_MEASURED_TIME_TOL 1e-9 /* [-] relative difference of times that are one */

/* Heading of the first column that begins with "spread", the default column of error bars; NULL: there is none. */
static const char *pdi_read_measured_find_spread(const pdi_read_tables_state *s)
{
    for (int k = 0; k < s->table.columns; k++)
        if (strncmp(pd_table_get_text(&s->table, -1, k), "spread", 6) == 0) return pd_table_get_text(&s->table, -1, k);
    return NULL;
}

/* Check that a column has the wanted dimension. PD_ERR_ARGUMENT. */
static pd_status pdi_read_measured_check_dims(const pdi_read_tables_state *s, const char *key, const pd_dims *found,
                                              const pd_dims *wanted)
{
    char is[PD_UNITS_TEXT], expected[PD_UNITS_TEXT];
    if (pd_units_is_same(found, wanted)) return PD_OK;
    pd_units_describe(found, is);
    pd_units_describe(wanted, expected);
    return pdi_text_fail_key(s->ctx, s->text, s->section, key,
                             "found %s, expected %s: write the unit behind 'in', such "
                             "as 'time_h in h'",
                             is, expected);
}

/* Report an inadmissible value in a row of the data file, with the line of that file. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_read_measured_fail_row(const pdi_read_tables_state *s, int row, const char *key, double found,
                                            const char *expected)
{
    return pdi_text_fail_key(s->ctx, s->text, s->section, key, "%.200s:%d: found %.6g, expected %s", s->table.path,
                             s->table.row_line[row], found, expected);
}

/* Read the column of times (the first by default) as time[rows] since the start of the run [s]: time of the file less
 * the key `start`. PD_ERR_ARGUMENT: no time, a value that is not finite, or one below that of the row before; equal
 * ones are admitted. */
static pd_status pdi_read_measured_times(const pdi_read_tables_state *s, double *time)
{
    char unit[PD_UNITS_TEXT];
    double scale, start;
    pd_dims dims, wanted;
    PD_TRY(pdi_read_tables_column(s, "time", "1", 1, time, unit, &scale, &dims));
    pd_units_parse(s->ctx, "s", NULL, &wanted);
    PD_TRY(pdi_read_measured_check_dims(s, "time", &dims, &wanted));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->section, "start", &start));
    for (int k = 0; k < s->table.rows; k++) {
        if (!(fabs(time[k]) < HUGE_VAL)) return pdi_read_measured_fail_row(s, k, "time", time[k], "a finite time");
        if (k && time[k] < time[k - 1])
            return pdi_read_measured_fail_row(s, k, "time", time[k],
                                              "a time that is not before that of the line above");
    }
    for (int k = 0; k < s->table.rows; k++) time[k] = scale * time[k] - start;
    return PD_OK;
}

/* Read the columns of values (the second by default) and, if the key or a heading that begins with "spread" gives one,
 * of error bars into r->value and the new array r->spread, both in SI. PD_ERR_ARGUMENT: a value that is not finite, a
 * spread that is negative or not finite, or a spread of another dimension. */
static pd_status pdi_read_measured_values(const pdi_read_tables_state *s, pd_setup_measured *r)
{
    char unit[PD_UNITS_TEXT];
    const char *spread = pdi_read_measured_find_spread(s);
    double scale;
    pd_dims dims;
    PD_TRY(pdi_read_tables_column(s, "value", "2", 1, r->value, r->unit, &r->scale, &r->dims));
    for (int k = 0; k < r->points; k++) {
        if (!(fabs(r->value[k]) < HUGE_VAL))
            return pdi_read_measured_fail_row(s, k, "value", r->value[k], "a finite value");
        r->value[k] *= r->scale;
    }
    if (!spread && !pdi_text_has_key(s->ctx, s->text, s->section, "standard_deviation")) return PD_OK;
    PD_TRY(PD_NEW(s->ctx, "record", r->points, r->spread));
    PD_TRY(pdi_read_tables_column(s, "standard_deviation", spread, 1, r->spread, unit, &scale, &dims));
    PD_TRY(pdi_read_measured_check_dims(s, "standard_deviation", &dims, &r->dims));
    for (int k = 0; k < r->points; k++) {
        if (!(r->spread[k] >= 0.0) || !(r->spread[k] < HUGE_VAL))
            return pdi_read_measured_fail_row(s, k, "standard_deviation", r->spread[k], "a finite one of at least 0");
        r->spread[k] *= scale;
    }
    return PD_OK;
}

/* Read the name of the scalar output that the data are compared with: "volume_loss", the default, or
 * "section.name.figure". PD_ERR_ARGUMENT: another word with fewer than two dots, or one that is too long. Whether the
 * output exists is not checked here. */
static pd_status pdi_read_measured_output_name(const pdi_read_tables_state *s, pd_setup_measured *r)
{
    const char *of;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, s->section, "of", "volume_loss", &of));
    const char *first = strchr(of, '.'), *last = strrchr(of, '.');
    if (strlen(of) >= sizeof r->output_name || (strcmp(of, "volume_loss") != 0 && first == last))
        return pdi_text_fail_key(s->ctx, s->text, s->section, "of",
                                 "found '%.80s', expected volume_loss or a figure of"
                                 " another section such as plane.NAME.flow or probe.NAME.C",
                                 of);
    memcpy(r->output_name, of, strlen(of) + 1);
    return PD_OK;
}

PDI_FN int pdi_read_measured_is_in_run(const pd_setup_measured *r, int point, double until)
{
    return r->time[point] > 0.0 && r->time[point] <= until * (1.0 + PDI_READ_MEASURED_TIME_TOL);
}

/* Check that at least one data point lies in the run. PD_ERR_ARGUMENT. */
static pd_status pdi_read_measured_check_times(const pdi_read_tables_state *s, const pd_setup *u,
                                               const pd_setup_measured *r)
{
    char until[PD_UNITS_TEXT];
    for (int k = 0; k < r->points; k++)
        if (pdi_read_measured_is_in_run(r, k, u->end_time)) return PD_OK;
    pd_setup_format_value(u->end_time, "s", until);
    return pdi_text_fail_key(s->ctx, s->text, s->section, "file",
                             "%.200s: found no point behind the start of the run and"
                             " before its end at t = %s; 'start' is the time of the file at which the run begins",
                             s->table.path, until);
}

/* Read one [measured NAME] section with its data file and append it to the setup, also on failure. The table of the
 * file stays in s->table for the caller to free. PD_ERR_ARGUMENT: too many sections, no name or a long one, fewer than
 * 2 columns, or no row. */
static pd_status pdi_read_measured_section(pdi_read_tables_state *s, pd_setup *u)
{
    const char *label = s->text->section[s->section].label;
    char path[PD_PATH_SIZE];
    if (u->measured_count >= PD_SETUP_MEASURED_MAX)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "measured", "found more than %d sections of this sort",
                                 PD_SETUP_MEASURED_MAX);
    if (label[0] == '\0' || strlen(label) >= PD_SETUP_NAME - 24)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "measured", "expected a short name: [measured NAME]");
    pd_setup_measured *r = &u->measured[u->measured_count++];
    memcpy(r->name, label, strlen(label) + 1);
    r->line = s->text->section[s->section].line;
    PD_TRY(pdi_input_files_get_path(s->ctx, s->text, s->section, "file", s->folder, path));
    if (pd_table_read(s->ctx, path, &s->table) < 0) return pdi_input_files_fail(s->ctx, s->text, s->section, "file");
    if (s->table.columns < 2 || s->table.rows < 1)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "file",
                                 "%.200s: found %d columns and %d rows, expected a"
                                 " time and a value in each row",
                                 path, s->table.columns, s->table.rows);
    r->points = s->table.rows;
    PD_TRY(PD_NEW(s->ctx, "record", r->points, r->time));
    PD_TRY(PD_NEW(s->ctx, "record", r->points, r->value));
    PD_TRY(pdi_read_measured_times(s, r->time));
    PD_TRY(pdi_read_measured_values(s, r));
    PD_TRY(pdi_read_measured_output_name(s, r));
    return pdi_read_measured_check_times(s, u, r);
}

PDI_FN pd_status pdi_read_measured_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup)
{
    pdi_read_tables_state s;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.text = text;
    s.folder = folder;
    for (s.section = pdi_text_next_section(ctx, text, "measured", -1); s.section >= 0;
         s.section = pdi_text_next_section(ctx, text, "measured", s.section)) {
        pd_status status = pdi_read_measured_section(&s, setup);
        pd_table_free(ctx, &s.table);
        PD_TRY(status);
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_measured_replace(pd_ctx *ctx, const char *where, const char *text, pd_setup *setup)
{
    char line[PD_EXPR_LENGTH];
    pd_text scene;
    if (strlen(text) + 32 > sizeof line || strchr(text, '\n'))
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "found more than a line of %d bytes", PD_EXPR_LENGTH - 32);
    snprintf(line, sizeof line, "[measured data] file = %.4000s\n", text);
    pd_setup_free_measured(ctx, setup);
    PD_TRY(pdi_text_build(ctx, where, line, strlen(line), &scene));
    pd_status status = pdi_read_measured_read(ctx, &scene, "", setup);
    if (status == PD_OK) status = pdi_text_check_unused(ctx, &scene);
    pdi_text_free(ctx, &scene);
    for (int k = 0; k < setup->measured_count; k++) setup->measured[k].line = 0;
    return status;
}

PDI_FN void pdi_read_measured_build_series(const pd_setup_measured *r, double x_unit, double y_unit, double last,
                                           double *work, pd_series *series)
{
    double *y = work + r->points, *spread = y + r->points;
    memset(series, 0, sizeof *series);
    for (int k = 0; k < r->points; k++) {
        if (r->time[k] < 0.0 || r->time[k] > last * (1.0 + PDI_READ_MEASURED_TIME_TOL)) continue;
        work[series->count] = r->time[k] / x_unit;
        y[series->count] = r->value[k] / y_unit;
        spread[series->count++] = r->spread ? r->spread[k] / y_unit : 0.0;
    }
    series->name = r->name;
    series->x = work;
    series->y = y;
    series->error_bar = spread;
    series->stroke = PD_SERIES_STYLE_MARKERS;
}

#undef PDI_READ_MEASURED_TIME_TOL
