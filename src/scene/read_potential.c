/* read_potential: see read_potential.h */
#include "scene/read_potential.h"
#include "scene/read_chemistry.h"
#include "scene/read_surface_states.h"
#include <math.h>
#include <string.h>

/* Table points of a polarisation curve that is given as an expression. */
#define PDI_READ_POTENTIAL_TABLE_POINTS 4001
/* Check that a curve in species rises: number of potentials tried, their range [V], relative fall that is rounding. */
#define PDI_READ_POTENTIAL_CHECK_POINTS 400
#define PDI_READ_POTENTIAL_CHECK_RANGE 4.0
#define PDI_READ_POTENTIAL_CHECK_TOL 1e-12

/* Kind of polarisation curve, the values of the key `curve`. */
typedef enum pdi_read_potential_curve_kind {
    PDI_READ_POTENTIAL_BUTLER_VOLMER = 0,
    PDI_READ_POTENTIAL_TAFEL,
    PDI_READ_POTENTIAL_LINEAR,
    PDI_READ_POTENTIAL_EXPRESSION,
    PDI_READ_POTENTIAL_PRIMARY
} pdi_read_potential_curve_kind;

static const pd_expr_symbol pdi_read_potential_curve_symbol[] = {{"E", "V", 0.0}};

PDI_FN int pdi_read_potential_has_sections(pdi_reader *s)
{
    return pdi_text_has_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "potential", NULL), NULL) ||
           pdi_text_next_section(s->ctx, s->text, "electrode", -1) >= 0;
}

/* ---- where it is ---- */

/* Index of the metal of a [shape] section; 0 if it names no material, or one that no metal has. */
static int pdi_read_potential_find_metal(pdi_reader *s, int section)
{
    const char *name;
    if (!pdi_text_has_key(s->ctx, s->text, section, "material")) return 0;
    if (pdi_text_get_string(s->ctx, s->text, section, "material", NULL, &name) != PD_OK) return 0;
    for (int k = 0; k < s->setup->metals; k++)
        if (strcmp(s->setup->metal[k].material.name, name) == 0) return k;
    return 0;
}

/* Read the shape of an electrode: its index in the setup into e->shape, its metal into e->metal. PD_ERR_ARGUMENT: no
 * such solid. */
static pd_status pdi_read_potential_shape(pdi_reader *s, int section, pd_setup_electrode *e)
{
    const pd_setup *u = s->setup;
    const char *name;
    int k = 0;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "shape", NULL, &name));
    for (int at = pdi_text_next_section(s->ctx, s->text, "shape", -1); at >= 0;
         at = pdi_text_next_section(s->ctx, s->text, "shape", at), k++) {
        int solid = 0;
        if (strcmp(s->text->section[at].label, name) != 0) continue;
        e->shape = u->section_shape[k];
        for (int w = 0; w < u->wall_count; w++) solid |= u->wall_shape[w].section == at;
        e->metal = pdi_read_potential_find_metal(s, at);
        if (e->shape >= 0 && !solid) return PD_OK;
        return pdi_text_fail_key(s->ctx, s->text, section, "shape",
                                 "found '%.40s', which is no metal, expected a [shape "
                                 "NAME] with kind = solid",
                                 name);
    }
    return pdi_text_fail_key(s->ctx, s->text, section, "shape",
                             "found '%.40s', which is no shape, expected the name of "
                             "a [shape NAME] with kind = solid",
                             name);
}

/* Read where an electrode is: a solid shape, or all metal of a material (e->shape -1), with e->metal in both cases.
 * PD_ERR_ARGUMENT: both keys, neither of them, no solid shape of that name, or a material of no metal. */
static pd_status pdi_read_potential_location(pdi_reader *s, int section, pd_setup_electrode *e)
{
    const pd_setup *u = s->setup;
    const char *name;
    int shape = pdi_text_has_key(s->ctx, s->text, section, "shape");
    e->shape = -1;
    if (shape == pdi_text_has_key(s->ctx, s->text, section, "material"))
        return pdi_text_fail_key(s->ctx, s->text, section, "shape",
                                 "found %s, expected shape = NAME of a solid, or "
                                 "material = NAME",
                                 shape ? "a shape and a material" : "neither a shape nor a material");
    if (shape) return pdi_read_potential_shape(s, section, e);
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "material", NULL, &name));
    for (e->metal = 0; e->metal < u->metals; e->metal++)
        if (strcmp(u->metal[e->metal].material.name, name) == 0) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "material",
                             "found '%.40s', expected the material of a solid "
                             "shape",
                             name);
}

