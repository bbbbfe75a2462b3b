/* vtu: see vtu.h */
#include "io/vtu.h"
#include "io/zlib.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Maximum bytes out of one byte of a zlib stream (RFC 1951: 258 bytes for two bits). */
#define PDI_VTU_UNPACKED 1032

/* A substring of the file. */
typedef struct pdi_vtu_text {
    const char *at;
    size_t size;
} pdi_vtu_text;

/* An XML tag: <name attributes> or </name>. */
typedef struct pdi_vtu_tag {
    const char *begin;
    pdi_vtu_text name, attributes;
    int closes, empty; /* 1: </name>; 1: <name/> */
} pdi_vtu_tag;

/* A <DataArray>: its tag, and the text up to the next tag. */
typedef struct pdi_vtu_array {
    int found;
    pdi_vtu_tag tag;
    const char *body, *end;
} pdi_vtu_array;

/* The data arrays that are read. */
enum { PDI_VTU_PLACES = 0, PDI_VTU_CONNECTIVITY, PDI_VTU_OFFSETS, PDI_VTU_TYPES, PDI_VTU_CELL_TAG, PDI_VTU_POINT_TAG,
       PDI_VTU_VOLUME, PDI_VTU_ARRAYS };

/* State of reading a file. */
typedef struct pdi_vtu {
    pdi_scan *scan;
    pdi_cells cells;        /* conversion of cells to points */
    const char *limit;      /* end of the XML text: where the appended data begin, or the end of the file */
    const char *appended;   /* first byte of the appended data; NULL: there are none */
    int plain;              /* 1: appended data are raw, 0: base64 */
    int swap, wide, packed; /* 1: other byte order; 1: sizes have 8 bytes, 0: 4; 1: zlib blocks */
    int64_t points, count;  /* number of points and of cells of the current piece */
    int64_t before;         /* number of points of the pieces before it */
    pdi_skin skin;          /* faces of the cells */
    int section;            /* 0: none; 'P', 'C', 'c', 'p': Points, Cells, CellData, PointData */
    int rank;               /* priority of the name of the region array found so far; 0: highest */
    pdi_vtu_array array[PDI_VTU_ARRAYS];
    double *value[PDI_VTU_ARRAYS]; /* decoded arrays */
    int64_t length[PDI_VTU_ARRAYS];
} pdi_vtu;

/* ---- tags ---- */

/* Returns 1 when a substring equals a word. */
static int pdi_vtu_is(pdi_vtu_text text, const char *word)
{
    return text.size == strlen(word) && memcmp(text.at, word, text.size) == 0;
}

/* Returns 1 for white space. */
static int pdi_vtu_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* Read the next tag before the limit, skipping comments and declarations. *found 0: there is none. */
static pd_status pdi_vtu_next(pdi_vtu *v, pdi_vtu_tag *tag, int *found)
{
    pdi_scan *s = v->scan;
    memset(tag, 0, sizeof *tag);
    for (*found = 0;;) {
        while (s->at < v->limit && *s->at != '<') s->at++;
        if (s->at >= v->limit) return PD_OK;
        tag->begin = s->at++;
        int comment = v->limit - s->at > 3 && memcmp(s->at, "!--", 3) == 0;
        char quote = 0;
        for (; s->at < v->limit && (quote || comment || *s->at != '>'); s->at++) {
            if (comment && *s->at == '>' && s->at - tag->begin > 5 && s->at[-1] == '-' && s->at[-2] == '-') break;
            if (!comment && (*s->at == '"' || *s->at == '\'')) quote = quote == *s->at ? 0 : quote ? quote : *s->at;
        }
        if (s->at >= v->limit) return pdi_scan_fail(s, tag->begin, "a tag that does not end");
        s->at++;
        if (tag->begin[1] != '!' && tag->begin[1] != '?') break;
    }
    const char *at = tag->begin + 1, *end = s->at - 1;
    tag->closes = *at == '/';
    at += tag->closes;
    tag->empty = end > at && end[-1] == '/';
    tag->name.at = at;
    while (at < end && !pdi_vtu_blank(*at) && *at != '/') at++;
    tag->name.size = (size_t)(at - tag->name.at);
    tag->attributes.at = at;
    tag->attributes.size = (size_t)(end - at);
    *found = 1;
    return PD_OK;
}

