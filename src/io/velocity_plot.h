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

/* Draw evenly spaced streamlines with arrow heads over a light outline of them; where the field is mirrored, also their
 * mirror images below `bottom`. Nothing where nothing flows. */
PDI_FN pd_status pdi_velocity_plot_draw_streamlines(pd_ctx *ctx, const pdi_velocity_plot *arrows, pdi_canvas *canvas);
/* Draw arrows centred on a regular grid, at least max_length apart (at least one along each axis), with lengths
 * proportional to the speed; those shorter than 3 pixels are left out, and all where max_speed is not positive. */
PDI_FN pd_status pdi_velocity_plot_draw_arrows(pd_ctx *ctx, const pdi_velocity_plot *arrows, pdi_canvas *canvas);
/* Speed [m/s] of the reference arrow in the key: the largest of 1, 2 and 5 times a power of ten that does not exceed
 * `max_speed` [m/s] > 0, up to 1e-9 of it. text[32]: its label, "2 mm/s", in the largest unit from nm/s to km/s of
 * which it is at least 0.04. */
PDI_FN double pdi_velocity_plot_reference_speed(double max_speed, char *text);
/* Draw one arrow, without outline, from (x, y) to the right, its length in pixels and positive. */
PDI_FN pd_status pdi_velocity_plot_draw_one_arrow(pd_ctx *ctx, pdi_canvas *canvas, double x, double y, double length);
#endif

#endif
