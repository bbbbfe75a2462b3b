/* picture: see picture.h */
#include "io/picture.h"
#include "core/par.h"
#include "io/arrows.h"
#include "io/bar.h"
#include "io/canvas.h"
#include "io/contour.h"
#include "io/label.h"
#include "io/legend.h"
#include "io/ticks.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_PICTURE_LARGEST 1.4 /* pixels over the wanted width from which on several cells share a pixel */
#define PDI_PICTURE_SMALLEST 120 /* [pixel] smaller fields are stretched */
#define PDI_PICTURE_DECADES 8 /* maximum decades of a logarithmic range that is not given */
#define PDI_PICTURE_SOLID 0x9A9DA1u /* colour of metal */
#define PDI_PICTURE_WALL 0x3C4043u /* colour of walls */
#define PDI_PICTURE_NAN 0xFF00FFu /* colour of NaN */
#define PDI_PICTURE_LINE 1.5 /* [pixel] width of contour lines */
#define PDI_PICTURE_RIM 3.5 /* [pixel] width of the light outline below them */

/* Scale of one axis: `each` pixels a cell, or `merged` cells a pixel. */
typedef struct pdi_picture_scale {
    int cells, each, merged, pixels;
    int smooth; /* 1: interpolated, with any number of pixels a cell */
} pdi_picture_scale;

/* Positions [pixel] of all parts of a picture, axes and texts. */
typedef struct pdi_picture_layout {
    pdi_picture_scale x, y;
    int left, top;   /* upper left corner of the field */
    int bar;         /* left edge of the colour bar or legend */
    int bar_label;   /* left edge of the label of the colour bar */
    int width, height;
    int y_label;     /* left edge of the label of the y axis */
    pdi_ticks axis_x, axis_y, axis_bar; /* axes of positions in unit_x and unit_y, and of the values */
    const char *unit_x, *unit_y;
    char x_label[160], label[PDI_LABEL_SIZE];
    int x_label_start;
    double fastest;             /* [m/s] speed of the longest arrow */
    double longest, scale;      /* [pixel] lengths of the longest and of the reference arrow; scale 0: no arrows */
    char scale_label[32];
    double aspect;  /* [-] scale of y over that of x */
    int has_bar, has_solid, has_wall, has_blank; /* 1: it has a bar; solid, walls, values <= 0 of a log scale occur */
    pdi_legend legend;
} pdi_picture_layout;

/* Check all members of a picture; PD_ERR_ARGUMENT names the wrong one. */
static pd_status pdi_picture_check(pd_ctx *ctx, const pd_picture *p)
{
    if (p->nx < 1 || p->ny < 1 || p->nx > INT32_MAX / p->ny || !p->values)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "%d x %d cells cannot be drawn", p->nx, p->ny);
    for (int d = 0; d < 2; d++)
        if (!(p->hi[d] - p->lo[d] > 0) || isinf(p->hi[d] - p->lo[d]))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "the extent %g .. %g m of axis %d is empty", p->lo[d],
                            p->hi[d], d);
    if (p->width != 0 && (p->width < PD_PICTURE_LEAST || p->width > PD_PICTURE_MOST))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "a width of %d pixels, expected %d to %d", p->width,
                        PD_PICTURE_LEAST, PD_PICTURE_MOST);
    if (p->magnification < 0 || p->magnification > 256)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "magnification %d, expected 0 (automatic) to 256",
                        p->magnification);
    if (!(p->range_lo <= p->range_hi) || isinf(p->range_hi - p->range_lo))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "the colour range %g .. %g is empty", p->range_lo,
                        p->range_hi);
    if (p->log && p->range_lo < p->range_hi && !(p->range_lo > 0))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "a logarithmic range from %g on, expected a positive one",
                        p->range_lo);
    if ((int)p->map < 0 || (int)p->map > PD_MAP_VIRIDIS)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "colour map %d does not exist", (int)p->map);
    if (p->contour_count < 0 || p->contour_count > PD_PICTURE_CONTOURS || (p->contour_count && p->map == PD_MAP_LABELS))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "%d contours, expected 0 to %d, and none of labels",
                        p->contour_count, PD_PICTURE_CONTOURS);
    for (int k = 0; k < 2; k++) {
        int across = k ? p->vectors : p->streamlines;
        if (across && (across < PD_PICTURE_FEWEST || across > PD_PICTURE_DENSEST || !p->velocity))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "%d %s side by side, expected 0 or %d to %d, with "
                            "velocities", across, k ? "vectors" : "streamlines", PD_PICTURE_FEWEST, PD_PICTURE_DENSEST);
    }
    for (int64_t k = 0; p->paint && k < (int64_t)p->nx * p->ny; k++)
        if (p->paint[k] > PD_PAINT_OUTSIDE)
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "picture", "cell %ld has paint %d, expected 0 to %d", (long)k,
                            p->paint[k], PD_PAINT_OUTSIDE);
    return PD_OK;
}

