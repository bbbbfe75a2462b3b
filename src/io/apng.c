/* apng: see apng.h */
#include "io/apng.h"
#include <string.h>

#define PDI_APNG_LAST_DELAY_FACTOR 10 /* display time of the last frame, in units of the delay */

PDI_FN pd_status pdi_apng_create(pd_ctx *ctx, const char *path, int count, int delay, pdi_apng *film)
{
    memset(film, 0, sizeof *film);
    if (count < 1 || delay < 1 || delay > 6000)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "apng", "%d images, one in %d ms, expected at least 1, and 1 to 6000 ms",
                       count, delay);
    film->frame_count = count;
    film->delay = delay;
    return pdi_file_create(ctx, path, &film->file);
}

/* Set size and channels of the film from its first image. Write the PNG header and the animation control chunk (acTL):
 * number of frames, endless repetition. */
static pd_status pdi_apng_write_header(pd_ctx *ctx, pdi_apng *film, const pd_image *image)
{
    uint8_t control[8];
    film->width = image->width;
    film->height = image->height;
    film->channels = image->channels;
    pdi_png_put_u32(control, (uint32_t)film->frame_count);
    pdi_png_put_u32(control + 4, 0); /* again and again */
    PD_TRY(pdi_png_write_header(ctx, &film->file, image));
    return pdi_png_write_chunk(ctx, &film->file, "acTL", control, sizeof control);
}

/* Write the frame control chunk (fcTL) of the next frame: size, and display time, ten times the delay for the last one.
 * Increments the sequence number. */
static pd_status pdi_apng_write_frame_control(pd_ctx *ctx, pdi_apng *film)
{
    uint8_t control[26] = {0};
    uint32_t delay =
        (uint32_t)(film->frames_written + 1 < film->frame_count ? film->delay
                                                                : PDI_APNG_LAST_DELAY_FACTOR * film->delay);
    pdi_png_put_u32(control, film->sequence_number++);
    pdi_png_put_u32(control + 4, (uint32_t)film->width);
    pdi_png_put_u32(control + 8, (uint32_t)film->height);
    pdi_png_put_u32(control + 20, delay << 16 | 1000u); /* a fraction of a second: two numbers of 16 bits */
    return pdi_png_write_chunk(ctx, &film->file, "fcTL", control, sizeof control);
}

/* Write the next frame, and the header before the first one: fcTL, and IDAT or fdAT of the compressed pixels, which a
 * sequence number precedes in fdAT. Counts the frame when all of it is written. */
static pd_status pdi_apng_write_frame(pd_ctx *ctx, pdi_apng *film, const pd_image *image, const pdi_bytes *packed)
{
    int first = film->frames_written == 0;
    if (first) PD_TRY(pdi_apng_write_header(ctx, film, image));
    PD_TRY(pdi_apng_write_frame_control(ctx, film));
    PD_TRY(pdi_png_write_chunk(ctx, &film->file, first ? "IDAT" : "fdAT", packed->data, packed->size));
    film->sequence_number += first ? 0u : 1u;
    film->frames_written++;
    return PD_OK;
}

/* The pixels are packed before anything is written: a frame for which memory is short leaves the film as it was. */
PDI_FN pd_status pdi_apng_add_frame(pd_ctx *ctx, pdi_apng *film, const pd_image *image)
{
    uint8_t number[4];
    pdi_bytes packed = {NULL, 0, 0};
    PD_TRY(pdi_png_check_image(ctx, image));
    if (film->frames_written >= film->frame_count)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "apng", "more than the %d images that were announced", film->frame_count);
    if (film->frames_written &&
        (image->width != film->width || image->height != film->height || image->channels != film->channels))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "apng", "an image of %d x %d pixels in a film of %d x %d", image->width,
                       image->height, film->width, film->height);
    pd_status status = PD_OK;
    if (film->frames_written) {
        pdi_png_put_u32(number, film->sequence_number + 1); /* its fcTL has the number before */
        status = pdi_bytes_add(ctx, &packed, number, sizeof number);
    }
    if (status == PD_OK) status = pdi_png_compress_pixels(ctx, image, &packed);
    if (status == PD_OK) status = pdi_apng_write_frame(ctx, film, image, &packed);
    pdi_bytes_free(ctx, &packed);
    return status;
}

PDI_FN pd_status pdi_apng_commit(pd_ctx *ctx, pdi_apng *film)
{
    pd_status status = PD_OK;
    if (film->frames_written != film->frame_count)
        status =
            pd_fail(ctx, PD_ERR_ARGUMENT, "apng", "%d images, expected %d", film->frames_written, film->frame_count);
    if (status == PD_OK) status = pdi_png_write_chunk(ctx, &film->file, "IEND", NULL, 0);
    if (status == PD_OK) return pdi_file_commit(ctx, &film->file);
    pdi_file_abandon(&film->file);
    return status;
}

PDI_FN void pdi_apng_abandon(pdi_apng *film) { pdi_file_abandon(&film->file); }

#undef PDI_APNG_LAST_DELAY_FACTOR
