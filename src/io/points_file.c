/* points_file: see points_file.h */
#include "io/points_file.h"
#include "io/csv.h"
#include "io/gmsh.h"
#include "io/vtu.h"
#include <math.h>
#include <string.h>

/* Largest mesh that is read. */
#define PDI_POINTS_FILE_MAX_SIZE 2147483648

/* ---- tables ---- */

/* Columns of a table: coordinates 0 to 2, and these. */
enum { PDI_POINTS_FILE_VOLUME = 3, PDI_POINTS_FILE_TAG, PDI_POINTS_FILE_COLUMNS };

/* Lower-case form of an ASCII letter. */
static char pdi_points_file_to_lower(char c) { return (char)(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); }

/* Returns 1 when a column header names the quantity, case ignored: "Volume [m3]" is volume; else 0. name: in lower
 * case. */
static int pdi_points_file_is_column_name(const char *text, const char *name)
{
    for (; *name; text++, name++)
        if (pdi_points_file_to_lower(*text) != *name) return 0;
    return !*text || *text == ' ' || *text == '[' || *text == '(';
}

/* Find the column of each quantity, column[PDI_POINTS_FILE_COLUMNS]; -1: there is none. PD_ERR_PARSE: a coordinate of
 * PD_DIM or the volume is missing, or a quantity has two columns. */
static pd_status pdi_points_file_find_columns(pd_ctx *ctx, const pd_table *t, int *column)
{
    static const char *const names[PDI_POINTS_FILE_COLUMNS] = {"x", "y", "z", "volume", "tag"};
    for (int k = 0; k < PDI_POINTS_FILE_COLUMNS; k++) {
        column[k] = -1;
        for (int c = 0; c < t->columns; c++) {
            if (!pdi_points_file_is_column_name(pd_table_get_text(t, -1, c), names[k])) continue;
            if (column[k] >= 0)
                return pd_fail(ctx, PD_ERR_PARSE, "mesh", "%s: two columns for '%s'", t->path, names[k]);
            column[k] = c;
        }
        if ((k < PD_DIM || k == PDI_POINTS_FILE_VOLUME) && column[k] < 0)
            return pd_fail(ctx, PD_ERR_PARSE, "mesh", "%s: no column is named '%s', expected %s volume and maybe tag",
                           t->path, names[k], PD_DIM == 1 ? "x," : PD_DIM == 2 ? "x, y," : "x, y, z,");
    }
    return PD_OK;
}

/* Parse a field of the table as a number of a magnitude below 1e100. PD_ERR_PARSE with path:line. */
static pd_status pdi_points_file_parse_number(pd_ctx *ctx, const pd_table *t, int row, int column, double *value)
{
    const char *text = pd_table_get_text(t, row, column);
    if (pdi_file_parse_number(text, strlen(text), value) && fabs(*value) < 1e100) return PD_OK;
    return pd_fail(ctx, PD_ERR_PARSE, "mesh", "%s:%d: column '%.40s': '%.40s', expected a finite number", t->path,
                   t->row_line[row], pd_table_get_text(t, -1, column), text);
}

/* Add the point of a row. column: -1 for none (z, tag: 0 then). constant[3]: coordinates beyond PD_DIM, set by the
 * first row and exactly equal in all others. PD_ERR_PARSE: they differ, a field is no finite number, the volume [m^d]
 * is not positive or not below 1e100, the tag is no whole number of 32 bits. */
static pd_status pdi_points_file_add_row(pd_ctx *ctx, const pd_table *t, const int *column, int row, double scale,
                                         double *constant, pd_points *points)
{
    double value[PDI_POINTS_FILE_COLUMNS] = {0.0}, position[PD_DIM], volume_scale = 1.0;
    for (int k = 0; k < PDI_POINTS_FILE_COLUMNS; k++)
        if (column[k] >= 0) PD_TRY(pdi_points_file_parse_number(ctx, t, row, column[k], &value[k]));
    for (int d = 0; d < PD_DIM; d++) {
        position[d] = value[d] * scale;
        volume_scale *= scale;
    }
    for (int d = PD_DIM; d < 3; d++) {
        if (row == 0) constant[d] = value[d];
        if (value[d] < constant[d] || value[d] > constant[d])
            return pd_fail(ctx, PD_ERR_PARSE, "mesh",
                           "%s:%d: %c = %g, expected %g as in the first row: this program"
                           " has %d dimensions",
                           t->path, t->row_line[row], "xyz"[d], value[d], constant[d], PD_DIM);
    }
    double volume = value[PDI_POINTS_FILE_VOLUME] * volume_scale, tag = value[PDI_POINTS_FILE_TAG];
    if (!(volume > 0.0) || !(volume < 1e100))
        return pd_fail(ctx, PD_ERR_PARSE, "mesh", "%s:%d: the volume %g, expected a positive one", t->path,
                       t->row_line[row], value[PDI_POINTS_FILE_VOLUME]);
    if (!(fabs(tag) <= 2147483647.0) || tag > floor(tag))
        return pd_fail(ctx, PD_ERR_PARSE, "mesh", "%s:%d: the tag %g, expected a whole number of 32 bits", t->path,
                       t->row_line[row], tag);
    return pd_points_add(ctx, points, position, volume, (int32_t)tag);
}

