/* dissolution_laws: dissolution rate laws of the scene that depend on pH or species concentrations at the surface. They
 * are a boundary condition of the species solver (react/etch.h) and give the dissolution speed of the metal.
 *
 * The species step first, with the law in their equations. The mean speed of that step is the speed of the metal, which
 * steps after them.
 */
#ifndef PD_DISSOLUTION_LAWS_H
#define PD_DISSOLUTION_LAWS_H
#include "metal/dissolve.h"
#include "potential/cell.h"
#include "react/course.h"
#include "physics/species_electrodes.h"
#include "physics/surface_states.h"
#include "setup/setup.h"

/* The rate law of one metal: callback data. */
typedef struct pd_dissolution_law {
    struct pd_dissolution_laws *laws;
    int setup_metal;                   /* index of the metal in the setup and in the dissolution */
    int surface_metal;                 /* index of the metal in the surface solver, pd_etch */
    const pd_surface_states *surfaces; /* surface states that the law depends on; NULL: none */
} pd_dissolution_law;

/* The rate laws of all metals, bound to the species solver and to the dissolution. */
typedef struct pd_dissolution_laws {
    pd_etch surface_solver;
    const pd_setup *setup;
    pd_dissolve *dissolve;
    const pd_course *species_integrator;
    const pd_cell *cell; /* potential solver: laws depend on its last solution, or electrodes use its contacts; NULL:
                          * neither */
    const pd_surface_states *states; /* surface states, with migrating ions; NULL: there are none */
    pd_species_electrodes species_electrodes; /* electrodes in an electrolyte with migration; else empty */
    pd_dissolution_law law[PD_SETUP_METALS];
    int law_count;  /* length of law[]: all metals where several have a law in the species, else 1, or 0 */
    int32_t *grain; /* [total] grain of the metal beside a fluid node; NULL: no law depends on it */
    double step_start; /* [s] start of the step of the run */
    /* sets the variables that are fields of the physics of the program; called where a law reads one */
    void (*set_registered)(const void *user, int32_t node, double *vars);
    const void *set_registered_user;
} pd_dissolution_laws;

#ifdef PDI_INTERNAL
/* Bind the rate laws of the setup that depend on species, and electrodes among migrating ions, to the species solver:
 * resets attack, builds its surface solver, and allocates `grain` where a law reads it. All is borrowed; dissolve: NULL
 * where no metal dissolves; surfaces: NULL without surface states; with migrating ions their `solve` is set here. After
 * an error the caller frees. */
PDI_FN pd_status pdi_dissolution_laws_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive,
                                            pd_dissolve *dissolve, const pd_course *course, pd_cell *cell,
                                            pd_electrode_map *map, pd_surface_states *surfaces,
                                            pd_dissolution_laws *attack);
/* Set the variables vars [PD_EXPR_VARS] of a rate-law expression from the state at the surface beside a node: c
 * [solutes] [mol/m3], pH, potential phi [V] of the fluid, time t [s]; as of pd_etch_fn. The potential of the law is
 * -phi among ions with electrodes, E(t) - phi for a metal with a prescribed E, else that of the potential solver or 0.
 * C is 0. Those that the law does not have stay. */
PDI_FN void pdi_dissolution_laws_set_variables(const pd_dissolution_law *law, int32_t node, const double *c, double ph,
                                               double phi, double t, double *vars);
/* With electrodes: solve rates, currents and potentials at the surface for the initial state, at time t [s], and set
 * the clocks of surface solver and dissolution; without them nothing is done. PD_ERR_STATE: no solution. The `open`
 * callback of pd_course; user: a pd_dissolution_laws. */
PDI_FN pd_status pdi_dissolution_laws_solve_initial(pd_ctx *ctx, void *user, double t);
PDI_FN void pdi_dissolution_laws_free(pd_ctx *ctx, pd_dissolution_laws *attack);
/* Dissolution speed [m/s] at a node as it was computed last. A pd_rate_fn of the dissolution; user is a
 * pd_dissolution_law.
 */
PDI_FN double pdi_dissolution_laws_get_speed(void *user, const pd_rate_at *at);
/* Update the dissolution speeds of all nodes at time t [s]: by solving the laws, or, where the species have already
 * passed t, as the mean of the step that they have made. Within a step of the run of the species only the weights of
 * surface sites are updated. PD_ERR_STATE: no solution, or a speed that is no number below 1e100 m/s. The `found`
 * callback of pd_dissolve; user is a pd_dissolution_laws. */
PDI_FN pd_status pdi_dissolution_laws_update_speeds(pd_ctx *ctx, void *user, double t);
/* Update the exposed surface and its sites for a step of the species from time t [s] on; sets the times of surface
 * solver and dissolution to t. At the start of a step of the run also keeps its time, and, where the species get
 * released metal of other than bond-based corrosion, finds the metal components. Without dissolving metal laws are
 * solved only then. The `find` callback of pd_course; user is a pd_dissolution_laws. */
PDI_FN pd_status pdi_dissolution_laws_update_interface(pd_ctx *ctx, void *user, double t);
#endif

#endif
