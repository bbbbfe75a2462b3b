/* migration: see migration.h */
#include "react/migration.h"
#include "core/par.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Share of the largest sum of z^2 c that psi is scaled with at least, and that the preconditioner conducts with. */
#define PDI_MIGRATION_LEAST 1e-12
/* Steps of Newton for lambda, and the longest. */
#define PDI_MIGRATION_STEPS 100
#define PDI_MIGRATION_LONGEST 2.0
/* [mol/m3/s] What a surface takes up at most in the preconditioner, which is of single precision. */
#define PDI_MIGRATION_HELD 1e18
/* Steps of so many times of diffusion through the box are late ones, and the share of its rate that they are
 * preconditioned with. */
#define PDI_MIGRATION_LATE 3e6
#define PDI_MIGRATION_SLOW 0.01
/* Waves of the box and of the lattice: squares of their numbers. */
#define PDI_MIGRATION_LONGEST_WAVE 10.0
#define PDI_MIGRATION_SHORTEST_WAVE 4.0
/* Roundings of the sum of |z| c that count as neutral. */
#define PDI_MIGRATION_ROUND 2.0

PDI_COLD_BEGIN
PDI_FN pd_status pdi_migration_plan(pd_ctx *ctx, const pd_multigrid_desc *desc, const pd_flux *flux,
                                    const pd_components *components, pd_migration *m)
{
    pd_multigrid_desc md = *desc;
    m->flux = flux;
    m->components = components;
    if (!m->on) return PD_OK;
    md.symmetric = 1;
    md.high_contrast = 1;
    m->excess = pdi_compact_operator_inverse_excess(flux->bonds->stencil);
    pdi_compact_operator_init(flux->bonds->grid, 0, &m->compact);
    return pdi_multigrid_init(ctx, &md, &m->mg);
}

PDI_FN pd_status pdi_migration_begin(pd_ctx *ctx, double temperature, const double *ratio, const double *wall,
                                     pd_migration *m)
{
    if (!m->on) return PD_OK;
    if (!(temperature > 0.0) || !(temperature < 1e4))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "the temperature is %g K, expected a positive one for "
                       "migration", temperature);
    m->volt = PD_GAS_CONSTANT * temperature / PD_FARADAY;
    m->ratio = ratio;
    m->wall = wall;
    for (int n = 0; n < m->components->solutes; n++) m->charge[n] = m->components->charge[n];
    return PD_OK;
}

PDI_FN void pdi_migration_free(pd_ctx *ctx, pd_migration *m) { pdi_multigrid_free(ctx, &m->mg); }

PDI_FN void pdi_migration_list(pdi_array_visitor *owner, pd_migration *migration)
{
    if (!migration->on) return;
    PDI_ARRAY_STATE(owner, migration, psi, (int64_t)migration->flux->bonds->grid->total, "1");
    PDI_ARRAY_STATE(owner, migration, idle, (int64_t)migration->flux->bonds->grid->total, "1");
}

PDI_FN void pdi_migration_work_list(pdi_array_visitor *owner, pd_migration *migration)
{
    if (!migration->on) return;
    int64_t total = migration->flux->bonds->grid->total;
    PDI_ARRAY_UNINIT(owner, migration, begin, total, "1");
    PDI_ARRAY_UNINIT(owner, migration, base, total, "1");
    PDI_ARRAY(owner, migration, move, total, "1");
    PDI_ARRAY(owner, migration, size, total, "mol/m3");
    PDI_ARRAY(owner, migration, current, total, "mol/m3/s");
    pdi_compact_operator_list(owner, &migration->compact);
    pdi_compact_operator_face_list(owner, &migration->compact);
    pdi_multigrid_list(owner, &migration->mg);
}
PDI_COLD_END

/* ---- at a node ---- */

PDI_FN double pdi_migration_charge(const pd_migration *m, const double *c, double *size)
{
    double sum = 0.0;
    *size = 0.0;
    for (int n = 0; n < m->components->solutes; n++) {
        sum += m->charge[n] * c[n];
        *size += fabs(m->charge[n]) * c[n];
    }
    return sum;
}

/* sum z c exp(-z lambda) falls with lambda; its steps are bounded, and past the solution it is steeper. */
PDI_FN void pdi_migration_neutralise(const pd_migration *m, double *c)
{
    for (int step = 0; step < PDI_MIGRATION_STEPS; step++) {
        double size, slope = 0.0, charge = pdi_migration_charge(m, c, &size), lambda;
        if (fabs(charge) <= PDI_MIGRATION_ROUND * DBL_EPSILON * size) return;
        for (int n = 0; n < m->components->solutes; n++) slope += m->charge[n] * m->charge[n] * c[n];
        if (!(slope > DBL_MIN)) return;
        lambda = pd_min(pd_max(charge / slope, -PDI_MIGRATION_LONGEST), PDI_MIGRATION_LONGEST);
        for (int n = 0; n < m->components->solutes; n++)
            if (m->charge[n] != 0.0) c[n] *= exp(-m->charge[n] * lambda);
    }
}

