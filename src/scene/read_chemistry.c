/* read_chemistry: see read_chemistry.h */
#include "scene/read_chemistry.h"
#include "scene/read_electrolyte.h"
#include "scene/read_dissolution.h"
#include "react/reactive.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* [-] Relative tolerance between the electrons of a reaction and the charge of Faraday's law. */
#define PDI_READ_CHEMISTRY_ELECTRON_TOL 1e-9

/* Section of a species in the text, for messages; if it has none, [chemistry], else the first [species ...]; -1: none
 * of them. */
static int pdi_read_chemistry_find_section(pdi_reader *s, const char *name)
{
    int section = pdi_text_get_section(s->ctx, s->text, "species", name);
    if (pdi_text_has_key(s->ctx, s->text, section, NULL)) return section;
    section = pdi_text_next_section(s->ctx, s->text, "chemistry", -1);
    return section >= 0 ? section : pdi_text_next_section(s->ctx, s->text, "species", -1);
}

/* ---- minerals ---- */

/* 1: the scene has a section [mineral NAME], with or without keys. */
static int pdi_read_chemistry_has_mineral(pdi_reader *s, const char *name)
{
    for (int k = pdi_text_next_section(s->ctx, s->text, "mineral", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "mineral", k))
        if (strcmp(s->text->section[k].label, name) == 0) return 1;
    return 0;
}

/* Read the kinetics of a mineral: rate constant [mol/m2/s] times area [1/m] into m->rate [mol/m3/s] and times surface
 * [m2/mol] into m->surface_rate [1/s], exponent, nucleation threshold, least porosity. Without a rate it is in
 * equilibrium, and both are 0. PD_ERR_ARGUMENT: a rate of 0 or without area and surface, or one of these without a
 * rate. */
static pd_status pdi_read_chemistry_mineral_rate(pdi_reader *s, int section, pd_mineral *m)
{
    double rate = 0.0, area, surface;
    int given = pdi_text_has_key(s->ctx, s->text, section, "rate");
    if (given) PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "rate", &rate));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "area", &area));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "surface", &surface));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "exponent", &m->exponent));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "nucleation", &m->nucleation));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "porosity", &m->min_porosity));
    m->rate = rate * area;
    m->surface_rate = rate * surface;
    if (given && !(m->rate + m->surface_rate > 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "rate",
                                 "found without a surface, expected a positive value, "
                                 "and area = 1e4 1/m or another, or surface in m2/mol");
    if (!given && area + surface > 0.0)
        return pdi_text_fail_key(s->ctx, s->text, section, area > 0.0 ? "area" : "surface",
                                 "found without 'rate', "
                                 "expected both, or none for equilibrium");
    return PD_OK;
}

/* Check that each [mineral NAME] section names a solid species of the electrolyte. PD_ERR_ARGUMENT. */
static pd_status pdi_read_chemistry_check_minerals(pdi_reader *s)
{
    const pd_electrolyte *e = &s->setup->electrolyte;
    for (int k = pdi_text_next_section(s->ctx, s->text, "mineral", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "mineral", k)) {
        const char *name = s->text->section[k].label;
        int i = pd_electrolyte_find_species(e, name);
        if (i < 0 || e->species[i].phase != PD_PHASE_SOLID)
            return pdi_text_fail_key(s->ctx, s->text, k, "mineral",
                                     "found '%.40s', which %s, expected the name of a "
                                     "solid such as [mineral Mg(OH)2(s)], with a [species ...] and a reaction",
                                     name, i < 0 ? "no [species ...] defines" : "is no solid");
    }
    return PD_OK;
}

/* Check that each mineral has a reaction, by a trial build of the reactive system; without minerals do nothing.
 * PD_ERR_ARGUMENT, at the first [mineral ...] or [chemistry], with the message of the build: it fails for any
 * reason. */
