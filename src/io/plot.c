/* plot: see plot.h */
#include "io/plot.h"
#include "io/canvas.h"
#include "io/unit_label.h"
#include "io/axis_ticks.h"
#include "io/colour.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_PLOT_GRID_COLOUR 0xE3E5E8u    /* colour of grid lines */
#define PDI_PLOT_DASH_LENGTH 12.0         /* [pixel] length of a dash and of its gap */
#define PDI_PLOT_CURVE_WIDTH 2.5          /* [pixel] width of a curve */
#define PDI_PLOT_ERROR_BAR_WIDTH 1.5      /* [pixel] width of an error bar */
#define PDI_PLOT_ERROR_CAP_HALF_WIDTH 5.0 /* [pixel] half the length of the stroke at its ends */
#define PDI_PLOT_LEGEND_ROW_HEIGHT 26     /* [pixel] height of a row of the legend */

/* Position of the axes on the canvas, and their ranges and ticks. */
typedef struct pdi_plot_layout {
    int left, top, right, bottom; /* [pixel] frame of the axes */
    pdi_axis_ticks x, y;
} pdi_plot_layout;

/* Returns 1 when an axis can show a value: finite, and positive on a logarithmic axis. */
static int pdi_plot_is_drawable(double value, int log_axis)
{
    return !isnan(value) && !isinf(value) && (!log_axis || value > 0);
}

/* Returns 1 when both axes can show point i of a series. */
static int pdi_plot_is_shown(const pd_plot *plot, const pd_series *s, int i)
{
    return pdi_plot_is_drawable(s->x[i], plot->x_log) && pdi_plot_is_drawable(s->y[i], plot->y_log);
}

/* Lower (side -1) or upper (side 1) end of the error bar of point i; the point itself where the axis cannot show it. */
static double pdi_plot_error_bar_end(const pd_plot *plot, const pd_series *s, int i, int side)
{
    double end = s->error_bar ? s->y[i] + side * s->error_bar[i] : s->y[i];
    return pdi_plot_is_drawable(end, plot->y_log) ? end : s->y[i];
}

/* Check the series and the size of a plot; PD_ERR_ARGUMENT: not 1 to PD_PLOT_MAX_SERIES series, a width or height that
 * is neither 0 nor in 320 x 240 to 8000 x 8000, a series of fewer than 0 points, or of points without x or y. */
static pd_status pdi_plot_check(pd_ctx *ctx, const pd_plot *plot)
{
    if (plot->count < 1 || plot->count > PD_PLOT_MAX_SERIES)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "plot", "%d series, expected 1 to %d", plot->count, PD_PLOT_MAX_SERIES);
    if (plot->width < 0 || plot->height < 0 || (plot->width && plot->width < 320) ||
        (plot->height && plot->height < 240) || plot->width > 8000 || plot->height > 8000)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "plot", "%d x %d pixels, expected 320 x 240 to 8000 x 8000",
                       plot->width, plot->height);
    for (int k = 0; k < plot->count; k++) {
        const pd_series *s = &plot->series[k];
        if (s->count < 0 || (s->count > 0 && (!s->x || !s->y)))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "plot", "series %d has %d points without data", k, s->count);
    }
    return PD_OK;
}

/* Set type and range of an axis: lo..hi as given, or, where lo == hi, that of the data with a margin of 3 % on both
 * sides. PD_ERR_ARGUMENT: the given range is reversed, NaN, infinite, or not positive on a logarithmic axis. name: for
 * the message. */
