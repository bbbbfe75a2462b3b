/* surface_plot: see surface_plot.h */
#include "io/surface_plot.h"
#include "io/colour_bar.h"
#include "io/unit_label.h"
#include "io/legend.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_SURFACE_PLOT_BODY_COLOUR 0xC9CED6u   /* colour of metal in full light */
#define PDI_SURFACE_PLOT_EDGE_COLOUR 0x5F6368u   /* colour of edges of the box */
#define PDI_SURFACE_PLOT_LEFT_MARGIN 24          /* [pixel] left margin of the view */
#define PDI_SURFACE_PLOT_MAX_SCALE_FRACTION 0.22 /* maximum length of the scale bar over the width of the view */
#define PDI_SURFACE_PLOT_LETTER_DISTANCE 15.0    /* [pixel] distance from an edge to the letter of its axis */
#define PDI_SURFACE_PLOT_BAR_HEIGHT_FRACTION 0.8 /* height of the colour bar over that of the view */

/* Positions [pixel] of all parts of the picture. */
typedef struct pdi_surface_plot_layout {
    int left, top;     /* upper left corner of the view */
    int width, height; /* size of the picture */
    pdi_axis_ticks axis;
    pdi_colour_bar bar;
    pdi_legend legend;
    int legend_left; /* [pixel] */
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    char label[PDI_UNIT_LABEL_SIZE], scale_label[32];
    double scale_bar_length; /* [pixel] length of the scale bar */
} pdi_surface_plot_layout;

/* Set length [pixel] and label of the scale bar: the largest of 1, 2 and 5 times a power of ten [m] that is at most
 * PDI_SURFACE_PLOT_MAX_SCALE_FRACTION of the width of the view; labelled in nm, µm, mm or m. */
static void pdi_surface_plot_compute_scale_bar(const pd_rendering *s, pdi_surface_plot_layout *l)
{
    static const char *const units[] = {"nm", "\xC2\xB5m", "mm", "m"};
    static const double sizes[] = {1e-9, 1e-6, 1e-3, 1.0};
    double most = PDI_SURFACE_PLOT_MAX_SCALE_FRACTION * s->width * s->pixel_size, power = pow(10.0, floor(log10(most)));
    double length = (most >= 5.0 * power ? 5.0 : most >= 2.0 * power ? 2.0 : 1.0) * power;
    int unit = 0;
    while (unit < 3 && length * (1.0 + 1e-9) >= sizes[unit + 1]) unit++;
    snprintf(l->scale_label, sizeof l->scale_label, "%.3g %s", length / sizes[unit], units[unit]);
    l->scale_bar_length = length / s->pixel_size;
}

/* Set up the legend with the labels that are visible. */
static void pdi_surface_plot_init_legend(const pdi_surface_plot *r, pdi_surface_plot_layout *l)
{
    const pd_rendering *s = r->rendering;
    l->legend.names = r->names;
    l->legend.colours = r->colours;
    l->legend.count = r->name_count;
    l->legend.lo = r->lo;
    l->legend.hi = r->hi;
    for (size_t k = 0; k < (size_t)s->width * (size_t)s->height; k++)
        if (s->coverage[k]) pdi_legend_mark_shown(&l->legend, (double)s->value[k]);
}

/* Positions of all parts, axis and ticks of the colour bar, and the size of the picture. */
static void pdi_surface_plot_compute_layout(const pdi_surface_plot *r, pdi_surface_plot_layout *l)
{
    const pd_rendering *s = r->rendering;
    const char *widest = r->widest_stamp ? r->widest_stamp : r->stamp;
    int title = r->title ? pdi_canvas_compute_text_width(r->title) + 1 : 0;
    int stamp = r->stamp ? pdi_canvas_compute_text_width(widest) : 0;
    l->left = PDI_SURFACE_PLOT_LEFT_MARGIN;
    l->top = 52;
    int right = l->left + s->width, header = l->left + title + stamp + 30;
    if (r->use_values && r->map != PD_COLOUR_MAP_LABELS) {
        pdi_colour_bar *b = &l->bar;
        l->axis.log = r->log;
        l->axis.lo = r->lo;
        l->axis.hi = r->hi;
        pdi_axis_ticks_widen_range(0, &l->axis);
        b->height = (int)(PDI_SURFACE_PLOT_BAR_HEIGHT_FRACTION * s->height);
        pdi_axis_ticks_compute(b->height / 50 + 1, &l->axis);
        b->left = right + 16;
        b->top = l->top + (s->height - b->height) / 2;
        b->axis = &l->axis;
        b->colour_table = l->table;
        b->label = r->label ? l->label : NULL;
        b->label_left = b->left + PDI_COLOUR_BAR_WIDTH + 12 + pdi_colour_bar_label_width(&l->axis) + 16;
        right = b->label_left + (r->label ? PDI_CANVAS_CAPITAL_HEIGHT + 4 : -8);
    } else if (r->use_values) {
        l->legend_left = right + 16;
        l->legend.max_height = s->height;
        right = l->legend_left + pdi_legend_compute_width(&l->legend);
    }
    l->width = (right > header ? right : header) + 22;
    l->height = l->top + s->height + 14 + PDI_CANVAS_CAPITAL_HEIGHT + 22;
}

