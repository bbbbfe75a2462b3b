/* time_loop: see time_loop.h */
#include "couple/time_loop.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Default of rtol (error in time of the lost metal) is `fraction` over this number. */
#define PDI_TIME_LOOP_RTOL_RATIO 25.0

pd_status pd_time_loop_build(pd_ctx *ctx, const pd_time_loop_desc *desc, pd_grid *grid, pd_bonds *bonds,
                             pd_time_loop *c)
{
    memset(c, 0, sizeof *c);
    if (!(desc->fraction >= 0.0) || desc->fraction > 1.0 || !(desc->rtol >= 0.0) || desc->rtol > 1.0 ||
        !(desc->max_step >= 0.0) || !(desc->ledger_tolerance >= 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "time_loop",
                       "fraction %g and rtol %g must lie in [0, 1], max_step %g s be at least 0", desc->fraction,
                       desc->rtol, desc->max_step);
    c->desc = *desc;
    if (!(c->desc.fraction > 0.0)) c->desc.fraction = 0.1;
    if (!(c->desc.rtol > 0.0)) c->desc.rtol = c->desc.fraction / PDI_TIME_LOOP_RTOL_RATIO;
    if (!(c->desc.ledger_tolerance > 0.0)) c->desc.ledger_tolerance = 1e-10;
    c->grid = grid;
    c->bonds = bonds;
    c->solid_nodes_start = grid->solid_count;
    return PD_OK;
}

/* Index of the ledger of an element, found by its name; c->elements: there is none yet. */
static int pdi_time_loop_find_ledger(const pd_time_loop *c, const pd_element *element)
{
    int e = 0;
    while (e < c->elements && strcmp(c->element[e].name, element->name) != 0) e++;
    return e;
}

pd_status pd_time_loop_add_process(pd_ctx *ctx, pd_time_loop *c, pd_physics process)
{
    if (c->count == PD_TIME_LOOP_MAX_PROCESSES)
        return pd_fail(ctx, PD_ERR_SIZE, "time_loop", "more than %d processes", PD_TIME_LOOP_MAX_PROCESSES);
    for (int k = 0, elements = c->elements; k < process.elements; k++) {
        int e = pdi_time_loop_find_ledger(c, &process.element[k]);
        if (e == PD_TIME_LOOP_MAX_ELEMENTS) {
            c->elements = elements;
            return pd_fail(ctx, PD_ERR_SIZE, "time_loop", "more than %d elements", PD_TIME_LOOP_MAX_ELEMENTS);
        }
        c->element[e] = process.element[k];
        if (e == c->elements) c->elements++;
    }
    c->process[c->count++] = process;
    return PD_OK;
}

/* ---- ledger ---- */

/* Sets the present amounts of all ledgers to the sums over the processes. Before the first step (steps 0) it also sets
 * the initial amounts: start is solid plus dissolved, without carried_residual. Imbalances stay as they are. */
static void pdi_time_loop_sum_amounts(pd_ctx *ctx, pd_time_loop *c)
{
    pd_amounts sum[PD_TIME_LOOP_MAX_ELEMENTS];
    memset(sum, 0, sizeof sum);
    for (int n = 0; n < c->count; n++) {
        const pd_physics *p = &c->process[n];
        for (int k = 0; k < p->elements; k++)
            p->add_amounts(ctx, p->self, k, &sum[pdi_time_loop_find_ledger(c, &p->element[k])]);
    }
    for (int e = 0; e < c->elements; e++) {
        pd_mass_balance *l = &c->ledger[e];
        l->solid = sum[e].solid;
        l->volume = sum[e].volume;
        l->dissolved = sum[e].dissolved;
        l->carried_residual = sum[e].undelivered;
        l->out = sum[e].out;
        l->in = sum[e].in;
        if (c->steps) continue;
        l->start = l->solid + l->dissolved;
        l->solid_start = l->solid;
        l->volume_start = l->volume;
    }
}

/* Sets c->own_imbalance to the largest relative imbalance of processes that keep balances of their own; 0: none does.
 * PD_ERR_BALANCE: it is above desc.ledger_tolerance; the first such process is named, those behind it are not asked. */
static pd_status pdi_time_loop_check_own_balances(pd_ctx *ctx, pd_time_loop *c)
{
    c->own_imbalance = 0.0;
    for (int n = 0; n < c->count; n++) {
        const pd_physics *p = &c->process[n];
        double imbalance = p->imbalance ? p->imbalance(ctx, p->self) : 0.0;
        if (!(imbalance <= c->own_imbalance)) c->own_imbalance = imbalance; /* which may be NaN */
        if (c->own_imbalance <= c->desc.ledger_tolerance) continue;
        return pd_fail(ctx, PD_ERR_BALANCE, "time_loop",
                       "at t = %g s the balances of %s miss by %.3g of what they have, "
                       "expected at most %g",
                       c->time, p->name, c->own_imbalance, c->desc.ledger_tolerance);
    }
    return PD_OK;
}

/* Updates the ledgers, their imbalances and c->own_imbalance. PD_ERR_BALANCE: |imbalance| of a ledger is above
 * ledger_tolerance times the largest of initial solid (without it, start), |in| and |out|, plus a rounding that grows
 * with the steps; or a balance of a process itself is off. relative_imbalance is 0 where the imbalance is below
 * DBL_MIN. Ledgers behind the first bad one are not checked. */
static pd_status pdi_time_loop_check_balance(pd_ctx *ctx, pd_time_loop *c)
{
    pdi_time_loop_sum_amounts(ctx, c);
    for (int e = 0; e < c->elements; e++) {
        pd_mass_balance *l = &c->ledger[e];
        l->imbalance = (l->solid + l->dissolved + l->carried_residual - l->start) + (l->out - l->in);
        /* what has passed may be many times the metal, and its sums are solved to a share of it */
        double scale = pd_max(l->solid_start > 0.0 ? l->solid_start : l->start, pd_max(fabs(l->in), fabs(l->out)));
        /* below DBL_MIN numbers have lost their digits */
        l->relative_imbalance = fabs(l->imbalance) > DBL_MIN ? fabs(l->imbalance) / scale : 0.0;
        double rounding =
            DBL_EPSILON * (double)(c->steps + 8) * (fabs(l->in) + fabs(l->out) + fabs(l->dissolved)) + DBL_MIN;
        if (!(fabs(l->imbalance) <= c->desc.ledger_tolerance * scale + rounding))
            return pd_fail(ctx, PD_ERR_BALANCE, "time_loop",
                           "at t = %g s solid %.9g + dissolved %.9g + out %.9g - in %.9g %s of %s misses the start "
                           "%.9g %s by %.3g",
                           c->time, l->solid, l->dissolved, l->out, l->in, c->element[e].unit, c->element[e].name,
                           l->start, c->element[e].unit, l->imbalance);
    }
    return pdi_time_loop_check_own_balances(ctx, c);
}

/* ---- steps ---- */

/* Solid lost since the start by the elements of a process [unit], summed over them, as of the last update of the
 * ledgers. */
static double pdi_time_loop_lost_solid(const pd_time_loop *c, const pd_physics *p)
{
    double lost = 0.0;
    for (int k = 0; k < p->elements; k++) {
        const pd_mass_balance *l = &c->ledger[pdi_time_loop_find_ledger(c, &p->element[k])];
        lost += l->solid_start - l->solid;
    }
    return lost;
}

/* Sets c->current, for progress messages, to process n at time t [s]; its other members become 0. */
static void pdi_time_loop_set_current(pd_time_loop *c, int n, double t)
{
    memset(&c->current, 0, sizeof c->current);
    c->current.name = c->process[n].name;
    c->current.time = t;
}

/* Keeps the status of a process: one that misses its tolerance sets c->has_missed. Returns the error, or PD_OK. */
static pd_status pdi_time_loop_keep_status(pd_time_loop *c, pd_status status)
{
    if (status > 0) c->has_missed = 1;
    return status < 0 ? status : PD_OK;
}

/* Solves all processes with a solve_at, in their order, at time t [s]: the callback pd_step.solve_at; user: the
 * pd_time_loop. Returns PD_OK or the first error: a process that misses its tolerance only sets c->has_missed.
 * c->current is restored; after an error it names the process. */
static pd_status pdi_time_loop_solve_quasi_steady(pd_ctx *ctx, void *user, double t)
{
    pd_time_loop *c = (pd_time_loop *)user;
    pd_attempt around = c->current;
    for (int n = 0; n < c->count; n++) {
        if (!c->process[n].solve_at) continue;
        pdi_time_loop_set_current(c, n, t);
        PD_TRY(pdi_time_loop_keep_status(c, c->process[n].solve_at(ctx, c->process[n].self, t)));
    }
    c->current = around;
    return PD_OK;
}

/* Adds 1 to c->unsolved if a process missed its tolerance since the last call, in a step or the start, and clears
 * c->has_missed. Returns PD_NOT_CONVERGED then, else PD_OK. */
static pd_status pdi_time_loop_count_missed(pd_time_loop *c)
{
    pd_status status = c->has_missed ? PD_NOT_CONVERGED : PD_OK;
    c->unsolved += c->has_missed;
    c->has_missed = 0;
    return status;
}

pd_status pd_time_loop_start(pd_ctx *ctx, pd_time_loop *c)
{
    for (int n = 0; n < c->count; n++) {
        pdi_time_loop_set_current(c, n, c->time);
        if (!c->process[n].start) continue;
        PD_TRY(pdi_time_loop_keep_status(c, c->process[n].start(ctx, c->process[n].self, c->time)));
    }
    memset(&c->current, 0, sizeof c->current);
    c->started = 1;
    pdi_time_loop_count_missed(c);
    return pdi_time_loop_check_balance(ctx, c);
}

/* Process n has made a step: clears its bits in c->new_fluid, and c->has_new_fluid when no bit of any process is left.
 */
static void pdi_time_loop_clear_new_fluid(pd_time_loop *c, int n)
{
    int left = 0;
    for (int32_t i = 0; i < c->grid->total && c->has_new_fluid; i++) left |= c->new_fluid[i] &= (uint8_t) ~(1 << n);
    c->has_new_fluid = left != 0;
}

/* Nodes turned [count] have become fluid: updates bond data, sets the bits of c->new_fluid of all processes that step
 * in time, and calls nodes_converted of all processes, in their order. Does nothing for count 0; bonds and new_fluid
 * may be NULL and are left out then. */
static pd_status pdi_time_loop_update_geometry(pd_ctx *ctx, pd_time_loop *c, const int32_t *turned, int32_t count)
{
    if (!count) return PD_OK;
    if (c->bonds) PD_TRY(pd_bonds_update(ctx, turned, count, c->bonds));
    for (int n = 0; n < c->count; n++)
        for (int32_t k = 0; k < count && c->new_fluid && c->process[n].attempt; k++)
            c->new_fluid[turned[k]] |= (uint8_t)(1 << n);
    c->has_new_fluid = c->new_fluid != NULL;
    for (int n = 0; n < c->count; n++)
        if (c->process[n].nodes_converted)
            PD_TRY(c->process[n].nodes_converted(ctx, c->process[n].self, turned, count));
    return PD_OK;
}

/* Step of the run where the first process takes several steps of its own in it: asks all processes with max_run_step.
 * If they allow less than the time left, divides that into equal steps of at most this length, sets s->dt and lowers
 * s->latest_end; else the step takes all the time left. PD_ERR_STATE: the step is below rounding of the time. */
static pd_status pdi_time_loop_choose_step(pd_ctx *ctx, const pd_time_loop *c, pd_step *s)
{
    double left = s->latest_end - s->time;
    s->dt = left;
    for (int n = 0; n < c->count; n++) {
        if (!c->process[n].max_run_step) continue;
        s->dissolved = pdi_time_loop_lost_solid(c, &c->process[n]);
        PD_TRY(c->process[n].max_run_step(ctx, c->process[n].self, s));
    }
    if (!(s->dt < left)) return PD_OK;
    s->dt = pdi_physics_equal_steps(left, s->dt);
    if (pdi_is_step_underflow(s->time, left, s->dt))
        return pd_fail(ctx, PD_ERR_STATE, "time_loop",
                       "steps of %g s do not lead on from t = %g s to %g s: max_step (%g s) is too small", s->dt,
                       s->time, s->latest_end, c->desc.max_step);
    if (s->dt < left) s->latest_end = s->time + s->dt;
    return PD_OK;
}

/* Advances a process from s->time to s->latest_end, or until those behind it have to follow (s->ends_substeps), or by
 * one step (once 1); s->end: the time reached. After each step clears its bits of new fluid and updates the geometry;
 * at the end calls `finish`. A step that misses its tolerance sets c->has_missed. PD_ERR_STATE: steps are too short to
 * reach the end, as of pdi_physics_check_progress. */
static pd_status pdi_time_loop_advance_process(pd_ctx *ctx, pd_time_loop *c, const pd_physics *p, int once, pd_step *s)
{
    pdi_physics_progress pace = {s->time, 0};
    double limit = s->latest_end;
    do {
        s->latest_end = limit;
        PD_TRY(pdi_time_loop_keep_status(c, pdi_physics_step(ctx, p, s)));
        pdi_time_loop_clear_new_fluid(c, (int)(p - c->process));
        PD_TRY(pdi_time_loop_update_geometry(ctx, c, s->converted_nodes, s->converted_count));
        s->time = s->end;
        if (!once) PD_TRY(pdi_physics_check_progress(ctx, p->name, &pace, s->time, limit));
    } while (!once && !s->ends_substeps && s->time < limit);
    return p->finish ? pdi_time_loop_keep_status(c, p->finish(ctx, p->self, s->end)) : PD_OK;
}

/* Advances the processes from number n on from time `from` [s] to `end` [s], each in its own steps; quasi-steady ones
 * are skipped. Where one stops before `end`, those behind it follow to that time first. */
static pd_status pdi_time_loop_advance_followers(pd_ctx *ctx, pd_time_loop *c, int n, double from, double end,
                                                 pd_step *s)
{
    for (; n < c->count; n++) {
        const pd_physics *p = &c->process[n];
        double reached = from;
        if (!p->attempt) continue;
        for (;;) {
            s->time = reached;
            s->latest_end = end;
            s->dissolved = pdi_time_loop_lost_solid(c, p);
            PD_TRY(pdi_time_loop_advance_process(ctx, c, p, 0, s));
            reached = s->end;
            if (!(reached < end)) break;
            PD_TRY(pdi_time_loop_advance_followers(ctx, c, n + 1, from, reached, s));
            from = reached;
        }
    }
    return PD_OK;
}

/* One step of all processes in their order, from c->time, which stays. *end, *dt [s]: end and length of the step; on
 * entry the limit and the time left to it. The first process that steps in time decides the end; *dt is its own step,
 * or the whole length if it takes several. If no process steps in time, the time left is divided into equal steps of at
 * most max_step (0: one step), and quasi-steady processes are solved at the end. */
static pd_status pdi_time_loop_advance_all(pd_ctx *ctx, pd_time_loop *c, double *end, double *dt)
{
    pd_step s;
    int n = 0;
    memset(&s, 0, sizeof s);
    s.max_dissolved_fraction = c->desc.fraction;
    s.rtol = c->desc.rtol;
    s.max_step = c->desc.max_step;
    s.solve_at = pdi_time_loop_solve_quasi_steady;
    s.solve_at_user = c;
    s.time_limit = c->desc.next_event;
    s.time_limit_user = c->desc.next_event_user;
    s.progress = &c->current;
    while (n < c->count && !c->process[n].attempt) n++;
    if (n < c->count) {
        const pd_physics *p = &c->process[n];
        s.time = c->time;
        s.latest_end = *end;
        if (p->has_substeps) PD_TRY(pdi_time_loop_choose_step(ctx, c, &s));
        s.dissolved = pdi_time_loop_lost_solid(c, p);
        PD_TRY(pdi_time_loop_advance_process(ctx, c, p, !p->has_substeps, &s));
        *end = s.end;
        *dt = p->has_substeps ? *end - c->time : s.dt;
        return pdi_time_loop_advance_followers(ctx, c, n + 1, c->time, *end, &s);
    }
    if (c->desc.max_step > 0.0 && c->desc.max_step < *dt) {
        *dt = pdi_physics_equal_steps(*dt, c->desc.max_step);
        if (*dt < *end - c->time) *end = c->time + *dt;
    }
    return pdi_time_loop_solve_quasi_steady(ctx, c, *end);
}

pd_status pd_time_loop_step(pd_ctx *ctx, pd_time_loop *c, double t_limit)
{
    double end = t_limit, dt = t_limit - c->time;
    if (!(t_limit > c->time))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "time_loop", "a step from %g s cannot end at %g s", c->time, t_limit);
    pd_status status = pdi_time_loop_advance_all(ctx, c, &end, &dt);
    memset(&c->current, 0, sizeof c->current);
    if (status < 0) return status;
    c->dt = dt;
    c->time = end;
    c->steps++;
    PD_TRY(pdi_time_loop_check_balance(ctx, c));
    for (int n = 0; n < c->count; n++)
        if (c->process[n].solve_at && c->process[n].finish)
            PD_TRY(pdi_time_loop_keep_status(c, c->process[n].finish(ctx, c->process[n].self, c->time)));
    return pdi_time_loop_count_missed(c);
}

