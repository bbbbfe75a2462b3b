/* vtu: see vtu.h */
#include "io/vtu.h"
#include "io/zlib.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Maximum bytes out of one byte of a zlib stream (RFC 1951: 258 bytes for two bits). */
#define PDI_VTU_MAX_INFLATE_RATIO 1032

/* A substring of the file. */
typedef struct pdi_vtu_text {
    const char *begin;
    size_t size;
} pdi_vtu_text;

/* An XML tag: <name attributes> or </name>. */
typedef struct pdi_vtu_xml_tag {
    const char *begin;
    pdi_vtu_text name, attributes;
    int is_closing, is_empty; /* 1: </name>; 1: <name/> */
} pdi_vtu_xml_tag;

/* A <DataArray>: its tag, and the text up to the next tag. */
typedef struct pdi_vtu_array {
    int found;
    pdi_vtu_xml_tag tag;
    const char *body, *end;
} pdi_vtu_array;

/* The data arrays that are read. */
enum {
    PDI_VTU_COORDINATES = 0,
    PDI_VTU_CONNECTIVITY,
    PDI_VTU_OFFSETS,
    PDI_VTU_TYPES,
    PDI_VTU_CELL_REGION,
    PDI_VTU_POINT_REGION,
    PDI_VTU_VOLUME,
    PDI_VTU_ARRAYS
};

/* State of reading a file. */
typedef struct pdi_vtu_reader {
    pdi_tokenizer *tokenizer;
    pd_points_converter cells; /* conversion of cells to points */
    const char *xml_end;        /* end of the XML text: where the appended data begin, or the end of the file */
    const char *appended;   /* first byte of the appended data; NULL: there are none */
    int appended_raw;       /* 1: appended data are raw, 0: base64 */
    int swap_bytes, size_64bit, compressed; /* 1: other byte order; 1: sizes have 8 bytes, 0: 4; 1: zlib blocks */
    int64_t point_count, cell_count;        /* number of points and of cells of the current piece */
    int64_t point_offset;                   /* number of points of the pieces before it */
    pd_boundary_faces faces;               /* faces of the cells */
    int section;            /* 0: none; 'P', 'C', 'c', 'p': Points, Cells, CellData, PointData */
    int region_rank[2];     /* priority of the tag array found so far, of cells and of points; 0: highest */
    pdi_vtu_array array[PDI_VTU_ARRAYS];
    double *value[PDI_VTU_ARRAYS]; /* decoded arrays */
    int64_t length[PDI_VTU_ARRAYS];
} pdi_vtu_reader;

/* ---- tags ---- */

/* Returns 1 when a substring equals a word. */
static int pdi_vtu_is_text(pdi_vtu_text text, const char *word)
{
    return text.size == strlen(word) && memcmp(text.begin, word, text.size) == 0;
}

/* Returns 1 for white space. */
static int pdi_vtu_is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

/* Read the next tag before xml_end and move behind it, skipping comments and declarations. *found 0: there is none.
 * PD_ERR_PARSE: a tag does not end. */
static pd_status pdi_vtu_read_tag(pdi_vtu_reader *v, pdi_vtu_xml_tag *tag, int *found)
{
    pdi_tokenizer *s = v->tokenizer;
    memset(tag, 0, sizeof *tag);
    for (*found = 0;;) {
        while (s->position < v->xml_end && *s->position != '<') s->position++;
        if (s->position >= v->xml_end) return PD_OK;
        tag->begin = s->position++;
        int comment = v->xml_end - s->position > 3 && memcmp(s->position, "!--", 3) == 0;
        char quote = 0;
        for (; s->position < v->xml_end && (quote || comment || *s->position != '>'); s->position++) {
            if (comment && *s->position == '>' && s->position - tag->begin > 5 && s->position[-1] == '-' &&
                s->position[-2] == '-')
                break;
            if (!comment && (*s->position == '"' || *s->position == '\''))
                quote = quote == *s->position ? 0 : quote ? quote : *s->position;
        }
        if (s->position >= v->xml_end) return pdi_tokenizer_fail(s, tag->begin, "a tag that does not end");
        s->position++;
        if (tag->begin[1] != '!' && tag->begin[1] != '?') break;
    }
    const char *at = tag->begin + 1, *end = s->position - 1;
    tag->is_closing = *at == '/';
    at += tag->is_closing;
    tag->is_empty = end > at && end[-1] == '/';
    tag->name.begin = at;
    while (at < end && !pdi_vtu_is_blank(*at) && *at != '/') at++;
    tag->name.size = (size_t)(at - tag->name.begin);
    tag->attributes.begin = at;
    tag->attributes.size = (size_t)(end - at);
    *found = 1;
    return PD_OK;
}

/* Value of an attribute of a tag, as it stands in the file. Returns 1; 0: the tag has none of this name, and *value is
 * unchanged. */
