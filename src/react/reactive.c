/* reactive: see reactive.h
 *
 * Design: Newton's method in the totals. A step of it moves totals; concentrations follow by the equilibrium of each
 * node, so iterates have no negative ones, and fronts where a species is used up are kinks of c(T) and not of T. The
 * linear systems are solved by GMRES with the derivatives dc/dT of each node.
 */
#include "react/reactive.h"
#include "core/par.h"
#include <float.h>
#include <math.h>
#include <string.h>

#if PDI_FLUX_FIELDS < PD_SPECIES_MOST
#error "the fields of a sweep have to hold all species"
#endif

/* Roundings of what a node exchanges that its balance may be off by. */
#define PDI_REACTIVE_ROUND 32.0
/* So many steps of Newton may raise the residual by this factor; else a step is halved, so many times at most. */
#define PDI_REACTIVE_FREE 12
#define PDI_REACTIVE_RISE 1e3
#define PDI_REACTIVE_HALVINGS 10
/* Tries with shorter steps, and their ratio. */
#define PDI_REACTIVE_PARTS 8
#define PDI_REACTIVE_SHORTER 8.0
/* Share of a residual that the linear solver leaves at least: its basis has single precision. */
#define PDI_REACTIVE_SINGLE 1e-5
/* Basis vectors of the linear solver. */
#define PDI_REACTIVE_BASIS 20
#define PDI_REACTIVE_TOLERANCE 1e-10
#define PDI_REACTIVE_STEPS 60

static pd_arena *pdi_reactive_arena(pd_reactive *r) { return r->desc.arena ? r->desc.arena : &r->own; }

/* The concentrations of a node. */
static inline void pdi_reactive_get(const pd_reactive *r, const double *field, int32_t i, double *c)
{
    for (int n = 0; n < r->components.solutes; n++) c[n] = field[(int64_t)n * r->grid->total + i];
}

static inline void pdi_reactive_put(const pd_reactive *r, const double *c, int32_t i, double *field)
{
    for (int n = 0; n < r->components.solutes; n++) field[(int64_t)n * r->grid->total + i] = c[n];
}

static int pdi_reactive_threads(const pd_ctx *ctx, const pd_reactive *r)
{
    return pdi_par_threads(ctx, (int64_t)r->grid->total * r->components.solutes * r->components.count);
}

/* Images of several fields. */
static void pdi_reactive_images(const pd_reactive *r, double *fields)
{
    for (int n = 0; n < r->components.solutes; n++)
        pd_ghosts_scalar(&r->bonds->ghosts, fields + (int64_t)n * r->grid->total);
}

/* y [components]: what leaves by the fields, over the weights. */
static void pdi_reactive_leave(const pd_ctx *ctx, const pd_reactive *r, const double *fields, const double *wall,
                               double *y)
{
    const pd_components *s = &r->components;
    double weight[PD_SPECIES_MOST * PD_SPECIES_MOST];
    pdi_flux_fields f;
    for (int k = 0; k < s->count; k++)
        for (int n = 0; n < s->solutes; n++) weight[k * s->solutes + n] = s->m[k][n] / r->weight[k];
    f.count = s->solutes;
    f.sums = s->count;
    f.ratio = r->ratio;
    f.wall = wall;
    f.c = fields;
    f.weight = weight;
    f.y = y;
    pdi_flux_apply_fields(ctx, &r->flux, &f);
}

/* What the balances of node i lack beside what leaves: in time, by sources and kinetic reactions [mol/m3/s]. */
static void pdi_reactive_lack(const pd_reactive *r, int32_t i, double *lack)
{
    const pd_components *s = &r->components;
    double c[PD_SPECIES_MOST], source[PD_SPECIES_MOST], gain[PD_SPECIES_MOST];
    pdi_reactive_get(r, r->c, i, c);
    pdi_reactive_get(r, r->source, i, source);
    pdi_components_totals(s, c, lack);
    pdi_components_totals(s, source, gain);
    for (int k = 0; k < s->count; k++)
        lack[k] = (r->total[(int64_t)k * r->grid->total + i] - lack[k]) / r->dt + gain[k];
    for (int n = 0; n < s->kinetics; n++) {
        double speed = pdi_components_speed(s, &s->kinetic[n], c, NULL);
        for (int k = 0; k < s->count; k++) lack[k] += s->kinetic[n].gain[k] * speed;
    }
}

