/* field_plot: see field_plot.h */
#include "io/field_plot.h"
#include "core/par.h"
#include "io/velocity_plot.h"
#include "io/colour_bar.h"
#include "io/canvas.h"
#include "io/contour.h"
#include "io/unit_label.h"
#include "io/legend.h"
#include "io/axis_ticks.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_FIELD_PLOT_MAX_WIDTH_FACTOR 1.4 /* pixels over the wanted width from which on several cells share a pixel \
                                             */
#define PDI_FIELD_PLOT_MIN_PIXELS 120       /* [pixel] smaller fields are stretched */
#define PDI_FIELD_PLOT_MAX_DECADES 8        /* maximum decades of a logarithmic range that is not given */
#define PDI_FIELD_PLOT_SOLID_COLOUR 0x9A9DA1u /* colour of metal */
#define PDI_FIELD_PLOT_WALL_COLOUR 0x3C4043u  /* colour of walls */
#define PDI_FIELD_PLOT_NAN_COLOUR 0xFF00FFu   /* colour of NaN */
#define PDI_FIELD_PLOT_CONTOUR_WIDTH 1.5      /* [pixel] width of contour lines */
#define PDI_FIELD_PLOT_OUTLINE_WIDTH 3.5      /* [pixel] width of the light outline below them */

/* Scale of one axis of `cells` cells: pixels_per_cell pixels a cell, or cells_per_pixel cells a pixel. pixels: length
 * of the axis. */
typedef struct pdi_field_plot_scale {
    int cells, pixels_per_cell, cells_per_pixel, pixels;
    int smooth; /* 1: interpolated, with any number of pixels a cell */
} pdi_field_plot_scale;

/* Positions [pixel] of all parts of a picture, axes and texts. */
typedef struct pdi_field_plot_layout {
    pdi_field_plot_scale x, y;
    int left, top;   /* upper left corner of the field */
    int bar_left;    /* left edge of the colour bar or legend */
    int bar_label_left; /* left edge of the label of the colour bar */
    int width, height;
    int y_label_left;                        /* left edge of the label of the y axis */
    pdi_axis_ticks axis_x, axis_y, axis_bar; /* axes of positions in unit_x and unit_y, and of the values */
    const char *unit_x, *unit_y;
    char x_label[160], label[PDI_UNIT_LABEL_SIZE];
    int x_label_left;
    double max_speed; /* [m/s] speed of the longest arrow */
    /* [pixel] lengths of the longest and of the reference arrow; scale 0: no arrows */
    double max_arrow, reference_length;
    char reference_label[32];
    double aspect;  /* [-] scale of y over that of x */
    /* 1: it has a bar; solid, walls, values <= 0 of a log scale occur */
    int has_bar, has_solid, has_wall, has_nonpositive;
    pdi_legend legend;
} pdi_field_plot_layout;

/* Check a picture; PD_ERR_ARGUMENT names what is wrong: no cells or values; an extent that is not positive or not
 * finite; width neither 0 nor in its limits; magnification outside 0..256; a colour range reversed, infinite, or not
 * positive on a log scale; an unknown map or paint; too many contours, or any of labels; a density neither 0 nor in its
 * limits, or without velocities. */
static pd_status pdi_field_plot_check(pd_ctx *ctx, const pd_field_plot *p)
{
    if (p->nx < 1 || p->ny < 1 || p->nx > INT32_MAX / p->ny || !p->values)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "%d x %d cells cannot be drawn", p->nx, p->ny);
    for (int d = 0; d < 2; d++)
        if (!(p->hi[d] - p->lo[d] > 0) || isinf(p->hi[d] - p->lo[d]))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "the extent %g .. %g m of axis %d is empty", p->lo[d],
                           p->hi[d], d);
    if (p->width != 0 && (p->width < PD_FIELD_PLOT_MIN_WIDTH || p->width > PD_FIELD_PLOT_MAX_WIDTH))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "a width of %d pixels, expected %d to %d", p->width,
                       PD_FIELD_PLOT_MIN_WIDTH, PD_FIELD_PLOT_MAX_WIDTH);
    if (p->magnification < 0 || p->magnification > 256)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "magnification %d, expected 0 (automatic) to 256",
                       p->magnification);
    if (!(p->range_lo <= p->range_hi) || isinf(p->range_hi - p->range_lo))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "the colour range %g .. %g is empty", p->range_lo,
                       p->range_hi);
    if (p->log && p->range_lo < p->range_hi && !(p->range_lo > 0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "a logarithmic range from %g on, expected a positive one",
                       p->range_lo);
    if ((int)p->map < 0 || (int)p->map > PD_COLOUR_MAP_VIRIDIS)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "colour map %d does not exist", (int)p->map);
    if (p->contour_count < 0 || p->contour_count > PD_FIELD_PLOT_MAX_CONTOURS ||
        (p->contour_count && p->map == PD_COLOUR_MAP_LABELS))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "%d contours, expected 0 to %d, and none of labels",
                       p->contour_count, PD_FIELD_PLOT_MAX_CONTOURS);
    for (int k = 0; k < 2; k++) {
        int across = k ? p->arrows : p->streamlines;
        if (across && (across < PD_FIELD_PLOT_MIN_DENSITY || across > PD_FIELD_PLOT_MAX_DENSITY || !p->velocity))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "picture",
                           "%d %s side by side, expected 0 or %d to %d, with "
                           "velocities",
                           across, k ? "vectors" : "streamlines", PD_FIELD_PLOT_MIN_DENSITY,
                           PD_FIELD_PLOT_MAX_DENSITY);
    }
    for (int64_t k = 0; p->cell_paint && k < (int64_t)p->nx * p->ny; k++)
        if (p->cell_paint[k] > PD_PAINT_OUTSIDE)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "picture", "cell %ld has paint %d, expected 0 to %d", (long)k,
                           p->cell_paint[k], PD_PAINT_OUTSIDE);
    return PD_OK;
}