static int pdi_vtu_find_attribute(const pdi_vtu_xml_tag *tag, const char *name, pdi_vtu_text *value)
{
    const char *at = tag->attributes.begin, *end = at + tag->attributes.size;
    while (at < end) {
        pdi_vtu_text key;
        while (at < end && pdi_vtu_is_blank(*at)) at++;
        key.begin = at;
        while (at < end && *at != '=' && !pdi_vtu_is_blank(*at)) at++;
        key.size = (size_t)(at - key.begin);
        while (at < end && *at != '"' && *at != '\'') at++;
        if (at >= end) return 0;
        char quote = *at++;
        const char *begin = at;
        while (at < end && *at != quote) at++;
        if (at >= end) return 0;
        if (pdi_vtu_is_text(key, name)) {
            value->begin = begin;
            value->size = (size_t)(at - begin);
            return 1;
        }
        at++;
    }
    return 0;
}

/* Read an integer attribute from 0 to high; absent: `fallback`, or PD_ERR_PARSE where that is negative. PD_ERR_PARSE:
 * no integer in that range. */
static pd_status pdi_vtu_read_integer(const pdi_vtu_reader *v, const pdi_vtu_xml_tag *tag, const char *name,
                                      int64_t high, int64_t fallback, int64_t *value)
{
    pdi_vtu_text text;
    pdi_tokenizer part = *v->tokenizer;
    *value = fallback;
    if (!pdi_vtu_find_attribute(tag, name, &text)) {
        if (fallback >= 0) return PD_OK;
        return pdi_tokenizer_fail(v->tokenizer, tag->begin, "a tag without %s", name);
    }
    part.position = text.begin;
    part.end = text.begin + text.size;
    return pdi_tokenizer_read_integer(&part, name, 0, high, value);
}

/* ---- data ---- */

/* A stream of bytes, raw or decoded from base64, where padding may stand within. */
typedef struct pdi_vtu_byte_stream {
    const char *position, *end; /* characters still to read */
    int raw, buffered;          /* 1: raw; number of decoded bytes in hold */
    uint8_t buffer[3];          /* decoded bytes in reverse order */
} pdi_vtu_byte_stream;

/* Value 0..63 of a base64 character (RFC 4648), -1 for others. */
static int pdi_vtu_base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *found = c ? strchr(digits, c) : NULL;
    return found ? (int)(found - digits) : -1;
}

/* Decode the next four base64 characters into the empty buffer of the stream. Returns 1; 0: at the end, or they are no
 * base64. */
static int pdi_vtu_decode_base64(pdi_vtu_byte_stream *s)
{
    uint32_t bits = 0;
    int digits = 0, padding = 0;
    for (; digits + padding < 4 && s->position < s->end; s->position++) {
        if (pdi_vtu_is_blank(*s->position)) continue;
        int digit = pdi_vtu_base64_digit(*s->position);
        if (*s->position == '=') padding++;
        else if (digit < 0 || padding) return 0;
        else digits++;
        bits = bits << 6 | (uint32_t)(digit < 0 ? 0 : digit);
    }
    if (digits + padding < 4 || digits < 2) return 0;
    s->buffered = digits - 1;
    for (int k = 0; k < s->buffered; k++) s->buffer[s->buffered - 1 - k] = (uint8_t)(bits >> (16 - 8 * k));
    return 1;
}

/* Read `size` bytes from the stream, decoded. Returns 1; 0: there are fewer, or they are no base64. */
static int pdi_vtu_read_bytes(pdi_vtu_byte_stream *s, uint8_t *out, size_t size)
{
    if (s->raw) {
        if (size > (size_t)(s->end - s->position)) return 0;
        memcpy(out, s->position, size);
        s->position += size;
        return 1;
    }
    for (size_t k = 0; k < size; k++) {
        if (s->buffered == 0 && !pdi_vtu_decode_base64(s)) return 0;
        out[k] = s->buffer[--s->buffered];
    }
    return 1;
}

/* Decode an unsigned integer of `size` bytes in the byte order of the file. */
static uint64_t pdi_vtu_decode_integer(const pdi_vtu_reader *v, const uint8_t *bytes, int size)
{
    const uint16_t probe = 1;
    uint8_t first;
    uint64_t value = 0;
    memcpy(&first, &probe, 1);
    int low_first = (first == 1) != (v->swap_bytes == 1);
    for (int k = 0; k < size; k++) value = value << 8 | bytes[low_first ? size - 1 - k : k];
    return value;
}

/* Read a size, of 4 or 8 bytes as of the header, from the stream. Returns 1; 0: at its end. */
static int pdi_vtu_read_size(const pdi_vtu_reader *v, pdi_vtu_byte_stream *s, uint64_t *size)
{
    uint8_t bytes[8];
    int wide = v->size_64bit ? 8 : 4;
    if (!pdi_vtu_read_bytes(s, bytes, (size_t)wide)) return 0;
    *size = pdi_vtu_decode_integer(v, bytes, wide);
    return 1;
}

