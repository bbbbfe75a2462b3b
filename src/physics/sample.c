/* sample: see sample.h */
#include "physics/sample.h"
#include "setup/fields.h"
#include "core/vec.h"
#include "metal/interface.h"
#include "flow/near_wall.h"
#include "lattice/surface.h"
#include "lattice/quadratic_fit.h"
#include "lattice/reconstruct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [cells] within this distance of a face a point touches the cells on both sides */
#define PDI_SAMPLE_FACE_TOLERANCE 1e-6
#define PDI_SAMPLE_MAX_CELLS (1 << PD_DIM)                              /* cells that a point may touch */
#define PDI_SAMPLE_BLOCK_CELLS (PD_DIM == 1 ? 3 : PD_DIM == 2 ? 9 : 27) /* a cell and its neighbours */
/* [cells] within this distance a place lies on a smooth surface, else on a cell face */
#define PDI_SAMPLE_SURFACE_TOLERANCE 1e-3

/* Mass density [kg/m3] of a node: of a solid node, that of its metal times the fraction that is left in the cell; of
 * others, that of flow or gas; 0 where there is neither. */
static double pdi_sample_get_node_density(const pd_model *m, int32_t i)
{
    const pdi_physics_sampler *moving = m->sampler[PD_FIELD_DENSITY];
    if (m->grid.kind[i] == PD_SOLID) {
        const pd_setup_metal *metal = &m->setup->metal[m->metal ? m->metal[i] : 0];
        return metal->material.density * (m->setup->has_dissolve ? m->transport.c[i] / metal->solid_c : 1.0);
    }
    return moving ? moving->sample(m, PD_FIELD_DENSITY, i) : 0.0;
}

double pd_sample_get_node(const pd_model *m, pd_field field, int32_t i)
{
    if (pd_model_is_undefined(m, field, i)) return (double)NAN;
    if (field == PD_FIELD_KIND) return m->grid.kind[i];
    if (field == PD_FIELD_PHASE) return m->grid.kind[i] == PD_SOLID;
    if (field == PD_FIELD_DENSITY) return pdi_sample_get_node_density(m, i);
    return m->sampler[field] ? m->sampler[field]->sample(m, field, i) : 0.0;
}

void pd_sample_prepare(pd_ctx *ctx, pd_model *m, pd_fields fields)
{
    for (int k = 0; k < m->physics->count; k++) {
        const pdi_physics_row *row = &m->physics->row[k];
        if (row->prepare_samples) row->prepare_samples(ctx, m, fields);
    }
}

/* Nodes of the cells that x [m] touches, within 1e-6 cells of a face on both sides, into node [PDI_SAMPLE_MAX_CELLS];
 * returns their number, 1 to 2^PD_DIM. Places outside count to the nearest cell of the box. The last is the upper
 * one. */
static int pdi_sample_find_cells(const pd_grid *grid, const double *x, int32_t *node)
{
    int i[PD_DIM][2], choices[PD_DIM], at[PD_DIM], count = 1;
    for (int d = 0; d < PD_DIM; d++) {
        double place = (x[d] - grid->lo[d]) / grid->h[d];
        int low = (int)floor(place - PDI_SAMPLE_FACE_TOLERANCE), high = (int)floor(place + PDI_SAMPLE_FACE_TOLERANCE);
        i[d][0] = low < 0 ? 0 : low >= grid->n[d] ? grid->n[d] - 1 : low;
        i[d][1] = high < 0 ? 0 : high >= grid->n[d] ? grid->n[d] - 1 : high;
        choices[d] = i[d][1] > i[d][0] ? 2 : 1;
        count *= choices[d];
    }
    for (int k = 0; k < count; k++) {
        int rest = k;
        for (int d = 0; d < PD_DIM; d++) {
            at[d] = i[d][rest % choices[d]];
            rest /= choices[d];
        }
        node[k] = pd_grid_node(grid, at);
    }
    return count;
}

