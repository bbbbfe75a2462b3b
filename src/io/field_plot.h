/* field_plot: plot of a field on a two-dimensional grid as PNG or SVG, with axes, colour bar, title and time stamp. */
#ifndef PD_FIELD_PLOT_H
#define PD_FIELD_PLOT_H
#include "io/png.h"
#include "io/colour.h"

#define PD_FIELD_PLOT_WIDTH 1000      /* [pixel] default width of a field */
#define PD_FIELD_PLOT_MAX_ASPECT 0.9  /* maximum height of a field over that width */
#define PD_FIELD_PLOT_MIN_WIDTH 120   /* [pixel] smallest width that can be asked for */
#define PD_FIELD_PLOT_MAX_WIDTH 4000  /* [pixel] largest one */
#define PD_FIELD_PLOT_MAX_CONTOURS 32 /* maximum number of contour lines */
#define PD_FIELD_PLOT_MIN_DENSITY 4   /* minimum number of streamlines or arrows side by side */
#define PD_FIELD_PLOT_MAX_DENSITY 100 /* maximum number of these */

/* What a cell shows: the field, or one colour. */
typedef enum pd_paint {
    PD_PAINT_FIELD = 0,
    PD_PAINT_SOLID = 1,  /* gray */
    PD_PAINT_WALL = 2,   /* dark */
    PD_PAINT_OUTSIDE = 3 /* background */
} pd_paint;

/* Zero-initialise, then fill in. Cell (i, j) is values[j * nx + i], i to the right, j upward. */
typedef struct pd_field_plot {
    int nx, ny;
    const double *values;  /* [nx * ny] [-] in the unit of the label; NaN is shown in magenta */
    const uint8_t *cell_paint; /* [nx * ny] pd_paint; NULL: the field everywhere */
    double lo[2], hi[2];   /* [m] the rectangle that the cells fill */
    double range_lo, range_hi; /* [-] range of colours; equal: that of the shown values (diverging: symmetric to 0) */
    pd_colour_map map;
    int magnification;     /* pixels per cell; 0: so that the field is about `width` pixels wide */
    const char *title, *stamp, *label; /* "Mg pin", "t = 6.1 s", "C [mol/m3]"; NULL: none */
    int width;             /* [pixel] approximate width of the field, its height at most 0.9 of that; 0: 1000 */
    int log;               /* 1: logarithmic colours; values of zero and below are left blank */
    int smooth;            /* 1: bilinear interpolation between cell centres; 0: a cell has one colour */
    const char *axes[2];   /* "r"; NULL: x, y */
    int mirrored;          /* 1: the picture is mirrored at 0 of the second axis, whose ticks have no sign */
    const char *widest_stamp; /* longest stamp of a series, so that all its pictures have one size; NULL: stamp */
    const char *const *names; /* [name_count] legend of the labels 0, 1, ...; NULL: their numbers */
    const uint32_t *colours;  /* [name_count] 0xRRGGBB of these labels; NULL: one for each number */
    int name_count;
    /* number of contour lines, at most PD_FIELD_PLOT_MAX_CONTOURS; not with PD_COLOUR_MAP_LABELS */
    int contour_count;
    const double *contours;   /* [contour_count] [-] their values; NULL: evenly spaced over the range of colours */
    int streamlines;          /* density of evenly spaced streamlines: how many fit side by side into `width`, 4 to 100;
                               * 0: none are drawn */
    int arrows;               /* density of arrows on a regular grid, in the same way */
    const double *velocity;   /* [2][nx * ny] [m/s] components along both axes; NaN: no fluid */
    double max_speed;         /* [m/s] speed of the longest arrow; 0: the largest speed of the field */
    int side_closed[4];       /* 1: nothing flows through the side x-, x+, y-, y+ */
} pd_field_plot;

#define pd_field_plot_write PD_NAME(pd_field_plot_write)
#define pd_field_plot_draw_image PD_NAME(pd_field_plot_draw_image)

/* Draw into an RGB image (freed by its own function), zeroed on failure. The axes have equal scales as far as whole
 * pixels allow; a field thinner than 120 pixels is stretched, and the axis label says so. PD_ERR_ARGUMENT: no cells or
 * values, or a member out of its range; PD_ERR_SIZE: more than PD_PNG_MAX_PIXELS. */
PD_API pd_status pd_field_plot_draw_image(pd_ctx *ctx, const pd_field_plot *picture, pd_image *image);

#ifdef PDI_APP_INTERNAL
/* Turn the smallest and largest value (log_scale: positive ones) into the ends of the range of colours. Logarithmic: lo
 * is raised to 1e-8 hi. Else diverging: symmetric to 0, -1..1 where both are 0. Other maps: unchanged. lo > hi: there
 * is no value; 0..1 results, logarithmic 1..10. */
PDI_FN void pdi_field_plot_adjust_range(pd_colour_map map, int log_scale, double *lo, double *hi);
#endif
/* Draw and write as PNG, or as SVG where the path ends in ".svg". Also PD_ERR_FILE. */
PD_API pd_status pd_field_plot_write(pd_ctx *ctx, const char *path, const pd_field_plot *picture);

#endif
