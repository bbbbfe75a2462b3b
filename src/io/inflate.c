/* inflate: see inflate.h */
#include "io/inflate.h"
#include "io/deflate.h"
#include <string.h>

#define PDI_INFLATE_LITERALS 286
#define PDI_INFLATE_DISTANCES 30
#define PDI_INFLATE_LENGTH_CODES 19
#define PDI_INFLATE_FIXED 288

/* Order in which a dynamic block lists the lengths of its length codes (RFC 1951, 3.2.7). */
static const uint8_t pdi_inflate_order[PDI_INFLATE_LENGTH_CODES] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                                    11, 4,  12, 3, 13, 2, 14, 1, 15};

typedef struct pdi_inflate_state {
    const uint8_t *data;
    size_t size, at;
    uint32_t bits;
    int bit_count;
    uint8_t *out;
    size_t out_size, out_at;
    const char *error; /* NULL: none so far */
} pdi_inflate_state;

/* A canonical code set: how many codes of each length, and the symbols in the order of their codes. */
typedef struct pdi_inflate_codes {
    int count[16];
    int symbol[PDI_INFLATE_FIXED];
} pdi_inflate_codes;

/* The first error stands. */
static int pdi_inflate_error(pdi_inflate_state *s, const char *text)
{
    if (!s->error) s->error = text;
    return 0;
}

static uint32_t pdi_inflate_get(pdi_inflate_state *s, int count)
{
    while (s->bit_count < count) {
        if (s->at >= s->size) {
            pdi_inflate_error(s, "the compressed data end early");
            return 0;
        }
        s->bits |= (uint32_t)s->data[s->at++] << s->bit_count;
        s->bit_count += 8;
    }
    uint32_t value = s->bits & ((1u << count) - 1);
    s->bits >>= count;
    s->bit_count -= count;
    return value;
}

/* 1 when the lengths make a full set of codes; a single code of one bit is allowed where `single`. */
static int pdi_inflate_prepare(pdi_inflate_codes *codes, const uint8_t *lengths, int n, int single)
{
    int offset[16], left = 1, used = 0;
    memset(codes->count, 0, sizeof codes->count);
    for (int i = 0; i < n; i++) codes->count[lengths[i]]++;
    used = n - codes->count[0];
    codes->count[0] = 0;
    for (int l = 1; l < 16; l++) {
        left = 2 * left - codes->count[l];
        if (left < 0) return 0;
    }
    offset[1] = 0;
    for (int l = 1; l < 15; l++) offset[l + 1] = offset[l] + codes->count[l];
    for (int i = 0; i < n; i++)
        if (lengths[i]) codes->symbol[offset[lengths[i]]++] = i;
    return left == 0 || (single && (used == 0 || (used == 1 && codes->count[1] == 1)));
}

/* Next symbol, -1 on error. */
static int pdi_inflate_symbol(pdi_inflate_state *s, const pdi_inflate_codes *codes)
{
    int code = 0, first = 0, index = 0;
    for (int l = 1; l < 16; l++) {
        code |= (int)pdi_inflate_get(s, 1);
        if (s->error) return -1;
        int count = codes->count[l];
        if (code - count < first) return codes->symbol[index + (code - first)];
        index += count;
        first = (first + count) << 1;
        code <<= 1;
    }
    pdi_inflate_error(s, "a code that was not defined");
    return -1;
}

static int pdi_inflate_copy(pdi_inflate_state *s, uint32_t length, uint32_t distance)
{
    if (distance > s->out_at) return pdi_inflate_error(s, "a reference to before the start of the data");
    if (length > s->out_size - s->out_at) return pdi_inflate_error(s, "more data than the picture holds");
    for (uint32_t i = 0; i < length; i++, s->out_at++) s->out[s->out_at] = s->out[s->out_at - distance];
    return 1;
}

static int pdi_inflate_coded(pdi_inflate_state *s, const pdi_inflate_codes *literals,
                             const pdi_inflate_codes *distances)
{
    for (;;) {
        int symbol = pdi_inflate_symbol(s, literals);
        if (symbol < 0) return 0;
        if (symbol == 256) return 1;
        if (symbol < 256) {
            if (s->out_at >= s->out_size) return pdi_inflate_error(s, "more data than the picture holds");
            s->out[s->out_at++] = (uint8_t)symbol;
            continue;
        }
        if (symbol > 285) return pdi_inflate_error(s, "a length code that does not exist");
        int k = symbol - 257, extra = k < 8 || k == 28 ? 0 : k / 4 - 1;
        uint32_t length = k == 28 ? 258u : k < 8 ? (uint32_t)k + 3 : (4u + (uint32_t)(k & 3)) << extra;
        if (k >= 8 && k < 28) length += 3 + pdi_inflate_get(s, extra);
        k = pdi_inflate_symbol(s, distances);
        if (k < 0) return 0;
        if (k > 29) return pdi_inflate_error(s, "a distance code that does not exist");
        extra = k < 4 ? 0 : k / 2 - 1;
        uint32_t distance = k < 4 ? (uint32_t)k + 1 : ((2u + (uint32_t)(k & 1)) << extra) + 1;
        distance += pdi_inflate_get(s, extra);
        if (s->error || !pdi_inflate_copy(s, length, distance)) return 0;
    }
}

