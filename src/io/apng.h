/* apng: animated PNG files (APNG 1.0): frames of one size. Readers that know PNG alone show the first frame.
 *
 *   pdi_apng_create(&ctx, path, count, delay, &film), pdi_apng_add_frame(&ctx, &film, &image) count times,
 *   pdi_apng_commit(&ctx, &film)
 */
#ifndef PD_APNG_H
#define PD_APNG_H
#include "io/file.h"
#include "io/png.h"

#ifdef PDI_APP_INTERNAL
/* An animated PNG while it is written. Zero-initialise. */
typedef struct pdi_apng {
    pd_file file;
    int width, height, channels;
    int frame_count, frames_written; /* number of frames in all, and of those that are written */
    int delay;         /* [ms] display time of a frame */
    uint32_t sequence_number; /* sequence number of the next fcTL or fdAT chunk */
} pdi_apng;

/* Zero `film` and open the temporary file of an animation of `count` frames (at least 1) of `delay` [ms] (1 to 6000).
 * Nothing is written yet. The last frame stays ten times as long; then the animation repeats without end.
 * PD_ERR_ARGUMENT: count or delay out of range, no path; PD_ERR_FILE. On failure there is nothing to close. */
PDI_FN pd_status pdi_apng_create(pd_ctx *ctx, const char *path, int count, int delay, pdi_apng *film);
/* Append a frame of 1 or 3 channels. The first frame writes the header, and sets the size and the number of channels
 * that all others must have. PD_ERR_ARGUMENT: another size or number of channels, one frame too many, no pixels,
 * neither 1 nor 3 channels; PD_ERR_SIZE: more than PD_PNG_MAX_PIXELS; PD_ERR_MEMORY, PD_ERR_LIMIT. A frame
 * that is refused is not counted, and the film stays as it was. PD_ERR_FILE: the film, which stays open, is
 * useless. */
PDI_FN pd_status pdi_apng_add_frame(pd_ctx *ctx, pdi_apng *film, const pd_image *image);
/* End the file and give it its final name. On failure it is closed and the temporary file deleted. PD_ERR_ARGUMENT:
 * frames are missing. */
PDI_FN pd_status pdi_apng_commit(pd_ctx *ctx, pdi_apng *film);
/* Close and delete the temporary file. A closed or zeroed animation is allowed. */
PDI_FN void pdi_apng_abandon(pdi_apng *film);
#endif

#endif
