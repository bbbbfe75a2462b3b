/* dissolution_physics: see dissolution_physics.h */
#include "physics/dissolution_physics.h"
#include "metal/interface.h"
#include "setup/interval.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Set all variables vars [PD_EXPR_VARS] of a rate-law expression at a node: C, t, place, grain, the fields of
 * registered physics where the law reads one, and current density and potential of the electrode beside it where there
 * is a potential solver and the law reads them; the others are 0. */
static void pdi_dissolution_physics_set_law_variables(const pd_model_law *law, const pd_rate_at *at, double *vars)
{
    memset(vars, 0, PD_EXPR_VARS * sizeof *vars);
    vars[0] = at->c;
    vars[1] = at->t;
    memcpy(vars + 2, at->x, sizeof at->x);
    vars[PD_SETUP_RATE_GRAIN] = at->grain;
    vars[PD_SETUP_RATE_CURRENT] = vars[PD_SETUP_RATE_POTENTIAL] = 0.0;
    if (pd_setup_reads_registered_field(law->metal)) pdi_model_set_registered_variables(law->model, at->node, vars);
    if (law->cell && pdi_setup_has_electric_rate(law->metal))
        pdi_cell_beside(law->cell, at->node, law->kind, &vars[PD_SETUP_RATE_CURRENT], &vars[PD_SETUP_RATE_POTENTIAL]);
}

/* Dissolution speed [m/s] by the rate expression of a metal. A pd_rate_fn; user: a pd_model_law. */
static double pdi_dissolution_physics_compute_rate(void *user, const pd_rate_at *at)
{
    const pd_model_law *law = (const pd_model_law *)user;
    double vars[PD_EXPR_VARS];
    pdi_dissolution_physics_set_law_variables(law, at, vars);
    return law->metal->rate_scale * pd_expr_eval(&law->metal->rate, vars);
}

/* Bounds *least, *most [m/s] of the speed, with rate_scale, over the times from .. to [s] with all other inputs held,
 * by interval arithmetic. A pd_rate_bounds_fn; user: a pd_model_law. */
static void pdi_dissolution_physics_compute_rate_bounds(void *user, const pd_rate_at *at, double from, double to,
                                                        double *least, double *most)
{
    const pd_model_law *law = (const pd_model_law *)user;
    double vars[PD_EXPR_VARS];
    pdi_dissolution_physics_set_law_variables(law, at, vars);
    pdi_interval range = pdi_interval_eval_expr(&law->metal->rate, vars, 1, from, to);
    *least = law->metal->rate_scale * range.low;
    *most = law->metal->rate_scale * range.high;
}

/* Allocate m->passive and mark the nodes within the shape of the passive film in it; without such a shape nothing is
 * done. */
static pd_status pdi_dissolution_physics_mark_passive(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    if (u->passive < 0) return PD_OK;
    PD_TRY(PD_NEW(ctx, "model", m->grid.total, m->passive));
    for (int32_t i = 0; i < m->grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&m->grid, i, x);
        m->passive[i] = (uint8_t)pdi_shape_contains(u->shape, u->passive, u->h, x);
    }
    return PD_OK;
}

/* Descriptor of a metal for the dissolution solver: solid concentration and rate law. */
static pd_metal pdi_dissolution_physics_set_metal_desc(const pd_model_law *law)
{
    const pd_setup_metal *metal = law->metal;
    pd_metal is;
    memset(&is, 0, sizeof is); /* no breaks: the bounds know them */
    is.solid = metal->solid_c;
    is.rate = pdi_dissolution_physics_compute_rate;
    is.rate_user = (void *)law; /* only read */
    is.uniform = metal->rate.variables_used >> 1 == 0;
    is.timeless = !(metal->rate.variables_used >> 1 & 1u);
    is.bounds = pdi_dissolution_physics_compute_rate_bounds;
    return is;
}

/* Options of bond-based corrosion, from the setup into desc; marks the nodes within the shape of the passive film in
 * the model. */
static pd_status pdi_dissolution_physics_set_corrosion_desc(pd_ctx *ctx, pd_model *m, pd_dissolve_desc *desc)
{
    const pd_setup *u = m->setup;
    PD_TRY(pdi_dissolution_physics_mark_passive(ctx, m));
    desc->model = PD_METAL_BONDS;
    desc->saturation = u->saturation;
    desc->rtol = u->rtol;
    desc->activation = u->activation;
    desc->bulk = u->bulk_c;
    desc->drive = u->drive;
    desc->kernel = u->kernel;
    desc->weights = u->weights;
    desc->stochastic = u->stochastic;
    desc->seed = (uint64_t)u->seed;
    desc->repassivation = u->repassivation;
    desc->passive = m->passive;
    return PD_OK;
}