/* work = what the balances lack over their weights; its norm. */
static double pdi_reactive_residual(const pd_ctx *ctx, pd_reactive *r)
{
    int64_t total = r->grid->total;
    int count = r->components.count, nt = pdi_reactive_threads(ctx, r);
    double *work = r->work;
    (void)nt;
    pdi_reactive_images(r, r->c);
    pdi_reactive_leave(ctx, r, r->c, r->wall, work);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double lack[PD_SPECIES_MOST];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_reactive_lack(r, i, lack);
        for (int k = 0; k < count; k++) work[k * total + i] = lack[k] / r->weight[k] - work[k * total + i];
    }
    return sqrt(pdi_par_dot(ctx, count * total, work, work));
}

/* Weights of the balances: what is there over the step, or what they lack at first, or the rounding of both. */
static void pdi_reactive_weigh(const pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    for (int k = 0; k < s->count; k++) r->weight[k] = 1.0;
    pdi_reactive_residual(ctx, r);
    for (int k = 0; k < s->count; k++) {
        double *work = r->work + k * total, *size = r->part_of;
        double first = sqrt(pdi_par_dot(ctx, total, work, work)), held = 0.0, rounding = 0.0;
        for (int32_t i = 0; i < (int32_t)total; i++) {
            double sum = 0.0;
            if (r->grid->kind[i] != PD_FLUID) continue;
            for (int n = 0; n < s->solutes; n++) sum += fabs(s->m[k][n]) * r->c[n * total + i];
            size[i] = sum * (1.0 / r->dt + r->rates[i]);
            held += sum / r->dt * (sum / r->dt);
        }
        rounding = PDI_REACTIVE_ROUND * DBL_EPSILON * sqrt(pdi_par_dot(ctx, total, size, size));
        r->weight[k] = fmax(fmax(sqrt(held), first), rounding / r->desc.tolerance);
        if (!(r->weight[k] > DBL_MIN)) r->weight[k] = 1.0;
    }
}

/* ---- linear systems ---- */

typedef struct pdi_reactive_user {
    pd_ctx *ctx;
    pd_reactive *r;
} pdi_reactive_user;

/* Derivatives at the present concentrations, and the preconditioner that follows from them. */
static pd_status pdi_reactive_derive(pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_reactive_threads(ctx, r), tables = s->live * pdi_components_columns(s);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MOST], slope[PD_SPECIES_MOST], one[PD_SPECIES_MOST], along[PD_SPECIES_MOST];
        float *by = r->by + (int64_t)i * r->slots, *row = by + tables;
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_reactive_get(r, r->c, i, c);
        pdi_components_derive(s, c, by);
        for (int n = 0; n < s->kinetics; n++, row += s->count) {
            double rate = 0.0;
            pdi_components_speed(s, &s->kinetic[n], c, slope);
            for (int k = 0; k < s->count; k++) {
                double sum = 0.0;
                memset(one, 0, sizeof one);
                one[k] = 1.0;
                pdi_components_follow(s, by, one, along);
                for (int m = 0; m < s->solutes; m++) sum += slope[m] * along[m];
                row[k] = (float)sum;
                rate -= (double)row[k] * s->kinetic[n].gain[k];
            }
            r->filter[n].absorb[i] = fmax(rate, 0.0);
        }
    }
    for (int n = 0; n < s->kinetics; n++)
        PDI_TRY(pdi_inverse_setup(ctx, &r->filter[n].inverse, 1.0 / r->dt, NULL, 0));
    return PD_OK;
}

/* y = J x, in totals over weights. */
static void pdi_reactive_apply(void *user, const double *x, double *y)
{
    pdi_reactive_user *u = (pdi_reactive_user *)user;
    pd_reactive *r = u->r;
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_reactive_threads(u->ctx, r), tables = s->live * pdi_components_columns(s);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double along[PD_SPECIES_MOST], c[PD_SPECIES_MOST];
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) along[k] = r->weight[k] * x[k * total + i];
        pdi_components_follow(s, r->by + (int64_t)i * r->slots, along, c);
        pdi_reactive_put(r, c, i, r->move);
    }
    pdi_reactive_images(r, r->move);
    pdi_reactive_leave(u->ctx, r, r->move, r->closed, y);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        const float *row = r->by + (int64_t)i * r->slots + tables;
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < s->count; k++) y[k * total + i] += x[k * total + i] / r->dt;
        for (int n = 0; n < s->kinetics; n++, row += s->count) {
            double speed = 0.0;
            for (int k = 0; k < s->count; k++) speed += (double)row[k] * r->weight[k] * x[k * total + i];
            for (int k = 0; k < s->count; k++) y[k * total + i] -= s->kinetic[n].gain[k] * speed / r->weight[k];
        }
    }
}

