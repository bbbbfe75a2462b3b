/* reaction: species that diffuse and react against closed forms: fronts, a layer that takes up, water, equilibrium that
 * is kept, metal under a law in pH. Included by cases.h alone. */
#ifndef VAL_REACTION_H
#define VAL_REACTION_H
#include "case.h"

/* What the parts build on a lab. */
typedef struct reaction_lab {
    pd_species species[PD_SPECIES_MAX];
    pd_reaction reaction[PD_REACTION_MAX];
    int count, reactions;
    pd_reactive reactive;
    pd_reactive_result result;
} reaction_lab;

static pd_status reaction_species(pd_ctx *ctx, reaction_lab *r, const char *name, const char *formula, double d)
{
    pd_species_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.name = name;
    desc.formula = formula;
    desc.diffusivity = d;
    return pd_species_read(ctx, &desc, &r->species[r->count++]);
}

/* forward 0: in equilibrium. */
static pd_status reaction_of(pd_ctx *ctx, reaction_lab *r, const char *text, double log10_k, double forward,
                             const char *unit)
{
    pd_reaction_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.k = log10_k;
    desc.k_unit = "log10";
    desc.forward = forward;
    desc.forward_unit = unit;
    return pd_reaction_read(ctx, &desc, r->species, r->count, &r->reaction[r->reactions++]);
}

/* A strip of n cells of h along axis 0, four wide, between mirrors; sides across are closed. */
static pd_status reaction_build(val_job *job, reaction_lab *r, int n, double h, pd_reactive_desc *d)
{
    val_lab *lab = job->lab;
    lab_box(lab, h, job->level.m, 0.0, 4.0 * h);
    lab->grid_desc.hi[0] = n * h;
    for (int e = 1; e < PD_DIM; e++) lab->grid_desc.side[2 * e] = lab->grid_desc.side[2 * e + 1] = PD_SIDE_MIRROR;
    PD_TRY(lab_build(job->ctx, lab, VAL_LATTICE));
    job->out->h = h;
    d->species = r->species;
    d->count = r->count;
    d->reactions = r->reaction;
    d->reaction_count = r->reactions;
    d->temperature = 298.15;
    return pd_reactive_build(job->ctx, &lab->grid, &lab->bonds, NULL, d, &r->reactive);
}

static pd_status reaction_step(val_job *job, reaction_lab *r, double dt)
{
    PD_TRY(pd_reactive_step(job->ctx, &r->reactive, dt, &r->result));
    job->out->steps++;
    return PD_OK;
}

/* Largest imbalance of elements and charge [-]. */
static double reaction_imbalance(val_job *job, const reaction_lab *r)
{
    double worst = 0.0;
    for (int row = 0; row < r->reactive.rows; row++) {
        pd_reactive_balance b;
        pd_reactive_balance_of(job->ctx, &r->reactive, row, &b);
        worst = fmax(worst, b.relative);
    }
    return worst;
}

/* ---- fronts ---- */

/* a (x < 0) and b (x > 0), a + n b = product: concentrations [mol/m3], diffusivities [m2/s]. The front lies at
 * 2 s sqrt(t), the product is q sqrt(t): s [m/s^0.5], q [mol/m2/s^0.5]. */
static const struct reaction_couple {
    double a, b, da, db, n, s, q;
} reaction_couples[] = {{300.0, 100.0, 1e-9, 1e-9, 1.0, 1.508205e-5, 5.684560e-3},
                        {100.0, 100.0, 9.31e-9, 5.27e-9, 1.0, 1.055205e-5, 9.580556e-3},
                        {100.0, 100.0, 0.705e-9, 5.27e-9, 2.0, -5.612062e-6, 3.745262e-3},
                        {10.0, 100.0, 0.705e-9, 5.27e-9, 2.0, -5.758053e-5, 1.256168e-3}};

static pd_status reaction_front_march(val_job *job, reaction_lab *r, double half)
{
    const struct reaction_couple *c = &reaction_couples[(int)job->level.p - 1];
    double time = 0.0, end = 100.0, x[PD_DIM];
    double *a = pd_reactive_field(&r->reactive, 0), *b = pd_reactive_field(&r->reactive, 1);
    for (int32_t i = 0; i < job->lab->grid.total; i++) {
        if (job->lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&job->lab->grid, i, x);
        a[i] = x[0] < half ? c->a : 0.0;
        b[i] = x[0] < half ? 0.0 : c->b;
    }
    PD_TRY(pd_reactive_begin(job->ctx, &r->reactive));
    for (double dt = 1e-2; time < end; dt = 0.04 * time) {
        dt = fmin(dt, end - time);
        PD_TRY(reaction_step(job, r, dt));
        time = end - time - dt < 1e-9 ? end : time + dt;
    }
    return PD_OK;
}

