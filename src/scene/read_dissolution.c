/* read_dissolution: see read_dissolution.h */
#include "scene/read_dissolution.h"
#include "scene/read_physics.h"
#include "scene/read_surface_states.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Horizon over the spacing from which on the speed of a front is isotropic on the lattice within 1 %. */
#define PDI_READ_DISSOLUTION_ISOTROPIC_M 3.0

PDI_FN int pdi_read_dissolution_has_section(pdi_reader *s, const char *name)
{
    for (int section = -1; (section = pdi_text_next_section(s->ctx, s->text, name, section)) >= 0;)
        if (pdi_text_has_key(s->ctx, s->text, section, NULL)) return 1;
    return 0;
}

/* Check that the label of each labelled section that has a pair is the name of a metal, and that its keys may differ
 * between metals: rate, law, current, rate_scale, Cs, charge, reaction. PD_ERR_ARGUMENT: they do not. */
static pd_status pdi_read_dissolution_check_labels(pdi_reader *s)
{
    static const char *const keys[] = {"rate", "law", "current", "rate_scale", "Cs", "charge", "reaction"};
    const pd_setup *u = s->setup;
    char names[PD_SETUP_METALS * 16] = "";
    for (int m = 0; m < u->metals; m++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", m ? ", " : "", u->metal[m].material.name);
    for (int k = 0; k < s->text->entry_count; k++) {
        const pd_text_entry *e = &s->text->entry[k];
        const pd_section *section = &s->text->section[e->section];
        int known = 0, single = 0;
        if (strcmp(section->name, pdi_reader_get_dissolution_name(u)) != 0 || !section->label[0]) continue;
        for (int m = 0; m < u->metals; m++) known |= strcmp(section->label, u->metal[m].material.name) == 0;
        for (size_t n = 0; n < sizeof keys / sizeof keys[0]; n++) single |= strcmp(e->key, keys[n]) == 0;
        if (!known)
            return pdi_text_fail_key(s->ctx, s->text, e->section, e->key,
                                     "found the metal '%.40s', expected a material of the shapes: %s", section->label,
                                     names);
        if (!single)
            return pdi_text_fail_key(
                s->ctx, s->text, e->section, e->key,
                "found in the section of one metal, expected it in [%s], which holds for all metals", section->name);
    }
    return PD_OK;
}

/* Set the constants rho_m, M_m, z_m and Cs, as far as they are declared, to those of a metal, for the numbers of its
 * section. */
static void pdi_read_dissolution_set_constants(pdi_reader *s, const pd_setup_metal *metal)
{
    static const char *const names[] = {"rho_m", "M_m", "z_m", "Cs"};
    const double values[] = {metal->material.density, metal->material.molar_mass, metal->material.charge,
                             metal->solid_c};
    for (int k = 0; k < s->constants.count; k++)
        for (size_t n = 0; n < sizeof names / sizeof names[0]; n++)
            if (strcmp(s->constants.symbol[k].name, names[n]) == 0) s->constants.symbol[k].value = values[n];
}

PDI_FN pd_status pdi_read_dissolution_constants(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int all = pdi_text_get_section(s->ctx, s->text, pdi_reader_get_dissolution_name(u), NULL);
    pdi_read_constants_add_builtin(s->text, &s->constants, "rho_m", "kg/m3", u->metal[0].material.density);
    pdi_read_constants_add_builtin(s->text, &s->constants, "M_m", "kg/mol", u->metal[0].material.molar_mass);
    pdi_read_constants_add_builtin(s->text, &s->constants, "z_m", "", u->metal[0].material.charge);
    if (u->has_dissolve) PD_TRY(pdi_read_dissolution_check_labels(s));
    for (int m = 0; m < u->metals && u->has_dissolve; m++) {
        pd_setup_metal *metal = &u->metal[m];
        int section = pdi_reader_find_dissolution(s, m, NULL);
        if (pdi_text_has_key(s->ctx, s->text, section, "charge"))
            PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "charge", &metal->material.charge));
        pdi_read_dissolution_set_constants(s, metal);
        if (pdi_text_has_key(s->ctx, s->text, section, "Cs"))
            PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "Cs", &metal->solid_c));
    }
    pdi_read_dissolution_set_constants(s, &u->metal[0]);
    pdi_read_constants_add_builtin(s->text, &s->constants, "Cs", "mol/m3", u->metal[0].solid_c);
    if (!u->has_dissolve || !pdi_text_has_key(s->ctx, s->text, all, "Csat")) return PD_OK;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, all, "Csat", &u->saturation));
    pdi_read_constants_add_builtin(s->text, &s->constants, "Csat", "mol/m3", u->saturation);
    return PD_OK;
}

