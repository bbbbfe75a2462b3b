/* colour_bar: colour bar beside a picture of a field. */
#ifndef PD_COLOUR_BAR_H
#define PD_COLOUR_BAR_H
#include "io/canvas.h"
#include "io/axis_ticks.h"

#ifdef PDI_APP_INTERNAL
#define PDI_COLOUR_BAR_WIDTH 22 /* [pixel] width of the bar without its numbers */

/* Position and content of a colour bar. */
typedef struct pdi_colour_bar {
    int left, top, height;  /* [pixel] of the bar */
    int label_left;         /* [pixel] left edge of the label, which is read upward */
    const pdi_axis_ticks *axis;   /* range of values and its ticks */
    const uint32_t *colour_table; /* [PDI_COLOUR_TABLE_SIZE] 0xRRGGBB from low to high */
    const char *label;      /* NULL: none */
} pdi_colour_bar;

/* Width [pixel] of the widest tick label of an axis; 0 without ticks. */
PDI_FN int pdi_colour_bar_label_width(const pdi_axis_ticks *axis);
/* Colour 0xRRGGBB at a fraction of table[PDI_COLOUR_TABLE_SIZE], 0 (low end) to 1 (high end); fractions beyond are
 * clamped, NaN gives the low end. */
PDI_FN uint32_t pdi_colour_bar_get_colour(const uint32_t *table, double fraction);
/* Draw the bar, the high end on top, its frame, its ticks with their labels on the right, their common power of ten
 * above it unless the exponent is 0, and its label upward unless it is NULL. */
PDI_FN void pdi_colour_bar_draw(const pdi_colour_bar *bar, pdi_canvas *canvas);
#endif

#endif
