/* read_mechanics: see read_mechanics.h */
#include "scene/read_mechanics.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const pdi_read_mechanics_displacement_keys[] = {"ux", "uy", "uz"};

/* Append a mechanical boundary condition for a section; *grip: the new entry. PD_ERR_ARGUMENT: too many. */
static pd_status pdi_read_mechanics_add_bc(pd_ctx *ctx, pd_text *text, int section, pd_setup *u,
                                           pd_setup_mechanical_bc **grip)
{
    pd_setup_mechanics *b = &u->metal_body;
    if (b->mechanical_bcs == PD_SETUP_MECHANICAL_BCS)
        return pdi_text_fail_key(ctx, text, section, "ux",
                                 "found more than %d sides and shapes that hold or load metal",
                                 PD_SETUP_MECHANICAL_BCS);
    *grip = &b->mechanical_bc[b->mechanical_bcs++];
    (*grip)->side = (*grip)->shape = -1;
    (*grip)->section = section;
    return PD_OK;
}

/* Read the prescribed displacements ux, uy, uz [m], expressions in x, y, z, t, and set has_displacement of their axes;
 * axes without a key are free. */
static pd_status pdi_read_mechanics_displacements(pd_ctx *ctx, pd_text *text, int section, pd_setup_mechanical_bc *grip)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (!pdi_text_has_key(ctx, text, section, pdi_read_mechanics_displacement_keys[d])) continue;
        PD_TRY(pdi_text_get_expr(ctx, text, section, pdi_read_mechanics_displacement_keys[d], "m",
                                 pd_setup_get_position_symbols(), PD_SETUP_POSITION_VARS, NULL,
                                 &grip->displacement[d]));
        grip->has_displacement[d] = 1;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_mechanics_shape_bc(pd_ctx *ctx, pd_text *text, int section, int shape, pd_setup *u)
{
    pd_setup_mechanical_bc *grip = NULL;
    int moves = 0;
    if (!u->has_solid) return pdi_text_fail_key(ctx, text, section, "kind", "found 'grip' without a [solid] section");
    PD_TRY(pdi_read_mechanics_add_bc(ctx, text, section, u, &grip));
    grip->shape = shape;
    PD_TRY(pdi_read_mechanics_displacements(ctx, text, section, grip));
    for (int d = 0; d < PD_DIM; d++) moves = moves || grip->has_displacement[d];
    if (moves) return PD_OK;
    return pdi_text_fail_key(ctx, text, section, "kind",
                             "found a grip that holds nothing, expected ux = ... or another "
                             "displacement");
}

/* Read all PD_DIM components of a vector of expressions in x, y, z, t into expr[PD_DIM]. PD_ERR_ARGUMENT: fewer
 * components; PD_ERR_PARSE: more. */
static pd_status pdi_read_mechanics_vector(pdi_reader *s, int section, const char *key, const char *unit, pd_expr *expr)
{
    int count;
    PD_TRY(pdi_text_get_exprs(s->ctx, s->text, section, key, unit, pd_setup_get_position_symbols(),
                              PD_SETUP_POSITION_VARS, NULL, PD_DIM, expr, &count));
    if (count == PD_DIM) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, key, "found %d components, expected %d", count, PD_DIM);
}

/* Read the displacement, traction and pressure of one side of the box as one new boundary condition. A side without any
 * of these keys adds none. */
static pd_status pdi_read_mechanics_side_bc(pdi_reader *s, int side)
{
    static const char *const loads[] = {"traction", "pressure"};
    int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(side)), any = 0;
    pd_setup_mechanical_bc *grip = NULL;
    if (section < 0) return PD_OK;
    for (int d = 0; d < PD_DIM; d++)
        any = any || pdi_text_has_key(s->ctx, s->text, section, pdi_read_mechanics_displacement_keys[d]);
    for (int k = 0; k < 2; k++) any = any || pdi_text_has_key(s->ctx, s->text, section, loads[k]);
    if (!any) return PD_OK;
    PD_TRY(pdi_read_mechanics_add_bc(s->ctx, s->text, section, s->setup, &grip));
    grip->side = side;
    PD_TRY(pdi_read_mechanics_displacements(s->ctx, s->text, section, grip));
    grip->has_traction = pdi_text_has_key(s->ctx, s->text, section, "traction");
    grip->has_pressure = pdi_text_has_key(s->ctx, s->text, section, "pressure");
    if (grip->has_traction) PD_TRY(pdi_read_mechanics_vector(s, section, "traction", "Pa", grip->traction));
    if (!grip->has_pressure) return PD_OK;
    return pdi_text_get_expr(s->ctx, s->text, section, "pressure", "Pa", pd_setup_get_position_symbols(),
                             PD_SETUP_POSITION_VARS, NULL, &grip->pressure);
}