/* ---- curves ---- */

/* Read a Butler-Volmer (both = 1) or Tafel curve: exchange current density, slopes, given per decade and stored per
 * factor e [V], and the limiting currents of the branches with a slope. PD_ERR_ARGUMENT: not two slopes with
 * Butler-Volmer, not one with Tafel. */
static pd_status pdi_read_potential_tafel_slopes(pdi_reader *s, int section, int both, pd_electrode_term *t)
{
    static const char *const keys[] = {"anodic_slope", "cathodic_slope"}, *const limits[] = {"anodic_limit",
                                                                                            "cathodic_limit"};
    double *slope[] = {&t->anodic, &t->cathodic}, *limit[] = {&t->anodic_limit, &t->cathodic_limit};
    int given = 0;
    t->kind = PD_ELECTRODE_BUTLER_VOLMER;
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "i0", &t->exchange));
    for (int k = 0; k < 2; k++) {
        if (!pdi_text_has_key(s->ctx, s->text, section, keys[k])) continue;
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, keys[k], slope[k]));
        *slope[k] /= log(10.0);
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, limits[k], limit[k]));
        given++;
    }
    if (given == 1 + both) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "curve",
                             "found %d of anodic_slope and cathodic_slope, expected "
                             "%s",
                             given, both ? "both with butler_volmer" : "one of them with tafel");
}

/* Tabulate a curve i(E) [A/m2] at PDI_READ_POTENTIAL_TABLE_POINTS equidistant points of its key `range` into new arrays
 * of e, which its term refers to. PD_ERR_ARGUMENT: i falls from one point to the next, so that solutions would not be
 * unique, or |i| is not below PD_KEY_MAX_NUMBER. Arrays that exist then stay in e. */
static pd_status pdi_read_potential_tabulate_curve(pdi_reader *s, int section, const pd_expr *curve,
                                                   pd_setup_electrode *e)
{
    double low, high;
    int count;
    PD_TRY(pdi_text_get_ranges(s->ctx, s->text, section, "range", "V", NULL, 1, &low, &high, &count));
    e->points = PDI_READ_POTENTIAL_TABLE_POINTS;
    PD_TRY(PD_NEW(s->ctx, "electrode", e->points, e->potential));
    PD_TRY(PD_NEW(s->ctx, "electrode", e->points, e->current));
    for (int k = 0; k < e->points; k++) {
        e->potential[k] = low + (high - low) * k / (e->points - 1);
        e->current[k] = pd_expr_eval(curve, &e->potential[k]);
        if (!(fabs(e->current[k]) < PD_KEY_MAX_NUMBER))
            return pdi_text_fail_key(s->ctx, s->text, section, "i",
                                     "found %g A/m2 at E = %.6g V, expected a number, or "
                                     "another range",
                                     e->current[k], e->potential[k]);
        if (k && e->current[k] < e->current[k - 1])
            return pdi_text_fail_key(
                s->ctx, s->text, section, "i",
                "found a current that falls from %.6g to %.6g A/m2 "
                "between E = %.6g and %.6g V, where a field would have several solutions; expected "
                "one that rises or stays (cathodic currents are negative). A peak of active metal "
                "is solved among ions: migration = yes in [chemistry], the curve as current of "
                "[dissolve], and a potential here",
                e->current[k - 1], e->current[k], e->potential[k - 1], e->potential[k]);
    }
    e->term.kind = PD_ELECTRODE_TABLE;
    e->term.points = e->points;
    e->term.potential = e->potential;
    e->term.current = e->current;
    return PD_OK;
}

