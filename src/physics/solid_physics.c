/* solid_physics: see solid_physics.h */
#include "physics/solid_physics.h"
#include "lattice/thickness.h"
#include "solid/bond_extension.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Failure criterion of bonds of all materials: principal stress [Pa], else, unless springs, energy of a crack [J/m2],
 * else stretch, the first that is set; zero: none. Springs take their energy elsewhere. */
static pd_bond_failure_desc pdi_solid_physics_set_fracture_desc(const pd_setup_mechanics *b)
{
    pd_bond_failure_desc breaks;
    memset(&breaks, 0, sizeof breaks);
    breaks.critical = b->stretch;
    if (b->strength > 0.0) {
        breaks.kind = PD_BOND_FAILURE_PRINCIPAL;
        breaks.critical = b->strength;
    } else if (b->toughness > 0.0 && b->material != PD_SOLID_COUPLING_BOND_BASED) {
        breaks.kind = PD_BOND_FAILURE_ENERGY;
        breaks.fracture = b->toughness;
    }
    return breaks;
}

/* Cells across for 5 % error in bending, m the horizon in cells: 5 m + 6 of metal with a yield stress, 2 m + 2 of
 * springs, 4 m of ordinary, 6 m of other metal, rounded up. Measured: plastic moments of bars are 4 % off with 12, 16,
 * 24 cells for m = 1, 2, 3; elastic curvatures at nu = 0.3 5 % off with 6, 12, 17, with the ordinary material 5, 8,
 * 11. */
static int pdi_solid_physics_get_min_cells_across(const pd_setup_mechanics *b)
{
    if (b->yield > 0.0) return (int)ceil(5.0 * b->m + 6.0);
    if (b->material == PD_SOLID_COUPLING_BOND_BASED) return (int)ceil(2.0 * b->m + 2.0);
    return (int)ceil((b->material == PD_SOLID_COUPLING_ORDINARY_STATE ? 4.0 : 6.0) * b->m);
}

/* Builds the body of the metal with material, cracks, supports and loads. A mirror side without a mechanical condition
 * becomes a plane of symmetry. Also sets the number of unknowns, and, in 2D and 3D, min_cells_across and thin_fraction
 * of the model. Errors: those of pd_solid_coupling_build and pdi_mechanical_bc_build. */
static pd_status pdi_solid_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup_mechanics *b = &m->setup->metal_body;
    pd_solid_coupling_precrack cuts[PD_SETUP_PRECRACKS];
    pd_solid_coupling_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.horizon_ratio = b->m;
    desc.elastic.young = b->young;
    desc.elastic.poisson = b->poisson;
    desc.elastic.plane = b->plane;
    desc.elastic.influence = b->influence;
    desc.elastic.yield = b->yield;
    desc.elastic.hardening = b->hardening;
    desc.material = b->material;
    desc.bond_failure = pdi_solid_physics_set_fracture_desc(b);
    if (b->material == PD_SOLID_COUPLING_BOND_BASED) desc.fracture = b->toughness;
    desc.density = b->density;
    desc.loads_in_time = b->is_time_dependent;
    desc.rtol = b->rtol;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int own = m->setup->side[side].kind != PD_SIDE_MIRROR;
        for (int k = 0; k < b->mechanical_bcs; k++) own |= b->mechanical_bc[k].side == side;
        if (!own) desc.mirrors |= 1 << side;
    }
    desc.load = pdi_mechanical_bc_apply;
    desc.user = &m->mechanical_bc;
    if (b->has_rate_factor) desc.rate_factor = pdi_mechanical_bc_compute_rate_factor;
    desc.pace_user = (void *)m->setup; /* only read */
    desc.base_rate_factor = m->boundary_factor;
    for (int k = 0; k < b->precracks; k++) {
        cuts[k].name = b->precrack[k].name;
        cuts[k].corners = b->precrack[k].corners;
        cuts[k].corner = b->precrack[k].corner;
    }
    desc.cuts = cuts;
    desc.cut_count = b->precracks;
    m->unknowns[PD_PART_SOLID] = (int64_t)PD_DIM * m->grid.solid_count;
    if (PD_DIM > 1) {
        m->min_cells_across = pdi_solid_physics_get_min_cells_across(b);
        PD_TRY(pdi_thickness_compute_thin_fraction(ctx, &m->grid, m->min_cells_across, &m->thin_fraction));
    }
    PD_TRY(pd_solid_coupling_build(ctx, &m->grid, &desc, &m->solid));
    return pdi_mechanical_bc_build(ctx, m->setup, &m->solid, &m->mechanical_bc);
}

