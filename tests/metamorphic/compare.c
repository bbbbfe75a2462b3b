/* compare: see compare.h */
#include "compare.h"
#include "generate.h"
#include "lattice/grid.h"
#include "setup/units.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Figures that count work or rounding: of no value that a scene has. */
static int of_work(const run_figure *f)
{
    static const char *const keys[] = {"ledger", "current_balance", "iterations", "defect", "residual"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(f->key, keys[k]) == 0) return 1;
    return 0;
}

/* Dimension of "mol/m", "A/m2"; of a label "C [mol/m3]" what stands in its brackets. */
static dimension dimension_of(const char *text)
{
    dimension d;
    pd_dims found;
    pd_ctx quiet;
    char unit_name[48];
    const char *open = strchr(text, '[');
    memset(&d, 0, sizeof d);
    if (open) snprintf(unit_name, sizeof unit_name, "%.*s", (int)strcspn(open + 1, "]"), open + 1);
    else snprintf(unit_name, sizeof unit_name, "%s", text);
    pd_ctx_init(&quiet);
    if (!unit_name[0] || strcmp(unit_name, "-") == 0) return d;
    if (pd_units_parse(&quiet, unit_name, NULL, &found) < 0) return d;
    static const int from[6] = {0, 1, 2, 4, 3, 5}; /* there amperes stand before moles */
    for (int k = 0; k < 6; k++) d.e[k] = found.exponent[from[k]];
    return d;
}

static double factor_of(const transform *t, const char *unit_name)
{
    if (t->length == 1.0 && t->time == 1.0) return 1.0;
    dimension d = dimension_of(unit_name);
    return transform_factor(t, &d);
}

/* Solvers balance each component to 1e-13 (record) and the potential to 1e-12 of the amounts that meet there: twenty
 * steps of two runs leave this share of the largest amount. What is smaller is the rest of a difference and has no
 * figure of its own. */
#define CANCELS 4e-12
/* [V] RT/F: potentials of ions are differences of logarithms of concentrations times it. */
#define THERMAL_VOLTAGE 0.0257
/* [mol/m3] Rounding of the content of metal, 7e4 mol/m3, over a hundred steps. */
#define METAL_ROUNDING 1e-9
#define FARADAY 96485.0 /* [C/mol] */
/* [Pa] Rounding of strains, 2e-15, times a modulus of 45 GPa. */
#define STRESS_ROUNDING 1e-4

/* What values of this unit are wrong by at least, whatever their own size: by rounding of what they are differences
 * of. */
static double floor_of(const scene *x, const char *unit_name, double tolerance)
{
    dimension d = dimension_of(unit_name);
    double size = CANCELS * x->current;
    int of_force = d.e[1] == 1.0 && d.e[2] == -2.0 && d.e[4] == 0.0;
    if (of_force && x->has & HAS_SOLID) { /* stresses, energies and forces */
        double load = STRESS_ROUNDING;
        for (int k = -1; k < (int)d.e[0]; k++) load *= x->h[0];
        return load;
    }
    if (of_force && d.e[0] == -1.0) return tolerance * x->pressure; /* a flow is known to its residual */
    if (d.e[4] == 1.0 && d.e[1] == 0.0 && (d.e[2] == 0.0 || d.e[2] == 1.0)) {
        if (d.e[2] == 1.0) size *= x->time; /* charges */
        for (int k = -2; k < (int)d.e[0]; k++) size *= x->h[0];
        return size;
    }
    if (d.e[0] == 1.0 && d.e[2] == -1.0 && d.e[1] == 0.0) return 1e-3 * tolerance * x->h[0] / x->time;
    int of_volts = d.e[1] == 1.0 && d.e[4] == -1.0 && d.e[2] == -3.0;
    return of_volts ? CANCELS + tolerance * THERMAL_VOLTAGE : 0.0;
}

/* What the fluid has dissolved, where a scene dissolves next to nothing. */
static int is_dissolved(const char *key)
{
    return strcmp(key, "C") == 0 || strcmp(key, "C_max") == 0 || strcmp(key, "C_min") == 0 ||
           strcmp(key, "C_mean") == 0 || strcmp(key, "C_bulk") == 0;
}

/* ---- names under a turn ---- */

/* The letter of an axis at key[at], turned; *sign by its direction. */
static void rotate_letter(const transform *t, char *letter, double *sign)
{
    int axis = *letter - 'x';
    *letter = (char)('x' + t->to[axis]);
    *sign *= t->sign[axis];
}

static int is_axis(char c) { return c >= 'x' && c < 'x' + PD_DIM; }

/* sigma_xy becomes sigma_yz; xx has no sign. */
static void rotate_stress(const transform *t, char *name, double *sign)
{
    static const char *const pairs[6][2] = {{"xx", "xx"}, {"yy", "yy"}, {"zz", "zz"},
                                            {"xy", "yx"}, {"yz", "zy"}, {"zx", "xz"}};
    char *p = name + 6;
    if (strncmp(name, "sigma_", 6) != 0 || strlen(p) != 2 || p[0] < 'x' || p[0] > 'z' || p[1] < 'x' || p[1] > 'z')
        return;
    double s = 1.0;
    for (int k = 0; k < 2; k++)
        if (is_axis(p[k])) rotate_letter(t, &p[k], &s);
    *sign *= s;
    for (int k = 0; k < 6; k++)
        if (strcmp(p, pairs[k][1]) == 0) memcpy(p, pairs[k][0], 3);
}

