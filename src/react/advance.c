/* advance: see advance.h
 *
 * Design: Newton's method in the totals. A step of it moves totals; concentrations follow by the equilibrium of each
 * node, so iterates have no negative ones, and fronts where a species is used up are kinks of c(T) and not of T. The
 * linear systems are solved by GMRES with the derivatives dc/dT of each node.
 */
#include "react/advance.h"
#include "react/embedded.h"
#include "react/extents.h"
#include "react/levels.h"
#include "react/positivity.h"
#include "react/loops.h"
#include "react/tangent.h"
#include "core/par.h"
#include "solve/sdirk.h"
#include "transport/bounds.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Roundings of what a node exchanges that its balance may be off by. */
#define PDI_ADVANCE_ROUND 32.0
/* With migration: roundings of the ions of a node that its charge may be off by. */
#define PDI_ADVANCE_CHARGE 4.0
/* A residual within this factor of the tolerance that comes no nearer than this share of itself in a step is rounding,
 * and met: what is undone is carried on. Rounding does not fall with a tolerance below the default. */
#define PDI_ADVANCE_NEAR 10.0
/* The same with electrodes: ions that are used up at them leave a potential that amplifies rounding. */
#define PDI_ADVANCE_NEAR_STEEP 1e3
#define PDI_ADVANCE_STALL 0.5
/* By so much weights that grow exceed what they have to be. */
#define PDI_ADVANCE_ROOM 2.0
/* So many steps of Newton may raise the residual by this factor; else a step is halved, so many times at most. */
#define PDI_ADVANCE_FREE 12
#define PDI_ADVANCE_RISE 1e3
#define PDI_ADVANCE_HALVINGS 10
/* Halvings of the correction of one node whose totals would have no equilibrium, or that loses a mineral or is full. */
#define PDI_ADVANCE_CUTS 20
/* With migration: psi moves at most by this in a step of Newton that raises the residual, and it may raise it by this
 * factor, since the next one finds the potential in the ions that have come. */
#define PDI_ADVANCE_LIFT 3.0
#define PDI_ADVANCE_JUMP 1e9
/* Tries with shorter steps, and their ratio; with a law in the potential of ions, which a steep exponential is far from
 * the solution. */
#define PDI_ADVANCE_PARTS 8
#define PDI_ADVANCE_PARTS_STEEP 18
#define PDI_ADVANCE_SHORTER 8.0
/* Share of a residual that the linear solver leaves at least: its basis has single precision. */
#define PDI_ADVANCE_SINGLE 1e-5

/* Concentrations and minerals. */
static void pdi_advance_copy(const pd_ctx *ctx, const pd_reactive *r, const double *c, double *to, const double *solid,
                             double *solid_to)
{
    pdi_par_copy(ctx, r->components.solutes * (int64_t)r->grid->total, c, to);
    if (r->minerals.count) pdi_par_copy(ctx, r->minerals.count * (int64_t)r->grid->total, solid, solid_to);
}

/* What was there at the start of the step; or (keep = 1) what is there becomes that. */
static void pdi_advance_back(const pd_ctx *ctx, pd_reactive *r, int keep)
{
    pd_migration *m = &r->migration;
    if (keep) pdi_advance_copy(ctx, r, r->c, r->begin, r->solid, r->solid_begin);
    else pdi_advance_copy(ctx, r, r->begin, r->c, r->solid_begin, r->solid);
    if (m->on) pdi_par_copy(ctx, r->grid->total, keep ? m->psi : m->begin, keep ? m->begin : m->psi);
}

/* What the balances of node i lack beside what leaves: in time, by sources and kinetic reactions [mol/m3/s]. */
static void pdi_advance_lack(const pd_reactive *r, int32_t i, double *lack)
{
    const pd_components *s = &r->components;
    double c[PD_SPECIES_MAX], source[PD_SPECIES_MAX], gain[PD_SPECIES_MAX];
    pd_reactive_get(r, r->c, i, c);
    pd_reactive_get(r, r->source, i, source);
    pdi_components_compute_totals(s, c, lack);
    pdi_components_compute_totals(s, source, gain);
    for (int k = 0; k < s->count; k++) lack[k] = r->total[(int64_t)k * r->grid->total + i] - lack[k];
    for (int m = 0; m < r->minerals.count; m++) {
        int64_t at = (int64_t)m * r->grid->total + i;
        for (int k = 0; k < s->count; k++)
            lack[k] += r->minerals.total_content[m][k] * (r->solid_start[at] - r->solid[at]);
    }
    for (int k = 0; k < s->count; k++) lack[k] = lack[k] / r->dt + gain[k];
    for (int n = 0; n < s->kinetics; n++) {
        double speed = pdi_components_compute_rate(s, &s->kinetic[n], c, NULL, NULL);
        for (int k = 0; k < s->count; k++) lack[k] += s->kinetic[n].total_change[k] * speed;
    }
    if (r->surface) pdi_etch_gain(r->surface, i, lack);
}

