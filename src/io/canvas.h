/* canvas: drawing into an RGB image or as SVG: rectangles, antialiased lines and discs, text (in images with a built-in
 * bitmap font).
 *
 * Coordinates are pixels, x to the right, y down; colours are 0xRRGGBB. Nothing is drawn outside the clip rectangle.
 */
#ifndef PD_CANVAS_H
#define PD_CANVAS_H
#include "io/svg.h"

#ifdef PDI_APP_INTERNAL
#define PDI_CANVAS_CAPITAL_HEIGHT 14     /* [pixel] height of a capital letter */
#define PDI_CANVAS_TEXT_COLOUR 0x202124u /* colour of text, axes and frames */
#define PDI_CANVAS_BACKGROUND 0xFFFFFFu  /* colour of the background */

/* What is drawn on: an image or an SVG drawing. */
typedef struct pdi_canvas {
    pd_image image;               /* pixels; of an SVG drawing width and height alone */
    pdi_svg *svg;                 /* NULL: an image is drawn */
    int clip_left, clip_top, clip_right, clip_bottom; /* [pixel] clip rectangle, right and bottom excluded */
    int strokes_open;                                 /* 1: a set of strokes has been begun */
    uint8_t *coverage;      /* [width * height] 1/255 of each pixel that the strokes cover; NULL: none begun */
    double stroke_width;    /* [pixel] width of the strokes */
    uint32_t stroke_colour; /* colour of the strokes */
} pdi_canvas;

/* Horizontal alignment: which part of a text stands at its anchor point. */
typedef enum pdi_align {
    PDI_ALIGN_START,
    PDI_ALIGN_CENTRE,
    PDI_ALIGN_END
} pdi_align;

/* Draws `what`: makes the canvas, of pixels, or of SVG where svg is not NULL, and draws on it. */
typedef pd_status (*pdi_canvas_draw_fn)(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas);

/* Euclidean length sqrt(x^2 + y^2). Not hypot: C libraries differ in its last bit, and pictures would differ. */
PDI_FN double pdi_canvas_hypot(double x, double y);
/* Zero the canvas and make a white RGB image of width x height pixels, without clipping; free canvas->image with its
 * own function. PD_ERR_SIZE: no pixel, or more than PD_PNG_MAX_PIXELS. */
PDI_FN pd_status pdi_canvas_build_image(pd_ctx *ctx, int width, int height, pdi_canvas *canvas);
/* Zero canvas and svg and begin an empty SVG drawing of that size, without clipping. canvas->svg is svg; canvas->image
 * has a size, but no pixels. Free svg with its own function. PD_ERR_SIZE as above. */
PDI_FN pd_status pdi_canvas_build_svg(pd_ctx *ctx, int width, int height, pdi_svg *svg, pdi_canvas *canvas);
/* Embed an image in an SVG drawing, its upper left corner at (left, top). The canvas has to be of SVG. */
PDI_FN void pdi_canvas_draw_image(pdi_canvas *canvas, int left, int top, const pd_image *image);
/* Draw `what` with the callback `draw` into a new RGB image, which the caller frees. Errors are those of the callback;
 * the image is zeroed then, and there is nothing to free. */
PDI_FN pd_status pdi_canvas_draw_to_image(pd_ctx *ctx, pdi_canvas_draw_fn draw, const void *what, pd_image *image);
/* Draw `what` with the callback `draw` into a file: SVG where its name ends in ".svg" (lower case), else PNG. Errors
 * are those of the callback, and PD_ERR_FILE; an older file of that name stays then. */
PDI_FN pd_status pdi_canvas_draw_to_file(pd_ctx *ctx, const char *path, pdi_canvas_draw_fn draw, const void *what);
/* Set the clip rectangle [left, right) x [top, bottom), cut to the canvas. In SVG this ends the group that was clipped
 * before and begins another one, except for the whole canvas: what follows is not clipped then. */
PDI_FN void pdi_canvas_set_clip(pdi_canvas *canvas, int left, int top, int right, int bottom);
/* Set the clip rectangle to the whole canvas. */
PDI_FN void pdi_canvas_reset_clip(pdi_canvas *canvas);
/* Fill the part of the rectangle [left, right) x [top, bottom) inside the clip rectangle, without blending; nothing
 * where it is empty. */
PDI_FN void pdi_canvas_fill_rectangle(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour);
/* Draw a frame of one pixel just outside the rectangle [left, right) x [top, bottom). */
PDI_FN void pdi_canvas_draw_frame(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour);
/* Draw a straight antialiased line of this width [pixel] from (xa, ya) to (xb, yb) with round ends; pixel centres lie
 * at half-integers. Ends at one point give a disc. Nothing is drawn for NaN, for coordinates of 1e300 and more, or
 * outside the clip rectangle. Where a set of strokes is open, the line is added to it: with the colour of the set, and
 * in SVG with its width. */
PDI_FN void pdi_canvas_draw_line(pdi_canvas *canvas, double xa, double ya, double xb, double yb, double width,
                                 uint32_t colour);
/* Begin a set of strokes of one width [pixel] and colour; none may be open. Pixels where they overlap are blended once.
 * Allocates the coverage of an image, which ending the set frees; on failure no set is open. Add strokes, then end the
 * set, also after a failure in between. */
PDI_FN pd_status pdi_canvas_begin_strokes(pd_ctx *ctx, pdi_canvas *canvas, double width, uint32_t colour);
/* Add a straight stroke from (xa, ya) to (xb, yb), clipped, to the open set. */
PDI_FN void pdi_canvas_add_stroke(pdi_canvas *canvas, double xa, double ya, double xb, double yb);
/* Blend the set of strokes into the image, inside the present clip rectangle, and free its coverage; of SVG: close its
 * path. Nothing happens without an open set. */
PDI_FN void pdi_canvas_end_strokes(pd_ctx *ctx, pdi_canvas *canvas);
/* Draw a UTF-8 text; (x, y): anchor, at the top of the capitals. The bitmap font has ASCII, µ, ·, °, ×, superscript
 * digits, superscript + and -; in an image other characters become '?'. */
PDI_FN void pdi_canvas_draw_text(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour, const char *text);
/* Draw a text rotated to read upward; x: top of the capitals (their left side), y: anchor; the text starts at its lower
 * end. */
PDI_FN void pdi_canvas_draw_text_upward(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour,
                                        const char *text);
/* Draw a bold text from x on to the right; y: top of the capitals. */
PDI_FN void pdi_canvas_draw_bold_text(pdi_canvas *canvas, int x, int y, uint32_t colour, const char *text);
/* Width [pixel] of a UTF-8 text in the bitmap font, without the gap behind its last character; 0 for an empty text.
 * SVG, whose font differs, is laid out with it, too. */
PDI_FN int pdi_canvas_compute_text_width(const char *text);
#endif

#endif
