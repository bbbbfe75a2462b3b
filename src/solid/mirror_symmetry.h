/* mirror_symmetry: a material with mirror images of its points behind planes of symmetry.
 *
 * The last points of the body are mirror images of others: they complete the families of points near a plane, and move
 * as the reflections of their points. The layer of images is three horizons thick, so that the forces on real points
 * are those of the complete body. Energies are those of the real points. Solvers see a pd_material_interface whose
 * images carry no forces; what they prescribe, load or compute at images is ignored.
 */
#ifndef PD_MIRROR_SYMMETRY_H
#define PD_MIRROR_SYMMETRY_H
#include "solid/material_interface.h"

typedef struct pd_mirror_symmetry {
    pd_material_interface material;
    int32_t count, images; /* points, and images, which come behind them */
    int32_t *image_source; /* [images] the point that an image stands for */
    uint8_t *image_reflection; /* [images] bit d: it is a reflection along axis d */
    uint8_t *is_image;         /* [count + images][PD_DIM] as of pd_material_interface */
    double *u, *v;         /* [count + images][PD_DIM] [m], [m/s] of all points; work */
    double *density;       /* [count + images] [J/m3] */
} pd_mirror_symmetry;

#ifdef PDI_INTERNAL
/* Allocates the arrays of images; count and images are set before, image_source and image_reflection are filled in
 * after the build. */
PDI_FN pd_status pdi_mirror_symmetry_build(pd_ctx *ctx, pd_mirror_symmetry *mirrored);
PDI_FN void pdi_mirror_symmetry_free(pd_ctx *ctx, pd_mirror_symmetry *mirrored);
/* The pd_material_interface table that wraps the one of a material, which is copied; its object is borrowed. Sets
 * is_image from image_reflection, which is filled in before: 1 for images along axes that they are not reflected along.
 * Bond energies and force states are NULL; other functions are NULL where the material has none, but energy and density
 * are always there and need its density. */
PDI_FN pd_material_interface pdi_mirror_symmetry_build_interface(pd_mirror_symmetry *mirrored,
                                                                 const pd_material_interface *material);
#endif

#endif