/* ---- laws ---- */

/* Check a rate law that was read. PD_ERR_ARGUMENT: it uses grain and there are no grains, or it is a constant or
 * depends on C alone, and its speed at C = 0 is not within 0 to 1 m/s. For key `law` add a note on the speed of a
 * layer. */
static pd_status pdi_read_dissolution_check_rate(pdi_reader *s, int section, const char *key,
                                                 const pd_setup_metal *metal)
{
    double v = pd_setup_compute_rate_at_zero(metal);
    char slow[PD_UNITS_TEXT];
    if ((metal->rate.variables_used >> PD_SETUP_RATE_GRAIN & 1u) && !s->setup->has_grains)
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found the variable grain, expected grain_size = SIZE in a solid [shape ...]");
    if (metal->rate.variables_used <= 1 && (!(v >= 0.0) || v > 1.0))
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found a recession speed of %.6g m/s at C = 0, expected 0 to 1 m/s", v);
    if (strcmp(key, "law") != 0) return PD_OK;
    pd_setup_format_value(s->setup->h[0], "m", slow);
    pd_setup_add_note(s->setup, "law: one layer of %s a unit of the rate: %.6g um/h = %.6g mm/year at C = 0", slow,
                      v * 1e6 * 3600.0, v * 1e3 * 31557600.0);
    return PD_OK;
}

/* Make the symbol table vars[*count] of the rate law under `key`: C, t, x, y, z, grain, i (not among migrating ions),
 * E, fields of registered physics, whose units unit[] stores, pH, the species that its text names as [H+], whose names
 * name[] stores, and all surface states. A variable that the scene has no value for gets the name "". Without the key
 * no species and states are added. PD_ERR_ARGUMENT: the law is i alone among migrating ions, or names no solute. */
static pd_status pdi_read_dissolution_rate_symbols(pdi_reader *s, int section, const char *key, pd_setup_metal *metal,
                                                   pd_expr_symbol *vars, char (*unit)[PD_UNITS_TEXT],
                                                   char (*name)[PD_SPECIES_NAME + 2], int *count)
{
    const char *at;
    memcpy(vars, pd_setup_get_rate_symbols(), PD_SETUP_RATE_VARS * sizeof *vars);
    pdi_read_physics_set_symbols(s->setup, vars, unit);
    if (!s->setup->has_potential || s->setup->has_migration) vars[PD_SETUP_RATE_CURRENT].name = "";
    if (!s->setup->has_potential && !metal->has_potential) vars[PD_SETUP_RATE_POTENTIAL].name = "";
    memset(&vars[PD_SETUP_RATE_PH], 0, sizeof *vars);
    vars[PD_SETUP_RATE_PH].name = "pH";
    vars[PD_SETUP_RATE_PH].unit = "";
    *count = PD_SETUP_RATE_PH + 1;
    metal->species_count = 0;
    if (!pdi_text_has_key(s->ctx, s->text, section, key)) return PD_OK;
    if (s->setup->has_potential && s->setup->has_migration) {
        PD_TRY(pdi_text_get_string(s->ctx, s->text, section, key, NULL, &at));
        if (strcmp(at, "i") == 0)
            return pdi_text_fail_key(
                s->ctx, s->text, section, key,
                "found i, expected the anodic law itself among ions "
                "that migrate, in E: current = 0.1 A/m2*exp((E + 0.4 V)/(26 mV)); the curve of the "
                "electrode is what passes beside it");
    }
    return pdi_read_surface_states_symbols(s, section, key, vars, name, count, metal->species_index,
                                           &metal->species_count);
}

