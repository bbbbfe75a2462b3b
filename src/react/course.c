/* course: see course.h */
#include "react/course.h"
#include "react/embedded.h"
#include "react/levels.h"
#include "react/positivity.h"
#include "react/bare.h"
#include "react/reclaim.h"
#include "core/array_registry.h"
#include "core/par.h"
#include "solve/sdirk.h"
#include <math.h>
#include <string.h>

/* So often a step without an estimate is made shorter before it stands. */
#define PDI_COURSE_TRIALS 6
/* Times of diffusion through the box after which fields are steady. A closed box keeps its amounts by what changes in a
 * step alone, which counts the less the longer the step is: fields come near in short ones first. */
#define PDI_COURSE_LATE 1e6
#define PDI_COURSE_SOON 1.0
#define PDI_COURSE_LATER 100.0
/* Of the time of diffusion across a cell: a step in which ions stay where they are. */
#define PDI_COURSE_STILL 1e-6
/* So many steps without a solution within this share of the time end a run with migration: it gets no further. */
#define PDI_COURSE_FAILED 12
#define PDI_COURSE_WINDOW 0.1
/* Share of the longest step of the run that the first one is when minerals cover metal. */
#define PDI_COURSE_FIRST 1e-3
/* An error that falls by less, as a step is made shorter, is that of a jump. */
#define PDI_COURSE_JUMP 0.9
/* Steps after which a node has nothing left of what a source takes: then that is why they are so short. */
#define PDI_COURSE_DRAINED 1e6

/* Metals whose amounts are told apart. */
static int pdi_course_metals(const pd_course *a)
{
    return a->desc.surface && a->desc.fed ? a->desc.surface->kinds : 1;
}

PDI_COLD_BEGIN
PDI_FN void pdi_course_list(pdi_array_visitor *owner, void *object)
{
    pd_course *course = (pd_course *)object;
    const pd_reactive *r = course->reactive;
    int64_t total = r ? r->grid->total : 0;
    if (!r || course->desc.settle) return;
    PDI_ARRAY(owner, course, start, r->components.solutes * total, "mol/m3");
    PDI_ARRAY(owner, course, carry, r->components.count * total, "mol/m3");
    if (r->minerals.count) PDI_ARRAY(owner, course, solid, r->minerals.count * total, "mol/m3");
    if (course->desc.coat && r->migration.on) PDI_ARRAY(owner, course, psi, total, "1");
    if (course->desc.bare) {
        PDI_ARRAY(owner, course, share, total, "1");
        PDI_ARRAY(owner, course, first, total, "1");
        PDI_ARRAY(owner, course, now, total, "1");
        PDI_ARRAY(owner, course, mean, total, "1");
        PDI_ARRAY_STATE(owner, course, rate, total, "1/s");
        if (course->desc.fed) PDI_ARRAY(owner, course, came, total, "mol/m3");
        if (course->desc.fed && !course->desc.surface) PDI_ARRAY(owner, course, ahead, total, "mol/m3/s");
        PDI_SCALAR_STATE(owner, course, span, "s");
    }
    PDI_SCALAR_STATE(owner, course, time, "s");
    PDI_SCALAR_STATE(owner, course, dt, "s");
    PDI_SCALAR_STATE(owner, course, error, "1");
    PDI_SCALAR_STATE(owner, course, taken, "mol");
    if (course->desc.fed) PDI_ARRAY(owner, course, due, pdi_course_metals(course) * total, "mol/m3");
    if (pdi_course_metals(course) > 1) PDI_ARRAY_STATE(owner, course, each, pdi_course_metals(course), "mol");
    PDI_SCALAR_STATE(owner, course, bent, "1");
    if (r->migration.on) {
        PDI_SCALAR_STATE(owner, course, failed, "1");
        PDI_SCALAR_STATE(owner, course, since, "s");
    }
    if (course->desc.coat && r->migration.on) PDI_SCALAR_STATE(owner, course, settled, "1");
    PDI_SCALAR_STATE(owner, course, steps, "1");
    PDI_SCALAR_STATE(owner, course, rejected, "1");
    PDI_SCALAR_STATE(owner, course, krylov, "1");
    PDI_SCALAR_STATE(owner, course, newton, "1");
    PDI_SCALAR_STATE(owner, course, euler, "1");
}

static pd_status pdi_course_stage(pd_ctx *ctx, void *user, double share)
{
    return pdi_coat_stage(ctx, ((pd_course *)user)->desc.coat, share);
}

