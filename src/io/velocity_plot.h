/* velocity_plot: draws a velocity field over a picture: streamlines with arrow heads, and arrows on a regular grid. */
#ifndef PD_VELOCITY_PLOT_H
#define PD_VELOCITY_PLOT_H
#include "io/canvas.h"
#include "io/streamline.h"

#ifdef PDI_APP_INTERNAL
/* A velocity field and where it is drawn. */
typedef struct pdi_velocity_plot {
    const pdi_streamline_field *field; /* velocity field; its lengths in the picture are in pixels */
    double left, bottom;      /* [pixel] lower left corner of the field on the canvas; y is upward from there */
    double max_speed;         /* [m/s] speed of an arrow of the length max_length */
    double max_length;        /* [pixel] length of the longest arrow, and distance between arrows */
} pdi_velocity_plot;

/* Draw evenly spaced streamlines with arrow heads; where the field is mirrored, also their mirror images below. */
PDI_FN pd_status pdi_velocity_plot_draw_streamlines(pd_ctx *ctx, const pdi_velocity_plot *arrows, pdi_canvas *canvas);
/* Draw arrows centred on a regular grid, about max_length apart, with lengths proportional to the speed; short ones are
 * left out. */
PDI_FN pd_status pdi_velocity_plot_draw_arrows(pd_ctx *ctx, const pdi_velocity_plot *arrows, pdi_canvas *canvas);
/* Speed [m/s] of the reference arrow in the key: the largest of 1, 2 and 5 times a power of ten that does not exceed
 * `max_speed` [m/s] > 0. text[32]: its label, "2 mm/s". */
PDI_FN double pdi_velocity_plot_reference_speed(double max_speed, char *text);
/* Draw one arrow from (x, y) to the right, its length in pixels. */
PDI_FN pd_status pdi_velocity_plot_draw_one_arrow(pd_ctx *ctx, pdi_canvas *canvas, double x, double y, double length);
#endif

#endif
