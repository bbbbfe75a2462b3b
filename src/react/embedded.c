/* embedded: see embedded.h */
#include "react/embedded.h"
#include "chemistry/mineral_step.h"
#include "react/extents.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* An estimate above this is damped, and what the linear solver may leave of that. */
#define PDI_EMBEDDED_SMALL 1e-5
#define PDI_EMBEDDED_DAMPED 0.1
/* An error that is more than this share of that of a longer step does not fall with it, and after so many of these a
 * component is taken to come from nothing. */
#define PDI_EMBEDDED_FALLS 0.9
#define PDI_EMBEDDED_STAYS 2

/* A share that grows by `change`: at most half of what is open is filled, and half of what fills it goes. */
static double pdi_embedded_filled(double film, double change)
{
    return film + pd_min(pd_max(change, -0.5 * film), 0.5 * (1.0 - film));
}

/* What minerals leave open for diffusion in the middle of a step of dt [s]: as it was, or (was = 0) as far as the last
 * one tells. */
PDI_FN void pdi_embedded_open(pd_reactive *r, double dt, int was)
{
    for (int32_t i = 0; i < r->grid->total; i++) {
        double film = r->filled[i];
        if (was && r->grid->kind[i] == PD_FLUID) film = 0.5 * (film + pd_reactive_film(r, i));
        else if (film > 0.0) film = pdi_embedded_filled(film, 0.5 * dt * r->narrow[i]);
        r->pass[i] = 1.0 - film;
        if (r->filled[i] > 0.0) r->pass[i] /= r->desc.tortuosity; /* where a film begins, from the next step on */
    }
    pd_ghosts_set_scalar(&r->bonds->ghosts, r->pass);
    r->migration.pass = r->pass;
}

/* By how much the slopes of both stages differ, times first and second of the times of stages, over its weight and the
 * time of the second one goes to `work`, that of minerals to `solid_slope`, and what was in `work` to `slope`. size
 * [components]: largest sum of terms. */
static void pdi_embedded_differ(pd_reactive *r, double first, double second, double *size)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_components_compute_totals(s, c, sum);
        for (int m = 0; m < r->minerals.count; m++)
            r->solid_slope[m * total + i] = first * r->solid_slope[m * total + i] -
                                            second * (r->solid[m * total + i] - r->solid_start[m * total + i]);
        for (int k = 0; k < s->count; k++) {
            int64_t at = k * total + i;
            double terms = 0.0, undone = r->dt * r->weight[k] * r->work[at];
            double by = first * r->slope[at] - second * (sum[k] - r->total[at] + undone);
            for (int n = 0; n < s->solutes; n++) terms += fabs(s->stoichiometry[k][n]) * c[n];
            for (int m = 0; m < r->minerals.count; m++)
                by += r->minerals.total_content[m][k] * r->solid_slope[m * total + i];
            size[k] = pd_max(size[k], terms);
            r->slope[at] = r->work[at];
            r->work[at] = by / (r->dt * r->weight[k]);
        }
    }
}

/* What has passed otherwise than through the pores of the middle of the step of dt [s] joins the differences. */
static void pdi_embedded_pored(const pd_ctx *ctx, pd_reactive *r, double dt)
{
    int64_t size = r->components.count * (int64_t)r->grid->total;
    double *now = r->work + size;
    pdi_tangent_images(r, r->c);
    pdi_embedded_open(r, dt, 1);
    pdi_tangent_leave(ctx, r, r->c, r->wall, now);
    pdi_embedded_open(r, dt, 0);
    pdi_tangent_leave(ctx, r, r->c, r->wall, r->move);
    for (int64_t at = 0; at < size; at++) {
        if (r->grid->kind[at % r->grid->total] != PD_FLUID) continue;
        r->work[at] += copysign((now[at] - r->move[at]) * (dt / r->dt), r->work[at]);
    }
}

/* Error of the surface of mineral m at node i as a share of it, where it grows with the amount: it multiplies later
 * growth. follows: derivatives say what the solver leaves of the amount by its tolerance, which is no error. */
static double pdi_embedded_spread(const pd_reactive *r, int32_t i, int m, double change, int follows,
                                  const double *size)
{
    int64_t at = m * (int64_t)r->grid->total + i;
    double reach = r->solid[at] + r->minerals.mineral[m].rate / r->minerals.mineral[m].surface_rate;
    if (!(r->solid[at] > r->solid_begin[at])) return 0.0;
    if (follows) reach += pdi_tangent_unsure(r, i, m, size) / PDI_EMBEDDED_SMALL;
    return fabs(change) / reach;
}

/* Largest of the differences `by` times `field` of totals over sizes, but for what minerals have of them; and of those
 * over their largest amount and what their components would give. follows: minerals follow totals. */
