/* read_param_file: see read_param_file.h */
#include "scene/read_param_file.h"
#include "io/file.h"
#include "scene/input_files.h"
#include "scene/key_value.h"
#include "setup/fields.h"
#include "scene/override.h"
#include "core/vec.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_READ_PARAM_FILE_FRAMES 20.0 /* pictures of a run */

/* One line a number: name, default as in the original file, smallest and largest admissible value, 1: that bound
 * itself is refused. */
#define PDI_READ_PARAM_FILE_NUMBERS(X) \
    X(dx, "5e-6", 0.0, 1.0, 1) \
    X(m_ratio, "3", 1.0, 6.0, 0) \
    X(R_wire, "40e-6", 0.0, 1.0, 0) \
    X(L_wire, "400e-6", 0.0, 1.0, 0) \
    X(R_tube, "150e-6", 0.0, 1.0, 1) \
    X(L_upstream, "500e-6", 0.0, 1.0, 1) \
    X(L_downstream, "500e-6", 0.0, 1.0, 1) \
    X(rho_f, "1000", 0.0, 1e6, 1) \
    X(mu_f, "1e-3", 0.0, 1e6, 1) \
    X(Q_flow, "1.667e-8", 0.0, 1.0, 0) \
    X(rho_m, "1738", 0.0, 1e6, 1) \
    X(D_liquid, "1e-9", 0.0, 1.0, 0) \
    X(C_solid_init, "1", 0.0, 1.0, 1) \
    X(C_liquid_init, "0", 0.0, 1.0, 0) \
    X(C_thresh, "0.2", 0.0, 0.99, 0) \
    X(grain_size_mean, "40e-6", 0.0, 1.0, 0) \
    X(grain_size_std, "5e-6", 0.0, 1.0, 0) \
    X(gb_width_cells, "0", 0.0, 100.0, 0) \
    X(k_corr, "1e-3", 0.0, 1e6, 0) \
    X(gb_corr_factor, "3", 0.0, 1e6, 0) \
    X(flow_conv_tol, "5e-6", 0.0, 0.1, 1) \
    X(T_final, "10", 0.0, 1e12, 1) \
    X(D_grain, "5e-11", 0.0, 1.0, 0) \
    X(D_gb, "5e-9", 0.0, 1.0, 0) \
    X(C_sat, "0", 0.0, 1.0, 0) \
    X(axisymmetric, "0", 0.0, 1.0, 0)

/* All numbers of the file. */
typedef struct pdi_read_param_file_values {
#define PDI_X(key, fallback, low, high, open) double key;
    PDI_READ_PARAM_FILE_NUMBERS(PDI_X)
#undef PDI_X
    double dx_file; /* [m] dx before overrides */
    int by_diffusion; /* 1: without k_corr the metal dissolves by diffusion bonds across its surface */
} pdi_read_param_file_values;

/* Keys that are read and have no effect, and why. */
static const char *const pdi_read_param_file_ignored_keys[][2] = {
    {"w_advect", "the advection scheme is limited and needs no blend"},
    {"alpha_art_diff", "the advection scheme needs no artificial diffusion"},
    {"gamma_eos", "only for the weakly compressible solver"},
    {"c0", "only for the weakly compressible solver"},
    {"eta_density", "only for the weakly compressible solver"},
    {"cfl_factor", "only for explicit steppers"},
    {"cfl_factor_corr", "only for explicit steppers"},
    {"flow_max_iters", "a count of explicit steps; the flow is solved by Newton's method"},
    {"corrosion_steps_per_check", "a count of explicit steps; steps are chosen by error control"},
    {"output_every_flow", "a count of explicit steps; output is spread over the run"},
    {"output_every_corr", "a count of explicit steps; output is spread over the run"},
    {"use_amr", "one lattice of dx holds everywhere"},
    {"amr_ratio", "one lattice of dx holds everywhere"},
    {"amr_buffer", "one lattice of dx holds everywhere"},
    {"D_precip", "precipitates are not modelled; they dissolve like the grain around them"},
    {"precip_fraction", "precipitates are not modelled"},
    {"precip_cluster_cells", "precipitates are not modelled"},
    {"corrosion_decay_l", "the rate does not fall with the loss, there by 10^(-loss/l)"},
    {"use_implicit", "steps are implicit, chosen by error control"},
    {"implicit_dt_fraction", "steps are chosen by error control"},
    {"implicit_dt_max", "steps are chosen by error control"},
    {"implicit_output_every", "a count of steps; output is spread over the run"},
    {"diagnostic_every", "a count of steps; diagnostics have a row for each"},
    {"newton_tol", "the transport is solved to the rounding of the ledger"},
    {"newton_max_iter", "the transport is solved to the rounding of the ledger"},
    {"channel_flow_corrections", "walls and openings are of second order without corrections"}};

