/* scene: see scene.h */
#include "scene/scene.h"
#include "setup/fields.h"
#include "scene/picture_memory.h"
#include "scene/input_files.h"
#include "scene/key_check.h"
#include "scene/read_constants.h"
#include "scene/read_tables.h"
#include "scene/fingerprint.h"
#include "scene/read_shapes.h"
#include "scene/read_dissolution.h"
#include "scene/read_electrolyte.h"
#include "scene/read_chemistry.h"
#include "scene/read_potential.h"
#include "scene/read_surface_states.h"
#include "scene/read_gas.h"
#include "scene/read_physics.h"
#include "scene/read_mechanics.h"
#include "scene/read_precracks.h"
#include "scene/read_param_file.h"
#include "scene/read_image_options.h"
#include "scene/read_monitors.h"
#include "scene/read_measured.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Bounds that catch a wrong unit. */
#define PDI_SCENE_MAX_CELLS 1e9 /* largest number of cells on an axis */
#define PDI_SCENE_MAX_STEPS 1e9 /* largest number of time steps */

/* Set bit `knob` of setup->settings_given if the section has the key, so that an accuracy preset leaves that solver
 * setting alone. */
static void pdi_scene_mark_given(pdi_reader *s, int section, const char *key, pd_solver_setting knob)
{
    if (pdi_text_has_key(s->ctx, s->text, section, key)) s->setup->settings_given |= 1u << knob;
}

/* ---- [grid] ---- */

/* Check that each edge of the box is a whole number of cells, at least one, within 1e-6 cells. PD_ERR_ARGUMENT: it is
 * not, or an axis has PDI_SCENE_MAX_CELLS or more. */
static pd_status pdi_scene_check_whole_cells(pdi_reader *s, int section)
{
    const pd_setup *u = s->setup;
    for (int d = 0; d < PD_DIM; d++) {
        double cells = (u->hi[d] - u->lo[d]) / u->h[d];
        char edge[PD_UNITS_TEXT], spacing[PD_UNITS_TEXT];
        if (!(cells < PDI_SCENE_MAX_CELLS)) {
            pd_setup_format_value(u->h[d], "m", spacing);
            return pdi_text_fail_key(s->ctx, s->text, section, "box",
                                     "found %.3g cells of %s on axis %c, expected fewer"
                                     " than %.0g",
                                     cells, spacing, "xyz"[d], PDI_SCENE_MAX_CELLS);
        }
        if (fabs(cells - floor(cells + 0.5)) <= 1e-6 && cells > 0.5) continue;
        pd_setup_format_value(u->hi[d] - u->lo[d], "m", edge);
        pd_setup_format_value(u->h[d], "m", spacing);
        return pdi_text_fail_key(s->ctx, s->text, section, "box",
                                 "found %s on axis %c, %.6g cells of %s, expected a whole number"
                                 " of cells",
                                 edge, "xyz"[d], cells, spacing);
    }
    return PD_OK;
}

/* Read the geometry: planar or axisymmetric around x. PD_ERR_ARGUMENT: axisymmetric outside 2D. An axisymmetric box
 * starts on the axis (|y| at most 1e-9 h, which is set to 0, and that side becomes a mirror), or at least as many
 * spacings above it as the lattice has ghost layers; else PD_ERR_ARGUMENT. */
static pd_status pdi_scene_read_geometry(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    int r = PD_DIM - 1;
    double reach = pd_setup_count_ghost_layers(u);
    char found[PD_UNITS_TEXT], horizon[PD_UNITS_TEXT];
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "geometry", &u->axisymmetric));
    if (!u->axisymmetric) return PD_OK;
    if (PD_DIM != 2)
        return pdi_text_fail_key(s->ctx, s->text, section, "geometry", "found 'axisymmetric' in %dD, expected it in 2D",
                                 PD_DIM);
    if (fabs(u->lo[r]) <= 1e-9 * u->h[r]) {
        u->lo[r] = 0.0;
        u->side[2 * r].kind = PD_SIDE_MIRROR;
        return PD_OK;
    }
    if (u->lo[r] >= reach * u->h[r] * (1.0 - 1e-12)) return PD_OK;
    pd_setup_format_value(u->lo[r], "m", found);
    pd_setup_format_value(reach * u->h[r], "m", horizon);
    return pdi_text_fail_key(s->ctx, s->text, section, "box",
                             "found y from %s, expected the distance from the axis to begin at 0 or at least at one"
                             " horizon, %s",
                             found, horizon);
}

/* Read the section [grid]: spacings, of all axes or one each, horizons of fluid and metal, box, threads, geometry.
 * PD_ERR_ARGUMENT: a spacing that is not positive, another number of spacings than 1 or PD_DIM, of ranges than PD_DIM,
 * or a box that is not of whole cells. */
static pd_status pdi_scene_read_grid(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "grid", NULL), count;
    PD_TRY(pdi_text_get_numbers(s->ctx, s->text, section, "h", "m", NULL, PD_DIM, u->h, &count));
    if (count != 1 && count != PD_DIM)
        return pdi_text_fail_key(s->ctx, s->text, section, "h", "found %d lengths, expected one or %d", count, PD_DIM);
    for (int d = 0; d < PD_DIM; d++) {
        if (count == 1) u->h[d] = u->h[0];
        if (!(u->h[d] > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, "h", "found %.6g m, expected a positive length",
                                     u->h[d]);
    }
    PD_TRY(pdi_read_dissolution_horizons(s, section));
    PD_TRY(pdi_text_get_ranges(s->ctx, s->text, section, "box", "m", NULL, PD_DIM, u->lo, u->hi, &count));
    if (count != PD_DIM)
        return pdi_text_fail_key(s->ctx, s->text, section, "box",
                                 "found %d range%s, expected %d, one for each axis:"
                                 " pd%dd runs scenes in %dD",
                                 count, count > 1 ? "s" : "", PD_DIM, count, count);
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "threads", &u->threads));
    PD_TRY(pdi_scene_check_whole_cells(s, section));
    return pdi_scene_read_geometry(s, section);
}

