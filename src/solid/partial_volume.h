/* partial_volume: partial volume: the fraction of a lattice cell that lies within the horizon, which is a ball.
 *
 * The ball has its centre in a point, the cell is an interval, a square or a cube around another one. The fraction
 * follows in closed form from the volumes of the ball beyond the corners of the cell, which are integrals of arc sines
 * (theory: eq. 14.19).
 */
#ifndef PD_PARTIAL_VOLUME_H
#define PD_PARTIAL_VOLUME_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Volume fraction [-], 0 to 1, of the cell with edges `size` [m] around xi [m] that lies within the ball of this radius
 * [m] around 0: 0 unless pdi_partial_volume_is_inside, 1 where the farthest corner lies in the ball, otherwise in
 * closed form. Mirror images of xi have the same bits. */
PDI_FN double pdi_partial_volume_compute_fraction(const double *xi, double size, double radius);
/* 1: the cell around xi intersects the ball by more than rounding: its nearest place is < (1 - 1e-9) radius from 0. */
PDI_FN int pdi_partial_volume_is_inside(const double *xi, double size, double radius);
#endif

#endif
