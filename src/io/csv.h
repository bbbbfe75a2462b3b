/* csv: tables of numbers as CSV text: a writer that flushes every row, and a reader.
 *
 * The first line names the columns ("time [s]"), every other line is a row. The reader ignores lines that begin with
 * '#'. Fields are separated by commas and may stand in double quotes ("" inside for one quote). Numbers are written as
 * the shortest text that reads back as the same bits.
 */
#ifndef PD_CSV_H
#define PD_CSV_H
#include "core/archive.h"
#include "io/file.h"

#define PD_CSV_MAX_COLUMNS 256         /* maximum number of columns */
#define PD_CSV_MAX_FILE_SIZE 536870912 /* [byte] largest table that is read */

/* A CSV file that rows are appended to. Zero-initialise. */
typedef struct pd_csv {
    pd_file file;
    int columns;
} pd_csv;

/* A table that was read; all of it owned here. Zero-initialise. */
typedef struct pd_table {
    char path[PD_PATH_SIZE];
    int columns, rows;
    char *text;      /* [text_size] content of the file, each field terminated by 0 */
    size_t text_size;
    size_t *field_offset; /* [capacity] offset of each field in text; the names come first */
    size_t capacity;
    int *row_line; /* [line_capacity] line of the file of each row, counted from 1 */
    size_t line_capacity;
} pd_table;

#define pd_csv_create PD_NAME(pd_csv_create)
#define pd_csv_write_row PD_NAME(pd_csv_write_row)
#define pd_csv_close PD_NAME(pd_csv_close)
#define pd_table_read PD_NAME(pd_table_read)
#define pd_table_find_column PD_NAME(pd_table_find_column)
#define pd_table_get_text PD_NAME(pd_table_get_text)
#define pd_table_parse_column PD_NAME(pd_table_parse_column)
#define pd_table_free PD_NAME(pd_table_free)

/* Create a CSV file with its header line, names[columns] such as "time [s]", and open it to append rows. An older file
 * is replaced. PD_ERR_ARGUMENT: columns outside 1..PD_CSV_MAX_COLUMNS; names that are NULL, empty, occur twice or hold
 * a control character. PD_ERR_FILE. On failure csv is not open. */
PD_API pd_status pd_csv_create(pd_ctx *ctx, const char *path, const char *const *names, int columns, pd_csv *csv);
/* Append a row values[columns] and flush it; NaN is written as nan, infinity as inf. PD_ERR_ARGUMENT: the file is not
 * open; PD_ERR_FILE. */
PD_API pd_status pd_csv_write_row(pd_ctx *ctx, pd_csv *csv, const double *values);
/* Close the file. One that is not open is allowed. PD_ERR_FILE. */
PD_API pd_status pd_csv_close(pd_ctx *ctx, pd_csv *csv);
/* Read a CSV file into a table, which is zeroed on failure. PD_ERR_FILE: unreadable, or larger than
 * PD_CSV_MAX_FILE_SIZE. PD_ERR_PARSE with file:line: no header line, a byte 0, a column name empty or there twice, more
 * than PD_CSV_MAX_COLUMNS fields, a row with more or fewer fields than the header, a quote that is open or has text
 * behind it. */
PD_API pd_status pd_table_read(pd_ctx *ctx, const char *path, pd_table *table);
/* Index of a column by name, case-sensitive: of the one that equals it, else of the only one that is the name followed
 * by " ["; -1: none, or several such. */
PD_API int pd_table_find_column(const pd_table *table, const char *name);
/* Text of a field, owned by the table; row -1 is the header line. Row and column are not checked. */
PD_API const char *pd_table_get_text(const pd_table *table, int row, int column);
/* Parse the column of this name (as of pd_table_find_column) into values[rows]; nan and inf are numbers. PD_ERR_PARSE
 * with file:line: no such column, or a field that is no number; the values before it are set then. */
PD_API pd_status pd_table_parse_column(pd_ctx *ctx, const pd_table *table, const char *name, double *values);
/* Free the table. A zeroed one is allowed. */
PD_API void pd_table_free(pd_ctx *ctx, pd_table *table);

#ifdef PDI_APP_INTERNAL

/* Write a whole table values[rows][columns] through a temporary file; values may be NULL where rows is 0. Errors as of
 * pd_csv_create; PD_ERR_FILE: an older file stays, and the temporary one is deleted. */
PDI_FN pd_status pdi_csv_write_table(pd_ctx *ctx, const char *path, const char *const *names, int columns,
                                     const double *values, int64_t rows);

/* Checkpoint of an open CSV file: flush it and write its length [byte]. Or, when reading, overwrite *csv: truncate the
 * file `path` to that length and open it to append; path and columns are used only there. PD_ERR_FILE: it is shorter,
 * or no row ends there. */
PDI_FN pd_status pdi_csv_store(pd_ctx *ctx, pd_archive *archive, const char *path, int columns, pd_csv *csv);
#endif

#endif
