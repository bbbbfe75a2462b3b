/* lattice_notes: notes on geometric and model errors of the lattice: volumes of metal, surfaces through nodes, ring
 * faces, the effective toughness of springs. */
#ifndef PD_LATTICE_NOTES_H
#define PD_LATTICE_NOTES_H
#include "physics/summary.h"

#define pd_lattice_notes_print PD_NAME(pd_lattice_notes_print)

/* Print notes, each only where it applies: nodes on surfaces of metal, wall, medium, solution and passive film; metal
 * whose cells have another volume than its shape; with surface dissolution, ring faces; springs with a toughness in
 * statics. */
PD_API void pd_lattice_notes_print(const pd_model *model, pd_print_fn print, void *user);
#ifdef PDI_INTERNAL
/* Volume of metal k by its shapes (*shape, within the box, less walls and later metals) and by its solid cells (*cells)
 * [m3, rings as a whole; m2 in planar 2D, m in 1D]. *error [-]: relative change of the first by the last subdivision,
 * 1e-3 without one. */
PDI_FN void pdi_lattice_notes_compute_volumes(const pd_model *model, int k, double *shape, double *cells,
                                              double *error);
#endif

#endif
