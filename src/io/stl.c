/* stl: see stl.h */
#include "io/stl.h"
#include "io/file.h"
#include <math.h>
#include <string.h>

/* Largest STL file that is read. */
#define PDI_STL_MAX_SIZE 2147483648
/* [byte] length of the header of a binary file, and of each of its triangles. */
#define PDI_STL_HEADER_SIZE 84
#define PDI_STL_TRIANGLE_SIZE 50

/* Triangles read so far. */
typedef struct pdi_stl_triangles {
    double *x;             /* [room][9] [m] three corners each */
    int64_t count, capacity; /* number of triangles, and capacity */
    double scale, shift[3]; /* [-], [m] transformation from the file */
} pdi_stl_triangles;

/* Read a 32-bit little-endian integer. */
static uint32_t pdi_stl_get_u32(const char *bytes)
{
    const unsigned char *byte = (const unsigned char *)bytes;
    return (uint32_t)byte[0] | (uint32_t)byte[1] << 8 | (uint32_t)byte[2] << 16 | (uint32_t)byte[3] << 24;
}

/* Set the capacity for triangles. */
static pd_status pdi_stl_reserve(pd_ctx *ctx, pdi_stl_triangles *c, int64_t capacity)
{
    PD_TRY(PD_GROW(ctx, "stl", c->capacity * 9, capacity * 9, c->x));
    c->capacity = capacity;
    return PD_OK;
}

/* Coordinate [m] along an axis of a number of the file. */
static double pdi_stl_transform(const pdi_stl_triangles *c, double x, int axis)
{
    return x * c->scale + c->shift[axis];
}

/* Take `count` binary triangles from a whole file that holds them: normal, three corners and two bytes each, numbers
 * little-endian. Sets the count. */
static pd_status pdi_stl_parse_binary(pd_ctx *ctx, const char *text, uint32_t count, pdi_stl_triangles *c)
{
    PD_TRY(pdi_stl_reserve(ctx, c, count));
    for (uint32_t k = 0; k < count; k++)
        for (int n = 0; n < 9; n++) {
            uint32_t bits =
                pdi_stl_get_u32(text + PDI_STL_HEADER_SIZE + (size_t)PDI_STL_TRIANGLE_SIZE * k + 12 + 4 * n);
            float value;
            memcpy(&value, &bits, sizeof value);
            c->x[9 * (int64_t)k + n] = pdi_stl_transform(c, (double)value, n % 3);
        }
    c->count = count;
    return PD_OK;
}

/* Read a triangle as text behind its word facet: normal N N N outer loop vertex X Y Z (three times) endloop endfacet.
 * The words of the normal are not looked at. PD_ERR_PARSE: another word, a coordinate that is no finite number. */
static pd_status pdi_stl_parse_facet(pdi_tokenizer *s, pdi_stl_triangles *c)
{
    const char *word;
    double value;
    if (c->count == c->capacity) PD_TRY(pdi_stl_reserve(s->ctx, c, 2 * c->capacity + 64));
    PD_TRY(pdi_tokenizer_expect_word(s, "normal"));
    for (int d = 0; d < 3; d++) (void)pdi_tokenizer_read_word(s, &word);
    PD_TRY(pdi_tokenizer_expect_word(s, "outer"));
    PD_TRY(pdi_tokenizer_expect_word(s, "loop"));
    for (int p = 0; p < 3; p++) {
        PD_TRY(pdi_tokenizer_expect_word(s, "vertex"));
        for (int d = 0; d < 3; d++) {
            PD_TRY(pdi_tokenizer_read_number(s, "a coordinate", &value));
            c->x[9 * c->count + 3 * p + d] = pdi_stl_transform(c, value, d);
        }
    }
    PD_TRY(pdi_tokenizer_expect_word(s, "endloop"));
    PD_TRY(pdi_tokenizer_expect_word(s, "endfacet"));
    c->count++;
    return PD_OK;
}

/* Returns 1 when nothing but padding (white space, 0, control-Z) stands between begin and end, else 0. */
static int pdi_stl_is_padding(const char *begin, const char *end)
{
    while (begin < end && (*begin == '\0' || *begin == '\x1A' || *begin == ' ' || *begin == '\t' || *begin == '\r' ||
                           *begin == '\n'))
        begin++;
    return begin == end;
}