/* Read the mechanical boundary conditions of all sides. PD_ERR_ARGUMENT: a side is periodic, or there is neither a
 * condition of a side or grip nor a body force. */
static pd_status pdi_read_mechanics_sides(pdi_reader *s, int section)
{
    const pd_setup *u = s->setup;
    for (int k = 0; k < 2 * PD_DIM; k++) PD_TRY(pdi_read_mechanics_side_bc(s, k));
    for (int k = 0; k < 2 * PD_DIM; k++)
        if (u->side[k].kind == PD_SIDE_PERIODIC)
            return pdi_text_fail_key(s->ctx, s->text, section, "solid",
                                     "found beside a periodic side, expected sides"
                                     " that end the metal: bonds of a body do not pass them");
    if (u->metal_body.mechanical_bcs || u->metal_body.has_body_force) return PD_OK;
    return pdi_text_fail_key(
        s->ctx, s->text, section, "solid",
        "found nothing that loads the metal, expected ux = ..., "
        "traction = ... or pressure = ... in a [side ...], kind = grip in a [shape ...], or body_force");
}

/* Append a monitor of solid mechanics, zero but for its kind, index, line and name. index: of the boundary condition, 0
 * for the body; name: of its table. PD_ERR_ARGUMENT: PD_SETUP_MONITORS are there. */
static pd_status pdi_read_mechanics_add_monitor(pdi_reader *s, int section, pd_monitor_kind kind, int index,
                                                const char *name)
{
    pd_setup *u = s->setup;
    if (u->monitors == PD_SETUP_MONITORS)
        return pdi_text_fail_key(s->ctx, s->text, section, "solid", "found more than %d tables", PD_SETUP_MONITORS);
    pd_setup_monitor *m = &u->monitor[u->monitors++];
    memset(m, 0, sizeof *m);
    m->kind = kind;
    m->index = index;
    m->line = s->text->section[section].line;
    snprintf(m->name, sizeof m->name, "%s", name);
    return PD_OK;
}

/* Add monitors of all mechanical boundary conditions and of the body. */
static pd_status pdi_read_mechanics_add_monitors(pdi_reader *s, int section)
{
    const pd_setup_mechanics *b = &s->setup->metal_body;
    for (int k = 0; k < b->mechanical_bcs; k++) {
        const char *name = s->text->section[b->mechanical_bc[k].section].label;
        PD_TRY(pdi_read_mechanics_add_monitor(s, b->mechanical_bc[k].section, PD_MONITOR_MECHANICAL_BC, k, name));
    }
    return pdi_read_mechanics_add_monitor(s, section, PD_MONITOR_SOLID, 0, "metal");
}

static const char *const pdi_read_mechanics_material_names[] = {"correspondence", "bond_based", "ordinary",
                                                                "neo_hookean",    "hencky",     NULL};

/* Part of messages: which failure criteria each material supports. */
#define PDI_READ_MECHANICS_SUPPORT_TEXT \
    "correspondence breaks by fracture_energy (without yield_stress), strength or critical_stretch, at rest; " \
    "ordinary, neo_hookean and " \
    "hencky by strength or critical_stretch, at rest; bond_based by fracture_energy, at rest and in motion; " \
    "yield_stress is of " \
    "correspondence and hencky at rest"

/* 1: the material is bond-based. */
static int pdi_read_mechanics_is_bond_based(const pd_setup_mechanics *b)
{
    return b->material == PD_SOLID_COUPLING_BOND_BASED;
}

/* Read Poisson's ratio; in 1D do nothing. That of the bond-based material is fixed, 1/3 in plane stress, else 1/4, and
 * may be left out. PD_ERR_ARGUMENT: a value that differs from it by 1e-3 or more, or a negative one of neo_hookean in
 * plane stress. */
