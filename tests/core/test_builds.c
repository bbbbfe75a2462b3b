/* builds: what fails to build or to be read leaves nothing: no memory, and an object of zeros, whatever it held before.
 * Every build of the library, with every allocation failing in turn, and with arguments that it refuses.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "chemistry/speciation.h"
#include "react/course.h"
#include "fault.h"
#include "potential/distribution.h"
#include "scene_file.h"
#include "run/parameter_sweep.h"
#include "run/compare_measured.h"
#include "physics/depletion_notes.h"
#include "physics/input_step_limit.h"
#include "flow/gas.h"
#include "lattice/csr.h"
#include "lattice/lattice.h"
#include "scene/text.h"
#include "physics/step_diagnostics.h"
#include "io/points_file.h"
#include "io/png.h"
#include "run/coarsen_setup.h"
#include "solid/finite_strain.h"
#include "solid/microelastic.h"
#include "solid/sequentially_linear.h"
#include "solid/ordinary_state.h"
#include "solid/coarse_fe_precond.h"
#include "solid/verlet.h"
#include "multigrid_build.h"
#include <stddef.h>

#if PD_DIM == 1
#define ACROSS(a, b)
#elif PD_DIM == 2
#define ACROSS(a, b) ", " a " .. " b
#else
#define ACROSS(a, b) ", " a " .. " b ", " a " .. " b
#endif

static const char pin[] = "[grid] h = 1 um  m = 2  box = 0 .. 16 um" ACROSS(
    "0", "8 um") "\n"
                 "[shape metal] box = 6 um .. 11 um" ACROSS(
                     "3 um",
                     "5 um") "\n  kind = solid  material = mg4ag  grain_size = 3 um\n"
#if PD_DIM > 1
                             "[side x-] flow = inlet  profile = uniform  mean = 0.01 m/s  C = 1 mol/m3*t/1 s\n[side "
                             "x+] flow = outlet\n"
                             "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
#else
                             "[side x-] C = 1 mol/m3*t/1 s\n"
#endif
                             "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s * (1 - C/Csat)  Csat = 50 mol/m3\n"
                             "[run] until = 0.1 s\n[transfer m] reference_length = 1 um  surface = Csat  fluid = 0 "
                             "mol/m3\n[total t]\n";
static const char pit[] =
    "[grid] h = 1 um  m = 2  box = 0 .. 16 um" ACROSS("0", "8 um") "\n[side x-] flow = open\n"
    "[shape metal] box = 4 um .. 16 um" ACROSS("0", "8 um") "\n  kind = solid  material = steel304\n"
    "[corrode] rate = 0.5 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n[run] until = 2 s\n";

/* What the objects are built on. */
typedef struct lab {
    pd_ctx ctx;
    pd_setup of_pin, of_pit;
    pd_model pin, pit;
    pd_bonds bonds; /* with what walls do to a flow */
    pd_flow flow;
    pd_steady steady;   /* of that flow, with what steps in time need */
    pd_grid rings;
    pd_body body;
    pd_microelastic springs;
    pd_stencil_desc family;
    pd_stencil near;    /* m = 1 */
    pd_bonds near_bonds;
    pd_grid_desc box;
    pd_reactive water; /* of the pin */
    int wrong; /* arguments that are refused */
} lab;

static void make_box(lab *l)
{
    memset(&l->family, 0, sizeof l->family);
    memset(&l->box, 0, sizeof l->box);
    l->family.m = 2.0;
    for (int d = 0; d < PD_DIM; d++) {
        l->family.h[d] = 1e-6;
        l->box.hi[d] = 8e-6;
    }
    l->box.axisymmetric = PD_DIM == 2;
    if (PD_DIM == 2) l->box.side[2 * PD_DIM - 2] = PD_SIDE_MIRROR; /* the axis */
}

static pd_flow_desc stream(const lab *l)
{
    pd_flow_desc d;
    memset(&d, 0, sizeof d);
    d.rho = l->wrong ? -1.0 : 1000.0;
    d.mu = 1e-3;
    d.report_speed = 0.01;
    d.report_length = 1e-5;
    return d;
}

/* Points of a block of four cells along each axis. */
static pd_status make_body_of(pd_ctx *ctx, int wrong, pd_body *o)
{
    static double position[64 * PD_DIM], volume[64];
    pd_body_desc d;
    memset(&d, 0, sizeof d);
    d.count = PD_DIM == 1 ? 4 : PD_DIM == 2 ? 16 : 64;
    for (int k = 0; k < d.count * PD_DIM; k++) position[k] = (double)(k / PD_DIM >> 2 * (k % PD_DIM) & 3);
    for (int k = 0; k < d.count; k++) volume[k] = 1.0;
    d.position = position;
    d.volume = volume;
    d.horizon = wrong ? -1.0 : 2.0;
    d.spacing = 1.0;
    return pd_body_build(ctx, &d, o);
}

