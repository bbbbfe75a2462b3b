/* read_chemistry: see read_chemistry.h */
#include "scene/read_chemistry.h"
#include "scene/read_electrolyte.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The section of a species; that of all where it has none. */
static int pdi_read_chemistry_section(pdi_reader *s, const char *name)
{
    int section = pdi_text_section(s->ctx, s->text, "species", name);
    if (pdi_text_has(s->ctx, s->text, section, NULL)) return section;
    section = pdi_text_next(s->ctx, s->text, "chemistry", -1);
    return section >= 0 ? section : pdi_text_next(s->ctx, s->text, "species", -1);
}

/* Solids do not move: those that are not there are left out. */
static pd_status pdi_read_chemistry_solids(pdi_reader *s)
{
    pd_electrolyte *e = &s->setup->electrolyte;
    int left_out = 0;
    for (int k = 0; k < e->count; k++) {
        const char *name = e->species[k].name;
        int section = pdi_read_chemistry_section(s, name);
        if (e->species[k].phase == PD_PHASE_SOLUTE && !(e->species[k].diffusivity > 0.0))
            return pdi_text_refuse(s->ctx, s->text, section, "D", "found no diffusivity of %s, which moves in a run, "
                                   "expected [species %s] D = 1e-9 m2/s or another positive value", name, name);
        if (e->species[k].phase == PD_PHASE_SOLUTE || e->species[k].phase == PD_PHASE_SOLVENT) continue;
        if (e->species[k].phase != PD_PHASE_SOLID || e->initial[k] > 0.0 || e->precipitates)
            return pdi_text_refuse(s->ctx, s->text, section, "initial", "found %s, which is no solute: no run carries "
                                   "solids and gases yet, expected minerals = given and initial = 0, which leave it "
                                   "out, or --speciate for the equilibrium", name);
        left_out++;
    }
    if (left_out)
        pdi_setup_note(s->setup, "%d solids of the electrolyte are left out: nothing precipitates in a run", left_out);
    pdi_electrolyte_dissolved(e);
    return PD_OK;
}

PDI_FN pd_status pdi_read_chemistry_read(pdi_reader *s)
{
    static const char *const times[] = {"implicit", "steady", NULL}, *const answers[] = {"no", "yes", NULL};
    pd_setup *u = s->setup;
    int section = pdi_text_section(s->ctx, s->text, "chemistry", NULL);
    if (!pdi_read_electrolyte_given(s->ctx, s->text)) return PD_OK;
    u->has_chemistry = 1;
    PDI_TRY(pdi_read_electrolyte_sections(s->ctx, s->text, &u->electrolyte));
    if (!pdi_text_has(s->ctx, s->text, pdi_text_section(s->ctx, s->text, "grid", NULL), NULL))
        return pdi_text_refuse(s->ctx, s->text, pdi_read_chemistry_section(s, ""), "chemistry",
                               "found species without a [grid], expected one for a run, or --speciate for their "
                               "equilibrium");
    if (u->has_gas)
        return pdi_text_refuse(s->ctx, s->text, pdi_read_chemistry_section(s, ""), "chemistry",
                               "found beside [gas], expected [flow] or fluid at rest");
    PDI_TRY(pdi_read_chemistry_solids(s));
    for (int k = 0; k < u->electrolyte.count; k++)
        snprintf(u->species_label[k], sizeof u->species_label[k], "%s [mol/m3]", u->electrolyte.species[k].name);
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "time", times, "implicit", &u->settle));
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "migration", answers, "no", &u->migrates));
    if (!u->settle || !u->has_dissolve) return PD_OK;
    return pdi_text_refuse(s->ctx, s->text, section, "time",
                           "found 'steady' beside metal that dissolves, expected implicit");
}

/* ---- the reaction at the surface ---- */

/* The next species of the text: without its number. 0: there is none. */
static int pdi_read_chemistry_word(const char **text, char *word)
{
    const char *from = *text + strspn(*text, " \t");
    size_t length = strcspn(from, " \t");
    *text = from + length;
    snprintf(word, PD_SPECIES_NAME, "%.*s", (int)(length < PD_SPECIES_NAME ? length : PD_SPECIES_NAME - 1), from);
    return length > 0;
}

