/* polarise: electrodes of a setup among ions that migrate: their curves at the surface, where they lie, what passes.
 *
 * The cell tells contacts and circuits. What passes is found with the steps of the species (react/levels.h).
 */
#ifndef PD_POLARISE_H
#define PD_POLARISE_H
#include "metal/dissolve.h"
#include "react/etch.h"
#include "run/electrodes.h"

typedef struct pd_polarise {
    const pd_setup *setup;
    pd_electrode_map *map;
    pd_cell *cell;
    pd_etch *etch;
    double *part;                                  /* [electrodes][species] [-] see pd_etch_electrodes */
    uint32_t reads[PD_SETUP_ELECTRODES];
    pd_etch_circuit circuit[PD_SETUP_ELECTRODES];
    int falls;                                     /* 1: a law of metal or a curve falls somewhere as E rises, */
    double low, high;                              /* [V] between these, where all of them do */
    double *former;                                /* [kinds + 1][total] [m/s], [mol/m2/s] with `falls`; else NULL */
    int64_t formers;                               /* of them */
} pd_polarise;

#ifdef PDI_INTERNAL
/* Electrodes for a pd_etch that is to be built; all is borrowed. */
PDI_FN pd_status pdi_polarise_build(pd_ctx *ctx, const pd_setup *setup, pd_electrode_map *map, pd_cell *cell,
                                    const pd_reactive *reactive, pd_etch *etch, pd_polarise *p,
                                    pd_etch_electrodes *electrodes);
PDI_FN void pdi_polarise_free(pd_ctx *ctx, pd_polarise *p);
/* 1: there is an electrode without a place. */
PDI_FN int pdi_polarise_gone(const pd_polarise *p);
/* What surfaces meet now. */
PDI_FN void pdi_polarise_meet(pd_polarise *p);
/* The places of a contact's node begin at `first`, and end where it returns; *own: the one whose metal is of `kind`,
 * with the largest area; -1: none. */
PDI_FN int32_t pdi_polarise_node(const pd_polarise *p, int32_t first, int kind, int32_t *own);
/* Electrode of the metal of `kind` that is nearest to a node. */
PDI_FN int pdi_polarise_near(const pd_polarise *p, const pd_dissolve *dissolve, int32_t node, int kind);
/* An electrode as it was at the end of the last step of the species. */
PDI_FN void pdi_polarise_electrode(const pd_polarise *p, int electrode, pd_cell_electrode *now);
/* [A/m2] Current density at the electrodes beside a fluid node; NaN where there are none. */
PDI_FN double pdi_polarise_density(const pd_polarise *p, int32_t node);
/* [A] (per m in planar 2D) what leaves metal, and *off [-], what circuits that float lack at most, over their currents.
 */
PDI_FN double pdi_polarise_current(const pd_polarise *p, double *off);
/* Circuits whose potential follows from their current have one: PD_ERR_STATE: there are several. */
PDI_FN pd_status pdi_polarise_unique(pd_ctx *ctx, pd_polarise *p);
/* No potential gives a circuit its current. */
PDI_FN pd_status pdi_polarise_found(pd_ctx *ctx, const pd_polarise *p);
#endif

#endif