static pd_status pdi_course_make(pd_ctx *ctx, pd_reactive *r, const pd_course_desc *desc, pd_course *a)
{
    memset(a, 0, sizeof *a);
    if (!(desc->cover >= 0.0) || !(desc->cover < 1e100) || (desc->cover > 0.0) != (desc->bare != NULL))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "course", "minerals %g m thick cover metal, expected a finite value "
                       "of at least 0, and above 0 an array for the bare share", desc->cover);
    if (!(desc->rtol >= 0.0) || !(desc->largest >= 0.0) || !(desc->rtol + desc->largest < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "course", "rtol %g and a largest step of %g s, expected finite values of "
                       "at least 0", desc->rtol, desc->largest);
    a->desc = *desc;
    if (!(a->desc.rtol > 0.0)) a->desc.rtol = 1e-3;
    a->desc.shed = NULL;
    a->reactive = r;
    for (int i = 0; i < r->desc.count && desc->fed && desc->shed; i++)
        if (r->components.solute_of_species[i] >= 0) a->shed[r->components.solute_of_species[i]] = desc->shed[i];
    if (desc->coat && desc->coat->desc.surface && desc->surface) {
        desc->surface->stage = pdi_course_stage;
        desc->surface->stager = a;
    }
    return pdi_array_registry_build(ctx, pdi_course_list, a);
}

pd_status pd_course_build(pd_ctx *ctx, pd_reactive *r, const pd_course_desc *desc, pd_course *a)
{
    pd_status status = pdi_course_make(ctx, r, desc, a);
    if (status < 0) pd_course_free(ctx, a);
    return status;
}

/* ---- metal ---- */

/* [solutes] of each with one of metal m. */
static const double *pdi_course_shed(const pd_course *a, int m)
{
    return m && a->desc.surface ? a->desc.surface->kind[m].shed : a->shed;
}

/* What the species of the step of the run get of `fed`. */
static void pdi_course_due(pd_course *a)
{
    int64_t total = a->reactive->grid->total;
    for (int m = 0; m < pdi_course_metals(a) && a->desc.fed; m++)
        pdi_reclaim_due(a->reactive, pdi_course_shed(a, m), a->left, a->desc.fed + m * total, a->due + m * total);
}

/* [mol/m3/s] of a metal at a node: what is due in what is left of the step of the run, and what comes anew. */
static double pdi_course_given(const pd_course *a, int m, int32_t i)
{
    if (a->reactive->grid->kind[i] != PD_FLUID) return 0.0;
    return a->due[m * a->reactive->grid->total + i] / a->left + (a->ahead ? a->ahead[i] : 0.0);
}

/* Sources of metal m that come after its steps; the charge of all [mol/m3/s]. More than the law gave comes with the
 * reactions that take its electrons. Less goes with them, too, but where one circuit is there: its electrons have gone
 * to that, whose curves take as many less. */
static double pdi_course_late(pd_course *a, int m, int one)
{
    pd_reactive *r = a->reactive;
    const pd_etch *s = a->desc.surface;
    double shed[2][PD_SPECIES_MAX], charge[2] = {0.0, 0.0};
    int64_t total = r->grid->total;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int whole = 0; whole < 2; whole++) {
        memcpy(shed[whole], pdi_course_shed(a, m), sizeof shed[whole]);
        if (whole && s) pdi_etch_whole(s, shed[whole]);
        for (int n = 0; n < r->components.solutes; n++) charge[whole] += r->components.charge[n] * shed[whole][n];
    }
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double rate = pdi_course_given(a, m, i);
        int whole = s && !r->migration.tied && (rate > 0.0 || !one);
        for (int n = 0; n < r->components.solutes; n++)
            r->source[n * total + i] = shed[whole][n] * rate + (m ? r->source[n * total + i] : 0.0);
        pdi_compensated_sum_add(&sum, charge[whole] * rate * pd_grid_circumference(r->grid, i));
    }
    return pdi_compensated_sum_total(&sum);
}

static void pdi_course_feed(pd_course *a)
{
    pd_reactive *r = a->reactive;
    int64_t total = r->grid->total;
    double late = 0.0;
    int one = a->desc.surface && a->desc.surface->electrode && pdi_levels_free(a->desc.surface) == 1;
    if (a->desc.fed && a->desc.surface && a->desc.surface->electrode) pdi_levels_ties(r);
    for (int m = 0; a->desc.fed && m < pdi_course_metals(a); m++) late += pdi_course_late(a, m, one);
    if (a->desc.surface) a->desc.surface->late = late;
    if (!a->desc.feed) return;
    for (int64_t at = 0; at < r->components.solutes * total && !a->desc.fed; at++) r->source[at] = 0.0;
    a->desc.feed(a->desc.feeder, r->source);
}

/* So much of a metal is in the species. */
static void pdi_course_count(pd_course *a, int m, const pdi_compensated_sum *sum)
{
    double amount = pdi_compensated_sum_total(sum) * a->reactive->bonds->stencil->volume;
    a->taken += amount;
    if (a->each) a->each[m] += amount;
}

double pd_course_lost(const pd_course *a, int metal)
{
    const pd_reactive *r = a->reactive;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < r->grid->total && a->desc.fed; i++)
        if (r->grid->kind[i] == PD_FLUID)
            pdi_compensated_sum_add(&sum, a->desc.fed[metal * r->grid->total + i] * pd_grid_circumference(r->grid, i));
    return (a->each ? a->each[metal] : a->taken) + pdi_compensated_sum_total(&sum) * r->bonds->stencil->volume;
}