/* 1: no solute of component k is at node i. */
static int pdi_advance_absent(const pd_reactive *r, int k, int32_t i)
{
    const pd_components *s = &r->components;
    double sum = 0.0;
    for (int n = 0; n < s->solutes; n++) sum += fabs(s->stoichiometry[k][n]) * r->c[(int64_t)n * r->grid->total + i];
    return !(sum > PDI_POSITIVITY_NONE);
}

/* work = what the balances lack over their weights; the norm of what can be met. */
static double pdi_advance_residual(const pd_ctx *ctx, pd_reactive *r)
{
    int64_t total = r->grid->total;
    int count = r->components.count, nt = pdi_tangent_threads(ctx, r);
    double *work = r->work;
    (void)nt;
    pdi_tangent_images(r, r->c);
    pdi_tangent_leave(ctx, r, r->c, r->wall, work);
    if (r->surface) pdi_levels_solve(ctx, r->surface);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double lack[PD_SPECIES_MAX];
        for (int k = 0; k < count; k++) r->move[k * total + i] = 0.0; /* images had changes */
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_advance_lack(r, i, lack);
        for (int k = 0; k < count; k++) {
            int64_t at = k * total + i;
            work[at] = lack[k] / r->weight[k] - work[at];
            r->spent[at] = work[at] < 0.0 && pdi_advance_absent(r, k, i) &&
                           -work[at] * r->weight[k] > PDI_ADVANCE_ROUND * DBL_EPSILON * pdi_extents_turnover(r, k, i);
            r->move[at] = r->spent[at] ? 0.0 : work[at];
        }
    }
    return sqrt(pdi_par_dot(ctx, count * total, r->move, r->move));
}

/* With migration: what a node lacks to be neutral, over the rounding of its ions, as charge of component k. */
static double pdi_advance_charge(const pd_reactive *r, int k, int32_t i)
{
    const pd_components *s = &r->components;
    double c[PD_SPECIES_MAX], size, z = fabs(r->migration.on ? r->migration.charge[s->component_solute[k]] : 0.0);
    if (!(z > 0.0)) return 0.0;
    pd_reactive_get(r, r->c, i, c);
    pdi_migration_charge(&r->migration, c, &size);
    return PDI_ADVANCE_CHARGE / PDI_ADVANCE_ROUND * size / z;
}

/* Rounding [mol/m3/s] of the balances of component k, as a norm; *held: of what is there over the step, its square. */
static double pdi_advance_rounding(const pd_ctx *ctx, pd_reactive *r, int k, double *held)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double *size = r->part_of, round = PDI_ADVANCE_ROUND * DBL_EPSILON;
    /* concentrations are as good as their law */
    double met = round + (r->minerals.count ? PDI_MINERAL_TOLERANCE : 0.0);
    *held = 0.0;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double sum = 0.0;
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < s->solutes; n++) sum += fabs(s->stoichiometry[k][n]) * r->c[n * total + i];
        size[i] = (sum + pdi_advance_charge(r, k, i)) * (round / r->dt + met * r->rates[i]);
        size[i] += pdi_extents_turnover(r, k, i) * round;
        *held += sum / r->dt * (sum / r->dt);
    }
    return sqrt(pdi_par_dot(ctx, total, size, size));
}

/* With migration: weights grow with the rounding of what has come. 1: one has. */
static int pdi_advance_grow(const pd_ctx *ctx, pd_reactive *r)
{
    int grown = 0;
    for (int k = 0; k < r->components.count; k++) {
        double held, least = pdi_advance_rounding(ctx, r, k, &held) / r->desc.tolerance;
        if (!(r->weight[k] < least)) continue;
        r->weight[k] = PDI_ADVANCE_ROOM * least;
        grown = 1;
    }
    return grown;
}

