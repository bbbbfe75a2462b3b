/* species_electrodes: electrodes in an electrolyte with migrating ions: polarisation curves as a boundary condition of
 * the species solver, and the currents that result (theory: 9.5).
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

/* State of an electrode at the end of the last step of the species, into all of *now: potential [V] (NaN: unknown),
 * current [A] and its anodic part, area, charge [C] and extremes of current density [A/m2]. Without fluid beside it
 * current, area and extremes are 0 and `touches` is PD_CELL_APART. */
PD_API void pd_species_electrodes_get_electrode(const pd_species_electrodes *p, int electrode, pd_cell_electrode *now);
/* [A] (per m in planar 2D) Total anodic current of all metal: sum of the positive parts of laws and curves. *off [-]:
 * largest current imbalance of a circuit without a prescribed potential, over the sum of sizes of its currents; 0:
 * there is none. */
PD_API double pd_species_electrodes_compute_total_current(const pd_species_electrodes *p, double *off);
#ifdef PDI_INTERNAL
/* Set up electrodes among migrating ions, and the descriptor `electrodes`, which points into p, for a surface solver
 * pd_etch that is built afterwards. Both are reset first. Allocates the stoichiometry, and finds whether a law or curve
 * decreases with E. All else is borrowed. saved_rates are the caller's to allocate where has_decreasing_range is 1;
 * pdi_species_electrodes_free frees both. */
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
/* Electrode of the nearest solid node of metal `kind` within 6 cells of a fluid node; the first electrode (0) if none
 * is near. */
PDI_FN int pdi_species_electrodes_find_nearest_electrode(const pd_species_electrodes *p, const pd_dissolve *dissolve,
                                                         int32_t node, int kind);
/* [A/m2] Mean current density from metal to fluid over the area of all electrodes beside a fluid node, laws and curves
 * together; NaN where there is no area. */
PDI_FN double pdi_species_electrodes_compute_current_density(const pd_species_electrodes *p, int32_t node);
/* Check that each circuit without a prescribed potential has one potential only, by a search within 2 V of the present
 * one; speeds, electron fluxes and potentials are as before afterwards. saved_rates are allocated. PD_ERR_STATE: a
 * circuit has two or more (bistability of a passivating metal). */
PDI_FN pd_status pdi_species_electrodes_check_unique_potential(pd_ctx *ctx, pd_species_electrodes *p);
/* Check that a potential was found for each circuit, by etch->lost. PD_ERR_STATE: none gives a circuit its current; the
 * message names the first of its electrodes that fluid touches, or the first without one. */
PDI_FN pd_status pdi_species_electrodes_check_solved(pd_ctx *ctx, const pd_species_electrodes *p);
#endif

#endif