/* What a cell shows; without a paint array all cells show the field. */
static pd_paint pdi_field_plot_get_paint(const pd_field_plot *p, size_t cell)
{
    return p->cell_paint ? (pd_paint)p->cell_paint[cell] : PD_PAINT_FIELD;
}

PDI_FN void pdi_field_plot_adjust_range(pd_colour_map map, int log_scale, double *lo, double *hi)
{
    if (*lo > *hi) { /* nothing to show */
        *lo = log_scale ? 1 : 0;
        *hi = log_scale ? 10 : 1;
    } else if (log_scale) *lo = pd_max(*lo, *hi * pow(10.0, -PDI_FIELD_PLOT_MAX_DECADES));
    else if (map == PD_COLOUR_MAP_DIVERGING) {
        *hi = pd_max(fabs(*lo), fabs(*hi));
        if (!(*hi > 0)) *hi = 1;
        *lo = -*hi;
    }
}

/* Set the range of the colour bar and the legend: the given one where range_lo < range_hi, else that of the finite
 * values that are shown (log scale: positive ones), adjusted; an empty one is widened. Labels have no log scale. Also
 * sets the names, colours and shown labels of the legend, and whether there is a bar, solid, walls and values <= 0 of a
 * log scale. */
static void pdi_field_plot_compute_range(const pd_field_plot *p, pdi_field_plot_layout *l)
{
    double lo = INFINITY, hi = -INFINITY;
    l->axis_bar.log = p->log && p->map != PD_COLOUR_MAP_LABELS;
    for (size_t k = 0; k < (size_t)p->nx * (size_t)p->ny; k++) {
        pd_paint paint = pdi_field_plot_get_paint(p, k);
        if (paint == PD_PAINT_SOLID) l->has_solid = 1;
        if (paint == PD_PAINT_WALL) l->has_wall = 1;
        if (paint != PD_PAINT_FIELD || isnan(p->values[k]) || isinf(p->values[k])) continue;
        if (l->axis_bar.log && !(p->values[k] > 0)) {
            l->has_nonpositive = 1;
            continue;
        }
        pdi_legend_mark_shown(&l->legend, p->values[k]);
        if (p->values[k] < lo) lo = p->values[k];
        if (p->values[k] > hi) hi = p->values[k];
    }
    if (p->range_lo < p->range_hi) {
        lo = p->range_lo;
        hi = p->range_hi;
    } else pdi_field_plot_adjust_range(p->map, l->axis_bar.log, &lo, &hi);
    l->axis_bar.lo = l->legend.lo = lo;
    l->axis_bar.hi = l->legend.hi = hi;
    l->legend.names = p->names;
    l->legend.colours = p->colours;
    l->legend.count = p->name_count;
    pdi_axis_ticks_widen_range(0, &l->axis_bar);
    l->has_bar = p->map != PD_COLOUR_MAP_LABELS;
}

/* Scale of an axis of `cells` cells that are wanted on `wanted` pixels: enlarged where it would have less than
 * PDI_FIELD_PLOT_MIN_PIXELS, merged where there are more than `max_pixels` cells. smooth 1: any number of pixels a
 * cell, where there is at least one. */
static pdi_field_plot_scale pdi_field_plot_fit_axis(int cells, double wanted, int max_pixels, int smooth)
{
    pdi_field_plot_scale s = {cells, 1, 1, 0, 0};
    if (smooth && wanted >= cells) {
        s.smooth = 1;
        s.pixels = (int)pd_max(floor(wanted + 0.5), PDI_FIELD_PLOT_MIN_PIXELS);
        return s;
    }
    /* The small shift lets equal spacings round alike. */
    if (wanted > cells && cells <= max_pixels) s.pixels_per_cell = (int)floor(wanted / cells + 0.5 + 1e-6);
    if (cells > max_pixels) s.cells_per_pixel = (cells + max_pixels - 1) / max_pixels;
    if (cells * s.pixels_per_cell < PDI_FIELD_PLOT_MIN_PIXELS)
        s.pixels_per_cell = (PDI_FIELD_PLOT_MIN_PIXELS + cells - 1) / cells;
    s.pixels = s.cells_per_pixel > 1 ? (cells + s.cells_per_pixel - 1) / s.cells_per_pixel : cells * s.pixels_per_cell;
    return s;
}

/* Merge cells along an axis of which the other one has merged cells, so that the scales of both stay equal. wanted
 * [pixel]: length for that. No change where the axis is enlarged, merged or interpolated, or would have less than
 * PDI_FIELD_PLOT_MIN_PIXELS. */
