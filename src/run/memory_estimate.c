/* memory_estimate: see memory_estimate.h */
#include "run/memory_estimate.h"
#include "scene/fields.h"
#include "io/renderer.h"
#include "flow/gas.h"
#include "flow/implicit.h"
#include "flow/weakly_compressible.h"
#include "metal/dissolve.h"
#include "metal/interface.h"
#include "io/field_plot.h"
#include "run/mechanical_bc.h"
#include "run/inlet.h"
#include "run/surface_states.h"
#include "run/wall_bc.h"
#include "solid/bond_extension.h"
#include "transport/two_stage.h"
#include "react/course.h"
#include "potential/cell.h"
#include <math.h>
#include <string.h>

/* Sample points of the geometry along an axis, at most. */
#define PDI_MEMORY_ESTIMATE_SAMPLE_POINTS (PD_DIM == 1 ? 2000 : PD_DIM == 2 ? 100 : 28)
/* [byte] A plot: pixels, filtered rows, the compressed file and the state of the compressor. */
#define PDI_MEMORY_ESTIMATE_PLOT_BYTES 5.7e6
/* [byte] The state of the compressor alone. */
#define PDI_MEMORY_ESTIMATE_DEFLATE_BYTES 0.65e6
/* [byte] What does not grow with the lattice: tables of a run, small matrices of the solvers, the stencil. */
#define PDI_MEMORY_ESTIMATE_FIXED_BYTES 0.22e6
/* Additional Krylov vectors that transport without flow allocates during a run. */
#define PDI_MEMORY_ESTIMATE_KRYLOV_VECTORS 3.0
/* Lattices with more nodes are planned with fewer layers and scaled up, so that numbers fit into an int32. */
#define PDI_MEMORY_ESTIMATE_MAX_PLANNED_NODES 1e8

/* Bonds of a complete family with horizon m cells: offsets with 0 < |n| < m + 1/2. */
static double pdi_memory_estimate_count_bonds(double m)
{
    int reach = (int)ceil(m + 0.5) - 1, n[3] = {0, 0, 0};
    double bonds = -1.0;
    for (n[2] = PD_DIM > 2 ? -reach : 0; n[2] <= (PD_DIM > 2 ? reach : 0); n[2]++)
        for (n[1] = PD_DIM > 1 ? -reach : 0; n[1] <= (PD_DIM > 1 ? reach : 0); n[1]++)
            for (n[0] = -reach; n[0] <= reach; n[0]++)
                bonds += n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < (m + 0.5) * (m + 0.5);
    return bonds;
}

/* 1: x lies within near_to cells of a wall or inlet side, where its family is truncated. */
static int pdi_memory_estimate_is_near_closed_side(const pd_setup *setup, const double *x, double near_to)
{
    for (int d = 0; d < PD_DIM; d++)
        for (int end = 0; end < 2; end++) {
            pd_side kind = setup->side[2 * d + end].kind;
            double away = end ? setup->hi[d] - x[d] : x[d] - setup->lo[d];
            if ((kind == PD_SIDE_WALL || kind == PD_SIDE_INLET) && away < near_to * setup->h[d]) return 1;
        }
    return 0;
}

/* [m] Signed distance of x from metal and walls, negative within them. */
static double pdi_memory_estimate_compute_distance(const pd_setup *setup, const double *x)
{
    double away = HUGE_VAL;
    if (setup->wall >= 0) away = pd_shape_distance(setup->shape, setup->wall, x);
    if (setup->solid >= 0) away = pdi_min(away, pd_shape_distance(setup->shape, setup->solid, x));
    return away;
}

/* 1: the family of fluid place x, at distance `away` [m] from metal and walls, is truncated by them: by the distance,
 * or, with unequal spacings, by steps along the axes. */
static int pdi_memory_estimate_is_truncated(const pd_setup *setup, const double *x, double away, double reach)
{
    double least = setup->h[0], most = setup->h[0];
    for (int d = 1; d < PD_DIM; d++) {
        least = pdi_min(least, setup->h[d]);
        most = pdi_max(most, setup->h[d]);
    }
    if (!(away < reach * most)) return 0;
    for (int step = -(int)reach; step <= (int)reach && most > least; step++)
        for (int d = 0; d < PD_DIM; d++) {
            double at[PD_DIM];
            for (int a = 0; a < PD_DIM; a++) at[a] = x[a] + (a == d ? step * setup->h[a] : 0.0);
            if (pdi_memory_estimate_compute_distance(setup, at) < 0.0) return 1;
        }
    return !(most > least);
}

/* Estimate the numbers of fluid, solid, truncated and medium nodes on a regular sample of the box. reach: of a family
 * [cells]. */
