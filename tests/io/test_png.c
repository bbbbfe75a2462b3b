/* png: deflate and inflate against streams of zlib, images there and back, damaged files. */
/* dims: 2 */
#include "io/png.h"
#include "io/zlib.h"
#include "io/file.h"
#include "scene/scene.h"
#include "fault.h"

#define DIRECTORY "build/files_of_test_png"

static void start(pd_ctx *ctx)
{
    pd_ctx_init(ctx);
    CHECK_OK(ctx, pd_file_make_directory(ctx, DIRECTORY));
}

/* Deterministic bytes; the sizes below were found with zlib 1.2 for the same bytes. */
static void generate(int kind, uint8_t *out, int n)
{
    uint32_t x = 12345;
    for (int i = 0; i < n; i++) {
        x = (x * 1103515245u + 12345u) & 0x7fffffffu;
        if (kind == 0) out[i] = (uint8_t)(x >> 16);
        else if (kind == 1) out[i] = (uint8_t)(i / 7 * (i / 1000));
        else out[i] = (uint8_t)((x >> 16 & 3) * (uint32_t)(i >> 8 & 1) + (uint32_t)(i / 300 % 5));
    }
}

TEST(checksums_have_their_published_values)
{
    const uint8_t digits[] = "123456789", name[] = "Wikipedia";
    CHECK_INT(pdi_zlib_crc32(0, digits, 9), 0xCBF43926);
    CHECK_INT(pdi_zlib_crc32(pdi_zlib_crc32(0, digits, 4), digits + 4, 5), 0xCBF43926);
    CHECK_INT(pdi_zlib_adler32(name, 9), 0x11E60398);
    CHECK_INT(pdi_zlib_adler32(name, 0), 1);
}

/* "peridynamic corrosion, peridynamic corrosion" by zlib with fixed codes. */
static const uint8_t fixed_stream[] = {0x78, 0x01, 0x2B, 0x48, 0x2D, 0xCA, 0x4C, 0xA9, 0xCC, 0x4B, 0xCC, 0xCD,
                                       0x4C, 0x56, 0x48, 0xCE, 0x2F, 0x2A, 0xCA, 0x2F, 0xCE, 0xCC, 0xCF, 0xD3,
                                       0x51, 0x28, 0xC0, 0x26, 0x0C, 0x00, 0x88, 0x46, 0x11, 0x73};

TEST(a_stream_of_zlib_is_unpacked)
{
    static const char text[] = "peridynamic corrosion, peridynamic corrosion";
    uint8_t out[64];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pdi_zlib_inflate(&ctx, "here", fixed_stream, sizeof fixed_stream, out, 44));
    CHECK(memcmp(out, text, 44) == 0);
    CHECK_INT(pdi_zlib_inflate(&ctx, "here", fixed_stream, sizeof fixed_stream, out, 43), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "here: damaged compressed data (more data") != NULL);
    CHECK_INT(pdi_zlib_inflate(&ctx, "here", fixed_stream, sizeof fixed_stream, out, 45), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "less data") != NULL);
    for (size_t n = 0; n < sizeof fixed_stream; n++) {
        CHECK_INT(pdi_zlib_inflate(&ctx, "here", fixed_stream, n, out, 44), PD_ERR_PARSE);
        CHECK(strstr(ctx.message, "end early") != NULL);
    }
}