/* Check that a curve in E, pH and species does not fall with E from -4 to 4 V, at 1 mol/m3 of each species and pH 7.
 * Potentials where |i| is not below PD_KEY_MAX_NUMBER are left out, falls within rounding admitted. PD_ERR_ARGUMENT. */
static pd_status pdi_read_potential_check_rising(pdi_reader *s, int section, const pd_setup_electrode *e)
{
    double vars[PD_EXPR_VARS], last = -HUGE_VAL;
    for (int k = 0; k < PD_EXPR_VARS; k++) vars[k] = 1.0;
    vars[1] = 7.0;
    for (int k = 0; k <= PDI_READ_POTENTIAL_CHECK_POINTS; k++) {
        vars[0] = PDI_READ_POTENTIAL_CHECK_RANGE * (2.0 * k / PDI_READ_POTENTIAL_CHECK_POINTS - 1.0);
        double i = pd_expr_eval(&e->species_curve, vars);
        if (!(fabs(i) < PD_KEY_MAX_NUMBER)) continue;
        if (i < last - PDI_READ_POTENTIAL_CHECK_TOL * fabs(last))
            return pdi_text_fail_key(s->ctx, s->text, section, "i",
                                     "found a current that falls from %.6g to %.6g A/m2 "
                                     "as E rises to %.6g V, at 1 mol/m3 of each species, expected one that rises or "
                                     "stays "
                                     "(cathodic currents are negative)",
                                     last, i, vars[0]);
        last = i;
    }
    return PD_OK;
}

/* With migrating ions, read a curve whose text has "pH" or '['; it stays an expression instead of a table, with
 * e->has_species_curve 1. Any other curve is left alone. PD_ERR_ARGUMENT: pH without species H+, a film resistance or
 * range beside it, or a current that falls with E. */
static pd_status pdi_read_potential_species_curve(pdi_reader *s, int section, pd_setup_electrode *e)
{
    pd_expr_symbol vars[PD_EXPR_VARS];
    char name[PD_EXPR_VARS][PD_SPECIES_NAME + 2];
    const char *text;
    int count = 2;
    if (!s->setup->has_migration || !pdi_text_has_key(s->ctx, s->text, section, "i")) return PD_OK;
    PD_TRY(pdi_text_get_string(s->ctx, s->text, section, "i", NULL, &text));
    if (!strchr(text, '[') && !strstr(text, "pH")) return PD_OK;
    memset(vars, 0, sizeof vars);
    vars[0] = pdi_read_potential_curve_symbol[0];
    vars[1].name = "pH";
    vars[1].unit = "";
    PD_TRY(pdi_read_surface_states_species_symbols(s, section, "i", vars, name, &count, e->species_index,
                                                   &e->species_count));
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "i", "A/m2", vars, count, NULL, &e->species_curve));
    e->has_species_curve = 1;
    if ((e->species_curve.variables_used >> 1 & 1u) && pd_electrolyte_find_species(&s->setup->electrolyte, "H+") < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "i",
                                 "found pH without the species H+, expected [species H+] "
                                 "and others");
    if (e->film_resistance > 0.0 || pdi_text_has_key(s->ctx, s->text, section, "range"))
        return pdi_text_fail_key(s->ctx, s->text, section, e->film_resistance > 0.0 ? "film_resistance" : "range",
                                 "found beside a curve in pH "
                                 "or species, expected none");
    return pdi_read_potential_check_rising(s, section, e);
}

/* Read a polarisation curve that is given as an expression (key `i`), as a table of points with the range of measured
 * tables in it, or, with pH or species, as it is. */
static pd_status pdi_read_potential_expression_curve(pdi_reader *s, int section, pd_setup_electrode *e)
{
    pd_expr curve;
    PD_TRY(pdi_read_potential_species_curve(s, section, e));
    if (e->has_species_curve) return PD_OK;
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, "i", "A/m2", pdi_read_potential_curve_symbol, 1, NULL, &curve));
    pd_expr_get_table_range(&curve, 0, e->table_range);
    pd_status status = pdi_read_potential_tabulate_curve(s, section, &curve, e);
    pd_expr_free(s->ctx, &curve);
    return status;
}