static void pdi_memory_estimate_nodes(const pd_setup *u, double reach, pd_memory_estimate *b)
{
    int count[3] = {1, 1, 1}, i[3];
    double points = 1.0, step = 0.0, fluid = 0.0, solid = 0.0, cut = 0.0, near = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = (u->hi[d] - u->lo[d]) / u->h[d];
        count[d] = cells < PDI_MEMORY_ESTIMATE_SAMPLE_POINTS ? (int)(cells + 0.5) : PDI_MEMORY_ESTIMATE_SAMPLE_POINTS;
        if (count[d] < 1) count[d] = 1;
        points *= count[d];
        step = pdi_max(step, u->h[d]);
    }
    for (i[2] = 0; i[2] < count[2]; i[2]++)
        for (i[1] = 0; i[1] < count[1]; i[1]++)
            for (i[0] = 0; i[0] < count[0]; i[0]++) {
                double x[PD_DIM];
                for (int d = 0; d < PD_DIM; d++) x[d] = u->lo[d] + (i[d] + 0.5) * (u->hi[d] - u->lo[d]) / count[d];
                if (u->medium >= 0) near += fabs(pd_shape_distance(u->shape, u->medium, x)) < (u->fluid_m + 0.5) * step;
                if (u->wall >= 0 && pd_shape_distance(u->shape, u->wall, x) < 0.0) continue;
                double away = pdi_memory_estimate_compute_distance(u, x);
                solid += away < 0.0;
                fluid += !(away < 0.0);
                cut += !(away < 0.0) && (pdi_memory_estimate_is_truncated(u, x, away, reach) ||
                                         pdi_memory_estimate_is_near_closed_side(u, x, reach));
            }
    b->fluid = b->cells * fluid / points;
    b->solid = b->cells * solid / points;
    b->truncated = b->cells * cut / points;
    b->near_medium = b->cells * near / points;
}

/* Objects of a run that are not built: only the sizes that their array lists read are set. */
typedef struct pdi_memory_estimate_plan {
    pd_ctx ctx;
    pd_stencil stencil, across;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    double scratch_bytes, level_bytes; /* [byte] shared by solvers: scratch memory, and coarse levels of multigrids */
    double node_scale;                 /* [-] nodes of the run over nodes of the planned grid */
} pdi_memory_estimate_plan;

/* Placeholder for functions of a scene, which are not called. */
static double pdi_memory_estimate_get_placeholder(void *user, const double *x)
{
    (void)user;
    return x[0];
}

/* Set the sizes of grid, stencils and bonds in the plan. */
static void pdi_memory_estimate_init_plan(const pd_setup *setup, const pd_memory_estimate *b,
                                          pdi_memory_estimate_plan *plan)
{
    pd_grid *grid = &plan->grid;
    double nodes = b->nodes;
    int reach = pdi_setup_count_ghost_layers(setup);
    memset(plan, 0, sizeof *plan);
    pd_ctx_init(&plan->ctx);
    grid->ghost = reach;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        double cells = floor((setup->hi[d] - setup->lo[d]) / setup->h[d] + 0.5), fewer = cells;
        if (nodes > PDI_MEMORY_ESTIMATE_MAX_PLANNED_NODES)
            fewer = pdi_max(floor(cells * PDI_MEMORY_ESTIMATE_MAX_PLANNED_NODES / nodes), 1.0);
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
    plan->across.count = (int)pdi_memory_estimate_count_bonds(setup->metal_m);
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

/* [byte] Memory of the arrays that `list` describes for a planned object. */
static double pdi_memory_estimate_count_array_bytes(const pdi_memory_estimate_plan *plan, pdi_array_list_fn list,
                                                    void *object)
{
    return plan->node_scale * (double)pdi_array_registry_count_bytes(list, object);
}

/* [byte] Memory of the coarser levels of a multigrid, a geometric series over the finest one. */
static double pdi_memory_estimate_count_level_bytes(const pdi_memory_estimate_plan *plan, const pd_multigrid *mg)
{
    double contrast = mg->desc.high_contrast ? 1.0 : 0.0;
    double link = mg->desc.symmetric ? 12.0 : 16.0;
    double cell = 4.0 + (4.0 * (4.0 + contrast) + 16.0 + 8.0 * contrast + link * 2 * PD_DIM) / ((1 << PD_DIM) - 1);
    return plan->node_scale * cell * mg->level[0].cells;
}

/* Add the memory of multigrid levels beyond what another solver, which is not used at the same time, already has. */
static void pdi_memory_estimate_add_shared_levels(pdi_memory_estimate_plan *plan, double levels, pd_memory_estimate *b)
{
    double more = pdi_max(levels - plan->level_bytes, 0.0);
    plan->level_bytes += more;
    b->runtime_bytes += more;
}

/* [byte] Growth of the shared scratch memory for a solver that needs `room` bytes of the planned grid. */
static double pdi_memory_estimate_add_scratch(pdi_memory_estimate_plan *plan, size_t room)
{
    double more = pdi_max(plan->node_scale * (double)room - plan->scratch_bytes, 0.0);
    plan->scratch_bytes += more;
    return more;
}

/* [byte] Memory of a Krylov solver. */
static double pdi_memory_estimate_krylov(pdi_memory_estimate_plan *plan, const pd_krylov_desc *desc)
{
    pd_krylov krylov;
    pdi_krylov_init(&plan->ctx, desc, &krylov);
    return pdi_memory_estimate_count_array_bytes(plan, pdi_krylov_list, &krylov);
}

/* Add the memory of grid, stencils, ghosts and rows of bonds; surfaces: with bonds across surfaces. */
static void pdi_memory_estimate_grid(int surfaces, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    b->bytes[PD_PART_GRID] = b->nodes + b->bonds * (70.0 + 12.0 * PD_DIM); /* kinds; the stencil */
    if (pdi_grid_has_images(&plan->grid)) b->bytes[PD_PART_GRID] += 4.0 * b->nodes; /* what nodes repeat */
    if (surfaces) b->bytes[PD_PART_GRID] += plan->across.count * (70.0 + 12.0 * PD_DIM);
    b->bytes[PD_PART_GRID] += 8.0 * b->nodes + 10.0 * (b->nodes - b->cells); /* rows of nodes, versions; ghosts */
    b->bytes[PD_PART_GRID] += pdi_memory_estimate_count_array_bytes(plan, pdi_bond_list_row_arrays, &plan->bonds);
}

/* [byte] Memory of the implicit flow solver (steady or in time): Jacobian, multigrids, scratch. */
static double pdi_memory_estimate_flow_solver(const pd_setup *setup, pdi_memory_estimate_plan *plan,
                                              pd_memory_estimate *b)
{
    pd_steady steady;
    pd_implicit implicit;
    memset(&steady, 0, sizeof steady);
    memset(&implicit, 0, sizeof implicit);
    steady.flow = implicit.flow = &plan->flow;
    steady.solves_stages = setup->flow_time == PD_FLOW_IMPLICIT;
    pdi_steady_plan(&plan->ctx, &steady);
    double bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_steady_list, &steady);
    bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_jacobian_list, &steady.jacobian);
    pdi_memory_estimate_add_shared_levels(plan,
                                          pdi_memory_estimate_count_level_bytes(plan, &steady.mg_u) +
                                              (steady.solves_stages ? 3.0 : 2.0) *
                                                  pdi_memory_estimate_count_level_bytes(plan, &steady.mg_p),
                                          b);
    size_t room = pdi_steady_count_work_bytes(&steady);
    if (steady.solves_stages) {
        bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_implicit_list, &implicit);
        room += pdi_implicit_count_work_bytes(&implicit);
    }
    return bytes + pdi_memory_estimate_add_scratch(plan, room);
}