pd_status pd_time_loop_run(pd_ctx *ctx, pd_time_loop *c, double t_end, double every, pd_observer_fn observer,
                           void *user)
{
    if (!(t_end >= c->time) || !(every >= 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "time_loop", "the run from %g s to %g s with output every %g s", c->time,
                       t_end, every);
    if (!c->started) {
        PD_TRY(pd_time_loop_start(ctx, c));
        if (observer && observer(user, c)) return c->unsolved ? PD_NOT_CONVERGED : PD_OK;
    }
    pdi_physics_progress pace = {c->time, 0};
    int n = 0; /* the process whose steps the run makes */
    while (n + 1 < c->count && !c->process[n].attempt) n++;
    while (c->time < t_end) {
        double limit = t_end;
        if (every > 0.0) {
            limit = (floor(c->time / every * (1.0 + 1e-12)) + 1.0) * every;
            if (limit > t_end * (1.0 - 1e-12)) limit = t_end;
        }
        PD_TRY(pd_time_loop_step(ctx, c, limit));
        PD_TRY(pdi_physics_check_progress(ctx, c->count ? c->process[n].name : "time loop", &pace, c->time, t_end));
        if (observer && observer(user, c)) break;
    }
    return c->unsolved ? PD_NOT_CONVERGED : PD_OK;
}

double pd_time_loop_volume_loss(const pd_time_loop *c)
{
    double start = 0.0, left = 0.0;
    for (int e = 0; e < c->elements; e++) {
        start += c->ledger[e].volume_start;
        left += c->ledger[e].volume;
    }
    return start > 0.0 ? 1.0 - left / start : 0.0;
}

double pd_time_loop_imbalance(const pd_time_loop *c)
{
    double worst = c->own_imbalance;
    for (int e = 0; e < c->elements; e++) worst = pd_max(worst, c->ledger[e].relative_imbalance);
    return worst;
}

/* ---- state ---- */

/* Writes cells, spacings, low ends, ghost layers, initial number of solid nodes, and names and number of processes into
 * a checkpoint. On reading, checks that it has the same ones: PD_ERR_ARGUMENT: they differ. */
static pd_status pdi_time_loop_check_compatible(pd_ctx *ctx, const pd_time_loop *c, pd_archive *archive)
{
    const pd_grid *grid = c->grid;
    static const char *const cells[] = {"cells along x", "cells along y", "cells along z"};
    static const char *const spacing[] = {"h along x [m]", "h along y [m]", "h along z [m]"};
    static const char *const low[] = {"low end along x [m]", "low end along y [m]", "low end along z [m]"};
    for (int d = 0; d < PD_DIM; d++) {
        PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, cells[d], grid->n[d]));
        PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, spacing[d], grid->h[d]));
        PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, low[d], grid->lo[d]));
    }
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "ghost layers", grid->ghost));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "metal nodes at the start", (double)c->solid_nodes_start));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "processes", c->count));
    for (int n = 0; n < c->count; n++) PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, c->process[n].name, 1));
    return PD_OK;
}