/* What a step of dt [s] has taken of it. */
static void pdi_course_taken(pd_course *a, double dt, int all)
{
    const pd_reactive *r = a->reactive;
    double share = all ? 1.0 : dt / a->left;
    for (int m = 0; m < pdi_course_metals(a) && a->desc.fed; m++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        double *fed = a->desc.fed + m * r->grid->total;
        const double *due = a->due + m * r->grid->total;
        for (int32_t i = 0; i < r->grid->total; i++) {
            if (r->grid->kind[i] != PD_FLUID) continue;
            pdi_compensated_sum_add(&sum, share * due[i] * pd_grid_circumference(r->grid, i));
            fed[i] = (fed[i] - due[i]) + (all ? 0.0 : due[i] * (1.0 - share));
            if (a->ahead) a->came[i] += dt * a->ahead[i];
        }
        pdi_course_count(a, m, &sum);
    }
    const pd_etch *s = a->desc.surface;
    for (int32_t p = 0; a->came && s && p < s->count; p++) a->came[s->node[p]] += s->weight[p] * s->ahead[p];
}

/* What the law at the surface gave in the step of the run, and what came anew, has still to come from the metal. */
static void pdi_course_owed(pd_course *a)
{
    const pd_reactive *r = a->reactive;
    const pd_etch *s = a->desc.surface;
    for (int m = 0; !a->came && s && m < s->kinds; m++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t p = 0; p < s->count; p++) {
            double given = s->weight[p] * s->passed[p];
            if (pdi_etch_which(s, p) != m) continue;
            if (a->desc.fed) a->desc.fed[m * r->grid->total + s->node[p]] -= given;
            pdi_compensated_sum_add(&sum, given * pd_grid_circumference(r->grid, s->node[p]));
        }
        pdi_course_count(a, m, &sum);
    }
    if (!a->came) return;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        a->desc.fed[i] -= a->came[i];
        pdi_compensated_sum_add(&sum, a->came[i] * pd_grid_circumference(r->grid, i));
        a->came[i] = 0.0;
    }
    pdi_course_count(a, 0, &sum);
}

/* 1: node i has got more of metal m than there was, and none is there any more. */
static int pdi_course_over(const pd_course *a, int m, int32_t i)
{
    const pd_grid *grid = a->reactive->grid;
    return grid->kind[i] == PD_FLUID && a->desc.fed[m * grid->total + i] < 0.0 &&
           pdi_etch_law(a->desc.surface, m, i) < 0;
}

/* What nodes have got of metal m beyond what there was: all fluid gives that back. */
static void pdi_course_reclaim(pd_course *a, int m)
{
    pd_reactive *r = a->reactive;
    double shed[PD_SPECIES_MAX], *fed = a->desc.fed + m * r->grid->total;
    pdi_compensated_sum sum = {0.0, 0.0}, taken = {0.0, 0.0};
    memcpy(shed, pdi_course_shed(a, m), sizeof shed);
    pdi_etch_whole(a->desc.surface, shed);
    for (int32_t i = 0; i < r->grid->total; i++)
        if (pdi_course_over(a, m, i)) pdi_compensated_sum_add(&sum, -fed[i] * pd_grid_circumference(r->grid, i));
    if (!(pdi_compensated_sum_total(&sum) > 0.0)) return;
    double share = pdi_reclaim_take(r, shed, pdi_compensated_sum_total(&sum)) / pdi_compensated_sum_total(&sum);
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (!pdi_course_over(a, m, i)) continue;
        pdi_compensated_sum_add(&taken, share * fed[i] * pd_grid_circumference(r->grid, i));
        fed[i] -= share * fed[i];
    }
    pdi_course_count(a, m, &taken);
}

/* ---- metal that minerals cover ---- */

/* What the metal knows: the share x + by y. */
static void pdi_course_bare(pd_course *a, const double *x, double by, const double *y)
{
    for (int32_t j = 0; j < a->reactive->grid->total; j++) {
        double share = x[j] < 0.0 ? 1.0 : pd_min(pd_max(x[j] + by * y[j], 0.0), 1.0);
        a->desc.bare[j] = (a->desc.whole ? a->desc.whole[j] : 1.0) * share;
    }
    if (a->desc.reached) *a->desc.reached = 0;
}

/* Shares are those of now, also at the start of the step of the run. */
static void pdi_course_uncover(pd_course *a)
{
    size_t size = (size_t)a->reactive->grid->total * sizeof *a->first;
    pdi_bare_shares(a->reactive, a->desc.cover, a->desc.layers, a->share);
    memcpy(a->first, a->share, size);
    memset(a->mean, 0, size);
    a->given = 0.0;
    pdi_course_bare(a, a->share, 0.0, a->rate);
}

/* Errors of the shares over the largest of them and over what they may be. Metal takes means over the step of the run,
 * of the share and of the speed: where both change by x, their product is wrong by x^2/12. *off: species get the share
 * of the middle of their step, by its rate in the last one; where it is x off at the end, by x/2. */
