/* recede: see recede.h */
#include "metal/recede.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* States of fluid nodes beside metal. */
enum { PDI_RECEDE_LAW = 0, PDI_RECEDE_SATURATED, PDI_RECEDE_FULL, PDI_RECEDE_PINNED };

/* How far a node must pass a bound to change its state, over the tolerance: less would chatter. */
#define PDI_RECEDE_MARGIN 3.0
/* Share of Csat by which the law is probed. */
#define PDI_RECEDE_PROBE 1e-6
/* Share of a concentration at which a law that has ended is looked for next. */
#define PDI_RECEDE_DOWN 0.94
/* Share of Csat within which a law jumps, share of a speed that makes a jump, and most halvings on the way there. */
#define PDI_RECEDE_JUMP 1e-12
#define PDI_RECEDE_DROP 1e-6
#define PDI_RECEDE_HALVINGS 60
/* How near to a jump a pinned node ends its step, over the tolerance. */
#define PDI_RECEDE_NEAR 100.0
/* What rounding leaves of an exchange, over Csat. */
#define PDI_RECEDE_ROUNDING 1e-14
/* Conductance of saturated nodes in the preconditioner, over that of all bonds. */
#define PDI_RECEDE_STIFF 1e3
/* Tolerance of the linear systems over the residual; where states have just turned and may turn again, in the first
 * rounds; how much longer the next step may be. */
#define PDI_RECEDE_FORCING 1e-3
#define PDI_RECEDE_FORCING_TURNED 0.03
#define PDI_RECEDE_FIRST 6
#define PDI_RECEDE_GROWTH 1.5
/* A preconditioner that takes more iterations is set up anew. */
#define PDI_RECEDE_STALE 40
/* A step in which a node loses this much more than its share is tried again; one this much shorter than wanted has
 * failed. */
#define PDI_RECEDE_EXCESS 2.5
#define PDI_RECEDE_SHORTEST 1e-12

/* What callbacks and sweeps see. */
typedef struct pdi_recede_user {
    pd_ctx *ctx;
    pd_recede *r;
    double *out; /* of a sweep over fluid nodes */
} pdi_recede_user;

/* 1: the concentration of the node is given. */
static int pdi_recede_held(const pd_recede *r, int64_t node)
{
    return r->state[node] == PDI_RECEDE_SATURATED || r->state[node] == PDI_RECEDE_PINNED;
}

/* ---- the linear system ---- */

static void pdi_recede_apply_run(void *user, int32_t first, int count)
{
    const pdi_recede_user *u = (const pdi_recede_user *)user;
    const pd_recede *r = u->r;
    const double *x = r->field + first;
    double sum[PDI_PHASE_PIECE];
    if (r->corrode->map.role[first] == PDI_ROLE_EXPOSED) return;
    /* the operand is 0 in metal and walls, bonds to which count as dry */
    pdi_corrode_laplacian(r->corrode, r->field, first, count, sum);
    for (int b = 0; b < count; b++) {
        double spread = sum[b] + r->dry[first + b] * x[b];
        double all = (1.0 / r->dt + r->drain[first + b]) * x[b] - r->corrode->desc.diffusivity * spread;
        u->out[first + b] = pdi_recede_held(r, first + b) ? 0.0 : all;
    }
}

/* A correction is odd about held planes. */
static void pdi_recede_apply(void *user, const double *x, double *y)
{
    pdi_recede_user *u = (pdi_recede_user *)user;
    const pd_corrode *m = u->r->corrode;
    int64_t first = u->r->krylov.desc.first, end = u->r->krylov.desc.end;
    pdi_par_copy(u->ctx, end - first, x + first, u->r->field + first);
    for (int32_t g = 0; g < m->map.ghosts; g++) {
        double from = x[m->map.source[g]];
        u->r->field[m->map.ghost[g]] = m->map.phase[m->map.ghost[g]] == PDI_PHASE_HELD ? -from : from;
    }
    u->out = y;
    pdi_corrode_sweep(u->ctx, m, pdi_recede_apply_run, u);
}