static void pdi_field_plot_equalise_scale(double wanted, pdi_field_plot_scale *s)
{
    int merged = (int)pd_max(1.0, floor(s->cells / pd_max(wanted, 1.0) + 0.5));
    int pixels = (s->cells + merged - 1) / merged;
    if (s->pixels_per_cell > 1 || s->cells_per_pixel > 1 || s->smooth || merged < 2 ||
        pixels < PDI_FIELD_PLOT_MIN_PIXELS)
        return;
    s->cells_per_pixel = merged;
    s->pixels = pixels;
}

/* Set the ends of an axis to lo and hi [m], converted by the largest magnitude `size` [m]: to nm below 2e-6, µm below
 * 2e-3, mm below 2, else m. Returns the name of the unit (static, UTF-8). */
static const char *pdi_field_plot_set_axis_unit(double size, double lo, double hi, pdi_axis_ticks *axis)
{
    double unit = size < 2e-6 ? 1e-9 : size < 2e-3 ? 1e-6 : size < 2 ? 1e-3 : 1;
    axis->lo = lo / unit;
    axis->hi = hi / unit;
    return size < 2e-6 ? "nm" : size < 2e-3 ? "\xC2\xB5m" : size < 2 ? "mm" : "m";
}

/* Scales, aspect, units and ticks of the axes, and ticks of the colour bar. Both axes have one unit where their scales
 * differ by less than 5 %. Interpolation is used only where both axes have a pixel per cell or more, and not for
 * labels. The labels of y have no sign in a mirrored picture. */
static void pdi_field_plot_compute_scales(const pd_field_plot *p, pdi_field_plot_layout *l)
{
    double lx = p->hi[0] - p->lo[0], ly = p->hi[1] - p->lo[1]; /* [m] */
    double width = p->width ? p->width : PD_FIELD_PLOT_WIDTH;  /* [pixel] */
    double scale = pd_min(width / lx, PD_FIELD_PLOT_MAX_ASPECT * width / ly); /* [pixel/m] */
    if (p->magnification) scale = p->magnification * p->nx / lx;
    int largest = (int)(PDI_FIELD_PLOT_MAX_WIDTH_FACTOR * width), smooth = p->smooth && p->map != PD_COLOUR_MAP_LABELS;
    smooth = smooth && scale * lx >= p->nx && scale * ly >= p->ny;
    l->x = pdi_field_plot_fit_axis(p->nx, scale * lx, largest, smooth);
    l->y = pdi_field_plot_fit_axis(p->ny, scale * ly, largest, smooth);
    if (l->x.cells_per_pixel > 1) pdi_field_plot_equalise_scale(l->x.pixels / lx * ly, &l->y);
    if (l->y.cells_per_pixel > 1) pdi_field_plot_equalise_scale(l->y.pixels / ly * lx, &l->x);
    l->aspect = (l->y.pixels / ly) / (l->x.pixels / lx);
    double size_x = pd_max(fabs(p->lo[0]), fabs(p->hi[0])), size_y = pd_max(fabs(p->lo[1]), fabs(p->hi[1]));
    if (fabs(l->aspect - 1) < 0.05) size_x = size_y = pd_max(size_x, size_y); /* one scale, one unit */
    l->unit_x = pdi_field_plot_set_axis_unit(size_x, p->lo[0], p->hi[0], &l->axis_x);
    l->unit_y = pdi_field_plot_set_axis_unit(size_y, p->lo[1], p->hi[1], &l->axis_y);
    pdi_axis_ticks_compute(l->x.pixels / 110 + 1, &l->axis_x);
    pdi_axis_ticks_compute(l->y.pixels / 60 + 1, &l->axis_y);
    pdi_axis_ticks_compute(l->y.pixels / 50 + 1, &l->axis_bar);
    for (int k = 0; p->mirrored && k < l->axis_y.count; k++)
        if (l->axis_y.label[k][0] == '-')
            memmove(l->axis_y.label[k], l->axis_y.label[k] + 1, strlen(l->axis_y.label[k]));
}

/* Name of axis 0 or 1: the given one, or x and y. */
static const char *pdi_field_plot_get_axis_name(const pd_field_plot *p, int axis)
{
    return p->axes[axis] ? p->axes[axis] : axis ? "y" : "x";
}

/* Convert a distance from the low end of an axis from cells to pixels. */
static double pdi_field_plot_cells_to_pixels(const pdi_field_plot_scale *scale, double cells)
{
    return scale->smooth ? cells * scale->pixels / scale->cells
                         : cells * scale->pixels_per_cell / scale->cells_per_pixel;
}

/* The velocity field of the picture (its array is not copied), with lengths in the picture in pixels. spacing 0: there
 * are no streamlines. */
static pdi_streamline_field pdi_field_plot_velocity_field(const pd_field_plot *p, const pdi_field_plot_layout *l)
{
    pdi_streamline_field f;
    const pdi_field_plot_scale *scale[2] = {&l->x, &l->y};
    memset(&f, 0, sizeof f);
    f.nx = p->nx;
    f.ny = p->ny;
    for (int d = 0; d < 2; d++) {
        f.velocity[d] = p->velocity + (size_t)d * (size_t)p->nx * (size_t)p->ny;
        f.pixel_size[d] = pdi_field_plot_cells_to_pixels(scale[d], 1.0);
        f.cell_size[d] = (p->hi[d] - p->lo[d]) / scale[d]->cells;
    }
    f.spacing = p->streamlines ? (double)(p->width ? p->width : PD_FIELD_PLOT_WIDTH) / p->streamlines : 0.0;
    memcpy(f.side_closed, p->side_closed, sizeof f.side_closed);
    return f;
}