/* Place of the front at 100 s from where it began, relative, and the product. */
static pd_status reaction_front_solve(val_job *job, reaction_lab *r)
{
    const struct reaction_couple *c = &reaction_couples[(int)job->level.p - 1];
    double initial[3] = {0.0, 0.0, 0.0}, half = 4.0 * sqrt(fmax(c->da, c->db) * 100.0), h = 2.0 * half / job->level.n;
    double where = 0.0, sum = 0.0, before = 0.0, x[PD_DIM];
    int at[3] = {0, 0, 0};
    pd_reactive_desc d;
    memset(&d, 0, sizeof d);
    PD_TRY(reaction_species(job->ctx, r, "Aa", "Na", c->da));
    PD_TRY(reaction_species(job->ctx, r, "Bb", "K", c->db));
    PD_TRY(reaction_species(job->ctx, r, "Pp", c->n > 1.5 ? "NaK2" : "NaK", 1e-9));
    PD_TRY(reaction_of(job->ctx, r, c->n > 1.5 ? "Aa + 2 Bb = Pp" : "Aa + Bb = Pp", 30.0, 0.0, NULL));
    d.initial = initial;
    d.order = 2;
    PD_TRY(reaction_build(job, r, job->level.n, h, &d));
    PD_TRY(reaction_front_march(job, r, half));
    for (at[0] = 0; at[0] < job->level.n; at[0]++) {
        int32_t i = pd_grid_node(&job->lab->grid, at);
        double u = c->n * c->da * pd_reactive_field(&r->reactive, 0)[i];
        u -= c->db * pd_reactive_field(&r->reactive, 1)[i]; /* smooth across the front */
        pd_grid_position(&job->lab->grid, i, x);
        if (at[0] && before > 0.0 && u <= 0.0) where = x[0] - half - h * (1.0 - before / (before - u));
        before = u;
        sum += pd_reactive_field(&r->reactive, 2)[i] * h;
    }
    job->out->err[0] = fabs(where / (20.0 * c->s) - 1.0);
    job->out->err[1] = fabs(sum / (10.0 * c->q) - 1.0);
    job->out->err[2] = reaction_imbalance(job, r);
    return PD_OK;
}

/* ---- a layer that takes up, water ---- */

static double reaction_left(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-7 ? 1.0 : (double)NAN;
}

/* A sink of first order behind a wall that holds 1, in one step: c = cosh((L - x)/l)/cosh(L/l), l = 316 um. */
static pd_status reaction_sink_solve(val_job *job, reaction_lab *r)
{
    double initial[2] = {0.0, 0.0}, wall[2] = {1.0, 0.0}, h = 1e-3 / job->level.n, l = sqrt(1e-7), x[PD_DIM];
    pd_reactive_desc d;
    pd_reactive_balance b;
    memset(&d, 0, sizeof d);
    PD_TRY(reaction_species(job->ctx, r, "Aa", "Na", 1e-9));
    PD_TRY(reaction_species(job->ctx, r, "Bb", "Na", 1e-9));
    PD_TRY(reaction_of(job->ctx, r, "Aa = Bb", 300.0, 1e-2, "1/s"));
    r->reaction[0].backward = 0.0;
    d.initial = initial;
    d.wall = wall;
    d.held = reaction_left;
    PD_TRY(reaction_build(job, r, job->level.n, h, &d));
    PD_TRY(reaction_step(job, r, 1e12));
    for (int32_t i = 0; i < job->lab->grid.total; i++) {
        if (job->lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&job->lab->grid, i, x);
        double c = pd_reactive_field(&r->reactive, 0)[i];
        job->out->err[0] = fmax(job->out->err[0], fabs(c - cosh((1e-3 - x[0]) / l) / cosh(1e-3 / l)));
    }
    pd_reactive_balance_of(job->ctx, &r->reactive, 0, &b);
    double flux = b.in / 1e12 / pow(4.0 * h, PD_DIM - 1);
    job->out->err[1] = fabs(flux / (sqrt(1e-9 * 1e-2) * tanh(1e-3 / l)) - 1.0);
    return PD_OK;
}