static pd_status pdi_plot_set_axis_range(pd_ctx *ctx, const char *name, int log_axis, double lo, double hi,
                                         double data_lo, double data_hi, pdi_axis_ticks *axis)
{
    axis->log = log_axis;
    axis->lo = lo;
    axis->hi = hi;
    if (lo == hi) {
        axis->lo = data_lo;
        axis->hi = data_hi;
        pdi_axis_ticks_widen_range(0.03, axis);
    } else if (!(lo < hi) || isinf(hi - lo) || (log_axis && !(lo > 0)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "plot", "the range %g .. %g of axis %s cannot be drawn", lo, hi, name);
    return PD_OK;
}

/* Range lo..hi of all x of the series, also of points whose y cannot be shown; 0..1 (logarithmic: 1..10) without any.
 * Start with lo above hi. */
static void pdi_plot_compute_x_range(const pd_plot *plot, double *lo, double *hi)
{
    for (int k = 0; k < plot->count; k++)
        for (int i = 0; i < plot->series[k].count; i++) {
            double x = plot->series[k].x[i];
            if (!pdi_plot_is_drawable(x, plot->x_log)) continue;
            *lo = pd_min(*lo, x);
            *hi = pd_max(*hi, x);
        }
    if (*lo <= *hi) return;
    *lo = plot->x_log ? 1.0 : 0.0;
    *hi = plot->x_log ? 10.0 : 1.0;
}

/* Set the ranges of both axes from the points that both axes can show, error bars included; where there is none, x from
 * all x that can be shown and y 0..1 (logarithmic: 1..10). PD_ERR_ARGUMENT: a given range is bad. */
static pd_status pdi_plot_compute_ranges(pd_ctx *ctx, const pd_plot *plot, pdi_plot_layout *l)
{
    double x_lo = INFINITY, x_hi = -INFINITY, y_lo = INFINITY, y_hi = -INFINITY;
    for (int k = 0; k < plot->count; k++)
        for (int i = 0; i < plot->series[k].count; i++) {
            const pd_series *s = &plot->series[k];
            if (!pdi_plot_is_shown(plot, s, i)) continue;
            x_lo = pd_min(x_lo, s->x[i]);
            x_hi = pd_max(x_hi, s->x[i]);
            y_lo = pd_min(y_lo, pdi_plot_error_bar_end(plot, s, i, -1));
            y_hi = pd_max(y_hi, pdi_plot_error_bar_end(plot, s, i, 1));
        }
    if (!(x_lo <= x_hi)) { /* no point can be shown: an empty frame over the x that are known */
        pdi_plot_compute_x_range(plot, &x_lo, &x_hi);
        y_lo = plot->y_log ? 1.0 : 0.0;
        y_hi = plot->y_log ? 10.0 : 1.0;
    }
    PD_TRY(pdi_plot_set_axis_range(ctx, "x", plot->x_log, plot->x_lo, plot->x_hi, x_lo, x_hi, &l->x));
    return pdi_plot_set_axis_range(ctx, "y", plot->y_log, plot->y_lo, plot->y_hi, y_lo, y_hi, &l->y);
}

/* Set the position of the axes on a canvas of width x height pixels, for the width of their labels, and their ticks. */
static void pdi_plot_compute_layout(const pd_plot *plot, int width, int height, pdi_plot_layout *l)
{
    int widest = 0;
    l->top = plot->title ? 56 : 30;
    l->bottom = height - (plot->x_label ? 72 : 44);
    pdi_axis_ticks_compute((l->bottom - l->top) / 75 + 1, &l->y);
    for (int k = 0; k < l->y.count; k++) {
        int text = pdi_canvas_compute_text_width(l->y.label[k]);
        if (text > widest) widest = text;
    }
    if (l->y.exponent && !plot->title) l->top += 14;
    l->left = 22 + (plot->y_label ? PDI_CANVAS_CAPITAL_HEIGHT + 14 : 0) + widest + 10;
    l->right = width - 34;
    pdi_axis_ticks_compute((l->right - l->left) / 120 + 1, &l->x);
}

/* Horizontal pixel position of a value x. */
static double pdi_plot_x_to_pixel(const pdi_plot_layout *l, double x)
{
    return l->left + pdi_axis_ticks_value_to_fraction(&l->x, x) * (l->right - l->left);
}

/* Vertical pixel position of a value y. */
static double pdi_plot_y_to_pixel(const pdi_plot_layout *l, double y)
{
    return l->bottom - pdi_axis_ticks_value_to_fraction(&l->y, y) * (l->bottom - l->top);
}

/* Draw the common power of ten of the tick labels of an axis, if they have one; (x, y): anchor of the text. */
static void pdi_plot_draw_axis_factor(pdi_canvas *canvas, const pdi_axis_ticks *axis, int x, int y, pdi_align align)
{
    char text[40], power[32];
    if (!axis->exponent) return;
    pdi_axis_ticks_format_power(axis->exponent, power);
    snprintf(text, sizeof text, "\xC3\x97 %s", power);
    pdi_canvas_draw_text(canvas, x, y, align, PDI_CANVAS_TEXT_COLOUR, text);
}

/* Draw grid lines (at ticks with a label), ticks (shorter without a label), tick labels and their powers of ten, frame,
 * axis labels with typeset units, and title; labels and title of NULL are left out. */
static void pdi_plot_draw_axes(const pd_plot *plot, const pdi_plot_layout *l, pdi_canvas *canvas)
{
    int middle_x = (l->left + l->right) / 2, middle_y = (l->top + l->bottom) / 2;
    char label[PDI_UNIT_LABEL_SIZE];
    for (int k = 0; k < l->x.count; k++) {
        int x = (int)(pdi_plot_x_to_pixel(l, l->x.value[k])), named = l->x.label[k][0] != 0;
        x = x < l->right ? x : l->right - 1;
        if (named) pdi_canvas_fill_rectangle(canvas, x, l->top, x + 1, l->bottom, PDI_PLOT_GRID_COLOUR);
        pdi_canvas_fill_rectangle(canvas, x, l->bottom, x + 1, l->bottom + (named ? 7 : 4), PDI_CANVAS_TEXT_COLOUR);
        pdi_canvas_draw_text(canvas, x + 1, l->bottom + 13, PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR, l->x.label[k]);
    }
    for (int k = 0; k < l->y.count; k++) {
        int y = (int)(pdi_plot_y_to_pixel(l, l->y.value[k])), named = l->y.label[k][0] != 0;
        y = y < l->bottom ? y : l->bottom - 1;
        if (named) pdi_canvas_fill_rectangle(canvas, l->left, y, l->right, y + 1, PDI_PLOT_GRID_COLOUR);
        pdi_canvas_fill_rectangle(canvas, l->left - (named ? 7 : 4), y, l->left, y + 1, PDI_CANVAS_TEXT_COLOUR);
        pdi_canvas_draw_text(canvas, l->left - 12, y - PDI_CANVAS_CAPITAL_HEIGHT / 2 + 1, PDI_ALIGN_END,
                             PDI_CANVAS_TEXT_COLOUR, l->y.label[k]);
    }
    pdi_canvas_draw_frame(canvas, l->left, l->top, l->right, l->bottom, PDI_CANVAS_TEXT_COLOUR);
    pdi_plot_draw_axis_factor(canvas, &l->y, 16, l->top - PDI_CANVAS_CAPITAL_HEIGHT - 10, PDI_ALIGN_START);
    pdi_plot_draw_axis_factor(canvas, &l->x, l->right, l->bottom + 39, PDI_ALIGN_END);
    if (plot->x_label)
        pdi_canvas_draw_text(canvas, middle_x, l->bottom + 39, PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR,
                             pdi_unit_label_format(plot->x_label, label));
    if (plot->y_label)
        pdi_canvas_draw_text_upward(canvas, 16, middle_y, PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR,
                                    pdi_unit_label_format(plot->y_label, label));
    if (plot->title) {
        int x = middle_x - pdi_canvas_compute_text_width(plot->title) / 2, start = l->y.exponent ? 90 : 16;
        pdi_canvas_draw_bold_text(canvas, x > start ? x : start, l->top - PDI_CANVAS_CAPITAL_HEIGHT - 16,
                                  PDI_CANVAS_TEXT_COLOUR, plot->title);
    }
}

/* Draw marker k at (x, y): one of six shapes, so that curves differ in grey print, too. */
static void pdi_plot_draw_marker(pdi_canvas *canvas, int k, double x, double y, uint32_t colour)
{
    static const double corner[6][8] = {
        {0},                                      /* disc */
        {-5, -5, 5, -5, 5, 5, -5, 5},             /* square */
        {0, -6, 5.5, 4.5, -5.5, 4.5, 0, -6},      /* triangle */
        {0, -6.5, 6.5, 0, 0, 6.5, -6.5, 0},       /* diamond */
        {0, 6, 5.5, -4.5, -5.5, -4.5, 0, 6},      /* triangle, point down */
        {0}};                                     /* ring */
    const double *c = corner[k % 6];
    if (k % 6 == 0) pdi_canvas_draw_line(canvas, x, y, x, y, 10, colour);
    else if (k % 6 == 5) {
        pdi_canvas_draw_line(canvas, x, y, x, y, 11, colour);
        pdi_canvas_draw_line(canvas, x, y, x, y, 6, PDI_CANVAS_BACKGROUND);
    } else
        for (int e = 0; e < 4; e++) {
            int f = (e + 1) % 4;
            pdi_canvas_draw_line(canvas, x + c[2 * e], y + c[2 * e + 1], x + c[2 * f], y + c[2 * f + 1], 2, colour);
        }
}

/* Draw a dashed segment, in pixels. *arc_length [pixel]: length of the curve so far, to which the segment is added; it
 * keeps the dashes regular across the points. A segment without length, or longer than 256 times width plus height of
 * the canvas, is neither drawn nor added. */
static void pdi_plot_draw_dashes(pdi_canvas *canvas, double xa, double ya, double xb, double yb, double *arc_length,
                                 uint32_t colour)
{
    double length = pdi_canvas_hypot(xb - xa, yb - ya), position = 0;
    /* Pieces far outside would only cost time. */
    double limit = 4.0 * (canvas->image.width + canvas->image.height);
    if (!(length > 0) || length > 64 * limit) return;
    while (position < length) {
        double phase = fmod(*arc_length, 2 * PDI_PLOT_DASH_LENGTH);
        double remaining =
            phase < PDI_PLOT_DASH_LENGTH ? PDI_PLOT_DASH_LENGTH - phase : 2 * PDI_PLOT_DASH_LENGTH - phase;
        double next = pd_min(position + pd_max(remaining, 1e-6), length), s = position / length, t = next / length;
        if (phase < PDI_PLOT_DASH_LENGTH)
            pdi_canvas_draw_line(canvas, xa + s * (xb - xa), ya + s * (yb - ya), xa + t * (xb - xa), ya + t * (yb - ya),
                                 PDI_PLOT_CURVE_WIDTH, colour);
        *arc_length += next - position;
        position = next;
    }
}

/* Draw the line of series k, solid or dashed, with gaps at points that cannot be shown; a series of markers has
 * none. */
static void pdi_plot_draw_series(const pd_plot *plot, const pdi_plot_layout *l, int k, pdi_canvas *canvas)
{
    const pd_series *s = &plot->series[k];
    uint32_t colour = pdi_colour_get_series_colour(k);
    double xa = 0, ya = 0, arc_length = 0;
    int before = 0; /* the point before is shown */
    for (int i = 0; i < s->count; i++) {
        int shown = pdi_plot_is_shown(plot, s, i);
        if (!shown) {
            before = 0;
            continue;
        }
        double x = pdi_plot_x_to_pixel(l, s->x[i]), y = pdi_plot_y_to_pixel(l, s->y[i]);
        if (s->stroke == PD_SERIES_STYLE_DASHED && before)
            pdi_plot_draw_dashes(canvas, xa, ya, x, y, &arc_length, colour);
        else if (s->stroke != PD_SERIES_STYLE_MARKERS && s->stroke != PD_SERIES_STYLE_DASHED && before)
            pdi_canvas_draw_line(canvas, xa, ya, x, y, PDI_PLOT_CURVE_WIDTH, colour);
        xa = x;
        ya = y;
        before = 1;
    }
}

/* Draw the error bars of series k, with a short stroke at either end. Points that cannot be shown, and bars that are
 * not positive, are skipped; an end that a log axis cannot show is the point itself. */
static void pdi_plot_draw_error_bars(const pd_plot *plot, const pdi_plot_layout *l, int k, pdi_canvas *canvas)
{
    const pd_series *s = &plot->series[k];
    uint32_t colour = pdi_colour_get_series_colour(k);
    for (int i = 0; s->error_bar && i < s->count; i++) {
        if (!pdi_plot_is_shown(plot, s, i) || !(s->error_bar[i] > 0)) continue;
        double x = pdi_plot_x_to_pixel(l, s->x[i]),
               low = pdi_plot_y_to_pixel(l, pdi_plot_error_bar_end(plot, s, i, -1));
        double high = pdi_plot_y_to_pixel(l, pdi_plot_error_bar_end(plot, s, i, 1));
        pdi_canvas_draw_line(canvas, x, low, x, high, PDI_PLOT_ERROR_BAR_WIDTH, colour);
        pdi_canvas_draw_line(canvas, x - PDI_PLOT_ERROR_CAP_HALF_WIDTH, low, x + PDI_PLOT_ERROR_CAP_HALF_WIDTH, low,
                             PDI_PLOT_ERROR_BAR_WIDTH, colour);
        pdi_canvas_draw_line(canvas, x - PDI_PLOT_ERROR_CAP_HALF_WIDTH, high, x + PDI_PLOT_ERROR_CAP_HALF_WIDTH, high,
                             PDI_PLOT_ERROR_BAR_WIDTH, colour);
    }
}

/* Draw the markers of series k, if its style has some, at points that can be shown and lie inside the axes or on the
 * frame; those on the frame are not clipped. */
static void pdi_plot_draw_markers(const pd_plot *plot, const pdi_plot_layout *l, int k, pdi_canvas *canvas)
{
    const pd_series *s = &plot->series[k];
    if (s->stroke != PD_SERIES_STYLE_MARKERS && s->stroke != PD_SERIES_STYLE_BOTH) return;
    for (int i = 0; i < s->count; i++) {
        if (!pdi_plot_is_shown(plot, s, i)) continue;
        double x = pdi_plot_x_to_pixel(l, s->x[i]), y = pdi_plot_y_to_pixel(l, s->y[i]);
        if (x < l->left - 1 || x > l->right + 1 || y < l->top - 1 || y > l->bottom + 1) continue;
        pdi_plot_draw_marker(canvas, k, x, y, pdi_colour_get_series_colour(k));
    }
}

/* How much of the curves a rectangle [pixel] would hide: number of points inside, and of 15 points along each line
 * between them. */
static int pdi_plot_count_hidden_points(const pd_plot *plot, const pdi_plot_layout *l, int left, int top, int right,
                                        int bottom)
{
    int count = 0;
    for (int k = 0; k < plot->count; k++)
        for (int i = 0; i < plot->series[k].count; i++) {
            const pd_series *s = &plot->series[k];
            if (!pdi_plot_is_shown(plot, s, i)) continue;
            double x = pdi_plot_x_to_pixel(l, s->x[i]), y = pdi_plot_y_to_pixel(l, s->y[i]), xa = x, ya = y;
            int line = s->stroke != PD_SERIES_STYLE_MARKERS && i > 0 && pdi_plot_is_shown(plot, s, i - 1);
            if (line) {
                xa = pdi_plot_x_to_pixel(l, s->x[i - 1]);
                ya = pdi_plot_y_to_pixel(l, s->y[i - 1]);
            }
            for (int step = 0; step < (line ? 16 : 1); step++) {
                double px = x + (xa - x) * step / 16, py = y + (ya - y) * step / 16;
                count += px > left && px < right && py > top && py < bottom;
            }
        }
    return count;
}

/* Returns 1 when a series is listed in the legend: it has a name and a point that is shown. */
static int pdi_plot_is_in_legend(const pd_plot *plot, const pd_series *s)
{
    for (int i = 0; s->name && i < s->count; i++)
        if (pdi_plot_is_shown(plot, s, i)) return 1;
    return 0;
}

/* Draw the legend of the series that are listed, if any, in the corner where it hides fewest points of the curves; of
 * equal ones upper right, upper left, lower right, lower left. */
static void pdi_plot_draw_legend(const pd_plot *plot, const pdi_plot_layout *l, pdi_canvas *canvas)
{
    int rows = 0, widest = 0, best = -1, left = 0, top = 0;
    for (int k = 0; k < plot->count; k++) {
        if (!pdi_plot_is_in_legend(plot, &plot->series[k])) continue;
        int width = pdi_canvas_compute_text_width(plot->series[k].name);
        if (width > widest) widest = width;
        rows++;
    }
    if (!rows) return;
    int width = widest + 70, height = rows * PDI_PLOT_LEGEND_ROW_HEIGHT + 10;
    for (int corner = 0; corner < 4; corner++) {
        int x = corner % 2 ? l->left + 14 : l->right - 14 - width;
        int y = corner / 2 ? l->bottom - 14 - height : l->top + 14;
        int crowd = pdi_plot_count_hidden_points(plot, l, x, y, x + width, y + height);
        if (best >= 0 && crowd >= best) continue;
        best = crowd;
        left = x;
        top = y;
    }
    pdi_canvas_fill_rectangle(canvas, left, top, left + width, top + height, PDI_CANVAS_BACKGROUND);
    pdi_canvas_draw_frame(canvas, left, top, left + width, top + height, 0xC4C7CBu);
    for (int k = 0, row = 0; k < plot->count; k++) {
        const pd_series *s = &plot->series[k];
        if (!pdi_plot_is_in_legend(plot, s)) continue;
        double y = top + 5 + (row++ + 0.5) * PDI_PLOT_LEGEND_ROW_HEIGHT, arc_length = 0;
        uint32_t colour = pdi_colour_get_series_colour(k);
        if (s->stroke == PD_SERIES_STYLE_DASHED)
            pdi_plot_draw_dashes(canvas, left + 12, y, left + 48, y, &arc_length, colour);
        else if (s->stroke != PD_SERIES_STYLE_MARKERS)
            pdi_canvas_draw_line(canvas, left + 12, y, left + 48, y, PDI_PLOT_CURVE_WIDTH, colour);
        if (s->stroke == PD_SERIES_STYLE_MARKERS || s->stroke == PD_SERIES_STYLE_BOTH)
            pdi_plot_draw_marker(canvas, k, left + 30, y, colour);
        pdi_canvas_draw_text(canvas, left + 58, (int)y - PDI_CANVAS_CAPITAL_HEIGHT / 2, PDI_ALIGN_START,
                             PDI_CANVAS_TEXT_COLOUR, s->name);
    }
}

/* Draw the plot `what` on a new canvas: an image, or SVG where svg is given. The caller frees the image or svg.
 * PD_ERR_ARGUMENT: a bad plot, or fewer than 80 pixels between the labels of y and the right margin; PD_ERR_SIZE: too
 * many pixels. */
static pd_status pdi_plot_draw_on_canvas(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas)
{
    const pd_plot *plot = (const pd_plot *)what;
    pdi_plot_layout l;
    int width = plot->width ? plot->width : 1100, height = plot->height ? plot->height : 760;
    memset(canvas, 0, sizeof *canvas);
    memset(&l, 0, sizeof l);
    PD_TRY(pdi_plot_check(ctx, plot));
    PD_TRY(pdi_plot_compute_ranges(ctx, plot, &l));
    pdi_plot_compute_layout(plot, width, height, &l);
    if (l.right - l.left < 80)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "plot", "%d pixels are too narrow for the labels", width);
    PD_TRY(svg ? pdi_canvas_build_svg(ctx, width, height, svg, canvas)
                : pdi_canvas_build_image(ctx, width, height, canvas));
    pdi_plot_draw_axes(plot, &l, canvas);
    pdi_canvas_set_clip(canvas, l.left, l.top, l.right, l.bottom);
    for (int k = 0; k < plot->count; k++) pdi_plot_draw_series(plot, &l, k, canvas);
    for (int k = 0; k < plot->count; k++) pdi_plot_draw_error_bars(plot, &l, k, canvas);
    pdi_canvas_reset_clip(canvas);
    for (int k = 0; k < plot->count; k++) pdi_plot_draw_markers(plot, &l, k, canvas);
    pdi_plot_draw_legend(plot, &l, canvas);
    return PD_OK;
}

pd_status pd_plot_draw_image(pd_ctx *ctx, const pd_plot *plot, pd_image *image)
{
    return pdi_canvas_draw_to_image(ctx, pdi_plot_draw_on_canvas, plot, image);
}

pd_status pd_plot_write(pd_ctx *ctx, const char *path, const pd_plot *plot)
{
    return pdi_canvas_draw_to_file(ctx, path, pdi_plot_draw_on_canvas, plot);
}