/* Order of the flow discretisation, 4 where the run will use it or may, else 2. */
static int pdi_memory_estimate_get_flow_order(const pd_setup *setup, const pd_grid *grid)
{
    if (setup->flow_order) return setup->flow_order;
    if (setup->fluid_m > 1.0 || setup->axisymmetric || setup->shapes || setup->flow_time != PD_FLOW_STEADY) return 2;
    return pdi_fourth_order_has_closed_sides(grid->side) ? 4 : 2;
}

/* Add the memory of the incompressible flow. */
static void pdi_memory_estimate_flow(const pd_setup *u, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_FLOW];
    pd_weakly_compressible unsteady;
    pd_fourth_order sharp;
    if (!u->has_flow) return;
    memset(&unsteady, 0, sizeof unsteady);
    unsteady.flow = &plan->flow;
    memset(&sharp, 0, sizeof sharp);
    sharp.bonds = plan->flow.bonds;
    plan->flow.order = pdi_memory_estimate_get_flow_order(u, &plan->grid);
    if (plan->flow.order == 4) *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_fourth_order_list, &sharp);
    if (pdi_wall_bc_has_motion(u)) plan->flow.wall = pdi_wall_bc_get_velocity;
    if (u->has_body_force_expr) plan->flow.body_force_fn = pdi_inlet_compute_body_force;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_flow_list, &plan->flow);
    if (u->flow_time == PD_FLOW_STEADY || u->flow_time == PD_FLOW_IMPLICIT)
        *bytes += pdi_memory_estimate_flow_solver(u, plan, b);
    if (u->flow_time == PD_FLOW_EXPLICIT)
        *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_weakly_compressible_list, &unsteady);
}

/* Add the memory of the gas. */
static void pdi_memory_estimate_gas(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    pd_gas gas;
    if (!setup->has_gas) return;
    memset(&gas, 0, sizeof gas);
    gas.grid = &plan->grid;
    gas.rows = (int32_t)(b->truncated / plan->node_scale);
    gas.desc.spatial_order = setup->gas_order;
    b->bytes[PD_PART_GAS] = pdi_memory_estimate_count_array_bytes(plan, pdi_gas_list, &gas);
}

/* Add the memory of transport. */
static void pdi_memory_estimate_transport(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_TRANSPORT];
    int medium = setup->medium >= 0;
    pd_transport t;
    pd_two_stage two_stage;
    if (!setup->has_transport) return;
    memset(&t, 0, sizeof t);
    memset(&two_stage, 0, sizeof two_stage);
    t.grid = &plan->grid;
    t.bonds = t.flux.bonds = t.limiter.bonds = t.diffusion.bonds = &plan->bonds;
    t.desc.advection = setup->advection;
    if (setup->has_flow) t.flow = t.flux.flow = &plan->flow;
    if (medium) t.desc.field = t.diffusion.media.surface_distance = pdi_memory_estimate_get_placeholder;
    t.desc.given = setup->has_corrode && setup->activation && !setup->has_flow;
    if (t.desc.given) {
        *bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_transport_list, &t);
        return;
    }
    if (pdi_wall_bc_has_concentration(setup)) t.diffusion.desc.held = pdi_memory_estimate_get_placeholder;
    t.diffusion.desc.smooth = !pdi_transport_limits(&t);
    t.diffusion.media.grid = &plan->grid;
    t.diffusion.media.stencil = &plan->stencil;
    t.diffusion.media.rows = (int32_t)(b->near_medium / plan->node_scale);
    t.flux.conductance.bonds = &plan->bonds;
    t.flux.conductance.capacity = plan->bonds.capacity;
    t.flux.conductance.rests = pdi_transport_rests(&t);
    two_stage.transport = &t;
    pdi_transport_plan(&plan->ctx, &t);
    *bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_transport_list, &t);
    *bytes += pdi_memory_estimate_add_scratch(plan, pdi_transport_room(&t));
    if (!setup->has_flow)
        b->runtime_bytes += PDI_MEMORY_ESTIMATE_KRYLOV_VECTORS * 2.0 * (medium ? 8.0 : 4.0) * plan->node_scale *
                            (double)t.krylov.length;
    t.diffusion.capacity = plan->bonds.capacity;
    t.diffusion.metals = plan->grid.solid_count > 0;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_list, &t.diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_place_list, &t.diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_conductance_list, &t.flux.conductance);
    if (medium)
        *bytes +=
            pdi_memory_estimate_count_array_bytes(plan, pdi_bond_diffusivity_list_node_arrays, &t.diffusion.media);
    if (medium)
        *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_bond_diffusivity_list_row_arrays, &t.diffusion.media);
    if (!setup->has_dissolve) *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_two_stage_list, &two_stage);
    pdi_memory_estimate_add_shared_levels(plan, pdi_memory_estimate_count_level_bytes(plan, &t.inverse.mg), b);
}

