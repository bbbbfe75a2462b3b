/* tangent: see tangent.h */
#include "react/tangent.h"
#include "chemistry/mineral_step.h"
#include "react/layer.h"
#include "react/levels.h"
#include "core/par.h"
#include "solve/gauss_jordan.h"
#include <math.h>
#include <string.h>

/* Share that a mineral leaves dissolved of what comes, at least: the derivatives have single precision. And the largest
 * one that is taken for all of it. */
#define PDI_TANGENT_LEAST 1e-7
#define PDI_TANGENT_MOST 0.99
/* What a node exchanges in a step, over what it holds, up to which each node by itself is near to the solution: the
 * square root of it is about the number of iterations. */
#define PDI_TANGENT_EXCHANGE 100.0

PDI_FN int pdi_tangent_threads(const pd_ctx *ctx, const pd_reactive *r)
{
    return pd_par_threads(ctx, (int64_t)r->grid->total * r->components.solutes * r->components.count);
}

PDI_FN void pdi_tangent_images(const pd_reactive *r, double *fields)
{
    for (int n = 0; n < r->components.solutes; n++)
        pd_ghosts_set_scalar(&r->bonds->ghosts, fields + (int64_t)n * r->grid->total);
}

PDI_FN void pdi_tangent_leave(const pd_ctx *ctx, pd_reactive *r, const double *fields, const double *wall, double *y)
{
    const pd_components *s = &r->components;
    double weight[PD_SPECIES_MAX * PD_SPECIES_MAX];
    pdi_flux_fields f;
    for (int k = 0; k < s->count; k++)
        for (int n = 0; n < s->solutes; n++) weight[k * s->solutes + n] = s->stoichiometry[k][n] / r->weight[k];
    if (r->migration.on) {
        pdi_migration_leave(ctx, &r->migration, r->c, fields, weight, y);
        return;
    }
    f.count = s->solutes;
    f.sums = s->count;
    f.ratio = r->ratio;
    f.wall = wall;
    f.c = fields;
    f.weight = weight;
    f.pass = r->pass;
    f.y = y;
    pdi_flux_apply_fields(ctx, &r->flux, &f);
}

typedef struct pdi_tangent_user {
    pd_ctx *ctx;
    pd_reactive *r;
} pdi_tangent_user;

PDI_FN void pdi_tangent_law(const pd_reactive *r, int32_t i, double *n, pd_mineral_start *start)
{
    double c[PD_SPECIES_MAX], first[PD_MINERAL_MAX];
    pd_reactive_get(r, r->begin, i, c);
    pdi_reactive_solids(r, r->solid_begin, i, n);
    pdi_mineral_begin_step(&r->components, &r->minerals, n, c, start);
    memcpy(first, n, sizeof first);
    pdi_reactive_solids(r, r->solid_start, i, n);
    for (int m = 0; m < r->minerals.count; m++)
        pdi_mineral_try_resume(start, m, first[m] + (n[m] - first[m]) / PDI_TANGENT_BEYOND, PDI_TANGENT_BEYOND, &n[m]);
    start->start_amount = n;
    start->dt = r->dt;
}

/* Where the derivatives of minerals stand in a row of `by`. */
static int pdi_tangent_place(const pd_reactive *r)
{
    const pd_components *s = &r->components;
    return s->members * pdi_components_count_columns(s) + s->kinetics * s->count;
}

PDI_FN void pdi_tangent_taken(const pd_reactive *r, const float *by, const double *total, double *taken)
{
    const pd_components *s = &r->components;
    const float *row = by + pdi_tangent_place(r);
    for (int m = 0; m < r->minerals.count; m++, row += s->count) {
        taken[m] = 0.0;
        for (int k = 0; k < s->count; k++) taken[m] += (double)row[k] * total[k];
    }
}

PDI_FN double pdi_tangent_unsure(const pd_reactive *r, int32_t i, int m, const double *size)
{
    const float *row = r->by + (int64_t)i * r->slots + pdi_tangent_place(r) + m * r->components.count;
    double sum = 0.0;
    for (int k = 0; k < r->components.count; k++) sum += fabs((double)row[k]) * size[k];
    return r->desc.tolerance * sum;
}

