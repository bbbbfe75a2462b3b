/* zlib: see zlib.h */
#include "io/zlib.h"
#include "core/par.h"
#include <string.h>

#define PDI_ZLIB_WINDOW 32768 /* [byte] how far back a match may lie */
#define PDI_ZLIB_MAX_CHAIN 64 /* maximum length of a hash chain that is searched */
#define PDI_ZLIB_MAX_MATCH 258 /* [byte] longest match */
#define PDI_ZLIB_BLOCK_SYMBOLS 16384 /* symbols per block */
#define PDI_ZLIB_GOOD_MATCH 64       /* [byte] a match of this length is taken without looking for a longer one */
#define PDI_ZLIB_MATCH_END_SIZE 16   /* [byte] end of such a match whose positions enter the hash chains */
#define PDI_ZLIB_LITERALS 286 /* number of literal and length codes (RFC 1951, 3.2.5) */
#define PDI_ZLIB_DISTANCES 30 /* number of distance codes */
#define PDI_ZLIB_LENGTH_CODES 19 /* number of codes for code lengths */
#define PDI_ZLIB_FIXED_CODES 288 /* number of fixed literal codes (RFC 1951, 3.2.6) */
#define PDI_ZLIB_CRC_TABLE_SIZE 8192 /* [byte] size from which a CRC uses tables */
#define PDI_ZLIB_CHUNK_SIZE 262144   /* [byte] chunk that one thread compresses at a time */
#define PDI_ZLIB_LOOKBACK 8192       /* [byte] window before a chunk that its first matches may refer to */
#define PDI_ZLIB_MAX_THREADS 4       /* maximum number of threads: each needs half a megabyte */

/* Order in which a dynamic block lists the lengths of its length codes (RFC 1951, 3.2.7). */
static const uint8_t pdi_zlib_length_order[PDI_ZLIB_LENGTH_CODES] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                                     11, 4,  12, 3, 13, 2, 14, 1, 15};

/* ---- byte buffers and checksums ---- */

PDI_FN pd_status pdi_bytes_reserve(pd_ctx *ctx, pdi_bytes *bytes, size_t more)
{
    if (bytes->capacity - bytes->size >= more) return PD_OK;
    size_t capacity = bytes->size + bytes->size / 2 + more;
    PD_TRY(PD_GROW(ctx, "zlib", bytes->capacity, capacity, bytes->data));
    bytes->capacity = capacity;
    return PD_OK;
}

PDI_FN pd_status pdi_bytes_add(pd_ctx *ctx, pdi_bytes *bytes, const void *data, size_t size)
{
    PD_TRY(pdi_bytes_reserve(ctx, bytes, size));
    if (size) memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
    return PD_OK;
}

PDI_FN void pdi_bytes_free(pd_ctx *ctx, pdi_bytes *bytes)
{
    PD_DELETE(ctx, bytes->capacity, bytes->data);
    bytes->size = bytes->capacity = 0;
}

/* CRC-32 register after the eight bits of a byte: remainder for the reflected polynomial 0xEDB88320. */
static uint32_t pdi_zlib_crc32_byte(uint32_t byte)
{
    for (int bit = 0; bit < 8; bit++) byte = (byte >> 1) ^ (0xEDB88320u & (0u - (byte & 1u)));
    return byte;
}