/* Speed and length of the longest arrow, and length and label of the reference arrow, whose length stays 0 without
 * arrows or flow. The speed is the given one where that is positive, else the largest of the cells. */
static void pdi_field_plot_compute_arrow_scale(const pd_field_plot *p, pdi_field_plot_layout *l)
{
    if (!p->arrows) return;
    pdi_streamline_field f = pdi_field_plot_velocity_field(p, l);
    l->max_arrow = (double)(p->width ? p->width : PD_FIELD_PLOT_WIDTH) / p->arrows;
    l->max_speed = p->max_speed > 0 ? p->max_speed : pdi_streamline_compute_max_speed(&f);
    if (!(l->max_speed > 0)) return;
    /* a stretched axis has longer arrows: those along x are explained */
    l->reference_length =
        pdi_velocity_plot_reference_speed(l->max_speed, l->reference_label) / l->max_speed * l->max_arrow;
}

/* Width [pixel] of the reference arrow with its label and the gap between them. */
static int pdi_field_plot_reference_width(const pdi_field_plot_layout *l)
{
    return (int)ceil(l->reference_length) + 10 + pdi_canvas_compute_text_width(l->reference_label);
}

/* Label of the x axis; it names the axis that is stretched, and how many times, where the scales differ by more than 5
 * %. */
static void pdi_field_plot_format_x_label(const pd_field_plot *p, pdi_field_plot_layout *l)
{
    const char *axis = pdi_field_plot_get_axis_name(p, l->aspect > 1), *x = pdi_field_plot_get_axis_name(p, 0);
    double times = l->aspect > 1 ? l->aspect : 1 / l->aspect;
    if (times > 1.05)
        snprintf(l->x_label, sizeof l->x_label, "%.30s [%s]   (%.30s drawn %.3g times larger)", x, l->unit_x, axis,
                 times);
    else snprintf(l->x_label, sizeof l->x_label, "%.30s [%s]", x, l->unit_x);
}

/* Positions of all parts and the size of the picture. */
static void pdi_field_plot_compute_layout(const pd_field_plot *p, pdi_field_plot_layout *l)
{
    int title = p->title ? pdi_canvas_compute_text_width(p->title) + 1 : 0;
    const char *widest = p->widest_stamp ? p->widest_stamp : p->stamp;
    int stamp = p->stamp ? pdi_canvas_compute_text_width(widest) : 0;
    l->y_label_left = 14;
    l->left = l->y_label_left + PDI_CANVAS_CAPITAL_HEIGHT + 14 + pdi_colour_bar_label_width(&l->axis_y) + 12;
    l->top = title || stamp ? 52 : 24;
    if (l->has_bar && l->axis_bar.exponent && !(title || stamp)) l->top += 16;
    int edge = l->left + l->x.pixels, right = edge + pdi_colour_bar_label_width(&l->axis_x) / 2;
    if (l->has_bar) {
        l->bar_left = edge + 28;
        l->bar_label_left = l->bar_left + PDI_COLOUR_BAR_WIDTH + 12 + pdi_colour_bar_label_width(&l->axis_bar) + 16;
        right = l->bar_label_left + (p->label ? PDI_CANVAS_CAPITAL_HEIGHT + 4 : -8);
    } else {
        l->bar_left = edge + 28;
        l->legend.max_height = l->y.pixels;
        if (l->bar_left + pdi_legend_compute_width(&l->legend) > right)
            right = l->bar_left + pdi_legend_compute_width(&l->legend);
    }
    int header = l->left + title + stamp + (title && stamp ? 30 : 0);
    if (!l->has_bar && p->label) header += pdi_canvas_compute_text_width(l->label) + 30;
    if (l->has_bar && l->axis_bar.exponent && header + 10 > l->bar_left) l->top += 22; /* room for the power of ten */
    /* Under a narrow field the label is wider than the field. */
    int label = pdi_canvas_compute_text_width(l->x_label), centred = l->left + (l->x.pixels - label) / 2;
    l->x_label_left = centred > l->y_label_left ? centred : l->y_label_left;
    if (l->x_label_left + label > right) right = l->x_label_left + label;
    if (l->reference_length > 0 && l->x_label_left + label + 24 + pdi_field_plot_reference_width(l) > right)
        right = l->x_label_left + label + 24 + pdi_field_plot_reference_width(l);
    l->width = (right > header ? right : header) + 22;
    l->height = l->top + l->y.pixels + 12 + PDI_CANVAS_CAPITAL_HEIGHT + 14 + PDI_CANVAS_CAPITAL_HEIGHT + 22;
}

/* Colour of a cell by its paint. */
static const uint32_t pdi_field_plot_paint_colours[4] = {0, PDI_FIELD_PLOT_SOLID_COLOUR, PDI_FIELD_PLOT_WALL_COLOUR,
                                                         PDI_CANVAS_BACKGROUND};

/* Returns 1 when the cell shows the field, and its value has a colour of the bar: not NaN, and positive on a log scale.
 * Infinite values have one. */
static int pdi_field_plot_has_bar_colour(const pd_field_plot *p, const pdi_field_plot_layout *l, size_t cell)
{
    return pdi_field_plot_get_paint(p, cell) == PD_PAINT_FIELD && !isnan(p->values[cell]) &&
           (!l->axis_bar.log || p->values[cell] > 0);
}