/* ---- [side ...] ---- */

/* Check that the label of each [side ...] section is a side of the box in PD_DIM dimensions: x-, x+, ...
 * PD_ERR_ARGUMENT. */
static pd_status pdi_scene_check_side_names(pdi_reader *s)
{
    for (int k = pdi_text_next_section(s->ctx, s->text, "side", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "side", k)) {
        const char *label = s->text->section[k].label;
        int known = 0;
        for (int side = 0; side < 2 * PD_DIM; side++) known = known || strcmp(label, pd_setup_side_name(side)) == 0;
        if (!known)
            return pdi_text_fail_key(s->ctx, s->text, k, "side",
                                     "found [side %.40s], expected one of x-, x+%s%s"
                                     " in %dD",
                                     label, PD_DIM > 1 ? ", y-, y+" : "", PD_DIM > 2 ? ", z-, z+" : "", PD_DIM);
    }
    return PD_OK;
}

/* Read an expression in x, y, z and t; fallback NULL: the key is required. */
static pd_status pdi_scene_read_expr(pdi_reader *s, int section, const char *key, const char *unit,
                                     const char *fallback, pd_expr *expr)
{
    return pdi_text_get_expr(s->ctx, s->text, section, key, unit, pd_setup_get_position_symbols(),
                             PD_SETUP_POSITION_VARS, fallback, expr);
}

/* Read the mean speed or flow rate of an inlet as a function of t; stream->variables_used is 0 for a constant.
 * PD_ERR_ARGUMENT: it depends on the place. */
static pd_status pdi_scene_read_time_expr(pdi_reader *s, int section, const char *key, const char *unit,
                                          pd_expr *stream)
{
    PD_TRY(pdi_scene_read_expr(s, section, key, unit, NULL, stream));
    if (!(stream->variables_used & ~((uint32_t)1 << PD_DIM))) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, key,
                             "found a function of the place, expected one of t alone, or"
                             " profile = expression with a velocity");
}

/* Read the strength of the inflow, `mean` [m/s] or `flow_rate` [m3/s], into side->inflow_of_time. A constant also goes
 * into mean_speed or flow_rate. A flow rate that depends on t leaves flow_rate at 1 as a mark, a mean speed that does
 * leaves mean_speed unchanged. PD_ERR_ARGUMENT: both keys, a flow rate in 1D, a function of x, y or z. PD_ERR_PARSE:
 * neither key. */
static pd_status pdi_scene_read_inflow(pdi_reader *s, int section, pd_setup_side *side)
{
    int volume = pdi_text_has_key(s->ctx, s->text, section, "flow_rate");
    if (!volume) PD_TRY(pdi_scene_read_time_expr(s, section, "mean", "m/s", &side->inflow_of_time));
    if (!volume && side->inflow_of_time.variables_used) return PD_OK;
    if (!volume) return pdi_key_value_get_number(s->ctx, s->text, section, "mean", &side->mean_speed);
    if (pdi_text_has_key(s->ctx, s->text, section, "mean"))
        return pdi_text_fail_key(s->ctx, s->text, section, "flow_rate", "found beside 'mean', expected one of them");
    if (PD_DIM == 1)
        return pdi_text_fail_key(s->ctx, s->text, section, "flow_rate",
                                 "found a volume flow in 1D, expected mean = speed");
    side->flow_rate = 1.0;
    PD_TRY(pdi_scene_read_time_expr(s, section, "flow_rate", "m3/s", &side->inflow_of_time));
    if (side->inflow_of_time.variables_used) return PD_OK;
    return pdi_key_value_get_number(s->ctx, s->text, section, "flow_rate", &side->flow_rate);
}

/* Read an inlet: velocity profile and its strength. profile = expression has a velocity [m/s] instead, 0 along axes
 * without a key, which `mean` or `flow_rate` scale if one of them is given (is_scaled). PD_ERR_ARGUMENT: an expression
 * without any of vx, vy, vz, or one that is scaled and depends on t. */
static pd_status pdi_scene_read_inlet(pdi_reader *s, int section, pd_setup_side *side)
{
    static const char *const keys[] = {"vx", "vy", "vz"};
    int profile;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "profile", &profile));
    side->profile = (pd_profile)(profile + PD_PROFILE_UNIFORM);
    side->is_scaled =
        side->profile == PD_PROFILE_EXPRESSION &&
        (pdi_text_has_key(s->ctx, s->text, section, "mean") || pdi_text_has_key(s->ctx, s->text, section, "flow_rate"));
    if (side->profile != PD_PROFILE_EXPRESSION || side->is_scaled) PD_TRY(pdi_scene_read_inflow(s, section, side));
    if (side->profile != PD_PROFILE_EXPRESSION) return PD_OK;
    for (int d = 0; d < PD_DIM; d++) {
        PD_TRY(pdi_scene_read_expr(s, section, keys[d], "m/s", "0", &side->velocity[d]));
        if (side->is_scaled && pd_setup_is_time_dependent(&side->velocity[d]))
            return pdi_text_fail_key(s->ctx, s->text, section, keys[d],
                                     "found a function of t that 'mean' or "
                                     "'flow_rate' scales, expected one of the place alone: let 'mean' depend on t");
    }
    for (int d = 0; d < PD_DIM; d++)
        if (pdi_text_has_key(s->ctx, s->text, section, keys[d])) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "profile",
                             "found 'expression' without a velocity, expected vx = ...");
}

/* Read a value [SI] that all inlets (C) or outlets (p) share, 0 by default. *seen 1: it must equal *value within the
 * rounding of units, else PD_ERR_ARGUMENT. Sets *seen to 1 and *value. */
static pd_status pdi_scene_read_shared_value(pdi_reader *s, int section, const char *key, int *seen, double *value)
{
    double found;
    PD_TRY(pdi_key_value_get_number_or(s->ctx, s->text, section, key, "0", &found));
    if (*seen && !pdi_reader_is_equal(found, *value))
        return pdi_text_fail_key(s->ctx, s->text, section, key, "found %.6g, another side has %.6g, expected one value",
                                 found, *value);
    *seen = 1;
    *value = found;
    return PD_OK;
}

