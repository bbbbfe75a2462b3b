/* quasi_static: quasi-static deformation under loads in time, with bond failure and the energy balance.
 *
 * A step solves for the equilibrium at its end. Bonds beyond the critical value then break, those with the largest
 * measure first, and the equilibrium is solved again until no more bonds break. External work equals the stored energy,
 * the dissipation of plasticity and broken bonds, and what unstable crack growth would turn into kinetic energy. A
 * component that has come off, and that has no supports against its loads, loses them.
 */
#ifndef PD_QUASI_STATIC_H
#define PD_QUASI_STATIC_H
#include "solid/bond_failure.h"
#include "solid/equilibrium.h"
#include "solve/anderson.h"
#include "solve/physics.h"

/* Loads at time t [s] into load [count][PD_DIM] [N/m3], and prescribed displacements into u [count][PD_DIM] [m], which
 * holds the last solution. */
typedef pd_status (*pd_load_fn)(pd_ctx *ctx, void *user, double t, double *u, double *load);

typedef struct pd_quasi_static_desc {
    const uint8_t *prescribed; /* [count][PD_DIM] 1: this displacement is prescribed; NULL: none. Borrowed */
    pd_load_fn load;
    void *user;
    /* How prescribed displacements follow free ones, as of the last call of load; NULL: they do not. Boundary values
     * that depend on the solution in any other way are iterated until they converge. Borrowed */
    const pd_multipoint_constraint *interpolation;
    pd_bond_failure_desc criterion; /* by which bonds break; zero: none does */
    double break_fraction;          /* [-] as of pd_bond_failure_break, in each round; -1: 0.5 */
    double rtol;           /* [-] as of pd_equilibrium_desc */
} pd_quasi_static_desc;

typedef struct pd_quasi_static {
    pd_quasi_static_desc desc;
    pd_material_interface solid;
    pd_bond_failure criterion;
    int64_t n;             /* components of all points */
    double *u;             /* [n] [m] */
    double *load;          /* [n] [N/m3] */
    double *force;         /* [n] [N/m3] of the bonds, at u */
    double *start;         /* [2][n] [m], [N/m3] u and load at the start of a step */
    double *correction;    /* [3][n] [m] corrections of prescribed displacements; work: u, load */
    pd_anderson acceleration; /* Anderson acceleration of prescribed displacements; empty between solves */
    double *saved;            /* [3][n] [m], [N/m3] u, load and force before a move */
    uint8_t *detached;        /* [count] 1: of a component that has come off */
    double time;           /* [s] of the solution */
    int solved;            /* 1: there is a solution */
    int stale;             /* 1: bonds or stiffness have changed since the solution */
    double work;           /* [J] (per m in 2D, per m2 in 1D) external work: of loads and reactions */
    double stored;         /* [J] elastic energy */
    double released;       /* [J] energy released by bond failure at fixed displacements */
    double dissolved_energy; /* [J] energy of dissolved metal */
    double separation_time;  /* [s] when the first loaded component came off, or the body fell into more parts than at
                              * first; -1: neither has happened */
    int32_t components;      /* components now that are supported or loaded, or have more points than a family */
    int32_t initial_components;      /* the same in the first solution */
    int64_t broken, detached_points; /* bonds that broke, and points that came off with loads */
    int64_t solves, iterations;
    double residual;       /* [-] of the last balance */
} pd_quasi_static;

#define pd_quasi_static_build PD_NAME(pd_quasi_static_build)
#define pd_quasi_static_process PD_NAME(pd_quasi_static_process)
#define pd_quasi_static_solve_at PD_NAME(pd_quasi_static_solve_at)
#define pd_quasi_static_free PD_NAME(pd_quasi_static_free)

/* At rest, without loads and unsolved. The material is borrowed, and so is what the description names. After an error
 * the object is empty. PD_ERR_ARGUMENT: break_fraction above 1 (negative: 0.5), rtol not in [0, 1), and as of
 * pd_bond_failure_build. */
PD_API pd_status pd_quasi_static_build(pd_ctx *ctx, const pd_material_interface *solid,
                                       const pd_quasi_static_desc *desc, pd_quasi_static *quasi_static);
/* Solves for the equilibrium at time t [s] with bond failure; where there is a solution, no bond or stiffness has
 * changed (stale) and loads and prescribed displacements are the same, it sets the time alone. Shorter load steps, down
 * to 1/256, are taken where Newton's method needs them. PD_NOT_CONVERGED: the solution at t is above its tolerance.
 * PD_ERR_STATE: no step is short enough (limit load of plasticity, or buckling), or boundary values do not converge.
 * Other errors: of the equilibrium and of the material; the time stays. */
PD_API pd_status pd_quasi_static_solve_at(pd_ctx *ctx, pd_quasi_static *quasi_static, double t);
/* The process table, for a run of coupled processes: start and each step solve by pd_quasi_static_solve_at; checkpoints
 * hold the state and that of the material. */
PD_API pd_physics pd_quasi_static_process(pd_quasi_static *quasi_static);
PD_API void pd_quasi_static_free(pd_ctx *ctx, pd_quasi_static *quasi_static);

#ifdef PDI_INTERNAL
/* Describes the arrays and values; those of state are stored. */
PDI_FN void pdi_quasi_static_list(pdi_array_visitor *owner, void *quasi_static);
#endif

#endif