/* Colour of pixel (px, py), py upward from the bottom of the field: bilinear mean, on the scale of the colour bar, of
 * the four nearest cells that have a value. The cell of the pixel decides first: its paint, magenta for NaN, background
 * for values <= 0 of a log scale. So cells without a value keep their edges. */
static uint32_t pdi_field_plot_interpolate_colour(const pd_field_plot *p, const pdi_field_plot_layout *l,
                                                  const uint32_t *table, int px, int py)
{
    double at[2], sum = 0, weights = 0;
    int low[2], n[2] = {p->nx, p->ny};
    at[0] = (px + 0.5) * p->nx / l->x.pixels;
    at[1] = (py + 0.5) * p->ny / l->y.pixels;
    size_t own = (size_t)pd_min(at[1], p->ny - 1.0) * (size_t)p->nx + (size_t)pd_min(at[0], p->nx - 1.0);
    pd_paint paint = pdi_field_plot_get_paint(p, own);
    if (paint != PD_PAINT_FIELD) return pdi_field_plot_paint_colours[paint];
    if (isnan(p->values[own])) return PDI_FIELD_PLOT_NAN_COLOUR;
    if (!pdi_field_plot_has_bar_colour(p, l, own)) return PDI_CANVAS_BACKGROUND;
    for (int d = 0; d < 2; d++) low[d] = (int)floor(at[d] - 0.5);
    for (int corner = 0; corner < 4; corner++) {
        int i[2];
        double weight = 1;
        for (int d = 0; d < 2; d++) {
            int up = corner >> d & 1;
            double fraction = at[d] - 0.5 - low[d];
            i[d] = low[d] + up < 0 ? 0 : low[d] + up >= n[d] ? n[d] - 1 : low[d] + up;
            weight *= up ? fraction : 1 - fraction;
        }
        size_t cell = (size_t)i[1] * (size_t)p->nx + (size_t)i[0];
        if (!pdi_field_plot_has_bar_colour(p, l, cell)) continue;
        sum += weight * pd_max(-1.0, pd_min(2.0, pdi_axis_ticks_value_to_fraction(&l->axis_bar, p->values[cell])));
        weights += weight;
    }
    return pdi_colour_bar_get_colour(table, sum / weights);
}

/* Colour of pixel (px, py), py upward from the bottom of the field: that of its cell, or of several cells the most
 * frequent paint (the field wins ties) and the mean of their values (of labels: the first one). Magenta: the mean is
 * NaN, or a label of 9e15 and more. Background: the mean is <= 0 on a log scale. */
static uint32_t pdi_field_plot_get_pixel_colour(const pd_field_plot *p, const pdi_field_plot_layout *l,
                                                const uint32_t *table, int px, int py)
{
    if (l->x.smooth) return pdi_field_plot_interpolate_colour(p, l, table, px, py);
    int i0 = px / l->x.pixels_per_cell * l->x.cells_per_pixel, j0 = py / l->y.pixels_per_cell * l->y.cells_per_pixel,
        count[4] = {0, 0, 0, 0}, frequent = 0;
    double sum = 0, first = 0;
    for (int j = j0; j < j0 + l->y.cells_per_pixel && j < p->ny; j++)
        for (int i = i0; i < i0 + l->x.cells_per_pixel && i < p->nx; i++) {
            size_t cell = (size_t)j * (size_t)p->nx + (size_t)i;
            pd_paint paint = pdi_field_plot_get_paint(p, cell);
            if (paint == PD_PAINT_FIELD && !count[paint]) first = p->values[cell];
            if (paint == PD_PAINT_FIELD) sum += p->values[cell];
            count[paint]++;
        }
    for (int k = 1; k < 4; k++)
        if (count[k] > count[frequent]) frequent = k;
    if (frequent) return pdi_field_plot_paint_colours[frequent];
    double value = count[0] > 1 ? sum / count[0] : first; /* one cell: no rounding */
    if (isnan(value)) return PDI_FIELD_PLOT_NAN_COLOUR;
    /* Means of labels mean nothing. */
    if (p->map == PD_COLOUR_MAP_LABELS)
        return fabs(first) < 9e15 ? pdi_legend_get_colour(&l->legend, first) : PDI_FIELD_PLOT_NAN_COLOUR;
    if (l->axis_bar.log && !(value > 0)) return PDI_CANVAS_BACKGROUND;
    return pdi_colour_bar_get_colour(table, pdi_axis_ticks_value_to_fraction(&l->axis_bar, value));
}

/* Draw the cells, the upper left corner of the field at (left, top). */
static void pdi_field_plot_draw_cells(const pd_ctx *ctx, const pd_field_plot *p, const pdi_field_plot_layout *l,
                                      const uint32_t *table, int left, int top, pdi_canvas *canvas)
{
    int nt = pd_par_threads(ctx, (int64_t)p->nx * p->ny * 8);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int row = 0; row < (l->y.pixels + l->y.pixels_per_cell - 1) / l->y.pixels_per_cell; row++)
        for (int x = 0; x < l->x.pixels; x += l->x.pixels_per_cell) {
            int y = row * l->y.pixels_per_cell, bottom = top + l->y.pixels - y;
            uint32_t colour = pdi_field_plot_get_pixel_colour(p, l, table, x, y);
            pdi_canvas_fill_rectangle(canvas, left + x, bottom - l->y.pixels_per_cell, left + x + l->x.pixels_per_cell,
                                      bottom, colour);
        }
}