static void pdi_recede_precondition(void *user, const double *x, double *y)
{
    pdi_recede_user *u = (pdi_recede_user *)user;
    pd_recede *r = u->r;
    pd_multigrid_cycle(u->ctx, &r->mg, x, y);
    for (int64_t i = r->krylov.desc.first; i < r->krylov.desc.end; i++)
        if (pdi_recede_held(r, i)) y[i] = 0.0;
}

/* What fluid beside metal adds to the mass of its cell: the drain of the law, or the stiffness of a saturated node. */
static float pdi_recede_hold(const pd_recede *r, int32_t node)
{
    const pd_corrode *m = r->corrode;
    if (!pdi_recede_held(r, node)) return (float)fmax(r->drain[node], 0.0);
    return (float)(PDI_RECEDE_STIFF * (m->diffusion + 1.0 / r->dt));
}

/* The preconditioner. links: 1 the first time in a step; then only states and drains are other ones. */
static pd_status pdi_recede_setup(pd_ctx *ctx, pd_recede *r, int links)
{
    const pd_corrode *m = r->corrode;
    pdi_compact_faces faces;
    pdi_compact_convection none;
    memset(&none, 0, sizeof none);
    faces.closed = 0;
    faces.inlet = faces.outlet = 1;
    float mass = (float)(1.0 / r->dt);
    if (links) pdi_compact_fill(ctx, m->desc.diffusivity, NULL, &none, 1.0 / r->dt, &faces, &r->compact);
    for (int32_t node = 0; node < m->grid->total; node++) {
        int i[PD_DIM];
        if (m->map.role[node] != PDI_ROLE_SHORE) continue;
        pdi_grid_index(m->grid, node, i);
        r->compact.mass[pdi_compact_cell(m->grid, i)] = mass + pdi_recede_hold(r, node);
    }
    if (links)
        return pd_multigrid_setup(ctx, &r->mg, r->compact.active, (const float *const *)r->compact.conduct, NULL,
                                  r->compact.wall, r->compact.mass);
    return pd_multigrid_mass(ctx, &r->mg, r->compact.active, r->compact.wall, r->compact.mass);
}

/* ---- the equations ---- */

/* What the metal in reach of fluid node i would give, and its bonds into the dry. */
static void pdi_recede_gather(pd_recede *r, int32_t i)
{
    const pd_corrode *m = r->corrode;
    for (int k = 0; k < m->stencil->count; k++) {
        int32_t j = i + m->map.shift[k];
        if (!pdi_phase_wet(m->map.phase[j])) r->dry[i] += m->stencil->lap[k];
        if (m->map.phase[j] != PDI_PHASE_SOLID) continue;
        double weight = m->front.weight[k] * (m->factor ? m->factor[j] : 1.0);
        r->reach[i] += weight;
        r->stock[i] += weight * m->c[j];
    }
}

/* Tolerance of the step at hand [-]. */
static double pdi_recede_goal(const pd_recede *r)
{
    return fmax(r->desc.tolerance, PDI_RECEDE_ROUNDING * r->dt * r->corrode->diffusion);
}

/* The law beside fluid node i. A law of time holds at the middle of the step. */
static void pdi_recede_law(const pd_recede *r, int32_t i, pdi_law *law)
{
    const pd_corrode *m = r->corrode;
    law->rate = m->desc.rate;
    law->user = m->desc.rate_user;
    law->top = m->desc.saturation;
    law->at.t = m->time + 0.5 * r->dt;
    pd_grid_position(m->grid, i, law->at.x);
}

/* Where fluid node i is full: at Csat, or where the law ends before. Above an end it is where the law begins below. */
static double pdi_recede_full(const pd_recede *r, int32_t i)
{
    const pd_corrode *m = r->corrode;
    double csat = m->desc.saturation, c = fmin(fmax(r->start[i], 0.0), csat), low = c;
    pdi_law law;
    pdi_recede_law(r, i, &law);
    if (!(c < csat) || pdi_law_rate(&law, c) > 0.0) return fmin(pdi_law_end(&law, fmin(c, csat), csat), csat);
    while (low > PDI_RECEDE_PROBE * csat && !(pdi_law_rate(&law, low) > 0.0)) low *= PDI_RECEDE_DOWN;
    return pdi_law_rate(&law, low) > 0.0 ? fmin(pdi_law_end(&law, low, c), csat) : csat;
}

