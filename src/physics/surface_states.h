/* surface_states: state variables of metal surfaces (film coverage, thickness) of a setup on its lattice: where they
 * are, the inputs of their rate laws, and their values for laws and polarisation curves (theory: 9.10). */
#ifndef PD_SURFACE_STATES_H
#define PD_SURFACE_STATES_H
#include "potential/cell.h"
#include "react/coat.h"
#include "react/etch.h"
#include "setup/setup.h"

/* Surface states of a setup and what they are coupled to. All is borrowed, but for the contacts and the coat. */
typedef struct pd_surface_states {
    const pd_setup *setup;
    const pd_bonds *bonds;
    const pd_stencil *interface_stencil; /* of bonds across surfaces */
    pd_cell *cell;            /* potential solver of the electrodes; NULL: there are none */
    const pd_etch *surface_solver; /* surface solver: metal that dissolves by a law in the species, or electrodes among
                                    * migrating ions; NULL: neither */
    pd_solve_at_fn solve;          /* with migrating ions: solves rate laws and curves at a time; */
    void *solve_user;              /* its user pointer; both set by the owner */
    pd_contacts contacts;     /* without electrodes: of metal and fluid */
    pd_coat state_solver;
    int affects_potential;   /* 1: the potential depends on states, or rates of states on it */
    int has_faradaic_source; /* 1: electrode reactions are sources of species */
    /* [-] components released per electron, of each electrode */
    double components_per_electron[PD_SETUP_ELECTRODES][PD_SPECIES_MAX];
} pd_surface_states;

/* Statistics of a state over its surface, as it is now. */
typedef struct pd_surface_state_statistics {
    double mean, min, max;    /* [unit of the state] over the area; NaN without any */
    double area;              /* [m^(d-1)] axisymmetric: over the whole circumference */
} pd_surface_state_statistics;

#define pd_surface_states_compute_statistics PD_NAME(pd_surface_states_compute_statistics)

/* Area-weighted mean, minimum and maximum of state k over the contacts of fluid and metal that carry it, and their
 * area. Without any the area is 0 and the others are NaN. */
PD_API void pd_surface_states_compute_statistics(const pd_surface_states *surfaces, int k,
                                                 pd_surface_state_statistics *figures);
#ifdef PDI_INTERNAL
/* Build the surface states of a setup; resets the object, which must not be moved afterwards: callbacks point to it.
 * cell, etch: NULL without; they may be built later. With migrating ions the caller sets `solve` afterwards. Errors:
 * those of pdi_coat_build; the caller frees after one. */
PDI_FN pd_status pdi_surface_states_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive,
                                          const pd_bonds *bonds, const pd_stencil *across, pd_cell *cell,
                                          const pd_etch *etch, pd_surface_states *surfaces);
PDI_FN void pdi_surface_states_free(pd_ctx *ctx, pd_surface_states *surfaces);
/* All states at the surface beside a fluid node, into value [states]. Where a state has no site at the node: the mean
 * of the nearest sites within two cells, else the value of the start. */
PDI_FN void pdi_surface_states_get_states(const pd_surface_states *surfaces, int32_t node, double *value);
/* Value of state k at a fluid node; NaN: its surface does not carry the state. */
PDI_FN double pdi_surface_states_get_state(const pd_surface_states *surfaces, int k, int32_t node);
/* Set in desc, zero before, what the rates of states depend on (solutes, pH, current density, potential), their number,
 * and whether they step in the stages of the species. */
PDI_FN void pdi_surface_states_set_desc(const pd_setup *setup, const pd_reactive *reactive, pd_coat_desc *desc);
/* Set all variables vars [PD_EXPR_VARS] of the rate expression of state k: time, place, current density, potential, pH
 * and species from the inputs `at` of the place, and its states y [states]; the others are 0. */
PDI_FN void pdi_surface_states_set_variables(const pd_surface_states *surfaces, int k, const pd_coat_at *at,
                                             const double *y, double *vars);
/* Factor *share [-] on the polarisation curve of an electrode beside a node at time t [s], as a function of surface
 * states; it stays where the electrode has no such function. PD_ERR_STATE: it is negative, NaN, or at least 1e100;
 * *share holds it then. */
PDI_FN pd_status pdi_surface_states_compute_curve_factor(pd_ctx *ctx, const pd_surface_states *surfaces, int electrode,
                                                         int32_t node, double t, double *share);
/* Set the factors (`share`) of the polarisation curves of contact [count] at time t [s], for the potential solver;
 * those of electrodes without such a function stay. Errors: as of pdi_surface_states_compute_curve_factor, at the first
 * contact that has one. */
PDI_FN pd_status pdi_surface_states_update_contact_factors(pd_ctx *ctx, const pd_surface_states *surfaces,
                                                           pd_contact *contact, int32_t count, double t);
#endif

#endif
