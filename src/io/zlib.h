/* zlib: the zlib format (RFC 1950, RFC 1951), its checksums, and a growing byte buffer.
 *
 * Compression is LZ77 over a 32 KiB window with hash chains and one step of lazy matching; each block is written with
 * dynamic or fixed Huffman codes or stored, whichever is shortest. Decompression takes nothing on trust: every code
 * set, distance, length and checksum is verified, and the output has the size that the caller demands.
 */
#ifndef PD_ZLIB_H
#define PD_ZLIB_H
#include "core/base.h"

#ifdef PDI_INTERNAL
typedef struct pdi_bytes {
    uint8_t *data;
    size_t size, capacity;
} pdi_bytes;

/* Make room for `more` bytes behind size. */
PDI_FN pd_status pdi_bytes_reserve(pd_ctx *ctx, pdi_bytes *bytes, size_t more);
PDI_FN pd_status pdi_bytes_add(pd_ctx *ctx, pdi_bytes *bytes, const void *data, size_t size);
PDI_FN void pdi_bytes_free(pd_ctx *ctx, pdi_bytes *bytes);

/* Append the zlib stream of data[0..size) to out. PD_ERR_SIZE above 1 GiB. */
PDI_FN pd_status pdi_zlib_deflate(pd_ctx *ctx, const uint8_t *data, size_t size, pdi_bytes *out);
/* Unpack a zlib stream that must give exactly out_size bytes. PD_ERR_PARSE; `name` (a file) is for the message. */
PDI_FN pd_status pdi_zlib_inflate(pd_ctx *ctx, const char *name, const uint8_t *data, size_t size, uint8_t *out,
                                  size_t out_size);
/* Running CRC-32 (ISO 3309); start with 0. */
PDI_FN uint32_t pdi_zlib_crc(uint32_t crc, const uint8_t *data, size_t size);
/* Adler-32 (RFC 1950). */
PDI_FN uint32_t pdi_zlib_adler(const uint8_t *data, size_t size);
#endif

#endif