/* Share of a change of totals that minerals take: total loses it. */
static void pdi_tangent_fix(const pd_reactive *r, const float *by, double *total)
{
    const pd_components *s = &r->components;
    double taken[PD_MINERAL_MAX];
    pdi_tangent_taken(r, by, total, taken);
    for (int m = 0; m < r->minerals.count; m++)
        for (int k = 0; k < s->count; k++) total[k] -= r->minerals.total_content[m][k] * taken[m];
}

/* Of what comes to node i as mineral m the share p stays dissolved, and gets the absorption (1/p - 1)/dt. */
static double pdi_tangent_absorb(const pd_reactive *r, int32_t i, int m)
{
    const pd_components *s = &r->components;
    const float *row = r->by + (int64_t)i * r->slots + pdi_tangent_place(r) + m * s->count;
    double share = 1.0;
    for (int k = 0; k < s->count; k++) share -= (double)row[k] * r->minerals.total_content[m][k];
    return share < PDI_TANGENT_MOST ? (1.0 / pd_max(share, PDI_TANGENT_LEAST) - 1.0) / r->dt : 0.0;
}

static pd_status pdi_tangent_migration(pd_ctx *ctx, pd_reactive *r)
{
    pdi_migration_surface surface = {0, NULL, NULL};
    if (r->surface) {
        pdi_etch_yield(r->surface);
        surface.count = r->surface->count;
        surface.node = r->surface->node;
        surface.take = r->surface->split;
    }
    return pdi_migration_setup(ctx, &r->migration, r->c, &surface);
}

/* taken [minerals][components]: what minerals of node i take of changes of totals. */
static void pdi_tangent_minerals(const pd_reactive *r, int32_t i, const double *c, double *taken)
{
    double n[PD_MINERAL_MAX], first[PD_MINERAL_MAX];
    pd_mineral_start start;
    pdi_tangent_law(r, i, first, &start);
    pdi_reactive_solids(r, r->solid, i, n);
    pdi_mineral_step_compute_derivatives(&r->components, &r->minerals, &start, c, n, taken);
}

/* left [components]: what minerals leave of one of total k. */
static void pdi_tangent_left(const pd_reactive *r, const double *taken, int k, double *left)
{
    int count = r->components.count;
    memset(left, 0, PD_SPECIES_MAX * sizeof *left);
    left[k] = 1.0;
    for (int m = 0; m < r->minerals.count; m++)
        for (int q = 0; q < count; q++) left[q] -= r->minerals.total_content[m][q] * taken[m * count + k];
}

/* By the totals before minerals take of them, of a row by those that they leave. What is left of an ion may be next to
 * nothing of what comes: single precision has it in the product alone. */
static void pdi_tangent_before(const pd_reactive *r, const double *taken, float *row)
{
    int count = r->components.count;
    double by[PD_SPECIES_MAX], left[PD_SPECIES_MAX];
    for (int k = 0; k < count; k++) {
        pdi_tangent_left(r, taken, k, left);
        by[k] = 0.0;
        for (int q = 0; q < count; q++) by[k] += (double)row[q] * left[q];
    }
    for (int k = 0; k < count; k++) row[k] = (float)by[k];
}

/* How places follow the totals of their nodes. */
static void pdi_tangent_surface(pd_ctx *ctx, pd_reactive *r)
{
    pd_etch *metal = r->surface;
    int32_t places = r->minerals.count ? metal->count : 0;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    pdi_layer_solve(ctx, metal, -1, 1);
    PD_PARALLEL_FOR(nt)
    for (int32_t p = 0; p < places; p++) {
        double c[PD_SPECIES_MAX], taken[PD_MINERAL_MAX * PD_SPECIES_MAX];
        pd_reactive_get(r, r->c, metal->node[p], c);
        pdi_tangent_minerals(r, metal->node[p], c, taken);
        pdi_tangent_before(r, taken, metal->by + (int64_t)p * r->components.count);
        if (metal->electrode) pdi_tangent_before(r, taken, metal->flow_by + (int64_t)p * r->components.count);
    }
    if (metal->electrode) pdi_levels_derive(metal);
}