TEST(packed_data_come_back_and_are_as_small_as_those_of_zlib)
{
    enum { N = 200000 };
    static uint8_t data[N], back[N];
    static const double zlib_size[3] = {200071, 39476, 39350}; /* level 6 */
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int kind = 0; kind < 3; kind++)
        for (int n = 0; n <= N; n = n < 20 ? n + 1 : n * 10) {
            pdi_bytes packed = {NULL, 0, 0};
            generate(kind, data, n);
            if (!CHECK_OK(&ctx, pdi_zlib_deflate(&ctx, data, (size_t)n, &packed))) return;
            if (!CHECK_OK(&ctx, pdi_zlib_inflate(&ctx, "here", packed.data, packed.size, back, (size_t)n))) return;
            CHECK(memcmp(data, back, (size_t)n) == 0);
            if (n == N) CHECK_LE((double)packed.size, zlib_size[kind] * 1.01);
            pdi_bytes_free(&ctx, &packed);
        }
    pdi_bytes packed = {NULL, 0, 0};
    memset(data, 7, N);
    CHECK_OK(&ctx, pdi_zlib_deflate(&ctx, data, N, &packed));
    CHECK_LE((double)packed.size, N / 800.0); /* the format reaches 1032 to 1 at best */
    pdi_bytes_free(&ctx, &packed);
    CHECK_INT(ctx.in_use, 0);
}

/* Pieces of 262144 bytes are packed side by side: the same stream for any number of threads. */
TEST(pieces_of_a_stream_come_back_whatever_the_threads)
{
    enum { PIECE = 262144, N = 3 * PIECE + 1 };
    static const int sizes[] = {PIECE - 1, PIECE, PIECE + 1, 2 * PIECE, N};
    static uint8_t data[N], back[N];
    for (int kind = 0; kind < 4; kind++) {
        if (kind < 3) generate(kind, data, N);
        else memset(data, 7, N);
        for (int k = 0; k < 5; k++) {
            pdi_bytes one = {NULL, 0, 0}, more = {NULL, 0, 0};
            pd_ctx ctx;
            size_t size = (size_t)sizes[k];
            pd_ctx_init(&ctx);
            ctx.threads = 1;
            if (!CHECK_OK(&ctx, pdi_zlib_deflate(&ctx, data, size, &one))) return;
            if (!CHECK_OK(&ctx, pdi_zlib_inflate(&ctx, "here", one.data, one.size, back, size))) return;
            CHECK(memcmp(data, back, size) == 0);
            CHECK_LE((double)one.size, (double)size * 1.001);
            ctx.threads = 3;
            if (!CHECK_OK(&ctx, pdi_zlib_deflate(&ctx, data, size, &more))) return;
            if (CHECK_INT(more.size, one.size)) CHECK(memcmp(one.data, more.data, one.size) == 0);
            pdi_bytes_free(&ctx, &one);
            pdi_bytes_free(&ctx, &more);
            CHECK_INT(ctx.in_use, 0);
        }
    }
}

/* Sums of the definition (RFC 1950), byte by byte. */
TEST(the_checksum_is_that_of_its_definition)
{
    static uint8_t data[12000];
    uint32_t a = 1, b = 0;
    memset(data, 255, sizeof data); /* the largest sums */
    for (size_t n = 0; n <= sizeof data; n++) {
        if (n < 100 || n % 1388 < 2 || n == sizeof data) CHECK_INT(pdi_zlib_adler32(data, n), b << 16 | a);
        if (n == sizeof data) break;
        if (n > 9000) data[n] = (uint8_t)(n * n >> 3);
        a = (a + data[n]) % 65521;
        b = (b + a) % 65521;
    }
}