/* Inflate the zlib blocks of an array, from their sizes on, into out[size]. *fault: an error text, NULL when all is
 * well; with PD_OK it is set where the data end early or the blocks do not add up to `size`. A damaged block is
 * PD_ERR_PARSE. */
static pd_status pdi_vtu_inflate_blocks(const pdi_vtu_reader *v, pdi_vtu_byte_stream *s, uint8_t *out, size_t size,
                                        const char **fault)
{
    uint64_t blocks, each, last, packed, left = (uint64_t)(s->end - s->position);
    *fault = "blocks of data that do not fit their array";
    if (!pdi_vtu_read_size(v, s, &blocks) || !pdi_vtu_read_size(v, s, &each) || !pdi_vtu_read_size(v, s, &last))
        return PD_OK;
    if (blocks > left / 4 || each > INT32_MAX || last > each) return PD_OK;
    uint64_t whole = blocks ? (blocks - 1) * each + (last ? last : each) : 0;
    if (whole != size) return PD_OK;
    pdi_vtu_byte_stream sizes = *s; /* a second stream reads the sizes again while the blocks are read */
    for (uint64_t b = 0; b < blocks; b++)
        if (!pdi_vtu_read_size(v, s, &packed)) return PD_OK;
    s->buffered = 0;
    for (uint64_t b = 0; b < blocks; b++) {
        uint8_t *bytes = NULL;
        size_t of = (size_t)(b + 1 == blocks && last ? last : each);
        if (!pdi_vtu_read_size(v, &sizes, &packed) || packed > left) return PD_OK;
        PD_TRY(PD_NEW(v->tokenizer->ctx, "vtu", packed, bytes));
        int got = pdi_vtu_read_bytes(s, bytes, (size_t)packed);
        pd_status status = PD_OK;
        if (got)
            status = pdi_zlib_inflate(v->tokenizer->ctx, v->tokenizer->path, bytes, (size_t)packed, out + b * each, of);
        PD_DELETE(v->tokenizer->ctx, packed, bytes);
        if (!got || status != PD_OK) return status;
    }
    *fault = NULL;
    return PD_OK;
}

/* Number types of data arrays. */
typedef enum pdi_vtu_number_type { PDI_VTU_SIGNED = 0, PDI_VTU_UNSIGNED, PDI_VTU_FLOAT } pdi_vtu_number_type;

/* Number type of "Int32", "UInt8", "Float64", ... Returns its size in bytes, 0 for an unknown one. */
static int pdi_vtu_find_number_type(pdi_vtu_text text, pdi_vtu_number_type *type)
{
    static const struct {
        char name[8];
        int size;
        pdi_vtu_number_type type;
    } types[10] = {{"Int8", 1, PDI_VTU_SIGNED},    {"Int16", 2, PDI_VTU_SIGNED},    {"Int32", 4, PDI_VTU_SIGNED},
                   {"Int64", 8, PDI_VTU_SIGNED},   {"UInt8", 1, PDI_VTU_UNSIGNED},  {"UInt16", 2, PDI_VTU_UNSIGNED},
                   {"UInt32", 4, PDI_VTU_UNSIGNED}, {"UInt64", 8, PDI_VTU_UNSIGNED}, {"Float32", 4, PDI_VTU_FLOAT},
                   {"Float64", 8, PDI_VTU_FLOAT}};
    for (int k = 0; k < 10; k++)
        if (pdi_vtu_is_text(text, types[k].name)) {
            *type = types[k].type;
            return types[k].size;
        }
    return 0;
}