/* Colour of the surface for a value, before shading. That of metal where values are not used, for NaN, and for values
 * <= 0 of a log scale; labels have the colour of the legend, labels of 9e15 and more one of the table. */
static uint32_t pdi_surface_plot_get_unshaded_colour(const pdi_surface_plot *r, const pdi_surface_plot_layout *l,
                                                     double value)
{
    if (!r->use_values || isnan(value)) return PDI_SURFACE_PLOT_BODY_COLOUR;
    if (r->map == PD_COLOUR_MAP_LABELS && fabs(value) < 9e15) return pdi_legend_get_colour(&l->legend, value);
    if (r->log && !(value > 0)) return PDI_SURFACE_PLOT_BODY_COLOUR;
    return pdi_colour_bar_get_colour(l->table, pdi_axis_ticks_value_to_fraction(&l->axis, value));
}

/* Colour of pixel k = row * width + column of the view: the shaded surface over the background, below the edges of the
 * box. */
static uint32_t pdi_surface_plot_get_pixel_colour(const pdi_surface_plot *r, const pdi_surface_plot_layout *l, size_t k)
{
    const pd_rendering *s = r->rendering;
    double samples = PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE, cover = s->coverage[k] / samples,
           edge = s->edge[k] / samples;
    uint32_t base = s->coverage[k] ? pdi_surface_plot_get_unshaded_colour(r, l, (double)s->value[k])
                                   : PDI_CANVAS_BACKGROUND,
             colour = 0;
    for (int c = 16; c >= 0; c -= 8) {
        double background = (double)(PDI_CANVAS_BACKGROUND >> c & 255),
               edge_colour = (double)(PDI_SURFACE_PLOT_EDGE_COLOUR >> c & 255);
        double body = (double)(base >> c & 255) * s->brightness[k] / 255.0,
               mixed = background + cover * (body - background);
        mixed += edge * (edge_colour - mixed);
        colour |= (uint32_t)(mixed + 0.5) << c;
    }
    return colour;
}

/* Draw the view, its upper left corner at (left, top). */
static void pdi_surface_plot_draw_pixels(const pdi_surface_plot *r, const pdi_surface_plot_layout *l, int left, int top,
                                         pdi_canvas *canvas)
{
    for (int y = 0; y < r->rendering->height; y++)
        for (int x = 0; x < r->rendering->width; x++) {
            uint32_t colour =
                pdi_surface_plot_get_pixel_colour(r, l, (size_t)y * (size_t)r->rendering->width + (size_t)x);
            pdi_canvas_fill_rectangle(canvas, left + x, top + y, left + x + 1, top + y + 1, colour);
        }
}

/* Draw the letter of axis d outside the box, beside an edge along d of its silhouette (of its two faces one is seen)
 * that is longer than a pixel: of x and y the lowest edge, of z the leftmost. Nothing where there is none. */
static void pdi_surface_plot_draw_axis_letter(const pd_rendering *s, const pdi_surface_plot_layout *l, int d,
                                              pdi_canvas *canvas)
{
    int e = (d + 1) % 3, g = (d + 2) % 3, edge = -1;
    double best = -HUGE_VAL, x[3], a[3], b[3], at[2], middle[3], out[2];
    char letter[2] = {"xyz"[d], '\0'};
    for (int k = 0; k < 4; k++) {
        double first = k & 1 ? s->eye[e] : -s->eye[e], second = k & 2 ? s->eye[g] : -s->eye[g];
        if ((first > 0.0) == (second > 0.0)) continue; /* both faces are seen, or none */
        pdi_renderer_project_box_edge(s, d, k, a, b);
        double place = d == 2 ? -(a[0] + b[0]) : a[1] + b[1];
        if (!(place > best) || !(pdi_canvas_hypot(b[0] - a[0], b[1] - a[1]) > 1.0)) continue;
        best = place;
        edge = k;
    }
    if (edge < 0) return;
    pdi_renderer_project_box_edge(s, d, edge, a, b);
    for (int c = 0; c < 2; c++) at[c] = 0.5 * (a[c] + b[c]);
    out[0] = b[1] - a[1];
    out[1] = a[0] - b[0];
    for (int c = 0; c < 3; c++) x[c] = 0.5 * (s->lo[c] + s->hi[c]);
    pdi_renderer_project_point(s, x, middle);
    double sense = out[0] * (at[0] - middle[0]) + out[1] * (at[1] - middle[1]) < 0.0 ? -1.0 : 1.0;
    for (int c = 0; c < 2; c++)
        at[c] += sense * PDI_SURFACE_PLOT_LETTER_DISTANCE * out[c] / pdi_canvas_hypot(out[0], out[1]);
    pdi_canvas_draw_text(canvas, l->left + (int)at[0], l->top + (int)at[1] - PDI_CANVAS_CAPITAL_HEIGHT / 2,
                         PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR, letter);
}