/* Read the polarisation curve of an electrode: Butler-Volmer, Tafel, linear, an expression, or primary (no kinetics),
 * with its parameters, E0 (not of an expression) and film resistance. With ions that migrate it may be absent
 * (e->has_no_curve). PD_ERR_ARGUMENT: it is absent otherwise, or primary with ions that migrate. */
static pd_status pdi_read_potential_kinetics(pdi_reader *s, int section, pd_setup_electrode *e)
{
    int curve = 0;
    e->has_no_curve = s->setup->has_migration && !pdi_text_has_key(s->ctx, s->text, section, "curve");
    if (e->has_no_curve) return PD_OK;
    if (!pdi_text_has_key(s->ctx, s->text, section, "curve"))
        return pdi_text_fail_key(s->ctx, s->text, section, "curve",
                                 "found no polarisation curve, expected curve = "
                                 "butler_volmer, tafel, linear, expression or primary");
    PD_TRY(pdi_key_value_get_index(s->ctx, s->text, section, "curve", &curve));
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "film_resistance", &e->film_resistance));
    if (curve == PDI_READ_POTENTIAL_EXPRESSION) return pdi_read_potential_expression_curve(s, section, e);
    PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "E0", &e->term.equilibrium));
    e->primary = curve == PDI_READ_POTENTIAL_PRIMARY;
    if (e->primary && s->setup->has_migration)
        return pdi_text_fail_key(s->ctx, s->text, section, "curve",
                                 "found primary beside migration = yes of [chemistry],"
                                 " expected another curve");
    if (e->primary) return PD_OK;
    if (curve != PDI_READ_POTENTIAL_LINEAR)
        return pdi_read_potential_tafel_slopes(s, section, curve == PDI_READ_POTENTIAL_BUTLER_VOLMER, &e->term);
    e->term.kind = PD_ELECTRODE_LINEAR;
    return pdi_key_value_get_number(s->ctx, s->text, section, "polarisation_resistance", &e->term.resistance);
}

/* ---- circuits ---- */

/* Read the prescribed potential [V] or current [A] of an electrode into e->fixed_value, a function of t; neither: it
 * floats. PD_ERR_ARGUMENT: both, or a function of x, y or z. */
static pd_status pdi_read_potential_control(pdi_reader *s, int section, pd_setup_electrode *e)
{
    e->has_fixed_potential = pdi_text_has_key(s->ctx, s->text, section, "potential");
    e->has_fixed_current = pdi_text_has_key(s->ctx, s->text, section, "current");
    if (e->has_fixed_potential && e->has_fixed_current)
        return pdi_text_fail_key(s->ctx, s->text, section, "current", "found beside 'potential', expected one of them");
    if (!e->has_fixed_potential && !e->has_fixed_current) return PD_OK;
    const char *key = e->has_fixed_potential ? "potential" : "current";
    PD_TRY(pdi_text_get_expr(s->ctx, s->text, section, key, e->has_fixed_potential ? "V" : "A",
                             pd_setup_get_position_symbols(), PD_SETUP_POSITION_VARS, NULL, &e->fixed_value));
    if (!(e->fixed_value.variables_used & ~((uint32_t)1 << PD_DIM))) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, key, "found a function of the place, expected one of t alone");
}

/* Read the electrodes that are electrically connected to electrode `own`, if there are any, and merge their circuits
 * into the one with the smaller number. PD_ERR_ARGUMENT: no other electrode of that name. */
static pd_status pdi_read_potential_connections(pdi_reader *s, int section, int own)
{
    pd_setup_potential *p = &s->setup->potential;
    pd_word_list list;
    if (!pdi_text_has_key(s->ctx, s->text, section, "connected")) return PD_OK;
    PD_TRY(pdi_text_get_words(s->ctx, s->text, section, "connected", NULL, &list));
    for (int w = 0; w < list.count; w++) {
        int other = 0;
        while (other < p->electrodes && strcmp(p->electrode[other].name, list.word[w]) != 0) other++;
        if (other == p->electrodes || other == own)
            return pdi_text_fail_key(s->ctx, s->text, section, "connected",
                                     "found '%s', expected the name of another "
                                     "[electrode NAME]",
                                     list.word[w]);
        int a = p->electrode[own].circuit, b = p->electrode[other].circuit;
        for (int k = 0; k < p->electrodes; k++)
            if (p->electrode[k].circuit == (a < b ? b : a)) p->electrode[k].circuit = a < b ? a : b;
    }
    return PD_OK;
}