static double pdi_embedded_largest(const pd_reactive *r, const double *field, double by, int follows,
                                   const double *size)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double off[PD_SPECIES_MAX] = {0.0}, solid[PD_MINERAL_MAX] = {0.0}, most[PD_MINERAL_MAX] = {0.0}, worst = 0.0;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double x[PD_SPECIES_MAX], taken[PD_MINERAL_MAX] = {0.0};
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) x[k] = r->weight[k] * by * field[k * total + i];
        if (follows) pdi_tangent_taken(r, r->by + (int64_t)i * r->slots, x, taken);
        for (int m = 0; m < r->minerals.count; m++) {
            double change = taken[m] + r->solid_slope[m * total + i];
            if (r->minerals.mineral[m].surface_rate > 0.0)
                worst = pd_max(worst, pdi_embedded_spread(r, i, m, change, follows, size));
            for (int k = 0; k < s->count; k++) x[k] -= r->minerals.total_content[m][k] * change;
            solid[m] = pd_max(solid[m], fabs(change));
            most[m] = pd_max(most[m], r->solid[m * total + i]);
        }
        for (int k = 0; k < s->count; k++) off[k] = pd_max(off[k], fabs(x[k]));
    }
    for (int k = 0; k < s->count; k++)
        if (size[k] > 0.0) worst = pd_max(worst, off[k] / size[k]);
    for (int m = 0; m < r->minerals.count; m++) {
        double least = HUGE_VAL;
        for (int k = 0; k < s->count; k++)
            if (r->minerals.total_content[m][k] != 0.0)
                least = pd_min(least, size[k] / fabs(r->minerals.total_content[m][k]));
        if (solid[m] > 0.0) worst = pd_max(worst, solid[m] / (most[m] + least));
    }
    return worst;
}

/* Where surfaces grow with amounts, a law that holds little at the start of a step may hold all at its end: off gets
 * what the laws of the start leave, where that is more. */
static void pdi_embedded_damp_early(const pd_reactive *r, int32_t i, double *off)
{
    double c[PD_SPECIES_MAX], n[PD_MINERAL_MAX], early[PD_MINERAL_MAX];
    pd_mineral_start start;
    int spreads = 0;
    for (int m = 0; m < r->minerals.count; m++) spreads |= r->minerals.mineral[m].surface_rate > 0.0;
    if (!spreads) return;
    pd_reactive_get(r, r->begin, i, c);
    pdi_reactive_solids(r, r->solid_begin, i, n);
    pdi_reactive_solids(r, r->solid_slope, i, early);
    pdi_mineral_begin_step(&r->components, &r->minerals, n, c, &start);
    start.start_amount = n;
    start.dt = r->dt;
    pdi_mineral_step_solve_linear_response(&r->components, &r->minerals, &start, c, n, early);
    for (int m = 0; m < r->minerals.count; m++)
        if (fabs(early[m]) > fabs(off[m])) off[m] = early[m];
}

/* Differences of minerals become what their laws leave of them, and the totals get what leaves or reacts otherwise by
 * that. */
static void pdi_embedded_damp_solids(pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total, size = s->count * total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], x[PD_SPECIES_MAX], left[PD_SPECIES_MAX], lack[PD_SPECIES_MAX];
        double n[PD_MINERAL_MAX], off[PD_MINERAL_MAX], first[PD_MINERAL_MAX];
        pd_mineral_start start;
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_tangent_law(r, i, first, &start);
        pdi_reactive_solids(r, r->solid, i, n);
        pdi_reactive_solids(r, r->solid_slope, i, off);
        pdi_mineral_step_solve_linear_response(s, &r->minerals, &start, c, n, off);
        pdi_embedded_damp_early(r, i, off);
        for (int m = 0; m < r->minerals.count; m++) r->solid_slope[m * total + i] = off[m];
        pdi_extents_relax(r, i, c, off, x, left, lack);
        for (int k = 0; k < s->count; k++)
            if (!r->spent[k * total + i]) r->work[k * total + i] += lack[k] / r->weight[k];
        for (int m = 0; m < s->solutes; m++) left[m] = -left[m];
        pdi_reactive_put(r, left, i, r->move);
    }
    pdi_tangent_images(r, r->move);
    if (r->migration.on) pdi_par_zero(ctx, total, r->migration.move);
    pdi_tangent_leave(ctx, r, r->move, r->closed, r->work + size);
    for (int64_t at = 0; at < size; at++)
        if (r->grid->kind[at % total] == PD_FLUID && !r->spent[at]) r->work[at] += r->work[size + at];
}

