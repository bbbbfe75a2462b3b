/* read_electrolyte: see read_electrolyte.h */
#include "scene/read_electrolyte.h"
#include "scene/key_value.h"
#include "core/vec.h"
#include "scene/include_files.h"
#include "scene/override.h"
#include "scene/key_check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PDI_READ_ELECTROLYTE_WATER_C 55.34e3    /* [mol/m3] of water at 25 C: 997.05 kg/m3 over 18.015 g/mol */
#define PDI_READ_ELECTROLYTE_LITRES_PER_M3 1e3  /* in a m3 */
#define PDI_READ_ELECTROLYTE_REFERENCE_T 298.15 /* [K] reference temperature of tabulated constants */

/* State of the reader: the electrolyte to fill, and the section of each species for messages. */
typedef struct pdi_read_electrolyte_state {
    pd_ctx *ctx;
    pd_text *text;
    pd_electrolyte *electrolyte;
    int chemistry;                    /* section */
    int diffusion_by_viscosity;       /* 1: diffusivities follow the viscosity of water */
    int section[PD_SPECIES_MAX];      /* of each species */
} pdi_read_electrolyte_state;

/* Report a failed call of the chemistry room with file:line and key in place of the location in its message. Returns
 * PD_ERR_ARGUMENT, or the status of that call, with its message, where it is fatal (out of memory, cancelled). */
static pd_status pdi_read_electrolyte_fail(const pdi_read_electrolyte_state *s, int section, const char *key)
{
    char message[PD_MESSAGE_SIZE];
    pd_status status = s->ctx->status;
    if (pd_is_fatal(status)) return status;
    const char *what = strstr(s->ctx->message, ": ");
    snprintf(message, sizeof message, "%s", what ? what + 2 : s->ctx->message);
    return pdi_text_fail_key(s->ctx, s->text, section, key, "%.500s", message);
}

/* ---- temperature ---- */

/* Read the temperature [K] first, since constants depend on it, and declare it as the constant T. Read how
 * diffusivities follow it. PD_ERR_ARGUMENT: the scene has a constant T. */
static pd_status pdi_read_electrolyte_temperature(pdi_read_electrolyte_state *s, pdi_read_constants_table *named)
{
    double *t = &s->electrolyte->temperature;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, s->chemistry, "temperature", t));
    for (int k = 0; k < named->count; k++)
        if (strcmp(named->symbol[k].name, "T") == 0)
            return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "constants", NULL), "T",
                                     "found beside species, where T is their temperature, expected another name");
    pdi_read_constants_add_builtin(s->text, named, "T", "K", *t);
    return pdi_key_value_get_index(s->ctx, s->text, s->chemistry, "diffusion", &s->diffusion_by_viscosity);
}

/* Arrhenius factor of a rate or diffusivity from 25 C to the temperature: exp(energy/R (1/T0 - 1/T)); energy
 * [J/mol]. */
static double pdi_read_electrolyte_arrhenius_factor(const pdi_read_electrolyte_state *s, double energy)
{
    return exp(energy / PD_GAS_CONSTANT *
               (1.0 / PDI_READ_ELECTROLYTE_REFERENCE_T - 1.0 / s->electrolyte->temperature));
}

/* log10 of the viscosity of water at `celsius` [C] over that at 20 C: Kestin, Sokolov and Wakeham 1978. */
static double pdi_read_electrolyte_log_viscosity(double celsius)
{
    double less = 20.0 - celsius;
    return less / (celsius + 96.0) * (1.2364 - less * (1.37e-3 - less * 5.7e-6));
}

/* Factor of a diffusivity from 25 C to the temperature by Stokes-Einstein: D mu/T is constant. */
static double pdi_read_electrolyte_stokes_einstein_factor(const pdi_read_electrolyte_state *s)
{
    double t = s->electrolyte->temperature, ice = 273.15;
    double more = pdi_read_electrolyte_log_viscosity(PDI_READ_ELECTROLYTE_REFERENCE_T - ice);
    more -= pdi_read_electrolyte_log_viscosity(t - ice);
    return t / PDI_READ_ELECTROLYTE_REFERENCE_T * pow(10.0, more);
}

/* Read the diffusivity [m2/s] at 25 C and convert it to the temperature: by the activation energy, if it is given, else
 * by the viscosity of water with diffusion = viscosity, else not. */