/* Value of an attribute of a tag. Returns 0 when the tag has none of this name; *value is unchanged then. */
static int pdi_vtu_attribute(const pdi_vtu_tag *tag, const char *name, pdi_vtu_text *value)
{
    const char *at = tag->attributes.at, *end = at + tag->attributes.size;
    while (at < end) {
        pdi_vtu_text key;
        while (at < end && pdi_vtu_blank(*at)) at++;
        key.at = at;
        while (at < end && *at != '=' && !pdi_vtu_blank(*at)) at++;
        key.size = (size_t)(at - key.at);
        while (at < end && *at != '"' && *at != '\'') at++;
        if (at >= end) return 0;
        char quote = *at++;
        const char *begin = at;
        while (at < end && *at != quote) at++;
        if (at >= end) return 0;
        if (pdi_vtu_is(key, name)) {
            value->at = begin;
            value->size = (size_t)(at - begin);
            return 1;
        }
        at++;
    }
    return 0;
}

/* Read an integer attribute from 0 to high; absent: `fallback`, or an error where that is negative. */
static pd_status pdi_vtu_integer(const pdi_vtu *v, const pdi_vtu_tag *tag, const char *name, int64_t high,
                                 int64_t fallback, int64_t *value)
{
    pdi_vtu_text text;
    pdi_scan part = *v->scan;
    *value = fallback;
    if (!pdi_vtu_attribute(tag, name, &text)) {
        if (fallback >= 0) return PD_OK;
        return pdi_scan_fail(v->scan, tag->begin, "a tag without %s", name);
    }
    part.at = text.at;
    part.end = text.at + text.size;
    return pdi_scan_integer(&part, name, 0, high, value);
}

/* ---- data ---- */

/* A stream of bytes, raw or decoded from base64, where padding may stand within. */
typedef struct pdi_vtu_stream {
    const char *at, *end; /* characters still to read */
    int plain, held; /* 1: raw; number of decoded bytes in hold */
    uint8_t hold[3]; /* decoded bytes in reverse order */
} pdi_vtu_stream;

/* Value 0..63 of a base64 character (RFC 4648), -1 for others. */
static int pdi_vtu_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *found = c ? strchr(digits, c) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* Decode the next four base64 characters. Returns 0 at the end, or when they are no base64. */
static int pdi_vtu_group(pdi_vtu_stream *s)
{
    uint32_t bits = 0;
    int digits = 0, padding = 0;
    for (; digits + padding < 4 && s->at < s->end; s->at++) {
        if (pdi_vtu_blank(*s->at)) continue;
        int digit = pdi_vtu_digit(*s->at);
        if (*s->at == '=') padding++;
        else if (digit < 0 || padding) return 0;
        else digits++;
        bits = bits << 6 | (uint32_t)(digit < 0 ? 0 : digit);
    }
    if (digits + padding < 4 || digits < 2) return 0;
    s->held = digits - 1;
    for (int k = 0; k < s->held; k++) s->hold[s->held - 1 - k] = (uint8_t)(bits >> (16 - 8 * k));
    return 1;
}

/* Read `size` bytes from the stream. Returns 0 when there are fewer. */
static int pdi_vtu_take(pdi_vtu_stream *s, uint8_t *out, size_t size)
{
    if (s->plain) {
        if (size > (size_t)(s->end - s->at)) return 0;
        memcpy(out, s->at, size);
        s->at += size;
        return 1;
    }
    for (size_t k = 0; k < size; k++) {
        if (s->held == 0 && !pdi_vtu_group(s)) return 0;
        out[k] = s->hold[--s->held];
    }
    return 1;
}

/* Decode an unsigned integer of `size` bytes in the byte order of the file. */
static uint64_t pdi_vtu_whole(const pdi_vtu *v, const uint8_t *bytes, int size)
{
    const uint16_t probe = 1;
    uint8_t first;
    uint64_t value = 0;
    memcpy(&first, &probe, 1);
    int low_first = (first == 1) != (v->swap == 1);
    for (int k = 0; k < size; k++) value = value << 8 | bytes[low_first ? size - 1 - k : k];
    return value;
}