static int pdi_inflate_stored(pdi_inflate_state *s)
{
    s->bits = 0; /* to the next whole byte; fewer than 8 bits are ever held */
    s->bit_count = 0;
    uint32_t length = pdi_inflate_get(s, 16), check = pdi_inflate_get(s, 16);
    if (s->error) return 0;
    if (length != (~check & 0xffff)) return pdi_inflate_error(s, "a stored block with a wrong length check");
    if (length > s->size - s->at) return pdi_inflate_error(s, "the compressed data end early");
    if (length > s->out_size - s->out_at) return pdi_inflate_error(s, "more data than the picture holds");
    if (length) memcpy(s->out + s->out_at, s->data + s->at, length);
    s->at += length;
    s->out_at += length;
    return 1;
}

static int pdi_inflate_fixed(pdi_inflate_state *s)
{
    pdi_inflate_codes literals, distances;
    uint8_t lengths[PDI_INFLATE_FIXED];
    for (int i = 0; i < PDI_INFLATE_FIXED; i++) lengths[i] = (uint8_t)(i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8);
    pdi_inflate_prepare(&literals, lengths, PDI_INFLATE_FIXED, 0);
    memset(lengths, 5, 32);
    pdi_inflate_prepare(&distances, lengths, 32, 0);
    return pdi_inflate_coded(s, &literals, &distances);
}

/* Read the run-length coded lengths of both code sets. */
static int pdi_inflate_lengths(pdi_inflate_state *s, const pdi_inflate_codes *codes, uint8_t *lengths, int n)
{
    for (int i = 0; i < n;) {
        int symbol = pdi_inflate_symbol(s, codes), run = 1;
        uint8_t value = 0;
        if (symbol < 0) return 0;
        if (symbol < 16) value = (uint8_t)symbol;
        else if (symbol == 16) {
            if (i == 0) return pdi_inflate_error(s, "a repeated code length without a first one");
            value = lengths[i - 1];
            run = 3 + (int)pdi_inflate_get(s, 2);
        } else run = symbol == 17 ? 3 + (int)pdi_inflate_get(s, 3) : 11 + (int)pdi_inflate_get(s, 7);
        if (s->error) return 0;
        if (run > n - i) return pdi_inflate_error(s, "too many code lengths");
        while (run--) lengths[i++] = value;
    }
    return 1;
}

static int pdi_inflate_dynamic(pdi_inflate_state *s)
{
    pdi_inflate_codes literals, distances;
    uint8_t lengths[PDI_INFLATE_FIXED + 32] = {0};
    int literal_count = 257 + (int)pdi_inflate_get(s, 5), distance_count = 1 + (int)pdi_inflate_get(s, 5);
    int listed = 4 + (int)pdi_inflate_get(s, 4);
    if (literal_count > PDI_INFLATE_LITERALS || distance_count > PDI_INFLATE_DISTANCES)
        return pdi_inflate_error(s, "a block with too many codes");
    for (int i = 0; i < listed; i++) lengths[pdi_inflate_order[i]] = (uint8_t)pdi_inflate_get(s, 3);
    if (s->error) return 0;
    if (!pdi_inflate_prepare(&literals, lengths, PDI_INFLATE_LENGTH_CODES, 0))
        return pdi_inflate_error(s, "a block with an impossible set of codes");
    memset(lengths, 0, sizeof lengths);
    if (!pdi_inflate_lengths(s, &literals, lengths, literal_count + distance_count)) return 0;
    if (!lengths[256]) return pdi_inflate_error(s, "a block without an end code");
    if (!pdi_inflate_prepare(&literals, lengths, literal_count, 1) ||
        !pdi_inflate_prepare(&distances, lengths + literal_count, distance_count, 1))
        return pdi_inflate_error(s, "a block with an impossible set of codes");
    return pdi_inflate_coded(s, &literals, &distances);
}

static void pdi_inflate_run(pdi_inflate_state *s)
{
    uint32_t head = pdi_inflate_get(s, 8) << 8;
    head |= pdi_inflate_get(s, 8);
    if (!s->error && ((head >> 8 & 15) != 8 || head >> 12 > 7 || (head & 32) || head % 31))
        pdi_inflate_error(s, "not a zlib stream");
    for (uint32_t last = 0; !last && !s->error;) {
        last = pdi_inflate_get(s, 1);
        uint32_t kind = pdi_inflate_get(s, 2);
        if (s->error) return;
        if (kind == 0) pdi_inflate_stored(s);
        else if (kind == 1) pdi_inflate_fixed(s);
        else if (kind == 2) pdi_inflate_dynamic(s);
        else pdi_inflate_error(s, "a block of an unknown kind");
    }
    if (s->error) return;
    if (s->out_at != s->out_size) {
        pdi_inflate_error(s, "less data than the picture holds");
        return;
    }
    s->bits = 0;
    s->bit_count = 0;
    uint32_t adler = 0;
    for (int i = 0; i < 4; i++) adler = adler << 8 | pdi_inflate_get(s, 8);
    if (!s->error && adler != pdi_deflate_adler(s->out, s->out_size)) pdi_inflate_error(s, "the checksum is wrong");
}

PDI_FN pd_status pdi_inflate(pd_ctx *ctx, const char *name, const uint8_t *data, size_t size, uint8_t *out,
                             size_t out_size)
{
    pdi_inflate_state s;
    memset(&s, 0, sizeof s);
    s.data = data;
    s.size = size;
    s.out = out;
    s.out_size = out_size;
    pdi_inflate_run(&s);
    if (s.error)
        return pdi_fail(ctx, PD_ERR_PARSE, "inflate", "%s: damaged compressed data (%s, at byte %.0f of %.0f)", name,
                        s.error, (double)s.at, (double)size);
    return PD_OK;
}