static pd_status pdi_read_electrolyte_diffusivity(pdi_read_electrolyte_state *s, int section, double *diffusivity)
{
    double energy;
    int own = pdi_text_has_key(s->ctx, s->text, section, "activation_energy");
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "D", diffusivity));
    if (own) {
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "activation_energy", &energy));
        *diffusivity *= pdi_read_electrolyte_arrhenius_factor(s, energy);
    } else if (s->diffusion_by_viscosity) {
        *diffusivity *= pdi_read_electrolyte_stokes_einstein_factor(s);
    }
    return PD_OK;
}

/* ---- [species FORMULA] ---- */

/* Read the concentration [mol/m3] of the species in work in the inlet or inside solution; default: the initial one, 0
 * of solids. PD_ERR_ARGUMENT: it is given of a solid. */
static pd_status pdi_read_electrolyte_other_concentration(pdi_read_electrolyte_state *s, int section, const char *key,
                                                          double *value)
{
    const pd_electrolyte *e = s->electrolyte;
    int solid = e->species[e->count].phase == PD_PHASE_SOLID;
    *value = solid ? 0.0 : e->initial[e->count];
    if (!pdi_text_has_key(s->ctx, s->text, section, key)) return PD_OK;
    if (!solid) return pdi_key_value_get_number(s->ctx, s->text, section, key, value);
    return pdi_text_fail_key(s->ctx, s->text, section, key, "found it of the solid %s, which does not flow",
                             e->species[e->count].name);
}

/* Read one [species FORMULA] section and append it to the electrolyte: formula, charge, D, concentrations, molar
 * volume. PD_ERR_ARGUMENT: no label, PD_SPECIES_MAX species, a formula that is refused, an activation energy without D,
 * or a molar volume of a species that is no solid. */
static pd_status pdi_read_electrolyte_one_species(pdi_read_electrolyte_state *s, int section)
{
    pd_electrolyte *e = s->electrolyte;
    pd_species_desc desc;
    const char *label = s->text->section[section].label;
    int k = e->count;
    memset(&desc, 0, sizeof desc);
    desc.name = label;
    if (!label[0])
        return pdi_text_fail_key(s->ctx, s->text, section, "species",
                                 "found no name, expected [species Mg2+] or another "
                                 "formula");
    if (k == PD_SPECIES_MAX)
        return pdi_text_fail_key(s->ctx, s->text, section, "species", "found more than %d species, expected fewer",
                                 PD_SPECIES_MAX);
    if (pdi_text_has_key(s->ctx, s->text, section, "formula"))
        PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "formula", NULL, &desc.formula));
    desc.has_charge = pdi_text_has_key(s->ctx, s->text, section, "charge");
    if (desc.has_charge) PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "charge", &desc.charge));
    if (pdi_text_has_key(s->ctx, s->text, section, "D"))
        PD_TRY(pdi_read_electrolyte_diffusivity(s, section, &desc.diffusivity));
    else if (pdi_text_has_key(s->ctx, s->text, section, "activation_energy"))
        return pdi_text_fail_key(s->ctx, s->text, section, "activation_energy",
                                 "found without D, expected that of 25 C");
    if (pd_species_read(s->ctx, &desc, &e->species[k]) < 0) return pdi_read_electrolyte_fail(s, section, "species");
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "initial", &e->initial[k]));
    PD_TRY(pdi_read_electrolyte_other_concentration(s, section, "inlet", &e->inlet[k]));
    PD_TRY(pdi_read_electrolyte_other_concentration(s, section, "inside", &e->shape_initial[k]));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "volume", &e->volume[k]));
    if (!(e->volume[k] >= 0.0) || (e->volume[k] > 0.0 && e->species[k].phase != PD_PHASE_SOLID))
        return pdi_text_fail_key(s->ctx, s->text, section, "volume",
                                 "found %g m3/mol of %s, expected a positive value "
                                 "of a solid",
                                 e->volume[k], label);
    s->section[k] = section;
    e->count++;
    return PD_OK;
}

/* Read all species, and add the solvent H2O if the file has none. Its concentration is that of pure water at 25 C
 * unless a positive one is given, and the same in all solutions. PD_ERR_ARGUMENT: no species, or no room for the
 * solvent. */
