/* read_surface_states: see read_surface_states.h */
#include "scene/read_surface_states.h"
#include "setup/fields.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Section of a surface state in the text. */
static int pdi_read_surface_states_find_section(pdi_reader *s, const pd_setup_surface_state *state)
{
    return pdi_text_get_section(s->ctx, s->text, "surface", state->name);
}

/* ---- names, units, bounds ---- */

/* 1: an identifier of ASCII letters, digits and _ that begins with a letter. */
static int pdi_read_surface_states_is_identifier(const char *name)
{
    size_t length = strlen(name);
    if (!isalpha((unsigned char)name[0])) return 0;
    for (size_t k = 0; k < length; k++)
        if (!isalnum((unsigned char)name[k]) && name[k] != '_') return 0;
    return 1;
}

/* Check that the name of a state is an identifier of fewer than PD_SETUP_NAME - 24 bytes that no field, species, other
 * state, constant, table, variable or function has. PD_ERR_ARGUMENT. */
static pd_status pdi_read_surface_states_check_name(pdi_reader *s, int section, const char *name)
{
    static const char *const others[] = {"E", "i", "pH", "grain"};
    const char *what = NULL;
    if (!pdi_read_surface_states_is_identifier(name) || strlen(name) >= PD_SETUP_NAME - 24)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                                 "found '%.40s', expected a short name of letters, "
                                 "digits and _: [surface theta]",
                                 name);
    int field = pd_fields_find(s->setup, name);
    if (field < PD_FIELD_COUNT)
        what = pd_fields_species_index(s->setup, field) >= 0 ? "a species"
               : pd_fields_state_index(s->setup, field) >= 0 ? "another state"
                                                                   : "a field";
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++)
        if (strcmp(others[k], name) == 0) what = "a variable";
    if (pdi_read_constants_is_reserved(name)) what = "a name of expressions";
    for (int k = 0; k < s->text->const_count; k++)
        if (strcmp(s->text->consts[k].name, name) == 0) what = "a constant";
    for (int k = 0; k < s->setup->tables; k++)
        if (strcmp(s->setup->table[k].name, name) == 0) what = "a table";
    if (!what) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                             "found the name '%.40s', which is %s, expected another "
                             "one",
                             name, what);
}

/* 1: the expression has this dimension, or is the constant 0. */
static int pdi_read_surface_states_has_dims(const pd_expr *expr, const pd_dims *dims)
{
    double zero = pd_expr_is_constant(expr) ? pd_expr_eval(expr, NULL) : 1.0;
    return pd_units_is_same(&expr->dims, dims) || !(fabs(zero) > 0.0);
}

/* Read a bound of the state (key `min` or `max`) [SI]; *value is unchanged if the key is absent. PD_ERR_ARGUMENT: its
 * dimension is not that of the initial value; a bound of 0 needs no unit. */
static pd_status pdi_read_surface_states_bound(pdi_reader *s, int section, const char *key,
                                               const pd_setup_surface_state *state, double *value)
{
    pd_expr expr;
    char found[PD_UNITS_TEXT], wanted[PD_UNITS_TEXT];
    if (!pdi_text_has_key(s->ctx, s->text, section, key)) return PD_OK;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, key, NULL, NULL, 0, NULL, &expr));
    int fits = pdi_read_surface_states_has_dims(&expr, &state->initial.dims);
    pd_units_describe(&expr.dims, found);
    pd_units_describe(&state->initial.dims, wanted);
    *value = pd_expr_eval(&expr, NULL);
    pd_expr_free(s->ctx, &expr);
    if (fits) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, key, "found %s, expected %s as of 'initial'", found, wanted);
}

/* Read one [surface NAME] section up to its rate and append the state: name, unit, initial value in x, y, z, bounds
 * (infinite by default). The initial value gives the dimension. PD_ERR_ARGUMENT: too many states, or states and
 * species, a name that is taken, a unit with fractional exponents, min not below max, a constant initial value out of
 * the bounds. */
