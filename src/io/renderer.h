/* renderer: renders the surface of a body and its bounding box from one direction, with a z-buffer.
 *
 * The projection is orthographic: lengths across the line of sight have one scale everywhere. Shading is Lambertian
 * with one light from the upper left and an ambient part. Antialiasing: a pixel is the mean of several samples along
 * each axis.
 */
#ifndef PD_RENDERER_H
#define PD_RENDERER_H
#include "io/surface_nets.h"

/* A view and the image rendered in it. */
typedef struct pd_rendering {
    int width, height;          /* [pixel] */
    double pixel_size;          /* [m] size of a pixel */
    double right[3], up[3], eye[3]; /* [-] unit vectors of the view: right, up, and towards the eye */
    double corner[2];           /* [m] lower left corner of the image, along right and up */
    double lo[3], hi[3];        /* [m] bounding box */
    float *value;               /* [width * height] mean value of the samples that have one; NaN: none; row 0 on top */
    uint8_t *brightness;        /* [width * height] brightness of the surface, 1/255 of full light */
    uint8_t *coverage;          /* [width * height] number of samples that the body covers */
    uint8_t *edge;              /* [width * height] number of samples on visible edges of the box */
} pd_rendering;

#ifdef PDI_APP_INTERNAL
#define PDI_RENDERER_SAMPLES_PER_SIDE 3 /* samples of a pixel along each axis */
#define PDI_RENDERER_AMBIENT_LIGHT 0.3  /* fraction of ambient light */

/* Set up the view of the box lo[3]..hi[3] [m] from direction[3] (towards the eye, any length) and allocate the image:
 * `width` pixels wide with its margins, or less where its height would exceed 0.9 of that. Free it also on failure. */
PDI_FN pd_status pdi_renderer_build(pd_ctx *ctx, const double *lo, const double *hi, const double *direction, int width,
                                    pd_rendering *shade);
/* Free the image. A zeroed one is allowed. */
PDI_FN void pdi_renderer_free(pd_ctx *ctx, pd_rendering *shade);
/* Zero `shade` and set up the view alone, without memory: unit vectors, box, corner, scale and size in pixels. z is up
 * in the image; where the direction lies within 1e-6 of the z axis, y. The box with margins is `width` pixels wide, or
 * less where its height would exceed 0.9 of that. */
PDI_FN void pdi_renderer_init_view(const double *lo, const double *hi, const double *direction, int width,
                                   pd_rendering *shade);
/* Render a surface mesh and the edges of the box: set value, brightness, coverage and edge of all pixels, whatever they
 * held. labels 1: each face has its own value, and a pixel that of its first sample; 0: values are interpolated between
 * corners (faces without a value have none). Pixels off the body have NaN, 0 and 0. */
PDI_FN pd_status pdi_renderer_draw_surface(pd_ctx *ctx, const pdi_surface_nets_mesh *shell, int labels,
                                           pd_rendering *shade);
/* Project a point x[3] [m]: position[0], [1]: its pixel position, y down; position[2]: its depth [m] from the low
 * corner of the box, positive towards the eye. */
PDI_FN void pdi_renderer_project_point(const pd_rendering *shade, const double *x, double *position);
/* Project the ends of edge k of the box along axis d, low end a[3], high end b[3]. Bit 0 of k: at the high side of axis
 * d + 1, bit 1: of axis d + 2 (modulo 3). */
PDI_FN void pdi_renderer_project_box_edge(const pd_rendering *shade, int d, int k, double *a, double *b);
/* Brightness 0..1 of a surface with this outward unit normal (Lambert): PDI_RENDERER_AMBIENT_LIGHT where it faces away
 * from the light, which comes from the upper left of the image, else more by the cosine of the angle to it, up to 1. */
PDI_FN double pdi_renderer_compute_brightness(const pd_rendering *shade, const double *normal);
#endif

#endif
