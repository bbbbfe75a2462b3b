/* setup: see setup.h */
#include "setup/setup.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Names of the sides of the box, number 2 axis + (1: upper). */
static const char *const pdi_setup_side_names[] = {"x-", "x+", "y-", "y+", "z-", "z+"};
/* Coordinates of a point as expression variables. */
#if PD_DIM == 1
#define PDI_SETUP_COORDINATES {"x", "m", 0.0}
#elif PD_DIM == 2
#define PDI_SETUP_COORDINATES {"x", "m", 0.0}, {"y", "m", 0.0}
#else
#define PDI_SETUP_COORDINATES {"x", "m", 0.0}, {"y", "m", 0.0}, {"z", "m", 0.0}
#endif
/* Variables of expressions in space and time. */
static const pd_expr_symbol pdi_setup_position_symbols[] = {PDI_SETUP_COORDINATES, {"t", "s", 0.0}};
/* Variables of dissolution rate laws. */
static const pd_expr_symbol pdi_setup_rate_symbols[] = {
    {"C", "mol/m3", 0.0}, {"t", "s", 0.0}, PDI_SETUP_COORDINATES, {"grain", "", 0.0}, {"i", "A/m2", 0.0},
    {"E", "V", 0.0},      {"", "", 0.0},   {"", "", 0.0},         {"", "", 0.0},      {"", "", 0.0}};
/* Variables of the stress factor of the dissolution rate. */
static const pd_expr_symbol pdi_setup_stress_symbols[] = {
    {"sigma_h", "Pa", 0.0}, {"mises", "Pa", 0.0}, {"eps_p", "", 0.0}, PDI_SETUP_COORDINATES, {"t", "s", 0.0}};
#undef PDI_SETUP_COORDINATES

pd_status pd_setup_init(pd_ctx *ctx, pd_setup *setup)
{
    memset(setup, 0, sizeof *setup);
    setup->solid = setup->wall = setup->medium = setup->passive = setup->solution = -1;
    setup->fluid_m = 1.0;
    setup->metal_m = 3.0;
    setup->gb_factor = 1.0;
    setup->slice_axis = PD_DIM - 1;
    setup->metals = 1;
    pd_material_find("mg4ag", &setup->metal[0].material);
    setup->metal[0].solid_c = pd_material_concentration(&setup->metal[0].material);
    setup->metal[0].shape = -1;
    setup->metal[0].rate_scale = 1.0;
    memcpy(setup->prefix, "corr", 5);
    memcpy(setup->folder, "output", 7);
    pd_status status = PD_NEW(ctx, "setup", PD_SHAPE_MAX, setup->shape);
    if (status < 0) memset(setup, 0, sizeof *setup);
    return status;
}

/* Free the expressions of loads, supports, body force and stress factor. */
static void pdi_setup_free_mechanics(pd_ctx *ctx, pd_setup_mechanics *b)
{
    for (int k = 0; k < b->mechanical_bcs; k++) {
        for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &b->mechanical_bc[k].displacement[d]);
        for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &b->mechanical_bc[k].traction[d]);
        pd_expr_free(ctx, &b->mechanical_bc[k].pressure);
    }
    for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &b->force[d]);
    pd_expr_free(ctx, &b->rate_factor);
}

/* Free expressions and tables of all electrodes; their number stays. */
static void pdi_setup_free_electrodes(pd_ctx *ctx, pd_setup_potential *p)
{
    for (int k = 0; k < p->electrodes; k++) {
        pd_setup_electrode *e = &p->electrode[k];
        pd_expr_free(ctx, &e->species_curve);
        PD_DELETE(ctx, e->points, e->potential);
        PD_DELETE(ctx, e->points, e->current);
        pd_expr_free(ctx, &e->fixed_value);
        pd_expr_free(ctx, &e->current_factor);
    }
}