static pd_status make_springs_of(pd_ctx *ctx, lab *l, pd_microelastic *o)
{
    pd_microelastic_desc d;
    memset(&d, 0, sizeof d);
    d.young = l->wrong ? 0.0 : 1.0;
    return pd_microelastic_build(ctx, &l->body, &d, o);
}

/* [byte] that steps of an implicit flow need beside those of its steady solver. */
static size_t room_of_steps(pd_flow *flow)
{
    pd_implicit implicit;
    memset(&implicit, 0, sizeof implicit);
    implicit.flow = flow;
    return pdi_implicit_count_work_bytes(&implicit);
}

static int ready(lab *l)
{
    memset(l, 0, sizeof *l);
    pd_flow_desc still = stream(l);
    pd_steady_desc of_steady;
    pd_stencil_desc nearest;
    pd_image dot;
    memset(&nearest, 0, sizeof nearest);
    nearest.m = 1.0;
    for (int d = 0; d < PD_DIM; d++) nearest.h[d] = 1e-6;
    memset(&of_steady, 0, sizeof of_steady);
    memset(&dot, 0, sizeof dot);
    pd_ctx_init(&l->ctx);
    l->ctx.threads = 1;
    make_box(l);
    put("pin.scene", pin, sizeof pin - 1);
    put("pit.scene", pit, sizeof pit - 1);
    put("pit.csv", "x,y\n1,2\n", 8);
    put("points.csv", "x,y,z,volume\n1,2,3,4\n", 21);
    dot.width = dot.height = 1;
    dot.channels = 3;
    dot.pixels = (uint8_t *)"abc";
    CHECK_OK(&l->ctx, pd_png_write(&l->ctx, path_of("dot.png"), &dot));
    return CHECK_OK(&l->ctx, pd_scene_read(&l->ctx, path_of("pin.scene"), NULL, 0, &l->of_pin)) &&
           CHECK_OK(&l->ctx, pd_scene_read(&l->ctx, path_of("pit.scene"), NULL, 0, &l->of_pit)) &&
           CHECK_OK(&l->ctx, pd_model_build(&l->ctx, &l->of_pin, &l->pin)) &&
           CHECK_OK(&l->ctx, pd_model_build(&l->ctx, &l->of_pit, &l->pit)) &&
           CHECK_OK(&l->ctx, pd_bonds_build(&l->ctx, &l->pin.stencil, &l->pin.grid, 0, &l->bonds)) &&
           CHECK_OK(&l->ctx, pd_stencil_build(&l->ctx, &nearest, &l->near)) &&
           CHECK_OK(&l->ctx, pd_bonds_build(&l->ctx, &l->near, &l->pin.grid, 0, &l->near_bonds)) &&
           CHECK_OK(&l->ctx, pd_flow_build(&l->ctx, &l->pin.grid, &l->bonds, &still, &l->flow)) &&
           CHECK_OK(&l->ctx, pd_steady_build(&l->ctx, &l->flow, &of_steady, &l->steady)) &&
           CHECK_OK(&l->ctx, pdi_steady_build_stages(&l->ctx, &l->steady, room_of_steps(&l->flow))) &&
           CHECK_OK(&l->ctx, pd_grid_build(&l->ctx, &l->pin.stencil, &l->box, &l->rings)) &&
           CHECK_OK(&l->ctx, make_body_of(&l->ctx, 0, &l->body)) &&
           CHECK_OK(&l->ctx, make_springs_of(&l->ctx, l, &l->springs));
}

static void tidy(lab *l)
{
    pd_reactive_free(&l->ctx, &l->water);
    pd_microelastic_free(&l->ctx, &l->springs);
    pd_body_free(&l->ctx, &l->body);
    pd_grid_free(&l->ctx, &l->rings);
    pd_steady_free(&l->ctx, &l->steady);
    pd_bonds_free(&l->ctx, &l->near_bonds);
    pd_stencil_free(&l->ctx, &l->near);
    pd_flow_free(&l->ctx, &l->flow);
    pd_bonds_free(&l->ctx, &l->bonds);
    pd_model_free(&l->ctx, &l->pit);
    pd_model_free(&l->ctx, &l->pin);
    pd_setup_free(&l->ctx, &l->of_pit);
    pd_setup_free(&l->ctx, &l->of_pin);
    CHECK_INT(l->ctx.in_use, 0);
}

/* ---- the builds ---- */

