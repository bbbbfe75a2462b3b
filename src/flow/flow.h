/* flow: peridynamic Navier-Stokes operator: momentum and continuity residuals, their linearisation, flux sections.
 *
 * Unknowns are the velocity u [m/s] and the kinematic pressure P = p/rho [m2/s2] of fluid nodes. Continuity is a sum
 * of antisymmetric bond fluxes F_ij = g.(v_i + v_j) over open bonds, so nothing passes solid or wall; a fourth-order
 * antisymmetric pressure flux ties odd and even nodes (theory: eq. 3.1 to 3.12; Zhao and Bobaru 2022).
 */
#ifndef PD_FLOW_H
#define PD_FLOW_H
#include "core/array_registry.h"
#include "flow/isotropic_stencil.h"
#include "flow/fourth_order.h"
#include "lattice/reconstruct.h"
#include "lattice/node_loop.h"
#include <math.h>

#define PD_FLOW_ORDER_AUTO (-1)

typedef struct pd_flow_desc {
    double rho;             /* [kg/m3] */
    double mu;              /* [Pa s] */
    double force[PD_DIM];   /* [m/s2] body force per mass */
    pd_velocity_fn body;    /* [m/s2] position-dependent body force, on top of `force`; NULL: none */
    void *body_user;
    double *clock;          /* [s] where inlet, wall and body read the time: it is written there before they are asked.
                             * NULL: they do not depend on time. Borrowed */
    double p_out;           /* [Pa] at outlets */
    double report_speed;    /* [m/s] reference U of reported residuals; 0: the scale U of the flow (eq. 3.9) */
    double report_length;   /* [m] reference L of reported residuals; 0: the scale L of the flow (eq. 3.9) */
    pd_velocity_fn inlet;   /* [m/s] velocity at inlets (Dirichlet); NULL: fluid at rest in the inlet ghosts */
    void *inlet_user;
    int developed_sides;    /* bit s: the inlet on side s has developed flow, constant along its normal */
    pd_velocity_fn wall;    /* [m/s] tangential velocity of walls and solids at points on them; NULL: no slip at rest */
    void *wall_user;
    int order; /* of steady and implicit flow: 2 or 4; 0: 2. 4 needs m = 1 and a planar lattice.
                * PD_FLOW_ORDER_AUTO: 4 in steady flows where that is known to pay (theory: eq. 3.24), else 2;
                * pd_implicit takes 2 or 4 */
} pd_flow_desc;

