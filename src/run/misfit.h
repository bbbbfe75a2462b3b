/* misfit: how the cells of the lattice, and cracks of springs, differ from what the scene asks for, in notes. */
#ifndef PD_MISFIT_H
#define PD_MISFIT_H
#include "run/summary.h"

#ifdef PDI_INTERNAL
/* Volume of metal k of the setup as its shapes hold it within the box, less walls and later metals, and that of its
 * cells [m3; m2 in planar 2D, m in 1D]; *error [-]: what the first may be off by, over it. */
PDI_FN void pdi_misfit_volumes(const pd_model *model, int k, double *shape, double *cells, double *error);
/* Notes: metal whose cells have another volume, surfaces on which nodes lie, and springs with a toughness. */
PDI_FN void pdi_misfit_print(const pd_model *model, pd_print_fn print, void *user);
#endif

#endif