/* [byte] Memory of surface states. */
static double pdi_memory_estimate_surface_states(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_reactive *r)
{
    pd_coat coat;
    memset(&coat, 0, sizeof coat);
    if (!setup->states) return 0.0;
    coat.reactive = r;
    pdi_surface_states_set_desc(setup, r, &coat.desc);
    pdi_coat_columns(&coat);
    return pdi_memory_estimate_count_array_bytes(plan, pdi_coat_list, &coat);
}

/* Add the memory of the species: reactive transport, surface solver, time integrator, surface states. */
static void pdi_memory_estimate_species(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_CHEMISTRY];
    pd_reactive_filter filter[PD_REACTION_MAX + PD_MINERAL_MAX];
    pd_krylov_desc kd;
    pd_reactive r;
    pd_course course;
    pd_etch etch;
    pd_coat coat;
    double mark = 0.0;
    if (!setup->has_chemistry) return;
    memset(&r, 0, sizeof r);
    memset(&course, 0, sizeof course);
    memset(filter, 0, sizeof filter);
    pdi_setup_get_reactive_desc(setup, &r.desc);
    if (pdi_reactive_system(&plan->ctx, &r.desc, &r) < 0) return; /* the model says why */
    r.grid = &plan->grid;
    r.bonds = r.flux.bonds = r.diffusion.bonds = &plan->bonds;
    if (setup->has_flow) r.flow = r.flux.flow = &plan->flow;
    r.flux.conductance.bonds = &plan->bonds;
    r.flux.conductance.capacity = plan->bonds.capacity;
    r.flux.conductance.rests = !setup->has_flow;
    r.migration.on = setup->has_migration;
    r.migration.flux = &r.flux;
    r.filter = filter;
    pdi_reactive_slots(&r);
    pdi_reactive_plan(&plan->ctx, &r, &kd);
    *bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_reactive_list, &r);
    *bytes += pdi_memory_estimate_add_scratch(plan, pdi_reactive_room(&r));
    for (int side = 0; side < 2 * PD_DIM; side++)
        if (setup->side[side].has_fixed_species) r.diffusion.desc.held = pdi_memory_estimate_get_placeholder;
    r.diffusion.desc.smooth = 1;
    r.diffusion.capacity = plan->bonds.capacity;
    r.diffusion.metals = plan->grid.solid_count > 0;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_list, &r.diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_place_list, &r.diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_conductance_list, &r.flux.conductance);
    course.reactive = &r;
    course.desc.settle = setup->steady_transport;
    memset(&etch, 0, sizeof etch);
    if (pdi_setup_find_species_rate_metal(setup) >= 0 || pdi_setup_has_ion_electrodes(setup)) {
        etch.reactive = &r;
        etch.kinds = pdi_setup_count_species_rate_metals(setup);
        etch.desc.solid = pdi_setup_find_species_rate_metal(setup) >= 0 && setup->metals == 1 ? 1.0 : 0.0;
        if (pdi_setup_has_ion_electrodes(setup)) {
            etch.desc.electrodes.count = setup->potential.electrodes;
            etch.desc.electrodes.circuits = setup->potential.electrodes;
            for (int e = 0; e < setup->potential.electrodes; e++)
                etch.desc.electrodes.shares |= setup->potential.electrode[e].has_current_factor;
        }
        course.desc.surface = &etch;
        *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_etch_list, &etch);
    }
    course.desc.fed = setup->has_surface_reaction ? &mark : NULL;
    if (setup->shielding_thickness > 0.0 && setup->minerals && setup->has_dissolve) {
        course.desc.bare = &mark;
        b->bytes[PD_PART_DISSOLVE] += (double)plan->grid.total * sizeof(double);
    }
    *bytes += pdi_memory_estimate_surface_states(setup, plan, &r);
    if (setup->states) course.desc.coat = &coat;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_course_list, &course);
    pdi_memory_estimate_add_shared_levels(
        plan, (1.0 + r.filters) * pdi_memory_estimate_count_level_bytes(plan, &r.inverse.mg), b);
}

/* Placeholder for the conductivity callback. */
static void pdi_memory_estimate_set_placeholder(void *user, double *field)
{
    (void)user;
    (void)field;
}