/* Read a 32-bit little-endian number. */
static uint32_t pdi_zlib_get_u32(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Update the CRC-32 register (complement of the CRC) with data[8 * words], eight bytes at a time (slicing by 8:
 * Kounavis and Berry, IEEE Trans. Comput. 57 (2008), 1550). */
static uint32_t pdi_zlib_crc32_words(uint32_t crc, const uint8_t *data, size_t words)
{
    uint32_t table[8][256];
    for (uint32_t b = 0; b < 256; b++) {
        table[0][b] = pdi_zlib_crc32_byte(b);
        for (int k = 1; k < 8; k++) table[k][b] = table[k - 1][b] >> 8 ^ pdi_zlib_crc32_byte(table[k - 1][b] & 255);
    }
    for (; words; words--, data += 8) {
        uint32_t first = crc ^ pdi_zlib_get_u32(data), last = pdi_zlib_get_u32(data + 4);
        crc = 0;
        for (int k = 0; k < 4; k++)
            crc ^= table[7 - k][first >> 8 * k & 255] ^ table[3 - k][last >> 8 * k & 255];
    }
    return crc;
}

PDI_FN uint32_t pdi_zlib_crc32(uint32_t crc, const uint8_t *data, size_t size)
{
    size_t words = size < PDI_ZLIB_CRC_TABLE_SIZE ? 0 : size / 8;
    crc = ~crc;
    if (words) crc = pdi_zlib_crc32_words(crc, data, words);
    for (size_t i = 8 * words; i < size; i++) crc = crc >> 8 ^ pdi_zlib_crc32_byte((crc ^ data[i]) & 255);
    return ~crc;
}

PDI_FN uint32_t pdi_zlib_adler32(const uint8_t *data, size_t size)
{
    enum { lanes = 16 };
    uint32_t a = 1, b = 0;
    while (size) {
        /* 5552: the longest run whose sums fit 32 bits */
        uint32_t n = size < 5552 ? (uint32_t)size : 5552, rows = n / lanes, sum[lanes] = {0}, ramp[lanes] = {0};
        uint64_t more = 0; /* what the bytes add to b beside the running sum a */
        uint32_t all = 0;
        size -= n;
        b += (uint32_t)((uint64_t)n * a % 65521);
        for (uint32_t row = 0; row < rows; row++, data += lanes)
            for (int l = 0; l < lanes; l++) {
                ramp[l] += sum[l];
                sum[l] += data[l];
            }
        for (uint32_t l = 0; l < lanes; l++) {
            all += sum[l];
            more += (uint64_t)lanes * ramp[l] + (uint64_t)(n - lanes * (rows - 1) - l) * sum[l];
        }
        for (uint32_t left = n - lanes * rows; left; left--, data++) {
            all += *data;
            more += left * *data;
        }
        b = (uint32_t)((b + more) % 65521);
        a = (a + all) % 65521;
    }
    return b << 16 | a;
}

/* ---- compression ---- */

/* [byte] Largest output of a chunk: 17 blocks at most, none longer than stored (fixed codes: 31 bits a symbol). */
#define PDI_ZLIB_OUTPUT_SIZE (PDI_ZLIB_CHUNK_SIZE + 256)

typedef struct pdi_zlib_writer {
    int32_t head[PDI_ZLIB_WINDOW]; /* last position with this hash, -1: none */
    int32_t prev[PDI_ZLIB_WINDOW]; /* the one before, by position modulo the window */
    uint32_t symbols[PDI_ZLIB_BLOCK_SYMBOLS]; /* literal, or distance << 16 | length */
    int symbol_count;
    size_t block_start;
    uint32_t literal_freq[PDI_ZLIB_LITERALS + 2], distance_freq[PDI_ZLIB_DISTANCES];
    uint64_t bits; /* bits that do not fill a byte yet */
    int bit_count;
    uint8_t out[PDI_ZLIB_OUTPUT_SIZE];
    size_t used; /* [byte] of out */
    const uint8_t *data;
    size_t start, size; /* begin and end of the chunk in data */
    uint32_t adler;
} pdi_zlib_writer;

typedef struct pdi_zlib_codes {
    uint8_t literal_len[PDI_ZLIB_LITERALS + 2], distance_len[PDI_ZLIB_DISTANCES];
    uint16_t literal[PDI_ZLIB_LITERALS + 2], distance[PDI_ZLIB_DISTANCES];
} pdi_zlib_codes;

/* A length or distance as its code and extra bits (RFC 1951, 3.2.5). */
typedef struct pdi_zlib_coded_value {
    int code, extra_bits;
    uint32_t extra;
} pdi_zlib_coded_value;

/* Largest k with 2^k <= x; x > 0. */
static int pdi_zlib_log2(uint32_t x)
{
    int n = 0;
    while (x >>= 1) n++;
    return n;
}

/* Code 257..285 and extra bits of a match length 3..258: four codes have the same number of extra bits. */
static pdi_zlib_coded_value pdi_zlib_length_code(uint32_t length)
{
    pdi_zlib_coded_value s = {0, 0, 0};
    uint32_t x = length - 3;
    if (length == PDI_ZLIB_MAX_MATCH) s.code = 285;
    else if (x < 8) s.code = 257 + (int)x;
    else {
        int n = pdi_zlib_log2(x);
        s.code = 257 + 4 * (n - 1) + (int)((x >> (n - 2)) & 3);
        s.extra_bits = n - 2;
        s.extra = x & ((1u << (n - 2)) - 1);
    }
    return s;
}

/* Code 0..29 and extra bits of a distance 1..32768: two codes have the same number of extra bits. */
static pdi_zlib_coded_value pdi_zlib_distance_code(uint32_t distance)
{
    pdi_zlib_coded_value s = {0, 0, 0};
    uint32_t x = distance - 1;
    if (x < 4) s.code = (int)x;
    else {
        int n = pdi_zlib_log2(x);
        s.code = 2 * n + (int)((x >> (n - 1)) & 1);
        s.extra_bits = n - 1;
        s.extra = x & ((1u << (n - 1)) - 1);
    }
    return s;
}

/* Write a value of `count` bits, lowest first; its higher bits are 0. */
static void pdi_zlib_write_bits(pdi_zlib_writer *s, uint32_t value, int count)
{
    s->bits |= (uint64_t)value << s->bit_count;
    s->bit_count += count;
    while (s->bit_count >= 8) {
        s->out[s->used++] = (uint8_t)s->bits;
        s->bits >>= 8;
        s->bit_count -= 8;
    }
}

/* Code lengths[n] of a Huffman tree for freq[n] by the two-queue method, 0 for symbols that do not occur. Returns the
 * longest. At least two symbols must occur. */
static int pdi_zlib_huffman_lengths(const uint32_t *freq, int n, uint8_t *lengths)
{
    int order[PDI_ZLIB_LITERALS + 2], parent[2 * (PDI_ZLIB_LITERALS + 2)], depth[2 * (PDI_ZLIB_LITERALS + 2)];
    uint64_t weight[2 * (PDI_ZLIB_LITERALS + 2)];
    int leaves = 0, longest = 0;
    for (int i = 0; i < n; i++) {
        lengths[i] = 0;
        if (!freq[i]) continue;
        int k = leaves++;
        for (; k > 0 && freq[order[k - 1]] > freq[i]; k--) order[k] = order[k - 1];
        order[k] = i;
    }
    for (int i = 0; i < leaves; i++) weight[i] = freq[order[i]];
    int leaf = 0, inner = leaves, total = leaves;
    for (; total < 2 * leaves - 1; total++) {
        weight[total] = 0;
        for (int k = 0; k < 2; k++) {
            int take_leaf = leaf < leaves && (inner >= total || weight[leaf] <= weight[inner]);
            int child = take_leaf ? leaf++ : inner++;
            weight[total] += weight[child];
            parent[child] = total;
        }
    }
    depth[total - 1] = 0;
    for (int i = total - 2; i >= 0; i--) {
        depth[i] = depth[parent[i]] + 1;
        if (i < leaves) {
            lengths[order[i]] = (uint8_t)depth[i];
            if (depth[i] > longest) longest = depth[i];
        }
    }
    return longest;
}

/* Code lengths[n] of at most `limit` bits for at least two symbols. freq[n] is changed: symbols are added where fewer
 * than two occur, and frequencies are flattened until the tree is shallow enough. */
static void pdi_zlib_limit_lengths(uint32_t *freq, int n, int limit, uint8_t *lengths)
{
    int used = 0;
    for (int i = 0; i < n; i++) used += freq[i] != 0;
    /* Some readers refuse a set with fewer than two codes. */
    for (int i = 0; used < 2; i++)
        if (!freq[i]) {
            freq[i] = 1;
            used++;
        }
    while (pdi_zlib_huffman_lengths(freq, n, lengths) > limit)
        for (int i = 0; i < n; i++)
            if (freq[i]) freq[i] = freq[i] / 4 + 1;
}

/* Canonical Huffman codes from their lengths (RFC 1951, 3.2.2), bit-reversed as they are sent. */
static void pdi_zlib_set_codes(const uint8_t *lengths, int n, uint16_t *codes)
{
    uint32_t count[16] = {0}, next[16] = {0};
    for (int i = 0; i < n; i++) count[lengths[i]]++;
    count[0] = 0;
    for (int l = 1; l < 16; l++) next[l] = (next[l - 1] + count[l - 1]) << 1;
    for (int i = 0; i < n; i++) {
        uint32_t code = lengths[i] ? next[lengths[i]]++ : 0, reversed = 0;
        /* bit by bit: independent shifts of each bit become vectors, which clang 14 gets wrong for wasm at -Os */
        for (int b = 0; b < lengths[i]; b++) reversed = reversed << 1 | (code >> b & 1);
        codes[i] = (uint16_t)reversed;
    }
}

/* The fixed codes of RFC 1951, 3.2.6. */
static void pdi_zlib_set_fixed_codes(pdi_zlib_codes *codes)
{
    for (int i = 0; i < 288; i++) codes->literal_len[i] = (uint8_t)(i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8);
    memset(codes->distance_len, 5, sizeof codes->distance_len);
    pdi_zlib_set_codes(codes->literal_len, 288, codes->literal);
    pdi_zlib_set_codes(codes->distance_len, PDI_ZLIB_DISTANCES, codes->distance);
}

/* Number of bits of the symbols of the current block with these codes, without extra bits. */
static uint64_t pdi_zlib_count_bits(const pdi_zlib_writer *s, const pdi_zlib_codes *codes)
{
    uint64_t bits = 0;
    for (int i = 0; i < PDI_ZLIB_LITERALS; i++) bits += (uint64_t)s->literal_freq[i] * codes->literal_len[i];
    for (int i = 0; i < PDI_ZLIB_DISTANCES; i++) bits += (uint64_t)s->distance_freq[i] * codes->distance_len[i];
    return bits; /* the extra bits are the same for every code set */
}

/* The header of a dynamic block: its two sets of lengths, run-length coded. */
typedef struct pdi_zlib_header {
    uint8_t token[PDI_ZLIB_LITERALS + PDI_ZLIB_DISTANCES], extra[PDI_ZLIB_LITERALS + PDI_ZLIB_DISTANCES];
    int token_count, literals, distances, listed;
    uint8_t length[PDI_ZLIB_LENGTH_CODES];
    uint16_t code[PDI_ZLIB_LENGTH_CODES];
    uint64_t bits;
} pdi_zlib_header;

/* Number of extra bits of a code-length symbol (RFC 1951, 3.2.7). */
static int pdi_zlib_token_bits(int token) { return token == 16 ? 2 : token == 17 ? 3 : token == 18 ? 7 : 0; }

/* Run-length code the code lengths[n] of a dynamic block (RFC 1951, 3.2.7) into token and extra of the header. */
static void pdi_zlib_encode_lengths(const uint8_t *lengths, int n, pdi_zlib_header *header)
{
    header->token_count = 0;
    for (int i = 0; i < n;) {
        int run = 1, token = lengths[i], extra = 0, most = lengths[i] ? 6 : 138;
        int repeats = i > 0 && lengths[i] && lengths[i] == lengths[i - 1]; /* 16 copies the length before it */
        while (i + run < n && run < most && lengths[i + run] == lengths[i]) run++;
        if (!lengths[i] && run >= 3) {
            token = run < 11 ? 17 : 18;
            extra = run - (run < 11 ? 3 : 11);
        } else if (repeats && run >= 3) {
            token = 16;
            extra = run - 3;
        } else run = 1;
        header->token[header->token_count] = (uint8_t)token;
        header->extra[header->token_count++] = (uint8_t)extra;
        i += run;
    }
}

/* Prepare the header of a dynamic block with these code lengths, and count its bits, without the three of the block
 * type. */
static void pdi_zlib_plan_header(const pdi_zlib_codes *codes, pdi_zlib_header *header)
{
    uint8_t all[PDI_ZLIB_LITERALS + PDI_ZLIB_DISTANCES];
    uint32_t freq[PDI_ZLIB_LENGTH_CODES] = {0};
    header->literals = PDI_ZLIB_LITERALS;
    header->distances = PDI_ZLIB_DISTANCES;
    while (header->literals > 257 && !codes->literal_len[header->literals - 1]) header->literals--;
    while (header->distances > 1 && !codes->distance_len[header->distances - 1]) header->distances--;
    memcpy(all, codes->literal_len, (size_t)header->literals);
    memcpy(all + header->literals, codes->distance_len, (size_t)header->distances);
    pdi_zlib_encode_lengths(all, header->literals + header->distances, header);
    for (int i = 0; i < header->token_count; i++) freq[header->token[i]]++;
    pdi_zlib_limit_lengths(freq, PDI_ZLIB_LENGTH_CODES, 7, header->length);
    pdi_zlib_set_codes(header->length, PDI_ZLIB_LENGTH_CODES, header->code);
    header->listed = PDI_ZLIB_LENGTH_CODES;
    while (header->listed > 4 && !header->length[pdi_zlib_length_order[header->listed - 1]]) header->listed--;
    header->bits = 14 + 3 * (uint64_t)header->listed;
    for (int i = 0; i < header->token_count; i++)
        header->bits += (uint64_t)(header->length[header->token[i]] + pdi_zlib_token_bits(header->token[i]));
}

/* Write the header of a block with codes of its own, behind its type (RFC 1951, 3.2.7). */
static void pdi_zlib_write_header(pdi_zlib_writer *s, const pdi_zlib_header *header)
{
    pdi_zlib_write_bits(s, (uint32_t)(header->literals - 257), 5);
    pdi_zlib_write_bits(s, (uint32_t)(header->distances - 1), 5);
    pdi_zlib_write_bits(s, (uint32_t)(header->listed - 4), 4);
    for (int i = 0; i < header->listed; i++) pdi_zlib_write_bits(s, header->length[pdi_zlib_length_order[i]], 3);
    for (int i = 0; i < header->token_count; i++) {
        int token = header->token[i];
        pdi_zlib_write_bits(s, header->code[token], header->length[token]);
        pdi_zlib_write_bits(s, header->extra[i], pdi_zlib_token_bits(token));
    }
}

/* Write the symbols of the block that are collected, and the end code. */
static void pdi_zlib_write_symbols(pdi_zlib_writer *s, const pdi_zlib_codes *codes)
{
    for (int i = 0; i < s->symbol_count; i++) {
        uint32_t length = s->symbols[i] & 0xffff, distance = s->symbols[i] >> 16;
        if (!distance) {
            pdi_zlib_write_bits(s, codes->literal[length], codes->literal_len[length]);
            continue;
        }
        pdi_zlib_coded_value l = pdi_zlib_length_code(length), d = pdi_zlib_distance_code(distance);
        pdi_zlib_write_bits(s, codes->literal[l.code], codes->literal_len[l.code]);
        pdi_zlib_write_bits(s, l.extra, l.extra_bits);
        pdi_zlib_write_bits(s, codes->distance[d.code], codes->distance_len[d.code]);
        pdi_zlib_write_bits(s, d.extra, d.extra_bits);
    }
    pdi_zlib_write_bits(s, codes->literal[256], codes->literal_len[256]);
}

/* Fill up the current byte and write the next `length` bytes of the input, at most 65535, as a stored block, behind its
 * type. block_start stays. */
static void pdi_zlib_write_stored(pdi_zlib_writer *s, size_t length)
{
    if (s->bit_count) pdi_zlib_write_bits(s, 0, 8 - s->bit_count);
    pdi_zlib_write_bits(s, (uint32_t)length, 16);
    pdi_zlib_write_bits(s, ~(uint32_t)length & 0xffff, 16);
    if (length) memcpy(s->out + s->used, s->data + s->block_start, length);
    s->used += length;
}

/* End the current block and write it as the shortest of the three kinds, then begin an empty one at `end`, the input
 * position behind it. Stored: only below 65536 bytes, and where that is shorter than both codes; fixed codes: also
 * where the dynamic ones are as short. last 1: final block. Resets frequencies and symbols. */
static void pdi_zlib_write_block(pdi_zlib_writer *s, size_t end, int last)
{
    pdi_zlib_codes dynamic, fixed;
    pdi_zlib_header header;
    size_t length = end - s->block_start;
    s->literal_freq[256] = 1;
    pdi_zlib_set_fixed_codes(&fixed);
    uint64_t fixed_bits = pdi_zlib_count_bits(s, &fixed), stored_bits = ((uint64_t)length + 5) * 8, extra_bits = 0;
    for (int i = 0; i < PDI_ZLIB_LITERALS; i++)
        if (i >= 265 && i < 285) extra_bits += (uint64_t)s->literal_freq[i] * (uint64_t)((i - 261) / 4);
    for (int i = 4; i < PDI_ZLIB_DISTANCES; i++)
        extra_bits += (uint64_t)s->distance_freq[i] * (uint64_t)(i / 2 - 1);
    uint32_t literal_freq[PDI_ZLIB_LITERALS], distance_freq[PDI_ZLIB_DISTANCES];
    memcpy(literal_freq, s->literal_freq, sizeof literal_freq);
    memcpy(distance_freq, s->distance_freq, sizeof distance_freq);
    pdi_zlib_limit_lengths(literal_freq, PDI_ZLIB_LITERALS, 15, dynamic.literal_len);
    pdi_zlib_limit_lengths(distance_freq, PDI_ZLIB_DISTANCES, 15, dynamic.distance_len);
    pdi_zlib_set_codes(dynamic.literal_len, PDI_ZLIB_LITERALS, dynamic.literal);
    pdi_zlib_set_codes(dynamic.distance_len, PDI_ZLIB_DISTANCES, dynamic.distance);
    pdi_zlib_plan_header(&dynamic, &header);
    uint64_t dynamic_bits = pdi_zlib_count_bits(s, &dynamic) + header.bits;
    uint64_t coded_bits = (dynamic_bits < fixed_bits ? dynamic_bits : fixed_bits) + extra_bits;
    pdi_zlib_write_bits(s, (uint32_t)last, 1);
    if (length < 65536 && stored_bits < coded_bits) {
        pdi_zlib_write_bits(s, 0, 2);
        pdi_zlib_write_stored(s, length);
    } else if (fixed_bits <= dynamic_bits) {
        pdi_zlib_write_bits(s, 1, 2);
        pdi_zlib_write_symbols(s, &fixed);
    } else {
        pdi_zlib_write_bits(s, 2, 2);
        pdi_zlib_write_header(s, &header);
        pdi_zlib_write_symbols(s, &dynamic);
    }
    memset(s->literal_freq, 0, sizeof s->literal_freq);
    memset(s->distance_freq, 0, sizeof s->distance_freq);
    s->symbol_count = 0;
    s->block_start = end;
    PD_ASSERT(s->used + 8 <= PDI_ZLIB_OUTPUT_SIZE);
}

/* Enter a position of the input into the chain of the hash of its three bytes; nothing where fewer than three are
 * left. */
static void pdi_zlib_insert_position(pdi_zlib_writer *s, size_t pos)
{
    if (pos + 3 > s->size) return;
    uint32_t key = (uint32_t)s->data[pos] | (uint32_t)s->data[pos + 1] << 8 | (uint32_t)s->data[pos + 2] << 16;
    uint32_t hash = (key * 0x9E3779B1u) >> 17;
    s->prev[pos % PDI_ZLIB_WINDOW] = s->head[hash];
    s->head[hash] = (int32_t)pos;
}

/* Number of equal bytes at the start of two sequences, at most max_length. */
static uint32_t pdi_zlib_count_equal(const uint8_t *here, const uint8_t *there, uint32_t max_length)
{
    uint32_t length = 0;
    for (uint64_t a, b; length + sizeof a <= max_length; length += (uint32_t)sizeof a) {
        memcpy(&a, here + length, sizeof a);
        memcpy(&b, there + length, sizeof b);
        if (a != b) break;
    }
    while (length < max_length && there[length] == here[length]) length++;
    return length;
}

/* Longest match of at least 3 bytes for the position just inserted, among the PDI_ZLIB_MAX_CHAIN latest positions of
 * its hash chain within the window; the nearest among equal ones, and none of 3 bytes farther than 4096. Returns its
 * length, and *distance; 0: none. */
static uint32_t pdi_zlib_find_match(const pdi_zlib_writer *s, size_t position, uint32_t *distance)
{
    uint32_t best = 2, max_length = PDI_ZLIB_MAX_MATCH;
    if (position + 3 > s->size) return 0;
    if (s->size - position < max_length) max_length = (uint32_t)(s->size - position);
    const uint8_t *here = s->data + position;
    int32_t candidate = s->prev[position % PDI_ZLIB_WINDOW];
    for (int tries = 0; tries < PDI_ZLIB_MAX_CHAIN && candidate >= 0; tries++) {
        if (position - (size_t)candidate > PDI_ZLIB_WINDOW - 1) break;
        const uint8_t *there = s->data + candidate;
        if (there[best] == here[best]) {
            uint32_t length = pdi_zlib_count_equal(here, there, max_length);
            if (length > best) {
                best = length;
                *distance = (uint32_t)(position - (size_t)candidate);
                if (best == max_length) break;
            }
        }
        int32_t older = s->prev[(size_t)candidate % PDI_ZLIB_WINDOW];
        if (older >= candidate) break; /* the slot was taken over by a newer position */
        candidate = older;
    }
    /* Three bytes from far away cost more than three literals. */
    return best < 3 || (best == 3 && *distance > 4096) ? 0 : best;
}

/* Collect a copy, or a literal (distance 0: the byte `length`). Writes the block up to `end` where it is full. */
static void pdi_zlib_add_symbol(pdi_zlib_writer *s, uint32_t length, uint32_t distance, size_t end)
{
    s->symbols[s->symbol_count++] = distance << 16 | length;
    if (distance) {
        s->literal_freq[pdi_zlib_length_code(length).code]++;
        s->distance_freq[pdi_zlib_distance_code(distance).code]++;
    } else s->literal_freq[length]++;
    if (s->symbol_count == PDI_ZLIB_BLOCK_SYMBOLS) pdi_zlib_write_block(s, end, 0);
}

/* Compress a chunk: LZ77 with one step of lazy matching. A match is taken where none at the next position is longer
 * (from PDI_ZLIB_GOOD_MATCH on without looking), else a literal. The last block stays open. */
static void pdi_zlib_compress(pdi_zlib_writer *s)
{
    size_t at = s->start;
    uint32_t length = 0, distance = 0;
    if (at < s->size) {
        pdi_zlib_insert_position(s, at);
        length = pdi_zlib_find_match(s, at, &distance);
    }
    while (at < s->size) {
        uint32_t next = 0, next_distance = 0;
        if (at + 1 < s->size) {
            pdi_zlib_insert_position(s, at + 1);
            if (length < PDI_ZLIB_GOOD_MATCH) next = pdi_zlib_find_match(s, at + 1, &next_distance);
        }
        if (length >= 3 && length >= next) {
            pdi_zlib_add_symbol(s, length, distance, at + length);
            for (uint32_t k = length < PDI_ZLIB_GOOD_MATCH ? 2 : length - PDI_ZLIB_MATCH_END_SIZE; k < length; k++)
                pdi_zlib_insert_position(s, at + k);
            at += length;
            length = 0;
            if (at < s->size) {
                pdi_zlib_insert_position(s, at);
                length = pdi_zlib_find_match(s, at, &distance);
            }
        } else {
            pdi_zlib_add_symbol(s, s->data[at], 0, at + 1);
            at++;
            length = next;
            distance = next_distance;
        }
    }
}

/* Compress chunk k of data[size] into s->out, and compute its Adler-32; the writer starts with empty hash chains and
 * output. All but the last one end with an empty stored block, and so with a whole byte. */
static void pdi_zlib_deflate_chunk(pdi_zlib_writer *s, const uint8_t *data, size_t size, size_t k)
{
    int last = size - k * PDI_ZLIB_CHUNK_SIZE <= PDI_ZLIB_CHUNK_SIZE;
    memset(s->head, 0xff, sizeof s->head);
    s->used = 0;
    s->bit_count = 0;
    s->bits = 0;
    s->data = data;
    s->block_start = s->start = k * PDI_ZLIB_CHUNK_SIZE;
    s->size = last ? size : s->start + PDI_ZLIB_CHUNK_SIZE;
    for (size_t at = k ? s->start - PDI_ZLIB_LOOKBACK : 0; at < s->start; at++) pdi_zlib_insert_position(s, at);
    pdi_zlib_compress(s);
    if (last || s->symbol_count) pdi_zlib_write_block(s, s->size, last);
    if (!last) pdi_zlib_write_bits(s, 0, 3);
    if (!last) pdi_zlib_write_stored(s, 0);
    else if (s->bit_count) pdi_zlib_write_bits(s, 0, 8 - s->bit_count);
    s->adler = pdi_zlib_adler32(data + s->start, s->size - s->start);
}

/* Adler-32 of two sequences from that of each; size [byte] of the second one. */
static uint32_t pdi_zlib_combine_adler32(uint32_t adler, uint32_t more, size_t size)
{
    uint32_t a = adler & 0xffff, b = adler >> 16, n = (uint32_t)(size % 65521);
    b = (uint32_t)((b + (more >> 16) + (uint64_t)n * (a + 65520)) % 65521); /* each byte adds a, and has counted 1 */
    a = (a + (more & 0xffff) + 65520) % 65521;
    return b << 16 | a;
}

/* Compress all chunks in parallel, as many at a time as there are writers, and append them and the Adler-32 to out. */
static pd_status pdi_zlib_deflate_chunks(pd_ctx *ctx, pdi_zlib_writer *writer, int writers, const uint8_t *data,
                                         size_t size, pdi_bytes *out)
{
    size_t pieces = size ? (size - 1) / PDI_ZLIB_CHUNK_SIZE + 1 : 1;
    uint32_t adler = 1;
    for (size_t k = 0; k < pieces; k += (size_t)writers) {
        int count = pieces - k < (size_t)writers ? (int)(pieces - k) : writers;
        PD_PARALLEL_FOR(writers)
        for (int w = 0; w < count; w++) pdi_zlib_deflate_chunk(&writer[w], data, size, k + (size_t)w);
        for (int w = 0; w < count; w++) {
            PD_TRY(pdi_bytes_add(ctx, out, writer[w].out, writer[w].used));
            adler = pdi_zlib_combine_adler32(adler, writer[w].adler, writer[w].size - writer[w].start);
        }
    }
    uint8_t tail[4] = {(uint8_t)(adler >> 24), (uint8_t)(adler >> 16), (uint8_t)(adler >> 8), (uint8_t)adler};
    return pdi_bytes_add(ctx, out, tail, sizeof tail);
}

PDI_FN pd_status pdi_zlib_deflate(pd_ctx *ctx, const uint8_t *data, size_t size, pdi_bytes *out)
{
    static const uint8_t zlib_head[2] = {0x78, 0x9C}; /* deflate, 32 KiB window, default effort */
    if (size > (size_t)1 << 30)
        return pd_fail(ctx, PD_ERR_SIZE, "zlib", "%.0f bytes are too many for one stream", (double)size);
    PD_TRY(pdi_bytes_add(ctx, out, zlib_head, sizeof zlib_head));
    int pieces = (int)(size / PDI_ZLIB_CHUNK_SIZE) + 1, writers = pd_par_threads(ctx, (int64_t)size);
    if (writers > PDI_ZLIB_MAX_THREADS) writers = PDI_ZLIB_MAX_THREADS;
    if (writers > pieces) writers = pieces;
    pdi_zlib_writer *writer = NULL;
    PD_TRY(PD_NEW(ctx, "zlib", writers, writer));
    pd_status status = pdi_zlib_deflate_chunks(ctx, writer, writers, data, size, out);
    PD_DELETE(ctx, writers, writer);
    return status;
}

/* ---- decompression ---- */

typedef struct pdi_zlib_reader {
    const uint8_t *data;
    size_t size, position; /* [byte] length of data, and position */
    uint32_t bits;
    int bit_count;
    uint8_t *out;
    size_t out_size, out_position;
    const char *error; /* NULL: none so far */
} pdi_zlib_reader;

/* A canonical code set: how many codes of each length, and the symbols in the order of their codes. */
typedef struct pdi_zlib_decoder {
    int count[16];
    int symbol[PDI_ZLIB_FIXED_CODES];
} pdi_zlib_decoder;

PDI_COLD_BEGIN
/* Keep a text as the error, unless there is one already. Returns 0. */
static int pdi_zlib_set_error(pdi_zlib_reader *s, const char *text)
{
    if (!s->error) s->error = text;
    return 0;
}

/* Read `count` bits, lowest first; 0 and an error beyond the end of the input. */
static uint32_t pdi_zlib_read_bits(pdi_zlib_reader *s, int count)
{
    while (s->bit_count < count) {
        if (s->position >= s->size) {
            pdi_zlib_set_error(s, "the compressed data end early");
            return 0;
        }
        s->bits |= (uint32_t)s->data[s->position++] << s->bit_count;
        s->bit_count += 8;
    }
    uint32_t value = s->bits & ((1u << count) - 1);
    s->bits >>= count;
    s->bit_count -= count;
    return value;
}

/* Build a decoder from the code lengths[n]. Returns 1 for a complete code; single 1: also for no code, or a single code
 * of one bit. Else 0: more codes than the lengths allow, or fewer. */
static int pdi_zlib_build_decoder(pdi_zlib_decoder *codes, const uint8_t *lengths, int n, int single)
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

/* Decode the next symbol; -1: an error is set. */
static int pdi_zlib_read_symbol(pdi_zlib_reader *s, const pdi_zlib_decoder *codes)
{
    int code = 0, first = 0, index = 0;
    for (int l = 1; l < 16; l++) {
        code |= (int)pdi_zlib_read_bits(s, 1);
        if (s->error) return -1;
        int count = codes->count[l];
        if (code - count < first) return codes->symbol[index + (code - first)];
        index += count;
        first = (first + count) << 1;
        code <<= 1;
    }
    pdi_zlib_set_error(s, "a code that was not defined");
    return -1;
}

/* Append a copy of `length` bytes that begin `distance` before the end of the output. Returns 1; 0: an error is set. */
static int pdi_zlib_read_copy(pdi_zlib_reader *s, uint32_t length, uint32_t distance)
{
    if (distance > s->out_position) return pdi_zlib_set_error(s, "a reference to before the start of the data");
    if (length > s->out_size - s->out_position) return pdi_zlib_set_error(s, "more data than the picture holds");
    for (uint32_t i = 0; i < length; i++, s->out_position++)
        s->out[s->out_position] = s->out[s->out_position - distance];
    return 1;
}

/* Read the symbols of a block up to its end code into the output. Returns 1; 0: an error is set. */
static int pdi_zlib_read_coded(pdi_zlib_reader *s, const pdi_zlib_decoder *literals,
                               const pdi_zlib_decoder *distances)
{
    for (;;) {
        int symbol = pdi_zlib_read_symbol(s, literals);
        if (symbol < 0) return 0;
        if (symbol == 256) return 1;
        if (symbol < 256) {
            if (s->out_position >= s->out_size) return pdi_zlib_set_error(s, "more data than the picture holds");
            s->out[s->out_position++] = (uint8_t)symbol;
            continue;
        }
        if (symbol > 285) return pdi_zlib_set_error(s, "a length code that does not exist");
        int k = symbol - 257, extra = k < 8 || k == 28 ? 0 : k / 4 - 1;
        uint32_t length = k == 28 ? 258u : k < 8 ? (uint32_t)k + 3 : (4u + (uint32_t)(k & 3)) << extra;
        if (k >= 8 && k < 28) length += 3 + pdi_zlib_read_bits(s, extra);
        k = pdi_zlib_read_symbol(s, distances);
        if (k < 0) return 0;
        if (k > 29) return pdi_zlib_set_error(s, "a distance code that does not exist");
        extra = k < 4 ? 0 : k / 2 - 1;
        uint32_t distance = k < 4 ? (uint32_t)k + 1 : ((2u + (uint32_t)(k & 1)) << extra) + 1;
        distance += pdi_zlib_read_bits(s, extra);
        if (s->error || !pdi_zlib_read_copy(s, length, distance)) return 0;
    }
}

/* Read a stored block from the next whole byte on. Returns 1; 0: an error is set. */
static int pdi_zlib_read_stored(pdi_zlib_reader *s)
{
    s->bits = 0; /* to the next whole byte; fewer than 8 bits are ever held */
    s->bit_count = 0;
    uint32_t length = pdi_zlib_read_bits(s, 16), check = pdi_zlib_read_bits(s, 16);
    if (s->error) return 0;
    if (length != (~check & 0xffff)) return pdi_zlib_set_error(s, "a stored block with a wrong length check");
    if (length > s->size - s->position) return pdi_zlib_set_error(s, "the compressed data end early");
    if (length > s->out_size - s->out_position) return pdi_zlib_set_error(s, "more data than the picture holds");
    if (length) memcpy(s->out + s->out_position, s->data + s->position, length);
    s->position += length;
    s->out_position += length;
    return 1;
}

/* Read a block with the fixed codes. Returns 1; 0: an error is set. */
static int pdi_zlib_read_fixed(pdi_zlib_reader *s)
{
    pdi_zlib_decoder literals, distances;
    uint8_t lengths[PDI_ZLIB_FIXED_CODES];
    for (int i = 0; i < PDI_ZLIB_FIXED_CODES; i++) lengths[i] = (uint8_t)(i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8);
    pdi_zlib_build_decoder(&literals, lengths, PDI_ZLIB_FIXED_CODES, 0);
    memset(lengths, 5, 32);
    pdi_zlib_build_decoder(&distances, lengths, 32, 0);
    return pdi_zlib_read_coded(s, &literals, &distances);
}

/* Read the run-length coded code lengths[n] of both code sets, one behind the other. Returns 1; 0: an error is set. */
static int pdi_zlib_read_lengths(pdi_zlib_reader *s, const pdi_zlib_decoder *codes, uint8_t *lengths, int n)
{
    for (int i = 0; i < n;) {
        int symbol = pdi_zlib_read_symbol(s, codes), run = 1;
        uint8_t value = 0;
        if (symbol < 0) return 0;
        if (symbol < 16) value = (uint8_t)symbol;
        else if (symbol == 16) {
            if (i == 0) return pdi_zlib_set_error(s, "a repeated code length without a first one");
            value = lengths[i - 1];
            run = 3 + (int)pdi_zlib_read_bits(s, 2);
        } else run = symbol == 17 ? 3 + (int)pdi_zlib_read_bits(s, 3) : 11 + (int)pdi_zlib_read_bits(s, 7);
        if (s->error) return 0;
        if (run > n - i) return pdi_zlib_set_error(s, "too many code lengths");
        while (run--) lengths[i++] = value;
    }
    return 1;
}

/* Read a block with codes of its own. Returns 1; 0: an error is set. */
static int pdi_zlib_read_dynamic(pdi_zlib_reader *s)
{
    pdi_zlib_decoder literals, distances;
    uint8_t lengths[PDI_ZLIB_FIXED_CODES + 32] = {0};
    int literal_count = 257 + (int)pdi_zlib_read_bits(s, 5), distance_count = 1 + (int)pdi_zlib_read_bits(s, 5);
    int listed = 4 + (int)pdi_zlib_read_bits(s, 4);
    if (literal_count > PDI_ZLIB_LITERALS || distance_count > PDI_ZLIB_DISTANCES)
        return pdi_zlib_set_error(s, "a block with too many codes");
    for (int i = 0; i < listed; i++) lengths[pdi_zlib_length_order[i]] = (uint8_t)pdi_zlib_read_bits(s, 3);
    if (s->error) return 0;
    if (!pdi_zlib_build_decoder(&literals, lengths, PDI_ZLIB_LENGTH_CODES, 0))
        return pdi_zlib_set_error(s, "a block with an impossible set of codes");
    memset(lengths, 0, sizeof lengths);
    if (!pdi_zlib_read_lengths(s, &literals, lengths, literal_count + distance_count)) return 0;
    if (!lengths[256]) return pdi_zlib_set_error(s, "a block without an end code");
    if (!pdi_zlib_build_decoder(&literals, lengths, literal_count, 1) ||
        !pdi_zlib_build_decoder(&distances, lengths + literal_count, distance_count, 1))
        return pdi_zlib_set_error(s, "a block with an impossible set of codes");
    return pdi_zlib_read_coded(s, &literals, &distances);
}

/* Read all blocks of a stream into the output, verify that they fill it, and its Adler-32. s->error tells what is
 * wrong, NULL: nothing. Wrong are also another header than of deflate with a window up to 32 KiB, a preset dictionary,
 * and a block of type 3. */
static void pdi_zlib_inflate_stream(pdi_zlib_reader *s)
{
    uint32_t head = pdi_zlib_read_bits(s, 8) << 8;
    head |= pdi_zlib_read_bits(s, 8);
    if (!s->error && ((head >> 8 & 15) != 8 || head >> 12 > 7 || (head & 32) || head % 31))
        pdi_zlib_set_error(s, "not a zlib stream");
    for (uint32_t last = 0; !last && !s->error;) {
        last = pdi_zlib_read_bits(s, 1);
        uint32_t kind = pdi_zlib_read_bits(s, 2);
        if (s->error) return;
        if (kind == 0) pdi_zlib_read_stored(s);
        else if (kind == 1) pdi_zlib_read_fixed(s);
        else if (kind == 2) pdi_zlib_read_dynamic(s);
        else pdi_zlib_set_error(s, "a block of an unknown kind");
    }
    if (s->error) return;
    if (s->out_position != s->out_size) {
        pdi_zlib_set_error(s, "less data than the picture holds");
        return;
    }
    s->bits = 0;
    s->bit_count = 0;
    uint32_t adler = 0;
    for (int i = 0; i < 4; i++) adler = adler << 8 | pdi_zlib_read_bits(s, 8);
    if (!s->error && adler != pdi_zlib_adler32(s->out, s->out_size)) pdi_zlib_set_error(s, "the checksum is wrong");
}

PDI_FN pd_status pdi_zlib_inflate(pd_ctx *ctx, const char *name, const uint8_t *data, size_t size, uint8_t *out,
                                  size_t out_size)
{
    pdi_zlib_reader s;
    memset(&s, 0, sizeof s);
    s.data = data;
    s.size = size;
    s.out = out;
    s.out_size = out_size;
    pdi_zlib_inflate_stream(&s);
    if (s.error)
        return pd_fail(ctx, PD_ERR_PARSE, "zlib", "%s: damaged compressed data (%s, at byte %.0f of %.0f)", name,
                       s.error, (double)s.position, (double)size);
    return PD_OK;
}
PDI_COLD_END