PDI_FN void pdi_migration_along(const pd_migration *m, const double *c, double *along)
{
    const pd_components *s = m->components;
    double size = 0.0;
    for (int k = 0; k < s->count; k++) {
        along[k] = 0.0;
        for (int n = 0; n < s->solutes; n++) along[k] += s->stoichiometry[k][n] * m->charge[n] * c[n];
        size += m->charge[s->component_solute[k]] * along[k];
    }
    if (size > DBL_MIN) {
        for (int k = 0; k < s->count; k++) along[k] /= size;
        return;
    }
    size = 0.0;
    for (int k = 0; k < s->count; k++) size += m->charge[s->component_solute[k]] * m->charge[s->component_solute[k]];
    for (int k = 0; k < s->count; k++) along[k] = size > 0.0 ? m->charge[s->component_solute[k]] / size : 0.0;
}

/* ---- fields ---- */

PDI_FN void pdi_migration_leave(const pd_ctx *ctx, pd_migration *m, const double *c, const double *move,
                                const double *weight, double *y)
{
    pdi_migrate f;
    pd_ghosts_set_scalar(&m->flux->bonds->ghosts, m->psi);
    if (move != c) pd_ghosts_set_scalar(&m->flux->bonds->ghosts, m->move);
    f.flux = m->flux;
    f.count = m->components->solutes;
    f.sums = m->components->count;
    f.ratio = m->ratio;
    f.charge = m->charge;
    f.wall = m->wall;
    f.pass = m->pass;
    f.c = c;
    f.psi = m->psi;
    f.weight = weight;
    f.y = y;
    f.move = move != c ? move : NULL;
    f.lift = move != c ? m->move : NULL;
    pdi_migrate_apply(ctx, &f);
}

PDI_FN void pdi_migration_spread(const pd_ctx *ctx, const pd_migration *m, double *s, double *y)
{
    static const double one = 1.0;
    pd_flux still = *m->flux;
    pdi_flux_fields f;
    double wall = m->tied ? 0.0 : (double)NAN;
    still.flow = NULL;
    still.flux = NULL;
    pd_ghosts_set_scalar(&m->flux->bonds->ghosts, s);
    f.count = f.sums = 1;
    f.ratio = f.weight = &one;
    f.wall = &wall;
    f.pass = m->pass;
    f.c = s;
    f.y = y;
    pdi_flux_apply_fields(ctx, &still, &f);
}

/* Sum of z^2 D c between two nodes, or to what a wall holds (far NULL: the node itself). */
static double pdi_migration_between(const pd_migration *m, const double *c, int32_t i, int32_t j)
{
    int64_t total = m->flux->bonds->grid->total;
    double sum = 0.0, rise = m->psi[j] - m->psi[i];
    for (int n = 0; n < m->components->solutes; n++) {
        double z = m->charge[n], each = m->ratio[n] * z * z;
        if (each > 0.0) sum += each * pdi_migrate_conduct(z * rise, c[n * total + i], c[n * total + j]);
    }
    return sum;
}

/* Faces of the cells, which hold D/h^2, get the ions that they conduct with. */
static void pdi_migration_faces(pd_migration *m, const double *c, double least)
{
    const pd_grid *grid = m->flux->bonds->grid;
    const double *hold = m->flux->diffusion->wall_rate;
    int i[PD_DIM];
    for (int32_t node = 0; node < grid->total; node++) {
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        int64_t cell = pdi_compact_operator_cell_index(grid, i);
        double own = pd_max(pdi_migration_between(m, c, node, node), least);
        for (int d = 0; d < PD_DIM; d++) {
            int32_t next = node + grid->stride[d];
            if (m->compact.conductance[d][cell] > 0.0f)
                m->compact.conductance[d][cell] *= (float)pd_max(pdi_migration_between(m, c, node, next), least);
        }
        m->compact.dirichlet[cell] *= (float)own;
        if (hold) m->compact.mass[cell] += (float)(pd_grid_circumference(grid, node) * hold[node] * own);
    }
}

PDI_FN pd_status pdi_migration_setup(pd_ctx *ctx, pd_migration *m, const double *c,
                                     const pdi_migration_surface *surface)
{
    const pd_grid *grid = m->flux->bonds->grid;
    const pdi_compact_operator_bc faces = {0, 1, 0, NULL}; /* inlets hold a value */
    pdi_compact_operator_convection still;
    double most = 0.0, ratio = HUGE_VAL;
    for (int32_t i = 0; i < grid->total; i++) {
        double sum = 0.0;
        if (grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < m->components->solutes; n++)
            sum += m->charge[n] * m->charge[n] * c[(int64_t)n * grid->total + i];
        m->size[i] = sum;
        most = pd_max(most, sum);
    }
    if (!(most > 0.0)) most = 1.0;
    for (int32_t i = 0; i < grid->total; i++) m->size[i] = pd_max(m->size[i], PDI_MIGRATION_LEAST * most);
    for (int n = 0; n < m->components->solutes; n++)
        if (m->charge[n] != 0.0 && m->ratio[n] > 0.0) ratio = pd_min(ratio, m->ratio[n]);
    memset(&still, 0, sizeof still);
    pdi_compact_operator_assemble(ctx, m->flux->diffusion->desc.diffusivity, NULL, &still, 0.0, &faces, &m->compact);
    pdi_migration_faces(m, c, PDI_MIGRATION_LEAST * most * (ratio < HUGE_VAL ? ratio : 1.0));
    for (int32_t p = 0; p < surface->count; p++) {
        int i[PD_DIM];
        pd_grid_index(grid, surface->node[p], i);
        m->compact.mass[pdi_compact_operator_cell_index(grid, i)] +=
            (float)pd_min(pd_grid_circumference(grid, surface->node[p]) * surface->take[p], PDI_MIGRATION_HELD);
    }
    pd_status status = pdi_multigrid_setup(ctx, &m->mg, m->compact.active, (const float *const *)m->compact.conductance,
                                           NULL, m->compact.dirichlet, m->compact.mass);
    if (status != PD_ERR_ARGUMENT) return status;
    return pd_fail(ctx, PD_ERR_DIVERGED, "migration", "concentrations up to %g mol/m3, D = %g m2/s and h = %g m give "
                   "conductances beyond the range of numbers of the solver: expected those of ions in water", most,
                   m->flux->diffusion->desc.diffusivity, grid->h[0]);
}