/* Add the memory of the potential solver. */
static void pdi_memory_estimate_potential(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    const pd_setup_potential *e = &setup->potential;
    double *bytes = &b->bytes[PD_PART_POTENTIAL];
    pd_dissolve dissolve;
    pd_cell cell;
    size_t room = 0;
    if (!setup->has_potential) return;
    memset(&cell, 0, sizeof cell);
    memset(&dissolve, 0, sizeof dissolve);
    pd_potential *p = &cell.potential;
    cell.grid = p->grid = &plan->grid;
    if (setup->has_dissolve) cell.dissolve = &dissolve;
    if (!(e->conductivity > 0.0)) cell.desc.conduct = pdi_memory_estimate_set_placeholder;
    cell.desc.potential.electrodes = e->electrodes;
    for (int k = 0; k < e->electrodes; k++) p->desc.circuits += e->electrode[k].circuit == k;
    for (int k = 0; k < e->electrodes; k++)
        p->floating += e->electrode[k].circuit == k && !e->electrode[k].has_fixed_potential;
    cell.desc.potential.circuits = p->desc.circuits;
    p->bonds = p->flux.bonds = p->diffusion.bonds = &plan->bonds;
    p->flux.conductance.bonds = &plan->bonds;
    p->flux.conductance.capacity = p->diffusion.capacity = plan->bonds.capacity;
    p->flux.diffusion = &p->diffusion;
    p->diffusion.metals = plan->grid.solid_count > 0;
    p->diffusion.desc.smooth = 1;
    /* a contact for each fluid node beside metal, which has at least the surface of a cube */
    double shell = pdi_min(2.0 * PD_DIM * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->fluid);
    p->contacts.count = (int32_t)(shell / plan->node_scale);
    *bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_cell_list, &cell) +
             pdi_memory_estimate_count_array_bytes(plan, pdi_distribution_list, p);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_distribution_contact_list, p) +
              shell * (double)sizeof *p->contacts.list;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_list, &p->diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_diffusion_place_list, &p->diffusion);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_conductance_list, &p->flux.conductance);
    p->diffusion.media.grid = &plan->grid;
    p->diffusion.media.stencil = &plan->stencil;
    if (cell.desc.conduct)
        *bytes +=
            pdi_memory_estimate_count_array_bytes(plan, pdi_bond_diffusivity_list_node_arrays, &p->diffusion.media);
    if (pdi_distribution_plan(&plan->ctx, p, &room) >= 0) *bytes += plan->node_scale * (double)room;
    b->runtime_bytes += pdi_memory_estimate_count_level_bytes(plan, &p->inverse.mg);
}

/* Add the memory of grains and of the dissolution. */
static void pdi_memory_estimate_dissolution(const pd_setup *setup, const pdi_memory_estimate_plan *plan,
                                            pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_DISSOLVE];
    pd_dissolve d;
    if (setup->has_grains) b->bytes[PD_PART_GRAIN] = 12.0 * b->nodes; /* and shares, which do not stay: 4 */
    if (setup->metals > 1) *bytes += b->nodes;
    if (!setup->has_dissolve) return;
    /* fluid within a horizon of metal, which has at least the surface of a cube */
    double shell = pdi_min(2.0 * PD_DIM * setup->metal_m * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->fluid);
    memset(&d, 0, sizeof d);
    d.grid = (pd_grid *)&plan->grid; /* only read */
    d.paths.words = (plan->across.count + 31) / 32;
    d.kinds = setup->metals;
    d.capacity = (int32_t)plan->grid.solid_count;
    d.beside_capacity = (int32_t)(1.25 * shell / plan->node_scale); /* there is room for more */
    d.kernel.stencil = &plan->across;
    d.desc.model = setup->has_corrode ? PD_METAL_BONDS : PD_METAL_SURFACE;
    d.desc.activation = setup->activation;
    d.desc.sheds = setup->has_surface_reaction ? 1 + (pdi_setup_count_species_rate_metals(setup) > 1) : 0;
    d.desc.stochastic = setup->stochastic;
    d.desc.repassivation = setup->repassivation;
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_dissolve_list, &d) +
              pdi_memory_estimate_count_array_bytes(plan, pdi_reach_beside_list, &d);
    if (setup->has_corrode) {
        /* metal within a horizon of fluid; there is room for more */
        double layers = pdi_min(2.0 * PD_DIM * setup->metal_m * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->solid);
        d.reach_rows = (int32_t)(1.25 * layers / plan->node_scale);
        *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_front_list, &d.kernel);
        *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_reach_list, &d);
    }
    if (setup->passive >= 0) *bytes += b->nodes;
}

/* [byte] Work memory of the mechanical equilibrium solver. */
static double pdi_memory_estimate_equilibrium(const pd_setup *setup, pdi_memory_estimate_plan *plan,
                                              pd_solid_coupling *s)
{
    pd_material_interface solid = pdi_solid_coupling_material_interface(s);
    pd_multipoint_constraint follows;
    pd_equilibrium_desc desc;
    pdi_equilibrium q;
    double m = setup->metal_body.m;
    memset(&q, 0, sizeof q);
    memset(&desc, 0, sizeof desc);
    follows.count = 0;
    for (int k = 0; k < setup->metal_body.mechanical_bcs; k++)
        for (int d = 0; d < PD_DIM && setup->metal_body.mechanical_bc[k].side >= 0; d++)
            follows.count += setup->metal_body.mechanical_bc[k].has_displacement[d];
    desc.interpolation = &follows;
    q.solid = &solid;
    q.desc = &desc;
    q.n = s->static_solver.n;
    pd_krylov_desc kd = pdi_equilibrium_krylov_options(follows.count > 0);
    kd.n = q.n;
    return pdi_memory_estimate_krylov(plan, &kd) +
           pdi_memory_estimate_count_array_bytes(plan, pdi_equilibrium_list, &q) +
           (solid.moduli ? plan->node_scale * pdi_coarse_fe_precond_estimate_bytes(s->count, m + 0.5) : 0.0);
}

