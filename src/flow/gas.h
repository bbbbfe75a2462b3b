/* gas: inviscid flow of an ideal gas with energy, explicit in time: shock tubes, blasts, sound.
 *
 * dU/dt + div F(U) = 0 for the density, the momentum and the total energy per volume U = (rho, rho v, rho E), with
 * p = (gamma - 1) (rho E - rho v.v/2). A bond carries a flux between two states, antisymmetric in its ends, so mass,
 * momentum and energy are conserved to rounding: HLLC (Toro, Spruce and Speares 1994; wave speeds of Einfeldt 1988),
 * with limited linear states in the middle of the bond, and first order where those would lose positivity. Closed bonds
 * press on the gas as a wall that slips. In time the three-stage method of Shu and Osher 1988 (theory: eq. 4.1 to
 * 4.10).
 */
#ifndef PD_GAS_H
#define PD_GAS_H
#include "core/array_registry.h"
#include "lattice/node_loop.h"
#include "solve/physics.h"

/* Fields of a state: the density, PD_DIM components of the momentum (or velocity), the energy (or pressure). */
#define PD_GAS_FIELDS (PD_DIM + 2)

/* State at position x [m]: rho [kg/m3], v [PD_DIM] [m/s], p [Pa]. */
typedef void (*pd_gas_fn)(void *user, const double *x, double *rho, double *v, double *p);

typedef enum pd_gas_order {
    PD_GAS_SECOND = 0, /* second order where smooth */
    PD_GAS_FIRST = 1   /* the states of the nodes as they are: density and pressure stay positive by construction */
} pd_gas_order;

typedef struct pd_gas_desc {
    double gamma;       /* [-] ratio of the heat capacities, above 1 */
    pd_gas_order spatial_order;
    double cfl;         /* [-] share of the step limit; 0: 0.8 */
    pd_gas_fn initial;  /* at fluid nodes and at the ghosts of inlets, which keep it; NULL: the caller fills state */
    void *initial_user;
} pd_gas_desc;

typedef struct pd_gas {
    pd_gas_desc desc;    /* defaults filled in */
    const pd_grid *grid;
    const pd_bonds *bonds;
    double *state;       /* [PD_GAS_FIELDS][total] [kg/m3], [kg/m2/s], [J/m3] U at fluid nodes and inlets */
    double *primitive;   /* [PD_GAS_FIELDS][total] [kg/m3], [m/s], [Pa] rho, v, p after build, step, run and limit */
    /* [PD_GAS_FIELDS][PD_DIM][total] gradients of them [unit of 1/m], work; NULL: first order */
    double *gradient;
    double *start_state;     /* [PD_GAS_FIELDS][total] [unit of state] at the start of the step, work */
    double *time_derivative; /* [PD_GAS_FIELDS][total] [unit of state/s] time derivatives, work */
    double *wall_face;   /* [rows][PD_DIM walls][PD_DIM] [1/m] sum of g over the closed bonds of a row: points into the
                          * wall; in a concave edge or corner the part of each wall */
    double *wall_distance; /* [rows][PD_DIM walls] [m] distance of the wall along wall_face */
    int32_t rows;        /* of the bonds at build */
    int32_t *open_side_nodes; /* [open_side_node_count] fluid nodes with bonds through inlets and outlets */
    int32_t open_side_node_count;
    /* [total] the node fell back to first order in this stage, to stay positive; work */
    uint8_t *first_order_flag;
    /* [kg], [J] (1D: per m2; 2D: per m) mass and energy through open sides since the build */
    double outflow[2], inflow[2];
    double time;         /* [s] */
    int64_t steps, rejected; /* steps done; steps that were halved */
    int64_t first_order_count; /* nodes that fell back to first order, summed over stages */
} pd_gas;

#define pd_gas_build PD_NAME(pd_gas_build)
#define pd_gas_limit PD_NAME(pd_gas_limit)
#define pd_gas_step PD_NAME(pd_gas_step)
#define pd_gas_process PD_NAME(pd_gas_process)
#define pd_gas_free PD_NAME(pd_gas_free)

/* Grid and bonds are borrowed and must not change. Sides: periodic, mirror, wall; outlets let pass what comes; inlets
 * hold the state that the caller gives their ghosts (a far field: waves leave through them too; theory: eq. 4.8).
 * Without an initial callback all states are 0, and are not checked. PD_ERR_ARGUMENT: gamma not between 1 and 100, cfl
 * negative or 100 or more, an unknown order, an axisymmetric grid, an initial density or pressure not positive and
 * finite. After an error gas is freed. */
PD_API pd_status pd_gas_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_gas_desc *desc,
                              pd_gas *gas);
/* *limit [s]: step limit of the present state (eq. 4.10, cfl not applied), the least over fluid nodes. To this length a
 * step of first order keeps density and pressure positive. Updates `primitive`, overwrites `time_derivative`.
 * PD_ERR_STATE: the state of a fluid node or inlet is not admissible, *limit is 0. */
PD_API pd_status pd_gas_limit(pd_ctx *ctx, pd_gas *gas, double *limit);
/* One step of dt [s]; adds to time, steps, inflow and outflow, and updates `primitive`. PD_RETRY, state unchanged: a
 * density or pressure would turn non-positive or infinite, at first order too; first_order_count has grown all the
 * same. PD_ERR_ARGUMENT: dt is not positive and finite. PD_ERR_STATE: the state before the step is not admissible. */
PD_API pd_status pd_gas_step(pd_ctx *ctx, pd_gas *gas, double dt);
/* The gas as a process, with ledgers of mass and energy. Steps of cfl times the limit; rejected steps are halved.
 * PD_ERR_STATE: 20 halvings did not help. */
PD_API pd_physics pd_gas_process(pd_gas *gas);
#ifdef PDI_INTERNAL
/* stock [PD_GAS_FIELDS] = mass [kg], momentum [kg m/s], energy [J] of all fluid nodes (1D: per m2; 2D: per m). */
PDI_FN void pdi_gas_integrate_state(pd_ctx *ctx, const pd_gas *gas, double *stock);
#endif
PD_API void pd_gas_free(pd_ctx *ctx, pd_gas *gas);

#ifdef PDI_INTERNAL
/* Lists the arrays of a pd_gas (`object`). */
PDI_FN void pdi_gas_list(pdi_array_visitor *owner, void *object);
#endif

#endif