/* Read a size of 4 or 8 bytes from the stream. Returns 0 at its end. */
static int pdi_vtu_size(const pdi_vtu *v, pdi_vtu_stream *s, uint64_t *size)
{
    uint8_t bytes[8];
    int wide = v->wide ? 8 : 4;
    if (!pdi_vtu_take(s, bytes, (size_t)wide)) return 0;
    *size = pdi_vtu_whole(v, bytes, wide);
    return 1;
}

/* Inflate the zlib blocks of an array into out[size]. *fault: an error text, NULL when all is well. */
static pd_status pdi_vtu_unpack(const pdi_vtu *v, pdi_vtu_stream *s, uint8_t *out, size_t size, const char **fault)
{
    uint64_t blocks, each, last, packed, left = (uint64_t)(s->end - s->at);
    *fault = "blocks of data that do not fit their array";
    if (!pdi_vtu_size(v, s, &blocks) || !pdi_vtu_size(v, s, &each) || !pdi_vtu_size(v, s, &last)) return PD_OK;
    if (blocks > left / 4 || each > INT32_MAX || last > each) return PD_OK;
    uint64_t whole = blocks ? (blocks - 1) * each + (last ? last : each) : 0;
    if (whole != size) return PD_OK;
    pdi_vtu_stream sizes = *s; /* a second stream reads the sizes again while the blocks are read */
    for (uint64_t b = 0; b < blocks; b++)
        if (!pdi_vtu_size(v, s, &packed)) return PD_OK;
    s->held = 0;
    for (uint64_t b = 0; b < blocks; b++) {
        uint8_t *bytes = NULL;
        size_t of = (size_t)(b + 1 == blocks && last ? last : each);
        if (!pdi_vtu_size(v, &sizes, &packed) || packed > left) return PD_OK;
        PDI_TRY(PDI_NEW(v->scan->ctx, "vtu", packed, bytes));
        int got = pdi_vtu_take(s, bytes, (size_t)packed);
        pd_status status = PD_OK;
        if (got) status = pdi_zlib_inflate(v->scan->ctx, v->scan->path, bytes, (size_t)packed, out + b * each, of);
        PDI_DELETE(v->scan->ctx, packed, bytes);
        if (!got || status != PD_OK) return status;
    }
    *fault = NULL;
    return PD_OK;
}

/* Number types of data arrays. */
typedef enum pdi_vtu_type { PDI_VTU_SIGNED = 0, PDI_VTU_UNSIGNED, PDI_VTU_FLOAT } pdi_vtu_type;

/* Number type of "Int32", "UInt8", "Float64", ... Returns its size in bytes, 0 for an unknown one. */
static int pdi_vtu_kind(pdi_vtu_text text, pdi_vtu_type *type)
{
    static const struct {
        char name[8];
        int size;
        pdi_vtu_type type;
    } types[10] = {{"Int8", 1, PDI_VTU_SIGNED},    {"Int16", 2, PDI_VTU_SIGNED},    {"Int32", 4, PDI_VTU_SIGNED},
                   {"Int64", 8, PDI_VTU_SIGNED},   {"UInt8", 1, PDI_VTU_UNSIGNED},  {"UInt16", 2, PDI_VTU_UNSIGNED},
                   {"UInt32", 4, PDI_VTU_UNSIGNED}, {"UInt64", 8, PDI_VTU_UNSIGNED}, {"Float32", 4, PDI_VTU_FLOAT},
                   {"Float64", 8, PDI_VTU_FLOAT}};
    for (int k = 0; k < 10; k++)
        if (pdi_vtu_is(text, types[k].name)) {
            *type = types[k].type;
            return types[k].size;
        }
    return 0;
}