/* Decode one number of this type and size. */
static double pdi_vtu_decode_number(const pdi_vtu_reader *v, const uint8_t *bytes, int size, pdi_vtu_number_type type)
{
    uint64_t bits = pdi_vtu_decode_integer(v, bytes, size);
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

/* Set the stream to the start of an array: appended, at its offset, where its format says so, else inline and base64.
 * PD_ERR_PARSE: no offset, no appended data, or beyond them. */
static pd_status pdi_vtu_open_array(const pdi_vtu_reader *v, const pdi_vtu_array *a, pdi_vtu_byte_stream *s)
{
    pdi_vtu_text format;
    int64_t offset;
    memset(s, 0, sizeof *s);
    s->position = a->body;
    s->end = a->end;
    if (!pdi_vtu_find_attribute(&a->tag, "format", &format) || !pdi_vtu_is_text(format, "appended")) return PD_OK;
    PD_TRY(pdi_vtu_read_integer(v, &a->tag, "offset", INT64_C(999999999999999), -1, &offset));
    if (!v->appended || offset > (int64_t)(v->tokenizer->end - v->appended))
        return pdi_tokenizer_fail(v->tokenizer, a->tag.begin, "an array beyond the appended data");
    s->position = v->appended + offset;
    s->end = v->tokenizer->end;
    s->raw = v->appended_raw;
    return PD_OK;
}

/* Decode a binary array of `count` numbers, inline or appended, packed or not, into value[count]. PD_ERR_PARSE: too few
 * or too many bytes, damaged data, or a number whose magnitude is not below 1e100. */
static pd_status pdi_vtu_decode_binary(const pdi_vtu_reader *v, const pdi_vtu_array *a, int64_t count, double *value)
{
    pdi_vtu_text text = {"", 0};
    pdi_vtu_number_type type = PDI_VTU_SIGNED;
    pdi_vtu_byte_stream s;
    const char *fault = NULL;
    uint8_t *bytes = NULL;
    uint64_t given;
    (void)pdi_vtu_find_attribute(&a->tag, "type", &text);
    int each = pdi_vtu_find_number_type(text, &type);
    size_t size = (size_t)count * (size_t)each;
    PD_TRY(pdi_vtu_open_array(v, a, &s));
    PD_TRY(PD_NEW(v->tokenizer->ctx, "vtu", size, bytes));
    pd_status status = PD_OK;
    if (v->compressed) status = pdi_vtu_inflate_blocks(v, &s, bytes, size, &fault);
    else if (!pdi_vtu_read_size(v, &s, &given) || given != size || !pdi_vtu_read_bytes(&s, bytes, size))
        fault = "data that are shorter or longer than their array";
    for (int64_t k = 0; status == PD_OK && !fault && k < count; k++) {
        value[k] = pdi_vtu_decode_number(v, bytes + (size_t)k * (size_t)each, each, type);
        if (!(fabs(value[k]) < 1e100)) fault = "a number that is not finite";
    }
    PD_DELETE(v->tokenizer->ctx, size, bytes);
    return fault && status == PD_OK ? pdi_tokenizer_fail(v->tokenizer, a->tag.begin, "%s", fault) : status;
}

/* Parse a text array of `count` numbers into value[count]. PD_ERR_PARSE: too few or too many, or one not below
 * 1e100. */
static pd_status pdi_vtu_parse_ascii(const pdi_vtu_reader *v, const pdi_vtu_array *a, int64_t count, double *value)
{
    pdi_tokenizer part = *v->tokenizer;
    const char *word;
    part.position = a->body;
    part.end = a->end;
    for (int64_t k = 0; k < count; k++) {
        PD_TRY(pdi_tokenizer_read_number(&part, "a number of an array", &value[k]));
        if (!(fabs(value[k]) < 1e100)) return pdi_tokenizer_fail(&part, part.position, "a number beyond 1e100");
    }
    if (pdi_tokenizer_read_word(&part, &word) == 0) return PD_OK;
    return pdi_tokenizer_fail(&part, word, "an array of more than its %.0f numbers", (double)count);
}

/* Decode the array `which`, of `count` numbers, into new memory, v->value[which], and set its length. what: its name
 * for messages. PD_ERR_PARSE: missing, of an unknown type or format, of another number, or of more numbers than its
 * bytes can hold, which is found before memory is allocated. */
static pd_status pdi_vtu_decode_array(pdi_vtu_reader *v, int which, const char *what, int64_t count)
{
    const pdi_vtu_array *a = &v->array[which];
    pdi_vtu_text format = {"ascii", 5}, text = {"", 0};
    pdi_vtu_number_type type;
    if (!a->found)
        return pdi_tokenizer_fail(v->tokenizer, v->tokenizer->position, "a piece without its array %s", what);
    (void)pdi_vtu_find_attribute(&a->tag, "type", &text);
    int size = pdi_vtu_find_number_type(text, &type);
    if (!size)
        return pdi_tokenizer_fail(v->tokenizer, a->tag.begin, "an array of the type '%.*s', expected Int8 to Float64",
                                  text.size < 20 ? (int)text.size : 20, text.begin);
    (void)pdi_vtu_find_attribute(&a->tag, "format", &format);
    int ascii = pdi_vtu_is_text(format, "ascii"), appended = pdi_vtu_is_text(format, "appended");
    if (!ascii && !appended && !pdi_vtu_is_text(format, "binary"))
        return pdi_tokenizer_fail(v->tokenizer, a->tag.begin, "an array of an unknown format");
    double room = appended ? (double)(v->tokenizer->end - v->tokenizer->text) : (double)(a->end - a->body);
    room = ascii ? 0.5 * room + 1.0 : room * (v->compressed ? PDI_VTU_MAX_INFLATE_RATIO : 1) / size;
    if ((double)count > room)
        return pdi_tokenizer_fail(v->tokenizer, a->tag.begin,
                                  "an array of %.0f numbers, which is more than it can hold", (double)count);
    PD_TRY(PD_NEW(v->tokenizer->ctx, "vtu", count, v->value[which]));
    v->length[which] = count;
    return ascii ? pdi_vtu_parse_ascii(v, a, count, v->value[which])
                 : pdi_vtu_decode_binary(v, a, count, v->value[which]);
}

/* ---- pieces ---- */

/* Cell type of a VTK cell type, and its dimension, -1 when unknown. PD_POINTS_CELL_NONE: not supported. */
static pd_points_cell_type pdi_vtu_find_cell_type(int type, int *dimension)
{
    static const int8_t dimensions[15] = {-1, 0, 0, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3};
    static const int8_t form[15] = {0,
                                    0,
                                    0,
                                    PD_POINTS_CELL_LINE,
                                    0,
                                    PD_POINTS_CELL_TRIANGLE,
                                    0,
                                    0,
                                    PD_POINTS_CELL_QUAD,
                                    PD_POINTS_CELL_QUAD,
                                    PD_POINTS_CELL_TETRAHEDRON,
                                    PD_POINTS_CELL_HEXAHEDRON,
                                    PD_POINTS_CELL_HEXAHEDRON,
                                    PD_POINTS_CELL_WEDGE,
                                    PD_POINTS_CELL_PYRAMID};
    *dimension = type > 0 && type < 15 ? dimensions[type] : -1;
    return type > 0 && type < 15 ? (pd_points_cell_type)form[type] : PD_POINTS_CELL_NONE;
}

/* *tag: region (tag) number k of an array; 0 without the array. PD_ERR_PARSE: it is no whole number of 32 bits. */
static pd_status pdi_vtu_get_region(const pdi_vtu_reader *v, int which, int64_t k, int32_t *tag)
{
    double value = v->value[which] ? v->value[which][k] : 0.0;
    *tag = 0;
    if (!(fabs(value) <= 2147483647.0) || value < floor(value) || value > floor(value))
        return pdi_tokenizer_fail(v->tokenizer, v->array[which].tag.begin,
                                  "the tag %g, expected whole numbers of 32 bits", value);
    *tag = (int32_t)value;
    return PD_OK;
}

/* Add cell k as a point, and its faces; its nodes, `corners` of them, begin at `first` of the connectivity. *count_used
 * is incremented when it has PD_DIM dimensions; one of fewer is skipped. PD_ERR_PARSE: an unknown type, one of more
 * dimensions or not straight, a wrong number of corners, a node or tag that does not exist, or a cell that
 * pd_points_add_cell refuses. */
static pd_status pdi_vtu_add_cell(pdi_vtu_reader *v, int64_t k, int64_t first, int64_t corners, int64_t *count_used)
{
    static const int8_t swapped[8] = {0, 1, 3, 2, 4, 5, 7, 6};
    int64_t number[8];
    const double *corner[8], *node = v->value[PDI_VTU_CONNECTIVITY] + first;
    double type = v->value[PDI_VTU_TYPES][k];
    const char *fault, *at = v->array[PDI_VTU_CONNECTIVITY].tag.begin;
    int dimension, of = type > 0.0 && type < 100.0 ? (int)type : 0;
    pd_points_cell_type form = pdi_vtu_find_cell_type(of, &dimension);
    if (dimension < 0 || dimension > PD_DIM || (dimension == PD_DIM && form == PD_POINTS_CELL_NONE))
        return pdi_tokenizer_fail(v->tokenizer, v->array[PDI_VTU_TYPES].tag.begin,
                                  "cell %.0f is of VTK's type %g, expected straight cells of at most %d dimensions",
                                  (double)k, type, PD_DIM);
    if (dimension < PD_DIM) return PD_OK;
    if (corners != pd_points_count_corners(form))
        return pdi_tokenizer_fail(v->tokenizer, at, "cell %.0f has %.0f corners, expected %d", (double)k,
                                  (double)corners, pd_points_count_corners(form));
    for (int c = 0; c < (int)corners; c++) {
        double id = node[of == 8 || of == 11 ? swapped[c] : c];
        if (!(id >= 0.0) || !(id < (double)v->point_count) || id > floor(id))
            return pdi_tokenizer_fail(v->tokenizer, at, "cell %.0f has the point %g of %.0f", (double)k, id,
                                      (double)v->point_count);
        corner[c] = v->value[PDI_VTU_COORDINATES] + 3 * (int64_t)id;
        number[c] = v->point_offset + (int64_t)id;
    }
    int32_t tag;
    PD_TRY(pdi_vtu_get_region(v, PDI_VTU_CELL_REGION, k, &tag));
    PD_TRY(pd_points_add_cell(v->tokenizer->ctx, &v->cells, form, corner, of == 13, tag, &fault));
    ++*count_used;
    if (fault) return pdi_tokenizer_fail(v->tokenizer, at, "cell %.0f: %s", (double)k, fault);
    return pd_boundary_faces_add_cell(v->tokenizer->ctx, &v->faces, form, number, corner, v->cells.points->count - 1);
}

/* Decode the cells of a piece and add them as points; the orientation that they must share begins anew. *count_used is
 * incremented by the number of those of PD_DIM dimensions. PD_ERR_PARSE: a missing array, offsets that decrease or are
 * not whole, or a cell that is refused. */
static pd_status pdi_vtu_add_cells(pdi_vtu_reader *v, int64_t *count_used)
{
    double last = 0.0;
    PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_TYPES, "types", v->cell_count));
    PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_OFFSETS, "offsets", v->cell_count));
    for (int64_t k = 0; k < v->cell_count; k++) {
        double offset = v->value[PDI_VTU_OFFSETS][k];
        if (!(offset >= last) || offset > floor(offset) || !(offset < 1e15))
            return pdi_tokenizer_fail(v->tokenizer, v->array[PDI_VTU_OFFSETS].tag.begin, "offsets that do not ascend");
        last = offset;
    }
    PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_CONNECTIVITY, "connectivity", (int64_t)last));
    if (v->array[PDI_VTU_CELL_REGION].found)
        PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_CELL_REGION, "of tags", v->cell_count));
    v->cells.orientation = 0.0;
    for (int64_t k = 0, first = 0; k < v->cell_count; k++) {
        int64_t end = (int64_t)v->value[PDI_VTU_OFFSETS][k];
        PD_TRY(pdi_vtu_add_cell(v, k, first, end - first, count_used));
        first = end;
    }
    return PD_OK;
}

