/* table: rows of cells on the screen and in Markdown, text of reports, and curves of their figures. */
#ifndef CASES_TABLE_H
#define CASES_TABLE_H

enum { TABLE_CELLS = 24, TABLE_CELL = 48 };

/* One row of a table as text. */
typedef struct table_row {
    char cell[TABLE_CELLS][TABLE_CELL];
    int cells;
} table_row;

PD_PRINTF_LIKE(2, 3)
static void table_cell(table_row *row, const char *format, ...)
{
    va_list args;
    if (row->cells == TABLE_CELLS) return;
    va_start(args, format);
    vsnprintf(row->cell[row->cells++], TABLE_CELL, format, args);
    va_end(args);
}

/* Columns as wide as their widest cell. */
static void table_print(const table_row *row, int rows)
{
    int width[TABLE_CELLS];
    for (int c = 0; c < row[0].cells; c++) {
        width[c] = 0;
        for (int l = 0; l < rows; l++) {
            int size = (int)strlen(row[l].cell[c]);
            if (size > width[c]) width[c] = size;
        }
    }
    for (int l = 0; l < rows; l++) {
        for (int c = 0; c < row[l].cells; c++) printf("  %*s", width[c], row[l].cell[c]);
        printf("\n");
    }
}

PD_PRINTF_LIKE(3, 4)
static pd_status report_text(pd_ctx *ctx, pd_file *file, const char *format, ...)
{
    char text[4096];
    va_list args;
    va_start(args, format);
    int size = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (size < 0 || (size_t)size >= sizeof text)
        return pd_fail(ctx, PD_ERR_SIZE, "report", "a paragraph of the report has more than 4095 bytes");
    return pdi_file_write_text(ctx, file, text);
}

static pd_status report_row(pd_ctx *ctx, pd_file *file, const table_row *row)
{
    for (int c = 0; c < row->cells; c++) PD_TRY(report_text(ctx, file, "| %s ", row->cell[c]));
    return report_text(ctx, file, "|\n");
}

/* The first row is the head. */
static pd_status report_table(pd_ctx *ctx, pd_file *file, const table_row *row, int rows)
{
    PD_TRY(report_row(ctx, file, &row[0]));
    for (int c = 0; c < row[0].cells; c++) PD_TRY(report_text(ctx, file, "|---"));
    PD_TRY(report_text(ctx, file, "|\n"));
    for (int l = 1; l < rows; l++) PD_TRY(report_row(ctx, file, &row[l]));
    return report_text(ctx, file, "\n");
}

/* Add a curve to a plot that has room for it. */
static void plot_add(pd_plot *plot, const char *name, const double *x, const double *y, int count,
                     pd_series_style stroke)
{
    pd_series *s = &plot->series[plot->count++];
    s->name = name;
    s->x = x;
    s->y = y;
    s->count = count;
    s->stroke = stroke;
}

#endif