/* 400 bytes packed by zlib with dynamic codes. */
static const uint8_t dynamic_stream[] = {
    0x78, 0xDA, 0x15, 0xCE, 0xA1, 0x2F, 0x87, 0x41, 0x1C, 0xC7, 0xF1, 0xDF, 0xF6, 0xE5, 0xD9, 0x1E, 0xBB, 0xB9,
    0xED, 0x78, 0xB6, 0xB3, 0x9B, 0x67, 0x3B, 0x9E, 0xED, 0xB1, 0x9B, 0xDB, 0x1E, 0x6E, 0x3B, 0x7B, 0xE6, 0xD9,
    0x8E, 0xDB, 0x08, 0x04, 0x02, 0x81, 0x40, 0x20, 0x10, 0x08, 0x04, 0x02, 0x81, 0x40, 0xA0, 0x28, 0x8A, 0xA2,
    0x28, 0x8A, 0xA2, 0x28, 0x8A, 0xA2, 0x28, 0x8A, 0xA2, 0x28, 0x8A, 0xA2, 0x28, 0x0A, 0x9F, 0xDF, 0xFB, 0x0F,
    0x78, 0xEF, 0xD5, 0xA2, 0x84, 0x89, 0x4E, 0x6D, 0x5C, 0xD3, 0xC5, 0x95, 0xA9, 0xB9, 0x28, 0x3C, 0xF5, 0xDA,
    0x28, 0x4C, 0x5F, 0x56, 0x25, 0x3A, 0xCF, 0x1C, 0xB3, 0x83, 0x26, 0x31, 0xE9, 0x10, 0xF7, 0x32, 0xD8, 0xD4,
    0x29, 0x1A, 0x95, 0xE4, 0xF2, 0xB1, 0x60, 0x15, 0x6B, 0x5C, 0xA9, 0xF8, 0x64, 0xF0, 0xB6, 0x9C, 0x56, 0x99,
    0xE0, 0xB3, 0x0C, 0xCD, 0x8B, 0x4C, 0xE9, 0x45, 0xEB, 0x03, 0x2D, 0xAB, 0xD2, 0xC5, 0x55, 0x65, 0x03, 0x5B,
    0x77, 0x24, 0xAB, 0x4D, 0xE5, 0xD2, 0x62, 0x5B, 0x7A, 0x6E, 0x77, 0xDB, 0xBF, 0x7D, 0xE6, 0xB2, 0xE6, 0x30,
    0xA9, 0xB2, 0x78, 0x2C, 0xA2, 0x95, 0xA7, 0xBE, 0x10, 0x74, 0x6E, 0x14, 0xA7, 0x0B, 0x67, 0xB4, 0xBC, 0x64,
    0x09, 0xB5, 0xAE, 0x02, 0xBA, 0x6E, 0x01, 0x78, 0x23, 0x01, 0xBC, 0x25, 0x00, 0xEF, 0x08, 0xC0, 0x7B, 0x09,
    0xE0, 0x43, 0x04, 0xF0, 0xB1, 0x01, 0xF0, 0x29, 0xC5, 0xF0, 0xD9, 0x02, 0xF8, 0x52, 0x00, 0xF8, 0x5A, 0x01,
    0xF8, 0xC6, 0x00, 0x7C, 0x8F, 0x00, 0x7E, 0x10, 0x80, 0x9F, 0x1A, 0xC0, 0xAF, 0xB6, 0xEF, 0x9B, 0x03, 0xF8,
    0x53, 0x02, 0xF8, 0xCB, 0x01, 0xFC, 0x63, 0x00, 0x76, 0xE4, 0x00, 0xA6, 0x04, 0x60, 0x77, 0x00, 0xB0, 0xA7,
    0xFD, 0x93, 0x16, 0xC0, 0x7E, 0x0D, 0xE0, 0x80, 0x01, 0xB0, 0x24, 0x00, 0x87, 0x6B, 0x00, 0x47, 0x1A, 0x00,
    0xBD, 0x00, 0x70, 0x3C, 0xC2, 0x37, 0x11, 0x01, 0x9C, 0x12, 0x00, 0xCE, 0x34, 0x00, 0xCE, 0xD5, 0x00, 0x2E,
    0x10, 0x80, 0x4B, 0x06, 0xC0, 0x15, 0x0D, 0xE0, 0x9A, 0xC5, 0x70, 0x23, 0x05, 0x70, 0x2B, 0x00, 0xB8, 0x43,
    0x00, 0xEE, 0xE5, 0x00, 0x1E, 0x30, 0x00, 0x8F, 0x38, 0x80, 0x27, 0x25, 0x80, 0x67, 0x1C, 0xBE, 0x7F, 0x77,
    0x14, 0x49, 0x61};

