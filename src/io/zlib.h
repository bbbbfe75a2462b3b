/* zlib: compression and decompression in the zlib format (RFC 1950, RFC 1951), its checksums, a growing byte buffer.
 *
 * Compression is LZ77 over a 32 KiB window with hash chains and one step of lazy matching; each block is written with
 * dynamic or fixed Huffman codes or stored, whichever is shortest. Decompression verifies every code set, distance,
 * length and checksum, and the size of the output.
 */
#ifndef PD_ZLIB_H
#define PD_ZLIB_H
#include "core/base.h"

#ifdef PDI_APP_INTERNAL
/* A growing byte buffer. Zero-initialise. */
typedef struct pdi_bytes {
    uint8_t *data;
    size_t size, capacity;
} pdi_bytes;

/* Make room for `more` bytes behind the size, which stays, as does the content. The capacity grows to at least 1.5
 * times the size; nothing where there is room. */
PDI_FN pd_status pdi_bytes_reserve(pd_ctx *ctx, pdi_bytes *bytes, size_t more);
/* Append bytes. */
PDI_FN pd_status pdi_bytes_add(pd_ctx *ctx, pdi_bytes *bytes, const void *data, size_t size);
/* Free the buffer and set it to empty. A zeroed one is allowed. */
PDI_FN void pdi_bytes_free(pd_ctx *ctx, pdi_bytes *bytes);

/* Compress data[0..size) and append the zlib stream to out; size 0 is allowed. The stream does not depend on the number
 * of threads. PD_ERR_SIZE above 1 GiB, and nothing is appended; where memory runs out, out may hold a part. */
PDI_FN pd_status pdi_zlib_deflate(pd_ctx *ctx, const uint8_t *data, size_t size, pdi_bytes *out);
/* Decompress a zlib stream data[size] that must give exactly out[out_size], and verify its checksum; bytes behind the
 * stream are ignored. PD_ERR_PARSE: damaged, cut off, with a preset dictionary, or of another length; out may hold a
 * part then. name: of the file, for the message. */
PDI_FN pd_status pdi_zlib_inflate(pd_ctx *ctx, const char *name, const uint8_t *data, size_t size, uint8_t *out,
                                  size_t out_size);
/* Update a CRC-32 (ISO 3309) with more data; start with 0. */
PDI_FN uint32_t pdi_zlib_crc32(uint32_t crc, const uint8_t *data, size_t size);
/* Adler-32 checksum (RFC 1950) of data[size]; 1 for none. */
PDI_FN uint32_t pdi_zlib_adler32(const uint8_t *data, size_t size);
#endif

#endif
