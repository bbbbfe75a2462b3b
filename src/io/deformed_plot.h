/* deformed_plot: picture of a field on the deformed configuration.
 *
 * A cell is drawn as the quadrilateral of its displaced corners. A corner moves by the mean displacement of the cells
 * that meet there and are connected: there is no gap between those, and cracks between others open.
 */
#ifndef PD_DEFORMED_PLOT_H
#define PD_DEFORMED_PLOT_H
#include "io/field_plot.h"

#ifdef PDI_APP_INTERNAL
/* A picture and the displacements of its cells. */
typedef struct pdi_deformed_plot {
    const pd_field_plot *undeformed; /* the undeformed picture; its magnification is not used */
    const double *displacement;   /* [2][nx * ny] [m] displacements, already multiplied by their scale; NaN: none */
    int (*is_connected)(const void *user, int cell, int other); /* 1: the two neighbouring cells are connected */
    const void *user;
    double lo[2], hi[2];     /* [m] extent of the picture; lo == hi: large enough for all displaced cells */
} pdi_deformed_plot;

/* Extend lo[2] .. hi[2] [m] to the undeformed picture and all displaced corners; start with lo above hi. Cells of NaN
 * are skipped. PD_ERR_ARGUMENT: a displaced corner lies farther from the low corner of the picture, along an axis, than
 * ten times its size there; lo and hi may have changed. */
PDI_FN pd_status pdi_deformed_plot_extend_range(pd_ctx *ctx, const pdi_deformed_plot *warp, double *lo, double *hi);

/* Draw into an RGB image (freed by its own function), zeroed on failure; what moves beyond the extent is cut off. Where
 * displaced cells overlap, the later one is seen; cells of NaN are drawn in place, below. The undeformed picture has no
 * streamlines and arrows. Errors as of pd_field_plot_draw_image. PD_ERR_ARGUMENT also, where no extent is given: as of
 * pdi_deformed_plot_extend_range. */
PDI_FN pd_status pdi_deformed_plot_draw_image(pd_ctx *ctx, const pdi_deformed_plot *warp, pd_image *image);
/* Draw and write as PNG, or as SVG where the path ends in ".svg". */
PDI_FN pd_status pdi_deformed_plot_write(pd_ctx *ctx, const char *path, const pdi_deformed_plot *warp);
#endif

#endif
