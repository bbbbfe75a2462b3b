/* reaction_force: see reaction_force.h */
#include "physics/reaction_force.h"
#include <string.h>

/* Sum over all points of the nodal loads times volumes of the traction and pressure of condition k: force [PD_DIM] [N].
 * load [points][PD_DIM] [N/m3]: work, zero before. PD_ERR_STATE: as of pdi_mechanical_bc_add_traction; force stays
 * then. */
static pd_status pdi_reaction_force_compute_applied_load(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t,
                                                         double *load, double *force)
{
    const pd_solid_coupling *s = g->structure;
    pdi_compensated_sum sum[PD_DIM];
    memset(sum, 0, sizeof sum);
    PD_TRY(pdi_mechanical_bc_add_traction(ctx, g, k, t, load));
    for (int64_t n = 0; n < (int64_t)s->count * PD_DIM; n++)
        pdi_compensated_sum_add(&sum[n % PD_DIM], s->body.volume[n / PD_DIM] * load[n]);
    for (int d = 0; d < PD_DIM; d++) force[d] = pdi_compensated_sum_total(&sum[d]);
    return PD_OK;
}

/* Least-squares fit of the stress at an edge or corner: where several sides prescribe a component, the force density on
 * a point is f = sum P_a c_a by (14.5), c_a the part of c along the normal of side a. Normal equations for P_a. */
typedef struct pdi_reaction_force_corner_fit {
    double matrix[PD_DIM][PD_DIM], rhs[PD_DIM]; /* [1/m2], [N/m4] matrix and right side */
    double stress[PD_DIM]; /* [Pa] solution: stress component d on each of the sides */
} pdi_reaction_force_corner_fit;

/* [N/m3] Residual force density of component d of point i, bond forces and loads: minus the reaction of what prescribes
 * it. */
static double pdi_reaction_force_get_residual(const pd_mechanical_bc *g, int32_t i, int d)
{
    int64_t n = (int64_t)i * PD_DIM + d;
    return pdi_solid_coupling_forces(g->structure)[n] + pdi_solid_coupling_loads(g->structure)[n];
}

/* Fit by least squares the stresses on `count` sides (holders) to the residual of component d at the points that all of
 * them hold, in the plane of their normals through point i, into fit->stress [Pa], in the order of holders. Points
 * without metal at the start or not prescribed are left out; a stress without a positive pivot is 0. */
static void pdi_reaction_force_fit_corner_stress(const pd_mechanical_bc *g, const int *holders, int count, int32_t i,
                                                 int d, pdi_reaction_force_corner_fit *fit)
{
    const pd_solid_coupling *s = g->structure;
    int all = 1, depth = pdi_mechanical_bc_count_held_layers(g), at[PD_DIM];
    if (count > PD_DIM) count = PD_DIM;
    memset(fit, 0, sizeof *fit);
    pd_grid_index(s->grid, s->node[i], at);
    for (int a = 0; a < count; a++) all *= depth;
    for (int n = 0; n < all; n++) {
        double c[PD_DIM];
        for (int a = 0, rest = n; a < count; a++, rest /= depth) {
            int side = g->setup->metal_body.mechanical_bc[holders[a]].side;
            at[side / 2] = side % 2 ? s->grid->n[side / 2] - 1 - rest % depth : rest % depth;
        }
        int32_t j = s->point[pd_grid_node(s->grid, at)];
        if (j < 0 || !s->prescribed[(int64_t)j * PD_DIM + d]) continue;
        for (int a = 0; a < count; a++)
            c[a] = pdi_mechanical_bc_get_surface_coefficient(g, j, g->setup->metal_body.mechanical_bc[holders[a]].side);
        for (int a = 0; a < count; a++) {
            fit->rhs[a] += c[a] * pdi_reaction_force_get_residual(g, j, d);
            for (int b = 0; b < count; b++) fit->matrix[a][b] += c[a] * c[b];
        }
    }
    for (int a = 0; a < count; a++) /* Gauss */
        for (int b = a + 1; b < count; b++) {
            double factor = fit->matrix[a][a] > 0.0 ? fit->matrix[b][a] / fit->matrix[a][a] : 0.0;
            for (int e = a; e < count; e++) fit->matrix[b][e] -= factor * fit->matrix[a][e];
            fit->rhs[b] -= factor * fit->rhs[a];
        }
    for (int a = count - 1; a >= 0; a--) {
        for (int b = a + 1; b < count; b++) fit->rhs[a] -= fit->matrix[a][b] * fit->stress[b];
        fit->stress[a] = fit->matrix[a][a] > 0.0 ? fit->rhs[a] / fit->matrix[a][a] : 0.0;
    }
}

/* [N/m3] Reaction density of condition k, which holds it, on component d of point i. With one side: minus the residual.
 * At edges and corners each side takes its fitted stress times c_a, and all sides the same part of the remainder. Of
 * conditions with a shape, or a side and a shape, the last named takes all, others 0. */
static double pdi_reaction_force_compute_point_force(const pd_mechanical_bc *g, int k, int32_t i, int d)
{
    const pd_setup_mechanics *b = &g->setup->metal_body;
    int holders[PD_DIM], count = pdi_mechanical_bc_find_sides(g, i, d, holders), last = k, at = 0;
    double own = 0.0, rest = 0.0;
    pdi_reaction_force_corner_fit fit;
    for (int other = k + 1; other < b->mechanical_bcs; other++)
        if (b->mechanical_bc[other].has_displacement[d] && pdi_mechanical_bc_is_held(g, other, i)) last = other;
    if (b->mechanical_bc[last].side < 0 || b->mechanical_bc[k].side < 0)
        return last == k ? -pdi_reaction_force_get_residual(g, i, d) : 0.0;
    while (at < count && holders[at] != k) at++;
    if (at == count) return 0.0;
    if (count < 2) return -pdi_reaction_force_get_residual(g, i, d);
    pdi_reaction_force_fit_corner_stress(g, holders, count, i, d, &fit);
    rest = pdi_reaction_force_get_residual(g, i, d);
    for (int a = 0; a < count; a++) {
        double part =
            fit.stress[a] * pdi_mechanical_bc_get_surface_coefficient(g, i, b->mechanical_bc[holders[a]].side);
        if (holders[a] == k) own = part;
        rest -= part;
    }
    return -(own + rest / count);
}

pd_status pd_reaction_force_compute(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t, double *force)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    int64_t count = (int64_t)g->structure->count * PD_DIM;
    double *work = NULL, reaction[PD_DIM];
    pd_status status = PD_OK;
    for (int d = 0; d < PD_DIM; d++) force[d] = reaction[d] = 0.0;
    if (grip->has_traction || grip->has_pressure) {
        PD_TRY(PD_NEW(ctx, "grip_force", count, work));
        status = pdi_reaction_force_compute_applied_load(ctx, g, k, t, work, force);
        PD_DELETE(ctx, count, work);
    }
    for (int64_t n = 0; n < count; n++) {
        int32_t i = (int32_t)(n / PD_DIM);
        int d = (int)(n % PD_DIM);
        if (grip->has_displacement[d] && pdi_mechanical_bc_is_held(g, k, i))
            reaction[d] += g->structure->body.volume[i] * pdi_reaction_force_compute_point_force(g, k, i, d);
    }
    for (int d = 0; d < PD_DIM; d++)
        if (grip->has_displacement[d]) force[d] = reaction[d];
    return status;
}