/* The axis along which a figure is a place, as of the tip of a crack; -1: it is none. */
static int axis_of_place(const run_figure *f)
{
    return strcmp(f->section, "crack") == 0 && is_axis(f->key[0]) && !f->key[1] ? f->key[0] - 'x' : -1;
}

/* The figure of the second record that belongs to one of the first. */
static void rotate_figure(const transform *t, const scene *x, run_figure *f, double *sign)
{
    int boxed = strcmp(f->section, "force") == 0 || strcmp(f->section, "total") == 0 ||
                strcmp(f->section, "grip") == 0 || strcmp(f->section, "probe") == 0;
    *sign = 1.0;
    if (boxed && strchr("fmcvu", f->key[0]) && is_axis(f->key[1]) && (f->key[2] == '\0' || f->key[2] == '_'))
        rotate_letter(t, &f->key[1], sign);
    if (axis_of_place(f) >= 0) rotate_letter(t, &f->key[0], sign);
    rotate_stress(t, f->key, sign);
    if (strcmp(f->section, "plane") == 0 &&
        (strcmp(f->key, "flow") == 0 || strcmp(f->key, "species") == 0 || strcmp(f->key, "speed") == 0)) {
        for (int k = 0; k < x->entries; k++) {
            const entry *e = &x->list[k];
            if (e->kind == ENTRY_PLANE && strcmp(x->part[e->section].label, f->name) == 0) *sign = t->sign[e->axis];
        }
    }
    if (strcmp(f->section, "grip") == 0 && is_axis(f->name[0]) && (f->name[1] == '-' || f->name[1] == '+') &&
        !f->name[2]) {
        double s = 1.0;
        rotate_letter(t, &f->name[0], &s);
        if (s < 0.0) f->name[1] = f->name[1] == '-' ? '+' : '-';
    }
}

/* ---- values ---- */

static void report(finding *f, const char *kind, const char *name, double a, double b, double scale, const char *detail)
{
    size_t used = strlen(f->others);
    if (name[0] && !strstr(f->others, name)) snprintf(f->others + used, sizeof f->others - used, " %s", name);
    if (strstr(name, "flux_max")) scale *= 1e6; /* what else differs says more */
    double now = fabs(a - b) / scale, before = f->found ? fabs(f->a - f->b) / f->scale : -1.0;
    if (f->found && !(now > before) && !(isnan(now) && !isnan(before))) return;
    f->found = 1;
    snprintf(f->kind, sizeof f->kind, "%s", kind);
    snprintf(f->name, sizeof f->name, "%s", name);
    snprintf(f->detail, sizeof f->detail, "%s", detail);
    f->a = a;
    f->b = b;
    f->scale = scale;
}

/* Infinite and missing values agree with their like. */
static int agrees(double a, double b, double scale, double tolerance)
{
    if (isnan(a) || isnan(b)) return isnan(a) && isnan(b);
    if (a == b) return 1;
    return isfinite(a) && isfinite(b) && fabs(a - b) <= tolerance * scale;
}

static double size_of(const double *data, int64_t count)
{
    double most = 0.0;
    for (int64_t k = 0; k < count; k++)
        if (isfinite(data[k]) && fabs(data[k]) > most) most = fabs(data[k]);
    return most;
}

static const run_field *find_field(const record *r, const char *name)
{
    for (int k = 0; k < r->fields; k++)
        if (strcmp(r->field[k].name, name) == 0) return &r->field[k];
    return NULL;
}

/* [-] [Pa] Of what is held: a balance leaves forces of rtol, here the least that scenes have, of those that
 * displacements from cell to cell would have (solid/equilibrium), also those of a step before, where a grip has lost
 * its metal. Strains are wrong by twice that over h, displacements by as much along the body, and stresses by as much
 * times the largest modulus of waves, of nu = 0.4. */
#define HELD 1e-12
#define WAVE_MODULUS 9.7e10

/* 1: a side or a grip of the scene holds what is at rest. */
static int holds(const scene *x)
{
    int found = 0;
    for (int k = 0; k < x->entries && (x->has & HAS_SOLID) && !(x->has & HAS_MOTION); k++)
        found = found || (x->list[k].kind == ENTRY_COMPONENT && strcmp(x->list[k].key, "u") == 0);
    return found;
}

/* What a balance leaves unknown of displacements, or of stresses, energies and forces. */
static double floor_of_held(const scene *x, const record *a, const char *unit_name)
{
    const run_field *u = holds(x) ? find_field(a, "u(vector)") : NULL;
    dimension d = dimension_of(unit_name);
    double moved = u ? HELD * fmax(x->moved, size_of(u->data, u->components * a->cells)) : 0.0;
    double strain = 2.0 * moved / x->h[0], stress = WAVE_MODULUS * strain, length = 0.0;
    for (int k = 0; k < PD_DIM; k++) length = fmax(length, x->cells[k] * x->h[k]);
    if (d.e[1] == 1.0 && d.e[2] == -2.0 && d.e[4] == 0.0) {
        for (int k = -1; k < (int)d.e[0]; k++) stress *= x->h[0];
        return stress;
    }
    return d.e[0] == 1.0 && d.e[1] == 0.0 && d.e[2] == 0.0 && d.e[3] == 0.0 ? strain * length : 0.0;
}

