/* apng: films: images of one size one after the other in a PNG file (APNG 1.0). Readers that know PNG alone show the
 * first image.
 *
 *   pdi_apng_create(&ctx, path, count, delay, &film), pdi_apng_add(&ctx, &film, &image) count times,
 *   pdi_apng_commit(&ctx, &film)
 */
#ifndef PD_APNG_H
#define PD_APNG_H
#include "io/file.h"
#include "io/png.h"

#ifdef PDI_INTERNAL
/* Zero-initialise. */
typedef struct pdi_apng {
    pd_file file;
    int width, height, channels;
    int count, done;   /* images in all and so far */
    int delay;         /* [ms] between two */
    uint32_t sequence; /* number of the next chunk of the film */
} pdi_apng;

/* Begin a film of `count` images, aside. The last one stays ten times as long; then the first one comes again.
 * PD_ERR_ARGUMENT, PD_ERR_FILE. */
PDI_FN pd_status pdi_apng_create(pd_ctx *ctx, const char *path, int count, int delay, pdi_apng *film);
/* Errors as of pdi_png_write; PD_ERR_ARGUMENT also: it is not of the size of the first one, or one too many. */
PDI_FN pd_status pdi_apng_add(pd_ctx *ctx, pdi_apng *film, const pd_image *image);
/* Put the file in place. PD_ERR_ARGUMENT: images are missing. Closed on failure, too. */
PDI_FN pd_status pdi_apng_commit(pd_ctx *ctx, pdi_apng *film);
/* Remove what was written aside. Allowed on a closed or zeroed film. */
PDI_FN void pdi_apng_abandon(pdi_apng *film);
#endif

#endif