static pd_status pdi_read_mechanics_poisson(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    double own = PD_DIM == 2 && b->plane == PD_PLANE_STRESS ? 1.0 / 3.0 : 0.25;
    int rubber = b->material == PD_SOLID_COUPLING_NEO_HOOKEAN;
    if (PD_DIM == 1) return PD_OK;
    if (pdi_read_mechanics_is_bond_based(b) && !pdi_text_has_key(s->ctx, s->text, section, "nu")) {
        b->poisson = own;
        return PD_OK;
    }
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "nu", &b->poisson));
    if (rubber && b->plane == PD_PLANE_STRESS && b->poisson < 0.0)
        return pdi_text_fail_key(s->ctx, s->text, section, "nu",
                                 "found %g with model = neo_hookean and plane = stress, expected at least 0",
                                 b->poisson);
    if (!pdi_read_mechanics_is_bond_based(b) || fabs(b->poisson - own) < 1e-3) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "nu",
                             "found %g with model = bond_based, expected their %g, or "
                             "another material: " PDI_READ_MECHANICS_SUPPORT_TEXT,
                             b->poisson, own);
}

/* Read yield stress and linear hardening. A yield stress of 0 means elastic. PD_ERR_ARGUMENT: hardening without yield
 * stress, a material other than correspondence and hencky, a yield stress below 1000 rtol E, or correspondence in 2D
 * plane stress. */
static pd_status pdi_read_mechanics_plasticity(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "yield_stress", &b->yield));
    if (pdi_text_has_key(s->ctx, s->text, section, "hardening_modulus") && !(b->yield > 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "hardening_modulus",
                                 "found without yield_stress, expected both");
    if (!(b->yield > 0.0)) return PD_OK;
    if (b->material != PD_SOLID_COUPLING_CORRESPONDENCE && b->material != PD_SOLID_COUPLING_HENCKY)
        return pdi_text_fail_key(s->ctx, s->text, section, "yield_stress",
                                 "found with model = %s, expected another one of "
                                 "both: " PDI_READ_MECHANICS_SUPPORT_TEXT,
                                 pdi_read_mechanics_material_names[b->material]);
    if (b->yield < 1e3 * b->rtol * b->young)
        return pdi_text_fail_key(s->ctx, s->text, section, "yield_stress",
                                 "found %g Pa, expected 0 or at least 1000 rtol E = "
                                 "%g Pa: balances are no finer",
                                 b->yield, 1e3 * b->rtol * b->young);
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "hardening_modulus", &b->hardening));
    if (PD_DIM != 2 || b->plane == PD_PLANE_STRAIN || b->material == PD_SOLID_COUPLING_HENCKY) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "yield_stress",
                             "found with plane = stress, expected plane = strain or "
                             "model = hencky");
}

/* Read the failure criterion: at most one of critical stretch, strength and toughness (key `fracture_energy`); 0 counts
 * as not given. PD_ERR_ARGUMENT: two of them, or toughness with a material other than correspondence, in 3D with m
 * outside 1.5 to 3, or with a yield stress. */
static pd_status pdi_read_mechanics_failure(pdi_reader *s, int section)
{
    static const char *const keys[] = {"critical_stretch", "strength", "fracture_energy"};
    pd_setup_mechanics *b = &s->setup->metal_body;
    const char *found = NULL;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "critical_stretch", &b->stretch));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "strength", &b->strength));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "fracture_energy", &b->toughness));
    for (int k = 0; k < 3; k++) {
        double value = k == 0 ? b->stretch : k == 1 ? b->strength : b->toughness;
        if (!(value > 0.0)) continue;
        if (found)
            return pdi_text_fail_key(s->ctx, s->text, section, keys[k],
                                     "found beside %s, expected one of "
                                     "critical_stretch, strength and fracture_energy",
                                     found);
        found = keys[k];
    }
    if (!(b->toughness > 0.0)) return PD_OK;
    if (b->material != PD_SOLID_COUPLING_CORRESPONDENCE)
        return pdi_text_fail_key(s->ctx, s->text, section, "fracture_energy",
                                 "found with model = %s, expected another one "
                                 "of both: " PDI_READ_MECHANICS_SUPPORT_TEXT,
                                 pdi_read_mechanics_material_names[b->material]);
    if (PD_DIM == 3 && (b->m < 1.5 || b->m > 3.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "fracture_energy",
                                 "found with m = %g, expected m = 1.5 to 3 in 3D", b->m);
    if (!(b->yield > 0.0)) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "fracture_energy",
                             "found with yield_stress, expected "
                             "critical_stretch or strength: energies of bonds are those of metal that does not flow");
}