/* Split off what kinetic reaction n brings to rest: x loses it, part_of is its extent. */
static void pdi_reactive_split(const pd_ctx *ctx, pd_reactive *r, int n, double *x)
{
    const pd_components *s = &r->components;
    const double *gain = s->kinetic[n].gain;
    int64_t total = r->grid->total;
    int nt = pdi_reactive_threads(ctx, r), at = s->live * pdi_components_columns(s) + n * s->count;
    (void)nt;
    PDI_PARALLEL_FOR(nt)
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

/* y near J^-1 x: each component by itself with the mean diffusivity; what kinetic reactions bring to rest, with their
 * rate. */
static void pdi_reactive_precondition(void *user, const double *x, double *y)
{
    pdi_reactive_user *u = (pdi_reactive_user *)user;
    pd_reactive *r = u->r;
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    double *rest = r->move;
    if (!s->kinetics) {
        for (int k = 0; k < s->count; k++) pdi_inverse_apply(u->ctx, &r->inverse, x + k * total, y + k * total);
        return;
    }
    pdi_par_copy(u->ctx, s->count * total, x, rest);
    pdi_par_zero(u->ctx, s->count * total, y);
    for (int n = 0; n < s->kinetics; n++) {
        pdi_reactive_split(u->ctx, r, n, rest);
        pdi_inverse_apply(u->ctx, &r->filter[n].inverse, r->part_of, r->rates + total);
        for (int k = 0; k < s->count; k++)
            pdi_par_axpy(u->ctx, total, s->kinetic[n].gain[k] / r->weight[k], r->rates + total, y + k * total);
    }
    for (int k = 0; k < s->count; k++) {
        pdi_inverse_apply(u->ctx, &r->inverse, rest + k * total, r->part_of);
        pdi_par_axpy(u->ctx, total, 1.0, r->part_of, y + k * total);
    }
}

/* The correction behind the residual, to a share of it or to `goal`. */
static pd_status pdi_reactive_direction(pd_ctx *ctx, pd_reactive *r, double share, double goal,
                                        pd_reactive_result *result)
{
    pdi_reactive_user user;
    pd_krylov_result linear;
    pd_arena *arena = pdi_reactive_arena(r);
    user.ctx = ctx;
    user.r = r;
    r->krylov.desc.rtol = share;
    r->krylov.desc.atol = goal;
    PDI_TRY(pdi_reactive_derive(ctx, r));
    PDI_TRY(pdi_arena_lend(ctx, arena, pdi_krylov_list, &r->krylov));
    pd_status status = pdi_krylov_solve(ctx, &r->krylov, pdi_reactive_apply, pdi_reactive_precondition, &user, r->work,
                                        r->work + r->components.count * (int64_t)r->grid->total, &linear);
    result->krylov += linear.iterations;
    return pdi_arena_return(ctx, arena, pdi_krylov_list, &r->krylov, status);
}

/* ---- Newton's method ---- */

/* c: what belongs to the totals of `base` moved by a share of the correction. Where no equilibrium is found it is
 * NaN. */
static void pdi_reactive_move(const pd_ctx *ctx, pd_reactive *r, double share)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    const double *delta = r->work + s->count * total;
    int nt = pdi_reactive_threads(ctx, r);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MOST], sum[PD_SPECIES_MOST];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_reactive_get(r, r->base, i, c);
        pdi_components_totals(s, c, sum);
        for (int k = 0; k < s->count; k++) sum[k] += share * r->weight[k] * delta[k * total + i];
        if (pdi_components_solve(s, sum, c) != PD_OK) c[0] = NAN;
        pdi_reactive_put(r, c, i, r->c);
    }
}

/* A step along the correction, halved until the residual falls, or but for a rise that has room. 0: none does. */
static int pdi_reactive_shorten(const pd_ctx *ctx, pd_reactive *r, double room, double *norm)
{
    double before = *norm, share = 1.0;
    pdi_par_copy(ctx, r->components.solutes * (int64_t)r->grid->total, r->c, r->base);
    for (int halving = 0; halving <= PDI_REACTIVE_HALVINGS; halving++, share *= 0.5) {
        pdi_reactive_move(ctx, r, share);
        *norm = pdi_reactive_residual(ctx, r);
        if (*norm < (halving ? before : room * before)) return 1;
    }
    return 0;
}

