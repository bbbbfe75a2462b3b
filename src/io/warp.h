/* warp: pictures of cells that have moved.
 *
 * A cell becomes the quadrilateral of its four corners. A corner moves by the mean of the cells that meet there and
 * hold together, so there is no gap between those, and a crack between cells opens.
 */
#ifndef PD_WARP_H
#define PD_WARP_H
#include "io/picture.h"

#ifdef PDI_INTERNAL
typedef struct pdi_warp {
    const pd_picture *still; /* the picture without displacements; magnification is not used */
    const double *move;      /* [2][nx * ny] [m] displacements as they are drawn; NaN: the cell stays */
    int (*joined)(const void *user, int cell, int other); /* do both hold together? */
    const void *user;
    double lo[2], hi[2];     /* [m] the paper; lo == hi: wide enough for all that moves */
} pdi_warp;

/* Widen lo .. hi to the box and all that moves; start with lo above hi. PD_ERR_ARGUMENT as below. */
PDI_FN pd_status pdi_warp_extent(pd_ctx *ctx, const pdi_warp *warp, double *lo, double *hi);

/* Draw into an RGB image (freed by pdi_image_free). What moves beyond the paper is not shown. Also
 * PD_ERR_ARGUMENT: displacements of more than ten times the size of the picture. */
PDI_FN pd_status pdi_warp_draw(pd_ctx *ctx, const pdi_warp *warp, pd_image *image);
/* Draw and write as pd_picture_write. */
PDI_FN pd_status pdi_warp_write(pd_ctx *ctx, const char *path, const pdi_warp *warp);
#endif

#endif
