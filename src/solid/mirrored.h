/* mirrored: a material whose body goes on behind planes of symmetry, as a material of its points alone.
 *
 * The last points of the body are images of others: they bring the families of points near a plane to what they are in
 * the whole body, and move as the reflections of their points. Images go on for three horizons, so that all that the
 * forces of points depend on is that of the whole body. Energies are those of the points: the part of the body that is
 * there. What solvers hold, load or find of images is not looked at.
 */
#ifndef PD_MIRRORED_H
#define PD_MIRRORED_H
#include "solid/solid.h"

typedef struct pd_mirrored {
    pd_solid inner;
    int32_t count, images; /* points, and images, which come behind them */
    int32_t *of;           /* [images] the point that an image stands for */
    uint8_t *flip;         /* [images] bit d: it is a reflection along axis d */
    uint8_t *follows;      /* [count + images][PD_DIM] as of pd_solid */
    double *u, *v;         /* [count + images][PD_DIM] [m], [m/s] of all points; work */
    double *density;       /* [count + images] [J/m3] */
} pd_mirrored;

#ifdef PDI_INTERNAL
/* count and images are set, and of and flip follow the build. */
PDI_FN pd_status pdi_mirrored_build(pd_ctx *ctx, pd_mirrored *mirrored);
PDI_FN void pdi_mirrored_free(pd_ctx *ctx, pd_mirrored *mirrored);
/* Its table, of a material that is borrowed. */
PDI_FN pd_solid pdi_mirrored_solid(pd_mirrored *mirrored, const pd_solid *inner);
#endif

#endif