/* 1: a rate law depends on the current density, and no factor field, migration or other drive changes its rate, so that
 * Faraday's law can hold exactly. */
static int pdi_dissolution_physics_is_faradaic(const pd_setup *setup, const pd_dissolve_desc *desc)
{
    int sees = 0;
    for (int k = 0; k < setup->metals; k++)
        sees |= (int)(setup->metal[k].rate.variables_used >> PD_SETUP_RATE_CURRENT & 1u);
    return sees && setup->has_potential && !setup->has_migration && !desc->factor && desc->drive == PD_DRIVE_CONSTANT;
}

/* Bring currents that depend on time to time t [s] for the rate laws, unless they are solved in steps of the species;
 * with Faraday's law, match lost metal and charge. Does nothing before the potential solver is built. The `found`
 * callback of pd_dissolve; user: pd_model. */
static pd_status pdi_dissolution_physics_update_currents(pd_ctx *ctx, void *user, double t)
{
    pd_model *m = (pd_model *)user;
    if (!m->cell.grid) return PD_OK;
    if (m->cell.desc.timed && !pdi_electrode_map_is_solved_per_species_step(m->setup))
        PD_TRY(pdi_cell_bring(ctx, &m->cell, t));
    if (pdi_dissolution_physics_is_faradaic(m->setup, &m->dissolve.desc)) pdi_cell_match(&m->cell);
    return PD_OK;
}

/* Builds the dissolving metal: options, laws, grains, electrodes. A law in the species is replaced by the speed that
 * the surface solver finds. Allocates m->coverage_factor where minerals with a shielding thickness cover metal, and
 * m->passive under a passive film. Errors: those of pd_dissolve_build. */
static pd_status pdi_dissolution_physics_build(pd_ctx *ctx, pd_model *m)
{
    const pd_setup *u = m->setup;
    pd_metal metal[PD_SETUP_METALS];
    pd_dissolve_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(metal, 0, sizeof metal);
    for (int k = 0; k < u->metals; k++) {
        m->law[k].metal = &u->metal[k];
        m->law[k].kind = k;
        m->law[k].model = m;
        m->law[k].cell = u->has_potential ? &m->cell : NULL;
        metal[k] = pdi_dissolution_physics_set_metal_desc(&m->law[k]);
    }
    desc.more = metal + 1;
    desc.more_count = u->metals - 1;
    desc.metal = m->metal;
    for (int k = 0; k < u->metals; k++)
        if (u->metal[k].rate.variables_used >> PD_SETUP_RATE_GRAIN & 1u) desc.grain = m->grain.id;
    desc.factor = m->setup->metal_body.has_rate_factor ? m->solid.rate_factor : m->boundary_factor;
    if (u->shielding_thickness > 0.0 && u->minerals) {
        PD_TRY(PD_NEW(ctx, "model", m->grid.total, m->coverage_factor));
        for (int32_t i = 0; i < m->grid.total; i++) m->coverage_factor[i] = desc.factor ? desc.factor[i] : 1.0;
        desc.factor = m->coverage_factor;
        desc.lags = 1;
    }
    if (m->setup->has_corrode) PD_TRY(pdi_dissolution_physics_set_corrosion_desc(ctx, m, &desc));
    else desc.threshold = m->setup->threshold;
    desc.sheds = u->has_surface_reaction ? 1 + (pd_setup_count_species_rate_metals(u) > 1) : 0;
    for (int k = 0; k < u->metals; k++) {
        if (!pd_setup_has_species_rate(&u->metal[k])) continue;
        metal[k].rate = pdi_dissolution_laws_get_speed;
        metal[k].rate_user = &m->dissolution_laws.law[pd_setup_count_species_rate_metals(u) > 1 ? k : 0];
        metal[k].uniform = 0;
        metal[k].timeless = 1; /* it is found once a step */
        metal[k].bounds = NULL;
    }
    desc.solid = metal[0].solid;
    desc.rate = metal[0].rate;
    desc.rate_user = metal[0].rate_user;
    desc.uniform = metal[0].uniform;
    desc.timeless = metal[0].timeless;
    desc.bounds = metal[0].bounds;
    desc.follows = pdi_electrode_map_is_read_by_laws(u);
    desc.driven = desc.follows && pdi_electrode_map_is_time_dependent(u);
    desc.anew = desc.follows && !pdi_electrode_map_is_solved_per_species_step(u);
    if (desc.follows) {
        desc.found = pdi_dissolution_physics_update_currents;
        desc.found_user = m;
    }
    if (pd_setup_find_species_rate_metal(u) >= 0 || pd_setup_has_ion_electrodes(u)) {
        desc.found = pdi_dissolution_laws_update_speeds;
        desc.found_user = &m->dissolution_laws;
        desc.lags = 1;
    }
    m->unknowns[PD_PART_DISSOLVE] = m->grid.solid_count;
    return pd_dissolve_build(ctx, &m->grid, &m->interface_stencil, &m->transport, &desc, &m->dissolve);
}

