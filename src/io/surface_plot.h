/* surface_plot: picture of a rendered 3D surface as PNG or SVG, with the edges of the domain, a scale bar, colour bar
 * or legend, and title. */
#ifndef PD_SURFACE_PLOT_H
#define PD_SURFACE_PLOT_H
#include "io/colour.h"
#include "io/renderer.h"
#include "io/png.h"

#ifdef PDI_APP_INTERNAL
/* Zero-initialise, then fill in. */
typedef struct pdi_surface_plot {
    const pd_rendering *rendering; /* the rendered surface */
    int use_values;            /* 1: coloured by its values in the range lo..hi; 0: in the colour of metal */
    /* PD_COLOUR_MAP_LABELS: a colour for each whole number, and a legend of those that are seen */
    pd_colour_map map;
    int log;                /* 1: logarithmic colours */
    double lo, hi;          /* [-] range of colours, in the unit of the label */
    const char *const *names; /* [name_count] legend of the labels 0, 1, ...; NULL: their numbers */
    const uint32_t *colours;  /* [name_count] of these; NULL: those of pdi_colour_get_label_colour */
    int name_count;
    const char *title, *stamp, *label; /* NULL: none */
    const char *widest_stamp; /* longest stamp of a series, so that all its pictures have one size; NULL: stamp */
} pdi_surface_plot;

/* Draw into an RGB image (freed by its own function), zeroed on failure. PD_ERR_SIZE: more than PD_PNG_MAX_PIXELS. */
PDI_FN pd_status pdi_surface_plot_draw_image(pd_ctx *ctx, const pdi_surface_plot *relief, pd_image *image);
/* Draw and write as PNG, or as SVG where the path ends in ".svg". Also PD_ERR_FILE: an older file stays. */
PDI_FN pd_status pdi_surface_plot_write(pd_ctx *ctx, const char *path, const pdi_surface_plot *relief);
#endif

#endif
