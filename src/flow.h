/* flow: peridynamic Navier-Stokes operator: momentum and continuity residuals, their linearisation, flux sections.
 *
 * Unknowns are the velocity u [m/s] and the kinematic pressure P = p/rho [m2/s2] of fluid nodes. Continuity is a sum
 * of antisymmetric bond fluxes F_ij = g.(v_i + v_j) over open bonds, so nothing passes solid or wall; a fourth-order
 * antisymmetric pressure flux ties odd and even nodes (theory: eq. 4.1 to 4.6; Zhao and Bobaru 2022).
 */
#ifndef PD_FLOW_H
#define PD_FLOW_H
#include "bond.h"
#include "store.h"

typedef struct pd_flow_desc {
    double rho;             /* [kg/m3] */
    double mu;              /* [Pa s] */
    double force[PD_DIM];   /* [m/s2] body force per mass */
    double p_out;           /* [Pa] at outlets */
    double speed;           /* [m/s] reference U of residuals and of the pressure flux, positive */
    double length;          /* [m] reference L of residuals, positive */
    pd_velocity_fn inlet;   /* NULL: fluid at rest in the inlet ghosts */
    void *inlet_user;
    pd_velocity_fn wall;    /* velocity along the surface of walls and solids, at points on it; NULL: at rest */
    void *wall_user;
} pd_flow_desc;

typedef struct pd_flow {
    const pd_grid *grid;
    const pd_bonds *bonds;
    double rho;             /* [kg/m3] */
    double nu;              /* [m2/s] */
    double force[PD_DIM];   /* [m/s2] */
    double p_out;           /* [m2/s2] kinematic */
    double speed, length;   /* [m/s] [m] */
    double tau;             /* [s] weight of the pressure flux (eq. 4.4) */
    pd_velocity_fn inlet;
    void *inlet_user;
    pd_velocity_fn wall;
    void *wall_user;
    double *drive;          /* [PD_DIM][total] [1/m/s] of moving walls (pdi_bond_drive); NULL: walls at rest */
    double *u;              /* [PD_DIM][total] [m/s] */
    double *p;              /* [total] [m2/s2] kinematic pressure */
    double *grad;           /* [PD_DIM][total] [m/s2] gradient of p */
    double *carrier;        /* [PD_DIM][total] [m/s] velocity that makes the bond fluxes (eq. 4.2b) */
    const double *potential; /* [total] [m2/s] its Laplacian takes from the bond fluxes the divergence that a steady
                             * solve has left (eq. 4.10b), zero at ports. NULL: none. Borrowed from the solver */
    int64_t evaluations;    /* operator evaluations so far: residuals and linearised products */
} pd_flow;

#define pd_flow_build PD_NAME(pd_flow_build)
#define pd_flow_update PD_NAME(pd_flow_update)
#define pd_flow_prepare PD_NAME(pd_flow_prepare)
#define pd_flow_residual PD_NAME(pd_flow_residual)
#define pd_flow_section PD_NAME(pd_flow_section)
#define pd_flow_section_nodes PD_NAME(pd_flow_section_nodes)
#define pd_flow_free PD_NAME(pd_flow_free)

/* Allocates the fields (fluid at rest, p = p_out) and fills the inlet ghosts. Grid and bonds are borrowed.
 * PD_ERR_ARGUMENT: rho, mu, speed or length not positive. */
PD_API pd_status pd_flow_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow_desc *desc,
                               pd_flow *flow);
/* After pd_bonds_update: `changed` nodes have turned fluid. They start at rest with the mean pressure of their
 * fluid neighbours. */
PD_API pd_status pd_flow_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_flow *flow);
/* Ghosts, pressure gradient and carrier of the u and p that the caller has put in: all that transport needs of a given
 * flow. */
PD_API void pd_flow_prepare(pd_ctx *ctx, pd_flow *flow);
/* Residuals of the present state: ru [PD_DIM][total] [m/s2], rc [total] [1/s], zero outside of fluid nodes. */
PD_API void pd_flow_residual(pd_ctx *ctx, pd_flow *flow, double *ru, double *rc);
/* Volume flux [m^d/s; planar 2D: per unit depth, axisymmetric: m3/s] of all bonds that cross the plane between cells
 * `index - 1` and `index` of `axis` (index 1 .. n-1): the quantity that the scheme conserves. */
PD_API double pd_flow_section(pd_ctx *ctx, pd_flow *flow, int axis, int index);
/* The same from node velocities of the layer `index` of `axis`: sum u_axis times the face of a cell. */
PD_API double pd_flow_section_nodes(pd_ctx *ctx, const pd_flow *flow, int axis, int index);
PD_API void pd_flow_free(pd_ctx *ctx, pd_flow *flow);

#ifdef PDI_INTERNAL
/* Fields of one evaluation. */
typedef struct pdi_flow_terms {
    const double *mass;    /* carrier: convects u; its divergence is the continuity term [m/s] */
    const double *u;       /* [m/s] */
    const double *p;       /* [m2/s2] */
    const double *grad;    /* gradient of p [m/s2] */
    const double *force;   /* [PD_DIM] [m/s2], or NULL */
    const double *drive;   /* of moving walls [1/m/s], or NULL */
} pdi_flow_terms;
/* carrier = K v at nodes whose family is cut, v elsewhere, ghosts filled (eq. 4.2b); v and its inlet ghosts are
 * given. */
PDI_FN void pdi_flow_carrier(const pd_ctx *ctx, const pd_flow *flow, const double *v, double *carrier);
/* grad = G p at fluid nodes, images and outlet ghosts (eq. 3.5). */
PDI_FN void pdi_flow_gradient(const pd_ctx *ctx, const pd_flow *flow, const double *p, double *grad);
/* Momentum and continuity terms M(u, P) (eq. 4.1, 4.2); ghosts must be filled. */
PDI_FN void pdi_flow_terms_apply(const pd_ctx *ctx, const pd_flow *flow, const pdi_flow_terms *t, double *ru,
                                 double *rc);
/* What steps carry on; with all that follows from it after reading. */
PDI_FN pd_status pdi_flow_store(pd_ctx *ctx, pd_flow *flow, pd_store *store);
/* Volume flux per volume [1/s] of the bond k from node i to its far end, pressure flux included (eq. 4.4). */
PDI_FN double pdi_flow_bond_flux(const pd_flow *flow, int32_t i, int k);
/* Volume per time [m3/s, per m in planar 2D] that bonds to inlets bring, and what they would with the velocity of the
 * inlets at both ends. */
PDI_FN double pdi_flow_entering(pd_ctx *ctx, pd_flow *flow, double *given);
/* A fluid node beside an inlet from which no open bonds lead to an outlet; -1: there is none. */
PDI_FN pd_status pdi_flow_blocked(pd_ctx *ctx, const pd_flow *flow, int32_t *node);
#endif

#endif
