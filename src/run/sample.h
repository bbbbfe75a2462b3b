/* sample: values of the fields of a model at nodes and at points. */
#ifndef PD_SAMPLE_H
#define PD_SAMPLE_H
#include "run/model.h"

#ifdef PDI_INTERNAL
/* Value of a scalar field at a node, of v its length; 0 where the field has none, NaN where a node has just
 * turned fluid. The metal left in a node is in
 * `density`, C is what the fluid has dissolved. */
PDI_FN double pdi_sample_node(const pd_model *m, pd_field field, int32_t node);
/* Fill the ghosts of the concentration, and of `fields` what is known on demand alone; before
 * pdi_sample_point, and pdi_sample_node of such a field, are called for an instant. */
PDI_FN void pdi_sample_prepare(pd_ctx *ctx, pd_model *m, pd_fields fields);
/* Value at the place x [m] of the box: C, species and v (its component) of the quadratic that fits nodes and surfaces
 * around x best, p along its gradient (theory: 3.6; with bond-based corrosion linear between fluid nodes), as the mean
 * over the fluid cells that x touches; pH linear between fluid nodes. A place on or before a smooth surface in a closed
 * cell is taken from the nearest fluid nodes, one behind the surface in a fluid cell from the surface; NaN where there
 * is no fluid. Other fields: of the cell. */
PDI_FN double pdi_sample_point(const pd_model *m, pd_field field, int component, const double *x);
/* What a probe shows: the same, and 0 in the metal where only fluid has a value. */
PDI_FN double pdi_sample_probe(const pd_model *m, pd_field field, int component, const double *x);
/* 1 when x touches a cell of solid, or fluid nodes give the value there. */
PDI_FN int pdi_sample_inside(const pd_model *m, const double *x);
#endif

#endif
