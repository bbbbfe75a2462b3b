/* png: see png.h */
#include "io/png.h"
#include "core/par.h"
#include <string.h>

#define PDI_PNG_MAX_FILE ((size_t)256 << 20)
#define PDI_PNG_BLOCK_SIZE 4096 /* [byte] block of a row that is filtered at a time */

/* Filters of rows (PNG 9.2). */
enum { PDI_PNG_NONE, PDI_PNG_SUB, PDI_PNG_UP, PDI_PNG_AVERAGE, PDI_PNG_PAETH, PDI_PNG_FILTERS };

static const uint8_t pdi_png_signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

/* Bytes of all pixels of an image. */
static size_t pdi_png_pixel_bytes(const pd_image *image)
{
    return (size_t)image->width * (size_t)image->height * (size_t)image->channels;
}

void pd_image_free(pd_ctx *ctx, pd_image *image)
{
    PD_DELETE(ctx, pdi_png_pixel_bytes(image), image->pixels);
    memset(image, 0, sizeof *image);
}

PDI_FN int pdi_image_get_luminance(const pd_image *image, int column, int row)
{
    const uint8_t *p = image->pixels + ((size_t)row * (size_t)image->width + (size_t)column) * (size_t)image->channels;
    int luma = image->channels < 3 ? p[0] * 1000 : 299 * p[0] + 587 * p[1] + 114 * p[2];
    if (image->channels % 2) return (luma + 500) / 1000;
    int alpha = p[image->channels - 1];
    return (luma / 1000 * alpha + 127) / 255;
}