/* (T - T_old)/dt + what leaves = sources and reactions, from the present c. PD_NOT_CONVERGED: no solution was found. */
static pd_status pdi_reactive_newton(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    double goal = r->desc.tolerance, share = r->linear ? PDI_REACTIVE_SINGLE : PDI_KRYLOV_LOOSE;
    r->dt = dt;
    pdi_reactive_weigh(ctx, r);
    PDI_TRY(pdi_inverse_setup(ctx, &r->inverse, 1.0 / dt, NULL, 0));
    double norm = pdi_reactive_residual(ctx, r);
    for (int step = 0; norm > goal; step++) {
        if (step == r->desc.most || !(norm < HUGE_VAL)) return PD_NOT_CONVERGED;
        PDI_TRY(pdi_poll(ctx, "reactive: Newton", step));
        pd_status status = pdi_reactive_direction(ctx, r, share, 0.3 * goal, result);
        if (status < 0) return status;
        double before = norm;
        if (!pdi_reactive_shorten(ctx, r, step < PDI_REACTIVE_FREE ? PDI_REACTIVE_RISE : 1.0, &norm)) return PD_NOT_CONVERGED;
        if (!r->linear) share = pdi_krylov_forcing(norm / before);
        result->newton++;
    }
    result->residual = norm / goal;
    return PD_OK;
}

/* The same for the whole step; where that fails, by way of shorter ones from the same start. */
static pd_status pdi_reactive_solve(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    double now = dt;
    for (int part = 0; part <= PDI_REACTIVE_PARTS;) {
        pd_status status = pdi_reactive_newton(ctx, r, now, result);
        if (status < 0) return status;
        if (status == PD_OK && now >= dt) return PD_OK;
        if (status == PD_OK) now = fmin(now * PDI_REACTIVE_SHORTER, dt);
        else {
            pdi_par_copy(ctx, r->components.solutes * (int64_t)r->grid->total, r->begin, r->c);
            now = dt * pow(PDI_REACTIVE_SHORTER, -(double)++part);
            result->parts++;
        }
    }
    return PD_RETRY;
}

/* ---- a step ---- */

static void pdi_reactive_work_list(pdi_owner *owner, void *object)
{
    pd_reactive *reactive = (pd_reactive *)object;
    const pd_components *s = &reactive->components;
    int64_t total = reactive->grid->total;
    PDI_RAW(owner, reactive, begin, s->solutes * total, "mol/m3");
    PDI_RAW(owner, reactive, base, s->solutes * total, "mol/m3");
    PDI_RAW(owner, reactive, total, s->count * total, "mol/m3");
    PDI_ARRAY(owner, reactive, move, s->solutes * total, "mol/m3");
    PDI_ARRAY(owner, reactive, work, 2 * s->count * total, "");
    PDI_ARRAY(owner, reactive, part_of, total, "mol/m3/s");
    PDI_ARRAY(owner, reactive, rates, 2 * total, "1/s");
    PDI_RAW(owner, reactive, by, reactive->slots * total, "");
    PDI_ARRAY(owner, reactive, still, total, "1/s");
    pdi_flux_list(owner, &reactive->flux);
    pdi_inverse_list(owner, &reactive->inverse);
    for (int n = 0; n < s->kinetics; n++) {
        pd_reactive_filter *filter = &reactive->filter[n];
        PDI_ARRAY(owner, filter, absorb, total, "1/s");
        pdi_inverse_list(owner, &filter->inverse);
    }
}

/* Totals at the start with what is owed. */
static void pdi_reactive_start(const pd_ctx *ctx, pd_reactive *r)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    int nt = pdi_reactive_threads(ctx, r);
    (void)nt;
    pdi_par_copy(ctx, s->solutes * total, r->c, r->begin);
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double c[PD_SPECIES_MOST], sum[PD_SPECIES_MOST];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_reactive_get(r, r->c, i, c);
        pdi_components_totals(s, c, sum);
        for (int k = 0; k < s->count; k++) r->total[k * total + i] = sum[k] + r->carry[k * total + i];
    }
}

/* What passes the sides and held walls, and what sources give, in the step. */
static void pdi_reactive_pass(pd_reactive *r, double dt)
{
    const pd_components *s = &r->components;
    const pd_grid *grid = r->grid;
    int64_t total = grid->total;
    pdi_sum in[PD_SPECIES_MOST], out[PD_SPECIES_MOST];
    memset(in, 0, sizeof in);
    memset(out, 0, sizeof out);
    for (int32_t i = 0; i < grid->total; i++) {
        double around = pdi_grid_circumference(grid, i);
        if (grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < s->solutes; n++) {
            pdi_sum_add(&in[n], r->source[n * total + i] * around);
            if (!r->diffusion.wall_rate || !(r->wall[n] == r->wall[n])) continue;
            double gain = r->ratio[n] * r->diffusion.wall_rate[i] * (r->wall[n] - r->c[n * total + i]);
            pdi_sum_add(gain > 0.0 ? &in[n] : &out[n], fabs(gain) * around);
        }
    }
    for (int32_t p = 0; p < r->boundary.count; p++) {
        int32_t i = r->boundary.node[p];
        double around = pdi_grid_circumference(grid, i), flux, bond, upwind;
        for (int k = 0; k < r->bonds->stencil->count; k++) {
            int32_t j = i + r->bonds->paths.shift[k];
            if (!pdi_flux_open(&r->flux, i, k)) continue;
            if (grid->kind[j] != PD_OUTLET && grid->kind[j] != PD_INLET) continue;
            pdi_flux_bond(&r->flux, i, k, &flux, &bond, &upwind);
            for (int n = 0; n < s->solutes; n++) {
                double here = r->c[n * total + i], there = grid->kind[j] == PD_OUTLET ? here : r->c[n * total + j];
                double leave = 0.5 * flux * (here + there) - fmax(fabs(0.5 * flux), r->ratio[n] * bond) *
                                                             (there - here);
                pdi_sum_add(grid->kind[j] == PD_OUTLET ? &out[n] : &in[n],
                            around * (grid->kind[j] == PD_OUTLET ? leave : -leave));
            }
        }
    }
    for (int n = 0; n < s->solutes; n++) {
        r->in[n] += dt * r->bonds->stencil->volume * pdi_sum_total(&in[n]);
        r->out[n] += dt * r->bonds->stencil->volume * pdi_sum_total(&out[n]);
    }
}

