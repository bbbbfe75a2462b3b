/* arrows: a flow over a picture, as streamlines with heads and as arrows on a regular grid. */
#ifndef PD_ARROWS_H
#define PD_ARROWS_H
#include "io/canvas.h"
#include "io/streamline.h"

#ifdef PDI_INTERNAL
typedef struct pdi_arrows {
    const pdi_stream *stream; /* its paper has the unit pixel */
    double left, bottom;      /* [pixel] where its corner stands; y is upward from there */
    double fastest;           /* [m/s] of an arrow as long as `longest` */
    double longest;           /* [pixel], and the distance between arrows */
} pdi_arrows;

/* With stream->mirrored also below the bottom. */
PDI_FN pd_status pdi_arrows_lines(pd_ctx *ctx, const pdi_arrows *arrows, pdi_canvas *canvas);
/* Arrows with their middles on a regular grid, as long as the fluid is fast. */
PDI_FN pd_status pdi_arrows_grid(pd_ctx *ctx, const pdi_arrows *arrows, pdi_canvas *canvas);
/* Of the arrow that explains their length: its speed [m/s], the largest of 1, 2 and 5 times a power of ten that is not
 * longer than `longest`; text[32]: "2 mm/s". */
PDI_FN double pdi_arrows_scale(double fastest, char *text);
/* An arrow from (x, y) to the right. */
PDI_FN pd_status pdi_arrows_one(pd_ctx *ctx, pdi_canvas *canvas, double x, double y, double length);
#endif

#endif
