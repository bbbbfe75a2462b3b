/* plot: line plot: curves and markers over two axes, as PNG or SVG. */
#ifndef PD_PLOT_H
#define PD_PLOT_H
#include "io/png.h"

#define PD_PLOT_MAX_SERIES 12 /* maximum number of series; six colours, each for a solid and a dashed line */

/* How a series is drawn. */
typedef enum pd_series_style {
    PD_SERIES_STYLE_LINE = 0,
    PD_SERIES_STYLE_DASHED = 1,
    PD_SERIES_STYLE_MARKERS = 2, /* no line */
    PD_SERIES_STYLE_BOTH = 3     /* line and markers */
} pd_series_style;

/* A series of points. */
typedef struct pd_series {
    const char *name;    /* in the legend, if a point is shown; NULL: not listed */
    const double *x, *y; /* [count] [-] in the unit of the labels; points that an axis cannot show (NaN, <= 0 on a log
                          * axis) leave a gap */
    int count;
    pd_series_style stroke;
    /* [count] [-] half the length of the error bar of a point; 0: no bar. NULL: none has one */
    const double *error_bar;
} pd_series;

/* Zero-initialise, then fill in. */
typedef struct pd_plot {
    const char *title, *x_label, *y_label; /* "t [h]"; NULL: none */
    pd_series series[PD_PLOT_MAX_SERIES];
    int count;
    int x_log, y_log;
    double x_lo, x_hi, y_lo, y_hi; /* [-] lo == hi: from the data */
    int width, height;             /* [pixel] 0: 1100 x 760 */
} pd_plot;

#define pd_plot_write PD_NAME(pd_plot_write)
#define pd_plot_draw_image PD_NAME(pd_plot_draw_image)

/* Draw into an RGB image (freed by its own function), zeroed on failure; an empty frame where no point can be shown.
 * PD_ERR_ARGUMENT: not 1 to PD_PLOT_MAX_SERIES series, points without data, a range that is reversed, infinite or not
 * positive on a log axis, a size outside 320 x 240 to 8000 x 8000, or too narrow for the labels of y. */
PD_API pd_status pd_plot_draw_image(pd_ctx *ctx, const pd_plot *plot, pd_image *image);

/* Draw and write as PNG, or as SVG where the path ends with ".svg". Also PD_ERR_FILE. */
PD_API pd_status pd_plot_write(pd_ctx *ctx, const char *path, const pd_plot *plot);

#endif
