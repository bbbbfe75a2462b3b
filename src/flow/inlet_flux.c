/* inlet_flux: see inlet_flux.h */
#include "flow/inlet_flux.h"
#include "flow/inflow.h"
#include <math.h>
#include <stdlib.h>

/* Volume flux [m^d/s; axisymmetric: m3/s] into the box, positive inwards, through the face `up` (0 or 1) of node i
 * across axis d. Velocity on the face: the mean of node and ghost with inlets_on_side, else that of the ghost. 0: the
 * ghost next to the node is no inlet. */
static double pdi_inlet_flux_compute_face(const pd_flow *flow, int32_t i, int d, int up)
{
    const pd_grid *grid = flow->grid;
    int32_t ghost = up ? i + grid->stride[d] : i - grid->stride[d];
    if (grid->kind[ghost] != PD_INLET) return 0.0;
    const double *v = flow->u + (int64_t)d * grid->total;
    double u = flow->inlets_on_side ? 0.5 * (v[ghost] + v[i]) : v[ghost], half = 0.5 * grid->h[d];
    double around = pdi_grid_circumference_at(grid, i, d < PD_DIM - 1 ? 0.0 : up ? half : -half);
    return (up ? -u : u) * around * flow->bonds->stencil->volume / grid->h[d];
}

/* Volume flux [m^d/s], positive inwards, that bonds through the end `up` (0 or 1) of axis d bring to node i, by the
 * advecting velocities of node i and of its mirror image behind that side. 0: that image is beyond the ghosts or no
 * inlet. */
static double pdi_inlet_flux_compute_developed(const pd_flow *flow, int32_t i, int d, int up)
{
    const pd_grid *grid = flow->grid;
    int position = pdi_grid_index_along(grid, i, d), shift = up ? 2 * (grid->n[d] - position) - 1 : -2 * position - 1;
    int32_t ghost = i + shift * grid->stride[d];
    if (abs(shift) > 2 * grid->ghost || grid->kind[ghost] != PD_INLET) return 0.0;
    const double *v = flow->advecting + (int64_t)d * grid->total;
    return (up ? -1.0 : 1.0) * pdi_inflow_compute_flux_weight(flow->bonds, i, d, up) * (v[i] + v[ghost]);
}

PDI_FN double pdi_inlet_flux_integrate(pd_ctx *ctx, pd_flow *flow, double *net_inlet, double *gross_inlet)
{
    const pd_bonds *bonds = flow->bonds;
    const pd_grid *grid = flow->grid;
    const pd_stencil *s = bonds->stencil;
    double entering = 0.0;
    *net_inlet = *gross_inlet = 0.0;
    pdi_flow_update_derived_fields(ctx, flow);
    for (int32_t i = 0; i < grid->total; i++) {
        int32_t row = bonds->row_of_node[i];
        if (grid->kind[i] != PD_FLUID || row < bonds->rows_without_inlet) continue;
        double volume = s->volume * pd_grid_circumference(grid, i);
        for (int k = 0; k < s->count; k++)
            if (grid->kind[i + bonds->paths.shift[k]] == PD_INLET && pdi_bond_is_open(bonds, row, k))
                entering -= volume * pdi_flow_compute_bond_flux(flow, i, k);
        for (int side = 0; side < 2 * PD_DIM; side++) {
            int faces = side / 2 == PD_DIM - 1 && pdi_inflow_has_radial_balance(bonds);
            double part = flow->inlets_on_side && flow->developed_sides >> side & 1 && !faces
                              ? pdi_inlet_flux_compute_developed(flow, i, side / 2, side % 2)
                              : pdi_inlet_flux_compute_face(flow, i, side / 2, side % 2);
            *net_inlet += part;
            *gross_inlet += fabs(part);
        }
    }
    return entering;
}