static pd_status pdi_read_chemistry_check_reactions(pdi_reader *s)
{
    pd_setup *u = s->setup;
    pd_reactive_desc desc;
    pd_reactive r;
    char message[PD_MESSAGE_SIZE];
    pd_setup_get_reactive_desc(u, &desc);
    memset(&r, 0, sizeof r);
    if (!u->minerals || pd_reactive_system(s->ctx, &desc, &r) >= 0) return PD_OK;
    int section = pdi_text_next_section(s->ctx, s->text, "mineral", -1);
    const char *what = strstr(s->ctx->message, ": ");
    snprintf(message, sizeof message, "%s", what ? what + 2 : s->ctx->message);
    if (section < 0) section = pdi_text_get_section(s->ctx, s->text, "chemistry", NULL);
    return pdi_text_fail_key(s->ctx, s->text, section, "mineral", "%.500s", message);
}

/* Choose the minerals, solids with a [mineral ...] section or, with minerals = all, all solids; read their kinetics,
 * and remove all other solids from the electrolyte, with a note. Read tortuosity and covering thickness.
 * PD_ERR_ARGUMENT: a solute without a positive D, a species that is neither solute, solvent nor solid, an initial
 * amount of a solid that is no mineral, or more than PD_MINERAL_MAX. */
static pd_status pdi_read_chemistry_minerals(pdi_reader *s)
{
    pd_electrolyte *e = &s->setup->electrolyte;
    pd_setup *u = s->setup;
    int left_out = 0, stays[PD_SPECIES_MAX] = {0};
    PD_TRY(pdi_read_chemistry_check_minerals(s));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "chemistry", NULL),
                                    "tortuosity", &u->tortuosity));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "chemistry", NULL),
                                    "covering_thickness", &u->shielding_thickness));
    for (int k = 0; k < e->count; k++) {
        const char *name = e->species[k].name;
        int section = pdi_read_chemistry_find_section(s, name),
            law = pdi_text_get_section(s->ctx, s->text, "mineral", name);
        int given = e->species[k].phase == PD_PHASE_SOLID && pdi_read_chemistry_has_mineral(s, name);
        if (e->species[k].phase == PD_PHASE_SOLUTE && section >= 0 && pdi_text_has_key(s->ctx, s->text, section, "D") &&
            !(e->species[k].diffusivity > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, "D",
                                     "found 0: a solute moves in a run, expected a "
                                     "positive value, or a [mineral ...] in place of a species that stays where it is");
        if (e->species[k].phase == PD_PHASE_SOLUTE && !(e->species[k].diffusivity > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, "D",
                                     "found no diffusivity of %s, which moves in a run, "
                                     "expected [species %s] D = 1e-9 m2/s or another positive value",
                                     name, name);
        if (e->species[k].phase == PD_PHASE_SOLUTE || e->species[k].phase == PD_PHASE_SOLVENT) continue;
        if (e->species[k].phase != PD_PHASE_SOLID || (e->initial[k] > 0.0 && !given && !e->all_minerals_form))
            return pdi_text_fail_key(
                s->ctx, s->text, section, "initial", "found %s, which is no solute, expected%s", name,
                e->species[k].phase == PD_PHASE_SOLID
                    ? " [mineral ...] of that name, with which it "
                      "dissolves and grows, minerals = all in [chemistry], or initial = 0, which leaves "
                      "it out"
                    : " none in a run, or --speciate for the equilibrium");
        left_out += !given && !e->all_minerals_form;
        if (!given && !e->all_minerals_form) continue;
        if (u->minerals == PD_MINERAL_MAX)
            return pdi_text_fail_key(s->ctx, s->text, section, "mineral",
                                     "found more than %d solids that may form, "
                                     "expected fewer",
                                     PD_MINERAL_MAX);
        stays[k] = 1;
        u->mineral[u->minerals].volume = e->volume[k];
        PD_TRY(pdi_read_chemistry_mineral_rate(s, law, &u->mineral[u->minerals++]));
    }
    if (left_out)
        pd_setup_add_note(s->setup, "%d solids of the electrolyte are left out: they have no [mineral ...] section",
                          left_out);
    pd_electrolyte_remove_undissolved(e, stays);
    for (int k = 0, next = 0; k < e->count; k++)
        if (e->species[k].phase == PD_PHASE_SOLID) u->mineral[next++].species = k;
    return pdi_read_chemistry_check_reactions(s);
}

PDI_FN pd_status pdi_read_chemistry_read(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "chemistry", NULL);
    if (!pdi_read_electrolyte_has_sections(s->ctx, s->text)) return PD_OK;
    u->has_chemistry = 1;
    PD_TRY(pdi_read_electrolyte_sections(s->ctx, s->text, &s->constants, &u->electrolyte));
    if (!pdi_text_has_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "grid", NULL), NULL))
        return pdi_text_fail_key(s->ctx, s->text, pdi_read_chemistry_find_section(s, ""), "chemistry",
                                 "found species without a [grid], expected one for a run, or --speciate for their "
                                 "equilibrium");
    if (u->has_gas)
        return pdi_text_fail_key(s->ctx, s->text, pdi_read_chemistry_find_section(s, ""), "chemistry",
                                 "found beside [gas], expected [flow] or fluid at rest");
    PD_TRY(pdi_read_chemistry_minerals(s));
    for (int k = 0; k < u->electrolyte.count; k++) {
        u->species_label[k][0] = '\0';
        pd_append(u->species_label[k], sizeof u->species_label[k], "%s [mol/m3]", u->electrolyte.species[k].name);
    }
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "time", &u->steady_transport));
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "migration", &u->has_migration));
    if (!u->steady_transport || !u->has_dissolve) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "time",
                             "found 'steady' beside metal that dissolves, expected implicit");
}

