/* read_tables: see read_tables.h */
#include "scene/read_tables.h"
#include "scene/key_value.h"
#include "scene/input_files.h"
#include "scene/read_constants.h"
#include <stdio.h>
#include <string.h>

/* Copy the label of the section into name[PD_SETUP_NAME] as the name of its function. PD_ERR_ARGUMENT: it is no
 * identifier, too long, reserved by expressions, or a constant of the scene. */
static pd_status pdi_read_tables_check_name(const pdi_read_tables_state *s, char *name)
{
    const char *label = s->text->section[s->section].label;
    int taken = pdi_read_constants_is_reserved(label);
    if (pd_units_scan_word(label) != strlen(label) || !label[0] || strlen(label) >= PD_SETUP_NAME)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "table",
                                 "found the name '%.70s', expected a short word of"
                                 " letters, digits and _: [table NAME]",
                                 label);
    for (int k = 0; k < s->text->const_count; k++) taken |= strcmp(s->text->consts[k].name, label) == 0;
    if (taken)
        return pdi_text_fail_key(s->ctx, s->text, s->section, "table",
                                 "found the name '%s', expected one that expressions do not have", label);
    memcpy(name, label, strlen(label) + 1);
    return PD_OK;
}

/* Find the column with this heading, or of this number from 1 on; *column counts from 0. PD_ERR_ARGUMENT: there is
 * none. */
static pd_status pdi_read_tables_find_column(const pdi_read_tables_state *s, const char *key, const char *heading,
                                             int *column)
{
    double number;
    char list[240] = "";
    *column = pd_table_find_column(&s->table, heading);
    if (*column >= 0) return PD_OK;
    for (int k = 0; k < s->table.columns; k++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", pd_table_get_text(&s->table, -1, k));
        if (pdi_file_parse_number(heading, strlen(heading), &number) && number >= k + 1 && number <= k + 1) *column = k;
    }
    if (*column >= 0) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, s->section, key, "found '%.60s', expected a column of %.200s: %s",
                             heading, s->table.path, list);
}

/* Unit in the last brackets of a heading, "loss [%]", into unit[PD_UNITS_TEXT]; "" for [-]; unchanged if there are no
 * brackets, they do not close, or the unit is too long. */
static void pdi_read_tables_get_bracket_unit(const char *heading, char *unit)
{
    const char *open = strrchr(heading, '[');
    size_t size = open ? strcspn(open + 1, "]") : 0;
    if (!open || open[1 + size] != ']' || size + 1 > PD_UNITS_TEXT) return;
    memcpy(unit, open + 1, size);
    unit[size] = '\0';
    if (strcmp(unit, "-") == 0) unit[0] = '\0'; /* as the tables of a run have it */
}

/* Split "heading in unit" at its last " in " into heading[PD_EXPR_LENGTH] and unit[PD_UNITS_TEXT]; unit "" where there
 * is none. PD_ERR_ARGUMENT: one of them is too long. */
static pd_status pdi_read_tables_split_heading(const pdi_read_tables_state *s, const char *key, const char *given,
                                               char *heading, char *unit)
{
    size_t size = strlen(given);
    const char *in = NULL;
    unit[0] = '\0';
    if (size >= PD_EXPR_LENGTH) return pdi_text_fail_key(s->ctx, s->text, s->section, key, "the heading is too long");
    memcpy(heading, given, size + 1);
    for (size_t k = 1; k + 4 < size; k++)
        if (memcmp(given + k, " in ", 4) == 0) {
            in = given + k + 4;
            size = k;
        }
    if (in && strlen(in) >= PD_UNITS_TEXT)
        return pdi_text_fail_key(s->ctx, s->text, s->section, key,
                                 "found '%.60s', expected a unit such as mol/L behind"
                                 " 'in'",
                                 in);
    if (in) memcpy(unit, in, strlen(in) + 1);
    while (size > 0 && pd_units_is_blank(heading[size - 1])) size--;
    heading[size] = '\0';
    return PD_OK;
}

