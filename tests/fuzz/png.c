/* A picture: read; what could be read is written and read again. The checksums of the chunks are mended first, since no
 * mutation would pass them. */
#include "fuzz.h"

static void mend(uint8_t *data, size_t size)
{
    for (size_t at = 8; at + 12 <= size;) {
        size_t length = (size_t)data[at] << 24 | (size_t)data[at + 1] << 16 | (size_t)data[at + 2] << 8 | data[at + 3];
        if (length > size - at - 12) return;
        uint32_t crc = pdi_zlib_crc32(0, data + at + 4, length + 4);
        for (int k = 0; k < 4; k++) data[at + 8 + length + (size_t)k] = (uint8_t)(crc >> (24 - 8 * k));
        at += 12 + length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    pd_image image, again;
    uint8_t *copy = (uint8_t *)malloc(size + 1);
    if (!copy) return 0;
    memcpy(copy, data, size);
    mend(copy, size);
    fuzz_context(8000000, &ctx);
    const char *path = fuzz_file(".png", copy, size);
    free(copy);
    memset(&again, 0, sizeof again);
    pd_status status = pd_png_read(&ctx, path, &image);
    if (status == PD_OK) {
        int sum = 0;
        for (int r = 0; r < image.height; r++)
            for (int c = 0; c < image.width; c++) sum += pdi_image_get_luminance(&image, c, r);
        FUZZ_EXPECT(sum >= 0);
        if (image.channels % 2 && pd_png_write(&ctx, path, &image) == PD_OK && pd_png_read(&ctx, path, &again) == PD_OK)
            FUZZ_EXPECT(memcmp(image.pixels, again.pixels, (size_t)(image.width * image.height * image.channels)) == 0);
    }
    pd_image_free(&ctx, &again);
    pd_image_free(&ctx, &image);
    fuzz_settled(&ctx, status);
    return 0;
}
