/* picture_memory: estimate of the memory of the pictures that a scene asks for, before anything is built.
 */
#ifndef PD_PICTURE_MEMORY_H
#define PD_PICTURE_MEMORY_H
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* [byte] Estimated memory of the largest picture that the setup asks for, 0: none; they are drawn one by one. Of
 * curves, the view of the metal surface (3D) and images of fields (2D, 3D, with both halves of an axisymmetric box) the
 * largest counts. A callback of pd_setup. */
PDI_FN double pdi_picture_memory_estimate(const pd_setup *setup);
#endif

#endif