static pd_status pdi_read_electrolyte_species(pdi_read_electrolyte_state *s)
{
    pd_electrolyte *e = s->electrolyte;
    pd_species_desc water;
    for (int k = pdi_text_next_section(s->ctx, s->text, "species", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "species", k))
        PD_TRY(pdi_read_electrolyte_one_species(s, k));
    if (!e->count)
        return pdi_text_fail_key(s->ctx, s->text, s->chemistry, "chemistry",
                                 "found no species, expected [species Na+] "
                                 "and others");
    int solvent = pd_electrolyte_find_species(e, "H2O");
    if (solvent < 0 && e->count < PD_SPECIES_MAX) {
        memset(&water, 0, sizeof water);
        water.name = "H2O";
        PD_TRY(pd_species_read(s->ctx, &water, &e->species[e->count]));
        s->section[e->count] = s->chemistry;
        solvent = e->count++;
    }
    if (solvent < 0)
        return pdi_text_fail_key(s->ctx, s->text, s->section[e->count - 1], "species",
                                 "found %d species beside water, "
                                 "expected at most %d",
                                 e->count, PD_SPECIES_MAX - 1);
    if (!(e->initial[solvent] > 0.0)) e->initial[solvent] = PDI_READ_ELECTROLYTE_WATER_C;
    e->inlet[solvent] = e->shape_initial[solvent] = e->initial[solvent];
    return PD_OK;
}

/* ---- [reaction NAME] ---- */

/* Read an equilibrium or rate constant: *value in the unit that unit[PD_UNITS_TEXT] names, a product of powers of mol,
 * L and s, "" for a plain number. A volume counts as litres. PD_ERR_ARGUMENT: a dimension with others in it. The sign
 * is not checked. */
static pd_status pdi_read_electrolyte_constant(pdi_read_electrolyte_state *s, int section, const char *key,
                                               double *value, char *unit)
{
    static const char *const names[] = {"mol", "L", "s"};
    pd_expr expr;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, key, NULL, NULL, 0, NULL, &expr));
    pd_dims dims = expr.dims;
    *value = pd_expr_eval(&expr, NULL);
    pd_expr_free(s->ctx, &expr);
    double power[3] = {dims.exponent[4], dims.exponent[0] / 3.0, dims.exponent[2]};
    if (dims.exponent[1] != 0.0 || dims.exponent[3] != 0.0 || dims.exponent[5] != 0.0) {
        char found[PD_UNITS_TEXT];
        pd_units_describe(&dims, found);
        return pdi_text_fail_key(s->ctx, s->text, section, key, "found %s, expected a unit of mol, L and s", found);
    }
    *value *= pow(PDI_READ_ELECTROLYTE_LITRES_PER_M3, power[1]);
    unit[0] = '\0';
    for (int sign = 1; sign >= -1; sign -= 2)
        for (int k = 0; k < 3; k++) {
            double n = sign * power[k];
            if (!(n > 0.0)) continue;
            const char *before = sign < 0 ? unit[0] ? "/" : "1/" : unit[0] ? " " : "";
            if (n > 1.0 || n < 1.0) pd_append(unit, PD_UNITS_TEXT, "%s%s%.4g", before, names[k], n);
            else pd_append(unit, PD_UNITS_TEXT, "%s%s", before, names[k]);
        }
    return PD_OK;
}

/* Convert the equilibrium constant from 25 C to the temperature by van't Hoff, if its enthalpy is given (theory: eq.
 * 7.12). Store the enthalpy [J/mol] of the reaction in work in the electrolyte, NaN: not given. PD_ERR_ARGUMENT: an
 * enthalpy without K and log10_K. */
static pd_status pdi_read_electrolyte_vant_hoff(pdi_read_electrolyte_state *s, int section, pd_reaction_desc *desc)
{
    pd_electrolyte *e = s->electrolyte;
    double *enthalpy = &e->enthalpy[e->reactions];
    *enthalpy = NAN;
    if (!pdi_text_has_key(s->ctx, s->text, section, "enthalpy")) return PD_OK;
    if (isnan(desc->k))
        return pdi_text_fail_key(s->ctx, s->text, section, "enthalpy",
                                 "found without a constant, expected K or log10_K");
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "enthalpy", enthalpy));
    double more = *enthalpy / PD_GAS_CONSTANT * (1.0 / PDI_READ_ELECTROLYTE_REFERENCE_T - 1.0 / e->temperature);
    if (strcmp(desc->k_unit, "log10") == 0) desc->k += more / log(10.0);
    else desc->k *= exp(more);
    return PD_OK;
}

/* Convert the rate constants from 25 C to the temperature by Arrhenius, if the activation energy is given: forward with
 * it, backward with it less the enthalpy (0 if not given), so that their ratio stays K. PD_ERR_ARGUMENT: neither rate
 * is given. */