/* 1: the law falls by a jump between a and b, and is positive behind it; *at: the last concentration before that. */
static int pdi_recede_drops(const pd_recede *r, int32_t i, double a, double b, double *at)
{
    pdi_law law;
    pdi_recede_law(r, i, &law);
    double before = pdi_law_rate(&law, a), behind = pdi_law_rate(&law, b);
    for (int k = 0; k < PDI_RECEDE_HALVINGS && b - a > PDI_RECEDE_JUMP * law.top; k++) {
        double middle = 0.5 * (a + b), v = pdi_law_rate(&law, middle);
        if (before - v > v - behind) {
            b = middle;
            behind = v;
        } else {
            a = middle;
            before = v;
        }
    }
    if (!(behind > 0.0) || !(before - behind > PDI_RECEDE_DROP * before)) return 0;
    *at = a;
    return 1;
}

/* 1: node i was pinned to a jump of its law, which is still there. */
static int pdi_recede_stays(pd_recede *r, int32_t i)
{
    double near = PDI_RECEDE_NEAR * pdi_recede_goal(r) * r->corrode->desc.saturation, c = r->start[i];
    return r->state[i] == PDI_RECEDE_PINNED && pdi_recede_drops(r, i, c - near, c + near, &r->full[i]);
}

/* Begin a step: how many nodes take part, and what the metal in reach of those beside it would give. */
static void pdi_recede_begin(const pd_ctx *ctx, pd_recede *r)
{
    pd_corrode *m = r->corrode;
    pdi_corrode_repassivate(m);
    pdi_corrode_ghosts(m); /* the metal behind the sides has lost as much as its sources in the last step */
    int nt = pdi_par_threads(ctx, m->grid->total);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < m->grid->total; i++) {
        r->reach[i] = r->stock[i] = r->dry[i] = 0.0;
        if (m->map.role[i] == PDI_ROLE_SHORE) {
            pdi_recede_gather(r, i);
            continue;
        }
        r->state[i] = PDI_RECEDE_LAW; /* the front may have left it behind */
        r->drain[i] = 0.0;
    }
    for (int32_t i = 0; i < m->grid->total; i++) /* laws of callers are asked by one thread */
        if (m->map.role[i] == PDI_ROLE_SHORE) {
            r->asked_c[i] = -1.0;
            if (pdi_recede_stays(r, i)) continue;
            if (r->state[i] == PDI_RECEDE_PINNED) r->state[i] = PDI_RECEDE_LAW;
            r->full[i] = pdi_recede_full(r, i);
        }
    m->active = 0;
    int32_t first = -1, end = 1; /* of the fluid */
    for (int32_t i = 0; i < m->grid->total; i++) {
        int fluid = m->map.role[i] == PDI_ROLE_WHOLE || m->map.role[i] == PDI_ROLE_SHORE;
        if (fluid && first < 0) first = i;
        if (fluid) end = i + 1;
        m->active += m->map.role[i] != PDI_ROLE_IDLE;
    }
    r->krylov.desc.first = first > 0 ? first : 0;
    r->krylov.desc.end = end;
}

/* G [mol/m3/s] of node i at concentration c, with the speed v of the law there. */
static double pdi_recede_gain(const pd_recede *r, int32_t i, double v, double c)
{
    const pd_corrode *m = r->corrode;
    int difference = m->desc.drive == PD_DRIVE_DIFFERENCE;
    return v * pdi_corrode_scale(m) * (difference ? r->stock[i] - r->reach[i] * c : r->reach[i]);
}