/* What a cell shows; without a paint array all cells show the field. */
static pd_paint pdi_picture_paint(const pd_picture *p, size_t cell)
{
    return p->paint ? (pd_paint)p->paint[cell] : PD_PAINT_FIELD;
}

PDI_FN void pdi_picture_span(pd_map map, int log_scale, double *lo, double *hi)
{
    if (*lo > *hi) { /* nothing to show */
        *lo = log_scale ? 1 : 0;
        *hi = log_scale ? 10 : 1;
    } else if (log_scale) *lo = pdi_max(*lo, *hi * pow(10.0, -PDI_PICTURE_DECADES));
    else if (map == PD_MAP_DIVERGING) {
        *hi = pdi_max(fabs(*lo), fabs(*hi));
        if (!(*hi > 0)) *hi = 1;
        *lo = -*hi;
    }
}

/* Range of values of the field, set as range of the bar and the legend; also notes whether solid, walls and blank
 * values occur. */
static void pdi_picture_range(const pd_picture *p, pdi_picture_layout *l)
{
    double lo = INFINITY, hi = -INFINITY;
    l->axis_bar.log = p->log && p->map != PD_MAP_LABELS;
    for (size_t k = 0; k < (size_t)p->nx * (size_t)p->ny; k++) {
        pd_paint paint = pdi_picture_paint(p, k);
        if (paint == PD_PAINT_SOLID) l->has_solid = 1;
        if (paint == PD_PAINT_WALL) l->has_wall = 1;
        if (paint != PD_PAINT_FIELD || isnan(p->values[k]) || isinf(p->values[k])) continue;
        if (l->axis_bar.log && !(p->values[k] > 0)) {
            l->has_blank = 1;
            continue;
        }
        pdi_legend_show(&l->legend, p->values[k]);
        if (p->values[k] < lo) lo = p->values[k];
        if (p->values[k] > hi) hi = p->values[k];
    }
    if (p->range_lo < p->range_hi) {
        lo = p->range_lo;
        hi = p->range_hi;
    } else pdi_picture_span(p->map, l->axis_bar.log, &lo, &hi);
    l->axis_bar.lo = l->legend.lo = lo;
    l->axis_bar.hi = l->legend.hi = hi;
    l->legend.names = p->names;
    l->legend.colours = p->colours;
    l->legend.count = p->name_count;
    pdi_ticks_widen(0, &l->axis_bar);
    l->has_bar = p->map != PD_MAP_LABELS;
}

/* Scale of an axis of `cells` cells that are wanted on `wanted` pixels, with at most `max_pixels` pixels. */
static pdi_picture_scale pdi_picture_fit(int cells, double wanted, int max_pixels, int smooth)
{
    pdi_picture_scale s = {cells, 1, 1, 0, 0};
    if (smooth && wanted >= cells) {
        s.smooth = 1;
        s.pixels = (int)pdi_max(floor(wanted + 0.5), PDI_PICTURE_SMALLEST);
        return s;
    }
    /* The small shift lets equal spacings round alike. */
    if (wanted > cells) s.each = (int)floor(wanted / cells + 0.5 + 1e-6);
    if (cells > max_pixels) s.merged = (cells + max_pixels - 1) / max_pixels;
    if (cells * s.each < PDI_PICTURE_SMALLEST) s.each = (PDI_PICTURE_SMALLEST + cells - 1) / cells;
    s.pixels = s.merged > 1 ? (cells + s.merged - 1) / s.merged : cells * s.each;
    return s;
}

/* Merge cells along an axis of which the other one has merged cells, so that the scales of both stay equal. */
static void pdi_picture_even(double wanted, pdi_picture_scale *s)
{
    int merged = (int)pdi_max(1.0, floor(s->cells / pdi_max(wanted, 1.0) + 0.5));
    int pixels = (s->cells + merged - 1) / merged;
    if (s->each > 1 || s->merged > 1 || s->smooth || merged < 2 || pixels < PDI_PICTURE_SMALLEST) return;
    s->merged = merged;
    s->pixels = pixels;
}