/* [-] Each step leaves that of the balances of species which rounding does not let fall, in each of its two stages.
 * What follows from them amplifies it by less. */
#define FOLLOWS 10.0
static double left_of_steps(const record *a, const record *b)
{
    return 2.0 * FOLLOWS * (double)a->steps * fmax(a->residual, b->residual);
}

/* The largest value of any field of the same unit. */
static double size_of_kin(const record *r, const run_field *f)
{
    double most = 0.0;
    const char *own = strchr(f->label, '[');
    for (int k = 0; own && k < r->fields; k++) {
        const char *other = strchr(r->field[k].label, '[');
        if (!other || strcmp(own, other) != 0) continue;
        double size = size_of(r->field[k].data, r->field[k].components * r->cells);
        if (size > most) most = size;
    }
    return most;
}

/* [A/m2] What the balances of ions in a node leave of a current that is a difference: on metal before fluid that no
 * current leaves, all that passes is the rest of two reactions. */
static double current_error(const scene *x, const record *r)
{
    const run_field *ions = x->has & HAS_MIGRATION ? find_field(r, "Na+") : NULL;
    if (!ions || !r->steps) return 0.0;
    return CANCELS * FARADAY * size_of_kin(r, ions) * x->h[0] * (double)r->steps / r->time;
}

/* [as the figure] The same of figures of electrodes: of densities, and of their sum over the surface. */
static double electrode_error(const scene *x, const record *r, const run_figure *p)
{
    const run_figure *area = record_figure(r, p->section, p->name, "area");
    if (strcmp(p->key, "current") == 0) return area ? area->value * current_error(x, r) : 0.0;
    int density = strcmp(p->key, "density") == 0 || strcmp(p->key, "least") == 0 || strcmp(p->key, "most") == 0;
    return density ? current_error(x, r) : 0.0;
}

/* [-] The same over the least current that an electrode carries, or metal without one. */
static double current_share(const scene *x, const record *r)
{
    double least = HUGE_VAL, most = 0.0;
    if (!(x->has & HAS_MIGRATION)) return 0.0;
    for (int k = 0; k < r->figures; k++) {
        const run_figure *f = &r->figure[k];
        if (strcmp(f->section, "electrode") != 0) continue;
        if (strcmp(f->key, "least") == 0 || strcmp(f->key, "most") == 0) most = fmax(most, fabs(f->value));
        if (strcmp(f->key, "least") == 0 && fabs(f->value) > 0.0) least = fmin(least, fabs(f->value));
    }
    if (!(least < HUGE_VAL)) least = most;
    if (!(least > 0.0)) least = x->current;
    return least > 0.0 ? current_error(x, r) / least : 0.0;
}

/* [-] Rates of states read c/(STATE_HALF + c) of ions of metal (generate_chemistry): what balances leave of c changes a
 * state by this much. */
static double state_error(const record *r)
{
    const run_field *metal = find_field(r, "Mg2+");
    return metal ? CANCELS * size_of_kin(r, metal) / STATE_HALF : 0.0;
}

/* [V] Potentials take what is left of the current from curves that rise by their current over this voltage, the largest
 * slope of a curve. States of surfaces, other currents and charges follow it by the same share of themselves. */
#define CURVE_VOLTAGE 0.065
static double follows_current(const scene *x, const record *r, const char *unit_name, int of_state, double own)
{
    dimension d = dimension_of(unit_name);
    if (of_state) return fmax(own * current_share(x, r), state_error(r));
    if (d.e[4] == 1.0 && d.e[1] == 0.0) return own * current_share(x, r);
    return d.e[1] == 1.0 && d.e[4] == -1.0 && d.e[2] == -3.0 ? CURVE_VOLTAGE * current_share(x, r) : 0.0;
}

/* Relative error of H+ and OH- in a cell by what is left of differences: their total is H+ - OH-, of which an error e
 * is one of e/(H+ + OH-) of both. */
static double water_error(const record *r, int64_t cell)
{
    const run_field *acid = find_field(r, "H+"), *base = find_field(r, "OH-");
    if (!acid || !base) return 0.0;
    double sum = fabs(acid->data[cell]) + fabs(base->data[cell]);
    return sum > 0.0 ? CANCELS * size_of_kin(r, acid) / sum : 0.0;
}

/* [mol/m3] What is left of a current where none flows makes so much of the ions of metal. */
static double charge_error(const scene *x, const record *r)
{
    return CANCELS * x->current * r->time / (2.0 * FARADAY * x->h[0]);
}

/* [mol/m3] What balances and currents of two runs leave of ions of metal. */
static double metal_error(const scene *x, const record *r, const run_field *metal)
{
    return 2.0 * fmax(CANCELS * size_of_kin(r, metal), charge_error(x, r));
}

/* By how much logarithms of activities and of their products may be wrong in a cell: of next to no ion nothing is
 * known. */