/* work: what the balances lack beside kinetic reactions. At first these may be any number of times as fast as what is
 * there at the end: amounts that they only turn over are in the rounding. */
static void pdi_advance_lack_at_rest(pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < (int32_t)total && s->kinetics; i++) {
        double c[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        for (int n = 0; n < s->kinetics; n++) {
            double speed = pdi_components_compute_rate(s, &s->kinetic[n], c, NULL, NULL);
            for (int k = 0; k < s->count; k++) r->work[k * total + i] -= s->kinetic[n].total_change[k] * speed;
        }
    }
}

/* Weights of the balances: what is there over the step, or what they lack at first, or the rounding of both. */
static void pdi_advance_weigh(const pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int k = 0; k < s->count; k++) r->weight[k] = 1.0;
    pdi_advance_residual(ctx, r);
    pdi_advance_lack_at_rest(r);
    for (int k = 0; k < s->count; k++) {
        double *work = r->work + k * total, held;
        double first = sqrt(pdi_par_dot(ctx, total, work, work)), rounding = pdi_advance_rounding(ctx, r, k, &held);
        r->weight[k] = pd_max(pd_max(sqrt(held), first), rounding / r->desc.tolerance);
        if (!(r->weight[k] > DBL_MIN)) r->weight[k] = 1.0;
    }
    pdi_reactive_trace(r, r->weight);
}

/* ---- Newton's method ---- */

/* What is cut off at 0 has charged c: it becomes neutral, and with activities comes to equilibrium again. */
static pd_status pdi_advance_neutral(const pd_reactive *r, double *c)
{
    const pd_components *s = &r->components;
    double sum[PD_SPECIES_MAX];
    pdi_migration_neutralise(&r->migration, c);
    if (!(s->debye_hueckel > 0.0) || !s->members) return PD_OK;
    pdi_components_compute_totals(s, c, sum);
    PD_TRY(pdi_components_solve(s, sum, c));
    pdi_migration_neutralise(&r->migration, c);
    return PD_OK;
}

/* c: what belongs to the totals of node i of `base` moved by a share of the correction. PD_NOT_CONVERGED: there is no
 * equilibrium. */
static pd_status pdi_advance_node(const pd_reactive *r, int32_t i, double share, double *c)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    const double *delta = r->work + s->count * total;
    double sum[PD_SPECIES_MAX], n[PD_MINERAL_MAX];
    pd_reactive_get(r, r->base, i, c);
    pdi_components_compute_totals(s, c, sum);
    for (int k = 0; k < s->count; k++) sum[k] += share * r->weight[k] * delta[k * total + i];
    if (s->kinetics && share > 0.0) pdi_extents_react(r, i, share, sum);
    if (pdi_extents_equilibrium(r, i, sum, c, n) != PD_OK) return PD_NOT_CONVERGED;
    for (int k = 0; k < r->minerals.count; k++) r->solid[k * total + i] = n[k];
    if (!r->migration.on) return PD_OK;
    r->migration.psi[i] = r->migration.base[i] + share * r->migration.share * r->migration.move[i];
    return pdi_advance_neutral(r, c);
}

/* 1: node i has lost a mineral that it had in `base`, or is full and was not. */
static int pdi_advance_turned(const pd_reactive *r, int32_t i)
{
    double had[PD_MINERAL_MAX], has[PD_MINERAL_MAX];
    pdi_reactive_solids(r, r->solid_base, i, had);
    pdi_reactive_solids(r, r->solid, i, has);
    return pdi_mineral_has_switched(&r->minerals, had, has);
}

/* Node i stops just behind the place between 0 and `high` where it does: beyond it c follows its totals otherwise. */
static void pdi_advance_halt(const pd_reactive *r, int32_t i, double high, double *c)
{
    double low = 0.0;
    for (int cut = 0; cut < PDI_ADVANCE_CUTS; cut++) {
        double part = 0.5 * (low + high);
        if (pdi_advance_node(r, i, part, c) == PD_OK && !pdi_advance_turned(r, i)) low = part;
        else high = part;
    }
    if (pdi_advance_node(r, i, high, c) != PD_OK) *c = NAN;
}

/* The same at all nodes. A node without an equilibrium there goes a part of the way; where none is found c is NaN.
 * halt: one that loses a mineral, or gets full, stops there. */
