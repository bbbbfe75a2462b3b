/* sample: values of the fields of a model at nodes, and interpolated at points. */
#ifndef PD_SAMPLE_H
#define PD_SAMPLE_H
#include "physics/model.h"

#define pd_sample_get_node PD_NAME(pd_sample_get_node)
#define pd_sample_get_point PD_NAME(pd_sample_get_point)
#define pd_sample_get_probe PD_NAME(pd_sample_get_probe)
#define pd_sample_is_inside PD_NAME(pd_sample_is_inside)
#define pd_sample_prepare PD_NAME(pd_sample_prepare)

/* Value of a scalar field at a node [unit of the field]; of a velocity or displacement its norm. 0 where the model has
 * no such field, NaN where a dissolved field is undefined since the node was just converted to fluid. `phase` is 1 in
 * solid nodes. Metal left in a node is in `density`; C is the dissolved concentration. */
PD_API double pd_sample_get_node(const pd_model *m, pd_field field, int32_t node);
/* Fill the ghosts of concentrations, and compute those of `fields` that are computed on request. Call it before
 * pd_sample_get_point, and before pd_sample_get_node of such a field, at each output time. */
PD_API void pd_sample_prepare(pd_ctx *ctx, pd_model *m, pd_fields fields);
/* Value of a field at the point x [m] of the box. C, species and v (its component): a least-squares quadratic through
 * nodes and surfaces around x; p along its gradient (theory: 1.7). Of a gas, pH and potentials: linear between fluid
 * nodes. The mean over the fluid cells that x touches; in a closed cell near a smooth surface the nearest fluid nodes;
 * behind it in a fluid cell: from the surface. NaN: no fluid with a value. Rates, current densities and states: mean of
 * the cells with one; other fields: of the cell. */
PD_API double pd_sample_get_point(const pd_model *m, pd_field field, int component, const double *x);
/* The same for a probe: 0 instead of NaN, for fields of the fluid in metal and walls. NaN stays for surface fields, and
 * where x touches a cell just converted to fluid. */
PD_API double pd_sample_get_probe(const pd_model *m, pd_field field, int component, const double *x);
/* 1: x touches a solid cell, or there are fluid nodes that give a value there; 0: deep in a wall. */
PD_API int pd_sample_is_inside(const pd_model *m, const double *x);

#endif