/* Read an open side, an inlet where the prescribed flow enters and an outlet where it leaves, with its inflow
 * concentration. */
static pd_status pdi_scene_read_open_side(pdi_reader *s, int section, pd_setup_side *side)
{
    side->kind = PD_SIDE_INLET;
    side->is_open = 1;
    return pdi_scene_read_expr(s, section, "C", "mol/m3", "0", &side->inlet_c);
}

/* Read the concentration of an inlet, by default 0: a constant into setup->inlet_c, which must be the same at all
 * inlets with a constant, or an expression in x, y, z, t into side->inlet_c with setup->has_inlet_c_by_side 1. *inlets
 * 1: a constant was read, here or before. */
static pd_status pdi_scene_read_inlet_concentration(pdi_reader *s, int section, pd_setup_side *side, int *inlets)
{
    pd_expr found;
    PD_TRY(pdi_scene_read_expr(s, section, "C", "mol/m3", "0", &found));
    if (!found.variables_used) {
        pd_expr_free(s->ctx, &found);
        return pdi_scene_read_shared_value(s, section, "C", inlets, &s->setup->inlet_c);
    }
    side->inlet_c = found;
    s->setup->has_inlet_c_by_side = 1;
    return PD_OK;
}

/* Read whether a wall holds all species at their inlet values (Dirichlet condition, key `species`) into
 * side->has_fixed_species. PD_ERR_ARGUMENT: it does and the scene has no chemistry. */
static pd_status pdi_scene_read_wall_species(pdi_reader *s, int section, pd_setup_side *side)
{
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "species", &side->has_fixed_species));
    if (!side->has_fixed_species || s->setup->has_chemistry) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "species",
                             "found without species, expected [species Na+] and "
                             "others");
}

/* Read a wall; k: index of the side. With a flow: its velocity, where has_wall_velocity becomes 1 unless all components
 * are the constant 0. With transport: its Dirichlet concentration; without key C no flux. And whether it holds species.
 * PD_ERR_ARGUMENT: a number of components other than PD_DIM, or one across the side that is not the constant 0. */
static pd_status pdi_scene_read_wall(pdi_reader *s, int section, int k)
{
    pd_setup_side *side = &s->setup->side[k];
    int count;
    if (s->setup->has_flow && pdi_text_has_key(s->ctx, s->text, section, "velocity")) {
        PD_TRY(pdi_text_get_exprs(s->ctx, s->text, section, "velocity", "m/s", pd_setup_get_position_symbols(),
                                  PD_SETUP_POSITION_VARS, NULL, PD_DIM, side->wall_velocity, &count));
        for (int d = 0; d < count; d++)
            side->has_wall_velocity = side->has_wall_velocity || side->wall_velocity[d].variables_used ||
                                      fabs(pd_expr_eval(&side->wall_velocity[d], NULL)) > 0.0;
        const pd_expr *across = &side->wall_velocity[k / 2];
        if (count != PD_DIM || across->variables_used || fabs(pd_expr_eval(across, NULL)) > 0.0)
            return pdi_text_fail_key(s->ctx, s->text, section, "velocity",
                                     "expected %d components, that along %c being 0: a wall slides along itself",
                                     PD_DIM, "xyz"[k / 2]);
    }
    PD_TRY(pdi_scene_read_wall_species(s, section, side));
    if (!s->setup->has_transport || !pdi_text_has_key(s->ctx, s->text, section, "C")) return PD_OK;
    side->has_fixed_c = 1;
    PD_TRY(pdi_scene_read_expr(s, section, "C", "mol/m3", NULL, &side->fixed_c));
    double held;
    return side->fixed_c.variables_used ? PD_OK : pdi_key_value_get_number(s->ctx, s->text, section, "C", &held);
}

/* Check that the opposite of each periodic side is periodic. PD_ERR_ARGUMENT: it is not. */
static pd_status pdi_scene_check_periodic_pairs(pdi_reader *s)
{
    for (int k = 0; k < 2 * PD_DIM; k++) {
        const pd_setup_side *a = &s->setup->side[k], *b = &s->setup->side[k ^ 1];
        if ((a->kind == PD_SIDE_PERIODIC) == (b->kind == PD_SIDE_PERIODIC)) continue;
        int periodic = a->kind == PD_SIDE_PERIODIC ? k : k ^ 1;
        int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(periodic));
        return pdi_text_fail_key(s->ctx, s->text, section, "flow", "found 'periodic', expected it on %s and %s",
                                 pd_setup_side_name(k & ~1), pd_setup_side_name(k | 1));
    }
    return PD_OK;
}

/* Read an open side of [corrode] in fluid at rest: it becomes a wall with the Dirichlet concentration `bulk` of
 * [corrode], by default 0. PD_ERR_ARGUMENT: the side has key C. */
static pd_status pdi_scene_read_bulk_side(pdi_reader *s, int section, pd_setup_side *side)
{
    int corrode = pdi_text_get_section(s->ctx, s->text, "corrode", NULL);
    if (pdi_text_has_key(s->ctx, s->text, section, "C"))
        return pdi_text_fail_key(s->ctx, s->text, section, "C",
                                 "found beside flow = open, expected bulk in [corrode], or C without open");
    side->kind = PD_SIDE_WALL;
    side->has_fixed_c = 1;
    PD_TRY(pdi_scene_read_wall_species(s, section, side));
    return pdi_scene_read_expr(s, corrode, "bulk", "mol/m3", "0", &side->fixed_c);
}

/* Read one [side ...] section into setup->side[k]; with a gas by pdi_read_gas_side. *inlets, *outlets: 1 once the
 * shared C and p are known. An outlet, open side or inlet needs [flow]; `open` in [corrode] without flow holds `bulk`.
 * In an axisymmetric box the side on the axis is a mirror, and any other side of y is neither mirror nor periodic.
 * PD_ERR_ARGUMENT. */