static double logarithm_error(const scene *x, const record *r, int of_product, int64_t cell)
{
    const run_field *metal = of_product ? find_field(r, "Mg2+") : NULL;
    double error = 2.0 * water_error(r, cell);
    if (!metal) return error;
    double c = metal->data[cell], rest = metal_error(x, r, metal);
    return c > rest ? error - log1p(-rest / c) : HUGE_VAL;
}

static int64_t image_cell(const transform *t, const record *a, const record *b, int64_t cell)
{
    int64_t at[3] = {0, 0, 0}, rest = cell, to = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int64_t i = rest % a->n[d];
        rest /= a->n[d];
        if (d == t->unfold) i += a->n[d];
        at[t->to[d]] = t->sign[d] > 0 ? i : a->n[d] - 1 - i;
    }
    for (int d = PD_DIM - 1; d >= 0; d--) to = to * b->n[d] + at[d];
    return to;
}

static void compare_field(const scene *x, const transform *t, const record *a, const record *b, const run_field *p,
                          double tolerance, finding *f)
{
    char name[FIELD_NAME], detail[160];
    double sign = 1.0;
    int saturation = strcmp(p->name, "SI") == 0;
    snprintf(name, sizeof name, "%s", p->name);
    rotate_stress(t, name, &sign);
    const run_field *q = find_field(b, name);
    if (!q || q->components != p->components) {
        report(f, "missing", p->name, 0.0, 1.0, 1e-30, "the field is not there");
        return;
    }
    double factor = factor_of(t, p->label), own = size_of(p->data, p->components * a->cells);
    if (strcmp(p->name, "density") == 0 &&
        !(x->has & HAS_GAS)) { /* that of a material does not follow, that of a flow does */
        if ((x->has & HAS_FLOW) && factor != 1.0) return;
        factor = 1.0;
    }
    int logs = saturation || strcmp(p->name, "pH") == 0, of_ions = logs || strstr(p->label, "mol/m3") != NULL;
    double other = size_of(q->data, q->components * b->cells) / factor;
    if (other > own) own = other;
    if (logs && own < 1.0) own = 1.0;
    double least = floor_of(x, p->label, tolerance), kin = CANCELS * size_of_kin(a, p);
    if (kin > least) least = kin;
    if (of_ions && !logs) least = fmax(least, charge_error(x, a));
    if (tolerance > 0.0) least = fmax(least, fmax(floor_of_held(x, a, p->label), own * left_of_steps(a, b)));
    if (is_dissolved(p->name) && METAL_ROUNDING > least) least = METAL_ROUNDING;
    if (strcmp(p->name, "i") == 0) least = fmax(least, current_error(x, a));
    least = fmax(least, follows_current(x, a, p->label, strcmp(p->name, "theta") == 0, own));
    /* the scale on which the tolerance leaves that much */
    double scale = tolerance > 0.0 && least > tolerance * own ? least / tolerance : own;
    if (!(scale > 0.0)) scale = 1.0;
    int vector = strcmp(p->name, "v") == 0 || strstr(p->name, "(vector)") != NULL;
    for (int c = 0; c < p->components; c++) {
        int to = vector ? t->to[c] : 0;
        double s = vector ? t->sign[c] : sign;
        for (int64_t k = 0; k < a->cells; k++) {
            int64_t j = image_cell(t, a, b, k);
            double u = p->data[c * a->cells + k], v = s * q->data[to * b->cells + j] / factor;
            if (agrees(u, v, scale, tolerance)) continue;
            if (of_ions && tolerance > 0.0) {
                double error = logs ? logarithm_error(x, a, saturation, k) : 2.0 * water_error(a, k) * fabs(u);
                if (isinf(error) || fabs(u - v) <= tolerance * scale + error) continue;
            }
            int64_t at[3] = {k % a->n[0], k / a->n[0] % a->n[1], k / a->n[0] / a->n[1]};
            snprintf(detail, sizeof detail, "component %d at cell %d, %d, %d", c, (int)at[0], (int)at[1], (int)at[2]);
            report(f, "field", p->name, u, v, scale, detail);
        }
    }
}

/* Of the half: amounts are half of those of the whole. Figures of the surface of the box or of the largest value are
 * not. */
static double factor_of_half(const run_figure *g)
{
    static const char *const whole[] = {"volume", "energy",  "dissolved", "solid", "area",   "flow",    "species",
                                        "flux",   "current", "anodic",    "gas",   "work",   "stored",  "kinetic",
                                        "charge", "taken",   "released"};
    for (size_t k = 0; k < sizeof whole / sizeof whole[0]; k++)
        if (strcmp(g->key, whole[k]) == 0) return 2.0;
    if (strcmp(g->section, "total") == 0 && (strncmp(g->key, "sum_", 4) == 0 || strcmp(g->unit, "mol") == 0 ||
                                             strcmp(g->unit, "mol/m") == 0 || strcmp(g->unit, "mol/m2") == 0))
        return 2.0;
    return 1.0;
}