/* [byte] Memory of bond weights; share: fraction of points with weights of their own (truncated families). */
static double pdi_memory_estimate_bond_weights(const pdi_memory_estimate_plan *plan, const pd_solid_coupling *s,
                                               double share)
{
    pd_bond_weights weights;
    memset(&weights, 0, sizeof weights);
    weights.body = &s->body;
    weights.listed = s->body.lattice && share > 0.0 ? s->count : 0;
    weights.capacity = s->body.lattice ? (int64_t)(share * (double)s->body.bonds) : s->body.bonds;
    return pdi_memory_estimate_count_array_bytes(plan, pdi_bond_weights_list, &weights);
}

/* Fraction of the points of a box within two horizons m [cells] of its sides along the first `axes` axes: their bonds
 * have correction factors. */
static double pdi_memory_estimate_boundary_fraction(const pdi_memory_estimate_plan *plan, double m, int axes)
{
    double inside = 1.0;
    for (int d = 0; d < axes; d++) inside *= pdi_max(0.0, 1.0 - 4.0 * m / (double)plan->grid.n[d]);
    return 1.0 - inside;
}

/* [byte] Memory of batches of points (bands) as long as lattice rows, and of their bonds with `more` bytes each. */
static double pdi_memory_estimate_batches(const pdi_memory_estimate_plan *plan, const pd_solid_coupling *s,
                                          int32_t fields, double more)
{
    double most = pdi_min((double)PD_POINT_BATCH_MAX, (double)plan->grid.n[0]), bonds = (double)s->body.bonds / most;
    pd_point_batch band;
    memset(&band, 0, sizeof band);
    band.body = &s->body;
    band.fields = fields;
    band.stride = s->count;
    more += (double)sizeof *band.bond;
    return pdi_memory_estimate_count_array_bytes(plan, pdi_point_batch_list, &band) +
           1.25 * plan->node_scale * bonds * more;
}

/* [byte] Memory of the material model of the metal. */
static double pdi_memory_estimate_material(const pdi_memory_estimate_plan *plan, pd_solid_coupling *s)
{
    int flows = pdi_solid_coupling_is_plastic(s);
    /* in no band */
    double of = (double)sizeof *s->bond_based.springs.bond_kind,
           alone = pdi_memory_estimate_boundary_fraction(plan, s->desc.horizon_ratio, 1);
    switch (s->desc.material) {
    case PD_SOLID_COUPLING_BOND_BASED:
        return pdi_memory_estimate_batches(plan, s, PDI_POINT_BATCH_STIFFNESS, of) +
               alone * plan->node_scale * (double)s->body.bonds * ((double)sizeof *s->elastic.band.bond + of) +
               pdi_memory_estimate_bond_weights(
                   plan, s, pdi_memory_estimate_boundary_fraction(plan, s->desc.horizon_ratio, PD_DIM)) +
               pdi_memory_estimate_count_array_bytes(plan, pdi_microelastic_list, &s->bond_based);
    case PD_SOLID_COUPLING_ORDINARY_STATE:
        return pdi_memory_estimate_batches(plan, s, PDI_BOND_EXTENSION_FIELDS, 0.0) +
               pdi_memory_estimate_count_array_bytes(plan, pdi_ordinary_state_list, &s->ordinary) +
               pdi_memory_estimate_bond_weights(plan, s, 0.0);
    case PD_SOLID_COUPLING_NEO_HOOKEAN:
    case PD_SOLID_COUPLING_HENCKY:
        return pdi_memory_estimate_count_array_bytes(plan, pdi_finite_strain_list, &s->finite) +
               pdi_memory_estimate_bond_weights(plan, s, 0.0);
    case PD_SOLID_COUPLING_CORRESPONDENCE: break;
    }
    return pdi_memory_estimate_batches(plan, s, flows ? PDI_POINT_BATCH_FIELDS : PDI_POINT_BATCH_PLASTIC_STRESS, 0.0) +
           pdi_memory_estimate_bond_weights(plan, s, 0.0) +
           pdi_memory_estimate_count_array_bytes(plan, pdi_correspondence_list, &s->elastic) +
           pdi_memory_estimate_count_array_bytes(plan, pdi_j2_plasticity_list, &s->elastic.plastic);
}

/* Set the sizes of the bond table of a body on the lattice; it has no more entries than the box. */
static void pdi_memory_estimate_set_bond_table(const pd_setup *setup, const pdi_memory_estimate_plan *plan,
                                               pd_body *body)
{
    double bonds = pdi_memory_estimate_count_bonds(setup->metal_body.m), n[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) n[d] = (double)plan->grid.n[d];
    body->shifts = body->stencil_bonds = (int32_t)bonds;
    body->bonds = (int64_t)(bonds * (double)body->count);
    double places = pdi_body_count_table_entries(n, floor(setup->metal_body.m + 0.5));
    body->lattice = places + (double)body->count <= 2.0 * (double)body->bonds;
    body->table_entries = body->lattice ? (int64_t)places : body->bonds;
}

/* [byte] Memory of the interpolation rows of prescribed displacements: two horizons of metal at each such side. */
static double pdi_memory_estimate_interpolation(const pd_setup *setup, const pdi_memory_estimate_plan *plan)
{
    double rows = 2.0 * (ceil(setup->metal_body.m + 0.5) - 1.0), led = 0.0;
    pd_mechanical_bc grips;
    memset(&grips, 0, sizeof grips);
    for (int k = 0; k < setup->metal_body.mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &setup->metal_body.mechanical_bc[k];
        double share = grip->side >= 0 ? pdi_min(1.0, rows / plan->grid.n[grip->side / 2]) : 0.0;
        for (int d = 0; d < PD_DIM; d++)
            if (grip->has_displacement[d]) led += (double)plan->grid.solid_count * share;
    }
    grips.interpolation_capacity = (int64_t)led;
    return pdi_memory_estimate_count_array_bytes(plan, pdi_mechanical_bc_list, &grips);
}