static pd_status pdi_read_electrolyte_rate_temperature(pdi_read_electrolyte_state *s, int section,
                                                       pd_reaction_desc *desc)
{
    double energy, enthalpy = s->electrolyte->enthalpy[s->electrolyte->reactions];
    if (!pdi_text_has_key(s->ctx, s->text, section, "activation_energy")) return PD_OK;
    if (!(desc->forward > 0.0) && !(desc->backward > 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "activation_energy",
                                 "found without a rate, expected forward or "
                                 "backward");
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "activation_energy", &energy));
    desc->forward *= pdi_read_electrolyte_arrhenius_factor(s, energy);
    desc->backward *= pdi_read_electrolyte_arrhenius_factor(s, isnan(enthalpy) ? energy : energy - enthalpy);
    return PD_OK;
}

/* Read one [reaction NAME] section and append it to the electrolyte: equation, equilibrium constant, NaN without K and
 * log10_K, rate constants, 0 if not given, at the temperature. PD_ERR_ARGUMENT: no label, PD_REACTION_MAX reactions, a
 * second = in the equation, both K and log10_K, a rate that is not positive, an equation or units that are refused. */
static pd_status pdi_read_electrolyte_reaction(pdi_read_electrolyte_state *s, int section)
{
    static const char *const rates[] = {"forward", "backward"};
    pd_electrolyte *e = s->electrolyte;
    pd_reaction_desc desc;
    char unit[3][PD_UNITS_TEXT];
    double *rate[2] = {&desc.forward, &desc.backward};
    memset(&desc, 0, sizeof desc);
    memset(unit, 0, sizeof unit);
    desc.name = s->text->section[section].label;
    desc.k = NAN;
    desc.k_unit = unit[0];
    desc.forward_unit = unit[1];
    desc.backward_unit = unit[2];
    if (!desc.name[0])
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found no name, expected [reaction water] or "
                                 "another word");
    if (e->reactions == PD_REACTION_MAX)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction", "found more than %d reactions, expected fewer",
                                 PD_REACTION_MAX);
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "equation", NULL, &desc.text));
    const char *first = strchr(desc.text, '=');
    if (first && strchr(first + 1, '='))
        return pdi_text_fail_key(s->ctx, s->text, section, "equation",
                                 "found a second = in '%.120s', expected one, and "
                                 "behind the equation K, log10_K, forward or backward",
                                 desc.text);
    if (pdi_text_has_key(s->ctx, s->text, section, "log10_K")) {
        if (pdi_text_has_key(s->ctx, s->text, section, "K"))
            return pdi_text_fail_key(s->ctx, s->text, section, "log10_K", "found beside 'K', expected one of them");
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "log10_K", &desc.k));
        desc.k_unit = "log10";
    } else if (pdi_text_has_key(s->ctx, s->text, section, "K")) {
        PD_TRY(pdi_read_electrolyte_constant(s, section, "K", &desc.k, unit[0]));
    }
    PD_TRY(pdi_read_electrolyte_vant_hoff(s, section, &desc));
    for (int k = 0; k < 2; k++) {
        if (!pdi_text_has_key(s->ctx, s->text, section, rates[k])) continue;
        PD_TRY(pdi_read_electrolyte_constant(s, section, rates[k], rate[k], unit[1 + k]));
        if (!(*rate[k] > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, rates[k], "found %g, expected a positive value",
                                     *rate[k]);
    }
    PD_TRY(pdi_read_electrolyte_rate_temperature(s, section, &desc));
    if (pd_reaction_read(s->ctx, &desc, e->species, e->count, &e->reaction[e->reactions]) < 0)
        return pdi_read_electrolyte_fail(s, section, "equation");
    e->reactions++;
    return PD_OK;
}

/* ---- [chemistry] ---- */

/* Read the ion that a key names (balance, counter) into *ion: its index; -1: the key is absent. PD_ERR_ARGUMENT: no
 * such species, or one that is no charged solute. */
static pd_status pdi_read_electrolyte_ion(pdi_read_electrolyte_state *s, const char *key, int *ion)
{
    const char *name;
    *ion = -1;
    if (!pdi_text_has_key(s->ctx, s->text, s->chemistry, key)) return PD_OK;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, s->chemistry, key, NULL, &name));
    *ion = pd_electrolyte_find_species(s->electrolyte, name);
    if (*ion < 0)
        return pdi_text_fail_key(s->ctx, s->text, s->chemistry, key,
                                 "found '%.40s', which no section defines, expected "
                                 "an ion of a [species ...]",
                                 name);
    if (s->electrolyte->species[*ion].phase == PD_PHASE_SOLUTE && s->electrolyte->species[*ion].charge) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, s->chemistry, key,
                             "found '%.40s', which is no ion, expected one such as "
                             "Cl-",
                             name);
}