/* Set the ends of an axis [m] in nm, µm, mm or m by its size [m]. Returns the unit. */
static const char *pdi_picture_unit(double size, double lo, double hi, pdi_ticks *axis)
{
    double unit = size < 2e-6 ? 1e-9 : size < 2e-3 ? 1e-6 : size < 2 ? 1e-3 : 1;
    axis->lo = lo / unit;
    axis->hi = hi / unit;
    return size < 2e-6 ? "nm" : size < 2e-3 ? "\xC2\xB5m" : size < 2 ? "mm" : "m";
}

/* Scales, units and ticks of the axes and of the colour bar. */
static void pdi_picture_scales(const pd_picture *p, pdi_picture_layout *l)
{
    double lx = p->hi[0] - p->lo[0], ly = p->hi[1] - p->lo[1]; /* [m] */
    double width = p->width ? p->width : PD_PICTURE_WIDTH; /* [pixel] */
    double scale = pdi_min(width / lx, PD_PICTURE_SQUAT * width / ly); /* [pixel/m] */
    if (p->magnification) scale = p->magnification * p->nx / lx;
    int largest = (int)(PDI_PICTURE_LARGEST * width), smooth = p->smooth && p->map != PD_MAP_LABELS;
    smooth = smooth && scale * lx >= p->nx && scale * ly >= p->ny;
    l->x = pdi_picture_fit(p->nx, scale * lx, largest, smooth);
    l->y = pdi_picture_fit(p->ny, scale * ly, largest, smooth);
    if (l->x.merged > 1) pdi_picture_even(l->x.pixels / lx * ly, &l->y);
    if (l->y.merged > 1) pdi_picture_even(l->y.pixels / ly * lx, &l->x);
    l->aspect = (l->y.pixels / ly) / (l->x.pixels / lx);
    double size_x = pdi_max(fabs(p->lo[0]), fabs(p->hi[0])), size_y = pdi_max(fabs(p->lo[1]), fabs(p->hi[1]));
    if (fabs(l->aspect - 1) < 0.05) size_x = size_y = pdi_max(size_x, size_y); /* one scale, one unit */
    l->unit_x = pdi_picture_unit(size_x, p->lo[0], p->hi[0], &l->axis_x);
    l->unit_y = pdi_picture_unit(size_y, p->lo[1], p->hi[1], &l->axis_y);
    pdi_ticks_ticks(l->x.pixels / 110 + 1, &l->axis_x);
    pdi_ticks_ticks(l->y.pixels / 60 + 1, &l->axis_y);
    pdi_ticks_ticks(l->y.pixels / 50 + 1, &l->axis_bar);
    for (int k = 0; p->mirrored && k < l->axis_y.count; k++)
        if (l->axis_y.label[k][0] == '-')
            memmove(l->axis_y.label[k], l->axis_y.label[k] + 1, strlen(l->axis_y.label[k]));
}

/* Name of an axis. */
static const char *pdi_picture_axis(const pd_picture *p, int axis)
{
    return p->axes[axis] ? p->axes[axis] : axis ? "y" : "x";
}

/* Convert a position along an axis from cells to pixels. */
static double pdi_picture_pixel(const pdi_picture_scale *scale, double cells)
{
    return scale->smooth ? cells * scale->pixels / scale->cells : cells * scale->each / scale->merged;
}

/* The velocity field of the picture, with lengths in the picture in pixels. */
static pdi_stream pdi_picture_stream(const pd_picture *p, const pdi_picture_layout *l)
{
    pdi_stream f;
    const pdi_picture_scale *scale[2] = {&l->x, &l->y};
    memset(&f, 0, sizeof f);
    f.nx = p->nx;
    f.ny = p->ny;
    for (int d = 0; d < 2; d++) {
        f.u[d] = p->velocity + (size_t)d * (size_t)p->nx * (size_t)p->ny;
        f.size[d] = pdi_picture_pixel(scale[d], 1.0);
        f.cell[d] = (p->hi[d] - p->lo[d]) / scale[d]->cells;
    }
    f.apart = p->streamlines ? (double)(p->width ? p->width : PD_PICTURE_WIDTH) / p->streamlines : 0.0;
    memcpy(f.closed, p->closed, sizeof f.closed);
    return f;
}