/* balance = (C - C')/dt + what diffusion brings */
static void pdi_recede_balance_run(void *user, int32_t first, int count)
{
    const pdi_recede_user *u = (const pdi_recede_user *)user;
    const pd_recede *r = u->r;
    const pd_corrode *m = r->corrode;
    double sum[PDI_PHASE_PIECE];
    if (m->map.role[first] == PDI_ROLE_EXPOSED) return;
    pdi_corrode_spread(m, m->c, first, count, sum);
    for (int b = 0; b < count; b++)
        u->out[first + b] = (r->start[first + b] - m->c[first + b]) / r->dt + m->desc.diffusivity * sum[b];
}

/* A jump of the law between c and the last concentration that was asked for, where what the law gives crosses the line
 * through what was needed there. The node is pinned to it. */
static int pdi_recede_pin(pd_recede *r, int32_t i, double c, double need)
{
    double a = r->asked_c[i], b = c, asked_a = r->asked_need[i], asked_b = need;
    pdi_law law;
    pdi_recede_law(r, i, &law);
    r->asked_c[i] = c;
    r->asked_need[i] = need;
    if (a < 0.0) return 0;
    if (a > b) {
        double keep = a, asked = asked_a;
        a = b;
        b = keep;
        asked_a = asked_b;
        asked_b = asked;
    }
    if (pdi_recede_gain(r, i, fmax(pdi_law_rate(&law, a), 0.0), a) <= asked_a) return 0;
    if (pdi_recede_gain(r, i, fmax(pdi_law_rate(&law, b), 0.0), b) >= asked_b) return 0;
    double low = a, rise = (asked_b - asked_a) / (b - a);
    for (int k = 0; k < PDI_RECEDE_HALVINGS && b - a > PDI_RECEDE_JUMP * law.top; k++) {
        double middle = 0.5 * (a + b), v = fmax(pdi_law_rate(&law, middle), 0.0);
        if (pdi_recede_gain(r, i, v, middle) > asked_a + rise * (middle - low)) a = middle;
        else b = middle;
    }
    return pdi_recede_drops(r, i, a, b, &r->full[i]);
}

/* The state of a node that is pinned to a jump of its law: it leaves where the law before the jump gives too little or
 * that behind it too much. */
static uint8_t pdi_recede_unpin(pd_recede *r, int32_t i, double gain, double need, double margin)
{
    pdi_law law;
    pdi_recede_law(r, i, &law);
    double c = r->full[i] + 2.0 * PDI_RECEDE_PROBE * law.top; /* where a difference quotient does not see the jump */
    double next = r->full[i] + 2.0 * PDI_RECEDE_JUMP * law.top;
    double behind = pdi_recede_gain(r, i, fmax(pdi_law_rate(&law, next), 0.0), next);
    int below = (need - gain) * r->dt > margin, above = (behind - need) * r->dt > margin;
    if (!below && !above) return PDI_RECEDE_PINNED;
    if (above) r->corrode->c[i] = c;
    r->full[i] = pdi_recede_full(r, i);
    r->asked_c[i] = -1.0;
    return PDI_RECEDE_LAW;
}

/* The state of node i, with the gain G that the law allows at concentration c and what it needs to stay as it is. */
static uint8_t pdi_recede_choose(pd_recede *r, int32_t i, double c, double gain, double need)
{
    const pd_corrode *m = r->corrode;
    double margin = PDI_RECEDE_MARGIN * pdi_recede_goal(r) * m->desc.saturation;
    double above = m->c[i] - r->full[i];
    if (r->state[i] == PDI_RECEDE_PINNED) return pdi_recede_unpin(r, i, gain, need, margin);
    if (gain > 0.0 && fabs(need - gain) * r->dt > margin && pdi_recede_pin(r, i, c, need)) return PDI_RECEDE_PINNED;
    switch (r->state[i]) {
    case PDI_RECEDE_LAW: return above > margin ? PDI_RECEDE_SATURATED : PDI_RECEDE_LAW;
    case PDI_RECEDE_SATURATED:
        if (need * r->dt > gain * r->dt + margin) return PDI_RECEDE_LAW;
        return need * r->dt < -margin ? PDI_RECEDE_FULL : PDI_RECEDE_SATURATED;
    default: return above < -margin ? PDI_RECEDE_SATURATED : PDI_RECEDE_FULL;
    }
}

