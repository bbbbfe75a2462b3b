/* crack: J integral of a crack and the place of its tip, from displacements of any material.
 *
 * J is what a crack that grows straight on releases per area. With a function q that is 1 at the tip and 0 far away it
 * is an integral over the points between (equivalent domain integral; Li, Shih and Needleman 1985): a mean over
 * contours of all radii between `inner` and `outer`. Where a material has bonds that pull, the same mean is taken of
 * the contours of peridynamics (Silling and Lehoucq 2010), which count the bonds that pass through them. Crack faces
 * have to be straight and parallel to `way` within `outer`. What loads or holds points there counts.
 */
#ifndef PD_CRACK_H
#define PD_CRACK_H
#include "solid/material_interface.h"

typedef struct pd_crack_desc {
    double tip[PD_DIM];   /* [m] place of the tip; in 3D any point of the front, which is straight */
    double direction[PD_DIM]; /* [-] direction in which the crack grows, of any length */
    double front[PD_DIM]; /* [-] 3D: direction of the front, at a right angle to way */
    double inner, outer;  /* [m] radii about the tip or front: q falls from 1 to 0 between them */
    double thickness;     /* [m] 3D: length of the front; J is the mean over it */
} pd_crack_desc;

#define pd_crack_j PD_NAME(pd_crack_j)
#define pd_crack_tip PD_NAME(pd_crack_tip)
#define pd_crack_find_tip PD_NAME(pd_crack_find_tip)

/* *j [J/m2] (1D: [N]) of displacements u [count][PD_DIM] [m] (theory: eqs. 15.14 and 15.15). PD_ERR_ARGUMENT: a place,
 * a direction or a radius out of range, or a material with neither force states and densities nor a linear stress.
 * PD_ERR_GEOMETRY: no points lie between the radii, their bonds do not span all directions, or a surface lies there
 * that is not parallel to the crack. PD_RETRY: u is no state of the material. *j is set with PD_OK alone. A later
 * tangent of the material is that of u. */
PD_API pd_status pd_crack_j(pd_ctx *ctx, const pd_material_interface *solid, const pd_crack_desc *desc, const double *u,
                            double *j);
/* The farthest point along `way` that has lost at least `share` (0: 0.15) of its bonds: the mean of all that are as
 * far, into tip [PD_DIM] [m]. A point beside a straight crack has lost the share of the ball of its family that lies
 * beyond the crack, and half of that where the crack ends. PD_ERR_ARGUMENT: a share or a direction out of range.
 * PD_RETRY: no point has lost so many, and tip is as it was. */
PD_API pd_status pd_crack_tip(pd_ctx *ctx, const pd_body *body, const double *way, double share, double *tip);
/* Tip of one crack among several: the one that began at a polyline, or around a polygon (3D), of `corners` corners
 * corner [corners][PD_DIM] [m]. Follows points that have lost at least 0.15 of their bonds from those within a horizon
 * of its edges to such neighbours, over broken bonds too. left [count]: metal left in a point; points where it is not
 * positive are skipped. tip, PD_RETRY and PD_ERR_ARGUMENT (direction): as of pd_crack_tip. */
PD_API pd_status pd_crack_find_tip(pd_ctx *ctx, const pd_body *body, int corners, const double *corner,
                                   const double *left, const double *way, double *tip);

#endif