/* Length of the longest arrow and of the reference arrow. */
static void pdi_picture_arrow(const pd_picture *p, pdi_picture_layout *l)
{
    if (!p->vectors) return;
    pdi_stream f = pdi_picture_stream(p, l);
    l->longest = (double)(p->width ? p->width : PD_PICTURE_WIDTH) / p->vectors;
    l->fastest = p->fastest > 0 ? p->fastest : pdi_stream_fastest(&f);
    if (!(l->fastest > 0)) return;
    /* a stretched axis has longer arrows: those along x are explained */
    l->scale = pdi_arrows_scale(l->fastest, l->scale_label) / l->fastest * l->longest;
}

/* Width [pixel] of the reference arrow with its label. */
static int pdi_picture_scale_width(const pdi_picture_layout *l)
{
    return (int)ceil(l->scale) + 10 + pdi_canvas_text_width(l->scale_label);
}

/* Label of the x axis; it says when one axis is stretched against the other. */
static void pdi_picture_x_label(const pd_picture *p, pdi_picture_layout *l)
{
    const char *axis = pdi_picture_axis(p, l->aspect > 1), *x = pdi_picture_axis(p, 0);
    double times = l->aspect > 1 ? l->aspect : 1 / l->aspect;
    if (times > 1.05)
        snprintf(l->x_label, sizeof l->x_label, "%.30s [%s]   (%.30s drawn %.3g times larger)", x, l->unit_x, axis,
                 times);
    else snprintf(l->x_label, sizeof l->x_label, "%.30s [%s]", x, l->unit_x);
}

/* Positions of all parts and the size of the picture. */
static void pdi_picture_place(const pd_picture *p, pdi_picture_layout *l)
{
    int title = p->title ? pdi_canvas_text_width(p->title) + 1 : 0;
    const char *widest = p->widest ? p->widest : p->stamp;
    int stamp = p->stamp ? pdi_canvas_text_width(widest) : 0;
    l->y_label = 14;
    l->left = l->y_label + PDI_CANVAS_CAPITAL + 14 + pdi_bar_widest(&l->axis_y) + 12;
    l->top = title || stamp ? 52 : 24;
    if (l->has_bar && l->axis_bar.exponent && !(title || stamp)) l->top += 16;
    int edge = l->left + l->x.pixels, right = edge + pdi_bar_widest(&l->axis_x) / 2;
    if (l->has_bar) {
        l->bar = edge + 28;
        l->bar_label = l->bar + PDI_BAR_WIDTH + 12 + pdi_bar_widest(&l->axis_bar) + 16;
        right = l->bar_label + (p->label ? PDI_CANVAS_CAPITAL + 4 : -8);
    } else {
        l->bar = edge + 28;
        l->legend.height = l->y.pixels;
        if (l->bar + pdi_legend_width(&l->legend) > right) right = l->bar + pdi_legend_width(&l->legend);
    }
    int header = l->left + title + stamp + (title && stamp ? 30 : 0);
    if (!l->has_bar && p->label) header += pdi_canvas_text_width(l->label) + 30;
    if (l->has_bar && l->axis_bar.exponent && header + 10 > l->bar) l->top += 22; /* room for the power of ten */
    /* Under a narrow field the label is wider than the field. */
    int label = pdi_canvas_text_width(l->x_label), centred = l->left + (l->x.pixels - label) / 2;
    l->x_label_start = centred > l->y_label ? centred : l->y_label;
    if (l->x_label_start + label > right) right = l->x_label_start + label;
    if (l->scale > 0 && l->x_label_start + label + 24 + pdi_picture_scale_width(l) > right)
        right = l->x_label_start + label + 24 + pdi_picture_scale_width(l);
    l->width = (right > header ? right : header) + 22;
    l->height = l->top + l->y.pixels + 12 + PDI_CANVAS_CAPITAL + 14 + PDI_CANVAS_CAPITAL + 22;
}

/* Colour of a cell by its paint. */
static const uint32_t pdi_picture_flat[4] = {0, PDI_PICTURE_SOLID, PDI_PICTURE_WALL, PDI_CANVAS_PAPER};