void pd_setup_free(pd_ctx *ctx, pd_setup *setup)
{
    pdi_setup_free_mechanics(ctx, &setup->metal_body);
    pdi_setup_free_electrodes(ctx, &setup->potential);
    for (int r = 0; r < setup->registered_count; r++) {
        for (int k = 0; k < PD_PHYSICS_TYPE_KEYS; k++) pd_expr_free(ctx, &setup->registered[r].value[k]);
        for (int s = 0; s < 2 * PD_DIM; s++) pd_expr_free(ctx, &setup->registered[r].prescribed[s]);
    }
    for (int s = 0; s < 2 * PD_DIM; s++) {
        for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &setup->side[s].velocity[d]);
        for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &setup->side[s].wall_velocity[d]);
        pd_expr_free(ctx, &setup->side[s].inflow_of_time);
        pd_expr_free(ctx, &setup->side[s].inlet_c);
        pd_expr_free(ctx, &setup->side[s].fixed_c);
    }
    for (int k = 0; k < setup->wall_count; k++) pd_expr_free(ctx, &setup->wall_shape[k].fixed_c);
    for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &setup->body_force[d]);
    for (int d = 0; d < PD_DIM; d++) pd_expr_free(ctx, &setup->initial_velocity[d]);
    pd_expr_free(ctx, &setup->gas_rho);
    pd_expr_free(ctx, &setup->gas_p);
    pd_expr_free(ctx, &setup->initial_c);
    for (int k = 0; k < setup->metals; k++) {
        pd_expr_free(ctx, &setup->metal[k].rate);
        pd_expr_free(ctx, &setup->metal[k].potential);
    }
    for (int k = 0; k < setup->states; k++) {
        pd_expr_free(ctx, &setup->state[k].initial);
        pd_expr_free(ctx, &setup->state[k].rate);
    }
    for (int k = 0; k < setup->masks; k++) PD_DELETE(ctx, setup->mask_size[k], setup->mask[k]);
    for (int k = 0; k < setup->facets_count; k++) {
        pd_facets_free(ctx, setup->facets[k]);
        PD_DELETE(ctx, 1, setup->facets[k]);
    }
    PD_DELETE(ctx, PD_SHAPE_MAX, setup->shape);
    for (int k = 0; k < setup->tables; k++) pdi_monotone_cubic_free(ctx, &setup->table[k].curve);
    PD_DELETE(ctx, setup->tables, setup->table);
    PD_DELETE(ctx, setup->tables, setup->function);
    PD_DELETE(ctx, setup->fingerprint_size, setup->fingerprint);
    pd_setup_free_measured(ctx, setup);
    memset(setup, 0, sizeof *setup);
}

/* Error of pd_setup_set_function: the value under `key` cannot be a function, and why. Returns PD_ERR_ARGUMENT. */
static pd_status pdi_setup_fail_function(pd_ctx *ctx, const char *key, const char *why)
{
    return pd_fail(ctx, PD_ERR_ARGUMENT, "setup", "a function for '%.40s': %s", key, why);
}

/* The expression that a user function replaces, and what is no longer asked for where one does. */
typedef struct pdi_setup_replaced {
    pd_expr *expr;
    double *flow_rate;  /* of a side whose mean it gives, which becomes 0; NULL: none */
    double *rate_scale; /* of a metal whose rate it gives, which becomes 1; NULL: none */
    int is_inlet_c;     /* 1: the concentration of one inlet, after which each side has its own */
} pdi_setup_replaced;

/* Find the expression of a boundary condition that a user function replaces: key "x-.C", "x-.mean" or "x-.vx", whose
 * side is given. PD_ERR_ARGUMENT: another name; for mean no inlet with a mean; for vx no inlet whose expression is not
 * scaled; for C neither inlet nor wall with a concentration, no transport, or a [transfer] that refers to the inlet. */