/* What passes a face of a cell under a slope of a thousandth of all there is: less than that is nothing. */
static double least_figure(const scene *x, const record *a, const run_figure *p)
{
    const run_field *flow = find_field(a, "v"), *ions = find_field(a, "Na+");
    double around = x->has & HAS_AXIS ? 2 : PD_DIM - 1, face = pow(x->h[0], around), c = 1.0;
    double speed = flow ? size_of(flow->data, PD_DIM * a->cells) : 0.0;
    for (int k = 0; k < a->fields; k++) {
        double most = strcmp(a->field[k].name, "C") == 0 ? size_of(a->field[k].data, a->cells) : 0.0;
        if (most > c) c = most;
    }
    if (ions) c = fmax(c, size_of_kin(a, ions));
    double passes = 1e-3 * c * (x->D / x->h[0] + speed);
    if (strcmp(p->section, "plane") != 0 && strcmp(p->section, "transfer") != 0) return 0.0;
    if (strcmp(p->key, "species") == 0 || strcmp(p->key, "flux") == 0) return passes * face;
    if (strcmp(p->key, "density") == 0) return passes;
    if (strcmp(p->key, "flow") == 0) return 1e-3 * speed * face;
    return strcmp(p->key, "speed") == 0 ? 1e-3 * speed : 0.0;
}

/* [-] Share of itself by which work is off: it is a sum over moves by Simpson's rule, as many as Newton's method needs,
 * and forces of these materials are curved by the strain. */
static double work_error(const scene *x)
{
    double length = x->h[0] * x->cells[0]; /* the shortest: what the strain is at most */
    for (int d = 1; d < PD_DIM; d++) length = fmin(length, x->h[d] * x->cells[d]);
    for (int k = 0; k < x->sections; k++) {
        entry *material = strcmp(x->part[k].name, "solid") == 0 ? scene_find((scene *)x, k, "model") : NULL;
        const char *name = material ? x->pool[material->first[0]].text : "";
        if (strcmp(name, "neo_hookean") == 0 || strcmp(name, "hencky") == 0)
            return pow(x->moved / length, 3.0);
    }
    return 0.0;
}

/* The mixed stream of a plane that nothing passes, and layers where nothing is given off, are 0 over 0. */
static int of_nothing(const scene *x, const record *a, const run_figure *p)
{
    const run_figure *by = NULL;
    if (strcmp(p->key, "C_bulk") == 0) by = record_figure(a, p->section, p->name, "flow");
    if (strcmp(p->key, "layer") == 0 || strcmp(p->key, "Sh") == 0) by = record_figure(a, p->section, p->name, "flux");
    if (strcmp(p->key, "faraday") == 0) { /* of metal that passes next to no charge */
        by = record_figure(a, p->section, p->name, "charge");
        return by && fabs(by->value) < 1e6 * floor_of(x, by->unit, CANCELS);
    }
    return by && fabs(by->value) < 1e-3 * least_figure(x, a, by);
}

/* fx, mz, ux, vy, cx_p */
static int is_component(const char *key)
{
    return strchr("fmcvu", key[0]) && is_axis(key[1]) && (key[2] == '\0' || key[2] == '_');
}

/* A probe is a mean of the values of a field about it, C_min, C_max and means are values of C: they are as right as the
 * field. */
static double size_of_probed(const record *a, const run_figure *p)
{
    int of_c = strncmp(p->key, "C_", 2) == 0;
    const run_field *field = of_c || strcmp(p->section, "probe") == 0 ? find_field(a, of_c ? "C" : p->key) : NULL;
    return field ? size_of(field->data, field->components * a->cells) : 0.0;
}

/* A step goes by the surface at its start, and takes 25 rtol of a cell at most (fraction): where the surface shrinks,
 * all steps take too much by half of that of the cells that it lost, of all at the surface at most. Over 10 rtol, which
 * pairs are held to. */
#define FRONT (0.5 * 25.0 / 10.0)

/* [-] Of the metal, cells beside fluid at the start, as far as cells that have turned could change the surface by all
 * their faces; 0 where bonds break, which have steps of their own. */
static double share_of_front(const scene *x, const record *a)
{
    const run_field *first = x->has & HAS_DISSOLVE ? find_field(a, FIRST_KIND) : NULL;
    const run_field *last = find_field(a, "kind");
    int64_t metal = 0, front = 0, turned = 0;
    for (int64_t i = 0; first && last && i < a->cells; i++) {
        int64_t at[3] = {i % a->n[0], i / a->n[0] % a->n[1], i / a->n[0] / a->n[1]}, stride = 1;
        int fluid = 0;
        if (first->data[i] != PD_SOLID) continue;
        for (int d = 0; d < PD_DIM; stride *= a->n[d], d++) {
            fluid = fluid || (at[d] > 0 && first->data[i - stride] == PD_FLUID);
            fluid = fluid || (at[d] + 1 < a->n[d] && first->data[i + stride] == PD_FLUID);
        }
        metal++;
        front += fluid;
        turned += last->data[i] == PD_FLUID;
    }
    if (front > 2 * PD_DIM * turned) front = 2 * PD_DIM * turned;
    return metal ? (double)front / (double)metal : 0.0;
}

/* Metal lost [as the solid], and what steps may get wrong at the surface: steps are right to a share of both, however
 * little is left. */
