/* csv: see csv.h */
#include "io/csv.h"
#include <string.h>

/* Writing. */

/* Check the number of columns and names[columns]. PD_ERR_ARGUMENT: not 1 to PD_CSV_MAX_COLUMNS columns; a name is NULL,
 * empty, there twice, or has a control character (below 32). */
static pd_status pdi_csv_check_names(pd_ctx *ctx, const char *path, const char *const *names, int columns)
{
    if (columns < 1 || columns > PD_CSV_MAX_COLUMNS)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "csv", "%s: %d columns, expected 1 to %d", path, columns,
                       PD_CSV_MAX_COLUMNS);
    for (int k = 0; k < columns; k++) {
        if (!names[k] || !names[k][0])
            return pd_fail(ctx, PD_ERR_ARGUMENT, "csv", "%s: column %d has no name", path, k);
        for (const char *c = names[k]; *c; c++)
            if ((unsigned char)*c < 32)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "csv", "%s: the name of column %d holds a control character",
                               path, k);
        for (int j = 0; j < k; j++)
            if (strcmp(names[j], names[k]) == 0)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "csv", "%s: two columns are named '%s'", path, names[k]);
    }
    return PD_OK;
}

/* Write a column name; in quotes, its own quotes doubled, when it holds a comma or a quote, begins with '#', or begins
 * or ends with a space. */
static pd_status pdi_csv_write_name(pd_ctx *ctx, pd_file *file, const char *name)
{
    if (!strpbrk(name, ",\"") && name[0] != '#' && name[0] != ' ' && name[strlen(name) - 1] != ' ')
        return pdi_file_write_text(ctx, file, name);
    PD_TRY(pdi_file_write_text(ctx, file, "\""));
    for (; *name; name++) PD_TRY(pdi_file_write(ctx, file, *name == '"' ? "\"\"" : name, *name == '"' ? 2 : 1));
    return pdi_file_write_text(ctx, file, "\"");
}

/* Write the header line. */
static pd_status pdi_csv_write_header(pd_ctx *ctx, pd_file *file, const char *const *names, int columns)
{
    for (int k = 0; k < columns; k++) {
        if (k) PD_TRY(pdi_file_write_text(ctx, file, ","));
        PD_TRY(pdi_csv_write_name(ctx, file, names[k]));
    }
    return pdi_file_write_text(ctx, file, "\n");
}

/* Write values[columns] as one row. */
static pd_status pdi_csv_write_values(pd_ctx *ctx, pd_file *file, const double *values, int columns)
{
    char row[PD_CSV_MAX_COLUMNS * PDI_FILE_NUMBER_SIZE];
    size_t used = 0;
    for (int k = 0; k < columns; k++) {
        if (k) row[used++] = ',';
        pdi_file_format_number(values[k], row + used);
        used += strlen(row + used);
    }
    row[used++] = '\n';
    return pdi_file_write(ctx, file, row, used);
}

PDI_FN pd_status pdi_csv_write_table(pd_ctx *ctx, const char *path, const char *const *names, int columns,
                                     const double *values, int64_t rows)
{
    pd_file file;
    PD_TRY(pdi_csv_check_names(ctx, path, names, columns));
    PD_TRY(pdi_file_create(ctx, path, &file));
    pd_status status = pdi_csv_write_header(ctx, &file, names, columns);
    for (int64_t k = 0; k < rows && status == PD_OK; k++)
        status = pdi_csv_write_values(ctx, &file, values + k * columns, columns);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

pd_status pd_csv_create(pd_ctx *ctx, const char *path, const char *const *names, int columns, pd_csv *csv)
{
    memset(csv, 0, sizeof *csv);
    PD_TRY(pdi_csv_write_table(ctx, path, names, columns, NULL, 0));
    PD_TRY(pdi_file_open_append(ctx, path, &csv->file));
    csv->columns = columns;
    return PD_OK;
}

PDI_FN pd_status pdi_csv_store(pd_ctx *ctx, pd_archive *archive, const char *path, int columns, pd_csv *csv)
{
    int64_t length = 0;
    if (!archive->is_reading) PD_TRY(pdi_file_get_length(ctx, &csv->file, &length));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "length of a table", &length, 1));
    if (!archive->is_reading) return PD_OK;
    memset(csv, 0, sizeof *csv);
    PD_TRY(pdi_file_resume(ctx, path, length, &csv->file));
    csv->columns = columns;
    return PD_OK;
}

pd_status pd_csv_write_row(pd_ctx *ctx, pd_csv *csv, const double *values)
{
    PD_TRY(pdi_csv_write_values(ctx, &csv->file, values, csv->columns));
    return pdi_file_flush(ctx, &csv->file);
}