static pd_status pdi_setup_find_side_expr(pd_ctx *ctx, pd_setup *u, const char *key, pd_setup_side *side,
                                          pdi_setup_replaced *found)
{
    const char *name = key + 3;
    int inlet = side->kind == PD_SIDE_INLET && side->profile != PD_PROFILE_NONE;
    if (strcmp(name, "mean") == 0) {
        if (!inlet || (side->profile == PD_PROFILE_EXPRESSION && !side->is_scaled))
            return pdi_setup_fail_function(ctx, key,
                                           "expected an inlet with profile = uniform or parabola, or with "
                                           "'mean' beside an expression");
        found->flow_rate = &side->flow_rate;
        found->expr = &side->inflow_of_time;
        return PD_OK;
    }
    for (int d = 0; d < PD_DIM; d++) {
        if (name[0] != 'v' || name[1] != "xyz"[d] || name[2]) continue;
        found->expr = &side->velocity[d];
        if (inlet && side->profile == PD_PROFILE_EXPRESSION && !side->is_scaled) return PD_OK;
        return pdi_setup_fail_function(ctx, key, "expected an inlet with profile = expression, without 'mean'");
    }
    if (strcmp(name, "C") != 0)
        return pdi_setup_fail_function(ctx, key, "expected C, mean or vx, vy, vz behind the side");
    found->expr = side->has_fixed_c ? &side->fixed_c : &side->inlet_c;
    if (!u->has_transport || !(side->has_fixed_c || side->kind == PD_SIDE_INLET))
        return pdi_setup_fail_function(ctx, key, "expected an inlet, or a wall that holds a concentration");
    for (int k = 0; k < u->monitors && !side->has_fixed_c; k++)
        if (u->monitor[k].kind == PD_MONITOR_TRANSFER && u->monitor[k].reference == PD_REFERENCE_FLUID_INLET)
            return pdi_setup_fail_function(ctx, key, "[transfer] has fluid = inlet, expected bulk or a concentration");
    found->is_inlet_c = !side->has_fixed_c;
    return PD_OK;
}

/* Find the expression of the dissolution rate that a user function replaces: key "rate" of a single metal, or
 * "rate.NAME" of the material of one. PD_ERR_ARGUMENT: nothing dissolves, no such metal, "rate" with several metals, or
 * `uses` names the grain without grains. */
static pd_status pdi_setup_find_rate_expr(pd_ctx *ctx, pd_setup *u, const char *key, uint32_t uses,
                                          pdi_setup_replaced *found)
{
    int metal = u->metals == 1 && !key[4] ? 0 : -1;
    if (!u->has_dissolve) return pdi_setup_fail_function(ctx, key, "expected [dissolve] or [corrode]");
    for (int k = 0; k < u->metals && key[4]; k++)
        if (u->metal[k].material.name && strcmp(u->metal[k].material.name, key + 5) == 0) metal = k;
    if (metal < 0)
        return pdi_setup_fail_function(ctx, key,
                                       key[4] ? "no solid is of that material"
                                              : "there are several metals, expected rate.NAME for one of them");
    if ((uses >> PD_SETUP_RATE_GRAIN & 1u) && !u->has_grains)
        return pdi_setup_fail_function(ctx, key, "it depends on the grain, expected a solid [shape] with grain_size");
    found->rate_scale = &u->metal[metal].rate_scale;
    found->expr = &u->metal[metal].rate;
    return PD_OK;
}

/* Find the expression that a user function replaces under `key`: "rate", "initial" or a value of a side. *found is
 * zeroed first; the setup is not changed. PD_ERR_ARGUMENT: no such key, or the scene does not give that value. */
static pd_status pdi_setup_find_expr(pd_ctx *ctx, pd_setup *u, const char *key, uint32_t uses,
                                     pdi_setup_replaced *found)
{
    memset(found, 0, sizeof *found);
    if (strcmp(key, "rate") == 0 || strncmp(key, "rate.", 5) == 0) {
        PD_TRY(pdi_setup_find_rate_expr(ctx, u, key, uses, found));
    } else if (strcmp(key, "initial") == 0) {
        if (!u->has_transport) return pdi_setup_fail_function(ctx, key, "expected [transport] or [corrode]");
        found->expr = &u->initial_c;
    }
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (strncmp(key, pdi_setup_side_names[s], 2) == 0 && key[2] == '.')
            PD_TRY(pdi_setup_find_side_expr(ctx, u, key, &u->side[s], found));
    if (!found->expr)
        return pdi_setup_fail_function(ctx, key, "expected rate, initial, or a side and its value, such as x-.C");
    return PD_OK;
}