/* Multilinear interpolation at x [m] between the fluid nodes around that have a value, with weights that are divided by
 * their sum; NaN: there are none. f [total], or NULL: node values of the field. Used without bonds, for a gas,
 * potentials and pH. */
static double pdi_sample_interpolate_linear(const pd_model *m, pd_field field, const double *f, const double *x)
{
    const pd_grid *grid = &m->grid;
    double sum = 0.0, weights = 0.0;
    for (int corner = 0; corner < PDI_SAMPLE_MAX_CELLS; corner++) {
        double weight = 1.0;
        int i[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            double place = (x[d] - grid->lo[d]) / grid->h[d] - 0.5, low = floor(place);
            int up = (corner >> d) & 1;
            i[d] = (int)low + up;
            weight *= up ? place - low : 1.0 - (place - low);
        }
        if (!pd_grid_is_inside(grid, i)) continue;
        int32_t node = pd_grid_node(grid, i);
        if (grid->kind[node] != PD_FLUID || pd_model_is_undefined(m, field, node)) continue;
        sum += weight * (f ? f[node] : pd_sample_get_node(m, field, node));
        weights += weight;
    }
    return sum / weights;
}

/* ---- beside walls: a quadratic through nodes and surfaces ---- */

/* One interpolation: field, point and the quadratic fit. */
typedef struct pdi_sample_point_query {
    const pd_model *m;
    pd_field field;
    int component;
    const double *values;
    double x[PD_DIM]; /* [m] */
    /* sign: side of the medium's surface that x lies on; only values of that side count; 0: none */
    double medium_side;
    pdi_quadratic_fit fit;
} pdi_sample_point_query;

/* 1: the field is a concentration. */
static int pdi_sample_is_concentration(const pd_model *m, pd_field field)
{
    return field == PD_FIELD_C || pd_fields_species_index(m->setup, field) >= 0;
}

/* Signed distance [m] of x from the surface of the medium, negative inside; 0: there is no medium, or x lies on its
 * surface. */
static double pdi_sample_compute_medium_distance(const pd_model *m, const double *x)
{
    if (m->setup->medium < 0) return 0.0;
    double level = pdi_grid_signed_distance(&m->grid, m->setup->medium, x);
    return fabs(level) > PDI_SAMPLE_FACE_TOLERANCE * pdi_vec_min(m->grid.h) ? level : 0.0;
}

/* 1: the surface normal at a place is known: it is along an axis, as of one cell face, or the place lies within 1e-3
 * cells of the surface of the closed node; 0: as at cell edges. */
static int pdi_sample_is_normal_known(const pd_model *m, const double *place, const double *normal, int32_t closed)
{
    for (int d = 0; d < PD_DIM; d++)
        if (fabs(normal[d]) > 1.0 - PDI_SAMPLE_FACE_TOLERANCE) return 1;
    return fabs(pdi_bond_surface_distance(&m->bonds, closed, place)) <
           PDI_SAMPLE_SURFACE_TOLERANCE * pdi_vec_min(m->grid.h);
}

/* Add boundary conditions of a surface at `place` to the fit. Velocity: that of the wall, 0 at rest. Concentrations:
 * the prescribed value where there is one (C alone), else a zero normal gradient where the normal is known; metal of a
 * scene with dissolution gives none, and places on the other side of the medium's surface are skipped. closed: node
 * behind the surface. */