/* Read the prescribed electrode potential [V] of a metal in an electrolyte whose ions migrate, a function of t, if it
 * is given. metal->has_potential becomes 1 with it, and also where electrodes among migrating ions give the potential.
 * PD_ERR_ARGUMENT: the key beside such electrodes, without migration, beside a constant named E, or a function of x, y
 * or z. */
static pd_status pdi_read_dissolution_potential(pdi_reader *s, int section, pd_setup_metal *metal)
{
    if (pd_setup_has_ion_electrodes(s->setup)) metal->has_potential = 1;
    if (!pdi_text_has_key(s->ctx, s->text, section, "potential")) return PD_OK;
    if (metal->has_potential)
        return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                 "found beside an [electrode NAME], expected "
                                 "potential = E there");
    if (!s->setup->has_migration)
        return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                 "found without ions that carry a current, "
                                 "expected migration = yes in [chemistry], or [potential] and an [electrode NAME] with "
                                 "it");
    for (int n = 0; n < s->text->const_count; n++)
        if (strcmp(s->text->consts[n].name, "E") == 0)
            return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "constants", NULL), "E",
                                     "found the name 'E' beside potential of [dissolve], where it is a variable, "
                                     "expected another one");
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "potential", "V", pd_setup_get_position_symbols(),
                             PD_SETUP_POSITION_VARS, NULL, &metal->potential));
    metal->has_potential = 1;
    if (!(metal->potential.variables_used & ~((uint32_t)1 << PD_DIM))) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                             "found a function of the place, expected one of t "
                             "alone");
}

/* Check that the scene supports a rate law in pH, species, states or E; other laws pass. PD_ERR_ARGUMENT: pH without
 * species H+, C beside them, several metals without electrodes among ions, control = activation, driving_force =
 * difference, [corrode] beside electrodes among ions. Also a law in a field of registered physics beside such
 * electrodes. */
static pd_status pdi_read_dissolution_check_species_rate(pdi_reader *s, int section, const char *key,
                                                         const pd_setup_metal *metal)
{
    const pd_setup *u = s->setup;
    if (pd_setup_reads_registered_field(metal) && pd_setup_has_ion_electrodes(u))
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found a field of a physics of the program, expected none beside electrodes among "
                                 "ions that migrate");
    if (!pd_setup_has_species_rate(metal)) return PD_OK;
    int acid = u->has_chemistry && pd_electrolyte_find_species(&u->electrolyte, "H+") >= 0;
    if ((metal->rate.variables_used >> PD_SETUP_RATE_PH & 1u) && !acid)
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found pH without the species H+, expected [species H+] "
                                 "and others, or include = electrolytes/hbss.electrolyte in [chemistry]");
    if (metal->rate.variables_used & 1u)
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found C beside pH, species or E, expected the species "
                                 "of the dissolved metal, such as [Mg2+]");
    if (pd_setup_has_ion_electrodes(u) && u->has_corrode)
        return pdi_text_fail_key(s->ctx, s->text, section, key,
                                 "found E of electrodes among ions that migrate, expected "
                                 "[dissolve] there");
    if (pd_setup_has_ion_electrodes(u) && u->metals > 1) return PD_OK; /* see pdi_read_dissolution_check_several */
    if (u->metals > 1 || u->activation || u->drive == PD_DRIVE_DIFFERENCE)
        return pdi_text_fail_key(s->ctx, s->text, section, key, "found pH, species or E %s",
                                 u->metals > 1   ? "with several metals, expected one"
                                 : u->activation ? "with control = activation, expected diffusion"
                                                 : "with driving_force = difference, expected constant");
    return PD_OK;
}

/* Read the rate law under `key` in `unit` (speed, 1/s, or current density) into metal->rate, and multiply
 * metal->rate_scale by the key rate_scale. PD_ERR_ARGUMENT: the section has the key `other`, too, or the law is not
 * supported. PD_ERR_PARSE: there is no such key. With [dissolve] the key `potential` is read, too. */