/* Read a number in low .. high; open 1: low itself is refused. PD_ERR_ARGUMENT: out of bounds. */
static pd_status pdi_read_param_file_number(pd_ctx *ctx, pd_text *text, const char *key, const char *fallback,
                                            double low, double high, int open, double *value)
{
    pd_key row;
    memset(&row, 0, sizeof row);
    row.keys = key;
    row.type = PD_KEY_NUMBER;
    row.unit = "-";
    row.low = low;
    row.high = high;
    row.low_is_open = open;
    PD_TRY(pdi_text_get_number(ctx, text, 0, key, "", fallback, value));
    return pdi_key_value_check_bounds(ctx, text, 0, &row, *value);
}

/* Read all numbers of PDI_READ_PARAM_FILE_NUMBERS. */
static pd_status pdi_read_param_file_numbers(pd_ctx *ctx, pd_text *text, pdi_read_param_file_values *f)
{
#define PDI_X(key, fallback, low, high, open) \
    PD_TRY(pdi_read_param_file_number(ctx, text, #key, fallback, low, high, open, &f->key));
    PDI_READ_PARAM_FILE_NUMBERS(PDI_X)
#undef PDI_X
    return PD_OK;
}

/* Add a note for each key that is given and has no effect; such a key must still be a number. D_grain and D_gb have
 * none where k_corr gives the rate. */
static pd_status pdi_read_param_file_add_notes(pd_ctx *ctx, pd_text *text, const pdi_read_param_file_values *f,
                                               pd_setup *setup)
{
    double value;
    if (pdi_text_has_key(ctx, text, 0, "D_grain") && !f->by_diffusion)
        pd_setup_add_note(setup, "D_grain = %g is ignored: k_corr gives the rate", f->D_grain);
    if (pdi_text_has_key(ctx, text, 0, "D_gb") && !f->by_diffusion)
        pd_setup_add_note(setup, "D_gb = %g is ignored: gb_corr_factor gives that of the boundaries", f->D_gb);
    for (size_t k = 0; k < sizeof pdi_read_param_file_ignored_keys / sizeof pdi_read_param_file_ignored_keys[0]; k++) {
        const char *key = pdi_read_param_file_ignored_keys[k][0];
        if (!pdi_text_has_key(ctx, text, 0, key)) continue;
        PD_TRY(pdi_text_get_number(ctx, text, 0, key, "", NULL, &value));
        pd_setup_add_note(setup, "%s = %g is ignored: %s", key, value, pdi_read_param_file_ignored_keys[k][1]);
    }
    return PD_OK;
}

/* Set box, spacing, horizons and geometry; in 3D the box bounds the tube, rounded up to whole cells. An axisymmetric
 * box starts at y = 0, where the side becomes a mirror. PD_ERR_ARGUMENT: no whole number of cells within 1e-6 along x
 * or, in 2D, y, 1e9 cells or more, or axisymmetric other than 0, or 1 in 2D. */
static pd_status pdi_read_param_file_box(pd_ctx *ctx, const pd_text *text, const pdi_read_param_file_values *f,
                                         pd_setup *setup)
{
    double length = f->L_upstream + f->L_wire + f->L_downstream, cells = length / f->dx, across = f->R_tube / f->dx;
    double half = PD_DIM == 3 ? ceil(across - 1e-6) * f->dx : f->R_tube, width = f->axisymmetric > 0.0 ? 1.0 : 2.0;
    if (!(cells < 1e9) || !(across < 1e9))
        return pdi_text_fail_key(ctx, text, 0, "dx", "found %.3g and %.3g cells, expected fewer than 1e9 on an axis",
                                 cells, 2.0 * across);
    if (fabs(cells - floor(cells + 0.5)) > 1e-6)
        return pdi_text_fail_key(ctx, text, 0, "dx",
                                 "L_upstream + L_wire + L_downstream are %.6g cells, expected a whole number"
                                 " of them",
                                 cells);
    if (PD_DIM == 2 && fabs(width * across - floor(width * across + 0.5)) > 1e-6)
        return pdi_text_fail_key(ctx, text, 0, "dx", "%sR_tube %s %.6g cells, expected a whole number of them",
                                 width > 1.0 ? "2 " : "", width > 1.0 ? "are" : "is", width * across);
    for (int d = 0; d < PD_DIM; d++) {
        setup->h[d] = f->dx;
        setup->lo[d] = d == 0 ? -f->L_upstream : -half;
        setup->hi[d] = d == 0 ? f->L_wire + f->L_downstream : half;
    }
    setup->fluid_m = setup->metal_m = f->m_ratio;
    if (!(f->axisymmetric > 0.0)) return PD_OK;
    if (PD_DIM != 2 || f->axisymmetric < 1.0)
        return pdi_text_fail_key(ctx, text, 0, "axisymmetric", "found %g in %dD, expected 0, or 1 in 2D",
                                 f->axisymmetric, PD_DIM);
    setup->axisymmetric = 1;
    setup->lo[PD_DIM - 1] = 0.0;
    setup->side[2 * (PD_DIM - 1)].kind = PD_SIDE_MIRROR;
    return PD_OK;
}

/* Make *shape a cylinder along x through the origin; radius [m]. */
static void pdi_read_param_file_init_cylinder(double radius, pd_shape *shape)
{
    memset(shape, 0, sizeof *shape);
    shape->type = PD_SHAPE_CYLINDER;
    shape->radius = radius;
}

/* Add the shapes: tube wall (3D) as setup->wall, and the wire (in 2D a slab) as setup->solid. No wire where R_wire or
 * L_wire is 0. PD_ERR_ARGUMENT: R_wire is not below R_tube. */
static pd_status pdi_read_param_file_shapes(pd_ctx *ctx, const pd_text *text, const pdi_read_param_file_values *f,
                                            pd_setup *setup)
{
    pd_shape shape;
    if (PD_DIM == 3) {
        pdi_read_param_file_init_cylinder(f->R_tube, &shape);
        PD_TRY(pd_setup_add_shape(ctx, setup, &shape, &setup->wall));
        PD_TRY(pd_setup_add_complement(ctx, setup, &setup->wall));
    }
    if (!(f->R_wire > 0.0) || !(f->L_wire > 0.0)) return PD_OK;
    if (f->R_wire >= f->R_tube)
        return pdi_text_fail_key(ctx, text, 0, "R_wire", "found %.6g, expected less than R_tube = %.6g", f->R_wire,
                                 f->R_tube);
    memset(&shape, 0, sizeof shape);
    shape.type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        shape.a[d] = d == 0 ? 0.0 : -f->R_wire;
        shape.b[d] = d == 0 ? f->L_wire : f->R_wire;
    }
    PD_TRY(pd_setup_add_shape(ctx, setup, &shape, &setup->solid));
    if (PD_DIM < 3) return PD_OK;
    int piece = setup->solid, wire = -1;
    pdi_read_param_file_init_cylinder(f->R_wire, &shape);
    PD_TRY(pd_setup_add_shape(ctx, setup, &shape, &wire));
    memset(&shape, 0, sizeof shape);
    shape.type = PD_SHAPE_INTERSECT;
    shape.child_count = 2;
    shape.child[0] = piece;
    shape.child[1] = wire;
    return pd_setup_add_shape(ctx, setup, &shape, &setup->solid);
}

/* Set the flow: parabolic inlet of mean speed Q_flow/(pi R_tube^2), outlet, steady tolerance, with a note on the
 * latter. Q_flow = 0: no flow. */
static void pdi_read_param_file_flow(const pdi_read_param_file_values *f, pd_setup *setup)
{
    setup->has_flow = f->Q_flow > 0.0;
    if (!setup->has_flow) return;
    setup->rho = f->rho_f;
    setup->mu = f->mu_f;
    setup->steady_tolerance = f->flow_conv_tol;
    setup->side[0].kind = PD_SIDE_INLET;
    setup->side[0].profile = PD_PROFILE_PARABOLA;
    setup->side[0].mean_speed = f->Q_flow / (PD_PI * f->R_tube * f->R_tube);
    setup->side[1].kind = PD_SIDE_OUTLET;
    pd_setup_add_note(setup, "flow_conv_tol = %g is the tolerance of the residuals, not of the change per step",
                      f->flow_conv_tol);
}

/* Set diffusivity, concentrations and the density of the metal; fractions of the file refer to the intact metal, rho_m
 * over the molar mass. */
static pd_status pdi_read_param_file_transport(pd_ctx *ctx, const pdi_read_param_file_values *f, pd_setup *setup)
{
    char text[PDI_FILE_NUMBER_SIZE];
    pd_expr_desc desc;
    double intact = f->rho_m / setup->metal[0].material.molar_mass;
    setup->has_transport = 1;
    setup->diffusivity = f->D_liquid;
    setup->metal[0].material.density = f->rho_m;
    setup->metal[0].solid_c = f->C_solid_init * intact;
    setup->inlet_c = f->C_liquid_init * intact;
    pdi_file_format_number(setup->inlet_c, text);
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.unit = "mol/m3";
    desc.allow_bare = 1;
    return pd_expr_build(ctx, &desc, &setup->initial_c);
}

/* Sums over the bonds that a plane front along an axis opens. While the front passes a node, the node has been in all
 * rows, so that each bond counts as often as the rows it spans. *exposure [-]: fluid share of the neighbours, summed
 * over these rows, for k_corr; *bonds [1/m2]: sum of diffusion bond weights, whose constant in the logarithm is exact
 * in 2D. */
static void pdi_read_param_file_compute_front_sums(const pdi_read_param_file_values *f, double *exposure, double *bonds)
{
    double delta = f->m_ratio, count = 0.0, opened = 0.0, sum = 0.0;
    double constant = PD_DIM == 3 ? 9.0 / (2.0 * PD_PI * delta * delta * delta) : 4.0 / (PD_PI * delta * delta);
    int reach = (int)floor(delta + 0.5), across = PD_DIM > 1 ? reach : 0, deep = PD_DIM > 2 ? reach : 0;
    for (int i = -reach; i <= reach; i++)
        for (int j = -across; j <= across; j++)
            for (int k = -deep; k <= deep; k++) {
                double square = (double)(i * i + j * j + k * k), r = sqrt(square);
                if (!(square > 0.0) || r > delta + 0.5) continue;
                count += 1.0;
                if (i <= 0) continue;
                opened += i;
                sum += i * pd_min(1.0, delta + 0.5 - r) / square;
            }
    *exposure = opened / count;
    *bonds = constant * sum / (f->dx_file * f->dx_file);
}

/* Harmonic mean [m2/s] of the diffusivities on both sides of the surface; 0 where both are 0. */
static double pdi_read_param_file_harmonic_mean(double fluid, double metal)
{
    return fluid + metal > 0.0 ? 2.0 * fluid * (metal / (fluid + metal)) : 0.0; /* products of small ones underflow */
}

/* Recession speed [m/s] with k_corr: a node loses k_corr f per second, f the fluid fraction of its neighbours, from
 * C_solid_init down to C_thresh. Sets the factor of grain boundaries in the setup, and adds a note. */
static double pdi_read_param_file_speed_by_rate(const pdi_read_param_file_values *f, pd_setup *setup)
{
    double exposure, bonds;
    pdi_read_param_file_compute_front_sums(f, &exposure, &bonds);
    double layer = (f->C_solid_init - f->C_thresh) / (f->k_corr * exposure), speed = f->dx_file / layer;
    setup->gb_factor = f->gb_corr_factor;
    pd_setup_add_note(setup,
                      "k_corr = %g 1/s: a layer of dx = %g m in %.4g min: recession at %.6g um/h = %.6g mm/year, "
                      "for every dx",
                      f->k_corr, f->dx_file, layer / 60.0, speed * 1e6 * 3600.0, speed * 1e3 * 31557600.0);
    return speed;
}

/* Recession speed [m/s] without k_corr: diffusion bonds across the surface lower the content as exp(-rate t), down to
 * C_thresh. Sets the factor of grain boundaries in the setup, and adds notes of both. D_liquid and D_grain are
 * positive. */
static double pdi_read_param_file_speed_by_diffusion(const pdi_read_param_file_values *f, pd_setup *setup)
{
    double exposure, bonds, grain = pdi_read_param_file_harmonic_mean(f->D_liquid, f->D_grain);
    pdi_read_param_file_compute_front_sums(f, &exposure, &bonds);
    double layer = log(f->C_solid_init / f->C_thresh) / (grain * bonds), speed = f->dx_file / layer;
    setup->gb_factor = pdi_read_param_file_harmonic_mean(f->D_liquid, f->D_gb) / grain;
    pd_setup_add_note(setup,
                      "D_grain = %g, no k_corr: a layer of dx = %g m in %.4g min: recession at %.6g um/h = %.6g "
                      "mm/year, for every dx",
                      f->D_grain, f->dx_file, layer / 60.0, speed * 1e6 * 3600.0, speed * 1e3 * 31557600.0);
    pd_setup_add_note(setup, "D_gb = %g: %.6g times that speed in grain boundaries", f->D_gb, setup->gb_factor);
    return speed;
}

/* Set the dissolution rate law of the metal: constant speed [m/s], or proportional to 1 - C/Csat if setup->saturation
 * is not 0. */
static pd_status pdi_read_param_file_rate_law(pd_ctx *ctx, double speed, pd_setup *setup)
{
    static const pd_expr_symbol concentration[] = {{"C", "mol/m3", 0.0}};
    char rate[128], at_zero[PDI_FILE_NUMBER_SIZE], most[PDI_FILE_NUMBER_SIZE];
    pd_expr_desc desc;
    memset(&desc, 0, sizeof desc);
    pdi_file_format_number(speed, at_zero);
    pdi_file_format_number(setup->saturation, most);
    snprintf(rate, sizeof rate, "%s m/s", at_zero);
    if (setup->saturation > 0.0) snprintf(rate, sizeof rate, "%s m/s * (1 - C/(%s mol/m3))", at_zero, most);
    desc.text = rate;
    desc.unit = "m/s";
    desc.vars = concentration;
    desc.var_count = 1;
    return pd_expr_build(ctx, &desc, &setup->metal[0].rate);
}

/* Check that the rate in grain boundaries is a multiple of that in grains, which it cannot be where D_grain is 0 or
 * much too small. PD_ERR_ARGUMENT. */
static pd_status pdi_read_param_file_check_boundaries(pd_ctx *ctx, const pd_text *text,
                                                      const pdi_read_param_file_values *f)
{
    double grain = pdi_read_param_file_harmonic_mean(f->D_liquid, f->D_grain);
    if (!f->by_diffusion || !(f->grain_size_mean > 0.0)) return PD_OK;
    if (pdi_read_param_file_harmonic_mean(f->D_liquid, f->D_gb) <= 1e300 * grain) return PD_OK;
    return pdi_text_fail_key(ctx, text, 0, "D_grain",
                             "found %.6g with D_gb = %.6g: boundaries dissolve and grains do not, expected a larger "
                             "one, or D_gb = 0",
                             f->D_grain, f->D_gb);
}

/* Set up dissolution: threshold as a fraction of C_solid_init, saturation (0: none), rate law, notes. Without a solid
 * or a rate has_dissolve is 0 and nothing else is set. PD_ERR_ARGUMENT: C_thresh is not below C_solid_init, or is 0
 * without k_corr, or boundaries dissolve and grains do not. */
static pd_status pdi_read_param_file_dissolve(pd_ctx *ctx, const pd_text *text, const pdi_read_param_file_values *f,
                                              pd_setup *setup)
{
    double intact = f->rho_m / setup->metal[0].material.molar_mass;
    double rate = f->by_diffusion ? pdi_read_param_file_harmonic_mean(f->D_liquid, f->D_grain) : f->k_corr;
    if (setup->solid >= 0) PD_TRY(pdi_read_param_file_check_boundaries(ctx, text, f));
    setup->has_dissolve = setup->solid >= 0 && rate > 0.0;
    if (!setup->has_dissolve) return PD_OK;
    if (f->C_thresh >= f->C_solid_init)
        return pdi_text_fail_key(ctx, text, 0, "C_thresh", "found %.6g, expected less than C_solid_init = %.6g",
                                 f->C_thresh, f->C_solid_init);
    if (f->by_diffusion && !(f->C_thresh > 0.0))
        return pdi_text_fail_key(ctx, text, 0, "C_thresh",
                                 "found 0 without k_corr, expected a positive one: bonds across"
                                 " the surface never empty a node");
    setup->threshold = f->C_thresh / f->C_solid_init;
    setup->saturation = f->C_sat * intact;
    if (f->C_sat > 0.0)
        pd_setup_add_note(setup, "C_sat = %g: the rate falls as 1 - C/Csat, Csat = %.6g mol/m3; there it stops at it",
                          f->C_sat, setup->saturation);
    return pdi_read_param_file_rate_law(ctx,
                                        f->by_diffusion ? pdi_read_param_file_speed_by_diffusion(f, setup)
                                                        : pdi_read_param_file_speed_by_rate(f, setup),
                                        setup);
}

/* Set the grain structure of the metal, with a note on the width of its boundaries. Without grains the factor of grain
 * boundaries becomes 1. */
static void pdi_read_param_file_grains(const pdi_read_param_file_values *f, pd_setup *setup)
{
    setup->has_grains = setup->solid >= 0 && f->grain_size_mean > 0.0;
    if (!setup->has_grains) {
        setup->gb_factor = 1.0;
        return;
    }
    setup->grain.size = f->grain_size_mean;
    setup->grain.spread = f->grain_size_std;
    setup->grain.seed = 1;
    setup->grain.boundary_width = (1.0 + 2.0 * f->gb_width_cells) * f->dx_file;
    pd_setup_add_note(setup, "gb_width_cells = %g: grain boundaries are %.6g um wide, for every dx", f->gb_width_cells,
                      setup->grain.boundary_width * 1e6);
}

/* Set folder, end time, output interval (a twentieth of the run), the share of a node that a step takes (0.1) and
 * fields; all fields that exist are written, and C, v and grain are drawn. */
static pd_status pdi_read_param_file_output(pd_ctx *ctx, pd_text *text, const pdi_read_param_file_values *f,
                                            pd_setup *setup)
{
    PD_TRY(pdi_input_files_read_output_folder(ctx, text, 0, "output_dir", setup));
    setup->end_time = f->T_final;
    setup->output_interval = f->T_final / PDI_READ_PARAM_FILE_FRAMES;
    setup->max_node_fraction = 0.1;
    for (int k = 0; k < PD_FIELD_COUNT; k++)
        if (!pd_fields_lacks(setup, (pd_field)k)) setup->fields |= pd_fields_bit(k);
    setup->images = setup->fields & (pd_fields_bit(PD_FIELD_C) | pd_fields_bit(PD_FIELD_V) |
                                     pd_fields_bit(PD_FIELD_GRAIN));
    return PD_OK;
}

PDI_FN pd_status pdi_read_param_file_read(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count,
                                          pd_setup *setup)
{
    pdi_read_param_file_values f;
    memset(&f, 0, sizeof f);
    PD_TRY(pdi_read_param_file_number(ctx, text, "dx", "5e-6", 0.0, 1.0, 1, &f.dx_file));
    for (int k = 0; k < count; k++) PD_TRY(pdi_override_apply(ctx, text, overrides[k]));
    PD_TRY(pdi_read_param_file_numbers(ctx, text, &f));
    f.by_diffusion = !pdi_text_has_key(ctx, text, 0, "k_corr") &&
                     (pdi_text_has_key(ctx, text, 0, "D_grain") || pdi_text_has_key(ctx, text, 0, "D_gb"));
    PD_TRY(pdi_read_param_file_add_notes(ctx, text, &f, setup));
    if (PD_DIM == 1)
        return pdi_text_fail_key(ctx, text, 0, "dx", "found a flat parameter file, which describes a pin in 2D or 3D");
    PD_TRY(pdi_read_param_file_box(ctx, text, &f, setup));
    PD_TRY(pdi_read_param_file_shapes(ctx, text, &f, setup));
    pdi_read_param_file_flow(&f, setup);
    if (pdi_text_has_key(ctx, text, 0, "flow_conv_tol")) setup->settings_given |= 1u << PD_SOLVER_SETTING_STEADY;
    PD_TRY(pdi_read_param_file_transport(ctx, &f, setup));
    PD_TRY(pdi_read_param_file_dissolve(ctx, text, &f, setup));
    pdi_read_param_file_grains(&f, setup);
    PD_TRY(pdi_read_param_file_output(ctx, text, &f, setup));
    return pdi_text_check_unused(ctx, text);
}
#undef PDI_READ_PARAM_FILE_FRAMES
#undef PDI_READ_PARAM_FILE_NUMBERS
