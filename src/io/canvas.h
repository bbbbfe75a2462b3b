/* canvas: drawing on an RGB image, or as vectors: rectangles, smooth lines and discs, text, in images in a font of our
 * own.
 *
 * Coordinates are pixels, x to the right, y down; colours are 0xRRGGBB. Drawing outside the clip rectangle is cut.
 */
#ifndef PD_CANVAS_H
#define PD_CANVAS_H
#include "io/svg.h"

#ifdef PDI_INTERNAL
#define PDI_CANVAS_CAPITAL 14 /* height of a capital letter */
#define PDI_CANVAS_INK 0x202124u /* colour of text */
#define PDI_CANVAS_PAPER 0xFFFFFFu /* colour of the ground */

typedef struct pdi_canvas {
    pd_image image;               /* vectors: without pixels */
    pdi_svg *svg;                 /* NULL: pixels */
    int left, top, right, bottom; /* clip rectangle, right and bottom excluded */
    int drawing;                  /* 1: a drawing of strokes is open */
    uint8_t *cover;               /* [width * height] pixels: 1/255 of what it covers; NULL: none is open */
    double stroke;                /* its width */
    uint32_t ink;                 /* its colour */
} pdi_canvas;

/* Where a text stands relative to its anchor. */
typedef enum pdi_align {
    PDI_ALIGN_START,
    PDI_ALIGN_CENTRE,
    PDI_ALIGN_END
} pdi_align;

/* Makes a canvas of pixels, or of vectors where svg is not NULL, and draws `what` on it. */
typedef pd_status (*pdi_canvas_fn)(pd_ctx *ctx, const void *what, pdi_svg *svg, pdi_canvas *canvas);

/* Length on paper. Not hypot, whose last bit C libraries differ in, and with it pictures. */
PDI_FN double pdi_canvas_length(double x, double y);
/* A blank sheet; free image with pdi_image_free. */
PDI_FN pd_status pdi_canvas_init(pd_ctx *ctx, int width, int height, pdi_canvas *canvas);
/* The same with vectors; free svg with pdi_svg_free. */
PDI_FN pd_status pdi_canvas_vectors(pd_ctx *ctx, int width, int height, pdi_svg *svg, pdi_canvas *canvas);
/* Draw an image, its upper left corner there; of vectors alone. */
PDI_FN void pdi_canvas_image(pdi_canvas *canvas, int left, int top, const pd_image *image);
/* What `on` draws: as pixels, freed with pdi_image_free, or in a file, of vectors where its name ends in .svg. */
PDI_FN pd_status pdi_canvas_draw(pd_ctx *ctx, pdi_canvas_fn on, const void *what, pd_image *image);
PDI_FN pd_status pdi_canvas_file(pd_ctx *ctx, const char *path, pdi_canvas_fn on, const void *what);
PDI_FN void pdi_canvas_clip(pdi_canvas *canvas, int left, int top, int right, int bottom);
PDI_FN void pdi_canvas_unclip(pdi_canvas *canvas);
/* Fill [left, right) x [top, bottom). */
PDI_FN void pdi_canvas_fill(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour);
/* A one-pixel frame just outside the same rectangle. */
PDI_FN void pdi_canvas_frame(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour);
/* Straight stroke with round ends; pixel centres lie at half-integers. */
PDI_FN void pdi_canvas_line(pdi_canvas *canvas, double xa, double ya, double xb, double yb, double width,
                            uint32_t colour);
/* Strokes of one width and colour that are painted once where they meet. Begin it, add strokes, end it, also after a
 * failure in between. */
PDI_FN pd_status pdi_canvas_strokes(pd_ctx *ctx, pdi_canvas *canvas, double width, uint32_t colour);
PDI_FN void pdi_canvas_stroke(pdi_canvas *canvas, double xa, double ya, double xb, double yb);
PDI_FN void pdi_canvas_strokes_end(pd_ctx *ctx, pdi_canvas *canvas);
/* UTF-8 text of ASCII, µ, ·, °, × and raised digits; y is the top of the capitals. */
PDI_FN void pdi_canvas_text(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour, const char *text);
/* The same turned to read upward; x is the top of the capitals (their left side), y the anchor. */
PDI_FN void pdi_canvas_text_up(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour, const char *text);
/* Bold text, starting at x. */
PDI_FN void pdi_canvas_title(pdi_canvas *canvas, int x, int y, uint32_t colour, const char *text);
/* Width of a text [pixel]. */
PDI_FN int pdi_canvas_text_width(const char *text);
#endif

#endif