/* Read a pH within the bounds of the key; *ph is unchanged if the key is absent. */
static pd_status pdi_read_electrolyte_ph(pdi_read_electrolyte_state *s, const char *key, double *ph)
{
    if (!pdi_text_has_key(s->ctx, s->text, s->chemistry, key)) return PD_OK;
    return pdi_key_value_get_number(s->ctx, s->text, s->chemistry, key, ph);
}

/* Read the section [chemistry]: activity model, minerals, balance ion (-1: none) and counter ion, by default the same,
 * pH of the initial, inlet and inside solutions (NaN: none), the latter two by default the first. PD_ERR_ARGUMENT: a
 * key pH with H+ or OH- as counter ion. */
static pd_status pdi_read_electrolyte_chemistry(pdi_read_electrolyte_state *s)
{
    pd_electrolyte *e = s->electrolyte;
    const char *files; /* they are in the text */
    int activity, at = s->chemistry;
    if (pdi_text_has_key(s->ctx, s->text, at, "include"))
        PD_TRY(pdi_text_get_string(s->ctx, s->text, at, "include", NULL, &files));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, at, "activity", &activity));
    e->activity = (pd_activity)activity;
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, at, "minerals", &e->all_minerals_form));
    PD_TRY(pdi_read_electrolyte_ion(s, "balance_ion", &e->balance_ion));
    PD_TRY(pdi_read_electrolyte_ion(s, "counter_ion", &e->counter_ion));
    if (e->counter_ion < 0) e->counter_ion = e->balance_ion;
    if (e->counter_ion >= 0 &&
        (strcmp(e->species[e->counter_ion].name, "H+") == 0 || strcmp(e->species[e->counter_ion].name, "OH-") == 0) &&
        pdi_text_has_key(s->ctx, s->text, at, "pH"))
        return pdi_text_fail_key(s->ctx, s->text, at, "pH",
                                 "found beside balance_ion or counter_ion = %s, expected another ion, "
                                 "that of a salt",
                                 e->species[e->counter_ion].name);
    PD_TRY(pdi_read_electrolyte_ph(s, "pH", &e->ph));
    e->inlet_ph = e->shape_ph = e->ph;
    PD_TRY(pdi_read_electrolyte_ph(s, "inlet_pH", &e->inlet_ph));
    return pdi_read_electrolyte_ph(s, "inside_pH", &e->shape_ph);
}

/* Make the inlet or inside solution c[species] [mol/m3] neutral with its pH; errors name the key of one of its
 * concentrations, or key_ph. */
static pd_status pdi_read_electrolyte_close_solution(pdi_read_electrolyte_state *s, const char *key, const char *key_ph,
                                                     double ph, double *c)
{
    int written = -1;
    for (int k = 0; k < s->electrolyte->count; k++)
        if (written < 0 && s->section[k] != s->chemistry && pdi_text_has_key(s->ctx, s->text, s->section[k], key))
            written = s->section[k];
    if (pd_electrolyte_neutralise(s->ctx, s->electrolyte, ph, c) == PD_OK) return PD_OK;
    return written < 0 ? pdi_read_electrolyte_fail(s, s->chemistry, key_ph)
                       : pdi_read_electrolyte_fail(s, written, key);
}

/* Make the initial, inlet and inside solutions neutral with their pH. The initial one as written stays in e->recipe.
 * PD_ERR_ARGUMENT: the speciation cannot be built, charges cannot be balanced, or a pH cannot be reached. */
static pd_status pdi_read_electrolyte_close_solutions(pdi_read_electrolyte_state *s)
{
    pd_electrolyte *e = s->electrolyte;
    pd_speciation system;
    if (pd_electrolyte_build_speciation(s->ctx, e, NULL, &system) < 0)
        return pdi_read_electrolyte_fail(s, s->chemistry, "chemistry");
    memcpy(e->recipe, e->initial, sizeof e->recipe);
    if (pd_electrolyte_neutralise(s->ctx, e, NAN, e->initial) < 0)
        return pdi_read_electrolyte_fail(s, s->chemistry, "chemistry");
    if (pd_electrolyte_neutralise(s->ctx, e, e->ph, e->initial) < 0)
        return pdi_read_electrolyte_fail(s, s->chemistry, "pH");
    PD_TRY(pdi_read_electrolyte_close_solution(s, "inlet", "inlet_pH", e->inlet_ph, e->inlet));
    return pdi_read_electrolyte_close_solution(s, "inside", "inside_pH", e->shape_ph, e->shape_initial);
}