/* ---- contour lines ---- */

/* Position 0..1 of contour k on the colour bar: (k + 1) / (count + 1) where no values are given. Outside 0..1 the
 * colours do not show its value. NaN: a value <= 0 of a log scale. */
static double pdi_field_plot_contour_position(const pd_field_plot *p, const pdi_field_plot_layout *l, int k)
{
    if (!p->contours) return (k + 1.0) / (p->contour_count + 1.0);
    return l->axis_bar.log && !(p->contours[k] > 0) ? (double)NAN
                                                    : pdi_axis_ticks_value_to_fraction(&l->axis_bar, p->contours[k]);
}

/* What the callback for contour segments needs. */
typedef struct pdi_field_plot_segment_context {
    const pdi_field_plot_layout *l;
    pdi_canvas *canvas;
} pdi_field_plot_segment_context;

/* Callback for a contour segment from a[2] to b[2] [cells]: draw it. */
static void pdi_field_plot_draw_segment(void *user, const double *a, const double *b)
{
    const pdi_field_plot_segment_context *pen = (const pdi_field_plot_segment_context *)user;
    const pdi_field_plot_layout *l = pen->l;
    int bottom = l->top + l->y.pixels;
    pdi_canvas_add_stroke(pen->canvas, l->left + pdi_field_plot_cells_to_pixels(&l->x, a[0]),
                          bottom - pdi_field_plot_cells_to_pixels(&l->y, a[1]),
                          l->left + pdi_field_plot_cells_to_pixels(&l->x, b[0]),
                          bottom - pdi_field_plot_cells_to_pixels(&l->y, b[1]));
}

/* Position of each cell on the colour bar, position[nx * ny], 0..1 within the range of colours; NaN: the cell has no
 * value, or an infinite one. */
static void pdi_field_plot_compute_bar_positions(const pd_field_plot *p, const pdi_field_plot_layout *l,
                                                 double *position)
{
    for (size_t k = 0; k < (size_t)p->nx * (size_t)p->ny; k++) {
        int placed = pdi_field_plot_has_bar_colour(p, l, k) && !isinf(p->values[k]);
        position[k] = placed ? pdi_axis_ticks_value_to_fraction(&l->axis_bar, p->values[k]) : (double)NAN;
    }
}

/* Draw the contour lines, clipped to the field, over a light outline of them; nothing without contours. Then the clip
 * rectangle is the whole canvas. */
static pd_status pdi_field_plot_draw_contours(pd_ctx *ctx, const pd_field_plot *p, const pdi_field_plot_layout *l,
                                              pdi_canvas *canvas)
{
    size_t cells = (size_t)p->nx * (size_t)p->ny;
    double *position = NULL;
    pd_status status = PD_OK;
    if (!p->contour_count) return PD_OK;
    PD_TRY(PD_NEW(ctx, "picture", cells, position));
    pdi_field_plot_compute_bar_positions(p, l, position);
    pdi_contour contour = {p->nx, p->ny, position};
    pdi_field_plot_segment_context pen = {l, canvas};
    pdi_canvas_set_clip(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels);
    for (int core = 0; core < 2 && status == PD_OK; core++) {
        status =
            pdi_canvas_begin_strokes(ctx, canvas, core ? PDI_FIELD_PLOT_CONTOUR_WIDTH : PDI_FIELD_PLOT_OUTLINE_WIDTH,
                                     core ? PDI_CANVAS_TEXT_COLOUR : PDI_CANVAS_BACKGROUND);
        for (int k = 0; k < p->contour_count && status == PD_OK; k++)
            pdi_contour_find_segments(&contour, pdi_field_plot_contour_position(p, l, k), pdi_field_plot_draw_segment,
                                      &pen);
        pdi_canvas_end_strokes(ctx, canvas);
    }
    pdi_canvas_reset_clip(canvas);
    PD_DELETE(ctx, cells, position);
    return status;
}

/* Draw the arrows, where the reference arrow has a length, then the streamlines, clipped to the field; then the clip
 * rectangle is the whole canvas. In a mirrored picture streamlines are computed in the upper ny / 2 rows and drawn
 * twice, arrows are those of the whole field. */
static pd_status pdi_field_plot_draw_velocity(pd_ctx *ctx, const pd_field_plot *p, const pdi_field_plot_layout *l,
                                              pdi_canvas *canvas)
{
    pd_status status = PD_OK;
    if (!p->streamlines && !(l->reference_length > 0)) return PD_OK;
    pdi_streamline_field whole = pdi_field_plot_velocity_field(p, l), half = whole;
    pdi_velocity_plot arrows = {&whole, (double)l->left, (double)(l->top + l->y.pixels), l->max_speed, l->max_arrow};
    pdi_canvas_set_clip(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels);
    if (l->reference_length > 0) status = pdi_velocity_plot_draw_arrows(ctx, &arrows, canvas);
    if (p->mirrored) {
        arrows.field = &half;
        half.ny = p->ny / 2;
        for (int d = 0; d < 2; d++) half.velocity[d] += (size_t)(p->ny - half.ny) * (size_t)p->nx;
        half.side_closed[2] = half.mirrored = 1;
        arrows.bottom -= pdi_field_plot_cells_to_pixels(&l->y, p->ny - half.ny);
    }
    if (p->streamlines && status == PD_OK) status = pdi_velocity_plot_draw_streamlines(ctx, &arrows, canvas);
    pdi_canvas_reset_clip(canvas);
    return status;
}