/* BUILD(name) of the object `o` of its type, in the lab `l`, on another context; INNER(name): an internal build. */
#define BUILD(name, type) BUILD_AND(name, type, pd_##name##_free)
#define INNER(name, type) BUILD_AND(name, type, pdi_##name##_free)
#define BUILD_AND(name, type, free_fn) \
    static void free_##name(pd_ctx *ctx, void *object) { free_fn(ctx, (type *)object); } \
    static pd_status make_##name(pd_ctx *ctx, lab *l, type *o); \
    static pd_status build_##name(pd_ctx *ctx, lab *l, void *object) { return make_##name(ctx, l, (type *)object); } \
    static pd_status make_##name(pd_ctx *ctx, lab *l, type *o)

INNER(monotone_cubic, pd_monotone_cubic)
{
    static const double x[] = {0.0, 1.0, 2.0}, y[] = {1.0, 3.0, 4.0};
    return pd_monotone_cubic_build(ctx, x, y, l->wrong ? 1 : 3, 0, o);
}

BUILD(expr, pd_expr)
{
    pd_expr_desc d;
    memset(&d, 0, sizeof d);
    d.text = l->wrong ? "1 +" : "1 + 2";
    return pd_expr_build(ctx, &d, o);
}

INNER(text, pd_text)
{
    const char *bytes = l->wrong ? "[a" : "[a]\nb = 1\n";
    return pdi_text_build(ctx, "a", bytes, strlen(bytes), o);
}

BUILD(stencil, pd_stencil)
{
    pd_stencil_desc d = l->family;
    if (l->wrong) d.h[0] = -1.0;
    return pd_stencil_build(ctx, &d, o);
}

BUILD(grid, pd_grid)
{
    pd_grid_desc d = l->box;
    if (l->wrong) d.hi[0] = 0.3e-6;
    return pd_grid_build(ctx, &l->pin.stencil, &d, o);
}

INNER(ghosts, pd_ghosts) { return pdi_ghosts_build(ctx, &l->pin.grid, o); }
INNER(axisym, pd_axisym) { return pdi_axisym_build(ctx, &l->pin.stencil, &l->rings, o); }
BUILD(bonds, pd_bonds) { return pd_bonds_build(ctx, &l->pin.stencil, &l->pin.grid, 0, o); }
BUILD(csr, pd_csr)
{
    pd_csr_desc d;
    memset(&d, 0, sizeof d);
    if (l->wrong) d.op = PD_CSR_DIFFUSE; /* without a diffusivity */
    return pd_csr_build(ctx, &l->pin.bonds, &d, o);
}

BUILD(lattice, pd_lattice)
{
    pd_lattice_desc d;
    d.stencil = l->family;
    d.grid = l->box;
    if (l->wrong) d.stencil.h[0] = -1.0;
    return pd_lattice_build(ctx, &d, o);
}

BUILD(grain, pd_grain)
{
    pd_grain_desc d;
    memset(&d, 0, sizeof d);
    d.size = l->wrong ? -1.0 : 3e-6;
    d.spread = 0.3e-6;
    d.boundary_width = 0.5e-6;
    return pd_grain_build(ctx, &l->pin.grid, &d, o);
}

BUILD(krylov, pd_krylov)
{
    pd_krylov_desc d;
    memset(&d, 0, sizeof d);
    d.n = l->wrong ? 0 : 20;
    return pd_krylov_build(ctx, &d, o);
}

INNER(multigrid, pd_multigrid)
{
    pd_multigrid_desc d;
    memset(&d, 0, sizeof d);
    for (int k = 0; k < PD_DIM; k++) {
        d.n[k] = l->wrong ? 0 : 8;
        d.stride[k] = k == 0 ? 1 : 8 * d.stride[k - 1];
    }
    d.high_contrast = 1;
    return multigrid_build(ctx, &d, o);
}

INNER(front, pd_front)
{
    return pdi_front_build(ctx, &l->pin.stencil, l->wrong ? (pd_kernel)17 : PD_KERNEL_SQUARE, PD_WEIGHTS_CALIBRATED, o);
}

BUILD(flow, pd_flow)
{
    pd_flow_desc d = stream(l);
    return pd_flow_build(ctx, &l->pin.grid, &l->bonds, &d, o);
}

INNER(fourth_order, pd_fourth_order) { return pdi_fourth_order_build(ctx, l->wrong ? &l->bonds : &l->near_bonds, o); }

BUILD(steady, pd_steady)
{
    pd_steady_desc d;
    memset(&d, 0, sizeof d);
    d.tolerance = l->wrong ? -1.0 : 0.0;
    return pd_steady_build(ctx, &l->flow, &d, o);
}