static pd_status pdi_read_dissolution_rate(pdi_reader *s, int section, const char *key, const char *other,
                                           const char *unit, pd_setup_metal *metal)
{
    double factor;
    pd_expr_symbol vars[PD_EXPR_VARS];
    char name[PD_EXPR_VARS][PD_SPECIES_NAME + 2], units[PD_PHYSICS_TYPE_FIELDS][PD_UNITS_TEXT];
    int count;
    if (pdi_text_has_key(s->ctx, s->text, section, other) && strcmp(key, other) != 0)
        return pdi_text_fail_key(s->ctx, s->text, section, key, "found beside '%s', expected one of them", other);
    if (!s->setup->has_corrode) PD_TRY(pdi_read_dissolution_potential(s, section, metal));
    PD_TRY(pdi_read_dissolution_rate_symbols(s, section, key, metal, vars, units, name, &count));
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, key, unit, vars, count, NULL, &metal->rate));
    PD_TRY(pdi_read_dissolution_check_species_rate(s, section, key, metal));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "rate_scale", &factor));
    metal->rate_scale *= factor;
    return pdi_read_dissolution_check_rate(s, section, key, metal);
}

/* Read the rate law as a recession speed or as a current density, which metal->rate_scale converts to a speed by
 * Faraday's law with the charge and Cs of the metal. */
static pd_status pdi_read_dissolution_speed_or_current(pdi_reader *s, int section, pd_setup_metal *m)
{
    pd_material metal = m->material;
    int current = pdi_text_has_key(s->ctx, s->text, section, "current");
    metal.density = m->solid_c * metal.molar_mass;
    m->rate_scale = current ? pd_material_speed(&metal, 1.0) : 1.0;
    return pdi_read_dissolution_rate(s, section, current ? "current" : "rate", "rate", current ? "A/m2" : "m/s", m);
}

/* Read the rate law of [dissolve]: current density, which goes first, else layers of one cell per second (key `law`),
 * else speed. metal->rate_scale converts it to a speed. PD_ERR_ARGUMENT: `law` where spacings differ by more than 1e-9
 * of the first. */
static pd_status pdi_read_dissolution_dissolve_rate(pdi_reader *s, int section, pd_setup_metal *metal)
{
    const pd_setup *u = s->setup;
    int layers = pdi_text_has_key(s->ctx, s->text, section, "law");
    if (pdi_text_has_key(s->ctx, s->text, section, "current"))
        return pdi_read_dissolution_speed_or_current(s, section, metal);
    for (int d = 1; d < PD_DIM && layers; d++)
        if (fabs(u->h[d] - u->h[0]) > 1e-9 * u->h[0])
            return pdi_text_fail_key(s->ctx, s->text, section, "law",
                                     "found different spacings of the axes, expected rate = speed there");
    metal->rate_scale = layers ? u->h[0] : 1.0;
    return pdi_read_dissolution_rate(s, section, layers ? "law" : "rate", "rate", layers ? "1/s" : "m/s", metal);
}

/* Check several metals with electrodes among migrating ions where one has a rate law in E or species. PD_ERR_ARGUMENT:
 * a metal whose law has none of them and is not the constant 0, or covering_thickness with minerals and several such
 * metals. All other scenes pass. */
static pd_status pdi_read_dissolution_check_several(pdi_reader *s)
{
    const pd_setup *u = s->setup;
    if (!pd_setup_has_ion_electrodes(u) || u->metals == 1 || pd_setup_find_species_rate_metal(u) < 0) return PD_OK;
    for (int m = 0; m < u->metals; m++) {
        const pd_setup_metal *metal = &u->metal[m];
        if (pd_setup_has_species_rate(metal) ||
            (!metal->rate.variables_used && !(fabs(pd_setup_compute_rate_at_zero(metal)) > 0.0)))
            continue;
        int section = pdi_reader_find_dissolution(s, m, NULL);
        return pdi_text_fail_key(
            s->ctx, s->text, section, pdi_reader_get_rate_key(s, section),
            "found metal that "
            "dissolves without E beside metal that does by it, among ions that migrate, expected a "
            "law in E, or rate = 0 in [dissolve %s]",
            metal->material.name);
    }
    if (pd_setup_count_species_rate_metals(u) == 1 || !(u->shielding_thickness > 0.0) || !u->minerals) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "chemistry", NULL),
                             "covering_thickness",
                             "found "
                             "with several metals that dissolve among ions that migrate, expected one, or none");
}