/* Draw title, time stamp, scale bar and the letters of the axes. */
static void pdi_surface_plot_draw_texts(const pdi_surface_plot *r, const pdi_surface_plot_layout *l, pdi_canvas *canvas)
{
    int y = l->top + r->rendering->height + 14, right = l->left + r->rendering->width,
        wide = (int)(l->scale_bar_length + 0.5);
    int taken = l->left + (r->title ? pdi_canvas_compute_text_width(r->title) + 30 : 0);
    if (r->title) pdi_canvas_draw_bold_text(canvas, l->left, 24, PDI_CANVAS_TEXT_COLOUR, r->title);
    if (r->stamp) {
        int start = right - pdi_canvas_compute_text_width(r->stamp);
        pdi_canvas_draw_text(canvas, start > taken ? start : taken, 24, PDI_ALIGN_START, PDI_CANVAS_TEXT_COLOUR,
                             r->stamp);
    }
    int middle = y + PDI_CANVAS_CAPITAL_HEIGHT / 2;
    pdi_canvas_fill_rectangle(canvas, l->left, middle - 1, l->left + wide, middle + 2, PDI_CANVAS_TEXT_COLOUR);
    pdi_canvas_draw_text(canvas, l->left + wide + 10, y, PDI_ALIGN_START, PDI_CANVAS_TEXT_COLOUR, l->scale_label);
    for (int d = 0; d < 3; d++) pdi_surface_plot_draw_axis_letter(r->rendering, l, d, canvas);
}

/* Draw the picture `what` on a new canvas: an image, or SVG where svg is given. The caller frees the image or svg, also
 * on failure. PD_ERR_SIZE: too many pixels. The picture itself is not checked. */
static pd_status pdi_surface_plot_draw_on_canvas(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas)
{
    const pdi_surface_plot *r = (const pdi_surface_plot *)what;
    const pd_rendering *s = r->rendering;
    pdi_surface_plot_layout l;
    pdi_canvas view;
    memset(canvas, 0, sizeof *canvas);
    memset(&l, 0, sizeof l);
    pdi_colour_fill_table(r->map == PD_COLOUR_MAP_LABELS ? PD_COLOUR_MAP_SEQUENTIAL : r->map, l.table);
    if (r->label) pdi_unit_label_format(r->label, l.label);
    pdi_surface_plot_compute_scale_bar(s, &l);
    pdi_surface_plot_init_legend(r, &l);
    pdi_surface_plot_compute_layout(r, &l);
    PD_TRY(svg ? pdi_canvas_build_svg(ctx, l.width, l.height, svg, canvas)
                : pdi_canvas_build_image(ctx, l.width, l.height, canvas));
    if (!svg) pdi_surface_plot_draw_pixels(r, &l, l.left, l.top, canvas);
    else {
        PD_TRY(pdi_canvas_build_image(ctx, s->width, s->height, &view));
        pdi_surface_plot_draw_pixels(r, &l, 0, 0, &view);
        pdi_canvas_draw_image(canvas, l.left, l.top, &view.image);
        pd_image_free(ctx, &view.image);
    }
    if (l.bar.axis) pdi_colour_bar_draw(&l.bar, canvas);
    else if (r->use_values) pdi_legend_draw(&l.legend, l.legend_left, l.top, canvas);
    pdi_surface_plot_draw_texts(r, &l, canvas);
    return PD_OK;
}

PDI_FN pd_status pdi_surface_plot_draw_image(pd_ctx *ctx, const pdi_surface_plot *relief, pd_image *image)
{
    return pdi_canvas_draw_to_image(ctx, pdi_surface_plot_draw_on_canvas, relief, image);
}

PDI_FN pd_status pdi_surface_plot_write(pd_ctx *ctx, const char *path, const pdi_surface_plot *relief)
{
    return pdi_canvas_draw_to_file(ctx, path, pdi_surface_plot_draw_on_canvas, relief);
}

#undef PDI_SURFACE_PLOT_BODY_COLOUR
#undef PDI_SURFACE_PLOT_EDGE_COLOUR
#undef PDI_SURFACE_PLOT_LEFT_MARGIN
#undef PDI_SURFACE_PLOT_MAX_SCALE_FRACTION
#undef PDI_SURFACE_PLOT_LETTER_DISTANCE
#undef PDI_SURFACE_PLOT_BAR_HEIGHT_FRACTION