/* Returns 1 when the cell has a value that the colour bar shows. */
static int pdi_picture_placed(const pd_picture *p, const pdi_picture_layout *l, size_t cell)
{
    return pdi_picture_paint(p, cell) == PD_PAINT_FIELD && !isnan(p->values[cell]) &&
           (!l->axis_bar.log || p->values[cell] > 0);
}

/* Colour of pixel (px, py), interpolated bilinearly between cell centres; cells without a value keep their edges. */
static uint32_t pdi_picture_between(const pd_picture *p, const pdi_picture_layout *l, const uint32_t *table, int px,
                                    int py)
{
    double at[2], sum = 0, weights = 0;
    int low[2], n[2] = {p->nx, p->ny};
    at[0] = (px + 0.5) * p->nx / l->x.pixels;
    at[1] = (py + 0.5) * p->ny / l->y.pixels;
    size_t own = (size_t)pdi_min(at[1], p->ny - 1.0) * (size_t)p->nx + (size_t)pdi_min(at[0], p->nx - 1.0);
    pd_paint paint = pdi_picture_paint(p, own);
    if (paint != PD_PAINT_FIELD) return pdi_picture_flat[paint];
    if (isnan(p->values[own])) return PDI_PICTURE_NAN;
    if (!pdi_picture_placed(p, l, own)) return PDI_CANVAS_PAPER;
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
        if (!pdi_picture_placed(p, l, cell)) continue;
        sum += weight * pdi_max(-1.0, pdi_min(2.0, pdi_ticks_place(&l->axis_bar, p->values[cell])));
        weights += weight;
    }
    return pdi_bar_colour(table, sum / weights);
}

/* Colour of pixel (px, py): that of its cell, or of several cells the most frequent paint and the mean of the field. */
static uint32_t pdi_picture_colour(const pd_picture *p, const pdi_picture_layout *l, const uint32_t *table, int px,
                                   int py)
{
    if (l->x.smooth) return pdi_picture_between(p, l, table, px, py);
    int i0 = px / l->x.each * l->x.merged, j0 = py / l->y.each * l->y.merged, count[4] = {0, 0, 0, 0}, frequent = 0;
    double sum = 0, first = 0;
    for (int j = j0; j < j0 + l->y.merged && j < p->ny; j++)
        for (int i = i0; i < i0 + l->x.merged && i < p->nx; i++) {
            size_t cell = (size_t)j * (size_t)p->nx + (size_t)i;
            pd_paint paint = pdi_picture_paint(p, cell);
            if (paint == PD_PAINT_FIELD && !count[paint]) first = p->values[cell];
            if (paint == PD_PAINT_FIELD) sum += p->values[cell];
            count[paint]++;
        }
    for (int k = 1; k < 4; k++)
        if (count[k] > count[frequent]) frequent = k;
    if (frequent) return pdi_picture_flat[frequent];
    double value = count[0] > 1 ? sum / count[0] : first; /* one cell: no rounding */
    if (isnan(value)) return PDI_PICTURE_NAN;
    /* Means of labels mean nothing. */
    if (p->map == PD_MAP_LABELS) return fabs(first) < 9e15 ? pdi_legend_colour(&l->legend, first) : PDI_PICTURE_NAN;
    if (l->axis_bar.log && !(value > 0)) return PDI_CANVAS_PAPER;
    return pdi_bar_colour(table, pdi_ticks_place(&l->axis_bar, value));
}

/* Draw the cells, the upper left corner of the field at (left, top). */
static void pdi_picture_pixels(const pd_ctx *ctx, const pd_picture *p, const pdi_picture_layout *l,
                               const uint32_t *table, int left, int top, pdi_canvas *canvas)
{
    int nt = pdi_par_threads(ctx, (int64_t)p->nx * p->ny * 8);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int row = 0; row < (l->y.pixels + l->y.each - 1) / l->y.each; row++)
        for (int x = 0; x < l->x.pixels; x += l->x.each) {
            int y = row * l->y.each, bottom = top + l->y.pixels - y;
            uint32_t colour = pdi_picture_colour(p, l, table, x, y);
            pdi_canvas_fill(canvas, left + x, bottom - l->y.each, left + x + l->x.each, bottom, colour);
        }
}

/* ---- contour lines ---- */

/* Position 0..1 of contour k on the colour bar; outside 0..1 the colours do not show its value. */
static double pdi_picture_level(const pd_picture *p, const pdi_picture_layout *l, int k)
{
    if (!p->contours) return (k + 1.0) / (p->contour_count + 1.0);
    return l->axis_bar.log && !(p->contours[k] > 0) ? (double)NAN : pdi_ticks_place(&l->axis_bar, p->contours[k]);
}