static double lost_of(const scene *x, const record *a, double solid)
{
    const run_figure *loss = record_figure(a, "scene", "", "volume_loss");
    double rest = loss && loss->value < 1.0 ? 1.0 - loss->value : 0.0;
    return rest > 0.0 ? solid * (loss->value + FRONT * share_of_front(x, a)) / rest : 0.0;
}

/* [as the amount] Metal that has gone into the species of a box. What fluid and minerals hold of it is what that leaves
 * beside what has passed the sides and what has become something else: the error of what is lost is one of all. */
static double given_by_metal(const scene *x, const record *a, const run_figure *p)
{
    const run_figure *solid = strcmp(p->section, "total") == 0 ? record_figure(a, "total", p->name, "solid") : NULL;
    return solid && strcmp(p->unit, solid->unit) == 0 ? lost_of(x, a, solid->value) : 0.0;
}

/* [as the amount] What the fluid of a box holds at the largest concentration of a species, or of any where the figure
 * is of several: the errors of steps are a share of the largest concentration. */
static double held_by_fluid(const scene *x, const record *a, const run_figure *p)
{
    const run_figure *volume = strcmp(p->section, "total") == 0 ? record_figure(a, "total", p->name, "volume") : NULL;
    const run_field *own = find_field(a, p->key), *any = find_field(a, "Na+");
    if (!volume || !(x->has & HAS_CHEMISTRY) || strncmp(p->unit, "mol", 3) != 0) return 0.0;
    if (own) return volume->value * size_of(own->data, own->components * a->cells);
    return any ? volume->value * size_of_kin(a, any) : 0.0;
}

static void compare_figure(const scene *x, const transform *t, const record *a, const record *b, const run_figure *p,
                           double tolerance, finding *f)
{
    char name[128];
    double sign, scale = 0.0, factor = factor_of(t, p->unit);
    run_figure rotated = *p;
    if (of_work(p) || of_nothing(x, a, p)) return;
    if (strcmp(p->key, "steps") == 0 && tolerance > 0.0) return; /* error control may take another one */
    if (t->unfold >= 0) {
        int forces = strcmp(p->section, "force") == 0 || strcmp(p->section, "grip") == 0;
        int across = (p->key[0] == 'm' || p->key[0] == 'f') && is_axis(p->key[1]);
        if (forces || across || strcmp(p->section, "plane") == 0 || strcmp(p->key, "unknowns") == 0) return;
        if (strcmp(p->key, "parts") == 0) return; /* one that meets the mirror is one with its image, others are two */
        factor *= factor_of_half(p);
    }
    rotate_figure(t, x, &rotated, &sign);
    const run_figure *q = record_figure(b, rotated.section, rotated.name, rotated.key);
    snprintf(name, sizeof name, "%s.%s.%s", p->section, p->name, p->key);
    if (!q) {
        report(f, "missing", name, p->value, 0.0, 1e-30, "the figure is not there");
        return;
    }
    double least = floor_of(x, p->unit, tolerance), like = 0.0, amounts = 0.0;
    /* components of a vector have one scale; what else has the unit may cancel */
    for (int k = 0; k < a->figures; k++) {
        const run_figure *g = &a->figure[k];
        double size = fabs(g->value);
        if (!isfinite(size) || strcmp(g->section, p->section) != 0) continue;
        if (strcmp(g->unit, p->unit) != 0 || p->unit[0] == '-') continue;
        if (is_component(p->key) && is_component(g->key) && strcmp(g->name, p->name) == 0 && g->key[0] == p->key[0] &&
            size > scale)
            scale = size;
        if (size > like) like = size;
        if (strncmp(g->key, "sum_", 4) != 0) amounts += size;
    }
    /* the charge is what is left of those of all ions, which have one or two charges each */
    if (strcmp(p->key, "sum_charge") == 0) like = fmax(like, 2.0 * amounts);
    if (CANCELS * like > least) least = CANCELS * like;
    if (strcmp(p->key, "parted") == 0 && q->value < 0.0) factor = 1.0; /* -1: never */
    double v = sign * q->value / factor;
    int along = axis_of_place(p);
    if (along >= 0) { /* a place follows the shift, too, and is known as well as the box */
        v -= sign * t->offset[along];
        scale = x->cells[along] * x->h[along];
    }
    if (isfinite(p->value) && fabs(p->value) > scale) scale = fabs(p->value);
    if (isfinite(v) && fabs(v) > scale) scale = fabs(v);
    scale = fmax(scale, size_of_probed(a, p));
    if (t->kind == TRANSFORM_TIGHTER && strcmp(p->unit, "-") == 0 && scale < 1e-3)
        scale = 1e-3; /* a loss of a thousandth */
    if (t->kind == TRANSFORM_TIGHTER && strcmp(p->key, "volume_loss") == 0) scale += FRONT * share_of_front(x, a);
    if (t->kind == TRANSFORM_TIGHTER && strcmp(p->key, "solid") == 0) scale += lost_of(x, a, p->value);
    if (t->kind == TRANSFORM_TIGHTER) scale = fmax(scale, fmax(given_by_metal(x, a, p), held_by_fluid(x, a, p)));
    const run_figure *loss = strcmp(p->key, "gas") == 0 ? record_figure(a, "scene", "", "volume_loss") : NULL;
    if (t->kind == TRANSFORM_TIGHTER && loss && loss->value > 0.0)
        scale *= 1.0 + FRONT * share_of_front(x, a) / loss->value;
    if (strncmp(p->key, "flux", 4) == 0 && scale < 1.0 && strcmp(p->section, "result") == 0)
        scale = 1.0; /* what balances lack, over what passes */
    if (strcmp(p->key, "volume_loss") == 0 && CANCELS > least) least = CANCELS;
    /* fluxes of species are differences of what diffuses both ways */
    int carries = strcmp(p->key, "species") == 0 || strcmp(p->key, "flux") == 0;
    double passes = fmax(tolerance, carries ? 1e3 * CANCELS : 0.0) * least_figure(x, a, p);
    if (passes > least) least = passes;
    if (tolerance > 0.0) least = fmax(least, fmax(floor_of_held(x, a, p->unit), scale * left_of_steps(a, b)));
    if (is_dissolved(p->key) && METAL_ROUNDING > least) least = METAL_ROUNDING;
    if (strcmp(p->section, "electrode") == 0) least = fmax(least, electrode_error(x, a, p));
    if (strcmp(p->key, "work") == 0) least = fmax(least, work_error(x) * scale);
    least = fmax(least, follows_current(x, a, p->unit, strcmp(p->section, "surface") == 0, scale));
    if (tolerance > 0.0 && least > tolerance * scale) scale = least / tolerance;
    if (!(scale > 0.0)) scale = 1.0;
    if (strcmp(p->key, "front") == 0 && tolerance > 0.0) tolerance = 1e-6; /* distances are single floats there */
    if (!agrees(p->value, v, scale, tolerance)) report(f, "figure", name, p->value, v, scale, p->unit);
}

