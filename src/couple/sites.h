/* sites: the cells in which the points of a body on a grid are, and those of their images behind planes of symmetry;
 * which bonds leave the metal.
 */
#ifndef PD_SITES_H
#define PD_SITES_H
#include "lattice/grid.h"
#include "solid/body.h"

typedef struct pd_sites {
    const pd_grid *grid;  /* borrowed, as all down to flip */
    const int32_t *node;  /* [count] of the points */
    const int32_t *point; /* [total] of the nodes; -1: none */
    double *stiff;        /* [count + images] [-] 0: the metal has gone */
    double *depth;        /* [count + images] [m] below the surface, while the body is built */
    int32_t *of;          /* [images] as of pd_mirrored */
    uint8_t *flip;        /* [images] */
    double m;             /* [-] horizon over the spacing */
    int mirrors;          /* bit s: side s of the box is a plane of symmetry */
    int32_t count;        /* points */
    int32_t images;       /* of them, which come last */
    int32_t *cell;        /* [images][PD_DIM] cells of images, in the box as it goes on behind its sides */
    int32_t *chain;       /* [count + images with images] the next image of the same point, -1: none */
    int32_t *chart;       /* [wide[0] ..] with images the point of each cell, -1: none */
    int32_t wide[PD_DIM]; /* cells of it along each axis */
    int below[PD_DIM];    /* of these behind the lower side */
} pd_sites;

#ifdef PDI_INTERNAL
/* Arrays of images: of a body that has some. */
PDI_FN void pdi_sites_list(pdi_owner *owner, void *sites);
/* How many images there are, by grid, m and mirrors. */
PDI_FN void pdi_sites_reflect(pd_sites *sites);
/* The images, behind the points. */
PDI_FN void pdi_sites_images(pd_sites *sites);
/* Place of a point or image [m]. */
PDI_FN void pdi_sites_place(const pd_sites *sites, int32_t i, double *x);
/* Which bonds leave the metal of the start is to be asked of these. */
PDI_FN void pdi_sites_joined(pd_ctx *ctx, pd_sites *sites, pd_body_desc *desc);
/* Nodes have turned fluid: they lose their bonds, and so do others whose bonds led through them alone. 1: one of them
 * was a point. */
PDI_FN int pdi_sites_go(const pd_sites *sites, pd_body *body, const int32_t *turned, int32_t count);
#endif

#endif