/* Read plasticity and failure. PD_ERR_ARGUMENT: any key of them, or dissolution_factor, with dynamics or the bond-based
 * material, where only the toughness of the bond-based one is admitted, which is then read. */
static pd_status pdi_read_mechanics_plasticity_failure(pdi_reader *s, int section)
{
    static const char *const still[] = {"yield_stress", "hardening_modulus",  "critical_stretch",
                                        "strength",     "dissolution_factor", "fracture_energy"};
    pd_setup_mechanics *b = &s->setup->metal_body;
    int moves = b->density > 0.0, springs = pdi_read_mechanics_is_bond_based(b);
    for (int k = 0; k < (springs ? 5 : 6); k++)
        if ((springs || moves) && pdi_text_has_key(s->ctx, s->text, section, still[k]))
            return pdi_text_fail_key(s->ctx, s->text, section, still[k],
                                     "found with %s, expected another one of both: " PDI_READ_MECHANICS_SUPPORT_TEXT,
                                     springs ? "model = bond_based" : "dynamics = yes");
    if (springs) return pdi_key_value_get_number(s->ctx, s->text, section, "fracture_energy", &b->toughness);
    PD_TRY(pdi_read_mechanics_plasticity(s, section));
    return pdi_read_mechanics_failure(s, section);
}

/* Read whether the metal moves dynamically, and, if it does, its density [kg/m3], which stays 0 at rest.
 * PD_ERR_ARGUMENT: dynamics or the bond-based material beside metal that dissolves, or a density without dynamics. */
static pd_status pdi_read_mechanics_dynamics(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    int moves;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "dynamics", &moves));
    if (s->setup->has_dissolve && (moves || pdi_read_mechanics_is_bond_based(b)))
        return pdi_text_fail_key(s->ctx, s->text, section, moves ? "dynamics" : "model",
                                 "found beside metal that dissolves, expected %s",
                                 moves ? "dynamics = no" : "model = correspondence");
    if (moves) return pdi_key_value_get_number(s->ctx, s->text, section, "density", &b->density);
    if (!pdi_text_has_key(s->ctx, s->text, section, "density")) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "density", "found without dynamics = yes, expected both");
}

/* Read the material of [solid]: constitutive law, E (PD_ERR_ARGUMENT: below 1e-30 Pa), nu, plane (2D only), influence
 * function, horizon over h (2 by default, bond-based 3), tolerance, dynamics, plasticity and failure. */
static pd_status pdi_read_mechanics_material(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    int plane = 0, influence, material;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "model", &material));
    b->material = (pd_solid_coupling_material)material;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "E", &b->young));
    if (b->young < 1e-30)
        return pdi_text_fail_key(s->ctx, s->text, section, "E", "found %g Pa, expected at least 1e-30 Pa", b->young);
    if (PD_DIM == 2) PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "plane", &plane));
    b->plane = (pd_plane)plane;
    PD_TRY(pdi_read_mechanics_poisson(s, section));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "influence", &influence));
    b->influence = (pd_influence)influence;
    PD_TRY(pdi_key_value_get_number_or(s->ctx, s->text, section, "m", pdi_read_mechanics_is_bond_based(b) ? "3" : "2",
                                       &b->m));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "rtol", &b->rtol));
    PD_TRY(pdi_read_mechanics_dynamics(s, section));
    return pdi_read_mechanics_plasticity_failure(s, section);
}

/* ---- known limits ---- */

/* Poisson's ratio above which locking makes displacements of a bent body of 16 cells too small by more than 5 %: with a
 * horizon above 1 cell, and with m = 1. */
#define PDI_READ_MECHANICS_NU_LOCKING 0.45
#define PDI_READ_MECHANICS_NU_LOCKING_M1 0.48