/* [byte] Work memory of the mechanical equilibrium solver. */
static double pdi_solid_physics_estimate_equilibrium(const pd_setup *setup, pdi_memory_plan *plan, pd_solid_coupling *s)
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
    return pdi_memory_plan_count_krylov_bytes(plan, &kd) +
           pdi_memory_plan_count_array_bytes(plan, pdi_equilibrium_list, &q) +
           (solid.moduli ? plan->node_scale * pdi_coarse_fe_precond_estimate_bytes(s->count, m + 0.5) : 0.0);
}

/* [byte] Memory of bond weights; share: fraction of points with weights of their own (truncated families). A body
 * without a lattice table has weights for all bonds, whatever the share. */
static double pdi_solid_physics_estimate_bond_weights(const pdi_memory_plan *plan, const pd_solid_coupling *s,
                                                      double share)
{
    pd_bond_weights weights;
    memset(&weights, 0, sizeof weights);
    weights.body = &s->body;
    weights.listed = s->body.lattice && share > 0.0 ? s->count : 0;
    weights.capacity = s->body.lattice ? (int64_t)(share * (double)s->body.bonds) : s->body.bonds;
    return pdi_memory_plan_count_array_bytes(plan, pdi_bond_weights_list, &weights);
}

/* Fraction of the points of a box within two horizons m [cells] of its sides along the first `axes` axes: their bonds
 * have correction factors. */
static double pdi_solid_physics_estimate_boundary_fraction(const pdi_memory_plan *plan, double m, int axes)
{
    double inside = 1.0;
    for (int d = 0; d < axes; d++) inside *= pd_max(0.0, 1.0 - 4.0 * m / (double)plan->grid.n[d]);
    return 1.0 - inside;
}

/* [byte] Memory of batches of points (bands) as long as lattice rows, and of their bonds with `more` bytes each. */
static double pdi_solid_physics_estimate_batches(const pdi_memory_plan *plan, const pd_solid_coupling *s,
                                                 int32_t fields, double more)
{
    double most = pd_min((double)PD_POINT_BATCH_MAX, (double)plan->grid.n[0]), bonds = (double)s->body.bonds / most;
    pd_point_batch band;
    memset(&band, 0, sizeof band);
    band.body = &s->body;
    band.fields = fields;
    band.stride = s->count;
    more += (double)sizeof *band.bond;
    return pdi_memory_plan_count_array_bytes(plan, pdi_point_batch_list, &band) +
           1.25 * plan->node_scale * bonds * more;
}

/* [byte] Memory of the material model of the metal: its own arrays, bond weights, and batches of points, which metal of
 * large strains does not have. s has the sizes of the body and its material attached. */