BUILD(implicit, pd_implicit)
{
    pd_implicit_desc d;
    memset(&d, 0, sizeof d);
    d.rtol = l->wrong ? -1.0 : 0.0;
    return pd_implicit_build(ctx, &l->flow, &l->steady, &d, o);
}

BUILD(weakly_compressible, pd_weakly_compressible)
{
    pd_weakly_compressible_desc d;
    memset(&d, 0, sizeof d);
    d.sound_speed = l->wrong ? -1.0 : 1.0;
    return pd_weakly_compressible_build(ctx, &l->flow, &d, o);
}

BUILD(gas, pd_gas)
{
    pd_gas_desc d;
    memset(&d, 0, sizeof d);
    d.gamma = l->wrong ? 0.5 : 1.4;
    d.spatial_order = PD_GAS_SECOND;
    return pd_gas_build(ctx, &l->pin.grid, &l->pin.bonds, &d, o);
}

INNER(diffusion, pd_diffusion)
{
    pd_diffusion_desc d;
    memset(&d, 0, sizeof d);
    d.diffusivity = l->wrong ? -1.0 : 1e-9;
    return pdi_diffusion_build(ctx, &l->pin.bonds, &d, o);
}

BUILD(transport, pd_transport)
{
    pd_transport_desc d;
    memset(&d, 0, sizeof d);
    d.diffusivity = l->wrong ? -1.0 : 1e-9;
    return pd_transport_build(ctx, &l->pin.grid, &l->bonds, &l->flow, &d, o);
}

BUILD(two_stage, pd_two_stage)
{
    pd_two_stage_desc d;
    memset(&d, 0, sizeof d);
    d.rtol = l->wrong ? -1.0 : 0.0;
    return pd_two_stage_build(ctx, &l->pin.transport, &d, o);
}

BUILD(dissolve, pd_dissolve)
{
    pd_dissolve_desc d = l->pin.dissolve.desc;
    if (l->wrong) d.solid = -1.0;
    return pd_dissolve_build(ctx, &l->pin.grid, &l->pin.stencil, &l->pin.transport, &d, o);
}

/* The same build with bonds across the front. */
static void pd_bonds_of_metal_free(pd_ctx *ctx, pd_dissolve *dissolve) { pd_dissolve_free(ctx, dissolve); }
BUILD(bonds_of_metal, pd_dissolve)
{
    pd_dissolve_desc d = l->pit.dissolve.desc;
    d.threshold = 0.0;
    d.stochastic = 1;
    d.repassivation = 0.1 * d.saturation;
    if (l->wrong) d.rtol = -1.0;
    return pd_dissolve_build(ctx, &l->pit.grid, &l->pit.stencil, &l->pit.transport, &d, o);
}

BUILD(step_diagnostics, pd_step_diagnostics) { return pd_step_diagnostics_build(ctx, &l->pit, o); }

static void pd_time_loop_free(pd_ctx *ctx, pd_time_loop *couple) { (void)ctx, (void)couple; }

BUILD(time_loop, pd_time_loop)
{
    pd_time_loop_desc d;
    memset(&d, 0, sizeof d);
    d.fraction = l->wrong ? -1.0 : 0.0;
    return pd_time_loop_build(ctx, &d, &l->pin.grid, &l->pin.bonds, o);
}

static void pd_inlet_free(pd_ctx *ctx, pd_inlet *inlet)
{
    (void)ctx;
    (void)inlet;
}

BUILD(inlet, pd_inlet)
{
    pd_status status = pdi_inlet_build(ctx, &l->of_pin, &l->pin.grid, o);
    if (status < 0) o->error_side = 0; /* the side that is refused */
    return status;
}

static void pd_coarsen_setup_free(pd_ctx *ctx, pd_coarsened_setup *coarser)
{
    (void)ctx;
    (void)coarser;
}

BUILD(coarsen_setup, pd_coarsened_setup) { return pdi_coarsen_setup_build(ctx, &l->of_pit, l->wrong ? 3 : 2, o); }

BUILD(model, pd_model)
{
    pd_status status = pd_model_build(ctx, &l->of_pin, o);
    if (status < 0) o->error_line = 0; /* of the scene: what is refused */
    return status;
}

INNER(monitors, pd_monitors)
{
    pd_status status = pdi_monitors_build(ctx, &l->pin, o);
    if (status < 0) o->error_line = 0;
    return status;
}

INNER(input_step_limit, pd_input_step_limit) { return pdi_input_step_limit_build(ctx, &l->of_pin, o); }
BUILD(depletion_notes, pd_depletion_notes) { return pd_depletion_notes_build(ctx, &l->pin, o); }

