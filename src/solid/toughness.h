/* toughness: the critical energy of bonds with which a crack runs at a given energy per area.
 *
 * What sums over a lattice give (criterion, eq. 8.29) is what bonds hold that a crack cuts. Families that take their
 * strain from many bonds hand on what a bond carried, so a crack of such a material needs more. How much follows from
 * a crack in a strip of the same lattice, whose edges are moved apart: J is the same wherever its tip is (Rice 1968).
 * Bonds break until the tip has gone on by some cells, and the largest J on the way is what the crack needs. Forces are
 * linear, so that J over the critical energy does not depend on either. In 3D the strip repeats along the front of the
 * crack after two layers of points, and is in plane strain. From period to period the front is a cell ahead: a straight
 * front has no step at which a bond is near to breaking, and needs more than those of any body (theory: 8.9).
 */
#ifndef PD_TOUGHNESS_H
#define PD_TOUGHNESS_H
#include "solid/elastic.h"

#ifdef PDI_INTERNAL
#if PD_DIM > 1
/* critical [J/m^(2d)]: energy of bonds (PD_CRITERION_ENERGY) of a body on a lattice, whose cracks along the axes run at
 * `fracture` [J/m2]; parts of E are left out. Errors: PD_ERR_GEOMETRY: no lattice; PD_ERR_ARGUMENT:
 * in 3D a horizon that is not 1.5 to 3 spacings; those of the material and of the equilibrium. */
PDI_FN pd_status pdi_toughness_find(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, double fracture,
                                    double *critical);
#endif
#endif

#endif
