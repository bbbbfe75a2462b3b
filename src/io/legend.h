/* legend: the labels that a picture shows, with their colours, in place of a bar. */
#ifndef PD_LEGEND_H
#define PD_LEGEND_H
#include "io/canvas.h"

#ifdef PDI_INTERNAL
#define PDI_LEGEND_LABELS 64 /* that are listed, at most */

/* Zero-initialise, then fill in. */
typedef struct pdi_legend {
    const char *const *names; /* [count] of the labels 0, 1, ...; NULL: their numbers */
    const uint32_t *colours;  /* [count]; NULL: those of pdi_colour_label */
    int count;
    double lo, hi;            /* [-] smallest and largest label of the whole series */
    int height;               /* [pixel] from the top of the first row to that of the last one, at most */
    uint8_t shown[PDI_LEGEND_LABELS]; /* label k is in this picture */
} pdi_legend;

/* A value of the picture, rounded to its label. */
PDI_FN void pdi_legend_show(pdi_legend *legend, double value);
/* The value is below 9e15. */
PDI_FN uint32_t pdi_legend_colour(const pdi_legend *legend, double value);
/* [pixel] */
PDI_FN int pdi_legend_width(const pdi_legend *legend);
PDI_FN void pdi_legend_draw(const pdi_legend *legend, int left, int top, pdi_canvas *canvas);
#endif

#endif