/* Read a text file, case ignored: solid NAME .. endsolid NAME, once or more often, then padding or the end; names are
 * not compared. PD_ERR_PARSE: another word, or the end before endsolid. A solid without triangles is no error here. */
static pd_status pdi_stl_parse_text(pdi_tokenizer *s, pdi_stl_triangles *c)
{
    const char *word;
    int open = 0;
    s->ignore_case = 1;
    for (size_t size; (size = pdi_tokenizer_read_word(s, &word)) > 0;) {
        if (!open && pdi_stl_is_padding(word, s->end)) break;
        if (!open && pdi_tokenizer_is_word(s, word, size, "solid")) open = 1;
        else if (open && pdi_tokenizer_is_word(s, word, size, "endsolid")) open = 0;
        else if (open && pdi_tokenizer_is_word(s, word, size, "facet")) {
            PD_TRY(pdi_stl_parse_facet(s, c));
            continue;
        } else
            return pdi_tokenizer_fail(s, word, "found '%.*s', expected %s", size < 40 ? (int)size : 40, word,
                                      open ? "facet or endsolid" : "solid");
        pdi_tokenizer_skip_line(s); /* the name */
    }
    return open ? pdi_tokenizer_fail(s, s->end, "the file ends before endsolid") : PD_OK;
}

/* Take the triangles of a file: binary where its number of triangles, at byte 80, is not 0 and its size is at least
 * what they need, other bytes behind them ignored; else text where its first word is solid. PD_ERR_PARSE: neither, or a
 * fault in the text. */
static pd_status pdi_stl_parse(pd_ctx *ctx, const char *path, const char *text, size_t size, pdi_stl_triangles *c)
{
    double count = size >= PDI_STL_HEADER_SIZE ? (double)pdi_stl_get_u32(text + PDI_STL_HEADER_SIZE - 4) : -1.0;
    double whole = PDI_STL_HEADER_SIZE + PDI_STL_TRIANGLE_SIZE * count;
    /* text at this position gives a count beyond any file size; other bytes may follow the last triangle */
    if (count > 0.0 && (double)size >= whole) return pdi_stl_parse_binary(ctx, text, (uint32_t)count, c);
    pdi_tokenizer scan = pdi_tokenizer_init(ctx, "stl", path, text, size), first = scan;
    const char *word;
    first.ignore_case = 1;
    size_t length = pdi_tokenizer_read_word(&first, &word);
    if (pdi_tokenizer_is_word(&first, word, length, "solid")) return pdi_stl_parse_text(&scan, c);
    return pd_fail(ctx, PD_ERR_PARSE, "stl",
                   "%.250s: %.0f bytes, which do not begin with 'solid', and are no binary "
                   "file of %.0f triangles, whose size is %.0f: no STL file, or cut off",
                   path, (double)size, pd_max(count, 0.0), pd_max(whole, PDI_STL_HEADER_SIZE));
}

pd_status pd_facets_read(pd_ctx *ctx, const char *path, double scale, const double *shift, pd_facets *facets)
{
    char *text;
    size_t size;
    pdi_stl_triangles c;
    memset(facets, 0, sizeof *facets);
    memset(&c, 0, sizeof c);
    if (!(scale > 0.0) || !(scale < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "stl", "the scale %g, expected a positive one", scale);
    c.scale = scale;
    for (int d = 0; shift && d < 3; d++) c.shift[d] = shift[d];
    PD_TRY(pdi_file_read_all(ctx, path, (size_t)PDI_STL_MAX_SIZE, &text, &size));
    pd_status status = pdi_stl_parse(ctx, path, text, size, &c);
    PD_DELETE(ctx, size + 1, text);
    if (status == PD_OK) status = pd_facets_build(ctx, c.x, c.count, facets);
    PD_DELETE(ctx, c.capacity * 9, c.x);
    return status;
}

#undef PDI_STL_MAX_SIZE
#undef PDI_STL_HEADER_SIZE
#undef PDI_STL_TRIANGLE_SIZE