/* Mark the values of the contours on the colour bar; those outside its range are left out. */
static void pdi_field_plot_draw_contour_marks(const pd_field_plot *p, const pdi_field_plot_layout *l,
                                              pdi_canvas *canvas)
{
    int bottom = l->top + l->y.pixels, right = l->bar_left + PDI_COLOUR_BAR_WIDTH;
    for (int k = 0; k < p->contour_count; k++) {
        double place = pdi_field_plot_contour_position(p, l, k);
        if (!(place >= 0 && place <= 1)) continue;
        int y = bottom - 1 - (int)(place * (l->y.pixels - 1) + 0.5);
        int above = y > l->top ? y - 1 : y, below = y + 1 < bottom ? y + 2 : y + 1;
        pdi_canvas_fill_rectangle(canvas, l->bar_left, above, right, below, PDI_CANVAS_BACKGROUND);
        pdi_canvas_fill_rectangle(canvas, l->bar_left, y, right, y + 1, PDI_CANVAS_TEXT_COLOUR);
    }
}

/* Draw the cells (in SVG an embedded image), the frame around them, contours and velocity. */
static pd_status pdi_field_plot_draw_field(pd_ctx *ctx, const pd_field_plot *p, const pdi_field_plot_layout *l,
                                           const uint32_t *table, pdi_canvas *canvas)
{
    pdi_canvas cells;
    if (!canvas->svg) pdi_field_plot_draw_cells(ctx, p, l, table, l->left, l->top, canvas);
    else {
        PD_TRY(pdi_canvas_build_image(ctx, l->x.pixels, l->y.pixels, &cells));
        pdi_field_plot_draw_cells(ctx, p, l, table, 0, 0, &cells);
        pdi_canvas_draw_image(canvas, l->left, l->top, &cells.image);
        pd_image_free(ctx, &cells.image);
    }
    pdi_canvas_draw_frame(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels, PDI_CANVAS_TEXT_COLOUR);
    PD_TRY(pdi_field_plot_draw_contours(ctx, p, l, canvas));
    return pdi_field_plot_draw_velocity(ctx, p, l, canvas);
}

/* Draw ticks and labels of both axes. */
static void pdi_field_plot_draw_axes(const pd_field_plot *p, const pdi_field_plot_layout *l, pdi_canvas *canvas)
{
    int bottom = l->top + l->y.pixels;
    char text[64];
    for (int k = 0; k < l->axis_x.count; k++) {
        int x = l->left + (int)(pdi_axis_ticks_value_to_fraction(&l->axis_x, l->axis_x.value[k]) * l->x.pixels);
        pdi_canvas_fill_rectangle(canvas, x, bottom, x + 1, bottom + 7, PDI_CANVAS_TEXT_COLOUR);
        pdi_canvas_draw_text(canvas, x + 1, bottom + 12, PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR, l->axis_x.label[k]);
    }
    for (int k = 0; k < l->axis_y.count; k++) {
        int y = bottom - 1 - (int)(pdi_axis_ticks_value_to_fraction(&l->axis_y, l->axis_y.value[k]) * l->y.pixels);
        pdi_canvas_fill_rectangle(canvas, l->left - 7, y, l->left, y + 1, PDI_CANVAS_TEXT_COLOUR);
        pdi_canvas_draw_text(canvas, l->left - 12, y - PDI_CANVAS_CAPITAL_HEIGHT / 2 + 1, PDI_ALIGN_END,
                             PDI_CANVAS_TEXT_COLOUR, l->axis_y.label[k]);
    }
    pdi_canvas_draw_text(canvas, l->x_label_left, bottom + 12 + PDI_CANVAS_CAPITAL_HEIGHT + 12, PDI_ALIGN_START,
                         PDI_CANVAS_TEXT_COLOUR, l->x_label);
    snprintf(text, sizeof text, "%.30s [%s]", pdi_field_plot_get_axis_name(p, 1), l->unit_y);
    pdi_canvas_draw_text_upward(canvas, l->y_label_left, l->top + l->y.pixels / 2, PDI_ALIGN_CENTRE,
                                PDI_CANVAS_TEXT_COLOUR, text);
}

/* Draw the colour bar with the marks of the contours. */
static void pdi_field_plot_draw_colour_bar(const pd_field_plot *p, const pdi_field_plot_layout *l,
                                           const uint32_t *table, pdi_canvas *canvas)
{
    pdi_colour_bar bar = {
        l->bar_left, l->top, l->y.pixels, l->bar_label_left, &l->axis_bar, table, p->label ? l->label : NULL};
    pdi_colour_bar_draw(&bar, canvas);
    pdi_field_plot_draw_contour_marks(p, l, canvas);
}

/* Draw the reference arrow right of the x label, unless its length is 0, and from there to the left a key of the
 * colours of walls, solid and values <= 0: of those that occur, and fit in beside the x label. */
