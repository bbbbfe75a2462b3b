/* shade: a box and the surface of a body in it, seen from one direction, as light and values of pixels.
 *
 * The projection is orthographic: lengths across the line of sight have one scale everywhere. What is nearer hides what
 * lies behind (z-buffer). Light comes over the left shoulder; a matt surface sends (Lambert) the more the straighter it
 * is met, and everything has some light from around. A pixel is the mean of PDI_SHADE_SIDE^2 samples.
 */
#ifndef PD_SHADE_H
#define PD_SHADE_H
#include "io/shell.h"

typedef struct pd_shade {
    int width, height;          /* pixels */
    double size;                /* [m] of a pixel */
    double right[3], up[3], eye[3]; /* [-] unit vectors of the paper, and towards the eye */
    double corner[2];           /* [m] along right and up: the lower left corner of the paper */
    double lo[3], hi[3];        /* [m] the box */
    float *value;               /* [width * height] mean of the samples that have one; NaN: none has; row 0 on top */
    uint8_t *light;             /* [width * height] 1/255 of full light, of what is there */
    uint8_t *cover;             /* [width * height] samples that the body covers */
    uint8_t *edge;              /* [width * height] samples on edges of the box around the body and behind it */
} pd_shade;

#ifdef PDI_INTERNAL
#define PDI_SHADE_SIDE 3 /* samples of a pixel along each axis */
#define PDI_SHADE_AROUND 0.3 /* share of the light that comes from all directions */

/* way[3]: towards the eye, of any length. `width` pixels, or less where nine tenths of it were higher. */
PDI_FN pd_status pdi_shade_build(pd_ctx *ctx, const double *lo, const double *hi, const double *way, int width,
                                 pd_shade *shade);
PDI_FN void pdi_shade_free(pd_ctx *ctx, pd_shade *shade);
/* Pixels of a picture of a box: what pdi_shade_build would have. */
PDI_FN void pdi_shade_size(const double *lo, const double *hi, const double *way, int width, pd_shade *shade);
/* labels: values of faces as they are; else smooth between their corners. */
PDI_FN pd_status pdi_shade_draw(pd_ctx *ctx, const pdi_shell *shell, int labels, pd_shade *shade);
/* Where a place stands on the paper [pixel], y down, and how near it is [m]. */
PDI_FN void pdi_shade_project(const pd_shade *shade, const double *x, double *at);
/* Ends [3] of edge k, 0 to 3, of the box along axis d, projected. */
PDI_FN void pdi_shade_ends(const pd_shade *shade, int d, int k, double *a, double *b);
/* Light from 0 to 1 of a surface with this unit normal. */
PDI_FN double pdi_shade_light(const pd_shade *shade, const double *normal);
#endif

#endif