static void pdi_sample_add_surface_condition(pdi_sample_point_query *job, const double *place, const double *normal,
                                             int32_t closed)
{
    const pd_model *m = job->m;
    double at[PD_DIM], u[PD_DIM], held = (double)NAN;
    memcpy(at, place, sizeof at);
    pdi_grid_fold_position(&m->grid, at);
    if (job->field == PD_FIELD_V) {
        for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
        if (m->flow.wall) m->flow.wall(m->flow.wall_user, at, u);
        pdi_quadratic_fit_add_value(&job->fit, place, u[job->component]);
    }
    if (!pdi_sample_is_concentration(job->m, job->field) ||
        pdi_sample_compute_medium_distance(m, place) * job->medium_side < 0.0)
        return;
    if (job->field == PD_FIELD_C && m->transport.desc.held) held = m->transport.desc.held(m->transport.desc.user, at);
    if (held >= 0.0) pdi_quadratic_fit_add_value(&job->fit, place, held);
    else if ((!m->setup->has_dissolve || m->grid.kind[closed] != PD_SOLID) &&
             pdi_sample_is_normal_known(m, place, normal, closed))
        pdi_quadratic_fit_add_derivative(&job->fit, place, normal, 0.0);
}

/* Add the value at the other end of open bond k of node `base`; nothing where that node was just converted to fluid, or
 * lies on the other side of the medium's surface. An inlet ghost has the inflow concentration at any depth: its value
 * is put on the side, as the operators see it. */
static void pdi_sample_add_neighbour_value(pdi_sample_point_query *job, int32_t base, int k)
{
    const pd_model *m = job->m;
    const pd_stencil *s = m->bonds.stencil;
    int32_t far = base + m->bonds.paths.shift[k];
    double at[PD_DIM], place[PD_DIM], share = 1.0;
    if (pd_model_is_undefined(m, job->field, pd_grid_find_source(&m->grid, far, NULL))) return;
    int i[PD_DIM], inlet = m->grid.kind[far] == PD_INLET;
    pd_grid_position(&m->grid, base, at);
    pd_grid_index(&m->grid, base, i);
    for (int d = 0; d < PD_DIM && inlet && pdi_sample_is_concentration(job->m, job->field); d++) {
        int step = s->offset[k * PD_DIM + d], upper = step > 0;
        double inside = upper ? m->grid.n[d] - i[d] - 0.5 : i[d] + 0.5;
        if (step && pd_grid_is_inlet_or_outlet(m->grid.side[2 * d + upper]))
            share = pd_min(share, inside / abs(step));
    }
    for (int d = 0; d < PD_DIM; d++) place[d] = at[d] + share * s->xi[k * PD_DIM + d];
    if (pdi_sample_compute_medium_distance(m, place) * job->medium_side < 0.0) return;
    pdi_quadratic_fit_add_value(&job->fit, place, job->values[far]);
}

/* Add the values of node `base`, of its neighbours by open bonds, and conditions of surfaces that its other bonds
 * cross. Bonds longer than PDI_QUADRATIC_FIT_MAX_SQUARE [cell^2] and values beyond the medium's surface are left
 * out. */
static void pdi_sample_add_get_nodes(pdi_sample_point_query *job, int32_t base)
{
    const pd_bonds *bonds = &job->m->bonds;
    const pd_stencil *s = bonds->stencil;
    int32_t row = bonds->row_of_node[base];
    double place[PD_DIM], normal[PD_DIM];
    pd_grid_position(bonds->grid, base, place);
    if (!(pdi_sample_compute_medium_distance(job->m, place) * job->medium_side < 0.0))
        pdi_quadratic_fit_add_value(&job->fit, place, job->values[base]);
    for (int k = 0; k < s->count; k++) {
        int square = 0;
        for (int d = 0; d < PD_DIM; d++) square += s->offset[k * PD_DIM + d] * s->offset[k * PD_DIM + d];
        if (square > PDI_QUADRATIC_FIT_MAX_SQUARE) continue;
        if (row < 0 || pdi_bond_is_open(bonds, row, k)) pdi_sample_add_neighbour_value(job, base, k);
        else {
            int32_t closed = pdi_bond_find_surface_point(bonds, row, k, place, normal);
            if (closed >= 0) pdi_sample_add_surface_condition(job, place, normal, closed);
        }
    }
}

/* Start the fit around the point, and add the condition of the surface next to it; a point behind that surface moves
 * onto it, in job->x. */