/* Any bytes: unpacked or refused, the output never overrun (the sanitizers watch). Of all streams with one bit
 * changed zlib takes one, where the bit is not used (byte 322, the last before the checksum). */
TEST(damaged_streams_are_refused_as_by_zlib)
{
    enum { N = 400 };
    uint8_t data[N], back[N], stream[sizeof dynamic_stream];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int i = 0; i < N; i++) data[i] = (uint8_t)(i % 5 ? (i * i / 7 + i) % 23 * 3 : i);
    memcpy(stream, dynamic_stream, sizeof stream);
    CHECK_OK(&ctx, pdi_zlib_inflate(&ctx, "here", stream, sizeof stream, back, N));
    CHECK(memcmp(data, back, N) == 0);
    int accepted = 0;
    for (size_t k = 0; k < sizeof stream; k++)
        for (int bit = 0; bit < 8; bit++) {
            stream[k] = (uint8_t)(stream[k] ^ 1 << bit);
            pd_status status = pdi_zlib_inflate(&ctx, "here", stream, sizeof stream, back, N);
            stream[k] = (uint8_t)(stream[k] ^ 1 << bit);
            if (status != PD_OK) {
                CHECK_INT(status, PD_ERR_PARSE);
                continue;
            }
            accepted++;
            CHECK(k == 322 && bit == 7 && memcmp(data, back, N) == 0);
        }
    CHECK_INT(accepted, 1);
    uint32_t x = 1;
    int unpacked = 0;
    for (int k = 0; k < 20000; k++) { /* several bytes replaced */
        memcpy(stream, dynamic_stream, sizeof stream);
        for (int j = 0; j < 1 + k % 4; j++) {
            x = x * 1664525u + 1013904223u;
            stream[2 + (x >> 8) % (sizeof stream - 2)] = (uint8_t)(x >> 24);
        }
        pd_status status = pdi_zlib_inflate(&ctx, "here", stream, sizeof stream, back, N);
        unpacked += status == PD_OK && memcmp(data, back, N) != 0;
    }
    CHECK_LE(unpacked, 2); /* the checksum has 32 bits */
}

static pd_image pattern(pd_ctx *ctx, int width, int height, int channels)
{
    pd_image image = {0, 0, 0, NULL};
    size_t n = (size_t)width * (size_t)height * (size_t)channels;
    if (!CHECK_OK(ctx, PD_NEW(ctx, "test", n, image.pixels))) return image;
    image.width = width;
    image.height = height;
    image.channels = channels;
    for (size_t i = 0; i < n; i++) image.pixels[i] = (uint8_t)(i * i / 5 + i / (size_t)width);
    return image;
}

TEST(images_come_back)
{
    static const int sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {7, 5}, {640, 333}};
    pd_ctx ctx;
    start(&ctx);
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        for (int channels = 1; channels <= 3; channels += 2) {
            pd_image image = pattern(&ctx, sizes[k][0], sizes[k][1], channels), back;
            CHECK_OK(&ctx, pd_png_write(&ctx, DIRECTORY "/back.png", &image));
            if (!CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/back.png", &back))) return;
            CHECK(back.width == image.width && back.height == image.height && back.channels == channels);
            CHECK(memcmp(image.pixels, back.pixels,
                         (size_t)image.width * (size_t)image.height * (size_t)channels) == 0);
            pd_image_free(&ctx, &image);
            pd_image_free(&ctx, &back);
        }
    CHECK_INT(ctx.in_use, 0);
    remove(DIRECTORY "/back.png");
}

