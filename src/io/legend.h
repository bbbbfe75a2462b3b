/* legend: legend of a field of integer labels (grains, kinds): their names and colours, in place of a colour bar. */
#ifndef PD_LEGEND_H
#define PD_LEGEND_H
#include "io/canvas.h"

#ifdef PDI_APP_INTERNAL
#define PDI_LEGEND_MAX_LABELS 64 /* maximum number of labels in a legend */

/* Zero-initialise, then fill in. */
typedef struct pdi_legend {
    const char *const *names; /* [count] names of the labels 0, 1, ...; NULL: their numbers are shown */
    const uint32_t *colours;  /* [count]; NULL: those of pdi_colour_get_label_colour */
    int count;
    double lo, hi;            /* [-] smallest and largest label of the whole series */
    int max_height;           /* [pixel] maximum distance from the top of the first row to that of the last one */
    uint8_t shown[PDI_LEGEND_MAX_LABELS]; /* 1: label k occurs in this picture */
} pdi_legend;

/* Mark the label that a value of the field rounds to as shown; NaN and values outside 0..PDI_LEGEND_MAX_LABELS - 1 are
 * ignored. */
PDI_FN void pdi_legend_mark_shown(pdi_legend *legend, double value);
/* Colour 0xRRGGBB of the label that a value rounds to: the given one where `colours` has it, else that of
 * pdi_colour_get_label_colour. The magnitude of the value is below 9e15. */
PDI_FN uint32_t pdi_legend_get_colour(const pdi_legend *legend, double value);
/* Width [pixel] of the legend, with all labels of the series, shown or not, so that all its pictures have one size;
 * that of the range as a text where the series has too many. */
PDI_FN int pdi_legend_compute_width(const pdi_legend *legend);
/* Draw squares and names of the labels that are shown, in rows from (left, top) down without gaps. Where the series has
 * too many labels for the height, more than PDI_LEGEND_MAX_LABELS, or negative ones: the range lo to hi as a text. */
PDI_FN void pdi_legend_draw(const pdi_legend *legend, int left, int top, pdi_canvas *canvas);
#endif

#endif