/* Add the memory of the mechanics of the metal. */
static void pdi_memory_estimate_solid(const pd_setup *setup, pdi_memory_estimate_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_SOLID];
    pd_solid_coupling s;
    if (!setup->has_solid) return;
    memset(&s, 0, sizeof s);
    s.count = s.body.count = (int32_t)plan->grid.solid_count;
    s.total = plan->grid.total;
    pdi_memory_estimate_set_bond_table(setup, plan, &s.body);
    s.desc.material = setup->metal_body.material;
    s.desc.horizon_ratio = setup->metal_body.m;
    s.desc.density = setup->metal_body.density;
    s.desc.elastic.yield = setup->metal_body.yield;
    pdi_solid_coupling_attach_material(&s);
    s.dynamic_solver.solid.body = &s.body;
    s.static_solver.n = (int64_t)s.count * PD_DIM;
    if (setup->metal_body.has_rate_factor) s.desc.rate_factor = pdi_mechanical_bc_compute_rate_factor;
    *bytes = pdi_memory_estimate_count_array_bytes(plan, pdi_solid_coupling_list, &s) +
             pdi_memory_estimate_count_array_bytes(plan, pdi_body_list_state, &s.body);
    if (!pdi_solid_coupling_is_dynamic(&s)) *bytes += pdi_memory_estimate_interpolation(setup, plan);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_body_list_points, &s.body);
    *bytes += pdi_memory_estimate_count_array_bytes(plan, pdi_body_list_families, &s.body);
    *bytes += pdi_memory_estimate_material(plan, &s);
    *bytes += pdi_solid_coupling_is_dynamic(&s)
                  ? pdi_memory_estimate_count_array_bytes(plan, pdi_verlet_list, &s.dynamic_solver)
                  : pdi_memory_estimate_count_array_bytes(plan, pdi_quasi_static_list, &s.static_solver);
    if (!pdi_solid_coupling_is_dynamic(&s)) b->equilibrium_bytes = pdi_memory_estimate_equilibrium(setup, plan, &s);
}

/* Pixels along an axis for a field of `cells`, about `wanted`; cells are merged beyond `largest`. */
static double pdi_memory_estimate_count_pixels(double cells, double wanted, double largest)
{
    double each = pdi_max(1.0, floor(wanted / cells + 0.5));
    return cells > largest ? cells / ceil(cells / largest) : pdi_max(cells * each, 120.0);
}

/* [byte] Memory of the rendered metal surface in 3D, its mesh taken as large as the surface of the box. */
static double pdi_memory_estimate_surface_view(const pd_setup *setup)
{
    pd_rendering s;
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0}, faces = 0.0;
    if (PD_DIM < 3 || !setup->drawing.surface) return 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM;
        lo[d] = setup->lo[d];
        hi[d] = setup->hi[d];
        faces += 2.0 * (setup->hi[d] - setup->lo[d]) / setup->h[d] * (setup->hi[e] - setup->lo[e]) / setup->h[e];
    }
    pdi_renderer_init_view(lo, hi, setup->drawing.view_direction,
                           setup->drawing.width ? setup->drawing.width : PD_FIELD_PLOT_WIDTH, &s);
    double pixels = (double)s.width * s.height, image = 6.0 * (s.width + 140.0) * (s.height + 110.0);
    double sorted = setup->drawing.percentile > 0.0 && setup->drawing.percentile < 1.0 ? 8.0 * pixels : 0.0;
    return 7.0 * pixels + sorted + pdi_max(20.0 * pixels + 330.0 * faces, image + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES);
}

/* [byte] Memory of the largest picture; they are drawn one by one. */
static double pdi_memory_estimate_pictures(const pd_setup *u)
{
    int right = u->slice_axis == 0 && PD_DIM == 3 ? 1 : 0, up = u->slice_axis == 2 || PD_DIM < 3 ? 1 : 2;
    int lines = 0, flows = 0, plots = u->has_dissolve || (PD_DIM == 1 && u->images);
    double largest = 0.0, across = 0.0;
    for (int k = 0; k < u->monitors; k++) {
        const pd_setup_monitor *m = &u->monitor[k];
        plots = plots || (m->kind == PD_MONITOR_LINE && m->images) || (m->kind == PD_MONITOR_TRANSFER && m->axis >= 0);
    }
    if (plots) largest = PDI_MEMORY_ESTIMATE_PLOT_BYTES;
    largest = pdi_max(largest, pdi_memory_estimate_surface_view(u));
    if (PD_DIM == 1 || !u->images) return largest;
    double lx = u->hi[right] - u->lo[right], ly = u->hi[up] - u->lo[up];
    if (u->axisymmetric && !(u->lo[up] > 0.0)) ly *= 2.0; /* both halves are drawn */
    double wanted = u->drawing.width ? u->drawing.width : PD_FIELD_PLOT_WIDTH, cells = lx / u->h[right] * ly / u->h[up];
    double scale = pdi_min(wanted / lx, PD_FIELD_PLOT_MAX_ASPECT * wanted / ly);
    double width = pdi_memory_estimate_count_pixels(lx / u->h[right], scale * lx, 1.4 * wanted) + 230.0;
    double height = pdi_memory_estimate_count_pixels(ly / u->h[up], scale * ly, 1.4 * wanted) + 140.0;
    double all = 6.0 * width * height + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES;
    if (u->displacement_scale > 0.0) { /* drawn on paper of its own, which is gone as the image is packed */
        double pixels = scale * lx * scale * ly;
        width = scale * lx + 230.0;
        height = scale * ly + 140.0;
        all = pdi_max(3.0 * width * height + 9.0 * pixels, 6.0 * width * height + PDI_MEMORY_ESTIMATE_DEFLATE_BYTES);
        all += 17.0 * cells;
    }
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        lines = lines || u->drawing.contours[k];
        flows = flows || u->drawing.streamlines[k] || u->drawing.vectors[k];
        across = pdi_max(across, u->drawing.streamlines[k]);
    }
    if (flows) all = pdi_max(all, 4.0 * width * height) + 16.0 * cells;
    /* points of streamlines, 12 of 80 bytes over the distance between lines */
    all = pdi_max(all, 4.0 * width * height + 1000.0 * width * height * pow(across / wanted, 2.0));
    /* cover of a pixel, place on the bar of a cell */
    if (lines) all = pdi_max(all, 4.0 * width * height + 8.0 * cells);
    if (u->drawing.percentile > 0.0 && u->drawing.percentile < 1.0) all += 8.0 * cells;
    return pdi_max(largest, all) + 9.0 * cells;
}