/* Add the points of a piece themselves, with their volumes and tags. PD_ERR_PARSE: no volumes, one that is not
 * positive, a coordinate beyond PD_DIM that differs from that of the first point by more than 1e-9 of the extent, or a
 * tag that is no whole number of 32 bits. */
static pd_status pdi_vtu_add_points(pdi_vtu_reader *v)
{
    double scale = 1.0;
    for (int d = 0; d < PD_DIM; d++) scale *= v->cells.scale;
    PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_VOLUME, "volume", v->point_count));
    if (v->array[PDI_VTU_POINT_REGION].found)
        PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_POINT_REGION, "of tags", v->point_count));
    for (int64_t k = 0; k < v->point_count; k++) {
        const double *x = v->value[PDI_VTU_COORDINATES] + 3 * k;
        double position[PD_DIM], volume = v->value[PDI_VTU_VOLUME][k] * scale;
        int32_t tag;
        for (int d = 0; d < PD_DIM; d++) position[d] = x[d] * v->cells.scale;
        for (int d = PD_DIM; d < 3; d++)
            if (fabs(x[d] - v->value[PDI_VTU_COORDINATES][d]) > 1e-9 * v->cells.extent)
                return pdi_tokenizer_fail(v->tokenizer, v->array[PDI_VTU_COORDINATES].tag.begin,
                                          "point %.0f lies off the %dD of the"
                                          " others",
                                          (double)k, PD_DIM);
        if (!(volume > 0.0))
            return pdi_tokenizer_fail(v->tokenizer, v->array[PDI_VTU_VOLUME].tag.begin,
                                      "point %.0f has the volume %g, expected"
                                      " positive ones",
                                      (double)k, v->value[PDI_VTU_VOLUME][k]);
        PD_TRY(pdi_vtu_get_region(v, PDI_VTU_POINT_REGION, k, &tag));
        PD_TRY(pd_points_add(v->tokenizer->ctx, v->cells.points, position, volume, tag));
    }
    return PD_OK;
}