/* ---- the reaction at the surface ---- */

/* Copy the next word of a reaction equation, which blanks or tabs end, into word[PD_SPECIES_NAME], cut to fit, and
 * advance *text. 1: there was one; 0: end of the text. */
static int pdi_read_chemistry_next_word(const char **text, char *word)
{
    const char *from = *text + strspn(*text, " \t");
    size_t length = strcspn(from, " \t");
    *text = from + length;
    snprintf(word, PD_SPECIES_NAME, "%.*s", (int)(length < PD_SPECIES_NAME ? length : PD_SPECIES_NAME - 1), from);
    return length > 0;
}

/* Append the species of a reaction that the electrolyte lacks to e: the metal (a neutral word of one atom), a gas and
 * the electron e-, the first of each. *metal, *gas, *electron: their indices, -1: none was appended. Numbers, signs and
 * other words are passed over. PD_ERR_ARGUMENT: no room for a species. */
static pd_status pdi_read_chemistry_add_species(pdi_reader *s, int section, const char *text, pd_electrolyte *e,
                                                int *metal, int *gas, int *electron)
{
    char word[PD_SPECIES_NAME];
    *metal = *gas = *electron = -1;
    while (pdi_read_chemistry_next_word(&text, word)) {
        pd_species_desc desc;
        pd_species found;
        int *place;
        memset(&desc, 0, sizeof desc);
        desc.name = word;
        if (strchr("+=0123456789.", word[0]) || pd_electrolyte_find_species(e, word) >= 0) continue;
        if (pd_species_read(s->ctx, &desc, &found) < 0) continue; /* the reaction names it */
        place = found.phase == PD_PHASE_GAS ? gas : found.phase == PD_PHASE_ELECTRON ? electron : metal;
        if (place == metal && (found.elements != 1 || found.count[0] != 1 || found.charge)) continue;
        if (*place >= 0) continue;
        if (e->count == PD_SPECIES_MAX)
            return pdi_text_fail_key(s->ctx, s->text, section, "reaction", "found %d species beside %s, expected fewer",
                                     e->count, word);
        *place = e->count;
        e->species[e->count++] = found;
    }
    return PD_OK;
}

/* Read a surface reaction (key `reaction`) among the species of `all`, to which metal, gas and electron are appended as
 * by pdi_read_chemistry_add_species. PD_ERR_ARGUMENT: an equation that is refused; PD_ERR_PARSE: no such key. */
static pd_status pdi_read_chemistry_reaction(pdi_reader *s, int section, pd_electrolyte *all, int *metal, int *gas,
                                             int *electron, pd_reaction *reaction)
{
    pd_reaction_desc desc;
    char message[PD_MESSAGE_SIZE];
    memset(&desc, 0, sizeof desc);
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "reaction", NULL, &desc.text));
    PD_TRY(pdi_read_chemistry_add_species(s, section, desc.text, all, metal, gas, electron));
    desc.name = "surface";
    desc.k_unit = "log10"; /* unread: its speed is that of the law */
    if (pd_reaction_read(s->ctx, &desc, all->species, all->count, reaction) >= 0) return PD_OK;
    const char *what = strstr(s->ctx->message, ": ");
    snprintf(message, sizeof message, "%s", what ? what + 2 : s->ctx->message);
    return pdi_text_fail_key(s->ctx, s->text, section, "reaction", "%.500s", message);
}