static double pdi_solid_physics_estimate_material(const pdi_memory_plan *plan, pd_solid_coupling *s)
{
    int flows = pdi_solid_coupling_is_plastic(s);
    /* in no band */
    double of = (double)sizeof *s->bond_based.springs.bond_kind,
           alone = pdi_solid_physics_estimate_boundary_fraction(plan, s->desc.horizon_ratio, 1);
    switch (s->desc.material) {
    case PD_SOLID_COUPLING_BOND_BASED:
        return pdi_solid_physics_estimate_batches(plan, s, PDI_POINT_BATCH_STIFFNESS, of) +
               alone * plan->node_scale * (double)s->body.bonds * ((double)sizeof *s->elastic.band.bond + of) +
               pdi_solid_physics_estimate_bond_weights(
                   plan, s, pdi_solid_physics_estimate_boundary_fraction(plan, s->desc.horizon_ratio, PD_DIM)) +
               pdi_memory_plan_count_array_bytes(plan, pdi_microelastic_list, &s->bond_based);
    case PD_SOLID_COUPLING_ORDINARY_STATE:
        return pdi_solid_physics_estimate_batches(plan, s, PDI_BOND_EXTENSION_FIELDS, 0.0) +
               pdi_memory_plan_count_array_bytes(plan, pdi_ordinary_state_list, &s->ordinary) +
               pdi_solid_physics_estimate_bond_weights(plan, s, 0.0);
    case PD_SOLID_COUPLING_NEO_HOOKEAN:
    case PD_SOLID_COUPLING_HENCKY:
        return pdi_memory_plan_count_array_bytes(plan, pdi_finite_strain_list, &s->finite) +
               pdi_solid_physics_estimate_bond_weights(plan, s, 0.0);
    case PD_SOLID_COUPLING_CORRESPONDENCE: break;
    }
    return pdi_solid_physics_estimate_batches(plan, s, flows ? PDI_POINT_BATCH_FIELDS : PDI_POINT_BATCH_PLASTIC_STRESS,
                                              0.0) +
           pdi_solid_physics_estimate_bond_weights(plan, s, 0.0) +
           pdi_memory_plan_count_array_bytes(plan, pdi_correspondence_list, &s->elastic) +
           pdi_memory_plan_count_array_bytes(plan, pdi_j2_plasticity_list, &s->elastic.plastic);
}

/* Set the sizes of the bond table of a body on the lattice, of body->count points; it has no more entries than the box.
 */
static void pdi_solid_physics_set_bond_table(const pd_setup *setup, const pdi_memory_plan *plan, pd_body *body)
{
    double bonds = pdi_memory_plan_count_bonds(setup->metal_body.m), n[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) n[d] = (double)plan->grid.n[d];
    body->shifts = body->stencil_bonds = (int32_t)bonds;
    body->bonds = (int64_t)(bonds * (double)body->count);
    double places = pdi_body_count_table_entries(n, floor(setup->metal_body.m + 0.5));
    body->lattice = places + (double)body->count <= 2.0 * (double)body->bonds;
    body->table_entries = body->lattice ? (int64_t)places : body->bonds;
}

/* [byte] Memory of the interpolation rows of prescribed displacements: two horizons of metal at each such side. */
static double pdi_solid_physics_estimate_interpolation(const pd_setup *setup, const pdi_memory_plan *plan)
{
    double rows = 2.0 * (ceil(setup->metal_body.m + 0.5) - 1.0), led = 0.0;
    pd_mechanical_bc grips;
    memset(&grips, 0, sizeof grips);
    for (int k = 0; k < setup->metal_body.mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &setup->metal_body.mechanical_bc[k];
        double share = grip->side >= 0 ? pd_min(1.0, rows / plan->grid.n[grip->side / 2]) : 0.0;
        for (int d = 0; d < PD_DIM; d++)
            if (grip->has_displacement[d]) led += (double)plan->grid.solid_count * share;
    }
    grips.interpolation_capacity = (int64_t)led;
    return pdi_memory_plan_count_array_bytes(plan, pdi_mechanical_bc_list, &grips);
}

/* Set the memory of the mechanics of the metal in b->bytes, and, in statics, the work of its equilibrium solver in
 * b->equilibrium_bytes. Mirror images do not count. */