/* Speeds, states and drains of the nodes beside metal, and the balance of all at the present field. *change: 1 when a
 * state is another one; *worst: largest balance times dt over Csat. */
static pd_status pdi_recede_evaluate(pd_ctx *ctx, pd_recede *r, int settled, int *change, double *worst)
{
    pd_corrode *m = r->corrode;
    double csat = m->desc.saturation, probe = PDI_RECEDE_PROBE * csat, largest = 0.0;
    *change = 0;
    pdi_recede_user user;
    user.ctx = ctx;
    user.r = r;
    user.out = r->balance;
    pdi_corrode_ghosts(m);
    pdi_corrode_sweep(ctx, m, pdi_recede_balance_run, &user);
    for (int32_t i = 0; i < m->grid->total; i++) {
        if (m->map.role[i] == PDI_ROLE_WHOLE) largest = fmax(largest, fabs(r->balance[i]));
        if (m->map.role[i] != PDI_ROLE_SHORE) continue;
        /* at an end of the law that is no saturation it holds just before */
        double most = r->full[i] < csat && r->state[i] != PDI_RECEDE_PINNED ? r->full[i] - 0.5 * probe : r->full[i];
        double c = fmin(m->c[i], most), t = m->time + 0.5 * r->dt, v, less, need = -r->balance[i];
        PDI_TRY(pdi_corrode_law(ctx, m, t, i, c, &v));
        PDI_TRY(pdi_corrode_law(ctx, m, t, i, c - probe, &less));
        double gain = pdi_recede_gain(r, i, v, c), before = pdi_recede_gain(r, i, less, c - probe);
        uint8_t state = settled ? r->state[i] : pdi_recede_choose(r, i, c, gain, need);
        *change |= state != r->state[i];
        r->state[i] = state;
        r->drain[i] = state == PDI_RECEDE_LAW ? (before - gain) / probe : 0.0;
        m->speed[i] = state == PDI_RECEDE_LAW ? v : 0.0;
        if (pdi_recede_held(r, i)) {
            m->c[i] = r->full[i];
            m->speed[i] = gain > 0.0 ? v * fmin(fmax(need / gain, 0.0), 1.0) : 0.0;
            r->balance[i] = 0.0;
        } else if (state == PDI_RECEDE_LAW) r->balance[i] += gain;
        largest = fmax(largest, fabs(r->balance[i]));
    }
    *worst = largest * r->dt / csat;
    return PD_OK;
}

/* Leave out of the drains what makes the linear system indefinite: gains that grow with the concentration. 0: there
 * are none. */
static int pdi_recede_damp(pd_recede *r)
{
    int any = 0;
    for (int32_t i = 0; i < r->corrode->grid->total; i++) {
        if (r->corrode->map.role[i] != PDI_ROLE_SHORE || !(r->drain[i] < 0.0)) continue;
        r->drain[i] = 0.0;
        any = 1;
    }
    return any;
}

/* Concentrations, speeds and states at the end of the step. PD_RETRY: none were found. */
static pd_status pdi_recede_solve(pd_ctx *ctx, pd_recede *r)
{
    pd_corrode *m = r->corrode;
    pdi_recede_user user;
    int fresh = 0, links = 1;
    double worst = HUGE_VAL, goal = pdi_recede_goal(r);
    user.ctx = ctx;
    user.r = r;
    for (int round = 0; round < r->desc.max_newton; round++) {
        pd_krylov_result linear;
        int turned, again;
        PDI_TRY(pdi_poll(ctx, "corrosion: Newton", r->newton));
        PDI_TRY(pdi_recede_evaluate(ctx, r, 0, &turned, &worst));
        if (!turned && worst <= goal) return PD_OK;
        /* saturated nodes have moved to Csat: take the balance there */
        if (turned) {
            PDI_TRY(pdi_recede_evaluate(ctx, r, 1, &again, &worst));
            fresh = 0; /* a setup costs less than the iterations that it saves */
        }
        if (!fresh) PDI_TRY(pdi_recede_setup(ctx, r, links));
        links = 0;
        int loose = turned && round < PDI_RECEDE_FIRST;
        r->krylov.desc.rtol = loose ? PDI_RECEDE_FORCING_TURNED : PDI_RECEDE_FORCING;
        r->krylov.desc.atol = 0.1 * goal * m->desc.saturation / r->dt;
        pd_status status = pd_krylov_solve(ctx, &r->krylov, pdi_recede_apply, pdi_recede_precondition, &user,
                                           r->balance, r->delta, &linear);
        if (status == PD_ERR_DIVERGED && pdi_recede_damp(r)) { /* the law runs away faster than diffusion carries off */
            status = pd_krylov_solve(ctx, &r->krylov, pdi_recede_apply, pdi_recede_precondition, &user, r->balance,
                                     r->delta, &linear);
        }
        if (status < 0) return status;
        fresh = linear.iterations <= PDI_RECEDE_STALE;
        r->iterations += linear.iterations;
        r->newton++;
        pdi_par_axpy(ctx, m->grid->total, 1.0, r->delta, m->c);
    }
    return PD_RETRY;
}