INNER(compare_measured, pd_measured_comparison)
{
    pd_status status = pdi_compare_measured_build(ctx, &l->pin, NULL, NULL, 0, o); /* a scene without measured points */
    if (status < 0) o->error_line = 0;
    return status;
}

BUILD(body, pd_body) { return make_body_of(ctx, l->wrong, o); }
BUILD(correspondence, pd_correspondence)
{
    pd_correspondence_desc d;
    memset(&d, 0, sizeof d);
    d.young = l->wrong ? 0.0 : 1.0;
    return pd_correspondence_build(ctx, &l->body, &d, o);
}

BUILD(ordinary_state, pd_ordinary_state)
{
    pd_ordinary_state_desc d;
    memset(&d, 0, sizeof d);
    d.young = l->wrong ? 0.0 : 1.0;
    return pd_ordinary_state_build(ctx, &l->body, &d, o);
}

BUILD(bond_failure, pd_bond_failure)
{
    pd_bond_failure_desc d;
    memset(&d, 0, sizeof d);
    d.critical = l->wrong ? -1.0 : 1.0;
    pd_material_interface solid = pd_microelastic_material(&l->springs);
    return pd_bond_failure_build(ctx, &solid, &d, o);
}

INNER(coarse_fe_precond, pd_coarse_fe_precond) { return pdi_coarse_fe_precond_build(ctx, &l->body, o); }

BUILD(finite_strain, pd_finite_strain)
{
    pd_finite_strain_desc d;
    memset(&d, 0, sizeof d);
    d.law.kind = PD_FINITE_STRAIN_J2;
    d.law.young = 1.0;
    d.law.yield = l->wrong ? 0.0 : 1.0;
    return pd_finite_strain_build(ctx, &l->body, &d, o);
}

BUILD(microelastic, pd_microelastic) { return make_springs_of(ctx, l, o); }

BUILD(verlet, pd_verlet)
{
    pd_verlet_desc d;
    memset(&d, 0, sizeof d);
    d.density = l->wrong ? -1.0 : 1.0;
    pd_material_interface solid = pd_microelastic_material(&l->springs);
    return pd_verlet_build(ctx, &solid, &d, o);
}

static pd_status no_load(pd_ctx *ctx, void *user, double t, double *u, double *load)
{
    (void)ctx, (void)user, (void)t, (void)u, (void)load;
    return PD_OK;
}

BUILD(sequentially_linear, pd_sequentially_linear)
{
    static const double load[1] = {0.0}; /* which a build does not read */
    pd_sequentially_linear_desc d;
    pd_material_interface solid = pd_microelastic_material(&l->springs);
    memset(&d, 0, sizeof d);
    solid.linear = 1; /* of small displacements */
    d.load = load;
    d.criterion.critical = l->wrong ? -1.0 : 1e-3;
    return pd_sequentially_linear_build(ctx, &solid, &d, o);
}

BUILD(quasi_static, pd_quasi_static)
{
    pd_quasi_static_desc d;
    memset(&d, 0, sizeof d);
    d.load = no_load;
    d.criterion.critical = l->wrong ? -1.0 : 0.0;
    pd_material_interface solid = pd_microelastic_material(&l->springs);
    return pd_quasi_static_build(ctx, &solid, &d, o);
}

BUILD(solid_coupling, pd_solid_coupling)
{
    static const double corner[] = {
#if PD_DIM == 1
        8e-6
#elif PD_DIM == 2
        6e-6, 4e-6, 8e-6, 4e-6
#else
        6e-6, 4e-6, 3e-6, 8e-6, 4e-6, 3e-6, 8e-6, 4e-6, 5e-6, 6e-6, 4e-6, 5e-6
#endif
    };
    const pd_solid_coupling_precrack cut = {"notch", PD_DIM == 3 ? 4 : PD_DIM, corner};
    pd_solid_coupling_desc d;
    memset(&d, 0, sizeof d);
    d.horizon_ratio = 2.0;
    d.elastic.young = l->wrong ? 0.0 : 1.0;
    d.load = no_load;
    d.cuts = &cut;
    d.cut_count = 1;
    return pd_solid_coupling_build(ctx, &l->pin.grid, &d, o);
}

BUILD(parameter_sweep, pd_parameter_sweep)
{
    static const char *axes[] = {"until=1 s, 2 s"}, *wrong[] = {"until="};
    pd_parameter_sweep_desc d;
    memset(&d, 0, sizeof d);
    d.scene = path_of("pin.scene");
    d.axes = l->wrong ? wrong : axes;
    d.axis_count = 1;
    return pd_parameter_sweep_build(ctx, &d, o);
}

