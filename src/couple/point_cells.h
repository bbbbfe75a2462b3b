/* point_cells: grid cells of the material points of a body, and of their mirror images behind planes of symmetry; which
 * bonds lie within the metal, and which break as cells dissolve.
 */
#ifndef PD_POINT_CELLS_H
#define PD_POINT_CELLS_H
#include "lattice/grid.h"
#include "solid/body.h"

typedef struct pd_point_cells {
    const pd_grid *grid;  /* borrowed, as all down to flip */
    const int32_t *node;  /* [count] of the points */
    const int32_t *point; /* [total] of the nodes; -1: none */
    double *stiffness_factor; /* [count + images] [-] stiffness factor; 0: dissolved */
    double *depth;        /* [count + images] [m] below the surface, while the body is built */
    int32_t *image_source;     /* [images] as of pd_mirror_symmetry */
    uint8_t *image_reflection; /* [images] */
    double horizon_ratio;      /* [-] horizon over the spacing */
    int mirrors;          /* bit s: side s of the box is a plane of symmetry */
    int32_t count;        /* points */
    int32_t images;       /* of them, which come last */
    int32_t *cell;        /* [images][PD_DIM] cells of images, in the box as it goes on behind its sides */
    int32_t *next_image;  /* [count + images with images] the next image of the same point, -1: none */
    int32_t *cell_point;  /* [wide[0] ..] with images: the point of each cell of the extended box, -1: none */
    int32_t extended_cells[PD_DIM]; /* cells of the extended box along each axis */
    int lower_cells[PD_DIM];        /* of these below the lower side of the box */
} pd_point_cells;

#ifdef PDI_INTERNAL
/* Describes the arrays, for allocation and freeing: cells of mirror images, links from a point to its images, point of
 * each cell of the extended box. sites: a pd_point_cells with its counts. */
PDI_FN void pdi_point_cells_list(pdi_array_visitor *owner, void *sites);
/* Sizes the extended box (extended_cells, lower_cells) by grid, horizon and planes of symmetry, and adds to
 * sites->images, which is 0 before, the number of its cells outside of the box that mirror a solid node; none without
 * planes. grid, horizon_ratio and mirrors are set before. Nothing is allocated. */
PDI_FN void pdi_point_cells_count_images(pd_point_cells *sites);
/* Fills in the mirror images, numbered behind the points: cell, image_source, image_reflection, a stiffness factor of
 * 1, the links next_image and the map cell_point (-1: no metal). node and point are set before. Does nothing without
 * images. */
PDI_FN void pdi_point_cells_add_images(pd_point_cells *sites);
/* Initial position x [PD_DIM] [m] of a point or image; an image lies behind the sides of the box. */
PDI_FN void pdi_point_cells_position(const pd_point_cells *sites, int32_t i, double *x);
/* Sets the callback desc->joined, which decides which bonds lie within the initial metal, and its user, sites. Smooth
 * metal: the bond stays below the surface; sites->depth is filled in then, positive inside, for images, too. Other
 * metal: a staircase of metal cells joins the points. Leaves desc as it is for convex metal, where all bonds do. */
PDI_FN void pdi_point_cells_set_joined(pd_ctx *ctx, pd_point_cells *sites, pd_body_desc *desc);
/* Nodes turned [count] have become fluid: breaks all bonds of their points and images, and those of other points that
 * led through them alone, and sets their stiffness factors to 0. Nodes that were no point are skipped. Returns 1: at
 * least one of the nodes was a point of the body; 0: none. */
PDI_FN int pdi_point_cells_dissolve_nodes(const pd_point_cells *sites, pd_body *body, const int32_t *turned,
                                          int32_t count);
#endif

#endif
