/* vti: see vti.h */
#include "io/vti.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_VTI_TEXT_SIZE 2048 /* [byte] buffer for a name or the header */

/* VTK name and size [byte] of each number type. */
static const char *const pdi_vti_type_names[4] = {"Float64", "Float32", "UInt8", "Int32"};
static const size_t pdi_vti_type_sizes[4] = {8, 4, 1, 4};

/* Byte order of the machine as VTK names it. */
static const char *pdi_vti_get_byte_order(void)
{
    const uint16_t probe = 1;
    uint8_t first;
    memcpy(&first, &probe, 1);
    return first ? "LittleEndian" : "BigEndian";
}

/* Escape a text for an XML attribute, into out[size]. Returns 1; 0: it does not fit or holds a control character, and
 * out is not terminated. */
static int pdi_vti_escape_xml(const char *text, char *out, size_t size)
{
    size_t used = 0;
    for (; *text; text++) {
        char plain[2] = {*text, 0};
        const char *piece = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;"
                            : *text == '"' ? "&quot;" : plain;
        size_t length = strlen(piece);
        if ((unsigned char)*text < 32 || used + length >= size) return 0;
        memcpy(out + used, piece, length);
        used += length;
    }
    out[used] = 0;
    return 1;
}

/* Number of components in the file: 3 of a vector, 1 of a scalar. */
static size_t pdi_vti_count_components(const pd_vti_field *field) { return field->vector ? 3 : 1; }

/* Number of cells of the box. */
static int64_t pdi_vti_count_cells(const pd_grid *grid)
{
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= grid->n[d];
    return cells;
}

/* Check the time, the grid and the fields. PD_ERR_ARGUMENT names the wrong one: time not finite; count negative, or
 * fields NULL; an axis without cells; a field whose name is empty, there twice, of 256 bytes and more in XML or with a
 * control character, whose data are NULL or whose type is unknown. */
static pd_status pdi_vti_check_fields(pd_ctx *ctx, const pd_grid *grid, double time, const pd_vti_field *fields,
                                      int count)
{
    char name[PDI_VTI_TEXT_SIZE];
    if (isnan(time) || isinf(time)) return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "the time is %g", time);
    if (count < 0 || (count > 0 && !fields)) return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "%d fields", count);
    for (int d = 0; d < PD_DIM; d++)
        if (grid->n[d] < 1 || !(grid->h[d] > 0))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "axis %d has %d cells of %g m", d, grid->n[d], grid->h[d]);
    for (int k = 0; k < count; k++) {
        const pd_vti_field *f = &fields[k];
        if (!f->name || !f->name[0] || !pdi_vti_escape_xml(f->name, name, 256))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "field %d has no usable name", k);
        if (!f->data || (int)f->type < 0 || (int)f->type > PD_VTI_INT32)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "field '%s' has no data or an unknown type", f->name);
        for (int j = 0; j < k; j++)
            if (strcmp(fields[j].name, f->name) == 0)
                return pd_fail(ctx, PD_ERR_ARGUMENT, "vti", "two fields are named '%s'", f->name);
    }
    return PD_OK;
}

/* Convert one component of a field at a node to the number type of the file, into out; components beyond PD_DIM, or
 * beyond one of a scalar, are 0. A double beyond the range of Float32 becomes infinite, NaN stays. */
static void pdi_vti_convert_value(const pd_grid *grid, const pd_vti_field *f, int component, int32_t node, uint8_t *out)
{
    size_t size = pdi_vti_type_sizes[f->type];
    if (component >= (f->vector ? PD_DIM : 1)) {
        memset(out, 0, size); /* all types have zero as zero bytes */
        return;
    }
    size_t at = (size_t)component * (size_t)grid->total + (size_t)node;
    if (f->type == PD_VTI_FLOAT32) {
        double value = ((const double *)f->data)[at];
        /* The conversion of a number beyond the range is undefined in C. */
        float narrow = fabs(value) <= 3.4028234663852886e38 || isnan(value) ? (float)value
                       : value > 0 ? (float)INFINITY : -(float)INFINITY;
        memcpy(out, &narrow, size);
    } else memcpy(out, (const uint8_t *)f->data + at * size, size);
}

/* Write the data of a field, without ghost nodes: their length in 8 bytes, then one row of the box (axis 0) at a time,
 * the components of a cell together. row: buffer of 24 n[0] bytes. PD_CANCELLED, PD_ERR_FILE. */