/* The totals by which the matrix answers get those that nodes have found by themselves. */
static void pdi_embedded_relaxed(const pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double *found = r->work + s->count * total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], x[PD_SPECIES_MAX], left[PD_SPECIES_MAX], lack[PD_SPECIES_MAX];
        double off[PD_MINERAL_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_reactive_solids(r, r->solid_slope, i, off);
        pdi_extents_relax(r, i, c, off, x, left, lack);
        for (int k = 0; k < s->count; k++) found[k * total + i] += x[k] / r->weight[k];
    }
}

/* The estimate with the differences that the matrix of the stage leaves, where that is less: beside much solid the
 * solver's tolerance is rough. PD_NOT_CONVERGED: they were not found. */
static pd_status pdi_embedded_damp(pd_ctx *ctx, pd_reactive *r, const double *size, double *error, int *krylov)
{
    int64_t count = r->components.count * (int64_t)r->grid->total;
    double spent = 0.0;
    PD_TRY(pdi_tangent_derive(ctx, r));
    if (r->minerals.count) pdi_embedded_damp_solids(ctx, r);
    for (int64_t at = 0; at < count; at++) { /* the solver leaves out what has no equation */
        int64_t k = at / r->grid->total;
        if (r->spent[at] && size[k] > 0.0) spent = pd_max(spent, r->dt * r->weight[k] * fabs(r->work[at]) / size[k]);
    }
    pd_status status = pdi_tangent_direction(ctx, r, PDI_EMBEDDED_DAMPED, 0.0, krylov);
    if (status == PD_ERR_DIVERGED) return PD_NOT_CONVERGED;
    if (status == PD_OK && r->minerals.count && r->components.kinetics) pdi_embedded_relaxed(ctx, r);
    if (status == PD_OK)
        *error = pd_min(*error, pd_max(spent, pdi_embedded_largest(r, r->work + count, 1.0,
                                                                            r->minerals.count > 0, size)));
    return status;
}

/* 1: no node had any of component k before the step. */
static int pdi_embedded_new(const pd_reactive *r, int k)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < (int32_t)total; i++)
        for (int n = 0; n < s->solutes && r->grid->kind[i] == PD_FLUID; n++)
            if (s->stoichiometry[k][n] != 0.0 && r->begin[n * total + i] > 0.0) return 0;
    return 1;
}

/* Of a component that comes from nothing by a power of time the error is the same share of it however short the step
 * is, and counts over what comes in longer ones. */
static void pdi_embedded_comes(pd_reactive *r, double *size)
{
    for (int k = 0; k < r->components.count; k++) {
        if (!pdi_embedded_new(r, k)) continue;
        r->came[k] = pd_max(r->came[k], size[k]);
        if (r->stays >= PDI_EMBEDDED_STAYS) size[k] = r->came[k];
    }
}

/* Embedded estimate of the error of a step of dt [s], over the largest sum of the terms of totals (eq. 6.13, 8.8). Of
 * two steps of backward Euler it is what their slopes differ by, times sqrt(2) - 1 of dt. */
PDI_FN pd_status pdi_embedded_error(pd_ctx *ctx, pd_reactive *r, double dt, int euler, double *error, int *krylov)
{
    double size[PD_SPECIES_MAX] = {0.0}, rest = 1.0 - PDI_SDIRK_GAMMA;
    pd_status status = PD_OK;
    if (euler) pdi_embedded_differ(r, 1.0 / rest, PDI_SDIRK_GAMMA / (rest * rest), size);
    else pdi_embedded_differ(r, 1.0, 1.0, size);
    pdi_embedded_comes(r, size);
    pdi_reactive_trace(r, size);
    if (r->pass) pdi_embedded_pored(ctx, r, dt);
    *error = pdi_embedded_largest(r, r->work, r->dt, 0, size);
    if (*error > PDI_EMBEDDED_SMALL) status = pdi_embedded_damp(ctx, r, size, error, krylov);
    r->stays = *error > PDI_EMBEDDED_FALLS * r->erred && r->erred > 0.0 ? r->stays + 1 : 0;
    r->erred = *error;
    for (int64_t at = 0; at < r->components.count * (int64_t)r->grid->total; at++)
        if (r->grid->kind[at % r->grid->total] == PD_FLUID) r->work[at] = r->slope[at];
    return status < 0 ? status : PD_OK;
}

PDI_FN void pdi_embedded_accept(pd_reactive *r)
{
    memset(r->came, 0, sizeof r->came);
    r->stays = 0;
    r->erred = 0.0;
}

#undef PDI_EMBEDDED_SMALL
#undef PDI_EMBEDDED_DAMPED
#undef PDI_EMBEDDED_FALLS
#undef PDI_EMBEDDED_STAYS
