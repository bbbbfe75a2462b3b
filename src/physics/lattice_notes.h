/* lattice_notes: notes on geometric and model errors of the lattice: volumes of metal, surfaces through nodes, ring
 * faces, the effective toughness of springs. */
#ifndef PD_LATTICE_NOTES_H
#define PD_LATTICE_NOTES_H
#include "physics/summary.h"

#define pd_lattice_notes_print PD_NAME(pd_lattice_notes_print)

/* Print notes: metal whose cells have another volume, surfaces on which nodes lie, ring faces, springs with a
 * toughness. */
PD_API void pd_lattice_notes_print(const pd_model *model, pd_print_fn print, void *user);
#ifdef PDI_INTERNAL
/* Volume of metal k by its shapes (*shape, within the box, less walls and later metals) and by its cells (*cells) [m3;
 * m2 in planar 2D, m in 1D]. *error [-]: relative error of the first. */
PDI_FN void pdi_lattice_notes_compute_volumes(const pd_model *model, int k, double *shape, double *cells,
                                              double *error);
#endif

#endif