static void pdi_solid_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_SOLID];
    pd_solid_coupling s;
    memset(&s, 0, sizeof s);
    s.count = s.body.count = (int32_t)plan->grid.solid_count;
    s.total = plan->grid.total;
    pdi_solid_physics_set_bond_table(setup, plan, &s.body);
    s.desc.material = setup->metal_body.material;
    s.desc.horizon_ratio = setup->metal_body.m;
    s.desc.density = setup->metal_body.density;
    s.desc.elastic.yield = setup->metal_body.yield;
    pdi_solid_coupling_attach_material(&s);
    s.dynamic_solver.solid.body = &s.body;
    s.static_solver.n = (int64_t)s.count * PD_DIM;
    if (setup->metal_body.has_rate_factor) s.desc.rate_factor = pdi_mechanical_bc_compute_rate_factor;
    *bytes = pdi_memory_plan_count_array_bytes(plan, pdi_solid_coupling_list, &s) +
             pdi_memory_plan_count_array_bytes(plan, pdi_body_list_state, &s.body);
    if (!pd_solid_coupling_is_dynamic(&s)) *bytes += pdi_solid_physics_estimate_interpolation(setup, plan);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_body_list_points, &s.body);
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_body_list_families, &s.body);
    *bytes += pdi_solid_physics_estimate_material(plan, &s);
    *bytes += pd_solid_coupling_is_dynamic(&s)
                  ? pdi_memory_plan_count_array_bytes(plan, pdi_verlet_list, &s.dynamic_solver)
                  : pdi_memory_plan_count_array_bytes(plan, pdi_quasi_static_list, &s.static_solver);
    if (!pd_solid_coupling_is_dynamic(&s))
        b->equilibrium_bytes = pdi_solid_physics_estimate_equilibrium(setup, plan, &s);
}

/* Print the failure criteria of bonds that are set, a line each: stretch, principal stress, energy of cracks. */
static void pdi_solid_physics_print_fracture(const pdi_summary_text *s)
{
    const pd_setup_mechanics *b = &s->model->setup->metal_body;
    char strength[PD_UNITS_TEXT];
    pd_setup_format_value(b->strength, "Pa", strength);
    if (b->stretch > 0.0) pdi_summary_text_print_line(s, "  %-12sbonds break at a stretch of %g", "", b->stretch);
    if (b->strength > 0.0)
        pdi_summary_text_print_line(s, "  %-12sbonds break at a principal stress of %s", "", strength);
    if (b->toughness > 0.0) pdi_summary_text_print_line(s, "  %-12scracks take %g J/m2", "", b->toughness);
}

/* Prints material, failure criterion, supports and loads. */
static void pdi_solid_physics_print_summary(const pdi_summary_text *s)
{
    static const char *const materials[] = {"small strains", "springs", "ordinary", "neo-Hookean", "Hencky"};
    const pd_model *m = s->model;
    const pd_setup_mechanics *b = &m->setup->metal_body;
    char text[384], young[PD_UNITS_TEXT], yield[PD_UNITS_TEXT];
    pd_setup_format_value(b->young, "Pa", young);
    pd_setup_format_value(b->yield, "Pa", yield);
    snprintf(text, sizeof text, "%s, E = %s, nu = %g%s, m = %g, %.0f bonds", materials[b->material], young, b->poisson,
             PD_DIM != 2                   ? ""
             : b->plane == PD_PLANE_STRESS ? ", plane stress"
                                           : ", plane strain",
             b->m, 0.5 * (double)m->solid.body.bonds);
    pdi_summary_text_print_part(s, PD_PART_SOLID, "solid", text);
    if (b->yield > 0.0) pdi_summary_text_print_line(s, "  %-12sflows at %s", "", yield);
    pdi_solid_physics_print_fracture(s);
    if (b->density > 0.0)
        pdi_summary_text_print_line(s, "  %-12smoves, %g kg/m3, steps of %g s", "", b->density,
                                    m->solid.dynamic_solver.max_step);
}

/* Print a note with the share of metal in parts thinner than min_cells_across, if it is above 0; nothing else. */
static void pdi_solid_physics_print_thin_metal(const pdi_summary_text *s)
{
    static const char *const across[] = {"6 m", "2 m + 2", "4 m", "6 m", "6 m"};
    const pd_setup_mechanics *b = &s->model->setup->metal_body;
    char text[320];
    if (!(s->model->thin_fraction > 0.0)) return;
    snprintf(text, sizeof text,
             "solid: %.3g %% of the metal is in parts thinner than %d cells, %s: where they are "
             "bent they are more than 5 %% off; expected a smaller h, or a smaller m",
             100.0 * s->model->thin_fraction, s->model->min_cells_across,
             b->yield > 0.0 ? "5 m + 6 of metal that flows" : across[b->material]);
    s->print(s->user, PD_PRINT_NOTE, text);
}