PDI_FN void pdi_read_mechanics_add_notes(pdi_reader *s)
{
    pd_setup *u = s->setup;
    const pd_setup_mechanics *b = &u->metal_body;
    int stress = PD_DIM == 2 && b->plane == PD_PLANE_STRESS;
    int families = b->material != PD_SOLID_COUPLING_BOND_BASED && b->material != PD_SOLID_COUPLING_ORDINARY_STATE;
    if (!u->has_solid) return;
    for (int k = 1; k < u->metals; k++)
        pd_setup_add_note(u,
                          "solid: %.40s has the E and nu of %.40s, since [solid] has one of each; expected the metal "
                          "that bears the load alone with kind = solid, and a grip where the other one holds it",
                          u->metal[k].material.name, u->metal[0].material.name);
    if (b->toughness > 0.0 && !b->precracks)
        pd_setup_add_note(
            u, "solid: fracture_energy without a [crack]: the load that begins a crack in smooth metal, or at a "
               "notch, depends on h, about as 1/sqrt(h); expected a [crack ...], or strength = ...");
    if (PD_DIM > 1 && !stress && families &&
        b->poisson > (b->m > 1.0 ? PDI_READ_MECHANICS_NU_LOCKING : PDI_READ_MECHANICS_NU_LOCKING_M1))
        pd_setup_add_note(u,
                          "solid: nu = %g with model = %s: metal that is bent over 16 cells is too stiff by more "
                          "than 5 %%, near 1/2 by half; expected nu up to %g, model = ordinary, or plane = stress",
                          b->poisson, pdi_read_mechanics_material_names[b->material], PDI_READ_MECHANICS_NU_LOCKING);
}

/* Read the factor [-] by which stress changes the dissolution rate (key `dissolution_factor`), if it is given, and set
 * has_rate_factor. PD_ERR_ARGUMENT: no metal dissolves. */
static pd_status pdi_read_mechanics_rate_factor(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    if (!pdi_text_has_key(s->ctx, s->text, section, "dissolution_factor")) return PD_OK;
    if (!s->setup->has_dissolve)
        return pdi_text_fail_key(s->ctx, s->text, section, "dissolution_factor",
                                 "found without metal that dissolves, expected a [dissolve] or [corrode] section");
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "dissolution_factor", "", pd_setup_get_stress_symbols(),
                             PD_SETUP_STRESS_VARS, NULL, &b->rate_factor));
    b->has_rate_factor = 1;
    return PD_OK;
}

/* 1: a displacement, traction, pressure or body force depends on time. */
static int pdi_read_mechanics_is_time_dependent(const pd_setup_mechanics *b)
{
    int timed = 0;
    for (int k = 0; k < b->mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &b->mechanical_bc[k];
        for (int d = 0; d < PD_DIM; d++) {
            timed = timed || (grip->has_displacement[d] && pd_setup_is_time_dependent(&grip->displacement[d]));
            timed = timed || (grip->has_traction && pd_setup_is_time_dependent(&grip->traction[d]));
        }
        timed = timed || (grip->has_pressure && pd_setup_is_time_dependent(&grip->pressure));
    }
    for (int d = 0; d < PD_DIM; d++) timed = timed || (b->has_body_force && pd_setup_is_time_dependent(&b->force[d]));
    return timed;
}

PDI_FN pd_status pdi_read_mechanics_read(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "solid", NULL);
    if (!u->has_solid) return PD_OK;
    if (u->axisymmetric)
        return pdi_text_fail_key(s->ctx, s->text, section, "solid",
                                 "found in a box with geometry = axisymmetric, expected planar");
    if (u->solid < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "solid",
                                 "found no metal, expected a [shape ...] with kind = "
                                 "solid");
    for (int d = 1; d < PD_DIM; d++)
        if (fabs(u->h[d] - u->h[0]) > 1e-9 * u->h[0])
            return pdi_text_fail_key(s->ctx, s->text, section, "solid",
                                     "found different spacings of the axes, expected one h");
    PD_TRY(pdi_read_mechanics_material(s, section));
    u->metal_body.has_body_force = pdi_text_has_key(s->ctx, s->text, section, "body_force");
    if (u->metal_body.has_body_force)
        PD_TRY(pdi_read_mechanics_vector(s, section, "body_force", "N/m3", u->metal_body.force));
    PD_TRY(pdi_read_mechanics_sides(s, section));
    u->metal_body.is_time_dependent = pdi_read_mechanics_is_time_dependent(&u->metal_body);
    PD_TRY(pdi_read_mechanics_add_monitors(s, section));
    return pdi_read_mechanics_rate_factor(s, section);
}

#undef PDI_READ_MECHANICS_SUPPORT_TEXT
#undef PDI_READ_MECHANICS_NU_LOCKING
#undef PDI_READ_MECHANICS_NU_LOCKING_M1