pd_status pd_setup_set_function(pd_ctx *ctx, pd_setup *u, const char *key, pd_expr_fn fn, void *user, uint32_t uses)
{
    pdi_setup_replaced found;
    PD_TRY(pdi_setup_find_expr(ctx, u, key, uses, &found));
    if (found.flow_rate) *found.flow_rate = 0.0;
    if (found.rate_scale) *found.rate_scale = 1.0;
    if (found.is_inlet_c) u->has_inlet_c_by_side = 1;
    PD_DELETE(ctx, found.expr->discontinuity_count, found.expr->discontinuities);
    found.expr->discontinuity_count = 0;
    found.expr->fn = fn;
    found.expr->user = user;
    found.expr->variables_used = found.flow_rate ? (uint32_t)1 << PD_DIM : uses;
    return PD_OK;
}

pd_status pd_setup_set_breaks(pd_ctx *ctx, pd_setup *u, const char *key, const double *t, int count)
{
    pdi_setup_replaced found;
    double *own = NULL;
    PD_TRY(pdi_setup_find_expr(ctx, u, key, 0, &found));
    if (!found.expr->fn || count < 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "setup", "%d breaks of '%.40s', expected at least 0, and a function in "
                       "its place", count, key);
    for (int k = 0; k < count; k++)
        if (!(fabs(t[k]) < HUGE_VAL) || (k && !(t[k] > t[k - 1])))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "setup", "break %d of '%.40s' is %g s, expected a finite time behind "
                           "the one before", k, key, t[k]);
    if (count) {
        PD_TRY(PD_NEW(ctx, "setup", count, own));
        memcpy(own, t, (size_t)count * sizeof *t);
    }
    PD_DELETE(ctx, found.expr->discontinuity_count, found.expr->discontinuities);
    found.expr->discontinuities = own;
    found.expr->discontinuity_count = count;
    found.expr->time_variable = found.rate_scale ? 1 : PD_DIM;
    return PD_OK;
}

void pd_setup_free_measured(pd_ctx *ctx, pd_setup *setup)
{
    for (int k = 0; k < setup->measured_count; k++) {
        pd_setup_measured *r = &setup->measured[k];
        PD_DELETE(ctx, r->points, r->time);
        PD_DELETE(ctx, r->points, r->value);
        PD_DELETE(ctx, r->points, r->spread);
    }
    memset(setup->measured, 0, sizeof setup->measured);
    setup->measured_count = 0;
}

PDI_FN int pdi_setup_has_surface_area(const pd_setup *setup)
{
    int asked = setup->has_dissolve || setup->has_grains || setup->has_potential;
    for (int k = 0; k < setup->monitors; k++) asked = asked || setup->monitor[k].kind == PD_MONITOR_TRANSFER;
    return asked;
}

int pd_setup_count_ghost_layers(const pd_setup *setup)
{
    return (int)ceil((pdi_setup_has_surface_area(setup) ? pd_max(setup->fluid_m, setup->metal_m) : setup->fluid_m) +
                     0.5) -
           1;
}

PDI_FN int pdi_setup_get_bond_options(const pd_setup *setup)
{
    if (setup->has_flow) return 0;
    return setup->has_gas ? PD_BONDS_NO_FLOW : PD_BONDS_NO_FLOW | PD_BONDS_LOW_MEMORY;
}

void pd_setup_get_reactive_desc(const pd_setup *u, pd_reactive_desc *desc)
{
    const pd_electrolyte *e = &u->electrolyte;
    memset(desc, 0, sizeof *desc);
    desc->species = e->species;
    desc->count = e->count;
    desc->reactions = e->reaction;
    desc->reaction_count = e->reactions;
    desc->minerals = u->mineral;
    desc->mineral_count = u->minerals;
    desc->tortuosity = u->tortuosity;
    desc->activity = e->activity;
    desc->temperature = e->temperature;
    desc->order = u->steady_transport ? 1 : 2;
    desc->migration = u->has_migration;
}

const char *pd_setup_monitor_section_name(pd_monitor_kind kind)
{
    static const char *const names[] = {"line", "plane", "force", "transfer",  "total",
                                        "grip", "solid", "crack", "electrode", "surface"};
    return names[kind];
}

const char *pd_setup_side_name(int side) { return pdi_setup_side_names[side]; }

