/* rim: the part of a cell of a lattice that lies within a ball.
 *
 * The ball has its centre in a point, the cell is an interval, a square or a cube around another one. The part follows
 * in closed form from the volumes of the ball beyond the corners of the cell, which are integrals of arc sines
 * (theory: eq. 8.14).
 */
#ifndef PD_RIM_H
#define PD_RIM_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Part [-] of the cell with sides `size` [m] around the place xi [m] that lies within the ball of this radius [m]
 * around 0: from 0 to 1. Mirror images of xi have the same bits. */
PDI_FN double pdi_rim_part(const double *xi, double size, double radius);
/* 1: the cell reaches into the ball by more than the rounding of places. */
PDI_FN int pdi_rim_meets(const double *xi, double size, double radius);
#endif

#endif