PDI_FN pd_status pdi_read_chemistry_electrode_reaction(pdi_reader *s, int section, double *shed)
{
    pd_electrolyte all = s->setup->electrolyte;
    pd_reaction reaction;
    int metal, gas, electron;
    if (!s->setup->has_chemistry)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found without species, expected [species OH-] "
                                 "and others");
    if (s->setup->has_surface_reaction && !s->setup->has_migration)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found beside reaction of [dissolve], which takes "
                                 "the same current, expected one of them");
    if (s->setup->steady_transport && !s->setup->has_migration)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found beside time = steady in [chemistry], "
                                 "expected implicit");
    PD_TRY(pdi_read_chemistry_reaction(s, section, &all, &metal, &gas, &electron, &reaction));
    double electrons = electron >= 0 ? reaction.nu[electron] : 0.0;
    if (!(fabs(electrons) > 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found no e-, expected a half-reaction such as "
                                 "O2 + 2 H2O + 4 e- = 4 OH- or Mg = Mg2+ + 2 e-");
    for (int k = 0; k < s->setup->electrolyte.count; k++) shed[k] = reaction.nu[k] / electrons;
    return PD_OK;
}

/* Check the electrons that the reaction of metal m releases per mole of metal. PD_ERR_ARGUMENT: they are not positive,
 * neither migration nor a potential carries them away, electrodes stand among migrating ions and the rate law has no E
 * or species, or, with a law as a current density, they are not the charge in Faraday's law. */
static pd_status pdi_read_chemistry_check_electrons(pdi_reader *s, int section, int m, double electrons)
{
    const pd_setup *u = s->setup;
    double charge = u->metal[m].material.charge;
    if (!(electrons > 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found e- on the left, expected it on the right, "
                                 "as in Fe = Fe2+ + 2 e-");
    if (!u->has_migration && !u->has_potential)
        return pdi_text_fail_key(
            s->ctx, s->text, section, "reaction",
            "found e- where nothing carries the current, "
            "expected migration = yes in [chemistry], [potential] with electrodes, or what takes up "
            "the electrons, as in Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)");
    if (pd_setup_has_ion_electrodes(u) && !pd_setup_has_species_rate(&u->metal[m]))
        return pdi_text_fail_key(
            s->ctx, s->text, section, "reaction",
            "found e- beside electrodes among ions that "
            "migrate, and a law without E, expected one in E, the potential of the metal less that "
            "of the ions: current = 0.1 A/m2*exp((E + 0.4 V)/(26 mV))");
    if (!pdi_text_has_key(s->ctx, s->text, pdi_reader_find_dissolution(s, m, NULL), "current") ||
        fabs(electrons - charge) <= PDI_READ_CHEMISTRY_ELECTRON_TOL * charge)
        return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                             "found %.6g e- for one of the metal, but Faraday's "
                             "law has charge = %.6g, expected the same",
                             electrons, charge);
}

/* Store the name of the gas that a surface reaction evolves in setup->gas. PD_ERR_ARGUMENT: another metal evolves
 * another gas. */
static pd_status pdi_read_chemistry_set_gas(pdi_reader *s, int section, const char *name)
{
    pd_setup *u = s->setup;
    if (u->gas[0] && strcmp(u->gas, name) != 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found %s beside %s of another metal, expected "
                                 "one gas",
                                 name, u->gas);
    snprintf(u->gas, sizeof u->gas, "%s", name);
    return PD_OK;
}

/* Read the dissolution reaction of metal m: species_released and gas_released, moles per mole of metal (negative:
 * consumed). Set setup->has_surface_reaction, and setup->gas if a gas evolves. PD_ERR_ARGUMENT: no metal on the left, a
 * gas there, electrons that are refused, or another gas than of another metal. */
