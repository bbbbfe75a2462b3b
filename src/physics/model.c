/* model: see model.h */
#include "physics/model.h"
#include "setup/fields.h"
#include <math.h>
#include <string.h>

/* Stencil of the peridynamic family with horizon m cells on the spacing of the setup. */
static pd_status pdi_model_build_stencil(pd_ctx *ctx, const pd_setup *setup, double m, pd_stencil *stencil)
{
    pd_stencil_desc family;
    memset(&family, 0, sizeof family);
    family.m = m;
    if (setup->has_corrode) family.weights = setup->weights;
    for (int d = 0; d < PD_DIM; d++) family.h[d] = setup->h[d];
    return pd_stencil_build(ctx, &family, stencil);
}

pd_status pd_model_build_grid(pd_ctx *ctx, const pd_setup *setup, int *line, pd_stencil *stencil, pd_grid *grid)
{
    pd_grid_desc box;
    memset(&box, 0, sizeof box);
    box.ghost = pd_setup_count_ghost_layers(setup);
    for (int d = 0; d < PD_DIM; d++) {
        box.lo[d] = setup->lo[d];
        box.hi[d] = setup->hi[d];
    }
    for (int s = 0; s < 2 * PD_DIM; s++) box.side[s] = setup->side[s].kind;
    box.shapes = setup->shapes ? setup->shape : NULL;
    box.axisymmetric = setup->axisymmetric;
    if (setup->solid >= 0) box.solid = &setup->shape[setup->solid];
    if (setup->wall >= 0) box.wall = &setup->shape[setup->wall];
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (setup->side[s].is_open) box.is_inlet = pdi_inlet_is_inflow;
    box.is_inlet_user = (void *)setup; /* only read */
    PD_TRY(pdi_model_build_stencil(ctx, setup, setup->fluid_m, stencil));
    if (setup->shape_line) *line = setup->shape_line; /* what the lattice refuses are shapes */
    return pd_grid_build(ctx, stencil, &box, grid);
}

/* Allocate m->metal [total] and set the index of the metal of each solid node: the last of the metals from the second
 * on whose shape holds it, else 0. Other nodes get 0. */
static pd_status pdi_model_mark_metals(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    PD_TRY(PD_NEW(ctx, "model", m->grid.total, m->metal));
    for (int32_t i = 0; i < m->grid.total; i++) {
        double x[PD_DIM];
        if (m->grid.kind[i] != PD_SOLID) continue;
        pd_grid_position(&m->grid, i, x);
        for (int k = 1; k < u->metals; k++)
            if (pdi_shape_contains(u->shape, u->metal[k].shape, u->h, x)) m->metal[i] = (uint8_t)k;
    }
    return PD_OK;
}

/* Build grid, bonds, bonds across surfaces (only if something needs surfaces), metal of nodes (only with several
 * metals) and inlets; error_line becomes that of the side measured last. */
static pd_status pdi_model_build_lattice(pd_ctx *ctx, pd_model *m)
{
    PD_TRY(pd_model_build_grid(ctx, m->setup, &m->error_line, &m->stencil, &m->grid));
    PD_TRY(pd_bonds_build(ctx, &m->stencil, &m->grid, pdi_setup_get_bond_options(m->setup), &m->bonds));
    if (pdi_setup_has_surface_area(m->setup)) {
        PD_TRY(pdi_model_build_stencil(ctx, m->setup, m->setup->metal_m, &m->interface_stencil));
        PD_TRY(pdi_bond_path_build(ctx, &m->interface_stencil, &m->grid, &m->paths));
    }
    if (m->setup->metals > 1) PD_TRY(pdi_model_mark_metals(ctx, m));
    pd_status status = pdi_inlet_build(ctx, m->setup, &m->grid, &m->inlet);
    m->error_line = m->setup->side[m->inlet.error_side].line;
    return status;
}

/* Build a part of the model and add its memory to m->bytes. error_line is set to the line of its section first. */
static pd_status pdi_model_build_part(pd_ctx *ctx, pd_model *m, pd_part part, pd_status (*build)(pd_ctx *, pd_model *))
{
    size_t before = ctx->in_use;
    m->error_line = m->setup->line[part];
    PD_TRY(build(ctx, m));
    m->bytes[part] += ctx->in_use - before;
    return PD_OK;
}

/* Build the lattice and all physics that the setup has, in order; then connect these in order. */
static pd_status pdi_model_build_parts(pd_ctx *ctx, pd_model *m)
{
    PD_TRY(pdi_model_build_part(ctx, m, PD_PART_GRID, pdi_model_build_lattice));
    for (int connects = 0; connects < 2; connects++)
        for (int k = 0; k < m->physics->count; k++) {
            const pdi_physics_row *row = &m->physics->row[k];
            pd_status (*build)(pd_ctx *, pd_model *) = connects ? row->connect : row->build;
            if (build) PD_TRY(pdi_model_build_part(ctx, m, row->part, build));
        }
    return PD_OK;
}

void pd_model_get_statistics(const pd_model *m, pd_model_statistics *e)
{
    memset(e, 0, sizeof *e);
    for (int k = 0; k < m->physics->count; k++) {
        const pdi_physics_row *row = &m->physics->row[k];
        if (row->add_statistics) row->add_statistics(m, e);
    }
}