PDI_FN pd_status pdi_tangent_derive(pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r), tables = s->members * pdi_components_count_columns(s);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], slope[PD_SPECIES_MAX], one[PD_SPECIES_MAX], along[PD_SPECIES_MAX];
        double taken[PD_MINERAL_MAX * PD_SPECIES_MAX];
        float *by = r->by + (int64_t)i * r->slots, *row = by + tables;
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_components_compute_derivatives_single(s, c, by);
        if (r->minerals.count) {
            pdi_tangent_minerals(r, i, c, taken);
            for (int k = 0; k < r->minerals.count * s->count; k++) by[pdi_tangent_place(r) + k] = (float)taken[k];
        }
        for (int n = 0; n < s->kinetics; n++, row += s->count) {
            double rate = 0.0;
            pdi_components_compute_rate(s, &s->kinetic[n], c, slope, NULL);
            for (int k = 0; k < s->count; k++) {
                double sum = 0.0;
                /* of ions that reach a mineral next to nothing may stay dissolved: single precision has none of it */
                pdi_tangent_left(r, taken, k, one);
                pdi_components_apply_derivatives(s, by, one, along);
                for (int m = 0; m < s->solutes; m++) sum += slope[m] * along[m];
                row[k] = (float)sum;
                rate -= (double)row[k] * s->kinetic[n].total_change[k];
            }
            r->filter[n].absorb[i] = pd_max(rate, 0.0);
        }
        for (int n = s->kinetics; n < r->filters; n++)
            r->filter[n].absorb[i] = pdi_tangent_absorb(r, i, r->filter[n].mineral);
    }
    if (r->surface) pdi_tangent_surface(ctx, r);
    if (r->migration.on) PD_TRY(pdi_tangent_migration(ctx, r));
    for (int n = 0; n < r->filters; n++)
        PD_TRY(pdi_inverse_setup(ctx, &r->filter[n].inverse, 1.0 / r->dt, NULL, 0));
    return PD_OK;
}

/* What is spent has no equation. */
static void pdi_tangent_spend(const pd_reactive *r, double *y)
{
    int64_t size = r->components.count * (int64_t)r->grid->total;
    for (int64_t at = 0; at < size; at++)
        if (r->spent[at]) y[at] = 0.0;
}

/* With migration: the change x of totals of node i becomes that of neutral ones, and that of psi (theory: 8.12). */
static void pdi_tangent_part(const pd_reactive *r, int32_t i, double *x)
{
    const pd_components *s = &r->components;
    double c[PD_SPECIES_MAX], along[PD_SPECIES_MAX], charge = 0.0;
    if (!r->migration.on) return;
    pd_reactive_get(r, r->c, i, c);
    pdi_migration_along(&r->migration, c, along);
    for (int k = 0; k < s->count; k++) charge += r->migration.charge[s->component_solute[k]] * x[k];
    for (int k = 0; k < s->count; k++) x[k] -= along[k] * charge;
    r->migration.move[i] = charge / r->migration.size[i];
}

/* Change of the speed of metal at place p with the change x of totals (and psi) of its node, and *flow, that of its
 * electrode. */
static double pdi_tangent_metal(const pd_reactive *r, int32_t p, double *x, double *flow)
{
    const pd_etch *metal = r->surface;
    int32_t i = metal->node[p];
    pdi_tangent_part(r, i, x);
    double sum = pdi_etch_follow(metal, p, x);
    *flow = 0.0;
    if (metal->electrode)
        *flow = pdi_etch_follow_flow(metal, p, x) + (double)metal->flow_drive[p] * r->migration.move[i];
    return metal->drive ? sum + (double)metal->drive[p] * r->migration.move[i] : sum;
}