/* 1: the outcomes differ, or there is nothing to compare. */
static int compare_outcomes(const record *a, const record *b, finding *f)
{
    if (a->outcome == OUTCOME_CRASHED || b->outcome == OUTCOME_CRASHED) {
        report(f, "crash", "", a->outcome, b->outcome, 1.0, a->outcome == OUTCOME_CRASHED ? a->message : b->message);
        return 1;
    }
    if (a->outcome == OUTCOME_HUNG || b->outcome == OUTCOME_HUNG) {
        report(f, "hang", "", a->outcome, b->outcome, 1.0, a->outcome == OUTCOME_HUNG ? "first" : "second");
        return 1;
    }
    if (a->outcome != b->outcome) {
        report(f, "outcome", outcome_names[a->outcome > b->outcome ? a->outcome : b->outcome], a->outcome, b->outcome,
               1.0, a->outcome > b->outcome ? a->message : b->message);
        return 1;
    }
    return a->outcome != OUTCOME_DONE;
}

static const run_file *find_file(const record *r, const char *name)
{
    for (int k = 0; k < r->files; k++)
        if (strcmp(r->file[k].name, name) == 0) return &r->file[k];
    return NULL;
}

void compare_records(const scene *x, const transform *t, const record *a, const record *b, double tolerance, finding *f)
{
    memset(f, 0, sizeof *f);
    if (compare_outcomes(a, b, f)) return;
    /* Whether a step of species of second order takes more than there is decides whether it stands. Where that is the
     * rest of a difference rounding says so, and runs take other steps. */
    f->other_steps = a->species_steps != b->species_steps || a->species_euler != b->species_euler;
    if (tolerance > 0.0 && f->other_steps) return;
    for (int k = 0; k < a->fields; k++) compare_field(x, t, a, b, &a->field[k], tolerance, f);
    for (int k = 0; k < a->figures; k++) compare_figure(x, t, a, b, &a->figure[k], tolerance, f);
    if (tolerance > 0.0) return;
    if (strcmp(a->line, b->line) != 0) {
        char lines[1100];
        snprintf(lines, sizeof lines, "%s | %s", a->line, b->line);
        report(f, "file", "result line", 0.0, 1.0, 1e-9, lines);
    }
    for (int k = 0; k < a->files || k < b->files; k++) {
        const run_file *p = k < a->files ? &a->file[k] : &b->file[k], *q = find_file(k < a->files ? b : a, p->name);
        if (!q) report(f, "file", p->name, (double)p->size, 0.0, 1.0, "is not there");
        else if (p->size != q->size || p->sum != q->sum)
            report(f, "file", p->name, (double)p->size, (double)q->size, 1e-9, "other bytes; sizes");
    }
}

/* What steps may get wrong by their tolerance: amounts, not what single cells show at an instant. */
static int of_amount(const scene *x, const run_figure *p)
{
    int metal = (x->has & (HAS_DISSOLVE | HAS_CORRODE)) != 0, dissolves = metal && !(x->has & HAS_CHEMISTRY);
    if (strcmp(p->key, "volume_loss") == 0 || strcmp(p->key, "gas") == 0) return 1;
    if (strcmp(p->section, "total") != 0) return 0;
    if (dissolves) return strcmp(p->key, "solid") == 0; /* what is in the fluid, no tolerance is of */
    if (metal && strcmp(p->key, "dissolved") == 0) return 0; /* nor of the metal in the fluid beside species */
    return strncmp(p->unit, "mol", 3) == 0 && strncmp(p->key, "C_", 2) != 0 && strcmp(p->key, "sum_charge") != 0;
}

