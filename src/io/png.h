/* png: reads and writes PNG images (W3C PNG, second edition), without any other library.
 *
 * Written: 8-bit gray and RGB. Read: gray and palette of 1, 2, 4 or 8 bits, gray with alpha, RGB and RGBA of 8 bits,
 * not interlaced. Row 0 is at the top.
 */
#ifndef PD_PNG_H
#define PD_PNG_H
#include "io/file.h"
#include "io/zlib.h"

#define PD_PNG_MAX_PIXELS 67108864 /* maximum pixels of an image that is read or written */

/* An image. Zero-initialise. pixels[(row * width + column) * channels + c], row 0 on top; channels: 1 grey, 2 grey and
 * alpha, 3 RGB, 4 RGBA. */
typedef struct pd_image {
    int width, height, channels;
    uint8_t *pixels;
} pd_image;

#define pd_image_free PD_NAME(pd_image_free)
#define pd_png_write PD_NAME(pd_png_write)
#define pd_png_read PD_NAME(pd_png_read)

/* Free the pixels. A zeroed image is allowed. */
PD_API void pd_image_free(pd_ctx *ctx, pd_image *image);
/* Write an image with 1 or 3 channels to a file, through a temporary one. PD_ERR_ARGUMENT: no pixels, or another number
 * of channels; PD_ERR_SIZE: more than PD_PNG_MAX_PIXELS; PD_ERR_FILE: an older file stays. */
PD_API pd_status pd_png_write(pd_ctx *ctx, const char *path, const pd_image *image);
/* Read an image into new memory. Palettes become RGB; an alpha channel is added where they, grey or RGB have
 * transparency. PD_ERR_FILE: not readable, or above 256 MiB; PD_ERR_PARSE: damaged, interlaced, 16 bits a channel, more
 * than PD_PNG_MAX_PIXELS. The image is zeroed on failure. */
PD_API pd_status pd_png_read(pd_ctx *ctx, const char *path, pd_image *image);

#ifdef PDI_APP_INTERNAL
/* Luminance 0..255 of a pixel (Rec. 601 weights) times its opacity: transparent pixels have 0; row 0 on top. */
PDI_FN int pdi_image_get_luminance(const pd_image *image, int column, int row);
/* Parts of a PNG file, for files that hold more than one image. */
/* Write a big-endian number of four bytes. */
PDI_FN void pdi_png_put_u32(uint8_t *bytes, uint32_t value);
/* Check that an image can be written. PD_ERR_ARGUMENT: no pixels, or not 1 or 3 channels. PD_ERR_SIZE: more than
 * PD_PNG_MAX_PIXELS. */
PDI_FN pd_status pdi_png_check_image(pd_ctx *ctx, const pd_image *image);
/* Write the signature and the IHDR chunk of an image of 8 bits a channel. */
PDI_FN pd_status pdi_png_write_header(pd_ctx *ctx, pd_file *file, const pd_image *image);
/* Write a chunk with its length and CRC; type: four letters; data may be NULL where size is 0. */
PDI_FN pd_status pdi_png_write_chunk(pd_ctx *ctx, pd_file *file, const char *type, const uint8_t *data, size_t size);
/* Append an image as a whole PNG file to a buffer, behind what it holds. Errors as of pdi_png_check_image, when nothing
 * is appended; the buffer may hold a part of the file where memory runs out. */
PDI_FN pd_status pdi_png_encode(pd_ctx *ctx, const pd_image *image, pdi_bytes *out);
/* Append the filtered and compressed pixels of an image, which has been checked, to a buffer, as one zlib stream. */
PDI_FN pd_status pdi_png_compress_pixels(pd_ctx *ctx, const pd_image *image, pdi_bytes *packed);
#endif

#endif