TEST(an_image_that_cannot_be_written_is_refused)
{
    pd_ctx ctx;
    start(&ctx);
    pd_image image = pattern(&ctx, 4, 4, 3);
    CHECK_INT(pd_png_write(&ctx, DIRECTORY "/none/x.png", &image), PD_ERR_FILE);
    image.channels = 2;
    CHECK_INT(pd_png_write(&ctx, DIRECTORY "/x.png", &image), PD_ERR_ARGUMENT);
    image.channels = 3;
    image.height = 0;
    CHECK_INT(pd_png_write(&ctx, DIRECTORY "/x.png", &image), PD_ERR_ARGUMENT);
    image.width = image.height = 100000;
    CHECK_INT(pd_png_write(&ctx, DIRECTORY "/x.png", &image), PD_ERR_SIZE);
    image.width = image.height = 4;
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

TEST(gray_is_luminance_times_opacity)
{
    uint8_t pixels[] = {255, 0, 0, 255, 255, 255, 255, 0, 255, 255, 255, 128, 255, 255, 255, 255}, gray[] = {77};
    pd_image rgba = {2, 2, 4, pixels}, one = {1, 1, 1, gray};
    CHECK_INT(pdi_image_get_luminance(&rgba, 0, 0), 76); /* 0.299 * 255 */
    CHECK_INT(pdi_image_get_luminance(&rgba, 1, 0), 0);
    CHECK_INT(pdi_image_get_luminance(&rgba, 0, 1), 128);
    CHECK_INT(pdi_image_get_luminance(&rgba, 1, 1), 255);
    CHECK_INT(pdi_image_get_luminance(&one, 0, 0), 77);
}

static void put(const uint8_t *data, size_t size)
{
    FILE *f = fopen(DIRECTORY "/hurt.png", "wb");
    if (!CHECK(f != NULL)) return;
    CHECK(fwrite(data, 1, size, f) == size);
    fclose(f);
}

/* Read hurt.png; the message must hold `text`. */
static void refused(pd_ctx *ctx, const char *text)
{
    pd_image image;
    CHECK_INT(pd_png_read(ctx, DIRECTORY "/hurt.png", &image), PD_ERR_PARSE);
    if (!CHECK(strstr(ctx->message, text) && strstr(ctx->message, "hurt.png"))) NOTE("%s", ctx->message);
    CHECK(image.pixels == NULL);
    CHECK_INT(ctx->in_use, 0);
}

static void put32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++) at[i] = (uint8_t)(value >> (24 - 8 * i));
}

/* A file of a header with these entries, a palette of two colours if wanted, and compressed rows. Transparent pixels:
 * `key`, of that many bytes; 0: none. */
static void compose_with(pd_ctx *ctx, uint32_t width, uint32_t height, int depth, int colour, int interlaced,
                         int palette, const char *key, size_t keys, const uint8_t *rows, size_t size)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    uint8_t file[4096] = {0}, chunk[64] = {0};
    size_t used = sizeof signature;
    pdi_bytes packed = {NULL, 0, 0};
    if (!CHECK_OK(ctx, pdi_zlib_deflate(ctx, rows, size, &packed))) return;
    memcpy(file, signature, used);
    for (int k = 0; k < 5; k++) {
        static const char *const types[5] = {"IHDR", "PLTE", "tRNS", "IDAT", "IEND"};
        const uint8_t *body = k == 3 ? packed.data : chunk;
        size_t length = k == 0 ? 13 : k == 1 ? 6 : k == 2 ? keys : k == 3 ? packed.size : 0;
        if ((k == 1 && !palette) || (k == 2 && !keys)) continue;
        memset(chunk, 0, sizeof chunk);
        if (k == 0) {
            put32(chunk, width);
            put32(chunk + 4, height);
            chunk[8] = (uint8_t)depth;
            chunk[9] = (uint8_t)colour;
            chunk[12] = (uint8_t)interlaced;
        } else if (k == 1) memcpy(chunk, "\x0A\x14\x1E\xC8\xD2\xDC", 6);
        else if (k == 2) memcpy(chunk, key, keys);
        put32(file + used, (uint32_t)length);
        memcpy(file + used + 4, types[k], 4);
        memcpy(file + used + 8, body, length);
        put32(file + used + 8 + length, pdi_zlib_crc32(0, file + used + 4, length + 4));
        used += length + 12;
    }
    pdi_bytes_free(ctx, &packed);
    put(file, used);
}

