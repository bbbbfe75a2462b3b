/* velocity_plot: see velocity_plot.h */
#include "io/velocity_plot.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_VELOCITY_PLOT_LINE_WIDTH 1.3      /* [pixel] width of lines */
#define PDI_VELOCITY_PLOT_OUTLINE_WIDTH 3.1   /* [pixel] width of the light outline below them */
#define PDI_VELOCITY_PLOT_HEAD_LENGTH 9.0     /* [pixel] length of an arrow head */
#define PDI_VELOCITY_PLOT_HEAD_HALF_WIDTH 3.6 /* [pixel] half the width of a head */
#define PDI_VELOCITY_PLOT_HEAD_STROKES 3      /* strokes on each side of the axis of a head that fill it */
/* distance between heads on a streamline over the distance between streamlines */
#define PDI_VELOCITY_PLOT_HEAD_SPACING 7.0
#define PDI_VELOCITY_PLOT_MAX_HEAD_FRACTION 0.45 /* maximum length of the head over that of the arrow */
#define PDI_VELOCITY_PLOT_MIN_LENGTH 3.0         /* [pixel] shorter arrows are not drawn */

/* Add an arrow head to the open strokes, with its tip at (x, y), of this length [pixel], along the unit vector (dx,
 * dy). */
static void pdi_velocity_plot_draw_head(pdi_canvas *canvas, double x, double y, double dx, double dy, double length)
{
    double half = PDI_VELOCITY_PLOT_HEAD_HALF_WIDTH / PDI_VELOCITY_PLOT_HEAD_LENGTH * length;
    for (int k = -PDI_VELOCITY_PLOT_HEAD_STROKES; k <= PDI_VELOCITY_PLOT_HEAD_STROKES; k++) {
        double out = half * k / PDI_VELOCITY_PLOT_HEAD_STROKES;
        pdi_canvas_add_stroke(canvas, x, y, x - length * dx - out * dy, y - length * dy + out * dx);
    }
}

/* Add an arrow from (xa, ya) to another point (xb, yb) to the open strokes. */
static void pdi_velocity_plot_draw_arrow(pdi_canvas *canvas, double xa, double ya, double xb, double yb)
{
    double length = pdi_canvas_hypot(xb - xa, yb - ya),
           head = pd_min(PDI_VELOCITY_PLOT_HEAD_LENGTH, PDI_VELOCITY_PLOT_MAX_HEAD_FRACTION * length);
    double dx = (xb - xa) / length, dy = (yb - ya) / length;
    pdi_canvas_add_stroke(canvas, xa, ya, xb - 0.5 * head * dx, yb - 0.5 * head * dy);
    pdi_velocity_plot_draw_head(canvas, xb, yb, dx, dy, head);
}

/* Begin a set of strokes: the light outline (core 0), or the lines themselves (core 1). */
static pd_status pdi_velocity_plot_begin_strokes(pd_ctx *ctx, pdi_canvas *canvas, int core)
{
    return pdi_canvas_begin_strokes(ctx, canvas, core ? PDI_VELOCITY_PLOT_LINE_WIDTH : PDI_VELOCITY_PLOT_OUTLINE_WIDTH,
                                    core ? PDI_CANVAS_TEXT_COLOUR : PDI_CANVAS_BACKGROUND);
}

/* ---- streamlines ---- */

/* Add one streamline of `count` points point[][2] to the open strokes; y_sign 1: as it is, -1: mirrored at the bottom.
 * One arrow head stands near its middle, others at equal distances from there, but none within about half the spacing
 * of its start or a quarter of it of its end. Fewer than two points: nothing. */
static void pdi_velocity_plot_draw_streamline(const pdi_velocity_plot *a, pdi_canvas *canvas, const double *point,
                                              int64_t count, int y_sign)
{
    double length = 0.0, along = 0.0, every = PDI_VELOCITY_PLOT_HEAD_SPACING * a->field->spacing;
    for (int64_t k = 1; k < count; k++)
        length += pdi_canvas_hypot(point[2 * k] - point[2 * k - 2], point[2 * k + 1] - point[2 * k - 1]);
    double next = fmod(0.5 * length, every);
    if (next < 0.5 * a->field->spacing) next += every;
    for (int64_t k = 1; k < count; k++) {
        double x = a->left + point[2 * k - 2], y = a->bottom - y_sign * point[2 * k - 1];
        double dx = point[2 * k] - point[2 * k - 2], dy = -y_sign * (point[2 * k + 1] - point[2 * k - 1]);
        double segment = pdi_canvas_hypot(dx, dy);
        pdi_canvas_add_stroke(canvas, x, y, x + dx, y + dy);
        along += segment;
        if (along < next || next > length - 0.25 * a->field->spacing) continue;
        pdi_velocity_plot_draw_head(canvas, x + dx, y + dy, dx / segment, dy / segment, PDI_VELOCITY_PLOT_HEAD_LENGTH);
        next += every;
    }
}