static pd_status pdi_reactive_take(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    int64_t total = r->grid->total;
    int count = r->components.count;
    r->flux.absorb = r->still;
    r->inverse.fresh = 0;
    for (int n = 0; n < r->components.kinetics; n++) {
        r->filter[n].inverse.fresh = 0;
        r->filter[n].flux.absorb = r->filter[n].absorb;
    }
    PDI_TRY(pdi_flux_refresh(ctx, &r->flux));
    pdi_flux_rates(ctx, &r->flux, 0.0, r->rates);
    pdi_reactive_start(ctx, r);
    pd_status status = pdi_reactive_solve(ctx, r, dt, result);
    if (status != PD_OK) {
        pdi_par_copy(ctx, r->components.solutes * total, r->begin, r->c);
        return status;
    }
    for (int k = 0; k < count; k++)
        for (int64_t i = 0; i < total; i++) r->carry[k * total + i] = dt * r->weight[k] * r->work[k * total + i];
    pdi_reactive_pass(r, dt);
    return PD_OK;
}

pd_status pd_reactive_step(pd_ctx *ctx, pd_reactive *r, double dt, pd_reactive_result *result)
{
    pd_arena *arena = pdi_reactive_arena(r);
    memset(result, 0, sizeof *result);
    if (!(dt > 0.0) || !(dt < 1e300))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "the step is %g s, expected a positive one", dt);
    PDI_TRY(pdi_arena_lend(ctx, arena, pdi_reactive_work_list, r));
    pdi_multigrid_open(&r->inverse.mg);
    for (int n = 0; n < r->components.kinetics; n++) pdi_multigrid_open(&r->filter[n].inverse.mg);
    pd_status status = pdi_reactive_take(ctx, r, dt, result);
    pdi_krylov_trim(ctx, &r->krylov);
    for (int n = 0; n < r->components.kinetics; n++) pdi_multigrid_close(&r->filter[n].inverse.mg);
    pdi_multigrid_close(&r->inverse.mg);
    return pdi_arena_return(ctx, arena, pdi_reactive_work_list, r, status);
}

PDI_COLD_BEGIN
/* ---- what it holds ---- */

double *pd_reactive_field(pd_reactive *r, int species)
{
    int n = r->components.place[species];
    return n < 0 ? NULL : r->c + (int64_t)n * r->grid->total;
}

double *pd_reactive_source(pd_reactive *r, int species)
{
    int n = r->components.place[species];
    return n < 0 ? NULL : r->source + (int64_t)n * r->grid->total;
}

double pd_reactive_ph(const pd_reactive *r, int32_t node)
{
    double c[PD_SPECIES_MOST];
    if (r->proton < 0) return NAN;
    pdi_reactive_get(r, r->c, node, c);
    return 3.0 - (log(c[r->proton]) + pdi_components_activity(&r->components, c)) / log(10.0);
}

/* Amounts of a row in the fluid: with the sizes of its terms, or of what is carried. */
static double pdi_reactive_amount(const pd_reactive *r, int row, int carried, double *size)
{
    const pd_components *s = &r->components;
    int64_t total = r->grid->total;
    pdi_sum sum = {0.0, 0.0};
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double around = pdi_grid_circumference(r->grid, i);
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < (carried ? s->count : s->solutes); n++) {
            double part = r->part[row][carried ? s->master[n] : n];
            double term = around * part * (carried ? r->carry : r->c)[n * total + i];
            pdi_sum_add(&sum, term);
            *size += fabs(term) * r->bonds->stencil->volume;
        }
    }
    return pdi_sum_total(&sum) * r->bonds->stencil->volume;
}