static void pdi_advance_move(const pd_ctx *ctx, pd_reactive *r, double share, int halt)
{
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], part = share;
        int cut = 0;
        if (r->grid->kind[i] != PD_FLUID) continue;
        while (pdi_advance_node(r, i, part, c) != PD_OK && cut++ < PDI_ADVANCE_CUTS) part *= 0.5;
        if (cut > PDI_ADVANCE_CUTS) *c = NAN;
        else if (halt && pdi_advance_turned(r, i)) pdi_advance_halt(r, i, part, c);
        pdi_reactive_put(r, c, i, r->c);
    }
}

/* The present state becomes `base`. */
static void pdi_advance_mark(const pd_ctx *ctx, pd_reactive *r)
{
    pdi_advance_copy(ctx, r, r->c, r->base, r->solid, r->solid_base);
    if (r->migration.on) pdi_par_copy(ctx, r->grid->total, r->migration.psi, r->migration.base);
    r->migration.share = 1.0;
}

/* With migration: 1: a whole step lowers the residual. Else those that follow move psi by little. */
static int pdi_advance_lift(const pd_ctx *ctx, pd_reactive *r, double before, double *norm)
{
    double most = pdi_migration_largest(&r->migration);
    if (!(most > PDI_ADVANCE_LIFT)) return 0;
    pdi_advance_move(ctx, r, 1.0, 0);
    *norm = pdi_advance_residual(ctx, r);
    if (*norm < before) return 1;
    r->migration.share = PDI_ADVANCE_LIFT / most;
    return 0;
}

/* A step along the correction, halved until the residual falls, or but for a rise that has room. Where a whole one
 * raises it nodes that lose minerals or get full stop there, before any rise is taken. 0: none does. */
static int pdi_advance_shorten(const pd_ctx *ctx, pd_reactive *r, double room, double *norm)
{
    double before = *norm, share = 1.0;
    pdi_advance_mark(ctx, r);
    if (r->migration.on && pdi_advance_lift(ctx, r, before, norm)) return 1;
    for (int halving = 0, halt = 0; halving <= PDI_ADVANCE_HALVINGS; halving++, share *= 0.5) {
        do {
            pdi_advance_move(ctx, r, share, halt);
            *norm = pdi_advance_residual(ctx, r);
            halt = r->minerals.count && !halving && !halt && !(*norm < before);
        } while (halt);
        if (*norm < (halving ? before : room * before)) return 1;
    }
    return 0;
}

/* (T - T_old)/dt + what leaves = sources and reactions, from the present c. PD_NOT_CONVERGED: no solution was found. */
static pd_status pdi_advance_newton(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    double goal = r->exact ? 0.0 : r->desc.tolerance, share = r->linear ? PDI_ADVANCE_SINGLE : PDI_KRYLOV_FORCING_MAX;
    double near = r->surface && r->surface->electrode ? PDI_ADVANCE_NEAR_STEEP : PDI_ADVANCE_NEAR;
    near *= pd_max(r->desc.tolerance, PDI_REACTIVE_TOLERANCE);
    r->dt = dt;
    if (r->surface && r->surface->electrode)
        r->surface->extra = r->migration.tied ? 0.0 : -(r->surface->owed / dt + r->surface->sourced);
    pdi_reactive_guess(r);
    if (r->minerals.count) { /* each node meets the laws of its minerals before nodes exchange anything */
        int64_t size = r->components.count * (int64_t)r->grid->total;
        for (int k = 0; k < r->components.count; k++) r->weight[k] = 1.0;
        pdi_par_zero(ctx, size, r->work + size);
        pdi_advance_mark(ctx, r);
        pdi_advance_move(ctx, r, 0.0, 0);
    }
    pdi_advance_weigh(ctx, r);
    double rate = r->migration.on ? pdi_migration_pace(&r->migration, dt) : 1.0 / dt;
    PD_TRY(pdi_inverse_setup(ctx, &r->inverse, rate, NULL, 0));
    double norm = pdi_advance_residual(ctx, r);
    for (int step = 0; !(norm <= goal); step++) { /* also where it is no number */
        if (step == r->desc.most || !(norm < HUGE_VAL)) return PD_NOT_CONVERGED;
        PD_TRY(pd_check_cancel(ctx, "reactive: Newton", step));
        PD_TRY(pdi_tangent_derive(ctx, r));
        pd_status status = pdi_tangent_direction(ctx, r, share, 0.3 * goal, &result->krylov);
        if (status == PD_ERR_DIVERGED && r->migration.on) return PD_NOT_CONVERGED; /* where there are next to no ions */
        if (status < 0) return status;
        double before = norm, asked = share, rise = r->migration.on ? PDI_ADVANCE_JUMP : PDI_ADVANCE_RISE;
        int falls = pdi_advance_shorten(ctx, r, step < PDI_ADVANCE_FREE ? rise : 1.0, &norm);
        if (norm <= near && norm > PDI_ADVANCE_STALL * before) break;
        if (!falls) return PD_NOT_CONVERGED;
        if (r->migration.on && pdi_advance_grow(ctx, r)) norm = pdi_advance_residual(ctx, r);
        if (!r->linear) share = pdi_krylov_forcing(norm / before);
        result->newton++;
        /* the linear solver has found no step, and is asked for no less in the next one */
        if (status != PD_OK && !(norm < before) && !(norm > before) && !(share > asked)) return PD_NOT_CONVERGED;
    }
    result->residual = norm / r->desc.tolerance;
    return PD_OK;
}

