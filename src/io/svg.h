/* svg: a drawing as vectors and text, SVG 1.1. */
#ifndef PD_SVG_H
#define PD_SVG_H
#include "io/png.h"

#ifdef PDI_INTERNAL
/* Zero-initialise. Of a failure the first is kept, and what comes later does nothing. */
typedef struct pdi_svg {
    pd_ctx *ctx;
    pdi_bytes text;
    pd_status status;
    int clips;   /* so far */
    int clipped; /* one is open */
    double at[2]; /* end of the last stroke of a path */
    int strokes;  /* of the open path */
} pdi_svg;

/* Colours 0xRRGGBB; lengths in pixels. */
PDI_FN void pdi_svg_begin(pd_ctx *ctx, int width, int height, pdi_svg *svg);
PDI_FN void pdi_svg_rectangle(pdi_svg *svg, int left, int top, int width, int height, uint32_t colour);
PDI_FN void pdi_svg_frame(pdi_svg *svg, double left, double top, double width, double height, uint32_t colour);
PDI_FN void pdi_svg_line(pdi_svg *svg, double xa, double ya, double xb, double yb, double width, uint32_t colour);
/* A path of straight strokes, [M L]: begin, add, end. */
PDI_FN void pdi_svg_path(pdi_svg *svg);
PDI_FN void pdi_svg_stroke(pdi_svg *svg, double xa, double ya, double xb, double yb);
PDI_FN void pdi_svg_path_end(pdi_svg *svg, double width, uint32_t colour);
/* anchor: "start", "middle", "end"; up: turned to read upward; (x, y): on the baseline. UTF-8; signs that XML does not
 * have become question marks. */
PDI_FN void pdi_svg_text(pdi_svg *svg, double x, double y, const char *anchor, int up, int bold, uint32_t colour,
                         const char *text);
/* An image as PNG, at its size. */
PDI_FN void pdi_svg_image(pdi_svg *svg, int left, int top, const pd_image *image);
/* What follows is cut to the rectangle, until the next call; width 0: to nothing. */
PDI_FN void pdi_svg_clip(pdi_svg *svg, int left, int top, int width, int height);
/* End it, and write the file aside and rename it. The first failure. */
PDI_FN pd_status pdi_svg_write(pdi_svg *svg, const char *path);
PDI_FN void pdi_svg_free(pdi_svg *svg);
#endif

#endif