/* Decode one number of this type and size. */
static double pdi_vtu_number(const pdi_vtu *v, const uint8_t *bytes, int size, pdi_vtu_type type)
{
    uint64_t bits = pdi_vtu_whole(v, bytes, size);
    if (type == PDI_VTU_UNSIGNED) return (double)bits;
    if (type == PDI_VTU_SIGNED) {
        uint64_t minus = UINT64_C(1) << (8 * size - 1);
        return bits & minus ? -(double)(minus - (bits & (minus - 1))) : (double)bits;
    }
    if (size == 4) {
        uint32_t half = (uint32_t)bits;
        float single;
        memcpy(&single, &half, sizeof single);
        return (double)single;
    }
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Open the stream of an array, inline or appended. */
static pd_status pdi_vtu_open(const pdi_vtu *v, const pdi_vtu_array *a, pdi_vtu_stream *s)
{
    pdi_vtu_text format;
    int64_t offset;
    memset(s, 0, sizeof *s);
    s->at = a->body;
    s->end = a->end;
    if (!pdi_vtu_attribute(&a->tag, "format", &format) || !pdi_vtu_is(format, "appended")) return PD_OK;
    PDI_TRY(pdi_vtu_integer(v, &a->tag, "offset", INT64_C(999999999999999), -1, &offset));
    if (!v->appended || offset > (int64_t)(v->scan->end - v->appended))
        return pdi_scan_fail(v->scan, a->tag.begin, "an array beyond the appended data");
    s->at = v->appended + offset;
    s->end = v->scan->end;
    s->plain = v->plain;
    return PD_OK;
}

/* Decode a binary array of `count` numbers. */
static pd_status pdi_vtu_binary(const pdi_vtu *v, const pdi_vtu_array *a, int64_t count, double *value)
{
    pdi_vtu_text text = {"", 0};
    pdi_vtu_type type = PDI_VTU_SIGNED;
    pdi_vtu_stream s;
    const char *fault = NULL;
    uint8_t *bytes = NULL;
    uint64_t given;
    (void)pdi_vtu_attribute(&a->tag, "type", &text);
    int each = pdi_vtu_kind(text, &type);
    size_t size = (size_t)count * (size_t)each;
    PDI_TRY(pdi_vtu_open(v, a, &s));
    PDI_TRY(PDI_NEW(v->scan->ctx, "vtu", size, bytes));
    pd_status status = PD_OK;
    if (v->packed) status = pdi_vtu_unpack(v, &s, bytes, size, &fault);
    else if (!pdi_vtu_size(v, &s, &given) || given != size || !pdi_vtu_take(&s, bytes, size))
        fault = "data that are shorter or longer than their array";
    for (int64_t k = 0; status == PD_OK && !fault && k < count; k++) {
        value[k] = pdi_vtu_number(v, bytes + (size_t)k * (size_t)each, each, type);
        if (!(fabs(value[k]) < 1e100)) fault = "a number that is not finite";
    }
    PDI_DELETE(v->scan->ctx, size, bytes);
    return fault && status == PD_OK ? pdi_scan_fail(v->scan, a->tag.begin, "%s", fault) : status;
}

/* Parse a text array of `count` numbers. */
static pd_status pdi_vtu_ascii(const pdi_vtu *v, const pdi_vtu_array *a, int64_t count, double *value)
{
    pdi_scan part = *v->scan;
    const char *word;
    part.at = a->body;
    part.end = a->end;
    for (int64_t k = 0; k < count; k++) {
        PDI_TRY(pdi_scan_number(&part, "a number of an array", &value[k]));
        if (!(fabs(value[k]) < 1e100)) return pdi_scan_fail(&part, part.at, "a number beyond 1e100");
    }
    if (pdi_scan_word(&part, &word) == 0) return PD_OK;
    return pdi_scan_fail(&part, word, "an array of more than its %.0f numbers", (double)count);
}

/* Decode the array `which`, of `count` numbers, into new memory. what: its name for messages. */
static pd_status pdi_vtu_decode(pdi_vtu *v, int which, const char *what, int64_t count)
{
    const pdi_vtu_array *a = &v->array[which];
    pdi_vtu_text format = {"ascii", 5}, text = {"", 0};
    pdi_vtu_type type;
    if (!a->found) return pdi_scan_fail(v->scan, v->scan->at, "a piece without its array %s", what);
    (void)pdi_vtu_attribute(&a->tag, "type", &text);
    int size = pdi_vtu_kind(text, &type);
    if (!size) return pdi_scan_fail(v->scan, a->tag.begin, "an array of the type '%.*s', expected Int8 to Float64",
                                    text.size < 20 ? (int)text.size : 20, text.at);
    (void)pdi_vtu_attribute(&a->tag, "format", &format);
    int ascii = pdi_vtu_is(format, "ascii"), appended = pdi_vtu_is(format, "appended");
    if (!ascii && !appended && !pdi_vtu_is(format, "binary"))
        return pdi_scan_fail(v->scan, a->tag.begin, "an array of an unknown format");
    double room = appended ? (double)(v->scan->end - v->scan->text) : (double)(a->end - a->body);
    room = ascii ? 0.5 * room + 1.0 : room * (v->packed ? PDI_VTU_UNPACKED : 1) / size;
    if ((double)count > room)
        return pdi_scan_fail(v->scan, a->tag.begin, "an array of %.0f numbers, which is more than it can hold",
                             (double)count);
    PDI_TRY(PDI_NEW(v->scan->ctx, "vtu", count, v->value[which]));
    v->length[which] = count;
    return ascii ? pdi_vtu_ascii(v, a, count, v->value[which]) : pdi_vtu_binary(v, a, count, v->value[which]);
}

/* ---- pieces ---- */

/* Cell type of a VTK cell type, and its dimension, -1 when unknown. PDI_CELL_NONE: not supported. */
static pdi_cell_form pdi_vtu_form(int type, int *dimension)
{
    static const int8_t dimensions[15] = {-1, 0, 0, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3};
    static const int8_t form[15] = {0,
                                    0,
                                    0,
                                    PDI_CELL_LINE,
                                    0,
                                    PDI_CELL_TRIANGLE,
                                    0,
                                    0,
                                    PDI_CELL_QUAD,
                                    PDI_CELL_QUAD,
                                    PDI_CELL_TETRAHEDRON,
                                    PDI_CELL_HEXAHEDRON,
                                    PDI_CELL_HEXAHEDRON,
                                    PDI_CELL_WEDGE,
                                    PDI_CELL_PYRAMID};
    *dimension = type > 0 && type < 15 ? dimensions[type] : -1;
    return type > 0 && type < 15 ? (pdi_cell_form)form[type] : PDI_CELL_NONE;
}

/* Region (tag) number k of an array; 0 without the array. */
static pd_status pdi_vtu_region(const pdi_vtu *v, int which, int64_t k, int32_t *tag)
{
    double value = v->value[which] ? v->value[which][k] : 0.0;
    *tag = 0;
    if (!(fabs(value) <= 2147483647.0) || value < floor(value) || value > floor(value))
        return pdi_scan_fail(v->scan, v->array[which].tag.begin, "the tag %g, expected whole numbers of 32 bits",
                             value);
    *tag = (int32_t)value;
    return PD_OK;
}

/* Add cell k, whose nodes begin at `first` of the connectivity, as a point; *count_used is incremented when it has
 * PD_DIM dimensions. */
static pd_status pdi_vtu_cell(pdi_vtu *v, int64_t k, int64_t first, int64_t corners, int64_t *count_used)
{
    static const int8_t swapped[8] = {0, 1, 3, 2, 4, 5, 7, 6};
    int64_t number[8];
    const double *corner[8], *node = v->value[PDI_VTU_CONNECTIVITY] + first;
    double type = v->value[PDI_VTU_TYPES][k];
    const char *fault, *at = v->array[PDI_VTU_CONNECTIVITY].tag.begin;
    int dimension, of = type > 0.0 && type < 100.0 ? (int)type : 0;
    pdi_cell_form form = pdi_vtu_form(of, &dimension);
    if (dimension < 0 || dimension > PD_DIM || (dimension == PD_DIM && form == PDI_CELL_NONE))
        return pdi_scan_fail(v->scan, v->array[PDI_VTU_TYPES].tag.begin,
                             "cell %.0f is of VTK's type %g, expected straight cells of at most %d dimensions",
                             (double)k, type, PD_DIM);
    if (dimension < PD_DIM) return PD_OK;
    if (corners != pdi_points_corners(form))
        return pdi_scan_fail(v->scan, at, "cell %.0f has %.0f corners, expected %d", (double)k, (double)corners,
                             pdi_points_corners(form));
    for (int c = 0; c < (int)corners; c++) {
        double id = node[of == 8 || of == 11 ? swapped[c] : c];
        if (!(id >= 0.0) || !(id < (double)v->points) || id > floor(id))
            return pdi_scan_fail(v->scan, at, "cell %.0f has the point %g of %.0f", (double)k, id, (double)v->points);
        corner[c] = v->value[PDI_VTU_PLACES] + 3 * (int64_t)id;
        number[c] = v->before + (int64_t)id;
    }
    int32_t tag;
    PDI_TRY(pdi_vtu_region(v, PDI_VTU_CELL_TAG, k, &tag));
    PDI_TRY(pdi_cells_add(v->scan->ctx, &v->cells, form, corner, of == 13, tag, &fault));
    ++*count_used;
    if (fault) return pdi_scan_fail(v->scan, at, "cell %.0f: %s", (double)k, fault);
    return pdi_skin_add(v->scan->ctx, &v->skin, form, number, corner, v->cells.points->count - 1);
}

/* Decode the cells of a piece and add them as points. */
static pd_status pdi_vtu_all_cells(pdi_vtu *v, int64_t *count_used)
{
    double last = 0.0;
    PDI_TRY(pdi_vtu_decode(v, PDI_VTU_TYPES, "types", v->count));
    PDI_TRY(pdi_vtu_decode(v, PDI_VTU_OFFSETS, "offsets", v->count));
    for (int64_t k = 0; k < v->count; k++) {
        double offset = v->value[PDI_VTU_OFFSETS][k];
        if (!(offset >= last) || offset > floor(offset) || !(offset < 1e15))
            return pdi_scan_fail(v->scan, v->array[PDI_VTU_OFFSETS].tag.begin, "offsets that do not ascend");
        last = offset;
    }
    PDI_TRY(pdi_vtu_decode(v, PDI_VTU_CONNECTIVITY, "connectivity", (int64_t)last));
    if (v->array[PDI_VTU_CELL_TAG].found) PDI_TRY(pdi_vtu_decode(v, PDI_VTU_CELL_TAG, "of tags", v->count));
    v->cells.sign = 0.0;
    for (int64_t k = 0, first = 0; k < v->count; k++) {
        int64_t end = (int64_t)v->value[PDI_VTU_OFFSETS][k];
        PDI_TRY(pdi_vtu_cell(v, k, first, end - first, count_used));
        first = end;
    }
    return PD_OK;
}

/* Add the points of a piece themselves, with their volumes. */
static pd_status pdi_vtu_all_points(pdi_vtu *v)
{
    double scale = 1.0;
    for (int d = 0; d < PD_DIM; d++) scale *= v->cells.scale;
    PDI_TRY(pdi_vtu_decode(v, PDI_VTU_VOLUME, "volume", v->points));
    if (v->array[PDI_VTU_POINT_TAG].found) PDI_TRY(pdi_vtu_decode(v, PDI_VTU_POINT_TAG, "of tags", v->points));
    for (int64_t k = 0; k < v->points; k++) {
        const double *x = v->value[PDI_VTU_PLACES] + 3 * k;
        double position[PD_DIM], volume = v->value[PDI_VTU_VOLUME][k] * scale;
        int32_t tag;
        for (int d = 0; d < PD_DIM; d++) position[d] = x[d] * v->cells.scale;
        for (int d = PD_DIM; d < 3; d++)
            if (fabs(x[d] - v->value[PDI_VTU_PLACES][d]) > 1e-9 * v->cells.extent)
                return pdi_scan_fail(v->scan, v->array[PDI_VTU_PLACES].tag.begin, "point %.0f lies off the %dD of the"
                                     " others", (double)k, PD_DIM);
        if (!(volume > 0.0))
            return pdi_scan_fail(v->scan, v->array[PDI_VTU_VOLUME].tag.begin, "point %.0f has the volume %g, expected"
                                 " positive ones", (double)k, v->value[PDI_VTU_VOLUME][k]);
        PDI_TRY(pdi_vtu_region(v, PDI_VTU_POINT_TAG, k, &tag));
        PDI_TRY(pdi_points_add(v->scan->ctx, v->cells.points, position, volume, tag));
    }
    return PD_OK;
}

/* Add the cells, or else the points, of a piece whose arrays have been located. */
static pd_status pdi_vtu_piece(pdi_vtu *v, const char *begin)
{
    int64_t counts = 0, components;
    if (v->points == 0 && v->count == 0) return PD_OK;
    if (v->array[PDI_VTU_PLACES].found) {
        PDI_TRY(pdi_vtu_integer(v, &v->array[PDI_VTU_PLACES].tag, "NumberOfComponents", 9, 1, &components));
        if (components != 3) return pdi_scan_fail(v->scan, v->array[PDI_VTU_PLACES].tag.begin, "points of %.0f"
                                                  " coordinates, expected 3", (double)components);
    }
    PDI_TRY(pdi_vtu_decode(v, PDI_VTU_PLACES, "of points", 3 * v->points));
    for (int64_t k = 0; k < 3 * v->points; k++)
        v->cells.extent = pdi_max(v->cells.extent, fabs(v->value[PDI_VTU_PLACES][k] - v->value[PDI_VTU_PLACES][k % 3]));
    if (v->count) PDI_TRY(pdi_vtu_all_cells(v, &counts));
    if (counts) return PD_OK;
    if (v->array[PDI_VTU_VOLUME].found) return pdi_vtu_all_points(v);
    return pdi_scan_fail(v->scan, begin, "a piece without cells of %d dimensions, and without point data 'volume'",
                         PD_DIM);
}

/* Free the arrays of a piece. */
static void pdi_vtu_forget(pdi_vtu *v)
{
    for (int k = 0; k < PDI_VTU_ARRAYS; k++) {
        PDI_DELETE(v->scan->ctx, v->length[k], v->value[k]);
        v->length[k] = 0;
    }
    memset(v->array, 0, sizeof v->array);
    v->rank = 99;
}

/* Which of the known arrays a DataArray tag is, by its section and name; -1: none. */
static int pdi_vtu_which(pdi_vtu *v, const pdi_vtu_tag *tag)
{
    static const char *const tags[] = {"tag", "region", "material", "gmsh:physical"};
    pdi_vtu_text name = {"", 0};
    (void)pdi_vtu_attribute(tag, "Name", &name);
    if (v->section == 'P') return PDI_VTU_PLACES;
    if (v->section == 'C')
        return pdi_vtu_is(name, "connectivity") ? PDI_VTU_CONNECTIVITY
               : pdi_vtu_is(name, "offsets")    ? PDI_VTU_OFFSETS
               : pdi_vtu_is(name, "types")      ? PDI_VTU_TYPES
                                                : -1;
    if (v->section == 'p' && pdi_vtu_is(name, "volume")) return PDI_VTU_VOLUME;
    for (int k = 0; k < 4; k++)
        if ((v->section == 'c' || v->section == 'p') && pdi_vtu_is(name, tags[k])) {
            if (v->section == 'p') return v->array[PDI_VTU_POINT_TAG].found ? -1 : PDI_VTU_POINT_TAG;
            if (k > v->rank) return -1;
            v->rank = k;
            return PDI_VTU_CELL_TAG;
        }
    return -1;
}

/* Note the position of a DataArray that is needed. */
static void pdi_vtu_keep(pdi_vtu *v, const pdi_vtu_tag *tag)
{
    int which = pdi_vtu_which(v, tag);
    if (which < 0) return;
    pdi_vtu_array *a = &v->array[which];
    a->found = 1;
    a->tag = *tag;
    a->body = v->scan->at;
    a->end = a->body;
    while (!tag->empty && a->end < v->limit && *a->end != '<') a->end++;
}

/* ---- the file ---- */

/* Read the VTKFile tag: type, byte order, size of headers, compressor. */
static pd_status pdi_vtu_head(pdi_vtu *v, const pdi_vtu_tag *tag)
{
    const uint16_t probe = 1;
    uint8_t first;
    pdi_vtu_text text;
    memcpy(&first, &probe, 1);
    if (!pdi_vtu_attribute(tag, "type", &text) || !pdi_vtu_is(text, "UnstructuredGrid"))
        return pdi_scan_fail(v->scan, tag->begin, "no VTKFile of the type UnstructuredGrid");
    if (pdi_vtu_attribute(tag, "byte_order", &text)) v->swap = pdi_vtu_is(text, "LittleEndian") != (first == 1);
    v->wide = pdi_vtu_attribute(tag, "header_type", &text) && pdi_vtu_is(text, "UInt64");
    v->packed = pdi_vtu_attribute(tag, "compressor", &text) && text.size > 0;
    if (v->packed && !pdi_vtu_is(text, "vtkZLibDataCompressor"))
        return pdi_scan_fail(v->scan, tag->begin, "data packed by '%.*s', expected vtkZLibDataCompressor",
                             text.size < 40 ? (int)text.size : 40, text.at);
    return PD_OK;
}

/* Locate the appended data, which begin behind an underscore. */
static pd_status pdi_vtu_find_appended(pdi_vtu *v)
{
    pdi_vtu_tag tag;
    pdi_vtu_text text;
    int more;
    const char *found = strstr(v->scan->text, "<AppendedData");
    v->limit = v->scan->end;
    if (!found) return PD_OK;
    v->scan->at = found;
    PDI_TRY(pdi_vtu_next(v, &tag, &more));
    v->plain = pdi_vtu_attribute(&tag, "encoding", &text) && pdi_vtu_is(text, "raw");
    const char *at = v->scan->at;
    while (at < v->scan->end && pdi_vtu_blank(*at)) at++;
    if (at >= v->scan->end || *at != '_') return pdi_scan_fail(v->scan, found, "appended data without their mark '_'");
    v->appended = at + 1;
    v->limit = found;
    v->scan->at = v->scan->text;
    return PD_OK;
}

/* Section that a tag of this name opens or closes; 0: none. */
static int pdi_vtu_section(pdi_vtu_text name)
{
    return pdi_vtu_is(name, "Points")      ? 'P'
           : pdi_vtu_is(name, "Cells")     ? 'C'
           : pdi_vtu_is(name, "CellData")  ? 'c'
           : pdi_vtu_is(name, "PointData") ? 'p'
                                           : 0;
}

/* Handle an opening tag. *headed 1: VTKFile has been read; *piece: begin of the current piece, NULL outside. */
static pd_status pdi_vtu_enter(pdi_vtu *v, const pdi_vtu_tag *tag, int *headed, const char **piece)
{
    if (pdi_vtu_is(tag->name, "VTKFile")) {
        *headed = 1;
        return pdi_vtu_head(v, tag);
    }
    if (!*headed) return pdi_scan_fail(v->scan, tag->begin, "no VTKFile");
    if (pdi_vtu_is(tag->name, "Piece")) {
        *piece = tag->empty ? NULL : tag->begin;
        PDI_TRY(pdi_vtu_integer(v, tag, "NumberOfPoints", INT32_MAX, -1, &v->points));
        return pdi_vtu_integer(v, tag, "NumberOfCells", INT32_MAX, -1, &v->count);
    }
    if (pdi_vtu_is(tag->name, "DataArray") && *piece) pdi_vtu_keep(v, tag);
    if (pdi_vtu_section(tag->name) && !tag->empty) v->section = pdi_vtu_section(tag->name);
    return PD_OK;
}

/* Read the file tag by tag; a piece is converted at its closing tag. */
static pd_status pdi_vtu_file(pdi_vtu *v)
{
    int more = 1, headed = 0, ended = 0;
    const char *piece = NULL;
    PDI_TRY(pdi_vtu_find_appended(v));
    while (more && !ended) {
        pdi_vtu_tag tag;
        PDI_TRY(pdi_vtu_next(v, &tag, &more));
        if (!more) break;
        if (!tag.closes) PDI_TRY(pdi_vtu_enter(v, &tag, &headed, &piece));
        if (!tag.closes) continue;
        ended = pdi_vtu_is(tag.name, "UnstructuredGrid");
        if (pdi_vtu_is(tag.name, "Piece") && piece) {
            pd_status status = pdi_vtu_piece(v, piece);
            v->before += v->points;
            v->skin.part++;
            pdi_vtu_forget(v);
            PDI_TRY(status);
            piece = NULL;
        }
        if (pdi_vtu_section(tag.name)) v->section = 0;
    }
    if (!headed) return pdi_scan_fail(v->scan, v->scan->text, "no VTKFile");
    return ended ? PD_OK : pdi_scan_fail(v->scan, v->limit, "the file ends before </UnstructuredGrid>");
}

PDI_FN pd_status pdi_vtu_read(pdi_scan *scan, double scale, pd_points *points)
{
    pdi_vtu v;
    memset(&v, 0, sizeof v);
    v.scan = scan;
    v.cells.points = points;
    v.cells.scale = scale;
    v.rank = 99;
    pd_status status = pdi_vtu_file(&v);
    pdi_vtu_forget(&v);
    if (status == PD_OK) status = pdi_skin_close(scan->ctx, &v.skin, scale, points);
    pdi_skin_free(scan->ctx, &v.skin);
    return status;
}

#undef PDI_VTU_UNPACKED
