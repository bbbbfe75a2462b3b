/* colour_bar: see colour_bar.h */
#include "io/colour_bar.h"
#include "io/colour.h"
#include <stdio.h>

PDI_FN int pdi_colour_bar_label_width(const pdi_axis_ticks *axis)
{
    int widest = 0;
    for (int k = 0; k < axis->count; k++) {
        int width = pdi_canvas_compute_text_width(axis->label[k]);
        if (width > widest) widest = width;
    }
    return widest;
}

PDI_FN uint32_t pdi_colour_bar_get_colour(const uint32_t *table, double fraction)
{
    fraction = !(fraction > 0) ? 0 : fraction > 1 ? 1 : fraction;
    return table[(int)(fraction * (PDI_COLOUR_TABLE_SIZE - 1) + 0.5)];
}

PDI_FN void pdi_colour_bar_draw(const pdi_colour_bar *b, pdi_canvas *canvas)
{
    int bottom = b->top + b->height, right = b->left + PDI_COLOUR_BAR_WIDTH;
    char factor[40], power[32];
    for (int y = 0; y < b->height; y++) {
        uint32_t colour = pdi_colour_bar_get_colour(b->colour_table, b->height > 1 ? (double)y / (b->height - 1) : 0);
        pdi_canvas_fill_rectangle(canvas, b->left, bottom - y - 1, right, bottom - y, colour);
    }
    pdi_canvas_draw_frame(canvas, b->left, b->top, right, bottom, PDI_CANVAS_TEXT_COLOUR);
    for (int k = 0; k < b->axis->count; k++) {
        int y =
            bottom - 1 - (int)(pdi_axis_ticks_value_to_fraction(b->axis, b->axis->value[k]) * (b->height - 1) + 0.5);
        pdi_canvas_fill_rectangle(canvas, right, y, right + 6, y + 1, PDI_CANVAS_TEXT_COLOUR);
        pdi_canvas_draw_text(canvas, right + 12, y - PDI_CANVAS_CAPITAL_HEIGHT / 2 + 1, PDI_ALIGN_START,
                             PDI_CANVAS_TEXT_COLOUR, b->axis->label[k]);
    }
    if (b->axis->exponent) {
        pdi_axis_ticks_format_power(b->axis->exponent, power);
        snprintf(factor, sizeof factor, "\xC3\x97 %s", power);
        pdi_canvas_draw_text(canvas, b->left, b->top - PDI_CANVAS_CAPITAL_HEIGHT - 14, PDI_ALIGN_START,
                             PDI_CANVAS_TEXT_COLOUR, factor);
    }
    if (b->label)
        pdi_canvas_draw_text_upward(canvas, b->label_left, b->top + b->height / 2, PDI_ALIGN_CENTRE,
                                    PDI_CANVAS_TEXT_COLOUR, b->label);
}