static void compose(pd_ctx *ctx, uint32_t width, uint32_t height, int depth, int colour, int interlaced, int palette,
                    const uint8_t *rows, size_t size)
{
    compose_with(ctx, width, height, depth, colour, interlaced, palette, "", 0, rows, size);
}

/* A scene whose metal is hurt.png, of 4 x 3 cells, above a floor: its status, and which of them are metal, the lowest
 * row first. */
static pd_status mask(pd_ctx *ctx, char *found)
{
    static const char *const text =
        "[grid] h = 1 um  box = 0 um .. 8 um, 0 um .. 8 um\n[shape s] mask = hurt.png  corner = 2 um, 2 um  "
        "cell = 1 um  kind = solid  material = copper\n[transport] D = 1e-9 m2/s\n[dissolve] rate = 0 m/s\n"
        "[run] until = 1 s\n";
    pd_setup setup;
    FILE *f = fopen(DIRECTORY "/mask.scene", "wb");
    if (!CHECK(f != NULL)) return PD_ERR_FILE;
    fputs(text, f);
    fclose(f);
    pd_status status = pd_scene_read(ctx, DIRECTORY "/mask.scene", NULL, 0, &setup);
    for (int k = 0; k < 12 && status >= 0; k++) {
        double x[2] = {(2.5 + k % 4) * 1e-6, (2.5 + k / 4) * 1e-6};
        found[k] = pd_shape_distance(setup.shape, setup.solid, x) < 0.0 ? '#' : '.';
    }
    found[12] = 0;
    if (status >= 0) pd_setup_free(ctx, &setup);
    CHECK_INT(ctx->in_use, 0);
    return status;
}

/* White is metal; what is transparent is not, by alpha, by a palette or by a key. */
TEST(masks)
{
    static const uint8_t gray[] = {0, 0, 255, 255, 127, 0, 128, 0, 0, 0, 0, 255, 0, 0, 200};
    static const uint8_t clear[] = {0, 255, 0, 255, 255, 255, 127, 255, 128, 0, 9, 9, 255, 255, 200, 200, 90, 255,
                                    0, 255, 0, 255, 0, 255, 0, 255, 0};
    static const uint8_t bits[] = {0, 0x60, 0, 0x80, 0, 0x10};
    static const uint8_t labels[] = {0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1}, black[15] = {0};
    char found[13];
    pd_ctx ctx;
    start(&ctx);
    compose(&ctx, 4, 3, 8, 0, 0, 0, gray, sizeof gray);
    CHECK_INT(mask(&ctx, found), PD_OK);
    CHECK_STR(found, "#..##....##.");
    compose_with(&ctx, 4, 3, 8, 0, 0, 0, "\0\xff", 2, gray, sizeof gray);
    CHECK_INT(mask(&ctx, found), PD_OK);
    CHECK_STR(found, "...##.......");
    compose(&ctx, 4, 3, 8, 4, 0, 0, clear, sizeof clear);
    CHECK_INT(mask(&ctx, found), PD_OK);
    CHECK_STR(found, ".....##..#.#");
    compose(&ctx, 4, 3, 1, 3, 0, 1, bits, sizeof bits);
    CHECK_INT(mask(&ctx, found), PD_OK);
    CHECK_STR(found, "...##....##.");
    compose_with(&ctx, 4, 3, 1, 3, 0, 1, "\xff\x40", 2, bits, sizeof bits);
    CHECK(mask(&ctx, found) < 0);
    CHECK(strstr(ctx.message, "found lightness from 18 to 52 in ") != NULL);
    compose(&ctx, 4, 3, 8, 0, 0, 0, labels, sizeof labels);
    CHECK(mask(&ctx, found) < 0);
    CHECK(strstr(ctx.message, "mask.scene:2: mask: found lightness from 0 to 1 in ") != NULL);
    CHECK(strstr(ctx.message, "numbers of labels are no lightness") != NULL);
    compose(&ctx, 4, 3, 8, 0, 0, 0, black, sizeof black);
    CHECK(mask(&ctx, found) < 0);
    CHECK(strstr(ctx.message, "it is black or transparent everywhere") != NULL);
}