PDI_FN void pdi_migration_apply(pd_ctx *ctx, pd_migration *m, const double *current, double *y)
{
    const pd_grid *grid = m->flux->bonds->grid;
    double d = m->flux->diffusion->desc.diffusivity;
    pdi_multigrid_cycle(ctx, &m->mg, current, y);
    if (!(m->excess > 0.0) || !(d > 0.0)) return;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) y[i] += m->excess / (d * m->size[i]) * current[i];
}

PDI_FN double pdi_migration_largest(const pd_migration *m)
{
    const pd_grid *grid = m->flux->bonds->grid;
    double most = 0.0;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) most = pd_max(most, fabs(m->move[i]));
    return most;
}

/* Between the answers for the longest and the shortest waves, the geometric mean. In a closed box what a step of great
 * length moves as a whole is rounding times that length: it is moved less. */
PDI_FN double pdi_migration_pace(pd_migration *m, double dt)
{
    const pd_components *s = m->components;
    const pd_grid *grid = m->flux->bonds->grid;
    double longest = 0.0, shortest = HUGE_VAL, d = m->flux->diffusion->desc.diffusivity * dt;
    for (int axis = 0; axis < PD_DIM; axis++) {
        longest = pd_max(longest, grid->hi[axis] - grid->lo[axis]);
        shortest = pd_min(shortest, grid->h[axis]);
    }
    double slow = PDI_MIGRATION_LONGEST_WAVE * d / (longest * longest);
    double fast = PDI_MIGRATION_SHORTEST_WAVE * d / (shortest * shortest);
    for (int k = 0; k < s->count; k++) {
        double sum = 0.0, count = 0.0;
        for (int n = 0; n < s->solutes; n++) {
            if (s->stoichiometry[k][n] == 0.0 || !(m->ratio[n] > 0.0)) continue;
            sum += log(m->ratio[n]);
            count += 1.0;
        }
        double ratio = count > 0.0 ? exp(sum / count) : 1.0;
        m->pace[k] = sqrt((1.0 + slow) / (1.0 + slow * ratio) * (1.0 + fast) / (1.0 + fast * ratio));
    }
    return slow > PDI_MIGRATION_LATE ? PDI_MIGRATION_SLOW * slow / dt : 1.0 / dt;
}

PDI_FN void pdi_migration_inlets(pd_migration *m, double phi)
{
    const pd_grid *grid = m->flux->bonds->grid;
    for (int32_t i = 0; i < grid->total && m->on; i++)
        if (grid->kind[i] == PD_INLET) m->psi[i] = phi / m->volt;
}

PDI_FN void pdi_migration_tie(pd_migration *m)
{
    const pd_grid *grid = m->flux->bonds->grid;
    int holds = 0;
    m->tied = 0;
    for (int n = 0; n < m->components->solutes; n++)
        holds = holds || (m->charge[n] != 0.0 && m->wall[n] == m->wall[n]);
    for (int32_t i = 0; i < grid->total && holds && m->flux->diffusion->wall_rate && !m->tied; i++)
        m->tied = m->flux->diffusion->wall_rate[i] > 0.0;
    for (int32_t p = 0; p < m->flux->boundary->count * m->flux->bonds->stencil->count && !m->tied; p++)
        m->tied = grid->kind[m->flux->boundary->far_end[p]] == PD_INLET;
}

PDI_FN void pdi_migration_level(pd_migration *m)
{
    const pd_grid *grid = m->flux->bonds->grid;
    pdi_compensated_sum sum = {0.0, 0.0};
    int32_t count = 0;
    if (m->tied) return;
    for (int32_t i = 0; i < grid->total; i++) {
        if (grid->kind[i] != PD_FLUID) continue;
        pdi_compensated_sum_add(&sum, m->psi[i]);
        count++;
    }
    for (int32_t i = 0; i < grid->total && count; i++)
        if (grid->kind[i] == PD_FLUID) m->psi[i] -= pdi_compensated_sum_total(&sum) / count;
}