/* Water that is far from equilibrium, at finite rates that take 36 us: a step of 36 s, in which 1 mol/m3 reacts, and
 * one in equilibrium; the pH then. */
static pd_status reaction_water_solve(val_job *job, reaction_lab *r)
{
    double initial[3] = {55344.0, 1.0, 3.0};
    pd_reactive_desc d;
    memset(&d, 0, sizeof d);
    PD_TRY(reaction_species(job->ctx, r, "H2O", NULL, 0.0));
    PD_TRY(reaction_species(job->ctx, r, "H+", NULL, 9.31e-9));
    PD_TRY(reaction_species(job->ctx, r, "OH-", NULL, 5.27e-9));
    PD_TRY(reaction_of(job->ctx, r, "H+ + OH- = H2O", 14.0, 1.4e11, "L/mol/s"));
    d.initial = initial;
    PD_TRY(reaction_build(job, r, job->level.n, 1e-5, &d));
    for (int k = 0; k < 2; k++) PD_TRY(reaction_step(job, r, 36.0));
    for (int32_t i = 0; i < job->lab->grid.total; i++) /* 2 mol/m3 of OH- are left */
        if (job->lab->grid.kind[i] == PD_FLUID)
            job->out->err[0] = fmax(job->out->err[0], fabs(pd_reactive_ph(&r->reactive, i) - (11.0 + log10(2.0))));
    job->out->err[1] = reaction_imbalance(job, r);
    return PD_OK;
}

/* ---- metal under a law in pH ---- */

/* Speed [m/s] of the law. */
static double reaction_law(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    const double *power = (const double *)user;
    (void)node;
    (void)c;
    (void)phi;
    (void)t;
    return 3e-9 * pow(10.0, *power * (7.0 - ph));
}

/* The same where base diffuses through 1 mm of saline of pH 7: D_OH OH - D_H H is linear. */
static double reaction_law_exact(double power)
{
    double low = 0.0, high = 3e-9;
    for (int k = 0; k < 200; k++) {
        double v = 0.5 * (low + high), u = (5.27e-9 - 9.31e-9) * 1e-4 + 2.0 * 7e4 * v * 1e-3;
        double oh = (u + sqrt(u * u + 4.0 * 5.27e-9 * 9.31e-9 * 1e-8)) / (2.0 * 5.27e-9);
        if (reaction_law(&power, 0, NULL, 11.0 + log10(oh), 0.0, 0.0) > v) low = v;
        else high = v;
    }
    return high;
}

static double reaction_right(void *user, const double *x)
{
    (void)user;
    return x[0] > 1e-3 - 1e-7 ? 1.0 : (double)NAN;
}

/* One step of 1e12 s from neutral saline. */
static pd_status reaction_metal_solve(val_job *job, reaction_lab *r)
{
    double saline[6] = {55344.0, 1e-4, 1e-4, 145.0, 145.0, 0.0}, shed[6] = {0.0, 0.0, 2.0, 0.0, 0.0, 1.0};
    double power = job->level.p, h = 1e-3 / job->level.n, speed = 0.0, x[PD_DIM];
    static const char *const names[] = {"H2O", "H+", "OH-", "Na+", "Cl-", "Mg2+"};
    static const double ds[] = {0.0, 9.31e-9, 5.27e-9, 1.33e-9, 2.03e-9, 0.7e-9};
    pd_reactive_desc d;
    pd_etch_desc e;
    pd_etch etch;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    for (int k = 0; k < 6; k++) PD_TRY(reaction_species(job->ctx, r, names[k], NULL, ds[k]));
    PD_TRY(reaction_of(job->ctx, r, "H2O = H+ + OH-", -14.0, 0.0, NULL));
    d.initial = d.wall = saline;
    d.held = reaction_right;
    PD_TRY(reaction_build(job, r, job->level.n, h, &d));
    e.law = reaction_law;
    e.user = &power;
    e.shed = shed;
    e.reads_ph = 1;
    PD_TRY(pd_etch_build(job->ctx, &r->reactive, &e, &etch));
    for (int32_t i = 0; i < job->lab->grid.total; i++) {
        if (job->lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&job->lab->grid, i, x);
        if (x[0] < h) pd_etch_put(&etch, i, 7e4 / h, 7e4 * 0.5 * h / r->reactive.diffusion.desc.diffusivity);
    }
    pd_status status = reaction_step(job, r, 1e12);
    for (int32_t p = 0; p < etch.count; p++) speed = fmax(speed, etch.speed[etch.node[p]]);
    job->out->err[0] = fabs(speed / reaction_law_exact(power) - 1.0);
    job->out->err[1] = reaction_imbalance(job, r);
    pd_etch_free(job->ctx, &etch);
    return status;
}