/* The same for the whole step; where that fails, by way of shorter ones from the same start. */
static pd_status pdi_advance_solve(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    double now = dt;
    int steep = r->surface && r->surface->desc.reads_phi, parts = steep ? PDI_ADVANCE_PARTS_STEEP : PDI_ADVANCE_PARTS;
    for (int part = 0; part <= parts;) {
        pd_status status = pdi_advance_newton(ctx, r, now, result);
        if (status < 0) return status;
        if (status == PD_OK && now >= dt) return PD_OK;
        if (status == PD_OK) now = pd_min(now * PDI_ADVANCE_SHORTER, dt);
        else {
            pdi_advance_back(ctx, r, 0);
            now = dt * pow(PDI_ADVANCE_SHORTER, -(double)++part);
            result->parts++;
        }
    }
    return PD_RETRY;
}

/* ---- a step ---- */

/* [mol] Charge of a field of totals; or (undone = 1) of what the stage at hand leaves undone. */
static double pdi_advance_charges(const pd_reactive *r, const double *field, int undone)
{
    int64_t total = r->grid->total;
    pdi_compensated_sum sum = {0.0, 0.0};
    for (int k = 0; k < r->components.count; k++) {
        double z = r->migration.charge[r->components.component_solute[k]] * (undone ? r->dt * r->weight[k] : 1.0);
        for (int32_t i = 0; i < (int32_t)total; i++)
            if (r->grid->kind[i] == PD_FLUID)
                pdi_compensated_sum_add(&sum, pd_grid_circumference(r->grid, i) * z * field[k * total + i]);
    }
    return r->bonds->stencil->volume * pdi_compensated_sum_total(&sum);
}

/* Totals at the start with what is owed. */
static void pdi_advance_start(const pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_tangent_threads(ctx, r);
    (void)nt;
    pdi_advance_back(ctx, r, 1);
    if (r->minerals.count) pdi_par_copy(ctx, r->minerals.count * total, r->solid, r->solid_start);
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_components_compute_totals(s, c, sum);
        for (int k = 0; k < s->count; k++) r->total[k * total + i] = sum[k] + r->carry[k * total + i];
    }
    if (r->surface && r->surface->electrode) r->surface->owed = pdi_advance_charges(r, r->carry, 0);
}

/* carry: what a stage of dt [s] leaves undone. */
static void pdi_advance_owe(pd_reactive *r, double dt)
{
    int64_t total = r->grid->total;
    for (int k = 0; k < r->components.count; k++)
        for (int64_t i = k * total; i < (k + 1) * total; i++) r->carry[i] = dt * r->weight[k] * r->work[i];
}

/* 1: most of what is dissolved, or more, would go into that much of mineral m [mol/m3]; with a speed it has to. */
static int pdi_advance_short(const pd_reactive *r, int m, double grown, const double *dissolved)
{
    const pd_mineral *of = &r->minerals.mineral[m];
    if (!(of->rate > 0.0) && !(of->surface_rate > 0.0)) return 0;
    for (int k = 0; k < r->components.count; k++)
        if (fabs(r->minerals.total_content[m][k]) * grown > 0.5 * fabs(dissolved[k])) return 1;
    return 0;
}