typedef struct pd_flow {
    const pd_grid *grid;
    const pd_bonds *bonds;
    double rho;             /* [kg/m3] */
    double nu;              /* [m2/s] */
    double force[PD_DIM];   /* [m/s2] */
    pd_velocity_fn body_force_fn; /* [m/s2] callback of the position-dependent body force */
    void *body_force_user;
    double *body_force;     /* [PD_DIM][total] [m/s2] body force of body_force_fn at nodes; NULL: none */
    double *clock, time;    /* [s] `time`: of the boundary data and of the body force */
    double p_out;           /* [m2/s2] kinematic */
    /* [m/s] [m] scales U and L of the problem (eq. 3.9), for tolerances and stabilisation */
    double velocity_scale, length_scale;
    double reference_speed, reference_length; /* [m/s] [m] for reports alone */
    double stabilisation;   /* [s] weight tau of the pressure flux (eq. 3.7, 3.8) */
    int is_weakly_compressible; /* 1: that weight is the diffusion of density, which does not follow U */
    double *pressure_impulse; /* [total] [m2/s] pressure impulse, which the pressure flux of implicit flow is made of
                               * (eq. 3.43); NULL: it is tau times p. Borrowed from the integrator, as the next two */
    double *pressure_impulse_grad; /* [PD_DIM][total] [m/s] its gradient */
    double *pressure_impulse_flux; /* [total] [1/s] divergence of the known part of that pressure flux */
    /* [s] weight of the unknown pressure in it while a stage is solved; 0: no stage is */
    double stage_weight;
    pd_velocity_fn inlet;
    void *inlet_user;
    int developed_sides;
    pd_velocity_fn wall;
    void *wall_user;
    int inlets_on_side;   /* 1: inlet velocities hold on the side of the box, and ghosts are odd about them (eq.
                           * 3.10), as the steady solver needs; 0: they hold at the ghosts */
    int32_t inlet_ghosts; /* number of inlet ghosts */
    /* [PD_DIM][inlets] [m/s] prescribed (Dirichlet) velocity, in the order of the ghosts */
    double *inlet_velocity;
    /* [inlets] 1: tangential velocity would contribute to the inflow by bonds (eq. 3.11) */
    uint8_t *has_tangential_weight;
    /* [inlets] [-] factor k on the normal velocity (eq. 3.11); -1: the tensor of the row */
    double *inlet_speed_ratio;
    double *wall_motion; /* [PD_DIM][total] [1/m/s] Laplacian terms of moving walls (pdi_bond_sum_wall_velocity), with
                          * their acceleration (eq. 3.46); NULL: walls at rest */
    double *u;              /* [PD_DIM][total] [m/s] */
    double *p;              /* [total] [m2/s2] kinematic pressure */
    double *pressure_grad;  /* [PD_DIM][total] [m/s2] gradient of p */
    double *advecting;      /* [PD_DIM][total] [m/s] velocity that makes the bond fluxes (eq. 3.4) */
    const double *
        divergence_potential; /* [total] [m2/s] correction potential: its gradient makes the bond fluxes divergence-free
                               * (eq. 3.34), without flux through inlets. NULL: none. Borrowed from the solver */
    int uses_axis_divergence; /* 1: rows beside smooth surfaces take the pointwise divergence (3.5). The steady solver
                               * sets it, since its potential then makes fluxes for transport free of divergence */
    int32_t row_capacity;     /* rows that patch, more and leak have room for */
    int32_t *patch;         /* [rim] connected patch of a row beside a smooth surface: its first row; -1: other rows */
    uint32_t patch_version; /* version of the bonds (geometry) that the patches belong to */
    /* quadratic fits of pressure and velocity beside smooth surfaces (eq. 2.7, 2.11) */
    pd_quadratic_reconstruction wall_fit;
    int order;             /* 2 or 4; the steady solver builds `sharp` for 4. PD_FLOW_ORDER_AUTO: it decides which */
    pd_fourth_order fourth_order; /* corrections of fourth order; empty: second order */
    /* isotropic friction weights of second order (eq. 3.14); empty: those of the Laplacian */
    pd_isotropic_stencil isotropic_stencil;
    double isotropic_blending; /* [-] blending factor of these weights (eq. 3.17) */
    /* [rim] [1/s] work of (3.5): excess of a row; [2 rim] sum over a patch, row count */
    double *divergence_excess, *patch_sums;
    int64_t evaluations;    /* operator evaluations so far: residuals and linearised products */
} pd_flow;

#define pd_flow_build PD_NAME(pd_flow_build)
#define pd_flow_update PD_NAME(pd_flow_update)
#define pd_flow_integrate_section PD_NAME(pd_flow_integrate_section)
#define pd_flow_free PD_NAME(pd_flow_free)

/* Allocates the fields (fluid at rest, p = p_out), evaluates boundary data at time 0 and estimates the scales. Grid and
 * bonds are borrowed. PD_ERR_ARGUMENT, flow is freed: rho or mu not positive, speed or length negative, a value not
 * finite (mu/rho and p_out/rho, too), an unknown order, bonds without flow. */
PD_API pd_status pd_flow_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow_desc *desc,
                               pd_flow *flow);
/* After pd_bonds_update: `changed` nodes have turned fluid. They get velocity 0 and the mean pressure of the fluid
 * nodes of their family that no closed cell blocks: layer by layer from what was fluid before, in any order of
 * `changed` (p_out without any). Boundary data are
 * evaluated again at flow->time, without acceleration of walls. Scales, derived fields and surface patches stay.
 * PD_ERR_ARGUMENT: a boundary value is not finite. */
PD_API pd_status pd_flow_update(pd_ctx *ctx, const int32_t *changed, int32_t count, pd_flow *flow);
#ifdef PDI_INTERNAL
/* Updates all that follows from the u and p that the caller has put in: velocity ghosts (inlets: the prescribed
 * velocity), pressure ghosts, pressure gradient, advecting velocity, second differences of fourth order. Transport
 * needs no more of a given flow. */
