/* surfaces: the states of surfaces of a setup on its lattice: where they are, what rates read, and what reads them. */
#ifndef PD_SURFACES_H
#define PD_SURFACES_H
#include "potential/cell.h"
#include "react/coat.h"
#include "react/etch.h"
#include "scene/setup.h"

/* All is borrowed, but for the contacts and the coat. */
typedef struct pd_surfaces {
    const pd_setup *setup;
    const pd_bonds *bonds;
    const pd_stencil *across; /* of bonds across surfaces */
    pd_cell *cell;            /* of the electrodes; NULL: there are none */
    const pd_etch *etch;      /* metal that dissolves by a law in the species, or electrodes among ions that migrate;
                               * NULL: neither */
    pd_at_fn find;            /* among ions that migrate: brings law and curves to a time; */
    void *finder;             /* set by what owns it */
    pd_contacts contacts;     /* without electrodes: of metal and fluid */
    pd_coat coat;
    int moves;                /* 1: the potential follows states, or rates follow it */
    int comes;                /* 1: currents of electrodes enter the species */
    double gain[PD_SETUP_ELECTRODES][PD_SPECIES_MOST]; /* [-] components with one electron */
} pd_surfaces;

/* A state as it is now. */
typedef struct pd_surfaces_figures {
    double mean, least, most; /* [unit of the state] over the area; NaN without any */
    double area;              /* [m^(d-1)] of a body of rings all around */
} pd_surfaces_figures;

#ifdef PDI_INTERNAL
/* It must not be moved once it is built. cell, etch: NULL without; they are built later. */
PDI_FN pd_status pdi_surfaces_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive, const pd_bonds *bonds,
                                    const pd_stencil *across, pd_cell *cell, const pd_etch *etch,
                                    pd_surfaces *surfaces);
PDI_FN void pdi_surfaces_free(pd_ctx *ctx, pd_surfaces *surfaces);
/* All states at the surface beside a fluid node. */
PDI_FN void pdi_surfaces_values(const pd_surfaces *surfaces, int32_t node, double *value);
/* State k of a fluid node; NaN: its surface carries none. */
PDI_FN double pdi_surfaces_at(const pd_surfaces *surfaces, int k, int32_t node);
PDI_FN void pdi_surfaces_figures(const pd_surfaces *surfaces, int k, pd_surfaces_figures *figures);
/* What rates of states read, of a coat. */
PDI_FN void pdi_surfaces_reads(const pd_setup *setup, const pd_reactive *reactive, pd_coat_desc *desc);
/* The variables vars [PD_EXPR_VARS] of the rate of state k at a place, whose states are y. */
PDI_FN void pdi_surfaces_vars(const pd_surfaces *surfaces, int k, const pd_coat_at *at, const double *y, double *vars);
/* The factor of the curve of an electrode beside a node. */
PDI_FN pd_status pdi_surfaces_factor(pd_ctx *ctx, const pd_surfaces *surfaces, int electrode, int32_t node, double t,
                                     double *share);
/* Factors of the curves of electrodes, as `share` of a cell. */
PDI_FN pd_status pdi_surfaces_share(pd_ctx *ctx, const pd_surfaces *surfaces, pd_contact *contact, int32_t count,
                                    double t);
#endif

#endif