/* Decode the points of a piece whose arrays have been located, update the extent of the mesh (largest distance from the
 * first point along an axis), and add its cells of PD_DIM dimensions, or, where it has none, its points. A piece
 * without points and cells is skipped. begin: its start, for messages. PD_ERR_PARSE: neither such cells nor volumes, or
 * a fault in an array. */
static pd_status pdi_vtu_add_piece(pdi_vtu_reader *v, const char *begin)
{
    int64_t counts = 0, components;
    if (v->point_count == 0 && v->cell_count == 0) return PD_OK;
    if (v->array[PDI_VTU_COORDINATES].found) {
        PD_TRY(pdi_vtu_read_integer(v, &v->array[PDI_VTU_COORDINATES].tag, "NumberOfComponents", 9, 1, &components));
        if (components != 3)
            return pdi_tokenizer_fail(v->tokenizer, v->array[PDI_VTU_COORDINATES].tag.begin,
                                      "points of %.0f"
                                      " coordinates, expected 3",
                                      (double)components);
    }
    PD_TRY(pdi_vtu_decode_array(v, PDI_VTU_COORDINATES, "of points", 3 * v->point_count));
    for (int64_t k = 0; k < 3 * v->point_count; k++)
        v->cells.extent =
            pd_max(v->cells.extent, fabs(v->value[PDI_VTU_COORDINATES][k] - v->value[PDI_VTU_COORDINATES][k % 3]));
    if (v->cell_count) PD_TRY(pdi_vtu_add_cells(v, &counts));
    if (counts) return PD_OK;
    if (v->array[PDI_VTU_VOLUME].found) return pdi_vtu_add_points(v);
    return pdi_tokenizer_fail(v->tokenizer, begin,
                              "a piece without cells of %d dimensions, and without point data 'volume'", PD_DIM);
}

