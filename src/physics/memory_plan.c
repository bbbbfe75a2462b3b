/* memory_plan: see memory_plan.h */
#include "physics/memory_plan.h"
#include <math.h>
#include <string.h>

/* Lattices with more nodes are planned with fewer layers and scaled up, so that numbers fit into an int32. */
#define PDI_MEMORY_PLAN_MAX_NODES 1e8

PDI_FN double pdi_memory_plan_count_bonds(double m)
{
    int reach = (int)ceil(m + 0.5) - 1, n[3] = {0, 0, 0};
    double bonds = -1.0;
    for (n[2] = PD_DIM > 2 ? -reach : 0; n[2] <= (PD_DIM > 2 ? reach : 0); n[2]++)
        for (n[1] = PD_DIM > 1 ? -reach : 0; n[1] <= (PD_DIM > 1 ? reach : 0); n[1]++)
            for (n[0] = -reach; n[0] <= reach; n[0]++)
                bonds += n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < (m + 0.5) * (m + 0.5);
    return bonds;
}

PDI_FN void pdi_memory_plan_init(const pd_setup *setup, const pd_memory_estimate *b, pdi_memory_plan *plan)
{
    pd_grid *grid = &plan->grid;
    double nodes = b->nodes;
    int reach = pd_setup_count_ghost_layers(setup);
    memset(plan, 0, sizeof *plan);
    pd_ctx_init(&plan->ctx);
    grid->ghost = reach;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        double cells = floor((setup->hi[d] - setup->lo[d]) / setup->h[d] + 0.5), fewer = cells;
        if (nodes > PDI_MEMORY_PLAN_MAX_NODES) fewer = pd_max(floor(cells * PDI_MEMORY_PLAN_MAX_NODES / nodes), 1.0);
        nodes *= (fewer + 2.0 * reach) / (cells + 2.0 * reach);
        grid->n[d] = (int)fewer;
        grid->padded[d] = grid->n[d] + 2 * reach;
        grid->h[d] = setup->h[d];
    }
    grid->total = 1;
    for (int d = 0; d < PD_DIM; d++) {
        grid->stride[d] = grid->total;
        grid->total *= grid->padded[d];
    }
    for (int s = 0; s < 2 * PD_DIM; s++) grid->side[s] = setup->side[s].kind;
    plan->node_scale = b->nodes / grid->total;
    grid->fluid_count = (int64_t)(b->fluid / plan->node_scale);
    grid->solid = setup->solid;
    grid->solid_count = setup->solid >= 0 ? (int64_t)(b->solid / plan->node_scale) + 1 : 0;
    plan->stencil.count = (int)b->bonds;
    plan->stencil.reach = (int)ceil(setup->fluid_m + 0.5) - 1;
    plan->across.count = (int)pdi_memory_plan_count_bonds(setup->metal_m);
    plan->bonds.stencil = &plan->stencil;
    plan->bonds.grid = grid;
    plan->bonds.options = pdi_setup_get_bond_options(setup);
    plan->bonds.paths.words = (plan->stencil.count + 31) / 32;
    plan->bonds.capacity = (int32_t)(1.25 * b->truncated / plan->node_scale);
    plan->bonds.active_ranges.total = grid->total;
    plan->bonds.active_ranges.packed_length = (int32_t)((b->fluid + b->solid) / plan->node_scale);
    plan->flow.grid = grid;
    plan->flow.bonds = &plan->bonds;
}

PDI_FN double pdi_memory_plan_count_array_bytes(const pdi_memory_plan *plan, pdi_array_list_fn list, void *object)
{
    return plan->node_scale * (double)pdi_array_registry_count_bytes(list, object);
}

PDI_FN double pdi_memory_plan_count_level_bytes(const pdi_memory_plan *plan, const pd_multigrid *mg)
{
    double contrast = mg->desc.high_contrast ? 1.0 : 0.0;
    double link = mg->desc.symmetric ? 12.0 : 16.0;
    double cell = 4.0 + (4.0 * (4.0 + contrast) + 16.0 + 8.0 * contrast + link * 2 * PD_DIM) / ((1 << PD_DIM) - 1);
    return plan->node_scale * cell * mg->level[0].cells;
}

PDI_FN void pdi_memory_plan_add_shared_levels(pdi_memory_plan *plan, double levels, pd_memory_estimate *b)
{
    double more = pd_max(levels - plan->level_bytes, 0.0);
    plan->level_bytes += more;
    b->runtime_bytes += more;
}

PDI_FN double pdi_memory_plan_add_scratch(pdi_memory_plan *plan, size_t room)
{
    double more = pd_max(plan->node_scale * (double)room - plan->scratch_bytes, 0.0);
    plan->scratch_bytes += more;
    return more;
}

PDI_FN double pdi_memory_plan_count_krylov_bytes(pdi_memory_plan *plan, const pd_krylov_desc *desc)
{
    pd_krylov krylov;
    pdi_krylov_init(&plan->ctx, desc, &krylov);
    return pdi_memory_plan_count_array_bytes(plan, pdi_krylov_list, &krylov);
}

PDI_FN double pdi_memory_plan_get_placeholder(void *user, const double *x)
{
    (void)user;
    return x[0];
}

#undef PDI_MEMORY_PLAN_MAX_NODES
