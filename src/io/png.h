/* png: reading and writing PNG images (W3C PNG, second edition), without any other library.
 *
 * Written: 8-bit gray and RGB. Read: gray and palette of 1, 2, 4 or 8 bits, gray with alpha, RGB and RGBA of 8 bits,
 * not interlaced. Rows run from the top of the picture down.
 */
#ifndef PD_PNG_H
#define PD_PNG_H
#include "core/base.h"

#define PD_PNG_MAX_PIXELS 67108864 /* largest image that is read or written */

/* Zero-initialise. pixels[(row * width + column) * channels + c], row 0 on top; channels: 1 gray, 2 gray and alpha,
 * 3 RGB, 4 RGBA. */
typedef struct pd_image {
    int width, height, channels;
    uint8_t *pixels;
} pd_image;

#ifdef PDI_INTERNAL
PDI_FN void pdi_image_free(pd_ctx *ctx, pd_image *image);
/* Luminance 0..255 (Rec. 601 weights) of a pixel over white paper; row 0 on top. */
PDI_FN int pdi_image_gray(const pd_image *image, int column, int row);
/* Write an image with 1 or 3 channels aside and rename it. PD_ERR_ARGUMENT, PD_ERR_SIZE, PD_ERR_FILE. */
PDI_FN pd_status pdi_png_write(pd_ctx *ctx, const char *path, const pd_image *image);
/* Read an image; palettes become RGB, or RGBA when they carry transparency. PD_ERR_FILE: not readable;
 * PD_ERR_PARSE: damaged, interlaced, 16 bits a channel, too many pixels. */
PDI_FN pd_status pdi_png_read(pd_ctx *ctx, const char *path, pd_image *image);
#endif

#endif
