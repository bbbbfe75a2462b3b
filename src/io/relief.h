/* relief: a shaded view of a surface as a PNG or SVG with the edges of its box, a scale, bar or legend, and title. */
#ifndef PD_RELIEF_H
#define PD_RELIEF_H
#include "io/colour.h"
#include "io/shade.h"
#include "io/png.h"

#ifdef PDI_INTERNAL
/* Zero-initialise, then fill in. */
typedef struct pdi_relief {
    const pd_shade *shade;
    int coloured;           /* 1: by the values, in this range; else in the colour of metal */
    pd_map map;             /* PD_MAP_LABELS: a colour for each whole number, and a legend of those that are seen */
    int log;
    double lo, hi;          /* [-] in the unit of the label */
    const char *const *names; /* [name_count] of the labels 0, 1, ..., in the legend; NULL: their numbers */
    const uint32_t *colours;  /* [name_count] of these; NULL: those of pdi_colour_label */
    int name_count;
    const char *title, *stamp, *label; /* NULL: none */
    const char *widest;     /* stamp for which there is room; NULL: the own one */
} pdi_relief;

/* Draw into an RGB image (freed by pdi_image_free). */
PDI_FN pd_status pdi_relief_draw(pd_ctx *ctx, const pdi_relief *relief, pd_image *image);
/* Draw and write as pd_picture_write. */
PDI_FN pd_status pdi_relief_write(pd_ctx *ctx, const char *path, const pdi_relief *relief);
#endif

#endif