static pd_status pdi_vti_write_data(pd_ctx *ctx, pd_file *file, const pd_grid *grid, const pd_vti_field *f,
                                    uint8_t *row)
{
    size_t size = pdi_vti_type_sizes[f->type], components = pdi_vti_count_components(f);
    uint64_t bytes = (uint64_t)pdi_vti_count_cells(grid) * components * size;
    int64_t rows = pdi_vti_count_cells(grid) / grid->n[0];
    int index[PD_DIM] = {0};
    PD_TRY(pdi_file_write(ctx, file, &bytes, sizeof bytes));
    for (int64_t r = 0; r < rows; r++) {
        int32_t node = grid->ghost;
        PD_TRY(pd_check_cancel(ctx, "vti", r));
        for (int d = 1; d < PD_DIM; d++) node += (index[d] + grid->ghost) * grid->stride[d];
        uint8_t *out = row;
        for (int i = 0; i < grid->n[0]; i++)
            for (int c = 0; c < (int)components; c++, out += size) pdi_vti_convert_value(grid, f, c, node + i, out);
        PD_TRY(pdi_file_write(ctx, file, row, (size_t)(out - row)));
        for (int d = 1; d < PD_DIM; d++) {
            if (++index[d] < grid->n[d]) break;
            index[d] = 0;
        }
    }
    return PD_OK;
}

/* Write the XML header: extent, origin, spacing (the smallest one for missing dimensions), and the start of the field
 * data with the time. */
static pd_status pdi_vti_write_header(pd_ctx *ctx, pd_file *file, const pd_grid *grid, double time)
{
    char text[PDI_VTI_TEXT_SIZE], extent[96], number[7][PDI_FILE_NUMBER_SIZE];
    int n[3] = {1, 1, 1};
    double h[3], lo[3] = {0, 0, 0}, thin = grid->h[0];
    for (int d = 1; d < PD_DIM; d++) thin = pd_min(thin, grid->h[d]);
    for (int d = 0; d < 3; d++) {
        h[d] = d < PD_DIM ? grid->h[d % PD_DIM] : thin;
        if (d < PD_DIM) {
            n[d] = grid->n[d % PD_DIM];
            lo[d] = grid->lo[d % PD_DIM];
        }
        pdi_file_format_number(lo[d], number[d]);
        pdi_file_format_number(h[d], number[3 + d]);
    }
    pdi_file_format_number(time, number[6]);
    snprintf(extent, sizeof extent, "0 %d 0 %d 0 %d", n[0], n[1], n[2]);
    snprintf(text, sizeof text,
             "<?xml version=\"1.0\"?>\n"
             "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\">\n"
             "  <ImageData WholeExtent=\"%s\" Origin=\"%s %s %s\" Spacing=\"%s %s %s\">\n"
             "    <FieldData>\n"
             "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">%s"
             "</DataArray>\n",
             pdi_vti_get_byte_order(), extent, number[0], number[1], number[2], number[3], number[4], number[5],
             number[6]);
    return pdi_file_write_text(ctx, file, text);
}

/* Write the names of the values of a field as a VTK string array: byte codes in text, 0 after each name. */
static pd_status pdi_vti_write_value_names(pd_ctx *ctx, pd_file *file, const pd_vti_field *f)
{
    char text[PDI_VTI_TEXT_SIZE], name[256];
    pdi_vti_escape_xml(f->name, name, sizeof name);
    snprintf(text, sizeof text,
             "      <Array type=\"String\" Name=\"%s_names\" NumberOfTuples=\"%d\" format=\"ascii\">", name,
             f->value_name_count);
    PD_TRY(pdi_file_write_text(ctx, file, text));
    for (int k = 0; k < f->value_name_count; k++) {
        for (const char *c = f->value_names[k]; *c; c++) {
            snprintf(text, sizeof text, "%d ", (int)(unsigned char)*c);
            PD_TRY(pdi_file_write_text(ctx, file, text));
        }
        PD_TRY(pdi_file_write_text(ctx, file, "0 "));
    }
    return pdi_file_write_text(ctx, file, "</Array>\n");
}

/* Write the string arrays, end the field data, and open the piece and its cell data with the active scalar and
 * vector. */
