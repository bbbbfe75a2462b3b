/* toughness: the critical energy of bonds with which a crack runs at a given energy per area.
 *
 * What sums over a lattice give (criterion, eq. 8.29) is what bonds hold that a crack cuts. Families that take their
 * strain from many bonds hand on what a bond carried, so a crack of such a material needs more. How much follows from
 * a crack in a strip of the same lattice, whose edges are moved apart: J is the same wherever its tip is (Rice 1968).
 * Bond after bond breaks until the tip has gone on by some cells, and the largest J on the way is what the crack needs.
 * Forces are linear, so that J over the critical energy does not depend on either (theory: 8.9).
 */
#ifndef PD_TOUGHNESS_H
#define PD_TOUGHNESS_H
#include "solid/elastic.h"

#ifdef PDI_INTERNAL
#if PD_DIM == 2
/* critical [J/m^(2d)]: energy of bonds (PD_CRITERION_ENERGY) of a body on a lattice, whose cracks along the axes run at
 * `fracture` [J/m2]; parts of E are left out. Errors: PD_ERR_GEOMETRY: no lattice; those of the material and of the
 * equilibrium. */
PDI_FN pd_status pdi_toughness_find(pd_ctx *ctx, const pd_body *body, const pd_elastic_desc *elastic, double fracture,
                                    double *critical);
#endif
#endif

#endif