/* What places give with the change x takes what it is of the balances y. */
static void pdi_tangent_places(const pd_reactive *r, const double *x, double *y)
{
    const pd_etch *metal = r->surface;
    int count = r->components.count;
    int64_t total = r->grid->total;
    double change[PD_SPECIES_MAX], speed = 0.0, flow = 0.0;
    for (int pass = 0; pass < (metal->electrode ? 2 : 1); pass++) { /* circuits have to know all changes first */
        for (int32_t p = 0; p < metal->count; p++) {
            int32_t i = metal->node[p];
            if (pass) {
                speed = metal->side[p];
                flow = metal->side[total + p];
            } else {
                for (int k = 0; k < count; k++) change[k] = r->weight[k] * x[k * total + i];
                speed = pdi_tangent_metal(r, p, change, &flow);
            }
            if (metal->electrode && !pass) {
                metal->side[p] = speed;
                metal->side[total + p] = flow;
                continue;
            }
            for (int k = 0; k < count; k++) y[k * total + i] -= pdi_etch_gives(metal, p, k, speed, flow) / r->weight[k];
        }
        if (metal->electrode && !pass) pdi_levels_follow(metal, metal->side, metal->side + total);
    }
}

/* y = J x, in totals over weights. */
static void pdi_tangent_apply(void *user, const double *x, double *y)
{
    pdi_tangent_user *u = (pdi_tangent_user *)user;
    pd_reactive *r = u->r;
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(u->ctx, r), tables = s->members * pdi_components_count_columns(s);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double along[PD_SPECIES_MAX], c[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) along[k] = r->weight[k] * x[k * total + i]; /* 0 where it is spent */
        pdi_tangent_part(r, i, along);
        pdi_tangent_fix(r, r->by + (int64_t)i * r->slots, along);
        pdi_components_apply_derivatives(s, r->by + (int64_t)i * r->slots, along, c);
        pdi_reactive_put(r, c, i, r->move);
    }
    pdi_tangent_images(r, r->move);
    pdi_tangent_leave(u->ctx, r, r->move, r->closed, y);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        const float *row = r->by + (int64_t)i * r->slots + tables;
        double change[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) change[k] = r->weight[k] * x[k * total + i];
        pdi_tangent_part(r, i, change);
        for (int k = 0; k < s->count; k++) y[k * total + i] += change[k] / (r->weight[k] * r->dt);
        for (int n = 0; n < s->kinetics; n++, row += s->count) {
            double speed = 0.0;
            for (int k = 0; k < s->count; k++) speed += (double)row[k] * change[k];
            for (int k = 0; k < s->count; k++) y[k * total + i] -= s->kinetic[n].total_change[k] * speed / r->weight[k];
        }
    }
    if (r->surface) pdi_tangent_places(r, x, y);
    pdi_tangent_spend(r, y);
}

/* Split off what kinetic reaction n brings to rest: x loses it, part_of is its extent. */
static void pdi_tangent_split(const pd_ctx *ctx, pd_reactive *r, int n, double *x)
{
    const pd_components *s = &r->components;
    const double *gain = s->kinetic[n].total_change;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r), at = s->members * pdi_components_count_columns(s) + n * s->count;
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        const float *row = r->by + (int64_t)i * r->slots + at;
        double speed = 0.0, rate = r->filter[n].absorb[i];
        r->part_of[i] = 0.0;
        if (r->grid->kind[i] != PD_FLUID || !(rate > DBL_MIN)) continue;
        for (int k = 0; k < s->count; k++) speed += (double)row[k] * r->weight[k] * x[k * total + i];
        r->part_of[i] = -speed / rate;
        for (int k = 0; k < s->count; k++) x[k * total + i] -= gain[k] * r->part_of[i] / r->weight[k];
    }
}

/* What one of the metal of a place brings to the totals of its node, as the charge of it leaves at once. */
static void pdi_tangent_gain(const pd_reactive *r, int32_t p, double *gain)
{
    memcpy(gain, pdi_etch_of(r->surface, p)->gain, PD_SPECIES_MAX * sizeof *gain);
    pdi_tangent_part(r, r->surface->node[p], gain);
}

/* A law that is stiffer than all else that its node exchanges comes to rest by itself: x loses it, `split` is its
 * extent. */