static pd_status pdi_vti_begin_cell_data(pd_ctx *ctx, pd_file *file, const pd_grid *grid, const pd_vti_field *fields,
                                         int count)
{
    char text[PDI_VTI_TEXT_SIZE], name[256], active[2][256] = {"", ""};
    int n[3] = {1, 1, 1};
    for (int k = 0; k < count; k++) {
        if (fields[k].value_names) PD_TRY(pdi_vti_write_value_names(ctx, file, &fields[k]));
        int vector = fields[k].vector != 0;
        pdi_vti_escape_xml(fields[k].name, name, sizeof name);
        if (!active[vector][0]) memcpy(active[vector], name, sizeof name);
    }
    for (int d = 0; d < PD_DIM; d++) n[d] = grid->n[d];
    snprintf(text, sizeof text,
             "    </FieldData>\n"
             "    <Piece Extent=\"0 %d 0 %d 0 %d\">\n"
             "      <CellData%s%s%s%s%s%s>\n",
             n[0], n[1], n[2], active[0][0] ? " Scalars=\"" : "", active[0], active[0][0] ? "\"" : "",
             active[1][0] ? " Vectors=\"" : "", active[1], active[1][0] ? "\"" : "");
    return pdi_file_write_text(ctx, file, text);
}

/* Write the DataArray tag of a field; offset [byte] in the appended data. A unit that does not fit 63 bytes in XML, or
 * holds a control character, is left out. */
