/* line_laplacian: fast peridynamic Laplacian of nodes with full families, by grid lines along axis 0.
 *
 * The difference over a bond is that along its grid line plus that between the lines, and lines with the same weights
 * share the products (stencil.h). A node costs one addition for each line and one product for each kind of lines and
 * layer, instead of one for each bond: 12 products for 36 bonds (2D, m = 3), 24 for 178 (3D). Only differences are
 * summed, so constants give exact zeros.
 */
#ifndef PD_LINE_LAPLACIAN_H
#define PD_LINE_LAPLACIAN_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* Operands of the Laplacian, all borrowed. shift [lines]: that of pdi_grid_compute_line_shifts. */
typedef struct pdi_line_laplacian_data {
    const pd_grid *grid;
    const pd_stencil *stencil;
    const int32_t *shift;
} pdi_line_laplacian_data;
/* out [length] = Laplacian sum a (f_j - f_i) [unit of f / m2] at the nodes i .. i+length-1 of f [total] (eq. 1.3),
 * whose families must be full; far ends are read from f, ghosts included. Planar weights: not for axisymmetric grids.
 */
PDI_FN void pdi_line_laplacian_apply(const pdi_line_laplacian_data *lines, const double *f, int32_t i, int32_t length,
                                     double *out);
#endif

#endif