static void pdi_sample_add_nearest_surface(pdi_sample_point_query *job, int32_t base)
{
    double place[PD_DIM], normal[PD_DIM];
    int32_t closed;
    int found = pdi_surface_find_nearest(&job->m->bonds, base, job->x, place, normal, &closed);
    if (found < 0) memcpy(job->x, place, sizeof place);
    pdi_quadratic_fit_init(&job->fit, job->x, job->m->grid.h);
    if (found) pdi_sample_add_surface_condition(job, place, normal, closed);
}

/* Value at x [m], or on the surface that x lies behind, of the quadratic fit around fluid node `base`, as of
 * job->values. Pressure: kinematic of a liquid, with its wall-normal slope. Sets the point, the side of the medium (C
 * alone; on its surface that of base) and the fit of the job. */
static double pdi_sample_fit_quadratic(pdi_sample_point_query *job, int32_t base, const double *x)
{
    memcpy(job->x, x, sizeof job->x);
    pdi_quadratic_fit_init(&job->fit, x, job->m->grid.h);
    job->medium_side = 0.0;
    if (job->field == PD_FIELD_C && job->m->setup->medium >= 0) {
        double at[PD_DIM];
        pd_grid_position(&job->m->grid, base, at);
        job->medium_side = pdi_sample_compute_medium_distance(job->m, job->x);
        if (!(fabs(job->medium_side) > 0.0)) job->medium_side = pdi_sample_compute_medium_distance(job->m, at);
        if (!(fabs(job->medium_side) > 0.0)) job->medium_side = 1.0;
    }
    pdi_sample_add_nearest_surface(job, base);
    if (job->field == PD_FIELD_P)
        return pdi_near_wall_interpolate_pressure(&job->m->bonds, job->m->setup->has_gas ? NULL : &job->m->flow,
                                                  job->values, base, job->x);
    pdi_sample_add_get_nodes(job, base);
    return pdi_quadratic_fit_solve(&job->fit);
}

/* Fluid nodes that values at x [m] are computed from: of the cells that x touches, or, if all these are closed and x
 * lies on or before a smooth surface within 1e-6 cells, the nearest fluid ones among the neighbours, several if equally
 * near. Returns their number; 0: none, as deep in solid, or without bonds. */
static int pdi_sample_find_fluid_nodes(const pd_model *m, const double *x, int32_t *node)
{
    int cells = pdi_sample_find_cells(&m->grid, x, node), fluid = 0, i[PD_DIM], at[PD_DIM];
    double nearest = HUGE_VAL;
    int32_t own = node[0];
    for (int k = 0; k < cells; k++)
        if (m->grid.kind[node[k]] == PD_FLUID) node[fluid++] = node[k];
    if (fluid || !m->bonds.grid) return fluid;
    if (!(pdi_bond_surface_distance(&m->bonds, own, x) >= -PDI_SAMPLE_FACE_TOLERANCE * pdi_vec_min(m->grid.h)))
        return 0;
    pd_grid_index(&m->grid, own, i);
    for (int k = 0; k < PDI_SAMPLE_BLOCK_CELLS; k++) {
        double square = 0.0, place[PD_DIM];
        int rest = k;
        for (int d = 0; d < PD_DIM; d++) {
            at[d] = i[d] + rest % 3 - 1;
            rest /= 3;
        }
        int32_t j = pd_grid_node(&m->grid, at);
        if (!pd_grid_is_inside(&m->grid, at) || m->grid.kind[j] != PD_FLUID) continue;
        pd_grid_position(&m->grid, j, place);
        for (int d = 0; d < PD_DIM; d++) {
            double way = (place[d] - x[d]) / m->grid.h[d];
            square += way * way;
        }
        if (square < nearest * (1.0 - PDI_SAMPLE_FACE_TOLERANCE)) fluid = 0;
        if (square > nearest * (1.0 + PDI_SAMPLE_FACE_TOLERANCE)) continue;
        if (fluid == 0) nearest = square;
        if (fluid < PDI_SAMPLE_MAX_CELLS) node[fluid++] = j;
    }
    return fluid;
}