PDI_FN void pdi_flow_update_derived_fields(pd_ctx *ctx, pd_flow *flow);
/* Sets flow->time, *clock, inlet velocities, wall terms and the body force to time t [s]; without a clock all stays,
 * *change is 0. half_step [s]: wall acceleration is the mean over t +- half_step (eq. 3.46); 0: none. *change (NULL
 * allowed) [-]: the largest of velocity changes over U, force changes over U^2/L + nu U/L^2. Faster inlets or walls
 * raise U and update tau; slower ones do not lower them. PD_ERR_ARGUMENT: a value is not finite; data are part old,
 * part new then. */
PDI_FN pd_status pdi_flow_set_time(pd_ctx *ctx, pd_flow *flow, double t, double half_step, double *change);
/* Residuals of the present state at fluid nodes: momentum ru [PD_DIM][total] [m/s2] (du/dt = -ru) and continuity rc
 * [total] [1/s], divergence less pressure flux (eq. 3.1, 3.2), with body force, fitted walls and terms of fourth order.
 * Entries of other nodes stay as they are. Updates the derived fields first (pdi_flow_update_derived_fields), and
 * counts one evaluation. */
PDI_FN void pdi_flow_assemble_residual(pd_ctx *ctx, pd_flow *flow, double *ru, double *rc);
#endif
/* Volume flux [m^d/s; planar 2D: per unit depth, axisymmetric: m3/s], positive along `axis`, of all open bonds that
 * cross the plane between cells index - 1 and index (1 .. n-1; not checked), with pressure flux and divergence
 * potential: what the scheme conserves. Updates the derived fields. */
PD_API double pd_flow_integrate_section(pd_ctx *ctx, pd_flow *flow, int axis, int index);
#ifdef PDI_INTERNAL
/* Volume flux [m^d/s], positive along `axis`, from the node velocities of the layer `index` of cells: sum of u_axis
 * times the face of a cell over its fluid nodes. */
static inline double pdi_flow_integrate_nodal_section(const pd_flow *flow, int axis, int index)
{
    const pd_grid *grid = flow->grid;
    double sum = 0.0, face = flow->bonds->stencil->volume / grid->h[axis];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        if (i[axis] != index) continue;
        sum += flow->u[(int64_t)axis * grid->total + node] * face * pd_grid_circumference(grid, node);
    }
    return sum;
}
#endif
PD_API void pd_flow_free(pd_ctx *ctx, pd_flow *flow);

#ifdef PDI_INTERNAL
/* Lists the arrays of a pd_flow (`object`) that it has from the start, for allocation, checkpoint and freeing. */
PDI_FN void pdi_flow_list(pdi_array_visitor *owner, void *object);

/* Input fields of one evaluation of momentum and continuity. */
typedef struct pdi_flow_operands {
    const double *advecting; /* [m/s] advecting velocity: it convects u, and its divergence is the continuity term */
    const double *u;       /* [m/s] */
    const double *p;       /* [m2/s2] */
    const double *grad;    /* gradient of p [m/s2] */
    const double *force;   /* [PD_DIM] [m/s2], or NULL */
    const double *wall_motion; /* [1/m/s] of moving walls, or NULL */
} pdi_flow_operands;
/* advecting [PD_DIM][total] [m/s] = the velocity that makes the bond fluxes: K v at rows (K: tensor of eq. 3.4), v at
 * other nodes. With uses_axis_divergence rows beside smooth surfaces have no K, and in second order (3.6) corrects v
 * at all nodes. Ghosts of v are given; those of advecting are filled, at inlets by (3.11) if inlets_on_side. second:
 * second differences of v for the fourth-order correction (eq. 3.19); NULL: second order. */
PDI_FN void pdi_flow_compute_advecting_velocity(const pd_ctx *ctx, const pd_flow *flow, const double *v,
                                                const double *second, double *advecting);
/* Weight [s] of the present pressure in the stabilising pressure flux: tau of eq. 3.7, or that of a stage in time. */
static inline double pdi_flow_get_pressure_flux_weight(const pd_flow *flow)
{
    return flow->pressure_impulse ? flow->stage_weight : flow->stabilisation;
}
/* From here on inlets hold their velocity on the side of the box: ghosts are odd about it (eq. 3.10). Evaluates inlet
 * velocities and their ratios (eq. 3.11) anew; derived fields stay. Without an inlet callback inlets_on_side is 0.
 * PD_ERR_ARGUMENT: a velocity is not finite. */