static pd_status pdi_scene_read_side(pdi_reader *s, int k, int section, int *inlets, int *outlets)
{
    static const char *const flows[] = {"noslip", "inlet", "outlet", "periodic", "mirror", "open", NULL};
    const int open = 5;
    pd_setup *u = s->setup;
    int flow;
    if (u->has_gas) return pdi_read_gas_side(s->ctx, s->text, section, &u->side[k]);
    PD_TRY(pdi_text_get_choice(s->ctx, s->text, section, "flow", flows, "noslip", &flow));
    if (u->axisymmetric && k / 2 == PD_DIM - 1) {
        int axis = u->side[k].kind == PD_SIDE_MIRROR;
        if (axis && flow != PD_SIDE_MIRROR)
            return pdi_text_fail_key(s->ctx, s->text, section, "flow",
                                     "found '%s' on the axis, expected mirror or nothing", flows[flow]);
        if (!axis && (flow == PD_SIDE_PERIODIC || flow == PD_SIDE_MIRROR))
            return pdi_text_fail_key(s->ctx, s->text, section, "flow",
                                     "found '%s' around an axis, expected noslip, inlet, outlet or open", flows[flow]);
    }
    if (u->has_corrode && !u->has_flow && flow == open) return pdi_scene_read_bulk_side(s, section, &u->side[k]);
    if ((pd_grid_is_inlet_or_outlet((pd_side)flow) || flow == open) && !u->has_flow)
        return pdi_text_fail_key(s->ctx, s->text, section, "flow",
                                 "found '%s' without a [flow] section, expected C = ... alone"
                                 " to hold a concentration",
                                 flows[flow]);
    if (flow == open) return pdi_scene_read_open_side(s, section, &u->side[k]);
    u->side[k].kind = (pd_side)flow;
    if (flow == PD_SIDE_WALL) return pdi_scene_read_wall(s, section, k);
    if (flow == PD_SIDE_INLET) PD_TRY(pdi_scene_read_inlet(s, section, &u->side[k]));
    if (flow == PD_SIDE_OUTLET) return pdi_scene_read_shared_value(s, section, "p", outlets, &u->p_out);
    if (flow == PD_SIDE_INLET && u->has_transport)
        return pdi_scene_read_inlet_concentration(s, section, &u->side[k], inlets);
    return PD_OK;
}

/* Read the boundary conditions of all sides. A side without a section stays as it is, a wall by default.
 * PD_ERR_ARGUMENT: a section of no side, or a periodic side across from one that is not. */
static pd_status pdi_scene_read_sides(pdi_reader *s)
{
    int inlets = 0, outlets = 0;
    PD_TRY(pdi_scene_check_side_names(s));
    for (int k = 0; k < 2 * PD_DIM; k++) {
        int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(k));
        if (pdi_text_has_key(s->ctx, s->text, section, NULL))
            PD_TRY(pdi_scene_read_side(s, k, section, &inlets, &outlets));
    }
    return pdi_scene_check_periodic_pairs(s);
}

/* ---- physics ---- */

/* Read the time treatment of the flow: steady (nothing else is read), implicit with its tolerance, explicit with its
 * equation of state and speed of sound, or prescribed; all but steady have a velocity in x, y, z, initial or
 * prescribed, 0 by default. PD_ERR_ARGUMENT: an open side and the flow is not prescribed, or a prescribed one beside
 * dissolution. */
static pd_status pdi_scene_read_flow_time(pdi_reader *s, int section)
{
    static const char *const motions[] = {"steady", "implicit", "explicit", "prescribed", NULL};
    static const char *const keys[] = {"vx", "vy", "vz"};
    pd_setup *u = s->setup;
    int motion;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "time", &motion));
    u->flow_time = (pd_flow_time)motion;
    for (int k = 0; k < 2 * PD_DIM; k++)
        if (u->side[k].is_open && u->flow_time != PD_FLOW_PRESCRIBED)
            return pdi_text_fail_key(s->ctx, s->text, section, "time",
                                     "found '%s' beside an open side, expected prescribed", motions[motion]);
    if (u->flow_time == PD_FLOW_STEADY) return PD_OK;
    if (u->has_dissolve && u->flow_time == PD_FLOW_PRESCRIBED)
        return pdi_text_fail_key(s->ctx, s->text, section, "time",
                                 "found 'prescribed' beside [dissolve], expected steady, implicit or explicit: a "
                                 "prescribed flow does not enter where metal was");
    for (int d = 0; d < PD_DIM; d++)
        PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, keys[d], "m/s", pd_setup_get_position_symbols(), PD_DIM,
                                 "0", &u->initial_velocity[d]));
    if (u->flow_time == PD_FLOW_PRESCRIBED) return PD_OK;
    if (u->flow_time == PD_FLOW_IMPLICIT) {
        pdi_scene_mark_given(s, section, "rtol", PD_SOLVER_SETTING_FLOW_RTOL);
        return pdi_key_value_get_number(s->ctx, s->text, section, "rtol", &u->flow_rtol);
    }
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "eos", &u->linear_eos));
    return pdi_key_value_get_number(s->ctx, s->text, section, "c0", &u->sound_speed);
}

/* If the flow is steady and eos or c0 is given, read them, so that they count as used, and add a note that they have no
 * effect. With any other flow do nothing. */
static pd_status pdi_scene_read_ignored_eos(pdi_reader *s, int section)
{
    double sound;
    int state, given = pdi_text_has_key(s->ctx, s->text, section, "c0");
    if (s->setup->flow_time != PD_FLOW_STEADY) return PD_OK;
    if (!given && !pdi_text_has_key(s->ctx, s->text, section, "eos")) return PD_OK;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "eos", &state));
    if (given) PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "c0", &sound));
    pd_setup_add_note(s->setup,
                      "eos and c0 belong to time = explicit; the steady solver is incompressible and ignores them");
    return PD_OK;
}

/* Read the body force per mass [m/s2], if it is given: a constant vector into setup->force, or, if one component
 * depends on x, y, z or t, expressions into setup->body_force with has_body_force_expr 1. Components that are not given
 * are 0. */