/* ---- what is read from files ---- */

BUILD(setup, pd_setup)
{
    return pd_scene_read(ctx, path_of(l->wrong ? "pit.csv" : "pin.scene"), NULL, 0, o);
}

/* The same from a text. */
static void pd_scene_free(pd_ctx *ctx, pd_setup *setup) { pd_setup_free(ctx, setup); }
BUILD(scene, pd_setup) { return pd_scene_parse(ctx, "pin", l->wrong ? "no scene" : pin, NULL, 0, o); }

BUILD(table, pd_table) { return pd_table_read(ctx, path_of(l->wrong ? "none.csv" : "pit.csv"), o); }

BUILD(facets, pd_facets)
{
    static const double corner[36] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                      0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    return pd_facets_build(ctx, corner, l->wrong ? 3 : 4, o);
}

BUILD(points, pd_points) { return pd_points_read(ctx, path_of(l->wrong ? "pit.csv" : "points.csv"), 1.0, o); }

BUILD(image, pd_image) { return pd_png_read(ctx, path_of(l->wrong ? "pit.csv" : "dot.png"), o); }

/* Takes no memory. */
static void pd_speciation_free(pd_ctx *ctx, pd_speciation *s)
{
    (void)ctx;
    memset(s, 0, sizeof *s);
}
/* Water, its ions and the reaction of them; forward 0: in equilibrium. */
static pd_status make_water(pd_ctx *ctx, double forward, pd_species *species, pd_reaction *reaction)
{
    static const pd_species_desc desc[3] = {{"H2O", 0, 0, 0, 0}, {"H+", 0, 0, 0, 9e-9}, {"OH-", 0, 0, 0, 5e-9}};
    pd_reaction_desc water;
    memset(&water, 0, sizeof water);
    water.name = "water";
    water.text = "H2O = H+ + OH-";
    water.k = -14.0;
    water.k_unit = "log10";
    water.forward = forward;
    water.forward_unit = "mol/L/s";
    for (int k = 0; k < 3; k++) PD_TRY(pd_species_read(ctx, &desc[k], &species[k]));
    return pd_reaction_read(ctx, &water, species, 3, reaction);
}

BUILD(speciation, pd_speciation)
{
    pd_species species[3];
    pd_reaction reaction;
    PD_TRY(make_water(ctx, 0.0, species, &reaction));
    int count = l->wrong ? PD_SPECIES_MAX + 1 : 3;
    return pd_speciation_build(ctx, species, count, &reaction, 1, PD_ACTIVITY_IDEAL, 298.15, o);
}

BUILD(reactive, pd_reactive)
{
    double initial[3] = {55344.0, 1e-4, 1e-4};
    pd_species species[3];
    pd_reaction reaction;
    pd_reactive_desc d;
    PD_TRY(make_water(ctx, 1e-3, species, &reaction));
    memset(&d, 0, sizeof d);
    d.species = species;
    d.count = 3;
    d.reactions = &reaction;
    d.reaction_count = 1;
    d.initial = initial;
    d.tolerance = l->wrong ? -1.0 : 0.0;
    return pd_reactive_build(ctx, &l->pin.grid, &l->bonds, PD_DIM > 1 ? &l->flow : NULL, &d, o);
}

BUILD(course, pd_course)
{
    pd_course_desc d;
    if (!l->water.c) PD_TRY(make_reactive(&l->ctx, l, &l->water)); /* that of the lab, once */
    memset(&d, 0, sizeof d);
    d.rtol = l->wrong ? -1.0 : 0.0;
    return pd_course_build(ctx, &l->water, &d, o);
}

static double etching(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    (void)user, (void)node, (void)c, (void)phi, (void)t;
    return 1e-9 * ph;
}

BUILD(etch, pd_etch)
{
    pd_etch_desc d;
    if (!l->water.c) PD_TRY(make_reactive(&l->ctx, l, &l->water));
    memset(&d, 0, sizeof d);
    d.law = l->wrong ? NULL : etching;
    return pd_etch_build(ctx, &l->water, &d, o);
}

BUILD(electrode, pd_electrode)
{
    static const double u[3] = {-1.0, 0.0, 1.0}, i[3] = {-2.0, 0.0, 3.0};
    pd_electrode_term term;
    pd_electrode_desc d;
    memset(&term, 0, sizeof term);
    memset(&d, 0, sizeof d);
    term.kind = PD_ELECTRODE_TABLE;
    term.points = l->wrong ? 1 : 3;
    term.potential = u;
    term.current = i;
    d.term = &term;
    d.count = 1;
    return pd_electrode_build(ctx, &d, o);
}

