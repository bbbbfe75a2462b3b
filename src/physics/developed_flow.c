/* developed_flow: see developed_flow.h */
#include "physics/developed_flow.h"
#include <math.h>
#include <string.h>

/* Reynolds number of the duct flow. Any small one will do: the profile does not depend on it. */
#define PDI_DEVELOPED_FLOW_REYNOLDS 1e-3
/* Residual tolerance of the duct flow, and residual that is accepted where rounding stops the solver. */
#define PDI_DEVELOPED_FLOW_TOLERANCE 1e-11
#define PDI_DEVELOPED_FLOW_MAX_RESIDUAL 1e-7

/* The flow solver of a duct. */
typedef struct pdi_developed_flow {
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
} pdi_developed_flow;

/* Build the lattice of the duct, d->grid and d->bonds: a slice of the box at a side, two reaches of the stencil deep
 * and periodic along the flow, with inlets and outlets of other sides as mirrors; walls that have no node in it are
 * left out. After an error the caller frees. PD_ERR_GEOMETRY: no node of the duct has a wall in its family. */
static pd_status pdi_developed_flow_build_duct(pd_ctx *ctx, const pd_inlet *inlet, const pd_flow *flow, int side,
                                               pdi_developed_flow *d)
{
    const pd_setup *u = inlet->setup;
    const pd_grid *grid = inlet->grid;
    int axis = side / 2, walls = 0;
    double deep = 2 * flow->bonds->stencil->reach * grid->h[axis]; /* so that no bond passes a section twice */
    pd_grid_desc box;
    memset(&box, 0, sizeof box);
    for (int a = 0; a < PD_DIM; a++) {
        box.lo[a] = grid->lo[a];
        box.hi[a] = grid->hi[a];
    }
    if (side % 2) box.lo[axis] = grid->hi[axis] - deep;
    else box.hi[axis] = grid->lo[axis] + deep;
    for (int s = 0; s < 2 * PD_DIM; s++)
        box.side[s] = s / 2 == axis                                ? PD_SIDE_PERIODIC
                      : pd_grid_is_inlet_or_outlet(grid->side[s]) ? PD_SIDE_MIRROR
                                                                   : grid->side[s];
    box.axisymmetric = u->axisymmetric;
    for (int32_t node = 0; node < grid->total; node++) {
        double x[PD_DIM];
        pd_grid_position(grid, node, x);
        walls = walls || (grid->kind[node] == PD_WALL && x[axis] > box.lo[axis] && x[axis] < box.hi[axis]);
    }
    if (u->wall >= 0 && walls) {
        box.shapes = u->shape;
        box.wall = &u->shape[u->wall];
    }
    PD_TRY(pd_grid_build(ctx, flow->bonds->stencil, &box, &d->grid));
    PD_TRY(pd_bonds_build(ctx, flow->bonds->stencil, &d->grid, pdi_setup_get_bond_options(u), &d->bonds));
    for (int32_t r = 0; r < d->bonds.rows; r++)
        if (d->bonds.wall_laplacian[r] > 0.0) return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "inlet",
                   "side %s: found no wall beside the opening, so that no profile develops, expected profile = "
                   "uniform",
                   pd_setup_side_name(side));
}

/* Build and solve the steady duct flow, d->flow and d->steady, driven by a body force along `axis` that gives about the
 * small Reynolds number. A residual below 1e-7 counts as solved, also where the solver misses its tolerance of 1e-11.
 * PD_ERR_DIVERGED: it stays above. After an error the caller frees. */
static pd_status pdi_developed_flow_solve(pd_ctx *ctx, const pd_flow *flow, int axis, pdi_developed_flow *d)
{
    pd_flow_desc fd;
    pd_steady_desc sd;
    pd_steady_result result;
    memset(&fd, 0, sizeof fd);
    memset(&sd, 0, sizeof sd);
    fd.rho = flow->rho;
    fd.mu = flow->nu * flow->rho;
    fd.force[axis] = 12.0 * PDI_DEVELOPED_FLOW_REYNOLDS * flow->nu * flow->nu / pow(flow->length_scale, 3.0);
    fd.order = flow->order == 4 ? 4 : 2;
    sd.tolerance = PDI_DEVELOPED_FLOW_TOLERANCE;
    PD_TRY(pd_flow_build(ctx, &d->grid, &d->bonds, &fd, &d->flow));
    PD_TRY(pd_steady_build(ctx, &d->flow, &sd, &d->steady));
    d->flow.isotropic_blending = flow->isotropic_blending; /* friction is that of the run */
    if (!flow->isotropic_stencil.bonds) memset(&d->flow.isotropic_stencil, 0, sizeof d->flow.isotropic_stencil);
    pd_status status = pd_steady_solve(ctx, &d->steady, &result);
    double reached = result.residual_over_tolerance * PDI_DEVELOPED_FLOW_TOLERANCE;
    if (status <= 0 || reached < PDI_DEVELOPED_FLOW_MAX_RESIDUAL) return status < 0 ? status : PD_OK;
    return pd_fail(ctx, PD_ERR_DIVERGED, "inlet",
                   "the developed profile of an opening is not found: its residual is %g", reached);
}

/* Allocate inlet->profile[side] [cells of the side] and store the axial velocities of the duct there, scaled so that
 * their flux is inlet->opening: those of a mean velocity of 1. Cells that are not fluid get 0. */
static pd_status pdi_developed_flow_store_profile(pd_ctx *ctx, pd_inlet *inlet, int side, pdi_developed_flow *d)
{
    int axis = side / 2, i[PD_DIM];
    int64_t cells = pdi_inlet_count_side_cells(inlet->grid, side), place = 0;
    const double *u = d->flow.u + (int64_t)axis * d->grid.total;
    PD_TRY(PD_NEW(ctx, "inlet", cells, inlet->profile[side]));
    double scale = inlet->opening[side] / pd_flow_integrate_section(ctx, &d->flow, axis, 1);
    memset(i, 0, sizeof i);
    for (place = 0; place < cells; place++) {
        int64_t rest = place;
        for (int a = 0; a < PD_DIM; a++) {
            if (a == axis) continue;
            i[a] = (int)(rest % d->grid.n[a]);
            rest /= d->grid.n[a];
        }
        int32_t node = pd_grid_node(&d->grid, i);
        inlet->profile[side][place] = d->grid.kind[node] == PD_FLUID ? scale * u[node] : 0.0;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_developed_flow_compute_profiles(pd_ctx *ctx, pd_inlet *inlet, pd_flow *flow)
{
    int found = 0;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        pdi_developed_flow d;
        if (!inlet->needs_profile[side] || inlet->profile[side]) continue;
        memset(&d, 0, sizeof d);
        inlet->error_side = side;
        pd_status status = pdi_developed_flow_build_duct(ctx, inlet, flow, side, &d);
        if (status >= 0) status = pdi_developed_flow_solve(ctx, flow, side / 2, &d);
        if (status >= 0) status = pdi_developed_flow_store_profile(ctx, inlet, side, &d);
        pd_steady_free(ctx, &d.steady);
        pd_flow_free(ctx, &d.flow);
        pd_bonds_free(ctx, &d.bonds);
        pd_grid_free(ctx, &d.grid);
        if (status < 0) return status;
        found = 1;
    }
    return found ? pd_flow_update(ctx, NULL, 0, flow) : PD_OK;
}

#undef PDI_DEVELOPED_FLOW_REYNOLDS
#undef PDI_DEVELOPED_FLOW_TOLERANCE
#undef PDI_DEVELOPED_FLOW_MAX_RESIDUAL