/* A Cartesian stress component [Pa] of a solid point, by its field (xx, yy, zz, xy, yz, zx); in 2D zz is the
 * out-of-plane stress. */
static double pdi_solid_physics_get_stress(const pd_solid_coupling *s, pd_field field, int32_t point)
{
    static const int row[6] = {0, 1, 2, 0, 1, 2}, column[6] = {0, 1, 2, 1, 2, 0};
    int p = row[field - PD_FIELD_SIGMA_XX], q = column[field - PD_FIELD_SIGMA_XX];
    if (PD_DIM == 2 && p == 2) return s->out_of_plane_stress[point];
    return s->stress[((int64_t)point * PD_DIM + p) * PD_DIM + q];
}

/* Value of a mechanical field at node i: norm of the displacement [m], stresses [Pa], plastic strain, damage, energy
 * [J/m3] as last prepared; 0 where the node is no solid now, or no point of the body. */
static double pdi_solid_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    const pd_solid_coupling *s = &m->solid;
    int32_t point = s->point[i];
    double square = 0.0;
    if (point < 0 || m->grid.kind[i] != PD_SOLID) return 0.0;
    switch (field) {
    case PD_FIELD_U:
        for (int d = 0; d < PD_DIM; d++) {
            double u = pd_solid_coupling_displacements(s)[(int64_t)point * PD_DIM + d];
            square += u * u;
        }
        return sqrt(square);
    case PD_FIELD_MISES: return s->mises[point];
    case PD_FIELD_MEAN_STRESS: return s->pressure[point];
    case PD_FIELD_PLASTIC_STRAIN: return s->plastic_strain[point];
    case PD_FIELD_BROKEN: return pdi_solid_coupling_damage(s, point);
    case PD_FIELD_STRAIN_ENERGY: return s->density[point];
    default: return pdi_solid_physics_get_stress(s, field, point);
    }
}

static int pdi_solid_physics_is_present(const pd_setup *setup) { return setup->has_solid; }

static pd_status pdi_solid_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    pd_dissolve *dissolve = m->dissolve.grid ? &m->dissolve : NULL;
    return pd_time_loop_add_process(ctx, &m->time_loop, pd_solid_coupling_process(&m->solid, dissolve));
}

static void pdi_solid_physics_free(pd_ctx *ctx, pd_model *m)
{
    pd_solid_coupling_free(ctx, &m->solid);
    pdi_mechanical_bc_free(ctx, &m->mechanical_bc);
}

/* Compute the energy density [J/m3] into m->solid.density if `fields` asks for it; other fields need nothing. */
static void pdi_solid_physics_prepare_samples(pd_ctx *ctx, pd_model *m, pd_fields fields)
{
    const pd_material_interface *solid = &m->solid.solid;
    if (((fields >> PD_FIELD_STRAIN_ENERGY) & 1u) && m->solid.count)
        solid->density(ctx, solid->self, pd_solid_coupling_displacements(&m->solid), m->solid.density);
}

PDI_FN void pdi_solid_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row = pdi_physics_row_add(list, "mechanics", PD_PART_SOLID, pdi_solid_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_MOTION;
    row->build = pdi_solid_physics_build;
    row->add_processes = pdi_solid_physics_add_processes;
    row->free = pdi_solid_physics_free;
    row->prepare_samples = pdi_solid_physics_prepare_samples;
    row->estimate = pdi_solid_physics_estimate;
    row->print_summary = pdi_solid_physics_print_summary;
    row->print_notes = pdi_solid_physics_print_thin_metal;
    pdi_physics_row_add_fields(row, PD_FIELD_U, PD_FIELD_SIGMA_ZX, pdi_solid_physics_sample, NULL);
}