/* Check that at most one electrode of each circuit has a prescribed potential or current. PD_ERR_ARGUMENT. */
static pd_status pdi_read_potential_check_circuits(pdi_reader *s)
{
    const pd_setup_potential *p = &s->setup->potential;
    for (int k = 0; k < p->electrodes; k++)
        for (int j = 0; j < k; j++) {
            const pd_setup_electrode *a = &p->electrode[j], *b = &p->electrode[k];
            if (a->circuit != b->circuit || !(a->has_fixed_potential || a->has_fixed_current) ||
                !(b->has_fixed_potential || b->has_fixed_current))
                continue;
            return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "electrode", b->name),
                                     b->has_fixed_potential ? "potential" : "current",
                                     "found beside that of %s, which %s is connected "
                                     "to, expected one of them",
                                     a->name, b->name);
        }
    return PD_OK;
}

/* ---- sections ---- */

/* Add a monitor of potential and current of an electrode; index: of the electrode. PD_ERR_ARGUMENT: too many monitors.
 */
static pd_status pdi_read_potential_add_monitor(pdi_reader *s, int section, int index)
{
    pd_setup *u = s->setup;
    if (u->monitors == PD_SETUP_MONITORS)
        return pdi_text_fail_key(s->ctx, s->text, section, "electrode", "found more than %d tables", PD_SETUP_MONITORS);
    pd_setup_monitor *m = &u->monitor[u->monitors++];
    memset(m, 0, sizeof *m);
    m->kind = PD_MONITOR_ELECTRODE;
    m->index = index;
    m->line = u->potential.electrode[index].line;
    memcpy(m->name, u->potential.electrode[index].name, sizeof m->name);
    return PD_OK;
}

/* Read one [electrode NAME] section and append the electrode, in a circuit of its own, with its monitor.
 * PD_ERR_ARGUMENT: too many electrodes, no name, one of PD_TEXT_WORD bytes or more, or, with ions that migrate, a curve
 * without a half-reaction. */
static pd_status pdi_read_potential_electrode(pdi_reader *s, int section)
{
    pd_setup_potential *p = &s->setup->potential;
    const char *label = s->text->section[section].label;
    if (p->electrodes == PD_SETUP_ELECTRODES)
        return pdi_text_fail_key(s->ctx, s->text, section, "electrode", "found more than %d electrodes",
                                 PD_SETUP_ELECTRODES);
    if (label[0] == '\0' || strlen(label) >= PD_TEXT_WORD)
        return pdi_text_fail_key(s->ctx, s->text, section, "electrode", "expected a short name: [electrode NAME]");
    pd_setup_electrode *e = &p->electrode[p->electrodes];
    memcpy(e->name, label, strlen(label) + 1);
    e->line = s->text->section[section].line;
    e->circuit = p->electrodes++;
    PD_TRY(pdi_read_potential_location(s, section, e));
    PD_TRY(pdi_read_potential_kinetics(s, section, e));
    PD_TRY(pdi_read_surface_states_current_factor(s, section, e->circuit));
    PD_TRY(pdi_read_potential_control(s, section, e));
    e->has_reaction = pdi_text_has_key(s->ctx, s->text, section, "reaction");
    if (e->has_reaction) PD_TRY(pdi_read_chemistry_electrode_reaction(s, section, e->species_released));
    if (s->setup->has_migration && !e->has_reaction && !e->has_no_curve)
        return pdi_text_fail_key(s->ctx, s->text, section, "reaction",
                                 "found none, expected the half-reaction by which "
                                 "the current of the curve enters the ions: reaction = O2 + 2 H2O + 4 e- = 4 OH-");
    p->has_reaction = p->has_reaction || e->has_reaction;
    return pdi_read_potential_add_monitor(s, section, e->circuit);
}