static pd_status pdi_scene_read_body_force(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    int count;
    if (!pdi_text_has_key(s->ctx, s->text, section, "body_force")) return PD_OK;
    PD_TRY(pdi_text_get_exprs(s->ctx, s->text, section, "body_force", "m/s2", pd_setup_get_position_symbols(),
                              PD_SETUP_POSITION_VARS, NULL, PD_DIM, u->body_force, &count));
    for (int d = 0; d < count; d++) u->has_body_force_expr = u->has_body_force_expr || u->body_force[d].variables_used;
    if (u->has_body_force_expr) return PD_OK;
    for (int d = 0; d < count; d++) pd_expr_free(s->ctx, &u->body_force[d]);
    return pdi_text_get_numbers(s->ctx, s->text, section, "body_force", "m/s2", NULL, PD_DIM, u->force, &count);
}

/* Read the order of the flow discretisation into setup->flow_order: 0 (auto), 2 or 4. PD_ERR_ARGUMENT: 4 with a horizon
 * of the fluid above 1 spacing, in an axisymmetric box, or with time = explicit or prescribed. */
static pd_status pdi_scene_read_flow_order(pdi_reader *s, int section)
{
    const pd_setup *u = s->setup;
    int twice;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "order", &twice));
    s->setup->flow_order = 2 * twice;
    if (twice < 2) return PD_OK;
    if (u->fluid_m > 1.0)
        return pdi_text_fail_key(s->ctx, s->text, section, "order", "found 4 and m = %g, expected m = 1 in [grid]",
                                 u->fluid_m);
    if (u->axisymmetric)
        return pdi_text_fail_key(s->ctx, s->text, section, "order", "found 4 in an axisymmetric box, expected 2");
    if (u->flow_time == PD_FLOW_EXPLICIT || u->flow_time == PD_FLOW_PRESCRIBED)
        return pdi_text_fail_key(s->ctx, s->text, section, "order",
                                 "found 4 beside time = explicit or prescribed, expected steady or implicit");
    return PD_OK;
}

/* Read the section [flow], if there is one: density, viscosity, tolerance, body force, reference values, time
 * treatment, order. PD_ERR_ARGUMENT: a side that is an inlet, not an open one, and no side that is an outlet. */
static pd_status pdi_scene_read_flow(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "flow", NULL), inflow = 0, outflow = 0;
    if (!u->has_flow) return PD_OK;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "rho", &u->rho));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "mu", &u->mu));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "steady_tolerance", &u->steady_tolerance));
    pdi_scene_mark_given(s, section, "steady_tolerance", PD_SOLVER_SETTING_STEADY);
    PD_TRY(pdi_scene_read_body_force(s, section));
    if (pdi_text_has_key(s->ctx, s->text, section, "reference_speed"))
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "reference_speed", &u->speed));
    if (pdi_text_has_key(s->ctx, s->text, section, "reference_length"))
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "reference_length", &u->length));
    PD_TRY(pdi_scene_read_flow_time(s, section));
    PD_TRY(pdi_scene_read_flow_order(s, section));
    PD_TRY(pdi_scene_read_ignored_eos(s, section));
    for (int k = 0; k < 2 * PD_DIM; k++) {
        inflow += u->side[k].kind == PD_SIDE_INLET && !u->side[k].is_open;
        outflow += u->side[k].kind == PD_SIDE_OUTLET;
    }
    if (inflow && !outflow)
        return pdi_text_fail_key(s->ctx, s->text, section, "flow",
                                 "found an inlet and no outlet, expected flow = outlet in a [side ...]");
    return PD_OK;
}

/* Read the section [transport], if there is one: D, advection scheme, time treatment (by default that of [chemistry]),
 * initial concentration. PD_ERR_ARGUMENT: another time treatment than that of [chemistry], or a steady one beside metal
 * that dissolves. */
static pd_status pdi_scene_read_transport(pdi_reader *s)
{
    static const char *const times[] = {"implicit", "steady", NULL};
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "transport", NULL), scheme, species = u->steady_transport;
    if (!pdi_text_has_key(s->ctx, s->text, section, NULL)) return PD_OK;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "D", &u->diffusivity));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "advection", &scheme));
    u->advection = (pd_advection)scheme;
    PD_TRY(pdi_key_value_get_index_or(s->ctx, s->text, section, "time", times[species], &u->steady_transport));
    if (u->has_chemistry && u->steady_transport != species)
        return pdi_text_fail_key(s->ctx, s->text, section, "time",
                                 "found '%s' beside [chemistry] with time = %s, "
                                 "expected the same",
                                 times[u->steady_transport], times[species]);
    if (u->steady_transport && u->has_dissolve)
        return pdi_text_fail_key(s->ctx, s->text, section, "time",
                                 "found 'steady' beside metal that dissolves, expected implicit");
    return pdi_reader_read_initial(s, section);
}

/* ---- [run], [output] ---- */

/* Check that none of `count` expressions depends on t, in a scene without time. PD_ERR_ARGUMENT names `key`. */
static pd_status pdi_scene_check_time_independent(pdi_reader *s, int section, const char *key, const pd_expr *expr,
                                                  int count)
{
    for (int k = 0; k < count; k++)
        if (pd_setup_is_time_dependent(&expr[k]))
            return pdi_text_fail_key(
                s->ctx, s->text, section, key,
                "found a function of t in a scene that is steady, expected until = ... in [run], "
                "time = implicit in [flow], [transport] or [chemistry], or a function of the place");
    return PD_OK;
}

/* Check that nothing depends on t in a steady scene. PD_ERR_ARGUMENT: conditions of sides and walls, displacements and
 * loads, potentials or currents of electrodes, or the body forces of flow and metal do. */