static pd_status pdi_read_surface_states_state(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    const char *name = s->text->section[section].label;
    char wanted[PD_UNITS_TEXT];
    if (u->states == PD_SETUP_SURFACE_STATES)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                                 "found more than %d states of surfaces, expected "
                                 "fewer",
                                 PD_SETUP_SURFACE_STATES);
    if (u->electrolyte.count + u->states >= PD_SPECIES_MAX)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                                 "found more than %d species and states of "
                                 "surfaces, expected fewer",
                                 PD_SPECIES_MAX);
    PD_TRY(pdi_read_surface_states_check_name(s, section, name));
    pd_setup_surface_state *state = &u->state[u->states];
    memset(state, 0, sizeof *state);
    memcpy(state->name, name, strlen(name) + 1);
    state->line = s->text->section[section].line;
    state->low = -HUGE_VAL;
    state->high = HUGE_VAL;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "initial", NULL, pd_setup_get_position_symbols(), PD_DIM, NULL,
                             &state->initial));
    u->states++; /* from here on it is freed */
    if (!pdi_read_constants_format_unit(s->ctx, &state->initial.dims, state->unit))
        return pdi_text_fail_key(s->ctx, s->text, section, "initial",
                                 "found a quantity with broken exponents, expected "
                                 "whole ones");
    memcpy(state->label, name, strlen(name) + 1);
    if (state->unit[0]) pd_append(state->label, sizeof state->label, " [%s]", state->unit);
    PD_TRY(pdi_read_surface_states_bound(s, section, "min", state, &state->low));
    PD_TRY(pdi_read_surface_states_bound(s, section, "max", state, &state->high));
    if (!(state->low < state->high))
        return pdi_text_fail_key(s->ctx, s->text, section, "max", "found bounds from %g to %g, expected min below max",
                                 state->low, state->high);
    if (!pd_expr_is_constant(&state->initial)) return PD_OK;
    double start = pd_expr_eval(&state->initial, NULL);
    if (start >= state->low && start <= state->high) return PD_OK;
    pd_units_describe(&state->initial.dims, wanted);
    return pdi_text_fail_key(s->ctx, s->text, section, "initial",
                             "found %g in SI, expected %s within its bounds, from "
                             "%g to %g",
                             start, wanted, state->low, state->high);
}

/* Check the physics that surface states require. PD_ERR_ARGUMENT: no chemistry, time = steady in it, or neither
 * electrodes nor dissolution. */
static pd_status pdi_read_surface_states_check_physics(pdi_reader *s, int section)
{
    const pd_setup *u = s->setup;
    if (!u->has_chemistry)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                                 "found without species, expected [species Mg2+] "
                                 "and others, or include = electrolytes/hbss.electrolyte in [chemistry]");
    if (u->steady_transport)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                                 "found beside time = steady in [chemistry], "
                                 "expected implicit");
    if (u->has_potential || u->has_dissolve) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "surface",
                             "found without metal, expected an [electrode NAME], or "
                             "[dissolve]");
}

PDI_FN pd_status pdi_read_surface_states_read(pdi_reader *s)
{
    for (int k = pdi_text_next_section(s->ctx, s->text, "surface", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "surface", k)) {
        PD_TRY(pdi_read_surface_states_check_physics(s, k));
        PD_TRY(pdi_read_surface_states_state(s, k));
    }
    return PD_OK;
}

/* ---- what laws know ---- */