/* Read the Dirichlet potentials [V] of the fluid at sides that have one; no current passes others. PD_ERR_ARGUMENT:
 * with ions that migrate, or at a side that is neither wall nor inlet. */
static pd_status pdi_read_potential_sides(pdi_reader *s)
{
    pd_setup *u = s->setup;
    for (int k = 0; k < 2 * PD_DIM; k++) {
        int section = pdi_text_get_section(s->ctx, s->text, "side", pd_setup_side_name(k));
        if (!pdi_text_has_key(s->ctx, s->text, section, "potential")) continue;
        if (u->has_migration)
            return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                     "found beside migration = yes of [chemistry],"
                                     " expected species = inlet, which holds ions at the potential 0");
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "potential", &u->potential.fixed_potential[k]));
        u->potential.has_fixed_potential[k] = 1;
        if (u->side[k].kind == PD_SIDE_WALL || u->side[k].kind == PD_SIDE_INLET) continue;
        return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                 "found at a side that is no wall and no inlet, "
                                 "expected flow = noslip or inlet there");
    }
    return PD_OK;
}

/* Read conductivity and tolerance of the section [potential]. The conductivity may be absent with species, which then
 * give it. PD_ERR_ARGUMENT: it is given with ions that migrate, or absent without species. */
static pd_status pdi_read_potential_conductivity(pdi_reader *s, int section)
{
    pd_setup_potential *p = &s->setup->potential;
    if (s->setup->has_migration && pdi_text_has_key(s->ctx, s->text, section, "conductivity"))
        return pdi_text_fail_key(s->ctx, s->text, section, "conductivity",
                                 "found beside migration = yes of [chemistry], "
                                 "expected none: it is that of the ions");
    if (!pdi_text_has_key(s->ctx, s->text, section, "conductivity") && !s->setup->has_chemistry)
        return pdi_text_fail_key(s->ctx, s->text, section, "conductivity",
                                 "found none, expected [potential] "
                                 "conductivity = 1.5 S/m or another positive value");
    if (pdi_text_has_key(s->ctx, s->text, section, "conductivity"))
        PD_TRY(pdi_key_value_get_number(s->ctx, s->text, section, "conductivity", &p->conductivity));
    return pdi_key_value_get_number(s->ctx, s->text, section, "tolerance", &p->tolerance);
}

PDI_FN pd_status pdi_read_potential_read(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_get_section(s->ctx, s->text, "potential", NULL), k = 0;
    int first = pdi_text_next_section(s->ctx, s->text, "electrode", -1);
    if (!u->has_potential) return PD_OK;
    if (u->has_gas)
        return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                 "found beside [gas], expected [flow] or fluid at "
                                 "rest");
    if (first < 0)
        return pdi_text_fail_key(s->ctx, s->text, section, "potential",
                                 "found no electrode, expected an [electrode "
                                 "NAME] with a shape and a curve");
    for (int n = 0; n < s->text->const_count; n++)
        if (strcmp(s->text->consts[n].name, "E") == 0 || strcmp(s->text->consts[n].name, "i") == 0)
            return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "constants", NULL),
                                     s->text->consts[n].name,
                                     "found the name '%s' beside [potential], where it is a "
                                     "variable, expected another one",
                                     s->text->consts[n].name);
    PD_TRY(pdi_read_potential_conductivity(s, section));
    PD_TRY(pdi_read_potential_sides(s));
    for (int at = first; at >= 0; at = pdi_text_next_section(s->ctx, s->text, "electrode", at))
        PD_TRY(pdi_read_potential_electrode(s, at));
    for (int at = first; at >= 0; at = pdi_text_next_section(s->ctx, s->text, "electrode", at))
        PD_TRY(pdi_read_potential_connections(s, at, k++));
    return pdi_read_potential_check_circuits(s);
}

#undef PDI_READ_POTENTIAL_TABLE_POINTS
#undef PDI_READ_POTENTIAL_CHECK_POINTS
#undef PDI_READ_POTENTIAL_CHECK_RANGE
#undef PDI_READ_POTENTIAL_CHECK_TOL