static pd_status pdi_field_plot_draw_key(pd_ctx *ctx, const pdi_field_plot_layout *l, pdi_canvas *canvas)
{
    static const char *const name[3] = {"wall", "solid", "zero or less"};
    static const uint32_t colour[3] = {PDI_FIELD_PLOT_WALL_COLOUR, PDI_FIELD_PLOT_SOLID_COLOUR, PDI_CANVAS_BACKGROUND};
    int y = l->top + l->y.pixels + 12 + PDI_CANVAS_CAPITAL_HEIGHT + 12, x = l->left + l->x.pixels;
    int there[3] = {l->has_wall, l->has_solid, l->has_nonpositive};
    int end = l->x_label_left + pdi_canvas_compute_text_width(l->x_label) + 20;
    if (l->reference_length > 0) {
        int width = pdi_field_plot_reference_width(l), start = x - width > end ? x - width : end;
        PD_TRY(pdi_velocity_plot_draw_one_arrow(ctx, canvas, start, y + 0.5 * PDI_CANVAS_CAPITAL_HEIGHT,
                                                l->reference_length));
        pdi_canvas_draw_text(canvas, start + width, y, PDI_ALIGN_END, PDI_CANVAS_TEXT_COLOUR, l->reference_label);
        x = start - 24;
    }
    for (int k = 0; k < 3; k++) {
        int width = pdi_canvas_compute_text_width(name[k]) + PDI_CANVAS_CAPITAL_HEIGHT + 8;
        if (!there[k] || x - width < end) continue;
        pdi_canvas_draw_text(canvas, x, y, PDI_ALIGN_END, PDI_CANVAS_TEXT_COLOUR, name[k]);
        x -= width;
        pdi_canvas_fill_rectangle(canvas, x, y, x + PDI_CANVAS_CAPITAL_HEIGHT, y + PDI_CANVAS_CAPITAL_HEIGHT,
                                  colour[k]);
        pdi_canvas_draw_frame(canvas, x, y, x + PDI_CANVAS_CAPITAL_HEIGHT, y + PDI_CANVAS_CAPITAL_HEIGHT,
                              PDI_CANVAS_TEXT_COLOUR);
        x -= 20;
    }
    return PD_OK;
}

/* Draw title, label (of fields with a legend) and time stamp above the field. The stamp ends at the right side of the
 * field, or follows the other texts where it would overlap them. */
static void pdi_field_plot_draw_header(const pd_field_plot *p, const pdi_field_plot_layout *l, pdi_canvas *canvas)
{
    int y = 24, right = l->left + l->x.pixels;
    if (p->title) pdi_canvas_draw_bold_text(canvas, l->left, y, PDI_CANVAS_TEXT_COLOUR, p->title);
    int taken = l->left + (p->title ? pdi_canvas_compute_text_width(p->title) + 30 : 0);
    if (!l->has_bar && p->label) {
        pdi_canvas_draw_text(canvas, taken, y, PDI_ALIGN_START, PDI_CANVAS_TEXT_COLOUR, l->label);
        taken += pdi_canvas_compute_text_width(p->label) + 30;
    }
    if (!p->stamp) return;
    int start = right - pdi_canvas_compute_text_width(p->stamp);
    pdi_canvas_draw_text(canvas, start > taken ? start : taken, y, PDI_ALIGN_START, PDI_CANVAS_TEXT_COLOUR, p->stamp);
}

/* Draw the picture `what` on a new canvas: an image, or SVG where svg is given. The caller frees the image or svg, also
 * on failure. PD_ERR_ARGUMENT: a bad picture; PD_ERR_SIZE: too many pixels. */
static pd_status pdi_field_plot_draw_on_canvas(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas)
{
    const pd_field_plot *picture = (const pd_field_plot *)what;
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    pdi_field_plot_layout l;
    memset(canvas, 0, sizeof *canvas);
    memset(&l, 0, sizeof l);
    PD_TRY(pdi_field_plot_check(ctx, picture));
    pdi_field_plot_compute_range(picture, &l);
    pdi_field_plot_compute_scales(picture, &l);
    pdi_field_plot_format_x_label(picture, &l);
    pdi_field_plot_compute_arrow_scale(picture, &l);
    if (picture->label) pdi_unit_label_format(picture->label, l.label);
    pdi_field_plot_compute_layout(picture, &l);
    pdi_colour_fill_table(picture->map == PD_COLOUR_MAP_LABELS ? PD_COLOUR_MAP_SEQUENTIAL : picture->map, table);
    PD_TRY(svg ? pdi_canvas_build_svg(ctx, l.width, l.height, svg, canvas)
                : pdi_canvas_build_image(ctx, l.width, l.height, canvas));
    PD_TRY(pdi_field_plot_draw_field(ctx, picture, &l, table, canvas));
    pdi_field_plot_draw_axes(picture, &l, canvas);
    if (l.has_bar) pdi_field_plot_draw_colour_bar(picture, &l, table, canvas);
    else pdi_legend_draw(&l.legend, l.bar_left, l.top, canvas);
    pdi_field_plot_draw_header(picture, &l, canvas);
    return pdi_field_plot_draw_key(ctx, &l, canvas);
}

pd_status pd_field_plot_draw_image(pd_ctx *ctx, const pd_field_plot *picture, pd_image *image)
{
    return pdi_canvas_draw_to_image(ctx, pdi_field_plot_draw_on_canvas, picture, image);
}

pd_status pd_field_plot_write(pd_ctx *ctx, const char *path, const pd_field_plot *picture)
{
    return pdi_canvas_draw_to_file(ctx, path, pdi_field_plot_draw_on_canvas, picture);
}