/* What the callback for contour segments needs. */
typedef struct pdi_picture_pen {
    const pdi_picture_layout *l;
    pdi_canvas *canvas;
} pdi_picture_pen;

/* Callback for a contour segment from a[2] to b[2] [cells]: draw it. */
static void pdi_picture_piece(void *user, const double *a, const double *b)
{
    const pdi_picture_pen *pen = (const pdi_picture_pen *)user;
    const pdi_picture_layout *l = pen->l;
    int bottom = l->top + l->y.pixels;
    pdi_canvas_stroke(pen->canvas, l->left + pdi_picture_pixel(&l->x, a[0]), bottom - pdi_picture_pixel(&l->y, a[1]),
                      l->left + pdi_picture_pixel(&l->x, b[0]), bottom - pdi_picture_pixel(&l->y, b[1]));
}

/* Position 0..1 of each cell on the colour bar, position[nx * ny]; NaN: the cell has no value. */
static void pdi_picture_places(const pd_picture *p, const pdi_picture_layout *l, double *position)
{
    for (size_t k = 0; k < (size_t)p->nx * (size_t)p->ny; k++) {
        int placed = pdi_picture_placed(p, l, k) && !isinf(p->values[k]);
        position[k] = placed ? pdi_ticks_place(&l->axis_bar, p->values[k]) : (double)NAN;
    }
}

/* Draw the contour lines. */
static pd_status pdi_picture_contours(pd_ctx *ctx, const pd_picture *p, const pdi_picture_layout *l,
                                      pdi_canvas *canvas)
{
    size_t cells = (size_t)p->nx * (size_t)p->ny;
    double *position = NULL;
    pd_status status = PD_OK;
    if (!p->contour_count) return PD_OK;
    PDI_TRY(PDI_NEW(ctx, "picture", cells, position));
    pdi_picture_places(p, l, position);
    pdi_contour contour = {p->nx, p->ny, position};
    pdi_picture_pen pen = {l, canvas};
    pdi_canvas_clip(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels);
    for (int core = 0; core < 2 && status == PD_OK; core++) {
        status = pdi_canvas_strokes(ctx, canvas, core ? PDI_PICTURE_LINE : PDI_PICTURE_RIM,
                                    core ? PDI_CANVAS_INK : PDI_CANVAS_PAPER);
        for (int k = 0; k < p->contour_count && status == PD_OK; k++)
            pdi_contour_lines(&contour, pdi_picture_level(p, l, k), pdi_picture_piece, &pen);
        pdi_canvas_strokes_end(ctx, canvas);
    }
    pdi_canvas_unclip(canvas);
    PDI_DELETE(ctx, cells, position);
    return status;
}

/* Draw arrows and streamlines. In a mirrored picture streamlines are computed in the upper half and drawn twice. */
static pd_status pdi_picture_flow(pd_ctx *ctx, const pd_picture *p, const pdi_picture_layout *l, pdi_canvas *canvas)
{
    pd_status status = PD_OK;
    if (!p->streamlines && !(l->scale > 0)) return PD_OK;
    pdi_stream whole = pdi_picture_stream(p, l), half = whole;
    pdi_arrows arrows = {&whole, (double)l->left, (double)(l->top + l->y.pixels), l->fastest, l->longest};
    pdi_canvas_clip(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels);
    if (l->scale > 0) status = pdi_arrows_grid(ctx, &arrows, canvas);
    if (p->mirrored) {
        arrows.stream = &half;
        half.ny = p->ny / 2;
        for (int d = 0; d < 2; d++) half.u[d] += (size_t)(p->ny - half.ny) * (size_t)p->nx;
        half.closed[2] = half.mirrored = 1;
        arrows.bottom -= pdi_picture_pixel(&l->y, p->ny - half.ny);
    }
    if (p->streamlines && status == PD_OK) status = pdi_arrows_lines(ctx, &arrows, canvas);
    pdi_canvas_unclip(canvas);
    return status;
}