/* ---- steps ---- */

/* Error in time [-]: half of what the field has moved otherwise than before, over Csat, root mean square. Keeps what it
 * has moved. */
static double pdi_recede_error(pd_recede *r)
{
    const pd_corrode *m = r->corrode;
    pdi_sum sum = {0.0, 0.0};
    int64_t nodes = 0;
    double ratio = r->last_dt > 0.0 ? r->dt / r->last_dt : 0.0;
    for (int32_t i = 0; i < m->grid->total; i++) {
        if (m->map.role[i] != PDI_ROLE_WHOLE && m->map.role[i] != PDI_ROLE_SHORE) continue;
        double moved = m->c[i] - r->start[i], error = 0.5 * (moved - ratio * r->moved[i]) / m->desc.saturation;
        pdi_sum_add(&sum, error * error);
        r->moved[i] = moved;
        nodes++;
    }
    return nodes ? sqrt(pdi_sum_total(&sum) / (double)nodes) : 0.0;
}

pd_status pd_recede_step(pd_ctx *ctx, pd_recede *r, double dt)
{
    pd_corrode *m = r->corrode;
    if (!(dt > 0.0) || !(dt < 1e100))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "recede", "a step of %g s, expected a positive one", dt);
    r->dt = dt;
    pdi_par_copy(ctx, m->grid->total, m->c, r->start);
    pdi_recede_begin(ctx, r);
    pd_status status = pdi_recede_solve(ctx, r);
    double lost = 0.0, spare = 1.0, most = fmin(1.0, PDI_RECEDE_EXCESS * r->desc.share);
    if (status == PD_OK) {
        m->base = r->start;
        pdi_corrode_ghosts(m); /* with the speeds of the solution */
        pdi_corrode_exchange(ctx, m, dt);
        lost = pdi_corrode_lost(m);
        spare = pdi_corrode_spare(m);
        m->base = m->c;
    }
    r->retry_dt = spare < 1.0 ? spare * dt : 0.5 * dt;
    if (status == PD_OK && spare < 1.0)
        status = pdi_fail(ctx, PD_RETRY, "recede", "in a step of %g s debris loses more than it has, expected %g s", dt,
                          r->retry_dt);
    if (status == PD_OK && lost > most)
        status = pdi_fail(ctx, PD_RETRY, "recede", "in a step of %g s a node loses %.3g of what it has, expected %.3g",
                          dt, lost, most);
    if (status != PD_OK) {
        pdi_par_copy(ctx, m->grid->total, r->start, m->c);
        m->changed_count = 0;
        r->rejected++;
        return status;
    }
    double error = pdi_recede_error(r);
    if (r->turned) error = 0.0;
    pdi_corrode_commit(m, dt);
    r->next_dt = dt * fmin(PDI_RECEDE_GROWTH, error > 0.0 ? 0.9 * sqrt(r->desc.rtol / error) : PDI_RECEDE_GROWTH);
    r->front_dt = lost > 0.0 ? dt * r->desc.share / lost : HUGE_VAL;
    r->last_dt = dt;
    r->turned = m->changed_count;
    return PD_OK;
}