static pd_status pdi_scene_check_steady_scene(pdi_reader *s)
{
    static const char *const keys[] = {"vx", "vy", "vz"};
    const pd_setup *u = s->setup;
    for (int k = 0; k < 2 * PD_DIM; k++) {
        const pd_setup_side *side = &u->side[k];
        int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(k));
        PD_TRY(pdi_scene_check_time_independent(s, section, side->flow_rate > 0.0 ? "flow_rate" : "mean",
                                                &side->inflow_of_time, 1));
        for (int d = 0; d < PD_DIM; d++)
            PD_TRY(pdi_scene_check_time_independent(s, section, keys[d], &side->velocity[d], 1));
        PD_TRY(pdi_scene_check_time_independent(s, section, "C", &side->inlet_c, 1));
        PD_TRY(pdi_scene_check_time_independent(s, section, "C", &side->fixed_c, 1));
        PD_TRY(pdi_scene_check_time_independent(s, section, "velocity", side->wall_velocity, PD_DIM));
    }
    for (int k = 0; k < u->wall_count; k++)
        PD_TRY(pdi_scene_check_time_independent(s, u->wall_shape[k].section, "C", &u->wall_shape[k].fixed_c, 1));
    for (int k = 0; k < u->metal_body.mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &u->metal_body.mechanical_bc[k];
        for (int d = 0; d < PD_DIM; d++) {
            static const char *const moves[] = {"ux", "uy", "uz"};
            PD_TRY(pdi_scene_check_time_independent(s, grip->section, moves[d], &grip->displacement[d], 1));
        }
        PD_TRY(pdi_scene_check_time_independent(s, grip->section, "traction", grip->traction, PD_DIM));
        PD_TRY(pdi_scene_check_time_independent(s, grip->section, "pressure", &grip->pressure, 1));
    }
    PD_TRY(pdi_scene_check_time_independent(s, pdi_text_get_section(s->ctx, s->text, "solid", NULL), "body_force",
                                            u->metal_body.force, PD_DIM));
    for (int k = 0; k < u->potential.electrodes; k++) {
        const pd_setup_electrode *e = &u->potential.electrode[k];
        PD_TRY(pdi_scene_check_time_independent(s, pdi_text_get_section(s->ctx, s->text, "electrode", e->name),
                                                e->has_fixed_potential ? "potential" : "current", &e->fixed_value, 1));
    }
    return pdi_scene_check_time_independent(s, pdi_text_get_section(s->ctx, s->text, "flow", NULL), "body_force",
                                            u->body_force, PD_DIM);
}

/* Read the section [run]: end time, largest step, and, with transport or species, tolerances. It is read with a gas,
 * dynamics, registered physics, a flow in time, transport or species in time, or where `until` is given and nothing is
 * carried. All other scenes are steady: nothing is read, and nothing may depend on t. Default of
 * max_dissolved_fraction: min(1, 25 rtol), with [corrode] 0.01, 0.1 or 0.2. PD_ERR_ARGUMENT: too many steps of
 * max_step. */
static pd_status pdi_scene_read_run(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "run", NULL);
    int carries = u->has_transport || u->has_chemistry;
    int rests = u->flow_time == PD_FLOW_STEADY || u->flow_time == PD_FLOW_PRESCRIBED;
    /* a steady flow may follow what stands outside of it, when a time to follow it for is given */
    int follows = (u->flow_time == PD_FLOW_STEADY || u->has_solid || u->has_potential) && !carries &&
                  pdi_text_has_key(s->ctx, s->text, section, "until");
    rests = rests && !(u->metal_body.density > 0.0) && !u->registered_count;
    if (rests && !follows && !u->has_gas && (!carries || u->steady_transport)) return pdi_scene_check_steady_scene(s);
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "until", &u->end_time));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "max_step", &u->max_step));
    if (u->max_step > 0.0 && u->end_time > PDI_SCENE_MAX_STEPS * u->max_step)
        return pdi_text_fail_key(s->ctx, s->text, section, "max_step",
                                 "found %.3g steps until the end, expected at most"
                                 " %.0g",
                                 u->end_time / u->max_step, PDI_SCENE_MAX_STEPS);
    if (!carries) return PD_OK;
    if (u->has_corrode) { /* loss in proportion to a difference: (1 - x)^n is not exp(-n x) */
        const char *share = u->drive == PD_DRIVE_DIFFERENCE ? "0.01" : u->activation ? "0.1" : "0.2";
        PD_TRY(pdi_key_value_get_number_or(s->ctx, s->text, section, "rtol", "1e-3", &u->rtol));
        return pdi_key_value_get_number_or(s->ctx, s->text, section, "max_dissolved_fraction", share,
                                           &u->max_node_fraction);
    }
    pdi_scene_mark_given(s, section, "rtol", PD_SOLVER_SETTING_RTOL);
    pdi_scene_mark_given(s, section, "max_dissolved_fraction", PD_SOLVER_SETTING_FRACTION);
    PD_TRY(pdi_key_value_get_number_or(s->ctx, s->text, section, "rtol", u->has_dissolve ? "4e-3" : "1e-3", &u->rtol));
    /* Measured on a dissolving disc of radius 12 h, law 1 - C/Csat, after 4 h of recession: the volume loss is off by
     * 3e-3 when a step takes at most 0.1 of a node, by 1e-3 with 0.025. */
    u->max_node_fraction = pd_min(1.0, 25.0 * u->rtol);
    if (!pdi_text_has_key(s->ctx, s->text, section, "max_dissolved_fraction")) return PD_OK;
    return pdi_key_value_get_number(s->ctx, s->text, section, "max_dissolved_fraction", &u->max_node_fraction);
}

/* Read the plane that images of a 3D run show: slice_axis and slice_at [m]; by default the middle of the last axis,
 * which is also set in 1D and 2D. PD_ERR_ARGUMENT: key `slice` outside 3D, or a plane outside the box. */
static pd_status pdi_scene_read_slice(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    u->slice_axis = PD_DIM - 1;
    u->slice_at = 0.5 * (u->lo[u->slice_axis] + u->hi[u->slice_axis]);
    if (!pdi_text_has_key(s->ctx, s->text, section, "slice")) return PD_OK;
    if (PD_DIM < 3)
        return pdi_text_fail_key(s->ctx, s->text, section, "slice", "found in %dD, expected it in 3D only", PD_DIM);
    return pdi_read_monitors_plane_position(s->ctx, s->text, u, section, "slice", &u->slice_axis, &u->slice_at);
}

