/* species_electrodes: electrodes in an electrolyte with migrating ions: polarisation curves as a boundary condition of
 * the species solver, and the currents that result (theory: 5c.5).
 *
 * The potential solver (pd_cell) only provides contacts and circuits here. Currents and potentials are solved with the
 * steps of the species (react/levels.h).
 */
#ifndef PD_SPECIES_ELECTRODES_H
#define PD_SPECIES_ELECTRODES_H
#include "metal/dissolve.h"
#include "react/etch.h"
#include "physics/electrode_map.h"

/* Electrodes among migrating ions. All is borrowed but for the arrays. */
typedef struct pd_species_electrodes {
    const pd_setup *setup;
    pd_electrode_map *map;
    pd_cell *cell;
    pd_etch *etch;
    double *stoichiometry;                    /* [electrodes][species] [-] see pd_etch_electrodes */
    uint32_t depends_on[PD_SETUP_ELECTRODES]; /* see pd_etch_electrodes */
    pd_etch_circuit circuit[PD_SETUP_ELECTRODES];
    /* 1: a rate law or curve decreases with E (passivation), */
    int has_decreasing_range;
    double decreasing_from, decreasing_to; /* [V] within this range of potentials */
    double *saved_rates;                   /* [kinds + 1][total] [m/s], [mol/m2/s] saved speeds and electron
                                            * fluxes, with `falls`; else NULL */
    int64_t saved_count;                   /* length of saved_rates */
} pd_species_electrodes;

#define pd_species_electrodes_compute_total_current PD_NAME(pd_species_electrodes_compute_total_current)
#define pd_species_electrodes_get_electrode PD_NAME(pd_species_electrodes_get_electrode)

/* State of an electrode at the end of the last step of the species: potential [V], current [A], area, charge [C] and
 * extremes of current density. */
PD_API void pd_species_electrodes_get_electrode(const pd_species_electrodes *p, int electrode, pd_cell_electrode *now);
/* [A] (per m in planar 2D) Total anodic current of all metal; *off [-]: largest relative current imbalance of a circuit
 * with a prescribed current. */
PD_API double pd_species_electrodes_compute_total_current(const pd_species_electrodes *p, double *off);
#ifdef PDI_INTERNAL
/* Set up electrodes among migrating ions, and the descriptor `electrodes`, which points into p, for a surface solver
 * pd_etch that is built afterwards. All is borrowed. saved_rates are the caller's to allocate where
 * has_decreasing_range is 1. */
PDI_FN pd_status pdi_species_electrodes_build(pd_ctx *ctx, const pd_setup *setup, pd_electrode_map *map, pd_cell *cell,
                                              const pd_reactive *reactive, pd_etch *etch, pd_species_electrodes *p,
                                              pd_etch_electrodes *electrodes);
PDI_FN void pdi_species_electrodes_free(pd_ctx *ctx, pd_species_electrodes *p);
/* 1: fluid touches no part of at least one electrode any more. */
PDI_FN int pdi_species_electrodes_has_unwetted(const pd_species_electrodes *p);
/* Extend the range of potentials at which each tabulated polarisation curve was evaluated, by those of now. */
PDI_FN void pdi_species_electrodes_update_surface_range(pd_species_electrodes *p);
/* Contacts of one node, from index `first` to before the returned end; *own: index of the one of metal `kind` with the
 * largest area, -1: none (kind < 0: none is looked for). */
PDI_FN int32_t pdi_species_electrodes_find_node_contacts(const pd_species_electrodes *p, int32_t first, int kind,
                                                         int32_t *own);
/* Electrode of the nearest solid node of metal `kind` around a fluid node; the first electrode (0) if none is near. */
PDI_FN int pdi_species_electrodes_find_nearest_electrode(const pd_species_electrodes *p, const pd_dissolve *dissolve,
                                                         int32_t node, int kind);
/* [A/m2] Mean current density from metal to fluid at the electrodes beside a fluid node; NaN where there are none. */
PDI_FN double pdi_species_electrodes_compute_current_density(const pd_species_electrodes *p, int32_t node);
/* Check that circuits with a prescribed current have one potential only, by a search around the present one; speeds,
 * electron fluxes and potentials are as before afterwards. saved_rates are allocated. PD_ERR_STATE: there are several
 * (bistability of a passivating metal). */
PDI_FN pd_status pdi_species_electrodes_check_unique_potential(pd_ctx *ctx, pd_species_electrodes *p);
/* Check that a potential was found for each circuit. PD_ERR_STATE: none gives a circuit its current; the message names
 * the electrode. */
PDI_FN pd_status pdi_species_electrodes_check_solved(pd_ctx *ctx, const pd_species_electrodes *p);
#endif

#endif