/* Add the memory of output: copies of fields, and the largest picture. */
static void pdi_memory_estimate_output(const pd_setup *setup, pd_memory_estimate *b)
{
    double copies = 0.0;
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (((setup->fields >> k) & 1u) && (k == PD_FIELD_U || pdi_fields_is_scalar((pd_field)k)))
            copies += k == PD_FIELD_U ? 8.0 * PD_DIM : 8.0;
    b->output_bytes = copies * b->nodes + pdi_memory_estimate_pictures(setup);
}

void pd_memory_estimate_compute(const pd_setup *u, pd_memory_estimate *b)
{
    pdi_memory_estimate_plan plan;
    double reach = ceil(u->fluid_m + 0.5) - 1.0, layers = pdi_setup_count_ghost_layers(u);
    memset(b, 0, sizeof *b);
    b->nodes = b->cells = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = floor((u->hi[d] - u->lo[d]) / u->h[d] + 0.5);
        b->cells *= cells;
        b->nodes *= cells + 2.0 * layers;
    }
    b->bonds = pdi_memory_estimate_count_bonds(u->fluid_m);
    pdi_memory_estimate_nodes(u, reach, b);
    pdi_memory_estimate_init_plan(u, b, &plan);
    pdi_memory_estimate_grid(pdi_setup_has_surface_area(u), &plan, b);
    pdi_memory_estimate_flow(u, &plan, b);
    pdi_memory_estimate_gas(u, &plan, b);
    pdi_memory_estimate_transport(u, &plan, b);
    pdi_memory_estimate_species(u, &plan, b);
    pdi_memory_estimate_potential(u, &plan, b);
    pdi_memory_estimate_dissolution(u, &plan, b);
    pdi_memory_estimate_solid(u, &plan, b);
    pdi_memory_estimate_output(u, b);
    b->total_bytes = PDI_MEMORY_ESTIMATE_FIXED_BYTES + b->runtime_bytes +
                     pdi_max(b->output_bytes, b->equilibrium_bytes) + PD_SHAPE_MAX * (double)sizeof *u->shape;
    for (int k = 0; k < u->masks; k++) b->total_bytes += (double)u->mask_size[k];
    for (int k = 0; k < u->facets_count; k++) b->total_bytes += (double)pdi_facets_bytes(u->facets[k]);
    for (int k = 0; k < PD_PART_COUNT; k++) b->total_bytes += b->bytes[k];
}

PDI_FN pd_status pdi_memory_estimate_check_limit(pd_ctx *ctx, const pd_setup *setup, int dry)
{
    pd_memory_estimate b;
    pd_memory_estimate_compute(setup, &b);
    if (dry) b.total_bytes -= pdi_max(b.output_bytes - b.equilibrium_bytes, 0.0);
    if (!(b.nodes <= (double)INT32_MAX))
        return pdi_fail(ctx, PD_ERR_SIZE, "grid", "the lattice has %.3g nodes, at most %.3g are possible", b.nodes,
                        (double)INT32_MAX);
    double sure = (b.total_bytes - PDI_MEMORY_ESTIMATE_FIXED_BYTES) / (1.0 + PD_MEMORY_ESTIMATE_ERROR);
    if (ctx->alloc.limit && sure > (double)ctx->alloc.limit)
        return pdi_fail(ctx, PD_ERR_LIMIT, "memory", "the run needs about %.3g MB, the limit is %.3g MB",
                        b.total_bytes * 1e-6, (double)ctx->alloc.limit * 1e-6);
    return PD_OK;
}

#undef PDI_MEMORY_ESTIMATE_SAMPLE_POINTS
#undef PDI_MEMORY_ESTIMATE_PLOT_BYTES
#undef PDI_MEMORY_ESTIMATE_DEFLATE_BYTES
#undef PDI_MEMORY_ESTIMATE_FIXED_BYTES
#undef PDI_MEMORY_ESTIMATE_MAX_PLANNED_NODES
#undef PDI_MEMORY_ESTIMATE_KRYLOV_VECTORS