/* Read the prefix of output files, by default "corr". PD_ERR_ARGUMENT: PD_SETUP_NAME bytes or more, or one of / \ : or
 * a blank in it. */
static pd_status pdi_scene_read_prefix(pdi_reader *s, int section)
{
    const char *value;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "prefix", "corr", &value));
    if (strlen(value) >= PD_SETUP_NAME || strpbrk(value, "/\\ :"))
        return pdi_text_fail_key(s->ctx, s->text, section, "prefix",
                                 "found '%.40s', expected a short word without folder", value);
    memcpy(s->setup->prefix, value, strlen(value) + 1);
    return PD_OK;
}

/* Read the magnification of displacements in images of the metal, if it is given. PD_ERR_ARGUMENT: in 1D, or without
 * [solid]. */
static pd_status pdi_scene_read_magnification(pdi_reader *s, int section)
{
    if (!pdi_text_has_key(s->ctx, s->text, section, "deformation_scale")) return PD_OK;
    if (PD_DIM == 1 || !s->setup->has_solid)
        return pdi_text_fail_key(s->ctx, s->text, section, "deformation_scale",
                                 PD_DIM == 1 ? "found in 1D, where images are curves, expected it in 2D and 3D"
                                             : "found without [solid], whose displacements it magnifies");
    return pdi_key_value_get_number(s->ctx, s->text, section, "deformation_scale", &s->setup->displacement_scale);
}

/* Read the section [output]: interval (a twentieth of the run by default), fields, images and their options, prefix,
 * folder, slice. In a run without end time `every` is not read. A gas without max_step gets a twentieth of the
 * interval. By default all fields of registered physics are written, too. PD_ERR_ARGUMENT: more than 9e5 frames. */
static pd_status pdi_scene_read_output(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "output", NULL);
    u->output_interval = u->end_time / 20.0;
    if (u->end_time > 0.0 && pdi_text_has_key(s->ctx, s->text, section, "every"))
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "every", &u->output_interval));
    if (u->has_gas && !(u->max_step > 0.0)) u->max_step = u->output_interval / 20.0; /* rows of the tables */
    if (u->end_time > 0.0 && u->end_time / u->output_interval > 9e5)
        return pdi_text_fail_key(s->ctx, s->text, section, "every",
                                 "found %.3g frames until the end, expected at most 900000",
                                 u->end_time / u->output_interval);
    PD_TRY(pdi_read_monitors_fields(s->ctx, s->text, u, section, "fields",
                                    u->has_gas ? "density, v, p, energy, kind" :
                                    u->has_solid ? "C, v, p, kind, grain, u, mises, sigma_h, eps_p, broken" :
                                    "C, v, p, kind, grain, pH, phi", &u->fields));
    int given = pdi_text_has_key(s->ctx, s->text, section, "fields");
    for (int k = pd_fields_first_registered(u), i; !given && pd_fields_find_registered(u, k, &i) >= 0; k++)
        u->fields |= pd_fields_bit(k);
    PD_TRY(pdi_read_monitors_fields(s->ctx, s->text, u, section, "images", "none", &u->images));
    PD_TRY(pdi_scene_read_magnification(s, section));
    PD_TRY(pdi_read_image_options_read(s->ctx, s->text, section, u));
    PD_TRY(pdi_scene_read_prefix(s, section));
    PD_TRY(pdi_input_files_read_output_folder(s->ctx, s->text, section, "folder", u));
    return pdi_scene_read_slice(s, section);
}

/* Line of a section in the file, 0: absent. The section counts as looked up. */
static int pdi_scene_find_section_line(pdi_reader *s, const char *name, const char *label)
{
    int section = pdi_text_get_section(s->ctx, s->text, name, label);
    return section >= 0 ? s->text->section[section].line : 0;
}

/* Store the lines of the main sections (0: absent), for errors that only show when the model is built. These sections
 * then count as looked up. PD_PART_DISSOLVE: that of [dissolve], else of [corrode]. */
static void pdi_scene_set_section_lines(pdi_reader *s)
{
    pd_setup *u = s->setup;
    u->line[PD_PART_GRID] = pdi_scene_find_section_line(s, "grid", NULL);
    u->line[PD_PART_FLOW] = pdi_scene_find_section_line(s, "flow", NULL);
    u->line[PD_PART_GAS] = pdi_scene_find_section_line(s, "gas", NULL);
    u->line[PD_PART_SOLID] = pdi_scene_find_section_line(s, "solid", NULL);
    u->line[PD_PART_TRANSPORT] = pdi_scene_find_section_line(s, "transport", NULL);
    u->line[PD_PART_DISSOLVE] = pdi_scene_find_section_line(s, "dissolve", NULL);
    u->line[PD_PART_POTENTIAL] = pdi_scene_find_section_line(s, "potential", NULL);
    if (!u->line[PD_PART_DISSOLVE]) u->line[PD_PART_DISSOLVE] = pdi_scene_find_section_line(s, "corrode", NULL);
    for (int k = 0; k < 2 * PD_DIM; k++)
        u->side[k].line = pdi_scene_find_section_line(s, "side", pd_setup_side_name(k));
}

/* Add a note to the setup for each former name that the text has. */
static void pdi_scene_add_renamed_notes(const pd_text *text, pd_setup *setup)
{
    for (int k = 0; k < PD_RENAMED_KEYS; k++) {
        const char *former, *present;
        if (!text->has_renamed[k]) continue;
        const char *section = pdi_renamed_keys_describe(k, &former, &present);
        pd_setup_add_note(setup, "'%s' of [%s] is a former name and holds; its name is '%s'", former, section, present);
    }
}

/* Read all sections of a scene in the order of their dependencies; path: of the scene. All names of sections and keys
 * are checked first, and at the end that every pair was read. PD_ERR_ARGUMENT: no flow, gas, transport, metal under
 * load, chemistry, potential or registered physics. What was read so far stays in the setup on failure. */