static void pdi_tangent_split_metal(pd_reactive *r, double *x)
{
    const pd_components *s = &r->components;
    pd_etch *metal = r->surface;
    int64_t total = r->grid->total;
    for (int32_t p = 0; p < metal->count; p++) {
        int32_t i = metal->node[p];
        double own = 1.0 / r->dt + r->rates[i], rate = 0.0, change[PD_SPECIES_MAX], gain[PD_SPECIES_MAX];
        const float *by = metal->by + (int64_t)p * s->count;
        pdi_tangent_gain(r, p, gain);
        for (int k = 0; k < s->count; k++) rate -= metal->weight[p] * (double)by[k] * gain[k];
        metal->split[p] = 0.0;
        if (!(rate > own)) continue;
        for (int k = 0; k < s->count; k++) change[k] = r->weight[k] * x[k * total + i];
        pdi_tangent_part(r, i, change);
        double extent = -metal->weight[p] * pdi_etch_follow(metal, p, change) / rate;
        for (int k = 0; k < s->count; k++) x[k * total + i] -= gain[k] * extent / r->weight[k];
        metal->split[p] = extent / (rate + own);
    }
}

static void pdi_tangent_join_metal(const pd_reactive *r, double *y)
{
    const pd_etch *metal = r->surface;
    for (int32_t p = 0; p < metal->count; p++) {
        double gain[PD_SPECIES_MAX];
        pdi_tangent_gain(r, p, gain);
        for (int k = 0; k < r->components.count; k++)
            y[k * (int64_t)r->grid->total + metal->node[p]] += gain[k] * metal->split[p] / r->weight[k];
    }
}

/* Split off what minerals take up, which stays where it is: x loses it, y is what belongs to it. */
static void pdi_tangent_lay(const pd_ctx *ctx, pd_reactive *r, double *x, double *y)
{
    int64_t total = r->grid->total;
    int count = r->components.count, nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double along[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < count; k++) along[k] = r->weight[k] * x[k * total + i];
        pdi_tangent_fix(r, r->by + (int64_t)i * r->slots, along);
        for (int k = 0; k < count; k++) {
            double rest = along[k] / r->weight[k];
            y[k * total + i] += r->dt * (x[k * total + i] - rest);
            x[k * total + i] = rest;
        }
    }
}

/* Split off what comes along a mineral with a speed: x loses it, and y gets what the absorption leaves of it. */
static void pdi_tangent_split_mineral(pd_ctx *ctx, pd_reactive *r, pd_reactive_filter *filter, double *x, double *y)
{
    const double *gain = r->minerals.total_content[filter->mineral];
    int64_t total = r->grid->total;
    int count = r->components.count, nt = pdi_tangent_threads(ctx, r);
    int at = pdi_tangent_place(r) + filter->mineral * count;
    double *left = r->rates + total;
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        const float *row = r->by + (int64_t)i * r->slots + at;
        double taken = 0.0, more = filter->absorb[i] * r->dt;
        r->part_of[i] = 0.0;
        if (r->grid->kind[i] != PD_FLUID || !(more > 0.0)) continue;
        for (int k = 0; k < count; k++) taken += (double)row[k] * r->weight[k] * x[k * total + i];
        r->part_of[i] = taken * (1.0 + more) / more;
        for (int k = 0; k < count; k++) x[k * total + i] -= gain[k] * r->part_of[i] / r->weight[k];
    }
    pdi_inverse_apply(ctx, &filter->inverse, r->part_of, left);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++)
        for (int k = 0; k < count; k++)
            y[k * total + i] += gain[k] / r->weight[k] * (1.0 + filter->absorb[i] * r->dt) * left[i];
}

/* With migration: psi that drives the charge of x out, and `rest`, what that leaves of x. y: work. */
static void pdi_tangent_discharge(pd_ctx *ctx, pd_reactive *r, const double *x, double *rest, double *y)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double charge = 0.0;
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++)
            charge += r->migration.charge[s->component_solute[k]] * r->weight[k] * x[k * total + i];
        r->migration.current[i] = charge;
    }
    pdi_migration_apply(ctx, &r->migration, r->migration.current, r->migration.move);
    pdi_tangent_leave(ctx, r, NULL, r->closed, y);
    for (int k = 0; k < s->count; k++) {
        PD_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < (int32_t)total; i++)
            if (r->grid->kind[i] == PD_FLUID) rest[k * total + i] = x[k * total + i] - y[k * total + i];
    }
}