/* What has passed in the first stage, of totals and of minerals. */
static void pdi_advance_slopes(pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_components_compute_totals(s, c, sum);
        for (int k = 0; k < s->count; k++) {
            int64_t at = k * total + i;
            r->slope[at] = sum[k] - r->total[at] + r->dt * r->weight[k] * r->work[at];
        }
        for (int64_t at = i; at < r->minerals.count * total; at += total)
            r->solid_slope[at] = r->solid[at] - r->solid_start[at];
    }
}

/* The totals that the second stage starts from, by what has passed in the first one times `ratio`: also where that
 * leaves totals that no concentrations have. To go on from the nearest ones would make amounts that the stream carries
 * off. */
static void pdi_advance_between(pd_reactive *r, double ratio)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    if (r->surface && r->surface->electrode)
        r->surface->owed += ratio * (pdi_advance_charges(r, r->work, 1) - r->surface->owed);
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MAX], sum[PD_SPECIES_MAX];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pd_reactive_get(r, r->c, i, c);
        pdi_components_compute_totals(s, c, sum);
        for (int k = 0; k < s->count; k++) r->total[k * total + i] += ratio * r->slope[k * total + i];
        for (int m = 0; m < r->minerals.count; m++) {
            int64_t at = m * total + i;
            r->solid_start[at] += ratio * r->solid_slope[at];
            /* what its law asks for and is not dissolved comes with it */
            if (ratio > 1.0 && pdi_advance_short(r, m, ratio * r->solid_slope[at], sum))
                r->solid[at] = r->solid_start[at] + r->solid_slope[at];
        }
    }
}

/* [s] The second stage of a step of dt, after a first one of `stage`. Where (6.12) asks for what no concentrations have
 * and minerals cannot give, it has no solution: it goes on from the first one, as backward Euler over the rest. */
static double pdi_advance_rest(const pd_reactive *r, double dt, double stage)
{
    int64_t total = r->grid->total;
    double size[PD_SPECIES_MAX], at[PD_SPECIES_MAX], n[PD_MINERAL_MAX];
    for (int k = 0; k < r->components.count && r->minerals.count; k++) {
        pdi_bounds of = {0.0, 0.0};
        pdi_bounds_take_all(r->grid, PD_FLUID, r->total + k * total, &of);
        size[k] = PDI_POSITIVITY_SLACK * pd_max(of.high, -of.low);
    }
    for (int32_t i = 0; i < (int32_t)total && r->minerals.count; i++) {
        pd_mineral_start start;
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_tangent_law(r, i, n, &start);
        start.dt = stage;
        for (int k = 0; k < r->components.count; k++)
            at[k] = size[k] + r->total[k * total + i] + PDI_TANGENT_BEYOND * r->slope[k * total + i];
        for (int m = 0; m < r->minerals.count; m++) {
            double grown = r->solid_slope[m * total + i], first = n[m] + grown;
            double had = n[m] + PDI_TANGENT_BEYOND * grown;
            n[m] = had;
            if (!pdi_mineral_try_resume(&start, m, first, PDI_TANGENT_BEYOND, &n[m])) continue;
            for (int k = 0; k < r->components.count; k++) at[k] += r->minerals.total_content[m][k] * (had - n[m]);
        }
        if (pdi_mineral_is_infeasible(&r->components, &r->minerals, &start, at)) return dt - stage;
    }
    return stage;
}

/* What passes in dt [s] at the present state. */
static void pdi_advance_pass(pd_reactive *r, double dt)
{
    pdi_reactive_pass(r, dt);
    if (r->surface) pdi_etch_pass(r->surface, dt);
}

/* A step of two stages (eq. 6.12). PD_NOT_CONVERGED: it is no step, and the balance is as before. */
static pd_status pdi_advance_second(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    double in[PD_SPECIES_MAX], out[PD_SPECIES_MAX], stage = PDI_SDIRK_GAMMA * dt;
    memcpy(in, r->in, sizeof in);
    memcpy(out, r->out, sizeof out);
    PD_TRY(pdi_etch_stage(ctx, r->surface, PDI_SDIRK_GAMMA));
    pd_status status = pdi_advance_newton(ctx, r, stage, result);
    if (status != PD_OK) return status;
    pdi_advance_slopes(r);
    double rest = pdi_advance_rest(r, dt, stage);
    result->euler = rest > stage;
    pdi_advance_pass(r, dt - rest);
    pdi_advance_between(r, result->euler ? 1.0 : PDI_TANGENT_BEYOND);
    PD_TRY(pdi_etch_stage(ctx, r->surface, 1.0));
    status = pdi_advance_newton(ctx, r, rest, result);
    if (status == PD_OK) status = pdi_embedded_error(ctx, r, dt, result->euler, &result->error, &result->krylov);
    if (status == PD_OK && (!pdi_positivity_holds(r, rest) || !pdi_positivity_bounded(r))) status = PD_NOT_CONVERGED;
    if (status != PD_OK) {
        if (r->surface) pdi_etch_begin(r->surface);
        memcpy(r->in, in, sizeof in);
        memcpy(r->out, out, sizeof out);
        return status;
    }
    pdi_advance_owe(r, rest);
    pdi_advance_pass(r, rest);
    return PD_OK;
}