static double pdi_course_load(const pd_course *a, const pd_step *s, double *off)
{
    double most = 0.0, change = 0.0, rtol = s->rtol > 0.0 ? s->rtol : a->desc.rtol;
    *off = 0.0;
    for (int32_t j = 0; j < a->reactive->grid->total; j++) {
        most = pd_max(most, a->first[j]);
        change = pd_max(change, fabs(a->share[j] - a->first[j]));
        *off = pd_max(*off, fabs(a->share[j] - a->now[j] - s->dt * a->rate[j]));
    }
    if (!(most > 0.0)) return *off = 0.0;
    *off *= 0.5 / (most * rtol);
    return change * change / (12.0 * most * most * rtol);
}

/* Error of a step, over what may be: what is too much is left for the next one. */
static double pdi_course_covering(pd_course *a, const pd_step *s)
{
    double off;
    pdi_bare_shares(a->reactive, a->desc.cover, a->desc.layers, a->share);
    double load = pdi_course_load(a, s, &off);
    if (load <= 1.0) return off;
    double part = (1.0 - sqrt(a->covered)) / (sqrt(load) - sqrt(a->covered));
    return part > 0.0 ? pd_max(off, 1.0 / (part * part)) : HUGE_VAL;
}

/* The error of shares of the step that is tried, over what may be. Where it does not fall with the step it is a jump,
 * as of a mineral that forms at once: what metal gives is wrong by it for so long alone, and may be so as much as in
 * the first step that was tried. */
static double pdi_course_jump(pd_course *a, const pd_step *s)
{
    double error = pdi_course_covering(a, s);
    if (!s->rejected) a->tried = s->dt;
    int jump = s->rejected && error > 1.0 && error > PDI_COURSE_JUMP * a->jump && error * s->dt <= a->tried;
    a->jump = error;
    return jump ? 1.0 : error;
}

/* What all metal would give in a step of dt [s] if it were bare, of any unit: with it as weight the mean of shares
 * times that of speeds is what metal gives. */
static double pdi_course_gives(const pd_course *a, double dt)
{
    const pd_etch *surface = a->desc.surface;
    double sum = 0.0, share = 0.0;
    if (!surface && !a->ahead) return dt;
    for (int32_t p = 0; surface && p < surface->count; p++) sum += surface->ahead[p];
    if (surface) return sum;
    for (int32_t i = 0; i < a->reactive->grid->total; i++) {
        sum += a->ahead[i];
        if (!(a->first[i] < 0.0)) share += 0.5 * (a->now[i] + a->share[i]);
    }
    return share > 0.0 ? dt * sum / share : 0.0;
}

/* A step of species stands. 1: another one like it would be too much for the step of the run. */
static int pdi_course_full(pd_course *a, const pd_step *s)
{
    double off, before = sqrt(a->covered), load = pdi_course_load(a, s, &off), gives = pdi_course_gives(a, s->dt);
    for (int32_t j = 0; j < a->reactive->grid->total; j++) {
        a->rate[j] = (a->share[j] - a->now[j]) / s->dt;
        a->mean[j] += 0.5 * gives * (a->share[j] + a->now[j]);
    }
    a->given += gives;
    a->covered = load;
    return sqrt(load) + (sqrt(load) - before) > 1.0;
}

/* The step of the run is done. */
static void pdi_course_covered(pd_course *a, double end)
{
    double span = end - a->begin;
    a->span = pdi_sdirk_update_plan(a->span, span, a->covered);
    for (int32_t j = 0; j < a->reactive->grid->total; j++) {
        double mean = a->given > 0.0 ? a->mean[j] / a->given : a->share[j];
        a->mean[j] = a->first[j] < 0.0 ? -1.0 : mean;
    }
    pdi_course_bare(a, a->mean, 0.0, a->rate);
}

/* Nodes have turned: what is bare of the metal around them has no past. */
static void pdi_course_turned(pd_course *a)
{
    pdi_bare_shares(a->reactive, a->desc.cover, a->desc.layers, a->now);
    for (int32_t j = 0; j < a->reactive->grid->total; j++) {
        if (!(a->now[j] < a->share[j]) && !(a->now[j] > a->share[j])) continue;
        a->share[j] = a->first[j] = a->mean[j] = a->now[j];
        a->rate[j] = 0.0;
    }
    pdi_course_bare(a, a->mean, 0.0, a->rate);
}

/* What metal gives in a step of species. PD_RETRY: its laws need a shorter one. */
static pd_status pdi_course_ahead(pd_ctx *ctx, pd_course *a, const pd_step *s)
{
    int finds = a->desc.surface || a->ahead;
    pdi_course_bare(a, a->now, 0.5 * s->dt, a->rate);
    a->step = s->dt;
    pd_status status = finds ? a->desc.find(ctx, a->desc.user, s->time + 0.5 * s->dt) : PD_OK;
    if (status == PD_OK) pdi_course_feed(a);
    return status;
}

/* Steps of the run that suit the shares, as far as the last one tells. */
static pd_status pdi_course_longest(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_course *a = (pd_course *)self;
    PD_TRY(pdi_physics_limit_max_step(ctx, self, s));
    if (!a->desc.bare) return PD_OK;
    pdi_course_uncover(a);
    if (!(a->span > 0.0)) a->span = PDI_COURSE_FIRST * s->dt;
    s->dt = pd_min(s->dt, a->span);
    return PD_OK;
}

