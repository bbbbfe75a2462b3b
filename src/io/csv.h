/* csv: tables of numbers as text: a writer of rows that can be read while it runs, and a reader of small tables.
 *
 * The first line names the columns ("time [s]"), and every other one is a row: what reads CSV reads these without an
 * option. Of tables that are read, lines that begin with '#' are comments. Fields are separated by commas and may stand
 * in double quotes ("" inside for one quote). Numbers are written as the shortest text that reads back as
 * the same bits.
 */
#ifndef PD_CSV_H
#define PD_CSV_H
#include "core/archive.h"
#include "io/file.h"

#define PD_CSV_COLUMNS 256       /* most columns of a table */
#define PD_CSV_FILE_LIMIT 536870912 /* [byte] largest table that is read */

/* Rows on their way to a file. Zero-initialise. */
typedef struct pd_csv {
    pd_file file;
    int columns;
} pd_csv;

/* A table that was read; all of it owned here. Zero-initialise. */
typedef struct pd_table {
    char path[PD_PATH_SIZE];
    int columns, rows;
    char *text;      /* [text_size] the file, fields ended by 0 */
    size_t text_size;
    size_t *field;   /* [capacity] offset of each field in text; the names come first */
    size_t capacity;
    int *line;       /* [line_capacity] line of the file of each row, counted from 1 */
    size_t line_capacity;
} pd_table;

#ifdef PDI_INTERNAL
/* Start a file with the names of its columns, "time [s]", written aside and renamed, then open it for appending. An
 * older file is replaced. PD_ERR_ARGUMENT: names that are empty, twice there or hold a control character. */
PDI_FN pd_status pdi_csv_create(pd_ctx *ctx, const char *path, const char *const *names, int columns,
                                pd_csv *csv);
/* Append values[columns] and flush: the row is in the file when this returns. PD_ERR_FILE. */
PDI_FN pd_status pdi_csv_row(pd_ctx *ctx, pd_csv *csv, const double *values);
/* Close. Allowed on one that is not open. PD_ERR_FILE. */
PDI_FN pd_status pdi_csv_close(pd_ctx *ctx, pd_csv *csv);

/* A whole table values[rows][columns] at once, written aside and renamed. Errors as above. */
PDI_FN pd_status pdi_csv_write(pd_ctx *ctx, const char *path, const char *const *names, int columns,
                               const double *values, int64_t rows);

/* Read a table. PD_ERR_FILE; PD_ERR_PARSE with file:line: a row with more or fewer fields than names, an open quote,
 * a name twice. */
PDI_FN pd_status pdi_table_read(pd_ctx *ctx, const char *path, pd_table *table);
/* Number of the column of this name, with its unit or, where one column alone begins so, without; -1: none. */
PDI_FN int pdi_table_find(const pd_table *table, const char *name);
/* Text of a field; row -1 is the row of names. */
PDI_FN const char *pdi_table_text(const pd_table *table, int row, int column);
/* values[rows] of the column of this name. PD_ERR_PARSE with file:line: no such column, not a number. */
PDI_FN pd_status pdi_table_column(pd_ctx *ctx, const pd_table *table, const char *name, double *values);
PDI_FN void pdi_table_free(pd_ctx *ctx, pd_table *table);

/* Note the length of a table that is open; or, reading, open that of `path` and go on from this length: rows behind it
 * are cut off. PD_ERR_FILE: it is shorter, or another one. */
PDI_FN pd_status pdi_csv_store(pd_ctx *ctx, pd_archive *archive, const char *path, int columns, pd_csv *csv);
#endif

#endif