/* Add the memory of the dissolution. Fluid and metal within a horizon of each other are estimated by the surface of a
 * cube of all metal, with a quarter more room; bond-based corrosion also has its kernel and reaches, a passive film a
 * byte a node. */
static void pdi_dissolution_physics_estimate(const pd_setup *setup, pdi_memory_plan *plan, pd_memory_estimate *b)
{
    double *bytes = &b->bytes[PD_PART_DISSOLVE];
    pd_dissolve d;
    /* fluid within a horizon of metal, which has at least the surface of a cube */
    double shell = pd_min(2.0 * PD_DIM * setup->metal_m * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->fluid);
    memset(&d, 0, sizeof d);
    d.grid = (pd_grid *)&plan->grid; /* only read */
    d.paths.words = (plan->across.count + 31) / 32;
    d.kinds = setup->metals;
    d.capacity = (int32_t)plan->grid.solid_count;
    d.beside_capacity = (int32_t)(1.25 * shell / plan->node_scale); /* there is room for more */
    d.kernel.stencil = &plan->across;
    d.desc.model = setup->has_corrode ? PD_METAL_BONDS : PD_METAL_SURFACE;
    d.desc.activation = setup->activation;
    d.desc.sheds = setup->has_surface_reaction ? 1 + (pd_setup_count_species_rate_metals(setup) > 1) : 0;
    d.desc.stochastic = setup->stochastic;
    d.desc.repassivation = setup->repassivation;
    *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_dissolve_list, &d) +
              pdi_memory_plan_count_array_bytes(plan, pdi_reach_beside_list, &d);
    if (setup->has_corrode) {
        /* metal within a horizon of fluid; there is room for more */
        double layers = pd_min(2.0 * PD_DIM * setup->metal_m * pow(b->solid, (PD_DIM - 1.0) / PD_DIM), b->solid);
        d.reach_rows = (int32_t)(1.25 * layers / plan->node_scale);
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_front_list, &d.kernel);
        *bytes += pdi_memory_plan_count_array_bytes(plan, pdi_reach_list, &d);
    }
    if (setup->passive >= 0) *bytes += b->nodes;
}

/* Describe the dissolution rate of metal m in text [size], as "surface rate 1 um/h at C = 0 (8.766 mm/year, 3.8 A/m2
 * with z = 2), Cs = 71508 mol/m3". Laws in species, potential or fields of programs get no number. With several metals
 * the name comes first. */
static void pdi_dissolution_physics_format_rate(const pd_setup *setup, int m, char *text, size_t size)
{
    const pd_setup_metal *metal = &setup->metal[m];
    char speed[PD_UNITS_TEXT];
    double v = pd_setup_compute_rate_at_zero(metal), z = metal->material.charge;
    pd_setup_format_value(v, "m/s", speed);
    if (pd_setup_has_species_rate(metal) || pdi_setup_has_electric_rate(metal) ||
        pd_setup_reads_registered_field(metal)) {
        snprintf(text, size, "%s%ssurface rate by %s, z = %g, Cs = %.6g mol/m3",
                 setup->metals > 1 ? metal->material.name : "", setup->metals > 1 ? ": " : "",
                 pd_setup_has_species_rate(metal)    ? "a law in the species at the surface"
                 : pdi_setup_has_electric_rate(metal) ? "the potential"
                                                      : "a law in the fields at the surface",
                 z, metal->solid_c);
        return;
    }
    snprintf(text, size, "%s%ssurface rate %s at C = 0%s (%.4g mm/year, %.4g A/m2 with z = %g), Cs = %.6g mol/m3",
             setup->metals > 1 ? metal->material.name : "", setup->metals > 1 ? ": " : "", speed,
             metal->rate.variables_used > 1 ? ", t = 0 and the origin" : "", v * 1e3 * 31557600.0,
             v * metal->solid_c * z * PD_FARADAY, z, metal->solid_c);
}

/* Prints the laws of [dissolve], a line for each metal. */
static void pdi_dissolution_physics_print_surface_laws(const pdi_summary_text *s)
{
    const pd_setup *u = s->model->setup;
    char text[384];
    pdi_dissolution_physics_format_rate(u, 0, text, sizeof text);
    pdi_summary_text_print_part(s, PD_PART_DISSOLVE, "dissolution", text);
    for (int m = 1; m < u->metals; m++) {
        pdi_dissolution_physics_format_rate(u, m, text, sizeof text);
        pdi_summary_text_print_line(s, "  %-12s%s", "", text);
    }
    if (u->saturation > 0.0) pdi_summary_text_print_line(s, "  %-12sCsat = %.6g mol/m3", "", u->saturation);
}

