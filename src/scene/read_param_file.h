/* read_param_file: reads the flat `key = value` parameter file of the Mg-pin project (SI numbers without units) into a
 * setup.
 *
 * 2D: a plane channel of half-width R_tube along x with a slab of half-thickness R_wire from x = 0 to L_wire.
 * 3D: a tube along x with a wire. R_wire = 0: no pin. The inflow is a parabola of mean speed Q_flow / (pi R_tube^2).
 * axisymmetric = 1, 2D: that wire and tube around the axis y = 0.
 *
 * A rate becomes a recession speed, whatever dx a run overrides: that of a plane front along an axis on the lattice of
 * the file's own dx. k_corr [1/s] takes k_corr f a second from a node, f the share of its neighbours that are fluid;
 * the front passes dx in (C_solid_init - C_thresh)/(k_corr S), S the sum of f over the rows that have fluid in reach. A
 * file with D_grain or D_gb and no k_corr is of the later sort, where metal diffuses across the surface, with the
 * harmonic mean D of both sides: dC/dt = -C sum 4 D/(pi delta^2) V/xi^2, dx in ln(C_solid_init/C_thresh)/(the sum over
 * rows). Where k_corr, or D of one side, is 0, no metal dissolves.
 */
#ifndef PD_READ_PARAM_FILE_H
#define PD_READ_PARAM_FILE_H
#include "scene/text.h"
#include "setup/setup.h"

#ifdef PDI_APP_INTERNAL
/* Fill the setup from a flat text. Overrides are applied here, because k_corr refers to dx as it stands in the file. A
 * known key without effect on this solver adds a note. PD_ERR_PARSE with file:line: an unknown key. PD_ERR_ARGUMENT
 * with file:line: in 1D, a number out of bounds, a box that is not of whole cells, R_wire not below R_tube, C_thresh
 * not below C_solid_init, D_grain = 0 where D_gb is not. */
PDI_FN pd_status pdi_read_param_file_read(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count,
                                          pd_setup *setup);
#endif

#endif