PDI_FN pd_status pdi_flow_set_inlets_on_side(pd_ctx *ctx, pd_flow *flow);
/* Fills the ghosts of a velocity v [PD_DIM][total] [m/s]. is_state 1: v is odd about the prescribed velocity on inlet
 * sides; 0: v is a Newton increment, odd about 0. Unless inlets_on_side, inlet ghosts stay as they are. */
PDI_FN void pdi_flow_update_velocity_ghosts(const pd_flow *flow, int is_state, double *v);
/* grad [PD_DIM][total] [m/s2] = pressure gradient G p at fluid nodes, mirror images and outlet ghosts; inlet ghosts
 * stay (eq. 2.9; beside smooth surfaces 2.11 if uses_axis_divergence; of fourth order 3.20). Ghosts of p must be
 * filled. */
PDI_FN void pdi_flow_compute_pressure_gradient(const pd_ctx *ctx, const pd_flow *flow, const double *p, double *grad);
/* ru, rc at fluid nodes = momentum [m/s2] and continuity [1/s] sums over all open bonds (eq. 3.1, 3.2): convection,
 * friction with its parabola at walls and the row corrections of isotropic weights, pressure gradient less t->force,
 * pressure flux (none to inlets). Ghosts of all fields must be filled. Fourth order, fitted walls, the divergence
 * correction and the position-dependent force are added by other functions. */
PDI_FN void pdi_flow_assemble_bond_sums(const pd_ctx *ctx, const pd_flow *flow, const pdi_flow_operands *t, double *ru,
                                        double *rc);
/* Subtracts the position-dependent body force from the momentum residual ru [PD_DIM][total] [m/s2] at fluid nodes;
 * beside walls (1 - wall_curvature) times it, as of the pressure gradient (eq. 2.4). Nothing without a body force
 * callback. */
PDI_FN void pdi_flow_add_body_force(const pd_ctx *ctx, const pd_flow *flow, double *ru);
/* Body force per mass [m/s2] along axis d at a fluid node: the uniform one and that of the callback. */
static inline double pdi_flow_get_body_force(const pd_flow *flow, int d, int32_t node)
{
    return flow->force[d] + (flow->body_force ? flow->body_force[(int64_t)d * flow->grid->total + node] : 0.0);
}
/* After a change of geometry: groups the rows (nodes with cut families) beside smooth surfaces into connected patches,
 * over which the divergence (3.5) is made conservative: patch, patch_version. uses_axis_divergence becomes 1 where
 * there are such rows on a planar lattice; then fits the walls (wall_fit). Marks the regular nodes of fourth order.
 * Without such rows patch_version is 0, patch and wall_fit stay. Row arrays grow with the rows, and are zeroed then. */
PDI_FN pd_status pdi_flow_find_surface_patches(pd_ctx *ctx, pd_flow *flow);
/* 1: row r takes the wall terms of the quadratic fit (2.7) in place of the parabola of (2.3) and (2.4). Rows beside a
 * moving surface keep the parabola. */
static inline int pdi_flow_has_fitted_wall(const pd_flow *flow, int32_t r)
{
    if (!flow->uses_axis_divergence || !pdi_reconstruct_has_velocity_fit(&flow->wall_fit, r)) return 0;
    for (int d = 0; d < PD_DIM && flow->wall_motion; d++)
        if (fabs(flow->wall_motion[(int64_t)d * flow->grid->total + flow->bonds->node[r]]) > 0.0) return 0;
    return 1;
}
/* ru += the difference between the fitted wall terms (2.7, 2.8) and those of (2.3), (2.4), for velocity u, pressure p
 * and its gradient, at rows with pdi_flow_has_fitted_wall. is_state 1: the body force counts; 0: a Newton increment.
 * Nothing unless uses_axis_divergence. */
PDI_FN void pdi_flow_add_fitted_wall(const pd_ctx *ctx, const pd_flow *flow, const double *u, const double *p,
                                     const double *grad, int is_state, double *ru);
/* rc += sign times the difference between the pointwise divergence (3.5) and the bond fluxes of `advecting`, beside
 * smooth surfaces. Its mean over each patch is 0, so no volume passes the body. is_state 0: u is a Newton increment.
 * Overwrites divergence_excess and patch_sums. Nothing unless uses_axis_divergence. */
PDI_FN void pdi_flow_add_divergence_correction(const pd_ctx *ctx, const pd_flow *flow, const double *u,
                                               const double *advecting, int is_state, double sign, double *rc);