PDI_FN int pdi_read_electrolyte_has_sections(pd_ctx *ctx, pd_text *text)
{
    static const char *const names[] = {"chemistry", "species", "reaction", "mineral"};
    int given = 0;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        given |= pdi_text_next_section(ctx, text, names[k], -1) >= 0;
    return given;
}

PDI_FN pd_status pdi_read_electrolyte_sections(pd_ctx *ctx, pd_text *text, pdi_read_constants_table *named,
                                               pd_electrolyte *e)
{
    pdi_read_electrolyte_state s;
    memset(&s, 0, sizeof s);
    memset(e, 0, sizeof *e);
    s.ctx = ctx;
    s.text = text;
    s.electrolyte = e;
    e->ph = e->inlet_ph = e->shape_ph = NAN;
    s.chemistry = pdi_text_get_section(ctx, text, "chemistry", NULL);
    PD_TRY(pdi_read_electrolyte_temperature(&s, named));
    PD_TRY(pdi_read_electrolyte_species(&s));
    PD_TRY(pdi_read_electrolyte_chemistry(&s));
    for (int k = pdi_text_next_section(ctx, text, "reaction", -1); k >= 0;
         k = pdi_text_next_section(ctx, text, "reaction", k))
        PD_TRY(pdi_read_electrolyte_reaction(&s, k));
    return pdi_read_electrolyte_close_solutions(&s);
}

PDI_FN pd_status pdi_read_electrolyte_prepare(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count)
{
    static const char first[] = "chemistry.include";
    for (int turn = 0; turn < 2; turn++) {
        for (int k = 0; k < count; k++)
            if ((strncmp(overrides[k], first, sizeof first - 1) == 0) == !turn)
                PD_TRY(pdi_override_apply(ctx, text, overrides[k]));
        if (!turn) PD_TRY(pdi_include_files_read(ctx, text));
    }
    return PD_OK;
}

/* ---- a file of its own ---- */

/* Read an electrolyte from the text of a file of its own; its constants are detached from the text afterwards.
 * PD_ERR_ARGUMENT: no section of chemistry. */
static pd_status pdi_read_electrolyte_text(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count,
                                           pd_electrolyte *e)
{
    pdi_read_constants_table named;
    text->check_keys = 1;
    PD_TRY(pdi_read_electrolyte_prepare(ctx, text, overrides, count));
    PD_TRY(pdi_key_check_all(ctx, text));
    if (!pdi_read_electrolyte_has_sections(ctx, text))
        return pdi_text_fail_key(ctx, text, 0, "chemistry",
                                 "found no species, expected sections such as [species Na+]");
    memset(&named, 0, sizeof named);
    PD_TRY(pdi_read_constants_read(ctx, text, &named));
    pd_status status = pdi_read_electrolyte_sections(ctx, text, &named, e);
    text->consts = NULL;
    text->const_count = 0;
    return status;
}

/* Read an electrolyte from the text of a file of its own, and free the text; on failure the electrolyte is zero. */
static pd_status pdi_read_electrolyte_text_and_free(pd_ctx *ctx, pd_text *text, const char *const *overrides, int count,
                                                    pd_electrolyte *e)
{
    pd_status status = pdi_read_electrolyte_text(ctx, text, overrides, count, e);
    pdi_text_free(ctx, text);
    if (status < 0) memset(e, 0, sizeof *e);
    return status;
}

pd_status pd_electrolyte_read(pd_ctx *ctx, const char *path, const char *const *overrides, int count, pd_electrolyte *e)
{
    pd_text text;
    memset(e, 0, sizeof *e);
    PD_TRY(pdi_text_read(ctx, path, &text));
    return pdi_read_electrolyte_text_and_free(ctx, &text, overrides, count, e);
}

pd_status pd_electrolyte_parse(pd_ctx *ctx, const char *path, const char *text, const char *const *overrides, int count,
                               pd_electrolyte *e)
{
    pd_text own;
    memset(e, 0, sizeof *e);
    PD_TRY(pdi_text_build(ctx, path, text, strlen(text), &own));
    return pdi_read_electrolyte_text_and_free(ctx, &own, overrides, count, e);
}