void compare_steps(const scene *x, const transform *t, const record *a, const record *b, double tolerance, finding *f)
{
    int goes = (x->has & (HAS_DISSOLVE | HAS_CORRODE)) != 0;
    memset(f, 0, sizeof *f);
    if (a->outcome == OUTCOME_DONE && b->outcome == OUTCOME_HUNG)
        return; /* smaller steps may take longer than there is time */
    if (compare_outcomes(a, b, f)) return;
    for (int k = 0; k < a->fields && !goes; k++)
        if (strcmp(a->field[k].name, "SI") != 0) compare_field(x, t, a, b, &a->field[k], tolerance, f);
    for (int k = 0; k < a->figures; k++)
        if (of_amount(x, &a->figure[k])) compare_figure(x, t, a, b, &a->figure[k], tolerance, f);
}

/* Of the square roots of sizes the mean, squared. Beside the ends of inlets, edges of electrodes and corners of bodies
 * a field of two lattices differs by what no h lets fall: at the distance r from a jump of the speed of an inlet the
 * pressure is 1/r and differs by h/r^2, whose mean square has no order, and whose mean has h log(1/h). The mean of
 * roots is that of sqrt(h)/r, so this is of the order h, as in all of the field but near that place: h there, h^(4/3)
 * of a corner of 270 degrees. */
static double mean_of_roots(double sum, int64_t count)
{
    double mean = count ? sum / (double)count : 0.0;
    return mean * mean;
}

double compare_layer(const scene *x, const record *a, const record *b, apart *of, finding *f)
{
    double worst = 0.0;
    memset(f, 0, sizeof *f);
    of->count = 0;
    if (compare_outcomes(a, b, f)) return 0.0;
    for (int k = 0; k < a->fields && of->count < APART_FIELDS; k++) {
        const run_field *p = &a->field[k], *q = find_field(b, p->name);
        int64_t count = p->components * a->cells, known = 0;
        int missing = 0;
        if (strchr(p->name, '(') || strcmp(p->name, "SI") == 0 || !strchr(p->label, '[') || !q) continue;
        double sum = 0.0, own = 0.0;
        for (int64_t i = 0; i < count; i++) {
            if (isnan(p->data[i]) && isnan(q->data[i])) continue;
            known++;
            missing = missing || isnan(p->data[i]) || isnan(q->data[i]);
            sum += sqrt(fabs(p->data[i] - q->data[i]));
            own += sqrt(fabs(p->data[i]));
        }
        /* ions that are 1e-6 of the others are what their equilibria leave */
        double scale = fmax(1e-6 * size_of_kin(a, p), 1e9 * floor_of(x, p->label, CANCELS)), value = 0.0;
        if (!missing) scale = fmax(scale, mean_of_roots(own, known));
        if (scale > 0.0) value = missing ? 1.0 : mean_of_roots(sum, known) / scale;
        snprintf(of->name[of->count], sizeof of->name[0], "%s", p->name);
        of->value[of->count++] = value;
        worst = fmax(worst, value);
    }
    return worst;
}

/* How far a field is from that of a finer lattice, in means over the cells of a cell, over its own size. */
static double own_error(const run_field *p, const record *a, const record *fine)
{
    const run_field *q = find_field(fine, p->name);
    int64_t by = fine->n[0] / a->n[0], known = 0;
    double sum = 0.0, own = 0.0;
    for (int64_t i = 0; q && i < p->components * a->cells; i++) {
        int64_t at = i % a->cells, of = 0;
        const double *from = q->data + i / a->cells * fine->cells +
                             (at / a->n[0] * fine->n[0] + at % a->n[0]) * by;
        double mean = 0.0;
        for (int64_t n = 0; n < by * by; n++) {
            double v = from[n / by * fine->n[0] + n % by];
            if (isnan(v)) continue;
            mean += v;
            of++;
        }
        if (!of || isnan(p->data[i])) continue;
        known++;
        sum += sqrt(fabs(mean / (double)of - p->data[i]));
        own += sqrt(fabs(p->data[i]));
    }
    return own > 0.0 ? mean_of_roots(sum, known) / mean_of_roots(own, known) : 0.0;
}

/* An error of first order changes by three times of what is left of it when h is a quarter. Two lattices that differ by
 * a quarter of that are the same within what each of them is wrong by. */
#define WITHIN (0.25 / 3.0)

void compare_falls(const apart *before, const apart *now, double factor, double least, const record *a,
                   const record *fine, finding *f)
{
    for (int k = 0; k < before->count && k < now->count && !f->found; k++) {
        const run_field *own = a ? find_field(a, before->name[k]) : NULL;
        if (now->value[k] < least || now->value[k] * factor < before->value[k]) continue;
        if (own && now->value[k] < WITHIN * own_error(own, a, fine)) continue;
        f->found = 1;
        f->a = before->value[k];
        f->b = now->value[k];
        f->scale = 1.0;
        snprintf(f->kind, sizeof f->kind, "lattice");
        snprintf(f->name, sizeof f->name, "%s", before->name[k]);
    }
}