/* Prints the laws of [corrode], and the variant of the bond-based model. */
static void pdi_dissolution_physics_print_bond_laws(const pdi_summary_text *s)
{
    static const char *const kernels[] = {"area", "inverse square", "inverse"};
    const pd_setup *u = s->model->setup;
    char text[384];
    snprintf(text, sizeof text, "bond-based, %s control", u->activation ? "activation" : "diffusion");
    pdi_summary_text_print_part(s, PD_PART_DISSOLVE, "corrosion", text);
    for (int m = 0; m < u->metals; m++) {
        pdi_dissolution_physics_format_rate(u, m, text, sizeof text);
        pdi_summary_text_print_line(s, "  %-12s%s, Csat = %.6g mol/m3", "", text, u->saturation);
    }
    pdi_summary_text_print_line(s, "  %-12s%s weights, %s%s", "", kernels[u->kernel],
                                u->weights == PD_WEIGHTS_PUBLISHED ? "published" : "calibrated",
                                u->drive == PD_DRIVE_DIFFERENCE ? ", loss in proportion to the difference" : "");
    if (u->stochastic) pdi_summary_text_print_line(s, "  %-12smechanical bonds break at random, seed %d", "", u->seed);
}

static int pdi_dissolution_physics_is_present(const pd_setup *setup) { return setup->has_dissolve; }

static pd_status pdi_dissolution_physics_add_processes(pd_ctx *ctx, pd_model *m)
{
    return pd_time_loop_add_process(ctx, &m->time_loop, pd_dissolve_process(&m->dissolve));
}

/* Frees what pdi_dissolution_physics_build made. */
static void pdi_dissolution_physics_free(pd_ctx *ctx, pd_model *m)
{
    pd_dissolve_free(ctx, &m->dissolve);
    PD_DELETE(ctx, m->grid.total, m->passive);
    PD_DELETE(ctx, m->grid.total, m->coverage_factor);
}

/* A `reads_bonds` callback: 0: bond-based corrosion under activation control; 1: other metal. */
static int pdi_dissolution_physics_reads_bonds(const pd_setup *setup)
{
    return !setup->has_corrode || !setup->activation;
}

/* Adds the Krylov iterations of the metal's transport to the statistics of the run, and sets its limiter iterations and
 * residuals. */
static void pdi_dissolution_physics_add_statistics(const pd_model *m, pd_model_statistics *e)
{
    const pd_transport_result *r = &m->dissolve.result;
    e->transport_krylov += m->dissolve.krylov;
    e->limiter_iterations = r->limiter;
    e->steady_change = r->change;
    e->mass_defect = r->defect;
}

/* Speed [m/s] of the fastest metal beside a fluid node, NaN at nodes that are not fluid; or, for PD_FIELD_DAMAGE, the
 * damage [-] of any node. */
static double pdi_dissolution_physics_sample(const pd_model *m, pd_field field, int32_t i)
{
    if (field == PD_FIELD_DAMAGE) return pdi_dissolve_damage(&m->dissolve, i);
    return m->grid.kind[i] == PD_FLUID ? pdi_interface_fastest(&m->dissolve, i) : (double)NAN;
}

static void pdi_dissolution_physics_print_summary(const pdi_summary_text *s)
{
    if (s->model->setup->has_corrode) pdi_dissolution_physics_print_bond_laws(s);
    else pdi_dissolution_physics_print_surface_laws(s);
}

PDI_FN void pdi_dissolution_physics_register(pdi_physics_list *list)
{
    pdi_physics_row *row =
        pdi_physics_row_add(list, "dissolution", PD_PART_DISSOLVE, pdi_dissolution_physics_is_present);
    row->stage = PDI_PHYSICS_STAGE_METAL;
    row->build = pdi_dissolution_physics_build;
    row->add_processes = pdi_dissolution_physics_add_processes;
    row->free = pdi_dissolution_physics_free;
    row->reads_bonds = pdi_dissolution_physics_reads_bonds;
    row->add_statistics = pdi_dissolution_physics_add_statistics;
    row->estimate = pdi_dissolution_physics_estimate;
    row->print_summary = pdi_dissolution_physics_print_summary;
    pdi_physics_row_add_fields(row, PD_FIELD_RATE, PD_FIELD_RATE, pdi_dissolution_physics_sample, NULL);
    pdi_physics_row_add_fields(row, PD_FIELD_DAMAGE, PD_FIELD_DAMAGE, pdi_dissolution_physics_sample, NULL);
}