BUILD(potential, pd_potential)
{
    static const pd_circuit free_one = {PD_CIRCUIT_CURRENT, 0.0};
    static pd_electrode ideal; /* without terms there is nothing to build */
    pd_potential_desc d;
    memset(&d, 0, sizeof d);
    d.conductivity = l->wrong ? 0.0 : 1.0;
    d.electrode = &ideal;
    d.electrodes = 1;
    d.circuit = &free_one;
    d.circuits = 1;
    return pd_potential_build(ctx, &l->pit.grid, &l->pit.bonds, &d, o);
}

/* ---- all of them ---- */

typedef struct entry {
    const char *name;
    size_t size;
    pd_status (*build)(pd_ctx *ctx, lab *l, void *object);
    void (*free)(pd_ctx *ctx, void *object);
    int refuses, takes; /* has arguments that it refuses; takes memory */
} entry;

#define ROW(name, type, refuses, takes) {#name, sizeof(type), build_##name, free_##name, refuses, takes},
static const entry builds[] = {
    ROW(sequentially_linear, pd_sequentially_linear, 1, 1) ROW(weakly_compressible, pd_weakly_compressible, 1, 1)
    ROW(compare_measured, pd_measured_comparison, 0, 0) ROW(coarse_fe_precond, pd_coarse_fe_precond, 0, 1)
    ROW(step_diagnostics, pd_step_diagnostics, 0, 1) ROW(input_step_limit, pd_input_step_limit, 0, 1)
    ROW(depletion_notes, pd_depletion_notes, 0, 1) ROW(parameter_sweep, pd_parameter_sweep, 1, 1) ROW(csr, pd_csr, 1, 1)
    ROW(monotone_cubic, pd_monotone_cubic, 1, 1) ROW(coarsen_setup, pd_coarsened_setup, 1, 1) ROW(bonds, pd_bonds, 0, 1)
    ROW(solid_coupling, pd_solid_coupling, 1, 1) ROW(ordinary_state, pd_ordinary_state, 1, 1) ROW(front, pd_front, 1, 1)
    ROW(correspondence, pd_correspondence, 1, 1) ROW(finite_strain, pd_finite_strain, 1, 1) ROW(krylov, pd_krylov, 1, 1)
    ROW(microelastic, pd_microelastic, 1, 1) ROW(quasi_static, pd_quasi_static, 1, 1) ROW(multigrid, pd_multigrid, 1, 1)
    ROW(fourth_order, pd_fourth_order, 1, 1) ROW(bond_failure, pd_bond_failure, 1, 1) ROW(diffusion, pd_diffusion, 1, 1)
    ROW(axisym, pd_axisym, 0, PD_DIM == 2) ROW(bonds_of_metal, pd_dissolve, 1, 1) ROW(ghosts, pd_ghosts, 0, PD_DIM > 1)
    ROW(speciation, pd_speciation, 1, 0) ROW(transport, pd_transport, 1, 1) ROW(electrode, pd_electrode, 1, 1)
    ROW(two_stage, pd_two_stage, 1, 1) ROW(potential, pd_potential, 1, 1) ROW(time_loop, pd_time_loop, 1, 0)
    ROW(reactive, pd_reactive, 1, 1) ROW(implicit, pd_implicit, 1, 1) ROW(dissolve, pd_dissolve, 1, 1)
    ROW(monitors, pd_monitors, 0, 1) ROW(stencil, pd_stencil, 1, 1) ROW(lattice, pd_lattice, 1, 1)
    ROW(steady, pd_steady, 1, 1) ROW(verlet, pd_verlet, 1, 1) ROW(facets, pd_facets, 1, 1) ROW(points, pd_points, 1, 1)
    ROW(course, pd_course, 1, 1) ROW(grain, pd_grain, 1, 1) ROW(inlet, pd_inlet, 0, 0) ROW(model, pd_model, 0, 1)
    ROW(setup, pd_setup, 1, 1) ROW(scene, pd_setup, 1, 1) ROW(table, pd_table, 1, 1) ROW(image, pd_image, 1, 1)
    ROW(text, pd_text, 1, 1) ROW(expr, pd_expr, 1, 1) ROW(grid, pd_grid, 1, 1) ROW(flow, pd_flow, 1, 1)
    ROW(body, pd_body, 1, 1) ROW(etch, pd_etch, 1, 1) ROW(gas, pd_gas, 1, 1)
};
#undef ROW
enum { BUILDS = (int)(sizeof builds / sizeof builds[0]), OTHERS = 7 };

