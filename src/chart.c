/* chart: see chart.h */
#include "chart.h"
#include "csv.h"
#include "refer.h"
#include <stdio.h>
#include <string.h>

typedef struct pdi_chart {
    pd_ctx *ctx;
    pd_text *text;
    int section; /* in work */
    const char *folder;
    pd_table table; /* the file of that section */
} pdi_chart;

/* An identifier that means nothing else in an expression. */
static pd_status pdi_chart_name(const pdi_chart *s, char *name)
{
    static const char *const others[] = {"x", "y", "z", "C", "Cs", "Csat", "rho_m", "M_m", "z_m"};
    const char *label = s->text->section[s->section].label;
    int taken = pdi_expr_taken(label);
    if (pdi_units_word(label) != strlen(label) || !label[0] || strlen(label) >= PD_SETUP_NAME)
        return pd_text_refuse(s->ctx, s->text, s->section, "table", "found the name '%.70s', expected a short word of"
                              " letters, digits and _: [table NAME]", label);
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++) taken |= strcmp(others[k], label) == 0;
    if (taken)
        return pd_text_refuse(s->ctx, s->text, s->section, "table",
                              "found the name '%s', expected one that expressions do not have", label);
    memcpy(name, label, strlen(label) + 1);
    return PD_OK;
}

/* Number of the column with this heading, or whose number this is. */
static pd_status pdi_chart_column(const pdi_chart *s, const char *key, const char *heading, int *column)
{
    double number;
    char list[240] = "";
    *column = pd_table_find(&s->table, heading);
    if (*column >= 0) return PD_OK;
    for (int k = 0; k < s->table.columns; k++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", pd_table_text(&s->table, -1, k));
        if (pdi_file_parse(heading, strlen(heading), &number) && number >= k + 1 && number <= k + 1) *column = k;
    }
    if (*column >= 0) return PD_OK;
    return pd_text_refuse(s->ctx, s->text, s->section, key, "found '%.60s', expected a column of %.200s: %s", heading,
                          s->table.path, list);
}

/* "heading in unit": values [rows] of that column, as they stand, and the size and dimension of their unit. */
static pd_status pdi_chart_values(const pdi_chart *s, const char *key, double *values, double *scale, pd_dims *dims)
{
    const char *given, *unit = "";
    char heading[PD_EXPR_LENGTH];
    int column;
    PDI_TRY(pd_text_string(s->ctx, s->text, s->section, key, NULL, &given));
    size_t size = strlen(given);
    if (size >= sizeof heading) return pd_text_refuse(s->ctx, s->text, s->section, key, "the heading is too long");
    memcpy(heading, given, size + 1);
    for (size_t k = 1; k + 4 < size; k++)
        if (memcmp(given + k, " in ", 4) == 0) {
            unit = given + k + 4;
            size = k;
        }
    while (size > 0 && pdi_units_blank(heading[size - 1])) size--;
    heading[size] = '\0';
    if (pd_units_parse(s->ctx, unit, scale, dims) < 0)
        return pd_text_refuse(s->ctx, s->text, s->section, key, "found '%.60s', expected a unit such as mol/L behind"
                              " 'in'", unit);
    PDI_TRY(pdi_chart_column(s, key, heading, &column));
    if (pd_table_column(s->ctx, &s->table, pd_table_text(&s->table, -1, column), values) < 0)
        return pdi_refer_fail(s->ctx, s->text, s->section, key);
    return PD_OK;
}

/* x [rows] and y [rows] become the curve. */
static pd_status pdi_chart_curve(const pdi_chart *s, double *x, double *y, pd_expr_table *function, pd_curve *curve)
{
    static const char *const outsides[] = {"hold", "error", NULL};
    double x_unit = 1.0, y_unit = 1.0;
    int strict;
    PDI_TRY(pd_text_choice(s->ctx, s->text, s->section, "outside", outsides, "hold", &strict));
    PDI_TRY(pdi_chart_values(s, "x", x, &x_unit, &function->argument));
    PDI_TRY(pdi_chart_values(s, "y", y, &y_unit, &function->result));
    for (int k = 0; k < s->table.rows; k++) {
        const char *wrong = pdi_curve_wrong(x, y, k);
        char before[PD_UNITS_TEXT] = "";
        if (wrong && k) snprintf(before, sizeof before, " behind x = %.6g, y = %.6g", x[k - 1], y[k - 1]);
        if (wrong)
            return pd_text_refuse(s->ctx, s->text, s->section, "file", "%.200s:%d: found x = %.6g, y = %.6g%s, %s",
                                  s->table.path, s->table.line[k], x[k], y[k], before, wrong);
    }
    for (int k = 0; k < s->table.rows; k++) {
        x[k] *= x_unit;
        y[k] *= y_unit;
    }
    if (pd_curve_build(s->ctx, x, y, s->table.rows, strict, curve) == PD_OK) return PD_OK;
    return pdi_refer_fail(s->ctx, s->text, s->section, "file");
}

static pd_status pdi_chart_section(pdi_chart *s, pd_setup_table *table, pd_expr_table *function)
{
    char path[PD_PATH_SIZE];
    double *x = NULL, *y = NULL;
    PDI_TRY(pdi_chart_name(s, table->name));
    PDI_TRY(pdi_refer_path(s->ctx, s->text, s->section, "file", s->folder, path));
    if (pd_table_read(s->ctx, path, &s->table) < 0) return pdi_refer_fail(s->ctx, s->text, s->section, "file");
    int rows = s->table.rows;
    function->name = table->name;
    function->curve = &table->curve;
    pd_status status = PDI_NEW(s->ctx, "chart", rows, x);
    if (status == PD_OK) status = PDI_NEW(s->ctx, "chart", rows, y);
    if (status == PD_OK) status = pdi_chart_curve(s, x, y, function, &table->curve);
    PDI_DELETE(s->ctx, rows, x);
    PDI_DELETE(s->ctx, rows, y);
    pd_table_free(s->ctx, &s->table);
    return status;
}

PDI_FN pd_status pdi_chart_read(pd_ctx *ctx, pd_text *text, const char *folder, pd_setup *setup)
{
    pdi_chart s;
    int count = 0, k = 0;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.text = text;
    s.folder = folder;
    for (int at = pd_text_next(ctx, text, "table", -1); at >= 0; at = pd_text_next(ctx, text, "table", at)) count++;
    if (!count) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "chart", count, setup->table));
    setup->tables = count;
    PDI_TRY(PDI_NEW(ctx, "chart", count, setup->function));
    for (s.section = pd_text_next(ctx, text, "table", -1); s.section >= 0;
         s.section = pd_text_next(ctx, text, "table", s.section), k++)
        PDI_TRY(pdi_chart_section(&s, &setup->table[k], &setup->function[k]));
    text->tables = setup->function;
    text->table_count = count;
    return PD_OK;
}