void pd_reactive_balance_of(pd_ctx *ctx, const pd_reactive *r, int row, pd_reactive_balance *b)
{
    double size = 0.0;
    (void)ctx;
    memset(b, 0, sizeof *b);
    memcpy(b->name, r->name[row], sizeof b->name);
    b->start = r->start[row];
    b->dissolved = pdi_reactive_amount(r, row, 0, &size);
    b->carry = pdi_reactive_amount(r, row, 1, &size);
    for (int n = 0; n < r->components.solutes; n++) {
        b->in += r->part[row][n] * r->in[n];
        b->out += r->part[row][n] * r->out[n];
        size += fabs(r->part[row][n]) * (fabs(r->in[n]) + fabs(r->out[n]));
    }
    b->imbalance = b->dissolved + b->carry + b->out - b->in - b->start;
    b->relative = size > 0.0 ? fabs(b->imbalance) / size : 0.0;
}

/* A row of the balance: `times` atoms of an element less `less` of another (0: none). */
static void pdi_reactive_row(const pd_species *species, int count, int element, int less, int times, pd_reactive *r)
{
    char one[8], other[8];
    if (r->rows == PD_REACTIVE_ROWS - 1) return;
    pdi_species_symbol(element, one);
    r->name[r->rows][0] = 0;
    pdi_append(r->name[r->rows], PD_REACTIVE_NAME, "%s", one);
    if (less) {
        pdi_species_symbol(less, other);
        pdi_append(r->name[r->rows], PD_REACTIVE_NAME, "-%d%s", times, other);
    }
    for (int i = 0; i < count; i++) {
        int n = r->components.place[i];
        if (n < 0) continue;
        r->part[r->rows][n] = pdi_species_atoms(&species[i], element);
        if (less) r->part[r->rows][n] -= times * pdi_species_atoms(&species[i], less);
    }
    r->rows++;
}

/* Elements that the solvent has not, in order; then of those that it has one less another; then the charge. */
static void pdi_reactive_rows(const pd_species *species, int count, pd_reactive *r)
{
    const pd_species *solvent = NULL;
    for (int i = 0; i < count; i++)
        if (species[i].phase == PD_PHASE_SOLVENT) solvent = &species[i];
    for (int e = 1; e < 119; e++) {
        int there = 0;
        for (int i = 0; i < count; i++)
            if (species[i].phase == PD_PHASE_SOLUTE && pdi_species_atoms(&species[i], e)) there = 1;
        if (there && !(solvent && pdi_species_atoms(solvent, e))) pdi_reactive_row(species, count, e, 0, 0, r);
    }
    for (int e = 1; solvent && e < 119; e++) { /* H2O: H less 2 O */
        int last = solvent->element[solvent->elements - 1], atoms = pdi_species_atoms(solvent, last);
        if (e == last || !pdi_species_atoms(solvent, e) || atoms != 1) continue;
        pdi_reactive_row(species, count, e, last, pdi_species_atoms(solvent, e), r);
    }
    pdi_append(r->name[r->rows], PD_REACTIVE_NAME, "charge");
    for (int n = 0; n < r->components.solutes; n++) r->part[r->rows][n] = r->components.charge[n];
    r->rows++;
}

/* ---- the object ---- */

/* Bring c [solutes] to the equilibrium of its totals. */
static pd_status pdi_reactive_settle(pd_ctx *ctx, const pd_reactive *r, const char *where, double *c)
{
    double total[PD_SPECIES_MOST];
    for (int n = 0; n < r->components.solutes; n++)
        if (!(c[n] >= 0.0) || !(c[n] < 1e100))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s: solute %d of %d has %g mol/m3, expected a finite "
                            "value of at least 0", where, n + 1, r->components.solutes, c[n]);
    pdi_components_totals(&r->components, c, total);
    if (pdi_components_solve(&r->components, total, c) == PD_OK) return PD_OK;
    return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s: no equilibrium of the concentrations was found", where);
}

static void pdi_reactive_fill(pd_reactive *r, uint8_t kind, const double *c)
{
    for (int32_t i = 0; i < r->grid->total; i++)
        if (r->grid->kind[i] == kind) pdi_reactive_put(r, c, i, r->c);
}

pd_status pd_reactive_begin(pd_ctx *ctx, pd_reactive *r)
{
    double size = 0.0;
    for (int32_t i = 0; i < r->grid->total; i++) {
        double c[PD_SPECIES_MOST];
        if (r->grid->kind[i] != PD_FLUID) continue;
        pdi_reactive_get(r, r->c, i, c);
        PDI_TRY(pdi_reactive_settle(ctx, r, "a node", c));
        pdi_reactive_put(r, c, i, r->c);
    }
    pdi_reactive_fill(r, PD_INLET, r->inlet);
    memset(r->carry, 0, (size_t)r->components.count * (size_t)r->grid->total * sizeof *r->carry);
    memset(r->in, 0, sizeof r->in);
    memset(r->out, 0, sizeof r->out);
    for (int row = 0; row < r->rows; row++) r->start[row] = pdi_reactive_amount(r, row, 0, &size);
    return PD_OK;
}