/* ---- the steps of a process ---- */

static void pdi_course_keep(const pd_ctx *ctx, pd_course *a, int back)
{
    pd_reactive *r = a->reactive;
    int64_t total = r->grid->total;
    pdi_par_copy(ctx, r->components.solutes * total, back ? a->start : r->c, back ? r->c : a->start);
    pdi_par_copy(ctx, r->components.count * total, back ? a->carry : r->carry, back ? r->carry : a->carry);
    if (a->solid) pdi_par_copy(ctx, r->minerals.count * total, back ? a->solid : r->solid, back ? r->solid : a->solid);
    if (a->psi) pdi_par_copy(ctx, total, back ? a->psi : r->migration.psi, back ? r->migration.psi : a->psi);
    memcpy(back ? r->in : a->in, back ? a->in : r->in, sizeof a->in);
    memcpy(back ? r->out : a->out, back ? a->out : r->out, sizeof a->out);
}

/* [s] in which ions cross a cell. */
static double pdi_course_cell(const pd_reactive *r)
{
    double h = HUGE_VAL;
    for (int axis = 0; axis < PD_DIM; axis++) h = pd_min(h, r->grid->h[axis]);
    return h * h / r->diffusion.desc.diffusivity;
}

/* With states among ions that migrate: the potential of the ions as they are, by a step in which they stay. What passes
 * in it is next to nothing beside what is there, so it meets its equations to rounding. */
static pd_status pdi_course_still(pd_ctx *ctx, pd_course *a, double t)
{
    pd_reactive *r = a->reactive;
    pd_reactive_result result;
    double dt = PDI_COURSE_STILL * pdi_course_cell(r);
    pdi_coat_rest(a->desc.coat, t, dt);
    r->exact = 1;
    pd_status status = pd_reactive_step(ctx, r, dt, &result);
    r->exact = 0;
    if (status == PD_OK) pdi_par_copy(ctx, r->grid->total, r->migration.psi, a->psi);
    pdi_course_keep(ctx, a, 1);
    a->settled = 1;
    return status < 0 ? status : PD_OK;
}

static pd_status pdi_course_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_course *a = (pd_course *)self;
    a->left = s->latest_end - s->time;
    if (!(a->dt > 0.0)) a->dt = a->left;
    a->time = s->time;
    if (!a->begun) {
        a->begin = s->time;
        a->covered = 0.0;
        if (a->desc.bare) pdi_course_uncover(a);
        if (a->desc.surface) PD_TRY(a->desc.find(ctx, a->desc.user, s->time));
        for (int m = 0; a->desc.surface && a->desc.fed && m < pdi_course_metals(a); m++) pdi_course_reclaim(a, m);
    }
    a->begun = 1;
    if (a->desc.bare) memcpy(a->now, a->share, (size_t)a->reactive->grid->total * sizeof *a->now);
    pdi_course_keep(ctx, a, 0);
    if (a->psi && a->desc.coat->desc.surface && !a->settled) PD_TRY(pdi_course_still(ctx, a, s->time));
    if (a->desc.coat) PD_TRY(pdi_coat_begin(ctx, a->desc.coat, s->time));
    pdi_course_due(a);
    pdi_course_feed(a);
    s->dt = pdi_sdirk_limit_step(a->dt, a->desc.largest, a->left);
    return PD_OK;
}

/* A step from t [s] had no solution, or by way of shorter ones alone. */
static void pdi_course_fails(pd_course *a, double t)
{
    if (!a->failed || t > (1.0 + PDI_COURSE_WINDOW) * a->since) {
        a->failed = 0;
        a->since = t;
    }
    a->failed++;
}

/* States of surfaces go to the end of the step; *covering: the larger of what it was and of their error. */
static pd_status pdi_course_coat(pd_ctx *ctx, pd_course *a, pd_step *s, double *covering)
{
    pd_status status = pdi_coat_behind(ctx, a->desc.coat, a->start, s->time, s->dt, s->rejected);
    if (status == PD_RETRY) s->error = HUGE_VAL;
    *covering = pd_max(*covering, a->desc.coat->error);
    return status;
}