pd_status pd_csv_close(pd_ctx *ctx, pd_csv *csv) { return csv->file.stream ? pdi_file_commit(ctx, &csv->file) : PD_OK; }

/* Reading. */

/* State of parsing a table. */
typedef struct pdi_csv_reader {
    pd_table *table;
    size_t position; /* position in table->text */
    int line;      /* number of the line, from 1 */
    size_t field_count; /* number of fields so far */
} pdi_csv_reader;

/* Report an error at the current line as PD_ERR_PARSE. */
static pd_status pdi_csv_fail_at_line(pd_ctx *ctx, const pdi_csv_reader *r, const char *text)
{
    return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s:%d: %s", r->table->path, r->line, text);
}

/* Append the offset of a field to the table, whose capacity grows, and count the field. */
static pd_status pdi_csv_add_field(pd_ctx *ctx, pdi_csv_reader *r, size_t offset)
{
    pd_table *t = r->table;
    if (r->field_count == t->capacity) {
        size_t capacity = 2 * t->capacity + 64;
        PD_TRY(PD_GROW(ctx, "csv", t->capacity, capacity, t->field_offset));
        t->capacity = capacity;
    }
    t->field_offset[r->field_count++] = offset;
    return PD_OK;
}

/* Read a quoted field at the current position and remove its quotes in place; the position moves to the separator
 * behind it. *stop: where its terminating 0 belongs. That may be the separator itself, so the caller sets it after
 * looking at it. PD_ERR_PARSE: the quote is not closed on its line, or is followed by text. */
static pd_status pdi_csv_read_quoted_field(pd_ctx *ctx, pdi_csv_reader *r, size_t *stop)
{
    char *text = r->table->text;
    size_t out = ++r->position;
    PD_TRY(pdi_csv_add_field(ctx, r, out));
    for (;; r->position++) {
        char c = text[r->position];
        if (!c || c == '\n') return pdi_csv_fail_at_line(ctx, r, "a quote is not closed on its line");
        if (c == '"') {
            if (text[r->position + 1] != '"') break;
            r->position++;
        }
        text[out++] = c;
    }
    r->position++;
    while (text[r->position] == ' ' || text[r->position] == '\t' || text[r->position] == '\r') r->position++;
    char end = text[r->position];
    if (end && end != ',' && end != '\n') return pdi_csv_fail_at_line(ctx, r, "text behind a closing quote");
    *stop = out;
    return PD_OK;
}

/* Read an unquoted field; the position moves to the separator behind it. *stop: where its terminating 0 belongs, before
 * the white space at its end. */
static pd_status pdi_csv_read_plain_field(pd_ctx *ctx, pdi_csv_reader *r, size_t *stop)
{
    char *text = r->table->text;
    size_t start = r->position;
    PD_TRY(pdi_csv_add_field(ctx, r, start));
    r->position += strcspn(text + r->position, ",\n");
    *stop = r->position;
    while (*stop > start && strchr(" \t\r", text[*stop - 1])) --*stop;
    return PD_OK;
}

/* Read all fields of a line, each terminated by 0 in place, unquoted ones without white space around them; the position
 * moves to the next line. *fields: their number. PD_ERR_PARSE: more than 256 fields, a quote that is open or has text
 * behind it. */
static pd_status pdi_csv_read_line(pd_ctx *ctx, pdi_csv_reader *r, int *fields)
{
    char *text = r->table->text;
    for (*fields = 0;;) {
        size_t stop = 0;
        while (text[r->position] == ' ' || text[r->position] == '\t') r->position++;
        if (++*fields > PD_CSV_MAX_COLUMNS) return pdi_csv_fail_at_line(ctx, r, "more than 256 fields");
        if (text[r->position] == '"') PD_TRY(pdi_csv_read_quoted_field(ctx, r, &stop));
        else PD_TRY(pdi_csv_read_plain_field(ctx, r, &stop));
        char end = text[r->position];
        text[stop] = 0;
        if (end) r->position++;
        if (end != ',') return PD_OK;
    }
}

/* Take the fields read so far, `fields` of them, as the column names. PD_ERR_PARSE: one is empty or occurs twice. */
static pd_status pdi_csv_set_column_names(pd_ctx *ctx, pdi_csv_reader *r, int fields)
{
    pd_table *t = r->table;
    t->columns = fields;
    for (int k = 0; k < fields; k++) {
        const char *name = pd_table_get_text(t, -1, k);
        if (!name[0]) return pdi_csv_fail_at_line(ctx, r, "a column has no name");
        if (pd_table_find_column(t, name) != k)
            return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s:%d: two columns are named '%s'", t->path, r->line, name);
    }
    return PD_OK;
}