/* The totals of y become neutral, and y gets the psi that drives the charge of x out beside the current of those. */
static void pdi_tangent_recharge(pd_ctx *ctx, pd_reactive *r, double *y)
{
    const pd_components *s = &r->components;
    pd_migration *m = &r->migration;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double x[PD_SPECIES_MAX], c[PD_SPECIES_MAX], sum = 0.0;
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) x[k] = r->weight[k] * y[k * total + i];
        pdi_tangent_part(r, i, x);
        for (int k = 0; k < s->count; k++) y[k * total + i] = x[k] / r->weight[k];
        pdi_tangent_fix(r, r->by + (int64_t)i * r->slots, x);
        pdi_components_apply_derivatives(s, r->by + (int64_t)i * r->slots, x, c);
        for (int n = 0; n < s->solutes; n++) sum += m->charge[n] * r->ratio[n] * c[n];
        m->move[i] = sum;
    }
    pdi_migration_spread(ctx, m, m->move, r->part_of);
    for (int32_t i = 0; i < (int32_t)total; i++)
        if (r->grid->kind[i] == PD_FLUID) m->current[i] -= r->part_of[i];
    pdi_migration_apply(ctx, m, m->current, m->move);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], along[PD_SPECIES_MAX], lift = m->size[i] * m->move[i];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_migration_along(m, c, along);
        for (int k = 0; k < s->count; k++) y[k * total + i] += along[k] * lift / r->weight[k];
    }
}

/* The balances of one node by its own totals: row k of column n at matrix[k (count + 1) + n]. What it gets from others
 * is not in it. */
static void pdi_tangent_block(const pd_reactive *r, int32_t i, double *matrix)
{
    const pd_components *s = &r->components;
    const float *by = r->by + (int64_t)i * r->slots, *rows = by + s->members * pdi_components_count_columns(s);
    int count = s->count;
    for (int n = 0; n < count; n++) {
        double along[PD_SPECIES_MAX] = {0.0}, c[PD_SPECIES_MAX];
        along[n] = r->weight[n];
        pdi_tangent_fix(r, by, along);
        pdi_components_apply_derivatives(s, by, along, c);
        for (int k = 0; k < count; k++) {
            double sum = k == n ? r->weight[k] / r->dt : 0.0;
            for (int m = 0; m < s->solutes; m++) sum += s->stoichiometry[k][m] * r->rates[i] * r->ratio[m] * c[m];
            for (int q = 0; q < s->kinetics; q++)
                sum -= s->kinetic[q].total_change[k] * (double)rows[q * count + n] * r->weight[n];
            matrix[k * (count + 1) + n] = sum / r->weight[k];
        }
    }
}

/* y near J^-1 x: each node by itself, a law that is stiffer than its node before. */
static void pdi_tangent_precondition_nodes(void *user, const double *x, double *y)
{
    pdi_tangent_user *u = (pdi_tangent_user *)user;
    pd_reactive *r = u->r;
    int64_t total = r->grid->total;
    int count = r->components.count, nt = pdi_tangent_threads(u->ctx, r);
    double *rest = r->move;
    (void)nt;
    pdi_par_copy(u->ctx, count * total, x, rest);
    if (r->surface) pdi_tangent_split_metal(r, rest);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double matrix[PD_SPECIES_MAX * (PD_SPECIES_MAX + 1)]; /* and the right-hand side */
        int fluid = r->grid->kind[i] == PD_FLUID;
        if (fluid) {
            pdi_tangent_block(r, i, matrix);
            for (int k = 0; k < count; k++) matrix[k * (count + 1) + count] = rest[k * total + i];
            pdi_gauss_jordan_solve(count, count + 1, count + 1, matrix);
        }
        for (int k = 0; k < count; k++) y[k * total + i] = fluid ? matrix[k * (count + 1) + count] : 0.0;
    }
    if (r->surface) pdi_tangent_join_metal(r, y);
    pdi_tangent_spend(r, y);
}

/* y near J^-1 x: each component by itself with the mean diffusivity; what kinetic reactions bring to rest, with their
 * rate; the charge, by the conductivity. */