int pd_setup_count_cells(const pd_setup *setup, int axis)
{
    return (int)floor((setup->hi[axis] - setup->lo[axis]) / setup->h[axis] + 0.5);
}

const pd_expr_symbol *pd_setup_get_position_symbols(void) { return pdi_setup_position_symbols; }

const pd_expr_symbol *pd_setup_get_rate_symbols(void) { return pdi_setup_rate_symbols; }

const pd_expr_symbol *pd_setup_get_stress_symbols(void) { return pdi_setup_stress_symbols; }

double pd_setup_compute_rate_at_zero(const pd_setup_metal *metal)
{
    double vars[PD_EXPR_VARS];
    memset(vars, 0, sizeof vars);
    return metal->rate_scale * pd_expr_eval(&metal->rate, vars);
}

PDI_FN double pdi_setup_eval_expr(const pd_expr *expr, const double *x, double t)
{
    double vars[PD_SETUP_POSITION_VARS];
    memcpy(vars, x, PD_DIM * sizeof *x);
    vars[PD_DIM] = t;
    return pd_expr_eval(expr, vars);
}

pd_status pd_setup_add_shape(pd_ctx *ctx, pd_setup *setup, const pd_shape *shape, int *index)
{
    if (setup->shapes >= PD_SHAPE_MAX)
        return pd_fail(ctx, PD_ERR_SIZE, "setup", "more than %d shapes and set operations", PD_SHAPE_MAX);
    setup->shape[setup->shapes] = *shape;
    *index = setup->shapes++;
    return PD_OK;
}

pd_status pd_setup_add_union(pd_ctx *ctx, pd_setup *setup, int index, int *whole)
{
    pd_shape both;
    if (*whole < 0) {
        *whole = index;
        return PD_OK;
    }
    memset(&both, 0, sizeof both);
    both.type = PD_SHAPE_UNION;
    both.child_count = 2;
    both.child[0] = *whole;
    both.child[1] = index;
    return pd_setup_add_shape(ctx, setup, &both, whole);
}

pd_status pd_setup_add_complement(pd_ctx *ctx, pd_setup *setup, int *index)
{
    pd_shape outside;
    memset(&outside, 0, sizeof outside);
    outside.type = PD_SHAPE_COMPLEMENT;
    outside.child_count = 1;
    outside.child[0] = *index;
    return pd_setup_add_shape(ctx, setup, &outside, index);
}

pd_status pd_setup_add_mask(pd_ctx *ctx, pd_setup *setup, size_t size, uint8_t **mask)
{
    int k = setup->masks;
    if (k >= PD_SETUP_MASKS) return pd_fail(ctx, PD_ERR_SIZE, "setup", "more than %d masks", PD_SETUP_MASKS);
    PD_TRY(PD_NEW(ctx, "setup", size, setup->mask[k]));
    setup->mask_size[k] = size;
    *mask = setup->mask[k];
    setup->masks++;
    return PD_OK;
}

pd_status pd_setup_add_facets(pd_ctx *ctx, pd_setup *setup, pd_facets **surface)
{
    int k = setup->facets_count;
    if (k >= PD_SETUP_SURFACES)
        return pd_fail(ctx, PD_ERR_SIZE, "setup", "more than %d surfaces of triangles", PD_SETUP_SURFACES);
    PD_TRY(PD_NEW(ctx, "setup", 1, setup->facets[k]));
    *surface = setup->facets[k];
    setup->facets_count++;
    return PD_OK;
}

void pd_setup_add_note(pd_setup *setup, const char *format, ...)
{
    va_list args;
    if (setup->notes >= PD_SETUP_NOTES) return;
    va_start(args, format);
    vsnprintf(setup->note[setup->notes++], sizeof setup->note[0], format, args);
    va_end(args);
}

void pd_setup_format_value(double value, const char *unit, char *text)
{
    pd_ctx quiet;
    pd_dims dims;
    pd_ctx_init(&quiet);
    memset(&dims, 0, sizeof dims);
    pd_units_parse(&quiet, unit, NULL, &dims);
    pdi_units_format_value(value, &dims, text);
}