static pd_status pdi_scene_read_sections(pd_ctx *ctx, pd_text *text, const char *path, pd_setup *setup)
{
    pdi_reader s;
    char folder[PD_PATH_SIZE], name[PD_SETUP_NAME];
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.text = text;
    s.setup = setup;
    text->check_keys = 1;
    pdi_input_files_split_path(path, name, folder);
    PD_TRY(pdi_key_check_all(ctx, text));
    pdi_scene_set_section_lines(&s);
    setup->has_flow = pdi_text_has_key(ctx, text, pdi_text_get_section(ctx, text, "flow", NULL), NULL);
    setup->has_gas = pdi_text_has_key(ctx, text, pdi_text_get_section(ctx, text, "gas", NULL), NULL);
    setup->has_transport = pdi_text_has_key(ctx, text, pdi_text_get_section(ctx, text, "transport", NULL), NULL);
    setup->has_solid = pdi_text_has_key(ctx, text, pdi_text_get_section(ctx, text, "solid", NULL), NULL);
    setup->has_dissolve = pdi_read_dissolution_has_section(&s, "dissolve");
    setup->has_corrode = pdi_read_dissolution_has_section(&s, "corrode");
    setup->has_potential = pdi_read_potential_has_sections(&s);
    PD_TRY(pdi_read_gas_check_alone(ctx, text, setup));
    PD_TRY(pdi_read_dissolution_begin(&s));
    PD_TRY(pdi_read_constants_read(ctx, text, &s.constants));
    PD_TRY(pdi_read_chemistry_read(&s));
    PD_TRY(pdi_read_tables_read(ctx, text, folder, setup));
    PD_TRY(pdi_read_shapes_read(ctx, text, folder, setup));
    PD_TRY(pdi_read_dissolution_constants(&s));
    PD_TRY(pdi_scene_read_grid(&s));
    PD_TRY(pdi_scene_read_sides(&s));
    PD_TRY(pdi_scene_read_flow(&s));
    PD_TRY(pdi_read_gas_read(ctx, text, setup));
    PD_TRY(pdi_scene_read_transport(&s));
    PD_TRY(pdi_read_surface_states_read(&s));
    PD_TRY(pdi_read_physics_read(&s));
    PD_TRY(pdi_read_dissolution_dissolve(&s));
    PD_TRY(pdi_read_dissolution_corrode(&s));
    PD_TRY(pdi_read_dissolution_rates(&s));
    PD_TRY(pdi_read_chemistry_surface_reactions(&s));
    PD_TRY(pdi_read_potential_read(&s));
    PD_TRY(pdi_read_surface_states_rates(&s));
    PD_TRY(pdi_read_mechanics_read(&s));
    PD_TRY(pdi_read_precracks_read(&s));
    pdi_read_mechanics_add_notes(&s);
    PD_TRY(pdi_scene_read_run(&s));
    PD_TRY(pdi_scene_read_output(&s));
    PD_TRY(pdi_read_monitors_read(ctx, text, setup));
    PD_TRY(pdi_read_measured_read(ctx, text, folder, setup));
    PD_TRY(pdi_text_check_unused(ctx, text));
    pdi_scene_add_renamed_notes(text, setup);
    if (!setup->has_flow && !setup->has_gas && !setup->has_transport && !setup->has_solid && !setup->has_chemistry &&
        !setup->has_potential && !setup->registered_count)
        return pdi_text_fail_key(ctx, text, 0, "scene",
                                 "found no physics, expected a [flow], [gas], [transport], [corrode], [chemistry], "
                                 "[potential] or [solid] section");
    return PD_OK;
}

/* Read a parsed text: a flat parameter file, or a scene with sections, whose included files and overrides are applied
 * first. The constants and tables of the readers are then detached from a scene with sections. PD_ERR_ARGUMENT: a text
 * without sections and pairs. */
static pd_status pdi_scene_read_text(pd_ctx *ctx, pd_text *text, const char *path, const char *const *overrides,
                                     int count, pd_setup *setup)
{
    if (text->section_count <= 1 && text->entry_count == 0)
        return pdi_text_fail_key(ctx, text, 0, "scene", "found an empty file, expected sections or lines key = value");
    if (pdi_text_is_flat(text)) return pdi_read_param_file_read(ctx, text, overrides, count, setup);
    PD_TRY(pdi_read_electrolyte_prepare(ctx, text, overrides, count));
    pd_status status = pdi_scene_read_sections(ctx, text, path, setup);
    text->consts = NULL;
    text->const_count = 0;
    text->tables = NULL;
    text->table_count = 0;
    return status;
}

/* Build a setup, with its fingerprint, from the text `bytes`, or from the file at `path` if bytes is NULL. path gives
 * the name of the setup and, if it is short enough, its source. On failure the setup is freed. */
static pd_status pdi_scene_build_setup(pd_ctx *ctx, const char *path, const char *bytes, const char *const *overrides,
                                       int count, pd_setup *setup)
{
    pd_text text;
    PD_TRY(pd_setup_init(ctx, setup));
    setup->picture_bytes = pdi_picture_memory_estimate;
    pdi_input_files_split_path(path, setup->name, NULL);
    if (strlen(path) < sizeof setup->source) memcpy(setup->source, path, strlen(path) + 1);
    pd_status status = bytes ? pdi_text_build(ctx, path, bytes, strlen(bytes), &text) : pdi_text_read(ctx, path, &text);
    if (status == PD_OK) {
        status = pdi_scene_read_text(ctx, &text, path, overrides, count, setup);
        if (status == PD_OK) status = pdi_fingerprint_build(ctx, &text, setup);
        pdi_text_free(ctx, &text);
    }
    if (status < 0) pd_setup_free(ctx, setup);
    return status;
}

pd_status pd_scene_read(pd_ctx *ctx, const char *path, const char *const *overrides, int count, pd_setup *setup)
{
    return pdi_scene_build_setup(ctx, path, NULL, overrides, count, setup);
}

pd_status pd_scene_parse(pd_ctx *ctx, const char *path, const char *text, const char *const *overrides, int count,
                         pd_setup *setup)
{
    return pdi_scene_build_setup(ctx, path, text, overrides, count, setup);
}