PDI_FN pd_status pdi_velocity_plot_draw_streamlines(pd_ctx *ctx, const pdi_velocity_plot *a, pdi_canvas *canvas)
{
    pdi_streamlines lines;
    memset(&lines, 0, sizeof lines);
    pd_status status = pdi_streamlines_compute(ctx, a->field, &lines);
    for (int core = 0; core < 2 && status == PD_OK; core++) {
        status = pdi_velocity_plot_begin_strokes(ctx, canvas, core);
        for (int64_t k = 0; k < lines.count && status == PD_OK; k++)
            for (int up = 1; up >= (a->field->mirrored ? -1 : 1); up -= 2)
                pdi_velocity_plot_draw_streamline(a, canvas, lines.point + 2 * lines.line[k].first, lines.line[k].count,
                                                  up);
        pdi_canvas_end_strokes(ctx, canvas);
    }
    pdi_streamlines_free(ctx, &lines);
    return status;
}

/* ---- arrows ---- */

/* Arrow end[2] [pixel], relative to its start, y upward, for the velocity at a position[2] [pixel]. Returns 1; 0: no
 * fluid is there, or the arrow is shorter than PDI_VELOCITY_PLOT_MIN_LENGTH. */
static int pdi_velocity_plot_compute_arrow(const pdi_velocity_plot *a, const double *position, double *end)
{
    const pdi_streamline_field *f = a->field;
    double u[2];
    if (!pdi_streamline_interpolate_velocity(f, position, u)) return 0;
    /* [pixel] */
    for (int d = 0; d < 2; d++) end[d] = u[d] * f->cell_size[d] / f->pixel_size[d] / a->max_speed * a->max_length;
    return pdi_canvas_hypot(end[0], end[1]) >= PDI_VELOCITY_PLOT_MIN_LENGTH;
}

PDI_FN pd_status pdi_velocity_plot_draw_arrows(pd_ctx *ctx, const pdi_velocity_plot *a, pdi_canvas *canvas)
{
    const pdi_streamline_field *f = a->field;
    int count[2];
    double size[2] = {f->nx * f->pixel_size[0], f->ny * f->pixel_size[1]}, end[2];
    pd_status status = PD_OK;
    for (int d = 0; d < 2; d++) count[d] = (int)pd_max(1.0, floor(size[d] / a->max_length));
    for (int core = 0; core < 2 && status == PD_OK; core++) {
        status = pdi_velocity_plot_begin_strokes(ctx, canvas, core);
        for (int k = 0; k < count[0] * count[1] && status == PD_OK; k++) {
            double at[2] = {(k % count[0] + 0.5) * size[0] / count[0], (k / count[0] + 0.5) * size[1] / count[1]};
            if (!(a->max_speed > 0.0) || !pdi_velocity_plot_compute_arrow(a, at, end)) continue;
            double x = a->left + at[0], y = a->bottom - at[1];
            pdi_velocity_plot_draw_arrow(canvas, x - 0.5 * end[0], y + 0.5 * end[1], x + 0.5 * end[0],
                                         y - 0.5 * end[1]);
        }
        pdi_canvas_end_strokes(ctx, canvas);
    }
    return status;
}

PDI_FN double pdi_velocity_plot_reference_speed(double max_speed, char *text)
{
    static const char *const units[] = {"nm/s", "\xC2\xB5m/s", "mm/s", "m/s", "km/s"};
    static const double sizes[] = {1e-9, 1e-6, 1e-3, 1.0, 1e3};
    int unit = 0;
    double power = pow(10.0, floor(log10(max_speed) + 1e-9)), mantissa = max_speed / power * (1.0 + 1e-9);
    double speed = (mantissa >= 5.0 ? 5.0 : mantissa >= 2.0 ? 2.0 : 1.0) * power;
    while (unit < 4 && speed >= 0.04 * sizes[unit + 1]) unit++;
    snprintf(text, 32, "%.3g %s", speed / sizes[unit], units[unit]);
    return speed;
}

PDI_FN pd_status pdi_velocity_plot_draw_one_arrow(pd_ctx *ctx, pdi_canvas *canvas, double x, double y, double length)
{
    pd_status status = pdi_velocity_plot_begin_strokes(ctx, canvas, 1);
    if (status == PD_OK) pdi_velocity_plot_draw_arrow(canvas, x, y, x + length, y);
    pdi_canvas_end_strokes(ctx, canvas);
    return status;
}

#undef PDI_VELOCITY_PLOT_LINE_WIDTH
#undef PDI_VELOCITY_PLOT_OUTLINE_WIDTH
#undef PDI_VELOCITY_PLOT_HEAD_LENGTH
#undef PDI_VELOCITY_PLOT_HEAD_HALF_WIDTH
#undef PDI_VELOCITY_PLOT_HEAD_STROKES
#undef PDI_VELOCITY_PLOT_HEAD_SPACING
#undef PDI_VELOCITY_PLOT_MAX_HEAD_FRACTION
#undef PDI_VELOCITY_PLOT_MIN_LENGTH
