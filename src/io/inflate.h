/* inflate: decompression of the zlib format (RFC 1950, RFC 1951).
 *
 * Nothing is taken on trust: every code set, distance, length and checksum is verified, and the output has the size
 * that the caller demands.
 */
#ifndef PD_INFLATE_H
#define PD_INFLATE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Unpack a zlib stream that must give exactly out_size bytes. PD_ERR_PARSE; `name` (a file) is for the message. */
PDI_FN pd_status pdi_inflate(pd_ctx *ctx, const char *name, const uint8_t *data, size_t size, uint8_t *out,
                             size_t out_size);
#endif

#endif