/* The flow is that of the middle of the step. */
static pd_status pdi_course_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_course *a = (pd_course *)self;
    pd_reactive_result result;
    a->lasts = 1.0;
    a->used = 0;
    if (s->solve_at) PD_TRY(s->solve_at(ctx, s->solve_at_user, s->time + 0.5 * s->dt));
    s->error = HUGE_VAL; /* of PD_RETRY */
    pd_status status = a->desc.coat ? pdi_coat_ahead(ctx, a->desc.coat, s->time, s->dt, s->rejected) : PD_OK;
    if (a->desc.bring && status == PD_OK) status = a->desc.bring(ctx, a->desc.bringer, s->time + 0.5 * s->dt);
    if ((a->desc.coat || a->desc.bring) && status == PD_OK) pdi_course_feed(a);
    if (a->desc.bare && status == PD_OK) status = pdi_course_ahead(ctx, a, s);
    if (status != PD_OK) return status;
    if (a->desc.surface) a->desc.surface->from = s->time;
    if (a->desc.surface) a->desc.surface->span = s->dt;
    status = pd_reactive_step(ctx, a->reactive, s->dt, &result);
    if (a->desc.surface) a->desc.surface->span = 0.0;
    a->krylov += result.krylov;
    a->newton += result.newton;
    if (status == PD_RETRY || result.parts) pdi_course_fails(a, s->time);
    a->error = result.error;
    a->residual = pd_max(a->residual, result.residual * a->reactive->desc.tolerance);
    s->error = result.error / a->desc.rtol;
    if (status == PD_RETRY) s->error = HUGE_VAL;
    if (status != PD_OK) return status;
    a->euler += result.euler;
    double covering = a->desc.bare ? pdi_course_jump(a, s) : 0.0;
    if (a->desc.coat) status = pdi_course_coat(ctx, a, s, &covering);
    if (status != PD_OK) return status;
    if (covering > 1.0) {
        s->error = pd_max(s->error, covering);
        return PD_RETRY;
    }
    if (a->desc.coat) s->error = pd_max(s->error, covering);
    if (!a->bent && result.euler && !(result.error > 0.0) && s->rejected < PDI_COURSE_TRIALS) s->error = HUGE_VAL;
    int stands = a->bent || s->error <= 1.0;
    if (stands && a->desc.surface) a->lasts = pdi_etch_lasts(a->desc.surface, &a->used);
    return stands && !(a->lasts < 1.0) ? PD_OK : PD_RETRY;
}

static pd_status pdi_course_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_course *a = (pd_course *)self;
    (void)ctx;
    int all = !(s->end < s->latest_end), last = all;
    if (a->desc.bare && pdi_course_full(a, s)) last = s->ends_substeps = 1;
    /* metal that is used up goes before anything else moves */
    if (a->desc.surface && a->used) last = s->ends_substeps = 1;
    if (a->desc.coat) pdi_coat_accept(a->desc.coat, s->dt);
    if (a->desc.coat || a->desc.bring) last = s->ends_substeps = 1;
    pdi_course_taken(a, s->dt, all);
    if (a->desc.surface) pdi_etch_accept(a->desc.surface);
    if ((a->desc.surface || a->came) && last) pdi_course_owed(a);
    if (a->desc.bare && last) pdi_course_covered(a, s->end);
    if (last) a->begun = 0;
    a->time = s->end;
    if (!a->bent) pdi_sdirk_accept(&a->dt, s);
    a->bent = 0;
    a->steps++;
    pdi_embedded_accept(a->reactive);
    return PD_OK;
}

/* The last step would take more of a component than there is. */
static pd_status pdi_course_short(pd_ctx *ctx, const pd_course *a, double t)
{
    const pd_reactive *r = a->reactive;
    int solute = r->components.component_solute[r->short_of - 1], n = 0;
    char place[PDI_GRID_POSITION_LENGTH];
    while (n + 1 < a->desc.species_count && r->components.solute_of_species[n] != solute) n++;
    const char *name = a->desc.species ? a->desc.species[n].name : "a species";
    return pd_fail(ctx, PD_ERR_STATE, "chemistry",
                   "at t = %g s more %s is taken up beside %s m than is there: "
                   "expected a rate or current that falls to 0 with it, such as one with the factor [%s]/(1 mM)",
                   t, name, pdi_grid_format_position(r->grid, r->short_at, place), name);
}