/* Read all points of a CSV table. */
static pd_status pdi_points_file_read_table(pd_ctx *ctx, const char *path, double scale, pd_points *points)
{
    pd_table table;
    int column[PDI_POINTS_FILE_COLUMNS];
    double constant[3] = {0.0};
    PD_TRY(pd_table_read(ctx, path, &table));
    pd_status status = pdi_points_file_find_columns(ctx, &table, column);
    for (int row = 0; row < table.rows && status == PD_OK; row++)
        status = pdi_points_file_add_row(ctx, &table, column, row, scale, constant, points);
    pd_table_free(ctx, &table);
    return status;
}

/* ---- files ---- */

/* Returns 1 when a path has this extension (with its point, in lower case), case of the path ignored; else 0. */
static int pdi_points_file_has_extension(const char *path, const char *ending)
{
    size_t size = strlen(path), more = strlen(ending);
    for (size_t k = 0; k < more; k++)
        if (size < more || pdi_points_file_to_lower(path[size - more + k]) != ending[k]) return 0;
    return 1;
}

/* Returns 1 when a text begins with another one. */
static int pdi_points_file_has_prefix(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* Read a file in the format that its extension (.csv, .msh, .vtu, case ignored) shows; without one of these by its
 * first bytes: $MeshFormat is Gmsh, <?xml or <VTKFile is VTK, all else is read as a table. PD_ERR_FILE: also above 2
 * GiB (table: PD_CSV_MAX_FILE_SIZE). PD_ERR_PARSE. */
static pd_status pdi_points_file_read_any_format(pd_ctx *ctx, const char *path, double scale, pd_points *points)
{
    char *text;
    size_t size;
    if (pdi_points_file_has_extension(path, ".csv")) return pdi_points_file_read_table(ctx, path, scale, points);
    PD_TRY(pdi_file_read_all(ctx, path, (size_t)PDI_POINTS_FILE_MAX_SIZE, &text, &size));
    pdi_tokenizer scan = pdi_tokenizer_init(ctx, "mesh", path, text, size);
    const char *at = text + strspn(text, " \t\r\n");
    int msh = pdi_points_file_has_extension(path, ".msh"), vtu = pdi_points_file_has_extension(path, ".vtu"), table = 0;
    pd_status status = PD_OK;
    if (msh || (!vtu && pdi_points_file_has_prefix(at, "$MeshFormat"))) status = pdi_gmsh_read(&scan, scale, points);
    else if (vtu || pdi_points_file_has_prefix(at, "<?xml") || pdi_points_file_has_prefix(at, "<VTKFile"))
        status = pdi_vtu_read(&scan, scale, points);
    else table = 1;
    PD_DELETE(ctx, size + 1, text);
    return table ? pdi_points_file_read_table(ctx, path, scale, points) : status;
}

pd_status pd_points_read(pd_ctx *ctx, const char *path, double scale, pd_points *points)
{
    memset(points, 0, sizeof *points);
    if (!(scale > 0.0) || !(scale < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "mesh", "the scale %g, expected a positive one", scale);
    pd_status status = pdi_points_file_read_any_format(ctx, path, scale, points);
    if (status == PD_OK && points->count == 0)
        status = pd_fail(ctx, PD_ERR_PARSE, "mesh", "%.250s: no point, and no cell of %d dimensions", path, PD_DIM);
    if (status == PD_OK) status = pd_points_shrink(ctx, points);
    if (status != PD_OK) pd_points_free(ctx, points);
    return status;
}

#undef PDI_POINTS_FILE_MAX_SIZE
