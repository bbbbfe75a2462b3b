/* picture: a field on a two-dimensional lattice as a PNG or SVG with axes, colour bar, title and time stamp. */
#ifndef PD_PICTURE_H
#define PD_PICTURE_H
#include "io/png.h"
#include "io/colour.h"

#define PD_PICTURE_WIDTH 1000 /* pixels that the width of a field aims at */
#define PD_PICTURE_SQUAT 0.9 /* times that: pixels that its height aims at */
#define PD_PICTURE_LEAST 120 /* smallest width that can be asked for */
#define PD_PICTURE_MOST 4000 /* largest one */
#define PD_PICTURE_CONTOURS 32 /* lines of one value, at most */
#define PD_PICTURE_FEWEST 4 /* streamlines or arrows side by side, at least */
#define PD_PICTURE_DENSEST 100 /* the same, at most */

/* What a cell shows. */
typedef enum pd_paint {
    PD_PAINT_FIELD = 0,
    PD_PAINT_SOLID = 1,  /* gray */
    PD_PAINT_WALL = 2,   /* dark */
    PD_PAINT_OUTSIDE = 3 /* blank paper */
} pd_paint;

/* Zero-initialise, then fill in. Cell (i, j) is values[j * nx + i], i to the right, j upward. */
typedef struct pd_picture {
    int nx, ny;
    const double *values;  /* [nx * ny] [-] in the unit of the label; NaN is shown in magenta */
    const uint8_t *paint;  /* [nx * ny] pd_paint; NULL: the field everywhere */
    double lo[2], hi[2];   /* [m] the rectangle that the cells fill */
    double range_lo, range_hi; /* [-] of the colours; equal: of the shown values (diverging: symmetric about 0) */
    pd_map map;
    int magnification;     /* pixels per cell; 0: so that the field is about `width` pixels wide */
    const char *title, *stamp, *label; /* "Mg pin", "t = 6.1 s", "C [mol/m3]"; NULL: none */
    int width;             /* [pixel] that the width of the field aims at, its height at 0.9 of that; 0: 1000 */
    int log;               /* 1: colours by the logarithm; values of zero and below are left blank */
    int smooth;            /* 1: linear between the middles of cells; 0: a cell has one colour */
    const char *axes[2];   /* "r"; NULL: x, y */
    int mirrored;          /* 1: the second axis counts distances from 0 */
    const char *widest;    /* stamp for which there is room, so that a series has one size; NULL: the own one */
    const char *const *names; /* [name_count] of the labels 0, 1, ..., in the legend; NULL: their numbers */
    const uint32_t *colours;  /* [name_count] 0xRRGGBB of these labels; NULL: one for each number */
    int name_count;
    int contour_count;        /* lines of one value, at most PD_PICTURE_CONTOURS; not with PD_MAP_LABELS */
    const double *contours;   /* [contour_count] [-] their values; NULL: they part the range of colours evenly */
    int streamlines;          /* of the velocity, evenly spaced: how many fit side by side into `width`, 4 to 100; 0:
                               * none are drawn */
    int vectors;              /* the same of arrows on a regular grid */
    const double *velocity;   /* [2][nx * ny] [m/s] along both axes; NaN: nothing flows there */
    double fastest;           /* [m/s] of the longest arrow; 0: the largest speed */
    int closed[4];            /* 1: nothing flows through the side x-, x+, y-, y+ */
} pd_picture;

#define pd_picture_write PD_NAME(pd_picture_write)

#ifdef PDI_INTERNAL
/* From the smallest and the largest value (log_scale: that is positive) to the ends of the range of colours: a
 * diverging one is symmetric, a logarithmic one has at most eight decades; lo > hi: there is no value. */
PDI_FN void pdi_picture_span(pd_map map, int log_scale, double *lo, double *hi);
/* Draw into an RGB image (freed by pdi_image_free). Scales of the axes are equal as far as whole pixels allow; a strip
 * thinner than 120 pixels is stretched and the axis says so. PD_ERR_ARGUMENT, PD_ERR_SIZE. */
PDI_FN pd_status pdi_picture_draw(pd_ctx *ctx, const pd_picture *picture, pd_image *image);
#endif
/* Draw and write as PNG, or as SVG where the path ends with ".svg". Also PD_ERR_FILE. */
PD_API pd_status pd_picture_write(pd_ctx *ctx, const char *path, const pd_picture *picture);

#endif