/* Turns the solid nodes within the box that `kind` [total] says are fluid into fluid, then updates bonds and all
 * processes. turned [solid nodes at the start]: work. PD_ERR_GEOMETRY: kinds still differ somewhere; the grid is
 * changed then. */
static pd_status pdi_time_loop_restore_fluid(pd_ctx *ctx, pd_time_loop *c, const uint8_t *kind, int32_t *turned)
{
    int32_t count = 0;
    for (int32_t i = 0; i < c->grid->total; i++) {
        int at[PD_DIM];
        pd_grid_index(c->grid, i, at);
        if (kind[i] == PD_FLUID && c->grid->kind[i] == PD_SOLID && pd_grid_is_inside(c->grid, at)) turned[count++] = i;
    }
    for (int32_t n = 0; n < count; n++) pdi_grid_set_fluid(c->grid, turned[n]);
    for (int32_t i = 0; i < c->grid->total; i++)
        if (kind[i] != c->grid->kind[i])
            return pd_fail(ctx, PD_ERR_GEOMETRY, "time_loop", "node %d is of kind %d in the file, expected %d", (int)i,
                           kind[i], c->grid->kind[i]);
    return pdi_time_loop_update_geometry(ctx, c, turned, count);
}

/* Writes the kinds of all nodes of the grid. On reading, restores them and updates bonds and processes by the nodes
 * that have turned fluid. PD_ERR_GEOMETRY: as of pdi_time_loop_restore_fluid. Work is freed in any case. */