static pd_status pdi_course_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_course *a = (const pd_course *)self;
    const pd_etch *metal = a->desc.surface;
    double ions = 0.0;
    int solute;
    int32_t node, least = metal && metal->electrode ? pdi_positivity_fewest(metal, &ions) : 0;
    char place[PDI_GRID_POSITION_LENGTH];
    if (metal && metal->odd && !(s->error < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_STATE, "chemistry",
                       "the law of metal is no number beside %s m after t = %g s, "
                       "however short the step: expected one for all that comes to its surface, such as "
                       "sqrt(max(1 - [Mg2+]/(1 mM), 0))",
                       pdi_grid_format_position(metal->reactive->grid, metal->node[metal->odd - 1], place), s->time);
    if (a->desc.surface && a->desc.surface->electrode && !(s->error < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_STATE, "chemistry",
                       "this current cannot pass: no step of %g s was found at t = "
                       "%g s. Expected one that the ions beside %s m can carry, where %.3g mol/m3 are left; and the "
                       "curve of an electrode that takes up no more of a species than reaches the metal, and falls "
                       "to 0 with it, as i = -1 A/m2*[O2]/(0.25 mol/m3)%s",
                       s->dt, s->time, pdi_grid_format_position(metal->reactive->grid, least, place), ions,
                       a->desc.surface->share ? ", or a factor leaves metal without a current that balances" : "");
    if (a->desc.drained && a->desc.feed &&
        pdi_positivity_drained(a->reactive, PDI_COURSE_DRAINED * s->dt, &solute, &node))
        return a->desc.drained(ctx, a->desc.feeder, node, solute, s->time);
    if (a->reactive->short_of) return pdi_course_short(ctx, a, s->time);
    if (a->reactive->migration.on && !(s->error < HUGE_VAL))
        return pd_fail(ctx, PD_ERR_STATE, "chemistry", "no step of %g s was found at t = %g s for ions that migrate: "
                       "fluid with next to none beside fluid with many conducts too little, expected some "
                       "everywhere, as those of water, [species H+] and [species OH-] with initial = 1e-4 mol/m3",
                       s->dt, s->time);
    if (a->desc.coat && a->desc.coat->error > 1.0)
        return pd_fail(ctx, PD_ERR_STATE, "surface", "states of surfaces change faster than any step follows at t = "
                       "%g s: expected a rate that stays finite", s->time);
    return pd_fail(ctx, PD_ERR_STATE, "chemistry", "the error of a step of %g s at t = %g s is %g of the largest "
                   "concentrations, expected it to fall with the step", s->dt, s->time, a->error);
}

/* 1: steps have no solution, or hardly any, and shorter ones do not help. */
static int pdi_course_ends(const pd_course *a, const pd_step *s)
{
    const pd_reactive *r = a->reactive;
    if (s->error < HUGE_VAL || a->lasts < 1.0 || !r->migration.on) return 0;
    return a->failed >= PDI_COURSE_FAILED || s->dt < PDI_COURSE_STILL * pdi_course_cell(r);
}

static pd_status pdi_course_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_course *a = (pd_course *)self;
    pdi_course_keep(ctx, a, 1);
    if (a->desc.coat) pdi_coat_reject(a->desc.coat);
    a->rejected++;
    if (pdi_course_ends(a, s)) return pdi_course_stuck(ctx, self, s);
    if (a->lasts < 1.0) {
        s->dt *= a->lasts;
        return PD_OK;
    }
    pdi_sdirk_reject(&a->dt, a->desc.largest, s);
    /* what a long first step asks for may be far from the start: ions cross a cell in it, and steps grow fast */
    if (!a->steps && !(s->error < HUGE_VAL) && a->reactive->migration.on)
        a->dt = pd_min(a->dt, pdi_course_cell(a->reactive));
    pdi_sdirk_limit(a->dt, a->desc.largest, s);
    return PD_OK;
}

/* Steady fields: steps, the last one beyond all time scales. The balance begins with them. */
static pd_status pdi_course_settle(pd_ctx *ctx, pd_course *a)
{
    pd_reactive *r = a->reactive;
    pd_reactive_result result;
    double square = 0.0, d = r->diffusion.desc.diffusivity;
    for (int axis = 0; axis < PD_DIM; axis++) square = pd_max(square, pow(r->grid->hi[axis] - r->grid->lo[axis], 2.0));
    if (a->desc.surface) PD_TRY(a->desc.find(ctx, a->desc.user, 0.0));
    pd_status status = PD_OK;
    for (double late = PDI_COURSE_SOON; late < 1.5 * PDI_COURSE_LATE; late *= PDI_COURSE_LATER) {
        status = pd_reactive_step(ctx, r, late * square / d, &result);
        if (a->desc.surface && status == PD_OK) pdi_etch_accept(a->desc.surface);
        a->krylov += result.krylov;
        a->newton += result.newton;
        if (status < 0) return status;
    }
    for (int e = 0; a->desc.surface && e < 2 * a->desc.surface->desc.electrodes.count; e++)
        a->desc.surface->charge[e] = 0.0; /* no time has passed */
    if (status == PD_OK) return pd_reactive_begin(ctx, r);
    return pd_fail(ctx, PD_ERR_DIVERGED, "chemistry", "no steady concentrations were found in %d steps of Newton, "
                   "expected time = implicit, which follows them to there", result.newton);
}

static pd_status pdi_course_start(pd_ctx *ctx, void *self, double t)
{
    pd_course *a = (pd_course *)self;
    a->time = t;
    if (a->desc.bare) pdi_course_uncover(a);
    if (a->desc.coat) PD_TRY(pdi_coat_places(ctx, a->desc.coat));
    if (a->desc.settle) return pdi_course_settle(ctx, a);
    return a->desc.open ? a->desc.open(ctx, a->desc.user, t) : PD_OK;
}

/* A node comes to equilibrium again; what that is off by is owed. */
static void pdi_course_settled(pd_course *a, int32_t node)
{
    pd_reactive *r = a->reactive;
    int64_t total = r->grid->total;
    double c[PD_SPECIES_MAX], from[PD_SPECIES_MAX], to[PD_SPECIES_MAX];
    pd_reactive_get(r, r->c, node, c);
    pdi_components_compute_totals(&r->components, c, from);
    if (r->components.members && pdi_components_solve(&r->components, from, c) != PD_OK) return;
    pdi_migration_neutralise(&r->migration, c);
    pdi_components_compute_totals(&r->components, c, to);
    for (int k = 0; k < r->components.count; k++) r->carry[k * total + node] += from[k] - to[k];
    pdi_reactive_put(r, c, node, r->c);
}

/* With migration, each node that was metal gets the share 1/(2 d) of what fluid beside it held, `start`, as far as
 * nothing has filled it: without ions it would carry no current. `share` 0: nodes come to equilibrium after that. */