PDI_FN pd_status pdi_read_dissolution_rates(pdi_reader *s)
{
    pd_setup *u = s->setup;
    pd_status status = PD_OK;
    for (int m = 0; m < u->metals && u->has_dissolve && status == PD_OK; m++) {
        int section = pdi_reader_find_dissolution(s, m, NULL);
        pdi_read_dissolution_set_constants(s, &u->metal[m]);
        status = u->has_corrode ? pdi_read_dissolution_speed_or_current(s, section, &u->metal[m])
                                : pdi_read_dissolution_dissolve_rate(s, section, &u->metal[m]);
        if (status == PD_OK && u->has_corrode && u->metal[m].solid_c <= u->saturation)
            return pdi_text_fail_key(s->ctx, s->text, section, "Csat",
                                     "found %.6g mol/m3, expected less than Cs = %.6g mol/m3 of %s", u->saturation,
                                     u->metal[m].solid_c, u->metal[m].material.name);
    }
    pdi_read_dissolution_set_constants(s, &u->metal[0]);
    return status == PD_OK ? pdi_read_dissolution_check_several(s) : status;
}

/* ---- what all metals share ---- */

/* Read the factor of the dissolution rate in grain boundaries. PD_ERR_ARGUMENT: it is not 1 and there are no grains. */
static pd_status pdi_read_dissolution_gb_factor(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "grain_boundary_factor", &u->gb_factor));
    if (!(fabs(u->gb_factor - 1.0) > 0.0) || u->has_grains) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "grain_boundary_factor",
                             "found %.6g without grains, expected grain_size = SIZE in a solid [shape ...]",
                             u->gb_factor);
}

PDI_FN pd_status pdi_read_dissolution_dissolve(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "dissolve", NULL);
    if (!u->has_dissolve || u->has_corrode) return PD_OK;
    if (!u->has_transport)
        return pdi_text_fail_key(s->ctx, s->text, section, "dissolve",
                                 "found no [transport] section, expected one: the metal goes into the fluid");
    if (u->solid < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "dissolve",
                                 "found no solid, expected a [shape ...] with kind"
                                 " = solid");
    PD_TRY(pdi_read_dissolution_gb_factor(s, section));
    return pdi_key_value_get_number(s->ctx, s->text, section, "threshold", &u->threshold);
}

/* Before anything of the other sections is read. */
PDI_FN pd_status pdi_read_dissolution_begin(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "corrode", NULL);
    if (!u->has_corrode) return PD_OK;
    if (u->has_dissolve)
        return pdi_text_fail_key(s->ctx, s->text, section, "corrode",
                                 "found beside [dissolve], expected one of them: each says how the metal goes");
    u->has_transport = u->has_dissolve = 1;
    return PD_OK;
}

PDI_FN pd_status pdi_read_dissolution_horizons(pdi_reader *s, int grid)
{
    pd_setup *u = s->setup;
    int metal = pdi_text_get_section(s->ctx, s->text, pdi_reader_get_dissolution_name(u), NULL);
    int given = pdi_text_has_key(s->ctx, s->text, grid, "m");
    int own = u->has_dissolve && pdi_text_has_key(s->ctx, s->text, metal, "m");
    u->fluid_m = u->has_corrode ? PDI_READ_DISSOLUTION_ISOTROPIC_M : 1.0;
    if (given) PD_TRY(pdi_key_value_get_number(s->ctx, s->text, grid, "m", &u->fluid_m));
    u->metal_m = u->has_corrode ? u->fluid_m : pd_max(PDI_READ_DISSOLUTION_ISOTROPIC_M, u->fluid_m);
    if (!own) return PD_OK;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, metal, "m", &u->metal_m));
    if (u->has_corrode && !given) u->fluid_m = u->metal_m;
    if (u->has_corrode || u->metal_m >= u->fluid_m) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, metal, "m",
                             "found %.6g, expected at least the horizon of the fluid, m = %.6g of [grid]", u->metal_m,
                             u->fluid_m);
}