/* A step of at most dt [s] in which the course of the law costs a small part of what the step may take. */
static double pdi_recede_foresee(const pd_recede *r, double dt)
{
    const pd_corrode *m = r->corrode;
    double per = m->highest * m->front.total / (PDI_CORRODE_COURSE * r->desc.share);
    for (;;) {
        double error, fastest;
        pdi_corrode_course(m, dt, &error, &fastest);
        if (error * dt * per <= 1.0 + 1e-9) return dt;
        dt *= fmax(0.9 / (error * dt * per), 0.1);
    }
}

/* ---- the process ---- */

static pd_status pdi_recede_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_recede *r = (pd_recede *)self;
    double left, dt, limit;
    PDI_TRY(pdi_process_span(ctx, self, s));
    if (s->dt < s->limit - s->time) s->limit = s->time + pdi_process_even(s->limit - s->time, s->dt);
    left = dt = s->limit - s->time;
    if (r->last_dt > 0.0) dt = fmin(fmin(dt, r->next_dt), r->front_dt);
    else { /* no step yet: an explicit one */
        PDI_TRY(pd_corrode_limit(ctx, r->corrode, &limit));
        dt = fmin(dt, limit);
    }
    dt = pdi_recede_foresee(r, dt);
    s->shortest = PDI_RECEDE_SHORTEST * dt;
    s->dt = pdi_process_even(left, dt);
    return PD_OK;
}

static pd_status pdi_recede_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    return pd_recede_step(ctx, (pd_recede *)self, s->dt);
}

static pd_status pdi_recede_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    const pd_recede *r = (const pd_recede *)self;
    if (!(s->dt > s->shortest))
        return pdi_fail(ctx, PD_ERR_DIVERGED, "recede", "no step of %g s or more can be taken at t = %g s", s->shortest,
                        s->time);
    s->dt = r->retry_dt;
    return PD_OK;
}

static pd_status pdi_recede_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    (void)ctx;
    ((pd_recede *)self)->corrode->time = s->end;
    return PD_OK;
}

static pd_status pdi_recede_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    const pd_recede *r = (const pd_recede *)self;
    return pdi_fail(ctx, PD_ERR_STATE, "recede",
                    "steps of %g s do not lead on from t = %g s to %g s: share (%g) or rtol (%g) is too small, or the "
                    "rate changes too fast with C", s->dt, s->time, s->limit, r->desc.share, r->desc.rtol);
}

static pd_status pdi_recede_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_recede *r = (pd_recede *)self;
    int32_t total = r->corrode->grid->total;
    PDI_TRY(pdi_corrode_store(ctx, r->corrode, archive));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.moved", r->moved, total));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.state", r->state, total));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.last_dt", &r->last_dt, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.next_dt", &r->next_dt, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.front_dt", &r->front_dt, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.turned", &r->turned, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.newton", &r->newton, 1));
    PDI_TRY(PDI_KEEP(ctx, archive, "recede.iterations", &r->iterations, 1));
    return PDI_KEEP(ctx, archive, "recede.rejected", &r->rejected, 1);
}

static void pdi_recede_amounts(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    pd_process p;
    pdi_march_common(((pd_recede *)self)->corrode, &p);
    p.balance(ctx, p.self, k, a);
}

pd_process pd_recede_process(pd_recede *r)
{
    pd_process p;
    memset(&p, 0, sizeof p);
    pdi_march_common(r->corrode, &p);
    p.self = r;
    p.limit = pdi_recede_limit;
    p.attempt = pdi_recede_attempt;
    p.accept = pdi_recede_accept;
    p.reject = pdi_recede_reject;
    p.stuck = pdi_recede_stuck;
    p.store = pdi_recede_store;
    p.balance = pdi_recede_amounts;
    return p;
}

pd_status pd_recede_next(pd_ctx *ctx, pd_recede *r, double t_end)
{
    pd_process p = pd_recede_process(r);
    pd_step s;
    memset(&s, 0, sizeof s);
    s.time = r->corrode->time;
    s.limit = t_end;
    if (!(t_end > s.time))
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "recede", "a step from %g s cannot end at %g s", s.time, t_end);
    return pdi_process_step(ctx, &p, &s);
}