static pd_status pdi_time_loop_store_kinds(pd_ctx *ctx, pd_time_loop *c, pd_archive *archive)
{
    uint8_t *kind = NULL;
    int32_t *turned = NULL, total = c->grid->total;
    int64_t most = c->solid_nodes_start;
    if (!archive->is_reading) return PD_ARCHIVE_ARRAY(ctx, archive, "grid.kind", c->grid->kind, total);
    pd_status status = PD_NEW(ctx, "time_loop", total, kind);
    if (status == PD_OK) status = PD_NEW(ctx, "time_loop", most, turned);
    if (status == PD_OK) status = PD_ARCHIVE_ARRAY(ctx, archive, "grid.kind", kind, total);
    if (status == PD_OK) status = pdi_time_loop_restore_fluid(ctx, c, kind, turned);
    PD_DELETE(ctx, total, kind);
    PD_DELETE(ctx, most, turned);
    return status;
}

pd_status pd_time_loop_store(pd_ctx *ctx, pd_time_loop *c, pd_archive *archive)
{
    PD_TRY(pdi_time_loop_check_compatible(ctx, c, archive));
    PD_TRY(pdi_time_loop_store_kinds(ctx, c, archive));
    if (c->new_fluid) PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "fresh nodes", c->new_fluid, c->grid->total));
    if (c->new_fluid && archive->is_reading) c->has_new_fluid = 1; /* or none: the next step looks */
    for (int n = 0; n < c->count; n++)
        if (c->process[n].checkpoint) PD_TRY(c->process[n].checkpoint(ctx, c->process[n].self, archive));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "time", &c->time, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "dt", &c->dt, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "started", &c->started, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "steps", &c->steps, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "unsolved", &c->unsolved, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "imbalance apart", &c->own_imbalance, 1));
    return PD_ARCHIVE_ARRAY(ctx, archive, "ledger", c->ledger, c->elements);
}

#undef PDI_TIME_LOOP_RTOL_RATIO