static void pdi_course_share(pd_course *a, const int32_t *turned, int32_t count, double share)
{
    pd_reactive *r = a->reactive;
    const pd_grid *grid = r->grid;
    const pd_etch *surface = a->desc.surface;
    int64_t total = grid->total;
    for (int32_t k = 0; k < count; k++) {
        int32_t i = turned[k];
        double lacks = surface && surface->swept ? surface->split[i] : 1.0;
        for (int side = 0; side < 2 * PD_DIM; side++) {
            int32_t j = pd_grid_find_source(grid, i + (side % 2 ? 1 : -1) * (int32_t)grid->stride[side / 2], NULL);
            if (j < 0 || j == i || grid->kind[j] != PD_FLUID) continue;
            double around = pd_grid_circumference(grid, j) / pd_grid_circumference(grid, i);
            for (int n = 0; n < r->components.solutes && share > 0.0; n++) {
                double part = lacks * share * a->start[n * total + j];
                r->c[n * total + j] -= part;
                r->c[n * total + i] += around * part;
            }
            if (fabs(r->migration.psi[j]) > fabs(r->migration.psi[i])) r->migration.psi[i] = r->migration.psi[j];
            if (!(share > 0.0)) pdi_course_settled(a, j);
        }
        if (!(share > 0.0)) pdi_course_settled(a, i);
    }
}

/* Nodes that were metal begin as water, or with migration with a share of the fluid beside them. */
static pd_status pdi_course_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    pd_course *a = (pd_course *)self;
    pd_reactive *r = a->reactive;
    double c[PD_SPECIES_MAX], none[PD_SPECIES_MAX];
    memset(none, 0, sizeof none);
    PD_TRY(pd_reactive_update(ctx, r));
    pdi_components_solve_pure_solvent(&r->components, c);
    for (int32_t k = 0; k < count; k++) {
        pdi_reactive_put(r, c, turned[k], r->c);
        for (int s = 0; s < r->minerals.count; s++) r->solid[(int64_t)s * r->grid->total + turned[k]] = 0.0;
        if (r->narrow) r->narrow[turned[k]] = 0.0;
    }
    if (r->migration.on) {
        pdi_course_keep(ctx, a, 0);
        for (int32_t k = 0; k < count; k++) {
            pdi_reactive_put(r, none, turned[k], a->start); /* what turns gives nothing */
            r->migration.psi[turned[k]] = 0.0;
        }
        if (a->desc.surface && a->desc.surface->swept) pdi_etch_turn(a->desc.surface, turned, count);
        pdi_course_share(a, turned, count, 0.5 / PD_DIM);
        pdi_course_share(a, turned, count, 0.0);
    }
    a->bent = 1;
    a->settled = 0;
    if (a->desc.coat) a->desc.coat->anew = 1;
    if (a->desc.bare) pdi_course_turned(a);
    return PD_OK;
}

static pd_status pdi_course_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_course *a = (pd_course *)self;
    pd_reactive *r = a->reactive;
    PD_TRY(pdi_array_registry_store(ctx, pdi_reactive_list, r, archive));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "amounts at the start", r->start, PD_REACTIVE_ROWS));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "amounts in", r->in, PD_SPECIES_MAX));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "amounts out", r->out, PD_SPECIES_MAX));
    PD_TRY(pdi_array_registry_store(ctx, pdi_course_list, a, archive));
    if (a->desc.coat) PD_TRY(pdi_array_registry_store(ctx, pdi_coat_list, a->desc.coat, archive));
    if (a->desc.surface) PD_TRY(pdi_array_registry_store(ctx, pdi_etch_list, a->desc.surface, archive));
    if (a->desc.bare && archive->is_reading) pdi_course_uncover(a);
    return PD_OK;
}

static double pdi_course_imbalance(pd_ctx *ctx, void *self)
{
    const pd_course *a = (const pd_course *)self;
    pd_reactive_balance b;
    double worst = 0.0;
    for (int row = 0; row < a->reactive->rows; row++) {
        pd_reactive_balance_of(ctx, a->reactive, row, &b);
        worst = pd_max(worst, b.relative);
    }
    return worst;
}

pd_physics pd_course_process(pd_course *a)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "species in time";
    p.self = a;
    p.start = pdi_course_start;
    p.nodes_converted = pdi_course_changed;
    p.checkpoint = pdi_course_store;
    p.imbalance = pdi_course_imbalance;
    if (a->desc.settle) return p;
    p.time = &a->time;
    p.steps = &a->steps;
    p.has_substeps = a->desc.surface != NULL || a->desc.bare != NULL;
    p.max_run_step = pdi_course_longest;
    p.limit = pdi_course_limit;
    p.attempt = pdi_course_attempt;
    p.accept = pdi_course_accept;
    p.reject = pdi_course_reject;
    p.report_underflow = pdi_course_stuck;
    return p;
}

void pd_course_free(pd_ctx *ctx, pd_course *a)
{
    pdi_array_registry_free(ctx, pdi_course_list, a);
    memset(a, 0, sizeof *a);
}
PDI_COLD_END