PDI_FN pd_status pdi_read_surface_states_species_symbols(pdi_reader *s, int section, const char *key,
                                                         pd_expr_symbol *vars, char (*name)[PD_SPECIES_NAME + 2],
                                                         int *count, int *species_index, int *species)
{
    const pd_setup *u = s->setup;
    const pd_electrolyte *e = &u->electrolyte;
    const char *at = "";
    *species = 0;
    if (pdi_text_has_key(s->ctx, s->text, section, key))
        PD_TRY(pdi_text_get_string(s->ctx, s->text, section, key, NULL, &at));
    for (at = strchr(at, '['); at; at = strchr(at + 1, '[')) {
        int size = (int)strcspn(at, "]") + 1, known = 0;
        char word[PD_SPECIES_NAME + 2];
        if (size > PD_SPECIES_NAME) size = PD_SPECIES_NAME;
        snprintf(name[*species], PD_SPECIES_NAME + 2, "%.*s", size, at);
        for (int k = 0; k < *species; k++) known |= strcmp(name[k], name[*species]) == 0;
        if (known) continue;
        snprintf(word, sizeof word, "%.*s", size - 2, at + 1);
        int found = u->has_chemistry ? pd_electrolyte_find_species(e, word) : -1;
        if (found < 0 || e->species[found].phase != PD_PHASE_SOLUTE)
            return pdi_text_fail_key(s->ctx, s->text, section, key,
                                     "found [%s], expected a solute of a [species ...], "
                                     "such as [H+]",
                                     word);
        if (*count + u->states >= PD_EXPR_VARS)
            return pdi_text_fail_key(s->ctx, s->text, section, key, "found more than %d species, expected fewer",
                                     *species);
        vars[*count].name = name[*species];
        vars[*count].unit = "mol/m3";
        vars[(*count)++].value = 0.0;
        species_index[(*species)++] = found;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_surface_states_symbols(pdi_reader *s, int section, const char *key, pd_expr_symbol *vars,
                                                 char (*name)[PD_SPECIES_NAME + 2], int *count, int *species_index,
                                                 int *species)
{
    const pd_setup *u = s->setup;
    PD_TRY(pdi_read_surface_states_species_symbols(s, section, key, vars, name, count, species_index, species));
    for (int k = 0; k < u->states; k++) {
        vars[*count].name = u->state[k].name;
        vars[*count].unit = u->state[k].unit;
        vars[(*count)++].value = 0.0;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_read_surface_states_current_factor(pdi_reader *s, int section, int electrode)
{
    pd_setup *u = s->setup;
    pd_setup_electrode *e = &u->potential.electrode[electrode];
    pd_expr_symbol vars[PD_EXPR_VARS];
    char name[PD_EXPR_VARS][PD_SPECIES_NAME + 2];
    int count = PD_SETUP_POSITION_VARS, species_index[PD_EXPR_VARS], species;
    e->has_current_factor = pdi_text_has_key(s->ctx, s->text, section, "current_factor");
    if (!e->has_current_factor) return PD_OK;
    if (!u->states)
        return pdi_text_fail_key(s->ctx, s->text, section, "current_factor",
                                 "found without states of surfaces, expected a "
                                 "[surface NAME], or a factor of the curve itself");
    if (e->primary)
        return pdi_text_fail_key(s->ctx, s->text, section, "current_factor",
                                 "found beside curve = primary, where current passes "
                                 "freely, expected another curve");
    memcpy(vars, pd_setup_get_position_symbols(), PD_SETUP_POSITION_VARS * sizeof *vars);
    PD_TRY(pdi_read_surface_states_symbols(s, section, "current_factor", vars, name, &count, species_index, &species));
    if (species)
        return pdi_text_fail_key(s->ctx, s->text, section, "current_factor",
                                 "found %s, expected states of surfaces, x, y, z and "
                                 "t",
                                 name[0]);
    return pdi_text_get_expr(s->ctx, s->text, section, "current_factor", "", vars, count, NULL, &e->current_factor);
}

/* ---- rates ---- */

/* Read the electrodes that carry the state (key `of`) as bits of state->electrodes; all of them by default.
 * PD_ERR_ARGUMENT: the key without [potential], or a name of no electrode. */
static pd_status pdi_read_surface_states_electrodes(pdi_reader *s, int section, pd_setup_surface_state *state)
{
    const pd_setup_potential *p = &s->setup->potential;
    pd_word_list list;
    if (!pdi_text_has_key(s->ctx, s->text, section, "of")) {
        state->electrodes = ((uint32_t)1 << p->electrodes) - 1;
        return PD_OK;
    }
    if (!s->setup->has_potential)
        return pdi_text_fail_key(s->ctx, s->text, section, "of",
                                 "found without [potential], where all metal that "
                                 "dissolves carries the state, expected electrodes");
    PD_TRY(pdi_text_get_words(s->ctx, s->text, section, "of", NULL, &list));
    for (int w = 0; w < list.count; w++) {
        int k = 0;
        while (k < p->electrodes && strcmp(p->electrode[k].name, list.word[w]) != 0) k++;
        if (k == p->electrodes)
            return pdi_text_fail_key(s->ctx, s->text, section, "of",
                                     "found '%s', expected the name of an [electrode "
                                     "NAME]",
                                     list.word[w]);
        state->electrodes |= (uint32_t)1 << k;
    }
    return PD_OK;
}

/* Read the rate law of a state in t, x, y, z, pH, species and states, with a potential also in i and E, not in C or
 * grain. PD_ERR_ARGUMENT: it has not the dimension of the state per time and is not the constant 0, or it uses pH
 * without species H+. */
static pd_status pdi_read_surface_states_rate(pdi_reader *s, int section, pd_setup_surface_state *state)
{
    pd_setup *u = s->setup;
    pd_expr_symbol vars[PD_EXPR_VARS];
    char name[PD_EXPR_VARS][PD_SPECIES_NAME + 2], found[PD_UNITS_TEXT], wanted[PD_UNITS_TEXT];
    int count = PD_SETUP_RATE_PH + 1;
    pd_dims dims = state->initial.dims;
    memcpy(vars, pd_setup_get_rate_symbols(), PD_SETUP_RATE_VARS * sizeof *vars);
    vars[0].name = vars[PD_SETUP_RATE_GRAIN].name = "";
    if (!u->has_potential) vars[PD_SETUP_RATE_CURRENT].name = vars[PD_SETUP_RATE_POTENTIAL].name = "";
    vars[PD_SETUP_RATE_PH].name = "pH";
    vars[PD_SETUP_RATE_PH].unit = "";
    PD_TRY(pdi_read_surface_states_symbols(s, section, "rate", vars, name, &count, state->species_index,
                                           &state->species_count));
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "rate", NULL, vars, count, NULL, &state->rate));
    dims.exponent[2] -= 1.0; /* per s */
    pd_units_describe(&state->rate.dims, found);
    pd_units_describe(&dims, wanted);
    if (!pdi_read_surface_states_has_dims(&state->rate, &dims))
        return pdi_text_fail_key(s->ctx, s->text, section, "rate", "found %s, expected %s, that of %s per time", found,
                                 wanted, state->name);
    int acid = pd_electrolyte_find_species(&u->electrolyte, "H+") >= 0;
    if (!(state->rate.variables_used >> PD_SETUP_RATE_PH & 1u) || acid) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "rate",
                             "found pH without the species H+, expected [species H+] "
                             "and others, or include = electrolytes/hbss.electrolyte in [chemistry]");
}

/* Check that all electrodes of the bit set `where` carry state k, which the expression under `key` uses there.
 * PD_ERR_ARGUMENT names the first that does not. */
static pd_status pdi_read_surface_states_check_carried(pdi_reader *s, int section, const char *key, int k,
                                                       uint32_t where)
{
    const pd_setup *u = s->setup;
    uint32_t missing = where & ~u->state[k].electrodes;
    for (int e = 0; e < u->potential.electrodes; e++)
        if (missing >> e & 1u)
            return pdi_text_fail_key(s->ctx, s->text, section, key,
                                     "found %s, which the electrode %s does not carry, "
                                     "expected it in 'of' of [surface %s]",
                                     u->state[k].name, u->potential.electrode[e].name, u->state[k].name);
    return PD_OK;
}

/* Check that state k is carried by all electrodes of metal m, if the rate law of the metal uses it. */
static pd_status pdi_read_surface_states_check_metal(pdi_reader *s, int m, int k)
{
    const pd_setup *u = s->setup;
    const pd_setup_metal *metal = &u->metal[m];
    uint32_t all = 0;
    if (!(metal->rate.variables_used >> (PD_SETUP_RATE_PH + 1 + metal->species_count + k) & 1u)) return PD_OK;
    for (int e = 0; e < u->potential.electrodes; e++)
        if (u->potential.electrode[e].metal == m) all |= (uint32_t)1 << e;
    int section = pdi_reader_find_dissolution(s, m, NULL);
    return pdi_read_surface_states_check_carried(s, section, pdi_reader_get_rate_key(s, section), k, all);
}

/* Check that each surface state is carried wherever rates of states, electrode factors and rate laws of metals use it.
 * Of the metals, those with a law in species or E count, or metal 0 if there is none. PD_ERR_ARGUMENT. */
static pd_status pdi_read_surface_states_check_uses(pdi_reader *s)
{
    const pd_setup *u = s->setup;
    int goes = pd_setup_find_species_rate_metal(u);
    for (int k = 0; k < u->states; k++) {
        for (int n = 0; n < u->states; n++)
            if (u->state[n].rate.variables_used >> (PD_SETUP_RATE_PH + 1 + u->state[n].species_count + k) & 1u)
                PD_TRY(pdi_read_surface_states_check_carried(s, pdi_read_surface_states_find_section(s, &u->state[n]),
                                                             "rate", k, u->state[n].electrodes));
        for (int e = 0; e < u->potential.electrodes; e++)
            if (u->potential.electrode[e].current_factor.variables_used >> (PD_SETUP_POSITION_VARS + k) & 1u)
                PD_TRY(pdi_read_surface_states_check_carried(
                    s, pdi_text_get_section(s->ctx, s->text, "electrode", u->potential.electrode[e].name),
                    "current_factor", k, (uint32_t)1 << e));
        for (int m = 0; m < u->metals && u->has_dissolve; m++)
            if (goes < 0 ? m == 0 : pd_setup_has_species_rate(&u->metal[m]))
                PD_TRY(pdi_read_surface_states_check_metal(s, m, k));
    }
    return PD_OK;
}

/* Add a monitor of the surface state `index`. PD_ERR_ARGUMENT: too many monitors. */
static pd_status pdi_read_surface_states_add_monitor(pdi_reader *s, int section, int index)
{
    pd_setup *u = s->setup;
    if (u->monitors == PD_SETUP_MONITORS)
        return pdi_text_fail_key(s->ctx, s->text, section, "surface", "found more than %d tables", PD_SETUP_MONITORS);
    pd_setup_monitor *m = &u->monitor[u->monitors++];
    memset(m, 0, sizeof *m);
    m->kind = PD_MONITOR_SURFACE_STATE;
    m->index = index;
    m->line = u->state[index].line;
    memcpy(m->name, u->state[index].name, sizeof m->name);
    return PD_OK;
}

PDI_FN pd_status pdi_read_surface_states_rates(pdi_reader *s)
{
    pd_setup *u = s->setup;
    for (int k = 0; k < u->states; k++) {
        int section = pdi_read_surface_states_find_section(s, &u->state[k]);
        PD_TRY(pdi_read_surface_states_electrodes(s, section, &u->state[k]));
        PD_TRY(pdi_read_surface_states_rate(s, section, &u->state[k]));
        PD_TRY(pdi_read_surface_states_add_monitor(s, section, k));
    }
    return pdi_read_surface_states_check_uses(s);
}
