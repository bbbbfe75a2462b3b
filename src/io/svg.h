/* svg: writes vector drawings as SVG 1.1. */
#ifndef PD_SVG_H
#define PD_SVG_H
#include "io/png.h"

#ifdef PDI_APP_INTERNAL
/* A drawing while it is made. Zero-initialise. The first failure is kept in status, and later calls do nothing. */
typedef struct pdi_svg {
    pd_ctx *ctx;
    pdi_bytes text;
    pd_status status;
    int clip_count;     /* number of clip rectangles so far */
    int clip_open;      /* 1: a clip rectangle is set */
    double path_end[2]; /* [pixel] end of the last stroke of the open path */
    int stroke_count;   /* number of strokes of the open path */
} pdi_svg;

/* Zero `svg` and begin a drawing on a white background. In all functions lengths are in pixels, colours 0xRRGGBB. */
PDI_FN void pdi_svg_begin(pd_ctx *ctx, int width, int height, pdi_svg *svg);
/* Add a filled rectangle; one of no width or height is left out. */
PDI_FN void pdi_svg_add_rectangle(pdi_svg *svg, int left, int top, int width, int height, uint32_t colour);
/* Add the outline of a rectangle as a line of one pixel, centred on its sides. */
PDI_FN void pdi_svg_add_frame(pdi_svg *svg, double left, double top, double width, double height, uint32_t colour);
/* Add a straight line with round ends. */
PDI_FN void pdi_svg_add_line(pdi_svg *svg, double xa, double ya, double xb, double yb, double width, uint32_t colour);
/* Begin a path of straight strokes (commands M and L); then add strokes and end it. */
PDI_FN void pdi_svg_begin_path(pdi_svg *svg);
/* Add a stroke from (xa, ya) to (xb, yb) to the open path; it continues the last one where that ends there. */
PDI_FN void pdi_svg_add_stroke(pdi_svg *svg, double xa, double ya, double xb, double yb);
/* End the path and set its line width and colour. */
PDI_FN void pdi_svg_end_path(pdi_svg *svg, double width, uint32_t colour);
/* Add a UTF-8 text with (x, y) on its baseline; nothing for an empty text. anchor: "start", "middle" or "end"; upward
 * 1: rotated to read upward; bold 1: in bold. &, < and > are escaped; control characters, also newlines and tabs, and
 * bytes that are no UTF-8 or not allowed in XML become question marks. */
PDI_FN void pdi_svg_add_text(pdi_svg *svg, double x, double y, const char *anchor, int upward, int bold,
                             uint32_t colour, const char *text);
/* Embed an image of 1 or 3 channels, as PNG in base64, with its upper left corner at (left, top). An error of
 * pdi_png_encode becomes the status. */
PDI_FN void pdi_svg_add_image(pdi_svg *svg, int left, int top, const pd_image *image);
/* Clip what follows to the rectangle, until the next call, or that of pdi_svg_end_clip, which ends this group. A
 * rectangle of no width or height hides all. */
PDI_FN void pdi_svg_set_clip(pdi_svg *svg, int left, int top, int width, int height);
/* End the clipped group, if there is one: what follows is not clipped. */
PDI_FN void pdi_svg_end_clip(pdi_svg *svg);
/* End the drawing and write it to a file; call it once. The drawing stays until pdi_svg_free. Returns the first failure
 * of the drawing, and no file is written then; PD_ERR_FILE. */
PDI_FN pd_status pdi_svg_write(pdi_svg *svg, const char *path);
/* Free the drawing. A zeroed one is allowed. */
PDI_FN void pdi_svg_free(pdi_svg *svg);
#endif

#endif