/* Append a row, whose `fields` fields have been read, to the table. PD_ERR_PARSE: their number is not that of the
 * columns. */
static pd_status pdi_csv_add_row(pd_ctx *ctx, pdi_csv_reader *r, int fields)
{
    pd_table *t = r->table;
    if (fields != t->columns)
        return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s:%d: %d fields, expected %d as in the line of names", t->path,
                       r->line, fields, t->columns);
    if ((size_t)t->rows == t->line_capacity) {
        size_t capacity = 2 * t->line_capacity + 64;
        PD_TRY(PD_GROW(ctx, "csv", t->line_capacity, capacity, t->row_line));
        t->line_capacity = capacity;
    }
    t->row_line[t->rows++] = r->line;
    return PD_OK;
}

/* Parse table->text in place: a byte order mark is skipped, the first line gives the names, others are rows. Lines that
 * are blank, or begin with '#' behind white space, are skipped. PD_ERR_PARSE: a byte 0, no header line, or a fault in a
 * line. */
static pd_status pdi_csv_parse(pd_ctx *ctx, pd_table *table)
{
    pdi_csv_reader r = {table, 0, 0, 0};
    char *text = table->text;
    if (strlen(text) + 1 != table->text_size)
        return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s: byte %lu is 0: not a text file", table->path,
                       (unsigned long)strlen(text));
    if (strncmp(text, "\xEF\xBB\xBF", 3) == 0) r.position = 3; /* the mark some editors put before UTF-8 */
    while (text[r.position]) {
        r.line++;
        size_t blank = strspn(text + r.position, " \t\r");
        if (text[r.position + blank] == '#' || text[r.position + blank] == '\n' || !text[r.position + blank]) {
            r.position += strcspn(text + r.position, "\n");
            r.position += text[r.position] == '\n';
            continue;
        }
        int fields;
        PD_TRY(pdi_csv_read_line(ctx, &r, &fields));
        if (table->columns == 0) PD_TRY(pdi_csv_set_column_names(ctx, &r, fields));
        else PD_TRY(pdi_csv_add_row(ctx, &r, fields));
    }
    if (table->columns == 0) return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s: no line of column names", table->path);
    return PD_OK;
}

pd_status pd_table_read(pd_ctx *ctx, const char *path, pd_table *table)
{
    size_t size = 0;
    memset(table, 0, sizeof *table);
    PD_TRY(pdi_file_read_all(ctx, path, PD_CSV_MAX_FILE_SIZE, &table->text, &size));
    table->text_size = size + 1;
    strcpy(table->path, path);
    pd_status status = pdi_csv_parse(ctx, table);
    if (status != PD_OK) pd_table_free(ctx, table);
    return status;
}

void pd_table_free(pd_ctx *ctx, pd_table *table)
{
    PD_DELETE(ctx, table->text_size, table->text);
    PD_DELETE(ctx, table->capacity, table->field_offset);
    PD_DELETE(ctx, table->line_capacity, table->row_line);
    memset(table, 0, sizeof *table);
}

const char *pd_table_get_text(const pd_table *table, int row, int column)
{
    return table->text + table->field_offset[(size_t)(row + 1) * (size_t)table->columns + (size_t)column];
}

int pd_table_find_column(const pd_table *table, const char *name)
{
    int found = -1;
    size_t length = strlen(name);
    for (int k = 0; k < table->columns; k++) {
        const char *own = pd_table_get_text(table, -1, k);
        if (strcmp(own, name) == 0) return k;
        if (strncmp(own, name, length) == 0 && strncmp(own + length, " [", 2) == 0) found = found == -1 ? k : -2;
    }
    return found < 0 ? -1 : found;
}

pd_status pd_table_parse_column(pd_ctx *ctx, const pd_table *table, const char *name, double *values)
{
    int column = pd_table_find_column(table, name);
    if (column < 0)
        return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s: no column is named '%s'; the first of %d is '%s'", table->path,
                       name, table->columns, table->columns ? pd_table_get_text(table, -1, 0) : "");
    for (int r = 0; r < table->rows; r++) {
        const char *text = pd_table_get_text(table, r, column);
        if (!pdi_file_parse_number(text, strlen(text), &values[r]))
            return pd_fail(ctx, PD_ERR_PARSE, "csv", "%s:%d: column '%s': '%.40s' is not a number", table->path,
                           table->row_line[r], name, text);
    }
    return PD_OK;
}
