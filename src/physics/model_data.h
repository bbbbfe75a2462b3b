/* model_data: all objects of one simulation: grid, bonds, and the solvers of the physics that the setup has. */
#ifndef PD_MODEL_DATA_H
#define PD_MODEL_DATA_H
#include "couple/time_loop.h"
#include "flow/quasi_steady.h"
#include "flow/implicit.h"
#include "flow/weakly_compressible.h"
#include "transport/two_stage.h"
#include "react/course.h"
#include "metal/dissolve.h"
#include "physics/inlet.h"
#include "physics/wall_bc.h"
#include "physics/mechanical_bc.h"
#include "physics/dissolution_laws.h"
#include "physics/electrode_map.h"
#include "physics/rate_step_limit.h"
#include "physics/input_step_limit.h"

struct pdi_physics_list;
struct pdi_physics_sampler;

/* Callback data of the rate law of a metal. */
typedef struct pd_model_law {
    const pd_setup_metal *metal;
    int kind;            /* its index */
    const pd_cell *cell; /* potential solver; NULL: no law depends on it */
    const struct pd_model *model;
} pd_model_law;

/* A physics of the program in a model. */
typedef struct pd_model_registered {
    pd_physics_view view;
    void *state; /* NULL: not built */
} pd_model_registered;

/* Objects point at each other: a built model must not be moved. Absent physics stays zero. */
typedef struct pd_model {
    const pd_setup *setup;
    int error_line; /* line of the scene that a failed build is about; 0: unknown */
    pd_stencil stencil;
    pd_stencil interface_stencil; /* of bonds between metal and fluid */
    pd_grid grid;
    pd_bonds bonds;
    pd_bond_paths paths; /* of interface_stencil; both absent when nothing needs surfaces */
    pd_inlet inlet;
    pd_arena arena;           /* of flow and transport, which never solve at the same time */
    pd_flow flow;
    pd_steady steady;     /* absent with explicit flow */
    pd_quasi_steady quasi;
    pd_implicit implicit;
    pd_weakly_compressible unsteady;
    pd_gas gas;
    pd_transport transport;
    pd_two_stage transport_integrator; /* time integrator of transport without dissolution */
    pd_reactive reactive;     /* species */
    pd_input_step_limit input_step_limit; /* step limit from time-dependent inputs */
    pd_rate_step_limit rate_step_limit;   /* step limit from time-dependent rate laws at surfaces */
    /* [total] 1: the node was just converted to fluid, see pd_time_loop; NULL: not needed */
    uint8_t *just_converted;
    double *coverage_factor;              /* [total] [-] rate factor of metal that minerals cover, or NULL */
    pd_course species_integrator;         /* time integrator of the species */
    pd_surface_states *surface_states;    /* states of surfaces; NULL: there are none */
    pd_dissolution_laws dissolution_laws; /* rate laws in the species; else absent */
    pd_model_registered registered[PD_CTX_PHYSICS];
    pd_grain grain;
    pd_grain_stats grain_stats;
    double *boundary_factor;        /* [total] [-] rate factor of the grain boundaries; NULL: 1 */
    pd_solid_coupling solid;        /* mechanics of the metal */
    pd_mechanical_bc mechanical_bc; /* its boundary conditions */
    int min_cells_across;           /* parts with fewer cells across are too stiff in bending; 0: no mechanics */
    double thin_fraction;           /* [-] volume fraction of the metal in such parts */
    pd_dissolve dissolve;
    pd_model_law law[PD_SETUP_METALS];
    pd_electrode_map electrodes;
    pd_cell cell;
    uint8_t *metal;           /* [total] index of the metal of solid nodes; NULL: all are of the first one */
    uint8_t *passive;         /* [total] 1: in front of a passive film; NULL: none */
    pd_time_loop time_loop;   /* time loop over all solvers */
    struct pdi_physics_list *physics;                          /* rows of the physics that the setup has */
    const struct pdi_physics_sampler *sampler[PD_FIELD_COUNT]; /* of the first present physics with that field */
    size_t bytes[PD_PART_COUNT];     /* [byte] */
    int64_t unknowns[PD_PART_COUNT];
} pd_model;

#define PD_MODEL_ATMOSPHERE 101325.0 /* [Pa] */

/* Solver statistics since the start, and residuals of the last solves; zero where there is no such solver. */
typedef struct pd_model_statistics {
    int64_t flow_solves;             /* of a flow in time: steps of the run */
    int64_t flow_evaluations, flow_krylov, transport_krylov;
    int limiter_iterations;          /* Newton steps on the limited equations in the last step */
    double momentum, continuity;     /* [-] residuals of the last flow solve */
    double steady_change, mass_defect; /* [-] of a steady field, see pd_transport_result */
} pd_model_statistics;

#define pd_model_is_undefined PD_NAME(pd_model_is_undefined)
#define pd_model_velocity PD_NAME(pd_model_velocity)

/* 1: the value of a dissolved field at node i is undefined: the node was just converted to fluid, and no solver has
 * stepped since. Dissolved are species, pH, saturation index and diffusion potential, and C unless of bond-based
 * corrosion. 0 for all other fields. */
PD_API int pd_model_is_undefined(const pd_model *m, pd_field field, int32_t i);
/* [PD_DIM][total] [m/s] velocity of flow or gas; NULL: nothing moves. */
PD_API const double *pd_model_velocity(const pd_model *model);
#ifdef PDI_INTERNAL
/* Set the variables of a rate law, vars [PD_EXPR_VARS], that are fields of the physics of the program, at a node; 0 for
 * those that the setup does not have. model: a pd_model. */
PDI_FN void pdi_model_set_registered_variables(const void *model, int32_t node, double *vars);
/* Norm [m/s] at a node of a velocity [PD_DIM][total] [m/s]. */
PDI_FN double pdi_model_compute_speed(const pd_model *model, const double *velocity, int32_t node);

#endif

#endif