pd_status pd_recede_run(pd_ctx *ctx, pd_recede *r, double t_end)
{
    pd_process p = pd_recede_process(r);
    return pdi_process_run(ctx, &p, r->corrode->time, t_end);
}

static pd_status pdi_recede_allocate(pd_ctx *ctx, pd_recede *r)
{
    int64_t total = r->corrode->grid->total;
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->start));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->moved));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->balance));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->delta));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->field));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->drain));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->full));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->asked_c));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->asked_need));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->dry));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->reach));
    PDI_TRY(PDI_NEW(ctx, "recede", total, r->stock));
    return PDI_NEW(ctx, "recede", total, r->state);
}

static pd_status pdi_recede_make(pd_ctx *ctx, pd_corrode *corrode, const pd_recede_desc *desc, pd_recede *r)
{
    pd_krylov_desc kd;
    pd_multigrid_desc md;
    memset(r, 0, sizeof *r);
    memset(&kd, 0, sizeof kd);
    if (corrode->desc.activation)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "recede",
                        "the fluid is held under activation control, expected diffusion control");
    if (!(desc->share >= 0.0) || desc->share > 1.0 || !(desc->rtol >= 0.0) || !(desc->tolerance >= 0.0) ||
        !(desc->rtol < 1.0) || !(desc->tolerance < 1.0) || desc->max_newton < 0)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "recede",
                        "share %g, rtol %g, tolerance %g, max_newton %d, expected 0 to 1 and at least 0", desc->share,
                        desc->rtol, desc->tolerance, desc->max_newton);
    r->desc = *desc;
    if (!(r->desc.share > 0.0)) r->desc.share = 0.2;
    if (!(r->desc.rtol > 0.0)) r->desc.rtol = 1e-3;
    if (!(r->desc.tolerance > 0.0)) r->desc.tolerance = 1e-9;
    if (!r->desc.max_newton) r->desc.max_newton = 40;
    r->corrode = corrode;
    kd.method = PD_KRYLOV_CG;
    kd.n = corrode->grid->total;
    kd.zero_guess = 1;
    pdi_compact_multigrid(corrode->grid, &md);
    md.symmetric = 1;
    PDI_TRY(pdi_compact_build(ctx, corrode->grid, 0, &r->compact));
    PDI_TRY(pd_multigrid_build(ctx, &md, &r->mg));
    PDI_TRY(pd_krylov_build(ctx, &kd, &r->krylov));
    return pdi_recede_allocate(ctx, r);
}

pd_status pd_recede_build(pd_ctx *ctx, pd_corrode *corrode, const pd_recede_desc *desc, pd_recede *r)
{
    pd_status status = pdi_recede_make(ctx, corrode, desc, r);
    if (status < 0) pd_recede_free(ctx, r);
    return status;
}

void pd_recede_free(pd_ctx *ctx, pd_recede *r)
{
    int64_t total = r->corrode && r->corrode->grid ? r->corrode->grid->total : 0;
    pdi_compact_free(ctx, &r->compact);
    pd_multigrid_free(ctx, &r->mg);
    pd_krylov_free(ctx, &r->krylov);
    PDI_DELETE(ctx, total, r->start);
    PDI_DELETE(ctx, total, r->moved);
    PDI_DELETE(ctx, total, r->balance);
    PDI_DELETE(ctx, total, r->delta);
    PDI_DELETE(ctx, total, r->field);
    PDI_DELETE(ctx, total, r->drain);
    PDI_DELETE(ctx, total, r->full);
    PDI_DELETE(ctx, total, r->asked_c);
    PDI_DELETE(ctx, total, r->asked_need);
    PDI_DELETE(ctx, total, r->dry);
    PDI_DELETE(ctx, total, r->reach);
    PDI_DELETE(ctx, total, r->stock);
    PDI_DELETE(ctx, total, r->state);
    memset(r, 0, sizeof *r);
}