PDI_FN void pdi_reactive_list(pdi_owner *owner, void *object)
{
    pd_reactive *reactive = (pd_reactive *)object;
    if (!reactive->grid) return;
    int64_t total = reactive->grid->total;
    PDI_STATE(owner, reactive, c, reactive->components.solutes * total, "mol/m3");
    PDI_STATE(owner, reactive, carry, reactive->components.count * total, "mol/m3");
    PDI_ARRAY(owner, reactive, source, reactive->components.solutes * total, "mol/m3/s");
    if (reactive->components.kinetics) PDI_ARRAY(owner, reactive, filter, reactive->components.kinetics, "");
}

/* Values of the desc in the order of the solutes. */
static void pdi_reactive_pick(const pd_reactive *r, const double *of, double *c)
{
    for (int i = 0; i < r->desc.count; i++)
        if (r->components.place[i] >= 0) c[r->components.place[i]] = of ? of[i] : 0.0;
}

/* The mean diffusivity of the fluxes, and what the species have of it. */
static pd_status pdi_reactive_diffusivities(pd_ctx *ctx, const pd_species *species, pd_reactive *r)
{
    double least = HUGE_VAL, most = 0.0, of[PD_SPECIES_MOST];
    int even = 1;
    for (int i = 0; i < r->desc.count; i++) {
        int n = r->components.place[i];
        double d = species[i].diffusivity;
        if (n < 0) continue;
        if (!(d >= 0.0) || !(d < 1e100))
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "%s has D = %g m2/s, expected a finite value of at least "
                            "0", species[i].name, d);
        of[n] = d;
        if (d > 0.0) least = fmin(least, d);
        most = fmax(most, d);
        if (strcmp(species[i].name, "H+") == 0) r->proton = n;
    }
    r->diffusion.desc.diffusivity = most > 0.0 ? (least < most ? sqrt(least * most) : most) : 0.0;
    for (int n = 0; n < r->components.solutes; n++) {
        r->ratio[n] = most > 0.0 ? of[n] / r->diffusion.desc.diffusivity : 0.0;
        if (n && !(of[n] >= of[0] && of[n] <= of[0])) even = 0;
    }
    r->linear = !r->components.kinetics && (even || !r->components.joined);
    return PD_OK;
}

static void pdi_reactive_krylov(const pd_reactive *r, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->components = r->components.count;
    kd->n = (int64_t)kd->components * r->grid->total;
    kd->spans = &r->bonds->spans;
    kd->restart = PDI_REACTIVE_BASIS;
    kd->most = 10 * PDI_REACTIVE_BASIS;
    kd->flexible = 1;
    kd->compressed = 1;
    kd->zero_guess = 1;
}

static size_t pdi_reactive_room(pd_reactive *r)
{
    size_t setup = pdi_inverse_room(&r->inverse), linear = pdi_arena_bytes(pdi_krylov_list, &r->krylov);
    return pdi_arena_bytes(pdi_reactive_work_list, r) + (setup > linear ? setup : linear);
}

static pd_status pdi_reactive_solvers(pd_ctx *ctx, pd_reactive *r)
{
    pd_multigrid_desc md;
    pd_krylov_desc kd;
    pdi_compact_multigrid(r->grid, &md);
    md.symmetric = r->flow == NULL;
    md.arena = pdi_reactive_arena(r);
    r->inverse.flux = &r->flux;
    r->inverse.spread = 1.0;
    PDI_TRY(pdi_inverse_plan(ctx, &md, &r->inverse));
    for (int n = 0; n < r->components.kinetics; n++) {
        r->filter[n].flux = r->flux;
        r->filter[n].inverse.flux = &r->filter[n].flux;
        r->filter[n].inverse.spread = 1.0;
        PDI_TRY(pdi_inverse_plan(ctx, &md, &r->filter[n].inverse));
    }
    pdi_reactive_krylov(r, &kd);
    PDI_TRY(pdi_krylov_plan(ctx, &kd, &r->krylov));
    PDI_TRY(pdi_krylov_prepare(ctx, &kd, &r->krylov));
    return pdi_arena_fit(ctx, pdi_reactive_arena(r), pdi_reactive_room(r));
}