/* Free the decoded arrays of a piece, and forget where its arrays are. */
static void pdi_vtu_free_arrays(pdi_vtu_reader *v)
{
    for (int k = 0; k < PDI_VTU_ARRAYS; k++) {
        PD_DELETE(v->tokenizer->ctx, v->length[k], v->value[k]);
        v->length[k] = 0;
    }
    memset(v->array, 0, sizeof v->array);
    v->region_rank[0] = v->region_rank[1] = 99;
}

/* Which of the known arrays a DataArray tag is, by its section and name; in Points any name counts. -1: none, or a tag
 * array when one of higher priority has been found. Sets the priority of the tags of cells or points. */
static int pdi_vtu_find_array(pdi_vtu_reader *v, const pdi_vtu_xml_tag *tag)
{
    static const char *const tags[] = {"tag", "region", "material", "gmsh:physical"};
    pdi_vtu_text name = {"", 0};
    (void)pdi_vtu_find_attribute(tag, "Name", &name);
    if (v->section == 'P') return PDI_VTU_COORDINATES;
    if (v->section == 'C')
        return pdi_vtu_is_text(name, "connectivity") ? PDI_VTU_CONNECTIVITY
               : pdi_vtu_is_text(name, "offsets")    ? PDI_VTU_OFFSETS
               : pdi_vtu_is_text(name, "types")      ? PDI_VTU_TYPES
                                                     : -1;
    if (v->section == 'p' && pdi_vtu_is_text(name, "volume")) return PDI_VTU_VOLUME;
    for (int k = 0; k < 4; k++)
        if ((v->section == 'c' || v->section == 'p') && pdi_vtu_is_text(name, tags[k])) {
            int *rank = &v->region_rank[v->section == 'p'];
            if (k > *rank) return -1;
            *rank = k;
            return v->section == 'p' ? PDI_VTU_POINT_REGION : PDI_VTU_CELL_REGION;
        }
    return -1;
}

/* Note tag and text of a DataArray that is needed, in place of one of the same kind; others are ignored. The text
 * begins at the position of the tokenizer and ends before the next '<'. */
static void pdi_vtu_set_array(pdi_vtu_reader *v, const pdi_vtu_xml_tag *tag)
{
    int which = pdi_vtu_find_array(v, tag);
    if (which < 0) return;
    pdi_vtu_array *a = &v->array[which];
    a->found = 1;
    a->tag = *tag;
    a->body = v->tokenizer->position;
    a->end = a->body;
    while (!tag->is_empty && a->end < v->xml_end && *a->end != '<') a->end++;
}

/* ---- the file ---- */

/* Take byte order (default: that of the machine), size of headers (8 bytes for UInt64, else 4) and compression from the
 * VTKFile tag. PD_ERR_PARSE: no unstructured grid, or another compressor than zlib. */
static pd_status pdi_vtu_read_header(pdi_vtu_reader *v, const pdi_vtu_xml_tag *tag)
{
    const uint16_t probe = 1;
    uint8_t first;
    pdi_vtu_text text;
    memcpy(&first, &probe, 1);
    if (!pdi_vtu_find_attribute(tag, "type", &text) || !pdi_vtu_is_text(text, "UnstructuredGrid"))
        return pdi_tokenizer_fail(v->tokenizer, tag->begin, "no VTKFile of the type UnstructuredGrid");
    if (pdi_vtu_find_attribute(tag, "byte_order", &text))
        v->swap_bytes = pdi_vtu_is_text(text, "LittleEndian") != (first == 1);
    v->size_64bit = pdi_vtu_find_attribute(tag, "header_type", &text) && pdi_vtu_is_text(text, "UInt64");
    v->compressed = pdi_vtu_find_attribute(tag, "compressor", &text) && text.size > 0;
    if (v->compressed && !pdi_vtu_is_text(text, "vtkZLibDataCompressor"))
        return pdi_tokenizer_fail(v->tokenizer, tag->begin, "data packed by '%.*s', expected vtkZLibDataCompressor",
                                  text.size < 40 ? (int)text.size : 40, text.begin);
    return PD_OK;
}

/* Locate the appended data, which begin behind an underscore, and the end of the XML before them; without such data the
 * XML ends with the file. The tag counts outside of comments and of values alone. The position is at the start of the
 * text afterwards. PD_ERR_PARSE: a tag does not end, or no underscore follows this one. */