static void pdi_tangent_precondition(void *user, const double *x, double *y)
{
    pdi_tangent_user *u = (pdi_tangent_user *)user;
    pd_reactive *r = u->r;
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double *rest = r->move;
    if (!s->kinetics && !r->surface && !r->minerals.count && !r->migration.on) {
        for (int k = 0; k < s->count; k++) pdi_inverse_apply(u->ctx, &r->inverse, x + k * total, y + k * total);
        pdi_tangent_spend(r, y);
        return;
    }
    if (r->migration.on) pdi_tangent_discharge(u->ctx, r, x, rest, y);
    else pdi_par_copy(u->ctx, s->count * total, x, rest);
    pdi_par_zero(u->ctx, s->count * total, y);
    if (r->surface) pdi_tangent_split_metal(r, rest);
    for (int n = s->kinetics; n < r->filters; n++) pdi_tangent_split_mineral(u->ctx, r, &r->filter[n], rest, y);
    if (r->minerals.count) pdi_tangent_lay(u->ctx, r, rest, y);
    for (int n = 0; n < s->kinetics; n++) {
        pdi_tangent_split(u->ctx, r, n, rest);
        pdi_inverse_apply(u->ctx, &r->filter[n].inverse, r->part_of, r->rates + total);
        for (int k = 0; k < s->count; k++)
            pdi_par_axpy(u->ctx, total, s->kinetic[n].total_change[k] / r->weight[k], r->rates + total, y + k * total);
    }
    for (int k = 0; k < s->count; k++) {
        pdi_inverse_apply(u->ctx, &r->inverse, rest + k * total, r->part_of);
        pdi_par_axpy(u->ctx, total, r->migration.on ? r->migration.pace[k] : 1.0, r->part_of, y + k * total);
    }
    if (r->surface) pdi_tangent_join_metal(r, y);
    if (r->migration.on) pdi_tangent_recharge(u->ctx, r, y);
    pdi_tangent_spend(r, y);
}

/* With migration: what Newton's method moves, as totals and as psi. */
static void pdi_tangent_resolve(pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double *delta = r->work + s->count * total, x[PD_SPECIES_MAX];
    for (int32_t i = 0; i < (int32_t)total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) x[k] = r->weight[k] * delta[k * total + i];
        pdi_tangent_part(r, i, x);
        for (int k = 0; k < s->count; k++) delta[k * total + i] = x[k] / r->weight[k];
    }
}

/* 1: nodes by themselves are nearer to J^-1 than components by themselves: fast reactions and minerals tie the
 * components of a node, and a step exchanges little beside that. With migration psi ties the nodes. */
static int pdi_tangent_by_nodes(const pd_reactive *r)
{
    double rate = 0.0, ratio = 0.0;
    if (!r->components.kinetics || !r->minerals.count || r->migration.on) return 0;
    for (int32_t i = 0; i < (int32_t)r->grid->total; i++)
        if (r->grid->kind[i] == PD_FLUID) rate = pd_max(rate, r->rates[i]);
    for (int n = 0; n < r->components.solutes; n++) ratio = pd_max(ratio, r->ratio[n]);
    return ratio * rate * r->dt <= PDI_TANGENT_EXCHANGE;
}

PDI_FN pd_status pdi_tangent_direction(pd_ctx *ctx, pd_reactive *r, double share, double goal, int *iterations)
{
    pdi_tangent_user user;
    pd_krylov_result linear;
    pd_arena *arena = pdi_reactive_arena(r);
    pd_apply_fn near = pdi_tangent_by_nodes(r) ? pdi_tangent_precondition_nodes : pdi_tangent_precondition;
    user.ctx = ctx;
    user.r = r;
    r->krylov.desc.rtol = share;
    r->krylov.desc.atol = goal;
    pdi_tangent_spend(r, r->work);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_krylov_list, &r->krylov));
    pd_status status = pd_krylov_solve(ctx, &r->krylov, pdi_tangent_apply, near, &user, r->work,
                                       r->work + r->components.count * (int64_t)r->grid->total, &linear);
    *iterations += linear.iterations;
    if (r->migration.on) pdi_tangent_resolve(r);
    return pdi_arena_release(ctx, arena, pdi_krylov_list, &r->krylov, status);
}
