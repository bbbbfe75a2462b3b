/* electrodes: the electrodes of a setup on its lattice: which metal each of them is, what is connected, what is given.
 */
#ifndef PD_ELECTRODES_H
#define PD_ELECTRODES_H
#include "potential/cell.h"
#include "react/reactive.h"
#include "run/surfaces.h"
#include "scene/setup.h"

/* What a cell asks for. */
typedef struct pd_electrode_map {
    const pd_setup *setup;
    const pd_grid *grid;
    const uint8_t *metal;        /* [total] index of the metal of solid nodes; NULL: 0 */
    const pd_reactive *reactive; /* whose conductivity it is; NULL: it is given */
    const pd_reactive *species;  /* that reactions of electrodes bring; NULL: none are there */
    const pd_cell *cell;
    const pd_surfaces *surfaces; /* whose states the curves read; NULL: they read none */
    int circuits;
    int member[PD_SETUP_ELECTRODES];       /* circuit of each electrode */
    int given[PD_SETUP_ELECTRODES];        /* of each circuit: the electrode that has a given value; -1: none */
    pd_circuit circuit[PD_SETUP_ELECTRODES];
    const char *name[PD_SETUP_ELECTRODES];
    int line;                    /* of the scene: what was refused */
} pd_electrode_map;

#ifdef PDI_INTERNAL
/* All is borrowed. reactive, dissolve, surfaces: NULL without. PD_ERR_GEOMETRY: metal that is no electrode, an
 * electrode without metal. PD_ERR_ARGUMENT: two values are given for metals that touch. */
PDI_FN pd_status pdi_electrodes_build(pd_ctx *ctx, const pd_setup *setup, const pd_bonds *bonds,
                                      const pd_stencil *across, const uint8_t *metal, const pd_reactive *reactive,
                                      const pd_dissolve *dissolve, const pd_surfaces *surfaces,
                                      pd_electrode_map *electrodes, pd_cell *cell);
/* 1: given values or shares depend on time. */
PDI_FN int pdi_electrodes_timed(const pd_setup *setup);
/* Value of a circuit at time t [s], of a pd_electrode_map. */
PDI_FN double pdi_electrodes_given(void *user, int circuit, double t);
/* A `feed` of a course, of a pd_electrode_map with species and cell: by Faraday's law, of the potential found last. */
PDI_FN void pdi_electrodes_feed(void *user, double *source);
/* Its `drained`: names the electrode. */
PDI_FN pd_status pdi_electrodes_drained(pd_ctx *ctx, void *user, int32_t node, int solute, double t);
#endif

#endif
