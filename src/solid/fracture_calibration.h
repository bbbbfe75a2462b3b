/* fracture_calibration: calibration of the critical bond energy, so that a crack grows at a given fracture energy.
 *
 * Sums over a lattice (criterion, eq. 15.11) give the energy of the bonds that a crack cuts. In state-based models the
 * other bonds of a family take over the load of a broken one, so a crack needs more energy. How much follows from
 * a simulated crack in a strip of the same lattice, whose edges are moved apart: J does not depend on its length (Rice
 * 1968). Bonds break until the tip has advanced by some cells, and the largest J on the way is the effective fracture
 * energy. Forces are linear, so that J over the critical energy does not depend on either. In 3D the strip repeats
 * along the front of the crack after two layers of points, and is in plane strain. From period to period the front is a
 * cell ahead: a straight front has no step at which a bond is near to breaking, and needs more than those of any body
 * (theory: 15.7).
 */
#ifndef PD_FRACTURE_CALIBRATION_H
#define PD_FRACTURE_CALIBRATION_H
#include "solid/correspondence.h"

#ifdef PDI_INTERNAL
#if PD_DIM > 1
/* critical [J/m^(2d)]: critical bond energy (PD_BOND_FAILURE_ENERGY) of a body on a lattice, whose cracks along the
 * axes grow at `fracture` [J/m2]; stiffness factors are ignored. PD_ERR_GEOMETRY: no lattice; PD_ERR_ARGUMENT: in 3D a
 * horizon that is not 1.5 to 3 spacings; errors of the material and of the equilibrium. */
PDI_FN pd_status pdi_fracture_calibration_compute_critical(pd_ctx *ctx, const pd_body *body,
                                                           const pd_correspondence_desc *elastic, double fracture,
                                                           double *critical);
#endif
#endif

#endif
