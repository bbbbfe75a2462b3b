/* line: the Laplacian of nodes with whole families by lines along axis 0.
 *
 * The difference over a bond is that along its line plus that between the lines, and lines with the same weights share
 * theirs (stencil.h). A node costs one addition a line and one product a kind of lines and layer, instead of one a
 * bond: 12 products for 36 bonds (2D, m = 3), 24 for 178 (3D). Only differences are summed, so constants come out as
 * exact zeros.
 */
#ifndef PD_LINE_H
#define PD_LINE_H
#include "lattice/grid.h"

#ifdef PDI_INTERNAL
/* What the sweeps have to know of a lattice; shift: that of pdi_grid_line_shift. All borrowed. */
typedef struct pdi_lines {
    const pd_grid *grid;
    const pd_stencil *stencil;
    const int32_t *shift;
} pdi_lines;
/* out [length] = sum a (f_j - f_i) for the nodes i .. i+length-1 of f [total] (eq. 2.3). */
PDI_FN void pdi_line_laplacian(const pdi_lines *lines, const double *f, int32_t i, int32_t length, double *out);
#endif

#endif
