/* bar: colour bar beside a picture of a field. */
#ifndef PD_BAR_H
#define PD_BAR_H
#include "io/canvas.h"
#include "io/ticks.h"

#ifdef PDI_INTERNAL
#define PDI_BAR_WIDTH 22 /* [pixel] width of the bar without its numbers */

/* Position and content of a colour bar. */
typedef struct pdi_bar {
    int left, top, height;  /* [pixel] of the bar */
    int label_left;         /* [pixel] left edge of the label, which is read upward */
    const pdi_ticks *axis;  /* range of values and its ticks */
    const uint32_t *table;  /* [PDI_COLOUR_COUNT] 0xRRGGBB from low to high */
    const char *label;      /* NULL: none */
} pdi_bar;

/* Width [pixel] of the widest tick label of an axis. */
PDI_FN int pdi_bar_widest(const pdi_ticks *axis);
/* Colour 0xRRGGBB at a fraction of a colour table, 0 (low end) to 1 (high end); values beyond, and NaN, are clamped. */
PDI_FN uint32_t pdi_bar_colour(const uint32_t *table, double fraction);
/* Draw the bar, its ticks, their common power of ten and its label. */
PDI_FN void pdi_bar_draw(const pdi_bar *bar, pdi_canvas *canvas);
#endif

#endif