/* Species of the text that the electrolyte has not: the metal and a gas. */
static pd_status pdi_read_chemistry_others(pdi_reader *s, int section, const char *text, pd_electrolyte *e,
                                           int *metal, int *gas)
{
    char word[PD_SPECIES_NAME];
    *metal = *gas = -1;
    while (pdi_read_chemistry_word(&text, word)) {
        pd_species_desc desc;
        pd_species found;
        int *place;
        memset(&desc, 0, sizeof desc);
        desc.name = word;
        if (strchr("+=0123456789.", word[0]) || pdi_electrolyte_find(e, word) >= 0) continue;
        if (pd_species_read(s->ctx, &desc, &found) < 0) continue; /* the reaction names it */
        place = found.phase == PD_PHASE_GAS ? gas : metal;
        if (place == metal && (found.elements != 1 || found.count[0] != 1 || found.charge)) continue;
        if (*place >= 0) continue;
        if (e->count == PD_SPECIES_MOST)
            return pdi_text_refuse(s->ctx, s->text, section, "reaction", "found %d species beside %s, expected fewer",
                                   e->count, word);
        *place = e->count;
        e->species[e->count++] = found;
    }
    if (*metal >= 0) return PD_OK;
    return pdi_text_refuse(s->ctx, s->text, section, "reaction", "found no metal, expected the symbol of one that is "
                           "no species of the electrolyte, such as Mg in Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)");
}

static pd_status pdi_read_chemistry_surface(pdi_reader *s, int section)
{
    pd_electrolyte all;
    pd_setup *u = s->setup;
    pd_reaction_desc desc;
    pd_reaction reaction;
    char message[PD_MESSAGE_SIZE];
    int metal, gas;
    all = u->electrolyte;
    memset(&desc, 0, sizeof desc);
    PDI_TRY(pdi_text_string(s->ctx, s->text, section, "reaction", NULL, &desc.text));
    PDI_TRY(pdi_read_chemistry_others(s, section, desc.text, &all, &metal, &gas));
    desc.name = "surface";
    desc.k_unit = "log10"; /* unread: its speed is that of the law */
    if (pd_reaction_read(s->ctx, &desc, all.species, all.count, &reaction) < 0) {
        const char *what = strstr(s->ctx->message, ": ");
        snprintf(message, sizeof message, "%s", what ? what + 2 : s->ctx->message);
        return pdi_text_refuse(s->ctx, s->text, section, "reaction", "%.500s", message);
    }
    double one = -reaction.nu[metal];
    if (!(one > 0.0) || (gas >= 0 && reaction.nu[gas] < 0.0))
        return pdi_text_refuse(s->ctx, s->text, section, "reaction", "found '%s' on the wrong side, expected the metal "
                               "on the left, and a gas on the right", all.species[one > 0.0 ? gas : metal].name);
    for (int k = 0; k < u->electrolyte.count; k++) u->shed[k] = reaction.nu[k] / one;
    if (gas >= 0) snprintf(u->gas, sizeof u->gas, "%s", all.species[gas].name);
    if (gas >= 0) u->gas_shed = reaction.nu[gas] / one;
    u->sheds = 1;
    return PD_OK;
}

PDI_FN pd_status pdi_read_chemistry_metal(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_section(s->ctx, s->text, u->has_corrode ? "corrode" : "dissolve", NULL);
    int given = u->has_dissolve && pdi_text_has(s->ctx, s->text, section, "reaction");
    if (given && !u->has_chemistry)
        return pdi_text_refuse(s->ctx, s->text, section, "reaction", "found without species, expected [species Mg2+] "
                               "and others, or include = electrolytes/hbss.electrolyte in [chemistry]");
    if (!u->has_chemistry) return PD_OK;
    if (u->medium >= 0)
        return pdi_text_refuse(s->ctx, s->text, pdi_read_chemistry_section(s, ""), "chemistry",
                               "found beside a medium, where species would have a D of their own, expected none");
    if (!given) return PD_OK;
    if (u->metals > 1 || u->activation)
        return pdi_text_refuse(s->ctx, s->text, section, "reaction", u->metals > 1 ?
                               "found with several metals, expected one" :
                               "found with control = activation, where nothing dissolved is followed, expected "
                               "diffusion");
    return pdi_read_chemistry_surface(s, section);
}