/* Paeth predictor of the bytes left, above and above left (PNG 9.4). */
static int pdi_png_paeth(int a, int b, int c)
{
    int pa = b > c ? b - c : c - b, pb = a > c ? a - c : c - a, pc = a + b - 2 * c;
    if (pc < 0) pc = -pc;
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/* Prediction of a filter from the bytes left (a), above (b) and above left (c). */
static inline int pdi_png_predict_from_neighbours(int filter, int a, int b, int c)
{
    switch (filter) {
    case PDI_PNG_SUB: return a;
    case PDI_PNG_UP: return b;
    case PDI_PNG_AVERAGE: return (a + b) / 2;
    case PDI_PNG_PAETH: return pdi_png_paeth(a, b, c);
    default: return 0;
    }
}

/* Prediction of a filter for byte i of a row; `step`: bytes per pixel; above: NULL in the first row. */
static int pdi_png_predict_at(int filter, const uint8_t *row, const uint8_t *above, size_t i, size_t step)
{
    int a = i >= step ? row[i - step] : 0, b = above ? above[i] : 0, c = above && i >= step ? above[i - step] : 0;
    return pdi_png_predict_from_neighbours(filter, a, b, c);
}

/* Writing. */

PDI_FN void pdi_png_put_u32(uint8_t *bytes, uint32_t value)
{
    for (int i = 0; i < 4; i++) bytes[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* out[stride]: row minus its prediction, modulo 256; step: bytes of a pixel; above: zeros for the first row. Inlined
 * for one constant filter, so that the loops are vectorised. */
static inline void pdi_png_compute_residuals(int filter, const uint8_t *PD_RESTRICT row,
                                             const uint8_t *PD_RESTRICT above, size_t stride, size_t step,
                                             uint8_t *PD_RESTRICT out)
{
    for (size_t i = 0; i < step; i++)
        out[i] = (uint8_t)(row[i] - pdi_png_predict_from_neighbours(filter, 0, above[i], 0));
    for (size_t i = step; i < stride; i++)
        out[i] = (uint8_t)(row[i] - pdi_png_predict_from_neighbours(filter, row[i - step], above[i], above[i - step]));
}

/* out[stride]: row minus its prediction for any filter, with one copy of each loop. */
static void pdi_png_apply_filter(int filter, const uint8_t *PD_RESTRICT row, const uint8_t *PD_RESTRICT above,
                                 size_t stride, size_t step, uint8_t *PD_RESTRICT out)
{
    switch (filter) {
    case PDI_PNG_SUB: pdi_png_compute_residuals(PDI_PNG_SUB, row, above, stride, step, out); break;
    case PDI_PNG_UP: pdi_png_compute_residuals(PDI_PNG_UP, row, above, stride, step, out); break;
    case PDI_PNG_AVERAGE: pdi_png_compute_residuals(PDI_PNG_AVERAGE, row, above, stride, step, out); break;
    case PDI_PNG_PAETH: pdi_png_compute_residuals(PDI_PNG_PAETH, row, above, stride, step, out); break;
    default: memcpy(out, row, stride); break;
    }
}

/* Sum of the magnitudes of the residuals of a filter, as signed bytes; 0 for a row of one pixel. */
static uint64_t pdi_png_sum_magnitudes(int filter, const uint8_t *row, const uint8_t *above, size_t stride, size_t step)
{
    uint8_t residual[PDI_PNG_BLOCK_SIZE];
    uint64_t sum = 0;
    size_t count, skip;
    for (size_t at = 0; at + step < stride; at += count) { /* each block begins with the last pixel of the one before */
        count = stride - step - at < PDI_PNG_BLOCK_SIZE - step ? stride - step - at : PDI_PNG_BLOCK_SIZE - step;
        skip = at ? step : 0;
        pdi_png_apply_filter(filter, row + at, above + at, count + step, step, residual);
        uint32_t part = 0;
        for (size_t i = skip; i < count + step; i++) part += residual[i] < 128 ? residual[i] : 256u - residual[i];
        sum += part;
    }
    return sum;
}

/* Filter a row with the filter of the smallest sum of magnitudes (heuristic of PNG 12.8), of equal ones the first; with
 * "up" where it equals the row above, zeros for the first row. out[stride + 1]: the filter, then the residuals. */
static void pdi_png_filter_row(const uint8_t *row, const uint8_t *above, size_t stride, size_t step, uint8_t *out)
{
    uint64_t sum[PDI_PNG_FILTERS];
    out[0] = PDI_PNG_NONE;
    if (memcmp(row, above, stride) == 0) { /* true for most rows of a field drawn cell by cell */
        out[0] = PDI_PNG_UP;
        memset(out + 1, 0, stride);
        return;
    }
    for (int filter = 0; filter < PDI_PNG_FILTERS; filter++)
        sum[filter] = pdi_png_sum_magnitudes(filter, row, above, stride, step);
    for (int filter = 1; filter < PDI_PNG_FILTERS; filter++)
        if (sum[filter] < sum[out[0]]) out[0] = (uint8_t)filter;
    pdi_png_apply_filter(out[0], row, above, stride, step, out + 1);
}

/* Set length and type before the data of a chunk, and the CRC of type and data behind them. */
static void pdi_png_init_chunk_ends(const char *type, const uint8_t *data, size_t size, uint8_t head[8],
                                    uint8_t tail[4])
{
    pdi_png_put_u32(head, (uint32_t)size);
    memcpy(head + 4, type, 4);
    uint32_t crc = pdi_zlib_crc32(0, head + 4, 4);
    pdi_png_put_u32(tail, size ? pdi_zlib_crc32(crc, data, size) : crc);
}

PDI_FN pd_status pdi_png_write_chunk(pd_ctx *ctx, pd_file *file, const char *type, const uint8_t *data, size_t size)
{
    uint8_t head[8], tail[4];
    pdi_png_init_chunk_ends(type, data, size, head, tail);
    PD_TRY(pdi_file_write(ctx, file, head, sizeof head));
    if (size) PD_TRY(pdi_file_write(ctx, file, data, size));
    return pdi_file_write(ctx, file, tail, sizeof tail);
}

/* Content of the IHDR chunk of an image: 8 bits a channel, RGB for 3 channels, else grey, not interlaced. */
static void pdi_png_init_header(const pd_image *image, uint8_t header[13])
{
    memset(header, 0, 13);
    pdi_png_put_u32(header, (uint32_t)image->width);
    pdi_png_put_u32(header + 4, (uint32_t)image->height);
    header[8] = 8;
    header[9] = image->channels == 3 ? 2 : 0;
}

PDI_FN pd_status pdi_png_write_header(pd_ctx *ctx, pd_file *file, const pd_image *image)
{
    uint8_t header[13];
    pdi_png_init_header(image, header);
    PD_TRY(pdi_file_write(ctx, file, pdi_png_signature, sizeof pdi_png_signature));
    return pdi_png_write_chunk(ctx, file, "IHDR", header, sizeof header);
}

/* Write a PNG file of compressed pixels through a temporary file, deleted on failure; the image gives size and channels
 * alone. */
static pd_status pdi_png_write_file(pd_ctx *ctx, const char *path, const pd_image *image, const pdi_bytes *packed)
{
    pd_file file;
    PD_TRY(pdi_file_create(ctx, path, &file));
    pd_status status = pdi_png_write_header(ctx, &file, image);
    if (status == PD_OK) status = pdi_png_write_chunk(ctx, &file, "IDAT", packed->data, packed->size);
    if (status == PD_OK) status = pdi_png_write_chunk(ctx, &file, "IEND", NULL, 0);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

PDI_FN pd_status pdi_png_check_image(pd_ctx *ctx, const pd_image *image)
{
    if (!image->pixels || image->width < 1 || image->height < 1)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "png", "an image of %d x %d pixels cannot be written", image->width,
                       image->height);
    if (image->channels != 1 && image->channels != 3)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "png", "%d channels, expected 1 (gray) or 3 (RGB)", image->channels);
    if (image->width > PD_PNG_MAX_PIXELS / image->height)
        return pd_fail(ctx, PD_ERR_SIZE, "png", "%d x %d pixels, at most %d in all are possible", image->width,
                       image->height, PD_PNG_MAX_PIXELS);
    return PD_OK;
}

PDI_FN pd_status pdi_png_compress_pixels(pd_ctx *ctx, const pd_image *image, pdi_bytes *packed)
{
    size_t step = (size_t)image->channels, stride = (size_t)image->width * step, rows = (size_t)image->height;
    size_t size = (rows + 1) * (stride + 1);
    int nt = pd_par_threads(ctx, (int64_t)(size / 4));
    (void)nt;
    uint8_t *filtered = NULL;
    PD_TRY(PD_NEW(ctx, "png", size, filtered));
    const uint8_t *zeros = filtered + rows * (stride + 1);
    PD_PARALLEL_FOR(nt)
    for (int r = 0; r < image->height; r++) {
        const uint8_t *row = image->pixels + (size_t)r * stride;
        pdi_png_filter_row(row, r ? row - stride : zeros, stride, step, filtered + (size_t)r * (stride + 1));
    }
    pd_status status = pdi_zlib_deflate(ctx, filtered, rows * (stride + 1), packed);
    PD_DELETE(ctx, size, filtered);
    return status;
}

pd_status pd_png_write(pd_ctx *ctx, const char *path, const pd_image *image)
{
    pdi_bytes packed = {NULL, 0, 0};
    PD_TRY(pdi_png_check_image(ctx, image));
    pd_status status = pdi_png_compress_pixels(ctx, image, &packed);
    if (status == PD_OK) status = pdi_png_write_file(ctx, path, image, &packed);
    pdi_bytes_free(ctx, &packed);
    return status;
}

/* Append a chunk to a buffer. */
static pd_status pdi_png_add_chunk(pd_ctx *ctx, pdi_bytes *out, const char *type, const uint8_t *data, size_t size)
{
    uint8_t head[8], tail[4];
    pdi_png_init_chunk_ends(type, data, size, head, tail);
    PD_TRY(pdi_bytes_add(ctx, out, head, sizeof head));
    if (size) PD_TRY(pdi_bytes_add(ctx, out, data, size));
    return pdi_bytes_add(ctx, out, tail, sizeof tail);
}

PDI_FN pd_status pdi_png_encode(pd_ctx *ctx, const pd_image *image, pdi_bytes *out)
{
    uint8_t header[13];
    pdi_bytes packed = {NULL, 0, 0};
    PD_TRY(pdi_png_check_image(ctx, image));
    pdi_png_init_header(image, header);
    PD_TRY(pdi_bytes_add(ctx, out, pdi_png_signature, sizeof pdi_png_signature));
    PD_TRY(pdi_png_add_chunk(ctx, out, "IHDR", header, sizeof header));
    pd_status status = pdi_png_compress_pixels(ctx, image, &packed);
    if (status == PD_OK) status = pdi_png_add_chunk(ctx, out, "IDAT", packed.data, packed.size);
    pdi_bytes_free(ctx, &packed);
    return status == PD_OK ? pdi_png_add_chunk(ctx, out, "IEND", NULL, 0) : status;
}

/* Reading. */

/* A PNG file while it is read. */
typedef struct pdi_png_reader {
    const char *path;
    int width, height, depth, colour; /* as in IHDR */
    int samples;                      /* number of samples per pixel */
    uint8_t palette[256 * 3], alpha[256];
    int palette_count, alpha_count;
    int has_key;                      /* 1: grey or RGB pixels with the samples of key are transparent */
    uint32_t transparent_key[3];
    pdi_bytes compressed;             /* data of all IDAT chunks */
    int ended;                        /* 1: IEND has been read */
} pdi_png_reader;

PDI_COLD_BEGIN
/* Read a big-endian number of four bytes. */
static uint32_t pdi_png_get_u32(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Report a damaged or unsupported file as PD_ERR_PARSE. */
static pd_status pdi_png_fail(pd_ctx *ctx, const pdi_png_reader *png, const char *text)
{
    return pd_fail(ctx, PD_ERR_PARSE, "png", "%s: %s", png->path, text);
}

/* Take size, depth and colour type from the IHDR chunk. PD_ERR_PARSE: a second one, a wrong length, no pixels or more
 * than PD_PNG_MAX_PIXELS, an unknown colour type, compression or filter, a depth other than 8 bits (grey and palette:
 * or 1, 2, 4), or interlacing. */
static pd_status pdi_png_parse_header(pd_ctx *ctx, pdi_png_reader *png, const uint8_t *data, size_t size)
{
    if (png->width) return pdi_png_fail(ctx, png, "a second IHDR chunk");
    if (size != 13) return pdi_png_fail(ctx, png, "an IHDR chunk of the wrong length");
    uint32_t width = pdi_png_get_u32(data), height = pdi_png_get_u32(data + 4);
    if (width == 0 || height == 0) return pdi_png_fail(ctx, png, "the image has no pixels");
    if (width > PD_PNG_MAX_PIXELS || height > PD_PNG_MAX_PIXELS / width)
        return pd_fail(ctx, PD_ERR_PARSE, "png", "%s: %.0f x %.0f pixels, at most %d in all are read", png->path,
                       (double)width, (double)height, PD_PNG_MAX_PIXELS);
    png->width = (int)width;
    png->height = (int)height;
    png->depth = data[8];
    png->colour = data[9];
    switch (png->colour) {
    case 0: case 3: png->samples = 1; break;
    case 2: png->samples = 3; break;
    case 4: png->samples = 2; break;
    case 6: png->samples = 4; break;
    default: return pd_fail(ctx, PD_ERR_PARSE, "png", "%s: colour type %d does not exist", png->path, png->colour);
    }
    int small = png->depth == 1 || png->depth == 2 || png->depth == 4;
    if (png->depth != 8 && !(small && png->samples == 1))
        return pd_fail(ctx, PD_ERR_PARSE, "png", "%s: %d bits a channel, expected 8 (or 1, 2, 4 for gray and palette)",
                       png->path, png->depth);
    if (data[10] || data[11]) return pdi_png_fail(ctx, png, "an unknown compression or filter method");
    if (data[12]) return pdi_png_fail(ctx, png, "the image is interlaced, expected one without interlacing");
    return PD_OK;
}

/* Take one chunk into the reader: IHDR, PLTE, tRNS (of grey, RGB and palette), IDAT (its data are appended) or IEND;
 * others are ignored. PD_ERR_PARSE: another chunk before IHDR, a wrong length, or an unknown chunk that is critical (a
 * capital first letter). */
static pd_status pdi_png_parse_chunk(pd_ctx *ctx, pdi_png_reader *png, const uint8_t *type, const uint8_t *data,
                                     size_t size)
{
    if (!png->width && memcmp(type, "IHDR", 4) != 0) return pdi_png_fail(ctx, png, "the first chunk is not IHDR");
    if (memcmp(type, "IHDR", 4) == 0) return pdi_png_parse_header(ctx, png, data, size);
    if (memcmp(type, "IDAT", 4) == 0) return pdi_bytes_add(ctx, &png->compressed, data, size);
    if (memcmp(type, "IEND", 4) == 0) {
        png->ended = 1;
        return PD_OK;
    }
    if (memcmp(type, "PLTE", 4) == 0) {
        if (size == 0 || size > sizeof png->palette || size % 3)
            return pdi_png_fail(ctx, png, "a palette of the wrong length");
        memcpy(png->palette, data, size);
        png->palette_count = (int)(size / 3);
        return PD_OK;
    }
    if (memcmp(type, "tRNS", 4) == 0 && png->colour == 3) {
        if (size > sizeof png->alpha) return pdi_png_fail(ctx, png, "a transparency chunk that is too long");
        memcpy(png->alpha, data, size);
        png->alpha_count = (int)size;
        return PD_OK;
    }
    if (memcmp(type, "tRNS", 4) == 0 && (png->colour == 0 || png->colour == 2)) {
        if (size != 2 * (size_t)png->samples) return pdi_png_fail(ctx, png, "a transparency chunk of the wrong length");
        for (int c = 0; c < png->samples; c++) png->transparent_key[c] = (uint32_t)data[2 * c] << 8 | data[2 * c + 1];
        png->has_key = 1;
        return PD_OK;
    }
    /* Bit 5 of the first letter is clear in chunks that must be understood. */
    if (!(type[0] & 32)) return pdi_png_fail(ctx, png, "an unknown chunk that must be understood");
    return PD_OK;
}

/* Take all chunks of a file data[size] into the reader and verify their CRC. PD_ERR_PARSE: no PNG file, cut off,
 * damaged, or without pixels or palette. */
static pd_status pdi_png_parse_chunks(pd_ctx *ctx, pdi_png_reader *png, const uint8_t *data, size_t size)
{
    size_t at = sizeof pdi_png_signature;
    memset(png->alpha, 255, sizeof png->alpha);
    if (size < at || memcmp(data, pdi_png_signature, at) != 0) return pdi_png_fail(ctx, png, "not a PNG file");
    while (!png->ended) {
        if (size - at < 12) return pdi_png_fail(ctx, png, "the file ends early");
        size_t length = pdi_png_get_u32(data + at);
        if (length > size - at - 12) return pdi_png_fail(ctx, png, "the file ends early");
        if (pdi_zlib_crc32(0, data + at + 4, length + 4) != pdi_png_get_u32(data + at + 8 + length))
            return pdi_png_fail(ctx, png, "a chunk has a wrong checksum");
        PD_TRY(pdi_png_parse_chunk(ctx, png, data + at + 4, data + at + 8, length));
        at += 12 + length;
    }
    if (!png->compressed.size) return pdi_png_fail(ctx, png, "no image data");
    if (png->colour == 3 && !png->palette_count) return pdi_png_fail(ctx, png, "the palette is missing");
    return PD_OK;
}

/* Undo the filters of all rows raw[height][1 + stride] in place; step: bytes per pixel. PD_ERR_PARSE: an unknown
 * filter. */
static pd_status pdi_png_unfilter(pd_ctx *ctx, const pdi_png_reader *png, uint8_t *raw, size_t stride, size_t step)
{
    for (int r = 0; r < png->height; r++) {
        uint8_t *row = raw + (size_t)r * (stride + 1) + 1;
        const uint8_t *above = r ? row - (stride + 1) : NULL;
        int filter = row[-1];
        if (filter >= PDI_PNG_FILTERS) return pdi_png_fail(ctx, png, "a row with an unknown filter");
        if (filter == PDI_PNG_NONE) continue;
        for (size_t i = 0; i < stride; i++)
            row[i] = (uint8_t)(row[i] + pdi_png_predict_at(filter, row, above, i, step));
    }
    return PD_OK;
}

/* Sample of 1, 2, 4 or 8 bits in a row of single samples, not scaled. */
static int pdi_png_get_sample(const pdi_png_reader *png, const uint8_t *row, size_t column)
{
    size_t bit = column * (size_t)png->depth;
    int mask = (1 << png->depth) - 1;
    return (row[bit / 8] >> (8 - png->depth - (int)(bit % 8))) & mask;
}

/* Alpha of a pixel sample[samples]: 0 where its samples equal the transparent key, else 255. */
static uint8_t pdi_png_key_alpha(const pdi_png_reader *png, const uint8_t *sample)
{
    for (int c = 0; c < png->samples; c++)
        if (sample[c] != png->transparent_key[c]) return 255;
    return 0;
}

/* Convert unfiltered rows raw[height][1 + stride] to the pixels of the image: palette to RGB, grey to 8 bits,
 * transparency to alpha. PD_ERR_PARSE: an index beyond the palette. */
static pd_status pdi_png_expand_pixels(pd_ctx *ctx, const pdi_png_reader *png, const uint8_t *raw, size_t stride,
                                       pd_image *image)
{
    size_t channels = (size_t)image->channels, width = (size_t)png->width;
    for (int r = 0; r < png->height; r++) {
        const uint8_t *row = raw + (size_t)r * (stride + 1) + 1;
        uint8_t *out = image->pixels + (size_t)r * width * channels;
        if (png->samples > 1 && !png->has_key) {
            memcpy(out, row, stride);
            continue;
        }
        for (size_t c = 0; c < width; c++, out += channels) {
            if (png->samples > 1) {
                memcpy(out, row + 3 * c, 3);
                out[3] = pdi_png_key_alpha(png, out);
                continue;
            }
            int value = pdi_png_get_sample(png, row, c);
            if (png->colour == 0) { /* gray is spread over 0..255 */
                uint8_t sample = (uint8_t)value;
                out[0] = (uint8_t)(value * 255 / ((1 << png->depth) - 1));
                if (png->has_key) out[1] = pdi_png_key_alpha(png, &sample);
                continue;
            }
            if (value >= png->palette_count) return pdi_png_fail(ctx, png, "a pixel beyond the palette");
            memcpy(out, png->palette + 3 * value, 3);
            if (channels == 4) out[3] = png->alpha[value];
        }
    }
    return PD_OK;
}

/* Decompress, unfilter and convert the pixels into a new image; nothing stays on failure. PD_ERR_PARSE: fewer
 * compressed bytes than 1/1032 of the pixels, which is found before memory is allocated, damaged data, or an index
 * beyond the palette. */
static pd_status pdi_png_decode_pixels(pd_ctx *ctx, const pdi_png_reader *png, pd_image *image)
{
    size_t bits = (size_t)png->samples * (size_t)png->depth;
    size_t stride = ((size_t)png->width * bits + 7) / 8, step = bits < 8 ? 1 : bits / 8;
    size_t size = (size_t)png->height * (stride + 1);
    uint8_t *raw = NULL;
    /* Deflate compresses at most 1032 to 1: a small file that claims a huge image is refused before allocation. */
    if (size / 1032 > png->compressed.size) return pdi_png_fail(ctx, png, "too few data for this number of pixels");
    PD_TRY(PD_NEW(ctx, "png", size, raw));
    pd_status status = pdi_zlib_inflate(ctx, png->path, png->compressed.data, png->compressed.size, raw, size);
    if (status == PD_OK) status = pdi_png_unfilter(ctx, png, raw, stride, step);
    if (status == PD_OK) {
        image->channels = png->colour == 3 ? (png->alpha_count ? 4 : 3) : png->samples + png->has_key;
        image->width = png->width;
        image->height = png->height;
        status = PD_NEW(ctx, "png", pdi_png_pixel_bytes(image), image->pixels);
        if (status == PD_OK) status = pdi_png_expand_pixels(ctx, png, raw, stride, image);
        if (status != PD_OK) pd_image_free(ctx, image);
    }
    PD_DELETE(ctx, size, raw);
    return status;
}

pd_status pd_png_read(pd_ctx *ctx, const char *path, pd_image *image)
{
    char *data = NULL;
    size_t size = 0;
    pdi_png_reader png;
    memset(&png, 0, sizeof png);
    memset(image, 0, sizeof *image);
    png.path = path;
    PD_TRY(pdi_file_read_all(ctx, path, PDI_PNG_MAX_FILE, &data, &size));
    pd_status status = pdi_png_parse_chunks(ctx, &png, (const uint8_t *)data, size);
    if (status == PD_OK) status = pdi_png_decode_pixels(ctx, &png, image);
    pdi_bytes_free(ctx, &png.compressed);
    PD_DELETE(ctx, size + 1, data);
    return status;
}
PDI_COLD_END