/* ---- parts ---- */

static pd_status reaction_run(val_job *job, pd_status (*solve)(val_job *, reaction_lab *))
{
    static reaction_lab r;
    memset(&r, 0, sizeof r);
    pd_status status = solve(job, &r);
    pd_reactive_free(job->ctx, &r.reactive);
    return status;
}

static pd_status reaction_front_run(val_job *job) { return reaction_run(job, reaction_front_solve); }
static pd_status reaction_sink_run(val_job *job) { return reaction_run(job, reaction_sink_solve); }
static pd_status reaction_water_run(val_job *job) { return reaction_run(job, reaction_water_solve); }
static pd_status reaction_metal_run(val_job *job) { return reaction_run(job, reaction_metal_solve); }

#if PD_DIM == 1
#define REACTION_FRONTS {{240, 2.0, 1.0}, {240, 2.0, 2.0}, {360, 2.0, 3.0}, {240, 2.0, 4.0}}, 4, 4
#else
#define REACTION_FRONTS {{120, 2.0, 1.0}, {120, 2.0, 4.0}}, 2, 1
#endif

static const val_part reaction_front_part = {
    "fronts", "instantaneous fronts A + n B", "couple", VAL_BY_P, "couple", 0.0,
    {{"err_place", "place of the front"}, {"err_product", "product"}, {"imbalance", "elements and charge"}}, 3,
    {{0, 0.005, 0.0, 0, VAL_GOAL}, {1, 0.01, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL}}, 3,
    REACTION_FRONTS, reaction_front_run, NULL};

static const val_part reaction_sink_part = {
    "sink", "layer that takes up by first order", "cells", VAL_BY_N, NULL, 2.0,
    {{"err_field", "concentration over that at the wall"}, {"err_flux", "flux"}}, 2,
    {{0, 0.001, 0.0, 0, VAL_GOAL}, {1, 0.001, 0.0, 0, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}}, 3,
    {{50, 2.0, 0.0}, {100, 2.0, 0.0}, {200, 2.0, 0.0}}, 3, PD_DIM == 1 ? 3 : 2, reaction_sink_run, NULL};

static const val_part reaction_water_part = {
    "water", "relaxation of water in steps of a million times its time", "cells", VAL_BY_N, NULL, 0.0,
    {{"err_ph", "pH"}, {"imbalance", "elements and charge"}}, 2,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}}, 2,
    {{20, 2.0, 0.0}}, 1, 1, reaction_water_run, NULL};

static const val_part reaction_metal_part = {
    "metal", "metal under a law 10^(p (7 - pH)) through stagnant saline", "p", VAL_BY_P, "p", 0.0,
    {{"err_speed", "speed"}, {"imbalance", "elements and charge"}}, 2,
    {{0, 1e-6, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}}, 2,
    {{20, 1.0, 0.3}, {20, 1.0, 1.0}, {20, 1.0, 4.0}}, 3, 3, reaction_metal_run, NULL};

static const val_part *const reaction_parts[] = {&reaction_front_part, &reaction_sink_part, &reaction_water_part,
                                                 &reaction_metal_part};

static const val_case reaction_case = {
    "reaction", "species that diffuse and react",
    "Fronts of two species that consume each other at once, of equal and unequal diffusivities, at 100 s; a layer that "
    "takes up what diffuses in by first order; water out of equilibrium at its rates of 1.4e11 L/mol/s; and metal that "
    "dissolves by a law in the pH at its surface through 1 mm of stagnant saline, in one step of 1e12 s.",
    "Reactions that are split from diffusion, fronts that stick to nodes, totals that drift, stiff steps that ring, a "
    "law that is asked once a step.",
    "similarity solutions of instantaneous reactions (Galfi and Racz 1988; Koza 1996), hyperbolic functions, the "
    "balance of the fluxes of H+ and OH-",
    reaction_parts, 4};

#endif
