/* Streams of zlib for tests/wasm/streams.mjs: bytes such as those of pictures, and what the library makes of them. */
#define PDCORR_NO_PHYSICS
#define PDCORR_STATIC
#include "pdcorr_app.h"
#include <stdlib.h>
#include <string.h>

#define EXPORT(name) __attribute__((export_name(#name)))
#define MOST 600000

static pd_ctx ctx;
static pdi_bytes packed;
static uint8_t raw[MOST];
static uint32_t state;

static uint32_t next(void)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

/* Zeros in a row at the end of a random number: half of them 0, a quarter 1, and so on. */
static uint8_t geometric(void)
{
    uint32_t bits = next();
    uint8_t zeros = 0;
    while (!(bits & 1) && zeros < 31) {
        bits >>= 1;
        zeros++;
    }
    return zeros;
}

/* Packs stream `number` and returns its bytes, -1 on failure. */
EXPORT(make) int make(int number)
{
    if (number == 0) pd_ctx_init(&ctx);
    state = 2654435761u * (uint32_t)(number + 1) | 1u;
    for (int k = 0; k < 8; k++) next();
    uint32_t size = next() % (number % 50 ? MOST / 10 : MOST), width = 1 + next() % 900, levels = 1 + next() % 255;
    for (uint32_t i = 0; i < size; i++) {
        uint32_t x = i % width, y = i / width;
        switch (number % 8) {
        case 0: raw[i] = (uint8_t)next(); break;
        case 1: raw[i] = (uint8_t)(x * x / 64 + y * y / 64); break;
        case 2: raw[i] = i && next() % 100 ? raw[i - 1] : (uint8_t)next(); break;
        case 3: raw[i] = y && next() % 300 ? raw[i - width] : (uint8_t)next(); break;
        case 4: raw[i] = (uint8_t)(next() % levels); break;
        case 5: raw[i] = geometric(); break;
        case 6: raw[i] = (uint8_t)(x < width / 2 ? 0 : x * levels / width + next() % 2); break;
        default: raw[i] = i > 40000 ? raw[i - 1 - next() % 40000] : (uint8_t)(next() % 5);
        }
    }
    packed.size = 0;
    return pdi_zlib_deflate(&ctx, raw, size, &packed) < 0 ? -1 : (int)size;
}

EXPORT(raw_at) int raw_at(void) { return (int)(size_t)raw; }
EXPORT(packed_at) int packed_at(void) { return (int)(size_t)packed.data; }
EXPORT(packed_size) int packed_size(void) { return (int)packed.size; }