/* Colours with opacity, and colours of which one is clear; keys have 16 bits a sample. */
TEST(colours_with_opacity)
{
    static const uint8_t rgba[] = {0, 10, 20, 30, 255, 40, 50, 60, 0};
    static const uint8_t rgb[] = {0, 10, 20, 30, 10, 20, 31, 1, 10, 20, 30, 10, 20, 31};
    static const uint8_t keyed[] = {10, 20, 30, 0, 10, 20, 31, 255};
    pd_ctx ctx;
    pd_image image;
    start(&ctx);
    compose(&ctx, 2, 1, 8, 6, 0, 0, rgba, sizeof rgba);
    if (!CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/hurt.png", &image))) return;
    CHECK_INT(image.channels, 4);
    CHECK(memcmp(image.pixels, rgba + 1, 8) == 0);
    pd_image_free(&ctx, &image);
    compose_with(&ctx, 2, 2, 8, 2, 0, 0, "\0\x0A\0\x14\0\x1E", 6, rgb, sizeof rgb); /* the second row: left added */
    if (!CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/hurt.png", &image))) return;
    CHECK_INT(image.channels, 4);
    CHECK(image.width == 2 && image.height == 2);
    for (int k = 0; k < 8; k++) CHECK_INT(image.pixels[k], keyed[k]);
    CHECK_INT(image.pixels[11], 0);
    CHECK_INT(image.pixels[12], 20);
    CHECK_INT(image.pixels[14], 61);
    CHECK_INT(image.pixels[15], 255);
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

TEST(few_bits_and_palettes_are_expanded)
{
    /* Rows of 10 pixels: filter byte, then bits from the left. The second row adds the one above: A0, 40 + C0 = 00. */
    static const uint8_t rows[] = {0, 0xA0, 0x40, 2, 0x00, 0xC0};
    static const char *const expected[2] = {"1010000001", "1010000000"};
    pd_ctx ctx;
    pd_image image;
    start(&ctx);
    compose(&ctx, 10, 2, 1, 0, 0, 0, rows, sizeof rows);
    if (!CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/hurt.png", &image))) return;
    CHECK(image.width == 10 && image.height == 2 && image.channels == 1);
    for (int c = 0; c < 10; c++) {
        CHECK_INT(pdi_image_get_luminance(&image, c, 0), expected[0][c] == '1' ? 255 : 0);
        CHECK_INT(pdi_image_get_luminance(&image, c, 1), expected[1][c] == '1' ? 255 : 0);
    }
    pd_image_free(&ctx, &image);
    compose(&ctx, 10, 2, 1, 3, 0, 1, rows, sizeof rows);
    if (!CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/hurt.png", &image))) return;
    CHECK_INT(image.channels, 3);
    CHECK(memcmp(image.pixels, "\xC8\xD2\xDC\x0A\x14\x1E\xC8\xD2\xDC", 9) == 0);
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

TEST(what_is_not_supported_is_said)
{
    static const uint8_t rows[] = {0, 0xA0, 0x40, 0, 0x00, 0xC0};
    pd_ctx ctx;
    start(&ctx);
    compose(&ctx, 10, 2, 16, 0, 0, 0, rows, sizeof rows);
    refused(&ctx, "16 bits a channel, expected 8");
    compose(&ctx, 10, 2, 4, 2, 0, 0, rows, sizeof rows);
    refused(&ctx, "4 bits a channel");
    compose(&ctx, 10, 2, 1, 0, 1, 0, rows, sizeof rows);
    refused(&ctx, "interlaced");
    compose(&ctx, 10, 2, 8, 5, 0, 0, rows, sizeof rows);
    refused(&ctx, "colour type 5");
    compose(&ctx, 10, 2, 1, 3, 0, 0, rows, sizeof rows);
    refused(&ctx, "the palette is missing");
    compose(&ctx, 5, 2, 2, 3, 0, 1, rows, sizeof rows);
    refused(&ctx, "beyond the palette");
    compose(&ctx, 0, 2, 1, 0, 0, 0, rows, sizeof rows);
    refused(&ctx, "no pixels");
    compose(&ctx, 4000000000u, 4000000000u, 1, 0, 0, 0, rows, sizeof rows);
    refused(&ctx, "4000000000 x 4000000000 pixels");
    ctx.peak = 0;
    compose(&ctx, 8000, 8000, 8, 0, 0, 0, rows, sizeof rows);
    ctx.peak = 0;
    refused(&ctx, "too few data");
    CHECK_LE((double)ctx.peak, 1e6); /* nothing was taken for an image that cannot be there */
    compose(&ctx, 10, 3, 1, 0, 0, 0, rows, sizeof rows);
    refused(&ctx, "less data");
    compose(&ctx, 10, 1, 1, 0, 0, 0, rows, sizeof rows);
    refused(&ctx, "more data");
    static const uint8_t unknown_filter[] = {5, 1, 2};
    compose(&ctx, 10, 1, 1, 0, 0, 0, unknown_filter, sizeof unknown_filter);
    refused(&ctx, "unknown filter");
    put((const uint8_t *)"GIF89a", 6);
    refused(&ctx, "not a PNG file");
    pd_image image;
    CHECK_INT(pd_png_read(&ctx, DIRECTORY "/none.png", &image), PD_ERR_FILE);
}

TEST(cut_and_damaged_files_are_refused)
{
    pd_ctx ctx;
    char *data;
    size_t size;
    start(&ctx);
    pd_image image = pattern(&ctx, 9, 6, 3);
    CHECK_OK(&ctx, pd_png_write(&ctx, DIRECTORY "/good.png", &image));
    pd_image_free(&ctx, &image);
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, DIRECTORY "/good.png", 100000, &data, &size))) return;
    size_t held = ctx.in_use;
    int accepted = 0, other = 0, leaks = 0;
    for (size_t k = 0; k < size; k++)
        for (int bit = -1; bit < 8; bit++) {
            if (bit >= 0) data[k] = (char)(data[k] ^ 1 << bit);
            put((const uint8_t *)data, bit < 0 ? k : size);
            pd_status status = pd_png_read(&ctx, DIRECTORY "/hurt.png", &image);
            if (bit >= 0) data[k] = (char)(data[k] ^ 1 << bit);
            accepted += status == PD_OK;
            other += status != PD_OK && status != PD_ERR_PARSE;
            if (status == PD_OK) pd_image_free(&ctx, &image);
            leaks += ctx.in_use != held;
        }
    CHECK_INT(accepted, 0);
    CHECK_INT(other, 0);
    CHECK_INT(leaks, 0);
    PD_DELETE(&ctx, size + 1, data);
    remove(DIRECTORY "/good.png");
    remove(DIRECTORY "/hurt.png");
}

TEST_MAIN(ENTRY(checksums_have_their_published_values) ENTRY(a_stream_of_zlib_is_unpacked)
          ENTRY(packed_data_come_back_and_are_as_small_as_those_of_zlib)
          ENTRY(pieces_of_a_stream_come_back_whatever_the_threads)
          ENTRY(the_checksum_is_that_of_its_definition) ENTRY(damaged_streams_are_refused_as_by_zlib)
          ENTRY(images_come_back) ENTRY(an_image_that_cannot_be_written_is_refused)
          ENTRY(gray_is_luminance_times_opacity) ENTRY(masks) ENTRY(colours_with_opacity)
          ENTRY(few_bits_and_palettes_are_expanded)
          ENTRY(what_is_not_supported_is_said) ENTRY(cut_and_damaged_files_are_refused))