/* Add all solvers to the time loop, in the order of a step. */
static pd_status pdi_model_add_processes(pd_ctx *ctx, pd_model *m)
{
    for (int stage = 0; stage < PDI_PHYSICS_STAGE_COUNT; stage++)
        for (int k = 0; k < m->physics->count; k++) {
            const pdi_physics_row *row = &m->physics->row[k];
            if (!row->add_processes) continue;
            pdi_physics_stage own = row->get_stage ? row->get_stage(m) : row->stage;
            if ((int)own == stage) PD_TRY(row->add_processes(ctx, m));
        }
    return PD_OK;
}

/* 1: bonds have to be updated after metal has dissolved: there are probes or monitors, or a physics of the model reads
 * them. */
static int pdi_model_needs_bond_updates(const pd_model *m)
{
    const pd_setup *u = m->setup;
    int reads = u->probes || u->monitors;
    for (int k = 0; k < m->physics->count; k++) {
        const pdi_physics_row *row = &m->physics->row[k];
        reads |= row->reads_bonds && row->reads_bonds(u);
    }
    return reads;
}

/* Set m->sampler of each field to that of the first present physics with the field; NULL: none has it. */
static void pdi_model_set_samplers(pd_model *m)
{
    for (int k = m->physics->count - 1; k >= 0; k--) {
        const pdi_physics_row *row = &m->physics->row[k];
        for (int s = 0; s < row->samplers; s++)
            for (int f = (int)row->sampler[s].first; f <= (int)row->sampler[s].last && f < PD_FIELD_COUNT; f++)
                if (!row->sampler[s].has || row->sampler[s].has(m->setup, (pd_field)f))
                    m->sampler[f] = &row->sampler[s];
    }
}

const double *pd_model_velocity(const pd_model *m)
{
    for (int k = 0; k < m->physics->count; k++) {
        const pdi_physics_row *row = &m->physics->row[k];
        if (row->velocity) return row->velocity(m);
    }
    return NULL;
}

PDI_FN double pdi_model_compute_speed(const pd_model *m, const double *velocity, int32_t node)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double v = velocity[(int64_t)d * m->grid.total + node];
        square += v * v;
    }
    return sqrt(square);
}

PDI_FN void pdi_model_set_registered_variables(const void *model, int32_t node, double *vars)
{
    const pd_model *m = (const pd_model *)model;
    int first = pd_fields_first_registered(m->setup);
    for (int k = 0; k < PD_PHYSICS_TYPE_FIELDS; k++) {
        const pdi_physics_sampler *sampler = first + k < PD_FIELD_COUNT ? m->sampler[first + k] : NULL;
        vars[PD_SETUP_RATE_FIELD + k] = sampler ? sampler->sample(m, (pd_field)(first + k), node) : 0.0;
    }
}

int pd_model_is_undefined(const pd_model *m, pd_field field, int32_t i)
{
    int dissolved = field == PD_FIELD_PH || field == PD_FIELD_SATURATION_INDEX ||
                    field == PD_FIELD_DIFFUSION_POTENTIAL || pd_fields_species_index(m->setup, field) >= 0;
    if (field == PD_FIELD_C) dissolved = !m->setup->has_corrode;
    return m->just_converted && m->just_converted[i] && dissolved && m->grid.kind[i] == PD_FLUID;
}

pd_status pd_model_build(pd_ctx *ctx, const pd_setup *setup, pd_model *m)
{
    pd_time_loop_desc desc;
    memset(m, 0, sizeof *m);
    memset(&desc, 0, sizeof desc);
    PD_TRY(PD_NEW(ctx, "model", 1, m->physics));
    m->setup = setup;
    pdi_physics_list_init_present(setup, m->physics);
    pdi_model_set_samplers(m);
    desc.fraction = setup->max_node_fraction;
    desc.max_step = setup->max_step;
    pd_status status = pdi_model_build_parts(ctx, m);
    if (status == PD_OK) status = pdi_input_step_limit_build(ctx, setup, &m->input_step_limit);
    if (m->input_step_limit.count) desc.next_event = pdi_input_step_limit_compute;
    desc.next_event_user = &m->input_step_limit;
    pd_bonds *bonds = pdi_model_needs_bond_updates(m) ? &m->bonds : NULL;
    if (status == PD_OK) status = pd_time_loop_build(ctx, &desc, &m->grid, bonds, &m->time_loop);
    if (status == PD_OK && setup->has_dissolve && (!setup->has_corrode || setup->has_chemistry))
        status = PD_NEW(ctx, "model", m->grid.total, m->just_converted);
    m->time_loop.new_fluid = m->just_converted;
    if (status == PD_OK) status = pdi_model_add_processes(ctx, m);
    int line = m->error_line;
    if (status < 0) pd_model_free(ctx, m);
    m->error_line = line;
    return status;
}

void pd_model_free(pd_ctx *ctx, pd_model *m)
{
    for (int k = m->physics ? m->physics->count : 0; k-- > 0;)
        if (m->physics->row[k].free) m->physics->row[k].free(ctx, m);
    PD_DELETE(ctx, 1, m->physics);
    PD_DELETE(ctx, m->grid.total, m->just_converted);
    PD_DELETE(ctx, m->grid.total, m->metal);
    pdi_input_step_limit_free(ctx, &m->input_step_limit);
    pd_arena_free(ctx, &m->arena);
    pdi_inlet_free(ctx, &m->inlet);
    pdi_bond_path_free(ctx, &m->paths);
    pd_stencil_free(ctx, &m->interface_stencil);
    pd_bonds_free(ctx, &m->bonds);
    pd_grid_free(ctx, &m->grid);
    pd_stencil_free(ctx, &m->stencil);
    memset(m, 0, sizeof *m);
}