PDI_FN pd_status pdi_read_tables_column(const pdi_read_tables_state *s, const char *key, const char *fallback,
                                        int bracket, double *values, char *unit, double *scale, pd_dims *dims)
{
    const char *given, *name;
    char heading[PD_EXPR_LENGTH];
    int column;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, s->section, key, fallback, &given));
    PD_TRY(pdi_read_tables_split_heading(s, key, given, heading, unit));
    PD_TRY(pdi_read_tables_find_column(s, key, heading, &column));
    name = pd_table_get_text(&s->table, -1, column);
    if (bracket && !unit[0]) pdi_read_tables_get_bracket_unit(name, unit);
    if (pd_units_parse(s->ctx, unit, scale, dims) < 0)
        return pdi_text_fail_key(s->ctx, s->text, s->section, key,
                                 "found '%.60s', expected a unit such as mol/L behind"
                                 " 'in'",
                                 unit);
    if (pd_table_parse_column(s->ctx, &s->table, name, values) < 0)
        return pdi_input_files_fail(s->ctx, s->text, s->section, key);
    return PD_OK;
}

/* Build the monotone interpolant from the columns x and y of the section, in SI, and set the dimensions of the
 * function. x[rows], y[rows]: work arrays. PD_ERR_ARGUMENT: x does not rise, with the line of the file. */
static pd_status pdi_read_tables_build_curve(const pdi_read_tables_state *s, double *x, double *y,
                                             pd_expr_table *function, pd_monotone_cubic *curve)
{
    char unit[PD_UNITS_TEXT];
    double x_unit = 1.0, y_unit = 1.0;
    int strict;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, s->section, "outside", &strict));
    PD_TRY(pdi_read_tables_column(s, "x", NULL, 0, x, unit, &x_unit, &function->argument));
    PD_TRY(pdi_read_tables_column(s, "y", NULL, 0, y, unit, &y_unit, &function->result));
    for (int k = 0; k < s->table.rows; k++) {
        const char *wrong = pd_monotone_cubic_check_point(x, y, k);
        char before[PD_UNITS_TEXT] = "";
        if (wrong && k) snprintf(before, sizeof before, " behind x = %.6g, y = %.6g", x[k - 1], y[k - 1]);
        if (wrong)
            return pdi_text_fail_key(s->ctx, s->text, s->section, "file", "%.200s:%d: found x = %.6g, y = %.6g%s, %s",
                                     s->table.path, s->table.row_line[k], x[k], y[k], before, wrong);
    }
    for (int k = 0; k < s->table.rows; k++) {
        x[k] *= x_unit;
        y[k] *= y_unit;
    }
    if (pd_monotone_cubic_build(s->ctx, x, y, s->table.rows, strict, curve) == PD_OK) return PD_OK;
    return pdi_input_files_fail(s->ctx, s->text, s->section, "file");
}

/* Read one [table NAME] section: its CSV file into table->curve, and its function, which refers to it. The file is not
 * kept. PD_ERR_ARGUMENT: a name, file or column that is refused. */
static pd_status pdi_read_tables_section(pdi_read_tables_state *s, pd_setup_table *table, pd_expr_table *function)
{
    char path[PD_PATH_SIZE];
    double *x = NULL, *y = NULL;
    PD_TRY(pdi_read_tables_check_name(s, table->name));
    PD_TRY(pdi_input_files_get_path(s->ctx, s->text, s->section, "file", s->folder, path));
    if (pd_table_read(s->ctx, path, &s->table) < 0) return pdi_input_files_fail(s->ctx, s->text, s->section, "file");
    int rows = s->table.rows;
    function->name = table->name;
    function->curve = &table->curve;
    pd_status status = PD_NEW(s->ctx, "table", rows, x);
    if (status == PD_OK) status = PD_NEW(s->ctx, "table", rows, y);
    if (status == PD_OK) status = pdi_read_tables_build_curve(s, x, y, function, &table->curve);
    PD_DELETE(s->ctx, rows, x);
    PD_DELETE(s->ctx, rows, y);
    pd_table_free(s->ctx, &s->table);
    return status;
}

PDI_FN pd_status pdi_read_tables_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup)
{
    pdi_read_tables_state s;
    int count = 0, k = 0;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.text = text;
    s.folder = folder;
    for (int at = pdi_text_next_section(ctx, text, "table", -1); at >= 0;
         at = pdi_text_next_section(ctx, text, "table", at))
        count++;
    if (!count) return PD_OK;
    PD_TRY(PD_NEW(ctx, "table", count, setup->table));
    setup->tables = count;
    PD_TRY(PD_NEW(ctx, "table", count, setup->function));
    for (s.section = pdi_text_next_section(ctx, text, "table", -1); s.section >= 0;
         s.section = pdi_text_next_section(ctx, text, "table", s.section), k++)
        PD_TRY(pdi_read_tables_section(&s, &setup->table[k], &setup->function[k]));
    text->tables = setup->function;
    text->table_count = count;
    return PD_OK;
}