static pd_status pdi_reactive_make(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                                   const pd_reactive_desc *desc, pd_reactive *r)
{
    double c[PD_SPECIES_MOST];
    memset(r, 0, sizeof *r);
    PDI_TRY(pdi_components_build(ctx, desc->species, desc->count, desc->reactions, desc->reaction_count, desc->activity,
                                desc->temperature, &r->components));
    if (!(desc->tolerance >= 0.0) || !(desc->tolerance < 1.0) || desc->most < 0 || !desc->initial)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "tolerance %g, %d steps of Newton, %s concentrations at the "
                        "start: expected a tolerance of 0 to 1, at least 0 steps, and concentrations",
                        desc->tolerance, desc->most, desc->initial ? "with" : "without");
    r->desc = *desc;
    if (!(r->desc.tolerance > 0.0)) r->desc.tolerance = PDI_REACTIVE_TOLERANCE;
    if (!r->desc.most) r->desc.most = PDI_REACTIVE_STEPS;
    r->grid = grid;
    r->bonds = bonds;
    r->flow = flow;
    r->proton = -1;
    r->slots = r->components.live * pdi_components_columns(&r->components) +
               r->components.kinetics * r->components.count;
    if (!r->slots) r->slots = 1;
    PDI_TRY(pdi_reactive_diffusivities(ctx, desc->species, r));
    pdi_reactive_rows(desc->species, desc->count, r);
    pdi_reactive_pick(r, desc->wall, r->wall);
    for (int n = 0; n < r->components.solutes; n++) {
        if (!desc->held || !desc->wall) r->wall[n] = NAN;
        r->closed[n] = r->wall[n] == r->wall[n] ? 0.0 : NAN;
        if (r->wall[n] < 0.0 || r->wall[n] > 1e100)
            return pdi_fail(ctx, PD_ERR_ARGUMENT, "reactive", "a wall holds %g mol/m3, expected a finite value of at "
                            "least 0", r->wall[n]);
    }
    PDI_TRY(pdi_owner_build(ctx, pdi_reactive_list, r));
    pdi_reactive_pick(r, desc->inlet ? desc->inlet : desc->initial, r->inlet);
    pdi_reactive_pick(r, desc->initial, c);
    PDI_TRY(pdi_reactive_settle(ctx, r, "inlet", r->inlet));
    PDI_TRY(pdi_reactive_settle(ctx, r, "initial", c));
    pdi_reactive_fill(r, PD_FLUID, c);
    pd_diffusion_desc dd;
    memset(&dd, 0, sizeof dd);
    dd.diffusivity = r->diffusion.desc.diffusivity;
    dd.held = desc->wall ? desc->held : NULL;
    dd.user = desc->user;
    PDI_TRY(pdi_diffusion_build(ctx, bonds, &dd, &r->diffusion));
    PDI_TRY(pdi_boundary_build(ctx, bonds, &r->boundary));
    r->flux.bonds = bonds;
    r->flux.flow = flow;
    r->flux.diffusion = &r->diffusion;
    r->flux.boundary = &r->boundary;
    PDI_TRY(pdi_flux_build(ctx, &r->flux));
    PDI_TRY(pdi_reactive_solvers(ctx, r));
    r->desc.species = NULL;
    r->desc.reactions = NULL;
    r->desc.initial = r->desc.inlet = r->desc.wall = NULL;
    return pd_reactive_begin(ctx, r);
}

pd_status pd_reactive_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_flow *flow,
                            const pd_reactive_desc *desc, pd_reactive *r)
{
    pd_status status = pdi_reactive_make(ctx, grid, bonds, flow, desc, r);
    if (status < 0) pd_reactive_free(ctx, r);
    return status;
}

pd_status pd_reactive_update(pd_ctx *ctx, pd_reactive *r)
{
    PDI_TRY(pdi_diffusion_update(ctx, &r->diffusion));
    PDI_TRY(pdi_boundary_update(ctx, &r->boundary));
    pdi_reactive_fill(r, PD_INLET, r->inlet);
    return pdi_flux_fit(ctx, &r->flux);
}

void pd_reactive_free(pd_ctx *ctx, pd_reactive *r)
{
    pdi_flux_free(ctx, &r->flux);
    pdi_boundary_free(ctx, &r->boundary);
    pdi_diffusion_free(ctx, &r->diffusion);
    pdi_inverse_free(ctx, &r->inverse);
    for (int n = 0; n < r->components.kinetics && r->filter; n++) pdi_inverse_free(ctx, &r->filter[n].inverse);
    pdi_krylov_free(ctx, &r->krylov);
    pdi_owner_free(ctx, pdi_reactive_list, r);
    pd_arena_free(ctx, &r->own);
    memset(r, 0, sizeof *r);
}
PDI_COLD_END