/* Mark the values of the contours on the colour bar. */
static void pdi_picture_levels(const pd_picture *p, const pdi_picture_layout *l, pdi_canvas *canvas)
{
    int bottom = l->top + l->y.pixels, right = l->bar + PDI_BAR_WIDTH;
    for (int k = 0; k < p->contour_count; k++) {
        double place = pdi_picture_level(p, l, k);
        if (!(place >= 0 && place <= 1)) continue;
        int y = bottom - 1 - (int)(place * (l->y.pixels - 1) + 0.5);
        int above = y > l->top ? y - 1 : y, below = y + 1 < bottom ? y + 2 : y + 1;
        pdi_canvas_fill(canvas, l->bar, above, right, below, PDI_CANVAS_PAPER);
        pdi_canvas_fill(canvas, l->bar, y, right, y + 1, PDI_CANVAS_INK);
    }
}

/* Draw the cells (in SVG an embedded image), contours and velocity. */
static pd_status pdi_picture_field(pd_ctx *ctx, const pd_picture *p, const pdi_picture_layout *l, const uint32_t *table,
                                   pdi_canvas *canvas)
{
    pdi_canvas cells;
    if (!canvas->svg) pdi_picture_pixels(ctx, p, l, table, l->left, l->top, canvas);
    else {
        PDI_TRY(pdi_canvas_init(ctx, l->x.pixels, l->y.pixels, &cells));
        pdi_picture_pixels(ctx, p, l, table, 0, 0, &cells);
        pdi_canvas_image(canvas, l->left, l->top, &cells.image);
        pdi_image_free(ctx, &cells.image);
    }
    pdi_canvas_frame(canvas, l->left, l->top, l->left + l->x.pixels, l->top + l->y.pixels, PDI_CANVAS_INK);
    PDI_TRY(pdi_picture_contours(ctx, p, l, canvas));
    return pdi_picture_flow(ctx, p, l, canvas);
}

/* Draw ticks and labels of both axes. */
static void pdi_picture_axes(const pd_picture *p, const pdi_picture_layout *l, pdi_canvas *canvas)
{
    int bottom = l->top + l->y.pixels;
    char text[64];
    for (int k = 0; k < l->axis_x.count; k++) {
        int x = l->left + (int)(pdi_ticks_place(&l->axis_x, l->axis_x.at[k]) * l->x.pixels);
        pdi_canvas_fill(canvas, x, bottom, x + 1, bottom + 7, PDI_CANVAS_INK);
        pdi_canvas_text(canvas, x + 1, bottom + 12, PDI_ALIGN_CENTRE, PDI_CANVAS_INK, l->axis_x.label[k]);
    }
    for (int k = 0; k < l->axis_y.count; k++) {
        int y = bottom - 1 - (int)(pdi_ticks_place(&l->axis_y, l->axis_y.at[k]) * l->y.pixels);
        pdi_canvas_fill(canvas, l->left - 7, y, l->left, y + 1, PDI_CANVAS_INK);
        pdi_canvas_text(canvas, l->left - 12, y - PDI_CANVAS_CAPITAL / 2 + 1, PDI_ALIGN_END, PDI_CANVAS_INK,
                        l->axis_y.label[k]);
    }
    pdi_canvas_text(canvas, l->x_label_start, bottom + 12 + PDI_CANVAS_CAPITAL + 12, PDI_ALIGN_START, PDI_CANVAS_INK,
                    l->x_label);
    snprintf(text, sizeof text, "%.30s [%s]", pdi_picture_axis(p, 1), l->unit_y);
    pdi_canvas_text_up(canvas, l->y_label, l->top + l->y.pixels / 2, PDI_ALIGN_CENTRE, PDI_CANVAS_INK, text);
}

/* Draw the colour bar with the marks of the contours. */
static void pdi_picture_bar(const pd_picture *p, const pdi_picture_layout *l, const uint32_t *table,
                            pdi_canvas *canvas)
{
    pdi_bar bar = {l->bar, l->top, l->y.pixels, l->bar_label, &l->axis_bar, table, p->label ? l->label : NULL};
    pdi_bar_draw(&bar, canvas);
    pdi_picture_levels(p, l, canvas);
}

/* Draw the reference arrow right of the x label and, where they fit, a key of the colours of walls, solid and values <=
 * 0. */
