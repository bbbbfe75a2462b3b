/* bar: the bar of colours beside a picture. */
#ifndef PD_BAR_H
#define PD_BAR_H
#include "io/canvas.h"
#include "io/ticks.h"

#ifdef PDI_INTERNAL
#define PDI_BAR_WIDTH 22 /* [pixel] */

typedef struct pdi_bar {
    int left, top, height;  /* [pixel] */
    int label_left;         /* [pixel] of the label, which is read upward */
    const pdi_ticks *axis;
    const uint32_t *table;  /* [PDI_COLOUR_COUNT] */
    const char *label;      /* NULL: none */
} pdi_bar;

/* [pixel] of the widest number beside an axis. */
PDI_FN int pdi_bar_widest(const pdi_ticks *axis);
/* Colour of a place 0..1 of the bar, that of its ends beyond. */
PDI_FN uint32_t pdi_bar_colour(const uint32_t *table, double place);
PDI_FN void pdi_bar_draw(const pdi_bar *bar, pdi_canvas *canvas);
#endif

#endif
