/* pressure_impulse: see pressure_impulse.h */
#include "flow/pressure_impulse.h"
#include "core/par.h"

/* Sweep callback: pressure_impulse_flux [1/s] = divergence of the pressure flux of the whole impulse at `count`
 * consecutive nodes from i, which are the rows from `row` (-1: full families). Bonds to inlets carry none. */
static void pdi_pressure_impulse_compute_flux_range(const void *user, int32_t i, int32_t row, int32_t count)
{
    const pd_flow *flow = (const pd_flow *)user;
    const pd_bonds *bonds = flow->bonds;
    const pd_stencil *s = bonds->stencil;
    int64_t total = flow->grid->total;
    for (int32_t b = 0; b < count; b++, i++) {
        const double *p = flow->pressure_impulse, *grad = flow->pressure_impulse_grad,
                     *a = pdi_bond_get_laplacian_weights(bonds, i);
        double sum = 0.0;
        for (int k = 0; k < s->count; k++) {
            int32_t j = i + bonds->paths.shift[k];
            if (row >= 0 && (!pdi_bond_is_open(bonds, row + b, k) || flow->grid->kind[j] == PD_INLET)) continue;
            sum += a[k] *
                   pdi_flow_compute_stabilisation(s->xi + k * PD_DIM, p[j] - p[i], grad + i, total, grad + j, total);
        }
        flow->pressure_impulse_flux[i] = -0.5 * sum;
    }
}

PDI_FN void pdi_pressure_impulse_update_flux(const pd_ctx *ctx, pd_flow *flow, double share, double now)
{
    int64_t work = flow->grid->fluid_count * flow->bonds->stencil->count * 4;
    pdi_ghosts_set_pressure(&flow->bonds->ghosts, 0.0, flow->pressure_impulse);
    pdi_flow_compute_pressure_gradient(ctx, flow, flow->pressure_impulse, flow->pressure_impulse_grad);
    pdi_node_loop_by_ranges(ctx, flow->bonds, work, 0, pdi_pressure_impulse_compute_flux_range, flow);
    if (share < 1.0 || share > 1.0)
        pdi_par_axpy(ctx, flow->grid->total, share - 1.0, flow->pressure_impulse_flux, flow->pressure_impulse_flux);
    flow->stage_weight = now;
}

PDI_FN void pdi_pressure_impulse_update(pd_flow *flow, double share, double weight)
{
    for (int32_t i = 0; i < flow->grid->total; i++)
        if (flow->grid->kind[i] == PD_FLUID)
            flow->pressure_impulse[i] = share * flow->pressure_impulse[i] + weight * (flow->p[i] - flow->p_out);
}
