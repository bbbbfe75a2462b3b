/* electrode_map: electrodes of a setup on its lattice: the metal nodes of each, circuits of connected ones, and their
 * prescribed potentials or currents. */
#ifndef PD_ELECTRODE_MAP_H
#define PD_ELECTRODE_MAP_H
#include "potential/cell.h"
#include "react/reactive.h"
#include "physics/surface_states.h"
#include "setup/setup.h"

/* Data of the callbacks of the potential solver, pd_cell. */
typedef struct pd_electrode_map {
    const pd_setup *setup;
    const pd_grid *grid;
    const uint8_t *metal;        /* [total] index of the metal of solid nodes; NULL: 0 */
    const pd_reactive *reactive; /* species that the conductivity follows from; NULL: it is prescribed */
    const pd_reactive *species;  /* species that electrode reactions produce or consume; NULL: none */
    const pd_cell *cell;
    const pd_surface_states *surfaces; /* surface states that polarisation curves depend on; NULL: none */
    int circuits;
    int circuit_of_electrode[PD_SETUP_ELECTRODES]; /* circuit of each electrode */
    /* of each circuit: electrode with a prescribed value; -1: none */
    int prescribed_electrode[PD_SETUP_ELECTRODES];
    pd_circuit circuit[PD_SETUP_ELECTRODES];
    const char *name[PD_SETUP_ELECTRODES];
    int error_line; /* line of the scene that an error is about */
} pd_electrode_map;

#ifdef PDI_INTERNAL
/* Find electrodes and circuits on the lattice and build the potential solver `cell` with them. All is borrowed; metal
 * [total]: index of the metal of nodes, NULL: 0; reactive, dissolve, surfaces: NULL without. The caller then sets
 * electrodes->cell and ->species. PD_ERR_GEOMETRY: metal that is no electrode, an electrode without metal.
 * PD_ERR_ARGUMENT: two prescribed values for metals that touch. */
PDI_FN pd_status pdi_electrode_map_build(pd_ctx *ctx, const pd_setup *setup, const pd_bonds *bonds,
                                         const pd_stencil *across, const uint8_t *metal, const pd_reactive *reactive,
                                         const pd_dissolve *dissolve, const pd_surface_states *surfaces,
                                         pd_electrode_map *electrodes, pd_cell *cell);
/* Do prescribed potentials, currents or curve factors of electrodes depend on time? 1 or 0. */
PDI_FN int pdi_electrode_map_is_time_dependent(const pd_setup *setup);
/* Prescribed potential [V] or current [A] of a circuit at time t [s], by the expression at the origin; 0: it has none.
 * user: a pd_electrode_map. */
PDI_FN double pdi_electrode_map_get_circuit_value(void *user, int circuit, double t);
/* Add what electrode reactions release (negative: consume), by Faraday's law from the last current densities of
 * contacts, to source [solutes][total] [mol/m3/s]. Electrodes without a reaction give nothing. The `feed` callback of
 * pd_course; user: a pd_electrode_map with species and cell. */
PDI_FN void pdi_electrode_map_add_faradaic_source(void *user, double *source);
/* Error message for a node where electrode reactions consume more of a solute than is there; it names the electrode
 * that takes most. The `drained` callback of pd_course. Returns PD_ERR_STATE. */
PDI_FN pd_status pdi_electrode_map_report_depleted_species(pd_ctx *ctx, void *user, int32_t node, int solute, double t);
/* 1: rate laws of metal depend on currents or potentials of the potential solver. 0 with migrating ions. */
PDI_FN int pdi_electrode_map_is_read_by_laws(const pd_setup *setup);
/* 1: currents are solved before each species step, since they depend on what it changes: the conductivity is that of
 * the species, there are surface states, or minerals cover metal while electrodes have values in time. 0 with migrating
 * ions, and without potential or chemistry. */
PDI_FN int pdi_electrode_map_is_solved_per_species_step(const pd_setup *setup);
/* 1: the species solve currents in each of their own steps: they change them, or currents depend on time and no rate
 * law of the metal reads them. 0: they use those of the metal's step. */
PDI_FN int pdi_electrode_map_is_solved_by_species(const pd_setup *setup);
#endif

#endif