static pd_status pdi_vtu_find_appended(pdi_vtu_reader *v)
{
    pdi_vtu_xml_tag tag;
    pdi_vtu_text text;
    int more;
    v->xml_end = v->tokenizer->end;
    v->tokenizer->position = v->tokenizer->text;
    do {
        PD_TRY(pdi_vtu_read_tag(v, &tag, &more));
    } while (more && (tag.is_closing || !pdi_vtu_is_text(tag.name, "AppendedData")));
    const char *at = v->tokenizer->position;
    v->tokenizer->position = v->tokenizer->text;
    if (!more) return PD_OK;
    v->appended_raw = pdi_vtu_find_attribute(&tag, "encoding", &text) && pdi_vtu_is_text(text, "raw");
    while (at < v->tokenizer->end && pdi_vtu_is_blank(*at)) at++;
    if (at >= v->tokenizer->end || *at != '_')
        return pdi_tokenizer_fail(v->tokenizer, tag.begin, "appended data without their mark '_'");
    v->appended = at + 1;
    v->xml_end = tag.begin;
    return PD_OK;
}

/* Section that a tag of this name opens or closes: 'P' Points, 'C' Cells, 'c' CellData, 'p' PointData; 0: none. */
static int pdi_vtu_find_section(pdi_vtu_text name)
{
    return pdi_vtu_is_text(name, "Points")      ? 'P'
           : pdi_vtu_is_text(name, "Cells")     ? 'C'
           : pdi_vtu_is_text(name, "CellData")  ? 'c'
           : pdi_vtu_is_text(name, "PointData") ? 'p'
                                                : 0;
}

/* Handle an opening tag: header, numbers of a piece, array or section; others are ignored, arrays outside a piece, too.
 * *headed 1: VTKFile has been read; *piece: start of the current piece, NULL outside. PD_ERR_PARSE: another tag before
 * VTKFile, a wrong header, a piece without its numbers. */
static pd_status pdi_vtu_begin_tag(pdi_vtu_reader *v, const pdi_vtu_xml_tag *tag, int *headed, const char **piece)
{
    if (pdi_vtu_is_text(tag->name, "VTKFile")) {
        *headed = 1;
        return pdi_vtu_read_header(v, tag);
    }
    if (!*headed) return pdi_tokenizer_fail(v->tokenizer, tag->begin, "no VTKFile");
    if (pdi_vtu_is_text(tag->name, "Piece")) {
        *piece = tag->is_empty ? NULL : tag->begin;
        PD_TRY(pdi_vtu_read_integer(v, tag, "NumberOfPoints", INT32_MAX, -1, &v->point_count));
        return pdi_vtu_read_integer(v, tag, "NumberOfCells", INT32_MAX, -1, &v->cell_count);
    }
    if (pdi_vtu_is_text(tag->name, "DataArray") && *piece) pdi_vtu_set_array(v, tag);
    if (pdi_vtu_find_section(tag->name) && !tag->is_empty) v->section = pdi_vtu_find_section(tag->name);
    return PD_OK;
}

/* Read the file tag by tag up to the end of the grid; a piece is converted, and its arrays freed, at its closing tag.
 * PD_ERR_PARSE: no VTKFile, no </UnstructuredGrid>, or a fault in a tag or piece. */
static pd_status pdi_vtu_read_file(pdi_vtu_reader *v)
{
    int more = 1, headed = 0, ended = 0;
    const char *piece = NULL;
    PD_TRY(pdi_vtu_find_appended(v));
    while (more && !ended) {
        pdi_vtu_xml_tag tag;
        PD_TRY(pdi_vtu_read_tag(v, &tag, &more));
        if (!more) break;
        if (!tag.is_closing) PD_TRY(pdi_vtu_begin_tag(v, &tag, &headed, &piece));
        if (!tag.is_closing) continue;
        ended = pdi_vtu_is_text(tag.name, "UnstructuredGrid");
        if (pdi_vtu_is_text(tag.name, "Piece") && piece) {
            pd_status status = pdi_vtu_add_piece(v, piece);
            v->point_offset += v->point_count;
            v->faces.piece++;
            pdi_vtu_free_arrays(v);
            PD_TRY(status);
            piece = NULL;
        }
        if (pdi_vtu_find_section(tag.name)) v->section = 0;
    }
    if (!headed) return pdi_tokenizer_fail(v->tokenizer, v->tokenizer->text, "no VTKFile");
    return ended ? PD_OK : pdi_tokenizer_fail(v->tokenizer, v->xml_end, "the file ends before </UnstructuredGrid>");
}

PDI_FN pd_status pdi_vtu_read(pdi_tokenizer *scan, double scale, pd_points *points)
{
    pdi_vtu_reader v;
    memset(&v, 0, sizeof v);
    v.tokenizer = scan;
    v.cells.points = points;
    v.cells.scale = scale;
    v.region_rank[0] = v.region_rank[1] = 99;
    pd_status status = pdi_vtu_read_file(&v);
    pdi_vtu_free_arrays(&v);
    if (status == PD_OK) status = pd_boundary_faces_finish(scan->ctx, &v.faces, scale, points);
    pd_boundary_faces_free(scan->ctx, &v.faces);
    return status;
}

#undef PDI_VTU_MAX_INFLATE_RATIO
