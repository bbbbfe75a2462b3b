/* legend: see legend.h */
#include "io/legend.h"
#include "io/colour.h"
#include <math.h>
#include <stdio.h>

#define PDI_LEGEND_ROW_HEIGHT 24  /* [pixel] height of a row */
#define PDI_LEGEND_SQUARE_SIZE 16 /* [pixel] size of a coloured square */

PDI_FN void pdi_legend_mark_shown(pdi_legend *legend, double value)
{
    if (value > -0.5 && value < PDI_LEGEND_MAX_LABELS - 0.5) legend->shown[(int)(value + 0.5)] = 1;
}

PDI_FN uint32_t pdi_legend_get_colour(const pdi_legend *legend, double value)
{
    int64_t label = (int64_t)floor(value + 0.5);
    return legend->colours && label >= 0 && label < legend->count ? legend->colours[label]
                                                                  : pdi_colour_get_label_colour(label);
}

/* Number of rows for all labels of the series: the number of names, or without names hi + 1. 0: none, more than
 * PDI_LEGEND_MAX_LABELS, more than max_height holds, or negative labels (lo <= -0.5). */
static int pdi_legend_count_rows(const pdi_legend *l)
{
    double rows = l->names ? l->count : floor(l->hi + 0.5) + 1;
    if (!(rows >= 1) || rows > PDI_LEGEND_MAX_LABELS || !(l->lo > -0.5)) return 0;
    return rows * PDI_LEGEND_ROW_HEIGHT <= l->max_height + PDI_LEGEND_ROW_HEIGHT ? (int)rows : 0;
}

/* text[32]: name or number of label k. */
static void pdi_legend_format_name(const pdi_legend *l, int k, char *text)
{
    if (l->names) snprintf(text, 32, "%.31s", l->names[k] ? l->names[k] : "");
    else snprintf(text, 32, "%d", k);
}

/* text[32]: the range of the labels, shown when there are too many for a list. */
static void pdi_legend_format_range(const pdi_legend *l, char *text)
{
    snprintf(text, 32, "%.0f to %.0f", floor(l->lo + 0.5), floor(l->hi + 0.5));
}

PDI_FN int pdi_legend_compute_width(const pdi_legend *legend)
{
    char text[32];
    int rows = pdi_legend_count_rows(legend), widest = 0;
    if (!rows) {
        pdi_legend_format_range(legend, text);
        return pdi_canvas_compute_text_width(text);
    }
    for (int k = 0; k < rows; k++) {
        pdi_legend_format_name(legend, k, text);
        int width = pdi_canvas_compute_text_width(text);
        if (width > widest) widest = width;
    }
    return PDI_LEGEND_SQUARE_SIZE + 10 + widest;
}

PDI_FN void pdi_legend_draw(const pdi_legend *legend, int left, int top, pdi_canvas *canvas)
{
    char text[32];
    int rows = pdi_legend_count_rows(legend);
    if (!rows) {
        pdi_legend_format_range(legend, text);
        pdi_canvas_draw_text(canvas, left, top, PDI_ALIGN_START, PDI_CANVAS_TEXT_COLOUR, text);
    }
    for (int k = 0; k < rows; k++) {
        if (!legend->shown[k]) continue;
        pdi_legend_format_name(legend, k, text);
        pdi_canvas_fill_rectangle(canvas, left, top, left + PDI_LEGEND_SQUARE_SIZE, top + PDI_LEGEND_SQUARE_SIZE,
                                  pdi_legend_get_colour(legend, k));
        pdi_canvas_draw_text(canvas, left + PDI_LEGEND_SQUARE_SIZE + 10,
                             top + (PDI_LEGEND_SQUARE_SIZE - PDI_CANVAS_CAPITAL_HEIGHT) / 2, PDI_ALIGN_START,
                             PDI_CANVAS_TEXT_COLOUR, text);
        top += PDI_LEGEND_ROW_HEIGHT;
    }
}

#undef PDI_LEGEND_ROW_HEIGHT
#undef PDI_LEGEND_SQUARE_SIZE