static pd_status pdi_picture_key(pd_ctx *ctx, const pdi_picture_layout *l, pdi_canvas *canvas)
{
    static const char *const name[3] = {"wall", "solid", "zero or less"};
    static const uint32_t colour[3] = {PDI_PICTURE_WALL, PDI_PICTURE_SOLID, PDI_CANVAS_PAPER};
    int y = l->top + l->y.pixels + 12 + PDI_CANVAS_CAPITAL + 12, x = l->left + l->x.pixels;
    int there[3] = {l->has_wall, l->has_solid, l->has_blank};
    int end = l->x_label_start + pdi_canvas_text_width(l->x_label) + 20;
    if (l->scale > 0) {
        int width = pdi_picture_scale_width(l), start = x - width > end ? x - width : end;
        PDI_TRY(pdi_arrows_one(ctx, canvas, start, y + 0.5 * PDI_CANVAS_CAPITAL, l->scale));
        pdi_canvas_text(canvas, start + width, y, PDI_ALIGN_END, PDI_CANVAS_INK, l->scale_label);
        x = start - 24;
    }
    for (int k = 0; k < 3; k++) {
        int width = pdi_canvas_text_width(name[k]) + PDI_CANVAS_CAPITAL + 8;
        if (!there[k] || x - width < end) continue;
        pdi_canvas_text(canvas, x, y, PDI_ALIGN_END, PDI_CANVAS_INK, name[k]);
        x -= width;
        pdi_canvas_fill(canvas, x, y, x + PDI_CANVAS_CAPITAL, y + PDI_CANVAS_CAPITAL, colour[k]);
        pdi_canvas_frame(canvas, x, y, x + PDI_CANVAS_CAPITAL, y + PDI_CANVAS_CAPITAL, PDI_CANVAS_INK);
        x -= 20;
    }
    return PD_OK;
}

/* Draw title, label (of fields with a legend) and time stamp above the field. */
static void pdi_picture_header(const pd_picture *p, const pdi_picture_layout *l, pdi_canvas *canvas)
{
    int y = 24, right = l->left + l->x.pixels;
    if (p->title) pdi_canvas_title(canvas, l->left, y, PDI_CANVAS_INK, p->title);
    int taken = l->left + (p->title ? pdi_canvas_text_width(p->title) + 30 : 0);
    if (!l->has_bar && p->label) {
        pdi_canvas_text(canvas, taken, y, PDI_ALIGN_START, PDI_CANVAS_INK, l->label);
        taken += pdi_canvas_text_width(p->label) + 30;
    }
    if (!p->stamp) return;
    int start = right - pdi_canvas_text_width(p->stamp);
    pdi_canvas_text(canvas, start > taken ? start : taken, y, PDI_ALIGN_START, PDI_CANVAS_INK, p->stamp);
}

/* Draw the picture `what` on a new canvas: an image, or SVG where svg is given. The caller frees the image or svg. */
static pd_status pdi_picture_on(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas)
{
    const pd_picture *picture = (const pd_picture *)what;
    uint32_t table[PDI_COLOUR_COUNT];
    pdi_picture_layout l;
    memset(canvas, 0, sizeof *canvas);
    memset(&l, 0, sizeof l);
    PDI_TRY(pdi_picture_check(ctx, picture));
    pdi_picture_range(picture, &l);
    pdi_picture_scales(picture, &l);
    pdi_picture_x_label(picture, &l);
    pdi_picture_arrow(picture, &l);
    if (picture->label) pdi_label_print(picture->label, l.label);
    pdi_picture_place(picture, &l);
    pdi_colour_table(picture->map == PD_MAP_LABELS ? PD_MAP_SEQUENTIAL : picture->map, table);
    PDI_TRY(svg ? pdi_canvas_vectors(ctx, l.width, l.height, svg, canvas)
                : pdi_canvas_init(ctx, l.width, l.height, canvas));
    PDI_TRY(pdi_picture_field(ctx, picture, &l, table, canvas));
    pdi_picture_axes(picture, &l, canvas);
    if (l.has_bar) pdi_picture_bar(picture, &l, table, canvas);
    else pdi_legend_draw(&l.legend, l.bar, l.top, canvas);
    pdi_picture_header(picture, &l, canvas);
    return pdi_picture_key(ctx, &l, canvas);
}

PDI_FN pd_status pdi_picture_draw(pd_ctx *ctx, const pd_picture *picture, pd_image *image)
{
    return pdi_canvas_draw(ctx, pdi_picture_on, picture, image);
}

pd_status pd_picture_write(pd_ctx *ctx, const char *path, const pd_picture *picture)
{
    return pdi_canvas_file(ctx, path, pdi_picture_on, picture);
}
