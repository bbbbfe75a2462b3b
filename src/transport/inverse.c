/* inverse: see inverse.h */
#include "transport/inverse.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Conductance of nodes that hold their concentration, over that of their cell. */
#define PDI_INVERSE_STIFF 1e6

PDI_COLD_BEGIN
PDI_FN pd_status pdi_inverse_plan(pd_ctx *ctx, const pd_multigrid_desc *desc, pd_inverse *v)
{
    const pd_flow *flow = v->flux->flow;
    v->excess = flow ? 0.0 : pdi_compact_operator_inverse_excess(v->flux->bonds->stencil);
    pdi_compact_operator_init(v->flux->bonds->grid, flow != NULL, &v->compact);
    return pdi_multigrid_init(ctx, desc, &v->mg);
}

PDI_FN void pdi_inverse_list(pdi_array_visitor *owner, void *object)
{
    pd_inverse *inverse = (pd_inverse *)object;
    pdi_compact_operator_list(owner, &inverse->compact);
    pdi_multigrid_list(owner, &inverse->mg);
}

PDI_FN size_t pdi_inverse_room(pd_inverse *v)
{
    return pdi_arena_count_bytes(pdi_compact_operator_face_list, &v->compact) +
           pdi_arena_count_bytes(pdi_multigrid_setup_list, &v->mg);
}

PDI_FN void pdi_inverse_free(pd_ctx *ctx, pd_inverse *v) { pdi_multigrid_free(ctx, &v->mg); }
PDI_COLD_END

/* [1/s] What a node loses of its own concentration, beside what passes its bonds. Rising laws give, and are left out:
 * the preconditioner stays positive. */
static double pdi_inverse_own(const pd_inverse *v, int32_t i)
{
    const double *hold = v->flux->diffusion->wall_rate;
    return v->rate + pd_max(v->flux->absorb[i] + (hold ? hold[i] : 0.0), 0.0);
}

/* S of eq. 6.22 at node i; *direct: tau S [s]. */
static double pdi_inverse_share(const pd_inverse *v, int32_t i, double *direct)
{
    const pd_diffusion *d = v->flux->diffusion;
    double diffusivity = d->field ? d->field[i] : d->desc.diffusivity;
    double sum = diffusivity + v->excess * pdi_inverse_own(v, i);
    *direct = sum > 0.0 ? v->excess / sum : 0.0;
    return sum > 0.0 ? diffusivity / sum : 1.0;
}

/* What holds the concentrations of the cells: the time, the lines of the law, held walls. */
static void pdi_inverse_hold(pd_inverse *v, const int32_t *pinned, int32_t pinned_count)
{
    const pd_grid *grid = v->flux->bonds->grid;
    float *mass = v->compact.mass;
    int i[PD_DIM];
    for (int32_t node = 0; node < grid->total; node++) {
        if (grid->kind[node] != PD_FLUID) continue;
        double direct, own = pdi_inverse_own(v, node), around = pd_grid_circumference(grid, node);
        pd_grid_index(grid, node, i);
        int64_t cell = pdi_compact_operator_cell_index(grid, i);
        if (v->flux->flow) mass[cell] += (float)(around * (own - v->rate));
        else mass[cell] = (float)(around * own * pdi_inverse_share(v, node, &direct));
    }
    for (int32_t k = 0; k < pinned_count; k++) {
        pd_grid_index(grid, pinned[k], i);
        mass[pdi_compact_operator_cell_index(grid, i)] *= (float)PDI_INVERSE_STIFF;
    }
}

static pd_status pdi_inverse_fill(pd_ctx *ctx, pd_inverse *v, const int32_t *pinned, int32_t pinned_count)
{
    const pd_flux *flux = v->flux;
    const pd_diffusion *d = flux->diffusion;
    const pdi_compact_operator_bc faces = {0, 1, 0, NULL}; /* inlets hold a value */
    pdi_compact_operator_convection convection;
    double spread[PD_DIM * PD_DIM];
    pd_compact_operator *c = &v->compact;
    pdi_compact_operator_upwind_diffusion(flux->bonds->stencil, v->spread, spread);
    convection.u = flux->flow ? flux->flow->u : NULL;
    convection.numerical_diffusivity = spread;
    pdi_compact_operator_assemble(ctx, d->desc.diffusivity, d->field ? &d->media : NULL, &convection, v->rate, &faces,
                                  c);
    pdi_inverse_hold(v, pinned, pinned_count);
    pd_status status = pdi_multigrid_setup(ctx, &v->mg, c->active, (const float *const *)c->conductance,
                                           flux->flow ? (const float *const *)c->flux : NULL, c->dirichlet, c->mass);
    if (status != PD_ERR_ARGUMENT) return status;
    return pd_fail(ctx, PD_ERR_DIVERGED, "transport", "D = %g m2/s, h = %g m, speeds and the step give rates beyond "
                   "the range of numbers of the solver: expected those of what is dissolved in a fluid",
                   d->desc.diffusivity, flux->bonds->grid->h[0]);
}

PDI_FN pd_status pdi_inverse_setup(pd_ctx *ctx, pd_inverse *v, double rate, const int32_t *pinned,
                                   int32_t pinned_count)
{
    pd_compact_operator *c = &v->compact;
    pd_arena *arena = v->mg.desc.arena;
    /* at rest later stages of a step differ by what holds the nodes alone */
    int again = !v->flux->flow && v->fresh && v->rate >= rate && v->rate <= rate;
    v->rate = rate;
    if (again) {
        pdi_inverse_hold(v, pinned, pinned_count);
        return pdi_multigrid_update_mass(ctx, &v->mg, c->active, c->dirichlet, c->mass);
    }
    v->fresh = 1;
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_compact_operator_face_list, c));
    return pdi_arena_release(ctx, arena, pdi_compact_operator_face_list, c,
                             pdi_inverse_fill(ctx, v, pinned, pinned_count));
}

/* y = share x: the share of one thread. */
static void pdi_inverse_before(const pd_inverse *v, const double *x, double *y)
{
    const pd_grid *grid = v->flux->bonds->grid;
    PDI_FOR_NOWAIT
    for (int32_t i = 0; i < grid->total; i++) {
        double direct;
        if (grid->kind[i] == PD_FLUID) y[i] = pdi_inverse_share(v, i, &direct) * x[i];
    }
}

/* y = share y + direct x: the share of one thread. */
static void pdi_inverse_after(const pd_inverse *v, const double *x, double *y)
{
    const pd_grid *grid = v->flux->bonds->grid;
    PDI_FOR_NOWAIT
    for (int32_t i = 0; i < grid->total; i++) {
        double direct;
        if (grid->kind[i] != PD_FLUID) continue;
        y[i] *= pdi_inverse_share(v, i, &direct);
        y[i] += direct * x[i];
    }
}

PDI_FN void pdi_inverse_apply(pd_ctx *ctx, pd_inverse *v, const double *x, double *y)
{
    int nt = pd_par_threads(ctx, v->flux->bonds->grid->total * 4);
    if (!(v->excess > 0.0)) {
        pdi_multigrid_cycle(ctx, &v->mg, x, y);
        return;
    }
    PDI_PARALLEL_CALL(nt, pdi_inverse_before(v, x, y));
    pdi_multigrid_cycle(ctx, &v->mg, y, y);
    PDI_PARALLEL_CALL(nt, pdi_inverse_after(v, x, y));
}
