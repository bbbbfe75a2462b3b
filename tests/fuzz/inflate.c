/* A zlib stream into a field of a size that the first two bytes give, with nothing behind its end. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    if (size < 2) return 0;
    size_t room = (size_t)data[0] << 8 | data[1];
    uint8_t *out = (uint8_t *)malloc(room ? room : 1);
    if (!out) return 0;
    fuzz_context(1000000, &ctx);
    pd_status status = pdi_zlib_inflate(&ctx, "fuzz", data + 2, size - 2, out, room);
    fuzz_settled(&ctx, status);
    free(out);
    return 0;
}