/* 1: a field of surfaces (current density, rate, surface state), which the fluid cells beside them hold. */
static int pdi_sample_is_surface_field(const pd_model *m, pd_field field)
{
    return field == PD_FIELD_CURRENT_METAL || field == PD_FIELD_RATE ||
           pd_fields_state_index(m->setup, field) >= 0;
}

/* Arithmetic mean of a surface field over those of the given cells whose value is not NaN; NaN: none has one. */
static double pdi_sample_average_cells(const pd_model *m, pd_field field, int cells, const int32_t *node)
{
    double sum = 0.0;
    int count = 0;
    for (int k = 0; k < cells; k++) {
        double value = pd_sample_get_node(m, field, node[k]);
        if (!(value == value)) continue;
        sum += value;
        count++;
    }
    return count ? sum / count : (double)NAN;
}

double pd_sample_get_point(const pd_model *m, pd_field field, int component, const double *x)
{
    int32_t node[PDI_SAMPLE_MAX_CELLS];
    pdi_sample_point_query job;
    double sum = 0.0;
    if (field == PD_FIELD_PHI && m->dissolution_laws.species_electrodes.setup) field = PD_FIELD_DIFFUSION_POTENTIAL;
    job.m = m;
    job.field = field;
    job.component = component;
    job.values = NULL;
    if (m->sampler[field] && m->sampler[field]->get_values)
        job.values = m->sampler[field]->get_values(m, field, component);
    if (!job.values && field != PD_FIELD_PH && field != PD_FIELD_DIFFUSION_POTENTIAL) {
        int cells = pdi_sample_find_cells(&m->grid, x, node);
        if (pdi_sample_is_surface_field(m, field)) return pdi_sample_average_cells(m, field, cells, node);
        return pd_sample_get_node(m, field, node[cells - 1]);
    }
    int fluid = pdi_sample_find_fluid_nodes(m, x, node);
    for (int k = fluid; k-- > 0;)
        if (pd_model_is_undefined(m, field, node[k])) node[k] = node[--fluid];
    /* a gas has jumps, and slips along walls */
    if (fluid && (m->setup->has_gas || !job.values || field == PD_FIELD_PHI))
        return pdi_sample_interpolate_linear(m, field, job.values, x);
    for (int k = 0; k < fluid; k++)
        sum += m->bonds.grid ? pdi_sample_fit_quadratic(&job, node[k], x)
                             : pdi_sample_interpolate_linear(m, field, job.values, x);
    if (!fluid) return (double)NAN;
    return (field == PD_FIELD_P ? m->flow.rho : 1.0) * sum / fluid;
}

double pd_sample_get_probe(const pd_model *m, pd_field field, int component, const double *x)
{
    double value = pd_sample_get_point(m, field, component, x);
    int32_t node[PDI_SAMPLE_MAX_CELLS];
    int cells = value == value || !m->just_converted ? 0 : pdi_sample_find_cells(&m->grid, x, node);
    for (int k = 0; k < cells; k++)
        if (pd_model_is_undefined(m, field, node[k])) return value;
    return value == value || pdi_sample_is_surface_field(m, field) ? value : 0.0;
}

int pd_sample_is_inside(const pd_model *m, const double *x)
{
    int32_t node[PDI_SAMPLE_MAX_CELLS];
    int cells = pdi_sample_find_cells(&m->grid, x, node);
    for (int k = 0; k < cells; k++)
        if (m->grid.kind[node[k]] == PD_SOLID) return 1;
    return pdi_sample_find_fluid_nodes(m, x, node) > 0;
}

#undef PDI_SAMPLE_FACE_TOLERANCE
#undef PDI_SAMPLE_MAX_CELLS
#undef PDI_SAMPLE_BLOCK_CELLS
#undef PDI_SAMPLE_SURFACE_TOLERANCE