/* A step of dt [s] is done: pores narrow on as they did in it, in the next one. */
static void pdi_advance_stands(pd_reactive *r, double dt)
{
    for (int32_t i = 0; i < r->grid->total && r->pass; i++)
        r->narrow[i] = r->grid->kind[i] == PD_FLUID ? (pd_reactive_film(r, i) - r->filled[i]) / dt : 0.0;
}

static void pdi_advance_pores(pd_reactive *r, double dt)
{
    if (!r->pass) return;
    for (int32_t i = 0; i < r->grid->total; i++)
        r->filled[i] = r->grid->kind[i] == PD_FLUID ? pd_reactive_film(r, i) : 0.0;
    pdi_embedded_open(r, dt, 0);
}

static pd_status pdi_advance_take(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    r->flux.absorb = r->still;
    r->inverse.fresh = 0;
    for (int n = 0; n < r->filters; n++) {
        r->filter[n].inverse.fresh = 0;
        r->filter[n].flux.absorb = r->filter[n].absorb;
    }
    PD_TRY(pdi_flux_refresh(ctx, &r->flux));
    pdi_advance_pores(r, dt);
    if (r->migration.on) PD_TRY(pdi_levels_sources(ctx, r, dt));
    pdi_loops_find(r);
    pdi_flux_rates(ctx, &r->flux, 0.0, r->rates);
    pdi_advance_start(ctx, r);
    if (r->desc.order == 2) {
        pd_status second = pdi_advance_second(ctx, r, dt, result);
        if (second <= PD_OK) return second;
        result->euler = 1;
        pdi_advance_back(ctx, r, 0);
        pdi_advance_start(ctx, r);
    }
    PD_TRY(pdi_etch_stage(ctx, r->surface, 1.0));
    pd_status status = pdi_advance_solve(ctx, r, dt, result);
    if (status == PD_OK && !r->migration.on && pdi_positivity_exceeded(r, dt)) status = PD_RETRY;
    if (status != PD_OK) return status;
    pdi_advance_owe(r, dt);
    pdi_advance_pass(r, dt);
    return PD_OK;
}

pd_status pd_reactive_step(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    pd_arena *arena = pdi_reactive_arena(r);
    memset(result, 0, sizeof *result);
    if (!(dt > 0.0) || !(dt < 1e300))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "the step is %g s, expected a positive one", dt);
    PD_TRY(pdi_arena_acquire(ctx, arena, pdi_reactive_work_list, r));
    if (r->surface) {
        pdi_etch_begin(r->surface);
        r->surface->half = 0.5 * dt;
    }
    pdi_multigrid_set_pointers(&r->inverse.mg);
    if (r->migration.on) pdi_multigrid_set_pointers(&r->migration.mg);
    for (int n = 0; n < r->filters; n++) pdi_multigrid_set_pointers(&r->filter[n].inverse.mg);
    pd_status status = pdi_advance_take(ctx, r, dt, result);
    if (status == PD_OK) pdi_advance_stands(r, dt);
    if (status != PD_OK) {
        pdi_advance_back(ctx, r, 0);
    } else if (r->migration.on) {
        pdi_loops_level(r);
    }
    if (r->surface) r->surface->half = 0.0;
    pdi_krylov_free_growth(ctx, &r->krylov);
    for (int n = 0; n < r->filters; n++) pdi_multigrid_clear_pointers(&r->filter[n].inverse.mg);
    if (r->migration.on) pdi_multigrid_clear_pointers(&r->migration.mg);
    pdi_multigrid_clear_pointers(&r->inverse.mg);
    return pdi_arena_release(ctx, arena, pdi_reactive_work_list, r, status);
}