static pd_status pdi_vti_write_array_tag(pd_ctx *ctx, pd_file *file, const pd_vti_field *f, uint64_t offset)
{
    char text[PDI_VTI_TEXT_SIZE], name[256], unit[64] = "";
    pdi_vti_escape_xml(f->name, name, sizeof name);
    if (f->unit && !pdi_vti_escape_xml(f->unit, unit, sizeof unit)) unit[0] = 0;
    snprintf(text, sizeof text,
             "        <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" "
             "offset=\"%.0f\"",
             pdi_vti_type_names[f->type], name, (int)pdi_vti_count_components(f), (double)offset);
    PD_TRY(pdi_file_write_text(ctx, file, text));
    if (!unit[0]) return pdi_file_write_text(ctx, file, "/>\n");
    snprintf(text, sizeof text,
             "><InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">%s</InformationKey></DataArray>\n", unit);
    return pdi_file_write_text(ctx, file, text);
}

/* Write the whole file. */
static pd_status pdi_vti_write_file(pd_ctx *ctx, pd_file *file, const pd_grid *grid, double time,
                                    const pd_vti_field *fields, int count, uint8_t *row)
{
    uint64_t offset = 0;
    PD_TRY(pdi_vti_write_header(ctx, file, grid, time));
    PD_TRY(pdi_vti_begin_cell_data(ctx, file, grid, fields, count));
    for (int k = 0; k < count; k++) {
        const pd_vti_field *f = &fields[k];
        PD_TRY(pdi_vti_write_array_tag(ctx, file, f, offset));
        offset += 8 + (uint64_t)pdi_vti_count_cells(grid) * pdi_vti_count_components(f) * pdi_vti_type_sizes[f->type];
    }
    PD_TRY(pdi_file_write_text(
        ctx, file, "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_"));
    for (int k = 0; k < count; k++) PD_TRY(pdi_vti_write_data(ctx, file, grid, &fields[k], row));
    return pdi_file_write_text(ctx, file, "\n  </AppendedData>\n</VTKFile>\n");
}

pd_status pd_vti_write(pd_ctx *ctx, const char *path, const pd_grid *grid, double time, const pd_vti_field *fields,
                       int count)
{
    pd_file file;
    uint8_t *row = NULL;
    PD_TRY(pdi_vti_check_fields(ctx, grid, time, fields, count));
    size_t row_bytes = (size_t)grid->n[0] * 3 * 8;
    PD_TRY(PD_NEW(ctx, "vti", row_bytes, row));
    pd_status status = pdi_file_create(ctx, path, &file);
    if (status == PD_OK) {
        status = pdi_vti_write_file(ctx, &file, grid, time, fields, count, row);
        if (status == PD_OK) status = pdi_file_commit(ctx, &file);
        else pdi_file_abandon(&file);
    }
    PD_DELETE(ctx, row_bytes, row);
    return status;
}

/* PVD. */

PDI_FN pd_status pdi_pvd_init(pd_ctx *ctx, const char *path, pd_pvd *pvd)
{
    memset(pvd, 0, sizeof *pvd);
    if (!path || !path[0] || strlen(path) >= PD_PATH_SIZE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "pvd", "the path is empty or longer than %d characters",
                       PD_PATH_SIZE - 1);
    strcpy(pvd->path, path);
    return PD_OK;
}

PDI_FN void pdi_pvd_free(pd_ctx *ctx, pd_pvd *pvd)
{
    PD_DELETE(ctx, pvd->capacity, pvd->entries);
    memset(pvd, 0, sizeof *pvd);
}

/* Path of a file relative to the folder of the collection, where it lies below that, else as it is: a part of
 * `file`. */
static const char *pdi_vti_relative_path(const pd_pvd *pvd, const char *file)
{
    size_t length = strlen(pvd->path);
    while (length > 0 && !pdi_file_is_separator(pvd->path[length - 1])) length--;
    return length && strncmp(pvd->path, file, length) == 0 ? file + length : file;
}

/* Write the collection file through a temporary one, which is deleted on failure. PD_ERR_FILE. */
static pd_status pdi_vti_write_collection(pd_ctx *ctx, const pd_pvd *pvd)
{
    char head[160];
    pd_file file;
    snprintf(head, sizeof head,
             "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"%s\">\n"
             "  <Collection>\n",
             pdi_vti_get_byte_order());
    PD_TRY(pdi_file_create(ctx, pvd->path, &file));
    pd_status status = pdi_file_write_text(ctx, &file, head);
    if (status == PD_OK) status = pdi_file_write(ctx, &file, pvd->entries, pvd->size);
    if (status == PD_OK) status = pdi_file_write_text(ctx, &file, "  </Collection>\n</VTKFile>\n");
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

PDI_FN pd_status pdi_pvd_add_file(pd_ctx *ctx, pd_pvd *pvd, double time, const char *file)
{
    char line[PDI_VTI_TEXT_SIZE + 128], name[PDI_VTI_TEXT_SIZE], stamp[PDI_FILE_NUMBER_SIZE];
    if (!pvd->path[0]) return pd_fail(ctx, PD_ERR_ARGUMENT, "pvd", "the collection was not started by pdi_pvd_init");
    if (isnan(time) || isinf(time)) return pd_fail(ctx, PD_ERR_ARGUMENT, "pvd", "%s: the time is %g", file, time);
    if (pvd->count && !(time > pvd->last_time))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "pvd", "%s: time %.17g s does not follow %.17g s, times must increase",
                       file, time, pvd->last_time);
    if (!pdi_vti_escape_xml(pdi_vti_relative_path(pvd, file), name, sizeof name))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "pvd", "the file name '%.80s' cannot be listed", file);
    pdi_file_format_number(time, stamp);
    size_t length = (size_t)snprintf(line, sizeof line,
                                     "    <DataSet timestep=\"%s\" group=\"\" part=\"0\" file=\"%s\"/>\n", stamp, name);
    if (pvd->size + length > pvd->capacity) {
        size_t capacity = 2 * pvd->capacity + length + 1024;
        PD_TRY(PD_GROW(ctx, "pvd", pvd->capacity, capacity, pvd->entries));
        pvd->capacity = capacity;
    }
    memcpy(pvd->entries + pvd->size, line, length);
    pvd->size += length;
    pd_status status = pdi_vti_write_collection(ctx, pvd);
    if (status != PD_OK) {
        pvd->size -= length; /* the collection stays as it is on disk */
        return status;
    }
    pvd->last_time = time;
    pvd->count++;
    return PD_OK;
}

PDI_FN pd_status pdi_pvd_store(pd_ctx *ctx, pd_pvd *pvd, pd_archive *archive)
{
    int64_t size = (int64_t)pvd->size;
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "collection.last", &pvd->last_time, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "collection.count", &pvd->count, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "collection.size", &size, 1));
    if (size > (int64_t)pvd->capacity) {
        PD_TRY(PD_GROW(ctx, "pvd", pvd->capacity, size, pvd->entries));
        pvd->capacity = (size_t)size;
    }
    pvd->size = (size_t)size;
    return PD_ARCHIVE_ARRAY(ctx, archive, "collection", pvd->entries, size);
}