static pd_status pdi_read_chemistry_metal_reaction(pdi_reader *s, int section, int m)
{
    pd_electrolyte all;
    pd_setup *u = s->setup;
    pd_reaction reaction;
    int metal, gas, electron;
    all = u->electrolyte;
    PD_TRY(pdi_read_chemistry_reaction(s, section, &all, &metal, &gas, &electron, &reaction));
    if (metal < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found no metal, expected the symbol of one that "
                                 "is no species of the electrolyte, such as Mg in Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)");
    double one = -reaction.nu[metal];
    if (!(one > 0.0) || (gas >= 0 && reaction.nu[gas] < 0.0))
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found '%s' on the wrong side, expected the metal "
                                 "on the left, and a gas on the right",
                                 all.species[one > 0.0 ? gas : metal].name);
    if (electron >= 0) PD_TRY(pdi_read_chemistry_check_electrons(s, section, m, reaction.nu[electron] / one));
    for (int k = 0; k < u->electrolyte.count; k++) u->metal[m].species_released[k] = reaction.nu[k] / one;
    if (gas >= 0) PD_TRY(pdi_read_chemistry_set_gas(s, section, all.species[gas].name));
    if (gas >= 0) u->metal[m].gas_released = reaction.nu[gas] / one;
    u->has_surface_reaction = 1;
    return PD_OK;
}

/* 1: metal m releases species by a reaction: its rate law depends on species, or on E among migrating ions; if that of
 * no metal does, metal 0. */
static int pdi_read_chemistry_is_releasing(const pd_setup *u, int m)
{
    return pd_setup_find_species_rate_metal(u) < 0 ? m == 0 : pd_setup_has_species_rate(&u->metal[m]);
}

/* Read the dissolution reactions of all metals that release species; a section without label holds for all. section:
 * one with a reaction, for messages. PD_ERR_ARGUMENT: such a metal has no reaction, a section of its own gives one to
 * another metal, control = activation, or several metals without a rate law in E or species and electrodes among
 * ions. */
static pd_status pdi_read_chemistry_metal_reactions(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    int several = u->metals > 1 && !(pd_setup_has_ion_electrodes(u) && pd_setup_find_species_rate_metal(u) >= 0);
    int shared = pdi_text_get_section(s->ctx, s->text, pdi_reader_get_dissolution_name(u), NULL);
    if (several || u->activation)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 several
                                     ? "found with several metals, expected one"
                                     : "found with control = activation, where nothing dissolved is followed, expected "
                                       "diffusion");
    for (int m = 0; m < u->metals; m++) {
        int own = pdi_reader_find_dissolution(s, m, "reaction"),
            has = pdi_text_has_key(s->ctx, s->text, own, "reaction");
        if (pdi_read_chemistry_is_releasing(u, m) && !has)
            return pdi_text_fail_key(s->ctx, s->text, pdi_reader_find_dissolution(s, m, NULL), "reaction",
                                     "found none of "
                                     "%s, expected one of each metal that dissolves, in [dissolve %s]",
                                     u->metal[m].material.name, u->metal[m].material.name);
        if (!pdi_read_chemistry_is_releasing(u, m) && has && own != shared)
            return pdi_text_fail_key(s->ctx, s->text, own, "reaction",
                                     "found of metal that stays, expected a law in E "
                                     "beside it");
        if (pdi_read_chemistry_is_releasing(u, m)) PD_TRY(pdi_read_chemistry_metal_reaction(s, own, m));
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_chemistry_surface_reactions(pdi_reader *s)
{
    const pd_setup *u = s->setup;
    int section = -1;
    for (int m = u->metals; m-- > 0 && u->has_dissolve;) {
        int own = pdi_reader_find_dissolution(s, m, "reaction");
        if (pdi_text_has_key(s->ctx, s->text, own, "reaction")) section = own;
    }
    if (section >= 0 && !u->has_chemistry)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found without species, expected [species Mg2+] "
                                 "and others, or include = electrolytes/hbss.electrolyte in [chemistry]");
    if (!u->has_chemistry) return PD_OK;
    if (u->medium >= 0)
        return pdi_text_fail_key(s->ctx, s->text, pdi_read_chemistry_find_section(s, ""), "chemistry",
                                 "found beside a medium, where species would have a D of their own, expected none");
    return section < 0 ? PD_OK : pdi_read_chemistry_metal_reactions(s, section);
}