/* Read the variant of the bond-based model: control, driving force, kernel, weights, random breaking of bonds with its
 * seed. PD_ERR_ARGUMENT: control = activation or weights = published beside [flow], or a seed without breaking =
 * stochastic. */
static pd_status pdi_read_dissolution_corrode_variant(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    int drive, kernel, printed;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "control", &u->activation));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "driving_force", &drive));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "kernel", &kernel));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "weights", &printed));
    u->drive = (pd_drive)drive;
    u->kernel = (pd_kernel)kernel;
    u->weights = printed ? PD_WEIGHTS_PUBLISHED : PD_WEIGHTS_CALIBRATED;
    if (u->activation && u->has_flow)
        return pdi_text_fail_key(s->ctx, s->text, section, "control",
                                 "found 'activation' beside [flow], expected diffusion: with activation all fluid holds"
                                 " bulk");
    if (printed && u->has_flow)
        return pdi_text_fail_key(s->ctx, s->text, section, "weights",
                                 "found 'published' beside [flow], expected calibrated: no flow is exact with others");
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "breaking", &u->stochastic));
    if (u->stochastic) return pdi_key_value_get_index(s->ctx, s->text, section, "seed", &u->seed);
    if (!pdi_text_has_key(s->ctx, s->text, section, "seed")) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "seed", "found without breaking = stochastic, expected both");
}

/* Read D and the initial concentration, unless there is a [transport] section, and the bulk concentration, at most
 * Csat. D is required, with control = activation 0 by default. A note tells that activation uses neither of them.
 * PD_ERR_ARGUMENT: D or initial beside [transport]. */
static pd_status pdi_read_dissolution_corrode_fluid(pdi_reader *s, int section)
{
    static const char *const keys[] = {"D", "initial"};
    pd_setup *u = s->setup;
    int transport = pdi_text_has_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "transport", NULL), NULL);
    for (int k = 0; k < 2 && transport; k++)
        if (pdi_text_has_key(s->ctx, s->text, section, keys[k]))
            return pdi_text_fail_key(s->ctx, s->text, section, keys[k],
                                     "found beside a [transport] section, expected it there");
    if (!transport) {
        PD_TRY(pdi_key_value_get_number_or(s->ctx, s->text, section, "D", u->activation ? "0" : NULL, &u->diffusivity));
        PD_TRY(pdi_reader_read_initial(s, section));
    }
    if (u->activation && (u->diffusivity > 0.0 || pdi_text_has_key(s->ctx, s->text, section, "initial")))
        pd_setup_add_note(u, "D and initial belong to control = diffusion; with activation all fluid holds bulk");
    return pdi_key_value_get_number_up_to(s->ctx, s->text, section, "bulk", u->saturation, &u->bulk_c);
}

/* Csat is read for its check alone, at most Cs of the first metal: pdi_read_dissolution_constants has stored it. */
PDI_FN pd_status pdi_read_dissolution_corrode(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "corrode", NULL);
    double saturation;
    if (!u->has_corrode) return PD_OK;
    if (u->solid < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "corrode",
                                 "found no solid, expected a [shape ...] with kind = solid");
    PD_TRY(pdi_read_dissolution_corrode_variant(s, section));
    PD_TRY(pdi_key_value_get_number_up_to(s->ctx, s->text, section, "Csat", u->metal[0].solid_c, &saturation));
    PD_TRY(pdi_read_dissolution_gb_factor(s, section));
    PD_TRY(pdi_read_dissolution_corrode_fluid(s, section));
    if (pdi_text_has_key(s->ctx, s->text, section, "repassivation"))
        PD_TRY(pdi_key_value_get_number_up_to(s->ctx, s->text, section, "repassivation", u->saturation,
                                              &u->repassivation));
    if (u->activation && u->repassivation > 0.0)
        return pdi_text_fail_key(s->ctx, s->text, section, "repassivation",
                                 "found beside control = activation, expected diffusion: there all fluid holds bulk");
    return PD_OK;
}

#undef PDI_READ_DISSOLUTION_ISOTROPIC_M