static int all_zero(const void *object, size_t size)
{
    const unsigned char *bytes = (const unsigned char *)object;
    for (size_t k = 0; k < size; k++)
        if (bytes[k]) return 0;
    return 1;
}

/* Builds it with call n failing (0: none) in an object of garbage; returns the status. */
static pd_status once(const entry *e, lab *l, void *object, long n, long *calls)
{
    fault f;
    pd_ctx ctx;
    fault_context(&f, n, 0, &ctx);
    memset(object, 0x5a, e->size);
    pd_status status = e->build(&ctx, l, object);
    *calls = f.calls;
    if (status < 0) {
        int clean = f.live == 0 && f.wrong == 0 && ctx.in_use == 0 && all_zero(object, e->size);
        if (!CHECK(clean && ctx.status == status && ctx.message[0]))
            NOTE("%s: call %ld: %ld blocks left, %s", e->name, n, f.live,
                 all_zero(object, e->size) ? "zeros" : "an object that is not zero");
        if (!clean) return status;
    }
    for (int twice = 0; twice < 2; twice++) e->free(&ctx, object);
    if (!CHECK(f.live == 0 && f.wrong == 0 && ctx.in_use == 0)) NOTE("%s: call %ld", e->name, n);
    return status;
}

TEST(a_failed_build_leaves_nothing)
{
    static lab l;
    if (!ready(&l)) return;
    for (const entry *e = builds; e < builds + BUILDS; e++) {
        void *object = malloc(e->size);
        long calls, first;
        if (!CHECK(object != NULL)) return;
        if (!CHECK(once(e, &l, object, 0, &first) == PD_OK)) NOTE("%s: %s", e->name, l.ctx.message);
        if (!CHECK((first > 0) == e->takes)) NOTE("%s: %ld calls", e->name, first);
        for (long n = 1; n <= first && n < 400; n++)
            if (!CHECK_INT(once(e, &l, object, n, &calls), PD_ERR_MEMORY)) break;
        l.wrong = 1;
        if (e->refuses) CHECK(once(e, &l, object, 0, &calls) < 0);
        l.wrong = 0;
        free(object);
    }
    tidy(&l);
}

/* Internal builds of parts: they fail with the object that they are part of, whose build is tried. */
static const char *const parts[] = {"array_registry", "jacobian", "stability", "open_boundary", "bond_diffusivity",
                                    "active_range", "flux", "fingerprint", "compact_operator", "limiter", "inverse",
                                    "point_batch", "bond_force", "bond_path", "bond_weights", "pictures", "components",
                                    "surface_nets", "renderer", "surface_view", "electrolyte", "dissolution_laws",
                                    "mineral", "cell", "electrode_map", "gas_wall", "mirror_symmetry",
                                    "interpenetration", "species_electrodes", "coat", "surface_states",
                                    "mechanical_bc", "visibility"};

/* How many functions `pd_status pd_X_build(` or `pd_status pdi_X_build(` a header has; each must be tried. */
static int builds_of(const char *path)
{
    char line[300], name[80];
    int found = 0;
    FILE *header = fopen(path, "r");
    while (header && fgets(line, sizeof line, header)) {
        if (sscanf(line, "PD_API pd_status pd_%79[a-z_](", name) != 1 &&
            sscanf(line, "PDI_FN pd_status pdi_%79[a-z_](", name) != 1)
            continue;
        size_t length = strlen(name);
        if (length < 7 || strcmp(name + length - 6, "_build") != 0) continue;
        name[length - 6] = '\0';
        int known = 0, part = 0;
        for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++) part = part || strcmp(parts[k], name) == 0;
        if (part) continue;
        for (int k = 0; k < BUILDS; k++) known = known || strcmp(builds[k].name, name) == 0;
        if (!CHECK(known)) NOTE("the build %s of %s is not tried", name, path);
        found++;
    }
    if (header) fclose(header);
    return found;
}

TEST(no_build_is_left_out)
{
    char line[4000], room[80], path[240], module[80];
    int found = 0, size;
    FILE *list = fopen("src/MODULES", "r");
    if (!list) SKIP("src/MODULES is not below the current folder");
    while (fgets(line, sizeof line, list)) {
        const char *at = line;
        if (line[0] == '#' || sscanf(at, "%79s%n", room, &size) != 1) continue;
        for (at += size; sscanf(at, "%79s%n", module, &size) == 1; at += size) {
            snprintf(path, sizeof path, "src/%s/%s.h", room, module);
            found += builds_of(path);
        }
    }
    fclose(list);
    CHECK_INT(found, BUILDS - OTHERS);
}

TEST_MAIN(ENTRY(a_failed_build_leaves_nothing) ENTRY(no_build_is_left_out))