/* ru += the fourth-order correction of momentum (eq. 3.21 to 3.23). u == flow->u: of the state; else its derivative
 * along the increment u, whose advecting velocity and pressure gradient are given. Second differences must be in
 * fourth_order.second, those of an increment in second_increment; `work` is overwritten. Nothing for second order. */
PDI_FN void pdi_flow_add_fourth_order(const pd_ctx *ctx, const pd_flow *flow, const double *u, const double *advecting,
                                      const double *grad, double *ru);
/* Writes the state to a checkpoint; or reads it, sets the boundary data to its time (with a clock) and updates all
 * derived fields. PD_ERR_ARGUMENT after reading: a boundary value is not finite. */
PDI_FN pd_status pdi_flow_store(pd_ctx *ctx, pd_flow *flow, pd_archive *archive);
/* Raises the velocity scale U to the largest size of a velocity component at fluid nodes, never lowers it: the start of
 * a flow in time. Updates tau of the pressure stabilisation (eq. 3.8; not of weakly compressible flow) and the
 * isotropic blending (eq. 3.17). */
PDI_FN void pdi_flow_update_speed_scale(pd_flow *flow);
/* Scale of the momentum residual, U^2/L + nu U/L^2 [m/s2] (eq. 3.25). That of continuity is U/L. */
static inline double pdi_flow_get_momentum_scale(const pd_flow *flow, double speed, double length)
{
    return speed / length * (speed + flow->nu / length);
}
/* ---- volume flux of a bond (eq. 3.7): share g.(w_i + w_j) - tau/2 a stabiliser. It is linear: that of a step is its
 * derivative, in single precision for the products of solvers ---- */
/* Dot product g.w at one end of a bond; components of w are `stride` apart. */
PDI_INLINE double pdi_flow_dot(const double *g, const double *w, int64_t stride)
{
    double sum = g[0] * w[0];
    for (int d = 1; d < PD_DIM; d++) sum += g[d] * w[d * stride];
    return sum;
}
/* Dot product g.w at one end of a bond in single precision; components of w are `stride` apart. */
PDI_INLINE float pdi_flow_dot_single(const float *g, const float *w, int64_t stride)
{
    float sum = g[0] * w[0];
    for (int d = 1; d < PD_DIM; d++) sum += g[d] * w[d * stride];
    return sum;
}
/* g.(w_i + w_j): volume flux per volume [1/s] that the advecting velocity w carries through the bond (eq. 3.2, 3.3).
 * near, far: w at the two ends. */
PDI_INLINE double pdi_flow_compute_convective_flux(const double *g, const double *near, int64_t near_stride,
                                                   const double *far, int64_t far_stride)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += g[d] * (near[d * near_stride] + far[d * far_stride]);
    return sum;
}
/* Pressure stabilisation of a bond, 2 (p_j - p_i) - xi.(G_i + G_j) (eq. 3.7): pressure difference less that of the
 * gradients, of fourth order. step: p_j - p_i; near, far: gradients at the two ends. */
PDI_INLINE double pdi_flow_compute_stabilisation(const double *xi, double step, const double *near, int64_t near_stride,
                                                 const double *far, int64_t far_stride)
{
    double stabiliser = 2.0 * step;
    for (int d = 0; d < PD_DIM; d++) stabiliser -= xi[d] * (near[d * near_stride] + far[d * far_stride]);
    return stabiliser;
}
/* Pressure stabilisation of a bond, 2 (p_j - p_i) - xi.(G_i + G_j) (eq. 3.7), in single precision. step: p_j - p_i. */
PDI_INLINE float pdi_flow_compute_stabilisation_single(const float *xi, float step, const float *near,
                                                       int64_t near_stride, const float *far, int64_t far_stride)
{
    float stabiliser = 2.0f * step;
    for (int d = 0; d < PD_DIM; d++) stabiliser -= xi[d] * (near[d * near_stride] + far[d * far_stride]);
    return stabiliser;
}
/* Volume flux per volume of node i [1/s] from node i through bond k to its far end, with pressure flux and
 * divergence-free correction (eq. 3.7, 3.34). Bonds from or to inlets carry no pressure flux. The pressure flux is of
 * tau p, or of the pressure impulse if there is one. It is what advects solutes. Derived fields must be up to date;
 * whether the bond is open is not checked. */
PDI_FN double pdi_flow_compute_bond_flux(const pd_flow *flow, int32_t i, int k);
#endif

#endif
